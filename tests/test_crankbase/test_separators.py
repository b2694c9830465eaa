"""Numbers with decimal commas and separators of thousands: no digit is lost in what is suggested."""

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crankbase.errors import InputError
from crankbase.units.quantity import parse_quantity
from crankbase.units.separators import readings

# How a number is written: separator of thousands and decimal mark.
WRITTEN = st.sampled_from(
    [(",", "."), (".", ","), (" ", ","), ("'", "."), ("\u202f", ","), ("", ",")]
)


@given(st.integers(0, 10**9), st.integers(0, 999), st.integers(0, 3), WRITTEN)
def test_what_is_meant_is_among_the_readings_and_no_digit_is_lost(whole, part, places, marks):
    thousands, point = marks
    fraction = f"{part:03d}"[:places]
    text = f"{whole:,}".replace(",", thousands) + (point + fraction if fraction else "")
    if text.isdigit() or text.replace(".", "", 1).isdigit():
        assert readings(f"{text} mm") == ()
        return
    meant = Decimal(f"{whole}.{fraction or 0}")
    found = [Decimal(one.removesuffix(" mm")) for one in readings(f"{text} mm")]
    assert meant in found
    # Every reading has the digits that were written, but zeros at the end of a fraction.
    digits = "".join(filter(str.isdigit, text)).strip("0")
    assert all("".join(filter(str.isdigit, str(one))).strip("0") == digits for one in found)
    assert (len(found) > 1) == (
        (text.count(",") + text.count(".") == 1) and len(text.replace(".", ",").split(",")[1]) == 3
        and len(text.replace(".", ",").split(",")[0]) <= 3 and not text.startswith("0")
    )  # fmt: skip


@pytest.mark.parametrize(
    ("text", "suggested"),
    [
        ("82,5 mm", 'like "82.5 mm"'),
        ("1.200,5 mm", 'like "1200.5 mm"'),
        ("1,200 mm", 'like "1.2 mm" or "1200 mm", whichever is meant'),
        ("1 200 mm", 'like "1200 mm"'),
        ("1'200 mm", 'like "1200 mm"'),
        ("82,5", 'like "82.5 mm"'),
        ("17 0 mm", "which is not one number with one unit"),
        ("Ø180 mm", 'write for example "180 mm"'),
        # Another sign than minus is not left out.
        ("\u20135 mm", 'write for example "(?!5 mm)'),
        ("1.4 mmm", "in an unknown unit; write it in mm or a like unit"),
        ("66 %", "which is no length; write it in mm"),
    ],
)
def test_suggestion_keeps_the_digits(text, suggested):
    with pytest.raises(InputError, match=suggested):
        parse_quantity(text, "m", "throw.crank_radius")


@pytest.mark.parametrize("given", ["+5,N'%4", "847,e+8Å4*"])
def test_what_is_no_number_behind_a_comma_is_refused(given):
    with pytest.raises(InputError, match="not one number with one unit"):
        parse_quantity(given, "m", "f")
