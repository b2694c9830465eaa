"""The direct-drive plant of a Wartsila 5RT-flex50D.

Source: data of Wartsila for the plant in a public Matlab file, with natural frequencies of 330.08, 502.10,
1872.20 1/min and a critical speed of 66.0 1/min.

Tolerance: 0.02 % of the frequencies, from data of three to five digits; 0.1 % of the critical speed,
printed to 0.1/min.

The shipped engine 5rt-flex50d has these data; the assumed dimensions of its throw do not enter the chain.
The ends of the barred range are the rule's, 16 n/(18 - r) and (18 - r) n/16 with r = n over the rated
speed; the verdict's range contains them.
"""

import numpy as np
import pytest

import crankfem as cf
from comparing import close
from crankbase.quantity import RPM
from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.chain.chain_file import load_chain
from dynamics.assessment.barred_ranges import BarredRangeRule

PRINTED = (330.08, 502.10, 1872.20)
RATED = 99.0


def test_natural_frequencies(figure):
    found = 60.0 * load_chain("5rt-flex50d-plant").chain.modes().elastic_frequencies[:3]
    figure("first natural frequencies", found, PRINTED, 2e-4, "1/min")


def test_barred_range_of_the_rule(figure):
    n = 66.0
    r = n / RATED
    low, high = BarredRangeRule(RATED / RPM).bounds(n / RPM)
    figure("begin of the range by the rule", low * RPM, 16.0 * n / (18.0 - r), 1e-12, "1/min")
    figure("end of the range by the rule", high * RPM, (18.0 - r) * n / 16.0, 1e-12, "1/min")


@pytest.mark.further
def test_the_engine_has_the_chain_its_critical_speed_and_the_range(figure):
    engine = cf.load_engine("5rt-flex50d")
    coarse = cf.analyze_throw(engine.throw, engine.material, 0.1)
    run = engine_vibration(engine, analysis=coarse)
    found = 60.0 * run.torsional.chosen.elastic_frequencies[:3]
    figure("first natural frequencies of the engine", found, PRINTED, 2e-4, "1/min")
    (fifth,) = (one for one in run.torsional.criticals if (one.order, one.mode) == (5, 1))
    figure("critical speed of order 5", fifth.speed_rpm, 66.0, 1e-3, "1/min")
    assert fifth.kind == "major"
    assert run.assessment is not None
    (barred,) = run.assessment.verdict.barred
    assert barred.allowed
    # Damping puts the peak a little higher; the rule is applied there.
    (peak,) = barred.peaks
    assert peak * RPM == close(66.0, rel=0.03)
    low, high = BarredRangeRule(RATED / RPM).bounds(peak)
    assert barred.low <= low * (1.0 + 1e-12)
    assert barred.high >= high * (1.0 - 1e-12)
    assert np.isclose(barred.low, low)
    # The maker's error is that of every stiffness of his chain, so that all frequencies go with its root.
    known = run.assessment.torsional
    (spread,) = known.spreads
    for name, factor in (("lowest", spread.high), ("highest", spread.low)):
        bound = np.array([getattr(mode, name) for mode in known.frequencies])
        wanted = np.array([mode.nominal for mode in known.frequencies]) / np.sqrt(factor)
        figure("bounds of all frequencies", bound, wanted, 1e-9, "Hz")
