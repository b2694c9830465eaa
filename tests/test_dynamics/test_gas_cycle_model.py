import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from comparing import close
from crankbase.errors import InputError
from dynamics.gas.cycle_values import (
    USUAL_VALUES,
    GasCycle,
    assumption_remarks,
    name_of_field,
    usual_gas_cycle,
)
from dynamics.gas.cylinder_volume import cylinder_volume
from dynamics.gas.gas_cycle import gas_cycle, pressure_rise_per_heat
from references import closed_pressure

R, L, AREA = 0.07, 0.25, 0.0133


def position(angle, offset=0.0):
    sideways = R * np.sin(angle) - offset
    return R * np.cos(angle) + np.sqrt(L**2 - sideways**2)


def position_slope(angle, offset=0.0):
    sideways = R * np.sin(angle) - offset
    return -R * np.sin(angle) - sideways * R * np.cos(angle) / np.sqrt(L**2 - sideways**2)


def offset_position(angle):
    return position(angle, 0.02)


def slave_position(angle):
    """A piston on an articulated rod: its pin runs on an ellipse, its top is not at zero."""
    master = np.arcsin(R / L * np.sin(angle + 0.8))
    foot = R * np.exp(1j * angle) + 0.06 * np.exp(1j * (0.15 - master))
    return foot.real + np.sqrt(0.2**2 - foot.imag**2)


MECHANISMS = [position, offset_position, slave_position]
FOUR, TWO = usual_gas_cycle(15.0), usual_gas_cycle(13.0, 2)
CYCLES = [FOUR, TWO, replace(FOUR, wiebe_shape=0.4, intake_closes_deg=-200.0)]


@pytest.fixture(scope="module")
def volume():
    return cylinder_volume(position, AREA, 15.0)


# The volume


@pytest.mark.parametrize(
    ("law", "area", "ratio", "message"),
    [
        (position, 0.0, 15.0, "area: given 0 m"),
        (position, AREA, 1.0, "compression_ratio: given 1; allowed is more than 1"),
        (lambda angle: 0.0 * angle, AREA, 15.0, "position: given 0 m at 0 deg, .*that moves"),
        (lambda angle: np.cos(0.5 * angle), AREA, 15.0, "is back after one turn"),
        (lambda angle: -position(angle), AREA, 15.0, "highest at .*180 deg; allowed are -30 to 30"),
        (lambda angle: np.full(angle.shape, np.nan), AREA, 15.0, "position.*given nan"),
    ],
)
def test_unusable_pistons_are_refused(law, area, ratio, message):
    with pytest.raises(InputError, match=message):
        cylinder_volume(law, area, ratio)


# The closed part


def burnt_share(cycle, angles):
    """The model's integral of V^(g - 1) dx with V^(g - 1) constant: the burnt share.

    A ratio of heat capacities of 1 + e leaves V^e, which is 1 but for 3 e: 4e-11 here; e is a power
    of two to be exact.
    """
    cycle = replace(cycle, heat_capacity_ratio=1.0 + 2.0**-36)
    law = cylinder_volume(position, AREA, 15.0)
    return pressure_rise_per_heat(cycle, law, angles) * law.at(angle_deg=angles) * 2.0**36


@given(st.floats(0.0, 5.0), st.floats(0.6, 0.9999), st.floats(-40.0, 10.0), st.floats(5.0, 110.0))
@settings(max_examples=40)
def test_burnt_share_rises_from_nothing_to_all(shape, completeness, start, duration):
    cycle = replace(
        FOUR,
        wiebe_shape=shape,
        wiebe_completeness=completeness,
        combustion_start_deg=start,
        combustion_duration_deg=duration,
    )
    end = start + duration
    # From a little before, for angles from 0 to 6.28 deg look like a turn in radians.
    share = burnt_share(cycle, [start - 1.0, *np.linspace(start, end, 200)])
    assert share[1] == 0.0
    assert share[-1] == close(1.0, abs=1e-10)
    # Where all is burnt but 1e-11 the small part of V^e that is not constant shows.
    assert np.all(np.diff(share) >= -1e-11)
    assert burnt_share(cycle, [-110.0, end + 6.0]).tolist() == close([0.0, 1.0], abs=1e-10)


def balance(cycle, law, slope, heat):
    """Return heat, rise of internal energy and work from quadrature of p dV in the closed part."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    events = [cycle.intake_closes_deg, cycle.combustion_start_deg]
    events += [cycle.combustion_start_deg + cycle.combustion_duration_deg, cycle.exhaust_opens_deg]
    work = 0.0
    for begin, end in pairwise(np.radians(events)):
        # Steps that grow from the start of the combustion, where the pressure is least smooth.
        ends = begin + (end - begin) * np.linspace(0.0, 1.0, 61) ** 3
        half = 0.5 * np.diff(ends)[:, np.newaxis]
        angles = (ends[:-1, np.newaxis] + half * (1.0 + nodes)).ravel()
        power = closed_pressure(cycle, law, heat, np.degrees(angles)) * -AREA * slope(angles)
        work += float(np.sum((half * weights).ravel() * power))
    ends = [cycle.intake_closes_deg, cycle.exhaust_opens_deg]
    energy = closed_pressure(cycle, law, heat, ends) * law.at(angle_deg=ends)
    return float(np.diff(energy)[0]) / (cycle.heat_capacity_ratio - 1.0), work


@given(
    st.floats(0.0, 2e4),
    st.floats(1.2, 1.45),
    st.floats(8.0, 22.0),
    st.floats(0.3, 3.0),
    st.floats(-30.0, 20.0),
    st.floats(10.0, 90.0),
    st.sampled_from((0.0, 0.015)),
)
@settings(max_examples=40)
def test_heat_is_work_and_internal_energy(heat, gamma, ratio, shape, start, duration, offset):
    cycle = replace(
        FOUR,
        heat_capacity_ratio=gamma,
        wiebe_shape=shape,
        combustion_start_deg=start,
        combustion_duration_deg=duration,
    )
    law = cylinder_volume(lambda angle: position(angle, offset), AREA, ratio)
    gained, work = balance(cycle, law, lambda angle: position_slope(angle, offset), heat)
    # The quadrature of the work reaches 1e-10 of the energies; a motored cycle moves some 1 kJ.
    assert gained + work == close(heat, abs=1e-10 * (heat + 1e3))


@pytest.mark.parametrize("shape", [0.5, 1.0, 2.0])
def test_pressure_solves_the_equation_of_the_first_law(shape, volume):
    """dp/da = ((g - 1) dQ/da - g p dV/da) / V, integrated step by step."""
    cycle, heat = replace(FOUR, wiebe_shape=shape), 5000.0
    gamma = cycle.heat_capacity_ratio
    start, duration = np.radians([cycle.combustion_start_deg, cycle.combustion_duration_deg])

    def slope(angle, pressure):
        v, dv = volume.at(angle_deg=np.degrees(angle)), -AREA * position_slope(angle)
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


def test_pressure_is_found_at_any_angle_alone(volume):
    angles = [40.0, -3.0, 100.0, -90.0, 3.0]
    together = pressure_rise_per_heat(FOUR, volume, angles)
    alone = [pressure_rise_per_heat(FOUR, volume, [angle])[0] for angle in angles]
    # Other parts of the same integral: its own accuracy.
    assert together == close(np.array(alone), rel=1e-10)
    assert together[3] == 0.0


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
@pytest.mark.parametrize("mechanism", [position, slave_position])
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
    assert "Assumed: combustion_start -6 deg, because " in "".join(remarks)
    assert usual_gas_cycle(10.0, intake_pressure=1e5).exhaust_pressure == 1.05e5
    found = gas_cycle(cycle, position, AREA, heat=100.0)
    assert found.pressure.remarks == remarks
    assert usual_gas_cycle(10.0, **{n: getattr(cycle, n) for n in USUAL_VALUES}).assumed == ()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"boost": 1.0}, "boost: given 1.0; allowed are intake_pressure, exhaust"),
        ({"intake_pressure": "2 bar"}, "intake_pressure: given '2 bar'; allowed are finite"),
        ({"intake_pressure": -1.0}, "intake_pressure: given -1 Pa"),
        ({"heat_capacity_ratio": 1.0}, "heat_capacity_ratio: given 1; allowed is more than 1"),
        ({"wiebe_shape": -0.5}, "wiebe_shape: given -0.5"),
        ({"wiebe_completeness": 1.0}, "wiebe_completeness: given 1; allowed is more than 0.5"),
        ({"combustion_start_deg": np.nan}, "given nan; allowed are finite numbers of degrees"),
        (
            {"combustion_start_deg": -149.0},
            "combustion_start_deg: given -149 deg, with intake_closes_deg at -145",
        ),
        ({"combustion_duration_deg": 143.2}, "exhaust_opens_deg: given 130 deg, with end of comb"),
        ({"exhaust_opens_deg": 177.6}, "exhaust_opens_deg: given 177.6 .* less than 175 deg"),
        ({"intake_closes_deg": 5.7}, "intake_closes_deg: given 5.7 deg; allowed is more than -270"),
        ({"overlap_begins_deg": 172.0}, "overlap_begins_deg: given 172 deg, with bottom dead cent"),
        ({"overlap_ends_deg": 286.5}, "overlap_ends_deg: .* deg, with overlap_begins_deg at 320"),
        ({"overlap_ends_deg": 321.0}, "overlap_ends_deg: .* 5 deg or more between them"),
        ({"overlap_ends_deg": 630.0}, "intake_closes_deg one cycle later: given 575 deg, with ov"),
        ({"intake_closes": -145.0}, "intake_closes: given -145.0; allowed are .*intake_closes_deg"),
    ],
)
def test_impossible_parameters_are_refused(given, message):
    with pytest.raises(InputError, match=message) as raised:
        usual_gas_cycle(15.0, **given)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("cycle", [FOUR, TWO])
@pytest.mark.parametrize(
    "event", ["intake_closes_deg", "exhaust_opens_deg", "overlap_begins_deg", "overlap_ends_deg"]
)
def test_events_in_radians_are_refused(cycle, event):
    """Given to either; the other two, about the top and of any length, may be as small in degrees."""
    value = math.radians(getattr(cycle, event))
    message = rf"^{event}: given {value:.6g} deg, which would be .* radians; allowed are degrees"
    with pytest.raises(InputError, match=message):
        replace(cycle, **{event: value})
    with pytest.raises(InputError, match=message):
        usual_gas_cycle(15.0, cycle.strokes, **{event: value})


def test_names_without_their_unit_are_refused():
    values = {name: getattr(FOUR, name) for name in ("strokes", *USUAL_VALUES)}
    assert GasCycle(compression_ratio=15.0, assumed=FOUR.assumed, **values) == FOUR
    values["exhaust_opens"] = values.pop("exhaust_opens_deg")
    with pytest.raises(TypeError, match="exhaust_opens"):
        GasCycle(compression_ratio=15.0, **values)
    with pytest.raises(InputError, match=r"^solve_for: given 'combustion_start'"):
        gas_cycle(
            FOUR,
            position,
            AREA,
            peak_pressure=16e6,
            mean_effective_pressure=1.8e6,
            solve_for="combustion_start",
        )


def test_impossible_ratio_and_strokes_are_refused():
    with pytest.raises(InputError, match=r"compression_ratio: given 0\.9; allowed is more than 1"):
        usual_gas_cycle(0.9)
    with pytest.raises(InputError, match="strokes: given 3"):
        usual_gas_cycle(15.0, 3)


@pytest.mark.parametrize(
    ("targets", "message"),
    [
        ({}, "heat: given neither it nor peak_pressure nor mean_effective_pressure"),
        ({"heat": 1.0, "peak_pressure": 1e7}, "heat: given together with"),
        ({"heat": -1.0}, "heat: given -1 J; allowed are finite numbers of zero or more"),
        (
            {"heat": 1e6},
            r"heat: given 1e\+06 J; allowed are 0 to 3\d+\.?\d* J, because more drives",
        ),
        ({"peak_pressure": 5e6}, r"peak_pressure: given 5 MPa; allowed are 8\.865 MPa to 50 MPa"),
        ({"peak_pressure": 6e7}, "peak_pressure: given 60 MPa; allowed are"),
        ({"peak_pressure": np.nan}, "peak_pressure: given nan; allowed are"),
        ({"mean_effective_pressure": -1e6}, "given -1 MPa; allowed are 0.0229.* MPa to 11.9.* MPa"),
        ({"mean_effective_pressure": 2e7}, "given 20 MPa; allowed are"),
        (
            {"peak_pressure": 4e7, "mean_effective_pressure": 1e6},
            r"peak_pressure: given 40 MPa; allowed are 8\.865 MPa to 25\.64 MPa, because with a "
            r"mean effective pressure of 1 MPa a combustion_start_deg from -60 to 2\.5 deg",
        ),
        (
            {
                "peak_pressure": 1e7,
                "mean_effective_pressure": 3.5e6,
                "solve_for": "combustion_duration_deg",
            },
            r"allowed are 1\d\.\d+ MPa to .* a combustion_duration_deg from 2 to 136 deg",
        ),
        (
            {"peak_pressure": 1e7, "mean_effective_pressure": 0.0},
            "mean_effective_pressure: given 0 MPa; allowed is more than 0.0229",
        ),
        (
            {"peak_pressure": 1e7, "mean_effective_pressure": 1e6, "solve_for": "heat"},
            "solve_for: given 'heat'",
        ),
        (
            {"heat": 1.0, "samples": 600},
            "samples: given 600; allowed are whole numbers of 720 or more",
        ),
        ({"heat": 1.0, "samples": 1e4}, "samples: given 10000.0"),
    ],
)
def test_targets_out_of_reach_are_refused_with_what_is_in_reach(targets, message):
    with pytest.raises(InputError, match=message) as raised:
        gas_cycle(FOUR, position, AREA, **targets)
    assert "\n" not in str(raised.value)


def test_combustion_too_short_or_too_early_is_refused():
    short = replace(FOUR, combustion_duration_deg=1.0)
    with pytest.raises(
        InputError, match="combustion_duration_deg: given 1 deg; allowed is 2 deg or"
    ):
        gas_cycle(short, position, AREA, heat=100.0)
    early = replace(
        FOUR,
        intake_closes_deg=-200.0,
        combustion_start_deg=-170.0,
        combustion_duration_deg=20.0,
        exhaust_opens_deg=60.0,
    )
    with pytest.raises(InputError, match="released too early to do work"):
        gas_cycle(early, position, AREA, mean_effective_pressure=1e6)
