"""Random throws for the law's training: what is drawn of their ratios, and one throw's FE answers.

Lengths are in units of the main journal's diameter, which is 1 m here; ratios without a size of their own
are those of a throw of any size.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from crankbase.errors import InputError
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.throw import CrankThrow
from regression.law.ratios import FILLETS, LARGEST_FILLET, PLAIN, REAL

Array = NDArray[np.float64]
# Points are drawn a little beyond the law's ranges, so that their ends lie inside.
BEYOND = 0.03  # of the range's logarithm, at each end
DRAWN = 24  # numbers for each throw


@dataclass(frozen=True)
class Sample:
    """One kind of throws and a seed; ``spread``: the share of points drawn denser towards the ends."""

    tier: str
    seed: int
    beyond: float = 0.0
    spread: float = 0.0


SAMPLES = {
    "plain-train": Sample("plain", 23_001, BEYOND, 0.5),
    "plain-held-out": Sample("plain", 23_002),
    "plain-test": Sample("plain", 23_005),
    "wide-train": Sample("wide", 23_007, BEYOND, 0.5),
    "real-train": Sample("real", 23_003, BEYOND, 0.5),
    "real-test": Sample("real", 23_006),
}


def draw(name: str, count: int) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield number and fields of throws of a sample that can be built, until so many points are drawn."""
    sample = SAMPLES[name]
    points = qmc.Sobol(DRAWN, scramble=True, rng=np.random.default_rng(sample.seed)).random(
        1 << math.ceil(math.log2(count))
    )
    for number, point in enumerate(points[:count]):
        fields = FIELDS[sample.tier](sample, point)
        try:
            CrankThrow(**fields)
        except InputError:
            continue
        yield number, fields


def _lengths(
    sample: Sample, point: Array, ranges: dict[str, tuple[float, float]]
) -> dict[str, Any]:
    """Lengths on logarithmic scales; a share of the points denser towards the ends of all."""
    dense = point[-1] < sample.spread
    fields: dict[str, Any] = {"main_journal_diameter": 1.0}
    for share, (name, (low, high)) in zip(point, ranges.items(), strict=False):
        at = 0.5 - 0.5 * math.cos(math.pi * share) if dense else float(share)
        at = -sample.beyond + (1.0 + 2.0 * sample.beyond) * at
        fields[name] = low * (high / low) ** at
    return fields


def plain_fields(sample: Sample, point: Array) -> dict[str, Any]:
    """Fields of a plain filleted throw of obround webs."""
    return _lengths(sample, point, PLAIN)


def _or(share: float, usual: float, chance: float, low: float, high: float) -> float:
    """The usual value with a chance, else one between two."""
    if share < chance:
        return usual
    return low + (high - low) * (share - chance) / (1.0 - chance)


def wide_fields(sample: Sample, point: Array) -> dict[str, Any]:
    """Fields of a throw of obround webs within the ranges of real ones, with fillets of their own."""
    fields = _lengths(sample, point, REAL) | {"fillet_radius": 0.0}
    for share, name in zip(point[len(REAL) :].tolist(), FILLETS, strict=False):
        fields[name] = _or(share, 0.0, 0.1, 0.02, LARGEST_FILLET)
    return fields


def real_fields(sample: Sample, point: Array) -> dict[str, Any]:
    """Fields of a throw as they are: fillets, bores, web ends, outlines, slopes and unequal webs."""
    fields = wide_fields(sample, point)
    rest = iter(point[len(REAL) + 2 :].tolist())
    half = 0.5 * fields["web_width"]
    fields["main_journal_bore"] = _or(next(rest), 0.0, 0.4, 0.1, 0.68)
    fields["pin_bore"] = _or(next(rest), 0.0, 0.4, 0.1, 0.64) * fields["pin_diameter"]
    offsets = _or(next(rest), 0.0, 0.5, -0.16, 0.1), _or(next(rest), 0.0, 0.5, -0.1, 0.16)
    for name, offset in zip(("main_journal_bore", "pin_bore"), offsets, strict=True):
        fields[f"{name}_offset"] = offset if fields[name] > 0.0 else 0.0
    rectangle = next(rest) < 0.35
    fields["web_pin_end"] = half * _or(next(rest), 1.0, 0.35, 0.72, 1.1)
    fields["web_journal_end"] = half * _or(next(rest), 1.0, 0.55, 0.85, 1.12)
    corner, kind = _or(next(rest), 0.0, 0.25, 0.1, 0.9) * half, next(rest)
    if rectangle:
        fields["web_outline"] = "rectangle"
        fields["web_corner_radius" if kind < 0.5 else "web_corner_chamfer"] = corner
    elif max(fields["web_pin_end"], fields["web_journal_end"]) < half:
        fields["web_journal_end"] = half
    thickness = fields["web_thickness"]
    for name, chance in (("web_tip_thickness", 0.4), ("web_foot_thickness", 0.6)):
        share = _or(next(rest), 1.0, chance, 0.55, 1.0)
        if share < 1.0:
            fields[name] = share * thickness
    apart = _or(next(rest), 0.0, 0.7, -0.2, 0.2)
    if apart != 0.0:
        sides = {"left_web": math.exp(-apart), "right_web": math.exp(apart)}
        for web, side in sides.items():
            fields[web] = {"thickness": thickness * side}
            for name in ("tip_thickness", "foot_thickness"):
                if f"web_{name}" in fields:
                    fields[web][name] = fields[f"web_{name}"] * side
    return fields


FIELDS = {"plain": plain_fields, "wide": wide_fields, "real": real_fields}


def answers(fields: dict[str, Any], accuracy: float) -> dict[str, Any]:
    """The corrected superelement of a throw and what is left of errors, as plain numbers.

    Stiffness and compliances are those of E = 1 Pa, D = 1 m and nu = 0.3.
    """
    material = STEEL.changed(poisson_ratio=0.3)
    analysis = analyze_throw(CrankThrow(**fields), material, accuracy)
    bars = {support: analysis.error_bars(support) for support in ("pinned", "guided")}
    whole = {support: analysis.supported(support) for support in ("pinned", "guided")}
    one = analysis.superelement
    return {
        "stiffness": (one.stiffness / material.youngs_modulus).tolist(),
        "pin_loads": one.pin_loads[0].tolist(),
        "pin_flexibility": (one.pin_flexibility * material.youngs_modulus).tolist(),
        "errors": {
            f"{name}_{support}": abs(getattr(bars[support], name) / getattr(whole[support], name))
            for support in whole
            for name in ("axial", "torsional", "influence")
        },
        "volume": analysis.mass / material.density,
        "unknowns": analysis.mesh.unknowns,
        "corrected": analysis.corrected,
    }
