"""A whole crankshaft compared with its uncoupled chains, and whether the chains are adequate."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crankbase.checks.arrays import FloatArray
from crankbase.errors import InputError
from crankbase.library_types import Axes, DataFrame
from crankbase.summaries import summarized
from crankbase.tables.frames import table, table_of
from dynamics.chains.engine_chains import EngineChain, Kind
from dynamics.crankshaft.coupled_response import CoupledResponse
from dynamics.crankshaft.mode_matches import ModeMatch
from dynamics.plots.quantities import in_unit
from dynamics.plots.speed_curves import draw_named_curves
from dynamics.response.forced import ForcedResponse
from dynamics.response.synthesis import synthesis
from dynamics.running_limits import within

# A chain suffices where its frequencies, the purity of the modes and the free end's amplitude are within
# these. 3 % of frequency is what compliances from finite elements are worth; a share of 95 % leaves at
# most 5 % of a mode's energy to motion that the chain does not know; 10 % of amplitude is less than the
# uncertainty of any damping.
FREQUENCY_LIMIT = 0.03
SHARE_LIMIT = 0.95
RESPONSE_LIMIT = 0.10


@summarized("kind", "speeds [rad/s]", "chain", "shaft", "difference")
@dataclass(frozen=True, eq=False)
class ResponseMatch:
    """Amplitude of the free end by a chain and by the whole shaft.

    Half of the range over the working cycle, all orders together, without rigid-body motion.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    speeds : (S,) array
        [rad/s]
    chain, shaft : (S,) array
        [m or rad]; inf where unbounded.
    running_range : tuple of two floats
        Speeds [rad/s] within which the largest amplitudes are compared; all by default.
    """

    kind: Kind
    speeds: FloatArray
    chain: FloatArray
    shaft: FloatArray
    running_range: tuple[float, float] = (0.0, np.inf)

    @property
    def peaks(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speed [rad/s] and size [m or rad] of the largest amplitude: by the chain, and by the shaft.

        Each at its own worst speed of the running range.
        """
        inside = np.flatnonzero(within(self.speeds, *self.running_range))
        worst = [int(inside[np.argmax(curve[inside])]) for curve in (self.chain, self.shaft)]
        return (
            (float(self.speeds[worst[0]]), float(self.chain[worst[0]])),
            (float(self.speeds[worst[1]]), float(self.shaft[worst[1]])),
        )

    @property
    def difference(self) -> float:
        """Largest amplitude by the chain over that of the shaft, less 1."""
        (_, chain), (_, shaft) = self.peaks
        if chain == shaft:
            return 0.0
        return chain / shaft - 1.0 if 0.0 < shaft < np.inf else np.inf

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the amplitude of the free end by the chain and by the whole shaft over the speed.

        Parameters
        ----------
        axes : matplotlib.axes.Axes, optional
            Where to draw; new axes by default.

        Returns
        -------
        matplotlib.axes.Axes
            Curves have gaps where the vibration is unbounded.
        """
        drawn = in_unit("m" if self.kind == "axial" else "rad")
        curves = {"whole shaft": drawn.factor * self.shaft, "chain": drawn.factor * self.chain}
        title = f"{self.kind} vibration of the free end, all orders together"
        return draw_named_curves(axes, self.speeds, curves, drawn.label, title=title, dashed=True)

    def to_pandas(self) -> DataFrame:
        """Return a row for each speed: amplitude by the chain and by the shaft.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        unit = "m" if self.kind == "axial" else "rad"
        return table(
            {
                "speed": (self.speeds, "rad/s"),
                "chain": (self.chain, unit),
                "shaft": (self.shaft, unit),
            }
        )


@summarized("kind", "suffices", "reasons", "modes")
@dataclass(frozen=True)
class ChainVerdict:
    """Whether a chain is an adequate model of the whole shaft.

    Attributes
    ----------
    kind : {"axial", "torsional"}
    suffices : bool
    reasons : tuple of str
        Why it is inadequate, a sentence each; empty if it is adequate.
    modes : tuple of ModeMatch
        The modes compared.
    response : ResponseMatch or None
    """

    kind: Kind
    suffices: bool
    reasons: tuple[str, ...]
    modes: tuple[ModeMatch, ...]
    response: ResponseMatch | None

    def to_pandas(self) -> DataFrame:
        """Return a row for each mode that was compared; amplitudes are in ``response``.

        Returns
        -------
        pandas.DataFrame
            Units of the columns in ``attrs["units"]``.

        Raises
        ------
        MissingLibraryError
            If pandas is not installed.
        """
        return table_of(self.modes)


def matching_response(
    coupled: CoupledResponse,
    chain: EngineChain,
    answer: ForcedResponse,
    running_range: tuple[float, float] = (0.0, np.inf),
) -> ResponseMatch:
    """Compare the free end's amplitude by a chain with that by the whole shaft.

    Parameters
    ----------
    coupled : CoupledResponse
    chain : EngineChain
    answer : ForcedResponse
        Of the chain, under the same forces.
    running_range : tuple of two floats, optional
        As in `ResponseMatch`.

    Returns
    -------
    ResponseMatch

    Raises
    ------
    InputError
        If orders or speeds differ.
    """
    same = np.array_equal(coupled.speeds, answer.speeds)
    if coupled.further is None:
        same = same and np.array_equal(coupled.orders, answer.orders)
    if not same:
        raise InputError(
            f"answer: given {answer.orders.size} orders at {answer.speeds.size} speeds; allowed are the "
            "orders and speeds of the shaft's response, because amplitudes are compared one by one."
        )
    axial = chain.kind == "axial"
    # The free end's node comes first in either chain, before the first throw's.
    node = chain.sections[0] if axial else 0
    elastic = answer.elastic
    by_chain = synthesis(answer.orders, answer.speeds, elastic.values[:, :, node], answer.unbounded)
    return ResponseMatch(
        kind=chain.kind,
        speeds=coupled.speeds,
        chain=by_chain.amplitude,
        shaft=coupled.split("main bearing 1 uz" if axial else "main bearing 1 rz").both_sum,
        running_range=running_range,
    )


def chain_verdict(
    modes: Sequence[ModeMatch], response: ResponseMatch | None = None
) -> ChainVerdict:
    """Decide whether a chain is adequate.

    Parameters
    ----------
    modes : sequence of ModeMatch
        From `matching_modes`, of one kind.
    response : ResponseMatch, optional

    Returns
    -------
    ChainVerdict

    Raises
    ------
    InputError
        If there is no mode.

    Notes
    -----
    The criterion: every mode of the chain within the frequencies of interest has a match within 3 %, with
    at least 95 % of its energy of the chain's kind, and the largest amplitude of the free end at running
    speeds agrees within 10 %.
    """
    if not modes:
        raise InputError(
            "modes: given none; allowed is one or more, because a chain is judged by its modes."
        )
    kind = modes[0].kind
    reasons = []
    for match in modes:
        name = f"{kind} mode of the chain at {match.chain_frequency:.1f} Hz"
        if match.shaft_frequency is None:
            reasons.append(f"The whole shaft has no mode like the {name}.")
            continue
        if match.divided:
            modes_told = " and ".join(
                f"{frequency:.1f} Hz ({100.0 * share:.0f} % {kind})"
                for frequency, share in match.divided
            )
            reasons.append(f"The whole shaft has two modes like the {name}: {modes_told}.")
            continue
        if abs(match.difference) > FREQUENCY_LIMIT:
            reasons.append(
                f"The {name} differs from that of the whole shaft, at {match.shaft_frequency:.1f} Hz, by "
                f"{100.0 * match.difference:+.1f} %, more than {100.0 * FREQUENCY_LIMIT:.0f} %."
            )
        if match.share < SHARE_LIMIT:
            reasons.append(
                f"The whole shaft's mode at {match.shaft_frequency:.1f} Hz is only "
                f"{100.0 * match.share:.3g} % {kind}, less than {100.0 * SHARE_LIMIT:.0f} %."
            )
    if response is not None and abs(response.difference) > RESPONSE_LIMIT:
        reasons.append(
            f"The largest {kind} amplitude of the free end at running speeds differs by "
            f"{100.0 * response.difference:+.0f} % from that of the whole shaft, more than "
            f"{100.0 * RESPONSE_LIMIT:.0f} %."
        )
    return ChainVerdict(kind, not reasons, tuple(reasons), tuple(modes), response)
