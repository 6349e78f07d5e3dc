"""What was seen of a mover at an instant, and what is known of how it may move on.

The sightings of movers, where they may be from now on, and which of them are forgotten.

A mover whose acceleration is at most a is seen at p0 and, d seconds later, at p1, each within an error e of where it
is. So its velocity at the second sighting is within 2 e / d + a d / 2 of (p1 - p0) / d, and t seconds later it is
within e + v t + a t^2 / 2 of p1 + t (p1 - p0) / d, where v is that first bound.
"""

import math
from bisect import insort
from collections.abc import Mapping, Sequence
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator

from skyverse._typing import Floats
from skyverse.errors import InputError, did_you_mean, shown
from skyverse.model.mover import Doubt, Mover, MoverShape
from skyverse.model.mover_motions import WaypointMotion
from skyverse.model.quantities import Amount, Limit, Model, Number, listed
from skyverse.model.wrong_values import complaint

MAX_SEEN = 1e6
"""Metres, m/s or m/s^2: nothing that is seen is farther off, larger or faster, so that squares of it mean something."""
MIN_SEEN = 1e-6
"""Metres: nothing that is seen is smaller."""


def _of_real_size(shape: MoverShape) -> MoverShape:
    for name, value in shape.model_dump(
        exclude_none=True, exclude={"shape", "name", "kind", "solid", "closed_above"}
    ).items():
        sizes = np.abs(np.atleast_1d(value))
        if sizes.max() > MAX_SEEN:
            raise ValueError(f"{name} must be at most {MAX_SEEN:g} m")
        if np.ndim(value) == 0 and name not in ("low", "high") and sizes.min() < MIN_SEEN:
            raise ValueError(f"{name} must be at least {MIN_SEEN:g} m")
    return shape


Component = Annotated[Number, Field(ge=-MAX_SEEN, le=MAX_SEEN)]
Vector = Annotated[tuple[Component, Component, Component], BeforeValidator(listed)]


class Sighting(Model):
    """What was seen of a mover at an instant, and what is known of how it may move on.

    Attributes
    ----------
    name
        Tells movers apart: sightings of one mover have one name.
    shape
        In a frame whose zero is the moving point and whose axes do not turn.
    position
        x, y, z of the moving point, metres.
    error
        Metres by which that may be off.
    velocity
        x, y, z in m/s; ``None`` where it was not measured, and is estimated from earlier sightings.
    velocity_error
        M/s by which the velocity may be off, if it is given.
    top_speed
        M/s that the mover never exceeds.
    max_acceleration
        M/s^2 that it never exceeds; ``None`` where that is not known, as of a mover that may turn back in an instant.
    """

    name: Annotated[str, Field(min_length=1)]
    shape: Annotated[MoverShape, AfterValidator(_of_real_size)]
    position: Vector
    error: Amount = 0.0
    velocity: Vector | None = None
    velocity_error: Amount = 0.0
    top_speed: Limit
    max_acceleration: Amount | None = None

    @model_validator(mode="after")
    def _within_top_speed(self) -> Self:
        if self.velocity is not None and math.hypot(*self.velocity) > self.top_speed + self.velocity_error:
            seen = f"{math.hypot(*self.velocity):g} m/s"
            raise ValueError(f"velocity must not be above top_speed and velocity_error together, but it is {seen}")
        return self


def _checked(given: Sighting | Mapping[str, object], number: int) -> Sighting:
    """Return the sighting of a mover that was given as the one of some number, or raise `InputError`."""
    if isinstance(given, Sighting):
        return given
    try:
        return Sighting.model_validate(given)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in ("", *first["loc"]))
        raise InputError(complaint(first), field=f"movers[{number}]{place}") from None


MAX_SIGHTINGS = 1000
"""Movers in one observation at most."""
MAX_KEPT = 64
"""Sightings of one mover that are kept."""
MAX_TRACKS = 1000
"""Movers that are kept in mind at most."""


def checked_sightings(movers: Sequence[Sighting | Mapping[str, object]]) -> list[Sighting]:
    """Return the sightings of movers, no two of which have one name, or raise `InputError`."""
    if len(movers) > MAX_SIGHTINGS:
        raise InputError(f"expected at most {MAX_SIGHTINGS:,}, found {len(movers):,}", field="movers")
    sightings = [_checked(one, k) for k, one in enumerate(movers)]
    names = [one.name for one in sightings]
    for k, name in enumerate(names):
        if name in names[:k]:
            said = f"expected a name for each mover, but {name!r} is that of movers[{names.index(name)}] too"
            raise InputError(said, field=f"movers[{k}].name")
    return sightings


class Track:
    """The sightings of one mover, in the order of their instants; none if it is gone."""

    def __init__(self) -> None:
        self._seen: list[tuple[float, Sighting]] = []

    def __len__(self) -> int:
        return len(self._seen)

    @property
    def last(self) -> float:
        """The instant of the last sighting, seconds."""
        return self._seen[-1][0]

    def add(self, time: float, sighting: Sighting) -> None:
        """Take in a sighting, also one that comes late; of two at one instant the more exact one is kept."""
        if any(t == time and known.error <= sighting.error for t, known in self._seen):
            return
        self._seen = [one for one in self._seen if one[0] != time]
        insort(self._seen, (time, sighting), key=lambda one: one[0])
        self._seen = self._seen[-MAX_KEPT:]

    def drop(self, before: float) -> None:
        """Forget what was seen before an instant."""
        self._seen = [one for one in self._seen if one[0] >= before]

    def predicted(self, until: float) -> Mover:
        """Return the mover as it may move from its last sighting on, with a doubt that holds it up to an instant."""
        time, seen = self._seen[-1]
        position, ahead = np.array(seen.position), max(until - time, 1e-3)
        velocity, off = self._velocity()
        if seen.max_acceleration is None or off >= seen.top_speed:  # what is known of the velocity tells nothing
            motion = WaypointMotion(points=(seen.position,), times=(time,))
            doubt = Doubt(radius=seen.error, growth=seen.top_speed, since=time)
        else:
            motion = WaypointMotion(points=(position, position + ahead * velocity), times=(time, time + ahead))
            doubt = Doubt(
                radius=seen.error,
                growth=off,
                acceleration=seen.max_acceleration,
                since=time,
                top_speed=seen.top_speed,
            )
        return Mover(name=seen.name, shape=seen.shape, motion=motion, doubt=doubt)

    def may_be_anywhere(self, now: float, low: Floats, high: Floats) -> bool:
        """Tell whether the mover may be anywhere in the box between two corners, (3,) metres each, at an instant."""
        mover = self.predicted(now)
        doubt, seen = mover.doubt, self._seen[-1][1]
        reaches = [(mover.at([now])[0], float(doubt.at([now])[0]))]
        if doubt.top_speed is not None:
            reaches.append((np.array(seen.position), doubt.radius + doubt.top_speed * (now - self.last)))
        return all(math.hypot(*np.maximum(at - low, high - at)) <= reach for at, reach in reaches)

    def _velocity(self) -> tuple[Floats, float]:
        """Return the velocity at the last sighting, (3,) m/s, and by how much it may be off."""
        time, seen = self._seen[-1]
        best, least = np.zeros(3), np.inf
        if seen.velocity is not None:
            best, least = np.array(seen.velocity), seen.velocity_error
        if seen.max_acceleration is None:
            return best, least
        for earlier, before in reversed(self._seen[:-1]):
            lapse = time - earlier
            if 0.5 * seen.max_acceleration * lapse >= least:
                break  # what was seen still earlier tells less
            moved = np.array(seen.position) - before.position
            if math.hypot(*moved) > seen.top_speed * lapse + seen.error + before.error:
                break  # it has jumped: what was seen before was something else
            off = (seen.error + before.error) / lapse + 0.5 * seen.max_acceleration * lapse
            if off < least:
                best, least = moved / lapse, off
        return best, float(least)


class Tracks:
    """The movers that were seen, each until it is forgotten.

    A mover stays until its place was seen empty; or until it was not seen for some seconds, and may by then be anywhere
    where UAVs can be by the horizon, so that what is known of it tells nothing. If there are too many, those that were
    not seen for longest are forgotten.

    Parameters
    ----------
    memory
        Seconds for which a mover stays that was not seen again, whatever is known of it.
    """

    def __init__(self, memory: float) -> None:
        self._memory = memory
        self._of: dict[str, Track] = {}
        self._gone: dict[str, float] = {}  # since when; of whoever was only forgotten minus infinity

    def require_seen(self, gone: Sequence[str], sightings: Sequence[Sighting]) -> None:
        """Raise `InputError` for a name of somebody gone who was never seen; whoever was forgotten may be gone too."""
        seen = [*self._of, *self._gone, *(one.name for one in sightings)]
        for number, name in enumerate(gone):
            if name not in seen:
                said = f"expected the name of a mover that was seen, found {shown(name)}{did_you_mean(str(name), seen)}"
                raise InputError(said, field=f"gone[{number}]")

    def add(self, time: float, sightings: Sequence[Sighting]) -> None:
        """Take in what was seen at an instant, which tells nothing of whoever was gone later."""
        for sighting in sightings:
            if time >= self._gone.get(sighting.name, -math.inf):
                self._of.setdefault(sighting.name, Track()).add(time, sighting)

    def leave(self, time: float, gone: Sequence[str]) -> None:
        """Take in the names of movers whose places were seen empty at an instant; who was seen then or later stays."""
        for name in gone:
            self._gone[name] = max(time, self._gone.pop(name, -math.inf))
            if name in self._of:
                self._of[name].drop(time)
        self._of = {name: track for name, track in self._of.items() if len(track)}

    def forget(self, now: float, reached: Sequence[tuple[Floats, Floats]]) -> tuple[str, ...]:
        """Forget movers of which nothing is known any more, and return their names.

        Parameters
        ----------
        now
            Seconds into the mission.
        reached
            The least and the greatest corner, (3,) metres each, of where each UAV can be by the horizon.
        """
        oldest = sorted(self._of, key=lambda name: -self._of[name].last)[MAX_TRACKS:]
        found = tuple(
            name
            for name, track in self._of.items()
            if name in oldest
            or (now - track.last > self._memory and all(track.may_be_anywhere(now, *box) for box in reached))
        )
        for name in found:
            del self._of[name]
            self._gone.setdefault(name, -math.inf)
        self._gone = dict([*self._gone.items()][-MAX_TRACKS:])
        return found

    def predicted(self, until: float) -> tuple[Mover, ...]:
        """Return the movers, with all that they may do up to an instant."""
        return tuple(track.predicted(until) for track in self._of.values())
