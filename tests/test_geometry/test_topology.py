"""The topology of throws by their parts, against the faces, edges and corners of their solids."""

import pytest

from geometry.mesh import built_solid
from geometry.throw import CrankThrow
from geometry.topology import topology
from throws import MEDIUM_SPEED

BORED = MEDIUM_SPEED | {
    "main_journal_bore": 0.08,
    "pin_bore": 0.07,
    "pin_bore_offset": 0.012,
    "web_tip_thickness": 0.055,
}
WEIGHTED = MEDIUM_SPEED | {
    "web_foot_thickness": 0.05,
    "counterweight": {"outer_radius": 0.26, "inner_radius": 0.125, "angle": 2.0, "thickness": 0.06},
}


def counts(throw):
    """Faces, edges and corners of the solid that is meshed."""
    with built_solid(throw.parts, throw.symmetry) as built:
        return tuple(len(built.gmsh.model.getEntities(dimension)) for dimension in (2, 1, 0))


@pytest.mark.parametrize(
    "fields", [MEDIUM_SPEED, BORED, WEIGHTED], ids=["plain", "bored", "weighted"]
)
def test_small_changes_keep_the_topology(fields):
    throw = CrankThrow(**fields)
    for name in ("web_width", "pin_length", "crank_radius"):
        assert topology(throw.changed(**{name: 1.01 * fields[name]})) == topology(throw), name


@pytest.mark.parametrize(
    ("fields", "changes"),
    [
        # The bore reaches out of the part of the web that is thinned.
        (BORED, {"pin_bore_offset": -0.02}),
        # The web's straight sides end where both of its round ends are as wide as it is.
        (MEDIUM_SPEED, {"web_pin_end": 0.16}),
        (MEDIUM_SPEED, {"fillet_radius": 0.0}),
        # The counterweight ends inside the web's outline, or beyond it.
        (WEIGHTED, {"counterweight": {"outer_radius": 0.15, "angle": 2.0}}),
        (WEIGHTED, {"right_web": {"thickness": 0.08}}),
    ],
)
def test_other_solids_have_another_topology(fields, changes):
    throw = CrankThrow(**fields)
    other = throw.changed(**changes)
    assert counts(other) != counts(throw)
    assert topology(other) != topology(throw)
