"""Tables of samples over a working cycle, and the harmonics of a torque or force that repeats."""

from dataclasses import field, replace
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array, finite_vector, positive_number, radians_of, read_only
from crankbase.choices import check_choice, check_one_each
from crankbase.errors import InputError
from crankbase.frames import Axes, DataFrame, table
from crankbase.input_file import GivenFile
from crankbase.results import Internal, Number, Quantity, Result, result
from crankbase.sentences import with_sentences
from crankbase.summaries import frozen
from dynamics.cycle import check_even_cycle, cycle_degrees, is_even_cycle, order_step
from dynamics.plots.harmonics import draw_harmonics, draw_samples, draw_single_harmonics
from dynamics.sample_tables import (
    TableKind,
    TableReading,
    even_count,
    one_cycle,
    possible_cycles,
    read_sample_rows,
)

Shown = Literal["amplitudes", "curves"]
SHOWN: tuple[Shown, ...] = get_args(Shown)
# A harmonic below this share of the largest sample is round-off and has no phase.
ROUND_OFF_SHARE = 1e-13
# Room for the round-off of an order that was calculated.
ROOM = 1.0 + 1e-9


# In the unit of the samples.
Sampled = Annotated[Array, Quantity(".unit")]


@result("orders", "amplitude", "mean")
class Spectrum(Result):
    """Mean and harmonics M_k sin(order x + a_k)."""

    orders: Annotated[Array, Quantity("1")]
    amplitude: Sampled
    phase: Annotated[Array, Quantity("rad", exported="deg")]
    cosine: Sampled
    sine: Sampled
    mean: Annotated[float, Quantity(".unit")]
    unit: Internal[str] = field(default="unit of the samples", kw_only=True)


@result("orders", "amplitude", "mean", "strokes", "samples")
class Harmonics(Spectrum):
    """The harmonics of samples over one cycle: y = mean + sum of M_k sin(order x + a_k).

    x is the crank angle and the order counts cycles per crankshaft revolution, so that the k-th
    harmonic of the cycle has the order k/2 in a four-stroke and k in a two-stroke engine.

    Parameters
    ----------
    orders : ndarray of shape (K,)
        Orders, ascending; K is half the number of samples, rounded down, unless cut by `up_to`.
    amplitude : ndarray of shape (K,)
        M_k, in the unit of the samples.
    phase : ndarray of shape (K,)
        a_k [rad], from 0 to below 2 pi; 0 for a harmonic that is only round-off.
    cosine, sine : ndarray of shape (K,)
        A_k and B_k of A_k cos(order x) + B_k sin(order x), in the unit of the samples.
    mean : float
        M_0, in the unit of the samples.
    samples : int
        Number of samples that the harmonics were found from, without a closing sample.

    Notes
    -----
    With an even number of samples the last order is at half the sampling rate. There the samples
    give one number only, alternating in sign: the amplitude is that at the sample points and
    the phase is chosen so that the series matches them. A component of this order whose zeros
    fall on the sample points is not detected.
    """

    strokes: int
    samples: int

    @property
    def highest_order(self) -> Number:
        """The highest order that the samples resolve, in cycles per crankshaft revolution."""
        return order_step(self.strokes) * (self.samples // 2)

    def resolves(self, order: float) -> bool:
        """Return whether the order is one of `orders`."""
        return bool(np.any(np.isclose(self.orders, order, rtol=1e-9, atol=0.0)))

    def index_of(self, order: float) -> int:
        """Return the index of the order in `orders`."""
        if not self.resolves(order):
            step = order_step(self.strokes)
            raise InputError(
                f"order: given {order:g}; allowed are {step:g} to {self.orders[-1]:g} in steps of "
                f"{step:g}, because {self._why_no_others}."
            )
        return int(np.argmin(np.abs(self.orders - order)))

    def up_to(self, highest_order: float) -> "Harmonics":
        """Return the harmonics without the orders above a highest one.

        Returns
        -------
        Harmonics
            The same mean and lower orders; their sum no longer matches the samples.

        Raises
        ------
        InputError
            If the highest order is above or below all of them.
        """
        highest = positive_number(
            "highest_order", highest_order, "", "orders count cycles per turn"
        )
        kept = int(np.count_nonzero(self.orders <= highest * ROOM))
        if kept == 0 or highest > self.orders[-1] * ROOM:
            raise InputError(
                f"highest_order: given {highest:g}; allowed are {self.orders[0]:g} to "
                f"{self.orders[-1]:g}, because {self._why_no_others}."
            )
        series = ("orders", "amplitude", "phase", "cosine", "sine")
        return replace(self, **{name: getattr(self, name)[:kept] for name in series})

    @property
    def _why_no_others(self) -> str:
        if self.orders.size < self.samples // 2:
            return f"those above {self.orders[-1]:g} were left out"
        return f"{self.samples} samples over one cycle resolve no others"

    def at(self, *, crank_angle_deg: ArrayLike) -> Array:
        """Sum the series at crank angles; at the sample points all orders give the samples.

        Parameters
        ----------
        crank_angle_deg : array_like of any shape
            Crank angle x [deg].
        """
        return np.asarray(self.each_at(crank_angle_deg=crank_angle_deg).sum(axis=0) + self.mean)

    def each_at(self, *, crank_angle_deg: ArrayLike) -> Array:
        """Return each harmonic separately; mean and running sum of them are the partial sums.

        Parameters
        ----------
        crank_angle_deg : array_like of any shape
            Crank angle x [deg].

        Returns
        -------
        ndarray of shape (K, ...)
            M_k sin(order x + a_k) in the unit of the samples.
        """
        arguments = np.multiply.outer(self.orders, radians_of("crank_angle_deg", crank_angle_deg))
        cosine, sine = (
            part.reshape(-1, *(1,) * (arguments.ndim - 1)) for part in (self.cosine, self.sine)
        )
        return np.asarray(cosine * np.cos(arguments) + sine * np.sin(arguments))

    def plot(
        self,
        axes: Axes | None = None,
        *,
        unit: str = "unit of the samples",
        highest_order: float | None = None,
        show: Shown = "amplitudes",
    ) -> Axes:
        """Draw the amplitudes by order as bars, or single harmonics over the cycle.

        Parameters
        ----------
        show : {"amplitudes", "curves"}
            "curves": each harmonic over the crank angle, with its amplitude and phase, the six
            largest if there are more.
        """
        check_choice("show", show, SHOWN, "these are drawn of harmonics")
        shown = self if highest_order is None else self.up_to(highest_order)
        if show == "curves":
            return draw_single_harmonics(axes, shown, unit)
        bars = {"amplitude": shown.amplitude}
        return draw_harmonics(axes, shown.orders, bars, f"amplitude [{unit}]", title="Harmonics")

    def to_pandas(self, unit: str = "unit of the samples") -> DataFrame:
        """Return one row for each order: amplitude, phase, cosine and sine part."""
        return table(
            {
                "order": (self.orders, "1"),
                "amplitude": (self.amplitude, unit),
                "phase": (self.phase, "rad"),
                "cosine": (self.cosine, unit),
                "sine": (self.sine, unit),
            }
        )


def harmonics(
    samples: ArrayLike,
    strokes: int = 4,
    *,
    angles_deg: ArrayLike | None = None,
    unit: str = "unit of the samples",
) -> Harmonics:
    """Find the harmonics of samples taken evenly over one working cycle, by fast Fourier transform.

    Parameters
    ----------
    samples : array_like of shape (m,)
        At least 3 values over one cycle: 720 deg of crank angle for a four-stroke engine, 360 deg
        for a two-stroke one. The closing sample, which repeats the first, is left out.
    angles_deg : array_like of shape (m,), optional
        Crank angles of the samples [deg], to be checked. They may start anywhere: phases
        count from crank angle zero. By default the first sample is at zero.
    unit : str, optional
        Of the samples, for JSON.

    Returns
    -------
    Harmonics
        Orders up to half the number of samples per revolution.

    Raises
    ------
    InputError
        If there are fewer than 3 samples, if one is not a finite number, or if the angles are not
        even over one cycle without the closing sample.

    Notes
    -----
    The coefficients are those of the finite sums (3) to (5) in Makushev, Polyakova, Omsk
    Scientific Bulletin 2024 no. 3 (191), doi 10.25206/1813-8225-2024-191-39-47, and the phase is
    that of its (1): M_k = sqrt(A_k^2 + B_k^2), tan a_k = A_k / B_k in the quadrant given by the
    signs. For an even m the last term has 1/m instead of 2/m, because there the squared cosine
    sums to m and not to m/2; with it the series matches every sample.

    Examples
    --------
    >>> angle = np.radians(np.arange(0, 720, 10))
    >>> found = harmonics(50 + 8 * np.sin(1.5 * angle + 0.3))
    >>> found.orders[:3].tolist(), round(found.mean, 9)
    ([0.5, 1.0, 1.5], 50.0)
    >>> round(float(found.amplitude[2]), 9), round(float(found.phase[2]), 9)
    (8.0, 0.3)
    """
    values = finite_vector("samples", samples)
    count = values.size
    if count < 3:
        raise InputError(
            f"samples: given {count} values; allowed are 3 or more, because fewer do not "
            "show amplitude and phase of the lowest harmonic."
        )
    orders = order_step(strokes) * np.arange(1, count // 2 + 1, dtype=np.float64)
    weights = np.full(orders.size, 2.0 / count)
    if count % 2 == 0:
        weights[-1] = 1.0 / count
    transform = np.fft.rfft(values)
    # A_k - i B_k for angles that count from the first sample, then from crank angle zero.
    coefficients = weights * transform[1:]
    if angles_deg is not None:
        angles = finite_vector("angles_deg", angles_deg)
        check_one_each("angles_deg", angles.size, count, "samples")
        check_even_cycle("angles_deg", angles, cycle_degrees(strokes))
        coefficients *= np.exp(-1j * orders * np.radians(float(angles[0])))
    cosine, sine = coefficients.real, -coefficients.imag
    amplitude = np.hypot(cosine, sine)
    phase = np.arctan2(cosine, sine) % (2.0 * np.pi)
    round_off = amplitude <= ROUND_OFF_SHARE * np.max(np.abs(values))
    # A tiny negative angle becomes 2 pi itself by rounding in the modulo.
    phase[round_off | (phase >= 2.0 * np.pi)] = 0.0
    return Harmonics(
        orders=read_only(orders),
        amplitude=read_only(amplitude),
        phase=read_only(phase),
        cosine=read_only(cosine + 0.0),  # the sum turns a negative zero into zero
        sine=read_only(sine + 0.0),
        mean=float(transform[0].real) / count,
        strokes=int(strokes),
        samples=int(count),
        unit=unit,
    )


CYCLE_ANGLE = "cycle_angle_deg"
CRANK_ANGLE = "crank_angle_deg"
UNITS = {"Nm": 1.0, "kNm": 1e3}
# First and closing sample count as equal within this share of the largest torque.
CLOSING_TOLERANCE = 1e-9

TABLE = TableKind(
    name="torque table",
    angle_names=(CRANK_ANGLE, CYCLE_ANGLE),
    value_names=tuple(f"torque_{unit}" for unit in UNITS),
    units=UNITS,
    si="N m",
    headers=f'"{CRANK_ANGLE},torque_Nm" or "{CYCLE_ANGLE},torque_Nm", or "kNm" for "Nm"',
    header_says="which angle is meant and in which units",
)


@with_sentences
@frozen("torque [N m]", "crank_angle_deg [deg]", "strokes", "source", eq=False)
class TorqueTable:
    """The torque of one throw, evenly sampled over one cycle, without the closing sample.

    Parameters
    ----------
    source : str
        The comment lines of the file, without their number sign.
    remarks : tuple of str
        Changes made to the samples, a sentence each.
    """

    crank_angle_deg: Array
    torque: Array
    source: str
    strokes: int
    remarks: tuple[str, ...] = ()

    def harmonics(self) -> Harmonics:
        """Return the harmonics of the torque [N m]."""
        degrees = self.crank_angle_deg
        return harmonics(self.torque, self.strokes, angles_deg=degrees, unit="N m")

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the samples, and the sum of their harmonics between them."""
        return draw_samples(axes, self.torque, self.harmonics(), title="Torque of one throw")

    def to_pandas(self) -> DataFrame:
        """Return crank angles and torques, a row for each sample."""
        return table({"crank_angle": (self.crank_angle_deg, "deg"), "torque": (self.torque, "N m")})


def read_torque_table(
    path: GivenFile, *, strokes: int | None = None, reading: TableReading | None = None
) -> TorqueTable:
    """Read a torque table.

    The file has comment lines that start with a number sign, the header ``crank_angle_deg,torque_Nm`` or
    ``cycle_angle_deg,torque_Nm`` (or ``kNm``), and one sample a line. The crank angle [deg] covers 720 deg in
    a four-stroke and 360 deg in a two-stroke engine, the cycle angle [deg] 360 deg in either. The mean of
    several cycles is taken. A closing sample that repeats the first but for noise is dropped. Uneven samples
    are resampled. The remarks of the result state the changes.

    Parameters
    ----------
    strokes : int, optional
        Strokes per cycle, 2 or 4. Crank angles determine it; for cycle angles it is 4
        by default.
    reading : TableReading, optional
        Which columns are meant, where the header does not say so.

    Returns
    -------
    TorqueTable
        Crank angles [deg], torques [N m], source and strokes.
    """
    cycles = possible_cycles(strokes)
    rows = read_sample_rows(path, TABLE, reading)
    if rows.angle_name == CYCLE_ANGLE:
        cycles = {4 if strokes is None else strokes: 360.0}
    cycle_strokes, rows = one_cycle(
        rows,
        cycles,
        tolerance=CLOSING_TOLERANCE,
        what="torque",
        even=True,
    )
    cycle = cycles[cycle_strokes]
    angles, torque, remarks = rows.angles, rows.values, rows.remarks
    if not is_even_cycle(angles, cycle):
        from scipy.interpolate import CubicSpline  # here: loading it takes a quarter second

        count = even_count(angles, cycle)
        curve = CubicSpline(
            np.append(angles, angles[0] + cycle), np.append(torque, torque[0]), bc_type="periodic"
        )
        remark = (
            f"The {angles.size} uneven samples were replaced by {count} even ones in steps of "
            f"{cycle / count:.4g} deg on the periodic cubic spline through them."
        )
        remarks = (*remarks, remark)
        angles = angles[0] + cycle / count * np.arange(count)
        torque = np.asarray(curve(angles), dtype=np.float64)
    return TorqueTable(
        crank_angle_deg=read_only(cycle_degrees(cycle_strokes) / cycle * angles),
        torque=read_only(UNITS[rows.unit] * torque),
        source=rows.source,
        strokes=cycle_strokes,
        remarks=remarks,
    )
