"""Exact time steps of a linear system under forces that are polynomials within each step."""

from dataclasses import dataclass
from math import factorial

import numpy as np
from scipy.linalg import expm

from crankbase.checks.arrays import FloatArray
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
