# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the output of `isoshade export --to blender` in an open file: levels, ramps, the exact table, the scene.

Files are untrusted: custom properties are checked, and none is run."""
import json
import math
import os

import bpy
import numpy
from mathutils import Vector

from . import tables
from .tables import Refused

# ---- sockets ---------------------------------------------------------------------------------------------------

MATH = ("Value", "Value_001", "Value_002")  # operands of a Math node


def socket(sockets, identifier):
    """Finds a socket by its identifier, which Blender versions keep while they change names ("Fac" is "Factor" in 5.2)
    and order."""
    return next(one for one in sockets if one.identifier == identifier)


# ---- objects ---------------------------------------------------------------------------------------------------


def levels_of(frame):
    """Returns the volume objects of a frame, finest first."""
    found = [thing for thing in frame.children if thing.type == 'VOLUME' and "isoshade_table" in thing and "isoshade_level" in thing]
    return sorted(found, key=lambda thing: thing["isoshade_level"])


def find_frame(context):
    """Returns the current volume: the active object's, else the scene's first. None: there is none."""
    active = context.view_layer.objects.active if context.view_layer else None
    for thing in (active, active.parent if active else None, *context.scene.objects):
        if thing and levels_of(thing):
            return thing
    return None


def need_frame(context):
    frame = find_frame(context)
    if not frame:
        raise Refused("This scene has no volume of isoshade: import one")
    return frame


def shown_level(frame):
    return int(frame["level"]) if "level" in frame else int(levels_of(frame)[0]["isoshade_level"])


def shown_object(frame):
    levels = levels_of(frame)
    level = shown_level(frame)
    return next((thing for thing in levels if int(thing["isoshade_level"]) == level), levels[0])


def level_numbers(frame):
    return sorted({int(thing["isoshade_level"]) for thing in levels_of(frame)})


def set_level(frame, level):
    frame["level"] = level
    frame.update_tag()


def numbers(owner, key, count):
    """Returns a custom property as a list of finite floats."""
    try:
        listed = [float(v) for v in owner[key]]
    except (KeyError, TypeError, ValueError):
        raise Refused(f"{owner.name}: its property {key} is missing or not a list of numbers; was it exported by isoshade?") from None
    if len(listed) != count or not all(math.isfinite(v) for v in listed):
        raise Refused(f"{owner.name}: its property {key} must have {count} numbers")
    return listed


def noted(frame, scene, key, fallback):
    """Returns a note of the exporter from the frame, or in older files from the scene."""
    for owner in (frame, scene):
        if key in owner:
            return owner[key]
    return fallback


# ---- node groups -----------------------------------------------------------------------------------------------


def groups_of(tree, depth=0):
    yield tree
    for node in tree.nodes:
        if node.type == 'GROUP' and node.node_tree and depth < 8:
            yield from groups_of(node.node_tree, depth + 1)


def look_of(thing):
    """Returns the group node of a volume's material, and all groups in it."""
    material = thing.active_material
    node = material.node_tree.nodes.get("isoshade") if material and material.node_tree else None
    if not node or node.type != 'GROUP' or not node.node_tree:
        raise Refused(f'{thing.name}: its material has no group "isoshade"')
    return node, list(groups_of(node.node_tree))


def ramp_tree(thing):
    for tree in look_of(thing)[1]:
        if "isoshade_ramps" in tree:
            return tree
    raise Refused(f"{thing.name}: no ColorRamps of isoshade in its material; export again")


def table_image(thing):
    for tree in look_of(thing)[1]:
        for node in tree.nodes:
            if node.type == 'TEX_IMAGE' and node.image and node.image.name.startswith("isoshade transfer function"):
                return node.image
    raise Refused(f"{thing.name}: its material has no image of the transfer function")


# ---- ramps -----------------------------------------------------------------------------------------------------


class Ramp:
    """A ColorRamp of the group: its node, its range of values, and the length of its opacities."""

    def __init__(self, thing, index):
        self.tree, self.index = ramp_tree(thing), index
        notes = read_notes(self.tree)
        self.node = self.tree.nodes.get(f"isoshade ramp {index}")
        if not 0 <= index < len(notes) or not self.node or self.node.type != 'VALTORGB':
            raise Refused(f"{thing.name}: ColorRamp {index} is missing")
        self.notes = notes[index]
        self.lo = tables.number(self.notes.get("lo"), "the ramp's first value")
        self.hi = tables.number(self.notes.get("hi"), "the ramp's last value")
        self.unit_mm = tables.number(self.notes.get("unit_distance_mm"), "the ramp's unit distance", tables.LEAST_MM, tables.MOST_MM)
        self.unit = tables.number(self.notes.get("unit_distance"), "the ramp's unit distance", tables.LEAST_MM, tables.MOST_MM)
        if not self.hi > self.lo:
            raise Refused("the ramp's range is empty")

    def stops(self):
        return [[float(v) for v in (stop.position, *stop.color)] for stop in self.node.color_ramp.elements]

    def flat(self):
        return [v for stop in self.stops() for v in stop]

    def is_plain(self):
        """True if its stops are points of a transfer function: straight lines between linear colors."""
        ramp = self.node.color_ramp
        return ramp.interpolation == 'LINEAR' and ramp.color_mode == 'RGB'

    def points(self):
        return tables.points_of_stops(self.stops(), self.lo, self.hi)

    def curve(self, values):
        """Evaluates the ramp at values like Blender, before Cycles bakes it."""
        if self.is_plain():
            points = numpy.array(self.stops())
            points[:, 0] = self.lo + points[:, 0] * (self.hi - self.lo)
            # An entry at a step is after it, as in the tables of isoshade.
            points = numpy.array([[v, *row[1:]] for v, row in zip([p[0] for p in self.points()], points)])
            return tables.evaluate(points, values)
        evaluate = self.node.color_ramp.evaluate
        return numpy.array([evaluate(float(x)) for x in numpy.clip((values - self.lo) / (self.hi - self.lo), 0, 1)])

    def set_stops(self, stops):
        """Sets positions first, since Blender sorts by them."""
        ramp = self.node.color_ramp
        ramp.interpolation, ramp.color_mode = 'LINEAR', 'RGB'
        while len(ramp.elements) > len(stops):
            ramp.elements.remove(ramp.elements[-1])
        for element in ramp.elements:
            element.position = 1.0
        while len(ramp.elements) < len(stops):
            ramp.elements.new(1.0)
        for element, stop in zip(ramp.elements, stops):
            element.position = stop[0]
        for element, stop in zip(ramp.elements, stops):
            element.color = stop[1:]

    def set_points(self, points, unit_mm=None):
        """Sets the ramp to a curve: its points, or the fewest stops that reproduce it."""
        points = tables.fit(points)
        lo, hi = points[0][0], points[-1][0]
        if not hi > lo:
            lo, hi = (self.lo, self.hi) if self.lo <= lo <= self.hi else (lo - 0.5, hi + 0.5)
        self.set_range(lo, hi)
        if unit_mm:
            self.set_unit(unit_mm)
        self.set_stops(tables.stops_of_points(points, lo, hi))

    def set_range(self, lo, hi):
        start, scale = (self.tree.nodes.get(f"isoshade ramp {self.index} {name}") for name in ("start", "scale"))
        if not start or not scale:
            raise Refused(f"{self.tree.name}: the nodes of ColorRamp {self.index} are missing")
        socket(start.inputs, MATH[1]).default_value = lo
        socket(scale.inputs, MATH[1]).default_value = 1 / (hi - lo)
        self.lo, self.hi = lo, hi
        self.note(lo=lo, hi=hi)

    def set_unit(self, unit_mm):
        node = self.tree.nodes.get(f"isoshade ramp {self.index} extinction")
        if not node:
            raise Refused(f"{self.tree.name}: the nodes of ColorRamp {self.index} are missing")
        self.unit *= unit_mm / self.unit_mm
        self.unit_mm = unit_mm
        socket(node.inputs, MATH[1]).default_value = -1 / self.unit
        self.note(unit_distance_mm=self.unit_mm, unit_distance=self.unit)

    def note(self, **values):
        notes = read_notes(self.tree)
        notes[self.index].update(values)
        self.notes = notes[self.index]
        self.tree["isoshade_ramps"] = json.dumps(notes)

    def is_shown(self):
        """True if the exact table is that of the current ramp."""
        key = f"isoshade_shown_{self.index}"
        return self.is_plain() and key in self.tree and list(self.tree[key]) == self.flat()

    def note_shown(self):
        self.tree[f"isoshade_shown_{self.index}"] = self.flat()


def read_notes(tree):
    try:
        notes = json.loads(tree["isoshade_ramps"])
    except (KeyError, TypeError, ValueError, RecursionError):
        notes = None
    if not isinstance(notes, list) or not notes or not all(isinstance(note, dict) for note in notes):
        raise Refused(f"{tree.name}: its notes on ColorRamps cannot be read; export again")
    return notes


def ramp_of(thing):
    index = tables.number(thing.get("isoshade_ramp", 0.0), f"{thing.name}: the number of its ramp", 0, 1000)
    return Ramp(thing, int(index))


def ramps_of(frame):
    """Returns each ramp of a volume once, with its objects."""
    found = {}
    for thing in levels_of(frame):
        ramp = ramp_of(thing)
        found.setdefault(ramp.index, (ramp, []))[1].append(thing)
    return list(found.values())


def add_ramp(thing):
    """Adds a ColorRamp to the group, a copy of the object's, and assigns it to the object."""
    old = ramp_of(thing)
    tree, nodes, links = old.tree, old.tree.nodes, old.tree.links
    notes = read_notes(tree)
    index = len(notes)
    sink = next(node for node in nodes if node.type == 'GROUP_OUTPUT')
    source = next(node for node in nodes if node.type == 'GROUP_INPUT')

    def math_node(name, operation, *operands, clamp=False):
        node = nodes.new('ShaderNodeMath')
        node.operation, node.use_clamp, node.name = operation, clamp, name
        node.location = (old.node.location.x, old.node.location.y - 400 * (index - old.index))
        for identifier, operand in zip(MATH, operands):
            if isinstance(operand, bpy.types.NodeSocket):
                links.new(operand, socket(node.inputs, identifier))
            else:
                socket(node.inputs, identifier).default_value = operand
        return node.outputs["Value"]

    name = f"isoshade ramp {index}"
    offset = math_node(name + " start", 'SUBTRACT', source.outputs["Scalar"], old.lo)
    u = math_node(name + " scale", 'MULTIPLY', offset, 1 / (old.hi - old.lo), clamp=True)
    node = nodes.new('ShaderNodeValToRGB')
    node.name, node.label, node.location = name, f"level {int(thing['isoshade_level'])}", (old.node.location.x + 260, old.node.location.y - 400 * (index - old.index))
    links.new(u, socket(node.inputs, "Fac"))
    passed = math_node("", 'MAXIMUM', math_node("", 'SUBTRACT', 1.0, node.outputs["Alpha"]), 1 - tables.MOST_OPACITY)
    extinction = math_node(name + " extinction", 'MULTIPLY', math_node("", 'LOGARITHM', passed, math.e), -1 / old.unit)
    mine = math_node("", 'COMPARE', source.outputs["Ramp"], float(index), 0.5)
    before = {key: sink.inputs[key].links[0].from_socket for key in ("Color", "Extinction")}
    mix = nodes.new('ShaderNodeMixRGB')
    for identifier, operand in (("Fac", mine), ("Color1", before["Color"]), ("Color2", node.outputs["Color"])):
        links.new(operand, socket(mix.inputs, identifier))
    links.new(mix.outputs["Color"], sink.inputs["Color"])
    difference = math_node("", 'SUBTRACT', extinction, before["Extinction"])
    links.new(math_node("", 'MULTIPLY_ADD', mine, difference, before["Extinction"]), sink.inputs["Extinction"])
    notes.append(dict(notes[old.index], of=[node.label]))
    tree["isoshade_ramps"] = json.dumps(notes)
    thing["isoshade_ramp"] = float(index)
    ramp = Ramp(thing, index)
    ramp.set_stops(old.stops())
    return ramp


# ---- the exact table -------------------------------------------------------------------------------------------


class Table:
    """The rows of an object in the image."""

    def __init__(self, thing):
        self.thing, self.image = thing, table_image(thing)
        lo, per_value, last = numbers(thing, "isoshade_table", 3)
        width, rows = self.image.size
        self.count, self.lo = int(last) + 1, lo
        self.first = int(tables.number(thing.get("isoshade_row"), f"{thing.name}: its row", 0, rows - 1))
        self.rows = 1 + int(tables.number(thing.get("isoshade_last_row", 0.0), f"{thing.name}: its last row", 0, rows - 1))
        if not per_value > 0 or not 2 <= self.count <= width or self.first + self.rows > rows:
            raise Refused(f"{thing.name}: its table is not in the image of the transfer function")
        self.hi = lo + last / per_value

    def pixels(self):
        width, rows = self.image.size
        pixels = numpy.empty(4 * width * rows, numpy.float32)
        self.image.pixels.foreach_get(pixels)
        return pixels.reshape(rows, width, 4)

    def read(self):
        """Returns rows of r, g, b, extinction per unit of Blender; for a 2D transfer function its first row."""
        return self.pixels()[self.first, :self.count]

    def write(self, entries, lo=None, hi=None):
        """Sets all rows. A row with fewer entries than the image's width repeats the last one."""
        pixels = self.pixels()
        width = pixels.shape[1]
        entries = entries[:width]
        pixels[self.first:self.first + self.rows, :len(entries)] = entries
        pixels[self.first:self.first + self.rows, len(entries):] = entries[-1]
        self.image.pixels.foreach_set(pixels.ravel())
        self.image.update()
        self.image.pack()
        self.count = len(entries)
        self.lo, self.hi = (self.lo, self.hi) if lo is None else (lo, hi)
        self.thing["isoshade_table"] = [self.lo, (self.count - 1) / (self.hi - self.lo), float(self.count - 1)]
        self.thing.update_tag()


def bake(ramp, things):
    """Bakes the exact table of objects from their ramp. Returns its largest distance to the ramp's stops, and the value
    there."""
    worst, where = 0.0, 0.0
    for thing in things:
        table = Table(thing)
        lo, hi = min(table.lo, ramp.lo), max(table.hi, ramp.hi)
        entries = tables.make_table(ramp.curve, lo, hi, table.count, ramp.unit)
        table.write(entries, lo, hi)
        places = numpy.array([p[0] for p in ramp.points()])
        off = abs(tables.look_up(entries, lo, hi, places, ramp.unit) - numpy.minimum(ramp.curve(places), [1e9, 1e9, 1e9, tables.MOST_OPACITY])).max(axis=1)
        if off.max() > worst:
            worst, where = float(off.max()), float(places[off.argmax()])
    ramp.note_shown()
    ramp.note(own_points=True)
    return worst, where


def hidden_values(frame):
    """Returns the intervals of values that the grids omit, because the transfer function hid them when they were made.
    """
    try:
        return [(float(lo), float(hi)) for lo, hi in json.loads(frame.get("isoshade_hidden", "[]"))]
    except (TypeError, ValueError, RecursionError):
        raise Refused(f"{frame.name}: isoshade_hidden cannot be read") from None


def left_out_but_shown(frame):
    """Returns the first visible values that the grids omit."""
    hidden = hidden_values(frame)
    for thing in levels_of(frame):
        table = Table(thing)
        values = tables.values_of(table.lo, table.hi, table.count)
        seen = table.read()[:, 3] > 0
        for lo, hi in hidden:
            inside = values[seen & (values > lo) & (values < hi)]
            if len(inside):
                return float(inside[0]), float(inside[-1])
    return None


def present_transfer_function(thing):
    """Returns the shown transfer function as an object of the form isoshade.tf/1: the ramp's points, or the exact
    table's entries if the ramp is only an approximation."""
    table, ramp = Table(thing), ramp_of(thing)
    uses_ramp = look_of(thing)[0].inputs["Use Ramp"].default_value > 0.5
    lo, hi = min(table.lo, ramp.lo), max(table.hi, ramp.hi)
    edited = not ramp.is_shown()
    if edited and not uses_ramp:
        raise Refused("The ramp was edited, and the exact table is shown: bake it, or turn on Use Ramp")
    if ramp.is_plain() and (edited or ramp.notes.get("own_points") is True):
        return tables.to_json(ramp.points(), lo, hi, ramp.unit_mm, table.count)
    values = tables.values_of(lo, hi, table.count)
    rows = ramp.curve(values) if edited else tables.look_up(table.read(), table.lo, table.hi, values, ramp.unit)
    points = [[float(v), *map(float, row)] for v, row in zip(values, rows)]
    return tables.to_json(points, lo, hi, ramp.unit_mm, table.count)


# ---- the scene ---------------------------------------------------------------------------------------------------


def volume_path(frame, scene):
    """Returns the source file of the volume."""
    named = scene.isoshade.volume or frame.get("isoshade_volume", "") or noted(frame, scene, "isoshade_source", "")
    if not isinstance(named, str) or not named:
        raise Refused("The source file of the volume is unknown: set it under Volume")
    candidates = [bpy.path.abspath(named)]
    if bpy.data.filepath:
        candidates.append(os.path.join(os.path.dirname(bpy.data.filepath), named))
    for path in candidates:
        if os.path.exists(path):
            return os.path.abspath(path)
    raise Refused(f"{named}: does not exist; set the file under Volume")


def spacing_of(thing):
    """Returns the spacings of an object's grid along its axes, in units of Blender; None if its file has none."""
    grids = thing.data.grids
    if not grids.is_loaded:
        grids.load()
    for grid in grids:
        spacing = [column.length for column in grid.matrix_object.to_3x3().transposed()]
        if all(s > 0 for s in spacing):
            return spacing
    return None


def voxel_units(thing):
    """Returns the smallest spacing, or None."""
    spacing = spacing_of(thing)
    return min(spacing) if spacing else None


def place_of(frame, scene):
    """Transforms points and directions of the world to those of the volume, in mm."""
    scale = frame.matrix_world.to_scale()
    if min(scale) <= 0 or max(scale) / min(scale) > 1.0001:
        raise Refused(f"{frame.name}: is stretched or mirrored; certified scenes may only be moved, rotated and scaled uniformly")
    units = tables.number(noted(frame, scene, "isoshade_units_per_mm", 1.0), "isoshade_units_per_mm", 0.01 * tables.LEAST_MM, 100 * tables.MOST_MM)
    try:
        origin = Vector([float(v) for v in noted(frame, scene, "isoshade_origin_mm", (0, 0, 0))])
    except (TypeError, ValueError):
        raise Refused("isoshade_origin_mm must be three numbers") from None
    inverse = frame.matrix_world.inverted()
    turn = inverse.to_quaternion()
    return (lambda point: (inverse @ point) / units + origin, lambda direction: (turn @ direction).normalized(),
            1 / (scale[0] * units))


def camera_json(scene, frame):
    camera = scene.camera
    if not camera or camera.type != 'CAMERA' or camera.data.type not in ('PERSP', 'ORTHO'):
        raise Refused("The scene has no perspective or orthographic camera")
    if abs(scene.render.pixel_aspect_x / scene.render.pixel_aspect_y - 1) > 1e-4:
        raise Refused("The pixels are not square: set Aspect X and Y to 1")
    point, direction, mm = place_of(frame, scene)
    matrix = camera.matrix_world
    position, forward = matrix.translation, matrix.to_3x3() @ Vector((0, 0, -1))
    corners = camera.data.view_frame(scene=scene)
    top, bottom, right, left = (pick(c[axis] for c in corners) for axis in (1, 0) for pick in (max, min))
    if max(abs(top + bottom), abs(left + right)) > 1e-4 * (top - bottom):
        raise Refused("The camera has a lens shift, which isoshade does not support: set Shift to 0")
    middle = frame.matrix_world @ (sum((Vector(c) for c in frame.bound_box), Vector()) / 8)
    reach = max((middle - position).length, 1e-3)
    about = {"position": list(point(position)), "look_at": list(point(position + reach * forward.normalized())),
             "up": list(direction(matrix.to_3x3() @ Vector((0, 1, 0))))}
    if camera.data.type == 'ORTHO':
        return {"projection": "orthographic", "height_mm": (top - bottom) * mm, **about}
    return {"projection": "perspective", "fov_y_deg": math.degrees(2 * math.atan2(top, -corners[0].z)), **about}


def background_of(scene):
    """Returns the color behind the volume, and words for a world that the reference cannot draw: its color is black then."""
    world = scene.world
    if not world or scene.render.film_transparent:
        return [0, 0, 0], ""
    node = next((n for n in world.node_tree.nodes if n.type == 'BACKGROUND'), None) if world.use_nodes else None
    if node and (node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked):
        return [0, 0, 0], "picture of the world"
    if world.use_nodes and not node:
        return [0, 0, 0], ""
    color, strength = (node.inputs["Color"].default_value, node.inputs["Strength"].default_value) if node else (world.color, 1)
    color = [max(c * strength, 0) for c in color[:3]]
    return ([0, 0, 0], "a world brighter than 1") if max(color) > 1 else (color, "")


def scene_json(context, frame):
    """Returns the current scene in the form isoshade.scene/1, with the shown transfer function."""
    scene, thing = context.scene, shown_object(frame)
    look, _ = look_of(thing)
    _, direction, _ = place_of(frame, scene)
    lights = []
    while f"Light {len(lights) + 1}" in look.inputs:
        i = len(lights) + 1
        towards = Vector(look.inputs[f"Light {i}"].default_value)
        intensity = tables.near(look.inputs[f"Intensity {i}"].default_value)
        if not 0 <= intensity <= 1:
            raise Refused(f"Light {i} has intensity {intensity:.3g}, must be 0 to 1: set its sun's strength to at most {math.pi:.3f}")
        lights.append({"direction": list(direction(towards)), "space": "world", "intensity": intensity})
        color = look.inputs[f"Color {i}"].default_value[:3] if f"Color {i}" in look.inputs else (1, 1, 1)
        if min(color) < 1 - 1e-6 or max(color) > 1 + 1e-6:
            raise Refused(f"Light {i} has a color; isoshade validates white lights only: make its sun white")
    tf = present_transfer_function(thing)
    tf["unit_distance_mm"] /= tables.number(look.inputs["Density Scale"].default_value, "Density Scale", 1e-6, 1e6)
    share = scene.render.resolution_percentage / 100
    voxel = voxel_units(thing)
    step = thing.data.render.step_size
    about = {"schema": "isoshade.scene/1",
             "image": {"width": max(int(scene.render.resolution_x * share), 1), "height": max(int(scene.render.resolution_y * share), 1)},
             "camera": camera_json(scene, frame), "lights": lights,
             "shading": {key: tables.near(look.inputs[key.capitalize()].default_value) for key in ("ambient", "diffuse", "specular", "power")},
             "background": background_of(scene)[0],
             "step_voxels": min(max(step / voxel, 0.01), 4) if voxel and step > 0 else 0.25, "tf": tf}
    clips = noted(frame, scene, "isoshade_clip_planes", "[]")
    try:
        about["clip_planes"] = [{"normal": [float(v) for v in clip[:3]], "point_mm": [float(v) for v in clip[3:6]]} for clip in json.loads(clips)]
    except (TypeError, ValueError, RecursionError):
        raise Refused("isoshade_clip_planes cannot be read") from None
    if not about["clip_planes"]:
        del about["clip_planes"]
    return about


# ---- files -------------------------------------------------------------------------------------------------------


def missing_files(scene):
    """Returns the names of volumes and their missing files."""
    missing = []
    for thing in scene.objects:
        if thing.type != 'VOLUME':
            continue
        data = thing.data
        path = bpy.path.abspath(data.filepath, library=data.library)
        for wanted in sequence_paths(data, path) if data.is_sequence else [path]:
            if not os.path.isfile(wanted):
                missing.append((thing.name, wanted))
    return missing


def sequence_paths(data, path):
    """Returns the files of the frames of a sequence."""
    folder, name = os.path.split(path)
    stem, suffix = os.path.splitext(name)
    digits = len(stem) - len(stem.rstrip("0123456789"))
    if not digits:
        return [path]
    first = int(stem[-digits:])
    return [os.path.join(folder, f"{stem[:-digits]}{first + i:0{digits}d}{suffix}") for i in range(min(data.frame_duration, 100000))]
