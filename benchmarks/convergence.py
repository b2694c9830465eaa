"""Convergence of the axial compliance with the mesh, sharp and filleted, corrected and not.

Run by hand: ``python benchmarks/convergence.py``. Its table is kept in docs/accuracy.md.
"""

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
ACCURACIES = (0.02, 0.01, 0.005)


def main() -> None:
    print(
        "| fillet [mm] | accuracy asked | unknowns | e_n pinned, of the mesh | corrected | bar "
        "| e_n guided, corrected |"
    )
    print("|---|---|---|---|---|---|---|")
    for fillet in (0.012, 0.0):
        throw = cf.CrankThrow(**DIMENSIONS, fillet_radius=fillet)
        for accuracy in ACCURACIES:
            analysis = cf.analyze_throw(throw, accuracy=accuracy)
            print(
                f"| {fillet * 1e3:g} | {100.0 * accuracy:g} % | {analysis.mesh.unknowns} "
                f"| {analysis.discrete.axial_compliance('pinned') * 1e9:.4f}e-9 "
                f"| {analysis.axial_compliance('pinned') * 1e9:.4f}e-9 | {analysis.error_estimate:.2%} "
                f"| {analysis.axial_compliance('guided') * 1e9:.4f}e-9 |",
                flush=True,
            )


if __name__ == "__main__":
    main()
