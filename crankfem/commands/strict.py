"""How --strict ends: by the verdict of the assessment."""

from typing import Any

from crankfem import console
from geometry.errors import InputError

NOT_ACCEPTABLE = "not acceptable"


def end_strictly(vibration: dict[str, Any]) -> None:
    """End with code 4 if the limits are exceeded, after all results have been written and printed.

    Parameters
    ----------
    vibration : dict
        Record of the vibration, `crankfem.vibration.records.run_record`.

    Raises
    ------
    SystemExit
        With code 4 if the verdict is "not acceptable".
    InputError
        If there is no verdict.
    """
    assessment = vibration["assessment"]
    if assessment is None:
        raise InputError(
            "--strict: nothing could be judged, because the engine file gives no gas pressure; allowed is "
            "a file with the section [gas]."
        )
    if assessment["status"] == NOT_ACCEPTABLE:
        console.end_exceeded(f"Limits are exceeded: {assessment['sentence']}")
