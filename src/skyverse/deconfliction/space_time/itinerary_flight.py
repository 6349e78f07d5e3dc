"""From an itinerary to a flight: legs that follow each other without a wait become one smooth flight where they can."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.model.verdict import Verdict
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.numerics.tolerances import MIN_SEGMENT, MIN_WAIT
from skyverse.search.path_shortening.shortcut import drop_collinear, shortcut
from skyverse.space.world import World
from skyverse.trajectory.blended import blended
from skyverse.trajectory.leg_parts import rest_to_rest
from skyverse.trajectory.proof import prove

MAX_DEVIATION = 0.5
"""Metres that a blend may be from its corner."""
LEAST_PARTS = 2
"""Legs that are worth a smooth flight, at least."""


@dataclass(frozen=True, eq=False)
class Nonstop:
    """A part of a flight, from rest to rest, that is flown without a wait.

    Attributes
    ----------
    path
        (n, 3) metres.
    departure
        Seconds into the mission.
    flown
        The trajectory.
    """

    path: Floats
    departure: float
    flown: Trajectory

    @property
    def arrival(self) -> float:
        """Seconds into the mission."""
        return self.departure + self.flown.end - self.flown.start


IsClear = Callable[[Sequence[Nonstop]], bool]
"""Tells whether nobody is too near to a flight that consists of these runs."""


def split_at_waits(
    points: Floats, departures: Floats, arrivals: Floats, uav: UAV, stops: set[int], winds: WindBall = STILL_AIR
) -> list[Nonstop]:
    """Return the runs of an itinerary over n points, each with a stop at every point.

    Parameters
    ----------
    points
        (n, 3) metres.
    departures, arrivals
        (n,) seconds at each point.
    uav
        Whose limits are kept.
    stops
        The points at which a run ends even without a wait.
    winds
        In which the UAV flies.
    """
    waits = departures[1:-1] - arrivals[1:-1] > MIN_WAIT
    ends = [0, *(k + 1 for k, wait in enumerate(waits.tolist()) if wait or k + 1 in stops), len(points) - 1]
    return [_stop_and_go(points[a : b + 1], float(departures[a]), uav, winds) for a, b in pairwise(ends)]


def _stop_and_go(path: Floats, departure: float, uav: UAV, winds: WindBall) -> Nonstop:
    legs = [rest_to_rest(path[k : k + 2], uav, winds=winds) for k in range(len(path) - 1)]
    return Nonstop(path, departure, joined(legs))


def whole_flight(runs: Sequence[Nonstop]) -> Trajectory:
    """Return runs as one trajectory, at rest from the end of each to the departure of the next."""
    parts: list[Trajectory] = []
    for before, run in zip([None, *runs], runs, strict=False):
        if before is not None and run.departure - before.arrival > MIN_WAIT:
            hover = np.array([0.0, run.departure - before.arrival])
            parts.append(Trajectory(hover, before.path[-1][None, None]))
        parts.append(run.flown)
    smooth = [run.flown.form for run in runs if run.flown.form != "stop-and-go"]
    return replace(joined(parts).retimed(0.0), form=smooth[0] if smooth else "stop-and-go")


def smoothed(world: World, uav: UAV, runs: Sequence[Nonstop], clear: IsClear) -> list[Nonstop]:
    """Return runs that are flown smoothly where that is proven free, meets nobody, and arrives no later."""
    best = list(runs)
    all_smooth = [_smooth_ways(world, uav, run)[:1] or [run] for run in best]
    if clear([run[0] for run in all_smooth]):
        return [run[0] for run in all_smooth]
    k = 0
    while k < len(best):
        for smooth in _smooth_ways(world, uav, best[k]):
            tried = [*best[:k], smooth, *best[k + 1 :]]
            if clear(tried):
                best = tried
                break
        else:
            legs = len(best[k].path) - 1
            if legs >= 2 * LEAST_PARTS:
                best[k : k + 1] = _halves(best[k], uav, world.scenario.winds)
                continue
        k += 1
    return best


def _halves(run: Nonstop, uav: UAV, winds: WindBall) -> list[Nonstop]:
    middle = len(run.path) // 2
    first = _stop_and_go(run.path[: middle + 1], run.departure, uav, winds)
    return [first, _stop_and_go(run.path[middle:], first.arrival, uav, winds)]


def _smooth_ways(world: World, uav: UAV, run: Nonstop) -> list[Nonstop]:
    """Return the run on a straighter path and on its own, both with blends at the bends, where they are proven."""
    if len(run.path) <= LEAST_PARTS:
        return []
    found = []
    own = drop_collinear(run.path)
    straighter = shortcut(world.space, own)
    for path in [straighter, own] if len(straighter) < len(own) else [own]:
        if np.ptp(path, axis=0).max() <= MIN_SEGMENT:  # it leads back to where it begins
            continue
        flown = blended(world, path, uav, MAX_DEVIATION)
        smooth = Nonstop(path, run.departure, flown)
        if smooth.arrival <= run.arrival and prove(world, uav, flown).verdict is Verdict.PROVEN:
            found.append(smooth)
    return found
