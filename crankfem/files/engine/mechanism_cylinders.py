"""The cylinders of an engine file: positions, cranks, banks, throws, rods; how evenly they fire."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.errors import InputError
from crankbase.sentences import amount, angle, capital, finished, listed
from crankfem.files.reading.toml_file import InputWarning
from crankfem.files.sections.crank_throws import ShaftLayout
from crankfem.files.sections.engine_sections import Engine
from crankfem.files.sections.mechanism_sections import HingedRods, Piston, Rod
from dynamics.engine.layout import (
    EVEN,
    IN_LINE,
    EngineCylinder,
    EngineLayout,
    SlavePin,
    even_firing_order,
    least_uneven_order,
    repeating_intervals,
)
from dynamics.engine.rods import ConnectingRod
from geometry.any_throw import Throw
from geometry.crankshaft import throw_starts

# Inertia of a rod beside that of two masses at its pins, from light to heavy ends.
USUAL_INERTIA = (0.7, 1.2)


def throws_of(engine: Engine) -> tuple[int, ...]:
    """Return the throw of each cylinder, from 0."""
    if engine.throws is not None:
        return tuple(number - 1 for number in engine.throws)
    if engine.bank_angles is None:
        return tuple(range(engine.cylinders))
    banks = [round(angle, 9) for angle in engine.bank_angles]
    return tuple(banks[:place].count(bank) for place, bank in enumerate(banks))


def angles_of_throws(
    layout: ShaftLayout | None, engine: Engine, throws: Sequence[int]
) -> tuple[float, ...]:
    """Return the angle of each throw's first pin, as the file counts angles [rad]."""
    count = max(throws) + 1
    if layout is None or layout.throw_angles is None:
        return tuple(engine.crank_angles[throws.index(number)] for number in range(count))
    if len(layout.throw_angles) != count:
        raise InputError(
            f"shaft.throw_angles: given {len(layout.throw_angles)} throws; allowed is {count}, because "
            "the cylinders work on that many."
        )
    return layout.throw_angles


def pins_of(
    engine: Engine, throw: Throw, throws: Sequence[int], hinged: HingedRods | None
) -> tuple[int, ...]:
    """Return the pin that each cylinder works on, from 0, counted along the shaft.

    Hinged rods work on the pin of their main rod, rods side by side on one pin. All throws have the same
    number of pins as the one given.
    """
    main_of, count = _main_cylinders(engine, hinged), len(throw.parts.pins)
    pins = [0] * len(throws)
    taken = [0] * (max(throws) + 1)
    for place, number in enumerate(throws):
        if place not in main_of:
            pins[place] = number * count + (taken[number] if count > 1 else 0)
            taken[number] += 1
    for place, main in main_of.items():
        pins[place] = pins[main]
    return tuple(pins)


def engine_cylinders(
    engine: Engine,
    crank_throws: Sequence[Throw],
    rod: Rod,
    piston: Piston,
    hinged: HingedRods | None,
    throws: Sequence[int],
    throw_angles: Sequence[float],
) -> tuple[EngineCylinder, ...]:
    """Return the cylinders with pistons and rods, angles in the sense of rotation.

    Throws and their angles are given by crank, the crank that it works on by cylinder.
    """
    sense = engine.turning_sense
    banks = [sense * angle for angle in engine.bank_angles or (0.0,) * engine.cylinders]
    main_of = _main_cylinders(engine, hinged)
    positions = _positions(engine, crank_throws, throws, throw_angles, main_of)
    main_rod = _rod(rod)
    made = []
    for place in range(engine.cylinders):
        own_rod, pin = main_rod, None
        if hinged is not None and place in main_of:
            main = main_of[place]
            angle = banks[place] - banks[main]
            if hinged.pin_angle is not None:
                angle = sense * hinged.pin_angle
            own_rod, pin = (
                _rod(hinged),
                SlavePin(main + 1, hinged.pin_radius, angle_deg=math.degrees(angle)),
            )
        made.append(
            EngineCylinder(
                bore=engine.bore,
                piston_mass=piston.mass,
                rod=own_rod,
                crank_angle_deg=math.degrees(sense * engine.crank_angles[place]),
                bank_angle_deg=math.degrees(banks[place]),
                position=positions[place],
                pin_offset=piston.pin_offset,
                slave_pin=pin,
            )
        )
    return tuple(made)


def engine_layout(engine: Engine, cylinders: Sequence[EngineCylinder]) -> EngineLayout:
    """Return cylinders with the order and angles at which they fire, or are at the top."""
    # Those of a driven machine may be at the top together, which no order can say.
    tops = [cylinder.top_shaft_angle_deg for cylinder in cylinders] if engine.driven_by else None
    return EngineLayout(
        0.5 * engine.stroke,
        cylinders,
        engine.top_order,
        engine.strokes,
        firing_angles_deg=tops,
    )


def check_sizes(
    engine: Engine, throw: Throw, rod: Rod, piston: Piston, section: str = "throw"
) -> None:
    """Refuse cranks, rods and pin offsets that contradict each other; the section names the throw."""
    radius = throw.crank_radius
    if not math.isclose(2.0 * radius, engine.stroke, rel_tol=1e-3):
        raise InputError(
            f"{section}.crank_radius: given {amount(radius, 'm')}; allowed is half "
            "of engine.stroke, "
            f"{amount(engine.stroke / 2.0, 'm')}, because the piston moves by two crank radii; "
            f"correct it, or engine.stroke, given {amount(engine.stroke, 'm')}."
        )
    if rod.length <= 1.5 * radius:
        raise InputError(
            f"rod.length: given {amount(rod.length, 'm')}; allowed is more than 1.5 crank radii, "
            f"{amount(1.5 * radius, 'm')}, or the mechanism cannot turn."
        )
    largest = min(radius, rod.length - 1.5 * radius)
    if abs(piston.pin_offset) > largest:
        raise InputError(
            f"piston.pin_offset: given {amount(piston.pin_offset, 'm')}; allowed is "
            f"{amount(largest, 'm')} or less either way, because the rod must reach the piston."
        )


def inertia_of_masses(rod: Rod | HingedRods) -> float:
    """Return the inertia [kg m^2] of the two masses at a rod's pins about their center."""
    return rod.rotating_mass * (rod.mass - rod.rotating_mass) / rod.mass * rod.length**2


def known_inertia(rod: Rod | HingedRods) -> float | None:
    """Return a rod's inertia about its center of mass, if it is given or was found by swings [kg m^2]."""
    return rod.known_inertia if isinstance(rod, Rod) else rod.inertia


def inertia_remarks(*rods: Rod | HingedRods | None) -> list[str]:
    """State the consequence for each rod whose inertia is not given, or unusual."""
    remarks = []
    for rod in rods:
        if rod is None:
            continue
        inertia = known_inertia(rod)
        if inertia is None:
            remarks.append(
                f"{rod.section}.inertia is not given: the rod is modeled as two masses at its pins"
            )
            continue
        plain = inertia_of_masses(rod)
        if not USUAL_INERTIA[0] <= inertia / plain <= USUAL_INERTIA[1]:
            remarks.append(
                f"{rod.section}.inertia is {inertia / plain:.2g} times that of two masses at its pins; "
                f"usual is {USUAL_INERTIA[0]:g} to {USUAL_INERTIA[1]:g}"
            )
    return remarks


def side_by_side(throw: Throw, throws: Sequence[int], hinged: HingedRods | None) -> bool:
    """Return whether several rods share a pin."""
    carried = set() if hinged is None else {number - 1 for number in hinged.cylinders}
    on_pins = [pin for place, pin in enumerate(throws) if place not in carried]
    return len(throw.parts.pins) == 1 and len(on_pins) > len(set(on_pins))


def _main_cylinders(engine: Engine, hinged: HingedRods | None) -> dict[int, int]:
    """Main cylinder of each cylinder with a hinged rod, both from 0."""
    if hinged is None:
        return {}
    for name in ("cylinders", "main_cylinders"):
        for number in getattr(hinged, name):
            if not 1 <= number <= engine.cylinders:
                raise InputError(
                    f"hinged_rods.{name}: given {number}; allowed is 1 to {engine.cylinders}, "
                    "because the engine has these cylinders."
                )
    return {
        rider - 1: main - 1
        for rider, main in zip(hinged.cylinders, hinged.main_cylinders, strict=True)
    }


def _rod(section: Rod | HingedRods) -> ConnectingRod:
    """Return the rod with its center of mass at the position given by its shares."""
    distance = section.length * (1.0 - section.rotating_mass / section.mass)
    # Without an inertia the rod is as the two masses at its pins.
    inertia = known_inertia(section) or section.mass * distance * (section.length - distance)
    offset = section.center_offset if isinstance(section, Rod) else 0.0
    swung = section.inertia is None
    inertia_origin = "swing_period: given with swing_distance" if swung else "inertia: given"
    before = f"{section.section}."
    return ConnectingRod(
        section.length, section.mass, distance, inertia, offset, before, inertia_origin
    )


def _positions(
    engine: Engine,
    crank_throws: Sequence[Throw],
    throws: Sequence[int],
    throw_angles: Sequence[float],
    main_of: dict[int, int],
) -> list[float]:
    """Position of each cylinder along the shaft: on its throw's pin, or side by side on it."""
    positions = [0.0] * len(throws)
    for number, start in zip(range(max(throws) + 1), throw_starts(crank_throws), strict=False):
        pins = crank_throws[number].parts.pins
        on_pin = [
            place for place, throw in enumerate(throws) if throw == number and place not in main_of
        ]
        if len(on_pin) > 1 and len(pins) not in (1, len(on_pin)):
            raise InputError(
                f"engine.throws: given {len(on_pin)} rods for throw {number + 1}, which has {len(pins)} "
                "pins; allowed is one rod a pin, or all on one pin, because "
                "rods sit on pins."
            )
        for rank, place in enumerate(on_pin):
            pin = pins[rank if len(pins) > 1 else 0]
            turned = engine.crank_angles[place] - math.atan2(-pin.axis[0], pin.axis[1])
            if abs(math.remainder(turned - throw_angles[number], 2.0 * math.pi)) > IN_LINE:
                raise InputError(
                    f"engine.crank_angles: given {amount(engine.crank_angles[place], 'rad')} for "
                    f"cylinder {place + 1}, whose pin on throw {number + 1} is at "
                    f"{amount(engine.crank_angles[place] - turned + throw_angles[number], 'rad')}; "
                    "allowed is the angle of its pin, because the rod is on it (engine.throws defines which "
                    "cylinder is on which throw, [[throw.further_pins]] gives a throw more pins)."
                )
            share = 0.5 if len(pins) > 1 else (rank + 0.5) / len(on_pin)
            positions[place] = start + pin.start + share * (pin.end - pin.start)
    for place, main in main_of.items():
        positions[place] = positions[main]
    return positions


# Intervals that differ so many times more than those of another order look like a slip.
MUCH = 2.0


@dataclass(frozen=True)
class FiringEvenness:
    """What to say of firing intervals that are not even.

    Attributes
    ----------
    warnings : tuple of InputWarning
        Of what looks like a slip.
    notes : tuple of InputWarning
        Of what only some engines have.
    """

    warnings: tuple[InputWarning, ...] = ()
    notes: tuple[InputWarning, ...] = ()


def firing_evenness(engine: Engine) -> FiringEvenness:
    """Compare the firing intervals of an engine with even ones.

    Engines in banks and those of one or two cylinders are often built with uneven intervals: where no
    firing order makes them even, or by far more even, that is a note.
    """
    steps = engine.firing_intervals_deg
    if engine.driven_by or max(steps) - min(steps) < np.degrees(EVEN):
        return FiringEvenness()
    order = engine.top_order
    together = tuple(
        InputWarning(
            "engine.firing_order",
            f"cylinders {order[place]} and {order[(place + 1) % len(order)]} fire at the same time",
        )
        for place, step in enumerate(steps)
        if step < np.degrees(EVEN)
    )
    uneven = intervals_text(steps)
    even = even_firing_order(engine.firing_angles, engine.strokes)
    given_order = "-".join(map(str, order))
    if even is not None:
        every = sum(steps) / len(steps)
        better = InputWarning(
            "engine.firing_order",
            f"given {given_order}, which fires at uneven intervals of {uneven}; an "
            f"order such as {'-'.join(map(str, even))} fires every {angle(every)} with the same cranks",
        )
        return FiringEvenness((*together, better))
    banked = engine.bank_angles is not None
    angles = "crank and bank angles" if banked else "crank angles"
    fires = f"the cylinders fire at uneven intervals of {uneven}; no firing order is even with these {angles}"
    best = least_uneven_order(engine.firing_angles, engine.strokes)
    spread = max(steps) - min(steps)
    least = spread if best is None else np.degrees(max(best[1]) - min(best[1]))
    if best is not None and least < spread - np.degrees(EVEN):
        such = "-".join(map(str, best[0]))
        at = intervals_text([float(np.degrees(angle)) for angle in best[1]])
        fires += f", and the least uneven is such as {such} at {at}"
        if engine.cylinders > 2 and spread > MUCH * least:
            better = InputWarning("engine.firing_order", f"given {given_order}; {fires}")
            return FiringEvenness((*together, better))
    elif best is not None:
        fires += ", or less uneven than this one"
    of_cranks = InputWarning("engine.crank_angles", fires)
    if banked or engine.cylinders < 3:
        return FiringEvenness(together, (of_cranks,))
    unpaired = ""
    if engine.strokes != 2 and engine.cylinders % 2 == 0:
        fired = np.degrees(engine.firing_angles)
        tops = [round(float(angle) % 360.0, 1) % 360.0 for angle in fired]
        alone = [str(place) for place, top in enumerate(tops, start=1) if tops.count(top) == 1]
        if alone:
            unpaired = f" (not in pairs at the top: cylinders {', '.join(alone)})"
    hint = f"{unpaired}, so check them unless the engine is built so"
    return FiringEvenness((*together, of_cranks.with_hint(hint)))


def firing_sentence(engine: Engine) -> str:
    """Say in which order and at which intervals an engine fires, or its cranks come to the top."""
    steps = engine.firing_intervals_deg
    order = capital(f"{order_named(engine.driven_by)} {'-'.join(map(str, engine.top_order))}")
    if max(steps) - min(steps) < np.degrees(EVEN):
        return finished(f"{order}, even: every {angle(sum(steps) / len(steps))}.")
    return finished(f"{order}, uneven: intervals of {intervals_text(steps)}.")


def order_named(driven_by: str | None) -> str:
    """Name the order in which cylinders fire, or those of a driven machine come to the top."""
    return "order at the top" if driven_by else "firing order"


def intervals_text(intervals_deg: Sequence[float]) -> str:
    """Write intervals; of those that repeat, each once."""
    repeated = repeating_intervals(intervals_deg)
    again = " in turn" if 1 < len(repeated) < len(intervals_deg) else ""
    return f"{listed(np.radians(np.round(repeated, 1)).tolist(), 'rad')}{again}"
