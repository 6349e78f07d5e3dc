"""What a replanning policy is: frozen settings with one verb, which finds a way to the target anew.

Standing still until the way is free.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.live.guidance import Way
from skyverse.model.result import Effort
from skyverse.model.scenario import Scenario
from skyverse.space.timed_shapes import TimedShape
from skyverse.space.world import World


class Situation(NamedTuple):
    """What is known of one UAV's flight at an observation.

    Attributes
    ----------
    scenario
        What stands still, as far as it has been seen, without movers.
    uav, target
        The UAV's index, and that of its target.
    world
        What stands still, for the nominal position of this UAV.
    now, join, until
        The instants of the observation, at which another motion can begin, and up to which motions are proven; seconds
        into the mission.
    state
        (3, 3) position, velocity and acceleration at `join`.
    stop
        (3,) metres: where the UAV comes to rest if it brakes from there.
    movers
        The movers that were seen, and the motions of the other UAVs, with all that they may do.
    guidance
        What is still ahead of the way that the UAV would fly if nothing moved.
    memory
        What this policy's last answer for this UAV asked to be kept; ``None`` at first.
    rng
        The source of all random numbers.
    """

    scenario: Scenario
    uav: int
    target: int
    world: World
    now: float
    join: float
    until: float
    state: Floats
    stop: Floats
    movers: tuple[TimedShape, ...]
    guidance: Way
    memory: object
    rng: np.random.Generator


class Found(NamedTuple):
    """What a policy answers.

    Attributes
    ----------
    way
        The points to fly through, from where the UAV is; ``None`` if none was found.
    effort
        What the search took.
    memory
        What the policy wants to be told next time.
    share
        The share of the UAV's largest speed at which the way is flown at most.
    """

    way: Way | None
    effort: Effort
    memory: object = None
    share: float = 1.0


NO_EFFORT = Effort(0, 0, 0)
"""The effort of a policy that does not search."""


@dataclass(frozen=True, kw_only=True)
class Policy(ABC):
    """A replanning policy is its settings, a frozen dataclass, and one verb.

    Policies differ in how they find ways. The motions along them are made and proven alike for all, by `PolicyFlight`.
    """

    def __new__(cls, *args: Any, **settings: Any) -> Self:
        """Refuse a misspelt setting with a list of the settings that exist."""
        known = [field.name for field in fields(cls)]
        unknown = [name for name in settings if name not in known]
        if unknown:
            raise InputError(
                f"there is no setting {', '.join(map(repr, unknown))}; {cls.__name__} has {', '.join(known) or 'none'}"
            )
        return super().__new__(cls)

    @property
    def needs_proof(self) -> bool:
        """Whether only proven motions are flown."""
        return True

    @abstractmethod
    def find(self, situation: Situation) -> Found:
        """Return the way that a UAV is to fly from now on, as far as this policy finds one."""


def require_positive(policy: Policy, name: str) -> None:
    """Raise `ValueError` unless a setting is a finite number above 0."""
    value = getattr(policy, name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise InputError(f"{name} is a number above 0, not {value!r}")


@dataclass(frozen=True, kw_only=True)
class Wait(Policy):
    """Go on along the mission's own path as soon as that is proven, and stand still until then."""

    def find(self, situation: Situation) -> Found:
        """Return what is left of the mission's path."""
        return Found(situation.guidance, NO_EFFORT)
