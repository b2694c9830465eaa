"""How a throw's answers change with its dimensions, from the solutions of one analysis.

When a dimension changes, the mesh moves with the solid: v is the velocity of its nodes. The energy of two
displacement fields u and w that are solutions for prescribed motions of the end sections changes by

    integral of [ s(u):e(w) div v - s(u):(grad w grad v) - s(w):(grad u grad v) ]

the work of Eshelby's configurational stress on grad v (J. D. Eshelby, Phil. Trans. R. Soc. A 244, 1951,
87-112), and by the work of the forces on the end sections where the motion prescribed at a node changes
with its place. No further displacement is solved for. Only the motion of the surface matters, along its
normal; inside, nodes move as smoothly as that lets them.

The correction of the answers for discretization changes as well (`fem.error_slopes`): slopes are those of the
corrected answers.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from scipy import sparse

from crankbase.array_checks import Array
from crankbase.choices import check_choice
from crankbase.diagrams import draw_rows, new_axes, write_title
from crankbase.errors import InputError
from crankbase.frames import table
from crankbase.results import Number, Quantity, Result, result
from fem.correction import effectivity
from fem.end_reactions import END_LOADS
from fem.error_slopes import ErrorAdjoint, error_adjoints
from fem.material import Material
from fem.solver import (
    QUADRATURE_ORDER,
    assemble_stiffness,
    factorize,
    physical_gradients,
    symmetric_product,
    upper_triangle,
)
from fem.superelement import (
    CondensedClass,
    Superelement,
    combine_classes,
    end_surfaces,
    nodes_on,
    section_ring,
    unit_end_motions,
)
from fem.supports import Support, axial_motion, pin_compliance, reactions, support_throw
from fem.symmetry import (
    RIGID,
    NodalLoads,
    SectionMotions,
    axial_class,
    end_sections,
    mirror_images,
    pin_surfaces,
    radial_directions,
)
from geometry.boundary_motion import STEP, BoundaryMotion, boundary_motion, lengths_of
from geometry.mesh import ThrowMesh
from geometry.shapes import EDGES, shapes_for_quadrature
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Stiffness that holds corners on the moving surface, in largest entries of the matrix.
HELD = 1e6
# Of an element in the motion of the nodes, beside one of the median density of the error.
LEAST_WEIGHT, MOST_WEIGHT = 1e-2, 1e4
# Surfaces that touch, as a fillet and its journal, have normals as parallel as this.
PARALLEL = 1e-3
# Numbers taken at once, so that they stay in the cache.
CACHED = 60_000
# With so many velocities for each field, products of fields cost less than those of both with velocities.
MANY = 2
# Differences of loads and prescribed motions, which are smooth, in lengths of the throw.
SHIFT = 1e-7
# A ring whose size grows less than so many per cent for one per cent of a dimension does not change with it.
SAME_RING = 1e-3
# Answers with slopes, besides mass and inertia.
SLOPED = (
    *("axial_compliance", "torsional_compliance", "influence_coefficient", "pin_compliance"),
    *END_LOADS,
)
# Exact for the volume of curved elements, and for their moment of inertia but for 1e-6 of it.
VOLUME_ORDER = 5
# Of the slopes of mass and inertia, for facets that the mesh's edges bend in one way only: at most 1e-3 on
# coarse meshes of random throws.
VOLUME_ERROR = 2e-3


@result("quantity", "support", "shares")
class Sensitivities(Result):
    """How an answer of a throw changes with each of its dimensions.

    ``sensitivities["web_width"]`` is the change in per cent for one per cent of the web width.

    Attributes
    ----------
    quantity, support : str
        The answer; mass and inertia depend on no support ("").
    shares : mapping
        d ln(answer) / d ln(dimension), by dimension ("counterweight.thickness").
    left_out : mapping
        Dimensions without one, and the reason.
    error : float
        Estimated error of each share, for discretization (docs/accuracy.md).
    """

    quantity: str
    support: str
    shares: Annotated[Mapping[str, float], Quantity("1")]
    left_out: Mapping[str, str]
    error: Number

    def __getitem__(self, dimension: str) -> float:
        """Return the share of a dimension.

        Raises
        ------
        InputError
            If it has none.
        """
        if dimension not in self.shares:
            why = self.left_out.get(dimension, "the throw has no such dimension with a number")
            raise InputError(
                f"dimension: given {dimension!r}; allowed are {', '.join(self.shares)}, because {why}."
            )
        return self.shares[dimension]

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw a bar for each dimension, the largest first."""
        axes = new_axes(axes, height=1.2 + 0.3 * len(self.shares))
        ordered = dict(sorted(self.shares.items(), key=lambda share: -abs(share[1])))
        names = [name.replace("_", " ").replace(".", ", ") for name in ordered]
        draw_rows(axes, names, [*ordered.values()], "per cent for one per cent of the dimension")
        title = f"{self.quantity.replace('_', ' ')} {self.support}".strip()
        write_title(axes, title[0].upper() + title[1:])
        return axes

    def to_pandas(self) -> Any:
        """Return a table, a row for each dimension.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        columns = {"dimension": ([*self.shares], ""), "share": ([*self.shares.values()], "1")}
        return table(columns).set_index("dimension")


class NodeMotion(NamedTuple):
    """Velocities (n, 3) of a mesh's nodes, by dimension; the rest as of a `BoundaryMotion`."""

    velocities: dict[str, Array]
    beside: dict[str, tuple[CrankThrow, CrankThrow]]
    left_out: dict[str, str]


@dataclass(frozen=True)
class DimensionChange:
    """Change of a throw with one of its dimensions.

    Attributes
    ----------
    throws : two CrankThrow
        With the dimension smaller and larger by the share `STEP`.
    ends : two Superelement
        Theirs, to first order.
    mass, inertia : float
        Change of the mass, and of the moment of inertia about the shaft, as a share for a share.
    """

    throws: tuple[CrankThrow, CrankThrow]
    ends: tuple[Superelement, Superelement]
    mass: float
    inertia: float

    def share(self, answer: Callable[[Superelement], float]) -> float:
        """Return d ln(answer) / d ln(dimension)."""
        low, high = map(answer, self.ends)
        return (high - low) / (0.5 * (high + low)) / (2.0 * STEP)


def sloped_answer(
    quantity: str, support: Support, pin: int, force: Array | None
) -> Callable[[Superelement], float]:
    """Return what finds an answer of a throw.

    Parameters
    ----------
    quantity : str
        One of `SLOPED`.
    support : "pinned", "guided" or Neighbors
    pin : int
        Which is loaded.
    force : (3,) array or None
        On it, for its compliance and for reactions [N]; None for a radial one of 1 N.

    Raises
    ------
    InputError
        If the quantity is none of these.
    """
    check_choice("quantity", quantity, (*SLOPED, "mass", "inertia"), "these have slopes")

    def answer(throw: Superelement) -> float:
        along = throw.radials[pin] if force is None else force
        if quantity in END_LOADS:
            ends = reactions(throw, support, throw.joined.pin_loads[pin, :, :3] @ along)
            parts = [part for end in (ends.left, ends.right) for part in (end.force, end.moment)]
            return float(np.concatenate(parts)[END_LOADS.index(quantity)])
        if quantity == "pin_compliance":
            moved = pin_compliance(throw, support, pin)[:3, :3] @ along
            return float(moved @ along / (along @ along))
        answers = support_throw(throw, support)
        compliances = answers.axial, answers.torsional, answers.influences[pin]
        return float(compliances[SLOPED.index(quantity)])

    return answer


def check_sloped(throw: object, end_sections: str) -> CrankThrow:
    """Return the throw if slopes can be found for it.

    Raises
    ------
    InputError
        If it is a CAD part, or its end sections are not rigid.
    """
    if not isinstance(throw, CrankThrow):
        raise InputError(
            "throw: given a CAD part; allowed for slopes is a throw by its dimensions, because they are "
            "over these."
        )
    if end_sections != "rigid":
        raise InputError(
            f"end_sections: given {end_sections!r}; allowed for slopes is 'rigid', because they "
            "follow from the forces on sections whose motion is prescribed."
        )
    return throw


def dimension_changes(
    throw: object,
    mesh: ThrowMesh,
    material: Material,
    classes: Sequence[CondensedClass],
    *,
    joined: bool,
    corrected: bool,
    moving: Collection[str] | NodeMotion | None = None,
) -> tuple[dict[str, DimensionChange], dict[str, str]]:
    """Find the change of a throw with its dimensions, and why some have none.

    Errors as of `check_sloped`.

    Parameters
    ----------
    joined : bool
        Whether also with the bending sections of throws that meet, which takes longer.
    corrected : bool
        Whether of the corrected throw, which takes as long as to solve it, or of the mesh's own answers.
    moving : collection of str or NodeMotion, optional
        Paths of the dimensions, all by default, with which the mesh moves as smoothly as its surface lets
        it; or the motion of a mesh that was moved.
    """
    solved = check_sloped(throw, classes[0].end_sections)
    parts = [part if joined else part.up_to(RIGID) for part in classes]
    plain = [part.discrete or part for part in parts]
    if isinstance(moving, NodeMotion):
        surface, motion = None, moving
    else:
        surface = boundary_motion(solved, mesh, moving)
        motion = NodeMotion({}, surface.beside, surface.left_out)
    if not (motion.velocities or (surface and surface.speeds)):
        return {}, motion.left_out
    adjoints = error_adjoints(mesh, material, plain) if corrected else None
    velocities = motion.velocities
    if surface is not None:
        errors = None if adjoints is None else np.sum([each.shares for each in adjoints], axis=0)
        velocities = node_velocities(mesh, surface, classes[0].solver, errors)
    motions = list(velocities.values())
    by_class = class_slopes(mesh, material, plain, motions, adjoints)
    masses = mass_slopes(mesh, motions)
    axial = [part.symmetry for part in plain].index(axial_class(mesh.part))
    if adjoints is None:
        parts = plain
    else:
        factor = effectivity(mesh, axial_share(plain[axial], adjoints[axial].energies))
    sizes, changes = lengths_of(solved), {}
    discs = end_surfaces(mesh) if joined else []
    ring_here = section_ring(discs, mesh.points) if discs else ()
    for path, of_classes, (mass, inertia) in zip(
        velocities, zip(*by_class, strict=True), masses, strict=True
    ):
        slopes = [*of_classes]
        ends = []
        if adjoints is not None:
            step = STEP * sizes[path]
            grown = effectivity_slope(mesh, plain[axial], adjoints[axial], slopes[axial], step)
            slopes = [
                slope.corrected(part, factor * slope.energies + grown * adjoint.energies)
                if part.discrete
                else slope
                for part, slope, adjoint in zip(parts, slopes, adjoints, strict=True)
            ]
        for sign, end in zip((-STEP, STEP), motion.beside[path], strict=True):
            step = sign * sizes[path]
            moved = [
                replace(
                    part,
                    stiffness=part.stiffness + step * slope.stiffness,
                    pin_loads=part.pin_loads + step * slope.pin_loads,
                    pin_flexibility=part.pin_flexibility + step * slope.pin_flexibility,
                )
                for part, slope in zip(parts, slopes, strict=True)
            ]
            made = combine_classes(moved, radial_directions(end))
            if made.bending:
                # What is held of a section that bends is its mean motion, over a ring that changes.
                points = mesh.points + step * velocities[path]
                surfaces = [disc.at(points[disc.nodes], disc.images) for disc in discs]
                ring = section_ring(surfaces, points)
                if not np.allclose(ring, ring_here, rtol=SAME_RING * STEP, atol=0.0):
                    sections = SectionMotions(made.bending.sections.degree, *ring)
                    made = replace(made, bending=made.bending.shared_with(sections))
            ends.append(made)
        changes[path] = DimensionChange(
            motion.beside[path], (ends[0], ends[1]), sizes[path] * mass, sizes[path] * inertia
        )
    return changes, motion.left_out


def axial_share(part: CondensedClass, energies: Array) -> float:
    """Estimated error of the axial compliance, pinned, as a share of it, by those of the axial class."""
    motion = axial_motion(part.up_to(RIGID), "pinned")
    rigid = slice(len(motion))
    return float(
        motion @ energies[rigid, rigid] @ motion / (motion @ part.stiffness[rigid, rigid] @ motion)
    )


def effectivity_slope(
    mesh: ThrowMesh, part: CondensedClass, adjoint: ErrorAdjoint, slope: "ClassSlopes", step: float
) -> float:
    """Derivative of the effectivity of estimated errors, over a step of the dimension either way."""
    ends = []
    for change in (-step, step):
        changed = replace(part, stiffness=part.stiffness + change * slope.stiffness)
        share = axial_share(changed, adjoint.energies + change * slope.energies)
        ends.append(effectivity(mesh, share))
    return (ends[1] - ends[0]) / (2.0 * step)


def mass_slopes(mesh: ThrowMesh, velocities: Sequence[Array]) -> list[tuple[float, float]]:
    """Relative changes of the meshed volume and its inertia about the shaft, by velocity of the nodes."""
    values, gradients, weights = shapes_for_quadrature(VOLUME_ORDER)
    corners = mesh.points[mesh.elements]
    spatial, volumes = physical_gradients(corners, gradients, weights)
    arms = values @ corners[:, :, :2]
    squares = np.sum(arms**2, axis=2)
    whole = volumes.sum(), np.sum(volumes * squares)
    # Of f = 1 and f = x^2 + y^2: the integral of f div v + grad f . v, by node and component.
    grown = np.einsum("mq,mqni->mni", volumes, spatial)
    spun = np.einsum("mq,mqni->mni", volumes * squares, spatial)
    spun[:, :, :2] += 2.0 * values.T @ (volumes[:, :, None] * arms)
    nodal = np.zeros((2, *mesh.points.shape))
    for total, by_element in zip(nodal, (grown, spun), strict=True):
        np.add.at(total, mesh.elements, by_element)
    changes = np.tensordot(velocities, nodal / np.reshape(whole, (2, 1, 1)), ([1, 2], [1, 2]))
    return [(float(mass), float(inertia)) for mass, inertia in changes]


def node_velocities(
    mesh: ThrowMesh, motion: BoundaryMotion, solver: str, errors: Array | None = None
) -> dict[str, Array]:
    """Velocities (n, 3) of a mesh's nodes, by dimension.

    Corners move as smoothly as the surface lets them: the sum of |grad v|^2 is least. With the elements'
    shares (m,) of the error it is weighed, so that those whose errors count keep their shape. Edge nodes
    move as their corners do, on the surface along its normal as they must.
    """
    corners, elements = np.unique(mesh.elements[:, :4], return_inverse=True)
    elements = elements.reshape(-1, 4)
    number = np.full(len(mesh.points), -1)
    number[corners] = np.arange(len(corners))
    # Gradients (m, 4, 3) of the four linear shape functions; products, weighed by six times the volume.
    sides = mesh.points[mesh.elements[:, 1:4]] - mesh.points[mesh.elements[:, :1]]
    others = np.linalg.inv(sides).transpose(0, 2, 1)
    gradients = np.concatenate([-others.sum(axis=1, keepdims=True), others], axis=1)
    volumes = np.abs(np.linalg.det(sides))
    weights = volumes
    if errors is not None:
        densities = errors / volumes
        weights = volumes * np.clip(densities / np.median(densities), LEAST_WEIGHT, MOST_WEIGHT)
    products = (gradients @ gradients.transpose(0, 2, 1)) * weights[:, None, None]
    laplacian = sparse.csr_array(
        (products.ravel(), (np.repeat(elements, 4, axis=1).ravel(), np.tile(elements, 4).ravel())),
        shape=(len(corners),) * 2,
    )
    here = number[motion.nodes] >= 0
    columns = 3 * number[motion.nodes[here], None] + np.arange(3)
    rows = np.broadcast_to(np.arange(len(columns))[:, None], columns.shape)
    conditions = sparse.csr_array(
        (motion.normals[here].ravel(), (rows.ravel(), columns.ravel())),
        shape=(len(columns), 3 * len(corners)),
    )
    held = HELD * float(laplacian.diagonal().max())
    matrix = sparse.kron(laplacian, np.eye(3)) + held * (conditions.T @ conditions)
    speeds = np.column_stack(list(motion.speeds.values()))
    with factorize(upper_triangle(matrix.tocsr()), solver) as factors:
        moved = factors.solve(held * np.asarray(conditions.T @ speeds[here]))
    velocities = np.zeros((len(mesh.points), 3, len(motion.speeds)))
    velocities[corners] = moved.reshape(len(corners), 3, -1)
    for node, (start, stop) in zip(range(4, 10), EDGES, strict=True):
        ends = velocities[mesh.elements[:, start]] + velocities[mesh.elements[:, stop]]
        velocities[mesh.elements[:, node]] = 0.5 * ends
    # On all surfaces that meet in a node, by the least further motion.
    nodes, place = np.unique(motion.nodes, return_inverse=True)
    order = np.argsort(place, kind="stable")
    first = np.searchsorted(place[order], np.arange(len(nodes)))
    which = np.arange(len(order)) - first[place[order]]
    normals = np.zeros((len(nodes), int(which.max()) + 1, 3))
    missed = np.zeros((*normals.shape[:2], speeds.shape[1]))
    along = np.einsum("ca,cad->cd", motion.normals, velocities[motion.nodes])
    normals[place[order], which] = motion.normals[order]
    missed[place[order], which] = (speeds - along)[order]
    velocities[nodes] += np.linalg.pinv(normals, rcond=PARALLEL) @ missed
    return dict(zip(motion.speeds, np.moveaxis(velocities, 2, 0), strict=True))


def load_slopes(mesh: ThrowMesh, velocities: Sequence[Array]) -> list[list[NodalLoads]]:
    """Derivatives of the unit loads on the pins, by velocity of the nodes."""
    surfaces, slopes = pin_surfaces(mesh), []
    # The end of the meshed part, which the throw's length follows.
    last, images = int(mesh.points[:, 2].argmax()), 2.0 if mesh.part == "quarter" else 1.0
    for velocity in velocities:
        step = _step(mesh, velocity)
        ends = []
        for shift in (-step, step):
            length = mesh.length + shift * images * velocity[last, 2]
            mirrors = mirror_images(replace(mesh, length=length))
            ends.append(
                [
                    surface.at(
                        mesh.points[surface.nodes] + shift * velocity[surface.nodes], mirrors
                    ).unit_loads()
                    for surface in surfaces
                ]
            )
        slopes.append(
            [
                replace(before, values=(after.values - before.values) / (2.0 * step))
                for before, after in zip(*ends, strict=True)
            ]
        )
    return slopes


def _step(mesh: ThrowMesh, velocity: Array) -> float:
    return SHIFT * mesh.length / (float(np.abs(velocity).max()) or 1.0)


@dataclass(frozen=True)
class ClassSlopes:
    """Derivatives of a condensed class.

    Attributes
    ----------
    stiffness, pin_loads, pin_flexibility : arrays
        As of a `CondensedClass`.
    energies : (r + a, r + a) array or float
        Those of the mutual energies of its errors with rigid sections [J]; 0 if not found.
    """

    stiffness: Array
    pin_loads: Array
    pin_flexibility: Array
    energies: Array | float = 0.0

    def corrected(self, part: CondensedClass, corrections: Array) -> "ClassSlopes":
        """Return those of the corrected class, by the derivatives (r + a, r + a) of its corrections [J]."""
        stiffness, loads = self.stiffness.copy(), self.pin_loads.copy()
        copies, rigid = part.symmetry.copies, len(corrections) - len(part.pin_components)
        pins, components = part.pin_components.T
        stiffness[:rigid, :rigid] -= corrections[:rigid, :rigid]
        loads[pins, :rigid, components] += copies * corrections[rigid:, :rigid]
        flexibility = self.pin_flexibility + copies * corrections[rigid:, rigid:]
        return replace(self, stiffness=stiffness, pin_loads=loads, pin_flexibility=flexibility)


def class_slopes(
    mesh: ThrowMesh,
    material: Material,
    classes: Sequence[CondensedClass],
    velocities: Sequence[Array],
    adjoints: Sequence[ErrorAdjoint] | None,
) -> list[list[ClassSlopes]]:
    """Find the derivatives of condensed classes, by class and velocity; of their errors with adjoints."""
    loads = load_slopes(mesh, velocities)
    solutions = [np.concatenate([part.fields, part.pin_fields], axis=2) for part in classes]
    sets = solutions
    if adjoints is not None:
        sets = [
            np.concatenate([fields, adjoint.fields], axis=2)
            for fields, adjoint in zip(solutions, adjoints, strict=True)
        ]
    changes = energy_slopes(mesh, material, sets, velocities)
    # Forces are needed on the end sections alone.
    ends = np.concatenate([nodes_on(mesh, end) for end in end_sections(axial_class(mesh.part))])
    beside = mesh.elements[np.isin(mesh.elements, ends).any(axis=1)]
    stiffness = assemble_stiffness(mesh.points, beside, material)
    by_class = []
    for place, (part, both, of_velocities) in enumerate(
        zip(classes, solutions, changes, strict=True)
    ):
        count, every, copies = part.fields.shape[2], both.shape[2], part.symmetry.copies
        forces = symmetric_product(stiffness, both.reshape(-1, every)).reshape(both.shape)
        before = unit_end_motions(mesh, part.symmetry, part.sections)
        slopes, shifts = [], []
        for velocity, change, of_pins in zip(velocities, of_velocities, loads, strict=True):
            step = _step(mesh, velocity)
            moved = unit_end_motions(mesh, part.symmetry, part.sections, step * velocity)
            shifts.append(
                [
                    (nodes, (last - first) / step)
                    for (nodes, first), (_, last) in zip(before, moved, strict=True)
                ]
            )
            work = np.zeros((count, every))
            for nodes, shift in shifts[-1]:
                work += np.einsum("sak,sac->kc", shift, forces[nodes])
            energy = change[:count, :count] + work[:, :count] + work[:, :count].T
            works, carried = np.zeros_like(part.pin_loads), np.zeros_like(part.pin_flexibility)
            for column, (pin, component) in enumerate(part.pin_components):
                load = of_pins[pin].of_class(part.symmetry)[..., component]
                moving = np.einsum("sa,sac->c", load, both[of_pins[pin].nodes])
                held = change[count + column, :count] + work[:, count + column]
                works[pin, :, component] = moving[:count] - copies * held
                carried[column] = moving[count:]
            flexibility = carried + carried.T - copies * change[count:every, count:every]
            slopes.append(ClassSlopes(energy, works, flexibility))
        if adjoints is not None:
            # With rigid sections, then the pins.
            known = np.r_[: adjoints[place].motions, count:every]
            of_errors = adjoints[place].slopes(
                part, np.stack(velocities, axis=1), of_velocities[:, known, every:], shifts, loads
            )
            slopes = [
                replace(slope, energies=energies)
                for slope, energies in zip(slopes, of_errors, strict=True)
            ]
        by_class.append(slopes)
    return by_class


def energy_slopes(
    mesh: ThrowMesh, material: Material, solutions: Sequence[Array], velocities: Sequence[Array]
) -> list[Array]:
    """Derivatives (velocities, c, c) of the energies of fields (n, 3, c) that move with the mesh.

    For each of several sets of fields.
    """
    lame, shear = material.lame_constant, material.shear_modulus
    _, gradients, weights = shapes_for_quadrature(QUADRATURE_ORDER)
    moving = np.concatenate(velocities, axis=1)
    counts = [fields.shape[2] for fields in solutions]
    changes = [np.zeros((len(velocities), count, count)) for count in counts]
    size = max(1, CACHED // (9 * len(weights) * max(len(velocities), *counts)))
    for nodes in np.split(mesh.elements, range(size, len(mesh.elements), size)):
        spatial, volumes = physical_gradients(mesh.points[nodes], gradients, weights)
        across = spatial.transpose(0, 1, 3, 2).reshape(len(nodes), -1, 10)
        # turns[v, p, j, k] = div v / 2 - d v_k / d x_j at each point p
        turned = (across @ moving[nodes]).reshape(-1, 3, len(velocities), 3)
        turns = np.ascontiguousarray(-turned.transpose(2, 0, 1, 3))
        divergence = turned[:, 0, :, 0] + turned[:, 1, :, 1] + turned[:, 2, :, 2]
        for axis in range(3):
            turns[:, :, axis, axis] += 0.5 * divergence.T
        for fields, count, change in zip(solutions, counts, changes, strict=True):
            # slopes[p, j, i] = d u_i / d x_j
            flat = (across @ fields[nodes].reshape(len(nodes), 10, -1)).reshape(-1, 3, 3 * count)
            slopes = flat.reshape(-1, 3, 3, count)
            stresses = shear * (slopes + slopes.swapaxes(1, 2))
            trace = lame * (slopes[:, 0, 0] + slopes[:, 1, 1] + slopes[:, 2, 2])
            for axis in range(3):
                stresses[:, axis, axis] += trace
            stresses *= volumes.reshape(-1, 1, 1, 1)
            # (grad u grad v)_ij = d u_i / d x_k d v_k / d x_j
            if len(velocities) > MANY * count:
                works = stresses.swapaxes(2, 3)[:, :, None] @ slopes[:, None]
                change += np.tensordot(
                    turns.reshape(len(turns), -1), works.reshape(-1, count, count), 1
                )
                continue
            work = stresses.reshape(-1, count).T
            for number, turn in enumerate(turns):
                change[number] += work @ (turn @ flat).reshape(-1, count)
    return [change + change.transpose(0, 2, 1) for change in changes]
