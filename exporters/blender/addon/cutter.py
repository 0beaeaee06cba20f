# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutters: empties and closed meshes that cut a volume, exact for any phase of the ray's steps.

A group of nodes per cutter computes the part of a step inside of it, from the cutter's matrix, which drivers copy. A
box and a sphere are intersected with the ray. For a plane and a mesh the part follows from the signed distances at both
ends of the step; those of a mesh are sampled once to an image, so it must be cut again after it was edited."""
import math

import bmesh
import bpy
import numpy
from bpy.props import BoolProperty, EnumProperty
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from . import volume
from .operators import Button
from .tables import Refused
from .volume import MATH, socket

VECTOR = ("Vector", "Vector_001", "Vector_002")
CELLS = 64  # samples along the longest side of a mesh
MARGIN = 3  # samples around it
NAME = "isoshade cutter "


# ---- nodes -------------------------------------------------------------------------------------------------------


class Nodes:
    """Adds nodes to a tree. Operands are sockets or plain values."""

    def __init__(self, tree):
        self.tree = tree

    def add(self, kind, inputs, **settings):
        node = self.tree.nodes.new(kind)
        node.location = (200 * (len(self.tree.nodes) % 12), -220 * (len(self.tree.nodes) // 12))
        for key, value in settings.items():
            setattr(node, key, value)
        for key, operand in inputs.items():
            if isinstance(operand, bpy.types.NodeSocket):
                self.tree.links.new(operand, socket(node.inputs, key))
            else:
                socket(node.inputs, key).default_value = operand
        return node

    def math(self, operation, *operands, clamp=False):
        node = self.add('ShaderNodeMath', dict(zip(MATH, operands)), operation=operation, use_clamp=clamp)
        return node.outputs["Value"]

    def vector(self, operation, *operands):
        names = ("Vector", "Scale") if operation == 'SCALE' else VECTOR
        node = self.add('ShaderNodeVectorMath', dict(zip(names, operands)), operation=operation)
        return node.outputs['Value' if operation in ('DOT_PRODUCT', 'LENGTH') else 'Vector']

    def split(self, vector):
        return [self.add('ShaderNodeSeparateXYZ', {"Vector": vector}).outputs[axis] for axis in "XYZ"]

    def join(self, *components):
        return self.add('ShaderNodeCombineXYZ', dict(zip("XYZ", components))).outputs["Vector"]

    def driven(self, source, paths):
        """A vector whose components copy properties of an object."""
        node = self.add('ShaderNodeCombineXYZ', {})
        for axis, path in enumerate(paths):
            curve = node.inputs[axis].driver_add("default_value")
            curve.driver.type = 'AVERAGE'
            target = curve.driver.variables.new().targets[0]
            target.id, target.data_path = source, path
        return node.outputs["Vector"]


def place_in(nodes, cutter, size):
    """Returns the sample's position in the cutter's coordinates, and its change along a step."""
    a, b, c, origin = (nodes.driven(cutter, [f"matrix_world[{column}][{row}]" for row in range(3)])
                       for column in range(4))
    across = [nodes.vector('CROSS_PRODUCT', *pair) for pair in ((b, c), (c, a), (a, b))]
    whole = nodes.math('MULTIPLY', nodes.vector('DOT_PRODUCT', a, across[0]), size)
    geometry = nodes.add('ShaderNodeNewGeometry', {}).outputs
    step = nodes.add('ShaderNodeAttribute', {}, attribute_type='OBJECT', attribute_name="isoshade_step").outputs["Fac"]
    found = []
    away = nodes.vector('SUBTRACT', geometry["Position"], origin)
    for world in (away, nodes.vector('SCALE', geometry["Incoming"], step)):
        parts = [nodes.math('DIVIDE', nodes.vector('DOT_PRODUCT', row, world), whole) for row in across]
        found.append(nodes.join(*parts))
    return found


def overlap(nodes, enter, leave):
    enter, leave = nodes.math('MAXIMUM', enter, -0.5), nodes.math('MINIMUM', leave, 0.5)
    return nodes.math('MAXIMUM', nodes.math('SUBTRACT', leave, enter), 0.0)


def in_box(nodes, f, g):
    """Slab method for the box from -1 to 1."""
    g = nodes.vector('ADD', g, (1e-20, 1e-20, 1e-20))
    middle = nodes.vector('DIVIDE', nodes.vector('SCALE', f, -1.0), g)
    reach = nodes.vector('DIVIDE', (1.0, 1.0, 1.0), nodes.vector('ABSOLUTE', g))
    x, y, z = nodes.split(nodes.vector('SUBTRACT', middle, reach))
    enter = nodes.math('MAXIMUM', nodes.math('MAXIMUM', x, y), z)
    x, y, z = nodes.split(nodes.vector('ADD', middle, reach))
    return overlap(nodes, enter, nodes.math('MINIMUM', nodes.math('MINIMUM', x, y), z))


def in_sphere(nodes, f, g):
    """The ray's point nearest to the center, and half of the chord of the sphere of radius 1."""
    length = nodes.vector('LENGTH', g)
    along = nodes.vector('NORMALIZE', g)
    before = nodes.vector('DOT_PRODUCT', f, along)
    nearest = nodes.vector('SUBTRACT', f, nodes.vector('SCALE', along, before))
    left = nodes.math('SUBTRACT', 1.0, nodes.vector('DOT_PRODUCT', nearest, nearest))
    half = nodes.math('SQRT', nodes.math('MAXIMUM', left, 0.0))
    enter = nodes.math('DIVIDE', nodes.math('SUBTRACT', nodes.math('MULTIPLY', before, -1.0), half), length)
    leave = nodes.math('DIVIDE', nodes.math('SUBTRACT', half, before), length)
    return overlap(nodes, enter, leave)


def between(nodes, middle, change):
    """Part of a step with a positive value, for a value that is linear along the step."""
    change = nodes.math('ADD', nodes.math('ABSOLUTE', change), 1e-20)
    return nodes.math('ADD', nodes.math('DIVIDE', middle, change), 0.5, clamp=True)


def in_plane(nodes, f, g):
    return between(nodes, nodes.split(f)[2], nodes.split(g)[2])


# ---- meshes ------------------------------------------------------------------------------------------------------


def closed_mesh(cutter):
    """Returns the cutter's triangles in its own coordinates."""
    graph = bpy.context.evaluated_depsgraph_get()
    shown = cutter.evaluated_get(graph)
    mesh = bmesh.new()
    try:
        mesh.from_mesh(shown.to_mesh())
        shown.to_mesh_clear()
        if not mesh.faces or not all(edge.is_manifold for edge in mesh.edges):
            raise Refused(f"{cutter.name}: is not closed; a cutter needs a mesh without holes or loose edges")
        return BVHTree.FromBMesh(mesh), [vertex.co.copy() for vertex in mesh.verts]
    finally:
        mesh.free()


def crossings(tree, start, top):
    """Returns the heights at which a line along z crosses the mesh."""
    found, at = [], start.copy()
    while at.z < top:
        hit = tree.ray_cast(at, Vector((0, 0, 1)))[0]
        if hit is None:
            break
        found.append(hit.z)
        at.z = hit.z + 1e-6 * (top - start.z)
    return found


def distances(cutter):
    """Samples the signed distance to a mesh, positive inside. Returns values [z, y, x], the first sample's place, and
    the distance of samples."""
    tree, corners = closed_mesh(cutter)
    lo, hi = (Vector([pick(corner[a] for corner in corners) for a in range(3)]) for pick in (min, max))
    cell = max(hi - lo) / CELLS
    if not cell > 0:
        raise Refused(f"{cutter.name}: is empty")
    lo -= Vector([MARGIN * cell] * 3)
    count = [math.ceil((hi[a] - lo[a]) / cell) + MARGIN + 1 for a in range(3)]
    values = numpy.empty(count[::-1], numpy.float32)
    heights = lo.z + cell * numpy.arange(count[2])
    for y in range(count[1]):
        for x in range(count[0]):
            place = lo + Vector((x, y, 0)) * cell
            # The line is moved by a ten-thousandth of a cell, since it may miss or hit twice an edge of the mesh.
            line = Vector((place.x + 1.1e-4 * cell, place.y + 0.7e-4 * cell, place.z - cell))
            inside = numpy.searchsorted(crossings(tree, line, heights[-1] + cell), heights) % 2
            for z in range(count[2]):
                place.z = heights[z]
                far = tree.find_nearest(place)[3]
                values[z, y, x] = far if inside[z] else -far
    return values, lo, cell


def distance_image(values, name):
    """Makes an image with the slices as tiles."""
    nz, ny, nx = values.shape
    across = max(int(math.sqrt(nz * ny / nx)), 1)
    down = -(-nz // across)
    pixels = numpy.zeros((down * ny, across * nx, 4), numpy.float32)
    for z in range(nz):
        row, column = (z // across) * ny, (z % across) * nx
        pixels[row:row + ny, column:column + nx] = values[z][:, :, None]
    image = bpy.data.images.new(name, across * nx, down * ny, alpha=True, float_buffer=True, is_data=True)
    image.colorspace_settings.name = 'Non-Color'
    image.alpha_mode = 'CHANNEL_PACKED'
    if hasattr(image, "use_half_precision"):
        image.use_half_precision = False
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image, across


def in_mesh(nodes, f, g, cutter):
    values, lo, cell = distances(cutter)
    image, across = distance_image(values, NAME + cutter.name)
    nz, ny, nx = values.shape
    width, height = image.size

    def slice_at(x, y, z):
        down = nodes.math('FLOOR', nodes.math('DIVIDE', nodes.math('ADD', z, 0.5), float(across)))
        over = nodes.math('SUBTRACT', z, nodes.math('MULTIPLY', down, float(across)))
        u = nodes.math('DIVIDE', nodes.math('ADD', nodes.math('MULTIPLY_ADD', over, float(nx), x), 0.5), float(width))
        v = nodes.math('DIVIDE', nodes.math('ADD', nodes.math('MULTIPLY_ADD', down, float(ny), y), 0.5), float(height))
        return nodes.add('ShaderNodeTexImage', {"Vector": nodes.join(u, v, 0.0)}, image=image, interpolation='Linear',
                         extension='EXTEND', projection='FLAT').outputs["Alpha"]

    def at(place):
        """Outside of the samples the value there plus the distance to them: below the true one, and negative."""
        index = nodes.vector('SCALE', nodes.vector('SUBTRACT', place, tuple(lo)), 1 / cell)
        held = nodes.vector('MINIMUM', nodes.vector('MAXIMUM', index, (0, 0, 0)), (nx - 1, ny - 1, nz - 1))
        x, y, z = nodes.split(held)
        below = nodes.math('MINIMUM', nodes.math('FLOOR', z), float(nz - 2))
        first, second = slice_at(x, y, below), slice_at(x, y, nodes.math('ADD', below, 1.0))
        part = nodes.math('SUBTRACT', z, below)
        inside = nodes.math('MULTIPLY_ADD', part, nodes.math('SUBTRACT', second, first), first)
        away = nodes.vector('LENGTH', nodes.vector('SUBTRACT', index, held))
        return nodes.math('MULTIPLY_ADD', away, -cell, inside)

    half = nodes.vector('SCALE', g, 0.5)
    first, second = at(nodes.vector('SUBTRACT', f, half)), at(nodes.vector('ADD', f, half))
    middle = nodes.math('MULTIPLY', nodes.math('ADD', first, second), 0.5)
    return between(nodes, middle, nodes.math('SUBTRACT', second, first))


# ---- cutting -----------------------------------------------------------------------------------------------------


def shape_of(cutter):
    if cutter.type == 'MESH':
        return 'MESH'
    if cutter.type != 'EMPTY':
        raise Refused(f"{cutter.name}: is a {cutter.type.lower()}; a cutter is an empty or a closed mesh")
    return {'CUBE': 'BOX', 'SPHERE': 'SPHERE'}.get(cutter.empty_display_type, 'PLANE')


def cutter_group(cutter):
    """Makes the group that returns the kept part of a step."""
    tree = bpy.data.node_groups.new(NAME + cutter.name, 'ShaderNodeTree')
    if hasattr(tree, "interface"):
        tree.interface.new_socket(name="Kept", in_out='OUTPUT', socket_type='NodeSocketFloat')
    else:
        tree.outputs.new('NodeSocketFloat', "Kept")
    nodes, shape = Nodes(tree), shape_of(cutter)
    try:
        size = nodes.split(nodes.driven(cutter, ["empty_display_size"]))[0] if shape in ('BOX', 'SPHERE') else 1.0
        f, g = place_in(nodes, cutter, size)
        ways = {'BOX': in_box, 'SPHERE': in_sphere, 'PLANE': in_plane}
        part = ways[shape](nodes, f, g) if shape in ways else in_mesh(nodes, f, g, cutter)
    except Refused:
        bpy.data.node_groups.remove(tree)
        raise
    keeps = nodes.split(nodes.driven(cutter, ['["keep_inside"]']))[0]
    sign = nodes.math('MULTIPLY_ADD', keeps, 2.0, -1.0)
    kept = nodes.math('MULTIPLY_ADD', part, sign, nodes.math('SUBTRACT', 1.0, keeps))
    tree.links.new(kept, nodes.add('NodeGroupOutput', {}).inputs["Kept"])
    tree["isoshade_shape"] = shape
    return tree


def main_tree(frame):
    return volume.look_of(volume.shown_object(frame))[0].node_tree


def cutters_of(frame):
    """Returns nodes and objects of the cutters; an object is None after it was deleted."""
    found = []
    for node in main_tree(frame).nodes:
        if node.type == 'GROUP' and node.node_tree and "isoshade_shape" in node.node_tree:
            animation = node.node_tree.animation_data
            drivers = animation.drivers if animation else ()
            found.append((node, next((curve.driver.variables[0].targets[0].id for curve in drivers), None)))
    return found


def cut(frame, cutter, keep_inside):
    """Cuts a volume, and all that have its material; replaces the nodes of an earlier cut by this object."""
    tree = main_tree(frame)
    box = next((node for node in tree.nodes if node.type == 'GROUP' and "Inside" in node.outputs), None)
    if not box:
        raise Refused(f"{tree.name}: its part inside the box is missing; export again")
    cutter["keep_inside"] = int(keep_inside)
    cutter.update_tag()
    cutter.id_properties_ui("keep_inside").update(min=0, max=1, description="0: removes the inside. 1: keeps only it")
    group = cutter_group(cutter)
    remove(frame, cutter)
    node = tree.nodes.new('ShaderNodeGroup')
    node.node_tree, node.name = group, group.name
    both = tree.nodes.new('ShaderNodeMath')
    both.operation, both.name = 'MULTIPLY', group.name + " product"
    node.location, both.location = (box.location.x, box.location.y + 300), (box.location.x + 180, box.location.y + 200)
    users = [link.to_socket for link in box.outputs["Inside"].links]
    for user in users:
        tree.links.new(both.outputs["Value"], user)
    tree.links.new(box.outputs["Inside"], both.inputs[0])
    tree.links.new(node.outputs["Kept"], both.inputs[1])


def remove(frame, cutter=None):
    """Removes the nodes of one cutter, or of all. Returns their number."""
    tree, count = main_tree(frame), 0
    for node, owner in cutters_of(frame):
        if cutter is not None and owner != cutter:
            continue
        both = node.outputs["Kept"].links[0].to_node
        source = both.inputs[0].links[0].from_socket
        for user in [link.to_socket for link in both.outputs["Value"].links]:
            tree.links.new(source, user)
        group = node.node_tree
        images = [one.image for one in group.nodes if one.type == 'TEX_IMAGE']
        tree.nodes.remove(both)
        tree.nodes.remove(node)
        bpy.data.node_groups.remove(group)
        for image in {image for image in images if image and image.users <= 1}:
            bpy.data.images.remove(image)
        count += 1
    return count


def new_empty(frame, shape, context):
    """Adds an empty: a box over the corner nearest to the camera, or a sphere or a plane in the middle."""
    corners = [Vector(corner) for corner in frame.bound_box]
    middle = sum(corners, Vector()) / 8
    half = (corners[6] - corners[0]) / 2
    camera = context.scene.camera
    eye = frame.matrix_world.inverted() @ camera.matrix_world.translation if camera else corners[6]
    cutter = bpy.data.objects.new(f"{frame.name} cutter", None)
    cutter.empty_display_type = {'BOX': 'CUBE', 'SPHERE': 'SPHERE', 'PLANE': 'SINGLE_ARROW'}[shape]
    cutter.parent = frame
    near = Vector([half[a] if eye[a] > middle[a] else -half[a] for a in range(3)])
    cutter.location = middle + (near if shape == 'BOX' else Vector())
    if shape == 'BOX':
        cutter.scale = half
    else:
        cutter.scale = [min(half) / (2 if shape == 'SPHERE' else 1)] * 3
    for collection in frame.users_collection[:1] or (context.scene.collection,):
        collection.objects.link(cutter)
    return cutter


# ---- the reference -----------------------------------------------------------------------------------------------


def faces(cutter, shape):
    """Returns the kept half spaces as points and inward directions of the world; None if there are no such planes."""
    keeps = cutter.get("keep_inside", 0) > 0
    world, inverse = cutter.matrix_world, cutter.matrix_world.to_3x3().inverted().transposed()
    if shape == 'PLANE':
        return [(world.translation.copy(), inverse @ Vector((0, 0, 1 if keeps else -1)))]
    if shape != 'BOX' or not keeps:
        return None
    half, found = cutter.empty_display_size, []
    for axis in range(3):
        for side in (-1, 1):
            normal = Vector((0, 0, 0))
            normal[axis] = -side
            found.append((world @ (-half * normal), inverse @ normal))
    return found


def clip_planes(frame, point, direction):
    """Returns the cutters in the form of a scene's clip planes. point, direction: to the volume's millimeters."""
    planes = []
    for node, cutter in cutters_of(frame):
        kept = faces(cutter, node.node_tree["isoshade_shape"]) if cutter else None
        if kept is None:
            raise Refused(f"{cutter.name if cutter else node.name}: the reference cuts only by planes, and by a box "
                          "that keeps its inside; remove this cutter to certify")
        planes += [{"normal": list(direction(normal)), "point_mm": list(point(place))} for place, normal in kept]
    return planes


# ---- buttons -----------------------------------------------------------------------------------------------------


class ISOSHADE_OT_cut(Button, bpy.types.Operator):
    """Cut the volume by a new empty, or by the active empty or closed mesh; after editing a mesh, cut again"""
    bl_idname, bl_label = "isoshade.cut", "Cut"
    shape: EnumProperty(name="Shape", items=(('BOX', "Box", "An empty cube"), ('SPHERE', "Sphere", "An empty sphere"),
                                             ('PLANE', "Plane", "An arrow: its side is cut away, or kept"),
                                             ('ACTIVE', "Active", "The active empty, or closed mesh")))
    keep_inside: BoolProperty(name="Keep inside", description="Keep only the inside, or a plane's side of the arrow")

    def work(self, context):
        active = context.view_layer.objects.active
        frame = volume.need_frame(context)
        if self.shape != 'ACTIVE':
            active = new_empty(frame, self.shape, context)
        elif not active or active == frame or active in volume.levels_of(frame):
            raise Refused("Make an empty or a closed mesh the active object")
        context.view_layer.update()
        cut(frame, active, self.keep_inside)
        if active.type == 'MESH':
            active.display_type, active.hide_render = 'WIRE', True
        return f"{active.name} cuts {frame.name}"


class ISOSHADE_OT_uncut(Button, bpy.types.Operator):
    """Remove all cuts of the volume; the objects stay"""
    bl_idname, bl_label = "isoshade.uncut", "Remove Cuts"

    def work(self, context):
        frame = volume.need_frame(context)
        return f"{frame.name}: {remove(frame)} cuts removed"


classes = (ISOSHADE_OT_cut, ISOSHADE_OT_uncut)
