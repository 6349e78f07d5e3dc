"""Zones with active times on pages: their edges are drawn in one colour while they are active."""

from typing import Any

from skyverse._typing import Floats
from skyverse.draw.plotly_values import Trace, flat, trace
from skyverse.draw.scene import Scene
from skyverse.draw.shape_geometry import outline
from skyverse.model.shape_extent import extent
from skyverse.model.shapes import Box, Voxels, Zone
from skyverse.model.temporary_zones import temporary_zones


def active_zones_in_space(scene: Scene) -> list[Trace]:
    """Return the line of the edges of active zones, which the page fills in as time passes."""
    if not temporary_zones(scene.scenario):
        return []
    nowhere = {"x": [None], "y": [None], "z": [None]}
    return [trace("scatter3d", "lines", "Active zones", nowhere, None, {"role": "active"}, line={"width": 4})]


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
