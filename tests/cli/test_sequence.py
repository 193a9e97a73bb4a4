"""mesh2vdb over the frames of a sequence: one lattice, resumption, and what stops it."""

import os
import re

from program import ProgramCase, octahedron


class Sequence(ProgramCase):
    """An octahedron that grows and wanders."""

    FRAMES = (1, 2, 3)

    def setUp(self):
        super().setUp()
        for frame in self.FRAMES:
            self.write(f"body.{frame:04d}.obj", octahedron(0.5 + frame / 4, (frame / 8, 0, 0)))
        self.pattern = self.path("body.####.obj")

    def domains(self, report):
        """Corner, voxel size and dimensions of the volumes, as their files tell them: one for all, if they agree."""
        self.assertEqual([entry["frame"] for entry in report["counts"]], list(self.FRAMES))
        keys = {"volcaustic_min_corner", "volcaustic_voxel_size", "volcaustic_dims"}
        metadata = [self.report("info", entry["output"])["files"][0]["metadata"] for entry in report["counts"]]
        domains = {tuple(sorted((k, v) for k, v in m.items() if k in keys)) for m in metadata}
        return domains, report["counts"]

    def test_every_frame_has_the_same_lattice(self):
        report = self.report("mesh2vdb", self.pattern, "-o", self.path("v.####.vdb"), "--frames", "1-3",
                             "--resolution", "40")
        domains, counts = self.domains(report)
        self.assertEqual(len(domains), 1, domains)
        self.assertEqual(len(next(iter(domains))), 3, domains)
        self.assertEqual(len({tuple(entry["dims"]) for entry in counts}), 1)
        # The box of all frames: x from 0.125 - 0.375 to 0.375 + 0.625, so 1.25 is the longest side.
        self.assertAlmostEqual(counts[0]["voxelSize"], 1.25 / 40, delta=1e-12)
        for frame, entry in zip(self.FRAMES, counts):
            self.assertAlmostEqual(entry["coveredVolume"] / ((0.5 + frame / 4) ** 3 / 6), 1, delta=2e-3)
        self.assertEqual([name for name in self.files() if name.endswith(".vdb")],
                         [f"v.{frame:04d}.vdb" for frame in self.FRAMES])

    def test_progress_in_lines(self):
        done = self.succeed("mesh2vdb", self.pattern, "-o", self.path("v.####.vdb"), "--frames", "1-3", "--progress", "--quiet")
        before = re.compile(r"^progress: 1/1 bounds [01]\.\d{3}$")  # of all files
        lines = [line for line in done.stderr.splitlines() if not before.match(line)]
        files = []
        for line in lines:
            self.assertRegex(line, r"^progress: [1-3]/3 [a-z ]+ [01]\.\d{3}$")
            files.append(int(line.split()[1].split("/")[0]))
            self.assertLessEqual(float(line.split()[-1]), 1)
        self.assertEqual(files, sorted(files))
        self.assertEqual(set(files), {1, 2, 3})

    def test_a_part_of_the_frames_on_a_given_box(self):
        box = ["--bounds", "-1", "-1", "-1", "1", "1", "1", "--resolution", "16"]
        self.succeed("mesh2vdb", self.pattern, "-o", self.path("v.%03d.vdb"), "--frames", "1-3x2", *box)
        self.assertEqual([name for name in self.files() if name.endswith(".vdb")], ["v.001.vdb", "v.003.vdb"])
        os.remove(self.path("body.0002.obj"))
        done = self.call("mesh2vdb", self.pattern, "-o", self.path("w.####.vdb"), "--frames", "1-3", *box)
        self.assertEqual(done.returncode, 3)
        self.assertIn(self.path("body.0002.obj") + ": ", done.stderr)
        self.assertEqual([name for name in self.files() if name.startswith("w.")], ["w.0001.vdb", "w.0003.vdb"])

    def test_resume_makes_what_is_missing_on_the_same_lattice(self):
        arguments = ["mesh2vdb", self.pattern, "-o", self.path("v.####.vdb"), "--frames", "1-3", "--resolution", "24"]
        whole, _ = self.domains(self.report(*arguments))
        kept = os.stat(self.path("v.0001.vdb")).st_mtime_ns
        os.remove(self.path("v.0002.vdb"))
        report = self.report(*arguments, "--resume")
        self.assertEqual([entry["skipped"] for entry in report["counts"]], [True, False, True])
        self.assertEqual(os.stat(self.path("v.0001.vdb")).st_mtime_ns, kept)
        self.assertEqual(self.domains(report)[0], whole)

    def test_a_missing_frame_leaves_no_lattice_to_agree_on(self):
        line = self.fail_with(3, "mesh2vdb", self.pattern, "-o", self.path("v.####.vdb"), "--frames", "1-4")
        self.assertTrue(line.startswith(self.path("body.0004.obj") + ": "), line)
        self.assertFalse([name for name in self.files() if name.endswith(".vdb")])

    def test_several_sequences_into_a_folder(self):
        for frame in self.FRAMES:
            self.write(f"other_{frame}.obj", octahedron(2))
        os.mkdir(self.path("out"))
        self.succeed("mesh2vdb", self.pattern, self.path("other_#.obj"), "-o", self.path("out"), "--frames", "1-3",
                     "--resolution", "16")
        expected = [f"body.{frame:04d}.vdb" for frame in self.FRAMES] + [f"other_{frame}.vdb" for frame in self.FRAMES]
        self.assertEqual(sorted(os.listdir(self.path("out"))), expected)

    def test_a_scene_moves_by_its_own_tracks(self):
        self.write("body.obj", octahedron())
        scene = self.write("scene.json", {
            "volcaustic": 1, "volume": {"bounds": {"min": [-1, -1, -1], "max": [1, 1, 1]}, "resolution": 32},
            "objects": [{"mesh": "body.obj"}],
            "animation": {"/objects/0/scale": [[1, [1, 1, 1]], [3, [0.5, 0.5, 0.5]]]}})
        report = self.report("mesh2vdb", scene, "-o", self.path("s.vdb"), "--frames", "1-3x2")
        small, large = sorted(entry["coveredVolume"] for entry in report["counts"])
        self.assertAlmostEqual(small / large, 1 / 8, delta=2e-3)
        self.assertLessEqual({"s.0001.vdb", "s.0003.vdb"}, set(self.files()))

    def test_places_for_numbers_are_asked_for(self):
        still = self.write("still.obj", octahedron())
        self.assertIn("still.####.obj".replace("still", "name"),
                      self.fail_with(2, "mesh2vdb", still, "-o", self.path("v.vdb"), "--frames", "1-2"))
        self.assertIn("--frames", self.fail_with(2, "mesh2vdb", self.pattern, "-o", self.path("v.vdb")))
        self.assertIn("--frames", self.fail_with(2, "mesh2vdb", still, "-o", self.path("v.####.vdb")))
        self.fail_with(2, "mesh2vdb", self.pattern, "-o", "-", "--frames", "1-2")
