"""Power balance of a vibration: excitation, and heat in each element and damper."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import ComplexArray, FloatArray
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.errors import SolveError
from crankbase.library_types import Axes, Dataset
from crankbase.summaries import summarized
from crankbase.tables.frames import grid
from dynamics.plots.coordinates import name_axis, orders_and_speeds
from dynamics.plots.quantities import KILO
from dynamics.plots.speed_curves import draw_named_curves
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import dashpot_names
from dynamics.response.series import with_unbounded

# Sums over a working cycle of some hundred angles and orders; round-off leaves 1e-10 and less.
LARGEST_POWER_ERROR = 1e-6
# Heat below this share of the apparent power is lost in the round-off of that.
NO_HEAT = 1e-10


@summarized("power_in [W]", "dissipated [W]", "error", "orders", "speeds [rad/s]")
@dataclass(frozen=True, eq=False)
class PowerBalance:
    """Mean power over the cycle [W] by order and speed; inf where the vibration is unbounded.

    Orders do not exchange power over a common cycle: the powers of all orders add up.

    Parameters
    ----------
    power_in : ndarray of shape (K, S)
        Power of the exciting forces.
    apparent : ndarray of shape (K, S)
        Half the product of force and speed amplitudes, summed over the nodes: the power if
        each force were in phase with the speed of its node.
    elements : ndarray of shape (K, S, e)
        Heat in each element, by viscous damping and loss factor.
    dashpots : ndarray of shape (K, S, d)
        Heat in each dashpot.
    ground : ndarray of shape (K, S, n)
        Heat in the damper to ground at each node.
    rest : ndarray of shape (K, S)
        Power dissipated by modal damping or a magnifier; for a system that is not a chain, by all damping.
    unbounded : ndarray of shape (K, S), bool
    element_names, dashpot_names, node_names : tuple of str
    orders : ndarray of shape (K,)
        In cycles per crankshaft revolution.
    speeds : ndarray of shape (S,)
        [rad/s].
    """

    power_in: FloatArray
    apparent: FloatArray
    elements: FloatArray
    dashpots: FloatArray
    ground: FloatArray
    rest: FloatArray
    unbounded: NDArray[np.bool_]
    element_names: tuple[str, ...]
    dashpot_names: tuple[str, ...]
    node_names: tuple[str, ...]
    orders: FloatArray
    speeds: FloatArray

    @property
    def dissipated(self) -> FloatArray:
        """All heat together [W], (K, S); it equals the power of excitation."""
        own = self.elements.sum(axis=2) + self.dashpots.sum(axis=2) + self.ground.sum(axis=2)
        return np.asarray(own + self.rest)

    @property
    def error(self) -> float:
        """Largest difference of power in and heat at any speed, all orders together, as a share.

        Without damping, or if the heat is lost in round-off of the apparent power,
        as a share of the apparent power instead.
        """
        bounded = ~np.any(self.unbounded, axis=0)
        heat = self.dissipated[:, bounded].sum(axis=0)
        left = np.abs(self.power_in[:, bounded].sum(axis=0) - heat)
        apparent = self.apparent[:, bounded].sum(axis=0)
        whole = np.where(heat > NO_HEAT * apparent, heat, apparent)
        return float(np.max(left / np.where(whole > 0.0, whole, 1.0), initial=0.0))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the power of excitation and of all kinds of damping over the speed, all orders together.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
            Kinds of damping without power are left out.
        """
        axes = new_axes(axes)
        sinks = {
            "in elements": self.elements.sum(axis=2),
            "in dashpots": self.dashpots.sum(axis=2),
            "to ground": self.ground.sum(axis=2),
            "modal damping": self.rest,
        }
        curves = {"power in": KILO * self.power_in.sum(axis=0)}
        for name, values in sinks.items():
            if np.any(values[~self.unbounded]):
                curves[name] = KILO * values.sum(axis=0)
        draw_named_curves(axes, self.speeds, curves, "mean power [kW]")
        write_title(axes, "Power of vibration, all orders together")
        return axes

    def to_xarray(self) -> Dataset:
        """Return all powers over order, speed and place.

        Returns
        -------
        xarray.Dataset
            Units in the ``attrs["units"]`` of each array and coordinate.

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        plane = ("order", "speed")
        return grid(
            {
                "power_in": (plane, self.power_in, "W", "power of the exciting forces"),
                "apparent": (plane, self.apparent, "W", "power if all were in phase"),
                "elements": ((*plane, "element"), self.elements, "W", "heat in the element"),
                "dashpots": ((*plane, "dashpot"), self.dashpots, "W", "heat in the dashpot"),
                "ground": ((*plane, "node"), self.ground, "W", "heat in the damper to ground"),
                "rest": (plane, self.rest, "W", "modal damping"),
                "unbounded": (plane, self.unbounded, "1", "no steady vibration"),
            },
            {
                **orders_and_speeds(self.orders, self.speeds),
                "element": name_axis(self.element_names, "element"),
                "dashpot": name_axis(self.dashpot_names, "dashpot"),
                "node": name_axis(self.node_names, "node"),
            },
        )


def power_balance(response: ForcedResponse) -> PowerBalance:
    """Find the mean power of excitation and of all damping.

    Notes
    -----
    A force F exp(i w t) on a node that moves with X exp(i w t) does the mean work
    Re(F conj(i w X)) / 2 = w Im(F conj X) / 2 per second; a viscous damper c with the relative
    motion D turns c w^2 |D|^2 / 2 into heat and a loss factor on a stiffness k w k eta |D|^2 / 2.
    """
    w = response.angular_frequencies
    square = 0.5 * w[:, :, np.newaxis] ** 2
    forces, motion = response.excitation.forces, response.motion
    system, chain = response.system, response.chain
    work = 0.5 * w * np.sum((forces * np.conj(motion)).imag, axis=2)
    damping, loss = system.damping, system.loss
    none = np.zeros((*w.shape, 0))
    elements, dashpots, ground = none, none, np.zeros(motion.shape)
    names: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())
    if chain is not None:
        twist = np.abs(motion @ chain.elongations().T) ** 2
        hysteretic = 0.5 * w[:, :, np.newaxis] * chain.stiffness * chain.loss_factor
        elements = (square * chain.damping + hysteretic) * twist
        sizes = np.array([dashpot.damping for dashpot in chain.dashpots])
        dashpots = square * sizes * np.abs(motion @ chain.dashpot_elongations().T) ** 2
        ground = square * chain.ground_damping * np.abs(motion) ** 2
        names = (chain.elements, dashpot_names(chain))
        expand = chain.expansion()
        # Exactly zero where nothing was added: the system was made by the same products.
        damping = damping - expand.T @ chain.damping_matrix() @ expand
        loss = loss - expand.T @ chain.loss_matrix() @ expand
    rest = square[:, :, 0] * _quadratic(damping, response.unknowns)
    rest = rest + 0.5 * w * _quadratic(loss, response.unknowns)

    def endless(values: FloatArray) -> FloatArray:
        return with_unbounded(values, response.unbounded)

    return PowerBalance(
        power_in=endless(work),
        apparent=endless(0.5 * w * np.sum(np.abs(forces) * np.abs(motion), axis=2)),
        elements=endless(elements),
        dashpots=endless(dashpots),
        ground=endless(ground),
        rest=endless(rest),
        unbounded=response.unbounded,
        element_names=names[0],
        dashpot_names=names[1],
        node_names=response.names,
        orders=response.orders,
        speeds=response.speeds,
    )


def checked_power_balance(response: ForcedResponse) -> PowerBalance:
    """Return the result of `power_balance`, checked.

    Raises
    ------
    SolveError
        If power in and heat differ by more than a share of 1e-6.
    """
    found = power_balance(response)
    if not found.error <= LARGEST_POWER_ERROR:
        raise SolveError(
            f"Power into the vibration and heat in its damping differ by a share of {found.error:.1e} "
            f"(allowed {LARGEST_POWER_ERROR:.0e})."
        )
    return found


def _quadratic(matrix: FloatArray, motion: ComplexArray) -> FloatArray:
    """Return x* A x of each motion (K, S, q)."""
    return np.asarray(np.sum((np.conj(motion) * (motion @ matrix)).real, axis=2))
