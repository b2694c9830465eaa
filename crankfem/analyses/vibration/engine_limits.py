"""The limits of an engine file, including those from rules, and the speeds at which they apply."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Protocol

import numpy as np

from crankbase.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.quantity import format_quantity
from crankfem.analyses.shaft.chains import engine_throw_inertias, engine_torsional_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.engine_sections import Engine
from crankfem.files.sections.limits_sections import LimitsInput, ShaftLimitInput
from dynamics.assessment.barred_ranges import (
    BarredRange,
    BarredRangeRule,
    barred_ranges,
    limit_end_speed,
)
from dynamics.assessment.limit_rules import (
    BASE_STRENGTH,
    BASE_YIELD,
    CRANKSHAFT_RULES,
    CRANKSHAFT_STRENGTHS,
    RULE_OF_DRIVEN,
)
from dynamics.assessment.limit_rules import Kind as EngineKind
from dynamics.assessment.limits import AmplitudeCurve, VibrationLimit
from dynamics.assessment.response_curves import curves_of
from dynamics.assessment.verdict import Verdict, judge
from dynamics.chains.chain import Chain
from dynamics.chains.engine_chains import Kind
from dynamics.chains.shaft_line import DRIVEN
from dynamics.response.loads import ElementLoads, alternating_stress, dashpot_names, section_modulus
from dynamics.response.series import OrderSeries

RULE_PICKED = (
    "no limit is given: a classification society's limit for crankshafts is used, for plain steel unless "
    "[limits] or [strength] gives another; the engine maker's value replaces it"
)
# Any number above zero serves where only the names of nodes and elements are wanted.
ANY_COMPLIANCE, ANY_INERTIA = 1e-8, 1.0
# Just beyond the speed at which a limit ends, as a share of it.
BEYOND = 1e-6
# Firings count as even if their intervals differ by less [deg].
UNEVEN = 0.01
DAMPER = "damper ring"
# What is compared of any engine that has it, limited or not: key, name and unit.
COMPARED = {
    "torsional_amplitude": ("torsional amplitude of free end", "rad"),
    "axial_amplitude": ("axial amplitude of free end", "m"),
    "coupling_torque": ("torque of coupling", "N m"),
    "damper_torque": ("torque of torsional damper", "N m"),
}
# Limits that the class document alone holds results against.
IN_CLASS_DOCUMENT = ("coupling_heat", "damper_torque", "damper_heat", "generator_angle")
NOT_SAMPLED = "samples of the axial amplitude keep the excitation by torsion of the nominal chain"


Findings = Sequence[tuple[VibrationLimit, AmplitudeCurve]]


class Limited(Protocol):
    """What limits are read from, such as `crankfem.analyses.vibration.forced.ChainAnswer`.

    The torsional one also has the `stress`; chains the motion of the `free_end`, and loads of
    `crank_elements`.
    """

    @property
    def loads(self) -> ElementLoads:
        """Torque or force in each element."""


@dataclass(frozen=True)
class LimitedQuantity:
    """What a limit is on.

    Attributes
    ----------
    kind : {"axial", "torsional"}
        Of the vibration.
    series : callable
        The answer of that kind to the quantity by orders.
    element : str
        Of the torsional chain, outside the crankshaft; "" without one.
    """

    kind: Kind
    series: Callable[[Limited], OrderSeries]
    element: str = ""


def at_place(series: OrderSeries, name: str) -> OrderSeries:
    """Return one location of a series."""
    place = series.names.index(name)
    return replace(series, values=series.values[:, :, [place]], names=(name,))


def _torque(place: str, answer: Limited) -> OrderSeries:
    elements, dashpots = answer.loads.elements, answer.loads.dashpots
    return at_place(elements if place in elements.names else dashpots, place)


def _shaft_stress(shaft: ShaftLimitInput, answer: Limited) -> OrderSeries:
    modulus = float(section_modulus("torsional", shaft.diameter))
    return alternating_stress(answer.loads, {shaft.element: modulus})


# By the fields of [limits].
LIMITED = {
    "crankshaft_stress": LimitedQuantity("torsional", attrgetter("stress")),
    "torsional_amplitude": LimitedQuantity("torsional", attrgetter("free_end")),
    "axial_amplitude": LimitedQuantity("axial", attrgetter("free_end")),
    "axial_force": LimitedQuantity("axial", attrgetter("crank_elements")),
}


def coupling_of(engine: Engine) -> str:
    """Return the element of the torsional chain that is the coupling behind the flywheel."""
    return f"flywheel - {engine.driven_by or DRIVEN}"


def limited_quantities(engine_file: EngineFile) -> dict[str, LimitedQuantity]:
    """Return what each possible limit of `engine_limits` is on, by its name.

    The elements are those of `check_limited_elements`.
    """
    limits, coupling = engine_file.limits or LimitsInput(), coupling_of(engine_file.engine)
    series: dict[str, tuple[Callable[[Limited], OrderSeries], str]] = {
        "coupling_torque": (partial(_torque, coupling), coupling)
    }
    for shaft in limits.shafts:
        series[f"shaft: {shaft.element}"] = partial(_shaft_stress, shaft), shaft.element
    for part in limits.elements:
        series[f"torque: {part.element}"] = partial(_torque, part.element), part.element
    return LIMITED | {name: LimitedQuantity("torsional", *of) for name, of in series.items()}


# The limits of a file by their names, and remarks.
Limits = tuple[dict[str, VibrationLimit], tuple[str, ...]]


def engine_limits(engine_file: EngineFile) -> Limits:
    """Return the limits on an engine's vibration, made once for each file.

    Parameters
    ----------
    engine_file : EngineFile
        Its section [limits] is used if given; else a rule of a classification society for the
        crankshaft's stress.

    Returns
    -------
    limits : dict
        Name to limit.
    remarks : tuple of str
        What is not assessed, or was assumed.
    """
    return engine_file.once(_engine_limits)


def _engine_limits(engine_file: EngineFile) -> Limits:
    engine, limits = engine_file.engine, engine_file.limits or LimitsInput()
    kind: EngineKind = "in line" if engine.bank_angles is None else "V"
    interval = even_firing_interval(engine.firing_angles, engine.strokes)
    named_limits = limits.limits(
        engine.rated_speed,
        strokes=engine.strokes,
        kind=kind,
        firing_interval_deg=interval,
        provenance=engine_file.provenance,
    )
    remarks = []
    if engine.driven_by:
        # The rules are for engines: a driven machine's crankshaft has a given limit.
        forced = engine_file.gas is not None or engine_file.gas_map is not None
        if forced and "crankshaft_stress" not in named_limits:
            raise InputError(
                "limits.crankshaft_stress: missing for a machine that is driven; give what its maker "
                'permits, or { value = "25 MPa", assumed = "why" }, because the rules of classes for '
                "crankshafts are for engines."
            )
    elif "crankshaft_stress" not in named_limits:
        tensile, yielding = strengths(engine_file)
        picked = CRANKSHAFT_RULES[rule_of(engine)](
            engine.rated_speed,
            strokes=engine.strokes,
            kind=kind,
            firing_interval_deg=interval,
            tensile_strength=tensile,
            yield_strength=yielding,
            # [strength] gives no grade; steel beyond what carbon steel reaches is alloy steel.
            alloy=limits.alloy
            or (limits.tensile_strength is None and tensile > CRANKSHAFT_STRENGTHS[False]),
        )
        named_limits["crankshaft_stress"] = replace(picked, assumed=True)
        remarks.append(
            f"torsional stress of the crankshaft: {RULE_PICKED}; {rule_reason(engine_file)}"
        )
    if not {"axial_amplitude", "axial_force"} & set(named_limits):
        remarks.append(
            "axial vibration is not judged, because no limit is given and no general one is published; the "
            "engine maker can give limits.axial_amplitude or limits.axial_force"
        )
    unused = [f"limits.{name}" for name in IN_CLASS_DOCUMENT if getattr(limits, name) is not None]
    unused += [f"heat of {part.element}" for part in limits.elements if part.heat is not None]
    if unused:
        remarks.append(
            f"{', '.join(unused)}: not part of this verdict, but judged in the class document "
            "(`crankfem class`)"
        )
    if engine_file.ranges is not None:
        remarks.append(NOT_SAMPLED)
    remarks.append(
        f"orders above {engine_file.vibration.highest_order:g} are neither calculated nor judged "
        "(vibration.highest_order)"
    )
    if limits.passing_while_misfiring:
        basis = "limits.passing_while_misfiring"
        named_limits = {
            name: replace(limit, misfiring_basis=basis) for name, limit in named_limits.items()
        }
    return named_limits, tuple(remarks)


def rule_of(engine: Engine) -> str:
    """Return the name of the rule for the crankshaft if the file gives none."""
    return RULE_OF_DRIVEN[engine.drives or "propeller"]


def rule_reason(engine_file: EngineFile) -> str:
    """Say which rule is picked for the crankshaft, and why."""
    driven, rule = _driven(engine_file), rule_of(engine_file.engine)
    if driven is not None:
        field = "engine.drives" if engine_file.engine.drives else "load.law"
        return f"the rule {rule!r}, because the engine drives a {driven} ({field})"
    return (
        f"the rule {rule!r}, because the file does not say what the engine drives; for a "
        'generating set of constant speed write drives = "generator" in [engine]'
    )


def unmodeled_plant(engine_file: EngineFile) -> tuple[str, ...]:
    """Say what of a plant that the file names is left out: the other machine, or an engine's forces."""
    driver = engine_file.engine.driven_by
    other, section = (driver, "driver") if driver else (_driven(engine_file), "driven")
    left_out = []
    if driver == "engine":
        left_out.append(
            "The forces of the engine that drives this machine are not part of the calculation."
        )
    if other is not None and engine_file.behind_coupling is None and not engine_file.shaft_lines:
        left_out.append(
            f"The {other} and its shafts are not modeled (no [{section}], no [shaft_line]): the verdict "
            f"holds for the {'machine' if driver else 'engine'} with its flywheel alone, not for the plant."
        )
    return tuple(left_out)


def _driven(engine_file: EngineFile) -> str | None:
    """Return what the engine drives, by the file's engine.drives or by the law of its load."""
    load = engine_file.load
    by_load = load is not None and load.law == "propeller"
    return engine_file.engine.drives or ("propeller" if by_load else None)


def strengths(engine_file: EngineFile) -> tuple[float, float]:
    """Return the tensile and the yield strength for the crankshaft's rule [Pa].

    Those in the file, the tensile strength in [limits] or [strength], else those of the plain steel
    of the rules.

    Raises
    ------
    InputError
        If a yield strength alone is given, above that tensile strength.
    """
    limits, steel = engine_file.limits or LimitsInput(), engine_file.strength
    tensile = BASE_STRENGTH if steel is None else steel.tensile_strength
    tensile, yielding = limits.tensile_strength or tensile, limits.yield_strength or BASE_YIELD
    if yielding > tensile:
        raise InputError(
            f"limits.yield_strength: given {format_quantity(yielding, 'Pa')} without tensile_strength, for "
            f"which {format_quantity(tensile, 'Pa')} is taken from "
            f"{'the plain steel of the rules' if steel is None else '[strength]'}; allowed is that or less, "
            "or both, because a steel yields before it breaks."
        )
    return tensile, yielding


def assessment_end_speeds(engine_file: EngineFile) -> tuple[float, ...]:
    """Return the speeds at which the assessment ends [rad/s], ascending, the lowest running speed first.

    That of a limit is the highest running speed, or the end of its rule above it; an engine without
    gas pressure is not assessed and has the running range only.
    """
    engine = engine_file.engine
    running = (engine.lowest_speed, engine.highest_speed)
    if engine_file.gas is None and engine_file.gas_map is None:
        return running
    ends = {limit_end_speed(limit, running) for limit in engine_limits(engine_file)[0].values()}
    return tuple(sorted({*running, *ends}))


def bending_speeds(engine_file: EngineFile) -> tuple[float, ...]:
    """Return the speeds at which a limit may have a kink or jump [rad/s]: rated speed and end of passing."""
    limits, _ = engine_limits(engine_file)
    ends = [limit.passing.high for limit in limits.values() if limit.passing is not None]
    finite = [end for end in ends if np.isfinite(end)]
    beyond = [end * (1.0 + BEYOND) for end in finite]
    return tuple(sorted({engine_file.engine.rated_speed, *finite, *beyond}))


def judges_axial(engine_file: EngineFile) -> bool:
    """Whether any limit is on the axial vibration."""
    return any(
        LIMITED[name].kind == "axial" for name in LIMITED.keys() & engine_limits(engine_file)[0]
    )


def limited_series(
    engine_file: EngineFile, axial: Limited, torsional: Limited, names: Iterable[str] = ()
) -> dict[str, OrderSeries]:
    """Return the quantity of each limit of `engine_limits`, or of those named, by its name."""
    answers, quantities = {"axial": axial, "torsional": torsional}, limited_quantities(engine_file)
    return {
        name: quantities[name].series(answers[quantities[name].kind])
        for name in names or engine_limits(engine_file)[0]
    }


def limit_findings(
    engine_file: EngineFile, axial: Limited, torsional: Limited
) -> list[tuple[VibrationLimit, AmplitudeCurve]]:
    """Return each limit with each curve over the speed that it applies to."""
    limits, _ = engine_limits(engine_file)
    return [
        (limits[name], curve)
        for name, series in limited_series(engine_file, axial, torsional).items()
        for curve in curves_of(series)
    ]


def engine_verdict(engine_file: EngineFile, findings: Findings) -> Verdict:
    """Compare an engine's vibration, as `limit_findings` returns it, with its limits."""
    return judge(findings, *_judged_by(engine_file))


def engine_ranges(engine_file: EngineFile, findings: Findings) -> tuple[BarredRange, ...]:
    """Return the ranges of an `engine_verdict` alone, which decide its status."""
    running, rule, full_load = _judged_by(engine_file)
    return barred_ranges(findings, rule, running, full_load)


def _judged_by(engine_file: EngineFile) -> tuple[tuple[float, float], BarredRangeRule, bool]:
    """Return running range, rule, and whether the load is full load at all speeds."""
    engine, load = engine_file.engine, engine_file.load
    rule = (engine_file.limits or LimitsInput()).barred_rule(engine.rated_speed)
    full_load = engine_file.gas_map is None and (load is None or load.law == "constant")
    return (engine.lowest_speed, engine.highest_speed), rule, full_load


def even_firing_interval(firing_angles: Sequence[float], strokes: int) -> float | None:
    """Return the angle between firings if it is constant [deg], to a hundredth.

    Parameters
    ----------
    firing_angles : sequence of float
        Of the cylinders [rad].
    strokes : int
        2 or 4.

    Returns
    -------
    float or None
        None if intervals differ.
    """
    cycle = 180.0 * strokes
    angles = np.sort(np.rad2deg(firing_angles) % cycle)
    intervals = np.diff(angles, append=angles[0] + cycle)
    even = cycle / angles.size
    return round(even, 2) if np.all(np.abs(intervals - even) < UNEVEN) else None


def refuse_limits(engine_file: EngineFile) -> None:
    """Refuse limits on parts that the engine lacks, rules that do not fit, limits without excitation."""
    _ = engine_limits(engine_file)
    compliances = np.full(len(engine_file.throw_angles_deg), ANY_COMPLIANCE)
    inertias = engine_throw_inertias(engine_file, ANY_INERTIA)
    named = engine_torsional_chain(engine_file, compliances, inertias)
    if engine_file.limits is None:
        return
    if engine_file.gas is None and engine_file.gas_map is None:
        raise InputError(
            "limits: given without gas pressure; allowed are both, because amplitudes need what excites "
            "them: a section [gas] or [gas_map]."
        )
    check_limited_elements(engine_file.limits, named.chain, engine_file.engine)


def check_limited_elements(limits: LimitsInput, chain: Chain, engine: Engine) -> None:
    """Refuse limits on elements that the torsional chain does not have."""
    elements, coupling = chain.elements, coupling_of(engine)
    for name in ("coupling_torque", "coupling_heat"):
        if getattr(limits, name) is not None and coupling not in elements:
            section = "driver" if engine.driven_by else "driven"
            raise InputError(
                f"limits.{name}: given without the section [{section}]; allowed are both, because the "
                f"coupling joins the {engine.driven_by or DRIVEN}."
            )
    limited = [
        (f"limits.{table}[{place}].element", part.element, known)
        for table, known in (("shafts", elements), ("elements", (*elements, *dashpot_names(chain))))
        for place, part in enumerate(getattr(limits, table))
    ]
    for field, element, known in limited:
        if element not in known:
            raise InputError(
                f"{field}: given {element!r}; {did_you_mean(element, known)}allowed are {', '.join(known)}, "
                "because the torsional chain has these elements."
            )
        if element == coupling and (limits.coupling_torque or limits.coupling_heat):
            raise InputError(
                f"{field}: given {element!r} together with coupling_torque or coupling_heat; allowed is one "
                "of the two, because both limit that coupling."
            )


@dataclass(frozen=True, eq=False)
class ComparedQuantity:
    """A quantity compared between normal firing and misfiring."""

    name: str
    unit: str
    limit: VibrationLimit | None

    def while_firing(self, failing: Sequence[int]) -> VibrationLimit | None:
        """Return the limit that applies while cylinders fail; none of them in normal firing."""
        if self.limit is None or not failing:
            return self.limit
        return replace(self.limit, continuous=self.limit.misfiring, passing=None)


def compared_quantities(engine_file: EngineFile) -> dict[str, ComparedQuantity]:
    """Return name, unit and limit of each possible item of `compared_series`, by its key."""
    compared = {key: ComparedQuantity(name, unit, None) for key, (name, unit) in COMPARED.items()}
    return compared | {
        key: ComparedQuantity(limit.name, limit.unit, limit)
        for key, limit in engine_limits(engine_file)[0].items()
    }


def compared_series(
    engine_file: EngineFile, axial: Limited, torsional: Limited
) -> dict[str, OrderSeries]:
    """Return the quantities with limits, and motions and torques of `COMPARED` that the engine has."""
    loads = torsional.loads.elements
    coupled = coupling_of(engine_file.engine) in loads.names
    coupling = ("coupling_torque",) if coupled else ()
    names = (*engine_limits(engine_file)[0], "torsional_amplitude", "axial_amplitude", *coupling)
    compared = limited_series(engine_file, axial, torsional, names)
    for loads_of_part in (loads, torsional.loads.dashpots):
        rings = [place for place, name in enumerate(loads_of_part.names) if name.endswith(DAMPER)]
        if rings:
            names = tuple(loads_of_part.names[place] for place in rings)
            compared["damper_torque"] = replace(
                loads_of_part, values=loads_of_part.values[:, :, rings], names=names
            )
    return compared
