"""The choice of a design of experiments, with its parameters."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

# A study of more finite element runs than this is a slip of the pen, and planning it takes long.
LARGEST_DESIGN = 20_000

DesignKind = Literal[
    "full factorial",
    "fractional factorial",
    "central composite",
    "box-behnken",
    "latin hypercube",
    "sobol",
    "file",
]
SPACE_FILLING = ("latin hypercube", "sobol")
# What some designs take beside the factors, and which.
TAKERS: Mapping[str, tuple[str, ...]] = {
    "runs": SPACE_FILLING,
    "resolution": ("fractional factorial", "central composite"),
    "generators": ("fractional factorial",),
    "face": ("central composite",),
    "file": ("file",),
}


@dataclass(frozen=True)
class DesignChoice:
    """A design of experiments with its parameters.

    Parameters
    ----------
    kind : str
        As in `DesignKind`.
    runs : int, optional
        Number of runs of a Latin hypercube or a Sobol sequence, at most `LARGEST_DESIGN`.
    resolution : int, optional
        Of a fractional factorial (4 if neither it nor generators are given), or of the fraction of a
        central composite design's corners (all corners by default); 3 to 8.
    generators : str, optional
        Of a fractional factorial, instead of a resolution: "a b c abc".
    face : str, optional
        Of a central composite design: "faced" (default), "inscribed" or "circumscribed".
    rows : tuple of tuple of float, optional
        Runs of the design "file" [SI], one value for each factor.
    """

    kind: str = "full factorial"
    runs: int | None = None
    resolution: int | None = None
    generators: str | None = None
    face: str | None = None
    rows: tuple[tuple[float, ...], ...] | None = None
