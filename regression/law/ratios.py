"""The ratios of a throw in the law, their ranges, and the networks' inputs.

Lengths are divided by the main journal's diameter D; the pin's bore by the pin's diameter, the ends and
corners of webs by half of their width, tips and feet by their thickness. A plain throw has obround webs
of one thickness, fillets of one radius and no bores: seven ratios describe it.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.choices import check_kind
from crankbase.errors import InputError
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Web, web_dimension

Array = NDArray[np.float64]
Ratios = Mapping[str, Any]

# Ranges of the lengths over D that every throw has.
PLAIN: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "crank_radius": (0.45, 1.4),
        "pin_diameter": (0.7, 1.0),
        "main_journal_length": (0.35, 0.75),
        "pin_length": (0.4, 0.85),
        "web_width": (1.15, 1.9),
        "web_thickness": (0.18, 0.55),
        "fillet_radius": (0.03, 0.075),
    }
)
REAL: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "crank_radius": (0.45, 2.0),
        "pin_diameter": (0.7, 1.0),
        "main_journal_length": (0.3, 1.0),
        "pin_length": (0.3, 1.0),
        "web_width": (1.15, 2.0),
        "web_thickness": (0.18, 0.6),
    }
)
# What a plain throw has not, with its value there; fillets are those of `PLAIN`.
FEATURES: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "main_journal_bore": (0.0, 0.62, 0.0),
        "pin_bore": (0.0, 0.62, 0.0),
        "main_journal_bore_offset": (-0.12, 0.06, 0.0),
        "pin_bore_offset": (-0.06, 0.12, 0.0),
        "web_pin_end": (0.75, 1.05, 1.0),
        "web_journal_end": (0.9, 1.1, 1.0),
        "rectangle": (0.0, 1.0, 0.0),
        "web_corner": (0.0, 0.7, 0.0),
        "web_tip_thickness": (0.6, 1.0, 1.0),
        "web_foot_thickness": (0.65, 1.0, 1.0),
        "thickness_step": (0.74, 1.35, 1.0),
    }
)
# Distances from plain throws over which their networks' part in an answer falls to nothing. The main
# journal's length has none: it hardly changes e_n, which a passage between networks would outweigh.
FEATURE_FADES = MappingProxyType(
    {
        "rectangle": 1.0,
        "main_journal_bore": 0.1,
        "pin_bore": 0.1,
        "web_pin_end": 0.05,
        "web_journal_end": 0.05,
        "web_tip_thickness": 0.1,
        "web_foot_thickness": 0.1,
        "thickness_step": 0.1,
    }
)
FILLETS = ("main_journal_fillet_radius", "pin_fillet_radius")
LARGEST_FILLET = 0.08
LENGTH_FADES = MappingProxyType({name: 0.1 * (PLAIN[name][1] - PLAIN[name][0]) for name in REAL})
FADES: Mapping[str, float] = MappingProxyType(
    {
        **FEATURE_FADES,
        **dict.fromkeys(FILLETS, 0.01),
        **{name: fade for name, fade in LENGTH_FADES.items() if name != "main_journal_length"},
    }
)
# Walls beside bores are this share of the diameter or more.
THINNEST_WALL = 0.15
# Divisors that are not D, for sentences.
DIVISORS = {
    "pin_bore": "pin_diameter",
    "web_pin_end": "half of web_width",
    "web_journal_end": "half of web_width",
    "web_corner": "half of web_width",
    "web_tip_thickness": "web_thickness",
    "web_foot_thickness": "web_thickness",
}
# A chamfer that cuts as much off a corner as a radius of 1 does.
CHAMFER_OF_RADIUS = float(np.sqrt(2.0 - 0.5 * np.pi))
# A ratio may be beyond its range by round-off, and differs from a plain throw's by more.
ROUND_OFF = 1e-6
# Of a web of its own, what the law knows.
WEB_FIELDS = ("thickness", "tip_thickness", "foot_thickness", "counterweight")
PLAIN_FIELDS = ("main_journal_diameter", *PLAIN)
MORE_FIELDS = (
    *FILLETS,
    "main_journal_bore",
    "pin_bore",
    "main_journal_bore_offset",
    "pin_bore_offset",
    "web_journal_end",
    "web_pin_end",
    "web_corner_radius",
    "web_corner_chamfer",
    "web_tip_thickness",
    "web_foot_thickness",
)


def throw_dimensions(throw: CrankThrow) -> dict[str, Any]:
    """Fields of a throw in the law; webs of unequal thickness as their mean and their step.

    `InputError` if the throw has features outside the law: further pins, oil holes, webs of unequal
    outline.
    """
    check_kind("throw", throw, CrankThrow, "a CrankThrow")
    for name in ("further_pins", "oil_holes"):
        if features := getattr(throw, name):
            raise InputError(
                f"throw.{name}: given {len(features)}; allowed for the law is none, because its training "
                "throws have none."
            )
    dimensions = {name: getattr(throw, name) for name in (*PLAIN_FIELDS, *MORE_FIELDS)}
    dimensions["rectangle"] = float(throw.web_outline == "rectangle")
    dimensions["thickness_step"] = 1.0
    if throw.left_web is None and throw.right_web is None:
        return dimensions
    for table in ("left_web", "right_web"):
        web_table = getattr(throw, table)
        for name in () if web_table is None else Web.model_fields:
            common = getattr(throw, f"web_{name}", None)
            if name not in WEB_FIELDS and getattr(web_table, name) not in (None, common):
                raise InputError(
                    f"throw.{table}.{name}: given {getattr(web_table, name)}; allowed for the law is only "
                    f"{common}, as of both webs, because it covers webs that differ in thickness alone."
                )
    left, right = (
        {
            name: web_dimension(throw, table, name)[1]
            for name in ("thickness", "tip_thickness", "foot_thickness")
        }
        for table in ("left_web", "right_web")
    )
    mean = (left["thickness"] * right["thickness"]) ** 0.5
    dimensions["web_thickness"] = mean
    dimensions["thickness_step"] = right["thickness"] / left["thickness"]
    for name in ("tip_thickness", "foot_thickness"):
        shares = [(web[name] or web["thickness"]) / web["thickness"] for web in (left, right)]
        dimensions[f"web_{name}"] = 0.5 * mean * sum(shares)
    return dimensions


def ratios(dimensions: Mapping[str, Any]) -> dict[str, Any]:
    """All ratios of one or more throws from their dimensions, floats or arrays.

    These are fields of `CrankThrow` [m], with its defaults; also "rectangle", 1 or 0, and
    "thickness_step", the right web's thickness over the left one's.
    """
    lengths = {name: value for name, value in dimensions.items() if value is not None}
    diameter = lengths["main_journal_diameter"]
    shape = {name: lengths[name] / diameter for name in REAL}
    fillet = lengths.get("fillet_radius", 0.0)
    for name in FILLETS:
        shape[name] = lengths.get(name, fillet) / diameter
    for name in ("main_journal_bore", "main_journal_bore_offset", "pin_bore_offset"):
        shape[name] = lengths.get(name, 0.0) / diameter
    shape["pin_bore"] = lengths.get("pin_bore", 0.0) / lengths["pin_diameter"]
    half = 0.5 * lengths["web_width"]
    for name in ("web_pin_end", "web_journal_end"):
        shape[name] = lengths.get(name, half) / half
    corner = CHAMFER_OF_RADIUS * lengths.get("web_corner_radius", 0.0)
    shape["web_corner"] = (corner + lengths.get("web_corner_chamfer", 0.0)) / half
    shape["rectangle"] = lengths.get("rectangle", 0.0)
    thickness = lengths["web_thickness"]
    for name in ("web_tip_thickness", "web_foot_thickness"):
        shape[name] = lengths.get(name, thickness) / thickness
    shape["thickness_step"] = lengths.get("thickness_step", 1.0)
    return shape


def is_plain(shape: Ratios) -> Any:
    """Whether throws of these ratios are plain, within their range: bool or array."""
    journal, pin = (shape[name] for name in FILLETS)
    plain = abs(journal - pin) <= ROUND_OFF
    for name in FEATURE_FADES:
        plain = plain & (abs(shape[name] - FEATURES[name][2]) <= ROUND_OFF)
    for name, (low, high) in PLAIN.items():
        ratio = journal if name == "fillet_radius" else shape[name]
        plain = plain & (ratio >= low * (1.0 - ROUND_OFF)) & (ratio <= high * (1.0 + ROUND_OFF))
    return plain


def nearest_plain(shape: Ratios) -> dict[str, Any]:
    """Ratios of the plain throws within their range that are nearest to others."""
    fillet = _within(0.5 * (shape[FILLETS[0]] + shape[FILLETS[1]]), *PLAIN["fillet_radius"])
    return {
        **{name: usual for name, (*_, usual) in FEATURES.items()},
        **{name: _within(shape[name], *PLAIN[name]) for name in REAL},
        **dict.fromkeys(FILLETS, fillet),
    }


def plain_share(shape: Ratios, plain: Ratios, fades: Mapping[str, float]) -> Any:
    """Share of plain throws' networks in an answer: 1 at a plain throw, falling smoothly to 0 over fades."""
    share = 1.0
    for name, fade in fades.items():
        far = abs(shape[name] - plain[name]) / fade
        if type(far) is float and far >= 1.0:
            return 0.0
        far = far * (far < 1.0) + (far >= 1.0)
        share = share * (1.0 - far * far * (3.0 - 2.0 * far))
    return share


def _within(ratio: Any, low: float, high: float) -> Any:
    return min(max(ratio, low), high) if type(ratio) is float else np.clip(ratio, low, high)


def real_ranges() -> dict[str, tuple[float, float]]:
    """Smallest and largest values of all ratios of the law."""
    fillets = dict.fromkeys(FILLETS, (0.0, LARGEST_FILLET))
    return {**REAL, **fillets, **{name: (low, high) for name, (low, high, _) in FEATURES.items()}}


RANGES: Mapping[str, tuple[float, float]] = MappingProxyType(real_ranges())


def check_range(shape: Ratios) -> None:
    """Refuse ratios outside the law's range: `InputError` with the ratio, its value and its range."""
    for bore, unit in (("main_journal_bore", 1.0), ("pin_bore", shape["pin_diameter"])):
        thinnest = np.min(0.5 * (1.0 - shape[bore]) - abs(shape[f"{bore}_offset"]) / unit)
        if thinnest < THINNEST_WALL - ROUND_OFF:
            raise InputError(
                f"{bore}: leaves a wall of {thinnest:.3g} diameters at its thinnest; allowed for the law is "
                f"{THINNEST_WALL:g} or more, because its training throws have that."
            )
    for name, (low, high) in RANGES.items():
        values = shape[name]
        if type(values) is float and low - ROUND_OFF <= values <= high + ROUND_OFF:
            continue  # one throw is asked for far more often than many
        beyond = (values < low - ROUND_OFF) | (values > high + ROUND_OFF) | (values != values)
        if np.any(beyond):
            worst = float(np.asarray(values)[beyond][0]) if np.ndim(values) else float(values)
            raise InputError(
                f"{ratio_text(name)}: given {worst:.4g}; allowed is {low:g} to {high:g}, the range of the "
                "law's training throws."
            )


def ratio_text(name: str) -> str:
    """Name of a ratio in sentences.

    Examples
    --------
    >>> ratio_text("crank_radius"), ratio_text("thickness_step")
    ('crank_radius / main_journal_diameter', 'right_web.thickness / left_web.thickness')
    """
    if name == "thickness_step":
        return "right_web.thickness / left_web.thickness"
    return f"{name} / {DIVISORS.get(name, 'main_journal_diameter')}"
