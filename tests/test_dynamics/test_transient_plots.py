"""Pictures of runs: written as SVG, refused where there is nothing to show."""

import numpy as np
import pytest

from crankbase.errors import InputError
from crankfem.analyses.vibration.plots import (
    plot_transient,
    plot_transient_over_speed,
)
from dynamics.chains.chain import Chain
from dynamics.response.linear_system import chain_system
from dynamics.response.order_excitation import OrderExcitation
from dynamics.transient.applied_forces import SpeedCurve
from dynamics.transient.run import transient_motion


def run(system):
    acting = OrderExcitation([1.5], [100.0, 300.0], np.ones((1, 2, 2)) * [80.0, 0.0])
    return transient_motion(system, acting, SpeedCurve.ramp(120.0, 280.0, duration=1.0))


@pytest.mark.slow
def test_pictures(tmp_path):
    chain = Chain([0.3, 2.0], [4e4], damping=3.0, names=["crank", "flywheel"])
    found = run(chain)
    for quantity in ("torque", "motion"):
        path = tmp_path / f"{quantity}.svg"
        plot_transient(
            path, found, 0, quantity=quantity, steady=([150.0, 250.0], [20.0, 30.0]), title="a run"
        )
        assert path.read_text(encoding="utf-8").startswith("<?xml")
        assert path.stat().st_size < 200_000
    plot_transient(tmp_path / "turns.svg", found, turns=4)
    assert "amplitude over 4 turns" in (tmp_path / "turns.svg").read_text(encoding="utf-8")
    plot_transient_over_speed(tmp_path / "s.svg", [1.0, 2.0, 3.0], {"one": [1.0, np.inf, 2.0]})
    with pytest.raises(InputError, match=r"^place: given 1; allowed"):
        plot_transient(tmp_path / "a.svg", found, 1)
    with pytest.raises(InputError, match=r"^quantity: given 'torque'; allowed"):
        plot_transient(tmp_path / "a.svg", run(chain_system(chain)))
    with pytest.raises(InputError, match=r"^steady: given arrays"):
        plot_transient(tmp_path / "a.svg", found, steady=([3.0, 2.0], [1.0, 1.0]))
    with pytest.raises(InputError, match=r"^amplitudes: given none"):
        plot_transient_over_speed(tmp_path / "a.svg", [1.0], {})
    with pytest.raises(InputError, match=r"^amplitudes\['x'\]: given"):
        plot_transient_over_speed(tmp_path / "a.svg", [1.0], {"x": [np.nan]})
