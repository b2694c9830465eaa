"""A crankshaft from CAD: what it is, and compliance and mass of its throws, each kind analyzed once."""

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import MeshError
from crankbase.results import Internal, Part, Quantity, Result, result
from crankbase.sentences import amount, angle, finished, joined
from crankbase.table import Column, Main, Table
from dynamics.crankshaft.shaft_modes import ShaftMode
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.material import STEEL, Material
from geometry.equal_pieces import EQUAL
from geometry.imported import ImportedThrow
from geometry.imported_shaft import EndPart, ImportedCrankshaft, ShaftCylinder, import_crankshaft
from geometry.mass import MassProperties
from geometry.solids_in_file import SolidInFile

Metre = Annotated[float, Quantity("m")]
Kilogram = Annotated[float, Quantity("kg")]
Inertia = Annotated[float, Quantity("kg m^2", "about the shaft axis")]
# Names of the end parts.
FREE_END, FLANGE = "free end", "flange end"


@result("number", "angle_deg", "mass", "axial_compliance", "torsional_compliance")
class ThrowOfShaft(Result):
    """A throw of the crankshaft; compliances are those of pinned ends, None without finite elements.

    Attributes
    ----------
    start : float
        Along the shaft, from the first cut.
    symmetry : str
        Smallest part that stands for it: "quarter", "half" or "full".
    like, change : int, str
        First throw of its kind, perhaps itself, and how that becomes it.
    file : str or None
        STEP file of the kind, if it was to be kept.
    """

    number: int
    angle_deg: Annotated[float, Quantity("deg", "of its first pin about +z")]
    start: Metre
    length: Metre
    mass: Kilogram
    center: Annotated[Array, Quantity("m", "in the shaft's frame (3,)")]
    inertia_about_shaft: Inertia
    symmetry: str
    like: int
    change: str
    axial_compliance: Annotated[float | None, Quantity("m/N")]
    axial_error: Annotated[float | None, Quantity("m/N", "estimated")]
    torsional_compliance: Annotated[float | None, Quantity("rad/(N m)")]
    torsional_error: Annotated[float | None, Quantity("rad/(N m)", "estimated")]
    file: str | None


@result("name", "length", "mass", "inertia_about_shaft")
class EndOfShaft(Result):
    """What is beyond the first or the last cut; stiffnesses are those from the cut to its far face.

    Attributes
    ----------
    remark : str
        Why there are no stiffnesses, which finite elements alone give; empty if there are.
    """

    name: str
    start: Metre
    length: Metre
    mass: Kilogram
    inertia_about_shaft: Inertia
    torsional_stiffness: Annotated[float | None, Quantity("N m/rad")]
    axial_stiffness: Annotated[float | None, Quantity("N/m")]
    remark: str


@result("file", "solid", "throws", "ends")
class CadRun(Result):
    """All results for a crankshaft from CAD.

    Attributes
    ----------
    free_modes : tuple of ShaftMode
        The lowest of the whole crankshaft, free in space, if they were asked for.
    axis, origin : arrays (3,)
        Direction of the shaft from the free end to the flange, and center of the first cut, in the file.
    journals, pins, bores : tuple of ShaftCylinder
        Of the whole shaft, along it from the first cut.
    """

    shaft: Internal[ImportedCrankshaft]
    analyses: Internal[Mapping[int, ThrowAnalysis]]
    material: Material
    throws: tuple[ThrowOfShaft, ...]
    ends: tuple[EndOfShaft, ...]
    free_modes: tuple[ShaftMode, ...]

    @property
    def file(self) -> Part[str]:
        """The STEP file."""
        return self.shaft.path

    @property
    def unit(self) -> Metre:
        """Its unit of length."""
        return self.shaft.unit

    @property
    def solid(self) -> Part[str]:
        """Name of the crankshaft among its solids."""
        return self.shaft.solid

    @property
    def solids(self) -> Part[tuple[SolidInFile, ...]]:
        """All solids of the file."""
        return self.shaft.solids

    @property
    def axis(self) -> Annotated[Array, Quantity("1")]:
        """Direction of the shaft in the file."""
        return np.asarray(self.shaft.axes[2])

    @property
    def origin(self) -> Annotated[Array, Quantity("m")]:
        """Center of the first cut in the file."""
        return self.shaft.origin

    @property
    def journals(self) -> Part[tuple[ShaftCylinder, ...]]:
        """Main journals."""
        return self.shaft.journals

    @property
    def pins(self) -> Part[tuple[ShaftCylinder, ...]]:
        """Crankpins."""
        return self.shaft.pins

    @property
    def bores(self) -> Part[tuple[ShaftCylinder, ...]]:
        """Round holes along the shaft."""
        return self.shaft.bores

    @property
    def remarks(self) -> Part[tuple[str, ...]]:
        """How the file was understood."""
        return self.shaft.remarks

    @property
    def files(self) -> list[str]:
        """STEP files of the throws, without repetition."""
        return list(dict.fromkeys(throw.file for throw in self.throws if throw.file is not None))

    @property
    def mass(self) -> Kilogram:
        """Of the whole crankshaft."""
        return sum(throw.mass for throw in self.throws) + sum(end.mass for end in self.ends)

    def parts(self) -> Iterator[Table | str]:
        """Return tables and sentences for a console, the throws last."""
        if len(self.solids) > 1:
            yield self.solid_table()
        yield self.cylinder_table()
        if self.bores:
            yield _cylinders("Bores along the shaft", self.bores, "bore")
        yield from self.remarks
        yield Main(self.sentence())
        if self.ends:
            yield self.end_table()
        yield from (end.remark for end in self.ends if end.remark)
        if self.free_modes:
            yield self.mode_table()
        yield self.throw_table()

    def sentence(self) -> str:
        """Say what was found."""
        of_kind = len({throw.like for throw in self.throws})
        kinds = "all of one kind" if of_kind == 1 else f"of {of_kind} kinds"
        angles = joined(", ", [angle(throw.angle_deg) for throw in self.throws])
        count = len(self.throws)
        throws = f"{count} throws, {kinds}, at {angles}" if count > 1 else "one throw"
        return finished(
            f"Solid {self.solid!r} is the crankshaft: {throws}; mass {amount(self.mass, 'kg', 5)}."
        )

    def solid_table(self) -> Table:
        """Return the solids of the file."""
        return Table.of_records(
            "Solids in the file",
            self.solids,
            (Column("solid", words=True), "name"),
            (Column("volume", "dm^3"), "volume"),
            (Column("center x y z", "mm", joint="  "), lambda solid: [*solid.center]),
            (
                Column("size x y z", "mm", joint="  "),
                lambda solid: [high - low for low, high in zip(solid.low, solid.high, strict=True)],
            ),
            (Column("what it is", words=True), lambda solid: solid.what or "a crankshaft"),
            main=True,
        )

    def cylinder_table(self) -> Table:
        """Return main journals and pins in their order along the shaft."""
        named = [
            *((f"main {number}", item) for number, item in enumerate(self.journals, start=1)),
            *((f"pin {number}", item) for number, item in enumerate(self.pins, start=1)),
        ]
        rows = sorted(named, key=lambda pair: pair[1].start)
        return _cylinders("Main journals and pins", *zip(*[(i, n) for n, i in rows], strict=True))

    def end_table(self) -> Table:
        """Return the end parts."""
        stiffnesses = (
            (Column("torsional stiffness", "N m/rad"), "torsional_stiffness"),
            (Column("axial stiffness", "N/m"), "axial_stiffness"),
        )
        return Table.of_records(
            "Beyond the outer cuts",
            self.ends,
            (Column("part", words=True), "name"),
            (Column("length", "mm"), "length"),
            (Column("mass", "kg"), "mass"),
            (Column("inertia", "kg m^2"), "inertia_about_shaft"),
            *(stiffnesses if self.analyses else ()),
            main=True,
        )

    def mode_table(self) -> Table:
        """Return the free modes of the whole crankshaft."""
        return Table.of_records(
            "Free in space, elastic modes",
            self.free_modes,
            (Column("frequency", "Hz", 5), "frequency"),
            (Column("motion", words=True), "label"),
            main=True,
        )

    def throw_table(self) -> Table:
        """Return the throws with their compliances."""
        compliances = (
            (Column("e_n", "1e-9 m/N"), "axial_compliance"),
            (Column("torsional", "1e-9 rad/(N m)"), "torsional_compliance"),
        )
        return Table.of_records(
            "Throws, ends pinned" if self.analyses else "Throws",
            self.throws,
            (Column("throw"), "number"),
            (Column("angle", "deg", digits=None), lambda throw: math.radians(throw.angle_deg)),
            (Column("start", "mm", 5), "start"),
            (Column("length", "mm", 5), "length"),
            (Column("mass", "kg", 5), "mass"),
            (Column("kind", words=True), _kind),
            (Column("symmetry", words=True), "symmetry"),
            *(compliances if self.analyses else ()),
            main=True,
        )


def _kind(throw: ThrowOfShaft) -> str:
    """Name the kind of a throw by the first one of it."""
    return str(throw.like) if throw.change == EQUAL else f"{throw.like} {throw.change}"


def run_cad(
    path: str | Path,
    *,
    solid: str | None = None,
    free_end: str | None = None,
    cuts: Mapping[int, float] | None = None,
    folder: Path | None = None,
    accuracy: float | None = 0.01,
    free: int = 0,
    material: Material = STEEL,
    on_step: Callable[[str], None] | None = None,
) -> CadRun:
    """Read a crankshaft and analyze its throws.

    Parameters
    ----------
    path, solid, free_end, cuts, folder, on_step
        As for `import_crankshaft`.
    accuracy : float or None
        Of the axial compliance; None for no finite elements.
    free : int
        How many free modes of the whole crankshaft to find, which takes finite elements.

    Raises
    ------
    InputError, MeshError, SolveError
        If the file cannot be used, or a throw cannot be analyzed.
    """
    tell = on_step or (lambda _: None)
    shaft = import_crankshaft(
        path, solid=solid, free_end=free_end, cuts=cuts, folder=folder, on_step=tell
    )
    analyses: dict[int, ThrowAnalysis] = {}
    for number, (throw, (like, _)) in enumerate(
        zip(shaft.throws, shaft.like, strict=True), start=1
    ):
        if accuracy is not None and like == number:
            tell(f"Analyzing throw {number}")
            analyses[number] = analyze_throw(throw, material, accuracy)
    parts = {} if accuracy is None else end_analyses(shaft, accuracy, material, tell)
    modes: tuple[ShaftMode, ...] = ()
    if free and accuracy is not None:
        # Which imports what an engine file takes.
        from crankfem.satellites.cad.free_shaft import free_modes

        known = {shaft.throws[number - 1]: analysis for number, analysis in analyses.items()}
        free_shaft = free_modes(shaft, known | parts, free, accuracy, material, tell)
        modes = tuple(map(free_shaft.described, range(free_shaft.rigid, free_shaft.rigid + free)))
    masses = shaft.masses(material.density)
    throws = tuple(
        _throw(shaft, number, mass, analyses.get(shaft.like[number][0]), folder is not None)
        for number, mass in enumerate(masses)
    )
    ends = [
        _end(name, end, material.density, None if end.part is None else parts.get(end.part))
        for name, end in zip((FREE_END, FLANGE), shaft.ends, strict=True)
        if end is not None
    ]
    return CadRun(shaft, analyses, material, throws, tuple(ends), modes)


def end_analyses(
    shaft: ImportedCrankshaft,
    accuracy: float = 0.01,
    material: Material = STEEL,
    tell: Callable[[str], None] = lambda _: None,
) -> dict[ImportedThrow, ThrowAnalysis]:
    """Analyze what is beyond the outer cuts, as throws without pins; a part that cannot be is left out.

    Parameters
    ----------
    accuracy : float
        Of the axial compliance.
    tell : callable
        Called with the name of each step.
    """
    analyses = {}
    for end, name in zip(shaft.ends, (FREE_END, FLANGE), strict=True):
        if end is not None and end.part is not None:
            tell(f"Analyzing the {name}")
            try:
                analyses[end.part] = analyze_throw(end.part, material, accuracy)
            except MeshError:
                continue
    return analyses


def _throw(
    shaft: ImportedCrankshaft,
    place: int,
    mass: MassProperties,
    analysis: ThrowAnalysis | None,
    kept: bool,
) -> ThrowOfShaft:
    bars = None if analysis is None else analysis.error_bars()
    like, change = shaft.like[place]
    return ThrowOfShaft(
        number=place + 1,
        angle_deg=shaft.angles_deg[place],
        start=shaft.starts[place],
        length=shaft.starts[place + 1] - shaft.starts[place],
        mass=mass.mass,
        center=mass.center,
        inertia_about_shaft=mass.inertia_about_shaft,
        symmetry=shaft.symmetries[place],
        like=like,
        change=change,
        axial_compliance=None if analysis is None else analysis.axial_compliance(),
        axial_error=None if bars is None else bars.axial,
        torsional_compliance=None if analysis is None else analysis.torsional_compliance(),
        torsional_error=None if bars is None else bars.torsional,
        file=shaft.throws[place].path if kept else None,
    )


def _end(name: str, end: EndPart, density: float, analysis: ThrowAnalysis | None) -> EndOfShaft:
    masses = end.masses(density)
    return EndOfShaft(
        name,
        end.low,
        end.high - end.low,
        masses.mass,
        masses.inertia_about_shaft,
        None if analysis is None else 1.0 / analysis.torsional_compliance(),
        None if analysis is None else 1.0 / analysis.axial_compliance(),
        f"The {name} counts as rigid: {end.fault}" if end.fault else "",
    )


def _cylinders(title: str, items: tuple[ShaftCylinder, ...], names: tuple[str, ...] | str) -> Table:
    called = (
        [f"{names} {number}" for number in range(1, len(items) + 1)]
        if isinstance(names, str)
        else list(names)
    )
    return Table.of_records(
        title,
        list(zip(called, items, strict=True)),
        (Column("", words=True), lambda row: row[0]),
        (Column("diameter", "mm", 6), lambda row: row[1].diameter),
        (Column("start", "mm", 6), lambda row: row[1].start),
        (Column("length", "mm", 5), lambda row: row[1].length),
        (Column("off axis", "mm", 6), lambda row: row[1].crank_radius),
        (Column("angle", "deg", digits=None), lambda row: math.radians(row[1].angle_deg)),
        (
            Column("fillets", "mm", 3, joint="  "),
            lambda row: [row[1].start_fillet, row[1].end_fillet],
        ),
        (Column("deviation", "um", 2), lambda row: row[1].deviation),
        main=True,
    )
