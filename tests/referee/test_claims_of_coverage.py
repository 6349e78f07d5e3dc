"""Whatever stands there, a cell is claimed only if rays to all of its places are free, in every world."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import skyverse as sky
from claimed import denied
from skyverse.model.camera import CAMERAS
from skyverse.model.photos import Photos
from skyverse.model.uav import TrackingError

MIDDLE = np.array([20.0, 20.0])
"""About what structures and voxels stand."""

errors = st.builds(TrackingError, horizontal=st.sampled_from([0.0, 0.3, 1.0]), vertical=st.sampled_from([0.0, 0.5]))
attitudes = st.sampled_from([0.0, 1.0, 3.0])
seeds = st.integers(0, 2**32 - 1)


def scenario(survey, obstacles, terrain=None):
    return sky.Scenario(
        name="claims",
        bounds={"min": (-60, -60, -5), "max": (100, 100, 90)},
        clearance=0.5,
        lattice={"step": (10, 10, 10)},
        terrain=terrain,
        obstacles=obstacles,
        surveys=(survey,),
        uavs=({"start": (-50, -50, 80), "end": "home"},),
    )


def camera(attitude):
    return CAMERAS["mavic-3e"].model_copy(update={"attitude_error": attitude})


def photos_at(places, heading, pitch):
    n = len(places)
    none = np.zeros(n)
    return Photos(places, heading % 360.0, pitch, none, np.full(n, np.nan), none.astype(int), none.astype(int) - 1)


def photos_about(rng, target, near, far, count, least=-0.1):
    """Return photos from all around towards places near a target."""
    around, rise, away = rng.uniform(0, 2 * np.pi, count), rng.uniform(least, 1.4, count), rng.uniform(near, far, count)
    way = np.column_stack([np.cos(rise) * np.cos(around), np.cos(rise) * np.sin(around), np.sin(rise)])
    look = rng.normal(0, 2.0, (count, 3)) - away[:, None] * way
    heading, level = np.degrees(np.arctan2(look[:, 0], look[:, 1])), np.hypot(look[:, 0], look[:, 1])
    return photos_at(target + away[:, None] * way, heading, np.degrees(np.arctan2(look[:, 2], level)))


def hall(rng):
    """Return a bent or straight prism, or one with a court."""
    turn, size = rng.uniform(0, np.pi), rng.uniform(3, 7)
    axes = size * np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    ring = square if rng.random() < 0.5 else np.array([(-1, -1), (1, -1), (1, 0), (0.1, 0.2), (0, 1), (-1, 1)])
    holes = [(0.5 * square @ axes + MIDDLE).tolist()] if len(ring) == 4 and rng.random() < 0.5 else ()
    low = -1.0 if rng.random() < 0.6 else rng.uniform(0, 4)
    named = {"shape": "prism", "name": "hall", "kind": "building", "holes": holes}
    return named | {"vertices": (ring @ axes + MIDDLE).tolist(), "low": low, "high": low + rng.uniform(3, 10)}


def tent(rng):
    """Return facets of a roof with up to six sides, and of a wall beside it."""
    n, size, low = int(rng.integers(3, 7)), rng.uniform(3, 7), rng.uniform(0, 5)
    angle = np.sort(rng.uniform(0, 2 * np.pi, n))
    foot = np.column_stack([MIDDLE + size * np.column_stack([np.cos(angle), np.sin(angle)]), np.full(n, low)])
    top = np.array([*(MIDDLE + rng.uniform(-1, 1, 2)), low + rng.uniform(1, 6)])
    roof = [(a, b, top) for a, b in zip(foot, np.roll(foot, -1, axis=0), strict=True)]
    x = 20 + size + rng.uniform(1, 4)
    wall = [((x, 16.0, low), (x, 24.0, low), (x + rng.uniform(-1, 1), 20.0, low + 6.0))]
    return [tuple(tuple(map(float, corner)) for corner in facet) for facet in roof + wall]


def voxels(rng, low):
    """Return a heap of cells, some of them hanging in the air."""
    occupied = rng.random((4, 3, 3)) < rng.uniform(0.1, 0.6)
    occupied[0, 0, 0] = True
    return {"shape": "voxels", "name": "heap", "origin": (15, 15, low), "step": (2, 2.5, 1.5), "occupied": occupied}


def beside(rng, kind):
    """Return something between the structure and some of the cameras."""
    x, y = MIDDLE + rng.uniform(8, 14) * np.array([np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)])
    if kind == "sphere":
        return {"shape": "sphere", "centre": (x, y, rng.uniform(1, 9)), "radius": rng.uniform(0.5, 3)}
    low = rng.uniform(-1, 4)
    if kind == "cylinder":
        return {"shape": "cylinder", "centre": (x, y), "radius": rng.uniform(0.3, 2), "low": low, "high": low + 6}
    return {"shape": "box", "min": (x - 1, y - 2, low), "max": (x + 1, y + 2, low + rng.uniform(2, 8))}


@settings(max_examples=40, deadline=None)
@given(
    seed=seeds,
    mesh=st.booleans(),
    error=errors,
    attitude=attitudes,
    other=st.sampled_from(["box", "cylinder", "sphere"]),
)
@example(seed=70, mesh=False, error=TrackingError(), attitude=0.0, other="box")  # it stands in the wall
def test_rays_deny_nothing_that_is_claimed_of_walls_and_facets(seed, mesh, error, attitude, other):
    rng = np.random.default_rng(seed)
    what = {"facets": tent(rng)} if mesh else {"structures": ("hall",)}
    given_ = sky.Survey(pattern="facade", camera=camera(attitude), gsd=0.01, overlap=(0, 0), **what)
    obstacles = (beside(rng, other),) if mesh else (hall(rng), beside(rng, other))
    photos = photos_about(rng, np.array([*MIDDLE, 5.0]), 14.0, 35.0, 12)
    _, _, wrong = denied(scenario(given_, obstacles), photos, error, seed)
    assert not wrong


@settings(max_examples=20, deadline=None)
@given(seed=seeds, error=errors, attitude=attitudes, hangs=st.booleans(), relief=st.booleans())
def test_rays_deny_nothing_that_is_claimed_of_ground_about_voxels(seed, error, attitude, hangs, relief):
    rng = np.random.default_rng(seed)
    heights = rng.uniform(-1, 1, (9, 9)) if relief else None
    ground = {"origin": (-60, -60), "step": (20, 20), "heights": heights} if relief else None
    heap = voxels(rng, rng.uniform(2, 5) if hangs else -5.0)
    area = sky.Survey([(12, 11), (27, 12), (26, 28), (11, 26)], camera(attitude), gsd=0.012, overlap=(0, 0))
    photos = photos_about(rng, np.array([*MIDDLE, 0.0]), 20.0, 45.0, 8, least=0.5)
    _, _, wrong = denied(scenario(area, (heap,), ground), photos, error, seed, most=15)
    assert not wrong


def slope(rng):
    """Return ground that rises and is rough, about as high as the foot of what stands in the middle."""
    x = np.arange(-60.0, 125.0, step := rng.uniform(1.5, 20.0))
    rise = x[:, None] * rng.uniform(-0.4, 0.4) + x * rng.uniform(-0.4, 0.4)
    heights = rise - rise.mean() + rng.normal(0, 0.1 * step, rise.shape)
    return sky.Terrain(origin=(-60, -60), step=(step, step), heights=heights)


def above_ground(scenario, shape):
    """Return the area of a prism's walls above the ground, from heights at many places along them."""
    sampled = 0.0
    for ring in (shape["vertices"], *shape["holes"]):
        for a, b in zip(np.array(ring), np.roll(ring, -1, axis=0), strict=True):
            share = (np.arange(4000) + 0.5)[:, None] / 4000
            foot = np.maximum(scenario.terrain.height(a + share * (b - a)), shape["low"])
            sampled += np.maximum(shape["high"] - foot, 0.0).mean() * np.hypot(*(b - a))
    return sampled


@settings(max_examples=25, deadline=None)
@given(seed=seeds, error=errors, attitude=attitudes)
def test_all_walls_above_sloping_ground_are_judged_and_rays_deny_nothing_that_is_claimed(seed, error, attitude):
    rng = np.random.default_rng(seed)
    stands = hall(rng)
    stands |= {"low": stands["low"] - rng.uniform(0, 8)}
    given_ = sky.Survey(pattern="facade", camera=camera(attitude), gsd=0.01, overlap=(0, 0), structures=("hall",))
    world = scenario(given_, (stands,), slope(rng))
    photos = photos_about(rng, np.array([*MIDDLE, 5.0]), 14.0, 35.0, 12)
    found, _, wrong = denied(world, photos, error, seed)
    assert not wrong
    exact = above_ground(world, stands)
    assert exact - 0.01 <= found.area <= 1.04 * exact + 1.0
    assert found.seen[0] * found.area + sum(gap.area for gap in found.gaps) >= found.area - 1e-6


def test_much_is_claimed_of_walls_that_slopes_cut_aslant():
    rng = np.random.default_rng(3)
    stands = hall(rng) | {"low": -9.0, "high": 7.0, "holes": ()}
    x = np.arange(-60.0, 101.0, 4.0) - 20
    ground = sky.Terrain(origin=(-60, -60), step=(4, 4), heights=0.4 * x[:, None] + 0.1 * np.sin(x))
    given_ = sky.Survey(pattern="facade", camera=camera(1.0), gsd=0.02, overlap=(0, 0), structures=("hall",))
    photos = photos_about(rng, np.array([*MIDDLE, 2.0]), 16.0, 30.0, 90, least=0.3)
    found, claimed, wrong = denied(scenario(given_, (stands,), ground), photos, TrackingError(), 1)
    assert not wrong
    assert claimed >= 20
    assert found.seen[0] > 0.95


@pytest.mark.parametrize("mesh", [True, False])
def test_much_is_claimed_of_what_photos_from_all_sides_show(mesh):
    rng = np.random.default_rng(1)
    what = {"facets": tent(rng)} if mesh else {"structures": ("hall",)}
    given_ = sky.Survey(pattern="facade", camera=camera(1.0), gsd=0.02, overlap=(0, 0), **what)
    photos = photos_about(rng, np.array([*MIDDLE, 4.0]), 16.0, 30.0, 60)
    found, claimed, wrong = denied(scenario(given_, () if mesh else (hall(rng),)), photos, TrackingError(), 1)
    assert not wrong
    assert claimed >= 20
    assert found.seen[0] > 0.9
