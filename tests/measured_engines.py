"""Simulated records of a shipped engine: its orders with other values, as tables of orders."""

from dataclasses import replace
from functools import cache

import numpy as np

from crankfem.analyses.vibration.run import engine_vibration
from crankfem.files.engine.engine_file import load_engine
from crankfem.satellites.measured.calibration.engine_problem import EngineModel, with_magnifier
from crankfem.satellites.measured.calibration.fit import Problem
from crankfem.satellites.measured.measured_orders import MeasuredOrders

ENGINE = "6chn105-130"
FIELDS = {
    "flywheel.inertia": 0.05,
    "free_end.inertia": 0.2,
    "damping.torsional_magnifier": 0.5,
    "gas torque": 0.1,
}
WITH_THROWS = {**FIELDS, "torsional_compliance": 0.1}
TRUTH = np.array([0.5, 1.0, 0.8, -0.6, -1.2])
ORDERS = np.arange(1, 25) / 2.0


@cache
def run():
    return engine_vibration(ENGINE)


@cache
def model() -> EngineModel:
    engine = with_magnifier(load_engine(ENGINE), [*FIELDS])
    return EngineModel(engine_vibration(engine, analysis=run().analyses))


def calculated(engine, *, analysis=None, step=None):
    """Vibration of an engine: that of the maker's values is calculated once for all tests."""
    same = engine == model().engine_file
    return model().run if same else engine_vibration(engine, analysis=run().analyses)


def measured(place: str = "free end", groups: dict[str, float] = FIELDS, seed: int = 0):
    """Orders of the engine with other values at a place, with noise and the constants of a wheel."""
    of, rng = model(), np.random.default_rng(seed)
    speed = np.linspace(700.0, 1550.0, 30) * np.pi / 30.0
    record = MeasuredOrders(
        orders=ORDERS,
        speed=speed,
        amplitude=np.zeros((30, 24), dtype=complex),
        scatter=np.ones((30, 24)),
        place=place,
        quantity="angle",
        correlation=np.eye(30),
        ramp=np.zeros(30),
        wheel_constant=ORDERS % 1.0 == 0.0,
        cycle=2,
        zero_known=True,
    )
    problem = Problem(of.shaft(of.groups(groups)), (of.observation(record)[0],))
    true, _ = problem.predicted(TRUTH[: len(groups)], 0)
    size = np.sqrt(np.mean(np.abs(true) ** 2, axis=0))
    scatter = np.broadcast_to(np.maximum(0.05 * size, 0.003 * size.max()), true.shape)
    parts = rng.normal(size=(2, *true.shape))
    constants = (ORDERS % 1.0 == 0.0) * 0.1 * size.max()
    return replace(
        record, amplitude=true + constants + scatter * (parts[0] + 1j * parts[1]), scatter=scatter
    )


def written(record: MeasuredOrders, path) -> None:
    frame = record.to_pandas()
    lines = ["speed [1/min];order;amplitude [deg];phase [deg];scatter [deg]"]
    for row in frame.itertuples():
        numbers = (
            row.speed * 30.0 / np.pi,
            row.order,
            *np.degrees([row.amplitude, row.phase, row.scatter]),
        )
        lines.append(";".join(f"{number:.12g}" for number in numbers))
    path.write_text("\n".join(lines) + "\n")
