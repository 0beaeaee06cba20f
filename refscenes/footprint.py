#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""How near is a level whose voxels are no larger than a pixel to level 0, and is it sooner?

    python3 refscenes/footprint.py VOLUME...         the files' volumes, three transfer functions, two views
    python3 refscenes/footprint.py --suite DIR       scenes of a suite

A picture has 1, 2 or 4 voxels of the level per pixel, at the center of the box. The RMSE is that of `isoshade compare`
over all pixels and channels; the time is that of the whole command, from a volume and from a pyramid on disk, relative to
the level's."""
import argparse
import json
import math
import os
import shlex
import shutil
import statistics
import subprocess
import tempfile
import time

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
ISOSHADE = os.environ.get("ISOSHADE", os.path.join(TOP, "isoshade"))
BAR = 1 / 510
LOOKS = [["--tf", tf, "--view", view] for tf in ("auto", "simulation", "mri-brain") for view in ("front", "iso")]


def run(*words):
    start = time.perf_counter()
    done = subprocess.run([ISOSHADE, *words], capture_output=True, text=True)
    return done, time.perf_counter() - start


def diagonal(volume):
    """The box's diagonal in voxels of the smallest spacing: about the height of a picture that frames the box."""
    info = json.loads(run("info", volume, "--json")[0].stdout)
    spacing = info["spacing_mm"]
    return math.dist([0] * 3, [n * s / min(spacing) for n, s in zip(info["size"], spacing)])


def of_look(volume, pyramid, look, full, folder):
    """Yields level, voxels of it per pixel, RMSE, and times of level 0 and the level, from volume and pyramid."""
    for part in (2, 4, 8, 16):
        size = max(8, round(full / part))
        exr = [os.path.join(folder, "%d.exr" % k) for k in (0, 1, 2)]

        def draw(of, k):
            return run("render", of, "--with", "cpu", "--size", str(size), "--level", str(k), "-o", exr[k], *look)

        zero = draw(volume, 0)[1], draw(pyramid, 0)[1]
        for level in (1, 2):
            if not 1 <= part / 2 ** level <= 4:
                continue
            from_pyramid, seconds = draw(pyramid, level)[1], draw(volume, level)
            if seconds[0].returncode:
                continue
            done = run("compare", exr[0], exr[level], "--json")[0]
            times = zero[0] / seconds[1], zero[1] / from_pyramid
            yield level, part // 2 ** level, json.loads(done.stdout)["rmse"], times


def cases(arguments, folder):
    scenes = sorted(os.listdir(arguments.suite)) if arguments.suite else []
    for name in scenes:
        path = os.path.join(arguments.suite, name)
        if not name.endswith(".scene.json"):
            continue
        made = json.load(open(path))["suite"]["make"]
        volume = os.path.join(folder, name + ".nrrd")
        run("make", *shlex.split(made), "-o", volume)
        yield volume, [["--scene", path]]
    for volume in arguments.volumes:
        yield volume, LOOKS


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volumes", nargs="*")
    parser.add_argument("--suite")
    arguments = parser.parse_args()
    table = {}
    with tempfile.TemporaryDirectory() as folder:
        for volume, looks in cases(arguments, folder):
            pyramid = os.path.join(folder, "v.iso")
            shutil.rmtree(pyramid, ignore_errors=True)
            run("build", volume, "-o", pyramid, "--levels", "3")
            full = diagonal(volume)
            for look in looks:
                for level, voxels, rmse, times in of_look(volume, pyramid, look, full, folder):
                    table.setdefault((level, voxels), []).append((rmse, *times))
    print("| level | its voxels per pixel | pictures | RMSE below 1/510 | median RMSE | level 0's time, from a volume | "
          "from a pyramid |\n|---|---|---|---|---|---|---|")
    for (level, voxels), rows in sorted(table.items()):
        rmse, of_volume, of_pyramid = zip(*rows)
        print("| %d | %d | %d | %d | %.3g | %.3g | %.3g |" %
              (level, voxels, len(rows), sum(r < BAR for r in rmse), statistics.median(rmse),
               statistics.median(of_volume), statistics.median(of_pyramid)))


main()
