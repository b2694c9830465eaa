"""Harmonics of a torque table or of an engine's torque with its stars: results, tables, rows of CSV."""

import math
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.quantity import RPM
from crankbase.results import Flat, Quantity, Result, result
from crankbase.sentences import amount, kept
from crankbase.table import SI, Column, Main, OutputUnits, Table, table_unit
from crankfem.files.engine.engine_file import EngineFile
from dynamics.harmonics import Harmonics, Spectrum, TorqueTable
from dynamics.torque import (
    EngineTorque,
    PinForceHarmonics,
    Star,
    leading_stars,
    same_stars,
    star_diagram,
)

USUAL_ORDERS = 9.0
COLUMNS = ("order", "cosine", "sine", "amplitude", "phase_deg")
Parts = Iterator[Table | str]


def harmonics_table(
    harmonics: Spectrum,
    title: str = "Harmonics",
    units: OutputUnits = SI,
    residuals: Mapping[str, Array] = MappingProxyType({}),
) -> Table:
    """Return orders, coefficients, amplitudes [N m] and phases, with residuals [N m] by name."""
    shown = table_unit(harmonics.amplitude, "N m", units)
    return Table(
        title,
        [
            Column("order", digits=None),
            *(shown.column(symbol) for symbol in ("A_k", "B_k", "M_k")),
            Column("a_k", "deg", decimals=2),
            *map(shown.column, residuals),
        ],
        np.column_stack([*_columns(harmonics), harmonics.phase, *residuals.values()]).tolist(),
        main=True,
        weights=harmonics.amplitude.tolist(),
    )


def _columns(harmonics: Spectrum) -> tuple[Array, ...]:
    return harmonics.orders, harmonics.cosine, harmonics.sine, harmonics.amplitude


def _csv_rows(name: str, harmonics: Spectrum) -> list[list[object]]:
    """Return rows below "of", "unit" and `COLUMNS`; that of order 0 is the mean."""
    unit, mean = harmonics.unit, harmonics.mean
    values = np.column_stack([*_columns(harmonics), np.rad2deg(harmonics.phase)]).tolist()
    return [[name, unit, 0.0, mean, 0.0, mean, 0.0], *([name, unit, *row] for row in values)]


def finite_sums(
    degrees: Array, torque: Array, strokes: int, highest: float
) -> Iterator[list[object]]:
    """Return the auxiliary table of the finite sums: names, a row for each sample, their sums.

    Parameters
    ----------
    degrees, torque : ndarray of shape (m,)
        Even crank angles of one cycle [deg], and the torque there [N m].
    highest : float
        Order up to which there are columns.

    Notes
    -----
    x is the angle of the cycle, 360 deg long, and k counts its waves: of the order k in two strokes and k/2
    in four. A_k and B_k are 2/m times the sums of y cos kx and y sin kx (Makushev, Polyakova 2024, doi
    10.25206/1813-8225-2024-191-39-47, table 2).
    """
    turns = strokes / 2.0
    x = np.radians(degrees / turns)
    columns = {"x_deg": degrees / turns, "y_Nm": torque}
    for k in range(1, int(highest * turns + 1e-9) + 1):
        for name, wave in (("cos", np.cos(k * x)), ("sin", np.sin(k * x))):
            columns |= {f"{name}_{k}x": wave, f"y_{name}_{k}x": torque * wave}
    yield ["sample", *columns]
    rows = np.column_stack([*columns.values()]).tolist()
    yield from ([number, *row] for number, row in enumerate(rows, start=1))
    sums = (float(np.sum(column)) if "y" in name else "" for name, column in columns.items())
    yield ["sum", *sums]


def _torque(value: float, units: OutputUnits, unit: str = "N m") -> str:
    return table_unit([value], unit, units).with_unit(value)


@result("stars", "leading_orders")
class FiredCylinders(Result):
    """Cylinders that are alike, each from its own firing top: the star of each order."""

    firing_angles_deg: Annotated[Sequence[float], Quantity("deg")]
    stars: tuple[Star, ...]

    @property
    def leading_orders(self) -> Annotated[list[float], Quantity("1")]:
        """Orders of the stars that lead."""
        return [star.order for star in leading_stars(self.stars)]

    @property
    def same_stars(self) -> Annotated[list[list[float]], Quantity("1")]:
        """Orders whose stars have equal shapes."""
        return [[star.order for star in group] for group in same_stars(self.stars)]

    def star_parts(self, *, hinged: bool = False) -> Parts:
        """Return the stars; with hinged rods, with the remark that they are incomplete."""
        like = {order: group for group in self.same_stars for order in group}
        yield Table(
            "Stars of the orders, all cylinders alike",
            [
                Column("order", digits=None),
                Column("kind", words=True),
                Column("resultant / sum", decimals=4),
                Column("vectors by cylinder", "deg", digits=None, words=True),
                Column("same star as", digits=6, words=True),
            ],
            [
                [
                    star.order,
                    star.kind,
                    star.share,
                    [math.radians(round(angle, 6)) for angle in star.directions_deg.tolist()],
                    [order for order in like[star.order] if order != star.order],
                ]
                for star in self.stars
            ],
        )
        if hinged:
            yield (
                "Cylinders with hinged rods differ from the others: an order with a balanced star can leave "
                "some torque, as the harmonics above show."
            )
        named = ", ".join(f"{order:g}" for order in self.leading_orders)
        major = any(star.kind == "major" for star in self.stars)
        heading = "Major orders" if major else "No order is major; the strongest"
        yield Main(f"{heading}: {named}." if named else "All orders cancel.")


@result("torque", "stars")
class SummedCylinders(FiredCylinders):
    """Cylinders with the torque of one table each."""

    torque: Spectrum
    remarks: Sequence[str]

    def parts(self, units: OutputUnits) -> Parts:
        """Return tables and sentences."""
        angles = ", ".join(f"{angle:g}" for angle in self.firing_angles_deg)
        count = len(self.firing_angles_deg)
        those = "1 cylinder" if count == 1 else f"{count} cylinders, each"
        mean = _torque(self.torque.mean, units)
        yield Main(f"{those} with this torque, fired at {angles} deg: mean torque {mean}.")
        yield harmonics_table(self.torque, "Harmonics of the sum of all cylinders", units)
        yield from (units.written(f"Note: {kept(remark)}") for remark in self.remarks)
        yield from self.star_parts()


@result("table", "harmonics.mean", "cylinders")
class TableHarmonics(Result):
    """Harmonics of a torque table, the samples' differences from their sums, and what cylinders make of it.

    Parameters
    ----------
    residual_rms, residual_largest : ndarray of shape (K,), optional
        Of the samples, from the mean and the harmonics up to each order.
    """

    harmonics: Flat[Harmonics]
    table: Annotated[str | None, Quantity(left_out=True)] = None
    source: Annotated[str | None, Quantity(left_out=True)] = None
    residual_rms: Annotated[Array | None, Quantity("N m", left_out=True)] = None
    residual_largest: Annotated[Array | None, Quantity("N m", left_out=True)] = None
    cylinders: Annotated[SummedCylinders | None, Quantity(left_out=True)] = None
    remarks: Annotated[tuple[str, ...] | None, Quantity(left_out=True)] = None

    def parts(self, units: OutputUnits = SI) -> Parts:
        """Return tables and sentences; orders above the usual ones only if all are above."""
        harmonics, largest = self.harmonics, self.residual_largest
        assert self.residual_rms is not None
        assert largest is not None
        if harmonics.orders[0] <= USUAL_ORDERS < harmonics.orders[-1]:
            harmonics = harmonics.up_to(USUAL_ORDERS)
        kept = harmonics.orders.size
        yield from (f"Note: {remark}" for remark in self.remarks or ())
        residuals = {"residual rms": self.residual_rms[:kept], "largest residual": largest[:kept]}
        yield Main(
            f"Mean {_torque(harmonics.mean, units)}; {harmonics.samples} samples resolve orders up to "
            f"{harmonics.highest_order:g}."
        )
        yield harmonics_table(harmonics, units=units, residuals=residuals)
        most, upto = largest[kept - 1], f"The sum up to order {harmonics.orders[-1]:g}"
        if most <= 1e-9 * max(harmonics.amplitude):
            yield Main(f"{upto} matches every sample.")
        else:
            yield Main(f"{upto} differs from the samples by at most {_torque(most, units)}.")
        if self.cylinders is not None:
            yield from self.cylinders.parts(units)

    def rows(self) -> tuple[str, list[list[object]]]:
        """Return what a file of CSV holds, and its rows."""
        rows = _csv_rows("torque", self.harmonics)
        if self.cylinders is not None:
            rows += _csv_rows("torque of all cylinders", self.cylinders.torque)
        return f"{self.table}, {self.harmonics.strokes} strokes per cycle", rows


def table_harmonics(
    name: str, table: TorqueTable, highest: float | None, firing_angles_deg: Sequence[float]
) -> tuple[TableHarmonics, Harmonics]:
    """Split the torque of a table, and add up cylinders that fire at the angles, if there are any.

    Returns
    -------
    TableHarmonics
        All orders unless there is a highest one.
    Harmonics
        Those to be drawn.
    """
    whole = table.harmonics()
    drawn = whole.up_to(min(highest or USUAL_ORDERS, whole.highest_order))
    listed = whole if highest is None else drawn
    each = listed.each_at(crank_angle_deg=table.crank_angle_deg)
    residual = table.torque - listed.mean - np.cumsum(each, axis=0)
    return TableHarmonics(
        listed,
        table=name,
        residual_rms=np.sqrt(np.mean(residual**2, axis=1)),
        residual_largest=np.max(np.abs(residual), axis=1),
        cylinders=summed_cylinders(drawn, firing_angles_deg) if firing_angles_deg else None,
        remarks=table.remarks,
    ), drawn


def summed_cylinders(harmonics: Harmonics, firing_angles_deg: Sequence[float]) -> SummedCylinders:
    """Add up cylinders with these harmonics each, phases from their firing tops.

    The order of which an even number of samples has one phase only is left out.
    """
    blind = harmonics.highest_order if harmonics.samples % 2 == 0 else math.inf
    stars = star_diagram(
        orders=harmonics.orders[harmonics.orders < blind * (1.0 - 1e-9)],
        firing_angles_deg=firing_angles_deg,
        strokes=harmonics.strokes,
    )
    count = len(stars)
    sums = np.array([0.0 if star.kind == "balanced" else star.resultant for star in stars])
    directions = np.array([math.radians(star.resultant_direction_deg) for star in stars])
    amplitude = sums * harmonics.amplitude[:count]
    phase = np.where(amplitude > 0.0, (harmonics.phase[:count] - directions) % (2.0 * np.pi), 0.0)
    return SummedCylinders(
        firing_angles_deg,
        stars,
        Spectrum(
            harmonics.orders[:count],
            amplitude,
            phase,
            cosine=amplitude * np.sin(phase),
            sine=amplitude * np.cos(phase),
            mean=len(firing_angles_deg) * harmonics.mean,
            unit=harmonics.unit,
        ),
        [
            f"order {order:g} is left out, because {harmonics.samples} samples resolve only one phase of it"
            for order in harmonics.orders[count:].tolist()
        ],
    )


@result("cylinders", "harmonics")
class ThrowHarmonics(Result):
    """Harmonics of the torque of one throw."""

    cylinders: Annotated[tuple[int, ...], Quantity("1")]
    harmonics: Harmonics


@result("engine", "torque.speed", "torque.mean")
class EngineHarmonics(FiredCylinders):
    """Torque of an engine, its harmonics and those of its throws, and the star of each order.

    Parameters
    ----------
    cylinder : PinForceHarmonics, optional
        Of the cylinder that was asked for.
    """

    engine: str
    torque: Flat[EngineTorque]
    rod_model: str
    strokes: int
    harmonics: Harmonics
    throws: tuple[ThrowHarmonics, ...]
    hinged_rods: bool
    remarks: Sequence[str]
    cylinder: Annotated[PinForceHarmonics | None, Quantity(left_out=True)] = None

    def parts(self, units: OutputUnits = SI) -> Parts:
        """Return tables and sentences."""
        torque, speed = self.torque, units.of("1/min").with_name(self.torque.speed, 5)
        uneven = torque.nonuniformity
        spread = "" if uneven is None else f", (largest - least) / mean {uneven:.4g}"
        yield Main(
            f"{self.engine} at {speed}: mean torque {_torque(torque.mean, units)}, indicated "
            f"power {_torque(torque.power, units, 'W')}{spread}."
        )
        yield from (units.written(f"Note: {kept(remark)}.") for remark in self.remarks)
        yield harmonics_table(self.harmonics, "Harmonics of the engine's torque", units)
        amplitudes = [throw.harmonics.amplitude for throw in self.throws]
        shown = table_unit(np.ravel(amplitudes), "N m", units)
        yield Table(
            f"Amplitudes by throw [{shown.name}]",
            [
                Column("order", digits=None),
                *(
                    shown.column(
                        f"throw {place} (cyl. {', '.join(map(str, throw.cylinders))})", bare=True
                    )
                    for place, throw in enumerate(self.throws, start=1)
                ),
            ],
            np.column_stack([self.harmonics.orders, *amplitudes]).tolist(),
        )
        if self.cylinder is not None:
            for force in ("tangential", "radial"):
                causes = self.cylinder.by_cause[force]
                force_unit = table_unit(
                    np.ravel([part.amplitude for part in causes.values()]), "N", units
                )
                mean = table_unit([part.mean for part in causes.values()], "N", units)
                means = ", ".join(
                    f"{cause} {mean.text(part.mean)}" for cause, part in causes.items()
                )
                columns, values = [Column("order", digits=None)], [causes["gas"].orders]
                for cause, part in causes.items():
                    columns += [
                        force_unit.column(f"{cause} M_k"),
                        Column(f"{cause} a_k", "deg", decimals=2),
                    ]
                    values += [part.amplitude, part.phase]
                letter = {"tangential": "T", "radial": "Z"}[force]
                top = "top" if self.strokes == 2 else "firing top"
                angle = amount(math.radians(self.cylinder.firing_angle_deg), "rad")
                title = units.written(
                    f"Cylinder {self.cylinder.number}: {force} force {letter} on the crankpin, phases from "
                    f"its {top} at {angle}; mean [{mean.name}]: {means}"
                )
                yield Table(title, columns, np.column_stack(values).tolist())
        yield from self.star_parts(hinged=self.hinged_rods)

    def rows(self) -> tuple[str, list[list[object]]]:
        """Return what a file of CSV holds, and its rows."""
        rows = _csv_rows("engine torque", self.harmonics)
        for place, throw in enumerate(self.throws, start=1):
            rows += _csv_rows(f"torque of throw {place}", throw.harmonics)
        if self.cylinder is not None:
            for force, causes in self.cylinder.by_cause.items():
                for cause, harmonics in causes.items():
                    name = f"{force} force of cylinder {self.cylinder.number} from {cause}"
                    rows += _csv_rows(name, harmonics)
        return (
            f"{self.engine}, {self.torque.speed * RPM:.10g} 1/min, rods as {self.rod_model}",
            rows,
        )


def engine_harmonics(
    engine_file: EngineFile,
    torque: EngineTorque,
    highest: float,
    cylinder: PinForceHarmonics | None = None,
) -> EngineHarmonics:
    """Split an engine's torque into orders up to a highest one."""
    engine = torque.engine
    remarks = list(engine_file.remarks)
    if not engine_file.pressure:
        remarks.append("the file has no section [gas]: the torque is that of moving masses alone")
    return EngineHarmonics(
        firing_angles_deg=engine.firing_deg,
        stars=star_diagram(engine, highest),
        engine=engine_file.engine.name,
        torque=torque,
        rod_model="rigid",
        strokes=engine.strokes,
        harmonics=torque.harmonics().up_to(highest),
        throws=tuple(
            ThrowHarmonics(throw, torque.harmonics(place).up_to(highest))
            for place, throw in enumerate(torque.throws, start=1)
        ),
        hinged_rods=any(cylinder.slave_pin is not None for cylinder in engine.cylinders),
        remarks=remarks,
        cylinder=cylinder,
    )
