"""Flies one UAV: in rotorpy, or in the compiled simulator, which does the same many times as fast.

In rotorpy it is steered by rotorpy's controller, and an observer estimates during the flight by how much the wind
accelerates it. A fixed-step integrator takes the place of rotorpy's adaptive one, which is slower.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import OdeSolver
from scipy.spatial.transform import Rotation

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE, VERTICAL, Commands
from skyverse.flight.disturbances import draw
from skyverse.flight.quadrotor import ATTITUDE, POSITION, ROTORS, STATE_SIZE, VELOCITY, quadrotor_of
from skyverse.flight.tracking_control import LOST_DISTANCE, OBSERVER_BANDWIDTH, DrawnDisturbances, track
from skyverse.flight.vehicle import Vehicle
from skyverse.model.conditions import Conditions
from skyverse.model.trajectory import Motion
from skyverse.model.uav import GRAVITY


class RungeKutta(OdeSolver):
    """The classical fourth-order Runge-Kutta method in equal steps of at most `max_step`."""

    def __init__(
        self, fun: Any, t0: float, y0: Floats, t_bound: float, vectorized: bool = False, max_step: float = np.inf
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized)
        self._step = (t_bound - t0) / max(1, np.ceil((t_bound - t0) / max_step - 1e-9))

    def _step_impl(self) -> tuple[bool, None]:
        f, y, h = self.fun, self.y, self._step
        a = f(self.t, y)
        b = f(self.t, y + h / 2 * a)
        c = f(self.t, y + h / 2 * b)
        self.y = y + h / 6 * (a + 2 * b + 2 * c + f(self.t, y + h * c))
        self.t = self.t + h if self.t + 1.5 * h < self.t_bound else self.t_bound
        return True, None


class WindObserver:
    """Estimates the wind's acceleration as the smoothed change of velocity that rotors and still air do not explain."""

    def __init__(self, body: Any, kind: Vehicle) -> None:
        self._body, self._mass = body, kind.mass
        self._explained: Floats | None = None

    def push(self, told: dict[str, Floats], dt: float) -> Floats:
        """Update the estimate with a measured state, and return it, (3,) m/s^2."""
        turned = Rotation.from_quat(told["q"]).as_matrix()
        if self._explained is None:
            self._explained = told["v"].copy()
        push: Floats = OBSERVER_BANDWIDTH * (told["v"] - self._explained)
        force, _ = self._body.compute_body_wrench(told["w"], told["rotor_speeds"], turned.T @ told["v"])
        self._explained += (turned @ force / self._mass - GRAVITY * VERTICAL + push) * dt
        return push


class ControlledUAV:
    """One UAV in rotorpy that hovers at first, and then follows what it is told.

    rotorpy's SE3 controller, with its own gains, commands the rotors `COMMAND_RATE` times a second. It follows the
    reference of `feedforward`, less the wind's acceleration that the observer has estimated, within the vehicle's
    largest tilt.

    Parameters
    ----------
    vehicle
        The one that the controller believes to fly.
    flown, disturbed
        The one that flies, and what disturbs it, for as many samples as it will fly at most.
    place
        (3,) metres: where it hovers.

    Attributes
    ----------
    lost
        Whether it has strayed so far from its reference that its simulation has ended.
    """

    def __init__(self, vehicle: Vehicle, flown: Vehicle, disturbed: DrawnDisturbances, place: Floats) -> None:
        from rotorpy.controllers.quadrotor_control import SE3Control
        from rotorpy.vehicles.multirotor import Multirotor

        self.lost = False
        self._vehicle, self._disturbed = vehicle, disturbed
        self._control = SE3Control(vehicle.parameters)
        hover = np.sqrt(vehicle.mass * GRAVITY / (vehicle.parameters["num_rotors"] * vehicle.parameters["k_eta"]))
        self._state: dict[str, Floats] = {
            "x": place,
            "v": np.zeros(3),
            "q": np.array([0.0, 0.0, 0.0, 1.0]),
            "w": np.zeros(3),
            "wind": disturbed.wind[0],
            "rotor_speeds": np.full(4, hover),
        }
        steps = {"method": RungeKutta, "max_step": vehicle.parameters["tau_m"]}
        self._body = Multirotor(flown.parameters, self._state, integrator_kwargs=steps)
        self._observer = WindObserver(Multirotor(vehicle.parameters, self._state), vehicle)
        self._states = np.empty((len(disturbed.wind), STATE_SIZE))
        self._flown = 0

    @property
    def states(self) -> Floats:
        """Its states (m, 17) at the samples that it has flown."""
        return self._states[: self._flown]

    @property
    def place(self) -> Floats:
        """Where it is, (3,) metres."""
        return self._state["x"]

    @property
    def velocity(self) -> Floats:
        """Its velocity, (3,) m/s."""
        return self._state["v"]

    def follow(self, asked: Motion) -> None:
        """Fly the next samples of a reference, unless the UAV is lost."""
        for position, velocity, acceleration in zip(*asked, strict=True):
            if self.lost:
                return
            self._step(position, velocity, acceleration)

    def _step(self, position: Floats, velocity: Floats, acceleration: Floats) -> None:
        """Fly from one sample to the next."""
        k, state, disturbed, dt = self._flown, self._state, self._disturbed, 1.0 / COMMAND_RATE
        self._states[k] = (*state["x"], *state["v"], *state["q"], *state["w"], *state["rotor_speeds"])
        self._flown = k + 1
        state["wind"] = disturbed.wind[k]
        late = self._states[max(0, k - disturbed.delay)]
        measured = {
            "x": late[POSITION:VELOCITY] + disturbed.position_error[k],
            "v": late[VELOCITY:ATTITUDE] + disturbed.velocity_error[k],
        }
        believed = state | measured
        wanted = acceleration - self._observer.push(believed, dt)
        felt = self._control.kp_pos * (believed["x"] - position) + self._control.kd_pos * (believed["v"] - velocity)
        flat = {
            "x": position,
            "x_dot": velocity,
            "x_ddot": _within_tilt(wanted - felt, self._vehicle.max_tilt) + felt,
            "yaw": 0.0,
            "yaw_dot": 0.0,
        }
        self._state = self._body.step(state, self._control.update(k / COMMAND_RATE, believed, flat), dt)
        self.lost = not np.linalg.norm(self._state["x"] - position) < LOST_DISTANCE


def _within_tilt(acceleration: Floats, most: float | None) -> Floats:
    """Return an acceleration whose thrust tilts by at most `most` degrees, with its vertical part unchanged."""
    if most is None:
        return acceleration
    lift = max(acceleration[2] + GRAVITY, 0.0)
    level = float(np.hypot(acceleration[0], acceleration[1]))
    share = min(1.0, lift * np.tan(np.radians(most)) / max(level, 1e-12))
    return np.array([acceleration[0] * share, acceleration[1] * share, acceleration[2]])


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


def simulate(told: Commands, known: Vehicle, conditions: Conditions, seed: int) -> Samples:
    """Fly one UAV in the compiled simulator, from a hover until it has settled after its arrival or is lost."""
    flown, disturbed = draw(told, known, conditions, seed)
    real, believed = quadrotor_of(flown), quadrotor_of(known)
    position, velocity, acceleration = (np.ascontiguousarray(rows) for rows in told.reference)
    count, states = track(real, believed, position, velocity, acceleration, disturbed, 1.0 / COMMAND_RATE)
    return samples(told.times, states[:count], told.hover)


def simulate_in_rotorpy(told: Commands, known: Vehicle, conditions: Conditions, seed: int) -> Samples:
    """Fly one UAV in rotorpy, as `simulate` does; see `ControlledUAV`."""
    flown, disturbed = draw(told, known, conditions, seed)
    uav = ControlledUAV(known, flown, disturbed, told.reference.position[0])
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
