"""ROS messages as JSON and YAML: nav_msgs/Path, and trajectory_msgs/MultiDOFJointTrajectory, in local metres."""

import json
import math
from typing import Any

from skyverse.exports.sampling import SampledTrajectory

ROS_FRAME = "map"
"""The frame of coordinates: x east, y north, z up (REP 103)."""


def path_message(flight: SampledTrajectory) -> dict[str, Any]:
    """Return a nav_msgs/msg/Path whose stamps are seconds into the mission."""
    poses = [
        {"header": _header(t), "pose": {"position": _vector(p), "orientation": _rotation(yaw)}}
        for t, p, yaw in zip(flight.seconds.tolist(), flight.position.tolist(), flight.yaw.tolist(), strict=True)
    ]
    return {"header": _header(0.0), "poses": poses}


def trajectory_message(flight: SampledTrajectory) -> dict[str, Any]:
    """Return a trajectory_msgs/msg/MultiDOFJointTrajectory; times are seconds into the mission."""
    columns = (flight.seconds, flight.position, flight.velocity, flight.acceleration, flight.yaw, flight.yaw_rate)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    points = [
        {
            "transforms": [{"translation": _vector(p), "rotation": _rotation(yaw)}],
            "velocities": [_twist(v, yaw_rate)],
            "accelerations": [_twist(a)],
            "time_from_start": _time(t),
        }
        for t, p, v, a, yaw, yaw_rate in rows
    ]
    return {"header": _header(0.0), "joint_names": [flight.name], "points": points}


def as_text(message: dict[str, Any], suffix: str) -> str:
    """Return a message as JSON, or as YAML that ``ros2 topic pub`` takes."""
    if suffix == ".json":
        return json.dumps(message, indent=1, allow_nan=False) + "\n"
    return "\n".join(_yaml(message)) + "\n"


def _yaml(value: Any) -> list[str]:
    """Return lines of YAML; mappings of plain values are written on one line, all else in blocks."""
    if isinstance(value, list):
        return [("- " if k == 0 else "  ") + line for one in value for k, line in enumerate(_yaml(one))]
    if not isinstance(value, dict):
        return [_scalar(value)]
    if not any(isinstance(one, dict | list) for one in value.values()):
        return ["{" + ", ".join(f"{key}: {_scalar(one)}" for key, one in value.items()) + "}"]
    lines = []
    for key, one in value.items():
        below = _yaml(one)
        if isinstance(one, list) or len(below) > 1:
            lines += [f"{key}:", *(f"  {line}" for line in below)]
        else:
            lines.append(f"{key}: {below[0]}")
    return lines


def _scalar(value: Any) -> str:
    text = json.dumps(value, allow_nan=False)
    # in YAML 1.1, which ROS reads, 1e-07 is a string and 1.0e-07 a number
    return text.replace("e", ".0e") if isinstance(value, float) and "e" in text and "." not in text else text


def _header(seconds: float) -> dict[str, Any]:
    return {"stamp": _time(seconds), "frame_id": ROS_FRAME}


def _time(seconds: float) -> dict[str, int]:
    nanoseconds = round(seconds * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def _vector(values: list[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))


def _twist(values: list[float], yaw_rate: float = 0.0) -> dict[str, dict[str, float]]:
    return {"linear": _vector(values), "angular": _vector([0.0, 0.0, yaw_rate])}


def _rotation(yaw: float) -> dict[str, float]:
    """Return a rotation about the vertical as a quaternion."""
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
