"""Exports of tours: a file for each sortie, with stays and headings at targets, which reads back as it was planned."""

import dataclasses
import json
from itertools import pairwise

import numpy as np
import pytest

import skyverse as sky
from skyverse.exports import report
from skyverse.exports.autopilots import AUTOPILOTS
from skyverse.exports.fleet_routes import routes
from skyverse.exports.flight_plan import flight_plans, in_turn
from skyverse.exports.flights import flights_of
from skyverse.exports.landing import stands
from skyverse.exports.separation import Apart, fleet_apart
from skyverse.model.power import JOULES_OF_WATT_HOUR
from skyverse.model.quantities import derived
from skyverse.model.vehicle_profiles import VEHICLE_PROFILES
from skyverse.tour_table import numbered_sorties

HOMES = ((4600.0, -150.0), (4650.0, -250.0))
TARGETS = ((3700.0, -500.0), (4100.0, 400.0), (3500.0, 100.0), (5000.0, 500.0))
STAYS = (20.0, 0.0, 15.0, 25.0)
WAYPOINT_SUFFIXES = (".plan", ".waypoints", ".wpml.kmz", ".litchi.csv")


@pytest.fixture(scope="module")
def tour():
    """Return a tour of two UAVs over real ground, of which one needs two batteries."""
    ground = sky.read("jacksboro")

    def above(place, height):
        return (*place, round(float(ground.terrain.height(np.array([place]))[0]) + height, 1))

    limits = {**VEHICLE_PROFILES["m100"].limits, "battery": 70.0}
    scenario = derived(
        ground,
        uavs=tuple(
            sky.UAV(name=f"uav-{k}", start=above(home, 40.0), end="home", swap=60.0, **limits)
            for k, home in enumerate(HOMES, 1)
        ),
        targets=tuple(
            sky.Target(name=f"target-{k}", position=above(place, 45.0), stay=stay, heading=90.0 if k == 2 else None)
            for k, (place, stay) in enumerate(zip(TARGETS, STAYS, strict=True))
        ),
        frame=sky.Frame(origin=ground.frame.origin.model_copy(update={"geoid": -32.0})),
    )
    return sky.plan_mission(scenario)


def exported(tour, folder, suffix):
    """Return the files of an export, the notes, and what is proven."""
    notes, proven = [], []
    options = sky.ExportOptions(altitude="home" if suffix == ".litchi.csv" else "amsl")
    files = sky.export(tour, folder / f"t{suffix}", options, on_note=notes.append, on_certificate=proven.append)
    return files, notes, proven[0]


def flown(tour):
    """Return the flight plans of a tour for PX4, which end at home."""
    made = routes(tour)
    homes = stands(tour.scenario, [one.uav for one in made])
    plans = flight_plans(tour.scenario, made, AUTOPILOTS["px4"], homes)
    return in_turn(tour.scenario, [dataclasses.replace(plan, ending=plan.home[None]) for plan in plans])


@pytest.mark.parametrize("suffix", WAYPOINT_SUFFIXES)
def test_sorties_have_numbered_files_that_visit_and_stay_as_planned_and_are_proven(tour, tmp_path, suffix):
    files, notes, certificate = exported(tour, tmp_path, suffix)
    flights = list(flights_of(tour))
    names = [f"t-uav-{one.uav + 1}{f'-sortie-{one.sortie}' if one.sortie else ''}{suffix}" for one in flights]
    assert [file.name for file in files] == names
    assert sorted(one.sortie for one in flights) == [0, 1, 2]
    assert not any("batteries do not give it" in note for note in notes)
    planned = {(one.uav, one.number): one.battery.left[-1] for one in numbered_sorties(tour)}
    for file, flight, back in zip(files, flights, certificate.returns, strict=True):
        read = sky.read_waypoints(file)
        (checked,) = sky.check_waypoints(
            [read], tour.scenario, sky.FlightSettings(return_altitude=back.altitude)
        ).missions
        places, holds = checked.flown.plan.route.waypoints, checked.flown.plan.route.waypoint_holds
        assert len(flight.stays) == len(tour.sorties[flight.uav][max(flight.sortie - 1, 0)].visits)
        last = 0
        for stay in flight.stays:
            target = tour.scenario.targets[stay.target]
            off = np.linalg.norm(places[last:] - target.position, axis=1)
            last += int(np.argmin(off))
            assert off.min() < 0.1
            assert target.stay <= holds[last] <= stay.departure - stay.arrival + 5.0
        assert np.linalg.norm(places[-1] - tour.scenario.uavs[flight.uav].start) < 0.1
        wrong = {finding.kind.value for finding in checked.findings if finding.wrong}
        name = f"uav-{flight.uav + 1}" + (f" sortie {flight.sortie}" if flight.sortie else "")
        near_home = {"a DJI aircraft this near home returns without a climb"}
        assert wrong <= near_home
        if suffix == ".litchi.csv":  # whose tables do not say that they land
            continue
        if suffix != ".wpml.kmz":  # which flies slower
            assert abs(checked.summary.left - planned[flight.uav, max(flight.sortie, 1)]) < 0.02  # landing and all
        assert any(
            note.startswith(f"{name}: it takes") and f"{checked.summary.left:.1%} of its" in note for note in notes
        )


def test_flights_that_batteries_do_not_give_as_autopilots_fly_them_are_warned_of(tour, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "slow_touch_down", lambda *_: 10.0 * JOULES_OF_WATT_HOUR)
    _, notes, _ = exported(tour, tmp_path, ".plan")
    (low,) = [note for note in notes if "batteries do not give it" in note]
    assert "reserves: uav-1 sortie 1 with " in low
    assert "% left of 20%; plan" in low


def test_flights_whose_batteries_would_be_empty_before_they_land_are_refused(tour, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "slow_touch_down", lambda *_: 1000.0 * JOULES_OF_WATT_HOUR)
    with pytest.raises(sky.InputError, match="batteries are empty before they land: uav-1 sortie 1 with -"):
        exported(tour, tmp_path, ".plan")


def test_the_nose_points_at_a_target_where_that_wants_it(tour, tmp_path):
    (number,) = [k for k, target in enumerate(tour.scenario.targets) if target.heading is not None]
    (flight,) = [one for one in flights_of(tour) if number in [stay.target for stay in one.stays]]
    stem = f"t-uav-{flight.uav + 1}" + (f"-sortie-{flight.sortie}" if flight.sortie else "")
    for suffix in WAYPOINT_SUFFIXES:
        exported(tour, tmp_path, suffix)
    items = json.loads((tmp_path / f"{stem}.plan").read_text())["mission"]["items"]
    aimed = [item["params"] for item in items if item["command"] == 16 and item["params"][3] is not None]
    assert [(row[0] >= 15.0, row[3]) for row in aimed] == [(True, 90.0)]
    rows = [line.split("\t") for line in (tmp_path / f"{stem}.waypoints").read_text().splitlines()[2:]]
    (turn,) = [k for k, row in enumerate(rows) if row[3] == "115"]
    assert float(rows[turn][4]) == 90.0
    assert rows[turn - 1][3] == "178"  # the speed, as Copter forgets a heading that comes first
    assert rows[turn + 1][3] == "16"
    assert float(rows[turn + 1][4]) >= 15.0
    table = [line.split(",") for line in (tmp_path / f"{stem}.litchi.csv").read_text().splitlines()[1:]]
    assert [row[3] for row in table if row[8] == "0"] == ["90"]


def test_a_later_sortie_starts_when_the_one_before_has_landed_and_the_battery_is_changed(tour, tmp_path):
    _, notes, certificate = exported(tour, tmp_path, ".plan")
    plans = flown(tour)
    first, second = (next(plan for plan in plans if plan.route.sortie == k) for k in (1, 2))
    assert first.begin == 0.0
    assert second.begin >= first.predicted().end + tour.scenario.uavs[first.route.uav].swap - 1e-3
    assert np.allclose(first.predicted().at([first.predicted().end]).position[0], second.home)
    told = next(flight for flight in certificate.flights if flight.uav.endswith("sortie 2")).begin
    assert told >= second.begin  # where they settle over home before they land
    assert any("later sorties" in note and f"at t = {told:.4g} s" in note for note in notes)


def test_a_uav_in_two_sorties_is_one_uav_and_others_are_apart_from_each_of_them(tour):
    plans = flown(tour)
    apart = fleet_apart(tour.scenario, plans)
    assert apart.only(Apart.SPACE)
    assert list(apart.pairs) == [(0, 1)]
    whole = [[plan.predicted() for plan in plans if plan.route.uav == uav] for uav in (0, 1)]
    t = np.arange(0.0, max(one.end for each in whole for one in each), 0.5)

    def at(flights):
        place = flights[0].at(t).position
        for later in flights[1:]:
            place[t > later.start] = later.at(t[t > later.start]).position
        return place

    off = at(whole[0]) - at(whole[1])
    assert np.hypot(np.linalg.norm(off[:, :2], axis=1) / 3.0, off[:, 2] / 6.0).min() > 1.0
    (other,) = [plan for plan in plans if not plan.route.sortie]
    (second,) = [k for k, plan in enumerate(plans) if plan.route.sortie == 2]
    uav = plans[second].route.uav
    same = dataclasses.replace(other, route=dataclasses.replace(other.route, uav=uav, sortie=2), begin=900.0)
    meeting = [*plans[:second], same, *plans[second + 1 :]]  # its second sortie from where the other one stands
    assert fleet_apart(tour.scenario, meeting).pairs == {(0, 1): Apart.CLOSE}


def test_maps_and_robots_get_one_track_of_all_sorties(tour, tmp_path):
    for suffix in (".kml", ".gpx", ".geo.csv", ".csv", ".path.json", ".trajectory.json", ".skybrush.zip", ".geojson"):
        assert sky.export(tour, tmp_path / f"t{suffix}")
    found = json.loads((tmp_path / "t.geojson").read_text())["features"]
    paths = [one for one in found if one["properties"]["kind"] == "path"]
    assert [one["properties"]["name"] for one in paths] == ["uav-1", "uav-2"]
    for path, sorties in zip(paths, tour.sorties, strict=True):
        times = np.array(path["properties"]["times"])
        for one, following in pairwise(sorties):
            stood = np.array(path["geometry"]["coordinates"])[(times >= one.end) & (times <= following.begin)]
            assert len(stood) > 100
            assert np.ptp(stood, axis=0).max() < 1e-3


def test_returns_end_each_sortie_where_that_is_asked(tour, tmp_path):
    proven = []
    files = sky.export(tour, tmp_path / "t.plan", sky.ExportOptions(end="rtl"), on_certificate=proven.append)
    assert len(files) == 3
    for file in files:
        assert json.loads(file.read_text())["mission"]["items"][-1]["command"] == 20
    assert [flight.at_end for flight in proven[0].flights] == ["lands at home"] * 3
    second = next(k for k, flight in enumerate(proven[0].flights) if flight.uav.endswith("sortie 2"))
    assert proven[0].returns[second].plan.begin == proven[0].flights[second].begin > 0


def test_a_target_near_the_ground_is_reached_straight_down_and_left_straight_up(tmp_path):
    """Below the clearance and the tracking error, no leg is clear but the vertical one."""
    error = sky.TrackingError(horizontal=1.0, vertical=1.0)
    scenario = sky.Scenario(
        name="low",
        bounds=sky.Bounds(min=(0.0, 0.0, 0.0), max=(200.0, 100.0, 60.0)),
        obstacles=(sky.Box(min=(90.0, 40.0, 0.0), max=(110.0, 60.0, 17.9)),),
        clearance=2.0,
        uavs=(sky.UAV(name="uav-1", start=(20.0, 50.0, 0.0), end="home", max_speed=6.0, tracking_error=error),),
        targets=(
            sky.Target(name="roof", position=(100.0, 50.0, 20.0), stay=5.0),
            sky.Target(name="far", position=(180.0, 60.0, 20.0), look_at=(180.0, 0.0, 0.0)),
        ),
        frame=sky.Frame(origin=sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)),
    )
    mission = sky.plan_mission(scenario)
    (file,) = sky.export(mission, tmp_path / "low.plan")
    (route,) = routes(mission)
    for target in (0, 1):
        (k,) = np.flatnonzero(route.targets == target)
        assert np.allclose(route.points[k], scenario.targets[target].position)
    (k,) = np.flatnonzero(route.targets == 0)
    assert np.abs(route.points[[k - 1, k + 1], :2] - route.points[k, :2]).max() < 1e-9
    assert (route.holds[[k - 1, k, k + 1]] > [0.0, 5.0, 0.0]).all()
    items = json.loads(file.read_text())["mission"]["items"]
    assert [item["params"][3] for item in items if item["command"] == 16 and item["params"][3] is not None] == [180.0]


@pytest.mark.parametrize("suffix", [".plan", ".waypoints", ".litchi.csv"])
def test_targets_at_the_start_and_at_one_place_are_stayed_at_for_as_long_as_they_ask(tmp_path, suffix):
    places = {"here": (20.0, 50.0, 10.0), "x": (100.0, 50.0, 20.0), "y": (100.0, 50.0, 20.0), "z": (300.0, 60.0, 20.0)}
    scenario = sky.Scenario(
        name="coincide",
        bounds=sky.Bounds(min=(0.0, 0.0, 0.0), max=(400.0, 100.0, 60.0)),
        clearance=2.0,
        uavs=(sky.UAV(name="uav-1", start=places["here"], home=0.0, max_speed=6.0),),
        targets=tuple(sky.Target(name=name, position=place, stay=7.0) for name, place in places.items()),
        frame=sky.Frame(origin=sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)),
    )
    mission = sky.plan_mission(scenario)
    (file,) = sky.export(mission, tmp_path / f"t{suffix}", sky.ExportOptions(altitude="home"))
    (checked,) = sky.check_waypoints([sky.read_waypoints(file)], scenario).missions
    flight = checked.flown.plan.predicted()
    t = np.arange(0.0, flight.end, 0.1)
    for place, least in ((places["here"], 7.0), (places["x"], 14.0), (places["z"], 7.0)):
        off = np.linalg.norm(flight.at(t).position - place, axis=1)
        assert 0.1 * (off < 0.1).sum() >= least - 0.2
