"""A fitted compliance model in a file: dimensions in, compliance out, with its known errors.

A model is valid for one family of throws: some dimensions are its factors, the others are fixed; in
dimensionless groups it is valid for throws of the family at any size. It needs neither mesh nor solver
and is written as readable JSON.
"""

import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError
from geometry.throw import CrankThrow
from regression.models.angle import fold_angle
from regression.models.family_throw import query_for_throw
from regression.models.lookup import (
    Lookup,
    Lookups,
    make_lookup,
    make_lookup_between_neighbors,
    make_lookups,
    make_lookups_between_neighbors,
)
from regression.models.model_values import ModelValues
from regression.models.response_query import ResponseValues
from regression.response_kinds import ANGLE_LAWS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fem.supports import Support
    from regression.models.reaction_lookup import ReactionLookup

Value = float | NDArray[np.float64]


class ComplianceModel(ModelValues):
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
    constraints : tuple of str or None
        Constraints of the study: a throw that violates one counts as outside the range of the fit.
        None if unknown, as in files of older releases; lookups then state it.
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
        for name, given in asked.items():
            if not (given is None or isinstance(given, float | str)) and np.ndim(given):
                raise InputError(
                    f"{name}: given an array of shape {np.shape(given)}; allowed is one number, "
                    "because `lookup` is for one throw: `lookups` takes arrays."
                )
        if gamma_deg is None:
            return self._lookup(response, dimensions, strict)
        parts = [self._lookup(part, dimensions, strict) for part in self.angle_law(response)]
        known = self.responses.get(response)
        return make_lookup_between_neighbors(
            fold_angle(gamma_deg),
            parts,
            parts[0].symbol if known is None else known.symbol,
            self._compiled.angle_law_remarks,
        )

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
        parts = (response,) if gamma_deg is None else self.angle_law(response)
        answers = {part: self._answered(part, dimensions, strict) for part in parts}
        compiled = self._compiled
        found = [
            make_lookups(self.responses[part], compiled.bands[part], answer, compiled.remarks)
            for part, answer in answers.items()
        ]
        if gamma_deg is None:
            return found[0]
        known = self.responses.get(response)
        return make_lookups_between_neighbors(
            fold_angle(gamma_deg),
            found,
            found[0].symbol if known is None else known.symbol,
            self._compiled.angle_law_remarks,
        )

    def _lookup(self, name: str, dimensions: Mapping[str, Any], strict: bool) -> Lookup:
        value = self._compiled.fast_lookup(name, dimensions)
        if value is None:
            answer = self._answered(name, dimensions, strict)
        else:
            answer = ResponseValues(value, (), True)
        compiled = self._compiled
        return make_lookup(self.responses[name], compiled.bands[name], answer, compiled.remarks)

    def _answered(self, name: str, dimensions: Mapping[str, Any], strict: bool) -> ResponseValues:
        answer = self.answer(name, dimensions)
        if strict and answer.outside:
            raise InputError(answer.outside[0].error_sentence)
        return answer

    def reactions(
        self,
        pin_force: ArrayLike,
        support: "Support" = "pinned",
        *,
        strict: bool = False,
        **dimensions: ArrayLike | str,
    ) -> "ReactionLookup":
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
        from regression.models.reaction_lookup import look_reactions_up

        return look_reactions_up(self, self.lookups, pin_force, support, strict, dimensions)

    def dimensions_of(self, throw: CrankThrow) -> dict[str, Any]:
        """Return the dimensions and labels of a throw for queries to the model.

        Parameters
        ----------
        throw : CrankThrow

        Raises
        ------
        InputError
            If the throw has a feature that the throws of the model lack, or lacks one.
        """
        return dict(query_for_throw(throw, self._compiled.family, self.throw))

    def of_throw(
        self, throw: CrankThrow, *, gamma_deg: float | None = None, strict: bool = False
    ) -> dict[str, Lookup]:
        """Look all responses up for a throw.

        Parameters
        ----------
        throw : CrankThrow
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
        asked = self.dimensions_of(throw)
        found: dict[str, Lookup] = {}
        refused: dict[str, InputError] = {}
        for name in self.responses:
            angle = gamma_deg if name in ANGLE_LAWS else None
            try:
                found[name] = self.lookup(name, gamma_deg=angle, strict=strict, **asked)
            except InputError as error:
                refused[name] = error
        if not found:
            raise next(iter(refused.values()))
        for name, reason in refused.items():
            warnings.warn(f"{name} is left out: {reason}", stacklevel=2)
        return found

    def plot(
        self,
        axes: "Axes | None" = None,
        *,
        response: str | None = None,
        over: str | None = None,
        gamma_deg: float | None = None,
        **dimensions: float | str,
    ) -> "Axes":
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

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            As in `lookup`, if `over` is not a numeric factor, or that factor is given as well.
        """
        from regression.models.model_sections import plot_section

        name = next(iter(self.responses)) if response is None else response
        return plot_section(axes, self.family, self.lookup, name, over, gamma_deg, dimensions)

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
        from regression.models.model_sections import response_table

        return response_table(self.responses)

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

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        InputError
            As in `axial_compliance`, if there are not 2 points or more, or the grid has more than a million.
        MissingLibraryError
            If xarray is not installed.
        """
        from regression.models.model_sections import response_grid

        return response_grid(
            self.family, self.value, self.responses, responses, points, gamma_deg, dimensions
        )
