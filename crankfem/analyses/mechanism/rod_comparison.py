"""What the models of a rod's mass do to the forces of an engine."""

from dataclasses import dataclass

import numpy as np

from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from dynamics.engine.forces import MechanismForces, mechanism_forces
from dynamics.engine.loads import crankpin_loads
from dynamics.mechanism.rod_model_names import ROD_MODELS, RodModelName


@dataclass(frozen=True)
class ModelComparison:
    """How far a rod model's forces are from those of the rigid rod.

    Parameters
    ----------
    model : str
    crankpin : float
        Largest difference of the force on a crankpin, vector to vector, beside its mean size.
    side : float
        Largest difference of the side force N, beside the largest N.
    """

    model: RodModelName
    crankpin: float
    side: float


def compare_rod_models(run: MechanismRun) -> tuple[ModelComparison, ...]:
    """Compare the rod models with the rigid rod, for the same gas and speed."""
    rigid = run.forces if run.forces.model == "rigid" else _with_model(run, "rigid")
    loads = crankpin_loads(rigid)
    found = []
    for name in ROD_MODELS[1:]:
        forces = _with_model(run, name)
        crankpin = max(
            float(np.max(np.abs(own.force - load.force))) / load.mean
            for own, load in zip(crankpin_loads(forces), loads, strict=True)
        )
        side = float(np.max(np.abs(forces.side - rigid.side)) / np.max(np.abs(rigid.side)))
        found.append(ModelComparison(name, crankpin, side))
    return tuple(found)


def _with_model(run: MechanismRun, model: RodModelName) -> MechanismForces:
    return mechanism_forces(
        run.layout,
        run.speed,
        run.forces.gas,
        model=model,
        shaft_angles_deg=run.forces.shaft_angles_deg,
    )
