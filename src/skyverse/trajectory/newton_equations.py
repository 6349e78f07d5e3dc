"""Newton's equations of a spline through a corridor: gradient and Hessian of its objective and barriers.

With the control points P, the logarithms x of the corridor boxes' durations and a weight mu of the barriers, the
objective is

    f(P, x) = sum of durations + weight * integral |jerk or snap|^2 dt - mu * sum of log(slack),

with a slack for each coordinate of a control point towards either side of its bounds, and, for each control point d of
velocity, acceleration and jerk,

    limit^2 - |d|^2,    thrust^2 - |d + g|^2,    tilt^2 (d_z + fall)^2 - d_x^2 - d_y^2,
    ascent - d_z,    descent + d_z,

of which those with thrust and tilt are for accelerations only, and the last two for velocities only. Every such d, and
every value of jerk or snap that the integral needs, is ``d = sum of r_i P_i`` with a row r of at most five coefficients
that depend on x. A function phi(d) with gradient g and Hessian H by d adds, by the chain rule,

    df/dP_i = r_i g                            d2f/dP_i dP_j = r_i r_j H
    df/dx_e = g . d_e                          d2f/dx_e dx_f = d_e . H d_f + g . d_ef
    d2f/dx_e dP_i = r_i H d_e + r_i,e g

where an index e or f after d or r stands for a derivative by x_e or x_f. Where all spans of a row lie in one box,
``d = c exp(-m x_e)`` for a derivative of order m, hence ``d_e = -m d`` and ``d_ee = m^2 d``.
"""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.model.uav import GRAVITY
from skyverse.numerics.kernel import by_reference, inner, kernel
from skyverse.trajectory.limits import Limits
from skyverse.trajectory.newton_step import NewtonSystem
from skyverse.trajectory.spline import JET, make_rows, multiply, row_jet

FIXED = 4
"""Control points at either end that stay at one point, so that the flight starts and stops at rest and without jerk."""
ROOT_12 = np.sqrt(12.0)


@by_reference
class SplineProblem(NamedTuple):
    """The constraints and the objective of a spline, which stay the same while it is improved.

    Attributes
    ----------
    low, high
        (N, 3) bounds of each control point, metres.
    box_of
        (S,) the number of the corridor box of each span, rising from 0.
    limits
        Of the UAV; thrust and tilt are infinite where the limit on acceleration implies them.
    weight
        Of the integral of squared jerk or snap.
    order
        3 for jerk, 4 for snap.
    """

    low: Floats
    high: Floats
    box_of: Ints
    limits: Limits
    weight: float
    order: int


@kernel
def assemble(
    problem: SplineProblem,
    spans: Floats,
    points: Floats,
    mu: float,
    system: NewtonSystem,
    work: Floats,
    jets: Floats,
    other: Floats,
) -> None:
    """Write Newton's equations of a spline.

    Parameters
    ----------
    problem
        Constraints and objective.
    spans
        (S,) durations, seconds.
    points
        (N, 3) control points, metres.
    mu
        The weight of the barriers.
    system
        Is written.
    work, jets, other
        (2, 5, 5, 6), (6, 6) and (6, 6): room for intermediate results.
    """
    n, s = len(points), len(spans)
    system.by_points.fill(0.0)
    system.by_durations.fill(0.0)
    for blocks in (system.band, system.cross, system.small):
        blocks.fill(0.0)
    for k in range(s):
        system.by_durations[problem.box_of[k]] += spans[k]
        system.small[problem.box_of[k], problem.box_of[k]] += spans[k]
    for i in range(FIXED, n - FIXED):
        for a in range(3):
            below, above = points[i, a] - problem.low[i, a], problem.high[i, a] - points[i, a]
            system.by_points[3 * (i - FIXED) + a] += mu * (1.0 / above - 1.0 / below)
            system.band[3 * (i - FIXED) + a, 0] += mu * (1.0 / above**2 + 1.0 / below**2)
    g, h, d = np.empty(3), np.empty((3, 3)), np.empty((6, 3))
    row = np.empty(5)
    for order in range(1, 4):
        rows = make_rows(spans, order)
        for i in range(n - order):
            left, right = problem.box_of[max(i - 3, 0)], problem.box_of[min(i + order - 1, s - 1)]
            if left == right:
                _combine(rows[i], points, i, order + 1, d)
                _limit_barriers(problem.limits, order, d[0, 0], d[0, 1], d[0, 2], mu, g, h)
                _add_within(system, rows[i], (i, i + order + 1), left, float(order), d, g, h)
            else:
                row_jet(spans, problem.box_of, left, i, order, work, jets)
                _combine_jets(jets, points, i, order + 1, d)
                _limit_barriers(problem.limits, order, d[0, 0], d[0, 1], d[0, 2], mu, g, h)
                _add(system, jets, (i, i + order + 1), (left, right), d, g, h)
    rows = make_rows(spans, problem.order)
    for k in range(s):
        left, right = problem.box_of[max(k - 3, 0)], problem.box_of[min(k + 3, s - 1)]
        # jerk is linear over the span, from a to b, and the integral of its square two squares,
        # h/3 (a^2 + ab + b^2) = h (a + b)^2 / 4 + h (b - a)^2 / 12
        for part in range(5 - problem.order):
            if left == right:
                root = np.sqrt(spans[k])
                if problem.order == 4:
                    for c in range(5):
                        row[c] = root * rows[k, c]
                else:
                    row.fill(0.0)
                    near, far = (0.5 * root, 0.5 * root) if part == 0 else (-root / ROOT_12, root / ROOT_12)
                    for c in range(4):
                        row[c] += near * rows[k, c]
                        row[c + 1] += far * rows[k + 1, c]
                _combine(row, points, k, 5, d)
                _square(problem, d, g, h)
                _add_within(system, row, (k, k + 5), left, problem.order - 0.5, d, g, h)
                continue
            if problem.order == 4:
                row_jet(spans, problem.box_of, left, k, 4, work, jets)
            elif part == 0:
                row_jet(spans, problem.box_of, left, k, 3, work, other)
                for e in range(JET):
                    other[4, e] = 0.0
                row_jet(spans, problem.box_of, left, k + 1, 3, work, jets)
                for e in range(JET):
                    for c in range(4, 0, -1):
                        jets[c, e] = jets[c - 1, e]
                    jets[0, e] = 0.0
                for c in range(5):
                    for e in range(JET):
                        x, y = other[c, e], jets[c, e]
                        jets[c, e], other[c, e] = 0.5 * (x + y), (y - x) / ROOT_12
            else:
                for c in range(5):
                    for e in range(JET):
                        jets[c, e] = other[c, e]
            _times_root(jets, 5, spans[k], problem.box_of[k] == left)
            _combine_jets(jets, points, k, 5, d)
            _square(problem, d, g, h)
            _add(system, jets, (k, k + 5), (left, right), d, g, h)


@inner
def _times_root(jets: Floats, m: int, span: float, in_left: bool) -> None:
    """Multiply m jets by the square root of a span's duration."""
    root = np.sqrt(span)
    scale = np.zeros(6)
    scale[0] = root
    scale[1 if in_left else 2] = 0.5 * root
    scale[3 if in_left else 5] = 0.25 * root
    product = np.empty(6)
    for c in range(m):
        product.fill(0.0)
        multiply(scale, jets[c], product, 1.0)
        for e in range(JET):
            jets[c, e] = product[e]


@inner
def _combine(row: Floats, points: Floats, i: int, m: int, d: Floats) -> None:
    """Write a control point of a derivative, a row times the points from i on, into d[0]."""
    for a in range(3):
        d[0, a] = 0.0
        for c in range(m):
            d[0, a] += row[c] * points[i + c, a]


@inner
def _combine_jets(jets: Floats, points: Floats, i: int, m: int, d: Floats) -> None:
    """Write a control point of a derivative and its derivatives by two durations, a jet of (6, 3)."""
    d.fill(0.0)
    for c in range(m):
        for e in range(6):
            for a in range(3):
                d[e, a] += jets[c, e] * points[i + c, a]


@inner
def _square(problem: SplineProblem, d: Floats, g: Floats, h: Floats) -> None:
    """Write gradient and Hessian of the weighted square of d[0]."""
    h.fill(0.0)
    for a in range(3):
        g[a] = 2.0 * problem.weight * d[0, a]
        h[a, a] = 2.0 * problem.weight


@inner
def _limit_barriers(limits: Limits, order: int, x: float, y: float, z: float, mu: float, g: Floats, h: Floats) -> None:
    """Write gradient and Hessian of the barriers of a control point of velocity, acceleration or jerk."""
    g.fill(0.0)
    h.fill(0.0)
    _ball(x, y, z, limits.speed if order == 1 else (limits.acceleration if order == 2 else limits.jerk), mu, g, h)
    if order == 1:
        _vertical_speed(limits, z, mu, g, h)
        if limits.through_air < np.inf:
            _ball(x - limits.east, y - limits.north, z - limits.up, limits.through_air, mu, g, h)
    if order != 2:
        return
    up = z + GRAVITY
    if limits.thrust < np.inf:
        _ball(x, y, up, limits.thrust, mu, g, h)
    if limits.tilt < np.inf:
        t, up = limits.tilt**2, z + limits.fall
        slack = t * up**2 - x * x - y * y
        slope = (-2.0 * x, -2.0 * y, 2.0 * t * up)
        for a in range(3):
            g[a] -= mu * slope[a] / slack
            for b in range(3):
                h[a, b] += mu * slope[a] * slope[b] / slack**2
        h[0, 0] += 2.0 * mu / slack
        h[1, 1] += 2.0 * mu / slack
        h[2, 2] -= 2.0 * mu * t / slack


@inner
def _vertical_speed(limits: Limits, z: float, mu: float, g: Floats, h: Floats) -> None:
    """Add gradient and Hessian of ``-mu (log(ascent - z) + log(descent + z))``, as far as there are these limits."""
    if limits.ascent < np.inf:
        slack = limits.ascent - z
        g[2] += mu / slack
        h[2, 2] += mu / slack**2
    if limits.descent < np.inf:
        slack = limits.descent + z
        g[2] -= mu / slack
        h[2, 2] += mu / slack**2


@inner
def _ball(x: float, y: float, z: float, radius: float, mu: float, g: Floats, h: Floats) -> None:
    """Add gradient and Hessian of ``-mu log(radius^2 - x^2 - y^2 - z^2)``."""
    per = 2.0 / (radius**2 - x * x - y * y - z * z)
    d = (x, y, z)
    for a in range(3):
        g[a] += mu * per * d[a]
        h[a, a] += mu * per
        for b in range(3):
            h[a, b] += mu * per * per * d[a] * d[b]


@inner
def _add(
    system: NewtonSystem,
    jets: Floats,
    points: tuple[int, int],
    boxes: tuple[int, int],
    d: Floats,
    g: Floats,
    h: Floats,
) -> None:
    """Add a function of a control point of a derivative, whose spans lie in one box or in two.

    `points` are the first of the control points that it depends on and the one after the last.
    """
    _add_by_points(system, jets[:, 0], points, g, h)
    first, last = _free(system, points)
    for e in range(1, 2 if boxes[0] == boxes[1] else 3):
        box = boxes[e - 1]
        for a in range(3):
            system.by_durations[box] += g[a] * d[e, a]
            pushed = h[a, 0] * d[e, 0] + h[a, 1] * d[e, 1] + h[a, 2] * d[e, 2]
            for i in range(first, last):
                p = i - points[0]
                system.cross[box, 3 * (i - FIXED) + a] += jets[p, 0] * pushed + jets[p, e] * g[a]
            system.small[box, box] += pushed * d[e, a] + g[a] * d[3 if e == 1 else 5, a]
            if e == 2:
                mixed = pushed * d[1, a] + g[a] * d[4, a]
                system.small[boxes[0], boxes[1]] += mixed
                system.small[boxes[1], boxes[0]] += mixed


@inner
def _add_within(
    system: NewtonSystem,
    row: Floats,
    points: tuple[int, int],
    box: int,
    power: float,
    d: Floats,
    g: Floats,
    h: Floats,
) -> None:
    """Add a function of one all of whose spans lie in one box: ``d`` is proportional to its duration to the -power."""
    _add_by_points(system, row, points, g, h)
    along = bent = 0.0
    for a in range(3):
        along += g[a] * d[0, a]
        d[1, a] = h[a, 0] * d[0, 0] + h[a, 1] * d[0, 1] + h[a, 2] * d[0, 2]
        bent += d[0, a] * d[1, a]
    system.by_durations[box] -= power * along
    system.small[box, box] += power * power * (bent + along)
    first, last = _free(system, points)
    for i in range(first, last):
        for a in range(3):
            system.cross[box, 3 * (i - FIXED) + a] -= power * row[i - points[0]] * (d[1, a] + g[a])


@inner
def _add_by_points(system: NewtonSystem, row: Floats, points: tuple[int, int], g: Floats, h: Floats) -> None:
    """Add the derivatives of a function by the control points alone."""
    first, last = _free(system, points)
    for i in range(first, last):
        own, at = row[i - points[0]], 3 * (i - FIXED)
        for a in range(3):
            system.by_points[at + a] += own * g[a]
        for j in range(i, last):
            c = own * row[j - points[0]]
            for a in range(3):
                for b in range(a if j == i else 0, 3):
                    system.band[at + a, 3 * (j - i) + b - a] += c * h[a, b]


@inner
def _free(system: NewtonSystem, points: tuple[int, int]) -> tuple[int, int]:
    """Return which of control points may move: the first of them, and the one after the last."""
    return max(points[0], FIXED), min(points[1], len(system.by_points) // 3 + FIXED)
