"""Mission files: one JSON that reads back equal, and CSV that others can read."""

import csv
import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skyverse as sky
from rounds import rounds
from worlds import ROOM, scenarios


@cache
def room_mission():
    """Three UAVs: one flies, one cannot start, one has no target."""
    scenario = ROOM.model_copy(
        update={
            "uavs": tuple(
                sky.UAV(name=n, start=p) for n, p in [("a", (0.6, 0.7, 1.2)), ('b, "x"', (2.5, 1, 1)), ("c", (1, 4, 1))]
            ),
            "targets": tuple(sky.Target(name=n, position=p) for n, p in [("t", (5.8, 4.3, 3.1)), ("s", (5, 1, 1))]),
        }
    )
    return sky.plan_mission(scenario, sky.MVO(universes=5), stop=sky.MaxIterations(5), rng=4, assignment="identity")


def unjudged(mission):
    """The mission without the referee's certificates, which no file holds."""
    return replace(mission, certificates=(), apart=None)


def test_a_mission_reads_back_equal_but_for_its_certificates(tmp_path):
    mission = room_mission()
    assert len(mission.certificates) == 3
    assert mission.results[0].status.reached
    assert mission.results[1].cost == np.inf
    assert mission.results[2] is None
    sky.write(mission, tmp_path / "m.json")
    again = sky.read(tmp_path / "m.json")
    assert again == unjudged(mission)
    assert sky.read_mission(tmp_path / "m.json") == again
    assert sky.read_scenario(tmp_path / "m.json") == mission.scenario
    assert sky.check(again.scenario, again) == list(mission.violations)
    assert again.results[0].path.dtype == np.float64
    assert not again.results[0].path.flags.writeable
    assert again.assignment == (0, 1, None)


@given(
    st.integers(0, 3).flatmap(lambda u: st.integers(0, 3).flatmap(lambda t: scenarios(uavs=u, targets=t))),
    st.sampled_from([sky.MVO(universes=3), sky.AStar()]),
)
@settings(max_examples=30, suppress_health_check=[*HealthCheck])
def test_every_mission_reads_back_equal(tmp_path, scenario, planner):
    mission = sky.plan_mission(scenario, planner, stop=sky.MaxIterations(2), rng=1)
    sky.write(mission, tmp_path / "m.json")
    assert sky.read(tmp_path / "m.json") == unjudged(mission)
    sky.write(mission, tmp_path / "m.csv")
    sky.write(mission, tmp_path / "m.waypoints.csv")


def test_no_file_makes_a_reader_hand_out_a_certificate(tmp_path):
    sky.write(room_mission(), tmp_path / "m.json")
    data = json.loads((tmp_path / "m.json").read_text())
    assert not {"certificates", "apart"} & data.keys()
    forged = {"verdict": "proven", "sentence": "a is clear of every obstacle by 50 m.", "time": None, "position": None}
    for claims in (
        {"certificates": [forged | {"subdivisions": 0}, None, None], "apart": forged | {"subdivisions": 0}},
        {"certificates": "all is well", "apart": [1, 2]},
    ):
        (tmp_path / "forged.json").write_text(json.dumps({**data, **claims}))
        read = sky.read_mission(tmp_path / "forged.json")
        assert (read.certificates, read.apart) == ((), None)


def test_the_file_is_strict_json_with_format_scenario_and_provenance(tmp_path):
    sky.write(room_mission(), tmp_path / "m.json")

    def forbid(constant):
        raise AssertionError(f"{constant} is no JSON")

    data = json.loads((tmp_path / "m.json").read_text(), parse_constant=forbid)
    assert data["format"] == "skyverse/mission/2"
    assert data["scenario"]["name"] == "room"
    provenance = data["provenance"]
    assert provenance["skyverse"] == sky.__version__
    assert provenance["seed"] == 4
    assert "MVO(" in provenance["planner"]
    assert provenance["stop"] == "MaxIterations(5)"
    assert "Python" in provenance["platform"]


def refused(tmp_path, data, *says):
    path = tmp_path / "bad.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    with pytest.raises(sky.InputError) as error:
        sky.read(path)
    message = str(error.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    for words in says:
        assert words in message, message


def dumped(tmp_path):
    sky.write(room_mission(), tmp_path / "good.json")
    return json.loads((tmp_path / "good.json").read_text())


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (("results",), [], ["results: expected one entry for each UAV, 3 in all, found 0"]),
        (("trajectories",), [None] * 4, ["trajectories: expected one entry for each UAV, 3 in all, found 4"]),
        (("assignment",), [0, 1], ["assignment: expected one entry"]),
        (("assignment", 0), "first", ["assignment[0]", "found 'first'"]),
        (("asignment",), [], ["asignment", "there is no such key"]),
        (("results", 0, "status"), "splendid", ["results[0].status", "found 'splendid'"]),
        (("results", 0, "path"), [[0, 0], [1, 1]], ["results[0].path", "rows of x, y, z"]),
        (("results", 0, "path"), [[0, 0, 0], [1, 1]], ["results[0].path", "rows of equal length"]),
        (("results", 0, "path"), "long", ["results[0].path"]),
        (("results", 0, "cost"), "dear", ["results[0].cost", "found 'dear'"]),
        (("results", 0, "colour"), 1, ["results[0].colour", "there is no such key"]),
        (("results", 0, "history", "evaluations"), [1.5], ["results[0].history.evaluations", "whole numbers"]),
        (("trajectories", 0, "knots"), [{}], ["trajectories[0].knots", "expected numbers"]),
        (("trajectories", 0), 5, ["trajectories[0]", "found 5"]),
        (("scenario", "clearance"), -1, ["scenario.clearance", "found -1"]),
        (("scenario", "uavs", 0, "spead"), 1, ["scenario.uavs[0].spead", "no such key"]),
        (("violations",), [{"fault": "ugly", "uavs": [], "message": ""}], ["violations[0].fault", "found 'ugly'"]),
        (("provenance", "seed"), "x", ["provenance.seed", "found 'x'"]),
        (("provenance",), None, ["provenance"]),
        (("interrupted",), "perhaps", ["interrupted", "found 'perhaps'"]),
        (("interrupted",), "no", ["interrupted", "found 'no'"]),
        (("interrupted",), 0, ["interrupted", "found 0"]),
        (("format",), "skyverse/mission/3", ["format: expected 'skyverse/mission/2', found 'skyverse/mission/3'"]),
    ],
)
def test_a_field_that_is_wrong_is_named(place, value, says, tmp_path):
    data = dumped(tmp_path)
    at = data
    for key in place[:-1]:
        at = at[key]
    at[place[-1]] = value
    refused(tmp_path, data, *says)


@pytest.mark.parametrize("key", ["scenario", "assignment", "results", "trajectories", "violations", "provenance"])
def test_a_part_that_is_missing_is_named(key, tmp_path):
    data = dumped(tmp_path)
    del data[key]
    refused(tmp_path, data, f"{key}: is missing")


def test_a_misspelt_part_is_named_rather_than_the_one_that_it_leaves_missing(tmp_path):
    data = dumped(tmp_path)
    data["asignment"] = data.pop("assignment")
    refused(tmp_path, data, "asignment: there is no such key")


@pytest.mark.parametrize("share", [0.01, 0.3, 0.7, 0.999])
def test_a_truncated_mission_is_refused(share, tmp_path):
    dumped(tmp_path)
    text = (tmp_path / "good.json").read_text().rstrip()
    refused(tmp_path, text[: int(len(text) * share)], "expected JSON, found it cut off")


def test_a_scenario_is_no_mission(tmp_path, refuses):
    with refuses():
        sky.read_mission("map1")


def rows_of(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("rate", [20.0, 7.3, 0.1])
def test_the_trajectories_csv_holds_what_the_trajectories_say(rate, tmp_path):
    mission = room_mission()
    sky.write(mission, tmp_path / "flown.csv", rate=rate)
    rows = rows_of(tmp_path / "flown.csv")
    assert list(rows[0]) == ["uav", "t", "x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az", "yaw", "pitch"]
    assert {row["uav"] for row in rows} == {"a"}
    t = np.array([float(row["t"]) for row in rows])
    trajectory = mission.trajectories[0]
    assert t[0] == trajectory.start
    assert t[-1] == pytest.approx(trajectory.end, rel=1e-8)
    assert (np.diff(t) > 0).all()
    assert np.diff(t).max() <= 1 / rate + 1e-6
    assert len(t) >= (trajectory.end - trajectory.start) * rate
    values = np.array([[float(row[k]) for k in list(row)[2:]] for row in rows])
    heading = trajectory.heading(t)
    np.testing.assert_allclose(values, np.column_stack([*trajectory.at(t), heading.yaw, heading.pitch]), atol=1e-6)


def test_the_waypoints_csv_holds_the_places_between_the_pieces_exactly(tmp_path):
    mission = room_mission()
    sky.write(mission, tmp_path / "way.waypoints.csv")
    rows = rows_of(tmp_path / "way.waypoints.csv")
    assert list(rows[0]) == ["uav", "waypoint", "t", "x", "y", "z"]
    trajectory = mission.trajectories[0]
    assert [int(row["waypoint"]) for row in rows] == list(range(len(trajectory.knots)))
    t = np.array([float(row["t"]) for row in rows])
    np.testing.assert_array_equal(t, trajectory.knots)
    places = np.array([[float(row[k]) for k in "xyz"] for row in rows])
    np.testing.assert_array_equal(places, trajectory.at(t).position)
    np.testing.assert_allclose(places[[0, -1]], [(0.6, 0.7, 1.2), (5.8, 4.3, 3.1)], atol=1e-9)


def test_a_name_with_commas_and_quotes_survives_csv(tmp_path):
    mission = sky.plan_mission(
        ROOM.model_copy(update={"uavs": (sky.UAV(name='a, "b"\nc', start=(0.6, 0.7, 1.2)),)}), sky.AStar()
    )
    sky.write(mission, tmp_path / "a.csv")
    assert {row["uav"] for row in rows_of(tmp_path / "a.csv")} == {'a, "b"\nc'}


def test_a_fleet_that_does_not_fly_makes_a_csv_of_its_head(tmp_path):
    mission = sky.plan_mission(ROOM.model_copy(update={"uavs": ()}), sky.AStar())
    for name in ("a.csv", "a.waypoints.csv"):
        sky.write(mission, tmp_path / name)
        assert rows_of(tmp_path / name) == []
        assert (tmp_path / name).read_text().startswith("uav,")


@pytest.mark.parametrize("rate", [0, -1, np.inf, np.nan])
def test_a_rate_that_cannot_be_is_refused_and_nothing_is_written(rate, tmp_path, refuses):
    with refuses():
        sky.write(room_mission(), tmp_path / "a.csv", rate=rate)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a.yaml", "a.txt", "a", "a.html"])
def test_a_mission_is_written_as_json_or_csv_only(name, tmp_path, refuses):
    with refuses():
        sky.write(room_mission(), tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["m.json", "m.csv", "m.waypoints.csv"])
def test_an_unwritable_output_leaves_nothing_behind(name, tmp_path, refuses):
    with refuses():
        sky.write(room_mission(), tmp_path / "nowhere" / name)
    (tmp_path / name).mkdir()
    with refuses():
        sky.write(room_mission(), tmp_path / name)
    assert [p.name for p in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    ("place", "change", "says"),
    [
        (("results", 0, "cost"), lambda cost: cost - 1, "but its path makes"),
        (("results", 0, "terms", "fuel"), lambda fuel: fuel + 1e-4, "but its path makes"),
        (("results", 0, "bound"), lambda _: 1e6, "that no path can beat"),
        (("results", 0, "history", "cost", 0), lambda _: 0.0, "does not fall"),
        (("results", 1, "cost"), lambda _: 3.0, "there is no path"),
    ],
)
def test_a_file_that_states_other_costs_than_its_paths_have_is_refused(place, change, says, tmp_path):
    data = dumped(tmp_path)
    *keys, last = place
    at = data
    for key in keys:
        at = at[key]
    at[last] = change(at[last])
    refused(tmp_path, data, f"results[{place[1]}]: ", says)


def test_what_a_file_states_of_flights_and_arrivals_is_computed_anew(tmp_path):
    data = dumped(tmp_path)
    data["flights"][0] |= {"length": 1.0, "energy": 5.0, "deviation": 0.0}
    data["deconfliction"] |= {"total_after": 0.5, "makespan_after": 0.1}
    (tmp_path / "other.json").write_text(json.dumps(data))
    assert sky.read(tmp_path / "other.json") == unjudged(room_mission())


def test_a_deconfliction_of_uavs_that_are_not_there_is_refused(tmp_path):
    data = dumped(tmp_path)
    data["deconfliction"]["actions"] = [{"uav": 3, "kind": "delay", "sentence": "It departs later."}]
    refused(tmp_path, data, "deconfliction: expected UAVs numbered 0 to 2, found 3")


@settings(max_examples=20, deadline=None, suppress_health_check=[*HealthCheck])
@given(
    st.integers(1, 30).flatmap(
        lambda degree: st.lists(st.floats(-1e200, 1e200), min_size=3 * degree, max_size=3 * degree)
    )
)
def test_the_figures_of_a_flight_of_any_numbers_are_computed(tmp_path, numbers):
    data = dumped(tmp_path)
    data["trajectories"][0] |= {"knots": [0.0, 7.0], "coefficients": [np.reshape(numbers, (-1, 3)).tolist()]}
    (tmp_path / "wild.json").write_text(json.dumps(data))
    assert len(sky.read(tmp_path / "wild.json").flights) == 3


def test_a_mission_of_tours_reads_back_equal(tmp_path):
    mission = rounds()
    sky.write(mission, tmp_path / "m.json")
    again = sky.read(tmp_path / "m.json")
    assert again == unjudged(mission)
    assert again.sorties == mission.sorties
    assert sky.check(again.scenario, again) == []


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        ("sorties", [[]], "sorties: expected one entry for each UAV, 2 in all, found 1"),
        ("sorties.0.0.visits.0.target", 7, r"sorties\[0\]\[0\].visits\[0\].target: .*found 7"),
        ("sorties.0.0.visits.0.target", 0.5, r"sorties\[0\]\[0\].visits\[0\].target"),
        ("sorties.0.0.visits.0.arrival", "NaN", r"sorties\[0\]\[0\]: expected seconds"),
        ("sorties.0.0.begin", 1e9, r"sorties\[0\]\[0\]: expected seconds"),
        ("sorties.0.0", {"begin": 0}, r"sorties\[0\]\[0\]"),
        ("unvisited.0.target", -1, r"unvisited\[0\].target: .*found -1"),
    ],
)
def test_sorties_that_cannot_be_are_refused_with_their_file_and_field(place, value, says, tmp_path):
    sky.write(rounds(), tmp_path / "m.json")
    data = json.loads((tmp_path / "m.json").read_text())
    *parents, last = [int(one) if one.isdigit() else one for one in place.split(".")]
    part = data
    for one in parents:
        part = part[one]
    part[last] = value
    (tmp_path / "bad.json").write_text(json.dumps(data))
    with pytest.raises(sky.InputError, match=says) as error:
        sky.read(tmp_path / "bad.json")
    assert "bad.json" in str(error.value)
