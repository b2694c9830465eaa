"""Records of a study: results of its designs, and imported rows."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

# Roles of rows: fitted, judged by, only compared with.
RUN, HELD_OUT, MEASURED = "run", "held out", "measured"
# Among the inputs of designs whose slopes are computed: the dimensions over which.
SLOPES = "slopes"
# Among the inputs of designs whose mesh is that of another throw, moved: which throw, and over which
# dimensions.
MOVED = "moved"
# How a mesh was made that was to be moved and could not be.
MESHED = "new"


class StudyStoppedError(RuntimeError):
    """A study cannot continue, though nothing is wrong with its input; finished designs are kept.

    The message is one sentence with the reason.
    """


@dataclass(frozen=True)
class Outcome:
    """Outcome of one design: its responses [SI], or the reason why it has none.

    Attributes
    ----------
    inputs : mapping
        JSON content, SI units.
    seconds : float
        Time of the calculation [s].
    lost : bool
        Whether its worker died or was ended, which is no property of the design: a later run tries it again.
    errors : mapping
        Response name to estimated relative error.
    unknowns : int or None
        Of the mesh.
    worker : str
        Machine and process that computed it.
    attempts : int
        Number of attempts in the run that recorded it.
    slopes, slope_errors : mapping
        As of `fem.responses.ThrowResponses`, if the inputs ask for any.
    mesh : mapping
        If the inputs ask for a moved mesh: how it was made, ``tier``; of one that was moved also its
        ``quality``, the ``straightened`` elements, the ``reference``, a hash of the mesh that was moved, and
        ``discrete``: the answers without their correction, by response.
    """

    key: str
    inputs: Mapping[str, object]
    responses: Mapping[str, float] | None
    reason: str | None
    seconds: float
    lost: bool = False
    errors: Mapping[str, float] = field(default_factory=dict)
    unknowns: int | None = None
    worker: str = ""
    attempts: int = 1
    slopes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    slope_errors: Mapping[str, float] = field(default_factory=dict)
    mesh: Mapping[str, Any] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """Return "done", "failed" or "lost"."""
        if self.responses is not None:
            return "done"
        return "lost" if self.lost else "failed"


@dataclass(frozen=True)
class ExtraRow:
    """A row of a study that it did not compute: an earlier result, or a measured throw.

    Attributes
    ----------
    role : str
        "run" and "held out" rows are used like the study's own, "measured" ones are only compared.
    dimensions, outlines : mapping
        Numeric fields [SI] and text fields of the throw; of its parts those given.
    values : tuple of float or None
        Of the study's factors, in its order; None for a measured throw without them.
    responses, errors : mapping
        Response name to SI value, and to its estimated relative error, where known.
    source : str
        Origin of the row.
    """

    role: str
    dimensions: Mapping[str, float]
    outlines: Mapping[str, str]
    values: tuple[float, ...] | None
    responses: Mapping[str, float]
    errors: Mapping[str, float]
    source: str


def content_key(content: object) -> str:
    """Hash any JSON content, independent of the order of its keys."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:24]
