"""Write docs/validation.md from docs/validation-figures.json and the docstrings of tests/validation.

A file's docstring opens with a title and the paragraphs ``Source:`` and ``Tolerance:``; what follows them
stays in the file. Figures: ``pytest tests/validation -m "" --figures docs/validation-figures.json`` (files
can be run one by one, the figures of the others stay). Then run this script; a test compares.
"""

import ast
import json
import math
import re
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
TESTS = HERE.parent / "tests" / "validation"
FIGURES = HERE / "validation-figures.json"
PAGE = HERE / "validation.md"
FEWEST_DIGITS, MOST_DIGITS = 3, 8
ROUND_OFF = 1e-6
NO_BREAK = "\N{NO-BREAK SPACE}"
# Mark of a percentage, by the kind of the deviation.
PERCENT_OF = {"relative": "", "scaled": NO_BREAK + r"\*"}

INTRODUCTION = """---
hide:
  - navigation
  - toc
---

# Validation

crankfem compared with other programs, published figures, finer models and closed forms, in one table. Each
case is the test file of this name in `tests/validation/`. A figure reads *crankfem / reference: difference
(allowed)*, in percent of the reference (% \\*: of the largest value of its kind, or of the load), or in the
unit; of many numbers the one with the largest difference. Shown are the principal figures of a case and,
beyond round-off, the one nearest to its tolerance; [all figures](validation-figures.json).

Not covered: an amplitude measured on a running engine. The published measurements used here do not print the
cylinder pressure. A few references are earlier results of crankfem itself, kept to show changes; their case
says so. See [accuracy](accuracy.md) for the estimate of the discretization error and
[benchmarks](benchmarks.md) for times.
"""

HEAD = """<div class="cases" markdown>

| case | source | figures | tolerance and its reason |
| --- | --- | --- | --- |"""

REPEAT = """To repeat (five minutes on two cores; without CalculiX its cases are skipped):

```sh
apt-get install calculix-ccx
pytest tests/validation -m "" --figures docs/validation-figures.json
python docs/build_validation.py
```
"""

# Cases in the table's order, with the figures that it shows first.
GROUPS: dict[str, dict[str, tuple[str, ...]]] = {
    "Outside programs": {
        "test_calculix": ("axial compliance, pinned", "torsional compliance, pinned"),
        "test_exported_meshes": ("axial compliance of the plain .inp by CalculiX",),
        "test_throw_reference_values": ("fillets: e_n pinned", "fillets: torsion, pinned"),
        "test_v6_turning": ("Modelica: speed",),
        "test_mwm_forced": ("amplitudes of torques",),
        "test_mwm_pressure": (
            "half peak-to-peak torque at 2000 1/min",
            "plain sum of all orders, its largest",
        ),
        "test_transient_mwm": ("run-up by DOP853: torques",),
        "test_least_squares": ("coefficients, of the largest",),
    },
    "Published figures": {
        "test_published_chains": ("MWM: frequencies",),
        "test_printed_plants": ("container drive: frequencies",),
        "test_direct_drive_plant": ("critical speed of order 5",),
        "test_yamz5340": ("first two harmonics",),
        "test_excitation_yamz": ("orders 0.5 and 1",),
        "test_rod_models_paper": ("difference of static and dynamic model, at the same angle",),
        "test_rod_models_figure": ("figure 4a: largest difference at the same angle",),
        "test_articulated_v8": ("second order, major axis by the masses alone",),
        "test_hinge_paper": ("best pressure ratio for 1.95 times the force",),
        "test_published_table": ("Dorey by Draminsky (1), as repaired",),
        "test_paper_study": (
            "engine left out: axial compliance pinned",
            "36 runs: largest error of 30 held-out designs",
        ),
        "test_limit_rules": ("intermediate shaft, continuous running",),
        "test_crankshaft_strength": ("solid crank with overlap, printed coefficients",),
    },
    "Finer models": {
        "test_shaft_against_3d": (
            "free, flat: frequencies 1 to 5",
            "free, cross-plane: frequencies 1 to 5",
        ),
        "test_excitation_axial": ("first axial mode of the chain",),
        "test_end_sections": ("rigid sections, in line: too stiff by",),
        "test_law": (
            "error of e_n pinned, largest",
            "error of e_n pinned, real throws, rms",
            "error of e_n pinned, real throws, largest",
        ),
        "test_section_seams": ("sections 2, bending: seam",),
        "test_short_journals": (
            "four throws, degree 2, frequencies 1 to 5",
            "six throws, degree 2, frequencies 1 to 5",
        ),
        "test_line_and_propeller": (
            "three throws, coupling: frequencies 1 and 2",
            "three throws, one solid: frequencies 1 to 5",
        ),
        "test_symmetry_parts": ("axial compliance",),
        "test_element_factors": ("overlap: alpha_B",),
        "test_reaction_lookups": (
            "axial reaction, root mean square error, ends pinned, radial force",
        ),
        "test_slopes": (),
    },
    "Closed forms, throws": {
        "test_straight_shaft": ("rigid ends, two lengths: stretch",),
        "test_frame_limit": ("axial pinned: frame missed by",),
        "test_formula_limits": ("Draminsky (1) against the frame",),
        "test_convergence": ("e_n, limit of nested meshes, filleted",),
        "test_stress_concentration": (
            "shoulder fillet: factor in bending",
            "hyperbolic notch: bending",
        ),
        "test_oil_holes": ("bar in bending",),
        "test_dynamic_shaft": (
            "bar, torsional frequencies 1 to 3",
            "four throws: error up to 800 Hz",
        ),
        "test_named_throws": ("natural frequencies",),
        "test_study_limits": (),
    },
    "Closed forms, engines": {
        "test_chain_closed_forms": ("equal masses, free: frequencies",),
        "test_damper_optimum": ("viscous damper: least peak",),
        "test_damped_criticals": ("critical speed",),
        "test_engines_of_our_own": ("critical speed",),
        "test_driven_and_geared": ("torque, all orders",),
        "test_elastic_bearings": ("first torsional frequency",),
        "test_misfiring": (),
        "test_assumptions": (),
        "test_hinge_given": ("hinge moment",),
        "test_compliance_sources": ("lowest frequency",),
        "test_axial_force_over_cycle": ("force on the thrust bearing",),
        "test_equilibrium_of_chains": ("by masses, 6ChN 25/34",),
        "test_bearing_range": ("lowest first frequency",),
        "test_chain_difference": ("rigid chain and causes",),
        "test_first_modes": (),
        "test_worst_place": (),
        "test_gas_cycle": ("isentropic compression pressure",),
        "test_power_and_load": (),
        "test_known_balance": ("four in line: force of order 2",),
    },
}


def docstring(file: str) -> str:
    """Return what a test file says of itself."""
    text = (TESTS / f"{file}.py").read_text(encoding="utf-8")
    return ast.get_docstring(ast.parse(text)) or ""


def title(file: str) -> str:
    """Return the first sentence, without its period."""
    return _escaped(" ".join(docstring(file).split("\n\n")[0].split()).rstrip("."))


def paragraph(file: str, label: str) -> str:
    """Return the paragraph that begins with this label, without the label."""
    for text in docstring(file).split("\n\n"):
        if text.startswith(f"{label}: "):
            plain = _escaped(" ".join(text.split()).removeprefix(f"{label}: "))
            return re.sub(r"doi (10\.\S+?)(?=[,;:.)]*(?: |$))", r"[doi](https://doi.org/\1)", plain)
    raise ValueError(f"tests/validation/{file}.py has no paragraph '{label}:'.")


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
            values.append(f"{number(off, few)}{NO_BREAK}{_unit(row)}".strip())
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


def shown_rows(file: str, entry: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the figures that the table shows: those named, and the tightest unless it is round-off."""
    rows = {row["what"]: row for row, _ in worst_rows(entry)}
    named = [rows[what] for heading in GROUPS.values() for what in heading.get(file, ())]
    tightest = max(rows.values(), key=_used)
    shown = tightest in named or (named and tightest["allowed"] <= ROUND_OFF)
    return named if shown else [*named, tightest]


def _unit(row: dict[str, Any]) -> str:
    return "" if row["unit"] == "1" else str(row["unit"])


def _figure(row: dict[str, Any]) -> str:
    ours, theirs, off, allowed = shown(row)
    # In an absolute figure the unit stands beside the difference.
    unit = f"{NO_BREAK}{_unit(row)}" if _unit(row) and row["kind"] != "absolute" else ""
    return f"{_escaped(row['what'])}: {ours} / {theirs}{unit}: {off} ({allowed})"


def _line(file: str, entry: dict[str, Any]) -> str:
    figures = "<br>".join(map(_figure, shown_rows(file, entry)))
    case = f'<a id="{file}"></a>{title(file)}<br>`{file}`'
    source, tolerance = (paragraph(file, label) for label in ("Source", "Tolerance"))
    return f"| {case} | {source} | {figures} | {tolerance} |"


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


def page() -> str:
    """Return the text of the page."""
    figures = json.loads(FIGURES.read_text(encoding="utf-8"))
    count = sum(count for entry in figures.values() for _, count in worst_rows(entry))
    lines = [INTRODUCTION, HEAD]
    for heading, files in GROUPS.items():
        lines.append(f"| **{heading}** | | | |")
        lines += [_line(file, figures[file]) for file in files]
    lines.append("\n</div>")
    lines.append(f"\n{len(figures)} cases compare {count:,} numbers. {_versions(figures)}\n")
    return "\n".join([*lines, REPEAT])


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
