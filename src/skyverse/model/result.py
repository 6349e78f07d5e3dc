"""What a planner answers: one path, how its search ended, and what it took."""

import math
from dataclasses import dataclass, fields
from enum import Enum

import numpy as np

from skyverse.errors import Remedy, Sentence
from skyverse.model.arrays import ArrayRecord, FloatArray, IntArray, PointArray, PointVector, floats, integers
from skyverse.model.quantities import Flag, Real, Whole
from skyverse.model.short_lines import SMALLEST_GAP, as_lines, counted, told_gap, told_metres, told_point, told_seconds


class Status(Enum):
    """How a search for one path ended. ``.sentence`` says what happened and what to try."""

    OPTIMAL = "optimal"
    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    NO_PATH = "no path"
    NO_PATH_EXISTS = "no path exists"
    START_SHUT_IN = "start shut in"
    START_UNSAFE = "start unsafe"
    START_OUT_OF_BOUNDS = "start out of bounds"
    TARGET_UNSAFE = "target unsafe"
    TARGET_OUT_OF_BOUNDS = "target out of bounds"
    NOT_PLANNED = "not planned"

    @property
    def reached(self) -> bool:
        """Whether the path joins start and goal."""
        return self in (Status.OPTIMAL, Status.COMPLETE)

    @property
    def sentence(self) -> str:
        """What happened, and what to try."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.OPTIMAL: "The path reaches the target; it is optimal, as claimed by the planner.",
    Status.COMPLETE: "The path reaches the target.",
    Status.INCOMPLETE: "The best path found ends short of the target; give a larger budget, or try AStar.",
    Status.NO_PATH: Sentence(
        "No path was found, which does not prove that there is none: a finer lattice may have one",
        give=[Remedy("Lattice.step", None, "for it")],
    ),
    Status.NO_PATH_EXISTS: "No path joins start and target, which is proven whatever the step of the lattice.",
    Status.START_SHUT_IN: "No move leads away from the start; try a finer step, a smaller clearance or another start.",
    Status.START_UNSAFE: "The start, or the way from it to the lattice, is too close to an obstacle; move it.",
    Status.START_OUT_OF_BOUNDS: "The start lies outside the bounds; move it or widen them.",
    Status.TARGET_UNSAFE: "The target, or the way to it from the lattice, is too close to an obstacle; move it.",
    Status.TARGET_OUT_OF_BOUNDS: "The target lies outside the bounds; move it or widen them.",
    Status.NOT_PLANNED: "The run was interrupted before this UAV's turn; plan again.",
}


@dataclass(frozen=True)
class Effort:
    """Work done, counted the same way for every planner.

    Attributes
    ----------
    generated_paths
        Calls of a path generator (one walk from one node towards another), paths decoded from waypoints, or finished
        exact searches.
    generated_nodes
        Nodes that those walks and paths visited, or states that those searches expanded.
    evaluations
        Objective values computed.
    """

    generated_paths: Whole = 0
    generated_nodes: Whole = 0
    evaluations: Whole = 0

    def __add__(self, more: "Effort") -> "Effort":
        return Effort(*(getattr(self, one.name) + getattr(more, one.name) for one in fields(self)))


@dataclass(frozen=True, eq=False)
class History(ArrayRecord):
    """The best cost so far, and the effort spent, at each improvement and at the end of each iteration: (k,) each.

    `iteration` tells in which iteration a row was taken, 0 at the start; where it is left out, each row ends one.
    """

    cost: FloatArray
    generated_paths: IntArray
    generated_nodes: IntArray
    evaluations: IntArray
    iteration: IntArray = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        if self.iteration is None:
            object.__setattr__(self, "iteration", integers(range(len(self.cost))))
        super().__post_init__()

    def by_iteration(self) -> "History":
        """Return the rows that end the start and each iteration."""
        last = np.flatnonzero(np.append(self.iteration[1:] != self.iteration[:-1], [True] * (len(self.cost) > 0)))
        return History(*(column[last] for column in vars(self).values()))

    def __repr__(self) -> str:
        if not len(self.cost):
            return "History: empty, as the planner went straight to its answer"
        first, last = self.cost[0], self.cost[-1]
        return (
            f"History: {counted(int(self.iteration[-1]), 'iteration')}, best cost {first:,.6g} at first and "
            f"{last:,.6g} at last, after {counted(int(self.generated_paths[-1]), 'generated path')}"
        )


def no_history() -> History:
    """Return the history of a run without iterations."""
    none = integers([])
    return History(floats([]), none, none, none)


@dataclass(frozen=True)
class Provenance:
    """What made an answer, so that it can be made again.

    Attributes
    ----------
    skyverse, platform
        The version of skyverse, and the machine with the versions of Python and numpy.
    planner, stop
        The planner with its settings, and the stop rule; ``"None"`` for a planner that ends by itself.
    seed
        The seed of its random numbers; ``None`` where it draws none, or draws them from the caller's generator.
    """

    skyverse: str
    planner: str
    stop: str
    seed: Whole | None
    platform: str

    @property
    def planner_and_seed(self) -> str:
        """The name of the planner and, where it has one, its seed."""
        name = self.planner.partition("(")[0]
        return name if self.seed is None else f"{name}, seed {self.seed}"


NO_STOP = "None"
"""`Provenance.stop` of a planner that ends by itself, and draws no random numbers."""
CANCELLED = "Cancelled"
"""`Result.stopped_by` of a run that a `Cancelled` rule ended."""


@dataclass(frozen=True, eq=False)
class Result(ArrayRecord):
    """One path, and what is known about it.

    Attributes
    ----------
    status
        How the search ended; ``status.reached`` says whether the path joins start and goal.
    path
        (n, 3) float64 metres, beginning at `start`; empty where no path was begun.
    cost
        In the objective's unit; infinite where there is no path.
    terms
        ``fuel``, ``divergence`` and ``end``: their weighted shares, which add up to `cost`.
    bound
        A cost that no complete path on the same lattice can beat (the exact optimum), or, for an any-angle path, that
        no path at all can beat (a proven lower bound); ``None`` where it is not known.
    start, goal
        (3,) metres: the lattice nodes that the path had to join, or the UAV's start and its target where the path
        leaves the lattice or there is no path.
    effort, seconds, history
        The work done; `seconds` are wall-clock seconds of the search alone, without any compilation.
    stopped_by
        What ended the run: the name of a stop rule, or ``"finished"``.
    any_angle
        Whether the path leaves the lattice, and consists of straight legs from the UAV's start to its target. Such a
        path has no nodes to count, so that its fuel is in metres whatever the objective's unit.
    straight_bound
        Whether `bound` is the cost of the straight line from start to goal, which tells nothing of what is in its way.
        The line joins the places where a UAV leaves and enters its pads, where it has any.
    objective
        The objective of one's own by which `cost`, `terms`, `bound` and `history` are meant; empty: the scenario's.
    """

    status: Status
    path: PointArray
    cost: Real
    terms: dict[str, Real]
    bound: Real | None
    start: PointVector
    goal: PointVector
    effort: Effort
    seconds: Real
    history: History
    stopped_by: str
    provenance: Provenance
    any_angle: Flag = False
    straight_bound: Flag = False
    objective: str = ""

    def __repr__(self) -> str:
        if not len(self.path):
            return as_lines(f"Result: {self.status.value}", self.status.sentence)
        gap = self.gap_sentence
        cost = told_metres(self.cost) if self.any_angle else f"{self.cost:,.6g}"
        return as_lines(
            f"Result: {self.status.value}, cost {cost}{f', {gap}' if gap else ''}",
            f"path of {counted(len(self.path), 'point')}, {told_metres(self.length)}, "
            f"from {told_point(self.path[0])} to {told_point(self.path[-1])}",
            "" if self.status.reached else self.status.sentence,
            f"by {self.provenance.planner_and_seed}: {counted(self.effort.generated_paths, 'generated path')} "
            f"in {told_seconds(self.seconds)}",
        )

    @property
    def gap(self) -> float | None:
        """``cost / bound - 1`` of a complete path whose bound is known, and otherwise ``None``.

        It is infinite where a path costs something and its bound is no more than 0.
        """
        if self.bound is None or not self.status.reached:
            return None
        if self.bound > 0:
            return self.cost / self.bound - 1.0
        return 0.0 if self.cost <= self.bound else math.inf

    @property
    def length(self) -> float:
        """The length of the path, metres; 0 where there is none."""
        return float(np.linalg.norm(np.diff(self.path, axis=0), axis=1).sum())

    @property
    def gap_sentence(self) -> str:
        """How far the cost is above the best possible, as in ``at most 2 % above the best possible``; may be empty."""
        if self.gap is None or not math.isfinite(self.gap):
            return ""
        if self.gap < -SMALLEST_GAP:
            return f"{told_gap(-self.gap)} below its bound, which is impossible"
        if self.gap <= SMALLEST_GAP:
            return f"no path {'' if self.any_angle else 'on the lattice '}costs less"
        if self.straight_bound:
            return f"at most {told_gap(self.gap)} above the straight line, which no path beats"
        return f"at most {told_gap(self.gap)} above the best possible{'' if self.any_angle else ' on the lattice'}"

    @property
    def cancelled(self) -> bool:
        """Whether a `Cancelled` rule ended the run."""
        return self.stopped_by == CANCELLED
