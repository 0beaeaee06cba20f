# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of a volume: the surface at a value, and the voxels of each label."""
import json

import bpy
import numpy
from bpy.props import FloatProperty, IntProperty

from . import tables, volume
from .operators import Button
from .tables import Refused

MOST_FACES = 20_000_000  # of labels


def own_material(name, color):
    look = bpy.data.materials.new(name)
    look.use_nodes = True
    node = next(node for node in look.node_tree.nodes if node.type == 'BSDF_PRINCIPLED')
    node.inputs["Base Color"].default_value = (*(min(max(float(v), 0), 1) for v in color), 1)
    look.diffuse_color = node.inputs["Base Color"].default_value
    return look


def add_part(frame, name, mesh, color):
    """Adds a mesh that moves with the volume."""
    thing = bpy.data.objects.new(name, mesh)
    thing.data.materials.append(own_material(name, color))
    thing.parent = frame
    for collection in frame.users_collection:
        collection.objects.link(thing)
    return thing


# ---- the surface at a value --------------------------------------------------------------------------------------


def mover(thing):
    """A group of geometry nodes that moves a mesh of a grid to the grid's values. The object has the offset of this
    Blender's Cycles, and Volume to Mesh adds half a spacing along x, y and z, also if the grid is rotated."""
    spacing = volume.spacing_of(thing)
    if not spacing:
        raise Refused(f"{thing.name}: the file of its grids is missing")
    offset = [a + h / 2 for a, h in zip(volume.numbers(thing, "isoshade_offset", 3), spacing)]
    tree = bpy.data.node_groups.new("isoshade place", 'GeometryNodeTree')
    if hasattr(tree, "interface"):
        for way in ('INPUT', 'OUTPUT'):
            tree.interface.new_socket(name="Geometry", in_out=way, socket_type='NodeSocketGeometry')
    else:
        tree.inputs.new('NodeSocketGeometry', "Geometry")
        tree.outputs.new('NodeSocketGeometry', "Geometry")
    kinds = ('NodeGroupInput', 'GeometryNodeTransform', 'NodeGroupOutput')
    source, move, sink = (tree.nodes.new(kind) for kind in kinds)
    move.location, sink.location = (200, 0), (400, 0)
    move.inputs["Translation"].default_value = [-v for v in offset]
    tree.links.new(source.outputs["Geometry"], move.inputs["Geometry"])
    tree.links.new(move.outputs["Geometry"], sink.inputs["Geometry"])
    return tree


def color_at(thing, value):
    table, ramp = volume.Table(thing), volume.ramp_of(thing)
    return tables.look_up(table.read(), table.lo, table.hi, numpy.array([value]), ramp.unit)[0]


def middle_of_steepest(thing):
    """Returns the value at which the opacity rises most."""
    table, ramp = volume.Table(thing), volume.ramp_of(thing)
    values = tables.values_of(table.lo, table.hi, table.count)
    rise = numpy.diff(tables.opacity(table.read()[:, 3], ramp.unit))
    i = int(rise.argmax())
    return tables.plain((values[i] + values[i + 1]) / 2)


def add_surface(frame, value):
    thing = volume.shown_object(frame)
    if "isoshade_labels_size" in thing:
        raise Refused(f"{frame.name}: is a label map; make meshes of its labels")
    if any(lo <= value <= hi for lo, hi in volume.hidden_values(frame)):
        raise Refused(f"The grids leave out values around {value:g}; import the volume with all voxels")
    place_group = mover(thing)
    name = f"{frame.name} at {value:g}"
    surface = add_part(frame, name, bpy.data.meshes.new(name), color_at(thing, value)[:3])
    surface["isoshade_surface_level"] = int(thing["isoshade_level"])
    maker = surface.modifiers.new("Volume to Mesh", 'VOLUME_TO_MESH')
    maker.object, maker.grid_name, maker.threshold = thing, "density", value
    maker.resolution_mode, maker.use_smooth_shade = 'GRID', True
    surface.modifiers.new("isoshade place", 'NODES').node_group = place_group
    return surface


# ---- labels ------------------------------------------------------------------------------------------------------


def label_image(thing):
    for tree in volume.look_of(thing)[1]:
        for node in tree.nodes:
            if node.type == 'TEX_IMAGE' and node.image and node.image.name.startswith("isoshade labels"):
                return node.image
    raise Refused(f"{thing.name}: its material has no image of labels")


def read_classes(thing):
    """Returns the class of each voxel [z, y, x]."""
    image = label_image(thing)
    width, height = image.size
    pixels = numpy.empty(4 * width * height, numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels = numpy.rint(255 * pixels.reshape(height, width, 4)[::-1]).astype(int)
    classes = pixels[:, :, 0] + 256 * pixels[:, :, 1]
    nx, ny, nz = (int(v) for v in volume.numbers(thing, "isoshade_labels_size", 3))
    across, first, _ = (int(v) for v in volume.numbers(thing, "isoshade_labels_tiles", 3))
    if min(nx, ny, nz, across) < 1 or nx * across > width or first + ny * -(-nz // across) > height:
        raise Refused(f"{thing.name}: its labels are not in their image")
    found = numpy.empty((nz, ny, nx), int)
    for z in range(nz):
        row, column = first + ny * (z // across), nx * (z % across)
        found[z] = classes[row:row + ny, column:column + nx]
    return found


def faces_of(inside):
    """Returns the corners (index x, y, z) of the faces between inside and outside, four each, seen from outside."""
    around = numpy.pad(inside, 1)
    found = []
    for axis in range(3):  # of [z, y, x]
        step = [0, 0, 0]
        step[axis] = 1
        u, v = numpy.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        for side in (0, 1):
            neighbor = numpy.roll(around, 1 if side == 0 else -1, axis)
            corner = numpy.argwhere(around & ~neighbor) - 1 + side * numpy.array(step)
            quad = numpy.stack([corner, corner + u, corner + u + v, corner + v], axis=1)
            # Axes are z, y, x here: a mirror image, which turns the order of corners around.
            found.append(quad[:, ::-1] if side == 1 else quad)
    return numpy.concatenate(found)[:, :, ::-1]


def voxel_mesh(name, inside, frame, cells):
    """Makes a mesh of voxel faces in the frame's coordinates. cells: voxels along the box; the last may be cut."""
    quads = faces_of(inside)
    if len(quads) > MOST_FACES:
        raise Refused(f"{name}: would have {len(quads)} faces, at most {MOST_FACES}; show a coarser level")
    size = numpy.array(inside.shape[::-1]) + 1
    flat = quads @ numpy.array([1, size[0], size[0] * size[1]])
    used, corner = numpy.unique(flat, return_inverse=True)
    index = numpy.stack([used % size[0], used // size[0] % size[1], used // (size[0] * size[1])], axis=1)
    part = numpy.minimum(index / numpy.array(cells), 1)
    box = numpy.array([frame.data.vertices[i].co for i in (0, 1, 2, 4)])
    edges = box[1:] - box[0]
    corner = corner.reshape(-1, 4)
    corner = corner[:, ::-1] if numpy.linalg.det(edges) < 0 else corner
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(used))
    mesh.vertices.foreach_set("co", (box[0] + part @ edges).ravel())
    mesh.loops.add(4 * len(corner))
    mesh.loops.foreach_set("vertex_index", numpy.ascontiguousarray(corner).ravel())
    mesh.polygons.add(len(corner))
    mesh.polygons.foreach_set("loop_start", 4 * numpy.arange(len(corner)))
    mesh.polygons.foreach_set("loop_total", numpy.full(len(corner), 4))
    mesh.update(calc_edges=True)
    return mesh


def class_names(frame, count):
    try:
        listed = [str(name or f"label {label}") for label, name in json.loads(frame["isoshade_classes"])]
    except (KeyError, TypeError, ValueError, RecursionError):
        listed = []
    return listed + [f"class {i}" for i in range(len(listed), count)]


def add_labels(frame, smooth):
    """Adds a mesh for each visible label of the shown level. Returns the meshes."""
    thing = volume.shown_object(frame)
    if "isoshade_labels_size" not in thing:
        raise Refused(f"{frame.name}: is not a label map; make a surface at a value")
    classes, cells = read_classes(thing), volume.numbers(thing, "isoshade_labels_cells", 3)
    rows = volume.Table(thing).read()
    names = class_names(frame, int(classes.max()) + 1)
    made = []
    for number in numpy.unique(classes):
        if number >= len(rows) or not rows[number][3] > 0:
            continue
        name = f"{frame.name} {names[number]}"
        part = add_part(frame, name, voxel_mesh(name, classes == number, frame, cells), rows[number][:3])
        if smooth:
            modifier = part.modifiers.new("Smooth", 'SMOOTH')
            modifier.iterations = smooth
        made.append(part)
    if not made:
        raise Refused(f"{frame.name}: the transfer function hides all labels")
    return made


# ---- buttons -----------------------------------------------------------------------------------------------------


class ISOSHADE_OT_surface(Button, bpy.types.Operator):
    """Add a mesh of the surface at a value, which can be changed in its modifier"""
    bl_idname, bl_label = "isoshade.surface", "Surface at Value"
    value: FloatProperty(name="Value", description="Of the volume, in its unit", precision=4)

    def invoke(self, context, _event):
        try:
            self.value = middle_of_steepest(volume.shown_object(volume.need_frame(context)))
        except Refused as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context):
        return f"{add_surface(volume.need_frame(context), tables.plain(self.value)).name} is a mesh"


class ISOSHADE_OT_labels(Button, bpy.types.Operator):
    """Add a mesh with its own material for each visible label"""
    bl_idname, bl_label = "isoshade.label_meshes", "Meshes of Labels"
    smooth: IntProperty(name="Smooth", description="Repeats of the Smooth modifier; 0: the faces of the voxels",
                        default=0, min=0, max=100)

    def work(self, context):
        made = add_labels(volume.need_frame(context), self.smooth)
        return f"{len(made)} labels are meshes"


classes = (ISOSHADE_OT_surface, ISOSHADE_OT_labels)
