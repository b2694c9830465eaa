"""Errors of a file that is not TOML, explained without knowledge of TOML."""

import re
import tomllib

from crankbase.errors import shortened
from crankbase.units.quantity import SEPARATED_NUMBER, either, readings

# Of a line that is looked at.
LONGEST_LINE = 500
# Where the parser stopped.
AT_LINE = re.compile(r"\(at line (\d+), column \d+\)")
# A number followed by letters, with no quotes about them: "= 9 in", "value = 82,5 mm", "[0 deg, ...".
BARE = re.compile(
    rf"[=\[,]\s*({SEPARATED_NUMBER}\s*(?:1\s*/\s*)?[A-Za-z%°µ][^\s,}}\]#\"']*(?: [A-Za-z][\w^/*]*)*)"
)
# A number with separators, alone. In a list commas stand between numbers.
SEPARATED = re.compile(rf"=\s*({SEPARATED_NUMBER})\s*(?:[,}}]|$)")
NAME = re.compile(r"\s*([\w.-]+|\"[^\"]*\"|'[^']*')\s*=")
HEADER = re.compile(r"\s*\[(?!\[)([^\]]+)\]")
# What is written wrongly, where nothing else is, outside of quotes.
FAULTS = (
    (
        re.compile("[\u201c\u201d\u201e\u2018\u2019\u00ab\u00bb]"),
        "given typographic quotes; write straight ones, \" or '",
    ),
    (
        re.compile(r"^[^\"]*\"[^\"]*$|^[^']*'[^']*$"),
        "given an opening quote without a closing one; write both",
    ),
    (
        re.compile(r"^\s*\[[^\]]*[^\x00-\x7f][^\]]*\]|^[^=\"']*[^\x00-\x7f][^=\"']*="),
        "given a name with other letters than A to Z; write names with A to Z, digits, _ and -",
    ),
    (re.compile(r"^\s*[\w.-]+\s*:"), "given a colon behind a name; write ="),
    (re.compile(r"[;,]\s*$"), "given a comma or a semicolon at its end; leave it out"),
    (
        re.compile(r"=\s*(?!(?:true|false|inf|nan)\b)[A-Za-z][\w .-]*$"),
        "given text without quotes; write it in quotes",
    ),
    (re.compile(r"^\s*\[\[?[^\]=]*$"), "given a section without its closing bracket; write it"),
)
# An apostrophe behind a digit separates thousands.
QUOTED = re.compile(r"\"(?:[^\"\\]|\\.)*\"|(?<!\d)'[^']*'")


def not_toml(text: str, error: Exception) -> str:
    """Describe the error of the parser, and the correct form.

    Parameters
    ----------
    text : str
        Of the file.
    error : Exception
        Of the parser; without a line number in it, its own words are used.

    Returns
    -------
    str
        For example ``line 46, web_width = 9 in: a quantity stands without quotes; write "9 in" ...``.
    """
    if not isinstance(error, tomllib.TOMLDecodeError):
        return "given a number of thousands of digits; allowed are numbers of 64 bits, as TOML has them."
    found = AT_LINE.search(str(error))
    # What is wrong shows at the beginning of a line; patterns would take long over all of a very long one.
    lines = [line[:LONGEST_LINE] for line in text.splitlines()]
    # What is never closed is found at the end of the file, of which no line is told.
    place = int(found[1]) if found else _first_fault(lines)
    if not 1 <= place <= len(lines):
        return f"is not TOML ({error}); allowed is a TOML file."
    line = lines[place - 1]
    shown = f"line {place}, {shortened(line.strip())}:"
    before = _before(lines, place)
    if before is not None:
        return (
            f"{shown} given twice, in line {before} too; allowed is each name once in its section, and each "
            "section once."
        )
    # What stands in quotes already, and remarks, are no bare quantities.
    plain = QUOTED.sub('""', line).partition("#")[0]
    bare = BARE.search(plain)
    if bare is not None:
        given = bare[1].strip()
        if "," in given and not bare[0].startswith("="):
            return (
                f"{shown} given {given} in a list without quotes; write each quantity in quotes, with a "
                "decimal point, because commas separate the values of a list."
            )
        return (
            f"{shown} given {given} without quotes; write a quantity in quotes, "
            f"{either(readings(given) or (given,))}, because it is text with its unit."
        )
    fault = _fault(line)
    if fault is not None:
        return f"{shown} {fault}."
    return f"{shown} is not TOML ({AT_LINE.sub('', str(error)).strip()}); allowed is a TOML file."


def _fault(line: str) -> str | None:
    """Say what is written wrongly in a line, None if nothing is known of it."""
    plain = QUOTED.sub('""', line).partition("#")[0]
    number = SEPARATED.search(plain)
    if number is not None and (meant := readings(number[1])):
        return (
            f"given {number[1]}; write a decimal point and no separators, like {' or '.join(meant)}"
        )
    return next((fault for pattern, fault in FAULTS if pattern.search(plain)), None)


def _first_fault(lines: list[str]) -> int:
    """Return the number of the first line in which something is written wrongly, 0 if there is none."""
    return next((number for number, line in enumerate(lines, start=1) if _fault(line)), 0)


def _before(lines: list[str], place: int) -> int | None:
    """Return the number of an earlier line that gives the same section or name, None if there is none."""
    line = lines[place - 1]
    header = HEADER.match(line)
    given = header or NAME.match(line)
    if given is None:
        return None
    for number in range(place - 1, 0, -1):
        other = lines[number - 1]
        if header is None and other.lstrip().startswith("["):
            return None
        found = given.re.match(other)
        if found is not None and found[1].strip() == given[1].strip():
            return number
    return None
