"""Assumptions of the assessment of a crankshaft's strength by UR M53."""

from collections.abc import Iterator, Sequence

from crankbase.units.units import RPM
from crankfem.analyses.strength.shaft_loads import HIGHEST_ORDER, ShaftLoads
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.assessment.limit_sentences import shown_range
from dynamics.strength.concentration import COEFFICIENTS, DOUBTFUL, coefficient_differences
from dynamics.strength.crank_web import CrankWeb
from dynamics.strength.element_factors import ElementFactors


def strength_remarks(
    vibration: EngineVibration,
    section: StrengthSection,
    loads: ShaftLoads,
    webs: Sequence[CrankWeb],
    judged: Sequence[CrankWeb],
    elements: Sequence[ElementFactors],
) -> Iterator[str]:
    """State the assumptions, a sentence each.

    Parameters
    ----------
    vibration : EngineVibration
    section : StrengthSection
    loads : ShaftLoads
    webs : sequence of CrankWeb
        Of all throws.
    judged : sequence of CrankWeb
        Those that have factors by the formulas.
    elements : sequence of ElementFactors
        Of all webs that have factors by finite elements.
    """
    file = vibration.engine_file
    engine, asked = file.engine, HIGHEST_ORDER[file.engine.strokes]
    yield (
        f"bending is due to the rods' forces at rated speed, {RPM * engine.rated_speed:.4g} 1/min, each "
        "throw supported separately"
    )
    left_out = ", ".join(shown_range(*one) for one in loads.barred)
    yield (
        f"torsion is the largest from {shown_range(engine.lowest_speed, engine.highest_speed)}"
        f"{f' without {left_out}, which the verdict bars' if left_out else ''}, orders up to "
        f"{min(asked, file.vibration.highest_order):g} summed over the cycle, "
        f"{'in normal firing and while cylinders misfire' if loads.misfiring else 'in normal firing'}"
    )
    if not loads.misfiring:
        yield f"{vibration.misfiring_note or 'misfiring is not calculated'}; the rule requires it"
    if file.vibration.highest_order < asked:
        yield (
            f"the rule requires orders up to {asked:g}: those above {file.vibration.highest_order:g} are not "
            "calculated (vibration.highest_order)"
        )
    if section.axial_vibration == "calculated":
        yield (
            "the calculated axial force bends the web with the crank radius as lever arm, the largest "
            "possible; this replaces the rule's 20 MPa"
        )
    if section.oil_hole_diameter is not None and section.oil_hole_angle is None:
        yield "the oil hole's outlet is assumed where the pin's bending stress is largest"
    if any(throw.pin_bore_offset or throw.main_journal_bore_offset for throw in file.crank_throws):
        yield "eccentric bores are treated as concentric"
    if any(web.slopes for throw in file.crank_throws for web in throw.parts.webs):
        yield "tapered webs are used with their full thickness"
    if any(web.overlap < 0.0 for web in webs):
        yield (
            "pin and journal do not overlap: the web section is assumed at mid-thickness, because the "
            "rule's own figure was not available"
        )
    if elements:
        met = "meet" if all(own.as_ruled for own in elements) else "do not meet"
        yield (
            "finite elements: ends are rigid discs, the force in three-point bending is distributed over "
            "the pin; beta_Q follows method 1 of Appendix III, as the difference of two large numbers; mesh "
            f"and stresses {met} the criteria of the rule's Appendix III at every fillet"
        )
    changes = dict.fromkeys(
        f"{name} {100.0 * one:+.2g} %"
        for web in judged
        for name, one in coefficient_differences(web).items()
    )
    if changes:
        (cubic, square), (other_cubic, other_square) = (DOUBTFUL[one] for one in COEFFICIENTS)
        yield (
            f"two coefficients are doubtful, the {section.coefficients} ones are used: {other_cubic:g} in "
            f"place of the printed {cubic:g}, and {other_square:g} in place of {square:g}, would change "
            f"{', '.join(changes)}"
        )
    yield "the formulas come from one text of the rule; no second source confirms their coefficients"
