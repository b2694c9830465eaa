"""What counts as a number, and what a wrong name may have been meant for."""

import math

import numpy as np
import pytest

from crankbase.checks.choices import allowed_names, did_you_mean
from crankbase.checks.scalars import (
    is_number,
    is_whole,
    is_whole_within,
    whole_number,
    whole_within,
)
from crankbase.errors import InputError

NONE = [True, False, np.True_, "3", None, [3], 3j, np.complex128(3.0)]


@pytest.mark.parametrize("value", [3, 3.5, -0.0, np.float32(3.5), np.int8(3), np.float64(1e300)])
def test_numbers(value):
    assert is_number(value)


@pytest.mark.parametrize("value", [*NONE, math.nan, math.inf, np.float64("nan"), 10**400])
def test_what_is_no_number(value):
    assert not is_number(value)


@pytest.mark.parametrize("value", [*NONE, 3.0, np.float64(3.0), math.nan])
def test_what_is_no_whole_number(value):
    assert not is_whole(value)
    assert not is_whole_within(value, 0, 5)
    with pytest.raises(InputError, match=r"^count: given .*; allowed are the whole numbers 0 to 5"):
        whole_within("count", value, 0, 5, "there are so many")


@pytest.mark.parametrize("value", [0, 5, np.int64(3), np.uint8(5)])
def test_whole_numbers_of_a_range(value):
    made = whole_within("count", value, 0, 5, "there are so many")
    assert made == value
    assert type(made) is int
    assert whole_number("count", value, 0, "there are so many") == value


@pytest.mark.parametrize("value", [-1, 6, 10**400])
def test_whole_numbers_outside_a_range(value):
    assert is_whole(value)
    with pytest.raises(InputError, match=r"because there are so many\.$"):
        whole_within("count", value, 0, 5, "there are so many")


def test_a_range_of_one_number_is_named_as_one():
    with pytest.raises(
        InputError, match=r"^pin: given 1; allowed is 0, because the throw has one\.$"
    ):
        whole_within("pin", 1, 0, 0, "the throw has one")


def test_a_close_name_is_asked_for():
    names = ("web_width", "pin_length")
    assert did_you_mean("web_with", names) == "did you mean web_width? "
    assert did_you_mean("web_with", names, form="[{}]") == "did you mean [web_width]? "
    assert did_you_mean("web_with", names, cutoff=0.99) == ""
    assert allowed_names("x", iter(names)) == "allowed are web_width, pin_length"
    assert allowed_names("pin_lenght", iter(names)) == (
        "did you mean pin_length? allowed are web_width, pin_length"
    )
