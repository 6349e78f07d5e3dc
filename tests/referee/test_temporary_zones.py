"""UAVs keep clear of zones while they are active: proofs against dense samples, and faults that were planted."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import points
from skyverse.model.mission import Mission
from skyverse.model.result import Provenance
from skyverse.model.temporary_zones import with_zones_active
from skyverse.model.verdict import Fault, Verdict
from skyverse.referee.curve import curve_of
from skyverse.referee.speed_zones import judge_zone_speed
from temporary_zones import depth_in_zone, depth_while_active, zones

MADE_BY = Provenance("0", "by hand", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
REST_TO_REST = np.array([0, 0, 0, 10, -15, 6.0])
AIRSHOW = {"name": "airshow", "min": (4, -1, -1), "max": (6, 1, 1)}


def flight(a, b, seconds, start=0.0):
    """From rest at a to rest at b."""
    rows = (REST_TO_REST / seconds ** np.arange(6))[:, None] * (np.array(b, float) - a)
    rows[0] = a
    return sky.Trajectory(np.array([start, start + seconds]), rows[None])


def through(*zones, flown, clearance=0.5, **fields):
    """A mission of one UAV among zones."""
    a, b = (flown.at(t).position[0] for t in (flown.start, flown.end))
    scenario = sky.Scenario(
        name="zones",
        bounds={"min": (-1e3, -1e3, -1e3), "max": (1e3, 1e3, 1e3)},
        clearance=clearance,
        lattice={"step": (100, 100, 100)},
        zones=zones,
        uavs=(sky.UAV(start=a, **(AGILE | fields)),),
        targets=({"position": tuple(b)},),
    )
    return Mission(scenario, (0,), (None,), (flown,), (), MADE_BY)


def verdict(mission):
    """What the referee says of the only UAV."""
    return sky.certify(mission.scenario, mission).trajectories[0]


def zone_faults(mission):
    """What is wrong besides that the mission has a flight without a path."""
    wrong = sky.check(mission.scenario, mission)
    return [one for one in wrong if one.fault in (Fault.ACTIVE_ZONE, Fault.ZONE_SPEED, Fault.UNDECIDED)]


@given(st.lists(zones(), min_size=1, max_size=4), points, points, st.floats(3, 15), st.none() | st.floats(0.05, 0.6))
@settings(max_examples=100, deadline=None)
def test_what_is_proven_holds_at_many_samples_and_what_is_refuted_is_seen_there(given_zones, a, b, seconds, error):
    flown = flight(a, tuple(np.add(b, (0.5, 0, 0))), seconds, start=1.0)
    more = {} if error is None else {"tracking_error": sky.TrackingError(horizontal=error, vertical=error / 2)}
    said = verdict(through(*given_zones, flown=flown, **more))
    edges = [t for zone in given_zones for span in zone.active for t in span if t is not None]
    instants = np.unique(np.clip([*np.linspace(0, flown.end + 1, 5_001), *edges], 0, flown.end + 1))
    places = flown.at(np.clip(instants, flown.start, flown.end)).position
    aside, up = (0.0, 0.0) if error is None else (error, error / 2)
    strayed = [(0, 0, 0), (aside, 0, up), (-aside, 0, -up), (0, aside, up), (0, -aside, 0), (0, 0, up), (0, 0, -up)]
    deepest = max(depth_while_active(zone, instants, places + by, 0.5).max() for zone in given_zones for by in strayed)
    if deepest > 2e-6:
        assert said.verdict is Verdict.REFUTED
        assert "zone" in said.sentence
    elif deepest < -0.05 and error is None:
        assert said.verdict is Verdict.PROVEN
        assert "clear of every zone while it is active by 0.5 m" in said.sentence


@pytest.mark.parametrize(
    ("active", "fault"),
    [
        ([[None, None]], Fault.ACTIVE_ZONE),
        ([[None, 4.0]], None),
        ([[None, 4.4]], Fault.ACTIVE_ZONE),
        ([[6.0, None]], None),
        ([[5.6, None]], Fault.ACTIVE_ZONE),
        ([[0, 4.0], [6.0, 9]], None),
        ([[0, 4.0], [5, 5.0001], [6.0, 9]], Fault.ACTIVE_ZONE),
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


@pytest.mark.parametrize("start", [0.0, 30.0])
def test_a_uav_is_judged_while_it_waits_for_its_departure_and_after_its_arrival(start):
    place = (0, 0, 0) if start else (10, 0, 0)
    box = sky.Box(min=np.array(place) - 1.0, max=np.array(place) + 1.0, active=[[10.5, 11]])
    told = verdict(through(box, flown=flight((0, 0, 0), (10, 0, 0), 10, start=start)))
    assert told.verdict is Verdict.REFUTED
    assert 10.5 - 1e-9 <= told.time <= 11 + 1e-9


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
        assert found.fault is Fault.ZONE_SPEED
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
        assert sky.certify(always, mission).trajectories[0].verdict is Verdict.PROVEN
        assert verdict(mission).verdict is Verdict.PROVEN


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("active: [[5, 2]]", r"zones\[0\].*active\[0\] must end after it begins, but is from 5 s to 2 s"),
        ("active: [[1, 5], [4, 9]]", r"zones\[0\].*active\[1\] must begin after active\[0\] has ended"),
        ("active: [[1, null], [4, 9]]", r"zones\[0\].*active\[1\] must begin after active\[0\] has ended"),
        ("active: []", r"zones\[0\].*active"),
        ("active: [[.nan, 2]]", r"zones\[0\].*active\[0\]\[0\]"),
        ("active: [[0, 5]], risk: 2", r"zones\[0\].*a zone with a risk has no active times"),
        ("name: nothing", r"zones\[0\].*a zone needs a risk.*a max_speed, m/s, or times at which it is active"),
    ],
)
def test_bad_times_get_one_sentence(tmp_path, wrong, said):
    file = tmp_path / "zones.yaml"
    sky.write(through(flown=flight((0, 0, 0), (9, 0, 0), 5)).scenario, file)
    text = file.read_text().replace("zones: []\n", "")
    file.write_text(text + f"zones: [{{min: [0, 0, 0], max: [1, 1, 1], {wrong}}}]\n")
    with pytest.raises(sky.InputError, match=said):
        sky.read(file)


def test_obstacles_and_movers_have_no_active_times():
    with pytest.raises(ValueError, match="an obstacle is always there"):
        sky.Scenario(**{**dict(sky.read("map1")), "obstacles": [sky.Box(**AIRSHOW, active=[[0, 1]])]})
    stands = sky.WaypointMotion(points=[(5, 3, 0)], times=[0])
    with pytest.raises(ValueError, match="a mover has no active times"):
        sky.Mover(shape=sky.Sphere(centre=(0, 0, 0), radius=1, active=[[0, 1]]), motion=stands)
