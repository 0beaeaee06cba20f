#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What validation catches and what it leaves alone, and by how little: isoshade-lab power by the ray caster at few pixels.
. "$(dirname "$0")/../lib.sh"
power() { "$LAB" power --with gl -q "$@"; }

expect faults_are_caught_and_clean_scenes_left_alone 0 power --repetitions 2 --size 14 --json
check sixteen_faults_by_name test "$(grep -c '"caught": true' out)" = 16
check no_clean_scene_is_flagged test "$(grep -c '"flagged": 0' out)" = "$(grep -c '"flagged"' out)"
check a_scene_has_highlights_above_1 grep -q '"scenes_above_1": 1' out
# Every fault that changes a scene is seen by both gates there; and clipping is among them.
cat >seen.py <<'PY'
import json
faults = json.load(open("out"))["faults"]
assert all(g["rejected"] == g["comparisons"] == f["scenes_changed"] for f in faults for g in f["gates"])
assert any(f["fault"].startswith("radiance is clipped") and len(f["gates"]) == 2 for f in faults)
PY
check each_gate_sees_what_changes_a_scene python3 seen.py
expect the_table_is_printed 0 power --repetitions 2 --size 14
check with_the_confidence_of_its_rates grep -q 'clean scenes, gl lock-step: 0 of 2 flagged (a rate below 78 %, at 95 % confidence)' out
check and_nothing_wrong test "$(grep -c WRONG out)" = 0

# A constant with grain: a level is behind the simple way, and stays so when the volume is turned. No false alarm.
expect a_finding_is_no_false_alarm 0 power --random 1 --seed 1 --json
check it_is_counted grep -q '"worse_levels": 1' out

check the_sensitivity_has_a_chart power --sensitivity --repetitions 1 --size 10 -o sensitivity
check as_svg grep -q '</svg>' sensitivity/sensitivity.svg
# Eleven deviations by calibration, lock-step and limit.
check every_deviation_is_found_by_every_gate test "$(grep -c '^"' sensitivity/sensitivity.csv)" = 33
cat >order.py <<'PY'
import csv
rows = list(csv.DictReader(open("sensitivity/sensitivity.csv")))
of = {(r["deviation"], r["gate"]): float(r["median"]) for r in rows}
for d in {r["deviation"] for r in rows}:
    assert 0 < of[d, "gl lock-step"] < of[d, "gl limit"], d
assert of["the volume is shifted along all axes (voxel)", "gl limit"] < 0.25
PY
check lock_step_sees_less_than_a_limit_does python3 order.py
refuse an_output_without_a_chart_is_refused 2 "sensitivity" power --repetitions 1 -o no
refuse a_format_that_is_none_is_refused 2 "svg or pdf" power --sensitivity --format png -o no
refuse a_tiny_image_is_refused 2 "--size" power --size 4
exit $failed
