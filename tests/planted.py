# SPDX-License-Identifier: MIT
"""The faults of test_external.c in doc/guide/numpy_renderer.py, alone and in pairs, and the mistakes that name them.

planted.py draw REQUESTS [all]: draws what is below REQUESTS (`isoshade scenes --write`) with the right program and with
each fault, alone and in one pair, or in all pairs. Writes a folder of pictures for each, and prints the folders.
planted.py judge REPORT: prints a line per folder that report.json lacks or names wrong. Exits 1 if there is one.
"""
import ast
import glob
import itertools
import json
import os
import pathlib
import re
import sys

import numpy as np

TOP = pathlib.Path(__file__).resolve().parent.parent


def load_faults():
    """Returns (what, from, to, check, mistake) of each row of the table in C, whose texts are Python's, too."""
    table = re.search(r"\} faults\[\] = \{\n(.*?)\n\};", (TOP / "tests/test_external.c").read_text(), re.S)[1]
    return ast.literal_eval("[" + re.sub(r"^    \{", "(", table, flags=re.M).replace("},", "),") + "]")


def plant(text, faults):
    """Returns the program with the faults; None if they change the same place."""
    for _, old, new, *_ in faults:
        if old not in text:
            return None
        text = text.replace(old, new, 1)
    return text


def draw(name, program, requests):
    code, save, here = compile(program, name, "exec"), np.save, os.getcwd()
    for request in requests:
        folder = pathlib.Path(here, name, pathlib.Path(request).parent.name)
        folder.mkdir(parents=True)
        os.chdir(os.path.dirname(request))
        sys.argv = [name, "request.json"]
        np.save = lambda file, picture: save(folder / file, picture)
        exec(code, {"__name__": "__main__"})
        os.chdir(here)
    np.save = save


def choose_pairs(text, faults):
    """Returns pairs that have each fault once, or twice. The first one is far from the sum of its parts."""
    pairs, count = [(1, 9)], len(faults)
    for i in range(count):
        others = [(i + step) % count for step in range(9, count)]
        if not any(i in pair for pair in pairs):
            pairs.append((i, next(k for k in others if plant(text, [faults[i], faults[k]]))))
    return pairs


def draw_all(requests, every):
    faults, text = load_faults(), (TOP / "doc/guide/numpy_renderer.py").read_text()
    pairs = itertools.combinations(range(len(faults)), 2) if every else choose_pairs(text, faults)
    for numbers in [(), *((i,) for i in range(len(faults))), *pairs]:
        program = plant(text, [faults[i] for i in numbers])
        if program:
            name = "-".join(["fault" if numbers else "right", *map(str, numbers)])
            draw(name, program, requests)
            print(name)


def judge(report):
    """A right renderer has no mistake; a wrong one has those of its faults and no others."""
    faults, root, good = load_faults(), json.loads(pathlib.Path(report).read_text()), True
    for name in root["renderers"]:
        if not name.startswith(("fault", "right")):
            continue
        numbers, said = [int(n) for n in name.split("-")[1:]], root.get("mistakes", {}).get(name, "")
        wanted = [faults[i][4] for i in numbers]
        names = {"as if " + ", and ".join(order) for order in itertools.permutations(wanted)} if wanted else {""}
        if said.split(" (explains ")[0] not in names:
            print(f"{name}: {said or 'no mistake'}; wanted {max(names) or 'none'}")
            good = False
    return good


if __name__ == "__main__":
    if sys.argv[1] == "draw":
        draw_all(sorted(glob.glob(os.path.abspath(sys.argv[2]) + "/*/request.json")), sys.argv[3:] == ["all"])
    else:
        sys.exit(not judge(sys.argv[2]))
