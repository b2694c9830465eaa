"""A throw under unit loads, ends pinned: its displacements, and the stresses in it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem.assembly import assemble_stiffness
from fem.condensation import CondensedClass, EndSections, condense, nodes_on
from fem.correction import recovered_stress
from fem.loads import unit_pin_loads
from fem.material import Material
from fem.solver import SharedSolver
from fem.superelement import RX, RY
from fem.supports import STRETCH, TWIST, unit_response
from fem.surface_stress import as_components, as_matrices
from fem.symmetry import CUTS, MirrorImage, SymmetryClass, mirror_images, symmetry_classes
from geometry.mesh import ThrowMesh
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Moments on both ends that open the throw as a radial force does, and that bend it across.
OPENING = np.zeros(12)
OPENING[[RX, 6 + RX]] = 1.0, -1.0
BENDING_ACROSS = np.zeros(12)
BENDING_ACROSS[[RY, 6 + RY]] = -1.0, 1.0


@dataclass(frozen=True)
class UnitLoad:
    """A load of 1 N or 1 N m on a throw.

    Attributes
    ----------
    kind : {"axial", "torsion", "bending", "cross bending", "radial"}
    unit : {"N", "N m"}
    ends : (12,) array
        Forces and moments on the left, then on the right end section.
    pin : int or None
        Index of the pin with a radial force towards the shaft, from 0; uniform over its surface.
    direction : (3,) array
        Of that force.
    """

    kind: str
    name: str
    unit: str
    ends: Array
    pin: int | None
    direction: Array


def unit_loads(radials: Array) -> tuple[UnitLoad, ...]:
    """Return the unit loads of a throw.

    Parameters
    ----------
    radials : (pins, 3) array
        Direction of a radial force on each pin, towards the shaft.
    """
    none = np.zeros(3)
    loads = [
        UnitLoad("axial", "axial force", "N", STRETCH, None, none),
        UnitLoad("torsion", "torque", "N m", TWIST, None, none),
        UnitLoad("bending", "bending in the crank plane", "N m", OPENING, None, none),
        UnitLoad(
            "cross bending", "bending across the crank plane", "N m", BENDING_ACROSS, None, none
        ),
    ]
    for pin, direction in enumerate(radials):
        name = "radial force" if len(radials) == 1 else f"radial force on pin {pin + 1}"
        loads.append(UnitLoad("radial", name, "N", np.zeros(12), pin, direction))
    return tuple(loads)


@dataclass(frozen=True)
class LoadedThrow:
    """A throw's displacements under several loads.

    Attributes
    ----------
    mesh : ThrowMesh
        The meshed part.
    shares : tuple of (SymmetryClass, (n, 3, k) array)
        Contribution of each symmetry class to the displacement of the meshed part under each of k
        loads [m].
    end_sections : {"rigid", "averaged"}
    """

    mesh: ThrowMesh
    material: Material
    loads: tuple[UnitLoad, ...]
    shares: tuple[tuple[SymmetryClass, Array], ...]
    solver: str
    end_sections: str

    def displacement(self, image: MirrorImage) -> Array:
        """Displacements (n, 3, k) of an image of the meshed part [m]."""
        total = sum(symmetry.parity(image) * field for symmetry, field in self.shares)
        return np.asarray(image.signs[:, None] * total)

    def stresses(self, images: Sequence[MirrorImage]) -> list[Array]:
        """Stresses (n, k, 6) at the nodes of each image, recovered from the elements [Pa]."""
        mesh = self.mesh
        totals = [np.zeros((len(mesh.points), len(self.loads), 6)) for _ in images]
        for symmetry, field in self.shares:
            for load in np.flatnonzero(np.any(field, axis=(0, 1))):
                stress = recovered_stress(
                    mesh.points, mesh.elements, field[:, :, load], self.material
                )
                for image, total in zip(images, totals, strict=True):
                    total[:, load] += symmetry.parity(image) * stress
        return [
            as_components(np.outer(image.signs, image.signs) * as_matrices(total))
            for image, total in zip(images, totals, strict=True)
        ]


def solve_unit_loads(
    mesh: ThrowMesh,
    loads: Sequence[UnitLoad],
    material: Material,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
) -> LoadedThrow:
    """Find the displacements of a throw under unit loads, ends pinned.

    Only the symmetry classes that the loads excite are solved: three of a quarter's four under those of
    `unit_loads`.

    Parameters
    ----------
    solver : str
        See `fem.solver.SharedSolver`.
    end_sections : {"rigid", "averaged"}
        See `fem.condensation.condense`.

    Raises
    ------
    InputError
        If `end_sections` is neither.
    SolveError
        If the system cannot be solved.
    """
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    pins = unit_pin_loads(mesh)
    shares = []
    shared = SharedSolver(solver)
    try:
        for symmetry in symmetry_classes(mesh.part):
            if any(_excites(load, symmetry) for load in loads):
                part = condense(mesh, stiffness, pins, symmetry, shared, end_sections)
                fields = np.stack([_field(part, load) for load in loads], axis=-1)
                shares.append((symmetry, fields))
    finally:
        shared.close()
    return LoadedThrow(mesh, material, tuple(loads), tuple(shares), shared.solver, end_sections)


def _excites(load: UnitLoad, symmetry: SymmetryClass) -> bool:
    """Whether a load does work on any motion of a class."""
    on_pin = load.pin is not None and np.any(load.direction[symmetry.central_motions[:3]])
    return bool(on_pin or np.any(load.ends @ symmetry.ends))


def _field(part: CondensedClass, load: UnitLoad) -> Array:
    """Displacement (n, 3) of the meshed part in a class under a load [m]."""
    if not _excites(load, part.symmetry):
        return np.zeros(part.fields.shape[:2])
    work = load.ends @ part.symmetry.ends
    if load.pin is not None:
        work = work + part.pin_loads[load.pin, :, :3] @ load.direction
    field = part.fields @ unit_response(part, "pinned", work)
    if load.pin is not None:
        pins, components = part.pin_components.T
        on_it = (pins == load.pin) & (components < 3)
        field = field + part.pin_fields[:, :, on_it] @ load.direction[components[on_it]]
    return np.asarray(field)


@dataclass(frozen=True)
class WholeNodes:
    """Numbers of nodes of a whole throw, those on the cuts shared by the images.

    Attributes
    ----------
    numbers : (images, n) array
        Number of each node of the mesh in each image.
    """

    images: tuple[MirrorImage, ...]
    numbers: Integers

    def collect(self, values: Sequence[Array]) -> Array:
        """Values of the whole throw's nodes (w, ...) from those of each image (n, ...)."""
        count = int(self.numbers.max()) + 1
        whole = np.empty((count, *values[0].shape[1:]))
        for number, value in zip(self.numbers, values, strict=True):
            whole[number] = value
        return whole


def whole_nodes(mesh: ThrowMesh) -> WholeNodes:
    """Number the nodes of a whole throw."""
    images = mirror_images(mesh)
    places = {(image.across_crank, image.across_middle): k for k, image in enumerate(images)}
    count = len(mesh.points)
    numbers = np.arange(len(images) * count).reshape(len(images), count)
    cut_crank, cut_middle = CUTS[mesh.part]
    for (across_crank, across_middle), place in places.items():
        if cut_crank and across_crank:
            shared = nodes_on(mesh, CRANK_PLANE)
            numbers[place, shared] = numbers[places[False, across_middle], shared]
        if cut_middle and across_middle:
            shared = nodes_on(mesh, MIDDLE_PLANE)
            numbers[place, shared] = numbers[places[across_crank, False], shared]
    _, packed = np.unique(numbers, return_inverse=True)
    return WholeNodes(images, packed.reshape(numbers.shape))


# The corners and edge middles of a six-node triangle seen from its other side.
TURNED = [0, 2, 1, 5, 4, 3]


def whole_facets(nodes: WholeNodes, facets: Integers) -> Integers:
    """Facets (images t, 6) of a whole throw from those (t, 6) of the meshed part, outside kept."""
    return np.concatenate(
        [
            number[facets[:, TURNED] if image.inside_out else facets]
            for image, number in zip(nodes.images, nodes.numbers, strict=True)
        ]
    )
