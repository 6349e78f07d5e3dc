"""Missions of one or several vehicles, judged at one site: each by itself, and against each other."""

from collections.abc import Sequence
from dataclasses import dataclass

from skyverse.errors import InputError, require_kind
from skyverse.exports.separation import FleetApart
from skyverse.maps.assembly.options import BuildOptions
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import active_spans
from skyverse.model.short_lines import told_clock
from skyverse.model.timed_shapes import temporary_zones, with_zones_active
from skyverse.model.waypoints import Waypoints
from skyverse.waypoints.check import CheckedMission, check_apart, check_flown
from skyverse.waypoints.flown import FlownMission, flown
from skyverse.waypoints.site import Site, built_site, given_site, require_near, with_fence, with_height

LATE = 600.0
"""Seconds after the end of the last flight until which zones that become active count: it may be late, or return."""
HEADROOM = 50.0
"""Metres of space above the highest place of missions and returns."""


@dataclass(frozen=True, eq=False)
class CheckedFleet:
    """What is found of missions.

    Attributes
    ----------
    scenario
        Where they are flown, with a UAV for each.
    missions
        What is found of each.
    apart
        How each two keep their separation if all start together.
    assumed
        What was taken from defaults of the site, in words.
    """

    scenario: Scenario
    missions: tuple[CheckedMission, ...]
    apart: FleetApart
    assumed: tuple[str, ...]

    @property
    def is_proven(self) -> bool:
        """Whether nothing is wrong with any of them."""
        return all(mission.is_proven for mission in self.missions)


def check_waypoints(
    missions: Sequence[Waypoints], where: Scenario | BuildOptions, settings: FlightSettings | None = None
) -> CheckedFleet:
    """Judge missions as their autopilots fly them.

    Parameters
    ----------
    missions
        What `read_waypoints` returns, one for each vehicle.
    where
        A scenario with an origin, or the maps and limits to make one of; then its area may be left out.
    settings
        What files do not say, and what flies them.

    Raises
    ------
    InputError
        If maps do not cover the places of missions, or orders cannot be followed; the message names file and item.
    """
    settings = settings or FlightSettings()
    require_kind(settings, FlightSettings, "settings")
    require_kind(where, (Scenario, BuildOptions), "where")
    if not missions:
        raise InputError("expected a mission or more, found none", field="missions")
    return check_at(missions, site_of(missions, where, settings), settings, lower=isinstance(where, BuildOptions))


def site_of(missions: Sequence[Waypoints], where: Scenario | BuildOptions, settings: FlightSettings) -> Site:
    """Return where missions are flown: the site that is given, or one made of maps."""
    for one in missions:
        require_near(one, settings)
    if isinstance(where, Scenario):
        return given_site(missions, where, settings)
    return built_site(missions, where, settings)


def check_at(missions: Sequence[Waypoints], site: Site, settings: FlightSettings, *, lower: bool) -> CheckedFleet:
    """Judge missions at a site; `lower` if its bounds are to end where nobody flies."""
    scenario = site.scenario
    flights = [flown(one, scenario, k, site.homes[k], settings) for k, one in enumerate(missions)]
    scenario, closed = _with_zones_closed(scenario, flights)
    if lower:
        ground = 0.0 if scenario.terrain is None else float(scenario.terrain.heights.max())
        above = ground + (scenario.max_height or 0.0)
        scenario = with_height(scenario, max(above, *map(_top, flights)) + HEADROOM)
    checked = [
        check_flown(one, with_fence(scenario, one.waypoints, one.plan.autopilot.name), ground)
        for one, ground in zip(flights, site.grounds, strict=True)
    ]
    apart, checked = check_apart(checked, scenario)
    return CheckedFleet(scenario, tuple(checked), apart, (*site.assumed, *closed))


def _with_zones_closed(scenario: Scenario, flights: Sequence[FlownMission]) -> tuple[Scenario, tuple[str, ...]]:
    """Return a scenario in which zones that are active during flights are closed all the time, and say so in words."""
    until = max(float(one.plan.arrivals[-1]) for one in flights) + LATE
    timed = temporary_zones(scenario)
    spans = {number: active_spans(scenario.zones[number].active) for number in timed}
    closed = [number for number in timed if any(begin <= until and end >= 0 for begin, end in spans[number])]
    said = f"zones with active times count as closed throughout if any is within {told_clock(until)} min of the start"
    return with_zones_active(scenario, closed), (f"{said}, as {len(closed)} of {len(timed)} are",) if timed else ()


def _top(flight: FlownMission) -> float:
    """Return z of the highest place of a flight and of its returns, metres."""
    plan = flight.plan
    return max(float(plan.waypoints[:, 2].max()), float(plan.home[2]) + flight.return_altitude)
