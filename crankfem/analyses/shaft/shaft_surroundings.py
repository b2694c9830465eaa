"""What stands around the throws of a whole crankshaft, as an engine file tells."""

from dataclasses import asdict

import numpy as np

from crankbase.units.quantity import format_quantity
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

# Lateral stiffness of a main bearing (oil film, cap and wall) per journal diameter, where the file gives
# none. An assumption of the order of magnitude, no measurement: it makes 0.5e9 N/m of a journal of 50 mm
# and 2e9 N/m of one of 200 mm.
ASSUMED_BEARING_STIFFNESS = 1e10  # N/m per m

Remarks = tuple[str, ...]


def shaft_surroundings(
    engine_file: EngineFile,
    analysis: Analyses,
    bearings: MainBearings | None = None,
) -> tuple[ShaftSurroundings, tuple[str, ...]]:
    """Return what stands around the throws, as the engine file tells.

    Parameters
    ----------
    engine_file, analysis, bearings
        As for `whole_shaft`.

    Returns
    -------
    surroundings : ShaftSurroundings
        Without damping of the shaft itself.
    remarks : tuple of str
        What was assumed.
    """
    throws, per_throw = len(engine_file.throw_angles), len(engine_file.throw.parts.pins)
    each = crank_analyses(engine_file, analysis)
    solids = np.array([own.masses.inertia_about_shaft for own in each])
    rods = engine_throw_inertias(engine_file, solids) - solids
    at_each = np.repeat(rods / per_throw, per_throw) / engine_file.throw.crank_radius**2
    thrust, damper = engine_file.thrust_bearing, engine_file.axial_damper
    supports = [AxialSupport(thrust.bearing, thrust.stiffness)]
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
    )
    return around, (*first, *second, *third)


def _bearings(engine_file: EngineFile, throws: int) -> tuple[MainBearings, Remarks]:
    given = engine_file.bearings
    if given is not None:
        each = throws + 1
        return MainBearings([given.stiffness] * each, [given.damping] * each), ()
    assumed = ASSUMED_BEARING_STIFFNESS * engine_file.throw.main_journal_diameter
    return MainBearings(assumed), (
        f"main bearings are assumed to have a lateral stiffness of {assumed / 1e9:.3g}e9 N/m each, 1e10 N/m "
        "per m of journal diameter, and no damping; give the section [bearings]",
    )


def _flywheel(engine_file: EngineFile) -> tuple[EndBody, Remarks]:
    given, thickness = engine_file.flywheel, engine_file.shaft_ends.flange_thickness
    if thickness is None:
        overhang = 0.5 * engine_file.crank_throws[-1].main_journal_length
        where = (
            "at the end of the last main journal (assumed, because no flange is given), "
            f"{format_quantity(overhang, 'm')} beyond its middle"
        )
    else:
        overhang = thickness
        where = (
            f"at the far side of the flange, {format_quantity(overhang, 'm')} beyond the last main journal's "
            "middle; its mass includes that of the flange"
        )
    return EndBody(given.mass, given.inertia, overhang=overhang), (
        f"the flywheel is a thin disc {where}",
    )


def _free_end(engine_file: EngineFile) -> tuple[EndBody | None, Remarks]:
    """The stub of the shaft as a solid cylinder, and the inertia that the file puts on it."""
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
        remarks = (
            "the free end's inertia has no mass of its own, which the file does not give; half of it is "
            "taken about a diameter",
        )
        polar += given.inertia
        diametral += 0.5 * given.inertia
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
