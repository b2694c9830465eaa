"""The law: axial and torsional compliances of throws from their dimensions alone, with error bands.

Networks trained on finite elements of thousands of throws (docs/law.md) give dimensionless
compliances; E and the size are exact factors, Poisson's ratio near 0.3 has its mean effect. End sections are
rigid discs, as in `fem.analysis.analyze_throw`; counterweights hardly stiffen a throw and are neglected.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags, finite_array
from crankbase.choices import check_kind, number_within
from crankbase.errors import InputError
from crankbase.summaries import frozen
from geometry.throw import COLLAR_MARGIN, CrankThrow
from geometry.throw_dimensions import Web, web_dimension
from regression.formulas.case import FormulaValue, check_youngs_modulus
from regression.models.angle import between_values

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
# What may come near an end of them, that end, their width, and what counts as nothing of it: no end is near
# without a bore, or with the usual shape of a web.
NEARNESS = [
    (name, end, sign / (high - low), usual)
    for name, (low, high) in RANGES.items()
    for *_, usual in [FEATURES.get(name, (math.nan,))]
    for end, sign in ((low, 1.0), (high, -1.0))
    if name != "rectangle" and end != usual and (end or name not in FILLETS)
]


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


def dimension_ranges(throw: CrankThrow) -> dict[str, dict[str, float | str]]:
    """Range of the law in each dimension of a throw, the others kept.

    Parameters
    ----------
    throw : CrankThrow
        Within the law.

    Returns
    -------
    dict of str to dict
        By field that alone sets a ratio, "low" and "high" [m], with "_limit" the ratio that ends it there.
        Walls of bores may end earlier.

    Raises
    ------
    InputError
        As `throw_dimensions`.
    """
    dimensions = throw_dimensions(throw)
    ends: dict[str, dict[str, float | str]] = {}
    for field in (*PLAIN_FIELDS, *MORE_FIELDS):
        # What is not given, or zero, is tried with any length.
        value = dimensions[field] or dimensions["main_journal_diameter"]
        shape = ratios({**dimensions, field: value})
        doubled = ratios({**dimensions, field: 2.0 * value})
        sides: dict[bool, list[tuple[float, str]]] = {False: [], True: []}
        for name, limits in RANGES.items():
            power = round(math.log2(doubled[name] / shape[name]), 6) if shape[name] else 0.0
            if power not in (-1.0, 1.0):  # the ratio has it not, or as a term of a sum
                continue
            for least, limit in zip((True, False), limits, strict=True):
                if limit or power > 0.0:
                    end = value * (limit / shape[name]) ** power
                    text = f"{ratio_text(name)} = {limit:g}"
                    sides[least is (power > 0.0)].append((end, text))
        if sides[True] and sides[False]:
            (low, low_limit), (high, high_limit) = max(sides[True]), min(sides[False])
            ends[field] = {
                "low": low,
                "low_limit": low_limit,
                "high": high,
                "high_limit": high_limit,
            }
    return ends


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


SOURCE = "crankfem: beams fitted to finite-element answers of plain filleted throws (docs/law.md)"


def hand_parts(shape: Ratios) -> tuple[Any, Any, Any]:
    r"""Parts of e E D for ratios of one or more throws: the pin's bending, the webs, and tension.

    By hand: the beams of a throw, and 12 numbers.

    With all lengths in main journal diameters D, overlap s = (1 + D_p) / 2 - R, fillets r::

        e E D = R^2 (L_p + 0.45 h - 1.36 r) 64 / (pi D_p^4)                                      pin, bent
              + 39.3 R e^(-1.74 r) / (h^2.16 B^0.5 D_p^0.45) (1 + e^(1.5 s / (h^0.57 B^0.14)))^-2.4    webs
              + 1.16 (L_m + L_p / D_p^2) 4 / pi                                                   tension

    The pin is a beam, 0.45 h longer for the bending in the webs, and shorter for its fillets. As
    beams two webs would give 8 R^3 / (B h^3): without overlap, s well below 0, the middle term grows less
    steeply with R and h, since webs are short and wide; with overlap, force passes directly from main
    journal to pin, and the term falls exponentially with s over a length between h and D. The last term
    is the tension of journals and pin, 16 % more for the webs between them.
    """
    radius, pin, journal_length, pin_length, width, thickness = (shape[name] for name in REAL)
    fillet = 0.5 * (shape[FILLETS[0]] + shape[FILLETS[1]])
    overlap = 0.5 * (1.0 + pin) - radius
    bent = radius**2 * (pin_length + 0.45 * thickness - 1.36 * fillet) * 64.0 / (np.pi * pin**4)
    webs = 39.3 * radius * np.exp(-1.74 * fillet) / (thickness**2.16 * width**0.5 * pin**0.45)
    webs = webs * (1.0 + np.exp(1.5 * overlap / (thickness**0.57 * width**0.14))) ** -2.4
    return bent, webs, 1.16 * (journal_length + pin_length / pin**2) * 4.0 / np.pi


def hand_value(shape: Ratios) -> Any:
    """Value e E D of the formula for ratios of one or more throws."""
    bent, webs, tension = hand_parts(shape)
    return bent + webs + tension


def hand_formula(throw: CrankThrow, *, youngs_modulus: float = 2.1e11) -> FormulaValue:
    """Axial compliance of a plain throw, ends pinned, by a formula for hand calculation.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].

    Returns
    -------
    FormulaValue
        The value [m/N]; valid for plain throws within the law's range.

    Raises
    ------
    InputError
        If the throw has features outside any single-web formula, or E is not a positive number.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> round(hand_formula(throw).value * 1e9, 2)
    1.27
    """
    check_youngs_modulus(youngs_modulus)
    shape = ratios(throw_dimensions(throw))
    valid = bool(is_plain(shape))
    remarks = () if valid else (
        "The throw is not a plain one within the range that the formula was fitted to (docs/law.md).",
    )  # fmt: skip
    value = float(hand_value(shape)) / (youngs_modulus * throw.main_journal_diameter)
    return FormulaValue(value, valid, remarks, SOURCE, "m/N", "corrected")


# Dimensionless answers, E and D the unit: compliances and influence coefficients times E D, tilts and
# twists per moment times E D^3, per force times E D^2, volumes over D^3.
OUTPUTS = (
    "axial_pinned",
    "axial_guided",
    "tilt_ratio",
    "influence_pinned",
    "influence_guided",
    "torsional_pinned",
    "torsional_guided",
    "tilt_in_plane",
    "tilt_alike",
    "tilt_across",
    "tilt_by_force",
    "volume",
)
TIERS = ("plain", "real")
FILE = Path(__file__).with_name("law.npz")
# So many throws are evaluated at a time: what belongs to them stays in the processor's cache.
BLOCK = 2048


@dataclass(frozen=True)
class Networks:
    """Networks of k outputs of d inputs, with hidden layers of m and n units.

    Attributes
    ----------
    low, high : (d,) array
        Inputs that map to -1 and 1.
    last, direct, constant : (k, n), (k, d), (k,) array
        Contributions of the second layer and of the inputs themselves to the output.
    bands : (k, 1 + d) array
        Logarithm of the relative half width of the 95 % band: in the middle of the range, and its change with
        each input, between -1 and 1.
    poisson : (k, 2) array
        Change of the output's logarithm with Poisson's ratio, and its standard deviation over throws.
    """

    low: Array
    high: Array
    first: Array
    first_constant: Array
    second: Array
    second_constant: Array
    last: Array
    direct: Array
    constant: Array
    bands: Array
    poisson: Array

    def evaluate(self, inputs: Array) -> tuple[Array, Array]:
        """Values (k, n) for inputs (d, n), and relative half widths (k, n) of their 95 % bands."""
        count, units, _ = self.first.shape
        first, first_constant, second_constant, last, constant, middle, slopes = self._columns
        scaled = self.scaled(inputs)
        parts = []
        for start in range(0, inputs.shape[1], BLOCK):
            block = scaled[:, start : start + BLOCK]
            hidden = np.tanh(first @ block + first_constant).reshape(count, units, -1)
            hidden = np.tanh(self.second @ hidden + second_constant)
            parts.append((last @ hidden)[:, 0] + self.direct @ block)
        logs = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.exp(logs + constant), np.exp(middle + slopes @ scaled)

    def scaled(self, inputs: Array) -> Array:
        """Inputs (d, n) between -1 and 1."""
        low, scale = self._scale
        return np.asarray((inputs - low) * scale - 1.0)

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        return self.low[:, None], 2.0 / (self.high - self.low)[:, None]

    @cached_property
    def _columns(self) -> tuple[Array, ...]:
        """Weights prepared for multiplication, once: a throw's evaluation takes less time than this."""
        return (
            self.first.reshape(-1, self.first.shape[2]),
            self.first_constant.reshape(-1, 1),
            self.second_constant[:, :, None],
            self.last[:, None, :],
            self.constant[:, None],
            self.bands[:, :1],
            self.bands[:, 1:],
        )


@cache
def networks(tier: str, names: tuple[str, ...] = OUTPUTS) -> Networks:
    """Read the networks of a tier for some of the `OUTPUTS`."""
    rows = [OUTPUTS.index(name) for name in names]
    with np.load(FILE) as kept:
        arrays = {name: kept[f"{tier}_{name}"] for name in Networks.__annotations__}
    return Networks(**{n: a if n in ("low", "high") else a[rows] for n, a in arrays.items()})


SMALLEST_BORE = 0.1  # of the training throws, over the diameter


def plain_inputs(shape: Ratios) -> Array:
    """Inputs (8, ...) of the networks of plain throws."""
    rows = _rows([*(shape[name] for name in (*REAL, FILLETS[0])), _overlap(shape)])
    rows[:-1] = np.log(rows[:-1])
    return rows


def real_inputs(shape: Ratios) -> Array:
    """Inputs (29, ...) of the networks of real throws."""
    lengths = [shape[name] for name in REAL]
    radius, pin, _, _, width, _ = lengths
    fillet, pin_fillet = (shape[name] for name in FILLETS)
    bore, pin_bore = shape["main_journal_bore"], shape["pin_bore"]
    # The offset of a bore that vanishes means nothing.
    offset = shape["main_journal_bore_offset"] * _opened(bore)
    pin_offset = shape["pin_bore_offset"] * _opened(pin_bore)
    half, rectangle = 0.5 * width, shape["rectangle"]
    foot_end, tip_end = (half * shape[f"web_{end}_end"] for end in ("journal", "pin"))
    corner = half * shape["web_corner"]
    # Half widths at the axes: of the hull of two circles, or of a rectangle less its corners.
    sine = np.minimum(np.maximum((foot_end - tip_end) / radius, -0.95), 0.95)
    cosine = np.sqrt(1.0 - sine * sine)
    at_foot, at_tip = (
        rectangle * (half - np.maximum(corner - end, 0.0))
        + (1.0 - rectangle) * np.minimum(end / cosine, half)
        for end in (foot_end, tip_end)
    )
    tip, foot = 1.0 - shape["web_tip_thickness"], 1.0 - shape["web_foot_thickness"]
    begin = 0.5 + fillet + COLLAR_MARGIN
    far_begin = radius - (0.5 + COLLAR_MARGIN) * pin - pin_fillet
    step = 0.5 * np.log(shape["thickness_step"])
    tip_left = 2.0 * at_tip / width - pin_bore * pin / width
    foot_left = 2.0 * at_foot / width - bore / width
    pin_left = _inertia_left(pin_bore, pin_offset / pin)
    bent, webs, tension = hand_parts(shape)
    bent, webs = bent / pin_left, webs * (tip_left * foot_left) ** -0.25
    # How far each bore's edge lies within the other journal's outline, where force would go straight.
    inner = radius + pin_offset - 0.5 * pin_bore * pin
    outer = offset + 0.5 * bore
    rows = _rows(
        [
            *lengths,
            tip_left,
            foot_left,
            pin_left,
            _inertia_left(bore, offset),
            bent + webs + tension,
            bent / webs,
            _overlap(shape),
            fillet,
            pin_fillet,
            offset * bore,
            pin_offset * pin_bore,
            tip_end - 0.5 * pin - pin_fillet,
            foot_end - 0.5 - fillet,
            rectangle,
            tip * _between((radius - begin) / (radius + tip_end - begin)),
            tip,
            foot * _between(far_begin / (far_begin + foot_end)),
            foot,
            step * step,
            corner * rectangle,
            inner - outer,
            np.minimum(1.0, 5.0 * pin_bore * pin) * _passes(0.5 - inner),
            np.minimum(1.0, 5.0 * bore) * _passes(outer - radius + 0.5 * pin),
        ]
    )
    rows[:12] = np.log(rows[:12])
    return rows


def _overlap(shape: Ratios) -> Any:
    """Overlap of main journal and pin over the web's thickness, its large values compressed."""
    overlap = 0.5 * (1.0 + shape["pin_diameter"]) - shape["crank_radius"]
    return np.arcsinh(overlap / shape["web_thickness"])


def _opened(bore: Any) -> Any:
    """1 for the bores that the networks know, falling smoothly to 0 with smaller ones."""
    share = np.minimum(bore / SMALLEST_BORE, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _inertia_left(bore: Any, offset: Any) -> Any:
    """Moment of inertia of a bored journal about its own center, relative; lengths over its diameter."""
    moved = bore * offset
    square = bore * bore
    return 1.0 - square * square - 16.0 * moved * moved / (1.0 - square)


def _passes(depth: Any) -> Any:
    """A depth, or zero if negative, without a kink."""
    return 0.5 * (depth + np.sqrt(depth * depth + 0.01))


def _between(share: Any) -> Any:
    return np.minimum(np.maximum(share, -0.5), 1.0)


def _rows(values: list[Any]) -> Array:
    """Stack numbers, or arrays of one shape with numbers among them."""
    if any(isinstance(value, np.ndarray) for value in values):
        values = list(np.broadcast_arrays(*values))
    return np.array(values, dtype=float)


POISSON_RATIO = 0.3
POISSON_RANGE = (0.25, 0.35)
INPUTS = {"plain": plain_inputs, "real": real_inputs}


@frozen("pinned [m/N]", "guided [m/N]", "ratio", "influence_pinned [m/N]", "band [m/N]", "tier")
class AxialLaw:
    """Axial compliance and influence coefficient by the law: floats for a throw, arrays for many.

    Attributes
    ----------
    pinned, guided : float or ndarray
        e_n, ends pinned and guided [m/N]; between equal neighbors at 180 and at 0 deg.
    ratio : float or ndarray
        rho of the angle law, stiffness against tilting across the crank plane divided by that in it.
    influence_pinned, influence_guided : float or ndarray
        c of P = c Z / e_n [m/N].
    errors : mapping
        Relative half widths of bands that hold the true value in 95 of 100 throws, by the names above.
    tier : str or ndarray
        "plain" or "real": whether the throw is a plain one; between them values pass over continuously.
    nearest_limit : str
        For one throw: the ratio nearest to an end of the law's range, in words.
    """

    pinned: Any
    guided: Any
    ratio: Any
    influence_pinned: Any
    influence_guided: Any
    errors: Mapping[str, Any]
    tier: Any
    nearest_limit: str = ""

    @property
    def band(self) -> tuple[Any, Any]:
        """Ends of the band of `pinned` that holds the true value in 95 of 100 throws [m/N]."""
        return _band(self.pinned, self.errors["pinned"])

    def axial(self, gamma_deg: ArrayLike) -> Any:
        """Axial compliance between equal neighbors at an angle, e(gamma) [m/N].

        Parameters
        ----------
        gamma_deg : float or array_like
            Angle between neighboring cranks [deg].

        Raises
        ------
        InputError
            If an angle is not a finite number, or the shapes do not fit each other.
        """
        return between_values(gamma_deg, (self.guided, self.pinned, self.ratio))

    def influence(self, gamma_deg: ArrayLike) -> Any:
        """Influence coefficient between equal neighbors, c(gamma) [m/N]; as `axial`."""
        return between_values(gamma_deg, (self.influence_guided, self.influence_pinned, self.ratio))


@frozen("pinned [rad/(N m)]", "guided [rad/(N m)]", "band [rad/(N m)]", "tier")
class TorsionalLaw:
    """Torsional compliance by the law: floats for a throw, arrays for many.

    Attributes
    ----------
    pinned, guided : float or ndarray
        Twist per torque [rad/(N m)].
    errors, tier, nearest_limit
        As of an `AxialLaw`.
    """

    pinned: Any
    guided: Any
    errors: Mapping[str, Any]
    tier: Any
    nearest_limit: str = ""

    @property
    def band(self) -> tuple[Any, Any]:
        """Ends of the band of `pinned` that holds the true value in 95 of 100 throws."""
        return _band(self.pinned, self.errors["pinned"])


# Names of results, with their networks and powers of D beside E.
AXIAL = {
    "pinned": ("axial_pinned", 1),
    "guided": ("axial_guided", 1),
    "ratio": ("tilt_ratio", 0),
    "influence_pinned": ("influence_pinned", 1),
    "influence_guided": ("influence_guided", 1),
}
TORSIONAL = {"pinned": ("torsional_pinned", 3), "guided": ("torsional_guided", 3)}


def axial_law(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> AxialLaw:
    """Axial compliance and influence coefficient of a throw by the law.

    Parameters
    ----------
    youngs_modulus : float
        E [Pa].
    poisson_ratio : float
        0.25 to 0.35; the networks are trained at 0.3 and corrected by the mean effect.

    Raises
    ------
    InputError
        If a ratio of the throw is outside the range of the law's training throws, or the
        throw has features that they lack.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> print(f"{axial_law(throw).pinned:.2e} m/N")
    1.28e-09 m/N
    """
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    return AxialLaw(**answers.results(AXIAL)[0])


def torsional_law(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> TorsionalLaw:
    """Torsional compliance of a throw by the law; parameters and errors as `axial_law`."""
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    return TorsionalLaw(**answers.results(TORSIONAL)[0])


def throw_laws(
    throw: CrankThrow, *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO
) -> tuple[AxialLaw, TorsionalLaw]:
    """Both laws of a throw in the time of one; parameters and errors as `axial_law`."""
    answers = LawAnswers.of_throw(throw, youngs_modulus, poisson_ratio)
    axial, torsional = answers.results(AXIAL, TORSIONAL)
    return AxialLaw(**axial), TorsionalLaw(**torsional)


def axial_law_slopes(throw: CrankThrow, poisson_ratio: float = POISSON_RATIO) -> dict[str, float]:
    """Change of the pinned axial compliance in per cent for one per cent of each dimension, by the law.

    Differences over +-1 %, of one side at an end of the law's range. What is zero or no length of the law's
    has none. Errors as of `axial_law`.
    """

    def pinned(name: str, share: float) -> float | None:
        try:
            changed = throw.changed(**{name: getattr(throw, name) * share})
            return float(axial_law(changed, poisson_ratio=poisson_ratio).pinned)
        except InputError:
            return None

    here, slopes = axial_law(throw, poisson_ratio=poisson_ratio).pinned, {}
    for name in (*PLAIN_FIELDS, *MORE_FIELDS):
        shares = (1.01, 0.99) if getattr(throw, name, None) else ()
        ends = [(value, share) for share in shares if (value := pinned(name, share))]
        if ends:
            (high, more), (low, less) = ends[0], ends[1] if len(ends) > 1 else (here, 1.0)
            slopes[name] = math.log(high / low) / math.log(more / less)
    return slopes


def axial_laws(
    *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO, **dimensions: ArrayLike
) -> AxialLaw:
    """Axial compliance and influence coefficient of many throws by the law.

    Parameters
    ----------
    youngs_modulus, poisson_ratio
        As for `axial_law`.
    **dimensions : array_like
        Fields of `CrankThrow` [m] that can be broadcast together: the first eight, and of the others
        fillets, bores with their offsets, and the webs' ends, corners, tips and feet. Whether such
        throws can be built is not checked.

    Raises
    ------
    InputError
        If a dimension is missing, unknown or not an array of finite numbers, or a ratio is outside.

    Examples
    --------
    >>> law = axial_laws(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300,
    ...     web_thickness=[0.050, 0.068, 0.090], fillet_radius=0.012,
    ... )
    >>> law.pinned.shape
    (3,)
    """
    answers = LawAnswers(_given(dimensions), youngs_modulus, poisson_ratio)
    return AxialLaw(**answers.results(AXIAL)[0])


def torsional_laws(
    *, youngs_modulus: float = 2.1e11, poisson_ratio: float = POISSON_RATIO, **dimensions: ArrayLike
) -> TorsionalLaw:
    """Torsional compliance of many throws by the law; parameters and errors as `axial_laws`."""
    answers = LawAnswers(_given(dimensions), youngs_modulus, poisson_ratio)
    return TorsionalLaw(**answers.results(TORSIONAL)[0])


class LawAnswers:
    """Outputs for throws of some dimensions, each by the networks of its tier."""

    def __init__(
        self, dimensions: Mapping[str, Any], youngs_modulus: float, poisson_ratio: float
    ) -> None:
        check_material(youngs_modulus, poisson_ratio)
        self.ratios = ratios(dimensions)
        self.plain = is_plain(self.ratios)
        if self.plain is not True:  # a plain throw is within the range
            check_range(self.ratios)
        self.modulus, self.beside = youngs_modulus, poisson_ratio - POISSON_RATIO
        self.diameter = dimensions["main_journal_diameter"]
        shapes = {value.shape for value in self.ratios.values() if isinstance(value, np.ndarray)}
        self.shape = np.broadcast_shapes(*shapes) if shapes else ()

    @classmethod
    def of_throw(
        cls, throw: CrankThrow, youngs_modulus: float, poisson_ratio: float
    ) -> "LawAnswers":
        """Outputs for one throw; errors as of `axial_law`."""
        return cls(throw_dimensions(throw), youngs_modulus, poisson_ratio)

    @property
    def tier(self) -> Any:
        """Whether throws are "plain" or "real", an array of these for many."""
        return np.where(self.plain, *TIERS) if self.shape else TIERS[not self.plain]

    def values(self, names: tuple[str, ...]) -> tuple[Array, Array]:
        """Dimensionless outputs (k, ...) by the names of `OUTPUTS`, and relative half widths."""
        shape = self.shape or (1,)
        if not self.shape:
            answers, widths = (_of_plain if self.plain else _of_real)(names, self.ratios, shape)
        else:
            plain = np.broadcast_to(self.plain, shape).ravel()
            answers, widths = np.empty((2, len(names), plain.size))
            for answer, where in ((_of_plain, plain), (_of_real, ~plain)):
                if where.all():
                    answers, widths = answer(names, self.ratios, shape)
                elif where.any():
                    some = _picked(self.ratios, shape, where)
                    answers[:, where], widths[:, where] = answer(names, some, (where.sum(),))
        if self.beside:
            mean, spread = networks("real", names).poisson.T[:, :, None]
            answers = answers * np.exp(mean * self.beside)
            widths = widths + 2.0 * spread * abs(self.beside)
        return answers.reshape(-1, *shape), widths.reshape(-1, *shape)

    def results(self, *kinds: Mapping[str, tuple[str, int]]) -> list[dict[str, Any]]:
        """Fields of each law: values in SI units, errors, tier and the nearest limit."""
        values, widths = self.values(tuple([name for kind in kinds for name, _ in kind.values()]))
        every, errors = (
            iter(rows if self.shape else rows[:, 0].tolist()) for rows in (values, widths)
        )
        nearest = ""
        if not self.shape:
            # The ratio nearest to an end of its range relative to its width.
            _, name = min(
                ((self.ratios[name] - end) * scale, name)
                for name, end, scale, usual in NEARNESS
                if self.ratios[name] != usual
            )
            low, high = RANGES[name]
            nearest = f"{ratio_text(name)} = {self.ratios[name]:.3g} of {low:g} to {high:g}"
        results = []
        for kind in kinds:
            fields: dict[str, Any] = {}
            for name, (_, power) in kind.items():
                scale = self.modulus * self.diameter**power if power else 1.0
                fields[name] = next(every) / scale
            fields |= {"errors": {name: next(errors) for name in kind}}
            fields |= {"tier": self.tier, "nearest_limit": nearest}
            results.append(fields)
        return results


def _of_plain(
    names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Outputs (k, n) for ratios of n throws of a shape, and half widths, by the networks of plain throws."""
    return _of_tier("plain", names, of_throw, shape)


def _of_real(
    names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """The same by the networks of real throws, corrected by what these miss of plain ones nearby."""
    answers, widths = _of_tier("real", names, of_throw, shape)
    plain = nearest_plain(of_throw)
    share = plain_share(of_throw, plain, FADES)
    if type(share) is float and share == 0.0:
        return answers, widths
    close: Any = slice(None)
    if type(share) is not float:
        close = np.broadcast_to(share, shape).ravel() > 0.0
        if not close.any():
            return answers, widths
        of_throw, plain = (_picked(some, shape, close) for some in (of_throw, plain))
        share, shape = plain_share(of_throw, plain, FADES), (close.sum(),)
    known, least = _of_tier("plain", names, plain, shape)
    answers[:, close] *= (known / _of_tier("real", names, plain, shape)[0]) ** share
    share = share * plain_share(of_throw, plain, LENGTH_FADES)
    widths[:, close] = share * least + (1.0 - share) * widths[:, close]
    return answers, widths


def _of_tier(
    tier: str, names: tuple[str, ...], of_throw: Ratios, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    some, count = networks(tier, names), math.prod(shape)
    inputs = INPUTS[tier](of_throw).reshape(len(some.low), -1)
    if inputs.shape[1] != count:
        inputs = np.repeat(inputs, count, axis=1)
    return some.evaluate(inputs)


def _picked(of_throw: Ratios, shape: tuple[int, ...], where: Flags) -> dict[str, Any]:
    """Ratios of some throws of a shape, flat."""
    return {name: np.broadcast_to(value, shape).ravel()[where] for name, value in of_throw.items()}


def check_material(youngs_modulus: float, poisson_ratio: float) -> None:
    """Refuse an invalid Young's modulus, and a Poisson's ratio outside the law (`InputError`)."""
    check_youngs_modulus(youngs_modulus)
    reason = "the training throws of the law have 0.3"
    number_within("poisson_ratio", poisson_ratio, *POISSON_RANGE, "", reason)


def _given(dimensions: Mapping[str, ArrayLike]) -> dict[str, Any]:
    """Dimensions of many throws, checked."""
    known = (*PLAIN_FIELDS, *MORE_FIELDS)
    for name in dimensions:
        if name not in known:
            raise InputError(f"{name}: not a dimension of the law; allowed are {', '.join(known)}.")
    for name in PLAIN_FIELDS:
        if name not in dimensions and name != "fillet_radius":
            raise InputError(f"{name}: missing; it must be given, because the law needs its ratio.")
    checked: dict[str, Any] = {
        name: finite_array(name, value) for name, value in dimensions.items() if value is not None
    }
    for name in PLAIN_FIELDS:
        if name in checked and not np.all(checked[name] > 0.0):
            raise InputError(
                f"{name}: given {float(np.min(checked[name])):g}; allowed is a positive length in m."
            )
    for name, value in checked.items():
        if value.size == 0:
            raise InputError(
                f"{name}: given no values; allowed is one for each throw, or one for all."
            )
    try:
        np.broadcast_shapes(*(value.shape for value in checked.values()))
    except ValueError:
        shapes = ", ".join(
            f"{name} {value.shape}" for name, value in checked.items() if value.shape
        )
        raise InputError(
            f"dimensions: given arrays of the shapes {shapes}; allowed are shapes that can be broadcast "
            "together."
        ) from None
    return checked


def _band(value: Any, error: Any) -> tuple[Any, Any]:
    return value * (1.0 - error), value * (1.0 + error)


@frozen("mass [kg]", "band [kg]", "tier")
class MassLaw:
    """Mass of a throw by the law.

    Attributes
    ----------
    mass : float
        [kg]
    error : float
        Relative half width of the band that holds the true value in 95 of 100 throws.
    tier : str
        "plain" or "real": whether the throw is a plain one.
    """

    mass: float
    error: float
    tier: str

    @property
    def band(self) -> tuple[float, float]:
        """Ends of the band that holds the true value in 95 of 100 throws [kg]."""
        return self.mass * (1.0 - self.error), self.mass * (1.0 + self.error)


def mass_law(throw: CrankThrow, *, density: float = 7850.0) -> MassLaw:
    """Mass of a throw by the law, between the middles of its main journals.

    Parameters
    ----------
    throw : CrankThrow
        Without counterweights.
    density : float
        [kg/m^3]

    Raises
    ------
    InputError
        As `axial_law`; and for counterweights, or a density that is not a positive number.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> print(f"{mass_law(throw).mass:.1f} kg")
    194.1 kg
    """
    from geometry.mass import check_density  # loads the mesher's modules

    check_kind("throw", throw, CrankThrow, "a CrankThrow")
    check_density(density)
    webs = {"left_web.": throw.left_web, "right_web.": throw.right_web}
    for name, holder in {"": throw, **webs}.items():
        if holder is not None and holder.counterweight is not None:
            raise InputError(
                f"throw.{name}counterweight: given one; allowed for the law's mass is none, because it gives "
                "the mass of throws without counterweights alone: use analyze_throw for others."
            )
    answers = LawAnswers.of_throw(throw, 1.0, POISSON_RATIO)
    values, widths = answers.values(("volume",))
    volume = float(values[0, 0]) * throw.main_journal_diameter**3
    return MassLaw(density * volume, float(widths[0, 0]), answers.tier)
