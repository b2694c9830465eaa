"""Throw and crankshaft in three dimensions, to turn: solid, mesh, deformation, stress at fillets, cuts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crankbase.array_checks import Array, Flags, Integers
from crankbase.quantity import UNITS, percent
from crankfem.analyses.throw.pictures.solid_picture import (
    THROW_COLORS,
    SolidSurface,
    cylinder_surface,
)
from crankfem.analyses.throw.pictures.stress_picture import (
    STRESS_SHOWN,
    load_title,
    outside_facets,
    stressed_surface,
    stretched_surface,
)
from crankfem.analyses.throw.pictures.stress_rendering import COLORS, eye_at
from crankfem.analyses.throw.stress import of_loads
from crankfem.report.interactive.plot import write_figure
from crankfem.report.interactive.style import (
    Figure,
    Part,
    choice,
    note,
    plain_layout,
    rounded,
    shortest,
)
from fem.analysis import ThrowAnalysis
from fem.fillet_peaks import FilletStresses
from fem.whole_throw import whole_facets, whole_nodes, whole_points
from geometry.any_throw import Throw
from geometry.crankshaft import Crankshaft
from geometry.mesh import SUBTRIANGLES

# An angle between faces that makes an edge [deg].
SHARP = 30.0


@dataclass(frozen=True, eq=False)
class TriangleSurface:
    """Triangles, counterclockwise from outside.

    Attributes
    ----------
    points : (n, 3) array
    triangles : (t, 3) array
    """

    points: Array
    triangles: Integers

    @property
    def face_normals(self) -> Array:
        """Normals (t, 3) of twice the triangles' area."""
        corners = self.points[self.triangles]
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    @property
    def point_normals(self) -> Array:
        """Unit normals (n, 3) of the points, those of their triangles weighted with the area."""
        summed = np.zeros_like(self.points)
        normals = self.face_normals
        for column in self.triangles.T:
            np.add.at(summed, column, normals)
        sizes = np.linalg.norm(summed, axis=1, keepdims=True)
        return np.asarray(summed / np.where(sizes > 0.0, sizes, 1.0))

    def edges(self) -> tuple[Integers, Integers, Flags]:
        """Edges between two triangles.

        Returns
        -------
        ends : (e, 2) array
            Points.
        sides : (e, 2) array
            Triangles on both sides.
        sharp : (e,) array of bool
            Whether they meet at more than the angle that makes an edge.
        """
        count = len(self.triangles)
        ends = np.sort(self.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        owners = np.repeat(np.arange(count), 3)
        order = np.lexsort((ends[:, 1], ends[:, 0]))
        same = np.flatnonzero(np.all(ends[order][1:] == ends[order][:-1], axis=1))
        first, second = order[same], order[same + 1]
        sides = np.column_stack([owners[first], owners[second]])
        normals = self.face_normals
        sizes = np.linalg.norm(normals, axis=1)
        cosines = np.sum(normals[sides[:, 0]] * normals[sides[:, 1]], axis=1)
        limit = np.cos(np.deg2rad(SHARP)) * sizes[sides[:, 0]] * sizes[sides[:, 1]]
        return ends[first], sides, cosines < limit

    def sharp_edges(self, shortest: float = 0.0) -> Integers:
        """Edges (s, 2) at which the surface bends sharply.

        Parameters
        ----------
        shortest : float
            Least length of what hangs together; dents of single elements are shorter.
        """
        ends, _, sharp = self.edges()
        edges = ends[sharp]
        pieces = _connected(edges, len(self.points))[edges[:, 0]]
        lengths = np.linalg.norm(np.subtract(*self.points[edges.T]), axis=1)
        return edges[np.bincount(pieces, lengths)[pieces] >= shortest] if len(edges) else edges

    def split_at_sharp_edges(self) -> tuple[Integers, Integers]:
        """Split the surface at sharp edges, so that shading does not round off its edges.

        Returns
        -------
        sources : (m,) array
            The point that each new point is a copy of.
        triangles : (t, 3) array
            Of new points.
        """
        count = len(self.triangles)
        _, sides, sharp = self.edges()
        patches = _connected(sides[~sharp], count)
        keys = self.triangles + len(self.points) * patches[:, None]
        unique, triangles = np.unique(keys, return_inverse=True)
        return unique % len(self.points), triangles.reshape(count, 3)


def _connected(pairs: Integers, count: int) -> Integers:
    """Return for each of some things the number of the group that pairs of them join."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def polylines(ends: Integers) -> list[list[int]]:
    """Join edges (e, 2) end to end to polylines, so that they are drawn in few strokes.

    Returns
    -------
    list of lists of points
        Each edge is in exactly one of them.
    """
    at: dict[int, list[int]] = {}
    pairs = ends.tolist()
    for number, pair in enumerate(pairs):
        for end in pair:
            at.setdefault(end, []).append(number)
    used = [False] * len(pairs)
    lines = []
    # Odd points first: strokes that begin there need not begin in their middle.
    for start in sorted(at, key=lambda point: len(at[point]) % 2 == 0):
        while True:
            trail, here = [start], start
            while True:
                waiting = at[here]
                while waiting and used[waiting[-1]]:
                    waiting.pop()
                if not waiting:
                    break
                number = waiting.pop()
                used[number] = True
                first, second = pairs[number]
                here = second if here == first else first
                trail.append(here)
            if len(trail) == 1:
                break
            lines.append(trail)
    return lines


# A triangle may turn so far when a point is taken away [cosine].
TURN = 0.95
# What a change of the values by their whole range, and a length, weigh beside a dent of the surface
# of the same size as the surface itself.
VALUE_WEIGHT, LENGTH_WEIGHT = 0.03, 1e-3


def decimate_triangles(surface: TriangleSurface, values: Array, most: int) -> TriangleSurface:
    """Take points away until few enough triangles are left, or no more can go unnoticed.

    Parameters
    ----------
    surface : TriangleSurface
        Closed.
    values : (n,) array
        Colors of the points: where they change steeply, points stay longer.
    most : int
        Triangles.

    Returns
    -------
    TriangleSurface
        With the points of the given one, of which some are not used any more.

    Notes
    -----
    A point is moved onto a neighbor and its two triangles beside that edge vanish, as in H. Hoppe,
    Progressive Meshes, SIGGRAPH 1996. Points on sharp edges stay.
    """
    points, triangles = surface.points, surface.triangles
    size = float(np.ptp(points, axis=0).max())
    weights = values * (VALUE_WEIGHT * size / max(float(np.ptp(values)), np.finfo(float).tiny))
    fixed = np.zeros(len(points), dtype=bool)
    fixed[surface.sharp_edges()] = True
    while len(triangles) > most:
        pairs, costs = _moves(TriangleSurface(points, triangles), weights, fixed)
        # Each takes two triangles with it.
        wanted = (len(triangles) - most + 1) // 2
        order = np.argsort(costs, kind="stable")
        goes = _independent_moves(pairs[order], triangles, len(points), wanted)
        triangles = goes[triangles]
        kept = np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)
        if kept.all():
            break
        triangles = triangles[kept]
    return TriangleSurface(points, triangles)


def _moves(surface: TriangleSurface, weights: Array, fixed: Flags) -> tuple[Integers, Array]:
    """Return from and to which point (m, 2) one may be moved, and what it costs (m,), one for a point."""
    points, triangles = surface.points, surface.triangles
    ends, _, _ = surface.edges()
    moves = np.concatenate([ends, ends[:, ::-1]])
    moves = moves[~fixed[moves[:, 0]]]
    if not len(moves):
        return moves, np.empty(0)
    # All triangles round each point, one point after the other.
    corners = triangles.ravel()
    sequence = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(points))
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    each = counts[moves[:, 0]]
    first = np.concatenate(([0], np.cumsum(each)[:-1]))
    inside = np.arange(each.sum()) - np.repeat(first, each)
    round_it = sequence[np.repeat(starts[moves[:, 0]], each) + inside] // 3
    source, target = (np.repeat(column, each) for column in moves.T)
    old = surface.face_normals[round_it]
    changed = np.where(triangles[round_it] == source[:, None], target[:, None], triangles[round_it])
    new = TriangleSurface(points, changed).face_normals
    sizes = np.linalg.norm(old, axis=1)
    cosines = np.sum(old * new, axis=1) - TURN * sizes * np.linalg.norm(new, axis=1)
    vanishes = np.any(triangles[round_it] == target[:, None], axis=1)
    allowed = np.logical_and.reduceat((cosines > 0.0) | vanishes, first)
    away = points[target] - points[source]
    dents = np.maximum.reduceat(np.abs(np.sum(old * away, axis=1)) / sizes, first)
    lengths = np.linalg.norm(points[moves[:, 1]] - points[moves[:, 0]], axis=1)
    costs = dents + LENGTH_WEIGHT * lengths + np.abs(np.subtract(*weights[moves.T]))
    moves, costs = moves[allowed], costs[allowed]
    order = np.lexsort((costs, moves[:, 0]))
    best = order[np.unique(moves[order, 0], return_index=True)[1]]
    return moves[best], costs[best]


def _independent_moves(moves: Integers, triangles: Integers, count: int, most: int) -> Integers:
    """Choose independent moves, cheapest first, and return where points go (n,)."""
    around: list[set[int]] = [set() for _ in range(count)]
    for a, b, c in triangles.tolist():
        around[a] |= {b, c}
        around[b] |= {a, c}
        around[c] |= {a, b}
    goes = np.arange(count)
    touched = [False] * count
    for source, target in moves.tolist():
        ring = around[source]
        # With more than two common neighbors the surface would touch itself.
        if touched[source] or len(ring & around[target]) != 2 or any(touched[k] for k in ring):
            continue
        goes[source] = target
        touched[source] = True
        for point in ring:
            touched[point] = True
        most -= 1
        if most == 0:
            break
    return goes


MILLI = 1e3
# Displacements are shown for 1 kN in µm.
DISPLACEMENT_SHOWN = UNITS["kN"][1] / UNITS["um"][1]
# The largest displacement is drawn as this share of the throw's length.
DRAWN_DISPLACEMENT = 0.06
STEEL_COLOR, FEATURE_COLOR, MESH_COLOR = "#b9c4d0", "#2a3644", "#33475b"
# The edges of a six-node triangle: corner, middle, corner.
EDGE_PATHS = ((0, 3, 1), (1, 4, 2), (2, 5, 0))
# Loads whose stresses can be chosen.
STRESS_LOADS = ("radial", "torsion")
# What a file of 1.5 MB has room for.
MOST_TRIANGLES, MOST_STRESSED, MOST_EDGES = 14_500, 14_000, 7_500
# Lines lie above the faces by this share of the throw's size, so that these do not cover them.
LIFT = 0.0015
# An edge's middle counts if it lies beside the straight line by this share of the throw's size.
BENT = 5e-4
# From the middle to the eye: the main journals' axis runs to the right and away.
EYE, EYE_DISTANCE = np.array([1.0, 0.35, -0.55]), 2.0
# Of the lengths in which the browser counts, the scene shows about two; the throw takes up so many.
TAKEN = 1.65
MARGIN = 0.01  # of the throw's size, round all that is drawn
LIGHTING = {"ambient": 0.6, "diffuse": 0.55, "specular": 0.12, "roughness": 0.6, "fresnel": 0.05}
LIGHT = {"x": 6e4, "y": 1e5, "z": -3e4}
# Lines of the solid are left out below this share of the throw's size.
SHORTEST = 0.25
HEIGHT = 560
PLACE = "x %{x:.4g}, y %{y:.4g}, z %{z:.4g} mm"
FILE, SHAFT_FILE = "throw_view.json", "shaft_view.json"
# Rings round cuts stand out by this factor.
RING, RING_POINTS = 1.03, 61


def throw_view(
    folder: Path, analysis: ThrowAnalysis, stresses: FilletStresses | None = None
) -> Path:
    """Write the throw in three dimensions into a folder.

    Parameters
    ----------
    folder : Path
        That is there.
    stresses : FilletStresses, optional
        Of the same throw; without them there are no views of stress.

    Returns
    -------
    Path
        ``throw_view.json``.
    """
    return write_figure(folder / FILE, *throw_figure(analysis, stresses))


def shaft_view(folder: Path, shaft: Crankshaft, analyses: Sequence[ThrowAnalysis]) -> Path:
    """Write a crankshaft in three dimensions into a folder: throws in colors, cuts as rings.

    Parameters
    ----------
    folder : Path
        That is there.
    analyses : sequence of ThrowAnalysis
        Of each crank's throw.

    Returns
    -------
    Path
        ``shaft_view.json``.
    """
    return write_figure(folder / SHAFT_FILE, *shaft_figure(shaft, analyses))


def shaft_figure(shaft: Crankshaft, analyses: Sequence[ThrowAnalysis]) -> Figure:
    """Draw a crankshaft: a surface for each throw and end, and a line for all cuts."""
    most = MOST_TRIANGLES // len(analyses)
    made: dict[Throw, tuple[Array, Integers]] = {}
    solids: list[tuple[str, str, Array, Integers]] = []
    for number, (throw, analysis, angle, start) in enumerate(
        zip(shaft.throws, analyses, shaft.crank_angles_deg, shaft.starts.tolist(), strict=False)
    ):
        if throw not in made:
            whole = whole_nodes(analysis.mesh)
            corners = whole_facets(whole, outside_facets(analysis.mesh))[:, :3]
            surface = TriangleSurface(whole_points(analysis.mesh, whole), corners)
            values = np.zeros(len(surface.points))
            sources, triangles = decimate_triangles(surface, values, most).split_at_sharp_edges()
            made[throw] = surface.points[sources], triangles
        points, triangles = made[throw]
        place = SolidSurface(points, triangles, np.empty(0, dtype=np.int64)).moved(
            math.radians(angle), start
        )
        color = THROW_COLORS[number % len(THROW_COLORS)]
        solids.append((f"throw {number + 1}", color, place.points, triangles))
    for cylinder in shaft.end_cylinders:
        end = cylinder_surface(*cylinder)
        solids.append(("end", STEEL_COLOR, end.points, end.triangles))
    size = MILLI * float(np.ptp(np.concatenate([points for _, _, points, _ in solids])[:, 2]))
    traces = [
        _solid(MILLI * points, triangles, size, name=name, color=color, hover=f"{name}<br>{PLACE}")
        for name, color, points, triangles in solids
    ]
    turns = np.linspace(0.0, 2.0 * math.pi, RING_POINTS)
    radius = RING * MILLI * 0.5 * max(throw.main_journal_diameter for throw in shaft.throws)
    rings = [
        np.column_stack([radius * np.cos(turns), radius * np.sin(turns), np.full_like(turns, z)])
        for z in MILLI * shaft.starts
    ]
    strokes = np.arange(len(rings) * RING_POINTS).reshape(len(rings), -1).tolist()
    drawn = np.concatenate(rings)
    traces.append(_lines(drawn, strokes, size, FEATURE_COLOR, 4.0, "cuts"))
    view = _View("shaft", tuple(range(len(traces))), "rings: where the shaft is cut into throws")
    layout = _layout(traces, [view], MILLI * np.concatenate([points for _, _, points, _ in solids]))
    return traces, {name: part for name, part in layout.items() if name != "updatemenus"}


@dataclass(frozen=True)
class _View:
    """One of the views: which traces it shows, and what they are colored by."""

    label: str
    traces: tuple[int, ...]
    caption: str
    intensity: list[float | int | None] | None = None
    largest: float = 1.0
    bar: str = ""


def throw_figure(analysis: ThrowAnalysis, stresses: FilletStresses | None = None) -> Figure:
    """Draw the throw in several views, one of which a menu chooses.

    Returns
    -------
    traces : list of dict
        Solid, its sharp edges, element edges (none where there are too many to carry), the deformed
        solid and, with stresses, one surface for all loads.
    layout : dict
        Each array is in the file once: colors come with the menu's choice.
    """
    stretched = stretched_surface(analysis)
    points, displacement = MILLI * stretched.points, stretched.values
    flat = [stretched.facets[:, list(corners)] for corners in SUBTRIANGLES]
    surface = TriangleSurface(points, np.concatenate(flat))
    sizes = np.linalg.norm(displacement, axis=1)
    size = float(np.ptp(points, axis=0).max())
    lifted = points + LIFT * size * surface.point_normals
    features = polylines(surface.sharp_edges(SHORTEST * size))
    sources, triangles = decimate_triangles(surface, sizes, MOST_TRIANGLES).split_at_sharp_edges()
    scale = DRAWN_DISPLACEMENT * float(np.ptp(points[:, 2])) / float(sizes[sources].max())
    moved = points + scale * displacement
    edges = np.concatenate([stretched.facets[:, list(path)] for path in EDGE_PATHS])
    # The ends of all element edges with the node in the middle, -1 where the edge is straight.
    first, middle, last = edges.T
    away = points[middle] - 0.5 * (points[first] + points[last])
    middle = np.where(np.linalg.norm(away, axis=1) > BENT * size, middle, -1)
    ends = np.sort(edges[:, [0, 2]], axis=1)
    middles = {(a, b): node for (a, b), node in zip(ends.tolist(), middle.tolist(), strict=True)}
    traces = [
        _solid(points[sources], triangles, size, name="solid", color=STEEL_COLOR),
        _lines(lifted, features, size, FEATURE_COLOR, 3.0, "sharp edges"),
    ]
    views = [_View("solid", (0, 1), "drag to turn; pinch, or click and scroll, to zoom")]
    if len(middles) <= MOST_EDGES:
        # Along element edges, through the middles of bent ones.
        strokes = []
        for trail in polylines(np.array(list(middles), dtype=np.int64).reshape(-1, 2)):
            stroke = trail[:1]
            for a, b in pairwise(trail):
                middle = middles[min(a, b), max(a, b)]
                stroke += [b] if middle < 0 else [middle, b]
            strokes.append(stroke)
        traces.append(_lines(lifted, strokes, size, MESH_COLOR, 1.2, "element edges"))
        mesh = analysis.mesh
        part = f" in the {mesh.part}, mirrored" if len(whole_nodes(mesh).images) > 1 else ""
        size_text = f"{len(mesh.elements)} tetrahedra with 10 nodes{part}; {mesh.unknowns} unknowns"
        views.append(_View("mesh", (0, len(traces) - 1), size_text))
    shown = DISPLACEMENT_SHOWN * sizes[sources]
    # In mm for 1 N; drawn against 1 kN.
    factor = scale / (MILLI * 1e3)
    hover = f"%{{intensity:.3g}} µm for 1 kN<br>{PLACE} as drawn"
    traces.append(_solid(moved[sources], triangles, size, name="deformed", hover=hover))
    views.append(
        _View(
            "deformed by an axial force",
            (1, len(traces) - 1),
            f"ends pinned; displacements under 1 kN drawn {float(f'{factor:.2g}'):,.0f} times their size, "
            "the lines show the throw without load",
            rounded(shown, 4),
            float(shown.max()),
            "displacement<br>[µm for 1 kN]",
        )
    )
    if stresses is not None:
        trace, more = _stress_views(stresses, len(traces))
        traces.append(trace)
        views += more
    return traces, _layout(traces, views, np.concatenate([points[sources], moved[sources]]))


def _layout(traces: list[Part], views: list[_View], points: Array) -> Part:
    """Return the layout, with a menu of all views and room for all points."""
    eye = eye_at(EYE)
    seen = points @ eye.plane
    # What lies beyond the ends of axes is cut off, lines above faces too.
    room = MARGIN * float(np.ptp(points, axis=0).max())
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    # One scale for all axes. Without perspective a scene is magnified by its lengths, not by the eye.
    lengths = TAKEN * (high - low) / float(np.ptp(seen, axis=0).max())
    axes = {
        f"{name}axis": {"visible": False, "range": [float(start), float(end)]}
        for name, start, end in zip("xyz", low, high, strict=True)
    }
    changes: list[list[Part]] = [
        [
            {  # colors are given to all traces, though one shows them
                "visible": [place in view.traces for place in range(len(traces))],
                "intensity": [view.intensity],
                "cmax": [view.largest],
                "colorbar.title.text": [view.bar],
            },
            {"annotations[0].text": view.caption},
        ]
        for view in views
    ]
    menu = choice("show", [view.label for view in views], changes)
    for place, trace in enumerate(traces):
        trace["visible"] = place in views[0].traces
    return plain_layout("", HEIGHT) | {
        "margin": {"l": 0, "r": 0, "t": 10, "b": 34},
        "showlegend": False,
        "scene": {
            **axes,
            "aspectmode": "manual",
            "aspectratio": _xyz(np.round(lengths, 5).tolist()),
            "dragmode": "orbit",
            "camera": {
                "eye": _xyz(np.round(EYE_DISTANCE * eye.towards, 4).tolist()),
                "up": _xyz((0, 1, 0)),
                "center": _xyz((0, 0, 0)),
                "projection": {"type": "orthographic"},
            },
        },
        "annotations": [
            note(
                views[0].caption, x=0.5, y=0.0, yshift=-8, xref="paper", yref="paper", yanchor="top"
            )
        ],
        "updatemenus": [
            menu | {"type": "buttons", "direction": "right", "x": 0.0, "xanchor": "left"}
        ],
    }


def _stress_views(stresses: FilletStresses, place: int) -> tuple[Part, list[_View]]:
    """Return the surface of the mesh that was made for the fillets, and a view for each load."""
    # The radial force first.
    loads = stresses.loaded.loads
    chosen = [
        column for kind in STRESS_LOADS for column, load in enumerate(loads) if load.kind == kind
    ]
    stressed = stressed_surface(of_loads(stresses, chosen))
    # Elements are small here: straight edges do.
    corners = stressed.facets[:, :3]
    points, equivalent = MILLI * stressed.points, stressed.values
    size = float(np.ptp(points, axis=0).max())
    # What is largest under any of the loads shall stay.
    relative = (equivalent / equivalent.max(axis=0)).max(axis=1)
    surface = decimate_triangles(TriangleSurface(points, corners), relative, MOST_STRESSED)
    sources, triangles = surface.split_at_sharp_edges()
    trace = _solid(
        points[sources],
        triangles,
        size,
        name="fillet stress",
        hover=f"%{{intensity:.3g}} MPa<br>{PLACE}",
    )
    shares = np.linspace(0.0, 1.0, len(COLORS)).tolist()
    trace["colorscale"] = [list(pair) for pair in zip(shares, COLORS, strict=True)]
    views = []
    for column, load in enumerate(loads[load_number] for load_number in chosen):
        largest = max(peak.von_mises for peak in stresses.under(load)) * STRESS_SHOWN
        shown = STRESS_SHOWN * equivalent[sources, column]
        views.append(
            _View(
                f"stress, {load.name}",
                (place,),
                f"{load_title(load)}; largest at a fillet "
                f"{largest:.3g} MPa, estimated error {percent(stresses.error_estimate, 2)} %",
                rounded(shown, 4),
                float(largest),
                f"von Mises stress<br>[MPa for 1 k{load.unit}]",
            )
        )
    return trace, views


def _solid(
    points: Array,
    triangles: Integers,
    size: float,
    *,
    name: str,
    color: str = "",
    hover: str = PLACE,
) -> Part:
    """Return a shaded surface, of one color or of the colors that its values will have."""
    colored: Part = (
        {"color": color}
        if color
        else {
            "colorscale": "Viridis",
            "cmin": 0,
            "colorbar": {
                "title": {"text": "", "font": {"size": 12}},
                "thickness": 14,
                "len": 0.7,
                "outlinewidth": 0,
                "tickfont": {"size": 12},
                "x": 1.0,
                "xanchor": "right",
            },
        }
    )
    return {
        "type": "mesh3d",
        "name": name,
        **_coordinates(points, size),
        **dict(zip("ijk", triangles.T.tolist(), strict=True)),
        "flatshading": False,
        "lighting": LIGHTING,
        "lightposition": LIGHT,
        "hovertemplate": f"{hover}<extra></extra>",
    } | colored


def _lines(
    points: Array, strokes: list[list[int]], size: float, color: str, width: float, name: str
) -> Part:
    """Return strokes through points, with gaps between them."""
    gap = np.full((1, 3), np.nan)
    if strokes:
        drawn = np.concatenate([part for stroke in strokes for part in (points[stroke], gap)])[:-1]
    else:
        drawn = np.empty((0, 3))
    return {
        "type": "scatter3d",
        "mode": "lines",
        "name": name,
        **_coordinates(drawn, size),
        "line": {"color": color, "width": width},
        "hoverinfo": "skip",
    }


def _coordinates(points: Array, size: float) -> Part:
    """Return x, y and z to a ten thousandth of the size's power of ten [mm]."""
    decimals = 4 - math.floor(math.log10(size))
    rows = np.round(points.T, max(0, decimals)).tolist()
    return _xyz([[shortest(value) for value in row] for row in rows])


def _xyz(values: Sequence[object]) -> Part:
    return dict(zip("xyz", values, strict=True))
