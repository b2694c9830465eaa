import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from comparing import close
from crankbase.errors import InputError
from dynamics.harmonics import harmonics
from refusals import refusals, refusals_of, refused

VALUES = st.lists(
    st.floats(-1e4, 1e4, allow_nan=False, allow_subnormal=False), min_size=3, max_size=80
)
STROKES = st.sampled_from((2, 4))


def sample_angles(count, strokes, start=0.0):
    return start + np.arange(count) * strokes * np.pi / count


def test_phase_never_reaches_a_full_turn():
    angle = sample_angles(8, 2)
    found = harmonics(np.sin(angle - 1e-18) - 1e-17 * np.cos(angle), 2)
    assert np.all((found.phase >= 0.0) & (found.phase < 2.0 * np.pi))


def test_highest_term_of_an_even_number_of_samples_takes_half_weight():
    found = harmonics([1.0, -1.0, 1.0, -1.0], 2)
    assert found.amplitude == close([0.0, 1.0], abs=1e-15)
    assert found.phase[1] == close(np.pi / 2.0)


@pytest.mark.slow
@given(VALUES, STROKES, st.floats(-800.0, 800.0))
def test_series_meets_the_samples_wherever_they_start(values, strokes, start_deg):
    angles = sample_angles(len(values), strokes, np.radians(start_deg))
    found = harmonics(values, strokes, angles_deg=np.degrees(angles))
    assert found.at(crank_angle_deg=np.degrees(angles)) == close(
        values, abs=1e-10 * max(1.0, *map(abs, values))
    )


def test_series_takes_any_shape_of_angles():
    found = harmonics([1.0, 2.0, 4.0], 2)
    assert found.at(crank_angle_deg=0.0).shape == ()
    assert found.at(crank_angle_deg=np.degrees(np.zeros((2, 3)))).shape == (2, 3)
    assert float(found.at(crank_angle_deg=0.0)) == close(1.0)


def test_orders_above_a_highest_one_may_be_cut():
    angles = sample_angles(36, 4)
    kept = 2.0 + np.sin(1.5 * angles + 0.3)
    whole = harmonics(kept + np.cos(4.0 * angles))
    cut = whole.up_to(2.0)
    assert cut.orders.tolist() == [0.5, 1.0, 1.5, 2.0]
    for name in ("amplitude", "phase", "cosine", "sine"):
        assert getattr(cut, name).tolist() == getattr(whole, name)[:4].tolist()
    assert (cut.mean, cut.samples, cut.highest_order) == (whole.mean, 36, 9.0)
    assert cut.at(crank_angle_deg=np.degrees(angles)) == close(kept, abs=1e-13)
    assert cut.up_to(1.0).orders.tolist() == [0.5, 1.0]
    assert whole.up_to(9.0).orders.size == 18
    with refused("order"):
        cut.index_of(2.5)


test_no_other_orders_are_a_highest_one = refusals_of(
    lambda highest: harmonics(np.arange(36.0)).up_to(highest),
    (9.5, "highest_order"),
    (0.4, "highest_order"),
    (0.0, "highest_order"),
    (float("nan"), "highest_order"),
)


test_unusable_samples_are_refused = refusals_of(
    lambda samples: harmonics(samples),
    ([1.0, 2.0], "samples"),
    ([[1.0, 2.0, 3.0]], "samples"),
    ([1.0, float("nan"), 3.0], "samples[1]"),
    ([1.0, float("inf"), 3.0], "samples[1]"),
    (["1", "2", "3"], "samples"),
    ([1j, 2.0, 3.0], "samples"),
    ([[1.0], [2.0, 3.0]], "samples"),
)


@pytest.mark.parametrize("strokes", [0, 1, 3, 8, "4", True])
def test_other_strokes_are_refused(strokes):
    with refused("strokes"):
        harmonics([1.0, 2.0, 3.0], strokes)


test_unusable_angles_are_refused = refusals_of(
    lambda angles, strokes: harmonics(np.arange(len(angles)), strokes, angles_deg=angles),
    (np.arange(0.0, 360.0, 10.0), 4, "angles_deg"),
    (np.arange(0.0, 720.0, 20.0), 2, "angles_deg"),
    ([0.0, 180.0, 180.0, 540.0], 4, "angles_deg[2]"),
    ([540.0, 360.0, 180.0, 0.0], 4, "angles_deg[1]"),
    ([0.0, 180.0, 350.0, 540.0], 4, "angles_deg[2]"),
    ([0.0, float("nan"), 350.0, 540.0], 4, "angles_deg[1]"),
    (np.delete(np.arange(0.0, 720.0, 10.0), 30), 4, "angles_deg[30]"),
)


def test_angles_printed_rounded_are_accepted():
    angles_deg = np.round(np.arange(216) * 720.0 / 216, 1)
    assert harmonics(np.ones(216), angles_deg=angles_deg).samples == 216


@pytest.mark.slow
@given(
    st.integers(1, 24),
    st.booleans(),
    STROKES,
    st.floats(-720.0, 720.0),
    st.randoms(use_true_random=False),
)
@settings(max_examples=30, deadline=None)
def test_a_known_series_returns_its_amplitudes_and_phases(terms, even, strokes, start_deg, random):
    """Odd and even numbers of samples, wherever they start; 1e-12 of the largest amplitude."""
    amplitudes = np.array([random.uniform(0.5, 1.0) for _ in range(terms)])
    phases = np.array([random.uniform(0.0, 2.0 * np.pi) for _ in range(terms)])
    mean = random.uniform(-5.0, 5.0)
    # One sample more than twice the terms resolves them all; the half sampling rate stays free.
    count = 2 * terms + (2 if even else 1)
    angles = sample_angles(count, strokes, np.radians(start_deg))
    orders = 2.0 / strokes * np.arange(1, terms + 1)
    values = mean + np.sin(np.outer(angles, orders) + phases) @ amplitudes
    found = harmonics(values, strokes, angles_deg=np.degrees(angles))
    assert found.orders[:terms] == close(orders, rel=1e-15)
    assert found.mean == close(mean, abs=1e-12)
    assert found.amplitude[:terms] == close(amplitudes, abs=1e-12)
    apart = np.exp(1j * found.phase[:terms]) - np.exp(1j * phases)
    # Amplitudes are not small, so that phases are as well determined.
    assert np.max(np.abs(apart)) < 1e-12
    assert found.amplitude[terms:] == close(0.0, abs=1e-12)


def test_closing_sample_does_not_count_twice():
    """With both ends of the cycle the harmonics would change: it is refused where angles tell."""
    angles_deg = np.arange(0.0, 721.0, 20.0)
    values = 3.0 + 2.0 * np.cos(np.radians(0.5 * angles_deg))
    assert harmonics(values[:-1], angles_deg=angles_deg[:-1]).mean == close(3.0, rel=1e-14)
    assert harmonics(values).mean != close(3.0, rel=1e-3)
    for strokes, every in ((4, 1), (2, 2)):
        with pytest.raises(InputError, match="closing sample"):
            harmonics(values[::every], strokes, angles_deg=angles_deg[::every] * strokes / 4)


def test_an_order_beyond_the_samples_would_appear_as_a_lower_one():
    """Order 7 in 12 samples of a two-stroke cycle looks like order 5: so it is refused."""
    found = harmonics(np.sin(7.0 * sample_angles(12, 2)), 2)
    assert found.amplitude[4] == close(1.0)
    with refused("order"):
        found.index_of(7)


test_refused = refusals(
    ("angles_deg", lambda: harmonics([1.0, 2.0, 3.0], angles_deg=[0.0, 180.0, 360.0, 540.0])),
)
