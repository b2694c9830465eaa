"""Results describe themselves: JSON both ways, units, tables and texts from one declaration."""

import json
import math
from collections.abc import Mapping
from typing import Annotated

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crankbase.array_checks import Array
from crankbase.errors import InputError, SolveError
from crankbase.results import Internal, Quantity, Result, Speed, contents, result
from json_units import numbers_with_units


@result("speed", "load", "compliances")
class Peak(Result):
    """A point of a curve."""

    speed: Speed
    load: Annotated[float, Quantity("N", "load P")]
    compliances: Annotated[Array, Quantity("m/N")]
    limit: Annotated[float, Quantity(".unit")] | None
    unit: str
    cylinder: int
    solver: Internal[object] = None
    reason: Annotated[str | None, Quantity(left_out=True)] = None

    @property
    def work(self) -> Annotated[float, Quantity("J", key="work done")]:
        """Of the load over 2 m."""
        return 2.0 * self.load


@result("peaks")
class Sweep(Result):
    """Several points."""

    peaks: tuple[Peak, ...]
    by_name: Mapping[str, Peak]
    losses: Annotated[Mapping[str, float], Quantity("W")]


def peak(load=3.0, speed=10.0, **changes):
    """Make a point."""
    values = {"compliances": np.array([1.0, math.inf]), "limit": 5.0, "unit": "Pa", "cylinder": 2}
    return Peak(speed=speed, load=load, **(values | changes))


def test_json_has_the_content_with_the_unit_of_each_number():
    """Speeds in 1/min, unbounded values null, None left out where declared so."""
    content = json.loads(Sweep((peak(),), {"a": peak()}, {"damper": 4.0}).to_json())
    [point] = content["peaks"]
    assert point["compliances"] == [1.0, None]
    assert point["work done"] == 6.0
    assert "reason" not in point
    assert "solver" not in point
    units = {path[-1]: unit for path, _, unit in numbers_with_units(content)}
    assert units["speed_rpm"] == "1/min"
    assert units["limit"] == "Pa"
    assert units["damper"] == "W"
    assert math.isclose(point["speed_rpm"], 10.0 * 30.0 / math.pi)


@pytest.mark.further
@given(st.floats(-1e9, 1e9), st.floats(1e-3, 1e4), st.text(max_size=8))
def test_json_is_read_back(load, speed, reason):
    """Reading what was written gives the same document, at least to rounding."""
    sweep = Sweep((peak(load, speed, reason=reason),), {"a": peak(limit=None)}, {})
    again = Sweep.from_json(sweep.to_json())
    assert math.isclose(again.peaks[0].speed, speed, rel_tol=1e-15)
    assert (again.peaks[0].load, again.peaks[0].reason) == (load, reason)
    assert again.by_name["a"].limit is None
    np.testing.assert_array_equal(again.peaks[0].compliances, sweep.peaks[0].compliances)


def test_a_nan_is_refused_by_its_name():
    """No NaN leaves the program."""
    with pytest.raises(SolveError, match=r"peaks\.1\.load"):
        Sweep((peak(load=math.nan),), {}, {}).to_json()


def test_content_without_a_value_is_refused_by_its_key():
    """What is missing is neither unbounded nor None."""
    content = peak().to_record()
    known = Peak.from_record(content)
    assert Peak.from_record(known) is known
    with pytest.raises(InputError, match="cylinder"):
        Peak.from_record(content | {"cylinder": "second"})
    del content["load"]
    with pytest.raises(InputError, match="load"):
        Peak.from_record(content)


def test_texts_and_tables_take_the_declared_units():
    """Single values are columns; an undeclared field is refused."""
    assert repr(peak()) == "Peak(speed 10 rad/s, load 3 N, compliances (1, inf) m/N)"
    assert peak().row()["limit"] == (5.0, "Pa")
    assert peak().to_pandas().attrs["units"]["work"] == "J"

    @result()
    class Bare(Result):
        size: float

    with pytest.raises(TypeError, match="size"):
        contents(Bare)
