"""Dimensions of a throw from CAD, if one of dimensions is as compliant and as heavy."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from crankbase.array_checks import Array
from crankbase.errors import InputError, MeshError, SolveError
from fem.analysis import ThrowAnalysis, analyze_throw
from fem.whole_throw import whole_nodes, whole_points
from geometry.parts import OUTLINES
from geometry.throw import CrankThrow
from geometry.throw_dimensions import Counterweight

# Of axial and torsional compliance and mass.
LARGEST_DIFFERENCE = 0.01
# Webs reach less than this times half of their width behind the shaft, counterweights further.
COUNTERWEIGHT = 1.05
SMALLEST_SECTOR, LARGEST_SECTOR = math.radians(20.0), math.radians(178.0)


def dimensions_text(analysis: ThrowAnalysis, accuracy: float) -> str:
    """Return the dimensions of an imported throw as lines of an engine file; "" if none describe it.

    Parameters
    ----------
    accuracy : float
        Of the axial compliance of the throw of dimensions.
    """
    throw = None if len(analysis.throw.parts.pins) > 1 else _fitted(analysis)
    try:
        same = throw is not None and _is_alike(
            analysis, analyze_throw(throw, analysis.material, accuracy)
        )
    except (InputError, MeshError, SolveError):
        same = False
    if throw is None or not same:
        return ""
    lengths = throw.model_fields_set - {"counterweight", "web_outline"}
    lines = [f'{name} = "{1e3 * getattr(throw, name):.6g} mm"' for name in sorted(lengths)]
    lines.append(f'web_outline = "{throw.web_outline}"')
    if throw.counterweight is not None:
        radius, angle = throw.counterweight.outer_radius, throw.counterweight.angle
        weight = f'outer_radius = "{1e3 * radius:.6g} mm", angle = "{math.degrees(angle):.5g} deg"'
        lines.append(f"counterweight = {{ {weight} }}")
    return "\n".join(lines)


def _is_alike(solid: ThrowAnalysis, other: ThrowAnalysis) -> bool:
    ratios = (
        other.axial_compliance() / solid.axial_compliance(),
        other.torsional_compliance() / solid.torsional_compliance(),
        other.masses.mass / solid.masses.mass,
    )
    return max(abs(ratio - 1.0) for ratio in ratios) < LARGEST_DIFFERENCE


def _fitted(analysis: ThrowAnalysis) -> CrankThrow | None:
    """Measure a throw of one pin and two equal webs; of its outlines that with the nearest volume."""
    part, mesh = analysis.throw, analysis.mesh
    volume = analysis.masses.mass / analysis.material.density
    points = whole_points(mesh, whole_nodes(mesh))
    left, pin, right = part.parts.cylinders
    webs = [(before.end, after.start) for before, after in pairwise((left, pin, right))]
    widths, tips, feet, radii = zip(
        *(_reach(points, web, part.crank_radius) for web in webs), strict=True
    )
    width, tip, foot, radius = (float(np.mean(each)) for each in (widths, tips, feet, radii))
    dimensions = {
        "crank_radius": part.crank_radius,
        "main_journal_diameter": part.main_journal_diameter,
        "pin_diameter": part.pin_diameter,
        "main_journal_length": part.main_journal_length,
        "pin_length": part.pin_length,
        "web_width": width,
        "web_thickness": 0.5 * sum(end - start for start, end in webs),
        "web_pin_end": tip,
        "main_journal_fillet_radius": left.end_fillet,
        "pin_fillet_radius": pin.start_fillet,
    }
    bores = {"main_journal_bore": part.main_journal_bore, "pin_bore": part.pin_bore}
    dimensions |= {name: bore for name, bore in bores.items() if bore > 0.0}
    if foot <= COUNTERWEIGHT * 0.5 * width:
        dimensions["web_journal_end"] = foot
    made: list[CrankThrow] = []
    for outline in OUTLINES:
        try:
            made.append(_weighted({**dimensions, "web_outline": outline}, radius, volume))
        except (InputError, ValueError):  # it cannot be built, or no sector has the volume
            continue
    return min(made, key=lambda throw: abs(throw.volume - volume), default=None)


def _weighted(dimensions: dict[str, Any], radius: float, volume: float) -> CrankThrow:
    """Return a throw of the volume, by the angle of its counterweight if there is one."""
    if "web_journal_end" in dimensions:
        return CrankThrow(**dimensions)

    def throw_at(angle: float) -> CrankThrow:
        return CrankThrow(
            **dimensions, counterweight=Counterweight(outer_radius=radius, angle=angle)
        )

    angle = brentq(
        lambda at: throw_at(at).volume - volume, SMALLEST_SECTOR, LARGEST_SECTOR, xtol=1e-6
    )
    return throw_at(float(angle))


def _reach(
    points: Array, web: tuple[float, float], crank_radius: float
) -> tuple[float, float, float, float]:
    """Width of a web, how far it is beyond pin and shaft, and its largest radius behind the shaft [m]."""
    room = 1e-6 * crank_radius
    inside = points[(points[:, 2] > web[0] - room) & (points[:, 2] < web[1] + room)]
    between = inside[(inside[:, 1] > 0.0) & (inside[:, 1] < crank_radius)]
    behind = inside[inside[:, 1] < 0.0]
    return (
        float(np.ptp(between[:, 0])),
        float(inside[:, 1].max()) - crank_radius,
        -float(inside[:, 1].min()),
        float(np.hypot(behind[:, 0], behind[:, 1]).max()),
    )
