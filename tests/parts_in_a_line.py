"""Cylinders and crank throws whose usual values stand on a line, in the order of the field."""

from dynamics.engine.layout import EngineCylinder
from geometry.throw import CrankThrow


def cylinder(bore, piston_mass, rod, crank=0.0, bank=0.0, position=0.0, **more):
    """Crank and bank angle are in degrees, all else in SI units."""
    return EngineCylinder(
        bore,
        piston_mass,
        rod,
        crank_angle_deg=crank,
        bank_angle_deg=bank,
        position=position,
        **more,
    )


def crank_throw(radius, journal, pin, journal_length, pin_length, width, thickness, **more):
    """Diameters of main journal and crankpin, width and thickness of the webs, all in m."""
    return CrankThrow(
        crank_radius=radius,
        main_journal_diameter=journal,
        pin_diameter=pin,
        main_journal_length=journal_length,
        pin_length=pin_length,
        web_width=width,
        web_thickness=thickness,
        **more,
    )
