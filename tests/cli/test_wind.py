"""The wind on the command line: as pilots tell it, refused where nothing flies in it, and flown as planned."""

import json

import pytest

import skyverse as sky


@pytest.mark.parametrize(
    ("options", "wind"),
    [
        (("--wind-speed", "2", "--wind-from", "270", "--gust", "0.5"), sky.Wind(velocity=(2, 0, 0), gust=0.5)),
        (("--wind=0,-1,0",), sky.Wind(velocity=(0, -1, 0))),
        (("--gust", "1"), sky.Wind(velocity=(0, 0, 0), gust=1)),
        (("--wind", "0,0,0"), None),
    ],
)
def test_plan_flies_in_the_wind_that_is_given_and_proves_it(skyverse, tmp_path, options, wind):
    out = tmp_path / "m.json"
    assert skyverse("plan", "map1", "--planner", "taut", "-o", out, *options)[0] == 0
    mission = sky.read_mission(out)
    assert mission.scenario.wind == wind
    assert not mission.violations


def test_the_options_take_the_place_of_the_scenarios_wind(skyverse, tmp_path):
    blown = sky.read_scenario("map1").model_copy(update={"wind": sky.Wind(velocity=(1, 0, 0), gust=0.1)})
    sky.write(blown, tmp_path / "blown.yaml")
    for options, wind in (
        ((), blown.wind),
        (("--gust", "0.4"), sky.Wind(velocity=(1, 0, 0), gust=0.4)),
        (("--wind", "0,2,0"), sky.Wind(velocity=(0, 2, 0))),
    ):
        out = tmp_path / "m.json"
        assert skyverse("plan", tmp_path / "blown.yaml", "--planner", "taut", "-o", out, *options)[0] == 0
        assert sky.read_mission(out).scenario.wind == wind


def test_a_wind_against_which_a_uav_cannot_hold_its_place_is_refused_in_a_sentence(skyverse, tmp_path):
    code, _, err = skyverse("plan", "map1", "-o", tmp_path / "m.json", "--wind-speed", "14", "--wind-from", "270")
    assert code == 2
    said = "--wind: against 14 m/s from 270 degrees, uav-1, whose airspeed is at most 5 m/s, cannot hold its place"
    assert said in err
    assert not (tmp_path / "m.json").exists()


def test_what_a_uav_makes_good_against_a_strong_wind_is_told_and_nothing_against_a_weak_one(skyverse, tmp_path):
    strong, weak = (
        skyverse(
            "plan", "map1", "--planner", "taut", "-o", tmp_path / "m.json", "--wind-from", "270", "--wind-speed", v
        )
        for v in ("4", "1")
    )
    assert "WARNING: against 4 m/s from 270 degrees uav-1 makes 1 m/s good\n" in strong[1]
    assert "m/s good" not in weak[1]


def test_fly_takes_the_wind_that_the_mission_was_planned_for(skyverse, tmp_path):
    out = tmp_path / "m.json"
    skyverse("plan", "map1", "--planner", "taut", "-o", out, "--wind", "0.5,0,0", "--gust", "0.1")
    asked = ("fly", out, "--json")
    assert json.loads(skyverse(*asked)[1])["wind"] == [0.5, 0.0, 0.0]
    assert json.loads(skyverse(*asked, "--wind", "0,0,0")[1])["wind"] == [0.0, 0.0, 0.0]
