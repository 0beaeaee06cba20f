#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Random pipelines on random volumes and scenes, disturbed: make, build, suggest, adapt, plan, export, render, validate, some
of whose calls fail (tests/faults/shim.c) and which are killed in the middle. Each pipeline runs once in peace. Then each of its
commands is disturbed, judged, and repeated until it succeeds: nothing that was there is lost, what is called finished is right,
what failed said so in one line with its code, and the end is byte by byte that of the run in peace.

  tests/pipelines.py [--count N] [--seed S] [--one K] [--jobs N]

Everything follows from the seed, which is printed; --one K repeats pipeline K alone, and tells its commands."""
import argparse
import collections
import concurrent.futures
import errno
import json
import os
import random
import shlex
import shutil
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "faults"))
import world  # noqa: E402
from faults import HOW, codes_of, name_of  # noqa: E402
from world import KINDS, State, World, listing  # noqa: E402

MADE = "ramp slab sphere shells plate marschner-lobb noise tubes balls constant".split()


def size(dice):
    """Small, and now and then of one voxel."""
    return "x".join(str(dice.choice([1, 2, dice.randint(3, 9), dice.randint(5, 20), dice.randint(5, 20)])) for _ in range(3))


def tf(dice):
    values = sorted(dice.uniform(0, 1) for _ in range(dice.randint(2, 7)))
    points = [dict(value=v, opacity=dice.choice([0, dice.random(), dice.random()]), **{c: dice.random() for c in "rgb"})
              for v in values]
    return {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": dice.choice([0.5, 1, 4]), "color_space": "linear",
            "points": points}


def scene(dice):
    direction = [dice.uniform(-1, 1) for _ in range(3)]
    return {"schema": "isoshade.scene/1", "image": {"width": dice.randint(4, 16), "height": dice.randint(4, 16)},
            "camera": {"projection": dice.choice(["perspective", "orthographic"]), "fit": True, "direction": direction,
                       "up": [0, 0, 1], "fov_y_deg": dice.randint(20, 60)},
            "lights": [{"direction": [dice.uniform(-1, 1), 0.5, 1], "space": dice.choice(["camera", "world"]), "intensity": 1}],
            "shading": {"ambient": 0.2, "diffuse": 0.8, "specular": dice.choice([0, 0.3]), "power": 20},
            "background": [dice.random()] * 3, "step_voxels": dice.choice([0.5, 1]), "tf": "t.tf.json"}


def pipeline(dice, folder):
    """Writes the scene into the folder; a list of commands, each with the outputs it makes."""
    with open(f"{folder}/t.tf.json", "w") as file:
        json.dump(tf(dice), file)
    with open(f"{folder}/a.scene.json", "w") as file:
        json.dump(scene(dice), file)
    levels = dice.randint(1, 3)
    steps = [f"make {dice.choice(MADE)} --size {size(dice)} {dice.choice(['', '--gzip '])}-o v.nrrd -q",
             f"build v.nrrd --levels {levels} --scalar-filter {dice.choice(['mean', 'gauss', 'damped'])} "
             f"--direction-filter {dice.choice(['moments', 'eq1', 'tensor', 'naive'])} "
             f"--code {dice.choice(['fit', 'snorm', 'shell', 'free', 'cube', 'region48'])} -o v.iso -q"]
    later = [
        f"tf adapt v.iso --tf t.tf.json --level {dice.randint(1, 2)} -o adapted.tf.json -q",
        "tf suggest v.nrrd -o suggested.tf.json -q",
        "tf convert t.tf.json t.csv",
        f"plan v.nrrd --scene a.scene.json --size 12 --error {dice.choice([0.02, 0.1])} -o p.json -q",
        f"palette v.nrrd --entries {dice.randint(2, 9)} -o p.csv -q",
        f"render v.iso --scene a.scene.json --with reference --quadrature midpoint --level {dice.randint(0, levels - 1)} -o a.exr --png a.png -q",
        "render v.iso --scene a.scene.json --with gl -o gl.exr -q",
        "export v.iso --scene a.scene.json --to vdb -o v.vdb -q",
        "export v.iso --scene a.scene.json --to nanovdb -o v.nvdb -q",
        "export v.iso --scene a.scene.json --to povray -o povray -q",
        "export v.iso --scene a.scene.json --to pbrt -o pbrt -q",
        "export v.iso --scene a.scene.json --to paraview -o paraview -q",
        "view v.iso --scene a.scene.json --size 12 -o v.html -q",
        "info v.iso --verify -q",
    ]
    steps += dice.sample(later, dice.randint(2, 5))
    if dice.random() < 0.2:
        steps.append("validate v.nrrd --scene a.scene.json --with reference,gl --quick --levels 1 --size 12 -o report -q")
    return steps


class Runner:
    def __init__(self, w, library, tell):
        self.w, self.library, self.tell = w, library, tell

    def run(self, here, step, **more):
        return self.w.run(None, here, arguments=step, limit=120, **more)

    def fresh(self, name):
        here = f"{self.w.base}/{name}"
        os.makedirs(f"{here}/w")
        os.makedirs(f"{here}/t")
        return here

    def in_peace(self, dice, name):
        """Each command, its exit code, what it printed, and what is there after it; its calls, which are counted."""
        here = self.fresh(name)
        steps, plan = [], pipeline(dice, f"{here}/w")
        for step in plan:
            before = listing(f"{here}/w")
            code, out, err = self.run(here, step, FAULTS_STATE=f"{here}/state", LD_PRELOAD=self.library)
            calls = State(f"{here}/state").calls
            os.remove(f"{here}/state")
            files = listing(f"{here}/w")
            loose = {}
            if step.startswith("validate"):
                loose = {n: {} for n in files if n.startswith("report/") and files[n] != "folder"}
            steps.append(dict(step=step, code=code, before=before, files=files, loose=loose, calls=calls, err=err, out=None))
            if code == "hangs" or (isinstance(code, int) and code < 0):
                raise AssertionError(f"{step}: {code} in peace")
        return here, steps

    def fault(self, dice, calls):
        kinds = [k for k in KINDS if calls[k] > 0]
        kind = dice.choice(kinds)
        how = -9 if dice.random() < 0.3 else dice.choice(HOW[kind])
        return kind, dice.randint(1, calls[kind]), how

    def disturbed(self, dice, name, steps):
        """The same once more; what happened: a Counter of outcomes."""
        here, counts = self.fresh(name), collections.Counter()
        for n in ("t.tf.json", "a.scene.json"):
            shutil.copy(f"{self.w.base}/{name[:-1]}a/w/{n}", f"{here}/w/{n}")
        for right in steps:
            self.w.right[name] = right
            for tries in range(dice.choice([0, 1, 1, 2])):
                kind, number, how = self.fault(dice, right["calls"])
                step = right["step"] + (" --resume" if right["step"].startswith("build") and dice.random() < 0.5 else "")
                earlier = listing(f"{here}/w")
                code, _, err = self.run(here, step, FAULTS_STATE=f"{here}/state", FAULTS_KIND=kind, FAULTS_AT=str(number),
                                        FAULTS_HOW=str(how), LD_PRELOAD=self.library)
                met = State(f"{here}/state").failed
                os.remove(f"{here}/state")
                counts[self.judge(here, name, right, earlier, kind, how, code, err)] += 1
                if self.tell:
                    print(f"    {step}\n        {kind} {number} {'killed' if how < 0 else name_of(how)}"
                          f"{'' if met else ' (not met)'}: {code} {' '.join(err)[:150]}")
            step = right["step"] + (" --resume" if right["step"].startswith("build") and dice.random() < 0.5 else "")
            code, _, err = self.run(here, step)
            if code != right["code"]:
                raise AssertionError(f"{step}: ends with {code} after the faults, {right['code']} in peace: {err}")
            why = self.w.is_right(name, here)
            if why or os.listdir(f"{here}/t"):
                raise AssertionError(f"{step}: after the faults {why or 'something is left in TMPDIR'}")
        del self.w.right[name]
        return counts

    def judge(self, here, name, right, earlier, kind, how, code, err):
        if code == "hangs":
            raise AssertionError(f"{right['step']}: hangs after {kind} {name_of(how)}")
        if how < 0 and code == -9:
            # A file with its final name is old or right, except for the work that validate continues from.
            files = listing(f"{here}/w")
            for n in files:
                if not any(part.startswith((".", "report.work")) for part in n.split("/")) and \
                        files[n] not in (right["before"].get(n), right["files"].get(n)) and n not in right["loose"]:
                    raise AssertionError(f"{right['step']}: {n} is broken after a kill at {kind}")
            lost = [n for n in right["before"] if n not in files]
            if lost:
                raise AssertionError(f"{right['step']}: {lost[0]} is lost after a kill at {kind}")
            return "killed"
        what = f"{right['step']}: {kind} {name_of(how) if how >= 0 else 'killed'}: exit code {code}"
        if code == right["code"]:
            # A killed run's temporaries stay where the folder could not be listed; they go with the next run.
            stale = [n for n in earlier if any(part.startswith(".isoshade-") for part in n.split("/"))]
            why = self.w.is_right(name, here, stale)
            if why:
                raise AssertionError(f"{what}, but {why}")
            return "right"
        if code < 0:
            raise AssertionError(what)
        draws = "validate" if right["step"].startswith("validate") else "render gl" if " --with gl" in right["step"] else ""
        if code == 0 or code not in codes_of(draws, kind):
            raise AssertionError(f"{what}: {err}")
        if len([line for line in err if line]) != 1:
            raise AssertionError(f"{what}: {len(err)} lines: {err[:3]}")
        there = listing(f"{here}/w")
        # What an earlier try finished, or left when it was killed, may be there too; the second goes at any time.
        for n in set(there) | set(right["before"]):
            if n not in there or (there[n] not in (right["before"].get(n), right["files"].get(n), earlier.get(n)) and
                                  n not in right["loose"] and not n.startswith((".v.iso.partial", "report.work"))):
                raise AssertionError(f"{what}, and {n} is {'lost' if n not in there else 'left over or changed'}")
        return "told"


def one(w, library, seed, k, tell):
    dice = random.Random(f"{seed} {k}")
    runner = Runner(w, library, tell)
    counts = collections.Counter()
    try:
        _, steps = runner.in_peace(dice, f"{k}a")
        if tell:
            for s in steps:
                print(f"    {s['code']}  isoshade {s['step']}")
        counts = runner.disturbed(dice, f"{k}b", steps)
        counts["commands"] = len(steps)
        counts["refused"] = sum(s["code"] != 0 for s in steps)
        return k, counts, None
    except AssertionError as why:
        return k, counts, str(why)
    finally:
        shutil.rmtree(f"{w.base}/{k}a", ignore_errors=True)
        shutil.rmtree(f"{w.base}/{k}b", ignore_errors=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--count", type=int, default=200)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--one", type=int)
    p.add_argument("--jobs", type=int, default=os.cpu_count())
    a = p.parse_args()
    w, library, sums, findings = World(), world.shim(), collections.Counter(), 0
    numbers = [a.one] if a.one is not None else range(a.count)
    print(f"seed {a.seed}, {len(numbers)} pipelines", flush=True)
    try:
        with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
            for k, counts, why in pool.map(lambda k: one(w, library, a.seed, k, a.one is not None), numbers):
                sums.update(counts)
                if why:
                    findings += 1
                    print(f"    pipeline {k} (tests/pipelines.py --seed {a.seed} --one {k}): {why}", flush=True)
    finally:
        w.close()
    print(f"{sums['commands']} commands, {sums['refused']} of them refused in peace too; {sums['right'] + sums['told'] + sums['killed']}"
          f" disturbed runs: {sums['right']} right all the same, {sums['told']} told in one line, {sums['killed']} killed;"
          f" {findings} pipelines wrong")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
