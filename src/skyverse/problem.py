"""One UAV, one way from place to place, one objective, compiled."""

import math
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing, Rates, make_pricing, make_rates
from skyverse.errors import InputError, shown
from skyverse.model.mission import index_of
from skyverse.model.result import Status
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import as_lines, told_metres, told_point
from skyverse.model.timed_shapes import is_closed_at_times, temporary_zones
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import SIGHT_MARGIN
from skyverse.search.lattice_astar import LatticePath, shortest_route
from skyverse.space.cells import Cells, make_cells
from skyverse.space.edges import Edges, make_edges
from skyverse.space.lattice import Grid, make_grid, positions, snap
from skyverse.space.pads import lifted
from skyverse.space.timed_shapes import MovingShapes, moving_shapes, timed_parts
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import World, point_free


class Airspace:
    """A scenario's world, lattice and prices, compiled once, when asked for, and shared by all of its problems.

    Parameters
    ----------
    scenario
        The scenario that is compiled.
    error
        How far UAVs stray from where they should be; by default not at all. See `of`.
    """

    def __init__(self, scenario: Scenario, error: TrackingError = NO_ERROR) -> None:
        if not isinstance(scenario, Scenario):
            said = f"expected a Scenario, found {shown(scenario)}; read(...) makes one of a name or a file"
            raise InputError(said, field="scenario")
        self.scenario = scenario
        self.world = World(scenario, error)
        self.nominal = self
        self._straying: dict[TrackingError, Airspace] = {}

    def __repr__(self) -> str:
        return f"Airspace of {self.scenario!r}"

    def of(self, uav: int) -> "Airspace":
        """Return the airspace for the nominal position of a UAV: this one, where the UAV does not stray from it.

        There is one for each distinct tracking error of the fleet. Its `nominal` is the airspace without it.
        """
        error = self.scenario.uavs[uav].tracking_error
        if error == NO_ERROR:
            return self.nominal
        known = self.nominal._straying
        if error not in known:
            known[error] = Airspace(self.scenario, error)
            known[error].nominal = self.nominal
        return known[error]

    def lifted(self, uav: int, place: tuple[float, float, float]) -> Floats:
        """Return the lowest place straight above a UAV's start or target, (3,) metres, from which it may stray."""
        return lifted(self.nominal.world, self.world, uav, place)

    @cached_property
    def grid(self) -> Grid:
        """The lattice over the world."""
        return make_grid(self.world, self.scenario.lattice)

    @cached_property
    def rates(self) -> Rates:
        """The objective's prices of straight legs."""
        return make_rates(self.scenario)

    @cached_property
    def cells(self) -> Cells:
        """Free space, cut into cells, which are boxes."""
        return make_cells(self.world.space, self.world.space.clearance + 3 * SIGHT_MARGIN)

    @cached_property
    def edges(self) -> Edges:
        """The edges of obstacles at which a shortest path can bend."""
        return make_edges(self.world.space, self.world.space.clearance + 2 * SIGHT_MARGIN)

    @cached_property
    def moving(self) -> MovingShapes:
        """Movers, and zones that are closed at times; zones with a speed limit are left out, as it can be kept."""
        limited = {k for k in temporary_zones(self.scenario) if not is_closed_at_times(self.scenario.zones[k])}
        return moving_shapes(timed_parts(self.scenario, limited), self.world.error)

    @cached_property
    def pricing(self) -> Pricing:
        """The objective's prices on the lattice."""
        return make_pricing(self.scenario.objective, self.grid.step, self.rates)


class Problem:
    """One UAV that has to reach one target, or a later leg of its tour: from a target to another one, or home.

    Parameters
    ----------
    scenario
        The scenario; an `Airspace` of it in its place saves compiling it again for each of its problems.
    uav, target
        Indices of the scenario's UAVs and targets, or their names; the target is ``None`` for the way home.
    begins
        The target, by index or name, from which the UAV comes; ``None`` where it comes from its start.
    departs
        Seconds into the mission at which the UAV departs. Planners that price contact with movers heed it.

    Attributes
    ----------
    airspace
        Of this UAV, with its tracking error.
    start, end
        (3,) metres: where the path is planned from and to. That is where the UAV and its target are, or above
        them, where the UAV may stray that takes off from a pad and lands on one.
    uav_place, target_place
        (3,) metres: where the UAV and its target are, without the height above their pads.

    Raises
    ------
    InputError
        If the scenario is none, or has no such UAV or target, or `departs` is no such instant.
    """

    def __init__(
        self,
        scenario: Scenario | Airspace,
        uav: int | str = 0,
        target: int | str | None = 0,
        *,
        begins: int | str | None = None,
        departs: float = 0.0,
    ) -> None:
        airspace = scenario if isinstance(scenario, Airspace) else Airspace(scenario)
        self.scenario = airspace.scenario
        self.uav = uav = index_of(self.scenario.uavs, uav, "uav")
        targets, home = self.scenario.targets, self.scenario.uavs[uav].start
        self.target = None if target is None else index_of(targets, target, "target")
        self.begins = None if begins is None else index_of(targets, begins, "begins")
        if not isinstance(departs, float | int | np.number) or not 0.0 <= departs < math.inf:
            raise InputError(f"expected a number of seconds from 0 on, found {shown(departs)}", field="departs")
        self.departs = float(departs)
        self.airspace = airspace.of(uav)
        begin, end = (home if k is None else targets[k].position for k in (self.begins, self.target))
        self.uav_place, self.target_place = np.array(begin), np.array(end)
        self.start, self.end = self.airspace.lifted(uav, begin), self.airspace.lifted(uav, end)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Problem):
            return NotImplemented
        ours, theirs = ((one.uav, one.target, one.begins, one.departs) for one in (self, other))
        return ours == theirs and (self.scenario is other.scenario or self.scenario == other.scenario)

    def __hash__(self) -> int:
        return hash((self.uav, self.target, self.begins, self.departs))

    def __repr__(self) -> str:
        targets = self.scenario.targets
        begins = "" if self.begins is None else f"{targets[self.begins].name} at "
        target = "its start" if self.target is None else targets[self.target].name
        return as_lines(
            f"Problem in scenario {self.scenario.name!r}: {self.scenario.uavs[self.uav].name} from "
            f"{begins}{told_point(self.uav_place)} to {target} at {told_point(self.target_place)}",
            f"{told_metres(math.dist(self.uav_place, self.target_place))} as the crow flies",
        )

    @property
    def lifts(self) -> tuple[Floats, Floats]:
        """The UAV's start and its target, (1, 3) metres each, where it must rise from them first; (0, 3) elsewhere."""
        up, down = (
            place[None][: int(not np.array_equal(place, top))]
            for place, top in ((self.uav_place, self.start), (self.target_place, self.end))
        )
        return up, down

    def without_lifts(self, path: Floats) -> Floats:
        """Return the path (n, 3) of a result of any angle without the legs on the pads at its ends: what is planned."""
        up, down = self.lifts
        if len(up):
            path = path[1:]
        return path[:-1] if len(down) and np.array_equal(path[-1], self.target_place) else path

    @cached_property
    def _endpoints(self) -> tuple[tuple[int, Status | None], tuple[int, Status | None]]:
        """The nodes that stand for the start and the target, each with the status that refuses it."""
        return snap_endpoint(self.airspace, self.start, start=True), snap_endpoint(self.airspace, self.end, start=False)

    @property
    def source(self) -> int:
        """The lattice node that stands for the start, -1 where none can."""
        return self._endpoints[0][0]

    @property
    def goal(self) -> int:
        """The lattice node that stands for the target, -1 where none can."""
        return self._endpoints[1][0]

    @property
    def refusal(self) -> Status | None:
        """The status that says why there is nothing to plan on the lattice, or ``None``."""
        return self._endpoints[0][1] or self._endpoints[1][1]

    @property
    def any_angle_refusal(self) -> Status | None:
        """The status that says why there is nothing to plan for a path that leaves the lattice, or ``None``."""
        world = self.airspace.world
        for point, outside, unsafe in (
            (self.start, Status.START_OUT_OF_BOUNDS, Status.START_UNSAFE),
            (self.end, Status.TARGET_OUT_OF_BOUNDS, Status.TARGET_UNSAFE),
        ):
            if np.any(point < world.low) or np.any(point > world.high):
                return outside
            if not point_free(world.space, point):
                return unsafe
        return None

    @cached_property
    def route(self) -> LatticePath | None:
        """The exact answer: a cheapest path on this lattice, or ``None`` where no path joins start and goal."""
        if self.refusal is not None:
            return None
        return shortest_route(self.airspace.grid, self.airspace.pricing, self.source, self.goal)

    def places(self, nodes: Ints | list[int]) -> Floats:
        """Return the places of (n,) lattice nodes, (n, 3) metres."""
        return positions(self.airspace.grid, nodes)


def snap_endpoint(airspace: Airspace, point: ArrayLike, start: bool) -> tuple[int, Status | None]:
    """Find the lattice node that stands for a point from which or to which is planned, and the status that refuses it.

    The node is -1 where there is none.
    """
    p = np.array(point, dtype=np.float64)
    world, space, grid = airspace.world, airspace.world.space, airspace.grid
    if np.any(p < world.low) or np.any(p > world.high):
        return -1, Status.START_OUT_OF_BOUNDS if start else Status.TARGET_OUT_OF_BOUNDS
    node, shut_in = snap(grid, space, p)
    if node < 0:
        return -1, Status.START_UNSAFE if start else Status.TARGET_UNSAFE
    if shut_in and start:
        return node, Status.START_SHUT_IN
    return node, None
