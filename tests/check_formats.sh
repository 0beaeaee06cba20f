#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The pages doc/reference/files*.md are complete: tests/read_iso.py, which uses nothing else, reads what the program writes.
# And their keys are those of the code, both ways.
. "$(dirname "$0")/lib.sh"
page=$dir/files.md
cat "$top"/doc/reference/files*.md >"$page"
python_with numpy
read_iso() { "$python" "$top/tests/read_iso.py" "$@"; }

# ---- pyramids: each code, odd sizes, a rotated grid; noise, so that directions go everywhere ----
"$ISOSHADE" make noise --size 23x18x13 --spacing 1x1.5x2.5 --type uint16 -o v.nrrd >/dev/null 2>&1
# about z by 30 degrees: the header's length may change, the samples follow it
LC_ALL=C sed '0,/^space directions: .*/s//space directions: (0.8660254037844387,0.5,0) (-0.75,1.299038105676658,0) (0,0,2.5)/' v.nrrd >turned.nrrd
for code in fit snorm shell free cube region48; do
    "$ISOSHADE" build turned.nrrd -o "$code.iso" --code "$code" --keep-float --keep-magnitude --levels 3 -q >/dev/null 2>&1
    vdb=
    if "$python" -c 'import pyopenvdb' 2>/dev/null; then
        vdb=$code.vdb
        "$ISOSHADE" export "$code.iso" --to vdb --levels 3 -o "$vdb" -q >/dev/null 2>&1
    fi
    check "reads_$code" read_iso pyramid "$code.iso" $vdb
done
[ -n "$vdb" ] || echo "without OpenVDB for Python: directions are checked by the error of their code alone"
"$ISOSHADE" make shells --size 9x8x7 --type float -o f.nrrd >/dev/null 2>&1
"$ISOSHADE" build f.nrrd -o f.iso --scalar-filter gauss --direction-filter eq1 -q >/dev/null 2>&1
check reads_other_filters_and_types read_iso pyramid f.iso

# ---- faults: a flipped bit, a wrong decoder ----
cp -r fit.iso flipped.iso
printf '\001' | dd of=flipped.iso/level_1_dir.nrrd bs=1 seek=500 conv=notrunc status=none
cmp -s fit.iso/level_1_dir.nrrd flipped.iso/level_1_dir.nrrd && printf '\002' | dd of=flipped.iso/level_1_dir.nrrd bs=1 seek=500 conv=notrunc status=none
expect a_flipped_byte_is_found 1 read_iso pyramid flipped.iso
grep -q checksum out && ok it_is_the_checksum || not_ok it_is_the_checksum "$(cat out)"
expect a_wrong_decoder_of_region48_is_found 1 env WRONG=lambda "$python" "$top/tests/read_iso.py" pyramid region48.iso
check worked_examples read_iso examples "$page"
expect worked_examples_hold_the_decoder 1 env WRONG=signed "$python" "$top/tests/read_iso.py" examples "$page"

# ---- a transfer function and a scene: a constant slab by its formula. The value lies between two entries of the table. ----
cat >slab.tf.json <<'END'
{"schema": "isoshade.tf/1", "range": [0, 1], "unit_distance_voxels": 1.5, "color_space": "srgb", "table_size": 4,
 "points": [{"value": 0, "r": 0.2, "g": 0.4, "b": 0.9, "opacity": 0.05},
            {"value": 0.6, "r": 0.9, "g": 0.5, "b": 0.1, "opacity": 0.7},
            {"value": 1, "r": 0.9, "g": 0.5, "b": 0.1, "opacity": 0.1}]}
END
cat >slab.scene.json <<'END'
{"schema": "isoshade.scene/1", "image": {"width": 15, "height": 11},
 "camera": {"projection": "orthographic", "fit": true, "direction": [0, 1, 0], "up": [0, 0, 1]},
 "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}],
 "shading": {"ambient": 0.6, "diffuse": 0.4}, "background": [0.1, 0.2, 0.3], "tf": "slab.tf.json"}
END
"$ISOSHADE" make constant --size 6x7x5 --spacing 1x0.5x1.25 --type float -o c.nrrd >/dev/null 2>&1
"$ISOSHADE" build c.nrrd -o c.iso -q >/dev/null 2>&1
"$ISOSHADE" render c.iso --scene slab.scene.json --with reference -o slab.exr -q >/dev/null 2>&1
check slab_has_its_formula read_iso slab slab.exr c.iso slab.scene.json
expect opacity_between_entries_is_found 1 env WRONG=opacity "$python" "$top/tests/read_iso.py" slab slab.exr c.iso slab.scene.json

# ---- keys: those of the code are on the page, those of the page are in the code ----
rooms="pyramid tf scene renderers plan compare report validate chart cli options"
(cd "$top/src" && python3 "$top/tests/json_words.py" $rooms ../exporters/targets) >words
[ "$(wc -l <words)" -gt 150 ] && ok words_are_found || not_ok words_are_found "$(wc -l <words) words"
undocumented() { # page: words of the code that it lacks
    local word file missing=0
    while read -r word file; do
        grep -qE "[\`\"]$word[\`\"]" "$1" || { echo "$file writes or reads \"$word\", the page lacks it"; missing=1; }
    done <words
    return $missing
}
invented() { # page: keys of it that no code has
    local key missing=0
    for key in $(grep -oE '`[a-z][a-z0-9_]*`' "$1" | tr -d '`' | sort -u); do
        grep -rqF "\"$key\"" "$top/src" "$top/exporters" --include='*.[ch]' || { echo "the page has $key, no code does"; missing=1; }
    done
    return $missing
}
check keys_of_the_code_are_on_the_page undocumented "$page"
check keys_of_the_page_are_in_the_code invented "$page"
sed 's/`unit_distance_mm`/`unit_distance_of_nothing`/' "$page" >planted.md
expect a_key_that_is_left_out_is_found 1 undocumented planted.md
expect a_key_that_is_invented_is_found 1 invented planted.md
exit $failed
