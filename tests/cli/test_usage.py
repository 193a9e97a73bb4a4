"""Help, version, completion, devices and wrong usage."""

import json
import shutil
import subprocess
import unittest

from program import PROGRAM, ProgramCase

COMMANDS = ["mesh2vdb", "vdb2mesh", "trace", "render", "info", "compare", "convert", "scene check", "scene schema",
            "scene new", "bench", "devices", "completion bash", "help"]


class Help(ProgramCase):
    def test_every_command_explains_itself(self):
        for command in COMMANDS:
            with self.subTest(command=command):
                done = self.succeed(*command.split(), "--help")
                self.assertIn("Usage:", done.stdout)
                self.assertEqual(done.stderr, "")
                self.assertIn("Usage:", self.succeed("help", *command.split()).stdout)

    def test_the_program_lists_its_commands(self):
        text = self.succeed("--help").stdout
        for command in COMMANDS:
            self.assertIn(command.split()[0], text)
        self.assertRegex(self.succeed("--version").stdout, r"^volcaustic \d+\.\d+\.\d+\n$")

    def test_flags_carry_text_unit_range_and_default(self):
        text = " ".join(self.succeed("help", "mesh2vdb").stdout.split())
        for part in ["--supersample", "1, 2, 4, 8; default 4", "--blur", "--fill", "auto, exact, winding", "--ior", "--index",
                     "--attenuation", "[1/world]", "--scattering", "--asymmetry", "--resolution", "--voxel-size",
                     "--padding", "--half"]:
            self.assertIn(part, text)


class WrongUsage(ProgramCase):
    def test_ends_in_status_2_and_one_line(self):
        self.write_small_scene()
        mesh, out, scene = self.path("octahedron.obj"), self.path("out.vdb"), self.path("scene.json")
        for arguments in [
                [], ["nonsense"], ["mesh2vdb"], ["mesh2vdb", mesh], ["mesh2vdb", mesh, "-o", out, "--blur", "4"],
                ["mesh2vdb", mesh, "-o", out, "--supersample", "x"], ["mesh2vdb", mesh, "-o", out, "--ior", "nan"],
                ["mesh2vdb", mesh, "-o", out, "--fill", "solid"], ["mesh2vdb", mesh, "-o", out, "--attenuation", "1", "1"],
                ["mesh2vdb", mesh, "-o", out, "--scattering", "1", "1", "1"],
                ["mesh2vdb", mesh, "-o", out, "--resolution", "8", "--voxel-size", "0.1"],
                ["mesh2vdb", mesh, mesh, "-o", out], ["mesh2vdb", mesh, mesh, "-o", self.path("{}.vdb")],
                ["mesh2vdb", mesh, "-o", out, "--nonsense"], ["mesh2vdb", mesh, "-o", out, "--device", "gpu"],
                ["mesh2vdb", mesh, "-o", out, "--device", "cpu:sse2"], ["trace", scene, "-o", out, "--device", "hybrid:7"],
                ["trace", scene], ["trace", scene, "-o", out, "--set", "photons.gird=[8,8]"],
                ["trace", scene, "-o", out, "--set", "photons.grid=[0,8]"], ["trace", scene, "-o", out, "--frames", "5-2"],
                ["trace", scene, "-o", self.path("a.####.vdb")], ["trace", scene, "-o", "-", "--json"],
                ["render", scene, "-o", self.path("a.nonsense")], ["convert", mesh, self.path("a.png")],
                ["convert", mesh, self.path("a.nonsense")], ["compare", mesh], ["compare", scene, scene],
                ["scene"], ["scene", "nonsense"], ["help", "nonsense"], ["completion"]]:
            with self.subTest(arguments=arguments):
                line = self.fail_with(2, *arguments)
                self.assertTrue(line.startswith("volcaustic") or line.startswith(str(self.folder)), line)
        self.assertEqual(self.files(), ["octahedron.obj", "scene.json"])

    def test_an_unknown_set_path_names_the_nearest(self):
        scene = self.write_small_scene()
        line = self.fail_with(2, "trace", scene, "-o", self.path("o.vdb"), "--set", "photons.gird=[8,8]")
        self.assertIn("photons.grid", line)


class Devices(ProgramCase):
    def test_the_cpu_is_first_and_usable(self):
        devices = self.report("devices")["devices"]
        self.assertEqual(devices[0]["id"], "cpu")
        self.assertTrue(devices[0]["usable"])
        self.assertRegex(devices[0]["name"], r"\((avx512|avx2|scalar)\)$")
        for device in devices:
            self.assertTrue(device["usable"] or device["reason"])
        self.assertIn("cpu", self.succeed("devices").stdout)

    def test_a_device_that_cannot_be_used_is_status_4_with_its_reason(self):
        scene, out = self.write_small_scene(), self.path("o.vdb")
        gpu = any(d["usable"] for d in self.report("devices")["devices"][1:])
        for device in ["cuda:99"] if gpu else ["cuda", "cuda:0", "cuda:99", "hybrid", "hybrid:0.5"]:
            for command in (["mesh2vdb", self.path("octahedron.obj"), "-o", out], ["trace", scene, "-o", out]):
                with self.subTest(device=device, command=command[0]):
                    line = self.fail_with(4, *command, "--device", device)
                    self.assertIn(f"--device {device}: ", line)
                    self.assertIn("use cpu", line)
        self.assertNotIn("o.vdb", self.files())

    def test_auto_computes_on_what_is_here_without_a_word(self):
        scene = self.write_small_scene()
        usable = [d["id"] for d in self.report("devices")["devices"] if d["usable"]]
        done = self.succeed("trace", scene, "-o", self.path("auto.vdb"), "--device", "auto", "--json")
        self.assertEqual(json.loads(done.stdout)["device"], (usable[1:] or usable)[0])
        self.assertNotIn("warning", done.stderr)
        self.assertNotIn("cuda", done.stderr)

    def test_every_instruction_set_gives_the_same_light(self):
        scene = self.write_small_scene()
        self.succeed("trace", scene, "-o", self.path("scalar.vdb"), "--device", "cpu:scalar")
        for lanes in ["avx2", "avx512"]:
            done = self.call("trace", scene, "-o", self.path("lanes.vdb"), "--device", f"cpu:{lanes}", "--json")
            if done.returncode == 4:  # not on this processor
                self.assertEqual(len(done.stderr.splitlines()), 1)
                continue
            self.assertEqual((done.returncode, json.loads(done.stdout)["device"]), (0, f"cpu:{lanes}"), done.stderr)
            self.succeed("compare", self.path("scalar.vdb"), self.path("lanes.vdb"), "--metric", "rmse",
                         "--threshold", "0.01")


class Completion(ProgramCase):
    def complete(self, *words):
        script = self.succeed("completion", "bash").stdout
        typed = " ".join(f"'{w}'" for w in ("volcaustic", *words))
        tail = f"\nCOMP_WORDS=({typed}); COMP_CWORD={len(words)}; _volcaustic; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        done = subprocess.run(["bash", "-c", script + tail], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              cwd=self.folder, check=True)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    @unittest.skipUnless(shutil.which("bash"), "bash is not installed")
    def test_completes_commands_flags_and_files(self):
        self.write("thing.obj", "")
        self.assertIn("mesh2vdb", self.complete("mesh"))
        self.assertIn("check", self.complete("scene", "ch"))
        self.assertIn("--supersample", self.complete("mesh2vdb", "thing.obj", "--sup"))
        self.assertIn("--set", self.complete("scene", "check", "--"))
        self.assertIn("thing.obj", self.complete("mesh2vdb", "thi"))
        self.assertNotIn("--frames", self.complete("info", "--"))
