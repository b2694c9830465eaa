"""Least-squares fits of orders to samples at uneven angles: in windows, or along a whole record.

A signal is base(t) + Re sum_k X_k(t) exp(i k phi). Samples are fitted where they are, so that nothing is put
into a gap of a wheel. Teeth pass at known angles a, and a = phi(t) + Re sum_k X_k exp(i k phi): the base is
the rigid angle phi itself, which follows from the angles of the teeth in a few passes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, ComplexArray, Flags, Integers
from crankbase.errors import InputError

TURN = 2.0 * np.pi
# Passes from the angles of the teeth to rigid ones; the first alone errs by a tenth.
PASSES = 4
# Shortest window [revolutions] of constant amplitudes, and of those linear in time.
CONSTANT, LINEAR = 4.0, 8.0
# Least window [revolutions] times distance of neighboring orders.
SEPARATION = 0.24
# The base of a window is a polynomial of this degree.
BASE_DEGREE = 3
# Orders that are told apart worse than this are refused: condition of the fit's scaled columns.
MOST_CONDITION = 10.0
# Amplitudes along a record are cubic splines; between knots so many revolutions by the distance of orders.
DEGREE, KNOT_SPACING = 3, 0.75
# Weights of the amplitudes' second differences that are tried, as powers of ten.
FIRST_WEIGHT, LEAST_WEIGHT, MOST_WEIGHT = -4, -7, 6
# Turns on either side over which the speed changes.
RAMP_TURNS = 4.0
# Knots on either side of one for the condition there.
NEAR = 3
# Revolutions from which on what each tooth is off by is known from the residuals.
FOR_PITCHES = 20.0
# Deviation of a usual tooth [pitches].
USUAL_PITCH_ERROR = 0.02


@dataclass(frozen=True, eq=False)
class Samples:
    """What is fitted: values (n,) at times [s] and angles [rad], ascending.

    Attributes
    ----------
    angle : ndarray
        The rigid one; of a wheel, that of the teeth, which is the value too.
    tooth : ndarray or None
        Of a wheel, the number of each pulse's tooth within the revolution.
    pitches : int
        Of the wheel.
    """

    time: Array
    angle: Array
    value: Array
    tooth: Integers | None = None
    pitches: int = 1

    def within(self, rows: Flags | slice) -> "Samples":
        """Return some of them."""
        tooth = None if self.tooth is None else self.tooth[rows]
        return Samples(self.time[rows], self.angle[rows], self.value[rows], tooth, self.pitches)

    @property
    def revolutions(self) -> float:
        """From the first to the last sample."""
        return float(self.angle[-1] - self.angle[0]) / TURN


@dataclass(frozen=True, eq=False)
class OrderFit:
    """Orders at several times; shapes as those of `MeasuredOrders`.

    Attributes
    ----------
    condition : float
        Of the worst window.
    residual : float
        Root mean square of what is left [unit of the values].
    rigid : callable
        Rigid angle [rad] at times [s], of a wheel.
    left : ndarray
        What is left of each sample, of a fit along the whole record.
    """

    speed: Array
    ramp: Array
    amplitude: ComplexArray
    scatter: Array
    correlation: Array
    condition: float
    residual: float
    rigid: Callable[[Array], Array] | None = None
    left: Array | None = None


def spacing(orders: Array) -> float:
    """Return the least distance of two orders, or of one to the mean."""
    return float(np.min(np.diff(np.concatenate(([0.0], orders)))))


def waves(angle: Array, orders: Array) -> Array:
    """Return cos and -sin of each order, one after the other, (n, 2 K): factors of Re X and Im X."""
    turned = np.exp(1j * np.outer(angle, orders))
    return np.stack((turned.real, -turned.imag), axis=2).reshape(angle.size, -1)


def unbroken_windows(samples: Samples, begins: ArrayLike, length: float) -> Array:
    """Return the ends (m, 2) of windows from some angles on [rad] in which no revolution is without samples.

    Raises
    ------
    InputError
        If none is left.
    """
    ends = np.add.outer(np.asarray(begins, dtype=float), [0.0, length])
    pauses = np.flatnonzero(np.diff(samples.angle) > TURN)
    broken = (ends[:, :1] < samples.angle[pauses + 1]) & (ends[:, 1:] > samples.angle[pauses])
    kept: Array = ends[~np.any(broken, axis=1)]
    if not kept.size:
        pause = int(pauses[0])
        raise InputError(
            f"record: given nothing from {samples.time[pause]:.6g} s to {samples.time[pause + 1]:.6g} s; "
            f"allowed are records with {length / TURN:g} revolutions without a pause, because one window "
            "takes so many."
        )
    return kept


def fit_windows(samples: Samples, orders: Array, ends: Array, *, linear: bool = False) -> OrderFit:
    """Fit orders in windows from one angle to another [rad], (m, 2).

    Raises
    ------
    InputError
        If a window is too short, or orders are told apart too badly.
    """
    least = max(LINEAR if linear else CONSTANT, SEPARATION / spacing(orders))
    shortest = float(np.min(ends[:, 1] - ends[:, 0])) / TURN
    if shortest < least * (1.0 - 1e-9):
        raise InputError(
            f"window: given {shortest:.3g} revolutions; allowed are at least {least:.3g}, because orders "
            f"{spacing(orders):g} apart are told apart over so many."
        )
    rows = [slice(*np.searchsorted(samples.angle, pair).tolist()) for pair in ends]
    fits = [_window(samples.within(row), orders, linear) for row in rows]
    if samples.tooth is not None and samples.revolutions >= FOR_PITCHES:
        # What is left of a tooth in all windows is its own: it would spoil orders at their ends.
        teeth = np.concatenate([samples.tooth[row] for row in rows])
        left = np.bincount(teeth, np.concatenate([fit[6] for fit in fits]))
        off = (left / np.maximum(np.bincount(teeth), 1))[np.minimum(samples.tooth, teeth.max())]
        mended = replace(samples, angle=samples.angle - off, value=samples.value - off)
        fits = [_window(mended.within(row), orders, linear) for row in rows]
    common = np.minimum(ends[:, 1], ends[:, 1, None]) - np.maximum(ends[:, 0], ends[:, 0, None])
    length = ends[:, 1] - ends[:, 0]
    return OrderFit(
        speed=np.array([fit[0] for fit in fits]),
        ramp=np.array([fit[1] for fit in fits]),
        amplitude=np.array([fit[2] for fit in fits]),
        scatter=np.array([fit[3] for fit in fits]),
        correlation=np.maximum(common, 0.0) / np.sqrt(np.outer(length, length)),
        condition=max(fit[4] for fit in fits),
        residual=float(np.sqrt(np.mean([fit[5] ** 2 for fit in fits]))),
    )


def _window(
    samples: Samples, orders: Array, linear: bool
) -> tuple[float, float, ComplexArray, Array, float, float, Array]:
    """Return speed, ramp, amplitudes, scatter, condition, residual and what is left of one window."""
    time = samples.time
    half = 0.5 * float(time[-1] - time[0]) if time.size > 1 else 1.0
    u = (time - time[0]) / half - 1.0
    base = u[:, None] ** np.arange(BASE_DEGREE + 1)
    of_wheel, rigid = samples.tooth is not None, samples.angle
    value = samples.value - samples.value[0]
    count = BASE_DEGREE + 1 + (4 if linear else 2) * orders.size
    if time.size <= count:
        raise _too_many(orders, time.size, count)
    for _ in range(PASSES if of_wheel else 1):
        wave = waves(rigid, orders)
        columns = np.hstack((base, wave, wave * u[:, None])) if linear else np.hstack((base, wave))
        size = np.linalg.norm(columns, axis=0)
        squares = (columns / size).T @ (columns / size)
        values, vectors = np.linalg.eigh(squares)
        condition = float(np.sqrt(values[-1] / max(values[0], 1e-30)))
        _check_condition(condition, orders)
        inverse = (vectors / values) @ vectors.T
        solved = inverse @ ((columns / size).T @ value) / size
        rigid = samples.value - columns[:, BASE_DEGREE + 1 :] @ solved[BASE_DEGREE + 1 :]
        rigid = rigid if of_wheel else samples.angle
    left = value - columns @ solved
    variance = float(left @ left) / (time.size - count)
    parts = slice(BASE_DEGREE + 1, BASE_DEGREE + 1 + 2 * orders.size)
    error = np.sqrt(np.diag(inverse)[parts] * variance) / size[parts]
    pairs = solved[parts].reshape(-1, 2)
    if of_wheel:
        speed, ramp = float(solved[1]) / half, 2.0 * float(solved[2]) / half**2
    else:
        angle = np.polynomial.polynomial.polyfit(u, samples.angle - samples.angle[0], 2)
        speed, ramp = float(angle[1]) / half, 2.0 * float(angle[2]) / half**2
    amplitude = pairs[:, 0] + 1j * pairs[:, 1]
    scatter = np.sqrt(0.5 * np.sum(error.reshape(-1, 2) ** 2, axis=1))
    return speed, ramp, amplitude, scatter, condition, float(np.sqrt(variance)), left


def separation(samples: Samples, orders: Array) -> float:
    """Return the condition of the waves of orders over a shortest window, in the middle or nearest to it.

    Raises
    ------
    InputError
        If it is too bad, or as `unbroken_windows`.
    """
    length = TURN * max(CONSTANT, SEPARATION / spacing(orders))
    middle = 0.5 * float(samples.angle[0] + samples.angle[-1] - length)
    begins = np.append(middle, np.arange(samples.angle[0], samples.angle[-1] - length, length))
    windows = unbroken_windows(samples, begins, length)
    begin, end = windows[np.argmin(np.abs(windows[:, 0] - middle))]
    near = samples.within((samples.angle >= begin) & (samples.angle <= end))
    if near.time.size <= 1 + 2 * orders.size:
        raise _too_many(orders, near.time.size, 1 + 2 * orders.size)
    columns = np.hstack((np.ones((near.time.size, 1)), waves(near.angle, orders)))
    condition = float(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)))
    _check_condition(condition, orders)
    return condition


def _check_condition(condition: float, orders: Array) -> None:
    """Refuse a fit whose orders are told apart too badly."""
    if not condition <= MOST_CONDITION:
        raise InputError(
            f"orders: given {orders.size} up to {orders[-1]:g}; their condition is {condition:.3g}, allowed "
            f"is {MOST_CONDITION:g}, because errors grow by it: ask for fewer orders, or give a wheel with "
            "more teeth."
        )


def _too_many(orders: Array, samples: int, unknowns: int) -> InputError:
    return InputError(
        f"orders: given {orders.size} up to {orders[-1]:g}, with {unknowns} unknowns for {samples} samples; "
        "allowed are fewer unknowns, because least squares needs more samples."
    )


@dataclass(frozen=True, eq=False)
class _Splines:
    """Cubic splines over the time, with the values of those that are not zero at each sample."""

    knots: Array
    weights: Array
    first: Integers

    @classmethod
    def of(cls, samples: Samples, turns: float) -> "_Splines":
        """Place knots about so many revolutions apart."""
        from scipy.interpolate import BSpline

        time = samples.time
        pieces = max(round(samples.revolutions / turns), 1)
        inner = np.interp(
            np.linspace(samples.angle[0], samples.angle[-1], pieces + 1), samples.angle, time
        )
        beyond = np.arange(1, DEGREE + 1)
        before = inner[0] - (inner[1] - inner[0]) * beyond[::-1]
        after = inner[-1] + (inner[-1] - inner[-2]) * beyond
        knots = np.concatenate((before, inner, after))
        sparse = BSpline.design_matrix(time, knots, DEGREE)
        shape = (time.size, DEGREE + 1)
        return cls(
            knots, sparse.data.reshape(shape), sparse.indices.reshape(shape)[:, 0].astype(np.int64)
        )

    @property
    def count(self) -> int:
        """How many."""
        return self.knots.size - DEGREE - 1

    def at(self, coefficients: Array) -> Array:
        """Return the splines of coefficients (count, c) at the samples, (n, c)."""
        parts = [self.weights[:, j, None] * coefficients[self.first + j] for j in range(DEGREE + 1)]
        return np.asarray(sum(parts))

    def over(self, coefficients: Array, times: Array, derivative: int = 0) -> Array:
        """Return the splines, or a derivative, at other times."""
        from scipy.interpolate import BSpline

        return np.asarray(BSpline(self.knots, coefficients, DEGREE)(times, derivative))


def fit_along(samples: Samples, orders: Array, at: Array) -> OrderFit:
    """Fit orders whose amplitudes are smooth along the whole record, and return them at angles [rad], (m,).

    Notes
    -----
    Amplitudes and base are cubic splines over the time. The amplitudes' second differences are weighted; the
    weight is the most probable one (restricted likelihood), and the scatter holds what it hides besides
    noise. See Eilers and Marx, Statistical Science 11 (1996), 89.
    """
    from scipy.linalg import cho_solve_banded, cholesky_banded

    condition = separation(samples, orders)
    turns = KNOT_SPACING / min(spacing(orders), 0.5)
    splines = _Splines.of(samples, turns)
    trend = np.polynomial.Polynomial.fit(samples.time, samples.value, 1)
    of_wheel, rigid = samples.tooth is not None, samples.angle
    value = samples.value - trend(samples.time)
    unknowns = 1 + 2 * orders.size
    free = splines.count + 4 * orders.size
    if samples.time.size <= free:
        raise _too_many(orders, samples.time.size, free)
    bend = np.diff(np.eye(splines.count), 2, axis=0)
    bend = bend.T @ bend * (samples.time.size / splines.count)
    power = float(FIRST_WEIGHT)
    of_each = of_wheel and samples.revolutions >= FOR_PITCHES
    fixed = 2 * orders.size * (splines.count - 2)

    def constants(off: Array) -> Array:
        """Return the mean of the pitch errors and their whole orders, as Re and Im of each."""
        assert samples.tooth is not None
        teeth = np.unique(samples.tooth)
        angles = np.asarray(TURN / samples.pitches * teeth, dtype=float)
        columns = np.hstack((np.ones((teeth.size, 1)), waves(angles, orders[orders % 1.0 == 0.0])))
        return np.asarray(np.linalg.lstsq(columns, off[teeth])[0])

    def solve(power: float) -> tuple[float, Array, Array, Array, float]:
        """Return the likelihood's measure, coefficients, errors of teeth, what is left and its variance."""
        whole = matrix.copy()
        for below in range(3):
            rows = np.zeros((splines.count - below, unknowns))
            rows[:, 1:] = 10.0**power * np.diagonal(bend, -below)[:, None]
            whole[below * unknowns, : rows.size] += rows.ravel()
        try:
            factor = cholesky_banded(whole, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            raise InputError(
                f"record: lacks teeth over more than {turns:g} revolutions in a row; allowed is a record "
                "without such holes, because its amplitudes are smooth along the whole."
            ) from None
        pairs = cho_solve_banded((factor, True), right, check_finite=False)
        off = _pitch_errors(samples.tooth, pairs, right, value, noise) if of_each else np.zeros(0)
        solved = (pairs[:, 0] - pairs[:, 1:] @ off).reshape(splines.count, unknowns)
        if of_each:
            # The base, too, may move by a constant: the mean tooth is where an even wheel has it.
            solved[:, 0] += constants(off)[0]
            off = off - constants(off)[0]
        pitch = off[samples.tooth] if of_each else np.zeros(value.size)
        left = value - pitch - np.sum(splines.at(solved) * wave, axis=1)
        bent = 10.0**power * float(np.sum(solved[:, 1:] * (bend @ solved[:, 1:])))
        variance = (float(left @ left) + bent) / (value.size - free)
        determinant = 2.0 * float(np.sum(np.log(factor[0])))
        measure = (value.size - free) * np.log(variance) + determinant
        return measure - fixed * power * np.log(10.0), solved, off, left, variance

    passes = PASSES if of_wheel else 1
    noise = float(np.mean(np.diff(samples.value) ** 2)) * USUAL_PITCH_ERROR**2
    for turn in range(1, passes + 1):
        wave = np.hstack((np.ones((rigid.size, 1)), waves(rigid, orders)))
        matrix, right = _normal(splines, wave, value, samples.tooth if of_each else None)
        if turn == passes:
            power = _best_power(lambda tried: solve(tried)[0])
        _, solved, off, left, variance = solve(power)
        noise = variance
        if of_wheel:
            moved = np.sum(splines.at(solved)[:, 1:] * wave[:, 1:], axis=1)
            rigid = samples.value - moved - (off[samples.tooth] if of_each else 0.0)
    times = np.interp(at, samples.angle, samples.time)
    covariance, worse = _errors(splines, matrix, bend * 10.0**power, orders, times)
    deviation = np.sqrt(np.diag(covariance))
    pairs = splines.over(solved[:, 1:], times).reshape(times.size, -1, 2)
    if of_each:
        pairs[:, orders % 1.0 == 0.0] += constants(off)[1:].reshape(-1, 2)
    if of_wheel:  # the base is the rigid angle
        turned, curve, straight = splines, solved[:, 0], trend.deriv()
    else:
        turned, straight = _Splines.of(samples, turns), np.polynomial.Polynomial([0.0])
        whole, sides = _normal(turned, np.ones((rigid.size, 1)), rigid - rigid[0])
        curve = cho_solve_banded((cholesky_banded(whole, lower=True), True), sides[:, 0])
    # Twice differentiated, the base is noise: the speed changes as it does over some turns.
    around = at + RAMP_TURNS * TURN * np.array([[-1.0], [0.0], [1.0]])
    moments = np.interp(around, samples.angle, samples.time)
    before, speed, after = (turned.over(curve, each, 1) + straight(each) for each in moments)
    ramp = (after - before) / (moments[2] - moments[0])
    return OrderFit(
        speed,
        ramp,
        pairs[:, :, 0] + 1j * pairs[:, :, 1],
        np.sqrt(variance) * deviation[:, None] * worse,
        covariance / np.outer(deviation, deviation),
        condition,
        float(np.sqrt(np.mean(left**2))),
        lambda moments: splines.over(solved[:, 0], moments) + trend(moments),
        left,
    )


def _normal(
    splines: _Splines, wave: Array, value: Array, tooth: Integers | None = None
) -> tuple[Array, Array]:
    """Return the lower band of the normal equations, and the right sides of the values and of each tooth."""
    unknowns = wave.shape[1]
    width = (DEGREE + 1) * unknowns
    band = np.zeros((width, splines.count * unknowns))
    sides = value[:, None]
    if tooth is not None:
        sides = np.hstack((sides, np.eye(int(tooth.max()) + 1)[tooth]))
    right = np.zeros((splines.count * unknowns, sides.shape[1]))
    edges = np.searchsorted(splines.first, np.arange(splines.count - DEGREE + 1))
    for piece in range(splines.count - DEGREE):
        rows = slice(edges[piece], edges[piece + 1])
        columns = (splines.weights[rows, :, None] * wave[rows, None, :]).reshape(-1, width)
        squares, at = columns.T @ columns, piece * unknowns
        right[at : at + width] += columns.T @ sides[rows]
        for below in range(width):
            band[below, at : at + width - below] += np.diagonal(squares, -below)
    return band, right


def _best_power(measure: Callable[[float], float]) -> float:
    """Return the power of ten of the weight with the least measure, going down from the first one."""
    known = {float(FIRST_WEIGHT): measure(FIRST_WEIGHT)}

    def at(power: float) -> float:
        if power not in known:
            known[power] = measure(power)
        return known[power]

    best = float(FIRST_WEIGHT)
    for step in (1.0, -1.0):
        while LEAST_WEIGHT <= best + step <= MOST_WEIGHT and at(best + step) < at(best):
            best += step
    return best


def _pitch_errors(
    tooth: Integers | None, solved: Array, right: Array, value: Array, noise: float
) -> Array:
    """Return by how much each tooth is off.

    Whole orders that are constant look almost like it: they turn with the rigid angle, it with the teeth. The
    noise makes their separation uncertain, which matters only in products of both, and so it is undone in
    what is returned of the orders.
    """
    assert tooth is not None
    squares = np.diag(np.bincount(tooth).astype(float)) - right[:, 1:].T @ solved[:, 1:]
    sums = np.bincount(tooth, value) - right[:, 1:].T @ solved[:, 0]
    usual = USUAL_PITCH_ERROR * TURN / int(tooth.max() + 1)
    return np.asarray(np.linalg.solve(squares + (noise / usual**2) * np.eye(sums.size), sums))


def _errors(
    splines: _Splines, band: Array, bend: Array, orders: Array, times: Array
) -> tuple[Array, Array]:
    """Return the covariance of an order alone at times, and by how much others make its deviation larger.

    The first one is that of cos or sin, whose squares have the mean 1/2, by the unit variance of the samples.
    The teeth stand alike in every revolution, and so what orders do to each other is known from one place.
    """
    alone = 0.5 * _dense_gram(splines) + bend
    basis = splines.over(np.eye(splines.count), times)
    covariance = basis @ np.linalg.solve(alone, basis.T)
    unknowns = 1 + 2 * orders.size
    middle, near = splines.count // 2, min(NEAR, (splines.count - 1) // 2)
    some = np.arange(middle - near, middle + near + 1)
    first, size = some[0] * unknowns, some.size * unknowns
    block = np.zeros((size, size))
    for below in range(min(band.shape[0], size)):
        part = band[below, first : first + size - below]
        block[np.arange(below, size), np.arange(size - below)] = part
    block += np.tril(block, -1).T
    block += np.kron(bend[np.ix_(some, some)], np.diag([0.0, *np.ones(unknowns - 1)]))
    apart = np.kron(np.ones((some.size, some.size)), np.eye(unknowns)) * block
    row = near * unknowns + np.arange(1, unknowns)
    larger = np.diag(np.linalg.inv(block))[row] / np.diag(np.linalg.inv(apart))[row]
    return covariance, np.sqrt(0.5 * larger.reshape(-1, 2).sum(axis=1))


def _dense_gram(splines: _Splines) -> Array:
    """Return the sums of products of splines over the samples."""
    band, _ = _normal(splines, np.ones((splines.first.size, 1)), np.zeros(splines.first.size))
    whole = np.zeros((splines.count, splines.count))
    for below in range(band.shape[0]):
        size = splines.count - below
        whole[np.arange(below, splines.count), np.arange(size)] = band[below, :size]
    return np.asarray(whole + np.tril(whole, -1).T)
