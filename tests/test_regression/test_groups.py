import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.material import STEEL
from regression.fits.forms import Encoding, constant_groups, factor_encoding, group_encoding
from regression.fits.terms import (
    GROUPS,
    group_named,
    group_names,
    group_values,
    independent_groups,
)
from regression.plans.factors import Factor
from regression.response_kinds import response_scale

MAIN = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.135,
    "pin_length": 0.139,
    "web_width": 0.300,
    "web_thickness": 0.068,
    "fillet_radius": 0.012,
    "main_journal_bore": 0.0,
    "pin_bore": 0.060,
}


def columns(count=20, seed=1, **ranges):
    """Arrays of all main dimensions, some of them varied over ranges."""
    rng = np.random.default_rng(seed)
    found = {name: np.full(count, value) for name, value in MAIN.items()}
    return found | {name: rng.uniform(*ends, count) for name, ends in ranges.items()}


def test_groups_by_hand():
    values = group_values({name: np.array([value]) for name, value in MAIN.items()})
    expected = {
        "s/R": (0.110 + 0.090 - 0.170) / 0.170,
        "R/h": 2.5,
        "B/D_shm": 5 / 3,
        "D_km/D_shm": 11 / 9,
        "L_shm/D_shm": 139 / 180,
        "L_km/D_shm": 0.75,
        "r/D_shm": 1 / 15,
        "d_km/D_km": 0.0,
        "d_shm/D_shm": 1 / 3,
    }
    assert {name: column[0] for name, column in values.items()} == close(expected)
    assert list(values) == list(GROUPS)


def test_groups_of_plain_numbers_are_plain_numbers():
    for name in GROUPS:
        assert type(group_named(name).value(MAIN)) is float


@pytest.mark.parametrize("size", [0.1, 3.0])
def test_groups_do_not_change_with_the_size(size):
    other = {name: size * value for name, value in MAIN.items()}
    for name in GROUPS:
        assert group_named(name).value(other) == close(
            group_named(name).value(MAIN), rel=1e-12, abs=1e-12
        )


def test_other_lengths_are_divided_by_the_pin():
    names = group_names([*MAIN, "web_journal_end"])
    assert names[-1] == "web_journal_end/D_shm"
    assert group_named(names[-1]).value(MAIN | {"web_journal_end": 0.09}) == close(0.5)
    with pytest.raises(InputError, match="group: given 'web_width'; allowed are s/R"):
        group_named("web_width")


def test_scales_make_responses_dimensionless():
    """Lengths times 2: compliances by 2, by 8; mass times 8 (dimensional analysis)."""
    one, two = {"pin_diameter": 0.1}, {"pin_diameter": 0.2}
    for unit, ratio in (("m/N", 1 / 2), ("rad/(N m)", 1 / 8), ("kg", 8.0), ("", 1.0)):
        scale = response_scale(unit, one, STEEL)
        assert response_scale(unit, two, STEEL) / scale == close(ratio)
    assert response_scale("m/N", one, STEEL) == close(1 / (2.1e11 * 0.1))
    with pytest.raises(InputError, match="unit: given 'Pa'"):
        response_scale("Pa", one, STEEL)


def test_groups_that_vary_are_chosen():
    found = group_values(columns(web_width=(0.27, 0.33), web_thickness=(0.04, 0.09)))
    assert independent_groups(found, 2) == ("R/h", "B/D_shm")
    assert independent_groups(found, 1) == ("R/h",)
    # The radius moves two groups; one number cannot make them independent.
    found = group_values(columns(crank_radius=(0.165, 0.175)))
    assert independent_groups(found, 1) == ("s/R",)


@pytest.mark.parametrize(("share", "chosen"), [(2e-3, ("a", "b")), (5e-4, ("a",))])
def test_a_group_is_chosen_for_its_own_share(share, chosen):
    """A thousandth of a group's variation that others do not explain makes it one of its own."""
    first, second = np.array([1.0, -1.0, 1.0, -1.0]), np.array([1.0, 1.0, -1.0, -1.0])
    values = {"a": 5.0 + first, "b": 5.0 + np.sqrt(1.0 - share**2) * first + share * second}
    assert independent_groups(values, 2) == chosen


def test_encoding_by_groups():
    factors = (Factor("web_width", "m", 0.27, 0.33), Factor("web_thickness", "m", 0.04, 0.09))
    dimensions = columns(web_width=(0.27, 0.33), web_thickness=(0.04, 0.09))
    values = np.column_stack([dimensions[factor.name] for factor in factors])
    found = group_encoding(factors, values, dimensions)
    assert found == Encoding("groups", ("R/h", "B/D_shm"), (True, True))
    x = found.columns(factors, values, dimensions)
    assert x == close(np.column_stack([0.17 / values[:, 1], values[:, 0] / 0.18]))
    fixed = constant_groups(dimensions)
    assert fixed["r/D_shm"] == close(1 / 15)
    assert "R/h" not in fixed


def test_more_groups_than_factors_are_refused():
    dimensions = columns(pin_diameter=(0.17, 0.19))
    values = dimensions["pin_diameter"][:, None]
    with pytest.raises(InputError, match=r"groups: given 1 factors that make \d groups vary"):
        group_encoding((Factor("pin_diameter", "m", 0.17, 0.19),), values, dimensions)


def test_factors_that_are_no_lengths_of_the_throw_are_refused():
    factor = Factor("counterweight.angle", "rad", 0.5, 1.5)
    with pytest.raises(InputError, match=r"groups: given the factor counterweight\.angle"):
        group_encoding((factor,), np.linspace(0.5, 1.5, 20)[:, None], columns())


def test_encoding_by_factors():
    factors = (
        Factor("web_width", "m", 0.27, 0.33),
        Factor("fillet_radius", "m", 0.0, 0.012),
        Factor.of_labels("web_outline", ("obround", "rectangle", "other")),
    )
    values = np.array([[0.27, 0.001, 0.0], [0.30, 0.012, 1.0], [0.33, 0.010, 1.0]])
    found = factor_encoding(factors, values)
    # No run has the third label; the range of the fillet reaches 0.
    assert found.names == ("web_width", "fillet_radius", "web_outline=rectangle")
    assert found.logged == (True, False, False)
    assert found.columns(factors, values, {})[:, 2].tolist() == [0.0, 1.0, 1.0]
