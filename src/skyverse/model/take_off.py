"""What a UAV's take-off from the ground and its landing take, before and after the flight that is planned."""

import math
from typing import NamedTuple

import numpy as np

from skyverse.model.pad import ground_height, home_height
from skyverse.model.scenario import Scenario

RISE, SINK = 1.5, 1.5
"""m/s of take-off and descent: PX4's MPC_TKO_SPEED and MPC_Z_V_AUTO_DN."""
LAST_METRES, LAST_SINK = 10.0, 0.5
"""Metres above ground below which a landing is slower, m/s: ArduPilot's LAND_ALT_LOW and LAND_SPEED."""


SAME_SPOT = 1e-3
"""Metres from its start, seen from above, within which a UAV stands where it started."""


class OnAndOff(NamedTuple):
    """The seconds and the joules, at most, of a take-off or a landing; no joules where no power is known."""

    seconds: float
    joules: float


def take_off(scenario: Scenario, uav: int, place: tuple[float, float, float]) -> OnAndOff:
    """Return what it takes a UAV to rise from the ground to a place, x, y, z in metres; nothing for aeroplanes."""
    height = _above_ground(scenario, uav, place)
    return OnAndOff(height / RISE, height / RISE * _hovering(scenario, uav, RISE))


def landing(scenario: Scenario, uav: int, place: tuple[float, float, float]) -> OnAndOff:
    """Return what it takes a UAV to sink from a place to the ground below; nothing for aeroplanes."""
    return touch_down(scenario, uav, _above_ground(scenario, uav, place))


def touch_down(scenario: Scenario, uav: int, height: float) -> OnAndOff:
    """Return what it takes a UAV to sink by a height, metres, to what it lands on."""
    seconds = max(height - LAST_METRES, 0.0) / SINK + min(height, LAST_METRES) / LAST_SINK
    return OnAndOff(seconds, seconds * _hovering(scenario, uav, 0.0))


def _above_ground(scenario: Scenario, uav: int, place: tuple[float, float, float]) -> float:
    """Return how high a place is above what the UAV stands on there; 0 where nobody knows."""
    vehicle = scenario.uavs[uav]
    if vehicle.fixed_wing is not None:
        return 0.0
    if math.dist(place[:2], vehicle.start[:2]) <= SAME_SPOT:
        return max(place[2] - home_height(scenario, uav), 0.0)
    return 0.0 if scenario.terrain is None else max(place[2] - float(ground_height(scenario, place[:2])), 0.0)


def _hovering(scenario: Scenario, uav: int, climb: float) -> float:
    """Return the most that a UAV takes while it hovers and climbs in the scenario's winds, W."""
    power, winds = scenario.uavs[uav].power_model, scenario.winds
    if power is None:
        return 0.0
    gust = 0.0 if scenario.wind is None else scenario.wind.gust
    spread, up = winds.radius - gust, abs(winds.velocity[2])
    level, rise = math.hypot(*winds.velocity) + spread, climb + (up + spread if up else 0.0)
    return float(power.most(np.zeros(1), np.array([level]), np.array([rise]), np.ones(1), gust)[0])
