"""Uncertain values: ranges of factors on the values of a chain, and chains scaled by them.

Compliances by finite elements have an error and formulas a spread; inertias, dampings and the
stiffness of a thrust bearing are often estimates. Each such range is a `Spread`: factors on the
values of a group of elements or nodes, which move together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, positive_vector
from crankbase.checks.choices import check_choice
from crankbase.checks.scalars import is_whole_within
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.chains.editing import find_node

Kind = Literal[
    "compliance",
    "stiffness",
    "inertia",
    "distributed inertia",
    "ground stiffness",
    "damping",
    "loss factor",
    "ground damping",
    "dashpot damping",
    "all damping",
]
# Field of the chain that a kind scales, and the power of the factor that it takes.
FIELDS: dict[str, tuple[str, int]] = {
    "compliance": ("stiffness", -1),
    "stiffness": ("stiffness", 1),
    "inertia": ("inertia", 1),
    "distributed inertia": ("distributed_inertia", 1),
    "ground stiffness": ("ground", 1),
    "damping": ("damping", 1),
    "loss factor": ("loss_factor", 1),
    "ground damping": ("ground_damping", 1),
    "dashpot damping": ("dashpots", 1),
}
ALL_DAMPING = "all damping"
DAMPINGS = ("damping", "loss_factor", "ground_damping", "dashpots")


@summarized("name", "kind", "low", "high", "places")
@dataclass(frozen=True)
class Spread:
    """A range of factors on one kind of value, everywhere or at some elements or nodes together.

    Parameters
    ----------
    kind : str
        One of `FIELDS`: compliance, stiffness, damping, loss factor and distributed inertia belong
        to elements, inertia, ground stiffness and ground damping to nodes. Or "all damping", of
        the whole chain.
    low, high : float
        Least and largest factor on the nominal value; 1 is between them.
    places : tuple of int or str, optional
        Elements, nodes or dashpots by number from 0 or by name; all by default.
    name : str
        Its name; the kind by default.

    Raises
    ------
    InputError
        If the kind is unknown or 0 < low <= 1 <= high is not so.
    """

    kind: Kind
    low: float
    high: float
    places: tuple[int | str, ...] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        check_choice("kind", self.kind, (*FIELDS, ALL_DAMPING), "chains have these")
        if self.kind == ALL_DAMPING and self.places is not None:
            raise InputError(
                f"places: given {self.places} for all damping; allowed are none, because it is that "
                "of all nodes and elements."
            )
        ends = positive_vector(
            f"spread of {self.kind}",
            (self.low, self.high),
            "",
            "it is a factor on a positive value",
        )
        if not ends[0] <= 1.0 <= ends[1]:
            raise InputError(
                f"spread of {self.kind}: given factors {ends[0]:g} to {ends[1]:g}; allowed are a low "
                "one up to 1 and a high one from 1, because the nominal value is possible too."
            )
        if not self.name:
            object.__setattr__(self, "name", self.kind)

    @classmethod
    def within(
        cls, kind: Kind, share: float, places: tuple[int | str, ...] | None = None, name: str = ""
    ) -> "Spread":
        """Make a spread of plus or minus a share, such as 0.05 for 5 %.

        Raises
        ------
        InputError
            If the share is negative, or 1 or more.
        """
        return cls(kind, 1.0 - share, 1.0 + share, places, name)


def scaled_chain(chain: Chain, spreads: Sequence[Spread], factors: ArrayLike) -> Chain:
    """Return a chain with its values multiplied by factors.

    Parameters
    ----------
    chain : Chain
    spreads : sequence of p Spread
        They state what each factor acts on; a value with two factors gets both.
    factors : array_like of shape (p,)

    Raises
    ------
    InputError
        If an element or node does not exist, or a factor is not above zero.
    """
    given = positive_vector("factors", factors, "", "it is a factor on a positive value")
    scales = scale_factors(chain, spreads, given[np.newaxis])
    changed = {
        name: getattr(chain, name) * scale[0]
        for name, scale in scales.items()
        if name != "dashpots"
    }
    dashpots = [
        replace(dashpot, damping=dashpot.damping * scale)
        for dashpot, scale in zip(chain.dashpots, scales["dashpots"][0].tolist(), strict=True)
    ]
    return replace(chain, dashpots=tuple(dashpots), **changed)


def scale_factors(
    chain: Chain, spreads: Sequence[Spread], factors: FloatArray
) -> dict[str, FloatArray]:
    """Return for each field of the chain the scale factors of its values, (N, size) each."""
    if factors.shape[1] != len(spreads):
        raise InputError(
            f"factors: given {factors.shape[1]} for {len(spreads)} spreads; allowed is one for each."
        )
    fields = (*dict.fromkeys(field for field, _ in FIELDS.values()),)
    scales = {field: np.ones((len(factors), len(getattr(chain, field)))) for field in fields}
    for spread, column in zip(spreads, factors.T, strict=True):
        if spread.kind == ALL_DAMPING:
            for field in DAMPINGS:
                scales[field] *= column[:, np.newaxis]
            continue
        field, power = FIELDS[spread.kind]
        scales[field][:, spread_indices(chain, spread)] *= column[:, np.newaxis] ** power
    return scales


def spread_indices(chain: Chain, spread: Spread) -> list[int]:
    """Return the indices of the elements, nodes or dashpots that a spread acts on."""
    field, _ = FIELDS[spread.kind]
    count = len(getattr(chain, field))
    if spread.places is None:
        return list(range(count))
    if field in ("inertia", "ground", "ground_damping"):
        return [find_node(chain, place, f"spread of {spread.name}") for place in spread.places]
    names = chain.elements if field != "dashpots" else ()
    numbers = [names.index(p) if isinstance(p, str) and p in names else p for p in spread.places]
    for number in numbers:
        if not is_whole_within(number, 0, count - 1):
            known = f" and {', '.join(names)}" if names else ""
            raise InputError(
                f"spread of {spread.name}: given {number!r}; allowed are the whole numbers 0 to "
                f"{count - 1}{known}, because the chain has no others."
            )
    return [int(number) for number in numbers]
