"""A mission in flight: what is seen comes in, and motions that are proven to have a way out go out."""

import math
import time
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from skyverse.errors import InputError
from skyverse.live.choose_course import Choice, Span, choose_course
from skyverse.live.course import Course
from skyverse.live.guidance import Way, mission_guidance, planned_anew, sees
from skyverse.live.observed import Known, checked_states, strays, with_seen, with_targets
from skyverse.live.planned_motion import planned_motion
from skyverse.live.replan import Replan
from skyverse.live.sighting import Sighting, checked_sighting
from skyverse.live.surroundings import Moving, Surroundings, all_moving, with_others
from skyverse.live.track import Track
from skyverse.model.mission import Mission
from skyverse.model.mover import Mover
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape
from skyverse.model.short_lines import told_point
from skyverse.model.trajectory import Trajectory, joined
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.problem import Airspace
from skyverse.trajectory.limits import limits_of
from skyverse.trajectory.rest_to_rest import rest_to_rest

SPARE = 0.5
"""Seconds of the default horizon beyond those in which the UAV that takes longest comes to rest from its top speed."""
LOST = 1.0
"""Seconds after which another way is planned at the earliest for a UAV that does not see the one before."""
MAX_INSTANT = 1e9
"""Seconds into the mission: no observation is later."""


class Replanner:
    """A mission in flight: it takes in what is seen, and answers with the motions to fly from now on.

    Each motion joins the one before with continuous position, velocity and acceleration, keeps the UAV's limits, and
    ends at rest within the horizon. It is flown only if it is proven clear of what stands still, and up to the horizon
    of wherever movers may be: so there is a way out at every instant, whether or not anything is observed again.

    Parameters
    ----------
    mission
        Of multirotors. They fly its trajectories, from 0 s on, as long as these are proven to have a way out at every
        instant; a UAV that has left its trajectory flies along its path, as fast as it can.
    horizon
        Seconds from an observation up to which motions are proven; by default, half a second more than a UAV of the
        fleet takes at most to come to rest.
    lead
        Seconds from an observation at which a new motion begins: so long the answer may take.
    memory
        Seconds after which a mover that is not seen again is forgotten.
    candidates
        How many motions are tried for a UAV at most at each observation.

    Attributes
    ----------
    mission
        As given.
    scenario
        What is known, with the obstacles that were seen.
    now
        The instant of the last observation, seconds into the mission.
    horizon, lead, memory, candidates
        As given, or their defaults.

    Raises
    ------
    InputError
        If an argument is out of range, or the mission has aeroplanes, which are not replanned yet.
    """

    def __init__(
        self,
        mission: Mission,
        *,
        horizon: float | None = None,
        lead: float = 0.1,
        memory: float = 3.0,
        candidates: int = 128,
    ) -> None:
        scenario = mission.scenario
        _refuse_what_is_not_replanned(mission)
        slowest = max(u.max_speed / u.max_acceleration + u.max_acceleration / u.max_jerk for u in scenario.uavs)
        self.horizon = slowest + lead + SPARE if horizon is None else horizon
        for name, value, least in (("lead", lead, 0.0), ("horizon", self.horizon, lead), ("memory", memory, 0.0)):
            if not least < value < MAX_INSTANT:
                raise InputError(f"expected more than {least:g} seconds, but it is {value!r}", field=name)
        if candidates < 1:
            raise InputError(f"expected 1 or more, but it is {candidates!r}", field="candidates")
        self.lead, self.memory, self.candidates = lead, memory, candidates
        self.mission, self.scenario, self.now = mission, scenario, 0.0
        self._limits = [limits_of(uav, -LIMIT_MARGIN) for uav in scenario.uavs]
        self._airspace = Airspace(scenario)
        self._tracks: dict[str, Track] = {}
        self._entered: tuple[Shape, ...] = ()
        self._assignment = tuple(mission.assignment)
        self._planned = [0.0] * len(scenario.uavs)
        self._guidance = [mission_guidance(self._airspace, mission, uav) for uav in range(len(scenario.uavs))]
        self._own = [planned_motion(*both) for both in zip(mission.trajectories, self._guidance, strict=True)]
        self._courses = [_at_start(uav, way) for uav, way in zip(scenario.uavs, self._guidance, strict=True)]
        self._replan_all(0.0)

    def observe(
        self,
        t: float,
        *,
        movers: Sequence[Sighting | Mapping[str, object]] = (),
        obstacles: Sequence[Shape] = (),
        zones: Sequence[Shape] = (),
        states: Mapping[int, tuple[ArrayLike, ArrayLike]] | None = None,
        targets: Mapping[int, ArrayLike] | None = None,
        deadline_ms: float | None = None,
    ) -> tuple[Replan, ...]:
        """Take in what was seen at an instant, and replan all UAVs, those of higher priority first.

        Parameters
        ----------
        t
            Seconds into the mission. What was seen earlier than the last observation is taken in late.
        movers
            Those that were seen: sightings, or mappings with their fields.
        obstacles
            Those that stand still and were not known before. Where one is in the way, another path is planned. A UAV
            that is too near to one already leaves it.
        zones
            Those that were not known before, with a limit of speed, or times at which they are active.
        states
            Positions and velocities, (3,) metres and (3,) m/s, of UAVs by their indices. One that is farther from where
            it should be than its tracking error, and a centimetre, goes on from where it is.
        targets
            Other targets, (3,) metres, of UAVs by their indices, to which new paths are planned.
        deadline_ms
            Milliseconds after which no further motions are tried; the answers then depend on the clock.

        Returns
        -------
        tuple of Replan
            One for each UAV, in the scenario's order.

        Raises
        ------
        InputError
            If something is not what it should be, no path leads to another target, or the instant lies more than the
            horizon before the last one. Then nothing has changed.
        """
        began = time.perf_counter()
        instant = self._checked_instant(t)
        sightings = [checked_sighting(one, k) for k, one in enumerate(movers)]
        placed = checked_states({} if states is None else states, len(self.scenario.uavs))
        if deadline_ms is not None and not deadline_ms >= 0.0:
            raise InputError(f"expected 0 or more, but it is {deadline_ms!r}", field="deadline_ms")
        places = [course.state(max(instant, self.now))[0] for course in self._courses]
        known = with_seen(Known(self.scenario, self._entered), obstacles, zones, places)
        scenario, assignment = with_targets(known.scenario, self._assignment, {} if targets is None else targets)
        ways = self._ways_to(instant, scenario, assignment, () if targets is None else tuple(targets))
        late, before = instant < self.now, self.scenario
        self.now = max(self.now, instant)
        for sighting in sightings:
            self._tracks.setdefault(sighting.name, Track()).add(instant, sighting)
        self._tracks = {name: track for name, track in self._tracks.items() if self.now - track.last <= self.memory}
        for uav, state in placed.items():
            if not late and strays(self._courses[uav], self.now, state, scenario.uavs[uav].tracking_error):
                self._courses[uav] = self._courses[uav].restarted(self.now, state, self._limits[uav])
        for uav, way in ways.items():
            self._follow(uav, way)
        self._entered, self._assignment = known.entered, assignment
        self._find_ways(scenario, new=known.scenario is not before)
        return self._replan_all(self.lead, math.inf if deadline_ms is None else began + 1e-3 * deadline_ms)

    def _ways_to(
        self, t: float, scenario: Scenario, assignment: Sequence[int | None], uavs: Sequence[int]
    ) -> dict[int, Way]:
        """Return the ways of UAVs to their targets, or raise `InputError` where there is none."""
        found = {}
        for uav in uavs:
            stop = self._courses[uav].stop(max(t, self.now) + self.lead, self._limits[uav])
            way = planned_anew(scenario, uav, assignment[uav], stop)
            if way is None:
                raise InputError(
                    f"no path leads there from {told_point(stop)}, where {scenario.uavs[uav].name} can stop",
                    field=f"targets[{uav}]",
                )
            found[uav] = way
        return found

    def _follow(self, uav: int, way: Way) -> None:
        """Let a UAV follow another way than the mission's from now on."""
        self._planned[uav], self._guidance[uav], self._own[uav] = self.now, way, None
        self._courses[uav] = self._courses[uav].guided_by(way)

    def _replan_all(self, lead: float, deadline: float = math.inf) -> tuple[Replan, ...]:
        """Choose what all UAVs fly from `lead` seconds after now on, those of higher priority first."""
        span, seen = Span(self.now, self.now + lead, self.now + self.horizon), self.predicted()
        middle, uavs = 0.5 * (span.now + span.until), self.scenario.uavs
        moving = {
            error: all_moving(self.scenario, seen, self._entered, error, middle)
            for error in {uav.tracking_error for uav in uavs}
        }
        answers: dict[int, Replan] = {}
        for uav in sorted(range(len(uavs)), key=lambda k: -uavs[k].priority):
            answers[uav] = self._replan(uav, span, moving[uavs[uav].tracking_error], deadline)
        return tuple(answers[uav] for uav in range(len(uavs)))

    def _find_ways(self, scenario: Scenario, new: bool) -> None:
        """Plan the ways of UAVs anew in which something new stands, or from which UAVs have been led too far away."""
        join = self.now + self.lead
        stops = [course.stop(join, limits) for course, limits in zip(self._courses, self._limits, strict=True)]
        if new:
            self._airspace = Airspace(scenario)
        self.scenario = scenario
        for uav, (way, course) in enumerate(zip(self._guidance, self._courses, strict=True)):
            world, mark = self._airspace.of(uav).world, course.next_mark(join)
            ahead = way.after(max(min(mark, len(way.points) - 1) - 1, 0)).points
            barred = new and not world.segments_free(ahead[:-1], ahead[1:]).all()
            lost = self.now - self._planned[uav] >= LOST and not sees(world, stops[uav], way, mark)
            if barred or lost:
                self._planned[uav] = self.now
                found = planned_anew(scenario, uav, self._assignment[uav], stops[uav])
                if found is not None:
                    self._follow(uav, found)

    def _checked_instant(self, t: float) -> float:
        """Return the instant of an observation, or raise `InputError`."""
        if isinstance(t, bool) or not isinstance(t, int | float | np.number) or not 0.0 <= t <= MAX_INSTANT:
            raise InputError(f"expected seconds into the mission, from 0 on, but it is {t!r}", field="t")
        if t < self.now - self.horizon:
            back = f"{self.now:.6g} s to {t:.6g} s"
            raise InputError(f"the clock was set back from {back}, by more than the horizon", field="t")
        return float(t)

    def motion(self, uav: int) -> Trajectory:
        """Return what a UAV flies from now on, to rest; it begins at or shortly before now."""
        return self._courses[uav].motion

    def flown(self, uav: int) -> Trajectory:
        """Return what a UAV has flown since the mission began, and will fly if nothing is observed any more."""
        course = self._courses[uav]
        return joined([*course.flown, course.motion])

    def arrival(self, uav: int) -> float | None:
        """Return the instant at which a UAV's motion ends at its target, seconds; ``None`` if it ends elsewhere."""
        motion = self._courses[uav].motion
        off = np.linalg.norm(motion.at([motion.end]).position[0] - self._guidance[uav].points[-1])
        return motion.end if off <= 1e-6 else None

    def predicted(self) -> tuple[Mover, ...]:
        """Return the movers that were seen, with all that they may do up to the horizon."""
        until = self.now + self.horizon
        return tuple(track.predicted(until) for track in self._tracks.values())

    def _replan(self, uav: int, span: Span, moving: Moving, deadline: float) -> Replan:
        """Choose what a UAV flies from now on, among what moves."""
        began = time.perf_counter()
        others = {k: course for k, course in enumerate(self._courses) if k != uav}
        around = Surroundings(
            limits=self._limits[uav],
            world=self._airspace.of(uav).world,
            moving=with_others(moving, self.scenario, uav, others),
            uavs=len(moving.names),
            guidance=self._guidance[uav],
            planned=self._own[uav],
        )
        choice = choose_course(self._courses[uav].since(span.now), around, span, self.candidates, deadline)
        self._courses[uav] = choice.course
        return Replan(
            time=self.now,
            uav=uav,
            kept=choice.kept,
            proven=choice.proven,
            clear_until=min(choice.contact, span.until),
            sentence=_sentence(self.scenario.uavs[uav].name, choice, around, span),
            tried=choice.tried,
            seconds=time.perf_counter() - began,
        )


def _sentence(name: str, choice: Choice, around: Surroundings, span: Span) -> str:
    """Return what is proven of a UAV's motion, or which mover it may come too near to, when and where."""
    if choice.proven:
        return f"{name} has a way out, clear of everything until t = {span.until:.6g} s."
    if choice.mover < 0:
        return f"{name} has no way out that is proven clear of what stands still."
    at, whom = told_point(choice.course.state(choice.contact)[0]), around.moving.names[choice.mover]
    return f"{name} has no way out: {whom} may come too near at t = {choice.contact:.6g} s, at {at}."


def _at_start(uav: UAV, way: Way) -> Course:
    """Return the course of a UAV that hovers at its start, from 0 s on."""
    motion = rest_to_rest(np.array([uav.start]), uav)
    return Course((), motion, way.after(1), np.full(len(way.points) - 1, np.inf), 1, leaves=0.0)


def _refuse_what_is_not_replanned(mission: Mission) -> None:
    """Raise `InputError` where a mission has what is not replanned yet."""
    for uav in mission.scenario.uavs:
        if uav.fixed_wing is not None:
            raise InputError(f"{uav.name} is an aeroplane; only multirotors are replanned in flight", field="mission")
