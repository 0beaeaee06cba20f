#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command chart: its grid and files, fronts, the setting it names and that setting rendered again, the budget, restyling,
# messages, and no half-written folder.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
scene=refscenes/marschner-lobb.scene.json
# Without a limit of time, so that a busy machine leaves no setting out; a later --budget wins.
all_axes() { "$ISOSHADE" chart "$dir/v.nrrd" --scene $scene --size 24 --full-paths --quiet --budget 0 "$@"; }
chart() { all_axes --with gl --quadratures midpoint --plans none --estimators central --filters moments --codes snorm,region48 "$@"; }
column() { python3 "$top/tests/column.py" "$@"; } # CSV COLUMN [COLUMN=VALUE ...]: the values of a column, one a line
"$ISOSHADE" make marschner-lobb --size 20x28x17 --spacing 1x1x1.5 -o "$dir/v.nrrd" >/dev/null || exit 1

expect a_chart_is_drawn 0 chart --levels 2 --steps 1,0.25 --filters moments,naive --want 1/50 -o "$dir/c"
has_files the_chart_has "$dir/c" pareto.svg pareto.pdf pareto.csv pareto.gp style.gp chart.json reference.exr palette-254.csv
check the_fastest_setting_is_named grep -q '^fastest with rmse <= 0.02: gl; level 0' "$dir/out"
check the_smallest_setting_is_named grep -q '^smallest with rmse <= 0.02: gl; level 0' "$dir/out"
# 2 steps of: level 0: 2 codes, floats, flipped, 2 palettes, on the fly; level 1, by both transfer functions: codes, floats,
# flipped and palettes by 2 filters, on the fly; and the first code by both 2D transfer functions
check the_grid_is_whole test "$(wc -l <"$dir/c/pareto.csv")" = $((1 + 2 * (7 + 2 * (2 * 6 + 1) + 2)))
check no_setting_is_there_twice test -z "$(column "$dir/c/pareto.csv" setting | sort | uniq -d)"
# Which renderer draws where none is named depends on the machine.
check each_command_names_its_renderer test "$(column "$dir/c/pareto.csv" command | grep -vc -- ' --with gl ')" = 0
check flipped_directions_are_there grep -q 'gl; level 1; flipped moments' "$dir/c/pareto.csv"
check tf_2ds_are_there grep -q 'level 1 2D TF (deviation); snorm moments; step 0.25' "$dir/c/pareto.csv"
check adapted_transfer_functions_are_there grep -q 'level 1 adapted TF; snorm moments' "$dir/c/pareto.csv"
check the_pdf_embeds_its_fonts grep -aq FontFile "$dir/c/pareto.pdf"
check the_text_of_the_svg_is_text grep -q '>bytes that the renderer holds<' "$dir/c/pareto.svg"
check versions_and_machine_are_in_the_table grep -q 'isoshade [0-9.]*; .*OpenGL.*cores' "$dir/c/pareto.csv"
check the_fastest_frame_is_not_above_the_median test "$(awk -F, 'NR > 1 && ($12 > $13 || $13 > $14 || $15 < 1)' "$dir/c/pareto.csv" | wc -l)" = 0

# Device bytes are those of the textures: of a level, floats hold more than codes, codes more than one byte, that more than none.
bytes_fall() { [ "$1" -gt "$2" ] && [ "$2" -gt "$3" ] && [ "$3" -gt "$4" ]; }
device() { column "$dir/c/pareto.csv" device_bytes "shading_from=$1" level=0 step_voxels=1 filter=moments | sed -n 1p; }
check device_bytes_follow_the_textures bytes_fall "$(device float)" "$(device snorm)" "$(device palette-254)" "$(device on-the-fly)"
check stored_bytes_are_those_of_files test "$(column "$dir/c/pareto.csv" stored_bytes shading_from=snorm level=0 step_voxels=1)" = $((20 * 28 * 17 * (2 + 3)))

# Finer steps are closer to the converged reference: the planted fault is a table in which they are not.
finer_is_better() {
    awk -F, 'NR > 1 && $4 == 0 && $1 ~ /float/ {e[$10] = $21} END {exit !(e["0.25"] < e[1])}' "$1"
}
check a_finer_step_has_a_smaller_error finer_is_better "$dir/c/pareto.csv"
awk -F, -v OFS=, 'NR > 1 {$10 = $10 == 1 ? 0.25 : 1} 1' "$dir/c/pareto.csv" >"$dir/swapped.csv"
notice swapped_steps_are_noticed finer_is_better "$dir/swapped.csv"

# The fronts in the table, found again from its figures: nothing beats them, and everything else is beaten. The planted fault
# is a table in which a beaten setting is called on the front.
fronts_hold() { python3 "$top/tests/fronts.py" "$1"; }
check the_fronts_are_right fronts_hold "$dir/c/pareto.csv"
awk -F, -v OFS=, 'NR > 1 && !done && $25 == 0 {$25 = 1; done = 1} 1' "$dir/c/pareto.csv" >"$dir/forged.csv"
notice a_beaten_setting_on_the_front_is_noticed fronts_hold "$dir/forged.csv"

# A setting's command gives its error again, whatever the axis: one of each kind is run. Both renders are of the same program
# on the same machine; palettes go through text, and bricks through another layout of the cache: 1e-6 of the error is 1/255^2.
# The planted fault is the command of another step.
expect every_axis_is_charted 0 all_axes --with gl --levels 2 --steps 1 --codes fit,cube --filters moments,naive --estimators central,sobel --plans 16/255 --json -o "$dir/a"
check without_a_budget_none_is_skipped grep -q '"skipped_count": 0,' "$dir/out"
rendered_error() { # COMMAND: the RMSE of its image to the chart's reference
    (cd "$top" && PATH="$(dirname "$ISOSHADE"):$PATH" && eval "${1/setting.exr/$dir/setting.exr}" --quiet >/dev/null &&
        json_number <(isoshade compare "$dir/setting.exr" "$dir/a/reference.exr" --json) rmse)
}
same_error() { python3 -c 'import sys; a, b = map(float, sys.argv[1:]); sys.exit(not abs(a - b) <= 1e-6)' "$1" "$2"; }
again() { # NAME COLUMN=VALUE ...
    local name=$1 command error
    shift
    command=$(column "$dir/a/pareto.csv" command "$@" | sed -n 1p)
    error=$(column "$dir/a/pareto.csv" rmse "$@" | sed -n 1p)
    check "the_command_of_${name}_gives_its_error_again" same_error "$(rendered_error "$command")" "$error"
}
again a_code shading_from=cube level=0 estimator=central
again floats_of_another_filter shading_from=float level=1 filter=naive tf=original
again another_estimator estimator=sobel shading_from=fit level=1 filter=moments tf=original
again a_palette shading_from=palette-254 level=0 estimator=central
again on_the_fly shading_from=on-the-fly level=1 quadrature=preintegrated
again flipped_directions shading_from=flipped level=1
again an_adapted_tf tf=adapted shading_from=fit
again a_table_over_two_values tf=deviation
again a_plan plan_error=0.0627451
other=$(column "$dir/a/pareto.csv" command shading_from=cube level=0 estimator=central | sed 's/--step 1/--step 2/' | sed -n 1p)
notice the_command_of_another_step_is_noticed same_error "$(rendered_error "$other")" \
    "$(column "$dir/a/pareto.csv" rmse shading_from=cube level=0 estimator=central | sed -n 1p)"
expect the_reference_is_a_renderer_of_the_chart 0 chart --with reference --levels 1 --steps 1 -o "$dir/a"
again the_reference shading_from=snorm
# The named one, as it is printed: it meets what is wanted.
expect a_flip_is_wanted 0 chart --levels 1 --steps 1,0.5 --metric flip --want 0.02 -o "$dir/a"
check flip_is_the_error_of_the_chart grep -q '^fastest with flip <= 0.02' "$dir/out"
command=$(grep -A1 '^fastest' "$dir/out" | tail -n 1)
flip_of() { rendered_error "$1" >/dev/null && "$ISOSHADE" compare "$dir/setting.exr" "$dir/a/reference.exr" --max-flip "$2" >/dev/null; }
check what_is_printed_meets_what_is_wanted flip_of "$command" 0.02
# Which of the good settings is the fastest is for the machine to say; the planted fault is twice the largest step.
notice a_worse_setting_is_noticed flip_of "$(sed -E 's/--step [0-9.]+/--step 2/' <<<"$command")" 0.002

# Pre-integrated settings and plans double the two steps of level 0's codes, floats, flipped, palettes and on the fly, and add two
# plans for each step; a plan for a larger error has fewer bytes or as many, and holds less than every voxel of level 0.
expect pre_integration_and_plans_are_charted 0 chart --levels 1 --steps 1,0.5 --codes snorm --quadratures midpoint,preintegrated --plans 8/255,1/255 -o "$dir/c2"
check both_quadratures_and_plans_are_there test "$(wc -l <"$dir/c2/pareto.csv")" = $((1 + 2 * 2 * 6 + 2 * 2))
check pre_integrated_settings_are_named grep -q 'gl; level 0; snorm; step 0.5 pre-integrated' "$dir/c2/pareto.csv"
plans_shrink() { awk -F, '/plan for/ {b[$2 ~ /0.031/ ? 1 : 0] = $17; e[$2 ~ /0.031/ ? 1 : 0] = $21} END {exit !(b[1] <= b[0] && e[0] <= e[1] && b[0] > 0)}' "$1"; }
check a_plan_for_less_error_has_more_bytes_and_less_error plans_shrink "$dir/c2/pareto.csv"

# The start of another program is not the time of its frame.
expect povray_is_a_setting_of_the_chart 0 chart --levels 1 --steps 1 --with povray -o "$dir/c2"
check povray_has_one_line grep -q '^povray: [a-z]*,povray; level 0; ' "$dir/c2/pareto.csv"
check its_start_is_told_apart awk -F, 'NR == 2 {exit !($12 > 0 && $16 > $12 && $17 > 20 * 28 * 17 * 5)}' "$dir/c2/pareto.csv"
expect processor_time_is_taken 0 chart --levels 1 --steps 1 --with gl,povray --processor-time --bytes stored -o "$dir/c2"
check the_table_says_so test "$(column "$dir/c2/pareto.csv" time_kind | sort -u)" = processor
check frames_near_the_front_are_timed_again awk -F, 'NR > 1 && $15 > 5 {++n} END {exit !(n > 0)}' "$dir/c2/pareto.csv"
check stored_bytes_are_those_of_the_chart diff <(column "$dir/c2/pareto.csv" bytes) <(column "$dir/c2/pareto.csv" stored_bytes)
expect the_processor_time_of_cycles_is_not_known 2 chart --levels 1 --steps 1 --with cycles --processor-time -o "$dir/n"
expect a_program_that_is_asked_for_has_to_be_there 7 env ISOSHADE_POVRAY=/nowhere "$ISOSHADE" chart "$dir/v.nrrd" --scene $scene --size 8 --with povray -o "$dir/n" -q
export ISOSHADE_POVRAY=/nowhere ISOSHADE_BLENDER=/nowhere
expect a_program_of_the_default_may_be_missing 0 all_axes --levels 1 --steps 1 --budget 0.001 -o "$dir/c2"
check what_is_left_out_is_said grep -q '^left out: cycles: ' "$dir/out"
unset ISOSHADE_POVRAY ISOSHADE_BLENDER

sed 's/#0072b2/#123456/; s/Helvetica Neue/Some Font/' "$dir/c/style.gp" >"$dir/mine.gp"
expect a_style_can_be_given 0 chart --levels 1 --steps 1 --style "$dir/mine.gp" --json -o "$dir/c"
check the_color_of_the_style_is_used grep -q 'rgb( 18,  52,  86)' "$dir/c/pareto.svg"
check the_font_of_the_style_is_used grep -q 'Some Font' "$dir/c/pareto.svg"
check the_chart_follows_its_style_by_gnuplot_alone bash -c "cd '$dir/c' && sed -i 's/#123456/#654321/' style.gp && ! LC_ALL=C.UTF-8 gnuplot pareto.gp 2>&1 | grep . && grep -q 'rgb(101,  67,  33)' pareto.svg"
has_keys json_has "$dir/out" schema command options machine versions cases skipped_count untried milliseconds milliseconds_median setup_milliseconds device_bytes rmse on_time_front on_bytes_front
rm -r "$dir/c" # what was drawn again is not isoshade's any more, and would not be replaced
expect an_error_that_no_setting_has_is_exit_1 1 chart --levels 1 --steps 1 --want 1e-9 -o "$dir/c"
check the_nearest_is_named grep -q '^none has rmse <= 1e-09; the nearest: gl; level 0' "$dir/out"
check the_chart_is_there_all_the_same test -s "$dir/c/pareto.svg"
expect a_spent_budget_leaves_one_setting 0 chart --levels 1 --steps 1,0.5 --budget 0.001 -o "$dir/c"
check it_is_the_only_one test "$(wc -l <"$dir/c/pareto.csv")" = 2
check it_is_a_usual_one grep -q ',gl; level 0; snorm; step 1,' "$dir/c/pareto.csv"
check what_was_skipped_is_said grep -q 'settings did not fit into 0.001 s; none measured with: .*gl: float' "$dir/out"
expect a_budget_that_ends_before_what_is_wanted_is_exit_1 1 chart --levels 1 --steps 2,0.5 --want 1e-3 --budget 0.001 -o "$dir/c"
check the_nearest_so_far_is_named grep -q '^none has rmse <= 0.001; the nearest: gl; level 0; snorm; step 2' "$dir/out"
check and_what_was_not_tried grep -q 'did not fit into 0.001 s; none measured with: .*step 0.5' "$dir/out"
expect without_a_budget_it_is_found 0 chart --levels 1 --steps 2,0.5 --want 1e-2 --budget 0 -o "$dir/c"
for bad in -1 1e9 nan; do
    expect "budget_$bad"_is_refused 2 chart --levels 1 --steps 1 --budget="$bad" -o "$dir/n"
done
mkdir "$dir/user" && touch "$dir/user/file"
expect a_folder_of_the_user_is_kept 3 chart --levels 1 --steps 1 -o "$dir/user"
check its_file_is_there test -e "$dir/user/file"
for bad in 0 2 -1 x 1/ 1/0 nan; do
    expect "want_$bad"_is_refused 2 chart --want="$bad" -o "$dir/n"
done
for bad in 0 1, ,1 x 1x nan; do
    expect "steps_$bad"_is_refused 2 chart --steps="$bad" -o "$dir/n"
done
for bad in "metric psnr" "bytes some" "tfs mine" "codes oct24" "filters moments,magic" "quadratures simpson" "estimators guess" "with gl,vulkan"; do
    expect "an_unknown_${bad%% *}_is_refused" 2 chart --${bad%% *} "${bad#* }" -o "$dir/n"
done
for bad in 0 2 1/0 x 1/255, none,1/255; do
    expect "plans_$bad"_is_refused 2 chart --plans="$bad" -o "$dir/n"
done
# Inputs that the commands need are refused, not ignored.
render() { "$ISOSHADE" render "$@" --scene $scene --size 8 -o "$dir/r.exr" -q; }
"$ISOSHADE" build "$dir/v.nrrd" --levels 1 -o "$dir/v.iso" -q >/dev/null
expect another_code_needs_floats 2 render "$dir/v.iso" --code snorm
expect the_code_of_the_build_needs_none 0 render "$dir/v.iso" --code fit
expect a_pyramid_keeps_its_gradients 2 render "$dir/v.iso" --estimator sobel
expect a_plan_has_levels_of_its_own 2 render "$dir/v.nrrd" --plan-error 1/255 --level 1
expect a_plan_or_a_cache 2 render "$dir/v.nrrd" --plan-error 1/255 --cache-bytes 1e6
expect an_output_is_needed 2 chart
check no_folder_is_left test -z "$(find "$dir" -maxdepth 1 -name '.*-*')"
exit $failed
