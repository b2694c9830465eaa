"""Cut a crankshaft's solid out of a STEP file into throws, in the process that runs gmsh.

Lengths are in mm here, for which the kernel's tolerances are made; what leaves is in m.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from crankbase.array_checks import Array
from crankbase.errors import InputError, MeshError
from crankbase.processes import scratch_folder
from crankbase.sentences import amount
from geometry.equal_pieces import EQUAL, Signature, signature
from geometry.faces import PLAIN_KINDS, Face, Round, measured_face, meetings, rounds_along
from geometry.gmsh_session import gmsh_errors, gmsh_session, read_shapes
from geometry.mesh import OnRemark, SolidProperties
from geometry.shaft_shape import PLACE, Line, frame_along, journals_of, usual_cuts
from geometry.solid import remove_loose
from geometry.solids_in_file import (
    MM,
    SolidInFile,
    crankshaft_among,
    is_built_up,
    measured_solid,
)
from geometry.surface_mass import measured_properties

# Volumes of the pieces make up the whole to this share; of spline faces the kernel's own are less exact.
KEPT, KEPT_OF_SPLINES = 1e-4, 0.01
# A disk that cuts a journal is so much larger.
BEYOND = 1.02
# Cylinders at the two ends are of one thickness to this share.
ALIKE = 1e-4
# The free end is that with the low or the high coordinate in the file, along its main direction.
LOW, HIGH = "low", "high"
THICKER, GIVEN = "thicker", "given"


@dataclass(frozen=True)
class FoundCylinder:
    """A main journal, pin or bore in the shaft's frame [m, rad]; fillets at start and end."""

    diameter: float
    axis: tuple[float, float]
    start: float
    end: float
    fillets: tuple[float, float]
    deviation: float


@dataclass(frozen=True)
class Piece:
    """A throw or an end part, in a frame along the shaft's own.

    Attributes
    ----------
    low, high : float
        Its reach along the shaft [m].
    solid : SolidProperties
        In m, z from the shaft's origin.
    pins : tuple of int
        Numbers of its pins, from 0; none in an end part.
    symmetry : str
        As of a `CrankThrow`.
    like, change : int, str
        Number of the first throw that it is like, perhaps its own, and how that becomes it.
    copied : int or None
        Number of a throw before it that is the same.
    text : str
        STEP file of an end part, or of a throw that is no copy: first pin at +y, left end at z = 0.
    """

    low: float
    high: float
    solid: SolidProperties
    pins: tuple[int, ...] = ()
    symmetry: str = "full"
    like: int = 0
    change: str = ""
    copied: int | None = None
    text: str = ""


@dataclass(frozen=True)
class CutShaft:
    """What was found in a file, and the pieces.

    Attributes
    ----------
    solids : tuple of SolidInFile
    chosen : int
        Number of the crankshaft among them, from 0.
    rotation, origin : (3, 3), (3,) array
        Axes of the shaft's frame as rows, and its origin, in the file [m].
    flange_by : {"thicker", "given", "high"}
        How the flange was told: by its larger diameter, by the free end given, or by its coordinate.
    off_line : float
        Largest distance of a journal's own axis from the shaft axis [m].
    mains, pins, bores : tuple of FoundCylinder
        Main journals and pins with their fillets, and holes along the shaft.
    crossing : int
        Number of other round holes' faces.
    splines : bool
        Whether it has faces that the kernel weighs less exactly.
    free_end, flange_end : Piece or None
        What is beyond the outer cuts.
    throws : tuple of Piece
    """

    solids: tuple[SolidInFile, ...]
    chosen: int
    rotation: Array
    origin: Array
    flange_by: str
    off_line: float
    mains: tuple[FoundCylinder, ...]
    pins: tuple[FoundCylinder, ...]
    bores: tuple[FoundCylinder, ...]
    crossing: int
    splines: bool
    free_end: Piece | None
    flange_end: Piece | None
    throws: tuple[Piece, ...]


def cut_shaft(
    path: str,
    name: str | None,
    free_end: str | None,
    moved: Mapping[int, float],
    on_remark: OnRemark | None = None,
) -> CutShaft:
    """Find the crankshaft in a file and cut it; parameters and errors as of `import_crankshaft`.

    Parameters
    ----------
    on_remark : callable, optional
        Called with the name of each step.
    """
    tell: Any = on_remark or (lambda _: None)
    with gmsh_session("crankshaft") as gmsh, scratch_folder() as folder:
        tell("Reading the file")
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        made = read_shapes(gmsh, path)
        gmsh.model.occ.synchronize()
        tags = [tag for dimension, tag in made if dimension == 3]
        tell("Looking for the crankshaft")
        measured = [measured_solid(gmsh, tag, number) for number, tag in enumerate(tags, start=1)]
        solids = tuple(solid for solid, _ in measured)
        chosen = crankshaft_among(path, solids, name, lambda: is_built_up(gmsh, tags))
        line = measured[chosen][1]
        assert isinstance(line, Line)
        others = [(3, tag) for tag in tags if tag != tags[chosen]]
        gmsh.model.occ.remove(others, recursive=True)
        with gmsh_errors("cut the crankshaft"):
            shaft = _Shaft(gmsh, path, tags[chosen], line, free_end)
            tell("Cutting it into throws")
            shaft.cut(moved)
            tell("Comparing the throws")
            free, flange, throws = shaft.pieces(folder)
            mains, pins = shaft.described()
        return CutShaft(
            solids,
            chosen,
            shaft.rotation,
            MM * (shaft.origin + shaft.rotation[2] * shaft.cuts[0]),
            shaft.flange_by,
            MM * shaft.off_line,
            mains,
            pins,
            shaft.bores(),
            shaft.crossing(),
            shaft.splines,
            free,
            flange,
            throws,
        )


class _Shaft:
    """The crankshaft's solid in gmsh: turned into its frame, then cut."""

    def __init__(self, gmsh: Any, path: str, solid: int, line: Line, free_end: str | None) -> None:
        self._gmsh, self._path, self._solid = gmsh, path, solid
        box = gmsh.model.getBoundingBox(3, solid)
        self._near = PLACE * math.dist(box[:3], box[3:])
        self._turn(line, free_end)
        self._faces = self._measured()
        kinds = {gmsh.model.getType(2, face.tag) for face in self._faces}
        self.splines = not kinds <= {*PLAIN_KINDS}
        self._rounds = rounds_along(self._faces, self._near)
        on_axis = [
            item
            for item in self._rounds
            if item.whole and item.radius > 0.0 and item.offset < self._near
        ]
        # gmsh numbers the faces of what it turns anew.
        self._pins = sorted((self._turned(line, pin) for pin in line.pins), key=lambda pin: pin.low)
        journals = journals_of(on_axis, self._pins, self._near)
        self._mains, self._throws = journals.mains, journals.throws
        corners = gmsh.model.getBoundary([(3, solid)], oriented=False, recursive=True)
        heights = [gmsh.model.getValue(0, tag, [])[2] for _, tag in corners]
        self._low, self._high = min(heights), max(heights)
        ends = {
            face.tag
            for face in self._faces
            if face.kind == "Plane"
            and face.along
            and min(face.low - self._low, self._high - face.high) < self._near
        }
        row = [*self._mains, *self._pins]
        self._met = meetings(gmsh, solid, row, ends, self._near)
        self._reaches = [
            self._met.reach(place, item, self._faces) for place, item in enumerate(row)
        ]

    def _turned(self, line: Line, pin: Round) -> Round:
        """Find a pin again in the shaft's frame."""
        middle = line.rotation.T @ np.array([*pin.axis, pin.middle])
        x, y, z = self.rotation @ (middle - self.origin)
        for item in self._rounds:
            same = math.dist(item.axis, (x, y)) < 3.0 * self._near and item.low < z < item.high
            if same and abs(item.radius - pin.radius) < 3.0 * self._near:
                return item
        raise MeshError("a pin is not where it was before the crankshaft was turned.")

    def _measured(self) -> list[Face]:
        sides = self._gmsh.model.getBoundary([(3, self._solid)], combined=False, oriented=False)
        return [measured_face(self._gmsh, tag) for _, tag in sides]

    def _turn(self, line: Line, free_end: str | None) -> None:
        """Turn it: z from the free end along the axis, the first pin at +y."""
        on_axis = {tag for item in line.rounds for tag in item.tags}
        journals = [face for face in self._measured() if face.tag in on_axis]
        sizes = [abs(item.radius) * np.ptp(item.points @ line.rotation[2]) for item in journals]
        centers = np.array(
            [
                face.point + face.axis * float((face.points.mean(axis=0) - face.point) @ face.axis)
                for face in journals
            ]
        )
        # The straight line through the journals' own axes, each by its size.
        center = np.average(centers, axis=0, weights=sizes)
        _, _, ways = np.linalg.svd((centers - center) * np.sqrt(sizes)[:, None])
        self.off_line = float(np.linalg.norm(np.cross(centers - center, ways[0]), axis=1).max())
        direction = ways[0] * math.copysign(1.0, float(ways[0] @ line.rotation[2]))
        first, last = line.pins[0].low, line.pins[-1].high
        before = max((item.radius for item in line.rounds if item.middle < first), default=0.0)
        after = max((item.radius for item in line.rounds if item.middle > last), default=0.0)
        thicker = abs(before - after) > ALIKE * after
        self.flange_by = GIVEN if free_end is not None else THICKER if thicker else HIGH
        low_first = bool(direction[np.argmax(np.abs(direction))] > 0.0)
        flipped = low_first == (free_end == HIGH)
        if self.flange_by == THICKER:
            flipped = before > after
        pin = line.pins[-1 if flipped else 0]
        rotation = frame_along(-direction if flipped else direction)
        x, y = np.array(pin.axis) - line.axis
        across = rotation @ (line.rotation.T @ np.array([x, y, 0.0]))
        to_crank = Rotation.from_rotvec([0.0, 0.0, math.atan2(across[0], across[1])])
        self.rotation, self.origin = to_crank.as_matrix() @ rotation, center
        occ = self._gmsh.model.occ
        occ.translate([(3, self._solid)], *(-center).tolist())
        turn = Rotation.from_matrix(self.rotation).as_rotvec()
        angle = float(np.linalg.norm(turn))
        if angle > 0.0:
            occ.rotate([(3, self._solid)], 0.0, 0.0, 0.0, *(turn / angle).tolist(), angle)
        occ.synchronize()

    def cut(self, moved: Mapping[int, float]) -> None:
        """Cut it into pieces, which must be as many as expected and weigh as much as the whole."""
        gmsh, occ = self._gmsh, self._gmsh.model.occ
        whole, stepped = self._volume(self._solid), self._stepped()
        self.cuts = self._places(moved)
        inside = [
            (place, journal)
            for place, journal in zip(self.cuts, self._mains, strict=True)
            if min(place - self._low, self._high - place) > self._near
        ]
        disks = []
        for place, journal in inside:
            radius = BEYOND * journal.radius
            disks.append((2, occ.addDisk(0.0, 0.0, place, radius, radius)))
        made = [(3, self._solid)]
        if disks:
            _, (made, *_) = occ.fragment([(3, self._solid)], disks)
        occ.synchronize()
        remove_loose(gmsh)
        tags = sorted(
            (tag for dimension, tag in made if dimension == 3),
            key=lambda tag: float(occ.getCenterOfMass(3, tag)[2]),
        )
        places = [self._low, *(place for place, _ in inside), self._high]
        between = [
            low < occ.getCenterOfMass(3, tag)[2] < high
            for tag, (low, high) in zip(tags, pairwise(places), strict=False)
        ]
        kept = sum(map(self._volume, tags))
        most = KEPT_OF_SPLINES if self.splines else KEPT
        if len(tags) != len(places) - 1 or not all(between) or abs(kept / whole - 1.0) > most:
            allowed = "faces fit together exactly: approximated spline surfaces do not"
            if stepped:
                allowed = f"spline faces close along straight lines: here {stepped} in steps"
            raise InputError(
                f"{self._path}: given a crankshaft that the kernel cuts into {len(tags)} pieces with "
                f"{100.0 * kept / whole:.6g} % of its volume in place of {len(places) - 1} with all of it; "
                f"allowed is one whose {allowed}, so export it with analytic ones."
            )
        self._pieces = list(zip(tags, pairwise(places), strict=True))

    def _places(self, moved: Mapping[int, float]) -> list[float]:
        """Places of the cuts, moved ones kept within the cylinders of their journals."""
        cuts = usual_cuts(self._mains, self._reaches[: len(self._mains)])
        if len(cuts) == 2 and all(
            abs(reach - end) < self._near
            for reach, end in ((self._reaches[0][0], self._low), (self._reaches[1][1], self._high))
        ):
            cuts = [self._low, self._high]  # a throw that has been cut off already
        for number, shift in moved.items():
            if not 1 <= number <= len(cuts):
                raise InputError(
                    f"cut: given {number}; allowed is 1 to {len(cuts)}, because there are so many cuts."
                )
            journal, place = self._mains[number - 1], cuts[number - 1] + shift / MM
            low, high = journal.low - cuts[number - 1], journal.high - cuts[number - 1]
            if not journal.low <= place <= journal.high:
                least, most = amount(MM * low, "m"), amount(MM * high, "m")
                raise InputError(
                    f"cut: given {number} moved by {amount(shift, 'm')}; allowed is {least} to "
                    f"{most}, because the cut must be through the main journal."
                )
            cuts[number - 1] = place
        return cuts

    def _stepped(self) -> int:
        """Number of spline faces that close round a journal along more than one edge.

        Programs make them where they unite two journals whose seams are not in line; the face then reaches
        further than once round, and the kernel does not find where a plane meets it.
        """
        count = 0
        for face in self._faces if self.splines else ():
            side = (2, face.tag)
            edges = self._gmsh.model.getBoundary([side], combined=False, oriented=False)
            closing = [edge for edge in set(edges) if edges.count(edge) > 1]
            count += len(closing) > 1 and self._gmsh.model.getType(*side) not in PLAIN_KINDS
        return count

    def _volume(self, tag: int) -> float:
        return float(self._gmsh.model.occ.getMass(3, tag))

    def pieces(self, folder: Path) -> tuple[Piece | None, Piece | None, tuple[Piece, ...]]:
        """Return the end parts and the throws; of equal throws the first one's text stands for all."""
        shapes = str(folder / "pieces.brep")
        self._gmsh.write(shapes)
        ends: list[Piece | None] = [None, None]
        throws: list[Piece] = []
        known: list[Signature] = []
        for tag, (low, high) in self._pieces:
            solid = measured_properties(self._gmsh, tag)
            solid = replace(solid, center=solid.center - np.array([0.0, 0.0, self.cuts[0]]))
            reach = MM * (low - self.cuts[0]), MM * (high - self.cuts[0])
            piece = Piece(*reach, solid.scaled(MM))
            before, behind = high < self.cuts[0] + self._near, low > self.cuts[-1] - self._near
            if before or behind:
                text = self._text(shapes, tag, low, 0.0, folder)
                ends[int(behind)] = replace(piece, text=text)
                continue
            pins = self._throws[len(throws)]
            angles = [angle_of(pin.axis) for pin in pins]
            shape = signature(self._gmsh, tag, low, high, angles)
            shape = replace(shape, volume=solid.volume)
            number = len(throws)
            like, change, copied = number, EQUAL, None
            for place, other in enumerate(known):
                way = other.change_to(shape)
                if way == EQUAL:
                    like, change, copied = throws[place].like, throws[place].change, place
                    break
                if way is not None and like == number:
                    like, change = place, way
            throws.append(
                replace(
                    piece,
                    pins=tuple(self._pins.index(pin) for pin in pins),
                    symmetry=shape.symmetry,
                    like=like,
                    change=change,
                    copied=copied,
                    text=""
                    if copied is not None
                    else self._text(shapes, tag, low, angles[0], folder),
                )
            )
            known.append(shape)
        return ends[0], ends[1], tuple(throws)

    def _text(self, shapes: str, tag: int, low: float, angle: float, folder: Path) -> str:
        """Write a piece alone as STEP in mm, its first pin at +y and its left end at z = 0."""
        gmsh, occ = self._gmsh, self._gmsh.model.occ
        center = occ.getCenterOfMass(3, tag)
        before, file = gmsh.model.getCurrent(), folder / "throw.step"
        gmsh.model.add("throw")
        try:
            made = occ.importShapes(shapes)
            nearest = min(made, key=lambda item: math.dist(occ.getCenterOfMass(*item), center))
            occ.remove([item for item in made if item != nearest], recursive=True)
            occ.rotate([nearest], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -angle)
            occ.translate([nearest], 0.0, 0.0, -low)
            occ.synchronize()
            gmsh.write(str(file))
        finally:
            gmsh.model.remove()
            gmsh.model.setCurrent(before)
        return file.read_text(encoding="utf-8")

    def described(self) -> tuple[tuple[FoundCylinder, ...], tuple[FoundCylinder, ...]]:
        """Main journals and pins, fillets included in their reach."""
        row = [
            self._cylinder(item, *reach, self._fillet(place, "start"), self._fillet(place, "end"))
            for place, (item, reach) in enumerate(
                zip([*self._mains, *self._pins], self._reaches, strict=True)
            )
        ]
        return tuple(row[: len(self._mains)]), tuple(row[len(self._mains) :])

    def _fillet(self, place: int, end: str) -> float:
        return self._met.radii.get((place, end), 0.0)

    def _cylinder(
        self, item: Round, low: float, high: float, start: float = 0.0, end: float = 0.0
    ) -> FoundCylinder:
        x, y = item.axis
        first = self.cuts[0]
        return FoundCylinder(
            2.0 * MM * abs(item.radius),
            (MM * x, MM * y),
            MM * (low - first),
            MM * (high - first),
            (MM * start, MM * end),
            MM * item.deviation,
        )

    def bores(self) -> tuple[FoundCylinder, ...]:
        """Round holes along the shaft, of the uncut solid."""
        holes = [item for item in self._rounds if item.radius < 0.0 and item.whole]
        return tuple(self._cylinder(item, item.low, item.high) for item in holes)

    def crossing(self) -> int:
        """Number of faces of round holes that are not along the shaft."""
        return sum(
            face.kind == "Cylinder" and face.radius < 0.0 and not face.along for face in self._faces
        )


def angle_of(axis: tuple[float, float]) -> float:
    """Angle of a place about +z, counted from +y [rad]."""
    return math.atan2(-axis[0], axis[1])
