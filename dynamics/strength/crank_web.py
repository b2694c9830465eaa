"""A crank web with its pin, its journal and their fillets: the dimensions of UR M53."""

import math
from dataclasses import KW_ONLY, dataclass, fields

from crankbase.checks.arrays import nonnegative_number, positive_number
from crankbase.checks.choices import check_choice
from crankbase.errors import InputError
from crankbase.summaries import summarized

M53_SOURCE = (
    "IACS unified requirement M53 Rev.5, as carried into the Korean Register's Rules for Steel Ships 2025, "
    "Part 5 Guidance, Annex 5-3"
)
# Between these the rule's factors hold: lengths over the pin's diameter.
RANGES = {
    "overlap": ("s", -math.inf, 0.5),
    "web_thickness": ("w", 0.2, 0.8),
    "web_width": ("b", 1.1, 2.2),
    "pin_fillet_radius": ("r", 0.03, 0.13),
    "journal_fillet_radius": ("r", 0.03, 0.13),
    "pin_bore": ("d_H", 0.0, 0.8),
    "journal_bore": ("d_G", 0.0, 0.8),
    "oil_hole_diameter": ("d_O", 0.0, 0.2),
}
LENGTHS = ("pin_diameter", "journal_diameter", "crank_radius", "web_thickness", "web_width")
MAY_BE_ZERO = (
    *("pin_fillet_radius", "journal_fillet_radius", "pin_bore", "journal_bore"),
    *("pin_recess", "journal_recess", "oil_hole_diameter"),
)


@summarized("pin_diameter [m]", "journal_diameter [m]", "overlap [m]", "web_thickness [m]")
@dataclass(frozen=True)
class CrankWeb:
    """One web of a throw with the adjacent pin and main journal [m].

    Parameters
    ----------
    pin_diameter, journal_diameter : float
        D, D_G.
    crank_radius : float
        E.
    web_thickness, web_width : float
        W, B; of a semi-built crank B at the center of the pin's fillet.
    pin_fillet_radius, journal_fillet_radius : float
        R_H, R_G.
    pin_bore, journal_bore : float, optional
        D_BH, D_BG.
    pin_recess, journal_recess : float, optional
        T_H, T_G: depth to which the fillets are recessed into the web.
    oil_hole_diameter : float, optional
        D_O of a radial hole in the pin; 0 for none.
    semi_built : bool, optional
        Whether the journal is shrunk into the web: then it has no fillet to be assessed.

    Raises
    ------
    InputError
        If a length is not above zero (recesses, fillets and holes: negative), or a bore not smaller than
        its journal.
    """

    pin_diameter: float
    journal_diameter: float
    crank_radius: float
    web_thickness: float
    web_width: float
    pin_fillet_radius: float
    journal_fillet_radius: float
    _: KW_ONLY
    pin_bore: float = 0.0
    journal_bore: float = 0.0
    pin_recess: float = 0.0
    journal_recess: float = 0.0
    oil_hole_diameter: float = 0.0
    semi_built: bool = False

    def __post_init__(self) -> None:
        for name in LENGTHS:
            positive_number(name, getattr(self, name), "m", "it is a length")
        for name in MAY_BE_ZERO:
            nonnegative_number(name, getattr(self, name), "m", "it is a length")
        for part in ("pin", "journal"):
            bore, diameter = getattr(self, f"{part}_bore"), getattr(self, f"{part}_diameter")
            if bore >= diameter:
                raise InputError(
                    f"{part}_bore: given {bore:g} m; allowed is less than the diameter of {diameter:g} m, "
                    "because a wall is left."
                )
        if self.section_thickness <= 0.0:
            raise InputError(
                f"pin_recess: given {self.pin_recess:g} m; allowed is less than web thickness and pin fillet "
                f"radius together, {self.web_thickness + self.pin_fillet_radius:g} m, because a web is left."
            )

    @property
    def overlap(self) -> float:
        """S of pin and journal, negative without overlap [m]."""
        return 0.5 * (self.pin_diameter + self.journal_diameter) - self.crank_radius

    @property
    def section_thickness(self) -> float:
        """W, reduced by a recess deeper than the pin's fillet if pin and journal do not overlap [m].

        W_red = W - (T_H - R_H), of semi-built cranks at any overlap.
        """
        cut = self.pin_recess - self.pin_fillet_radius
        reduced = (self.semi_built or self.overlap < 0.0) and cut > 0.0
        return self.web_thickness - cut if reduced else self.web_thickness

    @property
    def bending_modulus(self) -> float:
        """W_eqw = B W^2 / 6 of the web's section [m^3]."""
        return self.web_width * self.section_thickness**2 / 6.0

    def ratio(self, name: str) -> float:
        """Return a length over the diameter of the pin; the web's thickness as of `section_thickness`.

        Raises
        ------
        InputError
            If the web has no length of that name.
        """
        names = [one.name for one in fields(self) if one.name != "semi_built"]
        check_choice("name", name, [*names, "overlap"], "these are the lengths of a crank web")
        length = "section_thickness" if name == "web_thickness" else name
        return float(getattr(self, length)) / self.pin_diameter

    def place_radius(self, place: str) -> tuple[float, float]:
        """Return the diameter and the radius that determine the strength of a fillet or oil hole [m]."""
        check_choice("place", place, PLACES, "the rule judges these")
        return {
            "pin fillet": (self.pin_diameter, self.pin_fillet_radius),
            "journal fillet": (self.journal_diameter, self.journal_fillet_radius),
            "oil hole": (self.pin_diameter, 0.5 * self.oil_hole_diameter),
        }[place]


PLACES = ("pin fillet", "journal fillet", "oil hole")


def check_ranges(web: CrankWeb) -> None:
    """Refuse a web for which the rule has no factors of stress concentration.

    Raises
    ------
    InputError
        With the ratio that is outside.
    """
    for name in RANGES:
        if web.semi_built and name == "journal_fillet_radius":
            continue
        check_ratio(f"{name} over pin_diameter", name, web.ratio(name))
    if not web.semi_built:
        own = web.journal_fillet_radius / web.journal_diameter
        check_ratio("journal_fillet_radius over journal_diameter", "journal_fillet_radius", own)


def check_ratio(what: str, name: str, value: float, lowest: float | None = None) -> None:
    """Refuse a ratio outside its range, or below the `lowest` of one factor.

    Raises
    ------
    InputError
    """
    symbol, low, high = RANGES[name]
    low = low if lowest is None else lowest
    slack = 1e-12
    if low - slack <= value <= high + slack:
        return
    allowed = f"{low:g} to {high:g}" if math.isfinite(low) else f"up to {high:g}"
    raise InputError(
        f"{what} ({symbol}): given {value:.4g}; allowed is {allowed}, because the formulas of UR M53 hold "
        "there alone; use finite elements."
    )
