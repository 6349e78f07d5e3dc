"""How legs of tours are planned: by a planner, along the line of a survey, or around where other UAVs stand."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from skyverse.model.flight_table import places_along
from skyverse.model.quantities import derived
from skyverse.model.result import Result
from skyverse.model.shapes import LEAST_CLEARANCE, Box
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV, kept_ellipsoid
from skyverse.planners.auto import Auto
from skyverse.planners.base import DirectPlanner, Planner, provenance
from skyverse.planners.cheapest import Cheapest
from skyverse.planners.own_path import require_result
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.problem import Airspace, Problem
from skyverse.referee import energy_bounds
from skyverse.stop import Stop
from skyverse.survey.lines import PhotoLine
from skyverse.trajectory import Shape, leg_along, stopping_along, straight_along

PRICING_LEGS = 20_000
"""The straight legs that `Cheapest` may price for a leg of a tour while routes are sought."""

Ends = tuple[int | None, int | None]
"""Of a leg: the targets where it begins and ends, ``None`` for the UAV's start."""

_NO_MATTER = (
    *("name", "home", "end", "capacity", "look_at", "heading", "priority"),
    *("separation", "vertical_separation", "reserve", "batteries", "swap", "vehicle"),
)
"""The fields of a UAV by which legs do not differ."""


@dataclass(frozen=True, eq=False)
class Leg:
    """A leg of a tour: its path, its trajectory from rest to rest, and what the battery gives for it at most, J."""

    result: Result
    trajectory: Trajectory | None
    joules: float

    @property
    def seconds(self) -> float:
        """How long it takes, s; infinite where it cannot be flown."""
        return math.inf if self.trajectory is None else self.trajectory.duration


@dataclass(frozen=True, kw_only=True)
class LegPlanning:
    """How legs are planned: by what, until when, by which seed, in which shape, and by how many threads."""

    planner: Planner
    stop: Stop | None
    seed: int
    shape: Shape
    workers: int

    @property
    def pricer(self) -> Planner:
        """What prices legs while routes are sought: the planner, if it is quick and finds the same at any time."""
        if isinstance(self.planner, Cheapest):
            return replace(self.planner, legs=min(self.planner.legs, PRICING_LEGS), restarts=0)
        return self.planner if isinstance(self.planner, DirectPlanner) else Auto()


@dataclass(eq=False)
class LegPlanner:
    """Plans the legs between all places of a scenario, for each of its UAVs.

    Attributes
    ----------
    airspace, how
        What is flown in, and how legs are planned.
    lines
        Of surveys: what is flown between two targets that are the ends of a photo line, in the direction of the leg.
    """

    airspace: Airspace
    how: LegPlanning
    lines: Mapping[Ends, PhotoLine] = field(default_factory=dict)
    _walled: dict[tuple[int, ...], Airspace] = field(default_factory=dict)

    def leg(self, uav: int, ends: Ends, planner: Planner) -> Leg:
        """Return a leg of a UAV as a planner finds it."""
        problem = Problem(self.airspace, uav, ends[1], begins=ends[0])
        numbers = [self.how.seed, self.kinds[uav], *(0 if end is None else end + 1 for end in ends)]
        result, trajectory = self._flown(problem, planner, numbers)
        homes = () if trajectory is None else self._homes_met(problem, trajectory)
        if homes:
            around = Problem(self._without(homes), uav, ends[1], begins=ends[0])
            led = self._flown(around, planner, numbers)
            result, trajectory = (result, trajectory) if led[1] is None else led
        joules = 0.0
        if trajectory is not None and self.airspace.scenario.uavs[uav].usable_energy is not None:
            bounds = energy_bounds(self.airspace.scenario, uav, trajectory, trajectory.start, trajectory.end)
            joules = float(bounds[1][-1])
        return Leg(result, trajectory, joules)

    def _flown(self, problem: Problem, planner: Planner, seed: list[int]) -> tuple[Result, Trajectory | None]:
        line = self.lines.get((problem.begins, problem.target))
        if line is not None:
            result = any_angle_result(
                problem, line.path, None, SearchRecord(provenance("a line of a survey", None, None))
            )
            if line.stay:
                return result, stopping_along(problem, line.parts, line.speed, line.stay)
            return result, straight_along(problem, line.path, line.speed)
        result = require_result(planner.plan(problem, stop=self.how.stop, rng=np.random.default_rng(seed)))
        leaving, entering = self.headings
        headings = leaving.get(problem.begins), entering.get(problem.target)
        return result, leg_along(problem, result, self.how.shape, headings)

    @cached_property
    def headings(self) -> tuple[dict[int | None, float], dict[int | None, float]]:
        """Where an aeroplane heads where it leaves a line at its end, and where it enters one, rad from the x-axis."""
        leaving, entering = dict[int | None, float](), dict[int | None, float]()
        for (a, b), line in self.lines.items():
            for place, heading, (p, q) in ((a, entering, line.path[:2]), (b, leaving, line.path[-2:])):
                heading[place] = math.atan2(q[1] - p[1], q[0] - p[0])
        return leaving, entering

    def _homes_met(self, problem: Problem, trajectory: Trajectory) -> tuple[int, ...]:
        """Return the UAVs at whose starts a leg comes too near to them, as long as they stand there.

        A leg is shared by the UAVs of a kind, so that its own UAV counts, too, unless it is the only one.
        """
        scenario, places, met = self.airspace.scenario, places_along(trajectory), []
        own, ends = scenario.uavs[problem.uav], np.stack([problem.uav_place, problem.target_place])
        for number, other in enumerate(scenario.uavs if scenario.clearance >= LEAST_CLEARANCE else ()):
            axes = np.array(kept_ellipsoid(own, other))[[0, 0, 1]]
            if number == problem.uav and self.kinds.count(self.kinds[number]) == 1:
                continue
            if not axes.all() or (np.linalg.norm((ends - other.start) / axes, axis=1) < 1.0).any():
                continue  # from there, or to there, it must fly
            if (np.linalg.norm((places - other.start) / axes, axis=1) < 1.0).any():
                met.append(number)
        return tuple(met)

    def _without(self, homes: tuple[int, ...]) -> Airspace:
        """Return the airspace with a box about each of some UAVs' starts, in which others would come too near."""
        if homes not in self._walled:
            scenario = self.airspace.scenario
            boxes = []
            for number in homes:
                own = scenario.uavs[number]
                half = np.array(kept_ellipsoid(own, own))[[0, 0, 1]] - scenario.clearance
                half = np.maximum(half, scenario.clearance)
                boxes.append(Box(min=tuple(own.start - half), max=tuple(own.start + half)))
            self._walled[homes] = Airspace(derived(scenario, obstacles=(*scenario.obstacles, *boxes)))
        return self._walled[homes]

    @cached_property
    def kinds(self) -> list[int]:
        """The number of each UAV's kind: UAVs of one kind fly alike from place to place."""
        alike = {name: UAV.model_fields[name].default for name in _NO_MATTER} | {"start": (0.0, 0.0, 0.0)}
        kinds: dict[str, int] = {}
        told = [uav.model_copy(update=alike).model_dump_json() for uav in self.airspace.scenario.uavs]
        return [kinds.setdefault(one, len(kinds)) for one in told]
