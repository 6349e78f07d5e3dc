"""The example that drives MAVSDK's simulated autopilot by `skyverse live` flies past a ball to its target."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from mavsdk_stations import free_port
from patience import PATIENCE_S, wait_until
from replanned import hall

EXAMPLE = Path(__file__).parents[2] / "examples" / "mavsdk"
if not EXAMPLE.exists():
    pytest.skip("the examples are in the repository only", allow_module_level=True)


def example(name):
    """A module of the example, which imports the others by their names."""
    sys.path.insert(0, str(EXAMPLE))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(EXAMPLE))


VECTORS = st.tuples(*[st.floats(-1e6, 1e6)] * 3)


@given(VECTORS)
def test_axes_are_turned_there_and_back(vector):
    frames = example("ned")
    assert frames.enu(frames.ned(vector)) == vector
    turned = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # a proper rotation
    assert np.linalg.det(turned) == pytest.approx(1.0)
    assert frames.ned(vector) == tuple(turned @ vector)


class Clock:
    """Stands in for `time`: it goes on only in sleep, once all that was observed is answered, and with the autopilot.

    So however busy the machine is, answers come in time, and the autopilot flies as long as it is steered.
    """

    def __init__(self, steering):
        self._now, self._asked, self._answers, self._observe = 0.0, 0, steering.answers, steering.observe
        steering.observe, self.autopilot = self.observe, None

    def observe(self, **observation):
        self._asked += 1
        self._observe(**observation | {"deadline_ms": 1000 * PATIENCE_S})

    def monotonic(self):
        return self._now

    def sleep(self, seconds):
        wait_until(lambda: len(self._answers) >= self._asked)
        self._now += seconds
        wait_until(lambda: self.autopilot.flown and self.autopilot.flown[-1][0] >= self._now)


def test_mavsdk_flies_what_is_answered_and_touches_nothing(tmp_path, monkeypatch):
    pytest.importorskip("mavsdk", reason="mavsdk is not installed")
    steer, autopilots, frames = (example(name) for name in ("steer", "simulated_autopilot", "ned"))
    from mavsdk.component_type import ComponentType
    from mavsdk.mavsdk import Configuration, Mavsdk

    uav = sky.UAV(start=(2, 5, 2), max_speed=1.5, tracking_error={"horizontal": 0.3, "vertical": 0.3})
    scenario = hall(uavs=[uav], targets=[sky.Target(position=(12, 5, 2))], size=(14, 10, 4))
    file = tmp_path / "hall.json"
    mission = sky.plan_mission(scenario)
    sky.write(mission, file)
    port = free_port()
    steering = steer.Steering(str(file), program=(sys.executable, "-m", "skyverse"))
    clock = Clock(steering)
    for module in (steer, autopilots):
        monkeypatch.setattr(module, "time", clock)
    clock.autopilot = autopilot = autopilots.SimulatedAutopilot(port, frames.ned((2.0, 5.0, 2.0)))
    ground = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    sees = steer.swinging_ball(steering.hello, middle_at=mission.makespan / 2)
    try:
        ground.add_any_connection(f"udpout://127.0.0.1:{port}")
        began = steer.fly(steering, ground.first_autopilot(PATIENCE_S), sees)
    finally:
        steering.close()
        ground.destroy()
        autopilot.close()
    t = np.linspace(0, mission.makespan, 200)
    planned = mission.trajectories[0].at(t).position - [sees(one)[0]["position"] for one in t]
    assert np.linalg.norm(planned, axis=1).min() < 0.1  # had nothing been observed
    flown = np.array([frames.enu(place) for _, place in autopilot.flown])
    ball = np.array([sees(instant - began)[0]["position"] for instant, _ in autopilot.flown])
    assert np.linalg.norm(flown - ball, axis=1).min() > 0.4 + scenario.clearance
    assert np.linalg.norm(flown[-1] - (12, 5, 2)) < 0.1
    assert len(steering.answers) > 20
    assert steering.answers[-1]["proven"]
