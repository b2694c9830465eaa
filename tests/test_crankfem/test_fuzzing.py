"""A share of the campaign of tests/campaigns/fuzzing.py, and what it has found before."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import crankfem as cf
from crankbase.errors import InputError
from crankbase.written_quantity import parse_quantity
from crankfem.cli import app as cli
from dynamics.engine.rods import PointMotion
from dynamics.strength.concentration import SupportedThrow
from regression.plans.relations import read_expression
from satellite_cases import of_satellites
from strategies import command_lines
from strategies.calls import wrong_calls
from strategies.outcomes import NOT_FINITE, TRACEBACK, outcome_of
from strategies.parsers import lay_out, parsers
from strategies.recording import Recorder

# Of each kind; the campaign by hand gives 20,000.
FEW = settings(
    max_examples=6,
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
QUICK = [name for name, parser in parsers().items() if parser.share == 1.0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("fuzzing")
    lay_out(made)
    command_lines.lay_out(made)
    return made


@pytest.mark.parametrize("name", QUICK)
def test_wrong_files_get_a_sentence_or_a_finite_result(name, folder):
    parser = parsers()[name]

    @FEW
    @given(content=parser.inputs)
    def attempt(content):
        outcome = parser.attempt(content, folder)
        assert outcome.good, outcome.text

    attempt()


@FEW
@given(line=command_lines.command_lines())
def test_wrong_command_lines(folder, line):
    outcome = command_lines.run_command(line, folder)
    assert outcome.good, outcome.text


@pytest.mark.parametrize("name", of_satellites("ASKED"))
def test_wrong_questions(folder, name):
    questions, asking = of_satellites("ASKED")[name]
    ask = asking(folder)

    @FEW
    @given(question=questions())
    def attempt(question):
        outcome = ask(question)
        assert outcome.good, outcome.text

    attempt()


@pytest.fixture(scope="module")
def calls():
    """Calls of public functions as a small piece of work makes them."""
    with Recorder() as recorder:
        chain = cf.Chain([1.0, 2.0, 3.0], [1e6, 2e6], loss_factor=0.02)
        excitation = cf.OrderExcitation([1.0, 2.0], [50.0, 60.0], np.ones((2, 2, 3)))
        response = cf.forced_response(cf.damped(chain, magnifier=30.0), excitation)
        cf.resonances(response)
        cf.response.element_loads(response)
        cf.chains.critical_speeds([10.0, 20.0], [1.0, 2.0], (5.0, 90.0))
        cf.limits.frequency_bounds(chain, [cf.limits.Spread("stiffness", 0.9, 1.1)])
        cf.harmonics(np.sin(np.arange(72.0)), 4)
        cf.strength.fatigue_strength(6e8, 0.2, 0.012)
        cf.dampers.viscous_damper_for(chain, 0, 0.2)
        cf.axial_law(cf.load_throw("6chn25-34")[0])
    return recorder.calls


@pytest.mark.slow
def test_wrong_calls_of_public_functions(calls):
    assert len(calls) > 12

    @settings(FEW, max_examples=60)
    @given(call=wrong_calls(calls))
    def attempt(call):
        outcome = call.outcome()
        assert outcome.good, outcome.text

    attempt()


def test_outcomes_are_told_apart():
    assert outcome_of(lambda: 1 / 0).kind == TRACEBACK
    assert outcome_of(lambda: np.log(np.array([-1.0]))).kind == TRACEBACK
    assert outcome_of(lambda: {"a": [1.0, np.inf]}).kind == NOT_FINITE
    assert outcome_of(lambda: cf.Chain([-1.0], [])).good

    def refuse():
        raise InputError("ValueError at <class 'x'>")

    assert outcome_of(refuse).kind == TRACEBACK


# What the campaign found, one line each.


def chain_of_two():
    return cf.Chain([1.0, 2.0], [1e6])


def throw():
    return SupportedThrow(0.4, [0.2], np.ones((1, 4)), np.ones((1, 4)))


def series():
    speeds, bounded = np.array([50.0, 60.0]), np.zeros((1, 2), dtype=bool)
    return cf.response.OrderSeries(np.ones(1), speeds, np.ones((1, 2, 1)) + 0j, bounded, ("a",))


def torque():
    from dynamics.plots.curves import quantity_display

    return quantity_display("torque", "SI")


def samples():
    return cf.limits.chain_samples(chain_of_two(), [], lambda one: one.stiffness, samples=4)


FOUND = {
    "unit to the power of zero": lambda: parse_quantity("3 a^0", "m", "field"),
    "power with zeros in front": lambda: parse_quantity("3 a^001", "m", "field"),
    "unit that is no number": lambda: parse_quantity("3 nan", "m", "field"),
    "relation with no number": lambda: read_expression("nan * mm", "field", {}),
    "percentile": lambda: samples().percentile(1e9),
    "millions of chains": lambda: cf.limits.chain_samples(chain_of_two(), [], float, samples=10**6),
    "no parts": lambda: cf.chains.ShaftCone(0.7, 0.2, 0.2).divided(0),
    "too many parts": lambda: cf.chains.ShaftCone(0.7, 0.2, 0.2).divided(10**6),
    "cylinder": lambda: cf.load_mechanism("8chn26-26").layout.main_of(9),
    "motion of a cylinder": lambda: cf.mechanism.cylinder_motion(
        cf.load_mechanism("8chn26-26").layout, 0, shaft_angles_deg=[0.0, 30.0]
    ),
    "inertia without rods": lambda: cf.mechanism.reduced_inertia(
        cf.load_mechanism("8chn26-26").layout, (), shaft_angles_deg=[0.0, 30.0]
    ),
    "speeds at other places": lambda: PointMotion(
        np.ones(3), np.ones(3), np.ones(3)
    ).acceleration(np.ones(4)),
    "speed that is none": lambda: PointMotion(
        np.ones(3), np.ones(3), np.ones(3)
    ).velocity(np.nan),
    "moment of no forces": lambda: throw().moment(0.1, np.ones((0, 4))),
    "shear of other forces": lambda: throw().shear(0.1, np.ones((2, 4))),
    "Findley's limit": lambda: cf.strength.findley_limit(3e8, np.nan),
    "Findley's plane": lambda: cf.strength.critical_plane(np.ones((5, 3)), np.inf),
    "stress of a fillet": lambda: cf.strength.fillet_equivalent(1e8, -np.inf, 0.0),
    "stress of a hole": lambda: cf.strength.hole_equivalent(np.nan, 1e8),
    "fewer points than none": lambda: cf.balances.Hodograph(1, 2.0 + 0.0j, 1.0 + 0.0j).points(-1),
    "speed without end": lambda: cf.excitation.axial_force_over_cycle(
        np.inf, np.ones((2, 1, 2)), [1e-9], np.full((1, 1, 2), 1e-10), shaft_angles_deg=[0.0, 30.0]
    ),
    "fewer sections than none": lambda: cf.crankshaft.MainBearings(1e9, 1e4).at(-1),
    "direction without end": lambda: cf.balances.Hodograph(1, 2.0 + 0.0j, 1.0 + 0.0j).amplitude_along(
        angle_deg=np.inf
    ),
    "curves that are limits": lambda: cf.judge([()], (50.0, 60.0), cf.limits.BarredRangeRule(100.0)),
    "limit next to nothing": lambda: cf.studies.Limit(("axial_compliance",), at_most=5e-324),
    "length of a web": lambda: cf.strength.CrankWeb(0.2, 0.2, 0.1, 0.1, 0.3, 0.01, 0.01).ratio("depth"),
    "negative seed": lambda: cf.limits.frequency_samples(
        cf.Chain([1.0, 2.0], [1e5]), (cf.limits.Spread("stiffness", "stiffness", 0.9, 1.1, (0,)),), seed=-1
    ),
    "motion turned without end": lambda: PointMotion(
        np.ones(3), np.ones(3), np.ones(3)
    ).turned(angle_deg=np.inf),
    "strength without end": lambda: cf.strength.SurfaceTreatment(
        "induction", 0.003, 500.0
    ).transition_strength(np.inf),
    "point of a pressure map": lambda: cf.excitation.pressure_map([(1.0, 2.0)]),
    "law of no throws": lambda: cf.formulas.axial_laws(
        crank_radius=0.17, main_journal_diameter=0.22, pin_diameter=0.18, main_journal_length=0.12,
        pin_length=0.139, web_width=0.3, web_thickness=[], fillet_radius=0.012,
    ),
    "outward of an end body": lambda: cf.crankshaft.EndBody(30.0, 1.5).mass_matrix(np.nan),
    "no values that alternate": lambda: cf.strength.alternating([]),
    "barred range of nothing": lambda: series().over_speed(0, torque(), barred=[()]),
    "running range of three": lambda: series().over_speed(0, torque(), running=(50.0, 60.0, 60.0)),
    "name of nothing": lambda: cf.CrankThrow.from_text({" ": "3 mm"}),
    "torque of 1,000 cylinders": lambda: cf.excitation.torque_harmonics(
        cf.harmonics(np.sin(np.arange(72.0)), 4), 3.0, firing_angles_deg=np.arange(1000.0), crank_radius=0.1
    ),
}  # fmt: skip


@pytest.mark.parametrize("found", FOUND)
def test_what_was_found_is_refused(found):
    outcome = outcome_of(FOUND[found])
    assert outcome.kind == "refused", outcome


def test_the_command_line_refuses_a_unit_that_is_no_number(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["crankfem", "two-mass", "yamz-5340", "--units", "nan"])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 2
    assert "nan" in capsys.readouterr().err


def test_a_number_within_an_array_shows_itself():
    assert "1.5" in repr(cf.limits.Samples((), np.ones((2, 0)), np.ones(2), np.array(1.5)))


def test_no_main_orders_where_no_speed_counts():
    from dynamics.plots.curves import main_orders_of

    assert main_orders_of(np.ones((3, 0)), 2) != []
