"""The pressure without combustion, estimated from the compression in a fired diagram."""

import numpy as np

from crankbase.checks.arrays import finite_array
from crankbase.errors import InputError
from dynamics.gas.cylinder_volume import CylinderVolume
from dynamics.gas.pressure import GasPressure, gas_pressure

# Where a diesel engine's compression is undisturbed: after valves close, before ignition [deg].
FIT_FROM, FIT_TO = -100.0, -40.0
FEWEST_SAMPLES = 4


def motored_from_compression(
    pressure: GasPressure,
    volume: CylinderVolume,
    *,
    fit_from_deg: float = FIT_FROM,
    fit_to_deg: float = FIT_TO,
) -> GasPressure:
    """Estimate the pressure in a cylinder that does not fire from the diagram of a fired one.

    Parameters
    ----------
    pressure : GasPressure
        Of the firing cylinder.
    volume : CylinderVolume
        Over its piston.
    fit_from_deg, fit_to_deg : float, optional
        Crank angles [deg] before the top between which the diagram shows pure compression.

    Returns
    -------
    GasPressure
        The diagram itself up to `fit_to_deg`; from there to the bottom after the top the lower one of
        the diagram and of the polytrope through the compression; then the diagram again. A remark
        states the exponent.

    Raises
    ------
    InputError
        If the range is not before the top, has fewer than four samples, or the pressure does
        not rise there as in compression.

    Notes
    -----
    ln p = ln C - n ln V is fitted by least squares. The fitted n includes heat to the walls during
    compression, and the same is assumed for expansion; the lower of both curves passes to the
    blow-down without the valve timing.
    """
    low, high = (
        float(finite_array(name, value))
        for name, value in (("fit_from_deg", fit_from_deg), ("fit_to_deg", fit_to_deg))
    )
    if not -180.0 <= low < high < 0.0:
        raise InputError(
            f"fit_from_deg: given {low:g} deg to {high:g} deg; allowed is a range "
            "from -180 deg to below 0, because the gas is compressed there."
        )
    angles, cycle = pressure.angles_deg, pressure.cycle_deg
    angles = np.where(angles > cycle / 2.0, angles - cycle, angles)
    within = (angles >= low) & (angles <= high)
    if np.count_nonzero(within) < FEWEST_SAMPLES:
        raise InputError(
            f"fit_from_deg: given a range with {np.count_nonzero(within)} samples; allowed are "
            f"{FEWEST_SAMPLES} or more, because the exponent is fitted to them."
        )
    size = np.log(volume.at(angle_deg=angles))
    slope, level = np.polyfit(size[within], np.log(pressure.pressure[within]), 1)
    if not -2.0 < slope < -1.0:
        raise InputError(
            f"pressure: given a diagram with the polytropic exponent {-slope:.3g} between "
            f"{low:g} and {high:g} deg; allowed is one from 1 to 2, because "
            "compression of a gas has such."
        )
    polytrope = np.exp(level + slope * size)
    after = (angles > high) & (angles <= 180.0)
    motored = np.where(after, np.minimum(pressure.pressure, polytrope), pressure.pressure)
    remark = (
        f"Without combustion: compression with the exponent {-slope:.4g}, fitted from "
        f"{low:g} to {high:g} deg, and expansion along the same curve."
    )
    return gas_pressure(
        motored,
        pressure.strokes,
        angles_deg=pressure.angles_deg,
        source=pressure.source,
        remarks=(*pressure.remarks, remark),
    )
