"""Convergence of the axial compliance with the mesh, sharp and filleted, and the error estimate.

Run by hand: ``python benchmarks/convergence.py``. Its table is kept in docs/accuracy.md.
"""

import time

import crankfem as cf

DIMENSIONS = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "main_journal_length": 0.120,
    "pin_length": 0.139,
    "web_width": 0.300,
    "web_thickness": 0.068,
}
ACCURACIES = (0.04, 0.02, 0.01, 0.005)


def main() -> None:
    print(
        "| fillet [mm] | accuracy asked | unknowns | e_n pinned | e_n guided | estimate | seconds |"
    )
    print("|---|---|---|---|---|---|---|")
    for fillet in (0.012, 0.0):
        throw = cf.CrankThrow(**DIMENSIONS, fillet_radius=fillet)
        for accuracy in ACCURACIES:
            start = time.perf_counter()
            analysis = cf.analyze_throw(throw, accuracy=accuracy)
            seconds = time.perf_counter() - start
            print(
                f"| {fillet * 1e3:g} | {accuracy:.1%} | {analysis.mesh.unknowns} "
                f"| {analysis.axial_compliance('pinned') * 1e9:.4f}e-9 "
                f"| {analysis.axial_compliance('guided') * 1e9:.4f}e-9 "
                f"| {analysis.error_estimate:.2%} | {seconds:.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
