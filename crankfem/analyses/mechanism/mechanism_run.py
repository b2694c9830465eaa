"""Everything about an engine's crank mechanism at one speed: forces, loads, torque, work, balance."""

from collections.abc import Sequence
from typing import Annotated, Any, Literal, get_args

import numpy as np

from crankbase.choices import check_choice, check_kind, check_not_given, is_whole
from crankbase.errors import InputError
from crankbase.frames import Axes, table
from crankbase.results import Quantity, Result, result
from crankbase.summaries import frozen
from crankfem.analyses.engine_mechanism import (
    full_load_only,
    pressures_at,
    with_throws,
)
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.full_load import by_gas
from dynamics.balance import Balance, HingedRodEffects, balance, hinged_rod_effects
from dynamics.engine import RodModelName
from dynamics.engine.forces import (
    LoadDiagram,
    MechanismForces,
    crankpin_loads,
    main_bearing_loads,
    mechanism_forces,
    motored_pressures,
    pin_groups,
    piston_ends,
)
from dynamics.engine.layout import EngineLayout
from dynamics.gas.pressure import ATMOSPHERE, GasPressure, indicated_mean_effective_pressure
from dynamics.torque import (
    DEFAULT_SAMPLES,
    EngineTorque,
    check_energy,
    engine_torque,
    samples_and_gas,
)
from geometry.mass import MassProperties

Shown = Literal[
    "torque", "forces", "pressure", "crankpin", "bearing", "force balance", "moment balance"
]
SHOWN: tuple[Shown, ...] = get_args(Shown)
BALANCE_ORDERS = (1, 2, 4)


Pascal = Annotated[float, Quantity("Pa")]
Newton = Annotated[float, Quantity("N")]


@result("peak_pressure", "work", "mean_effective_pressure", eq=True)
class CylinderWork(Result):
    """Results of the gas in one cylinder, and its largest forces.

    Parameters
    ----------
    peak_pressure, peak_angle_deg : float
        Absolute [Pa], and its angle from the firing top [deg].
    work : float
        Indicated work of one cycle [J].
    mean_effective_pressure : float
        Indicated [Pa].
    """

    cylinder: int
    peak_pressure: Pascal
    peak_angle_deg: Annotated[float, Quantity("deg")]
    work: Annotated[float, Quantity("J", key="indicated_work")]
    mean_effective_pressure: Pascal
    largest_side_force: Newton
    largest_piston_pin_force: Newton
    largest_tangential_force: Newton


@frozen(
    "engine_file.engine.name",
    "speed [rad/s]",
    "torque: torque.mean [N m]",
    "torque.power [W]",
    "crankpins",
    "bearings",
    eq=False,
)
class MechanismRun:
    """Forces in an engine's mechanism over one cycle at constant speed.

    Parameters
    ----------
    layout : EngineLayout
        With the unbalance of the throws.
    speed : float
        [rad/s]
    hinged_rods : tuple of HingedRodEffects
        Of the first crankpin with such rods; empty if there is none.
    """

    engine_file: EngineFile
    layout: EngineLayout
    speed: float
    pressure: tuple[GasPressure, ...]
    forces: MechanismForces
    torque: EngineTorque
    crankpins: tuple[LoadDiagram, ...]
    bearings: tuple[LoadDiagram, ...]
    works: tuple[CylinderWork, ...]
    balance: Balance
    hinged_rods: tuple[HingedRodEffects, ...]

    def plot(
        self,
        axes: Axes | None = None,
        *,
        show: Shown = "torque",
        number: int | None = None,
        frame: Literal["crank", "engine"] | None = None,
    ) -> Axes:
        """Draw one diagram of the mechanism.

        Parameters
        ----------
        show : str
            "torque" of the engine; "forces" and "pressure" of a cylinder; the load of a "crankpin" or
            main "bearing"; "force balance" or "moment balance": residual inertia effects.
        number : int, optional
            Of the cylinder, crankpin or bearing, from 1 at the free end, the first by default; torque
            and balance are those of the whole engine.
        frame : {"crank", "engine"}, optional
            Draw the load of a crankpin or bearing as a polar diagram in this frame.

        Raises
        ------
        InputError
            If an option is unknown or not applicable, or there is no such number.
        """
        check_choice("show", show, SHOWN, "these are diagrams of a mechanism")
        if show not in ("crankpin", "bearing"):
            check_not_given("frame", frame, show, "only loads of bearings have a frame")
        if show in ("torque", "force balance", "moment balance"):
            check_not_given("number", number, show, "it is that of the whole engine")
            if show == "torque":
                return self.torque.plot(axes)
            return self.balance.plot(axes, show="force" if show == "force balance" else "moment")
        if show in ("forces", "pressure"):
            place = _place(number, len(self.pressure), "the cylinders")
            if show == "forces":
                return self.forces.plot(axes, place + 1)
            return self.pressure[place].plot(axes)
        loads = self.crankpins if show == "crankpin" else self.bearings
        return loads[_place(number, len(loads), f"the {show}s")].plot(axes, frame=frame)

    def to_pandas(self) -> Any:
        """Return a table of the gas results, a row for each cylinder.

        Units are in ``frame.attrs["units"]``.
        """
        works = self.works
        return table(
            {
                "cylinder": (list(range(1, len(works) + 1)), "1"),
                "peak_pressure": ([work.peak_pressure for work in works], "Pa"),
                "peak_angle": ([work.peak_angle_deg for work in works], "deg"),
                "work": ([work.work for work in works], "J"),
                "mean_effective_pressure": ([work.mean_effective_pressure for work in works], "Pa"),
            }
        )

    def to_xarray(self) -> Any:
        """Return the forces of all cylinders over the cycle; see `MechanismForces.to_xarray`."""
        return self.forces.to_xarray()


def run_mechanism(
    engine_file: EngineFile,
    speed: float | None = None,
    model: RodModelName = "rigid",
    *,
    motored: bool = False,
    masses: MassProperties | Sequence[MassProperties] | None = None,
) -> MechanismRun:
    """Calculate an engine's mechanism at constant speed.

    Parameters
    ----------
    engine_file : EngineFile
        From `load_mechanism`, or a whole engine from `load_engine`.
    speed : float, optional
        [rad/s]; the rated speed by default.
    model : str, optional
        Of the rods' masses.
    motored : bool, optional
        Motor the engine without combustion.
    masses : MassProperties or sequence of such, optional
        Of the throw, or of each crank's throw from the free end; by default from their solids.

    Raises
    ------
    InputError
        If the file has no gas pressure, or the speed is not above zero.
    MeshError
        If the throw's solid, needed for its unbalance, cannot be built.
    """
    allowed = "what load_engine or load_mechanism returns"
    check_kind("engine_file", engine_file, EngineFile, allowed)
    if engine_file.gas is None:
        raise InputError(
            f"{engine_file.path.name}: given no section [gas]; allowed is one with peak_pressure, "
            "mean_effective_pressure or pressure_table, because gas loads the mechanism."
        )
    if motored and engine_file.power is not None and engine_file.power.driven:
        raise InputError(
            "motored: given for a machine that is driven; allowed is an engine, because nothing burns in "
            "this one."
        )
    turning = engine_file.engine.rated_speed if speed is None else speed
    layout = with_throws(engine_file, masses)
    if not full_load_only(engine_file):
        pressure = pressures_at(engine_file, [turning], motored=motored)[0]
    elif motored:
        pressure = by_gas(engine_file.gas, layout, motored_pressures)
    else:
        pressure = engine_file.pressure
    angles, gas = samples_and_gas(layout, pressure, DEFAULT_SAMPLES, ATMOSPHERE)
    torque = engine_torque(layout, turning, gas, model=model, throws=engine_file.throws)
    check_energy(torque)
    forces = mechanism_forces(
        layout, turning, gas, model=model, shaft_angles_deg=np.degrees(angles)
    )
    works = []
    largest = (
        np.abs(force).max(axis=1) for force in (forces.side, forces.piston_pin, forces.tangential)
    )
    rows = zip(pressure, torque.indicated_work.tolist(), *largest, strict=True)
    for number, (of_cylinder, work, *peaks) in enumerate(rows, start=1):
        low, high = piston_ends(torque.engine, number)
        swept = torque.engine.cylinders[number - 1].area * (high - low)
        works.append(
            CylinderWork(
                number,
                of_cylinder.peak_pressure,
                of_cylinder.peak_angle_deg,
                work,
                indicated_mean_effective_pressure(work, swept),
                *map(float, peaks),
            )
        )
    group = hinged_group(layout)
    return MechanismRun(
        engine_file=engine_file,
        layout=layout,
        speed=turning,
        pressure=pressure,
        forces=forces,
        torque=torque,
        crankpins=crankpin_loads(forces),
        bearings=main_bearing_loads(forces, engine_file.bearing_positions),
        works=tuple(works),
        balance=balance(
            layout,
            turning,
            BALANCE_ORDERS,
            about=0.5 * engine_file.bearing_positions[-1],
            model="two-mass" if model == "two-mass" else "rigid",
        ),
        hinged_rods=hinged_rod_effects(layout, turning, cylinders=group) if group else (),
    )


def _place(number: int | None, count: int, what: str) -> int:
    """Return an index from 0 for a number from 1; the first by default."""
    if number is None:
        return 0
    if not is_whole(number) or not 1 <= number <= count:
        raise InputError(
            f"number: given {number!r}; allowed is 1 to {count} for {what}, because there are that many."
        )
    return number - 1


def hinged_group(layout: EngineLayout) -> tuple[int, ...]:
    """Return the cylinders of the first crankpin with hinged rods, if any."""
    return next((group for group in pin_groups(layout) if len(group) > 1), ())
