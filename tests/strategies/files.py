"""Valid files with one to four things changed: text that is nearly right, and text that is nothing."""

import copy
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parents[2]
UNITS = (
    "mm", "m", "km", "µm", "in", "deg", "rad", "kg", "g", "t", "N", "kN", "N/m", "N m/rad", "Pa", "MPa",
    "GPa",
    "bar", "kg m^2", "kg/m^3", "1/min", "rpm", "Hz", "rad/s", "s", "K", "degC", "kW", "mm^2", "1/K", "%",
    "",
    "mm mm", "furlong", "m^", "/", "µ", "N m s/rad", "kg m^99999999", "mm/0",
)  # fmt: skip
NUMBERS = (
    "0", "-0.0", "1", "-1", "3", "0.5", "1e-300", "5e-324", "1e300", "1.7e308", "1e999", "-1e308", "nan",
    "inf",
    "-inf", "1e-12", "1e12", "123456789", "9223372036854775807", "9" * 400, "1_000", "1,5", "0x10", "1e",
    "--1",
    "١٢", "½", "",
)  # fmt: skip
WORDS = (
    "", " ", "x", "auto", "fe", "none", "None", "true", "../../etc/passwd", "/dev/null", "/", ".",
    "no_such.csv",
    "con\u0000", "a" * 500, "кривошип", "\u202e", "[bold]", "%s%n", "{0}", "${HOME}", "'; drop table",
    "🙂", "-1",
    "trapezium", "rigid", "torsional", "axial", "pinned",
)  # fmt: skip
# What stands where one value should.
VALUES = (
    "true", "[]", "[[]]", "{}", "''", "1979-05-27T07:32:00Z", "[1, 2, 3]", "['a', 1]", "{ value = {} }",
    "{ value = 1, source = 'x', assumed = 'y' }", "{ value = '170 mm', kind = 2 }", "[" * 60 + "]" * 60,
    "\"\"\"\na\"\"\"",
    "[{}, {}]", "nan", "inf", "-inf", "1e400", "1" * 5000,
)  # fmt: skip
_LINE = re.compile(r"^(\s*[\w.-]+\s*=\s*)(.*)$")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_QUANTITY = re.compile(r'"([-+]?\d[\d.eE+-]*) ?([^"]*)"')
ENDS = ("\ufeff", "\x00", "\x1b[31m", "é", "\r", "\u2028", "[[", "]", '"""', "=", "#")

positions = st.floats(0.0, 1.0, exclude_max=True)
# Powers of ten that keep a value among those that can be, and ones that do not.
factors = st.one_of(
    st.floats(0.3, 3.0),
    st.integers(-12, 12).map(lambda power: 10.0**power),
    st.sampled_from([-1.0, 0.0, 1e150, 1e-150]),
)


def _at(items: list[Any], place: float) -> int:
    return int(place * len(items))


@st.composite
def quantities(draw: st.DrawFn) -> str:
    """Draw a number with a unit, both of any kind."""
    return f'"{draw(st.sampled_from(NUMBERS))} {draw(st.sampled_from(UNITS))}"'


def _scaled(match: re.Match[str], factor: float) -> str:
    try:
        return f"{float(match[0]) * factor:.12g}"
    except OverflowError:
        return "1e308"


def _scale_number(line: str, place: float, factor: float) -> str:
    """Multiply one of the numbers of a line; what stands for infinity is no number of TOML."""
    found = list(_NUMBER.finditer(line))
    if not found:
        return line
    one = found[_at(found, place)]
    return line[: one.start()] + _scaled(one, factor) + line[one.end() :]


@st.composite
def _changed_line(draw: st.DrawFn, line: str) -> str:
    """Change what one line says."""
    match = _LINE.match(line)
    kind = draw(
        st.sampled_from(
            ("scale", "scale", "scale", "quantity", "value", "word", "unit", "name", "cut")
        )
    )
    if kind == "scale" or match is None:
        return _scale_number(line, draw(positions), draw(factors))
    head, value = match.groups()
    if kind == "quantity":
        return head + draw(quantities())
    if kind == "value":
        return head + draw(st.sampled_from(VALUES))
    if kind == "word":
        return head + json.dumps(draw(st.sampled_from(WORDS)), ensure_ascii=False)
    if kind == "unit":
        unit = draw(st.sampled_from(UNITS))
        return head + _QUANTITY.sub(lambda one: f'"{one[1]} {unit}"', value, count=1)
    if kind == "name":
        return (
            draw(st.sampled_from(("x", "inertia", "length", "name", "value", '""', "a.b.c")))
            + " = "
            + value
        )
    return line[: _at(list(line), draw(positions))]


@st.composite
def changed_texts(draw: st.DrawFn, texts: tuple[str, ...]) -> str:
    """Draw one of some texts, and change it in one to four ways."""
    lines = draw(st.sampled_from(texts)).split("\n")
    full = [
        number
        for number, line in enumerate(lines)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    for _ in range(draw(st.integers(1, 4))):
        place = full[_at(full, draw(positions))]
        if place >= len(lines):
            continue
        kind = draw(
            st.sampled_from(
                ("line", "line", "line", "line", "delete", "twice", "swap", "insert", "block")
            )
        )
        if kind == "line":
            lines[place] = draw(_changed_line(lines[place]))
        elif kind == "delete":
            del lines[place]
        elif kind == "twice":
            lines.insert(place, lines[place])
        elif kind == "swap":
            other = full[_at(full, draw(positions))]
            if other < len(lines):
                lines[place], lines[other] = lines[other], lines[place]
        elif kind == "insert":
            lines.insert(place, draw(st.one_of(st.sampled_from(VALUES), st.text(max_size=30))))
        else:  # some lines are gone, or stand twice
            end = place + draw(st.integers(1, 12))
            lines[place:end] = lines[place:end] * draw(st.sampled_from((0, 2)))
    return "\n".join(lines)


@st.composite
def as_bytes(draw: st.DrawFn, texts: st.SearchStrategy[str]) -> bytes:
    """Write a text as files are written, well or badly."""
    content = draw(texts).encode("utf-8", "surrogatepass")
    kind = draw(st.integers(0, 29))
    if kind == 0:
        return b"\xef\xbb\xbf" + content.replace(b"\n", b"\r\n")
    if kind == 1:
        return content.replace(b"\n", b"\r")
    if kind == 2:
        return content.decode("utf-8", "replace").encode("utf-16")
    if kind == 3:
        return draw(st.binary(max_size=300))
    if kind in (4, 5):
        place = int(draw(positions) * (len(content) + 1))
        return (
            content[:place]
            + draw(st.binary(min_size=1, max_size=4))
            + content[place + draw(st.integers(0, 3)) :]
        )
    if kind == 6:
        return content[: int(draw(positions) * len(content))]
    if kind == 7:
        return content * draw(st.integers(2, 3))
    if kind == 8:
        place = int(draw(positions) * (len(content) + 1))
        return (
            content[:place]
            + draw(st.sampled_from(ENDS)).encode() * draw(st.sampled_from((1, 3, 5000)))
            + content[place:]
        )
    return content


@cache
def texts_of(*patterns: str) -> tuple[str, ...]:
    """Read the files of the project of some patterns."""
    return tuple(
        path.read_text(encoding="utf-8")
        for pattern in patterns
        for path in sorted(ROOT.glob(pattern))
    )


# What may stand in the place of a value of JSON.
JSON_VALUES: tuple[Any, ...] = (
    None, True, 0, -1, 1.5, 1e308, -1e-300, 10**30, float("nan"), float("inf"), "", "x", "170 mm",
    "1e999 mm", "\x00",
    [], {}, [1.0, "a"], [[[]]], {"value": 1}, [0.0] * 3, [1e300] * 20, "a" * 500,
)  # fmt: skip


def places(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """List the paths to all values within JSON content."""
    inner: Any = ()
    if isinstance(content, dict):
        inner = content.items()
    elif isinstance(content, list):
        inner = enumerate(content)
    return [path, *(one for key, value in inner for one in places(value, (*path, key)))]


@st.composite
def changed_json(draw: st.DrawFn, content: Any) -> Any:
    """Change JSON content in one to three places: another value, one less, another key."""
    content = json.loads(json.dumps(content))
    for _ in range(draw(st.integers(1, 3))):
        paths = [path for path in places(content) if path]
        if not paths:
            break
        path = paths[_at(paths, draw(positions))]
        holder = content
        for key in path[:-1]:
            holder = holder[key]
        kind = draw(st.sampled_from(("value", "value", "scale", "scale", "delete", "key", "twice")))
        value = holder[path[-1]]
        if kind == "delete":
            del holder[path[-1]]
        elif kind == "scale" and isinstance(value, int | float) and not isinstance(value, bool):
            holder[path[-1]] = value * draw(factors)
        elif kind == "key" and isinstance(holder, dict):
            holder[draw(st.sampled_from(WORDS))] = value
        elif kind == "twice" and isinstance(value, list):
            holder[path[-1]] = value * 2
        else:
            holder[path[-1]] = copy.deepcopy(draw(st.sampled_from(JSON_VALUES)))
    return content


def json_texts(content: Any) -> st.SearchStrategy[str]:
    """Draw the texts of changed content, and changed texts of it."""
    return st.one_of(
        changed_json(content).map(json.dumps), changed_texts((json.dumps(content, indent=1),))
    )
