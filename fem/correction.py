"""Correction of a throw's results for discretization.

Finite elements choose among fewer displacements than the throw has, so it comes out too stiff. Of two
unit motions u, v of the end sections the true stiffness is the mutual energy a(u, v) of their true fields.
With the discrete fields u_h and errors e = u - u_h, which vanish on the end sections, a(u_h, v) is the work
of the discrete forces there and the same for all fields with that motion, so that

    K = K_h - a(e_u, e_v)

For unit loads l on the pins with the end sections held, and their fields w, energies of the errors are
added instead, and so to the work of the loads on the unit motions, where a(w_h, e_u) = 0:

    l(w) = l(w_h) + a(e_w, e_w),    l(u) = l(u_h) + a(e_w, e_u)

Rigid motions have no stress and no error: a corrected superelement is symmetric and its forces are in
equilibrium as those of the plain one are. The energies come from recovered stresses (`fem.correction`), which
miss a part of them, similar for throws of a kind: `effectivity`.

Inside an element the stress of second-order displacements is most accurate at the four points of its
quadrature. A quadratic polynomial fitted to these points over all elements around a corner node gives
the stress there one order better than the elements do (superconvergent patch recovery, O. C.
Zienkiewicz and J. Z. Zhu, Int. J. Numer. Meth. Engng 33, 1331-1382, 1992). The difference between
recovered stress and that of the elements measures their error; the recovered stress itself is what
used for fillets.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from fem.material import Material
from fem.solver import physical_gradients
from fem.superelement import CondensedClass, end_amplitudes
from fem.symmetry import RIGID
from geometry.mesh import ThrowMesh
from geometry.shapes import EDGES, shapes_for_quadrature
from geometry.solid import FILLET

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Order of components of a stress: xx, yy, zz, xy, yz, zx.
ROWS, COLUMNS = np.array([0, 1, 2, 0, 1, 2]), np.array([0, 1, 2, 1, 2, 0])
SAMPLING_ORDER = 2  # four points
# Stress differences are quadratic in an element, their energy is of fourth order.
ENERGY_ORDER = 4
# Terms of the fitted polynomial are held back by this share of the samples' weight where a patch has
# too few of them to tell; the constant is free.
HELD_BACK = np.array([0.0, *[1e-9] * 3, *[1e-5] * 6])
# Elements taken at once: at most so many, and fewer the more solutions there are, to bound the memory.
CHUNK, CHUNK_OF_ALL = 8192, 30_000
# Which corners each edge node lies between.
_ENDS = np.array([[1.0 if corner in edge else 0.0 for corner in range(4)] for edge in EDGES])


def stresses_at(
    points: Array, elements: Integers, displacement: Array, material: Material, gradients: Array
) -> Array:
    """Stress of the finite element solution.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    displacement : (n, 3) array
        [m]
    gradients : (q, 10, 3) array
        Reference gradients of the shape functions at the wanted places.

    Returns
    -------
    (m, q, 6) array
        xx, yy, zz, xy, yz, zx [Pa].
    """
    weights = np.ones(len(gradients))
    stresses, _ = _stresses(
        points, elements, displacement[:, :, None], material, gradients, weights
    )
    return stresses[..., 0]


def _stresses(
    points: Array,
    elements: Integers,
    displacements: Array,
    material: Material,
    gradients: Array,
    weights: Array,
) -> tuple[Array, Array]:
    """Stresses (m, q, 6, k) of k solutions (n, 3, k), and the volumes (m, q) of the places' weights."""
    lame, shear = material.lame_constant, material.shear_modulus
    count = displacements.shape[2]
    stresses = np.empty((len(elements), len(gradients), 6, count))
    volumes = np.empty((len(elements), len(gradients)))
    for batch in _batches(len(elements), count):
        nodes = elements[batch]
        spatial, volumes[batch] = physical_gradients(points[nodes], gradients, weights)
        of_nodes = displacements[nodes].reshape(len(nodes), 1, 10, 3 * count)
        # slopes[m, q, j, i] = d u_i / d x_j
        slopes = (spatial.transpose(0, 1, 3, 2) @ of_nodes).reshape(*spatial.shape[:2], 3, 3, count)
        stresses[batch] = shear * (slopes[:, :, ROWS, COLUMNS] + slopes[:, :, COLUMNS, ROWS])
        stresses[batch, :, :3] += lame * np.trace(slopes, axis1=2, axis2=3)[:, :, None]
    return stresses, volumes


def recovered_stress(
    points: Array, elements: Integers, displacement: Array, material: Material
) -> Array:
    """Stress at the nodes, recovered from the adjacent elements.

    Parameters
    ----------
    points, elements, displacement, material
        As for `stresses_at`.

    Returns
    -------
    (n, 6) array
        xx, yy, zz, xy, yz, zx [Pa].
    """
    _, gradients, _ = shapes_for_quadrature(SAMPLING_ORDER)
    samples = stresses_at(points, elements, displacement, material, gradients)
    return _recovered(points, elements, samples)


def _recovered(points: Array, elements: Integers, stress: Array) -> Array:
    """Stress (n, c) at the nodes from that at the sampling points (m, 4, c)."""
    components = stress.shape[-1]
    values, _, _ = shapes_for_quadrature(SAMPLING_ORDER)
    places = values @ points[elements]
    corners = elements[:, :4]
    vertices, number = np.unique(corners, return_inverse=True)
    number = number.reshape(corners.shape)
    sizes = _patch_sizes(points, corners, number, len(vertices))
    matrices = np.zeros((len(vertices), 100))
    sides = np.zeros((len(vertices), 10 * components))
    for batch in _batches(len(elements), components // 6):
        count = len(corners[batch])
        owner = number[batch].ravel()
        local = places[batch, None] - points[corners[batch]][:, :, None]
        terms = _terms(local.reshape(4 * count, 4, 3) / sizes[owner, None, None])
        own, place = np.unique(owner, return_inverse=True)
        gather = sparse.csr_array(
            (np.ones(len(owner)), (place, np.arange(len(owner)))), (len(own), len(owner))
        )
        matrices[own] += np.asarray(gather @ (terms.transpose(0, 2, 1) @ terms).reshape(-1, 100))
        samples = np.repeat(stress[batch], 4, axis=0)
        products = (terms.transpose(0, 2, 1) @ samples).reshape(-1, 10 * components)
        sides[own] += np.asarray(gather @ products)
    systems = matrices.reshape(-1, 10, 10)
    weight = systems[:, 0, 0]
    systems[:, np.arange(10), np.arange(10)] += weight[:, None] * HELD_BACK
    coefficients = np.linalg.solve(systems, sides.reshape(-1, 10, components))

    recovered = np.zeros((len(points), components))
    recovered[vertices] = coefficients[:, 0]
    ends = number[:, np.array(EDGES)].reshape(-1, 2)
    middles, first = np.unique(elements[:, 4:], return_index=True)
    for batch in _batches(len(middles), components // 6):
        for owner in ends[first[batch]].T:
            local = (points[middles[batch]] - points[vertices[owner]]) / sizes[owner, None]
            own = np.einsum("np,npc->nc", _terms(local), coefficients[owner])
            recovered[middles[batch]] += 0.5 * own
    return recovered


def _patch_sizes(points: Array, corners: Integers, number: Integers, count: int) -> Array:
    """Mean distance (v,) of the patches' other corners from their own [m]."""
    total, weight = np.zeros(count), np.zeros(count)
    for corner in range(4):
        for other in range(4):
            if corner != other:
                length = np.linalg.norm(
                    points[corners[:, corner]] - points[corners[:, other]], axis=1
                )
                total += np.bincount(number[:, corner], length, count)
                weight += np.bincount(number[:, corner], minlength=count)
    return np.asarray(total / weight)


def _terms(local: Array) -> Array:
    """Terms (..., 10) of a quadratic polynomial at places (..., 3)."""
    x, y, z = np.moveaxis(local, -1, 0)
    return np.stack([np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x], axis=-1)


@dataclass(frozen=True)
class EnergyErrors:
    """Estimated energy of the error of a solution.

    Attributes
    ----------
    elements : (m,) array
        Twice the strain energy of the error in each element [J].
    energy : float
        Twice the strain energy of the solution in the meshed part [J].
    """

    elements: Array
    energy: float

    @property
    def relative(self) -> float:
        """Share of the error in the energy, which is the relative error of the compliance."""
        return float(self.elements.sum() / self.energy)


@dataclass(frozen=True)
class StressErrors:
    """Stresses of k solutions on one mesh, and the recovered ones.

    Attributes
    ----------
    elements : (m, 10) array
        Node numbers.
    volumes : (m, 4) array
        Volumes of the sampling points [m^3].
    samples : (m, 4, 6, k) array
        Stresses of the elements at the sampling points [Pa].
    recovered : (n, 6, k) array
        Recovered stresses at the nodes [Pa].
    """

    elements: Integers
    material: Material
    volumes: Array
    samples: Array
    recovered: Array

    def energy_errors(self, amplitudes: Array) -> EnergyErrors:
        """Estimate the energy of the error of a sum of the solutions times amplitudes (k,)."""
        samples, recovered = self.samples @ amplitudes, self.recovered @ amplitudes
        densities = np.empty(len(self.elements))
        for batch, difference, shares in _differences(self.elements, samples, recovered):
            densities[batch] = strain_energy(difference, self.material) @ shares
        energy = float(np.sum(self.volumes * strain_energy(samples, self.material)))
        return EnergyErrors(self.volumes.sum(axis=1) * densities, energy)

    def products(self) -> Array:
        """Mutual energies (k, k) of the estimated errors of the solutions in the meshed part [J].

        The work of the forces of one solution on the displacement of another is their mutual energy;
        the part lost by discretization is the mutual energy of the two errors.
        """
        modulus, ratio = self.material.youngs_modulus, self.material.poisson_ratio
        strains = np.diag(np.repeat([1.0, 2.0], 3)) * (1.0 + ratio)
        strains[:3, :3] -= ratio
        half = np.linalg.cholesky(strains / modulus).T
        volumes = self.volumes.sum(axis=1)
        count = self.samples.shape[-1]
        total = np.zeros((count, count))
        for batch, difference, shares in _differences(self.elements, self.samples, self.recovered):
            # The rule's weights are not all positive.
            weights = np.repeat((volumes[batch, None] * shares).ravel(), 6)
            rows = (half @ difference).reshape(-1, count)
            total += rows.T @ (weights[:, None] * rows)
        return total


def stress_errors(
    points: Array, elements: Integers, displacements: Array, material: Material
) -> StressErrors:
    """Recover the stresses of several solutions, for the energies of their errors.

    Parameters
    ----------
    points, elements, material
        As for `stresses_at`.
    displacements : (n, 3, k) array
        [m]
    """
    _, gradients, weights = shapes_for_quadrature(SAMPLING_ORDER)
    count = displacements.shape[2]
    samples, volumes = _stresses(points, elements, displacements, material, gradients, weights)
    recovered = _recovered(points, elements, samples.reshape(len(elements), len(weights), -1))
    return StressErrors(
        elements, material, volumes, samples, recovered.reshape(len(points), 6, count)
    )


def energy_errors(
    points: Array, elements: Integers, displacement: Array, material: Material
) -> EnergyErrors:
    """Estimate the energy of the error of one solution; parameters as for `stresses_at`."""
    errors = stress_errors(points, elements, displacement[:, :, None], material)
    return errors.energy_errors(np.ones(1))


def _differences(
    elements: Integers, samples: Array, recovered: Array
) -> Iterator[tuple[slice, Array, Array]]:
    """Recovered stress less that of the elements (b, q, ...), and the volume shares (q,) of the places.

    For samples (m, 4, ...) and recovered stresses (n, ...), in batches of elements.
    """
    # Stress is linear inside a straight element; the recovered one is a quadratic between the nodes.
    fine, _, fine_weights = shapes_for_quadrature(ENERGY_ORDER)
    linear = _linear_through_samples(fine[:, :4] + 0.5 * fine[:, 4:] @ _ENDS)
    weights = np.hstack([fine, -linear])
    shares = fine_weights / fine_weights.sum()
    for batch in _batches(len(elements), int(np.prod(samples.shape[3:]))):
        both = np.concatenate([recovered[elements[batch]], samples[batch]], axis=1)
        flat = weights @ both.reshape(*both.shape[:2], -1)
        yield batch, flat.reshape(*flat.shape[:2], *both.shape[2:]), shares


def _batches(elements: int, solutions: int) -> Iterator[slice]:
    """Slices of so many elements, of a size for so many solutions."""
    size = max(256, min(CHUNK, CHUNK_OF_ALL // max(solutions, 1)))
    for start in range(0, elements, size):
        yield slice(start, start + size)


def _linear_through_samples(corners: Array) -> Array:
    """Weights (q, 4) of the sampling points in a linear function at places of these coordinates.

    `corners` (q, 4) are barycentric coordinates.
    """
    values, _, _ = shapes_for_quadrature(SAMPLING_ORDER)
    sampled = values[:, :4] + 0.5 * values[:, 4:] @ _ENDS
    return np.asarray(corners @ np.linalg.inv(sampled))


def strain_energy(stress: Array, material: Material) -> Array:
    """Twice the strain energy density (...) of stresses (..., 6) [J/m^3]."""
    modulus, ratio = material.youngs_modulus, material.poisson_ratio
    trace = stress[..., :3].sum(axis=-1)
    squares = (stress[..., :3] ** 2).sum(axis=-1) + 2.0 * (stress[..., 3:] ** 2).sum(axis=-1)
    return np.asarray(((1.0 + ratio) * squares - ratio * trace**2) / modulus)


# True energy of the error divided by the estimated one: of throws with fillets or (False) without, on fine
# meshes, and what it falls by where the axial compliance is short of so large a share of itself
# (tests/campaigns/corrected_answers.py).
EFFECTIVITY = {True: (1.25, 3.5), False: (1.28, 3.0)}
# What is left of an answer's error after correction is within this share of its correction, this share of
# that of the axial compliance (a small correction may be the difference of larger ones), and what answers
# of two meshes of like size differ by in any case, together: in 95 of 100 answers of random throws.
UNCERTAINTY, MESH_UNCERTAINTY, MESH_NOISE = 0.12, 0.1, 1e-4
# Of a correction of the axial compliance beyond this share, as coarse meshes round oil holes have, more is
# uncertain: the estimate of its error misses what such elements cannot show.
COARSE, COARSE_UNCERTAINTY = 0.03, 0.3
# A correction of so much of any motion's energy is none: the mesh tells nothing.
LARGEST_SHARE = 0.5


def class_errors(part: CondensedClass, mesh: ThrowMesh, material: Material) -> StressErrors:
    """Recover the stresses of a class's fields: of k unit motions, then of a loads on the pins."""
    fields = np.concatenate([part.fields, part.pin_fields], axis=2)
    return stress_errors(mesh.points, mesh.elements, fields, material)


def class_energies(
    parts: Sequence[CondensedClass], mesh: ThrowMesh, material: Material
) -> list[Array]:
    """Mutual energies (k + a, k + a) of the estimated errors of each class's fields [J]."""
    return [class_errors(part, mesh, material).products() for part in parts]


def effectivity(mesh: ThrowMesh, share: float) -> float:
    """True energy of the error divided by the estimated one, on a mesh of this coarseness.

    Parameters
    ----------
    share : float
        Estimated error of the axial compliance, pinned, as a share of it.
    """
    finest, fall = EFFECTIVITY[len(mesh.surfaces.get(FILLET, ())) > 0]
    return max(1.0, finest - fall * share)


def corrected_class(part: CondensedClass, energies: Array, factor: float) -> CondensedClass:
    """Correct a condensed class for discretization.

    Parameters
    ----------
    energies : (k + a, k + a) array
        From `class_energies`; not changed.
    factor : float
        The `effectivity` of the estimated errors.

    Returns
    -------
    CondensedClass
        With the one given as its ``discrete``; unchanged if its errors are so large that the
        corrected stiffness would not be positive.
    """
    count = len(part.stiffness)
    energies = factor * energies
    rigid = end_amplitudes(part.symmetry, RIGID).shape[1]
    missing = _largest_share(part.stiffness[:rigid, :rigid], energies[:rigid, :rigid])
    part = replace(part, missing=missing)
    if missing > LARGEST_SHARE:
        return part
    if _largest_share(part.stiffness, energies[:count, :count]) > LARGEST_SHARE:
        # Of a section's own bending the mesh may tell too little where it tells enough of the throw.
        energies[rigid:count], energies[:, rigid:count] = 0.0, 0.0
    pins, components = part.pin_components.T
    pin_loads = part.pin_loads.copy()
    pin_loads[pins, :, components] += part.symmetry.copies * energies[count:, :count]
    return replace(
        part,
        stiffness=part.stiffness - energies[:count, :count],
        pin_loads=pin_loads,
        pin_flexibility=part.pin_flexibility + part.symmetry.copies * energies[count:, count:],
        discrete=part,
        missing=0.0,
    )


def error_bars(
    corrected: ArrayLike,
    discrete: ArrayLike,
    axial_correction: float,
    sizes: ArrayLike | None = None,
    missing: float = 0.0,
) -> Array:
    """Estimated errors of corrected results from those of the mesh, in their units.

    Parameters
    ----------
    corrected, discrete : (...) array_like
    axial_correction : float
        Of the axial compliance, pinned, as a share of it: how coarse the mesh is.
    sizes : (...) array_like, optional
        Size of a result; by default itself.
    missing : float
        For uncorrected results: the largest share lost.
    """
    answers, plain = np.asarray(corrected, dtype=float), np.asarray(discrete, dtype=float)
    floor = MESH_UNCERTAINTY * axial_correction + MESH_NOISE + missing
    floor += COARSE_UNCERTAINTY * max(0.0, axial_correction - COARSE)
    size = np.abs(answers if sizes is None else np.asarray(sizes, dtype=float))
    return np.asarray(UNCERTAINTY * np.abs(answers - plain) + floor * size)


def _largest_share(stiffness: Array, energies: Array) -> float:
    """Largest share of the energies in the stiffness (k, k), of all motions that are not rigid."""
    # A unit motion may be rigid, its energy nothing but round-off.
    diagonal = np.diag(stiffness)
    scale = 1.0 / np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
    values, motions = np.linalg.eigh(scale[:, None] * stiffness * scale)
    elastic = values > 1e-9 * values[-1]
    motions = scale[:, None] * motions[:, elastic] / np.sqrt(values[elastic])
    return float(np.linalg.eigvalsh(motions.T @ energies @ motions)[-1])
