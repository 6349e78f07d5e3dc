"""One UAV in flight: what it flies, where it is led, and what all kinds of UAVs must be able to tell about that."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.live.policies.policy import Found
from skyverse.live.search import Choice
from skyverse.live.surroundings import Surroundings
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.problem import Airspace
from skyverse.space.world import World

LOST = 1.0
"""Seconds after which another way is planned at the earliest for a UAV that cannot follow the one before."""
SPARE = 0.5
"""Seconds of the default horizon beyond those that the way out takes."""


@dataclass(frozen=True)
class Pilot(ABC):
    """One UAV in flight.

    Attributes
    ----------
    number, uav
        Its index, and its limits.
    planned
        The instant at which its way was planned, seconds into the mission.
    """

    number: int
    uav: UAV
    planned: float

    turns: ClassVar[str]
    """What it does at its `turning_place`, in words."""

    @classmethod
    @abstractmethod
    def at_start(cls, airspace: Airspace, mission: Mission, number: int) -> Self:
        """Return the pilot of a UAV that is at its start, at 0 s."""

    @staticmethod
    @abstractmethod
    def seconds_of_way_out(uav: UAV) -> float:
        """Return the seconds that its way out takes at most."""

    def horizon(self, now: float, longest: float, lead: float) -> float:
        """Return the seconds up to which its motion is proven, no more than are given."""
        return longest

    def freed(self) -> Self:
        """Return the pilot that knows that a mover which may have kept it from its target is gone."""
        return self

    @property
    @abstractmethod
    def way_out(self) -> str:
        """What it can do if nothing is observed any more, in words that follow its name."""

    @property
    @abstractmethod
    def motion(self) -> Trajectory:
        """What it flies from now on."""

    @property
    @abstractmethod
    def flown(self) -> Trajectory:
        """What it has flown since the mission began, and will fly if nothing is observed any more."""

    @property
    @abstractmethod
    def arrival(self) -> float | None:
        """The instant at which its motion reaches its target, seconds; ``None`` if it does not."""

    @property
    @abstractmethod
    def occupied(self) -> tuple[Trajectory, ...]:
        """Motions that other UAVs keep clear of; each stays where it ends."""

    @abstractmethod
    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, also one at which it flew before, (3, 3)."""

    def reached(self, now: float, seconds: float, scenario: Scenario) -> tuple[Floats, Floats]:
        """Return the corners (3,) of the box, in bounds, in which it is within some seconds from now, metres."""
        place, far = self.state(now)[0], self.uav.max_speed * seconds
        low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
        return np.clip(place - far, low, high), np.clip(place + far, low, high)

    @property
    def ended(self) -> bool:
        """Whether its mission has ended where it is, so that it can fly no other way."""
        return False

    @abstractmethod
    def turning_place(self, t: float) -> Floats:
        """Return the place (3,) from which it can fly another way that begins at an instant."""

    @abstractmethod
    def checked_state(self, state: Floats) -> None:
        """Raise `InputError` unless it can be in a state (3, 3)."""

    @abstractmethod
    def restarted(self, t: float, state: Floats) -> Self:
        """Return the pilot of the UAV that was found in a state (3, 3) at an instant."""

    @abstractmethod
    def led_to(self, scenario: Scenario, target: int | None, now: float, join: float) -> Self | None:
        """Return the pilot that follows a way to its target, newly planned for `join`; ``None`` if there is none."""

    def toured(self, join: float) -> Self:
        """Return the pilot that goes on along its tour, if it has one and a stay is over by the instant `join`."""
        return self

    @abstractmethod
    def needs_a_way(self, world: World, new: bool, now: float, join: float) -> bool:
        """Tell whether another way is to be planned among what stands still, which may be `new`."""

    @abstractmethod
    def choose(self, around: Surroundings, answer: Found | None) -> tuple[Self, Choice]:
        """Return the pilot with what is flown from now on, along the way that a policy has found if it was asked."""
