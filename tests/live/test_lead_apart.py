"""UAVs that keep each other from going on, off the mission that would have led them past each other."""

import subprocess
import sys
import threading
from dataclasses import replace
from textwrap import dedent

import numpy as np
import pytest

import skyverse as sky
from patience import PATIENCE_S
from skyverse.live import lead_apart

MEETING = (3, 4, 6, 8)
"""Of the UAVs of a maze, some from either hall, which meet in a passage and then waited there for ever."""
GUST = np.array((0.0, 0.0, 0.05))
"""Metres by which all of them are moved at the beginning, so that they leave the mission's flights."""
LONGEST = 350
"""Observations, ten a second, in which they arrive."""


@pytest.fixture(scope="module")
def mission():
    maze = sky.random_maze(10, seed=0)
    uavs = [sky.UAV(name=f"uav-{k}", start=maze.uavs[k].start, max_speed=1.0, separation=0.4) for k in MEETING]
    fields = {"uavs": uavs, "targets": [maze.targets[k] for k in MEETING]}
    planned = sky.plan_mission(sky.Scenario(**{**dict(maze), **fields}), assignment="identity")
    assert not planned.violations
    return planned


def observations(replanner, **more):
    """Observe until all have arrived, and yield the answers."""
    uavs = range(len(MEETING))
    for k in range(1, LONGEST):
        gust = {uav: (replanner.mission.scenario.uavs[uav].start + GUST, np.zeros(3)) for uav in uavs}
        yield replanner.observe(k / 10, states=gust if k == 1 else None, **more)
        if all((replanner.arrival(uav) or np.inf) <= replanner.now for uav in uavs):
            return


def require_arrived(replanner, answers):
    """Require that all have arrived, that each answer was proven, and that they kept apart."""
    mission, uavs = replanner.mission, range(len(MEETING))
    assert all((replanner.arrival(uav) or np.inf) <= replanner.now for uav in uavs)
    assert all(answer.proven for answer in answers)
    flown = tuple(replanner.flown(uav) for uav in uavs)
    assert sky.certify(mission.scenario, replace(mission, trajectories=flown)).apart.verdict is sky.Verdict.PROVEN


def test_uavs_that_meet_in_a_passage_are_led_apart(mission):
    replanner = sky.Replanner(mission)
    answers = [answer for told in observations(replanner) for answer in told]
    require_arrived(replanner, answers)


def test_no_answer_with_a_deadline_waits_for_the_mission_that_leads_them_apart(mission, monkeypatch):
    begun, go_on, plan, ended = threading.Event(), threading.Event(), lead_apart.plan_mission, []

    def plan_when_told(*given, **more):
        ended.append(threading.Event())
        begun.set()
        try:
            assert go_on.wait(PATIENCE_S)
            return plan(*given, **more)
        finally:
            ended[-1].set()

    monkeypatch.setattr(lead_apart, "plan_mission", plan_when_told)
    replanner, answers, waited = sky.Replanner(mission), [], 0.0
    for told in observations(replanner, deadline_ms=1e6):
        answers += told
        if begun.is_set() and not go_on.is_set():
            waited = waited or replanner.now
            assert all(answer.kept for answer in told) or replanner.now < waited + 0.2
            if replanner.now > waited + 2.0 * lead_apart.PLANNED_IN:
                go_on.set()
        # the clock of the flight waits for the thread, which a busy machine may keep long
        assert not go_on.is_set() or all(one.wait(PATIENCE_S) for one in ended)
    assert go_on.is_set()
    require_arrived(replanner, answers)


def corridor_mission():
    """A mission in whose corridor a UAV that has arrived stands in the way of another one."""
    z, walls = 0.25, [((2, 0, 0), (6, 1.75, 0.5)), ((2, 2.25, 0), (12, 4, 0.5)), ((7, 0, 0), (12, 1.75, 0.5))]
    places = [(4, 2, z), (1, 2, z)]
    corridor = sky.Scenario(
        name="corridor",
        bounds=sky.Bounds(min=(0, 0, 0), max=(14, 4, 0.5)),
        obstacles=[sky.Box(min=low, max=high) for low, high in walls],
        clearance=0.1,
        lattice=sky.Lattice(step=(0.25, 0.25, 0.25), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=place, max_speed=1.0, separation=0.4) for place in places],
        targets=[sky.Target(position=(4, 2, z)), sky.Target(position=(13, 2, z))],
    )
    return sky.plan_mission(corridor, assignment="identity", options=sky.MissionOptions(keep_apart=False))


def test_a_uav_that_has_arrived_in_a_corridor_makes_way_and_returns():
    replanner = sky.Replanner(corridor_mission())
    for k in range(1, 300):
        assert all(answer.proven for answer in replanner.observe(k / 10))
        if (replanner.arrival(1) or np.inf) <= replanner.now:
            break
    assert all((replanner.arrival(uav) or np.inf) <= replanner.now for uav in (0, 1))
    flown = tuple(replanner.flown(uav) for uav in (0, 1))
    away = np.linalg.norm(flown[0].at(np.arange(0.0, flown[0].end, 0.1)).position - flown[0].at([0.0]).position, axis=1)
    assert away.max() > 2.0  # metres: the way to the only recess
    assert (
        sky.certify(replanner.scenario, replace(replanner.mission, trajectories=flown)).apart.verdict
        is sky.Verdict.PROVEN
    )


@pytest.mark.parametrize("error", [ZeroDivisionError("by nobody"), sky.InputError("no such mission")])
def test_a_mission_that_cannot_be_planned_ends_no_flight(monkeypatch, error):
    def fail(*_, **__):
        asked.append(error)
        raise error

    asked, told = [], []
    replanner = sky.Replanner(corridor_mission())
    monkeypatch.setattr(lead_apart, "plan_mission", fail)
    monkeypatch.setattr(threading, "excepthook", lambda said: told.append(said.exc_value))
    for k in range(1, 250):
        assert all(answer.proven for answer in replanner.observe(k / 10))
    assert len(asked) > 1  # and is asked for again
    assert told == ([] if isinstance(error, sky.InputError) else asked)


def test_a_flight_ends_while_a_mission_is_planned(tmp_path):
    sky.write(corridor_mission(), tmp_path / "mission.json")
    code = """
        import sys, threading
        import skyverse as sky
        from skyverse.live import lead_apart
        begun = threading.Event()
        lead_apart.plan_mission = lambda *_, **__: begun.set() or threading.Event().wait()
        replanner = sky.Replanner(sky.read_mission(sys.argv[1]))
        for k in range(1, 250):
            replanner.observe(k / 10, deadline_ms=1e6)
        print(begun.is_set())
    """
    words = [sys.executable, "-c", dedent(code), tmp_path / "mission.json"]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE_S)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "True\n", "")
