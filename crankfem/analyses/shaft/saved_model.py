"""The saved compliance model of an engine: named in its file, or given by an option."""

from dataclasses import replace
from pathlib import Path

from crankbase.errors import InputError
from crankbase.input_file import GivenFile
from crankfem.analyses.shaft.regression_source import (
    OPTION,
    REGRESSION,
    RESPONSES,
    refuse_regression,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.reading.toml_file import TomlFile
from regression.models.compliance_model import ComplianceModel


def saved_model(engine_file: EngineFile) -> ComplianceModel | None:
    """Read the model that an engine file names; None if it names none.

    Raises
    ------
    InputError
        If the file does not exist, or `ComplianceModel.load` cannot read it.
    """
    file = engine_file.model_file
    return None if file is None else _loaded(file, "vibration.model")


def _loaded(path: GivenFile, field: str) -> ComplianceModel:
    try:
        return ComplianceModel.load(path)
    except InputError as error:
        raise InputError(f"{field}: {error}") from None


def usable_model(engine_file: EngineFile, given: ComplianceModel | None) -> ComplianceModel | None:
    """Return the model given, else the one that the file names; None without either.

    Raises
    ------
    InputError
        If the file's model cannot be read, or a regression is to be the source of compliances and there is
        none, or it does not cover the engine's throws.
    """
    model = saved_model(engine_file) if given is None else given
    refuse_regression(engine_file, model)
    return model


def with_model(content: TomlFile, path: Path) -> TomlFile:
    """Return an engine file's sections with a saved model as the source of all that it contains.

    Parameters
    ----------
    content : TomlFile
    path : Path
        Of the model, as seen from the working directory.

    Raises
    ------
    InputError
        If it is not a model, or contains neither the axial nor the torsional compliance.
    """
    held = _loaded(path, "--model").responses
    chosen = {
        f"{kind}_source": REGRESSION for kind, response in RESPONSES.items() if response in held
    }
    if not chosen:
        raise InputError(
            f"--model: given {path}, a model of {', '.join(held)}; allowed is one of "
            f"{' or '.join(RESPONSES.values())}, because the chains are made of these."
        )
    given = {"model": str(path.absolute()), **chosen}
    vibration = {**content.sections.get("vibration", {}), **given}
    told = {f"vibration.{name}": (OPTION, False) for name in given}
    return replace(
        content,
        sections={**content.sections, "vibration": vibration},
        provenance={**content.provenance, **told},
    )
