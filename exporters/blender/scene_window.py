# SPDX-License-Identifier: GPL-3.0-or-later
"""The window of a newly opened file, and a sign for missing grid files.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part."""
import bpy
from mathutils import Matrix, Vector

# ---- signs for missing files ------------------------------------------------------------------------------------


def sign_paint():
    """A red material that ignores lights."""
    paint = bpy.data.materials.new("isoshade missing file")
    tree = tree_of(paint)
    paint.diffuse_color = (1, 0.1, 0.05, 1)
    nodes = tree.nodes
    emission = nodes.new('ShaderNodeEmission')
    emission.inputs["Color"].default_value = (1, 0.1, 0.05, 1)
    sink = nodes.new('ShaderNodeOutputMaterial')
    sink.location = (240, 0)
    tree.links.new(emission.outputs["Emission"], sink.inputs["Surface"])
    return paint


def sign_group(thing, words, size, frames, paint):
    """Geometry nodes that show a text if the volume is empty, in frames 1 to `frames` of a series. A volume without its
    file has no bounding box. Unlike scripts in a file, geometry nodes need no permission to run."""
    tree = bpy.data.node_groups.new("isoshade missing file", 'GeometryNodeTree')
    if hasattr(tree, "interface"):
        tree.interface.new_socket(name="Geometry", in_out='OUTPUT', socket_type='NodeSocketGeometry')
    else:
        tree.outputs.new('NodeSocketGeometry', "Geometry")
    column = 0

    def node(kind, inputs, **settings):
        nonlocal column
        result = tree.nodes.new(kind)
        result.location = (200 * column, 0)
        column += 1
        for key, value in settings.items():
            if hasattr(result, key):
                setattr(result, key, value)
        sockets = {one.name: one for one in result.inputs if one.enabled}
        for key, value in inputs.items():
            place = socket(result.inputs, key) if kind.startswith("Shader") else sockets[key]
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, place)
            else:
                place.default_value = value
        return next(one for one in result.outputs if one.enabled)

    volume = node('GeometryNodeObjectInfo', {"Object": thing}).node.outputs["Geometry"]
    box = node('GeometryNodeBoundBox', {"Geometry": volume}).node
    extent = node('ShaderNodeVectorMath', dict(zip(VECTOR, (box.outputs["Min"], box.outputs["Max"]))), operation='DISTANCE').node.outputs["Value"]
    silent = node('ShaderNodeMath', dict(zip(MATH, (extent, 0.0))), operation='GREATER_THAN')
    if frames:
        frame = node('GeometryNodeInputSceneTime', {}).node.outputs["Frame"]
        early = node('ShaderNodeMath', dict(zip(MATH, (frame, 0.5))), operation='LESS_THAN')
        late = node('ShaderNodeMath', dict(zip(MATH, (frame, frames + 0.5))), operation='GREATER_THAN')
        outside = node('ShaderNodeMath', dict(zip(MATH, (early, late))), operation='ADD')
        silent = node('ShaderNodeMath', dict(zip(MATH, (silent, outside))), operation='ADD')
    text = node('GeometryNodeStringToCurves', {"String": words, "Size": size}, align_x='CENTER', align_y='MIDDLE')
    curves = node('GeometryNodeRealizeInstances', {"Geometry": text})
    letters = node('GeometryNodeFillCurve', {"Curve": curves})
    letters = node('GeometryNodeSetMaterial', {"Geometry": letters, "Material": paint})
    shown = node('GeometryNodeSwitch', {"Switch": silent, "False": letters}, input_type='GEOMETRY')
    sink = tree.nodes.new('NodeGroupOutput')
    sink.location = (200 * column, 0)
    tree.links.new(shown, sink.inputs["Geometry"])
    return tree


def missing_signs(about, frame, camera, collection):
    """Adds a sign in front of each volume object, facing the camera, hidden when the volume is."""
    middle = Matrix(about["box_to_world"]) @ Vector((0.5, 0.5, 0.5, 1))
    reach = (Matrix(about["box_to_world"]).to_3x3() @ Vector((1, 1, 1))).length
    paint = sign_paint()
    for thing in [thing for thing in collection.objects if thing.type == 'VOLUME']:
        file = thing.data.filepath.lstrip("/")
        words = f"{file}\nis missing: put it next to\nthe .blend file"
        size = 0.9 * reach / max(16.0, 0.6 * max(len(line) for line in words.split("\n")))
        sign = bpy.data.objects.new(f"{thing.name} is missing", bpy.data.meshes.new("isoshade missing file"))
        collection.objects.link(sign)
        sign.parent = frame
        sign.location = middle.xyz
        sign.hide_select = True
        turn = sign.constraints.new('COPY_ROTATION')
        turn.target = camera
        sign.modifiers.new("isoshade missing file", 'NODES').node_group = sign_group(thing, words, size, about.get("sequence", 0), paint)
        if thing.animation_data:
            for curve in thing.animation_data.drivers:
                if curve.data_path in ("hide_render", "hide_viewport"):
                    copy_driver(curve, sign)


def copy_driver(curve, owner):
    """Sets hide_render and hide_viewport by the frame's level, like the volume."""
    targets = {variable.name: variable.targets[0] for variable in curve.driver.variables}
    drive(owner, curve.data_path, None, curve.driver.expression,
          {name: (target.id, target.data_path) for name, target in targets.items()})


# ---- the window ------------------------------------------------------------------------------------------------


def choose(frame, collection):
    """Selects the box, by which people move the volume, and activates it and its collection."""
    layer = bpy.context.view_layer
    layer.active_layer_collection = layer.layer_collection.children[collection.name]
    for thing in bpy.context.scene.objects:
        thing.select_set(thing == frame)
    layer.objects.active = frame


def set_eevee(scene, distance, reach):
    """Sets the range of EEVEE's slices from the nearest to the farthest part of the volume, from any side at the
    camera's distance. Blender 4.2 and later finds that range in each view. Its reprojection keeps the first frame after
    a file is opened, in which opaque parts are gray."""
    eevee = scene.eevee
    wanted = {"volumetric_start": max(distance - reach, 1e-3 * reach), "volumetric_end": distance + reach,
              "volumetric_tile_size": '4', "volumetric_samples": 128, "volumetric_sample_distribution": 0.0}
    if hasattr(eevee, "use_volume_custom_range"):
        wanted |= {"use_volume_custom_range": False, "use_taa_reprojection": False}
    for name, value in wanted.items():
        if hasattr(eevee, name):
            setattr(eevee, name, value)


def forget_folder(params):
    """Clears the path of file browsers, as it contains the user's home. A shorter path leaves the end of a longer one
    in the file, so the whole buffer is overwritten first."""
    for path in (b"/" * 1000, b"//"):
        params.directory = path


def arrange_windows(scene, about):
    """Sets every 3D view to the camera, with EEVEE, which shows nearly the picture of Cycles at once. Orbiting out of
    the camera view pivots about the volume's center. (Blender does not open files in a rendered view.)"""
    place = Matrix(about["box_to_world"])
    middle = (place @ Vector((0.5, 0.5, 0.5, 1))).xyz
    reach = (place.to_3x3() @ Vector((1, 1, 1))).length / 2
    for x in (-1, 1):
        for y in (-1, 1):
            reach = max(reach, (place.to_3x3() @ Vector((x, y, 1))).length / 2)
    camera = scene.camera
    distance = (middle - camera.matrix_world.translation).length
    set_eevee(scene, distance, reach)
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type == 'TEXT_EDITOR':
                area.spaces.active.text = bpy.data.texts["README"]
            for space in area.spaces:
                if space.type == 'FILE_BROWSER' and space.params:
                    forget_folder(space.params)
            if area.type != 'VIEW_3D':
                continue
            view = area.spaces.active
            view.shading.type = 'MATERIAL'
            view.shading.use_scene_lights = True
            view.shading.use_scene_world = True
            view.clip_start = 1e-3 * reach  # EEVEE computes positions in a volume with it: see clip_start() in
                                            # describe.c
            view.clip_end = max(10 * about["camera"]["clip_end"], 100 * reach)
            view.region_3d.view_location = middle
            view.region_3d.view_rotation = camera.matrix_world.to_quaternion()
            view.region_3d.view_distance = max(distance, 0.1 * reach)
            view.region_3d.view_perspective = 'CAMERA'
            view.region_3d.view_camera_zoom = 17  # the picture's frame fills three quarters of the view's height
