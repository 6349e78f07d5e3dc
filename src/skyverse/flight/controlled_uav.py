"""One UAV in rotorpy, with rotorpy's controller and an observer of the wind."""

import numpy as np

from skyverse._typing import Floats
from skyverse.flight.commands import COMMAND_RATE
from skyverse.flight.draw_disturbances import Drawn
from skyverse.flight.feedforward import Reference
from skyverse.flight.quadrotor import ATTITUDE, POSITION, STATE_SIZE, VELOCITY
from skyverse.flight.runge_kutta import RungeKutta
from skyverse.flight.tracking_control import LOST_DISTANCE
from skyverse.flight.vehicle import Vehicle
from skyverse.flight.wind_observer import WindObserver
from skyverse.trajectory.limits import GRAVITY


class ControlledUAV:
    """One UAV in rotorpy that hovers at first, and then follows what it is told.

    rotorpy's SE3 controller, with its own gains, commands the rotors `COMMAND_RATE` times a second. It follows the
    reference of `feedforward`, less the wind's acceleration that the observer has estimated, within the vehicle's
    largest tilt.

    Parameters
    ----------
    vehicle
        The one that the controller believes to fly.
    drawn
        The one that flies, and what disturbs it, for as many samples as it will fly at most.
    place
        (3,) metres: where it hovers.

    Attributes
    ----------
    lost
        Whether it has strayed so far from its reference that its simulation has ended.
    """

    def __init__(self, vehicle: Vehicle, drawn: Drawn, place: Floats) -> None:
        from rotorpy.controllers.quadrotor_control import SE3Control
        from rotorpy.vehicles.multirotor import Multirotor

        self.lost = False
        self._vehicle, self._drawn = vehicle, drawn
        self._control = SE3Control(vehicle.parameters)
        hover = np.sqrt(vehicle.mass * GRAVITY / (vehicle.parameters["num_rotors"] * vehicle.parameters["k_eta"]))
        self._state: dict[str, Floats] = {
            "x": place,
            "v": np.zeros(3),
            "q": np.array([0.0, 0.0, 0.0, 1.0]),
            "w": np.zeros(3),
            "wind": drawn.wind[0],
            "rotor_speeds": np.full(4, hover),
        }
        steps = {"method": RungeKutta, "max_step": vehicle.parameters["tau_m"]}
        self._body = Multirotor(drawn.vehicle.parameters, self._state, integrator_kwargs=steps)
        self._observer = WindObserver(Multirotor(vehicle.parameters, self._state), vehicle)
        self._states = np.empty((len(drawn.wind), STATE_SIZE))
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

    def follow(self, asked: Reference) -> None:
        """Fly the next samples of a reference, unless the UAV is lost."""
        for position, velocity, acceleration in zip(*asked, strict=True):
            if self.lost:
                return
            self._step(position, velocity, acceleration)

    def _step(self, position: Floats, velocity: Floats, acceleration: Floats) -> None:
        """Fly from one sample to the next."""
        k, state, drawn, dt = self._flown, self._state, self._drawn, 1.0 / COMMAND_RATE
        self._states[k] = (*state["x"], *state["v"], *state["q"], *state["w"], *state["rotor_speeds"])
        self._flown = k + 1
        state["wind"] = drawn.wind[k]
        late = self._states[max(0, k - drawn.delay)]
        measured = {
            "x": late[POSITION:VELOCITY] + drawn.position_error[k],
            "v": late[VELOCITY:ATTITUDE] + drawn.velocity_error[k],
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
