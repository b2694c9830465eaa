"""The two webs of an engine's throw for UR M53."""

import math
from dataclasses import dataclass

from crankfem.files.sections.strength_section import StrengthSection
from dynamics.strength.crank_web import CrankWeb
from dynamics.strength.shrink_fit import ShrinkFit
from geometry.throw import CrankThrow
from geometry.throw_dimensions import web_dimension


@dataclass(frozen=True)
class ThrowWeb:
    """A web of a throw, and its position.

    Attributes
    ----------
    name : {"left web", "right web"}
    web : CrankWeb
    middle : float
        Of its thickness, from the middle of the left main journal [m].
    """

    name: str
    web: CrankWeb
    middle: float


def throw_webs(throw: CrankThrow, section: StrengthSection) -> tuple[ThrowWeb, ThrowWeb]:
    """Return the webs of a throw with one pin."""
    left, pin, right = throw.parts.cylinders
    found = []
    for side, plate, journal, fillets in (
        ("left", throw.parts.webs[0], left, (pin.start_fillet, left.end_fillet)),
        ("right", throw.parts.webs[1], right, (pin.end_fillet, right.start_fillet)),
    ):
        web = CrankWeb(
            pin_diameter=2.0 * pin.radius,
            journal_diameter=2.0 * journal.radius,
            crank_radius=throw.crank_radius,
            web_thickness=plate.end - plate.start,
            web_width=web_dimension(throw, f"{side}_web", "width")[1],
            pin_fillet_radius=fillets[0],
            journal_fillet_radius=fillets[1],
            pin_bore=2.0 * pin.bore_radius,
            journal_bore=2.0 * journal.bore_radius,
            pin_recess=section.pin_recess,
            journal_recess=section.journal_recess,
            oil_hole_diameter=section.oil_hole_diameter or 0.0,
            semi_built=section.shrink_fit is not None,
        )
        found.append(ThrowWeb(f"{side} web", web, 0.5 * (plate.start + plate.end)))
    return found[0], found[1]


def shrink_fit(
    throw: CrankThrow, section: StrengthSection, torque: float, youngs_modulus: float
) -> ShrinkFit | None:
    """Return the fit of a throw's journals under a torque [N m].

    The distance of pin and fit is the crank radius less their radii. None for a shaft of one
    piece, and if the torque is unbounded.
    """
    given = section.shrink_fit
    if given is None or not math.isfinite(torque):
        return None
    return ShrinkFit(
        given.shrink_diameter,
        given.shrink_length,
        given.web_diameter,
        throw.main_journal_diameter,
        given.fillet_radius,
        max(throw.crank_radius - 0.5 * (given.shrink_diameter + throw.pin_diameter), 0.0),
        given.web_yield,
        given.journal_yield,
        torque,
        journal_bore=throw.main_journal_bore,
        friction=given.friction,
        safety=given.safety,
        youngs_modulus=youngs_modulus,
    )
