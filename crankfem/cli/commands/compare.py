"""Comparison of two models, or of the studies behind them."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from crankfem.cli.commands import completion
from crankfem.cli.commands.options import Output, with_output
from crankfem.cli.console import print_json, print_line, print_table

if TYPE_CHECKING:
    from crankfem.analyses.study.model_comparison import ModelComparison
    from regression.models.compliance_model import ComplianceModel

# Smaller differences are round-off.
LEAST_SHOWN = 1e-7


def _argument(which: str) -> Any:
    return typer.Argument(
        metavar=f"{which}.json",
        help="Model file, or the store of a study (.sqlite), which is fitted.",
        autocompletion=completion.files(".json", ".sqlite"),
    )


@with_output()
def compare(
    first: Annotated[Path, _argument("FIRST")],
    second: Annotated[Path, _argument("SECOND")],
    *,
    out: Output,
) -> None:
    """Compare two models on the same throws, in the ranges of both."""
    from crankfem.analyses.study.model_comparison import compare_models

    models = _model(first), _model(second)
    found = compare_models(*models)
    if out.json:
        print_json(asdict(found), "comparison")
    else:
        _print_comparison(models[0], found)


def _model(path: Path) -> "ComplianceModel":
    from regression.models.compliance_model import ComplianceModel
    from regression.runs.store_file import is_database

    if not (path.is_file() and is_database(path)):
        return ComplianceModel.load(path)
    from crankfem.analyses.study.fitting import fit_study
    from crankfem.analyses.study.study_model import compliance_model
    from regression.runs.study import read_study

    table = read_study(path)
    return compliance_model(table, fit_study(table))


def _print_comparison(model: "ComplianceModel", found: "ModelComparison") -> None:
    from crankbase.tables.table import Column, Table
    from crankfem.cli.model_arguments import dimensions_text
    from regression.response_kinds import is_positive_response

    family = model.family
    common = [
        f"{name} {family.format_value(name, low)}"
        + (f" to {family.format_value(name, high)}" if high > low else "")
        for name, (low, high) in found.ranges.items()
    ]
    common += [f"{name} {' or '.join(labels)}" for name, labels in found.choices.items()]
    count = "1 throw" if found.throws == 1 else f"{found.throws} throws"
    print_line(f"{count} in the ranges of both models: {', '.join(common)}.")
    print_table(
        Table.of_records(
            "Second model less first, in % of the first",
            list(map(asdict, found.responses)),
            (Column("response", words=True), lambda r: r["response"].replace("_", " ")),
            (Column("mean"), lambda r: _percent(r["mean"])),
            (Column("rms"), lambda r: _percent(r["rms"]).lstrip("+")),
            (Column("largest"), lambda r: _percent(r["largest"])),
            (Column("largest / bands", digits=3, missing="open"), "by_bands"),
            (Column("bands apart", missing="open"), lambda r: _share(r["apart"])),
        )
    )
    print_line(
        "Largest / bands: the largest ratio of a difference to the sum of both error bands on the facing "
        "sides; above 1 the bands do not overlap. Bands apart: share of the throws where they do not "
        "overlap."
    )
    signed = [one.response for one in found.responses if not is_positive_response(one.response)]
    if signed:
        listed = ", ".join(name.replace("_", " ") for name in signed)
        print_line(
            f"In % of the root mean square of the first, which may be zero for single throws: {listed}."
        )
    worst = max(found.responses, key=lambda one: abs(one.largest))
    place = ", ".join(dimensions_text(model, worst.place))
    print_line(f"Largest difference, of {worst.response.replace('_', ' ')}: at {place}.")
    for name, reason in found.left_out.items():
        print_line(f"Not compared: {name.replace('_', ' ')}, because {reason}.")
    for remark in found.remarks:
        print_line(f"Note: {remark}")


def _percent(share: float) -> str:
    return f"{100.0 * share:+.3g}" if abs(share) >= LEAST_SHOWN else "0"


def _share(share: float | None) -> str | None:
    return None if share is None else f"{100.0 * share:.3g} %"
