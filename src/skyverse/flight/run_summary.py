"""What is kept of one run: least distances, largest errors, how many errors of each size, and what was touched."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.flight.run import Fleet, Nearest, fly_run
from skyverse.flight.tracking_control import LOST_DISTANCE
from skyverse.flight.vehicle import told_airspeeds
from skyverse.model.flight_runs import Distribution, Touch
from skyverse.model.seconds import told_instant

MILLIMETRES = 1000.0
"""The resolution of the distributions of errors, bins a metre."""


class RunSummary(NamedTuple):
    """What is kept of a run: see `Run`; `lost` holds the instant, seconds, and the UAV that was lost first."""

    seed: int
    obstacle: Nearest
    ground: Nearest
    pair: Nearest
    nearness: float
    outside: float
    largest: Floats
    lost: tuple[float, int] | None


class ErrorCounts:
    """How many errors there are of each millimetre, rounded up."""

    def __init__(self) -> None:
        self.counts = np.zeros(0, dtype=np.int64)

    def add(self, counts: Ints) -> None:
        """Add counts of errors."""
        if len(counts) > len(self.counts):
            self.counts = np.pad(self.counts, (0, len(counts) - len(self.counts)))
        self.counts[: len(counts)] += counts

    def distribution(self, largest: float) -> Distribution:
        """Return the distribution of all that were counted; the largest is known exactly."""
        up_to = np.cumsum(self.counts)
        median, most = (float(np.searchsorted(up_to, share * up_to[-1])) / MILLIMETRES for share in (0.5, 0.99))
        return Distribution(min(median, float(largest)), min(most, float(largest)), float(largest))


def total(each: Iterable[ErrorCounts]) -> ErrorCounts:
    """Return the counts of all together."""
    together = ErrorCounts()
    for one in each:
        together.add(one.counts)
    return together


def summarise_run(fleet: Fleet, seed: int) -> tuple[RunSummary, dict[int, tuple[Ints, Ints]]]:
    """Fly once; return what is kept, and each UAV's counts of horizontal and vertical errors."""
    run = fly_run(fleet, seed)
    largest = np.zeros((len(run.errors), 2))
    counts = {}
    for uav, errors in enumerate(run.errors):
        if errors is not None:
            largest[uav] = errors.max(axis=0)
            bins = np.ceil(errors * MILLIMETRES).astype(np.int64)
            counts[uav] = (np.bincount(bins[:, 0]), np.bincount(bins[:, 1]))
    lost = [(float(s.times[-1]), uav) for uav, s in enumerate(run.samples) if s is not None and s.lost]
    summary = RunSummary(
        seed, run.obstacle, run.ground, run.pair, run.nearness, run.outside, largest, min(lost, default=None)
    )
    return summary, counts


def first_touch(fleet: Fleet, number: int, run: RunSummary) -> Touch | None:
    """Return the first thing that went wrong in a run, or nothing."""
    radius, names = fleet.vehicle.radius, [uav.name for uav in fleet.mission.scenario.uavs]
    wrong = []
    for nearest, reach, deed in (
        (run.obstacle, radius, "touches an obstacle"),
        (run.ground, radius, "touches the ground"),
        (run.pair, 2 * radius, "touch each other"),
    ):
        if nearest.distance <= reach:
            wrong.append((nearest.time, f"{' and '.join(names[uav] for uav in nearest.uavs)} {deed}", ""))
    if run.lost is not None:
        time, uav = run.lost
        flown = fleet.mission.trajectories[uav]
        assert flown is not None
        why = told_airspeeds(fleet.vehicle, flown, fleet.weather.wind)
        wrong.append((time, f"{names[uav]} is lost, more than {LOST_DISTANCE:g} m off its trajectory,", why))
    if not wrong:
        return None
    time, deed, why = min(wrong)
    seed = f" (seed {run.seed})" if fleet.weather.random else ""
    return Touch(number, run.seed, time, f"{deed} {told_instant(time)} in run {number}{seed}{why}")
