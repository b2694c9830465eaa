"""The engine file with fitted values: fields of the file, or the chain of the plant beside it."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from crankbase.errors import InputError
from crankbase.model import field_extra
from crankbase.outputs import write_errors, write_text
from crankbase.quantity import format_quantity
from crankfem.files.engine.engine_file import EngineFile, load_engine
from crankfem.files.reading.toml_text import quantity_text, toml_text
from crankfem.satellites.measured.calibration.engine_problem import EngineModel
from crankfem.satellites.measured.calibration.fit import Fit
from crankfem.satellites.measured.calibration.groups import EXCITATION, MODAL, Group
from dynamics.chains.chain import Chain

# What a chain of the plant has itself, and the file then may not.
IN_PLANT = ("torsional_damper", "driven", "driver")
DAMPING_IN_PLANT = ("cylinder_damping", "loss_factor")
UNITS = {
    "inertia": "kg m^2",
    "stiffness": "N m/rad",
    "damping": "N m s/rad",
    "ground": "N m/rad",
    "ground_damping": "N m s/rad",
    "distributed_inertia": "kg m^2",
}


@dataclass(frozen=True, eq=False)
class FittedEngine:
    """An engine with fitted values, not yet written.

    Attributes
    ----------
    engine_file : EngineFile
        With the fields that moved.
    chain : Chain or None
        The whole torsional chain, where groups moved that are no fields.
    sources : tuple of (Group, str)
        Each group with its interval, tolerance, record and date in words.
    left_out : tuple of str
        Names of fitted groups that no file holds, such as the gain of the gas.
    records : str
        Names of the records.
    """

    engine_file: EngineFile
    chain: Chain | None
    sources: tuple[tuple[Group, str], ...]
    left_out: tuple[str, ...]
    records: str

    def write(self, path: Path) -> tuple[Path, ...]:
        """Write the engine file, and the chain of the plant beside it, and return their paths.

        Files that crankfem did not write are never replaced.

        Raises
        ------
        InputError
            If a file cannot be written, or the engine cannot be read with the chain of the plant.
        """
        if self.chain is None:
            return (self.engine_file.save(path),)
        chain_path = path.with_name(f"{path.stem}-chain.toml")
        text = self._chain_text(self.chain)
        with write_errors(chain_path):
            write_text(chain_path, text, "input file")
        self.without_parts().save(path)
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        source = f"calibrated with {self.records}; each value has its source there"
        content["shaft_line"] = {
            **content.get("shaft_line", {}),
            "plant": {"value": chain_path.name, "source": source},
        }
        head = f"# Written by crankfem from {self.engine_file.path.name}, with a fitted chain.\n\n"
        with write_errors(path):
            write_text(path, head + toml_text(content), "input file")
        _ = load_engine(path)
        return path, chain_path

    def without_parts(self) -> EngineFile:
        """Return the engine without the sections that its chain of the plant has.

        Raises
        ------
        InputError
            If it needs one of them.
        """
        file = self.engine_file
        gone: dict[str, Any] = {name: None for name in IN_PLANT if getattr(file, name) is not None}
        damping = file.damping
        if damping is not None and any(getattr(damping, name) for name in DAMPING_IN_PLANT):
            gone["damping"] = dict.fromkeys(DAMPING_IN_PLANT)
        if file.vibration.torsional_source != "fe":
            gone["vibration"] = {"torsional_source": "fe"}
        try:
            return file.changed(**gone) if gone else file
        except InputError as error:
            raise InputError(
                f"--output: the moved groups are no fields of the file, and with the chain of the plant in "
                f"their place it is refused ({error}); move fields of the file, such as flywheel.inertia."
            ) from None

    def _chain_text(self, chain: Chain) -> str:
        """Return the chain as a TOML file, each value with what it comes from."""
        if chain.varying:
            raise InputError(
                "--output: given for groups that are no fields of the file, of a chain with springs that "
                "vary; allowed are fields of the file, like driven.stiffness, because others would be lost."
            )
        calculated = f"calculated from {self.engine_file.path.name}"

        def value(field: str, place: int) -> dict[str, str | float]:
            moved = [
                text
                for group, text in self.sources
                for act in group.acts
                if act.field == field and act.shares[place]
            ]
            number = float(getattr(chain, field)[place])
            return {
                "value": quantity_text(number, UNITS[field]) if field in UNITS else number,
                "source": "; ".join(moved) or calculated,
            }

        def values(names: dict[str, str], place: int) -> dict[str, Any]:
            return {
                key: value(field, place)
                for key, field in names.items()
                if getattr(chain, field)[place] or field in ("inertia", "stiffness")
            }

        nodes = {
            "inertia": "inertia",
            "ground_stiffness": "ground",
            "ground_damping": "ground_damping",
        }
        elements = {
            name: name for name in ("stiffness", "damping", "loss_factor", "distributed_inertia")
        }
        section: dict[str, Any] = {
            "name": f"{self.engine_file.engine.name}, fitted",
            "kind": "torsional",
            "nodes": [{"name": name, **values(nodes, k)} for k, name in enumerate(chain.names)],
            "elements": [
                {"nodes": [chain.names[left], chain.names[right]], **values(elements, k)}
                for k, (left, right) in enumerate(chain.connections)
            ],
        }
        if chain.dashpots:
            section["dashpots"] = [
                {
                    "nodes": [chain.names[each.left], chain.names[each.right]],
                    "damping": quantity_text(each.damping, UNITS["damping"]),
                }
                for each in chain.dashpots
            ]
        if chain.gears:
            section["gears"] = [
                {
                    "driver": chain.names[gear.driver],
                    "driven": chain.names[gear.driven],
                    "ratio": gear.ratio,
                }
                for gear in chain.gears
            ]
        head = (
            f"# Written by crankfem: torsional chain fitted from {self.engine_file.path.name}.\n\n"
        )
        return head + toml_text({"chain": section})


def fitted_engine(
    model: EngineModel, solved: Fit, records: Sequence[str], date: str
) -> FittedEngine:
    """Return the engine with the values of a fit.

    Parameters
    ----------
    records : sequence of str
        Names of the records.
    date : str
        Of the calibration.
    """
    shaft, file = solved.problem.shaft, model.engine_file
    factors, sources, left_out = solved.factors(), [], []
    changes: dict[str, dict[str, float]] = {}
    origins: dict[str, tuple[str, bool]] = {}
    beyond_fields = False
    for number, group in enumerate(shaft.groups):
        low, high = solved.interval(number)
        text = (
            f"calibrated {date} with {', '.join(records)}: {factors[number]:.5g} times the maker's value, "
            f"95 % {low:.5g} to {high:.5g}, tolerance before {100.0 * group.tolerance:.3g} %"
        )
        fields = {act.field for act in group.acts}
        if fields == {EXCITATION}:
            left_out.append(group.name)
            continue
        if not group.field:
            beyond_fields = True
            sources.append((group, text))
            continue
        section, _, name = group.field.partition(".")
        before = float(getattr(getattr(file, section), name))
        unit = field_extra(type(getattr(file, section)).model_fields[name], "unit") or ""
        changes.setdefault(section, {})[name] = before * float(factors[number])
        former, assumed = file.provenance.get(group.field, ("", False))
        before_text = f"{'assumed: ' if assumed else ''}{former}" if former else "no source"
        origins[group.field] = (
            f"{text}; before {format_quantity(before, unit)} ({before_text})",
            False,
        )
        sources.append((group, text))
    changed = file.changed(**changes) if changes else file
    chain = None
    if beyond_fields:
        chain = shaft.chain_at(solved.parameters[: len(shaft.groups)])
        modal = shaft.moved(solved.parameters[: len(shaft.groups)]).values[MODAL][0]
        if modal and not np.isclose(modal, model.modal_damping(changed), rtol=1e-12):
            changed = changed.changed(damping={"torsional_magnifier": 0.5 / float(modal)})
            name = "damping.torsional_magnifier"
            origins[name] = (f"calibrated {date} with {', '.join(records)}", False)
    moved = replace(changed, provenance={**changed.provenance, **origins})
    return FittedEngine(moved, chain, tuple(sources), tuple(left_out), ", ".join(records))
