"""Mission files: one self-contained JSON; waypoints and sampled trajectories as CSV."""

import csv
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from skyverse.errors import InputError
from skyverse.files.document import explain
from skyverse.files.grids import Side, grids_of
from skyverse.model.mission import Mission

FORMAT = "skyverse/mission/1"
MAX_SAMPLES = 1e7


@cache
def _codec() -> TypeAdapter[Mission]:
    return TypeAdapter(Mission)


def mission_from_data(source: str | Path, data: Any) -> Mission:
    """Validate a mission file's data, or raise `InputError` naming file and field."""
    if data["format"] != FORMAT:
        raise InputError(f"{source}: format: expected {FORMAT!r}, found {data['format']!r:.60}")
    try:
        mission = _codec().validate_python(data, context={"grids": grids_of(Path(source))})
    except ValidationError as error:
        raise explain(source, error, set()) from None
    _require_sound(source, mission)
    fleet = len(mission.scenario.uavs)
    for name in ("assignment", "results", "trajectories"):
        if len(getattr(mission, name)) != fleet:
            raise InputError(
                f"{source}: {name}: expected one entry for each of {fleet} UAVs, found {len(getattr(mission, name))}"
            )
    return mission


def _require_sound(source: object, mission: Mission) -> None:
    """Refuse arrays whose shapes do not fit each other; what they hold is the referee's to judge."""
    for i, trajectory in enumerate(mission.trajectories):
        if trajectory is not None:
            knots, rows = trajectory.knots, trajectory.coefficients
            if knots.ndim != 1 or len(knots) < 2 or not (np.diff(knots) > 0).all() or not np.isfinite(knots).all():
                raise InputError(f"{source}: trajectories[{i}].knots: expected two or more rising numbers of seconds")
            if rows.ndim != 3 or rows.shape[0] != len(knots) - 1 or rows.shape[1] < 1 or rows.shape[2] != 3:
                raise InputError(
                    f"{source}: trajectories[{i}].coefficients: expected {len(knots) - 1} pieces of rows of x, y, z, "
                    f"found an array of shape {rows.shape}"
                )
            if not np.isfinite(rows).all():
                raise InputError(f"{source}: trajectories[{i}].coefficients: expected numbers, found NaN or infinity")
    for i, result in enumerate(mission.results):
        if result is not None:
            columns = vars(result.history).values()
            if any(c.ndim != 1 for c in columns) or len({len(c) for c in columns}) > 1:
                raise InputError(f"{source}: results[{i}].history: expected four columns of one length")


def mission_text(mission: Mission, side: Side | None = None) -> str:
    """Return a mission as the text of its JSON file; its scenario's large arrays go to `side` if there is one."""
    return _codec().dump_json(mission, indent=1, context={"side": side}).decode() + "\n"


def waypoints_csv(mission: Mission) -> str:
    """Return the points between the trajectories' pieces: uav, waypoint, t, x, y, z; seconds and metres."""
    rows: list[list[object]] = []
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None:
            places = trajectory.at(trajectory.knots).position
            rows += [
                [uav.name, i, *(repr(float(v)) for v in (t, *p))]
                for i, (t, p) in enumerate(zip(trajectory.knots, places, strict=True))
            ]
    return _csv(["uav", "waypoint", "t", "x", "y", "z"], rows)


def trajectories_csv(mission: Mission, rate: float) -> str:
    """Return the trajectories `rate` times a second and at their ends: uav, t, position, velocity, acceleration."""
    rows: list[list[object]] = []
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None:
            if trajectory.end * rate > MAX_SAMPLES:
                raise InputError(
                    f"expected at most {MAX_SAMPLES:g} rows a UAV, found {rate:g} a second of {trajectory.end:g}",
                    field="rate",
                )
            count = int(np.floor(trajectory.end * rate) - np.ceil(trajectory.start * rate)) + 1
            ticks = (np.ceil(trajectory.start * rate) + np.arange(count)) / rate
            t = np.unique(np.r_[trajectory.start, ticks, trajectory.end])
            motion = trajectory.at(t)
            table = np.column_stack([t, *motion])
            rows += [[uav.name, *(f"{value:.9g}" for value in row)] for row in table]
    head = ["uav", "t", *(f"{kind}{axis}" for kind in ("", "v", "a") for axis in "xyz")]
    return _csv(head, rows)


def _csv(head: list[str], rows: list[list[object]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return out.getvalue()
