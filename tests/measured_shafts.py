"""Simulated measurements on the six-cylinder chain: truth from the prior, noise, wheels, windows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from crankfem.files.chain.chain_file import load_chain
from crankfem.satellites.measured.calibration.fit import Observation, Problem
from crankfem.satellites.measured.calibration.groups import Group, chain_group, excitation_group
from crankfem.satellites.measured.calibration.response_slopes import Excitation, Sensor, Shaft
from crankfem.satellites.measured.measured_orders import MeasuredOrders

CHAIN = load_chain("mwm-six").chain
CYLINDERS = tuple(f"cylinder {number}" for number in range(1, 7))
NODES = tuple(CHAIN.names.index(name) for name in CYLINDERS)
# Fires 1-5-3-6-2-4, 120 deg apart.
FIRING = 2.0 * np.pi * 2.0 / 6.0 * np.array([0, 4, 2, 5, 1, 3])
ALL_ORDERS = np.arange(1, 25) / 2.0
PULLEY, FLYWHEEL = Sensor(0), Sensor(8)


def gas_orders(orders):
    """Amplitudes of a cylinder's torque [N m]: falling with the order as those of a diesel do."""
    return 900.0 / (1.0 + (orders / 2.5) ** 2) * np.exp(1j * (0.4 - 0.35 * orders))


def excitation(orders, speed, inertial: bool = False) -> Excitation:
    """Gas torques of six cylinders, and perhaps inertia torques of orders 1 to 4, which have no gain.

    Without them all inertias, stiffnesses, absolute dampings and torques times one factor vibrate alike.
    """
    every, over = np.tile(orders, speed.size), np.repeat(speed, orders.size)
    turned = np.exp(-1j * np.outer(every, FIRING))
    inertia = np.select([every == k for k in (1, 2, 3, 4)], [0.01, -0.04, -0.03, -0.003], 0.0)
    fixed = np.zeros((every.size, len(CHAIN.names)), dtype=complex)
    fixed[:, NODES] = inertial * (-1j * inertia * over**2)[:, None] * turned
    return Excitation(fixed, gas_orders(every)[:, None] * turned, NODES)


def usual_groups() -> tuple[Group, ...]:
    """Eight groups; inertias, stiffnesses, absolute dampings and torques times one factor tell nothing."""
    every = ", ".join(CYLINDERS)
    rest = ", ".join(CHAIN.elements[2:])
    tolerances = {
        "inertia of flywheel": 0.04,
        "inertia of pulley, gear train": 0.10,
        f"inertia of {every}": 0.05,
        f"stiffness of {CHAIN.elements[0]}, {CHAIN.elements[1]}": 0.20,
        f"stiffness of {rest}": 0.10,
        "loss factor": 0.6,
        "ground damping": 0.6,
    }
    groups = [chain_group(CHAIN, name, tolerance) for name, tolerance in tolerances.items()]
    return (*groups, excitation_group("gas torque", 6, range(6), 0.10))


def shaft(groups: Sequence[Group] | None = None) -> Shaft:
    return Shaft(CHAIN, tuple(usual_groups() if groups is None else groups), 6)


def windows(count: int, shared: float) -> np.ndarray:
    """Correlation of windows that share a part with the next one."""
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    return np.maximum(0.0, 1.0 - apart * (1.0 - shared))


def observed(
    of: Shaft,
    truth,
    sensor: Sensor,
    rng,
    *,
    speed=None,
    orders=ALL_ORDERS,
    noise: float = 0.05,
    wheel: float = 0.0,
    shared: float = 0.0,
    outliers: float = 0.0,
    floor: bool = False,
    inertial: bool = False,
) -> Observation:
    """Measure a shaft: each part of an order has `noise` of its root mean square over the speeds.

    With a `floor` of that of all orders at least: of a healthy engine many orders nearly vanish. Whole orders
    hold a constant of `wheel` times theirs; windows share a part of their revolutions.
    """
    speed = np.linspace(70.0, 260.0, 60) if speed is None else np.asarray(speed, dtype=float)
    orders = np.asarray(orders, dtype=float)
    whole = orders % 1.0 == 0.0
    acting = excitation(orders, speed, inertial)
    correlation = windows(speed.size, shared)
    measured = MeasuredOrders(
        orders=orders,
        speed=speed,
        amplitude=np.zeros((speed.size, orders.size), dtype=complex),
        scatter=np.ones((speed.size, orders.size)),
        place=(CHAIN.names if sensor.kind == "node" else CHAIN.elements)[sensor.place],
        quantity="angle" if sensor.kind == "node" else "torque",
        correlation=correlation,
        ramp=np.zeros(speed.size),
        wheel_constant=whole & (wheel > 0.0),
        cycle=2,
        zero_known=True,
    )
    still = Observation(measured, sensor, acting)
    true, _ = Problem(of, (still,)).predicted(np.asarray(truth, dtype=float), 0)
    size = np.sqrt(np.mean(np.abs(true) ** 2, axis=0))
    if floor:
        size = np.maximum(size, np.sqrt(np.mean(size**2)))
    scatter = np.broadcast_to(noise * size, true.shape)
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    parts = rng.normal(size=(2, *true.shape))
    off = scatter * (root @ parts[0] + 1j * (root @ parts[1]))
    off[rng.uniform(size=true.shape) < outliers] *= 20.0
    pitch = rng.normal(size=orders.size) + 1j * rng.normal(size=orders.size)
    off += whole * wheel * size * pitch
    return replace(still, measured=replace(measured, amplitude=true + off, scatter=scatter))
