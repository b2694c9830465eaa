"""The diagrams of a report, each from plain numbers to one SVG file."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crankfem.fitting import ResponseFits
from crankfem.pictures.style import BLUE, COLORS, GRAY, GREEN, ORANGE, RED, figure, math_symbol
from crankfem.vibration import SourceResult, Vibration
from dynamics.harmonics import Harmonics
from regression.forms import factor_label
from regression.study import StudyTable

Array = NDArray[np.float64]
RPM = 30.0 / np.pi
SHAPES_SHOWN = 3


def plot_response(path: Path, table: StudyTable, fits: ResponseFits) -> None:
    """Plot the FE results of a study and the chosen equation over each factor in turn.

    The other factors stay at their middle level; FE results at those levels are shown as dots.
    """
    factors = table.plan.factors
    middles = np.array([sorted(levels)[len(levels) // 2] for levels in table.plan.levels.values()])
    column = table.responses["axial_compliance_pinned"] * 1e9
    with figure(path, len(factors), width=3.1 * len(factors) + 0.6, height=3.4) as axes:
        for place, (name, panel) in enumerate(zip(factors, np.atleast_1d(axes), strict=True)):
            label = factor_label(name)
            levels = table.plan.levels[name]
            points = np.tile(middles, (80, 1))
            points[:, place] = np.linspace(min(levels), max(levels), 80)
            for fit, style in zip(fits.fits, ("--", ":", "-."), strict=False):
                chosen = fit is fits.chosen
                panel.plot(
                    points[:, place] / label.size,
                    fit.predict(points) * 1e9,
                    color=BLUE if chosen else GRAY,
                    linestyle="-" if chosen else style,
                    linewidth=1.8 if chosen else 1.0,
                    label=fit.form + (" (chosen)" if chosen else ""),
                )
            others = np.arange(len(factors)) != place
            on_line = np.all(np.isclose(table.values[:, others], middles[others]), axis=1)
            panel.plot(
                table.values[on_line, place] / label.size,
                column[on_line],
                "o",
                color=ORANGE,
                label="finite elements",
            )
            panel.set_xlabel(f"{name.replace('_', ' ')} {math_symbol(label.symbol)} [{label.unit}]")
            if place == 0:
                panel.set_ylabel(r"axial compliance $e_\mathrm{n}$ [$10^{-9}$ m/N]")
        np.atleast_1d(axes)[-1].legend(fontsize=8)


def plot_parity(path: Path, table: StudyTable, fits: ResponseFits) -> None:
    """Plot each form's error at the runs and at the held-out designs over the FE value."""
    column = table.responses["axial_compliance_pinned"]
    with figure(path, len(fits.fits), width=3.1 * len(fits.fits) + 0.6, height=3.4) as axes:
        for fit, panel in zip(fits.fits, np.atleast_1d(axes), strict=True):
            predicted = fit.predict(table.values)
            ends = np.array([column.min(), column.max()]) * 1e9
            panel.plot(ends, ends, color=GRAY, linewidth=1.0)
            for held, color, marker, label in (
                (False, BLUE, "o", "fitted runs"),
                (True, ORANGE, "D", "held out"),
            ):
                chosen = table.held_out == held
                panel.plot(
                    column[chosen] * 1e9,
                    predicted[chosen] * 1e9,
                    marker,
                    color=color,
                    label=label,
                    markersize=5,
                    alpha=0.85,
                )
            worst = 100.0 * (fit.largest_heldout_error or 0.0)
            panel.set_title(f"{fit.form}: held out within {worst:.2g} %", fontsize=9)
            panel.set_xlabel(r"$e_\mathrm{n}$ by finite elements [$10^{-9}$ m/N]")
        np.atleast_1d(axes)[0].set_ylabel(r"$e_\mathrm{n}$ by the equation [$10^{-9}$ m/N]")
        np.atleast_1d(axes)[0].legend(fontsize=8)


def plot_formulas(
    path: Path, gammas: Array, fe: Array, formulas: Mapping[str, Array], bounds: tuple[float, float]
) -> None:
    """Plot the published formulas and FE over the angle between neighboring cranks.

    Parameters
    ----------
    path : Path
    gammas : (g,) array
        Angles between neighboring cranks [deg].
    fe : (g,) array
        FE compliance in a helix of that angle [m/N].
    formulas : mapping
        Formula name to (g,) values [m/N], nan where it does not apply.
    bounds : (float, float)
        FE values guided and pinned [m/N].
    """
    with figure(path) as axes:
        for (name, values), color in zip(formulas.items(), COLORS * 2, strict=False):
            axes.plot(gammas, values * 1e9, color=color, linewidth=1.3, label=name)
        axes.plot(gammas, fe * 1e9, color="black", linewidth=2.4, label="finite elements")
        for value, text in zip(bounds, ("guided", "pinned"), strict=True):
            axes.axhline(value * 1e9, color="black", linewidth=0.8, linestyle=":")
            axes.annotate(
                text, (0.0, value * 1e9), xytext=(2, 3), textcoords="offset points", fontsize=8
            )
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(0.0, 180.0)
        axes.set_xticks(np.arange(0, 181, 30))
        axes.set_xlabel("angle between neighboring cranks [deg]")
        axes.set_ylabel(r"axial compliance $e_\mathrm{n}$ [$10^{-9}$ m/N]")
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def plot_mode_shapes(path: Path, result: SourceResult) -> None:
    """Plot the first elastic mode shapes of a chain over its nodes."""
    modes = result.modes
    places = np.arange(len(result.chain.nodes))
    with figure(path, height=3.4) as axes:
        axes.axhline(0.0, color=GRAY, linewidth=1.0)
        for shown, mode in enumerate(range(modes.rigid, len(modes.frequencies))):
            if shown == SHAPES_SHOWN:
                break
            nodes = len(modes.node_positions[mode])
            axes.plot(
                places,
                modes.shapes[:, mode],
                "o-",
                color=COLORS[shown],
                markersize=4,
                label=f"{modes.frequencies[mode]:.1f} Hz, {nodes} node{'s' if nodes != 1 else ''}",
            )
            axes.plot(
                modes.node_positions[mode], np.zeros(nodes), "x", color=COLORS[shown], markersize=7
            )
        axes.set_xticks(places, [_short(name) for name in result.chain.nodes], fontsize=8)
        axes.set_ylabel("relative " + ("displacement" if result.chain.kind == "axial" else "twist"))
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _short(name: str) -> str:
    return (
        name.replace("cylinder ", "cyl. ")
        .replace("section ", "")
        .replace(", flywheel", "\nflywheel")
        .replace(", thrust bearing", "\nthrust")
    )


def plot_campbell(
    path: Path, vibration: Vibration, orders: Sequence[float], speeds: tuple[float, float]
) -> None:
    """Plot natural frequencies and order lines over the running range, critical speeds marked.

    Parameters
    ----------
    path : Path
    vibration : Vibration
    orders : sequence of float
        Harmonic orders [cycles per revolution].
    speeds : (float, float)
        Running range [rad/s].
    """
    low, high = (speed * RPM for speed in speeds)
    span = high - low
    left, right = max(0.0, low - 0.1 * span), high + 0.1 * span
    top = 1.05 * max(orders) * right / 60.0
    with figure(path, height=4.6) as axes:
        axes.axvspan(low, high, color="#eef3f8", zorder=0)
        for order in orders:
            end = order * right / 60.0
            axes.plot(
                [left, right],
                [order * left / 60.0, end],
                color=GRAY,
                linewidth=0.9 if float(order).is_integer() else 0.4,
            )
            if float(order).is_integer():
                axes.annotate(
                    f"{order:g}",
                    (right, end),
                    xytext=(3, -3),
                    textcoords="offset points",
                    fontsize=7,
                )
        for shown, frequency in enumerate(vibration.chosen.elastic_frequencies):
            if frequency > top:
                continue
            axes.axhline(frequency, color=COLORS[shown % len(COLORS)], linewidth=1.8)
            axes.annotate(
                f"{frequency:.1f} Hz",
                (left, frequency),
                xytext=(3, 3),
                textcoords="offset points",
                fontsize=8,
                color=COLORS[shown % len(COLORS)],
            )
        for critical in vibration.criticals:
            axes.plot(
                critical.critical.speed_rpm,
                critical.critical.frequency,
                "o",
                color=RED,
                markersize=3.0 + 7.0 * critical.phase_sum,
                alpha=0.85,
            )
        axes.set_xlim(left, right)
        axes.set_ylim(0.0, top)
        axes.set_xlabel("crankshaft speed [1/min]")
        axes.set_ylabel("frequency [Hz]")
        axes.set_title(
            f"{vibration.kind}: running range shaded, order at the right end of its line; "
            "dots grow with the phase sum",
            fontsize=9,
        )


def plot_torque(path: Path, samples: Array, found: Harmonics) -> None:
    """Plot torque samples with the sum of all harmonics, and the amplitudes by order."""
    cycle = np.pi * found.strokes
    angles = np.linspace(0.0, cycle, 721)
    sample_angles = np.arange(len(samples)) * cycle / len(samples)
    with figure(path, 2, width=8.6, height=3.4) as (left, right):
        left.plot(np.rad2deg(angles), found.at(angles), color=BLUE, label="sum of harmonics")
        left.plot(
            np.rad2deg(sample_angles), samples, "o", color=ORANGE, markersize=3.5, label="table"
        )
        left.axhline(found.mean, color=GREEN, linestyle="--", linewidth=1.0, label="mean")
        left.set_xlabel("crank angle [deg]")
        left.set_ylabel("torque of one throw [N m]")
        left.legend(fontsize=8)
        right.bar(found.orders, found.amplitude, width=0.3 * found.orders[0] / 0.5, color=BLUE)
        right.set_xlabel("harmonic order [cycles per revolution]")
        right.set_ylabel(r"amplitude $M_k$ [N m]")
