"""Reactions looked up in a compliance model: from its equations to forces and moments on both ends."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import check_sizes, finite_array
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import table
from fem.end_reactions import END_LOADS, LARGEST_LOAD, LOAD_UNITS, EndReaction, Reactions
from geometry.throw import CrankThrow
from regression.end_reactions import NEEDED, RIGHT_MOMENTS, ThrowLengths, end_reactions
from regression.models.family import Family, angle_law_remarks

if TYPE_CHECKING:
    from fem.supports import Support
    from regression.models.lookup import Lookups
    from regression.models.model_file import ModelContent

Array = NDArray[np.float64]

# Beginnings of names of what a throw has that its first pin's reactions do not tell of.
_OTHER_PARTS = ("further_pins.", "oil_holes.")
_WEBS = ("left_web.thickness", "right_web.thickness")


@summarized(
    "support",
    "left force: left.force [N]",
    "left moment: left.moment [N m]",
    "right force: right.force [N]",
    "right moment: right.moment [N m]",
    "remarks",
)
@dataclass(frozen=True, eq=False)
class ReactionLookup(Reactions):
    """Reactions from a compliance model, with their errors.

    Attributes
    ----------
    left, right : EndReaction
        Force [N] and moment [N m], each (3,), or (..., 3) of many throws, in the throw frame.
    band : Reactions
        Error of each component, from the bands of the equations together: 0 where
        equilibrium decides alone. Infinite without a valid band, as outside the range.
    support : str
    inside : ndarray of bool
        Where everything is within the range of the fits.
    remarks : tuple of str
        As in `Lookup`.
    """

    band: Reactions
    support: str
    inside: NDArray[np.bool_]
    remarks: tuple[str, ...]

    def to_pandas(self) -> Any:
        """Return a table of the ends; of many throws one of the throws in C order, "left Fx" to "right Mz".

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        if self.left.force.ndim == 1:
            return super().to_pandas()
        ends = (self.left.force, self.left.moment, self.right.force, self.right.moment)
        columns = np.concatenate(ends, axis=-1).reshape(-1, 12).T
        return table(dict(zip(END_LOADS, zip(columns, LOAD_UNITS * 2, strict=True), strict=True)))


def look_reactions_up(
    model: "ModelContent",
    lookups: "Callable[..., Lookups]",
    pin_force: ArrayLike,
    support: "Support",
    strict: bool,
    dimensions: Mapping[str, ArrayLike | str],
) -> ReactionLookup:
    """Find reactions for `ComplianceModel.reactions`, with a function that looks its responses up.

    Raises
    ------
    InputError
    """
    force = checked_force(pin_force)
    kind, gamma = checked_support(support)
    _check_throws(model, kind)
    missing = [name for name in NEEDED[kind] if name not in model.responses]
    if missing:
        raise InputError(
            f"support: given {support_words(kind, gamma)}, but the model has no {missing[0]}; reactions "
            f"there need {', '.join(NEEDED[kind])}: run and fit its study again, because this release has "
            "studies keep them."
        )
    found = {name: lookups(name, strict=strict, **dimensions) for name in NEEDED[kind]}
    inside = np.logical_and.reduce([one.inside for one in found.values()])
    _check_shapes(force, inside)
    lengths = throw_lengths(model.family, dimensions)
    values: dict[str, Any] = {name: one.value for name, one in found.items()}

    # One number for both ends, if they are alike.
    twins = {} if angle_law_remarks(model.family, model.throw) else RIGHT_MOMENTS
    values |= {right: values[left] for left, right in twins.items() if left in values}

    def loads(name: str = "", ends: Any = None) -> Array:
        changed = {} if not name else {name: ends, twins.get(name, name): ends}
        return end_reactions(values | changed, lengths, force, gamma)

    middle = loads()
    band = np.zeros_like(middle)
    for name, one in found.items():
        if name in twins.values():
            continue
        open_ended = ~(np.isfinite(one.lower) & np.isfinite(one.upper))
        ends = (np.where(open_ended, one.value, end) for end in (one.lower, one.upper))
        band += np.maximum(*(np.abs(loads(name, end) - middle) for end in ends))
        band[np.broadcast_to(open_ended, band.shape[:-1])] = np.inf
    return ReactionLookup(
        *both_ends(middle),
        band=Reactions(*both_ends(band)),
        support=support_words(kind, gamma),
        inside=np.broadcast_to(inside, middle.shape[:-1]),
        remarks=tuple(dict.fromkeys(remark for one in found.values() for remark in one.remarks)),
    )


def throw_lengths(family: Family, given: Mapping[str, ArrayLike | str]) -> ThrowLengths:
    """Return the lengths of throws of a family, from given and fixed ones.

    Raises
    ------
    InputError
        If one is unknown.
    """
    checked = family.checked(given)
    known = family.completed(checked, family.size(checked))
    needed = ("crank_radius", "main_journal_length", "pin_length", "web_thickness")
    missing = [name for name in needed if name not in known]
    if missing:
        raise InputError(
            f"{missing[0]}: missing; reactions need it, because they are in equilibrium with the force on "
            "the pin."
        )
    radius, journal, pin, web = (known[name] for name in needed)
    left, right = (known.get(name, web) for name in _WEBS)
    to_pin = journal / 2.0 + left + pin / 2.0
    return ThrowLengths(to_pin + pin / 2.0 + right + journal / 2.0, to_pin, radius)


def both_ends(loads: Array) -> tuple[EndReaction, EndReaction]:
    """Return the reactions on the left and on the right end, from loads (..., 12)."""
    left, right = (
        EndReaction(loads[..., start : start + 3], loads[..., start + 3 : start + 6])
        for start in (0, 6)
    )
    return left, right


def checked_force(given: ArrayLike) -> Array:
    """Return forces (..., 3) on a pin, across the shaft [N].

    Raises
    ------
    InputError
    """
    force = finite_array("pin_force", given)
    if force.shape[-1:] != (3,):
        raise InputError(
            f"pin_force: given an array of shape {force.shape}; allowed are x, y and z in the throw frame "
            "[N], for many throws a row of them for each."
        )
    check_sizes("pin_force", force, LARGEST_LOAD)
    axial = force[..., 2].ravel()
    if np.any(axial):
        raise InputError(
            f"pin_force: given {axial[np.argmax(np.abs(axial))]:g} N along the shaft; allowed are forces "
            "across it, x and y, because the model covers no others: use analyze_throw for these and for "
            "moments on a pin."
        )
    return force


def checked_support(support: object) -> tuple[str, float | None]:
    """Return the kind of a support, as named in `NEEDED`, and the angle between neighbors [deg].

    Raises
    ------
    InputError
    """
    if isinstance(support, str) and support in ("pinned", "guided"):
        return support, None
    left, right = (getattr(support, f"{side}_deg", None) for side in ("left", "right"))
    if not isinstance(left, int | float) or not isinstance(right, int | float):
        raise InputError(
            f'support: given {support!r}; allowed are "pinned", "guided" or Neighbors(left_deg, right_deg), '
            "because reactions depend on it."
        )
    if (left - right) % 360.0:
        raise InputError(
            f"support: given Neighbors({left:g}, {right:g}); allowed are equal angles, because the model "
            "covers only throws in a helix: use analyze_throw for others."
        )
    return "neighbors", float(left)


def support_words(kind: str, gamma: float | None) -> str:
    """Describe the support of a throw."""
    return kind if gamma is None else f"between neighbors at {gamma:g} deg"


def _check_throws(model: "ModelContent", kind: str) -> None:
    """Refuse throws whose reactions do not follow from the model's numbers."""
    family, throw = model.family, model.throw
    names = [*family.factors, *family.relations, *family.fixed, *family.labels]
    part = next((name for name in names if name.startswith(_OTHER_PARTS)), None)
    if part is not None or (throw is not None and CrankThrow(**throw).symmetry == "full"):
        raise InputError(
            f"reactions: given a model of throws with {part or 'parts beside the crank plane'}; allowed are "
            "throws of one pin that are symmetric about the crank plane, because for others a force in "
            "that plane does not leave the ends in it: use analyze_throw."
        )
    if kind == "neighbors" and angle_law_remarks(family, throw):
        raise InputError(
            "support: given Neighbors to a model of throws that are not alike from both ends; allowed are "
            '"pinned" and "guided", because only equal webs have reactions in closed form between '
            "neighbors: use analyze_throw."
        )


def _check_shapes(force: Array, inside: NDArray[np.bool_]) -> None:
    try:
        np.broadcast_shapes(force.shape[:-1], inside.shape)
    except ValueError:
        raise InputError(
            f"pin_force: given an array of shape {force.shape} for dimensions of shape {inside.shape}; "
            "allowed are three numbers, or rows of them that can be broadcast with the dimensions."
        ) from None
