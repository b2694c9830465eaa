"""Stresses at the exits of oil holes: computed, refused, written, drawn."""

import math

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.throw.pictures.stress_picture import picture_arrays
from crankfem.analyses.throw.stress import stress_record, stress_tables
from crankfem.cli.tables.throw_tables import _sentences
from fem.fillet_stress import fillet_stresses, nominal_hole_stress
from fem.loads import radial_directions
from fem.unit_loads import unit_loads
from geometry.throw import CrankThrow

HOLE = {"part": "pin", "diameter": 0.03}
IN_JOURNAL = {"part": "right main journal", "diameter": 0.02, "position": -0.025, "through": False}


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions, oil_holes=(HOLE,))


@pytest.fixture(scope="module")
def found(throw):
    return fillet_stresses(throw, accuracy=0.2)


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


@pytest.mark.slow
def test_factors_at_exits(found, throw):
    assert throw.symmetry == "quarter"
    names = ["pin, oil hole 1 at 0 deg", "pin, oil hole 1 at 180 deg"]
    assert len(found.hole_peaks) == len(found.loaded.loads) * len(names)
    by_kind = {}
    for load in found.loaded.loads:
        peaks = found.at_oil_holes(load)
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
    assert found.error_estimate == max(p.error_estimate for p in (*found.peaks, *found.hole_peaks))


@pytest.mark.slow
def test_records_tables_and_pictures_have_them_beside_the_fillets(found):
    record = stress_record(found)
    assert record["dimensions"]["oil_holes"][0]["diameter"] == 0.03
    own = record["loads"][1]["oil_holes"]
    assert [(one["diameter"], one["exit_radius"]) for one in own] == [(0.03, 0.0)] * 2
    assert own[0]["factor"] == found.at_oil_holes(found.loaded.loads[1])[0].factor
    table = stress_tables(record)[1]
    assert table.title.startswith("Torque: largest stresses at fillets and exits of oil holes")
    assert [row[0] for row in table.rows][-1] == "pin, oil hole 1 at 180 deg"
    assert any("to a depth of one diameter" in sentence for sentence in _sentences(record))
    drawn = picture_arrays(found)
    assert drawn["places"].shape == (
        5,
        2,
        4,
        3,
    )  # a fillet and a hole, in each image of the quarter
    for number, load in enumerate(found.loaded.loads):
        hole = max(found.at_oil_holes(load), key=lambda peak: peak.von_mises)
        fillet, text = drawn["remarks"][number].split("\n")
        assert fillet.startswith("largest at a fillet: ")
        assert text.startswith(
            f"largest at an oil hole: {hole.von_mises / 1e3:.3g} MPa ({hole.name}; "
        )
        largest = max(peak.von_mises for peak in (*found.under(load), hole))
        assert drawn["largest"][number] == close(largest / 1e3)
        # On the rim, right above where the stress is.
        rim = drawn["places"][number, 1, 0]
        assert math.hypot(rim[0], rim[1] - 0.17) == close(0.09)
        assert rim[2] == close(hole.von_mises_place[2])
    # Records that older releases wrote have no such key; the left fillets of two say all.
    for load in record["loads"]:
        del load["oil_holes"]
    assert len(stress_tables(record)[1].rows) == 2
    frame = found.to_pandas()
    assert len(frame) == len(found.peaks) + len(found.hole_peaks)
    assert frame["fillet"].tolist()[4:6] == [peak.name for peak in found.hole_peaks[:2]]
    assert found.to_xarray()["factor"].shape == (5, 6)
    assert found.plot().get_title(loc="left").endswith("fillets and oil holes")
