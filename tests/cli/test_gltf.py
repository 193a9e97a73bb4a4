"""glTF files wherever a scene file is taken."""

import json
import os
import shutil
import struct
import subprocess
import unittest

from program import OCTAHEDRON_CORNERS, ProgramCase

FACES = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]
SMALL = ["--set", "volume.resolution=24", "--set", "voxelise.blur=3", "--set", "photons.grid=[64,64]",
         "--set", "camera.resolution=[32,24]"]


def octahedron_document(**changes):
    """A glass octahedron with a camera, a sun and a move from x = 0 to 1 in the first second; and the bytes of its buffer."""
    positions = b"".join(struct.pack("<3f", *corner) for corner in OCTAHEDRON_CORNERS)
    indices = struct.pack("<24H", *FACES)
    times, moves = struct.pack("<2f", 0, 1), struct.pack("<6f", 0, 0, 0, 1, 0, 0)
    views, data = [], b""
    for part in (positions, indices, times, moves):
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_ior", "KHR_lights_punctual"],
        "buffers": [{"byteLength": len(data)}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 24, "type": "SCALAR"},
                      {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR"},
                      {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "materials": [{"name": "glass", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                                                       "KHR_materials_ior": {"ior": 1.45}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 683}]}},
        "cameras": [{"type": "perspective", "name": "main", "perspective": {"yfov": 0.6, "znear": 0.1}}],
        "nodes": [{"mesh": 0, "name": "gem"}, {"camera": 0, "translation": [0, 0, 4]},
                  {"extensions": {"KHR_lights_punctual": {"light": 0}}, "rotation": [-0.6, 0, 0, 0.8]}],
        "animations": [{"samplers": [{"input": 2, "output": 3}],
                        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
    }
    document.update(changes)
    return document, data


def glb(document, data):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    return (struct.pack("<4s2I", b"glTF", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(data), b"BIN\0") + data)


class Gltf(ProgramCase):
    def write_glb(self, name="gem.glb", **changes):
        (self.folder / name).write_bytes(glb(*octahedron_document(**changes)))
        return self.path(name)

    def test_check_and_info(self):
        path = self.write_glb()
        self.assertIn("1 objects, 1 materials, 1 lights", self.succeed("scene", "check", path).stderr)
        text = self.succeed("info", path).stdout
        for part in ("gem", "1.45", "directional", "gem.glb#/meshes/0"):
            self.assertIn(part, text)

    def test_the_canonical_scene_is_a_scene_file_of_the_same_hash(self):
        info = self.report("info", self.write_glb())["files"][0]
        scene = self.write("gem.json", info["scene"])
        self.assertEqual(self.report("scene", "check", scene, "--quiet")["sceneHashes"], [info["sceneHash"]])
        self.succeed("mesh2vdb", scene, "-o", self.path("gem.vdb"), "--set", "volume.resolution=16")

    def test_traces_and_renders(self):
        path = self.write_glb()
        self.assertEqual(self.succeed("trace", path, "-o", self.path("gem.vdb"), *SMALL, "--quiet").stderr, "")
        report = self.report("render", path, "-o", self.path("gem.exr"), "--camera", "main", *SMALL)
        self.assertGreater(report["counts"]["photonsTraced"], 0)
        self.assertEqual(self.files(), ["gem.exr", "gem.glb", "gem.vdb"])

    def test_frames_are_at_frame_over_fps(self):
        path = self.write_glb()
        self.succeed("mesh2vdb", path, "-o", self.path("gem.####.vdb"), "--frames", "0-10x5", "--fps", "10",
                     "--set", "volume.resolution=16")
        self.assertEqual(self.files(), ["gem.0000.vdb", "gem.0005.vdb", "gem.0010.vdb", "gem.glb"])
        volumes = self.report("info", *[self.path(f"gem.{n:04}.vdb") for n in (0, 5, 10)])["files"]
        corners = [volume["metadata"]["volcaustic_min_corner"] for volume in volumes]
        first = float(str(corners[0]).strip("[]").split(",")[0])
        for corner, moved in zip(corners, (0, 0.5, 1)):
            self.assertAlmostEqual(float(str(corner).strip("[]").split(",")[0]) - first, moved, 6)

    def test_what_is_not_read_is_said_once(self):
        metal = {"pbrMetallicRoughness": {"metallicFactor": 1, "baseColorFactor": [1, 1, 1, 1]}}
        glass = {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}
        path = self.write_glb(nodes=[{"mesh": 0}, {"mesh": 1}, {"mesh": 1}], materials=[glass, metal],
                              meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
                                      {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 1}]}],
                              animations=[])
        done = self.succeed("render", path, "-o", self.path("gem.####.exr"), "--frames", "1-2", *SMALL)
        self.assertEqual(done.stderr.count("as if it were matte"), 1, done.stderr)
        self.assertEqual(done.stderr.count("holds no light"), 1, done.stderr)

    def test_an_external_buffer(self):
        document, data = octahedron_document()
        document["buffers"][0]["uri"] = "gem.bin"
        path = self.write("gem.gltf", document)
        self.assertTrue(self.fail_with(3, "scene", "check", path).startswith(path + ":/buffers/0/uri: "))
        (self.folder / "gem.bin").write_bytes(data[:-1])
        self.assertTrue(self.fail_with(3, "scene", "check", path).startswith(path + ":/buffers/0: "))
        (self.folder / "gem.bin").write_bytes(data)
        self.succeed("scene", "check", path)

    def test_bad_files_end_in_one_line_and_status_3(self):
        document, data = octahedron_document()
        whole = glb(document, data)
        for name, content in {"empty": b"", "header": whole[:10], "half": whole[:len(whole) // 2], "version": whole[:4] + b"\1" + whole[5:],
                              "json": whole.replace(b'"asset"', b'"asset,', 1)}.items():
            with self.subTest(name=name):
                (self.folder / f"{name}.glb").write_bytes(content)
                path = self.path(f"{name}.glb")
                self.assertTrue(self.fail_with(3, "render", path, "-o", self.path("x.exr")).startswith(path + ":"))
        bad = self.write_glb(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 9, "material": 0}]}])
        self.assertTrue(self.fail_with(3, "trace", bad, "-o", self.path("x.vdb")).startswith(
            bad + ":/meshes/0/primitives/0/indices: "))
        self.assertNotIn("x.vdb", self.files())

    def test_wrong_options_are_usage_errors(self):
        path = self.write_glb()
        self.assertIn('"main"', self.fail_with(2, "render", path, "-o", self.path("x.exr"), "--camera", "man"))
        scene = self.write_small_scene()
        self.fail_with(2, "render", scene, "-o", self.path("x.exr"), "--camera", "main")
        self.fail_with(2, "trace", scene, "-o", self.path("x.vdb"), "--fps", "30")
        self.fail_with(2, "scene", "check", path, "--set", "volume.resolutoin=3")

    @unittest.skipUnless(shutil.which("blender"), "blender is not installed")
    def test_what_blender_exports(self):
        script = """
import bpy, math
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(1, 2, 3))
bpy.context.object.name = "Ball"
material = bpy.data.materials.new("glass")
material.use_nodes = True
inputs = material.node_tree.nodes["Principled BSDF"].inputs
inputs["Transmission"].default_value, inputs["IOR"].default_value, inputs["Roughness"].default_value = 1, 1.4, 0
bpy.context.object.data.materials.append(material)
bpy.ops.object.light_add(type="SUN")
bpy.context.object.data.energy = 3
bpy.ops.object.light_add(type="POINT")
bpy.context.object.data.energy = 100
bpy.ops.export_scene.gltf(filepath=OUT, export_format="GLB", export_lights=True)
"""
        out = self.path("ball.glb")
        # A Python of the caller's on the path would be taken for Blender's own.
        done = subprocess.run([shutil.which("blender"), "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                               self.write("export.py", script.replace("OUT", repr(out)))],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=200,
                              env={**os.environ, "PATH": os.defpath})
        self.assertEqual(done.returncode, 0, done.stdout)
        scene = self.report("info", out)["files"][0]["scene"]
        ball, sun, point = scene["objects"][0], scene["lights"][0], scene["lights"][1]
        self.assertEqual([round(x, 5) for x in ball["translate"]], [1, 3, -2], "y is up")
        self.assertAlmostEqual(scene["materials"]["glass"]["index"], 1.4, 6)
        self.assertEqual([round(x, 5) for x in sun["irradiance"]], [3, 3, 3])
        self.assertEqual([round(x, 5) for x in sun["direction"]], [0, -1, 0])
        self.assertAlmostEqual(point["intensity"][0] * 4 * 3.14159265, 100, 4)


if __name__ == "__main__":
    unittest.main()
