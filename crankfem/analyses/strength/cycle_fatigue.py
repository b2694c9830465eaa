"""Fatigue of every throw over the working cycle, by finite elements and a multiaxial criterion.

Stresses at fillets and oil holes are fields of a throw's finite elements times its loads over the cycle
(`cycle_loads`). Findley's criterion is evaluated at the points, speeds and cases of firing where a bound
of it is largest.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array, Integers
from crankbase.errors import InputError, MeshError, SolveError
from crankbase.frames import DataFrame, Row, table_of
from crankbase.results import Number, Part, Quantity, Result, Speed, result
from crankbase.table import Column, Table
from crankfem.analyses.strength.cycle_loads import CycleLoads, cycle_loads, judged_speeds
from crankfem.analyses.strength.engine_strength import EngineStrength, engine_strength
from crankfem.analyses.vibration.misfiring import Cylinders
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.sections.strength_section import StrengthSection
from dynamics.strength.fatigue import (
    FINDLEY_SOURCE,
    MANUFACTURE,
    CriticalPlane,
    Stress,
    critical_plane,
    fatigue_strength,
    findley_bound,
    findley_factor,
    findley_limit,
)
from dynamics.wording import at_speed, cylinders_named
from fem.fields import StressedSite, StressFields, stress_fields
from fem.fillet_peaks import FilletStresses
from fem.fillet_stress import fillet_stresses

# Speeds at which nodes are chosen first, how many are followed over all speeds, and how far these are apart
# beside the radius of the fillet or hole.
FIRST_SPEEDS, FOLLOWED, APART = 5, 16, 0.5
# Every so many samples of the cycle are enough to choose nodes, and speeds.
SPARSER, SPARSE = 6, 3
# Highest speeds of each case that are looked at closely, and nodes there: apart, then near the worst.
CLOSELY, NODES = 3, 6


@dataclass(frozen=True)
class Candidate:
    """A speed and case of firing of a site that may be decisive: upper bound of its points, and its loads."""

    bound: float
    speed: float
    cylinders: Cylinders
    angles: Array
    amplitudes: Array  # (m, 12)


def _history(site: StressedSite, nodes: Integers, amplitudes: Array) -> Array:
    """Stresses (nodes, ..., m, 3) of amplitudes (..., m, 12)."""
    stress = site.stress[nodes]
    flat = amplitudes.reshape(-1, amplitudes.shape[-1]) @ np.moveaxis(stress, 1, 0).reshape(
        amplitudes.shape[-1], -1
    )
    return np.moveaxis(flat.reshape(*amplitudes.shape[:-1], len(stress), 3), -2, 0)


def _apart(site: StressedSite, values: Array) -> Iterator[int]:
    """Return nodes of a site with the largest values first, none next to one that came before."""
    left = values.copy()
    while np.any(left > 0.0):
        node = int(np.argmax(left))
        yield node
        distance = np.linalg.norm(site.points - site.points[node], axis=1)
        left[distance < APART * site.radius] = 0.0


def find_candidates(
    site: StressedSite, loads: CycleLoads, throw: int, amplitudes: Array, factor: float
) -> Iterator[Candidate]:
    """Return the speeds at which the bound of a site is highest among its neighbors."""
    count = len(loads.speeds)
    first = np.unique(np.linspace(0, count - 1, FIRST_SPEEDS).astype(int))
    twisting = np.ptp(loads.ends[throw, ..., 11], axis=1).argmax()
    every = np.arange(len(site.points))
    reached = np.zeros(len(every))
    for speed in [*first, twisting]:
        history = _history(site, every, amplitudes[speed, ::SPARSER])
        reached = np.maximum(reached, findley_bound(history, factor))
    nodes = np.array(list(islice(_apart(site, reached), FOLLOWED)))
    history = _history(site, nodes, amplitudes[:, ::SPARSE])
    bounds = findley_bound(history, factor).max(axis=0)
    padded = np.concatenate(([-np.inf], bounds, [-np.inf]))
    tops = np.flatnonzero((bounds >= padded[:-2]) & (bounds >= padded[2:]))
    for top in tops[np.argsort(bounds[tops])[::-1][:CLOSELY]]:
        speed = float(loads.speeds[top])
        yield Candidate(
            float(bounds[top]), speed, loads.cylinders, loads.angles, amplitudes[top].copy()
        )


def worst_point(
    site: StressedSite, candidates: Sequence[Candidate], factor: float
) -> tuple[CriticalPlane, int, Candidate]:
    """Return the critical plane of the worst of a site's nodes, its index, and the loads at that time."""
    best: CriticalPlane | None = None
    where = (0, candidates[0])
    for candidate in sorted(candidates, key=lambda candidate: -candidate.bound):
        if best is not None and candidate.bound <= best.value:
            break
        history = _history(site, np.arange(len(site.points)), candidate.amplitudes)
        bounds = findley_bound(history, factor)
        near = np.zeros(len(bounds), dtype=bool)
        for nodes in (islice(_apart(site, bounds), NODES), None):
            if nodes is None:
                # Round the worst of these, if it is of this candidate.
                distance = np.linalg.norm(site.points - site.points[where[0]], axis=1)
                near = (distance < APART * site.radius) & (where[1] is candidate)
                nodes = iter(np.argsort(np.where(near, bounds, 0.0))[::-1][:NODES].tolist())
            for node in nodes:
                if best is not None and bounds[node] <= best.value:
                    break
                plane = critical_plane(history[node], factor)
                if best is None or plane.value > best.value:
                    best, where = plane, (node, candidate)
    assert best is not None
    return best, *where


# Wished accuracy of the finite elements, where there are none yet.
ACCURACY = 0.1


@result("throw", "place", "name", "safety", "speed", "shaft_angle_deg", "cylinders", eq=True)
class FatiguePlace(Result):
    """The worst point of a fillet or of an exit of an oil hole, at the decisive speed and firing.

    Attributes
    ----------
    throw : int
        From 1 at the free end.
    place : {"pin fillet", "journal fillet", "oil hole"}
    name : str
        For example "pin, left web".
    point : tuple of three float
        In the throw frame.
    cylinders : tuple of int
        Misfiring cylinders; none in normal firing.
    shaft_angle_deg : float
        Shaft angle at which the normal stress on the critical plane is largest.
    shear_amplitude, normal_stress : float
        On the critical plane: amplitude of the shear stress, largest normal stress.
    value, limit : float
        Of the criterion.
    strength : float
        Fatigue strength of the location in bending, fully reversed.
    rule_factor : float or None
        Q of UR M53 of the same location of the throw; None if the rule has none.
    """

    throw: int
    place: str
    name: str
    point: Annotated[tuple[float, float, float], Quantity("m")]
    speed: Speed
    cylinders: Annotated[Cylinders, Quantity("1", key="misfiring")]
    shaft_angle_deg: Annotated[float, Quantity("deg")]
    shear_amplitude: Stress
    normal_stress: Stress
    value: Annotated[float, Quantity("Pa", key="criterion")]
    limit: Stress
    strength: Stress
    rule_factor: Number | None

    @property
    def safety(self) -> Number:
        """Limit over value of the criterion; inf without stress."""
        return self.limit / self.value if self.value > 0.0 else math.inf

    def row(self) -> Row:
        """Return its values by column, each with its unit, for tables."""
        return super().row() | {
            "misfiring": (", ".join(map(str, self.cylinders)), ""),
            **{axis: (value, "m") for axis, value in zip("xyz", self.point, strict=True)},
            "rule_factor": (math.nan if self.rule_factor is None else self.rule_factor, "1"),
        }


@result("sentence", "remarks")
class EngineFatigue(Result):
    """Fatigue of an engine's crankshaft over the working cycle.

    Attributes
    ----------
    places : tuple of FatiguePlace
        Each fillet and exit of every throw, the least safety first.
    factor : float
        k of the criterion.
    remarks : tuple of str
        Assumptions, a sentence each.
    source : str
        Of the criterion.
    """

    places: tuple[FatiguePlace, ...]
    factor: Number
    remarks: tuple[str, ...]
    source: str = FINDLEY_SOURCE

    @property
    def sentence(self) -> Part[str]:
        """The least safety factor, its location and time, and the rule's factor."""
        least = self.places[0]
        firing = (
            f"while {cylinders_named(least.cylinders)} misfires"
            if least.cylinders
            else "firing normally"
        )
        text = (
            "Fatigue over the cycle, by finite elements and Findley's criterion: the least safety factor is "
            f"{least.safety:.2f} at the {least.name} of throw {least.throw}, at "
            f"{at_speed(least.speed)}, shaft angle {least.shaft_angle_deg:.0f}°, {firing}"
        )
        broken = sum(place.safety < 1.0 for place in self.places)
        if broken:
            text += f"; {broken} of {len(self.places)} locations {'is' if broken == 1 else 'are'} below 1"
        if least.rule_factor is None:
            return f"{text}; UR M53 does not cover that location."
        return f"{text}; UR M53 has Q = {least.rule_factor:.2f} for that location."

    def to_pandas(self) -> DataFrame:
        """Return a row for each location, the least safety first.

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


def engine_fatigue(
    vibration: EngineVibration,
    *,
    stresses: Mapping[str, FilletStresses] | None = None,
    strength: EngineStrength | None = None,
) -> EngineFatigue:
    """Find the fatigue of an engine's crankshaft over the working cycle.

    Parameters
    ----------
    vibration : EngineVibration
        From `engine_vibration`, of an engine with the section [strength].
    stresses : mapping, optional
        Of each distinct throw by its name, if available: their meshes are used.
    strength : EngineStrength, optional
        By the rule, if available.

    Raises
    ------
    InputError
        If the engine has no section [strength], a throw neither fillets nor oil holes, or vibration is
        unbounded.
    MeshError, SolveError
        If a throw cannot be meshed or solved.

    Notes
    -----
    At each speed that `engine_strength` judges, in normal firing and in those cases of misfiring with the
    largest torque in some throw, the limit of tau_a + k sigma_max is f/2 (k + sqrt(1 + k^2)), f being the
    fatigue strength of UR M53 for the location.
    """
    file = vibration.engine_file
    rule = strength or engine_strength(vibration, stresses=stresses)
    section = file.strength
    assert section is not None  # or there were no rule
    kept, _ = judged_speeds(vibration)
    forced = vibration.forced_torsional
    assert forced is not None
    speeds = forced.response.speeds[kept]
    fields = throw_fields(vibration, stresses)
    cases = dict.fromkeys([(), *(judged_throw.torque.cylinders for judged_throw in rule.throws)])
    factor = findley_factor()
    candidates: dict[tuple[int, int], list[Candidate]] = {}
    for loads in cycle_loads(vibration, speeds, cases):
        for throw, name in enumerate(file.throw_names):
            amplitudes = fields[name].amplitudes(loads.ends[throw], loads.pins[throw])
            for number, site in enumerate(fields[name].sites):
                if site.kind == "journal fillet" and section.shrink_fit is not None:
                    continue
                critical = find_candidates(site, loads, throw, amplitudes, factor)
                candidates.setdefault((throw, number), []).extend(critical)
    places, hard = [], section.hardening
    for (throw, number), each in candidates.items():
        site = fields[file.throw_names[throw]].sites[number]
        factors = [
            place.acceptability for place in rule.throws[throw].places if place.place == site.kind
        ]
        # The point, speed and case with the largest value of the criterion.
        best, node, candidate = worst_point(site, each, factor)
        if hard is not None and site.kind in hard.places:
            place_strength = hard.treatment().surface_strength
        else:
            share = MANUFACTURE[section.manufacture][site.kind == "oil hole"]
            place_strength = fatigue_strength(
                section.tensile_strength, site.diameter, site.radius, share
            )
        x, y, z = site.points[node].tolist()
        places.append(
            FatiguePlace(
                throw=throw + 1,
                place=site.kind,
                name=site.name,
                point=(x, y, z),
                speed=candidate.speed,
                cylinders=candidate.cylinders,
                shaft_angle_deg=float(np.degrees(candidate.angles[best.moment])),
                shear_amplitude=best.shear_amplitude,
                normal_stress=best.normal_stress,
                value=best.value,
                limit=findley_limit(place_strength, factor),
                strength=place_strength,
                rule_factor=min(factors, default=None),
            )
        )
    remarks = _remarks(vibration, section, fields, tuple(cases))
    return EngineFatigue(
        tuple(sorted(places, key=lambda place: place.safety)), factor, tuple(remarks)
    )


def fatigue_or_reason(
    vibration: EngineVibration,
    strength: EngineStrength,
    stresses: Mapping[str, FilletStresses],
) -> tuple[EngineFatigue | None, str | None]:
    """Find the fatigue over the cycle; if impossible, the other results remain.

    Returns
    -------
    EngineFatigue or None
    str or None
        Why there is none.
    """
    try:
        fatigue = engine_fatigue(vibration, stresses=stresses, strength=strength)
    except (InputError, MeshError, SolveError) as error:
        return None, str(error)
    return fatigue, None


def throw_fields(
    vibration: EngineVibration, stresses: Mapping[str, FilletStresses] | None = None
) -> dict[str, StressFields]:
    """Return the fields of stress of each distinct throw by its name; equal throws share theirs."""
    file = vibration.engine_file
    fields: dict[object, StressFields] = {}
    for name in dict.fromkeys(file.throw_names):
        throw = file.named_throws[name]
        if throw not in fields:
            peaks = (stresses or {}).get(name) or fillet_stresses(throw, file.material, ACCURACY)
            fields[throw] = stress_fields(peaks.loaded.mesh, throw, file.material)
    return {name: fields[file.named_throws[name]] for name in file.throw_names}


def _remarks(
    vibration: EngineVibration,
    section: StrengthSection,
    fields: Mapping[str, StressFields],
    cases: Sequence[Cylinders],
) -> Iterator[str]:
    """State the assumptions, a sentence each."""
    file = vibration.engine_file
    failing = [case for case in cases if case]
    yield (
        "torque and axial force through the throws include the vibration of the chains, in phase with the "
        "rods' forces; these bend the whole shaft in its elastic main bearings, without inertia effects"
    )
    if failing:
        yield (
            "besides normal firing, each case with the largest torsion of a throw is covered: misfiring of "
            f"{', of '.join(cylinders_named(case) for case in sorted(failing))}"
        )
    yield (
        "the bending fatigue strength is the rule's for the location; the torsional one is assumed to be "
        f"1/√3 of it, hence k = {findley_factor():.4f}; the shear amplitude is the radius of the smallest "
        "circle around its path"
    )
    yield (
        "mean stresses are included, with a throw's own mass assumed to rotate with the pin; the rule's "
        "additional stress for misalignment is not added"
    )
    if section.hardening is not None:
        yield "only the surface of hardened locations is assessed, without residual stresses"
    drilled = any(
        site.kind == "oil hole" for throw_fields in fields.values() for site in throw_fields.sites
    )
    if section.oil_hole_diameter is not None and not drilled:
        yield (
            "the mesh has no oil hole in the pin, so the hole is not assessed here: give it in the throw's "
            "oil_holes"
        )
    if len(set(file.throws)) < len(file.throws):
        yield "rods side by side load the pin at their own positions, each distributed over the whole pin"


def fatigue_table(fatigue: EngineFatigue) -> Table:
    """Return the least safety of each kind of location of each throw."""
    least: dict[tuple[int, str], FatiguePlace] = {}
    for place in fatigue.places:
        least.setdefault((place.throw, place.place), place)
    places = least.values()
    return Table.of_columns(
        "Fatigue over the working cycle",
        (Column("throw"), [place.throw for place in places]),
        (Column("location", words=True), [place.name for place in places]),
        (Column("safety", decimals=2), [place.safety for place in places]),
        (Column("at", "1/min"), [place.speed for place in places]),
        (Column("misfiring cylinder"), [place.cylinders or None for place in places]),
        (
            Column("shaft angle", "deg", decimals=0),
            [math.radians(place.shaft_angle_deg) for place in places],
        ),
        (Column("shear amplitude", "MPa"), [place.shear_amplitude for place in places]),
        (Column("normal stress", "MPa"), [place.normal_stress for place in places]),
        (Column("fatigue strength", "MPa"), [place.strength for place in places]),
        (Column("factor Q", decimals=2), [place.rule_factor for place in places]),
    )
