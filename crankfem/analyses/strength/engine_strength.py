"""Strength of an engine's crankshaft by the formulas of UR M53, throw by throw."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.errors import InputError
from crankbase.library_types import DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table_of
from crankbase.units.units import RPM
from crankfem.analyses.strength.shaft_loads import (
    HIGHEST_ORDER,
    LargestLoad,
    ShaftLoads,
    shaft_loads,
)
from crankfem.analyses.strength.supported_throws import supported_throws
from crankfem.analyses.strength.throw_webs import ThrowWeb, shrink_fit, throw_webs
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import MechanismFile, mechanism_of
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.assessment.limit_sentences import shown_range
from dynamics.response.loads import section_modulus
from dynamics.strength.concentration import (
    COEFFICIENTS,
    DOUBTFUL,
    ConcentrationFactors,
    coefficient_differences,
)
from dynamics.strength.crank_web import M53_SOURCE, PLACES
from dynamics.strength.fatigue import (
    MANUFACTURE,
    REQUIRED,
    PlaceStrength,
    added_bending,
    fatigue_strength,
    fillet_equivalent,
    hole_equivalent,
)
from dynamics.strength.nominal import SupportedThrow, hole_stress, web_stresses
from dynamics.strength.shrink_fit import ShrinkFit
from dynamics.strength.surface_treatment import factors_below

# Factors that agree to so many decimals are equal: the place nearest to the free end stands first.
EQUAL = 9


@summarized("number", "torque.value [N m]", "places")
@dataclass(frozen=True, eq=False)
class ThrowStrength:
    """Strength of one throw.

    Attributes
    ----------
    number : int
        From 1 at the free end.
    webs : tuple of ThrowWeb
        The left and the right one.
    factors : dict of str to ConcentrationFactors
        Of each web by its name, as far as the rule has any.
    places : tuple of PlaceStrength
        Pin fillet, journal fillet and oil hole as far as there are such and the rule has factors: each
        beside the web, and of a hardened one at the depth, with the least acceptability.
    torque : LargestLoad
        Alternating, the largest beside the throw.
    fit : ShrinkFit or None
        Of the journals of a semi-built shaft.
    left_out : tuple of str
        Where the rule has no formula and why, as `EngineStrength.left_out` says it after the throws.
    """

    number: int
    webs: tuple[ThrowWeb, ...]
    factors: dict[str, ConcentrationFactors]
    places: tuple[PlaceStrength, ...]
    torque: LargestLoad
    fit: ShrinkFit | None
    left_out: tuple[str, ...]


@summarized("sentence", "passed", "remarks")
@dataclass(frozen=True, eq=False)
class EngineStrength:
    """Strength of an engine's crankshaft by the formulas of UR M53.

    Attributes
    ----------
    throws : tuple of ThrowStrength
        From the free end.
    remarks : tuple of str
        What was assumed, a sentence each.
    source : str
        Of the formulas.
    """

    throws: tuple[ThrowStrength, ...]
    remarks: tuple[str, ...]
    source: str = M53_SOURCE

    @property
    def places(self) -> tuple[PlaceStrength, ...]:
        """Those of all throws, the one with the least acceptability first."""
        found = (place for throw in self.throws for place in throw.places)
        return tuple(sorted(found, key=lambda one: round(one.acceptability, EQUAL)))

    @property
    def passed(self) -> bool | None:
        """Whether all places and fits are acceptable; None where some could not be judged."""
        fits = all(own.fit is None or own.fit.passed for own in self.throws)
        if not fits or not all(place.passed for place in self.places):
            return False
        return None if self.left_out else True

    @property
    def sentence(self) -> str:
        """What was found, with the place that decides."""
        unjudged = self.left_out
        if not self.places:
            return f"Crankshaft strength by UR M53 is not judged: {unjudged[0]}"
        least, wrong = self.places[0], sum(not place.passed for place in self.places)
        said = (
            f"Crankshaft strength by UR M53: the least acceptability factor is {shown_factor(least)} at the "
            f"{least.place} of throw {least.throw}, {REQUIRED:g} is required"
        )
        said += f"; {wrong} of {len(self.places)} places fall short." if wrong else "."
        fits = [own for own in self.throws if own.fit is not None and not own.fit.passed]
        if fits and fits[0].fit is not None:
            said += f" Shrink fit of throw {fits[0].number}: {fits[0].fit.refusals[0]}."
        return f"{said} Not judged: {unjudged[0]}" if unjudged else said

    def to_pandas(self) -> DataFrame:
        """Return a row for each place, the one with the least acceptability first.

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

    @property
    def left_out(self) -> tuple[str, ...]:
        """What could not be judged and why, a sentence each, with the throws it is said of."""
        said: dict[str, list[int]] = {}
        for own in self.throws:
            for text in own.left_out:
                said.setdefault(text, []).append(own.number)
        return tuple(f"{_named(numbers)}{text}" for text, numbers in said.items())


def engine_strength(
    vibration: EngineVibration, *, mechanism: MechanismFile | None = None
) -> EngineStrength:
    """Judge the strength of an engine's crankshaft by the formulas of UR M53.

    Parameters
    ----------
    vibration : EngineVibration
        From `engine_vibration`, of an engine with the section [strength]: its torques, barred ranges and
        axial forces.
    mechanism : MechanismFile, optional
        Of the same engine, where it is there already.

    Returns
    -------
    EngineStrength

    Raises
    ------
    InputError
        If the engine has no section [strength].

    Notes
    -----
    Each throw stands by itself on the middles of its main journals. Radial forces bend its webs, both
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
    known = mechanism_of(file) if mechanism is None else mechanism
    loads = shaft_loads(vibration, known)
    throws = []
    for place, supported in enumerate(supported_throws(file, mechanism=known)):
        throw = file.crank_throws[place]
        fit = shrink_fit(throw, section, loads.passed_on[place], file.material.youngs_modulus)
        webs = throw_webs(throw, section)
        throws.append(_throw(place + 1, file, section, webs, supported, loads, fit))
    remarks = _remarks(vibration, section, loads, throws)
    return EngineStrength(tuple(throws), tuple(remarks))


def _named(throws: Sequence[int]) -> str:
    return f"throw{'s' if len(throws) > 1 else ''} {', '.join(map(str, throws))}"


def _shrunk(own: ThrowWeb) -> str:
    """Say where a shaft without fillets at its journals is described."""
    if own.web.journal_fillet_radius or own.web.semi_built:
        return ""
    return " Journals that are shrunk into the webs have a section [strength.shrink_fit]."


def shown_factor(place: PlaceStrength) -> str:
    """Write an acceptability factor so that rounding does not make it a sufficient one."""
    digits = next(
        n for n in (2, 3, 4, 6, 9, 17)
        if (round(place.acceptability, n) >= REQUIRED) == place.passed
    )  # fmt: skip
    return f"Q = {place.acceptability:.{digits}f}"


def _throw(
    number: int,
    file: EngineFile,
    section: StrengthSection,
    webs: tuple[ThrowWeb, ...],
    supported: SupportedThrow,
    loads: ShaftLoads,
    fit: ShrinkFit | None,
) -> ThrowStrength:
    """Judge all places of a throw."""
    torque, left_out = loads.torque(number - 1), list[str]()
    if fit is None and section.shrink_fit is not None:
        left_out.append(", shrink fit: torsional vibration is unbounded.")
    axial = loads.axial[number - 1].value if section.axial_vibration == "calculated" else None
    found: dict[str, list[PlaceStrength]] = {place: [] for place in PLACES}
    known: dict[str, ConcentrationFactors] = {}
    for own in webs:
        try:
            factors = ConcentrationFactors(own.web, section.coefficients)
        except InputError as error:
            left_out.append(f", {own.name}: {error}{_shrunk(own)}")
            continue
        known[own.name] = factors
        nominal = web_stresses(supported, own.web, own.middle, strokes=file.engine.strokes)
        acting = {"pin fillet": nominal}
        if not own.web.semi_built:
            acting["journal fillet"] = nominal
        if own.web.oil_hole_diameter:
            angle = section.oil_hole_angle
            degrees = None if angle is None else float(np.degrees(angle))
            rods = np.unique(np.asarray(supported.rods)).tolist()
            acting["oil hole"] = (
                max(hole_stress(supported, own.web, at, degrees) for at in rods),
                0.0,
            )
        for place, stresses in acting.items():
            case = _Case(number, place, own, factors, *stresses, torque.value, axial)
            try:
                found[place] += _judged(case, section)
            except InputError as error:
                left_out.append(f", {own.name}, {place}: {error}")
    least = [
        min(each, key=lambda one: round(one.acceptability, EQUAL))
        for each in found.values()
        if each
    ]
    return ThrowStrength(number, webs, known, tuple(least), torque, fit, tuple(left_out))


@dataclass(frozen=True)
class _Case:
    """A place beside a web, with what acts there: nominal stresses [Pa], torque [N m], axial force [N]."""

    throw: int
    place: str
    own: ThrowWeb
    factors: ConcentrationFactors
    bending: float
    shear: float
    torque: float
    axial: float | None


def _judged(case: _Case, section: StrengthSection) -> Iterator[PlaceStrength]:
    """Return the place at its surface, and of a hardened one at the transition below too."""
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


def _remarks(
    vibration: EngineVibration,
    section: StrengthSection,
    loads: ShaftLoads,
    throws: Sequence[ThrowStrength],
) -> Iterator[str]:
    """Say what was assumed, a sentence each."""
    file = vibration.engine_file
    engine, asked = file.engine, HIGHEST_ORDER[file.engine.strokes]
    yield (
        f"bending is that of the rods' forces at rated speed, {RPM * engine.rated_speed:.4g} 1/min, each "
        "throw supported by itself"
    )
    left_out = ", ".join(shown_range(*one) for one in loads.barred)
    yield (
        f"torsion is the largest from {shown_range(engine.lowest_speed, engine.highest_speed)}"
        f"{f' without {left_out}, which the verdict bars' if left_out else ''}, orders up to "
        f"{min(asked, file.vibration.highest_order):g} summed over the cycle, "
        f"{'in normal firing and while cylinders misfire' if loads.misfiring else 'in normal firing'}"
    )
    if not loads.misfiring:
        yield f"{vibration.misfiring_note or 'misfiring is not calculated'}; the rule asks for it"
    if file.vibration.highest_order < asked:
        yield (
            f"the rule asks for orders up to {asked:g}: those above {file.vibration.highest_order:g} are not "
            "calculated (vibration.highest_order)"
        )
    if section.axial_vibration == "calculated":
        yield (
            "the calculated axial force bends the web with the crank radius as lever, its largest; that "
            "stands in place of the rule's 20 MPa"
        )
    if section.oil_hole_diameter is not None and section.oil_hole_angle is None:
        yield "the oil hole's outlet is taken where the pin's bending stress is largest"
    if any(throw.pin_bore_offset or throw.main_journal_bore_offset for throw in file.crank_throws):
        yield "bores that lie aside of their journals' axes are taken as if they were in the middle"
    if any(web.slopes for throw in file.crank_throws for web in throw.parts.webs):
        yield "webs that get thinner to their ends are taken with their full thickness"
    webs = [own.web for throw in throws for own in throw.webs]
    if any(web.overlap < 0.0 for web in webs):
        yield (
            "pin and journal do not overlap: the web is taken at the middle of its thickness, where the rule "
            "has a figure of its own that was not at hand"
        )
    changes = dict.fromkeys(
        f"{name} {100.0 * one:+.2g} %"
        for throw in throws
        for own in throw.factors.values()
        for name, one in coefficient_differences(own.web).items()
    )
    if changes:
        (cubic, square), (other_cubic, other_square) = (DOUBTFUL[one] for one in COEFFICIENTS)
        yield (
            f"two coefficients are doubtful, the {section.coefficients} ones are used: {other_cubic:g} in "
            f"place of the printed {cubic:g}, and {other_square:g} of {square:g}, change {', '.join(changes)}"
        )
    yield "the formulas are read from one text of the rule; no second text confirms their coefficients"
