"""The verb ``fly`` with ``--replan``: what it prints and writes, and what it refuses."""

import json

import pytest

import skyverse as sky
from replanned import BALL, hall

REFUSED = [
    (["--sensor-range", "3"], "--sensor-range: expected --replan with it, found it alone"),
    (["--truth", "map1"], "--truth: expected --replan with it, found it alone"),
    (["--longest", "9"], "--longest: expected --replan with it, found it alone"),
    (["--replan", "--runs", "3"], "--runs: expected a flight that is not replanned, found --replan with it"),
    (["--replan", "--until-safe"], "--until-safe: expected a flight that is not replanned, found --replan with it"),
    (["--replan", "--mover-kind", "knots"], "--mover-kind: expected --movers with it, found it alone"),
    (["--replan", "--sensor-range", "-1"], "--sensor-range: expected a number above 0, found -1"),
    (["--replan", "--sensor-error", "nan"], "--sensor-error: expected a finite number, found nan"),
    (["--replan", "--sensor-delay", "0.1"], "--sensor-delay: expected less than the replanner's lead, 0.1 s"),
    (["--replan", "--sensor-rate", "500"], "--sensor-rate: expected at most 100 observations a second, found 500"),
    (["--replan", "--lead", "0"], "--lead: expected seconds from 0.001 to 600, found 0.0"),
    (["--replan", "--longest", "-1"], "--longest: expected seconds from 0.001 on, found -1.0"),
    (["--replan", "--truth", "missing.yaml"], "missing.yaml: no such file"),
    (["--replan", "--truth", "other.yaml"], "--truth: names must differ, but 'cart' stands 2 times"),
]


@pytest.fixture(scope="module")
def mission():
    return sky.plan_mission(known())


def known(at=8.0):
    """A hall of ten metres with a mover that the mission knows."""
    scenario = hall(size=(10, 10, 4), targets=[sky.Target(position=(9, 5, 1))])
    cart = sky.Mover(name="cart", shape=BALL, motion=sky.WaypointMotion(points=[(at, 8, 1)], times=[0]))
    return sky.Scenario(**{**dict(scenario), "movers": [cart]})


@pytest.mark.parametrize(("words", "expected"), REFUSED)
def test_what_makes_no_sense_is_refused_with_one_sentence(skyverse, mission, tmp_path, words, expected):
    pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
    sky.write(mission, tmp_path / "hall.json")
    sky.write(known(at=7.0), tmp_path / "other.yaml")
    before = sorted(path.name for path in tmp_path.iterdir())
    code, out, err = skyverse("fly", "hall.json", *words, "-o", "flight.json")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert expected in err
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_a_flight_is_told_and_written(skyverse, mission, tmp_path):
    pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
    sky.write(mission, tmp_path / "hall.json")
    sensor = ("--sensor-range", "5", "--sensor-delay", "0.05", "--sensor-error", "0.02")
    words = ("fly", "hall.json", "--replan", "--movers", "2", *sensor, "--seed", "3")
    code, out, err = skyverse(*words, "-o", "flight.json", "--animation", "page.html")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert "The sensors see what is within 5 m 10 times a second, 0.05 s late, with errors of up to 0.02 m." in lines
    assert any(line.startswith("Safe as flown: every UAV arrived and kept the required 0.1 m") for line in lines)
    assert lines[-2:] == ["flight.json", "page.html"]
    flight = sky.read_flight(tmp_path / "flight.json")
    assert [mover.name for mover in flight.truth.movers] == ["cart", "spinner-1", "spinner-2"]
    assert flight.flight.seed == 3
    code, out, _ = skyverse(*words, "--json")
    told = json.loads(out)
    assert (told["safe"], told["proven"], told["sensor"]["range"]) == (True, True, 5.0)
    assert told["uavs"][0]["arrival"] == flight.arrivals[0]
    assert told["approaches"] == [vars(one) | {"uavs": list(one.uavs)} for one in flight.approaches]


def test_a_flight_that_is_not_safe_has_exit_code_1(skyverse, mission, tmp_path):
    pytest.importorskip("rotorpy", reason='rotorpy is not installed; pip install "skyverse[flight]"')
    sky.write(mission, tmp_path / "hall.json")
    code, out, _ = skyverse("fly", "hall.json", "--replan", "--longest", "0.5")
    assert code == 1
    assert "trajectory ends: uav-1 has not arrived when the flight ends at 0.50 s" in out
    assert out.splitlines()[-1] == "Not safe: 1 thing went wrong."
