"""What photos show of the ground, for pictures: their footprints, and how many show each place, from samples."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.asked_ground import asked_ground
from skyverse.model.camera import Camera
from skyverse.model.coverage import Coverage, CoverageGap
from skyverse.model.mission import Mission
from skyverse.model.pad import ground_height
from skyverse.model.photos import Photos, photos_of
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey

STEPS, HALVINGS = 48, 24
"""Places of a ray at which it is compared with the ground, and how often the piece that meets the ground is halved."""
FARTHEST = 6.0
"""A footprint ends where its ray has gone this many times as far as the survey's distance."""
SAMPLES = 160
"""The largest number of sampled places along each side of a survey."""
BEYOND = 0.2
"""Between its corners, a footprint reaches beyond them by less than this share of its size."""
SIGHTS = 16
"""Places of a line of sight at which it is asked whether the ground hides what is at its end."""
CORNERS = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1), (0, 0)])
"""The corners of a picture and its middle: to the right and up, in halves of its sides."""

_NONE = np.zeros(0)
_NOBODY = np.zeros(0, dtype=np.int64)
NO_PHOTOS = Photos(np.zeros((0, 3)), _NONE, _NONE, _NONE, _NONE, _NOBODY, _NOBODY)
"""What is drawn of a survey before anything is planned."""


@dataclass(frozen=True, eq=False)
class SampledViews:
    """How many photos show each place, and the finest of them there.

    Attributes
    ----------
    x, y
        (n,) and (m,) metres: a grid over the survey.
    count
        (n, m): of the photos that show it no more coarsely than asked; -1 outside what is to be seen.
    gsd
        (n, m) metres: the ground sample distance of the best photo; NaN where there is none.
    """

    x: Floats
    y: Floats
    count: Ints
    gsd: Floats


@dataclass(frozen=True, eq=False)
class DrawnSurvey:
    """One survey of a scenario or a mission, as pictures show it; without a mission it has no photos.

    The `coverage` is what the referee proved, if it was asked; `unseen` is what no UAV flies to see.
    """

    scenario: Scenario
    number: int
    photos: Photos
    sortie: Ints
    coverage: Coverage | None = None
    unseen: tuple[CoverageGap, ...] = ()

    @property
    def survey(self) -> Survey:
        """What is to be seen."""
        return self.scenario.surveys[self.number]

    @property
    def gaps(self) -> tuple[CoverageGap, ...]:
        """What is not proven to be seen, and what no UAV flies to see."""
        return (*(self.coverage.gaps if self.coverage else ()), *self.unseen)

    @cached_property
    def outlines(self) -> list[Floats]:
        """The outlines of what is to be seen, (k, 3) metres each, on the ground or on a structure."""
        if not self.survey.of_ground:
            return [np.array([*facet, facet[0]]) for facet in self.survey.facets]
        shape = asked_ground(self.survey)
        rings = [ring for part in getattr(shape, "geoms", [shape]) for ring in (part.exterior, *part.interiors)]
        fine = max(float(np.ptp(shape.bounds[::2])), float(np.ptp(shape.bounds[1::2]))) / SAMPLES
        flat = [np.array(ring.segmentize(fine).coords) for ring in rings]
        return [np.column_stack([ring, ground_height(self.scenario, ring)]) for ring in flat]

    @cached_property
    def footprints(self) -> Floats:
        """Where the rays through the corners of each photo, and through its middle, end: (n, 5, 3) metres."""
        photos, survey = self.photos, self.survey
        ahead, right, up = np.moveaxis(photos.frames, 1, 0)
        wide, high = survey.camera.half_widths
        across = (wide * right)[:, None] * CORNERS[:, :1] + (high * up)[:, None] * CORNERS[:, 1:]
        rays, start = (ahead[:, None] + across).reshape(-1, 3), np.repeat(photos.position, len(CORNERS), axis=0)
        most = survey.distance * (FARTHEST if survey.of_ground else 1.0)
        return (start + meets(self.scenario, start, rays, most)[:, None] * rays).reshape(-1, len(CORNERS), 3)

    @cached_property
    def gsd(self) -> tuple[Floats, Floats]:
        """The ground sample distances in the middle of each photo, and in its coarsest corner, (n,) metres."""
        depths = np.einsum("nkc,nc->nk", self.footprints - self.photos.position[:, None], self.photos.frames[:, 0])
        return self.survey.camera.pixel * depths[:, -1], self.survey.camera.pixel * depths.max(axis=1)

    @cached_property
    def views(self) -> SampledViews | None:
        """What its photos show of the ground; ``None`` where that is not what it is for, or without photos."""
        return sampled_views(self) if self.survey.of_ground and len(self.photos) else None


def drawn_surveys(scenario: Scenario, mission: Mission | None = None) -> Iterator[DrawnSurvey]:
    """Yield the surveys of a scenario, with their photos where it is that of a mission."""
    for number in range(len(scenario.surveys)):
        if mission is None:
            yield DrawnSurvey(scenario, number, NO_PHOTOS, NO_PHOTOS.uav)
            continue
        photos = photos_of(mission, number)
        begins = [np.array([one.begin for one in mission.sorties_of(uav)]) for uav in range(len(scenario.uavs))]
        flown = [int((begins[uav] <= t).sum()) for uav, t in zip(photos.uav, photos.time, strict=True)]
        coverage = next((one for one in mission.coverage if one.survey == number), None)
        unseen = tuple(one for one in mission.unseen if one.survey == number)
        yield DrawnSurvey(scenario, number, photos, np.array(flown, dtype=np.int64), coverage, unseen)


def meets(scenario: Scenario, start: Floats, rays: Floats, most: float) -> Floats:
    """Return how many times its length each ray, (n, 3), goes until it meets the ground, or `most`."""

    def above(times: Floats) -> Floats:
        places = start[:, None] + times[..., None] * rays[:, None]
        return places[..., 2] - ground_height(scenario, places[..., :2])

    times = np.broadcast_to(most * np.arange(STEPS + 1) / STEPS, (len(rays), STEPS + 1))
    below = above(times) <= 0
    below[:, -1] = True
    after = np.maximum(below.argmax(axis=1), 1)
    low, high = (np.take_along_axis(times, k[:, None], axis=1) for k in (after - 1, after))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        under = above(middle) <= 0
        low, high = np.where(under, low, middle), np.where(under, middle, high)
    return high[:, 0]


def sampled_views(drawn: DrawnSurvey) -> SampledViews:
    """Return what photos show of places on a grid: how many show each, and how finely the best does.

    UAVs are where they are planned to be, and only the ground hides places from them.
    """
    from shapely import contains_xy

    survey, shape = drawn.survey, asked_ground(drawn.survey)
    west, south, east, north = shape.bounds
    step = max(east - west, north - south) / SAMPLES
    x, y = np.arange(west + step / 2, east, step), np.arange(south + step / 2, north, step)
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    places = np.concatenate([places, ground_height(drawn.scenario, places)[..., None]], axis=-1)
    count, depth = np.zeros(places.shape[:2], dtype=np.int64), np.full(places.shape[:2], np.inf)
    most = np.inf if survey.gsd is None else survey.distance
    slopes = [np.diff(places[..., 2], axis=axis) / step for axis in (0, 1)]
    steepest = np.hypot(*(np.abs(one).max(initial=0.0) for one in slopes))
    flat = drawn.footprints[:, :4, :2]
    more = BEYOND * np.ptp(flat, axis=1)
    low, high = flat.min(axis=1) - more, flat.max(axis=1) + more
    first = np.clip(np.ceil((low - (x[0], y[0])) / step), 0, count.shape).astype(int)
    last = np.clip(np.floor((high - (x[0], y[0])) / step) + 1, 0, count.shape).astype(int)
    fall = drawn.footprints[:, :4] - drawn.photos.position[:, None]
    gentle = (-fall[..., 2] / np.maximum(np.hypot(fall[..., 0], fall[..., 1]), 1e-9)).min(axis=1) <= steepest
    ahead, right, up = np.moveaxis(drawn.photos.frames, 1, 0)
    for k, place in enumerate(drawn.photos.position):
        part = slice(first[k, 0], last[k, 0]), slice(first[k, 1], last[k, 1])
        away = places[part] - place
        far = _in_view(survey.camera, away, ahead[k], right[k], up[k])
        if gentle[k]:
            seen = np.isfinite(far)
            far[seen] = np.where(_hidden(drawn.scenario, place, away[seen]), np.inf, far[seen])
        count[part] += far <= most
        np.minimum(depth[part], far, out=depth[part])
    inside = contains_xy(shape, places[..., 0], places[..., 1])
    gsd = np.where(inside & np.isfinite(depth), survey.camera.pixel * depth, np.nan)
    return SampledViews(x, y, np.where(inside, count, -1), gsd)


def _in_view(camera: Camera, away: Floats, ahead: Floats, right: Floats, up: Floats) -> Floats:
    """Return how far along its axis a camera has each place, (n, m) metres; infinite outside of its picture."""
    far, aside, over = (np.einsum("nmc,c->nm", away, axis) for axis in (ahead, right, up))
    wide, high = camera.half_widths
    return np.where((far > 0) & (np.abs(aside) <= wide * far) & (np.abs(over) <= high * far), far, np.inf)


def _hidden(scenario: Scenario, place: Floats, away: Floats) -> Any:
    """Return which of some places, (n, 3) metres from a camera, lie behind ground."""
    sight = place + away[:, None] * (np.arange(1, SIGHTS) / SIGHTS)[:, None]
    return (ground_height(scenario, sight[..., :2]) > sight[..., 2]).any(axis=1)
