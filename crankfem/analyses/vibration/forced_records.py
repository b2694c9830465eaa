"""Forced vibration as plain numbers, and the columns of its file."""

import numpy as np
from crankbase.checks.arrays import FloatArray

from crankbase.units.units import RPM
from crankfem.analyses.record import ASSUMED, Record, finite_or_none
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.vibration.forced import ForcedVibration
from dynamics.excitation.axial_comparison import AxialForceComparison
from dynamics.response.series import OrderSeries

# SI units of loads in records.
LOAD_UNIT = {"torsional": "N m", "axial": "N"}

# Shares below this are round-off: the cylinders cancel.
ROUND_OFF = 1e-12


def forced_record(forced: ForcedVibration) -> Record:
    """Return curves and peaks of a forced vibration in SI units; null where it is unbounded."""
    free_end = forced.free_end
    return {
        "kind": forced.kind,
        "damping": list(forced.damping),
        "remarks": [*_gas_remarks(forced), *forced.remarks],
        "method": forced.response.method,
        "orders": forced.response.orders.tolist(),
        "speeds_rpm": (forced.response.speeds * RPM).tolist(),
        "free_end": {
            "node": free_end.names[0],
            "unit": MOTION[forced.kind].si,
            "synthesis": _finite(free_end.synthesis.amplitude[:, 0]),
            "plain_sum": _finite(free_end.synthesis.plain_sum[:, 0]),
            "orders": _order_peaks(free_end),
        },
        "loads": _peaks(forced.loads.elements, LOAD_UNIT[forced.kind]),
        "stress": None if forced.stress is None else _peaks(forced.stress, "Pa"),
        "power": _power(forced),
        "running_rpm": [speed * RPM for speed in forced.running_range],
        "judged_rpm": [speed * RPM for speed in forced.judged_range],
        "resonances": [
            {
                "mode": one.mode,
                "frequency": one.frequency,
                "order": one.order,
                "speed_rpm": one.speed_rpm,
                "amplitude": finite_or_none(one.amplitude if one.severity > ROUND_OFF else 0.0),
                "estimate": finite_or_none(one.estimate if one.severity > ROUND_OFF else 0.0),
                "magnifier": finite_or_none(one.magnifier),
                "share": one.share,
                "severity": one.severity,
                "kind": one.kind,
                "unbounded": one.unbounded,
                "in_running_range": one.in_running_range,
            }
            for one in forced.resonances
        ],
        "axial_forces": None
        if forced.axial_forces is None
        else _axial_forces(forced.axial_forces, forced),
    }


def forced_columns(forced: ForcedVibration) -> tuple[dict[str, FloatArray], str]:
    """Return the amplitudes over the speed, of the free end by order and of loads, and what they are."""
    free_end, loads = forced.free_end, forced.loads.elements
    unit = MOTION[forced.kind].si
    load = "Nm" if forced.kind == "torsional" else "N"
    columns = {
        "speed_rpm": forced.response.speeds * RPM,
        f"free_end_synthesis_{unit}": free_end.synthesis.amplitude[:, 0],
        f"free_end_plain_sum_{unit}": free_end.synthesis.plain_sum[:, 0],
    }
    for place, order in enumerate(free_end.orders.tolist()):
        columns[f"free_end_order_{order:g}_{unit}"] = free_end.amplitude[place, :, 0]
    for place, name in enumerate(loads.names):
        columns[f"{name} [{load}]"] = loads.synthesis.amplitude[:, place]
    return columns, f"{forced.kind} vibration, amplitudes; inf is unbounded"


def _peaks(series: OrderSeries, unit: str) -> list[Record]:
    """Largest value over the speeds of each place, all orders together."""
    summed = series.synthesis
    found = []
    for place, name in enumerate(series.names):
        worst = int(np.argmax(summed.amplitude[:, place]))
        found.append(
            {
                "element": name,
                "unit": unit,
                "peak": finite_or_none(float(summed.amplitude[worst, place])),
                "speed_rpm": float(series.speeds[worst] * RPM),
                "plain_sum_peak": finite_or_none(float(np.max(summed.plain_sum[:, place]))),
            }
        )
    return found


def _order_peaks(series: OrderSeries) -> list[Record]:
    """Largest amplitude of each order at the first place, and its speed."""
    amplitude = series.amplitude[:, :, 0]
    places = np.argmax(amplitude, axis=1)
    return [
        {
            "order": order,
            "amplitude": finite_or_none(float(amplitude[row, place])),
            "speed_rpm": float(series.speeds[place] * RPM),
        }
        for row, (order, place) in enumerate(
            zip(series.orders.tolist(), places.tolist(), strict=True)
        )
    ]


def _power(forced: ForcedVibration) -> Record:
    """Where most heat arises, and how well the balance of power holds."""
    power = forced.power
    bounded = ~np.any(power.unbounded, axis=0)
    total = power.dissipated.sum(axis=0, where=~power.unbounded)
    worst = int(np.argmax(np.where(bounded, total, -1.0)))
    dampers = {
        name: float(power.dashpots[:, worst, place].sum())
        for place, name in enumerate(power.dashpot_names)
        if bounded[worst]
    }
    return {
        "unit": "W",
        # At no speed is there anything to compare, where vibration is unbounded at all of them.
        "error": power.error if np.any(bounded) else None,
        "largest": float(total[worst]),
        "speed_rpm": float(forced.response.speeds[worst] * RPM),
        "dampers": dampers,
    }


def _axial_forces(compared: AxialForceComparison, forced: ForcedVibration) -> list[Record]:
    """Largest axial force of any throw at the highest speed, two ways, by order."""
    alone, in_shaft = (
        np.abs(forces[:, -1]).max(axis=1) for forces in (compared.alone, compared.in_shaft)
    )
    none = alone <= ROUND_OFF * alone.max()
    alone[none] = in_shaft[none] = 0.0
    return [
        {
            "order": order,
            "unit": "N",
            "alone": own,
            "in_shaft": shaft,
            "difference": difference,
        }
        for order, own, shaft, difference in zip(
            forced.response.orders.tolist(),
            alone.tolist(),
            in_shaft.tolist(),
            np.where(none, 0.0, compared.difference[:, -1]).tolist(),
            strict=True,
        )
    ]


def _gas_remarks(forced: ForcedVibration) -> list[str]:
    """What the forces tell beside the gas model's own assumptions, which the mechanism reports."""
    return [text for text in forced.forces.remarks if not text.startswith((ASSUMED, "Solved"))]


def _finite(values: FloatArray) -> list[float | None]:
    return [finite_or_none(value) for value in values.tolist()]
