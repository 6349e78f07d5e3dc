"""Where a UAV stands before it takes off and where it lands, on the ground or on an obstacle, and whether it may."""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.flight_plan import FlightPlan, attainable_speed
from skyverse.exports.global_positions import home, origin_of
from skyverse.model.geodesy import to_wgs84, told_globe
from skyverse.model.pad import ground_height
from skyverse.model.polygon import are_inside
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import AnyShape, Box, Prism, Sphere, Voxels
from skyverse.model.short_lines import counted
from skyverse.model.take_off import touch_down
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.referee.clearance import judge_segments
from skyverse.referee.pads import without_support
from skyverse.referee.world import RefereeWorld, referee_world
from skyverse.space.tracking_error import LEAST_REACH, STEEPEST, landing_slope
from skyverse.space.world import World

GAP = 0.1
"""Metres between the places of a surface that are asked: narrower gaps are not seen."""
MAX_TOLD = 3
"""UAVs that cannot land which one sentence tells; of more it says only how many."""
ASKED_HEIGHTS = 9
"""At how many heights of a descent it is asked what is too near."""


def surfaces_below(scenario: Scenario, places: Floats, ground: Floats) -> Floats:
    """Return z of what is below each place, (n,) metres: the highest surface that is not above it, or the ground.

    No-fly zones and other airspace carry nobody.

    Parameters
    ----------
    scenario
        The scenario.
    places, ground
        (n, 3) metres, and z of the ground below each, (n,) metres.
    """
    solids = [shape for shape in scenario.obstacles if shape.solid]
    corners = np.array([np.stack(extent(shape))[:, :2] for shape in solids]).reshape(-1, 2, 2)
    x_y, highest = places[:, :2], ground.copy()
    near = ((corners[:, 0] <= x_y.max(axis=0)) & (x_y.min(axis=0) <= corners[:, 1])).all(axis=1)
    for k in np.flatnonzero(near).tolist():
        over = np.flatnonzero(((corners[k, 0] <= x_y) & (x_y <= corners[k, 1])).all(axis=1))
        if len(over):
            highest[over] = np.maximum(highest[over], _tops(solids[k], places[over]))
    return np.minimum(highest, places[:, 2])


def _tops(shape: AnyShape, places: Floats) -> Floats:
    """Return z of the highest top of a shape that is not above each of some places, (n,) metres, or -inf.

    The places (n, 3) are in the shape's bounding box, seen from above. Only a voxel grid has several tops at a place.
    """
    x, y, z = places.T
    if isinstance(shape, Voxels):
        steps = (places[:, :2] - shape.origin[:2]) / shape.step[:2]
        i, j = np.minimum(steps.astype(np.intp), np.array(shape.occupied.shape[:2]) - 1).T
        filled = shape.occupied[i, j]
        ends = filled & ~np.pad(filled[:, 1:], ((0, 0), (0, 1)))
        levels = shape.origin[2] + shape.step[2] * (np.arange(shape.occupied.shape[2]) + 1)
        tops = np.where(ends & (levels <= z[:, None] + LEG_ALLOWANCE), levels, -np.inf)
        return np.asarray(tops.max(axis=1))
    if isinstance(shape, Box):
        inside, top = np.ones(len(places), dtype=np.bool_), np.full(len(places), shape.max[2])
    elif isinstance(shape, Prism):
        inside, top = are_inside(places[:, :2], shape.vertices), np.full(len(places), shape.high)
        for hole in shape.holes:
            inside &= ~are_inside(places[:, :2], hole)
    else:
        squares = shape.radius**2 - (x - shape.centre[0]) ** 2 - (y - shape.centre[1]) ** 2
        inside, top = squares >= 0, np.sqrt(np.maximum(squares, 0.0))
        top = shape.centre[2] + top if isinstance(shape, Sphere) else np.full(len(places), shape.high)
    return np.where(inside & (top <= z + LEG_ALLOWANCE), top, -np.inf)


def _ground_below(scenario: Scenario, uav: int, places: Floats) -> Floats:
    """Return z of the ground, (n,) metres: without a terrain that of the UAV's home, if the scenario states it."""
    floor = scenario.uavs[uav].home if scenario.terrain is None else None
    return ground_height(scenario, places[:, :2]) if floor is None else np.full(len(places), floor)


def stands(scenario: Scenario, uavs: Sequence[int]) -> list[Floats]:
    """Return where UAVs stand before they take off, (3,) metres each: on their homes, or on what is above these."""
    starts = np.array([scenario.uavs[uav].start for uav in uavs])
    homes = np.array([home(scenario, uav)[2] for uav in uavs])
    flying = [scenario.uavs[uav].fixed_wing is not None for uav in uavs]  # an aeroplane is in flight there
    below = np.where(flying, starts[:, 2], surfaces_below(scenario, starts, homes))
    return list(np.column_stack([starts[:, :2], below]))


def landing_places(scenario: Scenario, plans: Sequence[FlightPlan]) -> list[Floats]:
    """Return where UAVs land below their last waypoints, (3,) metres each."""
    places = np.array([plan.waypoints[-1] for plan in plans])
    rows = zip(plans, places, strict=True)
    ground = np.concatenate([_ground_below(scenario, plan.route.uav, place[None]) for plan, place in rows])
    return list(np.column_stack([places[:, :2], surfaces_below(scenario, places, ground)]))


def slow_touch_down(scenario: Scenario, plan: FlightPlan) -> float:
    """Return what a landing takes at most beyond what a flight plan predicts, J: autopilots touch down slowly."""
    if not len(plan.ending) or scenario.uavs[plan.route.uav].fixed_wing is not None:
        return 0.0
    above, below = [plan.waypoints[-1], *plan.ending][-2:]
    seconds, joules = touch_down(scenario, plan.route.uav, max(float(above[2] - below[2]), 0.0))
    if seconds == 0:
        return 0.0
    predicted = math.dist(above, below) / attainable_speed(above, below, plan.top_speed, plan.rates)
    return joules * max(1 - predicted / seconds, 0.0)


def require_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` for UAVs that cannot land below their last waypoints, with the places and the reasons.

    They land on nothing steep, and on no edge, and descend without coming too near to anything.
    """
    stay = [Remedy("end", "loiter", "to stay at the target")]
    planes = [uav.name for uav in (scenario.uavs[plan.route.uav] for plan in plans) if uav.fixed_wing is not None]
    if planes:
        said = f"{', '.join(planes)}: an aeroplane cannot descend straight down below its last waypoint"
        raise InputError(said, field="end", give=stay)
    descents, refused = Descents(scenario), []
    for plan in plans:
        uav, top, place = plan.route.uav, plan.waypoints[-1], plan.ending[-1]
        why = None if plan.route.to_home else why_not_level(scenario, uav, place)  # of homes it is a warning
        why = why or descents.why_not_clear(uav, top, place)
        if why is not None:
            latitude, longitude, _ = to_wgs84(origin_of(scenario), place[None])[0].tolist()
            where = f"it cannot land below its last waypoint, at {told_globe(latitude, longitude)}"
            refused.append(f"{plan.route.name(scenario)}: {where}, as {why}")
    if refused:
        more = f"; and {counted(len(refused) - MAX_TOLD, 'more UAV')}" if len(refused) > MAX_TOLD else ""
        raise InputError(f"{'; '.join(refused[:MAX_TOLD])}{more}. Choose other targets", field="end", give=stay)


class Descents:
    """Judges descents, with the planners' space and then with the referee's."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = derived(scenario, max_height=None)
        self._worlds: dict[TrackingError, tuple[World, RefereeWorld]] = {}

    def why_not_clear(self, uav: int, top: Floats, place: Floats) -> str | None:
        """Return the end of a sentence on why a UAV cannot descend from `top` to a place, (3,) metres, or ``None``.

        Only what ends no higher than where it lands may come nearer than the clearance and its tracking error.
        """
        error, highest = self.scenario.uavs[uav].tracking_error, float(place[2]) + LEG_ALLOWANCE
        world, referee = self._of(error)
        world = world.without_support(place, highest)
        if world.first_crossing(top, place) is not None:
            found = [world.blocker(at) for at in np.linspace(place, top, ASKED_HEIGHTS)]
            what = next((world.named(number) for number in found if number is not None), "something")
            return f"{what} stands within {self.scenario.clearance + error.horizontal:.3g} m of where it would descend"
        judged = judge_segments(without_support(referee, place, highest), top[None], place[None])
        proven = judged.incursion is None and judged.peaks.proven[0]
        return None if proven else "its descent could not be proven"

    def _of(self, error: TrackingError) -> tuple[World, RefereeWorld]:
        if error not in self._worlds:
            self._worlds[error] = World(self.scenario, error), referee_world(self.scenario, error)
        return self._worlds[error]


def why_not_level(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV should not land at a place (3,), or ``None`` if it may.

    As far around as its horizontal tracking error, and at least `LEAST_REACH`, the ground must be no steeper than
    `STEEPEST`. What else it lands on must be there, and no steeper.
    """
    reach, terrain = max(scenario.uavs[uav].tracking_error.horizontal, LEAST_REACH), scenario.terrain
    if place[2] <= _ground_below(scenario, uav, place[None])[0] + LEG_ALLOWANCE:
        slope = 0.0 if terrain is None else landing_slope(terrain, place[:2], scenario.uavs[uav].tracking_error)
        if slope <= STEEPEST:
            return None
        steep = math.ceil(10 * slope - 0.001) / 10
        return f"the ground within {reach:.3g} m slopes by {steep:g} degrees, more than the {STEEPEST:g} to land on"
    off = _disc(reach)
    away = np.linalg.norm(off, axis=1)
    places = place + off + away[:, None] * [0.0, 0.0, 1.0]
    around = surfaces_below(scenario, places, _ground_below(scenario, uav, places))
    if (np.abs(around - place[2]) <= np.maximum(away * math.tan(math.radians(STEEPEST)), LEG_ALLOWANCE)).all():
        return None
    return f"what it would stand on is not level within {reach:.3g} m, or ends"


def _disc(radius: float) -> Floats:
    """Return places of a disc about the origin, (n, 3) metres: its middle, its rim, and no more than `GAP` between."""
    rings = [np.zeros((1, 3))]
    for away in np.linspace(0.0, radius, math.ceil(radius / GAP) + 1)[1:]:
        angles = np.linspace(0.0, 2 * np.pi, max(math.ceil(2 * np.pi * away / GAP), 8), endpoint=False)
        rings.append(away * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]))
    return np.concatenate(rings)


def starts_in_the_air(scenario: Scenario, uav: int) -> bool:
    """Tell whether a multirotor's start, above the lower bound, is taken as home for want of a terrain."""
    vehicle = scenario.uavs[uav]
    if vehicle.fixed_wing is not None or vehicle.home is not None or scenario.terrain is not None:
        return False
    return bool(vehicle.start[2] > scenario.bounds.min[2] + LEG_ALLOWANCE)
