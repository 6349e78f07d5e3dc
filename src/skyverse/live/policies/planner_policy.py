"""What policies that ask a planner have in common: its settings, and the problem that it is given."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skyverse.errors import InputError
from skyverse.live.guidance import Way, guidance
from skyverse.live.policies.policy import Policy, Situation, require_positive
from skyverse.live.policies.swept_boxes import swept_boxes
from skyverse.model.mover import Mover
from skyverse.model.quantities import derived
from skyverse.model.result import Effort, Result
from skyverse.planners import make_planner
from skyverse.planners.base import Planner
from skyverse.planners.hybrid import HybridMVO
from skyverse.planners.lattice import LatticeSearch
from skyverse.problem import Problem


@dataclass(frozen=True, kw_only=True)
class PlannerPolicy(Policy):
    """A policy that asks a planner, from where the UAV would come to rest, for a path to the target.

    Attributes
    ----------
    planner
        The name of a planner.
    settings
        Its settings.
    paths
        How many paths it may generate; planners that end by themselves take what they take.
    sweep
        Seconds ahead over which movers are obstacles: boxes that hold them wherever they may be.
    timed
        Whether movers are no such obstacles, but each path is priced by what its flight meets of them at which time;
        only metaheuristics on lattice paths do so.
    """

    planner: str = "mvo"
    settings: dict[str, Any] = field(default_factory=dict)
    paths: int = 200
    sweep: float = 1.0
    timed: bool = False

    def __post_init__(self) -> None:
        made = self.made()
        require_positive(self, "sweep")
        if isinstance(self.paths, bool) or not isinstance(self.paths, int) or self.paths < 1:
            raise InputError(f"paths is a whole number from 1 on, not {self.paths!r}")
        if not isinstance(self.timed, bool):
            raise InputError(f"timed is true or false, not {self.timed!r}")
        if self.timed and not isinstance(made, LatticeSearch | HybridMVO):
            raise InputError(f"timed needs a planner that prices contact in time, such as 'mvo', not {self.planner!r}")

    def made(self) -> Planner:
        """Return the planner."""
        return make_planner(self.planner, **self.settings)


def problem_now(situation: Situation, sweep: float, timed: bool) -> Problem:
    """Return the problem of a UAV from where it would come to rest, among movers as the settings of a policy say."""
    scenario = situation.scenario
    uavs = list(scenario.uavs)
    uavs[situation.uav] = derived(uavs[situation.uav], start=tuple(situation.stop.tolist()))
    update: dict[str, Any] = {"uavs": tuple(uavs)}
    if timed:
        update["movers"] = tuple(
            Mover.model_construct(name=f"mover {k}", kind=None, shape=one.shape, motion=one.motion, doubt=one.doubt)  # type: ignore[arg-type]
            for k, one in enumerate(situation.movers)
        )
        return Problem(derived(scenario, **update), situation.uav, situation.target, departs=situation.join)
    target = np.array(scenario.targets[situation.target].position)
    end = min(situation.now + sweep, situation.until)
    ends = (situation.stop, target)
    boxes = swept_boxes(situation.movers, situation.now, end, scenario.clearance, ends)
    update["obstacles"] = (*scenario.obstacles, *boxes)
    return Problem(derived(scenario, **update), situation.uav, situation.target)


def planned(problem: Problem, result: Result) -> tuple[Way | None, Effort]:
    """Return the way of a result from where the UAV is, and its effort."""
    if not result.status.reached or not math.isfinite(result.cost):
        return None, result.effort
    way = guidance(problem, result).after(1)
    return Way(way.points, way.most, np.full(len(way.points), -1)), result.effort
