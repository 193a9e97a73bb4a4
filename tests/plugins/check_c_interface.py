"""check_c_interface.py PROGRAM LIBRARY OUT: volcaustic_c.h through ctypes, as a host in another language sees it."""
import ctypes as c
import json
import os
import subprocess
import sys
import threading
import time
import unittest

PROGRAM, LIBRARY, OUT = sys.argv[1:4]
OK, USAGE, INPUT, DEVICE, FILE, CANCELLED = 0, 2, 3, 4, 5, 130
MEDIUM, PHOTONS, VIEW = 0, 1, 2
SCENE = {"volcaustic": 1, "frames": {"first": 1, "last": 3, "rate": 25},
         "volume": {"bounds": {"min": [-1, -1, -1.5], "max": [1, 1, 1]}, "resolution": 40,
                    "attenuation": [0.1] * 3, "scattering": [0.1] * 3},
         "objects": [{"shape": {"type": "ellipsoid", "semiAxes": [0.5, 0.5, 0.5]}}],
         "lights": [{"direction": [0, 0, -1], "name": "sun"}], "photons": {"grid": [96, 96]},
         "animation": {"/objects/0/translate": [[1, [0, 0, 0]], [3, [0.4, 0, 0]]]},
         "camera": {"position": [0, -6, 0], "resolution": [64, 48]}}

PROGRESS = c.CFUNCTYPE(c.c_int32, c.c_void_p, c.c_char_p, c.c_double)
LOG = c.CFUNCTYPE(None, c.c_void_p, c.c_int32, c.c_char_p)


class Options(c.Structure):
    _fields_ = [("size", c.c_size_t), ("threads", c.c_int32), ("seed", c.c_uint64), ("memory_limit", c.c_uint64),
                ("device", c.c_char_p), ("cache", c.c_char_p), ("progress", PROGRESS), ("log", LOG), ("user", c.c_void_p)]


class Scene(c.Structure):
    _fields_ = [("size", c.c_size_t), ("json", c.c_char_p), ("path", c.c_char_p), ("sets", c.POINTER(c.c_char_p)),
                ("set_count", c.c_size_t), ("frame", c.c_double), ("camera", c.c_char_p), ("box_of_all", c.c_int32)]


class Grid(c.Structure):
    _fields_ = [("name", c.c_char_p), ("unit", c.c_char_p), ("components", c.c_int32), ("dims", c.c_int32 * 3),
                ("min_corner", c.c_double * 3), ("voxel_size", c.c_double)]


class Picture(c.Structure):
    _fields_ = [("width", c.c_int32), ("height", c.c_int32), ("channels", c.c_int32)]


lib = c.CDLL(LIBRARY)
for name in ("version", "message", "channel"):
    getattr(lib, "volcaustic_" + name).restype = c.c_char_p
lib.volcaustic_open.restype = c.c_void_p
lib.volcaustic_grid_count.restype = c.c_size_t
lib.volcaustic_cancel.restype = None
lib.volcaustic_read_grid.argtypes = [c.c_void_p, c.c_int, c.c_char_p, c.POINTER(c.c_int32), c.POINTER(c.c_int32),
                                     c.POINTER(c.c_float), c.c_size_t]


def message():
    return lib.volcaustic_message().decode()


def scene_struct(scene=SCENE, path=None, sets=(), frame=1.0, box_of_all=0):
    texts = (c.c_char_p * len(sets))(*[s.encode() for s in sets])
    return Scene(c.sizeof(Scene), json.dumps(scene).encode() if scene else None, path.encode() if path else None, texts,
                 len(sets), frame, None, box_of_all)


def options_struct(**fields):
    return Options(size=c.sizeof(Options), **fields)


class Interface(unittest.TestCase):
    def open(self, options=None, status=OK, **scene):
        found = c.c_int(-1)
        given = scene_struct(**scene)
        session = lib.volcaustic_open(c.byref(given), c.byref(options) if options else None, c.byref(found))
        self.assertEqual(found.value, status, message())
        self.assertEqual(session is None, status != OK)
        if session:
            session = c.c_void_p(session)
            self.addCleanup(lib.volcaustic_close, session)
        return session

    def grids(self, session, stage):
        found = {}
        for i in range(lib.volcaustic_grid_count(session, stage)):
            grid = Grid()
            self.assertEqual(lib.volcaustic_grid_at(session, stage, c.c_size_t(i), c.byref(grid)), OK)
            found[grid.name.decode()] = grid
        return found

    def read(self, session, stage, grid, first=(0, 0, 0), size=None, count=None):
        size = size or tuple(grid.dims)
        values = (c.c_float * (size[0] * size[1] * size[2] * grid.components))()
        status = lib.volcaustic_read_grid(session, stage, grid.name, (c.c_int32 * 3)(*first), (c.c_int32 * 3)(*size),
                                          values, len(values) if count is None else count)
        return status, values

    def picture(self, session):
        what = Picture()
        self.assertEqual(lib.volcaustic_picture_of(session, c.byref(what)), OK)
        values = (c.c_float * (what.width * what.height * what.channels))()
        self.assertEqual(lib.volcaustic_read_picture(session, values, c.c_size_t(len(values))), OK, message())
        return what, values

    def test_versions(self):
        self.assertEqual(lib.volcaustic_interface(), 1)
        version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
        self.assertIn(lib.volcaustic_version().decode(), version)

    def test_grids_and_files_are_those_of_the_program(self):
        import numpy
        import pyopenvdb
        session = self.open()
        self.assertEqual(set(self.grids(session, MEDIUM)), {"index", "attenuation", "scattering", "coverage"})
        light = self.grids(session, PHOTONS)
        self.assertEqual(set(light), {"radiance", "direction", "emission", "density", "caustic", "direct"})
        self.assertEqual(light["radiance"].unit, b"W/(m2 sr)")
        self.assertEqual(tuple(light["radiance"].dims), (32, 32, 40))
        path = os.path.join(OUT, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(SCENE, file)
        subprocess.run([PROGRAM, "trace", path, "-o", os.path.join(OUT, "theirs.vdb"), "--parts", "--quiet"], check=True)
        for name, grid in light.items():
            status, values = self.read(session, PHOTONS, grid)
            self.assertEqual(status, OK)
            array = numpy.frombuffer(values, numpy.float32).reshape(40, 32, 32, grid.components)
            wanted = numpy.empty((32, 32, 40, 3) if grid.components == 3 else (32, 32, 40), numpy.float32)
            pyopenvdb.read(os.path.join(OUT, "theirs.vdb"), name).copyToArray(wanted)
            self.assertTrue(numpy.array_equal(array.transpose(2, 1, 0, 3).reshape(wanted.shape), wanted), name)
        ours = os.path.join(OUT, "ours.vdb")
        self.assertEqual(lib.volcaustic_write(session, PHOTONS, ours.encode(), 2), OK)
        done = subprocess.run([PROGRAM, "compare", ours, os.path.join(OUT, "theirs.vdb")], check=False, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_the_picture_is_that_of_the_program(self):
        session = self.open()
        what, _ = self.picture(session)
        self.assertEqual((what.width, what.height), (64, 48))
        self.assertEqual([lib.volcaustic_channel(session, i) for i in (0, 3, 4)], [b"R", b"A", b"caustic.R"])
        self.assertIsNone(lib.volcaustic_channel(session, what.channels))
        path = os.path.join(OUT, "picture.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(SCENE, file)
        ours, theirs = os.path.join(OUT, "ours.exr"), os.path.join(OUT, "theirs.exr")
        subprocess.run([PROGRAM, "render", path, "-o", theirs, "--float", "--quiet"], check=True)
        self.assertEqual(lib.volcaustic_write(session, VIEW, ours.encode(), 0), OK)
        done = subprocess.run([PROGRAM, "compare", ours, theirs], check=False, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_a_moved_camera_runs_the_view_alone(self):
        stages = []
        keep = PROGRESS(lambda user, stage, fraction: stages.append(stage.decode()) or 0)
        session = self.open(options_struct(progress=keep))
        first = bytes(self.picture(session)[1])
        self.assertIn("photons", stages)
        stages.clear()
        moved = scene_struct(sets=["camera.position=[3,-6,0]"])
        self.assertEqual(lib.volcaustic_set_scene(session, c.byref(moved)), OK)
        self.assertNotEqual(bytes(self.picture(session)[1]), first)
        self.assertEqual(set(stages), {"view"})

    def test_frames_share_a_box_where_asked(self):
        scene = dict(SCENE, volume={k: v for k, v in SCENE["volume"].items() if k != "bounds"})
        session = self.open(scene=scene, box_of_all=1)
        corners = []
        for frame in (1, 3):
            at = scene_struct(scene=scene, frame=frame, box_of_all=1)
            self.assertEqual(lib.volcaustic_set_scene(session, c.byref(at)), OK)
            corners.append(tuple(self.grids(session, MEDIUM)["index"].min_corner))
        self.assertEqual(corners[0], corners[1])
        alone = self.open(scene=scene, frame=3)
        self.assertNotEqual(tuple(self.grids(alone, MEDIUM)["index"].min_corner), corners[0])
        first, last, rate = c.c_int32(), c.c_int32(), c.c_double()
        self.assertEqual(lib.volcaustic_frames(session, c.byref(first), c.byref(last), c.byref(rate)), OK)
        self.assertEqual((first.value, last.value, rate.value), (1, 3, 25))

    def test_grids_are_known_before_the_photons(self):
        lights = [{"name": "key"}, {"direction": [1, 0, -1]}]
        for separate in (False, True):
            told = []
            callback = PROGRESS(lambda user, stage, fraction: told.append(stage) or 0)
            session = self.open(options_struct(progress=callback), scene={**SCENE, "lights": lights},
                                sets=[f"photons.separate={json.dumps(separate)}"])
            before = set(self.grids(session, PHOTONS))
            self.assertNotIn(b"photons", told)
            path = os.path.join(OUT, "known.vdb")
            self.assertEqual(lib.volcaustic_write(session, PHOTONS, path.encode(), 2), OK, message())
            files = subprocess.run([PROGRAM, "info", "--json", path], capture_output=True, text=True, check=True).stdout
            self.assertEqual(before, {grid["name"] for grid in json.loads(files)["files"][0]["grids"]})
            self.assertEqual("radiance_key" in before, separate)

    def test_a_session_is_for_one_call_at_a_time(self):
        statuses, sessions = [], []

        def again(user, stage, fraction):
            statuses.append(lib.volcaustic_run(sessions[0], MEDIUM))
            return 1 if fraction == 1 and stage == b"view" else 0

        callback = PROGRESS(again)
        sessions.append(self.open(options_struct(progress=callback)))
        self.assertEqual(lib.volcaustic_run(sessions[0], VIEW), CANCELLED, "at its last report, too")
        self.assertEqual(set(statuses), {USAGE})
        self.assertGreater(lib.volcaustic_grid_count(sessions[0], MEDIUM), 0, "the next call is another")

    def test_cancelled_by_callback_and_from_another_thread(self):
        keep = PROGRESS(lambda user, stage, fraction: int(stage == b"photons"))
        session = self.open(options_struct(progress=keep))
        self.assertEqual(lib.volcaustic_run(session, VIEW), CANCELLED)
        self.assertEqual(lib.volcaustic_run(session, MEDIUM), OK, "one cancel ends one call")
        large = self.open(sets=["photons.grid=[4096,4096]", "volume.resolution=256"])
        timer = threading.Timer(0.3, lib.volcaustic_cancel, [large])
        timer.start()
        start = time.monotonic()
        self.assertEqual(lib.volcaustic_run(large, VIEW), CANCELLED)
        self.assertLess(time.monotonic() - start, 20)
        timer.join()

    def test_faults(self):
        self.open(scene={"volcaustic": 1, "lights": [{"irradianc": [1, 1, 1]}]}, status=INPUT)
        self.assertIn("/lights/0/irradianc", message())
        self.open(scene=None, path=os.path.join(OUT, "absent.json"), status=FILE)
        self.assertIn("absent.json", message())
        self.open(scene=None, status=USAGE)
        self.open(sets=["photons.gird=[3,3]"], status=USAGE)
        for threads in (-1, 1000000):
            self.open(options_struct(threads=threads), status=USAGE)
            self.assertIn("threads", message())
        for frame in (float("nan"), float("inf"), 1e300):
            self.open(frame=frame, status=USAGE)
            self.assertIn("frame", message())
        toaster = self.open(options_struct(device=b"toaster"))
        self.assertEqual(lib.volcaustic_run(toaster, PHOTONS), USAGE)
        self.assertIn("toaster", message())
        session = self.open()
        grid = self.grids(session, PHOTONS)["radiance"]
        self.assertEqual(self.read(session, PHOTONS, grid, count=7)[0], USAGE)
        self.assertIn("7", message())
        self.assertEqual(self.read(session, PHOTONS, grid, size=(1, 1, 1), first=(-2 ** 31, 0, 0))[0], USAGE)
        grid.name = b"radianse"
        self.assertEqual(self.read(session, PHOTONS, grid)[0], USAGE)
        self.assertIn("radiance", message())
        self.assertEqual(lib.volcaustic_run(session, 7), USAGE)
        self.assertEqual(lib.volcaustic_run(None, VIEW), USAGE)
        self.assertEqual(lib.volcaustic_grid_at(session, VIEW, c.c_size_t(0), c.byref(grid)), USAGE)
        self.assertEqual(lib.volcaustic_grid_at(session, PHOTONS, c.c_size_t(99), c.byref(grid)), USAGE)
        self.assertEqual(lib.volcaustic_write(session, PHOTONS, os.path.join(OUT, "no", "x.vdb").encode(), 0), FILE)
        self.assertEqual(lib.volcaustic_write(session, PHOTONS, os.path.join(OUT, "x.txt").encode(), 0), USAGE)
        self.assertEqual(lib.volcaustic_write(session, PHOTONS, b"x.vdb", 64), USAGE)
        small = self.open(options_struct(memory_limit=1 << 20))
        self.assertEqual(lib.volcaustic_run(small, PHOTONS), INPUT)
        for line in (message(),):
            self.assertEqual(len(line.splitlines()), 1)
        lib.volcaustic_close(None)
        lib.volcaustic_cancel(None)

    def test_an_older_host_has_shorter_structs(self):
        scene = scene_struct()
        scene.size = Scene.frame.offset  # neither frame nor what follows
        scene.frame, scene.box_of_all = float("nan"), 77
        session = lib.volcaustic_open(c.byref(scene), None, None)
        self.assertTrue(session, message())
        lib.volcaustic_close(c.c_void_p(session))
        scene.size = 0
        self.assertIsNone(lib.volcaustic_open(c.byref(scene), None, None))
        self.assertIn("size", message())

    def test_sessions_on_threads_have_messages_of_their_own(self):
        wrong = []

        def work(i):
            for _ in range(20):
                given = scene_struct(scene={"volcaustic": 1, f"key{i}": 1})
                if lib.volcaustic_open(c.byref(given), None, None) or f"key{i}" not in message():
                    wrong.append(message())

        threads = [threading.Thread(target=work, args=[i]) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])


unittest.main(argv=sys.argv[:1])
