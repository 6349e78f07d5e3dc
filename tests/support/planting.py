"""One fault put into a mission that is right, and whether what a judge found of the missions is so."""

import itertools
import math
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from shapely import affinity
from shapely.geometry import LineString, Point, Polygon, box

import skyverse as sky
from planted_missions import (
    GEOID,
    GROUND,
    HOME,
    SEA,
    TAKEOFF,
    WAYPOINT,
    Case,
    Flight,
    Item,
    Line,
    Retry,
    unharmed,
)
from planted_worlds import Floats, sampled

NOT_DJI = ("fence", "home", "conflict")
"""What DJI's files do not have: a fence, an altitude of home; and several vehicles have one home given."""


def harmed(rng: np.random.Generator, fault: str, *, dji: bool = False) -> Case:
    """Return missions with one fault of a kind, wrong by metres, of `dji` where its files have such."""
    while True:
        two = fault == "conflict"
        case = unharmed(rng, plain=fault in ("radius", "conflict", "return"), dji=dji and fault not in NOT_DJI)
        for _ in range(12):
            changed = case.with_(fault=fault)
            try:
                changed.planted = _conflict(rng, changed) if two else _PLANT[fault](rng, changed)
            except Retry:
                continue
            return changed


def _leg(rng: np.random.Generator, case: Case) -> Line:
    """Return one of the legs between two items, not too near to home."""
    flight = case.flights[0]
    legs = [one for one in flight.lines(case.world) if not one.corner and len(one.items) == 2 and len(one.points) > 10]
    legs = [one for one in legs if _away(flight, one.points[len(one.points) // 2]) > 45]
    if not legs:
        raise Retry
    return legs[int(rng.integers(len(legs)))]


def _away(flight: Flight, place: Floats) -> float:
    return math.dist(flight.home, place[:2])


def _item(case: Case, number: int) -> Item:
    return case.flights[0].items[number - case.flights[0].first]


def _middle(rng: np.random.Generator, leg: Line) -> tuple[Floats, Floats]:
    """Return a place in the middle half of a leg, and the direction there."""
    k = int(len(leg.points) * rng.uniform(0.3, 0.7))
    way = leg.points[-1][:2] - leg.points[0][:2]
    return leg.points[k], way / max(float(np.linalg.norm(way)), 1e-9)


def _surely(case: Case, items: tuple[int, ...], kind: str) -> tuple[int, ...]:
    """Return the items if a line at them now surely meets something of a kind; otherwise something else is drawn."""
    if not any(kind in case.world.harm(one.points) for one in lines(case, 0) if one.items == items):
        raise Retry
    return items


def lines(case: Case, number: int) -> list[Line]:
    """Return what a mission flies, within its own fence."""
    case.world.fence = case.flights[number].fence
    return case.flights[number].lines(case.world)


def _ridge(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    leg = _leg(rng, case)
    place, way = _middle(rng, leg)
    world, follows = case.world, _item(case, leg.items[-1]).frame == GROUND
    if follows:
        raise Retry
    above = float(place[2] - world.ground(*place[:2]))
    wide = max(rng.uniform(15, 50), 2.5 * world.cell)
    before = float(world.ground(*case.flights[0].home))
    far = Point(place[:2]).buffer(8 * wide)  # buildings stand on the ground, and would rise with it
    world.solids = [one for one in world.solids if one.kind == "zone" or not one.outline.intersects(far)]
    world.raise_around(place[0], place[1], above + rng.uniform(6, 20), (-way[1], way[0]), (3 * wide, wide))
    if abs(float(world.ground(*case.flights[0].home)) - before) > 0.05:
        raise Retry
    return _surely(case, leg.items, "ground")


def _block(rng: np.random.Generator, case: Case, kind: str) -> tuple[int, ...]:
    leg = _leg(rng, case)
    (x, y, z), _ = _middle(rng, leg)
    world, sizes = case.world, rng.uniform(4, 12, 2)
    shape = affinity.rotate(box(x - sizes[0], y - sizes[1], x + sizes[0], y + sizes[1]), rng.uniform(0, 90))
    if shape.distance(Point(case.flights[0].home)) < 15:
        raise Retry
    if kind == "zone":
        shape = affinity.scale(shape, 3, 3)
        height, sea = (None, False) if rng.uniform() < 0.5 else (round(float(z + rng.uniform(5, 60)), 1), True)
    else:
        height, sea = round(float(z - world.ground(x, y) + rng.uniform(4, 25)), 1), False
    world.solids.append(world.solid(kind, shape, height, sea=sea))
    return _surely(case, leg.items, kind)


def _fence(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    flight = replace(case.flights[0], autopilot="px4")
    if any(item.frame == GROUND for item in flight.items) or case.flights[0].autopilot != "px4":
        raise Retry
    leg = _leg(rng, case)
    place, way = _middle(rng, leg)
    own = np.concatenate([line.points for line in flight.lines(case.world)])[:, :2]
    fence = flight.fence or LineString(own).convex_hull.buffer(30)
    side = np.array([-way[1], way[0]])
    edges = [LineString([place[:2], place[:2] + sign * 2000 * side]) for sign in (-1, 1)]
    out = min(edges, key=lambda one: one.intersection(fence).length)
    notched = fence.difference(out.buffer(float(rng.uniform(6, 20))))
    if not isinstance(notched, Polygon) or not notched.contains(Point(flight.home).buffer(15)):
        raise Retry
    case.flights[0] = replace(flight, fence=notched)
    return _surely(case, leg.items, "fence")


def _waypoint(rng: np.random.Generator, case: Case) -> int:
    """Return the index of a waypoint."""
    found = [k for k, item in enumerate(case.flights[0].items) if item.command == WAYPOINT]
    return int(rng.choice(found))


def _high(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    flight, world = case.flights[0], case.world
    k = _waypoint(rng, case)
    item = flight.items[k]
    assert item.place is not None
    x, y, z = item.place
    above = {SEA: z - float(world.ground(x, y)), GROUND: z}.get(item.frame)
    if above is None:
        above = z + float(world.ground(*flight.home)) - float(world.ground(x, y))
    more = world.max_height - above + float(rng.uniform(11, 40))
    flight.items[k] = item._replace(place=(x, y, z + more))
    return _at(case, k + flight.first, "ceiling")


def _at(case: Case, number: int, *kinds: str) -> tuple[int, ...]:
    """Return an item's number if a leg at it now meets something."""
    found = [one for one in lines(case, 0) if number in one.items]
    if not any(case.world.harm(one.points) & set(kinds) for one in found):
        raise Retry
    return (number,)


def _frame(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    flight, k = case.flights[0], _waypoint(rng, case)
    item = flight.items[k]
    frames = [frame for frame in (SEA, HOME) if frame != item.frame]
    swapped, number = int(rng.choice(frames)), k + flight.first
    for at in range(len(flight.items)) if flight.autopilot == "dji" else [k]:  # whose heights have one mode
        if flight.items[at].command == WAYPOINT:
            flight.items[at] = flight.items[at]._replace(frame=swapped)
    return _at(case, number, "ground", "ceiling")


def _home(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    case.flights[0].told_home = float(rng.choice([-20.0, 20.0]))
    return (0,)


def _radius(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    flight, world = case.flights[0], case.world
    if flight.autopilot == "ardupilot":
        raise Retry
    ways = [one for one in flight.lines(world) if not one.corner]
    pairs = [(a, b) for a, b in itertools.pairwise(ways) if min(len(a.points), len(b.points)) > 70]
    pairs = [(a, b) for a, b in pairs if len(a.items) == len(b.items) == 2 and a.items[1] == b.items[0]]
    pairs = [(a, b) for a, b in pairs if _item(case, a.items[1]).command == WAYPOINT]
    if not pairs:
        raise Retry
    a, b = pairs[int(rng.integers(len(pairs)))]
    k, at = a.items[1] - flight.first, a.points[-1]
    radius = round(0.7 * min(len(a.points), len(b.points)))
    back = (a.points[0] - at) / np.linalg.norm(a.points[0] - at) * radius
    place = at + back + 0.35 * (b.points[-1] - at - back)
    shape = box(place[0] - 4, place[1] - 4, place[0] + 4, place[1] + 4)
    legs = [LineString(one.points[:, :2]) for one in ways if len(one.points) > 1 and len(one.items) == 2]
    if min(shape.distance(one) for one in legs) < 14 or shape.distance(Point(flight.home)) < 20:
        raise Retry
    tall = round(float(place[2] - world.ground(*place[:2]) + 12), 1)
    world.solids.append(world.solid("building", shape, tall))
    item = flight.items[k]
    flight.items[k] = item._replace(numbers=(0.0, float(radius), 0.0, 0.0))
    return _surely(case, a.items[1:], "building")


def _return(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    flight, world = case.flights[0], case.world
    ways = [line for line in lines(case, 0) if not line.corner]
    legs, leg = [LineString(one.points[:, :2]) for one in ways if len(one.points) > 1], _leg(rng, case)
    place = leg.points[len(leg.points) // 2][:2]
    x, y = np.array(flight.home) + rng.uniform(0.3, 0.7) * (place - flight.home)
    shape = box(x - 5, y - 5, x + 5, y + 5)
    if min(shape.distance(one) for one in legs) < 14 or shape.distance(Point(flight.home)) < 25:
        raise Retry
    tall = round(float(max(flight.level, leg.points[:, 2].max()) - world.ground(x, y) + rng.uniform(5, 25)), 1)
    world.solids.append(world.solid("building", shape, tall))
    return leg.items


def _conflict(rng: np.random.Generator, case: Case) -> tuple[int, ...]:
    """Add a second mission that flies the same way from its end, so that the two meet on the way."""
    first, world = case.flights[0], case.world
    items = [item for item in first.items if item.command == WAYPOINT]
    other = replace(first, items=[], home=(first.home[0] + 18.0, first.home[1]), fence=None, told_home=0.0)
    shift = float(world.ground(*first.home)) - float(world.ground(*other.home))
    back = [
        item._replace(place=(x, y, z + shift if item.frame == HOME else z))
        for item in reversed(items)
        if item.place is not None
        for x, y, z in [item.place]
    ]
    up = first.items[0].place
    assert up is not None
    other.items = [Item(TAKEOFF, frame=HOME, place=(*other.home, up[2] + shift)), *back]
    first.items[:] = [first.items[0], *items]
    points = sampled([one.points[-1] for one in first.lines(world) if not one.corner])
    if len(points) < 250:
        raise Retry
    case.flights.append(other)
    if any(one.outline.distance(Point(other.home)) < 15 for one in world.solids):
        raise Retry
    for number in (0, 1):
        if any(world.doubt(one.points) for one in lines(case, number)[1:]):
            raise Retry
    gaps = world.gaps(other.returns(world), surely=False)
    if any(gap < 9 for gap in gaps.values()):
        raise Retry
    return ()


_PLANT = {
    "ridge": _ridge,
    "building": lambda rng, case: _block(rng, case, "building"),
    "zone": lambda rng, case: _block(rng, case, "zone"),
    "fence": _fence,
    "high": _high,
    "home": _home,
    "frame": _frame,
    "radius": _radius,
    "return": _return,
}


class Found(NamedTuple):
    """What a judge found of a mission: what it is about, at which items, and what is met."""

    subject: str
    items: tuple[int, ...]
    what: str


def mistakes(case: Case, found: list[list[Found]]) -> tuple[list[str], list[str]]:
    """Return what was not found although it is surely so, and what was found although it surely is not."""
    missed, false = [], []
    for number, (flight, of) in enumerate(zip(case.flights, found, strict=True)):
        told = [one for one in of if one.subject in ("legs", "corners", "take-off")]
        for line in lines(case, number):
            at = [
                one for one in told if set(one.items) >= set(line.items) or (line.corner and one.subject == "corners")
            ]
            harm = case.world.harm(line.points) - ({"ground"} if len(line.items) == 1 and not line.corner else set())
            if harm and not any(_is(one, kind) for one in at for kind in harm):
                missed.append(f"{number}: {sorted(harm)} at {line.items}")
        for one in told:
            doubted = set().union(*(case.world.doubt(line.points) for line in _beside(lines(case, number), one)))
            if not any(_is(one, kind) for kind in doubted):
                false.append(f"{number}: {one}")
        back = case.world.gaps(flight.returns(case.world), surely=False)
        unsure = any(gap < 9 for gap in back.values()) or any(
            case.world.harm(line.points) for line in lines(case, number)[1:]
        )
        false += [f"{number}: {one}" for one in of if one.subject in ("way home", "end") and not unsure]
        rest = {"home": case.fault == "home", "separation": case.fault == "conflict", "limits": False}
        false += [f"{number}: {one}" for one in of if not rest.get(one.subject, True)]
    missed += _missed_plant(case, found)
    return missed, false


def _is(found: Found, kind: str) -> bool:
    return kind in found.what or (kind == "ground" and found.what == "bounds")


def _beside(every: Iterable[Line], found: Found) -> list[Line]:
    """Return the lines that a finding is about."""
    if found.subject == "corners":
        return [line for line in every if set(found.items) & set(line.items)]
    return [line for line in every if set(line.items) <= set(found.items)]


def _missed_plant(case: Case, found: list[list[Found]]) -> list[str]:
    wanted = {"home": "home", "radius": "corners", "conflict": "separation", "return": "way home"}.get(case.fault or "")
    if wanted is None:
        return []
    for of in found:
        at = [one for one in of if one.subject == wanted or (wanted == "way home" and one.subject == "end")]
        right = {"radius": set(case.planted), "home": {0}, "return": set(case.planted)}.get(case.fault or "", set())
        if not any(set(one.items) >= right or (case.fault == "return" and set(one.items) & right) for one in at):
            return [f"{case.fault} at {case.planted}"]
        if case.fault != "conflict":
            break
    return []


def options_and_settings(case: Case, folder: Path) -> tuple[sky.BuildOptions, sky.FlightSettings]:
    """Return where the missions of a case are flown, with its maps written to a folder, and how."""
    flight, maps = case.flights[0], case.world.write(folder)
    level = flight.level - float(case.world.ground(*flight.home))
    home = tuple(map(float, case.world.globe(*flight.home))) if flight.autopilot == "dji" else None
    settings = sky.FlightSettings(autopilot=flight.autopilot, home=home, return_altitude=round(level, 3))
    most = sky.AboveGround(case.world.max_height)
    limits: dict[str, Any] = {"clearance": 2.0, "ground_clearance": 2.0, "vehicle": "camera", "max_height": most}
    return sky.BuildOptions("planted", **limits, **maps), settings


def judged(case: Case) -> list[list[Found]]:
    """Return what skyverse finds wrong with each mission of a case, read from files."""
    with tempfile.TemporaryDirectory() as folder:
        files = [one.write(case.world, Path(folder), f"m{k}") for k, one in enumerate(case.flights, 1)]
        where, settings = options_and_settings(case, Path(folder))
        read = [sky.read_waypoints(file, **({"geoid": GEOID} if file.suffix == ".kmz" else {})) for file in files]
        fleet = sky.check_waypoints(read, where, settings)
    wrong = ([one for one in mission.findings if one.wrong] for mission in fleet.missions)
    return [[Found(one.subject.value, one.items, one.what) for one in some] for some in wrong]
