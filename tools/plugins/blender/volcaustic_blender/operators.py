"""Bake, and cancel."""

import contextlib
import hashlib
import os
import re
import shutil
import tempfile

import bpy
from bpy.app.handlers import persistent
from bpy.props import EnumProperty

from . import export, job, volume

current = None  # the bake that runs in the background


def cache_folder(scene):
    """Of a scene: beside the .blend; of one that is not saved in Blender's temporary folder, which goes with the session."""
    if bpy.data.is_saved:
        base, name = os.path.split(bpy.data.filepath)
    else:
        base, name = bpy.app.tempdir or tempfile.gettempdir(), "unsaved"
    scene_name = f"{bpy.path.clean_name(scene.name)}_{hashlib.sha256(scene.name.encode()).hexdigest()[:6]}"
    return os.path.join(base, "volcaustic_cache", os.path.splitext(name)[0], scene_name)


def bakes_in(folder, span):
    """Numbers of the bakes of a kind, in the folders frame_1, animation_1 and so on."""
    names = os.listdir(folder) if os.path.isdir(folder) else []
    return sorted(int(match.group(1)) for match in (re.fullmatch(span + r"_(\d+)", name) for name in names) if match)


class Task:
    """From the scene to the volume, in steps that take no longer than the meshes of a frame. Each bake has a folder of its
    own: what was shown before stays until the new one is whole, and Blender reads no old file from its memory."""

    def __init__(self, context, span):
        scene = context.scene
        self.scene_name = scene.name_full
        self.frames = ([scene.frame_current] if span == "FRAME" else list(range(scene.frame_start, scene.frame_end + 1)))
        if self.frames[0] < 0:
            raise export.Refused("frames below 0 have no place in file names; let the animation begin at 0 or later")
        self.program = job.find_program(bpy.path.abspath(context.preferences.addons[__package__].preferences.program))
        self.cache, self.span = cache_folder(scene), span.lower()
        self.folder = os.path.join(self.cache, f"{self.span}_{max(bakes_in(self.cache, self.span), default=0) + 1}")
        self.warnings, self.cancelled, self.bake = [], False, None
        self.stage, self.text = "scene", "reading the scene"
        self.gathering = export.export(context, self.folder, self.frames)

    def step(self):
        """\\returns whether it goes on. \\throws Refused."""
        if self.bake:
            self.stage, self.text = self.bake.stage, self.bake.text
            return self.bake.running()
        if self.cancelled:
            return False
        try:
            self.text = next(self.gathering)
        except StopIteration as done:
            path, self.warnings = done.value
            self.bake = job.Bake([self.program, "trace", path, "-o", os.path.join(self.folder, "caustic.####.vdb"), "--preset",
                                  "blender", "--progress", "--frames", f"{self.frames[0]}-{self.frames[-1]}"])
        return True

    def cancel(self):
        self.cancelled = True
        self.stop_gathering()
        if self.bake:
            self.bake.cancel()

    def stop_gathering(self):
        with contextlib.suppress(ReferenceError):  # of a scene that is no more
            self.gathering.close()

    def drop(self):
        """Leaves nothing behind."""
        self.stop_gathering()
        if self.bake:
            self.bake.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def show(self):
        """The volume in the scene that it is of. The bake before it stays for Undo; older ones of its kind go."""
        scene = next((s for s in bpy.data.scenes if s.name_full == self.scene_name), None)
        if not scene:
            raise export.Refused(f"{self.scene_name}: the scene is no more; its volumes are in {self.folder}")
        volume.show(scene, os.path.join(self.folder, "caustic.####.vdb"), self.frames)
        for number in bakes_in(self.cache, self.span)[:-2]:
            shutil.rmtree(os.path.join(self.cache, f"{self.span}_{number}"), ignore_errors=True)


def sentence(error):
    return f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else str(error)


class VOLCAUSTIC_OT_bake(bpy.types.Operator):
    bl_idname = "volcaustic.bake"
    bl_label = "Bake Caustics"
    bl_description = "Send light through the scene's glass and import what it lights up as a volume"

    span: EnumProperty(name="Frames", items=[("FRAME", "This Frame", ""), ("ANIMATION", "Animation", "")])

    @classmethod
    def poll(cls, context):
        return current is None

    def refused(self, error):
        self.report({"ERROR"}, sentence(error))
        return {"CANCELLED"}

    def finish(self, task):
        bake = task.bake
        for line in task.warnings + (bake.warnings if bake else []):
            self.report({"WARNING"}, line)
        try:
            if task.cancelled:
                task.drop()
                self.report({"INFO"}, "the bake was cancelled")
                return {"CANCELLED"}
            if failure := bake.failure:
                task.drop()
                raise export.Refused(failure)
            task.show()
        except (export.Refused, OSError) as error:
            return self.refused(error)
        if not bpy.app.background:
            bpy.ops.ed.undo_push(message=self.bl_label)
        return {"FINISHED"}

    def execute(self, context):
        """Waits: for scripts and for Blender without a window."""
        task = None
        try:
            task = Task(context, self.span)
            while task.step():
                if task.bake:
                    task.bake.wait()
        except (export.Refused, OSError) as error:
            if task:
                task.drop()
            return self.refused(error)
        return self.finish(task)

    def invoke(self, context, event):
        global current
        try:
            current = Task(context, self.span)
        except (export.Refused, OSError) as error:
            return self.refused(error)
        self.task = current
        self.timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.task.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        for area in context.screen.areas if context.screen else ():
            if area.type == "PROPERTIES":
                area.tag_redraw()
        context.workspace.status_text_set(f"volcaustic: {self.task.text}   Esc: cancel")
        try:
            if self.task.step():
                return {"PASS_THROUGH"}
        except (export.Refused, OSError, ReferenceError) as error:
            self.task.drop()
            self.cancel(context)
            return self.refused("the scene was undone while it was read" if isinstance(error, ReferenceError) else error)
        self.cancel(context)
        return self.finish(self.task)

    def cancel(self, context):
        """At its end, and where Blender gives it up."""
        global current
        current = None
        context.window_manager.event_timer_remove(self.timer)
        if context.workspace:
            context.workspace.status_text_set(None)


class VOLCAUSTIC_OT_cancel(bpy.types.Operator):
    bl_idname = "volcaustic.cancel"
    bl_label = "Cancel"
    bl_description = "End the bake; the volume that is there stays"

    @classmethod
    def poll(cls, context):
        return current is not None

    def execute(self, context):
        current.cancel()
        return {"FINISHED"}


@persistent
def another_file(*_):
    """A bake is of the file that is open."""
    global current
    if current:
        current.drop()
    current = None


CLASSES = (VOLCAUSTIC_OT_bake, VOLCAUSTIC_OT_cancel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_pre.append(another_file)


def unregister():
    another_file()
    bpy.app.handlers.load_pre.remove(another_file)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
