"""Harmonics of a torque and stars of its cylinders, as plain JSON content, and their table."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table
from crankbase.tables.table_units import table_unit
from crankfem.analyses.record import Record, attributes
from dynamics.harmonics import Harmonics, TorqueTable
from dynamics.torque.star import Star, leading_stars, same_stars, star_diagram

COLUMNS = ("orders", "cosine", "sine", "amplitude", "phase_deg")
# How far the samples are from the sum up to an order, and how a table calls it.
RESIDUALS = {"residual_rms": "residual rms", "residual_largest": "largest residual"}


def harmonics_record(found: Harmonics) -> Record:
    """Mean and harmonics M_k sin(k w t + a_k)."""
    names = ("strokes", "samples", "mean", "highest_order", *COLUMNS[:-1])
    return {**attributes(found, *names), "phase_deg": np.rad2deg(found.phase).tolist()}


def residual_record(found: Harmonics, table: TorqueTable) -> Record:
    """Difference of a table's samples from mean and harmonics up to each order, in its unit."""
    each = found.each_at(crank_angle_deg=table.crank_angle_deg)
    residual = table.torque - found.mean - np.cumsum(each, axis=0)
    return {
        "residual_rms": np.sqrt(np.mean(residual**2, axis=1)).tolist(),
        "residual_largest": np.max(np.abs(residual), axis=1).tolist(),
    }


def stars_record(stars: Sequence[Star]) -> Record:
    """The star of each order, the leading ones, and those of equal shape."""
    return {
        "stars": [
            {
                **attributes(star, "order", "kind", "resultant", "share"),
                "directions_deg": np.rad2deg(np.radians(star.directions_deg)).tolist(),
            }
            for star in stars
        ],
        "leading_orders": [star.order for star in leading_stars(stars)],
        "same_stars": [[star.order for star in group] for group in same_stars(stars)],
    }


def seen_stars(found: Harmonics, firing_angles_deg: ArrayLike) -> tuple[Star, ...]:
    """Return the star of each order except the one for which an even number of samples has one phase only."""
    blind = found.highest_order if found.samples % 2 == 0 else math.inf
    return star_diagram(
        orders=found.orders[found.orders < blind * (1.0 - 1e-9)],
        firing_angles_deg=firing_angles_deg,
        strokes=found.strokes,
    )


def fired_record(
    found: Harmonics, stars: Sequence[Star], firing_angles_deg: Sequence[float]
) -> Record:
    """Stars of cylinders with these harmonics each, phases from their firing tops, and their torque."""
    count = len(stars)
    sums = np.array([0.0 if star.kind == "balanced" else star.resultant for star in stars])
    directions = np.array([math.radians(star.resultant_direction_deg) for star in stars])
    amplitude = sums * found.amplitude[:count]
    phase = np.where(amplitude > 0.0, (found.phase[:count] - directions) % (2.0 * np.pi), 0.0)
    left_out = [
        f"order {order:g} is left out, because {found.samples} samples resolve only one phase of it"
        for order in found.orders[count:].tolist()
    ]
    return {
        "firing_angles_deg": list(firing_angles_deg),
        **stars_record(stars),
        "torque": {
            "mean": len(firing_angles_deg) * found.mean,
            "orders": found.orders[:count].tolist(),
            "cosine": (amplitude * np.sin(phase)).tolist(),
            "sine": (amplitude * np.cos(phase)).tolist(),
            "amplitude": amplitude.tolist(),
            "phase_deg": np.rad2deg(phase).tolist(),
        },
        "remarks": left_out,
    }


def harmonics_table(record: Record, title: str = "Harmonics", units: OutputUnits = SI) -> Table:
    """Return orders, coefficients, amplitudes [N m] and phases of a `harmonics_record`."""
    shown = table_unit(record["amplitude"], "N m", units)
    orders, *coefficients, phases = (record[name] for name in COLUMNS)
    residuals = [name for name in RESIDUALS if name in record]
    return Table(
        title,
        [
            Column("order", digits=None),
            *(shown.column(symbol) for symbol in ("A_k", "B_k", "M_k")),
            Column("a_k", "deg", decimals=2),
            *(shown.column(RESIDUALS[name]) for name in residuals),
        ],
        list(
            zip(
                orders,
                *coefficients,
                map(math.radians, phases),
                *(record[name] for name in residuals),
                strict=True,
            )
        ),
    )
