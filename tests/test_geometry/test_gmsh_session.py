import signal
import subprocess
import sys
from pathlib import Path
from unittest import mock

import gmsh
import numpy as np
import pytest

from crankbase.errors import MeshError, MissingLibraryError
from geometry.gmsh_session import DEBIAN_PACKAGES, gmsh_session, load_gmsh, missing_library_advice
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow

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


def test_nothing_stays_open(coarse_mesh):
    assert not gmsh.isInitialized()


def test_a_callers_session_survives_and_leaves_no_mark_on_the_mesh(
    own_session, coarse_mesh, dimensions
):
    before = state()
    mesh = mesh_throw(CrankThrow(**dimensions), 2.0)
    assert state() == before
    assert np.array_equal(mesh.points, coarse_mesh.points)


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


def test_own_session_is_closed_after_a_failure(dimensions):
    with (
        mock.patch("geometry.mesh.set_sizes", side_effect=RuntimeError("no sizes")),
        pytest.raises(MeshError),
    ):
        mesh_throw(CrankThrow(**dimensions), 2.0)
    assert not gmsh.isInitialized()


@pytest.mark.parametrize(("library", "package"), DEBIAN_PACKAGES.items())
def test_missing_library_names_the_debian_package(library, package):
    advice = missing_library_advice(
        "gmsh", f"{library}: cannot open shared object file: No such file or directory"
    )
    assert advice.startswith(f"gmsh needs the system library {library}; ")
    assert advice.endswith(f"apt-get install {package}")


def test_unknown_missing_library_is_named():
    advice = missing_library_advice("gmsh", "libodd-2.so.7: cannot open shared object file")
    assert "libodd-2.so.7" in advice
    assert "install" in advice
    assert "a system library" in missing_library_advice("gmsh", "something else")


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


def test_missing_package_is_reported():
    with (
        mock.patch.dict(sys.modules, {"gmsh": None}),
        pytest.raises(MissingLibraryError, match="pip install gmsh"),
    ):
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
