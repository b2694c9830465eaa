import pickle
import re
from dataclasses import fields, is_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError, MeshError
from fem.analysis import analyze_throw
from fem.material import STEEL
from fem.solver import assemble_stiffness
from fem.superelement import condense
from fem.supports import class_axial_compliances
from fem.symmetry import axial_class, unit_pin_loads
from geometry.equal_pieces import Signature
from geometry.gmsh_session import IsolatedProcess, gmsh_session
from geometry.imported import NODES_PER_FACE, RequestedFaces, import_throw
from geometry.mass import mass_properties
from geometry.mesh import MESHING_STRATEGIES, mesh_throw
from geometry.recognition import recognize
from geometry.shapes import element_volumes
from geometry.solid import (
    BORE,
    FILLET,
    LEFT_END,
    MAIN_JOURNAL,
    PIN,
    RIGHT_END,
    make_solid,
    remove_loose,
)
from geometry.step_file import decode_string, read_step
from geometry.throw import CrankThrow
from refusals import refused

METER = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT($,.METRE.) )"
MILLIMETER = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) )"
CONVERTED = "(CONVERSION_BASED_UNIT('{name}',#900002) LENGTH_UNIT() NAMED_UNIT(#900003))"
CONVERSION = (
    f"#900001={MILLIMETER};\n#900002=LENGTH_MEASURE_WITH_UNIT({{measure}},#900001);\n"
    "#900003=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
)
# Name of the unit: meters of it, its entity, more entities.
UNITS = {
    "meter": (1.0, METER, ""),
    "millimeter": (1e-3, MILLIMETER, ""),
    "centimeter": (1e-2, METER.replace("$", ".CENTI."), ""),
    "inch": (
        0.0254,
        CONVERTED.format(name="INCH"),
        CONVERSION.format(measure="LENGTH_MEASURE(25.4)"),
    ),
    "foot": (0.3048, CONVERTED.format(name="FOOT"), CONVERSION.format(measure="304.8")),
}


def scaled(part, size):
    """A part's lengths in another unit; the kernel's own scaling makes splines of all surfaces."""
    if isinstance(part, float):
        return part * size
    if isinstance(part, tuple):
        return tuple(scaled(item, size) for item in part)
    if is_dataclass(part):
        return replace(part, **{f.name: scaled(getattr(part, f.name), size) for f in fields(part)})
    return part


def step_text(throw, unit="meter", turn=0.0, shift=0.0, build=None):
    """A throw's STEP file as gmsh writes it, in another unit, turned [rad] and shifted [m]."""
    size, entity, more = UNITS[unit]
    with gmsh_session("write") as gmsh:
        occ = gmsh.model.occ
        if build is None:
            make_solid(gmsh, scaled(throw.parts, 1.0 / size), "full")
        else:
            build(gmsh)
        remove_loose(gmsh)
        solids = gmsh.model.getEntities(3)
        occ.rotate(solids, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, turn)
        occ.translate(solids, 0.0, 0.0, shift)
        occ.synchronize()
        gmsh.write("throw.step")
    with open("throw.step", encoding="ascii") as file:
        text = file.read()
    assert MILLIMETER in text
    return text.replace(MILLIMETER, entity).replace("ENDSEC;\nEND-", f"{more}ENDSEC;\nEND-")


def name_faces(text, choose):
    """Write names into a file's faces by their surface: type, numbers of its place, radius."""
    statements = dict(re.findall(r"(#\d+) = (.*?);\n", text, re.DOTALL))
    statements = {number: re.sub(r"\s+", "", body) for number, body in statements.items()}

    def numbers(reference):
        return [float(value) for value in re.findall(r"-?\d[\d.E+-]*", statements[reference][2:])]

    def rename(found):
        surface = statements[found[2]]
        kind = surface.split("(")[0]
        point = np.zeros(3)
        if kind in ("PLANE", "CYLINDRICAL_SURFACE"):
            place = statements[re.findall(r"#\d+", surface)[0]]
            point = np.array(numbers(re.findall(r"#\d+", place)[0]))
        radius = float(surface.rstrip(")").split(",")[-1]) if kind == "CYLINDRICAL_SURFACE" else 0.0
        return f"ADVANCED_FACE('{choose(kind, point, radius)}'{found[1]},{found[2]},"

    return re.sub(r"ADVANCED_FACE\(''(,\s*\([#\d,\s]*\)),\s*(#\d+),", rename, text)


def usual_names(throw, size=1.0, shift=0.0, turn=0.0):
    """Names of the ends and of each pin, 'pin', 'pin 2' ..."""
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    def choose(kind, point, radius):
        x, y, z = point * size
        if kind == "PLANE" and abs(z - shift) < 1e-6:
            return LEFT_END
        if kind == "PLANE" and abs(z - throw.length - shift) < 1e-6:
            return RIGHT_END
        for pin in throw.parts.pins:
            beside = np.hypot(*(rotation @ pin.axis - (x, y)))
            if kind != "PLANE" and beside < 1e-6 and abs(radius * size - pin.radius) < 1e-6:
                return pin.name
        return ""

    return choose


def write(path, text):
    path.write_text(text, encoding="ascii")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("step"))
        yield tmp_path_factory.mktemp("parts")


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions)


@pytest.fixture(scope="module")
def plain(throw, folder):
    """Text without names."""
    return step_text(throw)


@pytest.fixture(scope="module")
def named(throw, plain):
    """Text with the usual names."""
    return name_faces(plain, usual_names(throw))


@pytest.fixture(scope="module")
def imported(named, folder):
    return import_throw(write(folder / "named.step", named))


@pytest.fixture(scope="module")
def mesh(imported):
    return imported.meshed(1.5)


def assert_same_throw(imported, throw, tolerance=1e-6):
    assert imported.volume == close(throw.volume, rel=tolerance)
    assert imported.length == close(throw.length, rel=1e-9)
    assert imported.symmetry == throw.symmetry
    assert imported.filleted == throw.filleted
    journals = imported.cylinders[0], imported.cylinders[-1]
    assert [end.radius for end in journals] == close([throw.main_journal_diameter / 2.0] * 2)
    assert [pin.name for pin in imported.pins] == [pin.name for pin in throw.parts.pins]
    for pin, expected in zip(imported.pins, throw.parts.pins, strict=True):
        assert pin.axis == close(expected.axis, abs=1e-9)
        assert pin.radius == close(expected.radius, rel=1e-9)
        assert (pin.start, pin.end) == close((expected.start, expected.end), abs=1e-9)
    assert imported.pin_axes == tuple(pin.axis for pin in imported.pins)


# --- the text -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("left end", "left end"),
        ("it''s", "it's"),
        (r"\X2\00C40416\X0\x", "ÄЖx"),
        (r"\X4\0001F600\X0\x", "\U0001f600x"),
        (r"a\X\E4b", "aäb"),
        (r"\S\dx", "äx"),
        (r"\PE\\S\6", "Ж"),
        (r"C:\\parts", r"C:\parts"),
    ],
)
def test_strings_are_decoded(written, meant):
    assert decode_string(written) == meant


@pytest.mark.parametrize("unit", UNITS)
def test_units_and_places_of_named_faces(throw, folder, unit):
    size = UNITS[unit][0]
    text = name_faces(step_text(throw, unit), usual_names(throw, size))
    step = read_step(text.encode(), "x.step")
    assert step.unit == close(size, rel=1e-12)
    faces = {face.name: face for face in step.faces}
    assert faces.keys() == {LEFT_END, RIGHT_END, PIN}
    pin = faces[PIN]
    assert pin.kind == "CYLINDRICAL_SURFACE"
    assert pin.point[:2] == close((0.0, throw.crank_radius), abs=1e-9)
    assert pin.radius == close(throw.pin_diameter / 2.0, rel=1e-9)
    assert np.abs(pin.axis) == close([0.0, 0.0, 1.0], abs=1e-12)
    assert faces[RIGHT_END].kind == "PLANE"
    assert faces[RIGHT_END].point[2] == close(throw.length, rel=1e-9)
    assert len(pin.corners) == 2
    beside = np.array(pin.corners)[:, :2] - (0.0, throw.crank_radius)
    assert np.hypot(*beside.T) == close(throw.pin_diameter / 2.0, rel=1e-9)


def test_breaks_comments_spaces_and_escapes_do_not_matter(named):
    odd = named.replace(
        f"ADVANCED_FACE('{PIN}'",
        "/* a 'pin'; */ ADVANCED_FACE\r\n( 'the\r\n \\X2\\00C4\\X0\\ ''pin'';'",
    )
    odd = odd.replace("CYLINDRICAL_SURFACE('',", "CYLINDRICAL_SURFACE ( 'NONE' , /* */ ")
    odd = odd.replace("ADVANCED_FACE(''", "ADVANCED_FACE ( 'NONE' ")
    faces = {face.name: face for face in read_step(odd.encode(), "x.step").faces}
    assert faces.keys() == {LEFT_END, RIGHT_END, "the Ä 'pin';"}
    plain_faces = {face.name: face for face in read_step(named.encode(), "x.step").faces}
    assert faces["the Ä 'pin';"] == replace(plain_faces[PIN], name="the Ä 'pin';")


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "solid" + text,
        lambda text: text.replace("MANIFOLD_SOLID_BREP", "SHELL_BASED_SURFACE_MODEL"),
        lambda text: text.replace("SI_UNIT($,.METRE.)", "SI_UNIT($,.GRAM.)"),
        lambda text: text.replace("LENGTH_UNIT()", ""),
        lambda text: re.sub(r"#\d+ = CARTESIAN_POINT[^;]*;", "", text),
        lambda text: text.replace(METER, CONVERTED.format(name="ELL")).replace(
            "DATA;", f"DATA;#900001={CONVERTED.format(name='INCH')};"
            "#900002=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(45.),#900001);", 1
        ),
        # Units that differ within a file.
        lambda text: text.replace("DATA;", f"DATA;#900000={MILLIMETER};"
            "#900001=(GLOBAL_UNIT_ASSIGNED_CONTEXT((#900000)));", 1),
    ],
)  # fmt: skip
def test_files_that_cannot_be_used(named, change):
    with refused("x.step"):
        read_step(change(named).encode(), "x.step")


# --- import -------------------------------------------------------------------------------------


def test_without_names_the_same_is_found_by_shape(throw, plain, imported, folder):
    found = import_throw(write(folder / "plain.step", plain))
    assert_same_throw(found, throw)
    assert len(found.remarks) == 3
    assert "diameter 180 mm at 170 mm" in found.remarks[-1]
    kept = {"path": "", "digest": "", "remarks": ()}
    assert replace(found, **kept) == replace(imported, **kept)


@pytest.mark.parametrize("names", [{"pins": ["crank"]}, {"left_end": "free"}])
def test_names_in_a_file_without_any_are_refused(plain, folder, names):
    with pytest.raises(InputError, match="no face of it has a name"):
        import_throw(write(folder / "plain.step", plain), **names)


def test_none_finds_by_shape_although_there_are_names(throw, plain, folder):
    auto = name_faces(plain, lambda *_: "Face")
    found = import_throw(write(folder / "auto.step", auto), None, None, None)
    assert_same_throw(found, throw)
    assert len(found.remarks) == 3


def test_names_may_be_others_and_written_otherwise(throw, named, folder):
    text = named.replace("'left end'", "'FREE_END'").replace("'pin'", "'Crank-Pin'")
    path = write(folder / "others.step", text)
    assert_same_throw(import_throw(path, "free end", "Right End", "crank pin"), throw)


def test_what_is_imported_travels_and_is_hashable(imported):
    assert pickle.loads(pickle.dumps(imported)) == imported
    assert hash(imported) == hash(replace(imported))


@pytest.mark.slow
@pytest.mark.parametrize("with_names", [True, False])
def test_a_turned_and_shifted_part_is_brought_back(throw, folder, with_names):
    text = step_text(throw, turn=0.7, shift=-1.25)
    if with_names:
        text = name_faces(text, usual_names(throw, shift=-1.25, turn=0.7))
    imported = import_throw(write(folder / f"turned{with_names}.step", text))
    assert_same_throw(imported, throw)
    assert imported.turned == close(-0.7, abs=1e-9)
    assert imported.shifted == close(1.25, abs=1e-9)
    assert "-40.107 deg" in imported.remarks[-1]
    mesh = imported.meshed(2.0)
    pin = mesh.points[np.unique(mesh.surfaces[PIN])]
    assert np.hypot(pin[:, 0], pin[:, 1] - throw.crank_radius) == close(0.09, rel=1e-9)
    masses = mass_properties(mesh, 1.0)
    assert masses.mass == close(throw.volume, rel=1e-6)
    assert masses.center[[0, 2]] == close([0.0, throw.length / 2.0], abs=1e-9)


BORED = {
    "main_journal_bore": 0.08,
    "pin_bore": 0.06,
    "pin_bore_offset": 0.01,
    "main_journal_bore_offset": -0.005,
}


def test_a_larger_finely_meshed_surface_takes_more_unknowns(imported):
    zone = replace(imported.plan.zones[0], size=0.99 * imported.plan.bulk)
    counts = []
    for area in (0.1, 0.2):
        plan = replace(imported.plan, zones=(replace(zone, area=area * imported.area),))
        counts.append(replace(imported, plan=plan).expected_unknowns(1.0, "full"))
    # Almost as coarse as all else, it takes as many a square meter, within the layers beside it.
    faces = 0.1 * imported.area / zone.size**2
    assert counts[1] - counts[0] == close(3.0 * NODES_PER_FACE * faces, rel=0.1)


@pytest.fixture(scope="module")
def bored(dimensions):
    return CrankThrow(**dimensions, **BORED)


@pytest.mark.slow
@pytest.mark.parametrize("with_names", [True, False])
def test_bores_are_not_taken_for_pins_or_journals(bored, folder, with_names):
    text = step_text(bored)
    if with_names:
        text = name_faces(text, usual_names(bored))
    imported = import_throw(write(folder / f"bored{with_names}.step", text))
    assert_same_throw(imported, bored)
    assert [part.bore_radius for part in imported.cylinders] == close([0.04, 0.03, 0.04])
    mesh = imported.meshed(2.0, "full")
    assert mesh.solid.volume == close(bored.volume, rel=1e-6)
    assert element_volumes(mesh.points, mesh.elements).sum() == close(bored.volume, 1e-3)
    bore = mesh.points[np.unique(mesh.surfaces[BORE])]
    off_pin = np.hypot(bore[:, 0], bore[:, 1] - 0.18)
    off_journal = np.hypot(bore[:, 0], bore[:, 1] + 0.005)
    assert np.minimum(np.abs(off_pin - 0.03), np.abs(off_journal - 0.04)).max() < 1e-6


@pytest.fixture(scope="module")
def two_pins(dimensions):
    return CrankThrow(
        **{**dimensions, "fillet_radius": 0.0},
        further_pins=[{"angle": 2.0 * np.pi / 3.0, "diameter": 0.16, "length": 0.1}],
    )


@pytest.mark.slow
def test_two_pins_in_any_order(two_pins, folder):
    path = write(folder / "two.step", name_faces(step_text(two_pins), usual_names(two_pins)))
    imported = import_throw(path, pins=("pin 2", "pin"))
    assert_same_throw(imported, two_pins)
    assert not imported.filleted
    assert_same_throw(import_throw(path, pins=None), two_pins)
    mesh = imported.meshed(2.0)
    assert mesh.pins == ("pin", "pin 2")
    second = mesh.points[np.unique(mesh.surfaces["pin 2"])]
    assert np.hypot(*(second[:, :2] - two_pins.parts.pins[1].axis).T) == close(0.08, rel=1e-9)


@pytest.mark.slow
def test_a_pin_in_two_faces_of_which_one_is_named(throw, folder):
    def build(gmsh):
        """Two halves, put together without uniting their faces."""
        gmsh.option.setNumber("Geometry.OCCUnionUnify", 0)
        half = make_solid(gmsh, throw.parts, "half")
        other = gmsh.model.occ.copy([half])
        middle = throw.length / 2.0
        gmsh.model.occ.rotate(other, 0.0, 0.0, middle, 0.0, 1.0, 0.0, np.pi)
        gmsh.model.occ.fuse([half], other)

    once = iter([PIN])
    usual = usual_names(throw)

    def choose(kind, point, radius):
        name = usual(kind, point, radius)
        return next(once, "") if name == PIN else name

    text = name_faces(step_text(throw, build=build), choose)
    assert text.count(f"'{PIN}'") == 1
    assert text.count(f"'{LEFT_END}'") == 2
    imported = import_throw(write(folder / "halves.step", text))
    assert_same_throw(imported, throw)
    surfaces = dict(imported.surfaces)
    assert len(surfaces[PIN]) == len(surfaces[LEFT_END]) == 2
    assert len(surfaces[MAIN_JOURNAL]) == 4


@pytest.mark.slow
def test_an_oil_hole_disturbs_nothing(throw, folder):
    def build(gmsh):
        occ = gmsh.model.occ
        solid = make_solid(gmsh, throw.parts, "full")
        occ.cut([solid], [(3, occ.addCylinder(0.0, -0.2, 0.02, 0.0, 0.6, 0.24, 0.005))])

    imported = import_throw(write(folder / "oil.step", step_text(throw, build=build)))
    assert imported.filleted
    assert imported.pins[0].radius == close(throw.pin_diameter / 2.0, rel=1e-9)
    assert len(imported.fillets) == 4
    assert imported.corners == ()
    assert len(dict(imported.surfaces)[FILLET]) == 4
    assert BORE not in dict(imported.surfaces)
    mesh = imported.meshed(1.5, "full")
    assert mesh.attempts == ()
    assert element_volumes(mesh.points, mesh.elements).sum() == close(imported.volume, rel=1e-3)


def rename(text, old, new):
    assert f"'{old}'" in text
    return text.replace(f"ADVANCED_FACE('{old}'", f"ADVANCED_FACE('{new}'")


@pytest.mark.parametrize(
    ("change", "arguments", "field"),
    [
        (lambda t: t, {"left_end": "free end"}, "left_end"),
        (lambda t: t, {"pins": ("pin", "pin 2")}, "pins"),
        (lambda t: t, {"pins": ()}, "pins"),
        (lambda t: t, {"pins": ("pin", "PIN")}, "pins"),
        (lambda t: t, {"left_end": "pin"}, "left_end"),
        (lambda t: t, {"pins": ("left end",)}, "pins"),
        (lambda t: t, {"left_end": "right end", "right_end": "left end"}, "left_end"),
        (
            lambda t: rename(t, LEFT_END, PIN + " side"),
            {"left_end": None, "right_end": "pin side"},
            "right_end",
        ),
        (lambda t: t.replace(METER, MILLIMETER), {}, "refused.step"),
        (lambda t: t.replace(METER, METER.replace("$", ".KILO.")), {}, "refused.step"),
    ],
)
def test_imports_that_cannot_be(named, folder, change, arguments, field):
    path = write(folder / "refused.step", change(named))
    with refused(field):
        import_throw(path, **arguments)


@pytest.mark.parametrize(
    ("field", "kind", "where"),
    [
        ("pins", "CYLINDRICAL_SURFACE", lambda p, r: np.hypot(*p[:2]) < 1e-6 and r < 0.12),
        ("left_end", "PLANE", lambda p, _: abs(abs(p[0]) - 0.15) < 1e-6),
        ("left_end", "PLANE", lambda p, _: abs(p[2] - 0.06) < 1e-6 and abs(p[0]) < 0.1),
    ],
)
def test_named_faces_in_wrong_places(plain, folder, field, kind, where):
    def choose(own, point, radius):
        return PIN if own == kind and where(point, radius) else "other"

    path = write(folder / "wrong.step", name_faces(plain, choose))
    arguments = dict.fromkeys(("left_end", "right_end", "pins"))
    arguments[field] = (PIN,) if field == "pins" else PIN
    with refused(field):
        import_throw(path, **arguments)


def test_one_name_for_two_pins(two_pins, folder):
    usual = usual_names(two_pins)
    text = name_faces(step_text(two_pins), lambda *at: usual(*at).removesuffix(" 2"))
    with refused("pins"):
        import_throw(write(folder / "twice.step", text))


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda occ: (occ.addBox(0, 0, 0, 1, 1, 1), occ.addBox(3, 0, 0, 1, 1, 1)), "odd.step"),
        (lambda occ: occ.addBox(0, 0, 0, 1, 1, 1), "left_end"),
        (lambda occ: occ.addCylinder(0, 0, 0, 0, 0, 1, 0.1), "pins"),
        (lambda occ: occ.addSphere(0, 0, 0, 1), "left_end"),
    ],
)
def test_parts_that_are_no_throws(folder, build, field):
    text = step_text(None, build=lambda gmsh: build(gmsh.model.occ))
    with refused(field):
        import_throw(write(folder / "odd.step", text))


def test_a_pin_across_the_shaft_is_refused(folder):
    def build(gmsh):
        occ = gmsh.model.occ
        shaft, pin = (occ.addCylinder(0, 0, *way, 0.1) for way in ((0, 0, 0, 1), (0.5, 0, 0.5, 0)))
        occ.fuse([(3, shaft)], [(3, pin)])

    count = iter(range(100))
    text = step_text(None, build=build)
    text = re.sub(r"ADVANCED_FACE\(''", lambda _: f"ADVANCED_FACE('f{next(count)}'", text)
    faces = read_step(text.encode(), "x.step").faces
    across = next(f for f in faces if f.kind == "CYLINDRICAL_SURFACE" and abs(f.axis[2]) < 0.5)
    with refused("pins"):
        import_throw(write(folder / "odd.step", rename(text, across.name, PIN)), None, None)


def test_an_inclined_shaft_is_refused(throw, folder):
    def build(gmsh):
        solid = make_solid(gmsh, throw.parts, "full")
        gmsh.model.occ.rotate([solid], 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1e-3)

    path = write(folder / "inclined.step", step_text(throw, build=build))
    with refused("left_end"):
        import_throw(path)


def test_a_file_that_is_not_there(folder):
    for path in (folder / "missing.step", folder):
        with pytest.raises(InputError, match=r"does not exist|is a folder"):
            import_throw(path)


@pytest.mark.slow
def test_a_file_that_takes_the_process_down(imported):
    class Lost(IsolatedProcess):
        def call(self, *_, **__):
            return super().call("os:abort", time_limit=60.0)

    with pytest.raises(InputError, match="the process that called gmsh was ended by SIGABRT"):
        import_throw(imported.path, process=Lost())


# --- mesh ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_failed_ways_are_passed_over_and_recorded(imported):
    mesh = imported.meshed(2.5, "auto", None, ("as planned: it took too long",))
    assert mesh.attempts == ("as planned: it took too long",)
    assert mesh.size_factor == close(2.5 * MESHING_STRATEGIES[1].share)
    with pytest.raises(MeshError, match="6 ways of meshing the throw failed"):
        imported.meshed(2.5, "auto", None, ("no",) * len(MESHING_STRATEGIES))


def test_too_fine_a_mesh_is_refused(imported):
    with refused("size_factor"):
        imported.meshed(0.05)


def test_a_changed_file_is_refused(named, folder):
    path = write(folder / "changed.step", named)
    imported = import_throw(path)
    write(path, named.replace("Author", "Other"))
    with pytest.raises(InputError, match="changed"):
        imported.meshed()
    path.unlink()
    with pytest.raises(InputError, match="does not exist"):
        imported.meshed()


@pytest.mark.slow
def test_surfaces_that_are_elsewhere_are_noticed(imported):
    names = dict(imported.surfaces)
    names |= {LEFT_END: names[RIGHT_END], RIGHT_END: names[LEFT_END]}
    wrong = replace(imported, surfaces=tuple(names.items()))
    with pytest.raises(MeshError, match="'left end' of the file is not where it was"):
        wrong.meshed(3.0, "auto", None, ("no",) * (len(MESHING_STRATEGIES) - 1))


# --- analysis -----------------------------------------------------------------------------------


def axial_compliance(mesh):
    matrix = assemble_stiffness(mesh.points, mesh.elements, STEEL)
    part = condense(mesh, matrix, unit_pin_loads(mesh), axial_class(mesh.part))
    return SimpleNamespace(
        value=class_axial_compliances(part, "pinned")[0], factor=mesh.size_factor
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "part"), [({}, "quarter"), ({"left_web": {"thickness": 0.07}}, "half")]
)
def test_the_part_that_is_meshed_stands_for_the_whole(dimensions, folder, change, part):
    throw = CrankThrow(**dimensions | change)
    imported = import_throw(write(folder / f"{part}.step", step_text(throw, turn=0.3)))
    assert imported.symmetry == part
    results = [
        analyze_throw(one, accuracy=0.05) for one in (imported, replace(imported, symmetry="full"))
    ]
    assert [result.mesh.part for result in results] == [part, "full"]
    (cut, expected) = (result.masses for result in results)
    assert cut.inertia == close(expected.inertia, abs=1e-7 * expected.inertia.max())
    assert cut.center == close(expected.center, abs=1e-7)
    bars = [result.error_bars() for result in results]
    first, second = results
    axial, torsional = sum(bar.axial for bar in bars), sum(bar.torsional for bar in bars)
    assert first.axial_compliance() == close(second.axial_compliance(), abs=axial)
    assert first.torsional_compliance() == close(second.torsional_compliance(), abs=torsional)
    widths = [
        [2.0 * web.outline.pieces[1].start[0] for web in imported.parts_by(result.mesh).webs]
        for result in results
    ]
    assert widths[0] == close(widths[1], rel=1e-2)


def test_an_apparent_symmetry_is_not_used_and_told(dimensions, folder, monkeypatch):
    throw = CrankThrow(**dimensions, left_web={"thickness": 0.07})
    path = write(folder / "apparent.step", step_text(throw))
    monkeypatch.setattr(Signature, "symmetry", "quarter")
    imported = recognize(str(path), "", RequestedFaces(None, None, None))
    assert imported.symmetry == "full"
    assert imported.remarks[-1].startswith(
        "The throw seems to be symmetric but is meshed whole: a quarter of the throw, mirrored, differs"
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "order", "factors"),
    [
        ({}, 1.6, (1.5, 1.0)),
        pytest.param({"fillet_radius": 0.0}, 1.0, (1.5, 1.0), marks=pytest.mark.further),
        pytest.param(BORED, 1.6, (1.2, 0.8), marks=pytest.mark.further),
    ],
)
def test_the_compliance_is_that_of_the_throw(dimensions, folder, change, order, factors):
    """Both converge to one value: their errors, estimated from two meshes each, cover the rest.

    With bores the noise of coarse meshes is as large as what they differ by.
    """
    throw = CrankThrow(**{**dimensions, **change})
    imported = import_throw(write(folder / "analyzed.step", step_text(throw)))
    results = []
    for make in (lambda f: imported.meshed(f), lambda f: mesh_throw(throw, f)):
        coarse, fine = (axial_compliance(make(factor)) for factor in factors)
        ratio = coarse.factor / fine.factor
        results.append((fine.value, (fine.value - coarse.value) / (ratio**order - 1.0)))
    (ours, our_error), (theirs, their_error) = results
    assert 0.0 < our_error < 0.025 * ours
    # Meshed to the same sizes, the two differ by less than their distance from the limit.
    nearer = 0.5 * max(our_error, their_error)
    assert ours == close(theirs, abs=nearer)
    assert ours + our_error == close(theirs + their_error, abs=nearer)
