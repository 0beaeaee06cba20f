#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The commands that read a report, figure and report diff: exit codes, messages, and what they leave.
. "$(dirname "$0")/lib.sh"
report() { # folder, rmse
    mkdir -p "$1"
    cat >"$1/report.json" <<END
{"schema": "isoshade.validate/1", "command": "isoshade validate v.nrrd", "agreement": [
    {"scene": "s", "level": 0, "a": "reference", "renderer": "gl", "tier": "tight", "rmse": $2, "max_abs": 0.01,
     "limits": {"rmse": 0.01, "max_abs": 0.02}, "verdict": "agree"}],
 "consistency": [{"method": "moments", "level": 1, "flip_mean": 0.1}]}
END
}
report "$dir/one" 0.001
report "$dir/worse" 0.002

expect without_a_baseline_nothing_is_accepted 3 "$ISOSHADE" report diff "$dir/base.json" "$dir/one" --worse
check the_message_says_how grep -q -- --accept "$dir/err"
check and_none_is_written test ! -e "$dir/base.json"
expect an_update_accepts 0 "$ISOSHADE" report diff "$dir/base.json" "$dir/one" --accept
expect the_same_report_is_good 0 "$ISOSHADE" report diff "$dir/base.json" "$dir/one" --worse
scene=$top/refscenes/shells.scene.json
refuse a_scene_is_no_baseline 4 'shells.scene.json: its schema is "isoshade.scene/1", must be isoshade.validate/1' "$ISOSHADE" report diff "$scene" "$dir/one" --worse
refuse nor_a_report 4 'shells.scene.json: its schema is "isoshade.scene/1", must be isoshade.validate/1' "$ISOSHADE" report diff "$dir/base.json" "$scene" --worse
cp "$dir/base.json" "$dir/kept.json"
expect a_worse_figure_is_exit_1 1 "$ISOSHADE" report diff "$dir/base.json" "$dir/worse" --worse
check the_last_line_says_it grep -q '^Figures, verdicts or rows that are worse' "$dir/out"
check the_figure_is_named grep -q 'worse: rmse: 0.001 -> 0.002' "$dir/out"
check the_baseline_is_untouched cmp "$dir/base.json" "$dir/kept.json"
expect a_better_one_is_good 0 "$ISOSHADE" report diff "$dir/worse" "$dir/one" --worse
check and_says_so grep -q '^Nothing is worse than accepted' "$dir/out"
expect an_update_says_what_it_changes 0 "$ISOSHADE" report diff "$dir/kept.json" "$dir/worse" --accept
check the_change_is_named grep -q 'worse: rmse: 0.001 -> 0.002' "$dir/out"
refuse only_a_file_is_accepted 2 "must end in .json" "$ISOSHADE" report diff "$dir/kept" "$dir/worse" --accept
expect and_then_it_is_accepted 0 "$ISOSHADE" report diff "$dir/kept.json" "$dir/worse" --worse
check one_figure_is_one_line_of_the_file test "$(diff "$dir/base.json" "$dir/kept.json" | grep -c '^>')" = 1
expect a_wide_factor_allows_it 0 "$ISOSHADE" report diff "$dir/base.json" "$dir/worse" --worse --factor 20
expect json_is_printed 1 "$ISOSHADE" report diff "$dir/base.json" "$dir/worse" --worse --json
has_keys json_has "$dir/out" schema command options worse_count rows facts sentence verdict
expect a_factor_below_1_is_refused 2 "$ISOSHADE" report diff "$dir/base.json" "$dir/one" --worse --factor 0.5
expect a_report_is_a_baseline 0 "$ISOSHADE" report diff "$dir/one/report.json" "$dir/one" --worse
for rows in '' ', "agreement": []' ', "agreement": {"a": {}}' ', "agreement": null'; do
    echo "{\"schema\": \"isoshade.validate/1\"$rows}" >"$dir/empty.json"
    refuse "a_baseline_without_rows_is_refused" 4 "has no rows" "$ISOSHADE" report diff "$dir/empty.json" "$dir/one" --worse
done
expect a_folder_without_report_is_refused 3 "$ISOSHADE" report diff "$dir/base.json" "$dir" --worse

expect a_report_without_pictures_gives_no_figure 5 "$ISOSHADE" figure "$dir/one" -o "$dir/f"
check no_figure_is_left test ! -e "$dir/f"
expect a_figure_needs_a_report 4 "$ISOSHADE" figure "$dir" -o "$dir/f"
check and_says_so grep -q 'is not a report, it has no report.json' err
expect an_unknown_figure_is_refused 2 "$ISOSHADE" figure "$dir/one" --kind photo -o "$dir/f"
expect a_figure_needs_an_output 2 "$ISOSHADE" figure "$dir/one"
check nothing_temporary_is_left test -z "$(find "$dir" -name '.*-*' ! -name .isoshade-files)"
exit $failed
