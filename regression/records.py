"""Records of a study: results of its designs, and imported rows."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field

# Roles of rows: fitted, judged by, only compared with.
RUN, HELD_OUT, MEASURED = "run", "held out", "measured"


class StudyStoppedError(RuntimeError):
    """A study cannot go on, though nothing is wrong with its input; finished designs are kept.

    The message is one sentence that says why.
    """


@dataclass(frozen=True)
class Outcome:
    """What became of one design: its responses, or the reason why it has none.

    Attributes
    ----------
    key : str
        Of the design.
    inputs : mapping
        JSON content, SI units.
    responses : mapping or None
        Response name to SI value; None where the design has none.
    reason : str or None
        Why it has none.
    seconds : float
        That it took.
    lost : bool
        Whether its worker died or was ended, which says nothing about the design: a later run tries
        it again.
    errors : mapping
        Response name to estimated relative error.
    unknowns : int or None
        Of the mesh.
    worker : str
        Machine and process that computed it.
    attempts : int
        How often it was tried in the run that recorded it.
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

    @property
    def status(self) -> str:
        """Return "done", "failed" or "lost"."""
        if self.responses is not None:
            return "done"
        return "lost" if self.lost else "failed"


@dataclass(frozen=True)
class ExtraRow:
    """A row of a study that was not computed by it: an earlier result, or a measured throw.

    Attributes
    ----------
    role : str
        "run" and "held out" rows stand beside the study's own, "measured" ones are only compared.
    dimensions : mapping
        Numeric field of the throw to SI value; of its parts ("counterweight.thickness") those that
        the row itself gives.
    outlines : mapping
        Field of the throw that holds a word to that word.
    values : tuple of float or None
        Values of the study's factors, in its order; None for a measured throw that has no such.
    responses : mapping
        Response name to SI value.
    errors : mapping
        Response name to estimated relative error, where known.
    source : str
        Where the row comes from.
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
