"""Compliances of throws in the shaft and the shaft's own balance, as plain JSON content."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crankfem.analyses.record import Record, attributes
from crankfem.files.engine.engine_file import EngineFile
from fem.shaft import ShaftCompliances
from fem.throw_analysis import ThrowAnalysis
from geometry.crankshaft import Crankshaft
from geometry.mass import unbalance


def shaft_record(shaft: ShaftCompliances, analyses: Sequence[ThrowAnalysis]) -> Record:
    """Compliances of each throw in the shaft, and those of the single throw."""
    axial = np.array([own.axial_compliance("pinned") for own in analyses])
    torsional = np.array([own.torsional_compliance("pinned") for own in analyses])
    return attributes(shaft, "axial", "torsional", "influence") | {
        "axial_beside_pinned": (shaft.axial / axial).tolist(),
        "torsional_beside_pinned": (shaft.torsional / torsional).tolist(),
    }


def shaft_balance_record(engine_file: EngineFile) -> Record:
    """Masses and unbalance of the whole crankshaft, about the middle of its throws; without rods."""
    shaft = Crankshaft(
        engine_file.crank_throws,
        crank_angles_deg=engine_file.throw_angles_deg,
        ends=engine_file.shaft_ends,
    )
    masses = shaft.masses(engine_file.material.density)
    middle = 0.5 * float(shaft.starts[-1])
    found = unbalance(masses, middle)
    # What would be there if all throws pointed one way: beside it, round-off is nothing.
    one = engine_file.throw.crank_radius * masses.mass
    return {
        "mass": masses.mass,
        "length": shaft.length,
        "inertia_about_shaft": masses.inertia_about_shaft,
        "static": _without_round_off(found.static, one),
        "dynamic": _without_round_off(found.dynamic, one * shaft.length),
    }


def _without_round_off(values: NDArray[np.float64], scale: float) -> list[float]:
    return [0.0 if abs(value) < 1e-9 * scale else float(value) for value in values]
