"""What a format needs of a mission, which is asked before anything is judged or searched."""

import math

from skyverse.errors import InputError, is_number
from skyverse.exports.autopilots import MIN_ACCEPTANCE_RADIUS, AutopilotName, autopilot_for
from skyverse.exports.file_names import ALTITUDE_REFERENCES, ROUTE_SUFFIXES
from skyverse.exports.global_positions import AltitudeReference, geoid_of, require_reference
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario

HOME_TOLERANCE = 0.1
"""Metres: a home may be so much lower than any ground that the scenario knows, as files and grids round both."""


def require_format(
    mission: Mission,
    scenario: Scenario,
    suffix: str,
    altitude: AltitudeReference,
    autopilot: AutopilotName | None,
    what: str,
) -> None:
    """Raise `InputError` where a format in degrees cannot hold a mission, whatever is proven of it.

    Parameters
    ----------
    mission, scenario
        The mission, and its scenario with an origin.
    suffix, altitude, autopilot
        The format, the reference of altitudes, and the autopilot that is asked for, if any.
    what
        What messages call the output.
    """
    require_reference(scenario, altitude, ALTITUDE_REFERENCES[suffix], what)
    flying = [uav for uav, flight in zip(scenario.uavs, mission.trajectories, strict=True) if flight is not None]
    if suffix in ROUTE_SUFFIXES:
        autopilot_for(suffix, altitude, autopilot)
        planes = [uav.name for uav in flying if uav.fixed_wing is not None]
        if suffix == ".wpml.kmz" and planes:
            raise InputError(f"{', '.join(planes)}: DJI's waylines are for multirotors, not for aeroplanes")
    if suffix == ".geojson" or (suffix == ".wpml.kmz" and altitude == "amsl"):
        geoid_of(scenario, what if suffix == ".geojson" else "DJI's waylines, above the sea")
    if suffix in ROUTE_SUFFIXES or altitude == "home":
        require_plausible_homes(scenario)


def require_radius_and_takeoff(radius: float, takeoff: float) -> None:
    """Raise `InputError` for an acceptance radius or a height of the first climb that no waypoint can have."""
    for noun, value, least, most in (
        ("radius", radius, MIN_ACCEPTANCE_RADIUS, 1000.0),
        ("takeoff", takeoff, 0.0, math.inf),
    ):
        if not (is_number(value) and least <= value <= most):
            until = f"to {most:g}" if most < math.inf else "on"
            raise InputError(f"expected metres from {least:g} {until}, found {value!r}", field=noun)


def require_plausible_homes(scenario: Scenario) -> None:
    """Raise `InputError` for a home where there can be no ground to stand on.

    A home may be as low as the bounds, or as the lowest ground that the terrain may have there, which can be lower.
    """
    for number, uav in enumerate(scenario.uavs):
        if uav.home is None:
            continue
        lowest, noun = scenario.bounds.min[2], "the bounds"
        if scenario.terrain is not None:
            ground = float(scenario.terrain.lowest_ground.height(uav.start[:2]))
            if ground < lowest:
                lowest, noun = ground, "the lowest ground there"
        if uav.home < lowest - HOME_TOLERANCE:
            raise InputError(
                f"uavs[{number}].home ({uav.name}): expected the ground below the start, at z = {lowest:.6g} m or "
                f"higher, found {uav.home:.6g} m, which is below {noun}"
            )


def require_no_movers(scenario: Scenario, what: str) -> None:
    """Raise `InputError` for a scenario with movers; `what` is what would be made of it."""
    if scenario.movers:
        raise InputError(
            f"{what}: scenario {scenario.name!r} has movers, and no autopilot keeps a schedule exactly enough to be "
            "proven clear of them; formats that keep the times of the flight hold it, such as .csv, .geojson and ROS's"
        )
