"""Torsional vibration up to 120 % of rated speed, firing normally and with each cylinder failing."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankfem.analyses.vibration.chain_answers import ChainAnswer, EngineChains
from crankfem.analyses.vibration.engine_excitation import (
    calculated_speeds,
    engine_harmonics,
    failing_harmonics,
    forces_over_speeds,
    merged_speeds,
)
from crankfem.analyses.vibration.engine_limits import (
    DAMPER,
    at_place,
    engine_limits,
    limited_quantities,
)
from crankfem.analyses.vibration.misfiring import (
    Cylinders,
    Reached,
    Series,
    Superposition,
    worst_of,
)
from crankfem.analyses.vibration.run import EngineVibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.excitation_sections import Misfire
from crankfem.files.sections.limits_sections import LimitsInput
from dynamics.assessment.limits import VibrationLimit
from dynamics.chains.chain import Chain
from dynamics.indices import at_most, within, within_any
from dynamics.response.forced import ForcedResponse
from dynamics.response.loads import alternating_stress, section_modulus, varying_stiffness
from dynamics.response.series import OrderSeries

# Speeds are calculated up to this share of the rated one, as class rules ask.
HIGHEST_SHARE = 1.2
STRESS, TORQUE, DASHPOTS, GEARS, GENERATOR = "stress", "torque", "dashpots", "gears", "generator"
MISFIRING, CUT_OUT = "one cylinder misfiring", "one cylinder cut out"
MEANING = {
    MISFIRING: "no combustion in the cylinder, which still compresses",
    CUT_OUT: "no gas force in the cylinder, whose running gear still moves",
}
# Of what drives a generator, from the most particular on.
GENERATOR_NODES = ("driven machine", "generator", "flywheel")


@dataclass(frozen=True, eq=False)
class FiringCase:
    """Results of one case of firing.

    Attributes
    ----------
    kept : dict
        Key of a series and location to the worst at running speeds outside the ranges to be barred: the
        largest use of the limit that then applies, without a limit the largest amplitude.
    passed : dict
        The same in these ranges, compared with the limit for passing; empty without such a range, and if
        a cylinder fails.
    largest : dict
        The same to the largest amplitude at any calculated speed.
    heat : dict
        Damper or coupling to the largest heat at these speeds [W] and its speed [rad/s].
    """

    kept: Mapping[tuple[str, str], Reached]
    passed: Mapping[tuple[str, str], Reached]
    largest: Mapping[tuple[str, str], Reached]
    heat: Mapping[str, tuple[float, float]]


@summarized("speeds [rad/s]", "limits", "notes")
@dataclass(frozen=True, eq=False)
class FiringCases:
    """Torsional vibration of an engine up to 120 % of its rated speed in all cases of firing.

    Attributes
    ----------
    speeds : (S,) array
        [rad/s].
    normal : dict
        Of normal firing: key to its series by orders; stress [Pa], torque of elements and dashpots
        [N m], torque of gears on their driven nodes [N m], amplitude of the generator [electrical rad].
    firing : FiringCase
    failing : dict
        `MISFIRING` and `CUT_OUT` to the case of each cylinder, from 1; without unknown ones.
    envelopes : dict
        The same to the largest stress at each speed and location with any cylinder failing [Pa].
    mean_torque : (S,) array
        Of the engine firing normally [N m].
    limits : dict
        Key of a series and location to its limit.
    notes : tuple of str
        Omitted calculations, and why.
    """

    speeds: Array
    normal: Series
    firing: FiringCase
    failing: Mapping[str, Mapping[int, FiringCase]]
    envelopes: Mapping[str, Array]
    mean_torque: Array
    limits: Mapping[tuple[str, str], VibrationLimit]
    notes: tuple[str, ...]

    def worst_cylinder(self, way: str, key: str, place: str) -> int:
        """Return the number of the cylinder whose failing is worst for a location."""
        cases = self.failing[way]
        return max(cases, key=lambda number: cases[number].kept[key, place].severity)

    def worst(self, way: str, key: str, place: str) -> Reached:
        """Return the worst of a location with any cylinder failing."""
        return self.failing[way][self.worst_cylinder(way, key, place)].kept[key, place]


def firing_cases(run: EngineVibration) -> FiringCases:
    """Calculate all cases of firing.

    Parameters
    ----------
    run : EngineVibration
        With gas pressure.
    """
    file = run.engine_file
    chains = EngineChains.of(file, run.axial, run.torsional, run.shaft)
    share, notes = HIGHEST_SHARE, []
    harmonics = engine_harmonics(file, share)
    speeds = calculated_speeds(file, harmonics.orders, chains.damped, above_rated=share)
    # Those at which the vibration found its worst, closer than a grid.
    checks = () if run.assessment is None else run.assessment.verdict.checks
    worst = [use.speed for check in checks for use in (check.running, check.above) if use]
    misfiring_checks = () if run.misfiring is None else run.misfiring.checks
    worst += [reached.speed for check in misfiring_checks for reached in check.each.values()]
    speeds = merged_speeds(speeds, [speed for speed in worst if speed <= speeds[-1]])
    if not at_most(share * file.engine.rated_speed, speeds[-1]):
        notes.append(
            f"speeds are calculated up to {speeds[-1] / file.engine.rated_speed:.3g} of the rated one, "
            "where the load in the engine file ends"
        )
    limits = place_limits(file)
    damping = heat_factors(run.torsional_chain)
    if run.torsional_chain.varying:
        notes.append("heat in springs that vary is calculated with their constant stiffness")
    barred = [] if run.assessment is None else run.assessment.verdict.ranges_to_bar
    # Running speeds that may be kept, and those in ranges to be barred.
    running = within(speeds, file.engine.lowest_speed, file.engine.highest_speed)
    passed = within_any(speeds, barred)
    judge = _Judge(limits, damping, running & ~passed, running & passed)
    failing: dict[str, dict[int, FiringCase]] = {}
    envelopes: dict[str, Array] = {}
    normal: Series = {}
    firing = None
    ways = ((MISFIRING, True), (CUT_OUT, False))
    for way, compression in ways[1:] if file.engine.driven_by else ways:
        misfire = Misfire(compression=compression)
        try:
            cold = failing_harmonics(file, harmonics, share, misfire=misfire)
        except InputError as error:
            notes.append(f"{way} is not calculated: {error}")
            continue
        whole = file.changed(misfire=None)
        undamped_chains = EngineChains(
            whole, chains.pulled, chains.cranks, chains.damped, chains.shaft
        )
        added = Superposition(undamped_chains, harmonics, cold, torsional_series)
        cases: list[Cylinders] = [(cylinder,) for cylinder in range(1, file.engine.cylinders + 1)]
        for case, answer in added.at(speeds, cases if firing else [(), *cases]):
            if not case:
                normal, firing = answer, judge.case(answer, case)
                continue
            failing.setdefault(way, {})[case[0]] = judge.case(answer, case)
            amplitude = answer[STRESS].synthesis.amplitude
            envelopes[way] = np.maximum(envelopes.get(way, amplitude), amplitude)
    assert firing is not None  # a cylinder without gas can always be calculated
    mean = forces_over_speeds(file, harmonics, speeds).mean_torque
    return FiringCases(speeds, normal, firing, failing, envelopes, mean, limits, tuple(notes))


def torsional_series(file: EngineFile, _: ChainAnswer, torsional: ChainAnswer) -> Series:
    """Return the quantities of the document for one response of the torsional chain; linear in the forces."""
    loads, response = torsional.loads, torsional.response
    # Nominal stress of all parts of the crankshaft, and of shafts with diameters in [limits].
    moduli = {loads.elements.names[place]: modulus for place, modulus in torsional.moduli.items()}
    for shaft in (file.limits or LimitsInput()).shafts:
        moduli[shaft.element] = float(section_modulus("torsional", shaft.diameter))
    stresses = alternating_stress(loads, moduli)
    series = {STRESS: stresses, TORQUE: loads.elements, DASHPOTS: loads.dashpots}
    if torsional.engine_chain.chain.gears:
        series[GEARS] = _gear_torques(response, torsional.engine_chain.chain)
    if file.engine.generator_poles is not None:
        node = generator_node(torsional.engine_chain.chain)
        place = torsional.engine_chain.nodes.index(node)
        values = 0.5 * file.engine.generator_poles * response.motion[:, :, [place]]
        series[GENERATOR] = replace(loads.elements, values=values, names=(node,))
    return series


def generator_node(chain: Chain) -> str:
    """Return the node that turns with the generator's rotor."""
    return next(name for name in GENERATOR_NODES if name in chain.names)


def _gear_torques(response: ForcedResponse, chain: Chain) -> OrderSeries:
    """Torque of each gear on its driven node: that which holds the node in equilibrium.

    At a node the sum of inertia, springs, dampers and outside torques is zero except for its gears; a node
    in several gears has their sum.
    """
    w = response.angular_frequencies[:, :, np.newaxis]
    stiffness = chain.stiffness_matrix() + 1j * chain.loss_matrix()
    nodes = [gear.driven for gear in chain.gears]
    x = response.motion
    held = (
        x @ stiffness[nodes].T
        + 1j * w * (x @ chain.damping_matrix()[nodes].T)
        - w**2 * (x @ chain.mass_matrix()[nodes].T)
    )
    names = tuple(f"{chain.names[one.driver]} / {chain.names[one.driven]}" for one in chain.gears)
    springs = chain.varying_springs(np.eye(x.shape[2]))
    for (_, added), spring in zip(varying_stiffness(response), springs, strict=True):
        held += (added * (x @ spring.row))[:, :, np.newaxis] * spring.row[nodes]
    values = held - response.excitation.forces[:, :, nodes]
    return OrderSeries(response.orders, response.speeds, values, response.unbounded, names)


def place_limits(file: EngineFile) -> dict[tuple[str, str], VibrationLimit]:
    """Return the limits by their location; "" is each location of the crankshaft."""
    limits, quantities = engine_limits(file)[0], limited_quantities(file)
    shown = {"Pa": (STRESS,), "N m": (TORQUE, DASHPOTS)}
    return {
        (key, quantities[name].element): limit
        for name, limit in limits.items()
        for key in shown.get(limit.unit, ())
    }


def heat_factors(chain: Chain) -> dict[tuple[str, str], tuple[float, float, float]]:
    """Return stiffness, loss factor and damping of all dissipative parts, by series and location.

    Dashpots have no stiffness; parts of the crankshaft with damping of their own are included.
    """
    factors = {}
    for name, *values in zip(
        chain.elements, chain.stiffness, chain.loss_factor, chain.damping, strict=True
    ):
        stiffness, loss, damping = map(float, values)
        if loss or damping:
            factors[TORQUE, name] = (stiffness, loss, damping)
    for dashpot in chain.dashpots:
        name = f"{chain.names[dashpot.left]} - {chain.names[dashpot.right]}"
        factors[DASHPOTS, name] = (0.0, 0.0, dashpot.damping)
    return factors


def heat_of(series: OrderSeries, place: str, values: tuple[float, float, float]) -> Array:
    """Return the heat of a damper at each speed, all orders together, from the torque in it (S,) [W].

    Notes
    -----
    A twist of amplitude D at w takes w (k eta + w c) D^2 / 2, and the torque is |k (1 + i eta) + i w c| D.
    """
    stiffness, loss, damping = values
    w = np.outer(series.orders, series.speeds)
    torque = np.abs(series.values[:, :, series.names.index(place)])
    resisting = stiffness * loss + w * damping
    return np.asarray(
        np.sum(0.5 * w * resisting * torque**2 / (stiffness**2 + resisting**2), axis=0)
    )


def damper_places(chain: Chain) -> tuple[tuple[str, str], ...]:
    """Return the parts of torsional dampers, by series and location."""
    return tuple(key for key in heat_factors(chain) if key[1].endswith(DAMPER))


@dataclass(frozen=True, eq=False)
class _Judge:
    """Finds the worst of each location in one case of firing."""

    limits: Mapping[tuple[str, str], VibrationLimit]
    damping: Mapping[tuple[str, str], tuple[float, float, float]]
    kept: Flags
    passed: Flags

    def case(self, answer: Series, failing: Cylinders) -> FiringCase:
        kept, passed, largest = {}, {}, {}
        for key, series in answer.items():
            inside = _at_speeds(series, self.kept)
            between = _at_speeds(series, self.passed)
            for place in series.names:
                limit = limit_of(self.limits, key, place)
                if limit is not None and failing:
                    limit = replace(limit, continuous=limit.misfiring, passing=None)
                kept[key, place] = worst_of(at_place(inside, place), limit)
                largest[key, place] = worst_of(at_place(series, place), None)
                if limit is not None and limit.passing is not None and np.any(self.passed):
                    quick = replace(limit, continuous=limit.passing)
                    passed[key, place] = worst_of(at_place(between, place), quick)
        heat = {}
        for (key, place), values in self.damping.items():
            inside = _at_speeds(answer[key], self.kept)
            over_speed = heat_of(inside, place, values)
            top = int(np.argmax(over_speed))
            heat[place] = (float(over_speed[top]), float(inside.speeds[top]))
        return FiringCase(kept, passed, largest, heat)


def limit_of(
    limits: Mapping[tuple[str, str], VibrationLimit], key: str, place: str
) -> VibrationLimit | None:
    """Return the limit of a location; for a part of the crankshaft that of all parts."""
    return limits.get((key, place)) or limits.get((key, ""))


def _at_speeds(series: OrderSeries, some: Flags) -> OrderSeries:
    return replace(
        series,
        speeds=series.speeds[some],
        values=series.values[:, some],
        unbounded=series.unbounded[:, some],
    )
