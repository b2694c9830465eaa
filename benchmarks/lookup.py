"""Lookups in a compliance model: one value, arrays, and the import of what a lookup needs.

Run by hand: ``python benchmarks/lookup.py`` (20 seconds on one core). It prints a Markdown table; each time
is the best of five rounds, for other work on the machine only adds to it. The plain evaluation beside it is
that of `FittedForm.predict`: whole columns, one term after the other, without checks.
"""

import itertools
import os
import subprocess
import sys
import timeit
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fem.material import STEEL
from regression.fits.fits import fit_form
from regression.fits.forms import group_named
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel

ROOT = Path(__file__).resolve().parents[1]
ROUNDS = 5
MANY = 1_000_000
# What a lookup must do.
MOST_MICROSECONDS, LEAST_RATE, MOST_IMPORT_SECONDS = 20.0, 2e6, 0.5
HEAVY = ("gmsh", "vtk", "vtkmodules", "pyvista", "scipy", "pint", "skfem", "matplotlib", "meshio")

THREE = {"web_width": (0.270, 0.330), "web_thickness": (0.038, 0.098), "pin_length": (0.120, 0.158)}
EIGHT = THREE | {
    "crank_radius": (0.150, 0.190),
    "main_journal_diameter": (0.200, 0.240),
    "pin_diameter": (0.160, 0.200),
    "main_journal_length": (0.100, 0.140),
    "fillet_radius": (0.008, 0.014),
}
GROUPS = ("s/R", "R/h", "B/D_shm", "D_km/D_shm", "L_shm/D_shm", "L_km/D_shm", "r/D_shm")


def three_factors() -> ComplianceModel:
    """A full quadratic in the logarithms of three dimensions."""
    x = np.array(list(itertools.product(*(np.linspace(*ends, 3) for ends in THREE.values()))))
    y = 1.3e-9 * (x[:, 0] / 0.3) ** -0.8 * (x[:, 1] / 0.07) ** -1.2 * (x[:, 2] / 0.14) ** 0.4
    fit = fit_form("log-quadratic", tuple(THREE), x, y)
    return ComplianceModel(
        responses={"axial_compliance": ResponseModel.from_fit(fit, symbol="e_n", unit="m/N")}
    )


def eight_dimensions() -> ComplianceModel:
    """A full quadratic in seven groups of eight dimensions."""
    rng = np.random.default_rng(1)
    designs = {name: rng.uniform(*ends, 200) for name, ends in EIGHT.items()}
    x = np.stack([group_named(name).value(designs) for name in GROUPS], axis=-1)
    y = 40.0 * np.exp(0.3 * np.sin(x).sum(axis=1))
    fit = fit_form("log-quadratic", GROUPS, x, y)
    response = ResponseModel.from_fit(fit, symbol="e_n", unit="m/N", basis="groups")
    return ComplianceModel(
        responses={"axial_compliance": response}, ranges=EIGHT, material=STEEL.model_dump()
    )


def seconds(call: Callable[[], object], number: int) -> float:
    """Time of one call: the best of some rounds."""
    call()
    return min(timeit.repeat(call, number=number, repeat=ROUNDS)) / number


def import_seconds() -> tuple[float, str]:
    """Time of importing what a lookup needs in a fresh process, and what else it loads."""
    code = (
        "import sys, time; start = time.perf_counter(); import crankfem as cf; cf.ComplianceModel; "
        "print(time.perf_counter() - start); "
        f"print(*(name for name in {HEAVY} if name in sys.modules))"
    )
    best, loaded = float("inf"), ""
    for _ in range(ROUNDS):
        done = subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        first, _, loaded = done.stdout.partition("\n")
        best = min(best, float(first))
    return best, loaded.strip()


def measured(name: str, model: ComplianceModel, box: dict[str, tuple[float, float]]) -> bool:
    """Print the rows of one model; return whether it is fast enough."""
    point = {key: 0.5 * (low + high) for key, (low, high) in box.items()}
    rng = np.random.default_rng(2)
    middle = {key: (0.7 * a + 0.3 * b, 0.3 * a + 0.7 * b) for key, (a, b) in box.items()}
    arrays = {key: rng.uniform(*ends, MANY) for key, ends in middle.items()}
    response = model.responses["axial_compliance"]
    one = seconds(lambda: model.axial_compliance(**point), 20_000)
    told = seconds(lambda: model.lookup("axial_compliance", **point), 5_000)
    many = seconds(lambda: model.axial_compliance(**arrays), 1)

    def plain() -> object:
        if response.basis == "factors":
            columns = np.stack([arrays[key] for key in response.factors], axis=-1)
            return response.predict(columns)
        groups = [group_named(key).value(arrays) for key in response.factors]
        scale = STEEL.youngs_modulus * arrays["pin_diameter"]
        return response.predict(np.stack(groups, axis=-1)) / scale

    naive = seconds(plain, 1)
    agree = np.max(np.abs(np.asarray(plain()) / model.axial_compliance(**arrays) - 1.0))
    print(
        f"| {name} | {1e6 * one:.1f} | {1e6 * told:.1f} | {MANY / many / 1e6:.0f} | "
        f"{naive / many:.1f} | {agree:.0e} |"
    )
    return one * 1e6 <= MOST_MICROSECONDS and MANY / many >= LEAST_RATE


def main() -> None:
    print(
        "| model | one value [us] | lookup with band [us] | array [million/s] | plain / ours | differ by |"
    )
    print("|---|---|---|---|---|---|")
    fast = measured("three factors, log-quadratic", three_factors(), THREE)
    fast &= measured("seven groups of eight dimensions", eight_dimensions(), EIGHT)
    best, loaded = import_seconds()
    print(
        f"\nImport for lookups: {best:.2f} s; of {', '.join(HEAVY)} it loads: {loaded or 'none'}."
    )
    if not (fast and best <= MOST_IMPORT_SECONDS and not loaded):
        raise SystemExit("slower than promised")


if __name__ == "__main__":
    main()
