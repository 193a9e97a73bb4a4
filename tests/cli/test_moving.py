"""Scenes that move: sequences of files, deformations, one box for all frames, resumption, the cache, why stages ran."""

import hashlib
import math
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from program import OCTAHEDRON, PROGRAM, SMALL_SCENE, ProgramCase, octahedron


def stages(report):
    return [s["stage"] for s in report["stages"] if s["key"]]


class TestMoving(ProgramCase):
    def hashes(self, pattern):
        return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(self.folder.glob(pattern))}

    def volume(self, path):
        return self.report("info", path)["files"][0]

    def test_meshes_of_a_sequence(self):
        for frame in (1, 2, 3):
            self.write(f"drop.{frame:04d}.obj", octahedron(scale=.5 + .25 * frame))
        self.write("still.obj", OCTAHEDRON)
        scene = self.write("s.json", {**SMALL_SCENE, "animation": {}, "objects": [{"mesh": "drop.####.obj"}]})
        report = self.report("scene", "mesh", scene, "-o", self.path("out.####.ply"), "--frames", "1-3")
        self.assertEqual(len(report["outputs"]), 3)
        volumes = [self.report("info", self.path(f"out.000{i}.ply"))["files"][0]["signedVolume"] for i in (1, 2, 3)]
        for i, volume in enumerate(volumes):
            self.assertAlmostEqual(volume, (.5 + .25 * (i + 1)) ** 3 / 6, places=6)
        line = self.fail_with(3, "trace", scene, "-o", self.path("t.####.vdb"), "--frames", "3-4")
        self.assertIn("drop.0004.obj", line)
        # A file that is called so is itself, not a sequence.
        self.write("take#2.obj", OCTAHEDRON)
        plain = self.write("p.json", {**SMALL_SCENE, "objects": [{"mesh": "take#2.obj"}]})
        self.succeed("scene", "check", plain)

    def test_all_frames_share_one_box(self):
        moving = {"/objects/0/translate": [[1, [0, 0, 0]], [5, [1, 0, 0]]]}
        scene = self.write_small_scene(animation=moving)
        self.succeed("trace", scene, "-o", self.path("t.####.vdb"), "--frames", "1-5x2")
        boxes = [self.report("info", self.path(f"t.000{i}.vdb")) for i in (1, 3, 5)]
        first = [g for g in boxes[0]["files"][0]["grids"] if g["name"] == "radiance"][0]
        for other in boxes[1:]:
            grid = [g for g in other["files"][0]["grids"] if g["name"] == "radiance"][0]
            self.assertEqual(grid["transform"] if "transform" in grid else grid["voxelSize"],
                             first["transform"] if "transform" in first else first["voxelSize"])
        # With the section `frames`, a frame by itself has that box too: the same bytes.
        scene = self.write_small_scene(animation=moving, frames={"first": 1, "last": 5})
        self.succeed("trace", scene, "-o", self.path("a.####.vdb"), "--frames", "1-5")
        self.succeed("trace", scene, "-o", self.path("b.####.vdb"), "--frames", "4")
        a, b = self.hashes("a.0004.vdb"), self.hashes("b.0004.vdb")
        self.assertEqual(list(a.values()), list(b.values()))

    def test_48_frames_killed_and_resumed_are_the_same_files(self):
        scene = self.write_small_scene(animation={"/lights/0/direction": [[1, [.3, 0, -1]], [48, [-.3, .2, -1]]],
                                                  "/objects/0/rotate": [[1, [0, 0, 0]], [48, [0, 0, 90]]]},
                                       photons={"grid": [48, 48], "jitter": True})
        arguments = ["trace", scene, "-o", self.path("k.####.vdb"), "--frames", "1-48"]
        running = subprocess.Popen([PROGRAM, *arguments, "--quiet"])
        while len(self.hashes("k.*.vdb")) < 10 and running.poll() is None:
            time.sleep(.01)
        running.send_signal(signal.SIGKILL)
        running.wait()
        done = len(list(self.folder.glob("k.????.vdb")))
        self.assertTrue(10 <= done < 48, f"{done} frames before it was killed")
        report = self.report(*arguments, "--resume")
        self.assertGreaterEqual(sum(f["skipped"] for f in report["frames"]), 10)
        self.succeed("trace", scene, "-o", self.path("w.####.vdb"), "--frames", "1-48")
        killed, whole = self.hashes("k.????.vdb"), self.hashes("w.????.vdb")
        self.assertEqual(len(whole), 48)
        self.assertEqual(list(killed.values()), list(whole.values()))

    def test_only_what_changed_runs_again_and_says_why(self):
        turning = {"/camera/position": [[1, [0, -4, 1]], [2, [1, -4, 1]]]}
        report = self.report("render", self.write_small_scene(animation=turning), "-o", self.path("f.####.exr"), "--frames",
                             "1-2")
        self.assertEqual(stages(report), ["medium", "stepField", "photons", "view", "view"])
        self.assertEqual(report["stages"][-2 if report["stages"][-1]["stage"] == "write" else -1]["because"],
                         ["camera/position"])
        done = self.succeed("render", self.path("scene.json"), "-o", self.path("g.####.exr"), "--frames", "1-2", "--verbose")
        self.assertIn("changed: camera/position", done.stderr)

    def test_the_cache_outlives_the_program(self):
        scene = self.write_small_scene(animation={})
        arguments = ["render", scene, "-o", self.path("a.png"), "--cache", self.path("cache")]
        self.assertEqual(stages(self.report(*arguments)), ["medium", "stepField", "photons", "view"])
        shutil.copy(self.path("a.png"), self.path("first.png"))
        report = self.report(*arguments)
        self.assertEqual([(s["stage"], s["fromDisk"]) for s in report["stages"] if s["key"]], [("photons", True), ("view", True)])
        self.succeed("compare", self.path("first.png"), self.path("a.png"))

    def test_a_deformed_object(self):
        twisted = {"mesh": "octahedron.obj", "name": "twisted",
                   "deform": [{"type": "inflate", "center": [0, 0, 0], "radius": 100, "strength": .1}]}
        scene = self.write_small_scene(objects=[twisted], animation={"/objects/0/deform/0/strength": [[1, 0], [2, .1]]})
        self.succeed("scene", "mesh", scene, "-o", self.path("d.####.ply"), "--frames", "1-2")
        still, inflated = (self.report("info", self.path(f"d.000{i}.ply"))["files"][0] for i in (1, 2))
        self.assertAlmostEqual(still["signedVolume"], 1 / 6, places=9)
        # A vertex goes out along its axis by 0.1: the octahedron of radius 0.6.
        self.assertAlmostEqual(inflated["signedVolume"], .6 ** 3 * 4 / 3, places=3)
        report = self.report("trace", scene, "-o", self.path("t.####.vdb"), "--frames", "1-2")
        # Each frame's surface once for the box of all frames, and once for the frame itself.
        self.assertEqual(stages(report).count("surface"), 4)
        report = self.report("trace", scene, "-o", self.path("t.####.vdb"), "--frames", "1-2", "--set",
                             'volume.bounds={"min":[-1,-1,-1],"max":[1,1,1]}')
        self.assertEqual(stages(report).count("surface"), 2)

    def test_what_runs_through_itself_is_reported(self):
        ball = self.path("ball.ply")
        sphere = self.write("ball.json", {"volcaustic": 1, "shape": {"type": "sphere", "radius": .5}})
        self.succeed("shape2mesh", sphere, "-o", ball, "--resolution", "24")
        # The top is pulled down through the bottom, which is held.
        top = {"type": "handle", "center": [0, 0, .5], "radius": .2, "translate": [0, 0, -1.5]}
        bottom = {"type": "handle", "center": [0, 0, -.5], "radius": .2}
        scene = self.write_small_scene(objects=[{"mesh": "ball.ply", "name": "inside out", "deform": [top, bottom]}],
                                       animation={})
        done = self.succeed("scene", "mesh", scene, "-o", self.path("d.ply"))
        self.assertRegex(done.stderr, r"objects \(inside out\): runs through itself in \d+ pairs of triangles")
        self.assertGreater(self.report("info", self.path("d.ply"), "--self-intersections")["files"][0]["selfIntersections"]["pairs"], 10)
        # Still for the cache: the surface is not made again only to be looked at.
        arguments = ["render", scene, "-o", self.path("t.png"), "--cache", self.path("cache")]
        self.assertIn("surface", stages(self.report(*arguments)))
        self.assertNotIn("surface", stages(self.report(*arguments)))

    def test_bad_deformations_are_refused(self):
        for deform, words in [({"type": "twist", "radius": 1}, "/objects/0/deform/0/direction"),
                              ({"type": "smooth", "radius": 1, "strength": 2}, "/objects/0/deform/0/strength"),
                              ({"type": "push", "radius": 0}, "/objects/0/deform/0/radius"),
                              ({"type": "stretch"}, '"stretch" is not known'),
                              ({"type": "handle", "center": [9, 9, 9], "radius": .1}, "no vertex")]:
            scene = self.write_small_scene(objects=[{"mesh": "octahedron.obj", "deform": [deform]}], animation={})
            line = self.fail_with(3, "scene", "mesh", scene, "-o", self.path("d.ply"))
            self.assertIn(words, line, deform)
        self.assertEqual([f for f in self.files() if f.endswith(".ply")], [])


if __name__ == "__main__":
    unittest.main()
