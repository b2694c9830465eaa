"""How a file of quantities is understood: for the command check, before anything is computed."""

from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from crankbase.model import field_extra
from crankbase.results import Quantity, Result, Speed, made_from, result
from crankbase.sentences import with_sentences
from crankfem.analyses.assumptions import input_values
from crankfem.analyses.engine_mechanism import input_warnings, load_any
from crankfem.analyses.record import Record, attributes
from crankfem.analyses.shaft.sources import chosen_regressions, refused
from crankfem.analyses.study.nominal_throw import outside_study
from crankfem.analyses.study.response_fits import check_study_can_be_fitted
from crankfem.analyses.throw.law_record import law_results
from crankfem.analyses.vibration.engine_excitation import refuse_forced_vibration
from crankfem.analyses.vibration.engine_limits import engine_limits, rule_reason
from crankfem.files.chain.chain_file import load_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.file_kinds import any_sections, file_kind
from crankfem.files.engine.throw_file import ThrowFile, load_study
from crankfem.files.engine.used_values import USES, not_used
from crankfem.files.engine.usual_parts import (
    POISSON,
    first_nodes,
    material_warnings,
    near_angles,
    study_warnings,
)
from crankfem.files.engine.usual_sizes import throw_warnings
from crankfem.files.reading.toml_file import InputRecord, TomlFile
from crankfem.files.satellites import at_place, satellite_files, uses_of_satellites
from crankfem.files.sections.crank_throws import PLAIN, ShaftLayout
from crankfem.files.sections.engine_sections import Engine, ThrustBearing
from dynamics.chains.coupling_damping import in_all_conventions
from dynamics.harmonics import read_torque_table
from fem.material import STEEL, Material
from geometry.any_throw import Throw
from geometry.throw import CrankThrow
from regression.plans.plan import PlannedStudy
from regression.records import RUN


def refuse_what_cannot_run(engine_file: EngineFile, content: TomlFile | None = None) -> None:
    """Refuse limits, chains, pressures, models, studies and tables with which a run would end in an error.

    Parameters
    ----------
    content : TomlFile, optional
        Its sections, for the lines of the file in errors.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    with nullcontext() if content is None else content.with_lines():
        refuse_forced_vibration(engine_file)
        # A saved model stands for a study that cannot give what is wanted of it.
        if engine_file.vibration.model is None and engine_file.study is not None:
            check_study_can_be_fitted(engine_file.study.planned)
            reason = outside_study(engine_file.study)
            for kind in chosen_regressions(engine_file.vibration) if reason else ():
                raise refused(
                    engine_file,
                    kind,
                    f"does not apply to the throw that its study varies: {reason}",
                )
        if engine_file.torque_table is not None:
            _ = read_torque_table(engine_file.torque_table, strokes=engine_file.engine.strokes)


THROW_COMMANDS = ("throw", "stress", "formulas", "draw", "export")
MECHANISM_COMMANDS = ("mechanism", "harmonics", *THROW_COMMANDS)


Degrees = Annotated[tuple[float, ...], Quantity("deg")]


@result("cylinders", "firing_order")
class Arrangement(Result):
    """Cylinders and cranks of an engine; firing angles are in the firing order."""

    cylinders: int
    strokes: int
    bore: Annotated[float, Quantity("m")]
    stroke: Annotated[float, Quantity("m")]
    firing_order: Annotated[tuple[int, ...], Quantity("1")]
    firing_angles_deg: Degrees
    firing_intervals_deg: Degrees
    crank_angles_deg: Degrees
    bank_angles_deg: Annotated[tuple[float, ...] | None, Quantity("deg")]
    rated_speed: Speed
    lowest_speed: Speed
    highest_speed: Speed
    mean_piston_speed: Annotated[float, Quantity("m/s")]
    driven_by: Annotated[str | None, Quantity(left_out=True)] = None


@result("length", "overlap", "volume")
class Shape(Result):
    """What follows from the dimensions of a throw, and the part of it to be solved."""

    length: Annotated[float, Quantity("m")]
    overlap: Annotated[float, Quantity("m")]
    volume: Annotated[float, Quantity("m^3")]
    remarks: tuple[str, ...]
    pins: int
    solved_part: str


@result("name", "value")
class Dimension(Result):
    """One dimension of a throw, as understood."""

    name: str
    symbol: str
    meaning: str
    value: Annotated[float, Quantity("m")]


@with_sentences
@dataclass(frozen=True)
class CheckedFile:
    """A valid file, and how it is understood.

    Attributes
    ----------
    kind : {"engine", "mechanism", "throw", "chain"} or that of a satellite
    name : str or None
        Its name in the file.
    commands : tuple of str
        That can use the file.
    inputs : tuple of InputRecord
        Every value with its source.
    engine : Arrangement or None
    warnings : tuple of str
        What is far outside of practice, and so perhaps a slip.
    throws : dict
        Name to throw, where throws have names; the first then is that at the free end.
    material : Material
        Of the throws.
    not_used : dict
        Command to the sections and fields of the file that it does not use.
    """

    path: Path
    kind: str
    name: str | None
    sections: tuple[str, ...]
    commands: tuple[str, ...]
    inputs: tuple[InputRecord, ...]
    throw: Throw | None = None
    engine: Arrangement | None = None
    remarks: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    throws: dict[str, Throw] = field(default_factory=dict)
    material: Material = STEEL
    not_used: dict[str, tuple[str, ...]] = field(default_factory=dict)


def check_file(file: str | TomlFile) -> CheckedFile:
    """Read a file of any kind, and check it.

    Parameters
    ----------
    file : str
        Path, or the name of a shipped file; or its sections, if already read.

    Raises
    ------
    InputError
        With one sentence that names the field, what was given and what is allowed.
    """
    content = file if isinstance(file, TomlFile) else any_sections(file)
    checked = _checked(file, content)
    if content is None:
        return checked
    used = {*USES, *uses_of_satellites()}
    throws = (checked.throw, *checked.throws.values())
    if not all(throw is None or isinstance(throw, CrankThrow) for throw in throws):
        commands = tuple(name for name in checked.commands if name != "formulas")
        checked = replace(checked, commands=commands)
    unused = {name: not_used(content, name) for name in checked.commands if name in used}
    return replace(checked, not_used=unused)


def _checked(file: str | TomlFile, content: TomlFile | None) -> CheckedFile:
    if content is None or file_kind(content) == "chain":
        chain_file = load_chain(content or file)
        chain = chain_file.chain
        return CheckedFile(
            chain_file.path,
            "chain",
            chain_file.name,
            ("chain",),
            ("vibration",),
            chain_file.records,
            remarks=(
                f"a {chain_file.kind} chain of {len(chain.names)} nodes and {len(chain.elements)} "
                f"elements, from {chain.names[0]} to {chain.names[-1]}",
                *chain_file.printed,
            ),
        )
    if file_kind(content) in satellite_files():
        files = satellite_files()[file_kind(content)]
        satellite_file = at_place(files.reader)(content)
        sections = tuple(name for name in at_place(files.sections) if name in content.sections)
        return CheckedFile(
            satellite_file.path,
            files.kind,
            satellite_file.name,
            sections,
            (files.command,),
            satellite_file.records,
        )
    read = load_any(content)
    of_study: tuple[str, ...] = ()
    if "study" in content.sections:
        # Where it is read already: it is planned once.
        study = (read.study if isinstance(read, EngineFile) else None) or load_study(content)
        _ = study.planned  # refuses a study of which nothing can be built
        of_study = tuple(warning.sentence for warning in study_warnings(study))
    if isinstance(read, ThrowFile):
        checked = _throw(read, content)
    else:
        checked = _engine(read, content) if read.whole else _mechanism(read, content)
    return replace(checked, warnings=(*checked.warnings, *of_study))


def check_record(checked: CheckedFile) -> Record:
    """Return a checked file as plain JSON content in SI units, angles in degrees."""
    throws = {
        name: _throw_record(throw, checked.material) for name, throw in checked.throws.items()
    }
    return {
        "engine": checked.name,
        "valid": True,
        "file": str(checked.path),
        **attributes(checked, "kind", "sections", "commands", "not_used"),
        "remarks": checked.remarks,
        "warnings": checked.warnings,
        "arrangement": checked.engine,
        **_throw_record(checked.throw, checked.material),
        "inputs": checked.inputs,
    } | ({"throws": throws} if throws else {})


def _throw_record(throw: Throw | None, material: Material) -> Record:
    if throw is None:
        return {"shape": None, "dimensions": None}
    return {
        "shape": throw_shape(throw),
        "dimensions": None
        if not isinstance(throw, CrankThrow)
        else [
            Dimension(
                name,
                field_extra(info, "symbol") or "",
                info.description or "",
                getattr(throw, name),
            )
            for name, info in type(throw).model_fields.items()
            if field_extra(info, "unit") == "m"
            and isinstance(getattr(throw, name), float)
            and not (field_extra(info, "feature") and getattr(throw, name) == 0.0)
        ],
        "law": law_results(throw, material),
    }


def throw_shape(throw: Throw) -> Shape:
    """Return what follows from the dimensions."""
    return made_from(throw, Shape, pins=len(throw.parts.pins), solved_part=throw.symmetry)


def _throw(read: ThrowFile, content: TomlFile) -> CheckedFile:
    study = ("doe",) if "study" in content.sections else ()
    shaft, material = content.model("shaft", ShaftLayout), read.material
    poisson = material.poisson_ratio
    warnings = (
        *material_warnings(material),
        *throw_warnings(read.throws),
        *POISSON.warning_of("material.poisson_ratio", poisson, "", poisson / STEEL.poisson_ratio),
        *near_angles("shaft.throw_angles", None if shaft is None else shaft.throw_angles),
    )
    return CheckedFile(
        read.path,
        "throw",
        None,
        tuple(content.sections),
        (*THROW_COMMANDS, *_lookup(read.throw, material), *study),
        read.records,
        read.throw,
        warnings=tuple(warning.sentence for warning in warnings),
        throws={} if PLAIN in read.throws else read.throws,
        material=material,
    )


def _mechanism(read: EngineFile, content: TomlFile) -> CheckedFile:
    study = ("doe",) if "study" in content.sections else ()
    gas = (_without_gas(),) if read.power is None else _power(read)
    names = content.sections.get("shaft", {}).get("throws", ())
    return CheckedFile(
        read.path,
        "mechanism",
        read.engine.name,
        tuple(content.sections),
        (*MECHANISM_COMMANDS, *_lookup(read.throw, read.material), *study),
        input_values(read),
        read.throw,
        _arrangement(read.engine),
        (*read.remarks, *gas, *_of_tables(read)),
        input_warnings(read),
        dict(zip(names, read.crank_throws, strict=False)),
        read.material,
    )


def _lookup(throw: Throw, material: Material) -> tuple[str, ...]:
    """The command lookup, where the law covers the throw: then it needs no model."""
    return () if law_results(throw, material).answers is None else ("lookup",)


def _engine(read: EngineFile, content: TomlFile) -> CheckedFile:
    refuse_what_cannot_run(read, content)
    study = ("doe",) if read.study is not None else ()
    place, count = read.required(ThrustBearing).main_bearing, len(read.throw_angles_deg) + 1
    remarks = [
        f"thrust bearing at main bearing {place} of {count}, counted from 1 at the free end",
        *read.remarks,
        *_power(read),
        *_of_tables(read),
    ]
    if read.torque_table is not None:
        torque = read_torque_table(read.torque_table, strokes=read.engine.strokes)
        remarks += [f"torque.table: {remark}" for remark in torque.remarks]
    behind = read.behind_coupling
    if behind is not None and behind.loss_factor:
        remarks.append(f"coupling: {in_all_conventions(behind.loss_factor)}")
    remarks += [added.sentence for added, twice in first_nodes(read) if not twice]
    if read.gas is None:
        remarks.append(_without_gas())
    if read.limits is not None or read.strength is not None:
        limits, _ = engine_limits(read)
        remarks += [f"{limit.name}: {limit.remark}" for limit in limits.values() if limit.remark]
    if read.limits is None and read.gas is not None:
        remarks.append(
            "without the section [limits], a classification society's rule for crankshafts is used: "
            + rule_reason(read)
        )
    fitted_by_run = bool(chosen_regressions(read.vibration)) and read.vibration.model is None
    if fitted_by_run:
        remarks.append(
            "crankfem run fits the source regression; crankfem vibration needs a saved model: "
            "vibration.model, or --model MODEL.json"
        )
    vibration = (
        "vibration",
        *(
            name
            for name, use in uses_of_satellites().items()
            if use.needs & content.sections.keys()
        ),
    )
    model = read.model_file
    if model is not None:
        beside = "" if read.study is None else "; the section [study] is not run"
        remarks.append(f"regression: the saved model {model.path}{beside}")
    elif read.study is None:
        remarks.append("without the section [study] no regression is fitted")
    else:
        remarks += excluded_designs(read.study.planned)
    return CheckedFile(
        read.path,
        "engine",
        read.engine.name,
        tuple(content.sections),
        (
            *("run", *(() if fitted_by_run else vibration), *MECHANISM_COMMANDS),
            *(*_lookup(read.throw, read.material), *study),
        ),
        input_values(read),
        read.throw,
        _arrangement(read.engine),
        tuple(remarks),
        input_warnings(read),
        dict(read.throws_by_name),
        read.material,
    )


def excluded_designs(planned: PlannedStudy) -> tuple[str, ...]:
    """State how many designs of a study are excluded, and why the first one is."""
    runs = sum(design.role == RUN for design in planned.designs)
    excluded = [design for design in planned.excluded if design.role == RUN]
    if not excluded:
        return ()
    return (
        f"study: {len(excluded)} of {len(excluded) + runs} designs are excluded; reason for the first: "
        f"{excluded[0].reason.rstrip('.')}",
    )


def _power(read: EngineFile) -> tuple[str, ...]:
    """What is said of the power; one that does not fit is a warning already."""
    power = read.power
    return () if power is None or not power.consistent else (power.sentence,)


def _of_tables(read: EngineFile) -> list[str]:
    """State what was done to the samples of a pressure table."""
    if read.gas is None or read.gas.pressure_table is None:
        return []
    return [f"gas.pressure_table: {remark}" for remark in read.pressure[0].changes]


def _without_gas() -> str:
    return "without the section [gas], there are no gas forces, no amplitudes and no verdict"


def _arrangement(engine: Engine) -> Arrangement:
    def degrees(angles: Iterable[float]) -> tuple[float, ...]:
        return tuple(round(float(angle), 6) for angle in np.degrees(list(angles)))

    firing = degrees(engine.firing_angles)
    return made_from(
        engine,
        Arrangement,
        firing_order=engine.top_order,
        firing_angles_deg=tuple(firing[number - 1] for number in engine.top_order),
        firing_intervals_deg=tuple(engine.firing_intervals_deg),
        crank_angles_deg=degrees(engine.crank_angles),
        bank_angles_deg=None if engine.bank_angles is None else degrees(engine.bank_angles),
        mean_piston_speed=engine.mean_piston_speed(engine.rated_speed),
        driven_by=engine.driven_by or None,
    )
