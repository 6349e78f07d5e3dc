"""A best-first search for what one UAV flies from now on: of the motions that are proven, the one that arrives first.

Steps are taken in the order of when they could arrive at best. A step makes a motion, and pushes the step that examines
it by when it would arrive; or it examines one. A kind of vehicle says which steps there are, and what proves a motion.
"""

import heapq
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from itertools import count
from typing import Generic, NamedTuple, Protocol, TypeVar

from skyverse.live.course import AnyCourse
from skyverse.live.surroundings import FirstContact, Surroundings

LOOKED_AT = 0.5
"""The share of the horizon after which motions are compared by what they still have to fly."""
KEEP_ON = 0.05
"""Seconds by which another way must arrive earlier than the present one, so that a UAV does not waver."""
BLOCKED = 10.0
"""Seconds that it may take longer to arrive along a way in which something stands."""


class Choice(NamedTuple):
    """What is known of the motion that was chosen.

    Attributes
    ----------
    kept, proven
        Whether it is what was flown before, and whether it is proven up to the horizon.
    contact
        What it comes too near to first, up to the horizon.
    tried
        How many motions were made.
    held_up
        Whether another UAV is in the way of the motion that would arrive first.
    """

    kept: bool
    proven: bool
    contact: FirstContact
    tried: int
    held_up: bool = False


class Flyable(Protocol):
    """A motion that may be flown."""

    @property
    def kept(self) -> bool:
        """Whether the present course goes on."""


C = TypeVar("C", bound=AnyCourse)
F = TypeVar("F", bound=Flyable)
Step = Callable[[], tuple[C, Choice] | None]
"""Returns what is flown, and what is known of it, if it has found that."""


class Search(ABC, Generic[C, F]):
    """One search for one UAV, over courses C and motions F that may be flown next."""

    def __init__(self, around: Surroundings) -> None:
        self.around, self.span = around, around.span
        self.queue: list[tuple[float, int, Step[C]]] = []
        self.numbers = count()
        self.met: list[tuple[FirstContact, F]] = []
        self.tried = 0
        self.looked_at = self.span.now + LOOKED_AT * (self.span.until - self.span.now)

    @abstractmethod
    def first(self) -> Iterator[Step[C]]:
        """Yield the steps that are taken before all others."""

    @abstractmethod
    def fill(self) -> None:
        """Push the steps that are taken in the order of when they could arrive."""

    @abstractmethod
    def last(self) -> Iterator[Step[C]]:
        """Yield the steps that are taken in the end, whatever the effort."""

    @abstractmethod
    def flown(self, found: F) -> C:
        """Return the course of a motion."""

    @abstractmethod
    def clear(self, found: F) -> bool:
        """Tell whether all that is flown from now on is clear of what stands still, and slow enough there."""

    def first_meeting(self, found: F, contact: FirstContact) -> FirstContact:
        """Return what an unproven motion meets first, of movers and of what stands still."""
        return contact

    def nearest_to_clear(self, ranked: list[tuple[FirstContact, F]]) -> tuple[FirstContact, F]:
        """Return the best of motions none of which is clear of what stands still."""
        return ranked[0]

    def push(self, arrival: float, step: Step[C]) -> None:
        """Let a step be taken when it is its turn."""
        heapq.heappush(self.queue, (arrival, next(self.numbers), step))

    def pop(self) -> Step[C]:
        """Return the step whose turn it is."""
        return heapq.heappop(self.queue)[-1]

    @property
    def spent(self) -> bool:
        """Whether no more motions may be made."""
        return self.tried >= self.around.motions or time.perf_counter() >= self.around.deadline

    def steps(self) -> Iterator[Step[C]]:
        """Yield all steps, as far as the budget lasts."""
        for step in self.first():
            if self.spent:
                break
            yield step
        if not self.spent:
            self.fill()
        while self.queue and not self.spent:
            yield self.pop()
        yield from self.last()

    def choose(self) -> tuple[C, Choice]:
        """Return what is flown from now on, and what is known of it."""
        for step in self.steps():
            outcome = step()
            if outcome is not None:
                return outcome
        return self.least_bad()

    def outcome(self, found: F, proven: bool = True, contact: FirstContact | None = None) -> tuple[C, Choice]:
        """Return the course of a motion, and what is known of it."""
        held_up = bool(self.met) and self.met[0][0].mover >= self.around.uavs
        return self.flown(found), Choice(found.kept, proven, contact or FirstContact(), self.tried, held_up)

    def unproven(self, found: F, contact: FirstContact) -> tuple[C, Choice]:
        """Return the same of a motion that is not proven."""
        return self.outcome(found, False, self.first_meeting(found, contact))

    def least_bad(self) -> tuple[C, Choice]:
        """Return the course that is clear of most of what movers may do from when it can begin, and for longest.

        One that is not clear of what stands still is flown only if there is no other.
        """
        ranked = sorted(self.met, key=lambda met: self.around.danger(self.flown(met[1]).motion))
        best = next((met for met in ranked if self.clear(met[1])), None)
        contact, found = self.nearest_to_clear(ranked) if best is None else best
        return self.unproven(found, contact)
