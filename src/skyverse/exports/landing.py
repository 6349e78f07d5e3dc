"""Where a UAV stands before it takes off and where it lands, on the ground or on the roof below, and whether it may."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property, lru_cache

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilot_leg_clearance import LegChecker
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import home, origin_of
from skyverse.exports.leg_certificate import LegCertificate, Polyline
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_wgs84
from skyverse.model.pad import ground_height
from skyverse.model.polygon import are_inside
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import AnyShape, Box, Prism, Sphere, Voxels
from skyverse.model.short_lines import counted
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.problem import Airspace
from skyverse.space.pads import why_no_pad
from skyverse.space.tube import NO_ERROR, steepest_within
from skyverse.space.world import BESIDE, World


def surface_below(scenario: Scenario, place: Floats, floor: float | None = None) -> float:
    """Return z of what is below a place (3,): the highest roof that is not above it, or the ground; metres.

    No-fly zones and other airspace carry nobody.

    Parameters
    ----------
    scenario
        The scenario.
    place
        Where the UAV is, metres.
    floor
        z of the ground there, if it is known better than by `ground_height`.
    """
    solids = solids_over(scenario, place[:2], place[:2])
    return float(surfaces_among(solids, place[None], ground_below(scenario, place[None], floor))[0])


def surfaces_among(solids: Sequence[AnyShape], places: Floats, ground: Floats) -> Floats:
    """Return z of the highest roof of some solids that is not above each place, (n,) metres, or of the ground there.

    Parameters
    ----------
    solids
        What has roofs.
    places
        (n, 3) metres.
    ground
        z of the ground below each place, (n,) metres.
    """
    highest = ground.copy()
    for solid in solids:
        low, high = extent(solid)
        over = np.flatnonzero(((low[:2] <= places[:, :2]) & (places[:, :2] <= high[:2])).all(axis=1))
        if len(over):
            highest[over] = np.maximum(highest[over], _roofs(solid, places[over]))
    return np.minimum(highest, places[:, 2])


def solids_over(scenario: Scenario, low: Floats, high: Floats) -> list[AnyShape]:
    """Return the obstacles, but for airspace, whose bounding boxes reach over a rectangle between corners (2,)."""
    lows, highs = _outlines(_SameObstacles(scenario.obstacles))
    around = np.flatnonzero(((lows <= high) & (low <= highs)).all(axis=1)).tolist()
    return [scenario.obstacles[k] for k in around if scenario.obstacles[k].solid]


def ground_below(scenario: Scenario, places: Floats, floor: float | None = None) -> Floats:
    """Return z of the ground below places (..., 3), (...) metres, without roofs; `floor` is as in `surface_below`."""
    return ground_height(scenario, places[..., :2]) if floor is None else np.full(places.shape[:-1], floor)


def stand(scenario: Scenario, uav: int) -> Floats:
    """Return where a UAV stands before it takes off, (3,) metres: on its home, or on a roof above that."""
    at = home(scenario, uav)
    if scenario.uavs[uav].fixed_wing is not None:
        return np.array(scenario.uavs[uav].start)  # an aeroplane is in flight there
    at[2] = surface_below(scenario, np.array(scenario.uavs[uav].start), float(at[2]))
    return at


def landing_place(scenario: Scenario, plan: FlightPlan) -> Floats:
    """Return where a UAV lands below its last waypoint, (3,) metres."""
    place = plan.waypoints[-1].copy()
    place[2] = surface_below(scenario, place, ground_level(scenario, plan.route.uav))
    return place


def ground_level(scenario: Scenario, uav: int) -> float | None:
    """Return z of the ground where there is no terrain: that of the UAV's home, if the scenario states it; metres."""
    return scenario.uavs[uav].home if scenario.terrain is None else None


def require_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` if a descent from the last waypoint comes too near to an obstacle beside it.

    Down to the clearance above where the UAV lands it keeps the clearance, and the tracking error but for what lies
    below on the pad there; and above ground down to the ground clearance, if that is larger. An aeroplane
    has no such descent.
    """
    vehicles = [scenario.uavs[plan.route.uav] for plan in plans]
    planes = [uav.name for uav in vehicles if uav.fixed_wing is not None]
    if planes:
        raise InputError(
            f"{', '.join(planes)}: an aeroplane cannot descend straight down below its last waypoint",
            field="end",
            give=[Remedy("end", "loiter", "to circle at the target")],
        )
    descents = [_Descents(scenario, max(scenario.clearance, scenario.ground_clearance))]
    if scenario.terrain is not None and scenario.ground_clearance > scenario.clearance:
        among = derived(scenario, terrain=None, max_height=None)
        descents.append(_Descents(among, scenario.clearance))
    for plan in plans:
        for down in descents:
            down.require(plan)


class _Descents:
    """Judges descents down to a height above where UAVs land, metres."""

    def __init__(self, scenario: Scenario, height: float) -> None:
        self.scenario, self.height = scenario, height
        self.exact = LegCertificate(LegChecker(scenario, "amsl"))

    @cached_property
    def airspace(self) -> Airspace:
        """The space in which pads are looked for."""
        return Airspace(self.scenario)

    def require(self, plan: FlightPlan) -> None:
        """Raise `InputError` if one descent comes too near to anything."""
        scenario, exact = self.scenario, self.exact
        uav, lowest = plan.route.uav, plan.ending[-1].copy()
        lowest[2] = min(lowest[2] + self.height, plan.waypoints[-1][2])
        name, error = scenario.uavs[uav].name, scenario.uavs[uav].tracking_error
        certificate = exact
        if error != NO_ERROR:
            own, place = self.airspace.of(uav), (float(lowest[0]), float(lowest[1]), float(lowest[2]))
            why = why_no_pad(self.airspace.world, own.world, uav, place)
            if why is not None:
                raise InputError(f"{name}: it cannot land below its last waypoint: its place there {why}", field="end")
            lifts = ((lowest, own.lifted(uav, place)), *plan.route.lifts)
            legs = LegChecker(scenario, "amsl", error, lifts, exact.legs.worlds)
            certificate = LegCertificate(legs, exact.worlds)
        descent = Polyline(np.stack([plan.waypoints[-1], lowest]), 0.0, np.ones(2))
        unproven = certificate.refused([descent])
        trouble = certificate.legs.trouble(*descent)
        if trouble is not None or unproven:
            said = "it could not be proven" if trouble is None else certificate.sentence(trouble[1])
            raise InputError(f"{name}: it cannot land below its last waypoint: {said}", field="end")


def _roofs(shape: AnyShape, places: Floats) -> Floats:
    """Return z of the highest roof of a shape that is not above each of some places, (n,) metres, or -inf.

    The places (n, 3) are in the shape's bounding box, seen from above. Only a voxel grid has several roofs at a place.
    """
    x, y, z = places.T
    if isinstance(shape, Voxels):
        steps = (places[:, :2] - shape.origin[:2]) / shape.step[:2]
        i, j = np.minimum(steps.astype(np.intp), np.array(shape.occupied.shape[:2]) - 1).T
        filled = shape.occupied[i, j]
        ends = filled & ~np.pad(filled[:, 1:], ((0, 0), (0, 1)))
        levels = shape.origin[2] + shape.step[2] * (np.arange(shape.occupied.shape[2]) + 1)
        roofs = np.where(ends & (levels <= z[:, None] + LEG_ALLOWANCE), levels, -np.inf)
        return np.asarray(roofs.max(axis=1))
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


class _SameObstacles:
    """Obstacles that are equal only to themselves, so that what is computed of them can be remembered."""

    def __init__(self, obstacles: tuple[AnyShape, ...]) -> None:
        self.obstacles = obstacles

    def __hash__(self) -> int:
        return id(self.obstacles)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _SameObstacles) and self.obstacles is other.obstacles


@lru_cache(maxsize=2)
def _outlines(of: _SameObstacles) -> tuple[Floats, Floats]:
    """Return the least and greatest x, y of each obstacle, (n, 2) metres each; some UAVs ask for the same obstacles."""
    corners = np.array([np.stack(extent(shape))[:, :2] for shape in of.obstacles]).reshape(-1, 2, 2)
    return corners[:, 0], corners[:, 1]


STEEPEST = 15.0
"""Degrees: nobody lands on steeper ground. Above it no helicopter does (FM 3-21.38, Pathfinder Operations, 2006)."""
LEAST_REACH = 1.0
"""Metres around the place that are asked at least: a UAV has legs."""
GAP = 0.1
"""Metres between the places of a roof that are asked: narrower gaps are not seen."""
KERB = 0.1
"""Metres: what is no higher than this above where a UAV lands may be beside it."""
MAX_TOLD = 3
"""UAVs that cannot land which one sentence tells; of more it says only how many."""
ASKED_HEIGHTS = 9
"""At how many heights above where a UAV lands it is asked what stands beside."""


def why_not_level(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV should not land at a place (3,) on the ground or a roof, or ``None``.

    As far around as its horizontal tracking error, and at least `LEAST_REACH`, the ground must be no steeper than
    `STEEPEST`. A roof must be there, and no steeper.
    """
    reach = max(scenario.uavs[uav].tracking_error.horizontal, LEAST_REACH)
    terrain, floor = scenario.terrain, ground_level(scenario, uav)
    if place[2] <= ground_below(scenario, place, floor) + LEG_ALLOWANCE:
        slope = 0.0 if terrain is None else math.degrees(math.atan(steepest_within(terrain, place[:2], reach)))
        if slope <= STEEPEST:
            return None
        steep = math.ceil(10 * slope - 0.001) / 10
        return f"the ground within {reach:.3g} m slopes by {steep:g} degrees, more than the {STEEPEST:g} to land on"
    off = _disc(reach)
    away = np.linalg.norm(off, axis=1)
    places = place + off + away[:, None] * [0.0, 0.0, 1.0]
    solids = solids_over(scenario, place[:2] - reach, place[:2] + reach)
    beside = surfaces_among(solids, places, ground_below(scenario, places, floor))
    if (np.abs(beside - place[2]) <= np.maximum(away * math.tan(math.radians(STEEPEST)), LEG_ALLOWANCE)).all():
        return None
    return f"the roof there is not level within {reach:.3g} m, or ends"


def _disc(radius: float) -> Floats:
    """Return places of a disc about the origin, (n, 3) metres: its middle, its rim, and no more than `GAP` between."""
    rings = [np.zeros((1, 3))]
    for away in np.linspace(0.0, radius, math.ceil(radius / GAP) + 1)[1:]:
        angles = np.linspace(0.0, 2 * np.pi, max(math.ceil(2 * np.pi * away / GAP), 8), endpoint=False)
        rings.append(away * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]))
    return np.concatenate(rings)


def why_not_clear(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV would land at a place (3,) beside something, or ``None``.

    From there up to the clearance above, whatever is higher than `KERB` must be as far from it as the clearance and its
    tracking error.
    """
    error = scenario.uavs[uav].tracking_error
    obstacles = World(derived(scenario, terrain=None, max_height=None), error)
    world = obstacles.without_support(place, float(place[2]) + KERB, BESIDE)
    top = place + np.array([0.0, 0.0, scenario.clearance])
    if world.first_crossing(place[None], top[None]) is None:
        return None
    found = [world.blocker(at) for at in np.linspace(place, top, ASKED_HEIGHTS)]
    what = next((world.named(number) for number in found if number is not None), "something")
    return f"{what} stands within {scenario.clearance + error.horizontal:.3g} m of where it would land"


def require_level_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a UAV that lands below its last waypoint would land on a slope or the edge of a roof."""
    _refuse(scenario, [(plan, why_not_level(scenario, plan.route.uav, plan.ending[-1])) for plan in plans])


def require_clear_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a UAV that lands below its last waypoint would land beside something."""
    _refuse(scenario, [(plan, why_not_clear(scenario, plan.route.uav, plan.ending[-1])) for plan in plans])


def _refuse(scenario: Scenario, asked: list[tuple[FlightPlan, str | None]]) -> None:
    """Raise `InputError` for those UAVs that should not land, with the places and the reasons."""
    refused = []
    for plan, why in asked:
        if why is not None:
            latitude, longitude, _ = to_wgs84(origin_of(scenario), plan.ending[-1:])[0].tolist()
            name = scenario.uavs[plan.route.uav].name
            refused.append(
                f"{name}: it cannot land below its last waypoint, at {latitude:.5f}, {longitude:.5f}, as {why}"
            )
    if refused:
        more = f"; and {counted(len(refused) - MAX_TOLD, 'more UAV')}" if len(refused) > MAX_TOLD else ""
        stay = Remedy("end", "loiter", "to stay at the target")
        raise InputError(f"{'; '.join(refused[:MAX_TOLD])}{more}. Choose other targets", field="end", give=[stay])


def ground_notes(scenario: Scenario, plans: Sequence[FlightPlan]) -> Iterator[str]:
    """Yield sentences on homes that are not known or not level, and on what is not known where UAVs land."""
    unknown = [scenario.uavs[plan.route.uav] for plan in plans if _starts_in_the_air(scenario, plan.route.uav)]
    if unknown:
        told = ", ".join(f"{vehicle.name} at z = {vehicle.start[2]:.4g} m" for vehicle in unknown)
        yield (
            f"{Caution.WARNING}: homes that are not known, as the scenario has no terrain, and are taken to be the "
            f"starts: {told}. Where a UAV arms lower, it returns as much lower than is proven: state its home."
        )
    steep = []
    for plan in plans:
        vehicle = scenario.uavs[plan.route.uav]
        if vehicle.fixed_wing is not None or (scenario.terrain is None and vehicle.home is None):
            continue  # it takes off elsewhere, or from where the ground is not known
        why = why_not_level(scenario, plan.route.uav, plan.home)
        if why is not None:
            steep.append(f"{vehicle.name}: {why}")
    if steep:
        places = "; ".join(steep)
        yield f"{Caution.WARNING}: homes that are not level: {places}. Choose other starts, or level the places."
    if scenario.terrain is not None and not any(shape.solid for shape in scenario.obstacles):
        yield (
            f"{Caution.WARNING}: the scenario knows the ground and no obstacles: trees, roofs and water are unknown; "
            "look at where UAVs fly low and land."
        )


def _starts_in_the_air(scenario: Scenario, uav: int) -> bool:
    """Tell whether a multirotor's start, above the lower bound, is taken as home for want of a terrain."""
    vehicle = scenario.uavs[uav]
    if vehicle.fixed_wing is not None or vehicle.home is not None or scenario.terrain is not None:
        return False
    start = np.array(vehicle.start)
    return bool(start[2] > ground_below(scenario, start) + LEG_ALLOWANCE)
