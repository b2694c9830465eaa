"""Render off-screen in a process of its own.

VTK ends its process where no OpenGL library can be loaded; in a process of its own that costs the
pictures and nothing else.
"""

import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import MissingLibraryError, RenderError
from geometry.processes import package_environment

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


class OffscreenProcess:
    """A module of ours that renders in the background what it reads from a file of arrays.

    Parameters
    ----------
    module : str
        Run as ``python -m module ARRAYS.npz TARGET``.
    arrays : mapping
        What the module reads.
    target : Path
        File or folder that it writes.

    Raises
    ------
    OSError
        If the arrays cannot be written, or the process cannot be started.
    """

    def __init__(self, module: str, arrays: Mapping[str, Any], target: Path) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix="crankfem-")
        data = Path(self._scratch.name) / "arrays.npz"
        self._said = Path(self._scratch.name) / "said.txt"
        try:
            np.savez(data, **arrays)
            with self._said.open("wb") as said:
                # -P keeps a folder named like our packages in the working directory out of the way.
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", module, str(data), str(target)],
                    stdout=subprocess.DEVNULL,
                    stderr=said,
                    env=package_environment(),
                )
        except OSError:
            self._scratch.cleanup()
            raise

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
        """End the rendering and remove its scratch files."""
        self._process.kill()
        self._process.wait()
        self._scratch.cleanup()


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
    try:
        ended = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    except ValueError:
        ended = f"exit code {code}"
    # An exception's last line says what happened.
    last = next((line.strip() for line in reversed(said.splitlines()) if line.strip()), "")
    reason = f", saying: {last.rstrip('.')}" if last else ""
    return RenderError(f"{UNRENDERED}, because the process for it ended with {ended}{reason}.")


def _end_of(path: Path) -> str:
    return path.read_bytes()[-SAID:].decode(errors="replace")


def read_arguments() -> tuple[dict[str, NDArray[Any]], Path]:
    """Return what `OffscreenProcess` has handed to this process: arrays and target."""
    with np.load(sys.argv[1]) as data:
        return dict(data), Path(sys.argv[2])


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
