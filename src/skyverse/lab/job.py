"""One run of a study that is to be made: what is given, and by what it is recognised."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from skyverse.lab.code_versions import code_digest, digest, settings_of
from skyverse.live.policies.policy import Policy
from skyverse.mission.assignment import Assignment
from skyverse.model.conditions import Sensor
from skyverse.model.quantities import Model, derived
from skyverse.model.scenario import Scenario
from skyverse.planners.base import Planner
from skyverse.planners.objective import PathObjective
from skyverse.samples.movers import MoverKind, random_movers
from skyverse.stop import MaxIterations, Stop


@dataclass(frozen=True, kw_only=True)
class OwnReplanner:
    """The `Replanner` as it is, with how many motions it tries for a UAV at most at each observation."""

    candidates: int = 128

    def __post_init__(self) -> None:
        if isinstance(self.candidates, bool) or not isinstance(self.candidates, int) or self.candidates < 1:
            raise ValueError(f"candidates is a whole number from 1 on, not {self.candidates!r}")


@dataclass(frozen=True, kw_only=True)
class KnownBeforehand:
    """No replanning: the mission is planned among all movers and obstacles, which are known beforehand."""


Contender = Planner | Policy | OwnReplanner | KnownBeforehand


class Encounters(Model, strict=True, allow_inf_nan=False):
    """What is met in flight: random movers, which the seed makes, and obstacles that nobody knows of beforehand.

    Attributes
    ----------
    kind, count, speed
        Those of `random_movers`.
    hidden
        How many of the scenario's obstacles are not known beforehand; the seed draws which.
    label
        By default the other fields in words.
    """

    label: str = ""
    kind: MoverKind = "spinners"
    count: Annotated[int, Field(ge=0)] = 10
    speed: Annotated[float, Field(ge=1e-3, le=1e3, strict=False)] = 1.0
    hidden: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _labelled(self) -> Self:
        walls = f", {self.hidden} hidden" if self.hidden else ""
        told = f"{self.count} {self.kind} at {self.speed:g} m/s{walls}"
        return self if self.label else derived(self, label=told)

    def truth(self, scenario: Scenario, seed: int) -> Scenario:
        """Return the scenario with all that there is."""
        return random_movers(scenario, self.count, kind=self.kind, speed=self.speed, seed=seed)

    def known(self, scenario: Scenario, seed: int) -> Scenario:
        """Return the scenario with what is known beforehand; its own movers are not."""
        obstacles = scenario.obstacles
        hidden = np.random.default_rng([seed, 1]).permutation(len(obstacles))[: self.hidden].tolist()
        return derived(scenario, obstacles=tuple(o for k, o in enumerate(obstacles) if k not in hidden), movers=())


USUAL_SENSOR = Sensor(range=8.0)


@dataclass(frozen=True, eq=False)
class Case:
    """A scenario, its label, the assignment of its targets, and for flights among movers what is met in them.

    Cases with the same content are equal. UAVs see with the `sensor`, and a flight is given up after the `longest`
    time, in seconds.
    """

    label: str
    scenario: Scenario
    assignment: Assignment = "path-cost"
    encounters: Encounters | None = None
    sensor: Sensor = USUAL_SENSOR
    longest: float = 60.0

    @cached_property
    def digest(self) -> str:
        """A digest of all but the label."""
        met = self.encounters and repr((self.encounters, self.sensor, self.longest))
        return digest(self.scenario.digest, self.assignment, met)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, Case) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)


@dataclass(frozen=True, eq=False)
class Job:
    """One run to be made; it is sent to other processes as it is.

    Attributes
    ----------
    case
        The scenario; jobs on the same scenario should share one case.
    planner, label
        The planner, or in a flight what replans, and its label in the study.
    stop, budget
        The rule that ends each UAV's search, and its label; ``None`` for a flight. `MaxSeconds` alone is
        turned into paths by a pilot run.
    seed
        The search of a single UAV gets ``rng=seed``; those of several get a random stream each, as in
        `plan_mission`. For a flight it makes the movers, and the random numbers of sensor and policy.
    objective
        An objective of one's own by which the results of all planners are priced.
    """

    case: Case
    planner: Contender
    label: str
    stop: Stop | None
    budget: str
    seed: int
    objective: PathObjective | None = None

    @property
    def run(self) -> tuple[str, str, str, int]:
        """The labels of scenario, planner and budget, and the seed, which identify the run in its study."""
        return self.case.label, self.label, self.budget, self.seed

    @property
    def made_by(self) -> tuple[Contender, PathObjective | None]:
        """What makes the run."""
        return self.planner, self.objective

    @cached_property
    def code(self) -> str:
        """The digest of the code that makes the run, in the process that asks for it."""
        return code_digest(self.made_by)

    @cached_property
    def key(self) -> str:
        """A digest of the labels and of all that determines the answer, including the code."""
        return digest(*self.run, self.case.digest, settings_of(self.made_by), repr(self.stop), self.code)

    def shortened(self) -> "Job":
        """Return a run that is as short as it can be and needs the same kernels."""
        if self.case.encounters is None:
            return replace(self, stop=MaxIterations(1))
        return replace(self, case=replace(self.case, longest=0.5))

    def __str__(self) -> str:
        return "{}, {}, {}, seed {}".format(*self.run)
