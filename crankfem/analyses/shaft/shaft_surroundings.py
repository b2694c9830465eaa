"""Surroundings of the throws of a whole crankshaft, from an engine file."""

from dataclasses import asdict

import numpy as np

from crankbase.units.quantity import format_quantity
from crankfem.analyses.shaft.bearings import bearing_stiffness
from crankfem.analyses.shaft.chains import engine_throw_inertias
from crankfem.analyses.shaft.throw_analyses import Analyses, crank_analyses
from crankfem.files.engine.engine_file import EngineFile
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    TorsionalRing,
)
from geometry.mass import cylinder_mass_properties

Remarks = tuple[str, ...]


def shaft_surroundings(
    engine_file: EngineFile, analysis: Analyses, bearings: MainBearings | None = None
) -> tuple[ShaftSurroundings, tuple[str, ...]]:
    """Return the surroundings of the throws, as the engine file gives them.

    Parameters
    ----------
    engine_file, analysis, bearings
        As for `whole_shaft`.

    Returns
    -------
    surroundings : ShaftSurroundings
        Without damping of the shaft itself.
    remarks : tuple of str
        Assumptions.
    """
    throws, per_throw = len(engine_file.throw_angles_deg), len(engine_file.throw.parts.pins)
    each = crank_analyses(engine_file, analysis)
    solids = np.array([own.masses.inertia_about_shaft for own in each])
    rods = engine_throw_inertias(engine_file, solids) - solids
    at_each = np.repeat(rods / per_throw, per_throw) / engine_file.throw.crank_radius**2
    thrust, damper = engine_file.thrust_bearing, engine_file.axial_damper
    supports = [AxialSupport(thrust.section_index, thrust.stiffness)]
    if damper is not None:
        supports.append(AxialSupport(0, damper.stiffness, damper.damping))
    held, first = (bearings, ()) if bearings is not None else _bearings(engine_file, throws)
    flywheel, second = _flywheel(engine_file)
    free_end, third = _free_end(engine_file)
    around = ShaftSurroundings(
        bearings=held,
        axial_supports=tuple(supports),
        flywheel=flywheel,
        free_end=free_end,
        ring=_ring(engine_file),
        machine=_machine(engine_file),
        pin_masses=tuple(at_each.tolist()),
        torsional_line=engine_file.shaft_lines.get("torsional"),
        axial_line=engine_file.shaft_lines.get("axial"),
    )
    return around, (*first, *second, *third)


def _bearings(engine_file: EngineFile, throws: int) -> tuple[MainBearings, Remarks]:
    held, given = bearing_stiffness(engine_file), engine_file.bearings
    damping = 0.0 if given is None else given.damping
    return MainBearings([held.nominal] * (throws + 1), [damping] * (throws + 1)), (
        (
            f"main bearings are assumed to have a {held.describe()}, 1e10 N/m per m of journal diameter, "
            "and no damping; give the section [bearings]",
        )
        if held.assumed
        else ()
    )


def flywheel_overhang(engine_file: EngineFile) -> tuple[float, bool]:
    """Return the flywheel's distance beyond the last main journal's middle [m], and whether it is given."""
    given, thickness = engine_file.flywheel.overhang, engine_file.shaft_ends.flange_thickness
    if given is not None:
        return given, True
    if thickness is not None:
        return thickness, False
    return 0.5 * engine_file.crank_throws[-1].main_journal_length, False


def _flywheel(engine_file: EngineFile) -> tuple[EndBody, Remarks]:
    given, (overhang, known) = engine_file.flywheel, flywheel_overhang(engine_file)
    beyond = f"{format_quantity(overhang, 'm')} beyond"
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
    body = EndBody(given.mass, given.inertia, given.diametral_inertia, overhang)
    kind = "a thin disc" if given.diametral_inertia is None else "a body"
    return body, (f"the flywheel is {kind} {where}",)


def _free_end(engine_file: EngineFile) -> tuple[EndBody | None, Remarks]:
    """The stub of the shaft as a solid cylinder, and the inertia given for it."""
    given, ends = engine_file.free_end, engine_file.shaft_ends
    if given is None and ends.free_end_diameter is None:
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
    if given is not None:
        across, missing = given.diametral_inertia, []
        if given.mass == 0.0:
            missing.append("has no mass of its own (free_end.mass)")
        if across is None:
            missing.append("has half its inertia about a diameter (free_end.diametral_inertia)")
        if missing:
            remarks = (f"assumed: the free end {' and '.join(missing)}",)
        mass += given.mass
        polar += given.inertia
        diametral += 0.5 * given.inertia if across is None else across
    return EndBody(mass, polar, diametral, overhang=0.5 * length), remarks


def _ring(engine_file: EngineFile) -> TorsionalRing | None:
    given = engine_file.torsional_damper
    if given is None:
        return None
    made = asdict(given.damper())
    data = [made.get(name, 0.0) for name in ("stiffness", "damping", "loss_factor")]
    return TorsionalRing(made["ring_inertia"], *data)


def _machine(engine_file: EngineFile) -> TorsionalRing | None:
    given = engine_file.driven
    if given is None:
        return None
    return TorsionalRing(
        given.inertia, given.coupling_stiffness, loss_factor=given.coupling_loss_factor
    )
