"""The settings and schedules that `HybridMVO` shares with its engines."""

import dataclasses
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from skyverse.errors import InputError
from skyverse.model.result import Result
from skyverse.planners.base import Planner
from skyverse.planners.run import Run
from skyverse.planners.settings import require_boolean, require_integer, require_number
from skyverse.problem import Problem

R = TypeVar("R", bound=Run)


@dataclass(frozen=True, kw_only=True)
class Multiverse:
    """Universes, MVO's two schedules and the repairs; `HybridMVO` describes each setting."""

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
        require_integer(self, "universes", 2)
        require_integer(self, "straighten", 0)
        require_integer(self, "tries", 1)
        for name in ("rejoin", "segments", "wormholes"):
            require_boolean(self, name)
        require_number(self, "roam", 0, 1)
        require_number(self, "wep_min", 0, 1)
        require_number(self, "wep_max", self.wep_min, 1)
        require_number(self, "p", 1e-3, 1e3)
        if not isinstance(self.seeds, tuple) or not all(isinstance(seed, Planner) for seed in self.seeds):
            raise InputError(f"{type(self).__name__}'s seeds is a tuple of planners, not {self.seeds!r}")

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
        """Return the results of the seed planners, each of which has random numbers of its own."""
        return [seed.plan(problem, rng=rng.spawn(1)[0]) for seed in self.seeds]


def charge_seeds(run: R, seeds: list[Result]) -> R:
    """Return the run with the effort and the seconds of the seeds' results added to its own."""
    for result in seeds:
        run.workspace.spent[:] += dataclasses.astuple(result.effort)
    return dataclasses.replace(run, seeding_seconds=sum(result.seconds for result in seeds))
