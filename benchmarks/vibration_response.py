"""Forced torsional vibration of an engine beside openTorsion: equal results, and the time of both.

Run by hand (10 seconds on one core), where openTorsion is installed besides crankfem::

    pip install opentorsion
    python benchmarks/vibration_response.py

It prints a Markdown table and ends with an error where results differ or the promise is missed. All
ways take turns in one run, and the ratio of their medians is told.

The case is the MWM six-cylinder diesel of Mendes, Meirelles, Zampieri 2008 (doi
10.1243/14644193JMBD126): 9 inertias, absolute damping of 2 N m s/rad at each cylinder, loss factor
0.035 on each shaft, 24 orders at 400 speeds. openTorsion answers by `Assembly.ss_response`, all
frequencies in one call; its way to a damping that depends on frequency is a function C(w), which
here adds a matrix made beforehand, divided by w. In both, the shaft is described before the clock
starts; the damped modes are found while it runs.
"""

import os
import sys
import time
from collections.abc import Callable
from statistics import median

import numpy as np

from dynamics.chains.chain import Chain
from dynamics.response.forced import forced_response
from dynamics.response.order_excitation import OrderExcitation

INERTIA = (0.0170, 0.0090, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.0750)
STIFFNESS = tuple(1e6 * k for k in (1.106, 1.631, 1.253, 1.253, 1.678, 1.253, 1.253, 1.976))
CYLINDERS = range(2, 8)
FIRING = np.radians(120.0) * np.array([0, 4, 2, 5, 1, 3])
ABSOLUTE, LOSS_FACTOR = 2.0, 0.035
ORDERS = 0.5 * np.arange(1, 25)
SPEEDS = np.linspace(800.0, 3000.0, 400) * np.pi / 30.0
ROUNDS = 11
# How many times as fast the modal form must be, and should be on an idle machine; and how far
# results may differ (of the largest amplitude at that order and speed). All solve the same equations
# in double precision; near resonance and at low frequencies their condition number is 1e3 to 1e4,
# which leaves 1e-12.
LEAST_RATIO, AIM = 8.0, 30.0
EQUAL = 1e-11
# One thread for all: on matrices of nine rows more of them only wait for each other.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def excitation() -> OrderExcitation:
    """A torque at each cylinder that falls with the order and has a phase of its own."""
    own = 900.0 / (1.0 + 0.2 * ORDERS**2) * np.exp(0.4j * ORDERS)
    forces = np.zeros((ORDERS.size, SPEEDS.size, len(INERTIA)), dtype=complex)
    turned = np.exp(-1j * np.outer(ORDERS, FIRING))
    forces[:, :, list(CYLINDERS)] = (own[:, np.newaxis] * turned)[:, np.newaxis, :]
    return OrderExcitation(ORDERS, SPEEDS, forces)


def openTorsion_answer(excited: OrderExcitation) -> Callable[[], np.ndarray]:
    try:
        import opentorsion
    except ImportError:
        raise SystemExit("openTorsion is missing; pip install opentorsion") from None
    shafts = [opentorsion.Shaft(i, i + 1, k=k) for i, k in enumerate(STIFFNESS)]
    disks = [
        opentorsion.Disk(i, I=inertia, c=ABSOLUTE if i in CYLINDERS else 0.0)
        for i, inertia in enumerate(INERTIA)
    ]
    assembly = opentorsion.Assembly(shafts, disk_elements=disks)
    viscous, hysteretic = assembly.C, LOSS_FACTOR * assembly.K
    frequencies = excited.angular_frequencies.ravel()
    forces = np.ascontiguousarray(excited.forces.reshape(frequencies.size, -1).T)

    def answer() -> np.ndarray:
        motion, _ = assembly.ss_response(
            forces, frequencies, C_func=lambda w: viscous + hysteretic / w
        )
        return motion.T.reshape(excited.forces.shape)

    return answer


def main() -> None:
    excited = excitation()
    chain = Chain(
        INERTIA,
        STIFFNESS,
        loss_factor=LOSS_FACTOR,
        ground_damping=dict.fromkeys(CYLINDERS, ABSOLUTE),
    )
    ways = {
        "openTorsion": openTorsion_answer(excited),
        "crankfem, direct": lambda: forced_response(chain, excited, method="direct").motion,
        "crankfem, modal": lambda: forced_response(chain, excited).motion,
    }
    times: dict[str, list[float]] = {name: [] for name in ways}
    answers = {name: way() for name, way in ways.items()}
    for _ in range(ROUNDS):
        for name, way in ways.items():
            start = time.perf_counter()
            way()
            times[name].append(time.perf_counter() - start)
    peer = answers["openTorsion"]
    largest = np.max(np.abs(peer), axis=2, keepdims=True)
    slowest = median(times["openTorsion"])
    print("| way | median [ms] | least [ms] | times as fast | differs by |\n|---|---|---|---|---|")
    kept = True
    for name, own in times.items():
        differ = float(np.max(np.abs(answers[name] - peer) / largest))
        ratio = slowest / median(own)
        kept &= differ <= EQUAL
        kept &= not name.endswith("modal") or ratio >= LEAST_RATIO
        print(
            f"| {name} | {1e3 * median(own):.1f} | {1e3 * min(own):.1f} | {ratio:.1f} | "
            f"{differ:.0e} |"
        )
        if name.endswith("modal"):
            aim = f"{AIM:g} times as fast: " + ("reached" if ratio >= AIM else "missed")
    print(f"\n{aim}")
    if not kept:
        raise SystemExit("results differ, or slower than promised")


if __name__ == "__main__":
    # The libraries read this when they are loaded, so that the program starts anew with it.
    if not os.environ.items() >= ONE_THREAD.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | ONE_THREAD)
    main()
