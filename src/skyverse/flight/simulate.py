"""Flies one UAV: in rotorpy, or in the compiled simulator, which does the same many times as fast."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.commands import COMMAND_RATE, Commands
from skyverse.flight.draw_disturbances import draw
from skyverse.flight.quadrotor import ATTITUDE, POSITION, ROTORS, STATE_SIZE, VELOCITY, quadrotor_of
from skyverse.flight.runge_kutta import RungeKutta
from skyverse.flight.tracking_control import LOST_DISTANCE, DrawnDisturbances, track
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.weather import Weather
from skyverse.flight.wind_observer import WindObserver
from skyverse.trajectory.limits import GRAVITY


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
    return _samples(told, states[:count])


def simulate_in_rotorpy(job: SimulationJob) -> Samples:
    """Fly one UAV in rotorpy, as `simulate` does.

    rotorpy's SE3 controller, with its own gains, commands the rotors `COMMAND_RATE` times a second. It follows the
    reference of `feedforward`, less the wind's acceleration that the observer has estimated, within the vehicle's
    largest tilt.
    """
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.vehicles.multirotor import Multirotor

    told, kind, dt = job.commands, job.vehicle, 1.0 / COMMAND_RATE
    drawn, asked = draw(told, kind, job.weather, job.seed), told.reference
    control = SE3Control(kind.parameters)
    hover = np.sqrt(kind.mass * GRAVITY / (kind.parameters["num_rotors"] * kind.parameters["k_eta"]))
    state: dict[str, Floats] = {
        "x": asked.position[0],
        "v": np.zeros(3),
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": drawn.wind[0],
        "rotor_speeds": np.full(4, hover),
    }
    steps = {"method": RungeKutta, "max_step": kind.parameters["tau_m"]}
    body = Multirotor(drawn.vehicle.parameters, state, integrator_kwargs=steps)
    observer = WindObserver(Multirotor(kind.parameters, state), kind)
    states = np.empty((len(told.times), STATE_SIZE))
    for k, t in enumerate(told.times):
        states[k] = (*state["x"], *state["v"], *state["q"], *state["w"], *state["rotor_speeds"])
        state["wind"] = drawn.wind[k]
        late = states[max(0, k - drawn.delay)]
        measured = {
            "x": late[POSITION:VELOCITY] + drawn.position_error[k],
            "v": late[VELOCITY:ATTITUDE] + drawn.velocity_error[k],
        }
        believed = state | measured
        acceleration = asked.acceleration[k] - observer.push(believed, dt)
        felt = control.kp_pos * (believed["x"] - asked.position[k])
        felt += control.kd_pos * (believed["v"] - asked.velocity[k])
        flat = {
            "x": asked.position[k],
            "x_dot": asked.velocity[k],
            "x_ddot": _within_tilt(acceleration - felt, kind.max_tilt) + felt,
            "yaw": 0.0,
            "yaw_dot": 0.0,
        }
        state = body.step(state, control.update(t, believed, flat), dt)
        if not np.linalg.norm(state["x"] - asked.position[k]) < LOST_DISTANCE:
            states = states[: k + 1]
            break
    return _samples(told, states)


def _samples(told: Commands, states: Floats) -> Samples:
    """Return the states (m, 17) from the departure on; where a UAV was lost before it, those from the hover on."""
    count = len(states)
    first = min(told.hover, count - 1)
    flown = states[first:]
    x, y = flown[:, ATTITUDE], flown[:, ATTITUDE + 1]
    upright = 1.0 - 2.0 * (x * x + y * y)  # the vertical part of the thrust's direction
    return Samples(
        told.times[first:count],
        flown[:, POSITION:VELOCITY],
        flown[:, VELOCITY:ATTITUDE],
        flown[:, ROTORS:STATE_SIZE],
        np.degrees(np.arccos(np.clip(upright, -1.0, 1.0))),
        count < len(told.times),
    )


def _within_tilt(acceleration: Floats, most: float | None) -> Floats:
    """Return an acceleration whose thrust tilts by at most `most` degrees, with its vertical part unchanged."""
    if most is None:
        return acceleration
    lift = max(acceleration[2] + GRAVITY, 0.0)
    level = float(np.hypot(acceleration[0], acceleration[1]))
    share = min(1.0, lift * np.tan(np.radians(most)) / max(level, 1e-12))
    return np.array([acceleration[0] * share, acceleration[1] * share, acceleration[2]])
