"""The flights of a mission that are exported each by itself: those of its sorties, with the stays at targets."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Sortie, Strip, Visit
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import SAME_PLACE


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
    strips
        Along which it takes photos, each with its number among all of the UAV's.
    """

    uav: int
    trajectory: Trajectory
    begin: float
    end: float
    stays: tuple[Stay, ...] = ()
    sortie: int = 0
    to_home: bool = False
    strips: tuple[tuple[int, Strip], ...] = ()


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
            stays = _joined(mission.scenario, [_stay(trajectory, visit, sortie) for visit in sortie.visits])
            to_home = number < len(sorties) or mission.scenario.uavs[uav].end == "home"
            end = sortie.end if to_home or not stays else stays[-1].arrival
            of = number if len(sorties) > 1 else 0
            strips = tuple(enumerate(sortie.strips, sum(len(one.strips) for one in sorties[: number - 1])))
            yield ExportedFlight(uav, trajectory, sortie.begin, end, stays, of, to_home, strips)


def _joined(scenario: Scenario, stays: Sequence[Stay]) -> tuple[Stay, ...]:
    """Return stays of which those that follow one another at one place, with the nose in one direction, are one."""
    made: list[Stay] = []
    for stay in stays:
        old, new = (scenario.targets[one.target] for one in ((made or stays)[-1], stay))
        same = old.heading == new.heading and old.look_at == new.look_at
        if made and same and math.dist(old.position, new.position) <= SAME_PLACE:
            least = stay.arrival + stay.least - made[-1].arrival
            made[-1] = Stay(stay.target, made[-1].arrival, stay.departure, least)
        else:
            made.append(stay)
    return tuple(made)


def _stay(trajectory: Trajectory, visit: Visit, sortie: Sortie) -> Stay:
    """Return the stay of a visit: the stands that it is in and that touch it, in its sortie."""
    still = ~trajectory.coefficients[:, 1:].any(axis=(1, 2))
    met = still & (trajectory.knots[:-1] <= visit.departure) & (trajectory.knots[1:] >= visit.arrival)
    arrival = max(np.min(trajectory.knots[:-1][met], initial=visit.arrival), sortie.begin)
    departure = min(np.max(trajectory.knots[1:][met], initial=visit.departure), sortie.end)
    return Stay(visit.target, float(arrival), float(departure), float(visit.departure - arrival))
