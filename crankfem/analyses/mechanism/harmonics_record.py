"""Harmonics of a torque and the reduction to two masses, as plain JSON content, and their table."""

import math

import numpy as np

from crankbase.tables.output_units import SI, OutputUnits
from crankbase.tables.table import Column, Table
from crankbase.tables.table_units import table_unit
from crankfem.analyses.record import Record, attributes
from dynamics.chains.two_mass import TwoMassCheck
from dynamics.harmonics import Harmonics

COLUMNS = ("orders", "cosine", "sine", "amplitude", "phase_deg")


def harmonics_record(found: Harmonics) -> Record:
    """Mean and harmonics M_k sin(k w t + a_k)."""
    names = ("strokes", "samples", "mean", "highest_order", *COLUMNS[:-1])
    return {**attributes(found, *names), "phase_deg": np.rad2deg(found.phase).tolist()}


def harmonics_table(record: Record, title: str = "Harmonics", units: OutputUnits = SI) -> Table:
    """Return orders, coefficients, amplitudes [N m] and phases of a `harmonics_record`."""
    shown = table_unit(record["amplitude"], "N m", units)
    orders, *coefficients, phases = (record[name] for name in COLUMNS)
    return Table(
        title,
        [
            Column("order", digits=None),
            *(shown.column(symbol) for symbol in ("A_k", "B_k", "M_k")),
            Column("a_k", "deg", decimals=2),
        ],
        list(zip(orders, *coefficients, map(math.radians, phases), strict=True)),
    )


def two_mass_record(check: TwoMassCheck) -> Record:
    """The two-mass check."""
    return {
        **attributes(check, "stiffness", "angular_frequency", "vibrations_per_minute", "order"),
        **attributes(check, "resonant_speed_rpm", "statement"),
        "frequency": check.angular_frequency / (2.0 * math.pi),
    }
