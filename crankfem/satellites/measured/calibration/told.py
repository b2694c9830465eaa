"""A calibration in tables and sentences, each derived from its numbers."""

from collections.abc import Iterator

from crankbase.sentences import amount, finished
from crankbase.table import Column, Main, Table
from crankfem.satellites.measured.calibration.calibrated import Calibration, Untold, VerdictChange
from crankfem.satellites.measured.calibration.sampling import Samples

# Groups of a direction that are named, and groups of a change of the verdict.
MOST_NAMED, MOST_REASONS = 4, 3
# A change of a limit's use below this is none.
NO_CHANGE = 5e-4
# Orders with the largest residuals that are listed.
MOST_ORDERS = 8


def calibration_parts(made: Calibration) -> Iterator[Table | str]:
    """Write tables and sentences; the last one is the answer."""
    yield Table.of_records(
        "Factors on the maker's values, with 95 % intervals",
        made.groups,
        (Column("group", words=True), lambda row: row.name),
        (Column("factor", digits=5), lambda row: row.factor),
        (Column("from", digits=5), lambda row: row.low),
        (Column("to", digits=5), lambda row: row.high),
        *(
            (
                (Column("profile from", digits=5), lambda row: row.profile_low),
                (Column("to", digits=5), lambda row: row.profile_high),
            )
            if any(group.profile_low is not None for group in made.groups)
            else ()
        ),
        *(
            (
                (Column("samples from", digits=5), lambda row: row.sample_low),
                (Column("to", digits=5), lambda row: row.sample_high),
            )
            if made.samples is not None
            else ()
        ),
        (Column("tolerance", "%", 3), lambda row: row.tolerance),
        (Column("told by records", "%", 3), lambda row: row.determined),
        main=True,
    )
    if made.cylinders and made.status != "does not fit":
        yield Table.of_records(
            "Gas torque of each cylinder over the mean of the others, with 95 % intervals",
            made.cylinders,
            (Column("cylinder", words=True), lambda row: row.name),
            (Column("ratio", digits=5), lambda row: row.ratio),
            (Column("from", digits=5), lambda row: row.low),
            (Column("to", digits=5), lambda row: row.high),
            (Column("found if weaker by", "%", 3), lambda row: row.detectable),
        )
    worst = sorted(made.residuals, key=lambda row: -row.misfit)[:MOST_ORDERS]
    yield Table.of_records(
        "Residuals by order, the largest first, in deviations of the scatter",
        worst,
        (Column("record", words=True), lambda row: row.record),
        (Column("place", words=True), lambda row: row.place),
        (Column("order", digits=None), lambda row: row.order),
        (Column("residual", digits=3), lambda row: row.misfit),
    )
    for each in made.predicted:
        yield Main(
            f"Left out and predicted: {each.record} at {each.place}, {100.0 * each.inside:.0f} % of its "
            f"amplitudes within the 95 % band, whose half width is {100.0 * each.band:.2g} % at the median."
        )
    yield from (Main(_direction(each)) for each in made.untold)
    if made.cylinders and made.status != "does not fit":
        yield Main(_cylinders(made))
        ratios = (
            f"{each.name} {each.ratio:.3f} ({each.low:.3f} to {each.high:.3f})"
            for each in made.cylinders
        )
        yield Main(f"Gas torque of each cylinder over the mean of the others: {', '.join(ratios)}.")
    if made.verdict is not None:
        yield _limits(made.verdict)
        yield Main(_verdict(made.verdict))
    if made.unwritten:
        yield Main(
            f"No field of an engine file holds the factor of {', '.join(made.unwritten)}: neither what is "
            "written nor the verdict has it."
        )
    yield from made.remarks
    if made.samples is not None:
        yield _samples(made.samples)
    if made.lost_starts:
        yield (
            f"{made.lost_starts} of {made.starts} starts ended in a worse minimum; the best one is shown."
        )
    yield _agreement(made)


def _direction(each: Untold) -> str:
    """Say what the records cannot tell, by the groups that change most, and what would."""
    largest = sorted(each.parts.items(), key=lambda item: -abs(item[1]))
    changes = ", ".join(f"{name} {100.0 * share:+.3g} %" for name, share in largest[:MOST_NAMED])
    if len(largest) > MOST_NAMED:
        changes += f" and {len(largest) - MOST_NAMED} more"
    tells = "nothing of" if each.strength < 1e-3 else "less than the tolerances do of"
    would = (
        f"it would be told by {', '.join(each.remedies)}"
        if each.remedies
        else ("no other sensor on the chain, nor another running speed, would tell it")
    )
    return f"The records tell {tells} these together: {changes}; {would}."


def _samples(drawn: Samples) -> str:
    """Say how sure the intervals by samples are."""
    if not drawn.converged:
        return (
            "The samples have not converged: those of a walker hang together over so many steps that their "
            "number says nothing of the intervals."
        )
    return (
        f"The samples are worth {drawn.independent:.0f} independent ones: the ends of their intervals are "
        f"sure within {100.0 * drawn.error:.2g} % of the half width (one standard error)."
    )


def _cylinders(made: Calibration) -> str:
    """Name weak cylinders, or say that they cannot be told."""
    weak = [each for each in made.cylinders if each.weak]
    if weak:
        names = ", ".join(
            f"{each.name} ({100.0 * (1.0 - each.ratio):.2g} % less than the others, 95 % "
            f"{100.0 * (1.0 - each.high):.2g} to {100.0 * (1.0 - each.low):.2g} %)"
            for each in weak
        )
        return f"Weak: {names}."
    untold = [each.name for each in made.cylinders if not each.determined]
    if untold:
        would = (
            f" It would be told by {', '.join(made.cylinder_remedies)}."
            if made.cylinder_remedies
            else ""
        )
        return f"Whether a cylinder is weak by 20 % cannot be told of {', '.join(untold)}.{would}"
    least = max(each.detectable for each in made.cylinders)
    return f"No cylinder is weak: one weaker by {100.0 * least:.2g} % or more would be found."


def _limits(change: VerdictChange) -> Table:
    return Table.of_records(
        "Use of limits with the maker's values and with the fitted ones",
        change.limits,
        (Column("limit", words=True), lambda row: row.limit),
        (Column("place", words=True), lambda row: row.place),
        (Column("before", "%", 4), lambda row: row.before),
        (Column("after", "%", 4), lambda row: row.after),
        (Column("at", "1/min", 4), lambda row: row.speed_after),
        main=True,
    )


def _verdict(change: VerdictChange) -> str:
    """Say what changed in the verdict, and which groups changed the worst use."""
    same = change.status_before == change.status_after
    status = (
        f"Verdict as before: {change.status_after}"
        if same
        else f"Verdict before: {change.status_before}; now: {change.status_after}"
    )
    if not change.limits:
        return f"{status}."
    worst = change.limits[0]
    reasons = {name: share for name, share in change.by_group.items() if abs(share) >= NO_CHANGE}
    why = "; by each group alone, in points: " + ", ".join(
        f"{name} {100.0 * share:+.3g}" for name, share in [*reasons.items()][:MOST_REASONS]
    )
    return finished(
        f"{status}. Most used is {worst.limit} at {worst.place}: {100.0 * worst.before:.4g} % before, "
        f"{100.0 * worst.after:.4g} % now, at {amount(worst.speed_after, 'rad/s', 4)}"
        f"{why if reasons else ''}."
    )


def _agreement(made: Calibration) -> str:
    """Say whether the records fit."""
    judged = (
        f"misfit {made.misfit:.3g} of the scatter squared (by chance up to {made.limit:.3g}), "
        f"{100.0 * made.explained:.3g} % of the measured squares explained"
    )
    if made.status == "fits":
        return f"The records fit this engine: {judged}."
    if made.status == "fits roughly":
        return f"The records fit this engine beyond their scatter: {judged}; intervals are as much wider."
    pulled = f"; beyond their tolerances would be {', '.join(made.pulled)}" if made.pulled else ""
    slip = (
        f" They would fit with {made.slip} undone."
        if made.slip
        else f" Amplitudes are {made.size:.3g} times those calculated, at the median."
    )
    return f"The records do not fit this engine: {judged}{pulled}.{slip} Nothing is written."
