"""Diagrams of forced vibration: they are made, the same each time, and say what is unbounded."""

import numpy as np
import pytest

from crankbase.drawing.diagram_style import figure
from crankbase.errors import InputError
from crankfem.analyses.vibration.plots import plot_response_campbell
from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.linear_system import damped
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.resonance import resonances

TWO = Chain([1.0, 1.0], [2e4], names=["pulley", "flywheel"])  # 200 rad/s


def response(**damping):
    speeds = np.array([50.0, 100.0, 150.0])
    forces = np.ones((2, 3, 2)) * np.array([1.0, -1.0])
    return forced_response(damped(TWO, **damping), OrderExcitation([1.0, 2.0], speeds, forces))


@pytest.mark.slow
def test_diagrams_are_made_and_the_same_each_time(tmp_path):
    for name, choice in (("damped", {}), ("endless", {"undamped": True})):
        found = response(**choice)
        made = []
        for copy in ("a", "b"):
            campbell, curves = (tmp_path / f"{name}_{copy}_{what}.svg" for what in "cs")
            plot_response_campbell(
                campbell,
                found.system.elastic_frequencies,
                found.orders,
                (50.0, 150.0),
                resonances(found),
                title="x",
            )
            with figure(curves) as axes:
                found.elastic.plot(
                    axes,
                    "pulley",
                    quantity="twist",
                    limits={"limit": 1e-4, "rule": [1e-4, 2e-4, 3e-4]},
                    barred=[(95.0, 105.0)],
                )
            made.append(campbell.read_bytes() + curves.read_bytes())
        assert made[0] == made[1]
        assert b"nan" not in made[0].lower().replace(b"nance", b"")
    assert (tmp_path / "damped_a_s.svg").read_bytes() != (tmp_path / "endless_a_s.svg").read_bytes()


@pytest.mark.parametrize(
    ("place", "quantity", "words"),
    [
        ("crank", "twist", "place: given 'crank'"),
        (2, "twist", "place: given 2; allowed are the whole numbers 0 to 1"),
        (0, "noise", "quantity: given 'noise'; allowed are twist"),
    ],
)
def test_refused(tmp_path, place, quantity, words):
    with pytest.raises(InputError, match=words):
        response().nodes.plot(None, place, quantity=quantity)
    with pytest.raises(InputError, match="path: given"):
        plot_response_campbell(tmp_path / "x.png", [10.0], [1.0], (1.0, 2.0), [])
