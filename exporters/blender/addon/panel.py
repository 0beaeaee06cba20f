# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "isoshade" in the sidebar of the 3D view."""
import bpy

from . import cutter, histogram, operators, volume
from .tables import Refused, value_at


def lines(layout, text, icon, width):
    """Shows a text in several lines, as wide as the panel."""
    column, line = layout.column(align=True), ""
    column.scale_y = 0.8
    for word in text.split():
        if line and len(line) + len(word) > width:
            column.label(text=line, icon=icon)
            line, icon = "", 'BLANK1'
        line += (" " if line else "") + word
    column.label(text=line, icon=icon)


class Section:
    bl_space_type, bl_region_type, bl_category = 'VIEW_3D', 'UI', "isoshade"

    def width(self, context):
        return max(int(context.region.width / 8), 20) if context.region else 40


class ISOSHADE_PT_volume(Section, bpy.types.Panel):
    bl_idname, bl_label = "ISOSHADE_PT_volume", "Volume"

    def draw(self, context):
        layout, frame = self.layout, volume.find_frame(context)
        layout.operator("isoshade.import_volume", icon='IMPORT')
        state = context.window_manager.isoshade
        if operators.running is not None:
            row = layout.row()
            row.label(text=f"{operators.running.what}, {operators.running.seconds():.0f} s", icon='TIME')
            row.operator("isoshade.cancel", text="", icon='CANCEL')
        elif state.said:
            lines(layout, state.said, state.said_icon, self.width(context))
        if not frame:
            return
        levels = volume.level_numbers(frame)
        layout.label(text=frame.name, icon='VOLUME_DATA')
        if len(levels) > 1 and "level" in frame:
            row = layout.row(align=True)
            row.label(text="Level")
            for level in levels:
                row.operator("isoshade.level", text=str(level), depress=level == volume.shown_level(frame)).level = level
        layout.prop(context.scene.isoshade, "volume")
        layout.operator("isoshade.check_files", icon='FILE_TICK')


class ISOSHADE_PT_transfer(Section, bpy.types.Panel):
    bl_idname, bl_label = "ISOSHADE_PT_transfer", "Transfer Function"

    @classmethod
    def poll(cls, context):
        return volume.find_frame(context) is not None

    def draw(self, context):
        layout, frame = self.layout, volume.find_frame(context)
        thing = volume.shown_object(frame)
        try:
            ramp, look = volume.ramp_of(thing), volume.look_of(thing)[0]
        except Refused as error:
            lines(layout, str(error), 'ERROR', self.width(context))
            return
        uses_ramp = look.inputs["Use Ramp"].default_value > 0.5
        row = layout.row(align=True)
        row.operator("isoshade.show", text="Exact Table", depress=not uses_ramp).ramp = False
        row.operator("isoshade.show", text="Ramp", depress=uses_ramp).ramp = True
        picture = histogram.icon(frame, ramp)
        if picture:
            layout.template_icon(icon_value=picture, scale=8)
        else:
            layout.operator("isoshade.histogram", icon='SEQ_HISTOGRAM')
        layout.template_color_ramp(ramp.node, "color_ramp", expand=False)
        row = layout.row()
        unit = histogram.unit_of(frame)
        row.label(text=f"{ramp.lo:g} to {ramp.hi:g}{unit}, opacity of {ramp.unit_mm:.4g} mm")
        row.operator("isoshade.ramp_range", text="", icon='ARROW_LEFTRIGHT')
        column = layout.column(align=True)
        for stop in list(ramp.node.color_ramp.elements)[:12]:
            row = column.row(align=True)
            row.label(text=f"{value_at(stop.position, ramp.lo, ramp.hi):g}{unit}")
            row.label(text=f"{stop.color[3]:.3g}")
            row.prop(stop, "color", text="")
        if ramp.is_shown():
            layout.label(text="The exact table equals the ramp", icon='CHECKMARK')
        else:
            layout.label(text="Edited: bake it", icon='ERROR')
        row = layout.row(align=True)
        row.operator("isoshade.bake", icon='RENDER_STILL')
        row.operator("isoshade.bake", text="All Levels").all_levels = True
        if len(volume.level_numbers(frame)) > 1:
            layout.operator("isoshade.adapt", icon='MOD_MULTIRES')
        row = layout.row(align=True)
        row.operator("isoshade.load_tf", text="Load", icon='FILE_FOLDER')
        row.operator("isoshade.save_tf", text="Save", icon='FILE_TICK')


class ISOSHADE_PT_cut(Section, bpy.types.Panel):
    bl_idname, bl_label = "ISOSHADE_PT_cut", "Cut"

    @classmethod
    def poll(cls, context):
        return volume.find_frame(context) is not None

    def draw(self, context):
        layout, frame = self.layout, volume.find_frame(context)
        row = layout.row(align=True)
        for shape, icon in (('BOX', 'CUBE'), ('SPHERE', 'SPHERE'), ('PLANE', 'EMPTY_SINGLE_ARROW'),
                            ('SELECTED', 'RESTRICT_SELECT_OFF')):
            row.operator("isoshade.cut", text=shape.capitalize(), icon=icon).shape = shape
        try:
            found = cutter.cutters_of(frame)
        except Refused:
            return
        for _, thing in found:
            if thing is not None:
                layout.prop(thing, '["keep_inside"]', text=f"{thing.name}: keep inside")
        if found:
            layout.operator("isoshade.uncut", icon='X')


class ISOSHADE_PT_mesh(Section, bpy.types.Panel):
    bl_idname, bl_label = "ISOSHADE_PT_mesh", "Add to the Scene"

    @classmethod
    def poll(cls, context):
        return volume.find_frame(context) is not None

    def draw(self, context):
        frame = volume.find_frame(context)
        if "isoshade_labels_size" in volume.shown_object(frame):
            self.layout.operator("isoshade.label_meshes", icon='MESH_DATA')
        else:
            self.layout.operator("isoshade.surface", icon='MESH_DATA')
        row = self.layout.row(align=True)
        row.operator("isoshade.scale_bar", icon='DRIVER_DISTANCE')
        row.operator("isoshade.axes", icon='EMPTY_AXIS')


class ISOSHADE_PT_certify(Section, bpy.types.Panel):
    bl_idname, bl_label = "ISOSHADE_PT_certify", "Certify"

    @classmethod
    def poll(cls, context):
        return volume.find_frame(context) is not None

    def draw(self, context):
        layout, options = self.layout, context.scene.isoshade
        row = layout.row(align=True)
        for name in ("with_gl", "with_cycles", "with_povray"):
            row.prop(options, name, toggle=True)
        layout.prop(options, "size")
        layout.prop(options, "quick")
        layout.operator("isoshade.certify", icon='CHECKMARK')
        if options.verdict:
            lines(layout, options.verdict, 'CHECKMARK' if options.agrees else 'ERROR', self.width(context))
            layout.operator("isoshade.open_report", icon='URL')


classes = (ISOSHADE_PT_volume, ISOSHADE_PT_transfer, ISOSHADE_PT_cut, ISOSHADE_PT_mesh, ISOSHADE_PT_certify)
