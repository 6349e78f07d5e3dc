"""What holds for multirotors and aeroplanes alike: they fly the mission, and round all that they come to know."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, certified, faults, field, fly, hall, observe, whole_flight

PILLARS = [sky.Cylinder(centre=(x, 5 + 0.3 * (-1) ** x), radius=0.5, low=0, high=4) for x in (5, 8, 11, 14)]
HOUSES = [sky.Box(min=(200, 100, 0), max=(260, 220, 120)), sky.Box(min=(380, 180, 0), max=(420, 330, 120))]
STREET = [sky.Box(min=(100, 0, 0), max=(500, 170, 120)), sky.Box(min=(100, 230, 0), max=(500, 400, 120))]


def crossing(shape, *points, seconds):
    return sky.Mover(name="ball", shape=shape, motion=sky.WaypointMotion(points=points, times=[0, seconds]))


KINDS = {
    "multirotor": SimpleNamespace(
        scenario=hall,
        known=PILLARS,
        rate=10.0,
        since=0.5,
        ball=crossing(BALL, (10, 0, 1), (10, 10, 1), seconds=5),
        moves={"top_speed": 2.5, "max_acceleration": 0.5},
        wall=sky.Box(min=(12, 2, 0), max=(12.5, 9, 4)),
        shut=sky.Box(min=(12, 0, 0), max=(12.5, 10, 4)),
        zone=sky.Box(min=(9, 3, 0), max=(11, 7, 4), active=[(0.0, 100.0)]),
        targets=[(12, 1, 3), (3, 8, 1)],
        off=(0.0, 0.8, 0.3),
    ),
    "aeroplane": SimpleNamespace(
        scenario=field,
        known=HOUSES,
        rate=5.0,
        since=5.0,
        ball=crossing(sky.Sphere(centre=(0, 0, 0), radius=10), (300, 20, 46), (300, 380, 46), seconds=36),
        moves={"top_speed": 11.0, "max_acceleration": 0.05},
        wall=sky.Box(min=(330, 60, 0), max=(340, 300, 120)),
        shut=sky.Box(min=(330, 0, 0), max=(340, 400, 120)),
        zone=sky.Box(min=(280, 140, 0), max=(340, 260, 120), active=[(0.0, 300.0)]),
        targets=[(300, 340, 40), (100, 100, 60)],
        off=(0.0, 12.0, 4.0),
    ),
}


@pytest.fixture(params=KINDS)
def kind(request):
    return KINDS[request.param]


def replanner(scenario):
    return sky.Replanner(sky.plan_mission(scenario))


@pytest.mark.parametrize(
    ("scenario", "shape"),
    [
        *((hall(*obstacles), shape) for obstacles in ((), PILLARS) for shape in ("minimum-time", "minimum-snap")),
        *((field(*obstacles), "minimum-time") for obstacles in ((), HOUSES, STREET)),
        (field(size=(600, 240, 120)), "minimum-time"),
    ],
)
def test_who_meets_nothing_flies_the_mission(scenario, shape):
    mission = sky.plan_mission(scenario, assignment="identity", options=sky.MissionOptions(shape=shape))
    assert not mission.violations
    flight = sky.Replanner(mission)
    answers = fly(flight, [], rate=5.0, top_speed=1.0)
    assert all(one.proven for answer in answers for one in answer)
    (planned,) = mission.trajectories
    assert flight.arrival(0) == pytest.approx(planned.end)
    t = np.linspace(0.0, planned.end, 500)
    for flown, meant in zip(flight.flown(0).at(t)[:2], planned.at(t)[:2], strict=True):
        np.testing.assert_allclose(flown, meant, atol=1e-6)


@pytest.mark.parametrize("known", [False, True], ids=["alone", "among obstacles"])
def test_a_ball_is_let_pass_and_that_is_proven_and_the_same_each_time(kind, known):
    scenario = kind.scenario(*(kind.known if known else ()))
    flights = [replanner(scenario) for _ in range(2)]
    for flight in flights:
        answers = fly(flight, [kind.ball], rate=kind.rate, **kind.moves)
        assert all(one.proven for (one,) in answers)
        assert flight.arrival(0) is not None
    assert flights[0].flown(0) == flights[1].flown(0)
    assert certified(flight, [kind.ball]).trajectories[0].verdict is sky.Verdict.PROVEN
    among = sky.Scenario(**{**dict(scenario), "movers": [kind.ball]})
    if not known:
        as_planned = sky.certify(among, replace(flight.mission, scenario=among))
        assert as_planned.trajectories[0].verdict is sky.Verdict.REFUTED


@pytest.mark.parametrize("what", ["obstacles", "zones"])
def test_a_wall_or_a_restriction_that_comes_to_be_known_is_flown_round(kind, what):
    thing, flight = kind.wall if what == "obstacles" else kind.zone, replanner(kind.scenario())
    observe(flight, 0.0, kind.since, kind.rate)
    answers = observe(flight, kind.since, 90.0, kind.rate, **{what: [thing]})
    assert all(one.proven for one in answers)
    assert flight.arrival(0) is not None
    among = sky.Scenario(**{**dict(kind.scenario()), what: (thing,)})
    assert whole_flight(flight, among).verdict is sky.Verdict.PROVEN


def test_who_is_closed_off_by_a_new_wall_stays_before_it(kind):
    flight = replanner(kind.scenario())
    observe(flight, 0.0, kind.since, kind.rate)
    answers = observe(flight, kind.since, 60.0, 2.0, obstacles=[kind.shut])
    assert all(one.proven for one in answers)
    assert flight.arrival(0) is None
    places = flight.flown(0).at(np.linspace(0, 60, 600)).position
    assert places[:, 0].max() < kind.shut.min[0] - flight.scenario.clearance + 1e-6


def test_another_target_is_flown_to_also_after_the_arrival(kind):
    flight, since = replanner(kind.scenario()), kind.since
    observe(flight, 0.0, since, kind.rate)
    for target in kind.targets:
        answers = observe(flight, since, since + 120.0, kind.rate, targets={0: target})
        assert all(one.proven for one in answers)
        assert flight.scenario.targets[0].position == target
        assert flight.flown(0).at([flight.arrival(0)]).position[0] == pytest.approx(target)
        assert whole_flight(flight, flight.scenario).verdict is sky.Verdict.PROVEN
        since = flight.now + 1.0


def test_who_was_blown_off_its_course_goes_on_from_where_it_is(kind):
    flight, now = replanner(kind.scenario()), 4.0 * kind.since
    observe(flight, 0.0, now, kind.rate)
    place, velocity, _ = (part[0] for part in flight.motion(0).at([now]))
    blown, turned = place + kind.off, np.array([velocity[1], velocity[0], 0.0])
    (answer,) = flight.observe(now, states={0: (blown, turned)})
    assert answer.proven
    at = flight.motion(0).at([now])
    assert at.position[0] == pytest.approx(blown)
    assert at.velocity[0] == pytest.approx(turned, abs=1e-8)
    assert faults(flight) == []
    assert all(one.proven for one in observe(flight, now + 0.2, 90.0, kind.rate))
    assert flight.arrival(0) is not None


def test_a_target_that_no_path_leads_to_is_refused_and_changes_nothing(kind, refuses):
    flight = replanner(kind.scenario(*kind.known))
    observe(flight, 0.0, 2.0, kind.rate)
    before = flight.now, flight.motion(0), flight.scenario
    inside = kind.known[0].model_dump()
    place = (*inside["centre"], 1.0) if "centre" in inside else tuple(np.mean([inside["min"], inside["max"]], axis=0))
    with refuses():
        flight.observe(3.0, targets={0: place})
    assert (flight.now, flight.motion(0), flight.scenario) == before


def test_a_deadline_of_0_leaves_the_present_motion(kind):
    flight = replanner(kind.scenario())
    observe(flight, 0.0, 1.0, kind.rate)
    (answer,) = flight.observe(1.0, deadline_ms=0.0)
    assert (answer.proven, answer.kept, answer.tried) == (True, True, 0)
