# SPDX-License-Identifier: GPL-3.0-or-later
"""The histogram of a volume's values over the ramp, as a picture in the panel. The program counts; Blender cannot draw
into a ColorRamp, so the picture shows the ramp's colors and stops again, under the bars."""
import math

import bpy
import bpy.utils.previews
import numpy

from . import volume
from .operators import Button, isoshade, note_values
from .tables import Refused

WIDTH, HEIGHT, STRIP = 256, 128, 16  # pixels of the picture, and of the strip of colors
DARK, BAR, LINE = (0.11, 0.11, 0.11, 1), (0.5, 0.5, 0.5, 1), (1, 0.8, 0.3, 1)
pictures = None  # of the panel
drawn = {}  # name of a volume: its key and picture


def counts_of(frame):
    """Returns lowest and highest value and the counts; None: none are noted."""
    try:
        listed = [float(v) for v in frame["isoshade_histogram"]]
    except (KeyError, TypeError, ValueError):
        return None
    if len(listed) < 3 or not all(map(math.isfinite, listed)) or not listed[1] > listed[0]:
        return None
    return listed[0], listed[1], numpy.array(listed[2:])


def unit_of(frame):
    """Returns a blank and the unit of the values, or ''."""
    unit = frame.get("isoshade_value_unit", "")
    return f" {unit}" if isinstance(unit, str) and unit else ""


def heights(frame, lo, hi, columns):
    """Returns the heights of the bars from 0 to 1, logarithmic, for columns from lo to hi."""
    first, last, counts = counts_of(frame)
    values = lo + (numpy.arange(columns) + 0.5) / columns * (hi - lo)
    place = numpy.floor((values - first) / (last - first) * len(counts)).astype(int)
    inside = (place >= 0) & (place < len(counts))
    logs = numpy.log1p(counts) / max(numpy.log1p(counts.max()), 1e-9)
    return numpy.where(inside, logs[numpy.clip(place, 0, len(counts) - 1)], 0)


def picture(frame, ramp):
    """Returns rows of RGBA from below: the ramp's colors, above them bars, the opacity as a line, and the stops."""
    pixels = numpy.empty((HEIGHT, WIDTH, 4), numpy.float32)
    pixels[:] = DARK
    values = ramp.lo + (numpy.arange(WIDTH) + 0.5) / WIDTH * (ramp.hi - ramp.lo)
    rows = ramp.curve(values)
    pixels[:STRIP, :, :3] = numpy.clip(rows[:, :3], 0, 1)[None] ** (1 / 2.2)
    pixels[:STRIP, :, 3] = 1
    space = HEIGHT - STRIP - 1
    level = numpy.arange(space + 1)[:, None]
    above = pixels[STRIP:]
    above[level < heights(frame, ramp.lo, ramp.hi, WIDTH) * space] = BAR
    line = numpy.clip(numpy.rint(numpy.clip(rows[:, 3], 0, 1) * space).astype(int), 0, space)
    above[line, numpy.arange(WIDTH)] = LINE
    for stop in ramp.stops():
        pixels[STRIP:STRIP + 4, min(int(stop[0] * WIDTH), WIDTH - 1)] = (1, 1, 1, 1)
    return pixels


def icon(frame, ramp):
    """Returns the number of the icon for the panel, drawn again after a change; 0: there is no histogram."""
    global pictures
    if counts_of(frame) is None:
        return 0
    if pictures is None:
        pictures = bpy.utils.previews.new()
    key = (tuple(frame["isoshade_histogram"]), ramp.lo, ramp.hi, tuple(ramp.flat()))
    if drawn.get(frame.name) != key:
        image = pictures.get(frame.name) or pictures.new(frame.name)
        square = numpy.zeros((WIDTH, WIDTH, 4), numpy.float32)
        square[(WIDTH - HEIGHT) // 2:(WIDTH + HEIGHT) // 2] = picture(frame, ramp)
        image.image_size = (WIDTH, WIDTH)
        image.image_pixels_float.foreach_set(square.ravel())
        drawn[frame.name] = key
    return pictures[frame.name].icon_id


def forget():
    global pictures
    if pictures is not None:
        bpy.utils.previews.remove(pictures)
    pictures = None
    drawn.clear()


class ISOSHADE_OT_histogram(Button, bpy.types.Operator):
    """Count the volume's values, to show them over the ramp"""
    bl_idname, bl_label = "isoshade.histogram", "Histogram"

    def work(self, context):
        frame = volume.need_frame(context)
        name = frame.name

        def finish(job):
            if job.code() != 0:
                raise Refused(job.complaint())
            if name in bpy.data.objects:
                note_values(bpy.data.objects[name], job.output())
                if counts_of(bpy.data.objects[name]) is None:
                    raise Refused(f"{name}: has a single value, or isoshade is older than the add-on")
            return f"The values of {name} are counted"

        command = [isoshade(context), "info", volume.volume_path(frame, context.scene), "--json"]
        return self.run(context, "Counting", [command], finish)


classes = (ISOSHADE_OT_histogram,)
