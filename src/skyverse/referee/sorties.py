"""Judges the sorties of tours: that each target is visited, by whom, when and for how long, and the stands at home."""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario, Target
from skyverse.model.short_lines import counted
from skyverse.model.sortie import Sortie, Strip, Unvisited, Visit
from skyverse.model.take_off import landing, take_off
from skyverse.model.trajectory import Pointing, Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.judgement import position_text, position_tuple
from skyverse.referee.limits import well_formed
from skyverse.referee.tolerances import LET_PASS, SAME_INSTANT
from skyverse.referee.untrusted import entry, float_array, target_index

MAX_AIM = math.radians(1.0)
"""The angle, rad, by which the nose may be off where a target wants it."""


class Tour(NamedTuple):
    """The targets that a UAV visits, in their order, by index, and where its flight must end, metres, if anywhere."""

    visited: tuple[int, ...] = ()
    end: tuple[float, float, float] | None = None


def tour_to(scenario: Scenario, uav: int, target: int | None) -> Tour:
    """Return the tour of a UAV that flies to one target, if it has one."""
    return Tour(() if target is None else (target,), scenario.end_place(uav, target))


def tour_of(scenario: Scenario, mission: Mission, uav: int) -> Tour:
    """Return the tour of a UAV in a mission, however malformed that may be."""
    target = target_index(scenario, entry(mission.assignment, uav))
    visits = (visit.target for sortie in sound_sorties(mission, uav) for visit in sortie.visits)
    known = tuple(one for visit in visits if (one := target_index(scenario, visit)) is not None)
    surveys = any(sortie.strips for sortie in sound_sorties(mission, uav))
    end = scenario.uavs[uav].start if surveys else scenario.end_place(uav, target)
    return Tour(known or (() if target is None else (target,)), end)


def makes_tours(scenario: Scenario, mission: Mission) -> bool:
    """Tell whether a mission is judged as one of tours: it states sorties, or its scenario asks for them."""
    stated = mission.sorties
    return scenario.asks_for_tours or not isinstance(stated, tuple) or len(stated) > 0


def sound_sorties(mission: Mission, uav: int) -> tuple[Sortie, ...]:
    """Return the stated sorties of a UAV; none where any of them is malformed."""
    own = entry(mission.sorties, uav) if isinstance(mission.sorties, tuple) else ()
    return own if isinstance(own, tuple) and all(map(_well_formed, own)) else ()


def _well_formed(sortie: object) -> bool:
    if not isinstance(sortie, Sortie) or not isinstance(sortie.visits, tuple):
        return False
    if not all(isinstance(visit, Visit) for visit in sortie.visits):
        return False
    if not isinstance(sortie.strips, tuple) or not all(isinstance(strip, Strip) for strip in sortie.strips):
        return False
    if any(not isinstance(strip.survey, int | np.integer) for strip in sortie.strips):
        return False
    of_strips = [t for one in sortie.strips for t in (one.begin, one.end, one.every, one.pitch, one.heading or 0.0)]
    instants = [sortie.begin, *_instants(sortie), sortie.end, *of_strips]
    numbers = float_array(instants) if all(isinstance(t, float | int | np.number) for t in instants) else None
    return numbers is not None and bool(np.isfinite(numbers).all())


def spans_of(mission: Mission, uav: int, curve: PolynomialCurve) -> Floats:
    """Return when the sorties of a UAV begin and end, (n, 2) seconds: as stated, or one along all of its flight."""
    stated = [(one.begin, one.end) for one in sound_sorties(mission, uav)]
    return np.array(stated or [(curve.knots[0], curve.knots[-1])], dtype=np.float64)


def judge_visits(scenario: Scenario, mission: Mission) -> Iterator[Violation]:
    """Yield which targets of a mission with tours are visited twice, or neither visited nor named as unvisited.

    Only visits of UAVs that fly count.
    """
    names = [target.name for target in scenario.targets]
    given = mission.sorties if isinstance(mission.sorties, tuple) else ()
    if len(given) != len(scenario.uavs):
        message = f"The mission has sorties of {counted(len(given), 'UAV')}, but there are {len(scenario.uavs)}."
        yield Violation(Fault.VISIT, (), message)
        return
    count = np.zeros(len(names), dtype=int)
    for uav in range(len(scenario.uavs)):
        if isinstance(entry(mission.trajectories, uav), Trajectory):
            np.add.at(count, list(tour_of(scenario, mission, uav).visited), 1)
    unvisited = mission.unvisited if isinstance(mission.unvisited, tuple) else ()
    named = [target_index(scenario, one.target) for one in unvisited if isinstance(one, Unvisited)]
    for target, (name, visits) in enumerate(zip(names, count.tolist(), strict=True)):
        if visits > 1:
            yield Violation(Fault.VISIT, (), f"{name} is visited {visits} times.")
        elif visits and target in named:
            yield Violation(Fault.VISIT, (), f"{name} is visited, but named as unvisited.")
        elif not visits and target not in named and not mission.interrupted:
            yield Violation(Fault.VISIT, (), f"{name} is neither visited nor named.")


def judge_sorties(
    scenario: Scenario, mission: Mission, uav: int, trajectory: Trajectory, curve: PolynomialCurve
) -> Iterator[Violation]:
    """Yield what is wrong with the sorties of a UAV's flight."""
    vehicle, sorties = scenario.uavs[uav], sound_sorties(mission, uav)
    targets = [target_index(scenario, visit.target) for sortie in sorties for visit in sortie.visits]
    if None in targets:
        yield Violation(Fault.VISIT, (uav,), f"{vehicle.name} visits a target that does not exist.")
        return
    last, surveys = target_index(scenario, entry(mission.assignment, uav)), any(one.strips for one in sorties)
    if not sorties and entry(mission.assignment, uav) is None:
        return  # it has nothing to visit, and stays
    if not (targets or surveys) or (targets[-1] if targets else None) != last:
        yield Violation(Fault.VISIT, (uav,), f"{vehicle.name} flies, but its last visit is not that of its target.")
        return
    instants = [t for one in sorties for t in (one.begin, *_instants(one), one.end)]
    ends = [(curve.knots[0], instants[0]), (instants[-1], curve.knots[-1])]
    if not (np.diff(instants) >= -SAME_INSTANT).all() or any(not abs(b - a) <= SAME_INSTANT for a, b in ends):
        message = f"{vehicle.name}'s sorties and visits do not follow one another from take-off to landing."
        yield Violation(Fault.VISIT, (uav,), message)
        return
    if vehicle.batteries is not None and len(sorties) > vehicle.batteries:
        many = counted(vehicle.batteries, "battery", "batteries")
        message = f"{vehicle.name} flies {len(sorties)} sorties, but has {many}."
        yield Violation(Fault.VISIT, (uav,), message)
    for one, following in pairwise(sorties):
        stood, start = following.begin - one.end, vehicle.start
        due = landing(scenario, uav, start).seconds + vehicle.swap + take_off(scenario, uav, start).seconds
        if not stood >= due - SAME_INSTANT:
            message = f"{vehicle.name} has {stood:.6g} s at home between two sorties, but needs {due:.6g} s there."
            yield Violation(Fault.VISIT, (uav,), message, one.end)
        off = _off(curve, one.end, following.begin, vehicle.start)
        if not off <= LET_PASS:
            message = f"{vehicle.name} is {off:.6g} m from home between two sorties, after t = {one.end:.6g} s."
            yield Violation(Fault.VISIT, (uav,), message, one.end)
    for sortie in sorties:
        load = sum(scenario.targets[visit.target].demand for visit in sortie.visits)
        if vehicle.capacity is not None and load > vehicle.capacity * (1 + LET_PASS):
            message = (
                f"{vehicle.name} has {load:.6g} kg to carry at once, but its capacity is {vehicle.capacity:.6g} kg."
            )
            yield Violation(Fault.VISIT, (uav,), message, sortie.begin)
        for visit in sortie.visits:
            target = scenario.targets[visit.target]
            wrong = _wrong_visit(vehicle.name, target, visit, curve, trajectory, vehicle.fixed_wing is None)
            if wrong:
                where = position_tuple(np.array(target.position))
                message = f"{vehicle.name}'s visit of {target.name} at t = {visit.arrival:.6g} s {wrong}."
                yield Violation(Fault.VISIT, (uav,), message, visit.arrival, where)


def _instants(sortie: Sortie) -> list[float]:
    return [t for visit in sortie.visits for t in (visit.arrival, visit.departure)]


def _wrong_visit(
    name: str, target: Target, visit: Visit, curve: PolynomialCurve, trajectory: Trajectory, hovers: bool
) -> str:
    """Say what is wrong with a visit; nothing where all is right."""
    if target.uavs and name not in target.uavs:
        return f"is not its own: only {', '.join(target.uavs)} may go there"
    window = target.window
    if window is not None and not window[0] - SAME_INSTANT <= visit.arrival <= window[1] + SAME_INSTANT:
        return f"does not begin within its window, {window[0]:.6g} to {window[1]:.6g} s"
    stay = visit.departure - visit.arrival
    if not stay >= target.stay - SAME_INSTANT:
        return f"lasts {stay:.6g} s, not {target.stay:.6g} s"
    off = _off(curve, visit.arrival, visit.departure if hovers else visit.arrival, target.position)
    if not off <= LET_PASS:
        return f"is {off:.6g} m from {position_text(np.array(target.position))}"
    aim = _aim_error(target, visit, trajectory.pointing) if hovers else 0.0
    return f"points its nose {math.degrees(aim):.3g} degrees off" if not aim <= MAX_AIM else ""


def _off(curve: PolynomialCurve, begin: float, end: float, place: tuple[float, float, float]) -> float:
    """Return a bound on how far a curve is from a place between two instants, metres, but for moments at both."""
    middle = min(max((begin + end) / 2, float(curve.knots[0])), float(curve.knots[-1]))
    first, last = min(begin + SAME_INSTANT, middle), max(end - SAME_INSTANT, middle)
    begins, ends = curve.knots[:-1], curve.knots[1:]
    met = np.flatnonzero((begins <= last) & (ends >= first))
    if not len(met):
        return math.inf
    if first == last:  # an instant: it is enough to look there
        piece = int(met[0])
        return math.dist(curve.motion(piece, middle - float(begins[piece]))[0], place)
    powers = (ends - begins)[met, None] ** np.arange(1, curve.pieces.shape[1])
    reach: Floats = np.linalg.norm(curve.pieces[met, 0] - place, axis=1)
    reach = reach + (np.linalg.norm(curve.pieces[met, 1:], axis=2) * powers).sum(axis=1)
    return float(reach.max())


def _aim_error(target: Target, visit: Visit, pointing: Pointing | None) -> float:
    """Return by how much the nose is off where a target wants it, rad, at the most during a visit.

    Between corners the yaw is a quadratic, so that it is farthest off at a corner, where its rate is zero, or at an
    end. What is malformed is judged elsewhere.
    """
    if target.heading is not None:
        wanted = math.radians(90.0 - target.heading)
    elif target.look_at is not None:
        east, north = np.subtract(target.look_at, target.position)[:2]
        wanted = float(arctan2(np.array(north), np.array(east)))
    else:
        return 0.0
    ends, yaw = np.array([visit.arrival, visit.departure]), np.zeros(1)
    if pointing is not None:
        if not well_formed(pointing):
            return 0.0
        corners, _, rates, slopes = pointing.corners
        turning = slopes != 0
        level = corners[turning] - rates[turning] / slopes[turning]
        instants = np.clip(np.r_[ends, corners, level], *ends)
        yaw = replace(pointing, look_at=None).at(instants, np.zeros((len(instants), 3))).yaw
    return float(np.abs((yaw - wanted + math.pi) % (2.0 * math.pi) - math.pi).max())
