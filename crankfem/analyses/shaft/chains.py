"""The axial and the torsional chain of an engine file, with all bodies attached to them."""

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.quantity import UNITS, VIBRATING, significant, unit_symbol
from crankbase.sentences import amount, finished
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.files.chain.chain_file import PLANT, plant_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.sections.engine_sections import Flywheel, ThrustBearing
from crankfem.files.sections.mechanism_sections import load_points
from crankfem.files.sections.vibration_sections import ASSUMED_PER_DIAMETER
from dynamics import wording
from dynamics.chains.dampers import TorsionalDamper
from dynamics.chains.engine_chains import (
    EngineChain,
    Kind,
    axial_chain,
    throw_inertias,
    torsional_chain,
)
from dynamics.chains.shaft_line import DRIVEN, DrivenMachine
from dynamics.crankshaft.surroundings import AxialSupport, EndBody, MainBearings, ShaftSurroundings
from dynamics.response.linear_system import DEFAULT_MAGNIFIER, MAGNIFIER_SOURCE, DampedChain, damped
from geometry.mass import cylinder_mass_properties

# Points of the mean torque of the load over the speed, linear between.
TORQUES_OVER_SPEED = 241


def engine_axial_chain(
    engine_file: EngineFile, compliances: Array, throw_masses: ArrayLike
) -> EngineChain:
    """Masses at the main-journal middles of an engine, its thrust bearing and axial damper.

    Parameters
    ----------
    compliances : (n,) array
        Axial compliance of each throw in the shaft [m/N].
    throw_masses : float or (n,) array_like
        Of the throws [kg].
    """
    thrust, damper = engine_file.required(ThrustBearing), engine_file.axial_damper
    at_free_end = 0.0 if engine_file.free_end is None else engine_file.free_end.mass
    return axial_chain(
        compliances,
        np.broadcast_to(throw_masses, len(compliances)),
        engine_file.required(Flywheel).mass,
        thrust.section_index,
        thrust.stiffness,
        {0: at_free_end},
        damper=None if damper is None else damper.damper(),
        shaft_line=engine_file.shaft_lines.get("axial"),
    )


def engine_throw_inertias(engine_file: EngineFile, solid_inertias: ArrayLike) -> Array:
    """Inertia of each throw with its rods and pistons [kg m^2], (n,).

    Parameters
    ----------
    engine_file : EngineFile
        Its section [vibration] selects the equivalent inertia of pistons.
    solid_inertias : float or (n,) array_like
        Of the throws' solids about the shaft, counterweights included [kg m^2].
    """
    return throw_inertias(
        engine_file.layout,
        solid_inertias,
        reciprocating=engine_file.vibration.reciprocating,
        throws=engine_file.throws,
    )


def engine_torsional_chain(
    engine_file: EngineFile, compliances: Array, inertias: Array
) -> EngineChain:
    """Cranks of an engine between free end and flywheel, with damper and driven machine.

    Parameters
    ----------
    compliances : (n,) array
        Torsional compliance of each throw [rad/(N m)].
    inertias : (n,) array
        Of the throws with their shares of rods and pistons [kg m^2].

    Returns
    -------
    EngineChain
        Of a plant whose maker gives it, that chain, for any throws.
    """
    free_end, damping = engine_file.free_end, engine_file.damping
    on_each = np.bincount(engine_file.throws)
    if PLANT in engine_file.shaft_lines:
        return plant_chain(engine_file.shaft_lines[PLANT], on_each.tolist())
    absolute = (
        0.0 if damping is None or damping.cylinder_damping is None else damping.cylinder_damping
    )
    loss = 0.0 if damping is None or damping.loss_factor is None else damping.loss_factor
    return torsional_chain(
        compliances,
        inertias,
        engine_file.required(Flywheel).inertia,
        0.0 if free_end is None else free_end.inertia,
        driven_machine(engine_file),
        loss_factor=loss,
        throw_damping=absolute * on_each,
        cylinders=on_each.tolist(),
        damper=torsional_damper(engine_file),
        shaft_line=engine_file.shaft_lines.get("torsional"),
    )


def driven_machine(engine_file: EngineFile) -> DrivenMachine | None:
    """Return the driven machine, or the prime mover of one.

    A coupling that varies over the mean torque carries that of the load, which is the rated torque times
    the load's share of it at each speed, unless the file gives another.
    """
    behind, engine, load = engine_file.behind_coupling, engine_file.engine, engine_file.load
    if behind is None:
        return None
    machine = DrivenMachine(**dict(behind), name=engine.driven_by or DRIVEN)
    coupling = machine.variation
    known = engine.rated_power is not None and engine_file.gas_map is None
    if coupling is None or coupling.torque is None or coupling.at_torque is not None or not known:
        return machine
    assert engine.rated_power is not None
    speeds = np.linspace(0.0, 1.2 * engine.highest_speed, TORQUES_OVER_SPEED)
    points = None if load is None else load_points(load)
    shares: Array = np.ones(speeds.size)
    if points is not None:
        mean, at_rated = (
            np.interp(at, points.speeds, points.mean_pressure)
            for at in (speeds, engine.rated_speed)
        )
        shares = np.asarray(mean / at_rated)
    elif load is not None and load.law == "propeller":
        shares = (speeds / engine.rated_speed) ** 2
    torques = engine.rated_power / engine.rated_speed * shares
    course = coupling.changed(at_speed=tuple(speeds.tolist()), at_torque=tuple(torques.tolist()))
    return machine.changed(variation=course)


def torsional_damper(engine_file: EngineFile) -> TorsionalDamper | None:
    """Return the damper at the free end, if the file has one.

    Raises
    ------
    InputError
        If there is no free end to carry it.
    """
    damper = engine_file.torsional_damper
    if damper is None:
        return None
    if engine_file.free_end is None:
        raise InputError(
            "torsional_damper: given without the section [free_end]; allowed are both, because the hub "
            "of the damper is part of the free end's inertia."
        )
    return damper.damper()


def magnifier_of(engine_file: EngineFile, kind: Kind) -> tuple[float | None, str, bool]:
    """Return the magnifier of the elastic modes, its source, and whether it is assumed.

    Without any damping in the file this is a measured value, marked as assumed; none if cylinders or
    throws have damping of their own.
    """
    damping = engine_file.damping
    if damping is not None:
        magnifier = damping.axial_magnifier if kind == "axial" else damping.torsional_magnifier
        if magnifier is not None:
            source, assumed = engine_file.provenance.get(f"damping.{kind}_magnifier", ("", False))
            return magnifier, f"assumed: {source}" if assumed else "engine file", assumed
        if kind == "torsional" and damping.damps_torsion:
            return None, "", False
    return DEFAULT_MAGNIFIER, f"assumed, {MAGNIFIER_SOURCE}", True


def magnifier_damping(engine_file: EngineFile, chain: EngineChain) -> tuple[Array | None, str]:
    """Return the share of critical damping that the magnifier adds to each elastic mode, in words too.

    An assumed magnifier stands for damping that nobody gives: it does not damp parts whose own is given.
    """
    magnifier, source, assumed = magnifier_of(engine_file, chain.kind)
    if magnifier is None:
        return None, ""
    modes = chain.chain.modes()
    undamped = np.ones(modes.frequencies.size - modes.rigid)
    apart = ""
    if assumed and np.any(damped_springs := chain.chain.damped_springs):
        undamped = modes.strain_shares[~damped_springs, modes.rigid :].sum(axis=0)
        apart = ", by its share of strain in parts without damping of their own"
    sentence = f"magnifier {magnifier:g} of every elastic mode{apart}: {source}"
    return 0.5 / magnifier * undamped, sentence


def damped_engine_chain(
    engine_file: EngineFile, chain: EngineChain, factor: float = 1.0
) -> DampedChain:
    """Return the chain with the damping of engine and shaft; dampers and couplings add theirs.

    `factor` is that of what the magnifier stands for, which is no part of the chain.
    """
    added, magnifier = magnifier_damping(engine_file, chain)
    added = None if added is None else factor * added
    unit = "N s/m" if chain.kind == "axial" else "N m s/rad"
    system = damped(chain.chain, modal_damping=added, unit=unit)
    return system if added is None else replace(system, record=(*system.record[:-1], magnifier))


class Motion(NamedTuple):
    """Motion of a node in one kind of vibration.

    Attributes
    ----------
    quantity : str
        Its name in diagrams.
    si : str
        Its unit in records.
    printed : str
        Its unit among those of `crankbase.table`.
    unit : str
        The same as written in diagrams and reports.
    size : float
        Of that unit, in SI.
    load, load_printed, inertia, stiffness, compliance : str
        Units of an element's load, in SI and as printed, and of a chain's other values.
    """

    quantity: Literal["displacement", "twist"]
    si: str
    printed: str
    unit: str
    size: float
    load: str
    load_printed: str
    inertia: str
    stiffness: str
    compliance: str

    def number(self, value: float, digits: int = 3) -> str:
        """Write an SI value in that unit, rounded to so many digits also before the point, as tables do."""
        return significant(float(f"{value / self.size:.{digits}g}"), digits)


def _motion(quantity: Literal["displacement", "twist"], *units: str) -> Motion:
    printed = VIBRATING[quantity]
    si, size = UNITS[printed]
    return Motion(quantity, si, printed, unit_symbol(printed), size, *units)


MOTION = {
    "axial": _motion("displacement", "N", "kN", "kg", "N/m", "m/N"),
    "torsional": _motion("twist", "N m", "kN m", "kg m^2", "N m/rad", "rad/(N m)"),
}


Remarks = tuple[str, ...]


def shaft_surroundings(
    engine_file: EngineFile, analysis: Analyses, bearings: MainBearings | None = None
) -> tuple[ShaftSurroundings, tuple[str, ...]]:
    """Return the surroundings of the throws, as the engine file gives them.

    Returns
    -------
    surroundings : ShaftSurroundings
        Without damping of the shaft itself.
    remarks : tuple of str
        Assumptions.
    """
    per_throw = len(engine_file.throw.parts.pins)
    each = crank_analyses(engine_file, analysis)
    solids = np.array([throw.masses.inertia_about_shaft for throw in each])
    rods = engine_throw_inertias(engine_file, solids) - solids
    at_each = np.repeat(rods / per_throw, per_throw) / engine_file.throw.crank_radius**2
    thrust, damper = engine_file.required(ThrustBearing), engine_file.axial_damper
    torsional, driven = engine_file.torsional_damper, driven_machine(engine_file)
    supports = [AxialSupport(thrust.section_index, thrust.stiffness)]
    if damper is not None:
        supports.append(AxialSupport(0, damper.stiffness, damper.damping))
    held = bearings
    first: Remarks = ()
    if held is None:
        stated = engine_file.main_bearings
        held = MainBearings(stated.stiffness, stated.damping, stated.variation)
        if not engine_file.bearings:
            first = (
                "main bearings are assumed to have a lateral stiffness of "
                f"{amount(stated.stiffness, 'N/m', 3)} each "
                f"(range {wording.stiffness_range(stated.lowest, stated.highest)}), "
                f"{amount(ASSUMED_PER_DIAMETER, 'N/m')} per m of journal diameter, and no damping; "
                "give the section [bearings]",
            )
    flywheel, second = _flywheel(engine_file)
    free_end, third = _free_end(engine_file)
    around = ShaftSurroundings(
        bearings=held,
        axial_supports=tuple(supports),
        flywheel=flywheel,
        free_end=free_end,
        ring=None if torsional is None else torsional.damper().ring,
        machine=None if driven is None else driven.ring,
        machine_name=DRIVEN if driven is None else driven.name,
        pin_masses=tuple(at_each.tolist()),
        torsional_line=engine_file.shaft_lines.get("torsional"),
        axial_line=engine_file.shaft_lines.get("axial"),
        line_beam=engine_file.line_beam,
    )
    fourth = _line(engine_file) if around.torsional_line or around.axial_line else ()
    return around, tuple(map(finished, (*first, *second, *third, *fourth)))


def _line(engine_file: EngineFile) -> Remarks:
    beam, known = engine_file.line_beam, {record.field for record in engine_file.records}
    if beam is None:
        return (wording.LINE_WITHOUT_BENDING,)
    given_places, given_stiffness = (
        any(field.startswith(f"shaft_line.{name}") for field in known)
        for name in ("bearings", "bearing_stiffness")
    )
    missing = {"axial": "mass across it", "torsional": "inertia about a diameter"}
    without = [what for kind, what in missing.items() if kind not in engine_file.shaft_lines]
    return wording.line_bends(
        beam.length, beam.bearings, given_places, given_stiffness, ASSUMED_PER_DIAMETER, without
    )


def flywheel_overhang(engine_file: EngineFile) -> tuple[float, bool]:
    """Return the flywheel's distance beyond the last main journal's middle [m], and whether it is given."""
    overhang = engine_file.required(Flywheel).overhang
    thickness = engine_file.shaft_ends.flange_thickness
    if overhang is not None:
        return overhang, True
    if thickness is not None:
        return thickness, False
    return 0.5 * engine_file.crank_throws[-1].main_journal_length, False


def _flywheel(engine_file: EngineFile) -> tuple[EndBody, Remarks]:
    flywheel = engine_file.required(Flywheel)
    overhang, known = flywheel_overhang(engine_file)
    beyond = f"{amount(overhang, 'm')} beyond"
    if known:
        where = f"{beyond} the last main journal's middle"
    elif engine_file.shaft_ends.flange_thickness is None:
        where = (
            "at the end of the last main journal (assumed, because no flange is given), "
            f"{beyond} its middle"
        )
    else:
        where = (
            f"at the far side of the flange, {beyond} the last main journal's "
            "middle; its mass includes that of the flange"
        )
    body = EndBody(flywheel.mass, flywheel.inertia, flywheel.diametral_inertia, overhang)
    kind = "a thin disc" if flywheel.diametral_inertia is None else "a body"
    return body, (f"the flywheel is {kind} {where}",)


def _free_end(engine_file: EngineFile) -> tuple[EndBody | None, Remarks]:
    """The stub of the shaft as a solid cylinder, and the inertia given for it."""
    free_end, ends = engine_file.free_end, engine_file.shaft_ends
    if free_end is None and ends.free_end_diameter is None:
        return None, ()
    remarks: Remarks = ()
    mass = polar = diametral = length = 0.0
    if ends.free_end_diameter is not None and ends.free_end_length is not None:
        length = ends.free_end_length
        stub = cylinder_mass_properties(
            ends.free_end_diameter, -length, 0.0, engine_file.material.density
        )
        mass, polar = stub.mass, float(stub.inertia[2, 2])
        diametral = float(stub.inertia[0, 0])
    if free_end is not None:
        across, missing = free_end.diametral_inertia, []
        if free_end.mass == 0.0:
            missing.append("has no mass of its own (free_end.mass)")
        if across is None:
            missing.append("has half its inertia about a diameter (free_end.diametral_inertia)")
        if missing:
            remarks = (f"assumed: the free end {' and '.join(missing)}",)
        mass += free_end.mass
        polar += free_end.inertia
        diametral += 0.5 * free_end.inertia if across is None else across
    return EndBody(mass, polar, diametral, overhang=0.5 * length), remarks
