"""A tour as it is flown: legs from rest to rest, and between them stays at targets and at home, as one trajectory."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.model.scenario import Scenario, Target
from skyverse.model.sortie import Sortie, Strip, Visit
from skyverse.model.take_off import landing, take_off
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import MIN_WAIT, SAME_PLACE
from skyverse.survey.lines import PhotoLine
from skyverse.trajectory import HeldYaw, with_heading

TURN_ALLOWANCE = 1.5
"""How many times as long as a turn by half a circle the UAV has to turn its nose before a stay, and after it."""


@dataclass(frozen=True, eq=False)
class TourFlight:
    """The flight of one UAV along its tour.

    Attributes
    ----------
    scenario, uav
        What was given, and the index of the UAV.
    legs
        From rest to rest, in their order.
    ends
        The target at which each leg ends, ``None`` at home.
    departures
        The earliest instant for each leg, seconds into the mission: it departs then, or as soon as what comes before is
        done.
    lines
        The photo line that each leg is, ``None`` for other legs.
    """

    scenario: Scenario
    uav: int
    legs: tuple[Trajectory, ...]
    ends: tuple[int | None, ...]
    departures: tuple[float, ...]
    lines: tuple[PhotoLine | None, ...]

    @cached_property
    def times(self) -> tuple[tuple[float, float], ...]:
        """When each leg departs and arrives, seconds into the mission."""
        times: list[tuple[float, float]] = []
        for leg, least, end, line in zip(self.legs, self.departures, (None, *self.ends), self.lines, strict=False):
            ready = 0.0 if not times else self._done(end, times[-1][1])
            if (
                line is not None and times and self._own.fixed_wing is None
            ):  # the nose turns on the way to where the line begins
                ready = max(ready, times[-1][0] + half_turn_seconds(self._own))
            departure = max(ready, least)
            times.append((departure, departure + leg.duration))
        return tuple(times)

    def _done(self, end: int | None, arrival: float) -> float:
        """Return when what is to be done where a leg ends is done, if it arrives there at an instant."""
        if end is None:
            return arrival + swap_seconds(self.scenario, self.uav)
        visit = self._visit(end, arrival)
        return visit.departure + turning_seconds(self._own, self.scenario.targets[end])

    def _visit(self, target: int, arrival: float) -> Visit:
        wanted = self.scenario.targets[target]
        begin = arrival + turning_seconds(self._own, wanted)
        begin = begin if wanted.window is None else max(begin, wanted.window[0])
        return Visit(target, begin, begin + wanted.stay)

    @property
    def _own(self) -> UAV:
        return self.scenario.uavs[self.uav]

    @cached_property
    def sorties(self) -> tuple[Sortie, ...]:
        """Its sorties, from one stand at home to the next."""
        sorties: list[Sortie] = []
        visits: list[Visit] = []
        strips: list[Strip] = []
        begin: float | None = None
        for (departure, arrival), end, line in zip(self.times, self.ends, self.lines, strict=True):
            begin = departure if begin is None else begin
            if line is not None:
                strips.append(Strip(line.survey, departure, arrival, line.every, line.pitch, line.heading))
            if end is not None:
                visits.append(self._visit(end, arrival))
            if end is None:
                sorties.append(Sortie(begin, arrival, tuple(visits), tuple(strips)))
                visits, strips, begin = [], [], None
        if begin is not None:
            sorties.append(Sortie(begin, self._done(self.ends[-1], self.times[-1][1]), tuple(visits), tuple(strips)))
        return tuple(sorties)

    @cached_property
    def trajectory(self) -> Trajectory:
        """All of it, with where the nose points."""
        parts: list[Trajectory] = []
        for k, (leg, (departure, _)) in enumerate(zip(self.legs, self.times, strict=True)):
            if k:
                parts += _stand(parts[-1], self.times[k - 1][1], departure)
            parts.append(leg.retimed(departure))
        parts += _stand(parts[-1], self.times[-1][1], self.sorties[-1].end)
        notes = dict.fromkeys(part.note for part in parts if part.note)
        form = next((part.form for part in parts if part.form != "stop-and-go"), parts[0].form)
        whole = replace(joined(parts), form=form, note=" ".join(notes))
        held = [
            HeldYaw(
                visit.arrival, visit.departure, yaw, turning_seconds(self._own, self.scenario.targets[visit.target])
            )
            for sortie in self.sorties
            for visit in sortie.visits
            if (yaw := wanted_yaw(self.scenario.targets[visit.target])) is not None
        ]
        return with_heading(whole, self._own, held + self._held_on_lines)

    @property
    def _held_on_lines(self) -> list[HeldYaw]:
        """Where the nose points on photo lines; on the ways between them it turns."""
        held: list[HeldYaw] = []
        for k, (line, (begin, end)) in enumerate(zip(self.lines, self.times, strict=False)):
            if line is not None and self._own.fixed_wing is None:
                bends = line.heading is None and not _is_straight(line.path)  # the nose follows its course
                beside = [b - a for a, b in (*self.times[max(k - 1, 0) : k], *self.times[k + 1 : k + 2])]
                turn = min(half_turn_seconds(self._own), *beside)
                held.append(HeldYaw(begin, begin if bends else end, _yaw_of(line), turn))
        return held

    def keeps_windows(self) -> bool:
        """Tell whether each stay begins within its window."""
        visits = (visit for sortie in self.sorties for visit in sortie.visits)
        windows = ((visit, self.scenario.targets[visit.target].window) for visit in visits)
        return all(window is None or visit.arrival <= window[1] for visit, window in windows)


def _stand(before: Trajectory, begin: float, end: float) -> Sequence[Trajectory]:
    """Return the stand where a trajectory ends, none where it would be too short."""
    if end - begin <= MIN_WAIT:
        return ()
    place = before.at([before.end]).position
    return (Trajectory(np.array([begin, end]), place[None]),)


def swap_seconds(scenario: Scenario, uav: int) -> float:
    """Return the seconds between two sorties of a UAV: it lands, changes the battery, and takes off."""
    own = scenario.uavs[uav]
    return landing(scenario, uav, own.start).seconds + own.swap + take_off(scenario, uav, own.start).seconds


def turning_seconds(uav: UAV, target: Target) -> float:
    """Return how long a UAV has to turn its nose where a target wants it before a stay, and away from it after."""
    if wanted_yaw(target) is None:
        return 0.0
    return half_turn_seconds(uav)


def half_turn_seconds(uav: UAV) -> float:
    """Return how long a UAV has to turn its nose by half a circle."""
    return TURN_ALLOWANCE * (180.0 / uav.max_yaw_rate + 4.0 * uav.max_yaw_rate / uav.max_yaw_acceleration)


def _is_straight(path: Floats) -> bool:
    """Tell whether a path (n, 3) is straight as seen from above."""
    way, whole = np.diff(path[:, :2], axis=0), path[-1, :2] - path[0, :2]
    return bool((np.abs(way[:, 0] * whole[1] - way[:, 1] * whole[0]) <= SAME_PLACE * np.hypot(*whole)).all())


def _yaw_of(line: PhotoLine) -> float:
    """Return where the nose points where a photo line begins, rad, counterclockwise from east."""
    if line.heading is not None:
        return math.radians(90.0 - line.heading)
    east, north = (line.path[1] - line.path[0])[:2]
    return float(arctan2(np.array(north), np.array(east)))


def wanted_yaw(target: Target) -> float | None:
    """Return where a target wants the nose, rad, counterclockwise from east."""
    if target.heading is not None:
        return math.radians(90.0 - target.heading)
    if target.look_at is None:
        return None
    east, north = np.subtract(target.look_at, target.position)[:2]
    return float(arctan2(np.array(north), np.array(east)))
