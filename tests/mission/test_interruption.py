"""A mission that is interrupted at any look at its stop rule: it ends there, and what it keeps is sound."""

import dataclasses

import pytest

import skyverse as sky
from planned_surveys import planned_survey
from rounds import rounds
from turns import CancelledAtLook

UNJUDGED = {sky.Fault.SEPARATION, sky.Fault.GIVEN, sky.Fault.ASSIGNMENT}
"""What may be wrong with what is kept: conflicts are not resolved yet, nor all UAVs sent somewhere."""


def crossing():
    return sky.circle_swap(2)


def hills():
    return planned_survey("hills").scenario


WORK = {
    "fleet": (crossing, sky.Taut(), {"assignment": "identity"}),
    "apart in space": (crossing, sky.Taut(), {"options": sky.MissionOptions(apart_in_space=True)}),
    "metaheuristic": (crossing, sky.MVO(universes=4), {"stop": sky.MaxIterations(3)}),
    "tours": (lambda: rounds().scenario, sky.Taut(), {}),
    "survey": (hills, sky.Taut(), {}),
}


@pytest.mark.parametrize("kind", WORK)
def test_wherever_a_mission_is_interrupted_it_ends_and_keeps_what_is_sound(kind, tmp_path):
    make, planner, more = WORK[kind]
    scenario, other = make(), more.get("stop")

    def planned(look):
        stop = CancelledAtLook(look)
        options = more | {"stop": stop if other is None else other | stop}
        return sky.plan_mission(scenario, planner, rng=1, workers=1, **options), stop.looks

    whole, looks = planned(None)
    assert whole.apart is not None
    flown = []
    for look in sorted({1, *(int(looks * share) for share in (0.2, 0.4, 0.6, 0.8)), looks}):
        mission, more_looks = planned(look)
        assert mission.interrupted
        assert not mission.complete
        assert mission.apart is None  # nothing is said to be proven
        assert mission.violations == mission.certificates == mission.coverage == ()
        assert {one.fault for one in sky.check(scenario, mission)} <= UNJUDGED
        sky.write(mission, tmp_path / "mission.json")
        assert sky.read_mission(tmp_path / "mission.json").interrupted
        assert more_looks - look <= 100  # what is left to be looked at ends at its first look
        flown.append(sum(one is not None for one in mission.trajectories))
    assert flown[0] == 0
    assert flown[-1] == sum(one is not None for one in whole.trajectories)
    kept = dataclasses.replace(mission, interrupted=False, source=whole.source)
    assert [t and t.end for t in kept.trajectories] == [t and t.end for t in whole.trajectories]


def test_long_work_of_surveys_looks_often():
    """A strip, a photo and a pair of photos take milliseconds each; before each there is a look."""
    stop = CancelledAtLook(None)
    mission = sky.plan_mission(hills(), sky.Taut(), stop=stop, rng=1, workers=1)
    (coverage,) = mission.coverage
    assert stop.looks > 2 * coverage.photos
