"""Draw the pictures of these pages with the current code: ``python docs/build_pictures.py``."""

import math
from pathlib import Path

import numpy as np

import crankfem as cf
from crankfem.analyses.throw.pictures.drawing import write_drawing
from crankfem.files.engine.mechanism_file import load_mechanism
from dynamics.mechanism.rod_model_names import RodModelName

HERE = Path(__file__).parent
ENGINE = "8chn26-26"


def draw_hodographs() -> None:
    """Write the first- and second-order inertia forces of one throw with hinged rods."""
    engine = load_mechanism(ENGINE).layout
    speed = 1000 * math.pi / 30
    cf.pictures.plot_hinged_rods(HERE / "hodograph_8chn26-26.svg", engine, speed, cylinders=[1, 5])


def draw_loads(path: Path) -> None:
    """Draw the crankpin load of docs/mechanism.md: 13/14, rod of 225 mm, motored, three models."""
    length, bore, speed = 0.225, 0.130, 2100 * math.pi / 30
    inertia = 0.86 * 4.2 * 0.097 * (length - 0.097)
    rod = cf.ConnectingRod(length, 4.2, 0.097, inertia, 0.009)
    engine = cf.EngineLayout(0.070, [cf.EngineCylinder(bore, 3.4, rod)], [1])
    drive = cf.mechanism.SliderCrank(0.070, length)
    cycle = cf.gas.usual_gas_cycle(15.2, intake_pressure=1.0e5, exhaust_pressure=1.05e5)
    area = math.pi / 4 * bore**2
    motored = cf.gas.gas_cycle(
        cycle, lambda a: drive.piston(angle_deg=np.degrees(a)).place.real, area, heat=0.0
    )
    angles = np.radians(np.arange(0, 720, 1.0))
    gas = cf.gas.gas_forces(engine, motored.pressure, shaft_angles_deg=np.degrees(angles))
    models: tuple[RodModelName, ...] = ("two-mass", "three-mass", "rigid")
    forces = [
        cf.mechanism.mechanism_forces(
            engine, speed, gas, model=model, shaft_angles_deg=np.degrees(angles)
        )
        for model in models
    ]
    loads = [cf.mechanism.crankpin_loads(found)[0] for found in forces]
    title = "crankpin load, 8ChN 13/14, rod 225 mm, motored, 2100 1/min"
    cf.pictures.plot_polar_loads(path, loads, labels=models, title=title)


def main() -> None:
    """Write the drawing of a throw, the picture of a whole crankshaft, loads and hodographs."""
    throw, _ = cf.load_throw(ENGINE)
    write_drawing(throw, HERE / "drawing.svg", "8ChN 26/26")
    cf.pictures.picture_shaft(cf.load_crankshaft(ENGINE), HERE / "crankshaft.png")
    draw_loads(HERE / "loads_13_14.svg")
    draw_hodographs()


if __name__ == "__main__":
    with cf.replacing_files():
        main()
