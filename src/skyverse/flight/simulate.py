"""Flies one UAV: in rotorpy, or in the compiled simulator, which does the same many times as fast."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.commands import COMMAND_RATE, Commands
from skyverse.flight.controlled_uav import ControlledUAV
from skyverse.flight.draw_disturbances import draw
from skyverse.flight.quadrotor import ATTITUDE, POSITION, ROTORS, STATE_SIZE, VELOCITY, quadrotor_of
from skyverse.flight.tracking_control import DrawnDisturbances, track
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.weather import Weather


@dataclass(frozen=True, eq=False)
class SimulationJob:
    """The flight of one UAV: its commands, its vehicle, what disturbs it, and the seed of that."""

    commands: Commands
    vehicle: Vehicle
    weather: Weather
    seed: int


@dataclass(frozen=True, eq=False)
class Samples:
    """The motion of one UAV from its departure on, a hundredth of a second apart.

    Attributes
    ----------
    times
        (m,) seconds into the mission.
    positions, velocities
        (m, 3) metres and m/s.
    rotors
        (m, 4) rad/s.
    tilt
        (m,) degrees between the thrust and the vertical.
    lost
        Whether the samples end early because the UAV was lost.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    rotors: Floats
    tilt: Floats
    lost: bool


def require_simulator() -> None:
    """Raise `InputError` if rotorpy is not installed."""
    try:
        import rotorpy.vehicles.multirotor  # noqa: F401
    except ImportError:
        raise InputError('flying needs rotorpy: pip install "skyverse[flight]"') from None


def simulate(job: SimulationJob) -> Samples:
    """Fly one UAV in the compiled simulator, from a hover until it has settled after its arrival or is lost."""
    told, known = job.commands, job.vehicle
    drawn = draw(told, known, job.weather, job.seed)
    disturbed = DrawnDisturbances(drawn.wind, drawn.position_error, drawn.velocity_error, drawn.delay)
    real, believed = quadrotor_of(drawn.vehicle), quadrotor_of(known)
    position, velocity, acceleration = (np.ascontiguousarray(rows) for rows in told.reference)
    count, states = track(real, believed, position, velocity, acceleration, disturbed, 1.0 / COMMAND_RATE)
    return samples(told.times, states[:count], told.hover)


def simulate_in_rotorpy(job: SimulationJob) -> Samples:
    """Fly one UAV in rotorpy, as `simulate` does; see `ControlledUAV`."""
    told, kind = job.commands, job.vehicle
    uav = ControlledUAV(kind, draw(told, kind, job.weather, job.seed), told.reference.position[0])
    uav.follow(told.reference)
    return samples(told.times, uav.states, told.hover)


def samples(times: Floats, states: Floats, hover: int) -> Samples:
    """Return the motion of a UAV from its departure on; where it was lost before it, from the hover on.

    Parameters
    ----------
    times
        (n,) seconds into the mission: all that were to be flown.
    states
        (m, 17), of the first m of them.
    hover
        How many samples precede the departure.
    """
    count = len(states)
    first = min(hover, count - 1)
    flown = states[first:]
    x, y = flown[:, ATTITUDE], flown[:, ATTITUDE + 1]
    upright = 1.0 - 2.0 * (x * x + y * y)  # the vertical part of the thrust's direction
    return Samples(
        times[first:count],
        flown[:, POSITION:VELOCITY],
        flown[:, VELOCITY:ATTITUDE],
        flown[:, ROTORS:STATE_SIZE],
        np.degrees(np.arccos(np.clip(upright, -1.0, 1.0))),
        count < len(times),
    )
