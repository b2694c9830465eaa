"""What `crankfem check` accepts, `run` and `vibration` accept too, and the reverse, in the same words."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from crankbase.errors import InputError
from crankfem.analyses.file_check import check_file
from crankfem.analyses.shaft.chains import shaft_surroundings
from crankfem.analyses.strength.cycle_loads import supported_throws
from crankfem.analyses.strength.element_factors import shrink_fit, throw_webs
from crankfem.analyses.vibration import run as vibration_run
from crankfem.analyses.vibration.engine_excitation import (
    engine_harmonics,
    engine_load,
    forces_over_speeds,
)
from crankfem.analyses.vibration.engine_limits import compared_quantities, rule_of
from crankfem.jobs.run_computation import read_inputs
from strategies.engine_changes import WHOLE, changed_engines

QUICK = tuple(path for path in WHOLE if path.stem in ("6chn18-22", "6chn18-22-set", "cat-3116"))


class ReachedError(Exception):
    """All that comes before the finite elements was accepted."""


def reached(_):
    raise ReachedError


def cheap_part(path):
    """Do what a run does before and after finite elements, without them."""
    inputs = read_inputs(path)
    engine = inputs.engine_file
    with pytest.raises(ReachedError):
        vibration_run.engine_vibration(engine, mechanism=inputs.mechanism)
    masses = SimpleNamespace(inertia_about_shaft=1.0)
    shaft_surroundings(engine, dict.fromkeys(engine.named_throws, SimpleNamespace(masses=masses)))
    compared_quantities(engine)
    assert rule_of(engine.engine)
    if engine.ranges is not None:
        assert isinstance(
            (*engine.ranges.axial_spreads(), *engine.ranges.torsional_spreads()), tuple
        )
    if inputs.with_gas is None and engine.gas_map is None:
        return
    harmonics = engine_harmonics(engine, inputs.mechanism)
    rated = engine.engine.rated_speed
    forces_over_speeds(engine, harmonics, np.array([0.9, 1.0]) * rated)
    engine_load(engine, inputs.mechanism)
    if engine.strength is not None:
        supported_throws(engine, mechanism=inputs.mechanism)
        for throw in engine.crank_throws:
            throw_webs(throw, engine.strength)
            shrink_fit(throw, engine.strength, 1.0, engine.material.youngs_modulus)


def outcome(read, path):
    try:
        read(path)
    except InputError as error:
        return str(error)
    return "accepted"


def compare(monkeypatch, tmp_path, engines, examples):
    """Read drawn engines both ways, and count what was accepted and refused."""
    monkeypatch.setattr(vibration_run, "analyze_throws", reached)
    counts, path = Counter(), tmp_path / "engine.toml"

    @settings(
        max_examples=examples,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(changed_engines(engines))
    def same(text):
        path.write_text(text, encoding="utf-8")
        told = outcome(lambda file: check_file(str(file)), path)
        assert outcome(cheap_part, path) == told, text
        counts[told == "accepted"] += 1

    same()
    return counts


@pytest.mark.slow
def test_check_accepts_and_refuses_what_a_run_does(monkeypatch, tmp_path):
    counts = compare(monkeypatch, tmp_path, QUICK, 20)
    assert counts[True] >= 5
    assert counts[False] >= 2


@pytest.mark.further
def test_check_accepts_and_refuses_what_a_run_does_of_every_engine(monkeypatch, tmp_path):
    counts = compare(monkeypatch, tmp_path, WHOLE, 400)
    assert counts[True] >= 100
    assert counts[False] >= 50
