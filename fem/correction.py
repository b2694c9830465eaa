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

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, Integers
from fem.material import Material
from fem.solver import physical_gradients
from fem.superelement import CondensedClass, end_amplitudes
from fem.symmetry import RIGID
from geometry.mesh import ThrowMesh
from geometry.shapes import EDGES, shapes_for_quadrature
from geometry.solid import FILLET

# Order of components of a stress: xx, yy, zz, xy, yz, zx.
ROWS, COLUMNS = np.array([0, 1, 2, 0, 1, 2]), np.array([0, 1, 2, 1, 2, 0])
# The component of each entry of a tensor.
TENSOR = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
SAMPLING_ORDER = 2  # four points
# Stress differences are quadratic in an element, their energy is of fourth order.
ENERGY_ORDER = 4
# Terms of the fitted polynomial are held back by this share of the samples' weight where a patch has
# too few of them to tell; the constant is free.
HELD_BACK = np.array([0.0, *[1e-9] * 3, *[1e-5] * 6])
# Elements taken at once, divided by the number of solutions: so many that their stresses stay in the cache.
IN_CACHE = 1500
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
    spatial, _ = physical_gradients(points[elements], gradients, np.ones(len(gradients)))
    return _stresses(
        spatial, displacement[elements, :, None], material.lame_constant, material.shear_modulus
    )[..., 0]


def _stresses(spatial: Array, displacements: Array, lame: float, shear: float | Array) -> Array:
    """Stresses (m, q, 6, k) by gradients (m, q, 10, 3) and displacements (m, 10, 3, k) of nodes."""
    shape = (*spatial.shape[:2], 3, 3, displacements.shape[-1])
    rows = spatial.transpose(0, 1, 3, 2).reshape(shape[0], 3 * shape[1], 10)
    # slopes[m, q, j, i] = d u_i / d x_j
    slopes = (rows @ displacements.reshape(shape[0], 10, 3 * shape[4])).reshape(shape)
    stresses = slopes[:, :, ROWS, COLUMNS] + slopes[:, :, COLUMNS, ROWS]
    stresses *= shear
    stresses[:, :, :3] += lame * np.trace(slopes, axis1=2, axis2=3)[:, :, None]
    return np.asarray(stresses)


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
class ErrorDuals:
    """Estimated errors of k solutions, by element.

    Attributes
    ----------
    products : (m, k, k) array
        Mutual energies of the errors in each element [J].
    stresses : (m, 4, 6, k) array
        Of each solution: stresses at the sampling points, integrated over the volume, whose work on the
        strain of another is the mutual energy of the errors of both [N m].
    """

    products: Array
    stresses: Array


class StressRecovery:
    """Recovers stresses on one mesh, and finds the energies of their difference from those of the elements.

    Parameters
    ----------
    points : (n, 3) array
        Node coordinates [m].
    elements : (m, 10) array
        Node numbers.
    """

    def __init__(self, points: Array, elements: Integers) -> None:
        values, gradients, weights = shapes_for_quadrature(SAMPLING_ORDER)
        self._elements, self._count = elements, len(points)
        self._spatial, self._volumes = physical_gradients(points[elements], gradients, weights)
        vertices, number = np.unique(elements[:, :4], return_inverse=True)
        # The elements round each vertex, one vertex after the other.
        self._round, owner, starts = _grouped(number.ravel(), len(vertices))
        self._round //= 4
        self._limits = np.append(starts, len(owner)).tolist()
        vertex = points[vertices[owner], None]
        distances = np.linalg.norm(points[elements[self._round, :4]] - vertex, axis=2).sum(axis=1)
        sizes = np.add.reduceat(distances, starts) / (3 * np.bincount(owner))
        local = (values @ points[elements])[self._round] - vertex
        self._terms = _terms(local / sizes[owner, None, None])
        systems = np.add.reduceat(self._terms.transpose(0, 2, 1) @ self._terms, starts)
        systems[:, np.arange(10), np.arange(10)] += systems[:, :1, 0] * HELD_BACK
        # Each patch gives the stress at its vertex, and half of that in the middles of the edges there.
        middles, first = np.unique(elements[:, 4:], return_index=True)
        ends = number.reshape(-1, 4)[:, np.array(EDGES)].reshape(-1, 2)[first]
        order, owner, starts = _grouped(
            np.concatenate([np.arange(len(vertices)), *ends.T]), len(vertices)
        )
        self._nodes = np.concatenate([vertices, middles, middles])[order]
        self._at = np.append(starts, len(owner)).tolist()
        local = (points[self._nodes] - points[vertices[owner]]) / sizes[owner, None]
        shares = np.where(order < len(vertices), 1.0, 0.5)[:, None] * _terms(local)
        self._fit = (shares[:, None] @ np.linalg.inv(systems)[owner])[:, 0]

    def stresses(self, displacements: Array, material: Material) -> Array:
        """Recovered stresses (n, 6, k) at the nodes, of displacements (n, 3, k) [m, Pa]."""
        moduli = material.lame_constant, material.shear_modulus
        return self._recovered(self._samples(displacements, *moduli))

    def energy_errors(self, displacement: Array, material: Material) -> EnergyErrors:
        """Estimate the energy of the error of a solution (n, 3) [m]."""
        samples = self._samples(displacement[:, :, None], *_roots(material))
        densities = [np.square(rows).sum(axis=(1, 2)) for _, rows in self._differences(samples)]
        energy = float(np.sum(self._volumes * np.square(samples).sum(axis=(2, 3))))
        return EnergyErrors(self._volumes.sum(axis=1) * np.concatenate(densities), energy)

    def products(self, displacements: Array, material: Material) -> Array:
        """Mutual energies (k, k) of the estimated errors of solutions (n, 3, k) in the meshed part [J].

        The work of the forces of one solution on the displacement of another is their mutual energy;
        the part lost by discretization is the mutual energy of the two errors.
        """
        count = displacements.shape[2]
        total = np.zeros((count, count))
        samples = self._samples(displacements, *_roots(material))
        for batch, rows in self._differences(samples):
            # Element by element: of larger products numpy's library makes threads, which wait for each other.
            total += np.tensordot(
                self._volumes[batch].sum(axis=1), rows.transpose(0, 2, 1) @ rows, 1
            )
        return total

    def duals(self, displacements: Array, material: Material) -> "ErrorDuals":
        """Find by what the mutual energies of the errors of solutions (n, 3, k) change with these."""
        count = displacements.shape[2]
        lame, shear = _roots(material)
        samples = self._samples(displacements, lame, shear)
        products = np.empty((len(samples), count, count))
        nodal, duals = np.zeros((self._count, 6 * count)), np.empty_like(samples)
        combine = _difference_rows()
        for batch, rows in self._differences(samples):
            volumes = self._volumes[batch].sum(axis=1)[:, None, None]
            weighed = volumes * rows
            products[batch] = rows.transpose(0, 2, 1) @ weighed
            back = combine.T @ weighed.reshape(len(rows), 10, -1)
            np.add.at(nodal, self._elements[batch], back[:, :10])
            duals[batch] = back[:, 10:].reshape(samples[batch].shape)
        for start, stop, at, to in zip(
            self._limits, self._limits[1:], self._at, self._at[1:], strict=False
        ):
            sides = self._fit[at:to].T @ nodal[self._nodes[at:to]]
            patch = self._terms[start:stop].reshape(-1, 10) @ sides
            duals[self._round[start:stop]] += patch.reshape(stop - start, *samples.shape[1:])
        trace = lame * duals[:, :, :3].sum(axis=2, keepdims=True)
        duals *= shear
        duals[:, :, :3] *= 2.0
        duals[:, :, :3] += trace
        return ErrorDuals(products, duals)

    def forces(self, stresses: Array) -> Array:
        """Forces (n, 3, k) on the nodes whose work is that of integrated stresses (m, 4, 6, k)."""
        count = stresses.shape[3]
        forces = np.zeros((self._count, 3 * count))
        for batch in self._batches(count):
            spatial = self._spatial[batch]
            rows = spatial.transpose(0, 2, 1, 3).reshape(len(spatial), 10, 12)
            # In rows: sampling point and derivative; in columns: axis of the force and solution.
            tensors = stresses[batch][:, :, TENSOR].reshape(len(spatial), 12, 3 * count)
            np.add.at(forces, self._elements[batch], rows @ tensors)
        return forces.reshape(-1, 3, count)

    def work_slopes(self, stresses: Array, displacements: Array, moving: Array) -> Array:
        """Derivatives (v, k, k) of the work of integrated stresses (column) on solutions (row).

        Parameters
        ----------
        stresses : (m, 4, 6, k) array
            That stay.
        displacements : (n, 3, k) array
            That move with the nodes: their gradients change by -(grad u grad v).
        moving : (n, v, 3) array
            Velocities of the nodes.
        """
        count, velocities = displacements.shape[2], moving.shape[1]
        total = np.zeros((velocities, count * count))
        for batch in self._batches(count * count):
            nodes, spatial = self._elements[batch], self._spatial[batch]
            size = len(nodes), 4, 3
            across = spatial.transpose(0, 1, 3, 2).reshape(len(nodes), 12, 10)
            slopes = across @ displacements[nodes].reshape(len(nodes), 10, -1)
            turns = across @ moving[nodes].reshape(len(nodes), 10, -1)
            # works[k, u, j, s]: d u_i / d x_k times stress s_ij, to be multiplied by d v_k / d x_j
            works = slopes.reshape(*size, 3, count).swapaxes(3, 4) @ stresses[batch][
                :, :, TENSOR
            ].reshape(len(nodes), 4, 1, 3, -1)
            ordered = works.reshape(*size, count, 3, count).transpose(0, 1, 4, 2, 3, 5)
            turned = turns.reshape(*size, velocities, 3).transpose(3, 0, 1, 2, 4)
            total -= turned.reshape(velocities, -1) @ ordered.reshape(-1, count * count)
        return total.reshape(velocities, count, count)

    def growths(self, moving: Array) -> Array:
        """Relative change (m, v) of the elements' volumes by velocities (n, v, 3) of the nodes."""
        growths = np.empty((len(self._elements), moving.shape[1]))
        for batch in self._batches(moving.shape[1]):
            weighed = self._volumes[batch][:, None] @ self._spatial[batch].reshape(
                *self._volumes[batch].shape, 30
            )
            nodes = (
                moving[self._elements[batch]]
                .transpose(0, 1, 3, 2)
                .reshape(-1, 30, growths.shape[1])
            )
            volumes = self._volumes[batch].sum(axis=1)[:, None]
            growths[batch] = (weighed @ nodes)[:, 0] / volumes
        return growths

    def _samples(self, displacements: Array, lame: float, shear: float | Array) -> Array:
        """Stresses (m, 4, 6, k) of the elements at the sampling points."""
        count = displacements.shape[2]
        samples = np.empty((len(self._elements), 4, 6, count))
        for batch in self._batches(count):
            nodes = displacements[self._elements[batch]]
            samples[batch] = _stresses(self._spatial[batch], nodes, lame, shear)
        return samples

    def _recovered(self, samples: Array) -> Array:
        """Stresses (n, 6, k) at the nodes by those at the sampling points."""
        count = samples.shape[3]
        recovered = np.zeros((self._count, 6 * count))
        for start, stop, at, to in zip(
            self._limits, self._limits[1:], self._at, self._at[1:], strict=False
        ):
            patch = samples[self._round[start:stop]].reshape(-1, 6 * count)
            sides = self._terms[start:stop].reshape(-1, 10).T @ patch
            recovered[self._nodes[at:to]] += self._fit[at:to] @ sides
        return recovered.reshape(-1, 6, count)

    def _differences(self, samples: Array) -> Iterator[tuple[slice, Array]]:
        """Recovered stresses less those of the elements, by samples (m, 4, 6, k), in batches of elements.

        Given as rows (b, 60, k) whose sum of squares is the mean square over each element. Stress is linear
        inside a straight element; the recovered one is a quadratic between the nodes.
        """
        combine, recovered = _difference_rows(), self._recovered(samples)
        count = samples.shape[3]
        for batch in self._batches(count):
            nodes = recovered[self._elements[batch]]
            both = np.concatenate([nodes, samples[batch]], axis=1)
            yield batch, (combine @ both.reshape(len(both), 14, -1)).reshape(len(both), -1, count)

    def _batches(self, solutions: int) -> Iterator[slice]:
        size = max(16, IN_CACHE // solutions)
        for start in range(0, len(self._elements), size):
            yield slice(start, start + size)


def _grouped(owner: Integers, count: int) -> tuple[Integers, Integers, Integers]:
    """Order (k,) by owners, each of `count`; the owners in that order; where each one's part starts."""
    order = np.argsort(owner, kind="stable")
    ordered = owner[order]
    return order, ordered, np.searchsorted(ordered, np.arange(count))


def _roots(material: Material) -> tuple[float, Array]:
    """Lame's constant and shear modulus of "stresses" whose squares add up to twice the energy."""
    root = np.sqrt(material.shear_modulus)
    lame = np.sqrt(3.0 * material.lame_constant + 2.0 * root**2) - np.sqrt(2.0) * root
    return float(lame / 3.0), root * np.repeat([np.sqrt(0.5), 1.0], 3)[:, None]


def _terms(local: Array) -> Array:
    """Terms (..., 10) of a quadratic polynomial at places (..., 3)."""
    x, y, z = np.moveaxis(local, -1, 0)
    return np.stack([np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x], axis=-1)


def _difference_rows() -> Array:
    """Rows (10, 14) that give a difference of stresses from those at nodes and sampling points."""
    values, _, weights = shapes_for_quadrature(ENERGY_ORDER)
    masses = (values.T * weights / weights.sum()) @ values
    # The linear function through the values at the sampling points, at nodes in barycentric coordinates.
    shapes, _, _ = shapes_for_quadrature(SAMPLING_ORDER)
    sampled = shapes[:, :4] + 0.5 * shapes[:, 4:] @ _ENDS
    linear = np.vstack([np.eye(4), 0.5 * _ENDS]) @ np.linalg.inv(sampled)
    return np.asarray(np.linalg.cholesky(masses).T @ np.hstack([np.eye(10), -linear]))


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


# What is left of the error of slopes over dimensions is within this share of an answer's correction, where
# the correction is differentiated (True) or not, this share of that of the axial compliance, and what
# slopes of two meshes differ by in any case, together: in 95 of 100 slopes of random throws
# (tests/campaigns/slopes.py).
SLOPE_UNCERTAINTY = {True: 0.25, False: 1.5}
MESH_SLOPE_UNCERTAINTY, SLOPE_NOISE = 0.2, 1e-3


def class_energies(part: CondensedClass, recovery: StressRecovery, material: Material) -> Array:
    """Mutual energies (k + a, k + a) of the errors of a class: of k unit motions, then of a pin loads [J]."""
    return recovery.products(np.concatenate([part.fields, part.pin_fields], axis=2), material)


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


def slope_errors(
    corrected: ArrayLike,
    discrete: ArrayLike,
    axial_correction: float,
    differentiated: bool,
    missing: float = 0.0,
) -> Array:
    """Estimated errors of d ln(result) / d ln(dimension), whatever the dimension.

    Parameters
    ----------
    corrected, discrete, axial_correction, missing
        As of `error_bars`; no result is zero.
    differentiated : bool
        Whether slopes are those of corrected results, not of the discrete ones.
    """
    correction = np.abs(1.0 - np.divide(discrete, corrected))
    floor = MESH_SLOPE_UNCERTAINTY * axial_correction + SLOPE_NOISE
    return np.asarray(SLOPE_UNCERTAINTY[differentiated] * correction + missing + floor)


def _largest_share(stiffness: Array, energies: Array) -> float:
    """Largest share of the energies in the stiffness (k, k), of all motions that are not rigid."""
    # A unit motion may be rigid, its energy nothing but round-off.
    diagonal = np.diag(stiffness)
    scale = 1.0 / np.sqrt(np.maximum(diagonal, 1e-12 * diagonal.max()))
    values, motions = np.linalg.eigh(scale[:, None] * stiffness * scale)
    elastic = values > 1e-9 * values[-1]
    motions = scale[:, None] * motions[:, elastic] / np.sqrt(values[elastic])
    return float(np.linalg.eigvalsh(motions.T @ energies @ motions)[-1])
