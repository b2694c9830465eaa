"""Causes of the difference in frequency between a whole crankshaft and its chain."""

from dataclasses import dataclass, replace

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.engine_chains import EngineChain
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.mode_matches import ModeMatch, match_modes
from dynamics.crankshaft.shaft_modes import crankshaft_modes
from dynamics.crankshaft.shaft_throw import RX, RY
from dynamics.crankshaft.stations import Stations

# Share of the shaft's own mass matrix that stays in every step: without any mass a motion has no frequency.
RESIDUAL = 1e-6
# Causes of less are not told [Hz]: they print as nothing.
SHOWN = 0.05
# In the order of the steps, each added to those before it; the last one is a body's of its own.
CAUSES = ("bearings", "mass distribution", "lateral inertia", "eccentric masses", "flywheel tilt")


@summarized("kind", "rigid_chain [Hz]", "chain [Hz]", "shaft [Hz]", "causes")
@dataclass(frozen=True)
class FrequencyDifference:
    """A mode's frequency in the chain and in the whole crankshaft, and the steps from one to the other.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    mode : int
        Elastic mode of the chain, from 1.
    rigid_chain : float
        Frequency of the chain in laterally rigid bearings [Hz].
    chain, shaft : float
        In the engine's bearings: of the chain, and of the whole crankshaft [Hz].
    causes : dict of str to float
        Contributions to the frequency [Hz]; their sum with `rigid_chain` is `shaft`. "bearings":
        lateral motion of the journals. "mass distribution": inertia along each throw in place of lumps, and
        inertia loads within the shaft, which the journals' reactions carry from throw to throw.
        "lateral inertia": that of the throws as if centered on the axis, and of the end bodies without the
        flywheel's diametral inertia. "eccentric masses": the throws' centers of mass off the axis.
        "flywheel tilt": the flywheel's diametral inertia resists the tilting of its section.
    further : float or None
        Of a second mode that the shaft divides the chain's into [Hz]: the steps lead to the first alone.
    """

    kind: str
    mode: int
    rigid_chain: float
    chain: float
    shaft: float
    causes: dict[str, float]
    further: float | None = None

    @property
    def sentence(self) -> str:
        """Such as "axial mode 1: 81.0 Hz by the whole crankshaft, 75.0 Hz by the chain (+6.0 Hz, ...)"."""
        name = f"{self.kind} mode {self.mode}"
        text = (
            f"{name}: {self.shaft:.1f} Hz by the whole crankshaft, {self.chain:.1f} Hz by the chain"
        )
        return f"{text} ({self.shown_causes})" if self.shown_causes else text

    @property
    def shown_causes(self) -> str:
        """The difference between crankshaft and chain in the same bearings, and its causes step by step.

        Causes of less than 0.05 Hz, and what rounding leaves, are told together, so that what is
        printed adds up.
        """
        shown = {
            name: f"{by:+.1f}"
            for name, by in self.causes.items()
            if name != CAUSES[0] and abs(by) >= SHOWN
        }
        if not shown:
            return ""
        difference = round(round(self.shaft, 1) - round(self.chain, 1), 1)
        rest = difference - sum(map(float, shown.values()))
        steps = [f"{name} {by} Hz" for name, by in shown.items()]
        if abs(rest) >= SHOWN:
            steps.append(f"rounding and smaller steps {rest:+.1f} Hz")
        return f"{difference:+.1f} Hz, step by step: {', '.join(steps)}"

    @property
    def tilt(self) -> "FlywheelTilt":
        """The last step: the effect of the flywheel's diametral inertia, which is often assumed."""
        without = self.shaft - self.causes[CAUSES[-1]]
        return FlywheelTilt(self.kind, self.mode, without, self.shaft, self.further)

    @property
    def largest(self) -> str:
        """Cause with the largest effect on the frequency."""
        return max(self.causes, key=lambda name: abs(self.causes[name]))


def frequency_difference(
    shaft: AssembledShaft, chain: EngineChain, rigid_chain: EngineChain, mode: int = 1
) -> FrequencyDifference:
    """Split the difference between a chain's frequency and that of the whole crankshaft.

    Parameters
    ----------
    shaft : AssembledShaft
    chain : EngineChain
        With the throws' compliances in the same bearings.
    rigid_chain : EngineChain
        With those in laterally rigid bearings.
    mode : int
        Elastic mode of the chain, from 1.

    Returns
    -------
    FrequencyDifference

    Raises
    ------
    InputError
        If the chain has no such mode, or the whole crankshaft has none similar to it.

    Notes
    -----
    Masses are added one kind after another, and the mode most similar to the chain's is followed. The
    contribution of a cause depends on the order of the steps; the sum does not. The flywheel, the last
    station, gets its diametral inertia last, so that its contribution is what a wrong value can change.
    """
    frequencies = [_elastic(rigid_chain, mode), _elastic(chain, mode)]
    for lateral in (False, True):
        on_axis = (1.0 - RESIDUAL) * _centered_mass(shaft, lateral=lateral)
        changed = replace(shaft, mass=on_axis + RESIDUAL * shaft.mass)
        frequencies.append(_found(_match(changed, chain, mode)))
    tilts = shaft.stations.motions[-1, [RX, RY]]
    light = replace(shaft, mass=shaft.mass - shaft.stations.diametral[-1] * tilts.T @ tilts)
    last = _match(shaft, chain, mode)
    frequencies += [_found(_match(light, chain, mode)), _found(last)]
    return FrequencyDifference(
        kind=chain.kind,
        mode=mode,
        rigid_chain=frequencies[0],
        chain=frequencies[1],
        shaft=frequencies[-1],
        causes=dict(zip(CAUSES, np.diff(frequencies).tolist(), strict=True)),
        further=last.further_frequency,
    )


@summarized("kind", "mode", "without [Hz]", "shaft [Hz]")
@dataclass(frozen=True)
class FlywheelTilt:
    """Effect of the flywheel's diametral inertia on a mode of the whole crankshaft.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    mode : int
        Elastic mode of the chain, from 1, that matches the mode.
    without, shaft : float
        Frequency without this inertia, and with that of the shaft [Hz].
    further : float or None
        Second frequency with it, where it divides the mode between two [Hz].
    """

    kind: str
    mode: int
    without: float
    shaft: float
    further: float | None = None

    @property
    def shown(self) -> bool:
        """Whether the inertia moves the frequency by 0.05 Hz or more."""
        return abs(self.shaft - self.without) >= SHOWN

    @property
    def sentence(self) -> str:
        """For example "torsional mode 1 from 75.0 Hz without to 84.0 Hz with it"."""
        name = f"{self.kind} mode {self.mode}"
        found = " and ".join(
            f"{one:.1f}" for one in sorted(filter(None, (self.shaft, self.further)))
        )
        return f"{name} from {self.without:.1f} Hz without to {found} Hz with it"


def _elastic(chain: EngineChain, mode: int) -> float:
    found = chain.chain.modes().elastic_frequencies
    if not 1 <= mode <= len(found):
        raise InputError(
            f"mode: given {mode}; allowed is 1 to {len(found)}, because the chain has so many elastic modes."
        )
    return float(found[mode - 1])


def _match(shaft: AssembledShaft, chain: EngineChain, mode: int) -> ModeMatch:
    number = chain.chain.modes().rigid + mode - 1
    return match_modes(shaft, crankshaft_modes(shaft), chain, [number])[0]


def _found(match: ModeMatch) -> float:
    if match.shaft_frequency is None:
        number = match.chain_mode - match.chain_rigid + 1
        raise InputError(
            f"mode: given {number}, {match.chain_frequency:.1f} Hz; allowed is one that the whole crankshaft "
            "has too, and none of its modes is like it."
        )
    return match.shaft_frequency


def _centered_mass(shaft: AssembledShaft, *, lateral: bool) -> FloatArray:
    """Mass matrix with all mass on the shaft axis: along and about it, and as requested across it.

    Without the diametral inertia of the last station, the flywheel.
    """
    stations: Stations = shaft.stations
    across = lateral * stations.lateral_mass
    tilting = lateral * np.append(stations.diametral[:-1], 0.0)
    diagonal = np.column_stack(
        (across, across, stations.axial_mass, tilting, tilting, stations.polar)
    )
    centered = np.einsum("siu,si,siv->uv", stations.motions, diagonal, stations.motions)
    return np.asarray(centered + shaft.added_mass.sum(axis=0))
