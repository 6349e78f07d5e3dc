"""Scenarios with bad points are refused before anything is planned, and the message names all of them at once."""

import json

import numpy as np
import pytest

import skyverse as sky
from skyverse.cli import main
from skyverse.cli.given_scenario import MAX_NAMED_POINTS, refuse_unsafe, with_ends, with_lattice


def with_starts(*starts):
    return sky.read("map1").model_copy(
        update={"uavs": tuple(sky.UAV(name=f"u{number}", start=start) for number, start in enumerate(starts))}
    )


def refusal(scenario):
    with pytest.raises(sky.InputError) as refused:
        refuse_unsafe("mine.yaml", scenario)
    return str(refused.value).splitlines()


def test_all_bad_points_are_named_at_once():
    first, *lines = refusal(with_starts((5, 2.2, 1), (5, -4, 1), (5, 99, 1)))
    assert first == "mine.yaml: 2 starts and targets are not safe:"
    assert lines[0].startswith("  uavs[0].start (u0): expected a safe point, found (5, 2.2, 1), which lies inside obst")
    assert "; the roof is at z = 1.5 m there; the nearest free place is (5, 1.75, 1), 0.45 m away" in lines[0]
    assert lines[1].startswith("  uavs[2].start (u2): expected a safe point, found (5, 99, 1), which lies outside")
    assert len(lines) == 2


def test_one_bad_point_is_one_sentence():
    (line,) = refusal(with_starts((5, 2.2, 1)))
    assert line.startswith("mine.yaml: uavs[0].start (u0): expected a safe point")


def test_of_very_many_bad_points_the_first_are_named():
    lines = refusal(with_starts(*[(5, 2.2, 1)] * (MAX_NAMED_POINTS + 3)))
    assert len(lines) == MAX_NAMED_POINTS + 2
    assert lines[-1] == "  ... and 3 more"


def test_a_scenario_whose_points_are_all_safe_is_not_refused():
    refuse_unsafe("map1", sky.read("map1"))


def test_show_draws_a_scenario_before_it_is_planned(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sky.write(with_starts((5, 2.2, 1)), tmp_path / "mine.yaml")
    for words, page in ((["mine.yaml"], "mine.html"), (["table-4.8"], "out/table-4.8-scenario.html")):
        with pytest.raises(SystemExit) as ended:
            main(["show", *words])
        assert not ended.value.code
        assert capsys.readouterr().out == f"{page}\n"
        assert (tmp_path / page).read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    with pytest.raises(SystemExit):
        main(["show", "mine.yaml", "--figures", "figures"])
    assert capsys.readouterr().out == "figures/scenario.png\n"


def valley():
    """A scenario with an origin, over flat ground at 1500 m, with two UAVs of which one is fast."""
    return sky.Scenario(
        name="valley",
        bounds=sky.Bounds(min=(-500, -500, 0), max=(500, 500, 200)),
        terrain=sky.Terrain(origin=(-500, -500), step=(500, 500), heights=np.zeros((3, 3)), clearance=30),
        clearance=5,
        lattice=sky.Lattice(step=(20, 20, 20)),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(name="a", start=(0, 0, 60), home=-1.0), sky.UAV(name="b", start=(0, 100, 60), max_speed=17)],
        targets=[sky.Target(position=(300, 0, 60))],
        frame=sky.Frame(origin=sky.Origin(latitude=46.8, longitude=9.85, altitude=1500)),
    )


def test_places_in_degrees_replace_uavs_and_targets_which_keep_names_and_limits():
    uavs = ["46.801,9.851,70 m agl", "scout=46.802,9.851,1590 m amsl", "46.799,9.851,40 m agl"]
    changed = with_ends("v", valley(), uavs, ["46.798,9.85,262.467 ft agl"])
    assert [(uav.name, uav.max_speed) for uav in changed.uavs] == [("a", 5.0), ("scout", 17), ("uav-3", 17)]
    assert all(uav.home is None for uav in changed.uavs)
    expected = sky.to_local(valley().frame.origin, [(46.801, 9.851, 1570), (46.802, 9.851, 1590)])
    assert np.array([uav.start for uav in changed.uavs[:2]]) == pytest.approx(expected, abs=0.1)
    (target,) = changed.targets
    assert target.name == "target-1"
    assert target.position[2] == pytest.approx(80, abs=0.01)
    assert with_ends("v", valley(), None, None) == valley()
    local = with_ends("v", valley(), None, ["1,2,60", "x=3,4,60"])
    assert [(one.name, one.position) for one in local.targets] == [("target-1", (1, 2, 60)), ("x", (3, 4, 60))]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("46.9,9.85,60 m agl", "it ends 11 km from latitude 46.9, longitude 9.85; skyverse scenario build --from"),
        ("9.85,46.8,60 m agl", "are latitude and longitude swapped"),
        ("46.8,9.85,60 m home", "expected an altitude as agl or amsl"),
        ("46.8,9.85,60 agl", "expected an altitude in m or ft"),
        ("46.8,9.85", "expected x,y,z in metres"),
    ],
)
def test_places_that_cannot_be_are_refused(text, says):
    with pytest.raises(sky.InputError, match=says):
        with_ends("v", valley(), None, [text])


def test_a_place_in_degrees_needs_an_origin(refuses):
    with refuses():
        with_ends("map1", sky.read("map1"), None, ["46.8,9.85,60 m agl"])


def test_the_lattice_is_as_asked_for_or_fits_below_the_ceiling(refuses):
    low = valley().model_copy(update={"max_height": 70.0})
    assert with_lattice(low, None).lattice.step == (20, 20, 20)
    assert with_lattice(valley().model_copy(update={"max_height": 65.0}), None).lattice.step == (20, 20, 10)
    assert with_lattice(low, "25").lattice.step == (25, 25, 25)
    assert with_lattice(low, "50,50,10").lattice.step == (50, 50, 10)
    for text in ("0", "1,2", "x", "-5", "nan"):
        with refuses():
            with_lattice(low, text)


def test_plan_answers_another_target_without_a_new_scenario(skyverse):
    sky.write(valley(), "valley.yaml")
    words = ["--planner", "taut", "--no-page", "--workers", 2, "-o", "m.json", "--json"]
    code, out, _ = skyverse("plan", "valley.yaml", "--target", "46.802,9.853,60 m agl", *words)
    mission, said = sky.read_mission("m.json"), json.loads(out)
    assert code == 0
    assert len(mission.scenario.targets) == 1
    assert said["closed_ways"] == []
    assert said["uavs"][0]["target"] == "target-1"


def test_where_nobody_flies_nothing_is_said_to_be_proven_apart(skyverse):
    wall = sky.Box(min=(100, -600, -10), max=(120, 600, 300))
    target = [sky.Target(position=(300, 0, 60)), sky.Target(position=(300, 100, 60))]
    sky.write(valley().model_copy(update={"obstacles": (wall,), "targets": tuple(target)}), "shut.yaml")
    code, out, _ = skyverse("plan", "shut.yaml", "--planner", "taut", "--no-page", "--json")
    said = json.loads(out)
    assert (code, said["apart"]) == (1, None)
    (first, second) = said["closed_ways"]
    assert (first["uav"], second["uav"]) == ("a", "b")
    assert first["by"][0] == "the obstacle obstacles[0]"
    assert set(first["options"]) <= {"scenario build --ceiling", "scenario build --margin"}


def test_targets_of_a_file_keep_their_names_and_places(tmp_path, refuses):
    from skyverse.cli.places import written_places

    (tmp_path / "towers.csv").write_text("name,lat,lon,amsl_m\ntower 3,46.81,9.85,60\n=b,46.811,9.85,70\n")
    origin = sky.Origin(latitude=46.81, longitude=9.85, altitude=0.0)
    bounds = sky.Bounds(min=(-500.0, -500.0, 0.0), max=(500.0, 500.0, 200.0))
    changes = {"bounds": bounds, "frame": sky.Frame(origin=origin), "lattice": sky.Lattice(step=(10, 10, 10))}
    flat = sky.read("map1").model_copy(update=changes)
    asked = with_ends("flat", flat, None, [f"{tmp_path}/towers.csv", "0,-50,20"])
    assert [target.name for target in asked.targets[:3]] == ["tower 3", "=b", "target-3"]
    due = sky.to_local(origin, [(46.81, 9.85, 60.0), (46.811, 9.85, 70.0)])
    assert np.array([target.position for target in asked.targets[:2]]) == pytest.approx(due)
    raised = with_ends("flat", flat, None, [f"{tmp_path}/towers.csv,90 m amsl"])
    assert {target.position[2] for target in raised.targets} == {90.0}
    assert written_places("--target", [f"{tmp_path}/towers.csv"])[0] == "tower 3=46.81,9.85,60 m amsl"
    with refuses():
        with_ends("map1", sky.read("map1"), None, [f"{tmp_path}/towers.csv"])
    with refuses():
        with_ends("flat", flat, None, [f"{tmp_path}/none.gpx"])
