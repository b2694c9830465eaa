"""What counts as a number, what fields accept, and that messages stay short."""

import math
import re

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
from geometry.throw import CrankThrow


def sentence(call):
    """Return the message of the InputError that `call` raises, checked to be one sentence."""
    with pytest.raises(InputError) as caught:
        call()
    message = str(caught.value)
    assert message.endswith(".")
    assert "\n" not in message
    assert not re.search(r"\.\s+[A-Z]", message)
    assert "pydantic" not in message
    return message


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


def test_bare_number_in_a_file(dimensions):
    message = sentence(lambda: CrankThrow.from_text({**as_text(dimensions), "crank_radius": 170}))
    assert message.startswith("throw.crank_radius: ")
    assert '"170 mm"' in message


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pin_length": 0.020, "fillet_radius": 0.010}, "2.2 mm to 9 mm.*crankpin of 20 mm is too"),
        ({"main_journal_length": 0.020}, "0, or 2.2 mm to 9 mm.*main journal of 20 mm is too"),
        ({"web_width": 0.230}, "given 12 mm; allowed is 0, or 2.2 mm to 5 mm.*web of 230 mm is"),
        ({"web_width": 0.221}, r"allowed is only 0 \(sharp corners\)"),
        ({"fillet_radius": 0.001}, "given 1 mm; allowed is 0, or 2.2 mm to 40 mm"),
    ],
)
def test_fillets_that_do_not_fit(dimensions, changes, words):
    message = sentence(lambda: CrankThrow(**dimensions | changes))
    assert message.startswith("throw.fillet_radius: given ")
    assert re.search(words, message)


@pytest.mark.parametrize("name", ["pin_diameter", "main_journal_diameter"])
def test_journal_outside_the_web(dimensions, name):
    message = sentence(lambda: CrankThrow(**{**dimensions, name: 0.310}))
    assert message.startswith(f"throw.{name}: given 310 mm; allowed is at most 300 mm")
    assert "outside the web" in message


@pytest.mark.parametrize("name", ["pin_diameter", "main_journal_diameter"])
def test_journal_flush_with_the_web(dimensions, name):
    sharp = {**dimensions, "fillet_radius": 0.0}
    message = sentence(lambda: CrankThrow(**{**sharp, name: sharp["web_width"]}))
    assert message.startswith(f"throw.{name}: given 300 mm; allowed is at most 299.7 mm")
    assert CrankThrow(**{**sharp, name: 0.2997}).web_width == 0.3


@pytest.mark.parametrize("name", ["web_width", "crank_radius", "pin_length", "fillet_radius"])
def test_negative_size(dimensions, name):
    message = sentence(lambda: CrankThrow(**{**dimensions, name: -0.285}))
    assert message.startswith(f"throw.{name}: given -285 mm; allowed is ")
    assert re.search(r"allowed is [\d.]+ mm to \d+ mm", message)


def test_negative_size_in_a_file(dimensions):
    message = sentence(
        lambda: CrankThrow.from_text({**as_text(dimensions), "web_width": "-285 mm"})
    )
    assert message.startswith("throw.web_width: given -285 mm; allowed is 1 mm to 4000 mm")


@pytest.mark.parametrize("value", [float("nan"), float("inf"), None, [0.3]])
def test_no_number(dimensions, value):
    message = sentence(lambda: CrankThrow(**{**dimensions, "web_width": value}))
    assert message.startswith("throw.web_width: given ")
    assert "1 mm to 4000 mm" in message


@pytest.mark.parametrize("value", ["300 mm", "0.3", "wide", True])
def test_text_in_a_program_is_refused_with_the_unit_to_use(dimensions, value):
    message = sentence(lambda: CrankThrow(**{**dimensions, "web_width": value}))
    assert message.startswith(f"throw.web_width: given {value!r}; allowed is a number in m")


def test_missing_field(dimensions):
    del (incomplete := dict(dimensions))["web_width"]
    for call in (
        lambda: CrankThrow(**incomplete),
        lambda: CrankThrow.from_text(as_text(incomplete)),
    ):
        message = sentence(call)
        assert message.startswith("throw.web_width: missing; ")
        assert "1 mm to 4000 mm" in message


def test_unknown_field_with_a_suggestion(dimensions):
    for call in (
        lambda: CrankThrow(**dimensions, web_widht=0.3),
        lambda: CrankThrow.from_text({**as_text(dimensions), "web_widht": "300 mm"}),
    ):
        message = sentence(call)
        assert message.startswith("throw.web_widht: unknown field; did you mean web_width?")
        assert all(name in message for name in dimensions)


def test_unknown_field_without_a_likeness(dimensions):
    message = sentence(lambda: CrankThrow(**dimensions, colour=0.3))
    assert message.startswith("throw.colour: unknown field; allowed are crank_radius, ")


@pytest.mark.parametrize("name", ["web_thickness", "pin_length", "main_journal_length"])
def test_part_too_thin_to_mesh(dimensions, name):
    message = sentence(lambda: CrankThrow(**{**dimensions, name: 0.004, "fillet_radius": 0.0}))
    assert message.startswith(f"throw.{name}: given 4 mm; allowed is 8.8 mm or more")


def test_the_section_is_the_files(dimensions):
    message = sentence(
        lambda: CrankThrow.from_text(
            {**as_text(dimensions), "fillet_radius": "90 mm"}, section="throws.aft"
        )
    )
    assert message.startswith("throws.aft.fillet_radius: given 90 mm; ")


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
    with pytest.raises(InputError, match=r"^pin: given 1; allowed is 0, because the throw has"):
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
