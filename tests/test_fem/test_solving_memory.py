"""Memory is predicted before meshing: refusals mesh nothing; figures: tests/campaigns/predicted_memory.py."""

import pytest

from crankbase import memory
from crankbase.errors import NotEnoughMemoryError
from fem.analysis import analyze_throw
from fem.fillet_stress import fillet_stresses
from geometry.throw import CrankThrow


@pytest.fixture
def little_memory(monkeypatch):
    monkeypatch.setattr(memory, "free_memory", lambda: 0.0)
    monkeypatch.setattr(memory, "LITTLE", 0.0)


def refuse_to_mesh(*_):
    raise AssertionError("nothing may be meshed")


def test_an_analysis_that_does_not_fit_is_refused_before_meshing(throw, little_memory):
    wanted = r"^accuracy: given 0.01, whose next mesh of about [\d,]+ unknowns takes about"
    with pytest.raises(NotEnoughMemoryError, match=wanted):
        analyze_throw(throw, accuracy=0.01, mesher=refuse_to_mesh)


def test_stresses_that_do_not_fit_are_refused(throw, mesh, little_memory):
    meshed = []

    def once(*given):
        assert not meshed
        meshed.append(given)
        return mesh

    filleted = CrankThrow(**throw.model_dump() | {"fillet_radius": 0.012})
    with pytest.raises(
        NotEnoughMemoryError, match=r"^accuracy: given 0.05, whose .* GB that are free"
    ):
        fillet_stresses(filleted, accuracy=0.05, mesher=once)
