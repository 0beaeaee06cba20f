#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab consistency --shading: the whole table as a command, its keys, and bad usage.
. "$(dirname "$0")/../lib.sh"
"$ISOSHADE" make shells --size 24 --type uint8 -o shells.nrrd -q || exit 1
quick=(consistency --shading --quick --analytic 24 --views 1 --size 40 --levels 3 -q)

expect the_table_runs 0 "$LAB" "${quick[@]}" shells.nrrd --csv table.csv
check it_has_each_block grep -q 'held back' out
check and_each_method grep -q '^tensor' out
check the_csv_has_a_line_a_case test "$(wc -l <table.csv)" = $((1 + 10 * 2 * $(sed 1d table.csv | cut -d, -f4 | sort -u | wc -l)))
expect json_runs 0 "$LAB" "${quick[@]}" --held shells.nrrd --json
check its_keys python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
assert {c['block'] for c in r['cases']} == {'analytic volumes of the set', 'held back'}
for c in r['cases']:
    assert 0 <= c['dssim_mean'] <= 1 and len(c['dssim']) == 1
    assert 0 <= c['gradient_angle_mean_deg'] <= 90
ratio = {(s['block'], s['method'], s['level']): s['dssim_ratio'] for s in r['summary']}
for (block, method, level), value in ratio.items():
    if method == 'on-the-fly':
        assert value == 1
assert ratio['analytic volumes of the set', 'default', 2] < 1
assert ratio['analytic volumes of the set', 'default', 2] < ratio['analytic volumes of the set', 'unit', 2]
for e in r['exceptions']:
    assert e['dssim'] >= e['dssim_on_the_fly'] and e['cause']
PY
# What shows no difference between methods counts in no mean, and is named with its reason.
"$ISOSHADE" make noise --size 24 --type uint8 -o noise.nrrd -q && "$ISOSHADE" make constant --size 24 --type uint8 -o constant.nrrd -q || exit 1
expect a_volume_without_a_surface_runs 0 "$LAB" "${quick[@]}" noise.nrrd constant.nrrd --json
check it_is_left_out_with_its_reason python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
why = {c['volume']: c['why'] for c in r['left_out'] if c['level'] is None}
assert 'two classes' in why['noise.nrrd'] and 'constant' in why['constant.nrrd'], why
assert not {'noise.nrrd', 'constant.nrrd'} & {c['volume'] for c in r['cases']}
for s in r['summary']:
    assert s['volumes'] == 0 if s['block'] == 'volumes of the set' else s['dssim_ratio_median'] > 0, s
PY
expect cases_without_an_error_run 0 "$LAB" consistency shells.nrrd constant.nrrd --views 1 --size 24 --levels 2 --tfs soft --methods original,opacity-flat -q --json
check they_are_left_out_and_counted python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
block = r['blocks'][0]
assert block['case_count'] == 1 and block['left_out_count'] == 1, block
assert sum(block['left_out'].values()) == 1
ratio = {m['method']: m for m in block['means'] if m['level'] == 0}['opacity-flat']  # always adapts
assert ratio['ssim_ratio'] == ratio['ssim_ratio_median'] != 1, ratio  # one case left: its ratio is all figures
PY
expect no_volume_means_shading 0 "$LAB" consistency --size 16 --views 1 --levels 2 --help
# A name is a whole word: "al", "a" and nothing at all once meant all of them.
for name in al a , "" "default,al"; do
    refuse "methods_$name" 2 "unknown method" "$LAB" consistency --analytic 16 --size 16 --views 1 --levels 2 --methods "$name" -q
done
refuse too_many_views 2 --views "$LAB" consistency --shading --views 7 -q
refuse a_surface_beyond_the_range 2 --surface "$LAB" consistency --shading --surface 1.5 -q
expect a_missing_volume 3 "$LAB" "${quick[@]}" missing.nrrd
# ---- triangle: Figure 7 ----
tf=$top/refscenes/shells.tf.json
"$ISOSHADE" make shells --size 24 --type uint8 -q -o triangle.nrrd
expect triangle 0 "$LAB" triangle triangle.nrrd --tf "$tf" -o triangle.png
check its_corners_are_printed grep -qE 'Gaussian 0\.[0-9]+, constant 0\.[0-9]+, triangular 0\.[0-9]+; least 0\.[0-9]+' out
check its_picture_is_a_png grep -q PNG triangle.png
"$LAB" triangle triangle.nrrd --tf "$tf" -o triangle.pdf --json -q >out
holds the_least_is_no_corners "$(json_number out rms_least) <= $(json_number out rms_gauss) && $(json_number out rms_least) <= $(json_number out rms_constant)"
# With room to the edge: in a PNG letters are wider, and letters beyond the edge are not drawn.
on_the_page() { pdftotext -bbox "$1" - | awk -F'"' '/<page/ {wide = $2} />'"$2"'</ {found = 1; if ($6 > wide - 6) bad = 1} END {exit !found || bad}'; }
check the_words_of_its_colors_are_on_the_page on_the_page triangle.pdf voxels
refuse it_needs_a_transfer_function 2 "--tf is missing" "$LAB" triangle triangle.nrrd
exit $failed
