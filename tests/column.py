#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints a column of a CSV, a value a line: column.py FILE.csv COLUMN [COLUMN=VALUE ...] for the rows that have these values."""
import csv
import sys

path, column, *wanted = sys.argv[1:]
wanted = [word.split("=", 1) for word in wanted]
with open(path, newline="") as file:
    for row in csv.DictReader(file):
        if all(row[key] == value for key, value in wanted):
            print(row[column])
