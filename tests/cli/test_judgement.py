"""What a mission file claims is not believed: `export` refuses what the referee refutes, and `fly` tells it first."""

import json

import pytest

import skyverse as sky
from skyverse import cli


@pytest.fixture
def skyverse(monkeypatch, capsys, tmp_path):
    def run(*words):
        with pytest.raises(SystemExit) as stopped:
            cli.main([str(word) for word in words])
        said = capsys.readouterr()
        return stopped.value.code or 0, said.out, said.err

    monkeypatch.chdir(tmp_path)
    return run


@pytest.fixture(scope="module")
def mission():
    return sky.plan_mission(sky.read_scenario("map1"), sky.Taut(), rng=1)


@pytest.fixture
def data(mission, tmp_path):
    """The mission's file as data."""
    sky.write(mission, tmp_path / "map1.json")
    return json.loads((tmp_path / "map1.json").read_text())


@pytest.fixture
def refuted(data, tmp_path):
    """The mission with a trajectory that jumps by a metre."""
    data["trajectories"][0]["coefficients"][0][0][2] += 1.0
    (tmp_path / "refuted.json").write_text(json.dumps(data))
    return "refuted.json"


@pytest.fixture
def altered(data, tmp_path):
    """The mission in a world that it does not have to answer: with less clearance, in which it is as proven as ever."""
    data["scenario"]["clearance"] = 0.2
    (tmp_path / "altered.json").write_text(json.dumps(data))
    return "altered.json"


@pytest.mark.parametrize("suffix", ["csv", "waypoints.csv", "json", "trajectory.json", "path.yaml", "skybrush.zip"])
def test_a_refuted_mission_is_not_exported(skyverse, refuted, tmp_path, suffix):
    code, out, err = skyverse("export", refuted, f"out/m.{suffix}")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"skyverse: out/m.{suffix}: the referee refutes this mission: uav-1")
    assert "skyverse check" in err
    assert [path.name for path in tmp_path.rglob("m.*")] == []


def test_a_mission_in_an_altered_world_is_exported_only_if_nobody_names_the_right_one(skyverse, altered, tmp_path):
    code, out, err = skyverse("export", altered, "m.csv", "--scenario", "map1")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "clearance is 0.2 in the mission, not 0.25" in err
    assert not (tmp_path / "m.csv").exists()
    code, out, err = skyverse("export", altered, "m.csv")
    assert (code, out) == (0, "m.csv\n")
    assert "as the mission embeds it; --scenario tells its source.\n" in err
    code, _, err = skyverse("export", "map1.json", "m.csv", "--scenario", "map1")
    assert code == 0
    assert err.endswith(", from map1.\n")


def test_a_refuted_mission_is_flown_but_that_is_told_first(skyverse, refuted):
    pytest.importorskip("rotorpy", reason="the extra flight is not installed")
    code, out, err = skyverse("fly", refuted, "--seed", 1)
    assert code in (0, 1)
    assert "Simulated: thesis" in out
    assert err.startswith("The referee refutes this mission, which is flown all the same: uav-1")
    assert "skyverse check refuted.json" in err


def test_a_mission_in_an_altered_world_is_not_flown_as_if_it_were_the_right_one(skyverse, altered):
    code, out, err = skyverse("fly", altered, "--scenario", "map1")
    assert (code, out) == (2, "")
    assert "clearance is 0.2 in the mission, not 0.25" in err


def test_flights_of_a_proven_mission_say_nothing_more(skyverse, data):
    pytest.importorskip("rotorpy", reason="the extra flight is not installed")
    assert "referee" not in skyverse("fly", "map1.json", "--seed", 1)[2]


def test_a_flight_tells_its_seed_only_where_something_is_drawn(skyverse, data):
    pytest.importorskip("rotorpy", reason="the extra flight is not installed")
    assert "no wind, no noise\n" in skyverse("fly", "map1.json")[1]
    assert "no wind, noise 0.001 m, seed 7\n" in skyverse("fly", "map1.json", "--noise", 0.001, "--seed", 7)[1]
    once = skyverse("fly", "map1.json", "--wind", "0.5,0,0", "--runs", 1)[1]
    assert "; wind 0.5, 0, 0 m/s (0.5 m/s from 270°), no noise; 1 run\n" in once


def test_check_prints_what_is_proven_of_each_flight_and_of_the_fleet(skyverse, data, tmp_path):
    code, out, _ = skyverse("check", "map1.json")
    assert code == 0
    (proven,) = [line for line in out.splitlines() if line.startswith("proven: ")]
    assert proven.startswith(
        "proven: uav-1 is clear of every obstacle by 0.25 m, inside the bounds and within its limits"
    )
    data["certificates"] = [{"verdict": "proven", "sentence": "uav-1 is clear of every obstacle by 50 m."}]
    (tmp_path / "forged.json").write_text(json.dumps(data))
    assert "by 50 m" not in skyverse("check", "forged.json")[1]
    two = sky.Scenario(
        name="two",
        bounds=sky.Bounds(min=(0, 0, 0), max=(9, 9, 9)),
        clearance=0.2,
        lattice=sky.Lattice(step=(1, 1, 1)),
        uavs=(sky.UAV(start=(1, 1, 1), separation=0.5), sky.UAV(start=(1, 5, 1), separation=0.5)),
        targets=(sky.Target(position=(5, 1, 1)), sky.Target(position=(5, 5, 1))),
    )
    sky.write(sky.plan_mission(two, sky.Taut()), tmp_path / "two.json")
    sentences = [line for line in skyverse("check", "two.json")[1].splitlines() if line.startswith("proven: ")]
    assert len(sentences) == 3
    assert "All 2 UAVs keep their separation" in sentences[2]
