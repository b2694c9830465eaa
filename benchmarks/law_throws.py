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
from regression.law.throw_law import (
    CHAMFER_OF_RADIUS,
    FEATURES,
    FILLETS,
    LARGEST_FILLET,
    PLAIN,
    REAL,
    THINNEST_WALL,
)

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
    "real-train": Sample("real", 23_008, BEYOND, 0.3),
    "real-pool": Sample("real", 23_010, BEYOND, 0.3),
    "real-held-out": Sample("real", 23_011),
    "real-test": Sample("real", 23_009),
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
    shares = iter(point[len(REAL) + 2 :].tolist())

    def feature(name: str, chance: float, least: float | None = None) -> float:
        """The ratio of a plain throw with a chance, else one from its range and a little beyond."""
        low, high, usual = FEATURES[name]
        low = low if least is None else least
        margin = sample.beyond * (high - low)
        top = high if high == 1.0 else high + margin
        return _or(next(shares), usual, chance, low - (margin if least is None else 0.0), top)

    half, thickness = 0.5 * fields["web_width"], fields["web_thickness"]
    for name, unit in (("main_journal_bore", 1.0), ("pin_bore", fields["pin_diameter"])):
        bore, offset = feature(name, 0.4, 0.1), feature(f"{name}_offset", 0.6)
        if bore > 0.0:
            reach = 0.5 - THINNEST_WALL - 0.5 * bore
            fields[name] = bore * unit
            fields[f"{name}_offset"] = max(-reach * unit, min(reach * unit, offset))
    rectangle = next(shares) < 0.35
    for name, chance in (("web_pin_end", 0.35), ("web_journal_end", 0.55)):
        fields[name] = half * feature(name, chance)
    corner, rounded = half * feature("web_corner", 0.25, 0.08), next(shares) < 0.5
    if rectangle:
        fields["web_outline"] = "rectangle"
        name = "web_corner_radius" if rounded else "web_corner_chamfer"
        fields[name] = corner / (CHAMFER_OF_RADIUS if rounded else 1.0)
    elif max(fields["web_pin_end"], fields["web_journal_end"]) < half:
        fields["web_journal_end"] = half
    for name, chance in (("web_tip_thickness", 0.45), ("web_foot_thickness", 0.65)):
        share = feature(name, chance)
        if share < 1.0:
            fields[name] = share * thickness
    step = feature("thickness_step", 0.75) ** 0.5
    if step != 1.0:
        for web, side in (("left_web", 1.0 / step), ("right_web", step)):
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
