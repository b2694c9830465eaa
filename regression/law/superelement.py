r"""The superelement of a throw with equal webs from the law's numbers, and its reactions.

Mirrored in the crank plane and in the middle of its pin, such a throw has four classes of motions. Without
the rigid ones there are six, each with its load: lengthening under a force and twist under a torque; tilts of
both ends against each other (``in plane``) and alike (``across``) in the sense that couples with these;
and tilts alike in the crank plane and against each other across it, each alone in its class. With the ends
pinned their flexibilities are, E and D the unit::

    | e_p  g  |        | t_p  g' |
    | g   f_t |        | g'  f_u |        f_a        f_c

with g^2 = (e_p - e_g) f_t and g'^2 = (t_p - t_g) f_u of the compliances of guided ends, and rho = f_t / f_u.
A radial force Z lengthens the throw by c and tilts its ends by (c_p - c_g) f_t / g; a force along x twists
it like half of its torque R, and bends it across. So twelve numbers are the throw's superelement, and
with rigid motions its end forces balance the pin's exactly.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, finite_array
from crankbase.errors import InputError, quoted
from geometry.throw import CrankThrow
from regression.law.throw_law import OUTPUTS, POISSON_RATIO, LawAnswers

if TYPE_CHECKING:
    from fem.supports import Support
    from regression.models.lookup import ReactionLookup

UX, UY, UZ, RX, RY, RZ = range(6)
# All that the law answers but the volume.
NUMBERS = tuple(name for name in OUTPUTS if name != "volume")


def law_reactions(
    throw: CrankThrow,
    pin_force: ArrayLike,
    support: "Support" = "pinned",
    *,
    poisson_ratio: float = POISSON_RATIO,
) -> "ReactionLookup":
    """Reactions of the supports on a throw by the law, axial motion blocked.

    Parameters
    ----------
    throw : CrankThrow
        With equal webs.
    pin_force : (3,) array_like
        Force on the pin in the throw frame, none along the shaft [N]; the radial force Z is
        ``(0, -Z, 0)``.
    support : "pinned", "guided" or Neighbors
        The left end takes the torque.

    Returns
    -------
    ReactionLookup
        ``.left`` and ``.right``, each with ``.force`` [N] and ``.moment`` [N m] of shape (3,), and their
        errors.

    Raises
    ------
    InputError
        As `axial_law`; if the webs are unequal, the support is unknown, or the force is not three
        finite numbers of which the last is 0.
    """
    from fem.end_reactions import Reactions
    from regression.models.lookup import ReactionLookup, both_ends

    force = finite_array("pin_force", pin_force)
    if force.shape != (3,) or force[2] != 0.0:
        raise InputError(
            f"pin_force: given {quoted(pin_force)}; allowed are three numbers (x, y, 0), because the law "
            "covers only forces across the shaft."
        )
    if not throw.parts.mirrored:
        raise InputError(
            "throw: given one of unequal webs; allowed for reactions by the law are equal ones, because it "
            "covers only webs that are alike."
        )
    answers = LawAnswers.of_throw(throw, 1.0, poisson_ratio)
    numbers, widths = (answer.ravel() for answer in answers.values(NUMBERS))
    middle, band = _loads(throw, numbers, force, support), np.zeros(12)
    for place, width in enumerate(widths):
        ends = (
            _loads(throw, np.where(np.arange(len(numbers)) == place, end, numbers), force, support)
            for end in (numbers[place] * (1.0 - width), numbers[place] * (1.0 + width))
        )
        band += np.maximum(*(np.abs(end - middle) for end in ends))
    words = (
        support
        if isinstance(support, str)
        else (f"between neighbors at {support.left_deg:g} and {support.right_deg:g} deg")
    )
    return ReactionLookup(
        *both_ends(middle),
        band=Reactions(*both_ends(band)),
        support=words,
        inside=np.array(True),
        remarks=(),
    )


def _loads(throw: CrankThrow, numbers: Array, force: Array, support: "Support") -> Array:
    """Reactions (12,) on both ends by the numbers of a throw [N, N m]."""
    from fem.superelement import Superelement
    from fem.supports import reactions
    from fem.symmetry import RADIAL

    diameter = throw.main_journal_diameter
    stiffness, pin_loads = superelement(
        dict(zip(NUMBERS, numbers.tolist(), strict=True)),
        throw.crank_radius / diameter,
        throw.length / diameter,
    )
    # Lengths in D: forces stay, moments are F D.
    loads = np.zeros((1, 12, 6))
    loads[0, :, :2] = pin_loads
    reacting = reactions(
        Superelement(stiffness, loads, np.zeros((6, 6)), RADIAL[None]),
        support,
        loads[0, :, :3] @ force,
    )
    ends = [(end.force, end.moment * diameter) for end in (reacting.left, reacting.right)]
    return np.concatenate([part for end in ends for part in end])


def superelement(
    numbers: dict[str, float], crank_radius: float, length: float
) -> tuple[Array, Array]:
    """Stiffness (12, 12), and end loads (12, 2) of unit forces along x and y on the pin; lengths over D."""
    (axial, axial_guided, ratio, opening, opening_guided, twist, twist_guided, in_plane, alike, bent,
     bent_by_force) = (numbers[name] for name in NUMBERS)  # fmt: skip
    across = in_plane / ratio
    coupled = np.sqrt((axial - axial_guided) * in_plane)
    twisted = -np.sqrt((twist - twist_guided) * across)
    flexibility = np.diag([axial, twist, in_plane, across, alike, bent])
    flexibility[[0, 2], [2, 0]] = coupled
    flexibility[[1, 3], [3, 1]] = twisted
    stiffness = np.linalg.inv(flexibility)
    # Rows: lengthening, twist, and the tilts in the order of the flexibility, of end motions (12).
    motions = np.zeros((6, 12))
    motions[0, [UZ, 6 + UZ]] = motions[1, [RZ, 6 + RZ]] = -1.0, 1.0
    motions[2, [RX, 6 + RX]] = motions[5, [RY, 6 + RY]] = 1.0, -1.0
    motions[3, [RY, 6 + RY]] = motions[4, [RX, 6 + RX]] = 1.0, 1.0
    motions[3, [UX, 6 + UX]] = 2.0 / length, -2.0 / length
    motions[4, [UY, 6 + UY]] = -2.0 / length, 2.0 / length
    tilted = (opening - opening_guided) * in_plane / coupled
    half = 0.5 * crank_radius
    under_forces = np.array(
        [
            [0.0, -half * twist, 0.0, -half * twisted, 0.0, bent_by_force],
            [-opening, 0.0, -tilted, 0.0, 0.0, 0.0],
        ]
    ).T
    loads = motions.T @ stiffness @ under_forces
    # What of the forces the supports take at once.
    loads[[UX, 6 + UX], 0] += 0.5
    loads[[UY, 6 + UY], 1] += 0.5
    loads[RZ, 0] -= crank_radius
    return motions.T @ stiffness @ motions, loads
