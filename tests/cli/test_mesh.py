"""mesh2vdb, vdb2mesh, info, compare and convert."""

import json
import os
import subprocess

from program import OCTAHEDRON, PROGRAM, ProgramCase


class MeshToVdb(ProgramCase):
    def setUp(self):
        super().setUp()
        self.mesh = self.write("octahedron.obj", OCTAHEDRON)

    def test_writes_the_four_grids(self):
        report = self.report("mesh2vdb", self.mesh, "-o", self.path("o.vdb"), "--resolution", "40", "--ior", "1.7",
                             "--attenuation", "0.3", "0.2", "0.1", "--scattering", "0.1", "0.1", "0.1", "--asymmetry", "-0.5")
        self.assertEqual(report["command"], "mesh2vdb")
        self.assertEqual(report["outputs"], [self.path("o.vdb")])
        self.assertEqual({s["stage"] for s in report["stages"]}, {"read", "medium", "write"})
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
