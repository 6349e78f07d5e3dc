"""Prisms as arrays of edges and altitudes, as they are given, before anything grows them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.shapes import Prism


class Outlines(NamedTuple):
    """The outlines and altitudes of prisms.

    Attributes
    ----------
    p, q
        (e, 2) metres: the ends of the edges of all outlines and holes, one prism's after another's.
    first, edges
        (m,) the index of each prism's first edge, and how many edges it has.
    low, high
        (m,) altitudes, metres.
    """

    p: Floats
    q: Floats
    first: Indices
    edges: Indices
    low: Floats
    high: Floats

    def of(self, some: Indices) -> "Outlines":
        """Return those of some of the prisms, given by their numbers (k,)."""
        count = self.edges[some]
        first = np.cumsum(count) - count
        edge = np.arange(count.sum()) + np.repeat(self.first[some] - first, count)
        return Outlines(self.p[edge], self.q[edge], first, count, self.low[some], self.high[some])


def outlines_of(prisms: Sequence[Prism]) -> Outlines:
    """Return the outlines of prisms."""
    rings = [ring for prism in prisms for ring in (prism.vertices, *prism.holes)]
    size = np.array([len(ring) for ring in rings], dtype=np.intp)
    p = np.reshape([corner for ring in rings for corner in ring], (int(size.sum()), 2))
    following, begins = np.arange(1, len(p) + 1), np.cumsum(size) - size
    following[begins + size - 1] = begins
    edges = np.array([len(prism.vertices) + sum(map(len, prism.holes)) for prism in prisms], dtype=np.intp)
    low = np.array([prism.low for prism in prisms], dtype=np.float64)
    high = np.array([prism.high for prism in prisms], dtype=np.float64)
    return Outlines(p, p[following], np.cumsum(edges) - edges, edges, low, high)
