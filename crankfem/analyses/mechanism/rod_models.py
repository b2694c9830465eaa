"""Models of the rods' mass compared: forces, the load of a crankpin, equivalent masses."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated

import numpy as np

from crankbase.array_checks import Array
from crankbase.results import Internal, Number, Part, Quantity, Result, result
from crankbase.table import SI, Column, OutputUnits, Table, format_names
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from dynamics.engine import ROD_MODELS, RodModelName
from dynamics.engine.forces import LoadDiagram, MechanismForces, crankpin_loads, mechanism_forces
from dynamics.engine.layout import EngineLayout

Shares = Annotated[Array, Quantity("1")]
Degrees = Annotated[float, Quantity("deg")]
Kilogram = Annotated[float | None, Quantity("kg")]
# Shares below this are round-off.
ROUND_OFF = 1e-12
# A row of the table for every so many degrees of shaft angle, as the dots of the polar diagram.
ROW_STEP = 30.0


@result("model", "crankpin", "side", eq=True)
class ModelComparison(Result):
    """Largest differences of a rod model's forces from those of the rigid rod."""

    model: RodModelName
    crankpin: Annotated[
        float, Quantity("1", "vector to vector, of the mean size", key="crankpin_beside_mean")
    ]
    side: Annotated[float, Quantity("1", "of the largest N", key="side_force_beside_largest")]


def compare_rod_models(run: MechanismRun) -> tuple[ModelComparison, ...]:
    """Compare the rod models with the rigid rod, for the same gas and speed."""
    rigid = run.forces if run.forces.model == "rigid" else _with_model(run, "rigid")
    loads = crankpin_loads(rigid)
    differences = []
    for name in ROD_MODELS[1:]:
        forces = _with_model(run, name)
        crankpin = max(
            float(np.max(np.abs(crankpin_load.force - load.force))) / load.mean
            for crankpin_load, load in zip(crankpin_loads(forces), loads, strict=True)
        )
        side = float(np.max(np.abs(forces.side - rigid.side)) / np.max(np.abs(rigid.side)))
        differences.append(ModelComparison(name, crankpin, side))
    return tuple(differences)


def _with_model(run: MechanismRun, model: RodModelName) -> MechanismForces:
    return mechanism_forces(
        run.layout,
        run.speed,
        run.forces.gas,
        model=model,
        shaft_angles_deg=run.forces.shaft_angles_deg,
    )


@result("models", "mean: first.mean [N]", "of_same_angle", "of_mean", "piston_area")
class ModelDifference(Result):
    """The load of one crankpin by two models of the rods' mass; the second is compared with the first.

    Notes
    -----
    Yamanin, Zhukov, Baryshnikov 2018, doi 10.21821/2309-5180-2018-10-1-191-200, draw forces over the
    piston's area, and give the difference of momentary values.
    """

    models: tuple[RodModelName, RodModelName]
    first: Internal[LoadDiagram]
    second: Internal[LoadDiagram]
    piston_area: Annotated[float, Quantity("m^2", "of the piston above the crankpin")]
    side_change: Internal[Array]

    @property
    def force_changes(self) -> dict[str, Array]:
        """T and Z of the crankpin and N of the piston above it: second model less first, (m,) [N]."""
        crankpin = self.second.in_crank_frame - self.first.in_crank_frame
        return {"tangential": crankpin.imag, "radial": -crankpin.real, "side": self.side_change}

    @property
    def crankpin(self) -> Part[str]:
        """Its name."""
        return self.first.name

    @property
    def shaft_angles_deg(self) -> Annotated[Array, Quantity("deg")]:
        """Of the following, shape (m,)."""
        return self.first.angles_deg

    @property
    def sizes(self) -> Annotated[tuple[Array, Array], Quantity("N")]:
        """Sizes of the force by both models."""
        return self.first.magnitude, self.second.magnitude

    @property
    def change(self) -> Array:
        """Size of the force by the second model minus that by the first, shape (m,) [N].

        Zero if it is round-off of the largest force.
        """
        change = self.second.magnitude - self.first.magnitude
        return np.where(np.abs(change) < ROUND_OFF * self.first.maximum, 0.0, change)

    @property
    def of_same_angle(self) -> Shares:
        """The change as a share of the size by the first model at the same angle, shape (m,)."""
        return self.change / self.first.magnitude

    @property
    def of_mean(self) -> Shares:
        """The change as a share of the mean size by the first model, shape (m,)."""
        return self.change / self.first.mean

    @property
    def largest_of_same_angle(self) -> Number:
        """The largest share of the size at the same angle, signed."""
        return float(self.of_same_angle[_largest(self.of_same_angle)])

    @property
    def largest_of_same_angle_deg(self) -> Degrees:
        """Where it is."""
        return float(self.first.angles_deg[_largest(self.of_same_angle)])

    @property
    def largest_of_mean(self) -> Number:
        """The largest share of the mean size, signed."""
        return float(self.of_mean[_largest(self.of_mean)])

    @property
    def largest_of_mean_deg(self) -> Degrees:
        """Where it is."""
        return float(self.first.angles_deg[_largest(self.of_mean)])

    @property
    def mean(self) -> Number:
        """How the mean by the second model differs from that by the first, as a share."""
        return self.second.mean / self.first.mean - 1.0

    @property
    def maximum(self) -> Number:
        """How the maximum by the second model differs from that by the first, as a share."""
        return self.second.maximum / self.first.maximum - 1.0

    def parts(self, units: OutputUnits = SI) -> Iterator[Table | str]:
        """Return the loads by shaft angle, unless both are the same, and a sentence."""
        first, second = self.models
        if not self.largest_of_mean:
            yield f"Load of {self.crankpin}: the same, to round-off, as {second} and as {first}."
            return
        degrees = self.first.angles_deg
        lowest = math.ceil(degrees[0] / ROW_STEP) * ROW_STEP
        wanted = np.arange(lowest, degrees[-1] + 1e-6, ROW_STEP)
        rows = [int(np.argmin(np.abs(degrees - angle))) for angle in wanted]
        yield Table(
            f"Load of {self.crankpin}, rods as {first} and as {second}",
            [
                Column("shaft angle", "deg"),
                *(Column(name, "kN") for name in self.models),
                Column("change", "%", decimals=2),
                Column("of mean", "%", decimals=2),
            ],
            [
                [
                    math.radians(degrees[row]),
                    *(size[row] for size in self.sizes),
                    self.of_same_angle[row],
                    self.of_mean[row],
                ]
                for row in rows
            ],
            note=f"1 kN over the area of the piston is {1e-3 / self.piston_area:.4g} MPa. Change: from "
            f"{first} to {second}, in percent of {first} at the same angle, and of its mean.",
        )
        same, of_mean, mean, maximum = (
            f"{100.0 * share:+.2f} %"
            for share in (self.largest_of_same_angle, self.largest_of_mean, self.mean, self.maximum)
        )
        at, mean_at = (
            units.of("deg").with_name(math.radians(angle))
            for angle in (self.largest_of_same_angle_deg, self.largest_of_mean_deg)
        )
        yield (
            f"Load of {self.crankpin}, from {first} to {second}: it changes by up to {same} of its size at "
            f"the same angle (at {at}), or {of_mean} of its mean (at {mean_at}); its mean changes by "
            f"{mean}, its maximum by {maximum}."
        )


def _largest(shares: Array) -> int:
    return int(np.argmax(np.abs(shares)))


def model_difference(run: MechanismRun, model: RodModelName) -> ModelDifference:
    """Compare the load of the first crankpin by another rod model with that of a run."""
    other = _with_model(run, model)
    return ModelDifference(
        (run.forces.model, model),
        run.crankpins[0],
        crankpin_loads(other)[0],
        run.layout.cylinders[0].area,
        other.side[0] - run.forces.side[0],
    )


@result("model", "at_foot", "at_piston_pin", "at_center", "inertia", eq=True)
class RodMasses(Result):
    """Equivalent masses of a rod by one model, None where it has no mass there.

    Parameters
    ----------
    at_foot : float or None
        At the crankpin, or at the slave pin.
    inertia : float
        Added to that of the masses.
    """

    model: RodModelName
    at_foot: Kilogram
    at_piston_pin: Kilogram
    at_center: Kilogram
    inertia: Annotated[float | None, Quantity("kg m^2")]


@result("cylinders", "models", eq=True)
class RodOfCylinders(Result):
    """Equivalent masses of the rods that are alike."""

    cylinders: Annotated[tuple[int, ...], Quantity("1")]
    models: tuple[RodMasses, ...]


def rod_masses(layout: EngineLayout) -> tuple[RodOfCylinders, ...]:
    """Return the equivalent masses of each different rod."""
    rods = [cylinder.rod for cylinder in layout.cylinders]
    different = []
    for rod in dict.fromkeys(rods):
        rows = []
        for model in map(rod.model, ROD_MODELS):
            masses = dict(zip(model.places, model.masses, strict=True))
            at_foot, at_pin, at_center = (
                _without_round_off(masses.get(place), rod.mass)
                for place in (0j, complex(rod.length), rod.center)
            )
            added = _without_round_off(model.added_inertia, rod.inertia)
            rows.append(RodMasses(model.name, at_foot, at_pin, at_center, added))
        alike = tuple(number for number, other in enumerate(rods, start=1) if other == rod)
        different.append(RodOfCylinders(alike, tuple(rows)))
    return tuple(different)


def _without_round_off(value: float | None, scale: float) -> float | None:
    return 0.0 if value is not None and abs(value) < ROUND_OFF * scale else value


def rod_mass_table(rods: Sequence[RodOfCylinders]) -> Table:
    """Return the equivalent masses of the rods by model."""
    several = len(rods) > 1
    return Table(
        "Equivalent masses of the rod" + ("s" if several else ""),
        [
            *([Column("cylinders", words=True)] if several else []),
            Column("model", words=True),
            Column("at big end", "kg", missing=""),
            Column("at piston pin", "kg", missing=""),
            Column("at center of mass", "kg", missing=""),
            Column("added inertia", "kg m^2"),
        ],
        [
            [
                *([format_names(list(map(str, rod.cylinders)))] if several else []),
                row.model,
                row.at_foot,
                row.at_piston_pin,
                row.at_center,
                row.inertia,
            ]
            for rod in rods
            for row in rod.models
        ],
    )
