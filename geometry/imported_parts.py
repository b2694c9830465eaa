"""The parts of a CAD throw for stresses at its fillets: journals, pins, sections of webs.

Journals, pins, fillets and bores are those recognized; a web is the gap between two of them, with the
width of the mesh at the height that nominal stresses refer to.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from geometry.facets import flat_triangles
from geometry.imported import ImportedThrow
from geometry.mesh import ThrowMesh
from geometry.outline import Line, Outline
from geometry.parts import Cylinder, ThrowParts, WebPlate

Array = NDArray[np.float64]


def imported_parts(throw: ImportedThrow, mesh: ThrowMesh) -> ThrowParts:
    """Parts of an imported throw.

    Parameters
    ----------
    throw : ImportedThrow
    mesh : ThrowMesh
        Of the throw; widths are measured on it.

    Returns
    -------
    ThrowParts
        Each web as a plate with the width that nominal stresses refer to.
    """
    corners = mesh.points[flat_triangles(mesh)]
    rows = list(pairwise(throw.cylinders))
    names = ["left web", *(f"web {number}" for number in range(2, len(rows))), "right web"]
    webs = tuple(
        _web(name, before, after, corners)
        for name, (before, after) in zip(names, rows, strict=True)
    )
    return ThrowParts(throw.cylinders, webs)


def _web(name: str, before: Cylinder, after: Cylinder, corners: Array) -> WebPlate:
    """Make a plate of what lies between two cylinders."""
    foot, tip = (before, after) if before.is_pin <= after.is_pin else (after, before)
    start, end = before.end, max(after.start, before.end)
    plate = WebPlate(name, start, end, foot.axis, tip.axis, Outline(()))
    middle = 0.5 * (foot.radius + plate.distance - tip.radius)
    height = min(max(middle, 0.0), plate.distance)
    half = 0.5 * _width(plate, height, corners)
    low, high = -foot.radius, plate.distance + tip.radius
    turns = ((0.0, low), (half, low), (half, high), (0.0, high))
    outline = Outline(tuple(Line(one, other) for one, other in pairwise(turns)))
    return WebPlate(name, start, end, foot.axis, tip.axis, outline)


def _width(web: WebPlate, height: float, corners: Array) -> float:
    """Distance of the outermost points of a surface (t, 3, 3) across a web, halfway through it [m]."""
    up = np.array([*web.direction, 0.0])
    across = np.array([up[1], -up[0], 0.0])
    local = corners - np.array([*web.foot, 0.5 * (web.start + web.end)]) - height * up
    u, first, second = local @ across, local @ up, local[..., 2]
    # Shares of the corners at the point that the line meets, of triangles that are not edge-on.
    shares = np.stack(
        [first[:, k - 2] * second[:, k - 1] - first[:, k - 1] * second[:, k - 2] for k in range(3)],
        axis=1,
    )
    total = shares.sum(axis=1)
    met = total != 0.0
    shares = shares[met] / total[met, None]
    at = np.sum(shares * u[met], axis=1)[(shares >= 0.0).all(axis=1)]
    return float(np.ptp(at)) if len(at) else 0.0
