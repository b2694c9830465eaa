import json
import math
import os
import re
import signal
import subprocess
import sys
import threading
import time
import uuid
from pathlib import Path

import pytest

from crankbase.calls import Limits
from crankbase.errors import InputError
from fem.material import STEEL
from fem.responses import ThrowResponses, evaluate_throw
from geometry.throw import CrankThrow
from puppets import marked, spawned
from regression.runs import workers as workers_module
from regression.runs.workers import TIME_LIMIT, design_limits, interrupts_deferred, run_designs
from throws import MEDIUM_SPEED

ROOT = Path(__file__).resolve().parents[2]
THROW = MEDIUM_SPEED | {"fillet_radius": 0.0}
needs_proc = pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")

# Answers at once; what else it does is told by the key.
PUPPET = """
for request in requests():
    key = request["key"]
    if key.startswith("die"):
        os._exit(7)
    if key.startswith("hang"):
        time.sleep(600)
    if key.startswith("slow"):
        time.sleep(0.3)
    if key.startswith("half"):
        os.write(1, b'{"key": "ha')
        os._exit(0)
    if key.startswith("stuck"):
        os.write(1, bytes([128, 4, 149]))
        time.sleep(600)
    if key.startswith("large"):
        held = b"x" * 560_000_000
        time.sleep(600)
    if key.startswith("full"):
        answer({"key": key, "lost": "OSError: disk full", "seconds": 0.1})
        continue
    if key.startswith("unloaded"):
        pickle.dump(("ImportError", "ImportError: a.so: failed to map segment"), sys.stdout.buffer)
        sys.stdout.buffer.flush()
        continue
    if key.startswith("shy") and not os.path.exists(key.split()[1]):
        open(key.split()[1], "w").close()
        os._exit(7)
    answer({"key": key, "responses": {"x": 1.0}, "seconds": 0.0})
"""


def design(**changes):
    throw = THROW | changes
    return {"throw": throw, "material": STEEL.model_dump(), "accuracy": 0.1, "stresses": False}


@pytest.fixture
def mark(monkeypatch):
    """Mark the processes that a test starts, so that they are told from anyone else's."""
    value = f"CRANKFEM_TEST={uuid.uuid4()}"
    monkeypatch.setenv(*value.split("="))
    return value.encode()


@pytest.fixture
def puppets(monkeypatch):
    return spawned(monkeypatch, PUPPET)


def collect(keys, count=2, seconds=TIME_LIMIT, **options):
    found = {}

    def keep(outcome):
        assert outcome.key not in found, "a design has one outcome"
        found[outcome.key] = outcome

    limits = Limits(seconds, **options)
    run_designs([(key, {"number": key}) for key in keys], keep, count, limits)
    return found


# ------------------------------------------------------------------------ supervision, by puppets


def test_no_designs_start_no_worker(puppets):
    assert collect([]) == {}
    assert puppets == []


def test_a_design_that_kills_its_worker_costs_itself_alone(puppets):
    found = collect(["a", "die", "b", "c", "d"])
    assert {key for key, outcome in found.items() if outcome.responses} == {"a", "b", "c", "d"}
    assert found["die"].reason.endswith("(exit code 7)")
    assert (found["die"].lost, found["die"].attempts, found["a"].attempts) == (True, 2, 1)
    # Two to begin with, and one more after each of the two tries.
    assert len(puppets) <= 4


@pytest.mark.slow
def test_a_design_that_hangs_is_given_up(puppets):
    began = time.monotonic()
    found = collect(["a", "hang", "b"], seconds=0.7)
    assert time.monotonic() - began < 10.0
    assert {key for key, outcome in found.items() if outcome.responses} == {"a", "b"}
    assert found["hang"].reason.endswith("0.7 s")
    assert found["hang"].seconds >= 0.7
    assert all(process.poll() is not None for process in puppets)


@pytest.mark.slow
def test_a_worker_that_hangs_within_its_answer_is_given_up(puppets):
    found = collect(["a", "stuck"], seconds=0.7)
    assert found["stuck"].reason.endswith("0.7 s")
    assert found["a"].responses


def test_a_crash_that_happens_once_costs_a_retry(puppets, tmp_path):
    key = f"shy {tmp_path / 'mark'}"
    found = collect(["a", key, "b"])
    assert all(outcome.responses for outcome in found.values())
    assert found[key].attempts == 2
    assert found[key].worker


@pytest.mark.parametrize(
    ("key", "reason"),
    [
        ("full", "OSError: disk full"),
        # As where memory runs out before the worker has loaded its libraries.
        ("unloaded", "ImportError: a.so: failed to map segment"),
    ],
)
def test_a_design_that_the_machine_could_not_compute_is_lost_after_a_fresh_process(
    puppets, key, reason
):
    found = collect(["a", key, "b"], 1)
    assert {name for name, outcome in found.items() if outcome.responses} == {"a", "b"}
    lost = found[key]
    assert (lost.reason, lost.lost, lost.attempts) == (reason, True, 2)
    assert len(puppets) == 2  # nobody waits after the second try


def test_a_worker_that_dies_in_the_middle_of_its_answer(puppets):
    found = collect(["a", "half", "b"])
    assert {key for key, outcome in found.items() if outcome.responses} == {"a", "b"}
    assert found["half"].reason.endswith("(exit code 0)")


def test_the_signal_that_ended_a_worker_is_named(puppets):
    over = threading.Event()

    def kill():  # as the system does when memory runs out
        while not over.wait(0.1):
            for process in list(puppets):
                process.kill()

    killer = threading.Thread(target=kill)
    killer.start()
    found = collect(["hang"], 1)
    over.set()
    killer.join()
    assert "SIGKILL" in found["hang"].reason


@pytest.mark.slow
def test_a_design_that_takes_too_much_memory_is_given_up(puppets):
    found = collect(["a", "large", "b"], memory=0.5e9)
    assert {key for key, outcome in found.items() if outcome.responses} == {"a", "b"}
    # The peak seen lies between the limit and what the puppet took in all.
    named = re.fullmatch(
        r"took (0\.\d\d) GB of memory, more than the limit of 0\.5 GB", found["large"].reason
    )
    assert 0.5 <= float(named[1]) <= 0.6
    assert found["large"].attempts == 2
    assert all(process.poll() is not None for process in puppets)


@pytest.mark.slow
def test_the_next_design_is_given_before_the_answer_is_stored(puppets):
    began = time.monotonic()
    run_designs([(f"slow {n}", {}) for n in range(4)], lambda _: time.sleep(0.3), 1)
    # 4 x 0.3 s of work and the last store, 1.5 s; one after the other it would be 2.4 s.
    assert time.monotonic() - began < 2.1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time_limit": 0.0}, "time_limit: given 0 s; allowed is a positive"),
        ({"time_limit": math.inf}, "time_limit: given inf; allowed is a finite number of seconds"),
        ({"memory_limit": "4 GB"}, "memory_limit: given '4 GB'; allowed is a finite number of"),
        ({"memory_limit": 1e8}, r"memory_limit: given 0\.1 GB; allowed is 0\.5 GB or more"),
        ({"memory_limit": math.nan}, "memory_limit: given nan; allowed is"),
    ],
)
def test_limits_that_cannot_be(given, message):
    with pytest.raises(InputError, match=f"^{message}"):
        design_limits(0.01, **given)


def test_a_finer_study_may_take_longer():
    assert design_limits(0.1).seconds == design_limits(0.01).seconds == 300.0
    assert design_limits(0.001).seconds == 3000.0
    assert design_limits(0.001, 60.0, 2e9) == Limits(60.0, 2e9)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_does_not_cost_the_design_that_is_just_being_stored(puppets):
    stored = []

    def keep(outcome):
        signal.raise_signal(signal.SIGINT)
        stored.append(outcome.key)

    with pytest.raises(KeyboardInterrupt):
        run_designs([(key, {}) for key in "abc"], keep, 1)
    assert stored == ["a"]
    assert all(process.poll() is not None for process in puppets)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_waits_for_the_end_of_the_block():
    before, done = signal.getsignal(signal.SIGINT), []

    def interrupted():
        with interrupts_deferred():
            signal.raise_signal(signal.SIGINT)
            done.append("all")

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert done == ["all"]
    assert signal.getsignal(signal.SIGINT) is before
    with interrupts_deferred():
        pass  # nothing is left of the interrupt
    thread = threading.Thread(target=interrupts_deferred().__enter__)
    thread.start()
    thread.join()
    assert signal.getsignal(signal.SIGINT) is before


def test_who_ignores_interrupts_goes_on_doing_so():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interrupts_deferred():
            signal.raise_signal(signal.SIGINT)
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


# --------------------------------------------------------------------------- the worker's own work


@pytest.mark.slow
def test_a_worker_computes_and_tells_what_it_cannot():
    requests = [
        {"key": "bad", "inputs": design(web_width=0.100)},
        {"key": "worse", "inputs": {}},
        {"key": "good", "inputs": design()},
    ]
    bad, worse, good = map(workers_module.answer, requests)
    assert bad["key"] == "bad"
    assert bad["reason"].startswith("InputError: throw.main_journal_diameter: given 220 mm")
    assert "responses" not in bad
    assert "reason" in worse
    expected = evaluate_throw(CrankThrow(**THROW), STEEL, 0.1)
    assert good["responses"] == expected.values
    assert good["errors"] == expected.errors
    assert good["unknowns"] == expected.unknowns
    assert good["seconds"] > 0.0


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("part", [0, 1])
def test_a_result_that_is_no_number_is_a_failure(monkeypatch, value, part):
    bad, good = {"axial_compliance_pinned": value, "mass": 1.0}, {"mass": 1.0}
    found = ThrowResponses(*((bad, good) if part == 0 else (good, bad)), 10)
    monkeypatch.setattr(workers_module, "evaluate_throw", lambda *_, **__: found)
    answer = workers_module.answer({"key": "k", "inputs": design()})
    assert set(answer) == {"key", "reason", "seconds"}
    assert "axial_compliance_pinned came out as" in answer["reason"]


class PyPardisoError(Exception):
    """As pypardiso raises it: -2 is no memory, -4 a matrix that is not positive definite."""

    __module__ = "pypardiso.pardiso_wrapper"

    def __init__(self, value):
        self.value = value


@pytest.mark.parametrize(
    ("error", "cause", "kind"),
    [
        (MemoryError("no room"), None, "lost"),
        (OSError(28, "No space left on device"), None, "lost"),
        (ImportError("a.so: failed to map segment from shared object"), None, "lost"),
        (RuntimeError("no solution"), MemoryError(), "lost"),
        (RuntimeError("no solution"), PyPardisoError(-2), "lost"),
        (RuntimeError("no solution"), PyPardisoError(-4), "reason"),
        (RuntimeError("no solution"), None, "reason"),
        (ValueError("too narrow"), None, "reason"),
    ],
)
def test_trouble_of_the_machine_is_told_from_that_of_the_design(monkeypatch, error, cause, kind):
    def fail(*_, **__):
        raise error from cause

    monkeypatch.setattr(workers_module, "evaluate_throw", fail)
    answer = workers_module.answer({"key": "k", "inputs": design()})
    assert set(answer) == {"key", kind, "seconds"}
    assert answer[kind] == f"{type(error).__name__}: {error}"


# ------------------------------------------------------------------------------------ real workers


@pytest.mark.slow
@needs_proc
def test_workers_killed_in_the_middle_cost_a_retry(mark):
    widths = [0.270, 0.280, 0.290, 0.300, 0.310]
    designs = [(f"k{width}", design(web_width=width)) for width in widths]
    designs.append(("impossible", design(web_width=0.100)))
    found, killed = {}, []

    def keep(outcome):
        found[outcome.key] = outcome
        if outcome.responses and not killed:
            killed.extend(marked(mark))
            for process in killed:
                os.kill(process, signal.SIGKILL)

    run_designs(designs, keep, 2)
    assert len(killed) == 2
    assert marked(mark) == []
    assert len(found) == len(designs)
    assert found["impossible"].responses is None
    assert "throw.main_journal_diameter: given 220 mm" in found["impossible"].reason
    compliances = [found[f"k{w}"].responses["axial_compliance_pinned"] for w in widths]
    assert compliances == sorted(compliances, reverse=True)


@pytest.mark.slow
@needs_proc
def test_workers_find_the_packages_of_their_coordinator(tmp_path, mark):
    # However the coordinator found the packages, and whatever lies in the working directory.
    (tmp_path / "fem.py").write_text("raise SystemExit('a foreign module')\n", encoding="utf-8")
    code = f"""
import json, sys
sys.path.insert(0, {str(ROOT)!r})
sys.path[:] = [place for place in sys.path if place not in ("", {str(tmp_path)!r})]
from regression.runs.workers import run_designs
run_designs(
    [("k", {design()!r})], lambda o: print(json.dumps([o.responses is not None, o.reason])), 1
)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [True, None]
    assert marked(mark) == []


@pytest.mark.slow
def test_a_worker_ends_when_its_coordinator_is_gone():
    process = workers_module.spawn_worker()
    assert process.poll() is None
    process.stdin.close()
    assert process.wait(timeout=30.0) == 0
    assert process.stdout.read() == b""
    process.stdout.close()


@pytest.mark.parametrize("seconds", [0.0, pytest.param(4.0, marks=pytest.mark.slow)])
def test_workers_end_with_a_coordinator_that_is_killed(own, seconds):
    """While they start, and in the middle of a design."""
    request = {"key": "k", "inputs": design() | {"accuracy": 0.002}}
    owner = own(
        "import time; from regression.runs.workers import SupervisedProcess\n"
        "workers = [SupervisedProcess() for _ in range(2)]\n"
        f"for worker in workers: worker.compute({request!r})\n"
        "time.sleep(60)"
    )
    owner.wait_for(lambda: len(owner.children()) == 2)
    time.sleep(seconds)
    assert len(owner.children()) == 2
    assert owner.end() == ([], [])
