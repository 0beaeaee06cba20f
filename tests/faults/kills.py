#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Commands are killed (SIGKILL) at random instants, and run again. What was there before is whole or replaced by what is right;
the second run ends well, with the bytes of an undisturbed run, and leaves nothing of the first.

  tests/faults/kills.py [--count N] [--seed S] [--only WORDS] [--jobs N]

Prints a line a command: kills that came before its end, those that left something unfinished, and what was wrong."""
import argparse
import collections
import concurrent.futures
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import time

from world import COMMANDS, World, environment, listing, words

KILLED = ["make", "make gzip", "build", "build again", "build --resume", "render reference", "tf adapt", "tf show", "palette",
          "plan", "export vdb", "export nanovdb", "export povray", "export pbrt", "export paraview", "view",
          "report diff --accept", "report diff", "figure report", "render gl", "chart", "validate", "render povray",
          "render cycles", "export blender"]


def start(command, here, w, arguments=None):
    return subprocess.Popen(words(arguments or COMMANDS[command][1]), cwd=f"{here}/w", stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment(f"{here}/t", w.home))


def seconds_of(w, command):
    taken = []
    for _ in range(3):
        here = w.folder(command)
        begin = time.monotonic()
        start(command, here, w).wait()
        taken.append(time.monotonic() - begin)
        shutil.rmtree(here)
    return statistics.median(taken)


def broken(w, command, here):
    """After a kill: what is there under a name of its own is old or right. Names that begin with a point are not finished."""
    right, before, files = w.right[command], w.right[command]["before"], listing(f"{here}/w")
    shown = [n for n in files if not n.startswith((".isoshade-", ".")) or n in before]
    tops = {n.split("/")[0] for n in shown} | {n.split("/")[0] for n in before if not n.startswith(".")}
    for top in sorted(tops):
        def part(all_of):
            return {n: v for n, v in all_of.items() if n.split("/")[0] == top}
        there = part(files)
        if top.startswith(".") or there == part(before) or (command == "validate" and top == "o.work"):
            continue # the last is what --resume goes on from
        if set(there) != set(part(right["files"])):
            return f"{top} is in parts after the kill"
        if any(v != right["files"][n] and n not in right["loose"] for n, v in there.items()):
            return f"{top} is neither old nor right after the kill"
    return None


def kill_once(w, command, moment):
    here = w.folder(command)
    child = start(command, here, w)
    try:
        child.wait(timeout=moment)
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGKILL)
    code = child.wait()
    left = os.listdir(f"{here}/t") or [n for n in os.listdir(f"{here}/w") if n.startswith((".isoshade-", ".o"))]
    why = broken(w, command, here)
    # Another run puts all right. A build or a validation goes on where it was, or begins again.
    arguments = COMMANDS[command][1]
    if command.startswith(("build", "validate")) and "--resume" not in arguments and random.Random(moment).random() < 0.5:
        arguments += " --resume"
    if not why:
        again, _, said = w.run(command, here, arguments=arguments)
        why = f"the second run ends with {again}: {said[-1:]}" if again != 0 else w.is_right(command, here)
    # Programs that were ended with the killed run may take a moment.
    for _ in range(20):
        rest = os.listdir(f"{here}/t")
        if why or not rest:
            break
        time.sleep(0.05)
    if not why and rest:
        why = f"{rest[0]} in TMPDIR after the second run"
    shutil.rmtree(here, ignore_errors=True)
    return code == -signal.SIGKILL, bool(left), why


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--count", type=int, default=200)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--only", default="")
    p.add_argument("--jobs", type=int, default=os.cpu_count())
    a = p.parse_args()
    w, findings, sums = World(), 0, collections.Counter()
    print(f"{'command':<18}{'runs':>6}{'killed':>8}{'unfinished':>12}{'wrong':>7}{'s':>6}", flush=True)
    try:
        for command in KILLED:
            if a.only and command not in a.only.split(","):
                continue
            begin = time.time()
            w.learn(command)
            all_of_it, dice, row = seconds_of(w, command), random.Random(f"{a.seed} {command}"), collections.Counter()
            moments = [dice.uniform(0, 1.05 * all_of_it) for _ in range(a.count)]
            with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
                for moment, (killed, left, why) in zip(moments, pool.map(lambda m: kill_once(w, command, m), moments)):
                    row.update(runs=1, killed=killed, unfinished=left, wrong=bool(why))
                    if why:
                        print(f"    {command} at {moment:.4f} s: {why}", flush=True)
            sums.update(row)
            findings += row["wrong"]
            print(f"{command:<18}{row['runs']:>6}{row['killed']:>8}{row['unfinished']:>12}{row['wrong']:>7}"
                  f"{time.time() - begin:>6.0f}", flush=True)
        print(f"{'all':<18}{sums['runs']:>6}{sums['killed']:>8}{sums['unfinished']:>12}{sums['wrong']:>7}")
    finally:
        w.close()
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
