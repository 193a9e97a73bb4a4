"""compare and convert of images: thresholds, FLIP, maps, layers, tone and bits; what other programs read of it."""

import re
import shutil
import subprocess

from program import SHARED, ProgramCase


def header(path):
    return subprocess.run(["exrheader", path], stdout=subprocess.PIPE, text=True, check=True).stdout


class CompareImages(ProgramCase):
    def setUp(self):
        super().setUp()
        self.a, self.b = self.path("a.exr"), self.path("b.exr")
        for picture, blue in ((self.a, 2), (self.b, 2.6)):
            scene = self.write_small_scene(lights=[{"direction": [0.2, 0.1, -1], "irradiance": [4, 3, blue]}])
            self.succeed("render", scene, "-o", picture, "--float")

    def test_flip_of_a_picture_and_itself(self):
        done = self.succeed("compare", self.a, self.a)
        self.assertRegex(done.stdout, r"\nFLIP +0 +0\n")
        flip = self.report("compare", self.a, self.a)["flip"]
        self.assertEqual((flip["mean"], flip["maximum"], flip["pixelsPerDegree"]), (0, 0, 67))

    def test_thresholds_decide_the_status(self):
        report = self.call("compare", self.a, self.b, "--json")
        self.assertEqual(report.returncode, 1)
        flip = self.report("compare", self.a, self.b, "--threshold", "1000")["flip"]
        self.assertTrue(0 < flip["mean"] < flip["maximum"] <= 1, flip)
        self.assertGreaterEqual(len(flip["exposures"]), 2)
        above, below = flip["mean"] * 1.01, flip["mean"] * 0.99
        self.assertEqual(self.call("compare", self.a, self.b, "--flip-threshold", above).returncode, 0)
        self.assertEqual(self.call("compare", self.a, self.b, "--flip-threshold", below).returncode, 1)
        both = ["--threshold", "0", "--flip-threshold", above]
        self.assertEqual(self.call("compare", self.a, self.b, *both).returncode, 1)
        self.assertNotEqual(self.report("compare", self.a, self.b, "--threshold", "1000", "--pixels-per-degree", "20")["flip"]["mean"],
                            flip["mean"])

    def test_maps_as_numbers_and_as_colours(self):
        for name, channels in (("map.exr", ["Y"]), ("map.png", ["R", "G", "B"])):
            report = self.report("compare", self.a, self.b, "--threshold", "1000", "--map", self.path(name))
            self.assertEqual(report["outputs"], [self.path(name)])
            image = self.report("info", self.path(name))["files"][0]
            self.assertEqual(([c["name"] for c in image["channels"]], image["width"], image["height"]), (channels, 32, 24))
            if name == "map.exr":
                self.assertAlmostEqual(image["channels"][0]["mean"], report["flip"]["mean"], delta=1e-6)
                self.assertAlmostEqual(image["channels"][0]["maximum"], report["flip"]["maximum"], delta=1e-6)

    def test_display_files_are_compared_as_they_are_shown(self):
        for name in ("a", "b"):
            self.succeed("convert", self.path(name + ".exr"), self.path(name + ".png"), "--exposure", "4")
        report = self.report("compare", self.path("a.png"), self.path("b.png"), "--threshold", "1")
        self.assertEqual(report["flip"]["exposures"], [])

    def test_what_does_not_go_together_is_one_line(self):
        scene = self.write_small_scene(camera={"resolution": [16, 24]})
        self.succeed("render", scene, "-o", self.path("small.exr"))
        self.assertIn("sizes", self.fail_with(3, "compare", self.a, self.path("small.exr")))
        self.succeed("convert", self.a, self.path("rgb.exr"), "--layers", "R,G,B")
        self.assertIn("channel", self.fail_with(3, "compare", self.a, self.path("rgb.exr")))
        mesh = self.path("octahedron.obj")
        self.assertIn("--map", self.fail_with(2, "compare", mesh, mesh, "--map", self.path("map.png")))
        self.fail_with(2, "compare", self.a, self.b, "--map", self.path("map.nonsense"))
        self.fail_with(2, "compare", self.a, self.b, "--flip-threshold", "2")
        self.fail_with(2, "compare", self.a, self.b, "--pixels-per-degree", "0")


class WriteImages(ProgramCase):
    def setUp(self):
        super().setUp()
        self.picture = self.path("a.exr")
        self.succeed("render", self.write_small_scene(), "-o", self.picture, "--float", "--layers", "R,G,B,A,caustic.*,background.*,depth.Z",
                     "--tiles", "16", "--compression", "piz")

    def channels(self, path):
        return {c["name"] for c in self.report("info", path)["files"][0]["channels"]}

    def test_layers_tiles_and_codec(self):
        self.assertEqual(self.channels(self.picture), {"R", "G", "B", "A", "caustic.R", "caustic.G", "caustic.B", "background.R",
                                                       "background.G", "background.B", "depth.Z"})
        if shutil.which("exrheader"):
            text = header(self.picture)
            for part in ["compression (type compression): piz", "16 by 16 pixels", "chromaticities", "worldToCamera (type m44f)",
                         "worldToNDC (type m44f)", 'software (type string): "volcaustic', "scene_hash", "device (type string)",
                         "ms_photons", 'colorInteropID (type string): "lin_rec709_scene"']:
                self.assertIn(part, text)
            width = float(re.search(r"screenWindowWidth \(type float\): (\S+)", text).group(1))
            self.assertNotEqual(width, 1)

    def test_conversions_keep_every_value_and_what_the_file_says(self):
        self.succeed("convert", self.picture, self.path("b.exr"), "--compression", "none")
        self.succeed("compare", self.picture, self.path("b.exr"))
        before, after = (self.report("info", p)["files"][0]["metadata"] for p in (self.picture, self.path("b.exr")))
        self.assertEqual(before, after)
        self.succeed("convert", self.picture, self.path("half.exr"), "--half")
        self.assertEqual(self.call("compare", self.picture, self.path("half.exr")).returncode, 1)

    def test_tone_exposure_bits_and_alpha(self):
        def mean(name, *flags):
            self.succeed("convert", self.picture, self.path(name), *flags)
            channels = {c["name"]: c["mean"] for c in self.report("info", self.path(name))["files"][0]["channels"]}
            return channels["G"], len(channels)

        plain, count = mean("plain.png")
        self.assertEqual(count, 3, "the background is in the picture, so there is no alpha")
        self.assertAlmostEqual(mean("plain16.png", "--bits", "16")[0], plain, delta=0.01 * plain)
        self.assertGreater(mean("bright.png", "--exposure", "1")[0], 1.5 * plain)
        self.assertLess(mean("aces.png", "--tone", "aces")[0], plain)
        self.assertEqual(mean("alpha.png", "--alpha")[1], 4)
        self.assertLess(mean("caustic.png", "--layers", "caustic.*")[0], plain)
        self.succeed("render", self.path("scene.json"), "-o", self.path("r.png"), "-o", self.path("r.tif"), "--bits", "16", "--tone", "aces",
                     "--exposure", "2")
        self.succeed("compare", self.path("r.png"), self.path("r.tif"))

    def test_wrong_words_are_one_line(self):
        out = self.path("o.exr")
        self.assertIn("caustic.R", self.fail_with(2, "convert", self.picture, out, "--layers", "R,caustics.*"))
        self.fail_with(2, "convert", self.picture, out, "--compression", "gzip")
        self.fail_with(2, "convert", self.picture, out, "--tone", "film")
        self.fail_with(2, "convert", self.picture, self.path("o.png"), "--bits", "10")
        self.fail_with(2, "convert", self.picture, out, "--tiles", "5000")
        self.assertIn("layer", self.fail_with(2, "convert", self.picture, self.path("o.png"), "--layers", "depth.Z,A"))
        self.assertNotIn("o.exr", self.files())


class DamagedImages(ProgramCase):
    def test_end_in_one_line_or_are_pictures(self):
        folder = self.need(SHARED / "data" / "env_bad")
        files = sorted(p for p in folder.rglob("*") if p.is_file())
        self.assertGreater(len(files), 3)
        for file in [f for f in files if f.parent == folder] + files[::12]:
            copy = self.path("bad.hdr" if file.suffix == ".hdr" else "bad.exr")
            shutil.copyfile(file, copy)
            for arguments in (["convert", copy, self.path("out.png")], ["compare", copy, copy]):
                with self.subTest(file=file.name, command=arguments[0]):
                    done = self.call(*arguments)
                    self.assertIn(done.returncode, (0, 2, 3), done.stderr)
                    if done.returncode:
                        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
                        self.assertIn(".", done.stderr.split(":")[0])
