# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions as node groups: the exact table as an image, and ColorRamps to edit by hand.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part.
"""
import json
import math

import bpy
import numpy

MOST_OPAQUE = 1e-4  # transmittance of the unit distance at the limit of opacity, as in transfer functions

# ---- transfer functions ----------------------------------------------------------------------------------------


def color_table(tf):
    """Makes an image of the color maps: a row per level, or the rows of its 2D transfer function; a column per entry;
    packed, exact in 32-bit float.

    Rows with fewer entries than columns repeat the last entry."""
    rows = [row for table in tf["tables"]
            for row in numpy.array(table["entries"], numpy.float32).reshape(table["rows"], -1, 4)]
    width = max(len(row) for row in rows)
    pixels = numpy.stack([numpy.concatenate([row, numpy.repeat(row[-1:], width - len(row), axis=0)]) for row in rows])
    image = bpy.data.images.new("isoshade transfer function", width, len(rows), alpha=True, float_buffer=True,
                                is_data=True)
    image.colorspace_settings.name = 'Non-Color'
    image.alpha_mode = 'CHANNEL_PACKED'
    if hasattr(image, "use_half_precision"):
        image.use_half_precision = False
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def table_properties(table):
    """Returns the level's data for the shader: value of entry 0, entries per value, number of the last entry."""
    last = len(table["entries"]) // (4 * table["rows"]) - 1
    return [table["lo"], last / (table["hi"] - table["lo"]), float(last)]


def preview_lookup(group, image, entry, y):
    """Interpolates two unfiltered texels: EEVEE filters an image by its distance to the neighboring sample, which blurs the
    whole table."""
    width = image.size[0]
    lower = group.math('FLOOR', entry, label="entry below")
    texels = [group.node('ShaderNodeTexImage', "", {"Vector": group.join(group.math('MULTIPLY_ADD', lower, 1 / width, (0.5 + i) / width), y)},
                         image=image, interpolation='Closest', extension='EXTEND', projection='FLAT').outputs for i in (0, 1)]
    part = group.math('SUBTRACT', entry, lower)
    color = group.mix_color(part, texels[0]["Color"], texels[1]["Color"])
    extinction = group.math('MULTIPLY_ADD', part, group.math('SUBTRACT', texels[1]["Alpha"], texels[0]["Alpha"]), texels[0]["Alpha"])
    return color, extinction


def transfer_function_group(tf):
    """Scalar to color and extinction per unit: entry (s - lo) (N - 1) / (hi - lo), at the texels' centers; and the same for
    EEVEE."""
    group = Group("isoshade transfer function", [('NodeSocketFloat', "Scalar", 0.0), ('NodeSocketVector', "Table", (0, 1, 1)),
                                                 ('NodeSocketFloat', "Row", 0.0)],
                  [(kind, start + name) for start in ("", "Preview ")
                   for kind, name in (('NodeSocketColor', "Color"), ('NodeSocketFloat', "Extinction"))])
    image = color_table(tf)
    width, rows = image.size
    first, scale, last = group.split(group.given["Table"], "first value, entries per value, last entry")
    offset = group.math('SUBTRACT', group.given["Scalar"], first, label="from the first value")
    entry = group.math('MAXIMUM', group.math('MULTIPLY', offset, scale), 0.0)
    entry = group.math('MINIMUM', entry, last, label="entry")
    x = group.math('MULTIPLY_ADD', entry, 1 / width, 0.5 / width, label="between texel centers")
    y = group.math('MULTIPLY_ADD', group.given["Row"], 1 / rows, 0.5 / rows, label="the level's row")
    where = group.join(x, y)
    texel = group.node('ShaderNodeTexImage', "", {"Vector": where}, image=image, interpolation='Linear', extension='EXTEND',
                       projection='FLAT').outputs
    color, extinction = preview_lookup(group, image, entry, y)
    return group.finish(**{"Color": texel["Color"], "Extinction": texel["Alpha"], "Preview Color": color, "Preview Extinction": extinction})


def set_stops(color_ramp, ramp):
    """Adds the stops. Blender sorts them by position, so colors are set after all positions."""
    color_ramp.interpolation = 'CONSTANT' if ramp.get("constant") else 'LINEAR'
    stops = color_ramp.elements
    while len(stops) > len(ramp["stops"]):
        stops.remove(stops[-1])
    while len(stops) < len(ramp["stops"]):
        stops.new(1.0)
    for stop, (position, *_) in zip(stops, ramp["stops"]):
        stop.position = position
    for stop, (_, *color) in zip(stops, ramp["stops"]):
        stop.color = color


def one_ramp(group, ramp, number):
    """Color and opacity by a ColorRamp; extinction = -ln(1 - opacity) / unit distance. The add-on finds the nodes by
    name."""
    name = f"isoshade ramp {number}"
    offset = group.node('ShaderNodeMath', "from the first value", dict(zip(MATH, (group.given["Scalar"], ramp["lo"]))), operation='SUBTRACT',
                        name=name + " start").outputs["Value"]
    u = group.node('ShaderNodeMath', "fraction of the range", dict(zip(MATH, (offset, 1 / (ramp["hi"] - ramp["lo"])))), operation='MULTIPLY',
                   use_clamp=True, name=name + " scale").outputs["Value"]
    node = group.node('ShaderNodeValToRGB', ", ".join(ramp["of"]), {"Fac": u}, name=name)
    set_stops(node.color_ramp, ramp)
    passed = group.math('MAXIMUM', group.math('SUBTRACT', 1.0, node.outputs["Alpha"], label="1 - opacity"), MOST_OPAQUE)
    depth = group.math('LOGARITHM', passed, math.e, label="ln")
    extinction = group.node('ShaderNodeMath', "extinction", dict(zip(MATH, (depth, -1 / ramp["unit_distance"]))), operation='MULTIPLY',
                            name=name + " extinction").outputs["Value"]
    return node, extinction


def ramp_group(ramps):
    """The color maps as ColorRamps of at most 32 stops, one per different map; the object's number Ramp selects one.
    Less exact than the image, but easy to edit. For classes it is exact: one stop each, constant, from halfway to the
    previous class."""
    group = Group("isoshade ramp", [('NodeSocketFloat', "Scalar", 0.0), ('NodeSocketFloat', "Ramp", 0.0)],
                  [('NodeSocketColor', "Color"), ('NodeSocketFloat', "Extinction")])
    node, extinction = one_ramp(group, ramps[0], 0)
    nodes, color = [node], node.outputs["Color"]
    for number, ramp in enumerate(ramps[1:], 1):
        node, own_extinction = one_ramp(group, ramp, number)
        nodes.append(node)
        mine = group.math('COMPARE', group.given["Ramp"], float(number), 0.5, label=f"is ramp {number} asked for?")
        color = group.mix_color(mine, color, node.outputs["Color"])
        extinction = group.math('MULTIPLY_ADD', mine, group.math('SUBTRACT', own_extinction, extinction), extinction)
    tree = group.finish(Color=color, Extinction=extinction)
    tree["isoshade_ramps"] = json.dumps([{key: ramp[key] for key in ("of", "lo", "hi", "unit_distance_mm", "unit_distance",
                                                                     "own_points", "color_loss", "opacity_loss")}
                                         for ramp in ramps])
    for number, node in enumerate(nodes):  # values of the exact table, by which the add-on detects edits of a ramp
        tree[f"isoshade_shown_{number}"] = [float(v) for stop in node.color_ramp.elements for v in (stop.position, *stop.color)]
    return tree


def note_scene(about, frame):
    """Notes data of the scene file that nodes do not have, so that the add-on can write a scene file from the open
    file."""
    frame["isoshade_units_per_mm"] = about["units_per_mm"]
    frame["isoshade_origin_mm"] = about["origin_mm"]
    frame["isoshade_source"] = about.get("source", "")
    frame["isoshade_clip_planes"] = json.dumps(about["clip_planes_mm"])
    for key in ("value_range", "voxel_mm"):
        if key in about:
            frame[f"isoshade_{key}"] = about[key]
    if "labels" in about:
        frame["isoshade_classes"] = json.dumps(about["labels"]["classes"])
    if not about.get("dense", True):
        frame["isoshade_hidden"] = json.dumps(hidden_values(about["tf"]["tables"]))


def hidden_values(tables):
    """Finds intervals of values that no table shows: grids may omit them."""
    edges = numpy.unique(numpy.concatenate([numpy.linspace(t["lo"], t["hi"], len(t["entries"]) // (4 * t["rows"])) for t in tables]))
    shown = numpy.zeros(len(edges), bool)
    for table in tables:
        for row in numpy.array(table["entries"]).reshape(table["rows"], -1, 4):
            shown |= numpy.interp(edges, numpy.linspace(table["lo"], table["hi"], len(row)), row[:, 3]) > 0
    intervals, begin = [], None
    for i, edge in enumerate(edges):
        if not shown[i] and begin is None:
            begin = -1e30 if i == 0 else float(edge)
        if begin is not None and (shown[i] or i == len(edges) - 1):
            intervals.append([begin, 1e30 if not shown[i] else float(edges[i - 1])])
            begin = None
    return [interval for interval in intervals if interval[0] < interval[1]]
