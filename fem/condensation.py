"""Static condensation of a throw's meshed part to the motions of its end sections.

End sections are either rigid discs, or "averaged": only their mean translations and rotations are
given, and they warp freely under tractions of uniform and linear distribution. A real section is
stiffer than the second and softer than the first, so the two are bounds. In addition to rigid
motions those of bending sections can be included (`fem.symmetry`) with one factorization.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import block_diag, null_space, qr

from crankbase.errors import InputError
from fem.assembly import symmetric_product
from fem.loads import NodalLoads, end_sections, end_surface, rigid_motions, unit_end_loads
from fem.solver import SharedSolver, Stopwatch, check_reciprocity
from fem.symmetry import RIGID, SectionMotions, SymmetryClass, amplitude_shares, axial_class
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

Array = NDArray[np.float64]
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
    pin_components: NDArray[np.int64]
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


def end_amplitudes(symmetry: SymmetryClass, sections: SectionMotions) -> Array:
    """Motions (2 n, k) of both end sections for unit amplitudes of a class; see `CondensedClass.ends`."""
    beyond = symmetry.unit_motions(sections.mirror_x[6:], sections.mirror_z[6:])
    return np.asarray(block_diag(symmetry.ends, beyond))


def condense(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pins: Sequence[NodalLoads],
    symmetry: SymmetryClass,
    solver: str | SharedSolver = "auto",
    end_sections: EndSections = "rigid",
    watch: Stopwatch | None = None,
    degree: int = 0,
) -> CondensedClass:
    """Condense one symmetry class of a throw's meshed part.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    stiffness : sparse array
        Upper triangle of its stiffness.
    pins : sequence of NodalLoads
        Unit loads on each pin, from `fem.loads.unit_pin_loads`.
    symmetry : SymmetryClass
        The class, one of `fem.symmetry.symmetry_classes` of the part.
    solver : str or SharedSolver
        See `fem.solver.SharedSolver`; the classes of one mesh share a pattern.
    end_sections : {"rigid", "averaged"}
        Whether end sections move as rigid discs, or only their mean motions are given.
    watch : Stopwatch, optional
        Measures the time.
    degree : int
        Of the polynomials that end sections also move as; 0 for none, always so of averaged sections.

    Raises
    ------
    InputError
        If `end_sections` is neither.
    SolveError
        If the system cannot be solved, or its solutions fail the check of reciprocity.
    """
    if end_sections not in END_SECTIONS:
        raise InputError(
            f'end_sections: given {end_sections!r}; allowed are "rigid" and "averaged".'
        )
    watch = Stopwatch() if watch is None else watch
    pin_loads, components = _pin_loads(mesh, pins, symmetry)
    shared = solver if isinstance(solver, SharedSolver) else SharedSolver(solver, watch)
    # The meshed part carries its share of a load on the whole pin.
    shares = pin_loads / symmetry.copies
    if end_sections == "rigid":
        sections = measured_sections(mesh, degree)
        prescribed = unit_end_motions(mesh, symmetry, sections)
        solved = _with_given_ends(mesh, stiffness, shares, symmetry, prescribed, shared, watch)
    else:
        sections = RIGID
        solved = _with_averaged_ends(mesh, stiffness, shares, symmetry, shared, watch)
    fields, pin_fields = solved
    if shared is not solver:
        shared.close()
    count = fields.shape[1]
    forces = symmetric_product(stiffness, fields)
    energy = fields.T @ forces
    works, reactions = np.zeros((2, len(pins), count, 6))
    ends = _end_unknowns(mesh, symmetry)
    # The solutions hold the meshed part; forces on the whole throw are so many times theirs.
    held = symmetry.copies * (symmetric_product(stiffness, pin_fields) - shares)[ends]
    for column, (pin, component) in enumerate(components):
        works[pin, :, component] = pin_loads[:, column] @ fields
        reactions[pin, :, component] = -fields[ends].T @ held[:, column]
    flexibility = pin_loads.T @ pin_fields
    symmetric, end_forces = 0.5 * (energy + energy.T), fields[ends].T @ forces[ends]
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
    rings = []
    for section in end_sections(axial_class(mesh.part)):
        surface = end_surface(mesh, section)
        radius = float(np.hypot(*mesh.points[surface.nodes, :2].T).max())
        area = len(surface.images) * float(np.linalg.norm(surface.areas, axis=1).sum())
        rings.append((radius, 1.0 - area / (np.pi * radius**2)))
    radius, hollow = max(rings)
    return SectionMotions(degree, radius, radius * math.sqrt(hollow) if hollow > HOLLOW else 0.0)


def _end_unknowns(mesh: ThrowMesh, symmetry: SymmetryClass) -> NDArray[np.int64]:
    """Displacements, of 3 n, of the nodes on the meshed end sections."""
    nodes = np.concatenate([nodes_on(mesh, section) for section in end_sections(symmetry)])
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def _pin_loads(
    mesh: ThrowMesh, pins: Sequence[NodalLoads], symmetry: SymmetryClass
) -> tuple[Array, NDArray[np.int64]]:
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


def blocked_unknowns(
    mesh: ThrowMesh, symmetry: SymmetryClass, ends: bool = True
) -> NDArray[np.bool_]:
    """Which displacements (n, 3) the cuts block, and the end sections if `ends`."""
    blocked = np.zeros((len(mesh.points), 3), dtype=bool)
    for surface, axes in symmetry.blocked_axes().items():
        blocked[np.ix_(nodes_on(mesh, surface), np.array(axes))] = True
    if ends:
        for section in end_sections(symmetry):
            blocked[nodes_on(mesh, section)] = True
    return blocked


def _with_given_ends(
    mesh: ThrowMesh,
    stiffness: sparse.csr_array,
    pin_loads: Array,
    symmetry: SymmetryClass,
    ends: list[tuple[NDArray[np.int64], Array]],
    solver: SharedSolver,
    watch: Stopwatch,
) -> tuple[Array, Array]:
    """Fields (3 n, k) of given unit motions of the end sections, and (3 n, a) of loads on the pins."""
    count = ends[0][1].shape[2]
    prescribed = np.zeros((len(mesh.points), 3, count))
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    for nodes, motions in ends:
        prescribed[nodes], held[nodes] = motions, True
    free = np.flatnonzero(~held.ravel())
    blocked = blocked_unknowns(mesh, symmetry).ravel()[free]
    fields = prescribed.reshape(-1, count)
    # What is prescribed acts as a load on the free unknowns.
    loads = np.hstack([-symmetric_product(stiffness, fields)[free], pin_loads[free]])
    loads[blocked] = 0.0
    factors = solver.factorize(uncoupled(stiffness[free][:, free].tocsr(), blocked))
    with watch.lap("solves"):
        solution = factors.solve(loads)
    fields[free] = solution[:, :count]
    pin_fields = np.zeros_like(pin_loads)
    pin_fields[free] = solution[:, count:]
    return fields, pin_fields


def unit_end_motions(
    mesh: ThrowMesh, symmetry: SymmetryClass, sections: SectionMotions = RIGID
) -> list[tuple[NDArray[np.int64], Array]]:
    """Nodes (s,) of each meshed end section, and their displacements (s, 3, k) for unit amplitudes."""
    ends = end_amplitudes(symmetry, sections)
    beyond = 12 + sections.bending * np.arange(3)
    columns = []
    for place, section in enumerate(end_sections(symmetry)):
        nodes = nodes_on(mesh, section)
        numbers = np.r_[6 * place : 6 * place + 6, beyond[place] : beyond[place + 1]]
        columns.append((nodes, sections.fields(mesh.points[nodes]) @ ends[numbers]))
    return columns


def uncoupled(upper: sparse.csr_array, blocked: NDArray[np.bool_]) -> sparse.csr_array:
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
    watch: Stopwatch,
) -> tuple[Array, Array]:
    """Fields (3 n, k) of unit mean motions of the end sections, and (3 n, a) of loads on the pins.

    The end loads are the multipliers that keep the mean motions. As long as loads are in equilibrium
    the support of the part does not matter, so it is held at as many unknowns as it has rigid
    motions; the right rigid motion is added afterwards.
    """
    end_loads = _end_loads(mesh, symmetry)
    rigid = _class_rigid_motions(mesh, symmetry)
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
    with watch.lap("solves"):
        solution = factors.solve(loads)
    count = balanced.shape[1]
    elastic, pin_fields = solution[:, :count], solution[:, count:]

    flexibility = balanced.T @ (end_loads.T @ elastic)
    fields = elastic @ np.linalg.solve(flexibility, balanced.T)
    fields += rigid @ (inverse @ (np.eye(end_loads.shape[1]) - end_loads.T @ fields))
    pin_fields = pin_fields - fields @ (end_loads.T @ pin_fields)
    return fields, pin_fields


def _end_loads(mesh: ThrowMesh, symmetry: SymmetryClass) -> Array:
    """Loads (3 n, k) of the class whose work is the mean motions of the meshed end sections."""
    columns = []
    for section in end_sections(symmetry):
        unit = unit_end_loads(mesh, section)
        loads = np.zeros((len(mesh.points), 3, len(symmetry.end_unknowns)))
        loads[unit.nodes] = unit.of_class(symmetry)[..., symmetry.end_unknowns]
        columns.append(loads.reshape(3 * len(mesh.points), -1))
    return np.hstack(columns)


def _class_rigid_motions(mesh: ThrowMesh, symmetry: SymmetryClass) -> Array:
    """Displacements (3 n, r) of the rigid motions that the class has, about the throw's middle.

    Rotations are divided by the throw's length, so that all have similar size.
    """
    arms = mesh.points - (0.0, 0.0, 0.5 * mesh.length)
    motions = rigid_motions(arms) / ([1.0] * 3 + [mesh.length] * 3)
    return motions[:, :, symmetry.central_motions].reshape(3 * len(arms), -1)


def nodes_on(mesh: ThrowMesh, surface: str) -> NDArray[np.int64]:
    """Nodes (corners and edge middles) on one of the end sections or plane cuts."""
    axis, position = {
        LEFT_END: (2, 0.0),
        RIGHT_END: (2, mesh.length),
        CRANK_PLANE: (0, 0.0),
        MIDDLE_PLANE: (2, 0.5 * mesh.length),
    }[surface]
    tolerance = 1e-9 * float(np.abs(mesh.points).max())
    return np.flatnonzero(np.abs(mesh.points[:, axis] - position) < tolerance)
