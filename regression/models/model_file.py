"""Compliance models as JSON files: written in one step, with a checksum."""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crankbase.errors import InputError
from crankbase.input_file import GivenFile, InputFile
from crankbase.outputs import write_text
from crankbase.text_limits import LARGEST_TABLE_FILE
from crankbase.wrong_files import JSON
from regression.fits.terms import polynomial_terms
from regression.response_kinds import TOO_SMALL

FILE_FORMAT = "crankfem compliance model"
FORMAT_VERSION = 4
# Files of these versions are brought up to date when read.
OLD_VERSIONS = (1, 2, 3)
_MODEL_FILE = "a compliance model file as crankfem saves it"
_WANTED = f"allowed is {_MODEL_FILE}"


def write_model(content: Mapping[str, object], path: str | os.PathLike[str]) -> None:
    """Write a model's content; an existing model is replaced in one step.

    Parameters
    ----------
    content : mapping
        JSON content.
    path : path-like

    Raises
    ------
    InputError
        If the path is that of a folder, or of a file that is not such a model.
    OSError
        If the file cannot be written.
    """
    if Path(path).is_dir():
        raise InputError(
            f"{os.fspath(path)}: given a folder; allowed is a file to write, because a model is one file."
        )
    record = {
        "format": FILE_FORMAT,
        "version": FORMAT_VERSION,
        "checksum": checksum(content),
        **content,
    }
    text = json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_text(Path(path), text, "model", recognized=is_model)


def is_model(path: Path) -> bool:
    """Whether a file is a model that crankfem saved, and unchanged since then."""
    try:
        read_model(path)
    except InputError:
        return False
    return True


def read_model(path: GivenFile) -> dict[str, Any]:
    """Read the content that `write_model` wrote.

    Parameters
    ----------
    path : path-like

    Raises
    ------
    InputError
        If the file cannot be read, is not a compliance model, is of a newer format, or was changed or
        truncated since it was written.
    """
    file = InputFile.of(path)
    shown = file.path
    text = file.text(LARGEST_TABLE_FILE, "a compliance model", _MODEL_FILE, JSON)
    try:
        record = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        toml = shown.suffix.lower() == ".toml"
        fault = "is a TOML file" if toml else f"given a file that is not complete JSON ({error})"
        raise InputError(f"{shown}: {fault}; {_WANTED}.") from None
    except ValueError:  # Python reads no integers of thousands of digits
        raise InputError(f"{shown}: given a number of thousands of digits; {_WANTED}.") from None
    if not isinstance(record, dict) or record.get("format") != FILE_FORMAT:
        raise InputError(f"{shown}: given a file of another kind; {_WANTED}.")
    content = dict(record)
    del content["format"]
    version = content.pop("version", None)
    if version not in (*OLD_VERSIONS, FORMAT_VERSION):
        raise InputError(
            f"{shown}: given format version {version!r}; allowed are 1 to {FORMAT_VERSION}, because this "
            "release of crankfem reads no others."
        )
    if content.pop("checksum", None) != checksum(content):
        raise InputError(
            f"{shown}: given a file whose checksum does not fit its content; it was changed or "
            "damaged after it was written, so its numbers cannot be trusted: fit the model again."
        )
    if version in OLD_VERSIONS[:2]:
        content.setdefault("constraints", None)  # what the file does not tell is not known
    if version in OLD_VERSIONS:
        _mark_uncorrected(content)
    if version == 1:
        try:
            return _upgraded_content(content)
        except (AttributeError, KeyError, TypeError):
            raise InputError(
                f"{shown}: given a damaged compliance model; its content is not that of format 1."
            ) from None
    return content


def checksum(content: Mapping[str, object]) -> str:
    """Return the SHA-256 of the content in a canonical form."""
    spelled = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(spelled.encode()).hexdigest()


def _mark_uncorrected(content: dict[str, Any]) -> None:
    """Mark finite elements of content before version 4 as not corrected for discretization."""
    responses = content.get("responses")
    for name, response in responses.items() if isinstance(responses, dict) else ():
        if isinstance(response, dict):
            response["too_small"] = name.startswith(TOO_SMALL)


def _upgraded_content(content: dict[str, Any]) -> dict[str, Any]:
    """Upgrade content of version 1: add what followed from the form's name."""
    fe_error = content.get("provenance", {}).get("largest_fe_error_estimate")
    responses = {}
    for name, response in content["responses"].items():
        logarithmic = response["form"] == "log-quadratic"
        columns = len(response["factors"])
        degree = 1 if response["form"] == "linear" else 2
        responses[name] = response | {
            "logarithmic": logarithmic,
            "log_factors": [logarithmic] * columns,
            "terms": polynomial_terms(columns, degree),
            # The estimate was that of the axial compliance.
            "largest_fe_error": fe_error if name == "axial_compliance" else None,
        }
    return content | {"responses": responses}
