"""Torque of an engine, its harmonics, and the two-mass check."""

import math
import re
from itertools import pairwise

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.critical import solid_shaft_stiffness, two_mass_check, two_mass_frequency
from dynamics.engine.forces import gas_forces, mechanism_forces
from dynamics.harmonics import harmonics, read_torque_table
from dynamics.torque import engine_torque, pin_force_harmonics
from refusals import refusals_of, refused
from small_engines import SmoothPressure, two_stroke_row, vee

SPEED = 150.0
ENGINES = pytest.mark.parametrize("engine", [two_stroke_row(), vee(True)])


def test_torque_is_that_of_all_forces_at_once():
    engine = vee(True)
    pressure = SmoothPressure(4)
    found = engine_torque(engine, SPEED, pressure, samples=96, model="three-mass")
    angles = np.radians(found.shaft_angles_deg)
    gas = gas_forces(engine, pressure, shaft_angles_deg=np.degrees(angles))
    whole = mechanism_forces(
        engine, SPEED, gas, model="three-mass", shaft_angles_deg=np.degrees(angles)
    )
    largest = np.max(np.abs(whole.torque))
    assert found.per_cylinder == close(whole.torque, abs=1e-13 * largest)
    assert found.total == close(whole.torque.sum(axis=0), abs=1e-13 * largest)
    assert found.throws == ((1, 2), (3, 4))
    assert found.per_throw == close(
        np.array([whole.torque[:2].sum(axis=0), whole.torque[2:].sum(axis=0)]), abs=1e-12 * largest
    )
    # The first journal has only the throw at the free end before it.
    assert np.array_equal(found.passed_on[0], found.per_throw[0])
    assert np.max(np.abs(found.per_throw[0] - found.per_throw[1])) > 0.1 * largest
    assert found.passed_on[-1] == close(found.total, abs=1e-12 * largest)
    same = engine_torque(engine, SPEED, gas, samples=96, model="three-mass")
    assert same.total == close(found.total, abs=1e-13 * largest)
    assert found.nonuniformity == close(np.ptp(found.total) / found.mean)
    assert engine_torque(engine, SPEED).nonuniformity is None


def test_harmonics_of_throws_add_up_to_the_engines():
    found = engine_torque(vee(True), SPEED, SmoothPressure(4))
    throws = [found.harmonics(throw) for throw in (1, 2)]
    added = sum(throw.cosine + 1j * throw.sine for throw in throws)
    whole = found.harmonics()
    assert added == close(whole.cosine + 1j * whole.sine, abs=1e-9)
    for throw in (3, 0, 1.5, True):
        with refused("throw"):
            found.harmonics(throw)
    with refused("cylinder"):
        found.cylinder_harmonics(5)


@ENGINES
def test_pin_force_harmonics_restore_the_forces_from_the_firing_top(engine):
    pressure = SmoothPressure(engine.strokes)
    every = {2: 180.0, 4: 90.0}[engine.strokes]
    parts = pin_force_harmonics(engine, SPEED, pressure, samples=360, highest_order=every)
    angles = np.linspace(0.3, 5.0, 7)
    gas = mechanism_forces(
        engine,
        0.0,
        gas_forces(engine, pressure, shaft_angles_deg=np.degrees(angles)),
        shaft_angles_deg=np.degrees(angles),
    )
    masses = mechanism_forces(engine, SPEED, shaft_angles_deg=np.degrees(angles))
    for place, part in enumerate(parts):
        since_firing = angles - np.radians(engine.firing_deg)[place]
        assert math.radians(part.firing_angle_deg) == np.radians(engine.firing_deg)[place]
        for name, own in (("gas", gas), ("inertia", masses)):
            # 180 resolved orders of smooth forces: what is cut off is round-off.
            small = 1e-11 * np.max(np.abs(own.crankpin))
            for way in ("tangential", "radial"):
                found = getattr(part, f"{way}_{name}").at(crank_angle_deg=np.degrees(since_firing))
                assert found == close(getattr(own, way)[place], abs=small)
        both = part.tangential_gas.at(
            crank_angle_deg=np.degrees(angles)
        ) + part.tangential_inertia.at(crank_angle_deg=np.degrees(angles))
        assert part.tangential.at(crank_angle_deg=np.degrees(angles)) == close(both, abs=1e-8)


def test_like_cylinders_have_like_harmonics_from_their_own_firing_tops():
    parts = pin_force_harmonics(two_stroke_row(), SPEED, SmoothPressure(2), samples=360)
    for one, other in pairwise(parts):
        assert one.tangential.amplitude[:12] == close(other.tangential.amplitude[:12])
        assert one.radial.phase[:6] == close(other.radial.phase[:6], abs=1e-9)


def test_throws_may_be_told():
    engine = two_stroke_row()
    assert engine_torque(engine, SPEED, samples=12).throws == ((1,), (2,), (3,))
    assert engine_torque(engine, SPEED, samples=12, throws=[1, 0, 0]).throws == ((2, 3), (1,))
    for wrong in ([0, 1], [0.0, 1, 2], [False, 1, 2], ["0", 1, 2], [0, 2, 2]):
        with refused("throws"):
            engine_torque(engine, SPEED, samples=12, throws=wrong)


test_refusals = refusals_of(
    lambda change: engine_torque(two_stroke_row(), **({"speed": SPEED} | change)),
    ({"samples": 2}, "samples"),
    ({"samples": 10.5}, "samples"),
    ({"pressure": np.zeros((3, 5))}, "pressure"),
    ({"speed": -1.0}, "speed"),
    ({"pressure": [SmoothPressure(2)] * 2}, "pressure"),
    ({"pressure": SmoothPressure(4)}, "pressure"),
)


def test_orders_beyond_the_samples_are_refused():
    engine = two_stroke_row()
    for options in ({"highest_order": 13}, {}):
        with refused("highest_order"):
            pin_force_harmonics(engine, SPEED, samples=24, **options)
    with refused("order"):
        engine_torque(engine, SPEED, samples=24).harmonics().index_of(13)


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "torque.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


CRANK = "# An engine\n# Source: a book\n\ncrank_angle_deg,torque_Nm\n"
CYCLE = "cycle_angle_deg,torque_Nm\n"


def test_closing_sample_is_dropped(written):
    table = read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n720,1\n"))
    assert table.strokes == 4
    assert table.torque.tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(("strokes", "last"), [(None, 480.0), (4, 480.0), (2, 240.0)])
def test_cycle_angles_are_turned_into_crank_angles(written, strokes, last):
    table = read_torque_table(written(CYCLE + "0,1\n120,2\n240,3\n360,1\n"), strokes=strokes)
    assert table.crank_angle_deg.tolist() == [0.0, last / 2.0, last]


def test_byte_order_mark_and_windows_lines_are_accepted(tmp_path):
    path = tmp_path / "torque.csv"
    path.write_bytes(b"\xef\xbb\xbf" + CYCLE.encode() + b"0,1\r\n120,2\r\n240,3\r\n")
    assert read_torque_table(path).torque.size == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "torque.csv"),
        ("angle,torque\n0,1\n", "line 1"),
        (CRANK, "torque.csv"),
        (CRANK + "0,1\n180;2\n", "line 6"),
        (CRANK + "0,1\n180,two\n", "line 6: torque_Nm"),
        (CRANK + "0,1\n180,2\n# x\n180,3\n", "line 8: crank_angle_deg"),
        (CRANK + "0,1\n180,2\n350,3\n540,4\n", "line 8"),
        (CRANK + "0,1\n90,2\n180,3\n", "line 7"),
        (CYCLE + "0,1\n240,2\n480,3\n", "line 4"),
        (CYCLE + "0,1\n120,2\n240,3\n360,1.1\n", "line 5: torque_Nm"),
    ],
)
def test_unusable_tables_are_refused_with_file_and_line(written, text, message):
    path = written(text)
    with pytest.raises(InputError, match=message) as raised:
        read_torque_table(path)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_strokes_must_agree_with_the_crank_angles(written):
    with refused("crank_angle_deg"):
        read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n"), strokes=2)


def test_missing_and_unreadable_files_are_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read as a torque table"):
        read_torque_table(tmp_path / "absent.csv")
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\x80\xfe\x00\xd8")
    with pytest.raises(InputError, match=r"binary\.csv: is no text"):
        read_torque_table(path)


SHAFT = {"diameter": 0.05, "length": 0.4, "shear_modulus": 8e10, "inertia_1": 2.0, "inertia_2": 0.3}


def test_two_masses_are_the_shortest_chain_and_figures_belong_together():
    stiffness = solid_shaft_stiffness(0.05, 0.4, 8e10)
    modes = Chain([2.0, 0.3], [stiffness]).modes()
    assert two_mass_frequency(stiffness, 2.0, 0.3) == close(modes.angular_frequencies[1])
    check = two_mass_check(**SHAFT, order=6.0)
    assert check.resolved is None
    assert "order 6" in check.statement
    assert check.resonant_speed * 6.0 == close(check.angular_frequency)
    assert check.resonant_speed_rpm == close(check.resonant_speed * 30.0 / math.pi)
    assert check.vibrations_per_minute == close(60.0 * check.frequency)


@pytest.mark.parametrize(
    ("samples", "strokes", "order", "resolved", "told"),
    [
        (36, 4, 14.0, False, ["9", "14"]),
        (36, 4, 0.75, False, ["9", "0.5", "0.75"]),
        (36, 2, 6.0, True, ["18", "6", "2.5"]),
    ],
)
def test_statement_tells_what_the_table_can_show(samples, strokes, order, resolved, told):
    angle = np.arange(samples) * strokes * np.pi / samples
    found = harmonics(2.5 * np.sin(6.0 * angle), strokes)
    check = two_mass_check(**SHAFT, order=order, harmonics=found)
    assert check.resolved is resolved
    assert re.findall(r"\d[\d.]*\b", check.statement)[1:] == told


@pytest.mark.parametrize("field", [*SHAFT, "order"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "1"])
def test_every_value_must_be_above_zero(field, value):
    values = {**SHAFT, "order": 6.0, field: value}
    with refused(field):
        two_mass_check(**values)
