"""Receivers and reflection: pictures, light maps and what they say when something is wrong."""

import unittest

from program import OCTAHEDRON, ProgramCase

FLOOR = {"name": "floor", "scale": [4, 4, 1], "translate": [0, 0, -0.8], "resolution": 64}
STATUE = {"name": "statue", "mesh": "statue.obj", "scale": [0.5, 0.5, 0.5], "translate": [1.2, 0, -0.4], "resolution": 128}


class Receivers(ProgramCase):
    def scene(self, **changes):
        self.write("statue.obj", OCTAHEDRON)
        return self.write_small_scene(**{"receivers": [FLOOR, STATUE], **changes})

    def channels(self, name):
        return {c["name"]: c for c in self.report("info", self.path(name))["files"][0]["channels"]}

    def test_they_are_seen_and_take_power(self):
        report = self.report("render", self.scene(), "-o", self.path("a.exr"))
        balance = report["energyBalance"]
        self.assertGreater(balance["received"][0], 0)
        self.assertLess(balance["relativeImbalance"], 1e-5)
        self.assertGreater(self.channels("a.exr")["receiver.R"]["maximum"], 0.1)
        self.succeed("render", self.scene(receivers=[]), "-o", self.path("b.exr"))
        self.assertEqual(self.channels("b.exr")["receiver.R"]["maximum"], 0)

    def test_light_maps(self):
        for command, output in (("trace", "a.vdb"), ("render", "a.png")):
            self.succeed(command, self.scene(), "-o", self.path(output), "--light-maps", self.path("maps"))
            self.assertEqual(sorted(p.name for p in (self.folder / "maps").iterdir()),
                             ["floor.exr", "statue.exr", "statue.obj"])
        floor = self.channels("maps/floor.exr")
        self.assertEqual(set(floor), {f"{layer}{c}" for layer in ("", "caustic.", "direct.") for c in "RGB"})
        # Light beside the box is as bright as the light says, times the cosine of its slant.
        self.assertAlmostEqual(floor["direct.R"]["maximum"], 4 * 1 / (1.05 ** 0.5), 2)
        self.assertGreater(floor["caustic.R"]["maximum"], 0)
        text = (self.folder / "maps" / "statue.obj").read_text()
        corners = [line.split() for line in text.splitlines() if line.startswith("vt ")]
        self.assertEqual(len(corners), 24)
        self.assertTrue(all(0 <= float(x) <= 1 for _, *uv in corners for x in uv))
        self.assertIn("closed", self.succeed("info", self.path("maps/statue.obj")).stdout)

    def test_a_light_map_a_frame(self):
        self.succeed("trace", self.scene(receivers=[FLOOR]), "-o", self.path("a.vdb"), "--frames", "1-2", "--light-maps",
                     self.path("maps"))
        self.assertEqual(sorted(p.name for p in (self.folder / "maps").iterdir()), ["floor.0001.exr", "floor.0002.exr"])

    def test_a_moved_camera_keeps_the_light(self):
        turning = {"/camera/position": [[1, [0, -4, 1]], [2, [1, -4, 1]]]}
        report = self.report("render", self.scene(animation=turning), "-o", self.path("f.png"), "--frames", "1-2")
        self.assertEqual([s["stage"] for s in report["stages"]].count("photons"), 1)

    def test_mistakes_are_one_line(self):
        for receivers, place in (([{**FLOOR, "scale": [0, 1, 1]}], "/receivers/0/scale/0"),
                                 ([FLOOR, FLOOR], "/receivers/1/name"),
                                 ([{**FLOOR, "name": "a/b"}], "/receivers/0/name"),
                                 ([{**FLOOR, "albedo": [2, 0, 0]}], "/receivers/0/albedo/0"),
                                 ([{**STATUE, "mesh": "missing.obj"}], "missing.obj")):
            self.assertIn(place, self.fail_with(3, "render", self.scene(receivers=receivers), "-o", self.path("o.png")))
        vain = self.fail_with(2, "render", self.scene(receivers=[]), "-o", self.path("o.png"), "--light-maps", "maps")
        self.assertIn("no receivers", vain)
        self.assertNotIn("o.png", self.files())

    def test_reflection_is_asked_for(self):
        scene = self.scene(background={"top": [1, 1, 1], "bottom": [0, 0, 0]})
        self.succeed("render", scene, "-o", self.path("a.exr"), "--float")
        self.succeed("render", scene, "-o", self.path("b.exr"), "--float", "--set", "view.fresnel=true", "--set",
                     "photons.fresnel=true")
        a, b = self.channels("a.exr"), self.channels("b.exr")
        self.assertNotEqual(a["background.G"]["mean"], b["background.G"]["mean"])
        for threads in ("1", "2"):
            self.succeed("render", scene, "-o", self.path(threads + ".exr"), "--set", "view.fresnel=true", "--set",
                         "photons.fresnel=true", "--threads", threads)
        self.succeed("compare", self.path("1.exr"), self.path("2.exr"))


if __name__ == "__main__":
    unittest.main()
