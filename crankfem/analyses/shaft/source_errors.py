"""Errors of the compliances of each source: factors that contain the true ones.

Finite elements have their estimated error, either way. A regression and the law have bands. A formula is
compared with finite elements for the throws of all shipped engines (those with one pin if the engine's
have one), each at the cranks of the engine in question, and for the engine's own: with r the ratio of the
formula's sum of compliances along the shaft to that of finite elements, and f the estimated error of these,
the true sum is (1 - f)/r to (1 + f)/r times the formula's. The range is from the least to the greatest of
these; it always includes the value itself.
"""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from crankfem.analyses.shaft.law_source import law_values
from crankfem.analyses.shaft.regression_source import REGRESSION, RESPONSES, throw_lookups
from crankfem.analyses.shaft.sources import (
    FE,
    FE_PINNED,
    GIVEN,
    axial_by_formulas,
    neighbor_angles,
    torsional_by_formulas,
)
from crankfem.analyses.shaft.throw_analyses import Analyses, analyses_by_name
from crankfem.analyses.throw.law_record import LAW
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import data_folder
from dynamics.assessment.uncertainty import Spread
from fem.material import Material
from fem.shaft import ShaftCompliances
from geometry.throw import CrankThrow
from regression.models.angle import between_values
from regression.models.compliance_model import ComplianceModel

TABLE = "throw_compliances.csv"
# Of stiffnesses that a maker gives without saying how sure they are; an assumption.
MAKERS_ERROR = 0.05


@dataclass(frozen=True)
class AnalyzedThrow:
    """Compliances of a shipped engine's throw by finite elements.

    Attributes
    ----------
    throw : CrankThrow
    material : Material
    axial : tuple of three float
        e_0 and e_180 [m/N] and rho of its angle law.
    torsional : float
        Ends pinned [rad/(N m)].
    error_estimate : float
        Relative, of the axial compliance.
    """

    throw: CrankThrow
    material: Material
    axial: tuple[float, float, float]
    torsional: float
    error_estimate: float


def source_spread(
    engine_file: EngineFile,
    kind: str,
    source: str,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Spread:
    """Return the range of factors on the compliances of a source that contains the true ones.

    Parameters
    ----------
    engine_file : EngineFile
    kind : {"axial", "torsional"}
    source : str
        As named in `axial_sources` and `torsional_sources`; usable for this engine.
    analysis : ThrowAnalysis or mapping
        Of the engine's throw, or of each throw by its name.
    shaft : ShaftCompliances
        Of the throws in the shaft.
    model : ComplianceModel or None
        If the source is a regression.

    Returns
    -------
    Spread
        Of all throws together, with its origin.
    """
    estimates = (own.error_estimate for own in analyses_by_name(engine_file, analysis).values())
    error = max(estimates)
    if source == GIVEN:
        return Spread(
            "compliance",
            1.0 - MAKERS_ERROR,
            1.0 + MAKERS_ERROR,
            name="error of the maker's stiffnesses, assumed",
        )
    if source in (FE, FE_PINNED):
        of = " (that of the axial compliance)" if kind == "torsional" else ""
        return Spread(
            "compliance", 1.0 - error, 1.0 + error, name=f"error of the finite elements{of}"
        )
    if source == REGRESSION:
        assert model is not None
        found = throw_lookups(engine_file, model, RESPONSES[kind]).values()
        return Spread(
            "compliance",
            min(own.lower / own.value for own in found if own.lower is not None),
            max(own.upper / own.value for own in found if own.upper is not None),
            name=f"error of the regression ({'; '.join(dict.fromkeys(own.band for own in found))})",
        )
    if source == LAW:
        values = law_values(engine_file, RESPONSES[kind]).values()
        return Spread(
            "compliance",
            min(own.lower / own.value for own in values),
            max(own.upper / own.value for own in values),
            name="error of the law, not exceeded by 95 of 100 throws",
        )
    return _formula_spread(engine_file, kind, source, getattr(shaft, kind), error)


def _formula_spread(
    engine_file: EngineFile, kind: str, source: str, by_elements: Iterable[float], error: float
) -> Spread:
    """Range of a formula: its ratio to finite elements for shipped throws, and for the engine's own."""
    throws = engine_file.crank_throws
    here = sum(_row(engine_file, kind, source, throws, engine_file.material)) / sum(by_elements)
    found = [(here, error)]
    single = all(_pins(throw) == 1 for throw in throws)
    for one in analyzed_throws():
        if single and _pins(one.throw) > 1:
            continue
        row = _row(engine_file, kind, source, [one.throw] * len(throws), one.material)
        beside = sum(row) / sum(_elements(engine_file, kind, one))
        if beside > 0.0:
            found.append((beside, one.error_estimate))
    others = [beside for beside, _ in found[1:]]
    return Spread(
        "compliance",
        min(1.0, *((1.0 - off) / beside for beside, off in found)),
        max(1.0, *((1.0 + off) / beside for beside, off in found)),
        name=f"error of the formula {source} ({min(others):.2f} to {max(others):.2f} times finite elements "
        f"for the throws of {len(others)} shipped engines at the angles of these cranks, {here:.2f} times "
        "for the engine's own)",
    )


def _pins(throw: CrankThrow) -> int:
    return len(throw.parts.pins)


def _row(
    engine_file: EngineFile,
    kind: str,
    source: str,
    throws: Sequence[CrankThrow],
    material: Material,
) -> list[float]:
    """Compliances by a formula along the shaft, of these throws at the engine's cranks."""
    sources = (
        axial_by_formulas(throws, engine_file.throw_angles_deg, material)
        if kind == "axial"
        else torsional_by_formulas(throws, material)
    )
    compliances: list[float] = sources[source][0].tolist()
    return compliances


def _elements(engine_file: EngineFile, kind: str, one: AnalyzedThrow) -> list[float]:
    """Compliances by finite elements of one throw at all cranks of an engine."""
    sides = neighbor_angles(engine_file.throw_angles_deg)
    if kind == "torsional":
        return [one.torsional] * len(sides)
    return [float(np.mean(between_values(np.array(beside), one.axial))) for beside in sides]


@cache
def analyzed_throws() -> tuple[AnalyzedThrow, ...]:
    """Return the throws of the shipped engines with their compliances by finite elements."""
    text = (data_folder() / "tables" / TABLE).read_text(encoding="utf-8")
    found = []
    for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#")):
        name, *numbers = row.values()
        in_line, opposite, ratio, torsional, error = map(float, numbers)
        found.append(AnalyzedThrow(*load_throw(name), (in_line, opposite, ratio), torsional, error))
    return tuple(found)
