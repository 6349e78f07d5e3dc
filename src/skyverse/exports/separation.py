"""Whether exported flights keep their separation, and how: in space, by timing with some tolerance, or on schedule."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.timing import TimingTolerance, circle_reach, scheduled_path, timed_path, tolerance_for
from skyverse.model.caution import Caution
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.timed_path import TimedPath
from skyverse.model.verdict import Certificate, Verdict, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.separation import judge_separation
from skyverse.referee.timed_paths import KeptDistance, paths_apart

MAX_NAMED = 6
"""Pairs of UAVs named in one sentence; of more it says only how many."""


class Apart(Enum):
    """How two UAVs keep their separation when their autopilots fly what was exported; the surest first."""

    SPACE = "apart in space, whatever the timing"
    TIMING = "apart by timing"
    SCHEDULE = "apart only on schedule"
    CLOSE = "too close"


@dataclass(frozen=True)
class FleetApart:
    """How each two UAVs of a fleet keep their separation.

    Attributes
    ----------
    pairs
        What is proven of each two UAVs, by their indices, the lower first.
    tolerance
        What `Apart.TIMING` allows for.
    violations
        Where UAVs are too close even on schedule.
    corners
        The pairs of which one is an aeroplane whose corners are not proven.
    circles
        The pairs that are too close only because one is an aeroplane that circles at its end.
    """

    pairs: dict[tuple[int, int], Apart]
    tolerance: TimingTolerance
    violations: tuple[Violation, ...]
    corners: frozenset[tuple[int, int]] = frozenset()
    circles: frozenset[tuple[int, int]] = frozenset()

    def of(self, kind: Apart) -> list[tuple[int, int]]:
        """Return the pairs of which this, and nothing better, is proven."""
        return [pair for pair, found in self.pairs.items() if found is kind]

    def only(self, kind: Apart) -> bool:
        """Tell whether this is proven of every pair."""
        return all(found is kind for found in self.pairs.values())

    def certificate(self, scenario: Scenario) -> Certificate:
        """Return what is proven of the fleet as one certificate: proven only if no pair depends on the schedule."""
        said = " ".join(self.sentences(scenario)) or "There are no two UAVs."
        if self.of(Apart.CLOSE):
            if not self.violations:
                return Certificate(Verdict.REFUTED, said)
            worst = self.violations[0]
            return Certificate(Verdict.REFUTED, worst.message, worst.time, worst.position)
        return Certificate(Verdict.UNDECIDED if self.of(Apart.SCHEDULE) else Verdict.PROVEN, said)

    def sentences(self, scenario: Scenario) -> list[str]:
        """Return what is proven, one sentence for each kind that there is."""
        return [self.sentence(scenario, kind) for kind in Apart if self.of(kind)]

    def sentence(self, scenario: Scenario, kind: Apart) -> str:
        """Return what is said of the pairs of one kind."""
        said: dict[str, list[tuple[int, int]]] = {}
        for pair in self.of(kind):
            said.setdefault(self._words(pair, kind), []).append(pair)
        return " ".join(f"{named_pairs(scenario, pairs)} {words}." for words, pairs in said.items())

    def _words(self, pair: tuple[int, int], kind: Apart) -> str:
        at = self.tolerance.sentence()
        if kind is Apart.SPACE:
            return "keep their separation whatever the timing: their paths are apart in space"
        if kind is Apart.TIMING:
            return f"keep their separation by timing, {at}, if they start at the same time"
        if kind is Apart.SCHEDULE:
            turns = f", and only if aeroplanes turn where expected: what they keep at corners is {Caution.NOT} proven"
            return f"keep their separation only on schedule, {Caution.NOT} {at}{turns if pair in self.corners else ''}"
        if pair in self.circles:
            return (
                "may come too close even on schedule, where an aeroplane circles at its end, anywhere within twice its "
                "turn radius"
            )
        return "come too close even on schedule"


def fleet_apart(scenario: Scenario, plans: Sequence[FlightPlan]) -> FleetApart:
    """Judge each two UAVs that fly exported plans.

    Separation is counted with the tracking errors of both UAVs. Of the pairs whose paths are not apart in space, the
    referee judges whether they are apart at all times that the tolerance allows, and at last on schedule. An
    aeroplane may then be anywhere on the circles that it may fly at its end.
    """
    tolerance = tolerance_for(plans)
    paths = [timed_path(scenario, plan, tolerance) for plan in plans]
    boxes = [path_box(path) for path in paths]
    pairs: dict[tuple[int, int], Apart] = {}
    doubtful = []
    for i, j in combinations(range(len(plans)), 2):
        pair = plans[i].route.uav, plans[j].route.uav
        keep = kept_distance(scenario, *pair)
        if beyond(boxes[i], boxes[j], keep) or paths_apart(paths[i], paths[j], keep, timed=False):
            pairs[pair] = Apart.SPACE
        elif paths_apart(paths[i], paths[j], keep, timed=True):
            pairs[pair] = Apart.TIMING
        else:
            pairs[pair] = Apart.SCHEDULE
            doubtful.append(pair)
    violations = _on_schedule(scenario, plans, doubtful)
    waits = {plan.route.uav for plan in plans if plan.breaks}
    flown = {plan.route.uav: plan for plan in plans}
    circles = set()
    for pair in doubtful:
        if any(set(pair) == set(violation.uavs) for violation in violations) or waits & set(pair):
            pairs[pair] = Apart.CLOSE
        elif _circles_meet(scenario, flown[pair[0]], flown[pair[1]]):
            pairs[pair] = Apart.CLOSE
            circles.add(pair)
    unproven = {plan.route.uav for plan in plans if not plan.corners_proven}
    corners = frozenset(pair for pair in doubtful if unproven & set(pair))
    return FleetApart(pairs, tolerance, violations, corners, frozenset(circles))


def kept_distance(scenario: Scenario, first: int, second: int) -> KeptDistance:
    """Return what two UAVs must keep: of their separations the larger ones, and both tracking errors."""
    a, b = scenario.uavs[first], scenario.uavs[second]
    across, above = (max(pair) for pair in zip(a.ellipsoid, b.ellipsoid, strict=True))
    errors = a.tracking_error, b.tracking_error
    level, upright = sum(error.horizontal for error in errors), sum(error.vertical for error in errors)
    return KeptDistance(across, above, level, upright)


def _on_schedule(
    scenario: Scenario, plans: Sequence[FlightPlan], pairs: list[tuple[int, int]]
) -> tuple[Violation, ...]:
    """Return where UAVs of some pairs come too close if all fly exactly as predicted."""
    asked = {uav for pair in pairs for uav in pair}
    curves: list[PolynomialCurve | None] = [None] * len(scenario.uavs)
    uavs = list(scenario.uavs)
    for plan in plans:
        if plan.route.uav in asked:
            flight = plan.predicted()
            curves[plan.route.uav] = PolynomialCurve(flight.knots, flight.coefficients)
            start = tuple(float(value) for value in plan.home)
            uavs[plan.route.uav] = derived(uavs[plan.route.uav], start=start, home=None)
    standing = derived(scenario, uavs=tuple(uavs))
    unknown = {uav for uav, curve in enumerate(curves) if curve is None}
    found = judge_separation(standing, [None] * len(uavs), curves, unknown).violations
    return tuple(violation for violation in found if any(set(pair) == set(violation.uavs) for pair in pairs))


def _circles_meet(scenario: Scenario, first: FlightPlan, second: FlightPlan) -> bool:
    """Tell whether two UAVs may come too close on schedule while one, an aeroplane, circles at its end."""
    keep = kept_distance(scenario, first.route.uav, second.route.uav)
    for plan, other in ((first, second), (second, first)):
        if not circle_reach(scenario, plan.route.uav):
            continue
        own = scheduled_path(scenario, plan)
        circle = TimedPath(own.starts[-1:], own.ends[-1:], own.earliest[-1:], own.latest[-1:], own.deviation[-1:])
        if not paths_apart(circle, scheduled_path(scenario, other), keep, timed=True):
            return True
    return False


def path_box(path: TimedPath) -> tuple[Floats, Floats]:
    """Return the least and the greatest corner, (3,) metres each, of the box around a path, deviations counted."""
    off = path.deviation.max(axis=1)[:, None]
    low, high = np.minimum(path.starts, path.ends) - off, np.maximum(path.starts, path.ends) + off
    return low.min(axis=0), high.max(axis=0)


def beyond(first: tuple[Floats, Floats], second: tuple[Floats, Floats], keep: KeptDistance) -> bool:
    """Tell whether boxes about two paths are farther apart than the separation."""
    level, upright = keep.across + keep.error_across, keep.above + keep.error_above
    gap = np.maximum(first[0] - second[1], second[0] - first[1])
    return bool((gap > [level, level, upright]).any())


def named_pairs(scenario: Scenario, pairs: list[tuple[int, int]]) -> str:
    """Return the names of pairs of UAVs, or only how many they are."""
    if len(pairs) > MAX_NAMED:
        return f"{len(pairs)} pairs of UAVs"
    names = [" and ".join(scenario.uavs[uav].name for uav in pair) for pair in pairs]
    return "; ".join(names)
