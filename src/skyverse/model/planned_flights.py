"""What a mission holds of each UAV, in one place, also of a mission that the referee found wrong."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from skyverse.model.mission import FlightSummary, Mission
from skyverse.model.result import Result
from skyverse.model.scenario import Target
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV

Thing = TypeVar("Thing")


@dataclass(frozen=True, eq=False)
class PlannedFlight:
    """One UAV and what was planned for it; ``None`` where there is no such thing."""

    uav: UAV
    target: Target | None = None
    result: Result | None = None
    trajectory: Trajectory | None = None
    summary: FlightSummary | None = None

    @property
    def status(self) -> str:
        """How the search for its path ended, in words."""
        if self.result is not None:
            return self.result.status.value
        return "no target" if self.target is None else "not planned"


def planned_flights(mission: Mission) -> tuple[PlannedFlight, ...]:
    """Return what a mission holds of each UAV, in the scenario's order.

    Entries that are missing, that name no target, or that are trajectories without sound numbers count as ``None``.
    """
    flights = []
    for k, uav in enumerate(mission.scenario.uavs):
        wanted, trajectory = _entry(mission.assignment, k), _entry(mission.trajectories, k)
        flights.append(
            PlannedFlight(
                uav=uav,
                target=None if wanted is None else _entry(mission.scenario.targets, wanted),
                result=_entry(mission.results, k),
                trajectory=trajectory if trajectory is not None and _sound(trajectory) else None,
                summary=_entry(mission.flights, k),
            )
        )
    return tuple(flights)


def _entry(things: Sequence[Thing | None], number: int) -> Thing | None:
    return things[number] if 0 <= number < len(things) else None


def _sound(trajectory: Trajectory) -> bool:
    """Return whether a trajectory can be evaluated; one that was read from a file may have a wrong shape."""
    knots, coefficients = trajectory.knots, trajectory.coefficients
    if (
        coefficients.ndim != 3
        or coefficients.shape[2] != 3
        or coefficients.shape[1] < 1
        or knots.shape != (len(coefficients) + 1,)
    ):
        return False
    rising = len(knots) > 1 and bool(np.all(np.diff(knots) > 0))
    return rising and bool(np.isfinite(knots).all() and np.isfinite(coefficients).all())
