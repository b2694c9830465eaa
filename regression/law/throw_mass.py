"""The mass of a throw by the law: from a network of its ratios, without a solid."""

from dataclasses import dataclass

from crankbase.errors import InputError
from crankbase.summaries import summarized
from geometry.mass import check_density
from geometry.throw import CrankThrow
from regression.law.throw_law import POISSON_RATIO, LawAnswers


@summarized("mass [kg]", "band [kg]", "tier")
@dataclass(frozen=True)
class MassLaw:
    """Mass of a throw by the law.

    Attributes
    ----------
    mass : float
        [kg]
    error : float
        Relative half width of the band that holds the true value in 95 of 100 throws.
    tier : str
        "plain" or "real": whether the throw is a plain one.
    """

    mass: float
    error: float
    tier: str

    @property
    def band(self) -> tuple[float, float]:
        """Ends of the band that holds the true value in 95 of 100 throws [kg]."""
        return self.mass * (1.0 - self.error), self.mass * (1.0 + self.error)


def mass_law(throw: CrankThrow, *, density: float = 7850.0) -> MassLaw:
    """Mass of a throw by the law, between the middles of its main journals.

    Parameters
    ----------
    throw : CrankThrow
        Without counterweights.
    density : float
        [kg/m^3]

    Raises
    ------
    InputError
        As `axial_law`; and for counterweights, or a density that is not a positive number.

    Examples
    --------
    >>> throw = CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.012,
    ... )
    >>> print(f"{mass_law(throw).mass:.1f} kg")
    194.1 kg
    """
    check_density(density)
    webs = {"left_web.": throw.left_web, "right_web.": throw.right_web}
    for name, own in {"": throw, **webs}.items():
        if own is not None and own.counterweight is not None:
            raise InputError(
                f"throw.{name}counterweight: given one; allowed for the law's mass is none, because it gives "
                "the mass of throws without counterweights alone: use analyze_throw for others."
            )
    found = LawAnswers.of_throw(throw, 1.0, POISSON_RATIO)
    values, widths = found.values(("volume",))
    volume = float(values[0, 0]) * throw.main_journal_diameter**3
    return MassLaw(density * volume, float(widths[0, 0]), found.tier)
