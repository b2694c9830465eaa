"""Damping of a chain, from a user's choice of kinds, with a record of it for reports."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from crankbase.checks.arrays import FloatArray, nonnegative_vector, one_for_each, positive_number
from crankbase.checks.scalars import whole_within
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.units.number_formats import compact
from dynamics.chains.chain import Chain
from dynamics.indices import node_index, values_at_nodes
from dynamics.response.linear_system import (
    DEFAULT_MAGNIFIER,
    MAGNIFIER_SOURCE,
    LinearSystem,
    chain_system,
)

UNIT = "N m s/rad (torsional) or N s/m (axial)"
# So many places with one damping are named; of more their number is told.
NAMED = 2
PASSIVE = "it is that of a passive element"


@summarized("chain.inertia", "chain.stiffness", "record")
@dataclass(frozen=True, eq=False)
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
    magnifier : float
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


def damped(
    chain: Chain,
    *,
    magnifier: float | None = None,
    modal_damping: ArrayLike | None = None,
    absolute: ArrayLike | Mapping[int, float] | None = None,
    relative: ArrayLike | Mapping[int, float] | None = None,
    loss_factor: ArrayLike | Mapping[int, float] | None = None,
    element_magnifier: ArrayLike | Mapping[int, float] | None = None,
    engine_magnifier: EngineMagnifier | None = None,
    undamped: bool = False,
    add: bool = False,
    source: str = "given",
) -> DampedChain:
    """Give a chain damping of any kinds; its own damping is kept.

    Parameters
    ----------
    chain : Chain
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
    source : str, optional
        Source of the values, for the record.

    Returns
    -------
    DampedChain

    Raises
    ------
    InputError
        If a value is out of range, lengths do not fit, magnifier and modal damping are both given,
        undamped is combined with any damping, or a node or an element already has damping of the kind and
        `add` is not True.
    """
    given = {
        "magnifier": magnifier,
        "modal_damping": modal_damping,
        "absolute": absolute,
        "relative": relative,
        "loss_factor": loss_factor,
        "element_magnifier": element_magnifier,
        "engine_magnifier": engine_magnifier,
    }
    named = [
        name
        for name, value in given.items()
        if value is not None and not (isinstance(value, Mapping) and not value)
    ]
    own = bool(np.any(chain.damping_matrix()) or np.any(chain.loss_matrix()))
    if undamped and (named or own):
        what = ", ".join(named) or "damping of the chain itself"
        raise InputError(
            f"undamped: given True together with {what}; allowed is one of both, because what is "
            "damped is not undamped."
        )
    said = [f"damping of the chain itself: {_own_damping(chain)}"] if own else []
    between = of_elements("relative", relative, chain)
    at_nodes = values_at_nodes(
        "absolute", absolute, chain.inertia.size, UNIT, "damping takes energy away"
    )
    losses = of_elements("loss_factor", loss_factor, chain, unit="")
    inverse = _inverse_magnifiers(element_magnifier, chain)
    by_place = {
        "absolute": f"absolute damping at nodes, up to {_largest(at_nodes):g} {UNIT}",
        "relative": f"relative damping of elements, up to {_largest(between):g} {UNIT}",
        "loss_factor": f"loss factor of elements, up to {_largest(losses):g}",
    }
    said += [f"{text}: {source}" for name, text in by_place.items() if name in named]
    if np.any(inverse):
        said.append(
            f"magnifier of elements, least {1.0 / np.max(inverse):g} (loss factor 1/magnifier): "
            f"{source}"
        )
    of_cylinders = np.zeros(chain.inertia.size)
    if engine_magnifier is not None:
        of_cylinders = _cylinder_damping(engine_magnifier, chain)
        said.append(
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
        said.append(
            f"modal damping, up to {_largest(np.asarray(modal_damping)):g} of critical: {source}"
        )
    if magnifier is not None:
        said.append(f"magnifier {magnifier:g} of every elastic mode: {source}")
    if not (named or own or undamped):
        system = system.with_magnifier(DEFAULT_MAGNIFIER)
        said.append(
            f"magnifier {DEFAULT_MAGNIFIER:g} of every elastic mode, because none is given: "
            f"{MAGNIFIER_SOURCE}"
        )
    if undamped:
        said.append("no damping, on purpose")
    return DampedChain(whole, system, tuple(said))


def _own_damping(chain: Chain) -> str:
    """State the damping in a chain's description: each value and its location."""
    joints = [f"{chain.names[one.left]} - {chain.names[one.right]}" for one in chain.dashpots]
    found: dict[str, list[str]] = {}
    for before, unit, values, places, what in (
        ("loss factor ", " of", chain.loss_factor, chain.elements, "elements"),
        ("", f" {UNIT} of", chain.damping, chain.elements, "elements"),
        ("", f" {UNIT} between", [one.damping for one in chain.dashpots], joints, "pairs"),
        ("", f" {UNIT} to ground at", chain.ground_damping, chain.names, "nodes"),
    ):
        groups: dict[str, list[str]] = {}
        for value, place in zip(values, places, strict=True):
            if value > 0.0:
                groups.setdefault(f"{before}{compact(value, 4)}{unit}", []).append(place)
        found |= {
            text: [f"{len(at)} {what}"] if len(at) > NAMED else at for text, at in groups.items()
        }
    return "; ".join(f"{text} {', '.join(at)}" for text, at in found.items())


def of_elements(
    field: str,
    values: ArrayLike | Mapping[int, float] | None,
    chain: Chain,
    *,
    unit: str = UNIT,
    missing: float = 0.0,
) -> FloatArray:
    """Return one value for each element (e,): from all, from single ones, or from one for all.

    Raises
    ------
    InputError
        If a value is negative, an element does not exist, or lengths do not fit.
    """
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


def _largest(values: FloatArray) -> float:
    return float(np.max(values, initial=0.0))


def _inverse_magnifiers(values: ArrayLike | Mapping[int, float] | None, chain: Chain) -> FloatArray:
    given = of_elements("element_magnifier", values, chain, unit="", missing=np.inf)
    if np.any(given == 0.0):
        raise InputError(
            f"element_magnifier[{np.flatnonzero(given == 0.0)[0]}]: given 0; allowed are finite "
            "numbers of more than zero, because the loss factor is their inverse."
        )
    return np.asarray(1.0 / given)


def _cylinder_damping(choice: EngineMagnifier, chain: Chain) -> FloatArray:
    added = np.zeros(chain.inertia.size)
    speed = 2.0 * np.pi * choice.frequency
    for node in choice.nodes:
        place = node_index("engine_magnifier.nodes", node, added.size)
        added[place] = chain.inertia[place] * speed / choice.magnifier
    return added
