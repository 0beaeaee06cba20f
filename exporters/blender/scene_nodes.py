# SPDX-License-Identifier: GPL-3.0-or-later
"""The material of an isoshade volume as node groups.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part.
"""
import bpy
import numpy

# ---- nodes -----------------------------------------------------------------------------------------------------

MATH = ("Value", "Value_001", "Value_002")
VECTOR = ("Vector", "Vector_001", "Vector_002")


def socket(sockets, name):
    """Finds a socket by its identifier, which Blender versions keep while they change names ("Fac" is "Factor" in 5.2)
    and order; for groups, whose identifiers are numbers, by its name."""
    found = next((one for one in sockets if one.identifier == name), None) or next((one for one in sockets if one.name == name), None)
    if not found:
        raise KeyError(f"Blender {bpy.app.version_string} has no socket {name}, but {[one.identifier for one in sockets]}")
    return found


def tree_of(block):
    """Returns the emptied nodes of a new material or world. From Blender 5 on they exist from the start, and use_nodes
    goes away."""
    if not block.node_tree:
        block.use_nodes = True
    block.node_tree.nodes.clear()
    return block.node_tree



class Group:
    """A node group under construction. Operands are sockets or plain values; nodes are arranged in columns."""

    def __init__(self, name, inputs, outputs):
        self.tree = bpy.data.node_groups.new(name, 'ShaderNodeTree')
        self.column = {}
        self.filled = {}
        modern = hasattr(self.tree, "interface")  # Blender 4 and later
        for kind, label, default in inputs:
            socket = (self.tree.interface.new_socket(name=label, in_out='INPUT', socket_type=kind) if modern
                      else self.tree.inputs.new(kind, label))
            socket.default_value = default
        for kind, label in outputs:
            if modern:
                self.tree.interface.new_socket(name=label, in_out='OUTPUT', socket_type=kind)
            else:
                self.tree.outputs.new(kind, label)
        self.given = self.place(self.tree.nodes.new('NodeGroupInput'), 0).outputs

    def place(self, node, column):
        """Places a node below those of its column; its height grows with its sockets."""
        top = self.filled.get(column, 0)
        self.filled[column] = top + 130 + 22 * (len(node.inputs) + len(node.outputs))
        self.column[node.name] = column
        node.location = (240 * column, -top)
        node.select = False
        return node

    def node(self, kind, label, inputs, **settings):
        """inputs: {identifier of the socket, or name for groups: operand}."""
        node = self.tree.nodes.new(kind)
        node.label = label
        for key, value in settings.items():
            setattr(node, key, value)
        column = 0
        for key, operand in inputs.items():
            if isinstance(operand, bpy.types.NodeSocket):
                self.tree.links.new(operand, socket(node.inputs, key))
                column = max(column, self.column[operand.node.name] + 1)
            else:
                socket(node.inputs, key).default_value = operand
        return self.place(node, column)

    def math(self, operation, *operands, label="", clamp=False):
        return self.node('ShaderNodeMath', label, dict(zip(MATH, operands)), operation=operation,
                         use_clamp=clamp).outputs["Value"]

    def vector(self, operation, *operands, label=""):
        names = ("Vector", "Scale") if operation == 'SCALE' else VECTOR
        node = self.node('ShaderNodeVectorMath', label, dict(zip(names, operands)), operation=operation)
        return node.outputs['Value' if operation in ('DOT_PRODUCT', 'LENGTH') else 'Vector']

    def transform(self, kind, vector, source, target):
        return self.node('ShaderNodeVectorTransform', "", {"Vector": vector}, vector_type=kind, convert_from=source,
                         convert_to=target).outputs["Vector"]

    def split(self, vector, label=""):
        """Splits a vector into components."""
        parts = self.node('ShaderNodeSeparateXYZ', label, {"Vector": vector}).outputs
        return [parts[axis] for axis in "XYZ"]

    def join(self, *components, label=""):
        return self.node('ShaderNodeCombineXYZ', label, dict(zip("XYZ", components))).outputs["Vector"]

    def attribute(self, label, kind, name, output):
        node = self.node('ShaderNodeAttribute', label, {}, attribute_type=kind, attribute_name=name)
        return socket(node.outputs, output)

    def mix_color(self, part, first, second, label="color"):
        node = self.node('ShaderNodeMixRGB', label, {"Fac": part, "Color1": first, "Color2": second})
        return node.outputs["Color"]

    def call(self, group, **operands):
        return self.node('ShaderNodeGroup', "", {k.replace('_', ' '): v for k, v in operands.items()}, node_tree=group).outputs

    def finish(self, **results):
        sink = self.tree.nodes.new('NodeGroupOutput')
        for label, socket in results.items():
            self.tree.links.new(socket, sink.inputs[label])
        self.place(sink, max(self.filled) + 1)
        return self.tree


def dots(group, rows, vector, label):
    """Multiplies a matrix and a vector: three dot products."""
    parts = [group.vector('DOT_PRODUCT', vector, row, label=label) for row in rows]
    return group.join(*parts, label=label)


def box_group(to_box, clip_planes):
    """Part of the ray's step that lies inside the box: exact for any phase of the steps.

    A hard mask has an error of up to a step where the ray crosses a face. With the overlap of the box and the interval
    of one step around the sample, the sum over the samples telescopes instead. Slab method, in fractions of the box
    with 0 at its center: the ray is inside for  -f/g -+ 1/(2 |g|)  on each axis. A clip plane is one more face: n.f >=
    w, which the ray enters or leaves at  (w - n.f) / n.g  by the sign of n.g."""
    group = Group("isoshade box", [('NodeSocketVector', "Position", (0, 0, 0)), ('NodeSocketVector', "Ray", (0, 0, 1)),
                                   ('NodeSocketFloat', "Step", 1.0)],
                  [('NodeSocketFloat', name) for name in ("Inside", "Enter", "Leave")])
    linear = [row[:3] for row in to_box]
    f = group.vector('ADD', dots(group, linear, group.given["Position"], "position in the box"),
                     [row[3] - 0.5 for row in to_box], label="from its center")
    g = dots(group, linear, group.given["Ray"], "ray in the box")
    g = group.vector('ADD', g, (1e-20, 1e-20, 1e-20), label="never 0")
    middle = group.vector('DIVIDE', group.vector('SCALE', f, -1.0), g, label="to the middle")
    reach = group.vector('DIVIDE', (0.5, 0.5, 0.5), group.vector('ABSOLUTE', g), label="from there to the faces")
    half = group.math('MULTIPLY', group.given["Step"], 0.5)

    def extreme(vector, operation, last):
        part = group.split(vector)
        return group.math(operation, group.math(operation, group.math(operation, part[0], part[1]), part[2]), last)

    enter = extreme(group.vector('SUBTRACT', middle, reach), 'MAXIMUM', group.math('MULTIPLY', half, -1.0))
    leave = extreme(group.vector('ADD', middle, reach), 'MINIMUM', half)
    far = 1e9
    for plane in clip_planes:
        rate = group.math('ADD', group.vector('DOT_PRODUCT', g, plane[:3]), 1e-20)
        above = group.math('SUBTRACT', plane[3], group.vector('DOT_PRODUCT', f, plane[:3]), label="to the clip plane")
        crossing = group.math('MINIMUM', group.math('MAXIMUM', group.math('DIVIDE', above, rate), -far), far)
        enters = group.math('GREATER_THAN', rate, 0.0)
        leaves = group.math('SUBTRACT', 1.0, enters)
        enter = group.math('MAXIMUM', enter, group.math('SUBTRACT', group.math('MULTIPLY', crossing, enters),
                                                        group.math('MULTIPLY', leaves, far)))
        leave = group.math('MINIMUM', leave, group.math('ADD', group.math('MULTIPLY', crossing, leaves),
                                                        group.math('MULTIPLY', enters, far)))
    length = group.math('MAXIMUM', group.math('SUBTRACT', leave, enter), 0.0)
    # The add-on's cutters need the interval itself, in steps from the sample.
    inside, *ends = (group.math('DIVIDE', value, group.given["Step"], label="part of the step") for value in (length, enter, leave))
    return group.finish(Inside=inside, Enter=ends[0], Leave=ends[1])


def roi_group(to_box):
    """Weight of the finer level of a region of interest (scene/roi.h): 1 in its box, falling to 0 over a band around it
    with a continuous slope. Box and band are fractions of the volume's box."""
    group = Group("isoshade roi", [('NodeSocketVector', "Position", (0, 0, 0)), ('NodeSocketVector', "Lo", (0, 0, 0)),
                                     ('NodeSocketVector', "Hi", (1, 1, 1)), ('NodeSocketVector', "Band", (1, 1, 1))],
                  [('NodeSocketFloat', "Weight")])
    f = group.vector('ADD', dots(group, [row[:3] for row in to_box], group.given["Position"], "position in the box"),
                     [row[3] for row in to_box])
    below = group.vector('SUBTRACT', group.given["Lo"], f)
    above = group.vector('SUBTRACT', f, group.given["Hi"])
    far = group.vector('DIVIDE', group.vector('MAXIMUM', below, above), group.given["Band"], label="outside, in bands")
    part = group.split(far)
    outside = group.math('MAXIMUM', group.math('MAXIMUM', part[0], part[1]), part[2])
    u = group.math('SUBTRACT', 1.0, group.math('MINIMUM', group.math('MAXIMUM', outside, 0.0), 1.0), label="u")
    steep = group.math('MULTIPLY_ADD', u, -2.0, 3.0)
    return group.finish(Weight=group.math('MULTIPLY', group.math('MULTIPLY', u, u), steep, label="u u (3 - 2 u)"))


def label_image(path):
    """Loads class numbers, red + 256 green, as bytes without color conversion; packed."""
    image = bpy.data.images.load(path)
    image.name = "isoshade labels"
    image.colorspace_settings.name = 'Non-Color'
    image.alpha_mode = 'CHANNEL_PACKED'
    image.pack()
    return image


def label_group(about):
    """Class of the voxel at a position. Cycles interpolates grids, but not images, so the slices of each level are
    tiles of an image (exporters/blender/labels.c)."""
    group = Group("isoshade labels", [('NodeSocketVector', "Position", (0, 0, 0)), ('NodeSocketVector', "Cells", (1, 1, 1)),
                                      ('NodeSocketVector', "Size", (1, 1, 1)), ('NodeSocketVector', "Tiles", (1, 0, 0))],
                  [('NodeSocketFloat', "Class")])
    image = label_image(about["labels"]["image"])
    width, height = image.size
    to_box = about["world_to_box"]
    part = group.vector('ADD', dots(group, [row[:3] for row in to_box], group.given["Position"], "position in the box"),
                        [row[3] for row in to_box])
    last = group.vector('SUBTRACT', group.given["Size"], (1, 1, 1), label="last voxel")
    voxel = group.vector('FLOOR', group.vector('MULTIPLY', part, group.given["Cells"]))
    voxel = group.vector('MINIMUM', group.vector('MAXIMUM', voxel, (0, 0, 0)), last, label="voxel")
    x, y, z = group.split(voxel, "voxel")
    nx, ny, _ = group.split(group.given["Size"], "size")
    across, first, _ = group.split(group.given["Tiles"], "tiles in a row, first row")
    down = group.math('FLOOR', group.math('DIVIDE', group.math('ADD', z, 0.5), across), label="row of tiles")
    over = group.math('SUBTRACT', z, group.math('MULTIPLY', down, across), label="tile in it")
    column = group.math('MULTIPLY_ADD', over, nx, x, label="column of pixels")
    row = group.math('ADD', group.math('MULTIPLY_ADD', down, ny, y), first, label="row of pixels, from above")
    u = group.math('MULTIPLY_ADD', column, 1 / width, 0.5 / width)
    v = group.math('MULTIPLY_ADD', row, -1 / height, 1 - 0.5 / height)
    where = group.join(u, v)
    texel = group.node('ShaderNodeTexImage', "", {"Vector": where}, image=image, interpolation='Closest', extension='EXTEND',
                       projection='FLAT').outputs
    low, high, _ = group.split(texel["Color"], "red, green")
    low = group.math('ROUND', group.math('MULTIPLY', low, 255.0))
    high = group.math('ROUND', group.math('MULTIPLY', high, 255.0))
    return group.finish(Class=group.math('MULTIPLY_ADD', high, 256.0, low, label="class"))


def light_inputs(count):
    return [socket for i in range(1, count + 1)
            for socket in (('NodeSocketVector', f"Light {i}", (0, 0, 1)), ('NodeSocketFloat', f"Intensity {i}", 1.0),
                           ('NodeSocketColor', f"Color {i}", (1, 1, 1, 1)))]


def shade_group(light_count, eps):
    """shade = ka + sum of I C (kd |n.l| + ks |n.h|^p), n = d / sqrt(|d|^2 + eps^2); C is the light's color.

    The direction rotates with the object like normals (inverse transpose); its length, its reliability, is kept."""
    inputs = [('NodeSocketVector', "Direction", (0, 0, 0)), ('NodeSocketFloat', "Ambient", 0.3),
              ('NodeSocketFloat', "Diffuse", 0.7), ('NodeSocketFloat', "Specular", 0.0), ('NodeSocketFloat', "Power", 20.0)]
    group = Group("isoshade shade", inputs + light_inputs(light_count), [('NodeSocketVector', "Shade")])
    d = group.given["Direction"]
    length = group.vector('LENGTH', d)
    root = group.math('SQRT', group.math('MULTIPLY_ADD', length, length, eps * eps), label="sqrt(|d|^2 + eps^2)")
    trust = group.math('DIVIDE', length, root, label="|n|")
    # The transform normalizes: a zero direction needs some length, which its reliability of 0 removes again.
    turned = group.transform('NORMAL', group.vector('ADD', d, (0, 0, 1e-18)), 'OBJECT', 'WORLD')
    n = group.vector('SCALE', turned, trust, label="n")
    viewer = group.node('ShaderNodeNewGeometry', "", {}).outputs["Incoming"]
    shade = group.given["Ambient"]
    for i in range(light_count):
        light = group.vector('NORMALIZE', group.given[f"Light {i + 1}"], label=f"light {i + 1}")
        half = group.vector('NORMALIZE', group.vector('ADD', light, viewer), label="h")
        diffuse = group.math('ABSOLUTE', group.vector('DOT_PRODUCT', n, light), label="|n.l|")
        glossy = group.math('POWER', group.math('ABSOLUTE', group.vector('DOT_PRODUCT', n, half), label="|n.h|"),
                            group.given["Power"])
        both = group.math('MULTIPLY_ADD', diffuse, group.given["Diffuse"],
                          group.math('MULTIPLY', glossy, group.given["Specular"]))
        bright = group.math('MULTIPLY', both, group.given[f"Intensity {i + 1}"])
        shade = group.vector('MULTIPLY_ADD', bright, group.given[f"Color {i + 1}"], shade)
    return group.finish(Shade=shade)


def where_positive(group, factor, volume, label):
    """The same shader, skipped by Cycles if the factor is 0: it skips the branch of a mix with weight 0. Overlapping
    volumes, such as the levels of a plan, are all evaluated at each step of a ray."""
    part = group.math('GREATER_THAN', factor, 0.0, label=label)
    return group.node('ShaderNodeMixShader', label, {"Fac": part, "Shader_001": volume}).outputs["Shader"]


def isoshade_group(about):
    lights = len(about["lights"])
    inputs = [('NodeSocketFloat', "Density Scale", 1.0), ('NodeSocketFloat', "Use Ramp", 0.0),
              ('NodeSocketFloat', "Ambient", 0.3), ('NodeSocketFloat', "Diffuse", 0.7),
              ('NodeSocketFloat', "Specular", 0.0), ('NodeSocketFloat', "Power", 20.0),
              ('NodeSocketFloat', "Anisotropy", 0.0)]
    group = Group("isoshade", inputs + light_inputs(lights), [('NodeSocketShader', "Volume"), ('NodeSocketShader', "Preview")])
    direction = group.attribute("direction", 'GEOMETRY', "gradient", "Vector")
    table = group.attribute("table of the level", 'OBJECT', "isoshade_table", "Vector")
    row = group.attribute("row of the level", 'OBJECT', "isoshade_row", "Fac")
    world_step = group.attribute("ray step in the world", 'OBJECT', "isoshade_step", "Fac")
    physical = group.attribute("material of the volume", 'OBJECT', "isoshade_physical", "Fac")
    # The object's own coordinates, so that copies, instances and moving volumes each have theirs.
    position = group.vector('ADD', group.node('ShaderNodeTexCoord', "", {}).outputs["Object"],
                            group.attribute("offset of the grid", 'OBJECT', "isoshade_offset", "Vector"), label="position in the frame")
    scalar = group.attribute("scalar", 'GEOMETRY', "density", "Fac")
    if "labels" in about:
        tiles = {name: group.attribute(f"labels' {name}", 'OBJECT', f"isoshade_labels_{name}", "Vector")
                 for name in ("cells", "size", "tiles")}
        found = group.call(label_group(about), Position=position, Cells=tiles["cells"], Size=tiles["size"],
                           Tiles=tiles["tiles"])["Class"]
        # Cycles hides volumes whose shader reads no grid: read one with a contribution too faint to see.
        scalar = group.math('MULTIPLY_ADD', scalar, 1e-30, found, label="class")
    incoming = group.node('ShaderNodeNewGeometry', "", {}).outputs["Incoming"]
    # Length of a world unit along the ray in the object's units: extinction follows the object's scale.
    travel = group.transform('VECTOR', incoming, 'WORLD', 'OBJECT')
    ray = group.vector('NORMALIZE', travel)
    stretch = group.vector('LENGTH', travel)
    step = group.math('MULTIPLY', world_step, stretch, label="ray step in own units")

    where = row
    if any(table["rows"] > 1 for table in about["tf"]["tables"]):
        part = group.attribute("second value, 0 to 1", 'GEOMETRY', "second_value", "Fac")
        last = group.attribute("last row of the 2D transfer function", 'OBJECT', "isoshade_last_row", "Fac")
        where = group.math('MULTIPLY_ADD', part, last, where, label="row of the 2D transfer function")
    exact = group.call(transfer_function_group(about["tf"]), Scalar=scalar, Table=table, Row=where)
    which = group.attribute("ramp of the level", 'OBJECT', "isoshade_ramp", "Fac")
    ramp = group.call(ramp_group(about["tf"]["ramps"]), Scalar=scalar, Ramp=which)
    use_ramp = group.given["Use Ramp"]
    inside = group.call(box_group(about["world_to_box"], about["clip_planes"]), Position=position, Ray=ray,
                        Step=step)["Inside"]
    if any("roi" in level for level in about["levels"]):
        box = {name: group.attribute(f"roi {name}", 'OBJECT', f"isoshade_roi_{name}", "Vector")
               for name in ("lo", "hi", "band", "side")}
        weight = group.call(roi_group(about["world_to_box"]), Position=position, Lo=box["lo"], Hi=box["hi"],
                            Band=box["band"])["Weight"]
        constant, factor, _ = group.split(box["side"], "constant and factor")
        share = group.math('MULTIPLY_ADD', weight, factor, constant, label="this level's share")
        inside = group.math('MULTIPLY', inside, share)
    seen = group.math('MULTIPLY', inside, stretch, label="own units, inside")
    names = ["Ambient", "Diffuse", "Specular", "Power"] + [label for _, label, _ in light_inputs(lights)]
    shade = group.call(shade_group(lights, about["eps"]), Direction=direction,
                       **{name: group.given[name] for name in names})["Shade"]
    scale = 1.0
    if about.get("extinction_scale"):
        octaves = group.attribute("log2 of the extinction's scale", 'GEOMETRY', "log2_extinction_scale", "Fac")
        scale = group.math('POWER', 2.0, octaves, label="the extinction's scale")
    both = physical_group()

    def volume(table_color, table_extinction):
        color = group.mix_color(use_ramp, table_color, ramp["Color"])
        extinction = group.math('MULTIPLY_ADD', use_ramp, group.math('SUBTRACT', ramp["Extinction"], table_extinction),
                                table_extinction)
        if about.get("extinction_scale"):
            extinction = group.math('MULTIPLY', extinction, scale)
        sigma = group.math('MULTIPLY', group.math('MULTIPLY', extinction, seen), group.given["Density Scale"], label="sigma")
        shader = group.call(both, Color=color, Shade=shade, Extinction=sigma, Physical=physical,
                            Anisotropy=group.given["Anisotropy"])["Volume"]
        return where_positive(group, sigma, shader, "where something is seen")

    return group.finish(Volume=volume(exact["Color"], exact["Extinction"]),
                        Preview=volume(exact["Preview Color"], exact["Preview Extinction"]))


def material(about):
    result = bpy.data.materials.new(about["name"])
    tree = tree_of(result)
    node = tree.nodes.new('ShaderNodeGroup')
    node.node_tree = isoshade_group(about)
    node.name = node.label = "isoshade"
    node.width = 240
    shading = about["shading"]
    for name in ("Ambient", "Diffuse", "Specular", "Power"):
        node.inputs[name].default_value = shading[name.lower()]
    for i, light in enumerate(about["lights"]):
        node.inputs[f"Light {i + 1}"].default_value = light["direction"]
        node.inputs[f"Intensity {i + 1}"].default_value = light["intensity"]
    for row, (name, target) in enumerate((("Volume", 'ALL'), ("Preview", 'EEVEE'))):
        output = tree.nodes.new('ShaderNodeOutputMaterial')
        output.target = target
        output.location = (320, -160 * row)
        tree.links.new(node.outputs[name], output.inputs["Volume"])
    return result
