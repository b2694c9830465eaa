"""One location next to a web, from its nominal stresses to strength over equivalent stress."""

from collections.abc import Iterator
from dataclasses import dataclass

from crankfem.analyses.strength.throw_webs import ThrowWeb
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.response.loads import section_modulus
from dynamics.strength.concentration import ConcentrationFactors
from dynamics.strength.element_factors import ElementFactors
from dynamics.strength.fatigue import (
    MANUFACTURE,
    PlaceStrength,
    added_bending,
    fatigue_strength,
    fillet_equivalent,
    hole_equivalent,
)
from dynamics.strength.surface_treatment import factors_below


@dataclass(frozen=True)
class JudgedCase:
    """A location next to a web, with its loads: nominal stresses [Pa], torque [N m], axial force [N]."""

    throw: int
    place: str
    own: ThrowWeb
    factors: ConcentrationFactors | ElementFactors
    bending: float
    shear: float
    torque: float
    axial: float | None


def judged_places(case: JudgedCase, section: StrengthSection) -> Iterator[PlaceStrength]:
    """Return the location at its surface, and if hardened at the transition below too."""
    web, place = case.own.web, case.place
    on_bending, on_shear, on_torsion = case.factors.at(place)
    sizes = web.pin_diameter, web.pin_bore
    if place == "journal fillet":
        sizes = web.journal_diameter, web.journal_bore
    torsion = case.torque / float(section_modulus("torsional", *sizes))
    added = 0.0
    if place != "oil hole":
        of_axial = None
        if case.axial is not None:
            # The force bends the web most at the pin's axis.
            moment = case.axial * web.crank_radius
            of_axial = on_bending * moment / web.bending_modulus
        added = added_bending(section.piston, of_axial)
    factor = MANUFACTURE[section.manufacture][place == "oil hole"]
    strength = fatigue_strength(section.tensile_strength, *web.place_radius(place), factor)
    layers = [(0.0, on_bending, on_torsion, strength)]
    hardened = section.hardening
    if hardened is not None and place in hardened.places:
        treatment = hardened.treatment()
        depth = treatment.transition
        layers = [
            (0.0, on_bending, on_torsion, treatment.surface_strength),
            (
                depth,
                *factors_below(case.factors, place, depth),
                treatment.transition_strength(strength),
            ),
        ]
    for depth, of_bending, of_torsion, bears in layers:
        local = of_bending * case.bending + on_shear * case.shear
        equivalent = (
            hole_equivalent(local, of_torsion * torsion)
            if place == "oil hole"
            else fillet_equivalent(local, of_torsion * torsion, added)
        )
        yield PlaceStrength(
            throw=case.throw,
            place=place,
            web="" if place == "oil hole" else case.own.name,
            depth=depth,
            nominal_bending=case.bending,
            nominal_shear=case.shear,
            nominal_torsion=torsion,
            bending=local,
            torsion=of_torsion * torsion,
            added=added,
            equivalent=equivalent,
            strength=bears,
        )
