"""Stresses at the fillets of CAD parts: the same as those of the throw that the part was made of."""

import math

import pytest

from comparing import close
from crankbase.errors import InputError
from fem import fillet_stress
from fem.fillet_stress import fillet_stresses, torsion_modulus, web_section
from fem.surface_stress import throw_fillets
from geometry.imported import import_throw, imported_parts
from geometry.mesher import mesh_imported_throw
from geometry.solid_files import write_step
from geometry.throw import CrankThrow
from stand_ins import COARSE_STRESSES

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def throw(dimensions):
    return CrankThrow(**dimensions, main_journal_bore=0.06, right_web={"thickness": 0.055})


@pytest.fixture(scope="module")
def part(throw, tmp_path_factory):
    return import_throw(write_step(throw, tmp_path_factory.mktemp("cad") / "throw.step"))


def test_parts_are_those_that_the_solid_was_made_of(throw, part):
    """Lengths as the kernel has them; the width is measured on facets, which cut arcs short by 0.1 %."""
    found = imported_parts(part, mesh_imported_throw(part, 1.5))
    fillets, expected = throw_fillets(found), throw_fillets(throw.parts)
    assert [fillet.name for fillet in fillets] == [fillet.name for fillet in expected]
    for one, other in zip(fillets, expected, strict=True):
        assert (one.radius, one.start, one.end) == close((other.radius, other.start, other.end))
        assert torsion_modulus(one.journal) == close(torsion_modulus(other.journal))
        own, wanted = web_section(found, one.web), web_section(throw.parts, other.web)
        assert own.thickness == close(wanted.thickness)
        assert own.width == close(wanted.width, rel=2e-3)


@pytest.mark.further
def test_stresses_of_a_part_are_those_of_its_throw(dimensions, tmp_path):
    """Two meshes, each within its own estimate. Large fillets take few elements."""
    throw = CrankThrow(**dimensions | {"fillet_radius": 0.02})
    part = import_throw(write_step(throw, tmp_path / "throw.step"))
    expected, found = (fillet_stresses(one, accuracy=0.2) for one in (throw, part))
    assert found.loaded.mesh.part == "full"
    assert found.sharp_corners == ()
    for own, wanted in zip(found.peaks, expected.peaks, strict=True):
        assert (own.name, own.load.kind) == (wanted.name, wanted.load.kind)
        assert own.nominal == close(wanted.nominal, rel=3e-3)
        room = own.error_estimate + wanted.error_estimate
        assert own.von_mises == close(wanted.von_mises, rel=room)


def test_a_part_without_fillets_is_refused(dimensions, tmp_path):
    sharp = CrankThrow(**dimensions | {"fillet_radius": 0.0})
    part = import_throw(write_step(sharp, tmp_path / "sharp.step"))
    with pytest.raises(
        InputError, match=r"sharp\.step: given a part without a fillet at its main jou"
    ):
        fillet_stresses(part)


def test_corners_of_a_part_without_a_fillet_are_named(dimensions, tmp_path, monkeypatch):
    for name, value in COARSE_STRESSES.items():
        monkeypatch.setattr(fillet_stress, name, value)
    half = CrankThrow(**dimensions | {"pin_fillet_radius": 0.0})
    part = import_throw(write_step(half, tmp_path / "half.step"))
    found = fillet_stresses(part, accuracy=0.2)
    assert found.sharp_corners == ("pin, left web", "pin, right web")
    assert {peak.name for peak in found.peaks} == {"left main journal", "right main journal"}
    assert math.isfinite(found.error_estimate)
