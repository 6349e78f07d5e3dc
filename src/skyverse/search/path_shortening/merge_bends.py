"""Few bends for many: two neighbouring bends give way to one farther out.

Around a curved shape, bends that lie close to each other hold each other in place; fewer bends slide farther, and
`shorten` then finds a shorter path.
"""

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.norm import distance
from skyverse.numerics.tolerances import COLLINEAR_DOT
from skyverse.space.obstacles import Space
from skyverse.space.world import segment_free

MAX_MEETING_COSINE = 0.7
"""Two legs are prolonged to where they meet only where the cosine of the angle between them is at most this."""
OVERSHOOT = 0.02
"""The share by which a merged bend lies farther out than where the legs meet, so that it clears the shape."""


@kernel
def merge_bends(space: Space, path: Floats) -> Floats:
    """Return a free path (k, 3) that has one bend where a given free path (n, 3) has two neighbouring ones.

    Two bends are merged where their outer legs, prolonged, meet in a place that both outer neighbours see. It is
    repeated until no two are merged. The path may get longer.
    """
    meeting = np.empty(3)
    merged = True
    while merged and len(path) > 3:
        merged = False
        fewer = np.empty_like(path)
        count, i = 0, 0
        while i < len(path):
            meet = 0 < i < len(path) - 2 and _meet(fewer[count - 1], path[i], path[i + 1], path[i + 2], meeting)
            if meet and segment_free(space, fewer[count - 1], meeting) and segment_free(space, meeting, path[i + 2]):
                merged = True
                i += 1
            else:
                for axis in range(3):
                    meeting[axis] = path[i, axis]
            for axis in range(3):
                fewer[count, axis] = meeting[axis]
            count += 1
            i += 1
        path = fewer[:count].copy()
    return path


@inner
def _meet(a: Floats, v: Floats, w: Floats, b: Floats, meeting: Floats) -> bool:
    """Write into `meeting` where the legs a-v and b-w meet beyond v and w, a little farther out; tell whether they do.

    With unit vectors p from a to v and q from b to w, the points v + s p and w + t q are nearest to each other for

        s = (p . (w - v) - (p . q) (q . (w - v))) / (1 - (p . q)^2)
        t = ((p . q) (p . (w - v)) - q . (w - v)) / (1 - (p . q)^2)

    and the legs meet in the middle between these two points.
    """
    to_v, to_w = distance(a, v), distance(b, w)
    if to_v == 0.0 or to_w == 0.0:
        return False
    along = from_v = from_w = 0.0
    for axis in range(3):
        p, q, gap = (v[axis] - a[axis]) / to_v, (w[axis] - b[axis]) / to_w, w[axis] - v[axis]
        along += p * q
        from_v += p * gap
        from_w += q * gap
    if along > MAX_MEETING_COSINE or along < -1.0 + COLLINEAR_DOT:  # the path turns back, or is straight
        return False
    s, t = (from_v - along * from_w) / (1.0 - along**2), (along * from_v - from_w) / (1.0 - along**2)
    if s <= 0.0 or t <= 0.0:
        return False
    for axis in range(3):
        p, q, middle = (v[axis] - a[axis]) / to_v, (w[axis] - b[axis]) / to_w, 0.5 * (v[axis] + w[axis])
        nearest = 0.5 * (v[axis] + s * p + w[axis] + t * q)
        meeting[axis] = nearest + OVERSHOOT * (nearest - middle)
    return True
