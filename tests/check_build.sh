#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command build: files, JSON, default name, messages and exit codes, and nothing half-written.
. "$(dirname "$0")/lib.sh"
nothing_left() { [ -z "$(ls -A | grep -E '^\..*iso|no\.iso')" ]; }

"$ISOSHADE" make marschner-lobb --size 21x16x9 --spacing 1x1x2.5 --rotate 1,2,3,40 -o v.nrrd -q || exit 1
expect a_volume_is_built 0 "$ISOSHADE" build v.nrrd --levels 3 --keep-float --keep-magnitude --json
has_keys json_has out schema command options output seconds levels
check the_default_name_follows_the_input test -f v.iso/pyramid.json
has_files has v.iso level_0.nrrd level_1_dir.nrrd level_2_grad.nrrd level_2_mag.nrrd
expect levels_are_plain_nrrd 0 "$ISOSHADE" info v.iso/level_1.nrrd --json
check with_half_the_size grep -Pzq '"size": \[\s*11,\s*8,\s*5\s*\]' out
spacing_is() { python3 -c 'import json, sys
sys.exit(any(abs(a - float(b)) > 1e-12 for a, b in zip(json.load(open("out"))["spacing_mm"], sys.argv[1:])))' "$@"; } # lengths of turned axes are rounded
check and_twice_the_spacing spacing_is 2 2 5
notice another_spacing_is_found spacing_is 2 2 5.000001
expect the_finest_level_keeps_the_type 0 "$ISOSHADE" info v.iso/level_0.nrrd --json
check as_uint16 grep -q '"type": "uint16"' out
expect another_build_replaces_it 0 "$ISOSHADE" build v.nrrd -o v.iso --levels 2 --code region48 --direction-filter eq1
check and_keeps_nothing_of_it test ! -e v.iso/level_2.nrrd
tail -c 6048 v.nrrd >v.raw
expect a_raw_volume_is_built 0 "$ISOSHADE" build v.raw --raw-size 21x16x9 --raw-type uint16 -o raw.iso

expect a_missing_volume_is_named 3 "$ISOSHADE" build none.nrrd -o no.iso
check by_its_name grep -q none.nrrd err
head -c 3000 v.nrrd >short.nrrd
expect a_truncated_volume_is_refused 4 "$ISOSHADE" build short.nrrd -o no.iso
printf '\x00\x00\x80\x7f\x00\x00\x80\x3f' >infinite.raw
expect voxels_that_are_not_finite_are_refused 5 "$ISOSHADE" build infinite.raw --raw-size 2x1x1 --raw-type float -o no.iso
expect an_unknown_filter_is_refused 2 "$ISOSHADE" build v.nrrd --direction-filter median -o no.iso
check with_the_list grep -q 'moments' err
expect zero_levels_are_refused 2 "$ISOSHADE" build v.nrrd --levels 0 -o no.iso
expect a_sigma_that_is_nan_is_refused 2 "$ISOSHADE" build v.nrrd --gauss-sigma nan -o no.iso
mkdir mine && touch mine/file
expect a_foreign_folder_is_not_replaced 3 "$ISOSHADE" build v.nrrd -o mine
check and_keeps_its_files test -e mine/file
expect a_folder_that_is_missing_is_an_error 3 "$ISOSHADE" build v.nrrd -o none/no.iso
check nothing_half_written_is_left nothing_left
expect help_is_not_an_error 0 "$ISOSHADE" build --help
exit $failed
