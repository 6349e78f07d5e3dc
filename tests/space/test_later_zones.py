"""Zones that open around UAVs that stay, later than their flights are judged, are told of."""

import json

import pytest

import skyverse as sky
from skyverse import cli
from skyverse.space.later_zones import later_zone_cautions

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
    return later_zone_cautions(planned.scenario, planned.trajectories)


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
    assert json.loads(printed("plan", given, "-o", tmp_path / "out.json", "--json"))["cautions"] == [said]
    page = (tmp_path / "out.html").read_text(encoding="utf-8")
    assert "Zones open around UAVs after the last arrival." in page
    assert "WARNING: uav-1 stays at its target, inside zone 0" in page


def test_a_scenario_that_does_not_change_with_time_is_proven_without_an_end(tmp_path):
    planned = mission()
    assert cautions(planned) == []
    assert "until" not in planned.certificates[0].sentence
