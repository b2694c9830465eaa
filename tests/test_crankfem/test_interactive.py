"""Interactive figures: what they show are the objects' numbers at five digits, in small strict JSON.

Tolerances: numbers are rounded to 5 significant digits, so they are within 5e-5 of the objects' own;
thinned curves may miss a point by the share of the height that they are made with.
"""

import html
import json
import math
import re
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from comparing import close
from crankbase.diagrams import ON_PAPER, draw_diagram
from crankbase.errors import InputError
from crankfem.analyses.study.response_fits import fit_study, predicted
from crankfem.analyses.throw.formula_records import formulas_over_angle
from crankfem.report.figures import STUDY
from crankfem.report.interactive import vibration as vibration_plots
from crankfem.report.interactive.mechanism import MECHANISM, polar_load
from crankfem.report.interactive.plot import write_figure
from crankfem.report.interactive.study import parity, response_over_factors
from crankfem.report.interactive.style import (
    UNSEEN,
    design_texts,
    diagram_figure,
    plain_layout,
    rounded,
)
from crankfem.report.interactive.throw_view import (
    DRAWN_DISPLACEMENT,
    MOST_STRESSED,
    TriangleSurface,
    decimate_triangles,
    polylines,
    throw_view,
)
from crankfem.report.interactive.vibration import (
    VIBRATION,
    amplitudes_over_speed,
    axial_split,
    campbell_figure,
    mode_shapes,
    shaft_modes,
)
from dynamics.assessment.limits import LimitCurve, VibrationLimit
from dynamics.chains.chain import Chain
from dynamics.engine.forces import LoadDiagram
from dynamics.plots.curves import quantity_display
from dynamics.plots.load_diagrams import developed_load
from dynamics.response.damped_criticals import DampedCritical
from dynamics.response.series import OrderSeries
from fem.analysis import analyze_throw
from fem.fillet_stress import fillet_stresses
from geometry.throw import CrankThrow
from regression.plans.designs import DesignChoice
from regression.plans.factors import Factor
from regression.plans.plan import StudyPlan, plan_designs
from regression.records import Outcome
from regression.runs.study_table import study_table
from stand_ins import stress_coarsely

FIVE_DIGITS = 5e-5
RPM = 30.0 / math.pi


def floats(values):
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def named(traces, name):
    return next(trace for trace in traces if trace["name"] == name)


def written(plots, folder, run):
    """Write the interactive ones of some plots."""
    return [plot.write(folder, run) for plot in plots.of(run) if plot.interactive is not None]


def read(path, strict):
    figure = strict(path.read_text(encoding="utf-8"))
    assert set(figure) == {"data", "layout"}
    for trace in figure["data"]:
        if "y" in trace and trace["type"] == "scatter":
            assert len(trace["x"]) == len(trace["y"]) > 0, trace["name"]
    return figure


def units_told(figure):
    """Whether the titles of all axes that have one end with a unit."""
    titles = [
        part["title"]["text"]
        for name, part in figure["layout"].items()
        if name[1:5] == "axis" and part["title"]["text"]
    ]
    return titles and all("[" in title and "]" in title for title in titles)


# ---------------------------------------------------------------------------- numbers, thinning


def test_numbers_keep_five_digits():
    values = np.random.default_rng(1).normal(size=400) * 10.0 ** np.arange(-12, 8).repeat(20)
    assert rounded(values) == [float(f"{value:.5g}") for value in values]
    found = rounded([1234567.0, 0.0123456789, 2.0, -0.0, math.inf, -math.inf, math.nan])
    assert json.dumps(found) == "[1234600, 0.012346, 2, 0, null, null, null]"


def test_what_json_does_not_know_is_refused(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_figure(tmp_path / "x.json", [{"x": [math.nan]}], {})
    with pytest.raises(InputError, match="path: given"):
        write_figure(tmp_path / "missing" / "x.json", [], {})


# ------------------------------------------------------------------------------------ vibration


@pytest.fixture(scope="module")
def series():
    """Eight orders with resonances, order 4 without bounds at one speed."""
    orders, speeds = np.arange(1.0, 9.0), np.linspace(20.0, 60.0, 161)
    ratios = orders[:, None] * speeds / 190.0
    answer = 1e-4 / orders[:, None] / (1.0 - ratios**2 + 0.02j * ratios)
    unbounded = np.zeros(answer.shape, dtype=bool)
    unbounded[3, 110] = True
    return OrderSeries(
        orders, speeds, np.where(unbounded, 0.0, answer)[:, :, None], unbounded, ("free end",)
    )


def test_every_order_over_speed(series):
    def permitted(speeds):
        return 2e-4 + 0.0 * speeds

    limit = VibrationLimit(
        "amplitude",
        "free end",
        "rad",
        LimitCurve(permitted, 30.0),
        "here",
        LimitCurve(lambda speeds: 2.0 * permitted(speeds), 0.0, 50.0),
    )
    barred = [(25.0, 30.0), (40.0, 44.0)]
    traces, layout = diagram_figure(amplitudes_over_speed(series, 0, "twist", limit, barred), "x")
    assert layout["yaxis"]["title"]["text"] == "amplitude [mrad]"
    assert layout["xaxis"]["title"]["text"] == "crankshaft speed [1/min]"
    orders = [trace for trace in traces if trace["name"].startswith("order ")]
    # Those that are seen stand first in the legend.
    assert [trace.get("visible", True) for trace in orders] == [True] * 5 + ["legendonly"] * 3
    orders.sort(key=lambda trace: trace["name"])
    assert [trace["name"] for trace in orders] == [f"order {order}" for order in range(1, 9)]
    # Those that are seen have colors of their own.
    assert (
        len({trace["line"]["color"] for trace in orders if trace.get("visible", True) is True}) == 5
    )
    assert all(trace.get("visible", True) in (True, "legendonly") for trace in orders)
    shown = [(trace, series.amplitude[place, :, 0]) for place, trace in enumerate(orders)]
    both = series.synthesis
    shown.append((named(traces, "all orders (synthesis)"), both.amplitude[:, 0]))
    shown.append((named(traces, "plain sum"), both.plain_sum[:, 0]))
    top = layout["yaxis"]["range"][1]
    for trace, values in shown:
        x, y = floats(trace["x"]), floats(trace["y"])
        places = np.array([np.argmin(np.abs(series.speeds * RPM - one)) for one in x])
        assert x == close(series.speeds[places] * RPM, rel=FIVE_DIGITS)
        own = np.where(np.isfinite(values), 1e3 * values, np.nan)
        assert y == close(own[places], rel=FIVE_DIGITS, nan_ok=True)
        assert np.isnan(y).sum() == np.isinf(values).sum()
        known = np.isfinite(own)
        drawn = np.interp(series.speeds[known] * RPM, x[~np.isnan(y)], y[~np.isnan(y)])
        # Beside the thinning there is the rounding of x and y.
        assert np.abs(drawn - own[known]).max() < 3.0 * UNSEEN * max(top, np.nanmax(own))
    limits = {trace["name"]: trace for trace in traces if "limit" in trace["name"]}
    assert {name: trace.get("visible", True) for name, trace in limits.items()} == {
        "limit": True,
        "limit while passing": "legendonly",
    }
    for name, value in (("limit", 0.2), ("limit while passing", 0.4)):
        assert {one for one in limits[name]["y"] if one is not None} == {value}
        assert None in limits[name]["y"]  # where none is stated
    bands = [shape for shape in layout["shapes"] if shape["type"] == "rect"]
    assert [(one["x0"], one["x1"]) for one in bands] == [
        close((low * RPM, high * RPM)) for low, high in barred
    ]
    assert [one["showlegend"] for one in bands] == [True, False]
    lines = [shape for shape in layout["shapes"] if shape["type"] == "line"]
    assert [one["x0"] for one in lines] == [close(series.speeds[110] * RPM)]


@pytest.mark.parametrize(
    ("quantity", "title", "factor"),
    [
        ("twist", "amplitude [mrad]", 1e3),
        ("displacement", "amplitude [µm]", 1e6),
        ("stress", "alternating stress [MPa]", 1e-6),
    ],
)
def test_units_over_speed(series, quantity, title, factor):
    limit = VibrationLimit(
        "amplitude", "free end", "rad", LimitCurve(lambda speeds: 2e-4 + 0.0 * speeds), "here"
    )
    traces, layout = diagram_figure(amplitudes_over_speed(series, 0, quantity, limit, ()), "x")
    assert layout["yaxis"]["title"]["text"] == title
    unit = title.partition("[")[2].removesuffix("]")
    assert all(trace["hovertemplate"].endswith(f"}} {unit}<extra></extra>") for trace in traces)
    for name, values in (
        ("order 2", series.amplitude[1, :, 0]),
        ("all orders (synthesis)", series.synthesis.amplitude[:, 0]),
        ("plain sum", series.synthesis.plain_sum[:, 0]),
        ("limit", np.array([2e-4])),
    ):
        # Maxima are never thinned out.
        largest = factor * values[np.isfinite(values)].max()
        assert np.nanmax(floats(named(traces, name)["y"])) == close(largest, rel=5e-5)


def shaft(count=14):
    """Modes of a shaft of four nodes, listed out of their order along it, one of them rigid."""
    chance = np.random.default_rng(3)
    shares = chance.dirichlet(np.ones(3), count).T
    return SimpleNamespace(
        positions=np.array([0.0, 0.9, 0.3, 0.6]),
        names=tuple(f"mode {number}" for number in range(count)),
        rigid=1,
        frequencies=10.0 * np.arange(count),
        motions=chance.normal(size=(4, 6, count)),
        shares=tuple(shares),
        label=lambda mode: f"kind {mode}",
    )


def test_what_excites_the_axial_vibration():
    speeds = np.linspace(20.0, 60.0, 9)
    curves = [1e-5 * np.sin(speeds / number) ** 2 for number in (5.0, 6.0, 7.0)]
    split = SimpleNamespace(
        both_sum=np.where(speeds == 40.0, np.inf, curves[0]),
        tangential_sum=curves[1],
        radial_sum=curves[2],
    )
    traces, layout = diagram_figure(
        axial_split(SimpleNamespace(speeds=speeds, split=lambda _: split)), "x"
    )
    assert layout["yaxis"]["title"]["text"] == "axial amplitude of the free end [µm]"
    for name, values in (
        ("all forces", split.both_sum),
        ("tangential forces alone", split.tangential_sum),
        ("radial forces alone", split.radial_sum),
    ):
        trace = named(traces, name)
        places = np.rint((floats(trace["x"]) / RPM - 20.0) / 5.0).astype(int)
        own = np.where(np.isfinite(values), 1e6 * values, np.nan)[places]
        assert floats(trace["x"]) == close(speeds[places] * RPM, rel=FIVE_DIGITS)
        assert floats(trace["y"]) == close(own, rel=FIVE_DIGITS, nan_ok=True)
        assert np.isnan(own).any() == np.isinf(values).any()
        assert trace["hovertemplate"].endswith(" µm<extra></extra>")


# What plotly would read as bold, as a link, and as a value of the point under the mouse.
SHARP_NAME = "<b>R&D<a href=http://evil.example/> %{x}"


def texts(part):
    """All strings of a figure."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, dict | list | tuple):
        for inner in part.values() if isinstance(part, dict) else part:
            yield from texts(inner)


def test_names_are_no_markup(load, studied):
    shape = SimpleNamespace(
        modes=Chain([1.0, 1.0], [4e3]).modes(),
        chain=SimpleNamespace(nodes=(SHARP_NAME, "flywheel"), kind="axial"),
    )
    table, found = studied
    choice = Factor.of_labels("x", ("obround", SHARP_NAME))
    own = replace(load, name=SHARP_NAME)
    record = known_record()["angle_law"]
    fe = np.array(record["fe"])
    figures = [
        mode_shapes(shape, SHARP_NAME),
        campbell_figure(
            "axial", np.array([31.4]), np.ones(1), (4.0, 8.0), [resonance()], SHARP_NAME
        ),
        shaft_modes(shaft(), 0.2, SHARP_NAME),
        polar_load(own, "crank", SHARP_NAME),
        diagram_figure(developed_load(own), SHARP_NAME),
        diagram_figure(
            formulas_over_angle(np.array(record["gamma_deg"]), {SHARP_NAME: fe}, fe), "x"
        ),
        ({"text": design_texts((choice,), np.array([[0.0], [1.0]]))}, {}),
    ]
    for figure in figures:
        shown = [text for text in texts(figure) if "R&" in text]
        assert shown
        for text in shown:
            assert not re.search(r"<a|<b>R|%\{x\}", text)
            # Below an axis each word has a line.
            assert SHARP_NAME in html.unescape(text.replace("<br>", " "))
    # Menus are written by the page itself, which knows no markup.
    (menu,) = response_over_factors(table, found)[1]["updatemenus"]
    assert all(not re.search("[<>&]", button["label"]) for button in menu["buttons"])


def resonance(**changes):
    given = {
        "order": 4.5,
        "mode": 2,
        "speed": 2.0 * math.pi * 60.0 / 4.5,
        "amplitude": 1.234e-4,
        "first_amplitude": 1.234e-4,
        "place": "flywheel",
        "mode_share": 0.5,
        "in_band": True,
        "mode_frequency": 60.0,
        "damping_ratio": 0.02,
        "undamped_speed": 2.0 * math.pi * 60.0 / 4.5,
        "locked_speed": math.nan,
        "severity": 0.5,
    }
    return DampedCritical(**(given | changes))


def test_campbell_tells_what_meets():
    found = [
        resonance(),
        resonance(kind="major", order=6.0, speed=2.0 * math.pi * 10.0, severity=1.0),
        resonance(kind="major", order=5.0, speed=24.0 * math.pi, amplitude=math.inf),
    ]
    orders = np.arange(0.5, 6.1, 0.5)
    traces, layout = campbell_figure(
        "axial", np.array([31.4, 60.0, 500.0]), orders, (40.0, 80.0), found, "x"
    )
    lines = [trace for trace in traces if trace["name"] == "orders"]
    assert len(lines) == orders.size
    assert [line["showlegend"] for line in lines].count(True) == 1
    for order, line in zip(orders, lines, strict=True):
        assert floats(line["y"]) == close(order * floats(line["x"]) / 60.0, rel=1e-4)
        assert f"order {order:g}<br>" in line["hovertemplate"]
        assert max(line["y"]) <= layout["yaxis"]["range"][1] * (1.0 + FIVE_DIGITS)
    assert {trace["name"] for trace in traces if trace["name"].startswith("mode")} == {
        "mode 1",
        "mode 2",
    }
    minor, major = named(traces, "minor order"), named(traces, "major order")
    (told,) = minor["text"]
    assert all(text in told for text in ("order 4.5, mode 2", "800 1/min", "60 Hz", "123.4 µm"))
    assert (minor["x"], minor["y"]) == ([800], [60])
    assert "unbounded" in major["text"][1]
    assert major["marker"]["symbol"] == ["circle", "x"]
    assert major["marker"]["size"][0] > minor["marker"]["size"][0]
    assert layout["yaxis"]["title"]["text"] == "frequency [Hz]"
    assert layout["shapes"][0]["x0"] == close(40.0 * RPM)


def known_record():
    gammas = np.arange(0.0, 181.0, 30.0)
    fe = 1e-9 * (0.3 + gammas / 180.0)
    return {
        "angle_law": {
            "gamma_deg": gammas.tolist(),
            "fe": fe.tolist(),
            "formulas": {"Ours": [None, *(2e-9 * np.ones(6)).tolist()]},
        },
        "throw": {
            "supports": {
                "guided": {"axial_compliance": 0.3e-9},
                "pinned": {"axial_compliance": 1.3e-9},
            }
        },
    }


# ------------------------------------------------------------------------------------- mechanism


@pytest.fixture(scope="module")
def load():
    angles = np.linspace(0.0, 4.0 * np.pi, 720, endpoint=False)
    force = 1e4 * (2.0 + np.exp(1j * angles) + 0.3 * np.exp(-0.5j * angles))
    return LoadDiagram("crankpin 1", np.degrees(angles), force, np.degrees(0.4))


@pytest.mark.parametrize("frame", ["crank", "engine"])
def test_polar_load(load, frame):
    traces, layout = polar_load(load, frame, "x")
    curve, marks = traces
    own = 1e-3 * (load.in_crank_frame if frame == "crank" else load.force)
    assert curve["x"][0] == curve["x"][-1]
    assert curve["y"][0] == curve["y"][-1]
    for trace in traces:
        angles, sizes = np.array(trace["customdata"]).T
        places = np.rint(angles).astype(int)
        assert floats(trace["x"]) == close(own.imag[places], rel=FIVE_DIGITS, abs=1e-9)
        assert floats(trace["y"]) == close(own.real[places], rel=FIVE_DIGITS, abs=1e-9)
        assert sizes == close(1e-3 * load.magnitude[places], rel=FIVE_DIGITS)
    assert [angle for angle, _ in marks["customdata"]] == np.arange(0.0, 720.0, 30.0).tolist()
    assert layout["yaxis"]["scaleanchor"] == "x"
    spans = [np.ptp(layout[name]["range"]) for name in ("xaxis", "yaxis")]
    assert spans[0] == close(spans[1])
    assert "shaft angle" in curve["hovertemplate"]
    assert "kN" in curve["hovertemplate"]


def test_forces_of_a_mechanism(load, tmp_path, strict):
    values = np.stack([load.force.real, load.force.imag])
    run = SimpleNamespace(
        engine_file=SimpleNamespace(engine=SimpleNamespace(name="engine")),
        speed=100.0,
        balance=SimpleNamespace(rows=()),
        hinged_rods=None,
        crankpins=(load,),
        bearings=(load,),
        forces=SimpleNamespace(
            engine=SimpleNamespace(firing_deg=(180.0, 0.0), strokes=4),
            shaft_angles_deg=load.angles_deg,
            gas=values,
            tangential=-values,
            side=0.1 * values,
        ),
    )
    made = written(MECHANISM, tmp_path, run)
    assert [path.stem for path in made] == [
        "crankpin_polar",
        "crankpin_developed",
        "main_bearing_polar",
        "main_bearing_developed",
        "piston_forces",
    ]
    figures = [read(path, strict) for path in made]
    assert all(units_told(figure) for figure in figures)
    gas = figures[-1]["data"][0]
    # Counted from the firing top at 180 deg.
    places = (np.rint(gas["x"]).astype(int) + 180) % 720
    assert floats(gas["y"]) == close(1e-3 * values[0][places], rel=FIVE_DIGITS)


# ----------------------------------------------------------------------------------------- study


@pytest.fixture(scope="module")
def studied(request):
    """A small study of one response that an equation would give, with a choice among the factors."""
    throw = CrankThrow(**request.getfixturevalue("dimensions"))
    factors = (
        Factor("web_thickness", "m", 0.05, 0.09),
        Factor.of_labels("web_outline", ("obround", "rectangle")),
    )
    plan = StudyPlan(throw, factors, DesignChoice("latin hypercube", runs=12), held_out=4)
    planned = plan_designs(plan)
    outcomes = {}
    for place, design in enumerate(planned.designs):
        own = design.inputs["throw"]
        value = 1e-9 * (0.06 / own["web_thickness"]) ** 1.5 * (1.0 + 1e-3 * (place % 3))
        response = {"axial_compliance_pinned": value}
        outcomes[design.key] = Outcome(design.key, design.inputs, response, None, 1.0, errors={})
    table = study_table(plan, planned.designs, outcomes, (), planned.excluded)
    return table, fit_study(table)["axial_compliance"]


def test_study(studied, tmp_path, strict):
    table, found = studied
    made = written(STUDY, tmp_path, (table, found))
    assert [path.name for path in made] == ["response.json", "parity.json"]
    assert all(units_told(read(path, strict)) for path in made)
    traces, layout = response_over_factors(table, found)
    (menu,) = layout["updatemenus"]
    assert [button["label"] for button in menu["buttons"]] == ["web thickness h", "web outline"]
    first, second = (button["args"] for button in menu["buttons"])
    assert not any(a and b for a, b in zip(first[0]["visible"], second[0]["visible"], strict=True))
    assert [trace.get("visible", True) for trace in traces] == first[0]["visible"]
    assert second[1]["xaxis.ticktext"] == ["obround", "rectangle"]
    dots = named(traces, "other designs, moved to this line")
    assert all("web thickness" in text and " mm<br>web outline " in text for text in dots["text"])


def test_parity(studied):
    table, found = studied
    traces, layout = parity(table, found)
    column = table.responses[found.column]
    (menu,) = layout["updatemenus"]
    forms = [found.chosen, *(fit for fit in found.fits if fit is not found.chosen)]
    assert len(menu["buttons"]) == len(forms)
    for button, fit in zip(menu["buttons"], forms, strict=True):
        values = predicted(table, found, fit)
        off = 100.0 * np.abs(values / column - 1.0)[table.held_out].max()
        chosen = " (chosen)" if fit is found.chosen else ""
        assert button["label"] == f"{fit.form}{chosen}: held out within {off:.2g} %"
        shown = button["args"][0]["y"]
        for held, upper, lower in ((False, *shown[:2]), (True, *shown[2:])):
            own = table.held_out == held
            assert floats(upper) == close(1e9 * values[own], rel=FIVE_DIGITS)
            errors = 100.0 * (values[own] / column[own] - 1.0)
            assert floats(lower) == close(errors, rel=FIVE_DIGITS)
    assert [trace["y"] for trace in traces] == menu["buttons"][0]["args"][0]["y"]
    assert [len(trace["text"]) for trace in traces] == [12, 12, 4, 4]


# ------------------------------------------------------------------------------------- the throw


def box(count):
    """Surface of a unit cube with count by count squares on each side, and its outward normals."""
    steps = np.arange(count + 1) / count
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    squares = np.column_stack([corner, corner + count + 1, corner + count + 2, corner + 1])
    points, triangles = [], []
    for axis in range(3):
        for end in (0.0, 1.0):
            side = np.empty((u.size, 3))
            side[:, axis], side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = end, u, v
            own = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]])
            triangles.append((own if end else own[:, ::-1]) + sum(map(len, points)))
            points.append(side)
    unique, place = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return TriangleSurface(unique, place.ravel()[np.concatenate(triangles)])


def test_edges_and_shading_of_a_cube():
    cube = box(3)
    assert cube.face_normals.sum(axis=0) == close(np.zeros(3), abs=1e-12)
    ends, sides, sharp = cube.edges()
    assert len(ends) == len(sides) == 1.5 * len(cube.triangles)  # closed
    assert sharp.sum() == len(cube.sharp_edges()) == 12 * 3
    assert len(cube.sharp_edges(11.9)) == 36
    assert len(cube.sharp_edges(12.1)) == 0
    sources, triangles = cube.split_at_sharp_edges()
    assert np.array_equal(sources[triangles], cube.triangles)
    assert len(sources) == 6 * 16
    apart = TriangleSurface(cube.points[sources], triangles)
    # Each point has the normal of its one side.
    assert np.abs(apart.point_normals).max(axis=1) == close(np.ones(96), rel=1e-12)


def test_fewer_triangles_keep_shape_edges_and_steep_values():
    cube = box(12)
    values = np.zeros(len(cube.points))
    peak = int(np.argmin(np.linalg.norm(cube.points - [1.0, 0.5, 0.5], axis=1)))
    values[peak] = 1.0
    assert len(decimate_triangles(cube, values, 10**6).triangles) == len(cube.triangles) == 1728
    coarse = decimate_triangles(cube, values, 600)
    # Each move takes two triangles.
    assert len(coarse.triangles) == 600
    assert peak in np.unique(coarse.triangles)
    assert len(coarse.edges()[0]) == 1.5 * 600  # closed
    assert len(coarse.sharp_edges()) == 12 * 12
    # By the divergence theorem; flat sides stay flat but for round-off.
    corners = coarse.points[coarse.triangles]
    volume = np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume == close(1.0, rel=1e-12)


def test_what_cannot_go_unnoticed_stays():
    cube = box(4)
    # All points inside the six sides gone, edges as they were: 16 points round each side.
    coarse = decimate_triangles(cube, np.zeros(len(cube.points)), 10)
    assert 6 * 14 <= len(coarse.triangles) < len(cube.triangles)
    assert len(coarse.sharp_edges()) == 12 * 4


def test_trails_draw_each_edge_once():
    edges = np.array([[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [7, 8]])
    found = polylines(edges)
    drawn = [tuple(sorted(pair)) for one in found for pair in pairwise(one)]
    assert sorted(drawn) == sorted(tuple(sorted(pair)) for pair in edges.tolist())
    assert len(found) <= 3  # of six


@pytest.fixture(scope="module")
def throw(request):
    return CrankThrow(**request.getfixturevalue("dimensions"))


@pytest.fixture(scope="module")
def analysis(throw):
    return analyze_throw(throw, accuracy=0.1)


@pytest.mark.further
def test_throw_view(throw, analysis, tmp_path, strict, monkeypatch):
    import plotly.graph_objects

    stress_coarsely(monkeypatch)
    stresses = fillet_stresses(throw, accuracy=0.2)
    path = throw_view(tmp_path, analysis, stresses)
    assert path.name == "throw_view.json"
    assert path.stat().st_size < 1.5e6
    figure = strict(path.read_text(encoding="utf-8"))
    plotly.graph_objects.Figure(figure)
    traces, scene = figure["data"], figure["layout"]["scene"]
    for trace in traces:
        count = len(trace["x"])
        if trace["type"] == "mesh3d":
            numbers = np.array([trace[name] for name in "ijk"])
            assert np.array_equal(np.unique(numbers), np.arange(count))
        for name in "xyz":
            low, high = scene[f"{name}axis"]["range"]
            values = floats(trace[name])
            assert low <= np.nanmin(values)
            assert np.nanmax(values) <= high
    # One scale for all axes.
    scales = [scene["aspectratio"][name] / np.ptp(scene[f"{name}axis"]["range"]) for name in "xyz"]
    assert scales == close([scales[0]] * 3, rel=1e-4)
    solid = named(traces, "solid")
    # The whole throw, to a hundredth of a millimeter.
    assert np.ptp(solid["z"]) == close(1e3 * analysis.mesh.length, abs=0.02)
    assert min(solid["x"]) == close(-max(solid["x"]), abs=0.02)
    (menu,) = figure["layout"]["updatemenus"]
    changes = {button["label"]: button["args"][0] for button in menu["buttons"]}
    assert list(changes) == [
        "solid",
        "mesh",
        "deformed by an axial force",
        "stress, radial force",
        "stress, torque",
    ]
    assert [trace.get("visible", True) for trace in traces] == changes["solid"]["visible"]
    deformed, bent = named(traces, "deformed"), changes["deformed by an axial force"]
    moved = np.array([deformed[name] for name in "xyz"]) - np.array([solid[name] for name in "xyz"])
    sizes = np.linalg.norm(moved, axis=0)
    assert sizes.max() == close(DRAWN_DISPLACEMENT * 1e3 * analysis.mesh.length, rel=1e-3)
    # Colors are displacements for 1 kN; as much longer as the throw gets, its ends move apart.
    (shown,) = bent["intensity"]
    assert np.array(shown) * sizes.max() / max(shown) == close(sizes, abs=0.05)
    x, y, z = (np.array(solid[name]) for name in "xyz")
    heights = []
    for end in (z.min(), z.max()):
        here = z == end
        # End sections stay plane but tilt: what counts is how far the axis is moved.
        plane = np.column_stack([np.ones(here.sum()), x[here], y[here]])
        heights.append(np.linalg.lstsq(plane, moved[2, here])[0][0])
    pulled = (heights[1] - heights[0]) * max(shown) / sizes.max()
    compliance = analysis.supported("pinned").axial
    # Coordinates are rounded to a hundredth of a millimeter, displacements here are ten.
    assert pulled == close(1e9 * compliance, rel=2e-3)
    for label, kind in (("stress, radial force", "radial"), ("stress, torque", "torsion")):
        (values,) = changes[label]["intensity"]
        assert len(values) == len(named(traces, "fillet stress")["x"])
        largest = max(peak.von_mises for peak in stresses.peaks if peak.load.kind == kind)
        assert changes[label]["cmax"] == [close(1e-3 * largest)]
        # The surface shows its corner nodes: the largest of all may be a middle one.
        assert 0.8 * largest * 1e-3 < max(values)


@pytest.mark.slow
def test_vibration_of_an_engine(tmp_path, strict, coupled_vibration):
    import plotly.graph_objects

    run = coupled_vibration("6chn25-34")
    made = written(VIBRATION, tmp_path, run)
    assert [path.stem for path in made] == [
        "axial_modes",
        "axial_campbell",
        "axial_amplitude",
        "torsional_modes",
        "torsional_campbell",
        "torsional_amplitude",
        "axial_force",
        "torsional_stress",
        "deciding",
        "misfiring_stress",
        "shaft_modes",
        "axial_split",
    ]
    assert sum(path.stat().st_size for path in made) < 5e5
    figures = {path.stem: read(path, strict) for path in made}
    for name, figure in figures.items():
        plotly.graph_objects.Figure(figure)
        assert units_told(figure), name
    forced = run.forced_torsional
    for name in ("torsional_amplitude", "torsional_stress"):
        traces = figures[name]["data"]
        for order in forced.response.orders.tolist():
            named(traces, f"order {order:g}")
    worst = run.assessment.verdict.deciding
    deciding = figures["deciding"]
    curve = named(deciding["data"], "all orders (synthesis)")
    near = np.interp(worst.worst_speed * RPM, curve["x"], curve["y"])
    assert near == close(worst.worst_value / 1e6, rel=0.02)
    most = max(worst.cause.parts, key=lambda part: part.contribution)
    named(deciding["data"], f"order {most.order:g}")
    legend = [one["name"] for one in (*deciding["data"], *deciding["layout"]["shapes"])]
    assert len(set(legend)) <= 5
    check = run.misfiring.of_stress
    for name, found in (
        ("all cylinders firing", check.normal),
        (f"cylinder {check.cylinders[0]} not firing", check.misfiring),
    ):
        curve = named(figures["misfiring_stress"]["data"], name)
        near = np.interp(found.speed * RPM, curve["x"], curve["y"])
        assert near == close(found.value / 1e6, rel=0.02)
    assert named(figures["torsional_campbell"]["data"], "orders")["legendgroup"] == "orders"
    told = " ".join(
        text for trace in figures["torsional_campbell"]["data"] for text in trace.get("text", ())
    )
    assert all(f"order {one.order:g}, mode {one.mode}<" in told for one in forced.peaks)
    modes = run.whole.modes
    (menu,) = figures["shaft_modes"]["layout"]["updatemenus"]
    first = menu["buttons"][0]
    assert first["label"] == f"{modes.frequencies[modes.rigid]:.1f} Hz: {modes.label(modes.rigid)}"
    assert max(max(map(abs, curve["y"])) for curve in figures["shaft_modes"]["data"][:4]) == 1
    shape = run.torsional.chosen.modes.shapes[:, run.torsional.chosen.modes.rigid]
    drawn = figures["torsional_modes"]["data"][0]
    ends = run.torsional.chosen.chain.chain.connections[0]
    assert drawn["y"][:2] == rounded(shape[list(ends)])
    split = run.comparison.coupled.split("main bearing 1 uz")
    both = named(figures["axial_split"]["data"], "all forces")
    assert max(both["y"]) == close(1e6 * split.both_sum.max(), rel=FIVE_DIGITS)


def test_paper_and_screen_draw_the_same_curves(series):
    limits = {"limit": np.where(series.speeds < 30.0, np.inf, 2e-4)}
    barred = [(25.0, 30.0), (40.0, 44.0)]
    described = series.over_speed(0, quantity_display("twist", "SI"), limits=limits, barred=barred)
    traces, layout = diagram_figure(described, "x")
    axes = Figure().subplots()
    draw_diagram(axes, described)
    drawn = {one.get_label(): one for one in axes.get_lines()}
    assert axes.get_xlim() == close(layout["xaxis"]["range"])
    assert axes.get_ylim() == close(layout["yaxis"]["range"])
    assert axes.get_xlabel() == layout["xaxis"]["title"]["text"]
    assert axes.get_ylabel() == layout["yaxis"]["title"]["text"]
    seen = [trace for trace in traces if trace.get("visible", True) is True]
    assert {trace["name"] for trace in seen} == drawn.keys() - {"unbounded"}
    for trace in seen:
        line = drawn[trace["name"]]
        assert line.get_color() == trace["line"]["color"]
        assert line.get_linestyle() == ON_PAPER[trace["line"]["dash"]]
        assert np.nanmax(line.get_ydata()) == close(np.nanmax(floats(trace["y"])), rel=FIVE_DIGITS)
    assert len(axes.patches) == len(barred)


def test_the_stress_drawn_is_the_one_closest_to_its_limit(monkeypatch):
    """Of a plant, whose propeller shaft may be worse than the crankshaft."""

    def check(limit, place, unit="Pa"):
        limit = SimpleNamespace(name=limit, unit=unit)
        return SimpleNamespace(limit=limit, curve=SimpleNamespace(name=place))

    read = {
        "crankshaft_stress": SimpleNamespace(names=("cylinder",)),
        "shaft: line": SimpleNamespace(names=("first", "second")),
    }

    monkeypatch.setattr(vibration_plots, "limited_series", lambda *_: read)
    limits = {
        "axial_amplitude": SimpleNamespace(name="axial amplitude", unit="m"),
        "crankshaft_stress": SimpleNamespace(name="stress of crankshaft", unit="Pa"),
        "shaft: line": SimpleNamespace(name="stress of line", unit="Pa"),
    }
    worst_first = [
        check("axial amplitude", "free end", "m"),
        check("stress of line", "second"),
        check("stress of crankshaft", "cylinder"),
    ]
    run = SimpleNamespace(
        assessment=SimpleNamespace(limits=limits, verdict=SimpleNamespace(checks=worst_first)),
        forced_axial=0,
        forced_torsional=0,
        engine_file=0,
    )
    series, place, limit = vibration_plots._judged(run, vibration_plots._worst_stress(run))
    assert (series.names[place], limit.name) == ("second", "stress of line")
    del worst_first[1]
    series, place, limit = vibration_plots._judged(run, vibration_plots._worst_stress(run))
    assert (series.names[place], limit.name) == ("cylinder", "stress of crankshaft")


def test_a_title_of_two_lines_has_room():
    long = "8L 32/42 generating set, nominal torsional stress, cylinder 7 - cylinder 8"
    one, two = (plain_layout(title)["margin"]["t"] for title in ("8L 32/42, axial", long))
    assert two - one >= 1.3 * plain_layout(long)["title"]["font"]["size"]


@pytest.mark.slow
def test_throw_without_stresses_and_with_many_triangles(analysis, tmp_path, strict, monkeypatch):
    module = "crankfem.report.interactive.throw_view"
    monkeypatch.setattr(f"{module}.MOST_TRIANGLES", 2000)
    monkeypatch.setattr(f"{module}.MOST_EDGES", 100)
    figure = strict(throw_view(tmp_path, analysis).read_text(encoding="utf-8"))
    assert [trace["name"] for trace in figure["data"]] == ["solid", "sharp edges", "deformed"]
    assert 500 < len(figure["data"][0]["i"]) <= 2000 < MOST_STRESSED
    (menu,) = figure["layout"]["updatemenus"]
    assert len(menu["buttons"]) == 2
