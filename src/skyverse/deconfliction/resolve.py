"""One UAV after another finds its place among those placed before it: in which order, and what each may do."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.fleet import Fleet, Others, Place
from skyverse.deconfliction.options import Option
from skyverse.deconfliction.swept_volume_tree import TICK

FACTORS = (1.15, 1.4, 2.0)
"""By how much a multirotor is slowed down along its path."""
MUCH = 0.1
"""The share of its flight time that a UAV comes later before it looks for a way around."""
TRIES = 6
"""Ways around that one UAV tries in its turn."""
AGAIN = 8
"""How often those who found no place go first in another attempt."""
NEAR = 0.5
"""Metres between a path and a place that count as crossing it, where it only matters who goes first."""
FIRST, FEW = 3, 32
"""Orders that are tried before those that follow from them, of so few UAVs; of more it is one."""
ROUNDS = 4
"""Orders that follow, of few UAVs; of many at least three."""


def resolve(fleet: Fleet, own: Sequence[Option], clashing: set[int]) -> list[Place]:
    """Return a place for every UAV; where there is none that is apart from the others it flies as it was, and clashes.

    Squeaky wheel optimization (Joslin, Clements 1999): who came late goes earlier in the next order.

    Parameters
    ----------
    own
        Each UAV's own option.
    clashing
        Those in conflict; the others keep their places unless one of a higher priority needs it.
    """
    best: list[Place] | None = None
    places: list[Place] = []
    order: list[int] = []
    keys = _keys(own)[: FIRST if len(own) <= FEW else 1]
    for tried in range(len(keys) + max(3, ROUNDS * 8 // max(len(own), 8))):
        key = keys[tried] if tried < len(keys) else _sooner(own, order, places)
        places, order = _settled(fleet, own, _ordered(fleet, own, clashing, key))
        if best is None or worth(places) < worth(best):
            best = places
        if fleet.cancelled or worth(places) == _least(own):
            break
    assert best is not None
    return _earlier(fleet, own, best)


def _settled(fleet: Fleet, own: Sequence[Option], order: list[int]) -> tuple[list[Place], list[int]]:
    """Return places by an order, or by one in which those go first who found none, and that order."""
    places = _in_turn(fleet, own, order)
    for _ in range(AGAIN):
        failed = [uav for uav in order if places[uav].clashes]
        if not failed or fleet.cancelled:
            break
        front = set(failed)
        order = failed + [uav for uav in order if uav not in front]
        again = _in_turn(fleet, own, order)
        if worth(again)[0] >= worth(places)[0]:
            break
        places = again
    return places, order


def worth(places: Sequence[Place]) -> tuple[int, float, float]:
    """Return what is to be small: how many clash, makespan, total."""
    ends = [place.arrival for place in places if place.option.target is not None]
    return sum(place.clashes for place in places), round(max(ends, default=0.0), 6), round(sum(ends), 6)


def _least(own: Sequence[Option]) -> tuple[int, float, float]:
    """Return the worth of places that all have as they were."""
    return worth([Place(option, option.trajectory.start) for option in own])


def _ordered(fleet: Fleet, own: Sequence[Option], clashing: set[int], key: Floats) -> list[int]:
    """Return in which order UAVs choose: those that stand still, then by priority; those in no conflict first."""
    uavs = fleet.scenario.uavs
    rank = [(own[u].target is not None, -uavs[u].priority, u in clashing, key[u], u) for u in range(len(own))]
    return [entry[-1] for entry in sorted(rank)]


def _keys(own: Sequence[Option]) -> list[Floats]:
    """Return by what UAVs are ordered at first: the longest flights first; those in nobody's way; the shortest."""
    seconds = np.array([option.seconds for option in own])
    return [-seconds, _crossed(own), seconds]


def _sooner(own: Sequence[Option], order: Sequence[int], places: Sequence[Place]) -> Floats:
    """Return UAVs' positions in an order, less the more the later they came than by themselves."""
    late = np.array([place.arrival - option.trajectory.end for place, option in zip(places, own, strict=True)])
    most = max(float(late.max()), TICK)
    blame = np.where([place.clashes for place in places], 1.0, late / most)
    position = np.empty(len(order))
    position[list(order)] = np.arange(len(order))
    key: Floats = position - len(order) * blame
    return key


def _crossed(own: Sequence[Option]) -> Floats:
    """Return for each UAV on how many paths of others its target lies, less on how many its start does; (n,)."""
    starts, ends = np.array([option.start for option in own]), np.array([option.end for option in own])
    score = np.zeros(len(own))
    for option in own:
        since, until = option.trajectory.start, option.trajectory.end
        path = option.trajectory.at(np.linspace(since, until, 100)).position[:, None]
        for places, sign in ((starts, -1.0), (ends, 1.0)):
            near = (np.abs(path - places).max(axis=2) < NEAR).any(axis=0)
            near[option.uav] = False
            score += sign * near
    return score


def _in_turn(fleet: Fleet, own: Sequence[Option], order: Sequence[int]) -> list[Place]:
    placed: dict[int, Place] = {}
    for uav in order:
        placed[uav] = _choose(fleet, own[uav], list(placed.values()))
    return [placed[uav] for uav in range(len(own))]


def _earlier(fleet: Fleet, own: Sequence[Option], places: list[Place]) -> list[Place]:
    """Let each UAV in turn, the last to arrive first, choose again among all the others."""
    for uav in sorted(range(len(own)), key=lambda u: -places[u].arrival):
        place = places[uav]
        if fleet.cancelled:
            break
        if place.option.target is None or (place.arrival <= own[uav].trajectory.end and not place.clashes):
            continue
        again = _choose(fleet, own[uav], [p for p in places if p is not place])
        if place.clashes > again.clashes or (again.clashes == place.clashes and again.arrival < place.arrival - TICK):
            places[uav] = again
    return places


def _choose(fleet: Fleet, own: Option, placed: Sequence[Place]) -> Place:
    """Return where a UAV arrives first without a clash: by its own path, as it is or later, or by a way around.

    Where it is cancelled, it flies as it was.
    """
    at = own.trajectory.start
    others = fleet.others(own, placed)
    who = fleet.clashes(own, at, 1.0, others)
    if own.target is None or not who.any() or fleet.cancelled:
        return Place(own, at, clashes=bool(who.any()))
    latest = max(place.arrival for place in placed) + TICK
    best = _later(fleet, own, others, latest, None)
    enough = own.seconds * (1.0 + MUCH) + at
    around = own
    for _ in range(2):
        if best is not None and best.arrival <= enough:
            break
        share = fleet.share_of_clash(around, others, who)
        if share is None:
            break
        fewest: tuple[int, Option] | None = None
        until = 2.0 * latest + around.seconds if best is None else best.arrival - TICK
        for arrival, gate in fleet.detours(around, share, others, until)[:TRIES]:
            if best is not None and arrival >= best.arrival:
                break
            option = fleet.led_through(around, gate)
            if option is None:
                continue
            best = _later(fleet, option, others, latest, best)
            if best is None:
                clashing = int(fleet.clashes(option, at, 1.0, others).sum())
                if fewest is None or clashing < fewest[0]:
                    fewest = clashing, option
        if best is not None or fewest is None:
            break
        around = fewest[1]
        who = fleet.clashes(around, at, 1.0, others)
    return Place(own, at, clashes=True) if best is None else best


def _later(fleet: Fleet, option: Option, others: Others, latest: float, best: Place | None) -> Place | None:
    """Return the best place so far, or an earlier arrival by this option, delayed or slowed down or both."""
    fixed = fleet.scenario.uavs[option.uav].fixed_wing is not None
    for scale in (1.0,) if fixed else (1.0, *FACTORS):
        seconds = scale * option.seconds
        until = latest if best is None else min(latest, best.arrival - TICK - seconds)
        if until < option.trajectory.start:
            break
        at = fleet.delay(option, scale, others, until)
        if at is not None:
            best = Place(option, at, scale)
    return best
