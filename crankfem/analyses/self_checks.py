"""The self-checks of a calculation: equilibrium, reciprocity, round-off, and errors against those allowed."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from crankbase.quantity import percent, tiny
from crankbase.results import Quantity, Result, result
from crankfem.analyses.study.study_results import FittedStudy
from crankfem.analyses.throw.throw_record import ThrowResults
from crankfem.analyses.vibration.whole_verdict import WholeVibration
from dynamics import wording
from fem.end_reactions import EndReaction
from fem.solver import LARGEST_ROUND_OFF, rigid_body_residual
from regression.response_kinds import AXIAL, TORSIONAL

Figure = Annotated[float | None, Quantity("1")]


@result("figure", "allowed", "met")
class Check(Result):
    """A self-check of a calculation.

    Parameters
    ----------
    unit, shown_unit : str
        "1" for a share, else a word; "%" shows a share that is more than round-off.
    allowed : float or None
        None where nothing is.
    met : bool or None
        None where the check does not judge.
    sentence : str
        What the figure means.
    """

    name: str
    figure: Figure
    unit: str
    shown_unit: str
    allowed: Figure
    met: bool | None
    sentence: str

    @property
    def figure_text(self) -> str:
        """The figure with its unit."""
        return self._text(self.figure)

    @property
    def allowed_text(self) -> str:
        """What is allowed."""
        if self.allowed is None:
            return "not bounded" if self.met is None else "by its criteria"
        return f"at most {self._text(self.allowed)}"

    def _text(self, figure: float | None) -> str:
        if figure is None:
            return "none"
        if self.shown_unit == "%":
            return f"{percent(figure)} %"
        return tiny(figure) if self.shown_unit == "1" else f"{figure:g} {self.shown_unit}".strip()


def unbalanced_share(
    ends: Sequence[EndReaction], places: ArrayLike, force: ArrayLike, at: ArrayLike
) -> float:
    """Return the unbalanced part of the reactions to a force, relative to its size.

    Parameters
    ----------
    ends : sequence of EndReaction
        Of the supports on the shaft.
    places : (ends, 3) array
        Their positions [m].
    force : (3,) array
        Force on the pin [N].
    at : (3,) array
        Position of its resultant [m].

    Returns
    -------
    float
        The larger of unbalanced force / force and unbalanced moment / (force x distance of the ends).
    """
    places, force, at = (np.asarray(vector, dtype=float) for vector in (places, force, at))
    forces = np.array([end.force for end in ends])
    moments = np.array([end.moment for end in ends])
    size = float(np.linalg.norm(force))
    arm = float(np.linalg.norm(places[-1] - places[0]))
    left_over = forces.sum(axis=0) + force
    turning = moments.sum(axis=0) + np.cross(places, forces).sum(axis=0) + np.cross(at, force)
    return max(
        float(np.linalg.norm(left_over)) / size, float(np.linalg.norm(turning)) / (size * arm)
    )


def check(
    name: str,
    figure: float | None,
    sentence: str,
    *,
    unit: str = "1",
    shown_unit: str | None = None,
    allowed: float | None = None,
    met: bool | None = None,
) -> Check:
    """Make a check; without `met`, the figure is compared with the permitted one."""
    if met is None and allowed is not None and figure is not None:
        met = abs(figure) <= allowed
    return Check(name, figure, unit, shown_unit or unit, allowed, met, sentence)


def throw_checks(throw: ThrowResults, length: float, pin_center: Sequence[float]) -> list[Check]:
    """Return the self-checks possible with the results of a throw.

    Parameters
    ----------
    length : float
        Of the throw [m].
    pin_center : (3,) sequence
        Middle of the first pin as it is meshed, in the throw frame [m].
    """
    stiffness = throw.stiffness
    radial = (0.0, -throw.radial_force, 0.0)
    worst = max(
        unbalanced_share(
            (support.reactions.left, support.reactions.right),
            ((0.0, 0.0, 0.0), (0.0, 0.0, length)),
            radial,
            pin_center,
        )
        for support in throw.supports.values()
    )
    reciprocity = throw.reciprocity
    assert reciprocity is not None
    return [
        check(
            "Error of the axial compliance",
            throw.error_estimate,
            "Error left after the correction for discretization: of 100 random throws tested, 95 had a "
            "smaller one."
            if throw.axial_correction
            else "Estimated from the finite-element stresses; the true compliance is larger by about this "
            "much.",
            shown_unit="%",
            allowed=throw.accuracy,
            met=throw.accuracy_met,
        ),
        check(
            "Rigid-body motions of the stiffness",
            rigid_body_residual(stiffness, length),
            "A rigid-body motion must cause no force: largest force found, relative to the largest "
            "stiffness.",
            allowed=LARGEST_ROUND_OFF,
        ),
        check(
            "Symmetry of the stiffness",
            reciprocity.asymmetry,
            "Reciprocity: largest difference between the stiffness from end-section forces and its "
            "transpose, relative to the largest stiffness. The stiffness used follows from strain energies "
            "and is always symmetric.",
            allowed=LARGEST_ROUND_OFF,
        ),
        check(
            "Equilibrium of the reactions",
            worst,
            "Residual of the forces and moments at both ends and the radial force at the middle of the "
            "meshed pin, for pinned and guided ends.",
            allowed=LARGEST_ROUND_OFF,
        ),
        check(
            "Axial reaction by reciprocity",
            reciprocity.axial_reaction,
            "Difference, relative to Z, between the axial reaction of the held ends to a radial force Z on "
            "the pin and c Z / e_n, with c from the motion of the pin when the ends are moved.",
            allowed=LARGEST_ROUND_OFF,
        ),
        check(
            "Elements mended",
            throw.mended_elements,
            "Elements turned inside out by the curved surface; all were straightened.",
            unit="elements",
        ),
    ]


def study_checks(study: FittedStudy | None) -> list[Check]:
    """Return the errors of the chosen equations at held-out designs."""
    chosen = {
        name.removesuffix("_compliance"): fits.selected()
        for name, fits in ({} if study is None else study.fits).items()
        if name in (AXIAL, TORSIONAL)
    }
    return [
        check(
            f"Error of the {kind} regression",
            fit.largest_heldout_error,
            f"Largest error of the chosen form ({fit.form}) at held-out designs.",
            shown_unit="%",
        )
        for kind, fit in chosen.items()
    ]


def chain_checks(whole: WholeVibration | None) -> list[Check]:
    """Compare the chains' first frequencies with those of the whole crankshaft."""
    checks = []
    for kind, chain in ({} if whole is None else whole.comparison.chains).items():
        first = chain.modes[0] if chain.modes else None
        shaft = None if first is None else first.shaft_frequency
        figure = None if first is None or shaft is None else first.chain_frequency / shaft - 1.0
        checks.append(
            check(
                f"The {kind} chain compared with the whole crankshaft",
                figure,
                f"First {kind} frequency of the chain compared with that of the whole crankshaft. "
                + (wording.ADEQUATE if chain.suffices else wording.INADEQUATE),
                shown_unit="%",
                # Frequencies, shares of the energy and amplitudes decide together.
                met=chain.suffices,
            )
        )
    return checks
