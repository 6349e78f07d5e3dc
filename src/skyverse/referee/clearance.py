"""Judges clearance: of curves at every instant, and of straight paths."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.referee.boxes import Boxes, Closest, deepest, near, shut_boxes
from skyverse.referee.curve import Curve
from skyverse.referee.ground import Ground, ground_of
from skyverse.referee.polynomial import Peaks, Polynomials, greatest
from skyverse.referee.prisms import shut_prisms
from skyverse.referee.rounds import shut_cylinders, shut_spheres

FINE = 1e-9
"""How near to the worst instant (metres, or a share of the limit) is near enough."""


class Solids(Protocol):
    """Shapes of one kind, grown by the clearance less the tolerance."""

    @property
    def obstacle(self) -> Indices:
        """(m,) to which obstacle of the scenario each belongs."""

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners (m, 3), (m, 3) of boxes about them."""

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds (n,) on the errors of depths of pieces and their parts, by those of the pieces (n,)."""

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return upper bounds (n,) on how deep parts (n, degree + 1, 3) get inside shapes (n,); below 0 outside.

        Of a single coefficient, a place, it is the depth itself, or below 0.
        """

    def gap(self, position: Floats, which: int) -> float:
        """Return how far a position (3,) is from a shape as given, metres; negative inside."""


class Space(NamedTuple):
    """All that is shut."""

    boxes: Boxes
    others: tuple[Solids, ...]
    ground: Ground | None


def shut_space(scenario: Scenario) -> Space:
    """Return what is shut in a scenario."""
    ground = ground_of(scenario)
    kinds: list[Solids] = [shut_cylinders(scenario), shut_spheres(scenario), shut_prisms(scenario)]
    some = [kind for kind in kinds if len(kind.obstacle)]
    return Space(shut_boxes(scenario), (*some, *([] if ground is None else [ground])), ground)


class Met(NamedTuple):
    """What was found: the bounds, of pieces; where it is deepest, if anywhere; and when, as a share of that piece."""

    peaks: Peaks
    closest: Closest | None


def judge_curve(scenario: Scenario, space: Space, curve: Curve, position: list[Polynomials]) -> Met:
    """Judge the clearance of a curve, given by the polynomials of its place as well."""
    b = np.stack([part.b for part in position], axis=2)
    error = np.max([part.error for part in position], axis=0)

    def at(piece: int, share: float) -> Floats:
        place: Floats = curve.motion(piece, share * float(curve.durations[piece]))[0]
        return place

    return _deepest(scenario, [_judge(kind, b, error, at) for kind in (space.boxes, *space.others)])


def judge_legs(scenario: Scenario, space: Space, starts: Floats, ends: Floats) -> Met:
    """Judge the clearance of segments between (n, 3) starts and ends: pieces of degree 1."""
    b, exact = np.stack([starts, ends], axis=1), np.zeros(len(starts))

    def at(leg: int, share: float) -> Floats:
        place: Floats = starts[leg] + share * (ends[leg] - starts[leg])
        return place

    in_boxes = Met(_peaks([]), deepest(space.boxes, starts, ends))
    return _deepest(scenario, [in_boxes, *(_judge(kind, b, exact, at) for kind in space.others)])


def _judge(kind: Solids, b: Floats, error: Floats, at: Callable[[int, float], Floats]) -> Met:
    """Judge all pieces by all shapes of a kind; `at` evaluates the place of a piece at a share of it directly."""
    wrong = kind.error(b, error)
    near_to = near(b.min(axis=1) - wrong[:, None], b.max(axis=1) + wrong[:, None], *kind.hulls())
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *near_to]).T

    def depth(part: Floats, pair: Indices) -> Floats:
        return kind.depth(part, shape[pair])

    peaks = greatest(b[piece], wrong[piece], 0.0, FINE, depth)
    closest = None
    if peaks.refuted(0.0)[0]:
        pair, share = int(peaks.piece[0]), float(peaks.share[0])
        position, of = at(int(piece[pair]), share), int(shape[pair])
        if kind.depth(position[None, None], np.array([of]))[0] > 0:
            closest = Closest(kind.gap(position, of), int(kind.obstacle[of]), int(piece[pair]), share, position)
    # from pairs back to pieces, for whoever asks where
    stuck = np.where(peaks.stuck >= 0, piece[peaks.stuck] if len(piece) else -1, -1)
    spot = piece[peaks.piece] if len(piece) else peaks.piece
    return Met(peaks._replace(piece=spot, stuck=stuck), closest)


def _deepest(scenario: Scenario, met: list[Met]) -> Met:
    """Return what was found of all kinds: the deepest place of them all."""
    found = [one.closest for one in met if one.closest is not None]
    return Met(
        _peaks([one.peaks for one in met]), max(found, key=lambda closest: closest.depth(scenario), default=None)
    )


def _peaks(each: list[Peaks]) -> Peaks:
    """Return the greatest of all peaks, and the first place that stayed undecided."""
    nothing = Peaks(*(np.array([value]) for value in (-np.inf, 0, 0.0, -1, 0.0, 0)))
    highest = max(each, key=lambda peaks: float(peaks.value[0]), default=nothing)
    stuck = next((peaks for peaks in each if peaks.stuck[0] >= 0), nothing)
    halvings = np.array([sum(int(peaks.halvings[0]) for peaks in each)])
    return highest._replace(stuck=stuck.stuck, stuck_share=stuck.stuck_share, halvings=halvings)
