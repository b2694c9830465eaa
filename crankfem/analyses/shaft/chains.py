"""The axial and the torsional chain of an engine file, with all bodies attached to them."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crankbase.errors import InputError
from crankfem.files.chain.shaft_lines import PLANT, plant_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.mechanism_file import layout_of
from dynamics.chains.dampers import TorsionalDamper
from dynamics.chains.engine_chains import (
    EngineChain,
    Kind,
    axial_chain,
    throw_inertias,
    torsional_chain,
)
from dynamics.chains.shaft_line import DrivenMachine
from dynamics.response.linear_system import (
    DEFAULT_MAGNIFIER,
    MAGNIFIER_SOURCE,
    UNIT,
    DampedChain,
    damped,
)

Array = NDArray[np.float64]
ASSUMED = "assumed"


def engine_axial_chain(
    engine_file: EngineFile, compliances: Array, throw_masses: ArrayLike
) -> EngineChain:
    """Masses at the main-journal middles of an engine, its thrust bearing and axial damper.

    Parameters
    ----------
    engine_file : EngineFile
    compliances : (n,) array
        Axial compliance of each throw in the shaft [m/N].
    throw_masses : float or (n,) array_like
        Of the throws [kg].
    """
    thrust, damper = engine_file.thrust_bearing, engine_file.axial_damper
    at_free_end = 0.0 if engine_file.free_end is None else engine_file.free_end.mass
    return axial_chain(
        compliances,
        np.broadcast_to(throw_masses, len(compliances)),
        engine_file.flywheel.mass,
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
        layout_of(engine_file),
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
    engine_file : EngineFile
    compliances : (n,) array
        Torsional compliance of each throw [rad/(N m)].
    inertias : (n,) array
        Of the throws with their shares of rods and pistons [kg m^2].

    Returns
    -------
    EngineChain
        Of a plant whose maker gives it, that chain, for any throws.
    """
    free_end, driven, damping = engine_file.free_end, engine_file.driven, engine_file.damping
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
        engine_file.flywheel.inertia,
        0.0 if free_end is None else free_end.inertia,
        None
        if driven is None
        else DrivenMachine(
            driven.inertia,
            driven.coupling_stiffness,
            coupling_loss_factor=driven.coupling_loss_factor,
        ),
        loss_factor=loss,
        throw_damping=absolute * on_each,
        cylinders=on_each.tolist(),
        damper=torsional_damper(engine_file),
        shaft_line=engine_file.shaft_lines.get("torsional"),
    )


def torsional_damper(engine_file: EngineFile) -> TorsionalDamper | None:
    """Return the damper at the free end, if the file has one.

    Raises
    ------
    InputError
        If there is no free end to carry it.
    """
    given = engine_file.torsional_damper
    if given is None:
        return None
    if engine_file.free_end is None:
        raise InputError(
            "torsional_damper: given without the section [free_end]; allowed are both, because the hub "
            "of the damper is part of the free end's inertia."
        )
    return given.damper()


def magnifier_of(engine_file: EngineFile, kind: Kind) -> tuple[float | None, str]:
    """Return the magnifier of the elastic modes and its source, which begins with `ASSUMED` if it is.

    Without any damping in the file this is a measured value, marked as assumed; none if cylinders or
    throws have damping of their own.
    """
    given = engine_file.damping
    if given is not None:
        magnifier = given.axial_magnifier if kind == "axial" else given.torsional_magnifier
        if magnifier is not None:
            told, assumed = engine_file.provenance.get(f"damping.{kind}_magnifier", ("", False))
            return magnifier, f"{ASSUMED}: {told}" if assumed else "engine file"
        if kind == "torsional" and given.damps_torsion:
            return None, ""
    return DEFAULT_MAGNIFIER, f"{ASSUMED}, {MAGNIFIER_SOURCE}"


def magnifier_damping(engine_file: EngineFile, chain: EngineChain) -> tuple[Array | None, str]:
    """Return the share of critical damping that the magnifier adds to each elastic mode, in words too.

    An assumed magnifier stands for damping that nobody gives: it does not damp parts whose own is given.
    """
    magnifier, source = magnifier_of(engine_file, chain.kind)
    if magnifier is None:
        return None, ""
    modes = chain.chain.modes()
    undamped = np.ones(modes.frequencies.size - modes.rigid)
    apart = ""
    if source.startswith(ASSUMED) and np.any(own := chain.chain.damped_springs):
        undamped = modes.strain_shares[~own, modes.rigid :].sum(axis=0)
        apart = ", by its share of strain in parts without damping of their own"
    said = f"magnifier {magnifier:g} of every elastic mode{apart}: {source}"
    return 0.5 / magnifier * undamped, said


def damped_engine_chain(engine_file: EngineFile, chain: EngineChain) -> DampedChain:
    """Return the chain with the damping of engine and shaft; dampers and couplings add theirs."""
    added, told = magnifier_damping(engine_file, chain)
    found = damped(chain.chain, modal_damping=added)
    record = found.record if added is None else (*found.record[:-1], told)
    unit = "N s/m" if chain.kind == "axial" else "N m s/rad"
    return replace(found, record=tuple(said.replace(UNIT, unit) for said in record))
