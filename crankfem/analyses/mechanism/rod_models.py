"""The models of a connecting rod compared, and tables of the mechanism's forces."""

import math
from dataclasses import dataclass

import numpy as np

from crankbase.array_checks import FloatArray
from crankbase.summaries import summarized
from crankbase.table import SI, Column, OutputUnits, Table, format_names
from crankfem.analyses.mechanism.mechanism_run import MechanismRun
from crankfem.analyses.record import Record, attributes
from dynamics.engine import ROD_MODELS, RodModelName
from dynamics.engine.forces import LoadDiagram, MechanismForces, crankpin_loads, mechanism_forces
from dynamics.engine.layout import EngineLayout

# Shares below this are round-off.
ROUND_OFF = 1e-12
LOAD_COLUMNS = (
    Column("mean", "kN"),
    Column("largest", "kN"),
    Column("at", "deg"),
    Column("mean", "MPa"),
    Column("largest", "MPa"),
)


def cylinder_table(record: Record) -> Table:
    """Return pressures and largest forces by cylinder."""
    return Table(
        "Cylinders",
        [
            Column("cylinder", words=True),
            Column("p", "MPa"),
            Column("at", "deg"),
            Column("p_i", "MPa"),
            *(Column(symbol, "kN") for symbol in ("N", "pin", "T")),
        ],
        [
            [
                str(row["cylinder"]),
                row["peak_pressure"],
                math.radians(row["peak_angle_deg"]),
                row["mean_effective_pressure"],
                *(row[f"largest_{name}_force"] for name in ("side", "piston_pin", "tangential")),
            ]
            for row in record["cylinders"]
        ],
        note="p: peak pressure, absolute, and its angle from the firing top; p_i: mean indicated pressure; "
        "N, pin, T: largest side force, piston-pin force and tangential force.",
        merged=True,
    )


def crankpin_table(record: Record) -> Table:
    """Return loads and specific pressures of the crankpins."""
    return Table(
        "Crankpin bearings, angle from the firing top of the cylinder whose rod is on the pin",
        [Column("cylinder", words=True), *LOAD_COLUMNS],
        [
            [
                "+".join(str(cylinder) for cylinder in row["cylinders"]),
                *_load_cells(row, row["largest_angle_from_firing_deg"]),
            ]
            for row in record["crankpins"]
        ],
        merged=True,
    )


def bearing_table(record: Record) -> Table:
    """Return loads and specific pressures of the main bearings."""
    return Table(
        "Main bearings, each throw supported by its two bearings, shaft angle",
        [Column("bearing", words=True), *LOAD_COLUMNS],
        [
            [str(place), *_load_cells(row, row["largest_angle_deg"])]
            for place, row in enumerate(record["main_bearings"], start=1)
        ],
    )


def rod_model_table(record: Record) -> Table | None:
    """Return the effect of the rod models, unless the rod's data make them equal."""
    rows = record["rod_models"]
    if all(row["crankpin_beside_mean"] < ROUND_OFF for row in rows):
        return None
    return Table(
        "Rod models compared with the rigid rod, largest differences",
        [
            Column("model", words=True),
            Column("crankpin force / its mean", "%", decimals=2),
            Column("side force / its largest", "%", decimals=2),
        ],
        [
            [row["model"], row["crankpin_beside_mean"], row["side_force_beside_largest"]]
            for row in rows
        ],
    )


def _load_cells(row: Record, degrees: float) -> list[float]:
    return [
        row["mean"],
        row["largest"],
        math.radians(degrees),
        row["mean_specific_pressure"],
        row["largest_specific_pressure"],
    ]


@dataclass(frozen=True)
class ModelComparison:
    """Difference of a rod model's forces from those of the rigid rod.

    Parameters
    ----------
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


@summarized("models", "mean: first.mean [N]", "of_same_angle", "of_mean", "piston_area [m^2]")
@dataclass(frozen=True, eq=False)
class ModelDifference:
    """The load of one crankpin by two models of the rods' mass.

    Parameters
    ----------
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


# A row of the table for every so many degrees of shaft angle, as the dots of the polar diagram.
ROW_STEP = 30.0


def rod_mass_records(layout: EngineLayout) -> list[Record]:
    """Return the equivalent masses of each rod, by model.

    Returns
    -------
    list of dict
        For each different rod "cylinders", and "models": "model", "at_foot", "at_piston_pin" and
        "at_center" [kg], None where the model has no mass there, and the additional "inertia" [kg m^2].
        The foot is at the crankpin, or at the slave pin.
    """
    rods = [cylinder.rod for cylinder in layout.cylinders]
    records = []
    for rod in dict.fromkeys(rods):
        places = {"at_foot": 0j, "at_piston_pin": complex(rod.length), "at_center": rod.center}
        rows = []
        for model in map(rod.model, ROD_MODELS):
            masses = dict(zip(model.places, model.masses, strict=True))
            rows.append(
                {
                    "model": model.name,
                    **{
                        name: _without_round_off(masses.get(place), rod.mass)
                        for name, place in places.items()
                    },
                    "inertia": _without_round_off(model.added_inertia, rod.inertia),
                }
            )
        records.append(
            {
                "cylinders": [number for number, own in enumerate(rods, start=1) if own == rod],
                "models": rows,
            }
        )
    return records


def _without_round_off(value: float | None, scale: float) -> float | None:
    return 0.0 if value is not None and abs(value) < ROUND_OFF * scale else value


def rod_mass_table(records: list[Record]) -> Table:
    """Return the table of `rod_mass_records`."""
    several = len(records) > 1
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
                *(
                    [format_names([str(number) for number in record["cylinders"]])]
                    if several
                    else []
                ),
                row["model"],
                *(row[f"at_{place}"] for place in ("foot", "piston_pin", "center")),
                row["inertia"],
            ]
            for record in records
            for row in record["models"]
        ],
    )


def model_difference_record(difference: ModelDifference) -> Record:
    """Return the crankpin loads of two rod models, and their difference, as plain JSON content.

    Returns
    -------
    dict
        "models", "crankpin", "piston_area" [m^2]; over "shaft_angles_deg" the "sizes" of the force by
        both models [N], their difference "of_same_angle" and "of_mean" as shares, with the largest of
        each, "largest_of_same_angle" and "largest_of_mean", signed, at "..._deg"; and how "mean" and
        "maximum" of the second model differ from those of the first, as shares.
    """
    first, second = difference.first, difference.second
    degrees = first.angles_deg
    return {
        **attributes(difference, "models", "piston_area", "of_same_angle", "of_mean"),
        "crankpin": first.name,
        "shaft_angles_deg": degrees.tolist(),
        "sizes": [first.magnitude.tolist(), second.magnitude.tolist()],
        **_largest("of_same_angle", difference.of_same_angle, degrees),
        **_largest("of_mean", difference.of_mean, degrees),
        "mean": second.mean / first.mean - 1.0,
        "maximum": second.maximum / first.maximum - 1.0,
    }


def _largest(name: str, shares: FloatArray, degrees: FloatArray) -> Record:
    place = int(np.argmax(np.abs(shares)))
    return {f"largest_{name}": float(shares[place]), f"largest_{name}_deg": float(degrees[place])}


def model_difference_table(record: Record) -> Table | None:
    """Return the loads of a `model_difference_record` by shaft angle, unless both are the same."""
    first, second = record["models"]
    if not _differ(record):
        return None
    degrees = np.array(record["shaft_angles_deg"])
    wanted = np.arange(math.ceil(degrees[0] / ROW_STEP) * ROW_STEP, degrees[-1] + 1e-6, ROW_STEP)
    rows = [int(np.argmin(np.abs(degrees - angle))) for angle in wanted]
    sizes, pressure = record["sizes"], 1e-3 / record["piston_area"]
    return Table(
        f"Load of {record['crankpin']}, rods as {first} and as {second}",
        [
            Column("shaft angle", "deg"),
            *(Column(name, "kN") for name in record["models"]),
            Column("change", "%", decimals=2),
            Column("of mean", "%", decimals=2),
        ],
        [
            [
                math.radians(degrees[row]),
                *(size[row] for size in sizes),
                record["of_same_angle"][row],
                record["of_mean"][row],
            ]
            for row in rows
        ],
        note=f"1 kN over the area of the piston is {pressure:.4g} MPa. Change: from {first} to {second}, in "
        f"percent of {first} at the same angle, and of its mean.",
    )


def _differ(record: Record) -> bool:
    return bool(record["largest_of_mean"])


def model_difference_sentence(record: Record, units: OutputUnits = SI) -> str:
    """State the difference between two models."""
    first, second = record["models"]
    if not _differ(record):
        return f"Load of {record['crankpin']}: the same, to round-off, as {second} and as {first}."

    def share(name: str) -> str:
        return f"{100.0 * record[name]:+.2f} %"

    def at(name: str) -> str:
        return units.of("deg").with_name(math.radians(record[f"{name}_deg"]))

    same, mean = "largest_of_same_angle", "largest_of_mean"
    return (
        f"Load of {record['crankpin']}, from {first} to {second}: it changes by up to {share(same)} of its "
        f"size at the same angle (at {at(same)}), or {share(mean)} of its mean (at {at(mean)}); its mean "
        f"changes by {share('mean')}, its maximum by {share('maximum')}."
    )
