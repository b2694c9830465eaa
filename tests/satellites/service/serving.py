"""A service in a process of its own, as a user starts it, and what asks it."""

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

from throws import MEDIUM_SPEED, MEDIUM_SPEED_TOML

ROOT = Path(__file__).parents[3]
# Seconds for a service to answer on a busy machine.
STARTING = 60.0


# Linux ends a service with the process that started it, however that ends; see prctl(2).
PR_SET_PDEATHSIG = 1
C_LIBRARY = ctypes.CDLL(None) if sys.platform == "linux" else None


def end_with_owner():
    C_LIBRARY.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


# A service with bounds that the command line does not set.
BOUNDED = """
import sys
sys.modules.update(dict.fromkeys({hidden}))
from pathlib import Path
from crankfem.satellites.service.guard import Bounds, Settings
from crankfem.satellites.service.app import serve
settings = Settings(Path(sys.argv[1]), port=0, key={key!r}, bounds=Bounds(**{bounds}))
serve(settings, lambda address: print("crankfem serves at", address, "", file=sys.stderr, flush=True))
"""


class Served:
    """A service, its folder and its log; with bounds in place of options if such are given.

    It has no package whose name is hidden.
    """

    def __init__(self, folder, *options, key=None, hidden=(), **bounds):
        self.folder = folder
        self.log = folder / "log"
        paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
        own = str(folder / "service")
        command = ["-m", "crankfem", "serve", "--port", "0", "--folder", own, *options]
        if bounds:
            command = ["-c", BOUNDED.format(bounds=bounds, key=key, hidden=hidden), own]
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-P", *command],
                cwd=folder,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
                stdout=subprocess.DEVNULL,
                stderr=log,
                start_new_session=True,
                preexec_fn=C_LIBRARY and end_with_owner,
            )
        try:
            self.address = self._await_address()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def _await_address(self):
        deadline = time.monotonic() + STARTING
        told = "crankfem serves at "
        while time.monotonic() < deadline:
            lines = [line for line in self.log.read_text().splitlines() if line.startswith(told)]
            if lines and self.process.poll() is None:
                address = lines[-1].removeprefix(told).split("/ ")[0]
                try:
                    urllib.request.urlopen(f"{address}/", timeout=5).read()
                except urllib.error.URLError:
                    pass
                else:
                    return address
            assert self.process.poll() is None, self.log.read_text()
            time.sleep(0.05)
        raise AssertionError(self.log.read_text())

    def ask(self, path, question=None, method=None, **headers):
        """Ask, and return status, headers and body, whatever the status is."""
        body = question if isinstance(question, bytes | None) else json.dumps(question).encode()
        given = {"Content-Type": "application/json"} if body is not None else {}
        given |= {name.replace("_", "-"): value for name, value in headers.items()}
        request = urllib.request.Request(f"{self.address}{path}", body, given, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, answer.headers, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.headers, error.read()

    def json(self, path, question=None, **headers):
        status, _, body = self.ask(path, question, **headers)
        return status, json.loads(body)

    def wait(self, name, *states, seconds=180.0):
        """Wait until a job is in one of the states; return it."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            _, job = self.json(f"/api/jobs/{name}")
            if job["state"] in states:
                return job
            time.sleep(0.05)
        raise AssertionError(job)

    def end(self, number=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(number)
            self.process.wait(timeout=60)
        return self.process.returncode


def save_model(folder):
    """Keep a model of a throw in a folder, six.json."""
    from crankfem import STEEL, CrankThrow
    from fitted_models import known_model

    compliances = {"axial_compliance": 1.3e-9, "torsional_compliance": 4e-8}
    known_model(CrankThrow(**THROW), STEEL, compliances, 0.01).save(folder / "six.json")


THROW = dict(MEDIUM_SPEED)


STUDY = f"""
{MEDIUM_SPEED_TOML}
[study]
design = "full factorial"
accuracy = 0.1

[study.factors]
web_width = ["270 mm", "330 mm"]
web_thickness = ["55 mm", "98 mm"]
"""
