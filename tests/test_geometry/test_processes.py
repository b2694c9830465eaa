import signal
import subprocess

import pytest

from crankbase.processes import end_child, scratch_folder, signal_name, start_child

FOLDER = """
import time
from crankbase.processes import scratch_folder
with scratch_folder() as folder:
    (folder / "inner").mkdir()
    (folder / "inner" / "file").touch()
    time.sleep(60)
"""


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
