"""A study's equations: over each factor, and against finite elements."""

from html import unescape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crankbase.diagrams import BLUE, ORANGE
from crankfem.analyses.study.fit_plots import factor_diagram
from crankfem.analyses.study.response_fits import ResponseFits, predicted
from crankfem.report.interactive.style import (
    Figure,
    Part,
    axis,
    choice,
    choice_labels,
    described_traces,
    design_texts,
    display_unit,
    dots,
    factor_text,
    factor_title,
    layout,
    level,
    rounded,
    symbol_text,
    visibility_by_choice,
    with_unit,
)
from regression.plans.factors import Factor
from regression.runs.study_table import StudyTable

Array = NDArray[np.float64]

KINDS = ((False, BLUE, "circle", "fitted runs"), (True, ORANGE, "diamond", "held out"))


def response_over_factors(table: StudyTable, response: ResponseFits) -> Figure:
    """Draw the chosen equation, and others beside it, over one factor at a time; see `factor_diagram`."""
    unit = display_unit(response.unit)[0]
    factors = table.plan.factors
    texts = design_texts(factors, table.values)
    traces: list[Part] = []
    owners: list[int] = []
    for place in range(len(factors)):
        shown_unit = with_unit("", unit)
        panel = described_traces(factor_diagram(table, response, place, shown_unit, texts))
        traces += [trace | ({} if place == 0 else {"visible": False}) for trace in panel]
        owners += [place] * len(panel)
    changes = [
        [{"visible": visible}, {"xaxis.title.text": factor_title(factor), **_ticks(factor)}]
        for visible, factor in zip(visibility_by_choice(owners, len(factors)), factors, strict=True)
    ]
    # A menu knows no markup.
    menu_texts = [
        unescape(factor_text(factor).replace("<sub>", "_").replace("</sub>", ""))
        for factor in factors
    ]
    ticks = {name.removeprefix("xaxis."): value for name, value in _ticks(factors[0]).items()}
    return traces, layout(
        axis(factor_title(factors[0]), **ticks),
        axis(f"{symbol_text(response.symbol)} [{unit}]"),
        title=f"{response.response.replace('_', ' ')} over one factor",
        updatemenus=[choice("over", menu_texts, changes)],
    )


def parity(table: StudyTable, response: ResponseFits) -> Figure:
    """Draw one form at a time against finite elements: values above, errors in per cent below."""
    unit, size = display_unit(response.unit)
    column = table.responses[response.column]
    texts = design_texts(table.plan.factors, table.values)
    symbol = symbol_text(response.symbol)
    forms = [response.chosen, *(fit for fit in response.fits if fit is not response.chosen)]
    values = [predicted(table, response, fit) for fit in forms]
    panels: tuple[tuple[list[Array], str, Part], ...] = (
        ([value / size for value in values], f"by the equation {with_unit('%{y:.5g}', unit)}", {}),
        (
            [100.0 * (value / column - 1.0) for value in values],
            "error of the equation %{y:+.2g} %",
            {"xaxis": "x2", "yaxis": "y2", "showlegend": False},
        ),
    )
    traces: list[Part] = []
    # Of each trace the values under each form: the menu changes nothing else.
    shown: list[list[list[Any]]] = []
    for held, color, mark, name in KINDS:
        those = np.flatnonzero(table.held_out == held)
        for by_form, hover, place in panels:
            shown.append([rounded(y[those]) for y in by_form])
            traces.append(
                dots(
                    column[those] / size,
                    by_form[0][those],
                    name,
                    color,
                    f"<b>{name}</b><br>%{{text}}<br>{symbol} by FE {with_unit('%{x:.5g}', unit)}<br>{hover}",
                    text=[texts[design] for design in those.tolist()],
                    marker={"symbol": mark},
                    legendgroup=name,
                    **place,
                )
            )
    labels = [
        f"{fit.form}{' (chosen)' if fit is response.chosen else ''}: held out within "
        f"{100.0 * (fit.largest_heldout_error or 0.0):.2g} %"
        for fit in forms
    ]
    changes = [[{"y": [drawn[number] for drawn in shown]}] for number in range(len(forms))]
    ends = [float(column.min() / size), float(column.max() / size)]
    diagonal = level(0.0) | {
        "xref": "x",
        "x0": ends[0],
        "x1": ends[1],
        "y0": ends[0],
        "y1": ends[1],
    }
    made = layout(
        axis("", matches="x2", showticklabels=False),
        axis(f"{symbol} by the equation [{unit}]", domain=[0.42, 1.0]),
        title=f"{response.response.replace('_', ' ')}: equation against finite elements",
        height=560,
        shapes=[diagonal, level(0.0, xref="x2 domain", yref="y2")],
        updatemenus=[choice("form", labels, changes)],
    )
    lower = {
        "xaxis2": axis(f"{symbol} by FE [{unit}]", anchor="y2"),
        "yaxis2": axis("error [%]", domain=[0.0, 0.34], anchor="x2"),
    }
    return traces, made | lower


def _ticks(factor: Factor) -> Part:
    """Return how the axis of a factor differs from others, as changes of the layout."""
    if not factor.labels:
        return {"xaxis.tickmode": "auto", "xaxis.autorange": True}
    return {
        "xaxis.tickmode": "array",
        "xaxis.tickvals": list(range(len(factor.labels))),
        "xaxis.ticktext": choice_labels(factor),
        "xaxis.autorange": True,
    }
