"""From a study's values to the columns of an equation: factors, categories as 0/1, or groups."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from regression.fits.forms import Basis
from regression.fits.groups import (
    Dimensions,
    group_named,
    group_values,
    independent_groups,
    is_length,
)
from regression.plans.factors import Factor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Encoding:
    """Description of the columns of an equation.

    Attributes
    ----------
    basis : {"factors", "groups"}
    names : tuple of str
        Of the columns. A category of the labels a, b, c has the columns "name=b" and "name=c",
        which are 1 for that label and 0 for others; the first label has none.
    logged : tuple of bool
        Columns that a form in logarithms may use as logarithms.
    """

    basis: Basis
    names: tuple[str, ...]
    logged: tuple[bool, ...]

    def columns(self, factors: Sequence[Factor], values: Array, dimensions: Dimensions) -> Array:
        """Return the columns of designs.

        Parameters
        ----------
        factors : sequence of Factor
        values : (n, k) ndarray
            Of the factors [SI]; of a category the label's index.
        dimensions : mapping
            Of the throws, name to (n,) values [m]; for groups only.

        Returns
        -------
        (n, number of columns) ndarray
        """
        places = {factor.name: place for place, factor in enumerate(factors)}
        made = []
        for name in self.names:
            field, category, label = name.partition("=")
            if category:
                place = places[field]
                index = factors[place].labels.index(label)
                made.append((np.rint(values[:, place]) == index).astype(np.float64))
            elif self.basis == "groups":
                made.append(np.broadcast_to(group_named(name).value(dimensions), len(values)))
            else:
                made.append(values[:, places[name]])
        return np.column_stack(made)


def factor_encoding(factors: Sequence[Factor], values: Array) -> Encoding:
    """Use the factors themselves as columns.

    The logarithm of a factor whose range includes zero, such as an optional fillet, is not used.

    Parameters
    ----------
    factors : sequence of Factor
    values : (n, k) ndarray
        At the runs; labels that no run has get no column.
    """
    names: list[str] = []
    logged: list[bool] = []
    for place, factor in enumerate(factors):
        if factor.labels:
            names += _category_columns(factor, values[:, place])
            logged += [False] * (len(names) - len(logged))
        else:
            names.append(factor.name)
            logged.append(factor.lowest > 0.0)
    return Encoding("factors", tuple(names), tuple(logged))


def group_encoding(
    factors: Sequence[Factor], values: Array, dimensions: Mapping[str, Array]
) -> Encoding:
    """Use varying dimensionless groups as columns, and categories.

    Parameters
    ----------
    factors : sequence of Factor
    values : (n, k) ndarray
        At the runs.
    dimensions : mapping
        Of the throws at the runs, name to (n,) values [m].

    Raises
    ------
    InputError
        If a factor is not a length, so that groups of lengths do not follow it; or if more groups vary than
        can be separated, so that an equation in some of them would not apply to other sizes.
    """
    numbers = [factor for factor in factors if not factor.labels]
    odd = [f.name for f in numbers if f.unit and f.name not in dimensions]
    if odd:
        raise InputError(
            f"groups: given the factor {odd[0]}; allowed are the main dimensions of the throw and "
            "ratios, because groups are made of these."
        )
    found = group_values({name: column for name, column in dimensions.items() if is_length(name)})
    chosen = independent_groups(found, len(numbers))
    others = [name for name, column in found.items() if name not in chosen and _varies(column)]
    if others or not chosen:
        raise InputError(
            f"groups: given {len(numbers)} factors that make {len(chosen) + len(others)} groups vary, "
            f"{', '.join((*chosen, *others))}; allowed are as many factors as groups, because an "
            "equation in some of them does not carry over to other sizes."
        )
    categories = [
        name
        for place, factor in enumerate(factors)
        if factor.labels
        for name in _category_columns(factor, values[:, place])
    ]
    logged = [group_named(name).logged for name in chosen] + [False] * len(categories)
    return Encoding("groups", (*chosen, *categories), tuple(logged))


def _category_columns(factor: Factor, column: Array) -> list[str]:
    present = set(np.rint(column).astype(int).tolist())
    return [
        f"{factor.name}={label}"
        for index, label in enumerate(factor.labels)
        if index and index in present and len(present) > 1
    ]


def constant_groups(dimensions: Mapping[str, Array]) -> dict[str, float]:
    """Return the groups that are constant over all designs, with their value; absent features have none."""
    found = group_values({name: column for name, column in dimensions.items() if is_length(name)})
    return {
        name: float(column[0])
        for name, column in found.items()
        if column[0] and not _varies(column)
    }


def _varies(column: Array) -> bool:
    return bool(np.ptp(column) > 1e-9 * float(np.max(np.abs(column))))
