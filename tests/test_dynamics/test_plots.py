"""What results draw and tabulate: their own numbers, on the axes given, with units."""

import math
from functools import cache, partial
from operator import attrgetter
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from comparing import close
from crankbase.errors import InputError, MissingLibraryError
from crankbase.frames import table_of
from crankbase.results import Result
from dynamics.assessment.barred_ranges import BarredRangeRule
from dynamics.assessment.damper_sizing import SizedDamper
from dynamics.assessment.limits import AmplitudeCurve, given_limit
from dynamics.assessment.separation import CriticalRange
from dynamics.assessment.uncertainty import Samples, Spread
from dynamics.assessment.verdict import Trial, decide, judge
from dynamics.balance import HingedRodEffects, Hodograph, balance
from dynamics.chains.chain import Chain
from dynamics.chains.dampers import ViscousDamper
from dynamics.crankshaft.chain_comparison import ChainVerdict, ModeMatch, ResponseMatch
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.shaft_modes import CrankshaftSystem, ShaftModes
from dynamics.critical import critical_speeds
from dynamics.engine.forces import LoadDiagram, mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.excitation.chain_excitation import AxialForceComparison, axial_force_over_cycle
from dynamics.excitation.cylinders import CylinderForces
from dynamics.excitation.pressure_map import pressure_map
from dynamics.gas.gas_cycle import GasCycleResult
from dynamics.gas.pressure import gas_pressure
from dynamics.harmonics import TorqueTable, harmonics
from dynamics.plots.campbell import LABEL_ROOM, campbell_frame
from dynamics.plots.harmonics import KIND_COLORS
from dynamics.plots.load_diagrams import LABEL_HALF, label_spots, square_round
from dynamics.response.complex_modes import complex_modes
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.loads import element_loads, power_balance
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.peak_cause import peak_cause
from dynamics.response.resonance import campbell_diagram, resonances
from dynamics.torque import Star, engine_torque, pin_force_harmonics
from dynamics.transient.motions import SteadyMotion, TransientMotion
from dynamics.transient.propagator import SpeedCurve
from dynamics.transient.turning_run import TurningCycle, TurningRun
from dynamics.turning.free_turning import FreeTurning, WorkShare
from dynamics.turning.speed_over_angle import SpeedOverAngle
from refusals import refusals, refused
from satellite_cases import of_satellites

RPM = 30.0 / math.pi
CHAIN = Chain([0.3, 0.2, 2.0], [4e4, 5e4], damping=3.0, names=["pulley", "crank", "flywheel"])
SPEEDS = np.linspace(50.0, 150.0, 5)
ANGLES = np.radians(np.arange(0.0, 720.0, 30.0))
ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)


def rising(*shape):
    """Numbers that all differ."""
    return 1.0 + np.arange(math.prod(shape), dtype=float).reshape(shape)


@cache
def modes():
    return CHAIN.modes()


@cache
def response(undamped=False):
    """Forced at two orders; without damping the third speed is unbounded by order 2."""
    chain = Chain([1.0, 1.0], [2e4], names=["pulley", "flywheel"])  # 200 rad/s
    acting = OrderExcitation([1.0, 2.0], SPEEDS, np.ones((2, 5, 2)) * [1.0, -0.5])
    return forced_response(
        damped(chain, undamped=True) if undamped else damped(chain, magnifier=20.0), acting
    )


@cache
def loads():
    return element_loads(response())


@cache
def engine():
    cylinders = [
        EngineCylinder(0.12, 3.0, ROD, crank_angle_deg=math.degrees(angle), position=0.2 * place)
        for place, angle in enumerate((0.0, math.pi / 2.0))
    ]
    return EngineLayout(0.07, cylinders, [1, 2])


@cache
def gas():
    return gas_pressure(np.linspace(2e5, 1e5, 720), angles_deg=np.arange(0.0, 720.0, 1.0))


@cache
def torque():
    return engine_torque(engine(), 150.0, gas(), samples=24)


@cache
def pin_harmonics():
    return pin_force_harmonics(engine(), 150.0, gas(), samples=24, highest_order=6.0)[0]


@cache
def forces():
    return mechanism_forces(
        engine(), 150.0, 1e3 * rising(2, ANGLES.size), shaft_angles_deg=np.degrees(ANGLES)
    )


@cache
def verdict():
    values = 50e6 / (1.0 + ((SPEEDS - 100.0) / 5.0) ** 2)
    limit = given_limit("torsional stress", 40e6, "Pa", applies_to="shaft", source="sheet")
    curves = [AmplitudeCurve("shaft 1 - 2", SPEEDS, values)]
    curves.append(AmplitudeCurve("shaft 2 - 3", SPEEDS, 0.2 * values))
    return judge([(limit, one) for one in curves], (60.0, 140.0), BarredRangeRule(140.0))


@cache
def sized():
    limit = given_limit("torque", 2e3, "N m", applies_to="coupling", source="sheet")
    curve, without = (AmplitudeCurve("c", SPEEDS, top * rising(5)) for top in (100.0, 900.0))
    damper = ViscousDamper(0.2, 10.0)
    sizes, used = np.array([0.1, 0.2]), np.array([1.4, 0.25])
    return SizedDamper(
        damper, CHAIN, True, limit, curve, without, 0.25, 2.25, sizes, used, "It does."
    )


@cache
def shaft_modes():
    shares = np.array([[0.0, 0.7, 0.1], [1.0, 0.2, 0.1], [0.0, 0.1, 0.8]])
    names = ("rotation about the shaft axis", "mode 1", "mode 2")
    motions = rising(4, 6, 3) - 30.0
    places = np.array([0.0, 0.4, 0.2, 0.6])
    return ShaftModes(
        np.array([0.0, 300.0, 500.0]), np.eye(3), 1, names, shares, np.ones(3), motions, places
    )


@cache
def coupled():
    """Of a chain in place of a shaft: its nodes are the points."""
    one = response()
    shaft = SimpleNamespace(names=("main bearing 1 uz", "damper ring"), system=one.system)
    shaft.point = partial(CrankshaftSystem.point, shaft)
    return CoupledResponse(shaft, one, one)


@cache
def pressures():
    angles = np.radians(np.arange(0.0, 720.0, 5.0))
    low, high = (
        gas_pressure(np.linspace(top, 1e5, 144), angles_deg=np.degrees(angles))
        for top in (2e5, 3e5)
    )
    return pressure_map([(100.0, 0.5, low), (100.0, 1.0, high)], method="linear")


@cache
def run():
    time = np.linspace(0.0, 1.0, 101)
    angle = 100.0 * time + 25.0 * time**2
    motion = np.sin(angle)[:, np.newaxis] * [1e-3, 2e-3, 1e-4]
    load = np.sin(angle)[:, np.newaxis] * [300.0, 50.0]
    return TransientMotion(
        time=time,
        shaft_speed=100.0 + 50.0 * time,
        shaft_angle_deg=np.degrees(angle),
        motion=motion,
        rigid_motion=0.0 * motion,
        torque=load,
        complete=True,
        step=0.01,
        force_error=0.0,
        orders=np.array([1.0]),
        system=SimpleNamespace(chain=CHAIN),
        notes=(),
    )


@cache
def turning_run():
    one = run()
    rest = {name: rising(101) for name in ("kinetic_energy", "strain_energy")}
    rest |= {name: rising(101) for name in ("gas_work", "load_work", "damping_work")}
    return TurningRun(
        time=one.time,
        shaft_angle_deg=one.shaft_angle_deg,
        shaft_speed=one.shaft_speed,
        motion=one.motion,
        speed=100.0 + one.motion,
        torque=one.torque,
        turns=1,
        complete=True,
        system=one.system,
        notes=(),
        **rest,
    )


def steady(unbounded=False):
    motion, load = rising(24, 3) * 1e-4, rising(24, 2)
    system = SimpleNamespace(chain=CHAIN)
    return SteadyMotion(100.0, 2, np.degrees(ANGLES), motion, load, unbounded, 0.01, system, "")


@cache
def turning_cycle():
    one = steady()
    rest = (0.0, 0.0, 0.0, 0.0, 0.0, SimpleNamespace(system=one.system), "")
    motion = one.motion
    return TurningCycle(
        100.0, 2, 50.0, np.degrees(ANGLES), motion, 100.0 + motion, one.torque, *rest
    )


@cache
def free_turning():
    time = np.linspace(0.0, 1.0, 5)
    shares = [WorkShare(number * rising(5), -number * rising(5)) for number in (1, 2, 3, 4)]
    return FreeTurning(time, np.degrees(10.0 * time), rising(5), rising(5), rising(5), *shares)


@cache
def turning():
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    return SpeedOverAngle(np.degrees(angle), 100.0 + np.sin(angle), angle / 100.0, rising(9))


@cache
def axial_comparison():
    alone = rising(2, 5, 2) * (1.0 + 1.0j)
    return AxialForceComparison(
        np.array([0.5, 1.0]), SPEEDS, alone, 1.1 * alone, np.array([[1.0, 0.5, -0.2]])
    )


@cache
def cylinder_forces():
    phasors = rising(2, 5, 2) * (1.0 - 1.0j)
    means = rising(5, 2)
    orders = np.array([0.5, 1.0])
    return CylinderForces(orders, SPEEDS, phasors, 2.0 * phasors, means, means, 0.07, (0, 1))


@cache
def load_diagram():
    return LoadDiagram(
        "pin", np.degrees(ANGLES), 1e3 * (3.0 + 4.0j) * np.exp(1j * (0.5 + ANGLES)), np.degrees(0.5)
    )


@cache
def samples():
    spreads = (Spread("stiffness", 0.9, 1.1, (0,)),)
    values = np.append(np.linspace(1.0, 2.0, 9), np.inf)[:, np.newaxis]
    return Samples(spreads, np.linspace(0.9, 1.1, 10)[:, np.newaxis], values, np.array([1.5]))


@cache
def effects():
    curves = (Hodograph(1, size, 0.2 * size) for size in (1e3, 2e3, 3e3, 4e3))
    return HingedRodEffects(1, *curves)


@cache
def cycle():
    volume = SimpleNamespace(at=lambda *, angle_deg: 1e-3 * (2.0 - np.cos(np.radians(angle_deg))))
    return GasCycleResult(gas(), None, volume, 1e3, 4e2, 8e5, 1e5)


def torque_table():
    return TorqueTable(np.arange(0.0, 720.0, 90.0), rising(8), "", 4)


def star():
    return Star(1.0, np.array([0.0, 2.0]), np.ones(2))


def balanced():
    return balance(engine(), 100.0)


def hodograph():
    return Hodograph(1, 100.0, 20.0)


def response_match():
    return ResponseMatch("axial", SPEEDS, rising(5), 2.0 * rising(5))


def six_samples():
    return harmonics([0.0, 1.0, 0.0, -1.0, 2.0, 0.0], 4)


def closed(values):
    return np.append(values, values[0])


def axial_cycle():
    return axial_force_over_cycle(
        50.0,
        rising(16).reshape(4, 2, 2),
        [1e-9, 2e-9],
        1e-10 * rising(8).reshape(2, 2, 2),
        thrust_bearing=np.array([1e3, 3e3, -2e3, 0.5e3]),
        shaft_angles_deg=90.0 * np.arange(4.0),
    )


def over_cycle(degrees, values):
    """Degrees and values with the closing sample, which the object leaves out."""
    return np.append(degrees, degrees[-1] + degrees[1] - degrees[0]), closed(values)


def rpm_of(found):
    return RPM * found.speeds


DEGREES = np.degrees(ANGLES)
# Of each case: the object, options of plot(), and by label a line that must be there: x and y as drawn.
CASES = {
    "Modes": (modes, {}, lambda o: {None: along_pairs(o.shapes[:, 1])}),
    "Modes, one": (modes, {"count": 1}, lambda o: {None: along_pairs(o.shapes[:, 1])}),
    "OrderSeries": (
        lambda: response().nodes,
        {"place": "flywheel", "quantity": "twist"},
        lambda o: {
            "order 2": (rpm_of(o), 1e3 * o.amplitude[1, :, 1]),
            "all orders (synthesis)": (rpm_of(o), 1e3 * o.synthesis.amplitude[:, 1]),
            "plain sum": (rpm_of(o), 1e3 * o.synthesis.plain_sum[:, 1]),
        },
    ),
    "OrderSeries, limits": (
        lambda: response().nodes,
        {"limits": {"limit": 1e-4}, "barred": [(70.0, 80.0)], "main_orders": 1},
        lambda o: {"limit": (rpm_of(o), np.full(5, 1e-4))},
    ),
    "ForcedResponse": (
        response,
        {"node": "pulley", "quantity": "twist"},
        lambda o: {"order 1": (rpm_of(o), 1e3 * o.elastic.amplitude[0, :, 0])},
    ),
    "ForcedResponse, whole": (
        response,
        {"elastic": False},
        lambda o: {"order 1": (rpm_of(o), o.amplitude[0, :, 0])},
    ),
    "ElementLoads": (
        loads,
        {"quantity": "torque"},
        lambda o: {"order 1": (rpm_of(o.elastic), 1e-3 * o.elastic.amplitude[0, :, 0])},
    ),
    "ElementLoads, ground": (
        loads,
        {"element": "flywheel", "part": "ground"},
        lambda o: {"order 1": (rpm_of(o.ground), o.ground.amplitude[0, :, 1])},
    ),
    "PowerBalance": (
        lambda: power_balance(response()),
        {},
        lambda o: {"power in": (rpm_of(o), 1e-3 * o.power_in.sum(axis=0))},
    ),
    "CylinderForces": (
        cylinder_forces,
        {"cylinder": 2, "show": "radial"},
        lambda o: {"order 0.5": (rpm_of(o), 1e-3 * np.abs(o.radial[0, :, 1]))},
    ),
    "AxialForceComparison": (
        axial_comparison,
        {"throw": 2},
        lambda o: {"order 1, throw alone": (rpm_of(o), 1e-3 * np.abs(o.alone[1, :, 1]))},
    ),
    "PressureMap": (
        pressures,
        {},
        lambda o: {
            "954.9 1/min": over_cycle(o.diagrams[1].angles_deg, 1e-6 * o.diagrams[1].pressure)
        },
    ),
    "PressureMap, at": (pressures, {"speed": 100.0, "load": 0.75}, None),
    "AxialForceOverCycle": (
        axial_cycle,
        {},
        lambda o: {
            "on the thrust bearing, vibrating": (
                [0.0, 90.0, 180.0, 270.0, 360.0],
                1e-3 * np.append(o.thrust_bearing, o.thrust_bearing[0]),
            )
        },
    ),
    "Harmonics": (
        six_samples,
        {"unit": "N m", "highest_order": 1.0},
        None,
    ),
    "Harmonics, curves": (
        six_samples,
        {"unit": "N m", "show": "curves", "highest_order": 1.0},
        lambda o: {
            f"order 0.5: {o.amplitude[0]:.3f} N m, {np.degrees(o.phase[0]):.1f} deg": (
                np.linspace(0.0, 720.0, 721),
                o.amplitude[0] * np.sin(0.5 * np.radians(np.arange(721.0)) + o.phase[0]),
            )
        },
    ),
    "PinForceHarmonics": (pin_harmonics, {"highest_order": 2.0}, None),
    "TorqueTable": (
        torque_table,
        {},
        lambda o: {"table": (o.crank_angle_deg, o.torque)},
    ),
    "EngineTorque": (
        torque,
        {},
        lambda o: {"engine": over_cycle(o.shaft_angles_deg, 1e-3 * o.total)},
    ),
    "EngineTorque, throw": (
        torque,
        {"throw": 2},
        lambda o: {"both": over_cycle(o.shaft_angles_deg, 1e-3 * o.per_throw[1])},
    ),
    "Star": (star, {}, None),
    "MechanismForces": (forces, {}, lambda o: {"tangential, T": (DEGREES, 1e-3 * o.tangential[0])}),
    "LoadDiagram": (load_diagram, {}, lambda o: {None: (closed(DEGREES)[:-1], 1e-3 * o.magnitude)}),
    "LoadDiagram, polar": (
        load_diagram,
        {"frame": "crank"},
        lambda _: {"pin": (closed(np.full(24, 4.0)), closed(np.full(24, 3.0)))},
    ),
    "Balance": (
        balanced,
        {"show": "moment"},
        lambda o: {"order 1": tuple(np.array([-1e-3, 1e-3])[:, None] * o.of(1).moment.points(361))},
    ),
    "Hodograph": (
        hodograph,
        {},
        lambda o: {"order 1": tuple(np.array([-1e-3, 1e-3])[:, None] * o.points(361))},
    ),
    "HingedRodEffects": (effects, {}, None),
    "GasPressure": (
        gas,
        {},
        lambda o: {"pressure": over_cycle(o.angles_deg, 1e-6 * o.pressure)},
    ),
    "GasCycleResult": (
        cycle,
        {},
        lambda o: {
            None: (
                closed(1e3 * o.volume.at(angle_deg=o.pressure.angles_deg)),
                closed(1e-6 * o.pressure.pressure),
            )
        },
    ),
    "GasCycleResult, angle": (cycle, {"show": "pressure"}, None),
    "SteadyMotion": (
        steady,
        {"place": 1, "quantity": "force"},
        lambda o: {"crank - flywheel": over_cycle(DEGREES, 1e-3 * o.torque[:, 1])},
    ),
    "TransientMotion": (
        run,
        {"place": "pulley", "quantity": "twist", "steady": ([110.0, 140.0], [1.0, 2.0])},
        lambda o: {
            "amplitude over each turn": (o.envelope().time, 1e3 * o.envelope().motion[:, 0])
        },
    ),
    "TurningRun": (
        turning_run,
        {},
        lambda o: {
            "amplitude over each turn": (o.envelope().time, 1e-3 * o.envelope().torque[:, 0])
        },
    ),
    "Envelope": (
        lambda: run().envelope(),
        {"place": 1},
        lambda o: {"amplitude over 1 turn": (RPM * o.speed, 1e-3 * o.torque[:, 1])},
    ),
    "Envelope, time": (
        lambda: run().envelope(),
        {"quantity": "displacement", "over": "time"},
        lambda o: {"amplitude over 1 turn": (o.time, 1e6 * o.motion[:, 0])},
    ),
    "TurningCycle": (
        turning_cycle,
        {"quantity": "twist"},
        lambda o: {"pulley": over_cycle(DEGREES, 1e3 * o.motion[:, 0])},
    ),
    "SpeedCurve": (
        lambda: SpeedCurve([0.0, 1.0], [50.0, 150.0]),
        {},
        lambda o: {"speed": (o.times, RPM * o.speeds)},
    ),
    "FreeTurning": (free_turning, {}, lambda o: {"speed": (o.time, RPM * o.speed)}),
    "FreeTurning, work": (
        free_turning,
        {"show": "work"},
        lambda o: {"gravity": (o.time, 1e-3 * o.gravity.work)},
    ),
    "SpeedOverAngle": (turning, {}, lambda o: {"speed": (o.angle_deg, RPM * o.speed)}),
    "ShaftModes": (
        shaft_modes,
        {"radius": 0.1},
        lambda o: {
            "axial": (
                [0.0, 200.0, 400.0, 600.0],
                o.motions[[0, 2, 1, 3], 2, 1] / np.abs(o.motions[:, :3, 1]).max(),
            )
        },
    ),
    "CoupledResponse": (coupled, {}, None),
    "CoupledResponse, ring": (coupled, {"point": "damper ring"}, None),
    "SplitMotion": (
        lambda: coupled().split("main bearing 1 uz"),
        {},
        lambda o: {"all forces": (rpm_of(o), 1e6 * o.both_sum)},
    ),
    "ResponseMatch": (
        response_match,
        {},
        lambda o: {"chain": (rpm_of(o), 1e6 * o.chain)},
    ),
    "LimitCheck": (
        lambda: verdict().checks[0],
        {},
        lambda o: {
            "amplitude": (rpm_of(o.curve), 1e-6 * o.curve.values),
            "permitted": (rpm_of(o.curve), np.full(5, 40.0)),
            "worst: 125 % used": ([RPM * 100.0], [50.0]),
        },
    ),
    "Verdict": (
        verdict,
        {},
        lambda o: {
            "torsional stress of shaft, shaft 2 - 3": (
                rpm_of(o.checks[1].curve),
                100.0 * o.checks[1].curve.values / 40e6,
            )
        },
    ),
    "Samples": (samples, {"label": "frequency [Hz]"}, None),
    "SizedDamper": (sized, {}, lambda o: {"without": (rpm_of(o.without), 1e-3 * o.without.values)}),
    "SizedDamper, sizes": (
        sized,
        {"show": "sizes"},
        lambda o: {None: (o.sizes, 100.0 * o.used_at_best)},
    ),
    **of_satellites("PLOTS"),
}
# Without a unit: a star has no axes, and nodes stand at their names.
NO_UNIT = {"Star": "xy", "Modes": "x", "Modes, one": "x"}


def along_pairs(shape):
    """Ends of the elements of a chain of three, one after the other with a gap between."""
    return [0, 1, np.nan, 1, 2], [*shape[:2], np.nan, *shape[1:]]


def has_line(axes, label, x, y):
    """Tell whether a line of this label (any, for None) shows these numbers."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    for line in axes.lines:
        if label is not None and line.get_label() != label:
            continue
        drawn = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
        if label is None:
            drawn = tuple(values[: x.size] for values in drawn)
        if all(
            own.shape == wanted.shape
            and np.allclose(
                own, wanted, rtol=1e-12, atol=1e-12 * np.nanmax(np.abs(wanted)), equal_nan=True
            )
            for own, wanted in zip(drawn, (x, y), strict=True)
        ):
            return True
    return False


@pytest.mark.parametrize("name", CASES)
def test_plot_shows_the_numbers_of_the_object_with_units(name):
    make, options, expected = CASES[name]
    found = make()
    given = Figure().subplots()
    axes = found.plot(given, **options)
    assert axes is given
    assert len(axes.lines) + len(axes.patches) > 0
    for label, (x, y) in (expected(found) if expected else {}).items():
        assert has_line(axes, label, x, y), label
    assert axes.get_title(loc="left")
    for own, label in (("x", axes.get_xlabel()), ("y", axes.get_ylabel())):
        assert own in NO_UNIT.get(name, "") or ("[" in label and "]" in label), label


def test_unbounded_vibration_leaves_gaps_and_says_so():
    found = response(undamped=True)
    assert found.unbounded[1].tolist() == [False, False, True, False, False]
    axes = found.plot(Figure().subplots(), quantity="twist")
    by_label = {line.get_label(): line for line in axes.lines}
    for label in ("order 2", "all orders (synthesis)", "plain sum"):
        assert np.isnan(by_label[label].get_ydata()).tolist() == [False] * 2 + [True] + [False] * 2
    assert by_label["unbounded"].get_xdata()[0] == close(RPM * 100.0)
    grid = found.to_xarray()
    assert np.isinf(np.abs(grid.motion.sel(order=2.0, speed=100.0))).all()
    assert bool(grid.unbounded.sel(order=2.0, speed=100.0))
    assert np.isfinite(np.abs(grid.motion.sel(order=1.0))).all()


def test_a_pressure_map_draws_one_load():
    found = pressures()
    axes = found.plot(Figure().subplots(), load=0.5)
    assert axes.get_title(loc="left") == "Gas pressure at load 0.5"
    assert axes.lines[0].get_ydata().max() == close(1e-6 * found.diagrams[0].pressure.max())
    speeds = [50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0]
    many = pressure_map([(speed, 1.0, gas()) for speed in speeds], method="linear")
    axes = many.plot(Figure().subplots())
    assert len({tuple(line.get_color()) for line in axes.lines}) == len(speeds)
    with refused("load"):
        found.plot(load=0.7)


def test_a_verdict_draws_the_worst_five_and_counts_the_rest():
    curves = [AmplitudeCurve(f"shaft {n}", SPEEDS, np.full(5, 5e6 * n)) for n in range(1, 8)]
    limit = verdict().checks[0].limit
    found = judge([(limit, one) for one in curves], (60.0, 140.0), BarredRangeRule(140.0))
    *drawn, rest, permitted = found.plot(Figure().subplots()).lines
    names = [line.get_label() for line in drawn]
    assert names == [f"torsional stress of shaft, shaft {n}" for n in (7, 6, 5, 4, 3)]
    assert rest.get_label() == "and 2 more, used less"
    colors = {line.get_color() for line in drawn}
    assert len(colors) == 5
    assert permitted.get_color() not in colors


NAN = math.nan
# Of each result: options that are wrong, of which each is refused in one sentence.
SERIES_OPTIONS = {
    "limits": [{"a": [1.0, 2.0]}, {"a": "x"}, {"a": NAN}, {"a": [-1.0] * 5}, 3],
    "barred": [[(1,)], 3, [(80, 70)], [(NAN, 70)], ["ab"]],
    "main_orders": [1.5, "a", -1, True],
    "quantity": [3, ["twist"], "noise"],
}
ORDERS = {"main_orders": [1.5, "a", -1, 0]}
RUN_OPTIONS = {"steady": [3, ([1, 2], [1]), ([2, 1], [1, 1]), ("a", "b")], "turns": [0, 1.5]}
PLACES = {"place": ["nobody", 99, -1, 1.5, None, True]}
WRONG = {
    "ForcedResponse": (response, SERIES_OPTIONS | {"node": [7]}),
    "ElementLoads": (loads, SERIES_OPTIONS | {"part": [["elastic"], "none"]}),
    "OrderSeries": (lambda: response().nodes, SERIES_OPTIONS | PLACES),
    "CylinderForces": (cylinder_forces, ORDERS | {"show": [["radial"], "axial"], "cylinder": [3]}),
    "AxialForceComparison": (axial_comparison, ORDERS | {"throw": [0]}),
    "Samples": (samples, PLACES | {"bins": [0, -3, "z", 1.5]}),
    "TransientMotion": (run, RUN_OPTIONS | PLACES | {"quantity": [["twist"]]}),
    "TurningRun": (turning_run, RUN_OPTIONS),
    "SteadyMotion": (steady, {"quantity": ["heat"]}),
    "SteadyMotion, unbounded": (lambda: steady(unbounded=True), {"quantity": [None]}),
    "EngineTorque": (torque, {"throw": [3]}),
    "MechanismForces": (forces, {"cylinder": [0]}),
    "PinForceHarmonics": (pin_harmonics, {"show": ["axial"]}),
    "GasCycleResult": (cycle, {"show": ["time"]}),
    "FreeTurning": (free_turning, {"show": ["heat"]}),
    "SizedDamper": (sized, {"show": ["time"]}),
    "Modes": (modes, {"count": [0]}),
    "Balance": (balanced, {"show": ["torque", 3, None]}),
    "Hodograph": (hodograph, {"quantity": ["torque", 3, None]}),
    "CoupledResponse": (coupled, {"point": ["x", 3]}),
    "LoadDiagram": (load_diagram, {"mark_step_deg": [0, NAN, "a"], "frame": [3, "world"]}),
    "ShaftModes": (shaft_modes, {"radius": [None, "a", -0.1], "mode": [1, 3]}),
    "PressureMap": (pressures, {"speed": [1e9, "x"], "load": [99, "x", NAN]}),
    "Envelope": (lambda: run().envelope(), {"over": ["angle", 3], "quantity": [["torque"]]}),
    **of_satellites("WRONG_OPTIONS"),
}


def test_wrong_options_are_refused_before_anything_is_drawn(monkeypatch):
    def no_figure(**_):
        raise AssertionError("a figure was made before the options were looked at")

    monkeypatch.setattr("matplotlib.pyplot.subplots", no_figure)
    for make, wrong in WRONG.values():
        for option, values in wrong.items():
            for value in values:
                with pytest.raises(InputError, match=r"^[^;]*: given .*; allowed .*"):
                    make().plot(**{option: value})


def test_a_campbell_diagram_refuses_what_has_no_place_in_it():
    good = {"frequencies": [20.0], "orders": [1.0], "speed_range": (50.0, 150.0)}
    for option, values in {
        "orders": ([], [0.0, 1.0], [-1.0], [NAN]),
        "frequencies": ([NAN], [-3.0]),
        "speed_range": ((150.0, 50.0), (NAN, 50.0), (1.0, 2.0, 3.0), "ab"),
    }.items():
        for value in values:
            with pytest.raises(InputError, match=r"; allowed .*"):
                campbell_diagram(**(good | {option: value}), axes=Figure().subplots())


def test_tables_refuse_wrong_options():
    for found in (run(), steady()):
        with refused("quantity"):
            found.to_xarray("noise")


# Of each table: the object, and some columns with their unit and values: a part of the object, or numbers.
TABLES = {
    "Modes": (modes, {"frequency": ("Hz", "frequencies")}),
    "Decision": (
        lambda: decide("fine", [Trial("a.field", "strength", 4e8, "Pa", "fine")]),
        {"value": ("Pa", [4e8])},
    ),
    "PeakCause": (
        lambda: peak_cause(response(), response().nodes, 0, 0),
        {"contribution": ("rad or m", lambda o: [one.contribution for one in o.parts])},
    ),
    "ComplexModes": (
        lambda: complex_modes(response()),
        {"frequency": ("Hz", "frequencies"), "damping_ratio": ("1", "damping_ratios")},
    ),
    "AxialForceOverCycle": (
        axial_cycle,
        {"held": ("N", "held"), "throw_2": ("N", lambda o: o.throws[:, 1])},
    ),
    "Harmonics": (
        lambda: harmonics([0.0, 1.0, 0.0, -1.0], 4),
        {"order": ("1", "orders"), "amplitude": ("unit of the samples", "amplitude")},
    ),
    "PinForceHarmonics": (
        pin_harmonics,
        {"radial_inertia_phase": ("rad", "radial_inertia.phase")},
    ),
    "TorqueTable": (torque_table, {"crank_angle": ("deg", "crank_angle_deg")}),
    "Star": (star, {"direction": ("deg", "directions_deg")}),
    "LoadDiagram": (
        load_diagram,
        {"radial": ("N", np.full(24, -3e3)), "force_y": ("N", "force.real")},
    ),
    "Balance": (
        balanced,
        {"moment_major": ("N m", lambda o: [row.moment.major for row in o.rows])},
    ),
    "Hodograph": (
        hodograph,
        {name: ("N", lambda o, n=n: o.points(181)[n]) for n, name in enumerate("xy")},
    ),
    "HingedRodEffects": (effects, {"major": ("N", [1.2e3, 2.4e3, 3.6e3, 4.8e3])}),
    "GasPressure": (gas, {"pressure": ("Pa", "pressure")}),
    "GasCycleResult": (
        cycle,
        {"volume": ("m^3", lambda o: o.volume.at(angle_deg=o.pressure.angles_deg))},
    ),
    "FreeTurning": (free_turning, {"load_moment": ("N m", "load.moment")}),
    "SpeedOverAngle": (turning, {"kinetic_energy": ("J", "energy")}),
    "ShaftModes": (shaft_modes, {"torsional": ("1", lambda o: o.shares[1])}),
    "ResponseMatch": (response_match, {"shaft": ("m", "shaft")}),
    "ChainVerdict": (
        lambda: ChainVerdict((ModeMatch("axial", 1, 50.0, 9, 51.0, 0.9, 0.99, 1, 6),)),
        {
            "mode": ("1", [1]),
            "shaft_mode": ("1", [4]),
            "chain_frequency": ("Hz", [50.0]),
            "difference": ("1", [50.0 / 51.0 - 1.0]),
        },
    ),
    "LimitCheck": (
        lambda: verdict().checks[0],
        {"used": ("1", lambda o: o.curve.values / 40e6), "permitted": ("Pa", [40e6] * 5)},
    ),
    "Verdict": (verdict, {"worst_speed": ("rad/s", [100.0, 100.0]), "used": ("1", [1.25, 0.25])}),
    "SizedDamper": (sized, {"size": ("kg m^2", "sizes")}),
    **of_satellites("TABLES"),
}


def part_of(found, source):
    """Part of an object by its name, by a function of it, or known numbers."""
    if isinstance(source, str):
        return attrgetter(source)(found)
    return source(found) if callable(source) else source


@pytest.mark.parametrize("name", TABLES)
def test_tables_hold_the_numbers_in_si(name):
    make, expected = TABLES[name]
    found = make()
    frame = found.to_pandas()
    assert set(frame.attrs["units"]) == set(frame.columns)
    for column, (unit, source) in expected.items():
        np.testing.assert_allclose(frame[column], part_of(found, source), rtol=1e-12, atol=1e-9)
        assert frame.attrs["units"][column] == unit


# Of each grid: the object, and some arrays with their dimensions, unit and values: the object's if none are.
GRIDS = {
    "Modes": (modes, {"shapes": ("node mode", "1")}),
    "OrderSeries": (lambda: response().nodes, {"values": ("order speed place", "SI")}),
    "ForcedResponse": (response, {"motion": ("order speed node", "rad or m")}),
    "PowerBalance": (lambda: power_balance(response()), {"rest": ("order speed", "W")}),
    "OrderExcitation": (
        lambda: response().excitation,
        {"forces": ("order speed node", "N m or N")},
    ),
    "CylinderForces": (
        cylinder_forces,
        {"radial": ("order speed cylinder", "N"), "mean_radial": ("speed cylinder", "N")},
    ),
    "EngineTorque": (
        torque,
        {"gas": ("cylinder shaft_angle", "N m"), "total": ("shaft_angle", "N m")},
    ),
    "MechanismForces": (forces, {"crankpin": ("cylinder shaft_angle", "N")}),
    "SteadyMotion": (steady, {"motion": ("shaft_angle node", "rad or m")}),
    "TransientMotion": (run, {"torque": ("time element", "N m or N")}),
    "TurningRun": (turning_run, {"strain_energy": ("time", "J")}),
    "TurningCycle": (turning_cycle, {"speed": ("shaft_angle node", "rad/s")}),
    "ShaftModes": (
        shaft_modes,
        {"rotation": ("station axis mode", "rad", lambda o: o.motions[:, 3:])},
    ),
    "CoupledResponse": (coupled, {"radial": ("order speed point", "m or rad", "radial.motion")}),
    "SplitMotion": (
        lambda: coupled().split("damper ring"),
        {"both": ("order speed", "rad"), "both_sum": ("speed", "rad")},
    ),
}


def arrays_of(found, depth=0):
    """Arrays that an object holds, and those of its parts down to the third level."""
    if isinstance(found, np.ndarray):
        yield found
    elif isinstance(found, tuple | list) and depth < 3:
        for one in found:
            yield from arrays_of(one, depth + 1)
    elif hasattr(found, "__dict__") and depth < 3:
        for one in list(vars(found).values()):
            yield from arrays_of(one, depth + 1)


@pytest.mark.parametrize("name", GRIDS)
def test_grids_hold_the_numbers_over_named_coordinates(name):
    make, expected = GRIDS[name]
    found = make()
    grid = found.to_xarray()
    for array in (*grid.data_vars.values(), *grid.coords.values()):
        assert {"units", "long_name"} <= set(array.attrs)
        assert not any(np.shares_memory(array.values, own) for own in arrays_of(found))
    for variable, (dimensions, unit, *source) in expected.items():
        array, values = grid[variable], part_of(found, *(source or [variable]))
        assert array.dims == (*dimensions.split(),)
        assert array.dtype == np.asarray(values).dtype
        np.testing.assert_allclose(array, values, rtol=1e-15)
        assert array.attrs["units"] == unit
    for name_there in ("order", "speed"):
        if name_there in grid.dims:
            own = getattr(found, f"{name_there}s", None)
            if own is not None:
                np.testing.assert_array_equal(grid[name_there], own)


def test_campbell_diagram_has_a_dot_at_each_resonance():
    found = resonances(response())
    given = Figure().subplots()
    natural = response().system.elastic_frequencies
    axes = campbell_diagram(natural, [1.0, 2.0], (50.0, 150.0), found, given)
    assert axes is given
    dots = [line for line in axes.lines if line.get_marker() == "o" and len(line.get_xdata())]
    assert {line.get_color() for line in dots} <= set(KIND_COLORS.values())
    assert [line.get_xdata()[0] for line in dots] == [one.speed_rpm for one in found]
    assert [line.get_ydata()[0] for line in dots] == [one.frequency for one in found]
    assert axes.get_xlabel() == "crankshaft speed [1/min]"


def test_lists_of_records_become_tables():
    found = resonances(response())
    frame = table_of(found)
    assert list(frame["speed"]) == [one.speed for one in found]
    assert frame.attrs["units"]["equilibrium"] == "rad or m"
    speeds = critical_speeds([30.0, 60.0], [1.0, 2.0], (50.0, 400.0))
    assert list(table_of(speeds)["speed"]) == [one.speed for one in speeds]
    # Of elastic frequencies, critical speeds have the numbers that resonances have.
    assert list(table_of(speeds)["mode"]) == [
        1 + (30.0, 60.0).index(one.frequency) for one in speeds
    ]
    barred = table_of(verdict().barred)
    assert list(barred["low"]) == [one.low for one in verdict().barred]
    assert bool(barred["allowed"].all())
    ranges = table_of([CriticalRange(1, 6.0, 100.0, 95.0, 105.0, 0.1, 0.15)])
    assert ranges.attrs["units"]["margin"] == "1"
    assert table_of([]).empty


def test_a_missing_library_is_named_with_its_command(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'crankfem\[frames\]'"):
        table_of([])


def test_results_show_themselves_briefly():
    for make, *_ in (GRIDS | TABLES | CASES).values():
        result = make()
        text = repr(result)
        assert text.startswith(f"{type(result).__name__}(")
        assert len(text) <= 400
        assert result._repr_html_().count("<tr>") >= 2


def is_special(kind, way):
    """Tell whether a class has a method that not every result has."""
    return hasattr(kind, way) and getattr(kind, way) is not getattr(Result, way, None)


def test_every_plot_table_and_grid_is_tested_here(public_classes):
    for name, own in public_classes.items():
        for way, cases in (("plot", CASES), ("to_pandas", TABLES), ("to_xarray", GRIDS)):
            tested = {case.split(",")[0] for case in cases}
            package, _, module = own.__module__.partition(".")
            here = package == "dynamics" or module.startswith("satellites.")
            here = here and not module.endswith(".run") and is_special(own, way)
            assert not here or name in tested, f"{name}.{way} is not tested here"


def test_labels_of_a_polar_curve_touch_neither_it_nor_each_other():
    """A curve with loops: a circle of 1 with one of 0.55 three times as fast."""
    turns = 2.0 * np.pi * np.arange(720) / 720
    curve = np.exp(1j * turns) + 0.55 * np.exp(4j * turns)
    points = curve[::30]
    low, high = square_round([curve])
    width = high[0] - low[0]
    half = np.array(LABEL_HALF) * width
    spots = [spot for spot in label_spots(curve, points, width) if spot is not None]
    assert len(spots) > 15
    fine = np.interp(np.arange(0.0, 720.0, 0.05), np.arange(721), np.append(curve, curve[0]))
    for number, spot in enumerate(spots):
        gap = fine - spot
        # Samples of the curve are half a label's height apart.
        assert not np.any((np.abs(gap.real) < 0.8 * half[0]) & (np.abs(gap.imag) < 0.6 * half[1]))
        for other in spots[:number]:
            apart = np.abs([(other - spot).real, (other - spot).imag]) / half
            assert max(apart) >= 2.0 * (1.0 - 1e-12)
        assert low[0] < spot.real - half[0] < spot.real + half[0] < high[0]
        assert low[1] < spot.imag - half[1] < spot.imag + half[1] < high[1]


def test_orders_of_a_campbell_diagram_are_labeled_where_there_is_room():
    frame = campbell_frame(np.array([6.3]), np.arange(1.0, 13.0), (3.6, 15.0), ())
    labeled = frame.labeled([*range(1, 13), 1.5])
    assert {1, 2, 3, 4, 5} <= {*labeled} < {*range(1, 13)}
    left, right = frame.ends
    along = sorted(frame.line_end(order)[0] for order in labeled if frame.line_end(order)[2])
    assert min(np.diff(along)) >= LABEL_ROOM * (right - left) * (1.0 - 1e-12)


test_refused_calls = refusals(
    ("count", lambda: Hodograph(1, 100.0, 20.0).to_pandas(count=-1)),
)
