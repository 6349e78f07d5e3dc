"""Buildings and zones: outlines on the globe become prisms of the local frame that never cover less."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.maps.assembly.terrain import GIVE_GROUND, ground_range
from skyverse.maps.georeference.feature import ABOVE_PERMITTED, Feature, Rectangle
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea
from skyverse.model.caution import Caution
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local
from skyverse.model.shapes import Prism, Terrain

KINDS_FROM_THE_GROUND = ("building", "construction", "furniture", "tree", "vegetation")
"""Kinds of obstacles that reach down to the ground, even where their file lets them begin at an altitude."""
BURIED, BEYOND = "buried", "above or below the bounds"
"""Words for features that are counted, and of which nothing is left."""
ROUNDING = 1e-3
"""Metres that corners are rounded to, after their outline was grown by as much."""
MERGED_KINDS = ("building", ABOVE_PERMITTED)
"""Kinds of which neighbours become one where both their ends are alike."""
EVEN = 10.0
"""Metres by which the ground below a cell of permitted heights may rise before the cell is divided."""
LEAST_CELL, MAX_CELLS_ACROSS = 50.0, 24
"""Metres that such a cell is wide at least to be divided, and how many of them there are across a scenario at most."""
MAX_CORNERS = 1000
"""Corners of an outline at most; outlines of more are simplified."""


@dataclass
class LocalFeatures:
    """Features in the local frame, before the bounds are known.

    Attributes
    ----------
    outlines
        A polygon of shapely for each feature, local metres.
    features
        The feature that each polygon is of.
    low, high
        (n,) z of their ends, ``-inf`` and ``inf`` where the file gives none.
    counts
        How many features were left out or changed, and how.
    heeded
        Sentences on zones of which the ground leaves less than their file says, or nothing.
    """

    outlines: list[Any]
    features: list[Feature]
    low: Floats
    high: Floats
    counts: Counter[str] = field(default_factory=Counter)
    heeded: list[str] = field(default_factory=list)

    def chosen(self, these: NDArray[np.bool_]) -> "LocalFeatures":
        """Return the features that are chosen, (n,)."""
        outlines, features = list(compress(self.outlines, these)), list(compress(self.features, these))
        return LocalFeatures(outlines, features, self.low[these], self.high[these], Counter(self.counts))


def local_features(
    features: Sequence[Feature], origin: Origin, region: Rectangle, terrain: Terrain | None, reach: float
) -> LocalFeatures:
    """Bring features into the local frame; what is farther than `reach` metres from a region is cut off."""
    from skyverse.maps.readers.polygons import features_around, pieces

    given, features = len(features), features_around(features, origin.longitude, origin.latitude)
    counts: Counter[str] = Counter()
    x0, y0, x1, y1 = region[0] - reach, region[1] - reach, region[2] + reach, region[3] + reach
    outlines = local_outlines(features, origin)
    boxes = shapely.bounds(outlines).reshape(-1, 4)
    near = (boxes[:, 0] <= x1) & (boxes[:, 2] >= x0) & (boxes[:, 1] <= y1) & (boxes[:, 3] >= y0)
    counts["outside"] = int((~near).sum()) + max(0, given - len(features))
    kept, outlines = list(compress(features, near)), outlines[near]
    if terrain is not None:
        kept, outlines = _on_even_ground(kept, outlines, terrain, max(x1 - x0, y1 - y0))
    low, high = _ends(kept, outlines, origin, terrain)
    heeded = [] if terrain is None else list(_over_ground(kept, high, origin, ground_range(terrain, outlines)))
    empty = low >= high
    counts[BURIED] = int(empty.sum())
    kept = list(compress(kept, ~empty))
    low, high = low[~empty], high[~empty]
    outlines = shapely.buffer(outlines[~empty], ROUNDING, join_style="mitre", mitre_limit=5.0)
    frame = shapely.box(x0, y0, x1, y1)
    crossing = ~shapely.covered_by(outlines, frame)
    counts["cut at the edge of the area"] = int(crossing.sum())
    outlines[crossing] = shapely.intersection(outlines[crossing], frame)
    parts = [pieces(outline) for outline in outlines]
    rows = [k for k, some in enumerate(parts) for _ in some]
    whole = [part for some in parts for part in some]
    return LocalFeatures(whole, [kept[k] for k in rows], low[rows], high[rows], counts, heeded)


def _on_even_ground(
    features: list[Feature], outlines: NDArray[Any], terrain: Terrain, width: float
) -> tuple[list[Feature], NDArray[Any]]:
    """Divide cells of permitted heights over uneven ground: less is lost by counting from the lowest ground."""
    least = max(LEAST_CELL, width / MAX_CELLS_ACROSS)
    while True:
        x0, y0, x1, y1 = shapely.bounds(outlines).reshape(-1, 4).T
        uneven = np.array([feature.kind == ABOVE_PERMITTED for feature in features], dtype=bool)
        uneven &= np.maximum(x1 - x0, y1 - y0) > least
        if uneven.any():
            low, high = ground_range(terrain.lowest_ground, outlines[uneven])
            uneven[uneven] = high - low > EVEN
        if not uneven.any():
            return features, outlines
        along = x1 - x0 >= y1 - y0
        x, y = np.where(along, (x0 + x1) / 2, x1), np.where(along, y1, (y0 + y1) / 2)
        first = shapely.intersection(outlines, shapely.box(x0, y0, x, y))[uneven]
        x, y = np.where(along, (x0 + x1) / 2, x0), np.where(along, y0, (y0 + y1) / 2)
        second = shapely.intersection(outlines, shapely.box(x, y, x1, y1))[uneven]
        features = [*compress(features, ~uneven), *2 * list(compress(features, uneven))]
        outlines = np.concatenate([outlines[~uneven], first, second])


def local_outlines(features: Sequence[Feature], origin: Origin) -> NDArray[Any]:
    """Return polygons (n,) of shapely in local metres."""
    rings = [ring for feature in features for ring in (feature.outline, *feature.holes)]
    if not rings:
        return np.empty(0, dtype=object)
    sizes = np.array([len(ring) for ring in rings])
    owner = np.repeat(np.arange(len(features)), [1 + len(feature.holes) for feature in features])
    corners = np.concatenate(rings)
    places = to_local(origin, np.column_stack([corners[:, ::-1], np.zeros(len(corners))]))[:, :2]
    number = np.repeat(np.arange(len(rings)), sizes)
    made = shapely.linearrings(places, indices=number)
    polygons: NDArray[Any] = shapely.polygons(made, indices=owner)
    valid = shapely.is_valid(polygons)
    if not valid.all():
        polygons[~valid] = shapely.make_valid(polygons[~valid], method="structure", keep_collapsed=False)
    return polygons


def _ends(
    features: Sequence[Feature],
    outlines: NDArray[Any],
    origin: Origin,
    terrain: Terrain | None,
) -> tuple[Floats, Floats]:
    """Return z of both ends (n,): the lowest at which a feature may begin and the highest at which it may end."""
    low, high = np.full(len(features), -np.inf), np.full(len(features), np.inf)
    for ends, side in ((low, "low"), (high, "high")):
        sea = np.array([isinstance(getattr(feature, side), AboveSea) for feature in features], dtype=bool)
        ends[sea] = _metres(features, sea, side) - origin.altitude
    home = next((f for f in features if isinstance(f.low, AboveHome) or isinstance(f.high, AboveHome)), None)
    if home is not None:
        raise InputError(f"{home.where}: an altitude above home, but an obstacle has no home; give it as agl or amsl")
    floored = np.array([isinstance(feature.low, AboveGround) for feature in features], dtype=bool)
    capped = np.array([isinstance(feature.high, AboveGround) for feature in features], dtype=bool)
    if terrain is None:
        if (floored | capped).any():
            where = features[int(np.flatnonzero(floored | capped)[0])].where
            raise InputError(f"{where}: an altitude above ground, which is unknown", give=GIVE_GROUND)
        return low, high
    lowest, highest = ground_range(terrain, outlines)
    permitted = np.array([feature.kind == ABOVE_PERMITTED for feature in features], dtype=bool)
    if permitted.any():
        lowest[permitted] = ground_range(terrain.lowest_ground, outlines[permitted])[0]
    stands = np.array(
        [
            feature.low is None
            or (feature.solid and feature.kind in KINDS_FROM_THE_GROUND and isinstance(feature.low, AboveSea))
            for feature in features
        ],
        dtype=bool,
    )
    low[stands] = np.where(np.isfinite(low), np.minimum(low, lowest), lowest)[stands]
    low[floored] = lowest[floored] + _metres(features, floored, "low")
    high[capped] = highest[capped] + _metres(features, capped, "high")
    return low, high


def _over_ground(
    features: Sequence[Feature], high: Floats, origin: Origin, ground: tuple[Floats, Floats]
) -> Iterator[str]:
    """Take the upper end (n,) from zones that end at or below all ground below them, and yield what is to be told.

    Such an end is none, as one that a file counts from the ground itself.
    """
    for k, (feature, lowest, highest) in enumerate(zip(features, *ground, strict=True)):
        if feature.solid or high[k] > highest:
            continue
        end, least, most = (f"{z + origin.altitude:.0f} m" for z in (high[k], lowest, highest))
        named = f"{feature.name or feature.where.rpartition(': ')[2]}: its upper limit, {end} amsl, is"
        if high[k] <= lowest:
            high[k] = np.inf
            said = f"{named} at or below the ground there, {least} or more, and counts as none"
            yield f"{Caution.WARNING}: {said}: closed from the ground up"
        elif not isinstance(feature.low, AboveSea):
            yield f"{named} below a part of the ground there, up to {most}, over which it closes nothing"


def _metres(features: Sequence[Feature], these: NDArray[np.bool_], side: str) -> Floats:
    """Return the metres of one side's altitude of the features that are chosen."""
    return np.array([getattr(features[k], side).metres for k in np.flatnonzero(these).tolist()], dtype=np.float64)


def within_bounds(these: LocalFeatures, floor: float, ceiling: float, reach: float) -> LocalFeatures:
    """Leave out what lies above the ceiling or below the floor; what has no end ends `reach` metres beyond them."""
    inside = (these.low < ceiling + reach) & (these.high > floor - reach)
    found = these.chosen(inside)
    found.low, found.high = np.maximum(found.low, floor - reach), np.minimum(found.high, ceiling + reach)
    found.counts[BEYOND] += int((~inside).sum())
    return found


def simplified(these: LocalFeatures, tolerance: float) -> LocalFeatures:
    """Merge buildings, and cells, that touch and are about as high, and give outlines fewer corners, none smaller.

    Parameters
    ----------
    these
        The features.
    tolerance
        How far outlines may grow, and how far the ends of merged buildings may lie apart, metres.
    """
    from skyverse.maps.assembly.footprints import merge, simplify

    if not these.outlines:
        return these
    alike = np.array([tolerance > 0 and f.kind in MERGED_KINDS and f.risk is None for f in these.features])
    rest, joint = these.chosen(~alike), these.chosen(alike)
    features, counts, low, high = rest.features, rest.counts, rest.low, rest.high
    outlines = np.array(rest.outlines, dtype=object)
    if joint.outlines:
        merged = merge(joint.outlines, joint.low, joint.high, tolerance)
        firsts = [(joint.features[rows[0]], len(rows)) for rows in merged.members]
        features += [first if many == 1 else replace(first, name=None) for first, many in firsts]
        counts["merged with others"] = len(joint.outlines) - len(merged.polygons)
        outlines = np.concatenate([outlines, merged.polygons])
        low, high = np.concatenate([low, merged.low]), np.concatenate([high, merged.high])
    outlines = simplify(outlines, tolerance)
    while (many := shapely.get_num_coordinates(outlines) > MAX_CORNERS).any() and tolerance < 1e4:
        tolerance = max(2 * tolerance, 0.01)
        outlines[many] = simplify(outlines[many], tolerance)
        counts[f"of more than {MAX_CORNERS} corners, simplified by {tolerance:g} m"] = int(many.sum())
    return LocalFeatures(list(outlines), features, low, high, counts)


def prisms(these: LocalFeatures) -> tuple[list[Prism], Counter[str]]:
    """Return features as prisms, and how many were left out or changed, and how."""
    counts = Counter(these.counts)
    made = []
    for outline, feature, low, high in zip(these.outlines, these.features, these.low, these.high, strict=True):
        given = {name: getattr(feature, name) for name in ("name", "kind", "solid", "risk", "active")}
        given |= {"low": float(low), "high": float(high)}
        try:
            made.append(Prism(vertices=_ring(outline.exterior), holes=_rings(outline), **given))
        except InputError:  # an outline that touches itself or is thinner than the rounding has a sound hull
            hull = outline.convex_hull.buffer(ROUNDING, join_style="mitre")
            try:
                made.append(Prism(vertices=_ring(hull.exterior), **given))
            except InputError as error:
                raise InputError(f"{feature.where}: cannot become a prism: {error}") from None
            counts["taken as their convex hull"] += 1
    return made, counts


def _rings(outline: Any) -> tuple[Floats, ...]:
    rings = [_ring(hole) for hole in outline.interiors]
    return tuple(ring for ring in rings if len(ring) >= 3)  # a hole thinner than the rounding is filled


def _ring(ring: Any) -> Floats:
    """Return a ring's corners (n, 2), rounded, without repetitions."""
    corners: Floats = np.round(shapely.get_coordinates(ring), 3)
    return corners[1:][np.any(corners[1:] != corners[:-1], axis=1)]
