"""Rays from places to cameras, by code that shares nothing with the referee's but the records: what photos show.

A place is shown in a world, in which each camera is a little off and turned a little, if it lies in the picture, no
deeper than asked, and the straight line to the camera is free. Along such a line the ground is a parabola between the
lines of its grid, so that three heights tell exactly how high it rises.
"""

from dataclasses import dataclass, replace

import numpy as np

AT_ONCE = 20_000
"""Rays cast together, which bounds the memory."""


def turned(vectors, axis, angle):
    """Turn vectors (..., 3) about unit axes (..., 3) by angles (...,), radians, by Rodrigues' formula."""
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    along = (vectors * axis).sum(axis=-1, keepdims=True)
    return c * vectors + s * np.cross(axis, vectors) + (1 - c) * along * axis


def axes_of(heading, pitch, roll):
    """Return right, ahead and top, (n, 3, 3), of cameras that were level, looked north, and were then turned."""
    n = len(heading)
    right, ahead, top = (np.tile(np.eye(3)[k], (n, 1)) for k in range(3))
    up = np.tile([0.0, 0.0, 1.0], (n, 1))
    frame = np.stack([right, ahead, top], axis=1)
    for axis, angle in ((ahead, roll), (right, pitch), (up, -heading)):  # each about what was fixed before
        frame = turned(frame, axis[:, None], np.radians(angle)[:, None] + np.zeros((n, 3)))
    return frame


@dataclass(frozen=True)
class Caster:
    """What may hide places from cameras.

    Attributes
    ----------
    terrain
        Model record, or nothing for level ground at `floor`, which hides nothing.
    obstacles
        Model records, of which only the solid ones hide.
    facets
        (k, 3, 3) triangles.
    floor
        z of level ground.
    slack
        Metres by which a ray may enter what hides; less than nothing where it must keep clear of solids.
    lean
        Metres of height for each metre of the way by which it must keep clear of the ground.
    """

    terrain: object
    obstacles: tuple
    facets: np.ndarray
    floor: float
    slack: float = 1e-5
    lean: float = 0.0

    def ground(self, x, y):
        """Return the ground's z."""
        if self.terrain is None:
            return np.full(np.shape(x), self.floor)
        h = self.terrain.heights
        u = np.clip((x - self.terrain.origin[0]) / self.terrain.step[0], 0, h.shape[0] - 1)
        v = np.clip((y - self.terrain.origin[1]) / self.terrain.step[1], 0, h.shape[1] - 1)
        i, j = np.minimum(u.astype(int), h.shape[0] - 2), np.minimum(v.astype(int), h.shape[1] - 2)
        u, v = u - i, v - j
        return (h[i, j] * (1 - u) + h[i + 1, j] * u) * (1 - v) + (h[i, j + 1] * (1 - u) + h[i + 1, j + 1] * u) * v

    def blocked(self, places, cameras):
        """Return of (n, 3) places whether something is between them and (n, 3) cameras."""
        found = np.zeros(len(places), dtype=bool)
        for k in range(0, len(places), AT_ONCE):
            a, b = places[k : k + AT_ONCE], cameras[k : k + AT_ONCE]
            here = self._ground_blocks(a, b)
            for shape in self.obstacles:
                if shape.solid:
                    free = np.flatnonzero(~here)
                    here[free] = self._solid_blocks(shape, a[free], b[free])
            for facet in self.facets:
                free = np.flatnonzero(~here)
                here[free] = self._facet_blocks(facet, a[free], b[free])
            found[k : k + AT_ONCE] = here
        return found

    def _ground_blocks(self, a, b):
        if self.terrain is None or not len(a):
            return np.zeros(len(a), dtype=bool)
        top = float(self.terrain.heights.max())
        way = b - a
        end = np.ones(len(a))
        over = b[:, 2] > top
        end[over] = np.clip((top - a[over, 2]) / np.maximum(way[over, 2], 1e-12), 0, 1)
        cuts = [np.zeros((len(a), 1)), end[:, None]]
        for k in (0, 1):
            from_, to = (
                (p - self.terrain.origin[k]) / self.terrain.step[k] for p in (a[:, k], a[:, k] + end * way[:, k])
            )
            low = np.maximum(np.ceil(np.minimum(from_, to)), 0)
            high = np.minimum(np.floor(np.maximum(from_, to)), self.terrain.heights.shape[k] - 1)
            most = int(max((high - low).max() + 1, 0))
            lines = low[:, None] + np.arange(most)
            with np.errstate(divide="ignore", invalid="ignore"):
                cut = (lines - from_[:, None]) / (to - from_)[:, None] * end[:, None]
            cuts.append(np.where((lines <= high[:, None]) & np.isfinite(cut), np.clip(cut, 0, end[:, None]), 0.0))
        s = np.sort(np.concatenate(cuts, axis=1), axis=1)
        lean = self.lean * np.hypot(*way[:, :2].T)[:, None]
        p, m, q = (self._lift(a, way, t) + lean * t for t in (s[:, :-1], (s[:, :-1] + s[:, 1:]) / 2, s[:, 1:]))
        bend, tilt = 2 * (p + q - 2 * m), 4 * m - 3 * p - q  # p + tilt t + bend t^2 for t from 0 to 1
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(bend < 0, -tilt / (2 * bend), 0.0)
        t = np.clip(np.nan_to_num(t), 0, 1)
        rise = np.maximum(np.maximum(p, q), p + tilt * t + bend * t * t)
        return (rise > max(self.slack, 1e-9)).any(axis=1)

    def _lift(self, a, way, s):
        x, y, z = (a[:, k, None] + s * way[:, k, None] for k in range(3))
        return self.ground(x, y) - z

    def _solid_blocks(self, shape, a, b):
        kind, way, more = type(shape).__name__, b - a, -self.slack
        length = np.maximum(np.linalg.norm(way, axis=1), 1e-12)
        if kind == "Box":
            begin, end = _between(a, way, np.array(shape.min) - more, np.array(shape.max) + more)
        elif kind == "Cylinder":
            begin, end = _in_circle(a[:, :2] - shape.centre, way[:, :2], shape.radius + more)
            begin, end = _both((begin, end), _between(a[:, 2:], way[:, 2:], shape.low - more, shape.high + more))
        elif kind == "Sphere":
            begin, end = _in_circle(a - shape.centre, way, shape.radius + more)
        elif kind == "Prism":
            return self._prism_blocks(shape, a, way, more)
        else:
            raise TypeError(kind)
        return (np.minimum(end, 1) - np.maximum(begin, 0)) * length > 1e-6

    def _prism_blocks(self, shape, a, way, more):
        slab = _between(a[:, 2:], way[:, 2:], shape.low - more, shape.high + more)
        cuts, rings = [np.zeros(len(a)), np.ones(len(a))], [np.array(ring) for ring in (shape.vertices, *shape.holes)]
        for ring in rings:
            for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                d = q - p
                with np.errstate(divide="ignore", invalid="ignore"):
                    cross = way[:, 0] * d[1] - way[:, 1] * d[0]
                    s = ((p[0] - a[:, 0]) * d[1] - (p[1] - a[:, 1]) * d[0]) / cross
                cuts.append(np.clip(np.nan_to_num(s, posinf=0, neginf=0), 0, 1))
        s = np.sort(np.stack(cuts, axis=1), axis=1)
        found, length = np.zeros(len(a), dtype=bool), np.maximum(np.linalg.norm(way, axis=1), 1e-12)
        for k in range(s.shape[1] - 1):
            middle = a[:, :2] + ((s[:, k] + s[:, k + 1]) / 2)[:, None] * way[:, :2]
            inside = np.zeros(len(a), dtype=bool)
            for ring in rings:
                inside ^= in_ring(middle, ring)
            begin, end = _both((s[:, k], s[:, k + 1]), slab)
            found |= inside & ((end - begin) * length > 1e-6)
        return found

    def _facet_blocks(self, facet, a, b):
        p, u, v = facet[0], facet[1] - facet[0], facet[2] - facet[0]
        way, normal = b - a, np.cross(u, v)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = ((p - a) @ normal) / (way @ normal)
        at = a + np.nan_to_num(s)[:, None] * way - p
        size = normal @ normal
        f, g = np.cross(at, v) @ normal / size, np.cross(u, at) @ normal / size
        far = s * np.linalg.norm(way, axis=1)
        return (far > 1e-5) & (s < 1) & (f > 1e-9) & (g > 1e-9) & (f + g < 1 - 1e-9)


def in_ring(places, ring):
    """Return which places (n, 2) lie in a ring (k, 2), by crossings."""
    inside = np.zeros(len(places), dtype=bool)
    x, y = places.T
    for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return inside


def _both(one, other):
    return np.maximum(one[0], other[0]), np.minimum(one[1], other[1])


def _between(a, way, low, high):
    """Return from where to where lines (n, d) are between a least and a greatest corner (d,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (low - a) / way, (high - a) / way
    begin, end = np.minimum(one, other), np.maximum(one, other)
    still = way == 0
    out = still & ((a < low) | (a > high))
    begin = np.where(still, np.where(out, np.inf, -np.inf), begin)
    end = np.where(still, np.where(out, -np.inf, np.inf), end)
    return begin.max(axis=1), end.min(axis=1)


def _in_circle(a, way, radius):
    """Return from where to where lines (n, d) are in a circle or a sphere about the origin."""
    q, h = (way**2).sum(axis=1), (a * way).sum(axis=1)
    c = (a**2).sum(axis=1) - radius**2
    root = h**2 - q * c
    with np.errstate(divide="ignore", invalid="ignore"):
        begin, end = (-h - np.sqrt(np.maximum(root, 0))) / q, (-h + np.sqrt(np.maximum(root, 0))) / q
    still, out = q == 0, root <= 0
    begin = np.where(still, np.where(c < 0, -np.inf, np.inf), np.where(out, np.inf, begin))
    end = np.where(still, np.where(c < 0, np.inf, -np.inf), np.where(out, -np.inf, end))
    return begin, end


@dataclass(frozen=True)
class Cameras:
    """Photos, and by how much they may be off: `attitude` degrees, `level` (n,) and `upright` (n,) metres."""

    position: np.ndarray
    frame: np.ndarray
    half: tuple[float, float]
    most: float
    attitude: float
    level: np.ndarray
    upright: np.ndarray

    @classmethod
    def of(cls, survey, photos, errors):
        most = np.inf if survey.gsd is None else survey.gsd / survey.camera.pixel
        level, upright = (
            np.array([getattr(errors[k], name) for k in photos.uav]) for name in ("horizontal", "vertical")
        )
        (w, h), f = survey.camera.sensor, survey.camera.focal
        half = (h / f / 2, w / f / 2) if survey.camera.portrait else (w / f / 2, h / f / 2)
        frame = axes_of(photos.heading, photos.pitch, photos.roll)
        return cls(photos.position, frame, half, most, survey.camera.attitude_error, level, upright)

    def stricter(self, attitude, depth, metres=0.0):
        """Return them with more errors: degrees, share of the depth, metres."""
        return replace(
            self,
            attitude=self.attitude + attitude,
            most=self.most * (1 - depth),
            level=self.level + metres,
            upright=self.upright + metres,
        )

    def worlds(self, places, photo, random, rng):
        """Return positions and frames (m, k, 3), (m, k, 3, 3) in which photos (m,) may see places (m, 3) worst.

        One is nominal; four turn and move a side of the picture towards the place; one turns and moves the camera so
        that the place is deepest; two move it down and away, and aside; the others are random.
        """
        c, frame, e = self.position[photo], self.frame[photo], np.radians(self.attitude)
        level, upright = self.level[photo], self.upright[photo]
        q = places - c
        turns, moves = [np.zeros_like(q)], [np.zeros_like(q)]

        def rim(direction):
            flat = np.linalg.norm(direction[:, :2], axis=1, keepdims=True)
            move = np.zeros_like(direction)
            move[:, :2] = direction[:, :2] / np.maximum(flat, 1e-12) * level[:, None]
            move[:, 2] = np.sign(direction[:, 2]) * upright
            return move

        def about(one, other):  # the turn that carries one vector towards another
            axis = np.cross(one, other)
            return axis / np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-12) * e

        right, ahead, top = np.moveaxis(frame, 1, 0)
        for side, half in ((right, self.half[0]), (-right, self.half[0]), (top, self.half[1]), (-top, self.half[1])):
            inward = (half * ahead + side) / np.hypot(half, 1)
            turns.append(about(inward, -q))
            moves.append(rim(inward))
        turns.append(about(ahead, q))
        moves.append(rim(-ahead))
        aside = np.cross(q, [0.0, 0.0, 1.0])
        for direction in (q * [1, 1, 0], aside * rng.choice([-1, 1], (len(q), 1))):
            turns.append(np.zeros_like(q))
            moves.append(rim(np.column_stack([direction[:, :2], -np.ones(len(q))])))
        for k in range(random):
            axis, move = rng.normal(size=(2, *q.shape))
            axis /= np.linalg.norm(axis, axis=1, keepdims=True)
            full = k % 2 == 0
            turns.append(axis * e * (1.0 if full else rng.uniform(0, 1, (len(q), 1))))
            moves.append(rim(move) * (1.0 if full else rng.uniform(0, 1, (len(q), 1))))
        turn, move = np.stack(turns, axis=1), np.stack(moves, axis=1)
        angle = np.linalg.norm(turn, axis=2)
        axis = turn / np.maximum(angle, 1e-12)[..., None]
        return c[:, None] + move, turned(frame[:, None], axis[:, :, None], angle[:, :, None] + np.zeros(3))


def seen(caster, cameras, places, normals=None, random=8, seed=0, most=400_000):
    """Return how often places (n, 3) are certain to be seen, and how deep at most: (n, photos) True, and metres.

    A photo counts that shows a place in all of its worlds; the depth is the greatest of them.
    """
    rng = np.random.default_rng(seed)
    count, n = len(cameras.position), len(places)
    sure, depth = np.zeros((n, count), dtype=bool), np.full((n, count), np.inf)
    k, photo = (grid.ravel() for grid in np.meshgrid(np.arange(n), np.arange(count), indexing="ij"))
    shown = in_picture(cameras, places[k], cameras.position[photo], cameras.frame[photo])[0]
    k, photo = k[shown], photo[shown]
    step = max(most // (random + 8), 1)
    for begin in range(0, len(k), step):
        i, p = k[begin : begin + step], photo[begin : begin + step]
        position, frame = cameras.worlds(places[i], p, random, rng)
        shown, deep = in_picture(cameras, places[i][:, None], position, frame)
        if normals is not None:
            way = position - places[i][:, None]
            flat = (way * normals[i][:, None]).sum(axis=2) / np.maximum(np.linalg.norm(way, axis=2), 1e-12)
            shown &= flat >= np.cos(np.radians(75.0)) - (caster.slack > 0) * 1e-9
        good = shown.all(axis=1)
        i, p, position, deep = i[good], p[good], position[good], deep[good].max(axis=1)
        rays = np.repeat(places[i], position.shape[1], axis=0)
        free = ~caster.blocked(rays, position.reshape(-1, 3)).reshape(position.shape[:2]).any(axis=1)
        sure[i[free], p[free]], depth[i[free], p[free]] = True, deep[free]
    return sure, depth


def in_picture(cameras, places, position, frame):
    """Return whether places (..., 3) lie in pictures, no deeper than asked, and their depths."""
    q = places - position
    right, ahead, top = (np.einsum("...k,...k->...", frame[..., a, :], q) for a in range(3))
    slack = 1e-6 + 1e-6 * np.abs(ahead)
    inside = (np.abs(right) <= cameras.half[0] * ahead + slack) & (np.abs(top) <= cameras.half[1] * ahead + slack)
    return inside & (ahead > 0) & (ahead <= cameras.most * (1 + 2e-6)), ahead
