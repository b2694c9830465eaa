"""All numbers of a run as plain JSON content: what results.json holds."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from crankbase.errors import InputError
from crankbase.quantity import RPM
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.mechanism.mechanism_results import mechanism_results
from crankfem.analyses.mechanism.torque_harmonics import TableHarmonics
from crankfem.analyses.mechanism.two_masses import checked
from crankfem.analyses.provenance import Repetition, provenance
from crankfem.analyses.record import Record, attributes, plain
from crankfem.analyses.run_results import NamedThrow, RunResults, run_checks, throw_checks
from crankfem.analyses.shaft.sources import RESPONSES, throw_lookup
from crankfem.analyses.shaft.whole_records import shaft_balance, throws_in_shaft
from crankfem.analyses.study.fit_records import fitted_study
from crankfem.analyses.throw.formula_records import fe_axial_curve, fe_record, formula_records
from crankfem.analyses.throw.stress import stress_record
from crankfem.analyses.throw.throw_record import reciprocity, regression_record, throw_results
from crankfem.analyses.vibration.records import run_record
from crankfem.files.engine.engine_file import EngineFile
from crankfem.jobs.run_computation import RunComputation, RunInputs
from dynamics.critical import engine_orders, major_orders
from dynamics.gas.pressure import ATMOSPHERE
from fem.analysis import ThrowAnalysis
from fem.symmetry import pin_surfaces
from regression.formulas.axial_formulas import axial_formulas
from regression.models.compliance_model import ComplianceModel

# Without a gas pressure in the engine file, reactions are given for this radial force.
UNIT_RADIAL_FORCE = 1e5
ANGLES_SHOWN_DEG = np.arange(0.0, 181.0, 5.0)


def run_results(computed: RunComputation, repeat: Repetition) -> RunResults:
    """Return the results of a run, without pictures."""
    engine_file, study, mechanism = computed.engine_file, computed.study, computed.mechanism
    throws = _throw_results(computed)
    first = next(iter(throws.values()))
    results = RunResults(
        about=provenance(),
        engine=_engine_record(engine_file),
        inputs=input_values(engine_file),
        input_warnings=tuple(computed.inputs.mechanism.warnings),
        sources=engine_file.sources,
        throw=first.throw,
        formulas=first.formulas,
        fillets=first.fillets,
        fillet_note=first.fillet_note,
        angle_law=_angle_record(engine_file, computed.throw.analysis)
        | {"law": first.formulas["fe"]["angle_law"]},
        balance=shaft_balance(engine_file),
        mechanism=None if mechanism is None else mechanism_results(mechanism),
        study=None if study is None else fitted_study(study.table, study.fits, study.model),
        harmonics=None
        if computed.torque is None or computed.harmonics is None
        else TableHarmonics(computed.harmonics, source=computed.torque.source),
        two_mass=None
        if engine_file.two_mass is None
        else checked(engine_file.two_mass, computed.harmonics),
        shaft=throws_in_shaft(computed.vibration.shaft, computed.crank_analyses),
        vibration=plain(run_record(computed.vibration)),
        strength=computed.strength,
        fatigue=computed.fatigue,
        fatigue_note=computed.fatigue_note,
        throws=throws if engine_file.throws_by_name else None,
        repeat=repeat,
    )
    checks = [*run_checks(results, engine_file.throw.length, _pin_middle(computed.throw.analysis))]
    for name, records in list(throws.items())[1:]:
        checks += [
            replace(check, name=f"{check.name}, throw {name}")
            for check in throw_checks(
                records.throw,
                engine_file.named_throws[name].length,
                _pin_middle(computed.throws[name].analysis),
            )
        ]
    return replace(results, checks=tuple(checks))


def _pin_middle(analysis: ThrowAnalysis) -> list[float]:
    """Where the radial force acts: the middle of the first pin as it is meshed."""
    middle: list[float] = pin_surfaces(analysis.mesh)[0].center.tolist()
    return middle


def _throw_results(computed: RunComputation) -> dict[str, NamedThrow]:
    """Return the results of each distinct throw."""
    engine_file, records = computed.engine_file, {}
    for name, throw in computed.throws.items():
        formulas = formula_records(engine_file.named_throws[name], engine_file.material)
        records[name] = NamedThrow(
            cranks=tuple(
                place
                for place, throw_name in enumerate(engine_file.throw_names, start=1)
                if throw_name == name
            ),
            throw=replace(
                throw_results(throw.analysis, _radial_force(computed.inputs)),
                reciprocity=reciprocity(throw.analysis),
            ),
            formulas=formulas | {"fe": fe_record(throw.analysis, 180.0)},
            fillets=None if throw.stresses is None else stress_record(throw.stresses),
            fillet_note=throw.fillet_note,
        )
    if computed.model is not None:
        _add_regression(records, computed, computed.model)
    return records


def _add_regression(
    records: Mapping[str, NamedThrow], computed: RunComputation, model: ComplianceModel
) -> None:
    """Add the values of the equations for the engine's throws to the formulas, or why there are none."""
    engine_file, path = computed.engine_file, computed.inputs.saved_path
    source = "the study" if path is None else f"the saved model {path.name}"
    instead = computed.study is None and engine_file.study is not None
    remarks = (
        ["The section [study] was not run: the model is used in its place."] if instead else []
    )
    for name, records_of_throw in records.items():
        values, formulas = {}, records_of_throw.formulas
        for kind, response in RESPONSES.items():
            try:
                answer = throw_lookup(
                    model, response, engine_file.named_throws[name], engine_file.material
                )
            except InputError as error:
                reason = f"regression of {source}, {kind}: {str(error).rstrip('.')}"
                formulas["left_out"].append({"name": "regression", "reason": reason})
                continue
            values[kind] = (answer.value, model.responses[response])
        formulas["regression"] = regression_record(values, source, *remarks) if values else None


def _radial_force(inputs: RunInputs) -> float:
    """Radial force at firing top dead center: gas pressure on the piston [N]."""
    if inputs.with_gas is None:
        return UNIT_RADIAL_FORCE
    above = max(pressure.peak_pressure for pressure in inputs.with_gas.pressure) - ATMOSPHERE
    return above * math.pi / 4.0 * inputs.engine_file.engine.bore**2


def _engine_record(engine_file: EngineFile) -> Record:
    engine = engine_file.engine
    return {
        **attributes(engine, "name", "cylinders", "strokes", "bore", "stroke"),
        "file": engine_file.path.name,
        "v_engine": engine.bank_angles is not None,
        "reciprocating": engine_file.vibration.reciprocating,
        "crank_angles": list(engine.crank_angles),
        "firing_order": list(engine.firing_order),
        "firing_intervals_deg": list(engine.firing_intervals_deg),
        "mean_piston_speed": engine.mean_piston_speed(engine.rated_speed),
        "rated_speed_rpm": engine.rated_speed * RPM,
        "lowest_speed_rpm": engine.lowest_speed * RPM,
        "highest_speed_rpm": engine.highest_speed * RPM,
        "major_orders": major_orders(
            engine_orders(engine.strokes, engine_file.vibration.highest_order), engine.firing_angles
        ).tolist(),
        "highest_order": engine_file.vibration.highest_order,
        "radial_force_from_gas": engine_file.gas is not None,
    }


def _angle_record(engine_file: EngineFile, analysis: ThrowAnalysis) -> Record:
    """FE and formulas over the angle between neighboring cranks."""
    tables = [
        axial_formulas(engine_file.throw, float(gamma), material=engine_file.material)
        for gamma in ANGLES_SHOWN_DEG
    ]
    return {
        "gamma_deg": ANGLES_SHOWN_DEG.tolist(),
        "fe": fe_axial_curve(analysis, ANGLES_SHOWN_DEG.tolist()),
        "formulas": {
            name: [table[name].value if table[name].value > 0.0 else None for table in tables]
            for name in tables[0]
        },
    }
