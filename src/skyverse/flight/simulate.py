"""Flies one UAV in rotorpy."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.feedforward import reference
from skyverse.flight.runge_kutta import RungeKutta
from skyverse.flight.vehicle import vehicle_of
from skyverse.flight.wind_observer import WindObserver, upward
from skyverse.model.trajectory import Trajectory
from skyverse.trajectory.limits import GRAVITY

COMMAND_RATE = 100.0
"""Commands, and samples, per second."""
SETTLING_SECONDS = 1.0
"""Seconds for which a UAV is still simulated after its trajectory has ended."""
LOST_DISTANCE = 20.0
"""Metres: a UAV that is farther from its trajectory is lost."""


@dataclass(frozen=True)
class SimulationJob:
    """The flight of one UAV: trajectory, vehicle by name, wind (m/s), noise (m and m/s), seed of the noise."""

    trajectory: Trajectory
    vehicle: str
    wind: tuple[float, float, float]
    noise: float
    seed: int


@dataclass(frozen=True, eq=False)
class Samples:
    """The motion of one UAV: (m,) seconds, (m, 3) metres and m/s, (m, 4) rotor speeds (rad/s), (m,) degrees of tilt."""

    times: Floats
    positions: Floats
    velocities: Floats
    rotors: Floats
    tilt: Floats


def require_simulator() -> None:
    """Raise `InputError` if rotorpy is not installed."""
    try:
        import rotorpy.vehicles.multirotor  # noqa: F401
    except ImportError:
        raise InputError('flying needs rotorpy: pip install "skyverse[flight]"') from None


def simulate(job: SimulationJob) -> Samples:
    """Fly one UAV from its departure until `SETTLING_SECONDS` after the end of its trajectory.

    The UAV departs from a hover. rotorpy's SE3 controller, with its own gains, commands the rotors `COMMAND_RATE` times
    a second. It follows the reference of `feedforward`, less the wind's acceleration that the observer has estimated,
    within the vehicle's largest tilt. The samples end when the UAV is lost.
    """
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.vehicles.multirotor import Multirotor
    from rotorpy.wind.default_winds import ConstantWind

    kind, dt = vehicle_of(job.vehicle), 1.0 / COMMAND_RATE
    first = np.floor(job.trajectory.start * COMMAND_RATE)
    last = np.ceil((job.trajectory.end + SETTLING_SECONDS) * COMMAND_RATE)
    times = np.arange(first, last + 1) * dt
    control = SE3Control(kind.parameters)
    asked = reference(job.trajectory, kind, control, times, dt)
    hover = np.sqrt(kind.mass * GRAVITY / (kind.parameters["num_rotors"] * kind.parameters["k_eta"]))
    wind = ConstantWind(*job.wind)
    state: dict[str, Floats] = {
        "x": asked.position[0],
        "v": np.zeros(3),
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": np.array(job.wind),
        "rotor_speeds": np.full(4, hover),
    }
    body = Multirotor(
        kind.parameters, state, integrator_kwargs={"method": RungeKutta, "max_step": kind.parameters["tau_m"]}
    )
    observer = WindObserver(body, kind)
    errors = np.random.default_rng(job.seed)
    rows = np.empty((len(times), 11))
    for k, t in enumerate(times):
        rows[k] = (*state["x"], *state["v"], *state["rotor_speeds"], upward(state["q"])[2])
        state["wind"] = wind.update(t, state["x"])
        told = state
        if job.noise:
            told = state | {key: state[key] + errors.normal(scale=job.noise, size=3) for key in ("x", "v")}
        acceleration = asked.acceleration[k] - observer.push(told, dt)
        felt = control.kp_pos * (told["x"] - asked.position[k]) + control.kd_pos * (told["v"] - asked.velocity[k])
        flat = {
            "x": asked.position[k],
            "x_dot": asked.velocity[k],
            "x_ddot": _within_tilt(acceleration - felt, kind.max_tilt) + felt,
            "yaw": 0.0,
            "yaw_dot": 0.0,
        }
        state = body.step(state, control.update(t, told, flat), dt)
        if not np.linalg.norm(state["x"] - asked.position[k]) < LOST_DISTANCE:
            times, rows = times[: k + 1], rows[: k + 1]
            break
    return Samples(times, rows[:, :3], rows[:, 3:6], rows[:, 6:10], np.degrees(np.arccos(np.clip(rows[:, 10], -1, 1))))


def _within_tilt(acceleration: Floats, most: float | None) -> Floats:
    """Return an acceleration whose thrust tilts by at most `most` degrees, with its vertical part unchanged."""
    if most is None:
        return acceleration
    lift = max(acceleration[2] + GRAVITY, 0.0)
    level = float(np.hypot(acceleration[0], acceleration[1]))
    share = min(1.0, lift * np.tan(np.radians(most)) / max(level, 1e-12))
    return np.array([acceleration[0] * share, acceleration[1] * share, acceleration[2]])
