"""Backgrounds from files, environment light, lights by themselves, and layers that are asked for in vain."""

import json

from program import SHARED, ProgramCase

MAPS = SHARED / "data" / "env"
BAD_MAPS = SHARED / "data" / "env_bad"
LAMPS = [{"name": "key", "direction": [0.2, 0.1, -1], "irradiance": [4, 3, 2]},
         {"name": "a b/ü", "type": "point", "position": [1.5, 0, 1], "intensity": [1, 2, 3]},
         {"type": "environment"}]
SEPARATE = {"grid": [64, 64], "separate": True}


class Backgrounds(ProgramCase):
    def test_a_map_is_seen_and_shines(self):
        sky = self.need(MAPS / "rooftop_small.hdr")
        scene = self.write_small_scene(background={"file": str(sky)}, lights=[{"type": "environment"}])
        report = self.report("render", scene, "-o", self.path("a.exr"), "--float")
        self.assertGreater(report["energyBalance"]["emitted"][0], 0)
        self.assertLess(report["energyBalance"]["relativeImbalance"], 1e-6)
        channels = self.channels("a.exr")
        self.assertGreater(channels["background.R"]["maximum"], channels["background.R"]["minimum"])
        self.succeed("render", scene, "-o", self.path("dark.exr"), "--float", "--set", "background.visible=false")
        dark = self.channels("dark.exr")
        self.assertEqual(dark["background.R"]["maximum"], 0)
        self.assertEqual(dark["direct.R"]["mean"], channels["direct.R"]["mean"])

    def test_a_turned_map_is_another_picture(self):
        scene = self.write_small_scene(background={"file": str(self.need(MAPS / "rooftop_small.hdr"))})
        for name, turn in (("a", 0), ("b", 360), ("c", 90)):
            self.succeed("render", scene, "-o", self.path(f"{name}.exr"), "--set", f"background.turn={turn}")
        self.succeed("compare", self.path("a.exr"), self.path("b.exr"), "--threshold", "1e-3")
        other = self.call("compare", self.path("a.exr"), self.path("c.exr"), "--threshold", "1e-3")
        self.assertEqual(other.returncode, 1)

    def test_a_changing_background_sends_photons_anew_only_where_it_gives_light(self):
        changing = {"/background/top": [[1, [1, 1, 1]], [2, [2, 1, 1]]]}
        for lights, runs in (([{"direction": [0, 0, -1]}], 1), ([{"type": "environment"}], 2)):
            scene = self.write_small_scene(lights=lights, animation=changing)
            report = self.report("render", scene, "-o", self.path("f.####.png"), "--frames", "1-2")
            self.assertEqual([s["stage"] for s in report["stages"]].count("photons"), runs)
            self.assertEqual([s["stage"] for s in report["stages"]].count("view"), 2)

    def test_damaged_and_missing_maps_are_one_line_before_any_photon(self):
        maps = [self.folder / "missing.hdr"]
        if BAD_MAPS.exists():
            maps += [BAD_MAPS / "crash-res.hdr", BAD_MAPS / "invalid.exr", BAD_MAPS / "incomplete.exr"]
        for sky in maps:
            scene = self.write_small_scene(background={"file": str(sky)})
            line = self.fail_with(3, "render", scene, "-o", self.path("o.exr"), "--quiet")
            self.assertIn(sky.name, line)
        self.assertNotIn("o.exr", self.files())

    def test_a_map_that_is_missing_is_found_by_the_check(self):
        line = self.fail_with(3, "scene", "check", self.write_small_scene(background={"file": "sky.hdr"}))
        self.assertIn(":/background/file: no such file: ", line)

    def test_values_that_make_no_sense_are_named(self):
        scene = self.write_small_scene(background={"up": [0, 0, 0]})
        self.assertIn(":/background/up: ", self.fail_with(3, "render", scene, "-o", self.path("o.exr")))
        scene = self.write_small_scene(background={"top": [-1, 0, 0]})
        self.assertIn(":/background/top/0: ", self.fail_with(3, "render", scene, "-o", self.path("o.exr")))

    def channels(self, name):
        return {c["name"]: c for c in self.report("info", self.path(name))["files"][0]["channels"]}


class LightsByThemselves(ProgramCase):
    def test_their_layers_add_up_to_the_picture(self):
        scene = self.write_small_scene(lights=LAMPS, photons=SEPARATE)
        report = self.report("render", scene, "-o", self.path("a.exr"), "--float")
        names = ["key", "a_b___", "light2"]
        self.assertEqual(list(report["lights"]), names)
        emitted = sum(report["lights"][n]["emitted"][1] for n in names)
        self.assertAlmostEqual(emitted / report["energyBalance"]["emitted"][1], 1, delta=1e-9)
        mean = {c["name"]: c["mean"] for c in self.report("info", self.path("a.exr"))["files"][0]["channels"]}
        for colour in "RGB":
            parts = sum(mean[f"{n}.{colour}"] for n in names)
            self.assertGreater(min(mean[f"{n}.{colour}"] for n in names), 0)
            self.assertAlmostEqual(parts / (mean[colour] - mean["background." + colour]), 1, delta=1e-5)
            for part in ("caustic", "direct"):
                self.assertAlmostEqual(sum(mean[f"{n}.{part}.{colour}"] for n in names) / mean[f"{part}.{colour}"], 1,
                                       delta=1e-5)

    def test_the_same_bits_for_every_number_of_threads(self):
        scene = self.write_small_scene(lights=LAMPS, photons=SEPARATE)
        for threads in (1, 2):
            self.succeed("render", scene, "-o", self.path(f"{threads}.exr"), "--float", "--threads", threads)
            self.succeed("trace", scene, "-o", self.path(f"{threads}.vdb"), "--parts", "--threads", threads)
        self.succeed("compare", self.path("1.exr"), self.path("2.exr"))
        self.succeed("compare", self.path("1.vdb"), self.path("2.vdb"))

    def test_one_light_alone_is_the_layer_of_it(self):
        scene = self.write_small_scene(lights=LAMPS[:2], photons=SEPARATE)
        self.succeed("render", scene, "-o", self.path("both.exr"), "--float")
        scene = self.write_small_scene(lights=LAMPS[:1], photons=SEPARATE)
        self.succeed("render", scene, "-o", self.path("one.exr"), "--float")
        mean = [{c["name"]: c["mean"] for c in self.report("info", self.path(f))["files"][0]["channels"]}
                for f in ("both.exr", "one.exr")]
        self.assertEqual(mean[0]["key.G"], mean[1]["key.G"])

    def test_their_grids_add_up_to_the_volume(self):
        scene = self.write_small_scene(lights=LAMPS, photons=SEPARATE)
        self.succeed("trace", scene, "-o", self.path("o.vdb"), "--parts")
        grids = {g["name"]: g for g in self.report("info", self.path("o.vdb"))["files"][0]["grids"]}
        for kind in ("radiance", "caustic", "direct"):
            self.assertLessEqual({kind, f"{kind}_key", f"{kind}_a_b___", f"{kind}_light2"}, set(grids))
        self.assertEqual(grids["radiance_key"]["metadata"]["unit"], "W/(m2 sr)")
        self.succeed("trace", scene, "-o", self.path("plain.vdb"))
        names = {g["name"] for g in self.report("info", self.path("plain.vdb"))["files"][0]["grids"]}
        self.assertIn("radiance_key", names)
        self.assertNotIn("caustic_key", names)
        # The volume is that of all lights together.
        joint = self.write_small_scene(lights=LAMPS)
        self.succeed("trace", joint, "-o", self.path("joint.vdb"), "--set", "photons.grid=[64,64]")
        together = {g["name"]: g for g in self.report("info", self.path("joint.vdb"))["files"][0]["grids"]}
        self.assertAlmostEqual(grids["radiance"]["mean"] / together["radiance"]["mean"], 1, delta=1e-4)

    def test_names_that_are_not_told_apart_are_refused(self):
        for name in ("key", "caustic"):
            scene = self.write_small_scene(lights=[LAMPS[0], {**LAMPS[1], "name": name}], photons=SEPARATE)
            line = self.fail_with(3, "trace", scene, "-o", self.path("o.vdb"))
            self.assertIn(f":/lights: lights[1] ({name}): ", line)


class Layers(ProgramCase):
    def test_layers_that_are_not_there_are_found_before_rendering(self):
        scene = self.write_small_scene()
        for layers in ("nonsense", "R,caustik.*"):
            done = self.call("render", scene, "-o", self.path("o.exr"), "--layers", layers)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("no channel is called", done.stderr)
            self.assertNotIn("energy balance", done.stderr, "found out too late")
        self.assertNotIn("o.exr", self.files())
        self.succeed("render", self.write_small_scene(lights=LAMPS, photons=SEPARATE), "-o", self.path("o.exr"),
                     "--layers", "key.*,light2.R")
        image = json.loads(self.succeed("info", self.path("o.exr"), "--json").stdout)["files"][0]
        self.assertLessEqual({"key.R", "key.caustic.B", "light2.R"}, {c["name"] for c in image["channels"]})
        self.assertNotIn("R", {c["name"] for c in image["channels"]})
