"""Surveys as plotly traces, and as data of the card that plays through their photos."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from skyverse._typing import Floats
from skyverse.draw.drawn_world import DrawnWorld
from skyverse.draw.palette import COUNTS, DISTANCES, FINDINGS, SURVEY
from skyverse.draw.photo_views import DrawnSurvey, SampledViews
from skyverse.draw.plotly_values import NOWHERE, Trace, columns, mesh, packed, plain, trace
from skyverse.draw.scenes import Scene
from skyverse.model.pad import ground_height

LIFT = 0.004
"""How far above the ground what lies on it is drawn in space, as a share of the picture's longest side."""
COARSER = 2
"""One sampled place in so many, along each side, is drawn in space."""


def surveys_in_space(scene: Scene) -> list[Trace]:
    """Return what is to be seen, how often it is, the photos and what is missed; and the view of a photo, empty."""
    made = [each for drawn in scene.surveys for each in _in_space(drawn, scene.world)]
    if not any(len(drawn.photos) for drawn in scene.surveys):
        return made
    line = {"width": 4, "color": SURVEY}
    return [*made, trace("scatter3d", "lines", "View of a photo", NOWHERE, None, {"role": "view"}, line=line)]


def _in_space(drawn: DrawnSurvey, world: DrawnWorld) -> Iterator[Trace]:
    up = np.array([0.0, 0.0, LIFT * float((world.high - world.low).max())])
    name = plain(drawn.survey.name)
    if drawn.views is not None:
        yield _carpet(drawn, drawn.views, up / 2)
    for role, colour, ring in _rings(drawn):
        line = {"color": colour, "width": 4}
        yield trace("scatter3d", "lines", name, columns(ring + up, form=packed), None, {"role": role}, line=line)
    if len(drawn.photos):
        hover = "%{fullData.name}<br>x %{x:.1f}, y %{y:.1f}, z %{z:.1f} m<extra></extra>"
        points, marker = columns(drawn.photos.position, form=packed), {"size": 1.5, "color": SURVEY}
        yield trace("scatter3d", "markers", f"{name}: photo", points, hover, {"role": "photos"}, marker=marker)


def _carpet(drawn: DrawnSurvey, views: SampledViews, up: Floats) -> Trace:
    """Return the ground of a survey in the colours of how many photos show each place."""
    x, y, count = views.x[::COARSER], views.y[::COARSER], views.count[::COARSER, ::COARSER]
    flat = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    places = np.concatenate([flat, ground_height(drawn.scenario, flat)[..., None]], axis=-1).reshape(-1, 3) + up
    rows = np.arange(count.size).reshape(count.shape)
    cells = np.stack([rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:]], axis=-1).reshape(-1, 4)
    cells = cells[(count.ravel()[cells] >= 0).all(axis=1)]
    scale, low, high = count_scale(views)
    flat_light = {"ambient": 1, "diffuse": 0, "specular": 0, "fresnel": 0}
    shown = {"intensity": packed(count.ravel().astype(float)), "cmin": low, "cmax": high, "colorscale": scale}
    faces, role = np.concatenate([cells[:, (0, 1, 2)], cells[:, (0, 2, 3)]]), {"role": "seen"}
    more = {"showscale": False, "opacity": 0.75, "lighting": flat_light}
    return mesh(f"{plain(drawn.survey.name)}: photos of each place", places, faces, role, **shown, **more)


def _rings(drawn: DrawnSurvey) -> Iterator[tuple[str, str, Floats]]:
    """Yield the outlines of what is to be seen, and of what is missed: what they are, their colour, and (n, 3) points.

    Rings are parted by nan.
    """
    missed = [_ring(drawn, gap.outline) for gap in drawn.gaps]
    for role, colour, rings in (("survey", SURVEY, drawn.outlines), ("gap", FINDINGS["error"], missed)):
        if rings:
            yield role, colour, np.concatenate([np.vstack([ring, np.full((1, 3), np.nan)]) for ring in rings])


def _ring(drawn: DrawnSurvey, outline: Sequence[Sequence[float]]) -> Floats:
    """Return an outline, given by x and y or x, y and z, closed and in space: on the ground where it has no z."""
    ring = np.array([*outline, outline[0]], dtype=np.float64)
    return ring if ring.shape[1] > 2 else np.column_stack([ring, ground_height(drawn.scenario, ring)])


def surveys_on_map(scene: Scene) -> list[Trace]:
    """Return the outlines of what is to be seen, and of what is missed, which is hatched."""
    return [_outline(drawn, *ring) for drawn in scene.surveys for ring in _rings(drawn)]


def _outline(drawn: DrawnSurvey, role: str, colour: str, points: Floats) -> Trace:
    hatched = {
        "fill": "toself",
        "fillcolor": "rgba(0,0,0,0)",
        "fillpattern": {"shape": "/", "fgcolor": colour, "size": 6},
    }
    more = {"line": {"color": colour, "width": 2}} | (hatched if role == "gap" else {})
    where = columns(points, "xy", packed)
    return trace("scatter", "lines", plain(drawn.survey.name), where, None, {"role": role}, **more)


def survey_data(scene: Scene) -> list[dict[str, Any]]:
    """Return what the card of surveys draws, of each survey: maps of samples, outlines, and photos by their time."""
    return [
        {
            "name": drawn.survey.name,
            "maps": [] if drawn.views is None else _maps(drawn, drawn.views),
            "outlines": [_outline(drawn, *ring) for ring in _rings(drawn)],
            "photos": _photos(drawn),
        }
        for drawn in scene.surveys
    ]


def _photos(drawn: DrawnSurvey) -> dict[str, Any]:
    order = np.argsort(drawn.photos.time, kind="stable")
    photos = drawn.photos.taken(order)
    table = {
        "position": photos.position,
        "corners": drawn.footprints[order][:, :4],
        "time": photos.time,
        "uav": photos.uav,
        "sortie": drawn.sortie[order],
        "strip": photos.strip,
        "gsd": np.stack(drawn.gsd, axis=-1)[order],
    }
    return {"count": len(photos)} | {name: packed(np.ravel(value).astype(float)) for name, value in table.items()}


def _maps(drawn: DrawnSurvey, views: SampledViews) -> list[Trace]:
    """Return the maps of samples: how many photos show each place, and how finely the best does, in cm."""
    where = {"type": "heatmap", "x": packed(views.x), "y": packed(views.y), "zsmooth": False, "opacity": 0.8}
    place = "<br>x %{x:.0f}, y %{y:.0f} m<extra></extra>"
    made = []
    for role, unit, values, (scale, low, high) in (
        ("count", "photos", np.where(views.count < 0, np.nan, views.count), count_scale(views)),
        ("gsd", "cm", 100 * views.gsd, gsd_scale(drawn, views)),
    ):
        shown = {"z": packed(values.T), "colorscale": scale, "zmin": low, "zmax": high}
        told = f"%{{z:{'.0f' if role == 'count' else '.2f'}}} {unit}{place}"
        made.append(where | shown | {"hovertemplate": told, "meta": {"role": role, "unit": unit}})
    return made


Scale = tuple[list[tuple[float, str]], float, float]
"""The colours of a scale, each with its share of the way from the least to the most, and both."""


def count_scale(views: SampledViews) -> Scale:
    """Return the colours of how many photos show a place: of none red, of more from light to dark."""
    most = max(float(views.count.max()), 2.0)
    tones = zip(np.linspace(0.5 / most, 1.0, len(COUNTS)).tolist(), COUNTS, strict=True)
    return [(0.0, FINDINGS["error"]), (0.5 / most, FINDINGS["error"]), *tones], 0.0, most


def gsd_scale(drawn: DrawnSurvey, views: SampledViews) -> Scale:
    """Return the colours of ground sample distances, cm: from dark to light, and red above that which is asked."""
    found = views.gsd[np.isfinite(views.gsd)]
    asked = drawn.survey.gsd
    low, most = (float(found.min()), float(found.max())) if len(found) else (0.0, 1.0)
    edge = max(most, asked or 0.0) if asked is None or most <= asked * (1 + 1e-9) else asked
    high = max(most, edge, low + 1e-6)
    shares = np.linspace(0.0, max(edge - low, 0.0) / (high - low), len(DISTANCES)).tolist()
    above = [] if high <= edge else [(shares[-1], FINDINGS["error"]), (1.0, FINDINGS["error"])]
    return [*zip(shares, DISTANCES, strict=True), *above], 100 * low, 100 * high
