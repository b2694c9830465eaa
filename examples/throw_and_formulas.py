"""How far are the published formulas from finite elements for one crank throw?"""

import crankfem as cf

throw = cf.CrankThrow(
    crank_radius=0.170,
    main_journal_diameter=0.220,
    pin_diameter=0.180,
    main_journal_length=0.120,
    pin_length=0.139,
    web_width=0.285,
    web_thickness=0.068,
    fillet_radius=0.012,
)
analysis = cf.analyze_throw(throw, material=cf.STEEL, accuracy=0.05)

for kind, compliance, unit, formulas in (
    ("axial", analysis.axial_compliance("pinned"), "m/N", cf.axial_formulas(analysis)),
    (
        "torsional",
        analysis.torsional_compliance("pinned"),
        "rad/(N m)",
        cf.torsional_formulas(analysis),
    ),
):
    print(f"{kind}, finite elements: {compliance:.3e} {unit}, error {analysis.error_estimate:.1%}")
    for name, formula in formulas.items():
        print(
            f"  {name:16} {formula.value:.3e} {unit}, ratio to FE {formula.value / compliance:.2f}"
        )
