"""Writes waypoints for autopilots: proven, on one schedule, with what is proven of them in sentences."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilots import AutopilotName, autopilot_for
from skyverse.exports.file_names import file_for_each, write_zip
from skyverse.exports.flight_plan import FlightPlan, flight_plans
from skyverse.exports.global_positions import AltitudeReference, home_on_globe
from skyverse.exports.landing import landing_place, stand
from skyverse.exports.mavlink_items import End
from skyverse.exports.parameters import write_parameters
from skyverse.exports.qgc_plan import geofence, plan_text
from skyverse.exports.route import MIN_ACCEPTANCE_RADIUS
from skyverse.exports.routes import routes
from skyverse.exports.separation import Apart, FleetApart, fleet_apart
from skyverse.exports.wpl import waypoints_text
from skyverse.exports.wpml import wpml_parts
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario

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


def export_waypoints(
    mission: Mission,
    scenario: Scenario,
    path: Path,
    suffix: str,
    options: WaypointOptions,
    on_note: Callable[[str], object],
    on_certificate: Callable[[FleetApart], object],
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
    notes = [*_proofs(scenario, plans, options, path)]
    if len(plans) > 1:
        apart = fleet_apart(scenario, plans)
        on_certificate(apart)
        _require_apart(scenario, apart, options, path)
        notes += apart.sentences(scenario)
    for note in notes:
        on_note(note)
    return list(_written(path, suffix, scenario, plans, options, on_note))


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
            takeoff=0.0 if made.stops else options.takeoff,
            stops=made.stops,
        )
        plans = flight_plans(scenario, flown, made, [stand(scenario, one.uav) for one in flown])
        if options.end == "land":
            plans = [replace(plan, ending=landing_place(scenario, plan)[None]) for plan in plans]
        if made.stops or not options.apart_in_space or fleet_apart(scenario, plans).only(Apart.SPACE):
            break
    return plans


def _proofs(scenario: Scenario, plans: Sequence[FlightPlan], options: WaypointOptions, path: Path) -> Iterator[str]:
    """Yield sentences on what is proven of each flight plan."""
    for plan in plans:
        yield plan.route.sentence(scenario)
        if plan.breaks:
            name, most = scenario.uavs[plan.route.uav].name, plan.autopilot.max_waypoints
            yield f"{name}: {len(plan.parts)} files of at most {most} waypoints; after each it waits for the next."
    if options.altitude == "home":
        for plan in plans:
            yield _home_note(scenario, plan.route.uav)


def _require_apart(scenario: Scenario, apart: FleetApart, options: WaypointOptions, path: Path) -> None:
    """Raise `InputError` where UAVs come too close, or their paths are not apart in space and should be."""
    if options.apart_in_space and not apart.only(Apart.SPACE):
        left = [text for text in apart.sentences(scenario) if text != apart.sentence(scenario, Apart.SPACE)]
        raise InputError(f"{path}: not all paths are apart in space: {left[0]}", give=[Remedy("apart_in_space", False)])
    if apart.of(Apart.CLOSE) and not options.allow_close:
        said = apart.certificate(scenario).sentence
        raise InputError(
            f"{path}: as autopilots fly the waypoints, UAVs come too close: {said}",
            give=[Remedy("allow_close", True, "to write them all the same")],
        )


def _home_note(scenario: Scenario, uav: int) -> str:
    at = round(home_on_globe(scenario, uav)[2], 2)
    return (
        f"{scenario.uavs[uav].name}: its heights are counted from home at {at + 0.0:.2f} m above mean sea level; where "
        "it arms lower than that, it flies as much lower."
    )


def _written(
    path: Path,
    suffix: str,
    scenario: Scenario,
    plans: Sequence[FlightPlan],
    options: WaypointOptions,
    on_note: Callable[[str], object],
) -> Iterator[Path]:
    """Write the files of each flight plan and yield their paths; tell of the parameter files beside them."""
    names = [scenario.uavs[plan.route.uav].name for plan in plans]
    fence = geofence(scenario) if suffix == ".plan" else {}
    for own, plan, name in zip(file_for_each(path, suffix, names), plans, names, strict=True):
        parts = [f"part-{k}-of-{len(plan.parts)}" for k in range(1, len(plan.parts) + 1)]
        for file, part in zip(file_for_each(own, suffix, parts), plan.parts, strict=True):
            if suffix == ".plan":
                write_text(file, plan_text(scenario, plan, options.altitude, options.end, fence))
            elif suffix == ".waypoints":
                write_text(file, waypoints_text(scenario, plan, options.altitude, options.end))
            else:
                write_zip(file, wpml_parts(scenario, plan, part, options.altitude, options.end))
            yield file
        beside = write_parameters(own, suffix, plan, name)
        if beside is not None:
            on_note(f"{name}: made for {plan.autopilot.title}, with the rates of {beside}: load them into it first.")
