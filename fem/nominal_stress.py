"""Nominal stresses, the reference of stress concentration factors.

They are those of the rules for marine crankshafts (IACS UR M53, Calculation of Crankshafts for I.C.
Engines, section 2) as far as these have them: bending refers to the section of the web, torsion to the
pin or the main journal. The web's section lies in the middle of the overlap of the two journals that it
joins, or of the gap between them: B is the width of the web's outline and h its thickness there,
without counterweights, bores and fillets. Definitions that the rules lack are our choice:

==================== ================================= ==================================
unit load            nominal stress                    symbols
==================== ================================= ==================================
axial force P        P a / (B h^2 / 6)                 a: distance from the shaft of the
                                                       pin's axis, which the force passes;
                                                       of a web between pins the larger
torque T             T / (pi (D^4 - d^4) / (16 D))     D, d: outside and bore of the pin,
                                                       at its fillets, or main journal
bending moment M     M / (B h^2 / 6)
in the crank plane
bending moment M     M / (pi (D^4 - d^4) / (32 D))     since it twists the web but bends
across it                                              the pin and the main journal
radial force Z       Z l1 l2 / L / (B h^2 / 6)         the simply supported throw's moment
                                                       at the middle of the web's thickness:
                                                       l1 from the bearing on that side, l2
                                                       of the force from the other bearing
==================== ================================= ==================================

At the exits of oil holes all of them refer to the section of the pin or main journal, as if there were no
hole: a torque to pi (D^4 - d^4) / (16 D), moments to half of it (UR M53, W_P and W_e of the factors gamma_T
and gamma_B), whichever way the hole points. The moment of an axial force is P a at a pin; in a main journal
it gives P / (pi (D^2 - d^2) / 4). That of a radial force is the simply supported throw's at the hole.

The first, the fourth and the choice of section for webs between pins are ours; the rules know neither an
axial force nor bending across the crank plane.
"""

import math
from dataclasses import dataclass

import numpy as np

from fem.fillets import Fillet
from fem.unit_loads import UnitLoad
from geometry.drilling import DrillingExit
from geometry.parts import Cylinder, ThrowParts, WebPlate


def nominal_hole_stress(parts: ThrowParts, outlet: DrillingExit, load: UnitLoad) -> float:
    """Nominal stress at an exit of an oil hole under a unit load.

    Parameters
    ----------
    parts : ThrowParts
    outlet : DrillingExit
        Of one of the throw's oil holes.
    load : UnitLoad

    Returns
    -------
    float
        [Pa/N] or [Pa/(N m)]; under a torque a shear stress.
    """
    hole = outlet.drilling
    journal = next(one for one in parts.cylinders if one.name == hole.journal)
    modulus = torsion_modulus(journal)
    if load.kind == "torsion":
        return 1.0 / modulus
    moment = 1.0
    if load.kind == "axial":
        if not journal.is_pin:
            return 1.0 / (math.pi * (journal.radius**2 - journal.bore_radius**2))
        moment = math.hypot(*journal.axis)
    elif load.kind == "radial":
        moment = _simply_supported(parts, hole.place, load)
    return moment / (0.5 * modulus)


def _simply_supported(parts: ThrowParts, place: float, load: UnitLoad) -> float:
    """Moment [N m/N] at z = `place` of a radial force on the throw simply supported at its ends."""
    assert load.pin is not None
    loaded = parts.pins[load.pin]
    force = 0.5 * (loaded.start + loaded.end)
    return min(place, force) * (parts.length - max(place, force)) / parts.length


@dataclass(frozen=True)
class WebSection:
    """Section of a web in the middle of the overlap or gap of the journals that it joins [m]."""

    width: float
    thickness: float

    @property
    def modulus(self) -> float:
        """Section modulus B h^2 / 6 against bending in the crank plane [m^3]."""
        return self.width * self.thickness**2 / 6.0


def web_section(parts: ThrowParts, web: WebPlate) -> WebSection:
    """Section of a web that nominal stresses refer to.

    Parameters
    ----------
    parts : ThrowParts
    web : WebPlate
        One of its webs, of some thickness.
    """
    number = parts.webs.index(web)
    before, after = parts.cylinders[number : number + 2]
    foot, tip = (before, after) if math.dist(before.axis, web.foot) == 0.0 else (after, before)
    middle = 0.5 * (foot.radius + web.distance - tip.radius)
    height = np.array([min(max(middle, 0.0), web.distance)])
    width = 2.0 * float(web.outline.half_width(height)[0])
    thickness = web.end - web.start - sum(float(s.depth(height)[0]) for s in web.slopes)
    return WebSection(width, thickness)


def torsion_modulus(journal: Cylinder) -> float:
    """Section modulus against torsion of a journal or pin, its bore taken as concentric [m^3]."""
    outer, bore = 2.0 * journal.radius, 2.0 * journal.bore_radius
    return math.pi * (outer**4 - bore**4) / (16.0 * outer)


def nominal_stress(parts: ThrowParts, fillet: Fillet, load: UnitLoad) -> float:
    """Nominal stress at a fillet under a unit load.

    Parameters
    ----------
    parts : ThrowParts
    fillet : Fillet
        One of the throw's.
    load : UnitLoad

    Returns
    -------
    float
        [Pa/N] or [Pa/(N m)]; under a torque a shear stress.
    """
    web = fillet.web
    if load.kind == "torsion":
        return 1.0 / torsion_modulus(fillet.journal)
    if load.kind == "cross bending":
        return 2.0 / torsion_modulus(fillet.journal)
    modulus = web_section(parts, web).modulus
    if load.kind == "bending":
        return 1.0 / modulus
    if load.kind == "axial":
        return max(math.hypot(*web.foot), math.hypot(*web.tip)) / modulus
    return _simply_supported(parts, 0.5 * (web.start + web.end), load) / modulus
