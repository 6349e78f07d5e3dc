"""The UAVs of a scenario, what each could fly, and the tests of whether they are apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.conflicts import semi_axes
from skyverse.deconfliction.curve_store import Shelf
from skyverse.deconfliction.curves import Placed, standing
from skyverse.deconfliction.meeting import meetings
from skyverse.deconfliction.options import Fly, Gate, Gates, Option, gates, through
from skyverse.deconfliction.swept_volume_tree import all_free, clashes_with, earliest, survey
from skyverse.model.result import Result
from skyverse.model.trajectory import Trajectory
from skyverse.problem import Airspace
from skyverse.stop import Stop

TIGHT = 1.05
"""How near starts or targets are, as a share of the separation, where boxes are too coarse to tell them apart."""
PARTS = 8
"""Gates stand at so many places along a path, less one."""


@dataclass(frozen=True, eq=False)
class Place:
    """An option, flown from an instant on, and so many times as slowly; whether it clashes with one placed before."""

    option: Option
    at: float
    scale: float = 1.0
    clashes: bool = False

    @property
    def arrival(self) -> float:
        """Seconds into the mission."""
        return self.at + self.scale * self.option.seconds


class Others(NamedTuple):
    """Those placed, as kernels take them: flights, semi-axes, and who starts or ends about too close; (n,)."""

    placed: Placed
    wide: Floats
    tall: Floats
    tight: Bools


class Fleet:
    """The UAVs of a scenario, what each could fly, and the tests of whether they are apart.

    Parameters
    ----------
    airspace
        Of the scenario.
    fly
        Turns a way into a trajectory.
    stop
        Ends the search where it is `Cancelled`.
    """

    def __init__(self, airspace: Airspace, fly: Fly, stop: Stop | None = None) -> None:
        self.airspace, self.scenario, self.fly, self._stop = airspace, airspace.scenario, fly, stop
        self.shelf = Shelf()
        wide, tall = semi_axes(self.scenario)
        self._wide, self._tall = np.maximum.outer(wide, wide), np.maximum.outer(tall, tall)
        self._gates: dict[tuple[int, int], Gates] = {}
        self._ways: dict[tuple[int, Gate], Option | None] = {}

    @property
    def cancelled(self) -> bool:
        """Whether no better places are looked for any more."""
        return self._stop is not None and self._stop.cancelled

    def own(self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory | None) -> Option:
        """Return a UAV's own path as an option; it stands at its start where it has none."""
        flown = standing(self.scenario.uavs[uav]) if trajectory is None else trajectory
        return self._option(uav, None if trajectory is None else target, result, flown)

    def _option(
        self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory, walls: tuple[Gate, ...] = ()
    ) -> Option:
        curve = self.shelf.add(trajectory)
        return Option(uav, target, curve, self.shelf.seconds[curve], result, trajectory, walls)

    def others(self, option: Option, places: Sequence[Place]) -> Others:
        """Look at those placed from the side of an option."""
        who = np.array([place.option.uav for place in places], dtype=np.int64)
        curve = np.array([place.option.curve for place in places], dtype=np.int64)
        placed = Placed(curve, np.array([p.at for p in places]), np.array([p.scale for p in places]))
        wide, tall = self._wide[option.uav, who], self._tall[option.uav, who]
        tight = np.zeros(len(places), np.bool_)
        for a, b in (
            ([p.option.start for p in places], option.start),
            ([p.option.end for p in places], option.end),
        ):
            gap = (np.array(a).reshape(-1, 3) - b) ** 2
            near = (gap[:, 0] + gap[:, 1]) * tall**2 + gap[:, 2] * wide**2 < (TIGHT * wide * tall) ** 2
            tight |= near
        return Others(placed, wide, tall, tight)

    def clashes(self, option: Option, at: float, scale: float, others: Others) -> Bools:
        """Tell with whom of the others an option clashes, flown so, (n,)."""
        curves, tubes = self.shelf.laid
        found: Bools = clashes_with(curves, tubes, *others[:3], option.curve, at, scale)
        return found

    def delay(self, option: Option, scale: float, others: Others, latest: float) -> float | None:
        """Return the earliest instant up to the latest at which an option can depart, flown so slowly, if any."""
        free: Ints = all_free(latest, option.trajectory.start)
        curves, tubes = self.shelf.laid
        found = earliest(curves, tubes, *others, option.curve, scale, free)
        return None if found < 0.0 else found

    def detours(self, option: Option, share: float, others: Others, latest: float) -> list[tuple[float, Gate]]:
        """Return gates beside an option, where it has flown a share of its time, that may lead it around the others.

        Each comes with an estimate of the arrival, the earliest first: as if the option were drawn aside.
        """
        part = min(max(round(share * PARTS), 1), PARTS - 1)
        key = option.curve, part
        if key not in self._gates:
            self._gates[key] = gates(self.airspace, option, part / PARTS)
        beside, aside, stretched = self._gates[key]
        curves, tubes = self.shelf.laid
        since = option.trajectory.start
        arrivals = survey(curves, tubes, *others, option.curve, aside, stretched, part / PARTS, since, latest)
        order = [k for k in np.argsort(arrivals, kind="stable").tolist() if arrivals[k] < np.inf]
        return [(float(arrivals[k]), beside[k]) for k in order]

    def led_through(self, option: Option, gate: Gate) -> Option | None:
        """Return an option that leads through one more gate, or ``None`` where no path does."""
        key = option.curve, gate
        if key not in self._ways:
            assert option.target is not None
            walls = (*option.gates, gate)
            found = through(self.airspace, option.uav, option.target, walls, self.fly)
            self._ways[key] = None if found is None else self._option(option.uav, option.target, *found, walls)
        return self._ways[key]

    def share_of_clash(self, option: Option, others: Others, who: Bools) -> float | None:
        """Return after which share of its time an option, flown at once, clashes in flight: the middle one of them."""
        curves = self.shelf.laid.curves
        shares = []
        at = option.trajectory.start
        end = at + option.seconds
        for p in np.flatnonzero(who):
            flight = (int(others.placed.curve[p]), float(others.placed.at[p]), float(others.placed.scale[p]))
            mine = (option.curve, at, 1.0)
            spans = meetings(curves, *flight, *mine, float(others.wide[p]), float(others.tall[p]), end, False)
            shares += [(when - at) / option.seconds for when in spans[:, 2].tolist()]
        within = sorted(share for share in shares if 0.0 < share < 1.0)
        return within[len(within) // 2] if within else None
