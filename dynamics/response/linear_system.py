"""A linear vibrating system by its matrices, and the damping of a chain."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import (
    Array,
    ComplexArray,
    nonnegative_vector,
    one_for_each,
    positive_number,
)
from crankbase.choices import check_kind, whole_within
from crankbase.errors import InputError
from crankbase.quantity import compact
from crankbase.results import result
from crankbase.sentences import amount
from dynamics.chains.chain import DAMPING_UNIT, Chain
from dynamics.chains.chain_modes import elastic_modes
from dynamics.chains.varying import VaryingSpring
from dynamics.indices import node_index, values_at_nodes

# Magnifier (amplitude at resonance over the static one) of engine and shaft without a damper, as
# measured on a 12-liter six-cylinder engine: Nippon Foundation, report 1997/01151.
DEFAULT_MAGNIFIER = 40.0
MAGNIFIER_SOURCE = (
    "magnifier of about 40 for an engine without a damper, measured on a 12-liter six-cylinder "
    "engine (Nippon Foundation, report 1997/01151)"
)

# Steps by which a frequency at which a spring varies is found; each leaves less than half of the error.
MEETING_STEPS = 12


@result("natural [rad/s]", "rigid")
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
    varying : tuple of VaryingSpring
        Springs that vary with frequency or speed; the matrices have their constant stiffness.
    """

    mass: Array
    stiffness: Array
    damping: Array
    loss: Array
    rigid: Array
    expand: Array
    natural: Array
    shapes: Array
    varying: tuple[VaryingSpring, ...] = ()

    def varying_forces(self, w: Array, speeds: Array, motion: ComplexArray) -> ComplexArray:
        """Return the forces (m, q) of what varies at motions (m, q), frequencies and speeds (m,) [rad/s]."""
        forces = np.zeros_like(motion)
        for spring in self.varying:
            forces += np.outer(spring.added(w, speeds) * (motion @ spring.row), spring.row)
        return forces

    def at(self, w: float, speed: float) -> "LinearSystem":
        """Return the system with what varies as it is at one frequency and speed [rad/s] in its matrices."""
        springs = []
        stiffness, loss = self.stiffness.copy(), self.loss.copy()
        for spring in self.varying:
            added = complex(spring.added(np.array([w]), np.array([speed]))[0])
            stiffness += added.real * np.outer(spring.row, spring.row)
            loss += added.imag * np.outer(spring.row, spring.row)
            springs.append(replace(spring, constant=spring.constant + added))
        natural, shapes = natural_modes(self.mass, stiffness, self.rigid)
        return replace(
            self,
            stiffness=stiffness,
            loss=loss,
            natural=natural,
            shapes=shapes,
            varying=tuple(springs),
        )

    def frequencies_met(self, order: float) -> tuple[Array, Array]:
        """Return the frequency [Hz] and the damping ratio of each elastic mode where an order meets it.

        What varies is as it is there: w is the frequency of the mode at w and at the speed w / order.
        """
        met = []
        for mode in range(self.rigid.shape[1], self.natural.size):
            w, system = float(self.natural[mode]), self
            for _ in range(MEETING_STEPS):
                system = self.at(w, w / order)
                w = float(system.natural[mode])
            met.append((w / (2.0 * np.pi), system.damping_ratios()[mode - self.rigid.shape[1]]))
        frequencies, ratios = np.array(met).reshape(-1, 2).T
        return frequencies, ratios

    @property
    def elastic_frequencies(self) -> Array:
        """Natural frequencies of the elastic modes, without damping [Hz], (q - r,), ascending."""
        return self.natural[self.rigid.shape[1] :] / (2.0 * np.pi)

    def damping_ratios(self) -> Array:
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
        q unknowns: the chain's `leading_nodes`.
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
    unknowns = rigid[chain.leading_nodes]
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
        varying=chain.varying_springs(expand),
    )


def natural_modes(mass: Array, stiffness: Array, rigid: Array) -> tuple[Array, Array]:
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
    from scipy.linalg import eigh, qr  # here: engine files are read without it

    root = np.linalg.cholesky(mass)
    count = rigid.shape[1]
    basis = qr(root.T @ rigid)[0] if count else np.eye(len(root))
    elastic = np.linalg.solve(root.T, basis[:, count:])
    reduced = elastic.T @ stiffness @ elastic
    squares, vectors = eigh(0.5 * (reduced + reduced.T))
    frequencies = np.concatenate((np.zeros(count), np.sqrt(np.maximum(squares, 0.0))))
    return frequencies, np.column_stack((_orthonormal(mass, rigid), elastic @ vectors))


def _orthonormal(mass: Array, rigid: Array) -> Array:
    """Return combinations of rigid motions that are of unit modal mass and orthogonal."""
    root = np.linalg.cholesky(rigid.T @ mass @ rigid)
    return np.asarray(np.linalg.solve(root, rigid.T).T)


# So many places with one damping are named; of more their number is told.
NAMED = 2
PASSIVE = "it is that of a passive element"


@result("chain.inertia", "chain.stiffness", "record")
class DampedChain:
    """A chain with all of its damping.

    Parameters
    ----------
    chain : Chain
        With absolute and relative damping and loss factors.
    system : LinearSystem
        Of that chain, with modal damping or magnifier added.
    record : tuple of str
        Kinds of damping, one sentence each, with its source.
    """

    chain: Chain
    system: LinearSystem
    record: tuple[str, ...]


@dataclass(frozen=True)
class EngineMagnifier:
    """Absolute damping of cylinders by the magnifier of their own motion at one frequency.

    A node of inertia I that vibrates at the angular frequency w has the damping I w / magnifier:
    its inertia torque is `magnifier` times as large as its damping torque there.

    Parameters
    ----------
    nodes : tuple of int
        Nodes of the cylinders, from 0.
    frequency : float
        Frequency at which this holds, mostly that of the first elastic mode [Hz].

    Raises
    ------
    InputError
        If magnifier or frequency is not above zero.
    """

    magnifier: float
    nodes: tuple[int, ...]
    frequency: float

    def __post_init__(self) -> None:
        positive_number("magnifier", self.magnifier, "", "vibration at resonance is finite")
        positive_number("frequency", self.frequency, "Hz", "the damping is that at one frequency")


class Dampings(TypedDict, total=False):
    """Damping of all kinds; see `damped`."""

    magnifier: float | None
    modal_damping: ArrayLike | None
    absolute: ArrayLike | Mapping[int, float] | None
    relative: ArrayLike | Mapping[int, float] | None
    loss_factor: ArrayLike | Mapping[int, float] | None
    element_magnifier: ArrayLike | Mapping[int, float] | None
    engine_magnifier: EngineMagnifier | None


def damped(
    chain: Chain,
    *,
    undamped: bool = False,
    add: bool = False,
    source: str = "given",
    unit: str = DAMPING_UNIT,
    **dampings: Unpack[Dampings],
) -> DampedChain:
    """Give a chain damping of any kinds; its own damping is kept.

    Parameters
    ----------
    magnifier : float, optional
        Of every elastic mode: amplitude at resonance over the static one of that mode. If
        nothing is given (an empty mapping counts as nothing) and the chain is undamped, `DEFAULT_MAGNIFIER`.
    modal_damping : float or array_like of shape (q - r,), optional
        Share of critical damping of each elastic mode, or of all.
    absolute : array_like of shape (n,) or mapping of int to float, optional
        Viscous damping of nodes to ground [N m s/rad or N s/m].
    relative : float, array_like of shape (e,) or mapping of int to float, optional
        Viscous damping of elements [N m s/rad or N s/m].
    loss_factor : float, array_like of shape (e,) or mapping of int to float, optional
        Hysteretic damping of elements.
    element_magnifier : float, array_like of shape (e,) or mapping of int to float, optional
        The same by magnifiers: loss factor 1 / magnifier.
    engine_magnifier : EngineMagnifier, optional
        Absolute damping of cylinders by the magnifier of their own motion.
    undamped : bool, optional
        Leave the chain undamped on purpose.
    add : bool, optional
        Whether damping of nodes and elements that have some of the kind is added to it.
    source, unit : str, optional
        Source of the values, and unit of viscous damping, for the record.

    Raises
    ------
    InputError
        If a value is out of range, lengths do not fit, magnifier and modal damping are both given,
        undamped is combined with any damping, or a node or an element already has damping of the kind and
        `add` is not True.
    """
    check_kind("chain", chain, Chain, "a Chain, as load_chain returns in .chain")
    magnifier, modal_damping = dampings.get("magnifier"), dampings.get("modal_damping")
    engine_magnifier = dampings.get("engine_magnifier")
    named = [
        name
        for name, value in dampings.items()
        if value is not None and not (isinstance(value, Mapping) and not value)
    ]
    of_chain = bool(np.any(chain.damping_matrix()) or np.any(chain.loss_matrix()))
    if undamped and (named or of_chain):
        what = ", ".join(named) or "damping of the chain itself"
        raise InputError(
            f"undamped: given True together with {what}; allowed is one of both, because what is "
            "damped is not undamped."
        )
    notes = [f"damping of the chain itself: {_own_damping(chain, unit)}"] if of_chain else []
    if chain.varying:
        at = [(chain.names if s.to_ground else chain.elements)[s.place] for s in chain.varying]
        notes.append(
            f"stiffness that varies with frequency or the operating point: {', '.join(at)}; forced "
            "vibration and critical speeds have it, natural frequencies are those of the constant one"
        )
    between = of_elements("relative", dampings.get("relative"), chain)
    at_nodes = values_at_nodes(
        "absolute", dampings.get("absolute"), chain.inertia.size, unit, "damping takes energy away"
    )
    losses = of_elements("loss_factor", dampings.get("loss_factor"), chain, unit="")
    magnifiers = of_elements(
        "element_magnifier", dampings.get("element_magnifier"), chain, unit="", missing=np.inf
    )
    if np.any(magnifiers == 0.0):
        raise InputError(
            f"element_magnifier[{np.flatnonzero(magnifiers == 0.0)[0]}]: given 0; allowed are finite "
            "numbers of more than zero, because the loss factor is their inverse."
        )
    inverse = np.asarray(1.0 / magnifiers)
    by_place = {
        "absolute": f"absolute damping at nodes, up to {_largest(at_nodes):g} {unit}",
        "relative": f"relative damping of elements, up to {_largest(between):g} {unit}",
        "loss_factor": f"loss factor of elements, up to {_largest(losses):g}",
    }
    notes += [f"{text}: {source}" for name, text in by_place.items() if name in named]
    if np.any(inverse):
        notes.append(
            f"magnifier of elements, least {1.0 / np.max(inverse):g} (loss factor 1/magnifier): "
            f"{source}"
        )
    of_cylinders = np.zeros(chain.inertia.size)
    if engine_magnifier is not None:
        speed = 2.0 * np.pi * engine_magnifier.frequency
        for node in engine_magnifier.nodes:
            place = node_index("engine_magnifier.nodes", node, of_cylinders.size)
            of_cylinders[place] = chain.inertia[place] * speed / engine_magnifier.magnifier
        notes.append(
            f"magnifier {engine_magnifier.magnifier:g} of cylinders (absolute damping, taken at "
            f"{engine_magnifier.frequency:g} Hz): {source}"
        )
    if not add:
        for field, added, before, places in (
            ("absolute", at_nodes, chain.ground_damping, chain.names),
            ("engine_magnifier", of_cylinders, chain.ground_damping + at_nodes, chain.names),
            ("relative", between, chain.damping, chain.elements),
            ("loss_factor", losses, chain.loss_factor, chain.elements),
            ("element_magnifier", inverse, chain.loss_factor + losses, chain.elements),
        ):
            twice = np.flatnonzero((added > 0.0) & (before > 0.0))
            if twice.size:
                raise InputError(
                    f"{field}: given damping of {places[twice[0]]}, which has some of this kind already "
                    f"({compact(before[twice[0]], 4)}); allowed are places without, or add=True to add to it."
                )
    whole = replace(
        chain,
        damping=chain.damping + between,
        loss_factor=chain.loss_factor + losses + inverse,
        ground_damping=chain.ground_damping + at_nodes + of_cylinders,
    )
    system = chain_system(whole).with_added_damping(magnifier, modal_damping)
    if modal_damping is not None:
        notes.append(
            f"modal damping, up to {_largest(np.asarray(modal_damping)):g} of critical: {source}"
        )
    if magnifier is not None:
        notes.append(f"magnifier {magnifier:g} of every elastic mode: {source}")
    if not (named or of_chain or undamped):
        system = system.with_magnifier(DEFAULT_MAGNIFIER)
        notes.append(
            f"magnifier {DEFAULT_MAGNIFIER:g} of every elastic mode, because none is given: "
            f"{MAGNIFIER_SOURCE}"
        )
    if undamped:
        notes.append("no damping, on purpose")
    return DampedChain(whole, system, tuple(notes))


def _own_damping(chain: Chain, viscous: str) -> str:
    """State the damping in a chain's description: each value and its location."""
    joints = [
        f"{chain.names[dashpot.left]} - {chain.names[dashpot.right]}" for dashpot in chain.dashpots
    ]
    texts: dict[str, list[str]] = {}
    for unit, where, values, places, what in (
        ("", "of", chain.loss_factor, chain.elements, "elements"),
        (viscous, "of", chain.damping, chain.elements, "elements"),
        (viscous, "between", [each.damping for each in chain.dashpots], joints, "pairs"),
        (viscous, "to ground at", chain.ground_damping, chain.names, "nodes"),
    ):
        groups: dict[str, list[str]] = {}
        for value, place in zip(values, places, strict=True):
            if value > 0.0:
                text = (
                    amount(float(f"{value:.4g}"), unit, 4) if unit else f"loss factor {value:.4g}"
                )
                groups.setdefault(f"{text} {where}", []).append(place)
        texts |= {
            text: [f"{len(at)} {what}"] if len(at) > NAMED else at for text, at in groups.items()
        }
    return "; ".join(f"{text} {', '.join(at)}" for text, at in texts.items())


def of_elements(
    field: str,
    values: ArrayLike | Mapping[int, float] | None,
    chain: Chain,
    *,
    unit: str = DAMPING_UNIT,
    missing: float = 0.0,
) -> Array:
    """Return one value for each element (e,): from all, from single ones, or from one for all."""
    count = len(chain.connections)
    if values is None:
        return np.full(count, missing)
    if isinstance(values, Mapping):
        full = np.full(count, missing)
        for key, value in values.items():
            name = f"{field}[{key!r}]"
            place = whole_within(name, key, 0, count - 1, f"the chain has {count} elements")
            full[place] = nonnegative_vector(name, [value], unit, PASSIVE)[0]
        return full
    return one_for_each(field, values, count, "elements", unit, PASSIVE)


def _largest(values: Array) -> float:
    return float(np.max(values, initial=0.0))
