"""simulate: rigid bodies as keys of a scene, the mixing of two fluids as a sequence of volumes."""

import json
import math
import pathlib
import signal
import subprocess
import time
import unittest

from program import OCTAHEDRON, PROGRAM, SMALL_SCENE, ProgramCase

BODIES = {
    **SMALL_SCENE,
    "objects": [
        {"name": "ball", "shape": {"type": "sphere", "radius": 0.25}, "resolution": 24, "translate": [0, 0, 1]},
        {"name": "stone", "mesh": "octahedron.obj", "translate": [2, 0, 3]},
        {"name": "block", "mesh": "octahedron.obj", "translate": [-2, 0, 0]},
    ],
    "receivers": [{"name": "floor", "scale": [10, 10, 1]}],
    "animation": {"/lights/0/direction": [[1, [0.2, 0.1, -1]], [3, [-0.2, 0.1, -1]]],
                  "/objects/0/translate/0": [[1, 0], [9, 5]]},
}
MIXING = ("simulate", "mixing", "--resolution", 16)


class Bodies(ProgramCase):
    def setUp(self):
        super().setUp()
        self.write("octahedron.obj", OCTAHEDRON)
        self.scene = self.write("scene.json", BODIES)

    def simulated(self, *flags, out="out.json"):
        self.report("simulate", "bodies", self.scene, "-o", self.path(out), *flags)
        return json.loads((self.folder / out).read_text())

    def test_what_moves_gets_keys_and_the_rest_of_the_scene_stays(self):
        scene = self.simulated("--frames", "5-16", "--fixed", "block", "--velocity", "stone=0.5,0,0")
        self.assertEqual(scene["frames"], {"first": 5, "last": 16, "rate": 24.0})
        self.assertEqual(set(scene["animation"]),
                         {"/lights/0/direction", "/objects/0/translate", "/objects/0/rotate", "/objects/1/translate",
                          "/objects/1/rotate"})
        self.assertEqual(scene["lights"], BODIES["lights"])
        keys = scene["animation"]["/objects/1/translate"]
        self.assertEqual([frame for frame, _ in keys], list(range(5, 17)))
        t = 11 / 24
        for got, expected in zip(keys[-1][1], [2 + 0.5 * t, 0, 3 - 0.5 * 9.81 * t * t]):
            self.assertAlmostEqual(got, expected, delta=1e-3)
        self.succeed("scene", "check", self.path("out.json"))

    def test_the_floor_holds_what_falls(self):
        scene = self.simulated("--frames", "1-72")
        self.assertAlmostEqual(scene["animation"]["/objects/0/translate"][-1][1][2], 0.25, delta=0.01)
        lowest = min(position[2] for _, position in scene["animation"]["/objects/1/translate"])
        self.assertGreater(lowest, 0.5 / math.sqrt(3) - 0.02)

    def test_gravity_rate_and_repeatability(self):
        flags = ("--frames", "1-13", "--gravity", 0, 0, 0, "--rate", 12, "--velocity", "ball=0,1,0", "--spin", "ball=0,0,90")
        scene = self.simulated(*flags)
        self.assertEqual(scene, self.simulated(*flags, out="again.json"))
        self.assertAlmostEqual(scene["animation"]["/objects/0/translate"][-1][1][1], 1, delta=1e-3)
        self.assertAlmostEqual(scene["animation"]["/objects/0/rotate"][-1][1][2], 90, delta=1)

    def test_the_rate_is_that_of_the_scene(self):
        self.scene = self.write("scene.json", {**BODIES, "frames": {"first": 1, "last": 3, "rate": 30}})
        self.assertEqual(self.simulated("--frames", "1-3")["frames"]["rate"], 30)
        self.assertEqual(self.simulated("--frames", "1-3", "--rate", 12)["frames"]["rate"], 12)

    def test_relative_paths_lead_from_the_other_folder(self):
        (self.folder / "deep").mkdir()
        self.write("lens.json", {"volcaustic": 1, "shape": {"type": "sphere", "radius": 0.5}})
        self.scene = self.write("scene.json", {**BODIES, "objects": BODIES["objects"] + [
            {"name": "lens", "shape": "lens.json", "translate": [0, 4, 1]}]})
        scene = self.simulated("--frames", "1-3", out="deep/out.json")
        self.assertEqual(scene["objects"][1]["mesh"], "../octahedron.obj")
        self.assertEqual(scene["objects"][3]["shape"], "../lens.json")
        self.succeed("scene", "check", self.path("deep/out.json"))

    def test_says_what_is_wrong(self):
        def message(status, *flags):
            return self.fail_with(status, "simulate", "bodies", self.scene, "-o", self.path("out.json"), *flags)

        self.assertIn("ball, stone, block, floor", message(2, "--fixed", "bowl"))
        self.assertIn("NAME=X,Y,Z", message(2, "--velocity", "ball=1,2"))
        self.assertIn("density", message(2, "--density", "ball=0"))
        self.assertIn("is fixed", message(2, "--velocity", "floor=1,0,0"))
        self.assertIn("45 degrees", message(2, "--spin", "ball=0,0,1e6"))
        self.assertIn("left the numbers", message(3, "--velocity", "ball=1e39,0,0"))
        self.assertIn("no folder", self.fail_with(3, "simulate", "bodies", self.scene, "-o", self.path("none/out.json")))
        self.assertIn("step", message(2, "--frames", "1-9x2"))
        self.write("octahedron.obj", "\n".join(OCTAHEDRON.splitlines()[:-1]) + "\n")
        self.assertIn("stone: has 3 open edges", message(3))
        self.assertFalse((self.folder / "out.json").exists())


class Mixing(ProgramCase):
    def mix(self, *flags, name="mix.####.vdb"):
        return self.report(*MIXING, "-o", self.path(name), *flags)

    def frames(self, prefix):
        return {p.name[len(prefix):]: p.read_bytes() for p in self.folder.glob(prefix + "*.vdb")}

    def test_frames_are_numbered_and_hold_what_flowed_in(self):
        report = self.mix("--frames", "2-6x2", "--disturbance", 0)
        self.assertEqual([pathlib.Path(f).name for f in report["outputs"]],
                         ["mix.0002.vdb", "mix.0004.vdb", "mix.0006.vdb"])
        info = self.report("info", self.path("mix.0006.vdb"))["files"][0]
        names = {grid["name"] for grid in info["grids"]}
        self.assertEqual(names, {"concentration", "velocity"})

    def test_a_range_that_starts_later_has_the_same_files(self):
        self.mix("--frames", "1-4")
        self.mix("--frames", "3-4", name="late.####.vdb")
        early, late = self.frames("mix"), self.frames("late")
        self.assertEqual({name: early[name] for name in late}, late)
        self.assertEqual(len(late), 2)

    def test_resumed_and_whole_runs_have_the_same_files(self):
        self.mix("--frames", "1-5")
        for missing in (".0002.vdb", ".0005.vdb"):
            (self.folder / ("mix" + missing)).unlink()
        kept = (self.folder / "mix.0003.vdb").stat().st_mtime_ns
        report = self.mix("--frames", "1-5", "--resume")
        self.assertEqual([f["skipped"] for f in report["frames"]], [True, False, True, True, False])
        self.assertEqual((self.folder / "mix.0003.vdb").stat().st_mtime_ns, kept)
        self.mix("--frames", "1-5", name="whole.####.vdb")
        self.assertEqual(self.frames("mix"), self.frames("whole"))

    def test_a_killed_run_leaves_whole_files(self):
        command = [PROGRAM, *map(str, MIXING), "-o", self.path("mix.####.vdb"), "--frames", "1-200"]
        with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
            limit = time.monotonic() + 60
            while len(self.frames("mix.")) < 2 and time.monotonic() < limit:
                time.sleep(0.01)
            process.send_signal(signal.SIGKILL)
        files = self.frames("mix.0")
        self.mix("--frames", f"1-{len(files)}", name="whole.####.vdb")
        whole = self.frames("whole.0")
        for name, content in files.items():
            self.assertEqual(content, whole[name], name)

    def test_seed_and_threads(self):
        self.mix("--frames", "2", "--threads", 1)
        self.mix("--frames", "2", "--threads", 2, name="two.####.vdb")
        self.mix("--frames", "2", "--seed", 3, name="other.####.vdb")
        self.assertEqual(self.frames("mix"), self.frames("two"))
        self.assertNotEqual(self.frames("mix"), self.frames("other"))

    def test_says_what_is_wrong(self):
        self.assertIn("resolution", self.fail_with(2, "simulate", "mixing", "-o", self.path("m.vdb"), "--resolution", 2))
        self.assertIn("cells wide", self.fail_with(2, *MIXING, "-o", self.path("m.vdb"), "--size", 1, 1, 0.01))
        self.fail_with(2, *MIXING, "-o", self.path("mix.png"))
        self.assertIn("####", self.fail_with(2, *MIXING, "-o", "-"))
        self.assertIn("smaller than a cell", self.fail_with(2, *MIXING, "-o", self.path("m.vdb"), "--inflow-radius", 1e-4))
        self.fail_with(3, "simulate", "mixing", "-o", self.path("m.vdb"), "--memory-limit", "1M")


if __name__ == "__main__":
    unittest.main()
