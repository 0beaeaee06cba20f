#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Levels that are made for a scene: built, described, verified, validated; and what is refused.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene=$top/refscenes/marschner-lobb.scene.json
"$ISOSHADE" make marschner-lobb --size 33x28x31 --spacing 1x1x1.5 -q -o v.nrrd
"$ISOSHADE" build v.nrrd -q --levels 3 -o plain.iso >/dev/null

expect levels_are_made_for_a_scene 0 "$ISOSHADE" build v.nrrd --for "$scene" --levels 3 -o v.iso
check each_level_says_what_was_chosen_and_why grep -q '^level 1: [a-z-]*.*, 1 - SSIM [0-9.]* (' out
expect as_data 0 "$ISOSHADE" build v.nrrd --for "$scene" --levels 3 --threads 1 -o w.iso --json
has_keys data out made_for candidates ssim_dissimilarity rmse adapted_tf seconds_of_levels
check threads_change_no_byte diff -r v.iso w.iso

expect a_pyramid_says_what_it_was_made_for 0 "$ISOSHADE" info v.iso
check with_the_scene_and_each_level grep -q "made for   ${scene##*/}: level 1 least-squares, level 2" out
expect it_is_verified 0 "$ISOSHADE" info v.iso --verify
check with_all_levels test "$(grep -c 'voxels are made from level 0' out)" = 3
cp -r v.iso bad.iso
"$python" "$top/tests/swap_levels.py" plain.iso bad.iso scalar:1
expect a_plain_level_in_its_place_is_found 1 "$ISOSHADE" info bad.iso --verify
check by_level_and_values grep -q 'level 1: .* by its values' err
expect a_validation_finds_it_too 1 "$ISOSHADE" validate bad.iso --scene "$scene" --quick --with gl --size 24 -q -o bad
expect it_validates 0 "$ISOSHADE" validate v.iso --scene "$scene" --quick --with gl,povray --size 24 -q -o report
expect it_is_exported_as_any_pyramid 0 "$ISOSHADE" export v.iso --to povray --scene "$scene" --level 1 -o pov -q

refuse a_pyramid_is_no_volume 2 "v.iso: a pyramid" "$ISOSHADE" build v.iso --for "$scene" -o x.iso
refuse too_little_memory_is_said_with_what_is_needed 6 "MB, --memory is 0.5" \
    "$ISOSHADE" build v.nrrd --for "$scene" --memory 0.5 -o x.iso
refuse no_resuming 2 "levels for a scene are made at once" "$ISOSHADE" build v.nrrd --for "$scene" --resume -o x.iso
python3 - "$scene" <<'PY'
import json, sys
scene = json.load(open(sys.argv[1]))
del scene["tf"]
json.dump(scene, open("bare.scene.json", "w"))
PY
refuse a_scene_without_a_transfer_function 4 '"tf": is missing' "$ISOSHADE" build v.nrrd --for bare.scene.json -o x.iso
refuse no_scene_at_all 3 "nowhere.scene.json" "$ISOSHADE" build v.nrrd --for nowhere.scene.json -o x.iso
check nothing_is_left test ! -e x.iso
exit $failed
