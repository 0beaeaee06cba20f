# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of the add-on (exporters/blender/addon: surface.py, marks.py) against closed forms. Run by Blender for
check_meshes.sh; a line "ok NAME" or "not ok NAME: why" each.

blender -b NAME.blend -P meshes.py -- ADDON_FOLDER sphere|labels"""
import math
import sys

import bmesh
import bpy
import numpy
from mathutils import Matrix, Vector

folder, kind = sys.argv[sys.argv.index("--") + 1:]
sys.path.insert(0, folder)
import addon  # noqa: E402
from addon import volume  # noqa: E402

addon.register()
frame = volume.find_frame(bpy.context)
scene = bpy.context.scene

def say(case, good, why=""):
    print(f"ok {case}: {why}" if good else f"not ok {case}: {why}", flush=True)


def press(button, **values):
    try:
        button(**values)
    except RuntimeError as error:
        return str(error).strip()
    return ""


def vertices(thing):
    bpy.context.view_layer.update()
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = shown.to_mesh()
    found = numpy.array([shown.matrix_world @ vertex.co for vertex in mesh.vertices])
    shown.to_mesh_clear()
    return found


def newest(before):
    return sorted((thing for thing in bpy.data.objects if thing not in before), key=lambda thing: thing.name)


def off(thing, value, scale=1, center=(0, 0, 0)):
    """Largest distance in mm of a vertex to the sphere of a value: 1 - |p|, p from -1 to 1 along the shortest edge, 20
    mm. Returns the limit, too: interpolation along an edge of length h loses at most h h / 8 R, and a vertex at the
    mean of a cell's crossings lies as much inside."""
    found, radius = vertices(thing), 10 * (1 - value)
    far = abs(numpy.linalg.norm(found - center, axis=1) / scale - radius).max() if len(found) >= 30 else math.inf
    return far, (2.5 * 2 ** volume.shown_level(frame)) ** 2 / (4 * radius)


def near(case, *where):
    far, limit = off(*where)
    say(case, far <= limit, f"{far:.3g} mm, limit {limit:.3g}, voxels of 2.5 mm at level 0")


def sphere():
    for level in (0, 1):
        press(bpy.ops.isoshade.level, level=level)
        before = set(bpy.data.objects)
        said = press(bpy.ops.isoshade.surface, value=0.3)
        made = newest(before)
        if not made:
            say(f"a_surface_of_level_{level}", False, said)
            continue
        thing = made[0]
        near(f"vertices_of_level_{level}_are_on_the_sphere", thing, 0.3)
        thing.modifiers[0].threshold = 0.4
        near(f"and_after_its_value_was_changed_{level}", thing, 0.4)
        kept = frame.matrix_world.copy()
        frame.matrix_world = Matrix.Translation((3, -2, 1)) @ Matrix.Scale(0.01, 4) @ kept
        near(f"it_moves_and_scales_with_the_volume_{level}", thing, 0.4, 0.01, (3, -2, 1))
        frame.matrix_world = kept
        thing.modifiers[1].show_viewport = False
        far, limit = off(thing, 0.4)
        say(f"half_a_voxel_is_seen_{level}", limit < far < math.inf, f"{far:.3g} mm")
    said = press(bpy.ops.isoshade.label_meshes)
    say("it_has_no_labels", "is not a label map" in said, said)


def ends(bar):
    """Length of a bar in the world, along its own x axis."""
    found = vertices(bar)
    shown = bar.evaluated_get(bpy.context.evaluated_depsgraph_get())
    axis = numpy.array(shown.matrix_world.to_3x3().col[0].normalized())
    along = found @ axis
    return along.max() - along.min(), axis


def marks():
    """A scale bar has its length, and axes their directions, before and after the volume is scaled."""
    before = set(bpy.data.objects)
    press(bpy.ops.isoshade.scale_bar)
    bar, label = newest(before)
    words = label.data.body
    say("its_length_is_round", words == "10 mm" and bar.name.endswith(words), words)
    before = set(bpy.data.objects)
    press(bpy.ops.isoshade.scale_bar, length_mm=0.25)
    short = newest(before)[0]
    say("a_short_one_is_in_micrometers", short.name.endswith("250 µm"), short.name)
    before = set(bpy.data.objects)
    press(bpy.ops.isoshade.axes)
    axes = [thing for thing in newest(before) if thing.type == 'MESH']
    say("there_are_three_axes", len(axes) == 3, newest(before))
    kept = frame.matrix_world.copy()
    right = numpy.array(bpy.context.scene.camera.matrix_world.to_3x3().col[0])
    for case, scale in (("as_imported", 1), ("in_meters", 0.001), ("ten_times_as_large", 10)):
        turn = Matrix.Rotation(0.7, 4, 'Y') @ Matrix.Rotation(-0.3, 4, 'X')
        frame.matrix_world = Matrix.Translation((3, -2, 1)) @ Matrix.Scale(scale, 4) @ turn @ kept
        for thing, mm in ((bar, 10), (short, 0.25)):
            length, axis = ends(thing)
            # Positions have single precision.
            good = abs(length - mm * scale) < 1e-5 * mm * scale + 1e-6 * frame.matrix_world.translation.length
            good = good and abs(axis @ right - 1) < 1e-4
            say(f"a_bar_of_{mm}_mm_has_its_length_{case}", good, f"{length:.6g}, axis {axis}")
        wanted = frame.matrix_world.to_3x3().normalized()
        off = max(abs(ends_of - numpy.array(wanted.col[i])).max() for i, ends_of in enumerate(map(direction, axes)))
        say(f"axes_are_those_of_the_data_{case}", off < 1e-4, f"off by {off:.2g}")
    bar.scale = (1.1, 1, 1)  # planted
    say("a_longer_bar_is_seen", abs(ends(bar)[0] / 100 - 1) > 0.05, ends(bar)[0])
    frame.matrix_world = kept


def direction(thing):
    """Direction from an axis's start, at the lowest corner of the box, to its end."""
    found = vertices(thing)
    start = numpy.array(frame.matrix_world @ Vector(frame.bound_box[0]))
    away = found - start
    tip = away[numpy.linalg.norm(away, axis=1) > 0.9 * numpy.linalg.norm(away, axis=1).max()].mean(axis=0)
    return tip / numpy.linalg.norm(tip)


def volume_of(mesh):
    """Volume in voxels of level 0, of 1 x 1 x 2.5 mm."""
    found = bmesh.new()
    found.from_mesh(mesh)
    size, is_closed = found.calc_volume(signed=True) / 2.5, all(len(edge.link_faces) % 2 == 0 for edge in found.edges)
    found.free()
    return size, is_closed


def label_meshes(**how):
    before = set(bpy.data.objects)
    said = press(bpy.ops.isoshade.label_meshes, **how)
    made = {thing.name.split(".")[0].split()[-1]: thing for thing in newest(before)}
    say(f"each_label_is_a_mesh {how}", sorted(made) == ["bone", "edge", "liver", "nail"], f"{sorted(made)} {said}")
    looks = {thing.active_material.name: tuple(thing.active_material.diffuse_color) for thing in made.values()}
    say("with_a_material_and_a_color", len(set(looks.values())) == 4, looks)
    return made


def coarse_labels():
    """At level 1 a label of even places keeps its volume, also in the half voxels at the border."""
    press(bpy.ops.isoshade.level, level=1)
    made = label_meshes()
    for name, count in (("nail", 64), ("edge", 8)):
        size, is_closed = volume_of(made[name].data)
        say(f"{name}_has_its_volume_at_level_1", is_closed and abs(size / count - 1) < 1e-5, f"{size:.6g} voxels of {count}")
    low, high = (end(vertices(made["nail"]), axis=0) for end in (numpy.min, numpy.max))
    corners = numpy.array([(7.5 + 0.5 * 3.5, -0.5, 2.5 * 3.5), (11.5 + 0.5 * 7.5, 3.5, 2.5 * 7.5)]) + (10, 20, 30)
    off = abs(numpy.array((low, high)) - corners).max()
    say("at_its_place", off < 1e-4, f"off by {off:.3g} mm")
    press(bpy.ops.isoshade.level, level=0)


def smooth_labels(sharp):
    """A smoothed mesh stays closed and near to the faces of the voxels."""
    made = label_meshes(smooth=8)
    for name in ("bone", "nail"):
        shown = made[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
        size, is_closed = volume_of(shown.to_mesh())
        shown.to_mesh_clear()
        whole = volume_of(sharp[name].data)[0]
        away = numpy.linalg.norm(vertices(made[name]) - vertices(sharp[name]), axis=1)
        say(f"a_smooth_{name}_is_closed", is_closed and 0.5 < size / whole < 1, f"{size:.4g} of {whole:.4g} voxels")
        say(f"and_within_a_voxel_{name}", 0.1 < away.max() < math.sqrt(1 + 1 + 2.5 ** 2), f"{away.max():.3g} mm")


def labels():
    """A ball of 33 voxels, and cuboids of 2 x 3 x 4, 4 x 4 x 4 and 4 x 1 x 2, voxels of 1 x 1 x 2.5 mm, sheared."""
    made = label_meshes()
    for name, count, faces in (("liver", 24, 52), ("bone", 33, None), ("nail", 64, 96), ("edge", 8, 28)):
        size, is_closed = volume_of(made[name].data)
        say(f"{name}_has_the_volume_of_its_voxels", abs(size / count - 1) < 1e-5, f"{size:.6g} voxels of {count}")
        say(f"{name}_is_closed", is_closed)
        if faces:
            count = len(made[name].data.polygons)
            say(f"{name}_has_the_faces_of_a_cuboid", count == faces, count)
    found = vertices(made["liver"])
    # Its lowest corner is that of voxel (5, 2, 1): directions (1, 0, 0), (0, 1, 0), (0.5, 0, 2.5), the center of the
    # first voxel at (10, 20, 30).
    want = numpy.array((10 + 4.5 + 0.5 * 0.5, 20 + 1.5, 30 + 0.5 * 2.5))
    low = found[(found @ (1, 10, 100)).argmin()]
    say("at_the_corner_of_its_voxels", abs(low - want).max() < 1e-4, f"{low} {want}")
    refused = press(bpy.ops.isoshade.surface, value=1)
    say("labels_have_no_surface_at_a_value", "is a label map" in refused, refused)
    coarse_labels()
    smooth_labels(made)


if kind == "sphere":
    sphere()
    marks()
else:
    labels()
