"""A fitted equation compiled for speed: the same operations for one point and for a million.

The polynomial is nested as in Horner's scheme, z_i (a_i + z_j (a_ij + ...)), into closures that work
on floats and on arrays, in the same order: the results differ only as the logarithms and
exponentials of `math` and numpy do, by a unit in the last place. Arrays are processed in pieces that fit the
processor's cache.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from regression.fits.forms import FittedForm
from regression.fits.terms import Term

# Values of one column that are evaluated at a time: 64 kB, so that a few columns fit into a cache.
PIECE = 8192

# Floats or arrays: the closures do not ask.
Column = Any


@dataclass(frozen=True)
class CompiledEquation:
    """An equation as two functions of its columns, which are not coded and not logged.

    Attributes
    ----------
    scalar : callable
        Sequence of k floats to a float; `OverflowError` or `ValueError` if it has no value.
    array : callable
        Sequence of k floats or arrays of one shape to an array (or a float); infinite or NaN
        where it has no value.
    """

    scalar: Callable[[Sequence[float]], float]
    array: Callable[[Sequence[Column]], Column]


def compile_equation(fitted: FittedForm) -> CompiledEquation:
    """Compile a fitted form.

    Parameters
    ----------
    fitted : FittedForm

    Returns
    -------
    CompiledEquation
        Equal to `fitted.predict` within rounding.
    """
    codings = tuple(zip(fitted.log_factors, fitted.center, fitted.half_range, strict=True))
    polynomial = _horner_tree(dict(zip(fitted.terms, fitted.coefficients, strict=True)))
    if not fitted.logarithmic:
        total = _closure(polynomial)
        return CompiledEquation(
            lambda columns: total(_coded(columns, codings, math.log)),
            lambda columns: total(_coded(columns, codings, np.log)),
        )
    # exp(constant) once and for all: the rest is of order 1 and loses no digits in the exponential.
    size = math.exp(polynomial.constant)
    rest = _closure(_HornerNode(0.0, polynomial.children))
    return CompiledEquation(
        lambda columns: size * math.exp(rest(_coded(columns, codings, math.log))),
        lambda columns: size * np.exp(rest(_coded(columns, codings, np.log))),
    )


def _coded(
    columns: Sequence[Column],
    codings: tuple[tuple[bool, float, float], ...],
    logarithm: Callable[[Column], Column],
) -> list[Column]:
    return [
        ((logarithm(value) if logged else value) - center) / half_range
        for value, (logged, center, half_range) in zip(columns, codings, strict=True)
    ]


@dataclass(frozen=True)
class _HornerNode:
    """Node of a Horner scheme: constant + sum of z_i times child i."""

    constant: float
    children: Mapping[int, "_HornerNode"]


def _horner_tree(coefficients: Mapping[Term, float]) -> _HornerNode:
    """Build a Horner scheme: terms grouped by their first column, and so on within each group."""
    inner: dict[int, dict[Term, float]] = {}
    for term, coefficient in coefficients.items():
        if term:
            inner.setdefault(term[0], {})[term[1:]] = coefficient
    return _HornerNode(
        coefficients.get((), 0.0), {number: _horner_tree(inner[number]) for number in sorted(inner)}
    )


def _closure(nest: _HornerNode) -> Callable[[Sequence[Column]], Column]:
    constant = nest.constant
    leaves = tuple((i, n.constant) for i, n in nest.children.items() if not n.children)
    branches = tuple((i, _closure(n)) for i, n in nest.children.items() if n.children)

    def evaluate(coded: Sequence[Column]) -> Column:
        total = constant
        for number, coefficient in leaves:
            total = total + coefficient * coded[number]
        for number, inner in branches:
            total = total + coded[number] * inner(coded)
        return total

    return evaluate


def pieces(
    columns: Mapping[str, Column], shape: tuple[int, ...]
) -> Iterator[tuple[int, dict[str, Column]]]:
    """Cut columns that are broadcast to one shape into pieces of `PIECE` places.

    Parameters
    ----------
    columns : mapping
        Name to a float, or to an array that can be broadcast to `shape`.
    shape : tuple of int

    Yields
    ------
    start : int
        Place of the piece in C order.
    piece : dict
        Name to a float or a one-dimensional array.
    """
    flat: dict[str, Column] = {}
    for name, column in columns.items():
        array = np.asarray(column)
        flat[name] = array.item() if array.size == 1 else np.broadcast_to(array, shape).reshape(-1)
    for start in range(0, math.prod(shape), PIECE):
        yield (
            start,
            {
                name: column[start : start + PIECE] if isinstance(column, np.ndarray) else column
                for name, column in flat.items()
            },
        )
