"""Render the pictures of a throw off-screen, in a process of its own.

VTK ends its process where no OpenGL library can be loaded; in a process of its own that costs the
pictures and nothing else. Used as ``python -m crankfem.pictures.render SURFACE.npz FOLDER``.
"""

import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from crankfem.pictures.surface import Surface
from geometry.errors import MissingLibraryError
from geometry.processes import package_environment

MESH, DEFORMED = "throw_mesh.png", "throw_deformed.png"
ADVICE = (
    "the pictures of the throw could not be rendered; on Debian or Ubuntu install the off-screen "
    "OpenGL library with: apt-get install libegl1"
)
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
MARGIN = 12  # pixels


class Rendering:
    """Pictures being rendered in the background."""

    def __init__(self, surface: Surface, folder: Path) -> None:
        self._scratch = tempfile.TemporaryDirectory(prefix="crankfem-")
        data = Path(self._scratch.name) / "surface.npz"
        np.savez(data, **asdict(surface))
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "crankfem.pictures.render", str(data), str(folder)],
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
            code = self._process.wait(timeout=120.0)
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


def render(surface: Surface, folder: Path) -> None:
    """Write the pictures of the mesh and of the deformed throw."""
    import pyvista

    def plotter() -> Any:
        made = pyvista.Plotter(off_screen=True, window_size=(1100, 800))
        made.set_background("white")
        made.enable_anti_aliasing("ssaa")
        return made

    def mesh_of(points: Any) -> Any:
        faces = np.insert(surface.triangles, 0, 3, axis=1)
        return pyvista.PolyData(points, faces.ravel())

    def edges_of(points: Any) -> Any:
        lines = np.insert(surface.edges, 0, 3, axis=1)
        return pyvista.PolyData(points, lines=lines.ravel())

    def look(made: Any) -> None:
        made.view_vector((1.0, 0.35, -0.55), viewup=(0, 1, 0))
        made.camera.zoom(1.1)

    picture = plotter()
    picture.add_mesh(mesh_of(surface.points), color=STEEL_COLOR, **SHADING)
    picture.add_mesh(edges_of(surface.points), color=EDGE_COLOR, line_width=1.5, lighting=False)
    look(picture)
    _save(picture, folder / MESH)

    length = float(np.ptp(surface.points[:, 2]))
    size = np.linalg.norm(surface.displacement, axis=1)
    scale = DRAWN_DISPLACEMENT * length / float(size.max())
    moved = surface.points + scale * surface.displacement
    deformed = mesh_of(moved)
    deformed["share"] = 100.0 * size / float(size.max())
    picture = plotter()
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
    outline = mesh_of(surface.points).extract_feature_edges(
        feature_angle=35, boundary_edges=False, manifold_edges=False
    )
    picture.add_mesh(outline, color="black", line_width=1)
    look(picture)
    _save(picture, folder / DEFORMED)


def _save(picture: Any, path: Path) -> None:
    """Write a picture without its white margins."""
    from matplotlib.image import imsave

    pixels = picture.screenshot(return_img=True)
    picture.close()
    inked = np.any(pixels[:, :, :3] < 250, axis=2)
    rows, columns = np.flatnonzero(inked.any(axis=1)), np.flatnonzero(inked.any(axis=0))
    top, left = max(0, rows[0] - MARGIN), max(0, columns[0] - MARGIN)
    imsave(path, pixels[top : rows[-1] + MARGIN, left : columns[-1] + MARGIN].copy(order="C"))


def main() -> None:
    """Render what another process has saved."""
    with np.load(sys.argv[1]) as data:
        surface = Surface(**{name: data[name] for name in data.files})
    render(surface, Path(sys.argv[2]))


if __name__ == "__main__":
    main()
