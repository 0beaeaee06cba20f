#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Whole commands on good and bad input: exit code, one line on stderr, no half-written file.
. "$(dirname "$0")/lib.sh"
accept() { # name, words that stdout has to hold, command ...
    local name=$1 words=$2
    shift 2
    if ! "$ISOSHADE" "$@" >out 2>err; then not_ok "$name" "$(cat err)"
    elif ! grep -qF -- "$words" out; then not_ok "$name" "stdout lacks \"$words\""
    else ok "$name"; fi
}
header() { printf 'NRRD0004\ntype: %s\ndimension: 3\nsizes: %s\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n' "$1" "$2"; }

accept make_writes '"voxels": 73920' make marschner-lobb --size 40x56x33 --spacing 1x1x2.5 -o v.nrrd -q --json
accept info_shows_size 'size       40 x 56 x 33 = 73920 voxels of uint16' info v.nrrd
accept info_json '"world_is_ras": false' info v.nrrd --json
accept make_rotated '"output": "r.nrrd"' make sphere --size 20 --rotate 0,0,1,30 --type float --gzip -o r.nrrd -q --json
accept info_rotated 'x axis     0.866025, 0.5, 0' info r.nrrd
"$ISOSHADE" make noise --size 12 --type uint32 -o wide.nrrd -q
accept info_says_what_rounding_loses 'rounding   to float changes' info wide.nrrd
head -c 147840 /dev/zero >plain.raw
accept raw_options '40 x 56 x 33 = 73920 voxels of int16' info plain.raw --raw-size 40x56x33 --raw-type int16 --raw-spacing 1x1x2 --raw-big-endian

{ header uchar '2 2 2' | sed '$d'; printf 'scale_slope:=0.5\nscale_intercept:=-10\n\nABCDEFGH'; } >scaled.nrrd
accept a_scale_is_applied 'range      22.5 to 26' info scaled.nrrd
accept and_said 'value = 0.5 * stored + -10 (ignore it with --stored)' info scaled.nrrd
accept in_pyramids_too 'level 0  2 x 2 x 2  float  22.5 to 26' build scaled.nrrd --levels 1 -o scaled.iso -q
accept the_stored_values_are_there_too 'range      65 to 72' info scaled.nrrd --stored
accept what_was_left_out_is_said '(ignored: --stored)' info scaled.nrrd --stored

# Units: known ones are converted, others refused; --unit says another.
with_unit() { { header uchar '2 2 2' | sed '$d; /^spacings/d'; printf 'space dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,3)\nspace units: "%s" "%s" "%s"\n\nABCDEFGH' "$1" "$1" "$1"; } >unit.nrrd; }
while read -r unit spacing; do
    with_unit "$unit"
    accept "unit_$unit" "spacing    $spacing" info unit.nrrd
done <<'END'
angstrom 2 x 2 x 3 angstrom
nm 2 x 2 x 3 nm
microns 2 x 2 x 3 um
cm 20 x 20 x 30 mm
M 2000 x 2000 x 3000 mm
inch 50.8 x 50.8 x 76.2 mm
END
with_unit furlong
refuse a_unit_that_is_not_known 4 'unit.nrrd: unknown unit "furlong"; override it with --unit, one of m, cm' "$ISOSHADE" info unit.nrrd
accept unless_it_is_said 'spacing    2 x 2 x 3 um' info unit.nrrd --unit um
accept and_the_spacing_too 'spacing    4 x 5 x 6 um' info unit.nrrd --unit um --spacing 4x5x6
accept info_says_the_unit 'unit       um = 0.001 mm' info unit.nrrd --unit um
accept or_that_there_is_none 'unit       none in the file: mm' info scaled.nrrd
accept raw_files_have_units_too 'spacing    2 x 2 x 2 nm' info plain.raw --raw-size 40x56x33 --raw-type int16 --raw-spacing 2 --unit nm
refuse an_unknown_unit_of_the_option 2 '--unit is "furlong", must be m, cm' "$ISOSHADE" info unit.nrrd --unit furlong
refuse a_spacing_of_zero 2 '--spacing is 0' "$ISOSHADE" info unit.nrrd --unit um --spacing 0
header uchar '2 2 2' >short.nrrd; printf 1234567 >>short.nrrd
refuse truncated 4 'short.nrrd: truncated: holds 7 bytes of samples' "$ISOSHADE" info short.nrrd
head -c 60 v.nrrd >cut.nrrd
refuse cut_header 4 'cut.nrrd: ' "$ISOSHADE" info cut.nrrd
printf 'PNG or what' >magic.nrrd
refuse wrong_magic 4 'magic.nrrd: starts with "PNG or w"' "$ISOSHADE" info magic.nrrd
header uchar '5000000000 5000000000 5000000000' >huge.nrrd
refuse sizes_overflow 5 'huge.nrrd: sizes 5000000000' "$ISOSHADE" info huge.nrrd
header uchar '2 2 2' >long.nrrd; printf 123456789 >>long.nrrd
refuse sizes_do_not_match 4 'long.nrrd: too long: holds 9 bytes' "$ISOSHADE" info long.nrrd
header float '1 1 2' >nan.nrrd; printf '\0\0\0\0\0\0\300\177' >>nan.nrrd
accept nan_is_no_data 'no data    1 of 2 voxels' info nan.nrrd
refuse nan_voxel 5 'nan.nrrd: 1 of 2 voxels are NaN or infinite, none may be; the first is (0, 0, 1)' "$ISOSHADE" info nan.nrrd --no-data none
refuse no_bound 5 'nan.nrrd: some voxels have no data, for which there is no' "$ISOSHADE" tf bound nan.nrrd
refuse no_voxel 5 'nan.nrrd: none of its 2 voxels has data' "$ISOSHADE" info nan.nrrd --no-data 0
accept a_value_without_data 'no data    2 of 8 voxels' info scaled.nrrd --no-data 22.5,23
refuse a_rule_for_labels 2 'labels are integers' "$ISOSHADE" info plain.raw --raw-size 40x56x33 --raw-type int16 --labels --no-data 1
refuse an_unknown_rule 2 '--no-data is "2,1", must be a value' "$ISOSHADE" info nan.nrrd --no-data 2,1
header float '1 1 2' >inf.nrrd; printf '\0\0\200\377\0\0\0\0' >>inf.nrrd
refuse inf_voxel 5 'the first is (0, 0, 0)' "$ISOSHADE" info inf.nrrd
refuse missing_file 3 'absent.nrrd: cannot be opened' "$ISOSHADE" info absent.nrrd
mkdir empty
refuse an_empty_folder 4 'empty: a folder that holds no slices of a volume' "$ISOSHADE" info empty
refuse a_device 3 'is neither a regular file nor a folder' "$ISOSHADE" info /dev/null
refuse no_argument 2 'usage: isoshade info VOLUME' "$ISOSHADE" info
refuse an_empty_number 2 '--levels is empty, must be a number' "$ISOSHADE" build v.nrrd --levels '' -o x.iso
refuse an_empty_number_behind_an_equals_sign 2 '--gauss-sigma is empty' "$ISOSHADE" build v.nrrd --gauss-sigma= -o x.iso
refuse an_empty_number_of_every_command 2 '--threads is empty' "$ISOSHADE" info v.nrrd --threads ''
check options_stand_anywhere_in_any_environment env POSIXLY_CORRECT=1 "$ISOSHADE" make ramp --size 3 -q -o anywhere.nrrd
refuse unknown_option 2 '--sizes' "$ISOSHADE" make ramp --sizes 3 -o x.nrrd
refuse raw_half_given 2 'both --raw-size and --raw-type' "$ISOSHADE" info plain.raw --raw-size 3
refuse raw_wrong_size 4 'plain.raw: truncated: holds 147840 bytes' "$ISOSHADE" info plain.raw --raw-size 40x56x34 --raw-type int16
refuse raw_unknown_type 2 'uint8, int8, uint16' "$ISOSHADE" info plain.raw --raw-size 3 --raw-type float128
printf '\0\74\0\300' >half.raw # 1, -2
accept raw_halves 'range      -2 to 1' info half.raw --raw-size 2x1x1 --raw-type float16
printf '\376\377\377\377\377\377\377\377\7\0\0\0\0\0\0\0the end' >long.raw
accept raw_integers_of_64_bits 'voxels of int32' info long.raw --raw-size 2x1x1 --raw-type int64
accept with_their_values 'range      -2 to 7' info long.raw --raw-size 2x1x1 --raw-type int64
check a_trailer_is_left_out_with_a_warning grep -q 'long.raw: the 7 bytes after its samples are left out' err
gzip -k long.raw
accept packed_too 'range      -2 to 7' info long.raw.gz --raw-size 2x1x1 --raw-type int64
refuse a_plane_more_is_no_trailer 4 'too long' "$ISOSHADE" info long.raw --raw-size 1x1x2 --raw-type uint16
refuse raw_bad_spacing 2 '--raw-spacing is 0' "$ISOSHADE" info plain.raw --raw-size 3 --raw-type uint8 --raw-spacing 0
refuse make_unknown_kind 2 'unknown kind "blob"' "$ISOSHADE" make blob --size 3 -o x.nrrd
refuse make_zero_size 2 '--size is "0x3x3"' "$ISOSHADE" make ramp --size 0x3x3 -o x.nrrd
refuse make_bad_rotation 2 '--rotate is "1,2"' "$ISOSHADE" make ramp --size 3 --rotate 1,2 -o x.nrrd
refuse make_flat_matrix 5 'edge is 0 mm' "$ISOSHADE" make ramp --size 3 --rotate 1,0,0,1,0,0,0,0,1 -o x.nrrd
# What an option that is not given is held by is no value of it.
tf=$top/refscenes/shells.tf.json
refuse zoom_of_0 2 '--zoom is 0, must be 0.01 to 1000' "$ISOSHADE" scenes v.nrrd --zoom 0 -o x.png
refuse zoom_of_a_word 2 '--zoom is "near", must be a number' "$ISOSHADE" render v.nrrd --zoom near -o x.png
refuse export_step_of_0 2 '--step is 0, must be 0.001 to 16' "$ISOSHADE" export v.nrrd --to povray --step 0 -o x
refuse an_infinite_step 2 '--step is -inf, must be a finite number' "$ISOSHADE" render v.nrrd --step=-inf -o x.png
refuse an_infinite_limit 2 '--max-rmse is -inf, must be a finite number' "$ISOSHADE" compare a.exr b.exr --max-rmse=-inf
refuse an_infinite_time 2 '--timeout is -inf, must be a finite number' "$ISOSHADE" info v.nrrd --timeout -inf
refuse a_cache_of_0_bytes 2 '--cache-bytes is 0, must be 1 to 1e+15' "$ISOSHADE" render v.nrrd --with cpu --cache-bytes 0 -o x.png
# 0 is a value, not an option that is not given.
for option in "render --page-side" "render --intervals" "render --planes" "render --samples" "render --seeds" \
    "validate --levels" "validate --seeds" "validate --limit-size" "validate --level-views" "validate --level-size" \
    "scenes --size" "scenes --levels" "figure --levels" "figure --frames"; do
    name=${option//[ -]/_}
    refuse "${name}_of_0" 2 "${option#* } is 0, must be " "$ISOSHADE" ${option% *} v.nrrd "${option#* }" 0 -o x.png
done
refuse page_side_of_0_in_one_word 2 '--page-side is 0, must be' "$ISOSHADE" render v.nrrd --page-side=0 -o x.png
refuse plan_memory_of_0 2 '--memory is 0, must be 1 to 1e+15' "$ISOSHADE" plan v.nrrd --memory 0
refuse plan_brick_of_nothing 2 '--brick is -1, must be 2 to 64' "$ISOSHADE" plan v.nrrd --brick -1
refuse render_brick_of_nothing 2 '--brick is -1, must be 2 to 64' \
    "$ISOSHADE" render v.nrrd --plan-error 1/255 --brick -1 -o x.png
refuse a_series_of_one_volume 2 'v.nrrd: is one volume, --series junk' "$ISOSHADE" info v.nrrd --series junk
refuse a_series_of_a_raw_file 2 'a raw file is one volume' \
    "$ISOSHADE" info plain.raw --raw-size 40x56x33 --raw-type int16 --series 1
refuse a_pyramid_is_no_volume_of_tf 2 '--volume is scaled.iso, a pyramid' \
    "$ISOSHADE" tf show "$tf" --volume scaled.iso -o x.png
refuse nor_of_tf_convert 2 '--volume is scaled.iso, a pyramid' \
    "$ISOSHADE" tf convert "$tf" --volume scaled.iso -o x.vp.json
refuse make_no_folder 3 'the folder nowhere does not exist' "$ISOSHADE" make ramp --size 3 -o nowhere/x.nrrd
refuse make_on_a_folder 3 'is a directory' "$ISOSHADE" make ramp --size 3 -o .
# A disk that fills up: /dev/full cannot be renamed over, so a size limit stands in for it.
(ulimit -f 8; trap '' XFSZ; "$ISOSHADE" make noise --size 64 -o full.nrrd -q 2>err; echo $? >code)
if [ "$(cat code)" = 3 ] && [ "$(wc -l <err)" = 1 ] && [ ! -e full.nrrd ]; then ok output_that_does_not_fit
else not_ok output_that_does_not_fit "exit code $(cat code): $(cat err)"; fi
(ulimit -f 100; trap '' XFSZ; "$ISOSHADE" build v.nrrd -o full.iso -q >out 2>err; echo $? >code)
if [ "$(cat code)" = 3 ] && [ "$(wc -l <err)" = 1 ] && [ ! -e full.iso ] && grep -q ': full.iso/level_0' err; then ok a_pyramid_that_does_not_fit_is_named_as_the_user_did
else not_ok a_pyramid_that_does_not_fit_is_named_as_the_user_did "exit code $(cat code): $(cat err)"; fi
"$ISOSHADE" build v.nrrd -o v.iso -q --levels 2 >out
for to in povray vdb; do
    scene="--scene $top/refscenes/marschner-lobb.scene.json"
    [ $to = vdb ] && scene=
    (ulimit -f 8; trap '' XFSZ; "$ISOSHADE" export v.iso --to $to $scene -o full.$to -q >out 2>err; echo $? >code)
    if [ "$(cat code)" -ge 3 ] && grep -q "full.$to" err && [ ! -e full.$to ] && ! grep -q '/\.[0-9]*-' err; then ok "an_export_to_${to}_that_does_not_fit_names_no_temporary"
    else not_ok an_export_to_${to}_that_does_not_fit_names_no_temporary "exit code $(cat code): $(cat err)"; fi
done
left=$(find . -name '.*nrrd' -o -name 'x.nrrd')
[ -z "$left" ] && ok nothing_half_written || not_ok nothing_half_written "$left"
# 2048 x 2048 x 48 of uint16 are 384 MiB; made slab by slab they pass through less address space than that.
if (ulimit -v 390000; OMP_NUM_THREADS=2 "$ISOSHADE" make constant --size 2048x2048x48 -o big.nrrd -q); then ok make_streams
else not_ok make_streams "did not fit in 390 MB of address space"; fi
exit $failed
