"""Other ways round: a search over all edges that a shorter path could touch, not only over those near a path."""

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.numerics.arrays import put
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import distance, length_of
from skyverse.numerics.tolerances import OTHER_WAY_WORTH
from skyverse.search.taut.edge_geometry import best_crossing, crossings_within, pieces_within
from skyverse.search.taut.edge_search import BendPoints, search_edges
from skyverse.search.taut.shorten_window import cheapest_detour, local_space
from skyverse.search.taut.tighten import tighten
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space

MAX_PIECES = 2000
"""Pieces of edges in reach at most; where there are more, no other way is sought."""
WIDEST, NARROWEST = 1 / 12, 1 / 100
"""How far apart points are in the first search and in the last, as a share of the path's length."""
REFINEMENT = 0.5
"""By which factor points are nearer to each other in each search than in the one before."""
MAX_WORK = 2_500_000
"""Pairs of a state and a piece of an edge that all searches look at, at most."""
SHORT_PIECE = 0.5
"""A piece is short if a path can cross it on less than this share of the distance between points."""
FULL_GAP = 0.01
"""The gap to a bound, as a share of it, from which on all this work may be done; less of it for a smaller gap."""


@inner
def shortest_way(space: Space, edges: Edges, path: Floats, least: float, spent: Ints) -> Floats:
    """Return a free path (k, 3) with the same ends as a given one that is not longer, perhaps another way round.

    No path is shorter than `least` metres. Points are spread evenly over all pieces of edges that a shorter path could
    touch, and A* searches over them with lazy visibility; what it finds is tightened. This is repeated with ever more
    points.
    """
    start, goal = path[0], path[-1]
    share = WIDEST
    work = int(MAX_WORK * min((length_of(path) / least - 1.0) / FULL_GAP, 1.0))
    while share > NARROWEST and work > 0:
        length = length_of(path)
        if length < (1.0 + OTHER_WAY_WORTH) * distance(start, goal):
            break
        pieces = pieces_within(edges, start, goal, length, MAX_PIECES)
        if len(pieces) > MAX_PIECES:
            break
        points = _spread(edges, pieces, path, length, share * length)
        most = work // max(len(pieces), 1)
        found = search_edges(local_space(space, path)[0], edges, points, (1.0 - OTHER_WAY_WORTH) * length, most)
        spent[0] += 1
        spent[1] += found.expanded
        work -= found.expanded * len(pieces)
        if len(found.points):
            path = tighten(space, edges, points.at[found.points], spent)
        share *= REFINEMENT
    return path


@inner
def _spread(edges: Edges, pieces: Ints, path: Floats, length: float, spacing: float) -> BendPoints:
    """Spread points, at most `spacing` metres apart, over pieces of edges where a path so long can cross them.

    Each piece has its ends, the place where the straight line's detour over it is shortest, and two places where a
    detour of a given path is; a short piece has only the second of these. Start and goal come first.
    """
    low, high = np.empty(len(pieces)), np.empty(len(pieces))
    start, goal = path[0], path[-1]
    for k in range(len(pieces)):
        x = best_crossing(edges, pieces[k], start, goal)
        low[k], high[k] = crossings_within(edges, pieces[k], x, start, goal, length)
    most = 2
    for k in range(len(pieces)):
        most += 5 + int((high[k] - low[k]) / spacing)
    at = np.empty((most, 3))
    edge = np.full(most, -1)
    put(at, 0, start)
    put(at, 1, goal)
    n = 2
    for k in range(len(pieces)):
        e = pieces[k]
        axis = edges.axis[e]
        gaps = 1 + int((high[k] - low[k]) / spacing)
        short = high[k] - low[k] < SHORT_PIECE * spacing
        for i in range(gaps + 1 if short else 0, gaps + 2 if short else gaps + 4):
            if i <= gaps:
                place = low[k] + (high[k] - low[k]) * i / gaps
            elif i == gaps + 1:
                place = best_crossing(edges, e, start, goal)
            else:
                place = cheapest_detour(edges, e, path, i - gaps - 1)
            put(at, n, edges.ends[e, :3])
            at[n, axis] = place
            edge[n] = e
            n += 1
    return BendPoints(at[:n], edge[:n])
