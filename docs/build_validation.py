"""Write docs/validation*.md from docs/validation-figures.json and the docstrings of tests/validation.

Figures: ``pytest tests/validation -m "" --figures docs/validation-figures.json`` (files can be run one by
one, the figures of the others stay). Then ``python docs/build_validation.py``; a test compares.
"""

import ast
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
TESTS = HERE.parent / "tests" / "validation"
FIGURES = HERE / "validation-figures.json"
FEWEST_DIGITS, MOST_DIGITS = 3, 8
NO_BREAK = "\N{NO-BREAK SPACE}"
# Mark of a percentage, by the kind of the deviation.
PERCENT_OF = {"relative": "", "scaled": NO_BREAK + r"\*"}

INTRODUCTION = """# Validation

Check crankfem's results against CalculiX, openTorsion, Modelica, statsmodels, published papers, class rules,
finer models and closed forms. Each line has one principal figure; its case links to all figures, sources and
tolerances.
"""

SOURCES = """## Independent sources

| source | compared results |
| --- | --- |
| CalculiX 2.20 | compliances, reactions and natural frequencies of throws and shafts |
| openTorsion, Mendes et al. 2008 | torque in the crankshaft of a diesel |
| Modelica Standard Library 4.0.0 | a freely turning V6 |
| statsmodels, NIST | regression |
| scipy's DOP853 | vibration over time |
| Yamanin, Zhukov, Baryshnikov 2018; Yamanin, Zhukov 2021 | rod models; axial compliances, regression |
| Makushev, Polyakova 2024; Mikhina, Vyalkov 2024 | torque harmonics; balance with hinged rods |
| Zotov, Imaeva 2024 | elastic hinge |
| Friswell et al., Wartsila, MAN B&W | frequencies, critical speeds, power |
| Korean Register 2025, IACS UR M53 and M68 | class rules |

Not covered: an amplitude measured on a running engine. The published measurements used here do not print the
cylinder pressure. A few references are earlier results of crankfem itself, kept to show changes; their case
states it. See [accuracy.md](accuracy.md) for the estimate of the discretization error and
[benchmarks.md](benchmarks.md) for times.
"""

READING = """## How the tables are made

Each test asserts and records its figures at once; `docs/build_validation.py` writes these pages from the
records. *Theirs* is the reference, *ours* the result of crankfem. The difference is in percent of the
reference (% \\*: of the largest value of its kind, or of the load), or in the unit. A figure that covers many
numbers shows the one with the largest difference. *Allowed* is the tolerance of the test; the case gives its
reason.

```sh
apt-get install calculix-ccx      # optional: without it its cases are skipped
pytest tests/validation -m "" --figures docs/validation-figures.json    # five minutes on two cores
python docs/build_validation.py
```
"""

# The principal figure of each case, shown in the first table; of a case not listed, the tightest one.
PRINCIPAL = {
    "test_calculix": "axial compliance, pinned",
    "test_exported_meshes": "axial compliance of the plain .inp by CalculiX",
    "test_throw_reference_values": "fillets: e_n pinned",
    "test_v6_turning": "Modelica: speed",
    "test_mwm_forced": "amplitudes of torques",
    "test_mwm_pressure": "half peak-to-peak torque at 2000 1/min",
    "test_transient_mwm": "run-up by DOP853: torques",
    "test_least_squares": "coefficients, of the largest",
    "test_published_chains": "MWM: frequencies",
    "test_printed_plants": "container drive: frequencies",
    "test_direct_drive_plant": "critical speed of order 5",
    "test_yamz5340": "first two harmonics",
    "test_excitation_yamz": "orders 0.5 and 1",
    "test_rod_models_paper": "difference of static and dynamic model, at the same angle",
    "test_rod_models_figure": "figure 4a: largest difference at the same angle",
    "test_articulated_v8": "second order, major axis by the masses alone",
    "test_hinge_paper": "best pressure ratio for 1.95 times the force",
    "test_published_table": "Dorey by Draminsky (1), as repaired",
    "test_paper_study": "engine left out: axial compliance pinned",
    "test_limit_rules": "intermediate shaft, continuous running",
    "test_crankshaft_strength": "solid crank with overlap, printed coefficients",
    "test_shaft_against_3d": "free, flat: frequencies 1 to 5",
    "test_excitation_axial": "first axial mode of the chain",
    "test_end_sections": "rigid sections, in line: too stiff by",
    "test_law": "error of e_n pinned, largest",
    "test_section_seams": "sections 2, bending: seam",
    "test_short_journals": "four throws, degree 2, frequencies 1 to 5",
    "test_line_and_propeller": "three throws, one solid: first torsional frequency",
    "test_symmetry_parts": "axial compliance",
    "test_element_factors": "overlap: alpha_B",
    "test_straight_shaft": "rigid ends, two lengths: stretch",
    "test_formula_limits": "Draminsky (1) against the frame",
    "test_stress_concentration": "shoulder fillet: factor in bending",
    "test_oil_holes": "bar in bending",
    "test_dynamic_shaft": "bar, torsional frequencies 1 to 3",
    "test_chain_closed_forms": "equal masses, free: frequencies",
    "test_damper_optimum": "viscous damper: least peak",
    "test_damped_criticals": "critical speed",
    "test_engines_of_our_own": "critical speed",
    "test_driven_and_geared": "torque, all orders",
    "test_elastic_bearings": "first torsional frequency",
    "test_axial_force_over_cycle": "force on the thrust bearing",
    "test_compliance_sources": "lowest frequency",
    "test_equilibrium_of_chains": "by masses, 6ChN 25/34",
    "test_bearing_range": "lowest first frequency",
    "test_chain_difference": "rigid chain and causes",
    "test_gas_cycle": "isentropic compression pressure",
    "test_hinge_given": "hinge moment",
    "test_known_balance": "four in line: force of order 2",
    "test_named_throws": "natural frequencies",
}

# Page of each group's details, the most important group first.
DETAILS = {
    "Outside programs": "validation-programs.md",
    "Published figures": "validation-published.md",
    "Finer models": "validation-finer-models.md",
    "Closed forms, throws": "validation-throws.md",
    "Closed forms, engines": "validation-engines.md",
}

# Heading of the group: a sentence, and its files with what they are compared with.
GROUPS: dict[str, tuple[str, dict[str, str]]] = {
    "Closed forms, throws": (
        "Closed forms of mechanics for throws, formulas and stresses.",
        {
            "test_straight_shaft": "strength of materials, Timoshenko's beam",
            "test_frame_limit": "the frame of thin beams",
            "test_formula_limits": "the frame of thin beams",
            "test_convergence": "Williams's exponents of corners",
            "test_stress_concentration": "Neuber's notch, Peterson's and Tipton's fillets",
            "test_oil_holes": "pierced cylinders; Peterson's and UR M53's factors",
            "test_dynamic_shaft": "bars in tension, torsion and bending",
            "test_named_throws": "sums and matrices by hand",
            "test_study_limits": "comparisons of dimensions by hand",
        },
    ),
    "Closed forms, engines": (
        "Closed forms for chains, dampers, engines and gas, or short independent calculations.",
        {
            "test_chain_closed_forms": "chains of equal masses, the uniform rod",
            "test_damper_optimum": "Den Hartog's optima",
            "test_damped_criticals": "matrices solved at each speed",
            "test_engines_of_our_own": "matrices solved at each speed",
            "test_driven_and_geared": "kinematics and matrices written anew",
            "test_elastic_bearings": "matrices assembled by hand",
            "test_misfiring": "chains solved cylinder by cylinder",
            "test_assumptions": "a class rule inverted by hand",
            "test_hinge_given": "slider-crank by hand, distances by search",
            "test_compliance_sources": "eigenproblems scaled by hand, calculations at both ends",
            "test_axial_force_over_cycle": "matrices assembled by hand",
            "test_equilibrium_of_chains": "Newton's second law, body by body",
            "test_bearing_range": "the same engine in bearings of one stiffness each",
            "test_chain_difference": "matrices assembled by hand",
            "test_first_modes": "two inertias on a spring",
            "test_worst_place": "the largest of all elements and speeds",
            "test_gas_cycle": "ideal cycles of thermodynamics",
            "test_power_and_load": "integral over the volume; MAN B&W 6S50MC-C, 9480 kW",
            "test_known_balance": "series of the slider-crank, handbooks",
        },
    ),
    "Outside programs": (
        "The same problem, solved by other programs, or by a general integrator of equations in the test.",
        {
            "test_calculix": "CalculiX 2.20",
            "test_exported_meshes": "CalculiX 2.20, gmsh, MEDCoupling, VTK, meshio",
            "test_throw_reference_values": "independent finite elements, CalculiX 2.20",
            "test_v6_turning": "Modelica Standard Library 4.0.0",
            "test_mwm_forced": "equations in the test, DOP853",
            "test_mwm_pressure": "Mendes et al. 2008, openTorsion",
            "test_transient_mwm": "DOP853, Duhamel's integral",
            "test_least_squares": "statsmodels, NIST's certified values",
        },
    ),
    "Published figures": (
        "Figures of papers, books and rules that can be reproduced; the case states contradictions in print.",
        {
            "test_published_chains": "Mendes et al. 2008, Friswell et al.",
            "test_printed_plants": "printouts of makers, IEEE, Kundur 1994",
            "test_direct_drive_plant": "data of Wartsila",
            "test_yamz5340": "Makushev, Polyakova 2024",
            "test_excitation_yamz": "Makushev, Polyakova 2024",
            "test_rod_models_paper": "Yamanin, Zhukov, Baryshnikov 2018",
            "test_rod_models_figure": "Yamanin, Zhukov, Baryshnikov 2018",
            "test_articulated_v8": "Mikhina, Vyalkov 2024",
            "test_hinge_paper": "Zotov, Imaeva 2024",
            "test_published_table": "Yamanin, Zhukov 2021",
            "test_paper_study": "Yamanin, Zhukov 2021, own designs held out",
            "test_limit_rules": "Korean Register 2025, IACS M68",
            "test_crankshaft_strength": "Korean Register 2025, IACS M53",
        },
    ),
    "Finer models": (
        "Simplifications of crankfem, compared with models without them.",
        {
            "test_shaft_against_3d": "the whole solid in three dimensions",
            "test_excitation_axial": "the shaft of superelements",
            "test_end_sections": "the shaft without rigid sections",
            "test_law": "finite elements of excluded throws",
            "test_section_seams": "the uncut shaft",
            "test_short_journals": "the whole solid in three dimensions",
            "test_line_and_propeller": "the whole solid in three dimensions, with its line",
            "test_symmetry_parts": "half and whole meshes",
            "test_element_factors": "the same throws on meshes twice as fine",
            "test_reaction_lookups": "finite elements of each throw",
            "test_slopes": "differences between throws",
        },
    ),
}


def docstring(file: str) -> str:
    """Return what a test file says of itself."""
    text = (TESTS / f"{file}.py").read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(text)) or ""


def title(file: str) -> str:
    """Return the first sentence, without its period."""
    return _escaped(" ".join(docstring(file).split("\n\n")[0].split()).rstrip("."))


def prose(file: str) -> Iterator[str]:
    """Yield what follows the title as Markdown: paragraphs, lists, and indented lines as they are."""
    for paragraph in filter(str.strip, docstring(file).split("\n\n")[1:]):
        for kind, lines in _runs(paragraph.splitlines()):
            if kind == "code":
                yield "\n".join(["```text", *(line.removeprefix("    ") for line in lines), "```"])
            elif kind == "list":
                yield "\n".join(_escaped(item) for item in lines)
            else:
                text = _escaped(" ".join(lines))
                yield re.sub(r"^(Sources?|Tolerances?)([.:])", r"**\1\2**", text)


def _runs(lines: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield runs of a paragraph's lines that are prose, items of a list, or indented."""
    kind = "prose"
    run: list[str] = []
    for line in lines:
        if line.startswith("- "):
            new = "list"
        elif kind == "list" and line.startswith("  "):
            run[-1] += " " + line.strip()
            continue
        else:
            new = "code" if line.startswith("    ") else "prose"
        if new != kind and run:
            yield kind, run
            run = []
        kind = new
        run.append(line)
    if run:
        yield kind, run


def _escaped(text: str) -> str:
    """Return text whose signs mean nothing in Markdown, but for code in backquotes."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([\\*_<$\[\]])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def number(value: float, digits: int) -> str:
    """Return a number with these significant digits, and no fewer than its whole part has."""
    whole = len(str(int(abs(value)))) if 1.0 <= abs(value) < 10.0**MOST_DIGITS else 0
    text = f"{value:.{max(digits, whole)}g}"
    return re.sub(r"e([+-])0*(\d+)", lambda m: f"e{m[1].replace('+', '')}{m[2]}", text)


def shown(row: dict[str, Any]) -> tuple[str, str, str, str]:
    """Return what was found, the reference, the deviation and what is allowed, as texts."""
    allowed, reference = row["allowed"], row["reference"]
    if row["kind"] != "absolute":
        digits = math.ceil(-math.log10(allowed)) + 1
    else:
        size = abs(reference) or allowed
        digits = math.ceil(math.log10(size / allowed)) + 1
    digits = min(max(digits, FEWEST_DIGITS), MOST_DIGITS)
    values = [number(row["found"], digits if reference else 2), number(reference, digits)]
    for off, few in ((row["deviation"], 2), (allowed, 3)):
        if row["kind"] == "absolute":
            values.append(f"{number(off, few)}{NO_BREAK}{row['unit']}".strip())
        else:
            values.append(f"{number(100.0 * off, few)}{NO_BREAK}%{PERCENT_OF[row['kind']]}")
    return values[0], values[1], values[2], values[3]


def worst_rows(entry: dict[str, Any]) -> list[tuple[dict[str, Any], int]]:
    """Return the figures of a file, of those of one name the worst and how many numbers they are."""
    found: dict[str, list[dict[str, Any]]] = {}
    for figures in entry["tests"].values():
        for row in figures:
            found.setdefault(row["what"], []).append(row)
    return [(max(rows, key=_used), sum(row["numbers"] for row in rows)) for rows in found.values()]


def _used(row: dict[str, Any]) -> float:
    return float(row["deviation"] / row["allowed"])


def _table(entry: dict[str, Any]) -> Iterator[str]:
    yield "| figure | theirs | ours | difference | allowed |\n| --- | --- | --- | --- | --- |"
    for row, count in worst_rows(entry):
        cases = f" (worst of {count:,})" if count > 1 else ""
        ours, theirs, off, allowed = shown(row)
        yield f"| {_named(row)}{cases} | {theirs} | {ours} | {off} | {allowed} |"


def _named(row: dict[str, Any]) -> str:
    unit = f" \\[{row['unit']}\\]" if row["unit"] else ""
    return f"{_escaped(row['what'])}{unit}"


def principal(file: str, entry: dict[str, Any]) -> dict[str, Any]:
    """Return the figure of a file that the first table shows: the one named, else the tightest."""
    rows = [row for row, _ in worst_rows(entry)]
    named = [row for row in rows if row["what"] == PRINCIPAL.get(file)]
    return max(named or rows, key=_used)


def _summary(figures: dict[str, Any]) -> Iterator[str]:
    yield "| case | source | theirs | ours | difference |\n| --- | --- | --- | --- | --- |"
    for heading, page in DETAILS.items():
        for file, peer in GROUPS[heading][1].items():
            row = principal(file, figures[file])
            ours, theirs, off, _ = shown(row)
            case = f"[{title(file)}]({page}#{file}): {_named(row)}"
            yield f"| {case} | {peer} | {theirs} | {ours} | {off} |"


def _versions(figures: dict[str, Any]) -> str:
    dates = sorted({entry["date"] for entry in figures.values()})
    found: dict[str, set[str]] = {}
    for entry in figures.values():
        for name, version in entry["versions"].items():
            found.setdefault(name, set()).add(version)
    when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
    libraries = ", ".join(
        f"{name} {' and '.join(sorted(versions))}" for name, versions in found.items()
    )
    return f"Recorded on {when} with {libraries}."


def pages() -> dict[str, str]:
    """Return the text of each page, by its file's name."""
    figures = json.loads(FIGURES.read_text(encoding="utf-8"))
    count = sum(count for entry in figures.values() for _, count in worst_rows(entry))
    number_of = f"{len(figures)} cases compare {count:,} numbers. {_versions(figures)}"
    parts = [INTRODUCTION, *_summary(figures), f"\n{number_of}\n", SOURCES, READING]
    written = {"validation.md": "\n".join(parts)}
    for heading, (sentence, files) in GROUPS.items():
        parts = [f"# Validation: {heading.lower()}\n\n{sentence} [All cases](validation.md)."]
        for file in files:
            parts.append(f'\n<a id="{file}"></a>\n\n## {title(file)}\n')
            parts.append(f"`tests/validation/{file}.py`")
            parts += [f"\n{paragraph}" for paragraph in prose(file)]
            parts += ["", *_table(figures[file])]
        written[DETAILS[heading]] = "\n".join(parts) + "\n"
    return written


if __name__ == "__main__":
    for name, text in pages().items():
        (HERE / name).write_text(text, encoding="utf-8")
