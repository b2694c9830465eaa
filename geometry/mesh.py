"""Mesh a throw with second-order tetrahedra, and check the result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError, MeshError
from crankbase.summaries import summarized
from geometry.built_solid import built_solid
from geometry.gmsh_session import forget_array_types, gmsh_errors
from geometry.mesh_checks import (
    MOST_UNKNOWNS,
    SolidProperties,
    check_budget,
    check_quality,
    check_volume,
)
from geometry.parts import ThrowParts
from geometry.shapes import facet_keys, outer_facets, straighten_elements
from geometry.size_fields import set_size_map, set_sizes
from geometry.sizes import SHARES, SizeMap, predict_unknowns, size_plan
from geometry.solid import CRANK_PLANE, MIDDLE_PLANE
from geometry.throw import CrankThrow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        eye : (3,) array_like
            Direction from the throw to the eye; the crank is upright.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            If the direction is not three finite numbers, or along the crank.
        """
        from geometry.plots.mesh_plot import plot_mesh

        cuts = (CRANK_PLANE, MIDDLE_PLANE)
        facets = {cut: self.surfaces[cut] for cut in cuts if cut in self.surfaces}
        outside = [found for name, found in self.surfaces.items() if name not in cuts]
        count = len(self.elements)
        elements = "1 element" if count == 1 else f"{count:,} elements"
        title = f"{self.part.capitalize()} mesh, {elements}"
        return plot_mesh(
            axes, self.points, np.concatenate(outside), facets, np.asarray(eye, float), title
        )


def mesh_throw(
    throw: CrankThrow,
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
    part = checked_part(throw, part)
    parts = throw.parts
    check_budget(
        predict_unknowns(parts, size_factor, part)
        if sizes is None
        else sizes.expected_unknowns(size_factor),
        size_factor,
    )

    def mesh_by(rung: MeshingStrategy, failed: tuple[str, ...]) -> ThrowMesh:
        return _mesh_once(parts, size_factor, part, sizes, rung, failed)

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


def checked_part(throw: CrankThrow, part: str) -> str:
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


def _mesh_once(
    parts: ThrowParts,
    size_factor: float,
    part: str,
    sizes: SizeMap | None,
    rung: MeshingStrategy,
    attempts: tuple[str, ...],
) -> ThrowMesh:
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
            attempts=attempts,
            geometry_seconds=built.seconds,
        )


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
    gmsh : module
    surfaces : dict
        Surface tags by surface name.
    solid : SolidProperties
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
    facets = {}
    for name, surface_tags in surfaces.items():
        parts = [
            number[gmsh.model.mesh.getElementsByType(9, tag)[1].astype(np.int64)].reshape(-1, 6)[
                :, :3
            ]
            for tag in surface_tags
        ]
        facets[name] = np.concatenate(parts) if parts else np.empty((0, 3), dtype=np.int64)
    used, renumbered = np.unique(elements, return_inverse=True)
    order = np.full(len(points), -1, dtype=np.int64)
    order[used] = np.arange(len(used))
    elements = renumbered.reshape(elements.shape)
    outward = outer_facets(elements)
    return (
        points[used],
        elements,
        {name: _oriented(order[corners], outward) for name, corners in facets.items()},
    )


def _oriented(
    facets: NDArray[np.int64], outward: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> NDArray[np.int64]:
    """Turn facets outward; gmsh leaves them as their surface happens to lie."""
    if len(facets) == 0:
        return facets
    keys, oriented = outward
    wanted = facet_keys(facets)
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    if not np.array_equal(keys[place], wanted):
        raise MeshError("a named surface has facets that bound no element of the solid.")
    return oriented[place]
