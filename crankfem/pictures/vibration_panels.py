"""Single panels of an engine's vibration, each drawn on the axes it is given."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from crankfem.vibration.motion import MOTION
from dynamics.checks import FloatArray
from dynamics.plots.mode_shapes import draw_chain_shapes
from dynamics.plots.quantities import RPM
from geometry.diagram_style import BLUE
from geometry.plots.bars import draw_rows
from geometry.plots.legends import legend_inside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from crankfem.vibration.assessment import Assessment, Uncertainty
    from crankfem.vibration.forced import ForcedVibration
    from crankfem.vibration.modes import SourceResult, Vibration, WeightedCritical

SHAPES_SHOWN = 3


def draw_modes(axes: "Axes", result: "SourceResult", count: int = SHAPES_SHOWN) -> None:
    """Draw the first elastic mode shapes of a chain over its nodes."""
    modes = result.modes
    shown = slice(modes.rigid, min(modes.rigid + count, len(modes.frequencies)))
    positions = modes.node_positions[shown]
    labels = [
        f"{frequency:.1f} Hz, {len(still)} node{'s' if len(still) != 1 else ''}"
        for frequency, still in zip(modes.frequencies[shown], positions, strict=True)
    ]
    draw_chain_shapes(
        axes,
        modes.shapes[:, shown],
        labels,
        positions,
        result.chain.chain.connections,
        [short_name(name) for name in result.chain.nodes],
        MOTION[result.chain.kind].quantity,
    )


def draw_sources(axes: "Axes", results: Sequence["SourceResult"], chosen: str) -> None:
    """Draw the first elastic frequency by each source of compliances, the chosen one marked."""
    names = [f"{one.source} (chosen)" if one.source == chosen else one.source for one in results]
    first = [float(one.elastic_frequencies[0]) for one in results]
    draw_rows(axes, names, first, "first elastic natural frequency [Hz]")


def draw_bounds(axes: "Axes", found: "Uncertainty") -> None:
    """Draw each elastic frequency with its bounds, as a share of the nominal one."""
    numbers = np.arange(1, len(found.nominal) + 1)
    low, high = (100.0 * (ends / found.nominal - 1.0) for ends in (found.lowest, found.highest))
    axes.vlines(numbers, low, high, color=BLUE, linewidth=2.0, label="bounds")
    for ends in (low, high):
        axes.plot(numbers, ends, "_", color=BLUE, markersize=12)
    axes.plot(numbers, np.zeros(len(numbers)), "o", color=BLUE, label="nominal")
    legend_inside(axes)
    for number, frequency in zip(numbers.tolist(), found.nominal.tolist(), strict=True):
        text = f"{frequency:.1f} Hz"
        axes.annotate(text, (number, 0.0), xytext=(5, 3), textcoords="offset points", fontsize=8)
    axes.set_xticks(numbers)
    axes.margins(x=0.12)
    axes.set_xlabel("elastic mode")
    axes.set_ylabel("natural frequency beside the nominal one [%]")


def short_name(name: str) -> str:
    """Shorten a node's name to what fits under an axis."""
    return (
        name.replace("cylinder ", "cyl. ")
        .replace("section ", "")
        .replace(", flywheel", "\nflywheel")
        .replace(", thrust bearing", "\nthrust")
        .replace("driven machine", "driven\nmachine")
        .replace("damper ring", "damper\nring")
    )


def barred_ranges(assessment: "Assessment | None") -> list[tuple[float, float]]:
    """Return the speed ranges that may be barred, whatever limit asks for them [rad/s]."""
    if assessment is None:
        return []
    return [(one.low, one.high) for one in assessment.verdict.barred if one.allowed]


def limit_curve(
    assessment: "Assessment | None", forced: "ForcedVibration", name: str
) -> dict[str, FloatArray]:
    """Return a limit over the speeds by the name it has in a legend, if there is one."""
    limit = None if assessment is None else assessment.limits.get(name)
    return {} if limit is None else {"limit": limit.continuous.at(forced.response.speeds)}


def most_stressed(forced: "ForcedVibration") -> int:
    """Return the crankshaft's element with the largest stress."""
    assert forced.stress is not None
    return int(np.argmax(np.max(forced.stress.synthesis.amplitude, axis=0)))


def free_end_title(engine: str, kind: str) -> str:
    """Say of what the free end's amplitudes are."""
    return f"{engine}, {kind} vibration of the free end"


def stress_title(engine: str) -> str:
    """Say of what stresses over the speed are."""
    return f"{engine}, nominal torsional stress"


@dataclass(frozen=True)
class CriticalDot:
    """A critical speed as a Campbell diagram draws it, its size by its phase sum."""

    frequency: float
    speed_rpm: float
    severity: float
    kind: str = "major"
    unbounded: bool = False


def critical_dots(vibration: "Vibration", majors: FloatArray) -> list[CriticalDot]:
    """Return the dots of the critical speeds of free vibration."""

    def dot(one: "WeightedCritical") -> CriticalDot:
        kind = "major" if np.any(np.isclose(one.critical.order, majors)) else "minor"
        speed = one.critical.speed * RPM
        return CriticalDot(one.critical.frequency, speed, one.phase_sum, kind)

    return [dot(one) for one in vibration.criticals]
