"""One UAV's path and trajectory, sampled for pictures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.draw.palette import TRACKS
from skyverse.model.mission import PlannedFlight
from skyverse.model.scenario import Bounds
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.numerics.norm import off_chord
from skyverse.numerics.tolerances import DRAWN_DEVIATION
from skyverse.tour_table import NumberedVisit

Point = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class DrawnTrack:
    """One UAV in space and time.

    Attributes
    ----------
    colour, lap
        The UAV's colour, and how often the palette had been used up before it, which selects its dash and symbol.
    path
        (n, 3) metres: the planned path; empty where there is none.
    times, positions
        (m,) seconds and (m, 3) metres: samples of the trajectory; empty where there is none.
    start, target
        (3,) metres, as in the scenario; `target` is ``None`` where none was assigned.
    arrival
        Seconds into the mission; ``None`` without a trajectory.
    error
        How far the UAV may stray from its nominal positions.
    nominal
        (k, 3) metres: the planned trajectory, or the path where there is none; of a mission that was flown, `positions`
        are as flown.
    visits
        Of a tour: the targets that it visits, in their order.
    home
        Whether it ends where it starts.
    """

    name: str
    colour: str
    lap: int
    path: Floats
    times: Floats
    positions: Floats
    start: Point
    target: Point | None
    target_name: str | None
    arrival: float | None
    error: TrackingError
    nominal: Floats
    visits: tuple[NumberedVisit, ...] = ()
    home: bool = False

    @property
    def marks(self) -> list[tuple[Point, str, str]]:
        """Where it starts, and its targets: places, the numbers of visits, and what is told of each."""
        begins = (self.start, "", f"{self.name}: {'home' if self.home else 'start'}")
        visits = [(one.target.position, str(one.number), f"{self.name}, visit {one.sentence}") for one in self.visits]
        only = [(self.target, "", f"{self.name}: target {self.target_name or ''}")] if self.target is not None else []
        return [begins, *(visits or only)]

    def at(self, t: float) -> Floats:
        """Return the position at `t` seconds, (3,) metres; the UAV waits at its start and stays at its end."""
        if len(self.times) == 0:
            return np.array(self.start)
        return np.array([np.interp(t, self.times, self.positions[:, axis]) for axis in range(3)])

    def flown(self, t: float) -> Floats:
        """Return the trajectory up to `t` seconds, (k, 3) metres."""
        if len(self.times) == 0:
            return self.positions
        return np.vstack([self.positions[self.times < t], self.at(t)])


def track(flight: PlannedFlight, number: int, bounds: Bounds, visits: tuple[NumberedVisit, ...] = ()) -> DrawnTrack:
    """Return the track of a UAV; `number` is its index in the fleet."""
    uav, target, trajectory = flight.uav, flight.target, flight.trajectory
    times, positions = np.empty(0), np.empty((0, 3))
    if trajectory is not None:
        times, positions = sample(trajectory, DRAWN_DEVIATION * max(np.subtract(bounds.max, bounds.min)))
    path = np.empty((0, 3)) if flight.result is None else flight.result.path
    return DrawnTrack(
        name=uav.name,
        colour=TRACKS[number % len(TRACKS)],
        lap=number // len(TRACKS),
        path=path,
        times=times,
        positions=positions,
        start=uav.start,
        target=None if target is None else target.position,
        target_name=None if target is None else target.name,
        arrival=float(times[-1]) if len(times) else None,
        error=uav.tracking_error,
        nominal=positions if len(positions) else path,
        visits=visits,
        home=uav.end == "home",
    )


def sample(trajectory: Trajectory, tolerance: float) -> tuple[Floats, Floats]:
    """Return times, (m,), and positions, (m, 3), such that lines between them are within about `tolerance` metres.

    A chord over a time dt is off by up to dt**2 * |acceleration| / 8, so high accelerations get more samples.
    All knots are among the times.
    """
    lengths = np.diff(trajectory.knots)
    shares = np.linspace(0.0, 1.0, 17)[:-1] + 1 / 32
    probes = trajectory.knots[:-1, None] + lengths[:, None] * shares
    briskness = np.linalg.norm(trajectory.at(probes.ravel()).acceleration, axis=1).reshape(probes.shape).max(axis=1)
    counts = np.clip(np.ceil(lengths * np.sqrt(briskness / (8.0 * tolerance))), 2, 500).astype(int)
    pieces = [np.linspace(t, t + dt, n + 1)[:-1] for t, dt, n in zip(trajectory.knots, lengths, counts, strict=False)]
    times = np.concatenate([*pieces, trajectory.knots[-1:]])
    return times, trajectory.at(times).position


def few(points: Floats, tolerance: float) -> NDArray[np.bool_]:
    """Return which of the points, (n, 3), a line needs to pass all within `tolerance` (Douglas and Peucker)."""
    kept = np.zeros(len(points), dtype=bool)
    kept[[0, -1] if len(points) else []] = True
    left = [(0, len(points) - 1)]
    while left:
        first, last = left.pop()
        if last - first < 2:
            continue
        away = off_chord(points[first : last + 1])
        far = first + int(away.argmax())
        if away.max() > tolerance:
            kept[far] = True
            left += [(first, far), (far, last)]
    return kept
