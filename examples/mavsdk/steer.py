"""Steer a vehicle through MAVSDK by `skyverse live`, past a ball that swings across its way.

    python examples/mavsdk/steer.py out/map1.json                                 # a simulated autopilot flies
    python examples/mavsdk/steer.py out/map1.json --connect udpin://0.0.0.0:14540  # PX4's simulator, in the air

The autopilot's local frame must have its zero where that of the scenario is.
"""

import argparse
import json
import math
import socket
import subprocess
import sys
import threading
import time

from mavsdk.component_type import ComponentType
from mavsdk.mavsdk import Configuration, Mavsdk
from mavsdk.plugins.action.action import Action
from mavsdk.plugins.offboard.offboard import AccelerationNed, Offboard, PositionNedYaw, VelocityNedYaw
from mavsdk.plugins.telemetry.telemetry import Telemetry
from ned import enu, ned
from simulated_autopilot import SimulatedAutopilot

RATE = 50  # setpoints a second
OBSERVED = 5  # setpoints between two observations


class Steering:
    """The program `skyverse live`, and the setpoints that it answered last."""

    def __init__(self, mission, program=("skyverse",)):
        words = [*program, "live", mission, "--setpoints", str(RATE)]
        self._run = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.hello = json.loads(self._run.stdout.readline())
        self.answer, self.answers = None, []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self):
        for line in self._run.stdout:
            message = json.loads(line)
            if "error" in message:
                print(message["error"]["message"], file=sys.stderr)
            else:
                self.answer = message["uavs"][0]
                self.answers.append(self.answer)

    def observe(self, **observation):
        """Send what was observed; the answer arrives in the background."""
        self._run.stdin.write(json.dumps(observation) + "\n")
        self._run.stdin.flush()

    def setpoint(self, t):
        """Return position, velocity and acceleration, east-north-up, and yaw at an instant of the mission."""
        points = self.answer["setpoints"]
        k = min(max(round((t - points["t"][0]) * RATE), 0), len(points["t"]) - 1)
        return [points[name][k] for name in ("position", "velocity", "acceleration", "yaw")]

    def close(self):
        """End the program."""
        self._run.stdin.close()
        self._reader.join()
        self._run.wait()
        self._run.stdout.close()


def swinging_ball(hello, middle_at=4.0):
    """Return what a sensor sees at an instant: a ball that swings across the straight way, in its middle at another."""
    start, target = hello["uavs"][0]["start"], hello["uavs"][0]["target"]
    middle = [0.5 * (a + b) for a, b in zip(start, target, strict=True)]
    along = math.hypot(target[0] - start[0], target[1] - start[1]) or 1.0
    side = (start[1] - target[1]) / along, (target[0] - start[0]) / along, 0.0
    reach, turn = 2.0, 2 * math.pi / 16.0  # metres, radians a second

    def seen(t):
        place = [a + reach * math.sin(turn * (t - middle_at)) * b for a, b in zip(middle, side, strict=True)]
        ball = {"shape": "sphere", "centre": [0, 0, 0], "radius": 0.4}
        limits = {"top_speed": reach * turn, "max_acceleration": reach * turn**2}
        return [{"name": "ball", "shape": ball, "position": place, "error": 0.01, **limits}]

    return seen


def send(offboard, setpoint):
    """Send one setpoint to the vehicle."""
    *motion, yaw = setpoint
    position, velocity, acceleration = map(ned, motion)
    nose = 90.0 - math.degrees(yaw)  # clockwise from north
    offboard.set_position_velocity_acceleration_ned(
        PositionNedYaw(*position, nose), VelocityNedYaw(*velocity, nose), AccelerationNed(*acceleration)
    )


def fly(steering, system, sees, longest=120.0):
    """Steer a vehicle until it has arrived; return the instant of `time.monotonic` at which the mission began."""
    telemetry, offboard, heard = Telemetry(system), Offboard(system), {}

    def hear(told, _):
        place, speed = told.position, told.velocity
        position = enu((place.north_m, place.east_m, place.down_m))
        velocity = enu((speed.north_m_s, speed.east_m_s, speed.down_m_s))
        heard["state"] = time.monotonic(), {"position": position, "velocity": velocity}

    telemetry.subscribe_position_velocity_ned(hear)
    name, start = steering.hello["uavs"][0]["name"], steering.hello["uavs"][0]["start"]
    send(offboard, (start, (0, 0, 0), (0, 0, 0)))
    Action(system).arm()
    offboard.start()
    began, tick = time.monotonic(), 0
    while time.monotonic() - began < longest:
        t = time.monotonic() - began
        if tick % OBSERVED == 0 and "state" in heard:
            instant, state = heard["state"]
            seen = max(instant - began, 0.0)
            steering.observe(t=seen, movers=sees(seen), states={name: state}, deadline_ms=20)
        if steering.answer is not None:
            send(offboard, steering.setpoint(t))
            arrival = steering.answer["arrival"]
            if arrival is not None and t > arrival + 1.0:
                break
        tick += 1
        time.sleep(max(began + tick / RATE - time.monotonic(), 0.0))
    return began


def main():
    """Fly the mission that the command line names."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("mission")
    options.add_argument("--connect", help="where the autopilot is, as MAVSDK writes it")
    given = options.parse_args()
    steering, autopilot, where = Steering(given.mission), None, given.connect
    if where is None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        autopilot = SimulatedAutopilot(port, ned(steering.hello["uavs"][0]["start"]))
        where = f"udpout://127.0.0.1:{port}"
    ground = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    ground.add_any_connection(where)
    fly(steering, ground.first_autopilot(20.0), swinging_ball(steering.hello))
    print(steering.answer["sentence"])
    steering.close()
    ground.destroy()
    if autopilot is not None:
        autopilot.close()


if __name__ == "__main__":
    main()
