"""What the controller of one UAV is told at every sample of a flight."""

from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.flight.feedforward import Reference, reference
from skyverse.flight.vehicle import Vehicle
from skyverse.model.ground_height import ground_height
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.temporary_zones import is_closed_at_times
from skyverse.model.trajectory import Trajectory

COMMAND_RATE = 100.0
"""Commands, and samples, per second."""
HOVER_SECONDS = 3.0
"""Seconds for which a UAV hovers at its start, in the wind, before it departs."""
SETTLING_SECONDS = 1.0
"""Seconds for which a UAV is still simulated after its trajectory has ended."""


@dataclass(frozen=True, eq=False)
class Commands:
    """The commands to one UAV.

    Attributes
    ----------
    times
        (m,) seconds into the mission, a hundredth apart; the first `hover` of them lie before the departure.
    reference
        What is commanded at those times.
    height
        (m,) metres above the terrain, or above the floor of the bounds where there is none.
    hover
        How many samples precede the departure.
    """

    times: Floats
    reference: Reference
    height: Floats
    hover: int


def commands(mission: Mission, uav: int, vehicle: Vehicle) -> Commands:
    """Return the commands to a UAV from a hover before its departure until it has settled after its arrival.

    Raises
    ------
    InputError
        If the scenario has movers, or zones that are closed at times, which no simulated flight is judged against.
    """
    trajectory, scenario = mission.trajectories[uav], mission.scenario
    if scenario.movers:
        said = "flights among movers cannot be simulated unless they are replanned in flight; this scenario has movers"
        raise InputError(f"{scenario.name}: {said}")
    if any(map(is_closed_at_times, scenario.zones)):
        raise InputError(
            f"{scenario.name}: flights among zones that are closed at times cannot be simulated; this scenario has such"
        )
    assert trajectory is not None
    return commanded(scenario, trajectory, vehicle, trajectory.end + SETTLING_SECONDS)


def commanded(scenario: Scenario, trajectory: Trajectory, vehicle: Vehicle, until: float) -> Commands:
    """Return the commands to a UAV that flies a trajectory, from a hover before its start until an instant, seconds."""
    hover = round(HOVER_SECONDS * COMMAND_RATE)
    first = np.floor(trajectory.start * COMMAND_RATE) - hover
    last = np.ceil(until * COMMAND_RATE)
    times = np.arange(first, last + 1) / COMMAND_RATE
    told = reference(trajectory, vehicle, times, 1.0 / COMMAND_RATE)
    above = np.asarray(told.position[:, 2] - ground_height(scenario, told.position[:, :2]))
    return Commands(times, told, above, hover)
