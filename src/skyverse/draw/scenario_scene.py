"""A scenario as it is drawn before anything is planned; starts and targets that are not safe are marked."""

from skyverse.draw.scene import Scene, SceneFinding
from skyverse.draw.track import track
from skyverse.model.planned_flights import PlannedFlight
from skyverse.model.scenario import Scenario
from skyverse.space.unsafe_points import unsafe_points


def scenario_scene(scenario: Scenario) -> Scene:
    """Return the scene of a scenario: its UAVs at their starts, and every target as one to which no UAV flies yet."""
    return Scene(
        scenario=scenario,
        tracks=tuple(
            track(PlannedFlight(uav=uav), number, scenario.bounds) for number, uav in enumerate(scenario.uavs)
        ),
        spare_targets=tuple((target.name, target.position) for target in scenario.targets),
        findings=tuple(
            SceneFinding(
                severity="error",
                kind="start" if point.field.startswith("uavs") else "target",
                uavs=(point.name,),
                message=f"{point.advice}.",
                time=None,
                position=point.position,
            )
            for point in unsafe_points(scenario)
        ),
    )
