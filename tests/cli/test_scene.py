"""scene check, schema and new."""

import importlib.util
import json
import re
import unittest

from program import DATA, OCTAHEDRON, SMALL_SCENE, ProgramCase
from scene_tables import tables


def without_comments(text):
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*|/\*.*?\*/', lambda m: m.group(1) or " ", text, flags=re.S)


class Check(ProgramCase):
    def test_a_good_scene(self):
        scene = self.write_small_scene()
        self.assertIn("scene.json", self.succeed("scene", "check", scene).stderr)
        self.assertEqual(len(self.report("scene", "check", scene)["sceneHashes"][0]), 16)
        self.assertEqual(self.succeed("scene", "check", scene, "--quiet").stderr, "")

    def test_standard_input(self):
        self.write("octahedron.obj", OCTAHEDRON)
        self.succeed("scene", "check", "-", input=json.dumps(SMALL_SCENE), cwd=self.folder)

    def test_an_unknown_key_has_its_pointer_and_the_nearest_key(self):
        scene = self.write_small_scene(lights=[{"irradance": [1, 1, 1]}])
        line = self.fail_with(3, "scene", "check", scene)
        self.assertTrue(line.startswith(scene + ":/lights/0/irradance: "), line)
        self.assertIn('"irradiance"', line)

    def test_bad_syntax_has_line_and_column(self):
        scene = self.write("bad.json", '{\n  "volcaustic" 1}')
        self.assertTrue(self.fail_with(3, "scene", "check", scene).startswith(scene + ":2:16: "))

    def test_missing_files(self):
        self.assertTrue(self.fail_with(3, "scene", "check", self.path("no.json")).startswith(self.path("no.json") + ": "))
        scene = self.write("scene.json", SMALL_SCENE)
        self.assertTrue(self.fail_with(3, "scene", "check", scene).startswith(scene + ":/objects/0/mesh: "))

    def test_every_shipped_scene_is_good(self):
        scenes = sorted((DATA / "scenes").glob("*.json"))
        for scene in scenes:
            with self.subTest(scene=scene.name):
                self.succeed("scene", "check", scene)

    def test_every_shipped_scene_renders(self):
        for scene in sorted((DATA / "scenes").glob("*.json")):
            with self.subTest(scene=scene.name):
                content = json.loads(without_comments(scene.read_text()))
                small = ["camera.resolution=[32,20]", "photons.grid=[32,32]", "volume.resolution=24", "view.samples=1"]
                small += [f"receivers.{i}.resolution=32" for i in range(len(content.get("receivers", [])))]
                small += [f"lights.{i}.samples=2" for i, light in enumerate(content["lights"])
                          if light.get("type") == "environment"]
                report = self.report("render", scene, "-o", self.path("picture.exr"),
                                     *(word for value in small for word in ("--set", value)))
                self.assertGreater(report["counts"]["photonsEmitted"], 0)
                self.assertLess(report["energyBalance"]["relativeImbalance"], 1e-3)


class New(ProgramCase):
    def test_the_template_is_a_scene_as_it_is(self):
        text = self.succeed("scene", "new").stdout
        self.assertIn("//", text)
        self.write("mesh.obj", OCTAHEDRON)
        self.succeed("scene", "check", self.write("new.json", text))

    def test_the_template_takes_a_mesh(self):
        self.write('odd "name".obj', OCTAHEDRON)
        text = self.succeed("scene", "new", "--mesh", 'odd "name".obj').stdout
        self.succeed("scene", "check", self.write("new.json", text))


class Schema(ProgramCase):
    def test_is_json_and_describes_every_section(self):
        schema = json.loads(self.succeed("scene", "schema").stdout)
        self.assertEqual(schema["$schema"], "https://json-schema.org/draft/2020-12/schema")
        self.assertFalse(schema["additionalProperties"])
        attenuation = schema["properties"]["materials"]["additionalProperties"]["properties"]["attenuation"]
        self.assertEqual(attenuation["items"]["minimum"], 0)
        self.assertIn("[1/world]", attenuation["description"])
        alternatives = schema["properties"]["objects"]["items"]["anyOf"]
        self.assertEqual([a["required"] for a in alternatives], [["mesh"], ["volume"], ["shape"]])

    def test_the_documentation_has_the_tables_of_the_schema(self):
        page = (DATA.parent / "docs" / "scene_file.md").read_text()
        self.assertIn(tables(json.loads(self.succeed("scene", "schema").stdout)), page,
                      "docs/scene_file.md: paste what `volcaustic scene schema | python3 tests/cli/scene_tables.py` prints")

    @unittest.skipUnless(importlib.util.find_spec("jsonschema"), "python3-jsonschema is not installed")
    def test_accepts_scenes_and_refuses_what_the_program_refuses(self):
        import jsonschema
        schema = json.loads(self.succeed("scene", "schema").stdout)
        jsonschema.Draft202012Validator.check_schema(schema)
        validator = jsonschema.Draft202012Validator(schema)
        good = [SMALL_SCENE, json.loads(without_comments(self.succeed("scene", "new").stdout))]
        good += [json.loads(without_comments(p.read_text())) for p in sorted((DATA / "scenes").glob("*.json"))]
        good += [self.report("info", self.write_small_scene())["files"][0]["scene"]]
        for scene in good:
            validator.validate(scene)
        for change in [{"photon": {}}, {"lights": [{"irradance": [1, 1, 1]}]}, {"lights": [{"irradiance": [1, -1, 1]}]},
                       {"lights": [{"irradiance": [1, 1]}]}, {"voxelise": {"supersample": 3}}, {"volcaustic": 2},
                       {"photons": {"grid": [1.5, 2]}}, {"photons": {"scheme": "eulr"}}, {"objects": [{}]},
                       {"objects": [{"mesh": ""}]}, {"volume": {"bounds": "automatic"}},
                       {"volume": {"bounds": {"min": [0, 0, 0]}}}, {"animation": {"/camera/position": [[1, "x"]]}}]:
            with self.subTest(change=change):
                self.assertFalse(validator.is_valid({**SMALL_SCENE, **change}))
                self.fail_with(3, "scene", "check", self.write_small_scene(**change))
