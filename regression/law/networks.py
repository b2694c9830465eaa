"""The trained networks of the law: two hidden layers each, evaluated by numpy alone.

Each output of each tier has its own network, for the logarithm of its dimensionless value. Networks
of one shape are kept as one stack, so that all are evaluated in a few products of matrices.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.throw import COLLAR_MARGIN
from regression.law.hand_formula import hand_parts
from regression.law.ratios import FILLETS, REAL, Ratios

Array = NDArray[np.float64]

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
            np.minimum(1.0, 5.0 * pin_bore * pin) * _within(0.5 - inner),
            np.minimum(1.0, 5.0 * bore) * _within(outer - radius + 0.5 * pin),
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


def _within(depth: Any) -> Any:
    """A depth, or zero if negative, without a kink."""
    return 0.5 * (depth + np.sqrt(depth * depth + 0.01))


def _between(share: Any) -> Any:
    return np.minimum(np.maximum(share, -0.5), 1.0)


def _rows(values: list[Any]) -> Array:
    """Stack numbers, or arrays of one shape with numbers among them."""
    if any(isinstance(value, np.ndarray) for value in values):
        values = list(np.broadcast_arrays(*values))
    return np.array(values, dtype=float)
