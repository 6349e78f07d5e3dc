"""The planner where none is named: it chooses one by what the scenario prices."""

from dataclasses import dataclass

from skyverse.cost import prices_length_alone
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Voxels
from skyverse.planners.astar import AStar
from skyverse.planners.base import Planner, Seed, require_problem
from skyverse.planners.cheapest import Cheapest
from skyverse.planners.taut import Taut
from skyverse.problem import Problem
from skyverse.stop import OnIteration, Stop

FEWEST_LEGS, LEGS_PER_SHAPE, MOST_LEGS = 1_000_000, 100_000, 3_000_000
"""The legs that `Cheapest` may price: more among more obstacles and zones, as there are more ways to compare."""

MOST_SHAPES = 2_000
"""Obstacles above which only `Taut` seeks shortest paths: among more of them `Cheapest` takes too long."""


@dataclass(frozen=True, kw_only=True)
class Auto(Planner):
    """The planner that finds the cheapest paths of a scenario's own objective; it is used where none is named.

    It chooses by what the scenario prices:

    - nodes: `AStar`, which is exact on the lattice;
    - metres, and nothing else, among boxes, voxels and ground: `Taut`, which finds shortest paths and a proven bound;
    - metres, among up to 2,000 obstacles of which some have other shapes, or with turns, altitude, risk or climb:
      `Cheapest`, which begins with the path of `Taut` and seeks other ways. It may price 1 to 3 million legs, more of
      them among more obstacles and zones, and begins anew with half of them beside zones.

    An aeroplane cannot follow the moves of a lattice. A fleet that has one is planned as if the objective were in
    metres, and so are its costs.

    Results say which planner found them, in `provenance`. All three end by themselves: `stop`, `rng` and `on_iteration`
    have no effect.
    """

    def choose(self, scenario: Scenario) -> Planner:
        """Return the planner for a scenario."""
        if scenario.objective.unit == "nodes" and all(uav.fixed_wing is None for uav in scenario.uavs):
            return AStar()
        flat = all(isinstance(shape, Box | Voxels) for shape in scenario.obstacles)
        if prices_length_alone(scenario) and (flat or len(scenario.obstacles) > MOST_SHAPES):
            return Taut()
        legs = min(MOST_LEGS, FEWEST_LEGS + LEGS_PER_SHAPE * len(scenario.obstacles + scenario.risky_zones))
        restarts = 1 if scenario.risky_zones else 0
        return Cheapest(legs=legs // (1 + restarts), restarts=restarts)

    def leaves_lattice(self, scenario: Scenario) -> bool:
        """Tell whether the planner for a scenario leaves its lattice."""
        return self.choose(scenario).leaves_lattice(scenario)

    def plan(
        self, problem: Problem, *, stop: Stop | None = None, rng: Seed = None, on_iteration: OnIteration | None = None
    ) -> Result:
        """Plan one UAV's path by the planner for its scenario; see `Planner.plan`."""
        require_problem(problem, stop)
        return self.choose(problem.scenario).plan(problem, stop=stop, rng=rng, on_iteration=on_iteration)
