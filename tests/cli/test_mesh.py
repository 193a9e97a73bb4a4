"""mesh2vdb, vdb2mesh, info, compare and convert."""

import json
import os
import signal
import subprocess
import time

from program import OCTAHEDRON, PROGRAM, ProgramCase, octahedron


class MeshToVdb(ProgramCase):
    def setUp(self):
        super().setUp()
        self.mesh = self.write("octahedron.obj", OCTAHEDRON)

    def test_writes_the_four_grids(self):
        report = self.report("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "40", "--ior", "1.7",
                             "--attenuation", "0.3", "0.2", "0.1", "--scattering", "0.1", "0.1", "0.1", "--asymmetry", "-0.5")
        self.assertEqual(report["command"], "mesh2vdb")
        self.assertEqual(report["outputs"], [self.path("o.vdb")])
        self.assertEqual({s["stage"] for s in report["stages"]}, {"read", "check", "medium", "write"})
        self.assertGreater(report["peakMemoryBytes"], 1 << 20)
        self.assertEqual(report["counts"][0]["triangles"], 8)
        grids = {g["name"]: g for g in self.report("info", self.path("o.vdb"))["files"][0]["grids"]}
        self.assertLessEqual({"index", "attenuation", "scattering", "coverage"}, set(grids))
        self.assertAlmostEqual(grids["index"]["maximum"], 1.7, delta=1e-3)
        self.assertAlmostEqual(grids["index"]["voxelSize"][0], 1 / 40, delta=1e-7)
        self.assertAlmostEqual(grids["coverage"]["maximum"], 1, delta=1e-6)
        volume = grids["coverage"]["mean"] * grids["coverage"]["activeVoxels"] / 40**3
        self.assertAlmostEqual(volume, 1 / 6, delta=0.01 / 6)

    def test_several_meshes(self):
        other = self.write("other.obj", OCTAHEDRON)
        self.succeed("mesh2vdb", self.mesh, other, "-o", self.path("new_{}.vdb"), "--resolution", "16")
        self.succeed("mesh2vdb", self.mesh, other, "-o", self.path("a.vdb"), "-o", self.path("b.vdb"), "--resolution", "16")
        (self.folder / "sub").mkdir()
        self.succeed("mesh2vdb", self.mesh, other, "-o", self.path("sub"), "--resolution", "16")
        self.assertEqual(sorted(os.listdir(self.path("sub"))), ["octahedron.vdb", "other.vdb"])
        self.assertLessEqual({"new_octahedron.vdb", "new_other.vdb", "a.vdb", "b.vdb"}, set(self.files()))
        self.succeed("compare", self.path("a.vdb"), self.path("b.vdb"))

    def test_a_bad_mesh_does_not_lose_the_others(self):
        bad = self.write("bad.obj", "v 0 0 x\n")
        done = self.call("mesh2vdb", bad, self.mesh, self.path("nothing.ply"), "-o", self.path("{}.vdb"),
                         "--resolution", "16", "--quiet", "--json")
        self.assertEqual(done.returncode, 3)
        lines = done.stderr.splitlines()
        self.assertEqual([line.split(":")[0] for line in lines], [bad, self.path("nothing.ply")])
        counts = json.loads(done.stdout)["counts"]
        self.assertEqual(["error" in entry for entry in counts], [True, False, True])
        self.assertEqual(self.files(), ["bad.obj", "octahedron.obj", "octahedron.vdb"])

    def test_resume_leaves_what_is_there(self):
        self.succeed("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "16")
        before = os.stat(self.path("o.vdb")).st_mtime_ns
        report = self.report("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "24", "--resume")
        self.assertTrue(report["counts"][0]["skipped"])
        self.assertEqual(os.stat(self.path("o.vdb")).st_mtime_ns, before)

    def test_memory_does_not_grow_with_the_number_of_files(self):
        meshes = [self.write(f"m{i}.obj", octahedron(1 + i / 1000)) for i in range(100)]
        one = self.report("mesh2vdb", meshes[-1], "-o", self.path("one.vdb"), "--resolution", "96")
        every = self.report("mesh2vdb", *meshes, "-o", self.path("{}.vdb"), "--resolution", "96")
        self.assertLess(every["peakMemoryBytes"], 1.25 * one["peakMemoryBytes"] + (8 << 20))

    def test_standard_input_is_recognised_by_content(self):
        self.succeed("mesh2vdb", self.mesh, "-o", self.path("file.vdb"), "--resolution", "16")
        for extension in ("obj", "ply", "stl", "off"):
            with self.subTest(extension=extension):
                self.succeed("convert", self.mesh, self.path("m." + extension))
                with open(self.path("m." + extension), "rb") as mesh, open(self.path("pipe.vdb"), "wb") as volume:
                    command = [PROGRAM, "mesh2vdb", "-", "-o", "-", "--resolution", "16"]
                    self.assertEqual(subprocess.run(command, stdin=mesh, stdout=volume, timeout=60).returncode, 0)
                self.succeed("compare", self.path("file.vdb"), self.path("pipe.vdb"))
        line = self.fail_with(3, "mesh2vdb", "-", "-o", self.path("o.vdb"), input="")
        self.assertTrue(line.startswith("<stdin>: "), line)

    def test_the_box_can_be_given(self):
        entry = self.report("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "40", "--padding", "0",
                            "--bounds", "-1", "-1", "-1", "1", "1", "3")["counts"][0]
        self.assertEqual(entry["dims"], [20, 20, 40])
        done = self.succeed("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--bounds", "0", "0", "0", "1", "1", "1")
        self.assertIn("sticks out", done.stderr)
        self.fail_with(2, "mesh2vdb", self.mesh, "-o", self.path("p.vdb"), "--bounds", "1", "0", "0", "0", "1", "1")

    def test_the_report_says_which_fill_and_why(self):
        entry = self.report("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "64")["counts"][0]
        self.assertEqual([(b["fill"], b["shellCount"]) for b in entry["bodies"]], [("exact", 1)])
        self.assertLess(abs(entry["coveredVolume"] * 6 - 1), 5e-4)
        self.assertLess(abs(entry["volumeDifference"]), 5e-4)
        self.assertEqual(set(entry["ms"]), {"read", "check", "medium", "write"})
        opened = self.write("open.obj", OCTAHEDRON.replace("f 1 4 6\n", ""))
        done = self.succeed("mesh2vdb", opened, "-o", self.path("o.vdb"), "--resolution", "32", "--json")
        body = json.loads(done.stdout)["counts"][0]["bodies"][0]
        self.assertEqual((body["fill"], body["openEdges"]), ("winding", 3))
        self.assertIn("3 open", done.stderr)

    def test_an_interrupt_leaves_nothing_half_written(self):
        child = subprocess.Popen([PROGRAM, "mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "3000",
                                  "--memory-limit", "64G"], stderr=subprocess.PIPE, text=True)
        time.sleep(0.7)
        child.send_signal(signal.SIGINT)
        _, words = child.communicate(timeout=60)
        self.assertEqual(child.returncode, 130, words)
        self.assertEqual(self.files(), ["octahedron.obj"])

    def test_standard_output_is_data(self):
        done = subprocess.run([PROGRAM, "mesh2vdb", self.mesh, "-o", "-", "--resolution", "16"], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.folder / "out.vdb").write_bytes(done.stdout)
        self.succeed("mesh2vdb", self.mesh, "-o", self.path("file.vdb"), "--resolution", "16")
        self.succeed("compare", self.path("out.vdb"), self.path("file.vdb"))

    def test_the_same_bits_for_every_number_of_threads(self):
        for threads in (1, 2):
            self.succeed("mesh2vdb", self.mesh, "-o", self.path(f"{threads}.vdb"), "--threads", threads)
        self.succeed("compare", self.path("1.vdb"), self.path("2.vdb"))

    def test_a_target_that_cannot_be_written_is_left_alone(self):
        line = self.fail_with(3, "mesh2vdb", self.mesh, "-o", self.path("no/where.vdb"), "--resolution", "16")
        self.assertTrue(line.startswith(self.path("no/where.vdb") + ": "), line)

    def test_the_memory_limit_is_kept(self):
        line = self.fail_with(3, "mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "4096", "--memory-limit", "64M")
        self.assertIn("--memory-limit", line)
        self.assertEqual(self.files(), ["octahedron.obj"])


class SeveralBodies(ProgramCase):
    """A small octahedron of one material within a large one of another."""

    LARGE, SMALL = 1 / 6, 0.5**3 / 6

    def index_sum(self, file):
        """Sum of n - 1 times the volume of a voxel."""
        grid = next(g for g in self.report("info", file)["files"][0]["grids"] if g["name"] == "index")
        return (grid["mean"] - 1) * grid["activeVoxels"] * grid["voxelSize"][0] ** 3

    def write_nested(self):
        return self.write("nested.obj", octahedron(material="glass") + octahedron(0.5, first_vertex=7, material="wine"))

    def test_groups_have_materials_of_their_own(self):
        done = self.succeed("mesh2vdb", self.write_nested(), "-o", self.path("o.vdb"), "--resolution", "64",
                            "--blur", "1", "--ior", "1.5", "--attenuation", "0.1", "0.1", "0.1", "--json",
                            "--group", "wine:ior=1.25,priority=1,attenuation=2/3/4")
        bodies = json.loads(done.stdout)["counts"][0]["bodies"]
        self.assertEqual([(b["index"], b["priority"]) for b in bodies], [(1.5, 0), (1.25, 1)])
        expected = 0.5 * (self.LARGE - self.SMALL) + 0.25 * self.SMALL
        self.assertAlmostEqual(self.index_sum(self.path("o.vdb")) / expected, 1, delta=2e-3)
        grids = {g["name"]: g for g in self.report("info", self.path("o.vdb"))["files"][0]["grids"]}
        self.assertAlmostEqual(grids["attenuation"]["maximum"], 29**0.5, delta=1e-4)

    def test_a_slip_in_a_group_is_wrong_usage(self):
        mesh = self.write_nested()
        for text, said in [("wnie:ior=1.3", "wine"), ("wine:iro=1.3", "attenuation"), ("wine:ior=abc", "ior=abc"),
                           ("wine:ior=99", "ior=99"), ("wine", "NAME"), ("wine:scattering=1", "attenuation"),
                           ("wine:attenuation=1/2", "attenuation=1/2"), ("wine:priority=0.5", "priority=0.5")]:
            with self.subTest(text=text):
                self.assertIn(said, self.fail_with(2, "mesh2vdb", mesh, "-o", self.path("o.vdb"), "--group", text))
        self.assertEqual(self.files(), ["nested.obj"])

    def test_a_scene_becomes_one_volume(self):
        self.write("octahedron.obj", OCTAHEDRON)
        scene = self.write("scene.json", {
            "volcaustic": 1, "volume": {"resolution": 64, "margin": 0.1}, "voxelise": {"blur": 1},
            "materials": {"glass": {"index": 1.5}, "wine": {"index": 1.25}},
            "objects": [{"mesh": "octahedron.obj"},
                        {"mesh": "octahedron.obj", "material": "wine", "priority": 1, "scale": [0.5, 0.5, 0.5]}]})
        entry = self.report("mesh2vdb", scene, "-o", self.path("o.vdb"))["counts"][0]
        self.assertEqual(entry["objects"], 2)
        expected = 0.5 * (self.LARGE - self.SMALL) + 0.25 * self.SMALL
        self.assertAlmostEqual(self.index_sum(self.path("o.vdb")) / expected, 1, delta=2e-3)
        self.succeed("mesh2vdb", scene, "-o", self.path("p.vdb"), "--set", "volume.resolution=32")
        self.assertIn("--ior", self.fail_with(2, "mesh2vdb", scene, "-o", self.path("p.vdb"), "--ior", "1.3"))
        self.fail_with(2, "mesh2vdb", self.path("octahedron.obj"), "-o", self.path("p.vdb"), "--set", "voxelise.blur=1")


class ThereAndBack(ProgramCase):
    def setUp(self):
        super().setUp()
        self.mesh = self.write("octahedron.obj", OCTAHEDRON)
        self.succeed("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "64")

    def test_vdb2mesh_gives_the_mesh_again(self):
        for extension in ("obj", "ply", "stl", "off"):
            with self.subTest(extension=extension):
                back = self.path("back." + extension)
                self.succeed("vdb2mesh", self.path("o.vdb"), "-o", back)
                info = self.report("info", back)["files"][0]
                self.assertTrue(info["closed"])
                self.assertAlmostEqual(info["signedVolume"], 1 / 6, delta=0.01 / 6)

    def test_vdb2mesh_names_the_grids_there_are(self):
        line = self.fail_with(3, "vdb2mesh", self.path("o.vdb"), "-o", self.path("b.ply"), "--grid", "covrage")
        self.assertTrue(line.startswith(self.path("o.vdb") + ":"), line)
        self.assertIn("coverage", line)

    def test_compare_has_a_threshold(self):
        self.succeed("mesh2vdb", self.mesh, "-o", self.path("p.vdb"), "--resolution", "64", "--ior", "1.6")
        a, b = self.path("o.vdb"), self.path("p.vdb")
        self.assertEqual(self.call("compare", a, a).returncode, 0)
        self.assertEqual(self.call("compare", a, b).returncode, 1)
        self.assertEqual(self.call("compare", a, b, "--threshold", "0.101").returncode, 0)
        done = self.call("compare", a, b, "--json")
        report = json.loads(done.stdout)
        self.assertFalse(report["within"])
        index = next(d for d in report["differences"] if d["name"] == "index")
        self.assertAlmostEqual(index["maximum"], 0.1, delta=1e-4)
        self.succeed("compare", self.mesh, self.mesh)
        self.assertEqual(self.call("compare", self.mesh, self.write("t.obj", OCTAHEDRON.replace("0.5", "0.6"))).returncode, 1)
        self.fail_with(3, "compare", a, self.mesh)

    def test_convert_and_back(self):
        self.succeed("convert", self.path("o.vdb"), self.path("o.nvdb"))
        self.succeed("convert", self.path("o.nvdb"), self.path("again.vdb"))
        self.succeed("compare", self.path("o.vdb"), self.path("again.vdb"))
        self.succeed("convert", self.mesh, self.path("o.ply"))
        self.succeed("compare", self.mesh, self.path("o.ply"))

    def test_info_prints_tables(self):
        text = self.succeed("info", self.path("o.vdb"), self.mesh).stdout
        for part in ["index", "coverage", "8 triangles", "signed volume"]:
            self.assertIn(part, text)
        self.fail_with(3, "info", self.write("words.txt", "words"))
        self.fail_with(3, "info", self.path("nothing.vdb"))
