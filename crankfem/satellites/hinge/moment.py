"""The moment of an elastic hinge that keeps the crank's speed constant."""

from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    finite_vector,
    positive_number,
    read_only,
)
from crankbase.choices import so_many, whole_number
from crankbase.diagrams import new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.quantity import format_quantity
from crankbase.results import Internal, Number, Quantity, Result, result
from crankfem.satellites.hinge.crosshead import (
    TURN,
    CrossheadEngine,
    GasForce,
    Kinematics,
    ReducedCrank,
    antiderivative,
    periodic_spline,
    reduced_crank,
    turn_integral,
)
from crankfem.satellites.hinge.spring import Force
from dynamics.cycle import even_angles
from dynamics.plots.curves import FROM_TOP, KILO, draw_over_angle

Degrees = Annotated[float, Quantity("deg")]
Moment = Annotated[float, Quantity("N m")]

SAMPLES = 1440
# Fewer samples do not resolve a rise of pressure by combustion.
FEWEST_SAMPLES = 72


@result("speed [rad/s]", "load", "moment [N m]", "stored_energy [J]", "closing_error")
class HingeMoment(Result):
    """The hinge moment at one operating point of an engine; arrays of shape (m,) over one revolution.

    Made by `hinge_moment`.

    Parameters
    ----------
    speed : float
        Of the crank, held constant [rad/s].
    angles_deg : ndarray
        Even crank angles from the top dead center [deg], without the closing one.
    gas_force : callable
        Force on the piston towards the shaft [N] at any angles, a function of radians.
    gas : ndarray
        That force at the angles [N].
    load : float
        M_r, constant moment of the driven machine [N m]: the mean of the gas moment.
    moment : ndarray
        M_h, on the crank, positive when it drives [N m].
    """

    engine: Internal[CrossheadEngine]
    speed: Internal[float]
    kinematics: Internal[Kinematics]
    angles_deg: Internal[Array]
    gas_force: Internal[GasForce]
    gas: Internal[Array]
    reduced: Internal[ReducedCrank]
    load: Moment
    moment: Internal[Array]

    @property
    def gas_moment(self) -> Array:
        """Moment of the gas force [N m], shape (m,)."""
        return self.gas * self.reduced.travel_rate

    @cached_property
    def stored_energy(self) -> Array:
        """Required stored energy of the hinge since the top, minus the integral of M_h [J], (m,)."""
        return read_only(-antiderivative(self.moment))

    @property
    def largest(self) -> Moment:
        """Of M_h."""
        return float(self.moment.max())

    @property
    def largest_at_deg(self) -> Degrees:
        """Crank angle of the largest M_h."""
        return float(self.angles_deg[np.argmax(self.moment)])

    @property
    def least(self) -> Moment:
        """Of M_h."""
        return float(self.moment.min())

    @property
    def least_at_deg(self) -> Degrees:
        """Crank angle of the least M_h."""
        return float(self.angles_deg[np.argmin(self.moment)])

    @property
    def closing_error(self) -> Number:
        """Integral of M_h over a revolution, relative to that of its absolute value."""
        return turn_integral(self.moment) / max(turn_integral(np.abs(self.moment)), 1e-300)

    @property
    def energy_swing(self) -> Annotated[float, Quantity("J")]:
        """Largest less least stored energy."""
        return float(np.ptp(self.stored_energy))

    @property
    def largest_gas_force(self) -> Force:
        """Over the revolution."""
        return float(self.gas.max())

    @property
    def reduced_inertia(self) -> Annotated[tuple[float, float], Quantity("kg m^2")]:
        """Least and largest over the revolution."""
        return float(self.reduced.inertia.min()), float(self.reduced.inertia.max())

    def at_angles(self, *, angles_deg: ArrayLike) -> tuple[ReducedCrank, Array]:
        """Return the reduced crank, and the moment without the hinge [N m], at angles [deg], (k,)."""
        reduced = reduced_crank(self.engine, self.kinematics, angles_deg=angles_deg)
        gas = self.gas_force(np.radians(angles_deg)) * reduced.travel_rate
        return reduced, gas + reduced.weight_moment - self.load

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the moments of hinge, gas and driven machine over the crank angle."""
        curves = {
            "hinge": KILO * self.moment,
            "gas": KILO * self.gas_moment,
            "driven machine": np.full(self.angles_deg.shape, -KILO * self.load),
        }
        title = f"Moments at {format_quantity(self.speed, 'rad/s', 5)}"
        axes, label = new_axes(axes), "moment [kN m]"
        draw_over_angle(axes, np.radians(self.angles_deg), curves, label, angle_label=FROM_TOP)
        write_title(axes, title)
        return axes

    def to_pandas(self) -> DataFrame:
        """Return a row for each crank angle: gas force, moments, energy, the engine reduced to its crank."""
        return table(
            {
                "crank_angle": (self.angles_deg, "deg"),
                "gas_force": (self.gas, "N"),
                "gas_moment": (self.gas_moment, "N m"),
                "hinge_moment": (self.moment, "N m"),
                "stored_energy": (self.stored_energy, "J"),
                "inertia": (self.reduced.inertia, "kg m^2"),
                "inertia_rate": (self.reduced.inertia_rate, "kg m^2/rad"),
                "travel_rate": (self.reduced.travel_rate, "m/rad"),
                "weight_moment": (self.reduced.weight_moment, "N m"),
            }
        )


def hinge_moment(
    engine: CrossheadEngine,
    gas_force: GasForce | ArrayLike,
    speed: float,
    *,
    kinematics: Kinematics = "exact",
    samples: int = SAMPLES,
) -> HingeMoment:
    """Find the moment of a hinge that keeps the crank speed constant.

    Parameters
    ----------
    gas_force : callable or array_like of shape (k,)
        Force on the piston towards the shaft [N]: a function of an array of crank angles [rad] from
        the top dead center, or values at even angles over one revolution from the top, without the
        closing one.
    speed : float
        Of the crank [rad/s].
    samples : int, optional
        Number of angles over the revolution.

    Raises
    ------
    InputError
        If the speed is not above zero, there are too few samples, or the force is not finite.

    Notes
    -----
    Lagrange's equation of the crank is I phi'' + I' phi'^2 / 2 = F x' + M_w - M_r + M_h, with the
    moment M_w of the weights. For phi'' = 0 at phi' = w (equation (8) of Zotov, Imaeva 2024, doi
    10.24412/0131-4270-2024-1-2-50-55): M_h = w^2/2 I' - F x' - M_w + M_r, where
    M_r = 1/(2 pi) times the integral of F x' over a turn (5). I' and M_w have the mean zero, hence
    M_h has, and the hinge returns over a revolution all energy that it takes.

    Examples
    --------
    >>> from dynamics.engine.rods import ConnectingRod
    >>> rod = ConnectingRod(1.55, 150.0, 0.8, 50.0)
    >>> engine = CrossheadEngine(0.3, 0.5, 80.0, 0.2, 30.0, rod, 150.0, 200.0, 110.0)
    >>> found = hinge_moment(engine, lambda angle: 2e5 * (1.0 + np.sin(angle)), 9.3)
    >>> round(found.load, 6), abs(found.closing_error) < 1e-12
    (50000.0, True)
    """
    positive_number("speed", speed, "rad/s", "the crank turns forward")
    count = whole_number(
        "samples", samples, FEWEST_SAMPLES, "fewer over a turn do not show the rise of the pressure"
    )
    angles = even_angles(TURN, count)
    force = as_function(gas_force)
    gas = finite_vector("gas_force", force(angles))
    if gas.shape != angles.shape:
        raise InputError(
            f"gas_force: given {so_many(gas.size)} for {angles.size} angles; allowed is one for each, "
            "because the force is a function of the angle."
        )
    reduced = reduced_crank(engine, kinematics, angles_deg=np.degrees(angles))
    gas_moment = gas * reduced.travel_rate
    load = float(np.mean(gas_moment))
    moment = 0.5 * speed**2 * reduced.inertia_rate - gas_moment - reduced.weight_moment + load
    return HingeMoment(
        engine=engine,
        speed=float(speed),
        kinematics=kinematics,
        angles_deg=read_only(np.degrees(angles)),
        gas_force=force,
        gas=read_only(gas),
        reduced=reduced,
        load=load,
        moment=read_only(moment),
    )


def as_function(gas_force: GasForce | ArrayLike) -> GasForce:
    """Return a gas force as a function of angles [rad]; samples are interpolated by a periodic spline."""
    if callable(gas_force):
        return gas_force
    forces = finite_vector("gas_force", gas_force)
    if forces.size < FEWEST_SAMPLES:
        raise InputError(
            f"gas_force: given {forces.size} values; allowed are {FEWEST_SAMPLES} or more at even angles "
            "over a turn, because fewer do not show the rise of the pressure."
        )
    return periodic_spline(forces)
