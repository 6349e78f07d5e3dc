"""Writes waypoints for autopilots: proven, on one schedule, with what is proven of them in sentences."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyverse.atomic import write_text
from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilots import MIN_ACCEPTANCE_RADIUS, AutopilotName, autopilot_for, require_return_altitude
from skyverse.exports.flight_plan import FlightPlan, flight_plans
from skyverse.exports.flight_verdicts import FlightVerdict, flight_verdicts
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.landing import (
    ground_notes,
    landing_place,
    require_clear_landings,
    require_landings,
    require_level_landings,
    stand,
)
from skyverse.exports.mavlink_formats import End, geofence, plan_text, waypoints_text
from skyverse.exports.parameters import write_parameters
from skyverse.exports.requirements import file_for_each, write_zip
from skyverse.exports.route import stop_seconds
from skyverse.exports.routes import routes
from skyverse.exports.separation import Apart, FleetApart, fleet_apart
from skyverse.exports.speed_limits import return_warnings, speed_notes, with_limited_speeds
from skyverse.exports.way_home import WayHome, ways_home
from skyverse.exports.waypoint_notes import (
    AS_PLANNED,
    MAX_TOLD,
    OTHER_ENDS,
    few,
    lowered_takeoffs,
    made_for,
    not_apart_when_returning,
    not_in_layers,
    proofs,
    require_returns,
    return_sentences,
    schedule_note,
    start_together,
)
from skyverse.exports.wpml import wpml_parts
from skyverse.model.caution import Caution
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import SAME_PLACE

MAX_HALVINGS = 6
"""How often the acceptance radius is halved where paths are to be apart in space."""


@dataclass(frozen=True)
class WaypointOptions:
    """How waypoints are exported; see `skyverse.export`."""

    altitude: AltitudeReference
    radius: float
    takeoff: float
    end: End
    autopilot: AutopilotName | None
    apart_in_space: bool
    allow_close: bool
    return_altitude: float | None = None


@dataclass(frozen=True, eq=False)
class ExportCertificate:
    """What is proven of exported waypoints.

    Attributes
    ----------
    apart
        How each two UAVs keep their separation.
    returns
        The way home of each UAV that flies, ``None`` for an aeroplane.
    flights
        What matters most of each UAV that flies.
    """

    apart: FleetApart
    returns: tuple[WayHome | None, ...]
    flights: tuple[FlightVerdict, ...]


def export_waypoints(
    mission: Mission,
    scenario: Scenario,
    path: Path,
    suffix: str,
    options: WaypointOptions,
    on_note: Callable[[str], object],
    on_certificate: Callable[[ExportCertificate], object],
) -> list[Path]:
    """Write one file for each UAV, or several where one takes too few waypoints; return their paths.

    Parameters
    ----------
    mission, scenario
        The mission, and its scenario with an origin.
    path, suffix
        Where the files go, and the suffix that tells the format.
    options, on_note, on_certificate
        As for `skyverse.export`.

    Raises
    ------
    InputError
        As `skyverse.export`.
    """
    plans = _plans(mission, scenario, suffix, options)
    returns = _returns(scenario, plans, options.return_altitude)
    if options.end == "rtl":
        require_returns(scenario, [(plan.route.uav, back) for plan, back in zip(plans, returns, strict=True)])
        plans = [with_limited_speeds(scenario, _returning(*each)) for each in zip(plans, returns, strict=True)]
    apart = fleet_apart(scenario, plans)
    flights = flight_verdicts(scenario, plans, options.end, apart, returns)
    on_certificate(ExportCertificate(apart, tuple(returns), flights))
    notes = [*proofs(scenario, plans, from_home=options.altitude == "home")]
    warnings = list(return_warnings(scenario, plans))
    if len(plans) > 1:
        planned = not apart_by_timing_only(mission)
        _require_apart(scenario, apart, plans, options, path, planned=planned)
        notes += apart.sentences(scenario)
        warnings += [*start_together(scenario, apart, asked=options.apart_in_space, planned=planned)]
        if options.end == "rtl" and not apart.only(Apart.SPACE):
            notes.append("These paths contain the returns that end the mission, down to where the UAVs land.")
            warnings += [*not_apart_when_returning(scenario, plans, apart)]
    notes += return_sentences(scenario, plans, returns)
    warnings += not_in_layers(scenario, returns)
    notes += ground_notes(scenario, plans)
    notes += speed_notes(scenario, plans)
    if plans[0].autopilot.rises is None:
        notes += lowered_takeoffs(scenario, plans, options.takeoff)
    notes.append(schedule_note(plans))
    for note in notes:
        on_note(note)
    files = list(_written(path, suffix, scenario, plans, returns, options, on_note))
    backs = zip(plans, returns, strict=True)
    without = [scenario.uavs[plan.route.uav].name for plan, back in backs if back is None or not back.everywhere]
    for warning in warnings:
        on_note(warning)
    if without:
        on_note(
            f"{Caution.WARNING}: no way home is proven at every instant of the flight of {few(without, MAX_TOLD)}: the "
            "table says when."
        )
    return files


def _returns(scenario: Scenario, plans: Sequence[FlightPlan], altitude: float | None) -> list[WayHome | None]:
    """Return the way home of each UAV, at an altitude if one is asked for, ``None`` for aeroplanes."""
    if altitude is not None:
        require_return_altitude(plans[0].autopilot, altitude)
    found = ways_home(scenario, plans, altitude)
    if altitude is not None and None in found:
        raise InputError(
            "aeroplanes return as their autopilots are set: files name no altitude", field="return_altitude"
        )
    return found


def _returning(plan: FlightPlan, back: WayHome | None) -> FlightPlan:
    """Return a flight plan that ends with the return, which `require_returns` knows to be proven."""
    assert back is not None
    home = np.array([*plan.route.points[0][:2], plan.home[2]])
    top, over = plan.waypoints[-1].copy(), home.copy()
    top[2] = over[2] = max(back.level, top[2])
    return replace(plan, ending=np.stack([top, over, home]))


def _plans(mission: Mission, scenario: Scenario, suffix: str, options: WaypointOptions) -> list[FlightPlan]:
    """Return the flight plans, with an acceptance radius that keeps paths apart in space where that is asked."""
    made = autopilot_for(suffix, options.altitude, options.autopilot)
    plans: list[FlightPlan] = []
    for halvings in range(MAX_HALVINGS):
        flown = routes(
            mission,
            altitude=options.altitude,
            origin=scenario.frame.origin,
            radius=max(options.radius / 2**halvings, MIN_ACCEPTANCE_RADIUS) if halvings else options.radius,
            takeoff=options.takeoff if made.rises is None else made.rises[0],
            stops=made.stops,
            autopilot=made.name,
        )
        plans = flight_plans(scenario, flown, made, [stand(scenario, one.uav) for one in flown])
        _require_rises(scenario, plans)
        if options.end != "loiter":
            plans = [_settling(plan) for plan in plans]
        if options.end == "land":
            plans = [replace(plan, ending=landing_place(scenario, plan)[None]) for plan in plans]
            require_level_landings(scenario, plans)
            require_landings(scenario, plans)
            require_clear_landings(scenario, plans)
        plans = [with_limited_speeds(scenario, plan) for plan in plans]
        if not options.apart_in_space or fleet_apart(scenario, plans).only(Apart.SPACE):
            break
    return plans


def _settling(plan: FlightPlan) -> FlightPlan:
    """Return a flight plan whose UAV stays at its last waypoint until it is at rest there, and not only near it."""
    if plan.autopilot.stops:
        return plan
    holds = plan.route.holds.copy()
    holds[-1] = stop_seconds(plan.route.radius)
    return replace(plan, route=replace(plan.route, holds=holds))


def _require_rises(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a file cannot tell its UAV to rise as high as the flight plan has it."""
    for plan in plans:
        if plan.autopilot.rises is None or scenario.uavs[plan.route.uav].fixed_wing is not None:
            continue
        rise, (least, most) = float(plan.waypoints[0][2] - plan.home[2]), plan.autopilot.rises
        if not least - SAME_PLACE <= rise <= most + SAME_PLACE:
            raise InputError(
                f"{scenario.uavs[plan.route.uav].name}: {plan.autopilot.title}'s aircraft first rise by {least:g} to "
                f"{most:g} m, and there is room for {rise:.4g} m above its start"
            )


def _require_apart(
    scenario: Scenario,
    apart: FleetApart,
    plans: Sequence[FlightPlan],
    options: WaypointOptions,
    path: Path,
    *,
    planned: bool,
) -> None:
    """Raise `InputError` where UAVs come too close, or are not apart in space and must be; `planned` if the plan is."""
    if options.apart_in_space and not apart.only(Apart.SPACE):
        left = [text for text in apart.sentences(scenario) if text != apart.sentence(scenario, Apart.SPACE)]
        said = f"{path}: not all paths are apart in space: {left[0]}"
        ended = options.end == "rtl" and [*not_apart_when_returning(scenario, plans, apart)]
        raise InputError(said, give=OTHER_ENDS if ended else ())
    if apart.of(Apart.CLOSE) and not options.allow_close:
        said = apart.certificate(scenario).sentence
        raise InputError(
            f"{path}: as autopilots fly the waypoints, UAVs come too close: {said}",
            give=[*([AS_PLANNED] if planned else []), Remedy("allow_close", True, "to write them all the same")],
        )


def _written(
    path: Path,
    suffix: str,
    scenario: Scenario,
    plans: Sequence[FlightPlan],
    returns: Sequence[WayHome | None],
    options: WaypointOptions,
    on_note: Callable[[str], object],
) -> Iterator[Path]:
    """Write the files of each flight plan and yield their paths; tell of the parameter files beside them."""
    names = [scenario.uavs[plan.route.uav].name for plan in plans]
    fence = geofence(scenario) if suffix == ".plan" else {}
    beside: list[Path | None] = []
    for own, plan, name, back in zip(file_for_each(path, suffix, names), plans, names, returns, strict=True):
        parts = [f"part-{k}-of-{len(plan.parts)}" for k in range(1, len(plan.parts) + 1)]
        for file, part in zip(file_for_each(own, suffix, parts), plan.parts, strict=True):
            if suffix == ".plan":
                write_text(file, plan_text(scenario, plan, options.altitude, options.end, fence))
            elif suffix == ".waypoints":
                write_text(file, waypoints_text(scenario, plan, options.altitude, options.end))
            else:
                write_zip(file, wpml_parts(scenario, plan, part, options.altitude, options.end, back))
            yield file
        beside.append(write_parameters(own, suffix, plan, name, back))
    for note in made_for(plans, names, beside):
        on_note(note)
