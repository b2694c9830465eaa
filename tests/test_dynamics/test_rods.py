"""Models of connecting rods: masses, and the forces they give."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.engine import ROD_MODELS
from dynamics.engine.forces import gas_forces, mechanism_forces, pin_groups
from dynamics.engine.layout import EngineCylinder, EngineLayout, SlavePin
from dynamics.engine.rods import ConnectingRod

unit = st.floats(0.05, 0.95)


@st.composite
def rods(draw, offset=None):
    length, mass = draw(st.floats(0.05, 3.0)), draw(st.floats(0.1, 900.0))
    center = length * draw(unit)
    aside = 0.45 * length * (draw(st.floats(-1.0, 1.0)) if offset is None else offset)
    inertia = mass * length**2 * draw(st.floats(0.01, 0.5))
    return ConnectingRod(length, mass, center, inertia, aside)


def inertia_about(model, place):
    """Inertia of point masses and what is added, about any place."""
    return (
        sum(
            mass * abs(where - place) ** 2
            for mass, where in zip(model.masses, model.places, strict=True)
        )
        + model.added_inertia
    )


@settings(max_examples=30, deadline=None)
@given(rods())
def test_what_each_model_keeps(rod):
    size = rod.mass * rod.length**2
    for name in ROD_MODELS:
        model = rod.model(name)
        assert model.name == name
        assert model.length == rod.length
        assert model.mass == close(rod.mass, rel=1e-13)
        assert model.center.real == close(rod.center_distance, abs=1e-13 * rod.length)
        # The parallel axis theorem ties what the model says of itself to its point masses.
        about = inertia_about(model, model.center)
        assert model.inertia == close(about, abs=1e-13 * size)
    for name in ("rigid", "three-mass"):
        kept = inertia_about(rod.model(name), rod.center)
        assert kept == close(rod.inertia, abs=1e-13 * size)
    assert rod.model("rigid").places == (rod.center,)
    on_axis = complex(rod.center_distance)
    kept = inertia_about(rod.model("two-mass with inertia"), on_axis)
    assert kept == close(rod.inertia, abs=1e-13 * size)
    for name in ("two-mass", "two-mass with inertia"):
        assert rod.model(name).center.imag == 0.0
        near, far = rod.center_distance, rod.length - rod.center_distance
        assert rod.model(name).masses == close(
            (rod.mass * far / rod.length, rod.mass * near / rod.length), rel=1e-13
        )
    plain = rod.mass * rod.center_distance * (rod.length - rod.center_distance)
    assert rod.model("two-mass").inertia == close(plain, rel=1e-13)


@settings(max_examples=30, deadline=None)
@given(rods())
def test_the_three_mass_model_misses_the_lateral_static_moment(rod):
    model = rod.model("three-mass")
    at_pins = model.masses[0] + model.masses[1]
    off = rod.center_offset - model.center.imag
    assert off == close(at_pins * rod.center_offset / rod.mass, abs=1e-13 * rod.length)
    assert model.masses[0] > 0.0
    assert model.masses[1] > 0.0
    assert model.places == (0j, complex(rod.length), rod.center)


@settings(max_examples=30, deadline=None)
@given(rods(offset=0.0))
def test_without_offset_the_three_mass_model_is_the_rigid_rod(rod):
    rigid, model = rod.model("rigid"), rod.model("three-mass")
    assert model.mass == close(rigid.mass, rel=1e-12)
    assert model.center == close(rigid.center, rel=1e-12)
    assert model.inertia == close(rigid.inertia, rel=1e-12)


def test_two_masses_with_the_inertia_they_have_lack_none():
    rod = ConnectingRod(0.265, 5.0, 0.097, 5.0 * 0.097 * 0.168)
    assert rod.model("two-mass with inertia").added_inertia == close(0.0, abs=1e-15)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(unit, unit, unit), min_size=1, max_size=6))
def test_no_body_within_reach_is_refused_for_its_inertia(parts):
    """Any point masses in the box of half a length round the pins make an allowed inertia."""
    length = 0.3
    masses = np.array([mass for mass, _, _ in parts])
    places = np.array([complex(2.0 * u - 0.5, v - 0.5) * length for _, u, v in parts])
    center = complex(np.dot(masses, places) / masses.sum())
    inertia = float(np.dot(masses, np.abs(places - center) ** 2))
    if not 0.0 < center.real < length or inertia < 1e-12:
        return
    ConnectingRod(length, float(masses.sum()), center.real, inertia, center.imag)


GOOD = {"length": 0.265, "mass": 5.0, "center_distance": 0.097, "inertia": 0.07}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": -5.0}, "rod mass: given -5 kg; .*because it is a mass"),
        ({"mass": 0.0}, "rod mass: given 0 kg"),
        ({"length": -0.265}, "rod length: given -0.265 m"),
        ({"inertia": 0.0}, "rod inertia: given 0 kg m\\^2"),
        ({"inertia": -0.1}, "rod inertia: given -0.1 kg m\\^2"),
        ({"inertia": 5.0}, "rod inertia: given 5 kg m\\^2; allowed is 0.*or less, because no mass"),
        ({"center_distance": 0.0}, "rod center_distance: given 0 m; .*between the pins"),
        ({"center_distance": 0.265}, "rod center_distance: given 0.265 m; .*length of 0.265 m"),
        ({"center_distance": -0.01}, "rod center_distance: given -0.01 m"),
        ({"center_offset": 0.14}, "rod center_offset: given 0.14 m; .*within the rod"),
        ({"center_offset": -0.14}, "rod center_offset: given -0.14 m"),
        ({"center_offset": math.nan}, "rod center_offset: given nan"),
        ({"mass": "5"}, "rod mass: given '5'"),
    ],
)
def test_impossible_rods_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        ConnectingRod(**{**GOOD, **change})


def test_models_that_are_not_known_are_refused():
    with pytest.raises(
        InputError, match="rod model: given 'four-mass'; allowed are rigid, three-mass"
    ):
        ConnectingRod(**GOOD).model("four-mass")


SPEED, GAIN = 220.0, 9000.0
ANGLES = np.linspace(0.0, 4.0 * math.pi, 24, endpoint=False)
GAS = np.array([30e3 * (1.2 + np.cos(ANGLES / 2.0)), 20e3 * (1.1 + np.sin(ANGLES / 2.0))])
RUB = np.array([400.0 * np.sin(ANGLES), -300.0 * np.cos(ANGLES)])
FORCES = ("side", "piston_pin", "foot", "crankpin")


def largest(values):
    return np.max(np.abs(values))


def single(rod, **more):
    return EngineLayout(0.07, [EngineCylinder(0.13, 4.0, rod, **more)], [1])


def test_without_lateral_offset_three_masses_are_the_rigid_rod_and_two_are_not():
    """Requirement: 1e-12 between three masses and the rigid rod; two masses alone are 3.7 % of the
    largest side force and 0.8 % of the largest crankpin force off."""
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069))
    found = {
        name: mechanism_forces(
            engine,
            SPEED,
            GAS[0],
            model=name,
            crank_acceleration=GAIN,
            shaft_angles_deg=np.degrees(ANGLES),
        )
        for name in ROD_MODELS
    }
    size = largest(found["rigid"].foot)
    for name in ("three-mass", "two-mass with inertia"):
        for part in FORCES:
            ours, wanted = getattr(found[name], part), getattr(found["rigid"], part)
            np.testing.assert_allclose(ours, wanted, rtol=0.0, atol=1e-12 * size)
    static, rigid = found["two-mass"], found["rigid"]
    side, pin = (largest(getattr(static, n) - getattr(rigid, n)) for n in ("side", "crankpin"))
    assert side / largest(rigid.side) == close(0.0370, abs=5e-5)
    assert pin / largest(rigid.crankpin) == close(0.0084, abs=5e-5)


def test_with_lateral_offset_only_the_rigid_rod_is_the_rigid_rod():
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009))
    found = {
        name: mechanism_forces(engine, SPEED, model=name, shaft_angles_deg=np.degrees(ANGLES))
        for name in ROD_MODELS
    }
    size = largest(found["rigid"].crankpin)
    for name in ROD_MODELS[1:]:
        apart = largest(found[name].crankpin - found["rigid"].crankpin)
        assert apart > 0.01 * size


def test_a_rod_hinged_at_the_crankpin_stands_beside_the_main_rod():
    """With the slave pin at 1e-9 m what the main rod's wall adds is gone, to 1e-9 / 0.265."""
    rod = ConnectingRod(0.265, 5.0, 0.097, 0.069, 0.009)
    left, right = (
        EngineCylinder(0.13, 4.0, rod),
        EngineCylinder(0.13, 4.0, rod, bank_angle_deg=math.degrees(0.8)),
    )
    at_pin = EngineCylinder(
        0.13,
        4.0,
        rod,
        bank_angle_deg=math.degrees(0.8),
        slave_pin=SlavePin(1, 1e-9, angle_deg=math.degrees(0.8)),
    )
    side_by_side = EngineLayout(0.07, [left, right], [1, 2])
    hinged = EngineLayout(0.07, [left, at_pin], [1, 2])
    ours, theirs = (
        mechanism_forces(e, SPEED, GAS, friction=RUB, shaft_angles_deg=np.degrees(ANGLES))
        for e in (side_by_side, hinged)
    )
    size = largest(ours.foot)
    np.testing.assert_allclose(theirs.crankpin, ours.crankpin, rtol=0.0, atol=1e-7 * size)
    assert pin_groups(side_by_side) == ((1,), (2,))
    assert pin_groups(hinged) == ((1, 2),)


def test_each_cylinder_takes_its_pressure_from_its_own_firing_top():
    class Rising:
        strokes = 4

        def at(self, *, angle_deg):
            angle = np.radians(angle_deg)
            return 1e5 + 1e4 * np.mod(angle, 4.0 * math.pi)

    rod = ConnectingRod(0.265, 5.0, 0.097, 0.069)
    cylinders = [
        EngineCylinder(0.13, 4.0, rod, crank_angle_deg=math.degrees(a)) for a in (0.0, math.pi)
    ]
    engine = EngineLayout(0.07, cylinders, [1, 2])
    area = 0.25 * math.pi * 0.13**2
    found = gas_forces(engine, Rising(), 0.9e5, shaft_angles_deg=np.degrees([0.0, 0.5]))
    np.testing.assert_allclose(found[0], area * (1e4 + 1e4 * np.array([0.0, 0.5])), rtol=1e-12)
    # Cylinder 2 fires half a turn after cylinder 1, so its own angle is three half turns on.
    np.testing.assert_allclose(
        found[1], area * (1e4 + 1e4 * (3.0 * math.pi + np.array([0.0, 0.5]))), rtol=1e-12
    )
    with pytest.raises(InputError, match="pressure: given 1 for 2 cylinders"):
        gas_forces(engine, [Rising()], shaft_angles_deg=np.degrees([0.0]))
    two_stroke = Rising()
    two_stroke.strokes = 2
    with pytest.raises(InputError, match="pressure: given a cycle of 2 strokes; allowed is 4"):
        gas_forces(engine, [Rising(), two_stroke], shaft_angles_deg=np.degrees([0.0]))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"gas": np.zeros((3, 24))}, r"gas: given an array of shape \(3, 24\); .*fits \(1, 24\)"),
        ({"friction": np.zeros(5)}, r"friction: given an array of shape \(5,\)"),
        ({"gas": math.nan}, "gas: given nan"),
        ({"model": "stiff"}, "rod model: given 'stiff'"),
    ],
)
def test_what_does_not_fit_is_refused(more, words):
    engine = single(ConnectingRod(0.265, 5.0, 0.097, 0.069))
    with pytest.raises(InputError, match=words):
        mechanism_forces(engine, SPEED, shaft_angles_deg=np.degrees(ANGLES), **more)
