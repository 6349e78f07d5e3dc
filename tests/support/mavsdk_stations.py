"""MAVSDK, which reads missions for ground stations, and an autopilot that it simulates."""

import socket

import pytest

from patience import PATIENCE_S


def free_port():
    """Return a UDP port of this machine that nobody holds."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Stations:
    """MAVSDK's ground station, and its simulated autopilot, over loopback."""

    def __init__(self):
        from mavsdk.component_type import ComponentType
        from mavsdk.mavsdk import Configuration, Mavsdk
        from mavsdk.plugins.mission_raw.mission_raw import MissionRaw
        from mavsdk.plugins.mission_raw_server.mission_raw_server import MissionRawServer

        self.ground, self.air = (
            Mavsdk(Configuration.create_with_component_type(kind))
            for kind in (ComponentType.GROUND_STATION, ComponentType.AUTOPILOT)
        )
        self.received = []
        self.server = MissionRawServer(self.air.server_component())
        self.server.subscribe_incoming_mission(lambda result, plan, _: self.received.append(plan.mission_items))
        while self.air.add_any_connection(f"udpin://127.0.0.1:{(port := free_port())}"):
            pass  # another process has taken it since
        self.ground.add_any_connection(f"udpout://127.0.0.1:{port}")
        self.mission = MissionRaw(self.ground.first_autopilot(PATIENCE_S))

    def close(self):
        self.ground.destroy()
        self.air.destroy()


@pytest.fixture(scope="module")
def stations():
    pytest.importorskip("mavsdk", reason="reads .plan and .waypoints")
    both = Stations()
    yield both
    both.close()
