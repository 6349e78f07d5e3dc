"""Missions for Litchi, an app for DJI's aircraft: the metric table (CSV) of its Mission Hub.

A table has places, speeds, stops and noses. What else an aircraft has to know, Litchi asks for when it is imported.

Sources: https://www.litchiutilities.com/docs/litchiCsv.php; DJI's Mobile SDK 4, `DJIWaypoint` and `DJIWaypointAction`,
for the ranges.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.camera_items import interval, spacing
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import global_positions
from skyverse.exports.mavlink_formats import FlightFile, wanted_heading
from skyverse.exports.report import MAX_TOLD
from skyverse.exports.separation import few
from skyverse.exports.verdicts import ExportedFleet
from skyverse.exports.wpml import part_positions, part_speeds, stay_at
from skyverse.model.arrays import arctan2
from skyverse.model.caution import Caution
from skyverse.model.uav import UAV
from skyverse.orders.litchi_files import MOST_ACTIONS
from skyverse.orders.places import written

NO_ACTION, STAY, TAKE_PHOTO = ("-1", "0"), "0", "1"
"""No action with its parameter; the action that stays for some milliseconds; and that which takes a photo."""
LONGEST_STAY = 32.0
"""Seconds of one action."""
ALTITUDES = (-200.0, 500.0)
"""Metres above the take-off, or above ground."""
LEGS = (0.5, 2000.0)
"""Metres between two waypoints."""
ALTITUDE_MODES = {"home": "0", "agl": "1"}
GIMBAL_OFF, GIMBAL_AT_PLACE, GIMBAL_HELD = "0", "1", "2"
FINISH_ACTIONS = {"loiter": "None", "land": "Land", "rtl": "RTH"}
HEADER = ",".join(
    (
        "latitude,longitude,altitude(m),heading(deg),curvesize(m),rotationdir,gimbalmode,gimbalpitchangle",
        *(f"actiontype{k},actionparam{k}" for k in range(1, MOST_ACTIONS + 1)),
        "altitudemode,speed(m/s),poi_latitude,poi_longitude,poi_altitude(m),poi_altitudemode",
        "photo_timeinterval,photo_distinterval",
    )
)


def litchi_text(file: FlightFile) -> str:
    """Return a ``.litchi.csv`` text for a part of a plan's waypoints; raise `InputError` where Litchi takes none."""
    scenario, plan = file.scenario, file.plan
    vehicle, points, at = scenario.uavs[plan.route.uav], plan.waypoints[file.part], part_positions(file)
    _require_ranges(plan.route.name(scenario), points, at.altitude)
    mode, gimbal, place = ALTITUDE_MODES[file.reference], GIMBAL_OFF, "0,0,0"
    if vehicle.look_at is not None:
        looked_at = global_positions(scenario, plan.route.uav, np.array([vehicle.look_at]), file.reference).rows[0]
        gimbal, place = GIMBAL_AT_PLACE, ",".join(written(one, 9) for one in looked_at)
    rows = [HEADER]
    wanted = [wanted_heading(scenario, plan, k) for k in file.part]
    usual = _headings(points, vehicle)
    headings = [one if told is None else told for one, told in zip(usual, wanted, strict=True)]
    for k, (where, heading, speed) in enumerate(zip(at.rows, headings, part_speeds(file), strict=True)):
        numbers = ",".join(written(one, 9) for one in (*where, heading))
        photographed = any(run.standing_at(file.part[k]) for run in plan.route.runs)
        acts = ",".join(_acts(plan.route.name(scenario), stay_at(file, k), photographed))
        pitch, apart = _camera(plan, file.part[k])
        looks = f"{gimbal},0" if pitch is None else f"{GIMBAL_HELD},{written(pitch, 3)}"
        rows.append(f"{numbers},0,0,{looks},{acts},{mode},{written(speed, 9)},{place},{mode},{apart}")
    return "\n".join(rows) + "\n"


def _require_ranges(name: str, points: Floats, altitudes: Floats) -> None:
    """Raise `InputError` for waypoints that DJI's aircraft refuse."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    for what, values, (least, most) in (("altitudes", altitudes, ALTITUDES), ("legs", legs, LEGS)):
        wrong = values[(values < least) | (values > most)]
        if len(wrong):
            raise InputError(f"{name}: Litchi takes {what} of {least:g} to {most:g} m, and one has {wrong[0]:.4g} m")


def _headings(points: Floats, vehicle: UAV) -> list[float]:
    """Return where the nose points at waypoints (n, 3), degrees clockwise from north: by default along the next leg."""
    if vehicle.heading is not None:
        return [vehicle.heading] * len(points)
    legs = np.diff(points, axis=0)
    ways = np.concatenate([legs, legs[-1:]]) if vehicle.look_at is None else np.array(vehicle.look_at) - points
    headings: list[float] = (np.degrees(arctan2(ways[:, 0], ways[:, 1])) % 360.0).tolist()
    return headings


def _camera(plan: FlightPlan, k: int) -> tuple[float | None, str]:
    """Return where the camera looks at waypoint k, if that is told, and the columns of the photos on the leg after it.

    An interval holds from its waypoint to the next one.
    """
    own = [run for run in plan.route.runs if run.on - 1 <= k <= run.off]
    pitch = next((run.pitch for run in own if run.on <= k), own[0].pitch if own else None)
    taken = next((run for run in own if run.on <= k < run.off), None)
    if taken is None:
        return pitch, "-1,-1"
    if taken.trigger == "time":
        return pitch, f"{written(interval(plan, taken), 3)},-1"
    return pitch, f"-1,{written(spacing(plan, taken), 3)}"


def _acts(name: str, seconds: float, photo: bool) -> list[str]:
    """Return the actions of a waypoint where a UAV stays for some seconds, then photographs: kinds and parameters."""
    count, last = math.ceil(seconds / LONGEST_STAY), [TAKE_PHOTO, "0"] * photo
    if count + photo > MOST_ACTIONS:
        raise InputError(
            f"{name}: Litchi lets it wait {MOST_ACTIONS * LONGEST_STAY:g} s at most at a waypoint, and it is to depart "
            f"after {seconds:.4g} s"
        )
    stay = [STAY, str(round(1000.0 * seconds / count))] if count else []
    return stay * count + last + [*NO_ACTION] * (MOST_ACTIONS - count - photo)


def litchi_settings(fleet: ExportedFleet) -> str:
    """Return what a pilot has to set in Litchi, as its tables do not say it."""
    returns = [
        f"{back.altitude:.4g} m for {fleet.name(plan)}"
        for plan, back in zip(fleet.plans, fleet.returns, strict=True)
        if back is not None
    ]
    ends = [
        FINISH_ACTIONS[end] + ("" if len(named) == len(fleet.plans) else f" for {few(named, MAX_TOLD)}")
        for end in FINISH_ACTIONS
        if (named := [fleet.name(plan) for plan in fleet.plans if plan.end == end])
    ]
    return (
        f"{Caution.BEFORE} each flight, set in Litchi what its tables do not say: path mode Straight Lines; heading "
        f"mode Custom where a UAV has look_at or heading, else Auto; finish action {', '.join(ends)} "
        f"after the last table of a UAV, None after others; return height {few(returns, MAX_TOLD)}."
    )
