"""The whole crankshaft: throws at their crank angles, free end, flange."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, field
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from crankbase.array_checks import Array, finite_vector, refuse_crank_radians
from crankbase.calls import ProcessLostError
from crankbase.choices import check_kind
from crankbase.errors import InputError, MeshError
from crankbase.frames import Axes
from crankbase.model import InputModel, length_field
from crankbase.quantity import format_quantity
from crankbase.sentences import amount
from crankbase.summaries import frozen
from geometry.any_throw import Throw
from geometry.gmsh_session import gmsh_errors, shared_process
from geometry.mass import (
    MassProperties,
    Unbalance,
    check_density,
    combined_mass,
    cylinder_mass_properties,
    solid_mass_properties,
    unbalance,
)
from geometry.mesh import SOLID_VOLUME_TOLERANCE, SolidProperties, built_solid, solid_properties
from geometry.mesher import TIME_LIMIT
from geometry.solid import Entity, make_solid, remove_loose
from geometry.throw import CrankThrow

# Diameters of one journal in two throws from files agree to this share.
SAME_SIZE = 1e-9


class ShaftEnds(InputModel):
    """A cylindrical free end and a round flange, each only if its two dimensions are given.

    Parameters
    ----------
    free_end_diameter, free_end_length : float, optional
        [m]
    flange_diameter, flange_thickness : float, optional
        [m]

    Raises
    ------
    InputError
        If one dimension of an end is given without the other, or out of range.
    """

    section: ClassVar[str] = "shaft_ends"

    free_end_diameter: float | None = length_field(
        "diameter of the shaft's free end", (0.001, 2.0), default=None
    )
    free_end_length: float | None = length_field(
        "length of the free end beyond the first main journal", (0.0003, 5.0), default=None
    )
    flange_diameter: float | None = length_field(
        "diameter of the flange", (0.001, 4.0), default=None
    )
    flange_thickness: float | None = length_field(
        "thickness of the flange behind the last main journal", (0.0002, 1.0), default=None
    )

    @model_validator(mode="after")
    def _both_or_none(self) -> Self:
        for first, second in (
            ("free_end_diameter", "free_end_length"),
            ("flange_diameter", "flange_thickness"),
        ):
            for present, missing in ((first, second), (second, first)):
                if getattr(self, present) is not None and getattr(self, missing) is None:
                    raise InputError(
                        f"{self.section}.{missing}: missing; it must be given together with {present}."
                    )
        return self


@frozen("throws", "crank_angles_deg [deg]", "length [m]")
class Crankshaft:
    """A crankshaft of throws in a row.

    Parameters
    ----------
    throws : sequence of n CrankThrow or ImportedThrow
        From the free end to the flange. Adjacent throws share a main bearing, so their main
        journals have one diameter. Bores that differ end in the middle of the journal; see `remarks`.
    crank_angles_deg : sequence of n float
        Angle of each throw's first pin about +z, counted from +y [deg].
    ends : ShaftEnds, optional
        Free end and flange beyond the first and the last main journal.

    Raises
    ------
    InputError
        If there is not one angle for each throw, they are radians, or neighbors do not fit.

    Examples
    --------
    >>> shaft = Crankshaft([throw] * 4, crank_angles_deg=[0.0, 180.0, 180.0, 0.0])  # doctest: +SKIP
    """

    throws: Sequence[Throw]
    _: KW_ONLY
    crank_angles_deg: Sequence[float]
    ends: ShaftEnds = field(default_factory=ShaftEnds)

    def __post_init__(self) -> None:
        if not self.throws or len(self.throws) != len(self.crank_angles_deg):
            raise InputError(
                f"crank_angles_deg: given {len(self.crank_angles_deg)} for {len(self.throws)} throws; "
                "allowed is one for each of at least one throw."
            )
        for place, throw in enumerate(self.throws):
            check_kind(
                f"throws[{place}]", throw, Throw, "a CrankThrow, or what import_throw returns"
            )
        finite_vector("crank_angles_deg", self.crank_angles_deg)
        refuse_crank_radians("crank_angles_deg", self.crank_angles_deg)
        for number, (first, second) in enumerate(
            zip(self.throws, self.throws[1:], strict=False), start=1
        ):
            left, right = first.main_journal_diameter, second.main_journal_diameter
            if not math.isclose(left, right, rel_tol=SAME_SIZE):
                raise InputError(
                    f"throws: given main_journal_diameter {amount(left, 'm')} in throw {number} and "
                    f"{amount(right, 'm')} in throw {number + 1}; allowed is one value, because "
                    "they share a main journal."
                )

    def bore_step(self, number: int) -> str | None:
        """State how the bores of a throw, counted from 0, and the next one differ where these meet."""
        left, right = self.throws[number : number + 2]
        ends = (left.parts.cylinders[-1], right.parts.cylinders[0])
        turns = np.exp(1j * np.radians(self.crank_angles_deg[number : number + 2]))
        first, second = np.array([complex(*end.bore_axis) for end in ends]) * turns
        diameters = left.main_journal_bore, right.main_journal_bore
        sizes = " and ".join(format_quantity(size, "m") for size in diameters)
        if all(diameters) and abs(first - second) > 1e-9 * left.main_journal_diameter:
            return f"{sizes}, {format_quantity(float(abs(first - second)), 'm', 4)} apart"
        return None if math.isclose(*diameters, rel_tol=SAME_SIZE) else sizes

    @property
    def remarks(self) -> tuple[str, ...]:
        """State where the bores of neighboring throws do not continue each other, once for each kind."""
        pairs: dict[str, list[str]] = {}
        for number in range(len(self.throws) - 1):
            if (step := self.bore_step(number)) is not None:
                pairs.setdefault(step, []).append(f"{number + 1} and {number + 2}")
        return tuple(
            f"Throws {', '.join(between)} have main-journal bores of {step}: these do not continue each "
            "other, and end in the middle of the journal."
            for step, between in pairs.items()
        )

    @property
    def starts(self) -> Array:
        """Left end of each throw along the shaft, and the last one's right end (n + 1,) [m]."""
        return np.array(throw_starts(self.throws))

    @property
    def length(self) -> float:
        """Length with free end and flange [m]."""
        start, end = self.reach
        return end - start

    @property
    def reach(self) -> tuple[float, float]:
        """Where the shaft begins and ends; z = 0 is the middle of the first main journal [m]."""
        last = float(self.starts[-1])
        return -(self.ends.free_end_length or 0.0), last + (self.ends.flange_thickness or 0.0)

    def masses(self, density: float) -> MassProperties:
        """Mass, center and inertia from the solids of throws and ends [kg, m, kg m^2].

        Parameters
        ----------
        density : float
            [kg/m^3]

        Raises
        ------
        InputError
            If the density is not a number above zero.
        MeshError
            If a throw's solid cannot be built.
        """
        by_throw: dict[Throw, MassProperties] = {}
        parts = []
        for throw, angle, start in zip(
            self.throws, self.crank_angles_deg, self.starts[:-1], strict=True
        ):
            if throw not in by_throw:
                by_throw[throw] = throw_masses(throw, density)
            parts.append(by_throw[throw].moved(angle_deg=angle, along=float(start)))
        parts += [
            cylinder_mass_properties(diameter, low, high, density)
            for diameter, low, high in self.end_cylinders
        ]
        return combined_mass(parts)

    @property
    def end_cylinders(self) -> list[tuple[float, float, float]]:
        """Diameter, start and end of free end and flange, if given [m]."""
        (start, end), last = self.reach, float(self.starts[-1])
        made = []
        if self.ends.free_end_diameter is not None:
            made.append((self.ends.free_end_diameter, start, 0.0))
        if self.ends.flange_diameter is not None:
            made.append((self.ends.flange_diameter, last, end))
        return made

    def unbalance(self, density: float) -> Unbalance:
        """Static and dynamic unbalance, moments about the middle of the throws."""
        return unbalance(self.masses(density), 0.5 * float(self.starts[-1]))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the side view to scale, each throw at its crank angle with its number below."""
        from geometry.plots.throw_plot import plot_throws

        parts = [throw.parts for throw in self.throws]
        return plot_throws(
            axes, parts, np.radians(self.crank_angles_deg).tolist(), self.end_cylinders
        )


def throw_starts(throws: Sequence[Throw]) -> tuple[float, ...]:
    """Left end of each throw along a shaft, and the last one's right end [m].

    Sums are rounded once, so that equal throws are at whole multiples of their length.
    """
    lengths = [throw.length for throw in throws]
    return tuple(math.fsum(lengths[:number]) for number in range(len(lengths) + 1))


def throw_masses(throw: Throw, density: float) -> MassProperties:
    """Mass properties of a throw from its solid, without meshing it.

    Parameters
    ----------
    density : float
        [kg/m^3]

    Raises
    ------
    InputError
        If the density is not a number above zero.
    MeshError
        If the solid cannot be built.
    """
    check_kind("throw", throw, Throw, "a CrankThrow, or what import_throw returns")
    check_density(density)
    if not isinstance(throw, CrankThrow):
        return solid_mass_properties(throw.solid, "full", throw.length, density)
    try:
        solid = shared_process().call(
            "geometry.crankshaft:throw_solid", throw, time_limit=TIME_LIMIT
        )
    except ProcessLostError as error:
        raise MeshError(f"the throw's solid could not be built: {error}.") from None
    return solid_mass_properties(solid, throw.symmetry, throw.length, density)


def throw_solid(throw: CrankThrow) -> SolidProperties:
    """Properties of the solid of the part of a throw required by its symmetry, in this process."""
    with gmsh_errors("build the throw"), built_solid(throw.parts, throw.symmetry) as built:
        return built.solid


def make_shaft(gmsh: Any, shaft: Crankshaft) -> None:
    """Build a crankshaft's solid in the current gmsh model, x, y, z as in `Crankshaft`.

    Raises
    ------
    MeshError
        If the kernel lost a part, or did not unite all parts.
    """
    occ = gmsh.model.occ
    pieces: list[Entity] = []
    made: dict[Throw, Entity] = {}
    for throw, angle, start in zip(
        shaft.throws, np.radians(shaft.crank_angles_deg), shaft.starts[:-1], strict=True
    ):
        if throw not in made:
            made[throw] = (
                make_solid(gmsh, throw.parts, "full")
                if isinstance(throw, CrankThrow)
                else throw.read_into(gmsh)
            )
        (copied,) = occ.copy([made[throw]])
        occ.rotate([copied], 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, angle)
        occ.translate([copied], 0.0, 0.0, float(start))
        pieces.append(copied)
    for diameter, low, high in shaft.end_cylinders:
        tag = occ.addCylinder(0.0, 0.0, low, 0.0, 0.0, high - low, diameter / 2.0)
        pieces.append((3, int(tag)))
    occ.remove(list(made.values()), recursive=True)
    if len(pieces) > 1:
        pieces, _ = occ.fuse(pieces[:1], pieces[1:])
    remove_loose(gmsh)
    solid = solid_properties(gmsh)
    expected = sum(throw.volume for throw in shaft.throws)
    expected += sum(
        math.pi / 4.0 * diameter**2 * (high - low) for diameter, low, high in shaft.end_cylinders
    )
    if not math.isclose(solid.volume, expected, rel_tol=SOLID_VOLUME_TOLERANCE):
        raise MeshError(
            f"the shaft's solid has a volume of {solid.volume:.8g} m^3, its parts {expected:.8g} m^3."
        )
