"""Stresses at a throw's fillets and oil holes under unit loads, with stress concentration factors.

The throw is meshed with a few elements across all fillets and exits of oil holes, solved, meshed again with
more where the stresses are high, and solved again. The change from one mesh to the next measures
the error. The ends are pinned, so that the forces in every section follow from the loads alone.

Nominal stresses, the reference of stress concentration factors, are those of the rules for marine
crankshafts (IACS UR M53, Calculation of Crankshafts for I.C. Engines, section 2) as far as these have
them: bending refers to the section of the web, torsion to the pin or the main journal. The web's section
lies in the middle of the overlap of the two journals that it joins, or of the gap between them: B is the
width of the web's outline and h its thickness there, without counterweights, bores and fillets.
Definitions that the rules lack are our choice:

==================== ================================= ==================================
unit load            nominal stress                    symbols
==================== ================================= ==================================
axial force P        P a / (B h^2 / 6)                 a: distance from the shaft of the
                                                       pin's axis, which the force passes;
                                                       of a web between pins the larger
torque T             T / (pi (D^4 - d^4) / (16 D))     D, d: outside and bore of the pin,
                                                       at its fillets, or main journal
bending moment M     M / (B h^2 / 6)
in the crank plane
bending moment M     M / (pi (D^4 - d^4) / (32 D))     since it twists the web but bends
across it                                              the pin and the main journal
radial force Z       Z l1 l2 / L / (B h^2 / 6)         the simply supported throw's moment
                                                       at the middle of the web's thickness:
                                                       l1 from the bearing on that side, l2
                                                       of the force from the other bearing
==================== ================================= ==================================

At the exits of oil holes all of them refer to the section of the pin or main journal, as if there were no
hole: a torque to pi (D^4 - d^4) / (16 D), moments to half of it (UR M53, W_P and W_e of the factors gamma_T
and gamma_B), whichever way the hole points. The moment of an axial force is P a at a pin; in a main journal
it gives P / (pi (D^2 - d^2) / 4). That of a radial force is the simply supported throw's at the hole.

The first, the fourth and the choice of section for webs between pins are ours; the rules know neither an
axial force nor bending across the crank plane.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.array_checks import Array, Integers
from crankbase.choices import check_choice
from crankbase.errors import InputError
from crankbase.quantity import format_quantity
from fem.analysis import check_solving_memory
from fem.fillet_peaks import (
    RULE_LOADS,
    WISHED_SIZE,
    Fillet,
    FilletPeak,
    FilletStresses,
    FilletSurface,
    LoadedThrow,
    OilHolePeak,
    UnitLoad,
    fillet_element,
    fillet_points,
    fillet_surface,
    largest_principal,
    measured_sizes,
    principal_stresses,
    reading_quality,
    refine_at,
    rule_sizes,
    sharp_corners,
    solve_unit_loads,
    throw_fillets,
    unit_loads,
    von_mises,
)
from fem.material import STEEL, Material
from fem.superelement import EndSections
from fem.symmetry import mirror_images, radial_directions
from fem.wished_accuracy import STRESS_ACCURACY
from geometry.any_throw import Throw
from geometry.mesher import Mesher, mesh_isolated
from geometry.parts import Cylinder, DrillingExit, ThrowParts, WebPlate
from geometry.sizes import SizeMap
from geometry.throw import CrankThrow


def nominal_hole_stress(parts: ThrowParts, outlet: DrillingExit, load: UnitLoad) -> float:
    """Nominal stress at an exit of an oil hole under a unit load.

    Parameters
    ----------
    outlet : DrillingExit
        Of one of the throw's oil holes.

    Returns
    -------
    float
        [Pa/N] or [Pa/(N m)]; under a torque a shear stress.
    """
    hole = outlet.drilling
    journal = next(cylinder for cylinder in parts.cylinders if cylinder.name == hole.journal)
    modulus = torsion_modulus(journal)
    if load.kind == "torsion":
        return 1.0 / modulus
    moment = 1.0
    if load.kind == "axial":
        if not journal.is_pin:
            return 1.0 / (math.pi * (journal.radius**2 - journal.bore_radius**2))
        moment = math.hypot(*journal.axis)
    elif load.kind == "radial":
        moment = _simply_supported(parts, hole.place, load)
    return moment / (0.5 * modulus)


def _simply_supported(parts: ThrowParts, place: float, load: UnitLoad) -> float:
    """Moment [N m/N] at z = `place` of a radial force on the throw simply supported at its ends."""
    assert load.pin is not None
    loaded = parts.pins[load.pin]
    force = 0.5 * (loaded.start + loaded.end)
    return min(place, force) * (parts.length - max(place, force)) / parts.length


@dataclass(frozen=True)
class WebSection:
    """Section of a web in the middle of the overlap or gap of the journals that it joins [m]."""

    width: float
    thickness: float

    @property
    def modulus(self) -> float:
        """Section modulus B h^2 / 6 against bending in the crank plane [m^3]."""
        return self.width * self.thickness**2 / 6.0


def web_section(parts: ThrowParts, web: WebPlate) -> WebSection:
    """Section of a web that nominal stresses refer to.

    Parameters
    ----------
    web : WebPlate
        One of its webs, of some thickness.
    """
    number = parts.webs.index(web)
    before, after = parts.cylinders[number : number + 2]
    foot, tip = (before, after) if math.dist(before.axis, web.foot) == 0.0 else (after, before)
    middle = 0.5 * (foot.radius + web.distance - tip.radius)
    height = np.array([min(max(middle, 0.0), web.distance)])
    width = 2.0 * float(web.outline.half_width(height)[0])
    thickness = web.end - web.start - sum(float(s.depth(height)[0]) for s in web.slopes)
    return WebSection(width, thickness)


def torsion_modulus(journal: Cylinder) -> float:
    """Section modulus against torsion of a journal or pin, its bore taken as concentric [m^3]."""
    outer, bore = 2.0 * journal.radius, 2.0 * journal.bore_radius
    return math.pi * (outer**4 - bore**4) / (16.0 * outer)


def nominal_stress(parts: ThrowParts, fillet: Fillet, load: UnitLoad) -> float:
    """Nominal stress at a fillet under a unit load.

    Parameters
    ----------
    fillet : Fillet
        One of the throw's.

    Returns
    -------
    float
        [Pa/N] or [Pa/(N m)]; under a torque a shear stress.
    """
    web = fillet.web
    if load.kind == "torsion":
        return 1.0 / torsion_modulus(fillet.journal)
    if load.kind == "cross bending":
        return 2.0 / torsion_modulus(fillet.journal)
    modulus = web_section(parts, web).modulus
    if load.kind == "bending":
        return 1.0 / modulus
    if load.kind == "axial":
        return max(math.hypot(*web.foot), math.hypot(*web.tip)) / modulus
    return _simply_supported(parts, 0.5 * (web.start + web.end), load) / modulus


Site = Fillet | DrillingExit
FilletMesh = Literal["adaptive", "m53"]
FILLET_MESHES = ("adaptive", "m53")

# Size factor of the mesh that element sizes away from the fillets are taken from.
BULK = 1.2
# Elements across a fillet's quarter circle: of the first mesh, where it has room, and of the second.
COARSE, COARSEST, FINE = 3.0, 2.0, 6.0
# Later ones are so much finer; less than the smaller factor is not worth another mesh.
REFINEMENT, LEAST_REFINEMENT = 1.5, 1.25
MOST_MESHES, MOST_RULE_MESHES = 4, 5
# Fillets are meshed finely where their stress under any load is above this share of their largest.
STRESSED = 0.8
# Errors fall with the square of the element size; what two meshes say of them is multiplied by SAFETY.
# Meshes of one fineness differ by SCATTER divided by it, whatever two of them say. Found by comparing
# with much finer meshes.
ORDER, SAFETY, SCATTER = 2.0, 1.5, 0.15
MOST_UNKNOWNS = 400_000
# Elements across a quarter circle of a rule's mesh, and how many unknowns that may take.
RULE_FINE, MOST_RULE_UNKNOWNS = 0.5 * math.pi / WISHED_SIZE, 800_000
# Of the throw's length.
CUT_TOLERANCE = 1e-9


def fillet_stresses(
    throw: Throw,
    material: Material = STEEL,
    accuracy: float = 0.05,
    *,
    solver: str = "auto",
    end_sections: EndSections = "rigid",
    mesh: FilletMesh = "adaptive",
    mesher: Mesher | None = None,
) -> FilletStresses:
    """Compute the stresses at a throw's fillets and oil holes under unit loads by finite elements.

    The ends are pinned. The loads are an axial force, a torque, equal and opposite bending moments on
    the ends in the crank plane and across it, and a radial force on each pin, uniform over it.

    Parameters
    ----------
    throw : CrankThrow or ImportedThrow
        In a CAD part, fillets are the faces that run smoothly into journals and pins; oil holes of CAD
        parts have no stresses.
    material : Material
        The stresses depend only on its Poisson's ratio.
    accuracy : float
        Required relative accuracy of the largest stresses, 0.02 to 0.2.
    solver : {"auto", "pardiso", "superlu"}
        Equation solver.
    end_sections : {"rigid", "averaged"}
        Whether end sections move as rigid discs, or may warp with prescribed mean motions. It
        affects the main journals' fillets, the more the shorter the journals.
    mesh : {"adaptive", "m53"}
        Fine where fillets are stressed, or by IACS UR M53, Appendix III: elements of a quarter of
        the radius over the fillets on the side of the overlap, layers growing below, six elements across
        the web. `FilletStresses.meshings` states the values reached.
    mesher : callable, optional
        Function for meshing; by default gmsh runs in a separate process.

    Raises
    ------
    InputError
        If the throw has no fillet and no oil hole, or too small ones, or a parameter is out of range.
    MeshError, SolveError
        If the throw cannot be meshed or solved.

    Examples
    --------
    >>> import crankfem as cf
    >>> throw = cf.CrankThrow(
    ...     crank_radius=0.170, main_journal_diameter=0.220, pin_diameter=0.180,
    ...     main_journal_length=0.120, pin_length=0.139, web_width=0.300, web_thickness=0.068,
    ...     fillet_radius=0.020,
    ... )
    >>> found = cf.compliance.fillet_stresses(throw)
    >>> pin = next(p for p in found.peaks if p.load.kind == "bending" and p.fillet.journal.is_pin)
    >>> print(f"{pin.fillet.name}: {pin.factor:.1f}")
    pin, left web: 2.0
    """
    _check(throw, material, accuracy)
    check_choice("mesh", mesh, FILLET_MESHES, "these meshes are known")
    mesh_with = mesher or mesh_isolated
    usual = mesh_with(throw, BULK, "auto", None)
    parts = throw.parts if isinstance(throw, CrankThrow) else throw.parts_by(usual)
    webs = parts.webs if mesh == "m53" else ()
    fillets = throw_fillets(parts)
    if not isinstance(throw, CrankThrow):
        points = np.concatenate(
            [image.points(fillet_points(usual)) for image in mirror_images(usual)]
        )
        fillets = tuple(fillet for fillet in fillets if fillet.holds(points).any())
    outlets = [outlet for hole in parts.drillings for outlet in hole.exits]
    sites: tuple[Site, ...] = (*fillets, *outlets)
    if not sites:
        raise InputError(
            "throw: given a part whose fillets are not toroidal around its journals and pins; "
            "allowed is at least one that does."
        )
    loads = unit_loads(radial_directions(throw))

    def solved(sizes: SizeMap, fineness: float) -> _FilletRefinementLevel:
        check_solving_memory(throw, sizes.expected_unknowns(), accuracy, stresses=True)
        meshed = mesh_with(throw, 1.0, "auto", sizes)
        loaded = solve_unit_loads(meshed, loads, material, solver, end_sections)
        return _FilletRefinementLevel.judged(loaded, sites, fineness)

    # First a mesh that is a little finer than usual at all sites.
    points = fillet_points(usual)
    places = [points[site.holds(points)] for site in sites]
    sizes, fineness = _sizes_within_budget(measured_sizes(usual), sites, places, COARSE)
    if fineness < COARSEST:
        raise _too_small(sites)
    level = solved(sizes, fineness)
    errors = np.full((len(sites), len(loads)), np.inf)
    wanted = max(RULE_FINE if webs else FINE, (1.0 + 1e-9) * SCATTER / accuracy)
    for _ in range((MOST_RULE_MESHES if webs else MOST_MESHES) - 1):
        unsettled = errors > accuracy
        if webs and np.all(np.isfinite(errors)):
            unsettled |= level.badly_read(sites)
        if not unsettled.any():
            break
        sizes, fineness = level.finer_sizes(sites, unsettled, wanted, webs)
        if fineness < LEAST_REFINEMENT * level.fineness:
            break
        coarse, level = level, solved(sizes, fineness)
        # Relative errors of the largest stresses; what was settled before is not meshed more finely now.
        change = np.abs(level.largest - coarse.largest) / level.largest
        ratio = level.fineness / coarse.fineness
        estimate = SAFETY * change.max(axis=0) / (ratio**ORDER - 1.0)
        estimate = np.maximum(estimate, SCATTER / level.fineness)
        errors = np.where(unsettled, estimate, errors)
        wanted = REFINEMENT * fineness
    if not np.all(np.isfinite(errors)):
        raise _too_small(sites)
    return FilletStresses(
        throw=throw,
        peaks=tuple(
            FilletPeak(
                fillet=fillet,
                nominal=nominal_stress(parts, fillet, load),
                **level.peak(number, column, errors),
            )
            for column, load in enumerate(loads)
            for number, fillet in enumerate(fillets)
        ),
        hole_peaks=tuple(
            OilHolePeak(
                outlet=outlet,
                nominal=nominal_hole_stress(parts, outlet, load),
                **level.peak(number, column, errors, at_hole=True),
            )
            for column, load in enumerate(loads)
            for number, outlet in enumerate(outlets, start=len(fillets))
        ),
        sharp_corners=sharp_corners(parts),
        loaded=level.loaded,
        surface=level.surface,
        fineness=level.fineness,
        accuracy=accuracy,
        mesh=mesh,
    )


@dataclass(frozen=True)
class _FilletRefinementLevel:
    """One mesh with its solution, and the nodes of the fillets with the largest stresses."""

    loaded: LoadedThrow
    surface: FilletSurface
    fineness: float
    on: tuple[Integers, ...]  # nodes of each fillet or exit
    equivalent: Array  # (s, k)
    principals: Array  # (s, k, 3)

    @classmethod
    def judged(
        cls, loaded: LoadedThrow, sites: Sequence[Site], fineness: float
    ) -> "_FilletRefinementLevel":
        surface = fillet_surface(loaded)
        points = surface.points
        # Of mirrored nodes those at x >= 0; nodes on the cut are there to round-off.
        least = -np.inf if loaded.mesh.part == "full" else -CUT_TOLERANCE * loaded.mesh.length
        side = points[:, 0] > least
        chosen = []
        for site in sites:
            nodes = site.holds(points)
            # All if there are none on this side, as at a hole that points away from it.
            chosen.append(np.flatnonzero(nodes & side if np.any(nodes & side) else nodes))
        return cls(
            loaded,
            surface,
            fineness,
            tuple(chosen),
            von_mises(surface.stress),
            principal_stresses(surface.stress),
        )

    @property
    def largest(self) -> Array:
        """Largest equivalent and principal stresses (2, sites, k), without signs."""
        sizes = (self.equivalent, np.abs(largest_principal(self.principals)))
        return np.array([[size[nodes].max(axis=0) for nodes in self.on] for size in sizes])

    def _place(self, node: int) -> Array:
        """Position of a node; on a cut exactly there [m]."""
        place = self.surface.points[node]
        return np.where(np.abs(place) < CUT_TOLERANCE * self.loaded.mesh.length, 0.0, place)

    def finer_sizes(
        self,
        sites: Sequence[Site],
        loads: NDArray[np.bool_],
        fineness: float,
        webs: Sequence[WebPlate],
    ) -> tuple[SizeMap, float]:
        """Sizes of a mesh that is finer where stresses are high, and its fineness.

        `loads` (sites, k) are the loads considered. With `webs` it is as fine as UR M53 requires.
        """
        stressed = []
        for nodes, chosen in zip(self.on, loads, strict=True):
            here = nodes[self.surface.meshed[nodes]]
            share = self.equivalent[here] / self.equivalent[nodes].max(axis=0)
            stressed.append(self.surface.points[here[(share > STRESSED)[:, chosen].any(axis=1)]])
        sizes = measured_sizes(self.loaded.mesh)
        if not webs:
            return _sizes_within_budget(sizes, sites, stressed, fineness)
        on = [nodes[self.surface.meshed[nodes]] for nodes in self.on]
        fillets = [
            (site, self.surface.points[nodes])
            for site, nodes in zip(sites, on, strict=True)
            if isinstance(site, Fillet)
        ]
        sizes = rule_sizes(sizes, webs, fillets)
        if (expected := sizes.expected_unknowns()) > MOST_RULE_UNKNOWNS:
            raise InputError(
                f'mesh: given "m53", whose elements would make about {expected:,} unknowns with these '
                f'fillets; allowed are {MOST_RULE_UNKNOWNS:,}, or "adaptive".'
            )
        return _sizes_within_budget(sizes, sites, stressed, fineness, MOST_RULE_UNKNOWNS)

    def badly_read(self, sites: Sequence[Site]) -> NDArray[np.bool_]:
        """Fillets and loads of UR M53 (sites, k) at which elements differ more than it allows."""
        errors = np.zeros_like(self.largest[0])
        badly = np.zeros(errors.shape, dtype=bool)
        for number, site in enumerate(sites):
            for column, load in enumerate(self.loaded.loads):
                if isinstance(site, Fillet) and load.kind in RULE_LOADS:
                    badly[number, column] = not self.peak(number, column, errors)["quality"].met
        return badly

    def peak(
        self, number: int, column: int, errors: Array, at_hole: bool = False
    ) -> dict[str, Any]:
        """Largest stresses at a site under a load, both given by their indices; errors (sites, k)."""
        nodes = self.on[number]
        principals = self.principals[nodes, column]
        signed = largest_principal(principals)
        first = int(np.argmax(np.abs(signed)))
        second = int(np.argmax(self.equivalent[nodes, column]))
        shears = 0.5 * (principals[:, 0] - principals[:, 2])
        third = int(np.argmax(shears))
        load = self.loaded.loads[column]
        torsion = load.kind == "torsion"
        # Where UR M53 reads its factors: the largest shear or equivalent stress, at holes the principal one.
        place = first if at_hole else third if torsion else second
        read = int(self.surface.nodes[nodes[place]])
        return {
            "load": load,
            "shear": float(shears[third]),
            "shear_place": self._place(nodes[third]),
            "quality": reading_quality(self.loaded, read, column, shear=torsion),
            "principal": float(signed[first]),
            "principal_place": self._place(nodes[first]),
            "principals": principals[first],
            "von_mises": float(self.equivalent[nodes[second], column]),
            "von_mises_place": self._place(nodes[second]),
            "error_estimate": float(errors[number, column]),
        }


def _sizes_within_budget(
    sizes: SizeMap,
    sites: Sequence[Site],
    places: Sequence[Array],
    fineness: float,
    most: int | None = None,
) -> tuple[SizeMap, float]:
    """Sizes with so many elements across the sites at some places, or with as many as may be."""
    while True:
        wished = [
            (points, fillet_element(site.radius, fineness))
            for points, site in zip(places, sites, strict=True)
        ]
        finer = refine_at(sizes, wished)
        if finer.expected_unknowns() <= (most or MOST_UNKNOWNS) or fineness < COARSEST:
            return finer, fineness
        fineness *= 0.9


def _too_small(sites: Sequence[Site]) -> InputError:
    smallest = min(sites, key=lambda site: site.radius)
    field, radius = "fillet_radius", smallest.radius
    if isinstance(smallest, DrillingExit):
        hole = smallest.drilling
        radius = hole.exit_radius or hole.radius
        kind, what = ("exit_radius", "") if hole.exit_radius else ("diameter", " (its radius)")
        field = f"oil_holes[{hole.number - 1}].{kind}{what}"
    return InputError(
        f"{field}: given {format_quantity(radius, 'm')}; allowed are larger ones, because elements "
        f"small enough for its stress would make more than {MOST_UNKNOWNS:,} unknowns."
    )


def _check(throw: Throw, material: Material, accuracy: float) -> None:
    if not isinstance(throw, Throw):
        raise InputError(
            f"throw: given a {type(throw).__name__}; allowed is a CrankThrow, or an ImportedThrow of a "
            "STEP file."
        )
    if not isinstance(material, Material):
        raise InputError(f"material: given {material!r}; allowed is a Material, like STEEL.")
    STRESS_ACCURACY.checked("accuracy", accuracy)
    if not isinstance(throw, CrankThrow):
        if not throw.fillets:
            raise InputError(
                f"{throw.path}: given a part without a fillet at its main journals and pins; allowed is at "
                "least one, because the elastic stress at a sharp corner has no bound."
            )
    elif not throw_fillets(throw.parts) and not throw.oil_holes:
        raise InputError(
            "fillet_radius: given 0 at all main journals and pins; allowed is at least one fillet, because "
            "the elastic stress at a sharp corner has no bound."
        )
