"""A clearance from movers, and from zones at times, is decided to a millimetre, whatever moves and however doubtful."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from among_movers import BALL, among, flight, through, verdict
from movers import depth_at, movers, points
from skyverse.model.shapes import active_spans
from temporary_zones import depth_in_zone, zones


def deepest(depth_of, flown, span):
    """The greatest depth at any instant of a span, sought about the deepest of many."""
    instants, step = np.linspace(*span, 2001), (span[1] - span[0]) / 2000
    for _ in range(3):
        depths = depth_of(instants, flown.at(np.clip(instants, flown.start, flown.end)).position)
        best = np.argsort(depths)[-20:]
        instants = np.unique(np.clip(instants[best, None] + np.linspace(-step, step, 101), *span))
        step /= 50
    return float(depths.max())


ORIGIN = sky.WaypointMotion(points=[(0, 0, 0)], times=[0])
FLEEING = sky.WaypointMotion(points=[(2, 0, 0), (42, 0, 0)], times=[0, 20])
"""At 2 m/s, as fast as it can."""
DOUBTFUL = [
    sky.Mover(shape=BALL, motion=FLEEING, doubt=sky.Doubt(acceleration=4.0, since=2.0, top_speed=2.0)),
    sky.Mover(shape=BALL, motion=FLEEING, doubt=sky.Doubt(radius=0.1, acceleration=0.7, top_speed=2.0, since=3.0)),
    sky.Mover(shape=BALL, motion=FLEEING, doubt=sky.Doubt(growth=0.2, acceleration=0.5, since=-3.0, top_speed=2.5)),
    sky.Mover(shape=BALL, motion=ORIGIN, doubt=sky.Doubt(radius=0.3, growth=0.9, top_speed=1.0, since=1.0)),
]
HOVER, PASSING = ((-40, 3, 1), (-40, 3, 1)), ((-25, -60, 1), (-25, 60, 1))


@given(movers, st.tuples(points, points), st.floats(3, 12))
@settings(max_examples=20, deadline=None)
@example(DOUBTFUL[0], PASSING, 12.0)
@example(DOUBTFUL[1], PASSING, 12.0)
@example(DOUBTFUL[2], PASSING, 12.0)
@example(DOUBTFUL[3], PASSING, 12.0)
@example(DOUBTFUL[0], HOVER, 12.0)
def test_a_clearance_from_a_mover_that_is_just_kept_or_just_missed_is_decided(mover, ends, seconds):
    flown = flight(ends[0], tuple(np.add(ends[1], (0.5, 0, 0))), seconds, start=1.0)
    deep = deepest(lambda t, at: depth_at(mover, t, at, 0.0), flown, (0, flown.end + 1))
    assume(deep < -0.01)
    assert verdict(among(mover, flown=flown, clearance=-deep - 1e-3)).verdict is sky.Verdict.PROVEN
    told = verdict(among(mover, flown=flown, clearance=-deep + 1e-3))
    assert told.verdict is sky.Verdict.REFUTED
    assert depth_at(mover, np.array([told.time]), np.array([told.position]), -deep + 1e-3)[0] > 0


@given(zones(), st.tuples(points, points), st.floats(3, 12))
@settings(max_examples=20, deadline=None)
def test_a_clearance_from_a_zone_at_times_that_is_just_kept_or_just_missed_is_decided(zone, ends, seconds):
    flown = flight(ends[0], tuple(np.add(ends[1], (0.5, 0, 0))), seconds, start=1.0)
    spans = [np.clip(span, 0, flown.end + 1) for span in active_spans(zone.active) if span[1] >= 0]
    assume(all(begin < until for begin, until in spans))
    deep = max((deepest(lambda _, at: depth_in_zone(zone, at, 0.0), flown, span) for span in spans), default=0.0)
    assume(deep < -0.01)
    kept, missed = (through(zone, flown=flown, clearance=-deep + off) for off in (-1e-3, 1e-3))
    assert verdict(kept).verdict is sky.Verdict.PROVEN
    told = verdict(missed)
    assert told.verdict is sky.Verdict.REFUTED
    assert depth_in_zone(zone, np.array([told.position]), -deep + 1e-3)[0] > 0


@pytest.mark.parametrize("less", [-1e-8, -1e-15, 0.0, 1e-15, 1e-8])
@pytest.mark.parametrize("kind", ["mover", "zone"])
def test_a_clearance_missed_by_the_tolerance_itself_is_undecided_where_rounding_hides_it(kind, less):
    flown = flight((-3.0, 1.5 - 1e-6 - less, 0), (3, 1.5 - 1e-6 - less, 0), 4.0)
    box = sky.Box(min=(-1, -1, -1), max=(1, 1, 1))
    if kind == "mover":
        mission = among(sky.Mover(shape=box, motion=ORIGIN), flown=flown)
    else:
        mission = through(box.model_copy(update={"active": ((1.0, 3.0),)}), flown=flown)
    told = verdict(mission)
    decided = {-1e-8: sky.Verdict.PROVEN, 1e-8: sky.Verdict.REFUTED}
    assert told.verdict is decided.get(less, sky.Verdict.UNDECIDED)
    if less != -1e-8:
        assert abs(flown.at(told.time).position[0, 0]) <= 1.5
        assert told.position == pytest.approx(flown.at(told.time).position[0], abs=1e-9)


def test_cuts_among_movers_and_zones_are_counted():
    flown = flight((0, 0, 0), (10, 0, 0), 10, start=4)
    ball = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(5, -5, 0), (5, 6, 0)], times=[0, 11]))
    alone, near = verdict(among(flown=flown)), verdict(among(ball, flown=flown))
    both = verdict(among(ball, flown=flown, zones=(sky.Box(min=(4, -3, -1), max=(6, -1, 1), active=[[0, 9]]),)))
    assert {one.verdict for one in (alone, near, both)} == {sky.Verdict.PROVEN}
    assert alone.subdivisions < near.subdivisions <= both.subdivisions
