"""Zones that open around UAVs that stay, and movers that come to them, later than flights are judged, are told of."""

import json

import numpy as np
import pytest

import skyverse as sky
from skyverse import cli
from skyverse.space.later_cautions import later_cautions

AT_TARGET = {"min": (35, 8, 0), "max": (40, 12, 10)}


def mission(*zones, **more):
    """One UAV that crosses a hall in less than 100 s and hovers where it arrives."""
    return sky.plan_mission(
        sky.Scenario(
            name="hall",
            bounds={"min": (0, 0, 0), "max": (40, 20, 10)},
            clearance=0.5,
            lattice={"step": (1, 1, 1), "connectivity": 26},
            objective={"unit": "metres"},
            zones=zones,
            uavs=[sky.UAV(start=(1, 10, 5)), *more.get("uavs", ())],
            targets=[{"position": (38, 10, 5)}],
        )
    )


def cautions(planned):
    return later_cautions(planned.scenario, planned.trajectories)


def test_a_zone_that_opens_around_a_target_after_the_last_arrival_is_told_of():
    planned = mission(sky.Box(**AT_TARGET, name="airshow", active=[[500, 600], [900, None]]))
    assert planned.violations == ()
    (said,) = cautions(planned)
    assert said.startswith("WARNING: uav-1 stays at its target, inside zone 0 ('airshow', active from 500 s to 600 s")
    assert f"it opens at 500 s, after the last arrival at {sky_seconds(planned.makespan)}." in said


def sky_seconds(seconds):
    return f"{seconds:.2f}".rstrip("0").rstrip(".") + " s"


def test_the_clearance_counts_and_beyond_it_nothing_is_said():
    beside = {"min": (35, 10.4, 0), "max": (40, 12, 10)}
    beyond = {"min": (35, 10.6, 0), "max": (40, 12, 10)}
    planned = mission(sky.Box(**beside, active=[[500, None]]), sky.Box(**beyond, active=[[500, None]]))
    (said,) = cautions(planned)
    assert "zone 0 " in said


@pytest.mark.parametrize(
    "zone",
    [
        sky.Box(**AT_TARGET, max_speed=1.0, active=[[500, None]]),
        sky.Box(min=(15, 0, 0), max=(20, 20, 10), active=[[500, None]]),
    ],
)
def test_limits_of_speed_and_zones_on_the_way_are_not_told_of(zone):
    assert cautions(mission(zone)) == []


def test_a_uav_that_does_not_fly_stays_at_its_start():
    planned = mission(
        sky.Box(min=(0, 0, 0), max=(4, 4, 10), active=[[500, None]]), uavs=[sky.UAV(name="spare", start=(2, 2, 2))]
    )
    (said,) = cautions(planned)
    assert said.startswith("WARNING: spare stays at its start, inside zone 0 ")


def test_plan_check_and_page_tell_of_it_and_until_when_the_proof_holds(tmp_path, capsys):
    planned = mission(sky.Box(**AT_TARGET, name="airshow", active=[[500, None]]))
    (said,) = cautions(planned)
    until = f"{planned.makespan + 1.0:.6g} s"
    file, given = tmp_path / "hall.json", tmp_path / "given.yaml"
    sky.write(planned, file)
    sky.write(planned.scenario, given)

    def printed(*words):
        with pytest.raises(SystemExit) as stopped:
            cli.main([str(word) for word in words])
        assert not stopped.value.code
        return capsys.readouterr().out

    checked = printed("check", file)
    assert said in checked
    assert f"clear of zones that are closed at times also while it waits and stays, until {until}" in checked
    table = printed("plan", given, "-o", tmp_path / "out.json")
    assert said in table
    assert f"within limits, until {sky_seconds(planned.makespan + 1.0)}" in table
    assert json.loads(printed("plan", given, "-o", tmp_path / "out.json", "--json"))["cautions"][0]["sentence"] == said
    page = (tmp_path / "out.html").read_text(encoding="utf-8")
    assert "What a pilot must heed." in page
    assert "WARNING: uav-1 stays at its target, inside zone 0" in page


TRAIN = sky.Box(min=(-3, -1, -2), max=(3, 1, 2))
ON_TIME = [(38, 200, 5), (38, -200, 5)]  # over the target 250 s after it has left, at 1.6 m/s


def crossing(*motions, doubt=None):
    """The hall's UAV, and movers: each of them alone."""
    planned = mission()
    movers = [sky.Mover(shape=TRAIN, motion=motion, doubt=doubt or {}) for motion in motions]
    given = sky.Scenario(**{**dict(planned.scenario), "movers": movers})
    return later_cautions(given, planned.trajectories), planned


def test_a_mover_that_comes_to_a_target_after_the_last_arrival_is_told_of_from_the_first_instant():
    motion = sky.WaypointMotion(points=ON_TIME, times=[100, 350])
    (said,), planned = crossing(motion)
    assert said.startswith("WARNING: uav-1 stays at its target, where mover-1 may come nearer than the clearance; ")
    instants = np.linspace(100, 350, 250_001)
    aside = np.abs(motion.at(instants)[:, 1] - 10.0)
    first = instants[np.argmax(aside < 1.0 + 0.5)]  # half a train and the clearance
    assert f" at {first:.1f} s, after the last arrival at {sky_seconds(planned.makespan)}." in said


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        (sky.WaypointMotion(points=ON_TIME, times=[-300, -50]), False),  # long gone
        (sky.WaypointMotion(points=[(38, -200, 5), (38, 0, 5)], times=[100, 350]), False),  # it stops before
        (sky.WaypointMotion(points=[(38, -200, 5), (38, 11, 5)], times=[100, 350]), True),
        (sky.WaypointMotion(points=ON_TIME, times=[-400, 100], then="returns"), True),
        (sky.WaypointMotion(points=ON_TIME, times=[5000, 5250]), False),  # later than an hour
        (sky.CircularMotion(centre=(38, 110, 5), radius=100, period=1800), True),
        (sky.CircularMotion(centre=(38, 112, 5), radius=100, period=1800), False),
    ],
)
def test_movers_are_followed_for_a_cycle_or_an_hour(motion, told):
    said, _ = crossing(motion)
    assert len(said) == told


def test_a_doubt_that_grows_reaches_a_uav_that_stays():
    still = sky.WaypointMotion(points=[(38, 30, 5)], times=[0])
    (said,), _ = crossing(still, doubt={"growth": 0.1})
    assert " it first may at 185" in said  # 20 m, less half a train and the clearance, at 0.1 m/s
    assert crossing(still)[0] == []


def test_of_many_movers_the_first_are_told_of_and_the_others_counted():
    motions = [sky.WaypointMotion(points=ON_TIME, times=[100 + 10 * k, 350 + 10 * k]) for k in range(9)]
    said, _ = crossing(*motions)
    assert [one.split("where ")[1].split()[0] for one in said[:6]] == [f"mover-{k}" for k in range(1, 7)]
    assert said[6:] == ["WARNING: 3 more movers may come too near to UAVs that stay, after the last arrival."]


def test_a_scenario_that_does_not_change_with_time_is_proven_without_an_end(tmp_path):
    planned = mission()
    assert cautions(planned) == []
    assert "until" not in planned.certificates[0].sentence
