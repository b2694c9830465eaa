"""Estimated errors of a throw's corrected answers, from those that its mesh gives."""

import numpy as np
from numpy.typing import NDArray

from fem.correction import error_bars
from fem.superelement import Superelement
from fem.supports import Support, SupportedThrow, support_throw


def axial_correction(corrected: Superelement, discrete: Superelement) -> float:
    """Share of the axial compliance, pinned, that is correction: how coarse the mesh is."""
    axial = (support_throw(one, "pinned").axial for one in (discrete, corrected))
    return 1.0 - next(axial) / next(axial)


def supported_errors(
    corrected: Superelement, discrete: Superelement, support: Support
) -> SupportedThrow:
    """Estimated errors of the compliances under a support, in their units; see `error_bars`."""
    here, mesh = support_throw(corrected, support), support_throw(discrete, support)
    coarse = axial_correction(corrected, discrete)
    return SupportedThrow(
        axial=float(error_bars(here.axial, mesh.axial, coarse)),
        torsional=float(error_bars(here.torsional, mesh.torsional, coarse)),
        stretches=error_bars(here.stretches, mesh.stretches, coarse),
        influences=error_bars(here.influences, mesh.influences, coarse),
    )


def stiffness_errors(corrected: Superelement, discrete: Superelement) -> NDArray[np.float64]:
    """Estimated errors (12, 12) of the entries of the stiffness [SI]; see `error_bars`."""
    coarse = axial_correction(corrected, discrete)
    return error_bars(corrected.stiffness, discrete.stiffness, coarse)
