"""What an observation holds beside movers, checked before anything is changed: states, targets, and what stands.

Obstacles that are reported anew, a little differently each time, as one that holds all that was reported.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from skyverse._typing import Floats
from skyverse.errors import InputError, require_whole, shown
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario, Target
from skyverse.model.shapes import Box, Cylinder, Shape, Sphere
from skyverse.model.uav import UAV, TrackingError
from skyverse.model.wrong_values import complaint
from skyverse.space.world import World

MAX_DISTANCE = 1e6
"""Metres from the zero of the frame along each axis, beyond which no UAV can be."""
MAX_SPEED = 1e3
"""M/s along each axis: no UAV is faster."""
OFF_COURSE = 0.01
"""Metres beyond its tracking error from where it should be, at which a UAV counts as off its course."""
MAX_OBSTACLES, MAX_ZONES = 10_000, 1_000
"""How many obstacles and zones there may be with those that are seen."""


def checked_states(given: Mapping[int, tuple[ArrayLike, ArrayLike]], count: int) -> dict[int, Floats]:
    """Return the states (3, 3) of UAVs, without acceleration, or raise `InputError`."""
    states = {}
    _require_indices(given, "states", count)
    for uav, known in given.items():
        try:
            state = np.array([*known, np.zeros(3)], dtype=np.float64)
        except (TypeError, ValueError):
            state = np.full(1, np.nan)
        if state.shape != (3, 3) or not np.isfinite(state).all():
            raise InputError("expected a position and a velocity, three finite numbers each", field=f"states[{uav}]")
        for row, most, unit in ((state[0], MAX_DISTANCE, "m"), (state[1], MAX_SPEED, "m/s")):
            if np.abs(row).max() > most:
                raise InputError(f"expected at most {most:g} {unit} along each axis", field=f"states[{uav}]")
        states[uav] = state
    return states


def _require_indices(given: object, field: str, count: int) -> None:
    """Raise `InputError` if what is given for UAVs is not a mapping from their indices."""
    if not isinstance(given, Mapping):
        raise InputError(f"expected a mapping from indices of UAVs, found {shown(given)}", field=field)
    for uav in given:
        require_whole(uav, field, 0, count - 1)


def with_seen(
    before: Scenario,
    entered: tuple[Shape, ...],
    obstacles: Sequence[Shape],
    zones: Sequence[Shape],
    places: Sequence[Floats],
) -> tuple[Scenario, tuple[Shape, ...]]:
    """Return a scenario with more obstacles and zones, and those that were entered, or raise `InputError`.

    Parameters
    ----------
    before
        What was known to stand still, apart from the following.
    entered
        Obstacles to which a UAV was too near when they were seen; it has to leave them first.
    obstacles, zones
        That were seen.
    places
        (3,) metres each: where the UAVs are.
    """
    known_already = (*before.obstacles, *entered)
    obstacles = [one for one in obstacles if one not in known_already]
    zones = [one for one in zones if one not in before.zones]
    if not obstacles and not zones and not entered:
        return before, entered
    whole = _with_more(before, obstacles, zones)
    kept, new = merged(known_already, whole.obstacles[len(before.obstacles) :])
    stay = {id(one) for one in kept}
    standing = tuple(one for one in before.obstacles if id(one) in stay)
    added = (*(one for one in entered if id(one) in stay), *new)
    for field, count, most in (
        ("obstacles", len(standing) + len(added), max(MAX_OBSTACLES, len(before.obstacles))),
        ("zones", len(whole.zones), max(MAX_ZONES, len(before.zones))),
    ):
        if count > most:
            raise InputError(f"expected at most {most:,} with those that are known, found {count:,}", field=field)
    entered = tuple(one for one in added if any(_is_too_near(before, one, *both) for both in enumerate(places)))
    if len(entered) == len(added) and standing == before.obstacles and not zones:
        return before, entered
    left = (one for one in added if one not in entered)
    return derived(whole, obstacles=(*standing, *left)), entered


def _with_more(scenario: Scenario, obstacles: Sequence[Shape], zones: Sequence[Shape]) -> Scenario:
    more = {"obstacles": (*scenario.obstacles, *obstacles), "zones": (*scenario.zones, *zones)}
    try:
        return Scenario.model_validate({**dict(scenario), **more})
    except ValidationError as error:
        first = error.errors()[0]
        kind, *number = first["loc"][:2]
        place = ".".join(str(part) for part in ("", *first["loc"][3:]))
        before = len(scenario.obstacles if kind == "obstacles" else scenario.zones)
        which = f"[{number[0] - before}]" if number and isinstance(number[0], int) else ""
        raise InputError(complaint(first), field=f"{kind}{which}{place}") from None


def checked_targets(given: Mapping[int, ArrayLike], uavs: Sequence[UAV]) -> dict[int, Target]:
    """Return other targets of UAVs, given as places (3,), metres, or raise `InputError`."""
    targets = {}
    _require_indices(given, "targets", len(uavs))
    for uav, place in given.items():
        try:
            targets[uav] = Target.model_validate({"name": f"target of {uavs[uav].name}", "position": place})
        except ValidationError as error:
            raise InputError(complaint(error.errors()[0]), field=f"targets[{uav}]") from None
    return targets


def with_targets(
    scenario: Scenario, assignment: Sequence[int | None], given: Mapping[int, Target]
) -> tuple[Scenario, tuple[int | None, ...]]:
    """Return a scenario and an assignment in which UAVs, by their indices, have other targets in place of their own."""
    targets, assigned = list(scenario.targets), list(assignment)
    for uav, target in given.items():
        number = assigned[uav]
        if number is None:
            assigned[uav] = len(targets)
            targets.append(target)
        else:
            targets[number] = derived(target, name=targets[number].name)
    if not given:
        return scenario, tuple(assigned)
    return derived(scenario, targets=tuple(targets)), tuple(assigned)


def _is_too_near(scenario: Scenario, obstacle: Shape, uav: int, place: Floats) -> bool:
    """Tell whether a place (3,) is nearer to an obstacle than a UAV must keep from it."""
    bare = {"obstacles": (obstacle,), "zones": (), "terrain": None, "movers": ()}
    return not World(derived(scenario, **bare), scenario.uavs[uav].tracking_error).free(place)[0]


def strays(state: Floats, course: Floats, error: TrackingError, lead: float) -> bool:
    """Tell whether a state is off a course, both (3, 3), by more than a tracking error and a centimetre.

    So is one whose velocity leads that far off within `lead` seconds.
    """
    off = state - course
    return any(
        np.hypot(x, y) > error.horizontal + OFF_COURSE or abs(z) > error.vertical + OFF_COURSE
        for x, y, z in (off[0], off[0] + lead * off[1])
    )


class Fix(NamedTuple):
    """Where a UAV was found by the newest of its states.

    Attributes
    ----------
    t, state
        The instant of the state, seconds, and the state, (3, 3), whose acceleration is 0.
    since
        The instant at which that, or an earlier state, was told and the UAV went on from where it was found.
    flies
        Whether it can fly on as it was found.
    """

    t: float = -math.inf
    state: Floats = np.zeros((3, 3))
    since: float = -math.inf
    flies: bool = True

    def at(self, t: float) -> Floats:
        """Return the state in which it is at a later instant, (3, 3), as long as it keeps its velocity."""
        return self.state + (t - self.t) * np.vstack([self.state[1:], np.zeros(3)])

    def doubt(self, uav: UAV, lead: float) -> str:
        """Return why nothing is proven of what it flies, in words that follow "it"; empty if something may be.

        A state that is told late is carried on to when it is told, but the UAV may accelerate meanwhile. That counts as
        being off its course counts: by its tracking error and a centimetre, also as its velocity leads within the lead.
        """
        if not self.flies:
            return "was found at a speed at which it cannot fly on"
        late, error = self.since - self.t, (uav.tracking_error.horizontal, uav.tracking_error.vertical)
        if late > 0.0 and uav.max_acceleration * late * (0.5 * late + lead) > min(error) + OFF_COURSE:
            return f"was found off its course, but that was told {late:.2g} s late, and it may be farther off by now"
        return ""


SAME = 0.05
"""Metres by which no number of two reports of one obstacle differs by more."""
_MEASURES: dict[type[Shape], tuple[str, ...]] = {
    Box: ("min", "max"),
    Cylinder: ("centre", "radius", "low", "high"),
    Sphere: ("centre", "radius"),
}


def merged(known: Sequence[Shape], seen: Sequence[Shape]) -> tuple[list[Shape], list[Shape]]:
    """Return the known obstacles that stay as they are, and those that are new, or take the place of known ones."""
    kept, new = list(known), list[Shape]()
    for one in seen:
        same = ((old, around(old, one)) for old in (*kept, *new))
        old, both = next(((old, both) for old, both in same if both is not None), (None, one))
        if both == old:
            continue
        if old in kept:
            kept.remove(old)
        elif old is not None:
            new.remove(old)
        new.append(both)
    return kept, new


def around(known: Shape, seen: Shape) -> Shape | None:
    """Return what holds both of two obstacles if they are so alike that they count as one, else ``None``."""
    measures = _MEASURES.get(type(seen), ())
    if type(known) is not type(seen) or not measures:
        return None
    before, after = _numbers(known, measures), _numbers(seen, measures)
    if np.abs(after - before).max() > SAME:
        return None
    if derived(known, **{name: getattr(seen, name) for name in measures}) != seen:
        return None  # another name, kind or meaning
    low, high = np.minimum(before, after), np.maximum(before, after)
    if isinstance(known, Box):
        return derived(known, min=tuple(low[:3].tolist()), max=tuple(high[3:].tolist()))
    size = 2 if isinstance(known, Cylinder) else 3
    off = math.dist(after[:size], before[:size])
    more = {"radius": max(float(before[size]), float(after[size]) + off)}
    if isinstance(known, Cylinder):
        more |= {"low": float(low[3]), "high": float(high[4])}
    return derived(known, **more)


def _numbers(shape: Shape, measures: Sequence[str]) -> Floats:
    """Return all numbers of a shape, metres."""
    return np.concatenate([np.atleast_1d(np.array(getattr(shape, name), dtype=np.float64)) for name in measures])
