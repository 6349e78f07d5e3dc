"""Draws by seed what disturbs one flight of one UAV."""

import math
from dataclasses import dataclass, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE, Commands
from skyverse.flight.gusts import NORMALS_PER_SAMPLE, drift, gusts
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.weather import Weather

DRIFT_SECONDS = 1100.0
"""The time constant of the drift of a measured position; see `Disturbances`."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """What disturbs one flight of m samples.

    Attributes
    ----------
    vehicle
        The vehicle that flies, which may differ from the one that its controller believes to fly.
    wind
        (m, 3) m/s: the velocity of the air.
    position_error, velocity_error
        (m, 3) metres and m/s: what is measured, less what is true.
    delay
        The number of samples by which the measured position and velocity are late.
    """

    vehicle: Vehicle
    wind: Floats
    position_error: Floats
    velocity_error: Floats
    delay: int


def draw(told: Commands, vehicle: Vehicle, weather: Weather, seed: int) -> Drawn:
    """Draw what disturbs a flight; the same seed draws the same."""
    rng, others, count = np.random.default_rng(seed), weather.others, len(told.times)
    white = rng.normal(scale=weather.noise, size=(count, 2, 3)) if weather.noise else np.zeros((count, 2, 3))
    flown = vehicle
    if others.mismatch:
        flown = _differing(vehicle, rng.uniform(1.0 - others.mismatch, 1.0 + others.mismatch, size=4))
    wind = np.tile(np.array(weather.wind, dtype=np.float64), (count, 1))
    if others.gusts:
        airspeed = np.linalg.norm(told.reference.velocity - wind, axis=1)
        normals = rng.standard_normal((count, NORMALS_PER_SAMPLE))
        wind += gusts(told.height, airspeed, weather.wind, 1.0 / COMMAND_RATE, normals)
    position_error, velocity_error = np.ascontiguousarray(white[:, 0]), np.ascontiguousarray(white[:, 1])
    if others.position_noise:
        keep = math.exp(-1.0 / (COMMAND_RATE * DRIFT_SECONDS))
        position_error += others.position_noise * drift(keep, rng.standard_normal((count, 3)))
    return Drawn(flown, wind, position_error, velocity_error, round(others.delay * COMMAND_RATE))


def _differing(vehicle: Vehicle, factors: Floats) -> Vehicle:
    """Return a vehicle with mass, thrust, drag and inertia multiplied by (4,) factors."""
    made = dict(vehicle.parameters)
    scaled = (("mass",), ("k_eta",), ("c_Dx", "c_Dy", "c_Dz", "k_d", "k_z"), ("Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Ixz"))
    for names, factor in zip(scaled, factors.tolist(), strict=True):
        for name in names:
            made[name] = made[name] * factor
    return replace(vehicle, parameters=made)
