"""Replanning policies: frozen settings with one verb, which finds a way anew; and what is flown of these ways."""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import Course
from skyverse.live.guidance import SHARES, Way
from skyverse.live.multirotor_search import AT_END, Branch, MultirotorSearch, Outcome
from skyverse.live.search import KEEP_ON, Step
from skyverse.live.steered_motion import seconds_left
from skyverse.live.surroundings import Span, Surroundings
from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.mover_motions import PolynomialMotion
from skyverse.model.result import Effort
from skyverse.model.scenario import Scenario
from skyverse.model.timed_shapes import TimedShape
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import kept_ellipsoid
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
    span
        The instants that matter.
    state
        (3, 3) position, velocity and acceleration at `span.join`.
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
    span: Span
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
    proof
        Whether only proven motions along the way are flown; otherwise the first that can be made is.
    """

    way: Way | None
    effort: Effort
    memory: object = None
    share: float = 1.0
    proof: bool = True


SAME_PLACE = 0.02
"""Metres between points of two ways that count as one."""
NEAR_END = 0.1
"""Metres from the end of a way from which on a UAV had better not come to rest."""
NO_EFFORT = Effort(0, 0, 0)
"""The effort of a policy that does not search."""


def all_about(
    scenario: Scenario, uav: int, seen: Sequence[Mover], motions: Sequence[Trajectory]
) -> tuple[TimedShape, ...]:
    """Return what moves about a UAV: movers that were seen, and all other UAVs by their motions."""
    known = [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in seen]
    for other, motion in enumerate(motions):
        across, above = kept_ellipsoid(scenario.uavs[uav], scenario.uavs[other])
        if other != uav and across > 0.0:
            moves = PolynomialMotion(knots=tuple(motion.knots), coefficients=motion.coefficients.tolist())
            shape = Ellipsoid(centre=(0, 0, 0), semi_axis_xy=across, semi_axis_z=above)
            known.append(TimedShape(shape, moves, Doubt(), 0.0))
    return tuple(known)


@dataclass(frozen=True, kw_only=True)
class Policy(ABC):
    """A replanning policy is its settings, a frozen dataclass, and one verb.

    Policies differ in how they find ways. The motions along them are made and proven alike for all, by `PolicySearch`.
    """

    @abstractmethod
    def find(self, situation: Situation) -> Found:
        """Return the way that a UAV is to fly from now on, as far as this policy finds one."""


LEAST, MOST = 1e-3, 600.0
"""Seconds: settings of policies that are times lie between these."""


@dataclass(frozen=True, kw_only=True)
class Wait(Policy):
    """Go on along the mission's own path as soon as that is proven, and stand still until then."""

    def find(self, situation: Situation) -> Found:
        """Return what is left of the mission's path."""
        return Found(situation.guidance, NO_EFFORT)


class PolicySearch(MultirotorSearch):
    """A search along nothing but the ways that a policy has found, and the present one.

    Parameters
    ----------
    course, guidance, around
        As for `MultirotorSearch`.
    found
        What the policy has found. Its way is tried also by the place where the UAV would come to rest.
    """

    taken = False

    def __init__(self, course: Course, guidance: Way, around: Surroundings, found: Found) -> None:
        super().__init__(course, guidance, None, around)
        self.ways: list[Way] = []
        if found.way is not None and len(found.way.points):
            self.ways = [found.way, found.way.through(0, course.stop(self.span.join, around.limits), 0.0)]
        self.share, self.proof, self.widened = found.share, found.proof, True

    def first(self) -> Iterator[Step[Course]]:
        """Yield nothing: all ways are tried in the order of when they could arrive."""
        return iter(())

    def fill(self) -> None:
        """Push the ways at all speeds, and the present one by when it could arrive along the first of them."""
        if self.ways:
            self.push(self.arrival(self.hold) - KEEP_ON, partial(self.examine, self.hold))
            for begin in self.begins():
                self.consider(begin, self.ways, [self.share * share for share in SHARES])

    def leads_on(self, place: Floats, way: Way, mark: int) -> bool:
        """Believe the policy that its ways lead on."""
        return True

    def examine(self, found: Branch) -> Outcome | None:
        """Return a motion if it is proven, or need not be."""
        outcome = self.proven(found)
        return self.unproven(found, self.met[-1][0]) if outcome is None and not self.proof else outcome

    def arrival(self, found: Branch) -> float:
        """Return about when a UAV arrives that keeps its course for now, and follows the first way later.

        Never, if it would come to rest so near to the end of the way that no motion leads there any more.
        """
        course, way, looked_at = self.flown(found), self.ways[0], self.looked_at
        off = math.dist(course.state(course.motion.end)[0], way.points[-1])
        if off <= NEAR_END:
            return course.motion.end if off <= AT_END else math.inf
        place, velocity, _ = course.state(looked_at)
        done = course.way.points[course.passed <= looked_at]
        k = 0
        while k < len(way.points) - 1 and np.any(np.linalg.norm(done - way.points[k], axis=1) < SAME_PLACE):
            k += 1
        return looked_at + seconds_left(self.around.limits, place, velocity, way.points[k:])
