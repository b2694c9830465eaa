"""Sentences that keep their values."""

import copy
import json
import math
import pickle

import pytest

from crankbase.errors import InputError
from crankbase.quantity import UNITS
from crankbase.results import Result, result
from crankbase.sentences import (
    END,
    START,
    Amount,
    Sentence,
    amount,
    angle,
    apart,
    capital,
    finished,
    in_si,
    joined,
    kept,
    listed,
    written,
)
from crankbase.table import SI, parse_output_units

INCHES = parse_output_units("in, lbf, ksi")
WIDTH = finished(f"width of {amount(0.25, 'm')}")


def in_inches(text):
    return INCHES.written(text)


@pytest.mark.parametrize(
    ("value", "unit", "how", "shown", "three"),
    [
        (0.27048, "m", {"digits": 5}, "270.48 mm", "270 mm"),
        (1056.0 / UNITS["mm"][1] * 1e-6, "m", {}, "1056 mm", "1056 mm"),
        (0.5522, "kg", {"digits": 4}, "0.5522 kg", "0.552 kg"),
        (1.2813e-9, "m/N", {"digits": 5}, "1.2813e-9 m/N", "1.28e-9 m/N"),
        (30730.0, "N m", {}, "30.73 kN m", "30.7 kN m"),
        (123.46, "Hz", {"decimals": 1}, "123.5 Hz", "123 Hz"),
        (0.04, "Hz", {"decimals": 1, "signed": True}, "+0.0 Hz", "+0.0 Hz"),
        (-1234.0, "N", {"shown": "kN"}, "-1.234 kN", "-1.23 kN"),
        (12.0, "kg m^2", {"digits": 3, "zeros": True}, "12.0 kg m^2", "12.0 kg m^2"),
        (0.12345, "m", {"exact": True}, "123.45 mm", "123.45 mm"),
        (3.0, "", {}, "3", "3"),
    ],
)
def test_a_value_is_written_with_its_digits_or_three(value, unit, how, shown, three):
    text = finished(f"It is {amount(value, unit, **how)}.")
    assert text == f"It is {shown}."
    assert SI.written(text, 3) == f"It is {three}."
    # It is so of a file, too.
    pieces = json.loads(json.dumps(Sentence(kept(text)).record()))
    assert SI.written(Sentence.from_record(pieces), 3) == f"It is {three}."


def test_two_values_are_told_apart_in_every_unit_and_with_few_digits():
    for text in map(" of ".join, (apart(22.28e6, 22.27e6, "Pa"), apart(22.27e6, 22.28e6, "Pa", 4))):
        for shown in (finished(text), SI.written(text, 3), INCHES.written(text, 3)):
            reached, permitted = shown.split(" of ")
            assert reached != permitted
    assert finished(" of ".join(apart(5.0, 5.0, "N"))) == "5 N of 5 N"
    assert finished(" of ".join(apart(math.inf, 5.0, "N"))) == "unbounded of 5 N"


def test_what_has_no_bounds_has_no_unit():
    assert finished(amount(math.inf, "Pa")) == "unbounded"


@pytest.mark.parametrize(
    "keep",
    [
        copy.copy,
        copy.deepcopy,
        lambda text: pickle.loads(pickle.dumps(text)),
        lambda text: text + "",
        lambda text: "" + text,
        lambda text: (text + ".").removesuffix("."),
        lambda text: (text + ".").rstrip("."),
        lambda text: text[0] + text[1:],
        lambda text: finished(f"{kept(text)}"),
        lambda text: finished(joined(" ", [text])),
        lambda text: finished(capital(text)[:1].lower() + capital(text)[1:]),
    ],
)
def test_values_are_kept(keep):
    text = keep(WIDTH)
    assert text == "width of 250 mm"
    assert in_inches(text) == "width of 9.84 in"


def test_what_is_cut_within_a_value_is_cut_as_in_any_text():
    frequency = finished(amount(4.22, "Hz"))
    assert frequency.removesuffix(" Hz") == "4.22"
    assert frequency.rstrip("zH") == "4.22 "


def test_a_person_s_text_is_never_touched():
    source = "the 500 mm bore series; doi 10.24143/2073-1574-2021-4-75-83, 12.3456 MPa"
    assert in_inches(source) == source
    assert written(source, lambda value: value.text(None, 3)) == source
    assert in_inches(f"{amount(0.25, 'm')} ({source})") == f"9.84 in ({source})"


def test_a_list_has_one_unit_and_an_angle_is_given_in_degrees():
    assert finished(listed((0.1, 0.2), "m", between=" to ")) == "100 to 200 mm"
    assert finished(angle(120.0)) == "120 deg"
    assert Amount(0.1, "m").text(parse_output_units("m")) == "0.1 m"


@result("text")
class Told(Result):
    """What a test tells."""

    text: str
    texts: tuple[str, ...]
    by_name: dict[str, str]

    @property
    def longer(self) -> str:
        """More of it."""
        return f"a {kept(self.text)}"


def test_results_keep_values_in_python_and_in_json():
    mark = f"width of {amount(0.25, 'm')}"
    told = Told(mark, (mark, "no value"), {"one": mark})
    read = Told.from_json(told.to_json())
    for each in (told, read):
        assert (each.text, each.longer) == ("width of 250 mm", "a width of 250 mm")
        for text in (each.text, each.texts[0], each.by_name["one"], each.longer.removeprefix("a ")):
            assert text == "width of 250 mm"
        for text in (each.text, each.texts[0], each.by_name["one"], each.longer):
            assert in_inches(text).endswith("9.84 in")
    record = told.to_record()
    assert record["text"] == "width of 250 mm"
    assert record["said"]["text"] == ["width of ", {"value": 0.25, "unit": "m"}]
    # Results of an earlier release have the texts alone.
    assert Told.from_record({**record, "said": {}}).text == "width of 250 mm"


def test_an_error_keeps_its_values():
    error = InputError.of_all(
        [
            InputError(f"a: given {amount(0.3, 'm')}; allowed is less."),
            InputError("b: " + str(InputError(f"given {in_si(0.05, 'm')}."))),
        ]
    )
    inches = parse_output_units("in")
    for known in (error, pickle.loads(pickle.dumps(error)), InputError(str(error))):
        assert f"{known}" == "a: given 300 mm; allowed is less.\nb: given 0.05 m."
        assert [inches.written(line, full=True) for line in known.sentences] == [
            "a: given 11.811 in; allowed is less.",
            "b: given 1.9685 in.",
        ]


def test_an_error_whose_quote_is_cut_loses_its_values_alone():
    error = InputError(f"a: given '{'x' * 500}' of {amount(0.3, 'm')}.")
    assert str(error).endswith("' of 300 mm.")
    assert len(str(error)) < 120


@pytest.mark.parametrize("mark", ["", "x", "1|m|digits=99999", "1|m|shown=ell", "1|m|no=1", "1m"])
def test_letters_of_marks_in_a_text_of_a_person_are_no_value(mark):
    text = f"{START}{mark}{END}"
    assert str(InputError(text)) == text
    assert parse_output_units("in").written(text) == text
