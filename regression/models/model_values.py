"""The values of a compliance model: responses as numbers and arrays, with warnings outside the study."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError
from regression.models.angle import between_values, fold_angle
from regression.models.extrapolation import OutsideRangeWarning
from regression.models.model_content import ModelContent
from regression.models.response_query import ResponseValues
from regression.response_kinds import AXIAL, INFLUENCE, TORSIONAL

Value = float | NDArray[np.float64]


class ModelValues(ModelContent):
    """The plain numbers of a `ComplianceModel`."""

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
        found: Value
        if gamma_deg is None:
            value = self._compiled.fast_lookup(name, dimensions)
            if value is not None:
                return value
            answers = [self.answer(name, dimensions)]
            found = answers[0].values
        else:
            parts = self.angle_law(name)
            values: list[Any] | None = self._compiled.fast_lookups(parts, dimensions)
            answers = [] if values else [self.answer(part, dimensions) for part in parts]
            values = values or [answer.values for answer in answers]
            found = between_values(fold_angle(gamma_deg), values)
        # Each dimension is told of once.
        for one in {one.name: one for answer in answers for one in answer.outside}.values():
            if strict:
                raise InputError(one.error_sentence)
            warnings.warn(one.remark, OutsideRangeWarning, stacklevel=3)
        return found

    def answer(self, response: str, dimensions: Mapping[str, ArrayLike | str]) -> ResponseValues:
        """Values of a response with those outside its range, without warnings."""
        return self._compiled.query(response).evaluate(dimensions)
