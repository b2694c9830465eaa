"""Limits on the frequencies of an engine, for the search of an optimum among its throws."""

from dataclasses import dataclass
from typing import Literal

from crankbase.array_checks import Array
from crankbase.errors import InputError
from crankfem.analyses.shaft.chains import (
    engine_axial_chain,
    engine_throw_inertias,
    engine_torsional_chain,
)
from crankfem.analyses.shaft.sources import compliances_in_shaft
from crankfem.analyses.shaft.throw_analyses import analyze_throws
from crankfem.files.engine.engine_file import EngineFile
from dynamics.chains.engine_chains import EngineChain
from regression.models.compliance_model import ComplianceModel
from regression.optimum import Limit

Kind = Literal["axial", "torsional"]


@dataclass(frozen=True, eq=False)
class EngineFrequencies:
    """First natural frequencies of an engine's crankshaft over the compliance of its throws.

    Modes of a coupling, a damper's ring or a shaft line are skipped (`EngineChain.first_mode`).
    In the shaft each throw has another compliance than when pinned; the ratio is
    calculated by finite elements of the engine's own throw, and kept constant.

    Attributes
    ----------
    engine_file : EngineFile
    axial_shares, torsional_shares : (n,) array
        Compliance of each throw in the shaft, divided by that of the pinned throw.
    throw_mass : float
        Of the engine's throw [kg], for models without mass.
    throw_inertias : (n,) array
        Of the throws with their shares of rods and pistons [kg m^2]; kept constant.
    axial_mode, torsional_mode : int or None
        Index of the mode that is the crankshaft's own first with the engine's throw: other throws change its
        shape, not its number. By default found for each compliance.
    """

    engine_file: EngineFile
    axial_shares: Array
    torsional_shares: Array
    throw_mass: float
    throw_inertias: Array
    axial_mode: int | None = None
    torsional_mode: int | None = None

    def axial(self, compliance: float, mass: float | None = None) -> float:
        """First axial natural frequency [Hz] for throws of this pinned compliance [m/N] and mass [kg]."""
        return first_frequency(
            engine_axial_chain(
                self.engine_file,
                compliance * self.axial_shares,
                self.throw_mass if mass is None else mass,
            ),
            self.axial_mode,
        )

    def torsional(self, compliance: float) -> float:
        """First torsional natural frequency [Hz] for throws of this pinned compliance [rad/(N m)]."""
        return first_frequency(
            engine_torsional_chain(
                self.engine_file, compliance * self.torsional_shares, self.throw_inertias
            ),
            self.torsional_mode,
        )


def first_frequency(named: EngineChain, mode: int | None = None) -> float:
    """Lowest frequency of the crankshaft itself [Hz], or that of the mode of an index."""
    modes = named.chain.modes()
    first = named.first_mode(modes) if mode is None else mode
    if first is None:
        raise InputError(
            f"--first-{named.kind}-frequency: given for an engine without a {named.kind} mode of the "
            "crankshaft itself; allowed is one with a mode that has half of its strain energy there or more."
        )
    return float(modes.frequencies[first])


def check_one_throw(engine_file: EngineFile) -> None:
    """Refuse an engine of several throws."""
    if len(set(engine_file.crank_throws)) > 1:
        raise InputError(
            f"{engine_file.path.name}: given an engine with several throws; allowed is one whose cranks are "
            "all the same throw, because the search changes that one."
        )


def engine_frequencies(engine_file: EngineFile) -> EngineFrequencies:
    """Prepare the frequencies of an engine; its throw is analyzed by finite elements (seconds)."""
    check_one_throw(engine_file)
    analysis = next(iter(analyze_throws(engine_file).values()))
    shaft = compliances_in_shaft(engine_file, analysis)
    inertias = engine_throw_inertias(engine_file, analysis.masses.inertia_about_shaft)
    chains = (
        engine_axial_chain(engine_file, shaft.axial, analysis.mass),
        engine_torsional_chain(engine_file, shaft.torsional, inertias),
    )
    axial_mode, torsional_mode = (named.first_mode(named.chain.modes()) for named in chains)
    return EngineFrequencies(
        engine_file=engine_file,
        axial_shares=shaft.axial / analysis.axial_compliance("pinned"),
        torsional_shares=shaft.torsional / analysis.torsional_compliance("pinned"),
        throw_mass=analysis.mass,
        throw_inertias=inertias,
        axial_mode=axial_mode,
        torsional_mode=torsional_mode,
    )


def frequency_limit(
    kind: Kind, frequencies: EngineFrequencies, model: ComplianceModel, at_least: float
) -> Limit:
    """Limit the first frequency of an engine's crankshaft.

    Parameters
    ----------
    kind : {"axial", "torsional"}
    model : ComplianceModel
        With mass among its responses the axial frequency follows the mass of the throw too.
    at_least : float
        [Hz].
    """
    name = f"first {kind} frequency"
    if kind == "torsional":
        return Limit(
            ("torsional_compliance",),
            at_least=at_least,
            function=frequencies.torsional,
            name=name,
            unit="Hz",
        )
    quantities = ("axial_compliance", *(["mass"] if "mass" in model.responses else []))
    return Limit(quantities, at_least=at_least, function=frequencies.axial, name=name, unit="Hz")
