"""Draw the pictures of docs/transient.md with the current code: takes a minute or two."""

import math
from pathlib import Path

import numpy as np

import crankfem as cf
from dynamics.transient.turning_run import throw_inertia_curves

HERE = Path(__file__).parent
RPM = 30.0 / np.pi


def draw_run_up() -> None:
    """Draw the shaft at the flywheel of the MWM six through its resonances in 4 s."""
    chain = cf.Chain(
        inertia=[0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750],
        stiffness=np.array([1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976]) * 1e6,
        ground_damping=dict.fromkeys(range(2, 8), 2.0),
        loss_factor=0.035,
    )
    orders, speeds = np.arange(0.5, 12.5, 0.5), np.linspace(100.0, 270.0, 18)
    firing = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
    torque = np.zeros((orders.size, speeds.size, 9), dtype=complex)
    phases = np.exp(-1j * np.outer(orders, firing + 0.4))
    torque[:, :, 2:8] = (900.0 / (1.0 + orders[:, None] ** 1.5) * phases)[:, None]
    excitation = cf.OrderExcitation(orders, speeds, torque)
    run = cf.transient.transient_motion(
        chain, excitation, cf.transient.SpeedCurve.ramp(120.0, 260.0, duration=4.0)
    )
    constant = np.linspace(120.0, 260.0, 141)
    steady = [cf.transient.steady_motion(chain, excitation, float(speed)) for speed in constant]
    amplitudes = np.array([one.torque_amplitude[7] for one in steady])
    cf.pictures.plot_transient(
        HERE / "transient_run_up.svg",
        run,
        7,
        steady=(constant, amplitudes),
        title="MWM six, run-up in 4 s",
    )


def slow_six() -> tuple[cf.EngineLayout, cf.gas.GasPressure, cf.chains.EngineChain]:
    """Return a slow two-stroke six with heavy pistons, its gas and its chain; values are invented."""
    rod = cf.ConnectingRod(2.4, 1500.0, 0.9, 1100.0)
    order = [1, 5, 3, 4, 2, 6]
    tops = {number: place * np.pi / 3.0 for place, number in enumerate(order)}
    cylinders = [
        cf.EngineCylinder(
            0.6, 2500.0, rod, crank_angle_deg=math.degrees(-tops[number]), position=1.1 * number
        )
        for number in range(1, 7)
    ]
    engine = cf.EngineLayout(1.0, cylinders, order, strokes=2)
    angles = np.radians(np.arange(0.0, 360.0, 1.0))
    volume = 1.0 / 14.0 + 0.5 * (1.0 - np.cos(angles))
    after = (angles + np.pi) % (2.0 * np.pi) - np.pi
    compressed = 3e5 * np.maximum(1.0, (0.9 + 1.0 / 14.0) / volume) ** 1.33
    heat = np.where(after > 0.0, 1.0 - np.exp(-4.0 * (after / 0.5) ** 2), 0.0)
    opening = np.where(np.abs(after) < 2.0, np.cos(np.pi * after / 4.0) ** 2, 0.0)
    burnt = 9e6 * heat * (1.0 / 14.0 / volume) ** 1.25 * opening
    inertia = np.array([3500.0] * 6 + [4000.0, 25000.0])
    inertia[:6] += throw_inertia_curves(engine, list(range(6))).mean
    names = [*(f"cylinder {number}" for number in range(1, 7)), "flywheel", "propeller"]
    chain = cf.Chain(inertia, [4e8] * 5 + [5e8, 4e7], names=names)
    gas = cf.gas.gas_pressure(compressed + burnt, strokes=2, angles_deg=np.degrees(angles))
    return engine, gas, cf.chains.EngineChain(chain, "torsional", throw_nodes=tuple(range(6)))


def draw_secondary_resonance() -> None:
    """Draw order 8 where order 6 is critical, by the mean inertia and by the varying one."""
    engine, gas, chain = slow_six()
    speeds = np.linspace(66.0, 84.0, 37) / RPM
    forces = cf.excitation.cylinder_forces(engine, speeds, 12, gas)
    by_gas = cf.excitation.cylinder_forces(engine, speeds, 12, gas, inertia=False)
    turning = cf.transient.turning_chain(engine, chain, by_gas, magnifier=30.0)
    mean = cf.forced_response(turning.system.system, cf.excitation.torque_excitation(forces, chain))
    varying = np.array(
        [cf.transient.steady_cycle(turning, float(speed)).phasors([8.0])[0] for speed in speeds]
    )
    cf.pictures.plot_transient_over_speed(
        HERE / "transient_secondary.svg",
        speeds,
        {
            "inertia of pistons and rods at its mean": _twist(mean.motion[7]),
            "inertia by each throw's own angle": _twist(varying),
        },
        label="order 8: twist of the crankshaft [mrad]",
        title="Secondary resonance of a slow two-stroke six: order 8 where order 6 is critical",
    )


def _twist(motion: np.ndarray) -> np.ndarray:
    """Return the twist between first cylinder and flywheel [mrad]."""
    return np.asarray(1e3 * np.abs(motion[:, 0] - motion[:, 6]))


if __name__ == "__main__":
    with cf.replacing_files():
        draw_run_up()
        draw_secondary_resonance()
