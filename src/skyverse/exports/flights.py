"""The flights of a mission that are exported each by itself: those of its sorties, with the stays at targets."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.sortie import Visit
from skyverse.model.trajectory import Trajectory


class Stay(NamedTuple):
    """How long a UAV is at a target.

    Attributes
    ----------
    target
        The index of the target.
    arrival, departure
        Seconds into the mission between which it stands there.
    least
        Seconds after its arrival until which it must: when its visit ends.
    """

    target: int
    arrival: float
    departure: float
    least: float


@dataclass(frozen=True, eq=False)
class ExportedFlight:
    """One flight of one UAV, from take-off to its end.

    Attributes
    ----------
    uav, trajectory
        The index of the UAV, and its trajectory, which may have other flights, too.
    begin, end
        Seconds into the mission.
    stays
        At the targets that it visits, in their order; none where it flies to one and stays there.
    sortie
        Which of the sorties of the UAV it is, counted from 1; 0 where there is only one.
    to_home
        Whether it ends where it begins.
    """

    uav: int
    trajectory: Trajectory
    begin: float
    end: float
    stays: tuple[Stay, ...] = ()
    sortie: int = 0
    to_home: bool = False


def flights_of(mission: Mission) -> Iterator[ExportedFlight]:
    """Yield the flights of a mission, UAV by UAV, those of one UAV in their order."""
    for uav, trajectory in enumerate(mission.trajectories):
        if trajectory is None:
            continue
        if not mission.sorties:
            yield ExportedFlight(uav, trajectory, trajectory.start, trajectory.end)
            continue
        sorties = mission.sorties_of(uav)
        for number, sortie in enumerate(sorties, 1):
            stays = tuple(_stay(trajectory, visit, sortie.begin, sortie.end) for visit in sortie.visits)
            to_home = number < len(sorties) or mission.scenario.uavs[uav].end == "home"
            end = sortie.end if to_home or not stays else stays[-1].arrival
            yield ExportedFlight(uav, trajectory, sortie.begin, end, stays, number if len(sorties) > 1 else 0, to_home)


def _stay(trajectory: Trajectory, visit: Visit, begin: float, end: float) -> Stay:
    """Return the stay of a visit: the stands that it is in and that touch it, between two instants."""
    still = ~trajectory.coefficients[:, 1:].any(axis=(1, 2))
    met = still & (trajectory.knots[:-1] <= visit.departure) & (trajectory.knots[1:] >= visit.arrival)
    arrival = max(np.min(trajectory.knots[:-1][met], initial=visit.arrival), begin)
    departure = min(np.max(trajectory.knots[1:][met], initial=visit.departure), end)
    return Stay(visit.target, float(arrival), float(departure), float(visit.departure - arrival))
