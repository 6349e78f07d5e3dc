"""An autopilot that flies exported files, read from their text: small steps of time, and no code of the exporter."""

import json
import math
import re
import zipfile
from dataclasses import dataclass, field

import numpy as np
from handmade_exports import local

STEP = 0.02


@dataclass
class Takeoff:
    """How an autopilot takes off: seconds until its motors may lift it and until it rises, and m/s^2 from there on."""

    spool_up: float = 0.0
    startup: float = 0.0
    acceleration: float = math.inf


@dataclass
class Orders:
    """What files tell an autopilot: places in local metres, in order, with speeds, radii and seconds to stay.

    `px4` are the parameters of a `.params` file: with them it goes on, accelerates and takes off as PX4 does.
    """

    home: np.ndarray
    delay: float = 0.0
    places: list = field(default_factory=list)
    speeds: list = field(default_factory=list)
    radii: list = field(default_factory=list)
    stays: list = field(default_factory=list)
    stops: bool = False
    land: float | None = None
    px4: dict = field(default_factory=dict)

    def takeoff(self, slowness=1.0):
        """How it takes off: 1 as by default, 0 at once, and in between and above in proportion."""
        if not slowness:
            return Takeoff()
        if self.stops:  # DJI's, an assumption
            return Takeoff(0.0, 2.0 * slowness, 2.5 / slowness)
        if not self.px4:  # ArduPilot: MOT_SPOOL_TIME, TKOFF_SLEW_TIME up to hover, and WPNAV_ACCEL_Z
            return Takeoff(0.0, (0.5 + 0.35 * 2.0) * slowness, 1.0 / slowness)
        acceleration = self.px4["MPC_TKO_SPEED"] / (self.px4["MPC_TKO_RAMP_T"] * slowness)
        return Takeoff(slowness, 0.7 / acceleration, acceleration)  # COM_SPOOLUP_TIME is 1 s

    def near(self, k, level, up):
        """Whether the autopilot counts a place as reached, that far beside and so many metres above it."""
        if not self.px4:
            return math.hypot(level, up) <= self.radii[k]
        above = self.px4["NAV_MC_ALT_RAD"]
        if k == 0:
            return up <= above
        return level <= (self.radii[k] or self.px4["NAV_ACC_RAD"]) and abs(up) <= above


def of_commands(origin, home, rows, sea):
    """Orders from (command, p1, p2, latitude, longitude, altitude) of MAVLink; `sea` is added to altitudes."""
    made, speed = Orders(local(origin, *[[v] for v in home])[0]), 5.0
    for command, p1, p2, latitude, longitude, altitude in rows:
        if command == 93:
            made.delay = p1
        elif command == 178:
            speed = p2
        elif command in (16, 22):
            place = local(origin, [latitude], [longitude], [altitude + sea])[0]
            made.places.append(place)
            made.speeds.append(speed)
            made.radii.append(p2 if command == 16 else 0.0)
            made.stays.append(p1 if command == 16 else 0.0)
        elif command == 21:
            made.land = altitude + home[2] - origin.altitude
    return made


def read_waypoints(text, origin, sea=None):
    rows = [line.split("\t") for line in text.splitlines()[1:]]
    home = tuple(map(float, rows[0][8:11]))
    above = home[2] if rows[1:] and {row[2] for row in rows[1:]} & {"3"} and sea is None else 0.0
    commands = [(int(r[3]), float(r[4]), float(r[5]), *map(float, r[8:11])) for r in rows[1:]]
    return of_commands(origin, home, commands, above)


def read_plan(text, origin):
    mission = json.loads(text)["mission"]
    home = mission["plannedHomePosition"]
    above = home[2] if mission["globalPlanAltitudeMode"] == 1 else 0.0
    rows = [(i["command"], *i["params"][:2], *i["params"][4:]) for i in mission["items"]]
    return of_commands(origin, home, rows, above)


def read_parameters(text):
    """The values of a `.params` file."""
    rows = [row.split("\t") for row in text.splitlines() if row[0] != "#"]
    return {row[2]: float(row[3]) for row in rows}


def read_wpml(path, origin, home, above):
    with zipfile.ZipFile(path) as archive:
        text = archive.read("wpmz/waylines.wpml").decode()
    made = Orders(np.array(home), stops=True)
    for mark in text.split("<Placemark>")[1:]:
        longitude, latitude = map(float, re.search(r"<coordinates>(.*?)<", mark)[1].split(","))
        height = float(re.search(r"executeHeight>(.*?)<", mark)[1])
        made.places.append(local(origin, [latitude], [longitude], [height + above])[0])
        made.speeds.append(float(re.search(r"waypointSpeed>(.*?)<", mark)[1]))
        hover = re.search(r"hoverTime>(.*?)<", mark)
        made.stays.append(float(hover[1]) if hover else 0.0)
        made.radii.append(0.0)
    made.speeds = [made.speeds[0], *made.speeds[:-1]]  # a waypoint's speed is that of the leg after it
    return made


def fly(orders, climb, descent, factor, slowness=1.0, braking=2.5, until=10_000.0):
    """Positions every `STEP` seconds: straight to each place, turning near it, at rest where it stays.

    PX4 counts the seconds to stay from when it is near, and meanwhile flies on to the place.
    """
    x, y, z = orders.home.tolist()
    takeoff, px4 = orders.takeoff(slowness), bool(orders.px4)
    braking = orders.px4.get("MPC_ACC_HOR", braking)
    track = [(x, y, z)] * round((max(orders.delay, takeoff.spool_up) + takeoff.startup) / STEP)
    legs = zip(orders.places, orders.speeds, orders.stays, strict=True)
    pace = 0.0
    for k, (place, speed, stay) in enumerate(legs):
        last = k == len(orders.places) - 1
        rest = orders.stops or stay > 0 or last or (k == 0 and not px4)
        gain = braking if k else takeoff.acceleration
        if orders.stops or k == 1:
            pace = 0.0
        to, left = place.tolist(), stay
        while True:
            east, north, up = to[0] - x, to[1] - y, to[2] - z
            level = math.hypot(east, north)
            length = math.hypot(level, up)
            near = left < stay or orders.near(k, level, up)
            if px4 and stay and near:
                left -= STEP
            if length < 1e-9 or left < 0 or (near and not rest) or len(track) * STEP > until:
                break
            most = speed * factor * length / level if level > 1e-9 else math.inf
            if up:
                most = min(most, (climb if up > 0 else descent) * length / abs(up))
            pace = min(pace + gain * STEP, most)
            most = min(pace, math.sqrt(2 * gain * length) + 0.01) if rest or k == 0 else pace
            share = min(most * STEP / length, 1.0)
            x, y, z = x + share * east, y + share * north, z + share * up
            track.append((x, y, z))
        track += [(x, y, z)] * round(max(left, 0.0) / STEP)
    if orders.land is not None:
        track += [(x, y, low) for low in np.arange(z, orders.land, -descent * STEP)]
    return np.array(track)


def nearness(tracks, i, j, across, above):
    """The least distance of two tracks in units of their separation; each stays where it ended."""
    count = max(len(tracks[i]), len(tracks[j]))
    a, b = (np.concatenate([t, np.repeat(t[-1:], count - len(t), axis=0)]) for t in (tracks[i], tracks[j]))
    return float(np.linalg.norm((a - b) / [across, across, above], axis=1).min())
