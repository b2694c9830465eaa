"""The published formulas: for one throw, for all shipped engines, and the survey's own table."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.cli.commands import completion
from crankfem.cli.commands.options import GammaOption, Output, ThrowOption, with_output
from crankfem.cli.console import parse_pairs, print_json

if TYPE_CHECKING:
    from crankfem.analyses.throw.formula_records import EngineFormulas, EngineSpread, Formulas


@dataclass(frozen=True)
class _Request:
    """The options of the command line."""

    throw: str | None
    gamma: float
    variant: str
    constants: Mapping[str, float]
    fe: bool
    out: Output


@with_output(units=True, source="engines")
def formulas(
    engines: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="ENGINE.toml",
            help="Engine file, or the name of a shipped engine; several for a table of them; none with "
            "--all or --published.",
            autocompletion=completion.engines,
        ),
    ] = None,
    throw: ThrowOption = None,
    gamma: GammaOption = None,
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
            help="An open constant of a formula: C, k_3, k_or, k_n or k_gorbunov; may be repeated.",
        ),
    ] = None,
    fe: Annotated[bool, typer.Option(help="Also compute the finite element value.")] = True,
    all_engines: Annotated[
        bool, typer.Option("--all", help="Formula / finite elements for all shipped engines.")
    ] = False,
    published: Annotated[
        bool, typer.Option("--published", help="The published table, repaired values marked.")
    ] = False,
    *,
    out: Output,
) -> None:
    """Compare the published formulas with finite elements, for a throw or several engines."""
    from crankfem.cli.arguments import parse_gamma

    files = engines or []
    if bool(files) + all_engines + published != 1:
        raise InputError("formulas: give one of ENGINE.toml, --all and --published.")
    if throw is not None and len(files) != 1:
        raise InputError(
            f"--throw: given {throw!r} {'with several' if files else 'without'} ENGINE.toml; allowed is it "
            "with one, because its throws have names."
        )
    if published:
        beside = {
            "--gamma": gamma is not None,
            "--variant": variant is not None,
            "--constant": bool(constant),
            "--no-fe": not fe,
            "--units": bool(out.units.wished),
        }
        for option, is_given in beside.items():
            if is_given:
                raise InputError(
                    f"{option}: given together with --published; allowed is one of the two, because the "
                    "published table is shown as it was printed."
                )
        from crankfem.cli.tables import throw_tables
        from crankfem.files.reading.data_files import data_folder
        from regression.formulas.axial_formulas import FINITE_ELEMENTS_DOUBT, read_published_table

        values = read_published_table(data_folder() / "tables" / "axial_compliance_published.csv")
        if out.json:
            doubt = FINITE_ELEMENTS_DOUBT
            print_json({"unit": "m/N", "values": values, "finite_elements_doubt": doubt})
        else:
            out.show(throw_tables.published_parts(values))
        return
    asked = _Request(
        throw=throw,
        gamma=180.0 if gamma is None else parse_gamma(gamma, out.quiet),
        variant=variant or "corrected",
        constants=parse_pairs(constant or [], _pure_number, example="k_n=0.4"),
        fe=fe,
        out=out,
    )
    if not files:
        _all_engines(asked)
    elif len(files) == 1:
        _one_throw(files[0], asked)
    else:
        _some_engines(files, asked)


def _values(engine: str, asked: _Request) -> "Formulas":
    from crankfem.analyses.throw.formula_records import by_elements, formulas_of
    from crankfem.cli.arguments import select_throw
    from fem.analysis import analyze_throw
    from geometry.any_throw import with_dimensions

    throw, material = select_throw(engine, asked.throw, asked.out.quiet)
    dimensions = with_dimensions(throw)
    values = formulas_of(dimensions, material, asked.gamma, asked.variant, asked.constants)
    if asked.fe:
        fe = by_elements(analyze_throw(dimensions, material), asked.gamma)
        values = replace(values, fe=fe)
    return values


def _one_throw(engine: str, asked: _Request) -> None:
    from crankfem.cli.tables import throw_tables

    gamma, constants = asked.gamma, asked.constants
    values = replace(_values(engine, asked), gamma_deg=gamma, constants=constants)
    if asked.out.json:
        print_json(values)
    else:
        units = asked.out.units
        parts = throw_tables.one_throw_parts(values, gamma, constants, units)
        asked.out.show(parts, *throw_tables.formulas_answer(values, units))


def _some_engines(files: Sequence[str], asked: _Request) -> None:
    from crankfem.analyses.throw.formula_records import EngineFormulas
    from crankfem.cli.tables import throw_tables
    from crankfem.files.reading.data_files import input_path

    names = [input_path(file).stem for file in files]  # refuses all that are not there at once
    rows: list[EngineFormulas] = []
    for name, file in zip(names, files, strict=True):
        console.print_note(f"{name} ({len(rows) + 1} of {len(names)})", asked.out.quiet)
        rows.append(EngineFormulas(name, _values(file, asked)))
    if asked.out.json:
        _print_engines(rows, asked)
    else:
        asked.out.show(
            throw_tables.engines_parts(
                rows, asked.gamma, asked.variant, asked.constants, asked.out.units
            )
        )


def _print_engines(rows: "Sequence[EngineFormulas | EngineSpread]", asked: _Request) -> None:
    """Print as JSON what was calculated for each of several engines."""
    from crankfem.analyses.throw.formula_records import FormulasOfEngines

    print_json(FormulasOfEngines(asked.gamma, asked.constants, tuple(rows)))


def _all_engines(asked: _Request) -> None:
    from crankfem.analyses.throw.formula_records import engine_spread, spread_of_engines
    from crankfem.cli.tables import throw_tables
    from crankfem.files.engine.throw_file import load_throw
    from crankfem.files.reading.data_files import shipped_names
    from geometry.any_throw import with_dimensions

    if not asked.fe:
        raise InputError(
            "--no-fe: given together with --all; allowed is one of the two, because --all compares "
            "with finite elements."
        )
    spreads = spread_of_engines(
        [
            (name, with_dimensions(throw), material)
            for name in shipped_names("engine")
            for throw, material in [load_throw(name)]
        ],
        functools.partial(
            engine_spread, gamma_deg=asked.gamma, variant=asked.variant, constants=asked.constants
        ),
        lambda place, count, name: console.print_note(
            f"finite elements: {name} ({place} of {count})", asked.out.quiet
        ),
    )
    if asked.out.json:
        _print_engines(spreads, asked)
    else:
        asked.out.show(
            throw_tables.spread_parts(
                spreads, asked.gamma, asked.variant, asked.constants, asked.out.units
            )
        )


def _pure_number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"constant {name}: given {text!r}; allowed is a plain number, because the formulas' "
            "constants have no unit."
        ) from None
