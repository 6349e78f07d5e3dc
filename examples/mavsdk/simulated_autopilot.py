"""An autopilot for trials, played by MAVSDK's server plugins: it is armed, takes offboard setpoints, and tells where it is."""

import json
import threading
import time

from mavsdk.component_type import ComponentType
from mavsdk.mavsdk import Configuration, Mavsdk
from mavsdk.plugins.action_server.action_server import ActionServer, AllowableFlightModes
from mavsdk.plugins.mavlink_direct_server.mavlink_direct_server import MavlinkDirectServer
from mavsdk.plugins.telemetry_server.telemetry_server import (
    PositionNed,
    PositionVelocityNed,
    TelemetryServer,
    VelocityNed,
)

TICK = 0.01  # seconds between two steps of the simulation
POSITION_GAIN, VELOCITY_GAIN = 4.0, 4.0  # 1/s^2, 1/s
MAX_ACCELERATION = 8.0  # m/s^2 along each axis
LOST = 0.5  # seconds without a setpoint, after which it brakes


class SimulatedAutopilot:
    """A point mass that follows setpoints of position, velocity and acceleration, all in north-east-down.

    Parameters
    ----------
    port
        The UDP port of this machine at which it listens.
    position
        Where it hovers until the first setpoint arrives, metres.
    """

    def __init__(self, port, position):
        self.position, self.velocity = list(position), [0.0, 0.0, 0.0]
        self.flown = []  # instants of time.monotonic, and positions
        self._setpoint, self._heard, self._ended = None, 0.0, threading.Event()
        self._mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.AUTOPILOT))
        component = self._mavsdk.server_component()
        self._action = ActionServer(component)  # it answers as long as it is kept
        self._action.set_armable(True, True)
        self._action.set_disarmable(True, True)
        self._action.set_allowable_flight_modes(AllowableFlightModes(can_auto_mode=True, can_guided_mode=True))
        self._telemetry, self._direct = TelemetryServer(component), MavlinkDirectServer(component)
        self._direct.subscribe_message("SET_POSITION_TARGET_LOCAL_NED", self._follow)
        self._mavsdk.add_any_connection(f"udpin://127.0.0.1:{port}")
        self._thread = threading.Thread(target=self._fly)
        self._thread.start()

    def close(self):
        """Switch it off."""
        self._ended.set()
        self._thread.join()
        self._mavsdk.destroy()

    def _follow(self, message, _):
        """Take in a setpoint."""
        held = json.loads(message.fields_json)
        self._setpoint = [[held[name + axis] for axis in "xyz"] for name in ("", "v", "af")]
        self._heard = time.monotonic()

    def _fly(self):
        """Move, and tell where it is fifty times a second, until it is switched off."""
        before, ticks = time.monotonic(), 0
        while not self._ended.wait(TICK):
            now = time.monotonic()
            self._step(min(now - before, 0.05), lost=now - self._heard > LOST)
            before, ticks = now, ticks + 1
            self.flown.append((now, tuple(self.position)))
            if ticks % 2 == 0:
                told = PositionVelocityNed(PositionNed(*self.position), VelocityNed(*self.velocity))
                self._telemetry.publish_position_velocity_ned(told)

    def _step(self, seconds, lost):
        """Fly towards the setpoint for some seconds; without one, brake."""
        for axis in range(3):
            push = -VELOCITY_GAIN * self.velocity[axis]
            if self._setpoint is not None and not lost:
                position, velocity, acceleration = (part[axis] for part in self._setpoint)
                push = acceleration + VELOCITY_GAIN * (velocity - self.velocity[axis])
                push += POSITION_GAIN * (position - self.position[axis])
            self.velocity[axis] += seconds * max(-MAX_ACCELERATION, min(MAX_ACCELERATION, push))
            self.position[axis] += seconds * self.velocity[axis]
