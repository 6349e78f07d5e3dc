"""A flight's scene: the mission's, with the UAVs where they were flown, and what went wrong then."""

from dataclasses import replace

import numpy as np

from skyverse.draw.scene import Finding, Scene, scene
from skyverse.draw.track import Track
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.scenario import Scenario

DRAWN = 5
"""Of so many samples of a flight one is drawn."""


def as_flown(flight: Flight) -> Scene:
    """Gather what a picture of `flight` shows: a track's path is the trajectory as planned, its positions as flown."""
    planned = scene(flight.mission)
    tracks = tuple(_track(track, flown) for track, flown in zip(planned.tracks, flight.flown, strict=True))
    end = max(track.arrival for track in tracks if track.arrival is not None)
    return replace(
        planned,
        tracks=tracks,
        curves=(),
        findings=tuple(_finding(flight.mission.scenario, flight, k) for k in range(len(flight.violations))),
        notes=(),
        totals=replace(planned.totals, makespan=end),
        complete=True,
    )


def _track(planned: Track, flown: Flown | None) -> Track:
    meant = planned.positions
    if flown is None:
        return replace(planned, path=meant)
    kept = np.unique(np.r_[0 : len(flown.times) : DRAWN, len(flown.times) - 1])
    times = flown.times[kept]
    return replace(planned, path=meant, times=times, positions=flown.positions[kept], arrival=float(times[-1]))


def _finding(scenario: Scenario, flight: Flight, k: int) -> Finding:
    violation = flight.violations[k]
    names = tuple(scenario.uavs[uav].name for uav in violation.uavs)
    return Finding("error", violation.fault.value, names, violation.message, violation.time, violation.position)
