"""Pictures of the stress all over a throw under each unit load, the largest one at a fillet marked."""

import math
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankfem.pictures.offscreen import OffscreenProcess, make_plotter, read_arguments
from crankfem.pictures.style import STYLE
from fem.fillet_stress import FilletPeak, FilletStresses
from fem.principal import von_mises
from fem.unit_loads import UnitLoad, whole_facets, whole_nodes
from geometry.errors import InputError
from geometry.facets import six_node_triangles
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Stresses are shown for loads of 1 kN and 1 kN m, in MPa.
LOAD_SHOWN, STRESS_UNIT = 1e3, 1e6
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
# From the picture's middle to the eye: the whole throw, and its half x >= 0 seen on the cut.
OUTSIDE, CUT, BELOW = (1.0, 0.45, -0.62), (-1.0, 0.22, -0.36), (-1.0, -0.5, 0.45)
PIXELS = 1000  # along the longer side of each view
MARGIN = 0.02
LIFT = 0.003
# A curved facet is drawn as four to this power flat ones.
SUBDIVISION = 2
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
    MissingLibraryError
        If there is no OpenGL library; the message names what to install.
    """
    folder = Path(folder)
    names = [picture_name(load) for load in stresses.loaded.loads]
    with tempfile.TemporaryDirectory(prefix="crankfem-") as scratch:
        arrays = picture_arrays(stresses)
        OffscreenProcess("crankfem.pictures.stress_picture", arrays, Path(scratch)).wait()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name in names:
                shutil.copyfile(Path(scratch) / name, folder / name)
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
    peaks = [max(stresses.under(load), key=lambda peak: peak.von_mises) for load in loaded.loads]
    return {
        "points": whole.collect([image.points(mesh.points) for image in whole.images]),
        "facets": whole_facets(whole, facets),
        "half": half if len(on_cut) else np.empty((0, 6), dtype=np.int64),
        "stress": equivalent.T * (LOAD_SHOWN / STRESS_UNIT),
        "places": np.array([peak.von_mises_place for peak in peaks]),
        "largest": np.array([peak.von_mises for peak in peaks]) * (LOAD_SHOWN / STRESS_UNIT),
        "titles": np.array([_title(load) for load in loaded.loads]),
        "remarks": np.array([_remark(peak) for peak in peaks]),
        "files": np.array([picture_name(load) for load in loaded.loads]),
    }


def _title(load: UnitLoad) -> str:
    """Say what is shown."""
    name = {"bending across it": "bending across the crank plane"}.get(load.name, load.name)
    return f"{name[0].upper()}{name[1:]} of 1 k{load.unit}"


def _remark(peak: FilletPeak) -> str:
    """Say where the largest stress at a fillet is."""
    place = ", ".join(
        f"{axis} = {round(1e3 * value, 1) + 0.0:g} mm"
        for axis, value in zip("xyz", peak.von_mises_place, strict=True)
    )
    size = peak.von_mises * LOAD_SHOWN / STRESS_UNIT
    return (
        f"largest at a fillet: {size:.3g} MPa, {peak.fillet.name}, {place}; "
        f"concentration factor {peak.factor:.2f}"
    )


def render(arrays: Mapping[str, NDArray[Any]], folder: Path) -> None:
    """Draw all pictures in this process."""
    cut = len(arrays["half"]) > 0
    views = [(arrays["facets"], OUTSIDE, "whole throw")]
    if cut:
        views.append((arrays["half"], CUT, "cut at the crank plane"))
    else:
        views.append((arrays["facets"], BELOW, "from the other side"))
    for number, file in enumerate(arrays["files"]):
        stress = arrays["stress"][number]
        limit = float(arrays["largest"][number])
        place = arrays["places"][number]
        shown = [
            (*_view(arrays["points"], facets, stress, limit, np.array(eye), place), name)
            for facets, eye, name in views
        ]
        beyond = bool(stress[np.unique(arrays["facets"])].max() > 1.005 * limit)
        texts = (str(arrays["titles"][number]), str(arrays["remarks"][number]))
        _compose(shown, limit, beyond, texts, folder / str(file))


def _view(
    points: Array, facets: Integers, stress: Array, limit: float, eye: Array, place: Array
) -> tuple[NDArray[np.uint8], tuple[float, float] | None]:
    """Render one view; its pixels, and where the marked place is on them unless it is hidden."""
    import pyvista

    towards, right, up = _axes(eye)
    used = np.unique(facets)
    seen = points[used] @ np.column_stack([right, up])
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
    solid = _subdivided(points, facets, stress)
    picture.add_mesh(
        solid,
        scalars="stress",
        cmap=_colormap(),
        clim=(0.0, limit),
        n_colors=256,
        show_scalar_bar=False,
        **SHADING,
    )
    edges = solid.extract_feature_edges(
        feature_angle=SHARP, boundary_edges=False, non_manifold_edges=False, manifold_edges=False
    )
    style = {"color": LINE_COLOR, "line_width": 2.0}
    lines = [picture.add_silhouette(solid, **style)]
    if edges.n_cells:
        lines.append(picture.add_mesh(edges, lighting=False, **style))
    for line in lines:
        line.position = LIFT * longer * towards
    middle = 0.5 * (low + high) @ np.array([right, up])
    camera = picture.camera
    camera.focal_point, camera.position, camera.up = middle, middle + 10.0 * longer * towards, up
    camera.parallel_projection, camera.parallel_scale = True, 0.5 * float(extent[1])
    picture.renderer.reset_camera_clipping_range()
    pixels = picture.screenshot(return_img=True)[:, :, :3]
    picture.close()

    if _hidden(solid, place, towards, HIDDEN_BY * longer):
        return pixels, None
    across, above = (place @ np.column_stack([right, up]) - low) / extent
    return pixels, (float(across) * width, (1.0 - float(above)) * height)


def _subdivided(points: Array, facets: Integers, stress: Array) -> Any:
    """Flat triangles of curved facets, close together."""
    import pyvista

    cells = np.insert(facets, 0, 6, axis=1).ravel()
    kinds = np.full(len(facets), pyvista.CellType.QUADRATIC_TRIANGLE)
    grid = pyvista.UnstructuredGrid(cells, kinds, points)
    grid.point_data["stress"] = stress
    return grid.extract_surface(nonlinear_subdivision=SUBDIVISION).triangulate().clean()


def _hidden(solid: Any, place: Array, towards: Array, margin: float) -> bool:
    """Whether a triangle lies between a place and the eye."""
    corners = solid.points[solid.faces.reshape(-1, 4)[:, 1:]]
    origin = place + margin * towards
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(towards, second)
    size = np.sum(first * normal, axis=1)
    crossed = np.abs(size) > 0.0
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=crossed)
    arm = origin - corners[:, 0]
    u = np.sum(arm * normal, axis=1) * inverse
    across = np.cross(arm, first)
    v = across @ towards * inverse
    distance = np.sum(second * across, axis=1) * inverse
    return bool(np.any(crossed & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)))


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
    shown: list[tuple[NDArray[np.uint8], tuple[float, float] | None, str]],
    limit: float,
    beyond: bool,
    texts: tuple[str, str],
    path: Path,
) -> None:
    """Put the views, a color bar and the texts on one sheet."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    # Both views at one scale, beside each other, and the color bar to the right.
    heights, widths = zip(*(pixels.shape[:2] for pixels, _, _ in shown), strict=True)
    bar, gap = 0.10, 0.03
    tall = 6.0
    wide = tall * sum(widths) / max(heights)
    top, bottom, side = 0.75, 0.55, 0.25
    figure_width = wide * (1.0 + gap) + 1.5 + 2 * side
    figure_height = tall + top + bottom
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(figure_width, figure_height), dpi=110)
        FigureCanvasAgg(figure)
        left = side
        for pixels, mark, name in shown:
            share = pixels.shape[1] / sum(widths)
            span = wide * share
            high = tall * pixels.shape[0] / max(heights)
            low = bottom + 0.5 * (tall - high)
            axes = figure.add_axes(
                (
                    left / figure_width,
                    low / figure_height,
                    span / figure_width,
                    high / figure_height,
                )
            )
            axes.imshow(pixels, interpolation="lanczos", aspect="auto")
            axes.set_axis_off()
            figure.text(
                (left + 0.5 * span) / figure_width,
                0.32 / figure_height,
                name,
                ha="center",
                color=QUIET,
            )
            if mark is not None:
                _mark(axes, mark)
            left += span + gap * wide
        axes = figure.add_axes(
            (
                (left + 0.05) / figure_width,
                (bottom + 0.12 * tall) / figure_height,
                0.22 / figure_width,
                0.72 * tall / figure_height,
            )
        )
        colors = ScalarMappable(Normalize(0.0, limit), _colormap())
        scale = figure.colorbar(colors, cax=axes, extend="max" if beyond else "neither")
        scale.outline.set_linewidth(0.6)
        scale.set_label("equivalent stress (von Mises), MPa", color=TEXT_COLOR)
        axes.tick_params(width=0.6)
        figure.text(
            side / figure_width,
            1.0 - 0.34 / figure_height,
            texts[0],
            fontsize=14,
            fontweight="bold",
            color=TEXT_COLOR,
            va="center",
        )
        figure.text(
            side / figure_width, 1.0 - 0.66 / figure_height, texts[1], color=TEXT_COLOR, va="center"
        )
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


def main() -> None:
    """Draw what another process has saved."""
    arrays, folder = read_arguments()
    render(arrays, folder)


if __name__ == "__main__":
    main()
