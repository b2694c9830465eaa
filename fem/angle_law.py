r"""The angle between neighboring cranks in closed form: e(gamma) from three numbers of one throw.

Identical throws with equal webs in a row, each turned by gamma against the one before, all main
journals held laterally: a half turn about the crank's own axis y carries a throw into itself. So its
left end tilts by (t, u) about x and y when its right end tilts by (-t, u); and the right end of a throw
is the left end of the next, which is turned by gamma, whence u = t cot(gamma / 2). With k_t and k_u the
stiffness against these two tilts (lengthening and twist free), the energy of the tilts under an axial
force is that of k_t t^2 (1 + rho cot^2(gamma / 2)) with rho = k_u / k_t, and therefore::

    e(gamma) = e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma / 2))

The influence coefficient c follows the same law. rho = 1 makes it linear in cos gamma, as the angle
factors of most published formulas are; throws have rho of 1.7 to 3.3.

This is for rigid sections. Bending of sections rotates with multiples k of gamma, each constrained
like the tilts, a cos(k gamma / 2) and a sin(k gamma / 2): the energy has terms of several k, which no three
numbers contain. The law then goes through e(0), e(90) and e(180), with errors up to 0.4 % between.
"""

import math
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.array_checks import Array, finite_array
from crankbase.choices import check_choice
from crankbase.diagrams import BLUE, legend_inside, new_axes, write_title
from crankbase.errors import InputError, quoted
from crankbase.frames import Axes, grid, table
from crankbase.results import Internal, Quantity, Result, result
from fem.end_reactions import WORDS
from fem.plots import ANGLES_DEG, LABELS, SHOWN, Compliance, angle_axis
from fem.superelement import Superelement
from fem.supports import Neighbors, Support, SupportedThrow, support_throw
from fem.symmetry import MIRROR_X, MIRROR_Z

# A stiffness that its mirror image repeats within this share is symmetric.
SYMMETRIC = 1e-6


@result("in_line", "opposite", "ratio", eq=True)
class AngleNumbers(Result):
    """The three numbers of the axial compliance over the angle, with the stiffnesses against tilting.

    `ratio` is that across the crank plane divided by that in it, from e(90).
    """

    in_line: Annotated[float, Quantity("m/N", "between neighbors in line", key="e_0")]
    opposite: Annotated[float, Quantity("m/N", "between opposite neighbors", key="e_180")]
    ratio: Annotated[float, Quantity("1", key="rho")]


@result(
    "in_line", "opposite", "ratio", "influence_in_line [m/N]", "influence_opposite [m/N]", eq=True
)
class AngleLaw(AngleNumbers):
    """Axial compliance and influence coefficient of a throw over the angle to its neighbors.

    Exact for rigid sections; for those that bend at 0, 90 and 180 deg, and within 0.4 % between.

    Its influence coefficients are c_0 and c_180 [m/N].

    Raises
    ------
    InputError
        If a number is not finite, or a compliance or the ratio not above zero.
    """

    influence_in_line: Internal[float]
    influence_opposite: Internal[float]

    def __post_init__(self) -> None:
        for name in ("in_line", "opposite", "ratio", "influence_in_line", "influence_opposite"):
            value, signed = getattr(self, name), name.startswith("influence")
            if not math.isfinite(value) or not (signed or value > 0.0):
                kind = "finite number" if signed else "finite number above zero"
                raise InputError(
                    f"{name}: given {value:g}; allowed is a {kind}, as every throw has it."
                )

    def share(self, gamma_deg: ArrayLike) -> Array:
        """Position between in line (0) and opposite (1) at these angles [deg].

        Raises
        ------
        InputError
            If an angle is not a finite number.
        """
        half = np.deg2rad(finite_array("gamma_deg", gamma_deg)) / 2.0
        sine, cosine = np.sin(half) ** 2, np.cos(half) ** 2
        return np.asarray(sine / (sine + self.ratio * cosine))

    def axial(self, gamma_deg: ArrayLike) -> Array:
        """Axial compliance between neighbors at these angles [deg], e(gamma) [m/N]."""
        return np.asarray(self.in_line + (self.opposite - self.in_line) * self.share(gamma_deg))

    def influence(self, gamma_deg: ArrayLike) -> Array:
        """Influence coefficient between neighbors at these angles [deg], c(gamma) [m/N]."""
        change = self.influence_opposite - self.influence_in_line
        return np.asarray(self.influence_in_line + change * self.share(gamma_deg))

    def plot(
        self,
        axes: Axes | None = None,
        *,
        quantity: Literal["axial_compliance", "influence_coefficient"] = "axial_compliance",
    ) -> Axes:
        """Draw the law over the angle to the neighbors, 0 to 180 deg, with its two ends marked.

        Parameters
        ----------
        quantity : {"axial_compliance", "influence_coefficient"}

        Raises
        ------
        InputError
            If the quantity is unknown.
        """
        laws = self._over(ANGLES_DEG)
        check_choice("quantity", quantity, laws, "the law holds for these")
        values = laws[quantity] * SHOWN
        axes = new_axes(axes)
        axes.plot(ANGLES_DEG, values, color=BLUE, label=rf"law with $\rho$ = {self.ratio:.2f}")
        axes.plot([0.0, 180.0], values[[0, -1]], "o", color=BLUE, clip_on=False)
        angle_axis(axes)
        axes.set_ylim(bottom=min(0.0, 1.1 * float(values.min())))
        axes.set_ylabel(LABELS[quantity])
        write_title(axes, "Throw between equal neighbors")
        legend_inside(axes)
        return axes

    def to_pandas(self, gamma_deg: ArrayLike = ANGLES_DEG) -> Any:
        """Return a table of the law over angles.

        Parameters
        ----------
        gamma_deg : (n,) array_like
            Every 5 deg from 0 to 180 by default.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        InputError
            If an angle is not a finite number, or they are not one-dimensional.
        MissingLibraryError
            If pandas is not installed.
        """
        angles = _row_of_angles(gamma_deg)
        return table(
            {"gamma_deg": (angles, "deg")}
            | {name: (values, WORDS[name][0]) for name, values in self._over(angles).items()}
        )

    def to_xarray(self, gamma_deg: ArrayLike = ANGLES_DEG) -> Any:
        """Return the law over angles as an `xarray.Dataset`; parameters and errors as `to_pandas`."""
        angles = _row_of_angles(gamma_deg)
        return grid(
            {
                name: (("gamma_deg",), values, *WORDS[name])
                for name, values in self._over(angles).items()
            },
            {"gamma_deg": (angles, "deg", "angle between neighboring cranks")},
        )

    def _over(self, angles: NDArray[Any]) -> dict[str, Array]:
        return {
            "axial_compliance": self.axial(angles),
            "influence_coefficient": self.influence(angles),
        }


def angle_law(throw: Superelement) -> AngleLaw:
    """Find the angle law of a throw with equal webs.

    Raises
    ------
    InputError
        If the throw is not symmetric about the crank plane and the middle of its pin: then there is no
        closed form.
    """
    if not is_symmetric(throw):
        raise InputError(
            "throw: given one that is not symmetric about the crank plane and the middle of one pin; the "
            "angle law holds for equal webs only, for others use Neighbors(left_deg, right_deg)."
        )
    return effective_angle_law(throw)


def _row_of_angles(gamma_deg: ArrayLike) -> NDArray[Any]:
    """Return a row of angles, at least one; `AngleLaw.share` checks their values."""
    try:
        angles = np.atleast_1d(np.asarray(gamma_deg))
    except ValueError:  # rows of unequal length
        angles = np.zeros((0, 0))
    if angles.ndim != 1 or not angles.size:
        raise InputError(
            f"gamma_deg: given {quoted(gamma_deg)}; allowed are one or more angles in a row, because the "
            "table has a row for each."
        )
    return angles


def effective_angle_law(throw: Superelement) -> AngleLaw:
    """The angle law through e(0), e(90) and e(180), for equal webs and rigid sections exact between them."""
    in_line, opposite, ratio = between_neighbors(throw)
    return AngleLaw(
        in_line=in_line.axial,
        opposite=opposite.axial,
        ratio=ratio,
        influence_in_line=in_line.influence,
        influence_opposite=opposite.influence,
    )


def between_neighbors(throw: Superelement) -> tuple[SupportedThrow, SupportedThrow, float]:
    """Answer between equal neighbors in line and opposite, and by e(90) the ratio of the law (rho).

    No law holds for several pins, where e(gamma) is not e(-gamma): with pins 30 deg apart e(-60) may be 1.4
    times e(60), with a right angle between them e(90) is below e(0) and the ratio below zero.
    """
    in_line, quarter, opposite = (
        support_throw(throw, Neighbors(angle, angle)) for angle in (0.0, 90.0, 180.0)
    )
    ratio = (opposite.axial - quarter.axial) / (quarter.axial - in_line.axial)
    return in_line, opposite, ratio


def is_symmetric(throw: Superelement) -> bool:
    """Whether a throw of one pin is symmetric about the crank plane and the middle of that pin."""
    if len(throw.pin_loads) != 1:
        return False
    across_crank = np.diag(np.tile(MIRROR_X, 2))
    across_middle = np.kron([[0.0, 1.0], [1.0, 0.0]], np.diag(MIRROR_Z))
    size = np.sqrt(np.diag(throw.stiffness))
    for mirror in (across_crank, across_middle):
        change = np.abs(mirror @ throw.stiffness @ mirror.T - throw.stiffness)
        if not np.all(change <= SYMMETRIC * np.outer(size, size)):
            return False
    return True


def compliance(throw: Superelement, quantity: Compliance, support: Support) -> float:
    """Return one compliance of a throw under a support [m/N or rad/(N m)]."""
    answer = support_throw(throw, support)
    return {
        "axial_compliance": answer.axial,
        "torsional_compliance": answer.torsional,
        "influence_coefficient": answer.influence,
    }[quantity]


def compliance_over_angle(throw: Superelement, quantity: Compliance, gamma_deg: ArrayLike) -> Array:
    """Return a compliance (n,) over the angle to equal neighbors.

    Raises
    ------
    InputError
        If an angle is not finite.
    """
    angles = np.atleast_1d(finite_array("gamma_deg", gamma_deg))
    return np.array(
        [compliance(throw, quantity, Neighbors(angle, angle)) for angle in angles.tolist()]
    )
