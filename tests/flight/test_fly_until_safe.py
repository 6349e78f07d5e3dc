import numpy as np
import pytest

import skyverse as sky
from handmade import mission, straight
from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.flight import farther, slowed

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

BRISK = straight((0, 0, 2), (2, 0, 2), 1.6)
THROUGH = mission(straight((0, 0, 2), (1.2, 0, 2), 1.2), boxes=[((0.5, -0.2, 0), (0.7, 0.2, 3))])
LONGER = mission(straight((-1, 0, 2), (2.2, 0, 2), 2.0), boxes=[((0.5, -0.2, 0), (0.7, 0.2, 3))])


@pytest.mark.parametrize("factor", [1.25, 3.0])
def test_a_slowed_mission_is_at_the_same_places_later(factor):
    late = straight((0, 3, 2), (1, 4, 3), 2.0, begin=0.7)
    before = mission(BRISK, late, None)
    after = slowed(before, factor)
    assert after.trajectories[2] is None
    for old, new in zip(before.trajectories[:2], after.trajectories[:2], strict=True):
        t = np.linspace(-0.5, 3.0, 50)
        was, now = old.at(t), new.at(t * factor)
        assert now.position == pytest.approx(was.position)
        assert now.velocity == pytest.approx(was.velocity / factor)
        assert now.acceleration == pytest.approx(was.acceleration / factor**2)
        assert "Slowed down" in new.note
    assert after.makespan == pytest.approx(before.makespan * factor)


@pytest.mark.parametrize("runs", [None, 3])
def test_a_mission_that_flies_safely_is_left_alone(runs):
    flight = sky.fly_until_safe(mission(BRISK), runs=runs, rng=1)
    assert flight.safe
    assert flight.rounds == ()
    assert flight.mission == mission(BRISK)


def test_it_slows_down_until_it_is_safe():
    hasty = mission(BRISK, boxes=[((2.2505, -1, 0), (3, 1, 3))])
    flight = sky.fly_until_safe(hasty, margin=0.001, rounds=6)
    told = flight.rounds
    assert told[0].startswith("Round 1: slowed down to 80% of its speed; ")
    assert flight.safe
    assert told[-1].endswith("; safe.")
    assert flight.mission.makespan > hasty.makespan


def test_it_says_so_when_it_did_not_end_safe():
    flight = sky.fly_until_safe(THROUGH, margin=0.0, rounds=1)
    assert not flight.safe
    assert len(flight.rounds) == 1
    assert "; uav-1 touches an obstacle" in flight.rounds[0]
    assert flight.sentence == flight.refusal
    assert flight.refusal.startswith("Refused: by hand at 80% of its speed is too tight for no wind, no noise: ")


@pytest.mark.parametrize(
    ("given", "runs", "share"), [(THROUGH, None, "80%"), (LONGER, 12, "67%")], ids=["one flight", "many"]
)
def test_what_slowing_does_not_mend_is_planned_farther_off(given, runs, share):
    flown = sky.fly_until_safe(given, runs=runs, rng=1)
    assert flown.safe
    assert flown.refusal == ""
    assert f"slowed down to {share} of its speed" in flown.rounds[0]
    assert "planned anew with" in flown.rounds[-1]
    assert flown.rounds[-1].endswith("; safe.")
    assert flown.mission.scenario == given.scenario
    if runs is None:
        assert flown.flown[0].clearance > 0.125
    else:
        assert flown.runs == runs


def test_planning_anew_keeps_the_assignment_and_answers_the_same_scenario():
    swapped = mission(straight((0, 0, 2), (2, 0, 2), 2.0), straight((0, 3, 2), (2, 3, 2), 2.0))
    crossed = sky.Mission(**{**vars(swapped), "assignment": (1, 0)})
    anew = farther(crossed, 0.3)
    assert anew.assignment == (1, 0)
    assert anew.trajectories[0].at(99.0).position[0] == pytest.approx([2, 3, 2])
    assert anew.scenario == crossed.scenario
    assert not [v for v in anew.violations if v.fault is not sky.Fault.SEPARATION]


def test_planning_anew_heeds_all_that_the_scenario_prices():
    """The straight line leads through 10 m of a zone in which a metre costs as much as 51 elsewhere."""
    scenario = sky.Scenario(
        name="a risk on the way",
        bounds=sky.Bounds(min=(0, 0, 0), max=(40, 30, 8)),
        zones=[sky.Box(min=(15, 10, 0), max=(25, 20, 8), risk=50.0)],
        clearance=0.1,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(2, 15, 2))],
        targets=[sky.Target(position=(38, 15, 2))],
    )
    anew = farther(sky.plan_mission(scenario, rng=1), 0.3)
    assert anew.results[0].terms["risk"] < 1.0
    assert anew.cost < 40.0


def test_planning_anew_keeps_paths_apart_in_space():
    ends = [((20, 0.6, 0.2), (20, 7.4, 0.2)), ((1, 4, 0.2), (39, 4, 0.2))]
    scenario = sky.Scenario(
        name="a crossing",
        bounds=sky.Bounds(min=(0, 0, 0), max=(40, 8, 8)),
        clearance=0.1,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=start, separation=1.0, home=-5.0) for start, _ in ends],
        targets=[sky.Target(position=end) for _, end in ends],
    )
    for in_space in (True, False):
        planned = sky.plan_mission(
            scenario, sky.Taut(), options=sky.MissionOptions(apart_in_space=in_space), rng=1, assignment="identity"
        )
        assert (not apart_by_timing_only(planned)) == in_space
        anew = farther(planned, 0.05, 0.1)
        assert anew.violations == ()
        assert (not apart_by_timing_only(anew)) == in_space


def test_uavs_that_are_planned_too_close_are_not_slowed_in_vain():
    flights = straight((0, 0, 2), (0.6, 0, 2), 0.8), straight((0.6, 0.1, 2), (0, 0.1, 2), 0.8)
    flight = sky.fly_until_safe(mission(*flights))
    assert not flight.safe
    assert flight.rounds == ()
    assert "uav-1 and uav-2 are planned too close, which no slower flight mends" in flight.refusal


def test_uavs_given_too_close_are_slowed_where_they_keep_apart_as_planned():
    flights = straight((0, 0, 2), (1, 0, 2), 1.0), straight((0.2, 0, 2), (1.2, 0, 2), 1.0)
    flight = sky.fly_until_safe(
        mission(*flights), sky.Conditions(wind=(3, 0, 0), noise=0.03), rng=1, margin=0.0, rounds=1
    )
    assert not flight.safe
    assert flight.rounds[0].startswith("Round 1: slowed down to 80% of its speed; ")
