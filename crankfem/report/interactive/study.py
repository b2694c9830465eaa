"""A study's equations: over each factor, and against finite elements."""

import re

from crankbase.diagrams import display_unit, math_symbol
from crankbase.quantity import percent
from crankfem.analyses.study.fit_plots import factor_diagram, parity_diagrams
from crankfem.analyses.study.response_fits import ResponseFits
from crankfem.report.interactive.style import (
    Figure,
    Part,
    axis,
    choice,
    described_traces,
    design_texts,
    layout,
    level,
    literal,
    marked_up,
    shape,
    visibility_by_choice,
    with_unit,
)
from regression.plans.factors import Factor
from regression.plots import factor_text
from regression.runs.study_table import StudyTable


def response_over_factors(table: StudyTable, response: ResponseFits) -> Figure:
    """Draw the chosen equation, and others beside it, over one factor at a time; see `factor_diagram`."""
    factors = table.plan.factors
    unit = with_unit("", marked_up(display_unit(response.unit)[0]))
    texts = design_texts(factors, table.values)
    diagrams = [
        factor_diagram(table, response, place, unit, texts) for place in range(len(factors))
    ]
    traces: list[Part] = []
    owners: list[int] = []
    for place, diagram in enumerate(diagrams):
        panel = described_traces(diagram)
        traces += [trace | ({} if place == 0 else {"visible": False}) for trace in panel]
        owners += [place] * len(panel)
    titles = [marked_up(diagram.x.label) for diagram in diagrams]
    changes = [
        [{"visible": visible}, {"xaxis.title.text": title, **_ticks(factor)}]
        for visible, title, factor in zip(
            visibility_by_choice(owners, len(factors)), titles, factors, strict=True
        )
    ]
    ticks = {name.removeprefix("xaxis."): value for name, value in _ticks(factors[0]).items()}
    # Menus know no markup.
    names = [
        re.sub("<sub>(.*)</sub>", r"_\1", marked_up(factor_text(factor.name))) for factor in factors
    ]
    return traces, layout(
        axis(titles[0], **ticks),
        axis(marked_up(diagrams[0].y.label)),
        title=f"{response.response.replace('_', ' ')} over one factor",
        updatemenus=[choice("over", names, changes)],
    )


# Axes of the two panels.
ABOVE: Part = {}
BELOW: Part = {"xaxis": "x2", "yaxis": "y2", "showlegend": False}


def parity(table: StudyTable, response: ResponseFits) -> Figure:
    """Draw one form at a time against finite elements: values above, errors in per cent below."""
    unit = with_unit("", marked_up(display_unit(response.unit)[0]))
    symbol = marked_up(math_symbol(response.symbol))
    texts = design_texts(table.plan.factors, table.values)
    forms = [response.chosen, *(fit for fit in response.fits if fit is not response.chosen)]
    diagrams = [parity_diagrams(table, response, fit, symbol, unit, texts) for fit in forms]
    shown = [
        [
            trace | panel
            for both in zip(*map(described_traces, pair), strict=True)
            for trace, panel in zip(both, (ABOVE, BELOW), strict=True)
        ]
        for pair in diagrams
    ]
    labels = [
        f"{fit.form}{' (chosen)' if fit is response.chosen else ''}: held out within "
        f"{percent(fit.largest_heldout_error or 0.0, 2)} %"
        for fit in forms
    ]
    # The menu changes the values alone.
    changes = [[{"y": [trace["y"] for trace in traces]}] for traces in shown]
    above, below = diagrams[0]
    assert above.diagonal is not None
    low, high = ((end, end) for end in above.diagonal)
    made = layout(
        axis("", matches="x2", showticklabels=False),
        axis(marked_up(above.y.label), domain=[0.42, 1.0]),
        title=f"{response.response.replace('_', ' ')}: equation against finite elements",
        height=560,
        shapes=[shape("line", low, high), level(2)],
        updatemenus=[choice("form", labels, changes)],
    )
    lower = {
        "xaxis2": axis(marked_up(below.x.label), anchor="y2"),
        "yaxis2": axis(below.y.label, domain=[0.0, 0.34], anchor="x2"),
    }
    return shown[0], made | lower


def _ticks(factor: Factor) -> Part:
    """Return how the axis of a factor differs from others, as changes of the layout."""
    if not factor.labels:
        return {"xaxis.tickmode": "auto", "xaxis.autorange": True}
    return {
        "xaxis.tickmode": "array",
        "xaxis.tickvals": list(range(len(factor.labels))),
        "xaxis.ticktext": [*map(literal, factor.labels)],
        "xaxis.autorange": True,
    }
