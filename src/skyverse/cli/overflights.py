"""Warnings of flights that pass over a zone which ends below them."""

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.scenario import Scenario
    from skyverse.model.trajectory import Trajectory

METRES = 1.0
"""About how far apart the places are that are looked at along a flight."""
MAX_PLACES = 20_000
"""Places at most that are looked at along a flight."""


def tell_overflights(mission: "Mission") -> None:
    """Say on standard error which UAVs fly over which zones, and how that can be forbidden."""
    said = False
    for uav, trajectory in zip(mission.scenario.uavs, mission.trajectories, strict=True):
        if trajectory is not None:
            for zone, metres in _overflown(mission.scenario, trajectory):
                said = True
                print(f"skyverse: {uav.name} flies over {zone}, {metres:.0f} m above its upper end.", file=sys.stderr)
    if said:
        advice = "where that is not allowed, give the zones closed_above: true"
        print(f"skyverse: {advice}, or build the scenario with --zones-closed-above.", file=sys.stderr)


def _overflown(scenario: "Scenario", trajectory: "Trajectory") -> Iterator[tuple[str, float]]:
    """Yield the zones that a flight passes over, and how many metres above them it does so at least."""
    from skyverse.draw.shape_geometry import span
    from skyverse.model.shapes import NO_FLY_ZONE

    zones = [(k, shape) for k, shape in enumerate(scenario.obstacles) if not shape.solid and not shape.closed_above]
    if not zones:
        return
    import numpy as np

    coarse = trajectory.at(np.linspace(trajectory.start, trajectory.end, 1000)).position
    length = float(np.linalg.norm(np.diff(coarse, axis=0), axis=1).sum())
    count = int(min(max(length / METRES, 100), MAX_PLACES))
    places = trajectory.at(np.linspace(trajectory.start, trajectory.end, count)).position
    for number, shape in zones:
        above = places[:, 2] - span(shape, places[:, :2])[:, 1]
        if (above > 0).any():
            name = f"obstacles[{number}]" + (f" ({shape.name})" if shape.name else "")
            yield f"the {shape.kind or NO_FLY_ZONE} {name}", float(above[above > 0].min())
