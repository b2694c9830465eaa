"""A fitted compliance model in a file: dimensions in, compliance out, with its known errors.

A model is valid for one family of throws: some dimensions are its factors, the others are fixed; in
dimensionless groups it is valid for throws of the family at any size. It needs neither mesh nor solver
and is written as readable JSON.
"""

import hashlib
import json
import os
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ConfigDict, Field, FiniteFloat, model_validator

from crankbase.array_checks import Array
from crankbase.choices import check_not_given, did_you_mean, whole_number
from crankbase.errors import InputError
from crankbase.frames import Axes, grid, table
from crankbase.input_file import JSON, LARGEST_TABLE_FILE, GivenFile, InputFile
from crankbase.model import InputModel
from crankbase.outputs import write_text
from crankbase.sentences import finished
from fem.end_reactions import Reactions
from fem.material import Material
from geometry.throw import CrankThrow
from regression.models.angle import SEVERAL_PINS, between_values, fold_angle, opposite_share
from regression.models.family import Family, angle_law_remarks, query_for_throw
from regression.models.lookup import (
    Lookup,
    Lookups,
    ReactionLookup,
    Slope,
    both_ends,
    checked_force,
    checked_support,
    look_up,
    look_up_between_neighbors,
    support_words,
    throw_lengths,
)
from regression.models.response_model import IS, ResponseModel
from regression.models.response_query import (
    OutsideRangeWarning,
    ResponseQuery,
    ResponseValues,
    StudyConstraint,
    error_band,
    make_response_query,
    study_material,
)
from regression.plans.factors import rounded
from regression.plans.relations import read_constraint
from regression.response_kinds import (
    ANGLE_LAWS,
    AXIAL,
    INFLUENCE,
    NEEDED,
    RIGHT_MOMENTS,
    TORSIONAL,
    end_reactions,
    is_positive_response,
    material_ratio,
)
from regression.throw_values import check_dimension, same_dimension

if TYPE_CHECKING:
    from fem.supports import Support
    from regression.formulas.case import OfThrow


FILE_FORMAT = "crankfem compliance model"
# Later releases read files of version 4, as docs/lookup.md promises: a change of content keeps them readable.
FORMAT_VERSION = 4
_MODEL_FILE = "a compliance model file as crankfem saves it"
_WANTED = f"allowed is {_MODEL_FILE}"


def write_model(content: Mapping[str, object], path: str | os.PathLike[str]) -> None:
    """Write a model's content; a model there is replaced in one step. Errors as of `ComplianceModel.save`."""
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
    """Read the content that `write_model` wrote; errors as of `ComplianceModel.load`."""
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


class CompiledModel:
    """Data that a model computes once for all its queries: family, error bands, constraints and queries."""

    def __init__(self, model: "ComplianceModel") -> None:
        responses = model.responses
        ranges = dict(model.ranges)
        if not ranges:
            # Those of the equations' columns.
            for response in responses.values():
                columns = zip(response.factors, response.lowest, response.highest, strict=True)
                for name, low, high in columns:
                    if response.basis == "factors" and IS not in name:
                        ranges.setdefault(name, (low, high))
        self.family = Family(
            **{part.name: getattr(model, part.name) for part in fields(Family)} | {"ranges": ranges}
        )
        self.bands = {name: error_band(response) for name, response in responses.items()}
        self._throw = model.throw
        units = self.family.all_units
        self.constraints = tuple(
            StudyConstraint(read_constraint(text, f"constraints[{place}]", units), units)
            for place, text in enumerate(model.constraints)
        )
        self._queries = {
            name: make_response_query(
                name, response, self.family, model.material, model.constant_groups, self.constraints
            )
            for name, response in responses.items()
        }

    @cached_property
    def angle_law_remarks(self) -> tuple[str, ...]:
        """Remarks on the angle law of the model's throws."""
        return angle_law_remarks(self.family, self._throw)

    @cached_property
    def several_pins(self) -> bool:
        """Whether the model's throws have more than one pin."""
        pins = () if self._throw is None else CrankThrow(**self._throw).further_pins
        return bool(pins) or any(name.startswith(_FURTHER_PINS) for name in _names(self.family))

    def query(self, name: str) -> ResponseQuery:
        """Return the query for a response, or name those available."""
        if name not in self._queries:
            raise InputError(
                f"response: given {name!r}; {did_you_mean(name, self._queries, cutoff=0.8)}allowed are "
                f"{', '.join(self._queries)}, which this model holds."
            )
        return self._queries[name]


Value = float | Array


def _warn_outside(answers: Iterable[ResponseValues], frames: int) -> None:
    """Warn of each dimension outside its range, once, in the code so many frames up."""
    for finding in {part.name: part for answer in answers for part in answer.outside}.values():
        warnings.warn(finding.remark, OutsideRangeWarning, stacklevel=frames)


# Beginnings of names of what a throw has that its first pin's reactions do not tell of.
_FURTHER_PINS = "further_pins."
_OTHER_PARTS = (_FURTHER_PINS, "oil_holes.")
ANGLE = "gamma_deg"
MOST_POINTS = 1_000_000
# What a table says of each response.
WORDS = ("symbol", "unit", "support", "form")
ERRORS = ("largest_error", "largest_heldout_error", "largest_fe_error")


def _names(family: Family) -> list[str]:
    """Return the names of all that varies or is fixed."""
    return [*family.factors, *family.relations, *family.fixed, *family.labels]


def _middle(family: Family) -> dict[str, float | str]:
    """Return the middle of each factor's range, and the first label of each choice."""
    numbers = {name: 0.5 * (low + high) for name, (low, high) in family.ranges.items()}
    return numbers | {name: labels[0] for name, labels in family.categories.items()}


class ComplianceModel(InputModel):
    """Regression equations for the compliances of a family of crank throws.

    Parameters
    ----------
    responses : dict of str to ResponseModel
        By name: "axial_compliance", "torsional_compliance", "influence_coefficient", or others for
        `value` and `lookup`.
    fixed : dict of str to float
        The throw's dimensions that did not vary, by field of `CrankThrow` [SI]; of a part as
        "counterweight.thickness".
    ranges : dict of str to (float, float), optional
        Range of each numeric factor of the study [SI]; by default the ranges of the equations'
        columns.
    categories : dict of str to tuple of str
        Labels of each factor that is a choice, such as web_outline.
    labels : dict of str to str
        Choices that did not vary.
    units : dict of str to str
        SI units of factors that are not fields of a throw.
    relations : dict of str to str
        Dimensions that followed from others in the study, with their expressions.
    constraints : tuple of str
        Constraints of the study: a throw that violates one counts as outside the range of the fit.
    constant_groups : dict of str to float
        Dimensionless groups that did not vary although their dimensions did.
    throw : dict, optional
        The throw that the study varied, as a record.
    material : dict
        Constants used in the runs, such as youngs_modulus [Pa] and poisson_ratio.
    provenance : dict
        Origin of the model: key of the study, versions, date.

    Raises
    ------
    InputError
        If a field is missing or unknown, a dimension is both fixed and a factor, or one that no throw
        has, a column is not one of the model's factors, or a value is impossible for
        the response.

    Examples
    --------
    ``model = ComplianceModel.load("model.json")`` and then
    ``model.axial_compliance(web_width=0.300, web_thickness=0.068, pin_length=0.139)``.
    """

    section: ClassVar[str] = "model"
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    responses: dict[str, ResponseModel] = Field(min_length=1)
    fixed: dict[str, FiniteFloat] = Field(default_factory=dict)
    ranges: dict[str, tuple[FiniteFloat, FiniteFloat]] = Field(default_factory=dict)
    categories: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    labels: dict[str, str] = Field(default_factory=dict)
    units: dict[str, str] = Field(default_factory=dict)
    relations: dict[str, str] = Field(default_factory=dict)
    constraints: tuple[str, ...] = ()
    constant_groups: dict[str, FiniteFloat] = Field(default_factory=dict)
    throw: dict[str, Any] | None = None
    material: dict[str, str | FiniteFloat] = Field(default_factory=dict)
    provenance: dict[str, str | int | FiniteFloat | None] = Field(default_factory=dict)

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
        return finished(
            f"<ComplianceModel of {', '.join(self.responses)}; factors {', '.join(factors)}>"
        )

    __str__ = __repr__

    def angle_law(self, name: str) -> tuple[str, str, str]:
        """Names of the three responses (at 0 deg, at 180 deg, rho) of a response's angle law.

        `InputError` if the response or the model's throws have no such law, or the model lacks one of the
        three.
        """
        if name not in ANGLE_LAWS:
            raise InputError(
                f"gamma_deg: given for {name}; allowed is an angle for {' and '.join(ANGLE_LAWS)}, "
                "because other responses have no closed angle law."
            )
        if self._compiled.several_pins:
            raise InputError(SEVERAL_PINS)
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
        content = self.model_dump(mode="json")
        for response in content["responses"].values():
            if response["process"] is None:  # as other forms were written before there was any
                del response["process"]
        write_model(content, path)

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

    def axial_compliance(
        self,
        *,
        gamma_deg: ArrayLike | None = None,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> Value:
        """Axial compliance e_n [m/N].

        Parameters
        ----------
        gamma_deg : float or array_like, optional
            Angle to the neighboring cranks [deg], folded to 0 ... 180; the throw is then between
            identical neighbors instead of supported as in `lookup`. Needs e_0, e_180 and rho in the
            model.
        strict : bool
            Refuse values outside the range of the fit.
        **dimensions : float, str or array_like
            The factors by name [SI], choices as labels; arrays are broadcast together. A fixed
            dimension may be given with the model's value. An equation in dimensionless groups
            accepts any size: values not given are those of the study, and ratios that did not vary must
            agree with it.

        Returns
        -------
        float or ndarray
            A float if all dimensions are plain numbers.

        Raises
        ------
        InputError
            If a factor is missing, a dimension is unknown, not positive or not finite, a fixed one or
            a fixed ratio has another value, or, if `strict`, something is outside the range; with an
            angle, if the equation of rho does not give a positive number.

        Warns
        -----
        OutsideRangeWarning
            For each dimension or ratio outside the range of the fit; the value is not clipped.
        """
        return self._value(AXIAL, gamma_deg, strict, dimensions)

    def torsional_compliance(self, *, strict: bool = False, **dimensions: ArrayLike | str) -> Value:
        """Torsional compliance [rad/(N m)]; otherwise as `axial_compliance`."""
        return self._value(TORSIONAL, None, strict, dimensions)

    def influence_coefficient(
        self,
        *,
        gamma_deg: ArrayLike | None = None,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> Value:
        """Lengthening per unit radial force on the pin, c [m/N]; otherwise as `axial_compliance`."""
        return self._value(INFLUENCE, gamma_deg, strict, dimensions)

    def value(
        self,
        response: str,
        /,
        *,
        gamma_deg: ArrayLike | None = None,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> Value:
        """Value of any response of the model by its name [SI]; otherwise as `axial_compliance`."""
        return self._value(response, gamma_deg, strict, dimensions)

    def _value(
        self, name: str, gamma_deg: ArrayLike | None, strict: bool, dimensions: Mapping[str, Any]
    ) -> Value:
        """Evaluate, with warnings for the caller of the public method, two frames up."""
        answers = [answer for _, answer in self._answers(name, gamma_deg, strict, dimensions)]
        _warn_outside(answers, 4)
        value: Value = answers[0].values
        if gamma_deg is not None:
            value = between_values(fold_angle(gamma_deg), [answer.values for answer in answers])
        return value

    def _answers(
        self, name: str, gamma_deg: ArrayLike | None, strict: bool, dimensions: Mapping[str, Any]
    ) -> list[tuple[str, ResponseValues]]:
        """Evaluate a response, or those of its angle law."""
        answers = []
        for part in (name,) if gamma_deg is None else self.angle_law(name):
            answer = self.answer(part, dimensions)
            if strict and answer.outside:
                raise InputError(answer.outside[0].error_sentence)
            answers.append((part, answer))
        return answers

    def slopes(
        self,
        response: str,
        /,
        *,
        gamma_deg: ArrayLike | None = None,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> dict[str, Slope]:
        """Derivatives of a response by its factors, from the equation itself, without differences.

        Parameters
        ----------
        response, gamma_deg, strict, **dimensions
            As in `axial_compliance` and `lookup`; the angle and the throw's size relative to the study
            are held.

        Returns
        -------
        dict of str to Slope
            By each numeric factor given; dimensions that follow from it by relations move with it.
            Choices and fixed dimensions have no slope.

        Raises
        ------
        InputError
            As in `axial_compliance`; if the model lacks the response, or dimensions are given in place
            of the factors that they follow from.

        Warns
        -----
        OutsideRangeWarning
            As in `axial_compliance`.
        """
        answers = self._answers(response, gamma_deg, strict, dimensions)
        _warn_outside([answer for _, answer in answers], 3)
        family = self.family
        rows = [self._compiled.query(name).slopes(dimensions) for name, _ in answers]
        values: dict[str, Any] = rows[0]
        if gamma_deg is not None:
            in_line, opposite, ratio = (answer.values for _, answer in answers)
            between_values(gamma_deg, (in_line, opposite, ratio))  # refuses impossible values
            share = opposite_share(gamma_deg, ratio)
            by_ratio = (in_line - opposite) * share * (1.0 - share) / ratio
            values = {
                name: rows[0][name] * (1.0 - share)
                + rows[1][name] * share
                + rows[2][name] * by_ratio
                for name in values
            }
        unit = self.responses[answers[0][0]].unit or "1"
        return {
            name: Slope(value, f"{unit} per {family.unit(name) or '1'}")
            for name, value in values.items()
        }

    def answer(self, response: str, dimensions: Mapping[str, ArrayLike | str]) -> ResponseValues:
        """Values of a response with those outside its range, without warnings."""
        return self._compiled.query(response).evaluate(dimensions)

    def lookup(
        self,
        response: str,
        /,
        *,
        gamma_deg: float | None = None,
        strict: bool = False,
        **dimensions: float | str,
    ) -> Lookup:
        """One value of a response with its unit, error band and equation.

        Parameters
        ----------
        response : str
            Name of the response, such as "axial_compliance".
        gamma_deg, strict, **dimensions
            As in `axial_compliance`, plain numbers only.

        Returns
        -------
        Lookup
            Remarks report dimensions outside their range, and with an angle that the law is
            only an interpolation for throws with unequal webs; no warnings are issued.

        Raises
        ------
        InputError
            As in `axial_compliance`; if the model lacks the response; for an array.
        """
        asked: dict[str, Any] = {**dimensions, "gamma_deg": gamma_deg}
        for name, number in asked.items():
            if not (number is None or isinstance(number, float | str)) and np.ndim(number):
                raise InputError(
                    f"{name}: given an array of shape {np.shape(number)}; allowed is one number, "
                    "because `lookup` is for one throw: `lookups` takes arrays."
                )
        return Lookup.of(*self._looked_up(response, gamma_deg, strict, dimensions, single=True))

    def lookups(
        self,
        response: str,
        /,
        *,
        gamma_deg: ArrayLike | None = None,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> Lookups:
        """Values of a response for many throws at once, with their error bands.

        Parameters
        ----------
        response, gamma_deg, strict, **dimensions
            As in `axial_compliance` and `lookup`; arrays are broadcast together.

        Returns
        -------
        Lookups
            With arrays of the values, their bands and whether each is inside; no warnings are issued.

        Raises
        ------
        InputError
            As in `axial_compliance`; if the model lacks the response.
        """
        looked_up, _ = self._looked_up(response, gamma_deg, strict, dimensions)
        arrays = {n: np.asarray(looked_up[n]) for n in ("value", "lower", "upper", "inside")}
        return Lookups(**looked_up | arrays)

    def _looked_up(
        self,
        response: str,
        gamma_deg: ArrayLike | None,
        strict: bool,
        dimensions: Mapping[str, Any],
        *,
        single: bool = False,
    ) -> tuple[dict[str, Any], list[ResponseModel]]:
        """Return the fields of `Lookups`, floats or arrays, and the responses used."""
        compiled = self._compiled
        answers = self._answers(response, gamma_deg, strict, dimensions)
        used = [self.responses[name] for name, _ in answers]
        parts = [
            look_up(self.responses[name], compiled.bands[name], answer) for name, answer in answers
        ]
        if gamma_deg is None:
            return parts[0], used
        angle = fold_angle(gamma_deg)
        symbol = self.responses.get(response, used[0]).symbol
        shown = f"{angle:g} deg" if single else ""
        law = compiled.angle_law_remarks
        return look_up_between_neighbors(angle, parts, symbol, shown, law), used

    def reactions(
        self,
        pin_force: ArrayLike,
        support: "Support" = "pinned",
        *,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> ReactionLookup:
        """Reactions of the supports on the throw under a force on its pin, axial motion blocked.

        Parameters
        ----------
        pin_force : (3,) or (..., 3) array_like
            Across the shaft, in the throw frame [N]; the radial force Z is ``(0, -Z, 0)``. Rows are
            broadcast with the dimensions.
        support : "pinned", "guided" or Neighbors
            The left end takes the torque. `Neighbors` with equal angles, for symmetric throws.
        strict, **dimensions
            As in `axial_compliance`.

        Returns
        -------
        ReactionLookup
            ``.left`` and ``.right``, each with ``.force`` [N] and ``.moment`` [N m], in equilibrium
            with the force; no warnings are issued.

        Raises
        ------
        InputError
            As in `axial_compliance`; if the model lacks an equation that reactions need, as those of
            older releases do, the force has a part along the shaft, or the angles differ.
        """
        force = checked_force(pin_force)
        kind, gamma = checked_support(support)
        self._check_throws(kind)
        missing = [name for name in NEEDED[kind] if name not in self.responses]
        if missing:
            raise InputError(
                f"support: given {support_words(kind, gamma)}, but the model has no {missing[0]}; reactions "
                f"there need {', '.join(NEEDED[kind])}: run and fit its study again, because this release "
                "has studies keep them."
            )
        looked_up = {name: self.lookups(name, strict=strict, **dimensions) for name in NEEDED[kind]}
        inside = np.logical_and.reduce([answer.inside for answer in looked_up.values()])
        try:
            np.broadcast_shapes(force.shape[:-1], inside.shape)
        except ValueError:
            raise InputError(
                f"pin_force: given an array of shape {force.shape} for dimensions of shape {inside.shape}; "
                "allowed are three numbers, or rows of them that can be broadcast with the dimensions."
            ) from None
        lengths = throw_lengths(self.family, dimensions)
        values: dict[str, Any] = {name: answer.value for name, answer in looked_up.items()}

        # One number for both ends, if they are alike.
        twins = {} if angle_law_remarks(self.family, self.throw) else RIGHT_MOMENTS
        values |= {right: values[left] for left, right in twins.items() if left in values}

        def loads(name: str = "", ends: Any = None) -> Array:
            changed = {} if not name else {name: ends, twins.get(name, name): ends}
            return end_reactions(values | changed, lengths, force, gamma)

        middle = loads()
        band = np.zeros_like(middle)
        for name, answer in looked_up.items():
            if name in twins.values():
                continue
            open_ended = ~(np.isfinite(answer.lower) & np.isfinite(answer.upper))
            ends = (np.where(open_ended, answer.value, end) for end in (answer.lower, answer.upper))
            band += np.maximum(*(np.abs(loads(name, end) - middle) for end in ends))
            band[np.broadcast_to(open_ended, band.shape[:-1])] = np.inf
        return ReactionLookup(
            *both_ends(middle),
            band=Reactions(*both_ends(band)),
            support=support_words(kind, gamma),
            inside=np.broadcast_to(inside, middle.shape[:-1]),
            remarks=tuple(
                dict.fromkeys(remark for answer in looked_up.values() for remark in answer.remarks)
            ),
        )

    def _check_throws(self, kind: str) -> None:
        """Refuse throws whose reactions do not follow from the model's numbers."""
        family, throw = self.family, self.throw
        part = next((name for name in _names(family) if name.startswith(_OTHER_PARTS)), None)
        if part is not None or (throw is not None and CrankThrow(**throw).symmetry == "full"):
            raise InputError(
                f"reactions: given a model of throws with {part or 'parts beside the crank plane'}; allowed "
                "are throws of one pin that are symmetric about the crank plane, because for others a force "
                "in that plane does not leave the ends in it: use analyze_throw."
            )
        if kind == "neighbors" and angle_law_remarks(family, throw):
            raise InputError(
                "support: given Neighbors to a model of throws that are not alike from both ends; allowed "
                'are "pinned" and "guided", because only equal webs have reactions in closed form between '
                "neighbors: use analyze_throw."
            )

    def of_material(self, material: Material) -> "ComplianceModel":
        """Return the model for throws of another material with the same Poisson's ratio.

        Nothing is approximated: compliances are inverse to Young's modulus, masses go with the density.

        Parameters
        ----------
        material : Material

        Returns
        -------
        ComplianceModel
            The same one, if the material is that of its runs.

        Raises
        ------
        InputError
            If Poisson's ratio is another one, the model does not state its material, or a response is of
            a unit that does not tell how it depends on the material.
        """
        fitted = study_material(self.material)
        if not same_dimension(material.poisson_ratio, fitted.poisson_ratio):
            raise InputError(
                f"material.poisson_ratio: given {material.poisson_ratio:g}; allowed is "
                f"{fitted.poisson_ratio:g}, which the model was fitted with, because compliances are not in "
                "proportion to it."
            )
        if material == fitted:
            return self
        responses = {}
        for name, response in self.responses.items():
            factor = material_ratio(response.unit, material, fitted)
            responses[name] = (
                response if response.basis == "groups" else response.scaled(factor)
            )  # those in groups follow the model's material
        return self.changed(responses=responses, material=material.model_dump())

    def dimensions_of(self, throw: CrankThrow) -> dict[str, Any]:
        """Return the dimensions and labels of a throw for queries to the model.

        Raises
        ------
        InputError
            If the throw has a feature that the throws of the model lack, or lacks one.
        """
        return dict(query_for_throw(throw, self._compiled.family, self.throw))

    def of_throw(
        self,
        throw: "CrankThrow | OfThrow",
        *,
        material: Material | None = None,
        gamma_deg: float | None = None,
        strict: bool = False,
    ) -> dict[str, Lookup]:
        """Look all responses up for a throw.

        Parameters
        ----------
        throw : CrankThrow, or an analysis or engine with a throw and its material
        material : Material, optional
            Of the throw, as `of_material` takes it; that of the model's runs by default.
        gamma_deg, strict
            As in `axial_compliance`; the angle is for the responses that depend on it.

        Returns
        -------
        dict of str to Lookup
            Response name to its value. If the throw is of another size than the study's, this holds
            the dimensionless equations.

        Raises
        ------
        InputError
            If the throw is not of the model's family, or no response can be evaluated.

        Warns
        -----
        UserWarning
            For each response that cannot be evaluated while others can.
        """
        from regression.formulas.case import OfThrow, throw_and_material

        if material is not None or isinstance(throw, OfThrow):
            throw, material = throw_and_material(throw, material)
            return self.of_material(material).of_throw(throw, gamma_deg=gamma_deg, strict=strict)
        lookups, refused = self.look_all_up(
            gamma_deg=gamma_deg, strict=strict, **self.dimensions_of(throw)
        )
        for name, reason in refused.items():
            warnings.warn(f"{name} is left out: {reason}", stacklevel=2)
        return lookups

    def look_all_up(
        self,
        names: Iterable[str] | None = None,
        *,
        many: bool = False,
        gamma_deg: float | None = None,
        strict: bool = False,
        **dimensions: Any,
    ) -> tuple[dict[str, Any], dict[str, InputError]]:
        """Look several responses up, as far as they have values.

        Parameters
        ----------
        names : iterable of str, optional
            All by default.
        many : bool
            Whether for many throws, as `lookups`.
        gamma_deg, strict, **dimensions
            As in `lookup`; the angle is for the responses that depend on it.

        Returns
        -------
        lookups : dict of str to Lookup or Lookups
        refused : dict of str to InputError

        Raises
        ------
        InputError
            The first, if no response has a value.
        """
        look = self.lookups if many else self.lookup
        looked_up: dict[str, Any] = {}
        refused: dict[str, InputError] = {}
        for name in self.responses if names is None else names:
            angle = gamma_deg if name in ANGLE_LAWS else None
            try:
                looked_up[name] = look(name, gamma_deg=angle, strict=strict, **dimensions)
            except InputError as error:
                refused[name] = error
        if refused and not looked_up:
            raise next(iter(refused.values()))
        return looked_up, refused

    def plot(
        self,
        axes: Axes | None = None,
        *,
        response: str | None = None,
        over: str | None = None,
        gamma_deg: float | None = None,
        **dimensions: float | str,
    ) -> Axes:
        """Draw a response over one factor, with the band of its error.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            New ones by default.
        response : str, optional
            The first of the model by default.
        over : str, optional
            A numeric factor, by default the first; or "gamma_deg", the angle to the neighbors.
        gamma_deg, **dimensions
            As in `lookup`. By default factors are in the middle of their range, choices at
            their first label.

        Raises
        ------
        InputError
            As in `lookup`, if `over` is not a numeric factor, or that factor is given as well.
        """
        # Here: a lookup draws nothing.
        from crankbase.diagrams import BLUE, RED, display_unit, new_axes, write_title
        from fem.plots import angle_axis
        from regression.plots import POINTS, factor_size, label_factor_axis, response_text

        name = next(iter(self.responses)) if response is None else response
        family = self.family
        factor = next(iter(family.ranges)) if over is None else over
        if factor != ANGLE and factor not in family.ranges:
            raise InputError(
                f"over: given {over!r}; allowed are {', '.join((*family.ranges, ANGLE))}, because the model "
                "is evaluated over these."
            )
        swept = gamma_deg if factor == ANGLE else dimensions.get(factor)
        check_not_given(
            factor, swept, f"over={factor}", "the diagram sweeps it over its whole range"
        )
        low, high = (0.0, 180.0) if factor == ANGLE else family.ranges[factor]
        values = np.linspace(low, high, POINTS)
        asked = {key: v for key, v in _middle(family).items() if key != factor} | dict(dimensions)
        points: list[Lookup] = [
            self.lookup(name, **{**asked, ANGLE: gamma_deg, factor: value})
            for value in values.tolist()
        ]
        size = display_unit(points[0].unit)[1]
        axes = new_axes(axes)
        unit = family.unit(factor) if factor != ANGLE else "deg"
        x = values / (1.0 if factor == ANGLE else factor_size(unit, ()))
        y = np.array([point.value for point in points]) / size
        axes.plot(x, y, color=BLUE, label="equation")
        band = np.array([(point.lower, point.upper) for point in points], dtype=np.float64) / size
        if np.isfinite(band).all(axis=1).any():
            axes.fill_between(x, *band.T, color=BLUE, alpha=0.2, linewidth=0.0, label="error band")
        outside = np.array([not point.inside for point in points])
        if outside.any():
            beyond = np.where(outside, y, np.nan)
            axes.plot(x, beyond, color=RED, linestyle="--", label="outside the range of the fit")
        if factor == ANGLE:
            angle_axis(axes)
        else:
            label_factor_axis(axes, factor, unit, ())
        axes.set_ylabel(response_text(points[0].symbol.partition("(")[0], points[0].unit))
        write_title(axes, f"{name.replace('_', ' ')}, {points[0].support}".rstrip(", "))
        others = []
        for other, value in asked.items():
            text = value if isinstance(value, str) else family.format_value(other, float(value))
            others.append(finished(f"{other.replace('_', ' ')} {text}"))
        if gamma_deg is not None:
            others.append(f"neighbors at {gamma_deg:g} deg")
        axes.legend(frameon=False, title="\n".join(others), title_fontsize=8, fontsize=8)
        return axes

    def to_pandas(self) -> Any:
        """Return a table of the responses: symbol, unit, support, equation and its errors.

        Returns
        -------
        pandas.DataFrame
            Errors are relative; ``frame.attrs["units"]`` has the units of the columns.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        columns: dict[str, tuple[Any, str]] = {"response": (list(self.responses), "")}
        for names, unit in ((WORDS, ""), (ERRORS, "1"), (("equation",), "")):
            for name in names:
                columns[name] = (
                    [getattr(response, name) for response in self.responses.values()],
                    unit,
                )
        return table(columns)

    def to_xarray(
        self,
        *responses: str,
        points: int = 5,
        gamma_deg: ArrayLike | None = None,
        **dimensions: ArrayLike | str,
    ) -> Any:
        """Return responses on a grid of the factors.

        Parameters
        ----------
        *responses : str
            Names; all of the model by default.
        points : int
            Number of values of each numeric factor, 2 or more, if no dimension is given as an array.
        gamma_deg : float or (n,) array_like, optional
            As in `axial_compliance`; an array adds a dimension of its own.
        **dimensions : float, str or (n,) array_like
            Arrays form the grid. By default factors are in the middle of their range,
            choices at their first label; these are in ``attrs`` of the dataset.

        Raises
        ------
        InputError
            As in `axial_compliance`, if there are not 2 points or more, or the grid has more than a million.
        MissingLibraryError
            If xarray is not installed.
        """
        family = self.family
        most = whole_number("points", points, 2, "a factor's range has two ends")
        sizes: dict[str, Any] = dict(dimensions)
        if gamma_deg is not None:
            sizes[ANGLE] = gamma_deg
        sides = {name: np.asarray(value) for name, value in sizes.items() if np.ndim(value) == 1}
        fixed = {name: value for name, value in sizes.items() if name not in sides}
        if not sides:
            sides = {
                name: np.array([rounded(value) for value in np.linspace(*ends, most).tolist()])
                for name, ends in family.ranges.items()
                if name not in fixed
            }
        count = int(np.prod([len(values) for values in sides.values()]))
        if count > MOST_POINTS:
            raise InputError(
                f"points: given a grid of {count:,}; allowed are {MOST_POINTS:,}, because more fill the "
                "memory; give fewer points, or arrays of some factors only."
            )
        others = {n: v for n, v in _middle(family).items() if n not in sides} | fixed
        asked = others | dict(zip(sides, np.meshgrid(*sides.values(), indexing="ij"), strict=True))
        variables = {}
        for name in responses or tuple(self.responses):
            values = np.broadcast_to(self.value(name, **asked), [len(v) for v in sides.values()])
            response = self.responses[name]
            words = f"{name.replace('_', ' ')}, {response.support}".rstrip(", ")
            variables[name] = (tuple(sides), values, response.unit or "1", words)
        coordinates = {
            name: (
                values,
                "deg" if name == ANGLE else family.unit(name) or "1",
                name.replace("_", " "),
            )
            for name, values in sides.items()
        }
        made = grid(variables, coordinates)
        made.attrs |= others
        return made
