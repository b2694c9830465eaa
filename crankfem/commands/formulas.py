"""The published formulas: for one throw, for all shipped engines, and the survey's own table."""

import functools
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from crankfem import console, formula_tables
from crankfem.angle_argument import checked_gamma
from crankfem.commands.options import JsonOption
from crankfem.console import parse_pairs, print_json
from geometry.errors import InputError


def formulas(
    engine: Annotated[
        str | None,
        typer.Argument(
            metavar="ENGINE.toml",
            help="Engine file, or the name of a shipped engine; none with --all or --published.",
        ),
    ] = None,
    gamma: Annotated[
        float | None,
        typer.Option(help="Angle between neighboring cranks in deg.", show_default="180"),
    ] = None,
    variant: Annotated[
        str | None,
        typer.Option(
            help="Reading: corrected, printed, plain (TsNIIMF) or k/4 (Draminsky 2).",
            show_default="corrected",
        ),
    ] = None,
    constant: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="An open constant of a formula: C, k_3, k_or, k_n or k_gorbunov; once for each.",
        ),
    ] = None,
    fe: Annotated[bool, typer.Option(help="Also compute the finite element value.")] = True,
    all_engines: Annotated[
        bool, typer.Option("--all", help="Formula / finite elements for all shipped engines.")
    ] = False,
    published: Annotated[
        bool, typer.Option("--published", help="The published table, repaired values marked.")
    ] = False,
    json: JsonOption = False,
) -> None:
    """Show the published formulas for a throw, or all shipped engines, beside finite elements."""
    if (engine is not None) + all_engines + published != 1:
        raise InputError("formulas: give one of ENGINE.toml, --all and --published.")
    if published:
        _refuse_beside_published(
            {
                "--gamma": gamma is not None,
                "--variant": variant is not None,
                "--constant": bool(constant),
                "--no-fe": not fe,
            }
        )
        _published(json)
        return
    constants = parse_pairs(constant or [], _pure_number, example="k_n=0.4")
    angle = 180.0 if gamma is None else checked_gamma(gamma)
    reading = variant or "corrected"
    if engine is None:
        _all_engines(angle, reading, constants, fe, json)
    else:
        _one_throw(engine, angle, reading, constants, fe, json)


def _refuse_beside_published(given: Mapping[str, bool]) -> None:
    for option in (name for name, is_given in given.items() if is_given):
        raise InputError(
            f"{option}: given together with --published; allowed is one of the two, because the "
            "published table is shown as it was printed."
        )


def _one_throw(
    engine: str,
    gamma: float,
    variant: str,
    constants: Mapping[str, float],
    fe: bool,
    json: bool,
) -> None:
    from crankfem.formula_records import fe_record, formula_records
    from crankfem.throw_file import load_throw
    from fem.analysis import analyze_throw

    dimensions, material = load_throw(engine)
    records: dict[str, Any] = dict(formula_records(dimensions, material, gamma, variant, constants))
    records |= {"gamma_deg": gamma, "constants": dict(constants)}
    if fe:
        records["fe"] = fe_record(analyze_throw(dimensions, material), gamma)
    if json:
        print_json(records)
    else:
        formula_tables.print_one_throw(records, gamma, constants)


def _all_engines(
    gamma: float, variant: str, constants: Mapping[str, float], fe: bool, json: bool
) -> None:
    from crankfem.data_files import shipped_engines
    from crankfem.formula_spread import engine_spread, spread_of_engines, spread_record
    from crankfem.throw_file import load_throw

    if not fe:
        raise InputError(
            "--no-fe: given together with --all; allowed is one of the two, because --all compares "
            "with finite elements."
        )
    spreads = spread_of_engines(
        [(name, *load_throw(name)) for name in shipped_engines()],
        functools.partial(engine_spread, gamma_deg=gamma, variant=variant, constants=constants),
        lambda place, count, name: console.errors.print(
            f"finite elements: {name} ({place} of {count})", highlight=False
        ),
    )
    if json:
        engines = [spread_record(spread) for spread in spreads]
        print_json({"gamma_deg": gamma, "constants": dict(constants), "engines": engines})
    else:
        formula_tables.print_spread(spreads, gamma, variant, constants)


def _published(json: bool) -> None:
    from crankfem.data_files import data_folder
    from regression.formulas.published_table import FINITE_ELEMENTS_DOUBT, read_published_table

    values = read_published_table(data_folder() / "tables" / "axial_compliance_published.csv")
    if not json:
        formula_tables.print_published(values)
        return
    print_json(
        {
            "unit": "m/N",
            "values": [
                {
                    "engine": value.engine,
                    "formula": value.formula,
                    "printed": value.printed,
                    "exponent_factor": value.exponent_factor,
                    "repaired": value.repaired,
                    "group": value.group,
                    "doubt": value.doubt,
                }
                for value in values
            ],
            "finite_elements_doubt": FINITE_ELEMENTS_DOUBT,
        }
    )


def _pure_number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"constant {name}: given {text!r}; allowed is a plain number, because the formulas' "
            "constants have no unit."
        ) from None
