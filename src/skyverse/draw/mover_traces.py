"""Movers and zones with active times on pages: ways as thin lines, and edges and names, which the page moves."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.plotly_values import NOWHERE, Trace, columns, flat, packed, plain, trace
from skyverse.draw.scenes import Scene
from skyverse.draw.shape_geometry import footprint, grown, outline
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Voxels, Zone
from skyverse.model.timed_shapes import temporary_zones

SAMPLES = 400
"""Instants at which a mover's way is sampled; on pages it moves straight from one to the next."""


MAX_NAMED_MOVERS = 12
"""The names of more movers would hide the scene."""


def movers_in_space(scene: Scene) -> list[Trace]:
    """Return the movers' ways during the mission, and their edges and names, which the page fills in as they move."""
    movers = scene.scenario.movers
    if not movers:
        return []
    ways = _ways(scene)
    way = trace("scatter3d", "lines", "Movers' ways", columns(ways), None, {"role": "way"}, line={"width": 1.5})
    edges = trace("scatter3d", "lines", "Movers", NOWHERE, None, {"role": "mover"}, line={"width": 3})
    names = [plain(mover.name) for mover in movers] if len(movers) <= MAX_NAMED_MOVERS else []
    first = columns(np.array([mover.at(0.0)[0] for mover in movers[: len(names)]]).reshape(-1, 3))
    named = trace("scatter3d", "text", "Movers' names", first, None, {"role": "mover-name"}, text=names)
    return [way, edges, *([named] if names else [])]


def ways_on_map(scene: Scene) -> list[Trace]:
    """Return the movers' ways during the mission, seen from above."""
    if not scene.scenario.movers:
        return []
    ways = _ways(scene)
    points = columns(ways, "xy", packed)
    return [trace("scatter", "lines", "Movers' ways", points, None, {"role": "way"}, line={"width": 1.2})]


def mover_motions(scene: Scene) -> list[dict[str, Any]]:
    """Return for each mover what the page moves: where its point is and when, its edges, and how its doubt moves these.

    `edges`, in space, and `ring`, seen from above, are relative to the moving point; each of their points moves by
    `outwards`, or `ring_outwards`, for each metre of doubt.
    """
    instants = _instants(scene)
    drawn = []
    for number, mover in enumerate(scene.scenario.movers):
        (edges, ring), (far, wide) = (
            (outline(shape), footprint(shape)[0]) for shape in (grown(mover, 0.0), grown(mover, 1.0))
        )
        drawn.append(
            {
                "name": mover.name if number < MAX_NAMED_MOVERS >= len(scene.scenario.movers) else "",
                "times": flat(instants),
                "positions": [flat(column) for column in mover.at(instants).T],
                "doubt": flat(mover.doubt.at(instants)),
                "edges": [flat(column) for column in edges.T],
                "outwards": [flat(column) for column in (far - edges).T],
                "ring": [flat(column) for column in ring.T],
                "ring_outwards": [flat(column) for column in (wide - ring).T],
            }
        )
    return drawn


def ways_and_edges(scene: Scene) -> str:
    """Return a sentence that says how movers are drawn; empty where there are none."""
    if not scene.scenario.movers:
        return ""
    doubtful = any(mover.doubt.radius > 0 or mover.doubt.grows for mover in scene.scenario.movers)
    return f"Movers: their edges{', with their doubt' if doubtful else ''}, and dotted lines for their ways."


def _instants(scene: Scene) -> Floats:
    return np.linspace(0.0, scene.makespan or 1.0, SAMPLES)


def _ways(scene: Scene) -> Floats:
    """Return where the movers are during the mission, (n, 3) metres, with gaps of nan between them."""
    gap = np.full((1, 3), np.nan)
    return np.vstack([row for mover in scene.scenario.movers for row in (mover.at(_instants(scene)), gap)])


def active_zones_in_space(scene: Scene) -> list[Trace]:
    """Return the line of the edges of active zones, which the page fills in as time passes."""
    if not temporary_zones(scene.scenario):
        return []
    return [trace("scatter3d", "lines", "Active zones", NOWHERE, None, {"role": "active"}, line={"width": 4})]


def active_zones(scene: Scene) -> list[dict[str, Any]]:
    """Return for each zone with active times its edges, and from when until when it is active; open ends are None."""
    zones = [scene.scenario.zones[number] for number in temporary_zones(scene.scenario)]
    return [{"spans": zone.active, "edges": [flat(column) for column in _edges(zone).T]} for zone in zones]


def when_they_are_drawn(scene: Scene) -> str:
    """Return a sentence that says how zones with active times are drawn; empty where there are none."""
    return "Zones with active times: edges drawn while they are active." if temporary_zones(scene.scenario) else ""


def _edges(zone: Zone) -> Floats:
    """Return the edges of a zone; of voxels, which have none, those of the box around them."""
    if isinstance(zone, Voxels):
        low, high = extent(zone)
        return outline(Box(min=low, max=high))
    return outline(zone)
