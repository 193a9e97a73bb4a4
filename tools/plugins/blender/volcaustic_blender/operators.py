"""Bake, and cancel."""

import os
import tempfile

import bpy
from bpy.props import EnumProperty

from . import export, job, volume

current = None  # the bake that runs in the background


def cache_folder(scene):
    """Beside the .blend; of one that is not saved in Blender's temporary folder, which goes with the session."""
    base = bpy.path.abspath("//") if bpy.data.is_saved else bpy.app.tempdir or tempfile.gettempdir()
    return os.path.join(base, "volcaustic_cache", bpy.path.clean_name(scene.name))


class VOLCAUSTIC_OT_bake(bpy.types.Operator):
    bl_idname = "volcaustic.bake"
    bl_label = "Bake Caustics"
    bl_description = "Send light through the scene's glass and import what it lights up as a volume"

    span: EnumProperty(name="Frames", items=[("FRAME", "This Frame", ""), ("ANIMATION", "Animation", "")])

    @classmethod
    def poll(cls, context):
        return current is None

    def start(self, context):
        scene = context.scene
        self.frames = ([scene.frame_current] if self.span == "FRAME"
                       else list(range(scene.frame_start, scene.frame_end + 1)))
        if self.frames[0] < 0:
            raise export.Refused("frames below 0 have no place in file names; let the animation begin at 0 or later")
        preferences = context.preferences.addons[__package__].preferences
        program = job.find_program(preferences.program)
        folder = cache_folder(scene)
        path, warnings = export.export(context, folder, self.frames)
        for line in warnings:
            self.report({"WARNING"}, line)
        self.pattern = os.path.join(folder, "caustic.####.vdb")
        return job.Bake([program, "trace", path, "-o", self.pattern, "--preset", "blender", "--progress", "--frames",
                         f"{self.frames[0]}-{self.frames[-1]}"])

    def refused(self, sentence):
        self.report({"ERROR"}, sentence)
        return {"CANCELLED"}

    def finish(self, context, bake):
        if bake.cancelled:
            self.report({"INFO"}, "the bake was cancelled")
            return {"CANCELLED"}
        if bake.failure:
            return self.refused(bake.failure)
        volume.show(context.scene, self.pattern, self.frames)
        return {"FINISHED"}

    def execute(self, context):
        """Waits: for scripts and for Blender without a window."""
        try:
            bake = self.start(context)
        except (export.Refused, OSError) as refused:
            return self.refused(str(refused))
        bake.wait()
        return self.finish(context, bake)

    def invoke(self, context, event):
        global current
        try:
            current = self.start(context)
        except (export.Refused, OSError) as refused:
            return self.refused(str(refused))
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        global current
        if event.type == "ESC" and event.value == "PRESS":
            current.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        for area in context.screen.areas if context.screen else ():
            if area.type == "PROPERTIES":
                area.tag_redraw()
        context.workspace.status_text_set(f"volcaustic: {current.text}   Esc: cancel")
        if current.running():
            return {"PASS_THROUGH"}
        bake, current = current, None
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)
        return self.finish(context, bake)


class VOLCAUSTIC_OT_cancel(bpy.types.Operator):
    bl_idname = "volcaustic.cancel"
    bl_label = "Cancel"
    bl_description = "End the bake; volumes that are whole stay"

    @classmethod
    def poll(cls, context):
        return current is not None

    def execute(self, context):
        current.cancel()
        return {"FINISHED"}


CLASSES = (VOLCAUSTIC_OT_bake, VOLCAUSTIC_OT_cancel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    global current
    current = None
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
