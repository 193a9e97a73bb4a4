"""The volcaustic program in the background."""

import atexit
import os
import re
import shutil
import signal
import subprocess
import threading

from .export import Refused

OLDEST = (0, 1, 0)
PROGRESS = re.compile(r"^progress: (\d+)/(\d+) (.+) ([0-9.]+)$")
RUNNING = set()


def find_program(preferred):
    """The program's path. \\throws Refused."""
    wanted = os.path.expanduser(preferred) or os.environ.get("VOLCAUSTIC") or "volcaustic"
    program = shutil.which(wanted)
    if not program:
        raise Refused(f"{wanted}: there is no such program; install volcaustic, or name it in the add-on's preferences")
    try:
        said = subprocess.run([program, "--version"], capture_output=True, text=True, errors="replace", timeout=60,
                              check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refused(f"{program}: does not start: {error}; name another in the add-on's preferences") from None
    version = re.search(r"(\d+)\.(\d+)\.(\d+)", said)
    if "volcaustic" not in said or not version:
        raise Refused(f"{program}: is not volcaustic; name another program in the add-on's preferences")
    if tuple(map(int, version.groups())) < OLDEST:
        raise Refused(f"{program}: is volcaustic {version.group()}; this add-on needs {'.'.join(map(str, OLDEST))} or newer")
    return program


class Bake:
    """One run. Poll it; it never blocks."""

    def __init__(self, command):
        self.stage, self.index, self.count, self.fraction = "", 0, 1, 0.0
        self.warnings = []
        self._error = ""
        self._cancelled = False
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                         stderr=subprocess.PIPE, text=True, errors="replace", start_new_session=True)
        RUNNING.add(self)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stderr:
            match = PROGRESS.match(line)
            if match:
                self.index, self.count = int(match.group(1)), int(match.group(2))
                self.stage, self.fraction = match.group(3), float(match.group(4))
            elif line.startswith("warning: "):
                if line[9:].strip() not in self.warnings:
                    self.warnings.append(line[9:].strip())
            elif line.strip():
                self._error = line.strip()

    @property
    def text(self):
        return f"{self.stage} {100 * self.fraction:.0f} %, frame {self.index} of {self.count}" if self.stage else "starting"

    def running(self):
        if self._process.poll() is None:
            return True
        self._reader.join(5)
        RUNNING.discard(self)
        return False

    def wait(self):
        self._process.wait()
        self.running()

    def cancel(self):
        """The program ends soon, and leaves whole files or none."""
        self._cancelled = True
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)

    @property
    def cancelled(self):
        return self._cancelled

    @property
    def failure(self):
        """One line, or nothing where it went well."""
        status = self._process.returncode
        if status == 0 or self._cancelled:
            return ""
        if status < 0:
            return f"volcaustic was ended by signal {-status}; please report it"
        return self._error or f"volcaustic ended with status {status}"

    def stop(self):
        self.cancel()
        try:
            self._process.wait(3)
        except subprocess.TimeoutExpired:
            self._process.kill()
        RUNNING.discard(self)


def stop_all():
    for bake in list(RUNNING):
        bake.stop()


atexit.register(stop_all)
