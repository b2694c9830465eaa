"""A gmsh session without side effects, and the process of its own in which it runs."""

import atexit
import ctypes
import math
import re
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.calls import CallProcess, Limits, answered
from crankbase.errors import InputError, MeshError, MissingLibraryError
from crankbase.processes import once_per_process, start_child

# The Debian and Ubuntu packages of the system libraries that gmsh's wheel loads.
DEBIAN_PACKAGES = {
    "libGLU.so.1": "libglu1-mesa",
    "libGL.so.1": "libgl1",
    "libOpenGL.so.0": "libopengl0",
    "libX11.so.6": "libx11-6",
    "libXcursor.so.1": "libxcursor1",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXrender.so.1": "libxrender1",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libgomp.so.1": "libgomp1",
}

# A write to a closed pipe or socket: an error in Python, the end of the process once gmsh is initialized.
SIGPIPE = getattr(signal, "SIGPIPE", None)
# Of which gmsh's arrays are.
NUMBERS = (ctypes.c_double, ctypes.c_int, ctypes.c_size_t)

# Silent, reproducible (one thread), element sizes from our own size field alone, and the rest as gmsh
# has it by default, whatever a user's own session says.
OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Geometry.Tolerance": 1e-8,
    "Geometry.OCCParallel": 0,
    "Geometry.OCCUnionUnify": 1,
    "Mesh.Algorithm": 6,
    "Mesh.Algorithm3D": 1,
    "Mesh.ElementOrder": 1,
    "Mesh.HighOrderOptimize": 0,
    # Lengths of curves in elements, to so much; gmsh's own 1e-9 takes half of the time of a mesh.
    "Mesh.LcIntegrationPrecision": 1e-5,
    "Mesh.MaxNumThreads1D": 0,
    "Mesh.MaxNumThreads2D": 0,
    "Mesh.MaxNumThreads3D": 0,
    "Mesh.MeshSizeMax": 1e22,
    "Mesh.MeshSizeMin": 0,
    "Mesh.Optimize": 1,
    "Mesh.OptimizeThreshold": 0.3,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.RandomFactor3D": 1e-12,
    "Mesh.RecombineAll": 0,
    "Mesh.SecondOrderIncomplete": 0,
    "Mesh.SecondOrderLinear": 0,
    "Mesh.SubdivisionAlgorithm": 0,
    "Mesh.Smoothing": 1,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeFactor": 1,
}


def load_gmsh() -> Any:
    """Import gmsh.

    Raises
    ------
    MissingLibraryError
        If gmsh or a system library it needs is missing; the message names what to install.
    """
    try:
        import gmsh
    except ModuleNotFoundError:
        raise MissingLibraryError(
            "The Python package gmsh is missing; install it with: pip install gmsh"
        ) from None
    except OSError as error:
        raise MissingLibraryError(missing_library_advice(str(error))) from None
    return gmsh


def missing_library_advice(loader_message: str) -> str:
    """Turn the loader's error about a shared library into installation advice."""
    file_name = re.search(r"lib[\w+-]+\.so[.\d]*", loader_message)
    library = file_name.group(0) if file_name else "a system library"
    debian = DEBIAN_PACKAGES.get(library)
    if debian is None:
        return f"gmsh cannot load {library} ({loader_message}); install the package that has it."
    return (
        f"gmsh needs the system library {library}; on Debian or Ubuntu install it with: "
        f"apt-get install {debian}"
    )


@contextmanager
def gmsh_session(name: str) -> Iterator[Any]:
    """Open gmsh with one thread and a model of its own; close what was opened.

    gmsh is global to the process. With one thread it gives the same mesh bit for bit; with more it
    does not. ``interruptible=False`` lets it run outside the main thread.
    """
    gmsh = load_gmsh()
    mine = not gmsh.isInitialized()
    if mine:
        # In any thread: give back to a broken pipe what gmsh takes from it.
        of_pipe = None if SIGPIPE is None else _signal("getsig", ctypes.c_int)(SIGPIPE)
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        if SIGPIPE is not None:
            _signal("setsig", ctypes.c_int, ctypes.c_void_p)(SIGPIPE, of_pipe)
    before = {option: gmsh.option.getNumber(option) for option in OPTIONS}
    current = None if mine else gmsh.model.getCurrent()
    views = set(gmsh.view.getTags())
    gmsh.model.add(name)
    try:
        for option, value in OPTIONS.items():
            gmsh.option.setNumber(option, value)
        yield gmsh
    finally:
        gmsh.model.remove()
        if mine:
            gmsh.finalize()
        else:
            for option, value in before.items():
                gmsh.option.setNumber(option, value)
            gmsh.model.setCurrent(current)
            for view in set(gmsh.view.getTags()) - views:  # these do not go with their model
                gmsh.view.remove(view)


def _signal(name: str, *arguments: Any) -> Any:
    return ctypes.PYFUNCTYPE(ctypes.c_void_p, *arguments)((f"PyOS_{name}", ctypes.pythonapi))


@contextmanager
def gmsh_errors(what: str) -> Iterator[None]:
    """Turn gmsh's bare Exception into a MeshError "gmsh could not `what`"."""
    try:
        yield
    except (InputError, MeshError, MissingLibraryError):
        raise
    except Exception as error:
        raise MeshError(f"gmsh could not {what}: {error}") from error


def read_shapes(gmsh: Any, path: str) -> list[tuple[int, int]]:
    """Read a CAD file into the model; return dimension and tag of its shapes of highest dimension.

    Raises
    ------
    InputError
        If it cannot be read.
    """
    try:
        shapes: list[tuple[int, int]] = gmsh.model.occ.importShapes(path, highestDimOnly=True)
    except Exception as error:
        if type(error) is not Exception:  # which gmsh raises; others are not the file's fault
            raise
        raise InputError(f"{path}: given a file that cannot be read: {error}.") from None
    return shapes


def forget_array_types() -> None:
    """Delete the types that ctypes creates for arrays of numbers, one for each length, and keeps.

    gmsh returns its arrays with such types; in a long study they take 70 kB a mesh.
    """
    kept: dict[Any, Any] = getattr(ctypes, "_pointer_type_cache", {})
    for kind in list(kept):
        number: Any = getattr(kind, "_type_", None)
        if isinstance(kind, type) and issubclass(kind, ctypes.Array) and number in NUMBERS:
            kept.pop(kind, None)


def middle_point(gmsh: Any, dimension: int, tag: int) -> Array:
    """Return a point on a curve or surface, in the middle of its parameters."""
    middle = _middle_parameters(gmsh, dimension, tag)
    return np.asarray(gmsh.model.getValue(dimension, tag, middle), dtype=float)


def curvature_radius(gmsh: Any, tag: int) -> float:
    """Smallest radius of curvature in the middle of a face."""
    most, least, *_ = gmsh.model.getPrincipalCurvatures(tag, _middle_parameters(gmsh, 2, tag))
    curvature = max(abs(float(most[0])), abs(float(least[0])))
    return 1.0 / curvature if curvature > 0.0 else math.inf


def _middle_parameters(gmsh: Any, dimension: int, tag: int) -> list[float]:
    low, high = gmsh.model.getParametrizationBounds(dimension, tag)
    return [0.5 * (first + last) for first, last in zip(low, high, strict=True)]


class IsolatedProcess:
    """A process that calls functions of our packages by name, from any thread, one at a time."""

    def __init__(self) -> None:
        self._process: CallProcess | None = None
        self._begun: tuple[Any, ...] | None = None
        self._lock = threading.Lock()

    def start(self) -> CallProcess:
        """Start the process, if none runs, so that it is ready when needed."""
        if self._process is None or not self._process.alive:
            child = start_child(
                "crankbase.calls",
                "geometry.mesh:keep_solids",
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            self._process, self._begun = CallProcess(child, "the process that called gmsh"), None
        return self._process

    def begin(self, function: str, *arguments: Any, remarks: bool = False) -> None:
        """Let it begin a call, with remarks or without, that is to be made later."""
        with self._lock:
            if self._begun is not None:
                self.close()
            self.start().give(function, *arguments, remarks=remarks)
            self._begun = (function, *arguments)

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.end()

    def call(
        self,
        function: str,
        *arguments: Any,
        time_limit: float,
        on_remark: Callable[[Any], None] | None = None,
    ) -> Any:
        """Call a function there.

        Parameters
        ----------
        function : str
            ``"module:name"``. If `on_remark` is given, the function gets a callable of that name.
        *arguments
            Any that can be pickled.
        time_limit : float
            Time limit to the next remark or the result [s].
        on_remark : callable, optional
            Called here with each remark that the function makes there.

        Raises
        ------
        crankbase.calls.ProcessLostError
            If the process died or took too long; the next call starts a fresh one.
        InputError, MeshError, MissingLibraryError
            As raised by the function.
        """
        with self._lock:
            try:
                if self._begun not in (None, (function, *arguments)):
                    self.close()  # the answer to another call is on its way
                process = self.start()
                if self._begun is None:
                    process.give(function, *arguments, remarks=on_remark is not None)
                self._begun = None
                answer = process.wait(Limits(time_limit), on_remark)
            except BaseException:
                # An answer may still be on its way: it must not be taken for that of the next call.
                self.close()
                raise
        return answered(*answer)


@once_per_process
def shared_process() -> IsolatedProcess:
    """Return the process shared by all calls from this one; a forked child gets its own."""
    process = IsolatedProcess()
    atexit.register(process.close)
    return process
