"""What stands around the throws of a whole crankshaft, as an engine file tells."""

import numpy as np

from crankfem.engine_file import EngineFile
from crankfem.vibration.chains import engine_throw_inertias
from dynamics.crankshaft.surroundings import (
    AxialSupport,
    EndBody,
    MainBearings,
    ShaftSurroundings,
    TorsionalRing,
)
from fem.analysis import ThrowAnalysis
from geometry.mass import cylinder_mass_properties
from geometry.quantity import show_quantity

# Lateral stiffness of a main bearing (oil film, cap and wall) per journal diameter, where the file gives
# none. An assumption of the order of magnitude, no measurement: it makes 0.5e9 N/m of a journal of 50 mm
# and 2e9 N/m of one of 200 mm.
ASSUMED_BEARING_STIFFNESS = 1e10  # N/m per m


def shaft_surroundings(
    engine_file: EngineFile,
    analysis: ThrowAnalysis,
    remarks: list[str],
    bearings: MainBearings | None = None,
) -> ShaftSurroundings:
    """Return what stands around the throws, as the engine file tells.

    Parameters
    ----------
    engine_file, analysis, bearings
        As for `whole_shaft`.
    remarks : list of str
        Takes what was assumed.
    """
    throws, per_throw = len(engine_file.throw_angles), len(engine_file.throw.parts.pins)
    solid = analysis.masses.inertia_about_shaft
    rods = engine_throw_inertias(engine_file, solid) - solid
    at_each = np.repeat(rods / per_throw, per_throw) / engine_file.throw.crank_radius**2
    thrust, damper = engine_file.thrust_bearing, engine_file.axial_damper
    supports = [AxialSupport(thrust.bearing, thrust.stiffness)]
    if damper is not None:
        supports.append(AxialSupport(0, damper.stiffness, damper.damping))
    loss = engine_file.damping.loss_factor if engine_file.damping is not None else None
    if loss:
        remarks.append(
            "the loss factor of the throws in torsion is taken for all their deformation"
        )
    if engine_file.damping is not None and engine_file.damping.cylinder_damping:
        remarks.append(
            "absolute damping of the cylinders in torsion is left out; magnifiers remain"
        )
    return ShaftSurroundings(
        bearings=_bearings(engine_file, throws, remarks) if bearings is None else bearings,
        axial_supports=tuple(supports),
        flywheel=_flywheel(engine_file, remarks),
        free_end=_free_end(engine_file, remarks),
        ring=_ring(engine_file),
        machine=_machine(engine_file),
        pin_masses=tuple(at_each.tolist()),
        loss_factor=loss or 0.0,
    )


def _bearings(engine_file: EngineFile, throws: int, remarks: list[str]) -> MainBearings:
    given = engine_file.bearings
    if given is not None:
        return MainBearings([given.stiffness] * (throws + 1), [given.damping] * (throws + 1))
    assumed = ASSUMED_BEARING_STIFFNESS * engine_file.throw.main_journal_diameter
    remarks.append(
        f"main bearings are assumed to have a lateral stiffness of {assumed:.2g} N/m each, 1e10 N/m per m "
        "of journal diameter, and no damping; give the section [bearings]"
    )
    return MainBearings(assumed)


def _flywheel(engine_file: EngineFile, remarks: list[str]) -> EndBody:
    given, ends = engine_file.flywheel, engine_file.shaft_ends
    thickness = ends.flange_thickness or 0.0
    remarks.append(
        "the flywheel is a thin disc at the far side of the flange, "
        f"{show_quantity(thickness, 'm')} beyond the last main journal's middle; its mass includes that of "
        "the flange"
    )
    return EndBody(given.mass, given.inertia, overhang=thickness)


def _free_end(engine_file: EngineFile, remarks: list[str]) -> EndBody | None:
    """The stub of the shaft as a solid cylinder, and the inertia that the file puts on it."""
    given, ends = engine_file.free_end, engine_file.shaft_ends
    if given is None and ends.free_end_diameter is None:
        return None
    mass = polar = length = 0.0
    diametral = 0.0
    if ends.free_end_diameter is not None and ends.free_end_length is not None:
        length = ends.free_end_length
        stub = cylinder_mass_properties(
            ends.free_end_diameter, -length, 0.0, engine_file.material.density
        )
        mass, polar = stub.mass, float(stub.inertia[2, 2])
        diametral = float(stub.inertia[0, 0])
    if given is not None:
        remarks.append(
            "the free end's inertia has no mass of its own, which the file does not give; half of it is "
            "taken about a diameter"
        )
        polar += given.inertia
        diametral += 0.5 * given.inertia
    return EndBody(mass, polar, diametral, overhang=0.5 * length)


def _ring(engine_file: EngineFile) -> TorsionalRing | None:
    given = engine_file.torsional_damper
    if given is None:
        return None
    return TorsionalRing(
        given.ring_inertia, given.stiffness or 0.0, given.damping or 0.0, given.loss_factor or 0.0
    )


def _machine(engine_file: EngineFile) -> TorsionalRing | None:
    given = engine_file.driven
    if given is None:
        return None
    return TorsionalRing(
        given.inertia, given.coupling_stiffness, loss_factor=given.coupling_loss_factor
    )
