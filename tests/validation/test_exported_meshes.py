"""Exported meshes and solids, read by other programs.

Source: CalculiX 2.20 solves the plain .inp, gmsh 4.15 integrates .msh and .med and measures the STEP,
MEDCoupling 9.15 the .med, VTK 9.7 the .vtu and .stl, meshio 5.3 the .inp; references are crankfem's own
mesh and its 12 x 12.

Tolerance: 1e-9, the same polynomials or triangles; 1e-6 for single precision (.stl) and the kernel's solid;
1e-5 for CalculiX's 7 digits.

A wrong order of the edge nodes moves a volume by percents, a wrong face number of an element the reaction
to a pressure.
"""

import platform
import re
import shutil

import meshio
import numpy as np
import pytest
import pyvista

from calculix_run import run_calculix
from comparing import close
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.gmsh_session import gmsh_session
from geometry.mesh import flat_triangles, flattened, mesh_throw, six_node_triangles
from geometry.shapes import EDGES, element_volumes, triangle_shapes_at
from geometry.solid_files import MESH_ENDINGS, write_mesh, write_step
from geometry.throw import CrankThrow

SAME = 1e-9
# gmsh's and VTK's numbers of the ten-node tetrahedron and of the six-node triangle.
TETRAHEDRON, TRIANGLE = 11, 9
DECK = """*INCLUDE, INPUT=throw.inp
*NODE, NSET=ENDS
900001, 0, 0, 0
900002, 0, 0, 0
900003, 0, 0, {length!r}
900004, 0, 0, {length!r}
*MATERIAL, NAME=STEEL
*ELASTIC
{modulus!r}, {ratio!r}
*SOLID SECTION, ELSET=THROW, MATERIAL=STEEL
*RIGID BODY, NSET=LEFT_END, REF NODE=900001, ROT NODE=900002
*RIGID BODY, NSET=RIGHT_END, REF NODE=900003, ROT NODE=900004
*STEP
*STATIC
*BOUNDARY
900001, 1, 3
900002, 3, 3
900003, 1, 2
*CLOAD
900003, 3, 1.0
*NODE PRINT, NSET=ENDS
U
*END STEP
"""
PRESSED = """*INCLUDE, INPUT=throw.inp
*MATERIAL, NAME=STEEL
*ELASTIC
2.1e11, 0.3
*SOLID SECTION, ELSET=THROW, MATERIAL=STEEL
*BOUNDARY
LEFT_END, 1, 3
*STEP
*STATIC
*DSLOAD
RIGHT_END, P, 1.0
*NODE PRINT, NSET=LEFT_END, TOTALS=ONLY
RF
*END STEP
"""


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions | {"fillet_radius": 0.012, "pin_bore": 0.06})


@pytest.fixture(scope="module")
def mesh(throw):
    return mesh_throw(throw, 3.0, "full")


@pytest.fixture(scope="module")
def files(mesh, tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported")
    return {ending: write_mesh(mesh, folder / f"throw{ending}") for ending in MESH_ENDINGS}


def flat_area(points, triangles):
    a, b, c = points[triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def curved_area(mesh, corners):
    """By the quadrature that gmsh is asked for: six points, of order 4."""
    from skfem import MeshTri1
    from skfem.quadrature import get_quadrature

    where, weights = get_quadrature(MeshTri1.elem.refdom, 4)
    sides = mesh.points[six_node_triangles(mesh, corners)]
    first, second = np.einsum("iaq,tic->aqtc", triangle_shapes_at(where)[1], sides)
    return float(weights @ np.linalg.norm(np.cross(first, second), axis=-1).sum(axis=1))


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".msh", ".med"])
def test_gmsh_integrates_volume_and_named_surfaces(mesh, files, figure, ending):
    found, quality = {}, None
    with gmsh_session("read") as gmsh:
        gmsh.merge(str(files[ending]))
        quality = gmsh.model.mesh.getElementQualities(
            gmsh.model.mesh.getElementsByType(TETRAHEDRON)[0], "minSJ"
        )
        for dimension, group in gmsh.model.getPhysicalGroups():
            # gmsh fills the names of groups of a .med with blanks.
            name = gmsh.model.getPhysicalName(dimension, group).strip()
            name = name if ending == ".msh" else name.lower().replace("_", " ")
            kind = TETRAHEDRON if dimension == 3 else TRIANGLE
            local, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss4")
            found[name] = sum(
                (np.reshape(determinants, (-1, len(weights))) @ weights).sum()
                for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
                for determinants in [gmsh.model.mesh.getJacobians(kind, local, entity)[1]]
            )
    assert np.min(quality) > 0.0
    figure(
        f"volume of the {ending} by gmsh",
        found.pop("throw"),
        element_volumes(mesh.points, mesh.elements).sum(),
        SAME,
        "m^3",
    )
    expected = {name: curved_area(mesh, corners) for name, corners in mesh.surfaces.items()}
    assert found.keys() == expected.keys()
    assert np.array([found[name] for name in expected]) == close(
        np.array(list(expected.values())), rel=SAME
    )


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="no MEDCoupling for it")
def test_medcoupling_takes_volume_and_groups(mesh, files, figure):
    import medcoupling

    read = medcoupling.MEDFileUMesh(str(files[".med"]))
    volumes = read[0].getMeasureField(False).getArray().toNumPyArray()
    assert volumes.min() > 0.0
    corners = mesh.points[mesh.elements[:, :4]]
    straight = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0
    figure("volume of the .med by MEDCoupling", volumes.sum(), straight, SAME, "m^3")
    for name, facets in mesh.surfaces.items():
        area = (
            read.getGroup(-1, name.upper().replace(" ", "_")).getMeasureField(False).accumulate()[0]
        )
        assert area == close(flat_area(mesh.points, facets), rel=SAME)
    surfaces = [name.upper().replace(" ", "_") for name in mesh.surfaces]
    assert set(read.getGroupsNames()) == {"THROW", *surfaces}
    # Edge nodes stand where MEDCoupling's own element has them.
    default = medcoupling.MEDCouplingGaussLocalization.GetDefaultReferenceCoordinatesOf
    reference = np.reshape(default(medcoupling.NORM_TETRA10).getValues(), (10, 3))
    middles = [
        next(edge for edge in EDGES if np.allclose(reference[list(edge)].mean(axis=0), place))
        for place in reference[4:]
    ]
    nodes = read[0].getNodalConnectivity().toNumPyArray().reshape(-1, 11)[:, 1:]
    points = read.getCoords().toNumPyArray()[nodes]
    expected = points[:, np.array(middles)].mean(axis=2)
    distances = np.linalg.norm(points[:, 4:, None] - expected[:, None], axis=3)
    assert np.all(distances.argmin(axis=2) == np.arange(6))


@pytest.mark.slow
def test_vtk_measures_volume_and_flagged_surfaces(mesh, files, figure):
    grid = pyvista.read(files[".vtu"])
    # VTK cuts a curved element into straight ones, and so has the volume within the flat triangles.
    whole = pyvista.PolyData.from_regular_faces(mesh.points, flat_triangles(mesh))
    sizes = grid.compute_cell_sizes()
    volumes = sizes["Volume"][grid.celltypes == pyvista.CellType.QUADRATIC_TETRA]
    assert volumes.min() > 0.0
    figure("volume of the .vtu by VTK", volumes.sum(), whole.volume, SAME, "m^3")
    for name, facets in mesh.surfaces.items():
        area = flat_area(mesh.points, flattened(six_node_triangles(mesh, facets)))
        assert sizes["Area"][grid.cell_data[name] == 1].sum() == close(area, rel=SAME)
    surface = pyvista.read(files[".stl"])
    assert surface.volume == close(whole.volume, rel=1e-6)
    assert surface.is_manifold


@pytest.mark.slow
def test_meshio_reads_nodes_and_elements(mesh, files):
    for ending in (".inp", ".vtu"):
        read = meshio.read(files[ending])
        elements = read.cells_dict["tetra10"].astype(np.int64)
        assert np.array_equal(elements, mesh.elements)
        assert read.points == close(mesh.points, rel=1e-12)


@pytest.mark.slow
def test_gmsh_reads_the_solids_of_the_surface_and_the_step(throw, mesh, files, tmp_path, figure):
    step = write_step(throw, tmp_path / "throw.step")
    with gmsh_session("read") as gmsh:
        gmsh.merge(str(files[".stl"]))
        assert len(gmsh.model.getEntities(2)) == len(mesh.surfaces)
    with gmsh_session("read") as gmsh:
        # Otherwise gmsh turns the metres that the file names into millimetres.
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        try:
            ((_, solid),) = gmsh.model.occ.importShapes(str(step))
            volume = gmsh.model.occ.getMass(3, solid)
        finally:
            gmsh.option.setString("Geometry.OCCTargetUnit", "")
    figure("volume of the STEP by gmsh", volume, throw.volume, 1e-6, "m^3")


needs_calculix = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is not installed: apt-get install calculix-ccx"
)


@needs_calculix
@pytest.mark.further
def test_calculix_solves_the_plain_mesh(throw, mesh, files, figure):
    deck = files[".inp"].with_name("deck.inp")
    modulus, ratio = STEEL.youngs_modulus, STEEL.poisson_ratio
    deck.write_text(DECK.format(length=mesh.length, modulus=modulus, ratio=ratio), encoding="ascii")
    printed = run_calculix(deck, threads=1).read_text(encoding="ascii")
    motions = {
        int(row.split()[0]): row.split()[1:] for row in printed.splitlines() if "90000" in row
    }
    ours = analyze_throw(throw, accuracy=0.1, mesher=lambda *_, **__: mesh).discrete
    figure(
        "axial compliance of the plain .inp by CalculiX",
        ours.axial_compliance(),
        float(motions[900003][2]),
        1e-5,
        "m/N",
    )


@needs_calculix
@pytest.mark.further
def test_calculix_presses_on_a_named_surface(mesh, files, figure):
    deck = files[".inp"].with_name("pressed.inp")
    deck.write_text(PRESSED, encoding="ascii")
    printed = run_calculix(deck, threads=1).read_text(encoding="ascii")
    totals = re.search(r"total force.*\n\s*\n(.*)", printed)
    reaction = np.array(totals[1].split(), dtype=float)
    area = curved_area(mesh, mesh.surfaces["right end"])
    assert reaction[:2] == close(np.zeros(2), abs=1e-5 * area)
    figure("pressure on the right end by CalculiX", area, reaction[2], 1e-5, "m^2")
