"""Tables for Litchi, read back by litchi-wp, which others wrote."""

import csv
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest
from exported_fleets import ORIGIN

import skyverse as sky
from speed_zones import world_of

PLACE = (10.0, 40.0, 5.0)


def flown(*targets, **uav):
    """A mission from a start 12 m above the ground."""
    uav = sky.UAV(start=(-60, 0, 12), home=0, **uav)
    targets = [sky.Target(position=position) for position in targets or [(60, 30, 20)]]
    scenario = world_of(uavs=(uav,), targets=tuple(targets), frame=sky.Frame(origin=ORIGIN))
    return sky.plan_mission(scenario, sky.Taut())


def rows_of(file):
    with file.open(newline="") as stream:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(stream)]


@pytest.mark.usefixtures("unjudged")
@pytest.mark.parametrize("above", ["home", "agl"])
def test_an_independent_reader_finds_the_same_places_speeds_and_stops(tmp_path, above):
    litchi = pytest.importorskip("litchi_wp.waypoint", reason="reads .litchi.csv")
    pytest.importorskip("pyproj", reason="an independent geodesy")
    waited = told = 0
    for seed in range(12):
        mission = handmade.random_mission(seed, terrain=above == "agl")
        if mission.scenario.uavs[0].fixed_wing is not None:
            continue
        routes = sky.routes(mission, altitude=above, takeoff=1.2, stops=True)  # DJI's least rise
        files = sky.export(mission, tmp_path / f"m{seed}.litchi.csv", sky.ExportOptions(altitude=above))
        for route, file in zip(routes, files, strict=True):
            ground = route.waypoints[0, 2] - 1.2
            if above == "agl":
                ground = handmade.under(mission.scenario, route.waypoints)
            heights = route.waypoints[:, 2] - ground
            assert [row["altitude(m)"] for row in rows_of(file)] == pytest.approx(heights, abs=0.02)
            if heights.min() < 0:
                continue  # lower than the take-off, which litchi-wp does not read
            assert file.read_text().splitlines()[0] == litchi.Waypoint.get_header("")
            points = [litchi.Waypoint.from_line(line) for line in file.read_text().splitlines()[1:]]
            places = np.array([(p.lat, p.lon, p.altitude.value) for p in points]).T
            off = handmade.local(mission.scenario.frame.origin, *places) - route.waypoints
            assert np.abs(off[:, :2]).max() < 0.01
            assert {p.altitude.mode.value for p in points} == {0 if above == "home" else 1}
            assert {p.curvesize for p in points} == {0}
            assert all(0 < p.speed <= 15 for p in points)
            stays = [[a.param for a in p.actions if a.type.value == 0] for p in points]
            assert not any(stays[1:])
            waited += sum(stays[0]) > 0
            told += len(points)
    assert waited
    assert told > 10


def test_noses_point_along_legs_at_a_place_or_one_way(tmp_path):
    options = sky.ExportOptions(altitude="home")
    told = {}
    for name, uav in {"course": {}, "place": {"look_at": PLACE}, "fixed": {"heading": 225.5}}.items():
        (file,) = sky.export(flown(**uav), tmp_path / f"{name}.litchi.csv", options)
        told[name] = rows_of(file)
    assert [row["heading(deg)"] for row in told["fixed"]] == [225.5] * len(told["fixed"])
    assert told["course"][-1]["heading(deg)"] == pytest.approx(np.degrees(np.arctan2(120, 30)), abs=0.5)
    last = told["place"][-1]
    assert last["heading(deg)"] == pytest.approx(360 - np.degrees(np.arctan2(50, 10)), abs=0.5)
    assert {row["gimbalmode"] for row in told["place"]} == {1}
    assert {row["gimbalmode"] for row in told["course"] + told["fixed"]} == {0}
    seen = [[last["poi_latitude"]], [last["poi_longitude"]], [0.0]]
    np.testing.assert_allclose(handmade.local(ORIGIN, *seen)[0][:2], PLACE[:2], atol=0.02)
    assert last["poi_altitude(m)"] == 5
    assert last["poi_altitudemode"] == 0


def test_what_a_table_cannot_say_is_told(tmp_path):
    for end, action in (("loiter", "None"), ("land", "Land"), ("rtl", "RTH")):
        notes = []
        sky.export(
            flown(), tmp_path / "m.litchi.csv", sky.ExportOptions(altitude="home", end=end), on_note=notes.append
        )
        (said,) = [note for note in notes if "set in Litchi" in note]
        assert said.startswith("BEFORE")
        assert f"finish action {action} " in said
        assert "Straight Lines" in said
        assert "return height 30 m for uav-1" in said


@pytest.mark.usefixtures("unjudged")
@pytest.mark.parametrize(("begin", "count"), [(0.0, 0), (20.0, 1), (90.0, 3), (300.0, 10)])
def test_a_uav_that_departs_later_stays_at_its_first_waypoint(tmp_path, begin, count):
    mission = flown()
    late = replace(mission, trajectories=(mission.trajectories[0].retimed(begin),))
    options = sky.ExportOptions(altitude="home")
    (row, *others) = rows_of(sky.export(late, tmp_path / "m.litchi.csv", options)[0])
    stays = [row[f"actionparam{k}"] for k in range(1, 16) if row[f"actiontype{k}"] == 0]
    assert len(stays) == count
    assert all(0 < stay <= 32_000 for stay in stays)
    assert sum(stays) == pytest.approx(1000 * max(begin - 6, 0), abs=5_000)  # the climb takes some seconds
    assert not any(row[f"actiontype{k}"] == 0 for row in others for k in range(1, 16))


@pytest.mark.usefixtures("unjudged")
def test_what_dji_aircraft_do_not_take_is_refused(tmp_path, refuses):
    options, file = sky.ExportOptions(altitude="home"), tmp_path / "m.litchi.csv"
    mission = flown()
    late = replace(mission, trajectories=(mission.trajectories[0].retimed(600.0),))
    vast = {"bounds": sky.Bounds(min=(-100, -100, 0), max=(5000, 100, 2000)), "frame": sky.Frame(origin=ORIGIN)}
    for target in ((3000, 0, 20), (0, 0, 900)):
        uav, there = sky.UAV(start=(0, 0, 12), home=0, max_speed=15), sky.Target(position=target)
        scenario = world_of(uavs=(uav,), targets=(there,)).model_copy(update=vast)
        with refuses():
            sky.export(sky.plan_mission(scenario, sky.Taut()), file, options)
    with refuses():
        sky.export(late, file, options)
    assert list(tmp_path.iterdir()) == []


def test_altitudes_above_the_sea_and_other_autopilots_are_refused(tmp_path, refuses):
    with refuses():
        sky.export(flown(), tmp_path / "m.litchi.csv")
    with refuses():
        sky.export(flown(), tmp_path / "m.litchi.csv", sky.ExportOptions(altitude="home", autopilot="px4"))
    assert list(tmp_path.iterdir()) == []
