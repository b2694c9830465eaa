"""Difference of an engine's whole crankshaft from its chains, its causes, and the remarks on it."""

from dataclasses import replace

import numpy as np

from crankbase.errors import InputError
from crankbase.units.number_formats import UNBOUNDED, significant
from crankbase.units.units import RPM
from crankfem.analyses.shaft.motion import MOTION
from crankfem.analyses.shaft.whole_shaft import ShaftComparison, WholeShaft
from dynamics.chains.engine_chains import EngineChain
from dynamics.crankshaft.chain_comparison import (
    FREQUENCY_LIMIT,
    RESPONSE_LIMIT,
    ChainVerdict,
    frequency_difference,
)


def with_differences(
    comparison: ShaftComparison,
    whole: WholeShaft,
    chains: tuple[EngineChain, ...],
    rigid_chains: tuple[EngineChain, ...],
) -> ShaftComparison:
    """Add to a comparison the causes of the difference of the crankshaft's first frequencies.

    Parameters
    ----------
    comparison : ShaftComparison
    whole : WholeShaft
    chains, rigid_chains : tuples of EngineChain
        Axial and torsional, in the engine's main bearings and in laterally rigid ones.

    Returns
    -------
    ShaftComparison
        Without a chain whose first mode has no counterpart at every step, or is divided between two;
        unchanged if no chain is compared.
    """
    if not comparison.verdicts:
        return comparison
    shaft, found = whole.crankshaft.shaft, []
    for chain, rigid in zip(chains, rigid_chains, strict=True):
        modes = chain.chain.modes()
        first = chain.first_mode(modes)
        if first is None:
            continue
        number = first - modes.rigid + 1
        try:
            found.append(frequency_difference(shaft, chain, rigid, number))
        except InputError:
            continue
    # Steps lead to one frequency, not to two.
    whole_ones = tuple(one for one in found if one.further is None)
    return replace(comparison, differences=whole_ones, tilts=tuple(one.tilt for one in found))


def whole_shaft_remark(comparison: ShaftComparison) -> tuple[str, ...]:
    """Remark on a verdict, which is based on the chains, how the whole crankshaft differs from them.

    Returns
    -------
    tuple of str
        A sentence; none if the chains are adequate.
    """
    differing = [one for one in comparison.verdicts[::-1] if not one.suffices]
    if not differing:
        return ()
    told = "; ".join(map(_difference, differing))
    which = "which are" if len(differing) > 1 else f"of which the {differing[0].kind} one is"
    return (
        f"The verdict uses lumped models (chains), {which} inadequate here; the whole crankshaft differs: "
        f"{told}.",
    )


def _difference(verdict: ChainVerdict) -> str:
    """State the main difference: an amplitude, a frequency, else a mode of mixed motion."""
    motion, found = MOTION[verdict.kind], verdict.response
    if found is not None and abs(found.difference) > RESPONSE_LIMIT:
        chain, shaft = (
            f"{motion.number(peak)} {motion.printed} at {significant(speed * RPM, 3)} 1/min"
            if np.isfinite(peak)
            else UNBOUNDED
            for speed, peak in found.peaks
        )
        return (
            f"largest {verdict.kind} amplitude of the free end at running speeds {shaft} instead of "
            f"{chain}"
        )
    for match in verdict.modes:
        number = match.chain_mode - match.chain_rigid + 1
        if match.shaft_frequency is None:
            return f"it has no mode like {verdict.kind} mode {number}"
        if match.divided:
            told = " and ".join(f"{frequency:.1f}" for frequency, _ in match.divided)
            return (
                f"two modes at {told} Hz instead of {verdict.kind} mode {number} at "
                f"{match.chain_frequency:.1f} Hz"
            )
        if abs(match.difference) > FREQUENCY_LIMIT:
            return (
                f"{verdict.kind} mode {number} at {match.shaft_frequency:.1f} instead of "
                f"{match.chain_frequency:.1f} Hz"
            )
    mixed = min(verdict.modes, key=lambda match: match.share)
    return (
        f"its {verdict.kind} mode at {mixed.shaft_frequency:.1f} Hz is only {100.0 * mixed.share:.3g} % "
        f"{verdict.kind}"
    )
