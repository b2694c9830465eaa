"""Torque of an engine, its harmonics, and the two-mass check."""

import math
from itertools import pairwise

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.critical import solid_shaft_stiffness, two_mass_check, two_mass_frequency
from dynamics.engine.forces import gas_forces, mechanism_forces
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod
from dynamics.harmonics import harmonics, read_torque_table
from dynamics.torque import engine_torque, pin_force_harmonics
from parts_in_a_line import cylinder

ROD = ConnectingRod(0.25, 2.0, 0.08, 0.02, 0.004)
SLAVE_ROD = ConnectingRod(0.18, 1.2, 0.07, 0.008)
SPEED = 150.0


class SmoothPressure:
    """A pressure of few harmonics, so that sums over samples are exact integrals."""

    def __init__(self, strokes):
        self.strokes = strokes

    def at(self, *, angle_deg):
        angle = np.radians(angle_deg)
        part = 2.0 / self.strokes
        return 1e5 * (
            12.0 + 9.0 * np.cos(part * angle - 0.4) + 3.0 * np.cos(2 * part * angle - 0.7)
        )


def in_line_two_stroke():
    cylinders = [
        EngineCylinder(
            0.12, 3.0, ROD, crank_angle_deg=math.degrees(c), position=0.2 * i, pin_offset=0.003
        )
        for i, c in enumerate(np.radians([0.0, 120.0, 240.0]).tolist())
    ]
    return EngineLayout(0.07, cylinders, [1, 3, 2], strokes=2)


def hinged_vee():
    """Two throws, each with a main and a hinged rod, 60 deg between the banks."""
    cylinders = []
    for throw, crank in enumerate((0.0, math.pi)):
        place = 0.2 * throw
        cylinders.append(cylinder(0.12, 3.0, ROD, math.degrees(crank), -30.0, place))
        pin = SlavePin(2 * throw + 1, 0.06, angle_deg=60.0)
        cylinders.append(
            cylinder(0.12, 2.8, SLAVE_ROD, math.degrees(crank), 30.0, place, slave_pin=pin)
        )
    return EngineLayout(0.07, cylinders, [1, 2, 3, 4])


ENGINES = pytest.mark.parametrize("engine", [in_line_two_stroke(), hinged_vee()])


def test_torque_is_that_of_all_forces_at_once():
    engine = hinged_vee()
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


def test_nonuniformity():
    engine = in_line_two_stroke()
    found = engine_torque(engine, SPEED, SmoothPressure(2))
    assert found.nonuniformity == close(np.ptp(found.total) / found.mean)
    assert engine_torque(engine, SPEED).nonuniformity is None


def test_harmonics_of_throws_add_up_to_the_engines():
    found = engine_torque(hinged_vee(), SPEED, SmoothPressure(4))
    throws = [found.harmonics(throw) for throw in (1, 2)]
    added = sum(throw.cosine + 1j * throw.sine for throw in throws)
    whole = found.harmonics()
    assert added == close(whole.cosine + 1j * whole.sine, abs=1e-9)
    for throw in (3, 0, 1.5, True):
        with pytest.raises(InputError, match=f"throw: given {throw}; allowed are the whole"):
            found.harmonics(throw)
    with pytest.raises(InputError, match="cylinder: given 5"):
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
            tangential = getattr(part, f"tangential_{name}")
            radial = getattr(part, f"radial_{name}")
            assert tangential.at(crank_angle_deg=np.degrees(since_firing)) == close(
                own.tangential[place], abs=small
            )
            assert radial.at(crank_angle_deg=np.degrees(since_firing)) == close(
                own.radial[place], abs=small
            )
        both = part.tangential_gas.at(
            crank_angle_deg=np.degrees(angles)
        ) + part.tangential_inertia.at(crank_angle_deg=np.degrees(angles))
        assert part.tangential.at(crank_angle_deg=np.degrees(angles)) == close(both, abs=1e-8)


def test_like_cylinders_have_like_harmonics_from_their_own_firing_tops():
    parts = pin_force_harmonics(in_line_two_stroke(), SPEED, SmoothPressure(2), samples=360)
    for one, other in pairwise(parts):
        assert one.tangential.amplitude[:12] == close(other.tangential.amplitude[:12])
        assert one.radial.phase[:6] == close(other.radial.phase[:6], abs=1e-9)


def test_throws_may_be_told():
    engine = in_line_two_stroke()
    assert engine_torque(engine, SPEED, samples=12).throws == ((1,), (2,), (3,))
    assert engine_torque(engine, SPEED, samples=12, throws=[1, 0, 0]).throws == ((2, 3), (1,))
    with pytest.raises(InputError, match="throws: given 2; allowed are 3"):
        engine_torque(engine, SPEED, samples=12, throws=[0, 1])
    for wrong in ([0.0, 1, 2], [False, 1, 2], ["0", 1, 2]):
        with pytest.raises(InputError, match=r"throws: given .*; allowed are whole numbers from 0"):
            engine_torque(engine, SPEED, samples=12, throws=wrong)
    with pytest.raises(InputError, match=r"throws: .*without a gap"):
        engine_torque(engine, SPEED, samples=12, throws=[0, 2, 2])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"samples": 2}, "samples: given 2"),
        ({"samples": 10.5}, "samples: given 10.5"),
        ({"pressure": np.zeros((3, 5))}, r"pressure: given forces of shape \(3, 5\)"),
        ({"speed": -1.0}, "speed: given -1"),
        ({"pressure": [SmoothPressure(2)] * 2}, "pressure: given 2 for 3 cylinders; .*because"),
        ({"pressure": SmoothPressure(4)}, "pressure: given a cycle of 4 strokes"),
    ],
)
def test_refusals(change, message):
    with pytest.raises(InputError, match=message):
        engine_torque(in_line_two_stroke(), **({"speed": SPEED} | change))


def test_orders_beyond_the_samples_are_refused():
    engine = in_line_two_stroke()
    with pytest.raises(InputError, match="highest_order: given 13; allowed are 1 to 12, because"):
        pin_force_harmonics(engine, SPEED, samples=24, highest_order=13)
    with pytest.raises(InputError, match="highest_order: given 24; allowed are 1 to 12"):
        pin_force_harmonics(engine, SPEED, samples=24)
    found = engine_torque(engine, SPEED, samples=24).harmonics()
    with pytest.raises(InputError, match="order: given 13"):
        found.index_of(13)


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
        ("", "no header; allowed is"),
        ("angle,torque\n0,1\n", 'line 1: given the header "angle,torque"; allowed is'),
        (CRANK, "given 0 samples; allowed are 3 or more"),
        (CRANK + "0,1\n180;2\n", 'line 6: given "180;2"; allowed are two numbers'),
        (CRANK + "0,1\n180,two\n", 'line 6: torque_Nm: given "two"; allowed are finite numbers'),
        (CRANK + "0,1\n180,2\n# x\n180,3\n", "line 8: crank_angle_deg: given 180 deg after 180"),
        (CRANK + "0,1\n180,2\n350,3\n540,4\n", r"line 8: .*allowed is one cycle of 720 deg"),
        (CRANK + "0,1\n90,2\n180,3\n", "line 7: .*allowed is one cycle of 720 deg or 360 deg"),
        (CYCLE + "0,1\n240,2\n480,3\n", "line 4: .*allowed is one cycle of 360 deg,"),
        (CYCLE + "0,1\n120,2\n240,3\n360,1.1\n", "line 5: torque_Nm: given 1.1 for the closing"),
    ],
)
def test_unusable_tables_are_refused_with_file_and_line(written, text, message):
    path = written(text)
    with pytest.raises(InputError, match=message) as raised:
        read_torque_table(path)
    assert str(raised.value).startswith(str(path))
    assert "\n" not in str(raised.value)


def test_strokes_must_agree_with_the_crank_angles(written):
    with pytest.raises(InputError, match="allowed is one cycle of 360 deg,"):
        read_torque_table(written(CRANK + "0,1\n180,2\n360,3\n540,4\n"), strokes=2)


def test_missing_and_unreadable_files_are_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read as a torque table"):
        read_torque_table(tmp_path / "absent.csv")
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\x80\xfe\x00\xd8")
    with pytest.raises(InputError, match=r"binary\.csv: is no text"):
        read_torque_table(path)


SHAFT = {"diameter": 0.05, "length": 0.4, "shear_modulus": 8e10, "inertia_1": 2.0, "inertia_2": 0.3}


def test_two_masses_are_the_shortest_chain():
    stiffness = solid_shaft_stiffness(0.05, 0.4, 8e10)
    modes = Chain([2.0, 0.3], [stiffness]).modes()
    assert two_mass_frequency(stiffness, 2.0, 0.3) == close(modes.angular_frequencies[1])


def test_figures_belong_together():
    check = two_mass_check(**SHAFT, order=6.0)
    assert check.resonant_speed * 6.0 == close(check.angular_frequency)
    assert check.resonant_speed_rpm == close(check.resonant_speed * 30.0 / math.pi)
    assert check.vibrations_per_minute == close(60.0 * check.frequency)


@pytest.mark.parametrize(
    ("samples", "strokes", "order", "resolved", "statement"),
    [
        (36, 4, 14.0, False, "36 samples over two revolutions resolve orders up to 9: "
         "this table cannot excite order 14."),
        (36, 4, 0.75, False, "36 samples over two revolutions resolve orders up to 9 in steps of "
         "0.5: this table cannot excite order 0.75."),
        (36, 2, 6.0, True, "36 samples over one revolution resolve orders up to 18: "
         "this table excites order 6 with 2.5 N m."),
    ],
)  # fmt: skip
def test_statement_tells_what_the_table_can_show(samples, strokes, order, resolved, statement):
    angle = np.arange(samples) * strokes * np.pi / samples
    found = harmonics(2.5 * np.sin(6.0 * angle), strokes)
    check = two_mass_check(**SHAFT, order=order, harmonics=found)
    assert check.resolved is resolved
    assert check.statement == statement


def test_without_a_table_nothing_is_claimed():
    check = two_mass_check(**SHAFT, order=6.0)
    assert check.resolved is None
    assert check.statement.startswith("No torque table is given")


@pytest.mark.parametrize("field", [*SHAFT, "order"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "1"])
def test_every_value_must_be_above_zero(field, value):
    values = {**SHAFT, "order": 6.0, field: value}
    with pytest.raises(InputError, match=f"{field}: given .*more than zero"):
        two_mass_check(**values)
