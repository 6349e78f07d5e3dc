"""What a pilot must heed of a mission, whatever the referee says of it: what it leaves out, and what it assumes.

All that prints, draws or exports a mission takes its cautions from here.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import Remedy, Sentence
from skyverse.model.caution import Caution, MissionCaution, warning_of
from skyverse.model.flight_table import FlightMeasures, measure_flight, places_along
from skyverse.model.geodesy import told_place
from skyverse.model.mission import Mission, PlannedFlight, planned_flights
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent, roof_z
from skyverse.model.shapes import NO_FLY_ZONE, AnyShape, Voxels
from skyverse.model.short_lines import listed, told_area
from skyverse.model.take_off import take_off
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Verdict
from skyverse.space.later_cautions import later_cautions
from skyverse.space.world import World

MAX_NAMED = 6
"""UAVs or targets that are named in one sentence; of more it is told how many there are."""
USUAL_CEILING = 120.0
"""Metres above ground that most rules allow, such as those of the open category in the European Union and, as 400 feet,
those of the United States."""
LOWER = 1.0
"""Metres by which a flight is lower than both of its ends before that is told."""
SLOW = 0.5
"""The share of its largest speed below which what a UAV makes good against the wind is told."""
KINDS_OF_TREES = ("tree", "vegetation")

_Flown = tuple[str, Trajectory, FlightMeasures]
"""The name of a UAV, its flight, and what is read off it."""


def mission_cautions(mission: Mission) -> list[MissionCaution]:
    """Return what must be heeded of a mission as it answers its scenario; it may be one that the referee refutes."""
    scenario, flights = mission.scenario, planned_flights(mission)
    flown = [
        (one.uav.name, one.trajectory, measure_flight(one.trajectory, scenario.terrain))
        for one in flights
        if one.trajectory is not None
    ]
    later = later_cautions(scenario, [one.trajectory for one in flights])
    return [
        *_spare_targets(mission),
        *_left_out(scenario),
        *_not_seen(mission),
        *_flown_over(scenario, flown),
        *_high(scenario, flown),
        *_low(scenario, flown),
        *_slow_in_wind(scenario, flights),
        *(MissionCaution("comes later", said) for said in later),
        *_landings(mission),
    ]


def _not_seen(mission: Mission) -> Iterator[MissionCaution]:
    """Yield what of surveys is not proven to be seen as asked."""
    for one in mission.coverage:
        if one.verdict is not Verdict.PROVEN:
            name = mission.scenario.surveys[one.survey].name
            yield MissionCaution("not seen", f"{Caution.WARNING}: {name}: {one.sentence}", (name,))
            gaps = [gap for gap in mission.unseen if gap.survey == one.survey]
            for why in dict.fromkeys(gap.why for gap in gaps):
                some = [gap for gap in gaps if gap.why == why]
                area = sum(gap.area for gap in some)
                place = told_place(mission.scenario.frame.origin, max(some, key=lambda gap: gap.area).middle)
                where = f"{f'about {told_area(area)} of {name}' if area else name}, such as about {place}"
                yield MissionCaution("not seen", f"{Caution.WARNING}: {where}: {why}", (name,))


def _slow_in_wind(scenario: Scenario, flights: Sequence[PlannedFlight]) -> Iterator[MissionCaution]:
    """Yield a caution for each multirotor that the wind slows down a lot."""
    winds = scenario.winds
    for uav in (one.uav for one in flights if one.trajectory is not None and one.uav.fixed_wing is None):
        good = uav.airspeed - winds.strongest
        if winds.strongest and good < SLOW * uav.max_speed:
            said = f"{Caution.WARNING}: against {winds.told} {uav.name} makes {good:.2g} m/s good"
            yield MissionCaution("slow in wind", said, (uav.name,))


def _spare_targets(mission: Mission) -> Iterator[MissionCaution]:
    """Yield that there are targets to which no UAV is sent, and why not where that is known."""
    names = {k: mission.scenario.targets[k].name for k in mission.spare_targets}
    reasons = {one.target: one.why for one in mission.unvisited}
    for why in dict.fromkeys(reasons.get(k, "") for k in names):
        some = tuple(name for k, name in names.items() if reasons.get(k, "") == why)
        said = f"{Caution.WARNING}: no UAV flies to {_named(some)}{why and f': {why}'}"
        yield MissionCaution("no UAV", said, some)


def _landings(mission: Mission) -> Iterator[MissionCaution]:
    """Yield that UAVs land between sorties, below starts in the air, which nobody has proven."""
    scenario = mission.scenario
    lands = tuple(
        own.name
        for uav, own in enumerate(scenario.uavs)
        if len(mission.sorties_of(uav)) > 1 and take_off(scenario, uav, own.start).seconds > 0
    )
    if lands:
        said = f"between sorties {_named(lands)} {'lands' if len(lands) == 1 else 'land'} straight below the start"
        yield MissionCaution("lands", f"{Caution.WARNING}: {said}, which is not proven: keep that clear", lands)


def _left_out(scenario: Scenario) -> Iterator[MissionCaution]:
    """Yield what was left out when the scenario was made from files."""
    for source in scenario.sources:
        for said in source.cautions:
            yield MissionCaution("left out", warning_of(source.file, said), (source.file,))


def _flown_over(scenario: Scenario, flown: Sequence[_Flown]) -> Iterator[MissionCaution]:
    """Yield a caution for each obstacle that is airspace, and not closed above, over which UAVs fly."""
    tracks = [(name, places_along(flight)) for name, flight, _ in flown]
    for number, zone in enumerate(scenario.obstacles):
        if zone.solid or zone.closed_above:
            continue
        above = {name: _least_above(scenario, zone, places) for name, places in tracks}
        over = {name: metres for name, metres in above.items() if metres is not None}
        if over:
            called = f"obstacles[{number}]" + (f" ({zone.name})" if zone.name else "")
            least, names = min(over.values()), tuple(over)
            said = (
                f"{Caution.WARNING}: {_named(names)} {'flies' if len(names) == 1 else 'fly'} over the "
                f"{zone.kind or NO_FLY_ZONE} {called}, {least:.0f} m above its upper end"
            )
            give = [Remedy("zones_closed_above", True, "when the scenario is built, to forbid it")]
            yield MissionCaution("flown over", Sentence(said, give=give), names, least)


def _least_above(scenario: Scenario, zone: AnyShape, places: Floats) -> float | None:
    """Return how far above the upper end of a zone the lowest of those places (n, 3) is that are over it, if any is."""
    low, high = extent(zone)
    near = places[np.all((places[:, :2] >= low[:2]) & (places[:, :2] <= high[:2]), axis=1)]
    if not len(near):
        return None
    only = {"zones": (), "movers": (), "terrain": None, "max_height": None, "clearance": 0.0}

    def free(closed: bool) -> NDArray[np.bool_]:
        shape = derived(zone, closed_above=closed)
        return World(derived(scenario, **only, obstacles=(shape,))).free(near)

    over = near[free(False) & ~free(True)]
    heights = [z - roof_z(zone, (x, y, z), 0.0) for x, y, z in over.tolist()]
    return max(0.0, min(heights)) if heights else None


def _high(scenario: Scenario, flown: Sequence[_Flown]) -> Iterator[MissionCaution]:
    """Yield that UAVs fly higher above ground than most rules allow, where nobody has said how high they may."""
    if scenario.terrain is None or scenario.frame.origin is None or scenario.max_height is not None:
        return
    heights = {name: measures.highest for name, _, measures in flown if measures.highest > USUAL_CEILING}
    if heights:
        said = (
            f"{Caution.WARNING}: up to {max(heights.values()):.0f} m above ground, {_named(tuple(heights))} "
            f"{'flies' if len(heights) == 1 else 'fly'} higher than the {USUAL_CEILING:g} m that most rules allow"
        )
        give = [Remedy("max_height", None, "to say how high they may")]
        yield MissionCaution("high", Sentence(said, give=give), tuple(heights), max(heights.values()))


def _low(scenario: Scenario, flown: Sequence[_Flown]) -> Iterator[MissionCaution]:
    """Yield that UAVs fly lower than both of their ends, over ground of which nobody knows what stands on it."""
    ground = scenario.terrain
    if ground is None or scenario.frame.origin is None or _knows_trees(scenario):
        return
    heights = {}
    for name, flight, measures in flown:
        ends = flight.at([flight.start, flight.end]).position
        if measures.lowest < float((ends[:, 2] - ground.height(ends[:, :2])).min()) - LOWER:
            heights[name] = measures.lowest
    if heights:
        said = (
            f"{Caution.WARNING}: down to {min(heights.values()):.1f} m above ground, {_named(tuple(heights))} "
            f"{'flies' if len(heights) == 1 else 'fly'} lower than both ends; trees, masts and wires are not in the "
            "scenario"
        )
        give = [Remedy("ground_clearance", None, "when the scenario is built, to fly higher")]
        yield MissionCaution("low", Sentence(said, give=give), tuple(heights), min(heights.values()))


def _knows_trees(scenario: Scenario) -> bool:
    """Tell whether a scenario's obstacles say what stands on the ground: points measured from the air, or trees."""
    return any(isinstance(one, Voxels) or one.kind in KINDS_OF_TREES for one in scenario.obstacles)


def _named(names: Sequence[str]) -> str:
    more = len(names) - MAX_NAMED
    return listed([*names[:MAX_NAMED], *([f"{more} more"] if more > 0 else [])])


def nearest_obstacle(mission: Mission) -> float | None:
    """Return metres to the nearest obstacle, rounded down to centimetres, negative inside; ``None`` without any."""
    flown = [one for one in mission.trajectories if one is not None]
    if not flown or not mission.scenario.obstacles:
        return None
    world = World(derived(mission.scenario, terrain=None, max_height=None))
    return math.floor(100 * min(float(world.distance(places_along(one)).min()) for one in flown)) / 100
