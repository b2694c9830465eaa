"""Reactions from a few numbers of a throw, and from models of them.

Equilibrium is exact: 1e-12 of the loads. Beside finite elements with rigid sections, for which the law
between neighbors is exact, reactions agree to the rounding of their chains (1e-8).
"""

import itertools

import numpy as np
import pytest

from comparing import close
from crankbase.errors import InputError
from fem.analysis import analyze_throw
from fem.angle_law import angle_law
from fem.responses import end_moment_numbers
from fem.supports import Neighbors, reactions, support_throw
from plans import FILLETED
from refusals import refused
from regression.fits.fits import fit_form
from regression.models.compliance_model import ComplianceModel
from regression.models.response_model import ResponseModel
from regression.response_kinds import END_MOMENTS, NEEDED, ThrowLengths, end_reactions
from regression.throw_values import throw_values

THROW = FILLETED
LENGTHS = ThrowLengths(THROW.length, THROW.length / 2.0, THROW.crank_radius)
FORCES = np.array([[0.0, -1e5, 0.0], [4e4, 0.0, 0.0], [-3e4, -7e4, 0.0]])


def all_loads(found):
    ends = (found.left.force, found.left.moment, found.right.force, found.right.moment)
    return np.concatenate(ends, axis=-1)


def imbalance(loads, lengths, force):
    """Sums of forces and of moments about the left end, beside the size of the force and its moments."""
    force, loads = np.broadcast_arrays(force, loads[..., :3])[0], loads
    pin = np.stack(
        np.broadcast_arrays(0.0 * force[..., 0], lengths.crank_radius, lengths.to_pin), axis=-1
    )
    end = np.stack(np.broadcast_arrays(0.0 * force[..., 0], 0.0, lengths.whole), axis=-1)
    forces = loads[..., :3] + loads[..., 6:9] + force
    moments = (
        loads[..., 3:6] + loads[..., 9:] + np.cross(pin, force) + np.cross(end, loads[..., 6:9])
    )
    return max(np.max(np.abs(forces)), np.max(np.abs(moments))) / np.max(np.abs(loads))


@pytest.fixture(scope="module")
def rigid():
    return analyze_throw(THROW, accuracy=0.1).with_sections("rigid").superelement


@pytest.fixture(scope="module")
def numbers(rigid):
    law, found = angle_law(rigid), end_moment_numbers(rigid, THROW.length, alike=True)
    for support, ending in (("pinned", ""), ("guided", "_guided")):
        answer = support_throw(rigid, support)
        found[f"axial_reaction{ending}"] = answer.influence / answer.axial
    return found | {
        "axial_compliance_in_line": law.in_line,
        "axial_compliance_opposite": law.opposite,
        "influence_coefficient_in_line": law.influence_in_line,
        "influence_coefficient_opposite": law.influence_opposite,
        "tilt_stiffness_ratio": law.ratio,
    }


@pytest.mark.parametrize("angle", [None, "guided", 0.0, 35.0, 90.0, -120.0, 180.0, 240.0, 360.0])
def test_reactions_are_those_of_finite_elements(rigid, numbers, angle):
    kind = angle if angle == "guided" else "pinned" if angle is None else "neighbors"
    support = Neighbors(angle, angle) if kind == "neighbors" else kind
    own = {name: numbers[name] for name in NEEDED[kind]}
    found = end_reactions(own, LENGTHS, FORCES, angle if kind == "neighbors" else None)
    for loads, force in zip(found, FORCES, strict=True):
        wanted = all_loads(reactions(rigid, support, rigid.end_load(force)))
        # The mesh's pin is round to second order only, by which its radius differs.
        wanted[5] = THROW.crank_radius * force[0]
        assert loads == close(wanted, abs=1e-8 * 1e5)


# ----------------------------------------------------------------------------------- from a model

BOX = {"web_width": (0.270, 0.330), "web_thickness": (0.050, 0.090)}
GRID = np.array(list(itertools.product(*(np.linspace(*ends, 3) for ends in BOX.values()))))
SIZES = {
    "axial_reaction": 0.46,
    "axial_reaction_guided": 0.26,
    "axial_compliance_in_line": 0.26e-9,
    "axial_compliance_opposite": 1.3e-9,
    "influence_coefficient_in_line": 0.07e-9,
    "influence_coefficient_opposite": 0.6e-9,
    "tilt_stiffness_ratio": 2.7,
    "cross_tilt_stiffness_ratio": 1.9,
    **dict.fromkeys((name for name in END_MOMENTS if name.startswith(("rad", "tan"))), 0.13),
    **dict.fromkeys((name for name in END_MOMENTS if name.startswith("axial_end")), 0.24),
}
MIDDLE = {"web_width": 0.3, "web_thickness": 0.068}


def made_model(throw=THROW, names=SIZES, error=0.02):
    def response(name):
        values = SIZES[name] * (GRID[:, 0] / 0.3) ** -0.2 * (GRID[:, 1] / 0.068) ** 0.3
        fit = fit_form("log-quadratic", tuple(BOX), GRID, values)
        unit = "m/N" if "compliance" in name or "influence" in name else ""
        made = ResponseModel.from_fit(fit, symbol=name, unit=unit, fe_error=0.0)
        return ResponseModel(**(made.model_dump() | {"band_error": error, "band_designs": 40}))

    described = throw_values(throw, spelled_out=True)
    fixed = {
        name: value
        for name, value in described.items()
        if name not in BOX and isinstance(value, float)
    }
    return ComplianceModel(
        responses={name: response(name) for name in names},
        fixed=fixed,
        ranges=BOX,
        labels={name: value for name, value in described.items() if isinstance(value, str)},
        throw=throw.model_dump(mode="json"),
    )


@pytest.fixture(scope="module")
def model():
    return made_model()


def test_a_pinned_throw(model):
    found = model.reactions(pin_force=(2e4, -1e5, 0.0), **MIDDLE)
    push = 1e5 * model.value("axial_reaction", **MIDDLE)
    torque = THROW.crank_radius * 2e4
    assert found.left.force == close([-1e4, 5e4, push])
    assert found.left.moment == close([0.0, 0.0, torque])
    assert found.right.force == close([-1e4, 5e4, -push])
    assert found.right.moment == close([0.0, 0.0, 0.0])
    # Only the axial reaction rests on an equation; its band is 1 / (1 - 2 %).
    assert found.band.left.force == close([0.0, 0.0, push * (1.0 / 0.98 - 1.0)], abs=1e-9)
    assert not found.band.left.moment.any()
    assert (found.support, found.inside, found.remarks) == ("pinned", True, ())
    assert found.to_pandas().loc["left", "Fz"] == push


@pytest.mark.parametrize("support", ["pinned", "guided", Neighbors(120.0, 120.0)])
def test_arrays_are_those_of_each_throw(model, support):
    widths, thickness = np.linspace(0.26, 0.32, 4)[:, None], np.array([0.055, 0.07, 0.085])
    found = model.reactions(FORCES, support, web_width=widths, web_thickness=thickness)
    assert all_loads(found).shape == (4, 3, 12)
    assert found.inside.tolist() == [[False] * 3] + [[True] * 3] * 3
    for row, column in np.ndindex(4, 3):
        one = model.reactions(
            FORCES[column],
            support,
            web_width=float(widths[row, 0]),
            web_thickness=float(thickness[column]),
        )
        assert all_loads(found)[row, column] == close(all_loads(one), abs=1e-9)
        assert all_loads(found.band)[row, column] == close(all_loads(one.band), abs=1e-9)
        assert np.isinf(all_loads(one.band)).all() == (row == 0)
    assert len(found.remarks) == 1
    assert found.to_pandas()["right Mx"].tolist() == found.right.moment[..., 0].ravel().tolist()


def test_ends_alike_have_one_equation_for_both(model):
    """By symmetry each end takes half of a radial force, whatever the equations' errors."""
    found = model.reactions((0.0, -1e5, 0.0), "guided", **MIDDLE)
    assert found.left.force[1] == close(5e4)
    assert found.band.left.force[1] < 1e-6
    assert found.band.left.moment[0] > 10.0


def test_the_band_of_neighbors_is_open_where_one_of_its_numbers_is():
    found = made_model(error=1.0).reactions((0.0, -1e5, 0.0), Neighbors(120.0, 120.0), **MIDDLE)
    assert found.inside
    assert np.isinf(all_loads(found.band)).all()


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"pin_force": (0.0, -1e5, 3e3)}, "pin_force: given 3000 N along the shaft; allowed are f"),
        ({"pin_force": (0.0, -1e5)}, r"pin_force: given an array of shape \(2,\); allowed are x, y"),
        ({"pin_force": (0.0, np.nan, 0.0)}, r"pin_force\[1\]: given nan; allowed are finite"),
        ({"pin_force": (0.0, 1e40, 0.0)}, r"pin_force\[1\]: given 1e\+40; allowed are numbers of up"),
        ({"support": "free"}, 'support: given \'free\'; allowed are "pinned", "guided" or'),
        ({"support": Neighbors(120, 240)}, r"support: given Neighbors\(120, 240\); allowed are equal"),
        ({"pin_force": np.zeros((5, 3)), "web_width": np.full(4, 0.3)}, r"shape \(5, 3\) for dimens"),
        ({"web_width": 0.345, "strict": True}, "web_width: given 345 mm; allowed is the range of"),
        ({"hue": 1.0}, "hue: unknown dimension"),
    ],
)  # fmt: skip
def test_refusals(model, changes, match):
    with pytest.raises(InputError, match=match):
        model.reactions(**({"pin_force": (0.0, -1e5, 0.0)} | MIDDLE | changes))


def test_unequal_webs_have_no_law_between_neighbors():
    uneven = THROW.changed(right_web={"thickness": 0.080})
    model = made_model(uneven)
    found = model.reactions((1e4, -1e5, 0.0), "guided", **MIDDLE)
    pin = uneven.main_journal_length / 2.0 + 0.068 + uneven.pin_length / 2.0
    lengths = ThrowLengths(uneven.length, pin, uneven.crank_radius)
    assert imbalance(all_loads(found), lengths, np.array([1e4, -1e5, 0.0])) < 1e-12
    with refused("support"):
        model.reactions((1e4, -1e5, 0.0), Neighbors(90.0, 90.0), **MIDDLE)


def test_parts_beside_the_crank_plane_are_refused():
    hole = {"part": "pin", "diameter": 0.02, "angle": 0.7}
    model = made_model(THROW.changed(oil_holes=(hole,)))
    with refused("reactions"):
        model.reactions((0.0, -1e5, 0.0), **MIDDLE)
