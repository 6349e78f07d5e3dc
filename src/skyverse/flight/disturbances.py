"""What disturbs one flight of one UAV, drawn by seed.

Gusts are by the Dryden model of MIL-F-8785C ("Flying qualities of piloted airplanes", 1980) at low altitude.

With the height above ground h in feet, from 10 to 1000, and the mean wind at 20 feet, W_20, intensities and lengths are

    sigma_w = 0.1 W_20,      sigma_u = sigma_v = sigma_w / (0.177 + 0.000823 h)^0.4
    L_w     = h,             L_u     = L_v     = h / (0.177 + 0.000823 h)^1.2

along the mean wind (u), across it (v) and upwards (w). A vehicle that moves through the frozen field at the airspeed V
meets the spectra, one-sided in the frequency omega = V Omega, and so the autocorrelations over a time t = T L / V

    Phi_u(omega) = sigma_u^2 (2 L / (pi V)) / (1 + (L omega / V)^2),                            R_u = e^-T
    Phi_v(omega) = sigma_v^2 (L / (pi V)) (1 + 3 (L omega / V)^2) / (1 + (L omega / V)^2)^2,    R_v = (1 - T / 2) e^-T

and w as v. Measured in T and in units of sigma, both are stationary processes without parameters: u = p with
dp = -p dT + sqrt(2) dW, and v = (sqrt(3) p + (1 - sqrt(3)) q) / sqrt(2) with dq = (p - q) dT besides. Their transitions
over any step of T are known exactly and drawn here, so that intensities and lengths may change between samples.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE, Commands
from skyverse.flight.tracking_control import DrawnDisturbances
from skyverse.flight.vehicle import Vehicle
from skyverse.model.conditions import Conditions
from skyverse.numerics.kernel import kernel

FOOT = 0.3048
"""Metres."""
LOWEST_FEET, HIGHEST_FEET = 10.0, 1000.0
"""The heights between which the model of low altitude holds; below and above, it is taken as at the nearer of both."""
NORMALS_PER_SAMPLE = 5
"""Normal numbers that a sample of gusts is made of: one along the wind, two across it and two upwards."""


class GustScales(NamedTuple):
    """Intensities, m/s, and lengths, metres, (m,) each: horizontal (along and across the wind) and vertical."""

    horizontal_intensity: Floats
    vertical_intensity: float
    horizontal_length: Floats
    vertical_length: Floats


def gust_scales(height: Floats, wind_speed: float) -> GustScales:
    """Return intensities and lengths at heights above ground, (m,) metres, for a mean wind at 6 m in m/s."""
    feet = np.clip(height / FOOT, LOWEST_FEET, HIGHEST_FEET)
    rough = 0.177 + 0.000823 * feet
    vertical = 0.1 * wind_speed
    return GustScales(vertical / rough**0.4, vertical, feet / rough**1.2 * FOOT, feet * FOOT)


def gusts(height: Floats, airspeed: Floats, wind: Sequence[float], period: float, normals: Floats) -> Floats:
    """Return gusts, (m, 3) m/s towards east, north and up, at samples that are `period` seconds apart.

    Parameters
    ----------
    height
        (m,) metres above ground.
    airspeed
        (m,) m/s of the vehicle through the mean wind.
    wind
        The mean wind, m/s towards east, north and up; its horizontal speed is taken for that at 6 m.
    period
        Seconds between samples.
    normals
        (m, 5) independent standard normal numbers.
    """
    speed = math.hypot(wind[0], wind[1])
    scales = gust_scales(height, speed)
    level = airspeed * period / scales.horizontal_length
    unit = _unit_gusts(level, airspeed * period / scales.vertical_length, normals)
    along, across = scales.horizontal_intensity * unit[:, 0], scales.horizontal_intensity * unit[:, 1]
    east, north = (wind[0] / speed, wind[1] / speed) if speed else (1.0, 0.0)
    up = scales.vertical_intensity * unit[:, 2]
    return np.column_stack([east * along - north * across, north * along + east * across, up])


@kernel
def _unit_gusts(level: Floats, upright: Floats, normals: Floats) -> Floats:
    """Return gusts of unit intensity along and across the wind and upwards, (m, 3).

    Parameters
    ----------
    level, upright
        (m,) steps T before each sample, as shares of the horizontal and the vertical length; the first is not used.
    normals
        (m, 5) standard normal numbers.
    """
    count = len(level)
    unit = np.empty((count, 3))
    state = np.zeros(5)  # u, and p and q of v and of w
    for k in range(count):
        keep = math.exp(-level[k]) if k else 0.0
        state[0] = keep * state[0] + math.sqrt(1.0 - keep * keep) * normals[k, 0]
        unit[k, 0] = state[0]
        for axis in range(2):
            step = level[k] if axis == 0 else upright[k]
            keep = math.exp(-step) if k else 0.0
            p, q = state[1 + 2 * axis], state[2 + 2 * axis]
            # what is stationary has variances 1 and 1/2 and covariance 1/2; the step adds what it takes away
            pp = 1.0 - keep * keep
            pq = 0.5 - keep * keep * (step + 0.5)
            qq = 0.5 - keep * keep * (step * step + step + 0.5)
            if k == 0:
                pp, pq, qq = 1.0, 0.5, 0.5
            first = math.sqrt(pp)
            slope = pq / first if first > 0.0 else 0.0
            noise_p, noise_q = normals[k, 1 + 2 * axis], normals[k, 2 + 2 * axis]
            state[1 + 2 * axis] = keep * p + first * noise_p
            rest = math.sqrt(max(0.0, qq - slope * slope))
            state[2 + 2 * axis] = keep * (q + step * p) + slope * noise_p + rest * noise_q
            both = math.sqrt(3.0) * state[1 + 2 * axis] + (1.0 - math.sqrt(3.0)) * state[2 + 2 * axis]
            unit[k, 1 + axis] = both / math.sqrt(2.0)
    return unit


@kernel
def drift(keep: float, normals: Floats) -> Floats:
    """Return (m, 3) stationary first-order Gauss-Markov processes of unit variance.

    Parameters
    ----------
    keep
        The correlation between two samples.
    normals
        (m, 3) independent standard normal numbers.
    """
    drifted = normals.copy()
    fresh = math.sqrt(1.0 - keep * keep)
    for k in range(1, len(normals)):
        for axis in range(normals.shape[1]):
            drifted[k, axis] = keep * drifted[k - 1, axis] + fresh * normals[k, axis]
    return drifted


DRIFT_SECONDS = 1100.0
"""The time constant of the drift of a measured position; see `Conditions`."""


def draw(told: Commands, vehicle: Vehicle, conditions: Conditions, seed: int) -> tuple[Vehicle, DrawnDisturbances]:
    """Draw the vehicle that flies, and what disturbs it; the same seed draws the same."""
    rng, count = np.random.default_rng(seed), len(told.times)
    white = rng.normal(scale=conditions.noise, size=(count, 2, 3)) if conditions.noise else np.zeros((count, 2, 3))
    flown = vehicle
    if conditions.mismatch:
        flown = _differing(vehicle, rng.uniform(1.0 - conditions.mismatch, 1.0 + conditions.mismatch, size=4))
    wind = np.tile(np.array(conditions.wind, dtype=np.float64), (count, 1))
    if conditions.gusts:
        airspeed = np.linalg.norm(told.reference.velocity - wind, axis=1)
        normals = rng.standard_normal((count, NORMALS_PER_SAMPLE))
        wind += gusts(told.height, airspeed, conditions.wind, 1.0 / COMMAND_RATE, normals)
    position_error, velocity_error = np.ascontiguousarray(white[:, 0]), np.ascontiguousarray(white[:, 1])
    if conditions.position_noise:
        keep = math.exp(-1.0 / (COMMAND_RATE * DRIFT_SECONDS))
        position_error += conditions.position_noise * drift(keep, rng.standard_normal((count, 3)))
    return flown, DrawnDisturbances(wind, position_error, velocity_error, round(conditions.delay * COMMAND_RATE))


def _differing(vehicle: Vehicle, factors: Floats) -> Vehicle:
    """Return a vehicle with mass, thrust, drag and inertia multiplied by (4,) factors."""
    made = dict(vehicle.parameters)
    scaled = (("mass",), ("k_eta",), ("c_Dx", "c_Dy", "c_Dz", "k_d", "k_z"), ("Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Ixz"))
    for names, factor in zip(scaled, factors.tolist(), strict=True):
        for name in names:
            made[name] = made[name] * factor
    return replace(vehicle, parameters=made)
