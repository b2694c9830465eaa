"""The superelement from the forces on its ends, beside that from energies and mean motions.

Solutions leave a residual near 1e-14 of their right side; what is made of a few of them agrees to
1e-11.
"""

import numpy as np
import pytest

from crankfem.analyses.throw.throw_record import reciprocity_record
from fem.analysis import analyze_throw
from fem.superelement import superelement_of_end_forces
from geometry.throw import CrankThrow

ROUND_OFF = 1e-11

DIMENSIONS = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.135,
    "pin_length": 0.139,
    "web_width": 0.285,
    "web_thickness": 0.068,
}


def beside(one, other):
    return np.max(np.abs(one - other)) / np.max(np.abs(other))


@pytest.mark.slow
@pytest.mark.parametrize("end_sections", ["rigid", "averaged"])
@pytest.mark.parametrize("left_web", [None, {"thickness": 0.05}], ids=["equal webs", "unequal"])
def test_both_ways_to_the_superelement_agree(end_sections, left_web):
    throw = CrankThrow(**(DIMENSIONS | {"left_web": left_web}))
    found = analyze_throw(throw, accuracy=0.1, end_sections=end_sections).discrete
    own = found.superelement
    other = superelement_of_end_forces(found.classes, own.radials)
    assert beside(other.stiffness, own.stiffness) < ROUND_OFF
    assert beside(other.pin_loads, own.pin_loads) < ROUND_OFF
    # They are two calculations, not one.
    assert not np.array_equal(other.pin_loads, own.pin_loads)
    assert all(0.0 < figure < ROUND_OFF for figure in reciprocity_record(found).values())
