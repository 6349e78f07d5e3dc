"""Where a UAV stands before it takes off, and where it lands: on the ground, or on the roof below."""

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.autopilot_leg_clearance import LegChecker
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import home
from skyverse.exports.leg_certificate import LegCertificate, Polyline
from skyverse.model.airspace_kinds import is_airspace
from skyverse.model.polygon import is_inside
from skyverse.model.scenario import Scenario
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import AnyShape, Box, Cylinder, Prism, Sphere, Voxels
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.problem import Airspace
from skyverse.space.column import why_no_column
from skyverse.space.tube import NO_ERROR


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
        z of the ground there, if it is known better than by the terrain; without a terrain either, the ground is taken
        to be at the lower bound.
    """
    return surface_among(solids_over(scenario, place[:2], place[:2]), place, ground_below(scenario, place, floor))


def surface_among(solids: Sequence[AnyShape], place: Floats, ground: float) -> float:
    """Return z of the highest roof of some solids that is not above a place (3,), or of the ground there; metres."""
    x, y, z = (float(value) for value in place)
    tops = [top for solid in solids for top in _tops(solid, x, y) if top <= z + LEG_ALLOWANCE]
    return min(max([ground, *tops]), z)


def solids_over(scenario: Scenario, low: Floats, high: Floats) -> list[AnyShape]:
    """Return the obstacles, but for airspace, whose bounding boxes reach over a rectangle between corners (2,)."""
    lows, highs = _outlines(_SameObstacles(scenario.obstacles))
    around = np.flatnonzero(((lows <= high) & (low <= highs)).all(axis=1)).tolist()
    return [scenario.obstacles[k] for k in around if not is_airspace(scenario.obstacles[k].kind)]


def ground_below(scenario: Scenario, place: Floats, floor: float | None = None) -> float:
    """Return z of the ground below a place (3,), metres, whatever stands on it; `floor` is as in `surface_below`."""
    if floor is not None:
        return floor
    return scenario.bounds.min[2] if scenario.terrain is None else float(scenario.terrain.height(place[:2]))


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
    below in the column over that place; and above ground down to the ground clearance, if that is larger. An aeroplane
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
        among = scenario.model_copy(update={"terrain": None, "max_height": None})
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
        """The space in which columns are looked for."""
        return Airspace(self.scenario)

    def require(self, plan: FlightPlan) -> None:
        """Raise `InputError` if one descent comes too near to anything."""
        scenario, exact = self.scenario, self.exact
        uav, lowest = plan.route.uav, plan.ending[-1].copy()
        lowest[2] = min(lowest[2] + self.height, plan.waypoints[-1][2])
        name, error = scenario.uavs[uav].name, scenario.uavs[uav].tracking_error
        certificate = exact
        if error != NO_ERROR:
            own = self.airspace.of(uav)
            why = why_no_column(self.airspace.world, own.world, lowest)
            if why is not None:
                raise InputError(f"{name}: it cannot land below its last waypoint: its place there {why}", field="end")
            columns = ((lowest, own.column_top(lowest)), *plan.route.columns)
            legs = LegChecker(scenario, "amsl", error, columns, exact.legs.worlds)
            certificate = LegCertificate(legs, exact.worlds)
        descent = Polyline(np.stack([plan.waypoints[-1], lowest]), 0.0, np.ones(2))
        unproven = certificate.refused([descent])
        trouble = certificate.legs.trouble(*descent)
        if trouble is not None or unproven:
            said = "it could not be proven" if trouble is None else certificate.sentence(trouble[1])
            raise InputError(f"{name}: it cannot land below its last waypoint: {said}", field="end")


def _tops(shape: Box | Cylinder | Sphere | Prism | Voxels, x: float, y: float) -> list[float]:
    """Return z of the tops of a shape above a place, metres; a voxel grid may have several."""
    if isinstance(shape, Box):
        inside = all(low <= at <= high for low, at, high in zip(shape.min[:2], (x, y), shape.max[:2], strict=True))
        return [shape.max[2]] if inside else []
    if isinstance(shape, Voxels):
        cell = [math.floor((at - low) / step) for at, low, step in zip((x, y), shape.origin, shape.step, strict=False)]
        if not all(0 <= k < count for k, count in zip(cell, shape.occupied.shape, strict=False)):
            return []
        column = np.append(shape.occupied[cell[0], cell[1]], False)
        return [shape.origin[2] + shape.step[2] * (k + 1) for k in np.flatnonzero(column[:-1] & ~column[1:]).tolist()]
    if isinstance(shape, Prism):
        within = is_inside((x, y), shape.vertices) and not any(is_inside((x, y), hole) for hole in shape.holes)
        return [shape.high] if within else []
    off = math.hypot(x - shape.centre[0], y - shape.centre[1])
    if off > shape.radius:
        return []
    return [shape.high] if isinstance(shape, Cylinder) else [shape.centre[2] + math.sqrt(shape.radius**2 - off**2)]


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
