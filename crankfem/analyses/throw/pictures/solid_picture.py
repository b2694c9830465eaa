"""Pictures of a throw's or a crankshaft's solid, seen from the side with the free end to the left."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.outputs import copy_file
from crankbase.processes import scratch_folder
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.scene import Scene
from crankfem.analyses.throw.pictures.solid_surface import (
    BORES,
    ENDS,
    FILLETS,
    FORGED,
    MACHINED,
    SolidSurface,
    shaft_surface,
    throw_surface,
)
from geometry.crankshaft import Crankshaft
from geometry.mesher import Throw

Array = NDArray[np.float64]

ENDING = ".png"
PICTURE = "picture.png"  # in the scratch folder
COLORS = np.zeros((5, 3), dtype=np.uint8)
COLORS[[MACHINED, ENDS]] = (208, 215, 222)
COLORS[FILLETS] = (196, 203, 211)
COLORS[FORGED] = (186, 195, 204)
COLORS[BORES] = (140, 150, 160)
# From the picture's middle to the eye.
THROW_VIEW, SHAFT_VIEW = (-1.0, 0.45, -0.6), (-1.0, 0.35, -0.45)
THROW_PIXELS, SHAFT_PIXELS = 1200, 2400  # along the longer side
SHADING: dict[str, Any] = {
    "ambient": 0.36,
    "diffuse": 0.85,
    "specular": 0.18,
    "specular_power": 25.0,
}


def picture_throw(throw: Throw, path: str | Path) -> Path:
    """Write a picture of a throw's solid.

    Parameters
    ----------
    throw : CrankThrow or ImportedThrow
    path : path
        A file ending in ``.png``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    MeshError
        If the throw cannot be meshed.
    MissingLibraryError, RenderError
        If there is no OpenGL library; the message names what to install.
    """
    path = Path(path)
    check_picture_ending(path)
    return _write(throw_surface(throw, fineness=4), THROW_VIEW, THROW_PIXELS, path)


def picture_shaft(shaft: Crankshaft, path: str | Path) -> Path:
    """Write a picture of a whole crankshaft.

    Parameters
    ----------
    shaft : Crankshaft
    path : path
        A file ending in ``.png``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError, MeshError, MissingLibraryError, RenderError
        As for `picture_throw`.
    """
    path = Path(path)
    check_picture_ending(path)
    return _write(shaft_surface(shaft, fineness=2), SHAFT_VIEW, SHAFT_PIXELS, path)


def check_picture_ending(path: Path) -> None:
    """Refuse a file name that does not end in .png.

    Raises
    ------
    InputError
    """
    if path.suffix.lower() != ENDING:
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed for a picture is {ENDING}."
        )


def _write(
    surface: SolidSurface, view: tuple[float, float, float], pixels: int, path: Path
) -> Path:
    with scratch_folder() as folder:
        OffscreenProcess(f"{__name__}:render", folder, surface, np.array(view), pixels).wait()
        try:
            copy_file(folder / PICTURE, path, "picture")
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror or error}).") from None
    return path


def render(surface: SolidSurface, view: Array, pixels: int, folder: Path) -> None:
    """Render a solid in this process.

    Parameters
    ----------
    surface : SolidSurface
    view : (3,) array
        From the picture's middle to the eye.
    pixels : int
        Of the picture's longer side.
    folder : Path
        Folder for the file `PICTURE`.
    """
    import pyvista
    from matplotlib.image import imsave

    scene = Scene(surface.points, view, pixels)
    solid = pyvista.PolyData(surface.points, np.insert(surface.triangles, 0, 3, axis=1).ravel())
    solid.cell_data["color"] = COLORS[surface.kinds]
    solid = solid.clean(tolerance=1e-6 * scene.longer, absolute=True)
    scene.add(solid, scalars="color", rgb=True, **SHADING)
    imsave(folder / PICTURE, scene.render())
    scene.close()
