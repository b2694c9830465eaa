"""Edit chains: add nodes, join chains, add supports, links and dampers.

Every function returns a new chain. Existing nodes and elements keep their numbers and new
ones follow, so that numbers and names of the old chain remain valid in the new one. A
node is given by its name or by its number from 0.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol, TypedDict, Unpack

from crankbase.array_checks import Array, nonnegative_number
from crankbase.choices import check_choice
from crankbase.errors import InputError
from dynamics.chains.chain import Chain, Dashpot, Gear
from dynamics.chains.varying import StiffnessLaw, Varying
from dynamics.indices import node_index

AT_NODES = ("inertia", "ground", "ground_damping")
OF_ELEMENTS = ("stiffness", "damping", "loss_factor", "distributed_inertia")


class Attachable(Protocol):
    """Something that can be attached to a node of a chain, such as a damper."""

    def attached(self, chain: Chain, node: str | int) -> Chain:
        """Return the chain with this attached to one of its nodes."""
        ...


def find_node(chain: Chain, node: str | int, field: str = "node") -> int:
    """Return the number of a node, given by its name or its number from 0."""
    if not isinstance(node, str):
        return node_index(field, node, len(chain.names))
    check_choice(field, node, chain.names, "these are the nodes of the chain")
    return chain.names.index(node)


class Link(TypedDict, total=False):
    """What joins two nodes: an element, without its stiffness a dashpot, with a ratio a gear."""

    stiffness: float | None
    damping: float
    loss_factor: float
    distributed_inertia: float
    ratio: float | None


def add_node(
    chain: Chain,
    name: str,
    inertia: float,
    *,
    to: str | int,
    **link: Unpack[Link],
) -> Chain:
    """Return the chain with one more node, joined to an existing one.

    Parameters
    ----------
    inertia : float
        [kg m^2] or [kg].
    stiffness : float, optional
        Of the element between the two [N m/rad] or [N/m]. Without stiffness and `ratio`, a
        dashpot of the given damping joins them.
    ratio : float, optional
        Joins the new node by a gear instead: its motion per motion of the other node.

    Returns
    -------
    Chain
        The new node is its last.

    Raises
    ------
    InputError
        If the node to join is unknown, the name exists already, nothing joins the new node or both a
        spring and a gear do, or a value is not allowed.
    """
    at = find_node(chain, to, "to")
    check_new_names(chain.names, [name])
    values = _values_of(chain)
    for field, value in zip(AT_NODES, (inertia, 0.0, 0.0), strict=True):
        values[field].append(value)
    values["names"].append(name)
    _link(values, at, len(chain.names), link)
    return Chain(**values)


def join_chains(
    chain: Chain,
    at: str | int,
    other: Chain,
    other_at: str | int = 0,
    *,
    prefix: str = "",
    **link: Unpack[Link],
) -> Chain:
    """Return two chains as one.

    Parameters
    ----------
    chain : Chain
        Its nodes and elements keep their numbers and names.
    other : Chain
        Chain to join; its nodes follow.
    stiffness, damping, loss_factor : float, optional
        Of an element between the two nodes [N m/rad] or [N/m]. Without stiffness, damping
        and ratio the two nodes become one: inertias and connections to ground add up,
        and the name is that in `chain`.
    ratio : float, optional
        Gear between the two nodes: motion of the node of `other` per motion of the node of `chain`.

    Raises
    ------
    InputError
        If a node is unknown, a name exists already, both a spring and a gear are given, or the gears
        contradict each other.
    """
    left, right = find_node(chain, at, "at"), find_node(other, other_at, "other_at")
    count = len(chain.names)
    merged = link.get("stiffness") is link.get("ratio") is None and not link.get("damping")
    kept = [node for node in range(len(other.names)) if not (merged and node == right)]
    places = {node: count + number for number, node in enumerate(kept)} | (
        {right: left} if merged else {}
    )
    names = [prefix + other.names[node] for node in kept]
    check_new_names(chain.names, names)
    values, added = _values_of(chain), _values_of(other)
    for field in AT_NODES:
        values[field] += [added[field][node] for node in kept]
        if merged:
            values[field][left] += added[field][right]
    for field in OF_ELEMENTS:
        values[field] += added[field]
    values["connections"] += [(places[a], places[b]) for a, b in other.connections]
    values["dashpots"] += [
        replace(link, left=places[link.left], right=places[link.right]) for link in other.dashpots
    ]
    values["gears"] += [
        replace(link, driver=places[link.driver], driven=places[link.driven])
        for link in other.gears
    ]
    values["varying"] += [
        replace(
            spring,
            place=places[spring.place]
            if spring.to_ground
            else len(chain.connections) + spring.place,
        )
        for spring in other.varying
    ]
    values["names"] += names
    if not merged:
        _link(values, left, places[right], link)
    return Chain(**values)


def with_element(
    chain: Chain,
    left: str | int,
    right: str | int,
    stiffness: float,
    *,
    damping: float = 0.0,
    loss_factor: float = 0.0,
    distributed_inertia: float = 0.0,
) -> Chain:
    """Return the chain with one more element between two of its nodes, its last."""
    values = _values_of(chain)
    ends = find_node(chain, left, "left"), find_node(chain, right, "right")
    for field, value in zip(
        OF_ELEMENTS, (stiffness, damping, loss_factor, distributed_inertia), strict=True
    ):
        values[field].append(value)
    values["connections"].append(ends)
    return Chain(**values)


def with_dashpot(chain: Chain, left: str | int, right: str | int, damping: float) -> Chain:
    """Return the chain with one more dashpot between two of its nodes.

    Raises
    ------
    InputError
        If a node is unknown, both are the same, or the damping [N m s/rad] or [N s/m] is not above zero.
    """
    link = Dashpot(find_node(chain, left, "left"), find_node(chain, right, "right"), damping)
    return replace(chain, dashpots=(*chain.dashpots, link))


def with_gear(chain: Chain, driver: str | int, driven: str | int, ratio: float) -> Chain:
    """Return the chain with one more gear between two of its nodes."""
    link = Gear(find_node(chain, driver, "driver"), find_node(chain, driven, "driven"), ratio)
    return replace(chain, gears=(*chain.gears, link))


def with_inertia(chain: Chain, node: str | int, added: float) -> Chain:
    """Return the chain with inertia [kg m^2] or mass [kg] added to one of its nodes."""
    value = nonnegative_number("added", added, "", "it adds to the node's own inertia")
    return replace(chain, inertia=_added_at(chain, node, chain.inertia, value))


def with_ground(
    chain: Chain, node: str | int, stiffness: float = 0.0, *, damping: float = 0.0
) -> Chain:
    """Return the chain with stiffness and viscous damping added between a node and ground.

    Raises
    ------
    InputError
        If the node is unknown, or a value [N m/rad, N m s/rad] or [N/m, N s/m] is negative.
    """
    why = "a support does not push a node away"
    spring = nonnegative_number("stiffness", stiffness, "", why)
    dashpot = nonnegative_number("damping", damping, "", why)
    ground = _added_at(chain, node, chain.ground, spring)
    ground_damping = _added_at(chain, node, chain.ground_damping, dashpot)
    return replace(chain, ground=ground, ground_damping=ground_damping)


def with_varying(chain: Chain, place: int, law: StiffnessLaw, *, to_ground: bool = False) -> Chain:
    """Return the chain with an element, or the spring of a node `to_ground`, that varies by a law.

    Raises
    ------
    InputError
        If there is no such element or node.
    """
    return replace(chain, varying=(*chain.varying, Varying(place, law, to_ground)))


def with_damper(chain: Chain, node: str | int, damper: Attachable) -> Chain:
    """Return the chain with a damper on one of its nodes."""
    return damper.attached(chain, node)


def with_names(chain: Chain, names: Sequence[str]) -> Chain:
    """Return the chain with its nodes renamed."""
    return replace(chain, names=tuple(names))


def check_new_names(taken: Sequence[str], names: Sequence[str]) -> None:
    """Refuse a name that a node already has."""
    for name in names:
        if name in taken:
            raise InputError(
                f"name: given {name!r}, which a node of the chain has already; allowed is another "
                "one, or a prefix, because results are identified by names."
            )


def _values_of(chain: Chain) -> dict[str, Any]:
    """Return the parts of a chain as lists that can be extended."""
    values: dict[str, Any] = {
        field: getattr(chain, field).tolist() for field in (*AT_NODES, *OF_ELEMENTS)
    }
    for field in ("connections", "dashpots", "gears", "varying", "names"):
        values[field] = list(getattr(chain, field))
    return values


def _link(values: dict[str, Any], left: int, right: int, link: Link) -> None:
    """Add a connection of two nodes to the values of a chain."""
    ratio, stiffness = link.get("ratio"), link.get("stiffness")
    damping, loss_factor = link.get("damping", 0.0), link.get("loss_factor", 0.0)
    element = (stiffness, damping, loss_factor, link.get("distributed_inertia", 0.0))
    if ratio is not None:
        for field, value in zip(OF_ELEMENTS, element, strict=True):
            if value:
                raise InputError(
                    f"{field}: given {value:g} beside a ratio; allowed is one of the two, because "
                    "a gear is rigid."
                )
        values["gears"].append(Gear(left, right, ratio))
    elif stiffness is None:
        if any(element[2:]):
            raise InputError(
                "stiffness: given none beside a loss factor or an inertia; allowed are finite "
                "numbers of more than zero, because both belong to an elastic element."
            )
        values["dashpots"].append(Dashpot(left, right, damping))
    else:
        for field, value in zip(OF_ELEMENTS, element, strict=True):
            values[field].append(value)
        values["connections"].append((left, right))


def _added_at(chain: Chain, node: str | int, values: Array, added: float) -> Array:
    changed = values.copy()
    changed[find_node(chain, node)] += added
    return changed
