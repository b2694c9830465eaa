import math

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.chains.chain import Chain
from dynamics.critical import solid_shaft_stiffness, two_mass_check, two_mass_frequency
from dynamics.harmonics import harmonics

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
