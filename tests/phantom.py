# SPDX-License-Identifier: MIT
"""One phantom that other programs write in a format and isoshade reads back: what the cases of formats_in.py and frames_in.py
share.

The phantom has three different sizes and spacings, no symmetry, and a landmark: the largest value. Where a format can say
so it stands oblique in the world. Values have to be equal bit by bit, the landmark at the same world mm.
"""
import json
import os
import shutil
import subprocess
import sys

import numpy as np

ISOSHADE = os.path.abspath(sys.argv[1])
SIZE = (11, 13, 7)
LANDMARK = (8, 3, 5)
SPACING = np.array([0.75, 0.5, 2.5])


def rotation():
    a, b = np.radians(20), np.radians(-35)
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    rz = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return rz @ rx


STEPS = rotation() * SPACING  # columns: from a sample to the next, in right, anterior, superior
FIRST = np.array([-40.5, 12.25, 100.0])  # the center of the first sample
LPS = np.diag([-1.0, -1.0, 1.0])
FILES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "formats")  # of programs that tests cannot run


def phantom(dtype=np.int16):
    """[z, y, x]; negative values too, where the type has them."""
    z, y, x = np.meshgrid(*(np.arange(n) for n in SIZE[::-1]), indexing="ij")
    v = 3 * x + 17 * y * y + 5 * z * x + 29 * z - 400
    if np.dtype(dtype) == np.uint8:
        v = (v * 7) % 240
    elif np.dtype(dtype).kind == "u":
        v = v + 500
    v = v.astype(dtype)
    if np.dtype(dtype).kind == "f":
        v = v * np.dtype(dtype).type(0.37)
    v[LANDMARK[2], LANDMARK[1], LANDMARK[0]] = v.max() + 10
    return v


class Wrong(Exception):
    pass


def expect(condition, message):
    if not condition:
        raise Wrong(message)


def run(*words):
    return subprocess.run([ISOSHADE, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True)


def build(path, options=()):
    """Level 0 of a pyramid, and its samples [z, y, x]."""
    shutil.rmtree("read.iso", ignore_errors=True)
    got = run("build", path, "--levels", "1", "-q", "-o", "read.iso", *options)
    expect(got.returncode == 0, f"exit code {got.returncode}: {got.stderr.strip()}")
    with open("read.iso/pyramid.json", encoding="utf-8") as file:
        level = json.load(file)["levels"][0]
    with open(os.path.join("read.iso", level["files"]["scalar"]["name"]), "rb") as file:
        data = file.read()
    types = {"uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "float": "<f4"}
    g = level["geometry"]
    samples = np.frombuffer(data, types[level["stored_type"]], offset=data.index(b"\n\n") + 2)
    size = samples.size - int(np.prod(g["size"]))
    return level, samples[size:].reshape(g["size"][::-1])


def read_samples(path, options=()):
    return build(path, options)[1]


def load(path, options=()):
    """Samples [z, y, x], steps, the first sample's center, whether the world is right, anterior, superior."""
    level, samples = build(path, options)
    info = run("info", path, "--json", *options)
    expect(info.returncode == 0 and not info.stderr, f"info ends with {info.returncode}: {info.stderr.strip()}")
    info, g = json.loads(info.stdout), level["geometry"]
    steps = np.array(g["index_to_world"]).reshape(3, 3)
    return samples, steps, np.array(g["origin_mm"]) + steps @ [0.5, 0.5, 0.5], info


def same(path, values, steps=STEPS, first=FIRST, ras=True, options=(), unit=None, tolerance=1e-6, value_unit=None):
    """tolerance: mm, of decimals that the format has."""
    got, got_steps, got_first, info = load(path, options)
    expect(got.shape == values.shape, f"size {got.shape[::-1]}, not {values.shape[::-1]}")
    expect(np.array_equal(got, values), f"{(got != values).sum()} of {values.size} values differ, "
           f"the first by {(got.astype(float) - values).flat[(got != values).argmax()]:g}")
    if first is None:  # around its center
        first = steps @ -(np.array(values.shape[::-1]) - 1) / 2
    place, wanted = got_first + got_steps @ LANDMARK, first + steps @ LANDMARK
    expect(np.abs(place - wanted).max() <= tolerance, f"the landmark is at {place}, not {wanted}")
    expect(np.allclose(got_steps, steps, rtol=1e-5, atol=1e-5 * np.abs(steps).max()), f"steps {got_steps}, not {steps}")
    expect(info["world_is_ras"] == ras, f"world_is_ras is {info['world_is_ras']}")
    expect(unit is None or info["unit"] == unit, f"the unit is {info['unit']}, not {unit}")
    of_values = info["value_unit"]
    expect(value_unit is None or of_values == value_unit, f"the unit of values is {of_values}, not {value_unit}")


def refused(path, code, words, options=()):
    got = run("info", path, *options)
    lines = got.stderr.strip().splitlines()
    expect(got.returncode == code, f"{path}: exit code {got.returncode}, wanted {code}: {got.stderr.strip()}")
    expect(len(lines) == 1 and not got.stdout, f"{path}: {len(lines)} lines of messages: {got.stderr}{got.stdout[:80]}")
    expect(words in lines[0], f"{path}: \"{lines[0]}\" lacks \"{words}\"")


def must_choose(path, words, options=()):
    """Of several frames or channels builds want one named. info shows the first, and the option that chooses."""
    got = run("build", path, "-o", "never.iso", *options)
    expect(got.returncode == 2 and words in got.stderr, f"{path}: exit code {got.returncode}: {got.stderr.strip()}")
    got = run("info", path, *options)
    option = "--frame K chooses another" if "frames" in words else "--channel chooses another: 0"
    expect(got.returncode == 0 and option in got.stdout, f"{path}: info ends with {got.returncode}: {got.stderr}")


def cut(path, to, fraction=0.6):
    with open(path, "rb") as file:
        data = file.read()
    with open(to, "wb") as file:
        file.write(data[:int(len(data) * fraction)])


CASES = {}


def case(f):
    CASES[f.__name__] = f
    return f


def vtk_image(values, steps=None, first=None):
    """values [z, y, x]."""
    import vtk
    from vtk.util import numpy_support
    image = vtk.vtkImageData()
    image.SetDimensions(values.shape[::-1])
    if steps is not None:
        image.SetSpacing(np.linalg.norm(steps, axis=0))
        image.SetOrigin(first)
        image.SetDirectionMatrix((steps / np.linalg.norm(steps, axis=0)).ravel())
    array = numpy_support.numpy_to_vtk(values.ravel(), deep=True)
    array.SetName("values")
    image.GetPointData().SetScalars(array)
    return image


def vtk_array(numbers):
    from vtk.util import numpy_support
    return numpy_support.numpy_to_vtk(numbers, deep=True)


def vtk_colors(pixels):
    """pixels [y, x, components]."""
    from vtk.util import numpy_support
    image = vtk_image(pixels[None, ..., 0])
    array = numpy_support.numpy_to_vtk(pixels.reshape(-1, pixels.shape[-1]), deep=True)
    image.GetPointData().SetScalars(array)
    return image


def vtk_write(writer, image, path):
    writer.SetInputData(image)
    writer.SetFileName(path)
    writer.Write()


def main(cases):
    if sys.argv[1] == "--list":
        print("\n".join(cases))
        return 0
    failed = 0
    for name in sys.argv[2:] or cases:
        try:
            cases[name]()
            print("ok", name)
        except Exception as why:  # a missing module, too
            failed = 1
            print(f"not ok {name}: {type(why).__name__}: {why}")
        sys.stdout.flush()
    return failed
