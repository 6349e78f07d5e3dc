"""Missions among zones with active times are exported where no flight depends on these times, and refused elsewhere."""

import json
from dataclasses import replace

import pytest

import skyverse as sky
import skyverse.referee.mission
from skyverse.lab import Study

PLACE = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0, geoid=47.0)
ACROSS = {"min": (18, -5, -5), "max": (22, 25, 12)}


def mission(*zones):
    """One UAV that crosses a hall."""
    return sky.plan_mission(
        sky.Scenario(
            name="hall",
            bounds={"min": (0, 0, 0), "max": (40, 20, 10)},
            clearance=0.2,
            lattice={"step": (1, 1, 1), "connectivity": 26},
            objective={"unit": "metres"},
            zones=zones,
            uavs=[sky.UAV(start=(1, 10, 5), home=0.0)],
            targets=[{"position": (39, 10, 5)}],
            frame={"origin": PLACE},
        )
    )


def test_a_flight_that_depends_on_active_times_is_written_only_where_files_hold_its_times(tmp_path, refuses):
    planned = mission(sky.Box(**ACROSS, name="airshow", active=[[0, 20]]))
    assert planned.violations == ()
    for suffix in ("plan", "waypoints", "wpml.kmz"):
        with refuses():
            sky.export(planned, tmp_path / f"flight.{suffix}")
    with refuses():
        sky.routes(planned)
    assert not list(tmp_path.iterdir())
    for suffix in ("gpx", "geojson", "trajectory.json", "kml", "geo.csv", "json"):
        assert sky.export(planned, tmp_path / f"flight.{suffix}")
    assert sky.read_mission(tmp_path / "flight.json").scenario == planned.scenario


def test_a_flight_around_a_zone_is_exported_as_if_it_were_always_active(tmp_path):
    beside = {"min": (18, 6, -5), "max": (22, 25, 12)}
    planned = mission(sky.Box(**beside, active=[[0, 500]]))
    always = mission().scenario.model_copy(update={"obstacles": (sky.Box(**beside),)})
    assert "flies around zone 0" in planned.deconfliction.actions[0].sentence
    sky.export(planned, tmp_path / "times.plan")
    sky.export(sky.plan_mission(always), tmp_path / "always.plan")
    assert (tmp_path / "times.plan").read_text() == (tmp_path / "always.plan").read_text()


def test_a_flight_that_is_fast_only_while_a_limit_does_not_hold_is_refused(tmp_path, refuses):
    beside = sky.Box(min=(18, 14, -5), max=(22, 25, 12), active=[[0, 500]])
    planned = mission(beside, sky.Box(**ACROSS, active=[[0, 2]], max_speed=0.5))
    with refuses():
        sky.export(planned, tmp_path / "flight.plan")


def test_such_missions_are_neither_simulated_nor_studied(tmp_path, refuses):
    planned = mission(sky.Box(**ACROSS, active=[[0, 20]]))
    with refuses():
        sky.fly(planned)
    file = tmp_path / "zones.yaml"
    sky.write(planned.scenario, file)
    study = Study(scenarios=[str(file)], planners=["taut"], budget=[{"paths": 10}], seeds=[1])
    with refuses():
        list(study.jobs())


def test_a_refused_export_names_the_zone_that_check_names(tmp_path):
    aside = sky.Box(min=(18, 17, -5), max=(22, 25, 12), active=[[0, 500]])
    slow = sky.Box(**ACROSS, name="school", max_speed=0.5)
    planned = mission()
    refuted = replace(planned, scenario=planned.scenario.model_copy(update={"zones": (aside, slow)}))
    (found, *_) = (one for one in sky.check(refuted.scenario, refuted) if one.fault is sky.Fault.ZONE_SPEED)
    assert "zone 1 ('school')" in found.message
    with pytest.raises(sky.InputError) as refused:
        sky.export(refuted, tmp_path / "flight.plan")
    assert found.message.removesuffix(".") in str(refused.value)


@pytest.mark.parametrize("with_page", [False, True])
def test_a_mission_is_judged_once_as_given_and_once_as_if_zones_were_always_active(tmp_path, monkeypatch, with_page):
    planned = mission(sky.Box(min=(18, 17, -5), max=(22, 25, 12), name="airshow", active=[[0, 500]]))
    scenarios = []

    def counting(worlds, judged):
        scenarios.append(worlds.scenario)
        return judge_fleet(worlds, judged)

    judge_fleet = skyverse.referee.mission.judge_fleet
    monkeypatch.setattr(skyverse.referee.mission, "judge_fleet", counting)
    page = tmp_path / "flight.html" if with_page else None
    sky.export(planned, tmp_path / "flight.plan", page=page)
    given, always = scenarios
    assert (given, always.zones) == (planned.scenario, ())
    if page is not None:
        assert "clear of zones while they are active" in page.read_text(encoding="utf-8")


def test_drawn_zones_keep_their_names_and_numbers_on_maps(tmp_path):
    planned = mission(sky.Box(min=(18, 17, -5), max=(22, 25, 12), name="airshow", active=[[0, 500]]))
    sky.export(planned, tmp_path / "flight.geojson")
    drawn = json.loads((tmp_path / "flight.geojson").read_text())["features"]
    assert any("airshow" in str(one["properties"]) and "zone" in str(one["properties"]) for one in drawn)
