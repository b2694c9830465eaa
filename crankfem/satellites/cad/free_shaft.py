"""Natural vibration of a crankshaft from CAD, free in space as in a hammer test, with all beyond its cuts."""

from collections.abc import Callable, Mapping

import numpy as np

from crankfem.analyses.shaft.whole_shaft import shaft_throws
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.shaft_modes import ShaftModes, crankshaft_modes
from dynamics.crankshaft.surroundings import EndBody, ShaftSurroundings
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.material import STEEL, Material
from geometry.imported import ImportedThrow
from geometry.imported_shaft import EndPart, ImportedCrankshaft

# Superelements are made for so many times the highest frequency that static ones give.
ABOVE = 1.2
Analyses = Mapping[ImportedThrow, ThrowAnalysis]


def free_modes(
    shaft: ImportedCrankshaft,
    known: Analyses,
    count: int = 5,
    accuracy: float = 0.01,
    material: Material = STEEL,
    tell: Callable[[str], None] = lambda _: None,
) -> ShaftModes:
    """Find the lowest modes of the whole crankshaft from superelements of its throws and end parts.

    Parameters
    ----------
    known : mapping
        Analyses of throws, and of the end parts, which are rigid without them.
    count : int
        Of the elastic modes that must be right; higher ones follow.
    accuracy : float
        Of the compliances of further throws: those that turn a known one end for end, or mirror it.
    tell : callable
        Called with the name of each step.

    Raises
    ------
    InputError, MeshError, SolveError
        If a throw cannot be analyzed.
    """
    analyses = dict(known)
    for number, throw in enumerate(shaft.throws, start=1):
        if throw not in analyses:
            tell(f"Analyzing throw {number}")
            analyses[throw] = analyze_throw(throw, material, accuracy)
    tell("Finding the free modes")
    free, flange = shaft.ends
    row = list(zip(shaft.throws, shaft.angles_deg, strict=True))
    if free is not None and free.part in analyses:
        row.insert(0, (free.part, 0.0))
    if flange is not None and flange.part in analyses:
        row.append((flange.part, 0.0))
    around = ShaftSurroundings(
        free_end=_rigid(free, analyses, material, shaft.starts[0]),
        flywheel=_rigid(flange, analyses, material, shaft.starts[-1]),
    )
    highest = 0.0
    for _ in range(2):
        elements = {part: analyses[part].dynamic_superelement(highest) for part, _ in row}
        rings = (elements[throw].sections for throw in shaft.throws)
        widest = max(rings, key=lambda ring: (ring.radius, ring.bore))
        pieces = [
            piece
            for part, angle in row
            for piece in shaft_throws(
                elements[part].shared_with(widest), part, crank_angles_deg=[angle]
            )
        ]
        modes = crankshaft_modes(assemble_crankshaft(pieces, around))
        highest = ABOVE * float(modes.frequencies[modes.rigid + count - 1])
    return modes


def _rigid(
    end: EndPart | None, analyses: Analyses, material: Material, section: float
) -> EndBody | None:
    """Return an end part that has no superelement."""
    if end is None or end.part in analyses:
        return None
    masses = end.masses(material.density)
    across = float(np.trace(masses.inertia[:2, :2])) / 2.0
    overhang = abs(float(masses.center[2]) - section)
    return EndBody(masses.mass, masses.inertia_about_shaft, across, overhang)
