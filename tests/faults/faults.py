#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Each call of a command fails once: allocations, system calls on files, starts of processes. The outcome has to be the right
result, or one line of error and the documented exit code, with nothing left and nothing broken.

  tests/faults/faults.py [--only WORDS] [--kinds KIND,..] [--sample N] [--seed S] [--depth N] [--jobs N] [--verbose]

A call has a site: its innermost return addresses (--depth). Each site is visited once, in the first command of the
table that comes there; --sample takes N of each command at random, of all kinds alike. Prints a line a command, and a line a finding."""
import argparse
import collections
import concurrent.futures
import errno
import itertools
import os
import random
import shutil
import subprocess
import sys
import time

import world
from world import COMMANDS, KINDS, State, World

HOW = {"memory": [errno.ENOMEM], "read": [errno.EIO, errno.EINTR, 0], "write": [errno.ENOSPC, errno.EIO, errno.EINTR, 0],
       "open": [errno.EMFILE, errno.EIO, errno.EINTR], "rename": [errno.EIO], "sync": [errno.EIO], "make": [errno.ENOSPC],
       "look": [errno.EIO], "close": [errno.EIO], "start": [errno.EAGAIN]}
# The exit codes of `isoshade --help`: a file (3), memory (6), a program or device that is missing (7) or failed (8). Where it
# cannot be told what a name stands for, it is none of what is wanted (2, 4).
CODES = {"memory": {6}, "read": {3}, "write": {3}, "open": {3, 7, 8}, "rename": {3}, "sync": {3}, "make": {3},
         "look": {2, 3, 4, 7, 8}, "close": {3}, "start": {6, 8}}
# Where Mesa cannot read what it needs there is no device.
MISSING = {"read": {"render gl", "chart", "validate", "plan"}}


def codes_of(command, kind):
    return CODES[kind] | ({7} if command in MISSING.get(kind, ()) else set())


def name_of(how):
    return "short" if how == 0 else errno.errorcode[how]


def place(frames, depth=6):
    """The frames as people read them."""
    by_module = collections.defaultdict(list)
    for module, offset in frames[:depth]:
        by_module[module].append(offset)
    said = []
    for module, offset in frames[:depth]:
        if module.startswith("isoshade"):
            line = subprocess.run(["addr2line", "-fsCe", world.ISOSHADE, hex(offset - 1)], capture_output=True, text=True)
            function, where = (line.stdout.splitlines() + ["?", "?"])[:2]
            said.append(f"{function} ({where})")
        else:
            said.append(module)
    return " < ".join(said)


def is_foreign(frames):
    """Was the call made by a library for itself? Those of C and C++ ask for their callers."""
    for module, _ in frames[1:]: # the first is the program's malloc(), src/cli/memory.c
        if not module.startswith(("libc.so", "libstdc++", "libm.so")):
            return not module.startswith("isoshade")
    return True


class Trial:
    def __init__(self, command, kind, number, how):
        self.command, self.kind, self.number, self.how = command, kind, number, how

    def __str__(self):
        return f"{self.command}: {self.kind} {self.number} {name_of(self.how)}"


def judge(w, t, here, code, out, err):
    """(outcome, why): right, told, or a fault of ours."""
    right = w.right[t.command]
    if code == "hangs":
        return "HANGS", ""
    if code < 0:
        return "CRASHES", f"signal {-code}"
    left = os.listdir(f"{here}/t")
    if left:
        return "LEFT", f"{left[0]} in TMPDIR, exit code {code}"
    if code == 0:
        why = w.is_right(t.command, here)
        if not why and right["out"] is not None and out != right["out"]:
            why = "stdout differs"
        if why:
            return "WRONG", f"exit code 0, but {why}" + (f"; it said: {err[0]}" if err else "")
        return "right", ""
    why = w.is_untouched(t.command, here, code)
    if why and w.is_right(t.command, here):
        return "LEFT", f"exit code {code}, {why}"
    if code not in codes_of(t.command, t.kind):
        return "CODE", f"exit code {code}: {err[-1] if err else ''}"
    if len([line for line in err if line]) != 1:
        return "LINES", f"exit code {code}, {len(err)} lines on stderr: {' | '.join(err[:4])}"
    if t.command == "build --resume": # what was there before is still there to go on with
        again, _, said = w.run(t.command, here)
        why = f"the next run ends with {again}: {said}" if again != 0 else w.is_right(t.command, here)
        if why:
            return "LOST", why
    if out and right["out"] != out and not all(line in (right["out"] or out) for line in out):
        return "OUTPUT", f"exit code {code}, stdout: {out[0]}"
    return "told", ""


def attempt(w, t, library):
    here = w.folder(t.command)
    path = f"{here}/state"
    code, out, err = w.run(t.command, here, limit=120, FAULTS_LEAST=os.environ.get("LEAST", "0"), FAULTS_STATE=path, FAULTS_KIND=t.kind, FAULTS_HOW=str(t.how),
                           FAULTS_AT=str(t.number), LD_PRELOAD=library)
    state = State(path)
    outcome, why = judge(w, t, here, code, out, err)
    # What is all made, and cannot be put in place, is made again: its last step removes the notes to go on by.
    if outcome == "LEFT" and why.endswith(".o.iso.partial is lost") and "describe_and_commit" in place(state.frames, 16):
        outcome = "told"
    if not state.failed and outcome in ("right", "told"):
        outcome = "not met"
    shutil.rmtree(here, ignore_errors=True)
    return t, outcome, why, state.frames


def sites_of(w, command, library, depth, seen, kinds):
    here = w.folder(command)
    path = f"{here}/state"
    code, _, err = w.run(command, here, FAULTS_LEAST=os.environ.get("LEAST", "0"), FAULTS_STATE=path, FAULTS_DEPTH=str(depth), LD_PRELOAD=library)
    if code != 0:
        raise SystemExit(f"faults: {command} fails while its calls are counted: {code} {err}")
    state = State(path)
    new = []
    for kind, first, _, frames in state.sites:
        key = (kind, frames[:depth])
        if kind in kinds and key not in seen:
            seen.add(key)
            new.append((kind, first))
    shutil.rmtree(here)
    return sum(state.calls[k] for k in kinds), new


def sample_of(trials, count, dice):
    """As many of each kind as there are: most calls of some libraries are allocations."""
    of_kind = collections.defaultdict(list)
    for t in dice.sample(trials, len(trials)):
        of_kind[t.kind].append(t)
    turns = [t for turn in itertools.zip_longest(*of_kind.values()) for t in turn if t]
    return turns[:count]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--only", default="")
    p.add_argument("--kinds", default=",".join(KINDS))
    p.add_argument("--sample", type=int, default=0)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--depth", type=int, default=8)
    p.add_argument("--jobs", type=int, default=os.cpu_count())
    p.add_argument("--verbose", action="store_true")
    p.add_argument("--large", action="store_true", help="allocations of a mebibyte and more, of commands on larger volumes")
    a = p.parse_args()
    kinds, library, w, seen, findings = a.kinds.split(","), world.shim(), World(), set(), []
    if a.large:
        kinds = ["memory"]
        COMMANDS.clear()
        COMMANDS.update(world.LARGE)
        os.environ["LEAST"] = str(1 << 20)
    print(f"{'command':<18}{'calls':>8}{'sites':>7}{'faults':>8}{'right':>7}{'told':>7}{'library':>9}{'not met':>9}"
          f"{'findings':>10}{'s':>6}", flush=True)
    sums = collections.Counter()
    try:
        for command in COMMANDS:
            if a.only and not any(command.startswith(o) for o in a.only.split(",")):
                continue
            start = time.time()
            w.learn(command)
            calls, new = sites_of(w, command, library, a.depth, seen, kinds)
            trials = [Trial(command, kind, first, how) for kind, first in new for how in HOW[kind]]
            if a.sample and len(trials) > a.sample:
                trials = sample_of(trials, a.sample, random.Random(f"{a.seed} {command}"))
            counts = collections.Counter()
            with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
                for t, outcome, why, frames in pool.map(lambda t: attempt(w, t, library), trials):
                    if outcome not in ("right", "told", "not met"):
                        if t.kind == "memory" and is_foreign(frames):
                            outcome = f"library {outcome}"
                        else:
                            findings.append(t)
                        if a.verbose or not outcome.startswith("library"):
                            print(f"    {t}: {outcome}: {why}\n        at {place(frames)}", flush=True)
                    counts[outcome] += 1
            library_count = sum(n for o, n in counts.items() if o.startswith("library"))
            found = sum(n for o, n in counts.items() if o.isupper())
            row = {"calls": calls, "sites": len(new), "faults": len(trials), "right": counts["right"], "told": counts["told"],
                   "library": library_count, "not met": counts["not met"], "findings": found}
            sums.update(row)
            print(f"{command:<18}{row['calls']:>8}{row['sites']:>7}{row['faults']:>8}{row['right']:>7}{row['told']:>7}"
                  f"{row['library']:>9}{row['not met']:>9}{row['findings']:>10}{time.time() - start:>6.0f}", flush=True)
        print(f"{'all':<18}{sums['calls']:>8}{sums['sites']:>7}{sums['faults']:>8}{sums['right']:>7}{sums['told']:>7}"
              f"{sums['library']:>9}{sums['not met']:>9}{sums['findings']:>10}")
    finally:
        w.close()
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
