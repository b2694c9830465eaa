"""Draw the pictures of these pages with the current code: ``python docs/build_pictures.py``."""

import math
import re
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import matplotlib.pyplot as plt

import crankfem as cf
from crankfem.analyses.mechanism.hinged_rods import piston_names
from crankfem.analyses.mechanism.plots import picture_torque_table, plot_model_difference
from crankfem.analyses.mechanism.rod_models import model_difference
from crankfem.analyses.throw.pictures.drawing import write_drawing
from crankfem.files.engine.engine_file import load_mechanism
from crankfem.report.interactive.vibration import VIBRATION

HERE = Path(__file__).parent
ENGINE = "8chn26-26"
PICTURES = (
    "accelerations_8chn26-26.svg",
    "axial_force_6chn25-34.svg",
    "harmonics_yamz-5340.svg",
    "hodograph_8chn26-26.svg",
    "rod_models_13_14.svg",
    "rod_models_13_14_short.svg",
    "study_slopes.svg",
)


def draw_hodographs() -> None:
    """Write the first- and second-order inertia forces of one throw with hinged rods."""
    engine = load_mechanism(ENGINE).layout
    speed = 1000 * math.pi / 30
    cf.pictures.plot_hinged_rods(HERE / "hodograph_8chn26-26.svg", engine, speed, cylinders=[1, 5])


def draw_rod_models(path: Path, engine: Path | str, *, motored: bool = False) -> None:
    """Draw a crankpin load of docs/mechanism.md by two and by three masses."""
    run = cf.run_mechanism(load_mechanism(engine), model="two-mass", motored=motored)
    title = f"{run.crankpins[0].name}, {'motored' if motored else 'rated load'}"
    plot_model_difference(path, model_difference(run, "three-mass"), title=title)


def short_rod(folder: Path) -> Path:
    """Write the engine 13/14 with a rod of 225 mm and atmospheric pressure in the intake."""
    text = load_mechanism("8chn13-14").path.read_text(encoding="utf-8")
    for long, short in (
        ('"265 mm"', '"225 mm"'),
        ('"2.66264 kg"', '"2.38933 kg"'),
        ('"0.0589 kg m^2"', '"0.04485 kg m^2"'),
        ("[gas]", '[gas]\nintake_pressure = "0.1 MPa"\nexhaust_pressure = "0.105 MPa"'),
    ):
        text = text.replace(long, short)
    path = folder / "short.toml"
    path.write_text(text, encoding="utf-8")
    return path


def draw_accelerations(path: Path) -> None:
    """Draw the accelerations of main and hinged piston."""
    engine = load_mechanism(ENGINE).layout
    cylinders = piston_names(engine, (1, 5))
    cf.pictures.plot_accelerations(path, engine, 1000 * math.pi / 30, cylinders)


def draw_papers_figures() -> None:
    """Write what docs/torque.md and docs/excitation.md show beside the figures of papers."""
    table = cf.load_torque_table("yamz5340_torque_one_throw.csv")
    with TemporaryDirectory() as folder:
        _, curves, _ = picture_torque_table(Path(folder), table, table.harmonics().up_to(2.0))
        (HERE / "harmonics_yamz-5340.svg").write_bytes(curves.read_bytes())
        VIBRATION.draw(Path(folder), cf.engine_vibration("6chn25-34"))
        force = Path(folder) / "axial_force.svg"
        (HERE / "axial_force_6chn25-34.svg").write_bytes(force.read_bytes())


def draw_study_slopes() -> None:
    """Draw the table of docs/regression.md: error of e_n over time, with and without slopes."""
    page = (HERE / "regression.md").read_text(encoding="utf-8")
    _, _, *rows = re.findall(r"^\|.*runs \| CPU s.*(?:\n\|.*)+", page, re.M)[0].splitlines()
    figure, both = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True, layout="constrained")
    colors: dict[str, str] = {}
    for half, (axes, title) in enumerate(zip(both, ("three factors", "five factors"), strict=True)):
        curves: dict[str, list[tuple[float, float]]] = {}
        design = ""
        for row in rows:
            name, _, times, errors = (
                cell.strip(" *") for cell in row.split("|")[1 + 4 * half :][:4]
            )
            design = name or design
            for label, *point in zip(
                *(cell.split(";") for cell in (design, times, errors)), strict=True
            ):
                if times:
                    seconds, error = (float(text.split("(")[0]) for text in point)
                    curves.setdefault(label.strip(), []).append((seconds, error))
        for label, points in curves.items():
            slopes = "with slopes" in label
            drawn = label if label != "with slopes" else "Latin hypercube with slopes"
            color = colors.setdefault(drawn, f"C{len(colors)}")
            axes.semilogy(
                *zip(*points, strict=True), "s-" if slopes else "o:", color=color, label=drawn
            )
        axes.axhline(1.4, color="0.5", linewidth=0.8)
        axes.set(xlabel="processor time of the runs [s]", title=title, xlim=(0.0, None))
        axes.set_yticks([0.1, 0.2, 0.5, 1.0, 2.0, 5.0])
    both[0].set_ylabel("largest held-out error of $e_n$ [%]")
    both[0].yaxis.set_major_formatter("{x:g}")
    both[0].yaxis.set_minor_formatter("")
    figure.legend(*both[0].get_legend_handles_labels(), loc="outside right", fontsize="small")
    figure.savefig(HERE / "study_slopes.svg")


def shorten(path: Path) -> None:
    """Write numbers of an SVG file with two decimals of a point, each curve and each text in one line."""
    text = path.read_text(encoding="utf-8")
    # Scales of characters keep all their digits.
    text = re.sub(r"scale\([^)]*\)|(\d+\.\d\d)\d+", lambda found: found[1] or found[0], text)
    text = re.sub(r" *\n *(?=[LQCMz]|<use)", "", text)
    text = re.sub(r"\n +", "\n", text)
    path.write_text(text, encoding="utf-8")


def main() -> None:
    """Write the drawing of a throw, a whole crankshaft, loads, hodographs, and figures of papers."""
    throw, _ = cf.load_throw(ENGINE)
    write_drawing(throw, HERE / "drawing.svg", "8ChN 26/26", lettered=True)
    cf.pictures.picture_shaft(cf.load_crankshaft("8chn13-14"), HERE / "crankshaft.png")
    draw_rod_models(HERE / "rod_models_13_14.svg", "8chn13-14")
    with TemporaryDirectory() as folder:
        short = short_rod(Path(folder))
        draw_rod_models(HERE / "rod_models_13_14_short.svg", short, motored=True)
    draw_hodographs()
    draw_accelerations(HERE / "accelerations_8chn26-26.svg")
    draw_papers_figures()
    draw_study_slopes()
    for name in PICTURES:
        shorten(HERE / name)


if __name__ == "__main__":
    # Points of curves closer to a straight line than that are left out [1/72 in].
    mpl.rcParams["path.simplify_threshold"] = 0.3
    with cf.replacing_files():
        main()
