# SPDX-License-Identifier: MIT
"""Uses slices, lengths and other daily tools of the viewer's pages in Chromium, for tests/check_view_daily.sh. Prints a
line per finding.

view_daily.py slices PAGE FILE.nii     pixels, values and places against nibabel's
view_daily.py labels PAGE              names of labels
view_daily.py framed PAGE OUTER.html   the page in a frame that forbids to save, 420 pixels high
view_daily.py opened PAGE STEPS OVER   a file of time steps, and another file over its slices
view_daily.py picked PAGE              lengths and points in the picture, of a constant that is 10 mm wide
view_daily.py overlaid PAGE FILE FAR   a second volume, of constants; noise.nrrd is next to the page
view_daily.py placed PAGE FOLDER       writes the picture of the second volume alone, and its scene
view_daily.py unit PAGE FILE UNIT      the unit of values, of the page and of a file that is opened
view_daily.py lost PAGE FILE OTHER     the context is lost and comes again"""
import base64
import html
import json
import math
import os
import re
import sys
import time

import nibabel
import numpy

from chromium import Chromium
from view_page import load, take
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


def lost(path, file, other):
    picture = "isoshade.frames.settled().then(() => [...isoshade.frames.measure(60, 40).rgba])"
    with Chromium(size=(600, 400)) as page:
        load(page, path)
        before = page.evaluate(picture)
        page.evaluate("window.losing = isoshade.context.gl.getExtension('WEBGL_lose_context'); losing.loseContext()")
        page.wait("!document.getElementById('message').hidden")
        say("it_is_lost", page.evaluate("isoshade.context.gl.isContextLost()"))
        page.evaluate("losing.restoreContext()")
        page.wait("document.getElementById('message').hidden")
        page.evaluate("isoshade.frames.settled()")
        say("it_comes_again", page.evaluate(picture) == before)
        page.evaluate("document.getElementById('picture').focus()")
        page.key("ArrowLeft")
        page.evaluate("isoshade.frames.settled()")
        say("and_is_used", page.evaluate(picture) != before)

        # The graphics process ends, which takes the context with it.
        before = page.evaluate(picture)
        page.evaluate("window.count = 0; isoshade.context.gl.canvas.addEventListener('webglcontextrestored', () => ++count)")
        page.browser("Browser.crashGpuProcess")
        page.wait("count > 0")
        say("a_crash_is_survived", page.evaluate(picture) == before)

        # While a file is opened: in its upload, then while its first picture is drawn.
        choose(page, "#open", file)
        whole = page.evaluate(picture)
        for waits in (1, 2):
            choose(page, "#open", other)
            page.evaluate(f"""count = 0; window.waits = {waits}; window.finished = isoshade.context.finished;
                isoshade.context.finished = () => {{
                    if (--waits === 0) {{ losing.loseContext(); setTimeout(() => losing.restoreContext(), 300); }}
                    return finished();
                }}; window.losing = isoshade.context.gl.getExtension('WEBGL_lose_context')""")
            choose(page, "#open", file)
            page.evaluate("isoshade.context.finished = finished")
            say(f"a_file_comes_through_a_loss_after_{waits}", page.evaluate("count") == 1 and page.evaluate(picture) == whole)
        say("it_has_not_failed", not page.evaluate("document.documentElement.dataset.failed || ''"))
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def picked(path):
    """Opacity 0.3 over 2 mm everywhere: a half is passed ln 2 / sigma behind the face, wherever a ray enters."""
    depth = math.log(2) / (-math.log(0.7) / 2)
    with Chromium(size=(900, 700)) as page:
        load(page, path)
        page.evaluate("[...document.querySelectorAll('#views button')].find(b => b.textContent === 'front').click()")
        page.evaluate("(e => { e.value = 'orthographic'; e.dispatchEvent(new Event('change')); })"
                      "(document.querySelector('#projection select'))")
        page.evaluate("isoshade.frames.settled()")
        page.evaluate("document.querySelector('#slicing .buttons button').click()")
        left, top, width, height = page.evaluate("(b => [b.x, b.y, b.width, b.height])"
                                                 "(document.getElementById('picture').getBoundingClientRect())")
        mm = 2 * page.evaluate("isoshade.frames.camera(1).half") / height  # of a pixel
        x, y = left + width / 2, top + height / 2
        ends = [(round(x + dx / mm), round(y + dy / mm)) for dx, dy in ((-3, 2), (2.5, -2))]
        for at in ends:
            page.drag(at, at, steps=1)
        points = page.evaluate("isoshade.state.measure")
        face = page.evaluate("isoshade.data.geometry0.origin_mm[1]") + 10  # it looks against y
        off = max(abs(face - depth - p[1]) for p in points)
        say("points_lie_where_opacity_passes_a_half", off <= 0.01)  # midpoints of a constant are exact
        say("a_half_of_that_depth_is_noticed", max(abs(face - depth / 2 - p[1]) for p in points) > 0.01)
        text = page.evaluate("document.getElementById('length').textContent")
        length = mm * math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])
        say("the_length_is_that_between_the_pixels", abs(float(text.split()[1]) - length) <= 0.02)
        line = page.evaluate("document.querySelector('#outline path').getAttribute('d')")
        say("it_is_in_the_picture", line.count("M") == 1)
        say("a_drag_still_orbits", orbits(page, ends))
        page.evaluate("isoshade.state.measure = []")
        corner = (round(left + 3), round(top + 3))
        page.drag(corner, corner, steps=1)
        said = page.evaluate("document.getElementById('readout').textContent")
        count = page.evaluate("isoshade.state.measure.length")
        say("beside_the_volume_nothing_is_picked", "not opaque" in said and count == 0)
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def orbits(page, ends):
    """True if a drag turns the camera and picks nothing."""
    before = page.evaluate("JSON.stringify([isoshade.state.measure, isoshade.state.camera.position])")
    page.drag(*ends)
    measure, camera = page.evaluate("[isoshade.state.measure, isoshade.state.camera.position]")
    return json.loads(before)[0] == measure and json.loads(before)[1] != camera


def unit(path, file, name):
    with Chromium(size=(900, 700)) as page:
        load(page, path)
        for of in ("the_page", "an_opened_file"):
            page.evaluate("isoshade.state.slices || document.getElementById('slices').click()")
            page.evaluate("new Promise(done => setTimeout(done, 100)).then(() => isoshade.slices.draw())")
            said = page.evaluate("document.getElementById('readout').textContent")
            say(f"{of}_has_it_under_the_cursor", bool(re.search(rf"mm · -?[\d.]+ {name}$", said)))
            axis = page.evaluate("[...document.querySelectorAll('#editor svg text')].map(t => t.textContent)")
            lo, hi = page.evaluate("isoshade.data.value_range")
            ends = float(axis[0]) <= lo and float(axis[1]) >= hi * 0.999  # four digits
            say(f"{of}_has_it_at_the_axis", axis[2] == f"value, {name}" and ends)
            label = page.evaluate("document.querySelector('[data-field=value]').closest('label').textContent")
            say(f"{of}_has_it_at_the_field", label == f"value, {name}")
            choose(page, "#open", file)


def choose(page, selector, path):
    root = page.call("DOM.getDocument")["root"]["nodeId"]
    node = page.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
    page.call("DOM.setFileInputFiles", nodeId=node, files=[os.path.abspath(path)])
    page.wait(f"document.getElementById('message').hidden && document.body.textContent.includes('{os.path.basename(path)}')")
    page.evaluate("isoshade.frames.settled()")


def opened(path, steps, over):
    image, labels = nibabel.load(steps), nibabel.load(over)
    values, affine = numpy.asarray(image.dataobj, float), image.affine
    with Chromium(size=(1000, 800)) as page:
        load(page, path)
        choose(page, "#open", steps)
        page.evaluate("document.getElementById('slices').click()")
        right = []
        for step in (2, 1, 0):
            page.evaluate(f"isoshade.data.toStep({step}).then(() => isoshade.frames.settled())")
            page.evaluate(f"Object.assign(isoshade.state, {{window: [{values.min()}, {values.max()}]}})")
            right.append([largest_difference(page, values[..., t], affine, True, 0) <= 1 for t in range(3)])
        say("each_step_shows_its_values", [r.index(True) for r in right] == [2, 1, 0] and sum(map(sum, right)) == 3)
        say("the_command_names_the_step", page.evaluate("isoshade.data.input").endswith("--frame 0"))

        # The label at the position of each pixel colors it; nothing else changes.
        show(page, (9, 12, 8))
        before = colors(page)
        choose(page, "#overlay input[type=file]", over)
        after = colors(page)
        canonical = nibabel.as_closest_canonical(image)
        at = numpy.round(numpy.linalg.solve(canonical.affine, affine @ [9, 12, 8, 1])).astype(int)
        x, y = numpy.meshgrid(*[numpy.arange(n) for n in canonical.shape[:2]], indexing="ij")
        world = canonical.affine @ numpy.array([x.ravel(), y.ravel(), numpy.full(x.size, at[2]), numpy.ones(x.size)])
        there = numpy.linalg.solve(labels.affine, world)[:3]
        index = numpy.clip(numpy.floor(there + 0.5).astype(int), -1, numpy.array(labels.shape)[:, None])
        inside = numpy.all((index >= 0) & (index < numpy.array(labels.shape)[:, None]), 0)
        label = numpy.zeros(x.size)
        label[inside] = numpy.asarray(labels.dataobj)[tuple(index[:, inside])]
        label = label.reshape(x.shape).T[::-1, ::-1]  # rows from the top, the patient's right at the left
        say("labels_color_their_places", numpy.array_equal((before != after).any(-1), label > 0) and (label > 0).any())
        say("shifted_labels_are_noticed", not numpy.array_equal((before != after).any(-1), numpy.roll(label, 1, 0) > 0))
        page.evaluate("isoshade.state.overlay.cover = 1; isoshade.slices.draw()")
        say("each_label_has_one_color", len({tuple(c) for c in colors(page)[label > 0]}) == len(set(label[label > 0])))
        say("files_are_read_beside_the_page", page.evaluate("isoshade.worker.here") == 0)
        say("its_value_is_told", re.search(r"over\.nii \d+$", page.evaluate("document.getElementById('readout').textContent")))
        page.screenshot(over + ".png")
        saved_steps(page, values, affine, over)
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def saved_steps(page, values, affine, over):
    """Saves a page of opened files, whose steps and second volume are there again."""
    page.evaluate("isoshade.state.camera = {...isoshade.state.camera, half: 0.2}; isoshade.frames.ask()")
    page.evaluate("isoshade.data.toStep(1)")
    picture = "isoshade.frames.settled().then(() => [...isoshade.frames.measure(40, 30).rgba])"
    before, left = page.evaluate(picture), colors(page)
    state = page.evaluate("JSON.stringify(isoshade.state)")
    keep_saved(page, over + ".html")
    load(page, over + ".html")
    say("the_saved_page_has_the_state", page.evaluate("JSON.stringify(isoshade.state)") == state)
    say("it_draws_the_same", page.evaluate(picture) == before and numpy.array_equal(colors(page), left))
    right = []
    lo, hi = values.min(), values.max()
    page.evaluate(f"isoshade.state.overlay = null; isoshade.state.window = [{lo}, {hi}]")
    for step in (2, 0, 1):
        page.evaluate(f"isoshade.data.toStep({step}).then(() => isoshade.frames.settled())")
        right.append([largest_difference(page, values[..., t], affine, True, 0) <= 1 for t in range(3)])
    say("it_has_all_steps", [r.index(True) for r in right] == [2, 0, 1] and sum(map(sum, right)) == 3)
    keep_saved(page, over + ".again.html")
    load(page, over + ".again.html")
    say("it_is_saved_again", page.evaluate("isoshade.data.levels[0].held.length") == 3)


def keep_saved(page, path):
    page.evaluate("""HTMLAnchorElement.prototype.click = function () {
        window.savedPage = fetch(this.href).then(r => r.text()); }; document.getElementById('save-page').click()""")
    page.wait("window.savedPage")
    with open(path, "w", encoding="utf-8") as f:
        f.write(page.evaluate("savedPage"))


def overlaid(path, shifted, far):
    """Two constants of 10 mm, the second 4 mm nearer: each part of a ray is known."""
    with Chromium(size=(900, 700)) as page:
        load(page, path)
        # Faces lie at whole segments: in a segment that has one, the order of both is not known.
        page.evaluate("Object.assign(isoshade.state.camera, {position: [0, 105, 0], lookAt: [0, 0, 0], up: [0, 0, 1]})")
        page.evaluate("""Object.assign(isoshade.state,
            {shading: {ambient: 1, diffuse: 0, specular: 0, power: 1}, background: [0, 0, 0]})""")
        middle = "isoshade.frames.settled().then(() => [...isoshade.frames.measure(31, 31).rgba])"
        page.evaluate(SECOND % "0")
        alone = page.evaluate(middle)
        choose(page, "#overlay input[type=file]", far)
        page.evaluate(SECOND % "1")
        say("a_volume_elsewhere_changes_nothing", page.evaluate(middle) == alone)
        choose(page, "#overlay input[type=file]", shifted)
        page.evaluate(SECOND % "1")
        pixels_of = numpy.array(page.evaluate(middle)).reshape(31, 31, 4)
        say("both_are_summed", abs(pixels_of[15, 15, :3] - along_ray(4)).max() <= 2e-6)  # floats of 150 segments
        say("another_place_is_noticed", abs(pixels_of[15, 15, :3] - along_ray(3.9)).max() > 2e-6)
        layered = -math.expm1(-10 * OVER), -math.exp(-10 * OVER) * math.expm1(-10 * FIRST)
        say("layers_are_noticed", abs(pixels_of[15, 15, 1::-1] - layered).max() > 2e-3)
        page.evaluate(SECOND % "0")
        say("a_clear_one_changes_nothing", page.evaluate(middle) == alone)

        # Twice the same volume, each with half of the extinction.
        choose(page, "#overlay input[type=file]", os.path.join(os.path.dirname(path), "noise.nrrd"))
        choose(page, "#open", os.path.join(os.path.dirname(path), "noise.nrrd"))
        page.evaluate("Object.assign(isoshade.state, {shading: {ambient: 0.3, diffuse: 0.7, specular: 0, power: 1}})")
        page.evaluate("document.querySelector('#overlay .buttons button').click()")  # the volume's transfer function
        page.evaluate("window.whole = isoshade.state.overlay.tf; isoshade.state.overlay = null")
        page.evaluate("isoshade.state.tf = whole")
        whole = numpy.array(page.evaluate(middle))
        half = "{...whole, unit_distance_mm: 2 * whole.unit_distance_mm}"
        page.evaluate(f"isoshade.state.tf = {half}; isoshade.state.overlay = {{cover: 1, range: null, tf: {half}}}")
        both = numpy.array(page.evaluate(middle))
        say("two_halves_are_a_whole", abs(both - whole).max() <= 2e-6 and whole.max() > 0.1)
        page.evaluate("isoshade.state.overlay = {cover: 1, range: null, tf: whole}")
        say("more_is_noticed", abs(numpy.array(page.evaluate(middle)) - whole).max() > 1e-3)
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def placed(path, folder):
    """The second volume of a page alone: its picture, and the scene for the program."""
    with Chromium(size=(900, 700)) as page:
        load(page, path)
        command = page.evaluate("document.getElementById('command').textContent")
        say("its_command_says_that_it_lacks_the_second", command.endswith(" -o picture.png # without the second volume"))
        lo, hi = page.evaluate("(l => [l.min, l.max])(isoshade.data.overlay.level)")
        middle = lo + 0.4 * (hi - lo)
        points = [{"value": v, "r": 1, "g": 0.5, "b": 0.2, "opacity": o} for v, o in ((lo, 0), (middle, 0), (hi, 0.4))]
        tf = {"range": [lo, hi], "unit_distance_mm": 1.5, "color_space": "linear", "points": points}
        page.evaluate(f"""isoshade.state.overlay = {{cover: 1, range: null, tf: {json.dumps(tf)}}};
            isoshade.state.tf.points = isoshade.state.tf.points.map(p => ({{...p, opacity: 0}}))""")
        scene = page.evaluate("({...isoshade.controls.sceneNow(), image: {width: 80, height: 60}})")
        page.evaluate("(([w, h]) => { isoshade.state.camera = isoshade.frames.camera(w / h); })(isoshade.frames.size());"
                      " isoshade.state.sceneAspect = 80 / 60")
        with open(os.path.join(folder, "placed.scene.json"), "w", encoding="utf-8") as f:
            json.dump({**scene, "tf": {"schema": "isoshade.tf/1", **tf}}, f)
        take(page, os.path.join(folder, "placed.page.exr"), 80, 60)


FIRST, OVER = -math.log(0.7) / 2, -math.log(0.5) / 3  # extinctions per mm
SECOND = """isoshade.state.overlay = {cover: 1, range: null, tf: {range: [0, 2], unit_distance_mm: 3,
    points: [0, 2].map(value => ({value, r: 0, g: 1, b: 0, opacity: 0.5 * %s}))}};
    isoshade.state.tf = {...isoshade.state.tf, points: isoshade.state.tf.points.map(p => ({...p, r: 1, g: 0, b: 0}))}"""


def along_ray(shift):
    """The second alone, both, the first alone."""
    light, color = 1, numpy.zeros(3)
    for length, first, second in ((shift, 0, OVER), (10 - shift, FIRST, OVER), (shift, FIRST, 0)):
        part = light * -math.expm1(-(first + second) * length)
        color += part * numpy.array([first, second, 0]) / (first + second)
        light -= part
    return color


def colors(page):
    """Colors of the axial slice, row 0 at the top."""
    width, height, flat = page.evaluate(f"""(c => [c.width, c.height,
        [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]])({canvas(0)})""")
    return numpy.array(flat).reshape(height, width, 4)[..., :3]


class Frame:
    """The frame in a page of Chromium, whether or not it has a process of its own."""

    def __init__(self, page):
        self.page, self.outer, self.more = page, page.session, {}
        sessions = [e["params"]["sessionId"] for e in page.events if e["method"] == "Target.attachedToTarget"]
        contexts = [e["params"]["context"] for e in page.events if e["method"] == "Runtime.executionContextCreated"]
        if sessions:
            self.outer = sessions[-1]
        else:
            self.more = {"contextId": contexts[-1]["id"]}

    def evaluate(self, expression):
        session, self.page.session = self.page.session, self.outer
        try:
            result = self.page.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True, **self.more)
        finally:
            self.page.session = session
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"].get("description", ""))
        return result["result"].get("value")

    def wait(self, expression):
        for _ in range(400):
            if self.evaluate(f"Boolean({expression})"):
                return
            time.sleep(0.05)
        raise TimeoutError(expression)


def framed(path, outer):
    with open(path, encoding="utf-8") as f, open(outer, "w", encoding="utf-8") as out:
        out.write("<!doctype html><style>body { margin: 0 } iframe { width: 700px; height: 420px; border: 0 }</style>"
                  f'<iframe sandbox="allow-scripts" srcdoc="{html.escape(f.read())}"></iframe>')
    with Chromium(size=(700, 500)) as page:
        page.call("Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=False, flatten=True)
        page.open(outer, "document.readyState === 'complete'")
        frame = Frame(page)
        frame.wait("document.documentElement.dataset.ready || document.documentElement.dataset.failed")
        frame.evaluate("isoshade.frames.settled()")
        shown = "(e => e.getBoundingClientRect().toJSON())(document.getElementById('%s'))"
        picture, panel = frame.evaluate(shown % "picture"), frame.evaluate(shown % "panel")
        say("the_picture_is_first", picture["height"] >= 380 and picture["width"] == 700 and panel["width"] == 0)
        frame.evaluate("document.getElementById('settings').click()")
        panel = frame.evaluate(shown % "panel")
        say("the_panel_lies_over_it", panel["height"] == 420 and panel["right"] == 700 and panel["width"] < 400)
        buttons = frame.evaluate("""[...document.querySelectorAll('header button')].filter(b => b.offsetParent)
            .map(b => b.getBoundingClientRect()).every(b => b.top >= 0 && b.left >= 0 && b.right <= 700)""")
        say("buttons_are_in_the_frame", buttons)
        frame.evaluate("document.getElementById('save-picture').click()")
        link = "document.querySelector('#message a')?.href"
        frame.wait(link)
        data = base64.b64decode(frame.evaluate(link).partition(",")[2])
        say("a_link_holds_the_picture", data[:8] == b"\x89PNG\r\n\x1a\n" and int.from_bytes(data[16:20], "big") == 700)
        frame.evaluate("document.getElementById('settings').click()")
        page.screenshot(outer + ".png")
        say("no_exception", not any(e["method"] == "Runtime.exceptionThrown" for e in page.events))


if __name__ == "__main__":
    {"slices": slices, "labels": labels, "framed": framed, "opened": opened, "lost": lost, "picked": picked,
     "overlaid": overlaid, "placed": placed,
     "unit": unit}[sys.argv[1]](*sys.argv[2:])
