"""UAVs keep clear of movers, and of zones while they are active: against dense samples, and planted faults."""

import math
import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from among_movers import AGILE, BALL, MADE_BY, among, flight, through, verdict
from movers import depth_at, movers, points
from skyverse.model.timed_shapes import with_zones_active
from skyverse.referee.curve import curve_of
from skyverse.referee.speed_zones import judge_zone_speed
from temporary_zones import depth_in_zone, depth_while_active, zones

AIRSHOW = {"name": "airshow", "min": (4, -1, -1), "max": (6, 1, 1)}
HERE = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0, geoid=47.0)


@given(
    st.lists(movers, max_size=3),
    st.lists(zones(), max_size=3),
    st.tuples(points, points),
    st.floats(3, 15),
    st.none() | st.floats(0.05, 0.6),
)
@settings(max_examples=150, deadline=None)
def test_what_is_proven_holds_at_many_samples_and_what_is_refuted_is_seen_there(moving, closed, ends, seconds, error):
    flown = flight(ends[0], tuple(np.add(ends[1], (0.5, 0, 0))), seconds, start=1.0)
    more = {} if error is None else {"tracking_error": sky.TrackingError(horizontal=error, vertical=error / 2)}
    mission = among(*moving, zones=closed, flown=flown, **more)
    edges = [t for zone in closed for span in zone.active for t in span if t is not None]
    instants = np.unique(np.clip([*np.linspace(0, flown.end + 1, 10_001), *edges], 0, flown.end + 1))
    places = flown.at(np.clip(instants, flown.start, flown.end)).position
    aside, up = (0.0, 0.0) if error is None else (error, error / 2)
    strayed = [(0, 0, 0), (aside, 0, up), (-aside, 0, -up), (0, aside, up), (0, -aside, 0), (0, 0, up), (0, 0, -up)]
    deep = {sky.Fault.MOVER: [-np.inf], sky.Fault.ACTIVE_ZONE: [-np.inf]}
    for by in strayed:
        deep[sky.Fault.MOVER] += [depth_at(mover, instants, places + by, 0.5).max() for mover in moving]
        deep[sky.Fault.ACTIVE_ZONE] += [depth_while_active(zone, instants, places + by, 0.5).max() for zone in closed]
    found = {one.fault for one in sky.check(mission.scenario, mission)}
    for fault, depths in deep.items():
        assert max(depths) <= 2e-6 or fault in found
    if max(map(max, deep.values())) < -0.05 and error is None:
        assert verdict(mission).verdict is sky.Verdict.PROVEN
        assert bool(closed) == ("every zone while it is active" in verdict(mission).sentence)


def test_a_mover_that_crosses_the_way_is_found_at_the_worst_instant():
    crossing = sky.Mover(
        name="lorry", shape=BALL, motion=sky.WaypointMotion(points=[(5, -5, 0), (5, 5, 0)], times=[0, 10])
    )
    mission = among(crossing, flown=flight((0, 0, 0), (10, 0, 0), 10))
    (found,) = [one for one in sky.check(mission.scenario, mission) if one.fault is sky.Fault.MOVER]
    assert found.time == pytest.approx(5, abs=1e-3)
    assert found.uavs == (0,)
    assert "1 m inside mover 'lorry' at t = 5 s" in found.message
    assert "0.5 m are required" in found.message
    late = among(crossing, flown=flight((0, 0, 0), (10, 0, 0), 10, start=7))
    assert verdict(late).verdict is sky.Verdict.PROVEN
    assert "clear of every mover, wherever within its doubt that may be, by 0.5 m" in verdict(late).sentence


@pytest.mark.parametrize("start", [0.0, 30.0])
def test_a_uav_is_judged_while_it_waits_for_its_departure_and_after_its_arrival(start):
    place = (0, 0, 0) if start else (10, 0, 0)
    back_and_forth = sky.WaypointMotion(points=[(place[0], -40, 0), (place[0], 40, 0)], times=[0, 20], then="stays")
    flown = flight((0, 0, 0), (10, 0, 0), 10, start=start)
    told = verdict(among(sky.Mover(shape=BALL, motion=back_and_forth), flown=flown))
    assert told.verdict is sky.Verdict.REFUTED
    assert told.time == pytest.approx(10, abs=0.01 if start else 0.3)
    told = verdict(
        through(sky.Box(min=np.array(place) - 1.0, max=np.array(place) + 1.0, active=[[10.5, 11]]), flown=flown)
    )
    assert told.verdict is sky.Verdict.REFUTED
    assert 10.5 - 1e-9 <= told.time <= 11 + 1e-9


def test_doubt_that_grows_makes_a_flight_unsafe_that_was_safe():
    aside = sky.WaypointMotion(points=[(5, 3, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    assert verdict(among(sky.Mover(shape=BALL, motion=aside), flown=flown)).verdict is sky.Verdict.PROVEN
    doubt = sky.Doubt(growth=0.31)
    told = verdict(among(sky.Mover(shape=BALL, motion=aside, doubt=doubt), flown=flown))
    assert told.verdict is sky.Verdict.REFUTED
    assert "where mover 'mover-1' may be" in told.sentence
    later = sky.Doubt(growth=0.31, since=5.0)
    assert verdict(among(sky.Mover(shape=BALL, motion=aside, doubt=later), flown=flown)).verdict is sky.Verdict.PROVEN


def test_doubt_that_accelerates_reaches_a_flight_when_its_formula_says_so():
    aside = sky.WaypointMotion(points=[(5, 4, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    fast = {"since": 1.0, "top_speed": 5.0}
    near = sky.Doubt(acceleration=0.09, **fast)  # 4.5 m at 11 s, where 4.9 m are left
    assert verdict(among(sky.Mover(shape=BALL, motion=aside, doubt=near), flown=flown)).verdict is sky.Verdict.PROVEN
    gaps = {}
    for acceleration in (0.6, 5.0):
        doubt = sky.Doubt(acceleration=acceleration, **fast)
        told = verdict(among(sky.Mover(shape=BALL, motion=aside, doubt=doubt), flown=flown))
        assert told.verdict is sky.Verdict.REFUTED
        place, after = np.array(told.position), told.time - 1.0
        quick = min(after, 10.0 / acceleration)  # up to twice the top speed
        spread = acceleration * (after * quick - 0.5 * quick * quick)
        reached = min(spread, 5.0 * after)
        gaps[acceleration] = np.linalg.norm(place - (5, 4, 0)) - BALL.radius - reached
        words = re.search(r"comes within (\S+) m|is (\S+) m inside", told.sentence)
        said = float(words[1]) if words[1] else -float(words[2])
        assert said == pytest.approx(gaps[acceleration], abs=1e-4)


def test_a_doubt_grows_by_its_formula():
    doubt = sky.Doubt(radius=0.1, growth=0.2, acceleration=2.0, since=1.0, top_speed=3.0)
    assert doubt.at([0.0, 1.0, 2.0, 5.0]) == pytest.approx([0.1, 0.1, 1.3, 0.1 + 0.8 + 2 * 4.5 + 6])
    assert doubt.grows
    assert not sky.Doubt(radius=1.0).grows


def test_a_top_speed_bounds_what_a_mover_may_do_after_its_last_observation():
    near = sky.WaypointMotion(points=[(-50, 0, 0), (-7, 0, 0)], times=[0, 9])  # up to 7 m from the UAV's place
    flown = flight((0, 0, 0), (0, 0, 1), 9)
    doubt = sky.Doubt(radius=0.1, growth=2.0)  # so it may be 18 m farther by then
    assert verdict(among(sky.Mover(shape=BALL, motion=near, doubt=doubt), flown=flown)).verdict is sky.Verdict.REFUTED
    slow = sky.Doubt(radius=0.1, growth=2.0, top_speed=4.8)  # seen 50 m away at 0 s, it cannot be here within 10 s
    assert verdict(among(sky.Mover(shape=BALL, motion=near, doubt=slow), flown=flown)).verdict is sky.Verdict.PROVEN


def test_the_tracking_error_counts():
    aside = sky.WaypointMotion(points=[(5, 2.0, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    assert verdict(among(sky.Mover(shape=BALL, motion=aside), flown=flown)).verdict is sky.Verdict.PROVEN
    error = sky.TrackingError(horizontal=0.6, vertical=0.1)
    told = verdict(among(sky.Mover(shape=BALL, motion=aside), flown=flown, tracking_error=error))
    assert told.verdict is sky.Verdict.REFUTED
    assert "with its tracking error" in told.sentence


def test_a_uav_that_stands_at_its_start_is_judged_too():
    mission = among(
        sky.Mover(shape=BALL, motion=sky.CircularMotion(centre=(0, 0, 0), radius=3, period=4)),
        flown=flight((0, 0, 0), (9, 0, 0), 5),
    )
    scenario = mission.scenario.model_copy(update={"uavs": (*mission.scenario.uavs, sky.UAV(start=(3, 0, 0), **AGILE))})
    mission = sky.Mission(scenario, (0, None), (None, None), (mission.trajectories[0], None), (), MADE_BY)
    assert (sky.Fault.MOVER, (1,)) in {(found.fault, found.uavs) for found in sky.check(scenario, mission)}


def test_a_motion_with_too_many_turns_is_undecided_and_not_judged_for_hours():
    restless = sky.WaypointMotion(points=[(0, 0, 50), (1, 0, 50)], times=[0, 0.01], then="returns")
    told = verdict(among(sky.Mover(shape=BALL, motion=restless), flown=flight((0, 0, 0), (10, 0, 0), 1e4)))
    assert told.verdict is sky.Verdict.UNDECIDED
    assert "too many turns" in told.sentence


def test_a_circle_begins_at_its_bearing_and_turns_the_way_it_says():
    left = sky.CircularMotion(centre=(1, 2, 3), radius=5, period=8, bearing=90)
    assert left.at([0, 2, 4]) == pytest.approx(np.array([[6, 2, 3], [1, 7, 3], [-4, 2, 3]]))
    right = sky.CircularMotion(centre=(1, 2, 3), radius=5, period=8, bearing=90, clockwise=True)
    assert right.at([2]) == pytest.approx(np.array([[1, -3, 3]]))
    assert math.hypot(*(left.at(1.0)[0] - (1, 2, 3))) == pytest.approx(5)


def test_missions_among_movers_are_exported_as_data_once_the_referee_has_judged_them(tmp_path):
    stands = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(5, 30, 0)], times=[0]))
    stands_in_the_way = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(5, 0, 0)], times=[0]))
    ordinary = {"max_speed": 5, "max_acceleration": 3.5, "max_jerk": 50, "max_tilt": 40, "thrust_to_weight": 2.5}
    standing = flight((0, 0, 0), (9, 0, 0), 5)
    mission = sky.plan_mission(among(stands, flown=standing, **ordinary).scenario, sky.Taut())
    for suffix in ("csv", "trajectory.yaml", "path.json", "geojson", "gpx", "geo.csv", "kml"):  # which hold its times
        assert sky.export(mission, tmp_path / f"out.{suffix}", sky.ExportOptions(origin=HERE))
    assert (tmp_path / "out.csv").read_text().count("\n") > 20
    with pytest.raises(sky.InputError, match="the referee refutes this mission"):
        sky.export(
            mission,
            tmp_path / "hit.csv",
            scenario=among(stands_in_the_way, flown=standing, **ordinary).scenario,
        )
    assert not (tmp_path / "hit.csv").exists()


def test_missions_among_movers_are_neither_exported_to_autopilots_nor_flown_nor_studied(tmp_path, refuses):
    ordinary = {"max_speed": 5, "max_acceleration": 3.5, "max_jerk": 50, "max_tilt": 40, "thrust_to_weight": 2.5}
    stands = sky.Mover(shape=BALL, motion=sky.WaypointMotion(points=[(5, 30, 0)], times=[0]))
    mission = among(stands, flown=flight((0, 0, 0), (9, 0, 0), 5), **ordinary)
    with refuses():
        sky.export(mission, tmp_path / "out.plan", sky.ExportOptions(origin=HERE))
    assert not list(tmp_path.iterdir())
    for fly in (sky.fly, partial(sky.fly, runs=2), sky.fly_until_safe):
        with refuses():
            fly(mission)
    with refuses():
        sky.routes(mission, origin=HERE)
    sky.write(mission.scenario, tmp_path / "moving.yaml")
    with refuses():
        planners = {"planners": ["taut"], "budget": [{"paths": 10}], "seeds": [1]}
        list(sky.Study(scenarios=[str(tmp_path / "moving.yaml")], **planners).jobs())


def test_movers_are_read_from_yaml_and_named(tmp_path):
    file = tmp_path / "moving.yaml"
    sky.write(among(flown=flight((0, 0, 0), (9, 0, 0), 5)).scenario, file)
    file.write_text(
        file.read_text().replace("movers: []\n", "")
        + """
movers:
  - shape: {shape: sphere, centre: [0, 0, 0], radius: 1}
    motion: {points: [[5, -5, 0], [5, 5, 0]], times: [0, 10], then: returns}
    doubt: {radius: 0.2, growth: 0.1, top_speed: 3}
  - name: fan
    shape: {min: [-1, -1, 0], max: [1, 1, 2]}
    motion: {motion: circle, centre: [0, 0, 40], radius: 4, period: 6}
"""
    )
    scenario = sky.read(file)
    assert [mover.name for mover in scenario.movers] == ["mover-1", "fan"]
    assert "2 movers" in repr(scenario)
    assert sky.read(file).digest == scenario.digest


def zone_faults(mission):
    """What is wrong besides that the mission has a flight without a path."""
    wrong = sky.check(mission.scenario, mission)
    return [one for one in wrong if one.fault in (sky.Fault.ACTIVE_ZONE, sky.Fault.ZONE_SPEED, sky.Fault.UNDECIDED)]


@pytest.mark.parametrize(
    ("active", "fault"),
    [
        ([[None, None]], sky.Fault.ACTIVE_ZONE),
        ([[None, 4.0]], None),
        ([[None, 4.4]], sky.Fault.ACTIVE_ZONE),
        ([[6.0, None]], None),
        ([[5.6, None]], sky.Fault.ACTIVE_ZONE),
        ([[0, 4.0], [6.0, 9]], None),
        ([[0, 4.0], [5, 5.0001], [6.0, 9]], sky.Fault.ACTIVE_ZONE),
        ([[-9, -2], [30, 40]], None),
    ],
)
def test_a_zone_counts_from_when_it_opens_until_it_closes(active, fault):
    # at rest at x = 0 at 0 s, at x = 3.5 at 4.2 s, and at x = 6.5 at 5.8 s; the zone grown is from 3.5 to 6.5
    mission = through(sky.Box(**AIRSHOW, active=active), flown=flight((0, 0, 0), (10, 0, 0), 10))
    instants = np.linspace(0, 11, 200_001)
    depth = depth_while_active(mission.scenario.zones[0], instants, mission.trajectories[0].at(instants).position, 0.5)
    assert (depth.max() > 0) == (fault is not None)
    found = zone_faults(mission)
    assert [one.fault for one in found] == ([] if fault is None else [fault])
    for one in found:
        assert "zone 0 ('airshow', active" in one.message
        assert "0.5 m are required" in one.message
        around = one.time + np.array([-1e-9, 0.0, 1e-9])  # the instants of opening and closing are rounded
        place = np.repeat([one.position], 3, axis=0)
        assert depth_while_active(mission.scenario.zones[0], around, place, 0.5).max() > 0


def test_the_worst_instant_is_found():
    mission = through(sky.Box(**AIRSHOW, active=[[4.5, 60]]), flown=flight((0, 0, 0), (10, 0, 0), 10))
    (found,) = zone_faults(mission)
    assert found.time == pytest.approx(5, abs=1e-3)
    assert "is 1 m inside zone 0 ('airshow', active from 4.5 s to 60 s) at t = 5 s" in found.message


@given(zones(max_speed=2.0), points, points, st.floats(0.5, 8))
@settings(max_examples=60, deadline=None)
def test_a_speed_limit_holds_only_while_its_zone_is_active(zone, a, b, seconds):
    flown = flight(a, tuple(np.add(b, (0.5, 0, 0))), seconds)
    found = next(iter(judge_zone_speed(through(zone, flown=flown).scenario, 0, curve_of(flown)).violations), None)
    instants = np.linspace(0, flown.end, 5_001)
    motion = flown.at(instants)
    depth = depth_while_active(zone, instants, motion.position, 0.0)
    excess = np.linalg.norm(motion.velocity, axis=1) / 2.0 - 1.0
    worst = np.minimum(depth, excess).max()
    if worst > 1e-5:
        assert found.fault is sky.Fault.ZONE_SPEED
        assert "m/s in zone 0 (active " in found.message
    elif worst < -1e-2:
        assert found is None


@given(zones(), points, points)
@settings(max_examples=40, deadline=None)
def test_a_flight_that_is_clear_of_obstacles_is_clear_of_the_same_zones_at_times(zone, a, b):
    flown = flight(a, tuple(np.add(b, (0.5, 0, 0))), 6.0)
    mission = through(zone, flown=flown)
    always = with_zones_active(mission.scenario, {0})
    assert always.obstacles[0].active is None
    places = flown.at(np.linspace(0, 6, 2001)).position
    if depth_in_zone(zone, places, 0.5).max() < -0.05:
        assert sky.certify(always, mission).trajectories[0].verdict is sky.Verdict.PROVEN
        assert verdict(mission).verdict is sky.Verdict.PROVEN


STANDS = sky.WaypointMotion(points=[(5, 3, 0)], times=[0])
MOVER = "movers: [{shape: {shape: sphere, centre: [0, 0, 0], radius: 1}, motion: {points: [[5, 0, 0], [5, 5, 0]], %s}}]"


BAD_MOVERS = ("times: [10, 0]", "times: [0]", "times: [0, 10], then: repeats")
BAD_TIMES = ("[[5, 2]]", "[[1, 5], [4, 9]]", "[[1, null], [4, 9]]", "[]", "[[.nan, 2]]", "[[0, 5]], risk: 2", "null")
ZONE = "zones: [{min: [0, 0, 0], max: [1, 1, 1], active: %s}]"


@pytest.mark.parametrize("wrong", [*(MOVER % one for one in BAD_MOVERS), *(ZONE % one for one in BAD_TIMES)])
def test_bad_movers_and_times_are_refused(tmp_path, wrong, refuses):
    file = tmp_path / "moving.yaml"
    sky.write(among(flown=flight((0, 0, 0), (9, 0, 0), 5)).scenario, file)
    file.write_text(re.sub("(movers|zones): \\[\\]\n", "", file.read_text()) + wrong + "\n")
    with refuses():
        sky.read(file)


@pytest.mark.parametrize(
    "made",
    [
        lambda: sky.Doubt(acceleration=1.0),
        lambda: sky.Mover(shape=BALL.model_copy(update={"max_speed": 3.0}), motion=STANDS),
        lambda: sky.Mover(shape=BALL.model_copy(update={"active": ((0.0, 1.0),)}), motion=STANDS),
        lambda: sky.Scenario(**{**dict(sky.read("map1")), "obstacles": [sky.Box(**AIRSHOW, active=[[0, 1]])]}),
    ],
    ids=["a doubt", "a limit", "times of a mover", "times of an obstacle"],
)
def test_what_movers_and_obstacles_cannot_have_is_refused(made, refuses):
    with refuses(ValueError):
        made()
