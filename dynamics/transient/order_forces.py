"""Forces by orders on the modes of a system, at any shaft angle and speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.over_speed import OverSpeed
from dynamics.transient.propagator import PLACES, POINTS

# Shaft angles times the highest order that one step may cover [rad], by default and at most. A
# polynomial through the points of a step misses a sine at its ends by 1.5e-6 of the sixth power.
USUAL_REACH, WIDEST_REACH = 0.5, 2.0
# Most turns that a cycle may take for all orders to repeat.
MOST_TURNS = 12
# Speeds count as those of the excitation within this share.
SAME_SPEED = 1e-9
# Steps of each stretch at which the error of the polynomials is looked at.
CHECKED = 64


@dataclass(frozen=True, eq=False)
class OrderForces:
    """Forces on the modes as piecewise polynomials of the speed.

    Parameters
    ----------
    orders : ndarray of shape (K,)
    over_speed : OverSpeed
        Their amplitudes on the modes.
    coefficients : ndarray of shape (pieces, 2 K, powers, q)
        The same for the cosine, then for the sine of each order.
    """

    orders: FloatArray
    over_speed: OverSpeed
    coefficients: FloatArray

    @classmethod
    def of(cls, excitation: OrderExcitation, inputs: FloatArray) -> "OrderForces":
        """Return the forces on modes, inputs (n, q) taking forces on nodes to those on modes.

        Between the speeds of the excitation they are interpolated as by `at_speeds`.

        Raises
        ------
        InputError
            If there is not one force for each node.
        """
        if excitation.forces.shape[2] != len(inputs):
            raise InputError(
                f"excitation: given forces on {excitation.forces.shape[2]} nodes; allowed is one on "
                f"each of {len(inputs)}, because the system has so many."
            )
        over_speed = OverSpeed.of(excitation.speeds, excitation.forces @ inputs)
        powers = over_speed.coefficients.swapaxes(1, 2)
        both = np.concatenate((powers.real, -powers.imag), axis=1)
        return cls(excitation.orders, over_speed, np.ascontiguousarray(both))

    def check_speeds(self, lowest: float, highest: float) -> None:
        """Refuse speeds for which the forces are unknown.

        Raises
        ------
        InputError
        """
        known = self.over_speed.speeds[[0, -1]]
        if lowest < known[0] * (1.0 - SAME_SPEED) or highest > known[1] * (1.0 + SAME_SPEED):
            asked = f"{lowest:g}" if lowest == highest else f"{lowest:g} to {highest:g}"
            allowed = f"{known[0]:g}" if known.size == 1 else f"{known[0]:g} to {known[1]:g}"
            raise InputError(
                f"speed: given {asked} rad/s; allowed is {allowed} rad/s, because the excitation is "
                "known there."
            )

    def at(self, angles: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return the forces (m, q) at shaft angles [rad] and speeds [rad/s], both (m,)."""
        turning = np.outer(angles, self.orders)
        waves = np.concatenate((np.cos(turning), np.sin(turning)), axis=1)
        places = self.over_speed.pieces(speeds)
        forces = np.empty((angles.size, self.coefficients.shape[-1]))
        for piece in np.unique(places).tolist():
            own = np.flatnonzero(places == piece)
            coefficients = self.coefficients[piece]
            terms = waves[own] @ coefficients.reshape(len(coefficients), -1)
            terms = terms.reshape(own.size, *coefficients.shape[1:])
            above = (speeds[own] - self.over_speed.speeds[piece])[:, np.newaxis]
            total = terms[:, 0]
            for power in range(1, terms.shape[1]):
                total = total * above + terms[:, power]
            forces[own] = total
        return forces


def checked_step(step: float, orders: FloatArray, highest_speed: float) -> float:
    """Return a step [s] that resolves the orders.

    Raises
    ------
    InputError
        If it covers more than `WIDEST_REACH` of the highest order.
    """
    fastest = float(orders[-1]) * highest_speed
    if step * fastest > WIDEST_REACH * (1.0 + 1e-9):
        raise InputError(
            f"step: given {step:g} s; allowed is {WIDEST_REACH / fastest:.4g} s or less, because order "
            f"{orders[-1]:g} repeats every {2.0 * np.pi / fastest:.4g} s at {highest_speed:g} rad/s."
        )
    return step


def cycle_turns(orders: FloatArray) -> int:
    """Return the least number of revolutions after which all orders repeat.

    Raises
    ------
    InputError
        If there is none up to `MOST_TURNS`.
    """
    for turns in range(1, MOST_TURNS + 1):
        cycles = orders * turns
        if np.all(np.abs(cycles - np.round(cycles)) <= 1e-9 * np.maximum(cycles, 1.0)):
            return turns
    raise InputError(
        f"orders: given {', '.join(f'{order:g}' for order in orders[:8].tolist())}; allowed are orders "
        f"that all repeat within {MOST_TURNS} turns, because the motion is sought over a cycle."
    )


def sampling_note(natural: FloatArray, step: float) -> str:
    """State which modes the samples at each step are too few to show, or nothing."""
    unseen = int(np.count_nonzero(natural * step > np.pi))
    if not unseen:
        return ""
    return (
        f"Of the {natural.size} natural frequencies the highest {unseen}, above "
        f"{0.5 / step:.4g} Hz, are followed exactly, but the results at each step are too few to show "
        "them."
    )


def midpoint_residual(forces: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the errors of the polynomials of some steps at their midpoints, (k, q), and those steps.

    Parameters
    ----------
    forces : ndarray of shape (m, POINTS, q)
        At the points of m steps.
    """
    chosen = np.unique(np.linspace(0, len(forces) - 1, CHECKED).astype(int))
    powers = 0.5 ** np.arange(POINTS)
    middle = powers @ np.linalg.inv(np.vander(PLACES, POINTS, increasing=True))
    return np.tensordot(forces[chosen], middle, axes=(1, 0)), chosen
