"""Fences are drawn as low walls within the picture, and fill neither it nor the map."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.draw import faces, from_above, in_space, scenario_scene, surface
from traces import columns, of_role

RING = ((-120.0, -120.0), (120.0, -120.0), (120.0, 120.0), (-120.0, 120.0))
AREA = ((-60.0, -60.0), (60.0, -50.0), (50.0, 60.0), (-60.0, 60.0))


@pytest.fixture(params=[False, True])
def drawn(request):
    """A fence around an area, with and without ground."""
    fence = sky.Prism(vertices=RING, holes=(AREA,), low=-20, high=120, solid=False, kind="fence")
    heights = np.array([[0.0, 0.0], [20.0, 10.0]])
    ground = sky.Terrain(origin=(-100, -100), step=(200, 200), heights=heights, clearance=5) if request.param else None
    bounds = sky.Bounds(min=(-100, -100, 0), max=(100, 100, 100))
    uav = sky.UAV(name="a", start=(-40, 0, 60))
    return scenario_scene(
        sky.Scenario(name="f", bounds=bounds, obstacles=(fence,), clearance=2, terrain=ground, uavs=(uav,))
    )


def test_a_fence_is_a_low_wall_around_its_area(drawn):
    (kind,) = drawn.world.kinds
    (wall,) = kind.shapes
    assert (kind.name, kind.count, kind.solid) == ("fence", 1, False)
    points, triangles = surface(wall)
    low, high = drawn.world.low, drawn.world.high
    assert (points >= low).all()
    assert (points <= high).all()
    ground = 20.0 if drawn.world.relief is not None else 0.0
    assert points[:, 2].max() == pytest.approx(ground + 0.15 * (high[2] - low[2]))
    corners = points[triangles]
    assert (np.ptp(corners[:, :, :2], axis=1).max(axis=1) > 0).all()
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.abs(normals[:, 2]).max() == 0.0  # no floor and no roof
    assert len(faces(wall)) == 8


def test_the_map_shows_the_edge_of_a_fence_alone(drawn):
    (flat,) = of_role(from_above(drawn)["traces"], "kind")
    assert flat["fill"] == "none"
    line = columns(flat, "xy")
    assert np.nanmax(np.abs(line)) <= 100.0
    assert {(round(x), round(y)) for x, y in line[~np.isnan(line[:, 0])].tolist()} >= {(60, -50), (50, 60)}
    (edge,) = of_role(in_space(drawn), "edge")
    assert len(columns(edge, "xyz"))
