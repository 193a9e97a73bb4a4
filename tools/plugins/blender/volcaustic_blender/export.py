"""A Blender scene as a scene file of volcaustic: meshes in world space as .ply, everything else in JSON. Blender's units of
length are the world's; energies are converted as Cycles understands them."""

import hashlib
import json
import math
import os
import re

import numpy as np

from . import materials

MESH_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


class Refused(Exception):
    """What a person is told."""


def ply_bytes(obj, depsgraph):
    """Triangles of an evaluated object in world space, facing outwards also where it is mirrored; None where it has none."""
    evaluated = obj.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
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
    matrix = np.array(evaluated.matrix_world)
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


def light_values(obj):
    """A light of volcaustic, or None for a type that it does not have. Sun: W/m2. Point and spot: a power of P watts is an
    intensity of P/(4 pi) W/sr, in the cone of a spot, too."""
    light, matrix = obj.data, obj.matrix_world
    color = np.array(light.color, float) * light.energy
    values = {"name": obj.name}
    if light.type == "SUN":
        values.update(type="directional", irradiance=list(color), angle=math.degrees(light.angle))
    elif light.type in {"POINT", "SPOT"}:
        values.update(type=light.type.lower(), position=list(matrix.translation), intensity=list(color / (4 * math.pi)),
                      radius=light.shadow_soft_size)
    else:
        return None
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
    position = np.array(matrix.translation)
    return {"position": list(position), "target": list(position - np.array([matrix[r][2] for r in range(3)])),
            "up": [matrix[r][1] for r in range(3)], "fieldOfView": math.degrees(2 * math.atan(1 / projection[1][1])),
            "resolution": [width, height]}


def background_color(scene):
    world = scene.world
    if world and world.use_nodes and world.node_tree:
        for node in world.node_tree.nodes:
            if node.bl_idname == "ShaderNodeBackground":
                return [c * node.inputs["Strength"].default_value for c in node.inputs["Color"].default_value[:3]]
    return list(world.color) if world else [0.0, 0.0, 0.0]


def domain_bounds(obj, depsgraph):
    evaluated = obj.evaluated_get(depsgraph)
    corners = np.array([evaluated.matrix_world @ type(evaluated.location)(corner) for corner in evaluated.bound_box])
    low, high = corners.min(axis=0), corners.max(axis=0)
    if not np.all(high > low):
        raise Refused(f"{obj.name}: the domain is flat; choose a box")
    return {"min": list(low), "max": list(high)}


class Exporter:
    """Gathers a scene frame by frame, then writes it."""

    def __init__(self, scene, folder):
        self.scene, self.folder = scene, folder
        self.settings = scene.volcaustic
        self.warnings = []
        self.meshes = {}  # object name -> {frame: digest}
        self.tracks = {}  # JSON pointer -> {frame: value}
        self.json = None

    def gather(self, frame, depsgraph):
        objects = [o for o in self.scene.objects if not o.hide_render and o != self.settings.domain
                   and o != self.settings.result]
        first = self.json is None
        if first:
            self.json = self.frame_independent(depsgraph)
        bodies = [o for o in objects if o.type in MESH_TYPES and materials.role_of(o) != "IGNORE"]
        for obj in bodies:
            self.add_mesh(obj, frame, depsgraph, first)
        lights = [(o, light_values(o)) for o in objects if o.type == "LIGHT"]
        for obj, values in lights:
            if first and values is None:
                self.warnings.append(f"{obj.name}: {obj.data.type.lower()} lights are left out; use a sun, point or spot")
        self.track_list("lights", [values for _, values in lights if values], frame)
        camera = camera_values(self.scene, depsgraph)
        if camera:
            self.track("camera", camera, frame)

    def frame_independent(self, depsgraph):
        s = self.settings
        volume = {"resolution": s.resolution, "scattering": [s.fog_scattering] * 3,
                  "attenuation": [s.fog_scattering + s.fog_absorption] * 3}
        if s.domain:
            volume["bounds"] = domain_bounds(s.domain, depsgraph)
        color = background_color(self.scene)
        rate = self.scene.render.fps / self.scene.render.fps_base
        return {"volcaustic": 1, "volume": volume, "materials": {}, "objects": [], "receivers": [], "lights": [],
                "photons": {"grid": [s.photons, s.photons]}, "background": {"bottom": color, "top": color},
                "frames": {"first": 1, "last": 1, "rate": rate}}

    def add_mesh(self, obj, frame, depsgraph, first):
        content = ply_bytes(obj, depsgraph)
        if content is None:
            if first:
                self.warnings.append(f"{obj.name}: has no faces; left out")
            return
        if obj.name not in self.meshes:
            if not first:
                raise Refused(f"{obj.name}: appears in the midst of the animation; give it faces in every frame")
            self.declare(obj)
        digests = self.meshes.setdefault(obj.name, {})
        digests[frame] = hashlib.sha256(content).hexdigest()
        with open(os.path.join(self.folder, self.mesh_name(obj.name, frame)), "wb") as file:
            file.write(content)

    def declare(self, obj):
        """A placeholder for the mesh's file, which is known when all frames are."""
        name, s = obj.name, obj.volcaustic
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
            raise Refused("there is no light that can be traced; add a sun, point or spot")
        for entry in self.json["objects"] + self.json["receivers"]:
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
    exporter = Exporter(scene, folder)
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
