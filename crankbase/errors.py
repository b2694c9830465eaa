"""Errors for users: one clear sentence for each wrong input."""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from crankbase.sentences import finished, joined, lines

# Of what was given a message quotes at most so many characters, its beginning and its end.
LONGEST_QUOTE = 80
# A whole message is longer only by its list of what is allowed.
LONGEST_MESSAGE = 4000
# Of the errors of an input so many are told, and how many more there are.
MOST_TOLD = 20
CUT = " ... "
# Where a quoted text or a list may begin; an apostrophe within a word begins none.
_GIVEN = re.compile(
    r"(?<!\w)(?:'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\")|\bgiven (\w*[\[({])", re.DOTALL
)
_NESTED = re.compile(r"'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\"|[\[({]|[\])}]", re.DOTALL)
# The parts of a path are cut each for itself: what is told of a file must lead to it.
_WORD = re.compile(rf"[^\s/]{{{LONGEST_QUOTE + 1},}}")

# Of a terminal (C0 and C1) and of the direction of writing; halves of characters stand for foreign bytes.
_CONTROL = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def shortened(text: str, most: int = LONGEST_QUOTE) -> str:
    """Return a text of at most so many characters: its beginning and its end, if it is longer.

    Examples
    --------
    >>> shortened("given " * 100, 30)
    'given given given ... n given '
    """
    if len(text) <= most:
        return text
    end = (most - len(CUT)) // 3
    return text[: most - len(CUT) - end] + CUT + text[-end:]


def visible(text: str) -> str:
    r"""Return a text with its control characters written as escapes; lines and tabs stay.

    Also shown are characters that change the direction of what follows, and what is no character.

    Examples
    --------
    >>> print(visible("a\x1b]0;title\x07"))
    a\x1b]0;title\x07
    """
    return _CONTROL.sub(lambda control: control[0].encode("unicode_escape").decode(), text)


def quoted(value: object) -> str:
    """Write a value as Python does, shortened for a message; a number of any size can be written."""
    try:
        return shortened(repr(value))
    except ValueError:  # Python writes no integers of thousands of digits
        return "a number of thousands of digits"


def named(name: str) -> str:
    """Write the name of a field as it is, between quotes if nothing or a space is at either end."""
    return name if name and name.strip() == name else repr(name)


def with_short_quotes(message: str) -> str:
    """Return a message in which every quoted text, list and word is shortened; else it keeps its values."""
    message = finished(message)
    if len(message) <= LONGEST_QUOTE:
        return message
    pieces, place = [], 0
    while (quote := _GIVEN.search(message, place)) is not None:
        begin, end = quote.span()
        if quote[1]:
            begin, end = quote.start(1), _closing(message, quote.end(1))
        pieces += [message[place:begin], shortened(message[begin:end])]
        place = end
    pieces.append(message[place:])
    words = _WORD.sub(lambda word: shortened(word[0]), "".join(pieces))
    short = shortened(words, LONGEST_MESSAGE)
    return message if short == message else short


def _closing(message: str, place: int) -> int:
    """Return the end of the list that begins before `place`."""
    depth = 1
    for bracket in _NESTED.finditer(message, place):
        depth += {"[": 1, "(": 1, "{": 1, "]": -1, ")": -1, "}": -1}.get(bracket[0], 0)
        if depth == 0:
            return bracket.end()
    return place


def first_sentences(message: str) -> list[str]:
    """Return the first errors of a message, and how many more there are: a person mends a few at a time."""
    sentences = lines(message)
    if len(sentences) <= MOST_TOLD + 1:
        return sentences
    return [*sentences[:MOST_TOLD], f"{len(sentences) - MOST_TOLD} more errors are not shown."]


class InputError(ValueError):
    """Input that cannot be used; the message names the field, the value, the allowed range and why.

    Parameters
    ----------
    message : str
        Quoted input is cut to 80 characters; values are written by `crankbase.sentences.amount`.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(finished(joined("\n", map(with_short_quotes, lines(message)))))

    def __str__(self) -> str:
        """Return the message, a `crankbase.sentences.Sentence` if it has values."""
        message: str = self.args[0]
        return message

    @property
    def sentences(self) -> list[str]:
        """The errors, one sentence each: a file may have several errors, one on each line."""
        return lines(str(self))

    @classmethod
    def of_all(cls, errors: Iterable["InputError"]) -> "InputError":
        """Return one error with the sentences of all, each once."""
        return cls(
            joined("\n", dict.fromkeys(line for error in errors for line in error.sentences))
        )


class NotEnoughMemoryError(InputError):
    """Work that needs more memory than is free; the message has both figures."""


class InputErrors:
    """Errors of parts of an input that are read independently, reported together."""

    def __init__(self) -> None:
        self.errors: list[InputError] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Read one part in this context: its error is reported together with those of the others."""
        try:
            yield
        except InputError as error:
            self.errors.append(error)

    def tell(self) -> None:
        """Raise the collected errors, if any.

        Raises
        ------
        InputError
            With each sentence once.
        """
        if self.errors:
            raise InputError.of_all(self.errors) from None


class MissingLibraryError(ImportError):
    """A system library or Python package is missing; the message names the package to install."""


class MeshError(RuntimeError):
    """A throw could not be meshed, although its dimensions are valid; the message states why."""


class SolveError(RuntimeError):
    """Equations could not be solved, or a result fails a self-check; the message has the figure."""


class RenderError(RuntimeError):
    """A picture could not be rendered, although all requirements are met; the message states why."""
