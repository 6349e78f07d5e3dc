"""Warnings of UAVs that keep apart by timing only, where they were to be apart in space."""

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skyverse.model.mission import Mission

MAX_NAMED = 6
"""Pairs of UAVs named in one sentence; of more it says only how many."""


def tell_apart_by_timing(mission: "Mission") -> None:
    """Say on standard error which pairs of UAVs are not proven to be apart in space."""
    from skyverse.deconfliction.paths_apart import apart_by_timing_only

    pairs = apart_by_timing_only(mission)
    if not pairs:
        return
    names = [" and ".join(mission.scenario.uavs[uav].name for uav in pair) for pair in pairs]
    said = "; ".join(names) if len(names) <= MAX_NAMED else f"{len(names)} pairs of UAVs"
    print(f"skyverse: not apart in space, but at most by timing: {said}.", file=sys.stderr)
