"""UAVs keep clear of movers at every instant: proofs against dense samples, and faults that were planted."""

import math
import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skyverse as sky
from movers import depth_at, motions, movers, points
from skyverse.lab import Study
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt, Mover
from skyverse.model.mover_motions import CircularMotion, WaypointMotion
from skyverse.model.result import Provenance
from skyverse.model.scenario import Bounds, Lattice, Scenario, Target
from skyverse.model.shapes import Sphere
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV, TrackingError
from skyverse.model.verdict import Fault, Verdict
from skyverse.referee.mover_motion import MAX_PIECES, enclosed_motion

MADE_BY = Provenance("0", "by hand", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.9, "thrust_to_weight": 1e3}
REST_TO_REST = np.array([0, 0, 0, 10, -15, 6.0])
BALL = Sphere(centre=(0, 0, 0), radius=1.0)


def flight(a, b, seconds, start=0.0):
    """From rest at a to rest at b."""
    rows = (REST_TO_REST / seconds ** np.arange(6))[:, None] * (np.array(b, float) - a)
    rows[0] = a
    return Trajectory(np.array([start, start + seconds]), rows[None])


def among(*movers, flown, clearance=0.5, **fields):
    """A mission of one UAV among movers."""
    a, b = (flown.at(t).position[0] for t in (flown.start, flown.end))
    scenario = Scenario(
        name="movers",
        bounds=Bounds(min=(-1e3, -1e3, -1e3), max=(1e3, 1e3, 1e3)),
        clearance=clearance,
        lattice=Lattice(step=(100, 100, 100)),
        **({"movers": movers} if movers else {}),
        uavs=(UAV(start=a, **(AGILE | fields)),),
        targets=(Target(position=b),),
    )
    return Mission(scenario, (0,), (None,), (flown,), (), MADE_BY)


def verdict(mission):
    """What the referee says of the only UAV."""
    return sky.certify(mission.scenario, mission).trajectories[0]


@given(motions)
@settings(max_examples=60)
def test_polynomial_pieces_lie_within_their_error_of_the_stated_motion(motion):
    end = 20.0
    known = enclosed_motion(motion, end)
    assert known.knots[0] == 0
    assert known.knots[-1] == end
    assert (np.diff(known.knots) > 0).all()
    for k, (begin, until) in enumerate(zip(known.knots[:-1], known.knots[1:], strict=False)):
        inside = np.linspace(begin, until, 9)[1:-1]
        at = np.vander(inside - known.begins[k], known.pieces.shape[1], increasing=True) @ known.pieces[k]
        assert np.abs(at - motion.at(inside)).max() <= known.error[k] + 1e-12 * (1 + np.abs(at).max())


@given(st.lists(movers, min_size=1, max_size=4), points, points, st.floats(3, 15), st.none() | st.floats(0.05, 0.6))
@settings(max_examples=60, deadline=None)
def test_what_is_proven_holds_at_ten_thousand_samples_and_what_is_refuted_is_seen_there(
    given_movers, a, b, seconds, error
):
    flown = flight(a, tuple(np.add(b, (0.5, 0, 0))), seconds, start=1.0)
    more = {} if error is None else {"tracking_error": TrackingError(horizontal=error, vertical=error / 2)}
    said = verdict(among(*given_movers, flown=flown, **more))
    instants = np.linspace(0, flown.end + 1, 10_001)
    places = flown.at(np.clip(instants, flown.start, flown.end)).position
    aside, up = (0.0, 0.0) if error is None else (error, error / 2)
    strayed = [(0, 0, 0), (aside, 0, up), (-aside, 0, -up), (0, aside, up), (0, -aside, 0), (0, 0, up), (0, 0, -up)]
    deepest = max(depth_at(mover, instants, places + by, 0.5).max() for mover in given_movers for by in strayed)
    if deepest > 2e-6:
        assert said.verdict is Verdict.REFUTED
        assert "mover" in said.sentence
    elif deepest < -0.05 and error is None:
        assert said.verdict is Verdict.PROVEN


def test_a_mover_that_crosses_the_way_is_found_at_the_worst_instant():
    crossing = Mover(name="lorry", shape=BALL, motion=WaypointMotion(points=[(5, -5, 0), (5, 5, 0)], times=[0, 10]))
    mission = among(crossing, flown=flight((0, 0, 0), (10, 0, 0), 10))
    (found,) = [one for one in sky.check(mission.scenario, mission) if one.fault is Fault.MOVER]
    assert found.time == pytest.approx(5, abs=1e-3)
    assert found.uavs == (0,)
    assert "1 m inside mover 'lorry' at t = 5 s" in found.message
    assert "0.5 m are required" in found.message
    late = among(crossing, flown=flight((0, 0, 0), (10, 0, 0), 10, start=7))
    assert verdict(late).verdict is Verdict.PROVEN
    assert "clear of every mover, wherever within its doubt that may be, by 0.5 m" in verdict(late).sentence


@pytest.mark.parametrize("start", [0.0, 30.0])
def test_a_uav_is_judged_while_it_waits_for_its_departure_and_after_its_arrival(start):
    place = (0, 0, 0) if start else (10, 0, 0)
    back_and_forth = WaypointMotion(points=[(place[0], -40, 0), (place[0], 40, 0)], times=[0, 20], then="stays")
    mission = among(Mover(shape=BALL, motion=back_and_forth), flown=flight((0, 0, 0), (10, 0, 0), 10, start=start))
    told = verdict(mission)
    if start:
        assert told.verdict is Verdict.REFUTED
        assert told.time == pytest.approx(10, abs=0.01)
    else:
        assert told.verdict is Verdict.REFUTED
        assert told.time == pytest.approx(10, abs=0.3)


def test_doubt_that_grows_makes_a_flight_unsafe_that_was_safe():
    aside = WaypointMotion(points=[(5, 3, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    assert verdict(among(Mover(shape=BALL, motion=aside), flown=flown)).verdict is Verdict.PROVEN
    doubt = Doubt(growth=0.31)
    told = verdict(among(Mover(shape=BALL, motion=aside, doubt=doubt), flown=flown))
    assert told.verdict is Verdict.REFUTED
    assert "where mover 'mover-1' may be" in told.sentence
    later = Doubt(growth=0.31, since=5.0)
    assert verdict(among(Mover(shape=BALL, motion=aside, doubt=later), flown=flown)).verdict is Verdict.PROVEN


def test_doubt_that_accelerates_reaches_a_flight_when_its_formula_says_so():
    aside = WaypointMotion(points=[(5, 4, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    fast = {"since": 1.0, "top_speed": 5.0}
    near = Doubt(acceleration=0.09, **fast)  # 4.5 m at 11 s, where 4.9 m are left
    assert verdict(among(Mover(shape=BALL, motion=aside, doubt=near), flown=flown)).verdict is Verdict.PROVEN
    gaps = {}
    for acceleration in (0.6, 5.0):
        doubt = Doubt(acceleration=acceleration, **fast)
        told = verdict(among(Mover(shape=BALL, motion=aside, doubt=doubt), flown=flown))
        assert told.verdict is Verdict.REFUTED
        place, after = np.array(told.position), told.time - 1.0
        quick = min(after, 10.0 / acceleration)  # up to twice the top speed
        spread = acceleration * (after * quick - 0.5 * quick * quick)
        reached = min(spread, 5.0 * after)
        gaps[acceleration] = np.linalg.norm(place - (5, 4, 0)) - BALL.radius - reached
        words = re.search(r"comes within (\S+) m|is (\S+) m inside", told.sentence)
        said = float(words[1]) if words[1] else -float(words[2])
        assert said == pytest.approx(gaps[acceleration], abs=1e-4)


def test_a_doubt_that_accelerates_needs_a_top_speed():
    with pytest.raises(ValueError, match="acceleration needs a top_speed"):
        Doubt(acceleration=1.0)
    doubt = Doubt(radius=0.1, growth=0.2, acceleration=2.0, since=1.0, top_speed=3.0)
    assert doubt.at([0.0, 1.0, 2.0, 5.0]) == pytest.approx([0.1, 0.1, 1.3, 0.1 + 0.8 + 2 * 4.5 + 6])
    assert doubt.grows
    assert not Doubt(radius=1.0).grows


def test_a_top_speed_bounds_what_a_mover_may_do_after_its_last_observation():
    near = WaypointMotion(points=[(-50, 0, 0), (-7, 0, 0)], times=[0, 9])  # up to 7 m from the UAV's place
    flown = flight((0, 0, 0), (0, 0, 1), 9)
    doubt = Doubt(radius=0.1, growth=2.0)  # so it may be 18 m farther by then
    assert verdict(among(Mover(shape=BALL, motion=near, doubt=doubt), flown=flown)).verdict is Verdict.REFUTED
    slow = Doubt(radius=0.1, growth=2.0, top_speed=4.8)  # seen 50 m away at 0 s, it cannot be here within 10 s
    assert verdict(among(Mover(shape=BALL, motion=near, doubt=slow), flown=flown)).verdict is Verdict.PROVEN


def test_the_tracking_error_counts():
    aside = WaypointMotion(points=[(5, 2.0, 0)], times=[0])
    flown = flight((0, 0, 0), (10, 0, 0), 10)
    assert verdict(among(Mover(shape=BALL, motion=aside), flown=flown)).verdict is Verdict.PROVEN
    error = TrackingError(horizontal=0.6, vertical=0.1)
    told = verdict(among(Mover(shape=BALL, motion=aside), flown=flown, tracking_error=error))
    assert told.verdict is Verdict.REFUTED
    assert "with its tracking error" in told.sentence


def test_a_uav_that_stands_at_its_start_is_judged_too():
    mission = among(
        Mover(shape=BALL, motion=CircularMotion(centre=(0, 0, 0), radius=3, period=4)),
        flown=flight((0, 0, 0), (9, 0, 0), 5),
    )
    scenario = mission.scenario.model_copy(update={"uavs": (*mission.scenario.uavs, UAV(start=(3, 0, 0), **AGILE))})
    mission = Mission(scenario, (0, None), (None, None), (mission.trajectories[0], None), (), MADE_BY)
    assert (Fault.MOVER, (1,)) in {(found.fault, found.uavs) for found in sky.check(scenario, mission)}


def test_a_motion_with_too_many_turns_is_undecided_and_not_judged_for_hours():
    restless = WaypointMotion(points=[(0, 0, 50), (1, 0, 50)], times=[0, 0.01], then="returns")
    assert enclosed_motion(restless, 0.01 * MAX_PIECES) is None
    told = verdict(among(Mover(shape=BALL, motion=restless), flown=flight((0, 0, 0), (10, 0, 0), 1e4)))
    assert told.verdict is Verdict.UNDECIDED
    assert "too many turns" in told.sentence


def test_a_circle_begins_at_its_bearing_and_turns_the_way_it_says():
    left = CircularMotion(centre=(1, 2, 3), radius=5, period=8, bearing=90)
    assert left.at([0, 2, 4]) == pytest.approx(np.array([[6, 2, 3], [1, 7, 3], [-4, 2, 3]]))
    right = CircularMotion(centre=(1, 2, 3), radius=5, period=8, bearing=90, clockwise=True)
    assert right.at([2]) == pytest.approx(np.array([[1, -3, 3]]))
    assert math.hypot(*(left.at(1.0)[0] - (1, 2, 3))) == pytest.approx(5)


def test_missions_among_movers_are_exported_as_data_once_the_referee_has_judged_them(tmp_path):
    stands = Mover(shape=BALL, motion=WaypointMotion(points=[(5, 30, 0)], times=[0]))
    stands_in_the_way = Mover(shape=BALL, motion=WaypointMotion(points=[(5, 0, 0)], times=[0]))
    ordinary = {"max_speed": 5, "max_acceleration": 3.5, "max_jerk": 50, "max_tilt": 40, "thrust_to_weight": 2.5}
    standing = flight((0, 0, 0), (9, 0, 0), 5)
    mission = sky.plan_mission(among(stands, flown=standing, **ordinary).scenario, sky.Taut())
    here = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0, geoid=47.0)
    for suffix in ("csv", "trajectory.yaml", "path.json", "geojson", "gpx", "geo.csv", "kml"):  # which hold its times
        assert sky.export(mission, tmp_path / f"out.{suffix}", origin=here)
    assert (tmp_path / "out.csv").read_text().count("\n") > 20
    with pytest.raises(sky.InputError, match="the referee refutes this mission"):
        sky.export(
            mission,
            tmp_path / "hit.csv",
            scenario=among(stands_in_the_way, flown=standing, **ordinary).scenario,
        )
    assert not (tmp_path / "hit.csv").exists()


def test_missions_among_movers_are_neither_exported_to_autopilots_nor_flown(tmp_path):
    ordinary = {"max_speed": 5, "max_acceleration": 3.5, "max_jerk": 50, "max_tilt": 40, "thrust_to_weight": 2.5}
    stands = Mover(shape=BALL, motion=WaypointMotion(points=[(5, 30, 0)], times=[0]))
    mission = among(stands, flown=flight((0, 0, 0), (9, 0, 0), 5), **ordinary)
    with pytest.raises(sky.InputError, match="has movers, and no autopilot keeps a schedule exactly enough"):
        sky.export(mission, tmp_path / "out.plan", origin=(47.0, 8.0, 400.0))
    assert not list(tmp_path.iterdir())
    for fly in (sky.fly, partial(sky.fly, runs=2), sky.fly_until_safe):
        with pytest.raises(sky.InputError, match="flights among movers cannot be simulated"):
            fly(mission)
    with pytest.raises(sky.InputError, match="has movers, and no autopilot keeps a schedule"):
        sky.routes(mission, origin=(47.0, 8.0, 400.0))


def test_studies_refuse_movers(tmp_path):
    stands = Mover(shape=BALL, motion=WaypointMotion(points=[(5, 30, 0)], times=[0]))
    file = tmp_path / "moving.yaml"
    sky.write(among(stands, flown=flight((0, 0, 0), (9, 0, 0), 5)).scenario, file)
    study = Study(scenarios=[str(file)], planners=["taut"], budget=[{"paths": 10}], seeds=[1])
    with pytest.raises(sky.InputError, match="movers: expected none, since studies compare paths"):
        list(study.jobs())


def test_a_mover_has_no_speed_limit_for_others():
    with pytest.raises(ValueError, match="a mover has no max_speed for others"):
        Mover(
            shape=Sphere(centre=(0, 0, 0), radius=1, max_speed=3), motion=WaypointMotion(points=[(5, 3, 0)], times=[0])
        )


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


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("times: [10, 0]", r"movers\[0\].*times must rise, but times\[1\] is 0 s after 10 s"),
        ("times: [0]", r"movers\[0\].*times must be as many as points, 2, but they are 1"),
        ("times: [0, 10], then: repeats", r"movers\[0\].*the last point is not the first one"),
    ],
)
def test_bad_movers_get_one_sentence(tmp_path, wrong, said):
    file = tmp_path / "moving.yaml"
    sky.write(among(flown=flight((0, 0, 0), (9, 0, 0), 5)).scenario, file)
    mover = "movers: [{shape: {shape: sphere, centre: [0, 0, 0], radius: 1}, motion: {points: %s, %s}}]"
    file.write_text(file.read_text().replace("movers: []\n", "") + mover % ([[5, 0, 0], [5, 5, 0]], wrong) + "\n")
    with pytest.raises(sky.InputError, match=said):
        sky.read(file)
