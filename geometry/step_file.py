"""The text of STEP files: the names of faces, the surfaces they lie on, and the unit of length."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from crankbase.errors import InputError

Point = tuple[float, float, float]
PLANE = "PLANE"
CYLINDER = "CYLINDRICAL_SURFACE"
# Names that programs write where there is none.
NO_NAME = ("", "none", "$")
SOLIDS = ("MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP")
FACES = ("ADVANCED_FACE", "FACE_SURFACE")
# What leads from a face to its corners; curves and surfaces do not.
BOUNDARIES = (
    "FACE_OUTER_BOUND",
    "FACE_BOUND",
    "EDGE_LOOP",
    "VERTEX_LOOP",
    "ORIENTED_EDGE",
    "EDGE_CURVE",
)
PREFIXES = {
    "$": 1.0,
    ".KILO.": 1e3,
    ".DECI.": 1e-1,
    ".CENTI.": 1e-2,
    ".MILLI.": 1e-3,
    ".MICRO.": 1e-6,
}
STRING = r"'(?:[^']|'')*'"
STATEMENT_TOKEN = re.compile(rf"{STRING}|/\*.*?\*/|;", re.DOTALL)
RECORD = re.compile(r"#(\d+)\s*=\s*(.*)", re.DOTALL)
KEYWORD = re.compile(r"\(?\s*([A-Z]\w*)", re.IGNORECASE)
VALUE_TOKEN = re.compile(
    rf"{STRING}|\"[^\"]*\"|#\d+|\.\w+\.|[-+]?\d[\d.]*(?:E[-+]?\d+)?|!?[A-Z]\w*|[(),$*]",
    re.IGNORECASE,
)
DIRECTIVE = re.compile(
    r"\\X2\\(?P<two>(?:[0-9A-F]{4})*)\\X0\\|\\X4\\(?P<four>(?:[0-9A-F]{8})*)\\X0\\"
    r"|\\X\\(?P<one>[0-9A-F]{2})|\\P(?P<page>[A-I])\\|\\S\\(?P<upper>.)|(?P<back>\\\\)",
    re.IGNORECASE | re.DOTALL,
)


@dataclass(frozen=True)
class StepFace:
    """A named face of a STEP file.

    Attributes
    ----------
    kind : str
        Type of its surface as STEP calls it, such as PLANE.
    point, axis : (x, y, z)
        Of a plane a point and the normal, of a cylinder a point on the axis and its direction [m];
        zeros for other surfaces.
    radius : float
        Of a cylinder [m], 0 for others.
    corners : tuple of (x, y, z)
        Ends of its edges [m].
    """

    name: str
    kind: str
    point: Point
    axis: Point
    radius: float
    corners: tuple[Point, ...]


@dataclass(frozen=True)
class StepFile:
    """Content of the text.

    Attributes
    ----------
    unit : float
        Unit of length [m].
    faces : tuple of StepFace
        Faces with a name.
    """

    unit: float
    faces: tuple[StepFace, ...]


class Reference(int):
    """The number of an entity that another one refers to."""


def read_step(content: bytes, source: str) -> StepFile:
    """Read the names of faces and the unit.

    Parameters
    ----------
    content : bytes
        The file.
    source : str
        Its name in errors.

    Raises
    ------
    InputError
        If it is not a STEP file, has no solid or no known unit, or its faces cannot be understood.
    """
    try:
        text = content.decode("utf-8")  # the newest edition
    except UnicodeDecodeError:  # older files with bytes beyond ASCII, mostly
        text = content.decode("latin-1")
    if not text.lstrip("\ufeff \t\r\n").startswith("ISO-10303-21"):
        raise InputError(
            f"{source}: given a file that does not begin with ISO-10303-21; allowed is a STEP file."
        )
    entities = _Entities(text)
    if not any(entities.of_kind(*SOLIDS)):
        raise InputError(
            f"{source}: given a STEP file without a solid; allowed is one with one closed solid, not "
            "only surfaces, curves or facets."
        )
    try:
        units: dict[float, None] = {}
        for number in entities.with_text("GLOBAL_UNIT_ASSIGNED_CONTEXT"):
            for place in entities.read(number)["GLOBAL_UNIT_ASSIGNED_CONTEXT"][0]:
                if "LENGTH_UNIT" in entities.read(place):
                    units[_unit(entities, place, source)] = None
        if len(units) != 1:
            how_many = "no unit" if not units else f"{len(units)} different units"
            raise InputError(
                f"{source}: given a STEP file with {how_many} of length; allowed is a whole file with one "
                "unit."
            )
        (unit,) = units
        faces = []
        for number in entities.of_kind(*FACES):
            name, bounds, surface_number, _ = next(iter(entities.read(number).values()))
            name = str(name).strip()
            if name.lower() not in NO_NAME:
                kind, point, axis, radius = _surface(entities, surface_number, unit)
                corners = tuple(dict.fromkeys(_corners(entities, bounds, unit)))
                faces.append(StepFace(name, kind, point, axis, radius, corners))
        return StepFile(unit, tuple(faces))
    except (LookupError, TypeError, ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{source}: given a STEP file whose entity #{entities.last_read} cannot be understood; "
            "allowed is one by ISO 10303-21."
        ) from None


def decode_string(text: str) -> str:
    r"""Decode the inside of a STEP string: '' and the \X2\, \X4\, \X\, \S\ and \P\ directives."""
    page = "A"

    def replacement(escape: re.Match[str]) -> str:
        nonlocal page
        if escape["page"] is not None:
            page = escape["page"].upper()
            return ""
        if escape["two"] is not None:
            return bytes.fromhex(escape["two"]).decode("utf-16-be", "replace")
        if escape["four"] is not None:
            return bytes.fromhex(escape["four"]).decode("utf-32-be", "replace")
        if escape["one"] is not None:
            return chr(int(escape["one"], 16))
        if escape["upper"] is not None:
            code = (ord(escape["upper"]) + 128) % 256
            return bytes([code]).decode(f"iso8859_{ord(page) - ord('A') + 1}", "replace")
        return "\\"

    return DIRECTIVE.sub(replacement, text.replace("''", "'"))


class _Entities:
    """The entities of a file by number, understood when requested."""

    def __init__(self, text: str) -> None:
        self._records: dict[int, str] = {}
        self.last_read = 0
        pieces: list[str] = []
        begin = 0
        # Statements end at semicolons outside strings; comments are left out.
        for token in STATEMENT_TOKEN.finditer(text):
            if token[0].startswith("'"):
                continue
            pieces.append(text[begin : token.start()])
            begin = token.end()
            if token[0] == ";":
                record_match = RECORD.match("".join(pieces).strip())
                if record_match:
                    self._records[int(record_match[1])] = record_match[2]
                pieces = []

    def of_kind(self, *keywords: str) -> Iterator[int]:
        """Numbers of the entities of these types; of a compound one the first type counts."""
        for number, record in self._records.items():
            keyword = KEYWORD.match(record)
            if keyword and keyword[1].upper() in keywords:
                yield number

    def with_text(self, text: str) -> Iterator[int]:
        """Numbers of the entities that have this text somewhere."""
        return (number for number, record in self._records.items() if text in record)

    def read(self, number: int) -> dict[str, list[Any]]:
        """Types and their arguments; several types if the entity is a compound one."""
        self.last_read = number
        tokens = VALUE_TOKEN.findall(self._records[number])
        values, _ = _values(tokens, 0)
        if len(values) == 1 and isinstance(values[0], list):
            values = values[0]
        return {value[0]: value[1] for value in values if isinstance(value, tuple)}


def _values(tokens: list[str], place: int) -> tuple[list[Any], int]:
    """Read values up to the closing bracket; a typed value or an entity is (keyword, arguments)."""
    values: list[Any] = []
    while place < len(tokens):
        token = tokens[place]
        place += 1
        if token == ")":
            break
        if token == "(":
            inner, place = _values(tokens, place)
            if values and isinstance(values[-1], _Keyword):
                values[-1] = (str(values[-1]), inner)
            else:
                values.append(inner)
        elif token[0] == "'":
            # Lines may break anywhere, also within a string, where the break means nothing.
            values.append(decode_string(re.sub(r"[\r\n]", "", token[1:-1])))
        elif token[0] == "#":
            values.append(Reference(token[1:]))
        elif token[0].isdigit() or token[0] in "+-":
            values.append(float(token))
        elif token[0].isalpha() or token[0] == "!":
            values.append(_Keyword(token.upper()))
        elif token != ",":
            values.append(token.upper())
    return values, place


class _Keyword(str):
    """A type's name, whose arguments follow."""


def _unit(entities: _Entities, number: int, source: str) -> float:
    unit = entities.read(number)
    unit_name = ", ".join(unit)
    if "SI_UNIT" in unit:
        size = _meter_part(unit)
        if size is not None:
            return size
        unit_name = " ".join(unit["SI_UNIT"])
    elif "CONVERSION_BASED_UNIT" in unit:
        unit_name, measure_number = unit["CONVERSION_BASED_UNIT"]
        measure = entities.read(measure_number)
        value, base = measure.get("MEASURE_WITH_UNIT") or measure["LENGTH_MEASURE_WITH_UNIT"]
        # As a plain number or as LENGTH_MEASURE(number).
        factor = value[1][0] if isinstance(value, tuple) else value
        size = _meter_part(entities.read(base))
        # The kernel does not follow a unit defined by another one that is defined itself.
        if size is not None and factor > 0.0:
            return float(factor * size)
    raise InputError(
        f"{source}: given a STEP file with the unit of length {unit_name}; allowed are the meter and its "
        "parts, and units that the file defines directly by them, like the inch."
    )


def _meter_part(unit: dict[str, list[Any]]) -> float | None:
    """Size of an SI unit of length [m], None for other units."""
    prefix, name = unit.get("SI_UNIT", ("", ""))
    return PREFIXES.get(prefix) if name == ".METRE." else None


def _surface(entities: _Entities, number: int, unit: float) -> tuple[str, Point, Point, float]:
    surface = entities.read(number)
    kind = next(iter(surface))
    if kind not in (PLANE, CYLINDER):
        return kind, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    _, placement, *radius = surface[kind]
    location, *directions = entities.read(placement)["AXIS2_PLACEMENT_3D"][1:]
    point = _point(entities, location, unit)
    axis = (0.0, 0.0, 1.0)
    if directions and isinstance(directions[0], Reference):
        x, y, z = entities.read(directions[0])["DIRECTION"][1]
        size = (x * x + y * y + z * z) ** 0.5
        axis = (x / size, y / size, z / size)
    return kind, point, axis, unit * radius[0] if radius else 0.0


def _point(entities: _Entities, number: int, unit: float) -> Point:
    x, y, z = entities.read(number)["CARTESIAN_POINT"][1]
    return (unit * x, unit * y, unit * z)


def _corners(entities: _Entities, references: list[Any], unit: float) -> Iterator[Point]:
    """Follow a face's bounds down to the ends of its edges."""
    for reference in references:
        if isinstance(reference, list):
            yield from _corners(entities, reference, unit)
        if not isinstance(reference, Reference):
            continue
        entity = entities.read(reference)
        if "VERTEX_POINT" in entity:
            yield _point(entities, entity["VERTEX_POINT"][1], unit)
        for kind in BOUNDARIES:
            if kind in entity:
                yield from _corners(entities, entity[kind], unit)
