"""Forms of equations fitted to all responses of a study."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from crankbase.errors import InputError
from crankfem.analyses.study.response_fits import ResponseFits, fit_scale
from fem.responses import RESPONSES
from regression.fits.columns import Encoding, factor_encoding, group_encoding
from regression.fits.fits import Fit, fit_form
from regression.fits.forms import FORMS, Form
from regression.fits.selection import choose
from regression.plans.plan import PlannedStudy
from regression.records import MEASURED, RUN
from regression.runs.study_table import StudyTable, throw_dimensions

# Supports, as they stand at the end of a response's name, and what they are called.
SUPPORTS = {
    "pinned": "pinned",
    "guided": "guided",
    "opposite": "neighbors opposite, 180 deg",
    "in_line": "neighbors in line, 0 deg",
}
MAIN_SUPPORT = "_pinned"


def fit_study(table: StudyTable) -> dict[str, ResponseFits]:
    """Fit all forms to all responses of a study.

    Parameters
    ----------
    table : StudyTable

    Returns
    -------
    dict
        Response name, as in the model, to its fits. A response to which no form can be fitted is
        left out; `ResponseFits.unfitted` gives the reason for the others.

    Raises
    ------
    InputError
        If too few designs have results for even the smallest form, or no held-out design has one.
    """
    if not table.held_out.any():
        why = "; ".join(sorted({reason for _, _, reason in table.failures})[:3])
        raise InputError(f"study: no held-out design has a result ({why}).")
    encodings, missing = _encodings(table)
    found: dict[str, ResponseFits] = {}
    reasons: dict[str, str] = {}
    for column in RESPONSES:
        if column not in table.responses:
            continue
        try:
            fits = _fit_response(table, column, encodings, missing)
        except InputError as error:
            reasons[column] = str(error)
        else:
            found[fits.response] = fits
    if not found:
        raise InputError(next(iter(reasons.values()), "study: given no response; one is needed."))
    return {name: replace(fits, unfitted=reasons) for name, fits in found.items()}


def check_study_can_be_fitted(planned: PlannedStudy) -> None:
    """Refuse a study whose designs that can be built are too few for any equation.

    Raises
    ------
    InputError
    """
    factors = planned.plan.factors
    runs = [design for design in planned.designs if design.role == RUN]
    values = np.array([design.values for design in runs])
    throws = [throw_dimensions(design.inputs["throw"]) for design in runs]
    same = set(throws[0]).intersection(*throws)
    dimensions = {name: np.array([throw[name] for throw in throws]) for name in same}
    encodings = {"factors": factor_encoding(factors, values)}
    with suppress(InputError):
        encodings["groups"] = group_encoding(factors, values, dimensions)
    reason = ""
    for form in FORMS.values():
        encoding = encodings.get(form.basis)
        if encoding is None:
            continue
        x = encoding.columns(factors, values, dimensions)
        try:
            _ = fit_form(form.name, encoding.names, x, np.ones(len(x)), logged=encoding.logged)
        except InputError as error:
            reason = reason or str(error)
        else:
            return
    excluded = [design for design in planned.excluded if design.role == RUN]
    first = f"; reason for the first excluded design: {excluded[0].reason}" if excluded else ""
    raise InputError(
        f"study.factors: given {len(runs) + len(excluded)} designs of which {len(runs)} can be built, to "
        f"which no equation can be fitted ({reason.rstrip('.')}); allowed are ranges in which throws can be "
        f"built{first.rstrip('.')}."
    )


def response_name(column: str) -> tuple[str, str]:
    """Split a column of the table into the model's name of the response and its support.

    Examples
    --------
    >>> response_name("axial_compliance_pinned")
    ('axial_compliance', 'pinned')
    >>> response_name("axial_compliance_in_line")
    ('axial_compliance_in_line', 'neighbors in line, 0 deg')
    """
    support = next((text for end, text in SUPPORTS.items() if column.endswith(f"_{end}")), "")
    return column.removesuffix(MAIN_SUPPORT), support


def _encodings(table: StudyTable) -> tuple[dict[str, Encoding], dict[str, str]]:
    """Return the encodings by basis, and the reasons why there are no others."""
    runs = ~table.held_out
    values = table.values[runs]
    dimensions = {name: column[runs] for name, column in table.dimensions.items()}
    found = {"factors": factor_encoding(table.plan.factors, values)}
    try:
        _check_similar(table)
        found["groups"] = group_encoding(table.plan.factors, values, dimensions)
    except InputError as error:
        return found, {"groups": str(error)}
    return found, {}


def _check_similar(table: StudyTable) -> None:
    """Refuse groups where throws of different size carry a part of one size."""
    throw = table.plan.throw
    parts = [
        name
        for name in ("counterweight", "left_web", "right_web", "further_pins", "oil_holes")
        if getattr(throw, name)
    ]
    if parts and float(np.ptp(table.dimensions["pin_diameter"])) > 0.0:
        raise InputError(
            f"groups: given throws of different sizes with {parts[0]}; allowed are throws without, "
            "because the part does not grow with the throw."
        )


def _fit_response(
    table: StudyTable, column: str, encodings: Mapping[str, Encoding], missing: Mapping[str, str]
) -> ResponseFits:
    kind = RESPONSES[column]
    name, support = response_name(column)
    fits: list[Fit] = []
    skipped: list[str] = []
    twins: dict[str, str] = {}
    for form in FORMS.values():
        if form.basis in missing:
            skipped.append(f"{form.name}: {missing[form.basis]}")
            continue
        try:
            fit = _fit(table, column, form, encodings[form.basis])
        except InputError as error:
            skipped.append(f"{form.name}: {error}")
            continue
        twin = next((other.form for other in fits if _same_terms(fit, other)), None)
        if twin is None:
            fits.append(fit)
        else:
            twins[form.name] = twin
            skipped.append(f"{form.name}: has the same terms as {twin} in this study.")
    if not fits:
        raise InputError(f"study: no form can be fitted to {name} ({'; '.join(skipped)})")
    errors = _fe_errors(table, column)
    scatter = float(np.std(errors)) if errors else 0.0
    choice = choose(fits, scatter)
    return ResponseFits(
        response=name,
        column=column,
        symbol=kind.symbol,
        unit=kind.unit,
        support=support,
        fits=tuple(fits),
        chosen=fits[choice.place],
        reason=choice.reason,
        skipped=tuple(skipped),
        twins=twins,
        fe_error=max(errors, default=None),
        fe_scatter=scatter,
        encodings=dict(encodings),
    )


def _fe_errors(table: StudyTable, column: str) -> list[float]:
    """Relative errors of a response where known; imported rows may have none."""
    return [
        row.errors[column] for row in table.rows if row.role != MEASURED and column in row.errors
    ]


def _fit(table: StudyTable, column: str, form: Form, encoding: Encoding) -> Fit:
    y, held = table.responses[column], table.held_out
    x = encoding.columns(table.plan.factors, table.values, table.dimensions)
    scale = np.broadcast_to(fit_scale(table.plan, column, form.basis, table.dimensions), y.shape)
    return fit_form(
        form.name,
        encoding.names,
        x[~held],
        y[~held],
        x[held],
        y[held],
        scale=scale[~held],
        heldout_scale=scale[held],
        logged=encoding.logged,
        drop_terms=True,
    )


def _same_terms(fit: Fit, other: Fit) -> bool:
    one, two = fit.fitted, other.fitted
    return (
        fit.basis == other.basis
        and one.logarithmic == two.logarithmic
        and set(one.terms) == set(two.terms)
    )
