"""Judges whether a curve leads through a seam: between grown shapes that touch or leave less than a micrometre.

Grown shapes may be touched from outside. So a curve is judged by a second curve beside it: one that is nowhere farther
from it than `SEAM_SEARCH`, and that keeps half a micrometre, `HALF_SEAM`, from all grown shapes and from the bounds.
Where there is such a curve, nothing is squeezed through a seam; in a seam there is no space for it.

The curve beside is made of parts of the curve itself, each moved by one small step. Wherever the step changes from one
part to the next, the straight line between the two moved places must keep the same distance. A part that cannot be
moved is cut in two, until a place is found from which no step leads away. Then `is_sealed` is asked for a proof that
there is no such curve at all; where it has none, nothing is decided.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.referee.judgement import CEILING_NUMBER, GROUND_NUMBER, obstacle_text, position_text
from skyverse.referee.overlaps import blocks
from skyverse.referee.sealed import is_sealed
from skyverse.referee.seam_parts import WIDENED, CurveParts, MovableParts, NearShapes, shapes_near
from skyverse.referee.subdivision import MAX_DEPTH, MAX_UNDECIDED_PARTS
from skyverse.referee.tolerances import HALF_SEAM, SEAM_PART, SEAM_SEARCH
from skyverse.referee.world import RefereeWorld

BOUNDS_NUMBER = -3
"""The number that stands for the bounds among the numbers of obstacles."""
MORE_HALVINGS = 6
"""How often parts are still cut when rounding leaves a place undecided: another place may be certain."""
EVALUATIONS_AT_ONCE = 2**18
"""Depths computed in one call of NumPy, which bounds the memory."""


@dataclass(frozen=True, eq=False)
class Seam:
    """A place where a curve leads through a seam, or where that could not be decided.

    Attributes
    ----------
    decided
        Whether the curve certainly leads through a seam there.
    obstacles
        The numbers of the obstacles that leave no space, also `GROUND_NUMBER`, `CEILING_NUMBER` and
        `BOUNDS_NUMBER`.
    piece, share
        The index of the piece, and how far along it the place is, 0 to 1.
    position
        (3,) metres.
    """

    decided: bool
    obstacles: tuple[int, ...]
    piece: int
    share: float
    position: Floats

    def sentence(self, scenario: Scenario, subject: str, where: str) -> str:
        """Say that `subject` leads through the seam at the place that the words `where` tell."""
        there = f"{where}, position {position_text(self.position)}"
        names = [_named(scenario, number) for number in self.obstacles]
        if not self.decided:
            way = f"through a gap in {names[0]}" if names else "through a gap"
            way = f"between {' and '.join(names)}" if len(names) > 1 else way
            return f"Whether {subject} leads {way} could not be decided {there}."
        if len(names) < 2:
            gap = f"a gap in {names[0]}" if names else "a gap"
            return f"{subject} passes through {gap} that leaves less than a micrometre {there}."
        together = f"{', '.join(names[:-1])} and {names[-1]}"
        return f"{subject} passes between {together}, which leave less than a micrometre {there}."


def _named(scenario: Scenario, number: int) -> str:
    """Name an obstacle, the ground or the bounds."""
    if number == BOUNDS_NUMBER:
        return "the bounds"
    if number == CEILING_NUMBER:
        return "the ceiling above ground"
    return "the ground" if number == GROUND_NUMBER else obstacle_text(scenario, number)


def _all_steps() -> Floats:
    """Return the steps by which parts are moved, (k, 3) metres; the first one is none.

    There are 50 directions: up, down, and 16 all around, each of them level, half up and half down.
    """
    turn = np.radians(np.arange(0, 360, 22.5))
    around = [np.cos(turn), np.sin(turn)]
    half = np.sqrt(0.5)
    rings = [np.column_stack([half * around[0], half * around[1], np.full(16, up)]) for up in (half, -half)]
    ways = np.concatenate([[(0, 0, 1), (0, 0, -1)], np.column_stack([*around, np.zeros(16)]), *rings])
    return np.concatenate([np.zeros((1, 3)), *(HALF_SEAM * size * ways for size in (2.5, 5.0, 1.2, 9.9))])


STEPS = _all_steps()


def find_seam(world: RefereeWorld, b: Floats, error: Floats) -> Seam | None:
    """Return a seam that a curve leads through, or a place where that could not be decided; ``None`` if there is none.

    Parameters
    ----------
    world
        What to keep clear of.
    b, error
        (n, degree + 1, 3) coefficients of consecutive pieces that are not known to leave the bounds or to come too
        close, metres, and (n,) bounds on their errors.
    """
    seam = _sought(world, b, error)
    if seam is None or not seam.decided or is_sealed(world, b, error, seam.piece, seam.share):
        return seam
    return replace(seam, decided=False)


def _sought(world: RefereeWorld, b: Floats, error: Floats) -> Seam | None:
    """Return a place past which no steps lead, decided if rounding does not matter, or ``None`` if there is none."""
    near = tuple(shapes_near(kind, b, error) for kind in (world.boxes, *world.others))
    parts = CurveParts(b, np.arange(len(b)), np.zeros(len(b)), np.ones(len(b)), near)
    found = MovableParts(parts.of(np.arange(0)), np.zeros((0, len(STEPS)), dtype=np.bool_))
    doubt, more = None, MORE_HALVINGS
    for _ in range(MAX_DEPTH + 1):
        parts, movable = _without_movable(world, parts)
        found = found.with_others(movable)
        if not len(parts.b):
            return _seam_along(world, found)
        for end in (0, -1):
            seam = _sealed_place(world, parts.points(end))
            if seam is not None and seam.decided:
                return seam
            doubt = doubt or seam
        more -= doubt is not None
        if more < 0 or len(parts.b) > MAX_UNDECIDED_PARTS or parts.extent.min() < SEAM_PART:
            break
        parts = parts.halved()
    return doubt or _seam_at(world, parts.points(0), 0, decided=False)


def _without_movable(world: RefereeWorld, parts: CurveParts) -> tuple[CurveParts, MovableParts]:
    """Return the parts that must be cut, and those near shapes that some step moves clear of everything.

    Parts with no shape near them are in neither: they can be moved away from the bounds, and in all ways.
    """
    deepest, near = np.full(len(parts.b), -np.inf), []
    for one in parts.near:
        depth = one.depth(parts.b)
        np.maximum.at(deepest, one.part, depth)
        near.append(one.kept(~(depth <= -SEAM_SEARCH * one.kind.steepness)))
    parts = CurveParts(parts.b, parts.piece, parts.begin, parts.width, tuple(near))
    alone = np.ones(len(parts.b), dtype=np.bool_)
    for one in near:
        alone[one.part] = False
    if (world.high - world.low).min() > 2 * SEAM_SEARCH:
        parts, deepest = parts.of(np.flatnonzero(~alone)), deepest[~alone]
    allowed = np.zeros((len(parts.b), len(STEPS)), dtype=np.bool_)
    allowed[:, 0] = (deepest <= 0) & _in_bounds(world, parts.b)
    steepest = max((one.kind.steepness for one in near if len(one.part)), default=1.0)
    doubtful = np.flatnonzero(~allowed[:, 0] & (deepest <= SEAM_SEARCH * steepest))  # no step leads out from deeper
    allowed[doubtful] = _allowed(world, parts.of(doubtful))
    movable = allowed.any(axis=1)
    return parts.of(np.flatnonzero(~movable)), MovableParts(parts.of(np.flatnonzero(movable)), allowed[movable])


def _in_bounds(world: RefereeWorld, b: Floats) -> NDArray[np.bool_]:
    """Tell which parts (n, degree + 1, 3) keep half a seam from the bounds, (n,)."""
    low, high = world.low + HALF_SEAM, world.high - HALF_SEAM
    return ((b.min(axis=1) >= low) & (b.max(axis=1) <= high)).all(axis=1)


def _allowed(world: RefereeWorld, parts: CurveParts, sure: float = 1.0) -> NDArray[np.bool_]:
    """Tell which of `STEPS` move which parts clear of all shapes and bounds, (n, k).

    With -1 for `sure`, errors are taken in favour of the steps.
    """
    n, pairs = len(parts.b), sum(len(near.part) for near in parts.near)
    columns = []
    for some in (STEPS[block] for block in blocks(len(STEPS), EVALUATIONS_AT_ONCE, n + pairs)):
        k = len(some)
        moved = (parts.b[:, None] + some[:, None, :]).reshape(n * k, *parts.b.shape[1:])
        clear = _in_bounds(world, moved)
        for near in parts.near:
            part = (near.part[:, None] * k + np.arange(k)).ravel()
            repeated = NearShapes(near.kind, part, np.repeat(near.shape, k), sure * np.repeat(near.error, k))
            clear &= repeated.deepest(moved) <= 0
            thin = repeated.kept(near.kind.thin[repeated.shape])
            if len(thin.part):  # no step leads through a thin shape, as it is let pass, to its far side
                swept = np.concatenate([np.repeat(parts.b, k, axis=0), moved], axis=1)
                clear &= thin.deepest(swept) <= WIDENED + 2 * thin.error.max()
        columns.append(clear.reshape(n, k))
    return np.concatenate(columns, axis=1)


def _sealed_place(world: RefereeWorld, points: CurveParts) -> Seam | None:
    """Return a place from which no step leads away, or ``None``; where only rounding is left, it is not decided.

    No part that holds such a place can be moved, so that nothing is gained by cutting it.
    """
    deepest = np.full(len(points.b), -np.inf)
    for near in points.near:
        deepest = np.maximum(deepest, near.deepest(points.b))
    doubtful = np.flatnonzero(~((deepest <= 0) & _in_bounds(world, points.b)))
    sealed = doubtful[~_allowed(world, points.of(doubtful)).any(axis=1)]
    if not len(sealed):
        return None
    surely = sealed[~_allowed(world, points.of(sealed), sure=-1.0).any(axis=1)]
    return _seam_at(world, points, int(surely[0] if len(surely) else sealed[0]), decided=bool(len(surely)))


def _seam_along(world: RefereeWorld, movable: MovableParts) -> Seam | None:
    """Return where parts that can be moved one by one cannot be moved as one curve, or ``None``."""
    for _ in range(2 * MAX_DEPTH):
        movable = movable.in_order()
        k = _first_break(world, movable)
        if k is None:
            return None
        beside = np.arange(max(k - 1, 0), k + 1)
        long = beside[movable.parts.extent[beside] >= SEAM_PART]
        if not len(long):
            return _seam_at(world, movable.parts.points(0), k, decided=True)
        halves = movable.parts.of(long).halved()
        others = np.setdiff1d(np.arange(len(movable.parts.b)), long)
        rest = MovableParts(movable.parts.of(others), movable.allowed[others])
        movable = rest.with_others(MovableParts(halves, _allowed(world, halves)))
    return _seam_at(world, movable.parts.points(0), 0, decided=False)


def _first_break(world: RefereeWorld, movable: MovableParts) -> int | None:
    """Return the first part to which no step leads from the steps of the parts before it, or ``None``."""
    parts = movable.parts
    ends, begins = parts.piece + parts.begin + parts.width, parts.piece + parts.begin
    follows = np.r_[False, ends[:-1] == begins[1:]][: len(parts.b)]
    reached = np.zeros(0, dtype=np.intp)
    for k in range(len(parts.b)):
        steps = np.flatnonzero(movable.allowed[k])
        if follows[k]:
            same = np.intersect1d(reached, steps)
            if len(same) < len(steps):
                linked = _linked(world, parts, k, same[:1] if len(same) else reached, steps)
                steps = np.union1d(same, linked).astype(np.intp)
        if not len(steps):
            return k
        reached = steps
    return None


def _linked(world: RefereeWorld, parts: CurveParts, k: int, before: Indices, steps: Indices) -> Indices:
    """Return those steps of part k to which a clear straight line leads from one of the steps before, at its begin."""
    one, other = np.repeat(before, len(steps)), np.tile(steps, len(before))
    place = parts.b[k, 0]
    lines = np.stack([place + STEPS[one], place + STEPS[other]], axis=1)
    clear = _in_bounds(world, lines)
    for near in parts.of(np.array([k])).near:
        clear &= _repeated(near, len(lines)).deepest(lines) <= 0
    return np.unique(other[clear])


def _repeated(near: NearShapes, times: int) -> NearShapes:
    """Return what is near one part as what is near so many parts."""
    part = np.repeat(np.arange(times), len(near.part))
    return NearShapes(near.kind, part, np.tile(near.shape, times), np.tile(near.error, times))


def _seam_at(world: RefereeWorld, points: CurveParts, k: int, *, decided: bool) -> Seam:
    """Return the seam at place k, with all obstacles that are near enough to leave too little space.

    Where the curve is only held up by a change of step, they may be as far away as a step is long.
    """
    here = points.of(np.array([k]))
    numbers: set[int] = set() if _in_bounds(world, here.b)[0] else {BOUNDS_NUMBER}
    for reach in (2 * HALF_SEAM, SEAM_SEARCH):
        for near in here.near if len(numbers) < 2 else ():
            numbers.update(near.kind.obstacle[near.shape[near.depth(here.b) > -reach]].tolist())
    return Seam(decided, tuple(sorted(numbers)), int(here.piece[0]), float(here.begin[0]), here.b[0, 0])
