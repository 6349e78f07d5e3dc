"""Tours in flight: led away from its tour or not, a UAV makes every visit, in order and for as long as asked."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.live import LiveSession
from skyverse.live.closed_loop import fly_closed_loop

NEAR = sky.Scenario(
    name="near",
    bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 6)),
    obstacles=(sky.Box(min=(7, 0, 0), max=(8, 6, 6)),),
    clearance=0.5,
    uavs=(
        sky.UAV(start=(3, 3, 2), end="home", capacity=1.0, swap=3.0),
        sky.UAV(start=(17, 17, 2)),
    ),
    targets=(
        sky.Target(position=(14, 3, 2), stay=2.0, demand=1.0, uavs=("uav-1",)),
        sky.Target(position=(3, 14, 2), stay=1.0, demand=1.0, heading=90.0, uavs=("uav-1",)),
        sky.Target(position=(12, 12, 3), stay=1.5, uavs=("uav-2",)),
        sky.Target(position=(17, 8, 2), stay=1.5, window=(8.0, 40.0), uavs=("uav-2",)),
    ),
)


@pytest.fixture(scope="module")
def tour():
    return sky.plan_mission(NEAR)


def judged(replanner):
    """Assert that UAVs made all visits of their tours as told, and return the mission as it was flown."""
    mission = replanner.mission
    for uav, planned in enumerate(mission.sorties):
        flown, own = replanner.flown(uav), mission.scenario.uavs[uav]
        told = [visit for sortie in replanner.sorties(uav) for visit in sortie.visits]
        wanted = [visit for sortie in planned for visit in sortie.visits]
        assert [visit.target for visit in told] == [visit.target for visit in wanted]
        assert len(replanner.sorties(uav)) == len(planned)
        for visit, asked in zip(told, wanted, strict=True):
            target = mission.scenario.targets[visit.target]
            assert visit.arrival >= asked.arrival - 1e-9
            assert visit.departure - visit.arrival >= target.stay - 1e-9
            there = flown.at(np.linspace(visit.arrival, visit.departure, 50)).position
            assert np.abs(there - target.position).max() <= 1e-5
        for one, following in zip(replanner.sorties(uav), replanner.sorties(uav)[1:], strict=False):
            assert following.begin - one.end >= own.swap - 1e-9
            there = flown.at(np.linspace(one.end, following.begin, 50)).position
            assert np.abs(there - own.start).max() <= 1e-5
        end = mission.scenario.end_place(uav, mission.assignment[uav])
        assert flown.at([flown.end]).position[0] == pytest.approx(end, abs=1e-5)


def test_where_nothing_is_met_a_tour_is_flown_as_planned(tour):
    assert [len(own) for own in tour.sorties] == [2, 1]
    replanner = sky.Replanner(tour)
    for t in np.arange(0.0, tour.makespan + 0.1, 0.1):
        assert all(answer.proven for answer in replanner.observe(t))
    for uav, planned in enumerate(tour.trajectories):
        times = np.linspace(0.0, planned.end, 1000)
        assert replanner.flown(uav).at(times).position == pytest.approx(planned.at(times).position, abs=1e-9)
        assert replanner.sorties(uav) == tour.sorties[uav]
        assert replanner.arrival(uav) == pytest.approx(planned.end)
    judged(replanner)


def passing(place, t):
    """Return a ball that comes from the side, passes through a place at an instant, and goes far up."""
    points = [np.add(place, off) for off in ((-1, 4, 1), (0, 0, 0), (3, 0, 3))]
    points = [tuple(np.clip(point, 0.0, (20, 20, 5.9)).tolist()) for point in points]
    motion = sky.WaypointMotion(points=points, times=[t - 4.0, t, t + 3.0])
    return sky.Mover(name="ball", shape=sky.Sphere(centre=(0, 0, 0), radius=0.3), motion=motion)


MET = {
    "during a stay": ((14, 3, 2), 5.7),
    "just before a departure": ((14, 3, 2), 6.6),
    "on a leg": ((10.5, 7, 2), 8.0),
    "at home": ((3, 3, 2), 13.0),
    "where it looks": ((3, 14, 2), 26.0),
    "at the last stop": ((17, 8, 2), 9.0),
}


@pytest.mark.parametrize("where", MET)
def test_led_away_from_its_tour_a_uav_makes_all_visits_in_order_and_for_as_long_as_asked(tour, where):
    truth = NEAR.model_copy(update={"movers": (passing(*MET[where]),)})
    replanner = sky.Replanner(tour)
    assert fly_closed_loop(replanner, truth, sky.Sensor(range=6.0), longest=90.0)
    judged(replanner)
    away = [
        np.abs(replanner.flown(uav).at(times).position - one.at(times).position).max()
        for uav, one in enumerate(tour.trajectories)
        for times in [np.linspace(0.0, one.end, 500)]
    ]
    assert max(away) > 0.1


def test_targets_of_tours_are_not_changed_in_flight(tour, refuses):
    replanner = sky.Replanner(tour)
    with refuses() as refused:
        replanner.observe(0.1, targets={0: (3.0, 14.0, 3.0)})
    assert refused.value.sentence.field == "targets[0]"
    assert replanner.observe(0.1)[0].proven


def test_policies_fly_no_tours(tour, refuses):
    with refuses() as refused:
        sky.Replanner(tour, policy="wait")
    assert refused.value.sentence.field == "policy"


def test_a_session_announces_where_tours_end(tour):
    announced = LiveSession(sky.Replanner(tour)).hello().uavs
    assert [one.target for one in announced] == [(3.0, 3.0, 2.0), (17.0, 8.0, 2.0)]
