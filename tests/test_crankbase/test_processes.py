"""Child processes, memory and time taken."""

import signal
import subprocess
import sys

import psutil
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fem.solver
from comparing import close
from crankbase import memory
from crankbase.errors import NotEnoughMemoryError
from crankbase.memory import check_memory, free_memory
from crankbase.processes import end_child, scratch_folder, signal_name, start_child
from fem.solver import Stopwatch
from refusals import refused

FOLDER = """
import time
from crankbase.processes import scratch_folder
with scratch_folder() as folder:
    (folder / "inner").mkdir()
    (folder / "inner" / "file").touch()
    time.sleep(60)
"""


CALL = """
import os
from geometry.gmsh_session import IsolatedProcess
for stream in {closed}:
    os.close(stream)
os._exit(IsolatedProcess().call("math:isqrt", 49, time_limit=60.0))
"""


@pytest.mark.slow
@pytest.mark.parametrize("closed", [(0,), (0, 1, 2)])
def test_a_child_works_where_standard_streams_are_closed(closed):
    # Else its pipes get the numbers of the streams.
    made = subprocess.run([sys.executable, "-c", CALL.format(closed=closed)], timeout=120)
    assert made.returncode == 7


@pytest.fixture
def scratch(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_scratch_folder_goes_at_the_end_of_its_block(scratch):
    with scratch_folder() as folder, scratch_folder() as other:
        assert set(scratch.iterdir()) == {folder, other}
        assert folder.stat().st_mode & 0o777 == 0o700
        (folder / "inner").mkdir()
    assert list(scratch.iterdir()) == []


def fail_within_a_folder(error):
    with scratch_folder() as folder:
        (folder / "file").touch()
        raise error


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, OSError])
def test_a_scratch_folder_goes_with_an_error(scratch, error):
    with pytest.raises(error):
        fail_within_a_folder(error)
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGKILL"])
def test_a_scratch_folder_goes_with_its_owner(own, number):
    owner = own(FOLDER)
    owner.wait_for(lambda: list(owner.scratch.glob("*/inner/file")))
    assert owner.end(getattr(signal, number)) == ([], [])


def test_a_child_finds_its_arguments_and_ignores_interrupts():
    """Its owner decides what an interrupt means."""
    code = "import os, signal, sys; os.kill(os.getpid(), signal.SIGINT); print(sys.argv[0], '/a' in sys.path)"
    process = start_child(
        "timeit", "-n1", "-r1", code, environment={"PYTHONPATH": "/a"}, stdout=subprocess.PIPE
    )
    said = process.stdout.read().decode()
    end_child(process)
    assert "timeit.py True" in said


@pytest.mark.parametrize(("code", "name"), [(0, None), (3, None), (-9, "SIGKILL"), (-99, None)])
def test_the_signal_that_ended_a_process(code, name):
    assert signal_name(code) == name


class Clock:
    """A clock that goes when it is told to, in whole seconds, so that sums are exact."""

    def __init__(self):
        self.now = 0.0

    def perf_counter(self):
        return self.now

    def work(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(fem.solver, "time", made)
    return made


def test_two_watches_are_apart(clock):
    one, other = Stopwatch(), Stopwatch()
    with one.lap("mesh"), other.lap("mesh"):
        clock.work(1)
    assert one.seconds == other.seconds == {"mesh": 1.0}
    assert one.seconds is not other.seconds


# A piece of work: its name, its own seconds before and after, and pieces inside it.
pieces = st.recursive(
    st.tuples(st.sampled_from("abc"), st.integers(0, 9), st.integers(0, 9), st.just([])),
    lambda inner: st.tuples(
        st.sampled_from("abc"), st.integers(0, 9), st.integers(0, 9), st.lists(inner, max_size=3)
    ),
    max_leaves=12,
)


@pytest.mark.slow
@given(st.lists(pieces, max_size=4))
def test_every_second_counts_once(work):
    """However laps are nested, also inside others of their name, each gets its own seconds."""
    with pytest.MonkeyPatch.context() as patch:
        clock = Clock()
        patch.setattr(fem.solver, "time", clock)
        watch = Stopwatch()
        own = {}

        def do(piece):
            name, before, after, inside = piece
            own[name] = own.get(name, 0) + before + after
            with watch.lap(name):
                clock.work(before)
                for one in inside:
                    do(one)
                clock.work(after)

        for piece in work:
            do(piece)
        assert watch.seconds == own
        assert sum(watch.seconds.values()) == clock.now


@pytest.fixture
def group(tmp_path, monkeypatch):
    monkeypatch.setattr(memory, "CONTROL_FOLDER", tmp_path)
    (tmp_path / "memory").mkdir()
    return tmp_path


def test_without_a_limit_it_is_the_machines(group):
    machine = psutil.virtual_memory().available
    assert free_memory() == close(machine, rel=0.2)
    (group / "memory.max").write_text("max\n")
    assert free_memory() == close(machine, rel=0.2)


@pytest.mark.parametrize(
    ("limit", "use", "cached"),
    [
        ("memory.max", "memory.current", "inactive_file"),
        ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes", "total_inactive_file"),
    ],
)
def test_a_containers_limit_less_what_is_used_but_for_the_cache(group, limit, use, cached):
    (group / limit).write_text("50000000\n")
    (group / use).write_text("40000000\n")
    (group / limit).with_name("memory.stat").write_text(f"anon 10000000\n{cached} 30000000\n")
    assert free_memory() == 40e6


def test_what_does_not_fit_is_refused_with_both_figures(monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 2.4e9)
    check_memory(2.3e9, "accuracy: given 0.001, whose mesh takes", "ask for a larger one")
    with refused("accuracy") as caught:
        check_memory(5.1e9, "accuracy: given 0.001, whose mesh takes", "ask for a larger one")
    assert isinstance(caught.value, NotEnoughMemoryError)
    assert all(figure in str(caught.value) for figure in ("5.1 GB", "2.4 GB"))
