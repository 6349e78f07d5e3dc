"""A flight tells which vehicle is simulated, and which one the mission was planned for where that is another."""

import pytest

import skyverse as sky
from skyverse.flight import VEHICLES
from skyverse.model.conditions import simulated_vehicle, simulated_vehicle_sentence


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
