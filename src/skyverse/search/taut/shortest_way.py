"""The shortest way round that is found, and a length that no path beats, from one graph of intervals of edges.

The graph is searched for a bound, which strikes out what no path shorter than a limit touches, and then for a path over
the middles of the intervals that are left. Both searches get sharper as the intervals are halved. A shorter path lowers
the limit.
"""

from skyverse._typing import Floats, Ints
from skyverse.numerics.kernel import inner
from skyverse.numerics.norm import length_of
from skyverse.numerics.tolerances import BOUND_ROUNDING, OTHER_WAY_WORTH
from skyverse.search.taut.interval_graph import finer, first_graph, legs_by_interval
from skyverse.search.taut.lower_bound import sharpen
from skyverse.search.taut.shorten_window import local_space
from skyverse.search.taut.tighten import tighten
from skyverse.search.taut.way_over_middles import way_over_middles
from skyverse.space.edges import Edges
from skyverse.space.obstacles import Space

GAPS = (0.02, 0.5 * OTHER_WAY_WORTH)
"""The gaps between a known length and its bound that are sought one after the other, as shares of the bound."""
FIRST_SPACING = 1 / 6
"""The greatest length of the first intervals, as a share of the path's length."""
HALVINGS = 12
"""How often intervals are halved at most."""
DETOUR_TO_MIDDLES = 2.5
"""By how many gaps a path over the first intervals' middles may be longer than the known one, as a share of it; by half
as many after each halving. Tightening takes such a detour away."""


@inner
def shortest_way(
    space: Space, edges: Edges, path: Floats, bound: float, most: int, spent: Ints
) -> tuple[Floats, float]:
    """Return a path that is not longer than a given one and has the same ends, and a length that no such path beats.

    Parameters
    ----------
    path
        (k, 3) metres: a free path.
    bound
        A lower bound that is known, metres.
    most
        Pairs of intervals to look at, at most, about; less where the known gap is small.
    spent
        (2,) searches for paths and the states that they expanded are added.
    """
    looked = 0
    most = int(most * min((1.0 - bound / length_of(path)) / GAPS[0], 1.0))
    for gap in GAPS:
        if bound * (1.0 + gap) < length_of(path):
            path, found, more = _bound_up_to(space, edges, path, gap, most - looked, spent)
            looked += more
            bound = max(bound, found - BOUND_ROUNDING)
            if looked > most:
                break
    return path, bound


@inner
def _bound_up_to(
    space: Space, edges: Edges, path: Floats, gap: float, most: int, spent: Ints
) -> tuple[Floats, float, int]:
    """Return a path, a lower bound, 0 if none is found, and the pairs looked at.

    The search ends when the path is proven to exceed the bound by no more than the share `gap` of it.
    """
    near, _ = local_space(space, path)
    limit = length_of(path) / (1.0 + gap)
    spacing = FIRST_SPACING * limit
    graph, looked = first_graph(near, edges, path[0], path[-1], limit, spacing, most)
    bound = 0.0
    for turn in range(HALVINGS):
        if looked > most:
            break
        source = turn % 2
        lists = legs_by_interval(graph)
        graph, found = sharpen(graph, lists, source, limit)
        bound = max(bound, found)
        if bound >= limit:
            break
        worth = (1.0 + DETOUR_TO_MIDDLES * gap * 0.5**turn - OTHER_WAY_WORTH) * length_of(path)
        way = way_over_middles(space, edges, graph, lists, 1 - source, worth, spent)
        if len(way) and (length_of(way) < length_of(path) or 2 * looked > most):
            way = tighten(space, edges, way, spent)
            if length_of(way) < length_of(path):
                path = way
                limit = min(limit, length_of(path) / (1.0 + gap))
        spacing *= 0.5
        graph, more = finer(near, edges, graph, limit, spacing, most - looked)
        looked += more
    return path, bound, looked
