"""bench: the counts that the paper's table fixes, sums that add up, and sweeps that end where they should."""

import json
import math

from program import PROGRAM, ProgramCase

# Of VD's table: objects, triangles, and what the counts are held against at full size.
PAPER = {"fig5": (1, 53e3), "fig6": (3, 55e3), "fig7": (8, 100e3), "fig9": (9, 118e3)}
STAGES = ["voxelisation", "stepField", "photonTracing", "view", "rest"]
ROWS = ["functional objects", "triangles", "volume", "occupied voxels", "source photons", "photon steps",
        "photons that met the object", "voxelisation, ms", "photon tracing, ms", "step field", "view", "the rest",
        "total, ms", "frames a second", "ns a photon step", "voxels crossed", "ns a voxel crossed", "peak memory, MiB"]
LIMITS = ["copyMemoryGBs", "copyCacheGBs", "multiplyAddGflops", "gather32KiBNs", "gather1MiBNs", "gather16MiBNs"]
SMALL = ["--device", "cpu", "--repeat", "1", "--resolution", "32", "--photons", "64"]


class Table(ProgramCase):
    def check(self, result):
        objects, triangles = PAPER[result["scene"]]
        self.assertEqual((result["objects"], result["paper"]["objects"]), (objects, objects))
        self.assertLess(abs(result["triangles"] / triangles - 1), 0.02)
        self.assertEqual(result["paper"]["triangles"], triangles)
        self.assertEqual((result["device"], result["volume"], result["sourcePhotons"]), ("cpu", [32, 32, 32], 64 * 64))
        # Coarse voxels count more of the surface; 256 are in the next case.
        self.assertGreater(result["occupiedVoxels"] * 512, result["paper"]["occupiedVoxels"] * 0.9)
        counts, ms = result["counts"], result["ms"]
        self.assertLess(0, counts["photonsTraced"])
        self.assertLess(counts["photonsTraced"], counts["photonsEmitted"])
        self.assertLess(counts["photonsEmitted"], 64 * 64 + 1)
        self.assertLess(counts["photonsTraced"], counts["photonSteps"])
        self.assertEqual((counts["photonsAtStepLimit"], counts["photonsNotFinite"]), (0, 0))
        self.assertEqual(list(ms)[-1], "total")
        for stage in STAGES:
            self.assertGreaterEqual(ms[stage], 0, stage)
        self.assertAlmostEqual(sum(ms[stage] for stage in STAGES), ms["total"], delta=1e-6 * ms["total"])
        self.assertAlmostEqual(result["framesPerSecond"] * ms["total"], 1000, delta=1e-3)
        self.assertAlmostEqual(result["nsPerPhotonStep"] * counts["photonSteps"], ms["photonTracing"] * 1e6, delta=1)
        self.assertAlmostEqual(result["nsPerVoxelCrossed"] * counts["voxelsCrossed"], ms["photonTracing"] * 1e6, delta=1)
        self.assertGreater(result["peakMemoryBytes"], 10e6)

    def test_every_row_is_there_and_adds_up(self):
        done = self.succeed("bench", *SMALL, "--json", self.path("o.json"))
        for row in ROWS:
            self.assertIn(row, done.stdout)
        report = json.loads((self.folder / "o.json").read_text())
        self.assertEqual([r["scene"] for r in report["results"]], list(PAPER))
        for result in report["results"]:
            with self.subTest(scene=result["scene"]):
                self.check(result)
        for limit in LIMITS:
            with self.subTest(limit=limit):
                self.assertGreater(report["limits"][limit]["oneThread"], 0)
                self.assertGreater(report["limits"][limit]["allThreads"], 0)
        self.assertEqual([done.stdout.count(text) for text in ("copy, ", "multiply-add, ", "random loads from ")], [2, 1, 3])

    def test_occupied_voxels_and_photons_are_the_papers_at_256_voxels(self):
        report = self.report("bench", "--device", "cpu", "--repeat", "1", "--photons", "256", "--no-view", "--no-limits",
                             "--quiet")
        for result in report["results"]:
            with self.subTest(scene=result["scene"]):
                self.assertLess(abs(result["occupiedVoxels"] / result["paper"]["occupiedVoxels"] - 1), 0.1)
                traced = result["counts"]["photonsTraced"] * (1024 / 256) ** 2
                self.assertLess(abs(traced / result["paper"]["photonsTraced"] - 1), 0.05)
                self.assertNotIn("view", result["ms"])
                self.assertAlmostEqual(sum(v for k, v in result["ms"].items() if k != "total"), result["ms"]["total"])

    def test_json_without_a_file_is_all_of_stdout(self):
        report = self.report("bench", *SMALL, "--scene", "ball", "--no-limits", "--fog", "--quiet")
        self.assertEqual([r["scene"] for r in report["results"]], ["ball"])
        self.assertIsNone(report["results"][0]["paper"])
        self.assertNotIn("limits", report)
        self.assertEqual(self.files(), [])

    def test_wrong_usage(self):
        self.assertIn("fig5", self.fail_with(2, "bench", *SMALL, "--scene", "fig8", "--quiet"))
        self.fail_with(2, "bench", "--repeat", "0")
        self.fail_with(2, "bench", "--max-voxels", "64")
        line = self.fail_with(3, "bench", *SMALL, "--scene", "ball", "--no-limits", "--quiet", "--json",
                              self.path("no/such/folder.json"))
        self.assertTrue(line.startswith(self.path("no/such/folder.json") + ": "), line)


class Scaling(ProgramCase):
    def sweeps(self, *arguments):
        report = self.report("bench", "--scaling", "--device", "cpu", "--repeat", "1", "--quiet", *arguments)
        (device,) = report["scaling"]
        self.assertEqual(device["device"], "cpu")
        return {sweep["sweep"]: sweep for sweep in device["sweeps"]}

    def test_counts_grow_with_photons_and_voxels(self):
        sweeps = self.sweeps("--max-photons", "2^18", "--max-voxels", "128")
        photons, voxels = sweeps["photons"]["cases"], sweeps["voxels"]["cases"]
        self.assertEqual([c["sourcePhotons"] for c in photons], [2**16, 2**18])
        self.assertEqual([c["volume"][0] for c in voxels], [64, 128])
        self.assertEqual((sweeps["photons"]["stopped"], sweeps["voxels"]["stopped"]), (None, None))
        # Four times the photons cross four times the voxels; twice the voxels along an axis are twice as many on a path.
        crossed = [c["counts"]["voxelsCrossed"] for c in photons]
        self.assertAlmostEqual(crossed[1] / crossed[0], 4, delta=0.1)
        paths = [c["counts"]["voxelsCrossed"] / c["counts"]["photonsTraced"] for c in voxels]
        self.assertAlmostEqual(math.log2(paths[1] / paths[0]), 1, delta=0.2)
        for case in photons + voxels:
            self.assertGreater(case["peakMemoryBytes"], 1e6)

    def test_a_case_beyond_the_memory_ends_its_sweep_by_name(self):
        with open(PROGRAM, "rb") as program:
            if b"__asan_init" in program.read():
                self.skipTest("the address sanitizer ends a process that is out of memory in its own way")
        sweep = self.sweeps("--max-photons", "2^15", "--max-voxels", "1024", "--memory-limit", "150M")["voxels"]
        self.assertIsNotNone(sweep["stopped"])
        self.assertIn("memory", sweep["stopped"]["reason"])
        self.assertLess(len(sweep["cases"]), 5)
