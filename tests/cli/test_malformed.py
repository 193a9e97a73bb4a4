"""Damaged meshes end in status 3 and one line, soon and without taking the machine's memory."""

import os
import time

from program import PROGRAM, SHARED, ProgramCase

MOST_SECONDS = 10
MOST_BYTES = 1 << 30


class Malformed(ProgramCase):
    def test_every_file(self):
        for mesh in sorted(self.need(SHARED / "data" / "malformed").iterdir()):
            with self.subTest(mesh=mesh.name):
                self.check(mesh)
        self.assertEqual(self.files(), ["stderr"])

    def check(self, mesh):
        """Runs the program itself, so that wait4 tells what this one process took."""
        arguments = [PROGRAM, "mesh2vdb", str(mesh), "-o", self.path("out.vdb"), "--resolution", "32"]
        with open(self.path("stderr"), "w+") as words:
            start = time.monotonic()
            child = os.posix_spawn(PROGRAM, arguments, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, words.fileno(), 2)])
            _, status, usage = os.wait4(child, 0)
            seconds = time.monotonic() - start
            words.seek(0)
            lines = words.read().splitlines()
        self.assertEqual(os.waitstatus_to_exitcode(status), 3, lines)
        self.assertEqual(len(lines), 1, lines)
        self.assertTrue(lines[0].startswith(f"{mesh}:"), lines)
        self.assertLess(seconds, MOST_SECONDS)
        self.assertLess(usage.ru_maxrss * 1024, MOST_BYTES)
