"""An equation as text in the field's units, with sufficient digits for calculation."""

import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from crankbase.array_checks import Array
from regression.fits.forms import Basis, FittedForm, Term, design_matrix, term_name
from regression.fits.gaussian_process import GaussianProcess
from regression.plots import term_text
from regression.response_kinds import SCALES
from regression.throw_values import FactorLabel as FactorLabel
from regression.throw_values import factor_label as factor_label

# Evaluating a printed equation must give the prediction within this share (a tenth of what is
# promised to the reader).
PRINTED_EQUATION_ERROR = 1e-5
SMALLEST_DIGITS = 6
LARGEST_DIGITS = 17
# Up to this many factors a printed equation is tried at every corner and middle of the box.
_FACTORS_TRIED_FULLY = 6


def equation_text(fitted: FittedForm, *, symbol: str, unit: str, basis: Basis = "factors") -> str:
    """Write the equation in natural units, with sufficient digits for calculation.

    Evaluated by hand it gives the prediction within 1e-4 of its value over the box of the runs: numbers
    have 6 digits, or more if necessary. On groups it gives the dimensionless response.

    A Gaussian process has none: it is described.

    Forms: ``e_n = 1e-9 * (6.1 - 0.0583 B + ...) m/N, lengths in mm``; in logarithms ``ln(e_n / (1e-9
    m/N)) = 7.2 - 1.1 ln(B/mm) + ...``, of the first degree ``e_n = 7.2e-6 m/N * (B/mm)^-1.1
    (h/mm)^-0.9``; on groups ``ln(e_n E D_shm) = 3.1 + 0.9 ln(R/h) + ...``. A category is ``[web_outline
    = rectangle]``, 1 if it applies and 0 otherwise.
    """
    if fitted.process is not None:
        return _process_text(fitted, fitted.process, symbol)
    if basis == "groups":
        symbol, unit, size = SCALES[unit].symbol.format(symbol), "", 1.0
        shown = [
            factor_label(name) if "=" in name else FactorLabel(f"({name})", "", 1.0)
            for name in fitted.factors
        ]
    else:
        size = _response_scale(fitted)
        shown = [factor_label(name) for name in fitted.factors]
    sizes = [label.size for label in shown]
    linear = all(len(term) < 2 for term in fitted.terms)
    if linear and fitted.logarithmic and all(fitted.log_factors):
        natural = fitted.natural_coefficients(sizes)
        return _power_law_text(natural, shown, symbol, unit, _digits_needed(fitted, natural, sizes))
    natural = fitted.natural_coefficients(sizes, size)
    digits = _digits_needed(fitted, natural, sizes)
    names = [
        _symbol_text(label, fitted.logarithmic, logged)
        for label, logged in zip(shown, fitted.log_factors, strict=True)
    ]
    total = _sum_text(natural, names, digits)
    power = "" if size == 1.0 else f"{size:g}".replace("e-0", "e-").replace("e+0", "e")
    if fitted.logarithmic:
        reference = " ".join(part for part in (power, unit) if part)
        left = f"ln({symbol} / ({reference}))" if reference else f"ln({symbol})"
        return f"{left} = {total}"
    bracket = f"{power} * ({total})" if power else f"({total})"
    return f"{symbol} = {bracket} {unit}".rstrip() + _units_text(shown)


def term_symbols(fitted: FittedForm) -> tuple[str, ...]:
    """Name the terms in symbols, such as "ln(B) ln(h)^2"; "1" is the constant."""
    symbols = [factor_label(name).symbol for name in fitted.factors]
    names = [
        f"ln({name})" if logged else name
        for name, logged in zip(symbols, fitted.log_factors, strict=True)
    ]
    return tuple(term_name(term, names, " ") for term in fitted.terms)


def _process_text(fitted: FittedForm, process: GaussianProcess, symbol: str) -> str:
    labels = [factor_label(name).symbol for name in fitted.factors]
    scales = zip(labels, process.scales, strict=True)
    deviation, *noises = np.sqrt(process.variance * np.array([1.0, *process.noises]))
    slopes = len(process.weights) - process.values
    return (
        f"no equation can be written; the model evaluates {symbol} by {process.values} values and {slopes} "
        f"slopes. Standard deviation of {'ln ' * fitted.logarithmic}{symbol} {deviation:.3g}, noise "
        f"{noises[0]:.2g} of values{f', {noises[1]:.2g} of slopes' * bool(slopes)}; length scales in halves "
        f"of the ranges: {', '.join(f'{label} {scale:.3g}' for label, scale in scales)}"
    )


def _power_law_text(
    natural: Mapping[Term, float],
    labels: Sequence[FactorLabel],
    symbol: str,
    unit: str,
    digits: int,
) -> str:
    """Write C (B/mm)^a (h/mm)^b."""
    # One digit more than an exponent needs, for the constant is exp of a coefficient.
    constant = f"{math.exp(natural[()]):.{digits}g}".replace("e-0", "e-").replace("e+0", "e")
    powers = [
        f"{_base_text(labels[term[0]])}^{value:.{digits}g}"
        for term, value in natural.items()
        if term
    ]
    return f"{symbol} = " + " * ".join(
        part for part in (f"{constant} {unit}".rstrip(), " ".join(powers)) if part
    )


def _base_text(label: FactorLabel) -> str:
    return f"({label.symbol}/{label.unit})" if label.unit else label.symbol


def _response_scale(fitted: FittedForm) -> float:
    """Return the power of 1000 near the response in the middle of the box."""
    middle = np.array(
        [
            math.exp(center) if logged else center
            for center, logged in zip(fitted.center, fitted.log_factors, strict=True)
        ]
    )
    value = abs(float(fitted.predict(middle)))
    if value == 0.0:
        return 1.0
    return float(f"1e{3 * math.floor((math.log10(value) + 0.5) / 3.0)}")


def _symbol_text(label: FactorLabel, logarithmic: bool, logged: bool) -> str:
    if logged:
        inner = label.symbol.strip("()")
        return f"ln({inner}/{label.unit})" if label.unit else f"ln({inner})"
    # Inside a logarithm of the response no unit may be left.
    return _base_text(label) if logarithmic else label.symbol


def _sum_text(natural: Mapping[Term, float], names: Sequence[str], digits: int) -> str:
    """Write "6.1 - 0.0583 B^2 h", or "6.1 - 0.0583 (ln(B/mm))^2 ln(h/mm)"."""
    parts: list[str] = []
    for term, value in natural.items():
        if value == 0.0 and term:
            continue
        sign = "-" if value < 0.0 else "+"
        lead = ("-" if value < 0.0 else "") if not parts else f" {sign} "
        text = f"{lead}{abs(value):.{digits}g}"
        for number, power in sorted(Counter(term).items()):
            name = names[number]
            if power > 1:
                name = f"({name})^{power}" if name.startswith("ln(") else f"{name}^{power}"
            text += f" {name}"
        parts.append(text)
    return "".join(parts)


def _units_text(labels: Sequence[FactorLabel]) -> str:
    units = {label.unit for label in labels if not label.symbol.startswith("[")}
    if units == {"mm"}:
        return ", lengths in mm"
    stated = [f"{label.symbol} in {label.unit}" for label in labels if label.unit]
    return ", " + ", ".join(stated) if stated else ""


def _digits_needed(
    fitted: FittedForm, natural: Mapping[Term, float], sizes: Sequence[float]
) -> int:
    """Return the least number of digits, 6 or more, with which the printed equation predicts the same."""
    count = len(fitted.factors)
    if count <= _FACTORS_TRIED_FULLY:
        coded = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=count)))
    else:
        coded = np.random.default_rng(0).integers(-1, 2, size=(2000, count)).astype(np.float64)
    raw = np.asarray(fitted.center) + coded * np.asarray(fitted.half_range)
    logged = np.asarray(fitted.log_factors)
    units = np.where(logged, raw - np.log(sizes), raw / np.asarray(sizes))
    matrix = design_matrix(list(natural), units)
    exact = matrix @ np.array(list(natural.values()))
    for digits in range(SMALLEST_DIGITS, LARGEST_DIGITS):
        rounded = np.array([float(f"{value:.{digits}g}") for value in natural.values()])
        printed = matrix @ rounded
        if fitted.logarithmic:
            # A difference of logarithms is the relative difference of the response.
            error = float(np.max(np.abs(printed - exact)))
        else:
            # Where the response passes through zero no relative error can be small.
            floor = 1e-3 * float(np.max(np.abs(exact)))
            error = float(np.max(np.abs(printed - exact) / np.maximum(np.abs(exact), floor)))
        if error <= PRINTED_EQUATION_ERROR:
            return digits
    return LARGEST_DIGITS


def term_effects(fitted: FittedForm) -> tuple[list[str], Array]:
    """Return terms, as written in diagrams, and their coded coefficients, the largest first.

    The constant is left out.
    """
    values = dict(zip(term_symbols(fitted), fitted.coefficients, strict=True))
    order = sorted(values, key=lambda name: -abs(values[name]))
    order.remove("1")
    return [term_text(name) for name in order], np.array([values[name] for name in order])
