"""QGC WPL 110, the text format of Mission Planner and others: home, then one command on each line."""

import math

from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import AltitudeReference, home_on_globe
from skyverse.exports.mavlink_items import MAVLINK_FRAMES, Command, End, MissionItem, mission_items
from skyverse.model.altitude import AboveSea
from skyverse.model.scenario import Scenario


def waypoints_text(scenario: Scenario, plan: FlightPlan, reference: AltitudeReference, end: End) -> str:
    """Return a ``.waypoints`` file: line 0 is home, above mean sea level."""
    first = (0.0, 0.0, 0.0, 0.0, *home_on_globe(scenario, plan.route.uav))
    rows = [_row(0, 1, MAVLINK_FRAMES[AboveSea], Command.WAYPOINT, first)]
    rows += [_item(k, item) for k, item in enumerate(mission_items(scenario, plan, reference, end), 1)]
    return "\n".join(["QGC WPL 110", *rows]) + "\n"


def _item(number: int, item: MissionItem) -> str:
    # NaN leaves the heading to the autopilot, as 0 is north; but for loiter ArduPilot accepts only numbers
    free = 0.0 if item.command is Command.LOITER else math.nan
    return _row(number, 0, item.frame, item.command, tuple(free if v is None else v for v in item.numbers))


def _row(number: int, current: int, frame: int, command: int, values: tuple[float, ...]) -> str:
    return "\t".join([str(number), str(current), str(frame), str(int(command)), *map(_number, values), "1"])


def _number(value: float) -> str:
    if math.isnan(value):
        return "NaN"  # Mission Planner reads no other spelling
    return f"{value:.10f}".rstrip("0").rstrip(".") if value else "0"
