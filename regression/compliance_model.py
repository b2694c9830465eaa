"""A fitted compliance model in a file: dimensions in, compliance out, with its known errors.

A model answers for one family of throws: some dimensions are its factors, the others are fixed.
It needs neither mesh nor solver and is written as JSON that people can read.
"""

import hashlib
import json
import math
import os
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, Field, FiniteFloat, model_validator

from geometry.errors import InputError
from geometry.model import InputModel, field_extra
from geometry.quantity import show_quantity
from geometry.throw import CrankThrow
from regression.fits import Fit
from regression.forms import FittedForm, equation_text

FILE_FORMAT = "crankfem compliance model"
FORMAT_VERSION = 1

AXIAL = "axial_compliance"
TORSIONAL = "torsional_compliance"
# Symbol and unit of the responses that have a method of their own.
KNOWN_RESPONSES: Mapping[str, tuple[str, str]] = {
    AXIAL: ("e_n", "m/N"),
    TORSIONAL: ("e_t", "rad/(N m)"),
}

# Two dimensions are equal, or on the edge of a range, within this share: "98 mm" read from text
# and 0.098 may differ in the last digit.
_SAME = 1e-9

Value = float | NDArray[np.float64]


class OutsideRangeWarning(UserWarning):
    """A compliance was asked for outside the range of dimensions of its fit."""


@dataclass(frozen=True)
class Lookup:
    """One value from a compliance model, with all that is known about it.

    Parameters
    ----------
    value : float
        The compliance, in `unit`; never clipped.
    unit : str
        Its SI unit.
    support : str
        How the throw is supported, such as "pinned".
    inside : bool
        Whether every dimension lies within the range of the fit.
    remarks : tuple of str
        One sentence for each dimension outside its range.
    error : float or None
        Largest relative error at held-out designs; None if there were none.
    equation : str
        The equation in natural units.
    """

    value: float
    unit: str
    support: str
    inside: bool
    remarks: tuple[str, ...]
    error: float | None
    equation: str


class ResponseModel(InputModel):
    """One response of a compliance model: its equation, range and errors.

    Parameters
    ----------
    form : str
        "linear", "quadratic" or "log-quadratic".
    factors : tuple of str
        Names of the k varied dimensions.
    center, half_range, coefficients : tuple of float
        The equation in coded variables, as in `regression.forms.FittedForm`; this is what is
        evaluated.
    lowest, highest : tuple of float
        Range of each factor in the runs [SI].
    symbol, unit, support : str
        What the response is, in which SI unit, and how the throw was supported.
    r_squared, q_squared, largest_error, largest_heldout_error : float
        As in `regression.fits.Fit`; the second and the last may be None.
    runs, heldout_runs : int
        Numbers of finite element runs fitted and held out.
    equation : str
        The equation in natural units, for people.

    Raises
    ------
    InputError
        If a field is missing, unknown or contradicts another one.
    """

    section: ClassVar[str] = "response"
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    form: str
    factors: tuple[str, ...] = Field(min_length=1)
    center: tuple[FiniteFloat, ...]
    half_range: tuple[FiniteFloat, ...]
    coefficients: tuple[FiniteFloat, ...]
    lowest: tuple[FiniteFloat, ...]
    highest: tuple[FiniteFloat, ...]
    symbol: str
    unit: str
    support: str
    r_squared: FiniteFloat
    q_squared: FiniteFloat | None
    largest_error: FiniteFloat
    largest_heldout_error: FiniteFloat | None
    runs: int
    heldout_runs: int
    equation: str

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        fitted = self.fitted  # its construction checks the equation's numbers
        if len(set(self.factors)) != len(self.factors):
            raise InputError(f"factors: given {list(self.factors)}; each may stand once.")
        for name, values in (("lowest", self.lowest), ("highest", self.highest)):
            if len(values) != len(fitted.factors):
                raise InputError(
                    f"{name}: given {len(values)} numbers; allowed are {len(fitted.factors)}, one "
                    "for each factor."
                )
        for factor, low, high in zip(self.factors, self.lowest, self.highest, strict=True):
            if not 0.0 <= low < high:
                raise InputError(
                    f"lowest, highest: given {low:g} and {high:g} for {factor}; allowed is a range "
                    "from lower to higher without negative values."
                )
        return self

    @property
    def fitted(self) -> FittedForm:
        """The equation as a function."""
        return FittedForm(self.form, self.factors, self.center, self.half_range, self.coefficients)

    @classmethod
    def from_fit(
        cls,
        fit: Fit,
        *,
        symbol: str,
        unit: str,
        support: str = "pinned",
        lowest: Mapping[str, float] | None = None,
        highest: Mapping[str, float] | None = None,
    ) -> Self:
        """Take over a fit.

        Parameters
        ----------
        fit : Fit
            The fit; factors and response in SI units.
        symbol, unit, support : str
            What the response is, such as "e_n", "m/N" and "pinned".
        lowest, highest : mapping, optional
            Range of each factor, where the study's box is not what its runs span.
        """
        fitted = fit.fitted
        low, high = _span(fitted)
        return cls(
            form=fit.form,
            factors=fit.factors,
            center=fitted.center,
            half_range=fitted.half_range,
            coefficients=fitted.coefficients,
            lowest=tuple((lowest or low)[name] for name in fit.factors),
            highest=tuple((highest or high)[name] for name in fit.factors),
            symbol=symbol,
            unit=unit,
            support=support,
            r_squared=fit.r_squared,
            q_squared=fit.q_squared,
            largest_error=fit.largest_error,
            largest_heldout_error=fit.largest_heldout_error,
            runs=fit.runs,
            heldout_runs=fit.heldout_runs,
            equation=equation_text(fitted, symbol=symbol, unit=unit),
        )


class ComplianceModel(InputModel):
    """Regression equations for the compliances of a family of crank throws.

    Parameters
    ----------
    responses : dict of str to ResponseModel
        By name: "axial_compliance", "torsional_compliance", or others for `lookup`.
    fixed : dict of str to float
        The throw's dimensions that do not vary, by field of `CrankThrow` [SI].
    material : dict
        What the runs were calculated with, such as youngs_modulus [Pa] and poisson_ratio.
    provenance : dict
        Where the model comes from: key of the study, versions, date.

    Raises
    ------
    InputError
        If a field is missing or unknown, or a dimension is both fixed and a factor.

    Examples
    --------
    ``model = ComplianceModel.load("model.json")`` and then
    ``model.axial_compliance(web_width=0.300, web_thickness=0.068, pin_length=0.139)``.
    """

    section: ClassVar[str] = "model"
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    responses: dict[str, ResponseModel] = Field(min_length=1)
    fixed: dict[str, FiniteFloat] = Field(default_factory=dict)
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
        return self

    # ------------------------------------------------------------------------------ questions

    def axial_compliance(self, **dimensions: ArrayLike) -> Value:
        """Axial compliance e_n [m/N].

        Parameters
        ----------
        **dimensions : float or array_like
            The factors by name [SI]; arrays are broadcast together. A fixed dimension may be
            given if it has the model's value.

        Returns
        -------
        float or ndarray
            A float if all dimensions are plain numbers.

        Raises
        ------
        InputError
            If a factor is missing, a dimension is unknown, not positive or not finite, or a fixed
            one is given another value.

        Warns
        -----
        OutsideRangeWarning
            For each dimension outside the range of the fit; the value is not clipped.
        """
        return self._evaluate(AXIAL, dimensions)

    def torsional_compliance(self, **dimensions: ArrayLike) -> Value:
        """Torsional compliance [rad/(N m)]; else as `axial_compliance`."""
        return self._evaluate(TORSIONAL, dimensions)

    def lookup(self, response: str, **dimensions: float) -> Lookup:
        """One value of a response with its unit, error and equation.

        Parameters
        ----------
        response : str
            Name of the response, such as "axial_compliance".
        **dimensions : float
            As in `axial_compliance`, plain numbers only.

        Returns
        -------
        Lookup
            Dimensions outside their range are told in its remarks; nothing is warned about.

        Raises
        ------
        InputError
            As in `axial_compliance`; if the model does not hold the response; for an array.
        """
        model = self._response(response)
        arrays = self._checked(model, dimensions)
        for name, array in arrays.items():
            if array.ndim:
                raise InputError(
                    f"{name}: given an array of shape {array.shape}; allowed is one number, "
                    "because a lookup tells about one throw."
                )
        point = np.array([float(arrays[name]) for name in model.factors])
        remarks = tuple(_outside_sentences(model, arrays))
        return Lookup(
            value=float(model.fitted.predict(point)),
            unit=model.unit,
            support=model.support,
            inside=not remarks,
            remarks=remarks,
            error=model.largest_heldout_error,
            equation=model.equation,
        )

    def _response(self, name: str) -> ResponseModel:
        if name not in self.responses:
            raise InputError(
                f"response: given {name!r}; allowed are {', '.join(self.responses)}, which this "
                "model holds."
            )
        return self.responses[name]

    def _evaluate(self, name: str, dimensions: Mapping[str, ArrayLike]) -> Value:
        response = self._response(name)
        arrays = self._checked(response, dimensions)
        try:
            columns = np.broadcast_arrays(*(arrays[factor] for factor in response.factors))
        except ValueError:
            shapes = ", ".join(f"{factor} {arrays[factor].shape}" for factor in response.factors)
            raise InputError(
                f"dimensions: given arrays of the shapes {shapes}; allowed are shapes that can be "
                "broadcast together, one value or equally many of each."
            ) from None
        for sentence in _outside_sentences(response, arrays):
            # The caller of the public method is two frames up.
            warnings.warn(sentence, OutsideRangeWarning, stacklevel=3)
        values = response.fitted.predict(np.stack(columns, axis=-1))
        return values if values.ndim else float(values)

    def _checked(
        self, response: ResponseModel, dimensions: Mapping[str, Any]
    ) -> dict[str, NDArray[np.float64]]:
        """Return the factors as arrays, or say which dimension cannot be used."""
        needed = ", ".join(response.factors)
        for name in dimensions:
            if name not in response.factors and name not in self.fixed:
                raise InputError(
                    f"{name}: unknown dimension; allowed are {needed}, the factors of this model."
                )
        for name in response.factors:
            if name not in dimensions:
                raise InputError(f"{name}: missing; the model needs its factors {needed}.")
        # Features may be absent (0), and offsets of bores negative.
        least = dict(zip(response.factors, response.lowest, strict=True)) | self.fixed
        arrays = {
            name: _checked_array(name, value, least[name]) for name, value in dimensions.items()
        }
        for name, array in arrays.items():
            if name in self.fixed and not np.all(
                np.abs(array - self.fixed[name]) <= _SAME * abs(self.fixed[name])
            ):
                different = float(array.flat[int(np.argmax(np.abs(array - self.fixed[name])))])
                raise InputError(
                    f"{name}: given {_show(name, different)}; allowed is "
                    f"{_show(name, self.fixed[name])}, because it is fixed in this model (its "
                    f"factors are {needed})."
                )
        return {name: arrays[name] for name in response.factors}

    # ----------------------------------------------------------------------------------- file

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as a JSON file; an existing file is replaced in one step.

        Parameters
        ----------
        path : path-like
            Where to write.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        content = self.model_dump(mode="json")
        record = {
            "format": FILE_FORMAT,
            "version": FORMAT_VERSION,
            "checksum": _checksum(content),
            **content,
        }
        target = Path(path)
        text = json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(text)
            # Temporary files are private; a model is meant to be read.
            os.chmod(temporary, 0o644)
            os.replace(temporary, target)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a model that `save` wrote; it gives the same numbers to the last digit.

        Parameters
        ----------
        path : path-like
            The JSON file.

        Raises
        ------
        InputError
            If the file cannot be read, is no compliance model, is of a newer format, or was
            changed or cut since it was written.
        """
        shown = os.fspath(path)
        try:
            text = Path(path).read_text(encoding="utf-8")
        except OSError as error:
            raise InputError(
                f"{shown}: cannot be read ({error.strerror}); give the path of a compliance model "
                "file."
            ) from None
        except UnicodeDecodeError:
            raise InputError(f"{shown}: given a file that is not text; {_WANTED}.") from None
        try:
            record = json.loads(text)
        except (json.JSONDecodeError, RecursionError) as error:
            raise InputError(
                f"{shown}: given a file that is not complete JSON ({error}); {_WANTED}."
            ) from None
        return cls._from_record(record, shown)

    @classmethod
    def _from_record(cls, record: object, shown: str) -> Self:
        if not isinstance(record, dict) or record.get("format") != FILE_FORMAT:
            raise InputError(f"{shown}: given a file of another kind; {_WANTED}.")
        content = dict(record)
        del content["format"]
        version = content.pop("version", None)
        if version != FORMAT_VERSION:
            raise InputError(
                f"{shown}: given format version {version!r}; allowed is {FORMAT_VERSION}, the only "
                "one that this release of crankfem reads."
            )
        checksum = content.pop("checksum", None)
        if checksum != _checksum(content):
            raise InputError(
                f"{shown}: given a file whose checksum does not fit its content; it was changed or "
                "damaged after it was written, so its numbers cannot be trusted: fit the model "
                "again."
            )
        try:
            return cls(**content)
        except (InputError, TypeError) as error:
            raise InputError(f"{shown}: given a damaged compliance model; {error}") from None


_WANTED = "allowed is a compliance model file as crankfem saves it"


def _checksum(content: Mapping[str, object]) -> str:
    """Return the SHA-256 of the content in one fixed spelling."""
    spelled = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(spelled.encode()).hexdigest()


def _span(fitted: FittedForm) -> tuple[dict[str, float], dict[str, float]]:
    """Return the lowest and highest value of each factor in the runs."""
    low: dict[str, float] = {}
    high: dict[str, float] = {}
    for name, center, half in zip(fitted.factors, fitted.center, fitted.half_range, strict=True):
        low[name], high[name] = center - half, center + half
        if fitted.logarithmic:
            low[name], high[name] = math.exp(low[name]), math.exp(high[name])
    return low, high


def _checked_array(name: str, value: object, least: float) -> NDArray[np.float64]:
    """Return finite numbers, positive ones unless the least of the model says otherwise."""
    sign = "positive finite numbers" if least > 0.0 else "positive finite numbers (or 0)"
    sign = "finite numbers" if least < 0.0 else sign
    allowed = f"allowed are {sign} in SI units (m for a length)"
    try:
        raw = np.asarray(value)
        if raw.dtype.kind not in "iuf":
            raise TypeError
        array = raw.astype(np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: given {value!r}; {allowed}.") from None
    if array.size == 0:
        raise InputError(f"{name}: given an empty array; {allowed}.")
    wrong = ~np.isfinite(array)
    if least >= 0.0:
        wrong |= array < 0.0
    if least > 0.0:
        wrong |= array == 0.0
    if np.any(wrong):
        raise InputError(f"{name}: given {float(array[wrong].flat[0]):g}; {allowed}.")
    return array


def _outside_sentences(
    response: ResponseModel, arrays: Mapping[str, NDArray[np.float64]]
) -> list[str]:
    """Return one sentence for each factor outside its range, naming its farthest value."""
    sentences: list[str] = []
    for name, low, high in zip(response.factors, response.lowest, response.highest, strict=True):
        array = arrays[name]
        beyond = np.maximum(low * (1.0 - _SAME) - array, array - high * (1.0 + _SAME))
        number = int(np.count_nonzero(beyond > 0.0))
        if number == 0:
            continue
        farthest = float(array.flat[int(np.argmax(beyond))])
        several = f" (and {number - 1} more)" if number > 1 else ""
        sentences.append(
            f"{name}: given {_show(name, farthest)}{several}; the range of the fit is "
            f"{_show(name, low)} to {_show(name, high)}, beyond which its error is unknown."
        )
    return sentences


def _show(name: str, value: float) -> str:
    """Write a dimension with its unit."""
    declared = CrankThrow.model_fields.get(name)
    unit = field_extra(declared, "unit") if declared is not None else None
    return show_quantity(value, str(unit)) if unit is not None else f"{value:g}"
