"""Results of the law for a throw, without finite elements: values with their bands, or why there are none."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated

from crankbase.errors import InputError
from crankbase.quantity import percent
from crankbase.results import Quantity, Result, result
from crankbase.sentences import kept
from crankbase.table import SI, OutputUnits
from fem.material import Material
from geometry.any_throw import Throw, with_dimensions
from geometry.throw import CrankThrow
from regression.law.throw_law import AxialLaw, TorsionalLaw, throw_laws
from regression.models.angle import between_ends, fold_angle

if TYPE_CHECKING:
    from regression.models.lookup import Lookup, ReactionLookup

LAW = "law"
AXIAL, TORSIONAL = "axial_compliance", "torsional_compliance"
INFLUENCE = "influence_coefficient"
# Responses, as models name them, to the law's attributes and units.
_AXIAL = {
    AXIAL: ("pinned", "m/N"),
    f"{AXIAL}_guided": ("guided", "m/N"),
    INFLUENCE: ("influence_pinned", "m/N"),
    f"{INFLUENCE}_guided": ("influence_guided", "m/N"),
    "tilt_stiffness_ratio": ("ratio", ""),
}
_TORSIONAL = {TORSIONAL: ("pinned", "rad/(N m)"), f"{TORSIONAL}_guided": ("guided", "rad/(N m)")}


@result("value", "lower", "upper", "support")
class LawAnswer(Result):
    """One value of the law for a throw, with its band."""

    value: Annotated[float, Quantity(".unit")]
    lower: Annotated[float, Quantity(".unit")]
    upper: Annotated[float, Quantity(".unit")]
    unit: str
    support: str


def law_answers(
    throw: Throw, material: Material, gamma_deg: float | None = None
) -> dict[str, LawAnswer]:
    """Values of the law for a throw, with their bands.

    Parameters
    ----------
    gamma_deg : float, optional
        Angle between neighboring cranks [deg], for the axial compliance and the influence coefficient;
        by default pinned ends.

    Returns
    -------
    dict
        By the names of responses.

    Raises
    ------
    InputError
        If the law does not cover the throw or its material.
    """
    axial, torsional = throw_laws(
        with_dimensions(throw),
        youngs_modulus=material.youngs_modulus,
        poisson_ratio=material.poisson_ratio,
    )
    answers = end_answers(axial, torsional)
    return answers if gamma_deg is None else answers | neighbor_answers(axial, gamma_deg)


def end_answers(axial: AxialLaw, torsional: TorsionalLaw) -> dict[str, LawAnswer]:
    """Values of both laws with ends pinned and guided, as `law_answers` returns them."""
    answers: dict[str, LawAnswer] = {}
    for law, names in ((axial, _AXIAL), (torsional, _TORSIONAL)):
        for response, (name, unit) in names.items():
            support = "guided" if "guided" in name else "pinned" if unit else ""
            lower, upper = _band(law, name)
            answers[response] = LawAnswer(getattr(law, name), lower, upper, unit, support)
    return answers


def neighbor_answers(axial: AxialLaw, gamma_deg: float) -> dict[str, LawAnswer]:
    """Axial compliance and c between equal neighbors [deg]; their bands join those of three numbers."""
    support = f"between neighbors at {gamma_deg:g} deg"
    answers = {}
    for response, law in ((AXIAL, axial.axial), (INFLUENCE, axial.influence)):
        names = (_AXIAL[f"{response}_guided"][0], _AXIAL[response][0], "ratio")
        lower, upper = between_ends(fold_angle(gamma_deg), [_band(axial, name) for name in names])
        answers[response] = LawAnswer(float(law(gamma_deg)), lower, upper, "m/N", support)
    return answers


def _band(law: AxialLaw | TorsionalLaw, name: str) -> tuple[float, float]:
    value, error = getattr(law, name), law.errors[name]
    return value - error * abs(value), value + error * abs(value)


@result("answers", "reason")
class LawResults(Result):
    """Values of the law for a throw by the names of responses, or the reason why there are none."""

    answers: Mapping[str, LawAnswer] | None
    reason: str | None

    def sentence(self, units: OutputUnits = SI) -> str:
        """State the values with ends pinned, or why there are none."""
        if self.answers is None:
            return units.written(f"The law does not apply to this throw: {kept(self.reason or '')}")
        pinned, twist = self.answers[AXIAL], self.answers[TORSIONAL]
        axial, torsional = units.of("1e-9 m/N"), units.of("1e-9 rad/(N m)")
        width = percent(pinned.upper / pinned.value - 1.0)
        guided = axial.with_name(self.answers[f"{AXIAL}_guided"].value)
        return (
            f"By the law, without finite elements: e_n {axial.with_name(pinned.value)} within {width} %, "
            f"ends pinned ({guided} guided), torsional compliance "
            f"{torsional.with_name(twist.value)} pinned."
        )


def law_results(throw: Throw, material: Material, gamma_deg: float | None = None) -> LawResults:
    """Return `law_answers`, or why there are none."""
    try:
        return LawResults(law_answers(throw, material, gamma_deg), None)
    except InputError as error:
        return LawResults(None, str(error))


# What bands of the law cover; tests/validation/test_law.py counts the throws.
LAW_BANDS = (
    "Bands cover the error of the law and of its finite elements: of 100 random throws within the law's "
    "range 95 lie inside theirs, the others close to it. Bands hold for rigid end sections; real ones bend "
    "a little, which makes a throw softer."
)


@dataclass(frozen=True)
class LawLookups:
    """The law's results for one throw, in the form of lookups in a model.

    Attributes
    ----------
    answers : dict of str to Lookup
        By the names of responses.
    reactions : callable
        Force on the pin and support to reactions.
    """

    answers: "dict[str, Lookup]"
    reactions: "Callable[..., ReactionLookup]"


def law_lookups(
    throw: CrankThrow, material: Material, gamma_deg: float | None = None
) -> LawLookups:
    """Look a throw up by the law; arguments and errors as `law_answers`."""
    # Here: engines do without.
    from regression.law.superelement import law_reactions
    from regression.models.lookup import Lookup

    answers = {
        name: Lookup(
            **vars(answer),
            inside=True,
            remarks=(),
            error=None,
            fe_error=None,
            equation="networks of the law",
            band="95 of 100 throws with rigid end sections lie in it",
            symbol=name.replace("_", " "),
        )
        for name, answer in law_answers(throw, material, gamma_deg).items()
    }
    return LawLookups(answers, partial(law_reactions, throw, poisson_ratio=material.poisson_ratio))
