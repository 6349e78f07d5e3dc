"""Makes files of waypoints for autopilots: proven, on one schedule, with what is proven of them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from skyverse.deconfliction.paths_apart import apart_by_timing_only
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilots import MIN_ACCEPTANCE_RADIUS, autopilot_for, require_return_altitude
from skyverse.exports.expected_photos import photo_files
from skyverse.exports.fleet_routes import routes
from skyverse.exports.flight_plan import FlightPlan, flight_plans, in_turn
from skyverse.exports.landing import landing_places, require_landings, stands, starts_in_the_air
from skyverse.exports.litchi import litchi_settings, litchi_text
from skyverse.exports.mavlink_formats import FlightFile, geofence, plan_text, waypoints_text
from skyverse.exports.parameters import parameter_file, parameters_text
from skyverse.exports.report import (
    AS_PLANNED,
    MAX_TOLD,
    OTHER_ENDS,
    cautions,
    details,
    flight_sheet,
    flown_summary,
    loading,
    not_apart_when_returning,
)
from skyverse.exports.requirements import Contents, ExportOptions, file_for_each
from skyverse.exports.return_altitudes import ways_home
from skyverse.exports.route import stop_seconds
from skyverse.exports.separation import Apart, FleetApart, few, fleet_apart
from skyverse.exports.speed_limits import with_limited_speeds
from skyverse.exports.verdicts import ExportCertificate, ExportedFleet, flight_verdicts
from skyverse.exports.way_home import WayHome, moved
from skyverse.exports.wpml import wpml_parts
from skyverse.model.caution import Caution
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import SAME_PLACE

MAX_HALVINGS = 6
"""How often the acceptance radius is halved where paths are to be apart in space."""
FORMATS: dict[str, Callable[[FlightFile], str | dict[str, str]]] = {
    ".plan": plan_text,
    ".waypoints": waypoints_text,
    ".wpml.kmz": wpml_parts,
    ".litchi.csv": litchi_text,
}


class WaypointFiles(NamedTuple):
    """What is to be written, the files of waypoints among it, what is proven of them, and what is said."""

    contents: Contents
    files: list[Path]
    certificate: ExportCertificate
    notes: list[str]
    sheet: tuple[tuple[str, ...], ...]


def waypoint_files(mission: Mission, path: Path, suffix: str, options: ExportOptions) -> WaypointFiles:
    """Make one file for each UAV, or several where one takes too few waypoints.

    Raises
    ------
    InputError
        As `skyverse.export` does.
    """
    scenario, altitude = mission.scenario, options.return_altitude
    plans = _plans(mission, suffix, options)
    if options.altitude == "home":
        _require_launch_places(scenario, plans)
    if altitude is not None:
        require_return_altitude(plans[0].autopilot, altitude)
    returns, higher = ways_home(scenario, plans, altitude), []
    lost = any(back is not None and back.gaps for back in returns)
    if lost and options.end != "rtl" and None not in (scenario.terrain, scenario.max_height):
        returns = ways_home(derived(scenario, max_height=None), plans, altitude)
        above = f"the ceiling of {scenario.max_height:g} m above ground"
        higher = [f"Ways home are {Caution.NOT} held to {above}, as they are for emergencies, which may lead higher."]
    if altitude is not None and None in returns:
        said = "aeroplanes return as their autopilots are set: files name no altitude"
        raise InputError(said, field="return_altitude")
    if options.end == "rtl":
        _require_returns(scenario, list(zip(plans, returns, strict=True)))
        plans = [with_limited_speeds(scenario, _returning(*each)) for each in zip(plans, returns, strict=True)]
        plans = in_turn(scenario, plans)
        returns = [moved(back, plan) for back, plan in zip(returns, plans, strict=True)]
    apart = fleet_apart(scenario, plans)
    planned = not apart_by_timing_only(mission)
    _require_apart(scenario, apart, plans, options, path, planned=planned)
    told = ExportedFleet(mission, plans, returns, apart, options)
    _require_batteries(told, path)
    contents, loads = _contents(path, suffix, told)
    rates = [files[-1] if len(files) > len(plan.parts) else None for files, plan in zip(loads, plans, strict=True)]
    settings = [litchi_settings(told)] if suffix == ".litchi.csv" else []
    notes = [*cautions(told, planned=planned), *higher, *settings, *loading(told, rates), *details(told)]
    certificate = ExportCertificate(apart, tuple(returns), flight_verdicts(told))
    files = [file for own in loads for file in own if file not in rates]
    return WaypointFiles(contents, files, certificate, notes, flight_sheet(told, loads))


def _require_batteries(fleet: ExportedFleet, path: Path) -> None:
    """Raise `InputError` for flights whose batteries are empty before they land, as autopilots fly the waypoints."""
    left = {fleet.name(plan): flown_summary(fleet, plan).left for plan in fleet.plans}
    empty = [f"{name} with {share:.0%}" for name, share in left.items() if share is not None and share < 0.0]
    if empty:
        raise InputError(
            f"{path}: as autopilots fly the waypoints, batteries are empty before they land: {few(empty, MAX_TOLD)} "
            "left; take another format, whose autopilot does not stop at each waypoint, more UAVs or larger batteries"
        )


def _require_launch_places(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` for flights with photos whose heights are counted from ground that nobody knows."""
    flown = [plan.route for plan in plans if plan.route.runs]
    unknown = [one.name(scenario) for one in flown if starts_in_the_air(scenario, one.uav)]
    if unknown:
        raise InputError(
            f"{few(unknown, MAX_TOLD)}: expected a known height of the ground where it is launched, as the heights of "
            "its photos are counted from there, found a start in the air, no home and no terrain"
        )


def _require_returns(scenario: Scenario, backs: Sequence[tuple[FlightPlan, WayHome | None]]) -> None:
    """Raise `InputError` if any UAVs have no way home from the end of their flights, and say why.

    `backs` are the flights and their ways home, ``None`` for aeroplanes.
    """
    stay = [Remedy("end", "loiter", "to stay at the target")]
    planes = [plan.route.name(scenario) for plan, back in backs if back is None]
    if planes:
        raise InputError(f"{', '.join(planes)}: the return of an aeroplane cannot be proven", field="end", give=stay)
    lost = [(plan.route.name(scenario), back) for plan, back in backs if back is not None and not back.ends_safely]
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
            through=suffix != ".litchi.csv",
        )
        plans = flight_plans(scenario, flown, made, stands(scenario, [one.uav for one in flown]))
        _require_rises(scenario, plans)
        plans = _landing(scenario, [_settling(_ending(scenario, plan, options)) for plan in plans])
        plans = in_turn(scenario, [with_limited_speeds(scenario, plan) for plan in plans])
        if not options.apart_in_space or fleet_apart(scenario, plans).only(Apart.SPACE):
            break
    return plans


def _ending(scenario: Scenario, plan: FlightPlan, options: ExportOptions) -> FlightPlan:
    """Return a flight plan that ends as is asked; at home a multirotor lands where others stay."""
    lands = plan.route.to_home and options.end == "loiter" and scenario.uavs[plan.route.uav].fixed_wing is None
    return replace(plan, end="land" if lands else options.end)


def _landing(scenario: Scenario, plans: Sequence[FlightPlan]) -> list[FlightPlan]:
    """Return flight plans that end with the landing where that is asked, or raise `InputError` where none can land."""
    landing = [plan for plan in plans if plan.end == "land"]
    if not landing:
        return list(plans)
    places = iter(landing_places(scenario, landing))
    made = [replace(plan, ending=next(places)[None]) if plan.end == "land" else plan for plan in plans]
    require_landings(scenario, [plan for plan in made if plan.end == "land"])
    return made


def _settling(plan: FlightPlan) -> FlightPlan:
    """Return a flight plan whose UAV stays at its last waypoint until it is at rest there, and not only near it."""
    if plan.autopilot.stops or plan.end == "loiter":
        return plan
    holds = plan.route.holds.copy()
    holds[-1] = max(holds[-1], stop_seconds(plan.route.radius))
    return replace(plan, route=replace(plan.route, holds=holds))


def _require_rises(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a file cannot tell its UAV to rise as high as the flight plan has it."""
    for plan in plans:
        if plan.autopilot.rises is None or scenario.uavs[plan.route.uav].fixed_wing is not None:
            continue
        rise, (least, most) = float(plan.waypoints[0][2] - plan.home[2]), plan.autopilot.rises
        if not least - SAME_PLACE <= rise <= most + SAME_PLACE:
            raise InputError(
                f"{plan.route.name(scenario)}: {plan.autopilot.title}'s aircraft first rise by {least:g} to "
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


def _contents(path: Path, suffix: str, fleet: ExportedFleet) -> tuple[Contents, list[list[Path]]]:
    """Return all files, and those of each flight plan that are loaded, in their order, parameters last."""
    names = [plan.route.name(fleet.scenario, "-sortie-") for plan in fleet.plans]
    fence, contents, loads = geofence(fleet.scenario), Contents(), list[list[Path]]()
    for own, plan, back in zip(file_for_each(path, suffix, names), fleet.plans, fleet.returns, strict=True):
        parts = [f"part-{k}-of-{len(plan.parts)}" for k in range(1, len(plan.parts) + 1)]
        loads.append(list(file_for_each(own, suffix, parts)))
        for file, part in zip(loads[-1], plan.parts, strict=True):
            item = fleet.options.survey_item
            flight = FlightFile(fleet.scenario, plan, part, fleet.options.altitude, plan.end, back, fence, item)
            contents[file] = FORMATS[suffix](flight)
        contents |= photo_files(fleet.mission, plan, own, suffix)
        rates = parameter_file(own, suffix, plan)
        if rates is not None:
            contents[rates] = parameters_text(plan, fleet.scenario.uavs[plan.route.uav], back)
            loads[-1].append(rates)
    return contents, loads
