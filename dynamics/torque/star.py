"""Star diagrams: sums of the harmonics of all cylinders, order by order."""

import cmath
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    FloatArray,
    finite_array,
    finite_vector,
    positive_vector,
    read_only,
)
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.summaries import summarized
from dynamics.critical import FULL_SUM_TOLERANCE, engine_orders
from dynamics.cycle import checked_strokes, order_numbers
from dynamics.engine.forces import spread_array
from dynamics.engine.layout import EngineLayout
from dynamics.indices import grouped
from dynamics.plots.harmonics import draw_star, finish_stars

Kind = Literal["major", "minor", "balanced"]
# Two directions are one within this angle [rad].
SAME_DIRECTION = 1e-6


@summarized("order", "kind", "share", "resultant")
@dataclass(frozen=True, eq=False)
class Star:
    """The harmonics of one order of all cylinders as vectors.

    A cylinder that fires at f and whose harmonic is M sin(k (x - f) + a) has the direction k f - a:
    it is the phase at which its harmonic rises through zero, in terms of k x. The sum over the cylinders is
    resultant sin(k x - its direction).

    Parameters
    ----------
    order : float
        k, in cycles per crankshaft revolution.
    directions_deg : ndarray of shape (n,)
        Of the cylinders' vectors [deg], from 0 to below 360.
    weights : ndarray of shape (n,)
        Their lengths; negative where the mode shape reverses a vector.
    """

    order: float
    directions_deg: FloatArray
    weights: FloatArray

    @property
    def vectors(self) -> "np.ndarray[tuple[int], np.dtype[np.complex128]]":
        """The cylinders' vectors (n,)."""
        return np.asarray(self.weights * np.exp(1j * np.radians(self.directions_deg)))

    @property
    def resultant(self) -> float:
        """Length of their sum."""
        return float(abs(self.vectors.sum()))

    @property
    def resultant_direction_deg(self) -> float:
        """Direction of their sum [deg], from 0 to below 360; 0 for a balanced order."""
        if self.kind == "balanced":
            return 0.0
        return math.degrees(_turned(cmath.phase(complex(self.vectors.sum()))))

    @property
    def largest(self) -> float:
        """The resultant if all vectors had one direction."""
        return float(np.sum(np.abs(self.weights)))

    @property
    def share(self) -> float:
        """Resultant as a share of the largest possible, 0 to 1."""
        return self.resultant / self.largest if self.largest > 0.0 else 0.0

    @property
    def kind(self) -> Kind:
        """Return "major" with all vectors in one direction, "balanced" with no resultant, else "minor"."""
        if self.share >= 1.0 - FULL_SUM_TOLERANCE:
            return "major"
        return "balanced" if self.share <= FULL_SUM_TOLERANCE else "minor"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the star: firing at shaft angle zero points up, angles turn clockwise."""
        axes = new_axes(axes, width=3.2, height=3.6)
        draw_star(axes, self, f"order {self.order:g}")
        finish_stars(axes)
        write_title(axes, f"Star of order {self.order:g}")
        return axes

    def to_pandas(self) -> DataFrame:
        """Return one row for each cylinder: direction and length of its vector."""
        return table(
            {
                "cylinder": (np.arange(1, len(self.weights) + 1), "1"),
                "direction": (self.directions_deg, "deg"),
                "weight": (self.weights, "1"),
            }
        )


def star_diagram(
    engine: EngineLayout | None = None,
    orders: ArrayLike | float = 12.0,
    *,
    firing_angles_deg: ArrayLike | None = None,
    strokes: int | None = None,
    amplitudes: ArrayLike | None = None,
    phases_deg: ArrayLike | None = None,
    mode_shape: ArrayLike | None = None,
) -> tuple[Star, ...]:
    """Return the star of each order.

    Parameters
    ----------
    orders : array_like of shape (K,) or number, optional
        Orders, or the highest of all orders of the cycle.
    firing_angles_deg : array_like of shape (n,), optional
        Shaft angle at which each cylinder fires [deg], if no engine is given.
    amplitudes : array_like of shape (n,) or (K, n), optional
        Of the cylinders' harmonics, where they differ; 1 by default.
    phases_deg : array_like of shape (n,) or (K, n), optional
        a of M sin(k (x - f) + a), where they differ [deg].
    mode_shape : array_like of shape (n,), optional
        Displacement of the mode at each cylinder's throw, by which its vector is multiplied.

    Raises
    ------
    InputError
        If an array does not fit, the strokes are not 2 or 4 or not the engine's, or an order is not
        above zero or, if the strokes are known, not one of the cycle's.

    Examples
    --------
    >>> stars = star_diagram(firing_angles_deg=[0.0, 540.0, 180.0, 360.0], orders=4.0)
    >>> [(star.order, star.kind) for star in stars if star.kind != "balanced"]
    [(2.0, 'major'), (4.0, 'major')]
    """
    firing, known = _firing_and_strokes(engine, firing_angles_deg, strokes)
    asked = _requested_orders(orders, known)
    shape = (asked.size, firing.size)
    reason = "each order's vector of each cylinder takes its own"
    lengths, shares, turns = (
        spread_array(field, otherwise if spread is None else spread, shape, reason)
        for field, spread, otherwise in (
            ("amplitudes", amplitudes, 1.0),
            ("mode_shape", mode_shape, 1.0),
            ("phases_deg", phases_deg, 0.0),
        )
    )
    lengths = lengths * shares
    directions = np.outer(asked, firing) - np.radians(turns)
    return tuple(
        Star(
            order,
            read_only(np.degrees([_turned(angle) for angle in row.tolist()])),
            read_only(row_lengths.copy()),
        )
        for order, row, row_lengths in zip(asked.tolist(), directions, lengths, strict=True)
    )


def _firing_and_strokes(
    engine: EngineLayout | None, firing_angles_deg: ArrayLike | None, strokes: int | None
) -> tuple[FloatArray, int | None]:
    """Return the firing angles [rad], and the strokes if known."""
    checked = None if strokes is None else checked_strokes(strokes)
    if engine is None and firing_angles_deg is not None:
        firing = np.radians(finite_vector("firing_angles_deg", firing_angles_deg))
    elif isinstance(engine, EngineLayout) and firing_angles_deg is None:
        if checked not in (None, engine.strokes):
            raise InputError(
                f"strokes: given {checked}; allowed is {engine.strokes} or nothing, because that is the "
                "engine's."
            )
        return np.radians(engine.firing_deg), engine.strokes
    else:
        raise InputError(
            f"engine: given {type(engine).__name__} with firing_angles_deg "
            f"{'left out' if firing_angles_deg is None else 'given'}; allowed is either an EngineLayout or "
            "firing_angles_deg, because each defines where the cylinders fire."
        )
    if firing.size == 0:
        raise InputError(
            "firing_angles_deg: given none; allowed is one for each cylinder, because the star has a "
            "vector of each."
        )
    return firing, checked


def _requested_orders(orders: ArrayLike | float, strokes: int | None) -> FloatArray:
    """Return the requested orders: those given, or all up to a highest one."""
    if np.ndim(orders) == 0:
        highest = float(finite_array("orders", orders))
        return np.asarray(engine_orders(4 if strokes is None else strokes, highest))
    asked = positive_vector("orders", orders, "", "they count cycles per revolution")
    if strokes is not None:
        order_numbers(asked, strokes)
    return asked


def leading_stars(stars: Sequence[Star]) -> tuple[Star, ...]:
    """Return the major orders, or if there is none, as with uneven firing, the largest ones."""
    if not stars:
        raise InputError("stars: given none; allowed are one or more, because one is to lead.")
    majors = tuple(star for star in stars if star.kind == "major")
    strongest = max(star.share for star in stars)
    return majors or tuple(
        star
        for star in stars
        if star.share >= strongest - FULL_SUM_TOLERANCE and strongest > FULL_SUM_TOLERANCE
    )


def same_stars(stars: Iterable[Star]) -> tuple[tuple[Star, ...], ...]:
    """Return the stars in groups of equal shape, mirror images included.

    Two are equal if the lengths are equal and the directions, counted from the first cylinder's,
    are equal or opposite.
    """
    groups = grouped(stars, lambda group, star: _alike(group[0], star))
    return tuple(tuple(group) for group in groups)


def _alike(star: Star, reference: Star) -> bool:
    if star.weights.shape != reference.weights.shape or not np.allclose(
        star.weights, reference.weights, rtol=1e-9, atol=0.0
    ):
        return False
    first, second = (
        np.radians(star.directions_deg - star.directions_deg[0]) for star in (star, reference)
    )
    return _equal_directions(first, second) or _equal_directions(first, -second)


def _equal_directions(first: FloatArray, second: FloatArray) -> bool:
    return bool(np.max(np.abs(np.exp(1j * first) - np.exp(1j * second))) <= SAME_DIRECTION)


def _turned(angle: float) -> float:
    """Return an angle between 0 and 2 pi, with zero for what differs from it by round-off."""
    turn = 2.0 * math.pi
    folded = angle % turn
    return 0.0 if min(folded, turn - folded) < 1e-12 * max(1.0, abs(angle)) else folded
