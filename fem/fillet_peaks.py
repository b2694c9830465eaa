"""The largest stresses at a throw's fillets and oil holes: results of `fillet_stresses`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from crankbase.checks.choices import check_choice
from crankbase.drawing.bars import draw_groups
from crankbase.drawing.diagram_style import new_axes
from crankbase.drawing.legends import write_title
from crankbase.summaries import summarized
from crankbase.tables.frames import grid, table
from fem.fillets import Fillet
from fem.rule_mesh import RULE_LOADS, FilletMeshing, ReadingQuality, fillet_meshings
from fem.surface_stress import surface_stress
from fem.unit_loads import LoadedThrow, UnitLoad, whole_facets, whole_nodes
from geometry.drilling import DrillingExit
from geometry.mesh import ThrowMesh, six_node_triangles
from geometry.mesher import Throw
from geometry.solid import CRANK_PLANE, FILLET, LEFT_END, MIDDLE_PLANE, OIL_HOLE, RIGHT_END

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Array = NDArray[np.float64]
Integers = NDArray[np.int64]

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
    found = surface_stress(
        points,
        whole_facets(whole, facets),
        np.tile(on_fillet, len(whole.images)),
        displacement,
        loaded.material,
    )
    meshed = np.isin(found.nodes, whole.numbers[0])
    return FilletSurface(found.nodes, points[found.nodes], found.stress, meshed, found.normals)


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
    load : UnitLoad
    fillet : Fillet
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
        Nominal stress, as `fem.nominal_stress` defines it; under a torque a shear stress.
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
    throw : CrankThrow or ImportedThrow
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
        return all(read) and all(found.met for found in self.meshings)

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
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        criterion : {"principal", "von Mises"}
            Stress that is divided by the nominal one.

        Returns
        -------
        matplotlib.axes.Axes

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
