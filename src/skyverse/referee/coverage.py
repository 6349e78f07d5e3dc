"""Judges what the photos of a survey show: the share of it that is certain to be seen, how finely, and overlaps."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats
from skyverse.interrupt import raise_if_interrupted
from skyverse.model.asked_ground import asked_ground
from skyverse.model.coverage import Coverage, CoverageGap
from skyverse.model.frame import Origin
from skyverse.model.geodesy import told_place
from skyverse.model.pad import ground_height
from skyverse.model.photos import Photos
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted, listed, told_area, told_gsd, told_overlap
from skyverse.model.survey import Survey
from skyverse.model.uav import TrackingError
from skyverse.model.verdict import Verdict
from skyverse.referee.blockers import Solid, blockers_of, bottoms_of, closed_between, solids_of
from skyverse.referee.facet_cells import FacetCells, facet_cells
from skyverse.referee.gaps import Sight, name_of, outlines_of, runs, spots
from skyverse.referee.ground_cells import CellGrid, Pieces, grid_of, joined
from skyverse.referee.photo_overlaps import SHORT, Neighbours, directions_of, neighbours_of
from skyverse.referee.photo_views import views_of
from skyverse.referee.relief import relief_of
from skyverse.referee.shown import Viewers
from skyverse.referee.tolerances import LET_PASS, LIMIT_LET_PASS, SHARE_SHORT
from skyverse.referee.tracking_error import EXACT

HALVINGS = 3
"""How often cells that are not certain to be seen are cut in four."""
MOST_HALVED = 50_000
"""Pieces that are cut in four at once, at most."""
MOST_COUNTED = 10
"""Photos of a place that are counted, at most."""
MOST_WITNESSES = 60
"""Outlines of gaps in which it is looked for a place that is certainly not seen, at most."""
ACROSS = 9
"""Places along x and along y at which it is looked whether a solid stands on the ground."""
MOST_SHARE = 0.95
"""The share of the area of which sentences tell by how many photos it is seen, and how finely."""
LEAST_SHARE = 0.5
"""The share of the overlap that is asked for that each pair of neighbours has, however many have all of it."""
DIRECTIONS = {"cross": 2, "oblique": 5}
"""In how many directions patterns are flown, if not in one; straight down is one of the oblique ones."""


class Seen(NamedTuple):
    """What is seen of parts: their areas, square metres, by how many photos, and their depths in the best, metres."""

    area: Floats
    views: Floats
    depth: Floats


def judge_coverage(scenario: Scenario, number: int, photos: Photos, errors: Sequence[TrackingError]) -> Coverage:
    """Judge what photos show of a survey, wherever within their errors the UAVs are and the cameras are turned.

    Parameters
    ----------
    scenario
        What was given.
    number
        The index of the survey.
    photos
        All photos of the survey.
    errors
        The tracking error of each UAV; the last one is that of photos of no UAV.
    """
    survey = scenario.surveys[number]
    if not survey.of_ground:
        return _structures(scenario, number, photos, errors)
    area = asked_ground(survey)
    solids = _near(solids_of(scenario.obstacles), area, photos)
    stands = np.array([_stands(scenario, solid) for solid in solids], dtype=bool)
    resting = {solid.ball for solid, on_ground in zip(solids, stands, strict=True) if on_ground} - {None}
    stands |= np.array([solid.ball in resting for solid in solids], dtype=bool)  # all slices of a ball
    polygons = np.array([solid.polygon for solid in solids], dtype=object)
    asked = shapely.difference(area, shapely.union_all(polygons[stands]))
    if shapely.area(asked) <= LET_PASS:
        below = listed(sorted({name_of(scenario, solid) for solid, on in zip(solids, stands, strict=True) if on}))
        told, none = f"nothing of it is open ground, it lies below {below}: refuted.", math.nan
        return Coverage(number, Verdict.REFUTED, told, len(photos), 0.0, (0.0,), none, none, 0.0, (none, none), 0, 0)
    grid = grid_of(scenario, survey, asked)
    beyond = shapely.difference(asked, shapely.box(grid.x[0], grid.y[0], grid.x[-1], grid.y[-1]))
    hanging = bottoms_of([solid for solid, on_ground in zip(solids, stands, strict=True) if not on_ground])
    raise_if_interrupted()
    viewers, sight = _viewers(scenario, survey, photos, errors, solids, hanging)
    seen, missed = _look(viewers, grid)
    if survey.fine_all_over and viewers.deepest_cell <= viewers.most < viewers.deepest:
        viewers.look_closer(grid)
    gaps, certain = _gaps(sight, number, np.append(missed, beyond) if shapely.area(beyond) > 0 else missed, grid)
    needed = _directions(survey)
    lacking = _lacking(survey, photos, grid, needed) if needed > 1 else 0.0
    overlaps = neighbours(scenario, survey, photos, grid_of(scenario, survey, area) if stands.any() else grid)
    figures = _Figures(float(shapely.area(asked)), seen, survey.camera.pixel, viewers, overlaps, lacking)
    return figures.judged(scenario, number, len(photos), gaps, certain)


def _directions(survey: Survey) -> int:
    """Return in how many directions a survey's pattern is flown everywhere."""
    return 1 if survey.pattern == "oblique" and survey.pitch == -90.0 else DIRECTIONS.get(survey.pattern, 1)


def _lacking(survey: Survey, photos: Photos, grid: CellGrid, needed: int) -> float:
    """Return the greatest area that photos that look in one direction of a survey's pattern leave out, square metres.

    Nothing but the edges of pictures bounds what they show, and cameras are where they are planned to be.
    """
    number, lost = directions_of(photos, survey.pattern == "oblique"), 0.0
    count = np.bincount(number[number >= 0], minlength=needed)
    for k in np.argsort(-count, kind="stable")[:needed].tolist():
        own = photos.taken(number == k)
        views = views_of(own, survey.camera, [EXACT] * len(own), 0.0)
        _, missed = _look(Viewers(views, None, blockers_of([], bottoms_of([]), ()), math.inf), grid)
        lost = max(lost, float(shapely.area(missed).sum()))
    return lost


def neighbours(scenario: Scenario, survey: Survey, photos: Photos, grid: CellGrid) -> tuple[Neighbours, Neighbours]:
    """Return the neighbours among the photos of a survey, along strips and between them."""
    heights = photos.position[:, 2]
    closed = closed_between(scenario.obstacles, heights.min(initial=np.inf), heights.max(initial=-np.inf))
    return neighbours_of(photos, survey.camera, grid, closed, one_direction=_directions(survey) == 1)


def _viewers(
    scenario: Scenario,
    survey: Survey,
    photos: Photos,
    errors: Sequence[TrackingError],
    solids: list[Solid],
    bottoms: Floats,
) -> tuple[Viewers, Sight]:
    """Return what photos are certain to show, and what may be between them and what they are of."""
    camera, most = survey.camera, math.inf if survey.gsd is None else survey.gsd / survey.camera.pixel
    views = views_of(photos, camera, [errors[uav] for uav in photos.uav.tolist()], camera.attitude_error)
    exact = views_of(photos, camera, [EXACT] * len(photos), 0.0)
    relief = None if scenario.terrain is None else relief_of(scenario.terrain)
    viewers = Viewers(views, relief, blockers_of(solids, bottoms, survey.facets), most)
    return viewers, Sight(scenario, views, exact, viewers.most, solids)


def _structures(scenario: Scenario, number: int, photos: Photos, errors: Sequence[TrackingError]) -> Coverage:
    """Judge what photos show of walls and facets, of which photos have no neighbours."""
    survey = scenario.surveys[number]
    solids = solids_of(scenario.obstacles)
    viewers, sight = _viewers(scenario, survey, photos, errors, solids, bottoms_of(solids))
    cells = facet_cells(scenario, survey, solids)
    area, rows, lost = float(cells.area.sum()), [], []
    first = int(cells.source.max(initial=-1)) + 1 - len(survey.facets)
    for left in range(HALVINGS, -1, -1):
        flat = Pieces(np.zeros(len(cells.area), dtype=object), cells.corners, np.zeros(len(cells.area)), cells.area)
        shown = viewers.show_pieces(flat, cells.normal, cells.inside(solids))
        once = (shown.count > 0) & ~((cells.source >= first) & _sunk(scenario, cells))
        rows.append((flat.area[once], shown.count[once], shown.depth[once]))
        unsure = ~once & shown.touched & (left > 0)
        if unsure.sum() > MOST_HALVED:
            unsure[:] = False
        lost.append(cells.of(~once & ~unsure))
        cells = cells.of(unsure).halved()
    gaps, certain = [], False
    missed = FacetCells(*(np.concatenate(column) for column in zip(*lost, strict=True)))
    for source in np.unique(missed.source).tolist():
        part = missed.of(missed.source == source)
        some = np.argsort(-part.area, kind="stable")[:ACROSS]
        places = part.corners[some].mean(axis=1)
        if part.solid[0] >= 0:  # a little of walls' cells is below the ground, where nothing is asked for
            places[:, 2] = np.maximum(places[:, 2], ground_height(scenario, places[:, :2]))
        reasons = sight.reasons(places, part.normal[some])
        certain |= any(reason.certain for reason in reasons)
        why = Counter(reason.why for reason in reasons).most_common(1)[0][0]
        gaps.append(CoverageGap(number, part.outline, float(part.area.sum()), why))
    seen = Seen(*(np.concatenate(column) for column in zip(*rows, strict=True)))
    figures = _Figures(area, seen, survey.camera.pixel, viewers, ())
    return figures.judged(scenario, number, len(photos), tuple(sorted(gaps, key=lambda gap: -gap.area)), certain)


def _sunk(scenario: Scenario, cells: FacetCells) -> Bools:
    """Return of cells whether a corner, or the middle, is below the ground."""
    if scenario.terrain is None:
        return np.zeros(len(cells.area), dtype=np.bool_)
    places = np.concatenate([cells.corners, cells.corners.mean(axis=1, keepdims=True)], axis=1)
    sunk = places[:, :, 2] + LET_PASS < scenario.terrain.height(places[:, :, :2])
    found: Bools = np.any(sunk, axis=1)
    return found


def _near(solids: list[Solid], asked: shapely.Geometry, photos: Photos) -> list[Solid]:
    """Return the solids that are between photos and what they are of, or near."""
    ends = shapely.union(asked, shapely.multipoints(photos.position[:, :2]))
    box = shapely.box(*shapely.bounds(ends))
    return [solid for solid in solids if shapely.intersects(box, shapely.envelope(solid.polygon))]


def _stands(scenario: Scenario, solid: Solid) -> bool:
    """Tell whether a solid touches the ground somewhere, so that there is none to be seen below it."""
    west, south, east, north = shapely.bounds(solid.polygon)
    x, y = np.meshgrid(np.linspace(west, east, ACROSS), np.linspace(south, north, ACROSS))
    within = np.column_stack([x.ravel(), y.ravel()])[shapely.contains_xy(solid.polygon, x.ravel(), y.ravel())]
    places = np.concatenate([within, shapely.get_coordinates(solid.polygon)])
    low: float | Floats = solid.low
    if solid.ball is not None:
        inner = solid.ball[3] ** 2 - ((places - solid.ball[:2]) ** 2).sum(axis=1)
        low = solid.ball[2] - np.sqrt(np.maximum(inner, 0.0))
    return bool((ground_height(scenario, places) >= low).any())


def _look(viewers: Viewers, grid: CellGrid) -> tuple[Seen, NDArray[np.object_]]:
    """Return what is seen of the cells of a grid, and outlines of what is not certain to be."""
    shown = viewers.show_grid(grid)
    seen = grid.whole & (shown.count > 0)
    rows = [(np.full(int(seen.sum()), grid.size), shown.count[seen], shown.depth[seen])]
    again = grid.whole & ~seen & shown.touched
    missed = [runs(grid.whole & ~seen & ~again, grid.x, grid.y)]
    pieces = joined(grid.pieces, grid.halved(grid.cells(again)))
    for left in range(HALVINGS, -1, -1):
        if not left:  # about the corner of a building, one photo shows what is before one wall, one the rest
            pieces = grid.parted(pieces, *viewers.blockers.upright)
        shown = viewers.show_pieces(pieces)
        once = shown.count > 0
        rows.append((pieces.area[once], shown.count[once], shown.depth[once]))
        unsure = ~once & shown.touched & (left > 0)
        if unsure.sum() > MOST_HALVED:
            unsure[:] = False
        missed.append(pieces.outline[~once & ~unsure])
        pieces = grid.halved(pieces.of(unsure))
        if not len(pieces.area):
            break
    return Seen(*(np.concatenate(column) for column in zip(*rows, strict=True))), np.concatenate(missed)


def _gaps(sight: Sight, number: int, lost: NDArray[np.object_], grid: CellGrid) -> tuple[tuple[CoverageGap, ...], bool]:
    """Return the gaps of a survey, and whether some of them are certainly not seen."""
    outlines = outlines_of(lost, math.sqrt(grid.size))
    if not outlines:
        return (), False
    level = [spots(polygon)[: None if k < MOST_WITNESSES else 1] for k, (polygon, _) in enumerate(outlines)]
    places = np.concatenate(level)
    reasons = iter(sight.reasons(np.column_stack([places, ground_height(sight.scenario, places)])))
    found, certain = [], False
    for (polygon, area), some in zip(outlines, level, strict=True):
        why = list(islice(reasons, len(some)))
        certain |= any(reason.certain for reason in why)
        outline = tuple((x, y) for x, y in shapely.get_coordinates(shapely.get_exterior_ring(polygon))[:-1].tolist())
        found.append(CoverageGap(number, outline, area, Counter(one.why for one in why).most_common(1)[0][0]))
    return tuple(found), certain


class _Figures(NamedTuple):
    """What was found of a survey."""

    area: float
    seen: Seen
    pixel: float
    viewers: Viewers
    overlaps: tuple[Neighbours, ...]
    lacking: float = 0.0

    def judged(
        self, scenario: Scenario, number: int, photos: int, gaps: tuple[CoverageGap, ...], certain: bool
    ) -> Coverage:
        """Return what is proven of a survey."""
        survey, origin = scenario.surveys[number], scenario.frame.origin
        share = [
            float(self.seen.area[self.seen.views >= k].sum() / max(self.area, LET_PASS))
            for k in range(1, MOST_COUNTED + 1)
        ]
        shares = tuple(one for k, one in enumerate(share) if k == 0 or one > 0)
        order = np.argsort(self.seen.depth)
        grown = np.cumsum(self.seen.area[order])
        ranked = self.pixel * self.seen.depth[order]
        worst = float(ranked[-1]) if len(ranked) else math.nan
        mostly = float(ranked[np.searchsorted(grown, MOST_SHARE * grown[-1])]) if len(ranked) else math.nan
        least, short, where, pairs = [math.nan, math.nan], 0, "", 0
        for k, found in enumerate(self.overlaps):
            pairs += len(found.share)
            if len(found.share):
                worst_pair = int((found.share - survey.overlap[k]).argmin())
                least[k] = float(found.share[worst_pair])
                below = int((found.share < survey.overlap[k] - SHORT).sum())
                if below:
                    middle = told_place(origin, found.centre[worst_pair].mean(axis=0))
                    where += f"{' and' if where else ', the least'} about {middle}"
                short += below
        coarsest, asked = self.pixel * self.viewers.deepest, (survey.gsd or math.inf) * (1 + LIMIT_LET_PASS)
        coarse, unsure = (
            survey.fine_all_over and self.pixel * deep > asked
            for deep in (self.viewers.deepest_cell, self.viewers.deepest)
        )
        bare = any((found.share < LEAST_SHARE * survey.overlap[k]).any() for k, found in enumerate(self.overlaps))
        open_ = sum(gap.area for gap in gaps) > LET_PASS
        refuted = (open_ and certain) or short > SHARE_SHORT * pairs or coarse or self.lacking > LET_PASS or bare
        alone = len(self.overlaps) > 0 and photos > 1 and not pairs and max(survey.overlap) > 0
        verdict = Verdict.REFUTED if refuted else Verdict.UNDECIDED if open_ or alone or unsure else Verdict.PROVEN
        figures = (shares, worst, mostly, coarsest, (least[0], least[1]), pairs, short)
        told = _sentence(self.area, figures, survey, gaps, where, origin)
        told += "; no photos are neighbours on strips whose overlap could be judged" if alone else ""
        told += "; how much photos of walls overlap is not judged" if survey.overlaps_on_walls else ""
        if self.lacking > LET_PASS:
            told += (
                f"; {told_area(self.lacking)} are not photographed in each direction of the pattern {survey.pattern!r}"
            )
        sentence = f"{told}: {verdict.value}."
        return Coverage(number, verdict, sentence, photos, self.area, *figures, gaps)


def _sentence(
    area: float,
    figures: tuple[Any, ...],
    survey: Survey,
    gaps: tuple[CoverageGap, ...],
    where: str,
    origin: Origin | None,
) -> str:
    shares, worst, _, coarsest, (along, between), pairs, short = figures
    whole = not gaps
    percent = "100" if whole else f"{min(100 * shares[0], 99.99):.4g}"
    often = sum(one >= MOST_SHARE for one in shares)
    times = f", by at least {counted(often, 'photo')} on {100 * MOST_SHARE:g} %" if often > 1 else ""
    fine = f"; worst {told_gsd(worst)}" if shares[0] > 0 else ""
    if survey.gsd is not None and coarsest > survey.gsd * (1 + LIMIT_LET_PASS) and survey.fine_all_over:
        fine += f", but up to {100 * coarsest:.3g} cm in single photos, where {100 * survey.gsd:.3g} cm are asked"
    shared = [
        f"{told_overlap(share)} {which}"
        for share, which in ((along, "along strips"), (between, "between"))
        if share == share
    ]
    told = f"; photos share at least {' and '.join(shared)}" if shared else ""
    wrong = f", {short:,} of {counted(pairs, 'pair')} less than asked{where}" if short else ""
    gap = f"; {told_area(gaps[0].area)} about {told_place(origin, gaps[0].middle)}: {gaps[0].why}" if gaps else ""
    return f"{percent} % of {told_area(area)} is seen{times}{fine}{told}{wrong}{gap}"
