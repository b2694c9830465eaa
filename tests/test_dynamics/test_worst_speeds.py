"""Where most of a limit is used, whatever the grid of speeds.

Tolerances: refined peaks are known to 1/512 of the half bandwidth, where a resonance is within
(1/512)^2 / 2 = 2e-6 of its height; speeds to 1/512 of half a bandwidth of 1.25 %, 2.5e-5.
"""

import numpy as np

from comparing import close
from dynamics.assessment.limit_rules import crankshaft_limit
from dynamics.assessment.limits import usage
from dynamics.assessment.response_curves import curves_of, refined_maxima
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.loads import alternating_stress, element_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import refined_speeds

CHAIN = damped(Chain([0.4, 1.2, 1.2, 25.0], [4e5, 4e5, 5e5]), magnifier=40.0)
ORDERS = np.array([6.0, 7.0, 7.5, 8.0])
LIMIT = crankshaft_limit(95.0, strokes=4)
RANGE = (45.0, 1.15 * 95.0)


def uses_at(speeds):
    """Used shares of the limit of the three shafts, all orders together."""
    forces = np.zeros((ORDERS.size, speeds.size, 4), dtype=complex)
    forces[:, :, 1], forces[:, :, 2] = 300.0, 250.0j
    found = forced_response(CHAIN, OrderExcitation(ORDERS, speeds, forces))
    stress = alternating_stress(element_loads(found), dict.fromkeys(range(3), 2e-5))
    return np.array([usage(LIMIT, curve) for curve in curves_of(stress)])


def grid(points, further=()):
    natural = np.concatenate((CHAIN.system.elastic_frequencies, further))
    return refined_speeds(natural, 0.5 / 40.0, ORDERS, RANGE, points=points)


def worst(speeds):
    uses = uses_at(speeds)
    place = np.unravel_index(np.argmax(uses), uses.shape)
    return speeds[place[1]], uses[place]


def test_worst_use_is_the_same_on_coarse_and_fine_grids():
    grids = [grid(40), grid(150), grid(150, (61.0, 87.3)), np.linspace(*RANGE, 601)]
    plain, refined = [], []
    for speeds in grids:
        more = refined_maxima(uses_at, speeds)
        assert np.all((speeds[0] <= more) & (more <= speeds[-1]))
        plain.append(worst(speeds))
        refined.append(worst(more))
    exact = worst(np.linspace(0.998 * refined[0][0], 1.002 * refined[0][0], 801))
    for speed, use in refined:
        assert use == close(exact[1], rel=5e-6)
        assert speed == close(exact[0], rel=1e-4)
    # The grids alone differ by far more.
    assert np.ptp([use for _, use in plain]) > 1e-4 * exact[1]


def test_outer_peaks_of_each_exceeded_range_are_refined():
    def uses(speeds):
        near = [1.0 / (1.0 + ((speeds - at) / 0.7) ** 2) for at in (20.03, 22.11, 24.07, 40.01)]
        return np.array([3.0 * near[0] + 4.0 * near[1] + 2.0 * near[2] + 1.5 * near[3] + 0.05])

    dense = np.linspace(10.0, 50.0, 80001)
    values = uses(dense)[0]
    tops = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])) + 1
    first, highest, last, alone = dense[tops]
    speeds = np.linspace(10.0, 50.0, 161)
    # Neighbors 0.25 apart come 64 times closer.
    near = {"abs": 2 * 0.25 / 64}
    assert refined_maxima(uses, speeds) == close([highest], **near)
    outer = refined_maxima(uses, speeds, least=1.0)
    assert outer == close([first, highest, last, alone], **near)
    # An unbounded value stays where it is.
    unbounded = uses(speeds)
    unbounded[0, 80] = np.inf
    assert refined_maxima(lambda _: unbounded, speeds).size == 0


def test_a_maximum_at_the_end_stays_there():
    def rising(speeds):
        return np.array([speeds**2])

    speeds = np.linspace(1.0, 2.0, 11)
    assert refined_maxima(rising, speeds).tolist() == [2.0]
