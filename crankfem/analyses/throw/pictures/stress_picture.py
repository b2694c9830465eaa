"""Pictures of the stress all over a throw under each unit load, the largest one at a fillet marked."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.drawing.diagram_style import STYLE
from crankbase.errors import InputError
from crankbase.outputs import check_output, copy_file
from crankbase.processes import scratch_folder
from crankbase.units.units import UNITS
from crankfem.analyses.throw.pictures.offscreen import (
    OffscreenProcess,
    make_plotter,
)
from fem.fillet_peaks import FilletPeak, FilletStresses
from fem.principal import von_mises
from fem.symmetry import MirrorImage
from fem.unit_loads import UnitLoad, whole_facets, whole_nodes
from geometry.facets import six_node_triangles
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Stresses are shown for loads of 1 kN and 1 kN m, in MPa.
LOAD_SHOWN, STRESS_UNIT = UNITS["kN"][1], UNITS["MPa"][1]
# Nearly white where there is no stress, dark red at the fillets' largest.
COLORS = ("#eef1f4", "#d3dde6", "#f6e3ae", "#f4b266", "#e26a3c", "#b01f2e", "#560a1f")
LINE_COLOR, TEXT_COLOR, QUIET = "#2a3644", "#1d2733", "#5b6875"
SHARP = 30.0  # an angle between faces that makes an edge [deg]
SHADING: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": True,
    "feature_angle": SHARP,
    "ambient": 0.55,
    "diffuse": 0.55,
    "specular": 0.08,
}
LIGHTS = (((-0.5, 0.9, 1.0), 0.55), ((0.8, 0.2, 0.6), 0.25), ((0.0, 0.0, 1.0), 0.3))
# From the picture's middle to the eye, of the whole throw and of its half x >= 0 seen on the cut; the
# first from which the mark can be seen is taken. The free end is to the left, seen from the other side
# to the right.
OUTSIDE = ((-1.0, 0.45, -0.6), (-1.0, 0.45, 0.6), (-1.0, -0.5, -0.6), (-1.0, -0.5, 0.6))
CUT = ((-1.0, 0.22, -0.36), (-1.0, 0.22, 0.36), (-1.0, -0.3, -0.36), (-1.0, -0.3, 0.36))
OTHER_SIDE = ((1.0, 0.45, 0.6), (1.0, -0.5, 0.6), (1.0, -0.5, -0.6))
PIXELS = 900  # along the longer side of each view
VIEWS_HEIGHT, DOTS = 6.0, 110  # of the sheet [inch, 1/inch]
MARGIN = 0.02
# Lines are moved towards the eye by this share of the throw's size, so that no face covers them.
LIFT = 0.004
# A curved facet is drawn as four to this power flat ones; where there are many, the smaller number does.
SUBDIVISIONS, MANY = (2, 1), 20_000
HIDDEN_BY = 0.01  # what covers a mark is nearer to the eye by this share of the throw's size


def picture_stresses(stresses: FilletStresses, folder: str | Path) -> tuple[Path, ...]:
    """Write a picture of the equivalent stress for each unit load.

    Parameters
    ----------
    stresses : FilletStresses
    folder : path
        Where the files ``stress-axial.png`` and so on go; made if it is not there.

    Returns
    -------
    tuple of Path
        The files, in the order of the loads.

    Raises
    ------
    InputError
        If the folder cannot be written.
    MissingLibraryError, RenderError
        If there is no OpenGL library; the message names what to install.
    """
    folder = Path(folder)
    names = [picture_name(load) for load in stresses.loaded.loads]
    for name in names:
        check_output(folder / name, "picture")
    with scratch_folder() as scratch:
        OffscreenProcess(f"{__name__}:render", scratch, picture_arrays(stresses)).wait()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name in names:
                copy_file(scratch / name, folder / name, "picture")
        except OSError as error:
            raise InputError(f"{folder}: cannot be written ({error.strerror or error}).") from None
    return tuple(folder / name for name in names)


def picture_name(load: UnitLoad) -> str:
    """Name of the file of a load's picture."""
    pin = "" if load.pin in (None, 0) else f"-{load.pin + 1}"
    return f"stress-{load.kind.replace(' ', '-')}{pin}.png"


def picture_arrays(stresses: FilletStresses) -> dict[str, NDArray[Any]]:
    """What is drawn: nodes and facets of the whole throw and of its half, stresses, texts."""
    loaded = stresses.loaded
    mesh = loaded.mesh
    whole = whole_nodes(mesh)
    outside = [name for name in mesh.surfaces if name not in (CRANK_PLANE, MIDDLE_PLANE)]
    facets = six_node_triangles(mesh, np.concatenate([mesh.surfaces[name] for name in outside]))
    on_cut = six_node_triangles(mesh, mesh.surfaces.get(CRANK_PLANE, np.empty((0, 3), int)))
    here = [not image.across_crank for image in whole.images]
    both = np.concatenate([facets, on_cut])
    half = np.concatenate(
        [
            whole_facets(whole, both).reshape(len(here), -1, 6)[place]
            for place in np.flatnonzero(here)
        ]
    )
    equivalent = whole.collect([von_mises(part) for part in loaded.stresses(whole.images)])
    # Where it is known better.
    equivalent[stresses.surface.nodes] = von_mises(stresses.surface.stress)
    peaks = [largest_peak(stresses.under(load)) for load in loaded.loads]
    return {
        "points": whole.collect([image.points(mesh.points) for image in whole.images]),
        "facets": whole_facets(whole, facets),
        "half": half if len(on_cut) else np.empty((0, 6), dtype=np.int64),
        "stress": equivalent.T * (LOAD_SHOWN / STRESS_UNIT),
        # Of a symmetric throw, those in the mirror images are alike.
        "places": np.array([_mirrored(peak.von_mises_place, whole.images) for peak in peaks]),
        "largest": np.array([peak.von_mises for peak in peaks]) * (LOAD_SHOWN / STRESS_UNIT),
        "titles": np.array([_title(load) for load in loaded.loads]),
        "remarks": np.array([_remark(peak) for peak in peaks]),
        "files": np.array([picture_name(load) for load in loaded.loads]),
    }


def largest_peak(peaks: Sequence[FilletPeak]) -> FilletPeak:
    """Return the peak of the largest equivalent stress; of mirror images the first."""
    largest = max(peak.von_mises for peak in peaks)
    return next(peak for peak in peaks if peak.von_mises > (1.0 - 1e-6) * largest)


def _mirrored(place: Array, images: Sequence[MirrorImage]) -> Array:
    """Places (images, 3) of a place and its mirror images."""
    return np.array([image.points(place[None])[0] for image in images])


def _title(load: UnitLoad) -> str:
    """Say what is shown."""
    return f"{load.name[0].upper()}{load.name[1:]}: 1 k{load.unit}, ends pinned"


def _remark(peak: FilletPeak) -> str:
    """Say where the largest stress at a fillet is."""
    place = ", ".join(
        f"{axis} = {round(1e3 * value, 1) + 0.0:g} mm"
        for axis, value in zip("xyz", peak.von_mises_place, strict=True)
    )
    size = peak.von_mises * LOAD_SHOWN / STRESS_UNIT
    return (
        f"largest at a fillet: {size:.3g} MPa ({peak.fillet.name}; {place}); "
        f"divided by the nominal stress {peak.von_mises_factor:.2f}"
    )


@dataclass(frozen=True)
class _Solid:
    """What one of the views shows: a surface with the stresses under all loads, and its edges."""

    name: str
    eyes: tuple[tuple[float, float, float], ...]
    surface: Any
    edges: Any

    @classmethod
    def of(
        cls,
        name: str,
        eyes: tuple[tuple[float, float, float], ...],
        arrays: Mapping[str, NDArray[Any]],
        facets: Integers,
    ) -> "_Solid":
        """Subdivide curved facets into flat triangles close together."""
        import pyvista

        cells = np.insert(facets, 0, 6, axis=1).ravel()
        kinds = np.full(len(facets), pyvista.CellType.QUADRATIC_TRIANGLE)
        grid = pyvista.UnstructuredGrid(cells, kinds, arrays["points"])
        for number, stress in enumerate(arrays["stress"]):
            grid.point_data[_field(number)] = stress
        surface = grid.extract_surface(
            nonlinear_subdivision=SUBDIVISIONS[len(facets) > MANY], algorithm="dataset_surface"
        )
        surface = surface.triangulate().clean()
        edges = surface.extract_feature_edges(
            feature_angle=SHARP,
            boundary_edges=False,
            non_manifold_edges=False,
            manifold_edges=False,
        )
        return cls(name, eyes, surface, edges)

    def best_eye(self, places: Array) -> tuple[Array, Array | None]:
        """Direction to the eye, and the first of some places that is seen from there, if any."""
        for eye in self.eyes:
            for place in places:
                if not self._hidden(place, _axes(np.array(eye))[0]):
                    return np.array(eye), place
        return np.array(self.eyes[0]), None

    def _hidden(self, place: Array, towards: Array) -> bool:
        """Whether the surface does not reach a place, or lies between it and the eye."""
        points = np.asarray(self.surface.points)
        size = float(np.ptp(points, axis=0).max())
        if np.linalg.norm(points - place, axis=1).min() > HIDDEN_BY * size:
            return True
        corners = points[self.surface.faces.reshape(-1, 4)[:, 1:]]
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        normal = np.cross(towards, second)
        determinant = np.sum(first * normal, axis=1)
        crossed = determinant != 0.0
        inverse = np.divide(1.0, determinant, out=np.zeros(len(normal)), where=crossed)
        arm = place + HIDDEN_BY * size * towards - corners[:, 0]
        across = np.cross(arm, first)
        u = np.sum(arm * normal, axis=1) * inverse
        v = across @ towards * inverse
        distance = np.sum(second * across, axis=1) * inverse
        inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        return bool(np.any(crossed & inside & (distance > 0.0)))


@dataclass(frozen=True)
class _View:
    """Pixels of a view, its name, and where on it the mark is, if it is seen."""

    pixels: NDArray[np.uint8]
    name: str
    mark: tuple[float, float] | None


def _field(number: int) -> str:
    return f"stress {number}"


def render(arrays: Mapping[str, NDArray[Any]], folder: Path) -> None:
    """Draw all pictures in this process."""
    solids = [_Solid.of("whole throw", OUTSIDE, arrays, arrays["facets"])]
    if len(arrays["half"]) > 0:
        solids.append(_Solid.of("cut at the crank plane", CUT, arrays, arrays["half"]))
    else:
        solids.append(replace(solids[0], name="from the other side", eyes=OTHER_SIDE))
    seen = np.unique(arrays["facets"])
    for number, file in enumerate(arrays["files"]):
        limit = float(arrays["largest"][number])
        views = [_render_view(solid, number, limit, arrays["places"][number]) for solid in solids]
        beyond = bool(arrays["stress"][number][seen].max() > 1.005 * limit)
        texts = (str(arrays["titles"][number]), str(arrays["remarks"][number]))
        _compose(views, limit, beyond, texts, folder / str(file))


def _render_view(solid: _Solid, number: int, limit: float, places: Array) -> _View:
    """Render a view of the stress under one load; mark one of the places."""
    import pyvista

    eye, place = solid.best_eye(places)
    towards, right, up = _axes(eye)
    seen = np.asarray(solid.surface.points) @ np.column_stack([right, up])
    low, high = seen.min(axis=0), seen.max(axis=0)
    longer = float((high - low).max())
    low, high = low - MARGIN * longer, high + MARGIN * longer
    extent = high - low
    width, height = np.ceil(PIXELS * extent / extent.max()).astype(int).tolist()

    picture = make_plotter((width, height), lighting="none")
    for light, intensity in LIGHTS:
        picture.add_light(
            pyvista.Light(position=light, light_type="camera light", intensity=intensity)
        )
    picture.add_mesh(
        solid.surface.copy(),
        scalars=_field(number),
        cmap=_colormap(),
        clim=(0.0, limit),
        n_colors=256,
        show_scalar_bar=False,
        **SHADING,
    )
    style = {"color": LINE_COLOR, "line_width": 2.0}
    lines = [picture.add_silhouette(solid.surface, **style)]
    if solid.edges.n_cells:
        lines.append(picture.add_mesh(solid.edges, lighting=False, **style))
    for line in lines:
        line.position = LIFT * longer * towards
    middle = 0.5 * (low + high) @ np.array([right, up])
    camera = picture.camera
    camera.focal_point, camera.position, camera.up = middle, middle + 10.0 * longer * towards, up
    camera.parallel_projection, camera.parallel_scale = True, 0.5 * float(extent[1])
    picture.renderer.reset_camera_clipping_range()
    pixels = picture.screenshot(return_img=True)[:, :, :3].copy()
    picture.close()
    if place is None:
        return _View(pixels, solid.name, None)
    across, above = (place @ np.column_stack([right, up]) - low) / extent
    return _View(pixels, solid.name, (float(across) * width, (1.0 - float(above)) * height))


def _axes(view: Array) -> tuple[Array, Array, Array]:
    """Unit vectors towards the eye, to its right, and up."""
    towards = view / math.sqrt(float(view @ view))
    right = np.cross((0.0, 1.0, 0.0), towards)
    right /= np.linalg.norm(right)
    return towards, right, np.cross(towards, right)


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
            axes = axes_at(left, bottom + 0.5 * (VIEWS_HEIGHT - high), across, high)
            axes.imshow(view.pixels, interpolation="lanczos", aspect="auto")
            axes.set_axis_off()
            write(view.name, left + 0.5 * across, 0.28, ha="center", color=QUIET)
            if view.mark is not None:
                _mark(axes, view.mark)
            left += across + gap
        axes = axes_at(left, bottom + 0.12 * VIEWS_HEIGHT, 0.22, 0.72 * VIEWS_HEIGHT)
        colors = ScalarMappable(Normalize(0.0, limit), _colormap())
        drawn = figure.colorbar(colors, cax=axes, extend="max" if beyond else "neither")
        drawn.outline.set_linewidth(0.6)
        drawn.set_label("equivalent stress (von Mises), MPa", color=TEXT_COLOR)
        axes.tick_params(width=0.6)
        title, remark = texts
        write(title, side, height - 0.36, fontsize=14, fontweight="bold", color=TEXT_COLOR)
        write(remark, side, height - 0.70, color=TEXT_COLOR)
        figure.savefig(path)


def _mark(axes: Any, place: tuple[float, float]) -> None:
    """Mark a place with a ring that hides nothing."""
    for color, width in (("white", 4.0), ("#0b57d0", 1.8)):
        axes.plot(
            *place,
            "o",
            markersize=15,
            markerfacecolor="none",
            markeredgecolor=color,
            markeredgewidth=width,
            clip_on=False,
        )
