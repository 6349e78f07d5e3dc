"""A mission in flight: what is seen comes in, and motions that are proven to have a way out go out."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind, require_number, require_whole
from skyverse.live.aeroplane import Aeroplane
from skyverse.live.lead_apart import LeadApart
from skyverse.live.multirotor import Multirotor
from skyverse.live.observed import Fix, checked_states, checked_targets, strays, with_seen, with_targets
from skyverse.live.pilot import SPARE, Pilot
from skyverse.live.policies import policy_of
from skyverse.live.policies.policy import Found, Policy, Situation, all_about
from skyverse.live.replan import Replan, in_turns
from skyverse.live.search import Choice
from skyverse.live.stops import flown_sorties
from skyverse.live.surroundings import Moving, Span, Surroundings, all_moving, with_others
from skyverse.live.tracks import Sighting, Tracks, checked_sightings
from skyverse.model.geodesy import told_place
from skyverse.model.mission import Mission
from skyverse.model.mover import Mover
from skyverse.model.quantities import MAX_INSTANT
from skyverse.model.result import Effort
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape
from skyverse.model.short_lines import told_metres
from skyverse.model.sortie import Sortie
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import LIMIT_MARGIN
from skyverse.planners.base import Seed, seeded
from skyverse.problem import Airspace
from skyverse.trajectory.limits import limits_of

LONGEST_LEAP = 5.0
"""Seconds after the last observation; a later one counts only if another one agrees, since a clock may be wrong."""
LEAST_MEMORY = 3.0
"""Seconds for which a mover stays that is not seen again, by default, unless the horizon is longer."""
LEAST_LEAD = 1e-3
"""Seconds in which an answer is found at the soonest; the horizon is at least as much longer than the lead."""
LONGEST_HORIZON = 600.0
"""Seconds up to which motions are proven at most."""


class Replanner:
    """A mission in flight: it takes in what is seen, and answers with the motions to fly from now on.

    Each motion joins the one before with continuous position, velocity and acceleration, keeps the UAV's limits, and
    ends at rest within the horizon. It is flown only if it is proven clear of what stands still, and up to the horizon
    of wherever movers may be: so there is a way out at every instant, whether or not anything is observed again.

    Aeroplanes, which cannot rest, loiter instead: their motions join with continuous position and velocity, and end in
    a full level circle, or at the target where there is no room for one. All of that is clear of what stands still.

    Parameters
    ----------
    mission
        UAVs fly its trajectories, from 0 s on, as long as these are proven to have a way out at every instant. A
        multirotor that has left its trajectory flies along its path, as fast as it can; an aeroplane gets back to it.
    horizon
        Seconds from an observation up to which motions are proven. By default, for multirotors half a second more than
        one of them takes at most to come to rest, and for aeroplanes half a second more than the longest full turn.
    lead
        Seconds from an observation at which a new motion begins: so long the answer may take.
    memory
        Seconds for which a mover that is not seen again stays in any case, at least the horizon; by default that, or 3.
        Later it is forgotten once it may be anywhere where UAVs can be by the horizon.
    candidates
        How many motions are tried for a UAV at most at each observation.
    policy
        Finds the ways of multirotors anew, in place of those along the mission's path and past movers; motions along
        them are made and proven as else. Given by its name, ``"velocity-obstacles"``, or with settings, as in study
        files: ``{"policy": "from-scratch", "planner": "astar"}``.
    rng
        Seed or generator of the policy's random numbers.

    Attributes
    ----------
    mission, policy
        The mission as given, and the policy, or ``None``.
    scenario
        What is known, with the obstacles that were seen.
    now
        The instant of the last observation, seconds into the mission.
    horizon, lead, memory, candidates
        As given, or their defaults; the horizon is that of aeroplanes if there are any.
    effort
        What finding ways has taken in all: that of the policy, or how many motions were made.

    Raises
    ------
    InputError
        If an argument is out of range.
    """

    def __init__(
        self,
        mission: Mission,
        *,
        horizon: float | None = None,
        lead: float = 0.1,
        memory: float | None = None,
        candidates: int = 128,
        policy: Policy | str | Mapping[str, object] | None = None,
        rng: Seed = None,
    ) -> None:
        require_kind(mission, Mission, "mission")
        scenario = mission.scenario
        require_number(lead, "lead", "seconds", LEAST_LEAD, LONGEST_HORIZON)
        self._horizons = _horizons(scenario, lead) if horizon is None else (horizon,) * len(scenario.uavs)
        self.horizon = max(self._horizons) if horizon is None else horizon
        require_number(self.horizon, "horizon", "seconds", lead + LEAST_LEAD, LONGEST_HORIZON)
        memory = max(LEAST_MEMORY, self.horizon) if memory is None else memory
        require_number(memory, "memory", "seconds, at least the horizon,", self.horizon, MAX_INSTANT)
        require_whole(candidates, "candidates", 1)
        self.lead, self.memory, self.candidates = lead, memory, candidates
        if policy is not None and any(uav.fixed_wing is not None for uav in scenario.uavs):
            raise InputError("expected multirotors with a policy, found an aeroplane", field="policy")
        if policy is not None and mission.sorties:
            raise InputError("expected no policy with tours, which only the default replanning flies", field="policy")
        self.policy = None if policy is None else policy_of(policy)
        self.effort, self._rng = Effort(0, 0, 0), seeded(rng)[0]
        self.mission, self.scenario, self.now = mission, scenario, 0.0
        self._airspace = Airspace(scenario)
        self._tracks = Tracks(memory)
        self._leapt = -math.inf
        self._fixes = dict.fromkeys(range(len(scenario.uavs)), Fix())
        self._targeted: dict[int, float] = {}
        self._entered: tuple[Shape, ...] = ()
        self._assignment = tuple(mission.assignment)
        self._lead_apart = LeadApart()
        kinds = map(_kind_of, scenario.uavs)
        self._pilots = [kind.at_start(self._airspace, mission, number) for number, kind in enumerate(kinds)]
        if policy is None:  # policies are asked with the first observation
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
        gone: Sequence[str] = (),
        deadline_ms: float | None = None,
    ) -> tuple[Replan, ...]:
        """Take in what was seen at an instant, and replan all UAVs, those of higher priority first.

        What comes late counts for its instant: what was seen or told of a later one stands.

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
            it should be than its tracking error, and a centimetre, or will be within the lead by its velocity, goes on
            from there with that velocity; those of all others are not used. A late state is carried on to now by its
            velocity; if the UAV may have accelerated farther off than that meanwhile, nothing is proven of it until it
            is found again.
        targets
            Other targets, (3,) metres, of UAVs by their indices, to which new paths are planned.
        gone
            Names of movers that were seen before, whose places were seen empty; nothing more is expected of them,
            unless they were seen at this instant or later.
        deadline_ms
            Milliseconds after which no further motions are tried; the answers then depend on the clock. Without it, an
            answer may wait for the mission that leads multirotors apart, if that takes more than 2 s to plan.

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
        for field, given in (("movers", movers), ("obstacles", obstacles), ("zones", zones), ("gone", gone)):
            require_kind(given, (list, tuple), field)
        sightings = checked_sightings(movers)
        self._tracks.require_seen(gone, sightings)
        placed = checked_states({} if states is None else states, len(self.scenario.uavs))
        for uav, state in placed.items():
            self._pilots[uav].checked_state(state)
        wanted = checked_targets({} if targets is None else targets, self.scenario.uavs)
        wanted = {uav: one for uav, one in wanted.items() if instant >= self._targeted.get(uav, 0.0)}
        if deadline_ms is not None:
            require_number(deadline_ms, "deadline_ms", "milliseconds", 0.0)
        now, before = max(instant, self.now), self.scenario
        pilots, fixes = self._found_at(now, instant, placed)
        places = [pilot.state(now)[0] for pilot in pilots]
        known, entered = with_seen(before, self._entered, obstacles, zones, places)
        scenario, assignment = with_targets(known, self._assignment, wanted)
        for uav in wanted:
            pilots[uav] = self._led_to(scenario, assignment[uav], pilots[uav], now)
        self.now, self._fixes = now, fixes
        self._targeted |= dict.fromkeys(wanted, instant)
        self._tracks.add(instant, sightings)
        self._tracks.leave(instant, gone)
        reached = [pilot.reached(now, h, scenario) for pilot, h in zip(pilots, self._horizons, strict=True)]
        forgotten = self._tracks.forget(now, reached)
        self._pilots = [pilot.freed() for pilot in pilots] if gone or forgotten else pilots
        self._entered, self._assignment = entered, assignment
        self._find_ways(scenario, new=known is not before)
        self._pilots = self._lead_apart.led(self._pilots, scenario, now, now + self.lead, deadline_ms is None)
        answers = self._replan_all(self.lead, math.inf if deadline_ms is None else began + 1e-3 * deadline_ms)
        return tuple(replace(answer, forgotten=forgotten) for answer in answers)

    def _found_at(self, now: float, instant: float, states: Mapping[int, Floats]) -> tuple[list[Pilot], dict[int, Fix]]:
        """Return all pilots, those that were off their courses at an instant as found, and where UAVs were found."""
        pilots, fixes = list(self._pilots), dict(self._fixes)
        for uav, state in states.items():
            pilot, before = pilots[uav], fixes[uav]
            if instant < now and instant <= before.t:
                continue
            error = pilot.uav.tracking_error
            followed = instant >= before.since
            course = pilot.state(instant) if followed else before.at(instant)
            fix = Fix(instant, state, before.since, before.flies or followed)
            if strays(state, course, error, self.lead):
                here = fix.at(now)
                pilots[uav] = pilot.restarted(now, here)
                flies = not strays(here, pilots[uav].state(now), error, self.lead)
                fix = Fix(instant, state, now, flies)
            fixes[uav] = fix
        return pilots, fixes

    def _led_to(self, scenario: Scenario, target: int | None, pilot: Pilot, now: float) -> Pilot:
        """Return the pilot on a way to a target, or raise `InputError` where there is none."""
        name, field = pilot.uav.name, f"targets[{pilot.number}]"
        if self.mission.sorties:
            raise InputError(f"{name} is on a tour, whose targets are not changed in flight", field=field)
        if pilot.ended:
            said = f"{name} has ended its mission at its target, where it had no room to loiter"
            raise InputError(f"{said}; it flies on only from a state in which it was seen to fly", field=field)
        found = pilot.led_to(scenario, target, now, now + self.lead)
        if found is None:
            place = told_place(scenario.frame.origin, pilot.turning_place(now + self.lead))
            raise InputError(f"no path leads there from {place}, where {name} {pilot.turns}", field=field)
        return found

    def _replan_all(self, lead: float, deadline: float = math.inf) -> tuple[Replan, ...]:
        """Choose what all UAVs fly from `lead` seconds after now on, those of higher priority first."""
        pilots = zip(self._pilots, self._horizons, strict=True)
        horizons = [self.now + pilot.horizon(self.now, longest, self.lead) for pilot, longest in pilots]
        spans = [Span(self.now, self.now + lead, until, self.now + self.horizon) for until in horizons]
        kinds = {(uav.tracking_error, span) for uav, span in zip(self.scenario.uavs, spans, strict=True)}
        moving = {
            (error, span): all_moving(self.scenario, self._tracks.predicted(span.until), self._entered, error, span)
            for error, span in kinds
        }
        order = sorted(range(len(spans)), key=lambda k: -self.scenario.uavs[k].priority)
        uavs = self.scenario.uavs
        answers = in_turns(
            order, lambda k: self._replan(k, spans[k], moving[uavs[k].tracking_error, spans[k]], deadline)
        )
        return tuple(answers[uav] for uav in range(len(spans)))

    def _find_ways(self, scenario: Scenario, new: bool) -> None:
        """Plan the ways of UAVs anew in which something new stands, or which they cannot follow any more."""
        join = self.now + self.lead
        if new:
            self._airspace = Airspace(scenario)
        self.scenario = scenario
        for number, before in enumerate(self._pilots):
            self._pilots[number] = pilot = before.toured(join)
            other = new or pilot is not before
            if pilot.needs_a_way(self._airspace.of(number).world, other, self.now, join):
                found = pilot.led_to(scenario, self._assignment[number], self.now, join)
                self._pilots[number] = replace(pilot, planned=self.now) if found is None else found

    def _checked_instant(self, t: float) -> float:
        """Return the instant of an observation, or raise `InputError`."""
        require_number(t, "t", "seconds into the mission", 0.0, MAX_INSTANT)
        leapt, self._leapt = self._leapt, -math.inf
        if t < self.now - self.horizon:
            back = f"{self.now:.6g} s to {t:.6g} s"
            raise InputError(f"the clock was set back from {back}, by more than the horizon", field="t")
        agrees = 0.0 <= t - leapt <= max(LONGEST_LEAP, leapt - self.now)
        if t > self.now + LONGEST_LEAP and not agrees:
            self._leapt = float(t)
            ahead = f"{self.now:.6g} s to {t:.6g} s, by more than {LONGEST_LEAP:g} s"
            raise InputError(f"the clock went ahead from {ahead}; a next observation that agrees is taken", field="t")
        return float(t)

    def motion(self, uav: int) -> Trajectory:
        """Return what a UAV flies from now on; it begins at or shortly before now, or when the UAV departs.

        That of a multirotor ends at rest. That of an aeroplane ends after a full turn, or where its mission does.
        """
        return self._pilot(uav).motion

    def flown(self, uav: int) -> Trajectory:
        """Return what a UAV has flown since the mission began, and will fly if nothing is observed any more.

        That of an aeroplane ends where it passes its target, if its motion does.
        """
        return self._pilot(uav).flown

    def arrival(self, uav: int) -> float | None:
        """Return the instant at which a UAV's motion reaches its target, seconds; ``None`` if it does not.

        A multirotor comes to rest there, an aeroplane passes it.
        """
        return self._pilot(uav).arrival

    def sorties(self, uav: int) -> tuple[Sortie, ...]:
        """Return the sorties of a UAV's tour as far as they were flown, with the visits of stops that it has left."""
        pilot = self._pilot(uav)
        if not isinstance(pilot, Multirotor) or not self.mission.sorties:
            return ()
        return flown_sorties(self.mission.sorties[uav], pilot.left, returns=pilot.uav.end == "home")

    def _pilot(self, uav: int) -> Pilot:
        require_whole(uav, "uav", 0, len(self._pilots) - 1)
        return self._pilots[uav]

    def predicted(self) -> tuple[Mover, ...]:
        """Return the movers that were seen, with all that they may do up to the horizon."""
        return self._tracks.predicted(self.now + self.horizon)

    def _replan(self, uav: int, span: Span, moving: Moving, deadline: float) -> Replan:
        """Choose what a UAV flies from now on, among what moves."""
        began = time.perf_counter()
        others = {k: pilot.occupied for k, pilot in enumerate(self._pilots) if k != uav}
        around = Surroundings(
            limits=limits_of(self.scenario.uavs[uav], -LIMIT_MARGIN, self.scenario.winds),
            world=self._airspace.of(uav).world,
            moving=with_others(moving, self.scenario, uav, others),
            uavs=len(moving.names),
            span=span,
            motions=self.candidates,
            deadline=deadline,
        )
        pilot = self._pilots[uav]
        answer = self._asked(pilot, around) if isinstance(pilot, Multirotor) else None
        pilot, choice = pilot.choose(around, answer)
        self._pilots[uav] = pilot
        self.effort += answer.effort if answer is not None else Effort(0, 0, choice.tried)
        out = _out_of_bounds(pilot.state(self.now)[0], self.scenario)
        doubt = self._fixes[uav].doubt(pilot.uav, self.lead)
        proven = choice.proven and not doubt
        sentence = _sentence(pilot, choice, around)
        if choice.proven and not proven:
            sentence = f"{pilot.uav.name} has no way out: it {doubt}."
        return Replan(
            time=self.now,
            uav=uav,
            kept=choice.kept,
            proven=proven,
            clear_until=min(choice.contact.instant, span.until) if proven or not choice.proven else self.now,
            mover="" if choice.proven or choice.contact.mover < 0 else around.moving.names[choice.contact.mover],
            sentence=sentence + (f" It is {told_metres(out)} out of bounds." if out > 0.0 else ""),
            tried=choice.tried,
            seconds=time.perf_counter() - began,
            out_of_bounds=out,
        )

    def _asked(self, pilot: Multirotor, around: Surroundings) -> Found | None:
        """Return what the policy finds for a UAV; ``None`` if there is none to ask."""
        span = around.span
        target = self._assignment[pilot.number]
        if self.policy is None:
            return None
        if target is None:
            return Found(None, Effort(0, 0, 0))
        motions = [other.motion for other in self._pilots]
        return self.policy.find(
            Situation(
                scenario=self.scenario,
                uav=pilot.number,
                target=target,
                world=around.world,
                span=span,
                state=pilot.state(span.join),
                stop=pilot.turning_place(span.join),
                movers=all_about(self.scenario, pilot.number, self._tracks.predicted(span.until), motions),
                guidance=pilot.guidance.after(pilot.next_mark(span.join)),
                memory=pilot.memory,
                rng=self._rng,
            )
        )


def _out_of_bounds(place: Floats, scenario: Scenario) -> float:
    """Return how far a place (3,) is out of bounds, metres; 0 within."""
    return math.dist(place, np.clip(place, scenario.bounds.min, scenario.bounds.max))


def _sentence(pilot: Pilot, choice: Choice, around: Surroundings) -> str:
    """Return what is proven of a UAV's motion, or which mover it may come too near to, when and where."""
    name = pilot.uav.name
    if choice.proven:
        return f"{name} {pilot.way_out}, clear of everything until t = {around.span.until:.6g} s."
    if choice.contact.mover < 0:
        return f"{name} has no way out that is proven clear of what stands still, and slow enough in zones."
    whom = around.moving.names[choice.contact.mover]
    at = told_place(around.world.scenario.frame.origin, pilot.state(choice.contact.instant)[0])
    told = f"{whom} may come too near at t = {choice.contact.instant:.6g} s, at {at}"
    if choice.contact.instant <= around.span.join:  # whatever it flies then
        return f"{name} has no way out: {told}, before another motion can begin."
    return f"{name} has no way out that was found among {max(choice.tried, 1)} motions: {told}."


def _kind_of(uav: UAV) -> type[Pilot]:
    return Multirotor if uav.fixed_wing is None else Aeroplane


def _horizons(scenario: Scenario, lead: float) -> tuple[float, ...]:
    """Return the seconds up to which motions of UAVs are proven, one for all multirotors, and one for all aeroplanes.

    They are half a second more than the UAV that takes longest needs to come to rest, or to fly a full turn.
    """
    kinds = [_kind_of(uav) for uav in scenario.uavs]
    needed = [kind.seconds_of_way_out(uav) for kind, uav in zip(kinds, scenario.uavs, strict=True)]
    longest = {kind: max(s for other, s in zip(kinds, needed, strict=True) if other is kind) for kind in set(kinds)}
    return tuple(longest[kind] + lead + SPARE for kind in kinds)
