"""Velocity obstacles: of the velocities that meet no mover, the one nearest to the velocity that is preferred.

P. Fiorini, Z. Shiller, "Motion planning in dynamic environments using velocity obstacles", The International Journal of
Robotics Research 17 (1998), 760-772, in space: a mover at place q relative to the UAV, with the velocity w and the
radius r, makes an obstacle of all velocities u with |q + (w - u) t| < r for some t between 0 and the time horizon. As
in the paper, the velocities that the UAV can reach within a moment are laid out on a grid, those inside an obstacle are
struck out, and of the others the one nearest to the velocity straight to the goal is taken. In the paper what stands
still is a velocity obstacle too; here it is looked at exactly, along the way at each velocity, and the goal is the
farthest corner of the mission's path that is seen.
"""

import math
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Bools, Floats
from skyverse.errors import require_kind, require_number
from skyverse.live.guidance import Way, planned_anew
from skyverse.live.policies.policy import LEAST, MOST, NO_EFFORT, Found, Policy, Situation
from skyverse.model.mover import Ellipsoid
from skyverse.model.result import Effort
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Shape

DIRECTIONS = 96
"""Directions of the grid of velocities, spread over the sphere."""
SPEEDS = (0.25, 0.5, 0.75, 1.0)
"""Speeds of the grid, as shares of the largest."""


@dataclass(frozen=True, kw_only=True)
class VelocityObstacles(Policy):
    """Velocity obstacles of Fiorini and Shiller (1998), in space.

    Attributes
    ----------
    horizon
        Seconds up to which a velocity must meet no mover: the paper's time horizon.
    moment
        Seconds within which a velocity must be reached.
    proven
        Whether, as for all policies, only proven motions are flown. The method as published proves nothing.
    """

    horizon: float = 2.0
    moment: float = 0.5
    proven: bool = True

    def __post_init__(self) -> None:
        require_number(self.horizon, "horizon", "seconds", LEAST, MOST)
        require_number(self.moment, "moment", "seconds", LEAST, MOST)
        require_kind(self.proven, bool, "proven")

    def find(self, situation: Situation) -> Found:
        """Return the way straight on at the velocity that is chosen."""
        uav = situation.scenario.uavs[situation.uav]
        place, velocity = situation.state[0], situation.state[1]
        guidance = situation.memory if isinstance(situation.memory, Way) else situation.guidance
        goal, last = _seen_goal(situation, place, guidance)
        if goal is None:
            anew = planned_anew(situation.scenario, situation.uav, situation.target, situation.stop)
            if anew is None:
                return Found(None, NO_EFFORT)
            guidance = anew
            goal, last = guidance.points[min(1, len(guidance.points) - 1)], len(guidance.points) == 2
        preferred = _preferred(goal - place, uav.max_speed, uav.max_acceleration, last)
        velocities = np.vstack([preferred, np.zeros(3), self._grid(velocity, uav.max_speed, uav.max_acceleration)])
        until = self._first_meeting(situation, velocities)
        free = (until == math.inf) & self._clear(situation, place, velocities)
        off = np.linalg.norm(velocities - preferred, axis=1)
        best = int(np.argmin(np.where(free, off, math.inf))) if free.any() else int(np.argmax(until))
        effort = Effort(0, 0, len(velocities))
        if last and best == 0:
            return Found(_way(goal), effort, guidance, proof=self.proven)
        chosen = velocities[best]
        speed = math.hypot(*chosen)
        if speed < 1e-6:
            return Found(None, effort, guidance)
        share = min(speed / uav.max_speed, 1.0)
        return Found(_way(place + self.horizon * chosen), effort, guidance, share, self.proven)

    def _grid(self, velocity: Floats, top: float, acceleration: float) -> Floats:
        """Return the velocities (n, 3) of the grid that can be reached within a moment."""
        index = np.arange(DIRECTIONS)
        up = 1.0 - (2.0 * index + 1.0) / DIRECTIONS
        turn = index * math.pi * (3.0 - math.sqrt(5.0))  # Fibonacci's lattice on the sphere
        level = np.sqrt(1.0 - up * up)
        directions = np.column_stack([level * np.cos(turn), level * np.sin(turn), up])
        grid = np.concatenate([share * top * directions for share in SPEEDS])
        return np.asarray(grid[np.linalg.norm(grid - velocity, axis=1) <= acceleration * self.moment])

    def _first_meeting(self, situation: Situation, velocities: Floats) -> Floats:
        """Return when each velocity (n, 3) first leads too near to a mover, seconds; infinity beyond the horizon."""
        first = np.full(len(velocities), math.inf)
        for mover in situation.movers:
            here, later = mover.motion.at([situation.span.join, situation.span.join + 0.01])
            away, moves = here - situation.state[0], (later - here) / 0.01
            reach = _radius(mover.shape) + mover.keep + mover.doubt.radius
            relative = moves - velocities
            a, b = (relative**2).sum(axis=1), (relative * away).sum(axis=1)
            c = float(np.sum(away**2)) - reach**2
            if c <= 0.0:  # it is too near already: only velocities that lead away from it are free
                first[b < 0.0] = 0.0
                continue
            inside = b * b - a * c
            with np.errstate(divide="ignore", invalid="ignore"):
                meets = np.where((inside > 0.0) & (b < 0.0), (-b - np.sqrt(np.maximum(inside, 0.0))) / a, math.inf)
            first = np.minimum(first, np.where(meets <= self.horizon, meets, math.inf))
        return first

    def _clear(self, situation: Situation, place: Floats, velocities: Floats) -> Bools:
        """Tell at which velocities nothing that stands still is met before the UAV could brake."""
        uav = situation.scenario.uavs[situation.uav]
        speeds = np.linalg.norm(velocities, axis=1)
        seconds = self.moment + speeds / (2.0 * uav.max_acceleration)
        ends = place + seconds[:, None] * velocities
        inside = ((situation.world.low <= ends) & (ends <= situation.world.high)).all(axis=1)
        return np.asarray(inside & situation.world.segments_free(np.tile(place, (len(ends), 1)), ends))


def _seen_goal(situation: Situation, place: Floats, guidance: Way) -> tuple[Floats | None, bool]:
    """Return the farthest corner of a way that is seen from a place, or ``None``, and whether it is the last one."""
    points = guidance.points
    seen = np.nonzero(situation.world.segments_free(np.tile(place, (len(points), 1)), points))[0]
    if not len(seen):
        return None, False
    return points[seen[-1]], int(seen[-1]) == len(points) - 1


def _preferred(ahead: Floats, top: float, acceleration: float, stops: bool) -> Floats:
    """Return the velocity straight to a goal, which is slower where the UAV is to stop there."""
    far = math.hypot(*ahead)
    if far < 1e-9:
        return np.zeros(3)
    speed = min(top, math.sqrt(2.0 * acceleration * far)) if stops else top
    return np.asarray(speed / far * ahead)


def _radius(shape: Shape) -> float:
    """Return the radius of a ball about the moving point that holds a shape, metres."""
    if isinstance(shape, Ellipsoid):
        return math.hypot(*shape.centre) + max(shape.semi_axis_xy, shape.semi_axis_z)
    if hasattr(shape, "radius") and hasattr(shape, "centre") and len(shape.centre) == 3:
        return math.hypot(*shape.centre) + float(shape.radius)
    low, high = extent(shape)
    return math.hypot(*np.maximum(np.abs(low), np.abs(high)))


def _way(point: Floats) -> Way:
    """Return the way to one point."""
    return Way(point[None], np.zeros(1), np.full(1, -1))
