"""Messages stay short, however long what was given is."""

import pytest

from crankbase.errors import LONGEST_MESSAGE, InputError, quoted

LONG = 10**6


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
