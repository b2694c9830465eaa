"""Ratios of the published formulas to finite elements, for many engines."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from crankfem.analyses.record import Record
from crankfem.analyses.throw.formula_records import fe_record, formula_records
from fem.analysis import analyze_throw
from fem.material import Material
from geometry.throw import CrankThrow

# Formulas differ by factors: finite elements within 2 % are far more than enough beside them.
ACCURACY = 0.02


@dataclass(frozen=True)
class Ratio:
    """Ratio of a formula's value to finite elements, and whether the formula applies to the throw."""

    value: float
    valid: bool


@dataclass(frozen=True)
class EngineSpread:
    """One engine's formulas compared with finite elements.

    Attributes
    ----------
    engine : str
    overlap : float
        Overlap of main journal and crankpin relative to the crank radius, negative without overlap.
    fe : mapping of str to float
        "axial" [m/N] and "torsional" [rad/(N m)] by finite elements.
    error_estimate : float
        Relative, of the axial compliance.
    ratios : mapping of str to mapping of str to Ratio
        "axial" and "torsional", each formula name to formula / finite elements.
    """

    engine: str
    overlap: float
    fe: Mapping[str, float]
    error_estimate: float
    ratios: Mapping[str, Mapping[str, Ratio]]


@dataclass(frozen=True)
class FormulaSpread:
    """One formula compared with finite elements over many engines: least, mean and greatest ratio."""

    least: float
    mean: float
    greatest: float


def engine_spread(
    engine: str,
    throw: CrankThrow,
    material: Material,
    gamma_deg: float = 180.0,
    variant: str = "corrected",
    constants: Mapping[str, float] | None = None,
    accuracy: float = ACCURACY,
) -> EngineSpread:
    """Compute one engine's throw by finite elements and by all formulas.

    Parameters
    ----------
    engine : str
        Its name.
    throw : CrankThrow
    material : Material
    gamma_deg, variant, constants
        As in `axial_formulas`.
    accuracy : float
        Of the finite elements.

    Raises
    ------
    InputError
        As `axial_formulas`.
    """
    found = formula_records(throw, material, gamma_deg, variant, constants)
    fe = fe_record(analyze_throw(throw, material, accuracy=accuracy), gamma_deg)
    return EngineSpread(
        engine=engine,
        overlap=throw.overlap / throw.crank_radius,
        fe={kind: fe[kind] for kind in ("axial", "torsional")},
        error_estimate=fe["error_estimate"],
        ratios={
            kind: {
                record["name"]: Ratio(record["value"] / fe[kind], record["valid"])
                for record in found[kind]
            }
            for kind in ("axial", "torsional")
        },
    )


def spread_of_engines(
    engines: Sequence[tuple[str, CrankThrow, Material]],
    compute: Callable[[str, CrankThrow, Material], EngineSpread],
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[EngineSpread, ...]:
    """Compute many engines one after another.

    Parameters
    ----------
    engines : sequence of (name, throw, material)
    compute : callable
        `engine_spread` with its further arguments.
    progress : callable, optional
        Called before each engine with its number from 1, their count, and its name.
    """
    found = []
    for number, (name, throw, material) in enumerate(engines, start=1):
        if progress is not None:
            progress(number, len(engines), name)
        found.append(compute(name, throw, material))
    return tuple(found)


def formula_spreads(spreads: Sequence[EngineSpread], kind: str) -> dict[str, FormulaSpread]:
    """Least, geometric mean and greatest of each formula's ratios over the engines.

    Parameters
    ----------
    spreads : sequence of EngineSpread
    kind : {"axial", "torsional"}

    Returns
    -------
    dict of str to FormulaSpread
        In the formulas' order. Formulas without a positive ratio are left out, and so are single
        ratios that are not positive.
    """
    names = dict.fromkeys(name for spread in spreads for name in spread.ratios[kind])
    result = {}
    for name in names:
        ratios = [
            ratio.value
            for spread in spreads
            if (ratio := spread.ratios[kind].get(name)) is not None and ratio.value > 0.0
        ]
        if ratios:
            mean = math.exp(sum(math.log(ratio) for ratio in ratios) / len(ratios))
            result[name] = FormulaSpread(min(ratios), mean, max(ratios))
    return result


def spread_record(spread: EngineSpread) -> Record:
    """Return an engine's spread as plain JSON content."""
    return {
        "engine": spread.engine,
        "overlap_per_radius": spread.overlap,
        "fe": dict(spread.fe) | {"error_estimate": spread.error_estimate},
        "beside_fe": {
            kind: {
                name: {"ratio": ratio.value, "valid": ratio.valid} for name, ratio in ratios.items()
            }
            for kind, ratios in spread.ratios.items()
        },
    }
