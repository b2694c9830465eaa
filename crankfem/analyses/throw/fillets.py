"""Stresses at the fillets in a run, computed coarsely, pictured for the main loads."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from crankbase.errors import InputError, MeshError, SolveError
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.stress_picture import RENDER, picture_arrays, picture_name
from fem import fillet_stress
from fem.fillet_peaks import FilletStresses
from fem.material import Material
from geometry.throw import CrankThrow

# Of the largest stresses: enough to compare fillets and to see which is the weakest.
ACCURACY = 0.1
# What loads a throw most in an engine: the rod's force and the torque.
KINDS_SHOWN = ("radial", "torsion")


def stresses_or_reason(
    throw: CrankThrow, material: Material, mesh: fillet_stress.FilletMesh = "adaptive"
) -> tuple[FilletStresses | None, str | None]:
    """Compute the stresses at a throw's fillets; if impossible, the other results remain.

    Parameters
    ----------
    throw : CrankThrow
    material : Material
    mesh : {"adaptive", "m53"}
        See `fem.fillet_stress.fillet_stresses`.

    Returns
    -------
    FilletStresses or None
    str or None
        Why there are none.
    """
    try:
        return fillet_stress.fillet_stresses(throw, material, ACCURACY, mesh=mesh), None
    except (InputError, MeshError, SolveError) as error:
        return None, str(error)


def shown_loads(stresses: FilletStresses) -> FilletStresses:
    """Return the stresses under the loads that are pictured: radial on the first pin, and a torque."""
    loaded = stresses.loaded
    kept = [
        place
        for kind in KINDS_SHOWN
        for place, load in enumerate(loaded.loads)
        if load.kind == kind and load.pin in (None, 0)
    ]
    return of_loads(stresses, kept)


def of_loads(stresses: FilletStresses, kept: Sequence[int]) -> FilletStresses:
    """Return the stresses under some of the loads, by their indices."""
    loaded = stresses.loaded
    loads = tuple(loaded.loads[place] for place in kept)
    return replace(
        stresses,
        peaks=tuple(peak for peak in stresses.peaks if peak.load in loads),
        hole_peaks=tuple(peak for peak in stresses.hole_peaks if peak.load in loads),
        loaded=replace(
            loaded,
            loads=loads,
            shares=tuple(
                (symmetry, np.take(field, kept, axis=2)) for symmetry, field in loaded.shares
            ),
        ),
        surface=replace(stresses.surface, stress=np.take(stresses.surface.stress, kept, axis=1)),
    )


def stress_files(stresses: FilletStresses) -> dict[str, str]:
    """Return picture name to file name of the pictures of `StressRendering`."""
    names = [picture_name(load) for load in stresses.loaded.loads]
    return {Path(name).stem.replace("-", "_"): name for name in names}


class StressRendering(OffscreenProcess):
    """The pictures of stresses being rendered in the background, into a folder.

    Parameters
    ----------
    stresses : FilletStresses
        `shown_loads` of a throw.
    folder : Path
        Folder of the `stress_files`.
    """

    def __init__(self, stresses: FilletStresses, folder: Path) -> None:
        super().__init__(RENDER, folder, picture_arrays(stresses))
