#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Two reports: the same twice is no difference; one planted change is one row or one picture; what is printed, the page in a
# browser, and the summaries as Markdown. The scene is called <b>|x, which no text of them may take for its own.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 12x13x11 -q -o v.nrrd
cp "$top/refscenes/shells.tf.json" .
cp "$top/refscenes/shells.scene.json" '<b>|x.scene.json'
expect a_report_with_a_summary 0 "$ISOSHADE" validate v.nrrd --scene '<b>|x.scene.json' --quick --levels 1 --with gl --size 24 \
    --summary-md one.md -q -o one
check the_verdict_stands_in_the_summary grep -q '^The renderers agree' one.md
check versions_are_in_it grep -q '^| OpenGL ray caster | ' one.md
check it_links_to_the_page grep -qF '[one/index.html](one/index.html)' one.md
check nothing_failed_so_there_is_no_table_of_it test -z "$(grep 'at most' one.md)"
refuse a_summary_needs_a_folder 3 'the folder nowhere does not exist' "$ISOSHADE" validate v.nrrd --quick --summary-md nowhere/one.md -o two
# In the report's folder, which is not there yet at first, and is replaced with it.
within() { "$ISOSHADE" validate v.nrrd --scene '<b>|x.scene.json' --quick --levels 1 --with cpu --size 16 -q -o in "$@"; }
check other_forms_may_lie_in_the_report within --summary-md in/one.md --junit in/j.xml
check and_do_not_hinder_the_next_one within
check which_has_none test -s in/report.json -a ! -e in/one.md -a ! -e in/j.xml
within --summary-md "$dir/in/one.md" >/dev/null && echo more >>in/one.md
refuse one_that_was_edited_stays 3 'one.md in it was changed' within

cp -r one two
refuse two_reports_are_wanted 2 'diff needs two reports' "$ISOSHADE" report diff one
refuse other_words_are_refused 2 'unknown subcommand "draw"' "$ISOSHADE" report draw one two
refuse another_file_is_no_report 4 'must be isoshade.validate/1: not a report.json of isoshade validate' "$ISOSHADE" report diff one shells.tf.json
expect the_same_report_twice 0 "$ISOSHADE" report diff one two -o same
check is_said_to_be_no_difference grep -qE '^No difference in [0-9]+ rows and [1-9][0-9]* pictures\.$' "$dir/out"
check the_empty_page_is_written test -s same/index.html

# Plants one change into two/report.json: Python code on its dictionary d.
plant() {
    rm -rf two && cp -r one two
    python3 -c "
import json
d = json.load(open('two/report.json'))
$1
json.dump(d, open('two/report.json', 'w'))"
}
limit="next(r for r in d['agreement'] if r['comparison'] == 'lock-step')"
plant "$limit['rmse'] += 0.04 * $limit['limits']['rmse']"
expect one_figure_beyond_its_tolerance_is_a_difference 1 "$ISOSHADE" report diff one two
check of_exactly_one_row test "$(grep -c '^changed: ' "$dir/out")" = 1
check with_the_figure test "$(grep -c '^    worse: rmse: ' "$dir/out")" = 1
check and_no_picture test -z "$(grep '^picture' "$dir/out")"
expect a_figure_that_fell_is_one_too 1 "$ISOSHADE" report diff two one
expect json_says_it_too 1 "$ISOSHADE" report diff one two --json
has_keys json_has "$dir/out" schema command options rows facts pictures verdict sentence changed_count picture_count
plant "$limit['rmse'] += 0.005 * $limit['limits']['rmse']; $limit['seconds'] = 99; d['seconds']['total'] = 99; d['made'] = 'now'"
expect a_figure_within_it_and_times_are_none 0 "$ISOSHADE" report diff one two
plant "$limit['limits']['rmse'] *= 2"
expect a_stated_limit_that_moved_is_a_difference 1 "$ISOSHADE" report diff one two
plant "$limit['rmse'] += 0.04 * $limit['limits']['rmse']; $limit.setdefault('statistics', {})['noise_bar'] = 1.0"
expect a_change_within_the_noise_of_the_second_is_none 0 "$ISOSHADE" report diff one two
expect nor_within_that_of_the_first 0 "$ISOSHADE" report diff two one
plant "$limit['rmse'] = None"
expect a_figure_that_is_none_any_more_is_a_difference 1 "$ISOSHADE" report diff one two
plant "d['agreement'].remove($limit)"
expect a_row_that_disappeared_is_a_difference 1 "$ISOSHADE" report diff one two
plant "d['versions']['OpenGL ray caster'] = 'another'"
expect another_version_is_a_difference 1 "$ISOSHADE" report diff one two
check that_is_named grep -q '^versions: OpenGL ray caster: llvmpipe.* -> another$' "$dir/out"
expect but_not_of_the_results 0 "$ISOSHADE" report diff one two --results-only
check where_it_is_told grep -q '1 version or option differs (not counted, by request)' "$dir/out"
plant ''
rm -r two/images
expect a_report_without_its_pictures 0 "$ISOSHADE" report diff one two
check is_said grep -q 'Pictures were not compared: B has no folder images' "$dir/out"
plant ''
rm "two/images/level-0-gl-limit.exr"
expect a_picture_that_is_gone_counts 1 "$ISOSHADE" report diff one two
check by_name grep -q '^picture: level-0-gl-limit: .*level-0-gl-limit.exr' "$dir/out"
echo damaged >two/images/level-0-gl-limit.exr
refuse one_that_cannot_be_read_is_no_difference_but_an_error 4 "level-0-gl-limit.exr: is no picture of a known kind, must be OpenEXR" "$ISOSHADE" report diff one two

# A row and its picture, made with other steps.
plant "r = next(r for r in d['agreement'] if r['comparison'] == 'limit'); r['verdict'] = 'differ'; r['rmse'] = 0.5; d['verdict'] = 'differ'
d['calibration'][0]['verdict'] = 'fail'; d['calibration'][0]['renderer'] = '*_[x](y)'"
"$ISOSHADE" render v.nrrd --scene '<b>|x.scene.json' --size 24 --with gl --step 4 -q --png two/images/level-0-gl-limit.png \
    -o two/images/level-0-gl-limit.exr >"$dir/render.out" 2>&1
expect a_changed_picture_is_a_difference 1 "$ISOSHADE" report diff one two -o page --summary-md diff.md
expect so_with_a_summary_in_the_page 1 "$ISOSHADE" report diff one two -o page --summary-md page/diff.md
expect which_is_replaced_too 1 "$ISOSHADE" report diff one two -o page --summary-md diff.md
check of_exactly_one_picture test "$(grep -c '^picture: level-0-gl-limit: RMSE' "$dir/out")" = 1
check no_other_picture_differs test "$(grep -c '^picture: ' "$dir/out")" = 1
check the_summary_has_the_row grep -qF '| &#60;b&#62;&#124;x, level 0: gl, limit against reference | verdict | agree | differ | ' diff.md
check names_bring_no_markup_along test -z "$(grep -E '<b>|\[x\]|\*_' diff.md)"
# Unescaped bars part cells: each line of a table has as many as its head.
check tables_are_whole awk '/^\|/ { n = gsub(/\|/, ""); if (width && n != width) exit 1; width = n; next } { width = 0 }' diff.md one.md

{ sed '/<\/body>/,$d' page/index.html && echo '<script>' && cat "$top/tests/difference_page.js" && echo '</script></body></html>'; } >driven.html
patiently chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-component-update \
    --user-data-dir="$dir/browser" --window-size=1200,1600 --virtual-time-budget=20000 --dump-dom "file://$dir/driven.html" \
    2>browser.err | sed -n '/^findings$/,/^end of findings$/p' >findings
found() { grep -qxE "$1" findings; }
check the_page_was_used test -s findings
check no_script_failed test -z "$(grep exception findings)"
check changed_rows_are_listed found 'changes [3-9]'
check and_the_picture found 'pictures 1'
check the_sentence_is_on_top found 'verdict ✗ The reports differ: .*'
check the_page_begins_with_a_flip found 'begins_with_a_flip true'
check pictures_flip_between_the_reports found 'flips_between_the_reports true'
check a_slider_parts_them found 'slider true'
check their_difference_is_shown found 'differing_pixels [1-9][0-9]*'
check all_stand_side_by_side found 'side_by_side 3'
check a_row_opens_its_picture found 'a_row_opens_its_picture true'
check a_name_is_text found 'name_is_text true'
check and_no_element found 'elements_of_the_name 0'
check every_control_has_a_name found 'controls_without_a_name 0'
check nothing_is_fetched found 'fetched 0'
exit $failed
