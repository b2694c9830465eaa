"""A whole crankshaft as one solid: mesh, natural modes, and a deck for CalculiX.

What superelements are checked against: no throw is condensed, no section is rigid. For every day it is
too slow.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from fem.material import Material
from fem.modes import LANCZOS_TOLERANCE, frequencies_of
from fem.solver import assemble_mass, assemble_stiffness, factorize
from fem.symmetry import rigid_motions
from geometry.crankshaft import Crankshaft, make_shaft
from geometry.gmsh_session import gmsh_errors, gmsh_session
from geometry.mesh import (
    SolidProperties,
    ThrowMesh,
    check_quality,
    check_volume,
    read_mesh,
    solid_properties,
)
from geometry.mesh_exchange import inp_nodes_and_elements, number_field
from geometry.shapes import straighten_elements

Array = NDArray[np.float64]

# Elements at curved surfaces: so many to a full circle, and no smaller than this share of the others.
AROUND = 10
SMALLEST = 0.3
# Nodes of a main journal within this share of its diameter from a section stand for the section.
NEAR = 0.12
# The shift lies at this frequency [Hz], below the elastic modes of shafts.
SHIFT = 60.0


@dataclass(frozen=True)
class ShaftMesh:
    """A mesh of a whole crankshaft.

    Attributes
    ----------
    points : (n, 3) array
        [m]
    elements : (m, 10) array
        Node numbers of tetrahedra.
    sections : (s,) array
        Places of the throws' ends along the shaft [m].
    journal_diameter : float
        [m]
    """

    points: Array = field(repr=False)
    elements: NDArray[np.int64] = field(repr=False)
    sections: Array
    journal_diameter: float

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns."""
        return 3 * len(self.points)

    def nodes_near(self, section: float) -> NDArray[np.int64]:
        """Nodes in the main journal near a section [m]."""
        radius = np.hypot(self.points[:, 0], self.points[:, 1])
        inside = radius <= 0.5 * self.journal_diameter * (1.0 + 1e-6)
        near = np.abs(self.points[:, 2] - section) <= NEAR * self.journal_diameter
        return np.flatnonzero(inside & near)


def mesh_shaft(
    shaft: Crankshaft,
    size: float,
    line: Sequence[tuple[float, float]] = (),
    around: int = AROUND,
) -> ShaftMesh:
    """Mesh a whole crankshaft, in this process.

    Parameters
    ----------
    shaft : Crankshaft
    size : float
        Of the elements, smaller ones at curved surfaces [m].
    line : sequence of pairs of float, optional
        Diameter and length of the cylinders that follow the last section [m]. No element reaches from one
        into the next.
    around : int, optional
        Elements to a full circle of curved surfaces.

    Raises
    ------
    MeshError
        If gmsh fails, or the mesh is not that of the solid.
    """
    points, elements, _ = _meshed(shaft, size, around, SMALLEST, line=line)
    return ShaftMesh(points, elements, shaft.starts, shaft.throws[0].main_journal_diameter)


def mesh_shaft_quarter(shaft: Crankshaft, size: float, around: int, smallest: float) -> ThrowMesh:
    """Mesh a quarter, x >= 0, z <= length / 2, of a shaft with these two planes of symmetry.

    It is a quarter of one long throw, whose free modes are those of the shaft (`fem.modes.free_modes`).

    Parameters
    ----------
    shaft : Crankshaft
    size : float
        Of the elements [m].
    around : int
        Elements to a full circle of curved surfaces.
    smallest : float
        Smallest element, as a share of `size`.
    """
    points, elements, solid = _meshed(shaft, size, around, smallest, quarter=True)
    return ThrowMesh("quarter", shaft.length, (), points, elements, {}, 1.0, 0, solid)


def _meshed(
    shaft: Crankshaft,
    size: float,
    around: int,
    smallest: float,
    *,
    quarter: bool = False,
    line: Sequence[tuple[float, float]] = (),
) -> tuple[Array, NDArray[np.int64], SolidProperties]:
    """Mesh a shaft or a quarter of it: points (n, 3), elements (m, 10) and the solid without its line."""
    with gmsh_session("shaft") as gmsh, gmsh_errors("mesh the shaft"):
        make_shaft(gmsh, shaft)
        if quarter:
            reach = 10.0 * shaft.length
            box = gmsh.model.occ.addBox(
                0, -reach, -reach, reach, 2 * reach, reach + shaft.length / 2
            )
            gmsh.model.occ.intersect(gmsh.model.getEntities(3), [(3, box)])
            gmsh.model.occ.synchronize()
        solid = solid_properties(gmsh)
        pieces, place = [], float(shaft.starts[-1])
        for diameter, length in line:
            tag = gmsh.model.occ.addCylinder(0, 0, place, 0, 0, length, diameter / 2)
            pieces.append((3, tag))
            place += length
        if pieces:
            gmsh.model.occ.fragment(gmsh.model.getEntities(3), pieces)
            gmsh.model.occ.synchronize()
        for option, value in (
            ("MeshSizeMax", size),
            ("MeshSizeMin", smallest * size),
            ("MeshSizeFromCurvature", around),
        ):
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        points, elements, _ = read_mesh(gmsh, {})
    points, _ = straighten_elements(points, elements)
    beyond = sum(np.pi / 4.0 * diameter**2 * length for diameter, length in line)
    check_volume(points, elements, replace(solid, volume=solid.volume + beyond))
    check_quality(points, elements)
    return points, elements, solid


def solid_modes(
    mesh: ShaftMesh,
    material: Material,
    count: int,
    *,
    lateral_stiffness: Sequence[float] = (),
    axial_stiffness: Sequence[float] = (),
) -> tuple[Array, Array]:
    """Find the lowest modes of a shaft, rigid motions included.

    Parameters
    ----------
    mesh : ShaftMesh
    material : Material
    count : int
        How many.
    lateral_stiffness, axial_stiffness : sequence of float, optional
        Springs to ground at each section, on its mean motion across and along the shaft [N/m].

    Returns
    -------
    frequencies : (count,) array
        Ascending [Hz]; those of rigid motions are zero but for rounding.
    section_motions : (s, 6, count) array
        Mean motions of the sections: displacements, rotations, fitted to the nodes near them; modes are
        of unit modal mass.

    Raises
    ------
    ValueError
        If springs are given, but not one for each section.
    """
    stiffness = assemble_stiffness(mesh.points, mesh.elements, material)
    mass = assemble_mass(mesh.points, mesh.elements, material.density)
    fits = [_mean_motion(mesh, section) for section in mesh.sections]
    for springs, axes in ((lateral_stiffness, (0, 1)), (axial_stiffness, (2,))):
        for fit, spring in zip(fits, springs or [0.0] * len(fits), strict=True):
            for axis in axes:
                row = fit[[axis]]
                stiffness = stiffness + sparse.triu(spring * (row.T @ row), format="csr")
    squares, shapes, _ = lowest_modes(stiffness, mass, count)
    return frequencies_of(squares), np.array([fit @ shapes for fit in fits])


def lowest_modes(
    stiffness: sparse.csr_array,
    mass: sparse.csr_array,
    count: int,
    loads: Array | None = None,
    shift: float = SHIFT,
) -> tuple[Array, Array, Array]:
    """Find the lowest modes, and the response to loads that grow with exp(s t).

    Parameters
    ----------
    stiffness, mass : (u, u) sparse arrays
        Upper triangles.
    count : int
    loads : (u, c) array, optional
    shift : float, optional
        s / (2 pi) [Hz], below the elastic modes.

    Returns
    -------
    squares : (count,) array
        Of the angular frequencies, ascending [rad^2/s^2].
    shapes : (u, count) array
        Of unit modal mass.
    grown : (u, c) array
        (K + s^2 M)^(-1) times the loads.
    """
    square = (2.0 * np.pi * shift) ** 2
    size = stiffness.shape[0]
    whole_mass = (mass + sparse.triu(mass, k=1).T).tocsr()
    with factorize(sparse.csr_array(stiffness + square * mass), "auto") as factors:

        def solve(side: Array) -> Array:
            return np.asarray(factors.solve(np.asarray(side).reshape(-1, 1))[:, 0])

        start = np.random.default_rng(0).standard_normal(size)
        squares, shapes = eigsh(
            whole_mass,  # only its size is used, the operator below being given
            count,
            M=whole_mass,
            sigma=-square,
            OPinv=LinearOperator((size, size), matvec=solve, dtype=np.float64),
            v0=solve(whole_mass @ start),
            tol=LANCZOS_TOLERANCE,
        )
        # A side without columns is no system to Pardiso.
        grown = np.zeros((size, 0)) if loads is None else factors.solve(loads)
    order = np.argsort(squares)
    return squares[order], shapes[:, order], np.asarray(grown)


def frequency_deck(mesh: ShaftMesh, material: Material, count: int) -> str:
    """Write a deck for CalculiX that finds the lowest modes of the free shaft.

    Parameters
    ----------
    mesh : ShaftMesh
    material : Material
    count : int
        How many modes, the six rigid motions included.

    Returns
    -------
    str
        ``ccx`` prints the frequencies into its .dat file.
    """
    lines = list(inp_nodes_and_elements(mesh.points, mesh.elements, "SHAFT"))
    lines += [
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        f"{number_field(material.youngs_modulus)},{number_field(material.poisson_ratio)}",
        "*DENSITY",
        number_field(material.density),
        "*SOLID SECTION, ELSET=SHAFT, MATERIAL=STEEL",
        "*STEP",
        "*FREQUENCY",
        str(count),
        "*END STEP",
    ]
    return "\n".join(lines) + "\n"


def _mean_motion(mesh: ShaftMesh, section: float) -> sparse.csr_array:
    return mean_motion(mesh.points, mesh.nodes_near(section), (0.0, 0.0, section))


def mean_motion(
    points: Array, nodes: NDArray[np.int64], center: Sequence[float]
) -> sparse.csr_array:
    """Rows (6, 3 n): the rigid motion about a center that fits that of some nodes best."""
    fit = np.linalg.pinv(rigid_motions(points[nodes] - center).reshape(-1, 6))
    columns = (3 * nodes[:, np.newaxis] + np.arange(3)).ravel()
    rows = np.repeat(np.arange(6), columns.size)
    return sparse.csr_array((fit.ravel(), (rows, np.tile(columns, 6))), shape=(6, 3 * len(points)))
