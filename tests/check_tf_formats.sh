#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Transfer functions of other programs on the command line: what is written is read again, what cannot be read is refused by
# name. tests/test_tf_peers.c has the values.
. "$(dirname "$0")/lib.sh"
curves=$top/tests/tf/curves.vp.json maps=$top/tests/tf/curves.paraview.json shells=$top/refscenes/shells.tf.json
convert() { "$ISOSHADE" tf convert "$@"; }
"$ISOSHADE" make shells --size 16 --type uint8 -o shells.nrrd -q || exit 1

# ---- what is written is read again: nodes within 1/2048, bytes and their places within 2/255 --------------------------
while read -r suffix color opacity options; do
    expect "written_as_$suffix" 0 convert "$curves" --name 1 -o "one.$suffix" --json
    holds "read_again_from_$suffix" \
        "$(sed -n '/"written"/,/}/p' out | json_number /dev/stdin color) * 255 <= $color && $(sed -n '/"written"/,/}/p' out | json_number /dev/stdin opacity) * 255 <= $opacity"
    # And once more: a second conversion of what was written finds the same.
    [ "$suffix" = tf.json ] && continue
    check "$suffix converted_again" convert "one.$suffix" $options -o again.csv -q
done <<'END'
tf.json 0.001 0.001
csv 0.001 0.001
vp.json 0.3 0.1
paraview.json 0.3 0.1 --unit-distance 2.5
END
expect written_for_niivue 0 convert "$maps" --name rgb --unit-distance 1 -o one.niivue.json --json
holds read_again_from_niivue "$(sed -n '/"written"/,/}/p' out | json_number /dev/stdin color) * 255 <= 2.5"
check niivue_has_bytes python3 -c '
import json
m = json.load(open("one.niivue.json"))
assert all(isinstance(v, int) and 0 <= v <= 255 for k in "RGBAI" for v in m[k]) and m["I"][0] == 0 and m["I"][-1] == 255, m'
check written_as_a_picture convert "$curves" --name 1 -o ramp.png -q
check the_picture_is_the_ramp python3 -c '
import struct
png = open("ramp.png", "rb").read()
assert png[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">IIBB", png[16:26]) == (256, 16, 8, 6)'
expect losses_are_printed 0 convert "$maps" --name lab --unit-distance 1 -o lab.tf.json
grep -qE '^read: against the other program: color within 0\.[0-9]+/255, opacity within 0\.[0-9]+/255' out && ok the_loss_has_numbers || not_ok the_loss_has_numbers "$(cat out)"
# A curve that is much steeper than the table is fine says so.
printf '{"volumeProperties": [{"components": [{"scalarOpacity": {"points": [{"x": -4000, "y": 0.1}, {"x": 10, "y": 0.2},
 {"x": 10.3, "y": 0.9}, {"x": 4000, "y": 0.9}]}, "rgbTransferFunction": {"points": [{"x": 0, "color": [1, 1, 1]}]}}]}]}' >steep.vp.json
expect steep 0 convert steep.vp.json -o steep.tf.json
grep -q 'between two entries of the table' out && ok steepness_is_said || not_ok steepness_is_said "$(cat out)"
expect names_are_listed 0 "$ISOSHADE" tf names "$maps"
[ "$(cat out)" = "$(printf 'rgb\nhsv\nhsv, wrapped\nlab\nlab out of the gamut\ndiverging\ndiverging from gray\nstep\nciede2000')" ] && ok all_names || not_ok all_names "$(cat out)"
expect names_as_json 0 "$ISOSHADE" tf names "$maps" --json
check the_same_names python3 -c 'import json; assert json.load(open("out"))["names"][2:4] == ["hsv, wrapped", "lab"]'
# Names of a file reach a terminal without what would move its cursor.
python3 - "$maps" <<'PY'
import json, sys
maps = json.load(open(sys.argv[1]))[:2]
maps[0]["Name"] = "\x1b[31m\n\x7f"
json.dump(maps, open("escape.json", "w"))
PY
expect names_of_any_letters_are_listed 0 "$ISOSHADE" tf names escape.json
check without_control_characters test "$(cat out)" = "$(printf ' [31m  \nhsv')"

# ---- every command that takes a transfer function ----------------------------------------------------------------------
printf '0 0 0 0\n1 1 1 0.5\n' >gray.csv
printf '{"min": 0, "max": 255, "R": [0, 255], "G": [0, 200], "B": [0, 100], "A": [0, 128], "I": [0, 255]}' >map.json
sed 's/"shells.tf.json"/"map.json"/' "$top/refscenes/shells.scene.json" >map.scene.json
check a_scene_names_one "$ISOSHADE" render shells.nrrd --scene map.scene.json --size 16 -q -o x.exr
check tf_adapt_takes_one "$ISOSHADE" tf adapt shells.nrrd --tf gray.csv --unit-distance 2 --level 1 -o x.tf.json --always -q
check tf_show_takes_one "$ISOSHADE" tf show gray.csv --unit-distance 2 -o x.svg
check palette_takes_one "$ISOSHADE" palette shells.nrrd --tf map.json -q -o x.csv

# ---- what has to be said --------------------------------------------------------------------------------------------------
refuse several_components 2 'choose a component by --name: "1", "2"' convert "$curves" -o z.tf.json
refuse several_maps 2 '"lab", "lab out of the gamut", "diverging"' convert "$maps" -o z.tf.json
refuse no_such_map 2 'has no color map "lob"; choose one by --name: "rgb", "hsv"' convert "$maps" --name lob -o z.tf.json
refuse a_length_is_missing 2 'tf convert --unit-distance MM' convert "$maps" --name lab -o z.tf.json
refuse a_length_too_many 2 'are for 2.5 mm; --unit-distance cannot' convert "$curves" --name 1 --unit-distance 1 -o z.tf.json
printf '0 0 0\n1 1 1\n' >rgb.csv
refuse opacity_of_colors 2 'give them by tf convert --opacity' convert rgb.csv --unit-distance 1 -o z.tf.json
refuse opacity_too_many 2 'has opacities of its own' convert gray.csv --unit-distance 1 --opacity 1 -o z.tf.json
refuse a_range_for_values 2 'give --volume FILE or --range LO,HI' convert gray.csv --unit-distance 1 -o z.vp.json
check a_range_is_said convert gray.csv --unit-distance 1 --range -100,200 -o said.vp.json -q
check a_range_of_a_volume convert gray.csv --unit-distance 1 --volume shells.nrrd -o said.niivue.json -q
printf 'value,r_linear,g_linear,b_linear,extinction_per_mm\n0,0.1,0.5,0.7,0\n1e308,0.1,0.5,0.7,0.5\n' >huge.csv
refuse values_beyond_those_of_json 5 'values are 0 to 1e+308, must be -3.40282e+38 to 3.40282e+38' convert huge.csv -o z.tf.json
refuse range_backwards 2 '--range is "3,1"' convert gray.csv --unit-distance 1 --range 3,1 -o z.tf.json
refuse unit_in_words 2 '--unit-distance is "one"' convert gray.csv --unit-distance one -o z.tf.json
refuse opacity_above_1 2 '--opacity is "0,2"' convert rgb.csv --unit-distance 1 --opacity 0,2 -o z.tf.json
refuse ours_says_it_itself 2 '--unit-distance is for the formats of other programs' convert "$shells" --unit-distance 1 -o z.tf.json
refuse picture_is_not_read 4 'not JSON' convert ramp.png -o z.tf.json

# ---- what is in a file and not supported ------------------------------------------------------------------------------------
sed '0,/"y": 1}/s//"y": 0.5}/' "$curves" >gradient.vp.json
refuse gradient_opacity 4 'the gradient opacity is 0.5 at 0, only 1 is supported' convert gradient.vp.json --name 1 -o z.tf.json
sed 's/"shade": false/"transferFunction2D": {}/' "$curves" >two.vp.json
refuse tf_2d_of_slicer 4 '"transferFunction2D" is not supported' convert two.vp.json --name 2 -o z.tf.json
sed 's/"Diverging"/"Cubehelix"/' "$maps" >other.json
refuse unknown_space 4 '"Cubehelix", must be one of: RGB, HSV, Wrapped, Lab, Diverging, ProLab, Step, Lab/CIEDE2000' \
    convert other.json --name diverging --unit-distance 1 -o z.tf.json
printf '[{"Name": "c", "IndexedColors": [1, 0, 0]}]' >indexed.json
refuse categories 4 '"c" has colors of categories ("IndexedColors")' convert indexed.json --unit-distance 1 --opacity 1 -o z.tf.json
printf '[{"Name": "c", "ColorSpace": "RGB", "UseLogScale": 1, "RGBPoints": [1, 0, 0, 0, 2, 1, 1, 1]}]' >log.json
refuse logarithms 4 '"UseLogScale" is not supported' convert log.json --unit-distance 1 --opacity 1 -o z.tf.json
printf '{"R": [0, 1], "G": [0, 1], "B": [0, 1], "labels": ["a", "b"]}' >labels.json
refuse labels_of_niivue 4 'is a map of labels' convert labels.json -o z.tf.json
printf '<VoreenData><TransFuncIntensity><domain x="0" y="1"/><threshold x="0.2" y="1"/></TransFuncIntensity></VoreenData>' >cut.tfi
refuse threshold_of_voreen 4 'has a <threshold> of 0.2 to 1' convert cut.tfi -o z.tf.json
printf '<InviwoTreeData><maskMin content="0.1"/><maskMax content="1"/></InviwoTreeData>' >mask.itf
refuse mask_of_inviwo 4 'is masked to 0.1 to 1' convert mask.itf -o z.tf.json
printf 'value,r,g,b,gloss\n0,0,0,0,0\n1,1,1,1,1\n' >gloss.csv
refuse unknown_column 4 '"gloss", must be one of: value, r, g, b, opacity' convert gloss.csv --unit-distance 1 -o z.tf.json
sed 's/"points"/"size_of_table": 3, "points"/' "$shells" >key.tf.json
refuse unknown_key_lists_the_keys 4 'unknown key "size_of_table" in the transfer function, must be one of: schema, comment, range' convert key.tf.json -o z.tf.json

# ---- truncated and mislabeled files: one line, exit code 4 (or 5 for a value outside its limits) ---------------------------
printf '<?xml version="1.0" ?>\n<InviwoTreeData>\n<dataPoints><point><pos x="0" y="0"/><rgba x="0" y="0" z="0" w="0"/></point>
<point><pos x="1" y="0"/><rgba x="1" y="1" z="1" w="1"/></point></dataPoints></InviwoTreeData>\n' >a.itf
printf '<VoreenData><TransFuncIntensity><domain x="0" y="9"/><Keys><key><intensity value="0"/><split value="false"/><colorL r="0" g="0" b="0" a="0"/></key>
<key><intensity value="1"/><split value="false"/><colorL r="255" g="9" b="9" a="99"/></key></Keys></TransFuncIntensity></VoreenData>\n' >a.tfi
printf '<MRML><VolumeProperty name="a" scalarOpacity="4 0 0 9 1" colorTransfer="8 0 0 0 0 9 1 1 1"/></MRML>\n' >a.mrml
printf '<ColorMap name="a" space="RGB"><Point x="0" o="0" r="0" g="0" b="0"/><Point x="9" o="1" r="1" g="1" b="1"/></ColorMap>\n' >a.xml
printf '1\n1\n0.9\n0.1\n0.2\n10\n4 0 0 9 1\n4 0 1 9 1\n8 0 0 0 0 9 1 1 1\n' >a.vp
head -c 768 /dev/zero >a.lut
printf 'value,r,g,b,opacity\n0,0,0,0,0\n9,1,1,1,0.125\n' >a.csv
cp "$curves" a.vp.json && cp "$maps" a.paraview.json && cp map.json a.niivue.json && cp "$shells" a.tf.json
for suffix in itf tfi mrml xml vp lut csv vp.json paraview.json niivue.json tf.json; do
    options="--unit-distance 1"
    case $suffix in lut) options+=" --opacity 1" ;; vp.json) options="--name 2" ;; paraview.json) options+=" --name lab" ;; tf.json) options= ;; esac
    check "$suffix is_read" convert a.$suffix $options -o whole.tf.json -q
    size=$(stat -c %s a.$suffix) bad=
    for part in 0 1 $((size / 4)) $((size / 2)) $((size * 3 / 4)) $((size - 3)); do
        head -c $part a.$suffix >cut.$suffix
        convert cut.$suffix $options -o z.tf.json >out 2>err
        code=$?
        # Numbers of text may end anywhere and leave a shorter number, which says nothing.
        [ $code = 0 ] && [[ $suffix =~ ^(csv|vp)$ ]] && [ $part = $((size - 3)) ] && { rm -f z.tf.json; continue; }
        [[ $code =~ ^[245]$ ]] && [ "$(wc -l <err)" = 1 ] && grep -q "cut.$suffix" err && [ ! -e z.tf.json ] || bad+=" $part:$code:$(head -c 200 err)"
    done
    [ -z "$bad" ] && ok "${suffix}_cut_off_is_refused" || not_ok "${suffix}_cut_off_is_refused" "$bad"
    cp shells.nrrd wrong.$suffix
    convert wrong.$suffix $options -o z.tf.json >out 2>err
    code=$?
    [[ $code =~ ^[45]$ ]] && [ "$(wc -l <err)" = 1 ] && grep -q "wrong.$suffix" err && ok "${suffix}_that_is_a_volume" || not_ok "${suffix}_that_is_a_volume" "$code $(cat err)"
done
cp a.tfi other.itf
refuse voreen_named_inviwo 4 'other.itf: its content is a 1D transfer function of Voreen' convert other.itf --unit-distance 1 -o z.tf.json
cp a.vp.json other.csv
refuse slicer_named_csv 4 'other.csv: its content is a volume property of 3D Slicer' convert other.csv -o z.tf.json
cp map.json other.vp.json
check json_is_told_by_its_content convert other.vp.json -o whole.tf.json -q
[ ! -e z.tf.json ] && ok nothing_half_written || not_ok nothing_half_written "$(ls)"
# Settings that a file lacks are given in a scene, and to palette, as to tf convert.
"$ISOSHADE" make shells --size 12 -q -o open.nrrd
printf '0 0 0\n1 0.5 0\n1 1 1\n' >colors.csv
scene_with() { sed "s|\"tf\": \"shells.tf.json\"|\"tf\": $1|" "$top/refscenes/shells.scene.json" >open.scene.json; }
of_scene() { "$ISOSHADE" render open.nrrd --scene open.scene.json --size 24 -q -o "$1"; }
scene_with '{"file": "colors.csv", "unit_distance_mm": 2, "opacity": [0, 0.5], "range": "fit"}'
check a_scene_says_it of_scene said.exr
"$ISOSHADE" tf convert colors.csv --unit-distance 2 --opacity 0,0.5 --range fit -o colors.tf.json >/dev/null 2>&1
scene_with '"colors.tf.json"'
check as_convert_does of_scene converted.exr
check the_same_picture "$ISOSHADE" compare said.exr converted.exr --max-abs 2e-3
scene_with '{"file": "colors.csv", "unit_distance": 2, "opacity": [0, 0.5]}'
refuse a_scene_lists_the_keys 4 'must be one of: file, name, unit_distance_mm, opacity, range' of_scene no.exr
scene_with '{"file": "colors.csv", "opacity": [0, 0.5]}'
refuse a_scene_that_does_not 2 'does not state the length' of_scene no.exr
check palette_says_it "$ISOSHADE" palette open.nrrd --tf colors.csv --unit-distance 2 --opacity 0,0.5 --range fit --entries 4 -q -o p.csv
refuse palette_needs_it 2 'does not state the length' "$ISOSHADE" palette open.nrrd --tf colors.csv --opacity 0,0.5 --entries 4 -q -o q.csv
exit $failed
