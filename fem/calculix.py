"""Write a meshed throw as an input deck for CalculiX.

CalculiX (ccx, https://www.calculix.de) is a separate finite element program, so an engineer can check
our results with it: same mesh, same material, end sections as rigid bodies, same supports.

According to its manual, and as tried with version 2.20: a rigid body's reference node moves with the
section's center, the displacements of its rotation node are the section's rotations, forces on that are
moments; in a linear step without NLGEOM the rigid bodies are linear as well. A field of the deck has 20
characters at most.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from crankbase.array_checks import Array
from crankbase.choices import check_choice, check_kind, check_some
from crankbase.errors import InputError
from crankbase.outputs import write_errors, write_text
from fem.end_reactions import MOTIONS
from fem.material import Material
from fem.superelement import RX, RY, RZ, UX, UY, UZ
from fem.symmetry import uniform_pin_loads
from geometry.mesh import ThrowMesh
from geometry.mesh_exchange import inp_lines, number_field, set_name
from geometry.solid import LEFT_END, RIGHT_END

Support = Literal["pinned", "guided"]
# Motions of an end section that a support holds at both ends. The left end is held along and about the
# shaft as well.
HELD_BOTH: dict[str, tuple[int, ...]] = {"pinned": (UX, UY), "guided": (UX, UY, RX, RY)}
HELD_LEFT = (UZ, RZ)


@dataclass(frozen=True)
class LoadCase:
    """One linear static step: the supports and loads of the throw.

    Attributes
    ----------
    title : str
        Its description, for the deck's comments.
    support : {"pinned", "guided"}
        As for `fem.supports`; the left end is held along and about the shaft too.
    end_loads : (12,) tuple of float
        Forces [N] and moments [N m] on the left, then on the right end section.
    pin_forces : tuple of (3,) tuples of float
        Force on each pin in the throw frame [N], spread uniformly over its surface; empty for none.
    blocked : bool
        Whether the right end is also held along the shaft.

    Raises
    ------
    InputError
        If the support is unknown, a load is not a finite number, there are not twelve end loads, or one
        acts on a motion that is held.
    """

    title: str
    support: Support = "pinned"
    end_loads: tuple[float, ...] = (0.0,) * 12
    pin_forces: tuple[tuple[float, float, float], ...] = ()
    blocked: bool = False

    def __post_init__(self) -> None:
        if self.support not in HELD_BOTH:
            raise InputError(
                f'support: given {self.support!r}; allowed are "pinned" and "guided", because other supports '
                "need more than one throw."
            )
        if len(self.end_loads) != 12 or any(len(force) != 3 for force in self.pin_forces):
            raise InputError(
                f"load case {self.title!r}: given {len(self.end_loads)} end loads and the pin forces "
                f"{self.pin_forces!r}; allowed are 12 end loads and 3 numbers for each pin, because an "
                "end section has six motions and a pin force three components."
            )
        if not np.all(np.isfinite([*self.end_loads, *(x for f in self.pin_forces for x in f)])):
            raise InputError(
                f"load case {self.title!r}: given the end loads {self.end_loads!r} and the pin forces "
                f"{self.pin_forces!r}; allowed are finite numbers, because CalculiX reads no others."
            )
        loaded = [place for place in self.held if self.end_loads[place] != 0.0]
        if loaded:
            end = "left" if loaded[0] < 6 else "right"
            raise InputError(
                f"load case {self.title!r}: given a load on {MOTIONS[loaded[0] % 6]} of the {end} end; "
                "allowed are loads on motions that are free, because a support would take it at once."
            )

    @property
    def held(self) -> tuple[int, ...]:
        """Indices, of the twelve motions of the ends, that are held."""
        both = HELD_BOTH[self.support]
        right = (*both, UZ) if self.blocked else both
        return (*sorted({*both, *HELD_LEFT}), *(6 + place for place in sorted(right)))


def axial_case(support: Support = "pinned") -> LoadCase:
    """Pull with 1 N: the right center's uz is the axial compliance e_n [m/N]."""
    return LoadCase(f"axial force of 1 N, {support}", support, _on_right(UZ))


def torque_case(support: Support = "pinned") -> LoadCase:
    """Twist with 1 N m: the right end's rz is the torsional compliance [rad/(N m)]."""
    return LoadCase(f"torque of 1 N m, {support}", support, _on_right(RZ))


def bending_case(axis: Literal["x", "y"]) -> LoadCase:
    """Bend with opposite moments of 1 N m at the pinned ends: their tilts differ by the compliance.

    The moment about x bends the throw in the crank plane, that about y across it.
    """
    check_choice("axis", axis, ("x", "y"), "z is the shaft axis")
    place = RX if axis == "x" else RY
    loads = tuple(-1.0 if i == place else 1.0 if i == 6 + place else 0.0 for i in range(12))
    return LoadCase(f"opposite end moments of 1 N m about {axis}, pinned", "pinned", loads)


def pin_case(
    pin_forces: Iterable[Sequence[float]], support: Support = "pinned", *, blocked: bool
) -> LoadCase:
    """Load the pins: free to lengthen for the influence coefficient, blocked for the reactions.

    Parameters
    ----------
    pin_forces : (pins, 3) array_like
        Force on each pin in the throw frame [N].
    support : {"pinned", "guided"}
    blocked : bool
        Whether the right end is held along the shaft.
    """
    forces = tuple((float(x), float(y), float(z)) for x, y, z in pin_forces)
    ends = "length blocked" if blocked else "free to lengthen"
    title = f"pin forces {', '.join(map(str, forces))} N, {support}, {ends}"
    return LoadCase(title, support, pin_forces=forces, blocked=blocked)


def standard_cases(mesh: ThrowMesh) -> tuple[LoadCase, ...]:
    """All load cases for the behavior of a pinned or guided throw.

    Returns
    -------
    tuple of LoadCase
        Axial force and torque under both supports, end moments about x and y, and a force of 1 N on
        each pin along each axis under both supports, the length blocked and free.
    """
    supports: tuple[Support, ...] = ("pinned", "guided")
    cases = [make(support) for make in (axial_case, torque_case) for support in supports]
    cases += [bending_case("x"), bending_case("y")]
    units = np.eye(3 * len(mesh.pins)).reshape(-1, len(mesh.pins), 3).tolist()
    cases += [
        pin_case(forces, support, blocked=blocked)
        for support in supports
        for blocked in (True, False)
        for forces in units
    ]
    return tuple(cases)


def _on_right(place: int) -> tuple[float, ...]:
    return tuple(float(i == 6 + place) for i in range(12))


# The set of the four nodes that stand for the end sections, in the order left center, left rotation,
# right center, right rotation; their displacements are the twelve motions.
ENDS = "ENDS"


def write_calculix(
    mesh: ThrowMesh, material: Material, path: str | Path, cases: Sequence[LoadCase] | None = None
) -> Path:
    """Write a throw as an input deck for CalculiX, to check compliances and reactions with it.

    ``ccx throw`` then writes ``throw.dat``, which the deck's comments explain.

    Parameters
    ----------
    mesh : ThrowMesh
        Of a throw meshed whole (part "full").
    path : path
        A file with the ending ``.inp``.
    cases : sequence of LoadCase, optional
        One step each; `standard_cases` by default.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the mesh is not of a whole throw, a load case does not fit it, or the file cannot be written.
    """
    check_kind("mesh", mesh, ThrowMesh, "a ThrowMesh, as mesh_throw returns")
    check_kind("path", path, str | os.PathLike, "the name of a file ending in '.inp'")
    if cases is not None:
        check_kind("cases", cases, list | tuple, "a list of LoadCase")
        for place, case in enumerate(cases):
            check_kind(f"cases[{place}]", case, LoadCase, "a LoadCase")
    path = Path(path)
    if path.suffix != ".inp":
        raise InputError(
            f"{path.name}: given the ending {path.suffix!r}; allowed is '.inp', because CalculiX looks "
            "for no other."
        )
    text = calculix_deck(mesh, material, standard_cases(mesh) if cases is None else cases)
    with write_errors(path):
        return write_text(path, text, "deck")


def calculix_deck(mesh: ThrowMesh, material: Material, cases: Sequence[LoadCase]) -> str:
    """Text of the deck that `write_calculix` writes; parameters and errors as there."""
    if mesh.part != "full":
        raise InputError(
            f"mesh.part: given {mesh.part!r}; allowed is 'full', because the deck holds a whole throw: "
            'mesh it with part="full".'
        )
    check_kind("material", material, Material, "a Material")
    check_some("cases", cases, "CalculiX computes nothing else")
    for case in cases:
        if len(case.pin_forces) not in (0, len(mesh.pins)):
            raise InputError(
                f"load case {case.title!r}: given forces on {len(case.pin_forces)} pins; allowed is "
                f"{len(mesh.pins)}, because the throw has that many."
            )
    count = len(mesh.points)
    loaded = any(case.pin_forces for case in cases)
    shares = uniform_pin_loads(mesh) if loaded else np.zeros((len(mesh.pins), 0))
    lines = [*_head(mesh, material, cases), *inp_lines(mesh), f"*NODE, NSET={ENDS}"]
    for number, z in enumerate((0.0, 0.0, mesh.length, mesh.length), start=count + 1):
        lines.append(f"{number},0.0,0.0,{number_field(z)}")
    lines += [
        "*MATERIAL, NAME=THROW",
        "*ELASTIC",
        f"{number_field(material.youngs_modulus)},{number_field(material.poisson_ratio)}",
        "*DENSITY",
        number_field(material.density),
        "*SOLID SECTION, ELSET=THROW, MATERIAL=THROW",
    ]
    for side, surface in enumerate((LEFT_END, RIGHT_END)):
        center, rotation = (_end_node(6 * side + place, count)[0] for place in (UX, RX))
        lines.append(
            f"*RIGID BODY, NSET={set_name(surface)}, REF NODE={center}, ROT NODE={rotation}"
        )
    for number, case in enumerate(cases, start=1):
        lines += _step_lines(case, number, count, shares)
    return "\n".join(lines) + "\n"


def _head(mesh: ThrowMesh, material: Material, cases: Sequence[LoadCase]) -> Iterator[str]:
    count = len(mesh.points)
    yield from (
        "** A crank throw for CalculiX, written by crankfem: ccx throw (of throw.inp) writes throw.dat.",
        "** Units: m, N, kg, s; so Pa, rad, N m.",
        "** Frame: z along the shaft, from the center of the left end section; y to the first pin's axis.",
        f"** {count} nodes, {len(mesh.elements)} curved 10-node tetrahedra, length "
        f"{mesh.length:.6g} m, size factor {mesh.size_factor:.6g}, "
        f"E {material.youngs_modulus:.6g} Pa, nu {material.poisson_ratio:.6g}.",
        "** End sections (LEFT_END, RIGHT_END) are rigid bodies, each with two nodes:",
        f"**   {count + 1}, {count + 3} left and right center: displacements ux uy uz, forces Fx Fy Fz,",
        f"**   {count + 2}, {count + 4} left and right rotation: displacements rx ry rz, forces Mx My Mz.",
        "** throw.dat prints the displacements and the forces on these (reactions, and loads where given).",
        "** Supports:",
        "**   pinned: both centers stay on the shaft axis, sections tilt freely,",
        "**   guided: sections neither tilt nor leave the axis;",
        "**   the left end is held along and about the shaft, blocked also holds the right end along it.",
        "** Forces on a pin are spread uniformly over its surface: shares of the nodes in PIN, PIN_2 ...",
        "** Steps:",
    )
    for number, case in enumerate(cases, start=1):
        yield f"**   {number}: {_one_line(case.title)}"


def _one_line(title: str) -> str:
    return " ".join(title.split())


def _end_node(place: int, count: int) -> tuple[int, int]:
    """Node and axis (1 to 3) of one of the twelve motions in a mesh of so many nodes."""
    return count + 1 + place // 3, 1 + place % 3


def _step_lines(case: LoadCase, number: int, count: int, shares: Array) -> Iterator[str]:
    yield f"** Step {number}: {_one_line(case.title)}"
    yield from ("*STEP", "*STATIC", "*BOUNDARY, OP=NEW")
    for place in case.held:
        node, axis = _end_node(place, count)
        yield f"{node},{axis},{axis}"
    yield "*CLOAD, OP=NEW"
    for place in np.flatnonzero(case.end_loads).tolist():
        node, axis = _end_node(place, count)
        yield f"{node},{axis},{number_field(case.end_loads[place])}"
    for share, force in zip(shares, case.pin_forces, strict=False):  # there may be no forces
        loaded = np.flatnonzero(share)
        for axis in np.flatnonzero(force).tolist():
            for node, part in zip((loaded + 1).tolist(), share[loaded].tolist(), strict=True):
                yield f"{node},{axis + 1},{number_field(part * force[axis])}"
    yield from (f"*NODE PRINT, NSET={ENDS}", "U,RF", "*END STEP")
