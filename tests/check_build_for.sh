#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Levels that are made for a scene: built, described, verified, validated; and what is refused.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene=$top/refscenes/marschner-lobb.scene.json
"$ISOSHADE" make marschner-lobb --size 33x28x31 --spacing 1x1x1.5 -q -o v.nrrd
"$ISOSHADE" build v.nrrd -q --levels 3 -o plain.iso >/dev/null

expect levels_are_made_for_a_scene 0 "$ISOSHADE" build v.nrrd --for "$scene" --effort none --levels 3 -o v.iso
check each_level_says_what_was_chosen_and_why grep -q '^level 1: [a-z-]*.*, 1 - SSIM [0-9.]* (' out
expect as_data 0 "$ISOSHADE" build v.nrrd --for "$scene" --effort none --levels 3 --threads 1 -o w.iso --json
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
expect it_validates 0 "$ISOSHADE" validate v.iso --scene "$scene" --quick --with gl --size 24 -q -o report
expect it_is_exported_as_any_pyramid 0 "$ISOSHADE" export v.iso --to povray --scene "$scene" --level 1 -o pov -q

# Optimized levels: chosen, described, verified, and taken by every command.
expect levels_are_optimized 0 "$ISOSHADE" build v.nrrd --for "$scene" --effort fast --levels 2 --threads 2 -o o.iso --json
check data_say_how python3 -c 'import json
level = json.load(open("out"))["made_for"]["levels"][0]
o = level["optimized"]
assert level["scalar"] == "optimized" and o["seed"] == 2 and o["views"] == 64 and o["steps"] == 400, level
assert o["error"] < o["error_first"] and o["seconds"] > 0, o
ways = {(c["scalar"], c["scaled"]): c["ssim_dissimilarity"] for c in level["candidates"]}
assert set(ways) == {("as-built", 0), ("as-built", 1), ("least-squares", 0), ("damped", 0), ("damped", 1), ("optimized", 1)}
assert all(ways["optimized", 1] < 0.981 * way for name, way in ways.items() if name[0] != "optimized"), ways
assert len(level["edit_ratios"]) == 4 and max(level["edit_ratios"]) <= 1.02, level["edit_ratios"]
assert len(level["tf"]["entries"]) % 4 == 0 and level["tf"]["range"][0] < level["tf"]["range"][1]'
expect they_are_verified 0 "$ISOSHADE" info o.iso --verify
check by_their_checksum grep -q 'level 1: .* it is not remade' out
cp -r o.iso bad2.iso
printf 'x' | dd of=bad2.iso/level_1_dir.nrrd bs=1 seek=900 conv=notrunc 2>/dev/null
refuse a_changed_byte_is_found 4 'checksum' "$ISOSHADE" info bad2.iso --verify
"$ISOSHADE" build v.nrrd -q --levels 2 -o two.iso >/dev/null
for pyramid in two o; do
    "$ISOSHADE" render $pyramid.iso --scene "$scene" --size 64 --with cpu --level 1 -q -o $pyramid.exr >/dev/null
done
"$ISOSHADE" render o.iso --scene "$scene" --size 64 --with cpu --level 1 --adapt --extinction-scale -q -o adapted.exr >/dev/null
"$ISOSHADE" render o.iso --scene "$scene" --size 64 --with cpu -q -o finest.exr >/dev/null
check adapting_leaves_them_as_they_are "$ISOSHADE" compare o.exr adapted.exr --max-abs 1e-9 -q
for renderer in gl reference; do
    "$ISOSHADE" render o.iso --scene "$scene" --size 64 --with $renderer --step 0.5 --level 1 -q -o $renderer.exr >/dev/null
    check renderers_agree_on_them "$ISOSHADE" compare o.exr $renderer.exr --max-rmse 0.01 -q # their samples differ
done
"$ISOSHADE" tf suggest v.nrrd -o other.tf.json -q >/dev/null
expect another_transfer_function_is_drawn 0 "$ISOSHADE" render o.iso --scene "$scene" --tf other.tf.json --size 64 --with cpu --level 1 -o other.exr
check with_a_warning grep -q "warning: level 1 was made for the transfer function of ${scene##*/}" err
dissimilarity() { "$ISOSHADE" compare finest.exr "$1" --json | python3 -c 'import json, sys; print(1 - json.load(sys.stdin)["ssim"])'; }
check they_are_nearer_than_plain_levels awk "BEGIN {exit !($(dissimilarity o.exr) < 0.8 * $(dissimilarity two.exr))}"
# An export notes that values of such a level are no data; those of others are.
for pyramid in two o; do
    expect it_is_exported 0 "$ISOSHADE" export $pyramid.iso --to vdb --scene "$scene" --level 1 -o $pyramid.vdb -q
done
check an_export_notes_that_they_are_no_data grep -aq 'optimized for pictures of one scene' o.vdb
check but_not_of_a_plain_level bash -c '! grep -aq "optimized for pictures" two.vdb'
for pyramid in two o; do
    "$ISOSHADE" export $pyramid.iso --to vdb --for blender --scene "$scene" --level 1 -o $pyramid.baked.vdb -q
    "$ISOSHADE" export $pyramid.iso --to pbrt --scene "$scene" --level 1 -o $pyramid.pbrt -q
    "$ISOSHADE" export $pyramid.iso --to povray --scene "$scene" --level 1 -o $pyramid.pov -q
done
check other_exports_note_it_too grep -aq 'optimized for pictures of one scene' o.baked.vdb
check in_a_scene_file grep -q 'optimized for pictures of one scene' o.pbrt/scene.pbrt
check in_an_include_file grep -q 'optimized for pictures of one scene' o.pov/*.inc
check and_only_of_such_a_level bash -c '! grep -raq "optimized for pictures" two.baked.vdb two.pbrt two.pov'
# In NanoVDB, grids have blind data.
for pyramid in two o; do
    "$ISOSHADE" export $pyramid.iso --to nanovdb --scene "$scene" --level 1 -o $pyramid.nvdb >$pyramid.txt 2>&1
done
if grep -q 'built without NanoVDB' o.txt; then
    skip nanovdb "$(cat o.txt)"
else
    check each_nanovdb_grid_notes_it test "$(grep -ao 'optimized for pictures of one scene, no data' o.nvdb | wc -l)" = 3
    check named_isoshade_values grep -aq 'isoshade_values' o.nvdb
    check of_such_a_level_alone bash -c '! grep -aq "optimized for pictures" two.nvdb'
    if command -v nanovdb_validate >/dev/null; then
        check and_it_is_valid bash -c 'nanovdb_validate o.nvdb >valid.txt 2>&1 && test ! -s valid.txt'
        nanovdb_convert -f o.nvdb o.back.vdb >/dev/null 2>&1
        check the_grids_come_back "$ISOSHADE" info o.back.vdb:density
    else
        skip and_it_is_valid "libnanovdb-tools is not installed"
    fi
fi
refuse a_plan_has_no_optimized_bricks 2 "level 1 is optimized for a scene, and a plan makes its bricks from level 0" \
    "$ISOSHADE" plan o.iso --scene "$scene" --levels 2 --brick 8 --size 32 -o o.plan.json
expect they_validate 0 "$ISOSHADE" validate o.iso --scene "$scene" --quick --with gl --size 24 -q -o optimized
# The chart shows them as render does: the command of each transfer function gives its row's error again, within the
# table's nine digits. The planted fault leaves out the scale.
expect they_are_charted 0 "$ISOSHADE" chart o.iso --scene "$scene" --full-paths --with gl --steps 1 \
    --quadratures midpoint --plans none --size 24 --budget 0 -q -o chart
check the_build_time_is_that_of_the_pyramid python3 -c 'import csv, json
made = json.load(open("o.iso/pyramid.json"))["made_for"]["levels"][0]["optimized"]["seconds"]
cases = json.load(open("chart/chart.json"))["cases"]
wrong = [c["setting"] for c in cases # 15 digits are printed
         if abs(c.get("build_seconds", 0) - (made if c["level"] == 1 else 0)) > 1e-12 * made]
assert not wrong, wrong
assert {float(c["build_seconds"]) > 0 for c in csv.DictReader(open("chart/pareto.csv")) if c["level"] == "1"} == {True}'
check and_is_printed grep -q 'level 1.* built in [0-9.]* s$' out
check and_drawn grep -q 'level 1, built in' chart/pareto.svg
# Four levels, each with a time, and the cross of a quadrature: their legend takes two rows, all on the page.
mkdir long && cp chart/*.gp long && python3 -c 'import csv, sys
rows = list(csv.DictReader(open("chart/pareto.csv")))
out = csv.DictWriter(sys.stdout, rows[0])
out.writeheader()
out.writerows({**rows[0], "level": k, "build_seconds": 17.8, "quadrature": "preintegrated"} for k in range(4))' >long/pareto.csv
(cd long && gnuplot -e "format='pdf'" pareto.gp && pdftotext -bbox pareto.pdf words)
check its_long_legend_is_on_the_page awk -F'"' '/<page/ {w = $2} /<word/ && $6 > w {bad = 1} /pre-integrated/ {++n} END {exit bad || n != 1}' long/words
row() { python3 "$top/tests/column.py" chart/pareto.csv "$1" level=1 shading_from=fit tf="$2"; } # COLUMN TF
difference() { # TF PYRAMID: between the row's error and that of the rendered picture
    local command
    command=$(row command "$1")
    (PATH=$(dirname "$ISOSHADE"):$PATH && eval "${command/o.iso/$2}" -q) >/dev/null &&
        { "$ISOSHADE" compare setting.exr chart/reference.exr --json >errors.json || test $? = 1; } &&
        awk "BEGIN {d = $(row rmse "$1") - $(json_number errors.json rmse); print d < 0 ? -d : d}"
}
cp -r o.iso unscaled.iso
payload='import sys; print(sum(len(open(name, "rb").read().split(b"\n\n", 1)[1]) for name in sys.argv[1:]))' # of NRRDs
PYTHONPATH=$top/tests "$python" -c 'import json, read_iso
path = "unscaled.iso/pyramid.json"
description = json.load(open(path))
del description["levels"][1]["files"]["scale"]
read_iso.write_description(path, description)'
for tf in original adapted deviation; do
    holds "render_gives_the_error_of_tf_$tf" "$(difference $tf o.iso) < 1e-8"
    holds "a_missing_scale_is_noticed_with_tf_$tf" "$(difference $tf unscaled.iso) > 1e-4"
done
check the_bytes_are_those_of_the_files test "$(row stored_bytes original)" = \
    "$(python3 -c "$payload" o.iso/level_1{,_dir,_scale}.nrrd)"
expect they_are_exported 0 "$ISOSHADE" export o.iso --to povray --scene "$scene" --level 1 -o pov2 -q
check with_their_scale ls pov2/*_scale.df3
refuse a_target_without_scales_refuses_them 2 'paraview does not support extinction scales' \
    "$ISOSHADE" export o.iso --to paraview --scene "$scene" --level 1 -o paraview
expect they_are_viewed 0 "$ISOSHADE" view o.iso --scene "$scene" -q -o o.html
# Several scenes: each is judged, and commands take the level under its own transfer function for each.
two=$scene,$top/refscenes/solid.scene.json
expect levels_are_made_for_two_scenes 0 "$ISOSHADE" build v.nrrd --for "$two" --effort fast --levels 2 -o t.iso
check with_a_ratio_for_each grep -q '^level 1: .* of the best for solid.scene.json alone (' out
expect both_are_named 0 "$ISOSHADE" info t.iso --json
check with_their_figures python3 -c 'import json
made = json.load(open("out"))["made_for"]
level = made["levels"][0]
assert [made["scene"]] + [o["scene"] for o in made["others"]] == ["marschner-lobb.scene.json", "solid.scene.json"], made
for part in level, level["others"][0]:
    chosen = [c for c in part["candidates"] if c["scalar"] == "optimized"][0]["ssim_dissimilarity"]
    best = min(c["ssim_dissimilarity"] for c in part["candidates"] if c["scalar"] != "optimized")
    assert level["scalar"] == "optimized" and part["ratio"] <= 1.02 and abs(chosen / best - part["ratio"]) < 0.1, part
assert level["tf"] != level["others"][0]["tf"]'
for name in ${two//,/ }; do
    expect either_is_drawn 0 "$ISOSHADE" render t.iso --scene "$name" --size 48 --with cpu --level 1 -o a.png
    check without_a_warning bash -c '! grep -q "another one" err'
done
expect any_other_has_a_warning 0 "$ISOSHADE" render t.iso --scene "$scene" --tf other.tf.json --size 48 --with cpu \
    --level 1 -o a.png
check that_names_both grep -q 'the transfer function of marschner-lobb.scene.json, solid.scene.json and' err
refuse scenes_need_other_transfer_functions 2 "have the same transfer function" \
    "$ISOSHADE" build v.nrrd --for "$scene,$scene" --effort none --levels 2 -o x.iso
refuse effort_needs_a_scene 2 "--effort needs --for" "$ISOSHADE" build v.nrrd --effort fast -o x.iso

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
