"""The ground, obstacles and zones in a matplotlib figure, shaded where they are solid."""

from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.palette import LIGHT
from skyverse.draw.relief import along, cleared, relief, tinted
from skyverse.draw.scene import Scene
from skyverse.draw.shape_geometry import DrawnShape, brightness, faces, surface
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES, ShapeKind

MAX_FIGURE_HEIGHTS = 120
"""The largest number of heights along each side of the ground."""
MAX_FIGURE_SHAPES = 3_000
"""The largest number of shapes in a figure; of more, the largest ones are drawn."""


def draw_world(axes: Any, drawn: Scene) -> None:
    """Draw the world of `drawn` into 3-D axes; solid shapes are one collection, so that nearer ones hide others."""
    polygons: list[Floats] = []
    colours: list[Floats] = []
    _ground(drawn, polygons, colours)
    left = MAX_FIGURE_SHAPES
    for kind in drawn.world.kinds:
        shapes = _largest(kind, left)
        left -= len(shapes)
        if kind.solid:
            for shape in shapes:
                walls = faces(shape, kind.sides)
                polygons += walls
                colours += _lit(walls, colour(kind))
        else:
            _clear(axes, kind, shapes)
    if polygons:
        # edges of the same colour cover the seams that antialiasing would leave
        paint = np.array(colours)
        _add(axes, polygons, facecolors=paint, edgecolors=paint, linewidths=0.3, zorder=0.2, rasterized=True)


def legend_entries(drawn: Scene) -> tuple[list[Any], list[str]]:
    """Return the patches and labels of a legend, one for each kind, where the world is more than plain boxes."""
    from matplotlib.patches import Patch

    kinds = drawn.world.kinds if drawn.world.mapped else ()
    patches = [Patch(facecolor=colour(kind), alpha=1.0 if kind.solid else 0.35) for kind in kinds]
    return patches, [f"{kind.title}, at a risk" if kind.at_risk else kind.title for kind in kinds]


def colour(kind: ShapeKind) -> str:
    """Return the colour in which a kind is drawn."""
    return kind.colour or LIGHT["box" if kind.hard else "zone"]


def _ground(drawn: Scene, polygons: list[Floats], colours: list[Floats]) -> None:
    terrain = drawn.scenario.terrain
    if terrain is None:
        return
    ground = relief(terrain, drawn.world.low, drawn.world.high, MAX_FIGURE_HEIGHTS)
    lines = [line for track in drawn.tracks for line in (track.path, track.positions)]
    ground = cleared(ground, terrain, along(lines, float(ground.x[1] - ground.x[0]) / 2))
    points = np.stack([*np.meshgrid(ground.x, ground.y, indexing="ij"), ground.z], axis=-1)
    quads = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2)
    polygons += list(quads.reshape(-1, 4, 3))
    tints = tinted(ground, drawn.world.stretch)
    colours += list(((tints[:-1, :-1] + tints[1:, 1:]) / 2).reshape(-1, 3))


def _largest(kind: ShapeKind, most: int) -> list[DrawnShape]:
    if len(kind.shapes) <= most:
        return list(kind.shapes)
    sizes = np.linalg.norm(kind.extents[:, 1] - kind.extents[:, 0], axis=1)
    return [kind.shapes[k] for k in np.sort(np.argsort(-sizes)[:most])]


def _clear(axes: Any, kind: ShapeKind, shapes: list[DrawnShape]) -> None:
    """Draw transparent shapes: obstacles with their edges, zones without."""
    if kind.hard:
        walls = [face for shape in shapes for face in faces(shape, kind.sides)]
        edge = LIGHT["edge"] if kind.colour is None else kind.colour
        crowded = len(shapes) > MAX_EDGED_SHAPES
        lines = {"edgecolors": edge, "linewidths": 0.15 if crowded else 0.5}
        _add(axes, walls, facecolors=colour(kind), alpha=0.16, zorder=1, rasterized=crowded, **lines)
    else:
        cut = (surface(shape, kind.sides) for shape in shapes)
        walls = [points[triangle] for points, triangles in cut for triangle in triangles]
        _add(axes, walls, facecolors=colour(kind), edgecolors="none", alpha=0.14, zorder=0.5)


def _lit(walls: list[Floats], paint: str) -> list[Floats]:
    from matplotlib.colors import to_rgb

    normals = [np.cross(wall, np.append(wall[1:], wall[:1], axis=0)).sum(axis=0) for wall in walls]
    return [np.array(to_rgb(paint)) * light for light in brightness(np.array(normals).reshape(-1, 3))]


def _add(axes: Any, polygons: list[Floats], *, rasterized: bool = False, **style: Any) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    if polygons:
        collection = Poly3DCollection(polygons, **style)
        collection.set_rasterized(rasterized)
        collection.set_clip_on(False)
        axes.add_collection3d(collection)
