#!/usr/bin/env bash
# The command chart: its files, the setting it names, restyling, messages, and no half-written folder.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
chart() { "$ISOSHADE" chart "$dir/v.nrrd" --scene refscenes/marschner-lobb.scene.json --size 24 --quiet --quadratures midpoint --plans none "$@"; }
"$ISOSHADE" make marschner-lobb --size 20x28x17 --spacing 1x1x1.5 -o "$dir/v.nrrd" >/dev/null || exit 1

expect a_chart_is_drawn 0 chart --levels 2 --steps 1,0.25 --codes snorm,region48 --filters moments,naive --want 1/50 -o "$dir/c"
for file in pareto.svg pareto.pdf pareto.csv pareto.gp style.gp chart.json; do
    check "$file"_is_there test -s "$dir/c/$file"
done
check the_fastest_setting_is_named grep -q '^fastest with rmse <= 0.02: gl; level 0' "$dir/out"
check the_smallest_setting_is_named grep -q '^smallest with rmse <= 0.02: gl; level 0' "$dir/out"
# 2 steps of: level 0: 2 codes, floats, flipped, 2 palettes, on the fly; level 1, by both transfer functions: codes, floats,
# flipped and palettes by 2 filters, on the fly; and 2 codes by both tables over two values
check the_grid_is_whole test "$(wc -l <"$dir/c/pareto.csv")" = $((1 + 2 * (7 + 2 * (2 * 6 + 1) + 2 * 2)))
check flipped_directions_are_there grep -q 'gl; level 1; flipped moments' "$dir/c/pareto.csv"
check tables_over_two_values_are_there grep -q 'level 1 TF over deviation; snorm moments; step 0.25' "$dir/c/pareto.csv"
check adapted_transfer_functions_are_there grep -q 'level 1 adapted TF; snorm moments' "$dir/c/pareto.csv"
check the_pdf_embeds_its_fonts grep -aq FontFile "$dir/c/pareto.pdf"
check the_text_of_the_svg_is_text grep -q '>bytes of the level: scalars and directions<' "$dir/c/pareto.svg"

# Finer steps are closer to the converged reference: the planted fault is a table in which they are not.
finer_is_better() {
    awk -F, 'NR > 1 && $4 == 0 && $1 ~ /float/ {e[$5] = $8} END {exit !(e["0.25"] < e[1])}' "$1"
}
check a_finer_step_has_a_smaller_error finer_is_better "$dir/c/pareto.csv"
awk -F, -v OFS=, 'NR > 1 {$5 = $5 == 1 ? 0.25 : 1} 1' "$dir/c/pareto.csv" >"$dir/swapped.csv"
if finer_is_better "$dir/swapped.csv"; then echo "not ok swapped_steps_are_noticed: they pass"; failed=1; else echo "ok swapped_steps_are_noticed"; fi

# Pre-integrated settings and plans double the two steps of level 0's codes, floats, flipped, palettes and on the fly, and add two
# plans for each step; a plan for a larger error has fewer bytes or as many, and holds less than every voxel of level 0.
expect pre_integration_and_plans_are_charted 0 chart --levels 1 --steps 1,0.5 --codes snorm --quadratures midpoint,preintegrated --plans 8/255,1/255 -o "$dir/c2"
check both_quadratures_and_plans_are_there test "$(wc -l <"$dir/c2/pareto.csv")" = $((1 + 2 * 2 * 6 + 2 * 2))
check pre_integrated_settings_are_named grep -q 'gl; level 0; snorm; step 0.5 pre-integrated' "$dir/c2/pareto.csv"
plans_shrink() { awk -F, '/plan for/ {b[$2 ~ /0.031/ ? 1 : 0] = $7; e[$2 ~ /0.031/ ? 1 : 0] = $8} END {exit !(b[1] <= b[0] && e[0] <= e[1] && b[0] > 0)}' "$1"; }
check a_plan_for_less_error_has_more_bytes_and_less_error plans_shrink "$dir/c2/pareto.csv"
expect povray_is_a_setting_of_the_chart 0 chart --levels 1 --steps 1 --with povray -o "$dir/c2"
check povray_has_one_line grep -q '^povray: [a-z]*,povray; level 0; ' "$dir/c2/pareto.csv"

sed 's/#0072b2/#123456/' "$dir/c/style.gp" >"$dir/mine.gp"
expect a_style_can_be_given 0 chart --levels 1 --steps 1 --style "$dir/mine.gp" --json -o "$dir/c"
check the_style_is_used grep -q 'rgb( 18,  52,  86)' "$dir/c/pareto.svg"
for key in schema command options cases skipped_count milliseconds bytes rmse on_time_front on_bytes_front; do
    check "json_has_$key" grep -q "\"$key\":" "$dir/out"
done
expect an_error_that_no_setting_has_is_exit_1 1 chart --levels 1 --steps 1 --want 1e-9 -o "$dir/c"
check the_chart_is_there_all_the_same test -s "$dir/c/pareto.svg"
expect a_spent_budget_leaves_the_cheapest_setting 0 chart --levels 1 --steps 1,0.5 --budget 0.001 -o "$dir/c"
check it_is_the_only_one test "$(wc -l <"$dir/c/pareto.csv")" = 2
check what_was_skipped_is_said grep -q 'settings did not fit' "$dir/out"
mkdir "$dir/user" && touch "$dir/user/file"
expect a_folder_of_the_user_is_kept 3 chart --levels 1 --steps 1 -o "$dir/user"
check its_file_is_there test -e "$dir/user/file"
for bad in 0 2 -1 x 1/ 1/0 nan; do
    expect "want_$bad"_is_refused 2 chart --want="$bad" -o "$dir/n"
done
for bad in 0 1, ,1 x 1x nan; do
    expect "steps_$bad"_is_refused 2 chart --steps="$bad" -o "$dir/n"
done
expect a_code_without_a_texture_is_refused 2 chart --codes oct24 -o "$dir/n"
expect an_unknown_filter_is_refused 2 chart --filters moments,magic -o "$dir/n"
expect an_unknown_quadrature_is_refused 2 chart --quadratures simpson -o "$dir/n"
for bad in 0 2 1/0 x 1/255, none,1/255; do
    expect "plans_$bad"_is_refused 2 chart --plans="$bad" -o "$dir/n"
done
expect an_output_is_needed 2 chart
check no_folder_is_left test -z "$(find "$dir" -maxdepth 1 -name '.*-*')"
exit $failed
