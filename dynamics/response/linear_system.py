"""A linear vibrating system by its matrices, of any origin."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh, qr

from crankbase.checks.arrays import FloatArray, one_for_each, positive_number
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.chain import Chain
from dynamics.chains.chain_modes import elastic_modes

# Magnifier (amplitude at resonance over the static one) of engine and shaft without a damper, as
# measured on a 12-liter six-cylinder engine: Nippon Foundation, report 1997/01151.
DEFAULT_MAGNIFIER = 40.0
MAGNIFIER_SOURCE = (
    "magnifier of about 40 for an engine without a damper, measured on a 12-liter six-cylinder "
    "engine (Nippon Foundation, report 1997/01151)"
)


@summarized("natural [rad/s]", "rigid")
@dataclass(frozen=True, eq=False)
class LinearSystem:
    """M x'' + C x' + K x = f, with K + i H in place of K for harmonic motion.

    Parameters
    ----------
    mass, stiffness, damping, loss : ndarray of shape (q, q)
        M, K, C (viscous) and H (hysteretic: the imaginary part of the stiffness), symmetric.
    rigid : ndarray of shape (q, r)
        Motions that no stiffness resists, as columns.
    expand : ndarray of shape (n, q)
        Motions of the n nodes (or points) of interest, per unknown; forces on them act on
        the unknowns by its transpose.
    natural : ndarray of shape (q,)
        Undamped angular frequencies [rad/s], ascending; exactly zero for rigid-body motions.
    shapes : ndarray of shape (q, q)
        The undamped modes, as columns, of unit modal mass.
    """

    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    loss: FloatArray
    rigid: FloatArray
    expand: FloatArray
    natural: FloatArray
    shapes: FloatArray

    @property
    def elastic_frequencies(self) -> FloatArray:
        """Natural frequencies of the elastic modes, without damping [Hz], (q - r,), ascending."""
        return self.natural[self.rigid.shape[1] :] / (2.0 * np.pi)

    def damping_ratios(self) -> FloatArray:
        """Return the share of critical damping of each elastic mode, (q - r,), all kinds together.

        Notes
        -----
        With the undamped modes x of unit modal mass, (x' C x + x' H x / w) / (2 w): from the
        loss of each mode over one period at its own frequency. Coupling of modes by damping is neglected, so
        this is an estimate where damping is large or concentrated.
        """
        count = self.rigid.shape[1]
        natural, shapes = self.natural[count:], self.shapes[:, count:]
        viscous = np.sum(shapes * (self.damping @ shapes), axis=0)
        hysteretic = np.sum(shapes * (self.loss @ shapes), axis=0)
        ratios = 0.5 * (viscous + hysteretic / natural) / natural
        return np.asarray(np.maximum(ratios, 0.0))  # round-off of what is not damped

    def with_added_damping(
        self, magnifier: float | None, modal_damping: ArrayLike | None
    ) -> "LinearSystem":
        """Return the system with a magnifier, modal damping or none added to its elastic modes.

        Raises
        ------
        InputError
            If both are given, or one is out of range.
        """
        if magnifier is not None and modal_damping is not None:
            raise InputError(
                f"magnifier: given {magnifier!r} together with modal_damping; allowed is one of both, "
                "because they say the same thing in two ways."
            )
        if magnifier is not None:
            return self.with_magnifier(magnifier)
        return self if modal_damping is None else self.with_modal_damping(modal_damping)

    def with_modal_damping(self, ratios: ArrayLike) -> "LinearSystem":
        """Return the system with viscous damping added, mode by mode.

        Parameters
        ----------
        ratios : float or array_like of shape (q - r,)
            Share of critical damping of each elastic mode of the undamped system, or of all.

        Raises
        ------
        InputError
            If a ratio is negative or not finite, or their number does not fit.
        """
        count = self.rigid.shape[1]
        elastic = self.natural.size - count
        values = one_for_each(
            "modal_damping", ratios, elastic, "elastic modes", "", "damping takes energy away"
        )
        momenta = self.mass @ self.shapes[:, count:]
        added = (momenta * (2.0 * values * self.natural[count:])) @ momenta.T
        return replace(self, damping=self.damping + added)

    def with_magnifier(self, magnifier: float = DEFAULT_MAGNIFIER) -> "LinearSystem":
        """Return the system with the same magnifier added for each mode: ratio 1 / (2 magnifier)."""
        checked = positive_number("magnifier", magnifier, "", "vibration at resonance is finite")
        return self.with_modal_damping(0.5 / checked)


def chain_system(chain: Chain) -> LinearSystem:
    """Return the linear system of a chain; its nodes are those of the chain, gears are included.

    Returns
    -------
    LinearSystem
        q unknowns: n nodes less the number of gears.
    """
    expand = chain.expansion()
    rigid, _ = chain.rigid_motions()
    mass, stiffness, damping, loss = (
        expand.T @ matrix @ expand
        for matrix in (
            chain.mass_matrix(),
            chain.stiffness_matrix(),
            chain.damping_matrix(),
            chain.loss_matrix(),
        )
    )
    leading = np.array([np.flatnonzero(column)[0] for column in expand.T])
    unknowns = rigid[leading]
    frequencies, elastic = elastic_modes(
        chain.spring_rows() @ expand, mass, len(mass) - rigid.shape[1]
    )
    return LinearSystem(
        mass=mass,
        stiffness=stiffness,
        damping=damping,
        loss=loss,
        rigid=unknowns,
        expand=expand,
        natural=np.concatenate((np.zeros(rigid.shape[1]), frequencies)),
        shapes=np.column_stack((_orthonormal(mass, unknowns), elastic)),
    )


def natural_modes(
    mass: FloatArray, stiffness: FloatArray, rigid: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find the undamped modes of a system from its matrices.

    Parameters
    ----------
    mass, stiffness : ndarray of shape (q, q)
    rigid : ndarray of shape (q, r)
        Motions that no stiffness resists, as columns.

    Returns
    -------
    natural : ndarray of shape (q,)
        Angular frequencies [rad/s], ascending; exactly zero for the r rigid motions.
    shapes : ndarray of shape (q, q)
        As columns, of unit modal mass.
    """
    root = np.linalg.cholesky(mass)
    count = rigid.shape[1]
    basis = qr(root.T @ rigid)[0] if count else np.eye(len(root))
    elastic = np.linalg.solve(root.T, basis[:, count:])
    reduced = elastic.T @ stiffness @ elastic
    squares, vectors = eigh(0.5 * (reduced + reduced.T))
    frequencies = np.concatenate((np.zeros(count), np.sqrt(np.maximum(squares, 0.0))))
    return frequencies, np.column_stack((_orthonormal(mass, rigid), elastic @ vectors))


def _orthonormal(mass: FloatArray, rigid: FloatArray) -> FloatArray:
    """Return combinations of rigid motions that are of unit modal mass and orthogonal."""
    root = np.linalg.cholesky(rigid.T @ mass @ rigid)
    return np.asarray(np.linalg.solve(root, rigid.T).T)
