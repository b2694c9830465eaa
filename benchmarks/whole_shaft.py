"""The whole crankshaft of superelements: against finite elements of the whole solid, and its speed.

Run by hand: ``python benchmarks/whole_shaft.py [FINEST]`` (FINEST in mm, 22 by default, about ten minutes
and 8 GB; 18 takes 16 GB). It prints Markdown tables.

1. Frequencies of two four-throw shafts, free, as the mesh of the solid gets finer, and of superelements
   made to 1 % and to 0.3 % of compliance.
2. The coupled response of a six-throw shaft, 24 orders at 200 speeds, all forces, with free-end motion
   split into what tangential and radial forces do.
"""

import sys
import time
from types import SimpleNamespace

import numpy as np

import crankfem as cf
from crankfem.analyses.shaft.whole_shaft import shaft_throws
from dynamics.crankshaft.assembly import assemble_crankshaft
from dynamics.crankshaft.coupled_response import coupled_response
from dynamics.crankshaft.shaft_modes import crankshaft_modes, crankshaft_system
from dynamics.crankshaft.surroundings import AxialSupport, EndBody, MainBearings, ShaftSurroundings
from geometry.crankshaft import Crankshaft
from shaft_solid import mesh_shaft, solid_modes

THROW = cf.CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.300,
    web_thickness=0.068,
    fillet_radius=0.012,
)
SHAFTS = {"0-180-180-0": (0, 180, 180, 0), "0-90-270-180": (0, 90, 270, 180)}
SIZES = (0.05, 0.04, 0.03, 0.022, 0.018)
ACCURACIES = (0.01, 0.003)
HIGHEST = 600.0
SHOWN = 7


def row(*cells: object) -> None:
    """Print a row of a Markdown table."""
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def compare_with_solids(finest: float) -> None:
    """Print frequencies by meshes of the solid and by superelements."""
    superelements = {
        accuracy: cf.analyze_throw(THROW, accuracy=accuracy).dynamic_superelement(HIGHEST)
        for accuracy in ACCURACIES
    }
    for name, degrees in SHAFTS.items():
        print(f"\n### {name}, free\n")
        row("", "unknowns", "s", *(f"f{mode}" for mode in range(1, SHOWN + 1)))
        row(*["---"] * (3 + SHOWN))
        for size in (each for each in SIZES if each >= finest):
            start = time.perf_counter()
            mesh = mesh_shaft(Crankshaft([THROW] * 4, crank_angles_deg=degrees), size)
            found, _ = solid_modes(mesh, cf.STEEL, 6 + SHOWN)
            seconds = time.perf_counter() - start
            row(f"solid, {1e3 * size:g} mm", mesh.unknowns, f"{seconds:.0f}", *_shown(found[6:]))
        for accuracy, superelement in superelements.items():
            start = time.perf_counter()
            shaft = assemble_crankshaft(shaft_throws(superelement, THROW, crank_angles_deg=degrees))
            modes = crankshaft_modes(shaft)
            seconds = time.perf_counter() - start
            own = modes.frequencies[6 : 6 + SHOWN]
            row(
                f"superelements, {accuracy:.1%}",
                len(shaft.mass),
                f"{seconds:.2f}",
                *(
                    f"{value:.3f} ({100.0 * (value / solid - 1.0):+.2f} %)"
                    for value, solid in zip(own, found[6:], strict=True)
                ),
            )
            labels = [modes.label(mode) for mode in range(6, 6 + SHOWN)]
            row("", "", "", *labels)


def time_coupled_response() -> None:
    """Print how long the coupled response of six throws takes, step by step."""
    orders, speeds = np.arange(1, 25) * 0.5, np.linspace(20.0, 110.0, 200)
    rng = np.random.default_rng(0)
    shape = (24, 200, 6)
    tangential, radial = (
        1e4 * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) for _ in range(2)
    )
    forces = SimpleNamespace(
        orders=orders, speeds=speeds, tangential=tangential, radial=radial, throws=tuple(range(6))
    )
    marks = [time.perf_counter()]
    analysis = cf.analyze_throw(THROW)
    marks.append(time.perf_counter())
    superelement = analysis.dynamic_superelement(orders[-1] * speeds[-1] / (2.0 * np.pi))
    marks.append(time.perf_counter())
    around = ShaftSurroundings(
        bearings=MainBearings(2e9, 1e4),
        axial_supports=(AxialSupport(6, 1e9, 1e5),),
        flywheel=EndBody(1500.0, 300.0, overhang=0.1),
        free_end=EndBody(30.0, 2.0),
        pin_masses=(40.0,) * 6,
    )
    throws = shaft_throws(superelement, THROW, crank_angles_deg=(0, 120, 240, 240, 120, 0))
    crankshaft = crankshaft_system(assemble_crankshaft(throws, around), 500.0)
    marks.append(time.perf_counter())
    response = coupled_response(crankshaft, forces)
    response.split("main bearing 1 uz")
    marks.append(time.perf_counter())
    print("\n### Coupled response of six throws, 24 orders at 200 speeds\n")
    row("step", "s")
    row("---", "---")
    for name, seconds in zip(
        ("analysis of the throw, 1 %", "dynamic superelement", "system and modes", "response"),
        np.diff(marks),
        strict=True,
    ):
        row(name, f"{seconds:.2f}")
    row("all, without analysis and superelement", f"{marks[-1] - marks[2]:.2f}")
    row("all", f"{marks[-1] - marks[0]:.2f}")
    print(f"\n{len(crankshaft.system.mass)} unknowns; {response.tangential.method}")


def _shown(frequencies: np.ndarray) -> list[str]:
    return [f"{value:.3f}" for value in frequencies]


if __name__ == "__main__":
    time_coupled_response()
    compare_with_solids(1e-3 * float(sys.argv[1]) if len(sys.argv) > 1 else 0.022)
