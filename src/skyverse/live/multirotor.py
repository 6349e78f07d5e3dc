"""A multirotor in flight: its way out is to come to rest."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import Course, Planned, part_of, place_of_rest, planned_motion, spliced
from skyverse.live.guidance import Way, mission_guidance, planned_anew, sees_its_way
from skyverse.live.multirotor_search import MultirotorSearch
from skyverse.live.pilot import LOST, SPARE, Pilot
from skyverse.live.policies.policy import Found, PolicySearch
from skyverse.live.search import Choice
from skyverse.live.steered_heading import steered_heading, still
from skyverse.live.surroundings import Span, Surroundings
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Pointing, Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.model.wind import STILL_AIR, WindBall
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_PIECE
from skyverse.problem import Airspace
from skyverse.space.world import World
from skyverse.trajectory.heading import with_heading
from skyverse.trajectory.leg_parts import rest_to_rest
from skyverse.trajectory.limits import Limits, limits_of

NEARER = 0.1
"""Metres by which a UAV comes nearer to its target if it comes nearer at all."""
STUCK = 3.0
"""Seconds for which it comes no nearer until all are led apart, if UAVs are in its way, or else it looks less far."""


@dataclass(frozen=True)
class Multirotor(Pilot):
    """A multirotor in flight.

    Attributes
    ----------
    course
        What it flies.
    guidance, own
        The way that it would fly if nothing moved, and the mission's trajectory, ``None`` if it flies another way.
    pointing
        Where its nose points, since shortly before now.
    pointed
        Where it pointed before, one after another, without what had not ended.
    nearest, since
        How near to its target it has been, metres along its way, and the instant since which it has come no nearer.
    held_up
        Whether another UAV is in its way.
    waited
        Whether movers have kept it from coming nearer to this target for long; they may do so again.
    waits
        Whether it comes to rest and stays there, as far as that is proven, while a mission is planned for all.
    memory
        What a policy's last answer asked to be kept; ``None`` at first.
    winds
        In which it flies.
    """

    course: Course
    guidance: Way
    own: Planned | None
    pointing: Pointing
    nearest: float = math.inf
    since: float = 0.0
    held_up: bool = False
    waited: bool = False
    waits: bool = False
    pointed: tuple[Pointing, ...] = ()
    memory: object = None
    winds: WindBall = STILL_AIR
    turns: ClassVar[str] = "can stop"

    @classmethod
    def at_start(cls, airspace: Airspace, mission: Mission, number: int) -> Self:
        """Return the pilot of a UAV that hovers at its start, from 0 s on."""
        uav = mission.scenario.uavs[number]
        guidance = mission_guidance(airspace, mission, number)
        motion = rest_to_rest(np.array([uav.start]), uav)
        course = Course((), motion, guidance.after(1), np.full(len(guidance.points) - 1, np.inf), 1, leaves=0.0)
        flight = mission.trajectories[number]
        if flight is not None and flight.pointing is None:
            flight = with_heading(flight, uav)
        (yaw,), _, _ = with_heading(motion, uav).heading([0.0]) if flight is None else flight.heading([0.0])
        own, pointing = planned_motion(flight, guidance), still(float(yaw), uav)
        return cls(number, uav, 0.0, course, guidance, own, pointing, winds=mission.scenario.winds)

    @staticmethod
    def seconds_of_way_out(uav: UAV) -> float:
        """Return the seconds in which a multirotor comes to rest from its top speed."""
        return _seconds_to_rest(uav, uav.max_speed)

    def horizon(self, now: float, longest: float, lead: float) -> float:
        """Return the seconds up to which its motion is proven.

        The longer is looked ahead, the farther a mover may be from where it was seen, in the end anywhere. So a UAV
        that movers have kept from coming nearer for long looks ahead only as far as it has to at its present speed.
        """
        if not self.waited:
            return longest
        return min(longest, _seconds_to_rest(self.uav, math.hypot(*self.state(now)[1])) + lead + SPARE)

    def freed(self) -> Self:
        """Return the pilot that looks far ahead again, as a mover that may have kept it from its target is gone."""
        return replace(self, waited=False)

    @property
    def way_out(self) -> str:
        """What it can do if nothing is observed any more, in words that follow its name."""
        return "has a way out"

    @property
    def _limits(self) -> Limits:
        return limits_of(self.uav, -LIMIT_MARGIN, self.winds)

    @property
    def motion(self) -> Trajectory:
        """What it flies from now on, to rest."""
        motion = self.course.motion
        return replace(motion, pointing=self.pointing.parted(motion.start)[1])

    @property
    def occupied(self) -> tuple[Trajectory, ...]:
        """The motion that other UAVs keep clear of, and then where it stays."""
        return (self.course.motion,)

    @property
    def flown(self) -> Trajectory:
        """What it has flown since the mission began, and will fly if nothing is observed any more."""
        parts = [*self.pointed, self.pointing]
        instants, turns = (np.concatenate([getattr(one, name) for one in parts]) for name in ("instants", "turns"))
        pointing = replace(parts[0], instants=instants, turns=turns)
        return replace(joined([*self.course.flown, self.course.motion]), pointing=pointing)

    @property
    def arrival(self) -> float | None:
        """The instant at which its motion ends at its target, seconds; ``None`` if it ends elsewhere."""
        motion = self.course.motion
        return motion.end if math.dist(place_of_rest(motion), self.guidance.points[-1]) <= 1e-6 else None

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, (3, 3)."""
        return self.course.state(t)

    def next_mark(self, t: float) -> int:
        """Return the next point of the guidance to fly to at an instant; the last one if all are passed."""
        return min(self.course.next_mark(t), len(self.guidance.points) - 1)

    def turning_place(self, t: float) -> Floats:
        """Return where it comes to rest if it brakes from an instant on, (3,) metres."""
        return self.course.stop(t, self._limits)

    def checked_state(self, state: Floats) -> None:
        """Accept any state."""

    def restarted(self, t: float, state: Floats) -> Self:
        """Return the pilot of the UAV that brakes from a state (3, 3), where it was found at an instant."""
        return self.flying(self.course.restarted(t, state, self._limits), t)

    def flying(self, course: Course, begin: float) -> Self:
        """Return the pilot that flies another course from an instant on."""
        planned = None if self.own is None else self.own.motion
        pointing = steered_heading(self.pointing, begin, course.motion, self.uav, planned, course.leaves)
        return replace(self, course=course, pointing=pointing)

    def led_to(self, scenario: Scenario, target: int | None, now: float, join: float) -> Self | None:
        """Return the pilot that follows a new way from where it can come to rest; ``None`` if there is none."""
        way = planned_anew(scenario, self.number, target, self.turning_place(join))
        if way is None:
            return None
        led = replace(self, planned=now, guidance=way, own=None, course=self.course.guided_by(way), memory=None)
        same = np.array_equal(way.points[-1], self.guidance.points[-1])
        return led if same else replace(led, nearest=math.inf, waited=False)

    def needs_a_way(self, world: World, new: bool, now: float, join: float) -> bool:
        """Tell whether something new stands in its way, or it has been led too far away from it."""
        way, mark = self.guidance, self.course.next_mark(join)
        ahead = way.after(max(min(mark, len(way.points) - 1) - 1, 0)).points
        barred = new and not world.segments_free(ahead[:-1], ahead[1:]).all()
        return barred or (now - self.planned >= LOST and not sees_its_way(world, self.turning_place(join), way, mark))

    def choose(self, around: Surroundings, answer: Found | None) -> tuple[Self, Choice]:
        """Return the pilot with the course that is chosen, along the way that a policy has found if it was asked."""
        span = around.span
        now = self.course.since(span.now)
        before, pointing = self.pointing.parted(now.motion.start)
        pilot = replace(self, pointing=pointing, pointed=(*self.pointed, before) if len(before.turns) else self.pointed)
        for motions in (0, around.motions) if self.waits else (around.motions,):
            asked = around._replace(motions=motions)
            if answer is None:
                course, choice = MultirotorSearch(now, self.guidance, self.own, asked).choose()
            else:
                course, choice = PolicySearch(now, self.guidance, asked, answer).choose()
            if choice.proven:
                break
        pilot = replace(pilot, course=course) if choice.kept else pilot.flying(course, span.join)
        if answer is not None:
            return replace(pilot, memory=answer.memory), choice
        return pilot._watched(span, choice.held_up), choice

    def _watched(self, span: Span, held_up: bool) -> Self:
        """Return the pilot that knows since when the UAV has come no nearer to its target, unless that is planned."""
        points = self.guidance.after(self.next_mark(span.now)).points
        ends = [self.course.state(span.now)[0], *points]
        left = sum(math.dist(a, b) for a, b in pairwise(ends))
        arrived = left < NEARER
        if left < self.nearest - NEARER or arrived or self.course.leaves >= span.join:
            return replace(self, nearest=left, since=span.now, held_up=held_up)
        by_movers = span.now - self.since >= STUCK and not held_up and not self.waits
        return replace(self, held_up=held_up, waited=self.waited or by_movers)

    def is_stuck(self, now: float) -> bool:
        """Tell whether another UAV has kept it from coming nearer to its target for long."""
        return self.held_up and now - self.since >= STUCK

    def following(self, airspace: Airspace, mission: Mission, number: int, begin: float) -> Self:
        """Return the pilot that goes on by UAV `number`'s flight of a mission, which begins at an instant.

        That is no earlier than when its motion ends, at the start of that flight.
        """
        flight = mission.trajectories[number]
        if flight is None or flight.end - flight.start <= MIN_PIECE:
            return self
        way = mission_guidance(airspace, mission, number)
        course, planned = self.course.guided_by(way), planned_motion(flight.retimed(begin + flight.start), way)
        assert planned is not None
        whole = spliced(course.motion, part_of(flight, 0.0, flight.end).retimed(begin))
        own = planned._replace(motion=replace(whole, pointing=planned.motion.pointing))
        course = replace(course, leaves=begin)
        return replace(self, planned=begin, course=course, guidance=way, own=own, nearest=math.inf, held_up=False)


def _seconds_to_rest(uav: UAV, speed: float) -> float:
    """Return the seconds in which a multirotor comes to rest."""
    return speed / uav.max_acceleration + uav.max_acceleration / uav.max_jerk
