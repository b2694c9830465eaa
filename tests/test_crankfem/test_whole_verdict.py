"""The whole crankshaft held against the limits, where a chain is no adequate model of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from comparing import close
from crankfem.analyses.shaft.whole_shaft import ShaftComparison
from crankfem.analyses.vibration.engine_limits import engine_limits
from crankfem.analyses.vibration.whole_verdict import (
    decision_by_both,
    whole_sentence,
    whole_stress,
    whole_verdict,
)
from crankfem.files.engine.engine_file import load_engine
from dynamics.assessment.limits import AmplitudeCurve
from dynamics.assessment.verdict import decide
from dynamics.crankshaft.chain_comparison import ResponseMatch
from dynamics.response.series import OrderSeries

# From 200 to 515 1/min, and some beyond.
SPEEDS = np.linspace(18.0, 60.0, 421)
MODULUS = 1e-3
# Three throws between free end and flywheel.
CRANKS = SimpleNamespace(
    throw_nodes=(1, 2, 3),
    chain=SimpleNamespace(
        connections=((0, 1), (1, 2), (2, 3), (3, 4)), elements=("a", "b", "c", "d")
    ),
)


@pytest.fixture(scope="module")
def six():
    return load_engine("6chn25-34")


def compared(torque, *, adequate=()):
    """A whole crankshaft with one order's torque at the third of its four bearings."""
    values = np.zeros((1, SPEEDS.size, 4), dtype=complex)
    values[0, :, 2] = torque
    series = OrderSeries(
        np.array([1.0]),
        SPEEDS,
        values,
        np.zeros((1, SPEEDS.size), dtype=bool),
        ("main bearing 1", "main bearing 2", "main bearing 3", "main bearing 4"),
    )
    response = ResponseMatch("torsional", SPEEDS, np.ones(SPEEDS.size), np.ones(SPEEDS.size))
    kinds = [
        SimpleNamespace(kind=kind, suffices=kind in adequate, response=response)
        for kind in ("axial", "torsional")
    ]
    return ShaftComparison(SimpleNamespace(torque=series), *kinds)


def judged(six, comparison, checks=()):
    chains = SimpleNamespace(checks=checks)
    return whole_verdict(six, comparison, CRANKS, dict.fromkeys(range(4), MODULUS), chains)


def test_stress_at_a_bearing_is_that_of_the_element_through_it():
    stress = whole_stress(compared(5e3), CRANKS, {1: MODULUS, 2: 2.0 * MODULUS, 3: MODULUS})
    assert stress.names == ("b", "c", "d")
    assert np.max(stress.amplitude, axis=(0, 1)) == close((0.0, 2.5e6, 0.0))
    # Without a node at the free end the first element lies between the first two throws.
    bare = SimpleNamespace(
        throw_nodes=(0, 1, 2),
        chain=SimpleNamespace(connections=((0, 1), (1, 2), (2, 3)), elements=("b", "c", "d")),
    )
    stress = whole_stress(compared(5e3), bare, dict.fromkeys(range(3), MODULUS))
    assert np.max(stress.amplitude, axis=(0, 1)) == close((0.0, 5e6, 0.0))


def test_only_inadequate_chains_are_replaced(six):
    assert judged(six, compared(1e5, adequate=("axial", "torsional"))) is None
    assert judged(six, ShaftComparison(None)) is None
    found = judged(six, compared(1e5))
    assert found.status == "not acceptable"
    assert (found.checks[0].curve.name, found.checks[0].worst_value) == ("c", close(1e8))
    assert judged(six, compared(1e2)).status == "fine"
    # Without a limit on what the inadequate chain gives, nothing is decided by it.
    assert judged(six, compared(1e2, adequate=("torsional",))) is None


def test_what_an_adequate_chain_exceeds_is_not_acceptable_by_the_whole_crankshaft_either(six):
    limited = six.changed(limits={"axial_amplitude": 1e-3, "axial_force": 1e4})
    found = judged(limited, compared(1e2, adequate=("axial",)))
    assert found.status == "not acceptable"
    assert found.checks[0].limit.name.startswith("axial amplitude")
    # Axial forces are those of the chain.
    limited = six.changed(limits={"axial_force": 1e4})
    limit = next(one for key, one in engine_limits(limited)[0].items() if key == "axial_force")
    force = AmplitudeCurve("throw 1", SPEEDS, np.full(SPEEDS.size, 2e4))
    found = judged(limited, compared(1e2), [SimpleNamespace(limit=limit, curve=force)])
    assert found.status == "not acceptable"
    assert found.checks[0].curve is force
    said = whole_sentence(found, SimpleNamespace(checks=found.checks[:1], status=found.status))
    assert "torsional stress of crankshaft" in said.partition(";")[0]
    assert f'the same verdict, "not acceptable" ({found.barred[0].sentence}).' in said


def test_verdicts_that_differ_leave_it_undecided(six):
    bad, fine, other = (judged(six, compared(torque)) for torque in (1e5, 1e2, 1e5))
    decided = decide("not acceptable", [])
    same = decision_by_both(decided, bad, bad)
    assert same is decided
    for whole, chains, said in (
        (fine, bad, "acceptable by the whole crankshaft, not by the lumped model"),
        (bad, fine, "acceptable by the lumped model, not by the whole crankshaft"),
    ):
        found = decision_by_both(decided, whole, chains)
        assert found.status == "undecided"
        assert found.sentence.startswith(said)
    assert 'with the values used, the same verdict, "not acceptable"' in whole_sentence(bad, other)
    assert 'another verdict, "fine"' in whole_sentence(fine, bad)
    assert "100 MPa at" in whole_sentence(bad, other)
