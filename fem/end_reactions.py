"""Reactions of the supports on a throw: forces and moments on its end sections."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.summaries import summarized
from fem.throw_frames import load_table

Array = NDArray[np.float64]

# [N, N m] Far beyond any real load, far below what overflows.
LARGEST_LOAD = 1e30


@summarized("force [N]", "moment [N m]")
@dataclass(frozen=True)
class EndReaction:
    """Force [N] and moment [N m] on one end section, each (3,), in the throw frame."""

    force: Array
    moment: Array


@summarized(
    "left force: left.force [N]",
    "left moment: left.moment [N m]",
    "right force: right.force [N]",
    "right moment: right.moment [N m]",
)
@dataclass(frozen=True)
class Reactions:
    """What supports (and under `Neighbors` the adjoining throws) exert on a throw's end sections."""

    left: EndReaction
    right: EndReaction

    def to_pandas(self) -> Any:
        """Return a table of forces and moments Fx to Mz at the left and the right end.

        Returns
        -------
        pandas.DataFrame
            Units are in ``frame.attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        ends = {"left": self.left, "right": self.right}
        return load_table(
            {name: np.concatenate([one.force, one.moment]) for name, one in ends.items()}
        )
