#!/bin/bash
# SPDX-License-Identifier: MIT
# A contact sheet: each picture is what its command makes, pixel by pixel; an empty picture is left out with the reason.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 20x24x18 --type uint8 -q -o "a volume.nrrd"
far=far.tf.json # beyond the volume's values
cat >$far <<END
{"schema": "isoshade.tf/1", "range": [5000, 6000], "unit_distance_mm": 1, "color_space": "linear", "table_size": 64,
 "points": [{"value": 5000, "r": 1, "g": 1, "b": 1, "opacity": 0}, {"value": 6000, "r": 1, "g": 1, "b": 1, "opacity": 1}]}
END
cp "$top/refscenes/shells.tf.json" own.tf.json

expect it_draws 0 "$ISOSHADE" scenes "a volume.nrrd" --tf auto --tf own.tf.json --tf $far --view front --view 30,20 --size 48 -q -o sheet.png
has_files left . sheet.png sheet.json
check two_presets_from_two_sides test "$(grep -c '^ *[0-9]*  isoshade render ' out)" = 4
check what_shows_nothing_is_left_out grep -q 'left out: far.tf.json: 0 % of the voxels can be seen' out
run_line() { # of the printed commands, with this program
    local line
    line=$(sed -n "s/^ *$1  isoshade //p" out)
    eval "\"$ISOSHADE\" ${line% -o *} -q -o \"panel$1.png\""
}
for i in 1 4; do
    check "command_${i}_runs" run_line $i
    check "picture_${i}_is_its_commands" python3 "$top/tests/sheet_panel.py" sheet.json $i "panel$i.png"
done
notice another_picture_is_noticed python3 "$top/tests/sheet_panel.py" sheet.json 2 panel1.png
expect as_json 0 "$ISOSHADE" scenes "a volume.nrrd" --tf auto --view top --size 32 -q --json -o one.svg
has_keys json out sheet pictures left_out number command left top size
check it_is_what_is_beside cmp -s out one.json

expect with_a_scene 0 "$ISOSHADE" scenes "a volume.nrrd" --scene "$top/refscenes/shells.scene.json" --tf own.tf.json --zoom 1.4 --size 48 -q -o sheet.png
check its_own_view_and_the_others test "$(grep -c "^ *[0-9]*  isoshade render .*--scene .*--zoom 1.4" out)" = 5
check command_of_the_scene_runs run_line 1
check picture_of_the_scene_is_its_commands python3 "$top/tests/sheet_panel.py" sheet.json 1 panel1.png
refuse all_empty 5 'none of the transfer functions shows anything' "$ISOSHADE" scenes "a volume.nrrd" --tf $far --size 32 -q -o no.png
refuse an_unknown_preset 2 'must be' "$ISOSHADE" scenes "a volume.nrrd" --tf bones --size 32 -q -o no.png
refuse an_unknown_view 2 'bottomless' "$ISOSHADE" scenes "a volume.nrrd" --view bottomless --size 32 -q -o no.png
refuse another_ending 2 'must end in .png' "$ISOSHADE" scenes "a volume.nrrd" -q -o no.jpg
refuse too_many_views 2 'at most 32' "$ISOSHADE" scenes "a volume.nrrd" $(printf -- '--view 0,%d ' $(seq 33)) -q -o no.png
refuse too_small 2 '--size' "$ISOSHADE" scenes "a volume.nrrd" --size 8 -q -o no.png
exit $failed
