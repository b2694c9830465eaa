"""The law as the source of an engine's compliances: values and bands of its throws."""

from typing import NamedTuple

from crankbase.errors import InputError
from crankfem.analyses.throw.law_record import LAW, law_answers
from crankfem.files.engine.engine_file import EngineFile
from geometry.throw import CrankThrow


class LawValue(NamedTuple):
    """A compliance by the law, and the ends of its band."""

    value: float
    lower: float
    upper: float


def law_values(engine_file: EngineFile, quantity: str) -> dict[CrankThrow, LawValue]:
    """Find a compliance, ends pinned, of each distinct throw of an engine by the law.

    Parameters
    ----------
    engine_file : EngineFile
    quantity : {"axial_compliance", "torsional_compliance"}

    Raises
    ------
    InputError
        If the law does not cover one of the throws, with its name.
    """
    found: dict[CrankThrow, LawValue] = {}
    for name, throw in engine_file.named_throws.items():
        try:
            own = law_answers(throw, engine_file.material)[quantity]
        except InputError as error:
            which = f"throw {name}" if engine_file.throws_by_name else "this throw"
            raise InputError(f"does not apply to {which}: {str(error).rstrip('.')}") from None
        found[throw] = LawValue(own["value"], own["lower"], own["upper"])
    return found


def refuse_law(engine_file: EngineFile) -> None:
    """Refuse the law as a source if it does not cover a throw.

    Raises
    ------
    InputError
    """
    vibration = engine_file.vibration
    for kind, own in (("axial", vibration.axial_source), ("torsional", vibration.torsional_source)):
        if own.casefold() != LAW:
            continue
        try:
            law_values(engine_file, f"{kind}_compliance")
        except InputError as error:
            raise InputError(
                f"vibration.{kind}_source: given 'law', which {error}; give another source, such as 'fe'."
            ) from None
