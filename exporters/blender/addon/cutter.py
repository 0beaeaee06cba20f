# SPDX-License-Identifier: GPL-3.0-or-later
"""Cutters: empties and closed meshes that cut a volume, exact for any phase of the ray's steps.

A group of nodes per cutter computes the interval of a step inside of it, in steps from its middle, from the cutter's
matrix, which drivers copy. A box and a sphere are intersected with the ray. For a plane and a mesh the interval follows
from the signed distances at both ends of the step; those of a mesh are sampled once to an image, so it must be cut
again after it was edited. Another group joins the intervals. A cutter's property isoshade_cuts points to its volume, so
that copies cut, too: follow() makes their nodes, and removes those of deleted cutters."""
import hashlib
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
JOINED = "isoshade cutters"
NUMBER = "isoshade_cut_number"  # of the volumes that a cutter cuts
KEEPS = '["keep_inside"]'
ENDS = ("Keeps From", "Keeps To", "Cuts From", "Cuts To")


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

    def finish(self, results):
        sink = self.add('NodeGroupOutput', {})
        for name, result in results.items():
            self.tree.links.new(result, sink.inputs[name])

    def driven(self, source, paths):
        """A vector whose components copy properties of an object."""
        node = self.add('ShaderNodeCombineXYZ', {})
        for axis, path in enumerate(paths):
            curve = node.inputs[axis].driver_add("default_value")
            curve.driver.type = 'AVERAGE'
            target = curve.driver.variables.new().targets[0]
            target.id, target.data_path = source, path
        return node.outputs["Vector"]


def place_in(nodes, cutter, frame, size):
    """Returns the sample's position in the cutter's coordinates, and its change along a step. Both come from the
    volume's own coordinates, so that copies and instances of the volume are cut like it."""
    def columns(thing):
        return [nodes.driven(thing, [f"matrix_world[{column}][{row}]" for row in range(3)]) for column in range(4)]

    def attribute(name, output):
        return nodes.add('ShaderNodeAttribute', {}, attribute_type='OBJECT', attribute_name=name).outputs[output]

    own = nodes.add('ShaderNodeTexCoord', {}).outputs["Object"]
    own = nodes.vector('ADD', own, attribute("isoshade_offset", "Vector"))
    incoming = nodes.add('ShaderNodeNewGeometry', {}).outputs["Incoming"]
    step = nodes.vector('SCALE', incoming, attribute("isoshade_step", "Fac"))
    step = nodes.add('ShaderNodeVectorTransform', {"Vector": step}, vector_type='VECTOR', convert_from='WORLD',
                     convert_to='OBJECT').outputs["Vector"]
    fa, fb, fc, frame_origin = columns(frame)
    a, b, c, origin = columns(cutter)
    across = [nodes.vector('CROSS_PRODUCT', *pair) for pair in ((b, c), (c, a), (a, b))]
    whole = nodes.math('MULTIPLY', nodes.vector('DOT_PRODUCT', a, across[0]), size)
    found = []
    for local, start in ((own, nodes.vector('SUBTRACT', frame_origin, origin)), (step, (0, 0, 0))):
        world = start
        for part, column in zip(nodes.split(local), (fa, fb, fc)):
            world = nodes.vector('ADD', world, nodes.vector('SCALE', column, part))
        parts = [nodes.vector('DOT_PRODUCT', row, world) for row in across]
        found.append(nodes.join(*(nodes.math('DIVIDE', part, whole) for part in parts)))
    return found


def in_box(nodes, f, g):
    """Slab method for the box from -1 to 1."""
    g = nodes.vector('ADD', g, (1e-20, 1e-20, 1e-20))
    middle = nodes.vector('DIVIDE', nodes.vector('SCALE', f, -1.0), g)
    reach = nodes.vector('DIVIDE', (1.0, 1.0, 1.0), nodes.vector('ABSOLUTE', g))
    x, y, z = nodes.split(nodes.vector('SUBTRACT', middle, reach))
    enter = nodes.math('MAXIMUM', nodes.math('MAXIMUM', x, y), z)
    x, y, z = nodes.split(nodes.vector('ADD', middle, reach))
    return enter, nodes.math('MINIMUM', nodes.math('MINIMUM', x, y), z)


def in_sphere(nodes, f, g):
    """The ray's point nearest to the center, and half of the chord of the sphere of radius 1."""
    length = nodes.vector('LENGTH', g)
    along = nodes.vector('NORMALIZE', g)
    before = nodes.vector('DOT_PRODUCT', f, along)
    nearest = nodes.vector('SUBTRACT', f, nodes.vector('SCALE', along, before))
    left = nodes.math('SUBTRACT', 1.0, nodes.vector('DOT_PRODUCT', nearest, nearest))
    half = nodes.math('SQRT', nodes.math('MAXIMUM', left, 0.0))
    enter = nodes.math('DIVIDE', nodes.math('SUBTRACT', nodes.math('MULTIPLY', before, -1.0), half), length)
    return enter, nodes.math('DIVIDE', nodes.math('SUBTRACT', half, before), length)


def where_positive(nodes, middle, change):
    """The interval with positive values, for a value that is linear along the step."""
    change = nodes.math('ADD', change, 1e-20)
    crossing = nodes.math('DIVIDE', nodes.math('MULTIPLY', middle, -1.0), change)
    crossing = within_step(nodes, crossing)
    rises = nodes.math('GREATER_THAN', change, 0.0)
    falls = nodes.math('SUBTRACT', 1.0, rises)
    return (nodes.math('MULTIPLY_ADD', rises, nodes.math('ADD', crossing, 0.5), -0.5),
            nodes.math('MULTIPLY_ADD', falls, nodes.math('SUBTRACT', crossing, 0.5), 0.5))


def within_step(nodes, value):
    return nodes.math('MINIMUM', nodes.math('MAXIMUM', value, -0.5), 0.5)


def in_plane(nodes, f, g):
    return where_positive(nodes, nodes.split(f)[2], nodes.split(g)[2])


# ---- meshes ------------------------------------------------------------------------------------------------------


def closed_mesh(cutter):
    """Returns the cutter's triangles in its own coordinates, its vertices, and a digest of both."""
    graph = bpy.context.evaluated_depsgraph_get()
    shown = cutter.evaluated_get(graph)
    mesh = bmesh.new()
    try:
        mesh.from_mesh(shown.to_mesh())
        shown.to_mesh_clear()
        if not mesh.faces or not all(edge.is_manifold for edge in mesh.edges):
            raise Refused(f"{cutter.name}: is not closed; a cutter needs a mesh without holes or loose edges")
        corners = [vertex.co.copy() for vertex in mesh.verts]
        faces_of = [[vertex.index for vertex in face.verts] for face in mesh.faces]
        digest = hashlib.sha256(repr(([tuple(corner) for corner in corners], faces_of)).encode()).hexdigest()
        return BVHTree.FromBMesh(mesh), corners, digest
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


def distances(cutter, tree, corners):
    """Samples the signed distance to a mesh, positive inside. Returns values [z, y, x], the first sample's place, and
    the distance of samples."""
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


def image_of(cutter):
    """Returns the image of a mesh's distances, that of an equal mesh if there is one, and where its samples are."""
    tree, corners, digest = closed_mesh(cutter)
    image = next((image for image in bpy.data.images if image.get("isoshade_mesh") == digest), None)
    if not image:
        values, lo, cell = distances(cutter, tree, corners)
        image, across = distance_image(values, NAME + cutter.name)
        image["isoshade_mesh"], image["isoshade_samples"] = digest, [*lo, cell, *values.shape[::-1], across]
    return image, list(image["isoshade_samples"])


def in_mesh(nodes, f, g, cutter):
    image, (*lo, cell, nx, ny, nz, across) = image_of(cutter)
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
    return where_positive(nodes, middle, nodes.math('SUBTRACT', second, first))


# ---- cutting -----------------------------------------------------------------------------------------------------


def shape_of(cutter):
    if cutter.type == 'MESH':
        return 'MESH'
    if cutter.type != 'EMPTY':
        raise Refused(f"{cutter.name}: is a {cutter.type.lower()}; a cutter is an empty or a closed mesh")
    return {'CUBE': 'BOX', 'SPHERE': 'SPHERE'}.get(cutter.empty_display_type, 'PLANE')


def new_group(name, inputs, outputs):
    tree = bpy.data.node_groups.new(name, 'ShaderNodeTree')
    for way, labels in (('INPUT', inputs), ('OUTPUT', outputs)):
        for label in labels:
            if hasattr(tree, "interface"):
                tree.interface.new_socket(name=label, in_out=way, socket_type='NodeSocketFloat')
            else:
                (tree.inputs if way == 'INPUT' else tree.outputs).new('NodeSocketFloat', label)
    return tree


def cutter_group(cutter, frame):
    """Makes the group that returns the interval of a step that a cutter keeps, and the one that it removes."""
    tree = new_group(NAME + cutter.name, (), ENDS)
    nodes, shape = Nodes(tree), shape_of(cutter)
    try:
        size = nodes.split(nodes.driven(cutter, ["empty_display_size"]))[0] if shape in ('BOX', 'SPHERE') else 1.0
        f, g = place_in(nodes, cutter, frame, size)
        ways = {'BOX': in_box, 'SPHERE': in_sphere, 'PLANE': in_plane}
        enter, leave = ways[shape](nodes, f, g) if shape in ways else in_mesh(nodes, f, g, cutter)
    except Refused:
        bpy.data.node_groups.remove(tree)
        raise
    enter = within_step(nodes, enter)
    leave = nodes.math('MAXIMUM', within_step(nodes, leave), enter)
    number = nodes.add('ShaderNodeAttribute', {}, attribute_type='OBJECT', attribute_name=NUMBER).outputs["Fac"]
    mine = nodes.math('COMPARE', number, float(number_of(frame)), 0.5)
    inside = nodes.math('MULTIPLY', nodes.split(nodes.driven(cutter, [KEEPS]))[0], mine)
    removes = nodes.math('SUBTRACT', mine, inside)
    nodes.finish({
        "Keeps From": nodes.math('MULTIPLY_ADD', inside, nodes.math('ADD', enter, 0.5), -0.5),
        "Keeps To": nodes.math('MULTIPLY_ADD', inside, nodes.math('SUBTRACT', leave, 0.5), 0.5),
        "Cuts From": enter,
        "Cuts To": nodes.math('MULTIPLY_ADD', removes, nodes.math('SUBTRACT', leave, enter), enter)})
    tree["isoshade_shape"], tree["isoshade_number"] = shape, number_of(frame)
    return tree


def joined(groups):
    """Makes the group that returns the part of a step that all cutters leave: what they all keep, without the union of
    what they remove. That is a sum of gaps, from the start and from each removed interval's end to the next start of an
    interval that ends later."""
    tree = new_group(JOINED, ("Enter", "Leave"), ("Inside",))
    nodes = Nodes(tree)
    given = nodes.add('NodeGroupInput', {}).outputs
    found = [nodes.add('ShaderNodeGroup', {}, node_tree=group).outputs for group in groups]
    first, last = given["Enter"], given["Leave"]
    for one in found:
        first = nodes.math('MAXIMUM', first, one["Keeps From"])
        last = nodes.math('MINIMUM', last, one["Keeps To"])
    cuts = [[nodes.math('MAXIMUM', nodes.math('MINIMUM', one[end], last), first) for end in ("Cuts From", "Cuts To")]
            for one in found]
    stops = [last] * (1 + len(cuts))
    for i, (begin, end) in enumerate(cuts):
        stops[0] = nodes.math('MINIMUM', stops[0], begin)
        for j, (other_begin, other_end) in enumerate(cuts[:i]):
            is_later = nodes.math('LESS_THAN', other_end, end)  # of equal ends one counts
            beyond = nodes.math('SUBTRACT', 1.0, is_later)
            stops[1 + i] = nodes.math('MINIMUM', stops[1 + i], nodes.math('ADD', other_begin, is_later))
            stops[1 + j] = nodes.math('MINIMUM', stops[1 + j], nodes.math('ADD', begin, beyond))
    total = 0.0
    for start, stop in zip([first] + [end for _, end in cuts], stops):
        total = nodes.math('ADD', total, nodes.math('MAXIMUM', nodes.math('SUBTRACT', stop, start), 0.0))
    nodes.finish({"Inside": total})
    return tree


def main_tree(frame):
    return volume.look_of(volume.shown_object(frame))[0].node_tree


def number_of(frame):
    return int(volume.levels_of(frame)[0].get(NUMBER, 0))


def set_number(frame):
    """Gives a volume a number of its own: copies with the same number share its cutters."""
    number = 1 + max(int(thing.get(NUMBER, 0)) for thing in bpy.data.objects)
    for thing in volume.levels_of(frame):
        thing[NUMBER] = float(number)


def join_node(tree):
    return next((node for node in tree.nodes
                 if node.type == 'GROUP' and node.node_tree and node.node_tree.name.startswith(JOINED)), None)


def owner_of(group):
    """Returns the object of a cutter's group; None after it was deleted."""
    curves = group.animation_data.drivers if group.animation_data else ()
    targets = [curve.driver.variables[0].targets[0] for curve in curves]
    return next((target.id for target in targets if target.data_path == KEEPS), None)


def groups_in(tree):
    join = join_node(tree)
    return [node.node_tree for node in join.node_tree.nodes if node.type == 'GROUP' and node.node_tree] if join else []


def cutters_of(frame):
    """Returns groups and objects of a volume's cutters."""
    number = number_of(frame)
    return [(group, owner_of(group)) for group in groups_in(main_tree(frame)) if group["isoshade_number"] == number]


def connect(tree, groups):
    """Makes the part of a step inside the box that of all cutters, too; removes groups that are no longer in use."""
    box = next((node for node in tree.nodes if node.type == 'GROUP' and "Enter" in node.outputs), None)
    if not box:
        raise Refused(f"{tree.name}: its part inside the box is missing; export again")
    old, before = join_node(tree), groups_in(tree)
    source = (old or box).outputs["Inside"]
    users, result = [link.to_socket for link in source.links], box.outputs["Inside"]
    if groups:
        join = tree.nodes.new('ShaderNodeGroup')
        join.node_tree, join.location = joined(groups), (box.location.x, box.location.y + 300)
        for end in ("Enter", "Leave"):
            tree.links.new(box.outputs[end], join.inputs[end])
        result = join.outputs["Inside"]
    for user in users:
        tree.links.new(result, user)
    if old:
        bpy.data.node_groups.remove(old.node_tree)
        tree.nodes.remove(old)
    for group in before:
        if group not in groups:
            images = {node.image for node in group.nodes if node.type == 'TEX_IMAGE'}
            bpy.data.node_groups.remove(group)
            for image in images:
                if image and not image.users:
                    bpy.data.images.remove(image)


def cut(frame, cutters, keep_inside):
    """Cuts a volume; replaces the nodes of earlier cuts by these objects."""
    for cutter in cutters:
        cutter["keep_inside"] = int(keep_inside)
        cutter.id_properties_ui("keep_inside").update(min=0, max=1, description="0: removes the inside. 1: keeps only it")
        cutter.update_tag()
    if not number_of(frame):
        set_number(frame)
    tree, made = main_tree(frame), []
    try:
        for cutter in cutters:
            made.append(cutter_group(cutter, frame))
        connect(tree, [group for group in groups_in(tree) if owner_of(group) not in cutters] + made)
    except Refused:
        for group in made:
            bpy.data.node_groups.remove(group)
        raise
    for cutter in cutters:
        cutter["isoshade_cuts"] = frame


def remove(frame):
    """Removes all cuts of a volume. Returns their number."""
    tree, found = main_tree(frame), cutters_of(frame)
    for _, owner in found:
        if owner and "isoshade_cuts" in owner:
            del owner["isoshade_cuts"]
    connect(tree, [group for group in groups_in(tree) if group not in {group for group, _ in found}])
    return len(found)


# ---- copies ------------------------------------------------------------------------------------------------------

object_count = -1  # at the last look


def cuts(thing):
    """Returns the volume that an object of some scene cuts, or None."""
    frame = thing.get("isoshade_cuts") if thing and thing.users_scene else None
    return frame if isinstance(frame, bpy.types.Object) and frame.users_scene and volume.levels_of(frame) else None


def follow_copies():
    """Gives copied cutters their nodes, and takes those of deleted ones. A copied volume with copied cutters gets a
    number of its own."""
    wanted = {}
    for thing in bpy.data.objects:
        frame = cuts(thing) if "isoshade_cuts" in thing and not thing.library else None
        if frame and not frame.library:
            wanted.setdefault(frame, []).append(thing)
    frames = {thing.parent for thing in bpy.data.objects if thing.type == 'VOLUME' and NUMBER in thing and thing.parent}
    for frame in frames:
        try:
            tree = main_tree(frame)
            groups = groups_in(tree)
            kept = [group for group in groups if cuts(owner_of(group))]
            owners = [owner_of(group) for group in kept]
            new = [thing for thing in wanted.get(frame, ()) if thing not in owners]
            if new and not any(cuts(owner) == frame for owner in owners):
                set_number(frame)
            kept += [cutter_group(thing, frame) for thing in new]
            if kept != groups:
                connect(tree, kept)
        except Refused:  # of a file that others made
            continue


@bpy.app.handlers.persistent
def follow(*_):
    """Looks for copied and deleted cutters, if the number of objects has changed."""
    global object_count
    if len(bpy.data.objects) == object_count:
        return
    object_count = len(bpy.data.objects)
    if bpy.app.background:
        follow_copies()
    elif not bpy.app.timers.is_registered(follow_copies):
        bpy.app.timers.register(follow_copies, first_interval=0)


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
    for group, cutter in cutters_of(frame):
        kept = faces(cutter, group["isoshade_shape"]) if cutter else None
        if kept is None:
            raise Refused(f"{cutter.name if cutter else group.name}: the reference cuts only by planes, and by a box "
                          "that keeps its inside; remove this cutter to certify")
        planes += [{"normal": list(direction(normal)), "point_mm": list(point(place))} for place, normal in kept]
    return planes


# ---- buttons -----------------------------------------------------------------------------------------------------


def chosen(frame, context):
    """Returns the selected objects that can cut a volume, with the active one."""
    active = context.view_layer.objects.active
    own = (frame, *volume.levels_of(frame))
    if not active or active in own:
        raise Refused("Make an empty or a closed mesh the active object; all selected ones cut")
    return [active] + [thing for thing in context.view_layer.objects.selected
                       if thing != active and thing not in own and thing.type in ('EMPTY', 'MESH')]


class ISOSHADE_OT_cut(Button, bpy.types.Operator):
    """Cut the volume by a new empty, or by the selected empties and closed meshes; after editing a mesh, cut again"""
    bl_idname, bl_label = "isoshade.cut", "Cut"
    shape: EnumProperty(name="Shape", items=(('BOX', "Box", "An empty cube"), ('SPHERE', "Sphere", "An empty sphere"),
                                             ('PLANE', "Plane", "An arrow: its side is cut away, or kept"),
                                             ('SELECTED', "Selected", "The selected empties and closed meshes")))
    keep_inside: BoolProperty(name="Keep inside", description="Keep only the inside, or a plane's side of the arrow")

    def work(self, context):
        frame = volume.need_frame(context)
        cutters = chosen(frame, context) if self.shape == 'SELECTED' else [new_empty(frame, self.shape, context)]
        context.view_layer.update()
        cut(frame, cutters, self.keep_inside)
        for cutter in cutters:
            if cutter.type == 'MESH':
                cutter.display_type, cutter.hide_render = 'WIRE', True
        return f"{', '.join(cutter.name for cutter in cutters)}: cut {frame.name}"


class ISOSHADE_OT_uncut(Button, bpy.types.Operator):
    """Remove all cuts of the volume; the objects stay"""
    bl_idname, bl_label = "isoshade.uncut", "Remove Cuts"

    def work(self, context):
        frame = volume.need_frame(context)
        return f"{frame.name}: {remove(frame)} cuts removed"


classes = (ISOSHADE_OT_cut, ISOSHADE_OT_uncut)
