"""Measured orders over those calculated of an engine, at the place where they were measured."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from crankbase.array_checks import ComplexArray
from crankbase.diagrams import (
    ALL_ORDERS,
    Diagram,
    Dots,
    Limits,
    Line,
    display_unit,
    draw_diagram,
    legend_below,
    new_axes,
    order_line_style,
    write_title,
)
from crankbase.errors import InputError
from crankbase.frames import Axes
from crankbase.outputs import write_text
from crankbase.quantity import RPM
from crankbase.results import InItsUnit, Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import amount, finished, kept
from crankbase.table import SI, Column, OutputUnits, Table
from crankfem.analyses.shaft.chains import magnifier_damping
from crankfem.analyses.vibration.forced import ForcedVibration
from crankfem.analyses.vibration.run import EngineVibration, engine_vibration
from crankfem.files.engine.engine_file import EngineFile
from crankfem.report.interactive.plot import LEGEND_COLUMNS, picture
from crankfem.report.interactive.style import diagram_figure
from crankfem.satellites.measured.measured_orders import (
    PRINTED_UNITS,
    MeasuredOrders,
    agreeing_angle,
    largest_lag,
)
from crankfem.satellites.measured.order_fits import Samples, fit_along
from dynamics.indices import index_of_name
from dynamics.response.forced import ForcedResponse, forced_response
from dynamics.response.loads import elastic_loads
from dynamics.response.order_excitation import OrderExcitation
from dynamics.response.series import synthesis

# A steady response is off by this at a peak that is passed as quickly; above the second value it is refused.
STEADY_ERROR, MOST_RAMP_ERROR = 0.02, 0.5
# Ramps are those of one run-up if they agree within this.
EVEN_RAMP = 0.2
# Constants of a wheel are chosen from speeds that differ by this factor at least.
CONSTANT_RANGE = 1.05
# Peaks further apart than this are those of another shaft; an overlay with more left is no fit.
SAME_PEAK, NO_FIT = 0.05, 1.0
# Firing orders drawn to see whether others fit better, at so many speeds at most; of an engine's record fewer
# than this share do (of simulated ones at one speed 80 of 84, with resonances up to 5 % off; of those of
# another firing order 2 of 28). More than so many times what scatter alone leaves is not explained by it.
FIRING_ORDERS, FIRING_SPEEDS, FIT_BETTER, FAR_ABOVE = 100, 12, 0.05, 3.0
# Orders drawn, and those in the table, by their amplitude; angles of the mark that are tried.
DRAWN, LISTED, MARK_ANGLES = 6, 8, 2880


@result("order", "measured", "measured_at", "calculated", "calculated_at", eq=True)
class OrderPair(Result):
    """The largest amplitude of one order, measured and calculated, at the speeds measured."""

    order: Number
    measured: InItsUnit
    measured_at: Speed
    scatter: InItsUnit
    calculated: InItsUnit
    calculated_at: Speed
    unit: str


@result("engine", "by", "difference")
class Overlay(Result):
    """Measured and calculated orders at the same place and speeds.

    Attributes
    ----------
    measured : MeasuredOrders
        Those that are calculated too, at the speeds calculated; with the angle zero of the engine file, and
        without the constants of the wheel, which are chosen to agree; at one speed half orders alone.
    calculated : ndarray of shape (m, k), complex
    by : {"steady", "run-up"}
        Of the calculated ones.
    ramp_error : float
        By which a steady response would be off at the quickest passage of a peak, n dw/dt / (z w)^2.
    difference : float
        Root mean square of what is left, of that measured, with or without constants, whichever is less.
    pairs : tuple of OrderPair
    notes : tuple of str
    by_scatter : float
        Root mean square that the scatter alone would leave, of that measured.
    better : float or None
        Share of other firing orders with which less is left; None where it is not known, as in a run-up.
    """

    engine: str
    place: str
    measured: Internal[MeasuredOrders]
    calculated: Internal[ComplexArray]
    by: Literal["steady", "run-up"]
    ramp_error: Number
    difference: Number
    pairs: tuple[OrderPair, ...]
    notes: tuple[str, ...]
    by_scatter: Number = 0.0
    better: Annotated[float | None, Quantity("1")] = None

    @property
    def conclusion(self) -> Annotated[str, Quantity(key="conclusion")]:
        """What the comparison says, by its main peaks."""
        first = self.pairs[0]
        unit = first.unit
        largest = (
            f"Order {first.order:g}: measured {amount(first.measured, unit, 3)} at "
            f"{amount(first.measured_at, 'rad/s', 4)}, calculated {amount(first.calculated, unit, 3)} at "
            f"{amount(first.calculated_at, 'rad/s', 4)}"
        )
        left = (
            f"{100.0 * self.difference:.3g} % of all orders compared is left between them, where scatter "
            f"alone leaves {100.0 * self.by_scatter:.2g} %"
        )
        return finished(f"{largest}; {left}.")

    @cached_property
    def doubt(self) -> Annotated[str, Quantity(key="doubt")]:
        """What does not fit, as one sentence; empty if all does."""
        low, high = float(self.measured.speed.min()), float(self.measured.speed.max())
        inner = [
            pair
            for pair in self.pairs[:LISTED]
            if all(1.02 * low < at < 0.98 * high for at in (pair.measured_at, pair.calculated_at))
        ]
        if inner:
            shift = float(np.median([p.measured_at / p.calculated_at - 1.0 for p in inner]))
            if abs(shift) > SAME_PEAK:
                return (
                    f"The measured peaks are {100.0 * abs(shift):.2g} % "
                    f"{'above' if shift > 0.0 else 'below'} the calculated ones in speed: another shaft, "
                    "another engine, or a stiffness or inertia that is off by twice as much."
                )
        if self.difference > NO_FIT:
            return "More is left than was measured: another place, angle zero, firing order, unit or engine."
        if self.better is not None and self.better > FIT_BETTER:
            return (
                f"With {100.0 * self.better:.2g} % of other firing orders less is left: the record may be "
                "another engine's, or firing order, angle of the mark, place or a resonance are others."
            )
        if high < CONSTANT_RANGE * low and self.difference > FAR_ABOVE * self.by_scatter:
            return (
                f"Of the measured squares {100.0 * self.difference**2:.2g} % are not explained, by scatter "
                f"{100.0 * self.by_scatter**2:.1g} %: at one speed another engine cannot be told from other "
                "damping or stiffness; a record over the speeds could tell it."
            )
        return ""

    def diagram(self) -> Diagram:
        """Describe amplitudes over the speed: the main orders, and all orders together."""
        name, size = display_unit(self.measured.unit)
        order = np.argsort(self.measured.speed)
        speed = RPM * self.measured.speed[order]
        lines, dots = [], []
        sensed, calculated = self.measured.amplitude[order], self.calculated[order]
        for number, pair in enumerate(self.pairs[:DRAWN]):
            color = order_line_style(number).color
            place = int(np.argmin(np.abs(self.measured.orders - pair.order)))
            group = f"{pair.order:g}"
            lines.append(
                Line(
                    speed, np.abs(calculated[:, place]) / size, f"order {group}", color, group=group
                )
            )
            dots.append(
                Dots(
                    speed,
                    np.abs(sensed[:, place]) / size,
                    f"order {group} measured",
                    color,
                    group=group,
                )
            )
        speeds, orders = self.measured.speed[order], self.measured.orders
        together = [
            synthesis(orders, speeds, values.T).amplitude / size for values in (calculated, sensed)
        ]
        lines.append(Line(speed, together[0], "all", ALL_ORDERS, width=2.0))
        dots.append(Dots(speed, together[1], "all measured", ALL_ORDERS, "X"))
        ends = float(speed[0]), float(speed[-1])
        return Diagram(
            Limits("speed [1/min]", ends if ends[1] > ends[0] else None),
            Limits(f"amplitude at {self.place} [{name}]", (0.0, None)),
            lines,
            dots,
        )

    @property
    def title(self) -> str:
        """Of a diagram."""
        return f"{self.engine}: orders at {self.place}, measured (dots) and calculated (lines)"

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw amplitudes over the speed: the main orders and all together, calculated and measured."""
        axes = new_axes(axes)
        draw_diagram(axes, self.diagram())
        legend_below(axes, LEGEND_COLUMNS)
        write_title(axes, self.title)
        return axes

    def draw(self, path: Path) -> None:
        """Draw it into a file, an SVG."""
        picture(lambda axes, _: self.plot(axes), lambda _: self.title, 5.0)(path, self)

    def write_page(self, path: Path) -> None:
        """Write it as a page of its own, whose curves can be switched and magnified."""
        from plotly.io import to_html

        traces, layout = diagram_figure(self.diagram(), self.title, 600)
        figure = {"data": traces, "layout": layout}
        write_text(path, to_html(figure, config={"displaylogo": False}), "report")

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return the table of peaks, what does not fit, and remarks."""
        unit = PRINTED_UNITS[self.measured.unit]
        yield Table.of_records(
            f"{self.engine}: largest orders at {self.place}, measured and calculated "
            f"({'in the same run-up' if self.by == 'run-up' else 'at steady speeds'})",
            self.pairs,
            (Column("order", digits=None), "order"),
            (Column("measured", unit, 3), "measured"),
            (Column("scatter", unit, 2), "scatter"),
            (Column("at", "1/min", decimals=0), "measured_at"),
            (Column("calculated", unit, 3), "calculated"),
            (Column("at", "1/min", decimals=0), "calculated_at"),
            weight=lambda pair: pair.measured,
            main=True,
        )
        yield from (units.written(f"Note: {kept(note)}") for note in self.notes)


def overlay(
    measured: MeasuredOrders,
    engine: str | Path | EngineFile | EngineVibration,
    step: Callable[[str], None] | None = None,
) -> Overlay:
    """Compare measured orders with those of an engine, at the place measured.

    Parameters
    ----------
    measured : MeasuredOrders
        Their `place` is a mass or an element of the engine's chain; the free end if it is empty.
    engine : path, EngineFile or EngineVibration
    step : callable, optional
        Called with the name of each step.

    Raises
    ------
    InputError
        If the place is not in the chain, no order or speed is calculated, or the speed rises too quickly for
        a steady response and unevenly.
    """
    run = engine if isinstance(engine, EngineVibration) else engine_vibration(engine, step=step)
    forced = _forced_of(run, measured)
    place, index = _place(measured, forced)
    response = forced.response
    known = np.isin(measured.orders, response.orders)
    low, high = float(response.speeds[0]), float(response.speeds[-1])
    rows = (measured.speed >= low) & (measured.speed <= high)
    if not np.any(known) or not np.any(rows):
        raise InputError(
            finished(
                f"record: holds orders up to {measured.orders[-1]:g} at speeds from "
                f"{amount(float(measured.speed.min()), 'rad/s')}; calculated are orders up to "
                f"{response.orders[-1]:g} from {amount(low, 'rad/s')} to {amount(high, 'rad/s')}; allowed is "
                "a record with some of both."
            )
        )
    some = measured.part(rows, known)
    error = largest_lag(some, (*forced.resonances, *forced.started_through))
    notes = list(some.notes)
    by: Literal["steady", "run-up"] = "steady"
    if error > STEADY_ERROR and run.torsional is not None and measured.quantity != "axial":
        if step:
            step("Running up")
        calculated, by = _of_run_up(some, run, forced, index, error), "run-up"
    else:
        calculated = _steady(some, response, index)
        if error > MOST_RAMP_ERROR:
            raise _too_quick(error)
        if error > 5e-4:
            notes.append(
                f"The steady response is off by up to {100.0 * error:.2g} % at the peaks, as the speed "
                "changes."
            )
    better = None
    if by == "steady" and not response.system.varying and forced.engine_chain.kind == "torsional":
        better = _better_firing(some, response, index, forced.engine_chain.throw_nodes)
    some, calculated, left, chosen = _aligned(some, calculated)
    notes += chosen
    size = float(np.linalg.norm(some.amplitude))
    by_scatter = float(np.linalg.norm(some.scatter)) * np.sqrt(2.0) / size if size else 0.0
    pairs = [_pair(some, calculated, column) for column in range(some.orders.size)]
    pairs.sort(key=lambda pair: -pair.measured)
    return Overlay(
        run.engine_file.engine.name,
        place,
        some,
        calculated,
        by,
        error,
        left,
        tuple(pairs),
        tuple(dict.fromkeys(notes)),
        by_scatter,
        better,
    )


def _aligned(
    some: MeasuredOrders, calculated: ComplexArray
) -> tuple[MeasuredOrders, ComplexArray, float, list[str]]:
    """Choose what is unknown of mark and wheel to agree; return what is compared, left then, and notes."""
    notes = []
    if not some.zero_known:
        angle = _mark_angle(some, calculated)
        turned = some.amplitude * np.exp(-1j * angle * some.orders)
        some = replace(some, amplitude=turned, zero_known=True)
        notes.append(
            f"The angle of the wheel's mark is chosen to agree: {np.degrees(angle):.1f} deg; phases say no "
            "more than that."
        )
    least = float(np.linalg.norm(some.amplitude))
    if np.any(some.wheel_constant):
        if some.speed.max() > CONSTANT_RANGE * some.speed.min():
            constants = np.mean(some.amplitude - calculated, axis=0) * some.wheel_constant
            some = replace(some, amplitude=some.amplitude - constants)
            # Constants that cancel another engine's orders are no measurement of these.
            least = min(least, float(np.linalg.norm(some.amplitude)))
            held = f"are chosen to agree, the largest {np.degrees(np.abs(constants).max()):.2g} deg"
        elif np.all(some.wheel_constant):
            held = "are in them still, because at so few speeds any would agree"
        else:
            free = ~some.wheel_constant
            some = some.part(columns=free)
            calculated, least = calculated[:, free], float(np.linalg.norm(some.amplitude))
            held = "would make any engine's agree at so few speeds: half orders alone are compared"
        notes.append(f"The constants of the wheel in whole orders {held}.")
    return some, calculated, float(np.linalg.norm(some.amplitude - calculated)) / least, notes


def _forced_of(run: EngineVibration, measured: MeasuredOrders) -> ForcedVibration:
    """Return the vibration of the kind that was measured."""
    forced = run.forced_axial if measured.quantity == "axial" else run.forced_torsional
    if measured.quantity == "pressure" or forced is None:
        raise InputError(
            f"engine: given one to compare a measured {measured.quantity} with; allowed are angles, torques "
            "and axial motions of an engine with gas pressure, because these are vibration that it excites."
        )
    return forced


def _place(measured: MeasuredOrders, forced: ForcedVibration) -> tuple[str, int]:
    """Return the name and the index of the mass or element measured."""
    chain = forced.response.chain
    assert chain is not None
    of_element = measured.quantity == "torque"
    names = chain.elements if of_element else chain.names
    place = measured.place or names[0]
    what = "the chain's elements" if of_element else "the chain's masses"
    index = index_of_name("place", place, names, what, "the sensor is at one of them")
    return names[index], index


def _steady(
    measured: MeasuredOrders,
    response: ForcedResponse,
    index: int,
    forces: ComplexArray | None = None,
) -> ComplexArray:
    """Return the steady orders (m, k) at the place and speeds measured; forces (K, S, n) are other ones."""
    speeds, back = np.unique(measured.speed, return_inverse=True)
    acting = response.excitation.at_speeds(speeds)
    if forces is not None:
        acting = OrderExcitation(acting.orders, speeds, forces)
    there = replace(forced_response(response.system, acting), chain=response.chain)
    values = elastic_loads(there) if measured.quantity == "torque" else there.motion
    rows = np.searchsorted(response.orders, measured.orders)
    return np.asarray(values[rows][:, back, index].T)


def _better_firing(
    measured: MeasuredOrders, response: ForcedResponse, index: int, nodes: Sequence[int]
) -> float | None:
    """Return the share of other firing orders, the forces of throws changed about, that leave less."""
    count = measured.speed.size
    measured = measured.part(np.unique(np.linspace(0, count - 1, FIRING_SPEEDS).astype(int)))
    speeds = np.unique(measured.speed)
    forces = response.excitation.at_speeds(speeds).forces
    # Of a unit force on each throw, and the throws' forces, by speed and order.
    unit = np.zeros((len(nodes), *forces.shape), dtype=np.complex128)
    for place, node in enumerate(nodes):
        unit[place, :, :, node] = 1.0
    answers = np.array([_steady(measured, response, index, each) for each in unit])
    rows, at = (
        np.searchsorted(response.orders, measured.orders),
        np.searchsorted(speeds, measured.speed),
    )
    acting = forces[rows][:, at][:, :, list(nodes)].transpose(2, 1, 0)
    whole = _steady(measured, response, index)
    rest = whole - np.sum(answers * acting, axis=0)
    own = _aligned(measured, whole)[2]
    drawn = np.random.default_rng(0).permuted(
        np.tile(np.arange(len(nodes)), (FIRING_ORDERS, 1)), axis=1
    )
    left = np.array(
        [_aligned(measured, rest + np.sum(answers * acting[order], axis=0))[2] for order in drawn]
    )
    # Some are the same, begun at another cylinder.
    others = left[~np.isclose(left, own, rtol=1e-6)]
    return float(np.mean(others < own)) if others.size else None


def _of_run_up(
    measured: MeasuredOrders,
    run: EngineVibration,
    forced: ForcedVibration,
    index: int,
    error: float,
) -> ComplexArray:
    """Return the orders (m, k) of the engine's own run-up or run-down by the measured ramp."""
    from dynamics.transient.motions import transient_motion
    from dynamics.transient.propagator import SpeedCurve

    mean = float(np.mean(measured.ramp))
    if measured.speed.size < 2 or np.max(np.abs(measured.ramp - mean)) > EVEN_RAMP * abs(mean):
        raise _too_quick(error)
    response = forced.response
    speeds = response.speeds[0], response.speeds[-1]
    begin, end = speeds if mean > 0.0 else speeds[::-1]
    curve = SpeedCurve(np.array([0.0, (end - begin) / mean]), np.array([begin, end]))
    assert response.chain is not None
    added, _ = magnifier_damping(run.engine_file, forced.engine_chain)
    motion = transient_motion(response.chain, response.excitation, curve, modal_damping=added)
    moved = motion.motion + motion.rigid_motion
    values = motion.torque if measured.quantity == "torque" else moved
    angle = np.radians(motion.shaft_angle_deg)
    samples = Samples(motion.time, angle, np.asarray(values[:, index]))
    at = np.interp(mean * measured.speed, mean * motion.shaft_speed, angle)
    fit = fit_along(samples, response.orders, at)
    return np.asarray(fit.amplitude[:, np.searchsorted(response.orders, measured.orders)])


def _too_quick(error: float) -> InputError:
    return InputError(
        f"record: the speed changes so quickly that a steady response would be off by {100.0 * error:.2g} % "
        f"at a peak; allowed are up to {100.0 * STEADY_ERROR:g} %, or an even ramp, with which the engine's "
        "own run-up is compared."
    )


def _mark_angle(measured: MeasuredOrders, calculated: ComplexArray) -> float:
    """Return the shaft angle of the mark with which measured and calculated orders agree best [rad]."""
    tried = np.linspace(0.0, 2.0 * np.pi * measured.cycle, MARK_ANGLES, endpoint=False)
    # Constants of a wheel do not count: what varies over the speed does.
    both = [
        values - np.mean(values, axis=0) * measured.wheel_constant
        for values in (measured.amplitude, calculated)
    ]
    return agreeing_angle(measured.orders, np.sum(both[0] * both[1].conj(), axis=0), tried)


def _pair(measured: MeasuredOrders, calculated: ComplexArray, column: int) -> OrderPair:
    """Return the largest amplitudes of an order."""
    sizes = [np.abs(values[:, column]) for values in (measured.amplitude, calculated)]
    peak, expected = (int(np.argmax(size)) for size in sizes)
    return OrderPair(
        float(measured.orders[column]),
        float(sizes[0][peak]),
        float(measured.speed[peak]),
        float(measured.scatter[peak, column]),
        float(sizes[1][expected]),
        float(measured.speed[expected]),
        measured.unit,
    )
