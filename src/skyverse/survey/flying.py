"""Who flies a survey."""

from collections.abc import Sequence

from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV, TrackingError


def flying(scenario: Scenario, survey: Survey) -> tuple[UAV, ...]:
    """Return the UAVs that may fly a survey; a usual one where there are none yet."""
    found = tuple(uav for uav in scenario.uavs if not survey.uavs or uav.name in survey.uavs)
    return found or (UAV(start=(0.0, 0.0, 0.0)),)


def greatest_error(uavs: Sequence[UAV]) -> TrackingError:
    """Return how far any of some UAVs may stray."""
    errors = [uav.tracking_error for uav in uavs]
    return TrackingError(horizontal=max(e.horizontal for e in errors), vertical=max(e.vertical for e in errors))
