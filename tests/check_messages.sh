#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Words of messages: no name of a macro, plurals that are ones, and each error under the name of the file that it is about.
. "$(dirname "$0")/lib.sh"

# Strings of the source that hold a macro's name, such as one that was renamed with a search for its value. Shaders have
# macros of their own; variables of the environment are for people.
no_macro_in() {
    python3 - "$@" <<'END'
import os, re, sys
bad = 0
for top in sys.argv[1:]:
    for folder, _, names in os.walk(top):
        for name in names:
            if not name.endswith((".c", ".h", ".cpp")) or folder.endswith(("/gl", "/lab")):
                continue
            path = os.path.join(folder, name)
            for number, line in enumerate(open(path, errors="replace"), 1):
                if line.lstrip().startswith(("#", "*", "/*")):
                    continue
                for text in re.findall(r'"((?:[^"\\]|\\.)*)"', line):
                    if re.search(r"\bISO_(?!DECODER_)[A-Z0-9_]+\b", text):
                        print(f"{path}:{number}: \"{text}\"", file=sys.stderr)
                        bad = 1
sys.exit(bad)
END
}
check no_message_holds_a_macro no_macro_in "$top/src" "$top/exporters"
mkdir planted && printf 'static const char why[] = "sampled at 32 x 32 ISO_CALIBRATION_PIXELS; half a voxel";\n' >planted/x.c
notice one_that_does no_macro_in planted

"$ISOSHADE" list >list.txt
check a_device_has_its_plural grep -qi '^\(# *\)*devices of cycles' list.txt
no_bad_plural() { ! grep -nE '^[a-zA-Z -]+(sss?|[^aeiou]ys|chs|shs|xs):$|^[a-z -]+ of [A-Za-z]+ss' "$1" | grep -vE 'classes|biases'; }
"$ISOSHADE" list --markdown | sed -n 's/^## \(.*\)$/\1:/p' >plurals.txt
check plurals_are_ones no_bad_plural plurals.txt
echo 'device of Cycless:' >bad.txt
notice one_that_is_none no_bad_plural bad.txt

"$ISOSHADE" make shells --size 12x11x10 -o v.nrrd -q
cp "$top/refscenes/shells.tf.json" .
python3 - "$top/refscenes/shells.scene.json" <<'END'
import json, sys
scene = json.load(open(sys.argv[1]))
lost = {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "linear", "table_size": 2,
        "points": [{"value": v, "r": 1, "g": 1, "b": 1, "opacity": o} for v, o in ((.4, 0), (.5, .9), (.6, 0))]}
json.dump(lost, open("lost.tf.json", "w"))
scene["tf"] = "shells.tf.json"
json.dump(scene, open("good.scene.json", "w"))
scene["tf"] = "lost.tf.json"
json.dump(scene, open("names.scene.json", "w"))
scene["tf"] = lost
json.dump(scene, open("holds.scene.json", "w"))
END
lost="the transfer function's point at 0.5"
refuse a_tf_that_was_given_is_named 5 "lost.tf.json: $lost" "$ISOSHADE" render v.nrrd --scene good.scene.json --tf lost.tf.json -o a.png -q
refuse also_by_validate 5 "lost.tf.json: $lost" "$ISOSHADE" validate v.nrrd --scene good.scene.json --tf lost.tf.json --quick --levels 1 --with gl -o r -q
refuse and_without_a_scene 5 "lost.tf.json: $lost" "$ISOSHADE" render v.nrrd --tf lost.tf.json -o a.png -q
refuse one_that_a_scene_names_is_named 5 "lost.tf.json: $lost" "$ISOSHADE" render v.nrrd --scene names.scene.json -o a.png -q
refuse one_that_a_scene_holds_is_the_scenes 5 "holds.scene.json: $lost" "$ISOSHADE" render v.nrrd --scene holds.scene.json -o a.png -q

"$ISOSHADE" build v.nrrd -o v.iso --levels 1 -q && rm v.iso/pyramid.json && mkdir v.zarr plain
refuse a_pyramid_without_its_file_is_one 4 "v.iso: named as a pyramid, but has no pyramid.json" "$ISOSHADE" info v.iso
refuse also_with_a_slash 4 "v.iso/: named as a pyramid, but has no pyramid.json" "$ISOSHADE" render v.iso/ -o a.png -q
refuse so_is_a_zarr 4 "v.zarr: named as a Zarr, but has no .zarray" "$ISOSHADE" info v.zarr
refuse a_plain_folder_has_no_slices 4 "plain: a folder that holds no slices" "$ISOSHADE" info plain
chmod 000 v.iso
if [ "$(id -u)" != 0 ]; then
    refuse a_folder_that_may_not_be_read_is_told 3 "v.iso: cannot be read: Permission denied" "$ISOSHADE" info v.iso
else
    skip a_folder_that_may_not_be_read_is_told "root may read all"
fi
chmod 700 v.iso
exit $failed
