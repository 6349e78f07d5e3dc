"""Sorties: the flights of a UAV, each from take-off to landing on one battery, and its visits of targets."""

from dataclasses import dataclass

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
class Sortie:
    """One flight of one UAV, from take-off to landing, on one battery.

    Attributes
    ----------
    begin, end
        Seconds into the mission.
    visits
        In their order; none where it flies nowhere but home.
    """

    begin: Real
    end: Real
    visits: tuple[Visit, ...]

    def retimed(self, start: float, begin: float, factor: float) -> "Sortie":
        """Return the same sortie of a flight that begins at `begin` in place of `start`, `factor` times as long."""

        def then(t: float) -> float:
            return begin + (t - start) * factor

        visits = tuple(Visit(one.target, then(one.arrival), then(one.departure)) for one in self.visits)
        return Sortie(then(self.begin), then(self.end), visits)


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
