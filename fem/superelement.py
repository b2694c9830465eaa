"""The throw as a superelement between its two end sections, and superelements in a row: a crankshaft.

End sections are either rigid discs, or "averaged": only their mean translations and rotations are
given, and they warp freely under tractions of uniform and linear distribution. A real section is
stiffer than the second and softer than the first, so the two are bounds. In addition to rigid
motions those of bending sections can be included (`fem.symmetry`) with one factorization.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from crankbase.array_checks import Array, Flags, Integers, finite_vector, refuse_crank_radians
from crankbase.choices import check_choice, check_kind
from crankbase.diagrams import display_unit, draw_groups, draw_matrix, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import Axes, grid, table
from crankbase.results import Internal, Quantity, Result, result
from fem.solver import (
    SharedSolver,
    check_reciprocity,
    check_superelement,
    symmetric_product,
)
from fem.symmetry import (
    KEPT,
    RADIAL,
    RIGID,
    LoadedSurface,
    NodalLoads,
    SectionMotions,
    Sections,
    SymmetryClass,
    amplitude_shares,
    axial_class,
    both_ends,
    diagonal_blocks,
    end_sections,
    end_surface,
    pin_surfaces,
    rigid_motions,
    rotation,
    section_turn,
    unit_end_loads,
)
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

EndSections = Literal["rigid", "averaged"]
END_SECTIONS = ("rigid", "averaged")
# A section that lacks less of its circle's area is solid: so much facets leave out at most.
HOLLOW = 0.005


@dataclass(frozen=True)
class CondensedClass:
    """A throw's meshed part condensed for one symmetry class of k unknowns.

    Attributes
    ----------
    symmetry : SymmetryClass
        The class; the columns of ``ends`` are the unit motions below, those of rigid sections first.
    stiffness : (k, k) array
        Stiffness of the meshed part against the unit motions.
    fields : (n, 3, k) array
        Displacement (node, axis) for each unit motion.
    pin_loads : (pins, k, 6) array
        Work of a unit load on each whole pin (forces along x, y, z, moments about them) on each unit
        motion.
    pin_components : (a, 2) array
        Pins and components of the loads that this class carries.
    pin_fields : (n, 3, a) array
        Displacement under each of these loads on the whole pin, the end sections held.
    pin_flexibility : (a, a) array
        Motions of the whole pins along the loads under them, the end sections held [1/N and so on].
    solver : str
        The solver used.
    end_sections : {"rigid", "averaged"}
        Allowed motion of the end sections.
    end_forces : (k, k) array
        Work of the forces on the end sections under each unit motion (column) on each unit motion
        (row). It equals `stiffness`, which is the strain energy of both motions and always
        symmetric, as far as the fields are in equilibrium between the end sections.
    pin_reactions : (pins, k, 6) array
        The same as `pin_loads` by reciprocity: forces that hold the end sections under the unit
        loads on the pins, reversed. The two come from separate solutions.
    discrete : CondensedClass or None
        The class without correction, if `stiffness`, `pin_loads` and `pin_flexibility` are corrected
        (`fem.correction`).
    missing : float
        Of an uncorrected class: the largest estimated share of any motion's energy lost by
        discretization; no result has a larger error.
    sections : SectionMotions
        Allowed motion of the end sections.
    """

    symmetry: SymmetryClass
    stiffness: Array
    fields: Array
    pin_loads: Array
    pin_components: Integers
    pin_fields: Array
    pin_flexibility: Array
    solver: str
    end_sections: str
    end_forces: Array
    pin_reactions: Array
    discrete: "CondensedClass | None" = None
    missing: float = 0.0
    sections: SectionMotions = RIGID

    @property
    def ends(self) -> Array:
        """Motions (2 n, k) of both end sections for unit amplitudes.

        Six of the left and six of the right section, then those beyond the rigid ones of the left and of the
        right.
        """
        return end_amplitudes(self.symmetry, self.sections)

    @property
    def shares(self) -> Array:
        """Amplitudes (k, 2 n) of the class in unit motions of both end sections."""
        return amplitude_shares(self.ends)

    def up_to(self, sections: SectionMotions) -> "CondensedClass":
        """Return the class with fewer of its section motions; for `RIGID`, with rigid sections."""
        count = end_amplitudes(self.symmetry, sections).shape[1]
        return replace(
            self,
            stiffness=self.stiffness[:count, :count],
            fields=self.fields[:, :, :count],
            pin_loads=self.pin_loads[:, :count],
            end_forces=self.end_forces[:count, :count],
            pin_reactions=self.pin_reactions[:, :count],
            discrete=None if self.discrete is None else self.discrete.up_to(sections),
            sections=sections,
        )


@lru_cache(maxsize=KEPT)
def end_amplitudes(symmetry: SymmetryClass, sections: SectionMotions) -> Array:
    """Motions (2 n, k) of both end sections for unit amplitudes of a class; see `CondensedClass.ends`."""
    beyond = symmetry.unit_motions(sections.mirror_x[6:], sections.mirror_z[6:])
    return diagonal_blocks(symmetry.ends, beyond)


@dataclass(frozen=True, eq=False)
class HeldEnds:
    """Stiffness of a throw's meshed part with its end sections held: the same for all symmetry classes.

    Attributes
    ----------
    free, ends : (f,) and (h,) arrays
        Displacements, of 3 n, that are not and that are those of the end sections.
    inner : (f, f) sparse array
        Upper triangle of the stiffness of the free ones.
    coupling : (f, h) sparse array
        Forces along the free ones under those of the end sections.
    between_ends : (h, h) sparse array
        Forces along those of the end sections under themselves.
    sections : SectionMotions
        Allowed motion of the end sections.
    """

    free: Integers
    ends: Integers
    inner: sparse.csr_array
    coupling: sparse.csr_array
    between_ends: sparse.csr_array
    sections: SectionMotions


def hold_ends(mesh: ThrowMesh, stiffness: sparse.csr_array, degree: int) -> HeldEnds:
    """Hold the end sections, which also move as polynomials of a degree; 0 for none."""
    ends = _end_unknowns(mesh, axial_class(mesh.part))
    free = np.delete(np.arange(mesh.points.size), ends)
    of_free, of_ends = stiffness[free], stiffness[ends]
    among_ends = of_ends[:, ends]
    return HeldEnds(
        free,
        ends,
        of_free[:, free].tocsr(),
        (of_free[:, ends] + of_ends[:, free].T).tocsr(),
        (among_ends + among_ends.T - sparse.diags_array(among_ends.diagonal())).tocsr(),
        measured_sections(mesh, degree),
    )


def check_end_sections(end_sections: str) -> None:
    """Refuse another way in which end sections move."""
    check_choice("end_sections", end_sections, END_SECTIONS, "they move in one of these ways")


def condense(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pins: Sequence[NodalLoads],
    symmetry: SymmetryClass,
    solver: str | SharedSolver = "auto",
    end_sections: EndSections = "rigid",
    held: HeldEnds | None = None,
) -> CondensedClass:
    """Condense one symmetry class of a throw's meshed part.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    stiffness : sparse array
        Upper triangle of its stiffness.
    pins : sequence of NodalLoads
        Unit loads on each pin, from `fem.symmetry.unit_pin_loads`.
    symmetry : SymmetryClass
        The class, one of `fem.symmetry.symmetry_classes` of the part.
    solver : str or SharedSolver
        See `fem.solver.SharedSolver`; the classes of one mesh share a pattern.
    end_sections : {"rigid", "averaged"}
        Whether end sections move as rigid discs, or only their mean motions are given.
    held : HeldEnds, optional
        From `hold_ends`, which several classes share; by default those of rigid sections, and unused with
        averaged ones.

    Raises
    ------
    InputError
        If `end_sections` is neither.
    SolveError
        If the system cannot be solved, or its solutions fail the check of reciprocity.
    """
    check_end_sections(end_sections)
    pin_loads, components = _pin_loads(mesh, pins, symmetry)
    shared = solver if isinstance(solver, SharedSolver) else SharedSolver(solver)
    # The meshed part carries its share of a load on the whole pin.
    shares = pin_loads / symmetry.copies
    ends = _end_unknowns(mesh, symmetry)
    if end_sections == "rigid":
        held = held or hold_ends(mesh, stiffness, 0)
        sections = held.sections
        section_motions = [m for _, m in unit_end_motions(mesh, symmetry, sections)]
        motions = np.concatenate(section_motions).reshape(len(held.ends), -1)
        solved, forces = solve_given_ends(mesh, held, motions, shares, symmetry, shared)
    else:
        sections = RIGID
        solved = np.hstack(_with_averaged_ends(mesh, stiffness, shares, symmetry, shared))
        forces = symmetric_product(stiffness, solved)
        forces[:, -len(components) :] -= shares
    if shared is not solver:
        shared.close()
    count = solved.shape[1] - len(components)
    fields, pin_fields = solved[:, :count], solved[:, count:]
    energy = fields.T @ forces[:, :count]
    works, reactions = np.zeros((2, len(pins), count, 6))
    # The solutions hold the meshed part; forces on the whole throw are so many times theirs.
    holding = symmetry.copies * forces[ends, count:]
    for column, (pin, component) in enumerate(components):
        works[pin, :, component] = pin_loads[:, column] @ fields
        reactions[pin, :, component] = -fields[ends].T @ holding[:, column]
    flexibility = pin_loads.T @ pin_fields
    symmetric, end_forces = 0.5 * (energy + energy.T), fields[ends].T @ forces[ends, :count]
    amplitudes = end_amplitudes(symmetry, sections)
    check_reciprocity(amplitudes, (symmetric, end_forces), (works, reactions), mesh.length)
    return CondensedClass(
        symmetry=symmetry,
        stiffness=symmetric,
        fields=fields.reshape(-1, 3, count),
        pin_loads=works,
        pin_components=components,
        pin_fields=pin_fields.reshape(len(mesh.points), 3, len(components)),
        pin_flexibility=0.5 * (flexibility + flexibility.T),
        solver=shared.solver,
        end_sections=end_sections,
        end_forces=end_forces,
        pin_reactions=reactions,
        sections=sections,
    )


def measured_sections(mesh: ThrowMesh, degree: int) -> SectionMotions:
    """Motions up to a degree of a throw's end sections, from their meshed size.

    The bore is that of the same area about the axis; the wider section counts, and its bore.
    """
    if degree == 0:
        return RIGID
    return SectionMotions(degree, *section_ring(end_surfaces(mesh), mesh.points))


def end_surfaces(mesh: ThrowMesh) -> list[LoadedSurface]:
    """Return the meshed end sections."""
    return [end_surface(mesh, section) for section in end_sections(axial_class(mesh.part))]


def section_ring(surfaces: Sequence[LoadedSurface], points: Array) -> tuple[float, float]:
    """Radius of the wider one of end sections, and that of its bore [m], from a mesh's points (n, 3)."""
    rings = []
    for surface in surfaces:
        radius = float(np.hypot(*points[surface.nodes, :2].T).max())
        area = len(surface.images) * float(np.linalg.norm(surface.areas, axis=1).sum())
        rings.append((radius, 1.0 - area / (np.pi * radius**2)))
    radius, hollow = max(rings)
    return radius, radius * math.sqrt(hollow) if hollow > HOLLOW else 0.0


def _end_unknowns(mesh: ThrowMesh, symmetry: SymmetryClass) -> Integers:
    """Displacements, of 3 n, of the nodes on the meshed end sections."""
    nodes = np.concatenate([nodes_on(mesh, section) for section in end_sections(symmetry)])
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _pin_loads(
    mesh: ThrowMesh, pins: Sequence[NodalLoads], symmetry: SymmetryClass
) -> tuple[Array, Integers]:
    """Loads (3 n, a) of the class, whose work is that on the whole throw, and what they are (a, 2)."""
    carried = np.flatnonzero(symmetry.central_motions)
    components = np.array(
        [(pin, component) for pin in range(len(pins)) for component in carried], dtype=np.int64
    ).reshape(-1, 2)
    loads = np.zeros((len(mesh.points), 3, len(components)))
    for pin, unit in enumerate(pins):
        columns = slice(pin * len(carried), (pin + 1) * len(carried))
        loads[unit.nodes, :, columns] = unit.of_class(symmetry)[..., carried]
    return loads.reshape(3 * len(mesh.points), len(components)), components


def blocked_unknowns(mesh: ThrowMesh, symmetry: SymmetryClass, ends: bool = True) -> Flags:
    """Which displacements (n, 3) the cuts block, and the end sections if `ends`."""
    blocked = np.zeros((len(mesh.points), 3), dtype=bool)
    for surface, axes in symmetry.blocked_axes().items():
        blocked[np.ix_(nodes_on(mesh, surface), np.array(axes))] = True
    if ends:
        for section in end_sections(symmetry):
            blocked[nodes_on(mesh, section)] = True
    return blocked


def solve_given_ends(
    mesh: ThrowMesh,
    held: HeldEnds,
    motions: Array,
    loads: Array,
    symmetry: SymmetryClass,
    solver: SharedSolver,
) -> tuple[Array, Array]:
    """Find fields and forces (3 n, k + a) of motions (h, k) of the end sections, and of loads (3 n, a).

    Forces are those beside the loads, which hold the end sections and where the class blocks the cuts.
    """
    count = motions.shape[1]
    fields, forces = np.zeros((2, mesh.points.size, count + loads.shape[1]))
    fields[held.ends, :count] = motions
    # What is prescribed acts as a load on the free unknowns.
    sides = np.hstack([-(held.coupling @ motions), loads[held.free]])
    blocked = blocked_unknowns(mesh, symmetry).ravel()[held.free]
    sides[blocked] = 0.0
    factors = solver.factorize(uncoupled(held.inner, blocked))
    with solver.watch.lap("solves"):
        fields[held.free], residual = factors.solve_with_residual(sides)
    forces[held.free] = -residual
    forces[held.ends] = held.coupling.T @ fields[held.free]
    forces[held.ends] += held.between_ends @ fields[held.ends]
    forces[held.ends, count:] -= loads[held.ends]
    return fields, forces


def unit_end_motions(
    mesh: ThrowMesh,
    symmetry: SymmetryClass,
    sections: SectionMotions = RIGID,
    shift: Array | None = None,
) -> list[tuple[Integers, Array]]:
    """Nodes (s,) of each meshed end section, and their displacements (s, 3, k) for unit amplitudes.

    With a `shift` (n, 3) nodes are so far from their places [m].
    """
    points = mesh.points if shift is None else mesh.points + shift
    ends = end_amplitudes(symmetry, sections)
    beyond = 12 + sections.bending * np.arange(3)
    columns = []
    for place, section in enumerate(end_sections(symmetry)):
        nodes = nodes_on(mesh, section)
        numbers = np.r_[6 * place : 6 * place + 6, beyond[place] : beyond[place + 1]]
        columns.append((nodes, sections.fields(points[nodes]) @ ends[numbers]))
    return columns


def uncoupled(upper: sparse.csr_array, blocked: Flags) -> sparse.csr_array:
    """Let blocked unknowns (f,) stay zero; the pattern (f, f) stays what it is in all classes."""
    rows = np.repeat(np.arange(upper.shape[0]), np.diff(upper.indptr))
    cut = (blocked[rows] | blocked[upper.indices]) & (rows != upper.indices)
    values = np.where(cut, 0.0, upper.data)
    return sparse.csr_array((values, upper.indices, upper.indptr), upper.shape)


def _with_averaged_ends(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pin_loads: Array,
    symmetry: SymmetryClass,
    solver: SharedSolver,
) -> tuple[Array, Array]:
    """Fields (3 n, k) of unit mean motions of the end sections, and (3 n, a) of loads on the pins.

    The end loads are the multipliers that keep the mean motions. As long as loads are in equilibrium
    the support of the part does not matter, so it is held at as many unknowns as it has rigid
    motions; the right rigid motion is added afterwards.
    """
    from scipy.linalg import null_space, qr  # here: rigid sections do without

    # Loads of the class whose work is the mean motions of the meshed end sections.
    columns = []
    for section in end_sections(symmetry):
        unit = unit_end_loads(mesh, section)
        section_loads = np.zeros((len(mesh.points), 3, len(symmetry.end_unknowns)))
        section_loads[unit.nodes] = unit.of_class(symmetry)[..., symmetry.end_unknowns]
        columns.append(section_loads.reshape(3 * len(mesh.points), -1))
    end_loads = np.hstack(columns)
    # The rigid motions that the class has, about the throw's middle, of similar sizes.
    arms = mesh.points - (0.0, 0.0, 0.5 * mesh.length)
    motions = rigid_motions(arms) / ([1.0] * 3 + [mesh.length] * 3)
    rigid = motions[:, :, symmetry.central_motions].reshape(3 * len(arms), -1)
    rigid_ends = end_loads.T @ rigid
    blocked = blocked_unknowns(mesh, symmetry, ends=False).ravel()
    free = np.flatnonzero(~blocked)
    if rigid.shape[1]:
        _, _, order = qr(rigid[free].T, mode="economic", pivoting=True)
        blocked[free[order[: rigid.shape[1]]]] = True
    # Combinations of end loads in equilibrium, and end loads that balance the loads on the pins.
    balanced = null_space(rigid_ends.T) if rigid.shape[1] else np.eye(end_loads.shape[1])
    inverse = np.linalg.pinv(rigid_ends)
    balancing = -inverse.T @ (rigid.T @ pin_loads)
    loads = np.hstack([end_loads @ balanced, pin_loads + end_loads @ balancing])
    loads[blocked] = 0.0
    factors = solver.factorize(uncoupled(stiffness, blocked))
    with solver.watch.lap("solves"):
        solution = factors.solve(loads)
    count = balanced.shape[1]
    elastic, pin_fields = solution[:, :count], solution[:, count:]

    flexibility = balanced.T @ (end_loads.T @ elastic)
    fields = elastic @ np.linalg.solve(flexibility, balanced.T)
    fields += rigid @ (inverse @ (np.eye(end_loads.shape[1]) - end_loads.T @ fields))
    pin_fields = pin_fields - fields @ (end_loads.T @ pin_fields)
    return fields, pin_fields


def nodes_on(mesh: ThrowMesh, surface: str) -> Integers:
    """Nodes (corners and edge middles) on one of the end sections or plane cuts."""
    axis, position = {
        LEFT_END: (2, 0.0),
        RIGHT_END: (2, mesh.length),
        CRANK_PLANE: (0, 0.0),
        MIDDLE_PLANE: (2, 0.5 * mesh.length),
    }[surface]
    tolerance = 1e-9 * float(np.abs(mesh.points).max())
    return np.flatnonzero(np.abs(mesh.points[:, axis] - position) < tolerance)


# Places of the unknowns of an end section.
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Superelement:
    """A throw condensed to the motions of its end sections.

    A single throw has rigid sections. Where throws meet its `joined` is used, with bending sections:
    2 b unknowns more, amplitudes [m] of motions of the left and then of the right section without external
    forces. With these held at zero it is the superelement of rigid sections again.

    Attributes
    ----------
    stiffness : (12, 12) array
        Unknowns ux uy uz rx ry rz of the left, then of the right end section, in the throw frame; (12 + 2 b,
        12 + 2 b) with bending sections, mean motions of the sections first.
    pin_loads : (pins, 12, 6) array
        End loads equivalent to unit forces along x, y, z on each pin, and unit moments about them at its
        center: with end forces F and loads p on pin k the end motions q satisfy
        ``stiffness @ q = F + pin_loads[k] @ p``.
    pin_flexibility : (6 pins, 6 pins) array
        Mean motions of the pins under these loads, the end sections held; motions of the ends add
        ``pin_loads[k].T @ q``.
    radials : (pins, 3) array
        Direction of a radial force on each pin, towards the shaft.
    missing : float
        For uncorrected results: their largest deficit, as a share.
    sections : SectionMotions
        Allowed motion of the sections.
    bending : Superelement or None
        For a throw with rigid sections: the same with bending sections.
    """

    stiffness: Array
    pin_loads: Array
    pin_flexibility: Array
    radials: Array
    missing: float = 0.0
    sections: SectionMotions = RIGID
    bending: "Superelement | None" = field(default=None, repr=False)

    @property
    def joined(self) -> "Superelement":
        """The superelement where throws meet: with bending sections, if the throw was solved with them."""
        return self.bending or self

    def with_sections(self, sections: Sections) -> "Superelement":
        """Return the superelement with fewer section motions where throws meet.

        Raises
        ------
        InputError
            If more are requested than the throw was solved with.
        """
        whole = self.joined
        kept = whole.sections.up_to(sections)
        if not kept.bending:
            return replace(self, bending=None)
        beyond = 12 + np.arange(kept.bending)
        unknowns = np.r_[:12, beyond, beyond + whole.sections.bending]
        return replace(
            self,
            bending=replace(
                whole,
                stiffness=whole.stiffness[np.ix_(unknowns, unknowns)],
                pin_loads=whole.pin_loads[:, unknowns],
                sections=kept,
            ),
        )

    def shared_with(self, sections: SectionMotions) -> "Superelement":
        """Return the superelement in section motions over another ring, that of a neighbor's bore."""
        if sections == self.sections:
            return self
        shares = both_ends(self.sections.amplitudes_of(sections))
        return replace(
            self,
            stiffness=shares.T @ self.stiffness @ shares,
            pin_loads=shares.T @ self.pin_loads,
            sections=sections,
        )

    @property
    def pin_load(self) -> Array:
        """End loads (12, 3) of unit forces on the first pin."""
        return np.asarray(self.pin_loads[0, :, :3])

    def end_load(self, force: Array, pin: int = 0) -> Array:
        """End loads (12,) equivalent to a force (3,) on a pin, uniformly distributed."""
        return np.asarray(self.pin_loads[pin, :, :3] @ force)

    @property
    def radial_loads(self) -> Array:
        """End loads (12, pins) of a unit radial force on each pin."""
        return np.asarray(np.einsum("pqa,pa->qp", self.pin_loads[:, :, :3], self.radials))

    @property
    def tangential_loads(self) -> Array:
        """End loads (12, pins) of a unit force on each pin in the sense of rotation about +z."""
        along = -np.cross([0.0, 0.0, 1.0], self.radials)
        return np.asarray(np.einsum("pqa,pa->qp", self.pin_loads[:, :, :3], along))

    def turned(self, *, angle_deg: float) -> "Superelement":
        """Return the superelement of the throw turned by an angle [deg] about the shaft, +z.

        The motions are then in the shaft frame; pin loads stay in the frame of the throw.
        """
        both = section_turn(self.sections, math.radians(angle_deg))
        return replace(
            self,
            stiffness=both @ self.stiffness @ both.T,
            pin_loads=both @ self.pin_loads,
            bending=None if self.bending is None else self.bending.turned(angle_deg=angle_deg),
        )


def section_rotation(angle: float) -> Array:
    """Matrix (6, 6) that turns the motions of a section by an angle [rad] about z."""
    return np.asarray(np.kron(np.eye(2), rotation(angle)))


def combine_classes(
    classes: Sequence[CondensedClass], radials: Array = RADIAL[None]
) -> Superelement:
    """Build the superelement of a whole throw from all symmetry classes of its meshed part.

    Parameters
    ----------
    radials : (pins, 3) array
        Direction of a radial force on each pin; by default that of an only pin.

    Returns
    -------
    Superelement
        With rigid sections, and with bending ones as `bending` if the classes have them.
    """
    rigid = _combined([part.up_to(RIGID) for part in classes], radials)
    if not classes[0].sections.bending:
        return rigid
    return replace(rigid, bending=_combined(classes, radials))


def checked_superelement(
    classes: Sequence[CondensedClass], radials: Array, mesh: ThrowMesh
) -> Superelement:
    """Build the superelement of `combine_classes`, and check it with rigid and with bending sections.

    Raises
    ------
    SolveError
        As `fem.solver.check_superelement` does.
    """
    made = combine_classes(classes, radials)
    centers = [pin.center for pin in pin_surfaces(mesh)]
    for element in (made, *([made.bending] if made.bending else [])):
        check_superelement(element.stiffness, element.pin_loads, mesh.length, centers)
    return made


def _combined(classes: Sequence[CondensedClass], radials: Array) -> Superelement:
    """Return one superelement of all motions that the classes have."""
    sections = classes[0].sections
    size = 2 * sections.count
    stiffness = np.zeros((size, size))
    pin_loads = np.zeros((len(radials), size, 6))
    pin_flexibility = np.zeros((6 * len(radials),) * 2)
    for part in classes:
        shares = part.shares
        stiffness += part.symmetry.copies * shares.T @ part.stiffness @ shares
        pin_loads += shares.T @ part.pin_loads
        carried = part.pin_components @ (6, 1)
        pin_flexibility[np.ix_(carried, carried)] += part.pin_flexibility
    missing = max(part.missing for part in classes)
    return Superelement(stiffness, pin_loads, pin_flexibility, radials, missing, sections)


def superelement_of_end_forces(classes: Sequence[CondensedClass], radials: Array) -> Superelement:
    """Build the superelement of a throw a second time, from the forces on its end sections alone.

    The superelement is made of strain energies and of the pins' mean motions, which gives a symmetric
    stiffness even where a solution is poor. What has to hold the end sections, under motions of them and
    under loads on the pins, follows from the same displacements without that symmetry: how far the two
    differ is how far the displacements are out of equilibrium. Work and its reverse are equal (E. Betti,
    Il Nuovo Cimento 7-8, 1872), for the two are solutions under different loads.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the meshed part.
    radials : (pins, 3) array
        Direction of a radial force on each pin.

    Returns
    -------
    Superelement
        Its stiffness is symmetric, and its pin loads are those of `combine_classes`, only as far as
        the solutions are in equilibrium.
    """
    return combine_classes(
        [
            replace(part, stiffness=part.end_forces, pin_loads=part.pin_reactions)
            for part in classes
        ],
        radials,
    )


# Attributes of a shaft's compliances: SI unit, and what they are; the first three of each throw alone.
ALONE = ("axial", "torsional", "through")
SHOWN: Mapping[str, tuple[str, str]] = {
    "axial": ("m/N", "axial compliance"),
    "torsional": ("rad/(N m)", "torsional compliance"),
    "through": ("1/N", "lengthening per torque through the shaft"),
    "influence": ("m/N", "lengthening per radial force"),
    "tangential": ("m/N", "lengthening per tangential force"),
}


@result("axial", "torsional", "influence")
class ShaftCompliances(Result):
    """Compliances and influence coefficients of each throw in a shaft.

    Each section is in its main bearing, laterally rigid or elastic, and tilts freely; the first one is
    held axially and against rotation; forces act along the whole shaft.

    Attributes
    ----------
    axial : (n,) array
        Lengthening of each throw per unit axial force through the shaft, e_n [m/N].
    torsional : (n,) array
        Twist of each throw per unit torque through the shaft [rad/(N m)].
    influence : (n, n) array
        Lengthening of throw i per unit radial force Z on the pin of throw j, the shaft axially free
        [m/N]; its diagonal is each throw's own c. Throws of several pins have a column for each of
        them: columns then follow the pins along the shaft, (n, all pins).
    tangential : (n, all pins) array
        The same per unit tangential force on a pin, in the sense of positive rotation about +z, its
        torque reacted at the first section [m/N].
    through : (n,) array
        Lengthening of each throw per unit torque about +z at the last section, reacted at the first
        [1/N].
    """

    axial: Annotated[Array, Quantity("m/N")]
    torsional: Annotated[Array, Quantity("rad/(N m)")]
    influence: Annotated[Array, Quantity("m/N")]
    tangential: Internal[Array]
    through: Internal[Array]

    def plot(
        self,
        axes: Axes | None = None,
        *,
        quantity: Literal["axial", "torsional", "through", "influence", "tangential"] = "axial",
    ) -> Axes:
        """Draw one of the attributes: bars by throw, or a table colored by value.

        Parameters
        ----------
        quantity : {"axial", "torsional", "through", "influence", "tangential"}
            The last two are tables of throws and pins.

        Raises
        ------
        InputError
            If the quantity is unknown.
        """
        check_choice("quantity", quantity, SHOWN, "a shaft has these")
        unit, words = SHOWN[quantity]
        text, size = display_unit(unit)
        values = getattr(self, quantity) / size
        axes = new_axes(axes)
        throws = [str(number) for number in range(1, len(self.axial) + 1)]
        if values.ndim == 1:
            draw_groups(axes, throws, {words: values}, f"{words} [{text}]")
            write_title(axes, "Throws at their places in the shaft")
        else:
            pins = [str(number) for number in range(1, values.shape[1] + 1)]
            draw_matrix(axes, values, throws, pins)
            axes.set_ylabel("throw that is lengthened")
            write_title(axes, f"{words.capitalize()} [{text}]")
        axes.set_xlabel("throw" if values.ndim == 1 else "loaded pin")
        return axes

    def to_pandas(self) -> Any:
        """Return a table of each throw's own values; `to_xarray` has those by pins and throws.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table(
            {"throw": (np.arange(1, len(self.axial) + 1), "")}
            | {name: (getattr(self, name), SHOWN[name][0]) for name in ALONE}
        )

    def to_xarray(self) -> Any:
        """Return all attributes over throws and pins, numbered from 1.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        return grid(
            {
                name: (("throw",) if name in ALONE else ("throw", "pin"), getattr(self, name), *how)
                for name, how in SHOWN.items()
            },
            {
                "throw": (np.arange(1, len(self.axial) + 1), "", "throw from the free end"),
                "pin": (np.arange(1, self.influence.shape[1] + 1), "", "pin from the free end"),
            },
        )


def sharing_sections(throws: Sequence[Superelement]) -> list[Superelement]:
    """Return throws as used in a shaft, with the same section motions.

    Those of the widest section, of the lowest degree that a throw was solved with. If adjacent journals
    differ in diameter or bore, both move as the same polynomials.
    """
    lowest = min(
        (throw.joined.sections for throw in throws), key=lambda sections: sections.degree
    ).sections
    joined = [throw.with_sections(lowest).joined for throw in throws]
    widest = max(
        (throw.sections for throw in joined), key=lambda sections: (sections.radius, sections.bore)
    )
    return [throw.shared_with(widest) for throw in joined]


def shaft_unknowns(place: int, throws: int, bending: int) -> Integers:
    """Unknowns of a throw by its index in a row: sections of six, then the motions beyond them."""
    beyond = 6 * (throws + 1) + bending * place
    return np.concatenate([6 * place + np.arange(12), beyond + np.arange(2 * bending)])


def assemble_shaft(throws: Sequence[Superelement]) -> Array:
    """Stiffness (n (s + 1), n (s + 1)) of s throws in a row, each already turned to its crank angle.

    Unknowns are the mean motions of the sections, six each, and then the motions of bending sections.
    """
    sections = throws[0].sections
    stiffness = np.zeros((sections.count * (len(throws) + 1),) * 2)
    for place, throw in enumerate(throws):
        unknowns = shaft_unknowns(place, len(throws), sections.bending)
        stiffness[np.ix_(unknowns, unknowns)] += throw.stiffness
    return stiffness


def solve_shaft(
    throws: Sequence[Superelement], loads: Array, bearing_stiffness: ArrayLike = math.inf
) -> Array:
    """Solve for the section motions of a shaft in its main bearings.

    Parameters
    ----------
    throws : sequence of n Superelement
        Each already turned to its crank angle, all with the same section motions.
    loads : (u, k) array
        On the unknowns of `assemble_shaft`: forces and moments on the sections first. The first section is
        held axially and against rotation.
    bearing_stiffness : float or (n + 1,) array_like, optional
        Lateral, of each main bearing or of all [N/m]; ``math.inf`` for rigid ones. Zero for all is the limit
        of ever softer equal bearings, which carry the unbalanced part of the loads.

    Returns
    -------
    (u, k) array
        Motions; of a shaft without bearings relative to its first and last section.

    Raises
    ------
    InputError
        If a stiffness is negative or not a number, there is not one for each section, or just one is above
        zero, about which the shaft would swing.
    """
    sections = len(throws) + 1
    lateral = _lateral_stiffness(bearing_stiffness, sections)
    stiffness = assemble_shaft(throws)
    across = 6 * np.arange(sections)[:, None] + [UX, UY]
    size = len(stiffness)
    blocked = np.zeros(size, dtype=bool)
    blocked[[UZ, RZ]] = True
    if np.any(lateral > 0.0):
        elastic = np.isfinite(lateral)
        blocked[across[~elastic]] = True
        stiffness[across[elastic], across[elastic]] += lateral[elastic, None]
        return _solve(stiffness, loads, blocked)
    # The shaft is held at its ends, where no force is left once equal bearings have balanced the loads.
    ends = across[[0, -1]].ravel()
    blocked[ends] = True
    rigid = np.zeros((size, 4))
    rigid[ends] = np.eye(4)
    rigid[~blocked] = -np.linalg.solve(
        stiffness[np.ix_(~blocked, ~blocked)], stiffness[np.ix_(~blocked, ends)]
    )
    held = rigid[across.ravel()]
    balanced = np.array(loads, dtype=np.float64)
    balanced[across.ravel()] -= held @ np.linalg.solve(held.T @ held, rigid.T @ loads)
    return _solve(stiffness, balanced, blocked)


def _solve(stiffness: Array, loads: Array, blocked: Flags) -> Array:
    motions = np.zeros_like(loads, dtype=np.float64)
    motions[~blocked] = np.linalg.solve(stiffness[np.ix_(~blocked, ~blocked)], loads[~blocked])
    return motions


def _lateral_stiffness(stiffness: ArrayLike, sections: int) -> Array:
    lateral = np.asarray(stiffness, dtype=np.float64)
    if lateral.shape not in ((), (sections,)):
        raise InputError(
            f"bearing_stiffness: given an array of shape {lateral.shape}; allowed is one number for all, or "
            f"one for each of the {sections} sections, because throws side by side share a bearing."
        )
    lateral = np.broadcast_to(lateral, sections)
    if not np.all(lateral >= 0.0) or np.count_nonzero(lateral) == 1:
        raise InputError(
            f"bearing_stiffness: given {lateral.tolist()}; allowed are numbers of zero or more (infinite: "
            "rigid), two of them above zero or none, because a shaft in one bearing swings about it."
        )
    return lateral


def shaft_compliances(
    throws: Sequence[Superelement],
    *,
    crank_angles_deg: Sequence[float],
    bearing_stiffness: ArrayLike = math.inf,
) -> ShaftCompliances:
    """Find the compliances of each throw in a crankshaft.

    Parameters
    ----------
    throws : sequence of n Superelement
        From the free end, each in its own throw frame. Their sections bend where throws meet, if
        solved so, and are free at the ends of the shaft.
    crank_angles_deg : sequence of n float
        Angle of each crank about +z [deg].
    bearing_stiffness : float or (n + 1,) array_like, optional
        Lateral, of the main bearings; see `solve_shaft`.

    Raises
    ------
    InputError
        If there is not one angle for each throw, or as `solve_shaft` for the bearings.

    Notes
    -----
    With rigid sections and without lateral restraint (zero) every throw has its pinned compliances, axial and
    torsional, whatever the angles to its neighbors, and nearly so with sections that bend: an axial force
    through the section centers and a torque about their line load each throw independently, so the
    common journal carries no bending moment and no lateral force, and tilts and moves freely.
    Only bearings that hold the journals on one line couple the throws.
    """
    if not throws or len(throws) != len(crank_angles_deg):
        raise InputError(
            f"crank_angles_deg: given {len(crank_angles_deg)} for {len(throws)} throws; allowed is "
            "one for each of at least one throw."
        )
    for place, throw in enumerate(throws):
        check_kind(
            f"throws[{place}]", throw, Superelement, "a Superelement, as the one of an analysis"
        )
    count = len(throws)
    angles = finite_vector("crank_angles_deg", crank_angles_deg).tolist()
    refuse_crank_radians("crank_angles_deg", angles)
    turned = [
        throw.turned(angle_deg=angle)
        for throw, angle in zip(sharing_sections(throws), angles, strict=True)
    ]
    sections = turned[0].sections
    size = sections.count * (count + 1)
    pulls = np.zeros((size, 2))
    pulls[[6 * count + UZ, 6 * count + RZ], [0, 1]] = 1.0

    def on_shaft(place: int, loads: Array) -> Array:
        spread = np.zeros((size, loads.shape[1]))
        spread[shaft_unknowns(place, count, sections.bending)] = loads
        return spread

    radial = [on_shaft(place, throw.radial_loads) for place, throw in enumerate(turned)]
    tangential = [on_shaft(place, throw.tangential_loads) for place, throw in enumerate(turned)]
    loads = np.hstack([pulls, *radial, *tangential])
    motions = solve_shaft(turned, loads, bearing_stiffness)[: 6 * (count + 1)]
    stretch = np.diff(motions[UZ::6], axis=0)
    twist = np.diff(motions[RZ::6], axis=0)
    by_radial, by_tangential = np.split(stretch[:, 2:], 2, axis=1)
    return ShaftCompliances(stretch[:, 0], twist[:, 1], by_radial, by_tangential, stretch[:, 1])
