#!/bin/bash
# SPDX-License-Identifier: MIT
# Pictures of nothing: each kind has one line that says what is wrong and what to do, and validate refuses them.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 24 -q -o v.nrrd
cp "$top"/refscenes/shells.tf.json "$top"/refscenes/ct-bone.tf.json .
scene="$top/refscenes/shells.scene.json"
# A head CT's scene on values of 0 to 1.
"$ISOSHADE" make shells --size 24 --type float -q -o unit.nrrd
cp "$top/refscenes/ct-bone.scene.json" bone.scene.json
with_camera() { sed "s|\"camera\": {[^}]*}|\"camera\": {\"projection\": \"perspective\", $1}|" "$scene"; }
with_camera '"position": [0, -100, 0], "look_at": [0, -200, 0], "up": [0, 0, 1], "fov_y_deg": 30' >away.scene.json
full='{"value": 0, "r": 0, "g": 0, "b": 0, "opacity": 0.9}, {"value": 1, "r": 0, "g": 0, "b": 0, "opacity": 0.9}'
inline() { sed "s|\"tf\": \"shells.tf.json\"|\"tf\": {\"schema\": \"isoshade.tf/1\", \"range\": \"fit\", \"unit_distance_mm\": 1, \"color_space\": \"linear\", \"table_size\": 2, \"points\": [$1]}|; s|\"background\": [^]]*\]|\"background\": [0, 0, 0]|" "$scene"; }
inline "$full" >box.scene.json
inline "${full/0.9/0}" >black.scene.json

# warns NAME WORDS COMMAND: it succeeds, with one warning on stderr that holds the words
warns() {
    local name=$1 words=$2
    shift 2
    expect "$name" 0 "$@"
    check "${name}_in_one_line" test "$(grep -c 'warning:' err)" = 1
    check "${name}_is_said" grep -qF -- "$words" err
}
# silent NAME COMMAND
silent() {
    expect "$1" 0 "${@:2}"
    check "$1_without_warning" test -z "$(grep warning: err)"
}
render() { "$ISOSHADE" render "$1" --scene "$2" --size 32 -q -o out.exr "${@:3}"; }
silent a_scene_that_shows_something render v.nrrd "$scene"
warns values_outside_the_transfer_function "isoshade render: warning: 0 % of the voxels can be seen" render unit.nrrd bone.scene.json
check it_says_both_ranges grep -q "(its range: -1024 to 3071), the volume's values are 0 to" err
warns a_camera_that_looks_away "the camera looks past the volume" render v.nrrd away.scene.json
warns a_box "the picture is of a box: 100 % of its faces hide" render v.nrrd box.scene.json
warns black_on_black "has the background's color" render v.nrrd black.scene.json
warns an_isosurface_that_is_nowhere "the isosurface of 99999 is nowhere" render v.nrrd "$scene" --isosurface 99999
warns one_pixel "of the picture of 1 x 1 pixels" "$ISOSHADE" render v.nrrd --scene "$scene" --size 1 -q -o out.exr
check it_is_still_written test -s out.exr
expect as_json 0 render v.nrrd "$scene" --json
has_keys json out visible voxels faces picture

warns export_says_it "isoshade export: warning: 0 % of the voxels can be seen" "$ISOSHADE" export unit.nrrd --to povray --scene bone.scene.json -q -o pov
silent grids_alone_have_no_scene "$ISOSHADE" export unit.nrrd --to vdb -q -o a.vdb
warns build_for_says_it "isoshade build: warning: 0 % of the voxels can be seen" "$ISOSHADE" build unit.nrrd --for bone.scene.json --levels 2 -q -o for.iso

# Values far outside: of a plan, of a chart and of a bound, as of a picture.
warns plan_says_it "isoshade plan: warning: 0 % of the voxels can be seen" "$ISOSHADE" plan unit.nrrd --scene bone.scene.json --size 16 --brick 8 --levels 2 -q
warns chart_says_it "isoshade chart: warning: 0 % of the voxels can be seen" "$ISOSHADE" chart unit.nrrd --scene bone.scene.json --size 16 --levels 1 --with gl --steps 1 --codes fit --budget 0 -q -o chart
warns bound_says_it "isoshade tf: warning: 0 % of the voxels can be seen" "$ISOSHADE" tf bound unit.nrrd --scene bone.scene.json --size 16 --level 1 -q

validate() { "$ISOSHADE" validate "$1" --scene "$2" --quick --levels 1 --size 24 --with gl -q -o report; }
refuse validate_refuses_it 5 "0 % of the voxels can be seen" validate unit.nrrd bone.scene.json
refuse validate_refuses_a_box 5 "the picture is of a box" validate v.nrrd box.scene.json
refuse validate_refuses_another_view 5 "the camera looks past the volume" validate v.nrrd away.scene.json
"$ISOSHADE" validate v.nrrd --scene away.scene.json --anyway --quick --levels 1 --size 16 --with gl -q -o report >out 2>err
check anyway_it_is_validated test -s report/report.json
check and_warned_of grep -q "isoshade validate: warning: the camera looks past" err
# As in a report of an older version, without a warning.
warns a_figure_of_nothing "pictures show the volume on less than .1 %" "$ISOSHADE" figure report --kind renderers -q -o figure
exit $failed
