"""Damped modes and damped critical speeds, beside closed forms."""

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.errors import InputError
from crankbase.tables.frames import table_of
from dynamics.chains.chain import Chain, Gear
from dynamics.chains.dampers import RubberDamper, ViscousDamper
from dynamics.response.complex_modes import complex_modes
from dynamics.response.damped_criticals import damped_criticals
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import chain_system, damped
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import refined_speeds

SPEEDS = np.linspace(40.0, 200.0, 30)
ROW = Chain([1.0, 1.0, 4.0], [4e4, 4e4])
MAIN = Chain([1.0], [], {0: 1e4}, connections=[], names=["main"])


def response(chain, orders=(1.0, 2.0), node=0, speeds=SPEEDS):
    given = chain.chain if hasattr(chain, "record") else chain
    forces = np.zeros((len(orders), len(speeds), given.inertia.size), dtype=complex)
    forces[:, :, node] = 10.0
    return forced_response(chain, OrderExcitation(orders, speeds, forces))


def test_modes_of_one_mass():
    """s = -d w + i w sqrt(1 - d^2)."""
    modes = complex_modes(damped(MAIN, modal_damping=0.1))
    assert modes.eigenvalues == close([-10.0 + 100.0j * np.sqrt(0.99)], rel=1e-12)
    assert modes.frequencies == close([100.0 * np.sqrt(0.99) / (2.0 * np.pi)])
    assert modes.damping_ratios == close([0.1])
    assert modes.sources == ({"modal damping": 1.0},)
    assert (modes.numbers.tolist(), modes.locked) == ([1], None)
    assert modes.largest_magnifiers == close([0.5 / (0.1 * np.sqrt(0.99))])
    assert modes.magnifiers(np.array([100.0])) == close(np.array([[5.0]]))
    frame = modes.to_pandas()
    assert frame["undamped"].tolist() == close([100.0 / (2.0 * np.pi)])
    assert frame["damped_by"].tolist() == ["modal damping"]


def test_a_mode_that_creeps_is_none():
    modes = complex_modes(damped(MAIN, modal_damping=1.5))
    assert modes.eigenvalues.size == 0
    found = damped_criticals(response(damped(MAIN, modal_damping=1.5)), node=0)
    assert [(one.order, one.mode, one.has_peak) for one in found] == [
        (1.0, 1, False),
        (2.0, 1, False),
    ]
    assert np.isnan(found[0].mode_frequency)
    assert found[0].sentence.startswith("Order 1, mode 1: no peak (954.9 1/min undamped).")


@pytest.mark.parametrize("ratio", [0.001, 0.05, 0.3, 0.6])
def test_the_peak_of_one_mass(ratio):
    """w_n sqrt(1 - 2 d^2) and 1 / (2 d sqrt(1 - d^2)), without a maximum from d = 0.707 on."""
    speeds = np.linspace(20.0, 200.0, 40)
    run = response(damped(MAIN, modal_damping=ratio), speeds=speeds)
    (one, two) = damped_criticals(run, node=0)
    peak = 100.0 * np.sqrt(1.0 - 2.0 * ratio**2)
    assert two.speed == close(0.5 * peak, rel=1e-6)
    assert two.amplitude == close(1e-3 * 0.5 / (ratio * np.sqrt(1.0 - ratio**2)), rel=1e-9)
    assert two.undamped_speed == close(50.0)
    assert (two.mode, two.place, two.in_band) == (1, "main", True)
    assert two.mode_share == close(1.0, rel=1e-9)
    assert two.damping_ratio == close(ratio)
    assert two.frequency == close(two.speed / np.pi)
    assert max(one.severity, two.severity) == 1.0
    assert not two.unbounded
    assert one.speed == close(peak, rel=1e-6)


def test_at_speeds_that_hold_all_that_are_looked_at():
    chain = damped(MAIN, modal_damping=0.02)
    speeds = refined_speeds([100.0 / (2.0 * np.pi)], 0.02, [1.0], (40.0, 200.0))
    (own,) = damped_criticals(response(chain, orders=(1.0,), speeds=speeds), node=0)
    assert own.speed == close(100.0 * np.sqrt(1.0 - 2.0 * 0.02**2), rel=1e-6)


def test_no_peak_with_much_damping():
    found = damped_criticals(response(damped(MAIN, modal_damping=0.75)), node=0)
    assert [one.has_peak for one in found] == [False, False]
    assert "has_peak no" in repr(found[0])
    assert "nan" not in repr(found[0])
    assert found[0].damping_ratio == close(0.75)


def test_without_damping():
    found = damped_criticals(response(ROW), node=0)
    assert {one.amplitude for one in found} == {float("inf")}
    for one in found:
        assert one.speed == close(one.undamped_speed, rel=1e-9)
        assert one.mode_share == one.severity == 1.0
        assert one.unbounded
    assert complex_modes(ROW).sources == ({}, {})


@pytest.mark.parametrize("damping", [1e-3, 30.0, 1e6])
def test_the_ring_of_a_damper_free_and_locked(damping):
    chain = ViscousDamper(0.5, damping).attached(ROW, 0)
    modes = complex_modes(damped(chain, loss_factor=0.01))
    free = ROW.modes().frequencies[1:]
    locked = Chain([1.5, 1.0, 4.0], [4e4, 4e4]).modes().frequencies[1:]
    assert modes.undamped == close(free, rel=1e-9)
    assert modes.locked == close(locked, rel=1e-9)
    assert modes.numbers.tolist() == [1, 2]
    frame = modes.to_pandas()
    assert frame["undamped"].tolist() == close(free, rel=1e-9)
    assert frame["locked"].tolist() == close(locked, rel=1e-9)
    if damping == 1e-3:
        assert modes.frequencies == close(free, rel=1e-4)
    elif damping == 1e6:
        assert modes.frequencies == close(locked, rel=1e-4)
    else:
        assert np.all((locked < modes.frequencies) & (modes.frequencies < free))
        assert next(iter(modes.sources[0])) == "node 0 - damper ring"
    assert [sum(own.values()) for own in modes.sources] == close([1.0, 1.0])
    # Loss factors alone give half of themselves as a damping ratio.
    if damping != 30.0:
        assert modes.damping_ratios == close([0.005, 0.005], rel=0.05)


def test_sources_of_every_kind():
    chain = damped(
        RubberDamper(0.1, 3e3, 0.2, 1.0).attached(ROW, 0),
        relative={0: 2.0},
        absolute={1: 3.0},
        modal_damping=0.01,
    )
    modes = complex_modes(chain)
    names = set().union(*modes.sources)
    assert names == {"node 0 - damper ring", "node 0 - node 1", "node 1 to ground", "modal damping"}
    assert modes.shapes.shape == (4, 3)
    assert np.abs(modes.shapes).max(axis=0) == close([1.0, 1.0, 1.0])


def test_of_a_system_and_with_gears():
    modes = complex_modes(chain_system(MAIN).with_magnifier(10.0))
    assert modes.sources == ({"damping of the system": 1.0},)
    geared = Chain([1.0, 1.0, 2.0], [4e4], connections=[(0, 1)], gears=[Gear(1, 2, 2.0)])
    assert complex_modes(damped(geared)).frequencies == close(
        geared.modes().frequencies[1:], rel=1e-3
    )
    found = damped_criticals(response(damped(geared)))
    assert {one.place for one in found} == {"node 0 - node 1"}


@pytest.mark.parametrize("chain", [damped(ROW), ViscousDamper(0.5, 30.0).attached(ROW, 0)])
def test_contributions_of_modes_are_the_whole_response(chain):
    found = response(chain)
    modes = complex_modes(found)
    row = (found.chain.elongations() @ found.system.expand)[0]
    forces = found.excitation.forces[1] @ found.system.expand
    parts = modes.contributions(2.0 * SPEEDS, forces, np.broadcast_to(row, forces.shape))
    assert parts.sum(axis=1) == close(found.unknowns[1] @ row, rel=1e-9)


def test_peaks_of_the_forces_are_no_resonances():
    """A force that is large about 90 rad/s makes a peak there, 10 % above the mode's own."""
    speeds = np.linspace(40.0, 200.0, 400)
    forces = (1.0 + 40.0 / (1.0 + ((speeds - 130.0) / 3.0) ** 2))[np.newaxis, :, np.newaxis]
    run = forced_response(
        damped(MAIN, modal_damping=0.01), OrderExcitation([1.0], speeds, forces.astype(complex))
    )
    own, other = damped_criticals(run, node=0)
    assert (own.in_band, other.in_band) == (True, False)
    assert own.speed == close(100.0, rel=2e-3)
    assert other.speed == close(130.0, rel=2e-2)
    assert "where its forces are largest" in other.sentence


def test_what_is_asked_for():
    run = response(damped(ROW))
    every = damped_criticals(run)
    first = damped_criticals(run, elements=[0])
    assert {one.place for one in first if one.has_peak} == {"node 0 - node 1"}
    assert len(every) == len(first)
    part = damped_criticals(run, speed_range=(60.0, 140.0))
    assert 0 < len(part) < len(every)
    assert {one.speed for one in part} <= {one.speed for one in every}
    frame = table_of(every)
    assert frame["speed"].tolist() == [one.speed for one in every]
    assert every[0].speed_rpm == close(every[0].speed * 30.0 / np.pi)
    assert repr(every[0]).startswith("DampedCritical(order 1, mode 1, has_peak yes, speed_rpm ")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"elements": [0], "node": 0}, "node: given 0 together with elements"),
        ({"elements": [2]}, "elements: given 2"),
        ({"node": "nowhere"}, "node: given 'nowhere'"),
        ({"speed_range": (200.0, 100.0)}, "speed_range: given"),
        (
            {"speed_range": (10.0, 100.0)},
            "speed_range: given 10 to 100 rad/s; allowed is within 40",
        ),
    ],
)
def test_refused(options, words):
    with pytest.raises(InputError, match=words):
        damped_criticals(response(damped(ROW)), **options)


def test_refused_at_one_speed():
    with pytest.raises(InputError, match="given one at one speed"):
        damped_criticals(response(damped(ROW), speeds=np.array([50.0])))


def test_public_names():
    assert cf.response.complex_modes is complex_modes
    assert cf.response.damped_criticals is damped_criticals
