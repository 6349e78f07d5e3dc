"""The world as plotly traces: the ground, a mesh and edges for each kind of shape, and the bounds."""

from collections.abc import Iterator, Sequence

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.draw.ground_relief import relit
from skyverse.draw.palette import GROUND
from skyverse.draw.plotly_values import Trace, columns, mesh, packed, plain, trace
from skyverse.draw.scenes import Scene
from skyverse.draw.shape_geometry import below, brightness, outline, skin, surface
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES, ShapeKind
from skyverse.model.shapes import Box, Voxels


def terrain(scene: Scene) -> list[Trace]:
    """Return the ground as a shaded surface; an empty list without a terrain."""
    if scene.world.relief is None:
        return []
    off = {"show": False, "highlight": False}
    ground = {
        "type": "surface",
        "name": "Terrain",
        "x": packed(scene.world.relief.x),
        "y": packed(scene.world.relief.y),
        "z": packed(scene.world.relief.z.T),
        "surfacecolor": packed(relit(scene.world.relief, scene.world.stretch).T),
        "cmin": 0,
        "cmax": 1,
        "colorscale": [[k / (len(GROUND) - 1), tone] for k, tone in enumerate(GROUND)],
        "showscale": False,
        "hoverinfo": "skip",
        "contours": dict.fromkeys("xyz", off),
        "meta": {"role": "terrain"},
    }
    return [ground]


def kind(kind: ShapeKind, number: int, top: float) -> Trace:
    """Return all shapes of a kind, as far as they are below z = `top`, as one mesh, which is fast for thousands."""
    points, faces = [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
    first = 0
    for corners, triangles in _surfaces(kind, top):
        points.append(corners)
        faces.append(triangles + first)
        first += len(corners)
    triangles, corners = np.concatenate(faces), np.concatenate(points)
    shaded = {
        "intensity": packed(brightness(_normals(corners[triangles]))),
        "intensitymode": "cell",
        "cmin": 0,
        "cmax": 1,
    }
    shading = shaded | {"showscale": False} if kind.solid else {}
    return mesh(plain(kind.name), corners, triangles, {"role": "kind", "kind": number}, flatshading=True, **shading)


def _normals(triangles: Floats) -> Floats:
    """Return vectors, (m, 3), across triangles, (m, 3, 3)."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def _surfaces(kind: ShapeKind, top: float) -> Iterator[tuple[Floats, Ints]]:
    """Yield surfaces, points (n, 3) and triangles (m, 3); boxes that touch and are seen through have one together."""
    shapes = [below(shape, top) for shape in kind.shapes]
    together = set() if kind.solid else touching(shapes)
    whole = united([shape for k, shape in enumerate(shapes) if k in together and isinstance(shape, Box)])
    if whole is not None:
        yield whole
    for k, shape in enumerate(shapes):
        if whole is None or k not in together:
            yield surface(shape, kind.sides)


def edges(scene: Scene) -> list[Trace]:
    """Return the edges of each kind as one line; those of too many shapes are omitted, as they would hide the faces."""
    mapped, top = scene.world.mapped, float(scene.world.high[2])
    return [
        _line(
            f"Edges: {plain(kind.name)}",
            np.concatenate([outline(below(shape, top), kind.sides) for shape in kind.shapes]),
            {"role": "edge", "kind": number},
        )
        for number, kind in enumerate(scene.world.kinds)
        if kind.shapes and (len(kind.shapes) <= MAX_EDGED_SHAPES if mapped else kind.hard)
    ]


def bounds(scene: Scene) -> Trace:
    """Return the edges of the bounds; an empty line where there is a terrain."""
    given = scene.scenario.bounds
    frame = np.empty((0, 3)) if scene.world.relief is not None else outline(Box(min=given.min, max=given.max))
    return _line("Bounds", frame, {"role": "bounds"})


def _line(name: str, points: Floats, meta: Trace) -> Trace:
    return trace("scatter3d", "lines", name, columns(points, form=packed), None, meta)


MAX_BOXES = 2_000
"""The largest number of boxes that are compared with each other."""
MAX_CELLS = 2_000_000
"""The largest number of cells into which the boxes' sides may cut space."""


def touching(shapes: Sequence[object]) -> set[int]:
    """Return the indices of the boxes among some shapes that touch or overlap another one of them."""
    rows = [k for k, shape in enumerate(shapes) if isinstance(shape, Box)]
    if not 1 < len(rows) <= MAX_BOXES:
        return set()
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    low, high = np.array([box.min for box in boxes]), np.array([box.max for box in boxes])
    meet = np.ones((len(boxes), len(boxes)), dtype=bool)
    for axis in range(3):
        meet &= low[:, None, axis] <= high[:, axis]
        meet &= low[:, axis] <= high[:, None, axis]
    np.fill_diagonal(meet, False)
    return {rows[k] for k in np.flatnonzero(meet.any(axis=1))}


def united(boxes: Sequence[Box]) -> tuple[Floats, Ints] | None:
    """Return the points (n, 3) and triangles (m, 3) of the surface of some boxes; ``None`` for none, or too many.

    Seen through, two boxes that share a wall would otherwise be darker there than anywhere else.
    """
    corners = np.array([(box.min, box.max) for box in boxes], dtype=np.float64).reshape(-1, 2, 3)
    sides = [np.unique(corners[:, :, axis]) for axis in range(3)]
    shape = [len(places) - 1 for places in sides]
    if min(shape, default=0) < 1 or np.prod(shape, dtype=float) > MAX_CELLS:
        return None
    cells = np.zeros(shape, dtype=bool)
    first, last = (
        np.column_stack([np.searchsorted(sides[axis], corners[:, end, axis]) for axis in range(3)]) for end in (0, 1)
    )
    for low, high in zip(first, last, strict=True):
        cells[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = True
    numbered = skin(Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=cells)).astype(np.int64)
    quads = np.stack([sides[axis][numbered[:, :, axis]] for axis in range(3)], axis=-1)
    start = 4 * np.arange(len(quads))[:, None]
    return quads.reshape(-1, 3), np.vstack([start + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
