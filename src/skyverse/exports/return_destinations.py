"""Where a returning UAV may land: at home or at rally points, and which of them its autopilot may choose."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.autopilots import Acceptance, Autopilot
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import global_positions
from skyverse.exports.return_lines import Ground, ReturnLines, ReturnSpace
from skyverse.model.geodesy import LEAST_RADIUS
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import MAVLINK_ROUNDING, SAME_PLACE
from skyverse.space.tube import NO_ERROR, is_wall_within

WHOLE_METRES = 1e-3
"""Metres by which an altitude may exceed a whole number of metres and still be rounded down to that."""
COLUMN_STEP = 0.25
"""Metres between the heights above a landing place at which a straying UAV is tried."""
NEARER_BY = {"px4": 2.0, "ardupilot": 0.0, "dji": 0.0}
"""Metres by which a rally point must be nearer than what was looked at before it (`MIN_DIST_THRESHOLD` of PX4)."""
IGNORED_NEAR_HOME = 10.0
"""Metres from home within which PX4 ignores rally points (`MAX_DIST_FROM_HOME_FOR_LAND_APPROACHES`)."""
DISTANCE_ERROR = 0.01
"""The share of a distance by which an autopilot may reckon it wrong, and this in another way for each destination.

PX4 reckons on a sphere of 6,371,000 m and ArduPilot on one of 6,378,100 m: at the equator a metre to the north is one
of 1.0057 or 1.0067 m to them. The rest is for heights above the ellipsoid, and for places far from the origin.
"""


ACCEPTANCE = {"px4": Acceptance(1.0, 0.5), "ardupilot": Acceptance(0.0, 0.0), "dji": Acceptance(0.0, 0.0)}
"""On a return: `NAV_ACC_RAD` and at most `NAV_MC_ALT_RAD` of PX4's parameter file; the others come to a stop first."""


class Destination(NamedTuple):
    """A place to land at, below which or above which a flight may begin or end.

    Attributes
    ----------
    place
        (3,) metres.
    foot
        z at which the flight is above it, metres: that of the start over home.
    low
        z down to which the descent keeps above ground, metres.
    bottom
        z down to which it keeps clear of obstacles, metres: what is below cannot keep the clearance.
    column, climb
        z of the top of the column over it, metres, in which the tracking error does not count for what lies below: of a
        descent, and of a UAV that is called back there, which begins its climb from wherever it is within the error.
    roof, foot_roof
        z of the highest roof that lies below `bottom`, and below `foot`, metres.
    """

    place: Floats
    foot: float
    low: float
    bottom: float
    column: float
    climb: float
    roof: float
    foot_roof: float


def destination(scenario: Scenario, space: ReturnSpace, plan: FlightPlan, place: Floats, foot: float) -> Destination:
    """Return a place (3,) to land at, with its columns, which end as low as a UAV may stray or be beside its descent.

    There is no column where the ground is steeper than 45 degrees within the tracking error: that is a wall beside it.
    `foot` is z at which the flight is above it, metres, or the place itself where nobody lands.
    """
    error, clearance = scenario.uavs[plan.route.uav].tracking_error, scenario.clearance
    acceptance = ACCEPTANCE[plan.autopilot.name]
    low = min(float(place[2]) + max(clearance, scenario.ground_clearance), foot)
    bottom = min(float(place[2]) + clearance, low)
    roofs = bottom - clearance, foot - clearance

    def top(error: TrackingError, beside: float) -> float:
        if is_wall_within(scenario.terrain, place[:2], error.horizontal) or (error == NO_ERROR and not beside):
            return low
        highest = clearance + error.horizontal + error.vertical + beside
        levels = low + np.append(np.arange(0.0, highest, COLUMN_STEP), highest)
        points = np.column_stack([np.tile(place[:2], (len(levels), 1)), levels])
        none, all_ = np.zeros(len(levels)), np.ones(len(levels), dtype=np.bool_)
        off = none + MAVLINK_ROUNDING
        lax = np.tile([beside, 0.0], (len(levels), 1))
        lines = ReturnLines(
            points, points, off, off, off, points, points, all_ * Ground.RULES, all_, none - np.inf, lax
        )
        free = space.free(lines, error)
        return float(levels[np.argmax(free)]) if free.any() else low

    off_path = TrackingError(horizontal=2 * error.horizontal, vertical=error.vertical)
    columns = top(error, acceptance.radius), top(off_path, 0.0)
    return Destination(place, foot, low, bottom, *columns, *roofs)


def rally_points(scenario: Scenario, plan: FlightPlan, places: Floats, altitude: float) -> Floats:
    """Return rally points as files have them, (k, 3) metres, for the places (k, 3) where a UAV lands.

    PX4 returns at the return altitude, metres above home, above where it lands. ArduPilot counts it from home, but
    returns at the altitude of the rally point if that is higher, and lands there all the same. It keeps altitudes of
    rally points in whole metres above home: there a rally point stands at the next such altitude, to a millimetre.
    """
    if plan.autopilot.name != "ardupilot" or not len(places):
        return places
    points = places + np.array([0.0, 0.0, altitude])
    above = global_positions(scenario, plan.route.uav, points, "home", plan.home).altitude
    points[:, 2] += np.ceil(above - WHOLE_METRES) - above
    return points


def rally_rows(scenario: Scenario, plan: FlightPlan, points: Floats) -> list[tuple[float, float, float]]:
    """Return latitude, longitude and metres above home of rally points (k, 3); for ArduPilot in whole metres."""
    rows = global_positions(scenario, plan.route.uav, points, "home", plan.home).rows
    if plan.autopilot.name == "ardupilot":
        return [(latitude, longitude, float(round(altitude))) for latitude, longitude, altitude in rows]
    return rows


def return_levels(scenario: Scenario, plan: FlightPlan, places: Floats, altitude: float) -> Floats:
    """Return z at which a UAV below it returns to each place (k, 3), home first, at an altitude above home; metres.

    DJI's aircraft count the return altitude from home; for the others see `rally_points`.
    """
    level = float(plan.home[2]) + altitude
    if plan.autopilot.name == "px4":
        return np.asarray(places[:, 2] + altitude)
    return np.maximum(level, np.r_[level, rally_points(scenario, plan, places[1:], altitude)[:, 2]])


def may_be_taken(scenario: Scenario, autopilot: Autopilot, away: Floats, doubt: Floats) -> NDArray[np.bool_]:
    """Tell which destinations an autopilot may return to from each of some places, (n, k).

    It takes the nearest as it reckons distances, PX4 one that is up to `NEARER_BY` farther.

    Parameters
    ----------
    scenario, autopilot
        What is given.
    away
        (n, k) metres from places of the flight to each destination.
    doubt
        (n,) metres by which the UAV may be beside each place.
    """
    wrong = away * reckoning_error(scenario, away) + 2 * MAVLINK_ROUNDING
    nearest = (away + wrong).min(axis=1) + NEARER_BY[autopilot.name] + 2 * doubt
    return np.asarray(away - wrong <= nearest[:, None] + SAME_PLACE)


def reckoning_error(scenario: Scenario, away: Floats) -> Floats:
    """Return the share by which an autopilot may reckon distances `away` wrong, metres.

    PX4 1.14 takes a degree of longitude to be everywhere as long as it is where the UAV is.
    """
    origin = scenario.frame.origin
    steepness = 0.0 if origin is None else abs(math.tan(math.radians(origin.latitude)))
    return np.minimum(DISTANCE_ERROR + 1.1 * away * steepness / LEAST_RADIUS, 1.0)


def far_enough_from_home(scenario: Scenario, home: Floats, place: Floats) -> bool:
    """Tell whether PX4 does not ignore a rally point at a place because it is near home."""
    away = np.linalg.norm((place - home)[None, :2], axis=1)
    least = away * (1 - reckoning_error(scenario, away)) - 2 * MAVLINK_ROUNDING
    return bool(least[0] > IGNORED_NEAR_HOME)
