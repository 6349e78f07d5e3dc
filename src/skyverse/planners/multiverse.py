"""The settings of a hybrid multiverse, and its schedules: what HybridMVO and its engine share."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from skyverse.model.result import Result
from skyverse.planners.base import Planner, Run, require, require_between
from skyverse.problem import Problem


@dataclass(frozen=True, kw_only=True)
class Multiverse:
    """Universes, MVO's two schedules, and the repairs; see `HybridMVO`, which says what each of them is."""

    universes: int = 25
    straighten: int = 5
    tries: int = 4
    rejoin: bool = True
    segments: bool = True
    wormholes: bool = True
    roam: float = 0.2
    wep_min: float = 0.2
    wep_max: float = 1.0
    p: float = 6.0
    seeds: tuple[Planner, ...] = ()

    def __post_init__(self) -> None:
        require(self, "universes", 2)
        require(self, "straighten", 0)
        require(self, "tries", 1)
        for name in ("rejoin", "segments", "wormholes"):
            value = getattr(self, name)
            if not isinstance(value, bool):
                raise ValueError(f"{type(self).__name__}'s {name} is True or False, not {value!r}")
        require_between(self, "roam", 0, 1)
        require_between(self, "wep_min", 0, 1)
        require_between(self, "wep_max", self.wep_min, 1)
        require_between(self, "p", 1e-3, 1e3)
        if not isinstance(self.seeds, tuple) or not all(isinstance(seed, Planner) for seed in self.seeds):
            raise ValueError(f"{type(self).__name__}'s seeds is a tuple of planners, not {self.seeds!r}")

    @property
    def population(self) -> int:
        """How many universes there are."""
        return self.universes

    def wep(self, spent: float) -> float:
        """Return the wormhole existence probability when a share of the budget is spent (equation 3.8)."""
        return self.wep_min + spent * (self.wep_max - self.wep_min)

    def tdr(self, spent: float) -> float:
        """Return the travelling distance rate when a share of the budget is spent (equation 3.9)."""
        return 1.0 - float(spent ** (1.0 / self.p))

    def plan_seeds(self, problem: Problem, rng: np.random.Generator) -> list[Result]:
        """Let each seed plan, with random numbers of its own."""
        return [seed.plan(problem, rng=rng.spawn(1)[0]) for seed in self.seeds]


def charge(run: Run, seeds: list[Result]) -> Run:
    """Return the run with the seeds' effort spent; it remembers their seconds."""
    for result in seeds:
        run.desk.spent[:] += dataclasses.astuple(result.effort)
    return dataclasses.replace(run, memory=sum(result.seconds for result in seeds))
