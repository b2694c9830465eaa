"""A throw's compliances, reactions and masses: what console, JSON and report show."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.diagrams import COLORS, figure, legend_below, write_title
from crankbase.errors import InputError, MeshError
from crankbase.quantity import percent
from crankbase.results import Number, Quantity, Result, made_from, result
from crankbase.sentences import amount
from crankbase.table import SI, Column, Main, OutputUnits, Table
from crankfem.analyses.throw.law_record import LawResults
from fem.analysis import ThrowAnalysis, axial_correction
from fem.end_reactions import Reactions
from fem.material import Material
from fem.sensitivities import Sensitivities
from fem.solver import asymmetry
from fem.superelement import superelement_of_end_forces
from fem.supports import Compliances, Neighbors, Support, reactions
from fem.symmetry import Sections
from geometry.any_throw import Throw
from geometry.boundary_motion import lengths_of
from geometry.mass import Unbalance, unbalance
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fem.modes import ThrowModes
    from regression.models.lookup import ReactionLookup

Metre = Annotated[float, Quantity("m")]
Newton = Annotated[float, Quantity("N")]
# Without a gas pressure in the engine file, reactions are given for this radial force [N].
UNIT_RADIAL_FORCE = 1e5


@result("axial", "torsional", "influence")
class ThrowOnSupport(Compliances):
    """Compliances of a throw under one support, with errors; reactions to the force on its pin."""

    errors: Compliances
    # Effect of rigid sections; None if sections bend, or were solved as rigid only.
    section_errors: Compliances | None
    axial_force_per_radial: Number
    axial_force: Annotated[float, Quantity("N", "at the right end, that keeps the length")]
    reactions: Reactions


@result("frequency", "name")
class FreeMode(Result):
    """One natural mode of the free throw, with its motion."""

    frequency: Annotated[float, Quantity("Hz")]
    name: str


@result("asymmetry", "axial_reaction")
class Reciprocity(Result):
    """Errors of reciprocity between separate solutions of a throw, as shares."""

    asymmetry: Annotated[
        float,
        Quantity(
            "1",
            "largest difference between the stiffness from end forces and its transpose, relative to "
            "the largest stiffness, rotations measured as length x angle",
        ),
    ]
    axial_reaction: Annotated[
        float,
        Quantity(
            "1",
            "largest difference, of the supports, between c Z / e_n and the axial reaction by the end "
            "forces under a radial force Z on the first pin, relative to Z",
        ),
    ]


@result("name", "diameter")
class PinInFile(Result):
    """A crankpin of an imported throw."""

    name: str
    axis: Annotated[tuple[float, float], Quantity("m", "in the throw frame")]
    diameter: Metre


@result("file", "length")
class ThrowInFile(Result):
    """The file of a CAD part with its recognized features."""

    file: str
    sha256: str
    length: Metre
    pins: tuple[PinInFile, ...]
    main_journal_diameters: Annotated[tuple[float, ...], Quantity("m")]
    remarks: tuple[str, ...]


@result("mass", "error_estimate", "accuracy", "unknowns")
class ThrowResults(Result):
    """Compliances, reactions and masses of a throw.

    Matrices of stiffness (12, 12) are of ux uy uz rx ry rz of the left, then the right end section.
    """

    dimensions: CrankThrow | ThrowInFile
    material: Material
    supports: Mapping[str, ThrowOnSupport]
    radial_force: Newton
    pin_force: Annotated[tuple[float, float, float], Quantity("N", "on the first pin")]
    mass: Annotated[float, Quantity("kg")]
    center_of_mass: Annotated[Array, Quantity("m")]
    inertia: Annotated[Array, Quantity("kg m^2", "about the center of mass")]
    stiffness: Annotated[Array, Quantity(".stiffness_units")]
    stiffness_error: Annotated[Array, Quantity(".stiffness_units")]
    stiffness_units: Mapping[str, tuple[str, ...]]
    inertia_about_shaft: Annotated[float, Quantity("kg m^2")]
    unbalance: Unbalance
    error_estimate: Annotated[float, Quantity("1", "relative, of the axial compliance")]
    accuracy: Annotated[float, Quantity("1", "requested")]
    accuracy_met: bool
    solver: str
    seconds: Annotated[Mapping[str, float], Quantity("s", "of each step")]
    corrected: bool
    sections: Annotated[Sections, Quantity("1")]
    section_error: Number | None
    axial_correction: Annotated[float, Quantity("1", "share that is correction")]
    unknowns: int
    model: str
    remarks: tuple[str, ...]
    meshing_attempts: tuple[str, ...]
    mended_elements: int
    reciprocity: Annotated[Reciprocity | None, Quantity(left_out=True)] = None
    law: Annotated[LawResults | None, Quantity(left_out=True)] = None
    free_modes: Annotated[tuple[FreeMode, ...] | None, Quantity(left_out=True)] = None
    slopes: Annotated[tuple[Sensitivities, ...] | None, Quantity(left_out=True)] = None
    further_pin_forces: Annotated[
        tuple[tuple[float, float, float], ...] | None,
        Quantity("N", "on the other pins, in their order", left_out=True),
    ] = None

    @property
    def pin_forces(self) -> tuple[tuple[float, float, float], ...]:
        """Forces on the pins, from the first on [N]."""
        return (self.pin_force, *(self.further_pin_forces or ()))

    @property
    def error_words(self) -> str:
        """State the error of the axial compliance."""
        error = f"{percent(self.error_estimate)} %"
        return f"within {error}" if self.axial_correction else f"too small by about {error}"

    def pin_force_words(self, units: OutputUnits = SI) -> str:
        """State which force acts on the pin."""
        throw = self.dimensions
        if len(throw.parts.pins if isinstance(throw, CrankThrow) else throw.pins) == 1:
            return force_words(self.pin_force, "the pin", units)
        first = force_words(self.pin_force, "the first pin", units)
        further = enumerate(self.further_pin_forces or (), start=2)
        return " and ".join(
            [first, *(force_words(force, f"pin {n}", units) for n, force in further)]
        )

    def support_table(self) -> Table:
        """Return the compliances by support of the end sections."""
        return Table.of_records(
            f"Throw by finite elements (e_n {self.error_words})",
            self.supports.items(),
            (Column("support", words=True), lambda row: row[0]),
            (Column("e_n", "1e-9 m/N"), lambda row: row[1].axial),
            (Column("torsional", "1e-9 rad/(N m)"), lambda row: row[1].torsional),
            (Column("c", "1e-9 m/N"), lambda row: row[1].influence),
            (Column("P/Z"), lambda row: row[1].axial_force_per_radial),
        )

    def loaded_table(self, units: OutputUnits = SI) -> Table:
        """Return the compliances with the axial force P due to the force on the pin."""
        table, forces = (
            self.support_table(),
            (supported.axial_force for supported in self.supports.values()),
        )
        return replace(
            table,
            columns=[*table.columns, Column("P", "kN")],
            rows=[[*row, force] for row, force in zip(table.rows, forces, strict=True)],
            note="P: axial force at the right end that keeps the length under "
            f"{self.pin_force_words(units)}.",
        )

    def parts(self, units: OutputUnits = SI, *, profile: bool = False) -> Iterator[Table | str]:
        """Return reactions, masses, and what was asked for besides; the answer is the `loaded_table`."""
        yield self.reaction_table(units)
        if self.free_modes:
            yield self.mode_table()
        if self.slopes:
            yield self.slope_table()
            yield Main(self.slope_words())
        if profile:
            yield self.time_table()
        yield from map(Main, self.sentences(units))
        if not self.corrected:
            yield Main(units.written(f"Note: {NOT_CORRECTED}"))

    def plot(self, axes: "Axes | None" = None, *, support: str = "pinned") -> "Axes":
        """Draw the throw from the side with the forces on its pins and ends, as far as in this plane.

        Of a throw from a file, whose outline is unknown, draw the reactions' forces.

        Parameters
        ----------
        support : str, optional
            One of the `supports`.

        Raises
        ------
        InputError
            If there is no such support.
        """
        check_choice("support", support, self.supports, "these were calculated")
        throw, ends = self.dimensions, self.supports[support].reactions
        if isinstance(throw, ThrowInFile):
            return ends.plot(axes)
        axes = throw.plot(axes, dimensions=False)
        pins = zip(throw.parts.pins, self.pin_forces, strict=False)
        acting = {
            f"pin {number}": ((0.5 * (pin.start + pin.end), pin.axis[1]), force)
            for number, (pin, force) in enumerate(pins, start=1)
        }
        acting["left end"] = (0.0, 0.0), tuple(ends.left.force.tolist())
        acting["right end"] = (throw.length, 0.0), tuple(ends.right.force.tolist())
        longest = max(math.hypot(along, up) for _, (_, up, along) in acting.values())
        scale = LONGEST_ARROW * throw.length / (longest or 1.0)
        for color, (name, ((z, y), force)) in zip(cycle(COLORS), acting.items(), strict=False):
            components = ", ".join(f"{value / 1e3:.3g}" for value in force)
            axes.plot([], [], color=color, label=f"{name}: {components}")
            arrow = {
                "arrowstyle": "->",
                "color": color,
                "linewidth": 1.8,
                "shrinkA": 0,
                "shrinkB": 0,
            }
            tip = (z + scale * force[2], y + scale * force[1])
            axes.annotate("", tip, (z, y), arrowprops=arrow, annotation_clip=False)
        legend_below(axes, 2)
        write_title(axes, f"Forces x, y, z [kN], {support} ends")
        return axes

    def reaction_table(self, units: OutputUnits = SI) -> Table:
        """Return the reactions of the ends to the force on the pin."""
        ends = {name: supported.reactions for name, supported in self.supports.items()}
        return reaction_table(ends, self.pin_force_words(units))

    @property
    def section_sentence(self) -> str:
        """The effect of rigid sections on the axial compliance; empty if unknown."""
        shares = [
            f"{percent(held.section_errors.axial / held.axial)} % of e_n {name}"
            for name, held in self.supports.items()
            if held.section_errors
        ]
        if not shares:
            return ""
        return (
            f"Pinned and guided ends are rigid sections here, which omits {' and '.join(shares)}: the throw "
            f"is softer by this much between equal throws, with sections that bend (degree {self.sections})."
        )

    def sentences(self, units: OutputUnits = SI) -> list[str]:
        """State masses, model, and the effect of rigid sections."""
        static, dynamic = (
            math.hypot(*vector) for vector in (self.unbalance.static, self.unbalance.dynamic)
        )
        met = "" if self.accuracy_met else f"; the accuracy of {self.accuracy:.2g} was not met"
        masses = (
            f"Mass {amount(self.mass, 'kg', 4)}, center of mass {amount(self.center_of_mass[1], 'm', 4)} "
            f"from the shaft axis, inertia about the shaft {amount(self.inertia_about_shaft, 'kg m^2', 4)}; "
            f"static unbalance {amount(static, 'kg m', 4)}, dynamic unbalance "
            f"about the middle {amount(dynamic, 'kg m^2', 3)}."
        )
        model = f"Model: {self.model}, {self.unknowns:,} unknowns, solver {self.solver}{met}."
        return list(filter(None, (units.written(masses), model, self.section_sentence)))

    def mode_table(self) -> Table:
        """Return the natural modes of the free throw."""
        return Table.of_records(
            "Natural modes of the free throw",
            enumerate(self.free_modes or (), start=1),
            (Column("mode"), lambda row: row[0]),
            (Column("frequency", "Hz", decimals=1), lambda row: row[1].frequency),
            (Column("motion of the end sections", words=True), lambda row: row[1].name),
            main=True,
        )

    def slope_table(self, most: int | None = None) -> Table:
        """Return the changes in per cent for one per cent of each dimension, those of e_n falling.

        Of all dimensions, or of the first so many.
        """
        slopes = self.slopes or ()
        heads = [
            f"{SYMBOLS.get(slope.quantity, slope.quantity)} {slope.support}" for slope in slopes
        ]
        paths = sorted(slopes[0].shares, key=lambda path: -abs(slopes[0][path])) if slopes else []
        return Table(
            "Change in per cent for one per cent of a dimension",
            [
                Column("dimension", words=True),
                *(Column(head.strip(), decimals=3) for head in heads),
            ],
            [[path.replace("_", " "), *(slope[path] for slope in slopes)] for path in paths[:most]],
            main=True,
        )

    def slope_words(self, *, left_out: bool = True) -> str:
        """State what the slopes are of and how well they are known; and which dimensions have none."""
        slope, errors = (self.slopes or ())[0], sorted(each.error for each in self.slopes or ())
        words = [
            "P and Mx: reactions of the right and the left end to a radial force on the first pin; estimated "
            f"error of each slope {errors[0]:.3f} to {errors[-1]:.3f}"
        ]
        throw, reasons = self.dimensions, slope.left_out if left_out else {}
        sizes = lengths_of(throw) if isinstance(throw, CrankThrow) else {}
        if zero := [path for path in reasons if sizes[path] == 0.0]:
            words.append(f"no slope where a dimension is zero ({', '.join(zero)})")
        words += [f"{path}: {why}" for path, why in reasons.items() if path not in zero]
        return f"{'; '.join(words)}."

    def time_table(self) -> Table:
        """Return the time of each step."""
        total = sum(self.seconds.values())
        return Table(
            "Time of each step",
            [Column("work", words=True), Column("s", decimals=2), Column("", "%", decimals=0)],
            [[name, s, s / total] for name, s in (dict(self.seconds) | {"all": total}).items()],
            main=True,
        )


def force_words(force: Sequence[float], on: str, units: OutputUnits) -> str:
    """State a force [N] on a pin."""
    (x, y, z), unit = force, units.of("kN")
    if x == z == 0.0 and y <= 0.0:
        return f"a radial force of {unit.with_name(abs(y))} on {on}"
    shown = ", ".join(unit.number(value) for value in (x, y, z))
    return f"a force of {shown} {unit.name} (x, y, z) on {on}"


def reaction_table(reactions: Mapping[str, Reactions], force: str) -> Table:
    """Return the reactions of the ends by support; `force` says to what."""
    return Table(
        f"Reactions to {force}, length kept",
        [
            Column("support", words=True),
            Column("end", words=True),
            Column("force x y z", "kN", decimals=3, joint="  "),
            Column("moment x y z", "kN m", decimals=3, joint="  "),
        ],
        [
            [name, side, [*end.force], [*end.moment]]
            for name, ends in reactions.items()
            for side, end in (("left", ends.left), ("right", ends.right))
        ],
        main=True,
    )


@result("inside")
class ReactionsOnSupport(Result):
    """Reactions under one support by a model or the law, with the band of each component."""

    reactions: Reactions
    band: Reactions
    inside: bool


@result("supports", "refused")
class ReactionResults(Result):
    """Reactions by a model or the law under each possible support; of the others the reason."""

    pin_force: Annotated[tuple[float, float, float], Quantity("N")]
    radial_force: Newton
    supports: Mapping[str, ReactionsOnSupport]
    refused: Mapping[str, str]

    def table(self, units: OutputUnits) -> Table:
        """Return the reactions of the ends."""
        ends = {name: supported.reactions for name, supported in self.supports.items()}
        return reaction_table(ends, force_words(self.pin_force, "the pin", units))


def reaction_results(
    react: "Callable[..., ReactionLookup]", force: Sequence[float], gamma: float | None
) -> ReactionResults:
    """Look reactions up under each possible support.

    Parameters
    ----------
    react : callable
        Force and support to reactions, as `ComplianceModel.reactions`.
    force : (3,) sequence of float
        On the pin [N].
    gamma : float or None
        Angle to equal neighbors, for one more support [deg].
    """
    supports: dict[str, ReactionsOnSupport] = {}
    refused: dict[str, str] = {}
    for name, support in named_supports(gamma).items():
        try:
            answer = react(force, support)
        except InputError as error:
            refused[name] = str(error)
            continue
        ends = Reactions(answer.left, answer.right)
        supports[name] = ReactionsOnSupport(ends, answer.band, bool(answer.inside))
    if not supports:
        raise InputError(next(iter(refused.values())))
    x, y, z = force
    return ReactionResults((x, y, z), -y, supports, refused)


SUPPORTS: tuple[Support, ...] = ("pinned", "guided")
NOT_CORRECTED = (
    "Not all results are corrected for discretization: on this coarse mesh its error is too large to be "
    "estimated. Give a better accuracy."
)


def named_supports(
    gamma_deg: float | None, left_gamma_deg: float | None = None
) -> dict[str, Support]:
    """Return pinned and guided ends, and equal neighbors at angles [deg], by name."""
    named: dict[str, Support] = {str(support): support for support in SUPPORTS}
    if gamma_deg is not None:
        left = gamma_deg if left_gamma_deg is None else left_gamma_deg
        angles = f"{gamma_deg:g}" if left == gamma_deg else f"{left:g} and {gamma_deg:g}"
        named[f"neighbors {angles} deg"] = Neighbors(left, gamma_deg)
    return named


def throw_results(
    analysis: ThrowAnalysis,
    radial_force: float,
    *,
    pin_force: Sequence[float] | None = None,
    further_pin_forces: Sequence[Sequence[float]] = (),
    gamma_deg: float | None = None,
    left_gamma_deg: float | None = None,
    slopes: bool = False,
) -> ThrowResults:
    """Compliances, reactions and masses of a throw.

    Parameters
    ----------
    radial_force : float
        Z for the reactions [N].
    pin_force : (3,) sequence of float, optional
        On the first pin, in the throw frame, replaces Z [N].
    further_pin_forces : sequence of (3,) sequences of float, optional
        On the pins after it, at the same time [N].
    gamma_deg : float, optional
        Angle to equal neighbors, for one more support [deg].
    left_gamma_deg : float, optional
        Angle to the left neighbor, if different [deg].
    slopes : bool
        Whether also the slopes over the dimensions; a remark says why there are none.
    """
    x, y, z = (0.0, -radial_force, 0.0) if pin_force is None else pin_force
    further = [(right, up, along) for right, up, along in further_pin_forces]
    mesh, masses, sections = analysis.mesh, analysis.masses, analysis.sections
    remarks = (*analysis.throw.remarks, *(() if analysis.corrected else (NOT_CORRECTED,)))
    sloped = None
    try:
        sloped = throw_slopes(analysis) if slopes else None
    except (InputError, MeshError) as error:
        remarks = (*remarks, f"There are no slopes over the dimensions: {error}")
    supports, forces = {}, [(x, y, z), *further]
    for name, support in named_supports(gamma_deg, left_gamma_deg).items():
        answer = analysis.supported(support)
        rigid = isinstance(support, Neighbors) or sections == "rigid"
        ends = [analysis.reactions(force, support, pin) for pin, force in enumerate(forces)]
        lengthening = zip(
            answer.stretches, forces, strict=False
        )  # pins without a force are left out
        supports[name] = made_from(
            answer,
            ThrowOnSupport,
            errors=analysis.error_bars(support),
            section_errors=None if rigid else analysis.section_errors(support),
            axial_force_per_radial=answer.influence / answer.axial,
            axial_force=float(sum(stretch @ force for stretch, force in lengthening))
            / answer.axial,
            reactions=sum(ends[1:], ends[0]),
        )
    return made_from(
        analysis,
        ThrowResults,
        dimensions=dimensions_of(analysis.throw),
        supports=supports,
        radial_force=-y,
        pin_force=(x, y, z),
        mass=masses.mass,
        center_of_mass=masses.center,
        inertia=masses.inertia,
        stiffness_units={
            "row": (("N",) * 3 + ("N m",) * 3) * 2,
            "per_column": (("m",) * 3 + ("rad",) * 3) * 2,
        },
        inertia_about_shaft=masses.inertia_about_shaft,
        unbalance=unbalance(masses, analysis.throw.length / 2.0),
        sections=sections,
        section_error=None if sections == "rigid" else analysis.section_error,
        axial_correction=axial_correction(analysis.superelement, analysis.discrete.superelement),
        unknowns=mesh.unknowns,
        model=f"{mesh.part}, second-order tetrahedra, end sections {analysis.end_sections}",
        remarks=remarks,
        further_pin_forces=tuple(further) or None,
        slopes=sloped,
        meshing_attempts=mesh.attempts,
        mended_elements=mesh.mended_elements,
    )


LONGEST_ARROW = 0.3  # share of the throw's length
PICTURE = "throw_reactions.svg"


def picture_reactions(results: ThrowResults, folder: Path) -> Path:
    """Write the forces on the throw and the reactions of its ends, a row for each support."""
    path, drawn = folder / PICTURE, isinstance(results.dimensions, CrankThrow)
    columns, rows = 2 + drawn, len(results.supports)
    with figure(path, columns, 4.8 * columns, 4.2 * rows, rows=rows) as panels:
        for row, (name, supported) in zip(panels, results.supports.items(), strict=True):
            if drawn:
                results.plot(row[0], support=name)
            supported.reactions.plot(row[-2], show="force")
            supported.reactions.plot(row[-1], show="moment")
            for panel in row[-2:]:
                write_title(panel, f"Reactions, {name} ends")
    return path


def reciprocity(analysis: ThrowAnalysis) -> Reciprocity:
    """Compare separate solutions of a throw."""
    analysis = analysis.discrete
    elements = analysis.superelement
    by_forces = superelement_of_end_forces(analysis.classes, elements.radials)
    radial = elements.radials[0]
    differences = []
    for support in SUPPORTS:
        answer = analysis.supported(support)
        ends = reactions(elements, support, by_forces.end_load(radial))
        differences.append(abs(ends.left.force[2] - answer.influence / answer.axial))
    return Reciprocity(
        asymmetry(by_forces.stiffness, analysis.mesh.length), float(max(differences))
    )


SYMBOLS = {
    "axial_compliance": "e_n",
    "torsional_compliance": "e_t",
    "influence_coefficient": "c",
    "right Fz": "P",
    "left Mx": "Mx",
}
# Whose slopes are told; reactions are those to a radial force on the first pin.
SLOPED: tuple[tuple[str, Support], ...] = (
    ("axial_compliance", "pinned"),
    ("axial_compliance", "guided"),
    ("torsional_compliance", "pinned"),
    ("influence_coefficient", "pinned"),
    ("right Fz", "pinned"),
    ("left Mx", "guided"),
    ("mass", "pinned"),
    ("inertia", "pinned"),
)


def throw_slopes(analysis: ThrowAnalysis) -> tuple[Sensitivities, ...]:
    """Return how the main answers change with each dimension."""
    return tuple(analysis.sensitivities(*answer) for answer in SLOPED)


def free_modes(modes: "ThrowModes") -> tuple[FreeMode, ...]:
    """Return the natural modes of the free throw with their motions."""
    return tuple(
        FreeMode(float(frequency), name)
        for frequency, name in zip(modes.frequencies, modes.names, strict=True)
    )


def dimensions_of(throw: Throw) -> CrankThrow | ThrowInFile:
    """The input: its fields, or the file of a CAD part."""
    if isinstance(throw, CrankThrow):
        return throw
    return ThrowInFile(
        file=throw.path,
        sha256=throw.digest,
        length=throw.length,
        pins=tuple(
            PinInFile(pin.name, pin.axis, 2.0 * pin.radius) for pin in throw.cylinders[1:-1]
        ),
        main_journal_diameters=tuple(2.0 * throw.cylinders[end].radius for end in (0, -1)),
        remarks=throw.remarks,
    )
