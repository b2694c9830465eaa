"""Compliances of an engine's throws from every source: finite elements, regression, formulas."""

import numpy as np
from numpy.typing import NDArray

from crankfem.files.engine.engine_file import EngineFile
from fem.shaft import ShaftCompliances, shaft_compliances
from fem.throw_analysis import ThrowAnalysis
from regression.formulas.arguments import fold_angle_deg
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.compliance_model import ComplianceModel

FE, FE_PINNED, REGRESSION = "fe", "fe pinned", "regression"
# The formulas know no free end: a throw tilts there as it does beside an opposite crank.
NO_NEIGHBOR_DEG = 180.0

# Source to the compliance of each throw, and how it was used.
Sources = dict[str, tuple[NDArray[np.float64], str]]


def compliances_in_shaft(engine_file: EngineFile, analysis: ThrowAnalysis) -> ShaftCompliances:
    """FE compliances of each throw at its place among the engine's cranks."""
    throws = [analysis.superelement] * len(engine_file.throw_angles)
    return shaft_compliances(throws, engine_file.throw_angles)


def axial_sources(
    engine_file: EngineFile,
    analysis: ThrowAnalysis,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Axial compliance of each throw [m/N] by source; see `crankfem.analyses.vibration.modes`."""
    pinned = analysis.axial_compliance("pinned")
    sources = _fe_sources(shaft.axial, pinned)
    if model is not None:
        value = model.of_throw(engine_file.throw)["axial_compliance"].value
        sources[REGRESSION] = _from_regression(shaft.axial, value, pinned)
    return sources | _axial_formula_sources(engine_file)


def torsional_sources(
    engine_file: EngineFile,
    analysis: ThrowAnalysis,
    shaft: ShaftCompliances,
    model: ComplianceModel | None,
) -> Sources:
    """Torsional compliance of each throw [rad/(N m)] by source."""
    pinned = analysis.torsional_compliance("pinned")
    sources = _fe_sources(shaft.torsional, pinned)
    if model is not None:
        value = model.of_throw(engine_file.throw)["torsional_compliance"].value
        sources[REGRESSION] = _from_regression(shaft.torsional, value, pinned)
    material = engine_file.material
    count = len(engine_file.throw_angles)
    for name, formula in torsional_formulas(
        engine_file.throw,
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=material.poisson_ratio,
    ).items():
        sources[name] = (np.full(count, formula.value), "the same for every throw")
    return sources


def _fe_sources(in_shaft: NDArray[np.float64], pinned: float) -> Sources:
    return {
        FE: (in_shaft, "superelements assembled at the crank angles"),
        FE_PINNED: (
            np.full_like(in_shaft, pinned),
            "a single throw with ends free to tilt; too soft beside neighbors that hinder the tilt",
        ),
    }


def _from_regression(
    in_shaft: NDArray[np.float64], value: float, pinned: float
) -> tuple[NDArray[np.float64], str]:
    return (
        value * in_shaft / pinned,
        "the equation's pinned value, times each throw's ratio from the assembled superelements",
    )


def _axial_formula_sources(engine_file: EngineFile) -> Sources:
    """Formula values of each throw: the mean of those at the angles to either neighbor."""
    angles = np.rad2deg(engine_file.throw_angles)
    gaps = [NO_NEIGHBOR_DEG, *np.abs(np.diff(angles)).tolist(), NO_NEIGHBOR_DEG]
    material = engine_file.material
    tables = [
        axial_formulas(
            engine_file.throw,
            gap,
            youngs_modulus=material.youngs_modulus,
            poisson_ratio=material.poisson_ratio,
        )
        for gap in gaps
    ]
    sources: Sources = {}
    for name in tables[0]:
        values = np.array([table[name].value for table in tables])
        wrong = {
            round(fold_angle_deg(gap))
            for gap, table in zip(gaps, tables, strict=True)
            if not table[name].valid
        }
        remark = "mean of the formula at the angles to both neighbors; 180 deg at the shaft's ends"
        if wrong:
            remark += f"; does not apply at {', '.join(str(angle) for angle in sorted(wrong))} deg"
        sources[name] = (0.5 * (values[:-1] + values[1:]), remark)
    return sources
