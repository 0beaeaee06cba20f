#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A chart that goes on after it was killed, and several scenes in one; its page, as a hand or a keyboard uses it.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
scene=refscenes/marschner-lobb.scene.json
column() { python3 "$top/tests/column.py" "$@"; }
fronts_hold() { python3 "$top/tests/fronts.py" "$1"; }
"$ISOSHADE" make marschner-lobb --size 12x14x11 -q -o "$dir/v.nrrd" || exit 1

# ---- going on: what is measured is kept, and is not measured again ----
args=(chart "$dir/v.nrrd" --scene $scene --size 24 --full-paths -q --budget 0 --threads 1 --with reference --levels 2 --steps 1,0.5
    --quadratures midpoint --plans none --estimators central --filters moments --codes snorm)
going() { "$ISOSHADE" "${args[@]}" "$@"; }
expect a_chart_in_one_go 0 going -o "$dir/whole"
"$ISOSHADE" "${args[@]}" -o "$dir/killed" >/dev/null 2>&1 &
child=$!
for try in $(seq 400); do # killed as soon as two settings are measured
    measured=$(grep -cs '"setting"' "$dir/.killed.partial/settings.jsonl")
    [ "${measured:-0}" -lt 2 ] || break
    sleep 0.02
done
kill -9 $child
wait $child 2>/dev/null
check what_was_measured_is_kept test "$(grep -c '"setting"' "$dir/.killed.partial/settings.jsonl")" -ge 2
head -c -20 "$dir/.killed.partial/settings.jsonl" >"$dir/cut" && cp "$dir/cut" "$dir/.killed.partial/settings.jsonl" # half a line
# A planted error: were the setting measured again, it would not be in the result.
sed -i 's/"setting":"reference; level 1; snorm moments; step 1",\(.*\)"rmse":[0-9.e-]*/"setting":"reference; level 1; snorm moments; step 1",\1"rmse":0.777/' "$dir/.killed.partial/settings.jsonl"
cp -r "$dir/.killed.partial" "$dir/.planted.partial"
expect it_goes_on 0 going --resume -o "$dir/planted"
check what_is_kept_is_not_measured_again test "$(column "$dir/planted/pareto.csv" rmse "setting=reference; level 1; snorm moments; step 1")" = 0.777
check it_says_how_many_were_kept grep -qE '^[1-9][0-9]* settings were measured in an earlier run' "$dir/out"
# What another renderer drew, the planted error too, is drawn again.
cp -r "$dir/.killed.partial" "$dir/.other.partial"
sed -i 's/"renderer":"/&older /' "$dir/.other.partial/settings.jsonl"
expect it_goes_on_with_another_renderer 0 going --resume -o "$dir/other"
notice what_another_renderer_drew_is_drawn_again test "$(column "$dir/other/pareto.csv" rmse "setting=reference; level 1; snorm moments; step 1")" = 0.777
sed -i '/"setting":"reference; level 1; snorm moments; step 1"/d' "$dir/.killed.partial/settings.jsonl"
expect it_goes_on_without_the_plant 0 going --resume -o "$dir/killed"
settings() { python3 "$top/tests/column.py" "$1" setting | paste -d' ' - <(column "$1" rmse) <(column "$1" max_abs) <(column "$1" ssim) | sort; }
check the_resumed_chart_is_that_of_one_go diff <(settings "$dir/whole/pareto.csv") <(settings "$dir/killed/pareto.csv")
check so_is_its_reference cmp <(tail -c 3000 "$dir/whole/reference.exr") <(tail -c 3000 "$dir/killed/reference.exr")
expect a_finished_chart_goes_on_with_more_axes 0 going --steps 1,0.5,0.25 --resume -o "$dir/killed"
check its_old_settings_are_kept test "$(grep -oE '^[0-9]+ settings were measured in an earlier run' "$dir/out" | grep -oE '^[0-9]+')" = $(($(wc -l <"$dir/whole/pareto.csv") - 1))
refuse another_scene_is_not_gone_on_with 2 "--scene is not the same" "$ISOSHADE" chart "$dir/v.nrrd" --scene refscenes/shells.scene.json --size 24 --resume -q -o "$dir/killed"
check and_the_chart_stays test -s "$dir/killed/pareto.svg"

# ---- several scenes, a front for each and for each renderer; the page, in a browser that is started once ----
expect several_scenes_in_one_chart 0 going --scene $scene,refscenes/shells.scene.json --with gl,reference --tfs original --want 1/10 --viewer -o "$dir/s"
check each_setting_is_there_for_each_scene test "$(column "$dir/s/pareto.csv" setting scene=marschner-lobb.scene.json | sort)" = "$(column "$dir/s/pareto.csv" setting scene=shells.scene.json | sort)"
check fronts_of_scenes_and_renderers_are_right fronts_hold "$dir/s/pareto.csv"
awk -F, -v OFS=, 'NR > 1 && !done && $(NF - 1) == 1 {$(NF - 1) = 0; done = 1} 1' "$dir/s/pareto.csv" >"$dir/forged.csv"
notice a_setting_that_is_left_off_its_renderers_front_is_noticed fronts_hold "$dir/forged.csv"
check the_fastest_is_named_with_a_command_a_scene test "$(sed -n '/^fastest with rmse <= 0.1 in each scene/,/^smallest/p' "$dir/out" | grep -c -e '--scene refscenes')" = 2
check each_scene_has_a_row_of_panels test "$(grep -c '>bytes that the renderer holds<' "$dir/s/pareto.svg")" = 2
expect the_page_is_used 0 python3 "$top/tests/chart_page.py" "$dir/s/index.html"
for name in the_plot_has_every_setting pointing_shows_its_picture_and_command keys_go_along_the_front a_scene_is_chosen fronts_of_renderers_are_drawn \
    bytes_are_drawn it_links_to_the_viewer_at_its_level every_control_has_a_name dark_is_dark labels_are_whole; do
    check "$name" grep -qx "$name true" "$dir/out"
done
check the_page_fetches_nothing grep -qx 'fetched 0' "$dir/out"
check it_fits_a_telephone grep -qx 'wider_than_a_telephone false' "$dir/out"
check no_script_failed grep -qx "exceptions 0" "$dir/out"
exit $failed
