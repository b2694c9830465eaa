"""A throw from a STEP file: what its shape is, and how it is meshed."""

import hashlib
import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import count, pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.calls import ProcessLostError
from crankbase.errors import InputError, MeshError
from crankbase.input_file import not_a_file
from crankbase.processes import scratch_folder
from crankbase.sentences import with_sentences
from crankbase.summaries import frozen
from geometry.gmsh_session import (
    IsolatedProcess,
    gmsh_errors,
    gmsh_session,
    read_shapes,
    shared_process,
)
from geometry.mesh import (
    MeshingStrategy,
    OnRemark,
    SolidProperties,
    ThrowMesh,
    check_budget,
    checked_mesh,
    checked_part,
    flat_triangles,
    try_strategies,
)
from geometry.parts import Cylinder, Line, Outline, ThrowParts, WebPlate
from geometry.sizes import (
    GROWTH,
    LARGEST_ON_ROUND,
    ROOT_PER_FILLET,
    SHARES,
    SIZE_PER_BORE,
    SizeMap,
    SizePlan,
    set_face_sizes,
    set_size_map,
)
from geometry.solid import BORE, LEFT_END, PIN, RIGHT_END, Zone
from geometry.step_file import CYLINDER, PLANE, StepFace, read_step
from geometry.symmetric_part import PartOfSolid, part_of_solid

# The unit in which the kernel reads files, and the scale that gmsh applies then.
UNIT_OPTION, SCALE_OPTION = "Geometry.OCCTargetUnit", "Geometry.OCCScaling"
# Places are told apart to this share of the part's length, directions to this sine.
PLACE_TOLERANCE = 1e-5
# Nodes per volume of a cubed element size and per area of a squared one.
NODES_PER_CELL = 8.0
NODES_PER_FACE = 2.5
# Of rounded edges, with the nodes that their small elements bring with them on both sides.
NODES_PER_ROUNDED_FACE = 10.0
LAYERS = 100
# Seconds for reading a part; one of a hundred faces takes a fifth of a second.
TIME_LIMIT = 300.0
MOST_NAMES = 20


@with_sentences
@frozen("path", "length [m]", "pins", "volume [m^3]", "remarks")
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
    volume, area : float
        Of the solid [m^3, m^2].
    symmetry : str
        Smallest part that stands for the throw, and is meshed: "quarter", "half" or "full".
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
    solid : SolidProperties
        By the kernel, in the throw frame.
    """

    path: str
    digest: str
    length: float
    volume: float
    area: float
    symmetry: str
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
    solid: SolidProperties = field(compare=False, repr=False)

    @property
    def pins(self) -> tuple[Cylinder, ...]:
        """From the left: "pin", "pin 2" ..."""
        return self.cylinders[1:-1]

    @property
    def pin_axes(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the pins' axes [m]."""
        return tuple(pin.axis for pin in self.pins)

    @property
    def parts(self) -> ThrowParts:
        """Journals and pins; webs, of any shape, are measured on a mesh alone."""
        return ThrowParts(self.cylinders, ())

    @property
    def _first_pin(self) -> Cylinder:
        """Or, of an end part of a crankshaft, which has none, its main journal."""
        return self.cylinders[1 if self.pins else 0]

    @property
    def crank_radius(self) -> float:
        """Of the first pin [m]."""
        return math.hypot(*self._first_pin.axis)

    @property
    def pin_diameter(self) -> float:
        """Of the first pin [m]."""
        return 2.0 * self._first_pin.radius

    @property
    def pin_length(self) -> float:
        """Of the first pin, between the webs [m]."""
        return self._first_pin.end - self._first_pin.start

    @property
    def pin_bore(self) -> float:
        """Diameter of the hole through the first pin, 0 without one [m]."""
        return 2.0 * self._first_pin.bore_radius

    @property
    def main_journal_diameter(self) -> float:
        """Of the thinner one, as both are where the shaft's are equal [m]."""
        return 2.0 * min(self.cylinders[0].radius, self.cylinders[-1].radius)

    @property
    def main_journal_length(self) -> float:
        """Both halves together [m]."""
        return sum(journal.end - journal.start for journal in self.cylinders[:: len(self.pins) + 1])

    @property
    def main_journal_bore(self) -> float:
        """Diameter of the larger hole through a main journal, 0 without one [m]."""
        return 2.0 * max(self.cylinders[0].bore_radius, self.cylinders[-1].bore_radius)

    @property
    def overlap(self) -> float:
        """Of main journal and first pin, negative without overlap [m]."""
        return 0.5 * (self.main_journal_diameter + self.pin_diameter) - self.crank_radius

    def expected_unknowns(self, factor: float, part: str = "auto") -> int:
        """Predict the number of displacement unknowns, as `predict_unknowns` does but more roughly.

        Parameters
        ----------
        factor : float
            Scales all element sizes.
        part : {"auto", "quarter", "half", "full"}
            What is meshed; "auto" is the smallest that stands for the throw.
        """
        plan = _scaled(self.plan, factor)
        share = (np.arange(LAYERS) + 0.5) / LAYERS
        cells, near, faces = 0.0, 0.0, self.area / plan.bulk**2
        for zone in plan.zones:
            distance = plan.reach(zone) * share
            layers = (
                (zone.area + 1.5 * math.pi * zone.length * distance) * plan.reach(zone) / LAYERS
            )
            cells += float(np.sum(layers / (zone.size + GROWTH * distance) ** 3))
            near += float(np.sum(layers))
            faces += zone.area / zone.size**2
        cells += max(self.volume - near, 0.0) / plan.bulk**3
        for radius, area in self.curved:
            size = factor * max(ROOT_PER_FILLET * radius, self.smallest)
            if size < plan.bulk:
                faces += NODES_PER_ROUNDED_FACE / NODES_PER_FACE * area / size**2
        share_of_it = SHARES[self.symmetry if part == "auto" else part]
        return round(3.0 * share_of_it * (NODES_PER_CELL * cells + NODES_PER_FACE * faces))

    def meshed(
        self,
        size_factor: float = 1.0,
        part: str = "auto",
        sizes: SizeMap | None = None,
        attempts: tuple[str, ...] = (),
        on_remark: OnRemark | None = None,
    ) -> ThrowMesh:
        """Mesh it in this process.

        Parameters
        ----------
        size_factor, part, sizes, attempts, on_remark
            As for `mesh_throw`.

        Returns
        -------
        ThrowMesh
            In the throw frame. All faces other than ends, pins, main journals,
            fillets and bores are "web".

        Raises
        ------
        InputError
            If the file has changed since it was imported, or the mesh would have too many unknowns.
        MeshError
            If all strategies fail; the message states the last reason.
        """
        if hashlib.sha256(file_content(Path(self.path))).hexdigest() != self.digest:
            raise InputError(
                f"{self.path}: given a file that has changed since it was imported; allowed is the same, "
                "or import it again."
            )
        part = checked_part(self, part)
        check_budget(
            self.expected_unknowns(size_factor, part)
            if sizes is None
            else sizes.expected_unknowns(size_factor),
            size_factor,
        )

        def mesh_by(rung: MeshingStrategy, failed: tuple[str, ...]) -> ThrowMesh:
            factor = size_factor * rung.share
            opened = time.perf_counter()
            with opened_part(self.path) as (gmsh, tag):
                for option, value in rung.options:
                    gmsh.option.setNumber(option, value)
                with gmsh_errors("mesh the throw"):
                    made = self.placed(gmsh, tag, part)
                    seconds = time.perf_counter() - opened
                    if sizes is None:
                        self._set_sizes(gmsh, made, factor)
                    else:
                        set_size_map(gmsh, sizes, factor, self.parts)
                mesh = checked_mesh(
                    gmsh,
                    made.surfaces,
                    made.solid,
                    part=part,
                    length=self.length,
                    pins=tuple(pin.name for pin in self.pins),
                    size_factor=factor,
                    attempts=failed,
                    geometry_seconds=seconds,
                )
            # The surfaces' numbers must mean what they did when the part was read.
            ends = ((LEFT_END, 0.0), (RIGHT_END, mesh.length))
            for end, place in ends[:1] if part == "quarter" else ends:
                nodes = np.unique(mesh.surfaces.get(end, np.empty(0, np.int64)))
                off = np.abs(mesh.points[nodes, 2] - place)
                if off.size == 0 or off.max() > 10.0 * PLACE_TOLERANCE * mesh.length:
                    raise MeshError(f"the surface {end!r} of the file is not where it was.")
            return mesh

        return try_strategies(mesh_by, attempts, on_remark)

    def read_into(self, gmsh: Any) -> tuple[int, int]:
        """Read its solid into the current gmsh model, in the throw frame, and return its entity."""
        tag = read_part(gmsh, self.path)
        self._move(gmsh, tag)
        return (3, tag)

    def _move(self, gmsh: Any, tag: int) -> None:
        occ = gmsh.model.occ
        occ.rotate([(3, tag)], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, self.turned)
        occ.translate([(3, tag)], 0.0, 0.0, self.shifted)

    def placed(self, gmsh: Any, tag: int, part: str) -> PartOfSolid:
        """Turn and shift the file's solid in gmsh into the throw frame, and keep a part of it.

        Raises
        ------
        MeshError
            If the part cannot be cut out.
        """
        self._move(gmsh, tag)
        gmsh.model.occ.synchronize()
        return part_of_solid(
            gmsh, tag, part, self.length, self.surfaces, self.fillets, self.corners
        )

    def parts_by(self, mesh: ThrowMesh) -> ThrowParts:
        """Return the journals, pins and webs.

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
        if mesh.part != "full":
            corners = np.concatenate([corners, corners * [-1.0, 1.0, 1.0]])
        if mesh.part == "quarter":
            other_half = np.array([0.0, 0.0, mesh.length]) + corners * [1.0, 1.0, -1.0]
            corners = np.concatenate([corners, other_half])
        rows = list(pairwise(self.cylinders))
        names = ["left web", *(f"web {number}" for number in range(2, len(rows))), "right web"]
        webs = tuple(
            _web(name, before, after, corners)
            for name, (before, after) in zip(names, rows, strict=True)
        )
        return ThrowParts(self.cylinders, webs)

    def _set_sizes(self, gmsh: Any, part: PartOfSolid, factor: float) -> None:
        """Sizes at fillets and corners by a field, elsewhere by curvature."""
        plan = _scaled(self.plan, factor)
        # Elements round a circle, as long beside its radius as at fillets, which an end part may lack.
        longest = factor * ROOT_PER_FILLET if self.pins else min(factor, 1.0) * LARGEST_ON_ROUND
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 2.0 * math.pi / longest)
        gmsh.option.setNumber("Mesh.MeshSizeMin", factor * self.smallest)
        gmsh.option.setNumber("Mesh.MeshSizeMax", plan.bulk)
        if not plan.zones:
            return
        set_face_sizes(gmsh, self.holes, part.fillets, part.corners, plan)


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
        # The names "pin", "pin 2", "pin 3" ... as far as present.
        names = {_plain(face.name) for face in step.faces}
        further = (f"{PIN} {number}" for number in count(2))
        pins = (PIN, *takewhile(lambda name: name in names, further))
    if not step.faces:
        ends = [end for end in (left_end, right_end) if end not in (None, LEFT_END, RIGHT_END)]
        unknown = [*ends, *(name for name in pins or () if name != PIN)]
        if unknown:
            raise InputError(
                f"{path}: given {', '.join(map(repr, unknown))}, but no face of it has a name; allowed is no "
                "name, and faces are found by shape."
            )
        wanted = RequestedFaces(None, None, None)
    else:
        if pins is not None and len(pins) == 0:
            raise InputError("pins: given no names; allowed is one for each crankpin.")
        wanted = RequestedFaces(
            _named(step.faces, "left_end", left_end, PLANE),
            _named(step.faces, "right_end", right_end, PLANE),
            None
            if pins is None
            else tuple(_named(step.faces, "pins", name, CYLINDER) or () for name in pins),
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


def _web(name: str, before: Cylinder, after: Cylinder, corners: Array) -> WebPlate:
    """Make a plate of what lies between two cylinders."""
    foot, tip = (before, after) if before.is_pin <= after.is_pin else (after, before)
    start, end = before.end, max(after.start, before.end)
    plate = WebPlate(name, start, end, foot.axis, tip.axis, Outline(()))
    middle = 0.5 * (foot.radius + plate.distance - tip.radius)
    height = min(max(middle, 0.0), plate.distance)
    # The outermost points of the surface across the web, halfway through it.
    up = np.array([*plate.direction, 0.0])
    across = np.array([up[1], -up[0], 0.0])
    local = corners - np.array([*plate.foot, 0.5 * (plate.start + plate.end)]) - height * up
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
    half = 0.5 * (float(np.ptp(at)) if len(at) else 0.0)
    low, high = -foot.radius, plate.distance + tip.radius
    turns = ((0.0, low), (half, low), (half, high), (0.0, high))
    outline = Outline(tuple(Line(corner, other) for corner, other in pairwise(turns)))
    return WebPlate(name, start, end, foot.axis, tip.axis, outline)


@contextmanager
def opened_part(path: str) -> Iterator[tuple[Any, int]]:
    """A gmsh session with the file's solid in meters, not yet synchronized."""
    with gmsh_session("throw") as gmsh:
        yield gmsh, read_part(gmsh, path)


def read_part(gmsh: Any, path: str) -> int:
    """Read the file's solid into the current model in meters, and return its number.

    The kernel reads it in mm and gmsh scales it: a unit set in the kernel persists for the
    rest of the process, and would change files written later. Faces too thin for elements are healed away.
    """
    option = gmsh.option
    before = option.getString(UNIT_OPTION), option.getNumber(SCALE_OPTION)
    try:
        option.setString(UNIT_OPTION, "MM")
        option.setNumber(SCALE_OPTION, 1e-3)
        solid = _only_solid(gmsh, path)
        width = _width_of_slivers(gmsh, solid)
        return _healed(gmsh, path, solid, width) if width > 0.0 else solid
    finally:
        option.setString(UNIT_OPTION, before[0])
        option.setNumber(SCALE_OPTION, before[1])


def _only_solid(gmsh: Any, path: str) -> int:
    solids = [tag for dimension, tag in read_shapes(gmsh, path) if dimension == 3]
    if len(solids) != 1:
        raise InputError(
            f"{path}: given {len(solids)} solids; allowed is one throw; crankfem cad finds a whole "
            "crankshaft among other solids, and cuts it into throws."
        )
    return int(solids[0])


def _width_of_slivers(gmsh: Any, solid: int) -> float:
    """Largest mean width of faces that are too thin, like those between an oil hole's edge and a cut [m]."""
    occ = gmsh.model.occ
    box = np.array(occ.getBoundingBox(3, solid)).reshape(2, 3)
    thin = PLACE_TOLERANCE * float(np.ptp(box, axis=0).max())
    widths = [0.0]
    for face in np.concatenate(occ.getSurfaceLoops(solid)[1]).tolist():
        edges = np.concatenate(occ.getCurveLoops(face)[1]).tolist()
        length = sum(occ.getMass(1, abs(edge)) for edge in edges)
        widths.append(2.0 * occ.getMass(2, face) / length)
    return max(width for width in widths if width < thin)


def _healed(gmsh: Any, path: str, solid: int, width: float) -> int:
    """Put the file's solid without slivers in its place, if the kernel can make it."""
    before = gmsh.model.getCurrent()
    with scratch_folder() as folder:
        # In a model of its own, in mm, and read again: gmsh numbers what it heals beside what it healed.
        gmsh.model.add("healed")
        try:
            gmsh.option.setNumber(SCALE_OPTION, 1.0)
            whole = _only_solid(gmsh, path)
            volume = gmsh.model.occ.getMass(3, whole)
            gmsh.model.occ.healShapes([(3, whole)], 2e3 * width, sewFaces=False, makeSolids=False)
            gmsh.model.occ.synchronize()
            kept = [gmsh.model.occ.getMass(*item) for item in gmsh.model.getEntities(3)]
            gmsh.write(str(folder / "healed.brep"))
        finally:
            gmsh.model.remove()
            gmsh.model.setCurrent(before)
            gmsh.option.setNumber(SCALE_OPTION, 1e-3)
        if len(kept) != 1 or not math.isclose(kept[0], volume, rel_tol=PLACE_TOLERANCE):
            return solid
        gmsh.model.occ.remove([(3, solid)], recursive=True)
        return _only_solid(gmsh, str(folder / "healed.brep"))


def _scaled(plan: SizePlan, factor: float) -> SizePlan:
    """Sizes at another factor; elements larger than a hole's radius would not fill the part round it."""
    zones = tuple(
        replace(
            zone,
            size=zone.size * (min(factor, 1.0 / SIZE_PER_BORE) if zone.zone[1] == BORE else factor),
        )
        for zone in plan.zones
    )
    return SizePlan(factor * plan.bulk, zones)
