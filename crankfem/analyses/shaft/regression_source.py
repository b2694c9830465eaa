"""A fitted compliance model as the source of an engine's compliances, and its limits."""

from pathlib import Path

from crankbase.errors import InputError
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.engine_sections import VibrationSettings
from fem.material import Material
from geometry.throw import CrankThrow
from regression.models.compliance_model import ComplianceModel
from regression.models.lookup import Lookup
from regression.response_kinds import AXIAL, TORSIONAL
from regression.throw_values import same_dimension

REGRESSION = "regression"
# Source of the values that the option --model gives in place of a file's.
OPTION = "option --model"
RESPONSES = {"axial": AXIAL, "torsional": TORSIONAL}
# What compliances depend on.
ELASTIC = {"youngs_modulus": "Pa", "poisson_ratio": ""}


def throw_lookup(
    model: ComplianceModel, response: str, throw: CrankThrow, material: Material
) -> Lookup:
    """Look a compliance up for a throw of an engine, only where the model knows its error.

    Parameters
    ----------
    model : ComplianceModel
    response : {"axial_compliance", "torsional_compliance"}
    throw : CrankThrow
    material : Material

    Raises
    ------
    InputError
        If the model lacks the response, the throw is not of its family or is outside the range of the fit,
        the material is another one, or the band is unbounded.
    """
    if response not in model.responses:
        raise InputError(f"the model has {', '.join(model.responses)} and no {response}")
    for name, unit in ELASTIC.items():
        fitted, own = model.material.get(name), getattr(material, name)
        if isinstance(fitted, float) and not same_dimension(own, fitted):
            raise InputError(
                f"material.{name}: given {own:g} {unit}".rstrip()
                + f"; the model was fitted with {fitted:g} {unit}".rstrip()
            )
    found = model.lookup(response, **model.dimensions_of(throw))
    if not found.inside:
        raise InputError(" ".join(found.remarks))
    if found.lower is None or found.upper is None or not found.lower > 0.0:
        raise InputError(f"the band of {response} has no end ({found.band})")
    return found


def throw_lookups(
    engine_file: EngineFile, model: ComplianceModel, response: str
) -> dict[CrankThrow, Lookup]:
    """Look a compliance up for each distinct throw of an engine.

    Raises
    ------
    InputError
        As `throw_lookup`, with the name of the throw.
    """
    found: dict[CrankThrow, Lookup] = {}
    for name, throw in engine_file.named_throws.items():
        try:
            found[throw] = throw_lookup(model, response, throw, engine_file.material)
        except InputError as error:
            own = f"throw {name}" if engine_file.throws_by_name else "this throw"
            raise InputError(f"does not apply to {own}: {str(error).rstrip('.')}") from None
    return found


def chosen_regressions(vibration: VibrationSettings) -> dict[str, str]:
    """Return the kinds of vibration whose source is a regression, with the response that they need."""
    given = {"axial": vibration.axial_source, "torsional": vibration.torsional_source}
    return {kind: RESPONSES[kind] for kind, own in given.items() if own.casefold() == REGRESSION}


def refuse_regression(engine_file: EngineFile, model: ComplianceModel | None) -> None:
    """Refuse a regression as a source if there is none, or if it does not cover the throws.

    Raises
    ------
    InputError
    """
    for kind, response in chosen_regressions(engine_file.vibration).items():
        if model is None:
            raise InputError(
                f"vibration.{kind}_source: given 'regression' without a fitted model; allowed is it with a "
                "saved one (vibration.model, or --model MODEL.json), or in crankfem run, which fits the "
                "section [study]."
            )
        try:
            throw_lookups(engine_file, model, response)
        except InputError as error:
            raise refused(engine_file, kind, str(error)) from None


def refused(engine_file: EngineFile, kind: str, reason: str) -> InputError:
    """Return the error of a regression that cannot be the source of a kind of vibration."""
    field = f"vibration.{kind}_source"
    chosen = f"{field}: given 'regression', which"
    if engine_file.provenance.get(field, ("", False))[0] == OPTION:
        chosen = f"--model: given {Path(engine_file.vibration.model or '').name}, which"
    return InputError(
        f"{chosen} {reason.rstrip('.')}; give a model whose range "
        "contains the throw, because its error is known nowhere else, or another source, such as 'fe'."
    )
