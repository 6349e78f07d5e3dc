"""Viewpoints: few places and directions for photos that together show facets, chosen among many that are clear."""

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.model.arrays import arctan2
from skyverse.space.world import World
from skyverse.survey.facets import Facets
from skyverse.survey.set_cover import few_sets
from skyverse.survey.views import Sights

COARSE = ((0.0, 0.0, 1.0), (30.0, 0.0, 0.8), (-30.0, 0.0, 0.8), (0.0, 30.0, 0.8), (0.0, -30.0, 0.8), (0.0, 0.0, 0.7))
"""From where a facet is looked at first: degrees beside its normal, above it, and shares of the distance asked for."""
FINE = tuple(
    (a, e, s) for s in (1.0, 0.7, 0.5, 0.35) for e in (0, 20, -20, 40, -40, 55, -55) for a in (0, 25, -25, 50, -50)
)
"""From where facets are looked at that nothing of `COARSE` shows."""
PITCHES = (-90.0, 30.0)
"""Degrees above the horizon between which gimbals turn."""
UPRIGHT, ALL_ROUND = 0.1, 3.6
"""Where the horizontal part of an outward direction is less, it has no heading: degrees beside count so many times."""
MOST_VIEWS = 60_000
"""Views that are tried at once; of more, every second one, third one and so on is tried."""


def few_views(
    world: World, sights: Sights, facets: Facets, pitch: float | None = None
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return few views that show facets, and whether each facet is shown.

    Parameters
    ----------
    world
        Where the UAV may be.
    sights
        What views see.
    facets
        What is to be seen.
    pitch
        Degrees above the horizon at which all look; any if it is left out.

    Returns
    -------
    views, shown
        (m, 5): x, y, z in metres, heading and pitch in degrees; and (n,).
    """
    rows, pairs, shown = [np.zeros((0, 5))], [np.zeros((2, 0), dtype=np.int64)], np.zeros(len(facets), dtype=np.bool_)
    for offers in (COARSE, FINE):
        left = facets.chosen(~shown)
        offered = np.concatenate(
            [views_of(*_aims(left, offer[2] == 1.0), sights.look.distance, offer, pitch) for offer in offers]
        )
        offered = offered[world.free(offered[:, :3])] if len(offered) else offered
        offered = offered[:: 1 + len(offered) // MOST_VIEWS]
        view, facet = sights.seen(offered, facets)
        pairs.append(np.array([view + sum(map(len, rows)), facet]))
        rows.append(offered)
        shown[facet] = True
        if shown.all():
            break
    views = np.concatenate(rows)
    return views[few_sets(*np.concatenate(pairs, axis=1))], shown


def _aims(facets: Facets, with_corners: bool) -> tuple[Floats, Floats, Floats]:
    """Return places to look at, outward directions and headings of pictures taken straight down.

    They are the facets' centres, and their corners, where the direction is the mean of the facets that meet there.
    """
    edge = facets.corners[:, 1] - facets.corners[:, 0]
    turn = np.degrees(arctan2(edge[:, 0], edge[:, 1])) % 180.0
    if not with_corners:
        return facets.centre, facets.normal, turn
    places, where = np.unique(np.round(facets.corners.reshape(-1, 3), 2), axis=0, return_inverse=True)
    normal = np.zeros_like(places)
    np.add.at(normal, where.ravel(), np.repeat(facets.normal, 4, axis=0))
    turns = np.zeros(len(places))
    turns[where.ravel()] = np.repeat(turn, 4)
    length = np.sqrt((normal**2).sum(axis=1))
    whole = length > 1e-3
    normal = normal[whole] / length[whole, None]
    aims = np.concatenate([facets.centre, places[whole]]), np.concatenate([facets.normal, normal])
    return *aims, np.concatenate([turn, turns[whole]])


def views_of(
    aims: Floats, outward: Floats, turn: Floats, distance: float, offer: tuple[float, float, float], pitch: float | None
) -> Floats:
    """Return the views (n, 5) on places (n, 3) from a direction beside and above the outward one, (n, 3).

    `turn` is the heading, (n,) degrees, where the camera looks straight down.
    """
    beside, above, share = offer
    heading = np.degrees(arctan2(-outward[:, 0], -outward[:, 1])) + beside
    flat = np.hypot(outward[:, 0], outward[:, 1])
    down = -np.degrees(arctan2(outward[:, 2], flat)) - above
    pitches = np.clip(down, *PITCHES) if pitch is None else np.full(len(aims), pitch)
    heading = np.where(flat < UPRIGHT, turn + ALL_ROUND * beside + 90.0 * (share < 1.0), heading) % 360.0
    h, p = np.radians(heading), np.radians(pitches)
    ahead = np.column_stack([np.cos(p) * np.sin(h), np.cos(p) * np.cos(h), np.sin(p)])
    return np.column_stack([aims - share * distance * ahead, heading, pitches])
