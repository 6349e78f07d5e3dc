"""When a run ends: stateless rules over counted progress; ``a | b`` ends a run at whichever rule is met first."""

import math
import threading
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Protocol, TypeGuard

from skyverse.errors import InputError, is_number, require_kind, shown
from skyverse.model.result import CANCELLED


@dataclass(frozen=True)
class Progress:
    """What a run has done so far.

    Attributes
    ----------
    iterations, generated_paths, generated_nodes, evaluations
        How many there have been.
    seconds
        Wall-clock seconds since the run began.
    cost
        The lowest cost so far.
    """

    iterations: int = 0
    generated_paths: int = 0
    generated_nodes: int = 0
    evaluations: int = 0
    seconds: float = 0.0
    cost: float = math.inf


class Stop(ABC):
    """A rule that ends a run.

    A counted rule also tells which share of its budget is spent, because schedules (WEP, TDR) follow that share. A
    clock or an event may end a run but never steers it, so that a seed gives the same answer on every machine.
    """

    @abstractmethod
    def met(self, progress: Progress) -> str | None:
        """Return the name of the rule that ends the run here, or ``None``."""

    @property
    def cancelled(self) -> bool:
        """Whether somebody has cancelled the run; only `Cancelled` can tell."""
        return False

    def spent(self, progress: Progress) -> float | None:
        """Return the share of the counted budget that is spent, or ``None`` where nothing is counted."""
        return None

    def limit(self, counter: str) -> float:
        """Return the most that `counter`, a field of `Progress`, may reach."""
        return math.inf

    def __or__(self, other: "Stop") -> "Stop":
        return Either(self, other)


def require_stop(stop: object) -> None:
    """Raise `InputError` for what is neither a rule that ends a run nor ``None``."""
    if stop is not None and not isinstance(stop, Stop):
        said = f"expected a rule, such as MaxIterations(40) or MaxSeconds(1), found {shown(stop)}"
        raise InputError(said, field="stop")


def is_cancelled(stop: Stop | None) -> bool:
    """Tell whether somebody has cancelled a run, if there is a rule that can tell."""
    return stop is not None and stop.cancelled


@dataclass(frozen=True)
class Either(Stop):
    """Ends a run at whichever of two rules is met first."""

    first: Stop
    second: Stop

    def __post_init__(self) -> None:
        for rule in (self.first, self.second):
            require_kind(rule, Stop, "stop")

    def met(self, progress: Progress) -> str | None:
        """Return the name of the rule that ends the run here, the first's if both do, or ``None``."""
        return self.first.met(progress) or self.second.met(progress)

    @property
    def cancelled(self) -> bool:
        """Whether one of the two rules has been cancelled."""
        return self.first.cancelled or self.second.cancelled

    def spent(self, progress: Progress) -> float | None:
        """Return the larger share."""
        shares = [s for s in (self.first.spent(progress), self.second.spent(progress)) if s is not None]
        return max(shares, default=None)

    def limit(self, counter: str) -> float:
        """Return the smaller limit."""
        return min(self.first.limit(counter), self.second.limit(counter))

    def __repr__(self) -> str:
        return f"{self.first!r} | {self.second!r}"


@dataclass(frozen=True, repr=False)
class _Counted(Stop):
    most: int
    _counter: ClassVar[str] = ""

    def __post_init__(self) -> None:
        if not _counts(self.most):
            raise InputError(f"{type(self).__name__} takes a whole number from 1 on, not {self.most!r}")
        object.__setattr__(self, "most", int(self.most))

    def met(self, progress: Progress) -> str | None:
        """Return the rule's name once the counter has reached its limit."""
        return type(self).__name__ if getattr(progress, self._counter) >= self.most else None

    def spent(self, progress: Progress) -> float | None:
        """Return the counter's share of its limit, at most 1."""
        return min(1.0, float(getattr(progress, self._counter)) / self.most)

    def limit(self, counter: str) -> float:
        """Return the rule's own limit for its own counter."""
        return self.most if counter == self._counter else math.inf

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.most})"


class MaxIterations(_Counted):
    """End after so many iterations."""

    _counter: ClassVar[str] = "iterations"


class MaxPaths(_Counted):
    """End after so many generated paths; the fairest budget between metaheuristics.

    A path decoded from waypoints is one generated path. A candidate on lattice paths may take several; budgets are
    looked at between candidates, so that the last one may take a few paths more than there were left.
    """

    _counter: ClassVar[str] = "generated_paths"


class MaxNodes(_Counted):
    """End once so many nodes have been generated; the walk that reaches the limit is finished."""

    _counter: ClassVar[str] = "generated_nodes"


class MaxEvaluations(_Counted):
    """End after so many evaluations of the objective."""

    _counter: ClassVar[str] = "evaluations"


def _counts(value: object) -> bool:
    return _is_number(value) and value >= 1 and value % 1 == 0


def _is_number(value: object) -> TypeGuard[float]:
    return is_number(value) or (isinstance(value, float) and math.isinf(value))


@dataclass(frozen=True)
class MaxSeconds(Stop):
    """End after so many seconds of wall clock, at the end of an iteration."""

    seconds: float

    def __post_init__(self) -> None:
        if not _is_number(self.seconds) or not self.seconds > 0:
            raise InputError(f"MaxSeconds takes a number above 0, not {self.seconds!r}")

    def met(self, progress: Progress) -> str | None:
        """Return the rule's name once the time is up."""
        return "MaxSeconds" if progress.seconds >= self.seconds else None

    def __repr__(self) -> str:
        return f"MaxSeconds({self.seconds:g})"


@dataclass(frozen=True)
class TargetCost(Stop):
    """End as soon as the best cost is at most `cost`."""

    cost: float

    def __post_init__(self) -> None:
        if not _is_number(self.cost):
            raise InputError(f"TargetCost takes a number, not {self.cost!r}")

    def met(self, progress: Progress) -> str | None:
        """Return the rule's name once the cost is reached."""
        return "TargetCost" if progress.cost <= self.cost else None

    def __repr__(self) -> str:
        return f"TargetCost({self.cost:g})"


@dataclass(frozen=True)
class Cancelled(Stop):
    """End as soon as somebody sets the event (a key, a signal, another thread)."""

    event: threading.Event

    def met(self, progress: Progress) -> str | None:
        """Return the rule's name once the event is set."""
        return CANCELLED if self.event.is_set() else None

    @property
    def cancelled(self) -> bool:
        """Whether the event is set."""
        return self.event.is_set()

    def __repr__(self) -> str:
        return "Cancelled()"


class OnIteration(Protocol):
    """A function that is called after every iteration, for progress bars and live pictures."""

    def __call__(self, progress: Progress, /) -> None:
        """Take note of the progress."""
