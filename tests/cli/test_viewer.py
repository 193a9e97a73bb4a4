"""The window, on a display without a screen: real windows, a real mouse (xdotool), scripts, screenshots."""

import json
import math
import os
import pathlib
import shutil
import subprocess
import time
import unittest

from png import difference, read_png
from program import PROGRAM, ProgramCase

VIEWER = pathlib.Path(PROGRAM).parent / "volcaustic-view"
# At 1360 x 820 the picture has room for 970 x 790 pixels: each of these is 2 x 2 of the window.
RESOLUTION = [485, 395]


def place(point, position=(0, -4, 1), target=(0, 0, 0)):
    """Where a camera of 40 degrees shows a point in the window, and at which depth."""
    def minus(a, b):
        return [x - y for x, y in zip(a, b)]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def unit(a):
        return [x / math.sqrt(dot(a, a)) for x in a]

    forward = unit(minus(target, position))
    right = unit(cross(forward, [0, 0, 1]))
    up = cross(right, forward)
    away = minus(point, position)
    depth = dot(away, forward)
    scale = 395 / math.tan(math.radians(20)) / depth
    return 485 + scale * dot(away, right), 395 - scale * dot(away, up), depth


@unittest.skipUnless(VIEWER.exists(), "volcaustic-view was not built")
@unittest.skipUnless(shutil.which("Xvfb"), "Xvfb is not installed")
class ViewerCase(ProgramCase):
    @classmethod
    def setUpClass(cls):
        read, write = os.pipe()
        cls.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x900x24", "-nolisten", "tcp"],
                                      pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        cls.environment = {**os.environ, "DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1"}

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.wait()

    def setUp(self):
        super().setUp()
        self.scene = self.write_small_scene(camera={"resolution": RESOLUTION})

    def view(self, *arguments, **options):
        return self.call("view", *arguments, env=self.environment, cwd=self.folder, **options)

    def run_script(self, *lines, scene=None):
        script = self.write("script.txt", "\n".join(lines) + "\nquit\n")
        done = self.view(scene or self.scene, "--script", script)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stderr)

    def saved(self, name="saved.json"):
        return json.loads((self.folder / name).read_text())

    def shot(self, name):
        width, height, rows = read_png(self.path(name))
        self.assertEqual((width, height), (1360, 820))
        return rows

    def picture(self, name):
        """Every second pixel of the picture's place in a screenshot."""
        return [bytes(b for x in range(0, 970, 2) for b in row[3 * x:3 * x + 3]) for row in self.shot(name)[0:790:2]]


class TestScripts(ViewerCase):
    def test_the_window_shows_what_render_writes(self):
        self.run_script("wait", "key o", "frames 2", "screenshot a.png", "save a.json",
                        "set view.exposure=2", "wait", "frames 2", "screenshot b.png", "save b.json")
        for name in "ab":
            self.succeed("render", self.path(name + ".json"), "-o", self.path("r.png"), cwd=self.folder)
            _, _, rendered = read_png(self.path("r.png"))
            shown = self.picture(name + ".png")
            self.assertLess(difference(shown, rendered), 1, "dither and rounding")
            self.assertGreater(difference(shown, [bytes(len(r)) for r in rendered]), 3, "and not black")

    def test_lights_and_handles_follow_the_hand(self):
        soft = {"mesh": "octahedron.obj", "deform": [{"type": "handle", "center": [.5, 0, 0], "radius": .1},
                                                     {"type": "handle", "center": [-.5, 0, 0], "radius": .1}]}
        lamp = {"type": "point", "position": [-.6, .3, .9]}
        scene = self.write_small_scene(objects=[soft], lights=[lamp], animation={}, camera={"resolution": RESOLUTION})
        lines = []
        for point in ([.5, 0, 0], lamp["position"]):
            x, y, _ = place(point)
            lines.append(f"drag {x:.1f} {y:.1f} {x + 60:.1f} {y:.1f}")
        self.run_script("wait", *lines, "wait rough", "save saved.json", scene=scene)
        for point, moved in (([0, 0, 0], self.saved()["objects"][0]["deform"][0]["translate"]),
                             (lamp["position"], self.saved()["lights"][0]["position"])):
            depth = place([.5, 0, 0] if point == [0, 0, 0] else point)[2]
            shift = 60 / 790 * 2 * math.tan(math.radians(20)) * depth
            for got, expected in zip(moved, [point[0] + shift, point[1], point[2]]):
                self.assertAlmostEqual(got, expected, delta=.005)
        self.assertEqual(self.saved()["objects"][0]["deform"][1]["translate"], [0, 0, 0])

    def test_a_hand_that_rests_lets_the_picture_refine(self):
        self.run_script("wait", "move 40 100", "press left", "move 60 100", "wait", "release", "frames 2", "wait")

    def test_what_fails_ends_a_script_at_its_line(self):
        for line, status, words in [("device nonsense", 2, "nonsense"), ("set objects.0.mesh=none.obj", 3, "none.obj"),
                                    ("save .", 3, "cannot be written"), ("frame 2", 3, "drop.0002.obj")]:
            self.write("drop.0001.obj", (self.folder / "octahedron.obj").read_text())
            scene = self.write_small_scene(objects=[{"mesh": "drop.####.obj"}], animation={})
            script = self.write("bad.txt", f"frames 1\n{line}\nwait\nlayer depth\nquit\n")
            done = self.view(scene, "--script", script)
            self.assertEqual(done.returncode, status, (line, done.stderr))
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertRegex(done.stderr, r"bad\.txt:[23]: ")
            self.assertIn(words, done.stderr)

    def test_a_scene_saved_elsewhere_finds_its_files(self):
        (self.folder / "other").mkdir()
        self.run_script("save other/s.json")
        self.succeed("scene", "check", self.path("other/s.json"))

    def test_a_drag_orbits_by_half_a_turn_a_height(self):
        before = json.loads(pathlib.Path(self.scene).read_text())["camera"]
        self.run_script("wait", "screenshot a.png", "drag 40 100 237.5 100", "wait", "screenshot b.png", "save saved.json")
        camera = self.saved()["camera"]
        # A quarter of the picture's height of 790: an eighth of a turn about z, from (0, -4, 1).
        x, y, z = camera["position"]
        self.assertAlmostEqual(math.hypot(x, y), 4, places=3)
        self.assertAlmostEqual(abs(x), 4 * math.sin(math.pi / 4), delta=.02, msg="a pixel is .016")
        self.assertAlmostEqual(z, 1, places=3)
        self.assertEqual(before["resolution"], camera["resolution"])
        self.assertGreater(difference(self.picture("a.png"), self.picture("b.png")), 1)

    def test_a_drag_on_an_object_moves_it_with_the_hand(self):
        self.run_script("wait", "drag 485 395 585 395", "wait", "save saved.json")
        x, y, z = self.saved()["objects"][0]["translate"]
        # 100 of 790 pixels at the object's depth, sqrt(17), across a vertical field of view of 40 degrees.
        self.assertAlmostEqual(x, 100 / 790 * 2 * math.tan(math.radians(20)) * math.sqrt(17), delta=.01)
        self.assertAlmostEqual(y, 0, places=3)
        self.assertAlmostEqual(z, 0, places=3)
        camera = self.saved()["camera"]
        self.assertEqual(camera["position"], [0, -4, 1])

    def test_undo_redo_and_set(self):
        self.run_script("set materials.glass.index=1.3", "drag 485 395 585 395", "undo", "save one.json", "undo",
                        "save none.json", "redo", "redo", "save two.json")
        self.assertEqual(self.saved("one.json")["objects"][0]["translate"], [0, 0, 0])
        self.assertEqual(self.saved("one.json")["materials"]["glass"]["index"], 1.3)
        self.assertEqual(self.saved("none.json")["materials"]["glass"]["index"], 1.5)
        self.assertNotEqual(self.saved("two.json")["objects"][0]["translate"], [0, 0, 0])

    def test_layers_slices_and_surfaces_differ(self):
        names = ["picture", "caustic", "direct", "background", "transmittance", "depth", "steps"]
        lines = ["wait", "key o"]
        for name in names:
            lines += [f"layer {name}", "frames 2", f"screenshot layer_{name}.png"]
        volumes = ["radiance", "caustic", "direction", "index", "step", "energy"]
        for name in volumes:
            lines += [f"slice {name} y 0.5", "frames 2", f"screenshot slice_{name}.png"]
        lines += ["slice off", "iso 0.5", "frames 3", "screenshot iso.png"]
        self.run_script(*lines)
        shots = [f"layer_{n}" for n in names] + [f"slice_{n}" for n in volumes] + ["iso"]
        pictures = {name: self.picture(name + ".png") for name in shots}
        for i, a in enumerate(shots):
            for b in shots[i + 1:]:
                self.assertNotEqual(pictures[a], pictures[b], f"{a} and {b}")

    def test_exports_are_of_the_whole_scene(self):
        self.run_script("export e.vdb", "export e.exr", "save saved.json")
        self.succeed("render", self.path("saved.json"), "-o", self.path("r.exr"), cwd=self.folder)
        self.succeed("compare", self.path("e.exr"), self.path("r.exr"), cwd=self.folder)
        self.succeed("trace", self.path("saved.json"), "-o", self.path("t.vdb"), cwd=self.folder)
        self.succeed("compare", self.path("e.vdb"), self.path("t.vdb"), cwd=self.folder)

    def test_frames_of_an_animation(self):
        scene = self.write_small_scene(frames={"first": 1, "last": 3})
        self.run_script("wait", "frame 3", "wait", "save saved.json", scene=scene)
        self.assertEqual(self.saved()["lights"][0]["direction"], [-0.2, 0.1, -1])
        # Edits end with their frame; undo brings them back.
        self.run_script("wait", "drag 485 395 585 395", "frame 2", "save a.json", "undo", "save b.json", scene=scene)
        self.assertEqual(self.saved("a.json")["objects"][0]["translate"], [0, 0, 0])
        self.assertNotEqual(self.saved("b.json")["objects"][0]["translate"], [0, 0, 0])

    def test_bad_scripts_are_one_line_each(self):
        for line, words in [("dance", "is no command"), ("drag 1 2", "needs more words"), ("drag 1 2 3 x", "does not fit"), ("frames inf", "does not fit"),
                            ("iso much", "does not fit"), ("wait longer", "does not fit"), ("slice radiance y 5", "0 to 1"),
                            ("frames 1 2", "is too much"), ("set photons.grit=3", "grid"), ("layer nothing", "no layer"),
                            ("slice light", "no layer of the volume"), ("select nobody", "no object is called")]:
            script = self.write("bad.txt", "frames 1\n" + line + "\n")
            done = self.view(self.scene, "--script", script)
            self.assertEqual(done.returncode, 2, line)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
            self.assertIn("bad.txt:2: ", done.stderr)
            self.assertIn(words, done.stderr)

    def test_bad_scenes_displays_and_options(self):
        self.assertEqual(self.view(self.path("none.json")).returncode, 3)
        self.assertEqual(self.view(self.scene, "--nothing").returncode, 2)
        self.assertEqual(self.view("--help").returncode, 0)
        done = self.call("view", self.scene, env={**self.environment, "DISPLAY": ":987"})
        self.assertEqual(done.returncode, 4)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)


@unittest.skipUnless(shutil.which("xdotool"), "xdotool is not installed")
class TestHand(ViewerCase):
    def setUp(self):
        super().setUp()
        self.viewer = subprocess.Popen([PROGRAM, "view", self.scene], env=self.environment, cwd=self.folder)
        self.addCleanup(self.stop)
        self.window = self.hand("search", "--sync", "--name", "^volcaustic - ").split()[0]
        self.hand("windowfocus", self.window)
        time.sleep(1.5)

    def stop(self):
        if self.viewer.poll() is None:
            self.viewer.kill()
        self.viewer.wait()

    def hand(self, *words):
        return subprocess.run(["xdotool", *words], env=self.environment, check=True, capture_output=True, text=True,
                              timeout=60).stdout

    def drag(self, x0, y0, x1, y1, button="1"):
        at = ["mousemove", "--window", self.window]
        self.hand(*at, str(x0), str(y0))
        time.sleep(.3)
        self.hand("mousedown", button)
        for i in range(1, 6):
            time.sleep(.1)
            self.hand(*at, str(x0 + (x1 - x0) * i // 5), str(y0 + (y1 - y0) * i // 5))
        time.sleep(.3)
        self.hand("mouseup", button)
        time.sleep(.3)

    def click(self, x, y):
        self.drag(x, y, x, y)

    def save(self):
        """By the button."""
        path = self.folder / "scene.edited.json"
        path.unlink(missing_ok=True)
        self.click(1145, 18)
        for _ in range(50):
            if path.exists():
                return json.loads(path.read_text())
            time.sleep(.1)
        self.fail("the button saves nothing")

    def test_a_hand_orbits_moves_undoes_and_leaves(self):
        first = self.save()
        self.drag(40, 100, 240, 160)
        orbited = self.save()
        self.assertNotEqual(orbited["camera"]["position"], first["camera"]["position"])
        self.assertEqual(orbited["objects"], first["objects"])
        self.assertAlmostEqual(math.dist(orbited["camera"]["position"], [0, 0, 0]), math.sqrt(17), places=3)
        self.drag(485, 395, 540, 360)
        moved = self.save()
        self.assertNotEqual(moved["objects"][0]["translate"], [0, 0, 0])
        self.assertEqual(moved["camera"], orbited["camera"])
        self.hand("key", "ctrl+z")
        time.sleep(.5)
        self.assertEqual(self.save()["objects"][0]["translate"], [0, 0, 0])
        self.hand("key", "ctrl+q")
        self.assertEqual(self.viewer.wait(20), 0)

    def test_resized_and_closed_from_outside(self):
        self.hand("windowsize", "--sync", self.window, "700", "500")
        time.sleep(1)
        self.assertIsNone(self.viewer.poll())
        self.viewer.terminate()
        self.assertIn(self.viewer.wait(20), (-15, 130, 143))


if __name__ == "__main__":
    unittest.main()
