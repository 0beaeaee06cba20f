# SPDX-License-Identifier: GPL-3.0-or-later
"""Aids for people who open the file: lights to rotate, an explanation.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part."""
import math

import bpy
from mathutils import Matrix, Vector

# ---- handles ---------------------------------------------------------------------------------------------------


def sun_object(number, light, about, collection):
    """Adds a sun next to the volume, with its z axis towards the light."""
    data = bpy.data.lights.new(f"isoshade light {number}", 'SUN')
    # A white matte surface that faces a sun of strength pi has brightness 1.
    data.energy = math.pi * light["intensity"]
    thing = bpy.data.objects.new(data.name, data)
    towards = Vector(light["direction"])
    frame = Matrix(about["box_to_world"])
    middle = frame @ Vector((0.5, 0.5, 0.5, 1))
    reach = (frame.to_3x3() @ Vector((1, 1, 1))).length
    rotation = towards.to_track_quat('Z', 'Y')
    thing.matrix_world = Matrix.LocRotScale(middle.xyz + reach * towards, rotation, (1, 1, 1))
    collection.objects.link(thing)
    return thing


def kind_of(block):
    """Returns the kind of data of a driver's variable."""
    kinds = {bpy.types.Light: 'LIGHT', bpy.types.Volume: 'VOLUME', bpy.types.Material: 'MATERIAL'}
    return next((name for kind, name in kinds.items() if isinstance(block, kind)), 'OBJECT')


def drive(owner, path, index, expression, variables):
    """Adds a driver. Expressions use only arithmetic, sin and cos: Blender evaluates these even if a file may not run
    Python."""
    curve = owner.driver_add(path, index) if index is not None else owner.driver_add(path)
    curve.driver.type = 'SCRIPTED'
    for name, (thing, kind) in variables.items():
        variable = curve.driver.variables.new()
        variable.name = name
        target = variable.targets[0]
        if kind.startswith("ROT_"):
            variable.type = 'TRANSFORMS'
            target.id = thing
            target.transform_type = kind
            target.rotation_mode = 'XYZ'
            target.transform_space = 'WORLD_SPACE'
        elif kind == 'SCALE_AVG':
            variable.type = 'TRANSFORMS'
            target.id = thing
            target.transform_type = kind
            target.transform_space = 'WORLD_SPACE'
        else:
            target.id_type = kind_of(thing)
            target.id = thing
            target.data_path = kind
    curve.driver.expression = expression


def drive_rate(look, frame):
    """Makes the ray's step follow the frame's scale: Cycles multiplies a volume's step by its material's rate."""
    drive(look, "cycles.volume_step_rate", None, "fabs(scale)", {"scale": (frame, 'SCALE_AVG')})


def drive_step(thing, look):
    """Notes the ray's step in the world for the material, as Cycles will use it."""
    thing["isoshade_step"] = thing.data.render.step_size
    drive(thing, '["isoshade_step"]', None, "step * rate", {"step": (thing.data, "render.step_size"), "rate": (look, "cycles.volume_step_rate")})


def light_handles(about, look, collection):
    """Makes suns rotate the volume's lights: the z axis, computed from the angles, drives the direction."""
    tree = look.node_tree
    axis = ("cos(z) * sin(y) * cos(x) + sin(z) * sin(x)", "sin(z) * sin(y) * cos(x) - cos(z) * sin(x)", "cos(y) * cos(x)")
    for i, light in enumerate(about["lights"]):
        sun = bpy.data.objects.get(f"isoshade light {i + 1}") or sun_object(i + 1, light, about, collection)
        for c in range(3):
            drive(tree, f'nodes["isoshade"].inputs["Light {i + 1}"].default_value', c, axis[c],
                  {"x": (sun, 'ROT_X'), "y": (sun, 'ROT_Y'), "z": (sun, 'ROT_Z')})
        drive(tree, f'nodes["isoshade"].inputs["Intensity {i + 1}"].default_value', None, "energy / pi", {"energy": (sun.data, "energy")})
        for c in range(3):
            drive_by(tree, f'nodes["isoshade"].inputs["Color {i + 1}"].default_value', c, sun.data, f"color[{c}]")


# ---- the explanation -----------------------------------------------------------------------------------------

README = """{name}, exported by isoshade{source}

The wire box "{name}" represents the volume: move, rotate or scale it, and grids and normals follow.
{far}{levels}Rotate a sun "isoshade light N" to rotate a light of the volume. Its color, and its strength over pi, apply to the light too.
The property "physical" of the box selects the material. 0: exact, emission and absorption, lit by these suns only. 1: scattering with
shadows, lit by all lamps and the world. The text "isoshade agreement" makes the settings of the validated picture (Alt P). Material "{name}", group
"isoshade": ambient, diffuse, specular, power, and Density Scale as a factor of the extinction. The color map is the image "isoshade transfer function", exact and
packed. Use Ramp = 1 uses the ColorRamps in "isoshade ramp" instead, which you can edit. Their alpha is the opacity of a
length, as in a transfer function's file. As exported they differ from the exact map by up to:
{ramps}
A millimeter is {units:g} Blender unit(s).{unit} Cycles uses a step of {step:.4g} units, times the scale of the box; a longer step is
faster, a shorter one more exact (Volume data > Render > Step Size). For pictures with an alpha channel turn on Film > Transparent. Cycles renders on the {device} (Render > Device). Made by Blender {blender}, which shifts voxels by {shift}
of a voxel; the volume objects are shifted back. Other versions of Blender may differ: export again with the one that you
use.
"""


def ramp_lines(ramps):
    """Returns one line per ramp: objects, stops, length of the opacity, and losses."""
    return "".join("    {}: {} stops{}, opacity of {:.4g} mm; {:.2g} in color, {:.2g} in opacity\n".format(
        ", ".join(ramp["of"]), len(ramp["stops"]), ", the points of the transfer function" if ramp["own_points"] else "",
        ramp["unit_distance_mm"], ramp["color_loss"], ramp["opacity_loss"]) for ramp in ramps)


def explain(about, shift):
    ramps = about["tf"]["ramps"]
    several = ('Its property "level" selects the visible level of the pyramid.\n'
               if len({level["level"] for level in about["levels"]}) > 1 else "")
    if "sequence" in about:
        several += (f"Frames 1 to {about['sequence']} are the frames of a series, whose files are numbered from 0, with one color map and\n"
                   "one range for all.\n")
    if "planned" in about:
        several = "A plan chose the resolution by the scene: finer for visible parts, coarser for hidden ones.\n"
    if "more" in about:
        several += ("Several volumes: each has a box, a material and a collection of its own, and the property \"show\" of its box, 0 or 1,\n"
                    "hides it. Overlapping volumes add up. They are {}.\n"
                    .format(", ".join(f'"{one["name"]}"' for one in [about] + about["more"])))
    if any("roi" in level for level in about["levels"]):
        several += ('The object "... roi" is a finer level inside a box; in the band around the box both are blended. Its properties\n'
                    'isoshade_roi_* and those of the volume around it must be the same except the side.\n')
    several += "".join("Values of level {level}: {values}.\n".format(**level) for level in about["levels"] if "values" in level)
    far = ("The volume is far from the world's origin, and Blender's positions have single precision: the origin of this\n"
           "file is the point ({:.17g}, {:.17g}, {:.17g}) of the world, in millimeters.\n".format(*about["origin_mm"])
           if any(about["origin_mm"]) else "")
    if "labels" in about:
        several += ('A label map: the image "isoshade labels" holds the class of each voxel, and is looked up without interpolation; the\n'
                    'color map and the ColorRamp have one entry per class. Classes, by label:\n'
                    + "".join(f"    {number}: {label}{', ' if name else ''}{name}\n"
                              for number, (label, name) in enumerate(about["labels"]["classes"])))
    text = bpy.data.texts.new("README")
    text.write(README.format(name=about["name"], source=" from " + about["source"] if about["source"] else "",
                             far=far, levels=several, units=about["units_per_mm"],
                             unit=f' The unit of the data is {about.get("unit", "")}.' if about.get("unit", "") else "", ramps=ramp_lines(ramps), step=about["levels"][0]["step"],
                             blender=bpy.app.version_string, shift=shift,
                             device=bpy.context.scene.cycles.device))
    scene = bpy.context.scene
    scene["isoshade_source"] = about["source"]
    scene["isoshade_voxel_shift"] = shift
    scene["isoshade_origin_mm"] = about["origin_mm"]
    scene["isoshade_units_per_mm"] = about["units_per_mm"]
    scene["isoshade_unit"] = about.get("unit", "")
