# SPDX-License-Identifier: GPL-3.0-or-later
"""isoshade in Blender: import volumes, switch levels, edit transfer functions, certify the scene.

    tables.py     transfer functions as points, stops of a ramp, tables and files; independent of Blender
    program.py    the program isoshade as a child process; independent of Blender
    volume.py     the objects of `isoshade export --to blender` in the open file
    place.py      an imported volume in a person's own scene
    operators.py  the buttons
    cutter.py     empties and meshes that cut the volume
    surface.py    meshes of a surface and of labels
    marks.py      scale bar and axes
    histogram.py  the picture over the ramp
    certify.py    the button that certifies the scene
    own_picture.py  the picture of a copy of the file, in a Blender of its own
    panel.py      the panel in the sidebar of the 3D view"""
import bpy
from bpy.props import BoolProperty, IntProperty, PointerProperty, StringProperty

from . import certify, cutter, histogram, marks, operators, panel, surface

# For Blender before 4.2; later ones read blender_manifest.toml.
bl_info = {
    "name": "isoshade",
    "description": "Scalar volumes that render as validated: import, levels, transfer functions",
    "author": "isoshade",
    "version": (0, 3, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > isoshade",
    "category": "Import-Export",
}


class IsoshadePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", description="Path of isoshade; empty: search PATH", subtype='FILE_PATH')

    def draw(self, _context):
        self.layout.prop(self, "program")


class IsoshadeState(bpy.types.PropertyGroup):
    """State of the window manager: not saved in files."""
    said: StringProperty()
    said_icon: StringProperty(default='INFO')


class IsoshadeScene(bpy.types.PropertyGroup):
    volume: StringProperty(name="Volume", description="Source file of the volume; empty: the one noted by the export", subtype='FILE_PATH')
    with_gl: BoolProperty(name="GL", description="Compare isoshade's ray caster", default=True)
    with_cycles: BoolProperty(name="Cycles", description="Compare Cycles of this Blender", default=True)
    with_povray: BoolProperty(name="POV-Ray", description="Compare POV-Ray", default=False)
    size: IntProperty(name="Size", description="Longer side of the pictures, in pixels", default=96, min=8, max=4096)
    quick: BoolProperty(name="Quick", description="Fewer views and seeds, the same limits", default=True)
    verdict: StringProperty()
    agrees: BoolProperty()
    report: StringProperty(subtype='FILE_PATH')


classes = (IsoshadePreferences, IsoshadeState, IsoshadeScene, *operators.classes, *histogram.classes, *cutter.classes,
           *surface.classes, *marks.classes, *certify.classes, *panel.classes)


def menu(self, _context):
    self.layout.operator("isoshade.import_volume", text="Volume by isoshade")


def register():
    for kind in classes:
        bpy.utils.register_class(kind)
    bpy.types.Scene.isoshade = PointerProperty(type=IsoshadeScene)
    bpy.types.WindowManager.isoshade = PointerProperty(type=IsoshadeState)
    bpy.types.TOPBAR_MT_file_import.append(menu)
    for events in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.load_post):
        events.append(cutter.follow)


def unregister():
    if operators.running is not None:
        operators.running.cancel()
    for events in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.load_post):
        events.remove(cutter.follow)
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    histogram.forget()
    del bpy.types.WindowManager.isoshade, bpy.types.Scene.isoshade
    for kind in reversed(classes):
        bpy.utils.unregister_class(kind)
