"""Intervals of a fit by samples of its posterior, for which the package emcee is needed."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import MissingLibraryError
from crankbase.results import Internal, Number, Result, result
from crankfem.satellites.measured.calibration.fit import SEED, Fit, Rows

# Walkers, at least two for each parameter, and steps of a round; the first round is left out.
WALKERS, ROUND, MOST_ROUNDS = 20, 50, 40
# Steps over the autocorrelation time from which that itself is sure.
ENOUGH = 50.0
# Most steps are drawn anew from a t distribution about the fit, the others stretch between walkers.
ANEW, FREEDOM = 0.7, 5.0
TAIL = 0.025
# Standard error of the end of a normal 95 % interval from N draws, times the root of N, over its half width:
# sqrt(0.025 x 0.975) / 0.0584 / 1.96.
ERROR_OF_END = 1.363


@result("independent", "error", "converged")
class Samples(Result):
    """Draws from the posterior of a fit.

    Attributes
    ----------
    independent : float
        Number of independent draws that they are worth, by the autocorrelation time of the parameter that
        moves slowest.
    error : float
        Standard error of the end of a 95 % interval over its half width.
    converged : bool
        Whether each walker went so far that the autocorrelation time, and with it the intervals, are sure.
    parameters : ndarray of shape (N, P)
        The draws, as `Problem` says.
    """

    independent: Number
    error: Number
    converged: bool
    parameters: Internal[Array | None] = None

    def interval(self, solved: Fit, number: int) -> tuple[float, float]:
        """Return the ends of the 95 % interval of a group's factor, with as many draws below as above."""
        assert self.parameters is not None
        spread = solved.problem.shaft.groups[number].deviation
        low, high = np.exp(spread * np.quantile(self.parameters[:, number], (TAIL, 1.0 - TAIL)))
        return float(low), float(high)


def check_sampler() -> None:
    """Raise MissingLibraryError if emcee is not installed."""
    if find_spec("emcee") is None:
        raise MissingLibraryError(
            "Samples need the package emcee: pip install 'crankfem[sampling]'."
        )


def sampled(solved: Fit, *, seed: int = SEED, step: Callable[[str], None] | None = None) -> Samples:
    """Sample the posterior of a fit.

    The likelihood is that of all values, not linear, with their outliers' weights as fitted and the wheels'
    constants integrated out; the prior is that of the groups. The windows' correlation, the weights and the
    noise found then widen the samples about the fit, as they do the covariance.

    Parameters
    ----------
    seed : int, optional
        Of the draws.
    step : callable, optional
        Called with the name of each step.

    Raises
    ------
    MissingLibraryError
        If emcee is not installed.
    """
    check_sampler()
    import emcee

    rows, best = Rows(solved.problem, solved.weights), solved.parameters
    slopes, size = rows.jacobian(best), solved.problem.size
    # Parameters are `best` + `out` u; about the fit u is normal. Of constants of wheels that are linear and
    # have fixed weights, the least squares are those of the marginal distribution.
    root = np.linalg.cholesky(slopes.T @ slopes)
    out = np.linalg.inv(root).T

    def log_density(u: Array) -> float:
        return -0.5 * float(np.sum(rows.residuals(best + out @ u) ** 2))

    def log_proposed(u: Array) -> Array:
        return np.asarray(-0.5 * (FREEDOM + size) * np.log1p(np.sum(u**2, axis=1) / FREEDOM))

    def anew(u: Array, random: Any) -> tuple[Array, Array]:
        scale = np.sqrt(FREEDOM / random.chisquare(FREEDOM, size=(len(u), 1)))
        drawn = scale * random.normal(size=u.shape)
        return drawn, log_proposed(u) - log_proposed(drawn)

    walkers = max(WALKERS, 2 * size + 2)
    moves = [(emcee.moves.MHMove(anew), ANEW), (emcee.moves.StretchMove(), 1.0 - ANEW)]
    sampler = emcee.EnsembleSampler(walkers, size, log_density, moves=moves)
    sampler.random_state = np.random.MT19937(seed).state
    state: Any = np.random.default_rng(seed).normal(size=(walkers, size))
    time = np.inf
    for number in range(MOST_ROUNDS):
        if step is not None:
            step(f"Sampling: {number * ROUND} steps")
        state = sampler.run_mcmc(state, ROUND)
        if number == 0:
            sampler.reset()
            continue
        time = float(np.max(sampler.get_autocorr_time(tol=0)))
        if sampler.iteration >= ENOUGH * time:
            break
    # The symmetric map by which draws about the fit get its covariance.
    values, vectors = np.linalg.eigh(root.T @ solved.covariance @ root)
    widened = (sampler.get_chain(flat=True) @ vectors * np.sqrt(values)) @ vectors.T
    independent = len(widened) / time
    return Samples(
        independent=independent,
        error=float(ERROR_OF_END / np.sqrt(independent)),
        converged=bool(sampler.iteration >= ENOUGH * time),
        parameters=best + widened @ out.T,
    )
