"""Render the pictures of a run: the mesh of a throw, and how an axial force deforms it."""

from pathlib import Path
from typing import Any

import numpy as np

from crankfem.analyses.throw.pictures.offscreen import (
    OffscreenProcess,
    make_plotter,
    triangle_mesh,
)
from crankfem.analyses.throw.pictures.surface import Surface

MESH, DEFORMED = "throw_mesh.png", "throw_deformed.png"
STEEL_COLOR, EDGE_COLOR = "#b9c4d0", "#33475b"
SHADING: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": True,
    "ambient": 0.45,
    "diffuse": 0.65,
    "specular": 0.1,
}
# The largest displacement is drawn as this share of the throw's length.
DRAWN_DISPLACEMENT = 0.06
SIZE, MARGIN = (1100, 800), 12  # pixels


class Rendering(OffscreenProcess):
    """The pictures of a surface being rendered in the background, into a folder."""

    def __init__(self, surface: Surface, folder: Path) -> None:
        super().__init__(f"{__name__}:render", folder, surface)


def render(surface: Surface, folder: Path) -> None:
    """Write the pictures of the mesh and of the deformed throw."""
    import pyvista

    lines = np.insert(surface.edges, 0, 3, axis=1)
    edges = pyvista.PolyData(surface.points, lines=lines.ravel())
    picture = make_plotter(SIZE)
    picture.add_mesh(triangle_mesh(surface.points, surface.triangles), color=STEEL_COLOR, **SHADING)
    picture.add_mesh(edges, color=EDGE_COLOR, line_width=1.5, lighting=False)
    _look(picture)
    _save(picture, folder / MESH)

    length = float(np.ptp(surface.points[:, 2]))
    size = np.linalg.norm(surface.displacement, axis=1)
    scale = DRAWN_DISPLACEMENT * length / float(size.max())
    moved = surface.points + scale * surface.displacement
    deformed = triangle_mesh(moved, surface.triangles)
    deformed["share"] = 100.0 * size / float(size.max())
    picture = make_plotter(SIZE)
    picture.add_mesh(
        deformed,
        scalars="share",
        cmap="viridis",
        clim=(0.0, 100.0),
        **SHADING,
        scalar_bar_args={
            "title": "displacement, %",
            "vertical": True,
            "color": "black",
            "title_font_size": 18,
            "label_font_size": 16,
            "n_labels": 5,
            "fmt": "%.0f",
            "position_x": 0.86,
            "position_y": 0.2,
            "height": 0.6,
            "width": 0.06,
        },
    )
    outline = triangle_mesh(surface.points, surface.triangles).extract_feature_edges(
        feature_angle=35, boundary_edges=False, manifold_edges=False
    )
    picture.add_mesh(outline, color="black", line_width=1)
    _look(picture)
    _save(picture, folder / DEFORMED)


def _look(picture: Any) -> None:
    picture.view_vector((1.0, 0.35, -0.55), viewup=(0, 1, 0))
    picture.camera.zoom(1.1)


def _save(picture: Any, path: Path) -> None:
    """Write a picture without its white margins."""
    from matplotlib.image import imsave

    pixels = picture.screenshot(return_img=True)
    picture.close()
    inked = np.any(pixels[:, :, :3] < 250, axis=2)
    rows, columns = np.flatnonzero(inked.any(axis=1)), np.flatnonzero(inked.any(axis=0))
    top, left = max(0, rows[0] - MARGIN), max(0, columns[0] - MARGIN)
    imsave(path, pixels[top : rows[-1] + MARGIN, left : columns[-1] + MARGIN].copy(order="C"))
