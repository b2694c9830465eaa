"""Tables of pressure and torque that look like slips: another angle, sense, sign or unit."""

import math
from collections.abc import Iterator

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.sentences import amount, angle
from crankfem.files.engine.usual_parts import EngineScale, Practice
from crankfem.files.reading.toml_file import InputWarning
from dynamics.engine.forces import piston_position
from dynamics.engine.layout import EngineLayout
from dynamics.gas.pressure import (
    ATMOSPHERE,
    GasPressure,
    compression_line,
    cylinder_volume,
    periodic_slope,
)
from dynamics.harmonics import read_torque_table

EXPONENT = Practice(
    1.25, 1.4, "has a compression line with {} for exponent", "in p V^n", margin=1.06
)
PEAK_ANGLE = Practice(2.0, 20.0, "is highest {} after the top", "deg", margin=1.5)
LOWEST = Practice(0.7, 3.0, "is {} the atmosphere", margin=1.3)
MEAN_TORQUE = Practice(0.8, 1.3, "is {} the rated torque for each throw")
# Between these angles [deg] the pressure rises to its peak and falls behind it; a change against that of
# this share is a dropout, more than the waves of a gauge's channel.
CLOSED, DROPOUT = 90.0, 0.15


def table_warnings(scale: EngineScale) -> Iterator[InputWarning]:
    """Name what is unusual of an engine's tables of pressure and torque."""
    file = scale.file
    if file.gas is not None and file.gas.pressure_table is not None and not file.engine.driven_by:
        yield from pressure_warnings(file.pressure[0], file.layout, file.gas.compression_ratio)
    if file.torque_table is not None:
        table = read_torque_table(file.torque_table, strokes=file.engine.strokes)
        # A table is compared with the torque of a throw at the rated point.
        layout, pressure = scale.file.layout, scale.file.pressure
        field, mean = "torque.table", float(table.torque.mean())
        sense = -1.0 if scale.file.engine.driven_by else 1.0
        usual = sense * scale.torque / len(scale.file.crank_throws)
        hint = "; perhaps sign or order of the samples" if mean * usual < 0.0 else ""
        for warning in MEAN_TORQUE.warning_of(field, mean, "N m", mean / usual):
            yield warning.with_hint(hint)
        if pressure and len(layout.cylinders) == len(scale.file.crank_throws):
            torque = cylinder_torque(scale, layout, pressure[0], table.torque.size)
            along, against = (
                _likeness(torque, samples) for samples in (table.torque, table.torque[::-1])
            )
            if against > along:
                yield InputWarning(
                    field,
                    f"in the order given its samples correlate by {along:.2g} with the torque of a "
                    f"throw at rated speed, in the reverse order by {against:.2g}; perhaps the angles "
                    "are in reverse order",
                )


def pressure_warnings(
    pressure: GasPressure, layout: EngineLayout, compression_ratio: float
) -> Iterator[InputWarning]:
    """Compare a measured diagram with the compression, peak and lowest pressure of engines."""
    field = "gas.pressure_table"
    volume = cylinder_volume(
        piston_position(layout, 1), layout.cylinders[0].area, compression_ratio
    )
    exponent = -compression_line(pressure, volume)[0]
    text = f"the pressure, with compression ratio {compression_ratio:g}"
    for warning in EXPONENT.warning(field, text, exponent):
        yield warning.with_hint("; perhaps shifted, or gauge for absolute")
    peak = amount(pressure.peak_pressure, "Pa", 3)
    yield from PEAK_ANGLE.warning(field, f"its peak of {peak}", pressure.peak_angle_deg)
    least = f"its lowest pressure of {amount(pressure.lowest, 'Pa', 3)}"
    for warning in LOWEST.warning(field, least, pressure.lowest / ATMOSPHERE):
        yield warning.with_hint("; perhaps gauge for absolute, or a dropout")
    order = np.argsort(pressure.angles_from_top)
    angles, values = pressure.angles_from_top[order], pressure.pressure[order]
    top = int(np.argmax(values))
    # Towards the peak from either side, each sample beside the highest before it.
    for near in (slice(top + 1), slice(None, top - 1 if top else None, -1)):
        within = np.abs(angles[near]) <= CLOSED
        rising, at = values[near][within], angles[near][within]
        falls = rising / np.maximum.accumulate(rising)
        if falls.size and falls.min() < 1.0 - DROPOUT:
            yield InputWarning(
                field,
                f"the pressure at {angle(at[int(np.argmin(falls))], 4)} is {falls.min():.3g} times "
                f"that farther from the peak; usual is at least {1.0 - DROPOUT:g} times ({EXPONENT.basis}); "
                "perhaps a dropout",
            )


def cylinder_torque(
    scale: EngineScale, layout: EngineLayout, pressure: GasPressure, samples: int
) -> FloatArray:
    """Return the torque of gas and reciprocating mass of the first cylinder over a cycle [N m]."""
    angles = 180.0 * layout.strokes / samples * np.arange(samples)
    period = math.pi * layout.strokes
    slope = periodic_slope(piston_position(layout, 1)(np.radians(angles)), period)
    rod = scale.file.rod
    mass = scale.file.piston.mass + rod.mass - rod.rotating_mass
    force = (pressure.at(angle_deg=angles) - ATMOSPHERE) * layout.cylinders[0].area
    inertia = mass * scale.file.engine.rated_speed**2 * periodic_slope(slope, period)
    return np.asarray(-(force + inertia) * slope)


def _likeness(first: FloatArray, second: FloatArray) -> float:
    """Return the largest correlation of two series over a cycle, wherever either begins."""
    parts = [np.fft.rfft(series - series.mean()) for series in (first, second)]
    shifted = np.fft.irfft(parts[0] * np.conj(parts[1]), n=first.size)
    return float(shifted.max() / first.size / (first.std() * second.std() + 1e-300))
