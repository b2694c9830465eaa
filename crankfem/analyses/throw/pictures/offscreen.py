"""Render off-screen in a process of its own.

VTK ends its process where no OpenGL library can be loaded; in a process of its own that costs the
pictures and nothing else.
"""

import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import MissingLibraryError, RenderError
from crankbase.processes import end_child, signal_name, start_child

UNRENDERED = "the pictures of the throw could not be rendered"
ADVICE = (
    f"{UNRENDERED}; on Debian or Ubuntu install the off-screen OpenGL library with: "
    "apt-get install libegl1"
)
# What VTK says before it ends its process, and what Python says of a package that is not there.
NO_OPENGL = re.compile(r"Failed to load EGL|OSMesa not found|lib(EGL|GL|OpenGL|OSMesa)\.so")
NO_PACKAGE = re.compile(r"^(?:ModuleNotFoundError|ImportError): (.+)$", re.MULTILINE)
TIME_LIMIT = 120.0  # [s]
# Of what a process has said, so much is looked at.
SAID = 20_000
ARRAYS = "arrays.npz"


class OffscreenProcess:
    """A module of ours that renders in the background what it reads from a file of arrays.

    Parameters
    ----------
    module : str
        Run as ``python -m module FOLDER``.
    arrays : mapping
        What the module reads.
    folder : Path
        A scratch folder: for the arrays, and for what the module writes.

    Raises
    ------
    OSError
        If the arrays cannot be written, or the process cannot be started.
    """

    def __init__(self, module: str, arrays: Mapping[str, Any], folder: Path) -> None:
        self._said = folder / "said.txt"
        np.savez(folder / ARRAYS, **arrays)
        with self._said.open("wb") as said:
            self._process = start_child(
                module,
                str(folder),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
            )

    def wait(self) -> None:
        """Wait for the pictures.

        Raises
        ------
        MissingLibraryError
            If a library is missing; the message names what to install.
        RenderError
            If they could not be made for another reason, which the message gives.
        """
        try:
            code = self._process.wait(timeout=TIME_LIMIT)
            said = _end_of(self._said)
        except subprocess.TimeoutExpired:
            raise RenderError(
                f"{UNRENDERED}, because that took longer than {TIME_LIMIT:g} s; try again when the machine "
                "has less to do."
            ) from None
        finally:
            self.stop()
        if code != 0:
            raise render_failure(code, said)

    def stop(self) -> None:
        """End the rendering."""
        end_child(self._process)


def render_failure(code: int, said: str) -> MissingLibraryError | RenderError:
    """Return the error that says why a process has not rendered.

    Parameters
    ----------
    code : int
        With which it ended; a negative one is that of a signal.
    said : str
        What it wrote to standard error.
    """
    missing = NO_PACKAGE.findall(said)
    if NO_OPENGL.search(said):
        return MissingLibraryError(ADVICE)
    if missing:
        return MissingLibraryError(f"{UNRENDERED}: {missing[-1]}")
    ended = signal_name(code) or f"exit code {code}"
    # An exception's last line says what happened.
    last = next((line.strip() for line in reversed(said.splitlines()) if line.strip()), "")
    reason = f", saying: {last.rstrip('.')}" if last else ""
    return RenderError(f"{UNRENDERED}, because the process for it ended with {ended}{reason}.")


def _end_of(path: Path) -> str:
    return path.read_bytes()[-SAID:].decode(errors="replace")


def read_arguments() -> tuple[dict[str, NDArray[Any]], Path]:
    """Return what `OffscreenProcess` has handed to this process: arrays, and the folder to write in."""
    folder = Path(sys.argv[1])
    with np.load(folder / ARRAYS) as data:
        return dict(data), folder


def triangle_mesh(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> Any:
    """Make pyvista's mesh of triangles (t, 3)."""
    import pyvista

    return pyvista.PolyData(points, np.insert(triangles, 0, 3, axis=1).ravel())


def make_plotter(size: tuple[int, int], **options: Any) -> Any:
    """Make a plotter of so many pixels with a white background."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=size, **options)
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    return plotter
