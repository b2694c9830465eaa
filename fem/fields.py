"""Displacements and stresses of a whole throw, for pictures.

A throw is solved for every motion of its ends and every force and moment on its pin. Six combinations of
end motions cause strain; with the loads on the pin they give twelve fields of stress, and those of any loads
in equilibrium are sums of them: so the stresses of a whole working cycle need one solution.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.array_checks import Array, Flags
from crankbase.errors import InputError
from crankbase.summaries import frozen
from fem.fillet_peaks import LoadedThrow, fillet_surface, tangent_frames, throw_fillets
from fem.material import Material
from fem.solver import SharedSolver, assemble_stiffness
from fem.superelement import CondensedClass, Superelement, checked_superelement, condense
from fem.symmetry import mirror_images, radial_directions, symmetry_classes, unit_pin_loads
from geometry.any_throw import Throw
from geometry.mesh import ThrowMesh


@dataclass(frozen=True)
class Image:
    """The meshed part of a throw, or a mirror image of it, with its displacements.

    Attributes
    ----------
    points : (n, 3) array
        Nodes in the order of the mesh [m].
    displacement : (n, 3) array
        [m]
    inside_out : bool
        Whether a single mirror has inverted elements and facets.
    """

    points: Array
    displacement: Array
    inside_out: bool


def displacement_field(classes: Sequence[CondensedClass], motions: Array) -> Array:
    """Displacement of the nodes of a throw's meshed part.

    Parameters
    ----------
    classes : sequence of CondensedClass
        All symmetry classes of the part.
    motions : (m,) or (m, k) array
        Motions of the left, then the right end section, in the throw frame, such as those that
        `fem.supports.end_motions` finds: 12 of rigid sections, or all of the classes. Under a load
        on a pin these are not the whole motion: the load also bends the throw between its ends.

    Returns
    -------
    (n, 3) or (n, 3, k) array
        [m]
    """
    count = len(motions)
    return np.asarray(sum(part.fields @ (part.shares[:, :count] @ motions) for part in classes))


def images(mesh: ThrowMesh, classes: Sequence[CondensedClass], motions: Array) -> tuple[Image, ...]:
    """Displacement of a whole throw: of its meshed part and of the mirror images of that.

    Parameters
    ----------
    mesh : ThrowMesh
        The meshed part.
    classes : sequence of CondensedClass
        All its symmetry classes.
    motions : (12,) array
        Motions of both end sections.

    Returns
    -------
    tuple of Image
        Four of a quarter, two of a half, one of a whole throw; first the meshed part itself. Nodes on
        the cuts are in each image that they belong to.
    """
    parts = []
    for image in mirror_images(mesh):
        # What the image does is the mirror image of what the part would do for mirrored motions.
        ends = (motions[:6], motions[6:])
        left, right = ends[::-1] if image.across_middle else ends
        mirrored = np.concatenate([image.motion_signs * left, image.motion_signs * right])
        field = displacement_field(classes, mirrored)
        parts.append(Image(image.points(mesh.points), field * image.signs, image.inside_out))
    return tuple(parts)


# Ways in which the ends of a throw can move and strain it.
STRAINING = 6
# Of the largest force: what may be missing to equilibrium.
BALANCED = 1e-6


@frozen("name", "kind", "diameter [m]", "radius [m]", eq=False)
class StressedSite:
    """A fillet or an exit of an oil hole with its fields of stress.

    Attributes
    ----------
    name : str
        For example "pin, left web".
    kind : {"pin fillet", "journal fillet", "oil hole"}
    diameter : float
        Of the pin or main journal [m].
    radius : float
        Of the fillet; half of the hole's diameter [m].
    points : (s, 3) array
        Nodes, in the throw frame [m].
    frames : (s, 2, 3) array
        Two directions in the surface at each.
    stress : (s, 12, 3) array
        Along both and the shear between them, of the fields [Pa].
    """

    name: str
    kind: str
    diameter: float
    radius: float
    points: Array
    frames: Array
    stress: Array


@frozen("sites", "unknowns", eq=False)
class StressFields:
    """Fields of stress of a throw with one pin.

    Attributes
    ----------
    sites : tuple of StressedSite
        Fillets from left to right, then exits of oil holes.
    superelement : Superelement
        Of the same mesh.
    straining : (12, 6) array
        End loads to the amplitudes of the first six fields.
    unknowns : int
        Of the mesh.
    """

    sites: tuple[StressedSite, ...]
    superelement: Superelement
    straining: Array
    unknowns: int

    def amplitudes(self, ends: Array, pin: Array) -> Array:
        """Return the amplitudes of the fields under loads.

        Parameters
        ----------
        ends : (..., 12) array
            Forces and moments on the left, then on the right end section, in the throw frame.
        pin : (..., 6) array
            Forces and moments on the pin, about its center.

        Returns
        -------
        (..., 12) array

        Raises
        ------
        InputError
            If the loads are not in equilibrium.
        """
        acting = ends + pin @ self.superelement.pin_loads[0].T
        amplitudes = acting @ self.straining
        carried = amplitudes @ (self.superelement.stiffness @ self.straining).T
        missing = np.abs(acting - carried).max(initial=0.0)
        largest = np.abs(acting).max(initial=0.0)
        if missing > BALANCED * largest:
            raise InputError(
                f"loads: given ones out of balance by {missing / largest:.2g} of the largest; allowed are "
                "loads in equilibrium, because stresses under others are those of an accelerated throw."
            )
        return np.concatenate([amplitudes, pin], axis=-1)


def stress_fields(mesh: ThrowMesh, throw: Throw, material: Material) -> StressFields:
    """Solve a throw with one pin for its fields of stress at fillets and oil holes.

    Parameters
    ----------
    mesh : ThrowMesh
        Of the throw, fine at its fillets, such as `FilletStresses.loaded.mesh`.
    throw : CrankThrow or ImportedThrow
        With fillets or oil holes.

    Raises
    ------
    InputError
        If the throw has several pins.
    SolveError
        If the system cannot be solved.
    """
    if len(throw.parts.pins) != 1:
        raise InputError(
            f"throw: given one with {len(throw.parts.pins)} pins; allowed is one pin, because loads are "
            "those of the ends and one pin."
        )
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    pins = unit_pin_loads(mesh)
    shared = SharedSolver()
    try:
        classes = [
            condense(mesh, stiffness, pins, symmetry, shared)
            for symmetry in symmetry_classes(mesh.part)
        ]
    finally:
        shared.close()
    whole = checked_superelement(classes, radial_directions(throw), mesh)
    # Comparable end motions: rotations times the throw's length.
    scale = np.tile([1.0] * 3 + [1.0 / mesh.length] * 3, 2)
    values, motions = np.linalg.eigh(scale[:, None] * whole.stiffness * scale)
    # Motions of unit strain energy: end loads do the amplitude as work on them.
    unit = scale[:, None] * motions[:, -STRAINING:] / np.sqrt(values[-STRAINING:])
    shares = []
    for part in classes:
        fields = np.zeros((*part.fields.shape[:2], 2 * STRAINING))
        fields[..., :STRAINING] = part.fields @ (part.symmetry.shares @ unit)
        # Loads on the pin hold the ends: with `StressFields.amplitudes` the ends move freely.
        fields[..., STRAINING + part.pin_components[:, 1]] = part.pin_fields
        shares.append((part.symmetry, fields))
    surface = fillet_surface(LoadedThrow(mesh, material, (), tuple(shares), shared.solver, "rigid"))
    frames = tangent_frames(surface.normals)[:, :2]
    matrices = surface.stress[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    flat = np.einsum("sai,skij,sbj->skab", frames, matrices, frames, optimize=True)
    local = np.stack([flat[..., 0, 0], flat[..., 1, 1], flat[..., 0, 1]], axis=-1)
    sites = []
    for name, kind, diameter, radius, on in _places(throw, surface.points):
        nodes = np.flatnonzero(on)
        surface_places = surface.points[nodes], frames[nodes], local[nodes]
        sites.append(StressedSite(name, kind, diameter, radius, *surface_places))
    return StressFields(tuple(sites), whole, unit, int(mesh.points.size))


def _places(throw: Throw, points: Array) -> Sequence[tuple[str, str, float, float, Flags]]:
    """Name, kind, diameter, radius and nodes of each fillet and each exit."""
    places = [
        (
            fillet.name,
            "pin fillet" if fillet.journal.is_pin else "journal fillet",
            2.0 * fillet.journal.radius,
            fillet.radius,
            fillet.holds(points),
        )
        for fillet in throw_fillets(throw.parts)
    ]
    for hole in throw.parts.drillings:
        journal = next(
            cylinder for cylinder in throw.parts.cylinders if cylinder.name == hole.journal
        )
        for outlet in hole.exits:
            sizes = 2.0 * journal.radius, hole.radius
            places.append((outlet.name, "oil hole", *sizes, outlet.holds(points)))
    return places
