"""What a UAV could fly to its target, and when: a candidate, and a candidate that is placed in time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result
from skyverse.model.trajectory import Trajectory

LENGTH_SAMPLES = 200
"""Instants at which a trajectory is sampled to measure its length."""


@dataclass(frozen=True)
class Gate:
    """A point beside a path through which a detour leads: a hole in a wall that is imagined there.

    Attributes
    ----------
    passed
        The point of the path beside which the hole is, (3,) metres.
    centre
        Of the hole, (3,) metres.
    axis
        The axis that the wall is perpendicular to.
    """

    passed: tuple[float, float, float]
    centre: tuple[float, float, float]
    axis: int


@dataclass(frozen=True, eq=False)
class Candidate:
    """One way for a UAV to fly to its target.

    Attributes
    ----------
    uav, target
        Indices; the target is ``None`` for a UAV that stays at its start.
    curve
        The number of its trajectory in the `CurveStore`.
    seconds
        How long it takes.
    result, trajectory
        The path, and the trajectory along it from the UAV's earliest departure on.
    gates
        The gates that it is led through; none for the path as planned.
    heeds
        The numbers of the zones with active times that it heeds at all times; none for the path as planned.
    hovers
        Its waits on the way, in order: for so many seconds, at a place, (3,) metres.
    in_time
        Whether its way was found by a search in space and time.
    """

    uav: int
    target: int | None
    curve: int
    seconds: float
    result: Result | None
    trajectory: Trajectory
    gates: tuple[Gate, ...] = ()
    heeds: frozenset[int] = frozenset()
    hovers: tuple[tuple[float, Floats], ...] = ()
    in_time: bool = False

    @cached_property
    def start(self) -> Floats:
        """Where it begins, (3,) metres."""
        return self.trajectory.at(self.trajectory.start).position[0]

    @cached_property
    def end(self) -> Floats:
        """Where it ends, (3,) metres."""
        return self.trajectory.at(self.trajectory.end).position[0]

    @cached_property
    def metres(self) -> float:
        """The length of the trajectory."""
        return flown_length(self.trajectory)


@dataclass(frozen=True, eq=False)
class PlacedFlight:
    """A candidate that departs at an instant and takes some times as long as its trajectory.

    Attributes
    ----------
    candidate
        What is flown.
    departure
        Seconds into the mission.
    time_scale
        How many times as long it takes; 1 or more.
    in_conflict
        Whether it is in conflict with a flight that was placed before it.
    """

    candidate: Candidate
    departure: float
    time_scale: float = 1.0
    in_conflict: bool = False

    @property
    def arrival(self) -> float:
        """Seconds into the mission."""
        return self.departure + self.time_scale * self.candidate.seconds


def flown_length(trajectory: Trajectory) -> float:
    """Return the length of a trajectory, metres, approximated by `LENGTH_SAMPLES` samples."""
    instants = np.linspace(trajectory.start, trajectory.end, LENGTH_SAMPLES)
    return float(np.linalg.norm(np.diff(trajectory.at(instants).position, axis=0), axis=1).sum())
