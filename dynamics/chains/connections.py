"""Connections of the nodes of a chain: springs by pairs, dashpots and gears; connected parts."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.arrays import FloatArray, finite_vector, positive_number
from crankbase.checks.choices import check_kind
from crankbase.errors import InputError
from dynamics.indices import node_index

Pairs = tuple[tuple[int, int], ...]
# Ratios of two ways through gears count as equal within this.
EQUAL_RATIOS = 1e-9


@dataclass(frozen=True)
class Dashpot:
    """Viscous damping between two nodes that no spring joins, as in a viscous damper.

    Parameters
    ----------
    left, right : int
        Nodes, from 0.
    damping : float
        Torque or force per relative speed [N m s/rad or N s/m].

    Raises
    ------
    InputError
        If the damping is not a finite number above zero.
    """

    left: int
    right: int
    damping: float

    def __post_init__(self) -> None:
        positive_number(
            "dashpot.damping",
            self.damping,
            "N m s/rad (torsional) or N s/m (axial)",
            "a dashpot resists motion",
        )


@dataclass(frozen=True)
class Gear:
    """Two nodes whose motions keep a fixed ratio, as those of meshing gears do.

    Parameters
    ----------
    driver, driven : int
        Nodes, from 0.
    ratio : float
        Motion of the driven node per motion of the driver: their speed ratio, negative where the
        sense changes; teeth of the driver over teeth of the driven gear in size.

    Raises
    ------
    InputError
        If the ratio is zero or not finite.
    """

    driver: int
    driven: int
    ratio: float

    def __post_init__(self) -> None:
        value = finite_vector("gear.ratio", [self.ratio])
        if value[0] == 0.0:
            raise InputError(
                "gear.ratio: given 0; allowed is a finite number other than zero, because the "
                "driven gear turns."
            )


def checked_pairs(connections: Sequence[tuple[int, int]] | None, count: int) -> Pairs:
    """Return the pairs of nodes that springs join; by default the neighbors in a row.

    Raises
    ------
    InputError
        If a pair does not consist of different nodes.
    """
    if connections is None:
        return tuple(pairwise(range(count)))
    return tuple(
        _pair(f"connections[{place}]", pair, count) for place, pair in enumerate(connections)
    )


def check_links(dashpots: Sequence[Dashpot], gears: Sequence[Gear], count: int) -> None:
    """Check the nodes of dashpots and gears.

    Raises
    ------
    InputError
        If one is no Dashpot or Gear, a node does not exist, or both ends are one.
    """
    for field, links, kind, example in (
        ("dashpots", dashpots, Dashpot, "Dashpot(left=0, right=1, damping=20.0)"),
        ("gears", gears, Gear, "Gear(driver=1, driven=2, ratio=-0.6)"),
    ):
        check_kind(field, links, Sequence, f"a sequence of {kind.__name__}")
        for place, link in enumerate(links):
            check_kind(f"{field}[{place}]", link, kind, f"a {kind.__name__}, like {example}")
    for place, dashpot in enumerate(dashpots):
        _pair(f"dashpots[{place}]", (dashpot.left, dashpot.right), count)
    for place, gear in enumerate(gears):
        _pair(f"gears[{place}]", (gear.driver, gear.driven), count)


def _pair(field: str, pair: Sequence[int], count: int) -> tuple[int, int]:
    if np.ndim(pair) != 1 or len(pair) != 2:
        raise InputError(f"{field}: given {pair!r}; allowed are two node numbers.")
    left, right = (node_index(field, node, count) for node in pair)
    if left == right:
        raise InputError(
            f"{field}: given node {left} twice; allowed are two different nodes, because what joins "
            "a node to itself does nothing."
        )
    return left, right


def speed_ratios(
    pairs: Pairs, gears: Sequence[Gear], count: int
) -> tuple[NDArray[np.int64], FloatArray]:
    """Find which nodes springs and gears connect, and their relative speeds in rigid motion.

    Parameters
    ----------
    pairs : tuple of pairs of int
    gears : sequence of Gear
    count : int
        Number of nodes.

    Returns
    -------
    parts : ndarray of shape (n,)
        Number of the part of each node, from 0, in the order of first nodes.
    ratios : ndarray of shape (n,)
        Motion of each node per motion of its part's first node.

    Raises
    ------
    InputError
        If two paths through gears require different ratios of the same node.
    """
    neighbors: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for left, right in pairs:
        neighbors[left].append((right, 1.0))
        neighbors[right].append((left, 1.0))
    for gear in gears:
        neighbors[gear.driver].append((gear.driven, gear.ratio))
        neighbors[gear.driven].append((gear.driver, 1.0 / gear.ratio))
    parts, ratios = np.full(count, -1, dtype=np.int64), np.ones(count)
    for first in range(count):
        if parts[first] >= 0:
            continue
        parts[first] = parts.max() + 1
        waiting = [first]
        while waiting:
            node = waiting.pop()
            for other, ratio in neighbors[node]:
                wanted = ratios[node] * ratio
                if parts[other] < 0:
                    parts[other], ratios[other] = parts[first], wanted
                    waiting.append(other)
                elif abs(ratios[other] - wanted) > EQUAL_RATIOS * abs(wanted):
                    raise InputError(
                        f"gears: given ratios by which node {other} turns {ratios[other]:g} or "
                        f"{wanted:g} times as fast as node {first}; allowed is one ratio on every "
                        "way, because otherwise the shafts lock."
                    )
    return parts, ratios


def check_connected(parts: NDArray[np.int64], dashpots: Sequence[Dashpot]) -> None:
    """Refuse a chain that is not connected.

    Raises
    ------
    InputError
        Naming the nodes that are not connected to the first one.
    """
    reached = {0}
    pairs = [(int(parts[d.left]), int(parts[d.right])) for d in dashpots]
    for _ in pairs:
        for left, right in pairs:
            if left in reached or right in reached:
                reached |= {left, right}
    apart = [node for node, part in enumerate(parts.tolist()) if part not in reached]
    if apart:
        raise InputError(
            f"connections: given ones that do not join node {', '.join(map(str, apart))} to node 0; "
            "allowed is one connected chain, because separate parts do not move each other."
        )


def gear_groups(gears: Sequence[Gear], count: int) -> FloatArray:
    """Return T of shape (n, q): motion of the nodes per motion of the q that gears leave free.

    Each group of nodes coupled by gears moves with its first node.
    """
    groups, ratios = speed_ratios((), gears, count)
    expand = np.zeros((count, int(groups.max()) + 1))
    expand[np.arange(count), groups] = ratios
    return expand
