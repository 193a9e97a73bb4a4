"""trace and render: reports, frames, interruption, and the same bits for every number of threads."""

import json
import os
import signal
import subprocess
import time

from program import PROGRAM, ProgramCase


class Trace(ProgramCase):
    def setUp(self):
        super().setUp()
        self.scene = self.write_small_scene()

    def test_the_report_is_whole(self):
        report = self.report("trace", self.scene, "-o", self.path("o.vdb"), "--threads", "1", "--seed", "7", "--device", "cpu")
        self.assertEqual(report["inputs"], [self.scene])
        self.assertEqual(report["outputs"], [self.path("o.vdb")])
        self.assertEqual((report["command"], report["device"], report["threads"], report["seed"]), ("trace", "cpu", 1, 7))
        self.assertEqual(len(report["sceneHash"]), 16)
        self.assertLessEqual({"medium", "photons", "write"}, {s["stage"] for s in report["stages"]})
        for stage in report["stages"]:
            self.assertGreaterEqual(stage["ms"], 0)
        self.assertGreater(report["counts"]["photonsEmitted"], 1000)
        balance = report["energyBalance"]
        self.assertLess(balance["relativeImbalance"], 1e-4)
        self.assertGreater(balance["emitted"][0], balance["emitted"][2])
        for channel in range(3):
            out = sum(balance[k][channel] for k in ("absorbed", "scattered", "escaped", "received", "cutOff"))
            self.assertAlmostEqual(out / balance["emitted"][channel], 1, delta=1e-4)

    def test_the_energy_balance_is_said_unless_quiet(self):
        done = self.succeed("trace", self.scene, "-o", self.path("o.vdb"))
        self.assertEqual(done.stdout, "")
        for part in ["energy balance [W]", "emitted", "absorbed", "relative imbalance"]:
            self.assertIn(part, done.stderr)
        self.assertNotIn("\r", done.stderr, "progress is for terminals")
        self.assertEqual(self.succeed("trace", self.scene, "-o", self.path("o.vdb"), "--quiet").stderr, "")

    def test_set_changes_the_scene(self):
        report = self.report("trace", self.scene, "-o", self.path("o.vdb"), "--set", "photons.grid=[16,16]")
        self.assertLessEqual(report["counts"]["photonsEmitted"], 256)

    def test_the_same_bits_for_every_number_of_threads(self):
        for threads in (1, 2):
            self.succeed("trace", self.scene, "-o", self.path(f"{threads}.vdb"), "--threads", threads, "--parts",
                         "--set", "photons.jitter=true")
            self.succeed("render", self.scene, "-o", self.path(f"{threads}.exr"), "-o", self.path(f"{threads}.png"),
                         "--float", "--threads", threads)
        self.succeed("compare", self.path("1.vdb"), self.path("2.vdb"))
        self.succeed("compare", self.path("1.exr"), self.path("2.exr"))
        self.succeed("compare", self.path("1.png"), self.path("2.png"))

    def test_bad_scenes_are_status_3(self):
        scene = self.write_small_scene(lights=[{"irradance": [1, 1, 1]}])
        line = self.fail_with(3, "trace", scene, "-o", self.path("o.vdb"))
        self.assertTrue(line.startswith(scene + ":/lights/0/irradance: "), line)
        self.assertNotIn("o.vdb", self.files())


class Frames(ProgramCase):
    def setUp(self):
        super().setUp()
        self.scene = self.write_small_scene()

    def test_one_file_a_frame(self):
        report = self.report("trace", self.scene, "-o", self.path("f.####.vdb"), "--frames", "1-3x2")
        self.assertEqual([f["frame"] for f in report["frames"]], [1, 3])
        self.assertLessEqual({"f.0001.vdb", "f.0003.vdb"}, set(self.files()))
        self.assertNotEqual(report["frames"][0]["sceneHash"], report["frames"][1]["sceneHash"], "the light is animated")
        self.assertEqual([s["stage"] for s in report["stages"]].count("medium"), 1, "a moved light leaves the medium alone")
        self.assertEqual(self.call("compare", self.path("f.0001.vdb"), self.path("f.0003.vdb")).returncode, 1)
        self.succeed("trace", self.scene, "-o", self.path("g_%02d.vdb"), "--frames", "2")
        self.succeed("trace", self.scene, "-o", self.path("h.vdb"), "--frames", "2")
        self.assertLessEqual({"g_02.vdb", "h.0002.vdb"}, set(self.files()))

    def test_resume_skips_what_is_there(self):
        self.succeed("trace", self.scene, "-o", self.path("f.####.vdb"), "--frames", "2")
        before = os.stat(self.path("f.0002.vdb"))
        report = self.report("trace", self.scene, "-o", self.path("f.####.vdb"), "--frames", "1-3", "--resume")
        self.assertEqual([f["skipped"] for f in report["frames"]], [False, True, False])
        after = os.stat(self.path("f.0002.vdb"))
        self.assertEqual((before.st_ino, before.st_mtime_ns), (after.st_ino, after.st_mtime_ns))


class Render(ProgramCase):
    def setUp(self):
        super().setUp()
        self.scene = self.write_small_scene()

    def test_trace_then_info_then_render(self):
        self.succeed("trace", self.scene, "-o", self.path("o.vdb"), "--parts")
        grids = {g["name"]: g for g in self.report("info", self.path("o.vdb"))["files"][0]["grids"]}
        self.assertLessEqual({"radiance", "direction", "emission", "density", "caustic", "direct"}, set(grids))
        self.assertGreater(grids["radiance"]["maximum"], 0)
        self.succeed("render", self.scene, "--radiance", self.path("o.vdb"), "-o", self.path("read.exr"), "--float")
        report = self.report("render", self.scene, "-o", self.path("whole.exr"), "-o", self.path("whole.png"), "--float")
        self.assertEqual(report["outputs"], [self.path("whole.exr"), self.path("whole.png")])
        self.assertGreater(report["counts"]["viewSteps"], 0)
        # The light went through 32-bit grids of L = fluence / 4 pi once.
        self.succeed("compare", self.path("read.exr"), self.path("whole.exr"), "--threshold", "1e-7")
        image = self.report("info", self.path("whole.exr"))["files"][0]
        self.assertEqual((image["width"], image["height"]), (32, 24))
        self.assertLessEqual({"R", "G", "B", "A", "caustic.R", "direct.G", "transmittance.B", "depth.Z", "steps.Y"},
                             {c["name"] for c in image["channels"]})

    def test_light_without_its_parts_gives_the_same_picture(self):
        self.succeed("trace", self.scene, "-o", self.path("o.vdb"))
        self.succeed("render", self.scene, "--radiance", self.path("o.vdb"), "-o", self.path("read.exr"), "--float")
        self.succeed("render", self.scene, "-o", self.path("whole.exr"), "--float")
        done = self.call("compare", self.path("read.exr"), self.path("whole.exr"), "--json")
        beauty = [d["maximum"] for d in json.loads(done.stdout)["differences"] if d["name"] in "RGBA"]
        self.assertEqual(len(beauty), 4)
        # The view rounds light to half floats: two parts of it, or their sum.
        self.assertLess(max(beauty), 3e-5)

    def test_standard_input(self):
        with open(self.scene) as text:
            self.succeed("render", "-", "-o", "a.png", input=text.read(), cwd=self.folder)
        self.assertIn("a.png", self.files())


class Interruption(ProgramCase):
    def test_sigint_leaves_nothing_half_written(self):
        scene = self.write_small_scene(photons={"grid": [8192, 8192], "maxStep": 1})
        child = subprocess.Popen([PROGRAM, "trace", scene, "-o", self.path("o.vdb")], stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        child.send_signal(signal.SIGINT)
        _, words = child.communicate(timeout=60)
        self.assertEqual(child.returncode, 130, words)
        self.assertIn("interrupted", words.splitlines()[-1])
        self.assertEqual(self.files(), ["octahedron.obj", "scene.json"])
