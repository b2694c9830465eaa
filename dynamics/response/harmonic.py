"""Response of a linear system to harmonic forces at many frequencies at once."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, Flags, Integers
from crankbase.errors import SolveError
from dynamics.response.linear_system import LinearSystem

Method = Literal["modal", "direct"]
# A mode whose eigenvalue has a real part below this share of its size has no damping.
UNDAMPED = 1e-12
# An undamped mode answers without bounds within this share of its frequency.
UNBOUNDED_WITHIN = 1e-9
# A force does no work on a mode below this share of the largest possible.
NO_WORK = 1e-12
# If a modal answer leaves a larger residual (of its largest term), all are solved for directly.
RESIDUAL_LIMIT = 1e-11
# No answer may leave more, however it was found, of its largest sum of products of coefficients and motions:
# rounding is to these, also where they cancel as in a stiff spring. Solving directly leaves 1e-17 to 1e-13.
LARGEST_RESIDUAL = 1e-9
# Residuals are looked at for so many answers, evenly spread, and for those next to resonances.
CHECKED = 500
# Frequencies taken at once: what is in hand then stays in the processor's cache.
BATCH = 512


@dataclass(frozen=True, eq=False)
class HarmonicResponse:
    """Motion under harmonic forces; physical values are the real parts of value exp(i w t).

    Parameters
    ----------
    motion : ndarray of shape (m, q), complex
        Amplitudes of the unknowns; zero where the response is unbounded, so that sums
        stay finite: check `unbounded` first.
    unbounded : ndarray of shape (m,), bool
        Where an undamped mode is excited at its own frequency.
    directly : int
        Number of the m solved for directly.
    """

    motion: ComplexArray
    unbounded: Flags
    directly: int


def harmonic_response(
    system: LinearSystem,
    angular_frequencies: Array,
    forces: ComplexArray,
    method: Method = "modal",
    speeds: Array | None = None,
) -> HarmonicResponse:
    """Find the steady motion under harmonic forces, each at its own frequency.

    Parameters
    ----------
    system : LinearSystem
        q unknowns.
    angular_frequencies : ndarray of shape (m,)
        Above zero [rad/s].
    forces : ndarray of shape (m, q), complex
        On the unknowns [N m or N].
    method : {"modal", "direct"}
        By damped modes, with a check of residuals and the other method as fallback; or by solving with
        the complex dynamic stiffness at every frequency, as always where springs vary.
    speeds : ndarray of shape (m,), optional
        Speed of the shaft at each [rad/s], for springs that vary over it; by default at rest.

    Notes
    -----
    (K + i H - w^2 M + i w C) x = f. In the coordinates y of the undamped modes and their
    velocities this is z' = A z + b; with A = V diag(s) V^(-1), z is the sum over the
    damped modes of v_k (V^(-1) b)_k / (i w - s_k). Of rigid motions only the velocities are included,
    since nothing depends on their position: so the double eigenvalue zero, which has only one vector,
    does not occur. Eigenvalues of A with H are valid for the positive frequencies at which they are
    used. Undamped modes are solved for one by one.
    """
    frequencies, modal = angular_frequencies, damped_modes(system)
    singular, unbounded = modal.undamped_resonance(frequencies, forces)
    if speeds is None:
        speeds = np.zeros(frequencies.size)
    if system.varying:  # these are the modes of the constant stiffness
        method, singular, unbounded = "direct", *np.zeros((2, frequencies.size), dtype=bool)
    if np.any(unbounded):
        forces = np.where(unbounded[:, np.newaxis], 0.0, forces)
    motion = np.zeros(forces.shape, dtype=np.complex128)
    # At the frequency of an undamped mode the dynamic stiffness has no inverse.
    rest = ~singular
    if method != "direct" or np.any(singular):
        for start in range(0, frequencies.size, BATCH):
            part = slice(start, start + BATCH)
            motion[part] = modal.response(frequencies[part], forces[part])
    sample = np.linspace(0, frequencies.size - 1, min(frequencies.size, CHECKED)).astype(int)
    sample = np.concatenate((sample, modal.near_resonance(frequencies)))

    def largest_residual(products: bool = False) -> float:
        """Return the largest residual relative to a solution's largest term, or to the products in it."""
        moved, w = motion[sample], frequencies[sample, np.newaxis]
        acting = forces[sample] - system.varying_forces(frequencies[sample], speeds[sample], moved)
        elastic = moved @ (system.stiffness + 1j * system.loss)
        inertial = w**2 * (moved @ system.mass)
        viscous = 1j * w * (moved @ system.damping)
        left = np.abs(elastic - inertial + viscous - acting)
        if products:
            elastic = np.abs(moved) @ np.abs(system.stiffness + 1j * system.loss)
            inertial = w**2 * (np.abs(moved) @ np.abs(system.mass))
        terms = np.maximum(np.maximum(np.abs(elastic), np.abs(inertial)), np.abs(acting))
        largest = np.max(terms, axis=1)
        relative = np.max(left, axis=1) / np.where(largest > 0.0, largest, 1.0)
        return float(np.max(relative, initial=0.0))

    if method != "direct":
        rest &= not largest_residual() <= RESIDUAL_LIMIT
    places = np.flatnonzero(rest)
    for start in range(0, places.size, BATCH):
        some = places[start : start + BATCH]
        stiffness = dynamic_stiffness(system, frequencies[some], speeds[some])
        motion[some] = np.linalg.solve(stiffness, forces[some, :, np.newaxis])[..., 0]
    if places.size and not (residual := largest_residual(products=True)) <= LARGEST_RESIDUAL:
        raise SolveError(
            f"The forced vibration leaves a residual of {residual:.1e} of its largest term (allowed "
            f"{LARGEST_RESIDUAL:.0e})."
        )
    return HarmonicResponse(motion, unbounded, places.size)


def dynamic_stiffness(
    system: LinearSystem, angular_frequencies: Array, speeds: Array
) -> ComplexArray:
    """Return K + i H - w^2 M + i w C at each frequency and speed (m,) [rad/s], shape (m, q, q)."""
    w = angular_frequencies[:, np.newaxis, np.newaxis]
    matrices: ComplexArray = np.asarray(
        system.stiffness + 1j * (system.loss + w * system.damping) - w**2 * system.mass
    )
    for spring in system.varying:
        added = spring.added(angular_frequencies, speeds)[:, np.newaxis, np.newaxis]
        matrices = matrices + added * np.outer(spring.row, spring.row)
    return matrices


@dataclass(frozen=True, eq=False)
class DampedModes:
    """Damped modes of a system in the state space, and undamped ones that damping does not affect."""

    eigenvalues: ComplexArray  # (s,)
    inputs: ComplexArray  # (s, q): force to amplitude of each damped mode
    outputs: ComplexArray  # (s, q): that to motion
    rigid_outputs: ComplexArray  # (s, r): that to the velocity of each rigid motion
    rigid_shapes: Array  # (q, r)
    alone: Array  # frequencies of the undamped modes
    alone_shapes: Array

    @classmethod
    def of(cls, system: LinearSystem) -> "DampedModes":
        """Find all of a system."""
        natural, shapes, rigid = system.natural, system.shapes, system.rigid.shape[1]
        damping = shapes.T @ system.damping @ shapes
        loss = shapes.T @ system.loss @ shapes
        loss[:rigid] = loss[:, :rigid] = 0.0  # no spring, no loss: only round-off is there
        scale = float(natural[-1]) or 1.0
        # By each mode's own frequency: the highest may be a hundred thousand times as high.
        frequencies = np.where(natural > 0.0, natural, 1.0)
        reached = (
            np.maximum(
                _quadratic_forms(system.damping, shapes),
                _quadratic_forms(system.loss, shapes) / frequencies,
            )
            / frequencies
        )
        reached[:rigid] = 1.0
        elastic = rigid + np.flatnonzero(reached[rigid:] > UNDAMPED)
        alone = np.flatnonzero(reached <= UNDAMPED)
        count = elastic.size
        moving = np.concatenate((elastic, np.arange(rigid)))
        square = np.diag(natural[elastic] ** 2) + 1j * loss[np.ix_(elastic, elastic)]
        # Displacements of elastic modes, then velocities of elastic and of rigid ones; velocities are
        # measured in units of the highest frequency, which balances the matrix.
        matrix = np.zeros((count + moving.size,) * 2, dtype=np.complex128)
        matrix[:count, count : 2 * count] = scale * np.eye(count)
        matrix[count : 2 * count, :count] = -square / scale
        matrix[count:, count:] = -damping[np.ix_(moving, moving)]
        eigenvalues, vectors = np.linalg.eig(matrix)
        inverse = np.linalg.inv(vectors)
        return cls(
            eigenvalues=eigenvalues,
            inputs=_complex(inverse[:, count:] @ shapes[:, moving].T / scale),
            outputs=_complex(vectors[:count].T @ shapes[:, elastic].T),
            rigid_outputs=_complex(scale * vectors[2 * count :].T),
            rigid_shapes=shapes[:, :rigid],
            alone=natural[alone],
            alone_shapes=shapes[:, alone],
        )

    def response(self, frequencies: Array, forces: ComplexArray) -> ComplexArray:
        """Return the motions (m, q) under forces that excite no undamped mode at its frequency."""
        s = 1j * frequencies[:, np.newaxis]
        gap = s - self.eigenvalues
        undamped = self._undamped
        # Forces that do no work on an undamped mode leave it at rest even at its own frequency; their
        # round-off is not to be divided by next to nothing.
        at_own = _at(self.eigenvalues[undamped].imag, frequencies[:, np.newaxis])
        gap[:, undamped] = np.where(at_own, np.inf, gap[:, undamped])
        shares = forces @ self.inputs.T
        shares /= gap
        motion = shares @ self.outputs
        if self.rigid_shapes.size:
            motion += ((shares @ self.rigid_outputs) / s) @ self.rigid_shapes.T
        if self.alone.size:
            apart = self.alone**2 - frequencies[:, np.newaxis] ** 2
            apart[_at(self.alone, frequencies[:, np.newaxis])] = np.inf
            motion += ((forces @ self.alone_shapes) / apart) @ self.alone_shapes.T
        return np.asarray(motion)

    @cached_property
    def _undamped(self) -> Integers:
        """Indices of eigenvalues that damping, though it couples modes, does not affect."""
        return np.flatnonzero(
            (np.abs(self.eigenvalues.real) <= UNDAMPED * np.abs(self.eigenvalues))
            & (self.eigenvalues.imag > 0.0)
        )

    def near_resonance(self, frequencies: Array) -> Integers:
        """Return the indices of the frequencies nearest to those of the damped modes."""
        order = np.argsort(frequencies)
        places = np.searchsorted(frequencies[order], np.abs(self.eigenvalues.imag))
        return np.asarray(order[np.clip(places, 0, frequencies.size - 1)])

    def undamped_resonance(self, frequencies: Array, forces: ComplexArray) -> tuple[Flags, Flags]:
        """Return which frequencies are those of an undamped mode, and where it is excited, (m,)."""
        met = np.zeros(frequencies.size, dtype=bool)
        excited = met.copy()
        undamped = self._undamped
        natural = np.concatenate((self.alone, self.eigenvalues[undamped].imag))
        works = np.column_stack((self.alone_shapes, self.inputs[undamped].T))
        for frequency, work in zip(natural.tolist(), works.T, strict=True):
            near = np.flatnonzero(_at(frequency, frequencies))
            met[near] = True
            largest = np.abs(forces[near]) @ np.abs(work)
            excited[near] |= np.abs(forces[near] @ work) > NO_WORK * largest
        return met, excited


@lru_cache(maxsize=8)
def damped_modes(system: LinearSystem) -> DampedModes:
    """Return `DampedModes.of` a system; those of the last systems are cached."""
    return DampedModes.of(system)


def _at(natural: Array | float, frequencies: Array) -> Flags:
    return np.asarray(np.abs(frequencies - natural) <= UNBOUNDED_WITHIN * natural)


def _quadratic_forms(matrix: Array, shapes: Array) -> Array:
    """Return the form x' A x of each shape, zero if it is within the round-off of its terms."""
    sizes = np.abs(np.sum(shapes * (matrix @ shapes), axis=0))
    terms = np.sum(np.abs(shapes) * (np.abs(matrix) @ np.abs(shapes)), axis=0)
    return np.where(sizes > len(matrix) * np.finfo(np.float64).eps * terms, sizes, 0.0)


def _complex(values: ArrayLike) -> ComplexArray:
    return np.asarray(values, dtype=np.complex128)
