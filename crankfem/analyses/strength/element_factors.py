"""Factors of stress concentration of an engine's webs, read from the stresses of its throws."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.errors import InputError
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.response.loads import section_modulus
from dynamics.strength.concentration import CrankWeb, ElementFactors
from dynamics.strength.shrink_fit import ShrinkFit
from fem.fillet_peaks import FilletPeak, FilletStresses, largest_principal, principal_stresses
from fem.fillet_stress import FilletMesh, fillet_stresses
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
    webs = []
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
        webs.append(ThrowWeb(f"{side} web", web, 0.5 * (plate.start + plate.end)))
    return webs[0], webs[1]


def shrink_fit(
    throw: CrankThrow, section: StrengthSection, torque: float, youngs_modulus: float
) -> ShrinkFit | None:
    """Return the fit of a throw's journals under a torque [N m].

    The distance of pin and fit is the crank radius less their radii. None for a shaft of one
    piece, and if the torque is unbounded.
    """
    fit = section.shrink_fit
    if fit is None or not math.isfinite(torque):
        return None
    return ShrinkFit(
        fit.shrink_diameter,
        fit.shrink_length,
        fit.web_diameter,
        throw.main_journal_diameter,
        fit.fillet_radius,
        max(throw.crank_radius - 0.5 * (fit.shrink_diameter + throw.pin_diameter), 0.0),
        fit.web_yield,
        fit.journal_yield,
        torque,
        journal_bore=throw.main_journal_bore,
        friction=fit.friction,
        safety=fit.safety,
        youngs_modulus=youngs_modulus,
    )


# Wished accuracy of stresses that are calculated for factors.
ACCURACY = 0.05


def engine_stresses(engine: EngineFile, mesh: FilletMesh = "m53") -> dict[str, FilletStresses]:
    """Return the stresses of each distinct throw of an engine by its name; equal throws share theirs.

    Raises
    ------
    InputError
        If a throw has no fillet, or too small ones.
    MeshError, SolveError
        If a throw cannot be meshed or solved.
    """
    throws = {name: engine.named_throws[name] for name in engine.throw_names}
    stresses = {
        throw: fillet_stresses(throw, engine.material, ACCURACY, mesh=mesh)
        for throw in dict.fromkeys(throws.values())
    }
    return {name: stresses[throw] for name, throw in throws.items()}


def element_factors(
    stresses: FilletStresses, webs: Sequence[ThrowWeb]
) -> dict[str, ElementFactors]:
    """Return the factors of both webs of a throw with one pin, by the names of the webs.

    Parameters
    ----------
    stresses : FilletStresses
        On any mesh; that of Appendix III for factors that comply with the rule.
    webs : sequence of ThrowWeb
        Left and right.

    Notes
    -----
    Ends are rigid discs. The force of the three-point bending is uniform over the pin.
    """
    throw = stresses.throw
    if not isinstance(throw, CrankThrow):
        raise InputError(
            "stresses: given those of a CAD part; allowed are those of a throw by its dimensions, because "
            "nominal stresses refer to these."
        )
    (pin,) = throw.parts.pins
    length, force = throw.length, 0.5 * (pin.start + pin.end)
    holes = _hole_factors(stresses, webs[0], pin.name)
    elements = {}
    for throw_web in webs:
        web = throw_web.web
        names = {
            True: f"{pin.name}, {throw_web.name}",
            False: f"{throw_web.name.removesuffix(' web')} main journal",
        }

        def under(kind: str, on_pin: bool, names: Mapping[bool, str] = names) -> FilletPeak | None:
            """Return the largest stresses at a fillet of the web under a load."""
            each = (peak for peak in stresses.peaks if peak.name == names[on_pin])
            return next((peak for peak in each if peak.load.kind == kind), None)

        moduli = {
            True: float(section_modulus("torsional", web.pin_diameter, web.pin_bore)),
            False: float(section_modulus("torsional", web.journal_diameter, web.journal_bore)),
        }
        factors: dict[str, float | None] = {}
        for on_pin, greek in ((True, "alpha"), (False, "beta")):
            bent, twisted = under("bending", on_pin), under("torsion", on_pin)
            factors[f"{greek}_bending"] = (
                None if bent is None else bent.von_mises * web.bending_modulus
            )
            factors[f"{greek}_torsion"] = (
                None if twisted is None else twisted.shear * moduli[on_pin]
            )
        pressed, by_bending = under("radial", False), factors["beta_bending"]
        by_shear = combined = None
        if pressed is not None and by_bending is not None:
            # Of a unit force: the support beside the web takes its share, with the web's middle as lever.
            left = throw_web.middle < force
            reaction = (length - force) / length if left else force / length
            lever = throw_web.middle if left else length - throw_web.middle
            nominal = reaction * lever / web.bending_modulus
            shear = reaction / (web.web_width * web.section_thickness)
            by_shear = (pressed.von_mises - nominal * by_bending) / shear
            combined = pressed.von_mises / nominal
        elements[throw_web.name] = ElementFactors(
            web=web,
            beta_shear=by_shear,
            beta_combined=combined,
            error=stresses.error_estimate,
            as_ruled=stresses.rule_met,
            **factors,
            **holes,
        )
    return elements


def _hole_factors(
    stresses: FilletStresses, throw_web: ThrowWeb, pin: str
) -> dict[str, float | None]:
    """Return the factors of the oil hole in the pin, the larger of its exits."""
    loads = [load.kind for load in stresses.loaded.loads]
    modulus = float(
        section_modulus("torsional", throw_web.web.pin_diameter, throw_web.web.pin_bore)
    )
    bending, torsion = [], []
    for outlet in dict.fromkeys(peak.outlet for peak in stresses.hole_peaks):
        if outlet.drilling.journal != pin:
            continue
        surface = stresses.surface
        fields = surface.stress[outlet.holds(surface.points)]
        angle = math.radians(outlet.angle_deg)
        plane, across = (fields[:, loads.index(kind)] for kind in ("bending", "cross bending"))
        # Of both moments along these axes one bends the pin most at the hole, the other not at all there.
        for sine in (math.sin(angle), -math.sin(angle)):
            bending.append(_largest(math.cos(angle) * plane + sine * across) * 0.5 * modulus)
        torsion.append(_largest(fields[:, loads.index("torsion")]) * modulus)
    return {
        "gamma_bending": max(bending, default=None),
        "gamma_torsion": max(torsion, default=None),
    }


def _largest(stress: np.ndarray) -> float:
    return float(np.abs(largest_principal(principal_stresses(stress))).max())
