"""Masses of an engine's whole crankshaft, and compliances of its throws beside those of single ones."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Flat, Quantity, Result, result
from crankfem.files.engine.engine_file import EngineFile
from fem.analysis import ThrowAnalysis
from fem.superelement import ShaftCompliances
from geometry.mass import Unbalance, unbalance

Ratios = Annotated[Array, Quantity("1")]


@result("compliances", "axial_beside_pinned", "torsional_beside_pinned")
class ThrowsInShaft(Result):
    """Compliances of each throw in the shaft, also over those of the single throw with pinned ends."""

    compliances: Flat[ShaftCompliances]
    axial_beside_pinned: Ratios
    torsional_beside_pinned: Ratios


def throws_in_shaft(shaft: ShaftCompliances, analyses: Sequence[ThrowAnalysis]) -> ThrowsInShaft:
    """Return the compliances of throws in the shaft beside those of the single ones."""
    axial = np.array([analysis.axial_compliance("pinned") for analysis in analyses])
    torsional = np.array([analysis.torsional_compliance("pinned") for analysis in analyses])
    return ThrowsInShaft(shaft, shaft.axial / axial, shaft.torsional / torsional)


@result("mass", "length", "inertia_about_shaft")
class ShaftBalance(Result):
    """Masses and unbalance of the whole crankshaft, about the middle of its throws; without rods."""

    mass: Annotated[float, Quantity("kg")]
    length: Annotated[float, Quantity("m")]
    inertia_about_shaft: Annotated[float, Quantity("kg m^2")]
    unbalance: Flat[Unbalance]


def shaft_balance(engine_file: EngineFile) -> ShaftBalance:
    """Return masses and unbalance of an engine's crankshaft."""
    shaft = engine_file.crankshaft
    masses = shaft.masses(engine_file.material.density)
    left = unbalance(masses, 0.5 * float(shaft.starts[-1]))
    # What would be there if all throws pointed one way: beside it, round-off is nothing.
    aligned = engine_file.throw.crank_radius * masses.mass
    static, dynamic = (
        np.where(np.abs(values) < 1e-9 * scale, 0.0, values)
        for values, scale in ((left.static, aligned), (left.dynamic, aligned * shaft.length))
    )
    return ShaftBalance(
        masses.mass, shaft.length, masses.inertia_about_shaft, Unbalance(static, dynamic)
    )
