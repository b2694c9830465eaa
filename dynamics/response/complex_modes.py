"""Damped modes of a chain or system: frequencies, damping ratios, shapes, and sources of damping."""

import numpy as np

from crankbase.array_checks import (
    Array,
    ComplexArray,
    Integers,
    check_shape,
    check_sizes,
    finite_vector,
)
from crankbase.frames import DataFrame, table
from crankbase.results import result
from dynamics.chains.chain import Chain
from dynamics.chains.chain_modes import elastic_modes
from dynamics.response.forced import ForcedResponse, chain_and_system
from dynamics.response.harmonic import UNBOUNDED_WITHIN, DampedModes, damped_modes
from dynamics.response.linear_system import DampedChain, LinearSystem
from dynamics.response.loads import dashpot_names

# A motion whose eigenvalue has an imaginary part below this share of its size creeps back without
# vibrating: a damping ratio of 0.995 and more.
LEAST_OSCILLATION = 0.1
# Eigenvalues of a rigid body are below this share of the largest one: zero but for round-off.
ROUND_OFF = 1e-7
MODAL_DAMPING, SYSTEM_DAMPING = "modal damping", "damping of the system"


@result("frequencies [Hz]", "damping_ratios", "undamped [Hz]", "locked [Hz]")
class ComplexModes:
    """Free damped vibrations x = Re X exp(s t) of a system, by ascending frequency.

    Parameters
    ----------
    eigenvalues : ndarray of shape (m,), complex
        s, with a positive imaginary part: the damped angular frequency [rad/s].
    numbers : ndarray of shape (m,), int
        Number of the corresponding undamped elastic mode, 1 the lowest; 0 for a vibration that exists only
        with damping.
    shapes : ndarray of shape (n, m), complex
        X of the nodes, the largest displacement 1.
    undamped : ndarray of shape (e,)
        Natural frequencies without any damping, with the ring of a viscous damper free [Hz].
    locked : ndarray of shape (e,) or None
        The same with all dashpots rigid, with the ring locked to its housing [Hz]; None without a
        dashpot, or where the number of modes differs.
    sources : tuple of m dicts of str to float
        Sources of each mode's damping, the largest share first; shares sum to 1.
    terms : DampedModes
        All eigenvalues with their inputs and outputs.
    places : ndarray of shape (s,), int
        Mode of each eigenvalue of the terms, from 0; -1 for overdamped motions.
    """

    eigenvalues: ComplexArray
    numbers: Integers
    shapes: ComplexArray
    undamped: Array
    locked: Array | None
    sources: tuple[dict[str, float], ...]
    system: LinearSystem
    terms: DampedModes
    places: Integers

    @property
    def frequencies(self) -> Array:
        """Damped natural frequencies [Hz], (m,)."""
        return self.eigenvalues.imag / (2.0 * np.pi)

    @property
    def damping_ratios(self) -> Array:
        """Share of critical damping of each mode, -Re s / |s|, (m,)."""
        return np.asarray(np.maximum(-self.eigenvalues.real, 0.0) / np.abs(self.eigenvalues))

    def magnifiers(self, angular_frequencies: Array) -> Array:
        """Return the dynamic magnifier of each mode at frequencies (f,) [rad/s], (f, m).

        That of one mass with the mode's frequency and damping ratio: amplitude over static amplitude.
        """
        squares = np.abs(self.eigenvalues) ** 2
        w = angular_frequencies[:, np.newaxis]
        apart = squares - w**2 - 2j * self.eigenvalues.real * w
        with np.errstate(divide="ignore"):
            return np.asarray(squares / np.abs(apart))

    @property
    def largest_magnifiers(self) -> Array:
        """Dynamic magnifier of each mode at its peak, 1 where it has none, inf where undamped, (m,)."""
        ratios = self.damping_ratios
        with np.errstate(divide="ignore"):
            peaks = 0.5 / (ratios * np.sqrt(1.0 - ratios**2))
        return np.where(ratios < np.sqrt(0.5), peaks, 1.0)

    def contributions(
        self,
        angular_frequencies: Array,
        forces: ComplexArray,
        rows: Array,
        power: int = 1,
        balanced: ComplexArray | None = None,
    ) -> ComplexArray:
        """Return the contribution of each mode to a linear combination of the motion.

        Parameters
        ----------
        angular_frequencies : ndarray of shape (f,)
            [rad/s].
        forces : ndarray of shape (f, q), complex
            On the unknowns of the system.
        rows : ndarray of shape (f, q)
            Linear combination, per motion of the unknowns; rigid motions must not change it.
        power : int, optional
            Of i w - s in the denominator: 1, or 3 for half the second derivative over the
            frequency, with the sign changed.
        balanced : ndarray of shape (f, q), complex, optional
            Part of the forces whose effect without vibration is no part of the combination: each mode's is
            taken off, as of loads that pushing elements (`OrderExcitation.pressing`) do not carry at rest.

        Returns
        -------
        ndarray of shape (f, m + 1), complex
            The last one is that of overdamped motions; the sum is the whole response.

        Raises
        ------
        InputError
            If a value is not finite, or an array has another shape.
        """
        angular_frequencies = finite_vector("angular_frequencies", angular_frequencies)
        terms = self.terms
        eigenvalues, inputs, outputs = _with_undamped(terms)
        shape = (angular_frequencies.size, inputs.shape[1])
        for name, values in (("forces", forces), ("rows", rows)):
            check_shape(name, values, shape)
            check_sizes(name, np.asarray(values, dtype=np.complex128))
        gap = 1j * angular_frequencies[:, np.newaxis] - eigenvalues
        met = np.abs(gap) <= UNBOUNDED_WITHIN * np.abs(eigenvalues)
        moved = rows @ outputs.T
        parts = (forces @ inputs.T) * moved / np.where(met, np.inf, gap**power)
        if balanced is not None:
            still = np.abs(eigenvalues) <= ROUND_OFF * np.max(np.abs(eigenvalues), initial=0.0)
            parts += (balanced @ inputs.T) * moved / np.where(still, np.inf, eigenvalues)
        total = np.zeros((angular_frequencies.size, self.eigenvalues.size + 1), dtype=np.complex128)
        np.add.at(total.T, self.places, parts.T)
        return total

    def to_pandas(self) -> DataFrame:
        """Return a table: number, frequency, damping ratio, frequencies of ring free and locked.

        Units and errors are those of `crankbase.frames.table`.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``; NaN for a mode without an undamped counterpart.
        """
        known = np.where(self.numbers > 0, self.numbers - 1, 0)
        columns = {
            "mode": (self.numbers, "1"),
            "frequency": (self.frequencies, "Hz"),
            "damping_ratio": (self.damping_ratios, "1"),
            "undamped": (np.where(self.numbers > 0, self.undamped[known], np.nan), "Hz"),
            "damped_by": ([next(iter(shares), "") for shares in self.sources], ""),
        }
        if self.locked is not None:
            locked = np.where(self.numbers > 0, self.locked[known], np.nan)
            columns["locked"] = (locked, "Hz")
        return table(columns)


def modes_at(response: ForcedResponse, w: float, speed: float) -> ComplexModes:
    """Return the damped modes with springs that vary as they are at a frequency and speed [rad/s]."""
    system = response.system.at(w, speed)
    return complex_modes(
        system if response.chain is None else DampedChain(response.chain, system, ())
    )


def complex_modes(
    chain_or_system: Chain | LinearSystem | DampedChain | ForcedResponse,
) -> ComplexModes:
    """Find the damped modes of a chain or a system, with all of its damping.

    Parameters
    ----------
    chain_or_system : Chain, LinearSystem, DampedChain or ForcedResponse
        The chain or system that vibrates, or a response of it.

    Returns
    -------
    ComplexModes
        Only vibrations: motions of damping ratio 0.995 and more are left out.

    Notes
    -----
    (s^2 M + s C + K + i H) X = 0, of which the eigenvalues s with a positive imaginary part count,
    as H, the loss factors' part, is valid for positive frequencies. With the energies
    X* M X and so on of a mode, its imaginary part is

        -2 Re s  X* M X = X* C X + X* H X / Im s:

    the contribution of each damper and element to the right side is its share of the mode's damping.

    A mode gets the number of the undamped mode nearest in frequency, taken midway between ring
    free and ring locked, so that the total distance is least.
    """
    from scipy.optimize import linear_sum_assignment  # here: loading it takes a quarter second

    if isinstance(chain_or_system, ForcedResponse):
        chain, system = chain_or_system.chain, chain_or_system.system
    else:
        chain, system = chain_and_system(chain_or_system)
    terms = damped_modes(system)
    eigenvalues, _, outputs = _with_undamped(terms)
    sizes = np.abs(eigenvalues)
    least = np.maximum(LEAST_OSCILLATION * sizes, ROUND_OFF * np.max(sizes, initial=0.0))
    vibrating = np.flatnonzero(eigenvalues.imag > least)
    vibrating = vibrating[np.argsort(eigenvalues[vibrating].imag)]
    upper, motion = eigenvalues[vibrating], outputs[vibrating]
    undamped, locked = system.elastic_frequencies, None
    if chain is not None and chain.dashpots:
        from scipy.linalg import null_space  # here: engine files are read without it

        # With rigid dashpots.
        free = null_space(chain.dashpot_elongations() @ system.expand)
        springs = chain.spring_rows() @ system.expand @ free
        rank = int(np.linalg.matrix_rank(springs))
        frequencies, _ = elastic_modes(springs, free.T @ system.mass @ free, rank)
        if frequencies.size == undamped.size:
            locked = frequencies / (2.0 * np.pi)
    nodes = motion @ system.expand.T
    largest = nodes[np.arange(upper.size), np.argmax(np.abs(nodes), axis=1)]
    middle = undamped if locked is None else np.sqrt(undamped * locked)
    damped = np.abs(upper) / (2.0 * np.pi)
    rows, columns = linear_sum_assignment(np.abs(np.log(damped[:, np.newaxis] / middle)))
    numbers = np.zeros(damped.size, dtype=np.int64)
    numbers[rows] = columns + 1
    # An eigenvalue is of its own mode, or of that of which it is the mirror image.
    places = np.full(eigenvalues.size, -1, dtype=np.int64)
    mirrored = np.flatnonzero(eigenvalues.imag < 0.0)
    apart = np.abs(eigenvalues[vibrating, np.newaxis].imag + eigenvalues[mirrored].imag)
    rows, columns = linear_sum_assignment(apart)
    places[mirrored[columns]] = rows
    places[vibrating] = np.arange(vibrating.size)
    return ComplexModes(
        eigenvalues=upper,
        numbers=numbers,
        shapes=(nodes / largest[:, np.newaxis]).T,
        undamped=undamped,
        locked=locked,
        sources=_sources(chain, system, upper, motion),
        system=system,
        terms=terms,
        places=places,
    )


def _with_undamped(terms: DampedModes) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return eigenvalues, inputs and outputs with those of undamped modes, two each.

    1 / (w_n^2 - w^2) = (1 / (i w - i w_n) - 1 / (i w + i w_n)) / (2 i w_n).
    """
    inputs = terms.alone_shapes.T / (2j * terms.alone[:, np.newaxis])
    return (
        np.concatenate((terms.eigenvalues, 1j * terms.alone, -1j * terms.alone)),
        np.concatenate((terms.inputs, inputs, -inputs)),
        np.concatenate((terms.outputs, terms.alone_shapes.T, terms.alone_shapes.T)),
    )


def _sources(
    chain: Chain | None, system: LinearSystem, eigenvalues: ComplexArray, motion: ComplexArray
) -> tuple[dict[str, float], ...]:
    """Return the shares of damping of each mode (m, q) by source."""
    w = eigenvalues.imag[:, np.newaxis]
    damping, loss = system.damping, system.loss
    names: tuple[str, ...] = ()
    parts = [np.empty((len(motion), 0))]
    if chain is not None:
        nodes, expand = motion @ system.expand.T, system.expand
        damping = damping - expand.T @ chain.damping_matrix() @ expand
        loss = loss - expand.T @ chain.loss_matrix() @ expand
        sizes = np.array([dashpot.damping for dashpot in chain.dashpots])
        elements = chain.damping + chain.stiffness * chain.loss_factor / w
        parts += [
            elements * np.abs(nodes @ chain.elongations().T) ** 2,
            sizes * np.abs(nodes @ chain.dashpot_elongations().T) ** 2,
            chain.ground_damping * np.abs(nodes) ** 2,
        ]
        names = (
            *chain.elements,
            *dashpot_names(chain),
            *(f"{node} to ground" for node in chain.names),
        )
    rest = np.sum((np.conj(motion) * (motion @ damping + motion @ loss / w)).real, axis=1)
    shares = np.column_stack((*parts, rest))
    # What nothing damps has no shares; added damping is a difference, of which round-off goes.
    whole = np.sum(np.abs(shares), axis=1, keepdims=True)
    shares = np.where(shares > 1e-12 * whole, shares, 0.0)
    names = (*names, SYSTEM_DAMPING if chain is None else MODAL_DAMPING)
    sources = []
    for each in shares:
        largest_first = [place for place in np.argsort(-each).tolist() if each[place]]
        sources.append({names[place]: float(each[place] / np.sum(each)) for place in largest_first})
    return tuple(sources)
