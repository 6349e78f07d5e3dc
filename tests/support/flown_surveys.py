"""Missions of surveys made by hand, and photos taken by autopilots that follow exported files, by other code."""

import csv
import io
import json
import math
import re
import zipfile
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

import skyverse as sky
from proj_map import proj_local
from skyverse.model.sortie import Sortie, Strip, Visit
from skyverse.model.trajectory import Trajectory

ORIGIN = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0, geoid=48.0)
POLL = {"px4": 0.05, "ardupilot": 0.02, "dji": 0.0}
"""Seconds between two looks at the distance: of PX4's `CameraTrigger::Run` and of ArduPilot's `AP_Camera::update`."""
ORDER = 12
"""By how many photos the numbers of one that is taken and one that is planned may differ."""
LEFT_OUT = 4.0
"""Metres that a photo counts which is not planned, or not taken."""
GUSTS = 0.03
"""Share by which the speed comes and goes."""
CORNER = 2.0
"""m/s at which autopilots are taken to turn at sharp corners."""


def surveyed(lines, *, every=15.0, speed=8.0, home=(-40.0, -40.0, 5.0), pitch=-90.0, heading=None, **fields):
    """A mission of one UAV that takes photos along lines, (k, 3) metres each, at rest at each of their corners."""
    lines = [np.asarray(line, dtype=float) for line in lines]
    target = np.array([home[0], home[1], float(lines[0][0, 2])])
    corners, spans = [np.array(home), target], []
    for line in lines:
        spans.append((len(corners), len(corners) + len(line) - 1))
        corners += [*line]
    corners += [target, np.array(home)]
    knots, rows = [0.0], []
    for a, b in pairwise(corners):
        seconds = max(1.875 * float(np.linalg.norm(b - a)) / speed, 2.0)
        row = np.zeros((6, 3))
        row[0] = a
        for power, share in ((3, 10.0), (4, -15.0), (5, 6.0)):
            row[power] = share * (b - a) / seconds**power
        rows.append(row)
        knots.append(knots[-1] + seconds)
    strips = []
    for line, (a, b) in zip(lines, spans, strict=True):
        way = float(np.hypot(*np.diff(line[:, :2], axis=0).T).sum())
        apart = way / max(round(way / every), 1) if len(line) > 1 else 0.0
        strips.append(Strip(0, knots[a], knots[b], apart, pitch, heading))
    trajectory = Trajectory(np.array(knots), np.array(rows))
    places = np.concatenate(lines)[:, :2]
    (x0, y0), (x1, y1) = places.min(axis=0) - 20.0, places.max(axis=0) + 20.0
    trigger = fields.pop("trigger", "distance")
    limits = {"max_speed": 12.0, "max_acceleration": 6.0} | fields.pop("limits", {})
    scenario = sky.Scenario(
        **{
            "name": "photos",
            "bounds": sky.Bounds(min=(-400.0, -400.0, 0.0), max=(1400.0, 1400.0, 300.0)),
            "clearance": 0.0,
            "lattice": sky.Lattice(step=(50.0, 50.0, 50.0)),
            "uavs": (sky.UAV(name="uav-1", start=home, end="home", home=home[2], **limits),),
            "targets": (sky.Target(position=tuple(target.tolist())),),
            "surveys": (
                sky.Survey(
                    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], "mavic-3e", height=60.0, trigger=trigger, gimbal=pitch
                ),
            ),
            "frame": sky.Frame(origin=ORIGIN),
        }
        | fields
    )
    sortie = Sortie(0.0, knots[-1], (Visit(0, knots[1], knots[1]),), tuple(strips))
    made = sky.Provenance("", "by hand", "", 0, "")
    return sky.Mission(scenario, (0,), (None,), (trajectory,), (), made, sorties=((sortie,),))


@dataclass
class Step:
    """One thing that a file tells: a place to fly to, or what the camera does there.

    A place is reached within its radius; with `up` that is level, and another one upwards.
    """

    kind: str
    place: np.ndarray = field(default_factory=lambda: np.zeros(3))
    radius: float = 0.0
    up: float | None = None
    hold: float = 0.0
    speed: float = 5.0
    stops: bool = False
    numbers: tuple = ()


def flat(items):
    """The simple items of a plan, those that complex items have stored among them."""
    for item in items:
        yield from [item] if item["type"] == "SimpleItem" else flat(item["TransectStyleComplexItem"]["Items"])


def of_mavlink(rows, up, radius=None):
    """Steps from (command, seven numbers) with altitudes above the sea; Copter has one radius for all waypoints."""
    made, speed = [], 5.0
    for command, *numbers in rows:
        p = [0.0 if one is None or math.isnan(one) else float(one) for one in numbers]
        if command == 178:
            speed = p[1]
        elif command in (16, 22):
            place = proj_local(ORIGIN, [p[4]], [p[5]], [p[6]])[0]
            near = 0.0 if command == 22 else radius if radius is not None else p[1]
            hold = p[0] if command == 16 else 0.0
            made.append(Step("fly", place, near, up, hold, speed, hold > 0 or command == 22))
        elif command in (203, 205, 206, 530, 2000, 2001):
            made.append(Step(str(command), numbers=tuple(p)))
    fly = [step for step in made if step.kind == "fly"]
    fly[-1].stops = True
    return made


def steps_of(path, beside, ground=5.0):
    """Steps of a file, and the autopilot that flies it.

    `beside` is the text of its parameter file, `ground` the height of what the UAV takes off from.
    """
    name = path.name
    if name.endswith(".plan"):
        told = re.search(r"NAV_MC_ALT_RAD\t([\d.]+)", beside)  # aeroplanes have none
        up = float(told[1]) if told else math.inf
        items = flat(json.loads(path.read_text())["mission"]["items"])
        return of_mavlink([(one["command"], *one["params"]) for one in items], up), "px4"
    if name.endswith(".waypoints"):
        told = re.search(r"WP_RADIUS_M,([\d.]+)", beside)  # aeroplanes have that of each item
        radius = float(told[1]) if told else None
        rows = [line.split("\t") for line in path.read_text().splitlines()[2:]]
        return of_mavlink([(int(row[3]), *map(float, row[4:11])) for row in rows], None, radius), "ardupilot"
    return (of_wpml(path) if name.endswith(".kmz") else of_litchi(path, ground)), "dji"


def of_wpml(path):
    """Steps of waylines: the photos of a group are switched on at its first waypoint, off at its last one."""
    with zipfile.ZipFile(path) as archive:
        text = archive.read("wpmz/waylines.wpml").decode()
    marks = text.split("<Placemark>")[1:]

    def one(pattern, mark):
        found = re.search(rf"wpml:{pattern}>(.*?)<", mark)
        return found and found[1]

    speeds = [float(one("waypointSpeed", mark)) for mark in marks]
    made, off = [], {}
    for k, mark in enumerate(marks):
        longitude, latitude = map(float, re.search(r"<coordinates>(.*?)<", mark)[1].split(","))
        sea = float(one("executeHeight", mark)) - ORIGIN.geoid
        place, mode = proj_local(ORIGIN, [latitude], [longitude], [sea])[0], one("waypointTurnMode", mark)
        early = float(one("waypointTurnDampingDist", mark)) if mode == "coordinateTurn" else 0.02
        hold = float(one("hoverTime", mark) or 0.0)
        made.append(Step("fly", place, early, None, hold, speeds[max(k - 1, 0)], mode.startswith("toPointAndStop")))
        made += [Step("206", numbers=(0.0, 0.0, 0.0)), Step("2001")] * off.pop(k, 0)
        for group in mark.split("<wpml:actionGroup>")[1:]:
            name, trigger = one("actionActuatorFunc", group), one("actionTriggerType", group)
            if name == "gimbalRotate":
                made.append(Step("205", numbers=(float(one("gimbalPitchRotateAngle", group)),)))
            if name != "takePhoto":
                continue
            assert int(one("actionGroupStartIndex", group)) == k
            if trigger == "reachPoint":
                made.append(Step("203"))
                continue
            last, step = int(one("actionGroupEndIndex", group)), float(one("actionTriggerParam", group))
            off[last] = 1
            by_time = trigger == "multipleTiming"
            made.append(Step("2000", numbers=(0.0, step, 0.0)) if by_time else Step("206", numbers=(step, 0.0, 1.0)))
    return made


def of_litchi(path, ground):
    """Steps of a table for Litchi: it stops at every waypoint; equal intervals are taken to go on without a break."""
    made, told = [], 0.0
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    before = 5.0
    for row in rows:
        above = float(row["altitude(m)"]) + ORIGIN.altitude
        place = proj_local(ORIGIN, [float(row["latitude"])], [float(row["longitude"])], [above + ground])[0]
        made.append(Step("fly", place, 0.0, None, 0.0, before, True))
        before = float(row["speed(m/s)"])
        made.append(Step("205", numbers=(float(row["gimbalpitchangle"]),)))
        spacing, seconds = float(row["photo_distinterval"]), float(row["photo_timeinterval"])
        if spacing != told:
            made.append(Step("206", numbers=(max(spacing, 0.0), 0.0, 1.0)))
        told = spacing
        if seconds > 0:
            made.append(Step("2000", numbers=(0.0, seconds, 0.0)))
        made += [Step("203")] * sum(row[f"actiontype{k}"] == "1" for k in range(1, 16))
    return made


class Flight:
    """An autopilot that follows steps, with ramps of speed, and takes photos by its own rule."""

    def __init__(self, steps, home, *, acceleration=2.5, late=0.0, poll=0.0):
        self.steps, self.at = steps, np.array(home, dtype=float)
        self.acceleration, self.late, self.poll = acceleration, late, poll
        self.photos, self.distance, self.last, self.pitch = [], 0.0, None, 0.0
        self.interval, self.count, self.next, self.now, self.looked = 0.0, 0, 0.0, 0.0, 0.0

    def shoot(self):
        self.photos.append((*self.at, self.pitch))
        self.last = self.at[:2].copy()

    def told(self, step):
        p = step.numbers
        if step.kind == "205":
            self.pitch = p[0]
        elif step.kind == "203":
            self.shoot()
        elif step.kind == "206":
            self.distance, self.last = p[0], self.at[:2].copy()
            if p[2]:
                self.shoot() if p[0] else None
        elif step.kind == "2000":
            self.interval, self.count, self.next = p[1], p[2] or math.inf, self.now
        elif step.kind == "2001":
            self.interval = 0.0

    def moved(self, seconds):
        self.now += seconds
        looks = self.now - self.looked >= self.poll
        if looks:
            self.looked = self.now
        if self.distance and looks and math.dist(self.at[:2], self.last) >= self.distance:
            self.shoot()
        while self.interval and self.count > 0 and self.now >= self.next:
            self.shoot()
            self.count, self.next = self.count - 1, self.next + self.interval

    def run(self):
        """Fly all, and return the photos, (n, 4): metres, and where the camera looks."""
        places = [step for step in self.steps if step.kind == "fly"]
        pace, number = 0.0, 0
        for step in self.steps:
            if step.kind != "fly":
                self.told(step)
                continue
            after = places[number + 1].place if number + 1 < len(places) else None
            number += 1
            corner = 0.0 if step.stops or after is None else self.corner(step.place, after)
            while True:
                way = step.place - self.at
                level, length = math.hypot(*way[:2]), math.hypot(*way)
                near = 0.02 if step.stops else max(step.radius * (1.0 - self.late), 0.02)
                if length <= near if step.up is None else (level <= near and abs(way[2]) <= step.up) or length <= 0.02:
                    break
                most = min(step.speed, math.sqrt(2 * self.acceleration * max(length - near, 0.0) + corner**2) + 0.05)
                seconds = min(0.005, 0.02 / max(pace, 0.1)) if not self.poll else self.poll / 5
                pace = min(pace + self.acceleration * seconds, most)
                gust = 1.0 + GUSTS * math.sin(1.7 * self.now)
                self.at = self.at + way / length * min(pace * gust * seconds, length)
                self.moved(seconds)
            if step.stops:
                pace = 0.0
                self.now += step.hold
        return np.array(self.photos).reshape(-1, 4)

    def corner(self, to, after):
        """The speed at a waypoint: slow unless the way leads straight on."""
        a, b = to - self.at, after - to
        size = math.hypot(*a) * math.hypot(*b)
        return math.inf if size and float(a @ b) > 0.9 * size else CORNER


def planned(file):
    """The expected photos in the table beside a file: (n, 3) metres, pitches (n,), and the numbers of strips (n,)."""
    stem = re.sub(r"\.(plan|waypoints|wpml\.kmz|litchi\.csv)$", "", file.name)
    rows = list(csv.DictReader(io.StringIO((file.parent / f"{stem}.photos.csv").read_text())))
    columns = [[float(row[name]) for row in rows] for name in ("latitude", "longitude", "altitude_amsl_m")]
    pitch = np.array([float(row["pitch_deg"]) for row in rows])
    return proj_local(ORIGIN, *columns), pitch, np.array([int(row["strip"]) for row in rows])


def matched(taken, places):
    """For each photo taken the number of the planned one that it is, or -1: both come in their order.

    Of all ways to leave some out and to match the others in order, the one of the fewest metres (Needleman, Wunsch).
    """
    apart = np.linalg.norm(taken[:, None, :3] - places, axis=2)
    n, m = apart.shape
    best, came = np.full((n + 1, m + 1), np.inf), np.zeros((n + 1, m + 1), dtype=int)
    best[0, 0] = 0.0
    for i in range(n + 1):
        for j in range(max(i - ORDER, 0), min(i + ORDER, m) + 1):
            ways = (
                best[i - 1, j - 1] + apart[i - 1, j - 1] if i and j else np.inf,
                best[i - 1, j] + LEFT_OUT if i else np.inf,
                best[i, j - 1] + LEFT_OUT if j else np.inf,
            )
            if i or j:
                came[i, j] = int(np.argmin(ways))
                best[i, j] = ways[came[i, j]]
    found, i, j = np.full(n, -1), n, m
    while i or j:
        way = came[i, j]
        i, j = i - (way != 2), j - (way != 1)
        if way == 0:
            found[i] = j
    return found


def compared(taken, places, strips):
    """Metres that each planned photo is off, differences of counts on strips, and what is matched; see `matched`."""
    own = matched(taken, places)
    off = np.array([np.linalg.norm(taken[:, :3] - place, axis=1).min() for place in places])  # for those not taken
    off[own[own >= 0]] = np.linalg.norm(taken[own >= 0, :3] - places[own[own >= 0]], axis=1)
    last = np.maximum.accumulate(np.where(own < 0, 0, own))  # one that is not planned is of the strip of the one before
    return off, [int((strips[last] == k).sum() - (strips == k).sum()) for k in np.unique(strips)], own


def differences(file, home, beside="", **how):
    """How a flight of a file takes the photos that are planned.

    Metres of the farthest planned photo, the largest difference of counts on a strip, photos that are not planned, and
    photos with another pitch.
    """
    steps, name = steps_of(file, beside, home[2])
    taken = Flight(steps, home, poll=POLL[name], **how).run()
    places, pitch, strips = planned(file)
    off, counts, own = compared(taken, places, strips)
    turned = np.abs(taken[:, 3] - pitch[own])[own >= 0] > 0.1
    return off.max(), int(np.abs(counts).max()), int((own < 0).sum()), int(turned.sum())
