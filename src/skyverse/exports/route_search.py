"""Finds the waypoints of one UAV: few, and proven clear when an autopilot flies straight between them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.autopilots import AUTOPILOTS, MIN_ACCEPTANCE_RADIUS, rates_of
from skyverse.exports.flights import ExportedFlight
from skyverse.exports.legs import LegChecker
from skyverse.exports.photo_strips import (
    LEAST_GAP,
    MOST_RADII,
    MOST_RESTARTS,
    Approach,
    PhotoRun,
    Station,
    StripWay,
    strip_ways,
)
from skyverse.exports.route import Route, Takeoff, stop_seconds
from skyverse.exports.waypoint_placement import (
    MAX_WAYPOINTS,
    FixedPlaces,
    Obstruction,
    WaypointPlacement,
    distances_to_segment,
)
from skyverse.numerics.tolerances import SAME_PLACE

PLACES_PER_PIECE = 16
"""The number of samples on each piece of a trajectory at which a waypoint can be placed."""
BENT = 40.0
"""Metres of the ways to strips and from them, at most, that are bent towards a run-in, where no other strip is near."""
MIN_RADIUS_SHARE = 0.25
"""The share of the first radius down to which it is halved before the UAV may stop at corners instead."""


def route(
    legs: LegChecker,
    flight: ExportedFlight,
    *,
    radius: float,
    takeoff: Takeoff,
    stops: bool,
    through: bool = True,
) -> Route:
    """Return a UAV's waypoints, which the referee has yet to prove.

    Parameters
    ----------
    legs
        What checks its legs, in a scenario that has an origin.
    flight
        What the UAV flies.
    radius
        The largest acceptance radius, metres. It is halved until every leg and every cut corner is clear.
    takeoff
        The first climb, at least `radius` above the height at which it leaves a pad at the start; what is above that
        height is halved twice, then left out, where an obstacle is above the start.
    stops
        Whether the UAV stops at every waypoint and cuts no corner.
    through
        Whether even such a one flies through the ends and bends of strips along which photos are taken.

    Raises
    ------
    InputError
        If no radius gives a clear route, or it has more waypoints than autopilots accept.
    """
    if flight.strips:
        return _route_of_photos(legs, flight, radius=radius, takeoff=takeoff, stops=stops, through=through)
    sizes = _sizes(radius, not stops and legs.scenario.uavs[flight.uav].fixed_wing is None)
    found = _searched(legs, flight, _Curve(*_samples(flight)), sizes, takeoff, stops=stops)
    if isinstance(found, Route):
        return found
    raise _unproven(legs, flight, radius, found)


class _Curve(NamedTuple):
    """Samples of a flight, (n,) seconds and (n, 3) metres, and the stations and runs of each of its strips."""

    instants: Floats
    places: Floats
    strips: tuple[tuple[Sequence[Station], Sequence[PhotoRun]], ...] = ()


class _NoRoute(NamedTuple):
    """Why no waypoints are proven, and the instants of those beside which the last attempt failed."""

    said: str | Obstruction
    blocked: tuple[float, ...] = ()


def _route_of_photos(
    legs: LegChecker, flight: ExportedFlight, *, radius: float, takeoff: Takeoff, stops: bool, through: bool
) -> Route:
    """Return the waypoints of a flight with strips: it stops at the ends of those to which no run-in is proven."""
    vehicle, autopilot = legs.scenario.uavs[flight.uav], AUTOPILOTS[takeoff.autopilot]
    wing = vehicle.fixed_wing is not None
    radius = radius if wing else min(radius, MOST_RADII[takeoff.autopilot])
    busy = [flight.begin, flight.end, *(t for stay in flight.stays for t in (stay.arrival, stay.departure))]
    ways = strip_ways(legs.scenario, flight, busy, through=through)
    halts = [[not through or gap < LEAST_GAP for gap in way.room] for way in ways]
    found, least = _NoRoute(""), sum(len(way.photos) for way in ways) / MOST_RESTARTS
    for size, may_stop in _sizes(radius, not stops and not wing):
        how, more = Approach(autopilot.name, rates_of(vehicle, autopilot), size, wing, through, least), True
        while more:
            laid = tuple(way.laid(how, (first, last)) for way, (first, last) in zip(ways, halts, strict=True))
            made = _searched(legs, flight, _with_strips(flight, ways, laid), [(size, may_stop)], takeoff, stops=stops)
            if isinstance(made, Route):
                beyond = [max(-s[0].along, s[-1].along - way.length) for way, (s, _) in zip(ways, laid, strict=True)]
                return replace(made, off=max(made.off, *beyond))
            found, more = made, _halted(ways, halts, made.blocked)
    raise _unproven(legs, flight, radius, found)


def _searched(
    legs: LegChecker,
    flight: ExportedFlight,
    given: _Curve,
    sizes: Sequence[tuple[float, bool]],
    takeoff: Takeoff,
    *,
    stops: bool,
) -> Route | _NoRoute:
    """Return the waypoints of a flight that is given as a curve, with one of some radii; see `route`."""
    said: str | Obstruction = ""
    radius, instants, flown = sizes[0][0], given.instants, given.places
    curve = legs.below_ceiling(flown)
    lowered = float((flown - curve)[:, 2].max())
    stood = []
    for stay in flight.stays[::-1]:
        instants, curve, above = _stopping_above_pad(legs, instants, curve, _sample_at(instants, stay.arrival))
        stood += above
    base, risen = curve[0], _count_on_pad(legs, curve)
    sunk = _count_on_pad(legs, curve[::-1])
    stop_at = set()
    if risen and stops:  # it stops above the pad at the start, to which it flies straight up
        kept = [0, *range(risen, len(curve))]
        instants, curve, risen = instants[kept], curve[kept], 0
        curve[1, :2] = base[:2]
        stop_at = {1}
    instants, curve = instants[risen:], curve[risen:]
    if sunk:  # it stops above the pad at the target, and flies straight down from there
        kept = [*range(len(curve) - sunk), len(curve) - 1]
        instants, curve = instants[kept], curve[kept]
        curve[-2, :2] = curve[-1, :2]
        stop_at |= {len(curve) - 2}
    visits = dict.fromkeys(stop_at | {_sample_at(instants, t) for t in stood}, False)
    visits |= {_sample_at(instants, stay.arrival): True for stay in flight.stays}
    fixed = _fixed(given, instants, visits, stops=stops)
    passed = fixed.only_passes or not stops
    height = float(curve[0, 2] - base[2]) if risen else 0.0
    more = max(takeoff.climb - height, radius if risen else 0.0)  # the corner above a pad may be cut
    more = 0.0 if 0 in visits else more  # it is at a target already
    climbs = [height + more, height + more / 2, height + more / 4, height] if more > 0 else [height]
    early, blocked = takeoff.early(0.0, 0.0 if stops else radius), tuple[float, ...]()
    for climb in [*climbs, height + early] if early else climbs:  # the last leaves nothing below the start to prove
        lifted = base + np.array([0.0, 0.0, climb])
        if climb > height and legs.leg(base, lifted).fault is not None:
            continue
        for size, may_stop in sizes:
            early = 0.0 if stops else takeoff.early(climb, size)
            lead = (base - np.array([0.0, 0.0, early]))[None] if climb or early else curve[:0]
            asked = (legs, np.concatenate([lead, lifted[None]]), curve, size if passed else 0.0, size, may_stop, fixed)
            search = WaypointPlacement(*asked)
            found = search.run()
            if isinstance(found, Obstruction):
                search = WaypointPlacement(*asked, by_curve=True)
                found = search.run()
            if isinstance(found, Obstruction):
                said, blocked = found, tuple(instants[[*search.blocked]].tolist())
            elif len(found) <= MAX_WAYPOINTS:
                made = _made(flight, search, given, instants, found, base, climb, lowered)
                return replace(made, runs=_runs(given, made, instants[[k for k, _ in found]]))
            else:
                said = f"it takes {len(found)} waypoints, and autopilots take {MAX_WAYPOINTS}"
                break
    return _NoRoute(said, blocked)


def _unproven(legs: LegChecker, flight: ExportedFlight, radius: float, found: _NoRoute) -> InputError:
    said = found.said
    if isinstance(said, Obstruction):
        said = f"{said.where}: {legs.space.sentence(said.fault)}"
    return InputError(
        f"{legs.scenario.uavs[flight.uav].name}: straight legs between waypoints could not be proven with an "
        f"acceptance radius from {radius:g} m down to {MIN_ACCEPTANCE_RADIUS:g} m: {said}; fly it as a trajectory "
        "(.csv, .trajectory.json), or plan with a larger clearance"
    )


def _halted(ways: Sequence[StripWay], halts: list[list[bool]], blocked: Sequence[float]) -> bool:
    """Let a UAV stop at the ends of strips beside which no waypoints are proven; return whether any are new."""
    new = False
    for way, own in zip(ways, halts, strict=True):
        begin, end = way.strip.begin, way.strip.end
        for side, low, high in ((0, begin - way.room[0], begin), (1, end, end + way.room[1])):
            if not own[side] and any(low < t < high for t in blocked):
                own[side] = new = True
    return new


def _with_strips(
    flight: ExportedFlight, ways: Sequence[StripWay], laid: tuple[tuple[list[Station], list[PhotoRun]], ...]
) -> _Curve:
    """Return samples of a flight in which stations take the place of those that are between them.

    The ways before and after them are bent so that they lead to the first station and from the last one.
    """
    instants, places = _samples(flight)
    ends = [t for way in ways for t in (way.strip.begin, way.strip.end)]
    flown = places.copy()
    for way, (stations, _) in zip(ways, laid, strict=True):
        begin, end = way.strip.begin, way.strip.end
        for t, left, station in ((begin, begin - way.room[0], stations[0]), (end, end + way.room[1], stations[-1])):
            some = np.flatnonzero((instants >= min(t, left)) & (instants <= max(t, left)))
            if len(some) < 2:
                continue
            lengths = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(flown[some], axis=0), axis=1))]
            away = lengths if t <= left else lengths[-1] - lengths
            to_strip = min(abs(one - left) for one in ends) <= SAME_PLACE
            bent = lengths[-1] if to_strip else min(lengths[-1] / 2, BENT)
            at = way.place(0.0 if t == begin else way.length)
            if bent > SAME_PLACE:
                places[some] += np.maximum(1.0 - away / bent, 0.0)[:, None] * (station.place - at)
    for stations, _ in laid:
        first, last = stations[0].instant, stations[-1].instant
        before, after = int(np.sum(instants < first - SAME_PLACE)), int(np.sum(instants <= last + SAME_PLACE))
        instants = np.r_[instants[:before], [one.instant for one in stations], instants[after:]]
        places = np.concatenate([places[:before], np.stack([one.place for one in stations]), places[after:]])
    return _Curve(instants, places, laid)


def _fixed(given: _Curve, instants: Floats, visits: dict[int, bool], *, stops: bool) -> FixedPlaces:
    """Return where a flight must have waypoints; an autopilot that stops at all others passes those of strips."""
    stopped, passes, places = dict(visits), set[int](), set[int]()
    for stations, runs in given.strips:
        alone = {run.on for run in runs if run.on == run.off}
        for k, station in enumerate(stations):
            at = _sample_at(instants, station.instant)
            if k in alone or (station.stops and not stops):
                stopped[at] = True
            elif station.stops:
                places.add(at)
            else:
                passes.add(at)
    passes -= set(stopped)
    return FixedPlaces(stopped, frozenset(passes), frozenset(places), stops and bool(given.strips))


def _runs(given: _Curve, made: Route, instants: Floats) -> tuple[PhotoRun, ...]:
    """Return the runs of all strips by the numbers of waypoints, of which those that are placed come at instants."""
    found, first = [], len(made.waypoints) - len(instants)
    for stations, runs in given.strips:
        at = [first + _sample_at(instants, one.instant) for one in stations]
        found += [replace(run, on=at[run.on], off=at[run.off]) for run in runs]
    return tuple(found)


def _sizes(radius: float, may_stop: bool) -> list[tuple[float, bool]]:
    """Return the acceptance radii to try, and for each whether the UAV may stop where a corner is not clear."""
    halved = [radius]
    while halved[-1] / 2 >= MIN_ACCEPTANCE_RADIUS:
        halved.append(halved[-1] / 2)
    if not may_stop:
        return [(size, False) for size in halved]
    large = [(size, False) for size in halved if size >= MIN_RADIUS_SHARE * radius]
    return large + [(size, True) for size in halved]


def _made(
    flight: ExportedFlight,
    search: WaypointPlacement,
    given: _Curve,
    instants: Floats,
    found: list[tuple[int, Floats]],
    base: Floats,
    climb: float,
    lowered: float,
) -> Route:
    legs, curve, radius = search.legs, search.curve, search.radius
    points, times = np.array([point for _, point in found]), instants[[k for k, _ in found]]
    holds = np.array([stop_seconds(radius) if k in search.stopped else 0.0 for k, _ in found])
    stood, targets = np.zeros(len(found)), np.full(len(found), -1)
    for stay in flight.stays:
        k = [index for index, _ in found].index(_sample_at(instants, stay.arrival))
        stood[k], targets[k] = stay.departure - stay.arrival, stay.target
        holds[k] = max(stood[k], stay.least + (stop_seconds(radius) if radius else 0.0))
    for station in (one for stations, _ in given.strips for one in stations if one.stood):
        k = [index for index, _ in found].index(_sample_at(instants, station.instant))
        stood[k] = station.stood
        holds[k] = max(holds[k], station.stood)
    radii = np.array([radius * (k in search.passes or not search.only_passes) for k, _ in found])
    flown = np.concatenate([curve[:1], points[1:]])  # the takeoff does not count as a deviation
    deviations = legs.deviations(flown, radii, holds)
    away = [
        distances_to_segment(curve[a : b + 1], *ends).max()
        for (a, b), ends in zip(pairwise([k for k, _ in found]), pairwise(flown), strict=True)
    ]
    off = lowered + float(np.max(away + deviations))
    times = times + np.cumsum(np.r_[0.0, (holds - stood)[:-1]])
    if climb:
        holds, targets = np.r_[0.0, holds], np.r_[-1, targets]
        points, radii = np.concatenate([base[None], points]), np.r_[radii[:1], radii]
        times = np.concatenate([times[:1], times])
    deviations = legs.deviations(points, radii, holds)[1 if climb else 0 :]
    told = points, times, radii, climb, search.lead, off, holds, deviations, legs.lifts, deviations * np.nan, targets
    return Route(flight.uav, *told, sortie=flight.sortie, to_home=flight.to_home)


def _count_on_pad(legs: LegChecker, curve: Floats) -> int:
    """Return how many samples of a curve, (n, 3), are on the pad at its first place, below where it leaves the pad."""
    for base, top in legs.lifts:
        if np.abs(base - curve[0]).max() <= SAME_PLACE:
            below = (np.abs(curve[:, :2] - base[:2]).max(axis=1) <= SAME_PLACE) & (curve[:, 2] < top[2] - SAME_PLACE)
            return int(np.argmin(below))
    return 0


def _sample_at(instants: Floats, t: float) -> int:
    return int(np.argmin(np.abs(instants - t)))


def _stopping_above_pad(
    legs: LegChecker, instants: Floats, curve: Floats, at: int
) -> tuple[Floats, Floats, list[float]]:
    """Return samples of a curve, (n,) and (n, 3), that lead straight down to the pad at a sample, and up from there.

    With them comes when it is above the pad, to stop there; where the sample is on no pad, nothing is changed.
    """
    sunk, risen = _count_on_pad(legs, curve[at::-1]), _count_on_pad(legs, curve[at:])
    kept = np.r_[: at - max(sunk - 1, 0), at, at + max(risen, 1) : len(curve)]
    instants, curve, at = instants[kept], curve[kept], at - max(sunk - 1, 0)
    above = [k for k, on_pad in ((at - 1, sunk), (at + 1, risen)) if on_pad]
    curve[above, :2] = curve[at, :2]
    return instants, curve, instants[above].tolist()


def _samples(flight: ExportedFlight) -> tuple[Floats, Floats]:
    """Return times and positions on a flight, without repetitions where it stands still."""
    shares, trajectory = np.arange(PLACES_PER_PIECE) / PLACES_PER_PIECE, flight.trajectory
    t = (trajectory.knots[:-1, None] + np.diff(trajectory.knots)[:, None] * shares).ravel()
    t = np.r_[t[(t >= flight.begin) & (t < flight.end)], flight.end]
    curve = trajectory.at(t).position
    moved = np.linalg.norm(np.diff(curve, axis=0), axis=1) > SAME_PLACE
    keep = np.r_[True, moved]
    keep[-1] = True
    if keep[:-1].sum() > 1 and not moved[-1]:
        keep[np.flatnonzero(keep[:-1])[-1]] = False  # the end replaces the samples at the same place
    return t[keep], curve[keep]
