"""What exports say of waypoints: a line for each thing that a pilot must heed, and all that is proven."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from skyverse.draw import LandingPlace, page, scene
from skyverse.errors import Remedy, Sentence
from skyverse.exports.autopilots import LOOKS
from skyverse.exports.camera_items import look_late
from skyverse.exports.flight_plan import SPEED_TOLERANCE, FlightPlan
from skyverse.exports.global_positions import home_on_globe, origin_of
from skyverse.exports.landing import slow_touch_down, starts_in_the_air, why_not_level
from skyverse.exports.separation import Apart, FleetApart, few, fleet_apart, named_pairs
from skyverse.exports.speed_limits import may_return_too_fast, zones_of
from skyverse.exports.verdicts import ExportCertificate, ExportedFleet, verdict_table
from skyverse.exports.way_home import WayHome, layer
from skyverse.exports.way_home_space import CLEARANCE_SHARE
from skyverse.model.caution import Caution
from skyverse.model.flight_table import NO_VALUE
from skyverse.model.geodesy import to_wgs84, told_globe
from skyverse.model.mission import FlightSummary, Mission
from skyverse.model.power import JOULES_OF_WATT_HOUR
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted, told_seconds
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.space.pads import fleet_pads, pads_sentence
from skyverse.space.tracking_error import NO_ERROR
from skyverse.summary import flight_summary
from skyverse.tour_table import told_home

MAX_TOLD = 6
"""UAVs that one sentence names; of more it says only how many."""
LAUNCH = 1.0
"""Metres by which the place of a launch may be off, level and in height."""
HIGH = 120.0
"""Metres above home: most rules allow no more above ground."""
AS_PLANNED = Remedy("apart_in_space", True, "to export them apart in space as planned")
"""What helps UAVs that are apart in space as planned, but not on the waypoints."""
OTHER_ENDS = (
    Remedy("end", "land", "to land below the last waypoints"),
    Remedy("end", "loiter", "to stay there"),
)
"""What helps UAVs that are not apart in space on the returns that end their mission."""


def cautions(fleet: ExportedFleet, *, planned: bool) -> Iterator[str]:
    """Yield what a pilot must heed, one line for each thing; `planned` if the mission is apart in space as planned."""
    scenario = fleet.scenario
    _, plans, returns, apart, options = fleet
    if options.altitude == "home":
        homes = [f"{uav.name} {home_on_globe(scenario, k)[2]:z.2f} m" for k, uav in fleet.flying.items()]
        yield (
            f"{Caution.BEFORE} each flight, compare home, above mean sea level: {few(homes, MAX_TOLD)}; where a UAV "
            "arms lower, it flies as much lower."
        )
    if scenario.terrain is not None and not any(shape.solid for shape in scenario.obstacles):
        yield (
            f"{Caution.WARNING}: the scenario knows the ground and no obstacles: trees, buildings and water are "
            "unknown; look at where UAVs fly low and land."
        )
    for names, said in _warnings(fleet):
        if names:
            yield f"{Caution.WARNING}: {said.format(few(names, MAX_TOLD))}"
    timed = [pair for pair, kind in apart.pairs.items() if kind in (Apart.TIMING, Apart.SCHEDULE)]
    if timed:
        said = f"{Caution.ONLY} apart if they start at the same time: {named_pairs(scenario, timed)}"
        yield Sentence(said, give=[AS_PLANNED]) if planned and not options.apart_in_space else f"{said}."
    later = [f"{fleet.name(plan)} at t = {told_seconds(plan.begin)}" for plan in plans if plan.begin]
    if later:
        yield f"{Caution.BEFORE} later sorties, change the battery, and start them in time: {few(later, MAX_TOLD)}."
    parts = [f"{fleet.name(plan)} in {len(plan.parts)}" for plan in plans if plan.breaks]
    if parts:
        most, title = plans[0].autopilot.max_waypoints, plans[0].autopilot.title
        yield (
            f"{Caution.BEFORE} each flight, load all its parts: {few(parts, MAX_TOLD)}, as {title} takes {most} "
            "waypoints in a file at most. At the end of a part it hovers until you start the next: do so at once, "
            "without landing; what it takes of the battery to wait is not counted."
        )
    yield from _low_batteries(fleet)
    if options.end == "rtl":
        yield from not_apart_when_returning(scenario, plans, apart)
    near = [
        (a.plan.route.uav, b.plan.route.uav)
        for a, b in combinations([back for back in returns if back is not None], 2)
        if a.plan.route.uav != b.plan.route.uav
        and abs(a.level - b.level) < layer(scenario, a.plan, b.plan) - SAME_PLACE
    ]
    if near:
        yield (
            f"{Caution.WARNING}: return altitudes are less than a separation apart: {named_pairs(scenario, near)}; "
            "let one land before the other returns."
        )


def _warnings(fleet: ExportedFleet) -> Iterator[tuple[list[str], str]]:
    """Yield of which UAVs, or of nobody, each warning is, and what it says."""
    scenario, plans = fleet.scenario, fleet.plans
    yield (
        [uav.name for k, uav in fleet.flying.items() if starts_in_the_air(scenario, k)],
        "homes that are not known, as the scenario has no terrain, and are taken to be the starts: {}. Where a UAV "
        "arms lower, it returns as much lower than is proven: state its home.",
    )
    uavs = [scenario.uavs[plan.route.uav] for plan in plans]
    known = {
        plan.route.uav: plan.home
        for plan, uav in zip(plans, uavs, strict=True)
        if uav.fixed_wing is None and (scenario.terrain is not None or uav.home is not None)
    }
    yield (
        [scenario.uavs[k].name for k, home in known.items() if why_not_level(scenario, k, home) is not None],
        "homes that are not level: {}. Choose other starts, or level the places.",
    )
    farthest = [float(np.linalg.norm((plan.waypoints - plan.home)[:, :2], axis=1).max()) for plan in plans]
    slow = [
        f"{fleet.name(plan)} at {plan.top_speed:.3g} m/s from {away:,.0f} m away, {away / plan.top_speed:,.0f} s"
        for plan, uav, away in zip(plans, uavs, farthest, strict=True)
        if plan.top_speed < uav.max_speed / 2
    ]
    yield slow, "returns are as slow as the slowest zone demands, wherever that zone is: {}."
    yield (
        [fleet.name(plan) for plan in plans if may_return_too_fast(scenario, plan)],
        "the speed limits of zones are not proven of the returns of {}.",
    )
    flown = [back for back in fleet.returns if back is not None]
    yield (
        [f"{fleet.name(back.plan)} {back.altitude:.4g} m" for back in flown if back.altitude > HIGH],
        f"return altitudes of more than {HIGH:g} m above home, where most rules end: {{}}; give a lower one, or ask "
        "the air traffic authority.",
    )
    backs = zip(plans, fleet.returns, strict=True)
    yield (
        [fleet.name(plan) for plan, back in backs if back is None or not back.everywhere],
        "the way home of {} is not proven at every instant: the table says when not.",
    )


def not_apart_when_returning(scenario: Scenario, plans: Sequence[FlightPlan], apart: FleetApart) -> Iterator[Sentence]:
    """Yield a warning on the UAVs that are apart in space up to their last waypoints, but not on the returns."""
    if apart.only(Apart.SPACE):
        return
    before = fleet_apart(scenario, [replace(plan, ending=plan.ending[:0]) for plan in plans])
    pairs = [pair for pair in before.of(Apart.SPACE) if apart.pairs[pair] is not Apart.SPACE]
    if pairs:
        yield Sentence(
            f"{Caution.WARNING}: apart in space up to their last waypoints, but {Caution.NOT} on the returns that end "
            f"the mission: {named_pairs(scenario, pairs)}",
            give=OTHER_ENDS,
        )


def loading(fleet: ExportedFleet, parameter_files: Sequence[Path | None]) -> Iterator[str]:
    """Yield what parameter files are to be loaded."""
    files = zip(parameter_files, fleet.plans, strict=True)
    rates = [f"{file} into {fleet.name(plan)}" for file, plan in files if file is not None]
    title = fleet.plans[0].autopilot.title
    if rates:
        yield f"{Caution.BEFORE} the first flight, load the rates for {title}: {few(rates, MAX_TOLD)}."
    else:
        yield f"Made for {title}."


def details(fleet: ExportedFleet) -> Iterator[str]:
    """Yield all that is proven, of each UAV and of the fleet."""
    scenario = fleet.scenario
    mission, plans, _, apart, options = fleet
    for plan, back in zip(plans, fleet.returns, strict=True):
        corners = plan.route.corners if plan.corners_proven else f"corners {Caution.NOT} proven"
        yield plan.route.sentence(scenario, corners)
        rise = float(plan.waypoints[0][2] - plan.home[2])
        if plan.autopilot.rises is None and np.isfinite(plan.rates.climb) and rise < options.takeoff - SAME_PLACE:
            yield (
                f"{fleet.name(plan)}: its take-off ends {rise:.4g} m above where it stands, as there is no room to "
                f"rise by {options.takeoff:g} m."
            )
        yield from _of_photos(fleet, plan)
        if battery := told_battery(fleet, plan):
            yield f"{fleet.name(plan)}: it {battery}."
        yield from _of_way_home(fleet, plan, back)
    if pads := pads_sentence(scenario, fleet_pads(mission)):
        yield pads
    yield from (said for _, said in apart.sentences(scenario))
    if any(zones_of(scenario, plan.route.uav) for plan in plans):
        yield (
            "The commanded speeds keep the speed limits of zones, also where an autopilot flies up to "
            f"{SPEED_TOLERANCE:.0%} faster than it is told; returns do where the parameter file is loaded. Wind, and "
            "the turns and circles of aeroplanes, are not counted."
        )
    first = [plan for plan in plans if plan.route.sortie <= 1]
    late = max(
        float(plan.arrivals[0] + plan.hover - plan.route.waypoint_holds[0] - plan.route.waypoint_times[0])
        for plan in first
    )
    later = told_seconds(max(late, 0.0))
    begin = "when they do in the mission"  # as of aeroplanes, which do not take off
    if later != told_seconds(0.0):
        begin = f"{later} later than in the mission, when all take-offs have ended"
    yield (
        "All times are of the exported schedule: second 0 is when all UAVs start together, and trajectories begin "
        f"{begin}."
    )


def flown_summary(fleet: ExportedFleet, plan: FlightPlan) -> FlightSummary:
    """Return what a flight takes as its autopilot flies the waypoints, touch-down and all."""
    uav, ground = fleet.scenario.uavs[plan.route.uav], [slow_touch_down(fleet.scenario, plan)]
    return flight_summary(uav, plan.waypoints, plan.predicted(), fleet.scenario.wind, ground=ground)


def _low_batteries(fleet: ExportedFleet) -> Iterator[str]:
    """Yield a warning on the flights that take more than their batteries give, reserve apart."""
    low = []
    for plan in fleet.plans:
        left, reserve = flown_summary(fleet, plan).left, fleet.scenario.uavs[plan.route.uav].reserve
        if left is not None and left < reserve:
            low.append(f"{fleet.name(plan)} with {left:.1%} left of {reserve:.0%}")
    if low:
        yield (
            f"{Caution.WARNING}: as autopilots fly the waypoints, batteries do not give it with their reserves: "
            f"{few(low, MAX_TOLD)}; plan with larger reserves."
        )


def told_battery(fleet: ExportedFleet, plan: FlightPlan) -> str:
    """Return what a flight takes of its battery, and what must be left; nothing where that is not known."""
    taken = flown_summary(fleet, plan)
    if taken.energy_bound is None or taken.left is None:
        return ""
    energy, uav = taken.energy_bound / JOULES_OF_WATT_HOUR, fleet.scenario.uavs[plan.route.uav]
    return (
        f"takes {energy:.1f} of {uav.battery:g} Wh in {told_seconds(taken.time)} and leaves {taken.left:.1%} of its "
        f"battery; {uav.reserve:.0%} must be left"
    )


def _of_photos(fleet: ExportedFleet, plan: FlightPlan) -> Iterator[str]:
    """Yield how a flight takes its photos, from where, and what of it is not proven."""
    runs, name = plan.route.runs, fleet.name(plan)
    if not runs:
        return
    stops, (latitude, longitude, ground) = plan.full_stops, fleet.place(plan.home)
    alone, spans = sum(run.on == run.off for run in runs), [run for run in runs if run.on < run.off]
    photos = counted(sum(run.count for run in runs), "photo")
    strips, held = {run.strip for run in spans}, {run.strip for run in spans if stops[run.on] or stops[run.off]}
    parts = [f"{len(strips - held)} of {counted(len(strips), 'strip')} flown through"] if spans else []
    parts += [f"{alone} taken standing"] if alone else []
    yield (
        f"{name}: {photos} in {told_seconds(float(plan.arrivals[-1]) - plan.begin)}, {', '.join(parts)}; launch it "
        f"within {LAUNCH:g} m of {told_globe(latitude, longitude)} and {LAUNCH:g} m of {ground:z.1f} m above mean sea "
        "level."
    )
    late = max((look_late(plan, run) * (run.count - 1) for run in spans), default=0.0)
    if late and all(run.trigger == "distance" for run in spans):
        every = 1000 * LOOKS[plan.autopilot.name]
        yield (
            f"{name}: {plan.autopilot.title} looks at the distance every {every:.0f} ms, half of which is counted in: "
            f"where on its longest strip the last photo is, within {late:.2g} m, is {Caution.NOT} proven."
        )
    if not plan.corners_proven:
        yield f"{name}: it switches its camera where it turns, at a distance of its own: that is {Caution.NOT} proven."
    if plan.autopilot.name == "dji" and strips - held:
        yield f"{name}: how DJI's aircraft turn is not published: bends and run-ins of strips are {Caution.NOT} proven."
    if any(run.trigger == "time" for run in spans):
        yield f"{name}: photos by time are as far off their places as its speed is off: that is {Caution.NOT} proven."
    if fleet.options.survey_item:
        yield (
            f"{name}: whoever edits its survey item in QGroundControl puts other waypoints in place of these, which "
            f"are {Caution.NOT} proven."
        )


def _of_way_home(fleet: ExportedFleet, plan: FlightPlan, back: WayHome | None) -> Iterator[str]:
    """Yield sentences on the way home of a flight plan, and what it keeps."""
    scenario, name = fleet.scenario, fleet.name(plan)
    if back is None:
        yield f"{name}: no way home is proven of an aeroplane; choose the altitude of its return yourself."
        return
    latitude, longitude, ground = fleet.place(plan.home)
    yield (
        f"{name}: it returns at {back.altitude:.4g} m above home, which is at {told_globe(latitude, longitude)}, "
        f"{ground:z.1f} m above mean sea level, or as high as it is if that is higher."
    )
    if not back.nowhere:
        kept = f"{CLEARANCE_SHARE * scenario.clearance:.4g} m"
        if scenario.terrain is not None and scenario.ground_clearance < scenario.clearance:
            kept += f", above ground by {CLEARANCE_SHARE * scenario.ground_clearance:.4g} m"
        error = " and its tracking error" if scenario.uavs[plan.route.uav].tracking_error != NO_ERROR else ""
        when = "at every other instant" if back.gaps else "at every instant"
        yield f"{name}: its way home is proven {when}: climb, level way and descent are clear by {kept}{error}."
    for gap in back.gaps[:MAX_TOLD]:
        latitude, longitude, sea = fleet.place(gap.place)
        yield (
            f"{name}: no way home is proven from t = {told_seconds(gap.begin)} to {told_seconds(gap.end)}: {gap.why}, "
            f"from {told_globe(latitude, longitude)}, {sea:z.0f} m above mean sea level."
        )


def flight_sheet(fleet: ExportedFleet, loads: Sequence[Sequence[Path]]) -> tuple[tuple[str, ...], ...]:
    """Return the head and rows of the table for whoever prepares the flights; `loads` are the files of each."""
    head = ("flight", "load, in this order", "home", "returns at", "starts", "battery")
    rows = []
    for plan, back, files in zip(fleet.plans, fleet.returns, loads, strict=True):
        above = NO_VALUE if back is None else f"{back.altitude:.4g} m above home"
        names, starts = ", ".join(file.name for file in files), f"t = {told_seconds(plan.begin)}"
        home, battery = told_home(*fleet.place(plan.home)), told_battery(fleet, plan) or NO_VALUE
        rows.append((fleet.name(plan), names, home, above, starts, battery))
    return (head, *rows)


def export_page(
    mission: Mission, proven: ExportCertificate, notes: Sequence[str], sheet: tuple[tuple[str, ...], ...]
) -> str:
    """Return the page of an export: a judged mission whose scenario has an origin, what is proven, and what is said."""
    landings = []
    for back in proven.returns:
        if back is None:
            continue
        uav, (x, y, z) = back.plan.route.uav, back.plan.home.tolist()
        latitude, longitude, ground = to_wgs84(origin_of(mission.scenario), back.plan.home[None])[0].tolist()
        words = (
            f"{mission.scenario.uavs[uav].name}: home, {told_globe(latitude, longitude)}, {ground:z.1f} m above mean "
            f"sea level; it returns there {back.altitude:.4g} m above it, or higher"
        )
        landings.append(LandingPlace(uav, words, (x, y, z), back.level))
    head, rows = verdict_table(proven.flights)
    told = replace(scene(mission), landings=tuple(landings), export_notes=tuple(notes), export_verdicts=(head, *rows))
    return page(replace(told, sheet=sheet))
