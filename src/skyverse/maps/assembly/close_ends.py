"""Starts, or targets, that are nearer to each other than UAVs may come."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.kept_ellipsoid import kept_ellipsoid
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_metres

Point = tuple[float, float, float]

FORGIVEN = 1e-6
"""Share of the separation by which two points may be too close, as far as numbers are rounded."""


class EndsApart:
    """The starts of a fleet, and its targets, each of which must keep the separation from the others of its sort.

    Where there are more targets than UAVs, not all of them are flown to, and any of them may be close to each other.

    Parameters
    ----------
    scenario
        The fleet, whose UAVs all have the same limits.
    """

    def __init__(self, scenario: Scenario) -> None:
        uavs, targets = scenario.uavs, scenario.targets
        aside, up = kept_ellipsoid(uavs[0], uavs[0]) if uavs else (0.0, 0.0)
        self._kept = np.array([aside, aside, up])
        self._starts = {uav.name: uav.start for uav in uavs}
        self._targets = {target.name: target.position for target in targets} if len(targets) <= len(uavs) else {}

    def close(self) -> Iterator[tuple[str, Point, str]]:
        """Yield each start or target that is too near to one before it: its name, the point, and what is wrong."""
        if not self._kept.all():
            return
        aside, _, up = self._kept
        for noun, ends in (("start", self._starts), ("target", self._targets)):
            names, points = list(ends), np.array(list(ends.values())).reshape(-1, 3)
            for k in range(1, len(names)):
                shares = np.linalg.norm((points[:k] - points[k]) / self._kept, axis=1)
                j = int(shares.argmin())
                if shares[j] >= 1.0 - FORGIVEN:
                    continue
                away = math.dist(points[j], points[k])
                yield (
                    names[k],
                    ends[names[k]],
                    f"expected a {noun} at least {aside:.3g} m from that of {names[j]} at one height, or {up:.3g} m "
                    "above or below it (the separation, counting the tracking errors of both), found it "
                    f"{f'{told_metres(away)} away' if away else 'at the same place'}",
                )

    def apart(self, name: str, at: Point, points: Floats, margin: float) -> NDArray[np.bool_]:
        """Tell for each of (m, 3) points whether an end may move there without coming too near to another one.

        Parameters
        ----------
        name, at
            The end's name, and where it is.
        points
            Metres.
        margin
            Metres to keep besides.
        """
        found = np.ones(len(points), dtype=bool)
        ends = next((ends for ends in (self._starts, self._targets) if ends.get(name) == at), {})
        if self._kept.all():
            for other, place in ends.items():
                if other != name:
                    found &= np.linalg.norm((points - place) / (self._kept + margin), axis=1) >= 1.0
        return found

    def move(self, name: str, at: Point, place: Point) -> None:
        """Take note of the place to which an end is to be moved, so that the others keep away from there."""
        for ends in (self._starts, self._targets):
            if ends.get(name) == at:
                ends[name] = place
                return
