"""Dimensionless groups of a throw's dimensions: coordinates valid for all engine sizes.

A linear elastic throw scaled by a factor keeps its dimensionless responses: e E D_shm,
torsional compliance times E D_shm^3, mass by rho D_shm^3. An equation for these in ratios of lengths
is therefore valid for any size (with Poisson's ratio of the study). Overlap and radius are used as
s/R and R/h: the overlap stiffens the webs. For 160 throws of 13/14 to 25/34 size a quadratic form in
these is a little better at held-out designs than one in D/R and h/R, 1.4 % against 1.7 %.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from crankbase.model import field_extra
from geometry.throw import CrankThrow

Array = NDArray[np.float64]
# Numbers or arrays of one shape, by name of the dimension [SI].
Dimensions = Mapping[str, Any]

# Two values of a group are the same if they differ by less than this share.
_SAME = 1e-9
# A group of which the others explain all but this share says nothing of its own.
_OWN_SHARE = 1e-3


@dataclass(frozen=True)
class Group:
    """A dimensionless group.

    Attributes
    ----------
    name : str
        In the papers' symbols, such as "B/D_shm".
    dimensions : tuple of str
        Names of the dimensions used.
    value : callable
        Function of a mapping of dimensions; for plain numbers and arrays.
    logged : bool
        Whether a form in logarithms uses its logarithm: not if it may be 0 or negative.
    """

    name: str
    dimensions: tuple[str, ...]
    value: Callable[[Dimensions], Any]
    logged: bool


def _ratio(name: str, above: str, below: str, *, logged: bool = True) -> Group:
    return Group(name, (above, below), lambda d: d[above] / d[below], logged)


def _overlap(d: Dimensions) -> Any:
    return 0.5 * (d["main_journal_diameter"] + d["pin_diameter"]) / d["crank_radius"] - 1.0


GROUPS: Mapping[str, Group] = {
    group.name: group
    for group in (
        Group(
            "s/R", ("main_journal_diameter", "pin_diameter", "crank_radius"), _overlap, logged=False
        ),
        _ratio("R/h", "crank_radius", "web_thickness"),
        _ratio("B/D_shm", "web_width", "pin_diameter"),
        _ratio("D_km/D_shm", "main_journal_diameter", "pin_diameter"),
        _ratio("L_shm/D_shm", "pin_length", "pin_diameter"),
        _ratio("L_km/D_shm", "main_journal_length", "pin_diameter"),
        _ratio("r/D_shm", "fillet_radius", "pin_diameter", logged=False),
        _ratio("d_km/D_km", "main_journal_bore", "main_journal_diameter", logged=False),
        _ratio("d_shm/D_shm", "pin_bore", "pin_diameter", logged=False),
    )
}
_COVERED = frozenset(name for group in GROUPS.values() for name in group.dimensions)
_OTHER = "/D_shm"


def group_named(name: str) -> Group:
    """Return the group of this name: from the catalogue, or any other length over the pin diameter.

    Examples
    --------
    >>> group_named("web_journal_end/D_shm").dimensions
    ('web_journal_end', 'pin_diameter')

    Raises
    ------
    InputError
        If the name is unknown.
    """
    if name in GROUPS:
        return GROUPS[name]
    field = name.removesuffix(_OTHER)
    if field == name or not field:
        raise InputError(
            f"group: given {name!r}; allowed are {', '.join(GROUPS)} and FIELD{_OTHER} for another "
            "length, because equations that carry over to other sizes are written in these."
        )
    return _ratio(name, field, "pin_diameter", logged=False)


def group_names(dimensions: Iterable[str]) -> tuple[str, ...]:
    """Return the groups of these dimensions: those of the catalogue, then other lengths."""
    given = tuple(dimensions)
    known = [name for name, group in GROUPS.items() if set(group.dimensions) <= set(given)]
    if "pin_diameter" not in given:
        return tuple(known)
    return (*known, *(f"{name}{_OTHER}" for name in given if name not in _COVERED))


def group_values(dimensions: Dimensions) -> dict[str, Array]:
    """Calculate all groups that the dimensions make.

    Parameters
    ----------
    dimensions : mapping
        Name of a length to (n,) array [m]; only lengths.

    Returns
    -------
    dict of str to (n,) ndarray
    """
    return {
        name: np.asarray(group_named(name).value(dimensions), dtype=np.float64)
        for name in group_names(dimensions)
    }


def is_length(name: str) -> bool:
    """Whether a field of the throw is a length."""
    info = CrankThrow.model_fields.get(name)
    return info is not None and field_extra(info, "unit") == "m"


def independent_groups(values: Mapping[str, Array], limit: int) -> tuple[str, ...]:
    """Choose groups that vary independently.

    Starting with the first that varies, the group is added of which those already chosen explain the
    smallest share (by linear regression), as long as any has a share of its own.

    Parameters
    ----------
    values : mapping
        Group name to its values at the runs (n,).
    limit : int
        Largest number of groups: there are no more independent ones than varying numbers in the study.

    Returns
    -------
    tuple of str
        In the order of `values`.
    """
    varying = {
        name: (column - column.mean()) / np.linalg.norm(column - column.mean())
        for name, column in values.items()
        if np.ptp(column) > _SAME * float(np.max(np.abs(column)))
    }
    chosen: list[str] = []
    while varying and len(chosen) < limit:
        own = {name: float(np.linalg.norm(column)) for name, column in varying.items()}
        # Of equals the first: at the start all have the length 1.
        best = max(own, key=lambda name: round(own[name], 6))
        if own[best] < _OWN_SHARE:
            break
        chosen.append(best)
        direction = varying.pop(best) / own[best]
        varying = {name: c - direction * (direction @ c) for name, c in varying.items()}
    return tuple(name for name in values if name in chosen)
