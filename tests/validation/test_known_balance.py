"""Balance of well-known engines.

Source: binomial series of the slider-crank, m R w^2 (cos a + A_2 cos 2a + ...), A_2 = lambda + lambda^3/4 +
...; sums over cranks as in handbooks (Bosch's Automotive Handbook).

Tolerance: 1e-12, the series ends below 1e-17; printed numbers to half of their last digit.

One cylinder has crank radius R, lambda = R/L and reciprocating mass m; the force along its axis has

    A_2k = (2k)^2 (2/lambda) (-1)^k sum over n >= k of C(1/2, n) (-lambda^2/4)^n C(2n, n-k),

with A_4 = -(lambda^3/4 + 3 lambda^5/16) and A_2 = lambda + lambda^3/4 + 15 lambda^5/128 as first terms.
Resultants are sums of exp(i k angle) over the cranks, with h_k = m R w^2 A_k and cylinder pitch a.
"""

import math
from dataclasses import replace

import numpy as np
from scipy.integrate import quad
from scipy.special import binom

from comparing import close
from dynamics.balance import balance, balancing_masses
from dynamics.engine.forces import acceleration_orders
from dynamics.engine.layout import (
    EngineCylinder,
    EngineLayout,
    RotatingMass,
    firing_order_of_angles,
)
from dynamics.engine.rods import ConnectingRod
from parts_in_a_line import cylinder as made_cylinder

RADIUS, LENGTH, SPEED, PITCH = 0.05, 0.16, 400.0, 0.11
# Reciprocating 0.5 + 0.6 * 0.25 = 0.65 kg, rotating 0.45 kg.
PISTON, ROD = 0.5, ConnectingRod(LENGTH, 0.6, 0.04, 0.003)
RECIPROCATING, ROTATING = 0.65, 0.45
UNIT = RECIPROCATING * RADIUS * SPEED**2
EXACT = 1e-12


def coefficient(order, ratio):
    """A_k of the inertia force, from the binomial series."""
    half = order // 2
    terms = [
        binom(0.5, n) * (-(ratio**2) / 4.0) ** n * binom(2 * n, n - half) for n in range(half, 60)
    ]
    return order**2 * 2.0 / ratio * (-1) ** half * math.fsum(terms)


def size(order):
    return UNIT * (1.0 if order == 1 else abs(coefficient(order, RADIUS / LENGTH)))


def engine(cranks_deg, banks_deg=(0.0,), pin_step_deg=0.0):
    """One throw for each crank angle, with a cylinder for each bank; cranks of a throw may differ."""
    cylinders = [
        made_cylinder(0.09, PISTON, ROD, crank + place * pin_step_deg, bank, throw * PITCH)
        for throw, crank in enumerate(cranks_deg)
        for place, bank in enumerate(banks_deg)
    ]
    tops = [math.radians(cylinder.top_shaft_angle_deg) for cylinder in cylinders]
    order = firing_order_of_angles(tops, 2, 1)
    return EngineLayout(RADIUS, cylinders, order, 2, firing_angles_deg=np.degrees(tops))


def rotating_balanced(cranks_deg, banks_deg=(0.0,), pin_step_deg=0.0):
    plain = engine(cranks_deg, banks_deg, pin_step_deg)
    return replace(plain, rotating=balancing_masses(plain))


def approx(value):
    return close(value, rel=EXACT)


def test_series_of_the_slider_crank(figure):
    for ratio in (0.15, 0.25, 0.3125):
        rod = ConnectingRod(RADIUS / ratio, 0.6, 0.04, 0.003)
        single = EngineLayout(RADIUS, [EngineCylinder(0.09, PISTON, rod)], [1])
        found = acceleration_orders(single, 1, SPEED, 8)
        unit = RADIUS * SPEED**2
        figure("orders of one cylinder: first", found.cosine[0], unit, EXACT, "m/s^2")
        for order in (2, 4, 6, 8):
            wanted = unit * coefficient(order, ratio)
            what = f"orders of one cylinder: {order}, of the first"
            figure(what, found.cosine[order - 1], wanted, 1e-14, "m/s^2", scale=unit)
        np.testing.assert_allclose(found.amplitude[2:8:2], 0.0, atol=1e-14 * unit)
        # What the first terms leave is of the order of the next one, with coefficients below 0.15.
        second = ratio + ratio**3 / 4 + 15 * ratio**5 / 128
        assert coefficient(2, ratio) == close(second, abs=0.15 * ratio**7)
        fourth = -(ratio**3) / 4 - 3 * ratio**5 / 16
        assert coefficient(4, ratio) == close(fourth, abs=0.15 * ratio**7)


def test_one_cylinder():
    found = balance(engine([0.0]), SPEED)
    first = found.of(1).force
    assert first.major == approx((RECIPROCATING + ROTATING) * RADIUS * SPEED**2)
    assert first.minor == approx(ROTATING * RADIUS * SPEED**2)
    assert (math.radians(first.angle_deg), first.sense) == (close(0.0, abs=1e-12), 1)
    for order in (2, 4):
        assert found.of(order).force.major == approx(size(order))
        assert found.of(order).force.sense == 0
        assert found.of(order).moment_balanced


def test_one_cylinder_with_an_offset():
    """Against quadrature of the piston's way, s = R cos a + sqrt(L^2 - (R sin a - e)^2)."""
    offset = 0.012
    cylinder = EngineCylinder(0.09, PISTON, ROD, pin_offset=offset)
    found = balance(EngineLayout(RADIUS, [cylinder], [1]), SPEED, (1, 2, 3, 4))

    def way(angle):
        side = RADIUS * math.sin(angle) - offset
        return RADIUS * math.cos(angle) + math.sqrt(LENGTH**2 - side**2)

    for row in found.rows:
        order = row.order
        parts = [
            quad(way, 0.0, 2.0 * math.pi, weight=weight, wvar=order, epsabs=1e-13)[0] / math.pi
            for weight in ("cos", "sin")
        ]
        wanted = RECIPROCATING * SPEED**2 * order**2 * complex(*parts)
        made = row.parts.reciprocating.force
        # 1e-13 m of the way is 16 * 1e-13 / R of the force of fourth order.
        assert 2.0 * made.forward.conjugate() == close(wanted, abs=4e-11 * UNIT)
    # The offset brings a third order, of -(R sin a - e)^4 / (8 L^3); what follows is a tenth of it.
    third = 9.0 * RADIUS**2 * offset / (8.0 * LENGTH**3) * UNIT
    assert found.of(3).force.major == close(third, rel=0.15)


def test_two_in_line():
    """Cranks opposite: no first force, its moment (m + m_r) R w^2 a; second forces add up."""
    found = balance(engine([0.0, 180.0]), SPEED)
    assert found.of(1).force_balanced
    assert found.of(1).moment.major == approx(
        (RECIPROCATING + ROTATING) * RADIUS * SPEED**2 * PITCH
    )
    assert found.of(2).force.major == approx(2.0 * size(2))
    assert found.of(2).moment_balanced


def test_three_in_line():
    """No forces; moments sqrt(3) h a of first, second and fourth order; the sixth order adds up."""
    found = balance(rotating_balanced([0.0, 240.0, 120.0]), SPEED, (1, 2, 4, 6))
    for order in (1, 2, 4):
        assert found.of(order).force_balanced
        assert found.of(order).moment.major == approx(math.sqrt(3.0) * size(order) * PITCH)
        # Forces upwards have moments about the axis across.
        assert abs(math.radians(found.of(order).moment.angle_deg)) == approx(math.pi / 2)
        assert found.of(order).moment.sense == 0
    assert found.of(6).force.major == close(3.0 * size(6), abs=EXACT * UNIT)
    assert found.of(6).moment_balanced
    # The throws' own moment turns with the shaft.
    rotating = balance(engine([0.0, 240.0, 120.0]), SPEED).of(1).parts.rotating.moment
    assert rotating.major == approx(math.sqrt(3.0) * ROTATING * RADIUS * SPEED**2 * PITCH)
    assert rotating.minor == approx(rotating.major)


def test_four_in_line(figure):
    """Cranks 0-180-180-0: 4 h_2 and 4 h_4, nothing else."""
    found = balance(engine([0.0, 180.0, 180.0, 0.0]), SPEED)
    assert found.of(1).force_balanced
    for order in (2, 4):
        force = found.of(order).force.major
        figure(f"four in line: force of order {order}", force, 4.0 * size(order), EXACT, "N")
    assert all(row.moment_balanced for row in found.rows)


def test_five_in_line(figure):
    """Firing order 1-2-4-5-3: moments 0.449 h_1 a and 4.980 h_2 a, as handbooks print."""
    cranks = [0.0] * 5
    for place, number in enumerate((1, 2, 4, 5, 3)):
        cranks[number - 1] = -144.0 * place
    found = balance(rotating_balanced(cranks), SPEED)
    assert all(row.force_balanced for row in found.rows)
    first, second = (found.of(k).moment.major / (size(k) * PITCH) for k in (1, 2))
    figure("five in line: moment of order 1 by h a", first, 0.449, 5e-4, "", "absolute")
    figure("five in line: moment of order 2 by h a", second, 4.980, 5e-4, "", "absolute")


def test_six_in_line(figure):
    """Cranks 0-120-240-240-120-0: only 6 h_6 and its multiples are left."""
    found = balance(engine([0.0, 120.0, 240.0, 240.0, 120.0, 0.0]), SPEED, (1, 2, 3, 4, 5, 6))
    assert all(row.moment_balanced for row in found.rows)
    assert [row.order for row in found.rows if not row.force_balanced] == [6]
    force = found.of(6).force.major
    figure("six in line: force of order 6", force, 6.0 * size(6), EXACT, "N", scale=UNIT)


def test_flat_twin():
    """Opposite cylinders on opposite cranks: no forces, moments h a of every order."""
    twin = EngineLayout(
        RADIUS,
        [
            made_cylinder(0.09, PISTON, ROD, math.degrees(crank), math.degrees(bank), place)
            for crank, bank, place in ((0.0, math.pi / 2, 0.0), (math.pi, -math.pi / 2, PITCH))
        ],
        [1, 2],
    )
    for row in balance(replace(twin, rotating=balancing_masses(twin)), SPEED).rows:
        assert row.force_balanced
        assert row.moment.major == approx(size(row.order) * PITCH)
        # Forces to the side tilt the engine about the vertical.
        assert math.radians(row.moment.angle_deg) == close(0.0, abs=1e-12)


def test_vee_of_90_degrees(figure):
    """Each throw: first order m R w^2, turning; second sqrt(2) h_2 across, fourth up and down."""
    found = balance(rotating_balanced([0.0], (-45.0, 45.0)), SPEED)
    first, second, fourth = (row.force for row in found.rows)
    assert first.major == approx(UNIT)
    assert first.minor == approx(UNIT)
    assert first.sense == 1
    wanted = math.sqrt(2.0) * size(2)
    figure("V of 90 deg: force of order 2, across", second.major, wanted, EXACT, "N")
    assert abs(math.radians(second.angle_deg)) == approx(math.pi / 2)
    assert fourth.major == approx(math.sqrt(2.0) * size(4))
    assert math.radians(fourth.angle_deg) == close(0.0, abs=1e-12)


def test_a_rod_beside_its_axis_leaves_some_of_the_turning_first_order(figure):
    """M l_d across a rod acts along the cylinder with -M l_d (sin b)'' = M l_d lambda w^2 sin a, no more.

    Half of that turns with the crank, 90 deg behind it; two cylinders at 90 deg add their halves.
    Counterweights opposite to the crank, with half of the reciprocating masses, leave it.
    """
    rod = replace(ROD, center_offset=0.004)
    wanted = rod.mass * rod.center_offset * RADIUS / LENGTH * SPEED**2
    for banks, share, backward in (((0.0,), 0.5, UNIT / 2), ((-45.0, 45.0), 1.0, 0.0)):
        plain = engine([0.0], banks)
        cylinders = [replace(cylinder, rod=rod) for cylinder in plain.cylinders]
        plain = replace(plain, cylinders=cylinders)
        weights = balancing_masses(plain, 0.5)
        left = balance(replace(plain, rotating=weights), SPEED).of(1).force
        what = f"lateral offset, share 0.5, {len(banks)} cylinders: what turns with the shaft"
        figure(what, left.forward, -1j * share * wanted, 1e-10, "N", scale=wanted)
        assert left.backward.real == close(backward, abs=EXACT * UNIT)
        # A weight 90 deg ahead of the crank takes it away.
        moment = share * rod.mass * rod.center_offset * RADIUS / LENGTH
        more = (*weights, RotatingMass(moment, angle_deg=90.0))
        gone = balance(replace(plain, rotating=more), SPEED).of(1).force
        assert abs(gone.forward) < 1e-10 * wanted


def test_cross_plane_v8(figure):
    """Cranks 0-90-270-180: the moment sqrt(10) h_1 a turns with the shaft, counterweights cancel it."""
    cranks, banks = [0.0, 90.0, 270.0, 180.0], (-45.0, 45.0)
    found = balance(rotating_balanced(cranks, banks), SPEED)
    assert found.of(1).force_balanced
    turning = found.of(1).moment.major
    wanted = math.sqrt(10.0) * UNIT * PITCH
    figure("cross-plane V8: turning moment of order 1", turning, wanted, EXACT, "N m")
    assert found.of(1).moment.minor == approx(math.sqrt(10.0) * UNIT * PITCH)
    assert found.of(1).moment.sense == 1
    assert found.of(2).force_balanced
    assert found.of(2).moment_balanced
    assert found.of(4).force.major == approx(4.0 * math.sqrt(2.0) * size(4))
    # Two counterweights at the ends are enough: they carry the moment over another length.
    plain = engine(cranks, banks)
    arm = (balance(plain, SPEED).of(1).moment.forward / 1j / SPEED**2) / (3.0 * PITCH)
    ends = [
        RotatingMass(abs(arm), angle_deg=math.degrees(float(np.angle(arm * sign))), position=place)
        for sign, place in ((1.0, 0.0), (-1.0, 3.0 * PITCH))
    ]
    for weights in (balancing_masses(plain, 0.5), ends):
        row = balance(replace(plain, rotating=weights), SPEED).of(1)
        assert row.force_balanced
        assert row.moment_balanced


def test_v6_of_90_degrees_with_three_throws():
    """Moments sqrt(3) h_1 a, turning, and sqrt(6) h_2 a; no forces."""
    found = balance(rotating_balanced([0.0, 120.0, 240.0], (-45.0, 45.0)), SPEED)
    first, second = found.of(1), found.of(2)
    assert first.force_balanced
    assert second.force_balanced
    assert first.moment.major == approx(math.sqrt(3.0) * UNIT * PITCH)
    assert first.moment.minor == approx(math.sqrt(3.0) * UNIT * PITCH)
    assert second.moment.major == approx(math.sqrt(6.0) * size(2) * PITCH)
    assert second.moment.sense == 0


def test_v6_of_60_degrees_with_six_pins(figure):
    """Pins of a throw 60 deg apart: moments 1.5 h_1 a with the shaft, 1.5 h_2 a against it."""
    found = balance(rotating_balanced([0.0, 120.0, 240.0], (-30.0, 30.0), -60.0), SPEED)
    first, second = found.of(1), found.of(2)
    assert first.force_balanced
    assert second.force_balanced
    for row, sense in ((first, 1), (second, -1)):
        what, wanted = f"V6 of 60 deg: moment of order {row.order}", 1.5 * size(row.order) * PITCH
        figure(what, row.moment.major, wanted, EXACT, "N m")
        assert row.moment.minor == approx(row.moment.major)
        assert row.moment.sense == sense
