"""The verb ``fly``: what it prints and writes of one flight, and of many."""

import json

import pytest

import skyverse as sky
from handmade import mission, straight

pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')

FLIGHTS = straight((0, 0, 2), (0.5, 0, 2), 0.7), straight((0, 2, 2), (0.5, 3, 2), 0.9)
PAIR = mission(*FLIGHTS, boxes=[((3, -2, 0), (4, 2, 3))])


@pytest.fixture
def pair(tmp_path):
    sky.write(PAIR, tmp_path / "pair.json")
    return "pair.json"


def test_one_flight_is_told_and_written(skyverse, pair, tmp_path):
    pytest.importorskip("imageio_ffmpeg", reason='pip install "skyverse[flight]"')
    files = "-o", "flight.json", "--animation", "a.html", "--figures", "pictures"
    code, out, err = skyverse("fly", pair, "--wind", "1,0,0", "--seed", "3", "-j", "1", *files)
    assert code == 0, err
    assert "uav-2" in out
    assert "m to every obstacle was left, no UAV strayed" in out.partition("Safe: at least ")[2]
    assert sky.read_flight(tmp_path / "flight.json").conditions.wind == (1, 0, 0)
    assert "Tracking error" in (tmp_path / "a.html").read_text()
    figures = {path.name: path.read_bytes() for path in (tmp_path / "pictures").iterdir()}
    assert set(figures) == {"flown-initial.png", "flown-middle.png", "flown-final.png"}
    assert len(set(figures.values())) == 3
    assert set(out.splitlines()[-5:]) == {"flight.json", "a.html", *(f"pictures/{name}" for name in figures)}


def test_what_is_not_safe_ends_with_1_also_as_json(skyverse, tmp_path):
    sky.write(mission(straight((0, 0, 2), (0.4, 0, 2), 0.6), boxes=[((0.2, -1, 0), (0.3, 1, 3))]), tmp_path / "m.json")
    code, out, _ = skyverse("fly", "m.json", "--json", "-j", "1")
    told = json.loads(out)
    assert (code, told["safe"], told["violations"][0]["fault"]) == (1, False, "trajectory too close")
    assert told["uavs"][0]["clearance"] < 0


def test_many_flights_are_told(skyverse, pair):
    wind = ("--wind-speed", "8", "--wind-from", "270", "--gusts", "--mismatch", "20%", "--seed", "5")
    code, out, _ = skyverse("fly", pair, "--runs", "4", *wind, "-o", "flown.json")
    assert code == 0
    assert "horizontal: median" in out
    assert "Safe: nothing was touched in any of 4 runs" in out
    assert "mismatch of 20%" in out
    assert sky.read_mission("flown.json") == PAIR
    data = json.loads(skyverse("fly", pair, "--runs", "4", *wind, "--json")[1])
    again = sky.fly(PAIR, sky.Conditions(wind=sky.wind_from(8, 270), gusts=True, mismatch=0.2), runs=4, rng=5)
    assert (data["safe"], data["wind"], data["runs_within_tracking_error"]) == (True, [8, 0, 0], None)
    assert data["separation"] == again.separation.min()
    assert data["all"]["horizontal"]["largest"] == again.all_errors.horizontal.largest


@pytest.mark.parametrize("words", [(), ("--runs", "2"), ("--replan",)])
@pytest.mark.parametrize("margin", [0.5, 0.0])
def test_of_a_stand_in_it_says_neither_safe_nor_unsafe(skyverse, tmp_path, words, margin):
    uav, target = sky.UAV(start=(30, 10, 8), vehicle="heavy", max_speed=4.0), sky.Target(position=(5, 10, 8))
    bounds, lattice = sky.Bounds(min=(0, 0, 0), max=(60, 20, 20)), sky.Lattice(step=(2, 2, 2))
    slow = sky.Scenario(
        name="field",
        bounds=bounds,
        clearance=1.0,
        lattice=lattice,
        objective=sky.Objective(unit="metres"),
        uavs=[uav],
        targets=[target],
    )
    sky.write(sky.plan_mission(slow, sky.Taut()), tmp_path / "slow.json")
    strict = () if "--runs" in words else ("--margin", str(margin))  # with a margin of 0 something goes wrong
    told = []
    for form in ((), ("--json",)):
        code, out, _ = skyverse("fly", "slow.json", "--wind", "1,0,0", *words, *strict, *form)
        assert code == 3
        told.append(out)
    found = json.loads(told[1])
    assert (found["safe"], found["verdict"][:10]) == (None, "No verdict")
    wrong = [one["message"] for one in found.get("violations", ())]
    lines = [line for line in told[0].splitlines() if any(message in line for message in wrong)]
    assert all(line.startswith("thesis alone: ") for line in lines)
    assert bool(lines) == bool(wrong)
