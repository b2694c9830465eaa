"""A throw's compliances, reactions and masses as plain JSON content."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from crankbase.quantity import percent
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.record import Record, attributes
from fem.analysis import ThrowAnalysis, axial_correction
from fem.modes import ThrowModes
from fem.solver import asymmetry
from fem.superelement import superelement_of_end_forces
from fem.supports import Neighbors, Support, reactions
from geometry.mass import unbalance
from geometry.mesher import Throw
from geometry.throw import CrankThrow
from regression.models.response_model import ResponseModel

# Of a throw on its supports, in the order of the columns.
ANSWERS = (
    "axial_compliance",
    "torsional_compliance",
    "influence_coefficient",
    "axial_force_per_radial",
)


def error_words(record: Record) -> str:
    """State the error of the axial compliance of a `throw_record`."""
    error = f"{percent(record['error_estimate'])} %"
    # Compliances of older versions were not corrected for discretization.
    return f"within {error}" if record.get("axial_correction") else f"too small by about {error}"


def support_table(record: Record) -> Table:
    """Return the compliances of a throw by support of its end sections."""
    return Table(
        f"Throw by finite elements (e_n {error_words(record)})",
        [
            Column("support", words=True),
            Column("e_n", "1e-9 m/N"),
            Column("torsional", "1e-9 rad/(N m)"),
            Column("c", "1e-9 m/N"),
            Column("P/Z"),
        ],
        [[name, *(answer[key] for key in ANSWERS)] for name, answer in record["supports"].items()],
    )


def section_sentence(record: Record) -> str:
    """State the effect of rigid sections on the axial compliance of a `throw_record`; empty if unknown."""
    shares = [
        f"{percent(held['section_errors']['axial_compliance'] / held['axial_compliance'])} % of e_n {name}"
        for name, held in record["supports"].items()
        if held.get("section_errors")
    ]
    if not shares:
        return ""
    return (
        f"Pinned and guided ends are rigid sections here, which omits {' and '.join(shares)}: the throw is "
        f"softer by this much between equal throws, with sections that bend (degree {record['sections']})."
    )


def loaded_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the compliances of a throw with the axial force P due to the force on its pin."""
    table = support_table(record)
    return replace(
        table,
        columns=[*table.columns, Column("P", "kN")],
        rows=[
            [*row, supported["axial_force"]]
            for row, supported in zip(table.rows, record["supports"].values(), strict=True)
        ],
        note=f"P: axial force at the right end that keeps the length under {pin_force_words(record, units)}.",
    )


def pin_force_words(record: Record, units: OutputUnits = SI) -> str:
    """State which force acts on the pin of a `throw_record`."""
    unit = units.of("kN")
    # Records of older versions know radial forces only.
    x, y, z = record.get("pin_force", (0.0, -record["radial_force"], 0.0))
    dimensions = record.get("dimensions", {})
    several = dimensions.get("further_pins") or len(dimensions.get("pins", ())) > 1
    pin = "the first pin" if several else "the pin"
    if x == z == 0.0 and y <= 0.0:
        return f"a radial force of {unit.with_name(-y)} on {pin}"
    shown = ", ".join(unit.number(value) for value in (x, y, z))
    return f"a force of {shown} {unit.name} (x, y, z) on {pin}"


def reaction_table(record: Record, units: OutputUnits = SI) -> Table:
    """Return the reactions of the ends of a throw to a radial force on its pin."""
    return Table(
        f"Reactions to {pin_force_words(record, units)}, length kept",
        [
            Column("support", words=True),
            Column("end", words=True),
            Column("force x y z", "kN", decimals=3, joint="  "),
            Column("moment x y z", "kN m", decimals=3, joint="  "),
        ],
        [
            [name, side, reaction["force"], reaction["moment"]]
            for name, s in record["supports"].items()
            for side, reaction in s["reactions"].items()
        ],
    )


SUPPORTS: tuple[Support, ...] = ("pinned", "guided")
NOT_CORRECTED = (
    "Not all results are corrected for discretization: on this coarse mesh its error is too large to be "
    "estimated. Give a better accuracy."
)


def throw_record(
    analysis: ThrowAnalysis,
    radial_force: float,
    *,
    pin_force: Sequence[float] | None = None,
    gamma_deg: float | None = None,
    left_gamma_deg: float | None = None,
) -> Record:
    """Compliances, reactions and masses of a throw.

    Parameters
    ----------
    radial_force : float
        Z for the reactions [N].
    pin_force : (3,) sequence of float, optional
        On the first pin, in the throw frame, replaces Z [N].
    gamma_deg : float, optional
        Angle to equal neighbors, for one more support [deg].
    left_gamma_deg : float, optional
        Angle to the left neighbor, if different [deg].
    """
    supports, mesh = {}, analysis.mesh
    named: dict[str, Support] = {str(support): support for support in SUPPORTS}
    if gamma_deg is not None:
        left = gamma_deg if left_gamma_deg is None else left_gamma_deg
        angles = f"{gamma_deg:g}" if left == gamma_deg else f"{left:g} and {gamma_deg:g}"
        named[f"neighbors {angles} deg"] = Neighbors(left, gamma_deg)
    acting = (0.0, -radial_force, 0.0) if pin_force is None else tuple(pin_force)
    for name, support in named.items():
        answer = analysis.supported(support)
        ends, error = analysis.reactions(acting, support), analysis.error_bars(support)
        supports[name] = {
            "axial_compliance": answer.axial,
            "torsional_compliance": answer.torsional,
            "influence_coefficient": answer.influence,
            "errors": {
                "axial_compliance": error.axial,
                "torsional_compliance": error.torsional,
                "influence_coefficient": error.influence,
            },
            "section_errors": _section_errors(analysis, support),
            "axial_force_per_radial": answer.influence / answer.axial,
            "axial_force": float(answer.stretches[0] @ acting) / answer.axial,
            "reactions": {
                side: attributes(getattr(ends, side), "force", "moment")
                for side in ("left", "right")
            },
        }
    return {
        "dimensions": given_dimensions(analysis.throw),
        "material": analysis.material.model_dump(),
        "supports": supports,
        "radial_force": -acting[1],
        "pin_force": list(acting),
        **attributes(analysis, "mass", "center_of_mass", "inertia", "stiffness", "stiffness_error"),
        "stiffness_units": {
            "row": (["N"] * 3 + ["N m"] * 3) * 2,
            "per_column": (["m"] * 3 + ["rad"] * 3) * 2,
        },
        "inertia_about_shaft": analysis.masses.inertia_about_shaft,
        "unbalance": attributes(
            unbalance(analysis.masses, analysis.throw.length / 2.0), "static", "dynamic"
        ),
        **attributes(analysis, "error_estimate", "accuracy", "accuracy_met", "solver", "seconds"),
        "corrected": analysis.corrected,
        "sections": analysis.sections,
        "section_error": None if analysis.sections == "rigid" else analysis.section_error,
        "axial_correction": axial_correction(analysis.superelement, analysis.discrete.superelement),
        "unknowns": mesh.unknowns,
        "model": f"{mesh.part}, second-order tetrahedra, end sections {analysis.end_sections}",
        "remarks": [*analysis.throw.remarks, *([] if analysis.corrected else [NOT_CORRECTED])],
        "meshing_attempts": list(mesh.attempts),
        "mended_elements": mesh.mended_elements,
    }


def _section_errors(analysis: ThrowAnalysis, support: Support) -> Record | None:
    """Effect of rigid sections on compliances; None if sections bend, or were solved as rigid only."""
    if isinstance(support, Neighbors) or analysis.sections == "rigid":
        return None
    errors = analysis.section_errors(support)
    return {
        "axial_compliance": errors.axial,
        "torsional_compliance": errors.torsional,
        "influence_coefficient": errors.influence,
    }


def reciprocity_record(analysis: ThrowAnalysis) -> Record:
    """Errors of reciprocity between separate solutions of a throw, as shares.

    Returns
    -------
    dict
        "asymmetry": largest difference between the stiffness from end forces and its transpose,
        relative to the largest stiffness, with rotations measured as length x angle; "axial_reaction": the
        largest difference, of the supports, between c Z / e_n and the axial reaction by the end forces
        under a radial force Z on the first pin, relative to Z.
    """
    analysis = analysis.discrete
    elements = analysis.superelement
    by_forces = superelement_of_end_forces(analysis.classes, elements.radials)
    radial = elements.radials[0]
    differences = []
    for support in SUPPORTS:
        answer = analysis.supported(support)
        ends = reactions(elements, support, by_forces.end_load(radial))
        differences.append(abs(ends.left.force[2] - answer.influence / answer.axial))
    return {
        "asymmetry": asymmetry(by_forces.stiffness, analysis.mesh.length),
        "axial_reaction": float(max(differences)),
    }


def mode_records(modes: ThrowModes) -> list[Record]:
    """Natural modes of the free throw [Hz], with their motions."""
    return [
        {"frequency": float(frequency), "name": name}
        for frequency, name in zip(modes.frequencies, modes.names, strict=True)
    ]


def given_dimensions(throw: Throw) -> Record:
    """The input: fields in SI units, or the file of a CAD part with its recognized features."""
    if isinstance(throw, CrankThrow):
        return throw.model_dump(mode="json")
    return {
        "file": throw.path,
        "sha256": throw.digest,
        "length": throw.length,
        "pins": [
            {"name": pin.name, "axis": list(pin.axis), "diameter": 2.0 * pin.radius}
            for pin in throw.pins
        ],
        "main_journal_diameters": [2.0 * radius for radius in throw.journal_radii],
        "remarks": list(throw.remarks),
    }


UNITS = {"axial": "m/N", "torsional": "rad/(N m)"}


def compliance_tables(
    throw: Mapping[str, Any],
    formulas: Mapping[str, Any],
    vibration: Mapping[str, Any] | None = None,
) -> Record:
    """Return the content of the tables of compliances.

    Parameters
    ----------
    results : mapping
        Content of results.json.

    Returns
    -------
    dict
        "tables": for each kind its unit and rows: name, value, beside finite elements, mean over the throws
        in the shaft with that source and first natural frequency that follows (both None where the source
        is not used), whether it applies, numbers of its notes; "notes": the
        notes in the order of their numbers, each said once; "range": for each kind the lowest and the
        highest ratio of the formulas that apply, None where fewer than two do.
    """
    numbers: dict[str, int] = {}

    def note(text: str) -> int:
        return numbers.setdefault(text, len(numbers) + 1)

    tables, ranges = {}, {}
    for kind, unit in UNITS.items():
        fe = throw["supports"]["pinned"][f"{kind}_compliance"]
        in_shaft = () if vibration is None else vibration[kind]["sources"]
        sources = {own["source"]: own for own in in_shaft}

        def row(
            name: str,
            value: float,
            source: str,
            remarks: list[str],
            applies: bool = True,
            fe: float = fe,
            sources: Mapping[str, Any] = sources,
        ) -> Record:
            own = sources.get(source)
            return {
                "name": name,
                "value": value,
                "beside": value / fe,
                "in_shaft": None if own is None else own["mean_compliance"],
                "frequency": None
                if own is None
                else own.get("first_frequency", own["first_frequencies"][0]),
                "applies": applies,
                "notes": sorted(note(text) for text in remarks),
            }

        rows = [
            row("finite elements", fe, "fe", []),
            row("finite elements, pinned throughout", fe, "fe pinned", []),
        ]
        regression = formulas.get("regression")
        if regression is not None and regression.get(kind) is not None:
            own = regression[kind]
            rows.append(
                row(
                    f"regression of {own.get('of', 'the study')}",
                    own["value"],
                    "regression",
                    own["remarks"],
                )
            )
        law = (formulas.get("law") or {}).get(f"{kind}_compliance")
        if law is not None:
            width = percent(law["upper"] / law["value"] - 1.0)
            text = f"Fitted to finite elements of thousands of throws; 95 of 100 err by less than {width} %."
            rows.append(row("the law", law["value"], "law", [text]))
        own_rows = [
            row(f["name"], f["value"], f["name"], f["remarks"], f["valid"]) for f in formulas[kind]
        ]
        applying = [own["beside"] for own in own_rows if own["applies"]]
        ranges[kind] = (min(applying), max(applying)) if len(applying) > 1 else None
        tables[kind] = {"unit": unit, "rows": [*rows, *own_rows]}
    return {"tables": tables, "notes": list(numbers), "range": ranges}


def further_compliances(throws: Mapping[str, Any] | None) -> dict[str, Record]:
    """Return the tables of an engine's further throws by name, without frequencies."""
    return {
        name: compliance_tables(parts["throw"], parts["formulas"])
        for name, parts in list((throws or {}).items())[1:]
    }


def regression_record(
    values: Mapping[str, tuple[float, ResponseModel]], source: str = "the study", *remarks: str
) -> Record:
    """Return the results of fitted equations for the throw itself.

    Parameters
    ----------
    values : mapping
        Kind, "axial" or "torsional", to the compliance of the throw [SI] and its equation.
    source : str, optional
        Source of the equations.
    *remarks : str
        Further remarks on them.

    Returns
    -------
    dict
        For each kind "value", "of" (the source), "form", "largest_error_held_out" and "remarks".
    """
    return {
        kind: {
            "value": value,
            "of": source,
            "form": fit.form,
            "largest_error_held_out": fit.largest_heldout_error,
            "remarks": [_fit_remark(fit), *remarks],
        }
        for kind, (value, fit) in values.items()
    }


def _fit_remark(fit: ResponseModel) -> str:
    held = fit.largest_heldout_error
    judged = (
        "none was held out to judge it"
        if held is None
        else f"its largest error at held-out designs is {percent(held)} %"
    )
    return f"{fit.form.capitalize()} equation fitted to {fit.runs} designs; {judged}."
