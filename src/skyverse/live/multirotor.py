"""A multirotor in flight: its way out is to come to rest."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import Course, Planned, part_of, place_of_rest, planned_motion, spliced
from skyverse.live.guidance import Way, mission_guidance, place_to_stay, planned_anew, sees_its_way
from skyverse.live.multirotor_search import MultirotorSearch
from skyverse.live.pilot import LOST, SPARE, Pilot
from skyverse.live.policies.policy import Found, PolicySearch
from skyverse.live.search import Choice
from skyverse.live.steered_heading import steered_heading, still
from skyverse.live.stops import TourStop, stands_since, stops_of
from skyverse.live.surroundings import Span, Surroundings
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario, Target
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
    tour, stops
        Of a tour: its trajectory as planned, and the stops that it has not left yet; the guidance leads to the first.
    late, left
        By how many seconds it flies the tour later than planned, ``None`` while it flies another way; and by how many
        it was late at each stop that it has left.
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
    tour: Trajectory | None = None
    stops: tuple[TourStop, ...] = ()
    late: float | None = None
    left: tuple[float, ...] = ()
    turns: ClassVar[str] = "can stop"

    @classmethod
    def at_start(cls, airspace: Airspace, mission: Mission, number: int) -> Self:
        """Return the pilot of a UAV that hovers at its start, from 0 s on."""
        uav = mission.scenario.uavs[number]
        stops = stops_of(airspace, mission, number)
        guidance = stops[0].way if stops else mission_guidance(airspace, mission, number)
        motion = rest_to_rest(np.array([uav.start]), uav)
        course = Course((), motion, guidance.after(1), np.full(len(guidance.points) - 1, np.inf), 1, leaves=0.0)
        flight = mission.trajectories[number]
        if flight is not None and flight.pointing is None:
            flight = with_heading(flight, uav)
        (yaw,), _, _ = with_heading(motion, uav).heading([0.0]) if flight is None else flight.heading([0.0])
        pilot = cls(number, uav, 0.0, course, guidance, None, still(float(yaw), uav), winds=mission.scenario.winds)
        if stops and flight is not None:
            return replace(pilot, tour=flight, stops=stops, own=Planned(flight, stops[0].passed), late=0.0)
        return replace(pilot, own=planned_motion(flight, guidance))

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
        """The instant at which its motion ends at its target, seconds; ``None`` if it ends elsewhere.

        That of a tour ends at its last stop, after the stay there.
        """
        motion = self.course.motion
        if self.stops and (self.late is None or self.own is None or self.course.leaves < self.own.motion.end):
            return None
        return motion.end if math.dist(place_of_rest(motion), self.guidance.points[-1]) <= 1e-6 else None

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, also one at which it flew before, (3, 3)."""
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
        if self.stops:
            target = self.stops[0].target
            if target is None:
                home = Target(position=tuple(self.stops[0].place.tolist()))
                scenario, target = derived(scenario, targets=(*scenario.targets, home)), len(scenario.targets)
        way = planned_anew(scenario, self.number, target, self.turning_place(join))
        if way is None:
            return None
        course = self.course.guided_by(way)
        led = replace(self, planned=now, guidance=way, own=None, course=course, memory=None, late=None)
        same = np.array_equal(way.points[-1], self.guidance.points[-1])
        return led if same else replace(led, nearest=math.inf, waited=False)

    def toured(self, join: float) -> Self:
        """Return the pilot that goes on to its next stop when a stay is over.

        One that was led away from its tour stays all the time at the stop to which it flew, and goes on along the tour
        from there, later than planned, and never earlier.
        """
        pilot = self._past_stops(min(join, self.course.leaves))
        if not pilot.stops or pilot.tour is None or (pilot.late is not None and pilot.course.leaves >= join):
            return pilot
        stop, motion = pilot.stops[0], pilot.course.motion
        since = stands_since((*pilot.course.flown, part_of(motion, motion.start, join)), stop.place)
        if since is None or join < stop.arrival:
            return pilot
        planned = min(stop.arrival + join - since, stop.departure, join)
        late, way = join - planned, place_to_stay(stop.place)
        own = None
        if pilot.tour.end - planned > MIN_PIECE:
            whole = spliced(motion, part_of(pilot.tour, planned, pilot.tour.end).retimed(join))
            pointing = pilot.tour.retimed(pilot.tour.start + late).pointing
            own = Planned(replace(whole, pointing=pointing), np.array([join]))
        course = replace(pilot.course.guided_by(way), leaves=join)
        return replace(pilot, guidance=way, own=own, course=course, late=late)._past_stops(join)

    def _past_stops(self, t: float) -> Self:
        """Return the pilot without the stops that it has left by an instant, if it has flown its tour up to then."""
        pilot = self
        while pilot.stops and pilot.late is not None and t - pilot.late >= pilot.stops[0].departure - MIN_PIECE:
            stops, late, leaves = pilot.stops[1:], pilot.late, pilot.course.leaves
            pilot = replace(pilot, stops=stops, left=(*pilot.left, late))
            if stops and pilot.own is not None:
                way, passed = stops[0].way, stops[0].passed + late
                never = np.where(passed <= leaves, passed, np.inf)
                course = replace(pilot.course.guided_by(way), passed=never, leaves=leaves)
                own = pilot.own._replace(passed=passed)
                pilot = replace(pilot, guidance=way, own=own, course=course, nearest=math.inf, waited=False)
        return pilot

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
        return replace(
            self, planned=begin, course=course, guidance=way, own=own, nearest=math.inf, held_up=False, late=None
        )


def _seconds_to_rest(uav: UAV, speed: float) -> float:
    """Return the seconds in which a multirotor comes to rest."""
    return speed / uav.max_acceleration + uav.max_acceleration / uav.max_jerk
