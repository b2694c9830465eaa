"""A model that release 0.2.0 wrote is read by this release and gives the same answers.

`model-0.2.0.json` is the model of a study of 9 runs and 2 held-out designs, written by `crankfem fit` (its
spaces left out), `model-0.2.0-answers.json` what release 0.2.0 answered. Neither is made anew: a release that
reads models of another kind still reads this one. Numbers agree to 1e-11, forces and moments of 1e5 N on
0.4 m to 1e-9 besides: sums may be taken in another order.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import crankfem as cf
from comparing import close

DATA = Path(__file__).parents[1] / "data"
INSIDE = {"web_width": 0.285, "web_thickness": 0.061}
MANY = {"web_width": [0.275, 0.3, 0.325], "web_thickness": [[0.05], [0.08]]}
OUTSIDE = {"web_width": 0.285, "web_thickness": 0.095}
LOOKED_UP = ("value", "lower", "upper", "unit", "support", "symbol", "inside", "error", "fe_error")
ENDS = ("left", "right", "band.left", "band.right")
FORCES = {"pinned": (0.0, -1e5, 0.0), "guided": (3e4, -1e5, 0.0)}
THROW = {
    "crank_radius": 0.170,
    "main_journal_diameter": 0.220,
    "pin_diameter": 0.180,
    "web_width": 0.285,
    "web_thickness": 0.061,
    "pin_length": 0.153,
    "main_journal_length": 0.135,
}


def looked_up(found):
    return {name: getattr(found, name) for name in LOOKED_UP}


def reacted(found):
    ends = (found.left, found.right, found.band.left, found.band.right)
    return {
        name: [*map(float, end.force), *map(float, end.moment)]
        for name, end in zip(ENDS, ends, strict=True)
    }


def answers(model):
    """What the lookup API answers, by the names and arguments that later releases keep."""
    helix = cf.Neighbors(120.0, 120.0)
    found = {name: looked_up(model.lookup(name, **INSIDE)) for name in model.responses}
    found |= {f"{name}, outside": looked_up(model.lookup(name, **OUTSIDE)) for name in found}
    for name in ("axial_compliance", "influence_coefficient"):
        found[f"{name}, 120 deg"] = looked_up(model.lookup(name, gamma_deg=120.0, **INSIDE))
    found["many"] = {
        name: getattr(model.lookups("axial_compliance", **MANY), name).tolist()
        for name in ("value", "lower", "upper", "inside")
    }
    found["values"] = {
        "axial": model.axial_compliance(**INSIDE),
        "torsional": model.torsional_compliance(**INSIDE),
        "influence": model.influence_coefficient(gamma_deg=90.0, **INSIDE),
        "mass": model.value("mass", **INSIDE),
    }
    slopes = model.slopes("axial_compliance", gamma_deg=120.0, **INSIDE)
    found["slopes"] = {name: [slope.value, slope.unit] for name, slope in slopes.items()}
    for support, force in FORCES.items():
        found[support] = reacted(model.reactions(force, support, **INSIDE))
    found["neighbors"] = reacted(model.reactions((2e4, -1e5, 0.0), helix, **INSIDE))
    throw = model.of_throw(cf.CrankThrow(**THROW), strict=True)
    found["throw"] = {name: looked_up(one) for name, one in throw.items()}
    return found


def leaves(content, path=""):
    """Numbers and words of nested content, by their path."""
    if isinstance(content, dict | list):
        parts = content.items() if isinstance(content, dict) else enumerate(content)
        for key, part in parts:
            yield from leaves(part, f"{path}/{key}")
    else:
        yield path, content


@pytest.fixture(scope="module")
def model():
    return cf.ComplianceModel.load(DATA / "model-0.2.0.json")


def test_a_stored_model_gives_the_answers_of_its_release(model):
    stored = dict(leaves(json.loads((DATA / "model-0.2.0-answers.json").read_text("utf-8"))))
    found = dict(leaves(json.loads(json.dumps(answers(model)))))
    assert found.keys() >= stored.keys()
    for path, value in stored.items():
        load = path.split("/")[1] in (*FORCES, "neighbors")
        number = isinstance(value, float) and np.isfinite(value)
        wanted = close(value, rel=1e-11, abs=1e-9 if load else 0.0) if number else value
        assert found[path] == wanted, path


def test_a_stored_model_is_written_again_as_it_was(model, tmp_path):
    model.save(tmp_path / "again.json")
    stored = json.loads((DATA / "model-0.2.0.json").read_text("utf-8"))
    again = json.loads((tmp_path / "again.json").read_text("utf-8"))
    # A later release may write more.
    assert again["responses"].keys() == stored["responses"].keys()
    for name, response in stored["responses"].items():
        assert again["responses"][name].items() >= response.items()
