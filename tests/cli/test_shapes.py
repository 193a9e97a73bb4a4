"""Functional objects: shape files, shape2mesh, and shapes in scenes."""

import importlib.util
import json
import math
import re
import unittest

from program import DATA, SMALL_SCENE, ProgramCase
from shape_tables import tables

BALL = {"volcaustic": 1, "shape": {"type": "sphere", "radius": 0.5}}
# A still block, and a ball that moves on its far side.
MOVING = {
    "volcaustic": 1,
    "shape": {"type": "union", "parts": [
        {"type": "cuboid", "size": [1, 1, 1], "name": "block"},
        {"type": "sphere", "radius": 0.25, "translate": [2, 0, 0], "name": "ball"}]},
    "animation": {"/shape/parts/1/translate": [[1, [2, 0, 0]], [5, [2.2, 0, 0]]]},
}


def without_comments(text):
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*|/\*.*?\*/', lambda m: m.group(1) or " ", text, flags=re.S)


class ShapeToMesh(ProgramCase):
    def mesh(self, path):
        return self.report("info", path)["files"][0]

    def test_a_ball_is_closed_and_as_large_as_it_is(self):
        shape = self.write("ball.json", BALL)
        for extension in ("obj", "ply", "stl", "off"):
            out = self.path("ball." + extension)
            counts = self.report("shape2mesh", shape, "-o", out, "--resolution", 32)["counts"][0]
            mesh = self.mesh(out)
            self.assertTrue(mesh["closed"], extension)
            self.assertEqual(mesh["triangles"], counts["triangles"])
            self.assertAlmostEqual(mesh["signedVolume"], math.pi / 6, delta=0.01)
            self.assertLess(counts["deviation"], 0.01)
            self.assertAlmostEqual(counts["cellSize"], 1 / 32, delta=0.01)

    def test_finer_by_any_of_the_options(self):
        shape = self.write("ball.json", BALL)

        def counts(*flags):
            return self.report("shape2mesh", shape, "-o", self.path("ball.ply"), *flags)["counts"][0]

        coarse = counts("--resolution", 16)
        self.assertGreater(counts("--cell-size", 0.02)["triangles"], coarse["triangles"])
        self.assertLessEqual(counts("--resolution", 16, "--tolerance", 1e-3)["deviation"], 1e-3)
        few = counts("--triangles", 1000)["triangles"]
        self.assertLessEqual(few, 1000)
        self.assertGreater(few, 400)

    def test_values_can_be_set(self):
        shape = self.write("ball.json", BALL)
        self.succeed("shape2mesh", shape, "-o", self.path("ball.ply"), "--resolution", 16, "--set", "shape.radius=1")
        self.assertAlmostEqual(self.mesh(self.path("ball.ply"))["signedVolume"], 4 / 3 * math.pi, delta=0.2)
        self.assertIn("shape.radius", self.fail_with(2, "shape2mesh", shape, "-o", self.path("ball.ply"), "--set",
                                                     "shape.raduis=1"))

    def test_frames_take_over_what_does_not_move(self):
        shape = self.write("moving.json", MOVING)
        report = self.report("shape2mesh", shape, "-o", self.path("moving.ply"), "--frames", "1-5x2",
                             "--cell-size", 0.05)
        self.assertEqual([c["output"] for c in report["counts"]],
                         [self.path(f"moving.000{frame}.ply") for frame in (1, 3, 5)])
        self.assertEqual(report["counts"][0]["reusedBlocks"], 0)
        for counts in report["counts"][1:]:
            self.assertGreater(counts["reusedBlocks"], 0.3 * counts["blocks"])
            self.assertLess(counts["reusedBlocks"], counts["blocks"])
        alone = self.path("alone.ply")
        self.succeed("shape2mesh", shape, "-o", alone, "--cell-size", 0.05, "--set", "animation={}", "--set",
                     "shape.parts.1.translate=[2.2,0,0]")
        self.assertEqual((self.folder / "alone.ply").read_bytes(), (self.folder / "moving.0005.ply").read_bytes(),
                         "the same triangles whatever came before")

    def test_parts_are_groups(self):
        out = self.path("moving.obj")
        counts = self.report("shape2mesh", self.write("moving.json", MOVING), "-o", out, "--resolution", 48)["counts"][0]
        self.assertLessEqual({"block", "ball"}, set(counts["groups"]))
        groups = {g["name"]: g for g in self.mesh(out)["groups"]}
        self.assertAlmostEqual(groups["block"]["signedVolume"], 1, delta=0.02)
        self.assertTrue(groups["ball"]["closed"])

    def test_what_is_wrong_is_one_line(self):
        ball = self.write("ball.json", BALL)
        plane = self.write("plane.json", {"volcaustic": 1, "shape": {"type": "plane"}})
        self.assertTrue(self.fail_with(3, "shape2mesh", plane, "-o", self.path("plane.ply")).startswith(plane + ": "))
        bad = self.write("bad.json", {"volcaustic": 1, "shape": {"type": "spere"}})
        line = self.fail_with(3, "shape2mesh", bad, "-o", self.path("bad.ply"))
        self.assertTrue(line.startswith(bad + ":/shape/type: "), line)
        self.assertIn('"sphere"', line)
        self.fail_with(2, "shape2mesh", ball, "-o", self.path("ball.vdb"))
        self.fail_with(2, "shape2mesh", ball, "-o", self.path("ball.####.ply"))
        self.fail_with(2, "shape2mesh", ball, "-o", self.path("ball.ply"), "--frames", "x")
        self.fail_with(3, "shape2mesh", self.path("none.json"), "-o", self.path("none.ply"))
        self.fail_with(3, "shape2mesh", ball, "-o", self.path("ball.ply"), "--cell-size", 1e-6)


class Info(ProgramCase):
    def test_says_what_a_shape_is(self):
        entry = self.report("info", self.write("moving.json", MOVING))["files"][0]
        self.assertEqual(entry["kind"], "shape")
        self.assertEqual(entry["types"], {"sphere": 1, "cuboid": 1, "union": 1})
        self.assertLessEqual({"block", "ball"}, set(entry["parts"]))
        self.assertAlmostEqual(entry["volume"], 1 + math.pi / 48, delta=0.05)
        for corner, wanted in (("min", [-0.5, -0.5, -0.5]), ("max", [2.25, 0.5, 0.5])):
            for value, expected in zip(entry["bounds"][corner], wanted):
                self.assertAlmostEqual(value, expected, delta=0.02)
        text = self.succeed("info", self.path("moving.json")).stdout
        self.assertIn("1 cuboid", text)

    def test_a_shape_without_end(self):
        entry = self.report("info", self.write("plane.json", {"volcaustic": 1, "shape": {"type": "plane"}}))["files"][0]
        self.assertIsNone(entry["bounds"])


class Volumes(ProgramCase):
    def test_mesh2vdb_takes_a_shape(self):
        shape = self.write("ball.json", {**BALL, "animation": {"/shape/radius": [[1, 0.5], [2, 0.25]]}})
        report = self.report("mesh2vdb", shape, "-o", self.path("ball.vdb"), "--resolution", 32)
        self.assertAlmostEqual(report["counts"][0]["coveredVolume"], math.pi / 6, delta=0.005)
        frames = self.report("mesh2vdb", shape, "-o", self.path("b.vdb"), "--resolution", 32, "--frames", "1-2")["counts"]
        self.assertEqual(frames[0]["dims"], frames[1]["dims"], "one lattice around all frames")
        self.assertAlmostEqual(frames[1]["coveredVolume"], math.pi / 48, delta=0.005)
        self.fail_with(2, "mesh2vdb", shape, "-o", self.path("b.vdb"), "--group", "a:ior=2")
        nothing = {"type": "offset", "distance": -1, "part": {"type": "sphere", "radius": 0.5}}
        self.assertIn("no inside", self.fail_with(3, "mesh2vdb", self.write("nothing.json", {**BALL, "shape": nothing}),
                                                  "-o", self.path("nothing.vdb")))

    def volume(self, **changes):
        scene = self.write("scene.json", {**SMALL_SCENE, **changes})
        report = self.report("mesh2vdb", scene, "-o", self.path("scene.vdb"))
        return report["counts"][0]["coveredVolume"]

    def test_a_scene_voxelises_the_shape_or_its_triangles(self):
        node = {"type": "ellipsoid", "semiAxes": [0.5, 0.4, 0.3]}
        wanted = 4 / 3 * math.pi * 0.5 * 0.4 * 0.3
        self.assertAlmostEqual(self.volume(objects=[{"shape": node}]), wanted, delta=0.01)
        self.assertAlmostEqual(self.volume(objects=[{"shape": node, "triangulate": True}]), wanted, delta=0.01)
        self.assertAlmostEqual(self.volume(objects=[{"shape": node, "scale": [2, 2, -2]}]), 8 * wanted, delta=0.1)
        self.write("ball.json", BALL)
        self.assertAlmostEqual(self.volume(objects=[{"shape": "ball.json"}]), math.pi / 6, delta=0.01)

    def test_a_scene_whose_shape_has_no_end(self):
        scene = self.write("scene.json", {**SMALL_SCENE, "objects": [{"name": "floor", "shape": {"type": "plane"}}]})
        self.assertIn("floor", self.fail_with(3, "mesh2vdb", scene, "-o", self.path("scene.vdb")))

    def test_a_scene_with_a_shape_keeps_its_energy(self):
        scene = self.write("scene.json", {**SMALL_SCENE, "objects": [{"shape": {"type": "torus", "majorRadius": 0.5}}],
                                          "animation": {"/objects/0/shape/minorRadius": [[1, 0.2], [2, 0.3]]}})
        report = self.report("trace", scene, "-o", self.path("light.vdb"), "--frames", "1-2")
        hashes = set()
        for frame in report["frames"]:
            self.assertLess(frame["energyBalance"]["relativeImbalance"], 1e-3)
            hashes.add(frame["sceneHash"])
        self.assertEqual(len(hashes), 2)

    def test_only_a_shape_that_changes_is_voxelised_again(self):
        def media(**changes):
            node = {"type": "sphere", "radius": 0.5}
            scene = self.write("scene.json", {**SMALL_SCENE, "objects": [{"shape": node, **changes.pop("object", {})}],
                                              **changes})
            report = self.report("trace", scene, "-o", self.path("light.vdb"), "--frames", "1-3")
            return [stage["stage"] for stage in report["stages"]].count("medium")

        self.assertEqual(media(), 1, "the light alone is animated")
        radius = {"/objects/0/shape/radius": [[1, 0.5], [2, 0.4]]}
        self.assertEqual(media(animation=radius), 2)
        self.assertEqual(media(animation=radius, object={"triangulate": True, "resolution": 16}), 2)
        self.assertEqual(media(animation={"/objects/0/tolerance": [[1, 0.1], [2, 0.01]]}), 1, "there are no triangles")


class Schema(ProgramCase):
    def schema(self):
        return json.loads(self.succeed("scene", "schema", "--shape").stdout)

    def test_the_documentation_has_the_tables_of_the_schema(self):
        page = (DATA.parent / "docs" / "shape_file.md").read_text()
        self.assertIn(tables(self.schema()), page, "docs/shape_file.md: paste what `volcaustic scene schema --shape | "
                                                   "python3 tests/cli/shape_tables.py` prints")

    def test_examples_of_the_documentation_are_good(self):
        page = (DATA.parent / "docs" / "shape_file.md").read_text()
        examples = re.findall(r"```json\n(\{\n?\s*\"volcaustic\".*?)```", page, flags=re.S)
        self.assertGreater(len(examples), 0)
        for example in examples:
            self.succeed("info", self.write("example.json", example))

    @unittest.skipUnless(importlib.util.find_spec("jsonschema"), "python3-jsonschema is not installed")
    def test_accepts_shapes_and_refuses_what_the_program_refuses(self):
        import jsonschema
        jsonschema.Draft202012Validator.check_schema(self.schema())
        shapes = jsonschema.Draft202012Validator(self.schema())
        scenes = jsonschema.Draft202012Validator(json.loads(self.succeed("scene", "schema").stdout))
        shipped = sorted((DATA / "shapes").glob("**/*.json"))
        for path in shipped:
            with self.subTest(shape=path.name):
                shapes.validate(json.loads(without_comments(path.read_text())))
        for path in sorted((DATA / "scenes").glob("**/*.json")):
            with self.subTest(scene=path.name):
                scenes.validate(json.loads(without_comments(path.read_text())))
        good = [{"type": "ellipsoid", "semiAxes": [1, 1, 2], "deviations": [{"weight": -1, "region": {"type": "cone"}}]},
                {"type": "union", "blend": 0.1, "parts": [{"use": "ball", "name": "b", "scale": [1, 2, 1]}, MOVING["shape"]]},
                {"type": "instances", "placements": [{"translate": [1, 0, 0]}], "part": {"type": "sphere"}},
                {"type": "revolution", "points": [[0, 0], [1, 0], [0, 1]], "smooth": True}]
        definitions = {"ball": {"type": "sphere"}}
        for node in good:
            text = {**BALL, "shape": node, "shapes": definitions}
            shapes.validate(text)
            scenes.validate({**SMALL_SCENE, "objects": [{"shape": node}], "shapes": definitions})
            entry = self.report("info", self.write("good.json", text))["files"][0]
            shapes.validate({**BALL, "shape": entry["shape"]})
        bad = [{}, {"type": "spere"}, {"type": "sphere", "raduis": 1}, {"type": "sphere", "radius": 0},
               {"type": "sphere", "parts": []}, {"type": "union", "parts": []}, {"type": "union"}, {"type": "shell"},
               {"type": "torus", "deviations": []}, {"use": 3}, {"use": "ball", "type": "sphere"}, "ball.json",
               {"type": "cone", "deviations": [{"weight": 1}]}, {"type": "revolution"},
               {"type": "union", "parts": [{"type": "shell", "part": {"type": "cone", "height": "1"}}]}]
        for node in bad:
            with self.subTest(node=node):
                self.assertFalse(shapes.is_valid({**BALL, "shape": node, "shapes": definitions}))
                self.fail_with(3, "shape2mesh", self.write("bad.json", {**BALL, "shape": node, "shapes": definitions}),
                               "-o", self.path("bad.ply"))
