import numpy as np
import pytest

import crankfem as cf
from comparing import close
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.loads import element_loads
from dynamics.response.order_excitation import OrderExcitation

SECTION = """
[two_mass_check]
shaft_diameter = "70 mm"
shaft_length = "0.2 m"
shear_modulus = "80 GPa"
engine_inertia = "0.1 kg m^2"
flywheel_inertia = "0.78 kg m^2"
order = 6.0
"""


def test_shipped_engine(call):
    record = call("two-mass", "yamz-5340", "--json").json()
    assert record["resonant_speed_rpm"] == close(2224.7, abs=0.05)
    found = record["resonances"]
    assert [one["order"] for one in found] == [16.0, 15.5, 15.0, 14.5, 14.0]
    for one in found:
        assert one["order"] * one["speed_rpm"] == close(60.0 * record["frequency"])
        assert one["amplitude"] is None
    out = call("two-mass", "yamz-5340").out
    assert "Order 14 resonates at 2224.7 1/min, inside the running range of 600 to 2300" in out
    assert "this table cannot excite order 14." in out


def test_torque_in_the_shaft_is_that_of_a_chain_of_two(call):
    found = call("two-mass", "yamz-5340", "--json").json()["shaft_torque"]
    table = cf.load_torque_table("yamz5340_torque_one_throw.csv")
    # Four rows of samples, each shifted by its firing angle.
    total = sum(np.roll(table.torque, shift // 20) for shift in (0, 540, 180, 360))
    angles = np.radians(table.crank_angle_deg)
    orders = np.array(found["orders"])
    speed = 2300.0 * np.pi / 30.0
    phasors = np.array([2.0 / 36.0 * np.sum(total * np.exp(-1j * k * angles)) for k in orders])
    forces = np.zeros((len(orders), 1, 2), dtype=complex)
    forces[:, 0, 1] = phasors
    stiffness = 8e10 * np.pi * 0.07**4 / (32.0 * 0.2)
    chain = Chain([0.78, 0.1], [stiffness])
    response = forced_response(chain, OrderExcitation(orders, np.array([speed]), forces))
    expected = np.abs(element_loads(response).elements.values[:, 0, 0])
    assert found["torque"] == close(expected.tolist(), abs=1e-8 * expected.max())
    assert [k for k, by in zip(orders, found["exciting"], strict=True) if by > 1.0] == [2, 4, 6, 8]


def test_the_section_alone(call, tmp_path):
    (tmp_path / "two.toml").write_text(SECTION, encoding="utf-8")
    record = call("two-mass", "two.toml", "--order", "14", "--json").json()
    assert record["resonant_speed_rpm"] == close(2224.7, abs=0.05)
    assert record["resonances"] is record["shaft_torque"] is record["running_rpm"] is None
    out = call("two-mass", "two.toml").out
    assert out.splitlines()[1:] == [
        "Order 6 resonates at 5190.9 1/min.",
        "No torque table is given: how strongly order 6 excites is open.",
    ]


def test_an_order_that_the_table_excites(call):
    out = call("two-mass", "yamz-5340", "--order", "4").out
    assert "Order 4 resonates at 7786.3 1/min, outside the running range of 600 to 2300" in out
    assert "this table excites order 4 with 171.3 N m." in out


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (("6chn25-34",), "6chn25-34.toml: the section [two_mass_check] is missing; it is required"),
        (("yamz-5340", "--order", "nan"), "--order: given nan; allowed is an order above 0"),
        (("two.toml",), "two_mass_check.shaft_diameter: given 70, a bare number"),
        (("nowhere.toml",), "nowhere.toml: does not exist"),
    ],
)
def test_refusals(call, tmp_path, arguments, fragment):
    (tmp_path / "two.toml").write_text(SECTION.replace('"70 mm"', "70"), encoding="utf-8")
    answer = call("two-mass", *arguments)
    assert (answer.code, answer.out) == (2, "")
    assert fragment in answer.err
    assert answer.err.count("\n") == 1
