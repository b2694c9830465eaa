"""What the command `measured` finds: a record's orders, and the overlay on an engine."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.diagrams import display_unit, figure
from crankbase.frames import Axes
from crankbase.quantity import RPM
from crankbase.results import InItsUnit, Internal, Number, Quantity, Result, Speed, result
from crankbase.sentences import amount, finished, kept
from crankbase.table import SI, Column, Main, OutputUnits, Table
from crankfem.analyses.titles import add_title
from crankfem.satellites.measured.measured_orders import PRINTED_UNITS, MeasuredOrders
from crankfem.satellites.measured.overlay import Overlay

# Pictures, and a page.
MAP, OVERLAY, PAGE = "orders_map.svg", "overlay.svg", "overlay.html"


@result("order", "amplitude", "speed", eq=True)
class LargestOrder(Result):
    """The largest amplitude of one order in a record."""

    order: Number
    amplitude: InItsUnit
    phase: Annotated[float, Quantity("rad", exported="deg")]
    scatter: InItsUnit
    speed: Speed
    wheel_constant: Annotated[bool, Quantity(meaning="whether a constant of the wheel is in it")]
    unit: str


@result("record", "place", "largest")
class MeasuredVibration(Result):
    """Orders of a record, and their comparison with an engine's, if one is given."""

    record: str
    place: str
    unit: str
    method: str
    measured: Internal[MeasuredOrders]
    orders: Annotated[Array, Quantity("1")]
    speed: Annotated[Array, Quantity("rad/s", "of each window", "1/min")]
    amplitude: Annotated[Array, Quantity(".unit", "by speed and order")]
    largest: tuple[LargestOrder, ...]
    overlay: Overlay | None
    notes: tuple[str, ...]

    @classmethod
    def of(
        cls, record: str, measured: MeasuredOrders, overlay: Overlay | None
    ) -> "MeasuredVibration":
        """Collect the largest amplitude of each order."""
        size = np.abs(measured.amplitude)
        rows = np.argmax(size, axis=0)
        largest = [
            LargestOrder(
                order,
                float(size[row, column]),
                float(np.angle(measured.amplitude[row, column])),
                float(measured.scatter[row, column]),
                float(measured.speed[row]),
                bool(measured.wheel_constant[column]),
                measured.unit,
            )
            for column, (order, row) in enumerate(
                zip(measured.orders.tolist(), rows.tolist(), strict=True)
            )
        ]
        notes = measured.notes if overlay is None else ()
        return cls(
            record,
            measured.place,
            measured.unit,
            measured.method,
            measured,
            measured.orders,
            measured.speed,
            size,
            tuple(largest),
            overlay,
            tuple(notes),
        )

    @property
    def conclusion(self) -> Annotated[str, Quantity(key="conclusion")]:
        """The main result in a sentence."""
        if self.overlay is not None:
            return self.overlay.conclusion
        first = max(self.largest, key=lambda each: each.amplitude)
        return finished(
            f"Largest order: {first.order:g}, {amount(first.amplitude, first.unit, 3)} at "
            f"{amount(first.speed, 'rad/s', 4)}."
        )

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return the tables, what does not fit, and remarks."""
        unit = PRINTED_UNITS[self.unit]
        place = f" at {self.place}" if self.place else ""
        yield Table.of_records(
            f"Largest amplitude of each order{place}: {self.method}",
            self.largest,
            (Column("order", digits=None), "order"),
            (Column("amplitude", unit, 3), "amplitude"),
            (Column("scatter", unit, 2), "scatter"),
            (Column("phase", "deg", decimals=0), "phase"),
            (Column("at", "1/min", decimals=0), "speed"),
            weight=lambda each: each.amplitude,
            main=self.overlay is None,
        )
        yield from (units.written(f"Note: {kept(note)}") for note in self.notes)
        if self.overlay is not None:
            yield from self.overlay.parts(units)
            if self.overlay.doubt:
                yield Main(units.written(self.overlay.doubt))

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the map: the amplitude of each order over the speed, by color."""
        from crankbase.diagrams import new_axes

        axes = new_axes(axes)
        name, size = display_unit(self.unit)
        ascending = np.argsort(self.measured.speed)
        mesh = axes.pcolormesh(
            _edges(RPM * self.speed[ascending]),
            _edges(self.orders),
            self.amplitude[ascending].T / size,
            cmap="viridis",
            rasterized=True,
        )
        axes.set_xlabel("speed [1/min]")
        axes.set_ylabel("order")
        axes.grid(visible=False)
        drawn = axes.get_figure()
        assert drawn is not None
        drawn.colorbar(mesh, ax=axes, label=f"amplitude [{name}]")
        return axes

    def draw(self, folder: Path, step: Callable[[str], None] | None = None) -> list[Path]:
        """Write the map, and of an overlay its picture and its page."""
        if step:
            step("Drawing")
        written = [folder / MAP]
        with figure(written[0], height=4.8) as axes:
            self.plot(axes)
            add_title(axes, f"{self.record}: orders over the speed")
        if self.overlay is not None:
            written += [folder / OVERLAY, folder / PAGE]
            self.overlay.draw(written[1])
            self.overlay.write_page(written[2])
        return written


def _edges(values: Array) -> Array:
    """Return the ends of cells around ascending values."""
    if values.size == 1:
        return np.array([values[0] - 0.25, values[0] + 0.25])
    middles = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - middles[0], 2.0 * values[-1] - middles[-1]
    return np.concatenate(([first], middles, [last]))
