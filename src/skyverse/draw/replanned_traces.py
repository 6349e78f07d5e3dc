"""What a page of a replanned flight shows besides that of any flight: traces in space, and what its scripts move."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.plotly_values import Trace, flat, packed, plain, trace
from skyverse.draw.replanned_scene import CommittedWay, ReplannedScene
from skyverse.draw.shape_geometry import DrawnShape, footprint, outline, surface
from skyverse.model.replanned_flight import Prediction
from skyverse.model.shapes import Voxels

PAGE_STRIDE = 2
"""One sample of a committed way in this many is written."""
LETTERS = {"kept": "k", "replaced": "r", "no way out": "n"}


def replanned_in_space(drawn: ReplannedScene) -> list[Trace]:
    """Return the traces of what was planned and unknown, and empty ones that the page fills in."""
    nowhere = {"x": [None], "y": [None], "z": [None]}
    planned = [
        trace(
            "scatter3d",
            "lines",
            f"{plain(name)}: as planned",
            _xyz(line),
            None,
            {"role": "planned", "uav": uav},
            line={},
        )
        for uav, (name, line) in enumerate(drawn.planned)
        if len(line)
    ]
    unknown = [each for wall, when in zip(drawn.unknown, drawn.seen, strict=True) for each in _unknown(wall, when)]
    names = {"doubt": "Where movers may be", "committed": "Committed way", "out": "Way out"}
    names |= {"sensor": "Sensor range"} if drawn.flight.sensor.range else {}
    moving = [trace("scatter3d", "lines", name, nowhere, None, {"role": role}, line={}) for role, name in names.items()]
    return [*planned, *unknown, *moving]


def replans_data(drawn: ReplannedScene) -> dict[str, Any]:
    """Return what the page moves: observations, predictions, committed ways, answers and unknown obstacles.

    A prediction is a row: the mover's number, the instant of its last sighting, its place (3) and velocity (3) then,
    and its doubt's radius, growth and acceleration, and for how many seconds it accelerates.
    """
    steps = drawn.flight.steps
    return {
        "horizon": drawn.flight.horizon,
        "range": drawn.flight.sensor.range,
        "arrivals": flat(drawn.arrivals),
        "predictions": [[_row(one) for one in step.predictions] for step in steps],
        "ways": [[_way(way) for way in own] for own in drawn.committed],
        "ticks": ["".join(LETTERS[tick] for _, tick in own) for own in drawn.ticks],
        "sentences": [[answer.sentence for answer in step.answers] for step in steps],
        "seen": list(drawn.seen),
        "unknown": [[np.round(ring, 3).tolist() for ring in footprint(wall)] for wall in drawn.unknown],
    }


def _unknown(wall: DrawnShape, when: float | None) -> list[Trace]:
    """Return the edges of an obstacle that nobody knew of, and its faces, which are shown once it is seen."""
    corners, triangles = surface(wall)
    faces = {
        "type": "mesh3d",
        "name": "Unknown obstacle",
        **{axis: packed(corners[:, k]) for k, axis in enumerate("xyz")},
        **{axis: packed(triangles[:, k]) for k, axis in enumerate("ijk")},
        "hoverinfo": "skip",
        "meta": {"role": "unknown", "seen": when},
    }
    if isinstance(wall, Voxels):
        return [faces]
    edges = trace("scatter3d", "lines", "Unknown obstacle", _xyz(outline(wall)), None, {"role": "ghost"}, line={})
    return [edges, faces]


def _row(one: Prediction) -> list[float | None]:
    points, times = np.array(one.motion.points), one.motion.times
    velocity = (points[-1] - points[0]) / (times[-1] - times[0]) if len(times) > 1 else np.zeros(3)
    doubt = one.doubt
    grows = (doubt.radius, doubt.growth, doubt.acceleration, doubt.accelerating_for if doubt.acceleration else 0.0)
    return [one.mover, *flat([times[0], *points[0], *velocity, *grows])]


def _way(way: CommittedWay) -> dict[str, Any]:
    kept = np.unique(np.r_[0 : len(way.times) : PAGE_STRIDE, len(way.times) - 1])
    return {
        "since": way.since,
        "brakes": way.brakes,
        "times": flat(way.times[kept]),
        "positions": [flat(column) for column in way.places[kept].T],
    }


def _xyz(points: Floats) -> Trace:
    return {axis: flat(points[:, column]) for column, axis in enumerate("xyz")}
