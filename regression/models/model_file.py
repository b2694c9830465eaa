"""Compliance models as JSON files: written in one step, with a checksum."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import fields
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import ConfigDict, Field, FiniteFloat, model_validator

from crankbase.choices import did_you_mean
from crankbase.errors import InputError
from crankbase.input_file import JSON, LARGEST_TABLE_FILE, GivenFile, InputFile
from crankbase.model import InputModel
from crankbase.outputs import write_text
from regression.models.extrapolation import StudyConstraint, error_band
from regression.models.family import Family, angle_law_remarks
from regression.models.response_model import IS, ResponseModel
from regression.models.response_query import ResponseQuery, make_response_query
from regression.plans.relations import read_constraint
from regression.response_kinds import ANGLE_LAWS, is_positive_response
from regression.throw_values import check_dimension

FILE_FORMAT = "crankfem compliance model"
FORMAT_VERSION = 4
_MODEL_FILE = "a compliance model file as crankfem saves it"
_WANTED = f"allowed is {_MODEL_FILE}"


def write_model(content: Mapping[str, object], path: str | os.PathLike[str]) -> None:
    """Write a model's content; a model there is replaced in one step. Errors as of `ModelContent.save`."""
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
    """Read the content that `write_model` wrote; errors as of `ModelContent.load`."""
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
    if version != FORMAT_VERSION:
        raise InputError(
            f"{shown}: given format version {version!r}; allowed is {FORMAT_VERSION}, because this release "
            "of crankfem reads no other: fit the model again."
        )
    if content.pop("checksum", None) != checksum(content):
        raise InputError(
            f"{shown}: given a file whose checksum does not fit its content; it was changed or "
            "damaged after it was written, so its numbers cannot be trusted: fit the model again."
        )
    return content


def checksum(content: Mapping[str, object]) -> str:
    """Return the SHA-256 of the content in a canonical form."""
    spelled = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(spelled.encode()).hexdigest()


# Of models that an earlier release read from files of older ones, and wrote again.
UNKNOWN_CONSTRAINTS = (
    "The model's file does not hold the constraints of its study: it is unknown whether the study excluded "
    "such a design."
)
UNCORRECTED = (
    "The model was fitted to finite elements of an older release, not corrected for discretization: its "
    "compliances are too small, by up to the estimated error of these. Run and fit its study again."
)


class ModelContent(InputModel):
    """The fields of a `ComplianceModel`, which describes them."""

    section: ClassVar[str] = "model"
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    responses: dict[str, ResponseModel] = Field(min_length=1)
    fixed: dict[str, FiniteFloat] = Field(default_factory=dict)
    ranges: dict[str, tuple[FiniteFloat, FiniteFloat]] = Field(default_factory=dict)
    categories: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    labels: dict[str, str] = Field(default_factory=dict)
    units: dict[str, str] = Field(default_factory=dict)
    relations: dict[str, str] = Field(default_factory=dict)
    constraints: tuple[str, ...] | None = ()
    constant_groups: dict[str, FiniteFloat] = Field(default_factory=dict)
    throw: dict[str, Any] | None = None
    material: dict[str, str | FiniteFloat] = Field(default_factory=dict)
    provenance: dict[str, str | int | FiniteFloat | None] = Field(default_factory=dict)

    @property
    def uncorrected(self) -> bool:
        """Whether its finite elements were not corrected for discretization, as in older releases."""
        return any(response.too_small for response in self.responses.values())

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        for name, response in self.responses.items():
            both = [factor for factor in response.factors if factor in self.fixed]
            if both:
                raise InputError(
                    f"fixed: given {both[0]}, which is a factor of {name}; a dimension either "
                    "varies or is fixed."
                )
            if is_positive_response(name) and not response.largest_value > 0.0:
                raise InputError(
                    f"coefficients of {name}: given ones whose equation is {response.largest_value:g} "
                    "or less in all of its range; allowed are those of a response above zero, as every "
                    "throw has it."
                )
        for name, value in self.fixed.items():
            check_dimension(f"fixed.{name}", name, value)
        for name, (low, high) in self.ranges.items():
            if not low < high or name in self.fixed:
                raise InputError(
                    f"ranges: given {low:g} to {high:g} for {name}; allowed is a range from lower to "
                    "higher, of what is not fixed."
                )
        _ = self._compiled  # refuses columns that no dimension gives
        return self

    def __repr__(self) -> str:
        """Summarize the responses and the factors with their ranges; all else is in the fields."""
        family = self.family
        factors = [
            f"{name} {family.format_value(name, low)} to {family.format_value(name, high)}"
            for name, (low, high) in family.ranges.items()
        ]
        factors += [f"{name} {' or '.join(of)}" for name, of in family.categories.items()]
        return f"<ComplianceModel of {', '.join(self.responses)}; factors {', '.join(factors)}>"

    __str__ = __repr__

    def angle_law(self, name: str) -> tuple[str, str, str]:
        """Names of the three responses (at 0 deg, at 180 deg, rho) of a response's angle law.

        `InputError` if the response has no such law, or the model lacks one of the three.
        """
        if name not in ANGLE_LAWS:
            raise InputError(
                f"gamma_deg: given for {name}; allowed is an angle for {' and '.join(ANGLE_LAWS)}, "
                "because other responses have no closed angle law."
            )
        needed = ANGLE_LAWS[name]
        missing = [part for part in needed if part not in self.responses]
        if missing:
            raise InputError(
                f"gamma_deg: given, but the model has no {', no '.join(missing)}; allowed is an angle "
                f"only with {', '.join(needed)}, because the angle law is made of these."
            )
        return needed

    @property
    def family(self) -> Family:
        """The varying and fixed dimensions of the model's throws."""
        return self._compiled.family

    @cached_property
    def _compiled(self) -> "CompiledModel":
        return CompiledModel(self)

    # ----------------------------------------------------------------------------------- file

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as a JSON file; an existing model is replaced in one step.

        Parameters
        ----------
        path : path-like
            Where to write.

        Raises
        ------
        InputError
            If the path is that of a folder, or of a file that is not such a model; see `replacing_files`.
        OSError
            If the file cannot be written.
        """
        write_model(self.model_dump(mode="json"), path)

    @classmethod
    def load(cls, path: GivenFile) -> Self:
        """Read a model written by `save`; it gives the same numbers to the last digit.

        Parameters
        ----------
        path : path-like
            The JSON file.

        Raises
        ------
        InputError
            If the file cannot be read, is not a compliance model, is of another format, or was
            changed or truncated since it was written.
        """
        content = read_model(path)
        try:
            return cls(**content)
        except (InputError, TypeError) as error:
            shown = InputFile.of(path).path
            raise InputError(f"{shown}: given a damaged compliance model; {error}") from None

    def __getstate__(self) -> dict[Any, Any]:
        """Leave the compiled equations out of what goes to other processes."""
        state = super().__getstate__()
        kept = {name: value for name, value in state["__dict__"].items() if name != "_compiled"}
        return state | {"__dict__": kept}


class CompiledModel:
    """Data that a model computes once for all its queries: family, error bands, constraints and queries."""

    def __init__(self, model: ModelContent) -> None:
        responses = model.responses
        self.family = Family(
            **{part.name: getattr(model, part.name) for part in fields(Family)}
            | {"ranges": model.ranges or _column_ranges(responses)}
        )
        self.bands = {name: error_band(response) for name, response in responses.items()}
        self._throw = model.throw
        self._remarks = (
            *((UNKNOWN_CONSTRAINTS,) if model.constraints is None else ()),
            *((UNCORRECTED,) if model.uncorrected else ()),
        )
        units = self.family.all_units
        self.constraints = tuple(
            StudyConstraint(read_constraint(text, f"constraints[{place}]", units), units)
            for place, text in enumerate(model.constraints or ())
        )
        self._queries = {
            name: make_response_query(
                name, response, self.family, model.material, model.constant_groups, self.constraints
            )
            for name, response in responses.items()
        }

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on every lookup."""
        return self._remarks

    @cached_property
    def angle_law_remarks(self) -> tuple[str, ...]:
        """Remarks on the angle law of the model's throws."""
        return angle_law_remarks(self.family, self._throw)

    def query(self, name: str) -> ResponseQuery:
        """Return the query for a response, or name those available."""
        if name not in self._queries:
            raise InputError(
                f"response: given {name!r}; {did_you_mean(name, self._queries, cutoff=0.8)}allowed are "
                f"{', '.join(self._queries)}, which this model holds."
            )
        return self._queries[name]


def _column_ranges(responses: Mapping[str, ResponseModel]) -> dict[str, tuple[float, float]]:
    """Ranges of a model's numbers as the equations' columns have them."""
    ranges: dict[str, tuple[float, float]] = {}
    for response in responses.values():
        columns = zip(response.factors, response.lowest, response.highest, strict=True)
        for name, low, high in columns:
            if response.basis == "factors" and IS not in name:
                ranges.setdefault(name, (low, high))
    return ranges
