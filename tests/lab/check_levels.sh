#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab levels: the table as a command, its keys, what is left out, and bad usage.
. "$(dirname "$0")/../lib.sh"
"$ISOSHADE" make shells --size 24 --type uint8 -o shells.nrrd -q && "$ISOSHADE" make constant --size 24 --type uint8 -o constant.nrrd -q || exit 1
check its_help_has_names_without_words bash -c '"$LAB" levels --help=all >help && grep -qx "  opacity/2" help && ! grep -q null help'
few=(levels --quick --views 1 --size 40 --levels 3 -q)

expect the_table_runs 0 "$LAB" "${few[@]}" shells.nrrd --methods default,original,on-the-fly,gauss --csv table.csv
check it_has_both_levels test "$(grep -c '^named, level' out)" = 2
check and_each_method_at_each_and_at_all_together test "$(grep -c '^gauss ' out)" = 3
check the_csv_has_a_line_a_case_and_method test "$(wc -l <table.csv)" = $((1 + 4 * $(sed 1d table.csv | cut -d, -f2-4 | sort -u | wc -l)))
# A run that was ended goes on: what its table has is not measured again, and the whole is the same.
cp out first.txt && grep -E '^held|,opaque,|,shell,' table.csv >part.csv
expect a_run_goes_on 0 "$LAB" "${few[@]}" shells.nrrd --methods default,original,on-the-fly,gauss --have part.csv --csv again.csv
check it_measures_what_is_missing bash -c '! grep -E "^shells.nrrd +(opaque|shell) " out && grep -qE "^shells.nrrd +soft " out'
check and_has_the_same_cases cmp <(sort table.csv) <(sort again.csv)
expect tables_are_printed_without_volumes 0 "$LAB" levels -q --have part.csv
check of_the_cases_that_they_have grep -q '^named, level 1: 2 cases' out
expect of_all_cases 0 "$LAB" levels -q --have again.csv
check they_are_those_of_the_first_run cmp <(sed -n '/^named, level 1/,$p' first.txt) <(sed -n '/^named, level 1/,$p' out)
refuse a_table_twice 4 'part.csv: line 2: repeats an earlier line' "$LAB" levels -q --have table.csv,part.csv
refuse a_table_of_other_views 4 'not "2 views' "$LAB" levels shells.nrrd --quick --levels 3 -q --have part.csv
refuse a_table_of_another_volume 2 '24x24x24 voxels in the table, but 16x16x16 now' "$LAB" "${few[@]}" shells.nrrd --json --crop 16 --have part.csv
refuse a_file_that_is_no_table 4 shells.nrrd "$LAB" levels -q --have shells.nrrd
refuse a_method_that_was_not_measured 2 '--against fitted' "$LAB" levels -q --have part.csv --against fitted
expect json_runs 0 "$LAB" "${few[@]}" shells.nrrd constant.nrrd --held shells.nrrd --methods original,gauss --against original --json
check its_keys python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
assert r['schema'] == 'isoshade-lab.levels/1' and r['against'] == 'original' and r['complete']
assert [b['block'] for b in r['blocks']] == ['named', 'held back']
for b in r['blocks']:
    for level in b['levels']:
        rows = {m['method']: m for m in level['methods']}
        if not rows:
            continue
        base, gauss = rows['original'], rows['gauss']
        assert all(q == 1 for f in base['ratios'].values() for q in f.values()), base
        assert base['worse_count'] == base['much_worse_count'] == 0
        assert gauss['ratios']['dssim']['geometric_mean'] > 1.05, gauss  # wider than a mean of eight: a worse method
        assert gauss['worse_count'] >= gauss['much_worse_count'] > 0 and gauss['worst'][0]['dssim_ratio'] > 1.05
named = r['blocks'][0]
assert sum(named['left_out'].values()) > 0, named['left_out']  # the constant volume
assert {c['left_out'] for c in r['cases'] if c['volume'] == 'constant.nrrd'} <= set(named['left_out'])
# the same volume in both blocks: the same figures
a, b = ([c['dssim'] for c in r['cases'] if c['volume'] == 'shells.nrrd' and c['held'] == h] for h in (False, True))
assert a == b and len(a) > 0
PY
"$ISOSHADE" make sphere --size 24 --type uint8 -o sphere.nrrd -q || exit 1
expect rivals_run 0 "$LAB" "${few[@]}" sphere.nrrd --tfs opaque,soft --methods rivals --against original --json
check they_are_rows_and_worse_where_they_must_be python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
names = {c['method'] for c in r['cases']}
assert names == {'original', 'rgba-opacity', 'rgba-extinction', 'rgba-transmittance', 'two-gaussians', 'mean-deviation', 'brick-tables', 'sggx'}, names
rows = {m['method']: m['ratios']['dssim']['geometric_mean'] for m in r['blocks'][0]['levels'][0]['methods']}
assert rows['rgba-opacity'] > 1, rows          # a smooth surface that is classified first is blurred
assert rows['brick-tables'] < 1, rows        # one brick: as adapting the whole level
two, limit = ([c['rmse'] for c in r['cases'] if c['method'] == m] for m in ('two-gaussians', 'rgba-opacity'))
assert all(abs(a - b) < 0.2 * b for a, b in zip(two, limit)), (two, limit)
PY
expect levels_for_a_scene_run 0 "$LAB" "${few[@]}" sphere.nrrd --tfs opaque,soft --methods default,fitted,for-scene --json
check they_are_no_worse_than_what_they_choose_from python3 - out <<'PY'
import json, sys
r = json.load(open(sys.argv[1]))
cases = {(c['tf'], c['level'], c['method']): c['dssim'] for c in r['cases'] if not c['left_out']}
tried = {k[:2] for k in cases}
assert len(tried) >= 3, cases
for k in tried:  # other views than those that chose: a tenth
    assert cases[k + ('for-scene',)] <= 1.1 * min(cases[k + ('default',)], cases[k + ('fitted',)] if k[1] > 1 else 1), (k, cases)
PY
# Edited after the levels were made: another truth, and tables that are not mixed with those of another edit.
expect an_edited_tf_runs 0 "$LAB" "${few[@]}" sphere.nrrd --tfs opaque --methods default,for-scene --edit threshold-5 --csv edit.csv
expect and_one_that_is_not 0 "$LAB" "${few[@]}" sphere.nrrd --tfs opaque --methods default,for-scene --csv plain.csv
check they_differ bash -c '! cmp -s <(cut -d, -f7 edit.csv) <(cut -d, -f7 plain.csv)'
refuse a_table_of_another_edit 4 'threshold-5' "$LAB" "${few[@]}" sphere.nrrd --have edit.csv
refuse an_unknown_edit 2 'opacity/2' "$LAB" "${few[@]}" sphere.nrrd --edit more
expect quick_is_small 0 "$LAB" levels shells.nrrd --quick --levels 2 --tfs soft --methods original -q --json
check two_views_of_96_pixels grep -q '"views": 2' out
expect a_budget_ends_it 0 "$LAB" "${few[@]}" shells.nrrd shells.nrrd --budget 1e-9 --methods original --json
check and_it_says_so grep -q '"complete": false' out
refuse an_unknown_method 2 --methods "$LAB" "${few[@]}" shells.nrrd --methods best
refuse an_unknown_base 2 --against "$LAB" "${few[@]}" shells.nrrd --against best
refuse an_unknown_tf 2 --tfs "$LAB" "${few[@]}" shells.nrrd --tfs surface
refuse no_volume 2 volume "$LAB" levels -q
expect a_missing_volume 3 "$LAB" "${few[@]}" missing.nrrd
exit $failed
