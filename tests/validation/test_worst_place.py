"""The worst place of a verdict, and its cause.

Source: the largest stress of all elements and speeds of an in-line eight made for this: above the running
range another element is worst.

Tolerance: round-off.
"""

from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close

ENGINE = Path(__file__).parents[1] / "data" / "engines" / "8l32-42-invented.toml"


@pytest.mark.further
def test_place_value_speed_and_cause_are_of_one_point(figure):
    run = cf.engine_vibration(ENGINE)
    forced, verdict = run.forced_torsional, run.assessment.verdict
    speeds = forced.response.speeds
    inside = speeds <= run.engine_file.engine.highest_speed * (1.0 + 1e-9)
    inside &= speeds >= run.engine_file.engine.lowest_speed * (1.0 - 1e-9)
    stress = forced.stress.synthesis.amplitude[inside]
    allowed = verdict.deciding.limit.continuous.at(speeds[inside])
    at, place = np.unravel_index(np.argmax(stress / allowed[:, np.newaxis]), stress.shape)
    worst = verdict.deciding
    assert worst.curve.name == forced.stress.names[place] == "cylinder 5 - cylinder 6"
    figure("stress at the worst running speed", worst.worst_value, stress[at, place], 1e-9, "Pa")
    figure("its speed", worst.worst_speed, speeds[inside][at], 1e-9, "rad/s")
    # The orders add up to the amplitude at this place and speed.
    parts = sum(one.contribution for one in worst.cause.parts)
    assert worst.cause.amplitude == close(worst.worst_value, rel=1e-9)
    assert parts == close(worst.worst_value, rel=0.01)
    # Above the running range another place is worse, and is told apart.
    assert verdict.checks[0].curve.name == "cylinder 6 - cylinder 7"
    assert verdict.sentence.index("cylinder 5") < verdict.sentence.index("Above the running range")
