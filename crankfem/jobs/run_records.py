"""All numbers of a run as plain JSON content: what results.json holds."""

import math
from dataclasses import replace

from crankbase.errors import InputError
from crankbase.results import made_from
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.mechanism.mechanism_results import mechanism_results
from crankfem.analyses.mechanism.torque_harmonics import TableHarmonics
from crankfem.analyses.mechanism.two_masses import checked
from crankfem.analyses.provenance import Repetition, provenance
from crankfem.analyses.run_results import (
    EngineFacts,
    NamedThrow,
    RunResults,
    run_checks,
)
from crankfem.analyses.self_checks import throw_checks
from crankfem.analyses.shaft.sources import RESPONSES, throw_lookup
from crankfem.analyses.shaft.whole_records import shaft_balance, throws_in_shaft
from crankfem.analyses.study.fit_records import fitted_study
from crankfem.analyses.throw.formula_records import (
    Formulas,
    LeftOut,
    Regression,
    by_elements,
    compliances_over_angle,
    formulas_of,
)
from crankfem.analyses.throw.stress import stress_results
from crankfem.analyses.throw.throw_record import UNIT_RADIAL_FORCE, reciprocity, throw_results
from crankfem.files.engine.engine_file import EngineFile
from crankfem.jobs.run_computation import RunComputation
from dynamics.critical import engine_orders, major_orders
from dynamics.gas.pressure import ATMOSPHERE
from fem.analysis import ThrowAnalysis
from fem.symmetry import pin_surfaces
from geometry.any_throw import with_dimensions


def run_results(computed: RunComputation, repeat: Repetition) -> RunResults:
    """Return the results of a run, without pictures."""
    engine_file, study, mechanism = computed.engine_file, computed.study, computed.mechanism
    throws: dict[str, NamedThrow] = {}
    radial_force = UNIT_RADIAL_FORCE
    if engine_file.pressure:  # that of the gas at firing top dead center
        above = max(pressure.peak_pressure for pressure in engine_file.pressure) - ATMOSPHERE
        radial_force = above * math.pi / 4.0 * engine_file.engine.bore**2
    for name, throw in computed.throws.items():
        throws[name] = NamedThrow(
            cranks=tuple(
                place
                for place, throw_name in enumerate(engine_file.throw_names, start=1)
                if throw_name == name
            ),
            throw=replace(
                throw_results(throw.analysis, radial_force, slopes=True),
                reciprocity=reciprocity(throw.analysis),
            ),
            formulas=_formulas(computed, name, throw.analysis),
            fillets=None if throw.stresses is None else stress_results(throw.stresses),
            fillet_note=throw.fillet_note,
        )
    first = next(iter(throws.values()))
    results = RunResults(
        about=provenance(),
        engine=_engine_facts(engine_file),
        inputs=input_values(engine_file),
        input_warnings=tuple(warning.sentence for warning in computed.inputs.warnings),
        warned_fields=tuple(dict.fromkeys(warning.field for warning in computed.inputs.warnings)),
        sources=engine_file.sources,
        throw=first.throw,
        formulas=first.formulas,
        fillets=first.fillets,
        fillet_note=first.fillet_note,
        angle_law=compliances_over_angle(
            engine_file.throw,
            computed.throw.analysis,
            None if first.formulas.fe is None else first.formulas.fe.angle_law,
        ),
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
        vibration=computed.vibration,
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


def _formulas(computed: RunComputation, name: str, analysis: ThrowAnalysis) -> Formulas:
    """Return the formulas for a throw, with the values of the equations, or why they have none."""
    engine_file, model, path = computed.engine_file, computed.model, computed.inputs.saved_path
    throw, material = engine_file.named_throws[name], engine_file.material
    formulas = replace(formulas_of(throw, material), fe=by_elements(analysis))
    if model is None:
        return formulas
    source = "the study" if path is None else f"the saved model {path.name}"
    instead = computed.study is None and engine_file.study is not None
    remarks = (
        ["The section [study] was not run: the model is used in its place."] if instead else []
    )
    values, without = {}, []
    for kind, response in RESPONSES.items():
        try:
            value = throw_lookup(model, response, with_dimensions(throw), material).value
        except InputError as error:
            reason = f"regression of {source}, {kind}: {str(error).rstrip('.')}"
            without.append(LeftOut("regression", reason))
            continue
        values[kind] = Regression.by_equation(value, model.responses[response], source, *remarks)
    return replace(formulas, left_out=(*formulas.left_out, *without), regression=values or None)


def _engine_facts(engine_file: EngineFile) -> EngineFacts:
    engine = engine_file.engine
    orders = engine_orders(engine.strokes, engine_file.vibration.highest_order)
    return made_from(
        engine,
        EngineFacts,
        file=engine_file.path.name,
        v_engine=engine.bank_angles is not None,
        reciprocating=engine_file.vibration.reciprocating,
        crank_angles=tuple(engine.crank_angles),
        firing_order=engine.top_order,
        firing_intervals_deg=tuple(engine.firing_intervals_deg),
        mean_piston_speed=engine.mean_piston_speed(engine.rated_speed),
        major_orders=tuple(major_orders(orders, engine.firing_angles).tolist()),
        highest_order=engine_file.vibration.highest_order,
        radial_force_from_gas=engine_file.gas is not None,
        driven_by=engine.driven_by or None,
    )
