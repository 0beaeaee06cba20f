#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the fronts of a chart's pareto.csv against its own figures: fronts.py FILE.csv. Of settings that are equal to the
digits of the table, some may be on the front and some not."""
import csv
import sys

with open(sys.argv[1], newline="") as file:
    rows = list(csv.DictReader(file))
def check(rows, cost, flag):
    found = 0
    points = [(float(r[cost]), float(r["error"])) for r in rows]
    for row, (c, e) in zip(rows, points):
        beaten = any((a <= c and b < e) or (a < c and b <= e) for a, b in points)
        equal = points.count((c, e)) > 1
        if (row[flag] == "1") == beaten and not (equal and not beaten):
            print(f"{row['scene']}: {row['setting']}: {flag} is {row[flag]}, beaten: {beaten}", file=sys.stderr)
            found += 1
    return found


wrong = 0 if rows else 1
for scene in {r["scene"] for r in rows}:
    here = [r for r in rows if r["scene"] == scene]
    for cost, flag in (("milliseconds", "time_front"), ("bytes", "bytes_front")):
        wrong += check(here, cost, flag)
        for renderer in {r["renderer"] for r in here}:
            wrong += check([r for r in here if r["renderer"] == renderer], cost, f"renderer_{flag}")
sys.exit(wrong > 0)
