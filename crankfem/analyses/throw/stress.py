"""Stresses at a throw's fillets and oil holes: their numbers, tables and sentences."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError, MeshError, SolveError
from crankbase.quantity import percent
from crankbase.results import Number, Quantity, Result, made_from, result
from crankbase.table import SI, Column, Main, OutputUnit, OutputUnits, Table
from crankfem.analyses.throw.pictures.offscreen import OffscreenProcess
from crankfem.analyses.throw.pictures.stress_picture import RENDER, picture_arrays, picture_name
from crankfem.analyses.throw.throw_record import ThrowInFile, dimensions_of
from fem import fillet_stress
from fem.fillet_peaks import (
    ACROSS_WEB,
    LARGEST_NORMAL,
    LARGEST_SIZE,
    LARGEST_SPREAD,
    LAYERS,
    RULE_LOADS,
    FilletMeshing,
    FilletStresses,
    ReadingQuality,
)
from fem.material import Material
from geometry.any_throw import Throw
from geometry.throw import CrankThrow

# Of the largest stresses: enough to compare fillets and to see which is the weakest.
ACCURACY = 0.1
# What loads a throw most in an engine: the rod's force and the torque.
KINDS_SHOWN = ("radial", "torsion")


def stresses_or_reason(
    throw: Throw, material: Material, mesh: fillet_stress.FilletMesh = "adaptive"
) -> tuple[FilletStresses | None, str | None]:
    """Compute the stresses at a throw's fillets; if impossible, the other results remain.

    Parameters
    ----------
    mesh : {"adaptive", "m53"}
        See `fem.fillet_stress.fillet_stresses`.

    Returns
    -------
    str or None
        Why there are none.
    """
    try:
        return fillet_stress.fillet_stresses(throw, material, ACCURACY, mesh=mesh), None
    except (InputError, MeshError, SolveError) as error:
        return None, str(error)


def shown_loads(stresses: FilletStresses) -> FilletStresses:
    """Return the stresses under the loads that are pictured: radial on the first pin, and a torque."""
    loaded = stresses.loaded
    kept = [
        place
        for kind in KINDS_SHOWN
        for place, load in enumerate(loaded.loads)
        if load.kind == kind and load.pin in (None, 0)
    ]
    return of_loads(stresses, kept)


def of_loads(stresses: FilletStresses, kept: Sequence[int]) -> FilletStresses:
    """Return the stresses under some of the loads, by their indices."""
    loaded = stresses.loaded
    loads = tuple(loaded.loads[place] for place in kept)
    return replace(
        stresses,
        peaks=tuple(peak for peak in stresses.peaks if peak.load in loads),
        hole_peaks=tuple(peak for peak in stresses.hole_peaks if peak.load in loads),
        loaded=replace(
            loaded,
            loads=loads,
            shares=tuple(
                (symmetry, np.take(field, kept, axis=2)) for symmetry, field in loaded.shares
            ),
        ),
        surface=replace(stresses.surface, stress=np.take(stresses.surface.stress, kept, axis=1)),
    )


def stress_files(stresses: FilletStresses) -> dict[str, str]:
    """Return picture name to file name of the pictures of `StressRendering`."""
    names = [picture_name(load) for load in stresses.loaded.loads]
    return {Path(name).stem.replace("-", "_"): name for name in names}


class StressRendering(OffscreenProcess):
    """The pictures of stresses being rendered in the background, into a folder.

    Parameters
    ----------
    stresses : FilletStresses
        `shown_loads` of a throw.
    folder : Path
        Folder of the `stress_files`.
    """

    def __init__(self, stresses: FilletStresses, folder: Path) -> None:
        super().__init__(RENDER, folder, picture_arrays(stresses))


# Stresses are printed for loads of 1 kN and 1 kN m, or of so many of the user's own units.
LOAD = 1000.0


StressPerLoad = Annotated[float, Quantity(".stress_unit")]
Stresses = Annotated[Array, Quantity(".stress_unit")]
Place = Annotated[Array, Quantity("m")]


@result("name", "factor")
class StressPeak(Result):
    """The largest stresses at one location under one unit load, as `fem.fillet_peaks.FilletPeak` has them."""

    name: str
    principal: StressPerLoad
    principal_place: Place
    principals: Stresses
    von_mises: StressPerLoad
    von_mises_place: Place
    shear: StressPerLoad
    shear_place: Place
    nominal: StressPerLoad
    factor: Number
    von_mises_factor: Number
    shear_factor: Number
    rule_factor: Annotated[float | None, Quantity("1")]
    error_estimate: Number
    quality: ReadingQuality


@result("name", "factor")
class FilletStress(StressPeak):
    """The largest stresses at a fillet."""

    name: Annotated[str, Quantity(key="fillet")]
    radius: Annotated[float, Quantity("m")]


@result("name", "factor")
class OilHoleStress(StressPeak):
    """The largest stresses at an exit of an oil hole."""

    name: Annotated[str, Quantity(key="exit")]
    diameter: Annotated[float, Quantity("m")]
    exit_radius: Annotated[float, Quantity("m")]


@result("load", "unit")
class LoadStresses(Result):
    """The stresses of a throw under one unit load."""

    load: str
    kind: str
    unit: str
    stress_unit: str
    fillets: tuple[FilletStress, ...]
    oil_holes: tuple[OilHoleStress, ...]

    @property
    def peaks(self) -> tuple[FilletStress | OilHoleStress, ...]:
        """Those of fillets, then those of oil holes."""
        return (*self.fillets, *self.oil_holes)


@result("error_estimate", "accuracy", "unknowns")
class StressResults(Result):
    """Stresses at a throw's fillets and oil holes under unit loads."""

    dimensions: CrankThrow | ThrowInFile
    material: Material
    support: str
    end_sections: str
    loads: tuple[LoadStresses, ...]
    sharp_corners: tuple[str, ...]
    error_estimate: Number
    accuracy: Number
    accuracy_met: bool
    elements_across_fillets: Number
    mesh: str
    meshings: tuple[FilletMeshing, ...]
    rule_met: bool
    unknowns: int
    solved_part: str
    mended_elements: int
    meshing_attempts: tuple[str, ...]
    solver: str
    pictures: tuple[str, ...] = ()

    @property
    def mirrored(self) -> bool:
        """Whether the left half of a throw, symmetric about its middle, is sufficient."""
        return self.solved_part == "quarter"

    def tables(self, units: OutputUnits = SI) -> list[Table]:
        """Return a table of the largest stresses for each load; of a symmetric throw the left half."""
        length, pascals = units.of("mm"), units.of("MPa")
        digits = 2 if length.wished else 1
        tables = []
        for load in self.loads:
            holes = load.oil_holes
            shown = load.fillets[: len(load.fillets) // 2] if self.mirrored else load.fillets
            peaks: tuple[FilletStress | OilHoleStress, ...] = (*shown, *holes)
            # In Pa per N or N m of the load.
            newtons = units.of(load.unit)
            per = f"{LOAD:.0f} {newtons.name}" if newtons.wished else f"k{load.unit}"
            stress = OutputUnit(
                f"{pascals.name} per {per}",
                pascals.size / (LOAD * newtons.size),
                wished=pascals.wished or newtons.wished,
            )
            by_rule = any(peak.rule_factor is not None for peak in peaks)
            tables.append(
                Table(
                    f"{load.load.capitalize()}: largest stresses at fillets"
                    f"{' and exits of oil holes' if holes else ''} [{stress.name}]",
                    [
                        Column("fillet or exit" if holes else "fillet", words=True),
                        *(
                            Column(name, stress, bare=True)
                            for name in ("principal", "Mises", "nominal")
                        ),
                        Column("factor", decimals=2),
                        *([Column("M53", decimals=2)] if by_rule else []),
                        Column("principal at x y z", length),
                    ],
                    [
                        [
                            peak.name.replace("main journal", "journal"),
                            *(peak.principal, peak.von_mises, peak.nominal, peak.factor),
                            *([peak.rule_factor] if by_rule else []),
                            " ".join(
                                f"{round(value / length.size, digits) + 0.0:.{digits}f}"
                                for value in peak.principal_place
                            ),
                        ]
                        for peak in peaks
                    ],
                    main=True,
                )
            )
        return tables

    def factor_table(self) -> Table:
        """Return the factors of all loads by fillet and exit."""
        tables = (table.select(table.columns[0].name, "factor") for table in self.tables())
        columns = [{str(name): factor for name, factor in table.rows} for table in tables]
        names = dict.fromkeys(name for factors in columns for name in factors)
        return Table(
            "Stress concentration factors",
            [
                Column("fillet or exit", words=True),
                *(Column(load.load.lower(), decimals=2, missing="") for load in self.loads),
            ],
            [[name, *(factors.get(name) for factors in columns)] for name in names],
        )

    def sentences(self) -> list[str]:
        """Remarks that the tables do not contain."""
        sentences = [
            f"Ends pinned, end sections {self.end_sections}. Principal: the largest in magnitude, at the "
            "location given; Mises: the largest equivalent stress by von Mises; factor: size of the "
            "principal stress divided by the nominal one, which is a shear stress under a torque; M53: the "
            "factor as UR M53 defines it, at fillets by the largest shear stress under a torque, by von "
            "Mises in bending."
        ]
        if self.mirrored:
            sentences.append(
                "The fillets at the right web have the same stresses, under a torque with the opposite sign."
            )
        if self.solved_part != "full":
            sentences.append(
                "Locations at -x have the same stresses, under a torque and bending across the crank plane "
                "with the opposite sign."
            )
        if self.sharp_corners:
            sentences.append(
                f"No stress is given at {'; '.join(self.sharp_corners)}: without a fillet the elastic "
                "stress has no bound."
            )
        if any(load.oil_holes for load in self.loads):
            sentences.append(
                "The exit of an oil hole is its rim and the hole to a depth of one diameter; nominal: the "
                "stress of the pin or main journal without the hole, on its extreme fiber, wherever the "
                "hole points."
            )
        if self.mesh == "m53":
            sentences += self.rule_sentences()
        errors = [peak.error_estimate for load in self.loads for peak in load.peaks]
        met = "" if self.accuracy_met else f", not the {percent(self.accuracy, 2)} % requested"
        sentences.append(
            Main(
                f"Estimated errors of the stresses: {100.0 * min(errors):.2g} to "
                f"{percent(max(errors), 2)} %{met}."
            )
        )
        return sentences

    def rule_sentences(self) -> list[str]:
        """The requirements of UR M53, Appendix III, on mesh and stresses, and the values reached."""
        meshings = self.meshings
        layers = [max(meshing.layers[k] for meshing in meshings) for k in range(len(LAYERS))]
        read = [
            fillet.quality
            for load in self.loads
            if load.kind in RULE_LOADS
            for fillet in load.fillets
        ]

        def verdict(checks: Sequence[FilletMeshing | ReadingQuality]) -> str:
            return "met" if all(check.met for check in checks) else "not met"

        return [
            f"Mesh of UR M53, Appendix III, {verdict(meshings)}: largest element of the fillets "
            f"{_up(max(meshing.size_share for meshing in meshings), 2)} of the radius (allowed "
            f"{LARGEST_SIZE:g}), "
            f"layers below {', '.join(_up(layer, 1) for layer in layers)} quarters of it (1, 2, 3), "
            f"{_down(min(meshing.across_web for meshing in meshings), 1)} elements across the web "
            f"({ACROSS_WEB:.0f} or more).",
            "Its criteria where stresses are read under torque, bending in the crank plane and radial force, "
            f"{verdict(read)}: smallest principal stress up to "
            f"{100.0 * max(quality.normal_share for quality in read):.1f} % of the largest "
            f"(below {100.0 * LARGEST_NORMAL:.0f} %), elements within "
            f"{_up(100.0 * max(quality.spread for quality in read), 1)} % of their mean "
            f"({100.0 * LARGEST_SPREAD:.0f} %).",
        ]


def stress_results(stresses: FilletStresses) -> StressResults:
    """Return the numbers of stresses at a throw's fillets and oil holes."""
    loaded, mesh = stresses.loaded, stresses.loaded.mesh
    return made_from(
        stresses,
        StressResults,
        dimensions=dimensions_of(stresses.throw),
        material=loaded.material,
        support="pinned",
        end_sections=loaded.end_sections,
        loads=tuple(
            LoadStresses(
                load=load.name,
                kind=load.kind,
                unit=load.unit,
                stress_unit=f"Pa/({load.unit})" if " " in load.unit else f"Pa/{load.unit}",
                fillets=tuple(
                    made_from(peak, FilletStress, radius=peak.fillet.radius)
                    for peak in stresses.under(load)
                ),
                oil_holes=tuple(
                    made_from(
                        peak,
                        OilHoleStress,
                        diameter=2.0 * peak.outlet.drilling.radius,
                        exit_radius=peak.outlet.drilling.exit_radius,
                    )
                    for peak in stresses.at_oil_holes(load)
                ),
            )
            for load in loaded.loads
        ),
        elements_across_fillets=stresses.fineness,
        unknowns=mesh.unknowns,
        solved_part=mesh.part,
        mended_elements=mesh.mended_elements,
        meshing_attempts=mesh.attempts,
        solver=loaded.solver,
    )


def _up(value: float, decimals: int) -> str:
    """Return a number rounded up, so that a value above its limit never appears to meet it."""
    return f"{math.ceil(round(value * 10**decimals, 6)) / 10**decimals:.{decimals}f}"


def _down(value: float, decimals: int) -> str:
    """Return a number rounded down, so that a value below its limit never appears to meet it."""
    return f"{math.floor(round(value * 10**decimals, 6)) / 10**decimals:.{decimals}f}"
