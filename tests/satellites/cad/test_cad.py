import json
import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from cad_files import Posture, make_camshaft, make_rod, write_parts, write_shaft
from campaigns.cad_round_trip import (
    compliance_differences,
    differences,
    random_posture,
    random_shaft,
)
from comparing import close
from crankbase.errors import InputError
from crankfem.files.engine.throw_file import load_crankshaft
from crankfem.satellites.cad.run import run_cad
from fem.analysis import analyze_throw
from fem.material import STEEL
from geometry.crankshaft import Crankshaft, ShaftEnds, make_shaft
from geometry.equal_pieces import CHANGES, Signature
from geometry.imported import import_throw
from geometry.imported_shaft import import_crankshaft
from geometry.mass import mass_properties
from geometry.throw import CrankThrow
from geometry.throw_dimensions import FurtherPin

pytestmark = pytest.mark.slow
# Largest differences of what is read from what was written.
EXACT = {"angle [deg]": 1e-9, "place [m]": 1e-9, "mass": 1e-6, "kinds": 0.0, "symmetries": 0.0}
TURNED = Posture((0.4, -1.1, 0.7), (0.3, -0.2, 0.1))


@pytest.fixture(scope="module")
def four():
    """Four throws with free end and flange."""
    return load_crankshaft("vw-tdi")


@pytest.fixture(scope="module")
def file(four, tmp_path_factory):
    return write_shaft(tmp_path_factory.mktemp("cad") / "crank.step", four, TURNED)


@pytest.fixture(scope="module")
def run(file):
    return run_cad(file, accuracy=None)


def assert_same(shaft, run):
    off = differences(shaft, run)
    assert off.keys() == EXACT.keys()
    assert {name for name, value in off.items() if not value <= EXACT[name]} == set()


def test_a_turned_crankshaft_comes_back(four, run):
    assert_same(four, run)
    assert run.unit == 1e-3
    assert (len(run.solids), len(run.journals), len(run.pins)) == (1, 5, 4)
    throw = four.throws[0]
    for pin in run.pins:
        assert pin.diameter == close(throw.pin_diameter, rel=1e-9)
        assert pin.crank_radius == close(throw.crank_radius, rel=1e-9)
        assert pin.length == close(throw.pin_length, rel=1e-9)
        assert (pin.start_fillet, pin.end_fillet) == close((throw.fillet_radius,) * 2, rel=1e-6)
        assert pin.deviation < 1e-9
    inner = run.journals[1]
    assert inner.diameter == close(throw.main_journal_diameter, rel=1e-9)
    assert inner.length == close(throw.main_journal_length, rel=1e-9)
    assert inner.angle_deg == 0.0


def test_ends_and_whole_mass(four, run):
    density = STEEL.density
    assert run.mass == close(four.masses(density).mass, rel=1e-6)
    free, flange = run.ends
    ends = four.ends
    assert free.mass == close(
        density * math.pi / 4 * ends.free_end_diameter**2 * ends.free_end_length, rel=1e-6
    )
    # A disk's inertia is that of half its mass at its radius.
    assert flange.inertia_about_shaft == close(flange.mass * ends.flange_diameter**2 / 8, rel=1e-6)
    assert free.start == close(-ends.free_end_length, rel=1e-6)


@pytest.mark.parametrize(
    "posture",
    [
        replace(TURNED, beside=True, unit="inch"),
        pytest.param(replace(TURNED, divided=True), marks=pytest.mark.further),
        Posture((0.0, math.pi, 0.0)),
        Posture((math.pi / 2, 0.0, 0.0), (0.0, 0.09, 0.0)),
    ],
    ids=["inches, beside others", "divided faces", "end for end", "along y, off the origin"],
)
def test_as_programs_write_it(four, tmp_path, posture):
    read = run_cad(write_shaft(tmp_path / "crank.step", four, posture), accuracy=None)
    assert_same(four, read)
    assert len(read.solids) == (4 if posture.beside else 1)
    assert [solid.what == "" for solid in read.solids] == [True] + 3 * [False] * posture.beside
    assert read.unit == {"mm": 1e-3, "inch": 0.0254}[posture.unit]


@pytest.mark.further
def test_splines_are_weighed_by_meshes_of_their_surface(four, tmp_path):
    splines = replace(TURNED, splines=True)
    run = run_cad(write_shaft(tmp_path / "splines.step", four, splines), accuracy=None)
    off = differences(four, run)
    assert off["angle [deg]"] < 0.01
    assert off["place [m]"] < 1e-6
    assert off["mass"] < 1e-5
    assert off["symmetries"] == 0.0
    assert any("spline faces" in remark for remark in run.remarks)


@pytest.mark.further
def test_pieces_of_splines_that_do_not_make_up_the_whole_are_refused(four, tmp_path):
    two = Crankshaft(four.throws[:2], crank_angles_deg=[0.0, 90.0], ends=four.ends)
    path = write_shaft(tmp_path / "splines.step", two, replace(TURNED, splines=True))
    # The halves of its middle journal have their seams at the cranks.
    with pytest.raises(InputError, match=r"with 53\.\d+ % of its volume.* 1 in steps"):
        import_crankshaft(path)


def test_slivers_between_an_oil_hole_and_a_cut_are_healed(four, tmp_path):
    # The halves of a hole meet along lines that miss the cut by 9 nm, as round-off of CAD programs has them.
    two = Crankshaft(four.throws[:2], crank_angles_deg=[0.0, 180.0], ends=four.ends)
    middle, radius, miss = two.starts[1], 0.003, 9e-9

    def drilled(gmsh):
        make_shaft(gmsh, two)
        shaft, halves = gmsh.model.occ.getEntities(3), []
        for turn in (0.5 * math.pi, 1.5 * math.pi):
            axis = (-0.1, 0.0, middle, 0.2, 0.0, 0.0)
            halves.append((3, gmsh.model.occ.addCylinder(*axis, radius, angle=math.pi)))
            around = (0.0, 0.0, middle, 1.0, 0.0, 0.0)
            gmsh.model.occ.rotate(halves[-1:], *around, turn + miss / radius)
        gmsh.option.setNumber("Geometry.OCCUnionUnify", 0)
        gmsh.model.occ.cut(shaft, halves)

    shaft = import_crankshaft(write_parts(tmp_path / "crank.step", drilled))
    assert [change for _, change in shaft.like] == ["equal", "reversed"]
    mesh = shaft.throws[0].meshed(3.0)
    assert mesh.attempts == ()
    assert mesh.solid.volume == close(shaft.throws[0].volume / 2.0, rel=1e-6)


def test_a_whole_crankshaft_is_no_throw(four, tmp_path):
    with pytest.raises(InputError, match=r"of 4 throws.*crankfem cad"):
        import_throw(write_shaft(tmp_path / "crank.step", four))


@pytest.mark.parametrize("name", ["buick-3800", "6chn25-34"])
def test_shipped_engines(tmp_path, name):
    shaft = load_crankshaft(name)
    posture = Posture((0.4, 0.2, 0.1), (0.3, -0.2, 0.1))
    read = run_cad(write_shaft(tmp_path / "crank.step", shaft, posture), accuracy=None)
    assert_same(shaft, read)
    assert len(read.pins) == sum(len(throw.parts.pins) for throw in shaft.throws)


@pytest.mark.parametrize("seed", [2, 13, 24])
def test_random_crankshafts(tmp_path, seed):
    shaft = random_shaft(seed)
    posture = replace(random_posture(seed), divided=False)
    read = run_cad(write_shaft(tmp_path / "crank.step", shaft, posture), accuracy=None)
    assert_same(shaft, read)


def test_divided_fillets_are_compared_as_whole_ones(tmp_path):
    shaft = random_shaft(100)
    assert_same(
        shaft,
        run_cad(write_shaft(tmp_path / "crank.step", shaft, random_posture(100)), accuracy=None),
    )


def test_a_throw_turned_end_for_end_is_of_the_same_kind(tmp_path):
    shaft = random_shaft(2)
    read = import_crankshaft(write_shaft(tmp_path / "crank.step", shaft, TURNED))
    assert read.like == ((1, "equal"), (2, "equal"), (1, "reversed"), (1, "reversed"), (1, "equal"))
    assert read.throws[0] is read.throws[4]
    assert read.throws[2] is read.throws[3]
    assert read.throws[0] is not read.throws[2]


def test_a_throw_that_is_cut_off_is_not_cut_again(dimensions, tmp_path):
    shaft = Crankshaft([CrankThrow(**dimensions)], crank_angles_deg=[0.0])
    read = import_crankshaft(write_shaft(tmp_path / "one.step", shaft, TURNED))
    assert read.ends == (None, None)
    assert read.starts == close((0.0, shaft.throws[0].length), rel=1e-9, abs=1e-9)
    assert read.symmetries == (shaft.throws[0].symmetry,)


def test_compliances_are_those_of_the_throws_written(dimensions, tmp_path):
    throw = CrankThrow(**dimensions)
    thicker = throw.changed(web_thickness=1.1 * throw.web_thickness)
    throws = [throw, thicker, throw]
    shaft = Crankshaft(throws, crank_angles_deg=[0.0, 120.0, 240.0])
    read = run_cad(write_shaft(tmp_path / "crank.step", shaft, TURNED), accuracy=0.04)
    assert list(read.analyses) == [1, 2]
    for place, throw in enumerate(throws):
        analysis, row = analyze_throw(throw, accuracy=0.04), read.throws[place]
        bars = analysis.error_bars()
        off = row.axial_compliance - analysis.axial_compliance()
        assert abs(off) < row.axial_error + bars.axial
        off = row.torsional_compliance - analysis.torsional_compliance()
        assert abs(off) < row.torsional_error + bars.torsional
        assert row.mass == close(mass_properties(analysis.mesh, STEEL.density).mass, rel=1e-6)
    assert max(compliance_differences(shaft, read).values()) < 1.0


def test_cuts_move(file, run):
    moved = import_crankshaft(file, cuts={2: 0.005})
    assert np.diff(moved.starts) == close(
        [run.throws[0].length + 0.005, run.throws[1].length - 0.005, *([run.throws[0].length] * 2)],
        rel=1e-9,
    )
    assert [number for number, _ in moved.like] == [1, 2, 3, 3]
    assert sum(mass.mass for mass in moved.masses(1.0)) == close(
        sum(throw.mass for throw in run.throws) / STEEL.density, rel=1e-9
    )


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"cuts": {6: 0.001}}, "cut: given 6; allowed is 1 to 5, because there are so many cuts."),
        (
            {"cuts": {2: 0.02}},
            "cut: given 2 moved by 20 mm; allowed is -10 mm to 10 mm, because the cut",
        ),
        ({"free_end": "left"}, "free_end: given 'left'; allowed are low, high, because"),
        ({"solid": "rod"}, "solid: given 'rod', which names no solid; allowed is one of '1 "),
    ],
)
def test_wrong_arguments(file, arguments, sentence):
    with pytest.raises(InputError, match="given") as told:
        import_crankshaft(file, **arguments)
    assert str(told.value).startswith(sentence)


def test_the_free_end_may_be_given(file, run):
    ends = [import_crankshaft(file, free_end=end) for end in ("low", "high")]
    assert ends[0].axes[2] == close(-ends[1].axes[2], abs=1e-12)
    same = ends[0] if np.allclose(ends[0].axes, run.shaft.axes) else ends[1]
    other = next(end for end in ends if end is not same)
    assert other.starts == close(same.starts, abs=1e-9)
    assert other.ends[0].masses(1.0).mass == close(same.ends[1].masses(1.0).mass, rel=1e-9)


def plain_shaft(gmsh):
    occ = gmsh.model.occ
    first = (3, occ.addCylinder(0, 0, 0, 0, 0, 0.3, 0.03))
    occ.fuse([first], [(3, occ.addCylinder(0, 0, 0.3, 0, 0, 0.2, 0.04))])


def lantern(gmsh):
    """Two disks with hubs, and four studs between them."""
    occ = gmsh.model.occ
    disks = [(3, occ.addCylinder(0, 0, z, 0, 0, 0.02, 0.1)) for z in (0.0, 0.2)]
    hubs = [(3, occ.addCylinder(0, 0, z, 0, 0, 0.1, 0.03)) for z in (-0.1, 0.22)]
    studs = [
        (3, occ.addCylinder(0.07 * math.cos(a), 0.07 * math.sin(a), 0.02, 0, 0, 0.18, 0.01))
        for a in np.arange(4) * math.pi / 2
    ]
    occ.fuse(disks[:1], [*disks[1:], *hubs, *studs])


def overhung(gmsh):
    """A shaft with two steps, a web, and a pin beyond it."""
    occ = gmsh.model.occ
    shaft = (3, occ.addCylinder(0, 0, 0, 0, 0, 0.2, 0.03))
    rest = [
        (3, occ.addCylinder(0, 0, 0.2, 0, 0, 0.1, 0.035)),
        (3, occ.addBox(-0.04, -0.04, 0.3, 0.08, 0.14, 0.03)),
        (3, occ.addCylinder(0, 0.06, 0.33, 0, 0, 0.05, 0.02)),
    ]
    occ.fuse([shaft], rest)


def facets(gmsh):
    gmsh.model.occ.addBox(0, 0, 0, 0.1, 0.2, 0.3)


def built_up(shaft, gmsh):
    """A crankshaft whose pins and journals are solids of their own."""
    occ = gmsh.model.occ
    make_shaft(gmsh, shaft)
    solids = gmsh.model.getEntities(3)
    places = [
        start + place
        for throw, start in zip(shaft.throws, shaft.starts, strict=False)
        for place in (throw.parts.pins[0].start, throw.parts.pins[0].end)
    ]
    planes = [(2, occ.addDisk(0, 0, z, 1.0, 1.0)) for z in places]
    _, (pieces, *_) = occ.fragment(solids, planes)
    occ.remove([(2, tag) for _, tag in occ.getEntities(2)])
    assert len(pieces) == 2 * len(shaft.throws) + 1


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (partial(make_rod, place=(0, 0, 0), size=0.3), "outer cylinders, none of which is whole"),
        (
            partial(make_camshaft, place=(0, 0, 0), size=0.3),
            "4 eccentrics that hold the shaft within",
        ),
        (plain_shaft, "2 whole outer cylinders on one line, and no crankpin beside it"),
        (lantern, "4 parallel cylinders side by side, as studs are"),
        (overhung, "an overhung crank: 1 cylinder beside the axis, beyond the last main journal"),
        (facets, "6 faces, 6 of them plane, and no outer cylinder"),
    ],
    ids=["rod", "camshaft", "plain shaft", "lantern", "overhung crank", "facets"],
)
def test_other_parts_are_refused_by_what_they_are(tmp_path, build, sentence):
    path = write_parts(tmp_path / "part.step", build, TURNED)
    with pytest.raises(InputError, match="given no crankshaft in one solid") as told:
        import_crankshaft(path)
    assert sentence in str(told.value)


def test_one_of_two_crankshafts(four, tmp_path):
    one = Crankshaft(four.throws[:2], crank_angles_deg=[0.0, 180.0], ends=four.ends)

    def two(gmsh):
        make_shaft(gmsh, one)
        (copied,) = gmsh.model.occ.copy(gmsh.model.getEntities(3))
        gmsh.model.occ.translate([copied], 0.3, 0.0, 0.0)

    path = write_parts(tmp_path / "two.step", two)
    with pytest.raises(InputError, match="given 2 crankshafts, '1 "):
        import_crankshaft(path)
    second = import_crankshaft(path, solid="2")
    assert second.origin == close([0.3, 0.0, 0.0], abs=1e-9)
    assert second.solid.startswith("2 ")


def test_a_crankshaft_of_several_solids(four, tmp_path):
    path = write_parts(tmp_path / "built.step", partial(built_up, four))
    with pytest.raises(InputError, match="a crankshaft built up of") as told:
        import_crankshaft(path)
    assert "unite them in the CAD program" in str(told.value)


def test_the_kinds_of_change_keep_the_pin_in_the_crank_plane():
    draw = np.random.default_rng(3)
    areas, centers = draw.random(7), draw.random((7, 3))
    one = Signature(1.0, 0.0, 1.0, areas, centers, (0.0,))
    assert one.symmetry == "full"
    for change, (across, along) in CHANGES.items():
        moved = centers * [across, 1.0, along] + [0.0, 0.0, 0.5 - 0.5 * along]
        assert one.change_to(replace(one, centers=moved)) == change
    assert one.change_to(replace(one, areas=1.001 * areas)) is None


def test_two_opposite_pins_are_no_mirror_about_the_middle(dimensions, tmp_path):
    pin = FurtherPin(angle=math.pi, web_width=0.3)
    throw = CrankThrow(**dimensions, further_pins=(pin,))
    shaft = Crankshaft([throw, throw], crank_angles_deg=[0.0, 90.0])
    read = import_crankshaft(write_shaft(tmp_path / "two-pins.step", shaft))
    assert throw.symmetry == "half"
    assert read.symmetries == ("half", "half")
    assert [place for place, _ in read.like] == [1, 1]


def test_command(call, file, run, four):
    answer = call("cad", str(file), "--no-fe", "--full", "--throws", "kept")
    assert answer.code == 0, answer.err
    assert "The file's unit of length is mm." in answer.out
    assert "Throws: kept (1 file)" in answer.out
    assert "is the crankshaft: 4 throws, all of one kind, at 0 deg, 180 deg, 180 deg" in answer.out
    assert [line.split()[0] for line in answer.out.splitlines()[-4:]] == ["1", "2", "3", "4"]
    told = call("cad", str(file), "--no-fe", "--json", "--throws", "parts").json()
    assert [throw["angle_deg"] for throw in told["throws"]] == close(
        four.crank_angles_deg, abs=1e-6
    )
    assert {throw["file"].rpartition("/")[2] for throw in told["throws"]} == {"throw-1.step"}
    assert told["units"]["mass"] == "kg"
    # What was written is what `crankfem throw` reads.
    throw = import_throw("parts/throw-1.step")
    assert throw.length == close(four.throws[0].length, rel=1e-9)
    assert throw.pin_axes[0] == close((0.0, four.throws[0].crank_radius), abs=1e-9)
    assert json.loads(json.dumps(told["solids"]))[0]["what"] == ""


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            ("--cut", "3 mm"),
            "--cut: given '3 mm'; allowed is the number of a cut and how far it moves",
        ),
        (("--cut", "2"), "--cut: given '2'; allowed is the number of a cut and how far it moves"),
        (("--cut", "2=3 kg"), "--cut: given"),
        (("--cut", "2=3 mm", "--cut", "2=1 mm"), "--cut: given twice for cut 2; give it once."),
        (("--accuracy", "2"), "accuracy: given 2"),
    ],
)
def test_wrong_options(call, file, options, sentence):
    answer = call("cad", str(file), *options)
    assert (answer.code, answer.out) == (2, "")
    assert f"Error: {sentence}" in answer.err


@pytest.mark.parametrize("there", [False, True])
def test_a_refused_file_leaves_folders_as_they_were(call, tmp_path, there):
    folder = tmp_path / "parts"
    if there:
        folder.mkdir()
    wrong = tmp_path / "wrong.step"
    wrong.write_text("ISO-10303-21;", encoding="ascii")
    assert call("cad", str(wrong), "--throws", str(folder)).code == 2
    assert folder.exists() is there


def test_throws_replace_nothing_that_is_not_theirs(call, file, tmp_path):
    (tmp_path / "mine").mkdir()
    own = tmp_path / "mine" / "throw-1.step"
    own.write_text("my part", encoding="ascii")
    answer = call("cad", str(file), "--no-fe", "--throws", str(tmp_path / "mine"))
    assert answer.code == 2
    assert own.read_text(encoding="ascii") == "my part"


def test_one_throw_between_whole_journals_is_cut_in_their_middles(dimensions, tmp_path):
    throw = CrankThrow(**dimensions)
    half = throw.main_journal_length / 2.0
    ends = ShaftEnds(
        free_end_diameter=throw.main_journal_diameter,
        free_end_length=half,
        flange_diameter=1.3 * throw.main_journal_diameter,
        flange_thickness=half,
    )
    shaft = Crankshaft([throw], crank_angles_deg=[0.0], ends=ends)
    read = import_crankshaft(write_shaft(tmp_path / "one.step", shaft))
    # The left journal is whole, the right one half: each is cut in its middle.
    assert read.starts[1] - read.starts[0] == close(throw.length - half / 2.0, rel=1e-6)
