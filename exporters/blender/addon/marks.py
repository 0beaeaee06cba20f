# SPDX-License-Identifier: GPL-3.0-or-later
"""A scale bar and axes: objects that move and scale with the volume, so that their lengths stay those of the data."""
import math

import bpy
from bpy.props import FloatProperty
from mathutils import Vector

from . import tables, volume
from .operators import Button

COLORS = {"bar": (1, 1, 1), "x": (0.8, 0.1, 0.1), "y": (0.15, 0.6, 0.15), "z": (0.15, 0.3, 0.9)}
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))  # of a box
# Size in mm, and the first size of the next unit.
UNITS = ((1e-6, 1e-3, "nm"), (1e-3, 1.0, "µm"), (1.0, 1e3, "mm"), (1e3, 1e6, "m"))


def paint(name):
    """Returns a material that needs no lamp and lights nothing that the camera sees."""
    look = bpy.data.materials.get(f"isoshade {name}")
    if look:
        return look
    look = bpy.data.materials.new(f"isoshade {name}")
    look.use_nodes = True
    nodes, links = look.node_tree.nodes, look.node_tree.links
    nodes.clear()
    glow, out = nodes.new('ShaderNodeEmission'), nodes.new('ShaderNodeOutputMaterial')
    glow.inputs["Color"].default_value = look.diffuse_color = (*COLORS[name], 1)
    links.new(glow.outputs["Emission"], out.inputs["Surface"])
    return look


def add(frame, name, data, look, place):
    thing = bpy.data.objects.new(name, data)
    data.materials.append(look)
    thing.parent, thing.location = frame, place
    for ray in ("diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
        setattr(thing, f"visible_{ray}", False)
    for collection in frame.users_collection:
        collection.objects.link(thing)
    return thing


def face_camera(thing, scene):
    """Turns a mark like the camera's picture, in which a bar then has its true length."""
    if scene.camera:
        thing.constraints.new('COPY_ROTATION').target = scene.camera


def bars(boxes):
    """Makes a mesh of boxes, given by their lowest and highest corners."""
    corners, faces = [], []
    for lo, hi in boxes:
        at = len(corners)
        corners += [[(lo, hi)[i >> a & 1][a] for a in range(3)] for i in range(8)]
        faces += [[at + i for i in face] for face in SIDES]
    mesh = bpy.data.meshes.new("isoshade mark")
    mesh.from_pydata(corners, [], faces)
    return mesh


def letters(words, size):
    text = bpy.data.curves.new("isoshade words", 'FONT')
    text.body, text.size, text.align_x = words, size, 'CENTER'
    return text


def extent(frame):
    """Returns the lowest corner, the middle, the longest side and half of the diagonal, in the frame's coordinates."""
    corners = [Vector(corner) for corner in frame.bound_box]
    sides = corners[6] - corners[0]
    return corners[0], (corners[0] + corners[6]) / 2, max(sides), sides.length / 2


def round_length(most):
    """Returns the largest of 1, 2 or 5 times a power of ten that is not longer."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(digit * power for digit in (5, 2, 1) if digit * power <= most * (1 + 1e-9))


def in_words(mm):
    size, _, name = next((unit for unit in UNITS if mm < 0.9999 * unit[1]), UNITS[-1])
    return f"{mm / size:.6g} {name}"


def add_scale_bar(frame, scene, length_mm):
    units = tables.number(volume.noted(frame, scene, "isoshade_units_per_mm", 1.0), "isoshade_units_per_mm",
                          0.01 * tables.LEAST_MM, 100 * tables.MOST_MM)
    _, middle, longest, radius = extent(frame)
    mm = length_mm or round_length(0.4 * longest / units)
    half, thick = mm * units / 2, 0.006 * longest
    up = Vector((0, 0, 1))
    if scene.camera:
        turn = frame.matrix_world.inverted().to_3x3() @ scene.camera.matrix_world.to_3x3()
        up = (turn @ Vector((0, 1, 0))).normalized()
    place = middle - 0.8 * radius * up
    ends = [((side * half - (side > 0) * thick, -2 * thick, 0), (side * half + (side < 0) * thick, 3 * thick, thick))
            for side in (-1, 1)]
    mesh = bars([((-half, 0, 0), (half, thick, thick)), *ends])
    words = in_words(mm)
    bar = add(frame, f"{frame.name} scale bar {words}", mesh, paint("bar"), place)
    label = add(frame, f"{bar.name} text", letters(words, 0.07 * longest), paint("bar"), (0, -0.09 * longest, 0))
    label.parent = bar
    face_camera(bar, scene)
    bar["isoshade_length_mm"] = mm
    return bar


def add_axes(frame, scene):
    low, _, longest, _ = extent(frame)
    length, thick = 0.25 * longest, 0.006 * longest
    made = []
    for axis, name in enumerate("xyz"):
        lo, hi = [-thick / 2] * 3, [thick / 2] * 3
        hi[axis] = length
        made.append(add(frame, f"{frame.name} axis {name}", bars([(lo, hi)]), paint(name), low))
        end = low.copy()
        end[axis] += 1.15 * length
        label = add(frame, f"{frame.name} axis {name} text", letters(name, 0.07 * longest), paint(name), end)
        label.data.align_y = 'CENTER'
        face_camera(label, scene)
    return made


class ISOSHADE_OT_scale_bar(Button, bpy.types.Operator):
    """Add a scale bar in the plane of the camera's picture; it moves and scales with the volume"""
    bl_idname, bl_label = "isoshade.scale_bar", "Scale Bar"
    length_mm: FloatProperty(name="Length", description="In mm of the data; 0: a round length below half of the box",
                             default=0, min=0)

    def work(self, context):
        bar = add_scale_bar(volume.need_frame(context), context.scene, tables.plain(self.length_mm))
        return f"{bar.name} is added"


class ISOSHADE_OT_axes(Button, bpy.types.Operator):
    """Add the axes x, y and z of the data at the lowest corner of the volume"""
    bl_idname, bl_label = "isoshade.axes", "Axes"

    def work(self, context):
        frame = volume.need_frame(context)
        add_axes(frame, context.scene)
        return f"{frame.name} has axes"


classes = (ISOSHADE_OT_scale_bar, ISOSHADE_OT_axes)
