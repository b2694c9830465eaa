"""What tests take for alike."""

import math

import pytest

from comparing import close


@pytest.mark.parametrize(
    ("found", "expected", "allowed", "same"),
    [
        (1.0000009e-9, 1e-9, {}, True),
        (1.000002e-9, 1e-9, {}, False),  # less than 1e-12 apart
        (1.0009e-9, 1e-9, {"rel": 1e-3}, True),
        (1e-13, 0.0, {}, False),  # nothing is near zero by itself
        (1e-13, 0.0, {"abs": 1e-12}, True),
        (1.0 + 1e-7, 1.0, {"abs": 1e-8}, False),  # beside `abs` nothing is allowed unasked
        (1.0 + 1e-7, 1.0, {"abs": 1e-8, "rel": 1e-6}, True),
        ([1.0, 2.0], [1.0, 2.1], {"rel": 0.01}, False),
        (math.nan, math.nan, {}, False),
        (math.nan, math.nan, {"nan_ok": True}, True),
    ],
)
def test_numbers_are_compared_however_small_they_are(found, expected, allowed, same):
    assert (found == close(expected, **allowed)) is same
