"""The trained networks of the law: two hidden layers each, evaluated by numpy alone.

Each output of each tier has its own network, for the logarithm of its dimensionless value. Networks
of one shape are kept as one stack, so that all are evaluated in a few products of matrices.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
    first, first_constant : (k, m, d), (k, m) array
    second, second_constant : (k, n, m), (k, n) array
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
            given = scaled[:, start : start + BLOCK]
            hidden = np.tanh(first @ given + first_constant).reshape(count, units, -1)
            hidden = np.tanh(self.second @ hidden + second_constant)
            parts.append((last @ hidden)[:, 0] + self.direct @ given)
        found = parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)
        return np.exp(found + constant), np.exp(middle + slopes @ scaled)

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
