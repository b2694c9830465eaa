"""A range of speeds in which limits are exceeded, and whether running through it can be accepted."""

from dataclasses import dataclass
from typing import Literal

from crankbase.summaries import summarized
from crankbase.tables.frames import Row
from dynamics.assessment.limit_sentences import shown_range

Position = Literal["below", "running", "above"]


@summarized("low [rad/s]", "high [rad/s]", "allowed", "position", "peaks", "limits")
@dataclass(frozen=True)
class BarredRange:
    """A range of speeds to be passed quickly, or a proposal that cannot be accepted.

    Parameters
    ----------
    low, high : float
        [rad/s].
    peaks : tuple of float
        Speeds of the largest vibration in it, or of which it is a flank [rad/s].
    limits : tuple of str
        Names of the limits exceeded in it.
    refusals : tuple of str
        Why running through it cannot be accepted; none if it can.
    remarks : tuple of str
        What is not known of it.
    position : {"running", "below", "above"}
        Whether it has running speeds, or lies as a whole below them, so that every start passes it, or
        above them, where nothing runs and nothing can be barred, but a limit still applies.
    ends : str
        Where the range's ends come from: at which speeds and places limits are exceeded, and the rule
        that widens the range about peaks.
    full_load : bool
        Whether it lies below the running speeds and was calculated at full load, so that it is not judged.
    """

    low: float
    high: float
    peaks: tuple[float, ...]
    limits: tuple[str, ...]
    refusals: tuple[str, ...]
    remarks: tuple[str, ...]
    position: Position = "running"
    ends: str = ""
    full_load: bool = False

    @property
    def allowed(self) -> bool:
        """Whether it may be barred, or passed on starting."""
        return not self.refusals

    @property
    def shown(self) -> str:
        """Such as "700 to 800 1/min"."""
        return shown_range(self.low, self.high)

    @property
    def sentence(self) -> str:
        """Whether it may be barred or passed, and why not; without its full stop."""
        why = f": {'; '.join(self.refusals)}" if self.refusals else ""
        if self.position == "above":
            return f"{self.shown}, above the running range{why}"
        if self.full_load:
            return (
                f"{self.shown} is passed on every start, without the full load of this calculation, so it "
                "is not judged"
            )
        if self.position == "below":
            return f"{self.shown} is passed on every start{', too severely' if why else ''}{why}"
        return f"{self.shown} {'cannot' if why else 'may'} be barred{why}"

    def row(self) -> Row:
        """Return what a table of ranges shows, each value with its unit; see `table_of`."""
        return {
            "low": (self.low, "rad/s"),
            "high": (self.high, "rad/s"),
            "position": (self.position, ""),
            "allowed": (self.allowed, ""),
            "limits": (", ".join(self.limits), ""),
            "refusals": ("; ".join(self.refusals), ""),
            "remarks": ("; ".join(self.remarks), ""),
        }
