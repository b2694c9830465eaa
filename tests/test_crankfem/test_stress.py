"""What is printed, recorded and pictured of the stresses at fillets and oil holes."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from comparing import close
from crankbase.errors import InputError, MissingLibraryError
from crankfem.analyses.throw.pictures import stress_picture, stress_rendering
from crankfem.analyses.throw.pictures.stress_picture import (
    largest_peak,
    picture_arrays,
    picture_stresses,
)
from crankfem.analyses.throw.stress import StressResults, _down, _up, stress_results
from crankfem.cli.app import app
from crankfem.cli.console import print_parts
from fem import fillet_stress
from fem.fillet_peaks import FilletMeshing, ReadingQuality, unit_loads
from fem.fillet_stress import fillet_stresses, nominal_hole_stress
from fem.symmetry import radial_directions
from geometry.mesh import mesh_throw
from geometry.throw import CrankThrow
from stand_ins import COARSE_STRESSES

THROWS = {
    "quarter": {},
    "half": {"right_web": {"thickness": 0.055}, "pin_fillet_radius": 0.0},
    "full": {"further_pins": [{"angle": math.radians(30.0), "web_thickness": 0.0}]},
}
# A throw without symmetry takes seconds.
PARTS = ["quarter", "half", pytest.param("full", marks=pytest.mark.slow)]


class Made(dict):
    """What a function makes of each part of a throw, made when first asked for."""

    def __init__(self, make):
        self._make = make

    def __missing__(self, part):
        self[part] = self._make(part)
        return self[part]


def coarse_stresses(throw, **constants):
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (COARSE_STRESSES | constants).items():
            patch.setattr(fillet_stress, name, value)
        return fillet_stresses(throw, accuracy=0.2, mesher=mesh_throw)


@pytest.fixture(scope="module")
def found(dimensions):
    return Made(lambda part: coarse_stresses(CrankThrow(**dimensions, **THROWS[part])))


@pytest.fixture(scope="module")
def arrays(found):
    return Made(lambda part: picture_arrays(found[part]))


# ---------------------------------------------------------------------------------- record and tables


@pytest.mark.further
@pytest.mark.parametrize("part", PARTS)
def test_record_is_strict_json_with_every_load_and_fillet(found, part):
    record = stress_results(found[part]).to_record()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    kinds = [load["kind"] for load in record["loads"]]
    pins = 2 if part == "full" else 1
    assert kinds == ["axial", "torsion", "bending", "cross bending", *["radial"] * pins]
    fillets = {"quarter": 4, "half": 2, "full": 4}[part]
    assert all(len(load["fillets"]) == fillets for load in record["loads"])
    for load in record["loads"]:
        assert load["stress_unit"] == {"N": "Pa/N", "N m": "Pa/(N m)"}[load["unit"]]
        for peak in load["fillets"]:
            assert peak["factor"] == close(abs(peak["principal"]) / peak["nominal"])
    assert record["solved_part"] == part
    assert record["end_sections"] == "rigid"
    assert record["error_estimate"] == found[part].error_estimate


def printed(stresses, capsys):
    results = stress_results(stresses)
    print_parts([*results.tables(), *results.sentences()])
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_what_misses_a_limit_of_the_rule_by_little_does_not_look_as_if_it_met_it():
    assert (_up(0.2501, 2), _up(0.25, 2), _down(5.96, 1), _down(6.0, 1)) == (
        "0.26",
        "0.25",
        "5.9",
        "6.0",
    )
    meshing = FilletMeshing("pin", 0.003, 0.2501, (1.0, 2.0, 3.01), 5.96)
    load = SimpleNamespace(
        kind="torsion", fillets=[SimpleNamespace(quality=ReadingQuality(0.01, 0.0501))]
    )
    mesh, stresses = StressResults.rule_sentences(SimpleNamespace(meshings=[meshing], loads=[load]))
    assert all(one in mesh for one in ("0.26 ", "0.25", "1.0, 2.0, 3.1", "5.9 elements"))
    assert "5.1 %" in stresses


@pytest.mark.slow
def test_what_the_rule_asks_of_mesh_and_stresses_is_told(found, capsys):
    stresses = replace(found["quarter"], mesh="m53")
    text = printed(stresses, capsys)
    size = max(meshing.size_share for meshing in stresses.meshings)
    assert f"{_up(size, 2)} of" in text
    read = [
        peak.quality
        for peak in stresses.peaks
        if peak.load.kind in ("torsion", "bending", "radial")
    ]
    assert not stresses.rule_met
    spread = max(quality.spread for quality in read)
    assert f"{_up(100.0 * spread, 1)} % of" in text
    for load in stresses.loaded.loads:
        for peak in stresses.under(load):
            factors = {"torsion": peak.shear_factor, "axial": None, "cross bending": None}
            assert peak.rule_factor == factors.get(load.kind, peak.von_mises_factor)
            # Of two principal stresses and a free surface, half the von Mises stress at least.
            assert 0.5 <= peak.shear / peak.von_mises <= 1.0 / math.sqrt(3.0) + 1e-9
    assert "Appendix III" not in printed(found["quarter"], capsys)


@pytest.mark.slow
def test_sharp_corners_get_no_number(found, capsys):
    text = printed(found["half"], capsys)
    assert text.count("left journal") == text.count("right journal") == 5
    assert "pin, left web; pin, right web: " in text


@pytest.mark.slow
def test_halves_of_a_split_pin_meet_at_a_sharp_corner(found, capsys):
    text = printed(found["full"], capsys)
    assert "pin and pin 2" in text
    assert "-x" not in text


@pytest.mark.slow
def test_accuracy_not_met_is_said(found, capsys):
    stresses = replace(found["half"], accuracy=0.02)
    assert not stresses.accuracy_met
    text = printed(stresses, capsys)
    assert f" to {100.0 * stresses.error_estimate:.2g} %, not the 2 % requested." in text


# ------------------------------------------------------------------------------------------- command


def command(*arguments):
    found = CliRunner().invoke(app, ["stress", "6chn25-34", *map(str, arguments)])
    if isinstance(found.exception, InputError):
        raise found.exception
    assert found.exit_code == 0, found.output
    return found.stdout


@pytest.fixture
def computed(found, monkeypatch):
    """Let the command find its stresses done; note what it asked for."""
    asked = []

    def done(*arguments, **options):
        asked.append((arguments, options))
        return found["quarter"]

    monkeypatch.setattr(fillet_stress, "fillet_stresses", done)
    return asked


@pytest.mark.slow
def test_command_prints_json_and_nothing_else(computed):
    record = json.loads(command("--accuracy", 0.1, "--end-sections", "averaged", "--json"))
    assert record["pictures"] == []
    (throw, _, accuracy), options = computed[0]
    assert (throw.crank_radius, accuracy) == (0.17, 0.1)
    assert options == {"end_sections": "averaged", "mesh": "adaptive"}


@pytest.mark.slow
def test_command_writes_pictures(computed, monkeypatch, tmp_path):
    monkeypatch.setattr(
        stress_picture, "picture_stresses", lambda _, folder: (folder / "stress-axial.png",)
    )
    said = command("--pictures", tmp_path / "made")
    assert f"{tmp_path / 'made' / 'stress-axial.png'} written." in said.replace("\n", "")


@pytest.mark.slow
def test_command_refuses_a_folder_that_cannot_be_made(computed, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="a file of that name exists"):
        command("--pictures", tmp_path / "file" / "made")
    assert not computed


# ------------------------------------------------------------------------------------------ pictures


@pytest.mark.slow
@pytest.mark.parametrize("part", PARTS)
def test_pictures_show_the_stresses_of_the_tables(arrays, found, part):
    drawn = arrays[part]
    for number, load in enumerate(found[part].loaded.loads):
        peaks = found[part].under(load)
        peak = largest_peak(peaks)
        assert peak.von_mises == close(max(one.von_mises for one in peaks))
        assert part != "quarter" or any(peak is one for one in peaks[:2])
        assert drawn["largest"][number] == close(peak.von_mises / 1e3)
        distance = np.linalg.norm(drawn["points"] - peak.von_mises_place, axis=1)
        shown = drawn["stress"][number][distance.argmin()]
        assert distance.min() < 1e-12
        assert shown == close(peak.von_mises / 1e3)
        assert f"{peak.von_mises / 1e3:.3g} MPa ({peak.fillet.name}; " in drawn["remarks"][number]
        assert drawn["titles"][number].endswith(f": 1 k{load.unit}, ends pinned")
        assert len(drawn["places"][number]) == 1  # no oil holes
        assert len(drawn["places"][number][0]) == {"quarter": 4, "half": 2, "full": 1}[part]


@pytest.mark.slow
def test_a_mark_is_shown_from_where_it_is_seen(arrays):
    drawn = arrays["quarter"]
    solid = stress_rendering._Solid.of("throw", stress_rendering.OUTSIDE, drawn, drawn["facets"])
    radius, length = 0.11, 0.395
    on_left_end, on_right_end = np.array([0.0, 0.05, 0.0]), np.array([0.0, 0.05, length])
    inside = np.array([0.0, 0.0, 0.1])
    eye, place = solid.best_eye(np.array([inside, on_right_end, on_left_end]))
    assert np.array_equal(place, on_left_end)
    assert np.array_equal(eye, stress_rendering.OUTSIDE[0])
    eye, place = solid.best_eye(on_right_end[None])
    assert np.array_equal(place, on_right_end)
    assert eye[2] > 0.0
    # A place on the journal that no eye at -x sees.
    eye, place = solid.best_eye(np.array([[radius, 0.0, 0.03]]))
    assert place is None
    assert np.array_equal(eye, stress_rendering.OUTSIDE[0])


@pytest.mark.slow
def test_pictures_that_cannot_be_made_say_why(found, monkeypatch, tmp_path):
    class Failing:
        def __init__(self, *_):
            pass

        def wait(self):
            raise MissingLibraryError("no library")

    monkeypatch.setattr(stress_picture, "OffscreenProcess", Failing)
    with pytest.raises(MissingLibraryError, match="no library"):
        picture_stresses(found["quarter"], tmp_path / "made")
    assert not (tmp_path / "made").exists()


@pytest.mark.slow
def test_folder_that_cannot_be_written(found, monkeypatch, tmp_path):
    class Made:
        def __init__(self, _, target, arrays):
            for name in arrays["files"]:
                (target / str(name)).write_bytes(b"picture")

        def wait(self):
            pass

    monkeypatch.setattr(stress_picture, "OffscreenProcess", Made)
    files = picture_stresses(found["quarter"], tmp_path / "made")
    assert [file.read_bytes() for file in files] == [b"picture"] * 5
    in_the_way = tmp_path / "file"
    in_the_way.write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        picture_stresses(found["quarter"], in_the_way)


HOLE = {"part": "pin", "diameter": 0.03}
IN_JOURNAL = {"part": "right main journal", "diameter": 0.02, "position": -0.025, "through": False}


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions, oil_holes=(HOLE,))


@pytest.fixture(scope="module")
def hole_found(throw):
    return coarse_stresses(throw, FINE=4.0, MOST_MESHES=3)


def test_nominal_stresses_are_those_of_pin_and_journal_without_the_hole(throw):
    throw = throw.changed(oil_holes=(HOLE, IN_JOURNAL))
    loads = unit_loads(radial_directions(throw))
    pin, opposite, journal = (o for hole in throw.parts.drillings for o in hole.exits)
    length, thickness = throw.length, math.pi / 32.0
    for outlet, diameter, place in (
        (pin, throw.pin_diameter, 0.5 * length),
        (opposite, throw.pin_diameter, 0.5 * length),
        (journal, throw.main_journal_diameter, length - 0.025),
    ):
        modulus = thickness * diameter**3
        at_pin = outlet is not journal
        expected = {
            "axial": throw.crank_radius / modulus if at_pin else 4.0 / math.pi / diameter**2,
            "torsion": 0.5 / modulus,
            "bending": 1.0 / modulus,
            "cross bending": 1.0 / modulus,
            "radial": 0.5 * (length - place) / modulus,
        }
        nominal = {load.kind: nominal_hole_stress(throw.parts, outlet, load) for load in loads}
        assert nominal == {kind: close(value, rel=1e-12) for kind, value in expected.items()}


@pytest.mark.further
def test_factors_at_exits(hole_found, throw):
    assert throw.symmetry == "quarter"
    names = ["pin, oil hole 1 at 0 deg", "pin, oil hole 1 at 180 deg"]
    assert len(hole_found.hole_peaks) == len(hole_found.loaded.loads) * len(names)
    by_kind = {}
    for load in hole_found.loaded.loads:
        peaks = hole_found.at_oil_holes(load)
        assert [peak.name for peak in peaks] == names
        for peak in peaks:
            places = np.array([peak.principal_place, peak.von_mises_place])
            assert peak.outlet.holds(places).all()
            assert peak.error_estimate <= 0.2
        by_kind[load.kind] = [peak.factor for peak in peaks]
    # About what plates and bars have: 4 in torsion, 3 in bending where the hole lies in its plane.
    assert all(3.5 < factor < 4.8 for factor in by_kind["torsion"])
    assert all(2.2 < factor < 4.0 for factor in by_kind["bending"])
    assert all(factor < 0.7 for factor in by_kind["cross bending"])
    assert hole_found.error_estimate == max(
        p.error_estimate for p in (*hole_found.peaks, *hole_found.hole_peaks)
    )


@pytest.mark.slow
def test_records_tables_and_pictures_have_them_beside_the_fillets(hole_found):
    results = stress_results(hole_found)
    record = results.to_record()
    assert record["dimensions"]["oil_holes"][0]["diameter"] == 0.03
    own = record["loads"][1]["oil_holes"]
    assert [(one["diameter"], one["exit_radius"]) for one in own] == [(0.03, 0.0)] * 2
    assert own[0]["factor"] == hole_found.at_oil_holes(hole_found.loaded.loads[1])[0].factor
    table = results.tables()[1]
    assert [row[0] for row in table.rows][-1] == "pin, oil hole 1 at 180 deg"
    drawn = picture_arrays(hole_found)
    assert drawn["places"].shape == (
        5,
        2,
        4,
        3,
    )  # a fillet and a hole, in each image of the quarter
    for number, load in enumerate(hole_found.loaded.loads):
        hole = max(hole_found.at_oil_holes(load), key=lambda peak: peak.von_mises)
        _, text = drawn["remarks"][number].split("\n")
        assert f"{hole.von_mises / 1e3:.3g} MPa ({hole.name}; " in text
        largest = max(peak.von_mises for peak in (*hole_found.under(load), hole))
        assert drawn["largest"][number] == close(largest / 1e3)
        # On the rim, right above where the stress is.
        rim = drawn["places"][number, 1, 0]
        assert math.hypot(rim[0], rim[1] - 0.17) == close(0.09)
        assert rim[2] == close(hole.von_mises_place[2])
    # Without holes the left fillets of two say all.
    loads = tuple(replace(load, oil_holes=()) for load in results.loads)
    assert len(replace(results, loads=loads).tables()[1].rows) == 2
    frame = hole_found.to_pandas()
    assert len(frame) == len(hole_found.peaks) + len(hole_found.hole_peaks)
    assert frame["fillet"].tolist()[4:6] == [peak.name for peak in hole_found.hole_peaks[:2]]
    assert hole_found.to_xarray()["factor"].shape == (5, 6)
    assert hole_found.plot().get_title(loc="left").endswith("fillets and oil holes")
