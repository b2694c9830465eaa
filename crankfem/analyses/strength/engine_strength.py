"""Strength of a crankshaft by UR M53: factors and shrink fits of its webs, judged throw by throw."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from typing import Annotated, Any

import numpy as np

from crankbase.errors import InputError
from crankbase.frames import DataFrame, table_of
from crankbase.quantity import UNBOUNDED, percent
from crankbase.results import Flat, Internal, Number, Part, Quantity, Result, result
from crankbase.sentences import amount, kept
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.strength.cycle_loads import (
    HIGHEST_ORDER,
    LargestLoad,
    ShaftLoads,
    shaft_loads,
    supported_throws,
)
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.response.loads import section_modulus
from dynamics.strength.concentration import (
    COEFFICIENTS,
    DOUBTFUL,
    FACTORS,
    M53_SOURCE,
    PLACES,
    RANGES,
    SYMBOLS,
    ConcentrationFactors,
    CrankWeb,
    ElementFactors,
    SupportedThrow,
    coefficient_differences,
    hole_stress,
    unsafe_formulas,
    web_stresses,
)
from dynamics.strength.fatigue import (
    MANUFACTURE,
    REQUIRED,
    PlaceStrength,
    added_bending,
    factors_below,
    fatigue_strength,
    fillet_equivalent,
    hole_equivalent,
)
from dynamics.strength.shrink_fit import ShrinkFit
from dynamics.wording import at_speed, speed_range
from fem.fillet_peaks import FilletPeak, FilletStresses, largest_principal, principal_stresses
from fem.fillet_stress import FilletMesh, fillet_stresses
from geometry.any_throw import dimensioned, with_dimensions
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


@dataclass(frozen=True)
class JudgedCase:
    """A location next to a web, with its loads: nominal stresses [Pa], torque [N m], axial force [N]."""

    throw: int
    place: str
    web: ThrowWeb
    factors: ConcentrationFactors | ElementFactors
    bending: float
    shear: float
    torque: float
    axial: float | None


def judged_places(case: JudgedCase, section: StrengthSection) -> Iterator[PlaceStrength]:
    """Return the location at its surface, and if hardened at the transition below too."""
    web, place = case.web.web, case.place
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
            web="" if place == "oil hole" else case.web.name,
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
        f"bending is due to the rods' forces at rated speed, {at_speed(engine.rated_speed)}, each "
        "throw supported separately"
    )
    left_out = ", ".join(speed_range(*speeds) for speeds in loads.barred)
    yield (
        f"torsion is the largest from {speed_range(engine.lowest_speed, engine.highest_speed)}"
        f"{f' without {left_out}, which the verdict bars' if left_out else ''}, orders up to "
        f"{min(asked, file.vibration.highest_order):g} summed over the cycle, "
        f"{'in normal firing and while cylinders misfire' if loads.misfiring else 'in normal firing'}"
    )
    if not loads.misfiring:
        note = kept(vibration.misfiring_note or "misfiring is not calculated")
        yield f"{note}; the rule requires it"
    if file.vibration.highest_order < asked:
        yield (
            f"the rule requires orders up to {asked:g}: those above {file.vibration.highest_order:g} are not "
            "calculated (vibration.highest_order)"
        )
    if section.axial_vibration == "calculated":
        yield (
            "the calculated axial force bends the web with the crank radius as lever arm, the largest "
            f"possible; this replaces the rule's {amount(20e6, 'Pa')}"
        )
    if section.oil_hole_diameter is not None and section.oil_hole_angle is None:
        yield "the oil hole's outlet is assumed where the pin's bending stress is largest"
    known = dimensioned(file.named_throws).values()
    if any(throw.pin_bore_offset or throw.main_journal_bore_offset for throw in known):
        yield "eccentric bores are treated as concentric"
    if any(web.slopes for throw in known for web in throw.parts.webs):
        yield "tapered webs are used with their full thickness"
    if any(web.overlap < 0.0 for web in webs):
        yield (
            "pin and journal do not overlap: the web section is assumed at mid-thickness, because the "
            "rule's own figure was not available"
        )
    if elements:
        met = "meet" if all(factors.as_ruled for factors in elements) else "do not meet"
        yield (
            "finite elements: ends are rigid discs, the force in three-point bending is distributed over "
            "the pin; beta_Q follows method 1 of Appendix III, as the difference of two large numbers; mesh "
            f"and stresses {met} the criteria of the rule's Appendix III at every fillet"
        )
    changes = dict.fromkeys(
        f"{name} {percent(change, 2, signed=True)} %"
        for web in judged
        for name, change in coefficient_differences(web).items()
    )
    if changes:
        (cubic, square), (other_cubic, other_square) = (DOUBTFUL[kind] for kind in COEFFICIENTS)
        yield (
            f"two coefficients are doubtful, the {section.coefficients} ones are used: {other_cubic:g} in "
            f"place of the printed {cubic:g}, and {other_square:g} in place of {square:g}, would change "
            f"{', '.join(changes)}"
        )
    yield "the formulas come from one text of the rule; no second source confirms their coefficients"


# Factors that agree to so many decimals are equal: the place nearest to the free end stands first.
EQUAL = 9


@result("ratios", "factors")
class WebFactors(Result):
    """Ratios and factors of a web; None for factors that the rule or the mesh lacks."""

    ratios: Annotated[dict[str, float], Quantity("1")]
    factors: Annotated[dict[str, float | None], Quantity("1")]
    finite_elements: Annotated[dict[str, Any] | None, Quantity("1")]


@result("number", "torque.value", "places")
class ThrowStrength(Result):
    """Strength of one throw.

    Attributes
    ----------
    number : int
        From 1 at the free end.
    places : tuple of PlaceStrength
        Pin fillet, journal fillet and oil hole, if present and if the rule has factors: each
        next to the web, and if hardened at the depth with the least acceptability.
    torque : LargestLoad
        Alternating, the largest next to the throw.
    fit : ShrinkFit or None
        Of the journals of a semi-built shaft.
    sides : tuple of ThrowWeb
        The left and the right web; empty if read from a file, as what follows.
    factors : dict of str to ConcentrationFactors
        Of each web by its name, where the rule's formulas apply.
    elements : dict of str to ElementFactors
        By finite elements, if stresses were calculated.
    left_out : tuple of str
        Where the rule has no formula and why, as in `EngineStrength.left_out` after the throws.
    """

    number: Annotated[int, Quantity("1", key="throw")]
    torque: Flat[LargestLoad]
    places: tuple[PlaceStrength, ...]
    webs: dict[str, WebFactors]
    fit: Annotated[ShrinkFit | None, Quantity(key="shrink_fit")]
    sides: Internal[tuple[ThrowWeb, ...]] = ()
    factors: Internal[dict[str, ConcentrationFactors]] = field(default_factory=dict)
    elements: Internal[dict[str, ElementFactors]] = field(default_factory=dict)
    left_out: Internal[tuple[str, ...]] = ()


@result("sentence", "passed", "remarks")
class EngineStrength(Result):
    """Strength of an engine's crankshaft by UR M53.

    Attributes
    ----------
    throws : tuple of ThrowStrength
        From the free end.
    remarks : tuple of str
        Assumptions, a sentence each.
    left_out : tuple of str
        What could not be judged and why, a sentence each, with the throws concerned.
    unsafe : tuple of str
        Where a formula gives a smaller factor than finite elements, a sentence each.
    warning : str
        Which formulas do, with the largest difference; or "".
    by_elements : bool
        Whether the factors of stress concentration are those of finite elements.
    source : str
        Of the formulas.
    """

    throws: tuple[ThrowStrength, ...]
    remarks: tuple[str, ...]
    left_out: tuple[str, ...]
    unsafe: tuple[str, ...]
    warning: str
    by_elements: bool
    source: str = M53_SOURCE

    @property
    def required_factor(self) -> Number:
        """The least acceptability factor."""
        return REQUIRED

    @property
    def places(self) -> tuple[PlaceStrength, ...]:
        """Those of all throws, the one with the least acceptability first."""
        places = (place for throw in self.throws for place in throw.places)
        return tuple(sorted(places, key=lambda place: round(place.acceptability, EQUAL)))

    @property
    def passed(self) -> Part[bool | None]:
        """Whether all locations and fits are acceptable; None if some could not be judged."""
        fits = all(throw.fit is None or throw.fit.passed for throw in self.throws)
        if not fits or not all(place.passed for place in self.places):
            return False
        return None if self.left_out else True

    @property
    def sentence(self) -> Part[str]:
        """The finding, with the decisive location."""
        unjudged = self.left_out
        if not self.places:
            return f"Crankshaft strength by UR M53 is not judged: {kept(unjudged[0])}"
        least, wrong = self.places[0], sum(not place.passed for place in self.places)
        how = ", factors by finite elements" if self.by_elements else ""
        text = (
            f"Crankshaft strength by UR M53{how}: the least acceptability factor is {shown_factor(least)} "
            f"at the {least.place} of throw {least.throw}, {REQUIRED:g} is required"
        )
        count = len(self.places)
        text += (
            f"; {wrong} of {count} locations {'is' if wrong == 1 else 'are'} below it."
            if wrong
            else f"; all {count} reach it."
        )
        fits = [throw for throw in self.throws if throw.fit is not None and not throw.fit.passed]
        if fits and fits[0].fit is not None:
            text += f" Shrink fit of throw {fits[0].number}: {kept(fits[0].fit.refusals[0])}."
        return f"{text} Not judged: {kept(unjudged[0])}" if unjudged else text

    def to_pandas(self) -> DataFrame:
        """Return a row for each location, the one with the least acceptability first.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.places)


def engine_strength(
    vibration: EngineVibration,
    *,
    stresses: Mapping[str, FilletStresses] | None = None,
) -> EngineStrength:
    """Assess the strength of an engine's crankshaft by UR M53.

    Parameters
    ----------
    vibration : EngineVibration
        From `engine_vibration`, of an engine with the section [strength]: its torques, barred ranges and
        axial forces.
    stresses : mapping, optional
        Of each distinct throw by its name: factors by finite elements are reported with the formulas'.
        They are calculated, by Appendix III, if ``strength.factors`` selects them.

    Raises
    ------
    InputError
        If the engine has no section [strength].
    MeshError, SolveError
        If finite elements are selected, and a throw cannot be meshed or solved.

    Notes
    -----
    Each throw is supported separately at the middles of its main journals. Radial forces bend its webs, both
    forces the pin at the oil hole, all over one cycle at rated speed. Torsion is the largest at running
    speeds, see `shaft_loads`.
    """
    file = vibration.engine_file
    section = file.strength
    if section is None:
        raise InputError(
            f"{file.path.name}: given no section [strength]; allowed is one with tensile_strength, "
            "manufacture and piston, because the strength of the crankshaft depends on them."
        )
    loads = shaft_loads(vibration)
    by_elements = section.factors == "finite elements"
    if stresses is None:
        stresses = engine_stresses(file) if by_elements else {}
    throws = [
        _throw(file, place, supported, loads, stresses.get(file.throw_names[place]))
        for place, supported in enumerate(supported_throws(file))
    ]
    remarks = strength_remarks(
        vibration,
        section,
        loads,
        [throw_stresses.web for throw in throws for throw_stresses in throw.sides],
        [throw_stresses.web for throw in throws for throw_stresses in throw.factors.values()],
        [throw_stresses for throw in throws for throw_stresses in throw.elements.values()],
    )
    return EngineStrength(
        throws=tuple(throws),
        remarks=tuple(remarks),
        left_out=_of_throws((throw.number, text) for throw in throws for text in throw.left_out),
        unsafe=unsafe_sentences(throws),
        warning=unsafe_warning(throws),
        by_elements=by_elements,
    )


def unsafe_sentences(throws: Sequence[ThrowStrength]) -> tuple[str, ...]:
    """State where a formula gives a smaller factor than finite elements, a sentence each."""
    texts: list[tuple[int, str]] = []
    for throw in throws:
        webs: dict[str, list[str]] = {}
        for name, elements in throw.elements.items():
            smaller = unsafe_formulas(throw.factors.get(name), elements)
            for symbol, (formula, other) in smaller.items():
                error = elements.shear_error if symbol == "beta_Q" else elements.error
                assert error is not None
                text = (
                    f"{symbol} is {formula:.3f} by the formula and {other:.3f} by finite "
                    f"elements{_method(symbol)}, {_more(formula, other)} more (estimated error "
                    f"{percent(error, 2)} %): the formula is not conservative"
                )
                webs.setdefault(text, []).append(name)
        texts += [
            (throw.number, f", {'both webs' if len(names) > 1 else names[0]}: {text}")
            for text, names in webs.items()
        ]
    return _of_throws(texts)


def unsafe_warning(throws: Sequence[ThrowStrength]) -> str:
    """State which formulas give smaller factors than finite elements, with the largest difference; or ""."""
    most: dict[str, tuple[float, float]] = {}
    for throw in throws:
        for name, elements in throw.elements.items():
            for symbol, both in unsafe_formulas(throw.factors.get(name), elements).items():
                most[symbol] = max(most.get(symbol, both), both, key=lambda two: two[1] / two[0])
    named = ", ".join(
        f"{symbol} (up to {_more(*both)}{_method(symbol)})" for symbol, both in most.items()
    )
    return named and (
        "Finite elements give larger stress concentration factors than the formulas of UR M53: "
        f"{named}. There the formulas are not conservative."
    )


def _of_throws(numbered_texts: Iterable[tuple[int, str]]) -> tuple[str, ...]:
    """Put the throws in front of a sentence that holds for all of them."""
    numbers_of: dict[str, list[int]] = {}
    for number, text in numbered_texts:
        numbers_of.setdefault(text, []).append(number)
    sentences = []
    for text, throws in numbers_of.items():
        first, last = throws[0], throws[-1]
        named = f"throws {', '.join(map(str, throws))}"
        if len(throws) == 1:
            named = f"throw {first}"
        elif len(throws) > 2 and throws == [*range(first, last + 1)]:
            named = f"throws {first} to {last}"
        sentences.append(f"{named}{text}")
    return tuple(sentences)


def _method(symbol: str) -> str:
    """The method of Appendix III that is used for the shear factor."""
    return ", method 1" if symbol == "beta_Q" else ""


def _more(smaller: float, other: float) -> str:
    return f"{percent(other / smaller - 1.0, 2)} %"


def shown_factor(place: PlaceStrength) -> str:
    """Write an acceptability factor so that rounding does not make it sufficient."""
    digits = next(
        n for n in (2, 3, 4, 6, 9, 17)
        if (round(place.acceptability, n) >= REQUIRED) == place.passed
    )  # fmt: skip
    return f"Q = {place.acceptability:.{digits}f}"


def _throw(
    file: EngineFile,
    place_along: int,
    supported: SupportedThrow,
    loads: ShaftLoads,
    throw_stresses: FilletStresses | None,
) -> ThrowStrength:
    """Judge all locations of a throw, counted from 0 at the free end."""
    section, number = file.strength, place_along + 1
    throw = with_dimensions(file.crank_throws[place_along])
    assert section is not None  # or nothing would be judged
    fit = shrink_fit(throw, section, loads.passed_on[place_along], file.material.youngs_modulus)
    webs = throw_webs(throw, section)
    elements = {} if throw_stresses is None else element_factors(throw_stresses, webs)
    torque, left_out = loads.torque(place_along), list[str]()
    if fit is None and section.shrink_fit is not None:
        left_out.append(", shrink fit: torsional vibration is unbounded.")
    axial = loads.axial[place_along].value if section.axial_vibration == "calculated" else None
    judged: dict[str, list[PlaceStrength]] = {place: [] for place in PLACES}
    known: dict[str, ConcentrationFactors] = {}
    for web in webs:
        factors: ConcentrationFactors | ElementFactors | None = elements.get(web.name)
        try:
            known[web.name] = ConcentrationFactors(web.web, section.coefficients)
        except InputError as error:
            if section.factors == "formulas":
                # A shaft without fillets at its journals is described elsewhere.
                shrunk = not (web.web.journal_fillet_radius or web.web.semi_built)
                needed = " Journals shrunk into the webs need a section [strength.shrink_fit]."
                left_out.append(f", {web.name}: {error}{needed if shrunk else ''}")
                continue
        if section.factors == "formulas":
            factors = known[web.name]
        if factors is None:
            left_out.append(f", {web.name}: no stresses by finite elements were calculated.")
            continue
        nominal = web_stresses(supported, web.web, web.middle, strokes=file.engine.strokes)
        acting = {"pin fillet": nominal}
        if not web.web.semi_built:
            acting["journal fillet"] = nominal
        if web.web.oil_hole_diameter:
            angle = section.oil_hole_angle
            degrees = None if angle is None else float(np.degrees(angle))
            rods = np.unique(np.asarray(supported.rods)).tolist()
            acting["oil hole"] = (
                max(hole_stress(supported, web.web, at, degrees) for at in rods),
                0.0,
            )
        for place, stresses in acting.items():
            case = JudgedCase(number, place, web, factors, *stresses, torque.value, axial)
            try:
                judged[place] += judged_places(case, section)
            except InputError as error:
                left_out.append(f", {web.name}, {place}: {error}")
    least = [
        min(each, key=lambda judged_place: round(judged_place.acceptability, EQUAL))
        for each in judged.values()
        if each
    ]
    return ThrowStrength(
        number=number,
        torque=torque,
        places=tuple(least),
        webs={
            name: _factors(known.get(name), elements.get(name))
            for name in dict.fromkeys([*known, *elements])
        },
        fit=fit,
        sides=webs,
        factors=known,
        elements=elements,
        left_out=tuple(left_out),
    )


def _factors(formulas: ConcentrationFactors | None, elements: ElementFactors | None) -> WebFactors:
    known = formulas or elements
    assert known is not None
    factors: dict[str, float | None] = dict.fromkeys(FACTORS)
    for name in FACTORS if formulas else ():
        with suppress(InputError):
            factors[name] = getattr(formulas, name)
    meshed = None
    if elements is not None:
        names = (entry.name for entry in fields(elements) if entry.name != "web")
        meshed = {name: getattr(elements, name) for name in names}
    return WebFactors({name: known.web.ratio(name) for name in RANGES}, factors, meshed)


def strength_table(strength: EngineStrength, units: OutputUnits = SI) -> Table:
    """Return the least acceptability factor of each location of each throw."""
    places = [place for throw in strength.throws for place in throw.places]

    def stresses(name: str, attribute: str) -> tuple[Column, list[float]]:
        return Column(name, "MPa"), [getattr(place, attribute) for place in places]

    deep = (
        Column("depth", units.of("mm"), missing="surface"),
        [place.depth or None for place in places],
    )
    return Table.of_columns(
        "Alternating stresses by UR M53",
        (Column("throw"), [place.throw for place in places]),
        (
            Column("location", words=True),
            [f"{place.place} {place.web.removesuffix(' web')}".strip() for place in places],
        ),
        *([deep] if any(place.depth for place in places) else []),
        *(stresses(f"nominal {name}", f"nominal_{name}") for name in ("bending", "torsion")),
        *(stresses(name, name) for name in ("bending", "torsion")),
        (Column("added", "MPa"), [place.added or None for place in places]),
        stresses("equivalent", "equivalent"),
        stresses("fatigue strength", "strength"),
        (Column("factor Q", decimals=3), [place.acceptability for place in places]),
        marks=["" if place.passed else "over" for place in places],
    )


def torque_table(strength: EngineStrength) -> Table:
    """Return the largest alternating torque of each throw, with its speed and misfiring cylinders."""
    torques = [throw.torque for throw in strength.throws]
    return Table.of_columns(
        "Largest alternating torque",
        (Column("throw"), [throw.number for throw in strength.throws]),
        (
            Column("torque", "kN m", missing=UNBOUNDED),
            [None if math.isinf(torque.value) else torque.value for torque in torques],
        ),
        (Column("at", "1/min"), [torque.speed for torque in torques]),
        (Column("misfiring cylinder"), [torque.cylinders or None for torque in torques]),
    )


def factor_table(strength: EngineStrength) -> Table:
    """Return the factors of stress concentration of each web, those of equal webs once."""
    rows: dict[tuple[str, tuple[float | None, ...]], list[str]] = {}
    for throw in strength.throws:
        for name, web in throw.webs.items():
            for way, factors in (
                ("formulas", web.factors),
                ("finite elements", web.finite_elements),
            ):
                if factors is not None:
                    known = (factors[symbol] for symbol in FACTORS)
                    values = tuple(
                        None if factor is None else round(factor, EQUAL) for factor in known
                    )
                    place = f"{throw.number} {name.removesuffix(' web')}"
                    rows.setdefault((way, values), []).append(place)
    ways = [way for way, _ in rows]
    both = len(set(ways)) > 1
    return Table(
        "Factors of stress concentration",
        [
            Column("webs", words=True),
            *([Column("by", words=True)] if both else []),
            *(Column(symbol, decimals=3) for symbol in SYMBOLS.values()),
        ],
        [
            ["all" if ways.count(way) == 1 else ", ".join(webs), *([way] if both else []), *values]
            for (way, values), webs in rows.items()
        ],
    )
