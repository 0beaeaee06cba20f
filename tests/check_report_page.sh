#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The report in a browser, as its reader uses it: failed cases, A/B flip, threshold, zoom, no network, and a screenshot.
. "$(dirname "$0")/lib.sh"
python_with numpy
cd "$top" || exit 1
# A step of opacity 0.9999 in a scene declared smooth, whose limits floats exceed, so that the page has a failed case.
mkdir "$dir/strict" "$dir/elsewhere"
sed 's/"tf": "sharp"/"tf": "smooth"/; s/"opacity": 0.7/"opacity": 0.9999/' refscenes/suite/step.scene.json >"$dir/strict/strict.scene.json"
cd "$dir" || exit 1
expect a_report_with_a_failed_case_is_exit_1 1 "$ISOSHADE" validate --suite strict --quick --size 12 --with gl,povray --quiet -o report
commands() { PATH=$(dirname "$ISOSHADE"):$PATH python3 "$top/tests/report_commands.py" "$@"; }
check commands_of_the_report_run_where_it_was_made commands report
expect and_not_in_another_folder 1 commands report "$dir/elsewhere"
cd "$top" || exit 1

browse() { # page, options: the browser keeps to a folder of its own
    local page=$1
    shift
    patiently chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
        --disable-component-update --user-data-dir="$dir/browser" --window-size=1200,1600 --virtual-time-budget=20000 "$@" \
        "file://$page" 2>"$dir/browser.err"
}
# The page with the user's hands in it, and what they found.
findings() { # page
    { sed '/<\/body>/,$d' "$1" && echo '<script>' && cat tests/report_page.js && echo '</script></body></html>'; } >"$dir/driven.html"
    browse "$dir/driven.html" --dump-dom | sed -n '/^findings$/,/^end of findings$/p' >"$dir/findings"
}
found() { grep -qxE "$1" "$dir/findings"; }
page=$dir/report/index.html
findings "$page"
check the_page_was_used test -s "$dir/findings"
check no_script_failed test -z "$(grep exception "$dir/findings")"
check failed_cases_are_shown found 'failed_cases_shown [1-9]'
check failed_cases_stand_on_top found 'failed_cases_on_top true'
check every_comparison_has_a_row found 'rows [1-9][0-9]*'
check the_worst_row_is_first found 'worst_row_first differ'
check a_failed_case_says_how_to_see_it_again found 'reproduce isoshade .*'
check images_stand_side_by_side_with_their_difference found 'panels_side_by_side 3'
check the_threshold_slider_counts_pixels found 'threshold true'
check all_panels_zoom_in_step found 'zoom_in_step 3'
check a_button_shows_the_whole_again found 'whole_again true'
check what_is_under_the_pointer_stays_there found 'zoom_keeps_the_pixel_under_the_pointer true'
check the_zoom_outlives_the_mode found 'zoom_outlives_the_mode true'
check keys_zoom found 'keys_zoom true'
check images_flip found 'flip true'
check keys_flip found 'keys_flip true'
check a_key_goes_to_the_next_case_and_the_address_names_it found 'next_case true'
check a_renderer_can_be_chosen found 'filter true'
check rows_can_be_searched_for_words found 'words true'
check all_rows_come_back found 'all_again true'
check headings_sort found 'sort true'
check the_command_is_copied found 'copy true'
check every_control_has_a_name found 'controls_without_a_name 0'
check text_stands_out_by_day_and_by_night test "$(grep -cE '^contrast_(light|dark) true$' "$dir/findings")" = 2
check versions_and_machine_are_there found 'versions_and_machine true'
check any_two_pictures_of_a_scene_are_compared found 'any_two_pictures true'
check nothing_is_fetched found 'fetched 0'
check no_picture_is_broken found 'pictures_broken 0'

# The planted faults: pages each of which has lost one thing.
lost() { # name, what is lost (sed), the finding that must show it
    sed "$2" "$page" >"$dir/lost.html"
    if cmp -s "$page" "$dir/lost.html"; then not_ok "$1" "the fault could not be planted"; return; fi
    findings "$dir/lost.html"
    check "$1" found "$3"
}
lost a_dead_slider_is_noticed 's/view.threshold = Number(slider.value);//' 'threshold false'
lost a_panel_that_does_not_follow_is_noticed 's/draw(parts.b, b.canvas/0 \&\& draw(parts.b, b.canvas/' 'zoom_in_step 2'
lost a_dead_filter_and_a_dead_heading_are_noticed 's/order.filter\[name\] = e.target.value;//; s/order.column = i;//' '(filter|sort) false'

browse "$page" --screenshot="$dir/report.png" >/dev/null
# A blank page of this size packs into a few kilobytes.
check a_screenshot_is_no_blank_page test "$(stat -c %s "$dir/report.png")" -gt 40000

# Levels under the original and the adapted transfer function. The renderers agree, so this page has no other failures;
# its scene asks for a level that is nearer to level 0 than 8 x 9 x 7 voxels can be, so the level fails.
"$ISOSHADE" make shells --size 16x18x14 -o "$dir/v.nrrd"
cp refscenes/shells.tf.json "$dir"
sed 's/"step_voxels"/"levels": {"ssim_dissimilarity": 0.01}, &/' refscenes/shells.scene.json >"$dir/asked.scene.json"
expect a_level_that_fails_is_exit_1 1 "$ISOSHADE" validate "$dir/v.nrrd" --scene "$dir/asked.scene.json" --quick --with gl \
    --levels 2 --size 24 --quiet -o "$dir/levels"
# As a row of two versions of a program has it.
sed -i 's/"comparison":"limit"/"comparison":"versions"/; s/"statistics":{/&"largest_change":0.25,"pixel":[3,4],"channel":"G","noise_there":0.001,"pixels_tested":9,"pixels_beyond_chance":1,/' "$dir/levels/index.html"
findings "$dir/levels/index.html"
check versions_stand_beside_each_other_with_the_pixel found 'versions true'
check consistency_has_a_row_of_each_method_and_tf found 'consistency_rows 8'
check half_of_them_are_under_the_adapted_tf found 'rows_under_the_adapted_tf 4'
check the_level_is_told_with_its_figures found 'levels_told true'
check the_levels_have_a_verdict_of_their_own found 'levels_verdict ✗ The levels do not hold: 1 of 1 fails\. Level 1: 1-SSIM is 0\.[0-9]+, the limit is 0\.01\..*'
# A renderer with a known mistake.
cp doc/guide/{numpy_renderer.py,renderers.json} "$dir"
sed -i "s|\"python3\", \"numpy|\"$python\", \"numpy|" "$dir/renderers.json"
sed -i 's/-np.expm1(-sigma/-np.expm1(-0.5 * sigma/' "$dir/numpy_renderer.py"
expect a_renderer_with_a_mistake_is_exit_9 9 "$ISOSHADE" validate "$dir/v.nrrd" --quick --levels 1 --size 8 --quiet \
    --with numpy --renderers "$dir/renderers.json" -o "$dir/mistaken"
findings "$dir/mistaken/index.html"
check the_mistake_is_shown_with_its_pictures found 'mistakes_explained 1'
page=$dir/mistaken/index.html
lost pictures_of_another_mistake_are_noticed "s/picture('explained'/picture('wanted'/" 'mistakes_explained 0'
lost a_black_difference_is_noticed 's/(d, null, -Infinity)/(d, null, Infinity)/' 'mistakes_explained 0'
# What a budget left out.
expect nothing_is_compared_in_no_time 1 "$ISOSHADE" validate "$dir/v.nrrd" --scene refscenes/shells.scene.json --quick --with gl \
    --levels 3 --size 16 --budget 0.001 --quiet -o "$dir/hurried"
findings "$dir/hurried/index.html"
check whole_stages_are_told_first found 'uncompared open 5 stages: left out by the budget; open [0-9]+ cases: left out by the budget'
check and_that_no_level_was_judged found 'levels_verdict The levels were not judged: the budget of 0.001 s was over .*'
page=$dir/levels/index.html
lost a_level_without_its_verdict_is_noticed 's/f.held ? .. : .differ.//' 'levels_told false'
lost rows_of_the_wrong_tf_are_noticed "s/\\['adapted', 'scaled'\\].includes(r.tf) ? r.tf : 'original'/'original'/" 'consistency_rows false'
exit $failed
