import pytest
from hypothesis import given
from hypothesis import strategies as st

import crankbase.stopwatch
from crankbase.stopwatch import Stopwatch


class Clock:
    """A clock that goes when it is told to, in whole seconds, so that sums are exact."""

    def __init__(self):
        self.now = 0.0

    def perf_counter(self):
        return self.now

    def work(self, seconds):
        self.now += seconds


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(crankbase.stopwatch, "time", made)
    return made


def test_laps_of_one_name_add_up_in_the_order_first_met(clock):
    watch = Stopwatch()
    for name, seconds in (("mesh", 2), ("solve", 3), ("mesh", 4)):
        with watch.lap(name):
            clock.work(seconds)
    clock.work(10)
    assert watch.seconds == {"mesh": 6.0, "solve": 3.0}
    assert list(watch.seconds) == ["mesh", "solve"]


def test_a_lap_leaves_out_what_is_named_inside(clock):
    watch = Stopwatch()
    with watch.lap("outer"):
        clock.work(1)
        with watch.lap("inner"):
            clock.work(2)
            with watch.lap("innermost"):
                clock.work(4)
        clock.work(8)
        watch.add({"elsewhere": 3.0})
    assert watch.seconds == {"outer": 6.0, "inner": 2.0, "innermost": 4.0, "elsewhere": 3.0}
    assert next(iter(watch.seconds)) == "outer"


def test_a_lap_that_fails_is_timed(clock):
    watch = Stopwatch()

    def fail():
        with watch.lap("outer"):
            clock.work(1)
            with watch.lap("inner"):
                clock.work(2)
                raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert watch.seconds == {"outer": 1.0, "inner": 2.0}
    with watch.lap("outer"):
        clock.work(4)
    assert watch.seconds == {"outer": 5.0, "inner": 2.0}


def test_times_taken_elsewhere(clock):
    watch = Stopwatch()
    watch.add({"mesh": 1.5})
    watch.add({"mesh": 1.0, "geometry": 0.5})
    with watch.lap("mesh"):
        clock.work(2)
    assert watch.seconds == {"mesh": 4.5, "geometry": 0.5}


def test_two_watches_are_apart(clock):
    one, other = Stopwatch(), Stopwatch()
    with one.lap("mesh"), other.lap("mesh"):
        clock.work(1)
    assert one.seconds == other.seconds == {"mesh": 1.0}
    assert one.seconds is not other.seconds


# A piece of work: its name, its own seconds before and after, and pieces inside it.
pieces = st.recursive(
    st.tuples(st.sampled_from("abc"), st.integers(0, 9), st.integers(0, 9), st.just([])),
    lambda inner: st.tuples(
        st.sampled_from("abc"), st.integers(0, 9), st.integers(0, 9), st.lists(inner, max_size=3)
    ),
    max_leaves=12,
)


@given(st.lists(pieces, max_size=4))
def test_every_second_counts_once(work):
    """However laps are nested, also inside others of their name, each gets its own seconds."""
    with pytest.MonkeyPatch.context() as patch:
        clock = Clock()
        patch.setattr(crankbase.stopwatch, "time", clock)
        watch = Stopwatch()
        own = {}

        def do(piece):
            name, before, after, inside = piece
            own[name] = own.get(name, 0) + before + after
            with watch.lap(name):
                clock.work(before)
                for one in inside:
                    do(one)
                clock.work(after)

        for piece in work:
            do(piece)
        assert watch.seconds == own
        assert sum(watch.seconds.values()) == clock.now
