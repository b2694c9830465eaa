"""Pictures of the stress on a throw under each unit load, and the surface of the whole throw for them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError
from crankbase.outputs import check_output, copy_picture
from crankbase.processes import scratch_folder
from crankbase.quantity import UNITS
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from fem.analysis import ThrowAnalysis
from fem.fields import displacement_field, images
from fem.fillet_peaks import (
    FilletPeak,
    FilletStresses,
    OilHolePeak,
    UnitLoad,
    von_mises,
)
from fem.superelement import RZ, UZ
from fem.supports import end_motions
from fem.whole_throw import whole_facets, whole_nodes, whole_points
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE
from geometry.solid_files import write_mesh


@dataclass(frozen=True, eq=False)
class ThrowSurface:
    """Curved triangles of a throw's outside.

    Attributes
    ----------
    points : (n, 3) array
        All nodes of the throw, those on the cuts once [m].
    facets : (t, 6) array
        Corners, then edge middles, of each triangle, counterclockwise from outside.
    values : (n, ...) array
        At the nodes: displacements (n, 3) [m], or equivalent stresses (n, loads) [Pa].
    """

    points: Array
    facets: Integers
    values: Array


def write_vtu(analysis: ThrowAnalysis, path: str | Path) -> Path:
    """Write the solved mesh with its displacement under 1 N of axial pull, ends pinned.

    Parameters
    ----------
    path : path
        File ending in ``.vtu`` or another format of `write_mesh` that carries values at nodes.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the ending is unknown, or the file cannot be written.
    """
    field = displacement_field(analysis.classes, _stretched_ends(analysis))
    return write_mesh(analysis.mesh, path, {"displacement": field})


def stretched_surface(analysis: ThrowAnalysis) -> ThrowSurface:
    """Return the surface of the whole throw with displacements under an axial pull of 1 N, ends pinned."""
    mesh = analysis.mesh
    whole = whole_nodes(mesh)
    copies = images(mesh, analysis.classes, _stretched_ends(analysis))
    return ThrowSurface(
        whole_points(mesh, whole),
        whole_facets(whole, outside_facets(mesh)),
        whole.collect([copy.displacement for copy in copies]),
    )


def stressed_surface(stresses: FilletStresses) -> ThrowSurface:
    """Return the surface of the whole throw with equivalent stresses (von Mises) under all loads."""
    loaded, mesh = stresses.loaded, stresses.loaded.mesh
    whole = loaded.whole
    equivalent = whole.collect([von_mises(part) for part in loaded.stresses(whole.images)])
    # Where it is known better.
    equivalent[stresses.surface.nodes] = von_mises(stresses.surface.stress)
    facets = whole_facets(whole, outside_facets(mesh))
    return ThrowSurface(whole_points(mesh, whole), facets, equivalent)


def outside_facets(mesh: ThrowMesh) -> Integers:
    """Return the facets (t, 6) of the meshed part that are not on its cuts, by surface."""
    return six_node_triangles(mesh, np.concatenate(list(outside_corners(mesh).values())))


def outside_corners(mesh: ThrowMesh) -> dict[str, Integers]:
    """Return the corners of those facets, by the name of their surface."""
    return {
        name: corners
        for name, corners in mesh.surfaces.items()
        if name not in (CRANK_PLANE, MIDDLE_PLANE)
    }


def _stretched_ends(analysis: ThrowAnalysis) -> Array:
    """Motions (12,) of both ends under an axial pull of 1 N, moving apart by equal amounts."""
    motions = end_motions(analysis.superelement, "pinned")[:, 0]
    for unknown in (UZ, RZ):
        motions[[unknown, 6 + unknown]] -= 0.5 * (motions[unknown] + motions[6 + unknown])
    return motions


Peak = TypeVar("Peak", FilletPeak, OilHolePeak)
# What draws them, in a process that needs no finite elements.
RENDER = "crankfem.analyses.throw.pictures.stress_rendering:render"
# Stresses are shown for loads of 1 kN and 1 kN m, in MPa.
STRESS_SHOWN = UNITS["kN"][1] / UNITS["MPa"][1]


def picture_stresses(stresses: FilletStresses, folder: str | Path) -> tuple[Path, ...]:
    """Write a picture of the equivalent stress for each unit load.

    Parameters
    ----------
    folder : path
        Folder for the files ``stress-axial.png`` and so on; created if necessary.

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
        OffscreenProcess(RENDER, scratch, picture_arrays(stresses)).wait()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for name in names:
                copy_picture(scratch / name, folder / name)
        except OSError as error:
            raise InputError(f"{folder}: cannot be written ({error.strerror or error}).") from None
    return tuple(folder / name for name in names)


def picture_name(load: UnitLoad) -> str:
    """Name of the file of a load's picture."""
    pin = "" if load.pin in (None, 0) else f"-{load.pin + 1}"
    return f"stress-{load.kind.replace(' ', '-')}{pin}.png"


def picture_arrays(stresses: FilletStresses) -> dict[str, NDArray[Any]]:
    """Content of the pictures: nodes and facets of the whole throw and of its half, stresses, texts."""
    loaded = stresses.loaded
    mesh = loaded.mesh
    whole, surface = loaded.whole, stressed_surface(stresses)
    on_cut = six_node_triangles(mesh, mesh.surfaces.get(CRANK_PLANE, np.empty((0, 3), int)))
    here = [not image.across_crank for image in whole.images]
    both = np.concatenate([outside_facets(mesh), on_cut])
    half = np.concatenate(
        [
            whole_facets(whole, both).reshape(len(here), -1, 6)[place]
            for place in np.flatnonzero(here)
        ]
    )
    peaks = [marked_peaks(stresses, load) for load in loaded.loads]
    return {
        "points": surface.points,
        "facets": surface.facets,
        "half": half if len(on_cut) else np.empty((0, 6), dtype=np.int64),
        "stress": surface.values.T * STRESS_SHOWN,
        # Of a symmetric throw, those in the mirror images are alike: (loads, marks, images, 3).
        "places": np.array(
            [
                [[image.points(_seen_place(peak)) for image in whole.images] for peak in of_load]
                for of_load in peaks
            ]
        ),
        "largest": np.array([max(peak.von_mises for peak in of_load) for of_load in peaks])
        * STRESS_SHOWN,
        "titles": np.array([load_title(load) for load in loaded.loads]),
        "remarks": np.array(["\n".join(map(_remark, of_load)) for of_load in peaks]),
        "files": np.array([picture_name(load) for load in loaded.loads]),
    }


def marked_peaks(stresses: FilletStresses, load: UnitLoad) -> list[FilletPeak | OilHolePeak]:
    """Return the largest peak at a fillet and the one at an oil hole, if any."""
    fillets, holes = stresses.under(load), stresses.at_oil_holes(load)
    peaks: list[FilletPeak | OilHolePeak] = [largest_peak(fillets)] if fillets else []
    return [*peaks, largest_peak(holes)] if holes else peaks


def largest_peak(peaks: Sequence[Peak]) -> Peak:
    """Return the peak of the largest equivalent stress; of mirror images the first."""
    largest = max(peak.von_mises for peak in peaks)
    return next(peak for peak in peaks if peak.von_mises > (1.0 - 1e-6) * largest)


def load_title(load: UnitLoad) -> str:
    """Describe the content."""
    return f"{load.name[0].upper()}{load.name[1:]}: 1 k{load.unit}, ends pinned"


def _seen_place(peak: FilletPeak | OilHolePeak) -> Array:
    """Position of a peak's mark: of one inside an oil hole on the rim above it."""
    if isinstance(peak, FilletPeak):
        return peak.von_mises_place
    hole = peak.outlet.drilling
    off = peak.von_mises_place[:2] - hole.axis
    rim = hole.axis + off * (hole.journal_radius / np.linalg.norm(off))
    return np.array([*rim, peak.von_mises_place[2]])


def _remark(peak: FilletPeak | OilHolePeak) -> str:
    """State where the largest stress at a fillet or oil hole is."""
    place = ", ".join(
        f"{axis} = {round(1e3 * value, 1) + 0.0:g} mm"
        for axis, value in zip("xyz", peak.von_mises_place, strict=True)
    )
    size = peak.von_mises * STRESS_SHOWN
    return (
        f"largest at {'a fillet' if isinstance(peak, FilletPeak) else 'an oil hole'}: {size:.3g} MPa "
        f"({peak.name}; {place}), {peak.von_mises_factor:.2f} times the nominal stress"
    )
