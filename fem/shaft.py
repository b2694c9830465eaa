"""Superelements in a row: a crankshaft, or a throw between its neighbors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.checks.arrays import finite_vector, refuse_crank_radians
from crankbase.checks.choices import check_choice
from crankbase.diagrams import display_unit, draw_groups, draw_matrix, new_axes, write_title
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.tables.frames import grid, table
from fem.superelement import RZ, UX, UY, UZ, Superelement

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Attributes of a shaft's compliances: SI unit, and what they are; the first three of each throw alone.
ALONE = ("axial", "torsional", "through")
SHOWN: Mapping[str, tuple[str, str]] = {
    "axial": ("m/N", "axial compliance"),
    "torsional": ("rad/(N m)", "torsional compliance"),
    "through": ("1/N", "lengthening per torque through the shaft"),
    "influence": ("m/N", "lengthening per radial force"),
    "tangential": ("m/N", "lengthening per tangential force"),
}


@summarized("axial [m/N]", "torsional [rad/(N m)]", "influence [m/N]")
@dataclass(frozen=True)
class ShaftCompliances:
    """Compliances and influence coefficients of each throw in a shaft.

    Each section is in its main bearing, laterally rigid or elastic, and tilts freely; the first one is
    held axially and against rotation; forces act along the whole shaft.

    Attributes
    ----------
    axial : (n,) array
        Lengthening of each throw per unit axial force through the shaft, e_n [m/N].
    torsional : (n,) array
        Twist of each throw per unit torque through the shaft [rad/(N m)].
    influence : (n, n) array
        Lengthening of throw i per unit radial force Z on the pin of throw j, the shaft axially free
        [m/N]; its diagonal is each throw's own c. Throws of several pins have a column for each of
        them: columns then follow the pins along the shaft, (n, all pins).
    tangential : (n, all pins) array
        The same per unit tangential force on a pin, in the sense of positive rotation about +z, its
        torque reacted at the first section [m/N].
    through : (n,) array
        Lengthening of each throw per unit torque about +z at the last section, reacted at the first
        [1/N].
    """

    axial: Array
    torsional: Array
    influence: Array
    tangential: Array
    through: Array

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        quantity: Literal["axial", "torsional", "through", "influence", "tangential"] = "axial",
    ) -> "Axes":
        """Draw one of the attributes: bars by throw, or a table colored by value.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        quantity : {"axial", "torsional", "through", "influence", "tangential"}
            The last two are tables of throws and pins.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If the quantity is unknown.
        """
        check_choice("quantity", quantity, SHOWN, "a shaft has these")
        unit, words = SHOWN[quantity]
        text, size = display_unit(unit)
        values = getattr(self, quantity) / size
        axes = new_axes(axes)
        throws = [str(number) for number in range(1, len(self.axial) + 1)]
        if values.ndim == 1:
            draw_groups(axes, throws, {words: values}, f"{words} [{text}]")
            write_title(axes, "Throws at their places in the shaft")
        else:
            pins = [str(number) for number in range(1, values.shape[1] + 1)]
            draw_matrix(axes, values, throws, pins)
            axes.set_ylabel("throw that is lengthened")
            write_title(axes, f"{words.capitalize()} [{text}]")
        axes.set_xlabel("throw" if values.ndim == 1 else "loaded pin")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of each throw's own values; `to_xarray` has those by pins and throws.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {"throw": (np.arange(1, len(self.axial) + 1), "")}
            | {name: (getattr(self, name), SHOWN[name][0]) for name in ALONE}
        )

    def to_xarray(self) -> Any:
        """Return all attributes over throws and pins, numbered from 1.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        return grid(
            {
                name: (("throw",) if name in ALONE else ("throw", "pin"), getattr(self, name), *how)
                for name, how in SHOWN.items()
            },
            {
                "throw": (np.arange(1, len(self.axial) + 1), "", "throw from the free end"),
                "pin": (np.arange(1, self.influence.shape[1] + 1), "", "pin from the free end"),
            },
        )


def sharing_sections(throws: Sequence[Superelement]) -> list[Superelement]:
    """Return throws as used in a shaft, with the same section motions.

    Those of the widest section, of the lowest degree that a throw was solved with. If adjacent journals
    differ in diameter or bore, both move as the same polynomials.
    """
    lowest = min((throw.joined.sections for throw in throws), key=lambda one: one.degree).sections
    joined = [throw.with_sections(lowest).joined for throw in throws]
    widest = max((throw.sections for throw in joined), key=lambda one: (one.radius, one.bore))
    return [throw.shared_with(widest) for throw in joined]


def shaft_unknowns(place: int, throws: int, bending: int) -> NDArray[np.int64]:
    """Unknowns of a throw by its index in a row: sections of six, then the motions beyond them."""
    beyond = 6 * (throws + 1) + bending * place
    return np.concatenate([6 * place + np.arange(12), beyond + np.arange(2 * bending)])


def assemble_shaft(throws: Sequence[Superelement]) -> Array:
    """Stiffness (n (s + 1), n (s + 1)) of s throws in a row, each already turned to its crank angle.

    Unknowns are the mean motions of the sections, six each, and then the motions of bending sections.
    """
    sections = throws[0].sections
    stiffness = np.zeros((sections.count * (len(throws) + 1),) * 2)
    for place, throw in enumerate(throws):
        own = shaft_unknowns(place, len(throws), sections.bending)
        stiffness[np.ix_(own, own)] += throw.stiffness
    return stiffness


def free_unknowns(sections: int) -> NDArray[np.int64]:
    """Unknowns left free by main bearings that hold every section laterally, the first one fully."""
    blocked = np.zeros((sections, 6), dtype=bool)
    blocked[:, [UX, UY]] = True
    blocked[0, [UZ, RZ]] = True
    return np.flatnonzero(~blocked.ravel())


def solve_shaft(
    throws: Sequence[Superelement], loads: Array, bearing_stiffness: ArrayLike = math.inf
) -> Array:
    """Solve for the section motions of a shaft in its main bearings.

    Parameters
    ----------
    throws : sequence of n Superelement
        Each already turned to its crank angle, all with the same section motions.
    loads : (u, k) array
        On the unknowns of `assemble_shaft`: forces and moments on the sections first. The first section is
        held axially and against rotation.
    bearing_stiffness : float or (n + 1,) array_like, optional
        Lateral, of each main bearing or of all [N/m]; ``math.inf`` for rigid ones. Zero for all is the limit
        of ever softer equal bearings, which carry the unbalanced part of the loads.

    Returns
    -------
    (u, k) array
        Motions; of a shaft without bearings relative to its first and last section.

    Raises
    ------
    InputError
        If a stiffness is negative or not a number, there is not one for each section, or just one is above
        zero, about which the shaft would swing.
    """
    sections = len(throws) + 1
    lateral = _lateral_stiffness(bearing_stiffness, sections)
    stiffness = assemble_shaft(throws)
    across = 6 * np.arange(sections)[:, None] + [UX, UY]
    size = len(stiffness)
    blocked = np.zeros(size, dtype=bool)
    blocked[[UZ, RZ]] = True
    if np.any(lateral > 0.0):
        elastic = np.isfinite(lateral)
        blocked[across[~elastic]] = True
        stiffness[across[elastic], across[elastic]] += lateral[elastic, None]
        return _solve(stiffness, loads, blocked)
    # The shaft is held at its ends, where no force is left once equal bearings have balanced the loads.
    ends = across[[0, -1]].ravel()
    blocked[ends] = True
    rigid = np.zeros((size, 4))
    rigid[ends] = np.eye(4)
    rigid[~blocked] = -np.linalg.solve(
        stiffness[np.ix_(~blocked, ~blocked)], stiffness[np.ix_(~blocked, ends)]
    )
    held = rigid[across.ravel()]
    balanced = np.array(loads, dtype=np.float64)
    balanced[across.ravel()] -= held @ np.linalg.solve(held.T @ held, rigid.T @ loads)
    return _solve(stiffness, balanced, blocked)


def _solve(stiffness: Array, loads: Array, blocked: NDArray[np.bool_]) -> Array:
    motions = np.zeros_like(loads, dtype=np.float64)
    motions[~blocked] = np.linalg.solve(stiffness[np.ix_(~blocked, ~blocked)], loads[~blocked])
    return motions


def _lateral_stiffness(given: ArrayLike, sections: int) -> Array:
    lateral = np.asarray(given, dtype=np.float64)
    if lateral.shape not in ((), (sections,)):
        raise InputError(
            f"bearing_stiffness: given an array of shape {lateral.shape}; allowed is one number for all, or "
            f"one for each of the {sections} sections, because throws side by side share a bearing."
        )
    lateral = np.broadcast_to(lateral, sections)
    if not np.all(lateral >= 0.0) or np.count_nonzero(lateral) == 1:
        raise InputError(
            f"bearing_stiffness: given {lateral.tolist()}; allowed are numbers of zero or more (infinite: "
            "rigid), two of them above zero or none, because a shaft in one bearing swings about it."
        )
    return lateral


def shaft_compliances(
    throws: Sequence[Superelement],
    *,
    crank_angles_deg: Sequence[float],
    bearing_stiffness: ArrayLike = math.inf,
) -> ShaftCompliances:
    """Find the compliances of each throw in a crankshaft.

    Parameters
    ----------
    throws : sequence of n Superelement
        From the free end, each in its own throw frame. Their sections bend where throws meet, if
        solved so, and are free at the ends of the shaft.
    crank_angles_deg : sequence of n float
        Angle of each crank about +z [deg].
    bearing_stiffness : float or (n + 1,) array_like, optional
        Lateral, of the main bearings; see `solve_shaft`.

    Returns
    -------
    ShaftCompliances

    Raises
    ------
    InputError
        If there is not one angle for each throw, or as `solve_shaft` for the bearings.

    Notes
    -----
    With rigid sections and without lateral restraint (zero) every throw has its pinned compliances, axial and
    torsional, whatever the angles to its neighbors, and nearly so with sections that bend: an axial force
    through the section centers and a torque about their line load each throw independently, so the
    common journal carries no bending moment and no lateral force, and tilts and moves freely.
    Only bearings that hold the journals on one line couple the throws.
    """
    if not throws or len(throws) != len(crank_angles_deg):
        raise InputError(
            f"crank_angles_deg: given {len(crank_angles_deg)} for {len(throws)} throws; allowed is "
            "one for each of at least one throw."
        )
    count = len(throws)
    angles = finite_vector("crank_angles_deg", crank_angles_deg).tolist()
    refuse_crank_radians("crank_angles_deg", angles)
    turned = [
        throw.turned(angle_deg=angle)
        for throw, angle in zip(sharing_sections(throws), angles, strict=True)
    ]
    sections = turned[0].sections
    size = sections.count * (count + 1)
    pulls = np.zeros((size, 2))
    pulls[[6 * count + UZ, 6 * count + RZ], [0, 1]] = 1.0

    def on_shaft(place: int, loads: Array) -> Array:
        found = np.zeros((size, loads.shape[1]))
        found[shaft_unknowns(place, count, sections.bending)] = loads
        return found

    radial = [on_shaft(place, throw.radial_loads) for place, throw in enumerate(turned)]
    tangential = [on_shaft(place, throw.tangential_loads) for place, throw in enumerate(turned)]
    loads = np.hstack([pulls, *radial, *tangential])
    motions = solve_shaft(turned, loads, bearing_stiffness)[: 6 * (count + 1)]
    stretch = np.diff(motions[UZ::6], axis=0)
    twist = np.diff(motions[RZ::6], axis=0)
    by_radial, by_tangential = np.split(stretch[:, 2:], 2, axis=1)
    return ShaftCompliances(stretch[:, 0], twist[:, 1], by_radial, by_tangential, stretch[:, 1])
