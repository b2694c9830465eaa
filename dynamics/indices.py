"""Indices of nodes, cylinders and similar, groups of equal ones, and which speeds are in a range."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Flags, nonnegative_number, nonnegative_vector
from crankbase.choices import check_one_each, is_whole_within, whole_within
from crankbase.errors import InputError, quoted

T = TypeVar("T")
# Speeds this near the end of a range, as a share, lie in it: 1.15 times a speed is rounded.
AT_END = 8.0 * float(np.finfo(np.float64).eps)


def node_index(field: str, node: object, count: int) -> int:
    """Return the index of a node of a chain of `count` nodes, from 0."""
    return whole_within(field, node, 0, count - 1, f"the chain has {count} nodes")


def values_at_nodes(
    field: str, values: ArrayLike | Mapping[int, float] | None, count: int, unit: str, reason: str
) -> Array:
    """Return one non-negative value per node, from an array or a mapping node -> value.

    Parameters
    ----------
    values : array_like of shape (count,), mapping or None
        Nodes missing in a mapping, and all nodes for None, get zero.
    """
    if values is None:
        return np.zeros(count)
    if isinstance(values, Mapping):
        array = np.zeros(count)
        for node, value in values.items():
            name = f"{field}[{quoted(node)}]"
            array[node_index(name, node, count)] = nonnegative_number(name, value, unit, reason)
        return array
    array = nonnegative_vector(field, values, unit, reason)
    check_one_each(field, array.size, count, "nodes")
    return array


def index_of_name(field: str, node: object, names: Sequence[str], what: str, reason: str) -> int:
    """Return the index, from 0, of an item given by its name or that index."""
    if isinstance(node, str) and node in names:
        return names.index(node)
    if is_whole_within(node, 0, len(names) - 1):
        return int(node)
    raise InputError(
        f"{field}: given {quoted(node)}; allowed are the whole numbers 0 to {len(names) - 1} and the "
        f"names of {what}, because {reason}."
    )


def grouped(items: Iterable[T], belongs: Callable[[list[T], T], bool]) -> list[list[T]]:
    """Return items in groups, each in the first group it belongs to, or in its own."""
    groups: list[list[T]] = []
    for item in items:
        home = next((group for group in groups if belongs(group, item)), None)
        if home is None:
            groups.append([item])
        else:
            home.append(item)
    return groups


def within(speeds: float | Array, low: float, high: float) -> Flags:
    """Return which speeds are in a range, ends included within a few units in the last place."""
    return np.asarray(at_most(low, speeds) & at_most(speeds, high))


def within_any(speeds: Array, ranges: Sequence[tuple[float, float]]) -> Flags:
    """Return which speeds are in any of some ranges, whose ends are their own."""
    inside = np.zeros(speeds.shape, dtype=bool)
    for low, high in ranges:
        inside |= within(speeds, low, high)
    return inside


def at_most(speed: float | Array, limit: float | Array) -> Flags:
    """Return whether a speed is at most another, within a few units in the last place."""
    return np.asarray(speed <= limit * (1.0 + AT_END))
