"""A mission in flight whose UAVs find their ways by a policy; motions are made and proven as a replanner does."""

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skyverse.live.course import Course
from skyverse.live.first_proven import first_proven
from skyverse.live.guidance import SHARES
from skyverse.live.multirotor import Multirotor
from skyverse.live.observed import Known, with_seen
from skyverse.live.policies.policy import Found, Policy, Situation
from skyverse.live.replan import Replan, Span, in_turns
from skyverse.live.surroundings import Moving, Surroundings, all_moving, with_others
from skyverse.live.tracks import Sighting, Tracks
from skyverse.model.kept_ellipsoid import kept_ellipsoid
from skyverse.model.mission import Mission
from skyverse.model.mover import Doubt, Ellipsoid, Mover
from skyverse.model.mover_motions import PolynomialMotion
from skyverse.model.result import Effort
from skyverse.model.shapes import Shape
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.problem import Airspace
from skyverse.space.timed_shapes import TimedShape
from skyverse.trajectory.limits import limits_of


class PolicyFlight:
    """A mission in flight whose UAVs find their ways by a policy.

    The policy's way is tried at several speeds, also by way of the place where the UAV would come to rest. What is
    flown keeps the UAV's limits, ends at rest within the horizon, and is proven clear of what stands still and of
    wherever movers may be up to the horizon; where nothing new is proven, the UAV goes on with what was proven last,
    and so comes to rest. A policy that needs no proof is believed.

    Parameters
    ----------
    mission
        Of multirotors, in a scenario without movers.
    policy
        Finds the ways.
    horizon, lead, memory
        As those of a `Replanner`, seconds.
    rng
        The source of the policy's random numbers.

    Attributes
    ----------
    mission, policy, horizon, lead
        As given.
    scenario
        What is known, with the obstacles that were seen.
    now
        The instant of the last observation, seconds into the mission.
    effort
        What the policy has spent in all.
    """

    def __init__(
        self,
        mission: Mission,
        policy: Policy,
        *,
        horizon: float,
        lead: float,
        memory: float,
        rng: np.random.Generator,
    ) -> None:
        scenario = mission.scenario
        self.mission, self.policy, self.scenario = mission, policy, scenario
        self.horizon, self.lead, self._rng = horizon, lead, rng
        self.now, self.effort = 0.0, Effort(0, 0, 0)
        self._airspace = Airspace(scenario)
        self._tracks = Tracks(memory)
        self._entered: tuple[Shape, ...] = ()
        self._pilots = [Multirotor.at_start(self._airspace, mission, uav) for uav in range(len(scenario.uavs))]
        self._memories: list[object] = [None] * len(scenario.uavs)

    def observe(
        self, t: float, *, movers: Sequence[Sighting], obstacles: Sequence[Shape] = (), gone: Sequence[str] = ()
    ) -> tuple[Replan, ...]:
        """Take in what was seen at an instant, and replan all UAVs, those of higher priority first.

        Parameters
        ----------
        t
            Seconds into the mission, later than at the last observation.
        movers, obstacles
            Those that were seen.
        gone
            Names of movers that are known to be far away.
        """
        self.now = t
        self._tracks.add(t, movers)
        forgotten = self._tracks.forget(t, gone, [one.reached(t, self.horizon, self.scenario) for one in self._pilots])
        self._take_in(obstacles)
        seen, uavs = self.predicted(), self.scenario.uavs
        span = Span(t, t + self.lead, t + self.horizon, t + self.horizon)
        moving = {
            error: all_moving(self.scenario, seen, self._entered, error, span)
            for error in {uav.tracking_error for uav in uavs}
        }
        order = sorted(range(len(uavs)), key=lambda k: -uavs[k].priority)
        answers = in_turns(order, lambda k: self._replan(k, span, seen, moving[uavs[k].tracking_error]))
        return tuple(replace(answers[uav], forgotten=forgotten) for uav in range(len(uavs)))

    def predicted(self) -> tuple[Mover, ...]:
        """Return the movers that were seen, with all that they may do up to the horizon."""
        return self._tracks.predicted(self.now + self.horizon)

    def motion(self, uav: int) -> Trajectory:
        """Return what a UAV flies from now on, to rest; it begins at or shortly before now."""
        return self._pilots[uav].motion

    def flown(self, uav: int) -> Trajectory:
        """Return what a UAV has flown since the mission began, and will fly if nothing is observed any more."""
        return self._pilots[uav].flown

    def arrival(self, uav: int) -> float | None:
        """Return the instant at which a UAV's motion ends at its target, seconds; ``None`` if it ends elsewhere."""
        return self._pilots[uav].arrival

    def _take_in(self, obstacles: Sequence[Shape]) -> None:
        """Take in obstacles, and plan the mission's ways anew where one of them is in the way."""
        places = [pilot.state(self.now)[0] for pilot in self._pilots]
        known = with_seen(Known(self.scenario, self._entered), obstacles, (), places)
        self._entered = known.entered
        if known.scenario is self.scenario:
            return
        self.scenario, self._airspace = known.scenario, Airspace(known.scenario)
        join = self.now + self.lead
        for uav, pilot in enumerate(self._pilots):
            if pilot.needs_a_way(self._airspace.of(uav).world, True, self.now, join):
                found = pilot.led_to(self.scenario, self.mission.assignment[uav], self.now, join)
                if found is not None:
                    self._pilots[uav], self._memories[uav] = found, None

    def _replan(self, uav: int, span: Span, seen: Sequence[Mover], moving: Moving) -> Replan:
        """Ask the policy for a way of one UAV, and choose what it flies."""
        began = time.perf_counter()
        course, limits = self._pilots[uav].course.since(span.now), limits_of(self.scenario.uavs[uav], -LIMIT_MARGIN)
        others = {k: pilot.occupied for k, pilot in enumerate(self._pilots) if k != uav}
        around = Surroundings(
            limits=limits,
            world=self._airspace.of(uav).world,
            moving=with_others(moving, self.scenario, uav, others),
            uavs=len(moving.names),
        )
        found = self._found(uav, course, seen, span)
        ways, stop = [], course.stop(span.join, limits)
        if found.way is not None and len(found.way.points):
            ways = [found.way, found.way.through(0, stop, 0.0)]
        shares = [share * found.share for share in SHARES]
        course, choice = first_proven(course, around, span, ways, shares, self.policy.needs_proof)
        pilot = self._pilots[uav]
        self._pilots[uav] = replace(pilot, course=course) if choice.kept else pilot.flying(course, span.join)
        met = "" if choice.mover < 0 else f": {around.moving.names[choice.mover]} may come too near"
        name = self.scenario.uavs[uav].name
        told = f"{name} has a way out." if choice.proven else f"{name} has no proven way out{met}."
        return Replan(
            time=self.now,
            uav=uav,
            kept=choice.kept,
            proven=choice.proven,
            clear_until=min(choice.contact, span.until),
            mover="" if choice.proven or choice.mover < 0 else around.moving.names[choice.mover],
            sentence=told,
            tried=choice.tried,
            seconds=time.perf_counter() - began,
        )

    def _found(self, uav: int, course: Course, seen: Sequence[Mover], span: Span) -> Found:
        """Ask the policy for a way of one UAV."""
        target = self.mission.assignment[uav]
        if target is None:
            return Found(None, Effort(0, 0, 0))
        guidance = self._pilots[uav].guidance
        ahead = guidance.after(min(course.next_mark(span.join), len(guidance.points) - 1))
        found = self.policy.find(
            Situation(
                scenario=self.scenario,
                uav=uav,
                target=target,
                world=self._airspace.of(uav).world,
                now=span.now,
                join=span.join,
                until=span.until,
                state=course.state(span.join),
                stop=self._pilots[uav].turning_place(span.join),
                movers=self._movers(uav, seen),
                guidance=ahead,
                memory=self._memories[uav],
                rng=self._rng,
            )
        )
        self._memories[uav] = found.memory
        spent = self.effort
        self.effort = Effort(
            spent.generated_paths + found.effort.generated_paths,
            spent.generated_nodes + found.effort.generated_nodes,
            spent.evaluations + found.effort.evaluations,
        )
        return found

    def _movers(self, uav: int, seen: Sequence[Mover]) -> tuple[TimedShape, ...]:
        """Return what a UAV's policy is told of what moves: movers that were seen, and the other UAVs' motions."""
        known = [TimedShape(mover.shape, mover.motion, mover.doubt, self.scenario.clearance) for mover in seen]
        for other, pilot in enumerate(self._pilots):
            across, above = kept_ellipsoid(self.scenario.uavs[uav], self.scenario.uavs[other])
            if other != uav and across > 0.0:
                motion = pilot.course.motion
                moves = PolynomialMotion(knots=tuple(motion.knots), coefficients=motion.coefficients.tolist())
                shape = Ellipsoid(centre=(0, 0, 0), semi_axis_xy=across, semi_axis_z=above)
                known.append(TimedShape(shape, moves, Doubt(), 0.0))
        return tuple(known)
