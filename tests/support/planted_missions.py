"""Random missions as files of ground stations, with one planted fault each or none, and which of their items are wrong.

How a mission is flown, and what it meets, is worked out here once more, by dense samples; see `planted_worlds`.
"""

import itertools
import json
import math
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from shapely.geometry import MultiPoint, Polygon, box
from shapely.ops import unary_union

from planted_worlds import Floats, PlantedWorld, random_world, sampled

FAULTS = ("ridge", "building", "zone", "fence", "high", "home", "frame", "radius", "return", "conflict")
TAKEOFF, WAYPOINT, TURNS, STAY, RETURN, LAND, DELAY, JUMP, SPEED, TRIGGER = 22, 16, 18, 19, 20, 21, 93, 177, 178, 206
SEA, HOME, GROUND = 0, 3, 10
"""MAV_FRAME of altitudes."""
LOW, HIGH_ROOM = 20.0, 15.0
"""Metres above ground, and below the ceiling, that a mission without a fault keeps."""
GEOID = 31.0
"""Metres that mean sea level lies above the ellipsoid, by the readers of DJI's files."""
Autopilot = Literal["px4", "ardupilot", "dji"]


class Item(NamedTuple):
    """A mission item: its first four numbers, and metres east and north of home and of altitude in its frame."""

    command: int
    numbers: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    frame: int = 2
    place: tuple[float, float, float] | None = None


class Line(NamedTuple):
    """A flown leg, (n, 3) samples, or what is flown around a corner, and the numbers of the items at it."""

    items: tuple[int, ...]
    points: Floats
    corner: bool = False


@dataclass
class Flight:
    """One mission: its items from number 1, where home is, local metres, and what its file and its pilot say."""

    autopilot: Autopilot
    items: list[Item]
    home: tuple[float, float] = (0.0, 0.0)
    told_home: float = 0.0
    """Metres by which the file's altitude of home is off."""
    level: float = 0.0
    """Metres above the sea at which it returns."""
    fence: Polygon | None = None

    @property
    def first(self) -> int:
        """The number of the first item, which is DJI's take-off."""
        return int(self.autopilot != "dji")

    def lines(self, world: PlantedWorld) -> list[Line]:
        """Return all that is flown, from the take-off to the last item that is not the end."""
        ground = float(world.ground(*self.home))
        here, _number, at, done = np.array([*self.home, ground]), 0, 0, set()
        places, numbers, radii, follows = [here], [0], [0.0], [False]
        while at < len(self.items):
            at, item = at + 1, self.items[at]
            number = at - 1 + self.first
            if item.command == JUMP and at not in done:
                done.add(at)
                at = int(item.numbers[0]) - 1
                continue
            if item.command == DELAY:  # it stops there
                radii[-1] = 0.0
            if item.command == LAND and item.place is not None:  # at the height that it has
                here = np.array([*item.place[:2], here[2]])
            elif item.place is None:
                continue
            elif item.command == TAKEOFF:
                here = np.array([*self.home, ground + item.place[2]])
            else:
                x, y, z = item.place
                here = np.array([x, y, z + {SEA: 0.0, HOME: ground, GROUND: float(world.ground(x, y))}[item.frame]])
            if item.command == TURNS:
                angle = np.arctan2(*(places[-1] - here)[1::-1]) + np.linspace(0, 2 * np.pi, 73)
                for one in angle:
                    edge = abs(item.numbers[2]) * np.array([np.cos(one), np.sin(one), 0.0])
                    places.append(here + edge), numbers.append(number), radii.append(0.0), follows.append(False)
            (
                places.append(here),
                numbers.append(number),
                follows.append(item.frame == GROUND and item.command == WAYPOINT),
            )
            stops = item.command != WAYPOINT or item.numbers[0] > 0
            own = {"px4": item.numbers[1] or 2.0, "dji": item.numbers[1]}.get(self.autopilot, 2.0)
            radii.append(0.0 if stops else own)
        made = []
        for k in range(1, len(places)):
            points = sampled(places[k - 1 : k + 1])
            if follows[k]:
                above = (one[2] - float(world.ground(*one[:2])) for one in places[k - 1 : k + 1])
                points[:, 2] = world.ground(*points[:, :2].T) + np.linspace(*above, len(points))
            made.append(Line(tuple(dict.fromkeys((numbers[k - 1], numbers[k]) if k > 1 else (numbers[k],))), points))
        for k in range(1, len(places) - 1):
            back, on = places[k - 1] - places[k], places[k + 1] - places[k]
            if radii[k] > 2.0 and not (follows[k] or follows[k + 1]):
                share = min(radii[k] / max(float(np.linalg.norm(back)), 1e-6), 1.0)
                around = [sampled([places[k] + s * share * back, places[k] + on]) for s in np.linspace(0, 1, 9)]
                made.append(Line((numbers[k],), np.concatenate(around), corner=True))
        return made

    def returns(self, world: PlantedWorld) -> Floats:
        """Return samples of all ways home: straight up, level, straight down."""
        flown = np.concatenate([line.points for line in self.lines(world)])[::6]
        ground, made = float(world.ground(*self.home)), []
        for x, y, z in flown:
            top = max(z, self.level)
            made += [sampled([[x, y, max(z, ground + 20)], [x, y, top], [*self.home, top]], 3.0)]
        return np.concatenate([*made, sampled([[*self.home, self.level], [*self.home, ground + 20.0]])])

    def fan(self, world: PlantedWorld) -> Any:
        """Return the area over which it may come home."""
        flown = np.concatenate([line.points for line in self.lines(world)])[::5, :2]
        return unary_union([Polygon([self.home, a, b]).buffer(0.5) for a, b in itertools.pairwise(flown)])

    def write(self, world: PlantedWorld, folder: Path, name: str) -> Path:
        """Write the file."""
        latitude, longitude = world.globe(*self.home)
        altitude = float(world.ground(*self.home)) + self.told_home
        rows = []
        for item in self.items:
            lat, lon, alt = 0.0, 0.0, 0.0
            if item.place is not None:
                (lat, lon), alt = world.globe(*item.place[:2]), item.place[2]
            rows.append([*item.numbers, round(float(lat), 9), round(float(lon), 9), round(alt, 3)])
        if self.autopilot == "dji":
            return self._write_waylines(rows, folder / f"{name}.kmz")
        if self.autopilot == "ardupilot":
            home = [0.0, 0.0, 0.0, 0.0, round(latitude, 9), round(longitude, 9), round(altitude, 3)]
            lines = [
                "\t".join(map(str, [k, int(k == 0), frame, command, *row, 1]))
                for k, (frame, command, row) in enumerate(
                    [(0, 16, home), *((i.frame, i.command, row) for i, row in zip(self.items, rows, strict=True))]
                )
            ]
            path = folder / f"{name}.waypoints"
            path.write_text("\n".join(["QGC WPL 110", *lines]) + "\n")
            return path
        items = [
            {"type": "SimpleItem", "autoContinue": True, "command": i.command, "frame": i.frame, "params": row,
             "doJumpId": k} for k, (i, row) in enumerate(zip(self.items, rows, strict=True), 1)
        ]  # fmt: skip
        mission = {"version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 5,
                   "items": items, "plannedHomePosition": [latitude, longitude, altitude]}  # fmt: skip
        rings = [] if self.fence is None else [np.column_stack(world.globe(*self.fence.exterior.xy)).tolist()[:-1]]
        fences = [{"inclusion": True, "version": 1, "polygon": ring} for ring in rings]
        plan = {"fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "mission": mission,
                "geoFence": {"version": 2, "circles": [], "polygons": fences},
                "rallyPoints": {"version": 2, "points": []}}  # fmt: skip
        path = folder / f"{name}.plan"
        path.write_text(json.dumps(plan))
        return path

    def _write_waylines(self, rows: list[list[float]], path: Path) -> Path:
        """Write DJI's archive: one wayline, whose heights all count from the take-off or from the ellipsoid."""
        marks, end = [], {RETURN: "goHome", LAND: "autoLand"}.get(self.items[-1].command, "noAction")
        for item, (seconds, radius, *_, lat, lon, alt) in zip(self.items, rows, strict=True):
            if item.command != WAYPOINT:
                continue
            mode = "WGS84" if item.frame == SEA else "relativeToStartPoint"
            turn = "coordinateTurn" if radius and not seconds else "toPointAndStopWithDiscontinuityCurvature"
            height = round(alt + GEOID * (item.frame == SEA), 3)
            marks.append(
                f"<Placemark><Point><coordinates>{lon},{lat}</coordinates></Point><wpml:index>{len(marks)}</wpml:index>"
                f"<wpml:executeHeight>{height}</wpml:executeHeight><wpml:waypointSpeed>5</wpml:waypointSpeed>"
                f"<wpml:waypointTurnParam><wpml:waypointTurnMode>{turn}</wpml:waypointTurnMode>"
                f"<wpml:waypointTurnDampingDist>{radius}</wpml:waypointTurnDampingDist></wpml:waypointTurnParam>"
                "<wpml:useStraightLine>1</wpml:useStraightLine></Placemark>"
            )
        text = (
            '<?xml version="1.0" encoding="UTF-8"?><kml xmlns="http://www.opengis.net/kml/2.2" '
            'xmlns:wpml="http://www.dji.com/wpmz/1.0.2"><Document><wpml:missionConfig>'
            "<wpml:flyToWaylineMode>pointToPoint</wpml:flyToWaylineMode>"
            f"<wpml:finishAction>{end}</wpml:finishAction>"
            f"<wpml:takeOffSecurityHeight>{rows[0][-1]}</wpml:takeOffSecurityHeight></wpml:missionConfig><Folder>"
            f"<wpml:templateId>0</wpml:templateId><wpml:executeHeightMode>{mode}</wpml:executeHeightMode>"
            "<wpml:waylineId>0</wpml:waylineId><wpml:autoFlightSpeed>5</wpml:autoFlightSpeed>"
            f"{''.join(marks)}</Folder></Document></kml>"
        )
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("wpmz/waylines.wpml", text)
        return path


@dataclass
class Case:
    """Missions over one world, and what is wrong with them."""

    world: PlantedWorld
    flights: list[Flight]
    fault: str | None = None
    planted: tuple[int, ...] = ()
    """The items at which the fault is."""
    more: dict[str, Any] = field(default_factory=dict)

    def with_(self, **changes: Any) -> "Case":
        """Return a changed copy, whose world can be changed further."""
        world = replace(self.world, heights=self.world.heights.copy(), solids=list(self.world.solids))
        world.corner = self.world.corner
        return replace(self, world=world, flights=[replace(f, items=list(f.items)) for f in self.flights], **changes)


class Retry(Exception):  # noqa: N818
    """What was drawn cannot be used."""


def _tour(rng: np.random.Generator, middle: Floats, radius: float, count: int) -> Iterator[Floats]:
    for _ in range(count):
        yield middle + radius * math.sqrt(rng.uniform()) * np.array([np.cos(a := rng.uniform(0, 7)), np.sin(a)])


def _strips(rng: np.random.Generator, middle: Floats, radius: float) -> Iterator[Floats]:
    count, angle = int(rng.integers(3, 9)), rng.uniform(0, 7)
    long, apart = rng.uniform(0.6, 1.2) * radius, min(rng.uniform(15, 60), 1.2 * radius / count)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    for k in range(count):
        for side in (-1, 1) if k % 2 else (1, -1):
            yield middle + side * long / 2 * along + (k - (count - 1) / 2) * apart * across


def _followed(world: PlantedWorld, places: list[Floats], above: list[float], least: float = 12.0) -> list[Floats]:
    """Return places with altitudes, and more between them, so that straight legs keep over ground and under ceiling."""
    made = [np.array([*p, float(world.ground(*p)) + h]) for p, h in zip(places, above, strict=True)]
    k = 0
    while k < len(made) - 1:
        gaps = world.gaps(sampled(made[k : k + 2], 2.0), surely=True)
        if gaps["ground"] >= LOW and gaps["ceiling"] >= HIGH_ROOM:
            k += 1
            continue
        a, b = made[k], made[k + 1]
        middle = (a[:2] + b[:2]) / 2
        if math.dist(a, b) < least or len(made) > 150:
            raise Retry
        height = np.mean([one[2] - float(world.ground(*one[:2])) for one in (a, b)])
        made.insert(k + 1, np.array([*middle, float(world.ground(*middle)) + height]))
    return made


def random_flight(
    rng: np.random.Generator,
    world: PlantedWorld,
    home: Floats,
    radius: float,
    autopilot: Autopilot,
    *,
    plain: bool = False,
) -> Flight:
    """Return a mission of items that is not wrong anywhere; a `plain` one has few, long legs."""
    strips = not plain and rng.uniform() < 0.5
    ground = float(world.ground(*home))
    middle = home + (0 if plain else 0.3) * radius * rng.uniform(-1, 1, 2)
    places = list(_strips(rng, middle, 0.7 * radius) if strips else
                  _tour(rng, middle, 0.7 * radius, int(rng.integers(4, 6 if plain else 10))))  # fmt: skip
    if any(math.dist(a, b) < (60 if plain else 12) for a, b in itertools.pairwise(places)):
        raise Retry
    most = world.max_height - 2 * HIGH_ROOM
    above = (
        [rng.uniform(35, min(60, most))] * len(places) if strips else list(rng.uniform(35, min(70, most), len(places)))
    )
    frame = int(rng.choice([SEA, HOME, GROUND] if autopilot == "ardupilot" else [SEA, HOME]))
    up = float(rng.uniform(25, 45))
    if frame == GROUND:
        routed = [np.array([*p, h]) for p, h in zip(places, above, strict=True)]
    else:
        routed = _followed(world, [home, *places], [up, *above])[1:]
    items = [Item(TAKEOFF, frame=HOME, place=(*home.tolist(), up))]
    if rng.uniform() < 0.3:
        items.append(Item(SPEED, (1.0, round(float(rng.uniform(3, 12)), 1), -1.0, 0.0)))
    if strips:
        items.append(Item(TRIGGER, (round(float(rng.uniform(5, 30)), 1), 0.0, 1.0, 0.0)))
    for one in routed:
        z = {SEA: one[2], HOME: one[2] - ground, GROUND: one[2]}[frame]
        numbers = [0.0, 0.0, 0.0, 0.0]
        if rng.uniform() < 0.15:
            numbers[0] = float(rng.integers(1, 20))
        if autopilot != "ardupilot" and rng.uniform() < 0.4:
            numbers[1] = float(rng.choice([1.0, 3.0, 5.0]))
        items.append(Item(WAYPOINT, tuple(numbers), frame, (*one[:2].tolist(), float(z))))  # type: ignore[arg-type]
        if rng.uniform() < 0.05 and not plain:
            items.append(Item(DELAY, (float(rng.integers(1, 9)), 0.0, 0.0, 0.0)))
    if strips:
        items.append(Item(TRIGGER))
    elif not plain and rng.uniform() < 0.3 and frame != GROUND:
        turns = autopilot == "ardupilot"
        place = items[-1].place or routed[-1]
        numbers = (1.0, 0.0, float(rng.integers(6, 25)), 0.0) if turns else (float(rng.integers(3, 30)), 0.0, 0.0, 0.0)
        items.append(Item(TURNS if turns else STAY, numbers, frame, place))
    if not plain and rng.uniform() < 0.2:
        items.append(Item(JUMP, (float(rng.integers(2, len(items) + 1)), 1.0, 0.0, 0.0)))
        if items[int(items[-1].numbers[0]) - 1].place is None:
            raise Retry
    end = rng.uniform()
    if end < 0.5:
        items.append(Item(RETURN))
    elif end < 0.75 and world.slope(*home) < 10:
        items.append(Item(LAND, frame=HOME, place=(*(home + rng.uniform(-4, 4, 2)).tolist(), 0.0)))
    if autopilot == "dji":
        items = [item for item in items if item.command in (TAKEOFF, WAYPOINT, RETURN)]
    flight = Flight(autopilot, items, (float(home[0]), float(home[1])))
    under = world.ground(*np.concatenate([line.points for line in flight.lines(world)])[:, :2].T)
    low, high = float(under.max()) + 35, float(under.min()) + world.max_height - 40
    low = max(low, ground + 25)
    if high < low:
        raise Retry
    flight.level = round(float(rng.uniform(low, min(high, low + 15))) - ground, 1) + ground
    for line in flight.lines(world):
        gaps = world.gaps(line.points, surely=True)
        if gaps["ceiling"] < HIGH_ROOM or (gaps["ground"] < LOW - 6 and line.items != (flight.first,)):
            raise Retry
    gaps = world.gaps(flight.returns(world), surely=False)
    if gaps["ground"] < LOW - 5 or gaps["ceiling"] < HIGH_ROOM:
        raise Retry
    return flight


def furnish(rng: np.random.Generator, case: Case, radius: float) -> None:
    """Put buildings, zones and a fence where they are in nobody's way."""
    world, flights = case.world, case.flights
    tracks = [line.points for flight in flights for line in flight.lines(world)]
    fans = unary_union([flight.fan(world) for flight in flights])
    low = min(flight.level for flight in flights)
    for k in range(int(rng.integers(3, 20))):
        x, y = rng.uniform(-radius, radius, 2)
        if k % 5:
            sizes = rng.uniform(4, 15, 2)
            outline = box(x - sizes[0], y - sizes[1], x + sizes[0], y + sizes[1])
            solid = world.solid("building", outline, round(float(rng.uniform(4, 30)), 1))
        else:
            angles = np.sort(rng.uniform(0, 2 * np.pi, 7))
            reach = rng.uniform(15, 70, 7)
            outline = MultiPoint(np.column_stack([x + reach * np.cos(angles), y + reach * np.sin(angles)])).convex_hull
            limits = [None, round(float(rng.uniform(low - 80, low + 100)), 1)]
            solid = world.solid("zone", outline, limits[int(rng.integers(2))], sea=True)
        if outline.distance(fans) < 14 and solid.most[1] > low - 14:
            continue
        before, world.solids = world.solids, [solid]
        if not any(world.doubt(track) & {"building", "zone"} for track in tracks):
            before = [*before, solid]
        world.solids = before
    for flight in flights:
        if flight.autopilot == "px4" and rng.uniform() < 0.4:
            own = np.concatenate([line.points for line in flight.lines(world)])[:, :2]
            hull = MultiPoint([*own, flight.home]).convex_hull
            flight.fence = hull.buffer(float(rng.uniform(15, 60)), quad_segs=4).simplify(0.05)


def unharmed(rng: np.random.Generator, *, plain: bool = False, two: bool = False, dji: bool = False) -> Case:
    """Return missions that are right by metres, of `dji` or of another autopilot."""
    while True:
        max_height = float(rng.choice([120.0, 120.0, 300.0]))
        radius = float(rng.uniform(120, 420))
        world = random_world(rng, (2.6 if two else 1.0) * radius, max_height)
        homes = [np.zeros(2)]
        if two:
            homes = [np.array([-1.1 * radius - 40, 0.0]), np.array([1.1 * radius + 40, 0.0])]
        autopilot: Autopilot = "px4" if rng.uniform() < 0.5 else "ardupilot"
        autopilot = "dji" if dji else autopilot
        for _ in range(4):
            try:
                flights = [random_flight(rng, world, home, radius, autopilot, plain=plain) for home in homes]
            except Retry:
                continue
            case = Case(world, flights)
            furnish(rng, case, radius)
            return case
