"""Causes of the difference in frequency between a whole crankshaft and its chain."""

from dataclasses import dataclass, replace

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.summaries import summarized
from dynamics.chains.engine_chains import EngineChain
from dynamics.crankshaft.assembly import AssembledShaft
from dynamics.crankshaft.mode_matches import match_modes
from dynamics.crankshaft.shaft_modes import crankshaft_modes
from dynamics.crankshaft.shaft_throw import RX, RY
from dynamics.crankshaft.stations import Stations

# Share of the shaft's own mass matrix that stays in every step: without any mass a motion has no frequency.
RESIDUAL = 1e-6
# Causes of less are not told [Hz]: they print as nothing.
SHOWN = 0.05
CAUSES = ("bearings", "mass distribution", "flywheel tilt", "lateral inertia", "eccentric masses")


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
        "flywheel tilt": mass and diametral inertia of the end bodies resist the tilting of their sections.
        "lateral inertia": that of the throws as if centered on the axis. "eccentric masses": the throws'
        centers of mass off the axis.
    """

    kind: str
    mode: int
    rigid_chain: float
    chain: float
    shaft: float
    causes: dict[str, float]

    @property
    def sentence(self) -> str:
        """Such as "axial mode 1: 81 Hz by the whole crankshaft, 75 Hz by the chain (flywheel tilt +6 Hz)"."""
        name = f"{self.kind} mode {self.mode}"
        text = (
            f"{name}: {self.shaft:.1f} Hz by the whole crankshaft, {self.chain:.1f} Hz by the chain"
        )
        return f"{text} ({self.shown_causes})" if self.shown_causes else text

    @property
    def shown_causes(self) -> str:
        """Causes of the difference between crankshaft and chain in the same bearings, largest first.

        Causes of less than 0.05 Hz are left out.
        """
        apart = {name: by for name, by in self.causes.items() if name != CAUSES[0]}
        shown = sorted(
            ((name, by) for name, by in apart.items() if abs(by) >= SHOWN),
            key=lambda one: -abs(one[1]),
        )
        return ", ".join(f"{name} {by:+.1f} Hz" for name, by in shown)

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
    contribution of a cause depends on the order of the steps; the sum does not.
    """
    frequencies = [_elastic(rigid_chain, mode), _elastic(chain, mode)]
    for tilt, lateral in ((False, False), (True, False), (True, True)):
        on_axis = (1.0 - RESIDUAL) * _centered_mass(shaft, tilt=tilt, lateral=lateral)
        changed = replace(shaft, mass=on_axis + RESIDUAL * shaft.mass)
        frequencies.append(_matched(changed, chain, mode))
    frequencies.append(_matched(shaft, chain, mode))
    return FrequencyDifference(
        kind=chain.kind,
        mode=mode,
        rigid_chain=frequencies[0],
        chain=frequencies[1],
        shaft=frequencies[-1],
        causes=dict(zip(CAUSES, np.diff(frequencies).tolist(), strict=True)),
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
    """

    kind: str
    mode: int
    without: float
    shaft: float

    @property
    def shown(self) -> bool:
        """Whether the inertia moves the frequency by 0.05 Hz or more."""
        return abs(self.shaft - self.without) >= SHOWN

    @property
    def sentence(self) -> str:
        """For example "torsional mode 1 from 75.0 Hz without to 84.0 Hz with it"."""
        name = f"{self.kind} mode {self.mode}"
        return f"{name} from {self.without:.1f} Hz without to {self.shaft:.1f} Hz with it"


def flywheel_tilt(shaft: AssembledShaft, chain: EngineChain, mode: int = 1) -> FlywheelTilt:
    """Find the effect of the flywheel's diametral inertia, often assumed, on a mode.

    Parameters
    ----------
    shaft : AssembledShaft
        With a flywheel, the last of its stations.
    chain : EngineChain
    mode : int
        Elastic mode of the chain, from 1.

    Returns
    -------
    FlywheelTilt

    Raises
    ------
    InputError
        As `frequency_difference`.
    """
    stations = shaft.stations
    tilts = stations.motions[-1, [RX, RY]]
    light = replace(shaft, mass=shaft.mass - stations.diametral[-1] * tilts.T @ tilts)
    return FlywheelTilt(
        chain.kind, mode, _matched(light, chain, mode), _matched(shaft, chain, mode)
    )


def _elastic(chain: EngineChain, mode: int) -> float:
    found = chain.chain.modes().elastic_frequencies
    if not 1 <= mode <= len(found):
        raise InputError(
            f"mode: given {mode}; allowed is 1 to {len(found)}, because the chain has so many elastic modes."
        )
    return float(found[mode - 1])


def _matched(shaft: AssembledShaft, chain: EngineChain, mode: int) -> float:
    modes = chain.chain.modes()
    number = modes.rigid + mode - 1
    match = match_modes(shaft, crankshaft_modes(shaft), chain, [number])[0]
    if match.shaft_frequency is None:
        raise InputError(
            f"mode: given {mode}, {match.chain_frequency:.1f} Hz; allowed is one that the whole crankshaft "
            "has too, and none of its modes is like it."
        )
    return match.shaft_frequency


def _centered_mass(shaft: AssembledShaft, *, tilt: bool, lateral: bool) -> FloatArray:
    """Mass matrix with all mass on the shaft axis: along and about it, and as requested across it."""
    stations: Stations = shaft.stations
    count = len(stations.axial_mass)
    bodies = np.arange(count) >= shaft.section_count + len(shaft.pin_throws)
    across = np.where(bodies, tilt, lateral)
    diagonal = np.column_stack(
        (
            across * stations.lateral_mass,
            across * stations.lateral_mass,
            stations.axial_mass,
            across * stations.diametral,
            across * stations.diametral,
            stations.polar,
        )
    )
    centered = np.einsum("siu,si,siv->uv", stations.motions, diagonal, stations.motions)
    added = shaft.added.T * shaft.added_inertia @ shaft.added
    return np.asarray(centered + added)
