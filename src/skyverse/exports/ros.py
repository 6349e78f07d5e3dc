"""ROS messages as JSON and YAML: nav_msgs/Path, and trajectory_msgs/MultiDOFJointTrajectory, in local metres."""

import io
import json
from typing import Any

from skyverse.exports.samples import Sampled

FRAME = "map"
"""East, north, up, as REP 103 wants it."""
LEVEL = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
"""Headings are not planned."""


def path_message(flight: Sampled) -> dict[str, Any]:
    """Return a nav_msgs/msg/Path whose stamps are seconds into the mission."""
    poses = [
        {"header": _header(t), "pose": {"position": _vector(p), "orientation": dict(LEVEL)}}
        for t, p in zip(flight.seconds.tolist(), flight.position.tolist(), strict=True)
    ]
    return {"header": _header(0.0), "poses": poses}


def trajectory_message(flight: Sampled) -> dict[str, Any]:
    """Return a trajectory_msgs/msg/MultiDOFJointTrajectory; times are seconds into the mission."""
    rows = zip(
        *(v.tolist() for v in (flight.seconds, flight.position, flight.velocity, flight.acceleration)), strict=True
    )
    points = [
        {
            "transforms": [{"translation": _vector(p), "rotation": dict(LEVEL)}],
            "velocities": [_twist(v)],
            "accelerations": [_twist(a)],
            "time_from_start": _time(t),
        }
        for t, p, v, a in rows
    ]
    return {"header": _header(0.0), "joint_names": [flight.name], "points": points}


def as_text(message: dict[str, Any], suffix: str) -> str:
    """Return a message as JSON, or as YAML that ``ros2 topic pub`` takes."""
    if suffix == ".json":
        return json.dumps(message, indent=1, allow_nan=False) + "\n"
    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.representer.ignore_aliases = lambda _: True
    out = io.StringIO()
    yaml.dump(message, out)
    return out.getvalue()


def _header(seconds: float) -> dict[str, Any]:
    return {"stamp": _time(seconds), "frame_id": FRAME}


def _time(seconds: float) -> dict[str, int]:
    nanoseconds = round(seconds * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def _vector(values: list[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def _twist(values: list[float]) -> dict[str, dict[str, float]]:
    return {"linear": _vector(values), "angular": _vector([0.0, 0.0, 0.0])}
