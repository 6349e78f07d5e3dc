"""What the tests of the laboratory share; importable in spawned processes, too."""

import os
import signal
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import skyverse as sky
from skyverse.lab import Case, Job, Row
from skyverse.planners.base import Planner, provenance
from skyverse.planners.results import SearchRecord, lattice_result

ROOM = sky.Scenario(
    name="room",
    bounds=sky.Bounds(min=(0, 0, 0), max=(4, 4, 4)),
    clearance=0.1,
    lattice=sky.Lattice(step=(1, 1, 1)),
    uavs=(sky.UAV(start=(0, 0, 0)),),
    targets=(sky.Target(position=(4, 4, 4)),),
)


HISTORY = sky.History(
    np.array([900.0, 300.0, 270.0]), *np.array([[1, 500, 1000], [100, 45_000, 90_000], [2, 550, 1100]])
)
ROW = Row(
    *("map1", "mvo", "1000 paths", 0, "complete", True),
    *(270.0, 270.0, 0.0, 0.0, 265.0, 270 / 265 - 1),
    *(1000, 90_000, 1100, 40, 0.02, "MaxPaths", "", "MVO()", "skyverse 0.1.0", HISTORY),
)
"""One run on Map 1: its labels, status, costs, bound, effort, and what the referee says."""


def job(planner=None, seed=0, label="planner", scenario=ROOM, stop=None, budget="30 paths", case="room"):
    planner = sky.MVO(universes=5) if planner is None else planner
    return Job(Case(case, scenario), planner, label, stop or sky.MaxPaths(30), budget, seed)


def timeless(rows):
    """Return rows without what differs from run to run."""
    return [replace(row, seconds=0.0) for row in rows]


@dataclass(frozen=True, kw_only=True)
class Instant(Planner):
    """Knows the answer, and has a long history."""

    length: int = 2000

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        route = problem.route
        effort = np.arange(self.length) + 1
        history = sky.History(np.full(self.length, route.price), effort, effort, effort)
        counted = sky.Effort(self.length, self.length, self.length)
        record = SearchRecord(provenance(repr(self), stop, None), counted, 0.0, history)
        return lattice_result(problem, route.nodes, record)


@dataclass(frozen=True, kw_only=True)
class Deadly(Planner):
    """Kills its process where the file that it is given is not there; `once` makes the file before."""

    file: str
    once: bool

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        if not Path(self.file).exists() and rng == 1:
            if self.once:
                Path(self.file).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return Instant(length=2).plan(problem)


@dataclass(frozen=True, kw_only=True)
class Liar(Planner):
    """Claims a cost that its path does not have."""

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        honest = Instant(length=1).plan(problem)
        return replace(honest, cost=honest.cost - 1)
