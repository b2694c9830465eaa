"""The diagrams of a crank mechanism: loads of its bearings, forces of its pistons, balance."""

from pathlib import Path

from crankfem.mechanism_run import MechanismRun, hinged_group
from crankfem.pictures.balance_plots import plot_balance, plot_hinged_rods
from crankfem.pictures.load_plots import plot_developed_loads, plot_polar_loads
from crankfem.pictures.titles import at_speed
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import Frame
from geometry.diagram_style import figure, make_folder


def picture_mechanism(folder: Path, run: MechanismRun) -> list[Path]:
    """Write the diagrams of a mechanism into a folder, which is made if it is not there.

    Returns
    -------
    list of Path
        The SVG files.

    Raises
    ------
    InputError
        If the folder cannot be made.
    """
    make_folder(folder)
    engine = at_speed(run.mechanism.name, run.speed)
    heaviest = max(run.bearings, key=lambda load: load.maximum)
    made = []
    drawn: tuple[tuple[str, LoadDiagram, Frame], ...] = (
        ("crankpin", run.crankpins[0], "crank"),
        ("main_bearing", heaviest, "engine"),
    )
    for name, load, frame in drawn:
        polar, developed = folder / f"{name}_polar.svg", folder / f"{name}_developed.svg"
        plot_polar_loads(polar, [load], frame=frame, title=f"{load.name}\n{engine}")
        plot_developed_loads(developed, [load], title=f"{load.name}, {engine}")
        made += [polar, developed]
    made.append(folder / "piston_forces.svg")
    plot_piston_forces(made[-1], run)
    if not all(row.force_balanced and row.moment_balanced for row in run.balance.rows):
        made.append(folder / "balance.svg")
        plot_balance(made[-1], run.balance, title=engine)
    if run.hinged_rods:
        made.append(folder / "hinged_rods.svg")
        group = hinged_group(run.layout)
        plot_hinged_rods(made[-1], run.layout, run.speed, cylinders=group, title=engine)
    return made


def plot_piston_forces(path: Path, run: MechanismRun, cylinder: int = 1) -> None:
    """Plot gas force, side force and tangential force of a cylinder over the cycle, as SVG.

    Parameters
    ----------
    path : Path
    run : MechanismRun
    cylinder : int, optional
        Its number, from 1.
    """
    with figure(path) as axes:
        run.forces.plot(axes, cylinder)
        axes.set_title(f"cylinder {cylinder}, {at_speed(run.mechanism.name, run.speed)}")
