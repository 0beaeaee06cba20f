# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person finds who opens the file: lights to turn, an explanation.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part.
"""
import math

import bpy
from mathutils import Matrix, Vector

# ---- handles ---------------------------------------------------------------------------------------------------


def sun_object(number, light, about, collection):
    """A sun whose z axis points towards the light, beside the volume."""
    data = bpy.data.lights.new(f"isoshade light {number}", 'SUN')
    # A white matt surface that faces a sun of strength pi is as bright as 1.
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


def drive(owner, path, index, expression, variables):
    """Expressions of arithmetic, sin and cos alone: Blender evaluates them even where a file may not run Python."""
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
        else:
            if not isinstance(thing, bpy.types.Object):
                target.id_type = 'LIGHT'
            target.id = thing
            target.data_path = kind
    curve.driver.expression = expression


def light_handles(about, look, collection):
    """Turning a sun turns the volume's light: its z axis, from its angles, drives the direction."""
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


# ---- what a person finds who opens the file --------------------------------------------------------------------

README = """{name}, exported by isoshade{source}

The wire box "{name}" stands for the volume: move, turn and scale it, grids and normals follow.
{far}{levels}Turn a sun "isoshade light N" to turn a light of the volume; its color and strength, over pi, are the light's.
The property "physical" of the box chooses the material: 0 emission and absorption, exact, lit by these suns alone; 1 scattering with
shadows, lit by every lamp and the world. The text "isoshade agreement" sets what the validated picture needs (run it: Alt P). Material "{name}", group
"isoshade": ambient, diffuse, specular, power, and Density Scale for more or less opacity. The color map is the image "isoshade transfer function", exact and
packed. Use Ramp = 1 takes the ColorRamps in "isoshade ramp" instead, to edit by hand. Their alpha is the opacity of a
length, as in a transfer function's file. As exported they differ from the exact map by up to:
{ramps}
A millimeter is {units:g} Blender unit(s).{unit} Cycles takes a step of {step:.4g} units; a longer step is faster, a shorter one
more exact (change both the volume's render step and its property isoshade_step). For pictures with an alpha channel
turn on Film > Transparent. Cycles renders on the {device} (Render > Device). Made by Blender {blender}, which puts voxels {shift}
of a voxel off: the volume objects are moved back by that. Other versions of Blender may differ; export again with the one that you
use.
"""


def tell_ramps(ramps):
    """A line each: of what, how many stops, opacity of which length, what it loses."""
    return "".join("    {}: {} stops{}, opacity of {:.4g} mm; {:.2g} in color, {:.2g} in opacity\n".format(
        ", ".join(ramp["of"]), len(ramp["stops"]), ", the points of the transfer function" if ramp["own_points"] else "",
        ramp["unit_distance_mm"], ramp["color_loss"], ramp["opacity_loss"]) for ramp in ramps)


def explain(about, shift):
    ramps = about["tf"]["ramps"]
    several = ('Its property "level" chooses the level of the pyramid that is seen.\n'
               if len({level["level"] for level in about["levels"]}) > 1 else "")
    if "sequence" in about:
        several = (f"Frames 1 to {about['sequence']} are those of a series, counted from 0 in the names of their files: one color map and\n"
                   "one range for all of them.\n")
    if "planned" in about:
        several = "A plan left only what the scene needs, finer where it shows and coarser where it does not.\n"
    if "more" in about:
        several += ("Several volumes: each has a box, a material and a collection of its own, and the property \"show\" of its box, 0 or 1,\n"
                    "hides it. Where they overlap they add up. They are {}.\n"
                    .format(", ".join(f'"{one["name"]}"' for one in [about] + about["more"])))
    if any("roi" in level for level in about["levels"]):
        several += ('The object "... roi" is a finer level inside a box; in the band around the box both are blended. Its properties\n'
                    'isoshade_roi_* and those of the volume around it have to be the same but for the side.\n')
    far = ("The volume stands far from the world's origin, and Blender's positions are in single precision: the origin of this\n"
           "file is the point ({:.17g}, {:.17g}, {:.17g}) of the world, in millimeters.\n".format(*about["origin_mm"])
           if any(about["origin_mm"]) else "")
    if "labels" in about:
        several += ('A label map: the image "isoshade labels" holds the class of each voxel, and is looked up without interpolation; the\n'
                    'color map and the ColorRamp have an entry a class. Classes, by label:\n'
                    + "".join(f"    {number}: {label}{', ' if name else ''}{name}\n"
                              for number, (label, name) in enumerate(about["labels"]["classes"])))
    text = bpy.data.texts.new("README")
    text.write(README.format(name=about["name"], source=" from " + about["source"] if about["source"] else "",
                             far=far, levels=several, units=about["units_per_mm"],
                             unit=f' The data\'s lengths are in {about.get("unit", "")}.' if about.get("unit", "") else "", ramps=tell_ramps(ramps), step=about["levels"][0]["step"],
                             blender=bpy.app.version_string, shift=shift,
                             device=bpy.context.scene.cycles.device))
    scene = bpy.context.scene
    scene["isoshade_source"] = about["source"]
    scene["isoshade_voxel_shift"] = shift
    scene["isoshade_origin_mm"] = about["origin_mm"]
    scene["isoshade_units_per_mm"] = about["units_per_mm"]
    scene["isoshade_unit"] = about.get("unit", "")
