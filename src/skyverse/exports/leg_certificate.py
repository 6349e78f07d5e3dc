"""The referee's proof that legs and corners are clear, made once for all waypoints that are to be exported."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.autopilot_leg_clearance import LegChecker
from skyverse.exports.global_positions import home
from skyverse.exports.leg_geometry import Base, Segments, Shortfall, place_text
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.referee.clearance import judge_segments
from skyverse.referee.pads import without_support
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tube import named
from skyverse.referee.world import RefereeWorld, referee_world

SEGMENTS_AT_ONCE = 20_000
"""Segments that the referee judges together, which bounds the memory."""


class Polyline(NamedTuple):
    """One UAV's waypoints as `LegChecker.trouble` takes them: (n, 3) metres, metres, and (n,) stops."""

    points: Floats
    radius: float
    stops: Floats


@dataclass(frozen=True, eq=False)
class LegCertificate:
    """Lets the referee judge what a `LegChecker` found clear; it keeps the arrays of each growth and error."""

    legs: LegChecker
    worlds: dict[tuple[float, TrackingError], RefereeWorld] = field(default_factory=dict)

    def refused(self, polylines: Sequence[Polyline]) -> set[int]:
        """Return the numbers of polylines that are not proven; the checker then knows which of their parts are not."""
        wanted: dict[tuple[float, bool, Base | None, float], list[tuple[int, bytes, Segments]]] = defaultdict(list)
        for number, polyline in enumerate(polylines):
            for _, checked, key in self.legs.parts(*polyline):
                for segments in checked.clear:
                    wanted[segments[2:]].append((number, key, segments))
        found = set()
        for asked, parts in wanted.items():
            world = self._world(*asked)
            for batch in _batches(parts):
                found |= self._refused(world, batch)
        return found

    def _refused(self, world: RefereeWorld, parts: list[tuple[int, bytes, Segments]]) -> set[int]:
        """Judge parts in one world, without those that are refused, until the others are proven."""
        found = set()
        while parts:
            of = np.repeat(np.arange(len(parts)), [len(segments.starts) for _, _, segments in parts])
            starts = np.concatenate([segments.starts for _, _, segments in parts])
            ends = np.concatenate([segments.ends for _, _, segments in parts])
            peaks, incursion = judge_segments(world, starts, ends)
            if incursion is None and peaks.proven[0]:
                break
            piece = int(max(peaks.stuck[0], 0)) if incursion is None else incursion.segment
            number, key, segments = parts.pop(int(of[piece]))
            self.legs.refuse(key, segments._replace(starts=starts[piece : piece + 1], ends=ends[piece : piece + 1]))
            found.add(number)
        return found

    def sentence(self, fault: Shortfall | Segments) -> str:
        """Return a fault in words, with the place."""
        if isinstance(fault, Shortfall):
            return f"it {fault.said}, at {place_text(fault.place)}"
        world = self._world(*fault[2:])
        incursion = judge_segments(world, fault.starts, fault.ends).incursion
        if incursion is None:
            ends = " and ".join(place_text(end) for end in (fault.starts[0], fault.ends[0]))
            return f"whether it keeps the clearance could not be decided between {ends}"
        return incursion.sentence(world.scenario, named("it", world.error), "there").rstrip(".")

    def _world(self, growth: float, strays: bool, base: Base | None, upright: float = 0.0) -> RefereeWorld:
        key = growth, self.legs.search.stray(strays, upright)
        if key not in self.worlds:
            shapes = next((world.shapes for world in self.worlds.values()), None)
            self.worlds[key] = referee_world(self.legs.search.grown(growth), key[1], shapes=shapes)
        if base is None:
            return self.worlds[key]
        return without_support(self.worlds[key], np.array(base), self.legs.search.support(base) + LET_PASS)


def _batches(parts: list[tuple[int, bytes, Segments]]) -> list[list[tuple[int, bytes, Segments]]]:
    """Return parts in lists of about `SEGMENTS_AT_ONCE` segments at most."""
    count = np.cumsum([len(segments.starts) for _, _, segments in parts])
    cuts = [0, *(np.flatnonzero(np.diff(count // SEGMENTS_AT_ONCE)) + 1).tolist(), len(parts)]
    return [parts[a:b] for a, b in pairwise(cuts)]


def require_homes(scenario: Scenario, uavs: Sequence[int]) -> None:
    """Raise `InputError` if an obstacle lies between a UAV's home and its start, as where it starts on a roof."""
    ways = [(uav, home(scenario, uav), np.array(scenario.uavs[uav].start)) for uav in uavs]
    ways = [way for way in ways if way[1][2] < way[2][2]]
    if not ways:
        return
    bare = referee_world(derived(scenario, clearance=0.0, terrain=None))
    below, starts = (np.array([way[k] for way in ways]) for k in (1, 2))
    incursion = judge_segments(bare, below, starts).incursion
    if incursion is not None:
        named = scenario.obstacles[incursion.obstacle].name
        raise InputError(
            f"{scenario.uavs[ways[incursion.segment][0]].name}: its home, the ground below its start, cannot be risen "
            f"from: obstacle {incursion.obstacle}{f' ({named})' if named else ''} lies between; "
            "count altitudes from the sea (amsl)"
        )
