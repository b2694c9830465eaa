"""Compliances of an engine's throws from every source: finite elements, regression, formulas."""

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankfem.analyses.shaft.bearings import bearing_stiffness
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.files.engine.engine_file import EngineFile
from fem.shaft import ShaftCompliances, shaft_compliances
from geometry.throw import CrankThrow
from regression.formulas.arguments import fold_angle_deg
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.compliance_model import ComplianceModel

FE, FE_PINNED, REGRESSION = "fe", "fe pinned", "regression"
# The formulas know no free end: a throw tilts there as it does beside an opposite crank.
NO_NEIGHBOR_DEG = 180.0

# Source to the compliance of each throw, and how it was used.
Sources = dict[str, tuple[NDArray[np.float64], str]]


def compliances_in_shaft(
    engine_file: EngineFile, analysis: Analyses, stiffness: float | None = None
) -> ShaftCompliances:
    """Find the FE compliances of each throw at its place among the engine's cranks.

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
        throws,
        crank_angles_deg=engine_file.throw_angles_deg,
        bearing_stiffness=held,
    )


def axial_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Axial compliance of each throw [m/N] by source; see `crankfem.analyses.vibration.modes`."""
    fitted = _fitted_sources(engine_file, analysis, model, "axial_compliance", shaft.axial)
    return fitted | _axial_formula_sources(engine_file)


def torsional_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Torsional compliance of each throw [rad/(N m)] by source."""
    fitted = _fitted_sources(engine_file, analysis, model, "torsional_compliance", shaft.torsional)
    return fitted | _torsional_formula_sources(engine_file)


def _fitted_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    model: ComplianceModel | None,
    quantity: str,
    in_shaft: NDArray[np.float64],
) -> Sources:
    """Compliances by finite elements, and by the equation fitted to them."""
    each = crank_analyses(engine_file, analysis)
    pinned = np.array([getattr(own, quantity)("pinned") for own in each])
    found: Sources = {
        FE: (in_shaft, "superelements assembled at the crank angles, in elastic main bearings"),
        FE_PINNED: (
            pinned,
            "a single throw with ends free to tilt: what every throw has in journals that move sideways "
            "freely; bearings stiffen it",
        ),
    }
    if model is not None:
        found[REGRESSION] = _from_regression(engine_file, model, quantity, in_shaft / pinned)
    return found


def _from_regression(
    engine_file: EngineFile, model: ComplianceModel, quantity: str, ratios: NDArray[np.float64]
) -> tuple[NDArray[np.float64], str]:
    """Values of the equation for each throw in the shaft; no numbers if a throw is not of its family."""
    values: dict[CrankThrow, float] = {}
    for name, throw in engine_file.named_throws.items():
        try:
            values[throw] = model.of_throw(throw)[quantity].value
        except (InputError, KeyError) as error:
            if len(engine_file.named_throws) == 1:
                raise
            reason = str(error) if isinstance(error, InputError) else "it is of another size"
            return np.full_like(ratios, np.nan), f"says nothing of the throw {name}: {reason}"
    return (
        np.array([values[throw] for throw in engine_file.crank_throws]) * ratios,
        "the equation's pinned value, times each throw's ratio from the assembled superelements",
    )


def _axial_formula_sources(engine_file: EngineFile) -> Sources:
    """Formula values of each throw: the mean of those at the angles to either neighbor."""
    angles = np.array(engine_file.throw_angles_deg)
    gaps = [NO_NEIGHBOR_DEG, *np.abs(np.diff(angles)).tolist(), NO_NEIGHBOR_DEG]
    material = engine_file.material
    # Of each throw: the angles to its neighbors, and the formulas at both.
    sides = [
        [
            (
                gap,
                axial_formulas(
                    throw,
                    gap,
                    youngs_modulus=material.youngs_modulus,
                    poisson_ratio=material.poisson_ratio,
                ),
            )
            for gap in beside
        ]
        for throw, *beside in zip(engine_file.crank_throws, gaps[:-1], gaps[1:], strict=True)
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


def _torsional_formula_sources(engine_file: EngineFile) -> Sources:
    material = engine_file.material
    tables = {
        throw: torsional_formulas(
            throw, youngs_modulus=material.youngs_modulus, poisson_ratio=material.poisson_ratio
        )
        for throw in dict.fromkeys(engine_file.crank_throws)
    }
    remark = "the same for every throw" if len(tables) == 1 else "by each throw's own dimensions"
    each = [tables[throw] for throw in engine_file.crank_throws]
    return {name: (np.array([own[name].value for own in each]), remark) for name in each[0]}
