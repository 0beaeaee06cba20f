# SPDX-License-Identifier: GPL-3.0-or-later
"""The physical material next to the exact one, with the settings that only it needs: lamps, a lit world, bounces.

The exact material has emission and absorption only, as all renderers support. The physical one scatters light, with the
same color map:

    scattering = albedo sigma(s),  absorption = (1 - albedo) sigma(s),  albedo = c(s) within 0 and 1

Both have the same extinction sigma, so they hide the background equally and cast the same shadow. Joined with the other
scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part."""
import math

import bpy

# ---- the material ----------------------------------------------------------------------------------------------


def physical_group():
    """Mixes the materials by a share; at share 0 the result is the exact one, bit for bit."""
    group = Group("isoshade physical", [('NodeSocketColor', "Color", (1, 1, 1, 1)), ('NodeSocketVector', "Shade", (1, 1, 1)),
                                        ('NodeSocketFloat', "Extinction", 0.0), ('NodeSocketFloat', "Physical", 0.0),
                                        ('NodeSocketFloat', "Anisotropy", 0.0)],
                  [('NodeSocketShader', "Volume")])
    color, sigma, physical = (group.given[name] for name in ("Color", "Extinction", "Physical"))
    exact = group.math('SUBTRACT', 1.0, physical, label="share of the exact one")
    emission = group.node('ShaderNodeEmission', "", {
        "Color": group.vector('MULTIPLY', color, group.given["Shade"], label="shaded color"),
        "Strength": group.math('MULTIPLY', sigma, exact)}).outputs["Emission"]
    albedo = group.vector('MINIMUM', group.vector('MAXIMUM', color, (0, 0, 0)), (1, 1, 1), label="albedo")
    # Absorption has the density (1 - color): black gives sigma, the albedo gives the part that is not scattered.
    absorption = group.node('ShaderNodeVolumeAbsorption', "", {
        "Color": group.vector('SCALE', albedo, physical), "Density": sigma}).outputs["Volume"]
    scatter = group.node('ShaderNodeVolumeScatter', "", {
        "Color": albedo, "Density": group.math('MULTIPLY', sigma, physical),
        "Anisotropy": group.given["Anisotropy"]}).outputs["Volume"]

    def add(first, second):
        return group.node('ShaderNodeAddShader', "", {"Shader": first, "Shader_001": second}).outputs["Shader"]

    return group.finish(Volume=add(add(emission, absorption), scatter))


def choose_material(about, frame):
    """Links the volumes to the property "physical" of their box, by drivers without an expression."""
    frame["physical"] = 1 if about["physical"] else 0
    frame.id_properties_ui("physical").update(
        min=0, max=1, description="0: the exact material, for agreement. 1: the physical one, lit by lamps and world")
    frame.property_overridable_library_set('["physical"]', True)
    for thing in frame.children:
        if "isoshade_physical" in thing:
            drive_by(thing, '["isoshade_physical"]', None, frame, '["physical"]')


def drive_by(owner, path, index, source, source_path):
    """Copies the value of another property. Such drivers work even if a file may not run Python."""
    curve = owner.driver_add(path, index) if index is not None else owner.driver_add(path)
    curve.driver.type = 'AVERAGE'
    variable = curve.driver.variables.new()
    target = variable.targets[0]
    target.id_type = kind_of(source)
    target.id = source
    target.data_path = source_path


# ---- light -----------------------------------------------------------------------------------------------------


def light_world(about, world):
    """Makes a world: the camera sees the background; objects get an even light as strong as the ambient term."""
    tree = world.node_tree
    seen = tree.nodes["Background"]
    seen.label = "background of the camera"
    light = tree.nodes.new('ShaderNodeBackground')
    light.name, light.label = "Light", "light of the scene"
    light.inputs["Color"].default_value = (1, 1, 1, 1)
    light.inputs["Strength"].default_value = about["shading"]["ambient"]
    path = tree.nodes.new('ShaderNodeLightPath')
    mix = tree.nodes.new('ShaderNodeMixShader')
    output = next(node for node in tree.nodes if node.bl_idname == 'ShaderNodeOutputWorld')
    tree.links.new(path.outputs["Is Camera Ray"], socket(mix.inputs, "Fac"))
    tree.links.new(light.outputs["Background"], socket(mix.inputs, "Shader"))
    tree.links.new(seen.outputs["Background"], socket(mix.inputs, "Shader_001"))
    tree.links.new(mix.outputs["Shader"], output.inputs["Surface"])
    for node, place in ((path, (-300, 400)), (light, (-300, 50)), (seen, (-300, -150)), (mix, (0, 100)), (output, (200, 100))):
        node.location = place


# ---- settings --------------------------------------------------------------------------------------------------

# Settings that artists expect from F12: smooth edges, soft shadows, bounced light. Adaptive sampling ends early without
# noise, as everywhere in the exact material.
ARTIST_SETTINGS = {"samples": 64, "use_adaptive_sampling": True, "adaptive_threshold": 0.02, "adaptive_min_samples": 8,
                   "filter_width": 1.5, "max_bounces": 12, "volume_bounces": 12}

AGREEMENT = '''"""The picture that isoshade validates: the exact material, one sample at each pixel's center.

Run it here (Alt P) before a render, or:  blender -b NAME.blend --python-text "isoshade agreement" -f 1
"""
import bpy

scene = bpy.context.scene
for thing in scene.objects:
    if "physical" in thing:
        thing["physical"] = 0
        thing.update_tag()
for name, value in {settings!r}.items():
    setattr(scene.cycles, name, value)
'''


def set_for_artist(scene):
    """Switches from the agreement settings, which a text block keeps, to the settings for F12."""
    keep = {name: getattr(scene.cycles, name) for name in ARTIST_SETTINGS}
    bpy.data.texts.new("isoshade agreement").write(AGREEMENT.replace("{settings!r}", repr(keep)))
    for name, value in ARTIST_SETTINGS.items():
        setattr(scene.cycles, name, value)
