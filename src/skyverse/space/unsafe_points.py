"""Starts and targets that are not safe: why, how high the roof or the ground is there, and the nearest free place."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats, Ints
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Lattice, Scenario
from skyverse.model.shape_extent import roof_z
from skyverse.model.short_lines import told_metres
from skyverse.model.uav import UAV, TrackingError
from skyverse.space.lattice import make_grid, positions
from skyverse.space.pads import lifted, why_no_pad
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import World

Place = tuple[float, float, float]
AreFree = Callable[[Floats], NDArray[np.bool_]]
"""Tells for each of (m, 3) points whether it may be taken, (m,)."""

FIRST_RADIUS = 0.01
"""Metres: the radius of the first sphere on which free places are sought."""
RADIUS_RATIO = 1.15
"""By how much each sphere is larger than the one before."""
DIRECTIONS = 400
"""Places on each sphere, spread evenly, besides the six along the axes."""
CIRCLE = 32
"""Places on each circle on which places with room for a pad are sought."""
BISECTIONS = 40
"""Halvings of the way to a free place, which find where it begins to be free."""
MAX_DECIMALS = 6


CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
"""The index steps from the lowest node of a lattice's cell to its eight corners."""


class Regions:
    """The regions of free space that the moves of a lattice join.

    Parameters
    ----------
    world
        What is free.
    lattice
        The lattice.
    """

    def __init__(self, world: World, lattice: Lattice) -> None:
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        self._world, self._grid = world, make_grid(world, lattice)
        exits, count = self._grid.exits, len(self._grid.exits)
        begins = [np.flatnonzero(exits & (1 << move)) for move in range(0, len(self._grid.moves), 2)]
        ends = [nodes + self._grid.offsets[2 * axis] for axis, nodes in enumerate(begins)]
        a, b = np.concatenate(begins), np.concatenate(ends)
        joined = coo_array((np.ones(len(a), dtype=np.bool_), (a, b)), shape=(count, count))
        self._label: Ints = np.where(exits != 0, connected_components(joined, directed=False)[1], -1)

    def of(self, points: ArrayLike) -> set[int]:
        """Return the regions that any of (n, 3) places in metres lie in."""
        return set(self._labels(np.array(points, dtype=np.float64).reshape(-1, 3)).ravel().tolist()) - {-1}

    @property
    def largest(self) -> int:
        """The region of most nodes."""
        return int(np.bincount(self._label[self._label >= 0], minlength=1).argmax())

    def hold(self, points: Floats, regions: set[int]) -> NDArray[np.bool_]:
        """Tell for each of (n, 3) places in metres whether it lies in one of some regions, (n,)."""
        return np.asarray(np.isin(self._labels(points), list(regions)).any(axis=1))

    def _labels(self, points: Floats) -> Ints:
        """Return the regions of the nodes around each place that are joined to it, (n, 8), -1 for others."""
        shape = np.array(self._grid.shape)
        low = np.floor((points - self._grid.origin) / self._grid.step).astype(np.int64)
        nodes = np.sum(np.clip(low[:, None] + CORNERS, 0, shape - 1) * [shape[1] * shape[2], shape[2], 1], axis=2)
        found = self._label[nodes]
        asked = np.argwhere(found >= 0)
        starts = points[asked[:, 0]]
        free = self._world.segments_free(starts, positions(self._grid, nodes[tuple(asked.T)]))
        found[tuple(asked[~free].T)] = -1
        return found


class UnsafePoint(NamedTuple):
    """A start or target that is not safe.

    Attributes
    ----------
    field, name
        Its place in the scenario, such as ``"uavs[0].start"``, and the name of its UAV or target.
    position
        x, y, z in metres.
    reason
        The end of a sentence that says why it is unsafe, as in ``"lies inside obstacles[3] ..."``.
    nearest
        A free place; ``None`` if there is none.
    noun
        What to call that place; see `free_place_noun`.
    on_earth
        Latitude, longitude, degrees, and metres above sea of the nearest free place, where the frame is on Earth.
    """

    field: str
    name: str
    position: Place
    reason: str
    nearest: Place | None
    noun: str = "the nearest free place"
    on_earth: Place | None = None

    @property
    def sentence(self) -> str:
        """What is wrong with the point, and where a free place is."""
        return f"{self.field} ({self.name}): expected a safe point, found {written(self.position)}, which {self.advice}"

    @property
    def advice(self) -> str:
        """The reason, and where a free place is."""
        if self.nearest is None:
            return f"{self.reason}; no place within the bounds is free"
        away = math.dist(self.nearest, self.position)
        also = ""
        if self.on_earth is not None:
            latitude, longitude, sea = self.on_earth
            also = f" or {latitude:.7f},{longitude:.7f},{sea:.2f} m amsl"
        return f"{self.reason}; {self.noun} is {written(self.nearest)}{also}, {told_metres(away)} away"


def unsafe_points(scenario: Scenario, world: World | None = None) -> list[UnsafePoint]:
    """Return all starts and targets of a scenario that are not safe, in its order.

    A start is safe if its UAV may stray from it, or has a pad there; a target is if that holds for some UAV.

    Parameters
    ----------
    scenario
        The scenario.
    world
        Its space without tracking errors, if that is compiled already.
    """
    world = world or World(scenario)
    places = [(f"uavs[{i}].start", uav.name, uav.start, [uav]) for i, uav in enumerate(scenario.uavs)]
    everybody = list(scenario.uavs)
    places += [(f"targets[{i}].position", t.name, t.position, everybody) for i, t in enumerate(scenario.targets)]
    free = world.free([point for _, _, point, _ in places]) if places else np.ones(0, dtype=np.bool_)
    worlds = {NO_ERROR: world}
    found = []
    allowed = None if free.all() else _joined_to(scenario, world, [place[2] for place in places], free)
    for (field, name, point, uavs), safe in zip(places, free, strict=True):
        reason = None
        if safe:
            if not uavs or any(_can_leave(scenario, worlds, uav, point) for uav in uavs):
                continue
            strict = worlds[uavs[0].tracking_error]
            reason = why_no_pad(world, strict, scenario.uavs.index(uavs[0]), point)
            reason = reason or _reason(scenario, strict, point)
        nearest = _nearest_safe(scenario, worlds, uavs, point, allowed)
        if nearest is None and allowed is not None:
            nearest = _nearest_safe(scenario, worlds, uavs, point)
        reason = reason or _reason(scenario, world, point)
        noun = free_place_noun(uavs)
        found.append(UnsafePoint(field, name, point, reason, nearest, noun, _on_earth(scenario, nearest)))
    return found


def _joined_to(scenario: Scenario, world: World, points: Sequence[Place], free: NDArray[np.bool_]) -> AreFree | None:
    """Return what tells which places lie in the regions of a scenario's free starts and targets, or else the largest.

    Free places elsewhere, such as gaps within what a scan has not seen, would be of no use. ``None`` where the lattice
    is too coarse to tell.
    """
    known = [point for point, safe in zip(points, free, strict=True) if safe]
    regions = Regions(world, scenario.lattice)
    wanted = regions.of(known) if known else {regions.largest}
    return (lambda places: regions.hold(places, wanted)) if wanted else None


def free_place_noun(uavs: Sequence[UAV]) -> str:
    """Return what to call a free place for any of these UAVs.

    It is the nearest, to within about one per cent of its distance, where none of them has a tracking error. With one,
    a place from which the UAV can stray or that has room for its pad is sought on circles, and another may be nearer.
    """
    return "the nearest free place" if all(uav.tracking_error == NO_ERROR for uav in uavs) else "a free place"


def _on_earth(scenario: Scenario, place: Place | None) -> Place | None:
    if place is None or scenario.frame.origin is None:
        return None
    latitude, longitude, sea = to_wgs84(scenario.frame.origin, [place])[0].tolist()
    return latitude, longitude, sea


class SafePlaces:
    """The places at which some UAV of a fleet may start or arrive.

    Parameters
    ----------
    scenario
        The scenario.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._worlds = {NO_ERROR: World(scenario)}

    def nearest(self, point: Place, allowed: AreFree) -> Place | None:
        """Return the safe place nearest to a point among those that are allowed; ``None`` if none is found."""
        return _nearest_safe(self._scenario, self._worlds, self._scenario.uavs, point, allowed)


def _nearest_safe(
    scenario: Scenario,
    worlds: dict[TrackingError, World],
    uavs: Sequence[UAV],
    point: Place,
    allowed: AreFree | None = None,
) -> Place | None:
    """Return a free place that some UAV can leave: it may stray from there, or has a pad.

    It is the free place nearest to a point, or, if no UAV can leave that, a place on a circle at the height of it.
    """
    place = nearest_free(worlds[NO_ERROR], point, allowed)
    if place is None or not uavs or any(_can_leave(scenario, worlds, uav, place) for uav in uavs):
        return place
    places = [nearest_free(worlds[error], point, allowed) for error in {uav.tracking_error for uav in uavs}]
    found = min((place for place in places if place), key=lambda place: math.dist(place, point), default=None)
    nominal = worlds[NO_ERROR]
    longest = math.dist(nominal.high, nominal.low) if found is None else math.dist(found, point)
    for other in _on_circles((*point[:2], place[2]), longest):
        asked = np.array([other])
        free = nominal.free(asked)[0] and (allowed is None or allowed(asked)[0])
        if free and any(_can_leave(scenario, worlds, uav, other) for uav in uavs):
            return other
    return found


def _on_circles(point: Place, longest: float) -> Iterator[Place]:
    """Yield places on growing circles about a point, at its height; x and y are rounded to centimetres."""
    radius = FIRST_RADIUS
    while radius < longest:
        for turn in np.linspace(0.0, 2 * math.pi, CIRCLE, endpoint=False).tolist():
            x, y = (
                round(value, 2) for value in (point[0] + radius * math.cos(turn), point[1] + radius * math.sin(turn))
            )
            yield x, y, point[2]
        radius *= RADIUS_RATIO


def _can_leave(scenario: Scenario, worlds: dict[TrackingError, World], uav: UAV, point: Place) -> bool:
    """Tell whether a UAV may stray from a place that is safe, or from above it if it has a pad there."""
    error = uav.tracking_error
    if error == NO_ERROR:
        return True
    if error not in worlds:
        worlds[error] = World(scenario, error)
    return bool(worlds[error].free(lifted(worlds[NO_ERROR], worlds[error], scenario.uavs.index(uav), point))[0])


def _reason(scenario: Scenario, world: World, point: Place) -> str:
    """Say why a point is unsafe, with the height of the roof above it where it lies in an obstacle."""
    reason = world.why_unsafe(point) or "is not safe"
    number = world.blocker(point) if "inside" in reason else None
    if number is None:
        return reason
    if scenario.obstacles[number].closed_above:
        return f"{reason}; it is closed above, so that no place above it is free"
    roof = roof_z(scenario.obstacles[number], point, scenario.clearance)
    if roof > scenario.bounds.max[2]:
        return f"{reason}, which reaches above the bounds"
    origin = scenario.frame.origin
    sea = "" if origin is None else f" ({roof + origin.altitude:.1f} m amsl)"
    return f"{reason}; the roof is at z = {roof:.6g} m{sea} there"


def nearest_free(world: World, point: Place, allowed: AreFree | None = None) -> Place | None:
    """Return the free place nearest to a point that is not free, sought on growing spheres; ``None`` if none is found.

    Its coordinates have as few decimals as they can, two or more. With `allowed`, other free places do not count.
    """

    def free(points: Floats) -> NDArray[np.bool_]:
        return world.free(points) if allowed is None else world.free(points) & allowed(points)

    low, high = world.space.low, world.space.high
    middle = np.clip(point, low, high)
    if free(middle[None])[0]:
        return _rounded(free, point, middle)
    radius, longest = FIRST_RADIUS, math.dist(high, low)
    ways = _directions()
    while radius <= longest * RADIUS_RATIO:
        found = np.clip(middle + radius * ways, low, high)
        found = found[free(found)]
        if len(found):
            found = _begun(free, middle, found)
            best = found[np.linalg.norm(found - point, axis=1).argmin()]
            return _rounded(free, point, best)
        radius *= RADIUS_RATIO
    return None


def _directions() -> Floats:
    """Return unit vectors (k, 3): the six along the axes, and others spread evenly on a spiral."""
    turn = np.arange(DIRECTIONS) * np.pi * (3 - np.sqrt(5))
    z = 1 - (2 * np.arange(DIRECTIONS) + 1) / DIRECTIONS
    spiral = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    return np.concatenate([np.eye(3), -np.eye(3), spiral])


def _begun(are_free: AreFree, middle: Floats, found: Floats) -> Floats:
    """Return, on the way from a place that is not free to each of the free places (n, 3), where it is free first."""
    shut = np.broadcast_to(middle, found.shape).copy()
    for _ in range(BISECTIONS):
        half = (shut + found) / 2
        free = are_free(half)
        found, shut = np.where(free[:, None], half, found), np.where(free[:, None], shut, half)
    return found


def _rounded(are_free: AreFree, point: Place, place: Floats) -> Place:
    """Return a free place beside a free place, rounded to as few decimals as can be, the one nearest to a point."""
    for decimals in range(2, MAX_DECIMALS + 1):
        scale = 10.0**decimals
        near = np.array(list(itertools.product(*zip(np.floor(place * scale), np.ceil(place * scale), strict=True))))
        near = near / scale + 0.0  # no minus zero
        near = near[are_free(near)]
        if len(near):
            x, y, z = near[np.linalg.norm(near - point, axis=1).argmin()].tolist()
            return x, y, z
    x, y, z = place.tolist()
    return x, y, z


def written(place: Place) -> str:
    """Return a place as a message shows it."""
    return f"({', '.join(f'{value:.10g}' for value in place)})"
