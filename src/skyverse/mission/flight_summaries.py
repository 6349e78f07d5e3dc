"""A mission with the summaries of what its UAVs fly."""

from dataclasses import replace

from skyverse.model.flight_summary import FlightSummary
from skyverse.model.mission import Mission
from skyverse.trajectory.summary import flight_summary


def with_flight_summaries(mission: Mission) -> Mission:
    """Return a mission with a summary of every flight that has a path, whatever summaries it had."""
    flights: list[FlightSummary | None] = []
    for uav, result, trajectory in zip(mission.scenario.uavs, mission.results, mission.trajectories, strict=True):
        if result is None or trajectory is None or not len(result.path):
            flights.append(None)
        else:
            flights.append(flight_summary(uav, result.path, trajectory))
    return replace(mission, flights=tuple(flights))
