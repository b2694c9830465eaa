"""Tell a crankshaft from other solids by its shape: the axis, main journals, pins, throws.

The shaft axis is, of parallel lines, the one with most whole outer cylinders on it that has pins beside it.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from crankbase.array_checks import Array
from geometry.faces import Face, Round, rounds_along

# Places are told apart to this share of the solid's size, directions of axes to this sine.
PLACE, DIRECTION = 1e-4, 1e-3
# Of cylinders beside the axis, those thinner than this share of the thickest are bolts and the like.
THINNEST_PIN = 0.5
# A disk web holds its pin, so it is at least so many pin radii thicker about the axis than the crank radius.
DISK = 0.5


@dataclass(frozen=True)
class Line:
    """Whole outer cylinders on one line, and pins beside it, in a frame whose z axis is along the line.

    Attributes
    ----------
    rotation : (3, 3) array
        Its rows are the axes of that frame in the solid's.
    axis : (x, y)
        Place of the line there.
    rounds, pins : tuple of Round
        In their order along it.
    fault : str
        Why what is beside the line are no crankpins; empty if they are.
    """

    rotation: Array
    axis: tuple[float, float]
    rounds: tuple[Round, ...]
    pins: tuple[Round, ...]
    fault: str

    @property
    def rank(self) -> tuple[int, float]:
        """By which the lines of one solid are compared: most cylinders, the longest reach."""
        return len(self.rounds), self.rounds[-1].high - self.rounds[0].low


def crank_line(faces: Sequence[Face], size: float) -> Line | str:
    """Find the shaft axis of a solid, or say what the solid is instead.

    Parameters
    ----------
    faces : sequence of Face
        Of the solid.
    size : float
        Of the solid, in the same unit.
    """
    cylinders = [face for face in faces if face.kind == "Cylinder"]
    lines = [line for rotation in _frames(cylinders) for line in _lines(cylinders, rotation, size)]
    cranks = [line for line in lines if line.pins and not line.fault]
    if cranks:
        return max(cranks, key=lambda line: line.rank)
    faults = [line for line in lines if line.fault]
    if faults:
        return max(faults, key=lambda line: line.rank).fault
    if not any(face.radius > 0.0 for face in cylinders):
        flat = sum(face.kind == "Plane" for face in faces)
        return f"{len(faces)} faces, {flat} of them plane, and no outer cylinder"
    most = max((len(line.rounds) for line in lines), default=0)
    if most == 0:
        return "outer cylinders, none of which is whole"
    return f"{most} whole outer cylinder{'s' * (most > 1)} on one line, and no crankpin beside it"


def _frames(cylinders: Sequence[Face]) -> Iterator[Array]:
    """Frames along the directions of outer cylinders."""
    directions: list[list[Face]] = []
    for face in sorted(cylinders, key=_size, reverse=True):
        if face.radius > 0.0:
            for group in directions:
                if np.linalg.norm(np.cross(group[0].axis, face.axis)) < DIRECTION:
                    group.append(face)
                    break
            else:
                directions.append([face])
    for group in directions:
        first = group[0].axis
        mean = sum(
            _size(face) * math.copysign(1.0, face.axis @ first) * face.axis for face in group
        )
        yield frame_along(np.asarray(mean))


def _size(face: Face) -> float:
    """About the area of a cylinder's face."""
    return abs(face.radius) * face.turn * float(np.ptp(face.points @ face.axis))


def frame_along(direction: Array) -> Array:
    """Return axes x, y, z as rows, with z along a direction."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def _lines(cylinders: Sequence[Face], rotation: Array, size: float) -> Iterator[Line]:
    near = PLACE * size
    faces = [face.placed(rotation, np.zeros(3)) for face in cylinders]
    whole = [item for item in rounds_along(faces, near) if item.radius > 0.0 and item.whole]
    rows: list[list[Round]] = []
    for item in whole:
        for row in rows:
            if math.dist(row[0].axis, item.axis) < near:
                row.append(item)
                break
        else:
            rows.append([item])
    for row in rows:
        beside = [item for item in whole if item not in row]
        yield _line(rotation, sorted(row, key=lambda item: item.low), beside, near)


def _line(rotation: Array, row: list[Round], beside: list[Round], near: float) -> Line:
    """Look for pins beside a line."""
    axis = row[0].axis
    free = [
        item
        for item in beside
        if not any(other.low < item.middle < other.high for other in row)
        and math.dist(item.axis, axis) > 3.0 * near
    ]
    pins = [item for item in free if row[0].low < item.middle < row[-1].high]
    thickest = max((item.radius for item in pins), default=0.0)
    pins = sorted(
        (item for item in pins if item.radius > THINNEST_PIN * thickest), key=lambda item: item.low
    )
    thinnest = min(item.radius for item in row)
    eccentric = [item for item in pins if math.dist(item.axis, axis) <= item.radius - thinnest]
    fault = ""
    if any(after.low < before.high - 3.0 * near for before, after in pairwise(pins)):
        fault = (
            f"{len(pins)} parallel cylinders side by side, as studs are, not one behind the other"
        )
    elif eccentric:
        fault = (
            f"{len(eccentric)} eccentric{'s' * (len(eccentric) > 1)} that hold the shaft within them, as "
            "those of cams and pumps do, not crankpins"
        )
    elif len(pins) < len(free) and not pins and len(row) > 1:
        fault = (
            f"an overhung crank: {len(free)} cylinder{'s' * (len(free) > 1)} beside the axis, beyond the "
            "last main journal and not between two"
        )
    return Line(rotation, axis, tuple(row), () if fault else tuple(pins), fault)


@dataclass(frozen=True)
class Journals:
    """Main journals between which the pins of each throw are, in the shaft's frame.

    Attributes
    ----------
    mains : tuple of Round
        From the left; one more than there are throws.
    throws : tuple of tuples of Round
        The pins of each throw.
    """

    mains: tuple[Round, ...]
    throws: tuple[tuple[Round, ...], ...]


def journals_of(rounds: Sequence[Round], pins: Sequence[Round], near: float) -> Journals:
    """Find the main journals: the longest cylinder between two pins, and at the ends its likes.

    Parameters
    ----------
    rounds, pins : sequences of Round
        On the shaft axis, and beside it.
    near : float
        Lengths are told apart so far.
    """
    pins = sorted(pins, key=lambda pin: pin.low)
    thickest = min(pin.offset + DISK * pin.radius for pin in pins)
    slender = [item for item in rounds if item.radius < thickest]
    throws: list[list[Round]] = [[pins[0]]]
    inner: list[Round] = []
    for before, after in pairwise(pins):
        between = [item for item in slender if before.high < item.middle < after.low]
        if between:
            inner.append(_journal(between, near))
            throws.append([])
        throws[-1].append(after)
    left = [item for item in slender if item.middle < pins[0].low][::-1]
    right = [item for item in slender if item.middle > pins[-1].high]
    radius = float(np.median([item.radius for item in inner])) if inner else None
    ends = []
    for side in (left, right):
        alike = [item for item in side if radius is None or abs(item.radius - radius) < near]
        beside = (alike or side)[:1]
        if not beside:
            return Journals((), ())
        # An oil groove divides a journal: what is beyond a narrow one belongs to it.
        journal = beside[0]
        gap = max(0.25 * journal.radius, near)
        for item in side:
            apart = min(abs(item.low - journal.high), abs(journal.low - item.high))
            alike_radius = abs(item.radius - journal.radius) < near
            if item is not journal and alike_radius and apart < gap:
                beside.append(item)
        ends.append(_journal(beside, near))
    return Journals((ends[0], *inner, ends[1]), tuple(map(tuple, throws)))


def _journal(rounds: Sequence[Round], near: float) -> Round:
    """Join the parts of the longest cylinder that grooves divide."""
    longest = max(rounds, key=lambda item: item.high - item.low)
    parts = [item for item in rounds if abs(item.radius - longest.radius) < near]
    tags = tuple(tag for item in parts for tag in item.tags)
    return Round(
        longest.axis,
        longest.radius,
        min(item.low for item in parts),
        max(item.high for item in parts),
        longest.turn,
        tags,
        max(item.deviation for item in parts),
    )


def usual_cuts(mains: Sequence[Round], reaches: Sequence[tuple[float, float]]) -> list[float]:
    """Places of the cuts: in the middles of main journals, at the ends as far from the web as inside.

    Parameters
    ----------
    mains : sequence of Round
        From `journals_of`.
    reaches : sequence of (start, end)
        Of each, fillets included.
    """
    middles = [0.5 * (low + high) for low, high in reaches]
    if len(mains) > 2:
        (first, start), (last, end) = reaches[0], reaches[-1]
        inner = 0.5 * (reaches[1][1] - reaches[1][0]), 0.5 * (reaches[-2][1] - reaches[-2][0])
        middles[0] = max(start - inner[0], first)
        middles[-1] = min(last + inner[1], end)
    return middles
