"""Reactions from a study's equations, for 50 fresh throws.

Source: finite elements of 50 throws drawn from the box of the 6chn25-34 study by another seed.

Tolerance: 1.5 % root mean square of the axial reaction (measured 0.1 to 0.3); bands hold 95 of 100
components.

The study is run and fitted again. Axial reactions are compared with lookups and their bands: ends pinned,
guided and between neighbors at 120 deg, under a radial force or (between neighbors) a tangential one. For
components of equilibrium alone 2e-5 of the load is allowed, the roundness of the mesh's pin.
"""

import numpy as np
import pytest

import crankfem as cf

THROWS = 50
RMS, BANDS, ROUND_PIN = 0.015, 0.95, 3e-5
LOAD = 1e5
CASES = {
    "ends pinned, radial force": ("pinned", (0.0, -LOAD, 0.0)),
    "ends guided, radial force": ("guided", (0.0, -LOAD, 0.0)),
    "neighbors at 120 deg, radial force": (cf.Neighbors(120.0, 120.0), (0.0, -LOAD, 0.0)),
    "neighbors at 120 deg, tangential force": (cf.Neighbors(120.0, 120.0), (LOAD, 0.0, 0.0)),
}


def components(found):
    ends = (found.left.force, found.left.moment, found.right.force, found.right.moment)
    return np.concatenate(ends)


@pytest.mark.further
@pytest.mark.slow
def test_reactions_of_fresh_throws(tmp_path, figure):
    model = cf.run_study("6chn25-34", tmp_path / "runs.sqlite").model
    base = cf.load_throw("6chn25-34")[0]
    rng = np.random.default_rng(20261122)
    looked_up, by_fe, bands = ({case: [] for case in CASES} for _ in range(3))
    for _ in range(THROWS):
        given = {name: float(rng.uniform(*ends)) for name, ends in model.ranges.items()}
        analysis = cf.analyze_throw(base.changed(**given))
        for case, (support, force) in CASES.items():
            found = model.reactions(force, support, **given)
            looked_up[case].append(components(found))
            by_fe[case].append(components(analysis.reactions(force, support)))
            bands[case].append(components(found.band))
    for case in CASES:
        found, wanted, band = (np.array(one[case]) for one in (looked_up, by_fe, bands))
        rms = float(np.sqrt(np.mean((found[:, 2] / wanted[:, 2] - 1.0) ** 2)))
        figure(f"axial reaction, root mean square error, {case}", rms, 0.0, RMS, kind="absolute")
        missed = 1.0 - float(np.mean(np.abs(found - wanted) <= band + ROUND_PIN * LOAD))
        figure(f"components outside their bands, {case}", missed, 0.0, 1.0 - BANDS, kind="absolute")
