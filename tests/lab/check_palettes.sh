#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab palette: Table 1 of the paper, Figure 9, and bad usage.
. "$(dirname "$0")/../lib.sh"
expect the_table_has_all_methods 0 "$LAB" palette --seeds 1 --cycles 20 --steps 100 --json -q
check and_the_default_has_the_least_error python3 - out <<'PY'
import json, sys
rows = [r for r in json.load(open(sys.argv[1]))["ellipsoid"] if r["data"] == "ball" and r["entries"] in (254, 240)]
assert min(rows, key=lambda r: r["norm1"])["method"] == "kmeans" and {"anneal", "kmeans++", "faces"} < {r["method"] for r in rows}
PY
expect figure_9_is_drawn 0 "$LAB" palette --tessellation t.svg --entries 60 --cycles 5 --steps 200 -q
check the_drawing_is_svg grep -q '<svg ' t.svg
check each_of_90_edges_is_drawn_once test "$(grep -c L t.svg)" -le 90
expect an_odd_tessellation_is_refused 5 "$LAB" palette --tessellation t.svg --entries 61 -q
exit $failed
