"""A motor-driven compressor and a geared set with a soft coupling.

Source: slider-crank, chains and their dynamic stiffness written anew with numpy from the files' values;
compliances, masses and gas pressure are taken as numbers.

Tolerance: 1e-6 of sums that cancel, as files give angles with ten digits; 1e-5 of largest values, read at
20,000 angles; the rest is round-off.

Both sides sample pressures four times a degree.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close

FOLDER = Path(__file__).parents[1] / "data" / "engines"
NAMES = ("3-250-200-compressor", "geared-set")
ATMOSPHERE = 101325.0
STEPS = 1440  # a revolution
RPM = 30.0 / np.pi


@dataclass
class Machine:
    """A run, and what our own models take of it as numbers."""

    run: cf.EngineVibration

    def __post_init__(self):
        self.file = self.run.engine_file
        self.engine = self.file.engine
        self.radius, self.rod = self.file.throw.crank_radius, self.file.rod
        self.area = 0.25 * np.pi * self.engine.bore**2
        self.cranks = self.engine.cylinders
        self.orders = np.arange(1, 1 + 6 * self.engine.strokes) * 2.0 / self.engine.strokes
        throw = next(iter(self.run.analyses.values()))
        self.throw_mass = throw.mass
        self.throw_inertia = throw.masses.inertia_about_shaft
        self.moved = self.file.piston.mass + self.rod.mass - self.rod.rotating_mass
        turns = self.engine.strokes // 2
        self.angle = 2.0 * np.pi / STEPS * np.arange(STEPS * turns)
        self.top = -np.array(self.engine.crank_angles) * self.engine.turning_sense
        if turns == 2:  # each fires at the first of its tops after the one before
            last = -1e-9
            for number in self.engine.firing_order:
                while self.top[number - 1] < last:
                    self.top[number - 1] += 2.0 * np.pi
                last = self.top[number - 1]
        self.set_phasors()

    def slope(self, values):
        """Derivative of a periodic series by the shaft angle."""
        spectrum = np.fft.rfft(values)
        return np.fft.irfft(
            1j * np.arange(spectrum.size) / (self.engine.strokes // 2) * spectrum, values.size
        )

    def pressure(self):
        """Absolute, from the top."""
        gas = self.file.gas
        if gas.discharge_pressure is None:
            return self.file.pressure[0].at(angle_deg=np.degrees(self.angle))
        swept = 2.0 * self.radius * self.area
        clearance = gas.clearance * swept
        volume = clearance + self.area * self.travel()
        n, low, high = gas.exponent, gas.suction_pressure, gas.discharge_pressure
        return np.where(
            self.angle < np.pi,
            np.maximum(low, high * (clearance / volume) ** n),
            np.minimum(high, low * ((clearance + swept) / volume) ** n),
        )

    def travel(self):
        """Of the piston from its top."""
        along = np.sqrt(self.rod.length**2 - (self.radius * np.sin(self.angle)) ** 2)
        return self.radius + self.rod.length - self.radius * np.cos(self.angle) - along

    def parts(self):
        """Force along the cylinder by gas, and by the moving mass at unit speed; how it acts on the crank.

        It acts by a torque, and by a radial force towards the shaft, each per unit force.
        """
        first = self.slope(self.travel())
        tilt = np.arcsin(self.radius / self.rod.length * np.sin(self.angle))
        gas = (self.pressure() - ATMOSPHERE) * self.area
        moved = -self.moved * self.slope(first)
        return gas, moved, {"torque": first, "radial": np.cos(self.angle + tilt) / np.cos(tilt)}

    def set_phasors(self):
        """Phasors of each order from the cylinder's top: by gas, and by mass at unit speed."""
        gas, moved, ways = self.parts()
        waves = 2.0 / self.angle.size * np.exp(-1j * np.outer(self.orders, self.angle))
        self.known = {
            name: (waves @ (gas * way), waves @ (moved * way)) for name, way in ways.items()
        }

    def phasors(self, name, speed, order):
        """Phasor of torque or radial force at every crank."""
        gas, moved = (of[np.searchsorted(self.orders, order)] for of in self.known[name])
        return (gas + speed**2 * moved) * np.exp(-1j * order * self.top)


def torsional_model(machine):
    """Mass, complex stiffness and viscous damping, and each element's row and complex stiffness."""
    file, compliance = machine.file, machine.run.shaft.torsional
    crank = (
        machine.throw_inertia + (file.rod.rotating_mass + 0.5 * machine.moved) * machine.radius**2
    )
    inertia = [file.free_end.inertia, *[crank] * machine.cranks, file.flywheel.inertia]
    halves = 0.5 * compliance
    joined = [halves[0], *(halves[:-1] + halves[1:]), halves[-1]]
    eta = file.damping.loss_factor
    springs = [(k, k + 1, 1.0, (1.0 + 1j * eta) / joined[k]) for k in range(len(joined))]
    last, damper = len(inertia) - 1, None
    if file.driver is not None:
        inertia.append(6.0)
        springs.append((last, last + 1, 1.0, 12e3 * (1.0 + 0.8j / (2.0 * np.pi))))
    else:  # coupling, gear and generator; the wheel turns at -1/1.2 of the pinion
        ratio = -0.8333333333
        inertia[last] += 0.3
        inertia += [0.12 + ratio**2 * 0.25, 5.6, 0.18]
        springs += [
            (last, last + 1, 1.0, 7.4e3 * (1.0 + 0.16j)),
            (last + 1, last + 2, ratio, 600e3 * (1.0 + 0.01j)),
        ]
        damper = (0, last + 3, 120.0)
    size = len(inertia)
    stiffness, damping, rows = np.zeros((size, size), complex), np.zeros((size, size)), []
    for left, right, ratio, spring in springs:
        row = np.zeros(size)
        row[left], row[right] = -ratio, 1.0
        stiffness += spring * np.outer(row, row)
        rows.append((row, spring))
    if damper is not None:
        row = np.zeros(size)
        row[damper[0]], row[damper[1]] = -1.0, 1.0
        damping += damper[2] * np.outer(row, row)
    return np.diag(inertia), stiffness, damping, rows


def frequencies(mass, stiffness):
    root = 1.0 / np.sqrt(np.diag(mass))
    values = np.linalg.eigvalsh(root[:, None] * stiffness.real * root)
    return np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)


def torsional_motion(machine, model, speed, order):
    mass, stiffness, damping, _ = model
    torque = np.zeros(len(mass), complex)
    torque[1 : 1 + machine.cranks] = machine.phasors("torque", speed, order)
    w = order * speed
    return np.linalg.solve(stiffness + 1j * w * damping - w**2 * mass, torque)


def half_range(phasors, orders):
    """Half of the range over the cycle of a sum of orders."""
    angle = np.linspace(0.0, 4.0 * np.pi, 40001)
    waves = np.real(np.exp(1j * np.outer(angle, orders)) @ phasors)
    return 0.5 * np.ptp(waves, axis=0)


@pytest.fixture(scope="module", params=NAMES)
def machine(request):
    engine = cf.load_engine(FOLDER / f"{request.param}.toml")
    throw = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)
    return Machine(cf.engine_vibration(engine, analysis=throw))


@pytest.mark.further
def test_power_is_that_of_the_indicator_diagram(machine, figure):
    gas, _, ways = machine.parts()
    work = machine.cranks * np.sum(gas * ways["torque"]) * 2.0 * np.pi / STEPS
    cycles = machine.engine.rated_speed / (np.pi * machine.engine.strokes)
    power = machine.run.load.rated
    figure("indicated power", power.indicated, work * cycles, 1e-9, "W")
    by_size = sorted((abs(power.indicated), machine.engine.rated_power))
    assert power.mechanical_efficiency == close(by_size[0] / by_size[1], 1e-9)
    assert (power.indicated < 0.0) == bool(machine.engine.driven_by)


@pytest.mark.further
def test_frequencies(machine, figure):
    mass, stiffness, _, _ = torsional_model(machine)
    found = machine.run.torsional.chosen.modes.frequencies
    figure(
        "torsional frequencies", found, frequencies(mass, stiffness), 1e-8, "Hz", scale=found[-1]
    )
    mass, stiffness, _ = axial_model(machine)
    found = machine.run.axial.chosen.modes.frequencies
    figure("axial frequencies", found, frequencies(mass, stiffness), 1e-8, "Hz", scale=found[-1])


@pytest.mark.further
def test_torques_of_shaft_and_coupling(machine, figure):
    model, forced = torsional_model(machine), machine.run.forced_torsional
    elements = forced.loads.elements
    for place in range(0, forced.speeds.size, 37):
        speed = forced.speeds[place]
        motion = np.array([torsional_motion(machine, model, speed, r) for r in machine.orders])
        torque = np.stack([spring * (motion @ row) for row, spring in model[3]], axis=1)
        found = np.abs(elements.values[:, place])
        figure("torque by orders", found, np.abs(torque), 1e-6, "N m", scale=np.abs(torque).max())
        whole = half_range(torque, machine.orders)
        figure(
            "torque, all orders",
            elements.synthesis.amplitude[place],
            whole,
            1e-5,
            "N m",
            scale=whole.max(),
        )


def axial_model(machine):
    """Mass, stiffness with the thrust bearing, and damping by the magnifier of each mode."""
    file, compliance = machine.file, machine.run.shaft.axial
    count = machine.cranks + 1
    mass = np.full(count, machine.throw_mass)
    mass[[0, -1]] *= 0.5
    mass[0] += file.free_end.mass
    mass[-1] += file.flywheel.mass
    stiffness = np.zeros((count, count))
    for throw, e in enumerate(compliance):
        stiffness[throw : throw + 2, throw : throw + 2] += np.array([[1.0, -1.0], [-1.0, 1.0]]) / e
    stiffness[file.thrust_bearing.main_bearing - 1, file.thrust_bearing.main_bearing - 1] += (
        file.thrust_bearing.stiffness
    )
    root = np.sqrt(mass)
    squares, modes = np.linalg.eigh(stiffness / np.outer(root, root))
    ratio = 0.5 / file.damping.axial_magnifier
    damping = np.outer(root, root) * ((modes * (2.0 * ratio * np.sqrt(squares))) @ modes.T)
    return np.diag(mass), stiffness, damping


def throw_forces(machine, model, speed, order):
    """Force with which each throw pushes its ends apart: by radial forces, and by torques in the shaft."""
    shaft, radius = machine.run.shaft, machine.radius
    radial = machine.phasors("radial", speed, order)
    motion = torsional_motion(machine, model, speed, order)
    parts = np.array([spring.real * (row @ motion) for row, spring in model[3]])[
        : machine.cranks + 1
    ]
    pins = (parts[:-1] - parts[1:]) / radius
    lengthening = shaft.influence @ radial + shaft.tangential @ pins + shaft.through * parts[-1]
    return lengthening / shaft.axial


@pytest.mark.further
def test_axial_motion_and_forces(machine, figure):
    torsional, (mass, stiffness, damping) = torsional_model(machine), axial_model(machine)
    forced, e = machine.run.forced_axial, machine.run.shaft.axial
    response, elements = forced.response, forced.crank_elements
    for place in range(0, response.speeds.size, 37):
        speed = response.speeds[place]
        forces = []
        for row, order in enumerate(machine.orders):
            pushed = throw_forces(machine, torsional, speed, order)
            acting = np.concatenate([[0.0], pushed]) - np.concatenate([pushed, [0.0]])
            w = order * speed
            motion = np.linalg.solve(stiffness + 1j * w * damping - w**2 * mass, acting)
            forces.append(np.diff(motion) / e - pushed)
            found = np.abs(response.motion[row, place])
            largest = np.abs(response.motion).max()
            figure("axial motion", found, np.abs(motion), 1e-6, "m", scale=largest)
        whole = half_range(np.array(forces), machine.orders)
        found = elements.synthesis.amplitude[place]
        figure("axial force of throws", found, whole, 1e-5, "N", scale=whole.max())


@pytest.mark.further
def test_axial_force_is_what_accelerates_the_masses_before_a_throw(machine, figure):
    mass, _, damping = axial_model(machine)
    forced = machine.run.forced_axial
    response = forced.response
    w, motion = response.angular_frequencies[:, :, np.newaxis], response.motion
    moved = -(w**2) * (motion @ mass) + 1j * w * (motion @ damping)
    found = forced.crank_elements.values
    springs = np.abs(np.diff(motion, axis=2) / machine.run.shaft.axial).max()
    expected = np.cumsum(moved, axis=2)[:, :, :-1]
    figure("force by motion", found, expected, 1e-9, "N", scale=springs)


@pytest.mark.further
def test_the_coupling_swings_below_idle(machine, figure):
    """By the lowest order at which all cylinders act together; rubber moves its peak by up to 2 %."""
    model, forced = torsional_model(machine), machine.run.forced_torsional
    engine = machine.engine
    coupling = next(
        place
        for place, name in enumerate(forced.loads.elements.names)
        if name in ("flywheel - motor", "flywheel - pinion")
    )
    major = 2.0 * engine.cylinders / engine.strokes
    row, spring = model[3][coupling]
    speeds = np.linspace(0.1, 1.0, 4001) * engine.lowest_speed
    torque = [abs(spring * (row @ torsional_motion(machine, model, v, major))) for v in speeds]
    top = speeds[int(np.argmax(torque))]
    mode = frequencies(*model[:2])
    mode = mode[mode > 1.0][0]
    figure("critical speed of the coupling", top, 2.0 * np.pi * mode / major, 2e-2, "rad/s")
    assert top < 0.5 * engine.lowest_speed
    running = forced.speed_parts["running"]
    told = forced.loads.elements.synthesis.amplitude[running, coupling].max()
    assert told < 0.1 * max(torque)


@pytest.mark.further
@pytest.mark.parametrize("machine", ["geared-set"], indirect=True)
def test_a_half_order_has_its_critical_speed_where_the_coupling_swings(machine, figure):
    """The throws' torque of this order is static but for a thousandth, and no peak of the coupling's mode."""
    model, forced = torsional_model(machine), machine.run.forced_torsional
    (peak,) = (one for one in forced.resonances if one.order == 0.5 and one.of_load)
    assert peak.place == "flywheel - pinion"
    assert peak.mode_share > 0.9
    row, spring = model[3][forced.loads.elements.names.index(peak.place)]
    speeds = peak.speed * np.linspace(0.9, 1.1, 2001)
    torque = [abs(spring * (row @ torsional_motion(machine, model, v, 0.5))) for v in speeds]
    figure("critical speed, half order", peak.speed, speeds[int(np.argmax(torque))], 2e-4, "rad/s")
    # What strains the element is its stiffness times its twist, 1.3 % less than with its damping.
    largest = max(torque) * spring.real / abs(spring)
    figure("torque of the half order", peak.amplitude, largest, 1e-4, "N m")
