"""A solid in parallel projection, lit from three sides and with its edges drawn, on white."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LINE_COLOR, LINE_WIDTH = "#2a3644", 2.5
SHARP = 30.0  # an angle between faces that makes an edge [deg]
MARGIN = 0.02  # of the longer side
# Directions from which light falls, seen by the eye (right, up, towards it), and how much.
LIGHTS = (((-0.5, 0.9, 1.0), 0.6), ((0.8, 0.2, 0.6), 0.2), ((0.0, 0.0, 1.0), 0.3))
SHADING: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": True,
    "feature_angle": SHARP,
}
# Lines are moved towards the eye by this share of the solid's size, so that no face covers them.
LIFT = 0.004


class Eye(NamedTuple):
    """Unit vectors towards the eye, to its right, and up."""

    towards: Array
    right: Array
    up: Array

    @property
    def plane(self) -> Array:
        """Matrix from points (n, 3) to their positions (n, 2) on a picture, to the right and up."""
        return np.column_stack([self.right, self.up])


def eye_at(view: Array) -> Eye:
    """Return the eye in a direction (3,) from the middle, upright in y."""
    towards = view / math.sqrt(float(view @ view))
    right = np.cross((0.0, 1.0, 0.0), towards)
    right /= np.linalg.norm(right)
    return Eye(towards, right, np.cross(towards, right))


class Scene:
    """A picture of a solid in parallel projection, with a narrow margin, rendered in this process.

    Parameters
    ----------
    points : (n, 3) array
        Of the solid.
    view : (3,) array
        From the picture's middle to the eye.
    pixels : int
        Of the picture's longer side.

    Attributes
    ----------
    longer : float
        The longer side of the visible area, in the unit of the points.
    """

    def __init__(self, points: Array, view: Array, pixels: int) -> None:
        import pyvista

        self._eye = eye_at(view)
        seen = points @ self._eye.plane
        low, high = seen.min(axis=0), seen.max(axis=0)
        self.longer = float((high - low).max())
        self._low = low - MARGIN * self.longer
        self._extent = high - low + 2.0 * MARGIN * self.longer
        self._pixels = np.ceil(pixels * self._extent / self._extent.max()).astype(int)
        self._plotter = pyvista.Plotter(
            off_screen=True, window_size=self._pixels.tolist(), lighting="none"
        )
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("ssaa")
        for place, intensity in LIGHTS:
            self._plotter.add_light(
                pyvista.Light(position=place, light_type="camera light", intensity=intensity)
            )
        # Before anything is added: each later move looks for the silhouettes anew.
        middle = (self._low + 0.5 * self._extent) @ self._eye.plane.T
        camera = self._plotter.camera = pyvista.Camera()
        camera.focal_point, camera.up = middle, self._eye.up
        camera.position = middle + 10.0 * self.longer * self._eye.towards
        camera.parallel_projection = True
        camera.parallel_scale = 0.5 * float(self._extent[1])

    def add(self, solid: Any, **look: Any) -> None:
        """Add the faces of a surface, its silhouette and its sharp edges."""
        self._solid = self._plotter.add_mesh(solid, **SHADING, **look)
        style = {"color": LINE_COLOR, "line_width": LINE_WIDTH}
        lines = [self._plotter.add_silhouette(solid, **style)]
        edges = solid.extract_feature_edges(
            feature_angle=SHARP,
            boundary_edges=False,
            non_manifold_edges=False,
            manifold_edges=False,
        )
        if edges.n_cells:
            lines.append(self._plotter.add_mesh(edges, lighting=False, **style))
        for line in lines:
            line.position = LIFT * self.longer * self._eye.towards

    def place_of(self, point: Array) -> tuple[float, float]:
        """Return where a point is on the picture, from its upper left corner [pixels]."""
        across, above = (point @ self._eye.plane - self._low) / self._extent
        width, height = self._pixels
        return float(across * width), float((1.0 - above) * height)

    def render(self, field: str | None = None) -> NDArray[np.uint8]:
        """Return the pixels (height, width, 3); with a field, of that of the solid's values."""
        if field is not None:
            self._solid.mapper.scalar_map_mode = "point_field"
            self._solid.mapper.array_name = field
        self._plotter.renderer.reset_camera_clipping_range()
        self._plotter.render()
        return np.array(self._plotter.screenshot(return_img=True)[:, :, :3])

    def close(self) -> None:
        """End it."""
        self._plotter.close()
