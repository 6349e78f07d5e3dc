"""An aeroplane in flight: its way out is to loiter, or to end its mission at its target."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.live.aeroplane_course import (
    LEFT,
    LEVEL,
    AeroplaneCourse,
    Flying,
    Reference,
    leg_flown,
    loiter,
    places_ahead,
    pose_at,
    pose_of,
    turn,
)
from skyverse.live.aeroplane_search import AeroplaneSearch
from skyverse.live.course import STAY, part_of, spliced, staying
from skyverse.live.guidance import path_from
from skyverse.live.pilot import Pilot
from skyverse.live.policies.policy import Found
from skyverse.live.search import Choice
from skyverse.live.surroundings import Span, Surroundings
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.model.verdict import Verdict
from skyverse.numerics.tolerances import MIN_FLOWN
from skyverse.problem import Airspace
from skyverse.space.agility import agility_of, fixed_wing
from skyverse.space.world import World
from skyverse.trajectory.aeroplane import fly_aeroplane
from skyverse.trajectory.heading import with_heading
from skyverse.trajectory.path_to_trajectory import needed_waypoints
from skyverse.trajectory.proof import clear_pieces, prove


@dataclass(frozen=True)
class Aeroplane(Pilot):
    """An aeroplane in flight.

    Attributes
    ----------
    course
        What it flies.
    plan, done
        The trajectory that it would fly if nothing moved, ``None`` if it has none, and the instant of it before which
        it does not get back to it.
    arrived
        The instant at which it has passed its target; ``None`` if it has not.
    """

    course: AeroplaneCourse
    plan: Trajectory | None
    done: float
    arrived: float | None = None
    turns: ClassVar[str] = "can turn"

    @classmethod
    def at_start(cls, airspace: Airspace, mission: Mission, number: int) -> Self:
        """Return the pilot of an aeroplane that departs when its mission says; without a trajectory it stays."""
        uav, plan = mission.scenario.uavs[number], mission.trajectories[number]
        if plan is None:
            return cls(number, uav, 0.0, _standing((), np.array(uav.start), 0.0), None, -math.inf)
        return cls(number, uav, 0.0, _departing((), plan), plan, plan.start)

    @staticmethod
    def seconds_of_way_out(uav: UAV) -> float:
        """Return the seconds of a full turn."""
        return 2.0 * math.pi * float(agility_of(uav).radii[0]) / fixed_wing(uav).speed

    @property
    def _able(self) -> Flying:
        return Flying(agility_of(self.uav), fixed_wing(self.uav).speed)

    @property
    def way_out(self) -> str:
        """What it can do if nothing is observed any more, in words that follow its name."""
        if self.course.stands:
            return "stays where it is"
        return "can fly to its target" if self.course.lands else "can loiter"

    @property
    def motion(self) -> Trajectory:
        """What it flies from now on, to the end of a full turn, or of its mission."""
        return with_heading(self.course.motion, self.uav)

    @property
    def flown(self) -> Trajectory:
        """What it has flown since it departed, and will fly if nothing is observed any more, up to its target."""
        return with_heading(self._flown, self.uav)

    @property
    def _flown(self) -> Trajectory:
        whole, arrival = joined([*self.course.flown, self.course.motion]), self.arrival
        return whole if arrival is None else part_of(whole, whole.start, arrival)

    @property
    def arrival(self) -> float | None:
        """The instant at which its motion passes its target, seconds; ``None`` if it does not."""
        return self.course.arrival if self.arrived is None else self.arrived

    @property
    def occupied(self) -> tuple[Trajectory, ...]:
        """Motions that other UAVs keep clear of: once it has arrived it counts as staying at its target, too."""
        if self.arrival is None or self.course.lands or self.course.stands:
            return (self.course.motion,)
        return self.course.motion, self._flown

    def state(self, t: float) -> Floats:
        """Return position, velocity and acceleration at an instant, also one at which it flew before, (3, 3)."""
        return self._lasting(t).state(t)

    def _lasting(self, until: float) -> AeroplaneCourse:
        return self.course.lasting(until, self._able)

    def _levelled(self, begin: float) -> Trajectory | None:
        """Return the straight motion from an instant on in which a climb fades out; ``None`` if it does not climb."""
        pose, able = pose_at(self._lasting(begin).motion, begin), self._able
        metres = abs(float(pose[4])) / (able.agility.rate * able.speed)
        if metres <= MIN_FLOWN:
            return None
        leg = turn(pose, LEFT, 0.0, metres, LEVEL, able.agility, able.speed)
        return leg_flown(begin, leg, pose, 0.0, able)

    def turning_place(self, t: float) -> Floats:
        """Return where it is level, (3,) metres, if it flies straight on from an instant on."""
        level = None if self._departs_after(t) else self._levelled(t)
        motion, t = (self._lasting(t).motion, t) if level is None else (level, level.end)
        return motion.at([t]).position[0]

    def _departs_after(self, t: float) -> bool:
        """Tell whether it stands at an instant, and can depart in any heading."""
        return self.course.stands or t < self.course.motion.start

    @property
    def ended(self) -> bool:
        """Whether it has ended its mission at its target, where it had no room to loiter."""
        return self.course.stands and bool(self.course.flown)

    def checked_state(self, state: Floats) -> None:
        """Raise `InputError` if it would not fly forwards in a state (3, 3)."""
        if np.hypot(*state[1, :2]) == 0.0 and not self._departs_after(self.course.motion.start):
            said = "expected the velocity of an aeroplane, which flies forwards, but it has no horizontal part"
            raise InputError(said, field=f"states[{self.number}]")

    def restarted(self, t: float, state: Floats) -> Self:
        """Return the pilot of the aeroplane that loiters from a state (3, 3), where it was found at an instant."""
        if self._departs_after(t) and not (self.ended and np.hypot(*state[1, :2]) > 0.0):
            return self
        able, before = self._able, self._lasting(t).motion
        steepest = able.agility.slope * able.speed
        pose = pose_of(state[0], state[1])
        pose[4] = np.clip(pose[4], -steepest, steepest)
        if self.ended:
            flown = _stayed(self.course, before.at([before.start]).position[0], t)
        else:
            flown = (*self.course.flown, part_of(before, before.start, t)) if t > before.start else self.course.flown
        return replace(self, course=AeroplaneCourse(flown, loiter(t, pose, LEFT, 0.0, able), None, -math.inf))

    def led_to(self, scenario: Scenario, target: int | None, now: float, join: float) -> Self | None:
        """Return the pilot that follows a trajectory to its target from where it is level; ``None`` if there is none.

        It has not left its present course yet: `choose` may lead it to where the trajectory begins.
        """
        standing = self._departs_after(join)
        begin = join if self.course.stands else max(join, self.course.motion.start)
        level = None if standing else self._levelled(begin)
        place = self.turning_place(begin)
        found = path_from(scenario, self.number, target, place)
        if found is None:
            return None
        problem, result = found
        heading = None if standing else float(pose_at(self._lasting(begin).motion, begin)[3])
        plan = fly_aeroplane(problem.airspace.world, needed_waypoints(problem, result), self.uav, (heading, None))
        if plan is None:
            return None
        plan = plan.retimed(begin) if level is None else spliced(level, plan.retimed(level.end))
        if prove(problem.airspace.world, self.uav, plan).verdict is not Verdict.PROVEN:
            return None
        course = replace(self.course, reference=None, leaves=-math.inf)
        if standing:
            course = _departing(_stayed(self.course, place, begin), plan)
        return replace(self, planned=now, course=course, plan=plan, done=begin, arrived=None)

    def needs_a_way(self, world: World, new: bool, now: float, join: float) -> bool:
        """Tell whether something new stands in its way, or it has loitered for a full turn since one was planned."""
        if self.plan is None or (self.arrival is not None and self.arrival <= now):
            return False
        since = max(self.done, self.course.planned_until(join), self.plan.start)
        ahead = part_of(self.plan, since, self.plan.end)
        if new and not clear_pieces(world.space, np.diff(ahead.knots), ahead.coefficients.copy()).all():
            return True
        return self.course.leaves < now and now - self.planned >= self.seconds_of_way_out(self.uav)

    def choose(self, around: Surroundings, answer: Found | None) -> tuple[Self, Choice]:
        """Return the pilot with the course that is chosen; policies are not asked."""
        span, pilot = around.span, self._at(around.span)
        if pilot.course.stands:
            motion = pilot.course.motion
            contact = around.contact(motion, span.now, span.apart)
            free = bool(around.world.free(motion.coefficients[0, 0].copy())[0])
            return pilot, Choice(True, free and contact.mover < 0, contact, 0)
        course, plan, able = pilot.course, pilot.plan, pilot._able
        since = max(pilot.done, course.planned_until(max(span.join, course.motion.start)))
        ahead = None if plan is None else places_ahead(plan, since, able)
        course, choice = AeroplaneSearch(course, ahead, able, around).choose()
        return replace(pilot, course=course), choice

    def _at(self, span: Span) -> Self:
        """Return the same pilot, which counts as flown what it has flown, and knows whether it has arrived."""
        course = self._lasting(span.join).since(span.now)
        done = max(self.done, course.planned_until(span.now))
        if self.arrived is None and course.arrival is not None and course.arrival <= span.now:
            if course.lands:
                place = course.motion.at([course.motion.end]).position[0]
                course = _standing((*course.flown, course.motion), place, course.arrival)
            return replace(self, course=course, plan=None, done=done, arrived=self.course.arrival)
        return replace(self, course=course, done=done)


def _standing(flown: tuple[Trajectory, ...], place: Floats, since: float) -> AeroplaneCourse:
    """Return the course of an aeroplane that stands at a place (3,) from an instant on."""
    return AeroplaneCourse(flown, staying(place, since, since + STAY), None, math.inf)


def _departing(flown: tuple[Trajectory, ...], plan: Trajectory) -> AeroplaneCourse:
    """Return the course of an aeroplane that departs when a trajectory begins."""
    return AeroplaneCourse(flown, plan, Reference(plan, plan.start), plan.end)


def _stayed(course: AeroplaneCourse, place: Floats, until: float) -> tuple[Trajectory, ...]:
    """Return what was flown before an aeroplane stood at a place (3,), and its stay there until it departs again."""
    if not course.flown or not course.stands:
        return course.flown
    return (*course.flown, staying(place, course.motion.start, until))
