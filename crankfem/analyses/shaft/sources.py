"""Compliances of an engine's throws from every source: finite elements, regression, formulas."""

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankbase.input_file import GivenFile
from crankbase.sentences import angle, kept, listed
from crankfem.analyses.shaft.throw_analyses import Analyses, analyses_by_name, crank_analyses
from crankfem.analyses.throw.law_record import LAW, LawAnswer, law_answers
from crankfem.files.chain.chain_file import PLANT, plant_chain
from crankfem.files.engine.engine_file import EngineFile
from crankfem.files.engine.throw_file import load_throw
from crankfem.files.reading.data_files import data_folder
from crankfem.files.reading.toml_file import TomlFile
from crankfem.files.sections.engine_sections import VibrationSettings
from dynamics.assessment.uncertainty import Spread
from fem.material import Material
from geometry.any_throw import Throw, with_dimensions
from geometry.throw import CrankThrow
from regression.formulas.axial_formulas import axial_formulas
from regression.formulas.case import FormulaValue
from regression.formulas.torsional_formulas import torsional_formulas
from regression.models.angle import between_values
from regression.response_kinds import AXIAL, TORSIONAL, fold_angle_deg

if TYPE_CHECKING:
    from fem.superelement import ShaftCompliances
    from regression.models.compliance_model import ComplianceModel
    from regression.models.lookup import Lookup

Answer = TypeVar("Answer")


def _of_each_throw(
    engine_file: EngineFile, look_up: Callable[[CrankThrow], Answer]
) -> dict[Throw, Answer]:
    """Look something up for each distinct throw of an engine; an error names the throw."""
    answers: dict[Throw, Answer] = {}
    for name, throw in engine_file.named_throws.items():
        try:
            answers[throw] = look_up(with_dimensions(throw))
        except InputError as error:
            which = f"throw {name}" if engine_file.throws_by_name else "this throw"
            raise InputError(f"does not apply to {which}: {kept(str(error)).rstrip('.')}") from None
    return answers


def law_values(engine_file: EngineFile, quantity: str) -> dict[Throw, LawAnswer]:
    """Find a compliance, ends pinned, of each distinct throw of an engine by the law.

    Parameters
    ----------
    quantity : {"axial_compliance", "torsional_compliance"}

    Raises
    ------
    InputError
        If the law does not cover one of the throws, with its name.
    """
    return _of_each_throw(
        engine_file, lambda throw: law_answers(throw, engine_file.material)[quantity]
    )


def refuse_law(engine_file: EngineFile) -> None:
    """Refuse the law as a source if it does not cover a throw."""
    vibration = engine_file.vibration
    for kind, source in (
        ("axial", vibration.axial_source),
        ("torsional", vibration.torsional_source),
    ):
        if source.casefold() != LAW:
            continue
        try:
            law_values(engine_file, f"{kind}_compliance")
        except InputError as error:
            raise InputError(
                f"vibration.{kind}_source: given 'law', which {kept(str(error))}; give another "
                "source, such as 'fe'."
            ) from None


REGRESSION = "regression"
# Source of the values that the option --model gives in place of a file's.
OPTION = "option --model"
RESPONSES = {"axial": AXIAL, "torsional": TORSIONAL}


def throw_lookup(
    model: "ComplianceModel", response: str, throw: CrankThrow, material: Material
) -> "Lookup":
    """Look a compliance up for a throw of an engine, only where the model knows its error.

    Parameters
    ----------
    response : {"axial_compliance", "torsional_compliance"}

    Raises
    ------
    InputError
        If the model lacks the response, the throw is not of its family or is outside the range of the fit,
        the material has another Poisson's ratio, or the band is unbounded.
    """
    if response not in model.responses:
        raise InputError(f"the model has {', '.join(model.responses)} and no {response}")
    lookup = model.of_material(material).lookup(response, **model.dimensions_of(throw))
    if not lookup.inside:
        raise InputError(" ".join(lookup.remarks))
    if lookup.lower is None or lookup.upper is None or not lookup.lower > 0.0:
        raise InputError(f"the band of {response} has no end ({lookup.band})")
    return lookup


def throw_lookups(
    engine_file: EngineFile, model: "ComplianceModel", response: str
) -> "dict[Throw, Lookup]":
    """Look a compliance up for each distinct throw of an engine.

    Raises
    ------
    InputError
        As `throw_lookup`, with the name of the throw.
    """
    return _of_each_throw(
        engine_file, lambda throw: throw_lookup(model, response, throw, engine_file.material)
    )


def chosen_regressions(vibration: VibrationSettings) -> dict[str, str]:
    """Return the kinds of vibration whose source is a regression, with the response that they need."""
    sources = {"axial": vibration.axial_source, "torsional": vibration.torsional_source}
    return {
        kind: RESPONSES[kind] for kind, source in sources.items() if source.casefold() == REGRESSION
    }


def refuse_regression(engine_file: EngineFile, model: "ComplianceModel | None") -> None:
    """Refuse a regression as a source if there is none, or if it does not cover the throws."""
    for kind, response in chosen_regressions(engine_file.vibration).items():
        if model is None:
            raise InputError(
                f"vibration.{kind}_source: given 'regression' without a fitted model; allowed is it with a "
                "saved one (vibration.model, or --model MODEL.json), or in crankfem run, which fits the "
                "section [study]."
            )
        try:
            throw_lookups(engine_file, model, response)
        except InputError as error:
            raise refused(engine_file, kind, str(error)) from None


def refused(engine_file: EngineFile, kind: str, reason: str) -> InputError:
    """Return the error of a regression that cannot be the source of a kind of vibration."""
    field = f"vibration.{kind}_source"
    chosen = f"{field}: given 'regression', which"
    if engine_file.provenance.get(field, ("", False))[0] == OPTION:
        chosen = f"--model: given {Path(engine_file.vibration.model or '').name}, which"
    return InputError(
        f"{chosen} {reason.rstrip('.')}; give a model whose range "
        "contains the throw, because its error is known nowhere else, or another source, such as 'fe'."
    )


def saved_model(engine_file: EngineFile) -> "ComplianceModel | None":
    """Read the model that an engine file names; None if it names none.

    Raises
    ------
    InputError
        If the file does not exist, or `ComplianceModel.load` cannot read it.
    """
    file = engine_file.model_file
    return None if file is None else _loaded(file, "vibration.model")


def _loaded(path: GivenFile, field: str) -> "ComplianceModel":
    try:
        from regression.models.compliance_model import (
            ComplianceModel,  # here: few files name a model
        )

        return ComplianceModel.load(path)
    except InputError as error:
        raise InputError(f"{field}: {kept(str(error))}") from None


def usable_model(
    engine_file: EngineFile, chosen: "ComplianceModel | None"
) -> "ComplianceModel | None":
    """Return the model given, else the one that the file names; None without either.

    Raises
    ------
    InputError
        If the file's model cannot be read, or a regression is to be the source of compliances and there is
        none, or it does not cover the engine's throws.
    """
    model = saved_model(engine_file) if chosen is None else chosen
    refuse_regression(engine_file, model)
    return model


def with_model(content: TomlFile, path: Path) -> TomlFile:
    """Return an engine file's sections with a saved model as the source of all that it contains.

    Parameters
    ----------
    path : Path
        Of the model, as seen from the working directory.

    Raises
    ------
    InputError
        If it is not a model, or contains neither the axial nor the torsional compliance.
    """
    held = _loaded(path, "--model").responses
    chosen = {
        f"{kind}_source": REGRESSION for kind, response in RESPONSES.items() if response in held
    }
    if not chosen:
        raise InputError(
            f"--model: given {path}, a model of {', '.join(held)}; allowed is one of "
            f"{' or '.join(RESPONSES.values())}, because the chains are made of these."
        )
    changed = {"model": str(path.absolute()), **chosen}
    vibration = {**content.sections.get("vibration", {}), **changed}
    origins = {f"vibration.{name}": (OPTION, False) for name in changed}
    return replace(
        content,
        sections={**content.sections, "vibration": vibration},
        provenance={**content.provenance, **origins},
    )


FE, FE_PINNED = "fe", "fe pinned"
# Of the torsional chain of a plant, as its maker gives it.
GIVEN = "given"
# The formulas know no free end: a throw tilts there as it does beside an opposite crank.
NO_NEIGHBOR_DEG = 180.0

# Source to the compliance of each throw, and how it was used.
Sources = dict[str, tuple[Array, str]]


def compliances_in_shaft(
    engine_file: EngineFile, analysis: Analyses, stiffness: float | None = None
) -> "ShaftCompliances":
    """Find the FE compliances of each throw at its position among the engine's cranks.

    Parameters
    ----------
    stiffness : float, optional
        Lateral, of each main bearing [N/m], ``math.inf`` for rigid ones; by default that of the engine.
    """
    from fem.superelement import shaft_compliances  # here: engine files are checked without it

    throws = [
        crank_analysis.superelement for crank_analysis in crank_analyses(engine_file, analysis)
    ]
    held = engine_file.main_bearings.stiffness if stiffness is None else stiffness
    return shaft_compliances(
        throws, crank_angles_deg=engine_file.throw_angles_deg, bearing_stiffness=held
    )


def axial_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: "ShaftCompliances",
    model: "ComplianceModel | None",
) -> Sources:
    """Axial compliance of each throw [m/N] by source; see `crankfem.analyses.vibration.modes`."""
    fitted = _fitted_sources(engine_file, analysis, model, "axial_compliance", shaft.axial)
    return fitted | axial_by_formulas(
        engine_file.crank_throws, engine_file.throw_angles_deg, engine_file.material
    )


def torsional_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    shaft: "ShaftCompliances",
    model: "ComplianceModel | None",
) -> Sources:
    """Torsional compliance of each throw [rad/(N m)] by source; only the maker's for a given plant."""
    if PLANT in engine_file.shaft_lines:
        # Half of the compliance on either side of each crank, in the plant's chain.
        chain = engine_file.shaft_lines[PLANT]
        nodes = plant_chain(chain, np.bincount(engine_file.throws).tolist()).throw_nodes
        halves = 0.5 / chain.stiffness
        # Before the first crank there may be nothing: it is taken to be as after it.
        after = halves[list(nodes)]
        before = np.concatenate((after[:1], after[:-1]))
        remark = "the chain of the plant as its maker gives it (shaft_line.plant)"
        return {GIVEN: (after + before, remark)}
    fitted = _fitted_sources(engine_file, analysis, model, "torsional_compliance", shaft.torsional)
    return fitted | torsional_by_formulas(engine_file.crank_throws, engine_file.material)


def _fitted_sources(
    engine_file: EngineFile,
    analysis: Analyses,
    model: "ComplianceModel | None",
    quantity: str,
    in_shaft: Array,
) -> Sources:
    """Compliances by finite elements, and by the equations and the law fitted to them."""
    each = crank_analyses(engine_file, analysis)
    pinned = np.array([getattr(throw, quantity)("pinned") for throw in each])
    fitted_sources: Sources = {
        FE: (in_shaft, "superelements assembled at the crank angles, in elastic main bearings"),
        FE_PINNED: (
            pinned,
            "a single throw with ends free to tilt, as in journals that move freely sideways; bearings "
            "stiffen it",
        ),
    }
    ratios = in_shaft / pinned
    if model is not None:
        fitted_sources[REGRESSION] = _looked_up(
            "equation", ratios, engine_file, lambda: throw_lookups(engine_file, model, quantity)
        )
    fitted_sources[LAW] = _looked_up(
        "law", ratios, engine_file, lambda: law_values(engine_file, quantity)
    )
    return fitted_sources


def _looked_up(
    name: str,
    ratios: Array,
    engine_file: EngineFile,
    look_up: "Callable[[], Mapping[Throw, Lookup | LawAnswer]]",
) -> tuple[Array, str]:
    """Looked-up values of each throw in the shaft; NaN where a throw has none."""
    try:
        values = look_up()
    except InputError as error:
        return np.full_like(ratios, np.nan), str(error)
    return (
        np.array([values[throw].value for throw in engine_file.crank_throws]) * ratios,
        f"the {name}'s pinned value, times each throw's ratio from the assembled superelements",
    )


def neighbor_angles(throw_angles_deg: Sequence[float]) -> list[tuple[float, float]]:
    """Return the angles between each throw and its neighbors [deg] from the throws' angles [deg]."""
    gaps = np.abs(np.diff(throw_angles_deg)).tolist()
    return list(zip((NO_NEIGHBOR_DEG, *gaps), (*gaps, NO_NEIGHBOR_DEG), strict=True))


def axial_by_formulas(
    throws: Sequence[Throw], throw_angles_deg: Sequence[float], material: Material
) -> Sources:
    """Formula values of each throw [m/N]: the mean of those at the angles to both neighbors.

    Parameters
    ----------
    throws : sequence of CrankThrow or ImportedThrow
        Of the cranks, from the free end; formulas have no values if one is from a file.
    throw_angles_deg : sequence of float
        Those of the cranks [deg].
    """

    @cache
    def formulas(throw: CrankThrow, gap: float) -> dict[str, FormulaValue]:
        return axial_formulas(throw, gap, material=material)

    # Of each throw: the angles to its neighbors, and the formulas at both.
    known = _all_dimensioned(throws)
    sides = [
        [(gap, formulas(throw, gap)) for gap in beside]
        for throw, beside in zip(known, neighbor_angles(throw_angles_deg), strict=False)
    ]
    sources: Sources = {}
    if not known:
        return sources
    for name in sides[0][0][1]:
        values = np.array([[table[name].value for _, table in beside] for beside in sides])
        wrong = {
            round(fold_angle_deg(gap))
            for beside in sides
            for gap, table in beside
            if not table[name].valid
        }
        ends = f"{angle(180.0)} at the shaft's ends"
        remark = f"mean of the formula at the angles to both neighbors; {ends}"
        if wrong:
            remark += f"; does not apply at {listed(np.radians(sorted(wrong)).tolist(), 'rad')}"
        sources[name] = (0.5 * (values[:, 0] + values[:, 1]), remark)
    return sources


def _all_dimensioned(throws: Sequence[Throw]) -> list[CrankThrow]:
    """Return throws of dimensions; none if one is from a file, for formulas know it not."""
    known = [throw for throw in throws if isinstance(throw, CrankThrow)]
    return known if len(known) == len(throws) else []


def torsional_by_formulas(throws: Sequence[Throw], material: Material) -> Sources:
    """Formula values of each throw [rad/(N m)]; arguments as `axial_by_formulas`."""
    known = _all_dimensioned(throws)
    tables = {throw: torsional_formulas(throw, material=material) for throw in dict.fromkeys(known)}
    if not known:
        return {}
    remark = "the same for every throw" if len(tables) == 1 else "by each throw's own dimensions"
    each = [tables[throw] for throw in known]
    wrong = f"{remark}; does not apply{'' if len(tables) == 1 else ' to every throw'}"
    return {
        name: (
            np.array([table[name].value for table in each]),
            remark if all(table[name].valid for table in each) else wrong,
        )
        for name in each[0]
    }


TABLE = "throw_compliances.csv"
# Of stiffnesses that a maker gives without saying how sure they are; an assumption.
MAKERS_ERROR = 0.05


@dataclass(frozen=True)
class AnalyzedThrow:
    """Compliances of a shipped engine's throw by finite elements.

    Attributes
    ----------
    axial : tuple of three float
        e_0 and e_180 [m/N] and rho of its angle law.
    torsional : float
        Ends pinned [rad/(N m)].
    error_estimate : float
        Relative, of the axial compliance.
    """

    throw: CrankThrow
    material: Material
    axial: tuple[float, float, float]
    torsional: float
    error_estimate: float


def source_spread(
    engine_file: EngineFile,
    kind: str,
    source: str,
    analysis: Analyses,
    shaft: "ShaftCompliances",
    model: "ComplianceModel | None",
) -> Spread:
    """Return the range of factors on the compliances of a source that contains the true ones.

    Parameters
    ----------
    kind : {"axial", "torsional"}
    source : str
        As named in `axial_sources` and `torsional_sources`; usable for this engine.

    Returns
    -------
    Spread
        Of all throws together, with its origin.
    """
    error = max(throw.error_estimate for throw in analyses_by_name(engine_file, analysis).values())
    if source == GIVEN:
        name = "error of the maker's stiffnesses, assumed"
        return Spread("compliance", 1.0 - MAKERS_ERROR, 1.0 + MAKERS_ERROR, name=name)
    if source in (FE, FE_PINNED):
        of = " (that of the axial compliance)" if kind == "torsional" else ""
        name = f"error of the finite elements{of}"
        return Spread("compliance", 1.0 - error, 1.0 + error, name=name)
    if source in (REGRESSION, LAW):
        bands: Iterable[Lookup | LawAnswer]
        if source == LAW:
            bands = law_values(engine_file, RESPONSES[kind]).values()
            name = "error of the law, not exceeded by 95 of 100 throws"
        else:
            assert model is not None
            lookups = throw_lookups(engine_file, model, RESPONSES[kind]).values()
            bands, meanings = lookups, dict.fromkeys(lookup.band for lookup in lookups)
            name = f"error of the regression ({'; '.join(meanings)})"
        ends = [
            (band.lower / band.value, band.upper / band.value)
            for band in bands
            if band.lower is not None and band.upper is not None
        ]
        lower, upper = zip(*ends, strict=True)
        return Spread("compliance", min(lower), max(upper), name=name)
    return _formula_spread(engine_file, kind, source, getattr(shaft, kind), error)


def _formula_spread(
    engine_file: EngineFile, kind: str, source: str, by_elements: Iterable[float], error: float
) -> Spread:
    """Range of a formula: its ratio to finite elements for shipped throws, and for the engine's own."""
    throws = engine_file.crank_throws
    here = _row(engine_file, kind, source, throws, engine_file.material) / sum(by_elements)
    ratios = [(here, error)]
    single = all(len(throw.parts.pins) == 1 for throw in throws)
    sides = np.array(neighbor_angles(engine_file.throw_angles_deg))
    for analyzed_throw in analyzed_throws():
        if single and len(analyzed_throw.throw.parts.pins) > 1:
            continue
        row = _row(
            engine_file, kind, source, [analyzed_throw.throw] * len(throws), analyzed_throw.material
        )
        if kind == "torsional":
            at_all_cranks = analyzed_throw.torsional * len(sides)
        else:
            ends = between_values(sides, analyzed_throw.axial)
            at_all_cranks = float(np.mean(ends, axis=1).sum())
        beside = row / at_all_cranks
        if beside > 0.0:
            ratios.append((beside, analyzed_throw.error_estimate))
    others = [beside for beside, _ in ratios[1:]]
    return Spread(
        "compliance",
        min(1.0, *((1.0 - off) / beside for beside, off in ratios)),
        max(1.0, *((1.0 + off) / beside for beside, off in ratios)),
        name=f"error of the formula {source} ({min(others):.2f} to {max(others):.2f} times finite elements "
        f"for the throws of {len(others)} shipped engines at the angles of these cranks, {here:.2f} times "
        "for the engine's own)",
    )


def _row(
    engine_file: EngineFile,
    kind: str,
    source: str,
    throws: Sequence[Throw],
    material: Material,
) -> float:
    """Sum of the compliances by a formula along the shaft, of these throws at the engine's cranks."""
    sources = (
        axial_by_formulas(throws, engine_file.throw_angles_deg, material)
        if kind == "axial"
        else torsional_by_formulas(throws, material)
    )
    return float(sources[source][0].sum())


@cache
def analyzed_throws() -> tuple[AnalyzedThrow, ...]:
    """Return the throws of the shipped engines with their compliances by finite elements."""
    text = (data_folder() / "tables" / TABLE).read_text(encoding="utf-8")
    throws = []
    for row in csv.DictReader(line for line in text.splitlines() if not line.startswith("#")):
        name, *numbers = row.values()
        in_line, opposite, ratio, torsional, error = map(float, numbers)
        throw, material = load_throw(name)
        throws.append(
            AnalyzedThrow(
                with_dimensions(throw), material, (in_line, opposite, ratio), torsional, error
            )
        )
    return tuple(throws)
