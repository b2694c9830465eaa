"""What counts as a number, what fields accept, and that messages stay short."""

import math

import numpy as np
import pytest

from comparing import close
from crankbase.choices import (
    allowed_names,
    did_you_mean,
    is_number,
    is_whole,
    is_whole_within,
    whole_number,
    whole_within,
)
from crankbase.errors import LONGEST_MESSAGE, InputError, quoted
from crankbase.model import InputModel, part_field, quantity_field
from geometry.throw import CrankThrow
from refusals import refused


def as_text(dimensions):
    return {name: f"{1000.0 * value:.10g} mm" for name, value in dimensions.items()}


def test_text_and_numbers_give_the_same_throw(dimensions):
    dimensions = {**dimensions, "web_width": 0.285}
    assert CrankThrow.from_text(as_text(dimensions)) == CrankThrow(**dimensions)


def test_fillet_is_optional(dimensions):
    del (sharp := dict(dimensions))["fillet_radius"]
    assert CrankThrow(**sharp).fillet_radius == 0.0


def test_numpy_numbers_and_integers_are_numbers(dimensions):
    throw = CrankThrow(**{**dimensions, "crank_radius": np.float64(0.17), "web_width": 1})
    assert (throw.crank_radius, throw.web_width) == (0.17, 1.0)


JOURNALS = ("pin_diameter", "main_journal_diameter")
LENGTHS = ("web_thickness", "pin_length", "main_journal_length")
NO_NUMBERS = (math.nan, math.inf, None, [0.3])
TEXTS = ("300 mm", "0.3", "wide", True)


@pytest.mark.parametrize(
    ("changes", "field", "allowed"),
    [
        ({"pin_length": 0.020, "fillet_radius": 0.010}, "fillet_radius", "2.2 mm to 9 mm"),
        ({"main_journal_length": 0.020}, "fillet_radius", "0, or 2.2 mm to 9 mm"),
        ({"web_width": 0.230}, "fillet_radius", "0, or 2.2 mm to 5 mm"),
        ({"web_width": 0.221}, "fillet_radius", "only 0"),
        ({"fillet_radius": 0.001}, "fillet_radius", "0, or 2.2 mm to 40 mm"),
        *(({name: 0.310}, name, "at most 300 mm") for name in JOURNALS),
        *(({name: 0.3, "fillet_radius": 0.0}, name, "at most 299.7 mm") for name in JOURNALS),
        *(({name: -0.285}, name, "mm to") for name in ("web_width", "crank_radius", "pin_length")),
        ({"fillet_radius": -0.285}, "fillet_radius", "mm to"),
        *(({"web_width": value}, "web_width", "1 mm to 4000 mm") for value in NO_NUMBERS),
        *(({"web_width": value}, "web_width", "a number in m") for value in TEXTS),
        ({"web_widht": 0.3}, "web_widht", "did you mean web_width?"),
        ({"colour": 0.3}, "colour", "allowed are crank_radius, "),
        *(({name: 0.004, "fillet_radius": 0.0}, name, "8.8 mm or more") for name in LENGTHS),
    ],
)
def test_dimensions_that_are_refused_with_those_allowed(dimensions, changes, field, allowed):
    with refused(f"throw.{field}") as caught:
        CrankThrow(**dimensions | changes)
    assert allowed in str(caught.value)
    assert "pydantic" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "field", "allowed"),
    [
        ({"crank_radius": 170}, "crank_radius", '"170 mm"'),
        ({"web_width": "-285 mm"}, "web_width", "1 mm to 4000 mm"),
        ({"fillet_radius": "90 mm"}, "fillet_radius", "0, or 2.2 mm to 40 mm"),
        ({"web_widht": "300 mm"}, "web_widht", "did you mean web_width?"),
    ],
)
def test_dimensions_of_a_file_are_refused_in_its_section(dimensions, changes, field, allowed):
    with refused(f"throws.aft.{field}") as caught:
        CrankThrow.from_text(as_text(dimensions) | changes, section="throws.aft")
    assert allowed in str(caught.value)


def test_journals_a_little_narrower_than_the_web(dimensions):
    for name in JOURNALS:
        assert CrankThrow(**dimensions | {"fillet_radius": 0.0, name: 0.2997}).web_width == 0.3


def test_missing_field(dimensions):
    del (incomplete := dict(dimensions))["web_width"]
    for make in (
        lambda: CrankThrow(**incomplete),
        lambda: CrankThrow.from_text(as_text(incomplete)),
    ):
        with refused("throw.web_width"):
            make()


def test_a_throw_does_not_change(dimensions):
    throw = CrankThrow(**dimensions)
    with pytest.raises(ValueError, match="records stay as they were checked"):
        throw.crank_radius = 0.2
    assert hash(throw) == hash(CrankThrow(**dimensions))


def test_derived_dimensions(dimensions):
    throw = CrankThrow(**dimensions)
    assert throw.length == close(0.395, rel=1e-14)
    assert throw.overlap == close(0.030, rel=1e-12)


def test_a_changed_record_keeps_what_was_given_alone(dimensions):
    assert CrankThrow(**dimensions).changed(pin_length=0.150).model_fields_set == set(dimensions)


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
    with refused("count"):
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
    with refused("count"):
        whole_within("count", value, 0, 5, "there are so many")


def test_a_range_of_one_number_is_named_as_one():
    with pytest.raises(InputError, match=r"^pin: given 1; allowed is 0, "):
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


LONG = 10**5


@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    [
        repr("a" * LONG),
        repr("a b' " * LONG),
        repr('say "a" \\ ' * LONG),
        repr(["a", 'b"]', "c']"] * LONG),
        repr({"a": [1, (2, 3)]} | {str(number): number for number in range(1000)}),
        "array(" + repr(list(range(1000))) + ")",
        "1" * LONG,
        "--" + "x" * LONG,
    ],
    ids=["text", "apostrophes", "quotes", "list", "dict", "array", "number", "word"],
)
def test_what_was_given_is_cut_and_the_rest_stays(given):
    message = str(InputError(f"rod.mass: given {given}; allowed is the rod's mass, not others'."))
    assert message.startswith("rod.mass: given " + given[:40])
    assert message.endswith("; allowed is the rod's mass, not others'.")
    assert len(message) <= len("rod.mass: given ; allowed is the rod's mass, not others'.") + 80


@pytest.mark.parametrize(
    "message",
    [
        "the rod's mass stands in one place and the pistons' in another, which the engine's file tells.",
        f"{'/'.join(['a folder of files'] * 20)}/mine.toml: does not exist; give the path of a file.",
        f"section: given 'x'; allowed are {', '.join(f'name_{number}' for number in range(60))}.",
    ],
)
def test_other_words_stay_as_they_are(message):
    assert str(InputError(message)) == message


def test_no_message_is_endless():
    assert len(str(InputError("a b " * LONG))) <= LONGEST_MESSAGE


def test_an_integer_that_python_does_not_write_can_be_quoted():
    assert "digits" in quoted(10**5000)
    assert quoted([1, "a"]) == "[1, 'a']"


class Point(InputModel):
    """A part of `Load`."""

    section = "load.points"
    speed: float = quantity_field("speed", "rad/s", 1.0, 100.0)


class Load(InputModel):
    """A record with parts."""

    section = "load"
    points: tuple[Point, ...] = part_field("points", Point, many=True)
    seed: int = quantity_field("seed", "", 0, 2**31 - 1, default=0)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"points": [{"speed": 9.0}, {"speed": -1.0}]}, r"load\.points\[1\]\.speed: given -9\.5"),
        ({"points": [{}]}, r"load\.points\[0\]\.speed: missing"),
        ({"points": [5]}, r"load\.points\[0\]: given 5; allowed is a table for points"),
        ({"seed": -1}, r"load\.seed: given -1; allowed is 0 to 2147483647"),
    ],
)
def test_what_is_refused_is_named_once_by_its_path_with_its_range(values, said):
    with pytest.raises(InputError, match=f"^{said}"):
        Load(**values)
