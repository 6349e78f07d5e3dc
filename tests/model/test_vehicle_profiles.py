"""Vehicle profiles fill the limits that a UAV does not give itself, and limits of a fleet replace those of its UAVs."""

import math
from pathlib import Path

import pytest
from pydantic import ValidationError

import skyverse as sky
from skyverse.flight import VEHICLES
from skyverse.model.conditions import SIMULATED_VEHICLES, simulated_vehicle, simulated_vehicle_sentence
from skyverse.model.uav import with_limits
from skyverse.model.vehicle_profiles import FleetLimits


@pytest.mark.parametrize("name", sky.VEHICLE_PROFILES)
def test_a_profile_gives_the_limits_that_are_left_out(name):
    profile = sky.VEHICLE_PROFILES[name]
    uav = sky.UAV(start=(0, 0, 9), vehicle=name)
    given = uav.model_dump(exclude_unset=True)
    assert {key: given[key] for key in profile.limits} == dict(profile.limits)
    assert profile.title
    assert profile.source
    assert sky.UAV.model_validate(uav.model_dump(exclude_none=True)) == uav


def test_what_a_uav_gives_itself_stands():
    uav = sky.UAV(start=(0, 0, 9), vehicle="camera", max_speed=4)
    assert uav.max_speed == 4
    assert uav.max_climb == sky.VEHICLE_PROFILES["camera"].limits["max_climb"]
    assert sky.UAV(start=(0, 0, 9), vehicle="camera", tracking_error={}).tracking_error == sky.TrackingError()


@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_a_limit_that_is_null_is_none_also_when_it_is_written_and_read(suffix, tmp_path):
    given = {"vehicle": "camera", "max_climb": None, "separation": 3, "vertical_separation": None}
    uav = sky.UAV(name="a", start=(0, -4, 1), **given)
    assert uav.max_climb is None
    assert uav.ellipsoid == (3, 6)
    assert with_limits(uav, FleetLimits(max_speed=4)).max_climb is None
    scenario = sky.read("map1").model_copy(update={"uavs": (uav,)})
    sky.write(scenario, tmp_path / f"a.{suffix}")
    read = sky.read_scenario(tmp_path / f"a.{suffix}")
    assert read.uavs == (uav,)
    assert read.digest == scenario.digest


@pytest.mark.parametrize(
    "given",
    [
        {"vehicle": "camera", "max_speed": None},
        {"vehicle": "camera", "tracking_error": None},
        {"vehicle": "mapping", "fixed_wing": None},
    ],
)
def test_what_every_uav_has_is_refused_where_it_is_null(given, tmp_path, refuses):
    import json

    sky.write(sky.read("map1"), tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text()) | {"uavs": [{"start": [0, -4, 1]} | given]}
    (tmp_path / "a.json").write_text(json.dumps(data))
    with refuses():
        sky.read_scenario(tmp_path / "a.json")


def test_the_thesis_quadrotor_has_the_defaults_of_a_uav():
    plain, thesis = sky.UAV(start=(0, 0, 0)), sky.UAV(start=(0, 0, 0), vehicle="thesis")
    assert thesis.ellipsoid == plain.ellipsoid
    assert thesis.model_copy(update={"vehicle": "", "vertical_separation": None}) == plain


@pytest.mark.parametrize(
    ("name", "mass", "rotors", "radius"),
    [
        *(("indoor", 0.027, 4, 0.0235), ("camera", 0.915, 4, 0.1194)),
        *(("heavy", 15.5, 6, 0.2667), ("m100", 3.68, 4, 0.1651)),
    ],
)
def test_a_hover_takes_several_times_the_ideal_power_of_the_rotors(name, mass, rotors, radius):
    assert mass == sky.VEHICLE_PROFILES[name].limits["mass"]
    weight, discs = 9.81 * mass, rotors * math.pi * radius**2
    ideal = weight**1.5 / math.sqrt(2 * 1.225 * discs)  # momentum theory, in the air of the standard atmosphere
    efficiency = ideal / sky.VEHICLE_PROFILES[name].limits["hover_power"]
    assert 0.1 < efficiency < 0.6  # rotors, motors and electronics together; least of all in the smallest vehicle


def test_a_power_of_its_own_replaces_all_points_of_the_vehicle():
    own = sky.UAV(start=(0, 0, 0), vehicle="camera", hover_power=150)
    assert (own.hover_power, own.power, own.mass) == (150, None, 0.915)
    measured = sky.UAV(start=(0, 0, 0), vehicle="camera", power_curve=[(0, 120), (9, 100)])
    assert (measured.hover_power, measured.power) == (None, None)
    plain = sky.UAV(start=(0, 0, 0), vehicle="camera", power=None)
    assert (plain.hover_power, plain.power) == (122, None)


def test_the_mapping_aeroplane_turns_at_30_degrees_of_bank_and_climbs_within_its_rates():
    uav = sky.UAV(start=(0, 0, 0), vehicle="mapping")
    wing = uav.fixed_wing
    assert wing.turn_radius == pytest.approx(wing.speed**2 / (9.81 * math.tan(math.radians(30))), abs=0.5)
    assert wing.speed * math.tan(math.radians(wing.climb)) <= uav.max_descent


@pytest.mark.parametrize("name", ["cammera", 3])
def test_a_vehicle_that_is_not_known_is_refused_with_the_names_that_are(name, tmp_path):
    with pytest.raises(ValidationError, match="there are indoor, thesis, camera, heavy, m100, mapping"):
        sky.UAV.model_validate({"start": (0, 0, 0), "vehicle": name})


def test_a_scenario_file_names_a_vehicle(tmp_path, refuses):
    sky.write(sky.read("map1"), tmp_path / "a.yaml")
    text = (tmp_path / "a.yaml").read_text().partition("uavs:")[0]
    text += "uavs:\n- {start: [0, -4, 1], vehicle: indoor, max_speed: 0.5}\ntargets:\n- {position: [2, 17, 3]}\n"
    (tmp_path / "a.yaml").write_text(text)
    (uav,) = sky.read_scenario(tmp_path / "a.yaml").uavs
    assert (uav.max_speed, uav.max_climb, uav.max_tilt) == (0.5, 1.0, 20.0)
    (tmp_path / "a.yaml").write_text(text.replace("indoor", "outdoor"))
    with refuses():
        sky.read_scenario(tmp_path / "a.yaml")


def test_limits_of_a_fleet_replace_those_of_each_uav():
    uav = sky.UAV(name="a", start=(1, 2, 3), home=0, priority=2, max_speed=9, separation=3, vertical_separation=1)
    assert with_limits(uav, FleetLimits()) is uav
    slower = with_limits(uav, FleetLimits(max_speed=4, max_climb=2, max_descent=1))
    assert slower == uav.model_copy(update={"max_speed": 4, "max_climb": 2, "max_descent": 1})
    assert with_limits(uav, FleetLimits(separation=5)).ellipsoid == (5, 10)
    astray = with_limits(uav, FleetLimits(tracking_error=(1.5, 2)))
    assert with_limits(astray, FleetLimits(vehicle="thesis")).tracking_error == sky.TrackingError()
    gnss = sky.TrackingError(horizontal=1.6, vertical=3)
    assert with_limits(astray, FleetLimits(vehicle="camera")).tracking_error == gnss
    assert with_limits(uav, FleetLimits(vehicle="camera", tracking_error=(1, 2))).tracking_error.vertical == 2
    assert astray == uav.model_copy(update={"tracking_error": sky.TrackingError(horizontal=1.5, vertical=2)})
    camera = with_limits(uav, FleetLimits(vehicle="camera", max_speed=4))
    assert camera == sky.UAV(name="a", start=(1, 2, 3), home=0, priority=2, vehicle="camera", max_speed=4)


@pytest.mark.parametrize(
    "limits",
    [{"vehicle": "rocket"}, {"max_speed": -1.0}, {"tracking_error": (-1, 2)}, {"vehicle": "mapping", "max_speed": 9.0}],
)
def test_limits_that_cannot_be_are_refused_in_a_sentence(limits, refuses):
    with refuses():
        with_limits(sky.UAV(name="a", start=(0, 0, 0)), FleetLimits(**limits))


def test_the_documentation_states_the_profiles():
    page = (Path(__file__).parents[2] / "docs" / "vehicles.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if line.startswith("| `")]
    head = next(line for line in page.splitlines() if line.startswith("| |"))
    names = [cell.strip(" `") for cell in head.split("|")[2:-1]]
    assert names == list(sky.VEHICLE_PROFILES)
    stated = dict.fromkeys(names, 0)
    for first, *cells in rows:
        fields = [word.strip("`") for word in first.replace(",", " ").split() if word.startswith("`")]
        for name, cell in zip(names, cells, strict=True):
            limits = sky.VEHICLE_PROFILES[name].limits
            if fields == ["fixed_wing"]:
                wing = limits.get("fixed_wing")
                due = (
                    wing
                    and f"{wing['speed']:g} m/s, {wing['turn_radius']:g} m of turn radius, "
                    f"{wing['climb']:g}° of climb, {wing['max_wind']:g} m/s of wind"
                )
                assert cell == (due or "")
            elif fields == ["tracking_error"]:
                assert cell == f"{limits['tracking_error']['horizontal']:g}, {limits['tracking_error']['vertical']:g}"
            elif fields == ["power"]:
                assert cell == ", ".join(f"{watts:g} at {speed:g}" for speed, watts in limits.get("power", ()))
            else:
                numbers = [f"{limits[field]:g}" for field in fields if field in limits]
                assert cell == (", ".join(numbers) or ("none" if fields[0] == "max_climb" else "")), (name, fields)
            stated[name] += sum(field in limits for field in fields)
    assert stated == {name: len(sky.VEHICLE_PROFILES[name].limits) for name in names}


def fleet(*vehicles):
    return [sky.UAV(name=f"u{k}", start=(0, 0, 9), vehicle=vehicle) for k, vehicle in enumerate(vehicles)]


@pytest.mark.parametrize(
    ("vehicles", "simulated"),
    [
        (["indoor", "indoor"], "crazyflie"),
        (["thesis"], "thesis"),
        (["indoor", "mapping"], "crazyflie"),  # the aeroplane is not simulated
        (["camera"], "camera"),
        (["camera", "heavy"], "thesis"),
        (["", ""], "thesis"),
        (["indoor", "thesis"], "thesis"),
        (["indoor", ""], "thesis"),
        ([], "thesis"),
    ],
)
def test_the_vehicle_of_the_mission_is_simulated_where_it_has_a_model(vehicles, simulated):
    assert simulated_vehicle(fleet(*vehicles)) == simulated


@pytest.mark.parametrize(
    ("vehicle", "planned", "sentence"),
    [
        ("crazyflie", ["indoor"], "Simulated: crazyflie, for which the mission was planned."),
        (
            "thesis",
            [""],
            "Simulated: thesis, in place of every multirotor; the mission names no vehicle. It is small and agile: a "
            "real vehicle may stray farther.",
        ),
        (
            "thesis",
            ["camera", "heavy"],
            "Simulated: thesis, in place of every multirotor; the mission was planned for camera, heavy (heavy: limits "
            "are known, but no mass, inertia and rotors to simulate).",
        ),
        (
            "hummingbird",
            ["indoor", ""],
            "Simulated: hummingbird, in place of every multirotor; the mission was planned for indoor, UAVs without a "
            "vehicle.",
        ),
    ],
)
def test_another_vehicle_than_the_planned_one_is_told(vehicle, planned, sentence):
    assert simulated_vehicle_sentence(vehicle, fleet(*planned)) == sentence


def test_every_model_of_a_profile_can_be_flown():
    assert {profile.simulated_as for profile in sky.VEHICLE_PROFILES.values()} - {None} <= set(VEHICLES)
    assert tuple(VEHICLES) == SIMULATED_VEHICLES
