"""The largest stresses at a throw's fillets and oil holes: results of `fillet_stresses`.

IACS UR M53, Appendix III, requires of a mesh and its stresses what is compared with the values reached:
at the fillets, within 90 degrees of the crank plane on the side of the overlap, elements measure a
quarter of the radius or less (a) along and around; three layers below are a, 2a and 3a thick; there are
six elements across the web. Where a stress is read the smallest principal stress is below 3 % of the
largest, and the values of single elements at the node are within 5 % of their mean. Second-order
tetrahedra are allowed; they are measured here by the side of the regular triangle of a facet's area, and
by the height of the regular tetrahedron of an element's volume, the mean of all.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.choices import check_choice
from crankbase.diagrams import draw_groups, new_axes, write_title
from crankbase.frames import grid, table
from crankbase.summaries import summarized
from fem.correction import stresses_at
from fem.surface_stress import (
    Fillet,
    largest_shear,
    principal_stresses,
    refine_at,
    surface_stress,
    von_mises,
)
from fem.unit_loads import LoadedThrow, UnitLoad, WholeNodes, whole_facets, whole_nodes
from geometry.drilling import DrillingExit
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.mesher import Throw
from geometry.parts import WebPlate
from geometry.shapes import EDGES, element_volumes, shapes_at_nodes
from geometry.sizes import SizeMap, element_sizes
from geometry.solid import CRANK_PLANE, FILLET, LEFT_END, MIDDLE_PLANE, OIL_HOLE, RIGHT_END

if TYPE_CHECKING:
    from matplotlib.axes import Axes


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
        layers = all(thickness <= most for thickness, most in zip(self.layers, LAYERS, strict=True))
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
    meshings = []
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
        meshings.append(
            FilletMeshing(fillet.name, size, size / fillet.radius, tuple(layers), across)
        )
    return tuple(meshings)


def reading_quality(loaded: LoadedThrow, node: int, load: int, *, shear: bool) -> ReadingQuality:
    """Agreement of the elements around a node on the stress there.

    Parameters
    ----------
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
    image, number = (int(found[0]) for found in np.nonzero(whole.numbers == node))
    element, place = (int(found[0]) for found in np.nonzero(mesh.elements == number))
    places = [place] if place < 4 else EDGES[place - 4]
    return np.asarray(whole.numbers[image, mesh.elements[element, places]])


def _single_stresses(loaded: LoadedThrow, node: int, load: int) -> Array:
    """Stress (e, 6) at a corner node of the whole throw by each element round it."""
    mesh, whole = loaded.mesh, whole_nodes(loaded.mesh)
    _, gradients = shapes_at_nodes()
    singles = []
    for image, numbers in zip(whole.images, whole.numbers, strict=True):
        element, corner = np.nonzero(np.isin(mesh.elements[:, :4], np.flatnonzero(numbers == node)))
        stress = stresses_at(
            image.points(mesh.points),
            mesh.elements[element],
            loaded.displacement(image)[:, :, load],
            loaded.material,
            gradients,
        )
        singles.append(stress[np.arange(len(element)), corner])
    return np.concatenate(singles)


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


# Surfaces where stresses are asked for, and those that are not free.
STRESSED = (FILLET, OIL_HOLE)
CUTS_AND_ENDS = (CRANK_PLANE, MIDDLE_PLANE, LEFT_END, RIGHT_END)


@dataclass(frozen=True)
class FilletSurface:
    """Nodes on the fillets and in the oil holes of a whole throw with their stresses.

    Attributes
    ----------
    nodes : (s,) array
        Their numbers by `fem.unit_loads.whole_nodes`.
    points : (s, 3) array
        [m]
    stress : (s, k, 6) array
        xx, yy, zz, xy, yz, zx under k loads [Pa].
    meshed : (s,) array of bool
        Which are on the meshed part itself, not only on its mirror images.
    normals : (s, 3) array
        Of the surface, outwards.
    """

    nodes: Integers
    points: Array
    stress: Array
    meshed: NDArray[np.bool_]
    normals: Array


def fillet_surface(loaded: LoadedThrow) -> FilletSurface:
    """Recover the stresses at fillets and oil holes of a loaded throw from the strains of the surface.

    The facets of the whole throw are used, so that points on a cut are treated like
    any other.
    """
    mesh = loaded.mesh
    facets, on_fillet = _facets_at_fillets(mesh)
    whole = whole_nodes(mesh)
    points = whole.collect([image.points(mesh.points) for image in whole.images])
    displacement = whole.collect([loaded.displacement(image) for image in whole.images])
    stresses = surface_stress(
        points,
        whole_facets(whole, facets),
        np.tile(on_fillet, len(whole.images)),
        displacement,
        loaded.material,
    )
    meshed = np.isin(stresses.nodes, whole.numbers[0])
    return FilletSurface(
        stresses.nodes, points[stresses.nodes], stresses.stress, meshed, stresses.normals
    )


def fillet_points(mesh: ThrowMesh) -> Array:
    """Nodes (p, 3) on the fillets and in the oil holes of a meshed part [m]."""
    corners = np.concatenate([mesh.surfaces[name] for name in STRESSED if name in mesh.surfaces])
    return np.asarray(mesh.points[np.unique(six_node_triangles(mesh, corners))])


def _facets_at_fillets(mesh: ThrowMesh) -> tuple[Integers, NDArray[np.bool_]]:
    """Facets (t, 6) on and next to fillets and oil holes, and which are on them."""
    free = [name for name in mesh.surfaces if name not in CUTS_AND_ENDS]
    corners = np.concatenate([mesh.surfaces[name] for name in free])
    kinds = [np.full(len(mesh.surfaces[name]), name in STRESSED) for name in free]
    on_fillet = np.concatenate(kinds)
    near = np.isin(corners, corners[on_fillet]).any(axis=1)
    return six_node_triangles(mesh, corners[near]), on_fillet[near]


Criterion = Literal["principal", "von Mises"]
LABELS: Mapping[Criterion, str] = {
    "principal": "largest principal / nominal stress [1]",
    "von Mises": "von Mises / nominal stress [1]",
}


@dataclass(frozen=True, kw_only=True)
class _Peak:
    """The largest stresses at one location under one unit load; see `FilletPeak`."""

    load: UnitLoad
    principal: float
    principal_place: Array
    principals: Array
    von_mises: float
    von_mises_place: Array
    shear: float
    shear_place: Array
    nominal: float
    error_estimate: float
    quality: ReadingQuality

    @property
    def factor(self) -> float:
        """Stress concentration factor: magnitude of the largest principal stress over the nominal one."""
        return abs(self.principal) / self.nominal

    @property
    def von_mises_factor(self) -> float:
        """Largest equivalent stress by von Mises divided by the nominal stress."""
        return self.von_mises / self.nominal

    @property
    def shear_factor(self) -> float:
        """Largest shear stress divided by the nominal stress."""
        return self.shear / self.nominal


@summarized(
    "fillet: fillet.name", "load: load.kind", "factor", "von_mises_factor", "error_estimate"
)
@dataclass(frozen=True, kw_only=True)
class FilletPeak(_Peak):
    """The largest stresses at one fillet under one unit load.

    If a throw is symmetric about the crank plane, the location with x >= 0 is given; its mirror image
    has the same stresses, under a torque or bending across the crank plane with the opposite sign.

    Attributes
    ----------
    principal : float
        Principal stress of the largest magnitude, with its sign [Pa/N or Pa/(N m)].
    principal_place : (3,) array
        Its location, in the throw frame [m].
    principals : (3,) array
        All principal stresses there, largest first; that across the free surface is 0.
    von_mises : float
        Largest equivalent stress by von Mises, same unit.
    von_mises_place : (3,) array
    shear : float
        Largest shear stress, half of the difference of the outer principal stresses, same unit.
    shear_place : (3,) array
    nominal : float
        Nominal stress, as `fem.fillet_stress` defines it; under a torque a shear stress.
    error_estimate : float
        Estimated relative error of the largest values.
    quality : ReadingQuality
        Agreement of the elements on the stress read by the rule.
    """

    fillet: Fillet

    @property
    def name(self) -> str:
        """Name of the fillet."""
        return self.fillet.name

    @property
    def rule_factor(self) -> float | None:
        """Factor as UR M53 defines it: by the largest shear stress under a torque, by von Mises in bending.

        None under loads that are not in the rule.
        """
        if self.load.kind == "torsion":
            return self.shear_factor
        return self.von_mises_factor if self.load.kind in RULE_LOADS else None


@summarized("exit: outlet.name", "load: load.kind", "factor", "von_mises_factor", "error_estimate")
@dataclass(frozen=True, kw_only=True)
class OilHolePeak(_Peak):
    """The largest stresses at one exit of an oil hole under one unit load.

    The exit is its rounding and the hole's wall to a depth of one diameter. The nominal stress is that of
    the pin or main journal without the hole.

    Attributes
    ----------
    outlet : DrillingExit
        Which exit.
    load, principal, principal_place, principals, von_mises, von_mises_place, shear, shear_place, nominal
        As in `FilletPeak`.
    error_estimate, quality
        As in `FilletPeak`.
    """

    outlet: DrillingExit

    @property
    def name(self) -> str:
        """For example "pin, oil hole 1 at 45 deg"."""
        return self.outlet.name

    @property
    def rule_factor(self) -> float | None:
        """Factor as UR M53 defines it, by the largest principal stress; None for loads not in the rule."""
        return self.factor if self.load.kind in ("torsion", "bending", "cross bending") else None


@summarized("peaks", "error_estimate", "accuracy", "sharp_corners")
@dataclass(frozen=True)
class FilletStresses:
    """Stresses at the fillets and at the exits of the oil holes of a throw.

    Attributes
    ----------
    peaks : tuple of FilletPeak
        For each load, the fillets from left to right.
    sharp_corners : tuple of str
        Corners without a fillet: the elastic stress there is unbounded, so there is no number.
    loaded : LoadedThrow
        The last mesh with its displacements.
    surface : FilletSurface
        Stresses over the fillets and oil holes.
    fineness : float
        Elements across the quarter circle of a fillet where it was refined last.
    accuracy : float
        The requested accuracy.
    mesh : {"adaptive", "m53"}
        The requested kind of mesh.
    hole_peaks : tuple of OilHolePeak
        For each load, the exits of the oil holes in their order.
    """

    throw: Throw
    peaks: tuple[FilletPeak, ...]
    sharp_corners: tuple[str, ...]
    loaded: LoadedThrow = field(repr=False)
    surface: FilletSurface = field(repr=False)
    fineness: float
    accuracy: float
    mesh: str = "adaptive"
    hole_peaks: tuple[OilHolePeak, ...] = ()

    @property
    def error_estimate(self) -> float:
        """Largest of the error estimates."""
        return max(peak.error_estimate for peak in (*self.peaks, *self.hole_peaks))

    @property
    def meshings(self) -> tuple[FilletMeshing, ...]:
        """Mesh size at the fillets on the meshed part, and the requirements of UR M53."""
        fillets = {peak.name: peak.fillet for peak in self.peaks}
        return fillet_meshings(self.loaded.mesh, list(fillets.values()))

    @property
    def rule_met(self) -> bool:
        """Whether the mesh, and the stresses under the loads of UR M53, meet its requirements."""
        read = [peak.quality.met for peak in self.peaks if peak.load.kind in RULE_LOADS]
        return all(read) and all(meshing.met for meshing in self.meshings)

    @property
    def accuracy_met(self) -> bool:
        """Whether all error estimates are within the requested accuracy."""
        return self.error_estimate <= self.accuracy

    def under(self, load: UnitLoad) -> tuple[FilletPeak, ...]:
        """Peaks under one load, the fillets from left to right."""
        return tuple(peak for peak in self.peaks if peak.load is load)

    def at_oil_holes(self, load: UnitLoad) -> tuple[OilHolePeak, ...]:
        """Peaks at the exits of oil holes under one load."""
        return tuple(peak for peak in self.hole_peaks if peak.load is load)

    @property
    def _all(self) -> list[FilletPeak | OilHolePeak]:
        """For each load, the fillets from left to right, then the exits of oil holes."""
        every: tuple[FilletPeak | OilHolePeak, ...] = (*self.peaks, *self.hole_peaks)
        loads = list({id(peak.load): None for peak in every})
        return sorted(every, key=lambda peak: loads.index(id(peak.load)))

    def plot(self, axes: "Axes | None" = None, *, criterion: Criterion = "principal") -> "Axes":
        """Draw the stress concentration factors, a color for each load.

        There is a group of bars for each fillet and for each exit of an oil hole.

        Parameters
        ----------
        criterion : {"principal", "von Mises"}
            Stress that is divided by the nominal one.

        Raises
        ------
        InputError
            If the criterion is neither.
        """
        check_choice("criterion", criterion, LABELS, "factors are made of these stresses")
        loads, fillets = self._names
        factors = self._array("factor" if criterion == "principal" else "von_mises_factor")
        axes = new_axes(axes, width=8.6)
        draw_groups(axes, fillets, dict(zip(loads, factors, strict=True)), LABELS[criterion])
        holes = " and oil holes" if self.hole_peaks else ""
        write_title(axes, f"Stress concentration at the fillets{holes}")
        return axes

    def to_pandas(self) -> Any:
        """Return a table with a row for each load and fillet, from left to right, and each oil hole's exit.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        peaks = self._all
        stress = "Pa/N or Pa/(N m), as the load's unit says"
        places = np.array([peak.principal_place for peak in peaks])
        units = dict.fromkeys(("factor", "von_mises_factor"), "1")
        units |= dict.fromkeys(("principal", "von_mises", "nominal"), stress)
        units["error_estimate"] = "1"
        return table(
            {
                "load": ([peak.load.name for peak in peaks], ""),
                "load_unit": ([peak.load.unit for peak in peaks], ""),
                "fillet": ([peak.name for peak in peaks], ""),
            }
            | {
                name: ([getattr(peak, name) for peak in peaks], unit)
                for name, unit in units.items()
            }
            | {axis: (column, "m") for axis, column in zip("xyz", places.T, strict=True)}
        )

    def to_xarray(self) -> Any:
        """Return factors and their errors over loads and fillets, the exits of oil holes among these.

        Returns
        -------
        xarray.Dataset
            ``factor``, ``von_mises_factor`` and ``error_estimate`` (load, fillet).

        Raises
        ------
        MissingLibraryError
            If xarray is not installed.
        """
        words = {
            "factor": "largest principal stress by the nominal one",
            "von_mises_factor": "largest equivalent stress by the nominal one",
            "error_estimate": "estimated relative error of both",
        }
        loads, fillets = self._names
        return grid(
            {
                name: (("load", "fillet"), self._array(name), "1", text)
                for name, text in words.items()
            },
            {"load": (loads, "", "unit load"), "fillet": (fillets, "", "fillet")},
        )

    @property
    def _names(self) -> tuple[list[str], list[str]]:
        """Names of loads and fillets, in the order of the peaks."""
        loads = dict.fromkeys(peak.load.name for peak in self._all)
        return list(loads), list(dict.fromkeys(peak.name for peak in self._all))

    def _array(self, name: str) -> Array:
        """An attribute of the peaks (loads, fillets)."""
        values = np.array([getattr(peak, name) for peak in self._all], dtype=np.float64)
        return values.reshape(len(self._names[0]), -1)
