"""One UAV, one target, one objective, compiled."""

from functools import cached_property

import numpy as np

from skyverse.cost import make_pricing
from skyverse.exact import Route, shortest_route
from skyverse.result import Floats, Status
from skyverse.scenario import Scenario
from skyverse.space.lattice import Ints, make_grid, positions, snap
from skyverse.space.world import World


class Airspace:
    """A scenario's world, lattice and prices, compiled once and shared by all of its problems.

    Parameters
    ----------
    scenario
        Whose space to compile.
    """

    def __init__(self, scenario: Scenario) -> None:
        if not isinstance(scenario, Scenario):
            raise TypeError(f"expected a Scenario, got {scenario!r:.60}; read(...) makes one of a name or a file")
        self.scenario = scenario
        self.world = World(scenario)
        self.grid = make_grid(self.world, scenario.lattice)
        self.pricing = make_pricing(scenario.objective, self.grid.step)


class Problem:
    """One UAV's way to one target.

    Parameters
    ----------
    scenario
        What is given; an `Airspace` of it saves compiling it again for each of its problems.
    uav, target
        Indices into the scenario's UAVs and targets.

    Attributes
    ----------
    source, goal
        The lattice nodes that stand for start and target, -1 where none can.
    refusal
        The status that says why there is nothing to plan, or ``None``.

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
        self.source, source_refusal = stand(self.airspace, self.scenario.uavs[uav].start, start=True)
        self.goal, goal_refusal = stand(self.airspace, self.scenario.targets[target].position, start=False)
        self.refusal = source_refusal or goal_refusal

    @cached_property
    def route(self) -> Route | None:
        """The exact answer: a cheapest path on this lattice, or ``None`` where none joins start and goal."""
        if self.refusal is not None:
            return None
        return shortest_route(self.airspace.grid, self.airspace.pricing, self.source, self.goal)

    def places(self, nodes: Ints | list[int]) -> Floats:
        """Return the places of (n,) lattice nodes, (n, 3) metres."""
        return positions(self.airspace.grid, nodes)


def stand(airspace: Airspace, point: tuple[float, float, float], start: bool) -> tuple[int, Status | None]:
    """Find the node that stands for a UAV's start or a target, -1 for none, and the status that refuses it."""
    p = np.array(point)
    space, grid = airspace.world.space, airspace.grid
    if np.any(p < space.low) or np.any(p > space.high):
        return -1, Status.START_OUT_OF_BOUNDS if start else Status.TARGET_OUT_OF_BOUNDS
    node, shut_in = snap(grid, space, p)
    if node < 0:
        return -1, Status.START_UNSAFE if start else Status.TARGET_UNSAFE
    if shut_in and start:
        return node, Status.START_SHUT_IN
    return node, None
