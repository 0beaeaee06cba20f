# SPDX-License-Identifier: MIT
"""Uses slices, lengths and other daily tools of the viewer's pages in Chromium, for tests/check_view_daily.sh. Prints a
line per finding.

view_daily.py slices PAGE FILE.nii     pixels, values and places against nibabel's
view_daily.py labels PAGE              names of labels"""
import json
import re
import sys

import nibabel
import numpy

from chromium import Chromium
from view_page import load
from view_page import say as say_value

PLANES = ((0, 1, 2), (0, 2, 1), (1, 2, 0))  # axes of the world: to the right, upwards, through


def say(name, value):
    say_value(name, value if isinstance(value, (str, int)) else bool(value))  # numpy has its own bool


def canvas(n):
    return f"document.querySelectorAll('.slice canvas')[{n}]"


def pixels(page, n):
    """Gray pixels of a slice, row 0 at the top."""
    width, height, flat = page.evaluate(f"""(c => [c.width, c.height, [...c.getContext('2d')
        .getImageData(0, 0, c.width, c.height).data].filter((v, i) => i % 4 === 0)])({canvas(n)})""")
    return numpy.array(flat, float).reshape(height, width)


def expected(values, plane, at, mirrored):
    """The slice through voxel `at` of values in nibabel's closest canonical order (right, anterior, superior)."""
    across, up, through = plane
    cut = numpy.moveaxis(values, (up, across, through), (0, 1, 2))[::-1, :, at[through]]
    return cut[:, ::-1] if mirrored else cut


def box(page, n):
    return page.evaluate(f"(b => [b.x, b.y, b.width, b.height])({canvas(n)}.getBoundingClientRect())")


def show(page, index):
    """Moves the crosshair to a voxel of the file."""
    page.evaluate(f"""(() => {{ const {{state, slices, data}} = isoshade, g = data.geometry0, m = g.index_to_world;
        const at = {json.dumps([float(i) + 0.5 for i in index])};
        state.cross = g.origin_mm.map((o, r) => o + m[r][0] * at[0] + m[r][1] * at[1] + m[r][2] * at[2]);
        slices.draw(); }})()""")


def largest_difference(page, values, affine, mirrored, half_step):
    """Largest part of the allowed difference, over the pixels of three slices through several voxels."""
    order = nibabel.io_orientation(affine)
    worst, lo_hi = 0, page.evaluate("isoshade.state.window")
    canonical = nibabel.apply_orientation(values, order)
    for index in ((3, 5, 2), (9, 12, 8), (0, values.shape[1] - 1, values.shape[2] - 1)):
        show(page, index)
        at = [0, 0, 0]
        for axis, (world, flip) in enumerate(order):
            at[int(world)] = index[axis] if flip > 0 else values.shape[axis] - 1 - index[axis]
        for n, plane in enumerate(PLANES):
            wanted = 255 * (expected(canonical, plane, at, mirrored) - lo_hi[0]) / (lo_hi[1] - lo_hi[0])
            limit = 0.5 + 255 * half_step / (lo_hi[1] - lo_hi[0])  # rounding to a byte, and the page's own step
            shown = pixels(page, n)
            if shown.shape != wanted.shape:
                return numpy.inf
            worst = max(worst, abs(shown - numpy.clip(wanted, 0, 255)).max() / limit)
    return worst * (1 - 1e-9)  # floats of a byte's half


def hover(page, x, y):
    """Voxel, position and value that the page reports under a pixel."""
    page.mouse("mouseMoved", x, y, button="none")
    text = page.evaluate("document.getElementById('readout').textContent")
    voxel, mm, value = re.match(r"voxel ([\d ]+) · ([^m]*) mm · (\S+)", text).groups()
    return [int(i) for i in voxel.split()], [float(v) for v in mm.split(",")], float(value)


def slices(path, file):
    image = nibabel.load(file)
    values, affine = numpy.asarray(image.dataobj, float), image.affine
    with Chromium(size=(1000, 800)) as page:
        load(page, path)
        page.evaluate("document.getElementById('slices').click()")
        page.evaluate("new Promise(done => setTimeout(done, 100)).then(() => isoshade.frames.settled())")
        quantum = page.evaluate("(l => l.scalar.kind === 'quantized' ? l.scalar.step : 0)(isoshade.slices.shown())")
        lo, hi = float(values.min()), float(values.max())
        page.evaluate(f"Object.assign(isoshade.state, {{window: [{lo}, {hi}]}})")
        is_patient = page.evaluate("isoshade.data.is_patient")
        say("pixels_are_the_files_values", largest_difference(page, values, affine, is_patient, quantum / 2) <= 1)
        say("mirrored_ones_are_noticed", largest_difference(page, values, affine, not is_patient, quantum / 2) > 1)
        brighter = values + (hi - lo) / 200
        say("a_step_is_noticed", largest_difference(page, brighter, affine, is_patient, quantum / 2) > 1)
        letters = f"[...{canvas(0)}.parentElement.querySelectorAll('.end')].map(e => e.textContent).join(' ')"
        if is_patient:
            say("letters_are_radiological", page.evaluate(letters) == "R L A P")
            page.evaluate("isoshade.state.neurological = true; isoshade.slices.draw()")
            say("letters_are_neurological", page.evaluate(letters) == "L R A P")
            say("and_so_are_pixels", largest_difference(page, values, affine, False, quantum / 2) <= 1)
            page.evaluate("isoshade.state.neurological = false; isoshade.slices.draw()")
        else:
            say("letters_are_axes", page.evaluate(letters) == "-x +x +y -y")

        # Values and positions under the cursor.
        show(page, (9, 12, 8))
        good, shifted, rolled = [], [], numpy.roll(values, 1, 0)
        rest = quantum / 2 + 1e-6 * max(abs(lo), abs(hi))  # the page's step, seven digits
        for n, plane in enumerate(PLANES):
            left, top, width, height = box(page, n)
            for part in (0.21, 0.48, 0.83):
                voxel, mm, value = hover(page, round(left + part * width), round(top + (1 - part) * height))
                index = numpy.linalg.solve(affine[:3, :3], numpy.array(mm) - affine[:3, 3])
                near = abs(index - voxel).max() <= 0.5 + 0.01 / min(image.header.get_zooms())  # two decimals of mm
                good.append(near and abs(values[tuple(voxel)] - value) <= rest)
                shifted.append(abs(rolled[tuple(voxel)] - value) <= rest)
        say("values_under_the_cursor_are_the_files", all(good))
        say("a_shifted_volume_is_noticed", not all(shifted))

        # A click moves the crosshair, which is in the picture, too.
        lines = "document.querySelector('#outline path').getAttribute('d')"
        before = page.evaluate(lines)
        left, top, width, height = box(page, 0)
        page.drag((left + 0.3 * width, top + 0.4 * height), (left + 0.3 * width, top + 0.4 * height), steps=1)
        say("a_click_moves_the_crosshair", page.evaluate(lines) != before and before.count("M") == 3)
        say("it_meets_in_the_picture", meet(page.evaluate(lines)))
        mixed = ["", before.split("M")[1], *page.evaluate(lines).split("M")[2:]]
        say("a_line_elsewhere_is_noticed", not meet("M".join(mixed)))

        # The window.
        page.drag((left + 0.5 * width, top + 0.5 * height), (left + 0.6 * width, top + 0.7 * height), button="right")
        dragged = page.evaluate("isoshade.state.window")
        say("dragging_changes_the_window", dragged[1] - dragged[0] > 1.05 * (hi - lo) and sum(dragged) > sum((lo, hi)))

        # A length, in oblique axes and uneven spacings.
        page.evaluate("document.querySelector('#slicing button').click()")
        page.evaluate("new Promise(done => setTimeout(done, 100))")
        ends = []
        for x, y in ((0.2, 0.3), (0.7, 0.8)):
            at = (round(left + x * width), round(top + y * height))
            ends.append(hover(page, *at)[1])
            page.drag(at, at, steps=1)
        text = page.evaluate("document.getElementById('length').textContent")
        length = numpy.linalg.norm(numpy.subtract(*ends))
        say("a_length_is_in_mm", abs(float(text.split()[1]) - length) <= 0.02)  # the ends have two decimals
        in_voxels = numpy.linalg.norm(numpy.linalg.solve(affine[:3, :3], numpy.subtract(*ends)))
        say("a_length_in_voxels_is_noticed", abs(float(text.split()[1]) - in_voxels) > 0.02)
        say("its_line_is_in_the_picture", page.evaluate(lines).count("M") == 4)
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def meet(path):
    """True if the first three lines of a path have a point in common."""
    ends = [numpy.array(line.replace("L", " ").split(), float).reshape(2, 2) for line in path.split("M")[1:4]]
    normals = [numpy.array([-(b - a)[1], (b - a)[0]]) / max(numpy.linalg.norm(b - a), 1e-9) for a, b in ends]
    offsets = numpy.array([n @ e[0] for n, e in zip(normals, ends)])
    point = numpy.linalg.lstsq(numpy.array(normals), offsets, rcond=None)[0]
    return max(abs(n @ (e[0] - point)) for n, e in zip(normals, ends)) < 1e-4  # five decimals


def labels(path):
    with Chromium(size=(800, 600)) as page:
        load(page, path)
        page.evaluate("document.getElementById('slices').click()")
        found = []
        for index in ((2, 5, 4), (6, 5, 4), (10, 5, 4), (0, 5, 4)):
            show(page, index)
            found.append(page.evaluate("document.getElementById('readout').textContent").split("mm · ")[1])
        say("labels", "; ".join(found))


if __name__ == "__main__":
    {"slices": slices, "labels": labels}[sys.argv[1]](*sys.argv[2:])
