"""What is kept around flights as plotly traces: tracking errors, columns, separations, ceiling, landing places."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.draw.mover_traces import ways_and_edges, when_they_are_drawn
from skyverse.draw.plotly_values import NOWHERE, Trace, columns, mesh, packed, plain, trace
from skyverse.draw.scenes import LandingPlace, Scene
from skyverse.draw.shape_geometry import surface
from skyverse.draw.track import DrawnTrack, few
from skyverse.model.shapes import Cylinder

MIN_DEVIATION = 0.15
"""The lines at the corners of a tube are drawn to this share of the tracking error."""
PAD_SIDES = 16
"""Sides of the polygon that stands for a pad's circle."""
LEVEL = 1e-6
"""A piece of a line that runs less than this share of its length horizontally is taken for a vertical one."""


def tube(track: DrawnTrack, number: int, tolerance: float) -> list[Trace]:
    """Return the tube in which a UAV may stray from its trajectory; an empty list where it keeps to it exactly."""
    aside, up = track.error.horizontal, track.error.vertical
    line = track.nominal
    if len(line) < 2 or aside + up == 0:
        return []
    line = line[few(line, max(tolerance, MIN_DEVIATION * min(reach for reach in (aside, up) if reach)))]
    points, triangles = duct(line, aside, up)
    named = f"{plain(track.name)}: tracking error"
    return [mesh(named, points, triangles, {"role": "tube", "uav": number}, color=track.colour)]


def duct(line: Floats, aside: float, up: float) -> tuple[Floats, Ints]:
    """Return the surface that encloses an upright cylinder moved along a line (n, 3): points, (4 n, 3), and triangles.

    Across the line it is a rectangle, as wide as the cylinder, and as high as the cylinder looks along the line: of the
    radius `aside` and half the height `up`, metres, it reaches `up` above a level line, and `aside` beside a vertical
    one.
    """
    ahead = np.gradient(line, axis=0)
    flat, long = np.linalg.norm(ahead[:, :2], axis=1), np.linalg.norm(ahead, axis=1)
    level = np.flatnonzero(flat > LEVEL * long)
    east_north = np.tile((1.0, 0.0), (len(line), 1))
    if len(level):  # where the line is vertical, the surface is turned as it is nearby
        nearest = level[np.abs(np.arange(len(line))[:, None] - level).argmin(axis=1)]
        east_north = ahead[nearest, :2] / flat[nearest, None]
    steep = ahead[:, 2] / np.where(long > 0, long, 1)
    gentle = np.sqrt(np.maximum(0, 1 - steep**2))
    reach = aside * np.abs(steep) + up * gentle
    left = aside * np.column_stack([-east_north[:, 1], east_north[:, 0], np.zeros(len(line))])
    top = reach[:, None] * np.column_stack([-steep[:, None] * east_north, gentle])
    corners = np.stack([line + left + top, line - left + top, line - left - top, line + left - top], axis=1)
    first = 4 * np.arange(len(line) - 1)[:, None]
    k, after = np.arange(4), (np.arange(4) + 1) % 4
    walls = [(first + k, first + after, first + 4 + after), (first + k, first + 4 + after, first + 4 + k)]
    last = 4 * (len(line) - 1)
    ends = np.array([(0, 2, 1), (0, 3, 2), (last, last + 1, last + 2), (last, last + 2, last + 3)])
    triangles = np.concatenate([np.stack(corner, axis=-1).reshape(-1, 3) for corner in walls] + [ends])
    return corners.reshape(-1, 3), triangles


def pads(scene: Scene) -> list[Trace]:
    """Return the pads at starts and targets, where the tracking error does not count for what the UAV stands on."""
    made = []
    for uav, end, ((x, y, z), radius, _, top) in scene.pads:
        track = scene.tracks[uav]
        points, triangles = surface(Cylinder(centre=(x, y), radius=radius, low=z, high=top), PAD_SIDES)
        named = f"{plain(track.name)}: pad at {plain(end)}"
        made.append(mesh(named, points, triangles, {"role": "pad", "uav": uav}, color=track.colour))
    return made


def told(scene: Scene) -> str:
    """Return sentences that say what the drawn margins and movers are; empty where there are none."""
    rings = "Rings: half the separation of each UAV." if separations(scene) else ""
    straying = any(track.error.horizontal + track.error.vertical > 0 for track in scene.tracks)
    tubes = "Tubes: how far UAVs may stray." if straying else ""
    darker = "Cylinders at their ends: pads, where that does not count for what UAVs stand on." if scene.pads else ""
    return " ".join(filter(None, [rings, tubes, darker, ways_and_edges(scene), when_they_are_drawn(scene)]))


def separations(scene: Scene) -> list[Trace]:
    """Return the line of the rings of half the separation around the UAVs, which the page fills in as they move."""
    if not any(aside for aside, _ in scene.separations):
        return []
    return [trace("scatter3d", "lines", "Separation", NOWHERE, None, {"role": "separation"}, line={"width": 2})]


def ceiling(scene: Scene) -> list[Trace]:
    """Return the ceiling above ground, of which the page makes a surface.

    The page knows the ground; where the ceiling is counted from a lower surface, that comes with it.
    """
    most, ground, drawn = scene.scenario.max_height, scene.scenario.terrain, scene.world.relief
    if most is None or ground is None or drawn is None:
        return []
    meta: dict[str, object] = {"role": "ceiling", "above": most}
    if ground.lowest is not None:
        places = np.stack(np.meshgrid(drawn.x, drawn.y, indexing="ij"), axis=-1)
        meta["base"] = packed(ground.lowest_ground.height(places).T)
    rim = trace("scatter3d", "lines", "Ceiling's rim", {"x": [], "y": [], "z": []}, None, {"role": "rim"})
    return [{"type": "mesh3d", "name": f"Ceiling, {most:g} m above ground", "hoverinfo": "skip", "meta": meta}, rim]


def landings_in_space(scene: Scene) -> list[Trace]:
    """Return, for each UAV, the descents to its landing places, marked where they begin."""
    made = []
    for track, own, feet, named in _landings(scene):
        tops = np.column_stack([feet[:, :2], [place.level for place in own]])
        line = np.stack([feet, tops, np.full_like(feet, np.nan)], axis=1).reshape(-1, 3)
        named["text"] = [word for word in named["text"] for _ in range(3)]
        sizes = [size for _ in own for size in (0, 6, 0)]
        marker = {"symbol": "square", "color": track.colour, "size": sizes, "opacity": 1}
        style = {"color": track.colour, "width": 2, "dash": "dot"}
        made.append(
            {"type": "scatter3d", "mode": "lines+markers", **columns(line), "marker": marker, "line": style, **named}
        )
    return made


def landings_on_map(scene: Scene) -> list[Trace]:
    """Return, for each UAV, its landing places on the map."""
    made = []
    for track, _, feet, named in _landings(scene):
        marker = {"symbol": "square-open", "color": track.colour, "size": 13, "line": {"width": 2.5}}
        made.append({"type": "scatter", "mode": "markers", **columns(feet, "xy", packed), "marker": marker, **named})
    return made


def _landings(scene: Scene) -> Iterator[tuple[DrawnTrack, list[LandingPlace], Floats, Trace]]:
    """Yield of each UAV that has landing places its track, these places, their positions (k, 3), and their names."""
    for number, track in enumerate(scene.tracks):
        own = [place for place in scene.landings if place.uav == number]
        if own:
            named: Trace = {
                "name": f"{plain(track.name)}: where it may land",
                "text": [plain(place.words) for place in own],
            }
            named |= {"hovertemplate": "%{text}<extra></extra>", "meta": {"role": "landing", "uav": number}}
            yield track, own, np.array([place.position for place in own], dtype=np.float64), named
