"""Fit the groups of a shaft to measured orders by least squares, with covariance and intervals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from crankbase.array_checks import Array, ComplexArray
from crankbase.choices import check_some
from crankbase.errors import InputError
from crankfem.satellites.measured.calibration.response_slopes import Excitation, Sensor, Shaft
from crankfem.satellites.measured.measured_orders import MeasuredOrders, agreeing_angle

# The starts: the nominal values, and others drawn from the prior.
STARTS, SEED = 6, 0
# They use so many speeds of a record, evenly spread; the best one is then fitted to all.
SPEEDS_OF_STARTS = 40
MOST_STEPS = 60
# No step goes further from the prior, in deviations: nothing can be calculated there.
FARTHEST = 15.0
# Residuals of so many deviations are weighed as outliers (soft L1).
OUTLYING = 2.0
# Two-sided 95 % of the normal distribution, and when a profile's end is met, as a share.
NORMAL95, END_MET = 1.959964, 0.01
PROFILE_STEPS = 6
# Angles tried for a record whose zero is unknown, over its cycle.
ANGLES, SECTORS = 180, 12
# Points of Gauss's rule for a ramp.
RAMP_POINTS = 3
# Share of the values with which the mean square is as sure as their median is.
MEDIAN_KNOWS = 0.37
# With fewer values beyond the parameters than this the noise told is trusted as it is.
ENOUGH_TO_JUDGE = 30.0


@dataclass(frozen=True, eq=False)
class Observation:
    """Measured orders, where the sensor is on the shaft, and what excites the shaft then.

    Parameters
    ----------
    measured : MeasuredOrders
    sensor : Sensor
    excitation : Excitation
        At the points of all speeds and orders, (m k,), the orders of one speed together.
    phases : bool
        Whether phases are known; otherwise sizes alone are compared.
    growth : Excitation, optional
        Change of the excitation with the speed [N m s/rad], which counts in a ramp; none by default.

    Raises
    ------
    InputError
        If a scatter is zero: measured values are weighed by it.
    """

    measured: MeasuredOrders
    sensor: Sensor
    excitation: Excitation
    phases: bool = True
    growth: Excitation | None = None

    def __post_init__(self) -> None:
        if not np.all(self.measured.scatter > 0.0):
            raise InputError(
                f"{self.measured.place}: given orders with a scatter of {np.min(self.measured.scatter):g}; "
                "allowed is more than zero, because each value is weighed by it."
            )

    @cached_property
    def points(self) -> tuple[Array, Array]:
        """Angular frequency and speed at each point [rad/s], (m k,)."""
        measured = self.measured
        w = np.outer(measured.speed, measured.orders).ravel()
        return w, np.repeat(measured.speed, measured.orders.size)

    def thinned(self, most: int) -> "Observation":
        """Return the observation at up to so many of its speeds."""
        count = self.measured.speed.size
        if count <= most:
            return self
        some = np.unique(np.linspace(0, count - 1, most).astype(int))
        orders = self.measured.orders.size
        points = (some[:, np.newaxis] * orders + np.arange(orders)).ravel()
        return replace(
            self,
            measured=self.measured.part(some),
            excitation=self.excitation.at(points),
            growth=None if self.growth is None else self.growth.at(points),
        )

    def excited(self, off: ComplexArray) -> Excitation:
        """Return the excitation at frequencies off the points' by (n, N) [rad/s], for all of them (n N,)."""
        every = self.excitation.at(np.tile(np.arange(off.shape[1]), len(off)))
        if self.growth is None:
            return every
        w, speeds = self.points
        faster = (off * speeds / w)[..., np.newaxis]
        return replace(
            every,
            fixed=every.fixed + (faster * self.growth.fixed).reshape(every.fixed.shape),
            sources=every.sources + (faster * self.growth.sources).reshape(every.sources.shape),
        )


class Compared(NamedTuple):
    """One observation at some parameters: residuals in deviations, and their slopes.

    Of real and imaginary parts, or of sizes alone: (parts, m, k) and (parts, m, k, P).
    """

    residuals: Array
    slopes: Array


@dataclass(frozen=True, eq=False)
class Problem:
    """A shaft and what was measured on it.

    The parameters are those of the groups, in deviations of the prior, then the unknown zero angle of each
    observation that lacks it [rad].
    """

    shaft: Shaft
    observations: tuple[Observation, ...]

    def __post_init__(self) -> None:
        check_some("records", self.observations, "a fit needs measured values")

    @property
    def groups(self) -> int:
        """Number of groups."""
        return len(self.shaft.groups)

    @cached_property
    def angles(self) -> dict[int, int]:
        """Parameter of the zero angle by the number of the observation."""
        unknown = [k for k, each in enumerate(self.observations) if not each.measured.zero_known]
        return {k: self.groups + place for place, k in enumerate(unknown)}

    @property
    def size(self) -> int:
        """Number of parameters."""
        return self.groups + len(self.angles)

    def predicted(self, parameters: Array, number: int) -> tuple[ComplexArray, ComplexArray]:
        """Return the amplitudes (m, k) that an observation should have, and their slopes (m, k, P)."""
        each = self.observations[number]
        shape = each.measured.amplitude.shape
        w, speeds = each.points
        y, dy = self._in_a_ramp(parameters[: self.groups], each)
        slopes = np.zeros((y.size, self.size), dtype=np.complex128)
        slopes[:, : self.groups] = dy
        if number in self.angles:
            orders = w / speeds
            turned = np.exp(-1j * orders * parameters[self.angles[number]])
            y, slopes = y * turned, slopes * turned[:, np.newaxis]
            slopes[:, self.angles[number]] = -1j * orders * y
        return y.reshape(shape), slopes.reshape(*shape, -1)

    def _in_a_ramp(self, parameters: Array, each: Observation) -> tuple[ComplexArray, ComplexArray]:
        """Return the amplitudes and slopes while the speed changes.

        A force exp(i psi) of the frequency w, which grows at the rate a, meets an impulse response h as
        int h(t) exp(-i w t + i a t^2 / 2) dt: the mean of H over the frequencies w + sqrt(-i a) x of a normal
        x. Gauss's rule of n points has it up to the power n - 1 of a; of a peak n! lag^n is left.
        """
        w, speeds = each.points
        rate = np.outer(each.measured.ramp, each.measured.orders).ravel()
        if not np.any(rate):
            return self.shaft.amplitudes(parameters, each.sensor, w, speeds, each.excitation)
        x, weights = np.polynomial.hermite_e.hermegauss(RAMP_POINTS)
        off = np.multiply.outer(x, np.sqrt(-1j * rate))
        y, dy = self.shaft.amplitudes(
            parameters,
            each.sensor,
            (w + off).ravel(),
            np.tile(speeds, x.size),
            each.excited(off),
        )
        share = weights / np.sum(weights)
        by_point = dy.reshape(*off.shape, -1)
        return np.einsum("n,nm->m", share, y.reshape(off.shape)), np.einsum(
            "n,nmp->mp", share, by_point
        )

    def compared(self, parameters: Array, number: int) -> Compared:
        """Return residuals and slopes of an observation, by its scatter."""
        each = self.observations[number]
        y, dy = self.predicted(parameters, number)
        scatter, measured = each.measured.scatter, each.measured.amplitude
        if each.phases:
            off = (y - measured) / scatter
            slopes = dy / scatter[..., np.newaxis]
            return Compared(np.stack((off.real, off.imag)), np.stack((slopes.real, slopes.imag)))
        rates = _slopes_of_size(y, dy) / scatter[..., np.newaxis]
        return Compared(((np.abs(y) - np.abs(measured)) / scatter)[np.newaxis], rates[np.newaxis])

    def thinned(self, most: int) -> "Problem":
        """Return the problem with up to so many speeds of each record."""
        return Problem(self.shaft, tuple(each.thinned(most) for each in self.observations))


def _slopes_of_size(y: ComplexArray, dy: ComplexArray) -> Array:
    """Return the slopes of |y| from those of y, (..., P); zero where y is."""
    size = np.abs(y)
    direction = np.conj(y) / np.where(size > 0.0, size, 1.0)
    return np.asarray((direction[..., np.newaxis] * dy).real)


def without_constants(each: Observation, values: Array, weights: Array | None = None) -> Array:
    """Return values (parts, m, k, ...) less one constant of each order that holds one of the wheel.

    The constants are fitted by least squares with the scatter and further weights (parts, m, k).
    """
    flagged = np.flatnonzero(each.measured.wheel_constant)
    if not flagged.size or not each.phases:
        return values
    column = 1.0 / each.measured.scatter[:, flagged]
    kept = (np.ones(values.shape[:3]) if weights is None else weights)[:, :, flagged]
    if values.ndim > kept.ndim:  # of slopes
        column, kept = column[..., np.newaxis], kept[..., np.newaxis]
    some = values[:, :, flagged]
    size = np.sum(kept * column * some, axis=1) / np.sum(kept * column**2, axis=1)
    made = values.copy()
    made[:, :, flagged] = some - column * size[:, np.newaxis]
    return made


@dataclass(frozen=True, eq=False)
class Fit:
    """The parameters that fit best, and how sure they are.

    Attributes
    ----------
    parameters : ndarray of shape (P,)
        As `Problem` says.
    covariance : ndarray of shape (P, P)
        By a sandwich, with the correlation of windows, the weights of outliers and the misfit.
    data : ndarray of shape (R, P)
        Slopes of all measured values, in effective deviations, without the wheels' constants.
    misfit : float
        Square of the residuals' median size over that by the noise told; 1 where the model fits.
    limit : float
        What the misfit exceeds by chance in 1 of 100 fits.
    effective : float
        Number of independent real values.
    explained : float
        Share of the measured square sum that the model gives.
    starts : tuple of float
        Cost at the minimum that each start led to.
    residuals : tuple of ndarray (parts, m, k)
        Of each observation, in deviations.
    weights : tuple of ndarray (parts, m, k)
        1 for ordinary values, less for outliers.
    """

    problem: Problem
    parameters: Array
    covariance: Array
    data: Array
    misfit: float
    limit: float
    effective: float
    explained: float
    starts: tuple[float, ...]
    residuals: tuple[Array, ...]
    weights: tuple[Array, ...]

    @property
    def deviations(self) -> Array:
        """Standard deviations of the groups' parameters, (p,)."""
        return np.sqrt(np.diag(self.covariance))[: self.problem.groups]

    @property
    def lost_starts(self) -> int:
        """Number of starts that ended in a worse minimum."""
        best = min(self.starts)
        return sum(cost > best + max(1.0, 1e-3 * best) for cost in self.starts)

    def factors(self, parameters: Array | None = None) -> Array:
        """Return the factors (p,) of the groups, at the fitted parameters or others."""
        spread = np.array([group.deviation for group in self.problem.shaft.groups])
        chosen = self.parameters if parameters is None else parameters
        return np.asarray(np.exp(spread * chosen[: spread.size]))

    def interval(self, number: int) -> tuple[float, float]:
        """Return the ends of the 95 % interval of a group's factor, linear in its logarithm."""
        width = NORMAL95 * float(self.deviations[number])
        spread = self.problem.shaft.groups[number].deviation
        low, high = np.exp(spread * (self.parameters[number] + np.array([-width, width])))
        return float(low), float(high)

    def problem_of(self, observation: Observation) -> tuple[Problem, Array]:
        """Return the problem of another observation alone, and its parameters by this fit."""
        groups = self.problem.groups
        beside = Problem(self.problem.shaft, (observation,))
        return beside, np.concatenate((self.parameters[:groups], np.zeros(beside.size - groups)))

    def band(self, observation: Observation) -> tuple[ComplexArray, Array]:
        """Return the prediction (m, k) of an observation, and the deviation of its size from the fit's."""
        groups = self.problem.groups
        beside, parameters = self.problem_of(observation)
        y, dy = beside.predicted(parameters, 0)
        slopes = _slopes_of_size(y, dy)[..., :groups]
        covariance = self.covariance[:groups, :groups]
        return y, np.sqrt(np.einsum("mkp,pq,mkq->mk", slopes, covariance, slopes))


def fit(
    problem: Problem,
    *,
    robust: bool = True,
    starts: int = STARTS,
    seed: int = SEED,
    step: Callable[[str], None] | None = None,
) -> Fit:
    """Fit a problem: from several starts without the wheels' constants, then robustly with them.

    Parameters
    ----------
    robust : bool, optional
        Whether outliers are weighed less.
    starts, seed : int, optional
        The first start has the nominal values, the others are drawn from the prior.
    step : callable, optional
        Called with the name of each step.
    """
    from scipy.optimize import least_squares  # here: loading it takes a quarter second

    tell = step or (lambda _: None)
    thin = problem.thinned(SPEEDS_OF_STARTS)
    drawn = np.random.default_rng(seed).normal(size=(starts, problem.size))
    drawn[0] = 0.0
    # A weak cylinder is like another one with the zero in another part of the cycle: each part is tried.
    sectors = SECTORS if problem.angles else 0
    drawn = np.vstack((drawn, np.zeros((sectors, problem.size))))
    ends = []
    for number, start in enumerate(drawn):
        tell(f"Fitting from start {number + 1} of {len(drawn)}")
        start[problem.groups :] = 0.0
        for which in problem.angles:
            start[problem.angles[which]] = _first_angle(
                thin, which, start, number - starts if number >= starts else None
            )
        rows = Rows(thin)
        ends.append(
            least_squares(
                rows.residuals, start, rows.jacobian, x_scale="jac", ftol=1e-5, max_nfev=MOST_STEPS
            )
        )
    best = min(ends, key=lambda end: float(end.cost)).x
    tell("Fitting to all speeds")
    rows = Rows(problem)
    solution = least_squares(
        rows.residuals, best, rows.jacobian, x_scale="jac", max_nfev=MOST_STEPS
    ).x
    if robust:
        explicit = _WithConstants(problem)
        solution = least_squares(
            explicit.residuals,
            explicit.start(solution),
            explicit.jacobian,
            x_scale="jac",
            # Its stub asks for a keyword that scipy does not pass.
            loss=explicit.loss,  # type: ignore[arg-type]
            ftol=1e-6,
            max_nfev=MOST_STEPS,
        ).x[: problem.size]
    return _judged(
        problem, np.asarray(solution), robust, tuple(float(end.cost) for end in ends[:starts])
    )


def _first_angle(problem: Problem, number: int, start: Array, sector: int | None = None) -> float:
    """Return the zero angle [rad] at which an observation agrees best with the model at a start.

    Of a cycle, or of one of its `SECTORS`.
    """
    measured = problem.observations[number].measured
    y, _ = problem.predicted(start, number)
    weighed = np.sum(np.conj(measured.amplitude) * y / measured.scatter**2, axis=0)
    tried = np.linspace(0.0, 2.0 * np.pi * measured.cycle, ANGLES, endpoint=False)
    if sector is not None:
        tried = np.array_split(tried, SECTORS)[sector]
    return agreeing_angle(measured.orders, weighed, tried)


def _too_far(parameters: Array, problem: Problem) -> bool:
    return bool(np.max(np.abs(parameters[: problem.groups])) > FARTHEST)


class _LastValues:
    """Residuals and their slopes, kept where they were last asked for: least squares ask for each alone."""

    def __init__(self, calculate: Callable[[Array], tuple[Array, Array]]) -> None:
        self._calculate = calculate
        self._at: Array | None = None
        self.last: tuple[Array, Array] = np.zeros(0), np.zeros((0, 0))

    def __call__(self, parameters: Array) -> tuple[Array, Array]:
        if self._at is None or not np.array_equal(parameters, self._at):
            self.last = self._calculate(parameters)
            self._at = parameters.copy()
        return self.last


class Rows:
    """All residuals without the wheels' constants, in effective deviations; the prior's come last."""

    def __init__(self, problem: Problem, weights: Sequence[Array] | None = None) -> None:
        self._problem, self._weights = problem, weights
        self._all = _LastValues(self._calculated)

    def residuals(self, parameters: Array) -> Array:
        """Return the residuals; infinite ones too far from the prior, if there are any nearer."""
        if _too_far(parameters, self._problem):
            return np.full_like(
                self._all.last[0], np.inf
            )  # least_squares then takes a shorter step
        return self._all(parameters)[0]

    def jacobian(self, parameters: Array) -> Array:
        """Return their slopes."""
        return self._all(parameters)[1]

    def _calculated(self, parameters: Array) -> tuple[Array, Array]:
        problem = self._problem
        residuals, slopes = [], []
        for number, each in enumerate(problem.observations):
            weights = None if self._weights is None else self._weights[number]
            off, rates = problem.compared(parameters, number)
            off, rates = (without_constants(each, some, weights) for some in (off, rates))
            scale = np.sqrt(
                each.measured.independent * (np.ones_like(off) if weights is None else weights)
            )
            residuals.append((scale * off).ravel())
            slopes.append((scale[..., np.newaxis] * rates).reshape(-1, problem.size))
        prior = np.eye(problem.groups, problem.size)
        residuals.append(parameters[: problem.groups])
        return np.concatenate(residuals), np.vstack((*slopes, prior))


class _WithConstants:
    """All residuals with the wheels' constants as parameters, so that a robust loss can weigh each."""

    def __init__(self, problem: Problem) -> None:
        from scipy.linalg import block_diag

        self._problem = problem
        rows, shares = [], []
        for each in problem.observations:
            count, orders = each.measured.amplitude.shape
            parts = 2 if each.phases else 1
            flagged = np.flatnonzero(each.measured.wheel_constant & each.phases)
            block = np.zeros((parts, count, orders, parts, len(flagged)))
            for place, order in enumerate(flagged):
                for part in range(parts):
                    block[part, :, order, part, place] = 1.0 / each.measured.scatter[:, order]
            rows.append(block.reshape(parts * count * orders, -1))
            shares.append(np.full(parts * count * orders, each.measured.independent))
        self._constants = np.asarray(block_diag(*rows))
        # One deviation of a constant is then one of the value known best.
        scale = np.sqrt(np.sum(self._constants**2, axis=0))
        self._constants /= np.where(scale > 0.0, scale, 1.0)
        self._shares = np.concatenate(shares)
        self._data = _LastValues(self._calculated)

    def start(self, parameters: Array) -> Array:
        """Return parameters with the constants that fit best beside them."""
        off, _ = self._data(parameters)
        return np.concatenate((parameters, -self._constants.T @ off))

    def residuals(self, values: Array) -> Array:
        size, groups = self._problem.size, self._problem.groups
        if _too_far(values, self._problem):
            return np.full(self._shares.size + groups, np.inf)
        off, _ = self._data(values[:size])
        return np.concatenate((off + self._constants @ values[size:], values[:groups]))

    def jacobian(self, values: Array) -> Array:
        size, groups = self._problem.size, self._problem.groups
        _, slopes = self._data(values[:size])
        prior = np.eye(groups, size + self._constants.shape[1])
        return np.vstack((np.hstack((slopes, self._constants)), prior))

    def loss(self, squares: Array) -> Array:
        """Soft L1 of measured values, each by its share; the prior stays as it is."""
        made = np.vstack((squares, np.ones_like(squares), np.zeros_like(squares)))
        data = squares[: self._shares.size]
        root = np.sqrt(1.0 + data / OUTLYING**2)
        soft = np.vstack(
            (2.0 * OUTLYING**2 * (root - 1.0), 1.0 / root, -0.5 / OUTLYING**2 / root**3)
        )
        made[:, : data.size] = self._shares * soft
        return made

    def _calculated(self, parameters: Array) -> tuple[Array, Array]:
        problem = self._problem
        compared = [problem.compared(parameters, k) for k in range(len(problem.observations))]
        return (
            np.concatenate([each.residuals.ravel() for each in compared]),
            np.vstack([each.slopes.reshape(-1, problem.size) for each in compared]),
        )


def _judged(problem: Problem, parameters: Array, robust: bool, starts: tuple[float, ...]) -> Fit:
    """Return the fit at parameters with its covariance by a sandwich.

    With slopes J of the values in deviations, the correlation R of their errors, psi of the loss and the
    prior's unit matrix, the covariance is A^-1 (mean psi^2 J' R J + 1) A^-1 with A = mean psi' J' J + 1.
    """
    from scipy.stats import chi2

    residuals, weights, data = [], [], []
    bread, meat = np.zeros((2, problem.size, problem.size))
    psi_slope = square = whole = counted = squares = effective = 0.0
    for number, each in enumerate(problem.observations):
        off, rates = problem.compared(parameters, number)
        kept = np.ones_like(off)
        for _ in range(8 if robust else 1):
            rest = without_constants(each, off, kept)
            if robust:
                kept = 1.0 / np.sqrt(1.0 + (rest / OUTLYING) ** 2)
        rates = without_constants(each, rates)
        parts, count, orders = off.shape
        flat = rates.reshape(parts, count, orders, -1)
        share = each.measured.independent
        bread += share * np.einsum("smkp,smkq->pq", flat, flat, optimize=True)
        beside = np.einsum("mn,snkq->smkq", each.measured.correlation, flat, optimize=True)
        meat += share**2 * np.einsum("smkp,smkq->pq", flat, beside, optimize=True)
        fixed = parts * int(np.sum(each.measured.wheel_constant)) if each.phases else 0
        counted += share * off.size - fixed
        effective += share * off.size
        square += share * float(np.sum(rest**2))
        scaled = each.measured.amplitude / each.measured.scatter
        seen = np.stack((scaled.real, scaled.imag)) if each.phases else np.abs(scaled)[np.newaxis]
        whole += share * float(np.sum(without_constants(each, seen) ** 2))
        squares += share * float(np.sum((kept * rest) ** 2))
        psi_slope += share * float(np.sum(kept**3 if robust else kept))
        residuals.append(rest)
        weights.append(kept)
        data.append(np.sqrt(share) * rates.reshape(-1, problem.size))
    prior = np.zeros((problem.size, problem.size))
    prior[: problem.groups, : problem.groups] = np.eye(problem.groups)
    # Each parameter that the data determine takes one value of the residuals.
    strengths = np.linalg.eigvalsh(bread + prior)
    used = float(np.sum(np.clip(1.0 - 1.0 / np.maximum(strengths, 1.0), 0.0, 1.0)))
    free = max(counted - used, 1.0)
    slope, spread = psi_slope / effective, squares / free
    usual_slope, usual = _usual(robust)
    pairs = zip(problem.observations, residuals, strict=True)
    middle = np.median(np.concatenate([_of_one_size(*pair) ** 2 for pair in pairs]))
    misfit = float(middle / chi2.ppf(0.5, 1)) * max(counted, 1.0) / free
    limit = float(chi2.ppf(0.99, MEDIAN_KNOWS * free) / (MEDIAN_KNOWS * free))
    if free < ENOUGH_TO_JUDGE:
        slope, spread = usual_slope, usual * (misfit if misfit > limit else 1.0)
    inverse = np.linalg.inv(slope * bread + prior)
    covariance = inverse @ (spread * meat + prior) @ inverse
    return Fit(
        problem=problem,
        parameters=parameters,
        covariance=0.5 * (covariance + covariance.T),
        data=np.vstack(data),
        misfit=misfit,
        limit=limit,
        effective=effective,
        explained=1.0 - square / whole,
        starts=starts,
        residuals=tuple(residuals),
        weights=tuple(weights),
    )


def _of_one_size(each: Observation, rest: Array) -> Array:
    """Return residuals of the variance that those of all orders have, although constants took their part."""
    flagged, count = each.measured.wheel_constant & each.phases, each.measured.speed.size
    if count == 1:  # its constants take all of it
        return np.asarray(rest[:, :, ~flagged].ravel()) if not np.all(flagged) else np.zeros(1)
    return np.asarray((rest * np.where(flagged, np.sqrt(count / (count - 1.0)), 1.0)).ravel())


def _usual(robust: bool) -> tuple[float, float]:
    """Return the mean slope of psi and of its square for normal errors of deviation 1."""
    if not robust:
        return 1.0, 1.0
    points, weights = np.polynomial.hermite_e.hermegauss(60)
    kept = 1.0 / np.sqrt(1.0 + (points / OUTLYING) ** 2)
    weights = weights / np.sum(weights)
    return float(weights @ kept**3), float(weights @ (kept * points) ** 2)


def profile(solved: Fit, number: int) -> tuple[float, float]:
    """Return the 95 % interval of a group's factor by profile likelihood.

    The cost, with the outliers' weights as fitted, is minimized over all other parameters; it ends where it
    has grown by as much as the covariance says of a quadratic one.
    """
    from scipy.optimize import least_squares

    problem = solved.problem
    rows = Rows(problem, solved.weights)
    at = solved.parameters
    slopes = rows.jacobian(at)
    inverse = np.linalg.inv(slopes.T @ slopes)
    least = float(np.sum(rows.residuals(at) ** 2))
    width = NORMAL95 * float(np.sqrt(solved.covariance[number, number]))
    target = width / float(np.sqrt(inverse[number, number]))
    others = np.arange(problem.size) != number
    along = inverse[:, number] / inverse[number, number]

    def grown(value: float, others: Array) -> float:
        moved = at + along * (value - at[number])

        def full(some: Array) -> Array:
            made: Array = moved.copy()
            made[others] = some
            return made

        def off(some: Array) -> Array:
            return np.asarray(rows.residuals(full(some)))

        def slopes_of(some: Array) -> Array:
            return np.asarray(rows.jacobian(full(some))[:, others])

        end = least_squares(
            off,
            moved[others],
            slopes_of,
            x_scale="jac",
            ftol=1e-5,
            max_nfev=10,
        )
        return float(np.sqrt(max(2.0 * end.cost - least, 0.0)))

    spread = problem.shaft.groups[number].deviation
    ends = []
    for side in (-1.0, 1.0):
        reach = width
        for _ in range(PROFILE_STEPS):
            size = grown(float(at[number]) + side * reach, others)
            if abs(size - target) <= END_MET * target or size == 0.0:
                break
            reach *= float(np.clip(target / size, 0.5, 2.0))
        ends.append(float(np.exp(spread * (at[number] + side * reach))))
    return ends[0], ends[1]
