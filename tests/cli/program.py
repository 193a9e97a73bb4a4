"""Runs the volcaustic program for the cases in this folder."""

import json
import os
import pathlib
import resource
import shutil
import subprocess
import tempfile
import unittest

PROGRAM = os.environ.get("VOLCAUSTIC_PROGRAM", "volcaustic")
SHARED = pathlib.Path(os.environ.get("VOLCAUSTIC_SHARED", "../../../shared"))
DATA = pathlib.Path(os.environ.get("VOLCAUSTIC_DATA", "../../data"))

# A regular octahedron of radius 0.5: closed, outward, volume 1/6.
OCTAHEDRON = """v 0.5 0 0\nv -0.5 0 0\nv 0 0.5 0\nv 0 -0.5 0\nv 0 0 0.5\nv 0 0 -0.5
f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n"""

# Its corners as numbers, and OBJ text of it moved and scaled.
OCTAHEDRON_CORNERS = [(0.5, 0, 0), (-0.5, 0, 0), (0, 0.5, 0), (0, -0.5, 0), (0, 0, 0.5), (0, 0, -0.5)]


def octahedron(scale=1.0, centre=(0.0, 0.0, 0.0), first_vertex=1, material=None):
    """OBJ text of the octahedron; `first_vertex` is the number of its first vertex in a file of several."""
    vertices = ["v " + " ".join(repr(scale * x + c) for x, c in zip(corner, centre)) for corner in OCTAHEDRON_CORNERS]
    faces = [line.split()[1:] for line in OCTAHEDRON.splitlines() if line.startswith("f")]
    moved = ["f " + " ".join(str(int(v) + first_vertex - 1) for v in face) for face in faces]
    return "\n".join(vertices + ([f"usemtl {material}"] if material else []) + moved) + "\n"


SMALL_SCENE = {
    "volcaustic": 1,
    "volume": {"resolution": 24, "margin": 0.5, "attenuation": [0.2, 0.2, 0.2], "scattering": [0.1, 0.15, 0.2]},
    "objects": [{"mesh": "octahedron.obj"}],
    "lights": [{"direction": [0.2, 0.1, -1], "irradiance": [4, 3, 2]}],
    "voxelise": {"blur": 3},
    "photons": {"grid": [64, 64]},
    "camera": {"resolution": [32, 24]},
    "animation": {"/lights/0/direction": [[1, [0.2, 0.1, -1]], [3, [-0.2, 0.1, -1]]]},
}


def limit_memory(limit_bytes):
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (limit_bytes, limit_bytes))


class ProgramCase(unittest.TestCase):
    """A case with a folder of its own."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="volcaustic-cli-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return str(self.folder / name)

    def write(self, name, content):
        text = content if isinstance(content, str) else json.dumps(content)
        (self.folder / name).write_text(text)
        return self.path(name)

    def write_small_scene(self, **changes):
        self.write("octahedron.obj", OCTAHEDRON)
        return self.write("scene.json", {**SMALL_SCENE, **changes})

    def call(self, *arguments, **options):
        """The finished process; stdout and stderr as text."""
        options.setdefault("timeout", 120)
        return subprocess.run([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, errors="replace", **options)

    def succeed(self, *arguments, **options):
        done = self.call(*arguments, **options)
        self.assertEqual(done.returncode, 0, f"{arguments}\n{done.stderr}")
        return done

    def report(self, *arguments):
        return json.loads(self.succeed(*arguments, "--json").stdout)

    def fail_with(self, status, *arguments, **options):
        """The one line on stderr of a call that must end in `status`."""
        done = self.call(*arguments, **options)
        self.assertEqual(done.returncode, status, f"{arguments}\n{done.stdout}\n{done.stderr}")
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, done.stderr)
        return lines[0]

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())

    def need(self, path):
        if not path.exists():
            self.skipTest(f"not present: {path}")
        return path
