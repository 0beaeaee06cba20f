# SPDX-License-Identifier: MIT
"""Puts files of one pyramid into another of the same size, and their checksums into its description.

    swap_levels.py FROM.iso INTO.iso KEY:LEVEL ...       KEY: scalar, codes, directions, magnitude

What a careless copy leaves, or a careful forger: every file is as pyramid.json says.
"""
import json
import shutil
import sys

from read_iso import write_description

source, target = sys.argv[1:3]
theirs, ours = (json.load(open(f"{d}/pyramid.json")) for d in (source, target))
for word in sys.argv[3:]:
    key, level = word.split(":")
    entry, taken = ours["levels"][int(level)], theirs["levels"][int(level)]
    entry["files"][key] = taken["files"][key]
    if key == "scalar":
        entry["min"], entry["max"] = taken["min"], taken["max"]
    shutil.copy(f"{source}/{taken['files'][key]['name']}", target)
write_description(f"{target}/pyramid.json", ours)
