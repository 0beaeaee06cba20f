# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's panel as a person sees it: installs it, imports a volume, certifies the scene, and writes what the window
shows. Needs a display (xvfb-run).

    blender --factory-startup -P addon_picture.py -- ADDON.zip ISOSHADE VOLUME SCENE FOLDER PICTURE.png"""
import importlib
import os
import sys

import bpy

zip_path, program, source, look, folder, picture = sys.argv[sys.argv.index("--") + 1:]
if bpy.app.version >= (4, 2, 0):
    module = "bl_ext.user_default.isoshade"
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
else:
    module = "isoshade"
    bpy.ops.preferences.addon_install(filepath=zip_path)
    bpy.ops.preferences.addon_enable(module=module)
bpy.context.preferences.addons[module].preferences.program = program
bpy.context.preferences.view.show_splash = False
operators = importlib.import_module(module + ".operators")


def in_view():
    """The 3D view as the place where buttons are pressed."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == 'VIEW_3D')
    region = next(region for region in area.regions if region.type == 'WINDOW')
    return bpy.context.temp_override(window=window, screen=window.screen, area=area, region=region), area.spaces.active, window


def press(button, **values):
    with in_view()[0]:
        button(**values)


def hide_other_panels():
    """So that the panel's tab is the one that is open: no API chooses it in Blender 3.4."""
    for kind in bpy.types.Panel.__subclasses__():
        if getattr(kind, "bl_category", "") in ("Item", "Tool", "View", "Animation") and getattr(kind, "bl_region_type", "") == 'UI':
            try:
                bpy.utils.unregister_class(kind)
            except RuntimeError:
                pass


def steps():
    """One after the other: each yields how long to wait, or waits for the command that runs."""
    _, space, window = in_view()
    hide_other_panels()
    space.show_region_ui, space.show_region_toolbar = True, False
    press(bpy.ops.isoshade.import_volume, filepath=source, levels=3, adapt=True, look=look, folder=folder, into='SCENE')
    yield None
    window.scene.isoshade.with_cycles, window.scene.isoshade.size = False, 48
    press(bpy.ops.isoshade.certify)
    yield None
    window.view_layer.objects.active = None
    space.region_3d.view_perspective, space.overlay.show_overlays, space.shading.type = 'CAMERA', False, 'RENDERED'
    yield 75.0
    press(bpy.ops.screen.screenshot, filepath=picture)
    print("said:", window.scene.isoshade.verdict, flush=True)
    os._exit(0)


def tick(running=steps()):
    if operators.running is not None:
        return 0.5
    try:
        return next(running) or 0.5
    except Exception as error:  # else Blender stays open
        print("failed:", error, flush=True)
        os._exit(1)


bpy.app.timers.register(tick, first_interval=2.0)
