"""How near two flights come to each other, by dense sampling: the truth that conflicts are tested against."""

from typing import NamedTuple

import numpy as np


class Timed(NamedTuple):
    """A trajectory that departs at an instant and takes some times as long; `TimedCurve` without arrays."""

    trajectory: object
    departure: float
    time_scale: float

    @property
    def arrival(self):
        return self.departure + self.time_scale * (self.trajectory.end - self.trajectory.start)

    def at(self, times):
        """Positions (m, 3): it waits at its start before, and stays at its end after the flight."""
        local = (np.asarray(times) - self.departure) / self.time_scale
        return self.trajectory.at(np.clip(self.trajectory.start + local, *self.trajectory.knots[[0, -1]])).position


def moved_to_meet(rng, flight, other):
    """The flight, moved so that it is within decimetres of another one at an instant at which one of them moves."""
    instant = rng.uniform(min(flight.departure, other.departure), max(flight.arrival, other.arrival))
    gap = other.at([instant])[0] + rng.normal(0, 0.2, 3) - flight.at([instant])[0]
    rows = flight.trajectory.coefficients.copy()
    rows[:, 0] += gap
    return flight._replace(trajectory=type(flight.trajectory)(flight.trajectory.knots, rows))


def nearness(one, other, semi_axis_xy, semi_axis_z, times):
    """The distance of two flights at instants (m,), as a share of the semi-axes."""
    gap = (one.at(times) - other.at(times)) / (semi_axis_xy, semi_axis_xy, semi_axis_z)
    return np.sqrt(np.sum(gap**2, axis=1))
