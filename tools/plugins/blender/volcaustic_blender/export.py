"""A Blender scene as a scene file of volcaustic: meshes in world space as .ply, everything else in JSON. Blender's units of
length are the world's; energies are converted as Cycles understands them."""

import hashlib
import json
import math
import os
import re

import bpy
import numpy as np

from . import materials

NO_PLACE = 2**31 - 1  # ends the place of an instance in Blender's lists
MESH_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


class Refused(Exception):
    """What a person is told."""


def rendered_objects(view_layer):
    """The names (name_full, which tells linked objects apart) of what Cycles would render, instances aside."""
    names = set()

    def visit(layer):
        if not layer.exclude and not layer.collection.hide_render:
            names.update(o.name_full for o in layer.collection.objects if not o.hide_render)
            for child in layer.children:
                visit(child)

    visit(view_layer.layer_collection)
    return names


def rendered_things(view_layer, depsgraph):
    """Name, original object, evaluated object and world matrix of what is rendered: objects, then instances, whose names
    stay the same from frame to frame."""
    names = rendered_objects(view_layer)
    for obj in view_layer.objects:
        original_of_instances = obj.parent and obj.parent.instance_type in {"VERTS", "FACES"}
        if (obj.name_full in names and not original_of_instances
                and (obj.instance_type == "NONE" or obj.show_instancer_for_render)):
            evaluated = obj.evaluated_get(depsgraph)
            yield obj.name_full, obj, evaluated, evaluated.matrix_world
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.parent.original.name_full not in names or instance.object.original.hide_render:
            continue
        places = [part for part in instance.persistent_id if part != NO_PLACE]
        if instance.object.original == instance.parent.original and len(places) < 2:
            continue  # the surface of a curve or text, which is its own mesh
        name = f"{instance.parent.original.name_full}/{instance.object.name}.{'.'.join(map(str, places))}"
        yield name, instance.object.original, instance.object, instance.matrix_world


def ply_bytes(evaluated, matrix_world):
    """Triangles of an evaluated object in world space, facing outwards also where it is mirrored; None where it has none."""
    mesh = evaluated.to_mesh()
    if mesh is None:
        return None
    try:
        mesh.calc_loop_triangles()
        positions = np.empty(len(mesh.vertices) * 3, np.float32)
        triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
        mesh.vertices.foreach_get("co", positions)
        mesh.loop_triangles.foreach_get("vertices", triangles)
    finally:
        evaluated.to_mesh_clear()
    if not len(triangles):
        return None
    matrix = np.array(matrix_world, float)
    world = positions.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    corners = triangles.reshape(-1, 3)
    if np.linalg.det(matrix[:3, :3]) < 0:
        corners = corners[:, ::-1]
    faces = np.empty(len(corners), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, corners
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(world)}\n"
              "property double x\nproperty double y\nproperty double z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    return header.encode() + world.astype("<f8").tobytes() + faces.tobytes()


def light_color(name, light):
    """Its color times its power. \\throws Refused."""
    if light.energy < 0:
        raise Refused(f"{name}: its power is negative; there is no such light")
    color = np.array(light.color, float) * light.energy * 2 ** getattr(light, "exposure", 0)
    if getattr(light, "use_temperature", False):  # since Blender 4.5
        color *= np.array(light.temperature_color, float)
    return color


def light_values(name, light, matrix):
    """A light of volcaustic. Sun: W/m2. Point and spot: a power of P watts is an intensity of P/(4 pi) W/sr, in the cone
    of a spot, too. Area: P/pi on its axis, before Blender 4.0 P/4. \\throws Refused."""
    color = light_color(name, light)
    values = {"name": name}
    if light.type == "SUN":
        values.update(type="directional", irradiance=list(color), angle=min(math.degrees(light.angle), 90.0))
    elif light.type in {"POINT", "SPOT"}:
        values.update(type=light.type.lower(), position=list(matrix.translation), intensity=list(color / (4 * math.pi)),
                      radius=light.shadow_soft_size)
    else:
        sides = [math.hypot(*(matrix[row][column] for row in range(3))) for column in (0, 1)]
        values.update(type="area", position=list(matrix.translation),
                      intensity=list(color / (math.pi if bpy.app.version >= (4, 0, 0) else 4)),
                      width=light.size * sides[0], across=[matrix[row][0] for row in range(3)],
                      height=(light.size if light.shape in {"SQUARE", "DISK"} else light.size_y) * sides[1],
                      round=light.shape in {"DISK", "ELLIPSE"})
    if light.type == "SPOT":
        outer = min(light.spot_size / 2, math.pi / 2)
        inner = math.acos(min(1.0, math.cos(outer) + (1 - math.cos(outer)) * light.spot_blend))
        values["outerAngle"] = min(math.degrees(outer), 90.0)
        values["innerAngle"] = min(math.degrees(inner), values["outerAngle"])
    if light.type != "POINT":
        values["direction"] = [-matrix[row][2] for row in range(3)]
    return values


def left_out_of_light(light):
    """What volcaustic does not take of a light, in words."""
    if light.use_nodes and light.node_tree:
        yield "its nodes are not seen: its color and power are"
    if light.type == "AREA" and light.spread < math.pi - 1e-3:
        yield "its spread is taken as 180 degrees"
    if light.type == "SUN" and light.angle > math.pi / 2 + 1e-3:
        yield "its angle is taken as 90 degrees"
    if not getattr(light, "normalize", True):  # since Blender 4.5
        yield "its power is taken as if Normalize were on"


def left_out_of_object(obj, view_layer):
    """What of an object, or of the instances it makes, is another in renders than in the viewport, which is exported."""
    if obj.hide_viewport or (obj.name in view_layer.objects and obj.hide_get(view_layer=view_layer)):
        yield "is hidden in the viewport: its modifiers, instances and motion are not seen; show it"
    for modifier in obj.modifiers:
        other = modifier.show_viewport != modifier.show_render
        if other or getattr(modifier, "levels", 0) != getattr(modifier, "render_levels", getattr(modifier, "levels", 0)):
            yield f"its modifier {modifier.name} is taken as in the viewport, which is not as in renders"


def camera_values(scene, depsgraph):
    camera, render = scene.camera, scene.render
    width = max(1, round(render.resolution_x * render.resolution_percentage / 100))
    height = max(1, round(render.resolution_y * render.resolution_percentage / 100))
    if not camera or camera.data.type != "PERSP":
        return None
    matrix = camera.matrix_world
    projection = camera.calc_matrix_camera(depsgraph, x=width, y=height)
    position = np.array(matrix.translation, float)
    return {"position": list(position), "target": list(position - np.array([matrix[r][2] for r in range(3)])),
            "up": [matrix[r][1] for r in range(3)], "fieldOfView": math.degrees(2 * math.atan(1 / projection[1][1])),
            "resolution": [width, height]}


def linked(socket):
    """The node that gives a socket its value; None for one that has its own."""
    return socket.links[0].from_node if socket.is_linked else None


def map_values(node, folder):
    """`background` of an environment texture. Cycles' maps have the conventions of volcaustic's. \\throws Refused."""
    image, mapping = node.image, linked(node.inputs["Vector"])
    if not image or node.projection != "EQUIRECTANGULAR" or image.source != "FILE":
        raise Refused("the world's map is not one picture in latitude and longitude")
    path = bpy.path.abspath(image.filepath, library=image.library)
    if image.packed_file:
        path = os.path.join(folder, "world_" + os.path.basename(path))
        with open(path, "wb") as file:
            file.write(image.packed_file.data)
    elif not os.path.exists(path):
        raise Refused(f"the world's map is not there: {path}")
    turn = 0.0
    if mapping and mapping.bl_idname == "ShaderNodeMapping":
        rotation, scale = mapping.inputs["Rotation"].default_value, mapping.inputs["Scale"].default_value
        if abs(rotation[0]) + abs(rotation[1]) > 1e-6 or any(abs(part - 1) > 1e-6 for part in scale):
            raise Refused("the world's map is turned otherwise than about z, or scaled")
        turn = rotation[2] * (1 if mapping.vector_type == "TEXTURE" else -1)
    elif mapping and mapping.bl_idname != "ShaderNodeTexCoord":
        raise Refused("the world's map is placed by other nodes than Mapping")
    return {"file": path, "turn": math.degrees(turn)}


def background_values(scene, folder):
    """`background` of the world's surface: a color or a map. \\throws Refused."""
    world = scene.world
    node = world and world.use_nodes and world.node_tree and world.node_tree.get_output_node("ALL")
    node = node and linked(node.inputs["Surface"])
    if not node:
        color = list(world.color) if world and not world.use_nodes else [0.0, 0.0, 0.0]
        return {"bottom": color, "top": color}
    if node.bl_idname != "ShaderNodeBackground" or node.inputs["Strength"].is_linked:
        raise Refused("the world is made of other nodes than one Background")
    strength, texture = node.inputs["Strength"].default_value, linked(node.inputs["Color"])
    if texture and texture.bl_idname == "ShaderNodeTexEnvironment":
        return {**map_values(texture, folder), "scale": [strength] * 3}
    if texture:
        raise Refused("the world's color is neither one color nor a map")
    color = [c * strength for c in node.inputs["Color"].default_value[:3]]
    return {"bottom": color, "top": color}


def domain_bounds(obj, depsgraph):
    evaluated = obj.evaluated_get(depsgraph)
    corners = np.array([evaluated.matrix_world @ type(evaluated.location)(corner) for corner in evaluated.bound_box], float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    if not np.all(high > low):
        raise Refused(f"{obj.name}: the domain is flat; choose a box")
    return {"min": list(low), "max": list(high)}


class Exporter:
    """Gathers a scene frame by frame, then writes it."""

    def __init__(self, scene, view_layer, folder):
        self.scene, self.view_layer, self.folder = scene, view_layer, folder
        self.settings = scene.volcaustic
        self.domain = self.settings.domain
        if self.domain and self.domain.name_full not in {o.name_full for o in scene.objects}:
            self.domain = None  # deleted, which a pointer to it does not notice
        self.warnings = []
        self.meshes = {}  # object name -> {frame: digest}
        self.tracks = {}  # JSON pointer -> {frame: value}
        self.json = None

    def warn(self, name, sentences):
        for sentence in sentences:
            line = f"{name}: {sentence}" if name else sentence
            if line not in self.warnings:
                self.warnings.append(line)

    def gather(self, frame, depsgraph):
        first = self.json is None
        if first:
            self.json = self.frame_independent(depsgraph)
        elif self.domain and domain_bounds(self.domain, depsgraph) != self.json["volume"]["bounds"]:
            self.warn(self.domain.name, ["moves; the domain is where it is in the first frame"])
        lights, empty = [], []
        for name, obj, evaluated, matrix in rendered_things(self.view_layer, depsgraph):
            if obj in (self.domain, self.settings.result):
                continue
            if obj.type in MESH_TYPES and materials.role_of(obj) != "IGNORE":
                if not self.add_mesh(name, obj, ply_bytes(evaluated, matrix), frame, first):
                    empty.append(name)
            elif obj.type == "LIGHT":
                lights.append({**light_values(name, evaluated.data, matrix), "samples": self.settings.light_samples})
                self.warn(name, left_out_of_light(evaluated.data))
            elif not obj.is_instancer:
                continue
            self.warn(name, left_out_of_object(obj, self.view_layer))
        if first:
            self.warn("", [f"{name}: has no faces; left out" for name in empty
                           if not any(mesh.startswith(name + "/") for mesh in self.meshes)])
        if self.settings.world_light:
            lights.append({"name": "world", "type": "environment"})
        self.track_lights(lights, frame, first)
        camera = camera_values(self.scene, depsgraph)
        if camera:
            self.track("camera", camera, frame)

    def frame_independent(self, depsgraph):
        s = self.settings
        volume = {"resolution": s.resolution, "scattering": [s.fog_scattering] * 3,
                  "attenuation": [s.fog_scattering + s.fog_absorption] * 3}
        if s.fog_scattering == 0:
            self.warn("", ["the fog scatters nothing (Fog is 0): the volume will be dark"])
        if self.domain:
            volume["bounds"] = domain_bounds(self.domain, depsgraph)
        try:
            background = background_values(self.scene, self.folder)
        except Refused as refused:
            if s.world_light:
                raise Refused(f"{refused}; turn World Light off, or change the world") from None
            self.warn("", [f"{refused}; the background of scene.json is black"])
            background = {"bottom": [0.0, 0.0, 0.0], "top": [0.0, 0.0, 0.0]}
        rate = self.scene.render.fps / self.scene.render.fps_base
        return {"volcaustic": 1, "volume": volume, "materials": {}, "objects": [], "receivers": [], "lights": [],
                "photons": {"grid": [s.photons, s.photons]}, "background": background,
                "frames": {"first": 1, "last": 1, "rate": rate}}

    def add_mesh(self, name, obj, content, frame, first):
        """\\returns whether it has faces. \\throws Refused."""
        if content is None:
            return False
        if name not in self.meshes:
            if not first:
                raise Refused(f"{name}: appears in the midst of the animation; give it faces in every frame")
            self.declare(name, obj)
        if materials.role_of(obj) == "BODY":
            pointer = name.replace("~", "~0").replace("/", "~1")
            self.tracks.setdefault(f"/materials/{pointer}/index", {})[frame] = self.index_of(obj)
        digests = self.meshes.setdefault(name, {})
        digests[frame] = hashlib.sha256(content).hexdigest()
        with open(os.path.join(self.folder, self.mesh_name(name, frame)), "wb") as file:
            file.write(content)
        return True

    @staticmethod
    def index_of(obj):
        s = obj.volcaustic
        index = s.index if s.own_index else materials.index_of_object(obj)
        return s.index if index is None else index

    def declare(self, name, obj):
        """A placeholder for the mesh's file, which is known when all frames are."""
        s = obj.volcaustic
        if materials.role_of(obj) == "RECEIVER":
            self.json["receivers"].append({"name": self.file_name(name), "mesh": name})
            return
        self.json["materials"][name] = {
            "index": self.index_of(obj), "scattering": list(s.scattering),
            "attenuation": [a + b for a, b in zip(s.absorption, s.scattering)]}
        self.json["objects"].append({"name": name, "mesh": name, "material": name, "priority": s.priority})

    def track(self, place, values, frame):
        target = self.json.setdefault(place, {})
        for key, value in values.items():
            target.setdefault(key, value)
            self.tracks.setdefault(f"/{place}/{key}", {})[frame] = value

    def track_lights(self, lights, frame, first):
        if first:
            self.json["lights"] = lights
        if [light["name"] for light in lights] != [light["name"] for light in self.json["lights"]]:
            raise Refused("a light appears or vanishes in the midst of the animation; set its power to 0 instead")
        for i, light in enumerate(lights):
            for key, value in light.items():
                self.tracks.setdefault(f"/lights/{i}/{key}", {})[frame] = value

    @staticmethod
    def file_name(name):
        return re.sub(r"[^A-Za-z0-9_-]", "_", name) + "_" + hashlib.sha256(name.encode()).hexdigest()[:6]

    def mesh_name(self, name, frame=None):
        return self.file_name(name) + (".ply" if frame is None else f".{frame:04d}.ply")

    def finish(self, frames):
        """Writes the scene. \\returns its path."""
        if not self.json["objects"]:
            raise Refused("nothing bends light: give an object a glass material, or make it a Body in its properties")
        if not self.json["lights"]:
            raise Refused("there is no light that can be traced; add a lamp, or turn World Light on")
        for entry in self.json["objects"] + self.json["receivers"]:
            if len(self.meshes[entry["mesh"]]) < len(frames):
                raise Refused(f"{entry['mesh']}: vanishes in the midst of the animation; give it faces in every frame")
            entry["mesh"] = self.settle_mesh(entry["mesh"])
        animated = {place: [[f, keys[f]] for f in sorted(keys)] for place, keys in self.tracks.items()
                    if len({json.dumps(v) for v in keys.values()}) > 1}
        for place in animated:
            if isinstance(animated[place][0][1], str):
                raise Refused(f"{place}: changes in the midst of the animation, which cannot be")
        if animated:
            self.json["animation"] = animated
        self.json["frames"].update(first=frames[0], last=frames[-1])
        path = os.path.join(self.folder, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(self.json, file, indent=1)
        return path

    def settle_mesh(self, name):
        """One file for what does not change, else the sequence."""
        digests = self.meshes[name]
        if len(set(digests.values())) > 1:
            return self.file_name(name) + ".####.ply"
        first, *others = (os.path.join(self.folder, self.mesh_name(name, frame)) for frame in sorted(digests))
        os.replace(first, os.path.join(self.folder, self.mesh_name(name)))
        for file in others:
            os.remove(file)
        return self.mesh_name(name)


def export(context, folder, frames):
    """Writes scene.json and its meshes for `frames` into `folder`: a generator that goes on to the next frame and yields
    what it does, in words. \\returns the path, and warnings. \\throws Refused."""
    scene, view_layer = context.scene, context.view_layer
    os.makedirs(folder, exist_ok=True)
    exporter = Exporter(scene, view_layer, folder)
    current, subframe = scene.frame_current, scene.frame_subframe
    try:
        for number, frame in enumerate(frames, 1):
            if len(frames) > 1:  # a frame by itself is as it is on the screen
                scene.frame_set(frame)
            view_layer.update()
            exporter.gather(frame, view_layer.depsgraph)
            yield f"reading frame {number} of {len(frames)}"
    finally:
        if len(frames) > 1:
            scene.frame_set(current, subframe=subframe)
    return exporter.finish(frames), exporter.warnings
