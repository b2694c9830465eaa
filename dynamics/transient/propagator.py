"""Viscous damping in place of loss factors, and exact time steps under polynomial forces."""

from dataclasses import dataclass, replace
from math import factorial
from typing import Literal, TypedDict, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from crankbase.array_checks import FloatArray, positive_number
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.response.forced import chain_and_system
from dynamics.response.linear_system import LinearSystem

# Forces are taken at so many Gauss points of each step; between them they are a polynomial.
POINTS = 6
PLACES = 0.5 + 0.5 * np.polynomial.legendre.leggauss(POINTS)[0]


@dataclass(frozen=True, eq=False)
class StateSpace:
    """The first-order equation of motion in the undamped modes.

    z = (w_r y_r of the elastic modes, their velocities, velocities of the rigid motions, their
    displacements times the lowest elastic frequency), so that z' z / 2 is the energy except for the last.

    Parameters
    ----------
    matrix : ndarray of shape (2 q, 2 q)
        A of z' = A z + forces on velocities.
    velocities : ndarray of shape (q,)
        Indices in z of the velocity of each mode, rigid motions first as in the system.
    displacements : ndarray of shape (q,)
        Indices of its displacement.
    scales : ndarray of shape (q,)
        Factor of displacements in z [1/s].
    inputs : ndarray of shape (n, q)
        Forces on the nodes to forces on the modes, by multiplication from the right.
    rigid : int
        Number of rigid motions; their displacements are last in z.
    """

    matrix: FloatArray
    velocities: FloatArray
    displacements: FloatArray
    scales: FloatArray
    inputs: FloatArray
    rigid: int

    @classmethod
    def of(cls, system: LinearSystem) -> "StateSpace":
        """Return the state space of a system without hysteretic damping."""
        count, rigid = system.natural.size, system.rigid.shape[1]
        elastic = count - rigid
        displacements = np.concatenate(
            (np.arange(2 * elastic + rigid, 2 * count), np.arange(elastic))
        )
        velocities = np.concatenate(
            (np.arange(2 * elastic, 2 * elastic + rigid), np.arange(elastic, 2 * elastic))
        )
        scales = system.natural.copy()
        scales[:rigid] = system.natural[rigid] if elastic else 1.0
        damping = system.shapes.T @ system.damping @ system.shapes
        matrix = np.zeros((2 * count, 2 * count))
        matrix[displacements, velocities] = scales
        matrix[np.ix_(velocities, velocities)] = -damping
        matrix[velocities[rigid:], displacements[rigid:]] = -scales[rigid:]
        return cls(matrix, velocities, displacements, scales, system.expand @ system.shapes, rigid)

    def motion(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion of the nodes (m, n), and of rigid motions (m, rigid), of states (m, 2q)."""
        modal = states[:, self.displacements] / self.scales
        return modal @ self.inputs.T, modal[:, : self.rigid]


@dataclass(frozen=True, eq=False)
class Propagator:
    """One step of given length: z(t + h) = E z(t) + sum over points of W_j p(t + c_j h).

    Parameters
    ----------
    step : float
        h [s].
    transition : ndarray of shape (2 q, 2 q)
        E.
    weights : ndarray of shape (POINTS * q, 2 q)
        W of all points, one below the other, transposed.
    """

    step: float
    transition: FloatArray
    weights: FloatArray

    @classmethod
    def of(cls, space: StateSpace, step: float) -> "Propagator":
        """Return the step of a state space.

        Notes
        -----
        The integral of exp(A (h - s)) B (s/h)^k ds over the step is h k! phi_(k+1)(A h) B. All phi
        come from one exponential: that of A h augmented with B and a chain of unit matrices (C. Van
        Loan, IEEE Trans. Automatic Control 23 (1978) 395-404). The step is not limited by the stiffness of
        the chain, only by the accuracy of the polynomials.
        """
        size, count = len(space.matrix), space.velocities.size
        whole = np.zeros((size + POINTS * count,) * 2)
        whole[:size, :size] = space.matrix * step
        whole[space.velocities, size + np.arange(count)] = step
        chain = np.arange((POINTS - 1) * count)
        whole[size + chain, size + count + chain] = 1.0
        exponential = expm(whole)
        powers = np.vander(PLACES, POINTS, increasing=True)
        # Row j: coefficients by powers of the polynomial that is 1 at point j and 0 at the others.
        basis = np.linalg.inv(powers).T
        weights = np.zeros((POINTS, count, size))
        for power in range(POINTS):
            start = size + power * count
            answer = factorial(power) * exponential[:size, start : start + count].T
            weights += basis[:, power, np.newaxis, np.newaxis] * answer
        return cls(step, exponential[:size, :size], weights.reshape(POINTS * count, size))

    def propagate(self, start: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the states after each of m steps, (m, 2 q).

        Parameters
        ----------
        start : ndarray of shape (2 q,)
        forces : ndarray of shape (m, POINTS, q)
            On the modes, at the points of each step.
        """
        gains = forces.reshape(len(forces), -1) @ self.weights
        state, transition = start, self.transition
        for gain in gains:
            gain += transition @ state
            state = gain
        return np.asarray(gains)


LossAs = Literal["viscous", "modal"]


class ViscousDamping(TypedDict, total=False):
    """Damping arguments of `viscous_system`, which see."""

    loss_as: LossAs
    loss_frequency: float | None
    magnifier: float | None
    modal_damping: ArrayLike | None


@summarized("system.natural", "note")
@dataclass(frozen=True, eq=False)
class ViscousSystem:
    """A linear system that can be integrated over time.

    Parameters
    ----------
    system : LinearSystem
        Without hysteretic damping.
    chain : Chain or None
        Its origin.
    note : str
        How loss factors were replaced; empty if there are none.
    """

    system: LinearSystem
    chain: Chain | None
    note: str


def viscous_system(
    chain_or_system: Chain | LinearSystem,
    *,
    loss_as: LossAs = "viscous",
    loss_frequency: float | None = None,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
) -> ViscousSystem:
    """Return the system with loss factors replaced by viscous damping, and modal damping added.

    Parameters
    ----------
    loss_as : {"viscous", "modal"}
        "viscous": each element of loss factor eta and stiffness k gets a damper of
        eta k / w, exact at one angular frequency w. "modal": each elastic mode gets half of its own
        loss factor as share of critical damping, exact at the frequency of each mode, without the
        coupling of modes by damping.
    loss_frequency : float, optional
        w for "viscous" [rad/s]; the lowest elastic mode's by default.
    magnifier : float, optional
        Adds to each elastic mode the damping of this magnifier, 1 / (2 magnifier) of critical.
    modal_damping : float or array_like, optional
        Adds to each elastic mode this share of critical damping.

    Raises
    ------
    InputError
        If a number is out of range, the way is unknown, both magnifier and modal damping are given,
        or a loss frequency is given that is not used, or springs vary with frequency or speed.

    Notes
    -----
    Under harmonic motion of angular frequency W a loss factor causes the force i eta k x, a damper
    i W c x: with c = eta k / w the energy lost in a cycle is exact at W = w and wrong by W / w
    elsewhere. The mode of natural frequency w_r and shape x_r has the loss factor
    x_r' H x_r / (w_r^2 x_r' M x_r).
    """
    chain, system = chain_and_system(chain_or_system)
    if system.varying:
        raise InputError(
            "chain: given springs that vary with frequency or speed; allowed are constant ones for motion "
            "over time, because one motion has many frequencies: replace(chain, varying=()) keeps the "
            "constant stiffness."
        )
    why = "these are the ways to put viscous damping in the place of loss factors"
    check_choice("loss_as", loss_as, get_args(LossAs), why)
    frequency = None
    if loss_frequency is not None:
        frequency = positive_number(
            "loss_frequency", loss_frequency, "rad/s", "damping is right at one frequency"
        )
        if loss_as == "modal":
            raise InputError(
                f"loss_frequency: given {frequency:g} rad/s; allowed is none with loss_as='modal', "
                "because there each mode takes its own frequency."
            )
    replaced, note = _without_loss(system, loss_as, frequency)
    return ViscousSystem(replaced.with_added_damping(magnifier, modal_damping), chain, note)


def _without_loss(
    system: LinearSystem, loss_as: LossAs, frequency: float | None
) -> tuple[LinearSystem, str]:
    if not np.any(system.loss):
        return system, ""
    count = system.rigid.shape[1]
    plain = replace(system, loss=np.zeros_like(system.loss))
    natural, shapes = system.natural[count:], system.shapes[:, count:]
    if loss_as == "modal":
        losses = np.sum(shapes * (system.loss @ shapes), axis=0) / natural**2
        note = "Loss factors as modal damping, half the loss factor of each mode."
        return plain.with_modal_damping(0.5 * losses), note
    right_at = float(natural[0]) if frequency is None else frequency
    which = ", that of the lowest elastic mode" if frequency is None else ""
    note = (
        f"Loss factors as viscous damping of the elements, equal at {right_at / (2.0 * np.pi):.6g} Hz"
        f"{which}."
    )
    return replace(plain, damping=plain.damping + system.loss / right_at), note
