# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons. Commands of isoshade run in parallel with Blender, and a timer polls them; in background mode, which has
no timers, Blender waits."""
import json
import math
import os
import pathlib
import shutil
import tempfile

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import place, program, tables, volume
from .tables import Refused

running = None  # the running command


def preferences(context):
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def isoshade(context):
    chosen = preferences(context)
    return program.find(chosen.program if chosen else "")


def tell(text, icon):
    """Keeps a message in the panel until the next command."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()
    state = bpy.context.window_manager.isoshade
    state.said, state.said_icon = text, icon


def pop_up(text, icon):
    if bpy.context.window_manager.windows:
        bpy.context.window_manager.popup_menu(lambda menu, _: menu.layout.label(text=text), title="isoshade", icon=icon)


def poll():
    """Polls the command for the timer; None ends the timer."""
    global running
    if running is None:
        return None
    job = running
    try:
        if not job.ended():
            for window in bpy.context.window_manager.windows:
                for area in window.screen.areas:
                    if area.type == 'VIEW_3D':
                        area.tag_redraw()
            return 0.25
        running = None
        tell(job.finish(job), 'CHECKMARK')
    except Refused as error:
        running = None
        tell(str(error), 'ERROR')
        pop_up(str(error), 'ERROR')
    return None


class Button:
    """Reports Refused as a Blender error, in one line."""

    bl_options = {'REGISTER', 'UNDO'}

    def execute(self, context):
        try:
            said, icon = self.work(context), 'CHECKMARK'
        except Refused as error:
            tell(str(error), 'ERROR')
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        if said:
            level = 'WARNING' if said.startswith("Careful") else 'INFO'
            tell(said, 'ERROR' if level == 'WARNING' else icon)
            self.report({level}, said)
        return {'FINISHED'}

    def run(self, context, what, commands, finish):
        """Starts commands; in background mode waits for them and returns the result of finish()."""
        global running
        if running is not None:
            raise Refused(f"{running.what} runs; wait for it or cancel it")
        job = program.Job(what, commands, bpy.app.binary_path, finish)
        if bpy.app.background:
            job.wait()
            return job.finish(job)
        running = job
        bpy.app.timers.register(poll, first_interval=0.25)
        return f"{what} ..."


class ISOSHADE_OT_cancel(bpy.types.Operator):
    """End the running command"""
    bl_idname, bl_label = "isoshade.cancel", "Cancel"

    def execute(self, _context):
        if running is not None:
            running.cancel()
        return {'FINISHED'}


# ---- volumes ---------------------------------------------------------------------------------------------------


def take_over(path, into, context, unit='MM'):
    """Appends the contents of an exported .blend to the open file, in its units; the grids stay in place. Returns the
    frame."""
    before = set(bpy.data.objects)
    with bpy.data.libraries.load(path, link=False) as (there, here):
        if into == 'SCENE':
            here.scenes = list(there.scenes[:1])
        else:
            here.collections = list(there.collections[:1])
    new = [thing for thing in bpy.data.objects if thing not in before]
    frames = [thing for thing in new if volume.levels_of(thing)]
    if not frames or not (here.scenes if into == 'SCENE' else here.collections):
        raise Refused(f"{path}: has no volume of isoshade")
    if into == 'SCENE':
        context.window.scene = here.scenes[0]
    else:
        context.scene.collection.children.link(here.collections[0])
        place.resize(frames[0], new, unit)
        cameras = [thing for thing in new if thing.type == 'CAMERA']
        if context.scene.camera is None and cameras:
            context.scene.camera = cameras[0]
    for thing in new:
        if thing.type == 'VOLUME':
            file = os.path.join(os.path.dirname(path), os.path.basename(thing.data.filepath.replace("\\", "/")))
            thing.data.filepath = bpy.path.relpath(file) if bpy.data.filepath else file
    return frames[0]


def note_values(frame, text):
    """Keeps the histogram and the unit of the values, which `isoshade info --json` printed; without them if it is older
    than the add-on, or if the volume has one value."""
    try:
        about = json.loads(text[text.index("{"):])
        counts = [float(v) for v in about["histogram"]]
        lo, hi = float(about["min"]), float(about["max"])
    except (ValueError, KeyError, TypeError, RecursionError):
        return
    if hi > lo and counts and all(math.isfinite(v) and v >= 0 for v in (*counts, hi - lo)):
        frame["isoshade_histogram"] = [lo, hi, *counts]
        frame["isoshade_value_unit"] = str(about.get("value_unit", ""))[:32]


class ISOSHADE_OT_import(Button, bpy.types.Operator, ImportHelper):
    """Import a volume: NRRD, NIfTI, DICOM, TIFF, or another file that isoshade reads"""
    bl_idname, bl_label = "isoshade.import_volume", "Import Volume"
    filter_glob: StringProperty(default="*", options={'HIDDEN'})
    levels: IntProperty(name="Levels", description="The volume, and copies with half of the voxels along each axis", default=3, min=1, max=8)
    adapt: BoolProperty(name="Adapt", description="Adapt the transfer function of each level, so that it looks like the finest", default=True)
    all_voxels: BoolProperty(name="All voxels", description="Keep hidden voxels, so that an edited transfer function can show them; larger files", default=True)
    transfer: StringProperty(name="Transfer function", description="A file, or a preset such as ct-bone; empty: suggested by the volume")
    look: StringProperty(name="Scene file", description="A scene of isoshade (*.scene.json); empty: the volume from the front", subtype='FILE_PATH')
    folder: StringProperty(name="Folder", description="For the grids and their .blend; empty: that of the open .blend, or of the volume", subtype='DIR_PATH')
    into: EnumProperty(name="Into", items=(('SCENE', "A scene of its own", "With its camera and the validated render settings"),
                                           ('HERE', "This scene", "Add volume and lights to the open scene, and keep its settings")))
    unit: EnumProperty(name="Size", description="In this scene: what a unit of Blender is", items=place.UNITS, default='M')
    frame_it: BoolProperty(name="Frame it", description="In this scene: look at the volume, with its own camera", default=True)

    def draw(self, _context):
        for name in ("levels", "adapt", "all_voxels", "transfer", "look", "folder", "into"):
            self.layout.prop(self, name)
        for name in ("unit", "frame_it") if self.into == 'HERE' else ():
            self.layout.prop(self, name)

    def output(self):
        base = os.path.basename(os.path.normpath(self.filepath))
        stem = base.split(".")[0] or "volume"
        folder = bpy.path.abspath(self.folder) if self.folder else os.path.dirname(bpy.data.filepath or os.path.abspath(self.filepath))
        if not os.path.isdir(folder):
            raise Refused(f"{folder}: is not a folder")
        path = os.path.join(folder, stem + ".blend")
        for number in range(1, 1000):
            if not os.path.exists(path):
                return path
            path = os.path.join(folder, f"{stem}-{number}.blend")
        raise Refused(f"{path}: already exists")

    def work(self, context):
        source = os.path.abspath(bpy.path.abspath(self.filepath))
        if not os.path.exists(source):
            raise Refused(f"{source}: does not exist")
        target, into, unit, frame_it = self.output(), self.into, self.unit, self.frame_it
        path = isoshade(context)
        command = [path, "export", source, "--to", "blender", "--levels", str(self.levels), "-q", "-o", target]
        command += ["--dense"] if self.all_voxels and program.has_option(path, "export", "--dense") else []
        command += ["--adapt"] if self.adapt and self.levels > 1 else []
        command += ["--tf", program.argument(self.transfer)] if self.transfer else []
        command += ["--scene", os.path.abspath(bpy.path.abspath(self.look))] if self.look else []

        def finish(job):
            if job.code() != 0:
                raise Refused(job.complaint())
            frame = take_over(target, into, bpy.context, unit)
            frame["isoshade_volume"] = source
            note_values(frame, job.output())
            bpy.context.view_layer.objects.active = frame
            if into == 'HERE':
                if frame_it:
                    place.frame_it(frame, bpy.context)
                careful = place.cautions(frame, bpy.context)
                if careful:
                    return f"Careful: {frame.name} is imported, but {'; '.join(careful)}"
            return f"{frame.name}: {len(volume.level_numbers(frame))} levels from {os.path.basename(source)}; the grids are next to {target}"

        return self.run(context, f"Importing {os.path.basename(source)}", [command, [path, "info", source, "--json"]],
                        finish)


class ISOSHADE_OT_level(Button, bpy.types.Operator):
    """Show this level of the volume; colors stay"""
    bl_idname, bl_label = "isoshade.level", "Level"
    level: IntProperty(name="Level", min=0, max=63)

    def work(self, context):
        frame = volume.need_frame(context)
        levels = volume.level_numbers(frame)
        if "level" not in frame or self.level not in levels:
            raise Refused(f"{frame.name} has the level{'s' if len(levels) > 1 else ''} {', '.join(map(str, levels))}")
        volume.set_level(frame, self.level)


class ISOSHADE_OT_check_files(Button, bpy.types.Operator):
    """Check that the grid files of all volumes of this scene exist"""
    bl_idname, bl_label = "isoshade.check_files", "Check Files"

    def work(self, context):
        missing = volume.missing_files(context.scene)
        if missing:
            name, path = missing[0]
            more = f", and {len(missing) - 1} more" if len(missing) > 1 else ""
            raise Refused(f"{name}: its file is missing: {path}{more}")
        count = sum(thing.type == 'VOLUME' for thing in context.scene.objects)
        return f"The files of all {count} volumes exist"


# ---- transfer functions ----------------------------------------------------------------------------------------


class ISOSHADE_OT_show(Button, bpy.types.Operator):
    """Show the volume by the exact table, or by the ramp, whose edits show at once"""
    bl_idname, bl_label = "isoshade.show", "Show"
    ramp: BoolProperty(name="Ramp", description="The ramp instead of the exact table", default=False)

    def work(self, context):
        look, _ = volume.look_of(volume.shown_object(volume.need_frame(context)))
        look.inputs["Use Ramp"].default_value = float(self.ramp)


class ISOSHADE_OT_bake(Button, bpy.types.Operator):
    """Bake the ramp to the exact table, so that the exact material shows its edits"""
    bl_idname, bl_label = "isoshade.bake", "Bake"
    all_levels: BoolProperty(name="All levels", description="Give all levels the ramp of the visible one", default=False)

    def work(self, context):
        frame = volume.need_frame(context)
        ramp = volume.ramp_of(volume.shown_object(frame))
        flat = []
        for thing in volume.levels_of(frame):
            if self.all_levels:
                thing["isoshade_ramp"] = float(ramp.index)
        worst, where, baked = 0.0, 0.0, 0
        for own, things in volume.ramps_of(frame):
            if own.is_shown() and not (self.all_levels and own.index == ramp.index):
                continue
            flat += [thing.name for thing in things if thing.get("isoshade_last_row", 0) > 0]
            error = volume.bake(own, things)
            worst, where = max((worst, where), error)
            baked += len(things)
        left_out = volume.left_out_but_shown(frame)
        if left_out:
            return "Careful: the ramp shows values from {:g} to {:g}, which the grids leave out; import the volume with all voxels".format(*left_out)
        if flat:
            return f"Careful: {flat[0]}: the ramp has replaced its 2D transfer function"
        if worst > 1 / 255:
            return (f"Careful: at {where:g} the table of {volume.Table(volume.shown_object(frame)).count} entries misses the ramp by {worst:.2g}; "
                    "export with a larger table_size")
        return f"Baked the ramp to the exact table of {baked} level{'s' if baked != 1 else ''}" if baked else "The exact table already equals the ramp"


class ISOSHADE_OT_range(Button, bpy.types.Operator):
    """Let the ramp span these values; stops within keep their values"""
    bl_idname, bl_label = "isoshade.ramp_range", "Range of the Ramp"
    lo: FloatProperty(name="From", precision=4)
    hi: FloatProperty(name="To", precision=4)

    def invoke(self, context, _event):
        try:
            ramp = volume.ramp_of(volume.shown_object(volume.need_frame(context)))
        except Refused as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        self.lo, self.hi = ramp.lo, ramp.hi
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context):
        ramp = volume.ramp_of(volume.shown_object(volume.need_frame(context)))
        if not self.hi > self.lo:
            raise Refused(f"The range is {self.lo:g} to {self.hi:g}, its end must exceed its start")
        lo, hi = (tables.plain(v) for v in (self.lo, self.hi))
        points = [p for p in ramp.points() if lo <= p[0] <= hi]
        for end, at in ((lo, 0), (hi, len(points) + 1)):
            if not any(p[0] == end for p in points):
                points.insert(min(at, len(points)), [end, *map(float, tables.evaluate(ramp.points(), [end])[0])])
        if len(points) > tables.MOST_STOPS:
            raise Refused(f"The range would need {len(points)} stops, Blender has {tables.MOST_STOPS}")
        ramp.set_range(lo, hi)
        ramp.set_stops(tables.stops_of_points(points, lo, hi))


class ISOSHADE_OT_adapt(Button, bpy.types.Operator):
    """Make a transfer function for each coarser level, so that it looks like the finest one"""
    bl_idname, bl_label = "isoshade.adapt", "Adapt Levels"
    always: BoolProperty(name="Always", description="Adapt even if small views show no benefit", default=False)

    def work(self, context):
        frame = volume.need_frame(context)
        levels = volume.levels_of(frame)
        if int(levels[0]["isoshade_level"]) != 0 or len(levels) != len(volume.level_numbers(frame)):
            raise Refused("Levels are adapted to level 0, in files without a region of interest: import the volume with it")
        if len(levels) < 2:
            raise Refused(f"{frame.name} has one level: there is nothing to adapt")
        finest = levels[0]
        kept = volume.shown_level(frame)
        ramp = volume.ramp_of(finest)
        if not ramp.is_shown():
            volume.bake(ramp, [finest])
        tf = volume.present_transfer_function(finest)
        folder = tempfile.mkdtemp(prefix="isoshade-")
        path = os.path.join(folder, "own.tf.json")
        pathlib.Path(path).write_text(json.dumps(tf), encoding="utf-8")
        last = int(levels[-1]["isoshade_level"])
        command = [isoshade(context), "tf", "adapt", volume.volume_path(frame, context.scene), "--tf", path, "--levels", str(last + 1),
                   "-q", "-o", os.path.join(folder, "adapted"), *(["--always"] if self.always else [])]
        names = [thing.name for thing in levels[1:]]

        def finish(job):
            try:
                if job.code() != 0:
                    raise Refused(job.complaint())
                return take_adapted([bpy.data.objects[name] for name in names if name in bpy.data.objects], folder, ramp.unit_mm)
            finally:
                shutil.rmtree(folder, ignore_errors=True)

        try:
            return self.run(context, f"Adapting {len(levels) - 1} levels", [command], finish)
        except Refused:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        finally:
            volume.set_level(frame, kept)


def take_adapted(things, folder, unit_mm):
    for thing in things:
        path = os.path.join(folder, f"adapted_level_{int(thing['isoshade_level'])}.tf.json")
        try:
            text = pathlib.Path(path).read_text(encoding="utf-8")
        except OSError as error:
            raise Refused(f"{path}: {error.strerror}") from None
        points, lo, hi, of_mm = tables.from_json(text, os.path.basename(path), None)
        points = [p[:4] + [float(tables.opacity(tables.extinction(p[4], of_mm), unit_mm))] for p in points]
        own = volume.ramp_of(thing)
        shared = sum(volume.ramp_of(other).index == own.index for other in volume.levels_of(thing.parent)) > 1
        ramp = volume.add_ramp(thing) if shared else own
        table = volume.Table(thing)
        count = min(len(points), table.image.size[0])
        table.write(tables.make_table(lambda values: tables.evaluate(points, values), lo, hi, count, ramp.unit), lo, hi)
        ramp.set_points(points)
        ramp.note(own_points=len(points) <= tables.MOST_STOPS)
        ramp.note_shown()
    return f"{len(things)} levels have transfer functions of their own"


class ISOSHADE_OT_save(Button, bpy.types.Operator, ExportHelper):
    """Save the shown transfer function as a file for isoshade"""
    bl_idname, bl_label = "isoshade.save_tf", "Save Transfer Function"
    filename_ext = ".tf.json"
    filter_glob: StringProperty(default="*.tf.json", options={'HIDDEN'})

    def check(self, _context):
        return False  # ExportHelper supports suffixes with a single dot only

    def work(self, context):
        tf = volume.present_transfer_function(volume.shown_object(volume.need_frame(context)))
        path = bpy.path.abspath(self.filepath)
        path += "" if path.endswith(".json") else ".tf.json"
        try:
            temporary = path + ".part"
            pathlib.Path(temporary).write_text(json.dumps(tf, indent=1) + "\n", encoding="utf-8")
            os.replace(temporary, path)
        except OSError as error:
            raise Refused(f"{path}: {error.strerror}") from None
        return f"{path}: {len(tf['points'])} points"


class ISOSHADE_OT_load(Button, bpy.types.Operator, ImportHelper):
    """Give all levels the transfer function of a file (isoshade.tf/1)"""
    bl_idname, bl_label = "isoshade.load_tf", "Load Transfer Function"
    filter_glob: StringProperty(default="*.json", options={'HIDDEN'})

    def work(self, context):
        frame = volume.need_frame(context)
        path = bpy.path.abspath(self.filepath)
        try:
            if os.path.getsize(path) > 1 << 26:
                raise Refused(f"{path}: is too large for a transfer function")
            text = pathlib.Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise Refused(f"{path}: {getattr(error, 'strerror', None) or 'is not text'}") from None
        things = volume.levels_of(frame)
        first = volume.Table(things[0])
        known = [float(v) for v in frame.get("isoshade_value_range", (first.lo, first.hi))]
        voxel = frame.get("isoshade_voxel_mm")
        points, lo, hi, unit_mm = tables.from_json(text, os.path.basename(path), known, voxel)
        ramp = volume.ramp_of(volume.shown_object(frame))
        for thing in things:
            thing["isoshade_ramp"] = float(ramp.index)
        ramp.set_points(points, unit_mm)
        for thing in things:
            table = volume.Table(thing)
            count = table.image.size[0]
            table.write(tables.make_table(lambda values: tables.evaluate(points, values), lo, hi, count, ramp.unit), lo, hi)
        ramp.note(own_points=len(points) <= tables.MOST_STOPS)
        ramp.note_shown()
        return f"{os.path.basename(path)}: {len(points)} points, for all levels"


classes = (ISOSHADE_OT_cancel, ISOSHADE_OT_import, ISOSHADE_OT_level, ISOSHADE_OT_check_files, ISOSHADE_OT_show, ISOSHADE_OT_bake, ISOSHADE_OT_range,
           ISOSHADE_OT_adapt, ISOSHADE_OT_save, ISOSHADE_OT_load)
