"""info: what it prints for files of every kind, and its report."""

import json
import pathlib

from program import OCTAHEDRON, SHARED, ProgramCase


def cube(radius, first, name="", inwards=False):
    """A cube around the origin in OBJ, its vertices numbered from `first`."""
    lines = [f"v {radius * (2 * (i & 1) - 1)} {radius * ((i & 2) - 1)} {radius * ((i & 4) / 2 - 1)}" for i in range(8)]
    lines += [name] if name else []
    for face in [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]:
        lines.append("f " + " ".join(str(v + first) for v in (reversed(face) if inwards else face)))
    return "\n".join(lines) + "\n"


class Meshes(ProgramCase):
    def entry(self, path):
        return self.report("info", path)["files"][0]

    def test_a_shell_inside_another_says_why_it_is_solid(self):
        mesh = self.write("bottle.obj", cube(2, 1) + cube(1, 9))
        text = self.succeed("info", mesh).stdout
        for part in ["16 vertices, 24 triangles, closed", "shells         2, of which 2 closed", "immersed",
                     "reverse the inner", "--fill auto    exact: closed and consistently wound"]:
            self.assertIn(part, text)
        entry = self.entry(mesh)
        self.assertEqual([s["role"] for s in entry["shells"]], ["body", "immersed"])
        self.assertEqual(entry["shells"][1]["enclosedBy"], 0)
        self.assertEqual(entry["immersedShells"], 1)
        self.assertEqual(len(entry["remarks"]), 1)

        hollow = self.entry(self.write("hollow.obj", cube(2, 1) + cube(1, 9, inwards=True)))
        self.assertEqual([s["role"] for s in hollow["shells"]], ["body", "cavity"])
        self.assertAlmostEqual(hollow["signedVolume"], 64 - 8, places=9)

    def test_the_fill_and_its_reason(self):
        entry = self.entry(self.write("whole.obj", OCTAHEDRON))
        self.assertEqual((entry["fill"], entry["fillReason"]), ("exact", "closed and consistently wound"))
        self.assertEqual(entry["remarks"], [])
        lines = OCTAHEDRON.splitlines()
        flipped = lines[:-1] + ["f " + " ".join(reversed(lines[-1].split()[1:]))]
        entry = self.entry(self.write("flipped.obj", "\n".join(flipped)))
        self.assertEqual((entry["fill"], entry["flippedFaces"], entry["inconsistentEdges"]), ("winding", 1, 3))
        self.assertEqual(entry["fillReason"], "3 inconsistently wound edges (1 flipped face)")
        parts = cube(9, 1) + cube(1, 9).replace("f 9 11 12 10", "f 10 12 11 9")
        self.assertIn("misoriented", self.succeed("info", self.write("two.obj", parts)).stdout)

    def test_where_a_surface_runs_through_itself(self):
        sound = self.write("nested.obj", cube(2, 1) + cube(1, 9))
        self.assertIn("through itself nowhere", self.succeed("info", "--self-intersections", sound).stdout)
        self.assertNotIn("selfIntersections", self.entry(sound))
        # The second cube reaches out of a face of the first: 4 of its walls cross two triangles at least.
        shifted = "\n".join(f"v {float(x) + 1.5} {y} {z}" for _, x, y, z in
                            (line.split() for line in cube(1, 1).splitlines() if line.startswith("v ")))
        faces = "\n".join(line for line in cube(1, 9).splitlines() if line.startswith("f "))
        mesh = self.write("through.obj", cube(2, 1) + shifted + "\n" + faces + "\n")
        found = self.report("info", "--self-intersections", mesh)["files"][0]["selfIntersections"]
        self.assertGreaterEqual(found["pairs"], 8)
        self.assertEqual(len(found["examples"]), found["pairs"])
        self.assertEqual(found["bounds"]["max"][0], 2.5)
        text = self.succeed("info", "--self-intersections", mesh).stdout
        self.assertIn(f"through itself {found['pairs']} pairs of triangles, in (", text)
        self.assertIn("{} and {}".format(*found["examples"][0]), text)

    def test_groups_with_their_triangles(self):
        mesh = self.write("goblet.obj", cube(2, 1, "usemtl glass") + cube(1, 9, "usemtl red wine"))
        glass, wine = self.entry(mesh)["groups"]
        self.assertEqual((glass["name"], glass["triangles"], glass["closed"]), ("glass", 12, True))
        self.assertAlmostEqual(wine["signedVolume"], 8, places=9)
        self.assertRegex(self.succeed("info", mesh).stdout, r"red wine +12 +8 +yes\n")
        split = self.entry(self.write("split.obj", cube(2, 1).replace("f 3 7", "usemtl label\nf 3 7")))
        self.assertEqual([g["closed"] for g in split["groups"]], [False, False])
        self.assertEqual(self.entry(self.write("o.obj", OCTAHEDRON))["groups"], [])


class Scenes(ProgramCase):
    def test_prints_its_parts_with_units(self):
        self.write("goblet.obj", cube(2, 1, "o glass") + cube(1, 9, "o wine"))
        scene = self.write_small_scene(
            objects=[{"name": "cup", "mesh": "goblet.obj", "groups": [{"name": "wine", "material": "wine"}]}],
            materials={"glass": {"index": 1.5}, "wine": {"index": 1.34, "attenuation": [1, 2, 3]}})
        text = self.succeed("info", scene).stdout
        for part in ["1 objects, 2 materials", "wine: wine", "1.34", "1 2 3", "[1/world]", "W/m2", "24 voxels along"]:
            self.assertIn(part, text)
        groups = self.report("info", scene)["files"][0]["scene"]["objects"][0]["groups"]
        self.assertEqual(groups, [{"name": "wine", "material": "wine", "priority": 0}])

    def test_a_group_that_is_not_in_the_mesh_is_one_line(self):
        self.write("goblet.obj", cube(2, 1, "o glass") + cube(1, 9, "o wine"))
        scene = self.write_small_scene(objects=[{"mesh": "goblet.obj", "groups": [{"name": "wnie", "material": "glass"}]}])
        line = self.fail_with(3, "trace", scene, "-o", self.path("out.vdb"), "--quiet")
        self.assertEqual(line, 'goblet.obj: no group is called "wnie"; the nearest known one is "wine"')
        self.assertNotIn("out.vdb", self.files())


class Volumes(ProgramCase):
    def test_one_line_of_values_and_one_of_place_for_each_grid(self):
        self.succeed("mesh2vdb", self.write("o.obj", OCTAHEDRON), "-o", self.path("o.vdb"), "--resolution", "20")
        lines = self.succeed("info", self.path("o.vdb")).stdout.splitlines()
        rows = [line.split() for line in lines if line.split()[0] == "coverage"]
        self.assertEqual(len(rows), 2)
        self.assertEqual(rows[0][1:4], ["float", "fog", "volume"])
        self.assertEqual(rows[1][1:3], ["0.05", "aligned"])

    def test_voxels_that_are_no_cubes_have_three_sizes(self):
        volume = self.need(SHARED / "data/vdb/densityAndHeat.vdb")
        self.assertIn("0.703377 x 0.703377 x 0.716455", self.succeed("info", volume).stdout)

    def test_points_have_no_values(self):
        volume = self.need(SHARED / "data/vdb/pointgrid.vdb")
        self.assertRegex(self.succeed("info", volume).stdout, r"points +ptdataidx32 .* - +- +-\n")


class ManyFiles(ProgramCase):
    def test_a_damaged_file_does_not_keep_the_others_back(self):
        good = self.write("good.obj", OCTAHEDRON)
        bad = self.write("bad.obj", "f 1 2 3\n")
        done = self.call("info", good, bad, good)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertTrue(done.stderr.startswith(bad + ":1: "), done.stderr)
        self.assertEqual(done.stdout.count("8 triangles"), 2)
        self.assertTrue(done.stdout.endswith("3 files: 2 meshes (2 closed), 1 not readable\n"), done.stdout)
        files = json.loads(self.call("info", good, bad, "--json").stdout)["files"]
        self.assertTrue(files[1]["error"].startswith(bad + ":1: "))

    def test_every_shared_file_is_described_in_lines_that_fit(self):
        data = self.need(SHARED / "data")
        files = [p for folder in ["meshes_clean", "meshes_messy", "meshes_quirky", "vdb", "env", "malformed", "vdb_bad"]
                 for p in sorted((data / folder).iterdir()) if p.is_file()]
        done = self.call("info", *files, timeout=300)
        self.assertEqual(done.returncode, 3)
        for line in done.stdout.splitlines() + done.stderr.splitlines():
            if not line.startswith(str(data)):
                self.assertLess(len(line), 125, line)
        entries = json.loads(self.call("info", *files, "--json", timeout=300).stdout)["files"]
        self.assertEqual([pathlib.Path(e["file"]) for e in entries], files)
        self.assertEqual(sum("error" in e for e in entries), len(done.stderr.splitlines()))
        for entry in entries:
            if "meshes_clean" in entry["file"]:
                self.assertEqual(entry["fill"], "exact", entry["file"])
            if "malformed" in entry["file"]:
                self.assertIn("error", entry, entry["file"])
