"""End parts and free modes of a crankshaft from CAD; against CalculiX: tests/campaigns/cad_free_modes.py."""

import math
from dataclasses import replace

import pytest
import typer

from cad_files import Posture, write_parts, write_shaft
from comparing import close
from crankbase.errors import InputError
from crankfem.satellites.cad.command import cad
from crankfem.satellites.cad.free_shaft import free_modes
from crankfem.satellites.cad.run import end_analyses, run_cad
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.crankshaft import Crankshaft, ShaftEnds, make_shaft
from geometry.imported_shaft import import_crankshaft
from geometry.throw import CrankThrow
from stand_ins import caller_of

pytestmark = pytest.mark.slow
FREE = {"free_end_diameter": 0.16, "free_end_length": 0.2}
ENDS = ShaftEnds(**FREE, flange_diameter=0.35, flange_thickness=0.06)


@pytest.fixture(scope="module")
def shaft(dimensions):
    throw = CrankThrow(**dimensions)
    return Crankshaft([throw, throw], crank_angles_deg=[0.0, 180.0], ends=ENDS)


@pytest.fixture(scope="module")
def file(shaft, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cad")
    return write_shaft(folder / "crank.step", shaft, Posture((0.4, -1.1, 0.7)))


@pytest.fixture(scope="module")
def run(file):
    return run_cad(file, accuracy=0.05, free=5)


def test_end_parts_have_the_stiffness_of_their_cylinders(run):
    """Torsion is exact: sections of a cylinder turn without warping."""
    free, flange = run.ends
    shear = STEEL.youngs_modulus / (2.0 + 2.0 * STEEL.poisson_ratio)
    for end, diameter, length in ((free, 0.16, 0.2), (flange, 0.35, 0.06)):
        assert end.length == close(length, rel=1e-9)
        polar = math.pi / 32.0 * diameter**4
        assert end.torsional_stiffness == close(shear * polar / length, rel=5e-3)
        area = math.pi / 4.0 * diameter**2
        # Sections that keep their diameter stiffen: a thin flange up to plane strain.
        uniaxial = STEEL.youngs_modulus * area / length
        assert uniaxial < end.axial_stiffness < 1.35 * uniaxial
        assert end.remark == ""


def test_free_modes_do_not_depend_on_the_cuts(file, run):
    modes = run.free_modes
    frequencies = [mode.frequency for mode in modes]
    assert frequencies == sorted(frequencies)
    assert len(modes) == 5
    moved = run_cad(file, accuracy=0.05, free=5, cuts={1: 0.03, 2: -0.03, 3: -0.04})
    assert [mode.frequency for mode in moved.free_modes] == close(frequencies, rel=5e-3)


def test_a_rigid_end_part_in_place_of_a_stiff_one(file, run):
    """The flange is short and thick; the free end is no part of the lowest modes either."""
    shaft = run.shaft
    analyses = {shaft.throws[0]: run.analyses[1]}
    rigid = free_modes(shaft, analyses, 5, 0.05)
    assert rigid.rigid == 6
    frequencies = [mode.frequency for mode in run.free_modes]
    assert rigid.frequencies[6:11] == close(frequencies, rel=5e-3)


def test_an_end_that_is_no_plane_counts_as_rigid(shaft, tmp_path):
    def pointed(gmsh):
        make_shaft(gmsh, replace(shaft, ends=ShaftEnds(**FREE)))
        occ = gmsh.model.occ
        (solid,) = gmsh.model.getEntities(3)
        place = shaft.starts[-1]
        occ.fuse([solid], [(3, occ.addCone(0, 0, place, 0, 0, 0.1, 0.11, 0.0))])

    path = write_parts(tmp_path / "pointed.step", pointed)
    read = import_crankshaft(path, free_end="low")
    assert read.ends[1].part is None
    assert "allowed is" in read.ends[1].fault
    assert list(end_analyses(read, 0.1)) == [read.ends[0].part]


def test_end_parts_are_analyzed_like_throws_without_pins(file):
    part = import_crankshaft(file).ends[1].part
    assert part.pins == ()
    assert part.symmetry == "quarter"
    assert (part.crank_radius, part.length) == close((0.0, 0.06), rel=1e-9)
    analysis = analyze_throw(part, accuracy=0.1)
    assert analysis.superelement.pin_loads.shape == (0, 12, 6)
    assert analysis.axial_compliance() > 0.0
    assert "pin" not in repr(analysis)


def test_modes_take_finite_elements(file):
    app = typer.Typer()
    app.command()(cad)
    call = caller_of(app)
    with pytest.raises(InputError, match="--free-modes: given with --no-fe"):
        call(file, "--no-fe", "--free-modes", "3")
