"""The picture of a survey over relief: photos of each place on the ground, strips above it, and what is proven.

Ground is drawn from the farthest cell to the nearest, and lines are hidden where ground stands before them.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple, Self

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.path import Path as Outline
from scipy.ndimage import gaussian_filter

import skyverse as sky
from skyverse.draw.photo_views import DrawnSurvey, drawn_surveys
from skyverse.model.short_lines import told_gsd, told_share

GROUND, INK, SOFT = "#10161d", "#eef3f8", "#9fb0c1"
UAVS = ("#ffb000", "#ff5fa2", "#35d0ff")
PHOTOS = LinearSegmentedColormap.from_list("photos", ["#1d5b74", "#1f9e89", "#7fd34e", "#f4e61e"])
"""From few photos of a place to many."""
HIGHER = 1.35
"""How many times as high as they are heights are drawn."""
CELL = 9.0
"""Metres between the heights of the ground that are drawn."""
SUN = np.array([-0.45, -0.60, 0.62])


class Camera(NamedTuple):
    """Whence the picture is seen: a point, and three axes, right, up and ahead."""

    eye: Any
    axes: Any

    @classmethod
    def at(cls, eye: Any, middle: Any) -> Self:
        """Return the camera at a place that looks at another, metres."""
        eye, middle = (np.array(place, dtype=float) * (1, 1, HIGHER) for place in (eye, middle))
        ahead = (middle - eye) / np.linalg.norm(middle - eye)
        right = np.cross(ahead, (0, 0, 1))
        right /= np.linalg.norm(right)
        return cls(eye, np.array([right, np.cross(right, ahead), ahead]))

    def seen(self, places: Any) -> tuple[Any, Any]:
        """Return where places, (..., 3), lie in the picture, (..., 2), and how far away they are, (...)."""
        right, up, far = np.moveaxis((np.asarray(places) * (1, 1, HIGHER) - self.eye) @ self.axes.T, -1, 0)
        return np.stack([right, up], axis=-1) / far[..., None], far


def mountain() -> Any:
    """Return the figure of a survey of a mountain at Jacksboro, planned and proven."""
    relief = sky.read("jacksboro").model_dump()
    places = np.array([(4200.0, -1900.0), (4240.0, -1860.0), (4160.0, -1940.0)])
    starts = np.column_stack([places, sky.read("jacksboro").terrain.height(places) + 40.0])
    like = {"vehicle": "camera", "end": "home", "batteries": 6, "swap": 120.0}
    area = [(2650, -1900), (3200, -2150), (3850, -1800), (3850, -1150), (3250, -850), (2700, -1100)]
    zone = {"shape": "cylinder", "centre": (4080, -1480), "radius": 90.0, "low": 0.0, "high": 900.0}
    asked = {
        "name": "mountain",
        "description": "A mountain beside the Jacksboro fault.",
        "uavs": [like | {"start": tuple(start)} for start in starts.tolist()],
        "targets": [],
        "max_height": 120.0,
        "objective": {"unit": "metres"},
        "obstacles": [zone | {"kind": "no-fly zone", "name": "eyrie"}],
        "surveys": [{"area": area, "camera": "mavic-3e", "gsd": "3.2 cm", "overlap": (75, 65), "gsd_of": "place"}],
        "wind": {"speed": 5, "from": 250, "gust": 2},
    }
    soonest = sky.MissionOptions(criterion="min-max")
    mission = sky.plan_mission(sky.Scenario.model_validate(relief | asked), rng=1, options=soonest)
    camera = Camera.at(eye=(5700, -3600, 1900), middle=(3400, -1500, 520))
    return survey_picture(mission, (2350, 4350, -2300, -600), camera)


def survey_picture(mission: sky.Mission, block: tuple[float, float, float, float], camera: Camera) -> Any:
    """Return the figure of a mission's survey, over a block of ground: west, east, south and north, metres."""
    drawn = next(drawn_surveys(mission.scenario, mission))
    figure = plt.figure(figsize=(14, 8.2), facecolor=GROUND)
    axes = figure.add_axes((0.25, 0.0, 0.755, 1.0))
    axes.set_axis_off()
    _ground(axes, camera, drawn, block)
    _zones(axes, camera, mission)
    _flights(axes, camera, mission)
    axes.set_aspect("equal")
    _words(figure, drawn, mission)
    return figure


def _height(mission: sky.Mission, places: Any) -> Any:
    terrain = mission.scenario.terrain
    assert terrain is not None
    return terrain.height(places)


def _ground(axes: Any, camera: Camera, drawn: DrawnSurvey, block: tuple[float, float, float, float]) -> None:
    west, east, south, north = block
    x, y = np.arange(west, east + 1, CELL), np.arange(south, north + 1, CELL)
    flat = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    z = drawn.scenario.terrain.height(flat)
    z = gaussian_filter(z, 12 / CELL, mode="nearest")
    slopes = np.gradient(gaussian_filter(z, 14 / CELL, mode="nearest") * HIGHER, CELL)
    normal = np.stack([-slopes[0], -slopes[1], np.ones_like(z)], axis=-1)
    light = np.clip((normal / np.linalg.norm(normal, axis=-1, keepdims=True)) @ (SUN / np.linalg.norm(SUN)), 0, 1)
    rise = np.clip((z - z.min()) / np.ptp(z), 0, 1)[..., None]
    bare = np.array(to_rgb("#4a5a66")) * (1 - rise) + np.array(to_rgb("#a9aea2")) * rise
    views = drawn.views
    assert views is not None
    i, j = (np.clip(np.searchsorted(one, at) - 1, 0, len(one) - 1) for one, at in ((views.x, x), (views.y, y)))
    count = gaussian_filter(np.maximum(views.count, 0).astype(float), 0.7)[np.ix_(i, j)]
    low, high = _counts(drawn)
    tint = PHOTOS(np.clip((count - low) / (high - low), 0, 1))[..., :3]
    inside = np.zeros(z.shape, dtype=bool)
    for ring in drawn.outlines:
        inside ^= Outline(ring[:, :2]).contains_points(flat.reshape(-1, 2)).reshape(z.shape)
    lit = np.where(
        inside[..., None],
        tint * (0.46 + 0.72 * light[..., None] ** 1.4),
        bare * (0.34 + 0.85 * light[..., None] ** 1.5),
    )
    places = np.concatenate([flat, z[..., None]], axis=-1)
    corners = np.stack([places[:-1, :-1], places[1:, :-1], places[1:, 1:], places[:-1, 1:]], axis=-2)
    seen, far = camera.seen(corners)
    order = np.argsort(-far.mean(axis=-1), axis=None)
    colours = np.clip((lit[:-1, :-1] + lit[1:, 1:]) / 2, 0, 1).reshape(-1, 3)[order]
    axes.add_collection(PolyCollection(seen.reshape(-1, 4, 2)[order], facecolors=colours, edgecolors=colours, lw=0.35))
    rings = plt.figure().add_subplot().contour(x, y, z.T, levels=np.arange(0, 2000, 25)).allsegs
    for ring in (one for level in rings for one in level if len(one) > 2):
        way = np.column_stack([ring, drawn.scenario.terrain.height(ring) + 2])
        _line(axes, camera, drawn, way, "#ffffff", 0.5, 0.16)
    floor = float(z.min()) - 120.0
    for edge in (places[-1], places[:, 0]):  # the sides that are cut
        for k in range(len(edge) - 1):
            under = [(*edge[m][:2], floor) for m in (k + 1, k)]
            side = camera.seen([edge[k], edge[k + 1], *under])[0]
            axes.fill(*side.T, color="#232d36" if edge is places[:, 0] else "#1a232b", lw=0.3)
    for ring in drawn.outlines:
        _line(axes, camera, drawn, ring + np.array([0, 0, 4]), "#ffffff", 1.6, 0.95)


def _hidden(camera: Camera, drawn: DrawnSurvey, places: Any) -> Any:
    """Tell which places, (n, 3), lie behind ground."""
    share = np.linspace(0.02, 0.6, 120)[None, :, None]
    eye = camera.eye / (1, 1, HIGHER)
    sight = places[:, None] + share**2 * (eye - places)[:, None]
    return (drawn.scenario.terrain.height(sight[..., :2]) > sight[..., 2] + 3).any(axis=1)


def _line(axes: Any, camera: Camera, drawn: Any, places: Any, colour: str, width: float, alpha: float) -> None:
    """Draw a line where no ground stands before it."""
    shown = ~_hidden(camera, drawn, places)
    pieces = camera.seen(np.stack([places[:-1], places[1:]], axis=1))[0][shown[:-1] & shown[1:]]
    axes.add_collection(LineCollection(pieces, colors=colour, linewidths=width, alpha=alpha, capstyle="round"))


def _zones(axes: Any, camera: Camera, mission: sky.Mission) -> None:
    for zone in mission.scenario.obstacles:
        around = np.linspace(0, 2 * np.pi, 120)
        ring = np.array(zone.centre[:2]) + zone.radius * np.column_stack([np.cos(around), np.sin(around)])
        low, high = _height(mission, ring), np.full(len(ring), _height(mission, np.array([zone.centre[:2]]))[0] + 330)
        sides = np.stack([np.column_stack([ring, low]), np.column_stack([ring, high])])
        for k in range(len(ring) - 1):
            axes.fill(*camera.seen(sides[[0, 0, 1, 1], [k, k + 1, k + 1, k]])[0].T, color="#ff4d4d", alpha=0.13, lw=0)
        for side, alpha in ((sides[0], 0.5), (sides[1], 0.95)):
            axes.plot(*camera.seen(side)[0].T, color="#ff6b6b", lw=1.4, alpha=alpha)
        above = camera.seen(sides[1])[0]
        where = above[above[:, 0].argmax()]
        axes.annotate("no-fly zone", where, (8, 6), textcoords="offset points", color="#ff9a9a", fontsize=11)


def _flights(axes: Any, camera: Camera, mission: sky.Mission) -> None:
    drawn = next(drawn_surveys(mission.scenario, mission))
    for uav, (trajectory, colour) in enumerate(zip(mission.trajectories, UAVS, strict=False)):
        if trajectory is None:
            continue
        strips = [strip for sortie in mission.sorties_of(uav) for strip in sortie.strips]
        for sortie in mission.sorties_of(uav):
            t = np.linspace(sortie.begin, sortie.end, int((sortie.end - sortie.begin) * 2.5))
            _line(axes, camera, drawn, trajectory.at(t).position, colour, 0.9, 0.55)
        for strip in strips:
            way = trajectory.at(np.linspace(strip.begin, strip.end, 240)).position
            for width, alpha in ((3.4, 0.16), (1.5, 1.0)):
                _line(axes, camera, drawn, way, colour, width, alpha)
        place = np.array([*mission.scenario.uavs[uav].start[:2], 0.0])
        place[2] = _height(mission, place[None, :2])[0]
        axes.plot(*camera.seen(place[None])[0].T, "o", ms=9, mfc=GROUND, mec=colour, mew=2.6)
    axes.annotate("launch places", camera.seen(place)[0], (48, -4), textcoords="offset points", color=INK, fontsize=11)
    for k in _shown(drawn):
        eye, corners = drawn.photos.position[k], drawn.footprints[k, :4]
        colour = UAVS[drawn.photos.uav[k]]
        ring = np.concatenate(
            [np.linspace(a, b, 40) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
        )
        ring[:, 2] = drawn.scenario.terrain.height(ring[:, :2]) + 4
        axes.fill(*camera.seen(ring)[0].T, color=colour, alpha=0.30, lw=0)
        axes.plot(*camera.seen(np.vstack([ring, ring[:1]]))[0].T, color="white", lw=1.3)
        for corner in corners:
            axes.plot(*camera.seen(np.array([eye, corner]))[0].T, color="white", lw=0.9, alpha=0.8)
        axes.plot(*camera.seen(eye[None])[0].T, "o", ms=7, mfc=colour, mec="white", mew=1.4)


def _shown(drawn: DrawnSurvey) -> Iterator[int]:
    """Yield a photo of each UAV, of which what it shows is drawn."""
    for uav in sorted(set(drawn.photos.uav.tolist())):
        own = np.flatnonzero(drawn.photos.uav == uav)
        yield int(own[int(0.3 * len(own))])


def _words(figure: Any, drawn: DrawnSurvey, mission: sky.Mission) -> None:
    proof = drawn.coverage
    assert proof is not None
    assert proof.verdict is sky.Verdict.PROVEN
    assert drawn.survey.gsd is not None
    survey, scenario = drawn.survey, mission.scenario
    figure.text(0.03, 0.915, "Every place seen, and proven", color=INK, fontsize=22, weight="bold")
    where = f"{proof.area / 1e4:.0f} ha of mountain, photographed by {len(scenario.uavs)} UAVs"
    figure.text(
        0.03, 0.875, f"{where}\nat most {scenario.max_height:.0f} m above ground", color=SOFT, fontsize=13, va="top"
    )
    along, across = np.floor(10 * np.array(proof.overlap)) / 10
    facts = (
        (told_share(proof.seen[0]), "of the ground proven to be seen"),
        (told_gsd(proof.gsd), f"a pixel where it is coarsest; asked: {100 * survey.gsd:.2g}"),
        (f"{along:g} and {across:g} %", "least overlap, along and between strips"),
        (f"{len(drawn.photos):,} photos", f"{sum(map(len, mission.sorties))} sorties, each home on its battery"),
    )
    for k, (number, what) in enumerate(facts):
        figure.text(0.03, 0.735 - 0.094 * k, number, color=INK, fontsize=21, weight="bold")
        figure.text(0.03, 0.707 - 0.094 * k, what, color=SOFT, fontsize=11)
    low, high = _counts(drawn)
    bar = figure.add_axes((0.03, 0.20, 0.17, 0.022))
    bar.imshow(np.linspace(0, 1, 256)[None], aspect="auto", cmap=PHOTOS, extent=(low, high, 0, 1))
    bar.set_yticks([])
    bar.tick_params(colors=SOFT, labelsize=10, length=0)
    bar.spines[:].set_visible(False)
    bar.set_title("photos that show each place", color=SOFT, fontsize=11, loc="left")
    for uav, colour in zip(range(len(scenario.uavs)), UAVS, strict=False):
        strips = sum(len(sortie.strips) for sortie in mission.sorties_of(uav))
        figure.text(0.03, 0.125 - 0.032 * uav, "\u25cf", color=colour, fontsize=13)
        figure.text(0.047, 0.125 - 0.032 * uav, f"{scenario.uavs[uav].name}, {strips} strips", color=SOFT, fontsize=11)


def _counts(drawn: DrawnSurvey) -> Any:
    """Return between which numbers of photos of a place colours go."""
    assert drawn.views is not None
    return np.percentile(drawn.views.count[drawn.views.count >= 0], (2, 98))
