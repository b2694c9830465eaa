"""Symmetry classes of a throw, motions of its end sections in them, loads spread over its surfaces.

A section where throws meet bends, shears and contracts. With polynomials of degree p its displacement is
a sum of x^a y^b, a + b <= p, along each axis: 9 motions at p = 1, 18 at 2, 45 at 4, all continued over
the bore of a hollow section. The first six are the rigid motions; the others are orthogonal to them, and
to each other, over the ring between bore and rim, and of unit mean square there. So the amplitudes of the
first six are the mean motion: forces and bearings, which act on that, do no work on the others. Motions
of degree p come before those of p + 1, so that a lower degree, or the rigid section, is the first rows
and columns of a higher one.

The space of degree p is the same for all circles and angles of the section, so neighbors share it whatever
their bores and angles: a change of ring or angle is an exact linear map. Each motion is either along the
shaft or across it, and even or odd under either mirror of the section.

A load and the mean motion of its surface are conjugate: the work of a unit load on a displacement is
the mean motion along it, for translations and rotations. This defines "the motion of the pin"
and the free deformation of an end section with given mean motion.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import Literal

import numpy as np
from scipy import sparse

from crankbase.array_checks import Array, Flags, Integers
from crankbase.choices import check_choice
from crankbase.errors import InputError, quoted
from geometry.any_throw import Throw
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.shapes import quadrature, triangle_shapes_at
from geometry.solid import CRANK_PLANE, LEFT_END, MIDDLE_PLANE, RIGHT_END

# A mirror reverses the displacement across it, and the rotations about the axes along it.
MIRROR_X = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
MIRROR_Z = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True)
class MirrorImage:
    """The meshed part of a throw, or a mirror image of it.

    Attributes
    ----------
    across_crank, across_middle : bool
        Planes of reflection.
    length : float
        Length of the whole throw [m].
    """

    across_crank: bool
    across_middle: bool
    length: float

    @property
    def motion_signs(self) -> Array:
        """Signs (6,) of mirrored displacements and rotations."""
        signs = np.ones(6)
        if self.across_crank:
            signs = signs * MIRROR_X
        if self.across_middle:
            signs = signs * MIRROR_Z
        return signs

    @property
    def signs(self) -> Array:
        """Signs (3,) of mirrored displacements."""
        return self.motion_signs[:3]

    @property
    def inside_out(self) -> bool:
        """Whether a single mirror has inverted elements and facets."""
        return self.across_crank != self.across_middle

    def points(self, points: Array) -> Array:
        """Places (n, 3) of the image of points of the meshed part [m]."""
        shift = np.array([0.0, 0.0, self.length if self.across_middle else 0.0])
        return np.asarray(points * self.signs + shift)


def mirror_images(mesh: ThrowMesh) -> tuple[MirrorImage, ...]:
    """Return the images that make the whole throw, the meshed part itself first."""
    choices = [(False, True) if cut else (False,) for cut in CUTS[mesh.part]]
    return tuple(MirrorImage(crank, middle, mesh.length) for crank, middle in product(*choices))


@dataclass(frozen=True)
class SymmetryClass:
    """One of the parts of a motion.

    Attributes
    ----------
    crank_plane, middle_plane : int
        +1 symmetric, -1 antisymmetric about that plane, 0 where the throw is not cut there.
    """

    crank_plane: int
    middle_plane: int

    @property
    def copies(self) -> int:
        """Number of copies of the meshed part in the whole throw."""
        return int(2 ** (abs(self.crank_plane) + abs(self.middle_plane)))

    @property
    def end_unknowns(self) -> Integers:
        """The unknowns (of ux uy uz rx ry rz) that an end section has in this class."""
        return np.flatnonzero(self.crank_plane * MIRROR_X >= 0.0)

    @property
    def ends(self) -> Array:
        """Motions (12, k) of both end sections for unit amplitudes of the class.

        The left end's unknowns, which the right end mirrors if the middle plane is a cut and has
        in addition otherwise.
        """
        return self.unit_motions(MIRROR_X, MIRROR_Z)

    def unit_motions(self, mirror_x: Array, mirror_z: Array) -> Array:
        """Motions (2 n, k) of both end sections as of `ends`, for n motions of a section.

        Parameters
        ----------
        mirror_x, mirror_z : (n,) array
            Their signs when mirrored across the crank plane and across the section.
        """
        left = np.eye(len(mirror_x))[:, self.crank_plane * mirror_x >= 0.0]
        if self.middle_plane:
            return np.vstack([left, self.middle_plane * mirror_z[:, None] * left])
        return np.asarray(np.kron(np.eye(2), left), dtype=np.float64)

    @property
    def shares(self) -> Array:
        """Amplitudes (k, 12) of the class in unit motions of both end sections."""
        return amplitude_shares(self.ends)

    @property
    def central_motions(self) -> Flags:
        """Which motions (6,) of a point on all cuts the class has: along and about x, y, z."""
        return (self.crank_plane * MIRROR_X >= 0.0) & (self.middle_plane * MIRROR_Z >= 0.0)

    def parity(self, image: MirrorImage) -> float:
        """Return +1 if the class moves an image as the mirror image of the meshed part, or -1."""
        sign = self.crank_plane if image.across_crank else 1
        return float(sign * (self.middle_plane if image.across_middle else 1))

    def blocked_axes(self) -> dict[str, tuple[int, ...]]:
        """Displacements blocked on each cut."""
        blocked: dict[str, tuple[int, ...]] = {}
        if self.crank_plane:
            blocked[CRANK_PLANE] = (0,) if self.crank_plane > 0 else (1, 2)
        if self.middle_plane:
            blocked[MIDDLE_PLANE] = (2,) if self.middle_plane > 0 else (0, 1)
        return blocked


def amplitude_shares(ends: Array) -> Array:
    """Amplitudes (k, m) of unit motions `ends` (m, k), which are orthogonal, in motions of the ends."""
    return np.asarray(ends.T / np.sum(ends**2, axis=0)[:, None])


# Which planes each part of a throw is cut by: the crank plane, the middle plane.
CUTS = {"quarter": (1, 1), "half": (1, 0), "full": (0, 0)}


def symmetry_classes(part: str) -> tuple[SymmetryClass, ...]:
    """All classes of a "quarter", "half" or "full" throw."""
    signs = ((1, -1) if cut else (0,) for cut in CUTS[part])
    return tuple(SymmetryClass(*planes) for planes in product(*signs))


def axial_class(part: str) -> SymmetryClass:
    """Return the class that an axial force and a radial force on the pins excite."""
    return SymmetryClass(*CUTS[part])


Sections = Literal["rigid", 1, 2, 4]
SECTIONS: tuple[Sections, ...] = ("rigid", 1, 2, 4)
# What throws share where they meet, unless another is asked for.
SHARED: Sections = 2
RIGID_COUNT = 6
# Of a monomial that the motions before it compose all but this share of, nothing is left.
DEPENDENT = 1e-6
# Exact for products of motions of degree 4.
RADII, ANGLES = 6, 24
# Rings of so many bores are kept: throws of a study have one each.
KEPT = 16


@dataclass(frozen=True)
class SectionMotions:
    """Motions of a section: the six rigid ones, then polynomials up to a degree.

    Attributes
    ----------
    degree : int
        0 for the rigid motions alone.
    radius, bore : float
        Outer and inner radius of the ring that means are taken over [m].
    """

    degree: int = 0
    radius: float = 1.0
    bore: float = 0.0

    @property
    def count(self) -> int:
        """Number of motions, n."""
        return count_of(self.degree)

    @property
    def bending(self) -> int:
        """Number of motions beyond the rigid ones."""
        return self.count - RIGID_COUNT

    @property
    def sections(self) -> Sections:
        """The user's name of the choice."""
        return next(degree for degree in SECTIONS if degree_of(degree) == self.degree)

    @cached_property
    def mirror_x(self) -> Array:
        """Signs (n,) of the motions mirrored across x = 0."""
        terms, coefficients = _basis(self.degree, self.bore / self.radius)
        return np.concatenate([MIRROR_X, _signs(terms[:, 1] + (terms[:, 0] == 0), coefficients)])

    @cached_property
    def mirror_z(self) -> Array:
        """Signs (n,) of the motions mirrored across the section: minus along the shaft."""
        terms, coefficients = _basis(self.degree, self.bore / self.radius)
        return np.concatenate([MIRROR_Z, _signs(terms[:, 0] == 2, coefficients)])

    def fields(self, places: Array) -> Array:
        """Displacements (q, 3, n) of points (q, 2 or more; x and y [m]) for unit amplitudes.

        Translations and motions beyond the rigid ones are in m, rotations in rad.
        """
        x, y = places[:, 0], places[:, 1]
        motions = np.zeros((len(places), 3, self.count))
        motions[:, [0, 1, 2], [0, 1, 2]] = 1.0
        motions[:, 2, 3], motions[:, 2, 4] = y, -x
        motions[:, 0, 5], motions[:, 1, 5] = -y, x
        terms, coefficients = _basis(self.degree, self.bore / self.radius)
        values = _monomials(terms, np.column_stack([x, y]) / self.radius)
        motions[:, :, RIGID_COUNT:] = values @ coefficients
        return motions

    def turn(self, angle: float) -> Array:
        """Matrix (b, b) of amplitudes beyond the rigid motions as the section turns by an angle [rad]."""
        return _turn(self, angle) if self.bending else np.zeros((0, 0))

    def amplitudes_of(self, other: "SectionMotions") -> Array:
        """Amplitudes (n, n) of these motions in unit motions of the same degree over another ring."""
        if self == other:
            return np.eye(self.count)
        places, _ = self.ring()
        here = self.fields(places).reshape(-1, self.count)
        there = other.fields(places).reshape(-1, other.count)
        return np.asarray(np.linalg.lstsq(here, there, rcond=None)[0])

    def up_to(self, sections: Sections) -> "SectionMotions":
        """The motions of a lower degree.

        Raises
        ------
        InputError
            If the degree is higher.
        """
        degree = degree_of(sections)
        if degree > self.degree:
            allowed = ", ".join(str(kind) for kind in SECTIONS if degree_of(kind) <= self.degree)
            raise InputError(
                f"sections: given {quoted(sections)}; allowed is up to {self.sections} ({allowed}), because "
                "the throw was solved with these motions."
            )
        return replace(self, degree=degree)

    def ring(self) -> tuple[Array, Array]:
        """Points (q, 2) over the section [m] and their weights (q,), for integrals."""
        places, weights = _ring(self.bore / self.radius)
        return places * self.radius, weights


RIGID = SectionMotions()


def degree_of(sections: object) -> int:
    """Return the degree of a choice of section motions, 0 for rigid sections.

    Raises
    ------
    InputError
        If it is not in `SECTIONS`.
    """
    if isinstance(sections, bool) or sections not in SECTIONS:
        raise InputError(
            f'sections: given {quoted(sections)}; allowed are "rigid", 1, 2 and 4, the degree of the '
            "polynomials that sections move as where throws meet."
        )
    return 0 if isinstance(sections, str) else int(sections)


def count_of(degree: int) -> int:
    """Number of motions of a section up to a degree."""
    return RIGID_COUNT if degree == 0 else 3 * (degree + 1) * (degree + 2) // 2


def rotation(angle: float) -> Array:
    """Matrix (3, 3) that turns a vector by an angle [rad] about z."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def diagonal_blocks(*blocks: Array) -> Array:
    """Matrix with these along its diagonal; scipy's function takes as long to load as a mesh to make."""
    ends = np.cumsum([block.shape for block in blocks], axis=0)
    whole = np.zeros(ends[-1])
    for block, (row, column) in zip(blocks, ends.tolist(), strict=True):
        whole[row - len(block) : row, column - block.shape[1] : column] = block
    return whole


def section_turn(sections: SectionMotions, angle: float) -> Array:
    """Matrix (2 n, 2 n) that turns the motions of two sections by an angle [rad] about z.

    They are in the order of a superelement's: six of the left and six of the right section, then those beyond
    the rigid ones of the left and of the right.
    """
    return diagonal_blocks(*[rotation(angle)] * 4, *[sections.turn(angle)] * 2)


def both_ends(matrix: Array) -> Array:
    """Map (2 n, 2 n) of a superelement's motions from that of one section's (n, n)."""
    count, rigid = len(matrix), RIGID_COUNT
    left = np.r_[:rigid, 2 * rigid : rigid + count]
    right = np.r_[rigid : 2 * rigid, rigid + count : 2 * count]
    twice = np.zeros((2 * count, 2 * count))
    for end in (left, right):
        twice[np.ix_(end, end)] = matrix
    return twice


def _signs(odd: Array, coefficients: Array) -> Array:
    """Signs (b,) of motions whose terms (t,) all change sign or do not, by odd or even numbers."""
    first = np.abs(coefficients).argmax(axis=0)
    return np.asarray(1.0 - 2.0 * (np.asarray(odd, dtype=np.int64)[first] % 2))


def _monomials(terms: Integers, places: Array) -> Array:
    """Displacements (q, 3, t) of monomials (axis, a, b) at places (q, 2)."""
    axes, first, second = terms.T
    monomials = np.zeros((len(places), 3, len(terms)))
    monomials[:, axes, np.arange(len(terms))] = places[:, :1] ** first * places[:, 1:] ** second
    return monomials


@lru_cache(maxsize=KEPT * KEPT)
def _turn(motions: SectionMotions, angle: float) -> Array:
    """Return `SectionMotions.turn` of motions that bend, at the few angles that a study asks for."""
    (places, weights), turned = motions.ring(), rotation(angle)
    before = motions.fields(places @ turned[:2, :2])[:, :, RIGID_COUNT:]
    bending = motions.fields(places)[:, :, RIGID_COUNT:]
    matrix = np.einsum("q,qak,ab,qbl->kl", weights, bending, turned, before, optimize=True)
    matrix.flags.writeable = False
    return np.asarray(matrix)


@lru_cache(maxsize=KEPT)
def _ring(bore: float) -> tuple[Array, Array]:
    """Places (q, 2) and weights (q,), of sum one, of the ring from a bore to radius one."""
    roots, weights = np.polynomial.legendre.leggauss(RADII)
    # Even in the radius: a polynomial of its square, in which areas are even.
    radii = np.sqrt(0.5 * (1.0 + bore**2) + 0.5 * (1.0 - bore**2) * roots)
    angles = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    places = np.stack([np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))], axis=-1)
    return places.reshape(-1, 2), np.repeat(0.5 * weights / ANGLES, ANGLES)


@lru_cache(maxsize=KEPT)
def _basis(degree: int, bore: float) -> tuple[Integers, Array]:
    """Monomials (t, 3) and their coefficients (t, b) in the motions beyond the rigid ones, radius one."""
    terms = np.array(
        [
            (axis, total - b, b)
            for total in range(degree + 1)
            for axis in range(3)
            for b in range(total + 1)
        ],
        dtype=np.int64,
    ).reshape(-1, 3)
    places, weights = _ring(bore)
    values = _monomials(terms, places)
    products = np.einsum("q,qak,qal->kl", weights, values, values)
    known = _rigid_coefficients(terms, products)
    unit = np.eye(len(terms))
    for term in unit[3:]:
        rest = term
        for _ in range(2):  # once leaves rounding
            rest = rest - known @ (known.T @ (products @ rest))
        size, whole = rest @ products @ rest, term @ products @ term
        if size > DEPENDENT**2 * whole:
            rest = np.where(np.abs(rest) > 1e-10 * np.abs(rest).max(), rest, 0.0)
            known = np.column_stack([known, rest / np.sqrt(size)])
    return terms, known[:, RIGID_COUNT:]


def _rigid_coefficients(terms: Integers, products: Array) -> Array:
    """Coefficients (t, 6) of the rigid motions, of unit mean square; none (t, 6) of degree 0."""
    place = {tuple(term): number for number, term in enumerate(terms.tolist())}
    coefficients = np.zeros((len(terms), RIGID_COUNT))
    if (2, 0, 1) not in place:
        return coefficients
    for axis in range(3):
        coefficients[place[axis, 0, 0], axis] = 1.0
    coefficients[place[2, 0, 1], 3], coefficients[place[2, 1, 0], 4] = 1.0, -1.0
    coefficients[place[0, 0, 1], 5], coefficients[place[1, 1, 0], 5] = -1.0, 1.0
    sizes = np.sqrt(np.einsum("tk,ts,sk->k", coefficients, products, coefficients))
    return np.asarray(coefficients / sizes)


Distribution = Literal["uniform", "cosine"]
DISTRIBUTIONS = ("uniform", "cosine")

# Direction of a radial force on the first pin, towards the shaft.
RADIAL = np.array([0.0, -1.0, 0.0])
# Integrates the shape functions times linear loads on flat facets exactly.
FACET_RULE = quadrature(2, 5)


@dataclass(frozen=True)
class LoadedSurface:
    """A meshed surface, with its mirror images, ready to carry loads.

    Attributes
    ----------
    nodes : (s,) array
        Nodes on its meshed part.
    center : (3,) array
        Centroid of the whole surface [m]; forces act there and moments about it.
    places, areas : (q, 3) array
        Quadrature points of the meshed part [m] and their outward area vectors [m^2].
    shares : (q, s) sparse array
        Shape functions of the nodes there.
    images : tuple of MirrorImage
        The meshed part and its mirror images, which together are the whole surface.
    triangles : (t, 6) array
        Places of each triangle's corners and edge middles in `nodes`.
    resultants : (6, 6) array
        Forces and moments of the tractions that move with unit rigid motions of the surface.
    """

    nodes: Integers
    center: Array
    places: Array
    areas: Array
    shares: sparse.csr_array
    images: tuple[MirrorImage, ...]
    triangles: Integers
    resultants: Array

    def at(self, points: Array, images: tuple[MirrorImage, ...]) -> "LoadedSurface":
        """Return the surface with its nodes at other points (s, 3), and other images."""
        where, weights = FACET_RULE
        tangents = np.einsum("aiq,taj->tqij", triangle_shapes_at(where)[1], points[self.triangles])
        areas = np.cross(tangents[:, :, 0], tangents[:, :, 1]) * weights[:, None]
        places, areas = np.asarray(self.shares @ points), areas.reshape(-1, 3)
        sizes = np.linalg.norm(areas, axis=1)
        middle = np.mean([sizes @ image.points(places) for image in images], axis=0)
        moved = replace(self, places=places, areas=areas, images=images)
        return _with_center(moved, middle / sizes.sum())

    def on_image(self, image: MirrorImage) -> tuple[Array, Array]:
        """Positions relative to the center and outward area vectors of an image, (q, 3) each."""
        return image.points(self.places) - self.center, self.areas * image.signs

    def uniform(self, resultants: Array) -> list[Array]:
        """Tractions (q, 3) on each image with given forces and moments (6,), or (q, 3, c) with (6, c).

        A force is uniform; a moment is tractions that grow linearly from the center.
        """
        share = np.linalg.solve(self.resultants, resultants)
        return [rigid_motions(self.on_image(image)[0]) @ share for image in self.images]

    def nodal(self, tractions: list[Array]) -> Array:
        """Nodal loads (images, s, 3) of tractions (q, 3) on each image; (..., c) of (..., c)."""
        sizes, spread = np.linalg.norm(self.areas, axis=1), self.shares.T.tocsr()
        loads = [
            spread @ (sizes[:, None] * traction.reshape(len(sizes), -1)) for traction in tractions
        ]
        return np.array(loads).reshape(len(loads), len(self.nodes), *tractions[0].shape[1:])

    def unit_loads(self) -> "NodalLoads":
        """Return unit forces along x, y, z and unit moments about them, spread over the surface."""
        return NodalLoads(self.nodes, self.images, self.nodal(self.uniform(np.eye(6))))

    def forces_of(self, tractions: list[Array]) -> Array:
        """Force and moment (6,) of tractions on all images."""
        total = np.zeros(6)
        for image, traction in zip(self.images, tractions, strict=True):
            arms, areas = self.on_image(image)
            sizes = np.linalg.norm(areas, axis=1)
            total += np.einsum("q,qaj,qa->j", sizes, rigid_motions(arms), traction)
        return total


@dataclass(frozen=True)
class NodalLoads:
    """Loads on the nodes of a surface and of its mirror images.

    Attributes
    ----------
    nodes : (s,) array
    values : (images, s, 3, c) array
        For c load cases, on the nodes of each image along the axes of the throw.
    """

    nodes: Integers
    images: tuple[MirrorImage, ...]
    values: Array

    def of_class(self, symmetry: SymmetryClass) -> Array:
        """Loads (s, 3, c) whose work on the meshed part's field is that of all on the whole throw."""
        return np.asarray(
            sum(
                symmetry.parity(image) * image.signs[:, None] * load
                for image, load in zip(self.images, self.values, strict=True)
            )
        )


def pin_surfaces(mesh: ThrowMesh) -> tuple[LoadedSurface, ...]:
    """Return the pins of a meshed throw, ready to carry loads."""
    return tuple(_surface(mesh, mesh.surfaces[pin], mirror_images(mesh)) for pin in mesh.pins)


def unit_pin_loads(mesh: ThrowMesh) -> tuple[NodalLoads, ...]:
    """Unit forces along x, y, z and unit moments about them on each pin, spread over its surface.

    Returns
    -------
    tuple of NodalLoads
        One for each pin, with six load cases.
    """
    return tuple(surface.unit_loads() for surface in pin_surfaces(mesh))


def unit_end_loads(mesh: ThrowMesh, end: str) -> NodalLoads:
    """Unit forces and moments on an end section, spread over it.

    Their work is the mean motion of the section. Of a quarter the left end only is meshed, and its
    images are those across the crank plane.
    """
    center = np.array([0.0, 0.0, 0.0 if end == LEFT_END else mesh.length])
    return _with_center(end_surface(mesh, end), center).unit_loads()


def end_surface(mesh: ThrowMesh, end: str) -> LoadedSurface:
    """Return a meshed end section; its images are those across the crank plane."""
    images = tuple(image for image in mirror_images(mesh) if not image.across_middle)
    return _surface(mesh, mesh.surfaces[end], images)


def end_sections(symmetry: SymmetryClass) -> tuple[str, ...]:
    """Names of the end sections that are meshed."""
    return (LEFT_END,) if symmetry.middle_plane else (LEFT_END, RIGHT_END)


def pin_load(
    surface: LoadedSurface, force: Array, moment: Array, distribution: Distribution
) -> NodalLoads:
    """One load case on a pin.

    Parameters
    ----------
    force, moment : (3,) array
        In the throw frame, about the pin's center [N, N m].
    distribution : {"uniform", "cosine"}
        ``uniform``: uniform traction (moments: growing linearly from the center). ``cosine``: a
        force across the pin as a pressure p cos(theta) on the half that it presses on; a moment
        across it as such pressures that grow with the distance from the middle, on opposite halves of
        the pin's two ends. Loads that a pressure cannot carry (force along the pin, torque about it) are
        uniform in either case.

    Raises
    ------
    InputError
        If the distribution is neither.
    """
    check_choice("distribution", distribution, DISTRIBUTIONS, "a load is spread by one of them")
    wanted = np.concatenate([force, moment])
    if distribution == "uniform":
        tractions = surface.uniform(wanted)
    else:
        across = np.array([force[0], force[1], 0.0])
        # A force couple z x (moment x z) turns about the moment's own direction.
        couple = np.array([moment[1], -moment[0], 0.0])
        pressures = [
            pressure + other
            for pressure, other in zip(
                _pressure_patterns(surface, across, couple=False),
                _pressure_patterns(surface, couple, couple=True),
                strict=True,
            )
        ]
        rest = surface.uniform(wanted - surface.forces_of(pressures))
        tractions = [pressure + other for pressure, other in zip(pressures, rest, strict=True)]
    return NodalLoads(surface.nodes, surface.images, surface.nodal(tractions)[..., None])


def uniform_pin_loads(mesh: ThrowMesh) -> Array:
    """Share of each node in a unit force spread uniformly over the meshed surface of each pin.

    Returns
    -------
    (pins, n) array
        Integrals of the shape functions over the pin's surface, divided by its area; each pin's sum
        to 1.
    """
    shares = np.zeros((len(mesh.pins), len(mesh.points)))
    for pin, surface in enumerate(pin_surfaces(mesh)):
        sizes = np.linalg.norm(surface.areas, axis=1)
        shares[pin, surface.nodes] = sizes @ surface.shares / sizes.sum()
    return shares


def radial_directions(throw: Throw) -> Array:
    """Directions (pins, 3) from each pin's axis to the shaft."""
    axes = np.array([(*axis, 0.0) for axis in throw.pin_axes]).reshape(-1, 3)
    return np.asarray(-axes / np.linalg.norm(axes, axis=1)[:, None])


def rigid_motions(arms: Array) -> Array:
    """Displacements (q, 3, 6) of places (q, 3) from a center for unit translations and rotations."""
    motions = np.zeros((len(arms), 3, 6))
    motions[:, 0, 0] = motions[:, 1, 1] = motions[:, 2, 2] = 1.0
    x, y, z = arms.T
    motions[:, 1, 3], motions[:, 2, 3] = -z, y
    motions[:, 0, 4], motions[:, 2, 4] = z, -x
    motions[:, 0, 5], motions[:, 1, 5] = -y, x
    return motions


def _pressure_patterns(surface: LoadedSurface, direction: Array, *, couple: bool) -> list[Array]:
    """Pressures (q, 3) on each image with the resultant force, or couple, of that direction."""
    size = float(np.linalg.norm(direction))
    if size == 0.0:
        return [np.zeros_like(surface.places) for _ in surface.images]
    unit = direction / size
    pressures = []
    total = 0.0
    for image in surface.images:
        arms, areas = surface.on_image(image)
        sizes = np.linalg.norm(areas, axis=1)
        normals = areas / sizes[:, None]
        weight = arms[:, 2] if couple else np.ones(len(arms))
        facing = normals @ unit
        pressed = np.where(facing * np.sign(weight) < 0.0, np.abs(facing * weight), 0.0)
        pressures.append(-pressed[:, None] * normals)
        total += float(np.sum(sizes * weight * (pressures[-1] @ unit)))
    return [pressure * (size / total) for pressure in pressures]


def _surface(mesh: ThrowMesh, corners: Integers, images: tuple[MirrorImage, ...]) -> LoadedSurface:
    triangles = six_node_triangles(mesh, corners)
    values, _ = triangle_shapes_at(FACET_RULE[0])
    nodes, number = np.unique(triangles, return_inverse=True)
    number = number.reshape(triangles.shape)
    size = len(triangles) * len(values)
    columns = np.repeat(number, len(values), axis=0).ravel()
    shares = sparse.csr_array(
        (np.tile(values, (len(triangles), 1)).ravel(), (np.repeat(np.arange(size), 6), columns)),
        (size, len(nodes)),
    )
    none = np.zeros((size, 3))
    unplaced = LoadedSurface(nodes, none[0], none, none, shares, images, number, np.eye(6))
    return unplaced.at(mesh.points[nodes], images)


def _with_center(surface: LoadedSurface, center: Array) -> LoadedSurface:
    """Return the surface with another center."""
    resultants = np.zeros((6, 6))
    sizes = np.linalg.norm(surface.areas, axis=1)
    for image in surface.images:
        motions = rigid_motions(image.points(surface.places) - center)
        resultants += np.tensordot(sizes[:, None, None] * motions, motions, ([0, 1], [0, 1]))
    return replace(surface, center=center, resultants=resultants)
