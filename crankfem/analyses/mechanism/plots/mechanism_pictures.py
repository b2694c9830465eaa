"""The diagrams of a crank mechanism: loads of its bearings, forces of its pistons, balance."""

from pathlib import Path

from crankbase.drawing.diagram_style import figure, make_folder
from crankbase.drawing.legends import plain_text
from crankfem.analyses.mechanism.mechanism_run import MechanismRun, hinged_group
from crankfem.analyses.mechanism.plots.balance_plots import plot_balance, plot_hinged_rods
from crankfem.analyses.mechanism.plots.load_plots import plot_developed_loads, plot_polar_loads
from crankfem.analyses.titles import at_speed
from crankfem.analyses.to_draw import ToDraw, draw_all
from dynamics.engine.loads import LoadDiagram
from dynamics.plots.load_diagrams import Frame


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
    return draw_all(mechanism_pictures(folder, run))


def mechanism_pictures(folder: Path, run: MechanismRun) -> list[ToDraw]:
    """Return the diagrams of a mechanism, still to be drawn into a folder."""
    engine = at_speed(run.mechanism.name, run.speed)
    heaviest = max(run.bearings, key=lambda load: load.maximum)
    made = [
        *_load_pictures(folder, "crankpin", run.crankpins[0], "crank", engine),
        *_load_pictures(folder, "main_bearing", heaviest, "engine", engine),
        ToDraw(folder / "piston_forces.svg", lambda path: plot_piston_forces(path, run)),
    ]
    if not all(row.force_balanced and row.moment_balanced for row in run.balance.rows):
        made.append(
            ToDraw(
                folder / "balance.svg", lambda path: plot_balance(path, run.balance, title=engine)
            )
        )
    if run.hinged_rods:
        group = hinged_group(run.layout)
        made.append(
            ToDraw(
                folder / "hinged_rods.svg",
                lambda path: plot_hinged_rods(
                    path, run.layout, run.speed, cylinders=group, title=engine
                ),
            )
        )
    return made


def _load_pictures(
    folder: Path, name: str, load: LoadDiagram, frame: Frame, engine: str
) -> list[ToDraw]:
    """Both diagrams of a bearing's load."""
    return [
        ToDraw(
            folder / f"{name}_polar.svg",
            lambda path: plot_polar_loads(
                path, [load], frame=frame, title=f"{load.name}\n{engine}"
            ),
        ),
        ToDraw(
            folder / f"{name}_developed.svg",
            lambda path: plot_developed_loads(path, [load], title=f"{load.name}, {engine}"),
        ),
    ]


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
        engine = plain_text(at_speed(run.mechanism.name, run.speed))
        axes.set_title(f"cylinder {cylinder}, {engine}")
