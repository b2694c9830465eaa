"""The crank mechanism at one speed: loads of crankpin and main bearing, forces of a piston."""

from crankfem.analyses.mechanism.hinged_rods import piston_names
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.mechanism.plots import (
    plot_accelerations,
    plot_balance,
    plot_hinged_rods,
    plot_polar_loads,
)
from crankfem.analyses.titles import at_speed
from crankfem.report.interactive.plot import Plot, Plots, plot_of_curves
from crankfem.report.interactive.style import Figure, diagram_figure
from dynamics.engine.forces import LoadDiagram, piston_forces
from dynamics.plots.load_diagrams import Frame, developed_load, polar_loads

SQUARE = 560  # pixels


def polar_load(load: LoadDiagram, frame: Frame, title: str) -> Figure:
    """Draw the locus of a bearing's force vector; see `polar_loads`."""
    traces, made = diagram_figure(polar_loads([(load.name, load)], frame), title, SQUARE)
    return traces, made | {"showlegend": False}


# Loads that differ by a smaller share are alike.
ALIKE = 1e-6


def _engine(run: MechanismRun) -> str:
    return at_speed(run.engine_file.engine.name, run.speed)


def _of_bearing(
    name: str, frame: Frame, polar: tuple[str, str], developed: tuple[str, str]
) -> tuple[Plot[MechanismRun], ...]:
    """Both diagrams of a load, with their words: that of the first crankpin, or the heaviest bearing."""

    def load(run: MechanismRun) -> LoadDiagram:
        if name == "crankpin":
            return run.crankpins[0]
        most = max(bearing.maximum for bearing in run.bearings)
        # The first of those that are alike but for round-off.
        return next(bearing for bearing in run.bearings if bearing.maximum > (1.0 - ALIKE) * most)

    def title(run: MechanismRun, between: str = ", ") -> str:
        return f"{load(run).name}{between}{_engine(run)}"

    return (
        Plot(
            f"{name}_polar",
            *polar,
            lambda path, run: plot_polar_loads(
                path, [load(run)], frame=frame, title=title(run, "\n")
            ),
            lambda run: polar_load(load(run), frame, title(run)),
        ),
        plot_of_curves(
            f"{name}_developed", *developed, lambda run: developed_load(load(run)), title
        ),
    )


def _has(run: MechanismRun) -> list[str]:
    balanced = all(row.force_balanced and row.moment_balanced for row in run.balance.rows)
    return [*([] if balanced else ["unbalanced"]), *(["hinged rods"] if run.hinged_rods else [])]


MECHANISM: Plots[MechanismRun] = Plots(
    (
        *_of_bearing(
            "crankpin",
            "crank",
            (
                "Polar diagram of the crankpin load",
                "Force of the rod on the first crankpin, in the frame rotating with the crank; dots every "
                "30 deg of shaft angle.",
            ),
            (
                "Size of the crankpin load over the shaft angle",
                "The same load over the shaft angle, with its mean and maximum.",
            ),
        ),
        *_of_bearing(
            "main_bearing",
            "engine",
            (
                "Polar diagram of the main bearing load",
                "Load of the most heavily loaded main bearing, in the fixed frame, seen from the free end.",
            ),
            (
                "Size of the main bearing load over the shaft angle",
                "The main bearing load over the shaft angle, with its mean and maximum.",
            ),
        ),
        plot_of_curves(
            "piston_forces",
            "Gas, tangential and side force of one cylinder over the cycle",
            "Forces of the first cylinder over its cycle.",
            lambda run: piston_forces(run.forces, 1),
            lambda run: f"cylinder 1, {_engine(run)}",
        ),
        Plot(
            "balance",
            "Inertia forces and moments on the engine by order",
            "Unbalanced forces and moments, seen from the free end. A dot marks the vector at shaft angle "
            "zero, with the first crank up; an arrowhead marks its sense of rotation; thin dashed lines: "
            "cylinder axes.",
            lambda path, run: plot_balance(path, run.balance, title=_engine(run)),
            needs="unbalanced",
        ),
        Plot(
            "hinged_rods",
            "Effect of the hinged rods compared with rods on the crankpin",
            "Effect of the hinged rods.",
            lambda path, run: plot_hinged_rods(
                path, run.layout, run.speed, cylinders=hinged_group(run.layout), title=_engine(run)
            ),
            needs="hinged rods",
        ),
        Plot(
            "accelerations",
            "Accelerations of the pistons of main and hinged rods, by order",
            "Pistons on the first crankpin with hinged rods, each at the same angle from its own top.",
            lambda path, run: plot_accelerations(
                path,
                run.layout,
                run.speed,
                piston_names(run.layout, hinged_group(run.layout)),
                title=_engine(run),
            ),
            needs="hinged rods",
        ),
    ),
    _has,
)
