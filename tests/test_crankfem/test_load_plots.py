"""Pictures of load diagrams: where the curves lie on paper, and what is refused."""

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from crankfem.analyses.mechanism.plots import plot_polar_loads
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import on_paper, square_round

ANGLES = np.radians(np.arange(0.0, 720.0, 15.0))


@pytest.fixture
def diagram():
    """3 kN outwards and 4 kN with the rotation, on a crank that stands at 0.5 rad."""
    force = 1e3 * (3.0 + 4.0j) * np.exp(1j * (0.5 + ANGLES))
    return LoadDiagram("pin", np.degrees(ANGLES), force, np.degrees(0.5))


def test_the_crank_stands_upright_and_turns_clockwise(diagram):
    """Right is with the rotation and up outwards; at rest, right is -x, seen from the free end."""
    np.testing.assert_allclose(on_paper(diagram, "crank"), 4.0 + 3.0j, rtol=1e-12)
    columns = diagram.columns()
    at_rest = 1e-3 * (-columns["force_x_N"] + 1j * columns["force_y_N"])
    np.testing.assert_allclose(on_paper(diagram, "engine"), at_rest, rtol=1e-12)


def test_the_square_holds_curves_and_origin():
    low, high = square_round([np.array([2.0 + 1.0j, 6.0 + 3.0j])])
    assert high[0] - low[0] == close(high[1] - low[1])
    assert low[0] < 0.0
    assert low[1] < 0.0
    assert high[0] > 6.0
    assert high[1] > 3.0


@pytest.mark.slow
def test_pictures_are_the_same_each_time_and_differ_by_frame(diagram, tmp_path):
    made = []
    for name, frame in (("a", "crank"), ("b", "crank"), ("c", "engine")):
        path = tmp_path / f"{name}.svg"
        plot_polar_loads(path, [diagram, diagram], labels=["one", "two"], frame=frame, title="x")
        made.append(path.read_bytes())
    assert made[0] == made[1]
    assert made[0] != made[2]
    diagram.plot().figure.savefig(tmp_path / "d.svg")
    assert (tmp_path / "d.svg").read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"labels": ["one", "two"]}, "labels: given 2 for 1 diagrams"),
        ({"frame": "ship"}, "frame: given 'ship'; allowed are crank, engine"),
        (
            {"mark_step_deg": 0.0},
            "mark_step_deg: given 0 deg; allowed are finite numbers of more than zero",
        ),
    ],
)
def test_what_does_not_fit_is_refused(diagram, tmp_path, more, words):
    with pytest.raises(InputError, match=words):
        plot_polar_loads(tmp_path / "x.svg", [diagram], **more)
    with pytest.raises(InputError, match="diagrams: given none"):
        plot_polar_loads(tmp_path / "x.svg", [])
