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
equilibrium as those of the plain one are. The energies come from recovered stresses (`fem.recovery`), which
miss a part of them, similar for throws of a kind: `effectivity`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem.condensation import CondensedClass, end_amplitudes
from fem.material import Material
from fem.recovery import StressErrors, stress_errors
from fem.section_motions import RIGID
from geometry.mesh import ThrowMesh
from geometry.solid import FILLET

Array = NDArray[np.float64]

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
    mesh : ThrowMesh
    share : float
        Estimated error of the axial compliance, pinned, as a share of it.
    """
    finest, fall = EFFECTIVITY[len(mesh.surfaces.get(FILLET, ())) > 0]
    return max(1.0, finest - fall * share)


def corrected_class(part: CondensedClass, energies: Array, factor: float) -> CondensedClass:
    """Correct a condensed class for discretization.

    Parameters
    ----------
    part : CondensedClass
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
