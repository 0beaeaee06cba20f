# SPDX-License-Identifier: MIT
"""Runs the command of each row of a report in the working folder, and prints those that do not end as the row says.

    report_commands.py REPORT [FOLDER]      FOLDER: run in this folder instead

A command compares with the row's limits: it ends with 1 if a figure of the row exceeds its limit, otherwise with 0."""
import json
import os
import subprocess
import sys

path = os.path.join(sys.argv[1], "report.json")
folder = sys.argv[2] if len(sys.argv) > 2 else "."
with open(path) as f:
    rows = [row for row in json.load(f)["agreement"] if row.get("command") and row["verdict"] != "not compared"]
wrong = 0
for row in rows:
    wanted = int(any(row.get(name, 0) > limit for name, limit in row["limits"].items()))
    ran = subprocess.run(["bash", "-c", row["command"]], cwd=folder, capture_output=True, text=True)
    if ran.returncode != wanted:
        wrong += 1
        print(f"exit {ran.returncode} instead of {wanted}: {row['command']}\n{ran.stderr[-500:]}")
print(f"{len(rows)} commands, {wrong} wrong")
sys.exit(wrong > 0 or not rows)
