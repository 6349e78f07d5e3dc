"""Movers on pages: their ways as thin lines, and the edges of each with its doubt, which the page moves."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.plotly_values import Trace, flat, trace
from skyverse.draw.scene import Scene
from skyverse.draw.shape_geometry import outline
from skyverse.model.mover import Ellipsoid, Mover
from skyverse.model.shapes import Box, Cylinder, Sphere

SAMPLES = 400
"""Instants at which a mover's way is sampled; on pages it moves straight from one to the next."""


def movers_in_space(scene: Scene) -> list[Trace]:
    """Return the movers' ways during the mission, and the line of their edges, which the page fills in as they move."""
    if not scene.scenario.movers:
        return []
    gap = np.full((1, 3), np.nan)
    ways = np.vstack([row for mover in scene.scenario.movers for row in (mover.at(_instants(scene)), gap)])
    way = trace("scatter3d", "lines", "Movers' ways", _xyz(ways), None, {"role": "way"}, line={"width": 1.5})
    nowhere = {"x": [None], "y": [None], "z": [None]}
    return [way, trace("scatter3d", "lines", "Movers", nowhere, None, {"role": "mover"}, line={"width": 3})]


def mover_motions(scene: Scene) -> list[dict[str, Any]]:
    """Return for each mover what the page moves: where its point is and when, its edges, and how its doubt moves these.

    `edges` are relative to the moving point; each of their points moves by `outwards` for each metre of doubt.
    """
    instants = _instants(scene)
    drawn = []
    for mover in scene.scenario.movers:
        edges = _edges(mover, 0.0)
        drawn.append(
            {
                "times": flat(instants),
                "positions": [flat(column) for column in mover.at(instants).T],
                "doubt": flat(mover.doubt.at(instants)),
                "edges": [flat(column) for column in edges.T],
                "outwards": [flat(column) for column in (_edges(mover, 1.0) - edges).T],
            }
        )
    return drawn


def ways_and_edges(scene: Scene) -> str:
    """Return a sentence that says how movers are drawn; empty where there are none."""
    if not scene.scenario.movers:
        return ""
    doubtful = any(mover.doubt.radius + mover.doubt.growth > 0 for mover in scene.scenario.movers)
    return f"Movers: their edges{', with their doubt' if doubtful else ''}, and thin lines for their ways."


def _instants(scene: Scene) -> Floats:
    return np.linspace(0.0, scene.makespan or 1.0, SAMPLES)


def _edges(mover: Mover, more: float) -> Floats:
    """Return the edges of a mover's shape that is grown by some metres, (n, 3), with gaps of nan."""
    shape = mover.shape
    match shape:
        case Box():
            low, high = np.array(shape.min) - more, np.array(shape.max) + more
            return outline(Box(min=tuple(low.tolist()), max=tuple(high.tolist())))
        case Cylinder():
            grown = {"radius": shape.radius + more, "low": shape.low - more, "high": shape.high + more}
            return outline(shape.model_copy(update=grown))
        case Sphere():
            return outline(shape.model_copy(update={"radius": shape.radius + more}))
        case Ellipsoid():
            axes = np.array([shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z])
            unit = outline(Sphere(centre=(0, 0, 0), radius=1.0))
            return np.array(shape.centre) + unit * axes * (1.0 + more / axes.min())
    raise TypeError(f"a mover cannot be a {type(shape).__name__}")


def _xyz(points: Floats) -> Trace:
    return {axis: flat(points[:, column]) for column, axis in enumerate("xyz")}
