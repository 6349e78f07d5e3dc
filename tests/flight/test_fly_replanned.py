"""Missions replanned while they are flown in rotorpy: what is seen, what is avoided, and what is found wrong."""

import itertools
import json

import numpy as np
import pytest

import skyverse as sky
from replanned import BALL, hall

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

CROSSING = sky.Mover(
    name="cart", shape=BALL, motion=sky.WaypointMotion(points=[(5, 2, 1), (5, 8, 1)], times=[0, 6], then="returns")
)
WALL = sky.Box(min=(5, 1.5, 0), max=(5.4, 8, 4))
SENSOR = sky.Sensor(range=4.0, delay=0.05, error=0.02)


def short_hall(**more):
    """A hall of ten metres that one UAV crosses."""
    scenario = hall(size=(10, 10, 4), targets=[sky.Target(position=(9, 5, 1))])
    return sky.Scenario(**{**dict(scenario), **more})


@pytest.fixture(scope="module")
def mission():
    return sky.plan_mission(short_hall())


@pytest.fixture(scope="module")
def flight(mission):
    """A flight past a mover and a wall that the mission does not know of."""
    truth = short_hall(movers=[CROSSING], obstacles=[WALL])
    return sky.fly_replanned(sky.Replanner(mission), truth, SENSOR, rng=4)


class Blind(sky.Replanner):
    """A replanner to which nothing is told of what was seen."""

    def observe(self, t, **seen):
        return super().observe(t)


def test_an_unknown_wall_and_a_mover_are_avoided_in_rotorpy(flight):
    assert flight.safe, flight.violations
    assert flight.certificate.verdict is sky.Verdict.PROVEN
    assert flight.truth.obstacles == (WALL,)
    (flown,) = flight.flown
    low, high = np.array(WALL.min), np.array(WALL.max)
    beyond = np.maximum(low - flown.positions, flown.positions - high).clip(0)
    assert np.linalg.norm(beyond, axis=1).min() == pytest.approx(flown.clearance)
    assert flown.clearance > flight.truth.clearance - flight.flight.margin
    assert np.linalg.norm(flown.positions[-1] - (9, 5, 1)) < 0.02
    assert flown.largest < 0.1
    assert "proven clear of all movers and obstacles as they truly were" in flight.proof_sentence
    assert "allows for no tracking error" in flight.proof_sentence


def test_only_what_is_within_range_of_where_the_uav_really_is_is_seen(flight):
    (flown,) = flight.flown
    for step in flight.steps[:-1]:
        place = flown.positions[round(step.time * 100)]
        off = np.linalg.norm(CROSSING.at([step.time])[0] - place)
        assert (step.movers == (0,)) == (off <= SENSOR.range + CROSSING.shape.radius)
    (seen,) = [step for step in flight.steps if step.obstacles]
    place = flown.positions[round(seen.time * 100)]
    assert 3.5 < np.linalg.norm(np.maximum(np.array(WALL.min) - place, 0)) <= SENSOR.range


def test_observations_are_made_at_the_rate_and_arrive_after_the_delay(flight):
    times = [step.time for step in flight.steps]
    assert times == pytest.approx(np.arange(len(times)) / 10)
    assert [step.arrival for step in flight.steps] == pytest.approx([t + 0.05 for t in times])


def test_predictions_hold_the_mover_where_it_truly_is(flight):
    predicted = [(step.time, one) for step in flight.steps for one in step.predictions]
    assert predicted
    for t, one in predicted:
        later = t + np.linspace(0.0, flight.horizon, 20)
        doubt = sky.Doubt.at(one.doubt, later)
        assert (np.linalg.norm(one.motion.at(later) - CROSSING.at(later), axis=1) <= doubt + 1e-9).all()


def test_what_was_commanded_is_made_of_the_motions_of_the_answers(flight):
    (reference,) = flight.references
    motion = None
    for step, following in itertools.pairwise(flight.steps):
        motion = step.answers[0].motion or motion
        t = np.linspace(step.time, following.time, 5)
        assert motion.at(t).position == pytest.approx(reference.at(t).position, abs=1e-9)


def test_a_replanner_that_is_blind_flies_into_what_is_in_its_way(mission):
    truth = short_hall(
        movers=[CROSSING.model_copy(update={"motion": sky.WaypointMotion(points=[(5, 5, 1)], times=[0])})]
    )
    flight = sky.fly_replanned(Blind(mission), truth, SENSOR, rng=4)
    assert [one.fault for one in flight.violations] == [sky.Fault.MOVER]
    assert "uav-1 touches mover 'cart'" in flight.violations[0].message
    assert flight.nearest.distance == pytest.approx(-0.4, abs=0.03)
    assert flight.certificate.verdict is sky.Verdict.REFUTED
    assert not flight.safe
    assert flight.sentence == "Not safe: 1 thing went wrong."


def test_a_uav_that_never_arrives_is_not_safe(mission):
    flight = sky.fly_replanned(sky.Replanner(mission), mission.scenario, SENSOR, rng=4, longest=1.0)
    assert flight.arrivals == (None,)
    assert [one.message for one in flight.violations] == ["uav-1 has not arrived when the flight ends at 1.00 s"]


def test_a_seed_gives_the_same_flight_again(mission, flight):
    truth = short_hall(movers=[CROSSING], obstacles=[WALL])
    again = sky.fly_replanned(sky.Replanner(mission), truth, SENSOR, rng=4)
    assert again == flight


def test_another_seed_draws_other_errors(mission):
    truth, sensor = short_hall(movers=[CROSSING]), sky.Sensor(error=0.02)
    flights = [sky.fly_replanned(sky.Replanner(mission), truth, sensor, rng=seed, longest=0.3) for seed in (4, 4, 5)]
    seen = [[step.predictions[0].motion.points[0] for step in one.steps] for one in flights]
    assert seen[0] == seen[1] != seen[2]


def test_a_uav_that_is_blown_off_its_way_goes_on_from_where_it_is(mission):
    gusts = {"conditions": sky.Conditions(wind=(0, 8, 0), gusts=True), "margin": 0.0}
    flight = sky.fly_replanned(sky.Replanner(mission), mission.scenario, SENSOR, **gusts, rng=1, longest=2.0)
    assert any(answer.restarted for step in flight.steps for answer in step.answers)
    assert "Motions began anew from where UAVs were" in flight.proof_sentence


def test_two_uavs_that_exchange_sides_stay_apart():
    uavs = [sky.UAV(name="a", start=(1, 5, 1)), sky.UAV(name="b", start=(9, 5.2, 1))]
    targets = [sky.Target(position=(9, 5, 1)), sky.Target(position=(1, 5.2, 1))]
    scenario = short_hall(uavs=[uav.model_copy(update={"separation": 1.0}) for uav in uavs], targets=targets)
    mission = sky.plan_mission(scenario, assignment="identity")
    flight = sky.fly_replanned(sky.Replanner(mission), scenario, SENSOR, rng=1)
    assert flight.safe, flight.violations
    assert flight.passings[0].nearness > 0.9


def test_a_replanned_flight_comes_back_from_its_file(flight, tmp_path):
    path = tmp_path / "flight.json"
    sky.write(flight, path)
    again = sky.read_flight(path)
    assert isinstance(again, sky.ReplannedFlight)
    assert (again.sensor, again.steps, again.arrivals, again.approaches) == (
        flight.sensor, flight.steps, flight.arrivals, flight.approaches,
    )  # fmt: skip
    assert (again.flown, again.references, again.truth) == (flight.flown, flight.references, flight.truth)
    assert again.sentence == flight.sentence
    assert again.certificate is None
    assert again.proof_sentence.startswith("Not judged")
    assert sky.read_mission(path).trajectories == flight.mission.trajectories


@pytest.mark.parametrize(
    "given",
    [
        {"sensor": sky.Sensor(delay=0.1)},
        {"sensor": sky.Sensor(rate=200)},
        {"sensor": "radar"},
        {"truth": None},
        {"margin": -1},
        {"longest": float("inf")},
        {"conditions": {}},
    ],
)
def test_what_makes_no_sense_is_refused(mission, given, refuses):
    with refuses():
        sky.fly_replanned(sky.Replanner(mission), **{"truth": mission.scenario, "sensor": SENSOR, **given})


def test_a_replanner_that_is_no_longer_new_is_refused(mission, refuses):
    replanner = sky.Replanner(mission)
    replanner.observe(1.0)
    with refuses():
        sky.fly_replanned(replanner, mission.scenario)


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data["arrivals"].clear(),
        lambda data: data["steps"][3].update(movers=[7]),
        lambda data: data["steps"][2].update(obstacles=[-1]),
        lambda data: data["steps"][1]["answers"].clear(),
        lambda data: data.pop("format"),
        lambda data: data.update(sensor={"range": -1}),
    ],
)
def test_a_file_whose_parts_do_not_fit_is_refused(flight, tmp_path, change, refuses):
    path = tmp_path / "flight.json"
    sky.write(flight, path)
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with refuses():
        sky.read_flight(path)
