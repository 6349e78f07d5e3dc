"""The scene of a flight: that of its mission, with the motion as flown and the violations of the flight."""

from dataclasses import replace

import numpy as np

from skyverse.draw.scene import MissionScene, finding_of, scene
from skyverse.draw.track import Track
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.replanned_flight import ReplannedFlight

SAMPLE_STRIDE = 5
"""One sample of a flight in this many is drawn."""


def flight_scene(flight: Flight | ReplannedFlight) -> MissionScene:
    """Return the scene of `flight`; the path of a track is the planned trajectory, its positions are as flown.

    That of a flight that was replanned shows the truth, and as paths what was commanded.
    """
    if isinstance(flight, ReplannedFlight):
        flight = flight.flight
    planned = scene(flight.mission)
    tracks = tuple(_track(track, flown) for track, flown in zip(planned.tracks, flight.flown, strict=True))
    return replace(
        planned,
        tracks=tracks,
        curves=(),
        findings=tuple(replace(finding_of(planned.scenario, one), severity="error") for one in flight.violations),
        notes=(),
        complete=True,
    )


def _track(planned: Track, flown: Flown | None) -> Track:
    meant = planned.positions
    if flown is None:
        return replace(planned, path=meant)
    kept = np.unique(np.r_[0 : len(flown.times) : SAMPLE_STRIDE, len(flown.times) - 1])
    times = flown.times[kept]
    return replace(planned, path=meant, times=times, positions=flown.positions[kept], arrival=float(times[-1]))
