"""Gmsh in this process and in its own."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

import gmsh
import pytest

from comparing import close, same_mesh
from crankbase.calls import ProcessLostError
from crankbase.errors import InputError, MeshError, MissingLibraryError
from geometry.gmsh_session import (
    DEBIAN_PACKAGES,
    IsolatedProcess,
    gmsh_session,
    load_gmsh,
    missing_library_advice,
    shared_process,
)
from geometry.mesh import MESHING_STRATEGIES, mesh_throw
from geometry.mesher import mesh_isolated
from geometry.throw import CrankThrow
from refusals import refused

ROOT = Path(__file__).parents[2]
OPTIONS = (
    "General.Terminal",
    "General.NumThreads",
    "Geometry.OCCUnionUnify",
    "Mesh.MeshSizeExtendFromBoundary",
    "Mesh.MeshSizeFromCurvature",
    "Mesh.MeshSizeFromPoints",
    "Mesh.MeshSizeFactor",
    "Mesh.ElementOrder",
    "Mesh.Algorithm3D",
)


@pytest.fixture
def own_session():
    """A caller's session with two models, the first of them current, and options of its own."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("mine")
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    gmsh.model.add("another")
    gmsh.model.setCurrent("mine")
    gmsh.option.setNumber("Mesh.MeshSizeFactor", 0.5)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 12)
    gmsh.option.setNumber("Mesh.Algorithm3D", 10)
    gmsh.option.setNumber("Mesh.ElementOrder", 2)
    gmsh.option.setNumber("General.NumThreads", 2)
    yield
    gmsh.finalize()


def state():
    return (
        gmsh.model.getCurrent(),
        sorted(gmsh.model.list()),
        [gmsh.option.getNumber(name) for name in OPTIONS],
        len(gmsh.model.mesh.getNodes()[0]),
        gmsh.model.getEntities(),
    )


def test_a_callers_session_survives_and_leaves_no_mark_on_the_mesh(
    own_session, coarse_mesh, dimensions
):
    before = state()
    mesh = mesh_throw(CrankThrow(**dimensions), 2.0)
    assert state() == before
    assert same_mesh(mesh, coarse_mesh)


def test_a_callers_model_of_the_same_name_survives(own_session):
    gmsh.model.add("throw")
    with gmsh_session("throw"):
        assert gmsh.model.getEntities() == []
    assert gmsh.model.list().count("throw") == 1
    assert gmsh.model.getCurrent() == "throw"


def test_a_callers_session_survives_a_failure(own_session, dimensions):
    before = state()
    with (
        mock.patch("geometry.mesh.set_sizes", side_effect=RuntimeError("no sizes")),
        pytest.raises(MeshError, match="gmsh could not mesh the throw: no sizes"),
    ):
        mesh_throw(CrankThrow(**dimensions), 2.0)
    assert state() == before


@pytest.mark.parametrize(("library", "package"), DEBIAN_PACKAGES.items())
def test_missing_library_names_the_debian_package(library, package):
    advice = missing_library_advice(f"{library}: cannot open shared object file")
    assert library in advice
    assert advice.endswith(f"apt-get install {package}")


def test_unknown_missing_library_is_named():
    advice = missing_library_advice("libodd-2.so.7: cannot open shared object file")
    assert re.search(r"libodd-2\.so\.7.*install", advice)
    assert "install" in missing_library_advice("something else")


def test_missing_system_library_is_reported():
    class Finder:
        def find_spec(self, name, *_):
            if name == "gmsh":
                raise OSError("libGLU.so.1: cannot open shared object file: No such file")

    with (
        mock.patch.dict(sys.modules),
        mock.patch.object(sys, "meta_path", [Finder(), *sys.meta_path]),
    ):
        del sys.modules["gmsh"]
        with pytest.raises(MissingLibraryError, match="apt-get install libglu1-mesa"):
            load_gmsh()


def test_meshing_without_the_package_names_it_too(dimensions):
    with (
        mock.patch.dict(sys.modules, {"gmsh": None}),
        pytest.raises(MissingLibraryError, match="pip install gmsh"),
    ):
        mesh_throw(CrankThrow(**dimensions), 2.0)


PIPE = """
import os, threading
from geometry.gmsh_session import gmsh_session

def write():
    with gmsh_session("any"):
        pass
    reader, writer = os.pipe()
    os.close(reader)
    try:
        os.write(writer, b"x")
    except BrokenPipeError:
        print("an error")

write()
thread = threading.Thread(target=write)
thread.start()
thread.join()
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="no such signal here")
def test_a_broken_pipe_stays_an_error():
    """Gmsh has it end the process, such as a server whose client has gone."""
    ended = subprocess.run(
        [sys.executable, "-c", PIPE], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert ended.stdout.split("\n") == ["an error", "an error", ""]


@pytest.fixture(scope="module")
def process():
    made = IsolatedProcess()
    yield made
    made.close()


@pytest.mark.slow
def test_errors_come_back_as_they_are(dimensions, process):
    with refused("part"):
        mesh_isolated(CrankThrow(**dimensions), 1.0, "eighth", process=process)
    with pytest.raises(InputError, match="unknowns"):
        mesh_isolated(CrankThrow(**dimensions), 0.02, process=process)
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        process.call("operator:truediv", 1, 0, time_limit=10.0)


@pytest.mark.slow
def test_a_hang_is_ended_and_the_next_call_served(process):
    start = time.monotonic()
    with pytest.raises(ProcessLostError, match="took longer than the limit of 1 s"):
        process.call("time:sleep", 60.0, time_limit=1.0)
    assert time.monotonic() - start < 10.0
    assert process.call("operator:add", 1, 2, time_limit=10.0) == 3


@pytest.mark.slow
@pytest.mark.parametrize("disturbance", [ValueError, KeyboardInterrupt, MemoryError])
def test_a_disturbed_call_leaves_no_answer_behind(dimensions, process, disturbance):
    """The answer of a call that was given up must not be taken for that of the next one."""

    def disturb(_):
        raise disturbance

    large = CrankThrow(**{**dimensions, "crank_radius": 0.2})
    with pytest.raises(disturbance):
        process.call(
            "geometry.mesh:mesh_throw",
            large, 3.0, "auto", None, (),
            time_limit=60.0,
            on_remark=disturb,
        )  # fmt: skip
    throw = CrankThrow(**dimensions)
    assert same_mesh(mesh_isolated(throw, 3.0, process=process), mesh_throw(throw, 3.0))
    with pytest.raises((TypeError, AttributeError)):
        process.call("operator:add", lambda: 0, 1, time_limit=10.0)
    assert process.call("operator:add", 1, 2, time_limit=10.0) == 3


@pytest.mark.slow
def test_the_mesher_loads_nothing_that_it_does_without(dimensions, process):
    mesh_isolated(CrankThrow(**dimensions), 3.0, process=process)
    loaded = process.call("builtins:eval", "set(__import__('sys').modules)", time_limit=10.0)
    assert "gmsh" in loaded
    assert not {"pydantic", "scipy", "skfem", "geometry.throw"} & loaded


@pytest.mark.slow
def test_a_call_ends_with_an_owner_that_is_killed(own, tmp_path):
    """Even where a library keeps Python's threads from running."""
    begun = tmp_path / "begun"
    setup = f"import ctypes, pathlib; pathlib.Path({str(begun)!r}).touch()"
    call = ["-n1", "-r1", "-s", setup, "ctypes.PyDLL(None).sleep(60)"]
    owner = own(
        "from geometry.gmsh_session import IsolatedProcess\n"
        f"IsolatedProcess().call('timeit:main', {call!r}, time_limit=60.0)"
    )
    owner.wait_for(begun.exists)
    assert len(owner.children()) == 1
    assert owner.end() == ([], [])


@pytest.mark.slow
def test_a_call_that_was_begun_is_made_once(process, tmp_path):
    made = [tmp_path / "first", tmp_path / "second"]
    process.begin("os:mkdir", str(made[0]))
    process.call("os:mkdir", str(made[0]), time_limit=10.0)  # twice it would fail
    process.begin("os:mkdir", str(made[1]))
    assert process.call("operator:add", 1, 2, time_limit=10.0) == 3
    assert process.call("operator:add", 2, 2, time_limit=10.0) == 4


@pytest.mark.slow
def test_a_crash_costs_one_call(process):
    with pytest.raises(ProcessLostError, match=r"SIGSEGV|code"):
        process.call(
            "os:kill", process.call("os:getpid", time_limit=10.0), signal.SIGSEGV, time_limit=10.0
        )
    assert process.call("operator:add", 1, 2, time_limit=10.0) == 3


@pytest.mark.slow
def test_a_way_of_meshing_that_crashes_is_passed_over(dimensions, monkeypatch):
    """The process dies in the first way; a fresh one goes on with the second, and the mesh says so."""
    throw = CrankThrow(**dimensions)
    process = IsolatedProcess()
    call, lost = process.call, []

    def crash_once(function, *arguments, time_limit, on_remark):
        if not lost:
            on_remark(())
            lost.append(arguments)
            raise ProcessLostError("the process that called gmsh was ended by SIGSEGV")
        return call(function, *arguments, time_limit=time_limit, on_remark=on_remark)

    monkeypatch.setattr(process, "call", crash_once)
    mesh = mesh_isolated(throw, 2.0, process=process)
    process.close()
    assert mesh.attempts == ("as planned: the process that called gmsh was ended by SIGSEGV",)
    assert mesh.size_factor == close(1.6)


def test_if_every_way_hangs_it_is_said(dimensions, monkeypatch):
    process = IsolatedProcess()

    def late(*_, **__):
        raise ProcessLostError("took longer than the limit of 60 s")

    monkeypatch.setattr(process, "call", late)
    with pytest.raises(MeshError, match=f"{len(MESHING_STRATEGIES)} ways .* took longer than the"):
        mesh_isolated(CrankThrow(**dimensions), 2.0, process=process)


@pytest.mark.slow
def test_the_process_ends_with_its_owner():
    process = IsolatedProcess()
    number = process.call("os:getpid", time_limit=10.0)
    process.close()
    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)


def test_one_process_serves_all_analyses():
    assert shared_process() is shared_process()
