#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Transfer functions of Slicer and ParaView as VTK itself shows them, and isoshade beside it.

    python3 tests/peers/vtk_tables.py                        writes tests/tf/vtk_tables.json, which tests/test_tf_peers.c reads
    python3 tests/peers/vtk_tables.py --compare FILE ...     converts every transfer function in the files and compares

The curves are vtkPiecewiseFunction's and vtkColorTransferFunction's, with duplicate points allowed, as Slicer and ParaView make
them. --compare takes ParaView's color maps (.json), Slicer's volume properties (.vp.json) and its presets.xml; a table of
isoshade may be 1/255 from VTK's function at the table's own entries. Debian package: python3-vtk9."""
import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
CASES = ["tests/tf/curves.paraview.json", "tests/tf/curves.vp.json"]
SAMPLES = 81


def color_function(points, space="RGB", wrap=True):
    """points: (x, (r, g, b), midpoint, sharpness)"""
    f = vtkColorTransferFunction()
    f.SetAllowDuplicateScalars(True)
    f.SetHSVWrap(wrap)
    getattr(f, "SetColorSpaceTo" + {"CIELAB": "Lab", "Wrapped": "HSV", "Lab/CIEDE2000": "LabCIEDE2000"}.get(space, space))()
    for x, color, midpoint, sharpness in points:
        f.AddRGBPoint(x, *color, midpoint, sharpness)
    return f


def opacity_function(points):
    """points: (x, opacity, midpoint, sharpness)"""
    f = vtkPiecewiseFunction()
    f.SetAllowDuplicateScalars(True)
    for point in points:
        f.AddPoint(*point)
    return f


def groups(numbers, size):
    return [numbers[i:i + size] for i in range(0, len(numbers), size)]


def read_paraview(text):
    maps = json.loads(re.sub(r",(\s*[\]}])", r"\1", text))
    for m in maps if isinstance(maps, list) else [maps]:
        if "RGBPoints" not in m:
            yield m["Name"], None, None, "IndexedColors"
            continue
        color = [(p[0], p[1:], 0.5, 0) for p in groups(m["RGBPoints"], 4)]
        yield (m["Name"], color_function(color, m["ColorSpace"], bool(m.get("HSVWrap", 0))),
               opacity_function(groups(m["Points"], 4)) if m.get("Points") else None, "")


def read_slicer(text):
    properties = json.loads(text)["volumeProperties"]
    for p, item in enumerate(properties):
        for k, c in enumerate(item["components"]):
            name = f"{p + 1}.{k + 1}" if len(properties) > 1 else str(k + 1)

            def points(key, value, component=c):
                return [(n["x"], n[value], n.get("midpoint", 0.5), n.get("sharpness", 0)) for n in component[key]["points"]]
            yield name, color_function(points("rgbTransferFunction", "color")), opacity_function(points("scalarOpacity", "y")), ""


def read_mrml(text):
    for e in xml.etree.ElementTree.fromstring(text).iter("VolumeProperty"):
        def numbers(key, element=e):
            return [float(n) for n in element.get(key).split()][1:]
        gradient = numbers("gradientOpacity")[1::2]
        yield (e.get("name"), color_function([(p[0], p[1:], 0.5, 0) for p in groups(numbers("colorTransfer"), 4)]),
               opacity_function([(*p, 0.5, 0) for p in groups(numbers("scalarOpacity"), 2)]),
               "gradient opacity" if any(g != 1 for g in gradient) else "")


def read(path):
    text = open(path, encoding="utf-8").read()
    if "<VolumeProperty" in text:
        return read_mrml(text)
    return read_slicer(text) if "volumeProperties" in text else read_paraview(text)


def values(color, opacity, x):
    return [*color.GetColor(x), opacity.GetValue(x)]


def write_tables():
    tables = []
    for path in CASES:
        for name, color, opacity, _ in read(os.path.join(TOP, path)):
            lo = min(color.GetRange()[0], opacity.GetRange()[0])
            hi = max(color.GetRange()[1], opacity.GetRange()[1])
            xs = [lo + (hi - lo) * (i + 0.5) / SAMPLES for i in range(SAMPLES)]  # none at a step
            tables.append({"file": path, "name": name, "range": [xs[0], xs[-1]],
                           "table": [[round(v, 6) for v in values(color, opacity, x)] for x in xs]})
    lines = []
    for t in tables:
        rows = ",\n".join("  " + json.dumps(row) for row in t.pop("table"))
        lines.append(json.dumps(t)[:-1] + ', "table": [\n' + rows + "]}")
    with open(os.path.join(TOP, "tests/tf/vtk_tables.json"), "w", encoding="utf-8") as out:
        out.write('{"vtk": "%s", "cases": [\n' % vtkVersion.GetVTKVersion() + ",\n".join(lines) + "\n]}\n")
    print(f"VTK {vtkVersion.GetVTKVersion()}: {len(tables)} tables")


def srgb(c):
    return 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055


def compare(isoshade, path):
    converted, refused, wrong, worst = 0, {}, 0, (0, "")
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "x.csv")
        for name, color, opacity, why_not in read(path):
            options = ["--name", name]
            if color and not opacity:
                lo, hi = color.GetRange()
                opacity = opacity_function([(lo, 0, 0.5, 0), (hi, 1, 0.5, 0)])
                options += ["--opacity", "0,1"]
            if path.endswith(".json") and "vp.json" not in path:
                options += ["--unit-distance", "1"]
            run = subprocess.run([isoshade, "tf", "convert", path, *options, "-o", out], capture_output=True, text=True, check=False)
            if run.returncode != 0:
                reason = why_not or run.stderr.strip()
                refused[reason] = refused.get(reason, 0) + 1
                wrong += not why_not
                continue
            wrong += bool(why_not)
            converted += 1
            rows = list(csv.reader(open(out, encoding="utf-8")))[1:]
            first, last = float(rows[0][0]), float(rows[-1][0])
            lo, hi = color.GetRange()
            # Maps from 0 or -1 to 1 are fractions of a range.
            scale = (hi - lo, lo) if (first, last) == (0, 1) else (1, 0)
            for row in rows:
                x, *linear, _, alpha = (float(v) for v in row)
                got = [srgb(c) for c in linear] + [alpha]
                # At a step either side will do.
                sides = [values(color, opacity, scale[1] + scale[0] * (x + side * 1e-7 * (last - first))) for side in (-1, 0, 1)]
                worst = max(worst, (min(max(abs(a - min(b, 1)) for a, b in zip(got, want)) for want in sides), name))
    print(f"{path}: {converted} converted, worst difference {255 * worst[0]:.3f}/255 ({worst[1]})")
    for reason, count in refused.items():
        print(f"  {count} refused: {reason}")
    return wrong == 0 and worst[0] <= 1 / 255


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compare", nargs="+", metavar="FILE")
    parser.add_argument("--isoshade", default=os.environ.get("ISOSHADE", os.path.join(TOP, "isoshade")))
    args = parser.parse_args()
    if not args.compare:
        write_tables()
    elif not all([compare(args.isoshade, path) for path in args.compare]):
        sys.exit(1)


main()
