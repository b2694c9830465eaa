"""The gas spring of an elastic hinge: pressure, force, and work over its compression."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_array,
    nonnegative_number,
    positive_number,
)
from crankbase.errors import InputError
from crankbase.results import Number, Quantity, Result
from crankbase.sentences import amount, in_si

Length = Annotated[float, Quantity("m")]
Pressure = Annotated[float, Quantity("Pa")]
Force = Annotated[float, Quantity("N")]

# The gas column counts as gone when this share of its height is left.
LEAST_COLUMN = 0.01
# From isothermal to adiabatic gas of single atoms.
LOWEST_EXPONENT, HIGHEST_EXPONENT = 1.0, 5.0 / 3.0
NEWTON_STEPS = 60


@dataclass(frozen=True)
class GasSpring(Result):
    """A gas spring of two opposed pistons.

    Parameters
    ----------
    piston_area : float
        A [m^2].
    height : float
        H, height of the gas column with both rollers at the initial radius [m].
    pressure : float
        p_0, initial pressure of the gas [Pa]; above `ambient`.
    ambient : float, optional
        Pressure on the outer sides of the pistons [Pa]. The law of Zotov, Imaeva 2024 has none:
        they call p_0 an excess pressure and use it in the polytropic law, which holds for
        absolute pressure. With 0 the spring is theirs, p_0 being the absolute pressure without
        atmospheric pressure on the pistons; with 101325 Pa it is exact for p_0 in excess.

    Raises
    ------
    InputError
        If a value is out of its range.

    Examples
    --------
    >>> spring = GasSpring(piston_area=0.031, height=1.0, pressure=5e6)
    >>> round(float(spring.force(0.0)))
    155000
    >>> work = spring.work(0.2)
    >>> round(float(spring.compression(work)), 12)
    0.2
    """

    piston_area: Annotated[float, Quantity("m^2")]
    height: Length
    pressure: Pressure
    exponent: Number = 1.25
    ambient: Annotated[float, Quantity("Pa", key="ambient_pressure")] = 0.0

    def __post_init__(self) -> None:
        positive_number("piston_area", self.piston_area, "m^2", "the gas presses on it")
        positive_number("height", self.height, "m", "it is a length")
        positive_number("pressure", self.pressure, "Pa", "the spring presses the rollers out")
        nonnegative_number("ambient", self.ambient, "Pa", "it is absolute pressure")
        exponent = float(finite_array("exponent", self.exponent))
        if not LOWEST_EXPONENT <= exponent <= HIGHEST_EXPONENT:
            raise InputError(
                f"exponent: given {exponent:g}; allowed are {LOWEST_EXPONENT:g} to "
                f"{HIGHEST_EXPONENT:.4g}, because gas is between isothermal and adiabatic."
            )

    @property
    def absolute(self) -> float:
        """Absolute pressure at the start [Pa]."""
        return self.pressure + self.ambient

    def gas_pressure(self, compression: ArrayLike) -> Array:
        """Return the pressure above ambient [Pa] when the column is z [m] shorter."""
        share = 1.0 - self._within(compression) / self.height
        return np.asarray(self.absolute * share**-self.exponent - self.ambient)

    def force(self, compression: ArrayLike) -> Array:
        """Return the force on each piston, outwards [N], when the column is z [m] shorter."""
        return self.piston_area * self.gas_pressure(compression)

    def work(self, compression: ArrayLike) -> Array:
        """Return the work that shortens the column by z [m], the integral of the force [J]."""
        shorter = self._within(compression)
        logarithm = -np.log1p(-shorter / self.height)
        less = self.exponent - 1.0
        scale = self.piston_area * self.absolute * self.height
        stretched = np.expm1(less * logarithm) / less if less > 0.0 else logarithm
        return np.asarray(scale * stretched - self.piston_area * self.ambient * shorter)

    def compression(self, work: ArrayLike) -> Array:
        """Return the shortening of the column after a work.

        Parameters
        ----------
        work : array_like
            Work done on the gas since the start [J]; negative for released work.

        Returns
        -------
        ndarray of the same shape
            z [m], negative where the column is longer than at the start.

        Raises
        ------
        InputError
            If the gas cannot release so much, or almost nothing of the column would be left.

        Notes
        -----
        Without ambient pressure (H - z)^(1-n) = H^(1-n) + (n - 1) W / (A p_0 H^n). Otherwise
        Newton's method from above: the work is convex in z while the spring pushes outwards.
        """
        wanted = finite_array("work", work)
        self._check_energy(wanted)
        self._check_column(wanted)
        shortening = self._closed_form(wanted + self.piston_area * self.ambient * self.height)
        if self.ambient > 0.0:
            for _ in range(NEWTON_STEPS):
                shortening = shortening - (self.work(shortening) - wanted) / self.force(shortening)
        return np.asarray(shortening)

    def _within(self, compression: ArrayLike) -> Array:
        """Return compressions that leave part of the column."""
        shorter = finite_array("compression", compression)
        largest = float(np.max(shorter, initial=0.0))
        if largest >= self.height:
            raise InputError(
                f"compression: given {in_si(largest, 'm')} of a gas column {in_si(self.height, 'm')} high; "
                "allowed is less than its height, because the gas takes up room."
            )
        return shorter

    def _closed_form(self, work: Array) -> Array:
        """Return z for the work of the gas alone."""
        less = self.exponent - 1.0
        share = work / (self.piston_area * self.absolute * self.height)
        logarithm = np.log1p(less * share) / less if less > 0.0 else share
        return np.asarray(-self.height * np.expm1(-logarithm))

    def _check_column(self, work: Array) -> None:
        """Refuse works that leave almost nothing of the column."""
        largest = float(np.max(work, initial=0.0))
        most = float(self.work((1.0 - LEAST_COLUMN) * self.height))
        if largest > most:
            raise InputError(
                f"pressure: given {amount(self.pressure, 'Pa')} in a spring {in_si(self.height, 'm')} high "
                f"that must take {amount(largest, 'J', 4, shown='kJ')}; allowed is a pressure at which the "
                f"gas takes more, here at most {amount(most, 'J', 4, shown='kJ')} until "
                f"{in_si(LEAST_COLUMN * self.height, 'm', 3)} of the column are left, because the "
                "compression z must stay below the height H."
            )

    def _check_energy(self, work: Array) -> None:
        """Refuse works below what the gas releases until it no longer pushes outwards."""
        asked = -float(np.min(work, initial=0.0))
        if self.ambient > 0.0:
            slack = self.height * (1.0 - (self.absolute / self.ambient) ** (1.0 / self.exponent))
            released = -float(self.work(slack))
        elif self.exponent > 1.0:
            scale = self.piston_area * self.absolute * self.height
            released = scale / (self.exponent - 1.0)
        else:
            return
        if asked >= released * (1.0 - 1e-9):
            raise InputError(
                f"pressure: given {amount(self.pressure, 'Pa')} in a spring that must give "
                f"{amount(asked, 'J', 4, shown='kJ')}; allowed is a pressure at which the gas gives more, "
                f"here at most {amount(released, 'J', 4, shown='kJ')}, because it does no more work when it "
                "has expanded."
            )
