"""Effect of the models of a rod's mass on the forces of an engine."""

from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.summaries import summarized
from crankfem.analyses.mechanism.load_tables import ROUND_OFF
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from dynamics.engine import ROD_MODELS, RodModelName
from dynamics.engine.forces import MechanismForces, mechanism_forces
from dynamics.engine.loads import LoadDiagram, crankpin_loads


@dataclass(frozen=True)
class ModelComparison:
    """Difference of a rod model's forces from those of the rigid rod.

    Parameters
    ----------
    model : str
    crankpin : float
        Largest difference of the force on a crankpin, vector to vector, relative to its mean size.
    side : float
        Largest difference of the side force N, relative to the largest N.
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


@summarized("models", "mean: first.mean [N]", "of_same_angle", "of_mean", "piston_area [m^2]")
@dataclass(frozen=True, eq=False)
class ModelDifference:
    """The load of one crankpin by two models of the rods' mass.

    Parameters
    ----------
    models : tuple of two str
    first, second : LoadDiagram
        Of the same crankpin; the second is compared with the first.
    piston_area : float
        Of the piston above the crankpin [m^2].

    Notes
    -----
    Yamanin, Zhukov, Baryshnikov 2018, doi 10.21821/2309-5180-2018-10-1-191-200, draw forces over the
    piston's area, and give the difference of momentary values.
    """

    models: tuple[RodModelName, RodModelName]
    first: LoadDiagram
    second: LoadDiagram
    piston_area: float

    @property
    def change(self) -> FloatArray:
        """Size of the force by the second model minus that by the first, shape (m,) [N].

        Zero if it is round-off of the largest force.
        """
        change = self.second.magnitude - self.first.magnitude
        return np.where(np.abs(change) < ROUND_OFF * self.first.maximum, 0.0, change)

    @property
    def of_same_angle(self) -> FloatArray:
        """The change as a share of the size by the first model at the same angle, shape (m,)."""
        return self.change / self.first.magnitude

    @property
    def of_mean(self) -> FloatArray:
        """The change as a share of the mean size by the first model, shape (m,)."""
        return self.change / self.first.mean


def model_difference(run: MechanismRun, model: RodModelName) -> ModelDifference:
    """Compare the load of the first crankpin by another rod model with that of a run."""
    return ModelDifference(
        (run.forces.model, model),
        run.crankpins[0],
        crankpin_loads(_with_model(run, model))[0],
        run.layout.cylinders[0].area,
    )
