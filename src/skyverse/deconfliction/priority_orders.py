"""In which order the UAVs of a fleet take their turns."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.model.uav import UAV

IN_THE_WAY = 0.5
"""Metres along each axis within which a path counts as passing a start or target; it only decides who goes first."""
PATH_SAMPLES = 100
"""Instants at which a path is sampled for that."""


def priority_order(uavs: Sequence[UAV], planned: Sequence[Candidate], in_conflict: set[int], key: Floats) -> list[int]:
    """Return the UAVs in the order of their turns.

    Those that stay at their starts come first, then those of higher priority; among equals those in no conflict, and
    then those with the least key, (n,).
    """
    rank = [(planned[u].target is not None, -uavs[u].priority, u in in_conflict, key[u], u) for u in range(len(uavs))]
    return [entry[-1] for entry in sorted(rank)]


def first_keys(planned: Sequence[Candidate]) -> list[Floats]:
    """Return the keys of the first orders: the longest flights first; those in nobody's way; the shortest."""
    seconds = np.array([candidate.seconds for candidate in planned])
    return [-seconds, _paths_crossed(planned), seconds]


def next_key(planned: Sequence[Candidate], order: Sequence[int], placed: Sequence[PlacedFlight]) -> Floats:
    """Return the key of the next order: a UAV's position in the last one, less in proportion to how late it came."""
    late = np.array([flight.arrival - own.trajectory.end for flight, own in zip(placed, planned, strict=True)])
    latest = max(float(late.max()), TICK)
    blame = np.where([flight.in_conflict for flight in placed], 1.0, late / latest)
    position = np.empty(len(order))
    position[list(order)] = np.arange(len(order))
    return position - len(order) * blame


def _paths_crossed(planned: Sequence[Candidate]) -> Floats:
    """Return on how many others' paths each UAV's target lies, less on how many its start lies; (n,)."""
    starts, ends = np.array([own.start for own in planned]), np.array([own.end for own in planned])
    score = np.zeros(len(planned))
    for own in planned:
        instants = np.linspace(own.trajectory.start, own.trajectory.end, PATH_SAMPLES)
        path = own.trajectory.at(instants).position[:, None]
        for points, sign in ((starts, -1.0), (ends, 1.0)):
            near = (np.abs(path - points).max(axis=2) < IN_THE_WAY).any(axis=0)
            near[own.uav] = False
            score += sign * near
    return score
