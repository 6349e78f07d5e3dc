"""A scenario is made of a mission that somebody has, and a plan of it says how much better its way is."""

import json

import pytest

import skyverse as sky

HOME = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)


def place(x, y):
    return sky.to_wgs84(HOME, [[x, y, 0.0]])[0, :2].tolist()


def item(command, numbers):
    params = [0, 0, 0, None, *numbers]
    return {"type": "SimpleItem", "command": command, "frame": 3, "params": params, "autoContinue": True}


def plan(items):
    mission = {"items": items, "version": 2, "hoverSpeed": 5, "plannedHomePosition": [47.0, 8.0, 400.0]}
    return json.dumps({"fileType": "Plan", "version": 1, "mission": mission | {"firmwareType": 12, "vehicleType": 2}})


@pytest.fixture
def detour(tmp_path):
    corners = [(0, 200), (300, 200), (300, 0)]
    items = [item(22, [*place(0, 0), 50]), *(item(16, [*place(*corner), 50]) for corner in corners)]
    path = tmp_path / "detour.plan"
    path.write_text(plan(items), encoding="utf-8")
    return path


def test_area_home_speed_and_both_ends_are_those_of_the_mission(detour, tmp_path, skyverse):
    made = tmp_path / "made.yaml"
    skyverse("scenario", "build", "--mission", detour, "--ground", "400 m amsl", "-o", made)
    scenario = sky.read_scenario(made)
    (uav,), (target,) = scenario.uavs, scenario.targets
    start, end = sky.to_local(HOME, sky.to_wgs84(scenario.frame.origin, [uav.start, target.position]))
    assert start == pytest.approx([0, 0, 50], abs=0.05)
    assert end == pytest.approx([300, 0, 50], abs=0.05)
    assert (uav.name, uav.max_speed) == ("detour", 5)
    (low, high) = scenario.bounds.min, scenario.bounds.max
    assert 500 <= high[0] - low[0] <= 502
    assert 400 <= high[1] - low[1] <= 402
    length, seconds = scenario.sources[-1].flown
    assert length == pytest.approx(700, abs=0.1)
    assert seconds > 700 / 5
    code, out, _ = skyverse("plan", made, "-o", tmp_path / "planned.json")
    assert code == 0
    told = next(line for line in out.splitlines() if line.startswith("detour.plan flies"))
    assert "700 m" in told
    assert "57.1% shorter" in told


def test_building_again_takes_the_mission_again_and_options_go_before_it(detour, tmp_path, skyverse):
    made, again = tmp_path / "made.yaml", tmp_path / "again.yaml"
    skyverse("scenario", "build", "--mission", detour, "--ground", "400 m amsl", "--max-speed", "8", "-o", made)
    skyverse("scenario", "build", "--from", made, "--clearance", "6", "-o", again)
    before, after = sky.read_scenario(made), sky.read_scenario(again)
    assert after.uavs[0].max_speed == 8
    assert after.clearance == 6
    assert after.uavs[0].start == before.uavs[0].start


def test_a_mission_without_a_place_is_refused(tmp_path, refused):
    path = tmp_path / "empty.plan"
    path.write_text(plan([]), encoding="utf-8")
    refused("scenario", "build", "--mission", path, "--ground", "400 m amsl", "-o", tmp_path / "x.yaml")
