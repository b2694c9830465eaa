"""Find ends, journals, pins, fillets and bores of a CAD part."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from crankbase.errors import InputError, MeshError
from crankbase.sentences import amount, in_si
from geometry.equal_pieces import signature
from geometry.faces import (
    DIRECTION_TOLERANCE,
    Face,
    Round,
    measured_face,
    meetings,
    rounds_along,
)
from geometry.gmsh_session import curvature_radius
from geometry.imported import PLACE_TOLERANCE, ImportedThrow, RequestedFaces, opened_part
from geometry.parts import LEFT_JOURNAL, RIGHT_JOURNAL, Cylinder, Point
from geometry.shaft_shape import journals_of
from geometry.sizes import ROOT_PER_FILLET, SIZE_PER_BORE, SizePlan, bore_zone, root_size, root_zone
from geometry.solid import BORE, FILLET, LEFT_END, MAIN_JOURNAL, PIN, RIGHT_END, WEB, Zone
from geometry.step_file import PLANE, StepFace
from geometry.surface_mass import measured_properties


def same_surface(face: Face, wanted: StepFace, tolerance: float) -> bool:
    """Whether a face lies on the plane or cylinder that the file's text gives."""
    apart = face.point - np.array(wanted.point)
    axis = np.array(wanted.axis)
    if np.linalg.norm(np.cross(face.axis, axis)) > DIRECTION_TOLERANCE:
        return False
    if wanted.kind == PLANE:
        return abs(float(apart @ axis)) < tolerance
    off = float(np.linalg.norm(np.cross(apart, axis)))
    return off < tolerance and abs(abs(face.radius) - wanted.radius) < tolerance


def named_cylinders(
    names: Sequence[str],
    axes: Sequence[Point],
    row: Sequence[Round],
    spans: Sequence[Point],
    radii: Mapping[Zone, float],
    holes: Sequence[Cylinder],
) -> tuple[Cylinder, ...]:
    """Make cylinders of main journals and pins, with their fillets and bores.

    Parameters
    ----------
    names, axes, row, spans : sequences
        Names, axes in the throw frame, what was measured, and reach along z, fillets included [m].
    radii : mapping
        Radii of the fillets by number of the cylinder and end [m].
    holes : sequence of Cylinder
        Along the shaft; one through the middle of a journal or pin is its bore.
    """
    made = []
    for number, (name, axis, item, span) in enumerate(zip(names, axes, row, spans, strict=True)):
        start, end = radii.get((number, "start"), 0.0), radii.get((number, "end"), 0.0)
        cylinder = Cylinder(name, axis, item.radius, *span, start, end, 0.0, axis, *span)
        for hole in holes:
            inside = math.dist(hole.axis, axis) + hole.radius < item.radius
            through = hole.start < 0.5 * sum(span) < hole.end
            if inside and through and hole.radius > cylinder.bore_radius:
                cylinder = replace(
                    cylinder,
                    bore_radius=hole.radius,
                    bore_axis=hole.axis,
                    bore_start=hole.start,
                    bore_end=hole.end,
                )
        made.append(cylinder)
    return tuple(made)


def turned_place(axis: Point, turn: float) -> Point:
    """Turn a place about the shaft axis [m, rad]."""
    sine, cosine = math.sin(turn), math.cos(turn)
    return (cosine * axis[0] - sine * axis[1], sine * axis[0] + cosine * axis[1])


def hole_along(item: Round, turn: float, shift: float) -> Cylinder:
    """A hole in the throw frame, as the bore of a cylinder that the size fields know."""
    axis, radius = turned_place(item.axis, turn), -item.radius
    start, end = item.low + shift, item.high + shift
    return Cylinder(BORE, axis, radius, start, end, 0.0, 0.0, radius, axis, start, end)


def planned_sizes(
    row: list[Round],
    reaches: list[tuple[float, float]],
    fillets: dict[Zone, list[int]],
    corners: dict[Zone, list[int]],
    radii: dict[Zone, float],
    holes: tuple[Cylinder, ...],
) -> SizePlan:
    """Choose element sizes by the rules for throws given by dimensions.

    A web is as thick as the gap between the journal or pin before it and the one after it. An end part of a
    crankshaft has no pins, but main journals alone.
    """
    thinnest_pin = min(pin.radius for pin in row[1:-1] or row)
    gaps = [after[0] - before[1] for before, after in pairwise(reaches)]
    webs = [gap for gap in gaps if gap > 0.02 * thinnest_pin]
    thinnest = min(webs, default=thinnest_pin)
    bulk = min(thinnest, thinnest_pin)
    zones = []
    for zone in [*fillets, *corners]:
        number, end = zone
        gap = gaps[number - 1 if end == "start" else number]
        fillet = radii[zone] if zone in fillets else 0.0
        size = root_size(fillet, gap if gap in webs else thinnest)
        zones.append(root_zone(zone, row[number].radius, fillet, min(bulk, size)))
    for number, hole in enumerate(holes):
        zones.append(bore_zone(number, hole, min(bulk, SIZE_PER_BORE * hole.bore_radius)))
    return SizePlan(bulk, tuple(zones))


# A length outside these is taken for an error of the unit [m].
SHORTEST, LONGEST = 0.001, 20.0
# Of cylinders found by shape, those thinner than this share of the thickest are bolts and the like.
THINNEST_PIN = 0.5
# Rounded edges get no smaller elements than sharp corners do, and holes none smaller than the second:
# elements larger than a hole is wide overlap in it.
ROUNDED_PER_BULK, HOLE_PER_BULK = 0.1, 0.02


def recognize(path: str, digest: str, wanted: RequestedFaces) -> ImportedThrow:
    """Find ends, pins and all other features in a file's solid.

    Raises
    ------
    InputError
    """
    with opened_part(path) as (gmsh, solid):
        gmsh.model.occ.synchronize()
        box = gmsh.model.getBoundingBox(3, solid)
        length = box[5] - box[2]
        if not SHORTEST <= length <= LONGEST:
            raise InputError(
                f"{path}: given a part {in_si(length, 'm', 3)} long; allowed is {in_si(SHORTEST, 'm')} to "
                f"{in_si(LONGEST, 'm')}, so the file's unit of length is probably wrong."
            )
        return _Recognition(gmsh, solid, wanted, box).throw(path, digest)


class _Recognition:
    """Features found in one solid, in the file's frame."""

    def __init__(self, gmsh: Any, solid: int, wanted: RequestedFaces, box: Sequence[float]) -> None:
        self._gmsh, self._solid = gmsh, solid
        self._remarks: list[str] = []
        self._faces = [measured_face(gmsh, tag) for _, tag in gmsh.model.getEntities(2)]
        flat = [face for face in self._faces if face.kind == "Plane" and face.along]
        if flat:  # the kernel's box reaches beyond a cut through a spline face
            box = (
                *box[:2],
                min(face.low for face in flat),
                *box[3:5],
                max(face.high for face in flat),
            )
        self._tolerance = PLACE_TOLERANCE * (box[5] - box[2])
        self._rounds = rounds_along(self._faces, self._tolerance)
        self._left = self._end("left_end", wanted.left, box[2])
        self._right = self._end("right_end", wanted.right, box[5])
        self._low = self._left[0].low
        self._high = self._right[0].high
        self._journals = self._journal("left", self._low), self._journal("right", self._high)
        self._pins = self._find_pins(wanted.pins)
        on_axis = [
            item
            for item in self._rounds
            if item.whole and item.radius > 0.0 and math.hypot(*item.axis) < self._tolerance
        ]
        throws = len(journals_of(on_axis, self._pins, self._tolerance).throws) if self._pins else 1
        if throws > 1:
            raise InputError(
                f"pins: given a part with main journals between its pins, of {throws} throws; allowed is one "
                "throw; crankfem cad cuts a whole crankshaft into throws."
            )

    def throw(self, path: str, digest: str) -> ImportedThrow:
        """Transform them into the throw frame."""
        gmsh = self._gmsh
        x, y = self._pins[0].axis if self._pins else (0.0, 0.0)
        turn = math.atan2(x, y)
        turn = 0.0 if abs(turn) < 1e-9 else turn
        shift = 0.0 - self._low  # not minus zero
        if turn != 0.0:
            self._remarks.append(
                f"The part was turned by {amount(turn, 'rad')} about the shaft axis, so that its "
                "first pin points to +y."
            )
        row = [self._journals[0], *self._pins, self._journals[1]]
        ends = {face.tag for face in (*self._left, *self._right)}
        met = meetings(gmsh, self._solid, row, ends, self._tolerance)
        fillets, corners, radii = met.fillets, met.corners, met.radii
        reaches = [met.reach(number, item, self._faces) for number, item in enumerate(row)]
        holes = tuple(
            hole_along(item, turn, shift)
            for item in self._rounds
            if item.radius < 0.0 and item.whole
        )
        plan = planned_sizes(row, reaches, fillets, corners, radii, holes)
        names = (LEFT_JOURNAL, *map(_pin_name, range(len(self._pins))), RIGHT_JOURNAL)
        pin_axes = [turned_place(pin.axis, turn) for pin in self._pins]
        pin_axes[:1] = [(0.0, math.hypot(x, y))] * len(pin_axes[:1])
        axes = ((0.0, 0.0), *pin_axes, (0.0, 0.0))
        spans = [(low + shift, high + shift) for low, high in reaches]
        cylinders = named_cylinders(names, axes, row, spans, radii, holes)
        solid = measured_properties(gmsh, self._solid)
        throw = ImportedThrow(
            path=path,
            digest=digest,
            length=self._high - self._low,
            volume=solid.volume,
            area=sum(float(gmsh.model.occ.getMass(2, face.tag)) for face in self._faces),
            symmetry="full",
            filleted=not corners,
            turned=turn,
            shifted=shift,
            remarks=tuple(self._remarks),
            surfaces=self._named_surfaces(fillets),
            plan=plan,
            smallest=self._smallest(plan),
            holes=holes,
            curved=self._curved(fillets),
            cylinders=cylinders,
            fillets=tuple((zone, tuple(tags)) for zone, tags in fillets.items()),
            corners=tuple((zone, tuple(tags)) for zone, tags in corners.items()),
            solid=solid.turned(turn, shift),
        )
        return self._symmetric(throw)

    def _symmetric(self, throw: ImportedThrow) -> ImportedThrow:
        """Find the symmetry of the throw, if its part can be cut out; the solid is no more then."""
        angles = [math.atan2(-pin.axis[0], pin.axis[1]) for pin in self._pins]
        reach = self._low, self._high
        part = signature(self._gmsh, self._solid, *reach, angles or [0.0]).symmetry
        if part == "full":
            return throw
        try:
            throw.placed(self._gmsh, self._solid, part)
        except MeshError as error:
            remark = f"The throw seems to be symmetric but is meshed whole: {error}"
            return replace(throw, remarks=(*throw.remarks, remark))
        return replace(throw, symmetry=part)

    def _end(self, field: str, named: tuple[StepFace, ...] | None, extreme: float) -> list[Face]:
        """Plane faces of one end; all of them, for programs may cut it into several."""
        tolerance = 10.0 * self._tolerance
        for face in named or ():
            self._check_end(field, face.name, self._matching(field, face), extreme, tolerance)
        faces = [
            face
            for face in self._faces
            if face.kind == "Plane" and face.along and abs(face.low - extreme) < tolerance
        ]
        if not faces:
            raise InputError(
                f"{field}: given a part without a plane face normal to z at its "
                f"{'smallest' if field == 'left_end' else 'largest'} z; allowed is a throw along z"
                ", cut off square in the middles of its main journals; crankfem cad cuts whole crankshafts."
            )
        if named is None:
            end = field.replace("_", " ")
            self._remarks.append(
                f"The {end} was found by shape, as the plane at the end of the part."
            )
        return faces

    def _check_end(
        self, field: str, name: str, face: Face, extreme: float, tolerance: float
    ) -> None:
        if not face.along:
            raise InputError(
                f"{field}: given {name!r}, a plane that is not normal to z; allowed is one that is, because "
                "the shaft must be along z."
            )
        if abs(face.low - extreme) > tolerance:
            raise InputError(
                f"{field}: given {name!r} at z = {in_si(face.low, 'm')}; allowed is the end of the part at z "
                f"= {in_si(extreme, 'm')} (left end at the smallest, right end at the largest z)."
            )

    def _matching(self, field: str, wanted: StepFace) -> Face:
        """Find the face in gmsh by its surface and, among several on it, by its corners."""
        kind = "Plane" if wanted.kind == PLANE else "Cylinder"
        faces = [
            face
            for face in self._faces
            if face.kind == kind and same_surface(face, wanted, self._tolerance)
        ]
        if not faces:
            raise InputError(
                f"{field}: given {wanted.name!r}, a face that is not where the file's text has it; allowed "
                "is a file of the part itself, not of an assembly that moves it."
            )
        return min(faces, key=lambda face: self._distance(face, wanted))

    def _distance(self, face: Face, wanted: StepFace) -> float:
        """How far the file's corners of a face are from those in gmsh at most."""
        model = self._gmsh.model
        points = model.getBoundary([(2, face.tag)], combined=False, oriented=False, recursive=True)
        if not points or not wanted.corners:
            return math.inf
        here = np.array([model.getValue(0, tag, []) for _, tag in points])
        there = np.array(wanted.corners)
        apart = np.linalg.norm(here[:, None] - there[None], axis=2)
        return float(apart.min(axis=0).max())

    def _journal(self, side: str, end: float) -> Round:
        """The main journal that an end cuts."""
        rounds = [
            item
            for item in self._rounds
            if item.radius > 0.0
            and math.hypot(*item.axis) < self._tolerance
            and abs((item.low if side == "left" else item.high) - end) < self._tolerance
        ]
        if not rounds:
            raise InputError(
                f"{side}_end: given a part without a cylinder about the z axis at its {side} end; allowed "
                "is one whose main journals lie on the z axis."
            )
        return max(rounds, key=lambda item: item.radius)

    def _find_pins(self, named: tuple[tuple[StepFace, ...], ...] | None) -> list[Round]:
        """The pins from the left."""
        if named is None:
            pins = self._pins_by_shape()
        else:
            pins = [self._pin(faces) for faces in named]
            if len(set(pins)) < len(pins):
                raise InputError("pins: given two names for one pin; allowed is one for each pin.")
        return sorted(pins, key=lambda item: (item.low, item.axis))

    def _pins_by_shape(self) -> list[Round]:
        rounds = [
            item
            for item in self._rounds
            if item.radius > 0.0 and item.whole and math.hypot(*item.axis) > self._tolerance
        ]
        thickest = max((item.radius for item in rounds), default=0.0)
        rounds = [item for item in rounds if item.radius >= THINNEST_PIN * thickest]
        if not rounds:
            raise InputError(
                "pins: given a part without a round cylinder parallel to z beside the z axis; allowed is "
                "a throw with a crankpin."
            )
        where = "; ".join(
            f"diameter {amount(2.0 * item.radius, 'm')} at {amount(math.hypot(*item.axis), 'm')}"
            for item in rounds
        )
        self._remarks.append(
            f"The pins were found by shape, as round cylinders beside the shaft axis: {where}."
        )
        return rounds

    def _pin(self, named: tuple[StepFace, ...]) -> Round:
        """The whole of a pin of which at least one face is named."""
        name = named[0].name
        tags = {self._checked_pin(name, self._matching("pins", face)) for face in named}
        rounds = [item for item in self._rounds if tags & set(item.tags)]
        if len(rounds) > 1:
            raise InputError(
                f"pins: given {name!r} for {len(rounds)} different cylinders; allowed is one name for each "
                "pin."
            )
        return rounds[0]

    def _checked_pin(self, name: str, face: Face) -> int:
        if not face.along:
            fault, allowed = "that is not parallel to z", "one that is"
        elif face.radius < 0.0:
            fault, allowed = "that is a hole", "the outside of a crankpin"
        elif math.hypot(face.point[0], face.point[1]) < self._tolerance:
            fault, allowed = "about the shaft axis", "one beside it"
        else:
            return face.tag
        raise InputError(f"pins: given {name!r}, a cylinder {fault}; allowed is {allowed}.")

    def _smallest(self, plan: SizePlan) -> float:
        """Smallest element size on curved surfaces."""
        holes = [
            -face.radius
            for face in self._faces
            if face.kind == "Cylinder" and face.radius < 0.0 and face.turn > 3.0
        ]
        hole = max(HOLE_PER_BULK * plan.bulk, ROOT_PER_FILLET * min(holes, default=math.inf))
        return min(ROUNDED_PER_BULK * plan.bulk, hole, *(zone.size for zone in plan.zones))

    def _curved(self, fillets: dict[Zone, list[int]]) -> tuple[tuple[float, float], ...]:
        """Radii and areas of curved faces for which there are no zones."""
        zones = {tag for tags in fillets.values() for tag in tags}
        zones |= {tag for item in self._rounds if item.radius < 0.0 for tag in item.tags}
        area = self._gmsh.model.occ.getMass
        return tuple(
            (curvature_radius(self._gmsh, face.tag), float(area(2, face.tag)))
            for face in self._faces
            if face.kind != "Plane" and face.tag not in zones
        )

    def _named_surfaces(
        self, fillets: dict[Zone, list[int]]
    ) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Give every face of the solid a name."""
        names = {face.tag: LEFT_END for face in self._left}
        names |= {face.tag: RIGHT_END for face in self._right}
        for number, pin in enumerate(self._pins):
            names |= dict.fromkeys(pin.tags, _pin_name(number))
        for item in self._rounds:
            if item.radius < 0.0 and item.whole:
                names |= dict.fromkeys(item.tags, BORE)
        for journal in self._journals:
            names |= dict.fromkeys(journal.tags, MAIN_JOURNAL)
        names |= {tag: FILLET for tags in fillets.values() for tag in tags}
        for face in self._faces:
            names.setdefault(face.tag, FILLET if face.kind == "Torus" else WEB)
        order = [
            LEFT_END,
            RIGHT_END,
            *(_pin_name(number) for number in range(len(self._pins))),
            MAIN_JOURNAL,
            FILLET,
            WEB,
            BORE,
        ]
        return tuple(
            (name, tuple(sorted(tag for tag, surface in names.items() if surface == name)))
            for name in order
            if name != BORE or BORE in names.values()
        )


def _pin_name(number: int) -> str:
    return PIN if number == 0 else f"{PIN} {number + 1}"
