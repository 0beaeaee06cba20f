#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The structure of C and C++ sources. All C files of all programs are named.

    structure.py unreached FILE ...   functions outside tests/ that nothing reaches. Calls are followed from main(), from
                                      functions without a prototype of ours, which others call, and from all text
                                      outside of functions, such as tables
    structure.py circles FILE ...     circles of files of one folder: each includes the next, the last the first.
                                      NAME.c and NAME.h count as one"""
import collections
import os
import re
import sys

COMMENT_OR_TEXT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
PROTOTYPE = re.compile(r"^[A-Za-z_][^;{}=#]*\([^;{}=]*\)[^;{}()=]*;", re.M)
FUNCTION = re.compile(r"^([A-Za-z_][^;{}=#]*?\b([A-Za-z_]\w*)\((?:[^;{}]*)\)[^;{}()=]*)\n\{\n(.*?)^\}$", re.M | re.S)
WORD = re.compile(r"[A-Za-z_]\w*")
PASTED = re.compile(r"(?:\b([a-z]\w*_)##)|(?:##(_\w+))")  # parts of names that a macro joins


def words(text):
    return set(WORD.findall(text))


def unreached(paths):
    """{name: file}."""
    uses, home, pasted = collections.defaultdict(set), {}, []
    reached, open_to_others, declared = {"main"}, set(), set()
    for path in paths:
        with open(path) as file:
            text = COMMENT_OR_TEXT.sub(lambda m: " " if m[0][0] == "/" else '""', file.read())
        prototypes = "".join(PROTOTYPE.findall(text))
        if path.endswith(("isoshade.h", ".cc")):
            reached |= words(text)
            continue
        for head, name, body in FUNCTION.findall(text):
            home.setdefault(name, path)
            uses[name] |= words(body) | (words(head) - {name})
            if path.endswith(".c") and not head.startswith("static"):
                open_to_others.add(name)
        declared |= words(prototypes)
        reached |= words(PROTOTYPE.sub("", FUNCTION.sub("", text)))
        pasted += PASTED.findall(text)
    for start, end in pasted:
        reached |= {name for name in home if start and name.startswith(start) or end and name.endswith(end)}
    reached |= open_to_others - declared
    ahead = list(reached)
    while ahead:
        new = uses.get(ahead.pop(), set()) - reached
        reached |= new
        ahead += new
    return {name: path for name, path in home.items() if name not in reached and not path.startswith("tests/")}


def circles(paths):
    """Sorted lists of names without suffix, each of which reaches all others of its list."""
    after = collections.defaultdict(set)
    for path in paths:
        name, folder = os.path.splitext(path)[0], os.path.dirname(path)
        with open(path) as file:
            for included in re.findall(r'^#include "(?:[\w/]*/)?(\w+)\.h"', file.read(), re.M):
                other = f"{folder}/{included}"
                if other != name and os.path.exists(other + ".h"):
                    after[name].add(other)

    def reach(name):
        seen, ahead = set(), [name]
        while ahead:
            new = after[ahead.pop()] - seen
            seen |= new
            ahead += new
        return seen

    reaches = {name: reach(name) for name in list(after)}
    around = {frozenset({name} | {other for other in reaches[name] if name in reaches.get(other, ())}) for name in reaches}
    return sorted(sorted(circle) for circle in around if len(circle) > 1)


if sys.argv[1] == "unreached":
    for name, path in sorted(unreached(sys.argv[2:]).items(), key=lambda item: item[::-1]):
        print(f"{path}: {name}")
else:
    for circle in circles(sys.argv[2:]):
        print(os.path.dirname(circle[0]) + ":", *map(os.path.basename, circle))
