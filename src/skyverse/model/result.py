"""What is answered: results, trajectories, missions, violations. Plain frozen data; arrays are read-only."""

from dataclasses import dataclass, field, fields, replace
from enum import Enum
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, PlainSerializer, PlainValidator

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Certificate, Deconfliction, Violation


def _floats(value: object) -> Floats:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError("expected numbers in rows of equal length") from None
    array.flags.writeable = False
    return array


def _points(value: object) -> Floats:
    array = _floats(value)
    if array.size == 0:
        return _floats(array.reshape(0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"expected rows of x, y, z, found an array of shape {array.shape}")
    return array


def _point(value: object) -> Floats:
    array = _floats(value)
    if array.shape != (3,):
        raise ValueError(f"expected x, y, z, found an array of shape {array.shape}")
    return array


def _integers(value: object) -> NDArray[np.int64]:
    try:
        array = np.array(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError("expected whole numbers") from None
    if array.size and array.dtype.kind not in "iu":
        raise ValueError("expected whole numbers")
    array = array.astype(np.int64)
    array.flags.writeable = False
    return array


_listed = PlainSerializer(lambda array: array.tolist(), when_used="json")
FloatArray = Annotated[NDArray[np.float64], PlainValidator(_floats), _listed]
PointArray = Annotated[NDArray[np.float64], PlainValidator(_points), _listed]
PointVector = Annotated[NDArray[np.float64], PlainValidator(_point), _listed]
IntArray = Annotated[NDArray[np.int64], PlainValidator(_integers), _listed]


class _Record:
    """Equality field by field, arrays element by element; the codec refuses unknown keys."""

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                frozen = value.copy()
                frozen.flags.writeable = False
                object.__setattr__(self, name, frozen)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()  # a pickle forgets that arrays are read-only

    __pydantic_config__ = ConfigDict(extra="forbid", ser_json_inf_nan="strings")

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(getattr(self, f.name), getattr(other, f.name)) for f in fields(self))  # type: ignore[arg-type]

    __hash__ = None  # type: ignore[assignment]


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    return bool(a == b)


class Status(Enum):
    """How a search for one path ended. ``.sentence`` says what happened and what to try."""

    OPTIMAL = "optimal"
    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    NO_PATH = "no path"
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
    Status.OPTIMAL: "The path reaches the target, and none is cheaper.",
    Status.COMPLETE: "The path reaches the target.",
    Status.INCOMPLETE: "The best path found ends short of the target; give a larger budget, or try AStar.",
    Status.NO_PATH: "No path joins start and target; try a smaller clearance, or a finer step of the lattice.",
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

    generated_paths: int = 0
    generated_nodes: int = 0
    evaluations: int = 0


@dataclass(frozen=True, eq=False)
class History(_Record):
    """The best cost so far, and the effort spent, after the start (row 0) and after each iteration: (k,) each."""

    cost: FloatArray
    generated_paths: IntArray
    generated_nodes: IntArray
    evaluations: IntArray


def no_history() -> History:
    """Return the history of a run without iterations."""
    none = _integers([])
    return History(_floats([]), none, none, none)


@dataclass(frozen=True)
class Provenance:
    """What made an answer: enough to make it again."""

    skyverse: str
    planner: str
    stop: str
    seed: int | None
    platform: str


@dataclass(frozen=True, eq=False)
class Result(_Record):
    """One path, and what is known of it.

    Attributes
    ----------
    status
        How it ended; ``status.reached`` says whether the path joins start and goal.
    path
        (n, 3) float64 metres, from `start` on; empty where no path was begun.
    cost
        In the objective's unit; infinite where there is no path.
    terms
        ``fuel``, ``divergence`` and ``end``: their weighted shares, which add up to `cost`.
    bound
        What every complete path on the same lattice costs at least (the exact optimum), or, of an any-angle path, what
        every path at all does (a proven lower bound); ``None`` where unknown.
    start, goal
        (3,) metres: the lattice nodes that the path was to join; the UAV's start and its target where the path leaves
        the lattice, or there is none.
    effort, seconds, history
        What it took; `seconds` are wall-clock seconds of the search alone, without any compilation.
    stopped_by
        What ended the run: a stop rule's name, or ``"finished"``.
    any_angle
        Whether the path leaves the lattice: straight legs from the UAV's start to its target. It has no nodes to
        count, so its fuel is in metres whatever the objective's unit.
    """

    status: Status
    path: PointArray
    cost: float
    terms: dict[str, float]
    bound: float | None
    start: PointVector
    goal: PointVector
    effort: Effort
    seconds: float
    history: History
    stopped_by: str
    provenance: Provenance
    any_angle: bool = False

    @property
    def gap(self) -> float | None:
        """``cost / bound - 1`` of a complete path whose bound is known, otherwise ``None``."""
        if self.bound is None or not self.status.reached:
            return None
        return self.cost / self.bound - 1.0 if self.bound > 0 else 0.0


Form = Literal["smooth", "slowed", "straightened", "stop-and-go", "dubins"]


class Motion(NamedTuple):
    """Position (m), velocity (m/s) and acceleration (m/s^2) at some instants, (m, 3) each."""

    position: Floats
    velocity: Floats
    acceleration: Floats


@dataclass(frozen=True, eq=False)
class Trajectory(_Record):
    """Position, velocity and acceleration as functions of time: polynomial pieces between knots.

    Attributes
    ----------
    knots
        (n + 1,) seconds, rising.
    coefficients
        (n, degree + 1, 3) metres; piece k is the sum over j of ``coefficients[k, j] * (t - knots[k])**j``.
    form
        How it flies: ``"smooth"``; ``"slowed"`` or ``"straightened"``, smooth too, but not as first wished;
        ``"stop-and-go"``, at rest at every waypoint; ``"dubins"`` for an aeroplane.
    note
        One sentence that says why it is not what was wished for; empty when it is.
    """

    knots: FloatArray
    coefficients: FloatArray
    form: Form = "stop-and-go"
    note: str = ""

    @property
    def start(self) -> float:
        """The first instant, seconds."""
        return float(self.knots[0])

    @property
    def end(self) -> float:
        """The last instant, seconds."""
        return float(self.knots[-1])

    def retimed(self, start: float, factor: float = 1.0) -> "Trajectory":
        """Return the same flight from the instant `start` on, in `factor` times the time; `form` tells if slowed."""
        if start == self.start and factor == 1.0:
            return self
        powers = factor ** np.arange(self.coefficients.shape[1], dtype=np.float64)
        return replace(
            self,
            knots=start + (self.knots - self.start) * factor,
            coefficients=self.coefficients / powers[:, None],
            form="slowed" if factor > 1.0 and self.form == "smooth" else self.form,
        )

    def at(self, t: ArrayLike) -> Motion:
        """Evaluate at the instants `t`, (m,) seconds; before `start` and after `end` the UAV holds its place."""
        instants = np.atleast_1d(np.asarray(t, dtype=np.float64))
        clipped = np.clip(instants, self.start, self.end)
        piece = np.clip(np.searchsorted(self.knots, clipped, side="right") - 1, 0, len(self.coefficients) - 1)
        local = (clipped - self.knots[piece])[:, None]
        rows = self.coefficients[piece]
        motion = []
        for _ in range(3):
            value = np.zeros((len(clipped), 3))
            for j in range(rows.shape[1] - 1, -1, -1):
                value = value * local + rows[:, j]
            motion.append(value)
            powers = np.arange(rows.shape[1], dtype=np.float64)
            rows = (rows * powers[None, :, None])[:, 1:] if rows.shape[1] > 1 else np.zeros_like(rows)
        holding = (instants < self.start) | (instants > self.end)
        motion[1][holding] = 0.0
        motion[2][holding] = 0.0
        return Motion(*motion)


@dataclass(frozen=True, eq=False)
class Mission(_Record):
    """The fleet's answer. It embeds its scenario, so that one file serves every later verb.

    Attributes
    ----------
    assignment
        For each UAV the index of its target, or ``None``.
    results, trajectories
        In the scenario's order of UAVs; ``None`` where there is none.
    violations
        The referee's verdict; empty when nothing was found wrong.
    interrupted
        Whether the run was cut short; what was found until then is kept.
    certificates
        What the referee says of each UAV's trajectory, in the scenario's order; empty when it was not asked.
    apart
        What it says of the fleet's separation; ``None`` when it was not asked.
    deconfliction
        How conflicts between trajectories were resolved; ``None`` when that was not tried.
    """

    scenario: Scenario
    assignment: tuple[int | None, ...]
    results: tuple[Result | None, ...]
    trajectories: tuple[Trajectory | None, ...]
    violations: tuple[Violation, ...]
    provenance: Provenance
    interrupted: bool = False
    certificates: tuple[Certificate | None, ...] = ()
    apart: Certificate | None = None
    deconfliction: Deconfliction | None = None
    format: str = field(default="skyverse/mission/1")

    @property
    def cost(self) -> float:
        """The sum of the results' costs, in the objective's unit.

        A detour that keeps UAVs apart is priced in metres: where the others' paths count nodes, the sum means nothing.
        """
        return sum(result.cost for result in self.results if result is not None)

    @property
    def makespan(self) -> float:
        """Seconds until the last UAV has arrived."""
        return max((trajectory.end for trajectory in self.trajectories if trajectory is not None), default=0.0)

    @property
    def total_time(self) -> float:
        """The sum of the UAVs' arrival times, seconds into the mission."""
        return sum(trajectory.end for trajectory in self.trajectories if trajectory is not None)

    @property
    def complete(self) -> bool:
        """Whether as many UAVs as can have a target, and each has a path to it and a trajectory along it."""
        pairs = min(len(self.scenario.uavs), len(self.scenario.targets))
        assigned = sum(target is not None for target in self.assignment)
        return (
            not self.interrupted
            and assigned == pairs
            and all(
                target is None or (result is not None and result.status.reached and trajectory is not None)
                for target, result, trajectory in zip(self.assignment, self.results, self.trajectories, strict=True)
            )
        )
