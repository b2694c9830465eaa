"""Compliances of an engine's throws from every source: finite elements, regression, formulas."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankfem.analyses.shaft.bearings import bearing_stiffness
from crankfem.analyses.shaft.law_source import LawValue, law_values
from crankfem.analyses.shaft.regression_source import REGRESSION, throw_lookups
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.analyses.throw.law_record import LAW
from crankfem.files.chain.shaft_lines import PLANT, plant_chain
from crankfem.files.engine.engine_file import EngineFile
from fem.material import Material
from fem.shaft import ShaftCompliances, shaft_compliances
from geometry.throw import CrankThrow
from regression.formulas.arguments import fold_angle_deg
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import FormulaValue
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.compliance_model import ComplianceModel
from regression.models.lookup import Lookup

FE, FE_PINNED = "fe", "fe pinned"
# Of the torsional chain of a plant, as its maker gives it.
GIVEN = "given"
# The formulas know no free end: a throw tilts there as it does beside an opposite crank.
NO_NEIGHBOR_DEG = 180.0

# Source to the compliance of each throw, and how it was used.
Sources = dict[str, tuple[NDArray[np.float64], str]]


def compliances_in_shaft(
    engine_file: EngineFile, analysis: Analyses, stiffness: float | None = None
) -> ShaftCompliances:
    """Find the FE compliances of each throw at its position among the engine's cranks.

    Parameters
    ----------
    engine_file : EngineFile
    analysis : ThrowAnalysis or mapping
        Of the engine's throw, or of each throw by its name.
    stiffness : float, optional
        Lateral, of each main bearing [N/m], ``math.inf`` for rigid ones; that of `bearing_stiffness` by
        default.
    """
    throws = [own.superelement for own in crank_analyses(engine_file, analysis)]
    held = bearing_stiffness(engine_file).nominal if stiffness is None else stiffness
    return shaft_compliances(
        throws, crank_angles_deg=engine_file.throw_angles_deg, bearing_stiffness=held
    )


def axial_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Axial compliance of each throw [m/N] by source; see `crankfem.analyses.vibration.modes`."""
    fitted = _fitted_sources(engine_file, analysis, model, "axial_compliance", shaft.axial)
    return fitted | axial_by_formulas(
        engine_file.crank_throws, engine_file.throw_angles_deg, engine_file.material
    )


def torsional_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Torsional compliance of each throw [rad/(N m)] by source; only the maker's for a given plant."""
    if PLANT in engine_file.shaft_lines:
        return {GIVEN: _given_by_plant(engine_file)}
    fitted = _fitted_sources(engine_file, analysis, model, "torsional_compliance", shaft.torsional)
    return fitted | torsional_by_formulas(engine_file.crank_throws, engine_file.material)


def _given_by_plant(engine_file: EngineFile) -> tuple[NDArray[np.float64], str]:
    """Half of the compliance on either side of each crank, in a plant's chain."""
    chain = engine_file.shaft_lines[PLANT]
    nodes = plant_chain(chain, np.bincount(engine_file.throws).tolist()).throw_nodes
    halves = 0.5 / chain.stiffness
    # Before the first crank there may be nothing: it is taken to be as after it.
    after = halves[list(nodes)]
    before = np.concatenate((after[:1], after[:-1]))
    remark = "the chain of the plant as its maker gives it (shaft_line.plant)"
    return after + before, remark


def _fitted_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    model: ComplianceModel | None,
    quantity: str,
    in_shaft: NDArray[np.float64],
) -> Sources:
    """Compliances by finite elements, and by the equations and the law fitted to them."""
    each = crank_analyses(engine_file, analysis)
    pinned = np.array([getattr(own, quantity)("pinned") for own in each])
    found: Sources = {
        FE: (in_shaft, "superelements assembled at the crank angles, in elastic main bearings"),
        FE_PINNED: (
            pinned,
            "a single throw with ends free to tilt, as in journals that move freely sideways; bearings "
            "stiffen it",
        ),
    }
    ratios = in_shaft / pinned
    if model is not None:
        found[REGRESSION] = _looked_up(
            "equation", ratios, engine_file, lambda: throw_lookups(engine_file, model, quantity)
        )
    found[LAW] = _looked_up("law", ratios, engine_file, lambda: law_values(engine_file, quantity))
    return found


def _looked_up(
    name: str,
    ratios: NDArray[np.float64],
    engine_file: EngineFile,
    look_up: Callable[[], Mapping[CrankThrow, Lookup | LawValue]],
) -> tuple[NDArray[np.float64], str]:
    """Looked-up values of each throw in the shaft; NaN where a throw has none."""
    try:
        found = look_up()
    except InputError as error:
        return np.full_like(ratios, np.nan), str(error)
    return (
        np.array([found[throw].value for throw in engine_file.crank_throws]) * ratios,
        f"the {name}'s pinned value, times each throw's ratio from the assembled superelements",
    )


def neighbor_angles(throw_angles_deg: Sequence[float]) -> list[tuple[float, float]]:
    """Return the angles between each throw and its neighbors [deg] from the throws' angles [deg]."""
    gaps = np.abs(np.diff(throw_angles_deg)).tolist()
    return list(zip((NO_NEIGHBOR_DEG, *gaps), (*gaps, NO_NEIGHBOR_DEG), strict=True))


def axial_by_formulas(
    throws: Sequence[CrankThrow], throw_angles_deg: Sequence[float], material: Material
) -> Sources:
    """Formula values of each throw [m/N]: the mean of those at the angles to both neighbors.

    Parameters
    ----------
    throws : sequence of CrankThrow
        Of the cranks, from the free end.
    throw_angles_deg : sequence of float
        Those of the cranks [deg].
    material : Material
    """

    @cache
    def formulas(throw: CrankThrow, gap: float) -> dict[str, FormulaValue]:
        return axial_formulas(throw, gap, material=material)

    # Of each throw: the angles to its neighbors, and the formulas at both.
    sides = [
        [(gap, formulas(throw, gap)) for gap in beside]
        for throw, beside in zip(throws, neighbor_angles(throw_angles_deg), strict=True)
    ]
    sources: Sources = {}
    for name in sides[0][0][1]:
        values = np.array([[table[name].value for _, table in beside] for beside in sides])
        wrong = {
            round(fold_angle_deg(gap))
            for beside in sides
            for gap, table in beside
            if not table[name].valid
        }
        remark = "mean of the formula at the angles to both neighbors; 180 deg at the shaft's ends"
        if wrong:
            remark += f"; does not apply at {', '.join(str(angle) for angle in sorted(wrong))} deg"
        sources[name] = (0.5 * (values[:, 0] + values[:, 1]), remark)
    return sources


def torsional_by_formulas(throws: Sequence[CrankThrow], material: Material) -> Sources:
    """Formula values of each throw [rad/(N m)]; arguments as `axial_by_formulas`."""
    tables = {
        throw: torsional_formulas(throw, material=material) for throw in dict.fromkeys(throws)
    }
    remark = "the same for every throw" if len(tables) == 1 else "by each throw's own dimensions"
    each = [tables[throw] for throw in throws]
    return {name: (np.array([own[name].value for own in each]), remark) for name in each[0]}
