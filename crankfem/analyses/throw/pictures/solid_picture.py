"""Pictures of a throw's or a crankshaft's solid, seen from the side with the free end to the left."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.outputs import copy_file
from crankbase.processes import scratch_folder
from crankfem.analyses.throw.pictures.offscreen import (
    OffscreenProcess,
    make_plotter,
    triangle_mesh,
)
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
LINE_COLOR, LINE_WIDTH = "#2a3644", 2.5
SHARP = 30.0  # an angle between faces that makes an edge [deg]
# From the picture's middle to the eye.
THROW_VIEW, SHAFT_VIEW = (-1.0, 0.45, -0.6), (-1.0, 0.35, -0.45)
THROW_PIXELS, SHAFT_PIXELS = 1200, 2400  # along the longer side
MARGIN = 0.02  # of the longer side
# Directions from which light falls, seen by the eye (right, up, towards it), and how much.
LIGHTS = (((-0.5, 0.9, 1.0), 0.6), ((0.8, 0.2, 0.6), 0.2), ((0.0, 0.0, 1.0), 0.3))
SHADING: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": True,
    "feature_angle": SHARP,
    "ambient": 0.36,
    "diffuse": 0.85,
    "specular": 0.18,
    "specular_power": 25.0,
}
# Lines are moved towards the eye by this share of the solid's size, so that no face covers them.
LIFT = 0.003


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
        If the ending is another, or the file cannot be written.
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
    """Refuse a file name that is no PNG's.

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
        Where the file `PICTURE` is written.
    """
    import pyvista

    towards, right, up = _axes(view)
    seen = surface.points @ np.column_stack([right, up])
    low, high = seen.min(axis=0), seen.max(axis=0)
    longer = float((high - low).max())
    extent = high - low + 2.0 * MARGIN * longer
    width, height = np.ceil(pixels * extent / extent.max()).astype(int).tolist()
    picture = make_plotter((width, height), lighting="none")
    for place, intensity in LIGHTS:
        picture.add_light(
            pyvista.Light(position=place, light_type="camera light", intensity=intensity)
        )
    solid = triangle_mesh(surface.points, surface.triangles)
    solid.cell_data["color"] = COLORS[surface.kinds]
    solid = solid.clean(tolerance=1e-6 * longer, absolute=True)
    picture.add_mesh(solid, scalars="color", rgb=True, **SHADING)
    _add_lines(picture, solid, LIFT * longer * towards)

    middle = 0.5 * (low + high) @ np.array([right, up])
    camera = picture.camera
    camera.focal_point, camera.position, camera.up = middle, middle + 10.0 * longer * towards, up
    camera.parallel_projection, camera.parallel_scale = True, 0.5 * float(extent[1])
    picture.renderer.reset_camera_clipping_range()
    picture.screenshot(folder / PICTURE)
    picture.close()


def _add_lines(picture: Any, solid: Any, lift: Array) -> None:
    """Draw the silhouette and the sharp edges, moved by `lift`."""
    style = {"color": LINE_COLOR, "line_width": LINE_WIDTH}
    lines = [picture.add_silhouette(solid, **style)]
    edges = solid.extract_feature_edges(
        feature_angle=SHARP, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
    )
    if edges.n_cells:
        lines.append(picture.add_mesh(edges, lighting=False, **style))
    for line in lines:
        line.position = lift


def _axes(view: Array) -> tuple[Array, Array, Array]:
    """Unit vectors towards the eye, to its right, and up."""
    towards = view / math.sqrt(float(view @ view))
    right = np.cross((0.0, 1.0, 0.0), towards)
    right /= np.linalg.norm(right)
    return towards, right, np.cross(towards, right)
