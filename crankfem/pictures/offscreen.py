"""Render off-screen in a process of its own.

VTK ends its process where no OpenGL library can be loaded; in a process of its own that costs the
pictures and nothing else.
"""

import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import MissingLibraryError
from geometry.processes import package_environment

ADVICE = (
    "the pictures of the throw could not be rendered; on Debian or Ubuntu install the off-screen "
    "OpenGL library with: apt-get install libegl1"
)
TIME_LIMIT = 120.0  # [s]


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
    """

    def __init__(self, module: str, arrays: Mapping[str, Any], target: Path) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix="crankfem-")
        data = Path(self._scratch.name) / "arrays.npz"
        np.savez(data, **arrays)
        # -P keeps a folder named like our packages in the working directory out of the way.
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", module, str(data), str(target)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=package_environment(),
        )

    def wait(self) -> None:
        """Wait for the pictures.

        Raises
        ------
        MissingLibraryError
            If they could not be made; the message names what to install.
        """
        try:
            code = self._process.wait(timeout=TIME_LIMIT)
        except subprocess.TimeoutExpired:
            code = -1
        finally:
            self.stop()
        if code != 0:
            raise MissingLibraryError(ADVICE)

    def stop(self) -> None:
        """End the rendering and remove its scratch files."""
        self._process.kill()
        self._process.wait()
        self._scratch.cleanup()


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
