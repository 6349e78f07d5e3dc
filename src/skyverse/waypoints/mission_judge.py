"""The legs and corners of a mission, searched by the planners' space and proven by the referee."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_space import Checked, LegSpace, Segments
from skyverse.exports.legs import LegChecker, cut_corners, unproven
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape
from skyverse.model.uav import TrackingError
from skyverse.referee.clearance import incursions
from skyverse.referee.judgement import Incursion
from skyverse.waypoints.findings import FindingKind, kind_of
from skyverse.waypoints.flown import FlownMission

MOST_LIFTED = 1000.0
"""Metres by which a part of a flight is lifted at most to find where it would be clear."""
LIFT_STEP = 0.5
"""Metres to which that is found."""


class Part(NamedTuple):
    """A leg, (2, 3), or a corner, (4, 3) metres, that is cut within a radius, what checks it, and what that found."""

    k: int
    points: Floats
    radius: tuple[float, ...]
    checker: LegChecker
    checked: Checked
    key: bytes


class MissionJudge:
    """Judges the parts of missions of one UAV in one scenario."""

    def __init__(self, scenario: Scenario, error: TrackingError, lifts: tuple[tuple[Floats, Floats], ...]) -> None:
        self.scenario, self.error, self.lifts = scenario, error, lifts
        self._checkers: dict[tuple[bool, float], LegChecker] = {}
        self._spaces = {follows: LegSpace(scenario, "agl" if follows else "amsl") for follows in (False, True)}

    @cached_property
    def _alone(self) -> list["MissionJudge"]:
        """Judges of the ground and ceiling alone, and of things, of zones and of fences alone."""
        kinds = defaultdict[FindingKind, list[Shape]](list)
        for shape in self.scenario.obstacles:
            kinds[kind_of(shape)].append(shape)
        bare = derived(self.scenario, terrain=None, max_height=None)
        things = (derived(bare, obstacles=tuple(shapes)) for shapes in kinds.values())
        return [MissionJudge(one, self.error, self.lifts) for one in (derived(self.scenario, obstacles=()), *things)]

    def by_what_is_met(self, part: Part) -> list[Part]:
        """Return a part that is not proven once for each kind of thing that it meets, if it meets one by itself."""
        if part.checker.space.reference == "agl" or not self.scenario.obstacles:
            return [part]
        each = (judge.checker(False) for judge in self._alone)
        parts = [part._replace(checker=one, checked=one.part(part.points, *part.radius)[0]) for one in each]
        return [one for one in parts if one.checked.fault is not None] or [part]

    def checker(self, follows: bool, aside: float = 0.0) -> LegChecker:
        """Return what checks legs that follow the ground, or do not, and may be flown `aside` metres beside."""
        if (follows, aside) not in self._checkers:
            error = derived(self.error, horizontal=self.error.horizontal + aside)
            self._checkers[follows, aside] = LegChecker(self._spaces[follows], error, self.lifts)
        return self._checkers[follows, aside]

    def parts(self, flown: FlownMission) -> Iterator[Part]:
        """Yield all legs and corners; leg 0 is the climb of the take-off, and each ends at the visit of its number."""
        route, visits = flown.plan.route, flown.visits
        points = np.concatenate([route.lead, route.waypoints])
        first = len(points) - len(visits)
        ways = [(False, 0.0)] * first + [(visit.follows, visit.aside) for visit in visits]
        for k in range(1, len(points)):
            checker = self.checker(*ways[k])
            yield Part(k - first, points[k - 1 : k + 1], (), checker, *checker.part(points[k - 1 : k + 1]))
        radii, stops = (np.r_[np.zeros(first), one] for one in (route.waypoint_radii, route.waypoint_holds))
        for k, corner, radius in cut_corners(points, radii, stops):
            if not ways[k + 1][0]:  # where it follows the ground, what is beside its parts is checked
                checker = self.checker(False)
                yield Part(k - first, corner, (radius,), checker, *checker.part(corner, radius))

    def refuted(self, flown: FlownMission) -> list[Part]:
        """Return the legs and corners that are not proven."""
        parts = list(self.parts(flown))
        unproven((k, one.checker, one.checked, one.key) for k, one in enumerate(parts) if one.checked.fault is None)
        again = (one._replace(checked=one.checker.part(one.points, *one.radius)[0]) for one in parts)
        return [one for one in again if one.checked.fault is not None]

    def met(self, parts: Sequence[Part]) -> list[Incursion | None]:
        """Return what each of some refuted parts meets where it is deepest, of those that meet something."""
        asked: dict[tuple[object, ...], list[tuple[int, Segments]]] = defaultdict(list)
        for k, part in enumerate(parts):
            if isinstance(part.checked.fault, Segments):
                asked[part.checker.space, *part.checked.fault[2:]].append((k, part.checked.fault))
        found: list[Incursion | None] = [None] * len(parts)
        for same in asked.values():
            (first, fault), *_ = same
            starts, ends = (np.concatenate([one[end] for _, one in same]) for end in (0, 1))
            met = incursions(parts[first].checker.space.referee(fault), starts, ends)
            for (k, _), incursion in zip(same, met, strict=True):
                found[k] = incursion
        return found

    def clear_lift(self, part: Part) -> float | None:
        """Return how many metres higher a part would be clear; ``None`` where no height helps."""

        def clear(metres: float) -> bool:
            checker, lift = self.checker(False), np.array([0.0, 0.0, metres])
            return checker.part(part.points + lift, *part.radius)[0].fault is None

        high = LIFT_STEP
        while not clear(high):
            high *= 2
            if high > MOST_LIFTED:
                return None
        low = high / 2
        while high - low > LIFT_STEP:
            middle = (low + high) / 2
            low, high = (low, middle) if clear(middle) else (middle, high)
        return high
