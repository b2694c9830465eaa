"""Requirements of IACS UR M53, Appendix III, on a mesh and its stresses, and the values reached.

At the fillets, within 90 degrees of the crank plane on the side of the overlap, elements measure a quarter
of the radius or less (a) along and around; three layers below are a, 2a and 3a thick; there are six elements
across the web. Where a stress is read the smallest principal stress is below 3 % of the largest, and the
values of single elements at the node are within 5 % of their mean. Second-order tetrahedra are allowed; they
are measured here by the side of the regular triangle of a facet's area, and by the height of the regular
tetrahedron of an element's volume, the mean of all.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crankbase.summaries import summarized
from fem.fillets import Fillet, refine_at
from fem.recovery import stresses_at
from fem.surface_stress import largest_shear, principal_stresses, von_mises
from fem.unit_loads import LoadedThrow, WholeNodes, whole_nodes
from geometry.mesh import ThrowMesh
from geometry.parts import WebPlate
from geometry.shapes import EDGES, element_volumes, shapes_at_nodes
from geometry.sizes import SizeMap, element_sizes
from geometry.solid import FILLET

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Allowed: size beside the fillet's radius, layers beside a, elements across the web.
LARGEST_SIZE, LAYERS, ACROSS_WEB = 0.25, (1.0, 2.0, 3.0), 6.0
# Wished, so that the largest facet, not the mean one, is as small as allowed.
WISHED_SIZE = 0.18
# The mesher's elements come out up to a few percent larger than wished: so many are wished across the web.
WISHED_ACROSS = 6.3
# Of the largest stress: the smallest principal one, and by how much elements may differ.
LARGEST_NORMAL, LARGEST_SPREAD = 0.03, 0.05
# Height of a regular tetrahedron beside its edge.
HEIGHT = math.sqrt(2.0 / 3.0)
# Loads for which the rule has factors of fillets.
RULE_LOADS = ("torsion", "bending", "radial")
ON_SIDE = -1e-6  # of the journal's radius


@summarized("fillet", "size [m]", "size_share", "layers", "across_web", "met")
@dataclass(frozen=True)
class FilletMeshing:
    """Mesh size at a fillet and its web, and the requirements of UR M53, Appendix III.

    Attributes
    ----------
    fillet : str
        Name.
    size : float
        Largest element along and around the fillet, within 90 degrees of the crank plane [m].
    size_share : float
        `size` over the fillet's radius; a quarter is allowed.
    layers : (3,) tuple of float
        Mean height of the elements in each layer below over a quarter of the radius; 1, 2 and 3 are allowed.
    across_web : float
        Elements across the web's thickness; six are required.
    """

    fillet: str
    size: float
    size_share: float
    layers: tuple[float, ...]
    across_web: float

    @property
    def met(self) -> bool:
        """Whether the mesh is as fine as the rule requires."""
        layers = all(own <= most for own, most in zip(self.layers, LAYERS, strict=True))
        return self.size_share <= LARGEST_SIZE and layers and self.across_web >= ACROSS_WEB


@summarized("normal_share", "spread", "met")
@dataclass(frozen=True)
class ReadingQuality:
    """The two criteria of UR M53, Appendix III, for a stress read at a node.

    Attributes
    ----------
    normal_share : float
        Magnitude of the smallest principal stress over that of the largest, of the elements' mean stress;
        required is below 0.03.
    spread : float
        Largest difference of a single element's stress at the node from the mean one, relative to that; the
        equivalent stress that the rule uses. Required is at most 0.05.
    """

    normal_share: float
    spread: float

    @property
    def met(self) -> bool:
        """Whether both criteria are met."""
        return self.normal_share < LARGEST_NORMAL and self.spread <= LARGEST_SPREAD


def on_crank_side(fillet: Fillet, points: Array) -> NDArray[np.bool_]:
    """Which points (n, 3) lie within 90 degrees of the crank plane, where journal and pin overlap."""
    axis = np.array(fillet.journal.axis)
    far = math.dist(fillet.web.foot, axis) > math.dist(fillet.web.tip, axis)
    towards = np.array(fillet.web.direction) * (-1.0 if far else 1.0)
    return np.asarray((points[:, :2] - axis) @ towards > ON_SIDE * fillet.journal.radius)


def rule_sizes(
    sizes: SizeMap, webs: Sequence[WebPlate], places: Sequence[tuple[Fillet, Array]]
) -> SizeMap:
    """Limit the size of elements to that required by the rule.

    Parameters
    ----------
    sizes : SizeMap
    webs : sequence of WebPlate
    places : sequence of (Fillet, (p, 3) array)
        Fillets with points on them [m].
    """
    wished = sizes.sizes.copy()
    for web in webs:
        inside = _in_web(web, sizes.points)
        wished[inside] = np.minimum(wished[inside], (web.end - web.start) / WISHED_ACROSS)
    return refine_at(
        SizeMap(sizes.points, sizes.tetrahedra, wished),
        [
            (points[on_crank_side(fillet, points)], WISHED_SIZE * fillet.radius)
            for fillet, points in places
        ],
    )


def fillet_meshings(mesh: ThrowMesh, fillets: Sequence[Fillet]) -> tuple[FilletMeshing, ...]:
    """Measure a mesh at those fillets that are on the meshed part."""
    facets = mesh.points[mesh.surfaces[FILLET]]
    corners = mesh.elements[:, :4]
    places, heights = (
        mesh.points[corners].mean(axis=1),
        HEIGHT * element_sizes(mesh.points, corners),
    )
    volumes = element_volumes(mesh.points, mesh.elements)
    found = []
    for fillet in fillets:
        flat = facets.reshape(-1, 3)
        here = (fillet.holds(flat) & on_crank_side(fillet, flat)).reshape(-1, 3).all(axis=1)
        if not here.any():
            continue
        first, second, third = facets[here].transpose(1, 0, 2)
        areas = 0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1)
        size = float(np.sqrt(4.0 / math.sqrt(3.0) * areas.max()))
        step = LARGEST_SIZE * fillet.radius
        depth = _depth(fillet, places)
        layers, start = [], 0.0
        for thickness in LAYERS:
            off = np.abs(depth / step - (start + 0.5 * thickness)) / (0.5 * thickness)
            # On a coarse mesh the layer may hold no element's middle; then the nearest one counts.
            layers.append(float(heights[off <= max(1.0, off.min())].mean() / step))
            start += thickness
        web = _in_web(fillet.web, places)
        mean = float(volumes[web] @ heights[web] / volumes[web].sum())
        across = (fillet.web.end - fillet.web.start) / mean
        found.append(FilletMeshing(fillet.name, size, size / fillet.radius, tuple(layers), across))
    return tuple(found)


def reading_quality(loaded: LoadedThrow, node: int, load: int, *, shear: bool) -> ReadingQuality:
    """Agreement of the elements around a node on the stress there.

    Parameters
    ----------
    loaded : LoadedThrow
    node : int
        Of the whole throw, as `fem.unit_loads.whole_nodes` numbers them. Where it is the middle of an edge
        the worse of the two ends counts, since more elements meet there.
    load : int
        Number of the load.
    shear : bool
        Whether to use the half difference of principal stresses instead of von Mises.
    """
    measure = largest_shear if shear else von_mises
    shares, spreads = [], []
    for corner in _corners(loaded.mesh, whole_nodes(loaded.mesh), node):
        every = _single_stresses(loaded, corner, load)
        mean = every.mean(axis=0)
        sizes = np.abs(principal_stresses(mean))
        shares.append(sizes.min() / sizes.max())
        spreads.append(np.abs(measure(every) - measure(mean)).max() / measure(mean))
    return ReadingQuality(float(max(shares)), float(max(spreads)))


def _corners(mesh: ThrowMesh, whole: WholeNodes, node: int) -> Integers:
    """Numbers, in the whole throw, of a node that is a corner, or of the ends of the edge that it halves."""
    image, own = (int(found[0]) for found in np.nonzero(whole.numbers == node))
    element, place = (int(found[0]) for found in np.nonzero(mesh.elements == own))
    places = [place] if place < 4 else EDGES[place - 4]
    return np.asarray(whole.numbers[image, mesh.elements[element, places]])


def _single_stresses(loaded: LoadedThrow, node: int, load: int) -> Array:
    """Stress (e, 6) at a corner node of the whole throw by each element round it."""
    mesh, whole = loaded.mesh, whole_nodes(loaded.mesh)
    _, gradients = shapes_at_nodes()
    found = []
    for image, numbers in zip(whole.images, whole.numbers, strict=True):
        element, corner = np.nonzero(np.isin(mesh.elements[:, :4], np.flatnonzero(numbers == node)))
        stress = stresses_at(
            image.points(mesh.points),
            mesh.elements[element],
            loaded.displacement(image)[:, :, load],
            loaded.material,
            gradients,
        )
        found.append(stress[np.arange(len(element)), corner])
    return np.concatenate(found)


def _in_web(web: WebPlate, points: Array) -> NDArray[np.bool_]:
    """Which points (n, 3) are in a web's plate between foot and tip, counterweight left out."""
    along = (points[:, :2] - web.foot) @ np.array(web.direction)
    height = (along > web.outline.foot) & (along < web.outline.tip)
    reach = 1e-6 * (web.end - web.start)
    return np.asarray(
        height & (points[:, 2] > web.start - reach) & (points[:, 2] < web.end + reach)
    )


def _depth(fillet: Fillet, places: Array) -> Array:
    """Depth (n,) of points below the fillet's surface; infinite outside it."""
    journal, radius = fillet.journal, fillet.radius
    on_left = abs(fillet.start - journal.start) < abs(fillet.end - journal.end)
    center = fillet.end if on_left else fillet.start
    outwards = journal.radius + radius - np.linalg.norm(places[:, :2] - journal.axis, axis=1)
    along = (center - places[:, 2]) if on_left else (places[:, 2] - center)
    beside = (outwards < 0.0) | (along < 0.0) | ~on_crank_side(fillet, places)
    return np.where(beside, np.inf, np.hypot(outwards, along) - radius)
