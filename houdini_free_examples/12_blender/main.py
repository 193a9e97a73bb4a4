"""blender --background --python main.py -- PICTURE [WIDTH [SAMPLES]]: a glass head in a beam of light, baked by the add-on
and rendered by Cycles. Checks that the caustic is in the picture."""
import math
import os
import sys

import bpy  # first: it finds the others
import addon_utils
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tools/plugins/blender"))
PICTURE, WIDTH, SAMPLES = [*sys.argv[sys.argv.index("--") + 1:], "640", "48"][:3]


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new(kind)
    for socket, value in inputs.items():
        shader.inputs[socket].default_value = value
    made.node_tree.links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def add(name, data, location, rotation=(0, 0, 0)):
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.rotation_euler = location, [math.radians(angle) for angle in rotation]
    bpy.context.scene.collection.objects.link(obj)
    return obj


def build():
    """A head of glass in the dark; a spot above it sends a beam through it and the fog."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("volcaustic_blender", default_set=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_monkey_add(size=1.3, location=(0, 0, 0.1), rotation=(math.radians(-20), 0, math.radians(25)))
    head = bpy.context.object
    head.modifiers.new("smooth", "SUBSURF").levels = 2
    head.modifiers["smooth"].render_levels = 2
    bpy.ops.object.shade_smooth()
    head.data.materials.append(material("glass", "ShaderNodeBsdfGlass", IOR=1.45))
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0.6, 0, 0))
    box = bpy.context.object
    box.name, box.scale, box.display_type, box.hide_render = "domain", (5.6, 2.4, 3.4), "WIRE", True
    spot = bpy.data.lights.new("spot", "SPOT")
    spot.energy, spot.shadow_soft_size, spot.color = 1500, 0.01, (1, 0.93, 0.82)
    spot.spot_size, spot.spot_blend = math.radians(30), 0.3
    add("spot", spot, (-2.1, 0, 1.6), (0, -54.5, 0))
    camera = bpy.data.cameras.new("camera")
    camera.lens = 50
    scene.camera = add("camera", camera, (0.6, -7.2, 0), (90, 0, 0))
    scene.world = None
    settings = scene.volcaustic
    settings.domain, settings.resolution, settings.photons, settings.fog_scattering = box, 224, 1536, 0.12
    return scene


def render(scene, path):
    width = int(WIDTH)
    scene.render.resolution_x, scene.render.resolution_y = width, width * 5 // 8
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", int(SAMPLES)
    scene.cycles.use_denoising = False
    scene.cycles.volume_bounces = 0
    scene.view_settings.view_transform, scene.view_settings.exposure = "Filmic", 0.7
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], -1)[:, :, :3].mean(axis=2)
    bpy.data.images.remove(image)
    return pixels


def brightest(pixels, first, last):
    """Of the columns between two fractions of the width, as means of 3 x 3 pixels."""
    part = pixels[:, int(first * pixels.shape[1]):int(last * pixels.shape[1])]
    rows, columns = (size // 3 * 3 for size in part.shape)
    return part[:rows, :columns].reshape(rows // 3, 3, columns // 3, 3).mean(axis=(1, 3)).max()


SCENE = build()
bpy.ops.volcaustic.bake()
PIXELS = render(SCENE, os.path.abspath(PICTURE))
before, behind = brightest(PIXELS, 0.22, 0.27), brightest(PIXELS, 0.5, 0.6)
print(f"the beam before the head {before:.3f}, its focus behind {behind:.3f} (display values)")
if behind < 1.02 * before:  # without a focus the beam would be a fifth as bright there as here
    sys.exit("the head does not focus the beam")
