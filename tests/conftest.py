import contextlib
import gc
import inspect
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from hypothesis import settings

from throws import MEDIUM_SPEED

# Matrices are small here: the threads of numpy's and of the solver's library wait for each other, and with
# other processes beside them for much longer than they work. Read when those are first loaded, also by
# children.
for library in ("MKL", "OMP", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# Temporary folders lie in memory where there is room: stores wait for the disk with every row.
if Path("/dev/shm").is_dir() and psutil.disk_usage("/dev/shm").free > 2e9:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", "/dev/shm")

# Lines wrap at this width, as in a terminal; what is captured here is as in a pipe. Runners set it.
os.environ.pop("COLUMNS", None)

# Where coverage is measured, processes that are killed write first which lines they ran.
MEASURED = "COVERAGE_PROCESS_CONFIG" in os.environ


def end_softly(process):
    with contextlib.suppress(AttributeError, OSError):
        process.stdin.close()  # what answers calls ends with them
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(2.0)
    process.terminate()


if MEASURED:
    subprocess.Popen.kill = end_softly

# Tests never measure time: an example that takes long on a busy machine is no fault.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Let -m 'not slow' leave out the further tests, too."""
    for item in items:
        if item.get_closest_marker("further") is not None:
            item.add_marker("slow")


def pytest_collection_finish():
    """Let the collector of garbage pass over the thousands of tests that stay to the end."""
    gc.collect()
    gc.freeze()


def pytest_sessionfinish():
    """End softly what would end with this process."""
    for one in gc.get_objects() if MEASURED else ():
        if isinstance(one, subprocess.Popen) and one.poll() is None:
            one.kill()


@pytest.fixture(autouse=True)
def _figures_closed():
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(scope="session")
def public():
    """All that crankfem and its topics hand out, by its whole name, such as "crankfem.chains.Gear"."""
    import crankfem as cf

    found = {f"crankfem.{name}": getattr(cf, name) for name in cf.__all__}
    topics = {name: one for name, one in found.items() if inspect.ismodule(one)}
    return {name: one for name, one in found.items() if name not in topics} | {
        f"{topic}.{name}": getattr(one, name)
        for topic, one in topics.items()
        for name in one.__all__
    }


@pytest.fixture(scope="session")
def public_classes(public):
    """The classes among them, by their own names."""
    return {name.rpartition(".")[2]: one for name, one in public.items() if inspect.isclass(one)}


@pytest.fixture(scope="session")
def dimensions():
    """A medium-speed engine's throw, in m."""
    return MEDIUM_SPEED | {"web_width": 0.3}


@pytest.fixture
def interruptible():
    """Let interrupts interrupt this process and those that it starts, also where it was told to ignore them.

    It is under nohup, and as a job that a shell runs in the background.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


# Seconds within which everything that a process has made is gone after its end.
SOON = 2.0


def lives(process):
    """Whether a process runs; one that has ended runs no more, even if nobody has asked for its end."""
    try:
        return process.status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
    except psutil.NoSuchProcess:
        return False


class Owner:
    """A program that is ended from outside, with its children and its folder for scratch files."""

    def __init__(self, command, folder):
        self.scratch = folder / "scratch"
        self.scratch.mkdir()
        paths = [str(Path(__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
        self.process = subprocess.Popen(
            command,
            cwd=folder,
            env=os.environ | {"TMPDIR": str(self.scratch), "PYTHONPATH": os.pathsep.join(paths)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    def wait_for(self, happened):
        """Wait until something is the case."""
        deadline = time.monotonic() + 60.0
        while not happened():
            assert self.process.poll() is None, "the program has ended before"
            assert time.monotonic() < deadline
            time.sleep(0.01)

    def children(self):
        return psutil.Process(self.process.pid).children(recursive=True)

    def end(self, number=signal.SIGKILL):
        """Send a signal to the program alone; return what is left of it a little later."""
        children = self.children()
        self.process.send_signal(number)
        self.process.wait(timeout=30.0)
        deadline = time.monotonic() + SOON
        while True:
            left = [child for child in children if lives(child)], list(self.scratch.iterdir())
            if not any(left) or time.monotonic() > deadline:
                return left
            time.sleep(0.01)


@pytest.fixture
def own(tmp_path, interruptible):
    """Start programs (Python's code, or its arguments) in processes of their own."""
    if not hasattr(signal, "SIGKILL"):
        pytest.skip("needs signals that end a process")
    started = []

    def start(*arguments):
        command = ["-c", *arguments] if len(arguments) == 1 else arguments
        started.append(Owner([sys.executable, "-P", *command], tmp_path))
        return started[-1]

    yield start
    for owner in started:
        if owner.process.poll() is None:
            left = owner.children()
            owner.process.kill()
            owner.process.wait()
            for child in left:
                child.kill()


# Graphics are calculated by the processor: test machines have no screen.
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)


@pytest.fixture(scope="session")
def browser():
    """Debian's Chromium, one for all tests of a process."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="pages are looked at in a browser with crankfem[browser]"
    )
    if (chromium := shutil.which("chromium")) is None:
        pytest.skip("there is no chromium")
    with playwright.sync_playwright() as started:
        opened = started.chromium.launch(executable_path=chromium, args=list(FLAGS))
        yield opened
        opened.close()
