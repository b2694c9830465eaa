"""Excitation from the printed torque of one throw of the YaMZ-5340.

Source: Makushev, Polyakova 2024, doi 10.25206/1813-8225-2024-191-39-47: table 2 (torque of one throw),
section 2.1 (harmonics M_k sin(k x + a_k), k by the cycle).

Tolerance: half of the last printed digit; round-off for the series through all samples and for four
cylinders in even firing.
"""

from pathlib import Path

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from dynamics.excitation.cylinders import forces_at_speeds, torque_harmonics
from dynamics.harmonics import read_torque_table

TABLE = read_torque_table(
    Path(__file__).parents[2] / "data" / "tables" / "yamz5340_torque_one_throw.csv"
)
RADIUS = 0.064
# Firing order 1-3-4-2.
FIRING = np.radians([0.0, 540.0, 180.0, 360.0])
FIRING_DEG = np.degrees(FIRING)
SPEEDS = np.array([100.0, 2300.0 * np.pi / 30.0])


def test_printed_harmonics_excite_with_their_phases(figure):
    found = forces_at_speeds(
        torque_harmonics(
            TABLE.harmonics(), firing_angles_deg=FIRING_DEG, orders=8.5, crank_radius=RADIUS
        ),
        SPEEDS,
    )
    first = found.torque[:2, 1, 0]
    figure("orders 0.5 and 1", np.abs(first), [279.68, 396.44], 0.005, "N m", "absolute")
    # M sin(x + a) is Re(M exp(i (x + a - pi / 2))); printed 230.16 and, corrected, 20.38 deg.
    phases = np.degrees(np.angle(first * 1j)) % 360.0
    figure("their phases", phases, [230.16, 20.38], 0.005, "deg", "absolute")
    figure("mean torque of four", found.mean_torque, 4 * 123.36, 0.02, "N m", "absolute")
    assert found.remarks[0].startswith("One torque diagram was used at all speeds from 954.93")


def test_series_meets_the_table_and_even_firing_leaves_even_orders(figure):
    harmonics = torque_harmonics(
        TABLE.harmonics(), firing_angles_deg=FIRING_DEG, orders=8.5, crank_radius=RADIUS
    )
    found = forces_at_speeds(harmonics, SPEEDS)
    tangential, radial = found.at_angle(
        0, shaft_angle_deg=np.degrees(np.radians(TABLE.crank_angle_deg) + FIRING[2])
    )
    # 36 samples also hold the order 9, which alternates from sample to sample and has no phase.
    alternating = np.cos(9.0 * np.radians(TABLE.crank_angle_deg))
    left = TABLE.torque - RADIUS * tangential[:, 2]
    ninth = np.mean(left * alternating) * alternating
    figure("what the series leaves of the table", left, ninth, 1e-9, "N m", "absolute")
    assert np.all(radial == 0.0)
    total = np.abs(found.torque[:, 0].sum(axis=1))
    even = found.orders % 2.0 == 0.0
    assert total[even] == close(4.0 * np.abs(found.torque[even, 0, 0]), rel=1e-12)
    assert total[~even] == close(np.zeros(total[~even].size), abs=1e-10)


def test_orders_that_the_samples_do_not_resolve_are_refused():
    with pytest.raises(InputError, match=r"orders\[17\]: given 9; allowed are orders up to 8.5"):
        torque_harmonics(
            TABLE.harmonics(), firing_angles_deg=FIRING_DEG, orders=9.0, crank_radius=RADIUS
        )
    with pytest.raises(InputError, match="given 6; allowed are orders up to 5"):
        torque_harmonics(
            TABLE.harmonics().up_to(5.0),
            firing_angles_deg=FIRING_DEG,
            orders=[6.0],
            crank_radius=RADIUS,
        )
    with pytest.raises(InputError, match="torque: given 2 for 4 firing angles"):
        torque_harmonics(
            [TABLE.harmonics()] * 2, firing_angles_deg=FIRING_DEG, orders=5.0, crank_radius=RADIUS
        )
