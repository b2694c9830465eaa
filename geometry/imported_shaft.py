"""A crankshaft from a STEP file as CAD programs write it, cut into its throws."""

import atexit
import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated
from uuid import uuid4

import numpy as np

from crankbase.array_checks import Array
from crankbase.calls import ProcessLostError
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.outputs import write_errors, write_text
from crankbase.processes import once_per_process, scratch_folder
from crankbase.results import Quantity, Result, result
from crankbase.sentences import amount, with_sentences
from crankbase.summaries import summarized
from geometry.gmsh_session import IsolatedProcess, shared_process
from geometry.imported import TIME_LIMIT, ImportedThrow, RequestedFaces, file_content
from geometry.mass import MassProperties, solid_mass_properties
from geometry.shaft_cuts import (
    GIVEN,
    HIGH,
    LOW,
    THICKER,
    CutShaft,
    FoundCylinder,
    Piece,
    angle_of,
)
from geometry.solids_in_file import SolidInFile
from geometry.step_file import CYLINDER, StepFace, read_step

# Names of the files with the throws and the end parts.
THROW_FILE = "throw-{}.step"
FREE_END_FILE, FLANGE_FILE = "free-end.step", "flange-end.step"
# Angles are round to so many decimals; the kernel's round-off is below [deg].
ANGLE_DECIMALS = 9
# Of the usual units of length [m].
UNIT_NAMES = {1e-3: "mm", 1e-2: "cm", 1.0: "m", 0.0254: "the inch", 0.3048: "the foot"}


@result("diameter", "start", "end", "crank_radius", "angle_deg")
class ShaftCylinder(Result):
    """A main journal, crankpin or bore of a crankshaft, z from the first cut.

    Attributes
    ----------
    start, end : float
        Along the shaft, fillets included.
    """

    diameter: Annotated[float, Quantity("m")]
    start: Annotated[float, Quantity("m")]
    end: Annotated[float, Quantity("m")]
    crank_radius: Annotated[float, Quantity("m", "distance of its axis from the shaft's")]
    angle_deg: Annotated[float, Quantity("deg", "of its axis about +z from the first pin")]
    start_fillet: Annotated[float, Quantity("m", "radius; 0 for a sharp corner")]
    end_fillet: Annotated[float, Quantity("m", "radius; 0 for a sharp corner")]
    deviation: Annotated[float, Quantity("m", "largest, of its faces from the cylinder")]

    @property
    def length(self) -> Annotated[float, Quantity("m")]:
        """Its length, fillets included."""
        return self.end - self.start


@dataclass(frozen=True)
class EndPart:
    """What is beyond the first or the last cut.

    Attributes
    ----------
    low, high : float
        Reach along the shaft, z from the first cut [m].
    part : ImportedThrow or None
        The part by itself, as a throw without pins, for `analyze_throw`.
    fault : str
        Why there is none; empty if there is one.
    """

    low: float
    high: float
    part: ImportedThrow | None
    fault: str
    _piece: Piece = field(repr=False)

    def masses(self, density: float) -> MassProperties:
        """Mass, center and inertia, z from the first cut [kg, m, kg m^2]."""
        return _masses(self._piece, density)


@with_sentences
@summarized("path", "solid", "unit [m]", "throws", "angles_deg [deg]", "remarks")
@dataclass(frozen=True)
class ImportedCrankshaft:
    """A crankshaft whose solid is in a STEP file, and its throws.

    Attributes
    ----------
    path : str
        The file.
    unit : float
        Its unit of length [m].
    solids : tuple of SolidInFile
        All solids of the file.
    solid : str
        Name of the crankshaft among them.
    axes : (3, 3) array
        The shaft's x, y, z axes in the file's frame as rows: z from the free end to the flange, y to
        the first pin.
    origin : (3,) array
        Center of the first cut there [m].
    throws : tuple of ImportedThrow
        From the free end, each in its own frame; equal ones are the same object.
    angles_deg : tuple of float
        Angle of each throw's first pin about +z from that of the first throw.
    starts : tuple of float
        Where the throws begin, and the last one ends [m].
    like : tuple of (int, str)
        Number of the first throw, from 1, of which each is a copy, and how: "equal", "reversed" (end for
        end), "mirrored" or both.
    symmetries : tuple of str
        Smallest part that stands for each throw: "quarter", "half" or "full".
    journals, pins, bores : tuple of ShaftCylinder
    ends : (EndPart or None, EndPart or None)
        At free end and flange; None where the shaft ends with a cut.
    remarks : tuple of str
        How it was understood.
    """

    path: str
    unit: float
    solids: tuple[SolidInFile, ...]
    solid: str
    axes: Array
    origin: Array
    throws: tuple[ImportedThrow, ...]
    angles_deg: tuple[float, ...]
    starts: tuple[float, ...]
    like: tuple[tuple[int, str], ...]
    symmetries: tuple[str, ...]
    journals: tuple[ShaftCylinder, ...]
    pins: tuple[ShaftCylinder, ...]
    bores: tuple[ShaftCylinder, ...]
    ends: tuple[EndPart | None, EndPart | None]
    remarks: tuple[str, ...]
    _pieces: tuple[Piece, ...] = field(repr=False)

    def masses(self, density: float) -> tuple[MassProperties, ...]:
        """Mass, center and inertia of each throw from its solid, in the shaft's frame.

        Parameters
        ----------
        density : float
            [kg/m^3]
        """
        return tuple(_masses(piece, density) for piece in self._pieces)


def _masses(piece: Piece, density: float) -> MassProperties:
    return solid_mass_properties(piece.solid, "full", piece.high - piece.low, density)


def import_crankshaft(
    path: str | Path,
    *,
    solid: str | None = None,
    free_end: str | None = None,
    cuts: Mapping[int, float] | None = None,
    folder: str | Path | None = None,
    on_step: Callable[[str], None] | None = None,
    process: IsolatedProcess | None = None,
) -> ImportedCrankshaft:
    """Read a crankshaft from a STEP file, and cut it into throws in the middles of its main journals.

    The crankshaft may be anywhere in the file, in any direction and unit, beside other solids. The shaft axis
    is, of parallel lines, the one with most whole outer cylinders on it and pins beside it. The flange is the
    end with the thicker cylinder. The outer cuts are as far from the webs as the inner ones. Lengths along
    the shaft count from the first cut.

    Parameters
    ----------
    path : str or Path
        A STEP file with one crankshaft, which is one solid.
    solid : str, optional
        Name or number of the crankshaft, if there are several.
    free_end : {"low", "high"}, optional
        The free end, if it is not the thinner one: that with the low or the high coordinate in the file,
        along the axis' main direction.
    cuts : mapping of int to float, optional
        By how much cuts, counted from 1, are moved towards the flange [m].
    folder : str or Path, optional
        Where the throws' STEP files go; by default a folder that is removed with this process.
    on_step : callable, optional
        Called with the name of each step.
    process : IsolatedProcess, optional
        Process for gmsh; by default the one shared in this process.

    Raises
    ------
    InputError
        If the file has no such crankshaft, or it cannot be cut.
    MeshError
        If the kernel fails.

    Examples
    --------
    >>> shaft = import_crankshaft("crank.step")  # doctest: +SKIP
    >>> shaft.angles_deg  # doctest: +SKIP
    (0.0, 180.0, 180.0, 0.0)
    """
    if free_end is not None:
        check_choice(
            "free_end", free_end, (LOW, HIGH), "these are the ends of the shaft in the file"
        )
    content = file_content(Path(path))
    path = Path(path).resolve()
    unit = read_step(content, str(path)).unit
    process = shared_process() if process is None else process
    tell = on_step or (lambda _: None)
    try:
        cut: CutShaft = process.call(
            "geometry.shaft_cuts:cut_shaft",
            str(path),
            solid,
            free_end,
            dict(cuts or {}),
            time_limit=TIME_LIMIT,
            on_remark=tell,
        )
        into = _scratch() / uuid4().hex if folder is None else Path(folder)
        with write_errors(into):
            into.mkdir(parents=True, exist_ok=True)
        throws: list[ImportedThrow] = []
        for number, piece in enumerate(cut.throws):
            if piece.copied is not None:
                throws.append(throws[piece.copied])
                continue
            tell(f"Reading throw {number + 1}")
            throws.append(_imported(cut, piece, into / THROW_FILE.format(number + 1), process))
        beyond = ((cut.free_end, FREE_END_FILE), (cut.flange_end, FLANGE_FILE))
        free, flange = (_end(cut, piece, into / name, process) for piece, name in beyond)
    except ProcessLostError as error:
        raise InputError(f"{path}: given a file that cannot be read: {error}.") from None
    pieces = cut.throws
    angles = [
        round(math.degrees(angle_of(cut.pins[piece.pins[0]].axis)), ANGLE_DECIMALS) % 360.0
        for piece in pieces
    ]
    return ImportedCrankshaft(
        path=str(path),
        unit=unit,
        solids=cut.solids,
        solid=cut.solids[cut.chosen].name,
        axes=cut.rotation,
        origin=cut.origin,
        throws=tuple(throws),
        angles_deg=tuple(angles),
        starts=(*(piece.low for piece in pieces), pieces[-1].high),
        like=tuple((piece.like + 1, piece.change) for piece in pieces),
        symmetries=tuple(throw.symmetry for throw in throws),
        journals=tuple(map(_cylinder, cut.mains)),
        pins=tuple(map(_cylinder, cut.pins)),
        bores=tuple(map(_cylinder, cut.bores)),
        ends=(free, flange),
        remarks=_remarks(cut, unit, throws),
        _pieces=pieces,
    )


@once_per_process
def _scratch() -> Path:
    """A folder that is removed with this process."""
    stack = ExitStack()
    atexit.register(stack.close)
    return stack.enter_context(scratch_folder())


def _imported(cut: CutShaft, piece: Piece, file: Path, process: IsolatedProcess) -> ImportedThrow:
    """Write a throw or an end part and read it, its pins where they were found."""
    with write_errors(file):
        write_text(file, piece.text, "solid")
    pins = [cut.pins[number] for number in piece.pins]
    turn = -angle_of(pins[0].axis) if pins else 0.0
    cosine, sine = math.cos(turn), math.sin(turn)
    faces = []
    for number, pin in enumerate(pins):
        x, y = pin.axis
        x, y = cosine * x - sine * y, sine * x + cosine * y
        middle = (x, y, 0.5 * (pin.start + pin.end) - piece.low)
        faces.append(
            (
                StepFace(
                    f"pin {number + 1}",
                    CYLINDER,
                    middle,
                    (0.0, 0.0, 1.0),
                    0.5 * pin.diameter,
                    (middle,),
                ),
            )
        )
    throw: ImportedThrow = process.call(
        "geometry.recognition:recognize",
        str(file.resolve()),
        hashlib.sha256(piece.text.encode()).hexdigest(),
        RequestedFaces(None, None, tuple(faces)),
        time_limit=TIME_LIMIT,
    )
    return throw


def _end(
    cut: CutShaft, piece: Piece | None, file: Path, process: IsolatedProcess
) -> EndPart | None:
    if piece is None:
        return None
    try:
        part, fault = _imported(cut, piece, file, process), ""
    except InputError as error:
        part, fault = None, str(error)
    return EndPart(piece.low, piece.high, part, fault, piece)


def _cylinder(found: FoundCylinder) -> ShaftCylinder:
    radius = math.hypot(*found.axis)
    angle = math.degrees(angle_of(found.axis)) if radius > 1e-9 else 0.0
    return ShaftCylinder(
        found.diameter,
        found.start,
        found.end,
        radius,
        round(angle, ANGLE_DECIMALS) % 360.0,
        *found.fillets,
        found.deviation,
    )


def _remarks(cut: CutShaft, unit: float, throws: Sequence[ImportedThrow]) -> tuple[str, ...]:
    """Say how the file was understood."""
    axis = cut.rotation[2]
    main = int(np.argmax(np.abs(axis)))
    way = f"{'+' if axis[main] > 0.0 else '-'}{'xyz'[main]}"
    along = f"along {way}" if abs(axis[main]) > 1.0 - 1e-9 else f"near {way}"
    ends = {THICKER: "the flange is the thicker end", GIVEN: "the free end was given"}
    why = ends.get(cut.flange_by, "both ends are equally thick, and it has the higher coordinate")
    remarks = [
        f"The file's unit of length is {UNIT_NAMES.get(round(unit, 9)) or amount(unit, 'm')}.",
        f"The shaft axis, from the free end to the flange, is {along} in the file: {why}.",
    ]
    if cut.off_line > 1e-6:
        remarks.append(
            f"Main journals are off the shaft axis by up to {amount(cut.off_line, 'm', 3)}."
        )
    if cut.crossing:
        remarks.append(f"{cut.crossing} faces of oil holes cross journals, pins or webs.")
    if cut.splines:
        remarks.append(
            "The solid has spline faces: masses are from meshes of its surface; with analytic ones all is "
            "faster."
        )
    for number, (piece, throw) in enumerate(zip(cut.throws, throws, strict=True), start=1):
        # A symmetry of the piece that its throw cannot use.
        if piece.copied is None and piece.symmetry != throw.symmetry:
            remarks.append(f"Throw {number}: {throw.remarks[-1]}")
    return tuple(remarks)
