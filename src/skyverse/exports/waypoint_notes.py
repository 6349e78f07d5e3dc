"""What exports say of waypoints: proofs of legs, ways home, the schedule and the files."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

from skyverse.errors import InputError, Remedy, Sentence
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import home_on_globe, origin_of
from skyverse.exports.return_lines import CLEARANCE_SHARE
from skyverse.exports.separation import Apart, FleetApart, circle_reach, fleet_apart, named_pairs
from skyverse.exports.way_home import Gap, WayHome, layer
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted, told_seconds
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.space.tube import NO_ERROR


def few(words: Sequence[str], most: int) -> str:
    """Return at most so many words, and how many more there are."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return ", ".join(words[:most]) + more


def grouped(said: Sequence[tuple[str, str]], fleet: int) -> Iterator[str]:
    """Yield sentences, those that are the same of several UAVs once, in the order in which they first occur.

    Parameters
    ----------
    said
        The name of a UAV, and what is said of it, for some or all of the fleet.
    fleet
        How many UAVs there are in all.
    """
    holders: dict[str, list[str]] = {}
    for name, text in said:
        holders.setdefault(text, []).append(name)
    for text, names in holders.items():
        if len(names) == 1:
            yield f"{names[0]}: {text}"
        else:
            yield f"Each of {f'the {fleet} UAVs' if len(names) == fleet else ', '.join(names)}: {text}"


MAX_TOLD = 6
"""UAVs that one sentence names; of more it says only how many."""
AS_PLANNED = Remedy("apart_in_space", True, "to export them apart in space as planned")
"""What helps UAVs that are apart in space as planned, but not on the waypoints."""
OTHER_ENDS = (
    Remedy("end", "land", "to land below the last waypoints"),
    Remedy("end", "loiter", "to stay there"),
)
"""What helps UAVs that are not apart in space on the returns that end their mission."""


def proofs(scenario: Scenario, plans: Sequence[FlightPlan], *, from_home: bool) -> Iterator[str]:
    """Yield sentences on what is proven of flight plans, whose altitudes may be counted `from_home`."""
    names = [scenario.uavs[plan.route.uav].name for plan in plans]
    if len(plans) == 1:
        yield plans[0].route.sentence(scenario, _corners(plans[0]))
    else:
        yield from _figures([*zip(names, plans, strict=True)])
        yield from grouped(
            [(name, plan.route.proof(scenario)) for name, plan in zip(names, plans, strict=True)], len(plans)
        )
    for name, plan in zip(names, plans, strict=True):
        if not plan.corners_proven:
            yield (
                f"{name}: {plan.autopilot.title} turns an aeroplane at a distance of its own from each waypoint, not "
                f"at {plan.route.radius:.3g} m: what its corners keep is {Caution.NOT} proven."
            )
        if reach := circle_reach(scenario, plan.route.uav):
            yield (
                f"{name}: it ends circling within {reach:.3g} m of its last waypoint: what these circles keep from "
                f"obstacles, ground and bounds is {Caution.NOT} proven."
            )
        if plan.breaks:
            most = plan.autopilot.max_waypoints
            yield f"{name}: {len(plan.parts)} files of at most {most} waypoints; after each it waits for the next."
    if from_home:
        yield _home_note(scenario, [plan.route.uav for plan in plans])


def _figures(flown: Sequence[tuple[str, FlightPlan]]) -> Iterator[str]:
    """Yield a sentence on the waypoints of each of several UAVs."""
    for name, plan in flown:
        count = counted(len(plan.route.points), "waypoint")
        yield f"{name}: {count}, {_corners(plan)}, at most {plan.route.off:.3g} m off the trajectory."


def _corners(plan: FlightPlan) -> str:
    """Return how corners are flown, in words."""
    return plan.route.corners if plan.corners_proven else f"corners {Caution.NOT} proven"


def return_sentences(
    scenario: Scenario, plans: Sequence[FlightPlan], returns: Sequence[WayHome | None]
) -> Iterator[str]:
    """Yield sentences on the way home of each flight plan, ``None`` for an aeroplane, and on what returns keep."""
    kept = []
    for plan, back in zip(plans, returns, strict=True):
        name = scenario.uavs[plan.route.uav].name
        if back is None:
            yield (
                f"{name}: no way home is proven of an aeroplane, neither its return nor the circles that it flies at "
                "home; choose the altitude of its return yourself."
            )
            continue
        latitude, longitude, ground = to_wgs84(origin_of(scenario), plan.home[None])[0].tolist()
        yield (
            f"{name}: it returns at {back.altitude:.4g} m above home, which is at {latitude:.6f}, {longitude:.6f}, "
            f"{ground:z.1f} m above mean sea level, or as high as it is if that is higher."
        )
        yield from (f"{name}: no way home is proven {_gap_text(scenario, gap)}." for gap in back.gaps[:MAX_TOLD])
        if not back.nowhere:
            kept.append((name, _kept(scenario, plan.route.uav, "when it is" if back.gaps else "at every instant")))
    yield from grouped(kept, len(plans))


def _gap_text(scenario: Scenario, gap: Gap) -> str:
    """Return from when to when no way home is proven, why, and from where."""
    latitude, longitude, sea = to_wgs84(origin_of(scenario), gap.place[None])[0].tolist()
    return (
        f"from t = {told_seconds(gap.begin)} to {told_seconds(gap.end)}: {gap.why}, from "
        f"{latitude:.5f}, {longitude:.5f}, {sea:z.0f} m above mean sea level"
    )


def _kept(scenario: Scenario, uav: int, when: str) -> str:
    """Return what a proven way home keeps, and when."""
    kept = f"{CLEARANCE_SHARE * scenario.clearance:.4g} m"
    if scenario.terrain is not None and scenario.ground_clearance < scenario.clearance:
        kept += f", above ground by {CLEARANCE_SHARE * scenario.ground_clearance:.4g} m"
    error = " and its tracking error" if scenario.uavs[uav].tracking_error != NO_ERROR else ""
    return f"its way home is proven {when}: climb, level way and descent are clear by {kept}{error}."


def require_returns(scenario: Scenario, backs: Sequence[tuple[int, WayHome | None]]) -> None:
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


def not_in_layers(scenario: Scenario, returns: Sequence[WayHome | None]) -> Iterator[str]:
    """Yield a warning on UAVs whose return altitudes are less apart than their separation."""
    flown = [back for back in returns if back is not None]
    near = [
        (a.plan.route.uav, b.plan.route.uav)
        for a, b in combinations(flown, 2)
        if abs(a.level - b.level) < layer(scenario, a.plan, b.plan) - SAME_PLACE
    ]
    if near:
        yield (
            f"{Caution.WARNING}: return altitudes are less than a separation apart: {named_pairs(scenario, near)}; "
            "let one land before the other returns."
        )


def not_apart_when_returning(scenario: Scenario, plans: Sequence[FlightPlan], apart: FleetApart) -> Iterator[Sentence]:
    """Yield a warning on the UAVs that are apart in space up to their last waypoints, but not on the returns."""
    before = fleet_apart(scenario, [replace(plan, ending=plan.ending[:0]) for plan in plans])
    pairs = [pair for pair in before.of(Apart.SPACE) if apart.pairs[pair] is not Apart.SPACE]
    if pairs:
        yield Sentence(
            f"{Caution.WARNING}: apart in space up to their last waypoints, but {Caution.NOT} on the returns that end "
            f"the mission: {named_pairs(scenario, pairs)}",
            give=OTHER_ENDS,
        )


def start_together(scenario: Scenario, apart: FleetApart, *, asked: bool, planned: bool) -> Iterator[str]:
    """Yield what a pilot must heed where not all pairs of UAVs are apart in space, as `asked` or `planned`."""
    timed = [pair for pair, kind in apart.pairs.items() if kind in (Apart.TIMING, Apart.SCHEDULE)]
    if timed:
        said = f"{Caution.ONLY} apart if they start at the same time: {named_pairs(scenario, timed)}"
        yield Sentence(said, give=[AS_PLANNED]) if planned and not asked else f"{said}."


def schedule_note(plans: Sequence[FlightPlan]) -> str:
    """Return a sentence on the times that notes name."""
    late = max(float(plan.arrivals[0] + plan.hover - plan.route.waypoint_times[0]) for plan in plans)
    later = told_seconds(max(late, 0.0))
    begin = "when they do in the mission"  # as of aeroplanes, which do not take off
    if later != told_seconds(0.0):
        begin = f"{later} later than in the mission, when all take-offs have ended"
    return (
        "All times are of the exported schedule: second 0 is when all UAVs start together, and trajectories begin "
        f"{begin}."
    )


def lowered_takeoffs(scenario: Scenario, plans: Sequence[FlightPlan], asked: float) -> Iterator[str]:
    """Yield sentences on multirotors whose take-off ends less than `asked` metres above where they stand."""
    lowered = []
    for plan in plans:
        vehicle, rise = scenario.uavs[plan.route.uav], float(plan.waypoints[0][2] - plan.home[2])
        if vehicle.fixed_wing is None and rise < asked - SAME_PLACE:
            said = f"its take-off ends {rise:.4g} m above where it stands, as there is no room to rise by {asked:g} m."
            lowered.append((vehicle.name, said))
    yield from grouped(lowered, len(plans))


def _home_note(scenario: Scenario, uavs: Sequence[int]) -> str:
    """Return a sentence on the altitudes of the homes of some UAVs."""
    homes = [(scenario.uavs[uav].name, f"{round(home_on_globe(scenario, uav)[2], 2) + 0.0:.2f} m") for uav in uavs]
    told = few([f"{name} {at}" for name, at in homes], MAX_TOLD)
    return (
        f"{Caution.BEFORE} each flight, compare home, above mean sea level: {told}; where a UAV arms lower, it flies "
        "as much lower."
    )


def made_for(plans: Sequence[FlightPlan], names: Sequence[str], beside: Sequence[Path | None]) -> Iterator[str]:
    """Yield sentences on the autopilot that files are made for, and on the parameters beside them, if there are any."""
    title = plans[0].autopilot.title if plans else ""
    alone = [name for name, file in zip(names, beside, strict=True) if file is None]
    yield from grouped([(name, f"made for {title}.") for name in alone], len(plans))
    rates = [(name, file) for name, file in zip(names, beside, strict=True) if file is not None]
    if rates:
        files = few([f"{file} into {name}" for name, file in rates], MAX_TOLD)
        yield f"{Caution.BEFORE} the first flight, load the rates for {title}: {files}."
