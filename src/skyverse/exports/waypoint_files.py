"""Writes waypoints for autopilots: proven, on one schedule, with what is proven of them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from skyverse.atomic import write_text
from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilots import MIN_ACCEPTANCE_RADIUS, autopilot_for, require_return_altitude
from skyverse.exports.flight_plan import FlightPlan, flight_plans
from skyverse.exports.landing import landing_places, require_landings, stands
from skyverse.exports.mavlink_formats import FlightFile, geofence, plan_text, waypoints_text
from skyverse.exports.parameters import write_parameters
from skyverse.exports.report import (
    AS_PLANNED,
    MAX_TOLD,
    OTHER_ENDS,
    ExportCertificate,
    ExportedFleet,
    cautions,
    details,
    flight_verdicts,
    loading,
    not_apart_when_returning,
)
from skyverse.exports.requirements import ExportOptions, file_for_each, write_zip
from skyverse.exports.route import stop_seconds
from skyverse.exports.routes import routes
from skyverse.exports.separation import Apart, FleetApart, few, fleet_apart
from skyverse.exports.speed_limits import with_limited_speeds
from skyverse.exports.way_home import WayHome, ways_home
from skyverse.exports.wpml import wpml_parts
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import SAME_PLACE

MAX_HALVINGS = 6
"""How often the acceptance radius is halved where paths are to be apart in space."""
WRITERS: dict[str, Callable[[Path, FlightFile], None]] = {
    ".plan": lambda path, flight: write_text(path, plan_text(flight)),
    ".waypoints": lambda path, flight: write_text(path, waypoints_text(flight)),
    ".wpml.kmz": lambda path, flight: write_zip(path, wpml_parts(flight)),
}


def export_waypoints(
    mission: Mission, path: Path, suffix: str, options: ExportOptions
) -> tuple[list[Path], ExportCertificate, list[str]]:
    """Write one file for each UAV, or several where one takes too few waypoints.

    Returns
    -------
    tuple of list of Path, ExportCertificate and list of str
        The files, what is proven of them, and what is said of them; raises `InputError` as `skyverse.export` does.
    """
    scenario, altitude = mission.scenario, options.return_altitude
    plans = _plans(mission, suffix, options)
    if altitude is not None:
        require_return_altitude(plans[0].autopilot, altitude)
    returns = ways_home(scenario, plans, altitude)
    if altitude is not None and None in returns:
        said = "aeroplanes return as their autopilots are set: files name no altitude"
        raise InputError(said, field="return_altitude")
    if options.end == "rtl":
        _require_returns(scenario, [(plan.route.uav, back) for plan, back in zip(plans, returns, strict=True)])
        plans = [with_limited_speeds(scenario, _returning(*each)) for each in zip(plans, returns, strict=True)]
    apart = fleet_apart(scenario, plans)
    planned = not apart_by_timing_only(mission)
    _require_apart(scenario, apart, plans, options, path, planned=planned)
    files, rates = _written(path, suffix, scenario, plans, returns, options)
    told = ExportedFleet(mission, plans, returns, apart, options)
    notes = [*cautions(told, planned=planned), *loading(told, rates), *details(told)]
    return files, ExportCertificate(apart, tuple(returns), flight_verdicts(told)), notes


def _require_returns(scenario: Scenario, backs: Sequence[tuple[int, WayHome | None]]) -> None:
    """Raise `InputError` if any UAVs have no way home from the end of their flights, and say why.

    `backs` are the indices of UAVs and their ways home, ``None`` for aeroplanes.
    """
    stay = [Remedy("end", "loiter", "to stay at the target")]
    planes = [scenario.uavs[uav].name for uav, back in backs if back is None]
    if planes:
        raise InputError(f"{', '.join(planes)}: the return of an aeroplane cannot be proven", field="end", give=stay)
    lost = [(scenario.uavs[uav].name, back) for uav, back in backs if back is not None and not back.ends_safely]
    if lost:
        told = [f"{name}: at {back.altitude:.4g} m above home {back.gaps[-1].why}" for name, back in lost]
        raise InputError(f"no way home is proven from the last waypoint: {few(told, MAX_TOLD)}", field="end", give=stay)


def _returning(plan: FlightPlan, back: WayHome | None) -> FlightPlan:
    """Return a flight plan that ends with the return, which `_require_returns` knows to be proven."""
    assert back is not None
    home = np.array([*plan.route.points[0][:2], plan.home[2]])
    top, over = plan.waypoints[-1].copy(), home.copy()
    top[2] = over[2] = max(back.level, top[2])
    return replace(plan, ending=np.stack([top, over, home]))


def _plans(mission: Mission, suffix: str, options: ExportOptions) -> list[FlightPlan]:
    """Return the flight plans, with an acceptance radius that keeps paths apart in space where that is asked."""
    scenario, made = mission.scenario, autopilot_for(suffix, options.altitude, options.autopilot)
    plans: list[FlightPlan] = []
    for halvings in range(MAX_HALVINGS):
        flown = routes(
            mission,
            altitude=options.altitude,
            radius=max(options.radius / 2**halvings, MIN_ACCEPTANCE_RADIUS) if halvings else options.radius,
            takeoff=options.takeoff if made.rises is None else made.rises[0],
            stops=made.stops,
            autopilot=made.name,
        )
        plans = flight_plans(scenario, flown, made, stands(scenario, [one.uav for one in flown]))
        _require_rises(scenario, plans)
        if options.end != "loiter":
            plans = [_settling(plan) for plan in plans]
        if options.end == "land":
            places = landing_places(scenario, plans)
            plans = [replace(plan, ending=place[None]) for plan, place in zip(plans, places, strict=True)]
            require_landings(scenario, plans)
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
    options: ExportOptions,
    path: Path,
    *,
    planned: bool,
) -> None:
    """Raise `InputError` where UAVs come too close, or are not apart in space and must be; `planned` if the plan is."""
    if options.apart_in_space and not apart.only(Apart.SPACE):
        left = next(text for kind, text in apart.sentences(scenario) if kind is not Apart.SPACE)
        ended = options.end == "rtl" and [*not_apart_when_returning(scenario, plans, apart)]
        raise InputError(f"{path}: not all paths are apart in space: {left}", give=OTHER_ENDS if ended else ())
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
    options: ExportOptions,
) -> tuple[list[Path], list[Path | None]]:
    """Write the files of each flight plan; return their paths, and those of the parameter files beside them."""
    names = [scenario.uavs[plan.route.uav].name for plan in plans]
    fence, files, rates = geofence(scenario), list[Path](), list[Path | None]()
    for own, plan, name, back in zip(file_for_each(path, suffix, names), plans, names, returns, strict=True):
        parts = [f"part-{k}-of-{len(plan.parts)}" for k in range(1, len(plan.parts) + 1)]
        for file, part in zip(file_for_each(own, suffix, parts), plan.parts, strict=True):
            WRITERS[suffix](file, FlightFile(scenario, plan, part, options.altitude, options.end, back, fence))
            files.append(file)
        rates.append(write_parameters(own, suffix, plan, name, back))
    return files, rates
