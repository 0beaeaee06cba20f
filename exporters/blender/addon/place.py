# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts an imported volume into a person's own scene: its size, views and camera that see it, and what the scene would
change."""
import math

import bpy
from mathutils import Matrix, Vector

from . import volume

UNITS = (('M', "Meters", "A unit of Blender is a meter"), ('CM', "Centimeters", "A unit of Blender is a centimeter"),
         ('MM', "Millimeters", "A unit of Blender is a millimeter"), ('FIT', "Fit to 1", "The longest side is one unit"))
MM_PER_UNIT = {'M': 1000.0, 'CM': 10.0, 'MM': 1.0}


def corners(frame):
    return [frame.matrix_world @ Vector(corner) for corner in frame.bound_box]


def resize(frame, things, unit):
    """Scales the imported objects about the origin."""
    bpy.context.view_layer.update()
    if unit == 'FIT':
        factor = 1 / max(frame.dimensions)
    else:
        factor = 1 / (MM_PER_UNIT[unit] * frame.get("isoshade_units_per_mm", 1.0))
    for thing in things:
        if thing == frame:
            thing.matrix_world = Matrix.Scale(factor, 4) @ thing.matrix_world
        elif thing.parent is None:
            thing.location = factor * thing.location
    for camera in {thing.data for thing in things if thing.type == 'CAMERA'}:
        camera.clip_start, camera.clip_end, camera.ortho_scale = (
            factor * value for value in (camera.clip_start, camera.clip_end, camera.ortho_scale))
    bpy.context.view_layer.update()


def camera_of(frame):
    """Returns the camera that was imported with a volume."""
    for collection in frame.users_collection:
        for thing in collection.objects:
            if thing.type == 'CAMERA':
                return thing
    return None


def sphere(frame):
    places = corners(frame)
    middle = sum(places, Vector()) / len(places)
    return middle, max((place - middle).length for place in places)


def frame_it(frame, context):
    """Looks at a volume: by its own camera, and in all 3D views."""
    middle, radius = sphere(frame)
    camera = camera_of(frame)
    if camera:
        context.scene.camera = camera
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type != 'VIEW_3D':
                continue
            view = area.spaces.active
            view.region_3d.view_location, view.region_3d.view_distance = middle, 3 * radius
            view.clip_start, view.clip_end = min(view.clip_start, 0.02 * radius), max(view.clip_end, 100 * radius)


def depths(camera, frame):
    """Returns the distances of a volume's corners along the camera's view."""
    inverse = camera.matrix_world.normalized().inverted()
    return [-(inverse @ place).z for place in corners(frame)]


def sees(camera, frame):
    """True if the camera is outside of the volume, with the volume between its clip planes."""
    inside = frame.matrix_world.inverted() @ camera.matrix_world.translation
    low, high = Vector(frame.bound_box[0]), Vector(frame.bound_box[6])
    is_inside, away = all(low[a] < inside[a] < high[a] for a in range(3)), depths(camera, frame)
    return not is_inside and camera.data.clip_start < max(away) and min(away) < camera.data.clip_end


def cautions(frame, context):
    """Returns what keeps this scene from showing the volume as validated."""
    scene, found = context.scene, []
    if scene.camera and not sees(scene.camera, frame):
        found.append("the camera is inside it or cuts it off")
    view = scene.view_settings
    if view.view_transform not in ('Standard', 'Raw'):
        found.append(f"the view transform {view.view_transform} shows other colors (Color Management)")
    if scene.render.engine != 'CYCLES':
        found.append("only Cycles renders it exactly")
    step = volume.shown_object(frame).data.render.step_size * frame.matrix_world.median_scale
    needed = math.ceil(2 * sphere(frame)[1] / step) if step > 0 else 0
    if scene.cycles.volume_max_steps < needed:
        found.append(f"Volumes > Max Steps {scene.cycles.volume_max_steps} makes its steps longer, set {needed}")
    return found
