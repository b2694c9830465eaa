"""Results of a run changed so that other conclusions follow, and what is concluded from them."""

from functools import cache

from crankbase.results import contents
from crankfem.analyses.findings import failed_checks, headline, verdict_line
from crankfem.report.summary import engine_facts, summary
from dynamics.strength.fatigue import PlaceStrength
from stand_ins import stored_results, typed

BEARINGS = {"flips": False, "sentences": [], "stiffness": [1e9, 2e9], "shaft": {}, "statuses": []}
BEARINGS |= {"modes": {"axial": 1, "torsional": 1}}
BEARINGS |= {"further": {"axial": [], "torsional": []}, "chains": {}, "used": {}, "assumed": True}
POWER = ("speed_rpm", "indicated_power", "mean_indicated_pressure", "rated_power")
LOAD = {
    "law": "constant",
    "given": True,
    "speeds": [],
    "sentence": "full load",
    "rated": {
        **dict.fromkeys((*POWER, "mechanical_efficiency", "mean_effective_pressure"), 1.0),
        "consistent": False,
        "sentence": "no power",
    },
}


def part(order, contribution, state, mode=1):
    made = {"order": order, "contribution": contribution, "state": state, "kind": "torsional"}
    known = dict.fromkeys(("amplitude", "mode_share", "magnifier", "detuning"), 1.0)
    return known | made | {"mode": mode}


def misfiring(passed=False, sentence="too much"):
    told = {"passed": passed, "sentence": sentence, "missing_share": 1.0, "compression": True}
    told["running_rpm"] = [200.0, 515.0]
    ranges = [f"{name}_rpm" for name in ("exceeded", "remaining", "otherwise", "advised")]
    return told | {key: [] for key in ("cases", "checks", "remarks", *ranges)}


def with_parts(results, *parts):
    """A worst check of so many parts: their sum is reached, 20 MPa are permitted."""
    worst = results["vibration"]["assessment"]["checks"][0]
    value = sum(one["contribution"] for one in parts)
    worst |= {
        "value": value,
        "permitted": 20e6,
        "used": value / 20e6,
        "passed": value <= 20e6,
        "cause": {"sentence": "they make it", "orders": list(parts)},
    }
    return results


def decision(results, sentence, status="undecided"):
    told = {"status": status, "sentence": sentence, "trials": []}
    results["vibration"]["assessment"]["decision"] |= told


def acceptable(results):
    results["vibration"]["assessment"] |= {"status": "fine", "headline": "Acceptable"}


def of_parts(*parts, damper=False):
    def change(results):
        with_parts(results, *(part(*one) for one in parts))
        if damper:
            given = {"field": "torsional_damper.kind", "assumed": False}
            results["inputs"].append(results["inputs"][0] | given)

    return change


def all_at_once(results):
    results["vibration"] |= {"misfiring": misfiring(sentence="cylinder 2 misfiring makes 30 MPa")}
    results["vibration"] |= {"load": LOAD}
    results["vibration"]["assessment"]["beside"] = ["The whole crankshaft differs."]
    decision(results, "it hangs")


def nothing_judged(results):
    results["vibration"] |= {"forced": None, "assessment": None}


def one_check_fails(results):
    next(one for one in results["checks"] if one["met"] is False)["met"] = True


def the_calculation_fails(results):
    results["checks"][0] |= {"met": False, "figure": 0.04, "allowed": 0.01}


def misfires(results):
    results["vibration"]["misfiring"] = misfiring()


def misfires_alone(results):
    misfires(results)
    acceptable(results)


def misfires_undecided(results):
    misfires(results)
    decision(results, "acceptable with a tensile strength of 672 MPa")


def weak(results):
    place = dict.fromkeys(contents(PlaceStrength), 1.0) | {"place": "pin fillet", "web": ""}
    throw = {"throw": 1, "alternating_torque": 1.0, "torque_speed_rpm": 1.0, "misfiring": []}
    throw |= {"places": [place | {"throw": 1}], "webs": {}, "shrink_fit": None}
    said = {"throws": [throw], "by_elements": False, "warning": "", "source": ""}
    results["strength"] = said | {key: [] for key in ("remarks", "left_out", "unsafe")}
    return throw["places"][0]


def weak_alone(results):
    weak(results)
    acceptable(results)


def bearings(results):
    told = ["First frequencies.", "Over that range the verdict changes."]
    results["vibration"]["assessment"]["beside"] = ["The whole crankshaft differs.", told[1]]
    results["vibration"]["bearings"] = BEARINGS | {
        "sentences": told,
        "stiffness": [2.2e8, 2.2e9, 2.2e10],
        "statuses": ["fine", "not acceptable"],
    }
    results["vibration"]["bearings"]["shaft"] = {"torsional": [50.0, 70.0]}


def above_running_speeds(results):
    for check, used in zip(results["vibration"]["assessment"]["checks"], (0.8, 0.9), strict=False):
        own = {name: check[name] for name in ("value", "permitted", "speed_rpm")}
        check["running"] = own | {"used": used}
        check["above"] = own | {"used": used + 0.3, "speed_rpm": 570.0}
        check["in_running_range"] = False
    first = results["vibration"]["assessment"]["deciding"]
    kept = {"value": 0.8 * first["permitted"], "used": 0.8}
    results["vibration"]["assessment"]["deciding"] = first | first["running"] | kept
    first["used"] = 1.1


def propeller_shaft_decides(results):
    """118 MPa where 95.7 may be passed below the running range; all else is kept."""
    assessment = results["vibration"]["assessment"]
    for check in assessment["checks"]:
        check |= {"value": 0.8 * check["permitted"], "used": 0.8, "passed": True}
    deciding = dict(assessment["checks"][0])
    deciding |= {"limit": "torsional stress of propeller shaft", "place": "propeller shaft"}
    deciding |= {"value": 118e6, "permitted": 95.7e6, "used": 118.0 / 95.7, "speed_rpm": 150.0}
    assessment |= {"deciding": deciding | {"passed": False, "passing": True}}
    assessment |= {"status": "not acceptable", "headline": "Not acceptable", "barred": []}


def whole_crankshaft_disagrees(results):
    assessment = results["vibration"]["assessment"]
    assessment |= {"status": "fine", "headline": "Acceptable from 200 to 515 1/min"}
    decision(results, "acceptable by one")
    checks = assessment["checks"][:1]
    assessment["whole"] = {"status": "not acceptable", "checks": checks, "barred": []}


def axial_free_end(*curve):
    """At running speeds, 200 to 515 1/min, alone."""

    def change(results):
        forced = results["vibration"]["forced"]["axial"]
        forced["speeds_rpm"] = [100.0, 200.0, 400.0, 515.0, 600.0]
        forced["free_end"]["synthesis"] = curve

    return change


def uneven_firing(results):
    results["engine"] |= {"firing_intervals_deg": [90.0, 150.0] * 3, "highest_speed_rpm": 12500.0}


def first_screen_of_the_whole(results):
    """The verdict's box shows four findings; like is told beside like, each with its speed."""
    vibration = results["vibration"]
    vibration["assessment"] |= {"by_whole": ["It differs."], "beside": ["It differs.", "A note."]}
    ends = {"lowest": 0.0, "lowest_angle_deg": 0.0, "highest": 1.0, "highest_angle_deg": 9.0}
    vibration["axial_force"] = {
        "speed_rpm": 500.0,
        "thrust_bearing": None,
        "held": ends,
        "throws": [],
        "sentences": [],
        "running": {"amplitude": 116683.6, "speed_rpm": 500.6},
        "running_whole": {"amplitude": 55509.2, "speed_rpm": 496.9},
    }
    peak = {"order": 6.0, "speed_rpm": 494.6, "value": 6170.0, "unit": "N m", "place": "a - b"}
    peak |= {"mode": 1, "frequency": 50.0, "share": 1.0, "damping_ratio": None}
    above = peak | {"value": 1e9, "in_running_range": False}
    peaks = [peak | {"in_running_range": True, "damping_ratio": 0.0125}, above]
    vibration["whole"]["criticals"] = {"torsional": {"left_out": 0, "peaks": peaks}}


CHANGES = {
    "as stored": lambda _: None,
    "all at once": all_at_once,
    "nothing judged": nothing_judged,
    # Without order 6 there are 15 of the 20 MPa permitted.
    "damping may help": of_parts((3.0, 15e6, "forced"), (6.0, 10e6, "at resonance")),
    "more damping": of_parts((3.0, 15e6, "forced"), (6.0, 10e6, "at resonance"), damper=True),
    "damping alone does not": of_parts((1.5, 22e6, "forced"), (6.0, 3e6, "near resonance", 2)),
    # The others counteract the peak of 35 MPa: without the resonance 25 MPa are left, not minus 25.
    "others counteract": of_parts((1.5, -25e6, "forced"), (6.0, 60e6, "at resonance")),
    "kept at resonance": of_parts((6.0, 10e6, "at resonance")),
    "modes with little part": of_parts(
        (1.0, 5e6, "forced"), (4.0, 30e6, "at resonance", 2), (6.0, 1e6, "near resonance", 3)
    ),
    "one check fails": one_check_fails,
    "the calculation fails": the_calculation_fails,
    "undecided": lambda results: decision(results, "acceptable with a strength of 590 MPa"),
    "misfires": misfires,
    "misfires alone": misfires_alone,
    "misfires, undecided": misfires_undecided,
    "too weak": weak,
    "too weak alone": weak_alone,
    "bearings": bearings,
    "above running speeds": above_running_speeds,
    "propeller shaft decides": propeller_shaft_decides,
    "whole crankshaft disagrees": whole_crankshaft_disagrees,
    "axial, largest within": axial_free_end(9e-3, 1e-4, 7.386e-3, 2e-4, 8e-3),
    "axial, largest at the end": axial_free_end(9e-3, 1e-4, 2e-4, 3e-4, 8e-3),
    "axial, unbounded": axial_free_end(9e-3, 1e-4, 2e-4, None, 8e-3),
    "uneven firing": uneven_firing,
    "first screen of the whole": first_screen_of_the_whole,
}


def changed_results(name):
    """Stored results with a change, as a file holds them."""
    results = stored_results()
    CHANGES[name](results)
    return results


def conclusions(results):
    """Findings in full, but for those about checks."""
    return [
        " ".join(each.long) for each in results.findings if each.long and each.section != "checks"
    ]


@cache
def concluded(name):
    """All sentences that a run and its report conclude first."""
    run = typed(changed_results(name))
    shown = summary(run)
    lines = [headline(run.vibration, run.strength), verdict_line(run.vibration, run.strength)]
    lines += [*conclusions(run), failed_checks(run.checks), "; ".join(engine_facts(run))]
    lines += [f"{shown['status']}: {shown['headline']}"]
    lines += [f"{finding.about}: {text}" for finding, text in shown["findings"]]
    for tile in (*shown["tiles"], *shown["frequencies"]):
        lines.append(", ".join(map(str, (tile.get("value"), *tile.get("details", ())))))
    return [line for line in lines if line]


def concluded_otherwise(name):
    """The sentences that are not those of the results as stored."""
    usual = concluded("as stored") if name != "as stored" else ()
    return [line for line in concluded(name) if line not in usual]
