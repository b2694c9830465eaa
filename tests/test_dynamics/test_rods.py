"""Connecting rods and what each of the four models keeps of them.

Sums of three to four numbers of the rod's size: 1e-13 of it is round-off with room.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.engine import ROD_MODELS
from dynamics.engine.rods import REACH, ConnectingRod

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


@settings(max_examples=30, deadline=None)
@given(rods(), st.floats(0.01, 100.0), st.floats(0.01, 100.0))
def test_other_units_give_the_same_models(rod, longer, heavier):
    scaled = ConnectingRod(
        longer * rod.length,
        heavier * rod.mass,
        longer * rod.center_distance,
        heavier * longer**2 * rod.inertia,
        longer * rod.center_offset,
    )
    for name in ROD_MODELS:
        ours, theirs = rod.model(name), scaled.model(name)
        np.testing.assert_allclose(
            theirs.masses, heavier * np.array(ours.masses), rtol=1e-12, atol=1e-12 * scaled.mass
        )
        assert theirs.added_inertia == close(
            heavier * longer**2 * ours.added_inertia, abs=1e-12 * scaled.mass * scaled.length**2
        )


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


def test_the_largest_inertia_is_that_of_masses_at_the_corners():
    length, mass, center = 0.265, 5.0, 0.097 + 0.009j
    side = REACH * length
    low, high = -side, length + side
    right, up = (center.real - low) / (high - low), (center.imag + side) / (2.0 * side)
    corners = np.array([low - 1j * side, high - 1j * side, low + 1j * side, high + 1j * side])
    shares = np.outer([1.0 - up, up], [1.0 - right, right]).ravel()
    assert complex(np.dot(shares, corners)) == close(center)
    largest = mass * float(np.dot(shares, np.abs(corners - center) ** 2))
    rod = ConnectingRod(length, mass, center.real, 0.99999 * largest, center.imag)
    assert rod.largest_inertia == close(largest, rel=1e-13)
    with pytest.raises(InputError, match=r"rod inertia: given .* because no mass of 5 kg"):
        ConnectingRod(length, mass, center.real, 1.00001 * largest, center.imag)


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
