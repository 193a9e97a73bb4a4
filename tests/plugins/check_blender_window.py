"""blender --python check_blender_window.py: drives the add-on's operators as buttons do, step by step from a timer."""
import os
import traceback

import bpy  # first: it finds the others
import addon_utils

addon_utils.enable("volcaustic_blender", default_set=True)
from volcaustic_blender import job, operators  # noqa: E402


def build_scene():
    scene = bpy.context.scene
    bpy.data.objects.remove(scene.objects["Cube"])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5)
    ball = bpy.context.object
    ball.volcaustic.role = "BODY"
    for frame, x in ((1, 0.0), (8, 0.3)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    scene.frame_end = 8
    scene.volcaustic.resolution, scene.volcaustic.photons = 96, 1500


def press(operator, **values):
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "PROPERTIES")
    with bpy.context.temp_override(window=window, screen=window.screen, area=area, region=area.regions[-1]):
        assert operator.poll()
        return operator("INVOKE_DEFAULT", **values)


def steps():
    """Yields while Blender goes on."""
    build_scene()
    yield
    assert press(bpy.ops.volcaustic.bake, span="ANIMATION") == {"RUNNING_MODAL"}
    assert not bpy.ops.volcaustic.bake.poll(), "one bake at a time"
    told = set()
    while operators.current:
        told.add(operators.current.text)
        yield
    assert any("of 8" in text for text in told), told
    settings = bpy.context.scene.volcaustic
    assert settings.result.type == "VOLUME" and settings.result.data.is_sequence
    folder = os.path.dirname(bpy.path.abspath(settings.baked))
    assert len([f for f in os.listdir(folder) if f.endswith(".vdb")]) == 8

    settings.photons = 8192
    press(bpy.ops.volcaustic.bake, span="FRAME")
    while operators.current.stage != "photons":
        yield
    press(bpy.ops.volcaustic.cancel)
    while operators.current:
        yield
    assert not job.RUNNING and not bpy.ops.volcaustic.cancel.poll()
    assert settings.result.data.is_sequence and os.path.isdir(folder), "what was baked before stays"
    assert not os.path.exists(os.path.join(os.path.dirname(folder), "frame_1")), "what was cancelled goes"

    press(bpy.ops.volcaustic.bake, span="FRAME")
    while operators.current.stage != "photons":
        yield
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    addon_utils.enable("volcaustic_blender", default_set=True)
    yield
    assert not operators.current and not job.RUNNING, "another file ends it"
    assert bpy.ops.volcaustic.bake.poll()
    print("the window bakes, tells and cancels")


STEPS = steps()


def tick():
    try:
        next(STEPS)
        return 0.05
    except StopIteration:
        pass
    except BaseException:
        traceback.print_exc()
    bpy.ops.wm.quit_blender()
    return None


bpy.app.timers.register(tick, first_interval=1, persistent=True)  # over the load of another file
