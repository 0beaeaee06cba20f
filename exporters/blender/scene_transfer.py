# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer functions as node groups: the exact table as an image, and ColorRamps to edit by hand.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part.
"""
import bpy
import numpy

# ---- transfer functions ----------------------------------------------------------------------------------------


def color_table(tf):
    """The colour maps as an image: one row a level, or the rows of its 2D transfer function, one column an entry; packed, exact in 32-bit float.

    Where rows have fewer entries than columns the last one is repeated."""
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
    """What a level's object tells the shader: value of entry 0, entries per value, number of the last entry."""
    last = len(table["entries"]) // (4 * table["rows"]) - 1
    return [table["lo"], last / (table["hi"] - table["lo"]), float(last)]


def transfer_function_group(tf):
    """Scalar to colour and extinction per unit: entry (s - lo) (N - 1) / (hi - lo), at the texels' centres."""
    group = Group("isoshade transfer function", [('NodeSocketFloat', "Scalar", 0.0), ('NodeSocketVector', "Table", (0, 1, 1)),
                                                 ('NodeSocketFloat', "Row", 0.0)],
                  [('NodeSocketColor', "Color"), ('NodeSocketFloat', "Extinction")])
    image = color_table(tf)
    width, rows = image.size
    table = group.node('ShaderNodeSeparateXYZ', "first value, entries per value, last entry",
                       {0: group.given["Table"]}).outputs
    offset = group.math('SUBTRACT', group.given["Scalar"], table[0], label="from the first value")
    entry = group.math('MAXIMUM', group.math('MULTIPLY', offset, table[1]), 0.0)
    entry = group.math('MINIMUM', entry, table[2], label="entry")
    x = group.math('MULTIPLY_ADD', entry, 1 / width, 0.5 / width, label="between texel centres")
    y = group.math('MULTIPLY_ADD', group.given["Row"], 1 / rows, 0.5 / rows, label="the level's row")
    where = group.node('ShaderNodeCombineXYZ', "", {0: x, 1: y}).outputs[0]
    texel = group.node('ShaderNodeTexImage', "", {0: where}, image=image, interpolation='Linear', extension='EXTEND',
                       projection='FLAT').outputs
    return group.finish(Color=texel["Color"], Extinction=texel["Alpha"])


def ramp_group(ramp):
    """The first level's colour map by a ColorRamp of at most 32 stops: less exact, but easy to edit. Of classes a stop
    each, constant from halfway to the class before: exact."""
    group = Group("isoshade ramp", [('NodeSocketFloat', "Scalar", 0.0)],
                  [('NodeSocketColor', "Color"), ('NodeSocketFloat', "Extinction")])
    offset = group.math('SUBTRACT', group.given["Scalar"], ramp["lo"], label="from the range's start")
    u = group.math('MULTIPLY', offset, 1 / (ramp["hi"] - ramp["lo"]), label="fraction of the range", clamp=True)
    node = group.node('ShaderNodeValToRGB', "", {0: u})
    stops = node.color_ramp.elements
    node.color_ramp.interpolation = 'CONSTANT' if ramp.get("constant") else 'LINEAR'
    while len(stops) < len(ramp["stops"]):
        stops.new(1.0)
    for stop, (position, red, green, blue, alpha) in zip(stops, ramp["stops"]):
        stop.position = position
        stop.color = (red, green, blue, alpha)
    extinction = group.math('MULTIPLY', node.outputs["Alpha"], ramp["max_extinction"], label="extinction of alpha 1")
    return group.finish(Color=node.outputs["Color"], Extinction=extinction)
