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
    """The names of what Cycles would render, instances aside."""
    names = set()

    def visit(layer):
        if not layer.exclude and not layer.collection.hide_render:
            names.update(o.name for o in layer.collection.objects if not o.hide_render)
            for child in layer.children:
                visit(child)

    visit(view_layer.layer_collection)
    return names


def rendered_things(view_layer, depsgraph):
    """Name, original object, evaluated object and world matrix of what is rendered: objects, then instances, whose names
    stay the same from frame to frame."""
    names = rendered_objects(view_layer)
    for obj in view_layer.objects:
        if obj.name in names and (obj.instance_type == "NONE" or obj.show_instancer_for_render):
            evaluated = obj.evaluated_get(depsgraph)
            yield obj.name, obj, evaluated, evaluated.matrix_world
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.parent.name not in names or instance.object.original.hide_render:
            continue
        places = [part for part in instance.persistent_id if part != NO_PLACE]
        if instance.object.original == instance.parent.original and len(places) < 2:
            continue  # the surface of a curve or text, which is its own mesh
        name = f"{instance.parent.name}/{instance.object.name}.{'.'.join(map(str, places))}"
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


def light_values(name, light, matrix):
    """A light of volcaustic. Sun: W/m2. Point and spot: a power of P watts is an intensity of P/(4 pi) W/sr, in the cone
    of a spot, too. Area: P/pi on its axis, before Blender 4.0 P/4."""
    color = np.array(light.color, float) * light.energy
    values = {"name": name}
    if light.type == "SUN":
        values.update(type="directional", irradiance=list(color), angle=math.degrees(light.angle))
    elif light.type in {"POINT", "SPOT"}:
        values.update(type=light.type.lower(), position=list(matrix.translation), intensity=list(color / (4 * math.pi)),
                      radius=light.shadow_soft_size)
    else:
        sides = [math.hypot(*(matrix[row][column] for row in range(3))) for column in (0, 1)]
        values.update(type="area", position=list(matrix.translation), intensity=list(color / (math.pi if bpy.app.version >= (4, 0, 0) else 4)),
                      width=light.size * sides[0], across=[matrix[row][0] for row in range(3)],
                      height=(light.size if light.shape in {"SQUARE", "DISK"} else light.size_y) * sides[1],
                      round=light.shape in {"DISK", "ELLIPSE"})
    if light.type == "SPOT":
        outer = light.spot_size / 2
        inner = math.acos(min(1.0, math.cos(outer) + (1 - math.cos(outer)) * light.spot_blend))
        values.update(outerAngle=min(math.degrees(outer), 90.0), innerAngle=math.degrees(inner))
    if light.type != "POINT":
        values["direction"] = [-matrix[row][2] for row in range(3)]
    return values


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
        raise Refused(f"{node.name}: the world's map has to be one picture in latitude and longitude")
    path = bpy.path.abspath(image.filepath, library=image.library)
    if image.packed_file:
        path = os.path.join(folder, "world_" + os.path.basename(path))
        with open(path, "wb") as file:
            file.write(image.packed_file.data)
    turn = 0.0
    if mapping and mapping.bl_idname == "ShaderNodeMapping":
        turn = mapping.inputs["Rotation"].default_value[2] * (1 if mapping.vector_type == "TEXTURE" else -1)
    return {"file": path, "turn": math.degrees(turn)}


def background_values(scene, folder):
    """`background` of the world's surface: a color or a map."""
    world = scene.world
    node = world and world.use_nodes and world.node_tree and world.node_tree.get_output_node("ALL")
    node = node and linked(node.inputs["Surface"])
    if not node or node.bl_idname != "ShaderNodeBackground":
        color = list(world.color) if world and not world.use_nodes else [0.0, 0.0, 0.0]
        return {"bottom": color, "top": color}
    strength, texture = node.inputs["Strength"].default_value, linked(node.inputs["Color"])
    if texture and texture.bl_idname == "ShaderNodeTexEnvironment":
        return {**map_values(texture, folder), "scale": [strength] * 3}
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
        self.warnings = []
        self.meshes = {}  # object name -> {frame: digest}
        self.tracks = {}  # JSON pointer -> {frame: value}
        self.json = None

    def gather(self, frame, depsgraph):
        first = self.json is None
        if first:
            self.json = self.frame_independent(depsgraph)
        lights = []
        bodies = []
        for name, obj, evaluated, matrix in rendered_things(self.view_layer, depsgraph):
            if obj in (self.settings.domain, self.settings.result):
                continue
            if obj.type in MESH_TYPES and materials.role_of(obj) != "IGNORE":
                bodies.append(name)
                self.add_mesh(name, obj, ply_bytes(evaluated, matrix), frame, first)
            elif obj.type == "LIGHT":
                lights.append({**light_values(name, evaluated.data, matrix), "samples": self.settings.light_samples})
                if first and evaluated.data.type == "AREA" and evaluated.data.spread < math.pi - 1e-3:
                    self.warnings.append(f"{name}: its spread is taken as 180 degrees")
        if first:
            self.warnings += [f"{name}: has no faces; left out" for name in bodies
                              if name not in self.meshes and not any(m.startswith(name + "/") for m in self.meshes)]
        if self.settings.world_light:
            lights.append({"name": "world", "type": "environment"})
        self.track_list("lights", lights, frame)
        camera = camera_values(self.scene, depsgraph)
        if camera:
            self.track("camera", camera, frame)

    def frame_independent(self, depsgraph):
        s = self.settings
        volume = {"resolution": s.resolution, "scattering": [s.fog_scattering] * 3,
                  "attenuation": [s.fog_scattering + s.fog_absorption] * 3}
        if s.domain:
            volume["bounds"] = domain_bounds(s.domain, depsgraph)
        rate = self.scene.render.fps / self.scene.render.fps_base
        return {"volcaustic": 1, "volume": volume, "materials": {}, "objects": [], "receivers": [], "lights": [],
                "photons": {"grid": [s.photons, s.photons]}, "background": background_values(self.scene, self.folder),
                "frames": {"first": 1, "last": 1, "rate": rate}}

    def add_mesh(self, name, obj, content, frame, first):
        if content is None:
            return
        if name not in self.meshes:
            if not first:
                raise Refused(f"{name}: appears in the midst of the animation; give it faces in every frame")
            if obj.hide_viewport or (obj.name in self.view_layer.objects and obj.hide_get(view_layer=self.view_layer)):
                self.warnings.append(f"{name}: is hidden in the viewport: its modifiers are not seen; show it")
            self.declare(name, obj)
        digests = self.meshes.setdefault(name, {})
        digests[frame] = hashlib.sha256(content).hexdigest()
        with open(os.path.join(self.folder, self.mesh_name(name, frame)), "wb") as file:
            file.write(content)

    def declare(self, name, obj):
        """A placeholder for the mesh's file, which is known when all frames are."""
        s = obj.volcaustic
        if materials.role_of(obj) == "RECEIVER":
            self.json["receivers"].append({"name": name, "mesh": name})
            return
        index = s.index if s.own_index else materials.index_of_object(obj)
        self.json["materials"][name] = {
            "index": s.index if index is None else index, "scattering": list(s.scattering),
            "attenuation": [a + b for a, b in zip(s.absorption, s.scattering)]}
        self.json["objects"].append({"name": name, "mesh": name, "material": name, "priority": s.priority})

    def track(self, place, values, frame):
        target = self.json.setdefault(place, {})
        for key, value in values.items():
            target.setdefault(key, value)
            self.tracks.setdefault(f"/{place}/{key}", {})[frame] = value

    def track_list(self, place, items, frame):
        stored = self.json[place]
        if stored and len(stored) != len(items):
            raise Refused("a light appears or vanishes in the midst of the animation; set its power to 0 instead")
        if not stored:
            stored.extend(dict(item) for item in items)
        for i, item in enumerate(items):
            for key, value in item.items():
                self.tracks.setdefault(f"/{place}/{i}/{key}", {})[frame] = value

    @staticmethod
    def mesh_name(name, frame=None):
        safe = re.sub(r"[^A-Za-z0-9_-]", "_", name) + "_" + hashlib.sha256(name.encode()).hexdigest()[:6]
        return f"{safe}.ply" if frame is None else f"{safe}.{frame:04d}.ply"

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
            return self.mesh_name(name).replace(".ply", ".####.ply")
        first, *others = (os.path.join(self.folder, self.mesh_name(name, frame)) for frame in sorted(digests))
        os.replace(first, os.path.join(self.folder, self.mesh_name(name)))
        for file in others:
            os.remove(file)
        return self.mesh_name(name)


def export(context, folder, frames):
    """Writes scene.json and its meshes for `frames` into `folder`. \\returns the path and warnings.
    \\throws Refused."""
    scene = context.scene
    os.makedirs(folder, exist_ok=True)
    exporter = Exporter(scene, context.view_layer, folder)
    current = scene.frame_current
    try:
        for frame in frames:
            if frame != scene.frame_current:
                scene.frame_set(frame)
            exporter.gather(frame, context.evaluated_depsgraph_get())
    finally:
        if scene.frame_current != current:
            scene.frame_set(current)
    return exporter.finish(frames), exporter.warnings
