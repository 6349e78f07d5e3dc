"""Judges a mission, or the result of one of its UAVs: who is sent where, what each flies, and what is proven of it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from skyverse.errors import require_kind
from skyverse.interrupt import raise_if_interrupted
from skyverse.model.coverage import Coverage
from skyverse.model.mission import Mission, index_of
from skyverse.model.pad import Pad
from skyverse.model.power import JOULES_OF_WATT_HOUR
from skyverse.model.quantities import short
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import as_lines, counted
from skyverse.model.take_off import take_off
from skyverse.model.timed_shapes import is_closed_at_times
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation, with_global_places
from skyverse.referee.assignment import judge_assignment
from skyverse.referee.curve import PolynomialCurve, curve_of
from skyverse.referee.energy import judge_battery
from skyverse.referee.fleet_motion import judged_until
from skyverse.referee.pads import pads_of, pads_sentence
from skyverse.referee.result import judge_result
from skyverse.referee.separation import judge_separation
from skyverse.referee.sorties import judge_sorties, makes_tours, sound_sorties, spans_of, tour_of, tour_to
from skyverse.referee.strips import judge_strips, judge_surveys
from skyverse.referee.timed_shapes import judge_movers
from skyverse.referee.tracking_error import EXACT
from skyverse.referee.trajectory import judge_trajectory
from skyverse.referee.untrusted import entry
from skyverse.referee.world import RefereeWorlds

MAX_SHOWN = 4
"""Sentences at most that the prompt shows of what is not proven."""


class Certificates(NamedTuple):
    """What is proven of a mission.

    The certificate of each UAV's trajectory stands in the scenario's order, ``None`` where a UAV has no trajectory;
    beside them stand the certificate of the fleet's separation, and what is proven of the photos of each survey.
    """

    trajectories: tuple[Certificate | None, ...]
    apart: Certificate
    coverage: tuple[Coverage, ...] = ()

    def __repr__(self) -> str:
        flying = [one for one in self.trajectories if one is not None]
        proven = sum(one.verdict.value == "proven" for one in flying)
        judged: list[Certificate | Coverage] = [*flying, self.apart, *self.coverage]
        wrong = [one.sentence for one in judged if one.verdict.value != "proven"]
        surveys = [one.verdict.value for one in self.coverage]
        return as_lines(
            f"Certificates: {proven} of {counted(len(flying), 'trajectory', 'trajectories')} proven, "
            f"separation {self.apart.verdict.value}{', coverage ' if surveys else ''}{' and '.join(surveys)}",
            *wrong[:MAX_SHOWN],
            f"... and {len(wrong) - MAX_SHOWN} more" if len(wrong) > MAX_SHOWN else "",
        )


class JudgedFleet(NamedTuple):
    """The certificates, and what is behind them: what is wrong with trajectories, and with the separation."""

    certificates: Certificates
    trajectories: list[list[Violation]]
    apart: list[Violation]


def certify(scenario: Scenario, mission: Mission) -> Certificates:
    """Say of each trajectory, and of the fleet's separation, whether it is proven, refuted or undecided.

    What is proven holds at every instant, not only at samples: the UAV keeps the clearance from every obstacle, stays
    inside the bounds and within all its limits, flies without a jump from its start to its target, and stays out of the
    ellipsoids of all other UAVs, also before it starts and after it has arrived. Pieces of trajectories are bounded by
    their Bernstein coefficients, rounding included, and cut in two until they are decided. What is wrong by at most
    1e-6 m, or 1e-6 of a limit, is let pass.

    Parameters
    ----------
    scenario
        What was given.
    mission
        What is judged; the certificates that it carries are ignored. However malformed it is, nothing is raised.

    Returns
    -------
    Certificates
        A certificate that is refuted names the worst instant of the first thing that is wrong.
    """
    require_kind(mission, Mission, "mission")
    with np.errstate(all="ignore"):
        return judge_fleet(RefereeWorlds(scenario), mission).certificates


def judge_fleet(worlds: RefereeWorlds, mission: Mission) -> JudgedFleet:
    """Judge all trajectories of a mission, and the fleet's separation."""
    scenario = worlds.scenario
    count, digest = len(scenario.uavs), scenario.digest
    tours = [tour_of(scenario, mission, uav) for uav in range(count)]
    curves: list[PolynomialCurve | None] = [None] * count
    unknown: set[int] = set()
    violations: list[list[Violation]] = [[] for _ in range(count)]
    halvings = [0] * count
    for uav in range(count):
        raise_if_interrupted()
        trajectory = entry(mission.trajectories, uav)
        if not isinstance(trajectory, Trajectory):
            continue
        violations[uav], halvings[uav] = judge_trajectory(worlds.of(uav), uav, tours[uav], trajectory)
        curve = curve_of(trajectory)
        if isinstance(curve, str):
            unknown.add(uav)
        else:
            curves[uav] = curve
            violations[uav] += judge_battery(scenario, uav, trajectory, spans_of(mission, uav, curve))
            if makes_tours(scenario, mission):
                violations[uav] += judge_sorties(scenario, mission, uav, trajectory, curve)
                violations[uav] += judge_strips(scenario, mission, uav, trajectory)
    in_time = judge_movers(scenario, curves, unknown)
    certificates: list[Certificate | None] = [None] * count
    for uav in range(count):
        violations[uav] = with_global_places(scenario.frame, [*violations[uav], *in_time[uav].violations])
        if isinstance(entry(mission.trajectories, uav), Trajectory):
            pads = pads_of(worlds.of(uav), uav, tours[uav])
            sentence = _proven_sentence(scenario, digest, uav, curves, pads) + _landings(scenario, mission, uav)
            cuts = halvings[uav] + in_time[uav].halvings
            certificates[uav] = _certificate(digest, violations[uav], sentence, cuts)
    separation = judge_separation(scenario, [tour.end for tour in tours], curves, unknown)
    close = with_global_places(scenario.frame, separation.violations)
    sentence = f"All {count} UAVs keep their separation from one another at every instant, {_where(scenario, digest)}"
    if any(uav.tracking_error != EXACT for uav in scenario.uavs):
        sentence += ", in every flight of theirs within their tracking errors"
    sentence += "."
    if any(_landings(scenario, mission, uav) for uav in range(count)):
        sentence += " Landings between sorties, straight below starts, are not judged."
    apart = _certificate(digest, close, sentence, separation.halvings)
    if unknown and apart.verdict is Verdict.PROVEN:
        names = ", ".join(scenario.uavs[uav].name for uav in sorted(unknown))
        apart = Certificate(Verdict.UNDECIDED, f"There is no telling where {names} would fly.", scenario=digest)
    coverage = judge_surveys(scenario, mission)
    return JudgedFleet(Certificates(tuple(certificates), apart, coverage), violations, close)


def _proven_sentence(
    scenario: Scenario, digest: str, uav: int, curves: Sequence[PolynomialCurve | None], pads: list[tuple[str, Pad]]
) -> str:
    vehicle, curve = scenario.uavs[uav], curves[uav]
    knots = np.zeros(2) if curve is None else curve.knots
    limits = ["speed", "acceleration"]
    limits += ["jerk", "thrust", "tilt", "yaw"] if vehicle.fixed_wing is None else ["airspeed", "turn", "climb"]
    rates = (("climb rate", vehicle.max_climb), ("descent rate", vehicle.max_descent))
    limits += [noun for noun, most in rates if most is not None]
    if vehicle.max_airspeed is not None or scenario.wind is not None:
        limits += ["speed through the air"] if vehicle.fixed_wing is None else []
    kept = f"{', '.join(limits[:-1])} and {limits[-1]}"
    if scenario.wind is not None:
        kept += f" in a wind of {scenario.wind.told}"
    if any(zone.max_speed is not None for zone in scenario.zones):
        kept += ", and the speed limits of zones"
    ground = "" if scenario.terrain is None else f"{scenario.ground_clearance:.6g} m above ground, "
    if scenario.max_height is not None:
        ground = f"{scenario.ground_clearance:.6g} to {scenario.max_height:.6g} m above ground, "
    things = ["every obstacle"] if scenario.obstacles else []
    things += ["every mover, wherever within its doubt that may be,"] if scenario.movers else []
    things += ["every zone while it is active"] if any(map(is_closed_at_times, scenario.zones)) else []
    changing = ["movers"] if scenario.movers else []
    changing += ["zones that are closed at times"] if any(map(is_closed_at_times, scenario.zones)) else []
    stays = f"and clear of {' and '.join(changing)} also while it waits and stays, until {judged_until(curves):.6g} s, "
    clear = f"clear of {' and of '.join(things)} by {scenario.clearance:.6g} m, " if things else ""
    battery = ""
    if vehicle.usable_energy is not None:
        battery = (
            f"takes no more than the {vehicle.usable_energy / JOULES_OF_WATT_HOUR:.4g} Wh that its battery gives, "
        )
    without = "" if things else ", which has no obstacles"
    return (
        f"{vehicle.name} is {clear}{ground}inside the bounds and within its limits of {kept}, "
        f"at every instant from t = {knots[0]:.6g} s to {knots[-1]:.6g} s, {stays if changing else ''}{battery}"
        f"{_where(scenario, digest)}{without}{_for_every_flight(vehicle.tracking_error, pads)}."
    )


def _landings(scenario: Scenario, mission: Mission, uav: int) -> str:
    """Say that landings between sorties are no part of what is proven, where the UAV starts above its home."""
    lands = len(sound_sorties(mission, uav)) > 1 and take_off(scenario, uav, scenario.uavs[uav].start).seconds > 0
    return " Its landings between sorties, straight below its start, are not judged." if lands else ""


def _for_every_flight(error: TrackingError, pads: list[tuple[str, Pad]]) -> str:
    """Say that what is proven holds for all flights within a tracking error, and on which pads it does not count."""
    if error == EXACT:
        return ""
    stray = f"{error.horizontal:.6g} m horizontally and {error.vertical:.6g} m vertically"
    return f", for every flight within {stray} of it{pads_sentence(pads)}"


def _where(scenario: Scenario, digest: str) -> str:
    return f"in scenario {scenario.name!r} ({short(digest)})"


def _certificate(digest: str, violations: list[Violation], proven: str, halvings: int) -> Certificate:
    """Return what the worst violation says, or that there is none, for the scenario of that digest.

    A violation that the planner caused comes first, one that the scenario gives second, and an undecided one last.
    """
    if not violations:
        return Certificate(Verdict.PROVEN, proven, subdivisions=halvings, scenario=digest)
    order = {Fault.GIVEN: 1, Fault.UNDECIDED: 2}
    worst = min(violations, key=lambda violation: order.get(violation.fault, 0))
    verdict = Verdict.UNDECIDED if worst.fault is Fault.UNDECIDED else Verdict.REFUTED
    return Certificate(verdict, worst.message, worst.time, worst.position, halvings, digest)


def check(scenario: Scenario, mission: Mission) -> list[Violation]:
    """Judge a mission against the scenario that it answers.

    A place is safe if it lies within the closed bounds, not inside an obstacle that is grown by the clearance on every
    side (a grown box is a box), and no lower above ground than the terrain's clearance. What is wrong by at most 1e-6 m
    (or m/s, or relative) is let pass.

    Parameters
    ----------
    scenario
        What was given; the scenario that the mission embeds must be equal to it, or else the fields that differ are
        named. A mission file embeds whatever its writer put there: give the scenario that you know to be true.
    mission
        What is judged. However malformed it is, violations are returned and nothing is raised.

    Raises
    ------
    InputError
        If what is given is no scenario, or one that no file could hold, or no mission.

    Returns
    -------
    list of Violation
        Empty when nothing is wrong, and all trajectories and their separation are proven; see `certify`. There is at
        most one violation of each kind for a trajectory, at its worst instant, and for a pair of UAVs too close to each
        other.

    Notes
    -----
    *Not judged* are what paths cost and what else a mission states of itself (which is computed anew when a file is
    read), and claims that only another search could refute: that there is no path, that no path is cheaper, that a
    start or target is unsafe or shut in; nor the seconds and effort spent.

    *Exact* are the judgements of assignment, statuses, path segments, and of ends and continuity at the knots.

    *Proven* at every instant are clearance, bounds and limits of trajectories, and separations. What is neither proven
    nor refuted is a violation too, `Fault.UNDECIDED`. The mission's own certificates count for nothing.
    """
    require_kind(mission, Mission, "mission")
    return judge(scenario, mission)[0]


def judge(scenario: Scenario, mission: Mission) -> tuple[list[Violation], Certificates]:
    """Return what `check` and `certify` return, at the price of one of them."""
    with np.errstate(all="ignore"):
        worlds = RefereeWorlds(scenario)
        violations = judge_assignment(scenario, mission)
        fleet = judge_fleet(worlds, mission)
        for uav in range(len(scenario.uavs)):
            tour = tour_of(scenario, mission, uav)
            result, trajectory = entry(mission.results, uav), entry(mission.trajectories, uav)
            if isinstance(result, Result):
                if result.status is Status.NOT_PLANNED and not mission.interrupted:
                    message = f"{scenario.uavs[uav].name} was not planned, but the mission was not interrupted."
                    violations.append(Violation(Fault.STATUS, (uav,), message))
                found = judge_result(worlds.of(uav), uav, tour, result, isinstance(trajectory, Trajectory))
                violations += with_global_places(scenario.frame, found)
            violations += fleet.trajectories[uav]
        violations += fleet.apart
        return violations, fleet.certificates


def judged(scenario: Scenario, mission: Mission) -> Mission:
    """Return a mission with the referee's verdict in place of its own."""
    violations, (certificates, apart, coverage) = judge(scenario, mission)
    return replace(mission, violations=tuple(violations), certificates=certificates, apart=apart, coverage=coverage)


def check_result(scenario: Scenario, uav: int | str, target: int | str, result: Result) -> list[Violation]:
    """Judge one UAV's result alone, without a trajectory or a mission.

    Parameters
    ----------
    scenario
        What was given.
    uav, target
        The UAV and the target that it was sent to, by index or name.
    result
        What is judged: its status and path; see `check`. However malformed it is, nothing is raised.

    Returns
    -------
    list of Violation
        Empty when nothing is wrong. A path has no times, so that movers, and speed limits and active times of zones,
        are not judged.

    Raises
    ------
    InputError
        If the scenario has no such UAV or target, or could not be given at all.
    """
    worlds = RefereeWorlds(scenario)
    uav, target = index_of(scenario.uavs, uav, "uav"), index_of(scenario.targets, target, "target")
    with np.errstate(all="ignore"):
        found = judge_result(worlds.of(uav), uav, tour_to(scenario, uav, target), result, None)
        return with_global_places(scenario.frame, found)
