"""Trajectories sampled at even intervals, and their formats for robots (ROS) and light shows (Skybrush Studio)."""

import json
import math
from datetime import UTC, datetime, timedelta
from typing import Any, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.model.mission import Mission
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import SAME_INSTANT

MAX_SAMPLES = 1e6
EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""The date and time that stand for second 0 of a mission, which has no date of its own."""


class SampledTrajectory(NamedTuple):
    """One UAV's trajectory: (n,) seconds into the mission; position, velocity and acceleration, (n, 3) each.

    The yaw, rad counterclockwise from east, its rate, rad/s, and the camera's pitch, rad, are (n,) each.
    """

    uav: int
    name: str
    seconds: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    yaw: Floats
    yaw_rate: Floats
    pitch: Floats


def sample_trajectories(mission: Mission, rate: float) -> list[SampledTrajectory]:
    """Return every trajectory sampled `rate` times a second, at its ends, and where its pieces meet."""
    made = []
    for k, (uav, trajectory) in enumerate(zip(mission.scenario.uavs, mission.trajectories, strict=True)):
        if trajectory is not None:
            t = instants(trajectory, rate)
            made.append(SampledTrajectory(k, uav.name, t, *trajectory.at(t), *trajectory.heading(t)))
    return made


def instants(trajectory: Trajectory, rate: float) -> Floats:
    """Return the times of the samples of a trajectory, (n,) seconds, rising."""
    count = (trajectory.end - trajectory.start) * rate
    if count > MAX_SAMPLES:
        raise InputError(
            f"expected at most {MAX_SAMPLES:g} samples a UAV, found {rate:g} a second, which is {count:.3g}",
            field="rate",
        )
    ticks = np.arange(np.ceil(trajectory.start * rate), np.floor(trajectory.end * rate) + 1) / rate
    t = np.unique(np.r_[trajectory.knots, ticks])
    return t[np.r_[True, np.diff(t) > SAME_INSTANT]]


def clock(seconds: float) -> str:
    """Return a time in seconds into the mission as a date in ISO 8601, to the microsecond."""
    when = EPOCH + timedelta(seconds=seconds)
    return when.strftime("%Y-%m-%dT%H:%M:%S.%fZ")


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


SHOW_HEADER = "Time_msec,X,Y,Z,R,G,B"
"""The header that Skybrush writes itself, and whose beginning its importer recognises."""
SHOW_COLOUR = "255,255,255"


def show_csv(flight: SampledTrajectory, end: float) -> str:
    """Return one drone's file: whole milliseconds, local metres, white light; it waits at its first and last place."""
    milliseconds = np.rint(flight.seconds * 1000).astype(np.int64)
    rows = [(int(t), p) for t, p in zip(milliseconds, flight.position.tolist(), strict=True)]
    if rows[0][0] > 0:
        rows.insert(0, (0, rows[0][1]))
    last = int(np.rint(end * 1000))
    if rows[-1][0] < last:
        rows.append((last, rows[-1][1]))
    unique = dict(rows)
    return (
        "\n".join([SHOW_HEADER, *(f"{t},{x:.4f},{y:.4f},{z:.4f},{SHOW_COLOUR}" for t, (x, y, z) in unique.items())])
        + "\n"
    )
