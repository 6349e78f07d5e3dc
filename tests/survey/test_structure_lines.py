"""Photo lines of structures show every wall: dense samples are seen by a plain pinhole camera, however it errs."""

import math

import numpy as np
import pytest

import skyverse as sky
from skyverse.errors import InputError
from skyverse.model.shapes import Terrain
from skyverse.space.world import World
from skyverse.survey.facets import facets_of
from skyverse.survey.structure_lines import structure_lines

BOX = sky.Box(min=(0.0, 0.0, 0.0), max=(30.0, 12.0, 15.0), name="a")
BESIDE = sky.Box(min=(30.0, 4.0, 0.0), max=(50.0, 10.0, 8.0), name="b")
YARD = sky.Prism(
    vertices=((0, 0), (30, 0), (30, 30), (20, 42), (0, 30)),
    holes=(((8, 8), (22, 8), (22, 22), (8, 22)),),
    low=0.0,
    high=12.0,
    name="a",
)
TANK = sky.Cylinder(centre=(10.0, 5.0), radius=9.0, low=0.0, high=14.0, name="a")
BALL = sky.Sphere(centre=(10.0, 5.0, 16.0), radius=6.0, name="a")
VOXELS = sky.Voxels(origin=(0, 0, 0), step=(3, 3, 3), occupied=np.ones((10, 4, 5), dtype=bool), name="a")
ERROR = {"horizontal": 0.4, "vertical": 0.6}


def scenario(*obstacles, error=ERROR, terrain=None, clearance=2.0, **survey):
    given = {"structures": ("a",), "camera": "mavic-3e", "gsd": "3 mm", **survey}
    return sky.Scenario(
        name="structure",
        bounds={"min": (-60, -60, 0), "max": (100, 90, 80)},
        clearance=clearance,
        obstacles=obstacles,
        terrain=terrain,
        uavs=(sky.UAV(start=(-50, -50, 20), end="home", tracking_error=error),),
        surveys=(sky.Survey(**given),),
    )


def photos(lines):
    """Return x, y, z, heading, pitch of all photos, which stand at equal steps along their lines."""
    rows = []
    for line in lines:
        count = round(math.dist(line.path[0][:2], line.path[-1][:2]) / line.every) + 1 if line.every else 1
        rows += [(*place, line.heading, line.pitch) for place in np.linspace(line.path[0], line.path[-1], count)]
    return np.array(rows)


def wall_samples(rings, low, high, step=0.4):
    """Return places (n, 3) on upright walls and their outward normals, a centimetre in front of the walls."""
    places, normals = [], []
    for ring in rings:
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            along = np.linspace(a, b, max(2, int(math.dist(a, b) / step)) * 2 + 1)[1::2]
            normal = np.array([b[1] - a[1], a[0] - b[0], 0.0]) / math.dist(a, b)
            for z in np.arange(low + 0.05, high, step):
                places.append(np.column_stack([along, np.full(len(along), z)]) + 0.01 * normal)
                normals.append(np.tile(normal, (len(along), 1)))
    return np.concatenate(places), np.concatenate(normals)


def seen_by_all_errors(views, places, normals, survey, error, hidden, seed=0):
    """Tell of each place whether one photo shows it in all of 24 random errors: a rotation, and a stray position."""
    rng, camera = np.random.default_rng(seed), survey.camera
    wide, high = camera.half_widths
    sure = np.zeros(len(places), dtype=bool)
    for x, y, z, heading, pitch in views:
        h, p = np.radians((heading, pitch))
        ahead = np.array([math.cos(p) * math.sin(h), math.cos(p) * math.cos(h), math.sin(p)])
        right = np.array([math.cos(h), -math.sin(h), 0.0])
        axes = np.array([ahead, right, np.cross(right, ahead)])
        shown = np.ones(len(places), dtype=bool)
        for k in range(25):
            turn = rng.normal(size=3)
            turn *= (k > 0) * math.radians(camera.attitude_error) / np.linalg.norm(turn)
            angle = np.linalg.norm(turn)
            skew = np.cross(np.eye(3), turn / max(angle, 1e-12))
            spun = axes @ (np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew)
            round_, up = rng.uniform(0, 2 * math.pi), rng.choice([-1, 1])
            stray = np.array([math.cos(round_), math.sin(round_), 0.0]) * error["horizontal"]
            eye = np.array([x, y, z]) + (k > 0) * (stray + np.array([0, 0, up * error["vertical"]]))
            depth, across, above = spun @ (places - eye).T
            shown &= (np.abs(across) <= wide * depth) & (np.abs(above) <= high * depth)
            if survey.gsd is not None:
                shown &= depth * camera.pixel <= survey.gsd + 1e-9
            sight = (places - eye) / np.linalg.norm(places - eye, axis=1)[:, None]
            shown &= -(sight * normals).sum(axis=1) >= math.cos(math.radians(75.0))
        which = np.flatnonzero(shown & ~sure)
        sure[which[~hidden(np.array([x, y, z]), places[which])]] = True
    return sure


def behind_boxes(*boxes):
    """Return a function that tells whether a box is between an eye (3,) and places (n, 3), by 200 samples of sights."""

    def hidden(eye, places):
        at = eye + np.linspace(0, 1, 200)[:, None, None] * (places - eye)
        return np.any([((at > one.min) & (at < one.max)).all(axis=2).any(axis=0) for one in boxes], axis=0)

    return hidden


def never(eye, places):
    return np.zeros(len(places), dtype=bool)


def rings_of(shape):
    if isinstance(shape, sky.Box):
        (x, y, _), (u, v, _) = shape.min, shape.max
        return [np.array([(x, y), (u, y), (u, v), (x, v)], dtype=float)]
    if isinstance(shape, sky.Cylinder):
        turn = np.linspace(0, 2 * np.pi, 73)[:-1]
        return [np.array(shape.centre) + shape.radius * np.column_stack([np.cos(turn), np.sin(turn)])]
    return [np.array(shape.vertices, dtype=float), np.array(shape.holes[0], dtype=float)[::-1]]


@pytest.mark.parametrize("pattern", ["facade", "orbit", "viewpoints"])
@pytest.mark.parametrize("shape", [BOX, TANK, YARD], ids=["box", "tank", "yard"])
def test_every_place_of_the_walls_is_seen(pattern, shape):
    given = scenario(shape, pattern=pattern, clearance=1.0)
    found = structure_lines(given, 0)
    assert found.unseen == ()
    low, high = (shape.min[2], shape.max[2]) if isinstance(shape, sky.Box) else (shape.low, shape.high)
    places, normals = wall_samples(rings_of(shape), low, high)
    assert seen_by_all_errors(photos(found.lines), places, normals, given.surveys[0], ERROR, never).all()


@pytest.mark.parametrize("pattern", ["facade", "orbit", "viewpoints"])
def test_all_lines_are_clear(pattern):
    given = scenario(BOX, BESIDE, pattern=pattern)
    world = World(given, given.uavs[0].tracking_error)
    for line in structure_lines(given, 0).lines:
        assert world.free(line.path).all()
        assert world.segments_free(line.path[:-1], line.path[1:]).all()


def test_a_ball_and_a_mesh_are_seen():
    given = scenario(BALL, pattern="viewpoints")
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(1000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    places = np.array(BALL.centre) + (BALL.radius + 0.01) * normals
    found = structure_lines(given, 0)
    gaps = np.array([np.mean(gap.outline, axis=0) for gap in found.unseen]).reshape(-1, 3)
    near = np.linalg.norm(places[:, None] - gaps, axis=2).min(axis=1, initial=np.inf) < 3.0
    assert (seen_by_all_errors(photos(found.lines), places, normals, given.surveys[0], ERROR, never) | near).all()
    assert near.mean() < 0.35  # from below, where a gimbal looks up by 30 degrees at most
    corners = [((0, 0, 5), (12, 0, 5), (12, 0, 20)), ((0, 0, 5), (12, 0, 20), (0, 6, 20))]
    hull = sky.Prism(vertices=((0, 0), (12, 0), (0, 6)), low=5.0, high=20.0, solid=False)
    mesh = scenario(hull, structures=(), facets=corners, pattern="viewpoints")
    found = structure_lines(mesh, 0)
    assert found.unseen == ()
    for a, b, c in np.array(corners, dtype=float):
        share = rng.dirichlet((1, 1, 1), size=400)
        normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        places, normals = share @ np.array([a, b, c]) + 0.01 * normal, np.tile(normal, (400, 1))
        assert seen_by_all_errors(photos(found.lines), places, normals, mesh.surveys[0], ERROR, never).all()


def test_facets_in_free_air_are_refused():
    corners = [((0, 0, 5), (12, 0, 5), (12, 0, 20)), ((0, 0, 5), (12, 0, 20), (0, 6, 20))]
    hull = sky.Box(min=(0, 0, 5), max=(12, 4, 20))
    mesh = scenario(hull, structures=(), facets=corners, pattern="viewpoints")
    with pytest.raises(InputError, match=r"facets\[1\]: expected facets in obstacles .* 2 m outside"):
        structure_lines(mesh, 0)


@pytest.mark.parametrize("pattern", ["facade", "orbit", "viewpoints"])
def test_what_another_obstacle_hides_is_told(pattern):
    given = scenario(BOX, BESIDE, pattern=pattern)
    found = structure_lines(given, 0)
    places, normals = wall_samples(rings_of(BOX), 0.0, 15.0)
    hidden = behind_boxes(BOX, BESIDE)
    seen = seen_by_all_errors(photos(found.lines), places, normals, given.surveys[0], ERROR, hidden)
    untold = [p for p in places[~seen] if not any(around(gap.outline, p) for gap in found.unseen)]
    assert untold == []
    assert {gap.why for gap in found.unseen} <= {"hidden by 'b'", "too near 'b' to be flown before"}
    assert 48.0 <= sum(gap.area for gap in found.unseen) < 70.0  # 6 m by 8 m touch, and whole facets are told


def around(outline, place):
    low, high = np.min(outline, axis=0), np.max(outline, axis=0)
    return ((place > low - 0.05) & (place < high + 0.05)).all()


def test_walls_are_seen_down_to_sloping_ground_and_what_is_below_it_is_not_asked_for():
    x = np.arange(-60, 101, 10.0)
    y = np.arange(-60, 91, 10.0)
    ground = Terrain(origin=(-60, -60), step=(10, 10), heights=np.tile(0.15 * (x[:, None] + 60), (1, len(y))))
    box = sky.Box(min=(0, 0, 0), max=(30, 12, 30), name="a")
    given = scenario(box, terrain=ground, pattern="facade")
    found = structure_lines(given, 0)
    assert found.unseen == ()
    places, normals = wall_samples(rings_of(box), 0.0, 30.0)
    above = places[:, 2] > ground.height(places[:, :2]) + 0.3

    def below_ground(eye, places):
        at = eye + np.linspace(0, 1, 50)[:, None, None] * (places - eye)
        return (at[..., 2] < ground.height(at[..., :2])).any(axis=0)

    seen = seen_by_all_errors(photos(found.lines), places, normals, given.surveys[0], ERROR, below_ground)
    assert seen[above].all()


@pytest.mark.parametrize("pattern", ["facade", "viewpoints"])
@pytest.mark.parametrize("shape", [BOX, VOXELS], ids=["box", "voxels"])
def test_all_of_walls_above_rough_slopes_is_planned_for(pattern, shape):
    rng, x = np.random.default_rng(5), np.arange(-60, 104, 4.0)
    heights = 0.25 * (x[:, None] - 8.0) + 0.1 * (x - 6.0) + rng.normal(0, 0.3, (len(x), len(x))) + 6.0
    ground = Terrain(origin=(-60, -60), step=(4, 4), heights=np.maximum(heights, 0.0))
    given = scenario(shape, terrain=ground, pattern=pattern)
    facets = facets_of(given, given.surveys[0], 3.0)
    assert (facets.normal[:, 2] == 0.0).all()  # roofs are not asked for
    places = wall_samples(rings_of(BOX), 0.0, 15.0)[0]
    low, high = facets.corners.min(axis=1), facets.corners.max(axis=1)
    for place in places[places[:, 2] > ground.height(places[:, :2])]:
        near = np.flatnonzero(((place >= low - 0.02) & (place <= high + 0.02)).all(axis=1))
        assert any(above_foot(facets.corners[k], place) for k in near), place


def above_foot(corners, place):
    """Return whether a place before an upright facet is above its lower edge and below its upper one."""
    along = corners[:, :2] @ (way := corners[2, :2] - corners[0, :2])
    left, right = corners[np.isclose(along, along.min())][:, 2], corners[np.isclose(along, along.max())][:, 2]
    share = (place[:2] @ way - along.min()) / np.ptp(along)
    low, high = ((1 - share) * choose(left) + share * choose(right) for choose in (np.min, np.max))
    return low - 1e-6 <= place[2] <= high + 1e-6


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"gsd": "1 mm", "clearance": 5.0}, "gsd"),
        ({"gsd": None, "height": 4.0, "clearance": 5.0}, "height"),
        ({"gimbal": -80.0, "pattern": "facade"}, "gimbal"),
        ({"error": {"horizontal": 3.0, "vertical": 3.0}, "clearance": 0.5}, "gsd"),
    ],
)
def test_what_cannot_be_flown_is_refused(changes, field):
    given = scenario(BOX, **{"pattern": "orbit", **changes})
    with pytest.raises(InputError) as caught:
        structure_lines(given, 0)
    assert caught.value.sentence.field == field


def test_zones_that_are_closed_at_times_are_kept_from():
    zone = sky.Box(min=(-20, -20, 0), max=(12, -1, 80), name="closed", active=((10.0, 20.0),))
    given = scenario(BOX, pattern="facade")
    given = sky.Scenario(**{**dict(given), "zones": (zone,)})
    for line in structure_lines(given, 0).lines:
        assert not ((line.path > np.array(zone.min) - 2.0) & (line.path < np.array(zone.max) + 2.0)).all(axis=1).any()
