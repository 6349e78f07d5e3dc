"""Strips along which photos are taken, as places for waypoints: where a camera is switched on and off, and run-ins.

A strip is flown through: it begins behind a run-in, and its last waypoint lies so far beyond its last photo that what
an autopilot does within its acceptance radius comes after it. Where there is no room for that, the UAV stops.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.errors import InputError
from skyverse.exports.autopilots import LOOKS, AutopilotName, AutopilotRates, trigger_lead
from skyverse.exports.flights import ExportedFlight
from skyverse.exports.leg_geometry import leg_deviation, steepest
from skyverse.exports.waypoint_placement import distances_to_segment
from skyverse.model.arrays import arctan2
from skyverse.model.photos import photo_times
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Strip
from skyverse.model.survey import Trigger
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LEG_ALLOWANCE, SAME_PLACE

MOST_RADII: dict[AutopilotName, float] = {"px4": 1.0, "ardupilot": 0.6, "dji": 1.0}
"""Metres: the largest acceptance radius of a multirotor that takes photos; ArduPilot turns somewhere within it."""
OFF_WAY = 0.05
"""Metres by which the straight parts of a strip may be off its trajectory."""
OFF_STOPS = 0.4
"""The same for a UAV that stops at each bend, so that there are few."""
MOST_ASIDE = 0.7
"""Metres that a cut corner may lead beside a strip; the UAV stops at sharper bends."""
MOST_OFF = 0.5
"""Metres by which photos may be off along a strip, with a probability of 95 %, as autopilots look only now and then."""
ALIKE = 0.2
"""The part of the way between two looks by which all photos of a run may be late alike, if there are few looks."""
MANY_LOOKS = 33.0
"""From so many looks between two photos on, no run is late alike, as speeds come and go by a few per cent."""
MOST_RESTARTS = 75
"""How often the count of a flight begins anew for that at most, as each time takes four items."""
MOST_LATE = 0.15
"""Metres by which photos may be late behind bends, across which autopilots count the distance straight."""
OVERRUN = 3.0
"""Metres behind the last photo, at most, in which a late last photo may still be taken."""
AFTER_CORNER = 1.0
"""Metres of a run-in beside twice the acceptance radius."""
LEAST_LEG = 0.6
"""Metres between the waypoints of a strip at least, as DJI's aircraft take none below half a metre."""
LEAST_GAP = 0.5
"""Seconds between strips, or from the beginning of a flight, in which there is time for a run-in."""
SAMPLES_IN_PIECE = 16
"""Samples in each polynomial piece of a trajectory from which the straight parts of a strip are found."""
SPARE_SPEED = 1.1
"""By which factor an autopilot may be faster than told without photos that follow too soon for the camera."""


@dataclass(frozen=True)
class PhotoRun:
    """Photos that an autopilot takes one after the other between two waypoints.

    Attributes
    ----------
    strip
        The number of the strip among all of the UAV's.
    survey
        The index of the survey.
    on, off
        The waypoints, counted from 0 after the take-off, at which the camera is switched on and off; equal where the
        UAV stands for a single photo.
    count
        How many photos there are; the first is taken at once.
    every
        Metres from one to the next, seen from above; 0 for a single photo.
    trigger
        What they are taken by.
    pitch, heading
        As those of `Strip`.
    fastest
        m/s: what the camera keeps up with.
    stands
        Whether the UAV stops at `off`, where its last photo is to be taken: that is told by itself.
    """

    strip: int
    survey: int
    on: int
    off: int
    count: int
    every: float
    trigger: Trigger
    pitch: float
    heading: float | None
    fastest: float
    stands: bool

    def standing_at(self, k: int) -> bool:
        """Return whether the UAV takes a photo standing at waypoint k."""
        return self.stands and k == self.off

    def moved(self, at: Indices) -> "PhotoRun":
        """Return the same run after waypoints have been added, each before the one that had such a number."""
        on, off = (number + int(np.sum(at <= number)) for number in (self.on, self.off))
        return replace(self, on=on, off=off)


def photo_heading(runs: Sequence[PhotoRun], k: int) -> float | None:
    """Return where the nose points at waypoint k for photos, degrees clockwise from north; ``None`` if it is free.

    The waypoint before a run is part of it, so that the UAV has turned when it begins, unless it is one of another.
    """
    own = [run for run in runs if run.on <= k <= run.off] or [run for run in runs if k == run.on - 1]
    return own[-1].heading if own else None


class Station(NamedTuple):
    """A place of a waypoint.

    It has metres along a strip, the instant, seconds, (3,) metres, whether the UAV stops, and the seconds of its stand.
    """

    along: float
    instant: float
    place: Floats
    stops: bool
    stood: float = 0.0


class Approach(NamedTuple):
    """How an autopilot flies strips.

    Attributes
    ----------
    autopilot, rates
        What flies them.
    radius
        The acceptance radius, metres.
    wing
        Whether it is an aeroplane, whose trajectory leads on to each strip.
    through
        Whether it may pass bends of a strip without a stop.
    least
        How many photos are taken in one count at least.
    """

    autopilot: AutopilotName
    rates: AutopilotRates
    radius: float
    wing: bool
    through: bool = True
    least: float = 1.0


@dataclass(frozen=True, eq=False)
class StripWay:
    """A strip by metres along it, seen from above.

    Attributes
    ----------
    name, number, strip
        What the UAV is called, and the strip with its number among all of the UAV's.
    trigger, fastest
        As those of `PhotoRun`.
    along, instants, points
        (n,) metres, (n,) seconds and (n, 3) metres of samples of it.
    photos
        (k,) metres along it at which photos are taken.
    room
        Seconds before and after it that the UAV flies elsewhere.
    off
        Metres by which its straight parts may be off.
    longest
        Metres between the ends of its straight parts at most: longer ones autopilots fly too far beside straight lines.
    stands
        (k, 2) seconds: where the UAV stands for each photo, from when until when.
    """

    name: str
    number: int
    strip: Strip
    trigger: Trigger
    fastest: float
    along: Floats
    instants: Floats
    points: Floats
    photos: Floats
    room: tuple[float, float]
    off: float
    longest: float
    stands: Floats

    @property
    def alone(self) -> bool:
        """Whether the UAV stands for each photo."""
        return self.trigger == "point" or len(self.photos) == 1

    @property
    def length(self) -> float:
        """Metres, seen from above."""
        return float(self.along[-1])

    @property
    def pace(self) -> float:
        """m/s over ground, in the mean."""
        return self.length / (self.strip.end - self.strip.begin)

    @cached_property
    def corners(self) -> Indices:
        """The samples between which it is straight, both ends included."""
        found = np.array(_straight_parts(self.points, 0, len(self.points) - 1, self.off) or [0])
        parts = [
            np.linspace(a, b, math.ceil((b - a) / self.longest) + 1) for a, b in pairwise(self.along[found].tolist())
        ]
        return np.unique(np.r_[found, *(np.searchsorted(self.along, part[1:-1]) for part in parts)])

    @cached_property
    def bends(self) -> Floats:
        """(n,) radians by which it turns at each of the `corners`, seen from above; 0 at its ends."""
        ways = np.diff(self.points[self.corners, :2], axis=0)
        turns = np.zeros(len(self.corners))
        cross = ways[:-1, 0] * ways[1:, 1] - ways[:-1, 1] * ways[1:, 0]
        turns[1:-1] = np.abs(arctan2(cross, np.sum(ways[:-1] * ways[1:], axis=1)))
        return turns

    def place(self, along: float) -> Floats:
        """Return a place, (3,) metres; beyond its ends straight on."""
        if len(self.corners) == 1:
            return self.points[0]
        at = self.along[self.corners]
        k = int(np.clip(np.searchsorted(at, along) - 1, 0, len(at) - 2))
        a, b = self.points[self.corners[k : k + 2]]
        return np.asarray(a + (along - at[k]) / (at[k + 1] - at[k]) * (b - a))

    def instant(self, along: float, *, steady: bool) -> float:
        """Return when it is there, seconds, at an even pace or as planned; beyond its ends in the room that it has."""
        begin, end = self.strip.begin, self.strip.end
        if along < 0:
            return begin - min(-along / self.pace, 0.4 * self.room[0])
        if along > self.length:
            return end + min((along - self.length) / self.pace, 0.4 * self.room[1])
        return begin + along / self.pace if steady else float(np.interp(along, self.along, self.instants))

    def laid(self, how: Approach, halts: tuple[bool, bool]) -> tuple[list[Station], list[PhotoRun]]:
        """Return the stations of its waypoints, and its runs, which name stations by their numbers.

        `halts` tells whether the UAV stops at its first photo and at its last one.

        Raises
        ------
        InputError
            If photos are to be taken by time where the UAV would have to stop.
        """
        at = self.along[self.corners]
        if self.alone:
            stops = {float(along): True for along in self.photos}
            stands = dict(zip(stops, self.stands.tolist(), strict=True))
            stations = self._stations({**dict.fromkeys(at[1:-1].tolist(), False), **stops}, steady=False)
            for k, station in enumerate(stations):
                if station.stops:
                    begin, end = stands[station.along]
                    stations[k] = station._replace(instant=begin, stood=end - begin)
            return stations, [self._run(stations, along, along, 1, stands=True) for along in stops]
        halts = halts[0] and not how.wing, halts[1] and not how.wing
        sharp = how.radius * np.sin(np.minimum(self.bends, math.pi / 2)) > MOST_ASIDE
        sharp |= not how.through
        if self.trigger == "time" and (any(halts) or sharp.any()):
            why = f"there is no room for a run-in to strip {self.number + 1}, or a sharp bend in it"
            why = why if how.through else "it stops at every waypoint"
            raise InputError(f"{self.name}: photos by time need a steady speed, and {why}; take them by distance")
        run_in = self._run_in(how.rates) if self.trigger == "time" and not how.wing else 0.0
        over = 0.0 if halts[1] else how.radius + min(self.strip.every / 2, OVERRUN)
        parts = [*self._uninterrupted(how)]
        ons = [float(self.photos[first]) for first, _, _ in parts]
        ons = [on + (0.0 if halts[0] and not k else self._lead(how, on)) for k, on in enumerate(ons)]
        ends = [float(at[corner]) if corner else self._off(how, last) for _, last, corner in parts[:-1]]
        offs_at = [*ends, self.length + over]
        marks = [(on, off, last - first + 1) for on, off, (first, last, _) in zip(ons, offs_at, parts, strict=True)]
        switched = dict.fromkeys(ons, not how.through) | {ons[0]: halts[0]}
        offs = dict.fromkeys(offs_at, not how.through) | {offs_at[-1]: halts[1]}
        inner = dict(zip(at[1:-1].tolist(), sharp[1:-1].tolist(), strict=True))
        told = [*switched, *offs]
        far = [along for along in inner if min(abs(along - one) for one in told) > max(how.radius / 2, LEAST_LEG)]
        placed = {along: inner[along] for along in far}
        placed |= {along: inner.get(along, False) or stop for along, stop in offs.items()} | switched
        if not halts[0] and not how.wing:
            placed[-(2 * how.radius + AFTER_CORNER + run_in)] = False
        if run_in:
            placed[self.length + over + run_in] = False
        stations = self._stations(placed, steady=not any(halts) and not sharp.any())
        return stations, [self._run(stations, *mark, stands=halts[1] and mark is marks[-1]) for mark in marks]

    def _stations(self, placed: dict[float, bool], *, steady: bool) -> list[Station]:
        return [
            Station(along, self.instant(along, steady=steady), self.place(along), placed[along])
            for along in sorted(placed)
        ]

    def _run(self, stations: Sequence[Station], on: float, off: float, count: int, *, stands: bool) -> PhotoRun:
        where, strip = [station.along for station in stations], self.strip
        every = 0.0 if self.alone else strip.every
        at = where.index(on), where.index(off), count, every
        return PhotoRun(self.number, strip.survey, *at, self.trigger, strip.pitch, strip.heading, self.fastest, stands)

    def _run_in(self, rates: AutopilotRates) -> float:
        """Return the way in which a UAV comes from rest to its speed, metres."""
        return self.pace**2 / (2 * rates.acceleration) + self.pace * rates.acceleration / (2 * rates.jerk)

    def _lead(self, how: Approach, along: float) -> float:
        """Return how far behind a photo the waypoint lies at which it is taken, metres."""
        at = self.along[self.corners]
        k = int(np.clip(np.searchsorted(at, along, side="right"), 1, len(at) - 1))
        a, b = self.points[self.corners[k - 1 : k + 1]]
        slope = abs(float(b[2] - a[2])) / float(at[k] - at[k - 1])
        return min(trigger_lead(how.autopilot, how.radius, slope), max(float(at[k]) - along, 0.0) / 2)

    def _off(self, how: Approach, last: int) -> float:
        """Return where the camera is switched off after a photo: before the next one, lest that is taken twice."""
        a, b = self.photos[last : last + 2].tolist()
        return (a + b) / 2 + self._lead(how, (a + b) / 2) if LOOKS[how.autopilot] else b

    def _uninterrupted(self, how: Approach) -> Iterator[tuple[int, int, int]]:
        """Yield the first and the last photo of each run, and the number of the corner where it ends; 0 for no corner.

        Autopilots count the distance straight from photo to photo, and look at it only now and then. Where bends would
        make that too late, or looks too unsure, the count begins anew at the next photo; it ends at a bend if there is
        room, else halfway.
        """
        at, first, late = self.along[self.corners], 0, 0.0
        most, looks = len(self.photos), LOOKS[how.autopilot] * self.pace
        if looks and self.trigger == "distance":  # two standard deviations of an even distribution, if not all alike
            may, alike = MOST_OFF / looks, ALIKE if self.strip.every < MANY_LOOKS * looks else 0.0
            sure = min(3.0 * may**2, may / alike if alike else math.inf)
            most = math.ceil(most / math.ceil(most / (1.0 + max(sure, how.least))))
        places = np.array([self.place(float(along))[:2] for along in self.photos])
        for k, (a, b) in enumerate(pairwise(self.photos.tolist()), 1):
            within = np.flatnonzero((at > a) & (at < b))
            if len(within):
                late += b - a - math.dist(places[k - 1], places[k])
            if late > MOST_LATE or k - first >= most:
                bend = at[within[0]] if len(within) else a
                room = bend - a > how.radius + AFTER_CORNER and b - bend > LEAST_LEG
                yield first, k - 1, int(within[0]) if room else 0
                first, late = k, 0.0
        yield first, len(self.photos) - 1, 0


def _straight_parts(points: Floats, a: int, b: int, most: float) -> list[int]:
    """Return the corners of a line (n, 3) from one of its points to another (Ramer, Douglas and Peucker)."""
    off = distances_to_segment(points[a : b + 1], points[a], points[b])
    if b - a < 2 or off.max() <= most:
        return [a, b] if b > a else []
    middle = a + int(np.argmax(off))
    return [*_straight_parts(points, a, middle, most)[:-1], *_straight_parts(points, middle, b, most)]


def strip_ways(scenario: Scenario, flight: ExportedFlight, busy: Sequence[float], *, through: bool) -> list[StripWay]:
    """Return the strips of a flight as ways; `through` tells whether their bends are passed without a stop.

    `busy` are the instants at which the UAV begins and ends something else, of the flight's begin and end at least.
    """
    trajectory, strips = flight.trajectory, flight.strips
    slope = 0.0 if scenario.terrain is None else steepest(scenario.terrain)
    longest = math.sqrt(LEG_ALLOWANCE / (float(leg_deviation(scenario, 1.0)) * (1.0 + slope)))
    made = []
    for number, strip in strips:
        t = trajectory.instants(SAMPLES_IN_PIECE, strip.begin, strip.end)
        points = trajectory.at(t).position
        moved = np.r_[True, np.hypot(*np.diff(points[:, :2], axis=0).T) > SAME_PLACE]
        points, t = points[moved], t[moved]
        along = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points[:, :2], axis=0).T))]
        photos = np.linspace(0.0, along[-1], len(photo_times(trajectory, strip)))
        others = [*busy, *(t for k, one in strips if k != number for t in (one.begin, one.end))]
        room = (
            min((strip.begin - t for t in others if t <= strip.begin), default=0.0),
            min((t - strip.end for t in others if t >= strip.end), default=0.0),
        )
        survey = scenario.surveys[strip.survey]
        fastest = strip.every / (SPARE_SPEED * survey.camera.min_interval) if strip.every else math.inf
        of = scenario.uavs[flight.uav].name, number, strip, survey.trigger, fastest
        stands = np.array([_stand(trajectory, at) for at in np.interp(photos, along, t).tolist()])
        made.append(StripWay(*of, along, t, points, photos, room, OFF_WAY if through else OFF_STOPS, longest, stands))
    return made


def _stand(trajectory: Trajectory, t: float) -> tuple[float, float]:
    """Return from when until when a UAV stands still where it is at an instant, seconds; that twice if it does not."""
    knots, places = trajectory.knots, trajectory.at(trajectory.knots).position
    near = np.abs(places - trajectory.at([t]).position).max(axis=1) <= SAME_PLACE
    still = np.intersect1d(np.flatnonzero(near), np.flatnonzero(near) - 1)
    if not len(still):
        return t, t
    first = last = int(still[np.argmin(np.abs((knots[still] + knots[still + 1]) / 2 - t))])
    while first - 1 in still:
        first -= 1
    while last + 1 in still:
        last += 1
    return float(knots[first]), float(knots[last + 1])
