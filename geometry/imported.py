"""A throw from a STEP file, and the names of its ends and pins."""

import hashlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.calls import ProcessLostError
from crankbase.errors import InputError
from crankbase.input_file import not_a_file
from crankbase.summaries import summarized
from geometry.gmsh_session import IsolatedProcess, shared_process
from geometry.mesh import ThrowMesh, flat_triangles
from geometry.parts import Cylinder, Line, Outline, ThrowParts, WebPlate
from geometry.sizes import SizePlan
from geometry.solid import LEFT_END, PIN, RIGHT_END, Zone

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
    text = _decoded(content)
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
        unit = _file_unit(entities, source)
        return StepFile(unit, tuple(_named_faces(entities, unit)))
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


def _decoded(content: bytes) -> str:
    """The newest edition is in UTF-8; older files with bytes beyond ASCII mostly in Latin-1."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


class _Entities:
    """The entities of a file by number, understood when requested."""

    def __init__(self, text: str) -> None:
        self._records: dict[int, str] = {}
        self.last_read = 0
        for statement in _statements(text):
            record_match = RECORD.match(statement)
            if record_match:
                self._records[int(record_match[1])] = record_match[2]

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


def _statements(text: str) -> Iterator[str]:
    """Split at semicolons outside strings, without comments."""
    pieces: list[str] = []
    begin = 0
    for token in STATEMENT_TOKEN.finditer(text):
        if token[0].startswith("'"):
            continue
        pieces.append(text[begin : token.start()])
        begin = token.end()
        if token[0] == ";":
            yield "".join(pieces).strip()
            pieces = []


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
        elif token != ",":
            values.append(_value(token))
    return values, place


class _Keyword(str):
    """A type's name, whose arguments follow."""


def _value(token: str) -> Any:
    first = token[0]
    if first == "'":
        # Lines may break anywhere, also within a string, where the break means nothing.
        return decode_string(re.sub(r"[\r\n]", "", token[1:-1]))
    if first == "#":
        return Reference(token[1:])
    if first.isdigit() or first in "+-":
        return float(token)
    if first.isalpha() or first == "!":
        return _Keyword(token.upper())
    return token.upper()


def _file_unit(entities: _Entities, source: str) -> float:
    """The unit of length of the file's shapes [m]."""
    units: dict[float, None] = {}
    for number in entities.with_text("GLOBAL_UNIT_ASSIGNED_CONTEXT"):
        for unit in entities.read(number)["GLOBAL_UNIT_ASSIGNED_CONTEXT"][0]:
            if "LENGTH_UNIT" in entities.read(unit):
                units[_unit(entities, unit, source)] = None
    if len(units) != 1:
        units_text = "no unit of length" if not units else f"{len(units)} different units of length"
        raise InputError(f"{source}: given a STEP file with {units_text}; allowed is one with one.")
    return next(iter(units))


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


def _named_faces(entities: _Entities, unit: float) -> Iterator[StepFace]:
    for number in entities.of_kind(*FACES):
        name, bounds, surface_number, _ = next(iter(entities.read(number).values()))
        name = str(name).strip()
        if name.lower() in NO_NAME:
            continue
        kind, point, axis, radius = _surface(entities, surface_number, unit)
        corners = tuple(dict.fromkeys(_corners(entities, bounds, unit)))
        yield StepFace(name, kind, point, axis, radius, corners)


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


Array = NDArray[np.float64]
# Seconds for reading a part; one of a hundred faces takes a fifth of a second.
TIME_LIMIT = 300.0
MOST_NAMES = 20


@dataclass(frozen=True)
class ImportedPin:
    """A crankpin of an imported throw.

    Attributes
    ----------
    name : str
        "pin", "pin 2" ... from the left.
    axis : (x, y)
        In the throw frame [m].
    radius : float
        [m]
    start, end : float
        Extent along z, fillets included [m].
    """

    name: str
    axis: tuple[float, float]
    radius: float
    start: float
    end: float


@summarized("path", "length [m]", "pins", "volume [m^3]", "remarks")
@dataclass(frozen=True)
class ImportedThrow:
    """A throw whose shape is in a STEP file.

    Attributes
    ----------
    path : str
        The file.
    digest : str
        SHA-256 of its content.
    length : float
        Distance of the end planes [m].
    pins : tuple of ImportedPin
        From the left.
    journal_radii : (left, right)
        Of the main journals at the ends [m].
    volume, area : float
        Of the solid [m^3, m^2].
    filleted : bool
        Whether main journals and pins meet the webs without a sharp corner.
    turned, shifted : float
        Transformation of the part into the throw frame: a rotation about +z [rad] that puts the first pin
        at +y, and then a shift along z [m] that puts the left end at 0.
    remarks : tuple of str
        What was found by shape, not by name, and the transformation of the part.
    surfaces : tuple of (name, tags)
        Numbers of the surfaces in gmsh; all of the solid.
    plan : SizePlan
        Element sizes at factor 1.
    smallest : float
        Smallest size on curved surfaces at factor 1 [m].
    holes : tuple of Cylinder
        Along the shaft, each as the bore of a cylinder; `plan` numbers them from zero.
    curved : tuple of (radius, area)
        Of all other curved surfaces: smallest radius of curvature and area [m, m^2].
    cylinders : tuple of Cylinder
        Left main journal, pins, right main journal with their fillets and bores; the extent along z
        includes the fillets.
    fillets, corners : tuple of (zone, tags)
        Surfaces and curves where elements are small; cylinders are numbered from the left main
        journal.
    """

    path: str
    digest: str
    length: float
    pins: tuple[ImportedPin, ...]
    journal_radii: tuple[float, float]
    volume: float
    area: float
    filleted: bool
    turned: float
    shifted: float
    remarks: tuple[str, ...]
    surfaces: tuple[tuple[str, tuple[int, ...]], ...]
    plan: SizePlan
    smallest: float
    holes: tuple[Cylinder, ...]
    curved: tuple[tuple[float, float], ...]
    cylinders: tuple[Cylinder, ...]
    fillets: tuple[tuple[Zone, tuple[int, ...]], ...]
    corners: tuple[tuple[Zone, tuple[int, ...]], ...]

    @property
    def symmetry(self) -> str:
        """An imported throw is meshed whole, whatever symmetry it has."""
        return "full"

    @property
    def pin_axes(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the pins' axes [m]."""
        return tuple(pin.axis for pin in self.pins)


@dataclass(frozen=True)
class RequestedFaces:
    """Faces by their names in the file; None for those to be found by shape."""

    left: tuple[StepFace, ...] | None
    right: tuple[StepFace, ...] | None
    pins: tuple[tuple[StepFace, ...], ...] | None


def import_throw(
    path: str | Path,
    left_end: str | None = LEFT_END,
    right_end: str | None = RIGHT_END,
    pins: Sequence[str] | None = (PIN,),
    *,
    process: IsolatedProcess | None = None,
) -> ImportedThrow:
    """Read a throw from a STEP file.

    The shaft axis must be the z axis, with the left end at the smaller z; the part may be anywhere
    along it and at any angle about it. The file's unit of length is taken into account. Names may differ
    in case, and have underscores or hyphens for spaces. If no face has a name, ends and pins are found
    by shape: the plane faces at the smallest and the largest z, and round cylinders parallel to z off
    the shaft axis.

    Parameters
    ----------
    path : str or Path
        A STEP file with one solid: the throw from the middle of one main journal to the middle of the
        next.
    left_end, right_end : str or None
        Names of the end faces; None finds them by shape even if faces have names.
    pins : sequence of str or None
        Names of the pins' cylindrical faces, in any order; None finds them by shape. By default "pin",
        and "pin 2", "pin 3" ... if present.
    process : IsolatedProcess, optional
        Process for reading; by default the one shared in this process.

    Raises
    ------
    InputError
        If the file or the part in it cannot be used.

    Examples
    --------
    >>> throw = import_throw("throw.step", pins=("pin",))  # doctest: +SKIP
    """
    content = file_content(Path(path))
    path = Path(path).resolve()
    step = read_step(content, str(path))
    if isinstance(pins, str):
        pins = (pins,)
    if pins is not None and tuple(pins) == (PIN,):
        pins = _all_pins(step.faces)
    if not step.faces:
        wanted = RequestedFaces(None, None, None)
    else:
        wanted = RequestedFaces(
            _named(step.faces, "left_end", left_end, PLANE),
            _named(step.faces, "right_end", right_end, PLANE),
            None if pins is None else _named_pins(step.faces, pins),
        )
    process = shared_process() if process is None else process
    try:
        imported: ImportedThrow = process.call(
            "geometry.recognition:recognize",
            str(path),
            hashlib.sha256(content).hexdigest(),
            wanted,
            time_limit=TIME_LIMIT,
        )
    except ProcessLostError as error:
        raise InputError(f"{path}: given a file that cannot be read: {error}.") from None
    return imported


def _all_pins(faces: tuple[StepFace, ...]) -> tuple[str, ...]:
    """The names "pin", "pin 2", "pin 3" ... as far as present."""
    names = {_plain(face.name) for face in faces}
    further = (f"{PIN} {number}" for number in count(2))
    return (PIN, *takewhile(lambda name: name in names, further))


def file_content(path: Path) -> bytes:
    """Read a file, or report in one sentence why this is impossible."""
    if (entry := not_a_file(path)) is not None:
        raise InputError(f"{path}: {entry}.")
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: does not exist; give the path of a STEP file.") from None
    except OSError as error:
        raise InputError(f"{path}: given a file that cannot be read: {error.strerror}.") from None


def _plain(name: str) -> str:
    """A name without the changes that programs make in it."""
    return " ".join(name.casefold().replace("_", " ").replace("-", " ").split())


def _named(
    faces: tuple[StepFace, ...], field: str, name: str | None, kind: str
) -> tuple[StepFace, ...] | None:
    """Faces of a name, all of which must have the required kind of surface."""
    if name is None:
        return None
    named = tuple(face for face in faces if _plain(face.name) == _plain(name))
    if not named:
        names = list(dict.fromkeys(face.name for face in faces))
        listed = ", ".join(map(repr, names[:MOST_NAMES]))
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        raise InputError(
            f"{field}: given {name!r}; allowed are the names of faces in the file, {listed}{more}, or "
            "None to find it by shape."
        )
    for face in named:
        if face.kind != kind:
            allowed = "a plane" if kind == PLANE else "a cylinder"
            raise InputError(
                f"{field}: given {name!r}, which names a face on a {face.kind}; allowed is {allowed}."
            )
    return named


def _named_pins(
    faces: tuple[StepFace, ...], names: Sequence[str]
) -> tuple[tuple[StepFace, ...], ...]:
    if len(names) == 0:
        raise InputError("pins: given no names; allowed is one for each crankpin.")
    return tuple(_named(faces, "pins", name, CYLINDER) or () for name in names)


def imported_parts(throw: ImportedThrow, mesh: ThrowMesh) -> ThrowParts:
    """Parts of an imported throw.

    Parameters
    ----------
    mesh : ThrowMesh
        Of the throw; widths are measured on it.

    Returns
    -------
    ThrowParts
        Each web as a plate with the width that nominal stresses refer to.
    """
    corners = mesh.points[flat_triangles(mesh)]
    rows = list(pairwise(throw.cylinders))
    names = ["left web", *(f"web {number}" for number in range(2, len(rows))), "right web"]
    webs = tuple(
        _web(name, before, after, corners)
        for name, (before, after) in zip(names, rows, strict=True)
    )
    return ThrowParts(throw.cylinders, webs)


def _web(name: str, before: Cylinder, after: Cylinder, corners: Array) -> WebPlate:
    """Make a plate of what lies between two cylinders."""
    foot, tip = (before, after) if before.is_pin <= after.is_pin else (after, before)
    start, end = before.end, max(after.start, before.end)
    plate = WebPlate(name, start, end, foot.axis, tip.axis, Outline(()))
    middle = 0.5 * (foot.radius + plate.distance - tip.radius)
    height = min(max(middle, 0.0), plate.distance)
    half = 0.5 * _width(plate, height, corners)
    low, high = -foot.radius, plate.distance + tip.radius
    turns = ((0.0, low), (half, low), (half, high), (0.0, high))
    outline = Outline(tuple(Line(corner, other) for corner, other in pairwise(turns)))
    return WebPlate(name, start, end, foot.axis, tip.axis, outline)


def _width(web: WebPlate, height: float, corners: Array) -> float:
    """Distance of the outermost points of a surface (t, 3, 3) across a web, halfway through it [m]."""
    up = np.array([*web.direction, 0.0])
    across = np.array([up[1], -up[0], 0.0])
    local = corners - np.array([*web.foot, 0.5 * (web.start + web.end)]) - height * up
    u, first, second = local @ across, local @ up, local[..., 2]
    # Shares of the corners at the point that the line meets, of triangles that are not edge-on.
    shares = np.stack(
        [first[:, k - 2] * second[:, k - 1] - first[:, k - 1] * second[:, k - 2] for k in range(3)],
        axis=1,
    )
    total = shares.sum(axis=1)
    met = total != 0.0
    shares = shares[met] / total[met, None]
    at = np.sum(shares * u[met], axis=1)[(shares >= 0.0).all(axis=1)]
    return float(np.ptp(at)) if len(at) else 0.0
