"""Estimated errors of a throw's corrected results, from those of its mesh."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fem.correction import error_bars
from fem.superelement import Superelement
from fem.supports import Neighbors, Support, SupportedThrow, support_throw

# An entry so small beside those on the diagonal is round-off.
VANISHING = 1e-9
# Steps of the cranks [deg] between which a throw of equal webs and rigid sections is guided or pinned.
IN_LINE, OPPOSITE = 0.0, 180.0


def axial_correction(corrected: Superelement, discrete: Superelement) -> float:
    """Share of the axial compliance, pinned, that is correction: how coarse the mesh is."""
    return 1.0 - support_throw(discrete, "pinned").axial / support_throw(corrected, "pinned").axial


def supported_errors(
    corrected: Superelement, discrete: Superelement, support: Support
) -> SupportedThrow:
    """Estimated errors of the compliances under a support, in their units; see `error_bars`."""
    here, mesh = support_throw(corrected, support), support_throw(discrete, support)
    coarse, missing = axial_correction(corrected, discrete), corrected.missing
    return SupportedThrow(
        axial=float(error_bars(here.axial, mesh.axial, coarse, missing=missing)),
        torsional=float(error_bars(here.torsional, mesh.torsional, coarse, missing=missing)),
        stretches=error_bars(here.stretches, mesh.stretches, coarse, missing=missing),
        influences=error_bars(here.influences, mesh.influences, coarse, missing=missing),
    )


def section_errors(throw: Superelement, support: Support) -> SupportedThrow:
    """Effect of rigid sections on a throw's compliances, in their units; see `ThrowAnalysis`."""
    step = IN_LINE if support == "guided" else OPPOSITE
    where = support if isinstance(support, Neighbors) else Neighbors(step, step)
    bending = support_throw(throw, where)
    rigid = support_throw(replace(throw, bending=None), where)
    return SupportedThrow(
        axial=bending.axial - rigid.axial,
        torsional=bending.torsional - rigid.torsional,
        stretches=bending.stretches - rigid.stretches,
        influences=bending.influences - rigid.influences,
    )


def stiffness_errors(corrected: Superelement, discrete: Superelement) -> NDArray[np.float64]:
    """Estimated errors (12, 12) of the entries of the stiffness [SI]; see `error_bars`.

    The size of an entry is half of the geometric mean of the corresponding diagonal entries; entries that
    vanish by symmetry have no error.
    """
    stiffness, coarse = corrected.stiffness, axial_correction(corrected, discrete)
    diagonal = np.sqrt(np.diag(stiffness))
    sizes = 0.5 * np.outer(diagonal, diagonal)
    bars = error_bars(stiffness, discrete.stiffness, coarse, sizes, corrected.missing)
    return np.where(np.abs(stiffness) > VANISHING * sizes, bars, 0.0)
