"""Write data/tables/throw_compliances.csv: the throws of all shipped engines by finite elements.

Run from the root of the project, half a minute::

    python docs/build_throw_compliances.py

The published formulas are held against these values where one of them is the source of an engine's
compliances: that is what is known of their error.
"""

from crankfem.analyses.throw.formula_records import ACCURACY
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import data_folder, input_path, shipped_names
from crankfem.files.reading.toml_file import read_toml
from fem.analysis import analyze_throw
from fem.angle_law import effective_angle_law

HEAD = f"""\
# Compliances of each shipped engine with a throw of its own, by finite elements (written by
# docs/build_throw_compliances.py), estimated error within {100.0 * ACCURACY:g} %: relative, of the axial
# compliance. Axial between equal neighbors at an angle gamma:
# e_0 + (e_180 - e_0) / (1 + rho cot^2(gamma/2)), through gamma = 0, 90 and 180 deg, sections moving as
# polynomials of degree 2. Torsional: ends pinned. Of several throws that at the free end.
engine,e_0_m_per_N,e_180_m_per_N,rho,torsional_rad_per_Nm,error_estimate
"""


def main() -> None:
    """Analyze each throw and write a row for it."""
    rows, known = [], []
    for name in shipped_names("engine"):
        throw, material = load_throw(name)
        # A set has its engine's throw, and of a plant whose maker gives the chain the throw is assumed.
        of_plant = "plant" in read_toml(input_path(name)).sections.get("shaft_line", {})
        if of_plant or (throw, material) in known:
            continue
        known.append((throw, material))
        found = analyze_throw(throw, material, accuracy=ACCURACY)
        law = effective_angle_law(found.superelement)
        rows.append(
            f"{name},{law.in_line:.5e},{law.opposite:.5e},{law.ratio:.5f},"
            f"{found.torsional_compliance('pinned'):.5e},{found.error_estimate:.5f}\n"
        )
    (data_folder() / "tables" / "throw_compliances.csv").write_text(
        HEAD + "".join(rows), encoding="utf-8"
    )


if __name__ == "__main__":
    main()
