"""Checks, before anything is computed, of all that would be refused at the end of an engine's run."""

from contextlib import nullcontext

from crankfem.analyses.shaft.regression_source import chosen_regressions, refused
from crankfem.analyses.shaft.saved_model import usable_model
from crankfem.analyses.study.nominal_throw import outside_study
from crankfem.analyses.study.response_fits import check_study_can_be_fitted
from crankfem.analyses.vibration.engine_excitation import engine_harmonics, failing_harmonics
from crankfem.analyses.vibration.refusals import refuse_vibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import mechanism_of
from crankfem.files.reading.toml_file import TomlFile
from dynamics.harmonics import read_torque_table


def refuse_what_cannot_run(engine_file: EngineFile, content: TomlFile | None = None) -> None:
    """Refuse limits, chains, pressures, models, studies and tables with which a run would end in an error.

    Parameters
    ----------
    engine_file : EngineFile
    content : TomlFile, optional
        Its sections, for the lines of the file in errors.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    with nullcontext() if content is None else content.with_lines():
        refuse_vibration(engine_file)
        if engine_file.gas is not None or engine_file.gas_map is not None:
            _refuse_pressures(engine_file)
        _refuse_study(engine_file)
        if engine_file.torque_table is not None:
            _ = read_torque_table(engine_file.torque_table, strokes=engine_file.engine.strokes)


def _refuse_study(engine_file: EngineFile) -> None:
    """Refuse a saved model, or a study, that cannot give what is wanted of it."""
    if engine_file.vibration.model is not None:
        usable_model(engine_file, None)
    elif engine_file.study is not None:
        check_study_can_be_fitted(engine_file.study.planned)
        reason = outside_study(engine_file.study)
        for kind in chosen_regressions(engine_file.vibration) if reason else ():
            raise refused(
                engine_file, kind, f"does not apply to the throw that its study varies: {reason}"
            )


def _refuse_pressures(engine_file: EngineFile) -> None:
    """Refuse a pressure that cannot be reached or resolved at a speed for which it is calculated."""
    mechanism = mechanism_of(engine_file)
    harmonics = engine_harmonics(engine_file, mechanism)
    if engine_file.misfire is not None:
        _ = failing_harmonics(engine_file, mechanism, harmonics)
