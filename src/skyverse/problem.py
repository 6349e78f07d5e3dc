"""One UAV, one target, one objective, compiled."""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats, Ints
from skyverse.cost import Pricing, Rates, make_pricing, make_rates
from skyverse.model.result import Status
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import SEAM_MARGIN
from skyverse.search.lattice_astar import LatticePath, shortest_route
from skyverse.space.cells import Cells, make_cells
from skyverse.space.edges import Edges, make_edges
from skyverse.space.lattice import Grid, make_grid, positions, snap
from skyverse.space.world import World, point_free


class Airspace:
    """A scenario's world, lattice and prices, compiled once, when asked for, and shared by all of its problems.

    Parameters
    ----------
    scenario
        The scenario that is compiled.
    """

    def __init__(self, scenario: Scenario) -> None:
        if not isinstance(scenario, Scenario):
            raise TypeError(f"expected a Scenario, got {scenario!r:.60}; read(...) makes one of a name or a file")
        self.scenario = scenario
        self.world = World(scenario)

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
        return make_cells(self.world.space, self.scenario.clearance + 3 * SEAM_MARGIN)

    @cached_property
    def edges(self) -> Edges:
        """The edges of obstacles at which a shortest path can bend."""
        return make_edges(self.world.space, self.scenario.clearance + 2 * SEAM_MARGIN)

    @cached_property
    def pricing(self) -> Pricing:
        """The objective's prices on the lattice."""
        return make_pricing(self.scenario.objective, self.grid.step, self.rates)


class Problem:
    """One UAV that has to reach one target.

    Parameters
    ----------
    scenario
        The scenario; an `Airspace` of it in its place saves compiling it again for each of its problems.
    uav, target
        Indices into the scenario's UAVs and targets.

    Attributes
    ----------
    start, end
        (3,) metres: where the UAV and its target are.

    Raises
    ------
    ValueError
        If the scenario has no such UAV or target.
    """

    def __init__(self, scenario: Scenario | Airspace, uav: int = 0, target: int = 0) -> None:
        self.airspace = scenario if isinstance(scenario, Airspace) else Airspace(scenario)
        self.scenario = self.airspace.scenario
        for kind, index, things in (
            ("uav", uav, self.scenario.uavs),
            ("target", target, self.scenario.targets),
        ):
            if not 0 <= index < len(things):
                raise ValueError(
                    f"scenario {self.scenario.name!r} has {len(things)} {kind}s, there is no {kind} {index}"
                )
        self.uav = uav
        self.target = target
        self.start = np.array(self.scenario.uavs[uav].start)
        self.end = np.array(self.scenario.targets[target].position)

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
        space = self.airspace.world.space
        for point, outside, unsafe in (
            (self.start, Status.START_OUT_OF_BOUNDS, Status.START_UNSAFE),
            (self.end, Status.TARGET_OUT_OF_BOUNDS, Status.TARGET_UNSAFE),
        ):
            if np.any(point < space.low) or np.any(point > space.high):
                return outside
            if not point_free(space, point):
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
    """Find the lattice node that stands for a UAV's start or a target, -1 for none, and the status that refuses it."""
    p = np.array(point, dtype=np.float64)
    space, grid = airspace.world.space, airspace.grid
    if np.any(p < space.low) or np.any(p > space.high):
        return -1, Status.START_OUT_OF_BOUNDS if start else Status.TARGET_OUT_OF_BOUNDS
    node, shut_in = snap(grid, space, p)
    if node < 0:
        return -1, Status.START_UNSAFE if start else Status.TARGET_UNSAFE
    if shut_in and start:
        return node, Status.START_SHUT_IN
    return node, None
