"""Mesh a throw with second-order tetrahedra, and check the result.

The solid is built with the main journal's diameter as the unit of length. The kernel's tolerances are
lengths: so they are the same share of every throw, and throws that differ by their size alone get the
same mesh.
"""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError, MeshError
from crankbase.memory import check_memory
from crankbase.summaries import summarized
from geometry.gmsh_session import forget_array_types, gmsh_errors, gmsh_session, load_gmsh
from geometry.parts import ThrowParts, scaled_parts, throw_volume
from geometry.shapes import (
    EDGES,
    corner_quality,
    element_volumes,
    facet_keys,
    outer_facets,
    straighten_elements,
)
from geometry.sizes import SHARES, SizeMap, predict_unknowns, set_size_map, set_sizes, size_plan
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE, build_solid, part_end

if TYPE_CHECKING:  # the mesher's process does not load what reads dimensions
    from matplotlib.axes import Axes

    from geometry.throw import CrankThrow


# More unknowns than this are not tried: their factorization needs 20 GiB and minutes.
MOST_UNKNOWNS = 1_500_000
# That the mesher takes for each unknown, beside the solid [byte].
MESHING_MEMORY = 1e3
# The mesh may differ from the solid by this share of the volume, the solid from its description.
MESH_VOLUME_TOLERANCE = 1e-3
SOLID_VOLUME_TOLERANCE = 1e-5
# The kernel's roundings of exits of oil holes are off by up to 2 % of what they take.
ROUNDING_TOLERANCE = 0.05
# Mean ratio of the flattest tetrahedron.
SMALLEST_QUALITY = 1e-3


@dataclass(frozen=True)
class SolidProperties:
    """Properties of the meshed solid by the kernel.

    Attributes
    ----------
    volume : float
        [m^3]
    center : (3,) array
        Center of volume [m].
    second_moments : (3, 3) array
        Integral of x_i x_j over the volume about its center [m^5].
    """

    volume: float
    center: NDArray[np.float64]
    second_moments: NDArray[np.float64]

    def scaled(self, factor: float) -> "SolidProperties":
        """Return those of a solid scaled by a factor."""
        return SolidProperties(
            self.volume * factor**3, self.center * factor, self.second_moments * factor**5
        )

    def turned(self, turn: float, shift: float) -> "SolidProperties":
        """Return those of a solid turned about z [rad], then moved along it [m]."""
        cosine, sine = math.cos(turn), math.sin(turn)
        turning = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        center = turning @ self.center + np.array([0.0, 0.0, shift])
        return SolidProperties(self.volume, center, turning @ self.second_moments @ turning.T)


def check_budget(expected: int, size_factor: float) -> None:
    """Refuse a mesh of too many expected unknowns, for any computer or for the free memory."""
    check_memory(
        MESHING_MEMORY * expected,
        f"size_factor: given {size_factor:.3g}, whose mesh of about {expected:,} unknowns takes",
        "ask for a larger one",
    )
    if expected > MOST_UNKNOWNS:
        raise InputError(
            f"size_factor: given {size_factor:.3g}, which would make about {expected:,} unknowns; allowed "
            f"are {MOST_UNKNOWNS:,}, because solving more takes minutes and 20 GB."
        )


def solid_properties(gmsh: Any) -> SolidProperties:
    """Volume, center and second moments of all volumes in the model, which should be one."""
    tags = [tag for _, tag in gmsh.model.getEntities(3)]
    if len(tags) != 1:
        raise MeshError(f"the parts of the throw did not unite to one solid but to {len(tags)}.")
    return properties_of(gmsh, tags[0])


def properties_of(gmsh: Any, tag: int) -> SolidProperties:
    """Volume, center and second moments of one volume in the model, in its unit of length."""
    volume = float(gmsh.model.occ.getMass(3, tag))
    center = np.array(gmsh.model.occ.getCenterOfMass(3, tag))
    inertia = np.array(gmsh.model.occ.getMatrixOfInertia(3, tag)).reshape(3, 3)
    return SolidProperties(volume, center, 0.5 * np.trace(inertia) * np.eye(3) - inertia)


def check_solid(parts: ThrowParts, part: str, solid: SolidProperties) -> None:
    """Refuse a solid that differs from its description: boolean operations may lose a part silently.

    Raises
    ------
    MeshError
    """
    expected = SHARES[part] * throw_volume(parts)
    rounded = sum(outlet.rounding_volume for hole in parts.drillings for outlet in hole.exits)
    off = SOLID_VOLUME_TOLERANCE * expected + ROUNDING_TOLERANCE * SHARES[part] * rounded
    if abs(solid.volume - expected) > off:
        raise MeshError(
            f"the solid has a volume of {solid.volume:.8g} m^3, its parts {expected:.8g} m^3."
        )


def check_quality(points: NDArray[np.float64], elements: NDArray[np.int64]) -> None:
    """Refuse a mesh with an element so flat that solving loses digits.

    Raises
    ------
    MeshError
    """
    worst = float(np.abs(corner_quality(points, elements)).min())
    if worst < SMALLEST_QUALITY:
        raise MeshError(
            f"an element is flat: its mean ratio is {worst:.1e}, below {SMALLEST_QUALITY:g}."
        )


def check_volume(
    points: NDArray[np.float64], elements: NDArray[np.int64], solid: SolidProperties
) -> None:
    """Refuse a mesh that does not have the solid's volume.

    Raises
    ------
    MeshError
    """
    volume = float(element_volumes(points, elements).sum())
    if not math.isclose(volume, solid.volume, rel_tol=MESH_VOLUME_TOLERANCE):
        raise MeshError(
            f"the mesh has a volume of {volume:.6g} m^3, the solid {solid.volume:.6g} m^3: "
            "they differ by more than 0.1 %."
        )


Options = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class BuiltSolid:
    """A throw, or the part of it required by its symmetry, in the current gmsh model.

    Attributes
    ----------
    unit : float
        Length of 1 in the model [m].
    parts : ThrowParts
        The parts of the model, in its unit.
    last : float
        Where it ends along z.
    surfaces : dict
        Surface tags by surface name.
    solid : SolidProperties
        In SI units.
    seconds : float
        Time to build it, 0 if it was kept.
    """

    gmsh: Any
    unit: float
    parts: ThrowParts
    last: float
    surfaces: dict[str, list[int]]
    solid: SolidProperties
    seconds: float


class SolidKeeper:
    """Opens solids, one at a time, and keeps the last one open if told to.

    Attributes
    ----------
    keeps : bool
        Whether it does; by default, nothing stays open.
    """

    def __init__(self) -> None:
        self.keeps = False
        self._session = ExitStack()
        self._key: tuple[ThrowParts, str, Options] | None = None
        self._gmsh: Any = None
        self._surfaces: dict[str, list[int]]
        self._solid: SolidProperties

    def close(self) -> None:
        """Release the kept solid."""
        self._key = None
        self._session.close()

    @contextmanager
    def opened(self, parts: ThrowParts, part: str, options: Options = ()) -> Iterator[BuiltSolid]:
        """Open the solid of a part of a throw, built with options of gmsh, its model without a mesh.

        Raises
        ------
        MeshError
            If the kernel lost a part, or did not unite all parts.
        """
        begin, seconds = time.perf_counter(), 0.0
        unit = 2.0 * parts.cylinders[0].radius
        key = (scaled_parts(parts, 1.0 / unit), part, options)
        try:
            if key != self._key:
                self.close()
                self._build(*key)
                check_solid(parts, part, self._solid.scaled(unit))
                self._key, seconds = key, time.perf_counter() - begin
            yield BuiltSolid(
                gmsh=self._gmsh,
                unit=unit,
                parts=key[0],
                last=part_end(key[0], part),
                surfaces=self._surfaces,
                solid=self._solid.scaled(unit),
                seconds=seconds,
            )
            if self.keeps:
                self._remove_mesh()
        except BaseException:
            self.close()
            raise
        if not self.keeps:
            self.close()

    def _build(self, parts: ThrowParts, part: str, options: Options) -> None:
        self._gmsh = self._session.enter_context(gmsh_session("throw"))
        for option, value in options:
            self._gmsh.option.setNumber(option, value)
        self._surfaces = build_solid(self._gmsh, parts, part)
        self._solid = solid_properties(self._gmsh)
        self._views = set(self._gmsh.view.getTags())

    def _remove_mesh(self) -> None:
        """Remove the mesh and its size fields."""
        self._gmsh.model.mesh.clear()
        for field in self._gmsh.model.mesh.field.list():
            self._gmsh.model.mesh.field.remove(field)
        for view in set(self._gmsh.view.getTags()) - self._views:
            self._gmsh.view.remove(view)


# Of this process, where it is one of ours that keeps a solid.
_KEEPER = SolidKeeper()


def keep_solids() -> None:
    """Let this process keep the solid it built last: for processes that use gmsh only for this.

    Raises
    ------
    MissingLibraryError
        If gmsh cannot be loaded.
    """
    load_gmsh()
    _KEEPER.keeps = True


@contextmanager
def built_solid(parts: ThrowParts, part: str, options: Options = ()) -> Iterator[BuiltSolid]:
    """Open a throw's solid for a while, as `SolidKeeper.opened` does, by what this process keeps if any."""
    with (_KEEPER if _KEEPER.keeps else SolidKeeper()).opened(parts, part, options) as built:
        yield built


# gmsh numbers the edges of a 10-node tetrahedron in another order than scikit-fem.
GMSH_TO_SKFEM = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
PARTS = tuple(SHARES)
OnRemark = Callable[[tuple[str, ...]], None]


@dataclass(frozen=True)
class MeshingStrategy:
    """One strategy for meshing a part, tried if those before it failed.

    Attributes
    ----------
    what : str
        Its difference.
    share : float
        Of the size factor.
    options : tuple of (name, value)
        Of gmsh.
    """

    what: str
    share: float = 1.0
    options: tuple[tuple[str, float], ...] = ()


# No rung changes the part: they only make elements smaller, keep faces apart that lie in one surface,
# or use another algorithm.
MESHING_STRATEGIES = (
    MeshingStrategy("as planned"),
    MeshingStrategy("elements of 0.8 the size", 0.8),
    MeshingStrategy("elements of 0.6 the size", 0.6),
    MeshingStrategy("faces not united", 0.8, (("Geometry.OCCUnionUnify", 0),)),
    MeshingStrategy("frontal volume mesher", 0.8, (("Mesh.Algorithm3D", 4),)),
    MeshingStrategy(
        "faces not united, MeshAdapt surface mesher",
        0.7,
        (("Geometry.OCCUnionUnify", 0), ("Mesh.Algorithm", 1)),
    ),
)


@summarized("part", "length [m]", "unknowns", "size_factor", "mended_elements")
@dataclass(frozen=True)
class ThrowMesh:
    """A mesh of a throw or of the part of it required by its symmetry.

    Attributes
    ----------
    part : {"quarter", "half", "full"}
        The meshed part: x >= 0 and z <= length / 2, only x >= 0, or everything.
    length : float
        Length of the whole throw along the shaft [m].
    pins : tuple of str
        Names of the crankpins' surfaces, "pin", "pin 2" ...
    points : (n, 3) array
        Node coordinates in the throw frame [m].
    elements : (m, 10) array
        Node numbers of the tetrahedra, corner nodes first, edge nodes in scikit-fem's order.
    surfaces : dict
        Corner node numbers (k, 3) of the facets of each named surface, counterclockwise from
        outside: "left end", "right end" (not of
        a quarter), "crank plane" and "middle plane" (the cuts), each of `pins`, "main journal",
        "fillet", "web", and "bore" and "counterweight" if present.
    size_factor : float
        The size factor the mesh was made with: 1 is the default, smaller is finer.
    mended_elements : int
        Number of inverted elements whose edges were straightened.
    solid : SolidProperties
        Of the solid that was meshed, by the kernel.
    attempts : tuple of str
        Strategies tried before and why each failed; empty for most throws.
    geometry_seconds : float
        Time to build or open the solid, without meshing it; 0 if it was kept from the previous mesh.
    """

    part: str
    length: float
    pins: tuple[str, ...]
    points: NDArray[np.float64]
    elements: NDArray[np.int64]
    surfaces: dict[str, NDArray[np.int64]]
    size_factor: float
    mended_elements: int
    solid: SolidProperties
    attempts: tuple[str, ...] = ()
    geometry_seconds: float = 0.0

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns of the meshed part."""
        return 3 * len(self.points)

    def plot(self, axes: "Axes | None" = None, *, eye: ArrayLike = (-1.0, 0.45, -0.6)) -> "Axes":
        """Draw the surface of the mesh in parallel projection, cuts by planes of symmetry in orange.

        Parameters
        ----------
        eye : (3,) array_like
            Direction from the throw to the eye; the crank is upright.

        Raises
        ------
        InputError
            If the direction is not three finite numbers, or along the crank.
        """
        from geometry.plots.throw_plot import plot_mesh

        cuts = (CRANK_PLANE, MIDDLE_PLANE)
        facets = {cut: self.surfaces[cut] for cut in cuts if cut in self.surfaces}
        outside = [corners for name, corners in self.surfaces.items() if name not in cuts]
        count = len(self.elements)
        elements = "1 element" if count == 1 else f"{count:,} elements"
        title = f"{self.part.capitalize()} mesh, {elements}"
        return plot_mesh(
            axes, self.points, np.concatenate(outside), facets, np.asarray(eye, float), title
        )


def mesh_throw(
    throw: "CrankThrow",
    size_factor: float = 1.0,
    part: str = "auto",
    sizes: SizeMap | None = None,
    attempts: tuple[str, ...] = (),
    on_remark: OnRemark | None = None,
) -> ThrowMesh:
    """Mesh a throw in this process.

    If a strategy fails, or its mesh does not have the solid's volume, the next of `MESHING_STRATEGIES` is
    tried; none changes the part. The mesh records the attempts.

    Parameters
    ----------
    throw : CrankThrow
        The dimensions.
    size_factor : float
        Scales all element sizes; 1 gives about 1 % accuracy of the axial compliance.
    part : {"auto", "quarter", "half", "full"}
        Part to mesh; "auto" is the smallest that the throw's symmetry allows.
    sizes : SizeMap, optional
        Element sizes that `size_factor` scales, instead of those planned from the dimensions.
    attempts : tuple of str, optional
        Strategies that failed elsewhere, and are skipped here.
    on_remark : callable, optional
        Called with all failed attempts before each strategy.

    Returns
    -------
    ThrowMesh
        Identical bit for bit for the same input, in any process and thread.

    Raises
    ------
    InputError
        If the throw lacks that symmetry, or the mesh would have too many unknowns.
    MeshError
        If all strategies fail; the message states the last reason.
    """
    return mesh_parts(
        throw.parts, size_factor, checked_part(throw, part), sizes, attempts, on_remark
    )


def mesh_parts(
    parts: ThrowParts,
    size_factor: float,
    part: str,
    sizes: SizeMap | None,
    attempts: tuple[str, ...],
    on_remark: OnRemark | None = None,
) -> ThrowMesh:
    """Mesh a throw of these parts as `mesh_throw` does; its symmetry allows this part."""
    check_budget(
        predict_unknowns(parts, size_factor, part)
        if sizes is None
        else sizes.expected_unknowns(size_factor),
        size_factor,
    )

    def mesh_by(rung: MeshingStrategy, failed: tuple[str, ...]) -> ThrowMesh:
        factor = size_factor * rung.share
        with gmsh_errors("mesh the throw"), built_solid(parts, part, rung.options) as built:
            if sizes is None:
                set_sizes(built.gmsh, built.parts, size_plan(built.parts, factor), built.last)
            else:
                set_size_map(built.gmsh, sizes, factor, built.parts, built.unit)
            return checked_mesh(
                built.gmsh,
                built.surfaces,
                built.solid,
                built.unit,
                part=part,
                length=parts.length,
                pins=tuple(pin.name for pin in parts.pins),
                size_factor=factor,
                attempts=failed,
                geometry_seconds=built.seconds,
            )

    return try_strategies(mesh_by, attempts, on_remark)


def try_strategies(
    mesh_by: Callable[[MeshingStrategy, tuple[str, ...]], ThrowMesh],
    attempts: tuple[str, ...],
    on_remark: OnRemark | None,
) -> ThrowMesh:
    """Try `MESHING_STRATEGIES` one after the other, skipping those that failed before in `attempts`.

    Raises
    ------
    MeshError
        If all fail.
    """
    for rung in MESHING_STRATEGIES[len(attempts) :]:
        if on_remark is not None:
            on_remark(attempts)
        try:
            return mesh_by(rung, attempts)
        except MeshError as error:
            attempts = (*attempts, f"{rung.what}: {error}")
    raise all_failed(attempts)


def all_failed(attempts: tuple[str, ...]) -> MeshError:
    """Make the error of a throw that no strategy could mesh."""
    return MeshError(
        f"{len(attempts)} ways of meshing the throw failed, the last one ({attempts[-1]})."
    )


class Symmetric(Protocol):
    """What has a symmetry."""

    @property
    def symmetry(self) -> str:
        """Its smallest part that stands for it."""


def checked_part(throw: Symmetric, part: str) -> str:
    """Return the requested part, which the throw's symmetry must allow.

    Raises
    ------
    InputError
    """
    smallest = throw.symmetry
    if part == "auto":
        return smallest
    if part not in PARTS:
        raise InputError(f"part: given {part!r}; allowed are auto, {', '.join(PARTS)}.")
    if PARTS.index(part) < PARTS.index(smallest):
        raise InputError(
            f"part: given {part!r}; allowed is {smallest!r} or more, because this throw has no such symmetry."
        )
    return part


def checked_mesh(
    gmsh: Any,
    surfaces: dict[str, list[int]],
    solid: SolidProperties,
    unit: float = 1.0,
    **described: Any,
) -> ThrowMesh:
    """Mesh the model, whose element sizes are set, and check the result.

    Parameters
    ----------
    surfaces : dict
        Surface tags by surface name.
    unit : float
        Length of 1 in the model [m].
    **described
        Further attributes of the mesh.

    Raises
    ------
    MeshError
        If gmsh fails, or the mesh does not match the solid.
    """
    with gmsh_errors("mesh the throw"):
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
    points, elements, facets = read_mesh(gmsh, surfaces)
    forget_array_types()
    points *= unit
    if 3 * len(points) > 1.5 * MOST_UNKNOWNS:
        raise MeshError(f"the mesh has {3 * len(points):,} unknowns, far more than predicted.")
    points, mended = straighten_elements(points, elements)
    check_volume(points, elements, solid)
    check_quality(points, elements)
    return ThrowMesh(
        points=points,
        elements=elements,
        surfaces=facets,
        mended_elements=mended,
        solid=solid,
        **described,
    )


def read_mesh(
    gmsh: Any, surfaces: dict[str, list[int]]
) -> tuple[NDArray[np.float64], NDArray[np.int64], dict[str, NDArray[np.int64]]]:
    """Read nodes, tetrahedra and named facets from gmsh, nodes numbered from zero."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.asarray(coordinates, dtype=float).reshape(-1, 3)
    number = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    _, nodes = gmsh.model.mesh.getElementsByType(11)
    elements = number[nodes.astype(np.int64)].reshape(-1, 10)[:, GMSH_TO_SKFEM]
    if len(elements) == 0:
        raise MeshError("gmsh made no tetrahedra for the throw.")
    used, renumbered = np.unique(elements, return_inverse=True)
    order = np.full(len(points), -1, dtype=np.int64)
    order[used] = np.arange(len(used))
    elements = renumbered.reshape(elements.shape)
    keys, outward = outer_facets(elements)
    facets = {}
    for name, surface_tags in surfaces.items():
        parts = [np.empty((0, 3), dtype=np.int64)]
        for tag in surface_tags:
            nodes = gmsh.model.mesh.getElementsByType(9, tag)[1].astype(np.int64)
            parts.append(order[number[nodes].reshape(-1, 6)[:, :3]])
        # Turned outward: gmsh leaves them as their surface happens to lie.
        wanted = facet_keys(np.concatenate(parts))
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        if not np.array_equal(keys[place], wanted):
            raise MeshError("a named surface has facets that bound no element of the solid.")
        facets[name] = outward[place]
    return points[used], elements, facets


# A six-node triangle (corners 0 1 2, edge middles 3 4 5 on 01 12 02) as four flat ones.
SUBTRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


def six_node_triangles(mesh: ThrowMesh, corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the edge nodes of surface triangles (k, 3), in scikit-fem's order (01, 12, 02)."""
    size = len(mesh.points)
    ends = np.concatenate([mesh.elements[:, [a, b]] for a, b in EDGES])
    middles = np.concatenate([mesh.elements[:, node] for node in range(4, 10)])
    keys = ends.min(axis=1) * size + ends.max(axis=1)
    keys, first = np.unique(keys, return_index=True)
    middles = middles[first]
    edges = [corners[:, [a, b]] for a, b in ((0, 1), (1, 2), (0, 2))]
    wanted = [edge.min(axis=1) * size + edge.max(axis=1) for edge in edges]
    return np.column_stack([corners, *(middles[np.searchsorted(keys, w)] for w in wanted)])


def flattened(facets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Flat triangles (4 t, 3), four to each six-node one (t, 6)."""
    return np.concatenate([facets[:, list(corners)] for corners in SUBTRIANGLES])


def flat_triangles(mesh: ThrowMesh) -> NDArray[np.int64]:
    """Flat triangles (t, 3), four to each curved one, over all surfaces, cuts included."""
    return flattened(six_node_triangles(mesh, np.concatenate(list(mesh.surfaces.values()))))
