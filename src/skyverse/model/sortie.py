"""Sorties: the flights of a UAV, each from take-off to landing on one battery, its visits of targets, and strips."""

from dataclasses import dataclass, replace

from skyverse.model.quantities import Real, Whole


@dataclass(frozen=True)
class Visit:
    """A stay at a target.

    Attributes
    ----------
    target
        Its index.
    arrival, departure
        Seconds into the mission between which the UAV does what it came for; it stands still before that where it
        waits, as for a window to open.
    """

    target: Whole
    arrival: Real
    departure: Real


@dataclass(frozen=True)
class Strip:
    """A way along which a UAV takes photos of a survey.

    Attributes
    ----------
    survey
        The index of the survey.
    begin, end
        Seconds into the mission at which the first photo is taken, and the last.
    every
        Metres flown from one photo to the next, seen from above; 0 for a single photo.
    pitch
        Degrees above the horizon at which the camera looks, -90 straight down.
    heading
        Where the camera looks, or the top of a picture that is taken straight down, degrees clockwise from north;
        ``None`` where the UAV flies to.
    """

    survey: Whole
    begin: Real
    end: Real
    every: Real
    pitch: Real = -90.0
    heading: Real | None = None


@dataclass(frozen=True)
class Sortie:
    """One flight of one UAV, from take-off to landing, on one battery.

    Attributes
    ----------
    begin, end
        Seconds into the mission.
    visits
        In their order; none where it flies nowhere but home.
    strips
        Of surveys, in their order.
    """

    begin: Real
    end: Real
    visits: tuple[Visit, ...]
    strips: tuple[Strip, ...] = ()

    def retimed(self, start: float, begin: float, factor: float) -> "Sortie":
        """Return the same sortie of a flight that begins at `begin` in place of `start`, `factor` times as long."""

        def then(t: float) -> float:
            return begin + (t - start) * factor

        visits = tuple(Visit(one.target, then(one.arrival), then(one.departure)) for one in self.visits)
        strips = tuple(replace(one, begin=then(one.begin), end=then(one.end)) for one in self.strips)
        return Sortie(then(self.begin), then(self.end), visits, strips)


@dataclass(frozen=True)
class Unvisited:
    """A target that no UAV visits.

    Attributes
    ----------
    target
        Its index.
    why
        In words, to be put after its name.
    """

    target: Whole
    why: str
