import meshio
import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from geometry.crankshaft import Crankshaft, ShaftEnds
from geometry.gmsh_session import gmsh_session
from geometry.imported import import_throw
from geometry.mesh import mesh_throw
from geometry.recognition import opened_part
from geometry.shapes import element_volumes
from geometry.solid_files import MESH_ENDINGS, write_mesh, write_step
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin, Web


@pytest.fixture(scope="module")
def mesh(dimensions):
    return mesh_throw(CrankThrow(**dimensions, pin_bore=0.06), 2.0, "full")


@pytest.mark.parametrize("ending", [".vtu", ".vtk", ".inp", ".med", ".msh"])
def test_solid_formats_keep_nodes_elements_and_surfaces(mesh, tmp_path, ending):
    if ending == ".med":
        pytest.importorskip("h5py")
    read = meshio.read(write_mesh(mesh, tmp_path / f"throw{ending}"))
    elements = np.concatenate([b.data for b in read.cells if b.type == "tetra10"])
    assert np.sort(read.points, axis=0) == close(np.sort(mesh.points, axis=0), abs=1e-12)
    assert len(elements) == len(mesh.elements)
    # meshio's tetrahedra have scikit-fem's order of edge nodes; a wrong one gives a wrong volume.
    volume = element_volumes(read.points, elements.astype(np.int64)).sum()
    assert volume == close(mesh.solid.volume, rel=1e-3)
    triangles = sum(len(b.data) for b in read.cells if b.type == "triangle6")
    assert triangles == sum(len(corners) for corners in mesh.surfaces.values())


def test_gmsh_reads_its_own_format_with_names(mesh, tmp_path):
    path = write_mesh(mesh, tmp_path / "throw.msh")
    with gmsh_session("read") as gmsh:
        gmsh.merge(str(path))
        groups = gmsh.model.getPhysicalGroups()
        names = {gmsh.model.getPhysicalName(*group) for group in groups}
        kinds, _, _ = gmsh.model.mesh.getElements(3)
        # gmsh's own check of orientation and order: signed inverse condition numbers.
        _, tags, _ = gmsh.model.mesh.getElements(3)
        quality = gmsh.model.mesh.getElementQualities(tags[0], "minSJ")
    assert names == {"throw", *(n for n, corners in mesh.surfaces.items() if len(corners))}
    assert list(kinds) == [11]
    assert min(quality) > 0.0


def test_sets_of_abaqus_files_have_names(mesh, tmp_path):
    text = write_mesh(mesh, tmp_path / "throw.inp").read_text()
    for name in ("left_end", "right_end", "pin", "throw"):
        assert f"ELSET={name}" in text.replace(" ", "")


@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")  # in meshio's reader
@pytest.mark.parametrize("ending", [".stl", ".ply", ".obj"])
def test_surface_formats_enclose_the_volume(mesh, tmp_path, ending):
    read = meshio.read(write_mesh(mesh, tmp_path / f"throw{ending}"))
    a, b, c = read.points[read.cells_dict["triangle"]].transpose(1, 0, 2).astype(float)
    volume = np.einsum("ti,ti->t", a, np.cross(b, c)).sum() / 6.0
    # Flat triangles cut the corners of fillets and journals.
    assert volume == close(mesh.solid.volume, rel=0.02)


def test_values_at_nodes_travel(mesh, tmp_path):
    values = {"displacement": mesh.points * 2.0}
    read = meshio.read(write_mesh(mesh, tmp_path / "throw.vtu", values))
    assert read.point_data["displacement"] == close(mesh.points * 2.0)


def test_unknown_endings_and_missing_folders(mesh, tmp_path):
    with pytest.raises(InputError, match=r"'\.bdf'; allowed for a mesh are \.msh"):
        write_mesh(mesh, tmp_path / "throw.bdf")
    for ending in MESH_ENDINGS:
        if ending == ".med":
            continue
        with pytest.raises(InputError, match="cannot be written"):
            write_mesh(mesh, tmp_path / "nowhere" / f"throw{ending}")


def read_step(path):
    """Volume and reach along z of the one solid in a file, in m."""
    with opened_part(str(path)) as (gmsh, solid):
        gmsh.model.occ.synchronize()
        box = gmsh.model.getBoundingBox(3, solid)
        return gmsh.model.occ.getMass(3, solid), box[5] - box[2]


def test_step_of_a_throw_and_of_a_shaft_come_back_in_metres(dimensions, tmp_path):
    throw = CrankThrow(**dimensions, pin_bore=0.06)
    volume, length = read_step(write_step(throw, tmp_path / "throw.step"))
    assert volume == close(throw.volume, rel=1e-6)
    assert length == close(throw.length, rel=1e-5)
    half, _ = read_step(write_step(throw, tmp_path / "half.stp", "half"))
    assert half == close(throw.volume / 2.0, rel=1e-6)
    ends = ShaftEnds(free_end_diameter=0.2, free_end_length=0.3)
    shaft = Crankshaft([throw] * 3, crank_angles_deg=[0.0, 120.0, 240.0], ends=ends)
    volume, length = read_step(write_step(shaft, tmp_path / "shaft.step"))
    assert volume == close(shaft.masses(1.0).mass, rel=1e-6)
    assert length == close(shaft.length, rel=1e-5)


@pytest.mark.parametrize(
    "changes",
    [
        {"pin_bore": 0.06},
        {"fillet_radius": 0.0, "pin_diameter": 0.22},
        {"further_pins": (FurtherPin(angle=0.6, web_thickness=0.0),)},
        {"further_pins": (FurtherPin(angle=np.pi),)},
    ],
)
def test_a_written_throw_is_read_by_its_names(dimensions, tmp_path, changes):
    throw = CrankThrow(**{**dimensions, **changes})
    path = write_step(throw, tmp_path / "throw.step")
    names = [pin.name for pin in throw.parts.pins]
    read = import_throw(path)
    assert read.remarks == ()
    assert read.volume == close(throw.volume, rel=1e-6)
    assert read.length == close(throw.length, rel=1e-9)
    assert np.array(read.pin_axes) == close(np.array(throw.pin_axes), abs=1e-9)
    assert [pin.name for pin in read.pins] == names


def test_step_errors(dimensions, tmp_path):
    throw = CrankThrow(**dimensions)
    lopsided = CrankThrow(**dimensions, right_web=Web(thickness=0.05))
    with pytest.raises(InputError, match="no such symmetry"):
        write_step(lopsided, tmp_path / "throw.step", "quarter")
    with pytest.raises(InputError, match="allowed are auto, quarter"):
        write_step(throw, tmp_path / "throw.step", "third")
    with pytest.raises(InputError, match=r"allowed are \.step, \.stp"):
        write_step(throw, tmp_path / "throw.iges")
    with pytest.raises(InputError, match="cannot be written"):
        write_step(throw, tmp_path / "nowhere" / "throw.step")
