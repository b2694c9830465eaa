"""A Gaussian process through few throws of many ratios, that teaches the law's networks between them.

All answers share one Matern kernel of degree 5/2 with a length for each input, beside straight lines, found
by their likelihood (C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning, 2006, 5.4).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve
from scipy.optimize import minimize

Array = NDArray[np.float64]
LINES = 9.0  # variance of the straight lines, in that of the answers
BOUNDS = [(0.1, 100.0), (1e-3, 50.0), (2e-4, 0.1)]  # lengths, size, noise


class Process:
    """A process fitted to answers (n, k) at inputs (n, d) between -1 and 1, or with a known kernel.

    `left` (n, k) are the errors that it would have without each throw in turn.
    """

    def __init__(self, x: Array, y: Array, steps: int = 25, logs: Array | None = None) -> None:
        self.x = x
        self.mean, self.scale = y.mean(axis=0), y.std(axis=0)
        self.y = (y - self.mean) / self.scale
        self.lines = LINES * self._straight(x) @ self._straight(x).T
        self.logs = self._likeliest(steps) if logs is None else logs
        self._unlikeliness(self.logs)
        self.left = self.scale * self.weights / self.alone[:, None]

    def _likeliest(self, steps: int) -> Array:
        size = self.x.shape[1]
        found = minimize(
            self._unlikeliness,
            np.log([*np.full(size, 10.0), 2.0, 1e-2]),
            jac=True,
            method="L-BFGS-B",
            bounds=np.log([BOUNDS[0]] * size + BOUNDS[1:]),
            options={"maxiter": steps},
        )
        return np.asarray(found.x)

    @staticmethod
    def _straight(x: Array) -> Array:
        return np.column_stack([np.ones(len(x)), x])

    @staticmethod
    def _distances(one: Array, other: Array) -> Array:
        square = (one**2).sum(1)[:, None] + (other**2).sum(1) - 2.0 * one @ other.T
        return np.sqrt(5.0 * np.maximum(square, 0.0) + 1e-18)

    def _unlikeliness(self, logs: Array) -> tuple[float, Array]:
        """Negative logarithm of the answers' likelihood, and its slopes over the kernel's logarithms."""
        *lengths, size, noise = np.exp(logs)
        scaled = self.x / lengths
        far = self._distances(scaled, scaled)
        near = size**2 * np.exp(-far)
        kernel = near * (1.0 + far + far**2 / 3.0)
        whole = kernel + self.lines
        whole[np.diag_indices_from(whole)] += noise**2
        root = np.linalg.cholesky(whole)
        inverse = cho_solve((root, True), np.eye(len(whole)))
        self.weights, self.alone = inverse @ self.y, np.diag(inverse)
        answers = self.y.shape[1]
        value = 0.5 * np.sum(self.y * self.weights) + answers * np.log(np.diag(root)).sum()
        pull = self.weights @ self.weights.T - answers * inverse
        by_square = pull * near * (5.0 / 3.0) * (1.0 + far)
        rows = by_square.sum(axis=1)
        slopes = [-(rows @ z**2 - z @ by_square @ z) for z in scaled.T]
        slopes += [-np.sum(pull * kernel), -(noise**2) * np.trace(pull)]
        return float(value), np.array(slopes)

    def values(self, x: Array) -> Array:
        """Answers (m, k) at inputs (m, d)."""
        *lengths, size, _ = np.exp(self.logs)
        far = self._distances(x / lengths, self.x / lengths)
        kernel = size**2 * np.exp(-far) * (1.0 + far + far**2 / 3.0)
        kernel += LINES * self._straight(x) @ self._straight(self.x).T
        return np.asarray(self.mean + self.scale * (kernel @ self.weights))
