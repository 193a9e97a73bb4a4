"""blender --background --python check_blender_addon.py -- FOLDER: the add-on from end to end."""
import json
import math
import os
import subprocess
import sys
import time

import bpy  # first: it finds the others
import addon_utils
import numpy as np

OUT = sys.argv[sys.argv.index("--") + 1]
PROGRAM = os.environ["VOLCAUSTIC"]
ADDON = "volcaustic_blender"
WIDTH, HEIGHT = 160, 120


def program(*arguments):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def add(data, location=(0, 0, 0), rotation=(0, 0, 0)):
    obj = bpy.data.objects.new(data.name, data)
    obj.location, obj.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(obj)
    return obj


def glass(index):
    material = bpy.data.materials.new("glass")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeBsdfGlass")
    shader.inputs["IOR"].default_value = index
    material.node_tree.links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def dark_world():
    world = bpy.data.worlds.new("dark")
    world.color = (0, 0, 0)
    if world.node_tree:  # always, since Blender 5.0
        world.node_tree.nodes.clear()
    return world


def build_scene():
    """A glass ball in a box of thin fog, under a sun that stands a little to the side."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(ADDON, default_set=True)  # the factory's settings have forgotten it
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, segments=64, ring_count=32, location=(0, 0, 0.4))
    ball = bpy.context.object
    ball.name = "Ball / größte"
    ball.data.materials.append(glass(1.5))
    bpy.ops.mesh.primitive_cube_add(size=2)
    box = bpy.context.object
    box.name, box.scale, box.display_type, box.hide_render = "domain", (1, 0.8, 1.2), "WIRE", True
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle, sun.color = 3, 0, (1, 0.8, 0.5)
    sun = add(sun, rotation=(0, math.radians(15), 0))
    camera = add(bpy.data.cameras.new("camera"), (0, -7, 0), (math.pi / 2, 0, 0))
    camera.data.lens = 80
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.world = dark_world()
    settings = scene.volcaustic
    settings.domain, settings.resolution, settings.photons = box, 96, 256
    settings.fog_scattering, settings.fog_absorption = 0.12, 0.03
    return ball, sun


def test_settings_live_in_the_file():
    ball, _ = build_scene()
    ball.volcaustic.priority = 3
    path = os.path.join(OUT, "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    scene = bpy.context.scene
    assert scene.volcaustic.domain.name == "domain" and scene.volcaustic.photons == 256
    assert scene.objects["Ball / größte"].volcaustic.priority == 3


def bake(span="FRAME"):
    assert bpy.ops.volcaustic.bake(span=span) == {"FINISHED"}
    return bpy.context.scene.volcaustic.result


def exported():
    path = os.path.join(os.path.dirname(bpy.path.abspath(bpy.context.scene.volcaustic.baked)), "scene.json")
    program("scene", "check", path)
    with open(path, encoding="utf-8") as file:
        return path, json.load(file)


def test_a_frame():
    volume = bake()
    _, scene = exported()
    light = scene["lights"][0]
    assert np.allclose(light["irradiance"], [3, 2.4, 1.5]) and light["type"] == "directional"
    assert np.allclose(light["direction"], [-math.sin(math.radians(15)), 0, -math.cos(math.radians(15))], atol=1e-6)
    assert light["samples"] == 16 and len(scene["lights"]) == 1
    assert scene["materials"]["Ball / größte"]["index"] == 1.5 and scene["objects"][0]["priority"] == 3
    assert np.allclose(scene["volume"]["bounds"]["max"], [1, 0.8, 1.2])
    assert volume.data.render.clipping == 0 and not volume.data.is_sequence
    assert volume.data.grids.load(), volume.data.grids.error_message
    assert {"emission", "density", "radiance"} <= {grid.name for grid in volume.data.grids}
    assert volume.data.filepath.startswith("//"), "the folder can be moved"
    first = volume.data.filepath
    again = bake()
    assert volume.data.filepath != first, "Blender would show what it has in memory"
    assert again == volume and len([o for o in bpy.context.scene.objects if o.type == "VOLUME"]) == 1


def picture(path):
    """Linear pixels, rows from the top."""
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:], float).reshape(image.size[1], image.size[0], -1)[::-1, :, :3]
    bpy.data.images.remove(image)
    return pixels


def render_with_cycles(path, samples=16):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.cycles.volume_step_rate = 0.5
    if hasattr(scene.cycles, "volume_biased"):  # since Blender 5.0: march instead of sampling with noise
        scene.cycles.volume_biased = True
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def luminance(pixels):
    return pixels @ [0.2126, 0.7152, 0.0722]


def test_cycles_shows_what_volcaustic_sees(ball):
    """Without the glass, which volcaustic's view looks through: below it both see straight to the caustic."""
    scene_file, _ = exported()
    ours = os.path.join(OUT, "ours.exr")
    program("render", scene_file, "-o", ours, "-o", os.path.join(OUT, "ours.png"), "--float", "--layers", "R,G,B,A")
    theirs = os.path.join(OUT, "theirs.exr")
    ball.hide_render = True
    sun = bpy.context.scene.objects["sun"]
    sun.hide_render = True  # its light is in the volume
    render_with_cycles(theirs)
    ball.hide_render = sun.hide_render = False
    a, b = luminance(picture(ours)), luminance(picture(theirs))
    rows = slice(HEIGHT // 2 + 6, HEIGHT)  # below the ball
    a, b = a[rows], b[rows]
    peaks = [np.array(np.unravel_index(np.argmax(box(v)), v.shape)) for v in (a, b)]
    correlation = np.corrcoef(a.ravel(), b.ravel())[0, 1]
    level = b.sum() / a.sum()
    print(f"peaks {peaks[0]} {peaks[1]}, correlation {correlation:.4f}, Cycles / volcaustic {level:.4f}, "
          f"brightest {a.max():.4f} {b.max():.4f}")
    assert np.abs(peaks[0] - peaks[1]).max() <= 2, peaks
    assert correlation > 0.97 and abs(level - 1) < 0.05, (correlation, level)
    # The sun comes from the right, so its caustic is to the left of the middle.
    assert peaks[1][1] < WIDTH / 2 - 4, peaks
    assert a.max() > 4 * np.median(a)


def test_a_new_bake_is_seen(sun):
    """Blender keeps volumes in memory by the names of their files."""
    scene = bpy.context.scene
    path = os.path.join(OUT, "again.exr")
    sun.hide_render = True  # in the picture, not in the bakes

    def brightness():
        scene.volcaustic.resolution, sun.hide_render = 32, False
        bake()
        scene.volcaustic.resolution, sun.hide_render = 96, True
        render_with_cycles(path, samples=4)
        return luminance(picture(path)).sum()

    before = brightness()
    sun.data.energy *= 10
    ratio = brightness() / before
    sun.data.energy /= 10
    sun.hide_render = False
    assert abs(ratio - 10) < 0.1, ratio


def box(values):
    """3 x 3 means, so that a single noisy pixel is no peak."""
    padded = np.pad(values, 1, mode="edge")
    return sum(padded[i:i + values.shape[0], j:j + values.shape[1]] for i in range(3) for j in range(3)) / 9


def test_an_animation(sun):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 4, 6
    for frame, angle in ((4, 15), (6, -15)):
        sun.rotation_euler = (0, math.radians(angle), 0)
        sun.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(5)
    volume = bake("ANIMATION")
    assert scene.frame_current == 5, "the frame is what it was"
    _, data = exported()
    assert [key[0] for key in data["animation"]["/lights/0/direction"]] == [4, 5, 6]
    assert data["objects"][0]["mesh"].endswith(".ply") and "####" not in data["objects"][0]["mesh"], "it does not move"
    assert volume.data.is_sequence
    for frame in (4, 5, 6):
        scene.frame_set(frame)
        assert volume.data.grids.load(), volume.data.grids.error_message
        assert volume.data.grids.frame == frame, (volume.data.grids.frame, frame)
    ball = scene.objects["Ball / größte"]
    for frame, height in ((4, 0.4), (6, 0.5)):
        ball.location.z = height
        ball.keyframe_insert("location", frame=frame)
    bake("ANIMATION")
    _, data = exported()
    assert data["objects"][0]["mesh"].endswith(".####.ply"), "a moving body is a sequence"
    ball.animation_data_clear()
    sun.animation_data_clear()
    scene.frame_end = 4


def irradiance_at_the_origin(values):
    """Of a light above it, on a horizontal plane: Lambert's law over an area light's rectangle or ellipse."""
    if values["type"] == "directional":
        return values["irradiance"][0]
    if values["type"] != "area":
        return values["intensity"][0] / np.dot(values["position"], values["position"])
    side = (np.arange(200) + 0.5) / 200 - 0.5
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    inside = x ** 2 + y ** 2 < 0.25 if values["round"] else np.ones(len(x), bool)
    axis, u = (np.array(values[name]) / np.linalg.norm(values[name]) for name in ("direction", "across"))
    places = (np.array(values["position"]) + np.outer(x[inside] * values["width"], u)
              + np.outer(y[inside] * values["height"], np.cross(axis, u)))
    squared = (places ** 2).sum(axis=1)
    return values["intensity"][0] * (np.maximum(-places @ axis, 0) * places[:, 2] / squared ** 2).mean()


def test_lights_are_as_bright_as_in_cycles():
    """On a white sheet in Cycles, and computed from what the add-on says of a light."""
    from volcaustic_blender.export import light_values
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(ADDON, default_set=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=0.2)
    sheet = bpy.data.materials.new("white")
    sheet.use_nodes = True
    sheet.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 1, 1, 1)
    sheet.node_tree.nodes.clear()
    diffuse = sheet.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    sheet.node_tree.links.new(diffuse.outputs[0], sheet.node_tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    bpy.context.object.data.materials.append(sheet)
    scene.camera = add(bpy.data.cameras.new("camera"), (0, 0, 1), (0, 0, 0))
    scene.camera.data.lens = 500
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.world = dark_world()
    for kind, shape in (("POINT", ""), ("SPOT", ""), ("SUN", ""), ("AREA", "SQUARE"), ("AREA", "RECTANGLE"), ("AREA", "DISK"),
                        ("AREA", "ELLIPSE")):
        light = bpy.data.lights.new(kind, kind)
        light.energy = 5 if kind == "SUN" else 100
        obj = add(light, (0, 0, 2))
        if kind == "AREA":
            light.shape, light.size, light.size_y = shape, 1.2, 0.5
            obj.location, obj.rotation_euler, obj.scale = (0.7, -0.4, 2), (0.5, 0.3, 0.9), (2, 1, 1)
        elif kind != "SUN":
            light.shadow_soft_size = 0
        bpy.context.view_layer.update()
        ours = irradiance_at_the_origin(light_values(obj.name, obj.data, obj.matrix_world))
        path = os.path.join(OUT, f"{kind}{shape}.exr")
        render_with_cycles(path, samples=1024 if kind == "AREA" else 16)
        theirs = picture(path)[2:6, 2:6, 0].mean() * math.pi
        print(f"{kind} {shape}: irradiance {ours:.4f}, in Cycles {theirs:.4f} W/m2")
        assert abs(theirs / ours - 1) < 0.01, (kind, ours, theirs)
        bpy.data.objects.remove(obj)


def exported_scene(frames=(1,)):
    """What the add-on would bake, without the bake."""
    from volcaustic_blender import export
    folder = os.path.join(OUT, "exported")
    steps = export.export(bpy.context, folder, frames)
    try:
        while True:
            next(steps)
    except StopIteration as done:
        path, warnings = done.value
    program("scene", "check", path)
    with open(path, encoding="utf-8") as file:
        return path, json.load(file), warnings


def mesh_of(path, entry):
    """Volume and middle of an exported mesh, by the divergence theorem."""
    mesh = os.path.join(os.path.dirname(path), entry["mesh"])
    with open(mesh, "rb") as file:
        content = file.read()
    header, body = content.split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in header.decode().splitlines() if line.startswith("element")]
    points = np.frombuffer(body, "<f8", counts[0] * 3).reshape(-1, 3)
    faces = np.frombuffer(body, [("n", "u1"), ("c", "<i4", 3)], counts[1], counts[0] * 24)["c"]
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6, (points.min(axis=0) + points.max(axis=0)) / 2


def three_cubes():
    """Geometry nodes that put a cube on each of three points above each other."""
    group = bpy.data.node_groups.new("three", "GeometryNodeTree")
    if hasattr(group, "interface"):  # since Blender 4.0
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        group.outputs.new("NodeSocketGeometry", "Geometry")
    line, shape, instance, out = (group.nodes.new(kind) for kind in (
        "GeometryNodeMeshLine", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "NodeGroupOutput"))
    line.inputs["Count"].default_value, line.inputs["Offset"].default_value = 3, (0, 0, 3)
    group.links.new(line.outputs[0], instance.inputs["Points"])
    group.links.new(shape.outputs[0], instance.inputs["Instance"])
    group.links.new(instance.outputs[0], out.inputs[0])
    return group


def test_what_is_rendered_is_exported():
    """Instances, curves and modifiers are; what is hidden from renders or in collections that are is not."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(ADDON, default_set=True)
    scene = bpy.context.scene
    add(bpy.data.lights.new("sun", "SUN"))
    clear = glass(1.3)

    def cube(name, collection):
        bpy.ops.mesh.primitive_cube_add(size=1)
        obj = bpy.context.object
        obj.name = name
        obj.data.materials.append(clear)
        for holder in obj.users_collection:
            holder.objects.unlink(obj)
        collection.objects.link(obj)
        return obj

    sources, hidden = bpy.data.collections.new("sources"), bpy.data.collections.new("hidden")
    for collection in (sources, hidden):
        scene.collection.children.link(collection)
    cube("source", sources)
    cube("unseen", hidden)
    hidden.hide_render = True
    cube("off", scene.collection).hide_render = True
    row = cube("row", scene.collection)
    array = row.modifiers.new("array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (2, 0, 0)
    row.scale = (1, 1, 0.5)
    bpy.context.view_layer.layer_collection.children["sources"].exclude = True
    for name, x, scale in (("left", -5, (2, 2, 2)), ("right", 5, (-1, 1, 1))):
        empty = bpy.data.objects.new(name, None)
        scene.collection.objects.link(empty)
        empty.location, empty.scale = (x, 0, 0), scale
        empty.instance_type, empty.instance_collection = "COLLECTION", sources
    cubes = cube("cubes", scene.collection)
    cubes.modifiers.new("nodes", "NODES").node_group = three_cubes()
    text = bpy.data.curves.new("text", "FONT")
    text.body, text.extrude = "V", 0.1
    text.materials.append(clear)
    add(text, (0, 3, 0))
    bpy.context.view_layer.update()
    path, data, warnings = exported_scene()
    assert not warnings, warnings
    found = {entry["name"]: mesh_of(path, entry) for entry in data["objects"]}
    kinds = sorted(name.split(".")[0] for name in found)
    assert kinds == ["cubes/cubes"] * 3 + ["left/source", "right/source", "row", "text"], kinds
    heights = sorted(middle[2] for name, (_, middle) in found.items() if name.startswith("cubes"))
    assert np.allclose(heights, [0, 3, 6]), heights
    for name, (volume, middle) in found.items():
        expected = {"left": (8, -5), "right": (1, 5), "row": (1.5, 2)}.get(name.split("/")[0])
        if expected:
            assert abs(volume - expected[0]) < 1e-6 and abs(middle[0] - expected[1]) < 1e-6, (name, volume, middle)
    assert found["text"][0] > 0, "outwards"


def test_what_is_not_taken_is_said():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(ADDON, default_set=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, segments=8, ring_count=4)
    ball = bpy.context.object
    ball.name, ball.modifiers.new("smooth", "SUBSURF").render_levels = "ball", 3
    clear = glass(1.3)
    ball.data.materials.append(clear)
    shader = next(n for n in clear.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfGlass")
    value = clear.node_tree.nodes.new("ShaderNodeValue")
    clear.node_tree.links.new(value.outputs[0], shader.inputs["IOR"])
    for frame, index in ((1, 1.2), (3, 1.6)):
        value.outputs[0].default_value = index
        value.outputs[0].keyframe_insert("default_value", frame=frame)
    lamp = bpy.data.lights.new("lamp", "SPOT")
    lamp.energy, lamp.spot_blend = 10, 0
    spot = add(lamp, (0, 0, 3))
    bpy.ops.mesh.primitive_cube_add(size=3)
    scene.volcaustic.domain = bpy.context.object
    bpy.data.objects.remove(bpy.context.object)
    scene.world = dark_world()
    scene.volcaustic.fog_scattering = 0
    path, data, warnings = exported_scene((1, 2, 3))
    assert len(warnings) == 2 and "modifier smooth" in warnings[1] and "Fog is 0" in warnings[0], warnings
    assert np.allclose([key[1] for key in data["animation"]["/materials/ball/index"]], [1.2, 1.4, 1.6], atol=1e-6), data["animation"]
    assert "bounds" not in data["volume"], "a domain that was deleted is none"
    for degrees in (1, 3, 15, 45, 90, 120, 180):
        lamp.spot_size = math.radians(degrees)
        light = exported_scene()[1]["lights"][0]
        assert light["innerAngle"] <= light["outerAngle"] <= 90 and abs(light["outerAngle"] - degrees / 2) < 1e-4
    scene.volcaustic.fog_scattering, ball.modifiers["smooth"].render_levels = 0.1, 1
    spot.hide_viewport = True
    assert "lamp: is hidden in the viewport" in exported_scene()[2][0]
    spot.hide_viewport = False
    world = scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    sky = world.node_tree.nodes.new("ShaderNodeTexSky")
    world.node_tree.links.new(sky.outputs[0], world.node_tree.nodes["Background"].inputs["Color"])
    assert "neither one color nor a map" in exported_scene()[2][0]
    for owner, name, value, words in ((scene.volcaustic, "world_light", True, "World Light"), (lamp, "energy", -1, "negative")):
        before = getattr(owner, name)
        setattr(owner, name, value)
        try:
            exported_scene()
            raise AssertionError(words)
        except Exception as refused:
            assert words in str(refused), refused
        setattr(owner, name, before)


def test_the_world_is_where_cycles_has_it():
    """A map with one bright spot, turned by a Mapping node: volcaustic's background and Cycles' show it at the same place."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable(ADDON, default_set=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_cube_add(size=0.01, location=(0, 0, -50))  # behind the camera
    bpy.context.object.data.materials.append(glass(1.01))
    pixels = np.full((32, 64, 4), 0.1, np.float32)
    pixels[18:20, 40:42, :3] = (5, 3, 1)  # rows from below
    picture_file = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    picture_file.colorspace_settings.is_data = True  # numbers as they are
    picture_file.pixels = pixels.ravel()
    picture_file.filepath_raw, picture_file.file_format = os.path.join(OUT, "sky.exr"), "OPEN_EXR"
    picture_file.save()
    world = scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    texture, mapping, coordinate = (nodes.new("ShaderNode" + kind) for kind in ("TexEnvironment", "Mapping", "TexCoord"))
    texture.image = bpy.data.images.load(os.path.join(OUT, "sky.exr"))
    mapping.inputs["Rotation"].default_value[2] = math.radians(35)
    links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
    nodes["Background"].inputs["Strength"].default_value = 2
    scene.camera = add(bpy.data.cameras.new("camera"), (0, 0, 0), (math.radians(100), 0, math.radians(-140)))
    scene.camera.data.lens = 18
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.volcaustic.world_light, scene.volcaustic.fog_scattering = True, 0
    for kind in ("POINT", "TEXTURE"):
        mapping.vector_type = kind
        bpy.context.view_layer.update()
        path, data, _ = exported_scene()
        assert data["lights"] == [{"name": "world", "type": "environment"}]
        ours, theirs = os.path.join(OUT, "sky_ours.exr"), os.path.join(OUT, f"sky_theirs_{kind}.exr")
        program("render", path, "-o", ours, "--float", "--layers", "R,G,B,A", "--set", "photons.grid=[8,8]", "--set",
                "volume.resolution=8")
        render_with_cycles(theirs)
        a, b = luminance(picture(ours)), luminance(picture(theirs))
        correlation = np.corrcoef(a.ravel(), b.ravel())[0, 1]
        print(f"world, {kind}: correlation {correlation:.4f}, brightest {a.max():.3f} {b.max():.3f}")
        assert b.max() > 2 and correlation > 0.98, (kind, correlation)


def refusal(**changes):
    """What the operator says to a person."""
    settings = bpy.context.scene.volcaustic
    before = {name: getattr(settings, name) for name in changes}
    for name, value in changes.items():
        setattr(settings, name, value)
    try:
        bpy.ops.volcaustic.bake()
    except RuntimeError as error:
        return str(error)
    finally:
        for name, value in before.items():
            setattr(settings, name, value)
    raise AssertionError(f"nothing was said of {changes}")


def test_faults_are_sentences(ball, sun):
    preferences = bpy.context.preferences.addons[ADDON].preferences
    for path, words in (("/nowhere/volcaustic", "no such program"), ("/bin/true", "is not volcaustic")):
        preferences.program = path
        said = refusal()
        assert words in said and "Traceback" not in said and len(said.strip().splitlines()) == 1, said
    preferences.program = ""
    ball.volcaustic.role = "IGNORE"
    assert "nothing bends light" in refusal()
    ball.volcaustic.role = "AUTO"
    sun.hide_render = True
    assert "no light" in refusal()
    sun.hide_render = False
    ball.volcaustic.own_index, ball.volcaustic.index = True, 0.1
    ball.volcaustic.absorption = (1e6, 1e6, 1e6)
    said = refusal(resolution=4096)  # more memory than there is
    assert "lower the resolution" in said and len(said.strip().splitlines()) == 1 and "Traceback" not in said, said
    ball.volcaustic.own_index = False
    ball.volcaustic.absorption = (0, 0, 0)


def test_a_bake_can_be_cancelled():
    from volcaustic_blender import job
    scene_file, _, _ = exported_scene()
    target = os.path.join(OUT, "cancelled.vdb")
    running = job.Bake([PROGRAM, "trace", scene_file, "-o", target, "--progress", "--set", "photons.grid=[8192,8192]",
                        "--set", "volume.resolution=256"])
    while running.running() and running.stage != "photons":
        time.sleep(0.02)
    assert running.running() and "photons" in running.text
    running.cancel()
    running.wait()
    assert running.cancelled and not running.failure and not job.RUNNING
    assert not [f for f in os.listdir(OUT) if f.startswith("cancelled")], "half a file is left"
    another = job.Bake([PROGRAM, "trace", scene_file, "-o", target, "--set", "photons.grid=[8192,8192]"])
    addon_utils.disable(ADDON)  # ends what runs
    assert not another.running() and not job.RUNNING
    addon_utils.enable(ADDON)
    addon_utils.disable(ADDON)
    assert not hasattr(bpy.types.Object, "volcaustic") and not hasattr(bpy.types, "VOLCAUSTIC_PT_world")


test_settings_live_in_the_file()
BALL, SUN = (bpy.context.scene.objects[name] for name in ("Ball / größte", "sun"))
test_a_frame()
test_cycles_shows_what_volcaustic_sees(BALL)
test_a_new_bake_is_seen(SUN)
test_an_animation(SUN)
test_faults_are_sentences(BALL, SUN)
test_lights_are_as_bright_as_in_cycles()
test_what_is_rendered_is_exported()
test_what_is_not_taken_is_said()
test_the_world_is_where_cycles_has_it()
test_a_bake_can_be_cancelled()
print("the add-on bakes in Blender", bpy.app.version_string)
