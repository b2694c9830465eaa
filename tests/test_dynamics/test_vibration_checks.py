"""What every vibration is checked for, by breaking it: each is an error with its figure."""

from dataclasses import replace

import numpy as np
import pytest

from crankbase.errors import SolveError
from dynamics.chains import chain as chains
from dynamics.chains.chain import Chain
from dynamics.engine.layout import EngineCylinder, EngineLayout
from dynamics.engine.rods import ConnectingRod
from dynamics.response import harmonic
from dynamics.response.forced import forced_response
from dynamics.response.loads import checked_power_balance
from dynamics.response.order_excitation import OrderExcitation
from dynamics.torque.torque import check_energy, engine_torque

CHAIN = Chain(inertia=[1.0, 2.0, 5.0], stiffness=[1e5, 3e5], damping=[20.0, 30.0])
SHARE = 1e-5
ROD = ConnectingRod(length=0.2, mass=1.0, center_distance=0.07, inertia=0.006)
ENGINE = EngineLayout(0.05, [EngineCylinder(0.1, 1.0, ROD)], [1])


def response(method="modal"):
    forces = np.ones((2, 40, 3), dtype=complex)
    excitation = OrderExcitation([1.0, 2.0], np.linspace(20.0, 400.0, 40), forces)
    return forced_response(CHAIN, excitation, magnifier=None, method=method)


def test_answers_that_do_not_satisfy_the_equations(monkeypatch):
    exact = harmonic.dynamic_stiffness
    monkeypatch.setattr(harmonic, "dynamic_stiffness", lambda *given: (1.0 + SHARE) * exact(*given))
    with pytest.raises(SolveError, match=r"leaves a residual of .*e-06 .*\(allowed 1e-09\)"):
        response("direct")


def test_power_that_does_not_balance():
    found = response()
    assert checked_power_balance(found).error < 1e-12
    late = replace(found, motion=found.motion * np.exp(1j * SHARE))
    with pytest.raises(SolveError, match=r"differ by a share of \d.*\(allowed 1e-06\)"):
        checked_power_balance(late)


def test_modes_that_are_none(monkeypatch):
    find = chains.elastic_modes

    def off(rows, mass, count):
        frequencies, shapes = find(rows, mass, count)
        return (1.0 + SHARE) * frequencies, shapes

    monkeypatch.setattr(chains, "elastic_modes", off)
    with pytest.raises(SolveError, match=r"modes of the chain leave a residual of .*1e-10"):
        CHAIN.modes()


def test_work_that_is_not_that_of_the_gas():
    angles = np.radians(np.arange(0.0, 720.0, 0.5))
    torque = engine_torque(ENGINE, 100.0, [3e4 * np.exp(-(angles**2))])
    check_energy(torque)
    with pytest.raises(
        SolveError, match=r"work of the gas differ by a share of .*\(allowed 1e-10\)"
    ):
        check_energy(replace(torque, indicated_work=torque.indicated_work + 1e-3))
