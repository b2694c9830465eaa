"""Views of a solid and of the stresses on a throw, with a color bar and texts on one sheet."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from crankbase.array_checks import Array, Integers
from crankbase.diagrams import STYLE

LINE_COLOR, LINE_WIDTH = "#2a3644", 2.5
SAMPLES = 2  # along each side of a pixel, for smooth edges: faster than VTK's own
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
            off_screen=True, window_size=(SAMPLES * self._pixels).tolist(), lighting="none"
        )
        self._plotter.set_background("white")
        self._plotter.disable_anti_aliasing()
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
        rendered = self._plotter.screenshot(return_img=True)[:, :, :3]
        return np.asarray(Image.fromarray(np.ascontiguousarray(rendered)).reduce(SAMPLES))

    def close(self) -> None:
        """End it."""
        self._plotter.close()


# Nearly white where there is no stress, dark red at the fillets' largest.
COLORS = ("#eef1f4", "#d3dde6", "#f6e3ae", "#f4b266", "#e26a3c", "#b01f2e", "#560a1f")
TEXT_COLOR, QUIET = "#1d2733", "#5b6875"
STRESS_SHADING = {"ambient": 0.55, "diffuse": 0.55, "specular": 0.08}
# From the picture's middle to the eye, of the whole throw and of its half x >= 0 seen on the cut; the
# first from which the mark can be seen is taken. The free end is to the left, seen from the other side
# to the right.
OUTSIDE = ((-1.0, 0.45, -0.6), (-1.0, 0.45, 0.6), (-1.0, -0.5, -0.6), (-1.0, -0.5, 0.6))
CUT = ((-1.0, 0.22, -0.36), (-1.0, 0.22, 0.36), (-1.0, -0.3, -0.36), (-1.0, -0.3, 0.36))
OTHER_SIDE = ((1.0, 0.45, 0.6), (1.0, -0.5, 0.6), (1.0, -0.5, -0.6))
PIXELS = 900  # along the longer side of each view
VIEWS_HEIGHT, DOTS = 6.0, 110  # of the sheet [inch, 1/inch]
COMPRESSION = 4  # half of the time of the usual 6, for 7 % more bytes
# A curved facet is drawn as four to this power flat ones; where there are many, the smaller number does.
SUBDIVISIONS, MANY = (2, 1), 4_000
SYMBOLS = ("o", "s")  # of the first mark and the second
HIDDEN_BY = 0.01  # what covers a mark is nearer to the eye by this share of the throw's size


@dataclass(frozen=True)
class _Solid:
    """Content of one view: a surface with the stresses under all loads."""

    name: str
    eyes: tuple[tuple[float, float, float], ...]
    surface: Any

    @classmethod
    def of(
        cls,
        name: str,
        eyes: tuple[tuple[float, float, float], ...],
        arrays: Mapping[str, NDArray[Any]],
        facets: Integers,
    ) -> "_Solid":
        """Subdivide curved facets into flat triangles."""
        import pyvista

        cells = np.insert(facets, 0, 6, axis=1).ravel()
        kinds = np.full(len(facets), pyvista.CellType.QUADRATIC_TRIANGLE)
        grid = pyvista.UnstructuredGrid(cells, kinds, arrays["points"])
        for number, limit in enumerate(arrays["largest"]):
            grid.point_data[_field(number)] = arrays["stress"][number] / limit
        surface = grid.extract_surface(
            nonlinear_subdivision=SUBDIVISIONS[len(facets) > MANY], algorithm="dataset_surface"
        )
        return cls(name, eyes, surface.triangulate().clean())

    def best_eye(self, places: Array) -> tuple[Array, Array | None]:
        """Direction to the eye, and the first of some positions that is visible from there, if any."""
        for eye in map(np.array, self.eyes):
            if (place := self.seen_from(eye, places)) is not None:
                return eye, place
        return np.array(self.eyes[0]), None

    def seen_from(self, eye: Array, places: Array) -> Array | None:
        """Return the first of some positions that is visible from an eye, if any."""
        towards = eye_at(eye).towards
        return next((place for place in places if not self._hidden(place, towards)), None)

    def _hidden(self, place: Array, towards: Array) -> bool:
        """Whether the surface does not reach a position, or is between it and the eye."""
        points = np.asarray(self.surface.points)
        size = float(np.ptp(points, axis=0).max())
        if np.linalg.norm(points - place, axis=1).min() > HIDDEN_BY * size:
            return True
        start = place + HIDDEN_BY * size * towards
        covering, _ = self.surface.ray_trace(start, start + 2.0 * size * towards)
        return len(covering) > 0


@dataclass(frozen=True)
class _View:
    """Pixels of a view, its name, and the position of each mark on it, if visible."""

    pixels: NDArray[np.uint8]
    name: str
    marks: tuple[tuple[float, float] | None, ...]


def _field(number: int) -> str:
    """Name of the stresses under a load, as shares of the fillets' largest."""
    return f"stress {number}"


def render(arrays: Mapping[str, NDArray[Any]], folder: Path) -> None:
    """Draw all pictures in this process."""
    solids = [_Solid.of("whole throw", OUTSIDE, arrays, arrays["facets"])]
    if len(arrays["half"]) > 0:
        solids.append(_Solid.of("cut at the crank plane", CUT, arrays, arrays["half"]))
    else:
        solids.append(replace(solids[0], name="from the other side", eyes=OTHER_SIDE))
    seen = np.unique(arrays["facets"])
    shown = [_render_views(solid, arrays["places"]) for solid in solids]
    for number, (file, *views) in enumerate(zip(arrays["files"], *shown, strict=True)):
        limit = float(arrays["largest"][number])
        beyond = bool(arrays["stress"][number][seen].max() > 1.005 * limit)
        texts = (str(arrays["titles"][number]), str(arrays["remarks"][number]))
        _compose(views, limit, beyond, texts, folder / str(file))


def _render_views(solid: _Solid, places: Array) -> list[_View]:
    """Render a view under each load; of each mark's positions (loads, marks, images, 3) mark one."""
    views, scenes = [], dict[tuple[float, ...], Scene]()
    for number, of_load in enumerate(places):
        eye, _ = solid.best_eye(of_load[0])
        if tuple(eye) not in scenes:  # seen from one place, loads differ in their colors alone
            scene = Scene(np.asarray(solid.surface.points), eye, PIXELS)
            scene.add(
                solid.surface.copy(),
                scalars=_field(number),
                cmap=_colormap(),
                clim=(0.0, 1.0),
                n_colors=256,
                show_scalar_bar=False,
                **STRESS_SHADING,
            )
            scenes[tuple(eye)] = scene
        scene = scenes[tuple(eye)]
        pixels = scene.render(_field(number))
        seen = [solid.seen_from(eye, places) for places in of_load]
        marks = tuple(None if place is None else scene.place_of(place) for place in seen)
        views.append(_View(pixels, solid.name, marks))
    for scene in scenes.values():
        scene.close()
    return views


def _colormap() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("stress", COLORS)


def _compose(
    views: Sequence[_View], limit: float, beyond: bool, texts: tuple[str, str], path: Path
) -> None:
    """Put the views, a color bar and the texts on one sheet; sizes in inches."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    tallest = max(view.pixels.shape[0] for view in views)
    scale = VIEWS_HEIGHT / tallest
    spans = [(scale * view.pixels.shape[1], scale * view.pixels.shape[0]) for view in views]
    gap, side, top, bottom, bar = 0.35, 0.3, 0.95, 0.5, 1.25
    width = 2.0 * side + sum(span[0] + gap for span in spans) + bar
    height = VIEWS_HEIGHT + top + bottom
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), dpi=DOTS)
        FigureCanvasAgg(figure)

        def axes_at(left: float, low: float, across: float, high: float) -> Any:
            return figure.add_axes((left / width, low / height, across / width, high / height))

        def write(text: str, left: float, low: float, **style: Any) -> None:
            figure.text(left / width, low / height, text, va="center", **style)

        left = side
        for view, (across, high) in zip(views, spans, strict=True):
            low = bottom + 0.5 * (VIEWS_HEIGHT - high)
            # Made smaller here: faster than matplotlib does it.
            size = round(DOTS * across), round(DOTS * high)
            smaller = Image.fromarray(view.pixels).resize(size, Image.Resampling.HAMMING)
            x, y = round(DOTS * left), round(DOTS * low)
            figure.figimage(np.asarray(smaller), x, y, origin="upper", zorder=-1)
            axes = axes_at(left, low, across, high)
            axes.set(xlim=(0, view.pixels.shape[1]), ylim=(view.pixels.shape[0], 0))
            axes.set_axis_off()
            write(view.name, left + 0.5 * across, 0.28, ha="center", color=QUIET)
            for mark, symbol in zip(view.marks, SYMBOLS, strict=False):
                if mark is not None:
                    # A ring or a square hides nothing.
                    for color, stroke in (("white", 4.0), ("#0b57d0", 1.8)):
                        axes.plot(
                            *mark,
                            symbol,
                            markersize=15,
                            markerfacecolor="none",
                            markeredgecolor=color,
                            markeredgewidth=stroke,
                            clip_on=False,
                        )
            left += across + gap
        axes = axes_at(left, bottom + 0.12 * VIEWS_HEIGHT, 0.22, 0.72 * VIEWS_HEIGHT)
        colors = ScalarMappable(Normalize(0.0, limit), _colormap())
        drawn = figure.colorbar(colors, cax=axes, extend="max" if beyond else "neither")
        drawn.outline.set_linewidth(0.6)
        drawn.set_label("equivalent stress (von Mises), MPa", color=TEXT_COLOR)
        axes.tick_params(width=0.6)
        title, remark = texts
        write(title, side, height - 0.36, fontsize=14, fontweight="bold", color=TEXT_COLOR)
        write(remark, side, height - 0.70, color=TEXT_COLOR, linespacing=1.5)
        figure.savefig(path, pil_kwargs={"compress_level": COMPRESSION})
