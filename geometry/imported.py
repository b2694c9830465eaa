"""A throw from a STEP file, and the names of its ends and pins."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, pairwise, takewhile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankbase.calls import ProcessLostError
from crankbase.errors import InputError
from crankbase.summaries import summarized
from crankbase.wrong_files import not_a_file
from geometry.facets import flat_triangles
from geometry.isolated import IsolatedProcess, shared_process
from geometry.mesh import ThrowMesh
from geometry.outline import Line, Outline
from geometry.parts import Cylinder, ThrowParts, WebPlate
from geometry.sizes import SizePlan
from geometry.solid import LEFT_END, PIN, RIGHT_END, Zone
from geometry.step_file import CYLINDER, PLANE, StepFace, read_step

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
        found: ImportedThrow = process.call(
            "geometry.recognition:recognize",
            str(path),
            hashlib.sha256(content).hexdigest(),
            wanted,
            time_limit=TIME_LIMIT,
        )
    except ProcessLostError as error:
        raise InputError(f"{path}: given a file that cannot be read: {error}.") from None
    return found


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
    found = tuple(face for face in faces if _plain(face.name) == _plain(name))
    if not found:
        names = list(dict.fromkeys(face.name for face in faces))
        listed = ", ".join(map(repr, names[:MOST_NAMES]))
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        raise InputError(
            f"{field}: given {name!r}; allowed are the names of faces in the file, {listed}{more}, or "
            "None to find it by shape."
        )
    for face in found:
        if face.kind != kind:
            allowed = "a plane" if kind == PLANE else "a cylinder"
            raise InputError(
                f"{field}: given {name!r}, which names a face on a {face.kind}; allowed is {allowed}."
            )
    return found


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
    throw : ImportedThrow
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
    outline = Outline(tuple(Line(one, other) for one, other in pairwise(turns)))
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
