"""convert and vdb2mesh with volumes made by others: every real one, every damaged one, and what they become."""

import os
import shutil
import time

from program import PROGRAM, SHARED, ProgramCase

MOST_SECONDS = 20
MOST_BYTES = 1 << 30


class ForeignVolumes(ProgramCase):
    def volume(self, name):
        return self.need(SHARED / "data" / "vdb" / name)

    def grids(self, path):
        return {g["name"]: g for g in self.report("info", path)["files"][0]["grids"]}

    def test_a_simulation_becomes_a_medium_that_traces(self):
        smoke = self.volume("densityAndHeat.vdb")
        source = self.grids(smoke)["density"]
        report = self.report("convert", smoke, self.path("medium.vdb"), "--attenuation", "density:scale=2",
                             "--scattering", "density:scale=1.8/1.6/1.2", "--index", "heat:scale=1e-4,offset=1.0003")
        self.assertEqual(report["outputs"], [self.path("medium.vdb")])
        grids = self.grids(self.path("medium.vdb"))
        self.assertLessEqual({"index", "attenuation", "scattering"}, set(grids))
        length = source["maximum"] * 2 * 3 ** 0.5
        self.assertAlmostEqual(grids["attenuation"]["maximum"], length, delta=1e-4 * length)
        self.assertAlmostEqual(report["voxelSize"], source["voxelSize"][0], delta=1e-9)
        scene = {"volcaustic": 1, "volume": {"file": "medium.vdb"}, "lights": [{"direction": [0, 0, -1]}],
                 "photons": {"grid": [32, 32]}}
        self.succeed("trace", self.write("scene.json", scene), "-o", self.path("light.vdb"))
        self.assertGreater(self.grids(self.path("light.vdb"))["radiance"]["maximum"], 0)

    def test_a_level_set_becomes_a_body(self):
        report = self.report("convert", self.volume("sphere_v222.vdb"), self.path("body.vdb"), "--body",
                             "ls_sphere:ior=1.5,attenuation=0.1/0.2/0.3", "--blur", "5", "--voxel-size", "0.2")
        self.assertAlmostEqual(report["voxelSize"], 0.2)
        grids = self.grids(self.path("body.vdb"))
        self.assertAlmostEqual(grids["index"]["maximum"], 1.5, delta=1e-3)
        self.assertAlmostEqual(grids["coverage"]["maximum"], 1, delta=1e-6)

    def test_a_sequence_of_level_sets_is_a_liquid(self):
        small, large = self.volume("sphere_v222.vdb"), self.volume("sphere_fog_v223.vdb")
        for frame, source in ((1, small), (2, small), (3, small)):
            shutil.copy(source, self.path(f"liquid.{frame:04d}.vdb"))
        arguments = ["convert", self.path("liquid.####.vdb"), self.path("body.####.vdb"), "--frames", "1-3x2", "--body",
                     "ls_sphere:ior=1.33", "--voxel-size", "0.4"]
        self.assertEqual([os.path.basename(f) for f in self.report(*arguments)["outputs"]], ["body.0001.vdb", "body.0003.vdb"])
        before = os.stat(self.path("body.0001.vdb")).st_mtime_ns
        os.remove(self.path("body.0003.vdb"))
        self.succeed(*arguments, "--resume")
        self.assertEqual(os.stat(self.path("body.0001.vdb")).st_mtime_ns, before)
        scene = {"volcaustic": 1, "volume": {"file": "body.####.vdb"}, "lights": [{"direction": [0, 0, -1]}],
                 "photons": {"grid": [32, 32]}}
        self.succeed("trace", self.write("scene.json", scene), "-o", self.path("light.####.vdb"), "--frames", "1-3x2")
        self.assertGreater(self.grids(self.path("light.0003.vdb"))["radiance"]["maximum"], 0)
        self.assertIn("body.0002.vdb", self.fail_with(3, "trace", self.path("scene.json"), "-o", self.path("l.####.vdb"),
                                                      "--frames", "2"))
        report = self.report("vdb2mesh", self.path("liquid.####.vdb"), "-o", self.path("m.####.ply"), "--frames", "1-2")
        self.assertEqual(len(report["counts"]), 2)
        self.assertTrue(os.path.exists(self.path("m.0002.ply")))
        self.assertIn("no place", self.fail_with(2, "convert", large, self.path("x.####.nvdb"), "--frames", "1-2"))
        self.assertIn("--frames", self.fail_with(2, "vdb2mesh", large, "-o", self.path("x.####.ply")))

    def test_every_volume_there_and_back(self):
        for volume in sorted(self.need(SHARED / "data" / "vdb").iterdir()):
            if volume.name == "pointgrid.vdb":
                continue
            with self.subTest(volume=volume.name):
                self.succeed("convert", volume, self.path("copy.vdb"))
                self.succeed("convert", self.path("copy.vdb"), self.path("nano.nvdb"))
                self.succeed("convert", self.path("nano.nvdb"), self.path("back.vdb"))
                self.succeed("compare", self.path("copy.vdb"), self.path("back.vdb"))
                before, after = self.grids(volume), self.grids(self.path("copy.vdb"))
                self.assertEqual(set(before), set(after))
                for name, grid in before.items():
                    for key in ("type", "class", "voxelSize", "activeVoxels"):
                        self.assertEqual(grid.get(key), after[name].get(key), (name, key))

    def test_points_are_refused_by_name(self):
        points = self.volume("pointgrid.vdb")
        for arguments in (["convert", points, self.path("p.nvdb")], ["vdb2mesh", points, "-o", self.path("p.ply")],
                          ["convert", points, self.path("p.vdb"), "--attenuation", "points"]):
            self.assertIn("points", self.fail_with(3, *arguments))
        self.assertEqual(self.files(), [])

    def test_wrong_words(self):
        smoke = self.volume("densityAndHeat.vdb")
        out = self.path("m.vdb")
        self.assertIn("density", self.fail_with(3, "convert", smoke, out, "--attenuation", "densty"))
        self.assertIn("scale, offset", self.fail_with(2, "convert", smoke, out, "--attenuation", "density:factor=2"))
        self.fail_with(2, "convert", smoke, out, "--attenuation", "density:scale=much")
        self.fail_with(3, "convert", smoke, out, "--scattering", "density:scale=2", "--attenuation", "density:scale=1")
        self.fail_with(2, "convert", smoke, out, "--body", "density:ior=-1")
        self.assertEqual(self.files(), [])

    def test_vdb2mesh_of_a_named_grid(self):
        self.succeed("vdb2mesh", self.volume("densityAndHeat.vdb"), "-o", self.path("s.ply"), "--grid", "density",
                     "--isovalue", "0.1", "--adaptivity", "0.3")
        self.assertTrue(self.report("info", self.path("s.ply"))["files"][0]["closed"])


class DamagedVolumes(ProgramCase):
    def test_every_file_through_every_command(self):
        commands = (["info"], ["convert", "OUT.vdb"], ["convert", "OUT.vdb", "--attenuation", "density"],
                    ["vdb2mesh", "-o", "OUT.ply"])
        for volume in sorted(self.need(SHARED / "data" / "vdb_bad").iterdir()):
            for command in commands:
                with self.subTest(volume=volume.name, command=command):
                    self.check(volume, [command[0], str(volume), *(w.replace("OUT", self.path("out")) for w in command[1:])])

    def check(self, volume, arguments):
        """Runs the program itself, so that wait4 tells what this one process took. A file may be sound after all."""
        with open(self.path("stderr"), "w+") as words:
            start = time.monotonic()
            actions = [(os.POSIX_SPAWN_DUP2, words.fileno(), 2), (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
            child = os.posix_spawn(PROGRAM, [PROGRAM, *arguments], os.environ, file_actions=actions)
            _, status, usage = os.wait4(child, 0)
            seconds = time.monotonic() - start
            words.seek(0)
            lines = words.read().splitlines()
        code = os.waitstatus_to_exitcode(status)
        self.assertIn(code, (0, 3), lines)
        if code == 3:
            self.assertEqual(len(lines), 1, lines)
            self.assertTrue(lines[0].startswith(f"{volume}:"), lines)
        self.assertLess(seconds, MOST_SECONDS)
        self.assertLess(usage.ru_maxrss * 1024, MOST_BYTES)
