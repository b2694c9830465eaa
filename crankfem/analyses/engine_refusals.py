"""Checks, before anything is computed, of all that would be refused at the end of an engine's run."""

from crankfem.analyses.shaft.law_source import refuse_law
from crankfem.analyses.shaft.regression_source import chosen_regressions, refused
from crankfem.analyses.shaft.saved_model import usable_model
from crankfem.analyses.study.nominal_throw import outside_study
from crankfem.analyses.study.response_fits import check_study_can_be_fitted
from crankfem.analyses.vibration.engine_limits import refuse_limits
from crankfem.files.engine.engine_file import EngineFile
from dynamics.torque_table import read_torque_table


def refuse_what_cannot_run(engine_file: EngineFile) -> None:
    """Refuse limits, chains, models, studies and tables with which a run would end in an error.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    refuse_limits(engine_file)
    refuse_law(engine_file)
    if engine_file.vibration.model is not None:
        usable_model(engine_file, None)
    elif engine_file.study is not None:
        check_study_can_be_fitted(engine_file.study.planned)
        reason = outside_study(engine_file.study)
        for kind in chosen_regressions(engine_file.vibration) if reason else ():
            raise refused(kind, f"does not apply to the throw that its study varies: {reason}")
    if engine_file.torque_table is not None:
        _ = read_torque_table(engine_file.torque_table, strokes=engine_file.engine.strokes)
