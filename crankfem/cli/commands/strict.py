"""The exit codes of --strict, by the verdict of the assessment."""

from typing import TYPE_CHECKING, Any

from crankbase.errors import InputError
from crankfem.cli import console
from crankfem.jobs.exit_codes import EXIT_LIMITS, EXIT_UNDECIDED

if TYPE_CHECKING:
    from crankfem.files.engine.engine_file import EngineFile

NOT_ACCEPTABLE, UNDECIDED = "not acceptable", "undecided"


def check_has_limits(engine: "EngineFile") -> None:
    """Refuse an engine without limits, which --strict cannot judge, before anything is computed for it.

    Raises
    ------
    InputError
        If its file gives no gas pressure: then nothing is forced, nor compared with limits.
    """
    if engine.gas is None and engine.gas_map is None:
        raise InputError(
            "--strict: given for an engine file without gas pressure; allowed is one with a section [gas] "
            "or [gas_map], because nothing can be judged otherwise."
        )


def exit_unless_acceptable(vibration: dict[str, Any]) -> None:
    """Exit with a code of its own unless the verdict is acceptable, after all has been written and printed.

    Parameters
    ----------
    vibration : dict
        Record of the vibration, `crankfem.analyses.vibration.records.run_record`, of an engine that
        `check_has_limits` has let pass.

    Raises
    ------
    SystemExit
        With code 4 if the verdict is "not acceptable" for all assumptions, with 5 if it is undecided.
    """
    from dynamics.assessment.wording import undecided_sentence  # here: numpy takes its time

    assessment = vibration["assessment"]
    decision = assessment["decision"]
    if decision["status"] == UNDECIDED:
        console.exit_by_verdict(undecided_sentence(decision["sentence"]), EXIT_UNDECIDED)
    if decision["status"] == NOT_ACCEPTABLE:
        console.exit_by_verdict(f"Limits are exceeded: {assessment['sentence']}", EXIT_LIMITS)
