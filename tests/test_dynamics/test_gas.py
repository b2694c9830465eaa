"""Gas pressure: measured, tabulated, over speed and load, and by the cycle model."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from comparing import close
from crankbase.errors import InputError
from dynamics.cycle import cycle_radians
from dynamics.excitation.pressure_map import pressure_map, pressure_map_from_cycles
from dynamics.gas.gas_cycle import (
    USUAL_VALUES,
    GasCycle,
    assumption_remarks,
    gas_cycle,
    name_of_field,
    usual_gas_cycle,
)
from dynamics.gas.pressure import (
    cylinder_volume,
    gas_pressure,
    indicated_mean_effective_pressure,
    indicated_work,
    periodic_slope,
    read_pressure_table,
)
from references import closed_pressure
from refusals import refusals, refusals_of, refused


def curve(angle, cycle):
    """A smooth periodic pressure with its peak 10 deg after the top."""
    return 2e5 + 9e6 * np.exp(-60.0 * np.sin((angle - np.radians(10.0)) * np.pi / cycle) ** 2)


def even(count, strokes, start=0.0):
    cycle = np.pi * strokes
    angles = np.radians(start) + cycle / count * np.arange(count)
    return gas_pressure(curve(angles, cycle), strokes, angles_deg=np.degrees(angles))


@pytest.mark.slow
@given(st.lists(st.floats(1e4, 2e7), min_size=72, max_size=90), st.floats(-30.0, 30.0))
@settings(max_examples=50)
def test_curve_stays_between_neighboring_samples(values, angle):
    angles = 2.0 * np.pi / len(values) * np.arange(len(values))
    found = gas_pressure(values, 2, angles_deg=np.degrees(angles))
    turned = angle % cycle_radians(found.strokes)
    place = int(np.searchsorted(np.radians(found.angles_deg), turned, side="right")) - 1
    pair = found.pressure[place], found.pressure[(place + 1) % len(values)]
    value = float(found.at(angle_deg=np.degrees(angle)))
    # Round-off of the cubic on the largest value.
    assert min(pair) - 1e-8 <= value <= max(pair) + 1e-8


def test_uneven_samples_are_made_even_on_their_curve_and_said():
    coarse = np.concatenate([np.arange(-360.0, -40.0, 4.0), np.arange(-40.0, 60.0, 1.0)])
    angles = np.radians(np.concatenate([coarse, np.arange(60.0, 360.0, 4.0)]))
    found = gas_pressure(
        curve(angles, 4.0 * np.pi), 4, remarks=("Before.",), angles_deg=np.degrees(angles)
    )
    assert found.remarks[0] == "Before."
    assert len(found.remarks) == 2
    assert np.diff(np.radians(found.angles_deg)) == close(np.radians(0.5))
    # The highest sample is one of the even ones.
    assert found.peak_angle_deg == close(10.0)
    assert found.peak_pressure == close(9.2e6, rel=1e-12)
    # Where the samples are 4 deg apart the curve is flat, elsewhere they are 1 deg apart.
    assert found.pressure == close(curve(np.radians(found.angles_deg), 4.0 * np.pi), abs=2e-4 * 9e6)


def test_angles_printed_rounded_are_moved_to_even_places():
    angles = np.round(np.arange(540) * 720.0 / 540.0, 2)
    found = gas_pressure(curve(np.radians(angles), 4.0 * np.pi), angles_deg=angles)
    assert np.radians(found.angles_deg) == close(4.0 * np.pi / 540 * np.arange(540), abs=1e-12)
    assert len(found.remarks) == 1


DEGREES = np.arange(0.0, 360.0, 5.0)


test_unusable_samples_are_refused = refusals_of(
    lambda degrees, values: gas_pressure(values, 2, angles_deg=degrees),
    (DEGREES, np.ones(71), "angles_deg"),
    (DEGREES, np.zeros(72), "pressure[0]"),
    (DEGREES, np.full(72, np.nan), "pressure[0]"),
    (DEGREES[::-1], np.ones(72), "angles_deg[1]"),
    (np.append(DEGREES, 360.0), np.ones(73), "angles_deg"),
    (DEGREES[:60], np.ones(60), "angles_deg"),
    (np.delete(DEGREES, [10, 11]), np.ones(70), "angles_deg"),
    ([1.0], [1.0], "angles_deg"),
)


BAR = "crank_angle_deg,absolute_pressure_bar"


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "pressure.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def bar(angle, cycle=720.0, peak=8.0):
    """A pressure [bar] with its peak at an angle [deg]."""
    return 2.0 + 118.0 * np.exp(-40.0 * np.sin((angle - peak) * np.pi / cycle) ** 2)


def rows(angles, values):
    return "".join(f"{float(a)!r},{float(p)!r}\n" for a, p in zip(angles, values, strict=True))


def table(angles, values, header=BAR, comments="# Engine X\n# Indicated at rated load\n"):
    return f"{comments}{header}\n{rows(angles, values)}"


def test_closing_sample_may_differ_by_what_is_printed(written):
    angles = np.arange(0.0, 721.0, 1.0)
    values = bar(angles)
    values[-1] += 0.1
    assert read_pressure_table(written(table(angles, values))).pressure.size == 720


def test_motored_cycle_is_read(written):
    angles = np.arange(-360.0, 360.0, 1.0)
    values = 1.0 + 34.0 * np.exp(-40.0 * np.sin((angles + 0.7) * np.pi / 720.0) ** 2)
    assert read_pressure_table(written(table(angles, values))).peak_angle_deg == close(-1.0)


ANGLES = np.arange(0.0, 720.0, 5.0)
VALUES = bar(ANGLES, peak=10.0)


def changed(index, value):
    values = VALUES.copy()
    values[index] = value
    return table(ANGLES, values)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "pressure.csv"),
        ("crank_angle_deg,pressure\n0,1\n", "line 1"),
        ("crank_angle_deg,absolute_pressure_psi\n", "line 1"),
        (BAR + "\n", "pressure.csv"),
        (BAR + "\n0,1\n1;2\n", "line 3"),
        (BAR + "\n0,1\n1,high\n", "line 3: absolute_pressure_bar"),
        (BAR + "\n0,1\n0,2\n5,3\n", "line 3: crank_angle_deg"),
        (BAR + "\n0,1\n5,2\n6,3\n", "line 4"),
        (table(ANGLES[:-4], VALUES[:-4]), "line 143"),
        (table(np.append(ANGLES, 730.0), np.append(VALUES, 2.0)), "line 148"),
        (table(np.append(ANGLES, 720.0), np.append(VALUES, VALUES[0] + 1.0)), "line 148"),
        (table(np.delete(ANGLES, [50, 51]), np.delete(VALUES, [50, 51])), "line 54"),
        (changed(90, 0.0), "line 94: absolute_pressure_bar"),
        (changed(90, -0.5), "line 94: absolute_pressure_bar"),
        # Below vacuum by a gauge.
        (changed(90, -1.02).replace("absolute", "gauge"), "line 94: gauge_pressure_bar"),
        (table(ANGLES, VALUES / 1e3), "line 6"),
        (table(ANGLES, VALUES * 1e3), "line 6"),
        (table(ANGLES, bar(ANGLES, peak=370.0)), "line 78: crank_angle_deg"),
        (table(ANGLES, bar(ANGLES, peak=100.0)), "line 24: crank_angle_deg"),
    ],
)
def test_unusable_tables_are_refused_with_file_and_line(written, text, message):
    path = written(text)
    with pytest.raises(InputError, match=message) as raised:
        read_pressure_table(path)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_strokes_must_agree_with_the_angles(written):
    path = written(table(ANGLES, VALUES))
    assert read_pressure_table(path, 4).strokes == 4
    with pytest.raises(InputError, match="given 2 cycles of 360 deg, which differ by"):
        read_pressure_table(path, 2)
    with refused("strokes"):
        read_pressure_table(path, 3)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read as a pressure table"):
        read_pressure_table(tmp_path / "absent.csv")


R, L, AREA = 0.07, 0.25, 0.0133


@pytest.mark.slow
@given(st.lists(st.floats(1e4, 2e7), min_size=72, max_size=144), st.floats(0.0, 2e5))
def test_gas_torque_does_the_indicated_work(values, under):
    """Torque by the paper's P sin(alpha + beta) / cos(beta) R, work from p dV."""
    angle = 4.0 * np.pi / len(values) * np.arange(len(values))
    beta = np.arcsin(R / L * np.sin(angle))
    force = AREA * (np.array(values) - under)
    torque = force * R * np.sin(angle + beta) / np.cos(beta)
    slope = -AREA * cycle_position_slope(angle)
    # Round-off of the work that goes to and fro.
    exchanged = indicated_work(np.array(values) + under, np.abs(slope))
    assert 4.0 * np.pi * np.mean(torque) == close(
        indicated_work(values, slope), abs=1e-13 * exchanged
    )


@pytest.mark.parametrize("count", [720, 1441])
def test_slope_of_the_piston_position(count):
    """Orders of the position fall as (R / 2 L)^k: the series has died out long before half."""
    angle = 4.0 * np.pi / count * np.arange(count)
    slope = periodic_slope(cycle_position(angle), 4.0 * np.pi)
    assert slope == close(cycle_position_slope(angle), abs=1e-12 * R)


def test_mean_effective_pressure_is_work_over_swept_volume():
    assert indicated_mean_effective_pressure(3000.0, 1.5e-3) == 2e6


PER_MINUTE = math.pi / 30.0
MAP_ANGLES = np.radians(np.arange(0.0, 720.0, 2.0))
ORDERS = np.arange(0.5, 12.1, 0.5)


def diagram(speed, load):
    """A diagram whose height, place and width of the peak follow speed and load smoothly."""
    peak = 3e6 + 6e6 * load + 1e6 * (speed / 200.0) ** 2
    place, width = 0.1 + 0.15 * speed / 200.0 - 0.05 * load, 0.35 + 0.1 * load
    since = (MAP_ANGLES + 2.0 * np.pi) % (4.0 * np.pi) - 2.0 * np.pi
    return gas_pressure(
        1.5e5 + peak * np.exp(-(((since - place) / width) ** 2)), angles_deg=np.degrees(MAP_ANGLES)
    )


def grid(speeds, loads, method="cubic"):
    points = [(float(s), float(b), diagram(s, b)) for s in speeds for b in loads]
    return pressure_map(points[::-1], method=method)


@pytest.mark.parametrize(
    ("method", "worst"),
    # Of the largest harmonic; measured 5.4e-5 and 5.3e-3 with five speeds and four loads: cubic splines
    # are of fourth order in the distance of the points, straight lines of second.
    [("cubic", 1e-4), ("linear", 8e-3)],
)
def test_held_out_points_of_a_family_are_met(method, worst):
    found = grid(np.linspace(80.0, 240.0, 5), np.linspace(0.25, 1.0, 4), method)
    speeds, loads = np.array([97.0, 143.0, 181.0, 222.0]), np.array([0.31, 0.6, 0.86, 0.4])
    phasors = found.phasors(ORDERS, speeds, loads)
    for place, (speed, load) in enumerate(zip(speeds, loads, strict=True)):
        own = grid([speed], [load]).phasors(ORDERS, [speed])[:, 0]
        error = np.max(np.abs(phasors[:, place] - own)) / np.max(np.abs(own))
        assert error < worst
        assert (method == "linear") == (error > 1e-3)
        at = found.at(speed, load)
        assert "pressure map at" in at.source
        # Weights of the diagrams are those of the harmonics, so that both are missed by the same.
        missing = np.max(np.abs(diagram(speed, load).pressure - at.pressure))
        assert missing < 2.0 * error * at.peak_pressure
        again = np.fft.rfft(at.pressure)[1:25] * 2.0 / at.pressure.size
        assert phasors[:, place] == close(again, abs=1e-9 * np.abs(again).max())


def test_a_map_along_a_curve_takes_no_load():
    speeds = np.linspace(100.0, 200.0, 4)
    points = [(float(s), float((s / 200.0) ** 2), diagram(s, (s / 200.0) ** 2)) for s in speeds]
    found = pressure_map(points)
    assert found.loads is None
    assert found.load_of_speed == close((speeds / 200.0) ** 2)
    # At its points a map has its diagrams.
    assert found.at(100.0).pressure == close(points[0][2].pressure, rel=1e-12)
    assert found.weights([140.0]).sum() == close(1.0)
    with refused("load"):
        found.at(140.0, 0.5)


@pytest.mark.parametrize(
    ("speed", "load", "field"),
    [
        (70.0, 0.5, "speed"),
        (100.0, 1.2, "load"),
        (100.0, None, "load"),
        (100.0, [0.5, 0.6], "load"),
    ],
)
def test_a_map_is_never_extended(speed, load, field):
    found = grid([80.0, 160.0, 240.0], [0.25, 1.0])
    with refused(field):
        found.weights([speed], load)
    # A range that ends on the map's own end, but for round-off, is inside.
    found.weights([240.0 * (1 + 1e-12)], 1.0)


def test_maps_that_are_none_are_refused():
    own = diagram(100.0, 0.5)
    other = gas_pressure(own.pressure[:180], 2, angles_deg=np.degrees(MAP_ANGLES[:180]))
    for points, field in (
        ([], "points"),
        ([(100.0, 0.5, own), (100.0, 0.5, own)], "points"),
        ([(100.0, 0.5, own), (120.0, 0.5, other)], "points"),
        ([(100.0, 0.5, own), (100.0, 1.0, own), (120.0, 1.0, own)], "points"),
        ([(0.0, 0.5, own)], "pressure map speed"),
    ):
        with refused(field):
            pressure_map(points)
    with refused("method"):
        pressure_map([(100.0, 0.5, own)], method="nearest")
    with refused("orders[0]"):
        pressure_map([(100.0, 0.5, own)]).phasors([90.0], [100.0])


def test_a_map_from_cycles_has_its_targets_at_the_points():
    speeds, loads = np.array([1000.0, 1500.0, 2000.0]) * PER_MINUTE, [0.5, 1.0]
    means = np.outer([1.0, 1.05, 0.95], loads) * 16e5
    intakes = 1e5 * (1.0 + np.outer([0.6, 1.0, 1.3], loads))
    found = pressure_map_from_cycles(
        FOUR,
        cycle_position,
        AREA,
        speeds,
        loads,
        mean_effective_pressure=means,
        intake_pressure=intakes,
        exhaust_pressure=0.9 * intakes,
        samples=720,
    )
    bar = float(intakes[1, 1])
    middle = gas_cycle(
        usual_gas_cycle(15.0, intake_pressure=bar, exhaust_pressure=0.9 * bar),
        cycle_position,
        AREA,
        mean_effective_pressure=float(means[1, 1]),
        samples=720,
    )
    assert found.at(speeds[1], 1.0).pressure == close(middle.pressure.pressure, rel=1e-12)
    assert not any("Solved" in text for text in found.remarks)
    made = partial(pressure_map_from_cycles, FOUR, cycle_position, AREA)
    with refused("at 1500 1/min and load 1: mean_effective_pressure"):
        made(speeds[1:2], [1.0], mean_effective_pressure=[[1e8]], samples=720)
    with refused("peak_pressure"):
        made(speeds, [1.0], peak_pressure=[1e7, 2e7])


def cycle_position(angle, offset=0.0):
    sideways = R * np.sin(angle) - offset
    return R * np.cos(angle) + np.sqrt(L**2 - sideways**2)


def cycle_position_slope(angle, offset=0.0):
    sideways = R * np.sin(angle) - offset
    return -R * np.sin(angle) - sideways * R * np.cos(angle) / np.sqrt(L**2 - sideways**2)


def offset_position(angle):
    return cycle_position(angle, 0.02)


def slave_position(angle):
    """A piston on an articulated rod: its pin runs on an ellipse, its top is not at zero."""
    master = np.arcsin(R / L * np.sin(angle + 0.8))
    foot = R * np.exp(1j * angle) + 0.06 * np.exp(1j * (0.15 - master))
    return foot.real + np.sqrt(0.2**2 - foot.imag**2)


MECHANISMS = [cycle_position, offset_position, slave_position]
FOUR, TWO = usual_gas_cycle(15.0), usual_gas_cycle(13.0, 2)
CYCLES = [FOUR, TWO, replace(FOUR, wiebe_shape=0.4, intake_closes_deg=-200.0)]


@pytest.fixture(scope="module")
def volume():
    return cylinder_volume(cycle_position, AREA, 15.0)


# The volume


test_unusable_pistons_are_refused = refusals_of(
    lambda law, area, ratio: cylinder_volume(law, area, ratio),
    (cycle_position, 0.0, 15.0, "area"),
    (cycle_position, AREA, 1.0, "compression_ratio"),
    (lambda angle: 0.0 * angle, AREA, 15.0, "position"),
    (lambda angle: np.cos(0.5 * angle), AREA, 15.0, "position"),
    (lambda angle: -cycle_position(angle), AREA, 15.0, "position"),
    (lambda angle: np.full(angle.shape, np.nan), AREA, 15.0, "position[0]"),
)


# The closed part


@pytest.mark.parametrize("shape", [0.5, 1.0, 2.0])
def test_pressure_solves_the_equation_of_the_first_law(shape, volume):
    """dp/da = ((g - 1) dQ/da - g p dV/da) / V, integrated step by step."""
    cycle, heat = replace(FOUR, wiebe_shape=shape), 5000.0
    gamma = cycle.heat_capacity_ratio
    start, duration = np.radians([cycle.combustion_start_deg, cycle.combustion_duration_deg])

    def slope(angle, pressure):
        v, dv = volume.at(angle_deg=np.degrees(angle)), -AREA * cycle_position_slope(angle)
        t = np.clip((angle - start) / duration, 0.0, None)
        a = np.log(1000.0)
        rate = a * (shape + 1.0) * t**shape * np.exp(-a * t ** (shape + 1.0)) / 0.999 / duration
        return (heat * (gamma - 1.0) * rate * (t <= 1.0) - gamma * pressure * dv) / v

    begin, last = np.radians([cycle.intake_closes_deg, cycle.exhaust_opens_deg])
    pressure = np.array([cycle.intake_pressure])
    for end in (start, start + duration, last):
        asked = np.linspace(begin, end, 50)
        found = solve_ivp(
            slope, (begin, end), pressure, method="DOP853", t_eval=asked, rtol=1e-12, atol=1e-3
        )
        # The integration's own error, larger for the shape 0.5, whose rate begins steeply.
        assert closed_pressure(cycle, volume, heat, np.degrees(asked)) == close(
            found.y[0], rel=1e-8
        )
        pressure, begin = found.y[:, -1], end


# The whole cycle


@given(st.floats(1.0, 2.5), st.sampled_from(CYCLES), st.sampled_from(MECHANISMS))
@settings(max_examples=30)
def test_peak_is_met(rise, cycle, mechanism):
    lowest = gas_cycle(cycle, mechanism, AREA, heat=0.0).pressure.peak_pressure
    found = gas_cycle(cycle, mechanism, AREA, peak_pressure=rise * lowest)
    assert found.pressure.peak_pressure == close(rise * lowest, rel=1e-12)
    assert f"Solved: heat {found.heat / 1e3:.4g} kJ per cycle." in found.pressure.remarks


@pytest.mark.parametrize("solve_for", ["combustion_start_deg", "combustion_duration_deg"])
@pytest.mark.parametrize(("peak", "mean"), [(16e6, 1.8e6), (12e6, 1.0e6)])
@pytest.mark.parametrize("mechanism", [cycle_position, slave_position])
def test_peak_and_mean_pressure_are_met_together(peak, mean, mechanism, solve_for):
    found = gas_cycle(
        FOUR,
        mechanism,
        AREA,
        peak_pressure=peak,
        mean_effective_pressure=mean,
        solve_for=solve_for,
        samples=1440,
    )
    assert found.pressure.peak_pressure == close(peak, rel=1e-9)
    assert found.mean_effective_pressure == close(mean, rel=1e-9)
    other = {"combustion_start_deg", "combustion_duration_deg"} - {solve_for}
    assert getattr(found.cycle, *other) == getattr(FOUR, *other)
    assert solve_for not in found.cycle.assumed
    assert found.pressure.remarks[0].startswith(f"Solved: {name_of_field(solve_for)} ")
    again = gas_cycle(found.cycle, mechanism, AREA, heat=found.heat, samples=1440)
    assert again.pressure.pressure == close(found.pressure.pressure, rel=1e-12)


def test_usual_values_are_named_with_their_reasons():
    cycle = usual_gas_cycle(15.0, intake_pressure=3e5, wiebe_shape=0.8)
    assert set(cycle.assumed) == set(USUAL_VALUES) - {"intake_pressure", "wiebe_shape"}
    assert cycle.exhaust_pressure == close(2.7e5)
    remarks = assumption_remarks(cycle)
    assert len(remarks) == len(cycle.assumed)
    assert usual_gas_cycle(10.0, intake_pressure=1e5).exhaust_pressure == 1.05e5
    assert gas_cycle(cycle, cycle_position, AREA, heat=100.0).pressure.remarks == remarks
    assert usual_gas_cycle(10.0, **{n: getattr(cycle, n) for n in USUAL_VALUES}).assumed == ()


test_impossible_parameters_are_refused = refusals_of(
    lambda given: usual_gas_cycle(15.0, **given),
    ({"boost": 1.0}, "boost"),
    ({"intake_pressure": "2 bar"}, "intake_pressure"),
    ({"intake_pressure": -1.0}, "intake_pressure"),
    ({"heat_capacity_ratio": 1.0}, "heat_capacity_ratio"),
    ({"wiebe_shape": -0.5}, "wiebe_shape"),
    ({"wiebe_completeness": 1.0}, "wiebe_completeness"),
    ({"combustion_start_deg": np.nan}, "combustion_start_deg"),
    ({"combustion_start_deg": -149.0}, "combustion_start_deg"),
    ({"combustion_duration_deg": 143.2}, "exhaust_opens_deg"),
    ({"exhaust_opens_deg": 177.6}, "exhaust_opens_deg"),
    ({"intake_closes_deg": 5.7}, "intake_closes_deg"),
    ({"overlap_begins_deg": 172.0}, "overlap_begins_deg"),
    ({"overlap_ends_deg": 286.5}, "overlap_ends_deg"),
    ({"overlap_ends_deg": 321.0}, "overlap_ends_deg"),
    ({"overlap_ends_deg": 630.0}, "intake_closes_deg one cycle later"),
    ({"intake_closes": -145.0}, "intake_closes"),
)
# A peak that this mean pressure does not have, whatever is solved for.
BOTH = {"peak_pressure": 1e7, "mean_effective_pressure": 3.5e6}


@pytest.mark.parametrize("cycle", [FOUR, TWO])
@pytest.mark.parametrize(
    "event", ["intake_closes_deg", "exhaust_opens_deg", "overlap_begins_deg", "overlap_ends_deg"]
)
def test_events_in_radians_are_refused(cycle, event):
    """Given to either; the other two, about the top and of any length, may be as small in degrees."""
    value = math.radians(getattr(cycle, event))
    for call in (partial(replace, cycle), partial(usual_gas_cycle, 15.0, cycle.strokes)):
        with refused(event) as caught:
            call(**{event: value})
        assert "radians" in str(caught.value)


def test_names_without_their_unit_are_refused():
    values = {name: getattr(FOUR, name) for name in ("strokes", *USUAL_VALUES)}
    assert GasCycle(compression_ratio=15.0, assumed=FOUR.assumed, **values) == FOUR
    values["exhaust_opens"] = values.pop("exhaust_opens_deg")
    with pytest.raises(TypeError, match="exhaust_opens"):
        GasCycle(compression_ratio=15.0, **values)


@pytest.mark.parametrize(
    ("targets", "message"),
    [
        ({}, "heat: given neither it nor peak_pressure nor mean_effective_pressure"),
        ({"heat": 1.0, "peak_pressure": 1e7}, "heat: given together with"),
        ({"heat": -1.0}, "heat: given -1 J; allowed are finite numbers of zero or more"),
        ({"heat": 1e6}, r"heat: given 1e\+06 J; allowed is 0 to 3\d+\.?\d* J, because more"),
        ({"peak_pressure": 5e6}, r"peak_pressure: given 5 MPa; allowed are 8\.865 MPa to 50 MPa"),
        ({"peak_pressure": 6e7}, "peak_pressure: given 60 MPa; allowed are"),
        ({"peak_pressure": np.nan}, "peak_pressure: given nan; allowed are"),
        ({"mean_effective_pressure": -1e6}, "given -1 MPa; allowed are 0.0229.* MPa to 11.9.* MPa"),
        ({"mean_effective_pressure": 2e7}, "given 20 MPa; allowed are"),
        ({"peak_pressure": 4e7, "mean_effective_pressure": 1e6}, "peak_pressure: given 40 MPa"),
        (BOTH | {"solve_for": "combustion_duration_deg"}, r"1\d\.\d+ MPa to .* from 2 to 136 deg"),
        (BOTH | {"mean_effective_pressure": 0.0}, "mean_effective_pressure: given"),
        (BOTH | {"solve_for": "heat"}, "solve_for: given 'heat'"),
        (BOTH | {"solve_for": "combustion_start"}, "solve_for: given 'combustion_start'"),
        ({"heat": 1.0, "samples": 600}, "samples: given 600; allowed are whole numbers of 720 or"),
        ({"heat": 1.0, "samples": 1e4}, "samples: given 10000.0"),
    ],
)
def test_targets_out_of_reach_are_refused_with_what_is_in_reach(targets, message):
    with pytest.raises(InputError, match=message) as raised:
        gas_cycle(FOUR, cycle_position, AREA, **targets)
    assert "\n" not in str(raised.value)


def test_combustion_too_short_or_too_early_is_refused():
    short = replace(FOUR, combustion_duration_deg=1.0)
    with refused("combustion_duration_deg"):
        gas_cycle(short, cycle_position, AREA, heat=100.0)
    early = replace(FOUR, intake_closes_deg=-200.0, combustion_start_deg=-170.0)
    early = replace(early, combustion_duration_deg=20.0, exhaust_opens_deg=60.0)
    with refused("mean_effective_pressure"):
        gas_cycle(early, cycle_position, AREA, mean_effective_pressure=1e6)


test_refused = refusals(
    ("angle_deg", lambda: even(360, 4).at(angle_deg=np.nan)),
    ("strokes", lambda: even(360, 3)),
    ("volume_slope", lambda: indicated_work([1.0, 2.0], [1.0])),
    ("volume_slope", lambda: indicated_work([], [])),
    ("pressure[1]", lambda: indicated_work([1.0, np.inf], [1.0, 1.0])),
    ("strokes", lambda: indicated_work([1.0], [1.0], 3)),
    ("speeds", lambda: pressure_map([(100.0, 0.5, diagram(100.0, 0.5))]).weights([])),
    ("compression_ratio", lambda: usual_gas_cycle(0.9)),
    ("strokes", lambda: usual_gas_cycle(15.0, 3)),
    ("swept", lambda: indicated_mean_effective_pressure(3000.0, 0.0)),
)
