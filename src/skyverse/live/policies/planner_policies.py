"""Where movers may be in the next seconds, as boxes: obstacles for planners that know no time.

What policies that ask a planner have in common: its settings, and the problem that it is given.

A planner asked anew at every observation, which remembers nothing of its last answer.

A metaheuristic asked at every observation, which begins with the population of its last answer.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind, require_number, require_whole
from skyverse.live.guidance import Way, guidance
from skyverse.live.policies.policy import LEAST, MOST, Found, Policy, Situation
from skyverse.model.mover import Doubt, Mover
from skyverse.model.quantities import derived
from skyverse.model.result import Effort, Result
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box
from skyverse.model.timed_shapes import TimedShape
from skyverse.planners import make_planner
from skyverse.planners.base import Planner
from skyverse.planners.lattice import LatticeSearch
from skyverse.problem import Problem
from skyverse.stop import MaxPaths

SLICES = 4
"""Parts of the time ahead; where a mover may be in each is one box."""
SAMPLES = 5
"""Instants of each part at which the stated motion is looked at; those of seen movers are straight."""


def swept_boxes(
    movers: Sequence[TimedShape], begin: float, end: float, clearance: float, kept_free: Sequence[Floats]
) -> list[Box]:
    """Return boxes that hold movers wherever they may be between two instants.

    Parameters
    ----------
    movers
        Of any shape but voxels and prisms.
    begin, end
        Seconds into the mission.
    clearance
        Metres that are kept from the boxes anyway.
    kept_free
        Places (3,). Boxes that are nearer to one of them than the clearance are left out: no path keeps clear of where
        it begins or ends, and the proof of the motion judges what happens there.
    """
    edges = np.linspace(begin, end, SLICES + 1)
    found = []
    for mover in movers:
        low, high = extent(mover.shape)
        more = mover.keep - clearance
        for early, late in pairwise(edges):
            least, most = _places(mover, float(early), float(late))
            box_low, box_high = least + low - more, most + high + more
            if np.any(box_high <= box_low):
                continue
            near = (np.all((box_low - clearance < at) & (at < box_high + clearance)) for at in kept_free)
            if not any(near):
                found.append(Box(min=tuple(box_low.tolist()), max=tuple(box_high.tolist())))
    return found


def _places(mover: TimedShape, early: float, late: float) -> tuple[Floats, Floats]:
    """Return the corners of a box that holds the moving point between two instants."""
    doubt: Doubt = mover.doubt
    places = mover.motion.at(np.linspace(early, late, SAMPLES))
    off = float(doubt.at(late)[0])
    low, high = places.min(axis=0) - off, places.max(axis=0) + off
    if doubt.top_speed is not None and late > doubt.since:
        seen, far = mover.motion.at([doubt.since])[0], doubt.radius + doubt.top_speed * (late - doubt.since)
        low, high = np.maximum(low, seen - far), np.minimum(high, seen + far)
    return low, high


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
        require_number(self.sweep, "sweep", "seconds", LEAST, MOST)
        require_whole(self.paths, "paths", 1)
        require_kind(self.timed, bool, "timed")
        if self.timed and not isinstance(made, LatticeSearch):
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
        return Problem(derived(scenario, **update), situation.uav, situation.target, departs=situation.span.join)
    target = np.array(scenario.targets[situation.target].position)
    end = min(situation.span.now + sweep, situation.span.until)
    ends = (situation.stop, target)
    boxes = swept_boxes(situation.movers, situation.span.now, end, scenario.clearance, ends)
    update["obstacles"] = (*scenario.obstacles, *boxes)
    return Problem(derived(scenario, **update), situation.uav, situation.target)


def planned(problem: Problem, result: Result) -> tuple[Way | None, Effort]:
    """Return the way of a result from where the UAV is, and its effort."""
    if not result.status.reached or not math.isfinite(result.cost):
        return None, result.effort
    way = guidance(problem, result).after(1)
    return Way(way.points, way.most, np.full(len(way.points), -1)), result.effort


@dataclass(frozen=True, kw_only=True)
class FromScratch(PlannerPolicy):
    """A planner asked anew at every observation, which remembers nothing of its last answer."""

    def find(self, situation: Situation) -> Found:
        """Return the planner's way."""
        problem = problem_now(situation, self.sweep, self.timed)
        return Found(*planned(problem, self.made().plan(problem, stop=MaxPaths(self.paths), rng=situation.rng)))


@dataclass(frozen=True, kw_only=True)
class KeptPopulation(PlannerPolicy):
    """A metaheuristic asked at every observation, which begins with the population of its last answer.

    All paths that were kept are followed from where the UAV would come to rest, repaired where something new stands,
    and priced anew; that counts as effort. `FromScratch` with the same settings is the same search without memory.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        self._search()

    def find(self, situation: Situation) -> Found:
        """Return the way of the best path."""
        problem = problem_now(situation, self.sweep, self.timed)
        kept = situation.memory if isinstance(situation.memory, tuple) else ()
        result, population = self._search().evolve(problem, kept, stop=MaxPaths(self.paths), rng=situation.rng)
        return Found(*planned(problem, result), population)

    def _search(self) -> LatticeSearch:
        """Return the planner, or raise `ValueError` if it keeps no population of lattice paths."""
        made: Planner = self.made()
        if not isinstance(made, LatticeSearch):
            raise InputError(f"planner is a metaheuristic on lattice paths, such as 'mvo', not {self.planner!r}")
        return made
