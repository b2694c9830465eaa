"""Pictures of the stress on a throw under each unit load, with marks at fillets and oil holes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.outputs import check_output, copy_file
from crankbase.processes import scratch_folder
from crankbase.units.units import UNITS
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.surface import outside_facets, stressed_surface
from fem.fillet_peaks import FilletPeak, FilletStresses, OilHolePeak
from fem.unit_loads import UnitLoad, whole_facets, whole_nodes
from geometry.mesh import six_node_triangles
from geometry.solid import CRANK_PLANE

Array = NDArray[np.float64]
Peak = TypeVar("Peak", FilletPeak, OilHolePeak)
# What draws them, in a process that needs no finite elements.
RENDER = "crankfem.analyses.throw.pictures.stress_rendering:render"
# Stresses are shown for loads of 1 kN and 1 kN m, in MPa.
STRESS_SHOWN = UNITS["kN"][1] / UNITS["MPa"][1]


def picture_stresses(stresses: FilletStresses, folder: str | Path) -> tuple[Path, ...]:
    """Write a picture of the equivalent stress for each unit load.

    Parameters
    ----------
    stresses : FilletStresses
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
                copy_file(scratch / name, folder / name, "picture")
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
    whole, surface = whole_nodes(mesh), stressed_surface(stresses)
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
    found: list[FilletPeak | OilHolePeak] = [largest_peak(fillets)] if fillets else []
    return [*found, largest_peak(holes)] if holes else found


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
