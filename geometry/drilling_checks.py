"""Checks of oil holes: within their part, clear of fillets, bores and each other."""

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from crankbase.errors import InputError
from geometry.drilling import Drilling
from geometry.parts import Cylinder, ThrowParts
from geometry.throw_fields import dimension_error, in_mm, label

Array = NDArray[np.float64]

# Shares of the journal's diameter: smallest and largest hole, and what stays free beside its exits.
SMALLEST_HOLE, LARGEST_HOLE, FREE_LEDGE = 0.02, 0.4, 0.01
# The smallest exit radius and the thinnest wall beside a hole, beside its diameter.
SMALLEST_EXIT, SMALLEST_WALL = 0.05, 0.1
# A hole with its exit radius, beside the journal's radius less that; of the bore's radius, what a hole
# that runs into it may take.
WIDEST_EXIT, SHARE_OF_BORE = 0.6, 0.95
STEPS = 400


def check_drillings(parts: ThrowParts) -> None:
    """Refuse oil holes that cannot be drilled as described.

    Raises
    ------
    InputError
        With one sentence.
    """
    for hole in parts.drillings:
        journal = next(one for one in parts.cylinders if one.name == hole.journal)
        _check_diameter(hole, journal)
        _check_exit_radius(hole)
        if hole.bore_radius > 0.0:
            _check_bore(hole, journal)
        _check_place(parts, hole, journal)
    for first, second in combinations(parts.drillings, 2):
        if first.journal == second.journal:
            _check_apart(first, second)


def _field(hole: Drilling, name: str) -> str:
    return f"oil_holes[{hole.number - 1}].{name}"


def _check_diameter(hole: Drilling, journal: Cylinder) -> None:
    given, outside = 2.0 * hole.radius, 2.0 * hole.journal_radius
    low, high = SMALLEST_HOLE * outside, LARGEST_HOLE * outside
    if not low * (1.0 - 1e-12) <= given <= high * (1.0 + 1e-12):
        reason = (
            "a larger one leaves too little of it"
            if given > high
            else "a smaller one does not matter (leave it out)"
        )
        raise dimension_error(
            _field(hole, "diameter"),
            given,
            f"{in_mm(low)} to {in_mm(high)} in the {label(journal)} of {in_mm(outside)}",
            f"because {reason}",
        )


def _check_exit_radius(hole: Drilling) -> None:
    given, low = hole.exit_radius, SMALLEST_EXIT * 2.0 * hole.radius
    room = (WIDEST_EXIT * hole.journal_radius - hole.radius) / (1.0 + WIDEST_EXIT)
    high = min(2.0 * hole.radius, room)
    if given and not low * (1.0 - 1e-12) <= given <= high * (1.0 + 1e-12):
        reason = (
            "a smaller one acts as a sharp edge (give 0)"
            if given < low
            else f"the hole of {in_mm(2.0 * hole.radius)} cannot be opened further"
        )
        raise dimension_error(
            _field(hole, "exit_radius"),
            given,
            f"0, or {in_mm(low)} to {in_mm(high)}",
            f"because {reason}",
        )


def _check_bore(hole: Drilling, journal: Cylinder) -> None:
    """A hole enters the bore with its whole width, or passes it by."""
    across, along = hole.bore_place
    wall = SMALLEST_WALL * 2.0 * hole.radius
    if abs(across) - hole.radius >= hole.bore_radius + wall:
        return
    widest = 2.0 * (SHARE_OF_BORE * hole.bore_radius - abs(across))
    if 2.0 * hole.radius > widest * (1.0 + 1e-12):
        bore = f"the {label(journal)}'s bore of {in_mm(2.0 * hole.bore_radius)}"
        off = (
            f", whose axis passes the hole's at {in_mm(abs(across))}" if abs(across) > 1e-9 else ""
        )
        reason = f"because it must run with its whole width into {bore}{off}, or pass it by"
        if widest <= 0.0:
            raise InputError(
                f"throw.{_field(hole, 'angle')}: given {math.degrees(hole.angle):.6g} deg; allowed is "
                f"another one, {reason}."
            )
        raise dimension_error(
            _field(hole, "diameter"),
            2.0 * hole.radius,
            f"at most {in_mm(widest)} at this angle",
            reason,
        )
    for outlet in hole.exits:
        p, q, t = outlet.lip.T
        height = outlet.side * (t * math.cos(hole.tilt) + q * math.sin(hole.tilt) - along)
        left = float(np.min(height - np.sqrt(hole.bore_radius**2 - (p - across) ** 2)))
        if left < wall:
            raise dimension_error(
                _field(hole, "exit_radius"),
                hole.exit_radius,
                "a smaller one",
                f"because {in_mm(wall)} of straight hole must be left between its rounding and the bore of "
                f"{in_mm(2.0 * hole.bore_radius)}",
            )


def _check_place(parts: ThrowParts, hole: Drilling, journal: Cylinder) -> None:
    """A hole's exit is on its journal between the fillets, and clear of the throw's ends."""
    reached = [_along(hole, outlet.rim) for outlet in hole.exits]
    if not hole.through:
        half = hole.radius * math.cos(hole.tilt)
        reached.append(np.array([hole.place - half, hole.place + half]))
    lowest, highest = min(z.min() for z in reached), max(z.max() for z in reached)
    ledge = FREE_LEDGE * 2.0 * hole.journal_radius
    start = journal.start + journal.start_fillet + ledge
    end = journal.end - journal.end_fillet - ledge
    if lowest >= start * (1.0 - 1e-12) and highest <= end * (1.0 + 1e-12):
        return
    middle = 0.5 * (journal.start + journal.end)
    if not journal.is_pin:
        middle = journal.start if journal is parts.cylinders[0] else journal.end
    position = hole.place - middle
    low, high = position + start - lowest, position + end - highest
    if low > high:
        raise dimension_error(
            _field(hole, "diameter"),
            2.0 * hole.radius,
            f"a hole that takes at most {in_mm(end - start)} along the shaft with tilt and exit radius, not "
            f"{in_mm(highest - lowest)}",
            f"because the {label(journal)} has no more between its fillets"
            + ("" if journal.is_pin else " and the end of the throw"),
        )
    at_end = lowest < start if journal is parts.cylinders[0] else highest > end
    reason = (
        "because the throw ends in the middle of the main journal, and its section there must be whole"
        if not journal.is_pin and at_end
        else f"or the hole would cut the {label(journal)}'s fillet or the web"
    )
    raise dimension_error(
        _field(hole, "position"), position, f"{in_mm(low)} to {in_mm(high)}", reason
    )


def _along(hole: Drilling, places: Array) -> Array:
    """Coordinates z of places p, q, t (n, 3) [m]."""
    return np.asarray(hole.place + places @ hole.frame[:, 2])


def _check_apart(first: Drilling, second: Drilling) -> None:
    """Holes must not meet each other, nor their exits."""
    wall = SMALLEST_WALL * 2.0 * min(first.radius, second.radius)
    between = min(
        _distance(one, other) - first.radius - second.radius
        for one in _stretches(first)
        for other in _stretches(second)
    )
    exits = min(
        float(np.linalg.norm(one[:, None] - other[None], axis=2).min())
        for one in _rims(first)
        for other in _rims(second)
    )
    if min(between, exits) < wall:
        what = "runs into" if between < wall else "comes out into the exit of"
        raise InputError(
            f"throw.oil_holes[{second.number - 1}]: given so that it {what} oil_holes[{first.number - 1}]; "
            f"allowed are holes that leave {in_mm(wall)} between them, because each is calculated separately."
        )


def _rims(hole: Drilling) -> list[Array]:
    return [hole.middle + outlet.rim @ hole.frame for outlet in hole.exits]


def _stretches(hole: Drilling) -> list[tuple[Array, Array]]:
    """Ends of the axis of each stretch of a hole in the material; a bore is open between two."""
    none = np.zeros(1)
    return [
        (hole.middle + outlet.inner(none, none)[0] * hole.frame[2], outlet.point)
        for outlet in hole.exits
    ]


def _distance(one: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """Distance of two stretches [m]."""
    points = one[0] + np.linspace(0.0, 1.0, STEPS)[:, None] * (one[1] - one[0])
    way = other[1] - other[0]
    share = np.clip((points - other[0]) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(points - other[0] - share[:, None] * way, axis=1).min())
