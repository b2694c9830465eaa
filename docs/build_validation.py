"""Write docs/validation.md from docs/validation-figures.json and from what the tests say of themselves.

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
# What stands behind a percentage, by the kind of the deviation.
PERCENT_OF = {"relative": "", "scaled": NO_BREAK + r"\*"}

INTRODUCTION = """# Validation

Does crankfem compute what it says? Each case on this page compares it with something that is not crankfem: a
closed form, another program, a figure in print, or a model that leaves out less. Nothing here is copied by
hand. Each figure is recorded by the test that checks it, at the place where it checks it, and this page is
made from these records. A test that finds a figure further off than allowed fails.

How to read the tables: *off by* is the deviation of what was found from the reference, and *allowed* is the
tolerance of the test. In percent both are relative to the reference (% \\* to the largest of its kind, or to
the load), otherwise they are differences. Where a figure stands for many numbers the one is shown that is
furthest off. A tolerance is never widened to pass; each has its reason, told with the case.

Some references are earlier results of crankfem itself, kept so that a change shows (golden numbers, what end
sections cost); they prove nothing else, and their case says so.

What is missing: an amplitude measured on a running engine. The publication used here that has some (the MWM
diesel) does not print the cylinder pressure behind them, so that only frequencies, shapes and the equations
themselves can be compared. How the discretization error is estimated, and how true the estimate is, stands in
[accuracy.md](accuracy.md); times are in [benchmarks.md](benchmarks.md).

To run it again (some five minutes on two cores; without CalculiX its cases are left out):

```sh
apt-get install calculix-ccx
pytest tests/validation -m "" --figures docs/validation-figures.json
python docs/build_validation.py
```
"""

# Heading of the group: a sentence, and its files with what they are compared with.
GROUPS: dict[str, tuple[str, dict[str, str]]] = {
    "Closed forms": (
        "Mechanics that can be solved on paper, or in a few lines that share nothing with crankfem.",
        {
            "test_straight_shaft": "strength of materials, Timoshenko's beam",
            "test_frame_limit": "the frame of thin beams",
            "test_formula_limits": "the frame of thin beams",
            "test_convergence": "Williams's exponents of corners",
            "test_stress_concentration": "Neuber's notch, Peterson's and Tipton's fillets",
            "test_oil_holes": "pierced cylinders; Peterson's and UR M53's factors",
            "test_dynamic_shaft": "bars in tension, torsion and bending",
            "test_chain_closed_forms": "chains of equal masses, the uniform rod",
            "test_damper_optimum": "Den Hartog's optima",
            "test_damped_criticals": "matrices, solved speed by speed",
            "test_engines_of_our_own": "matrices, solved speed by speed",
            "test_elastic_bearings": "matrices put together by hand",
            "test_misfiring": "chains solved cylinder by cylinder",
            "test_assumptions": "a class rule turned round by hand",
            "test_hinge_given": "slider-crank by hand, distances found by search",
            "test_compliance_sources": "eigenproblems scaled by hand, calculations at both ends",
            "test_axial_force_over_cycle": "matrices put together by hand",
            "test_bearing_range": "the same engine in bearings of one stiffness each",
            "test_chain_difference": "matrices put together by hand",
            "test_first_modes": "two inertias on a spring",
            "test_gas_cycle": "ideal cycles of thermodynamics",
            "test_power_and_load": "integral over the volume; MAN B&W 6S50MC-C, 9480 kW",
            "test_known_balance": "series of the slider-crank, handbooks",
            "test_named_throws": "sums and matrices by hand",
            "test_study_limits": "comparisons of the throws' own dimensions",
        },
    ),
    "Outside programs": (
        "The same problem, solved by others, or by a general integrator from equations written out in the "
        "test.",
        {
            "test_calculix": "CalculiX 2.20",
            "test_throw_reference_values": "independent finite elements, CalculiX 2.20",
            "test_v6_turning": "Modelica Standard Library 4.0.0",
            "test_mwm_forced": "equations written out, DOP853",
            "test_mwm_pressure": "Mendes et al. 2008, openTorsion",
            "test_transient_mwm": "DOP853, Duhamel's integral",
            "test_least_squares": "statsmodels, NIST's certified values",
        },
    ),
    "Published figures": (
        "What papers, books and rules print, where it can be followed. Where the print contradicts itself "
        "the case says so.",
        {
            "test_published_chains": "Mendes et al. 2008, Friswell et al.",
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
    "Models that leave out less": (
        "What crankfem simplifies, beside the same thing not simplified.",
        {
            "test_shaft_against_3d": "the whole solid in three dimensions",
            "test_excitation_axial": "the shaft of superelements",
            "test_end_sections": "the shaft without rigid sections",
            "test_law": "finite elements of throws kept out",
            "test_section_seams": "the same shaft, not cut",
            "test_short_journals": "the whole solid in three dimensions",
            "test_symmetry_parts": "the throw meshed as a half and whole",
            "test_element_factors": "the same throws on meshes twice as fine",
            "test_reaction_lookups": "finite elements of every throw, in place of equations",
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
    yield "| figure | found | reference | off by | allowed |\n| --- | --- | --- | --- | --- |"
    for row, count in worst_rows(entry):
        what = _escaped(row["what"])
        unit = f" \\[{row['unit']}\\]" if row["unit"] else ""
        cases = f" (worst of {count:,})" if count > 1 else ""
        yield f"| {what}{unit}{cases} | {' | '.join(shown(row))} |"


def _summary(figures: dict[str, Any]) -> Iterator[str]:
    yield "| case | compared with | numbers | worst of them | off by | allowed |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for _, files in GROUPS.values():
        for file, peer in files.items():
            rows = worst_rows(figures[file])
            row = max((row for row, _ in rows), key=_used)
            _, _, off, allowed = shown(row)
            count = sum(count for _, count in rows)
            yield (
                f"| [{title(file)}](#{file}) | {peer} | {count:,} | {_escaped(row['what'])} "
                f"| {off} | {allowed} |"
            )


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
    return f"The figures below were found on {when} with {libraries}."


def page() -> str:
    """Return the text of the page."""
    figures = json.loads(FIGURES.read_text(encoding="utf-8"))
    parts = [INTRODUCTION, f"{_versions(figures)}\n", "## All cases\n", *_summary(figures)]
    for heading, (sentence, files) in GROUPS.items():
        parts.append(f"\n## {heading}\n\n{sentence}")
        for file in files:
            parts.append(f'\n<a id="{file}"></a>\n\n### {title(file)}\n')
            parts.append(f"`tests/validation/{file}.py`")
            parts += [f"\n{paragraph}" for paragraph in prose(file)]
            parts += ["", *_table(figures[file])]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    (HERE / "validation.md").write_text(page(), encoding="utf-8")
