"""Damping of a whole crankshaft: that of the engine's chains, by the kind of motion."""

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankfem.analyses.shaft.chains import ASSUMED, magnifier_of
from crankfem.files.engine.engine_file import EngineFile
from dynamics.chains.engine_chains import Kind
from dynamics.crankshaft.shaft_modes import CrankshaftSystem
from dynamics.response.linear_system import DEFAULT_MAGNIFIER

# Share of critical damping that belongs to the assumed magnifier.
ASSUMED_RATIO = 0.5 / DEFAULT_MAGNIFIER


def modal_damping(engine_file: EngineFile, crankshaft: CrankshaftSystem) -> FloatArray:
    """Return the damping of engine and shaft by modes: that of the chains, by the kind of motion.

    Parameters
    ----------
    engine_file : EngineFile
    crankshaft : CrankshaftSystem

    Returns
    -------
    ndarray of shape (kept + corrections,)
        Share of critical damping of each elastic mode that is kept, and of each correction.

    Notes
    -----
    Axial, torsional and bending motion each contribute their damping, by their share in the mode's
    energy: axial and torsional motion that of their chains, half of 1 / magnifier or of the loss factor;
    bending, and corrections, that of the bending magnifier, assumed by default. As in the chains, an
    assumed magnifier leaves out the share of strain in couplings, dampers and shaft lines with damping of
    their own, and the loss factor that of all of these.
    """
    modes, shaft = crankshaft.modes, crankshaft.shaft
    kept = slice(modes.rigid, modes.rigid + crankshaft.kept)
    shares, ratios = modes.shares[:, kept], _damping_ratios(engine_file)
    strain = (shaft.added_springs @ modes.shapes[:, kept] / modes.angular_frequencies[kept]) ** 2
    by_share = np.array(ratios) @ shares
    loss = 0.0 if engine_file.damping is None else engine_file.damping.loss_factor or 0.0
    kinds: tuple[Kind, ...] = ("axial", "torsional")
    for place, kind in enumerate(kinds):
        own = shaft.spring_kinds == place
        if magnifier_of(engine_file, kind)[1].startswith(ASSUMED):
            left = strain[own & shaft.damped_springs].sum(axis=0)
            by_share -= ratios[place] * np.minimum(left, shares[place])
        elif kind == "torsional":
            by_share -= 0.5 * loss * np.minimum(strain[own].sum(axis=0), shares[place])
    return np.concatenate((by_share, np.full(crankshaft.corrections, ratios[-1])))


def damping_remarks(engine_file: EngineFile) -> tuple[str, ...]:
    """Return the damping of the whole crankshaft in addition to bearings and dampers, in words."""
    given = engine_file.damping
    known = (False,) * 3
    if given is not None:
        twisted = given.torsional_magnifier is not None or given.loss_factor
        known = (
            given.axial_magnifier is not None,
            bool(twisted),
            given.bending_magnifier is not None,
        )
    axial, torsional, bending = (
        f"{100.0 * ratio:.3g} %{'' if own else ' (assumed)'}"
        for ratio, own in zip(_damping_ratios(engine_file), known, strict=True)
    )
    found = [
        "modes have the damping of the chains, weighted by their energy shares, of critical damping: "
        f"axial motion {axial}, torsion {torsional}, bending {bending}"
    ]
    if engine_file.damping is not None and engine_file.damping.cylinder_damping:
        found.append(
            "the damping of the cylinders in torsion (damping.cylinder_damping), which the torsional chain "
            "has, is left out"
        )
    return tuple(found)


def _damping_ratios(engine_file: EngineFile) -> tuple[float, float, float]:
    """Shares of critical damping of axial, torsional and bending motion."""
    given = engine_file.damping
    if given is None:
        return (ASSUMED_RATIO,) * 3
    axial = 0.5 / (given.axial_magnifier or DEFAULT_MAGNIFIER)
    if given.torsional_magnifier is not None:
        torsional = 0.5 / given.torsional_magnifier
    else:
        torsional = 0.0 if given.loss_factor else ASSUMED_RATIO
    bending = 0.5 / (given.bending_magnifier or DEFAULT_MAGNIFIER)
    return axial, torsional + 0.5 * (given.loss_factor or 0.0), bending
