#!/bin/bash
# SPDX-License-Identifier: MIT
# A volume alone is enough for a picture, an export and a report; wrong options are reported before any work.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 24 -q -o v.nrrd
"$ISOSHADE" make vessels --size 40 -q -o vessels.nrrd

# The colors of a picture: one is a picture of nothing.
colors() { "$python" -c 'import re, sys, zlib
b = open(sys.argv[1], "rb").read()
data = b"".join(b[m.end() : m.end() + int.from_bytes(b[m.start() - 4 : m.start()], "big")] for m in re.finditer(b"IDAT", b))
print(len(set(zlib.decompress(data))))' "$1" 2>/dev/null; }
python=$(command -v python3)

for volume in v vessels; do
    expect "${volume}_alone_is_a_picture" 0 "$ISOSHADE" render $volume.nrrd --size 64 -o $volume.png
    check "${volume}_shows_something" test "$(colors $volume.png)" -gt 20
    check "${volume}_without_warning" test -z "$(grep warning: err)"
done
# No other format is written under its name.
for name in x.gif x.jpg x same.exr.txt; do
    refuse "no_picture_is_called_$name" 2 'must end with .exr or .png' "$ISOSHADE" render v.nrrd --size 16 -o $name
done
"$ISOSHADE" build v.nrrd --levels 1 -q -o v.iso >/dev/null
refuse nor_is_one_in_pages 2 'must end with .exr or .png' "$ISOSHADE" render v.iso --size 16 --with cpu --memory 64 -o x.tiff
expect letters_may_be_large 0 "$ISOSHADE" render v.nrrd --size 16 -o LARGE.PNG
check and_say_the_same grep -qa PNG <(head -c 8 LARGE.PNG)
expect views_and_zoom 0 "$ISOSHADE" render v.nrrd --size 32 --tf simulation --view 30,20 --zoom 2 -o zoomed.png
expect named_view 0 "$ISOSHADE" render v.nrrd --size 32 --view top -o top.png
check views_differ test "$(cksum <zoomed.png)" != "$(cksum <top.png)"
expect over_a_scene 0 "$ISOSHADE" render v.nrrd --scene "$top/refscenes/shells.scene.json" --view top --size 32 -o over.png
expect exported_to_povray 0 "$ISOSHADE" export v.nrrd --to povray --size 32 -o pov
expect planned 0 "$ISOSHADE" plan v.nrrd --size 32 --brick 8 --levels 2 --error 1/255 -q
expect validated 0 "$ISOSHADE" validate v.nrrd --quick --levels 1 --size 24 --with gl -q -o report
check the_scene_stands_beside test -s report.scene.json
again() { "$ISOSHADE" validate v.nrrd --quick --levels 1 --size 16 --limit-size 8 --with cpu -q -o again; }
expect a_report_with_a_scene 0 again
expect replaces_the_scene_that_it_wrote 0 again
sed -i 's/"width": 16/"width": 17/' again.scene.json && cp again.scene.json mine.scene.json
refuse but_not_one_that_was_changed 3 'again.scene.json: was changed since' again
check which_stays cmp again.scene.json mine.scene.json
cp "$top/refscenes/shells.scene.json" again.scene.json
refuse nor_one_of_a_person 3 'again.scene.json: was changed since' again
expect the_scene_is_the_same 0 "$ISOSHADE" render v.nrrd --scene report.scene.json -q -o same.exr
expect as_without 0 "$ISOSHADE" render v.nrrd --size 24 -q -o first.exr
expect the_same_picture 0 "$ISOSHADE" compare first.exr same.exr --max-abs 1e-5 # the file has nine digits

expect suggested 0 "$ISOSHADE" tf suggest vessels.nrrd -q -o first.tf.json
check at_most_eight_points test "$(grep -c '"value"' first.tf.json)" -le 8
expect again_with_threads 0 "$ISOSHADE" tf suggest vessels.nrrd -q --threads 3 -o again.tf.json
check the_same_file cmp -s first.tf.json again.tf.json
expect suggested_is_read 0 "$ISOSHADE" render vessels.nrrd --tf first.tf.json --size 32 -q -o read.png
for preset in $("$ISOSHADE" list | sed -n '/^transfer function presets:/,/^$/p' | awk '/^  / {print $1}'); do
    expect "preset_$preset" 0 "$ISOSHADE" tf suggest v.nrrd --tf "$preset" -q -o "$preset.tf.json"
done

# refuse NAME WORDS COMMAND: a volume that is not there shows that nothing was read before
refuse() {
    expect "$1" 2 "${@:3}"
    check "$1_is_said" grep -qF -- "$2" err
}
refuse unknown_preset 'unknown transfer function preset "bone", must be one of: auto, ct-bone' "$ISOSHADE" render nothing.nrrd --tf bone -o x.png
refuse unknown_view '--view is "frnt", must be iso, front' "$ISOSHADE" export nothing.nrrd --to blender --view frnt -o x.blend
refuse zoom_of_nothing '--zoom is -1, must be 0.01 to 1000' "$ISOSHADE" render nothing.nrrd --zoom -1 -o x.png
refuse zoom_of_0 '--zoom is 0, must be 0.01 to 1000' "$ISOSHADE" render nothing.nrrd --zoom 0 -o x.png
refuse zoom_of_0_of_a_figure '--zoom is 0, must be 0.01 to 1000' "$ISOSHADE" figure nothing.nrrd --zoom 0 -o x
refuse bad_size '--size is "big"' "$ISOSHADE" validate nothing.nrrd --size big -o x
refuse view_for_grids '--view cannot be used with --to vdb' "$ISOSHADE" export nothing.nrrd --to vdb --view top -o x.vdb
refuse bad_error '--error is "1/0"' "$ISOSHADE" plan nothing.nrrd --error 1/0
refuse range_of_a_preset '--range needs a file as --tf, not the preset ct-bone' "$ISOSHADE" render nothing.nrrd --tf ct-bone --range 0,1 -o x.png
refuse range_of_nothing '--range needs a file as --tf' "$ISOSHADE" plan nothing.nrrd --range 0,1
refuse bad_unit_distance '--unit-distance is "x"' "$ISOSHADE" chart nothing.nrrd --tf $top/refscenes/shells.tf.json --unit-distance x -o x
# What a picture shows is asked for alike everywhere, in the same words, and checked before the volume is read.
looks="render -o x.png/export --to blender -o x.blend/validate -o x/plan/chart -o x/tf bound/tf adapt -o x/scenes -o x.png"
looks+="/lab plan/lab convergence/lab palette/lab encode"
IFS=/
for command in $looks; do
    IFS=' '
    set -- $command
    first=$1 && shift
    program=$ISOSHADE
    case $first in
        tf) first="$first $1" && shift ;;
        lab) program=$LAB first=$1 && shift ;;
    esac
    for wrong in "3 --scene missing.scene.json" "2 --tf bone" "2 --view frnt" "2 --size big" "2 --zoom -1"; do
        set -- $wrong "$@"
        code=$1 option=$2 value=$3 && shift 3
        expect "${program##*/}_${first// /_}${option/--/_}_first" $code "$program" $first nothing.nrrd $option $value "$@"
        check "${program##*/}_${first// /_}${option/--/_}_said" grep -q -- "$option\|$value" err
    done
    "$program" $first --help=all >>help.txt
done
IFS=$' \t\n'
# What --help says of an option, each command's in a line.
words_of() { awk -v option="--$1=" '/^  *-/ || /^$/ { if (text) print text; text = "" } index($1, option) == 1 || text { $1 = $1; text = text " " $0 }' help.txt; }
for option in scene zoom name unit-distance opacity; do
    check "${option}_in_the_same_words" test "$(words_of "$option" | sort -u | wc -l)" = 1
done
for command in "build --for first" "palette -o p.csv"; do
    set -- $command
    expect "${1}_${2#--}_tf_first" 2 "$ISOSHADE" $1 nothing.nrrd --tf bone "${@:2}"
    check "${1}_${2#--}_tf_said" grep -q 'unknown transfer function preset "bone"' err
done
expect levels_for_a_first_picture 0 "$ISOSHADE" build v.nrrd --for first --tf simulation --effort none --levels 2 -q -o for.iso
check whose_pyramid_says_so grep -q '"scene": "first"' for.iso/pyramid.json
expect palette_of_a_preset 0 "$ISOSHADE" palette v.nrrd --tf auto --entries 8 -q -o p.csv
expect chart_of_a_first_picture 0 "$ISOSHADE" chart v.nrrd --tf simulation --view top --zoom 1.5 --size 16 --levels 1 --with gl --codes fit --steps 1 --want 1 --budget 0 -q -o chart
line=$(sed -n 's/^ *isoshade render v.nrrd --tf simulation --view top --size 16 --zoom 1.5 /&/p' out | head -n 1)
check its_command_has_the_options test -n "$line"
echo '{"schema": "isoshade.scene/1", "camra": {}}' >key.scene.json
expect an_unknown_key 4 "$ISOSHADE" render nothing.nrrd --scene key.scene.json -o x.png
check it_lists_the_keys grep -q 'unknown key "camra" in the scene, must be one of: schema, comment, image, camera' err

# --progressive: pictures under one name, each put in its place by a rename, the last one that without it.
cat >count_pictures.py <<'EOF'
import ctypes, os, struct, subprocess, sys
# Prints how often a file of the folder was replaced whole, and how often it was written in place, while a command ran.
replaced, written = 0x80, 0x8
libc = ctypes.CDLL(None)
watch = libc.inotify_init1(os.O_NONBLOCK)
libc.inotify_add_watch(watch, b".", replaced | written)
code = subprocess.run(sys.argv[2:]).returncode
counts, data = {replaced: 0, written: 0}, b""
try:
    while True:
        data += os.read(watch, 65536)
except BlockingIOError:
    pass
while data:
    _, mask, _, length = struct.unpack_from("iIII", data)
    if data[16:16 + length].rstrip(b"\0").decode() == sys.argv[1]:
        for event in counts:
            counts[event] += bool(mask & event)
    data = data[16 + length:]
print(counts[replaced], counts[written])
sys.exit(code)
EOF
"$ISOSHADE" build v.nrrd -o v.iso --levels 2 -q
for input in v.nrrd v.iso; do
    "$ISOSHADE" render $input --size 61x43 -q -o plain.png
    expect "progressive_pictures_of_$input" 0 python3 count_pictures.py more.png "$ISOSHADE" render $input --size 61x43 --progressive -q -o more.png
    check "four_of_$input,_each_whole" test "$(tail -n 1 out)" = "4 0"
    check "the_last_one_of_${input}_is_the_plain_one" cmp plain.png more.png
done
expect one_picture_without_it 0 python3 count_pictures.py plain.png "$ISOSHADE" render v.nrrd --size 61x43 -q -o plain.png
check is_one test "$(tail -n 1 out)" = "1 0"
expect progressive_frames 2 "$ISOSHADE" render v.nrrd --progressive --limit -o x.png
exit $failed
