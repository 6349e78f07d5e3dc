"""A mission that is steered from outside: lines of JSON come in, and the messages that answer them go out."""

import time
from collections.abc import Iterator, Mapping
from typing import TypeVar

import numpy as np

from skyverse._version import __version__
from skyverse.errors import InputError, did_you_mean, printable
from skyverse.live.messages import (
    AnnouncedUAV,
    Answer,
    Hello,
    LineFault,
    MotionMessage,
    Refusal,
    Setpoints,
    UAVAnswer,
    YawMessage,
    read_observation,
)
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.live.tracks import Sighting
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.shapes import Sphere
from skyverse.model.short_lines import counted
from skyverse.model.trajectory import Trajectory
from skyverse.space.mission_cautions import mission_cautions

T = TypeVar("T")
MAX_RATE = 1000.0
"""Setpoints a second at most."""


class LiveSession:
    """A mission that is steered from outside.

    Parameters
    ----------
    replanner
        Of the mission.
    setpoints
        How many setpoints a second answers hold; none if left out.
    wgs84
        Whether setpoints have latitudes, longitudes and altitudes too.

    Attributes
    ----------
    replanner
        As given.
    answered, unproven, refused
        How many observations were answered, how many of them without a proven way out for all UAVs, and how many lines
        were refused.
    slowest
        Seconds that the slowest answer took.

    Raises
    ------
    InputError
        If an argument is out of range, or latitudes are asked for where the scenario has no origin.
    """

    def __init__(self, replanner: Replanner, *, setpoints: float | None = None, wgs84: bool = False) -> None:
        if setpoints is not None and not 0.0 < setpoints <= MAX_RATE:
            raise InputError(
                f"expected more than 0 and up to {MAX_RATE:g} a second, found {setpoints:g}", field="setpoints"
            )
        origin = replanner.mission.scenario.frame.origin
        if wgs84 and setpoints is None:
            raise InputError("expected setpoints with it, found none", field="wgs84")
        if wgs84 and origin is None:
            raise InputError("expected a scenario with an origin, found one without", field="wgs84")
        self.replanner = replanner
        self.answered = self.unproven = self.refused = 0
        self.slowest = 0.0
        self._setpoints, self._origin = setpoints, origin if wgs84 else None
        uavs = replanner.mission.scenario.uavs
        self._indices = {str(k): k for k in range(len(uavs))} | {uav.name: k for k, uav in enumerate(uavs)}

    def hello(self) -> Hello:
        """Return the message that goes out first."""
        replanner, mission = self.replanner, self.replanner.mission
        scenario = mission.scenario
        targets = [scenario.end_place(uav, k) for uav, k in enumerate(mission.assignment)]
        return Hello(
            version=__version__,
            mission=scenario.name,
            uavs=tuple(
                AnnouncedUAV(uav=k, name=uav.name, start=uav.start, target=target)
                for k, (uav, target) in enumerate(zip(scenario.uavs, targets, strict=True))
            ),
            horizon=replanner.horizon,
            lead=replanner.lead,
            memory=replanner.memory,
            origin=scenario.frame.origin,
            cautions=tuple(caution.sentence for caution in mission_cautions(mission)),
        )

    def answer(self, line: bytes, number: int) -> Answer | Refusal | None:
        """Return the answer to the line of some number; a blank line has none, and what cannot be changes nothing."""
        if not line.strip():
            return None
        began = time.perf_counter()
        try:
            seen = read_observation(line)
            replans = self.replanner.observe(
                seen.t,
                movers=seen.movers,
                obstacles=seen.obstacles,
                zones=seen.zones,
                states={uav: (one.position, one.velocity) for uav, one in self._by_index("states", seen.states)},
                targets=dict(self._by_index("targets", seen.targets)),
                gone=seen.gone,
                deadline_ms=seen.deadline_ms,
            )
        except InputError as error:
            self.refused += 1
            return Refusal(error=LineFault(line=number, field=error.sentence.field, message=str(error)))
        uavs, forgotten = tuple(map(self._uav_answer, replans)), replans[0].forgotten
        answer = Answer(line=number, t=self.replanner.now, uavs=uavs, forgotten=forgotten)
        self.answered += 1
        self.unproven += not all(replan.proven for replan in replans)
        self.slowest = max(self.slowest, time.perf_counter() - began)
        return answer

    def summary(self) -> str:
        """Return in one sentence what has been answered so far."""
        if not self.answered:
            return f"No observations answered, {counted(self.refused, 'line')} refused."
        proven = f"{self.answered - self.unproven} of them with a proven way out for every UAV"
        slowest = f"the slowest in {1e3 * self.slowest:.1f} ms"
        return f"{counted(self.answered, 'observation')} answered, {proven}, {slowest}; {self.refused} refused."

    def _by_index(self, field: str, given: Mapping[str, T]) -> Iterator[tuple[int, T]]:
        """Yield the index of each UAV for which a field holds something, and what that is."""
        found = set()
        for name, value in given.items():
            uav, place = self._indices.get(name), f"{field}.{printable(name, 60)}"
            if uav is None:
                near = did_you_mean(name[:60], self._indices)
                raise InputError(f"expected the name or the index of a UAV of the mission{near}", field=place)
            if uav in found:
                raise InputError("expected one value for each UAV, found two for this one", field=place)
            found.add(uav)
            yield uav, value

    def _uav_answer(self, replan: Replan) -> UAVAnswer:
        """Return what is answered for one UAV."""
        replanner, motion = self.replanner, self.replanner.motion(replan.uav)
        sampled = None
        if self._setpoints is not None:
            sampled = sampled_motion(
                motion, replan.time, replan.time + replanner.horizon, self._setpoints, self._origin
            )
        return UAVAnswer(
            uav=replan.uav,
            name=replanner.mission.scenario.uavs[replan.uav].name,
            kept=replan.kept,
            proven=replan.proven,
            clear_until=replan.clear_until,
            sentence=replan.sentence,
            arrival=replanner.arrival(replan.uav),
            milliseconds=round(1e3 * replan.seconds, 3),
            motion=motion_message(motion),
            setpoints=sampled,
        )


def load_kernels(mission: Mission) -> None:
    """Load all that replanning needs, so that no answer is late for it: replan a mission in which a UAV is hit."""
    ball = Sphere(centre=(0, 0, 0), radius=0.1)
    places = [uav.start for uav in mission.scenario.uavs[:1]]
    seen = [Sighting(name="ball", shape=ball, position=at, top_speed=0.1, max_acceleration=0.1) for at in places]
    replanner = Replanner(mission)
    for t in (0.0, 0.1):
        replanner.observe(t, movers=seen)


def motion_message(motion: Trajectory) -> MotionMessage:
    """Return what a message tells of a motion."""
    assert motion.pointing is not None
    t = np.unique(np.r_[motion.start, motion.pointing.corners[0]])
    t = t[t >= motion.start]
    yaw, yaw_rate, _ = motion.heading(t)
    return MotionMessage(
        knots=motion.knots.tolist(),
        coefficients=motion.coefficients.tolist(),
        yaw=YawMessage(t=t.tolist(), yaw=yaw.tolist(), yaw_rate=yaw_rate.tolist()),
    )


def sampled_motion(motion: Trajectory, begin: float, end: float, rate: float, origin: Origin | None) -> Setpoints:
    """Return a motion at instants between two, `rate` times a second; with an origin, in degrees too."""
    t = begin + np.arange(int(np.floor((end - begin) * rate)) + 1) / rate
    position, velocity, acceleration = motion.at(t)
    yaw, yaw_rate, _ = motion.heading(t)
    return Setpoints(
        t=t.tolist(),
        position=position.tolist(),
        velocity=velocity.tolist(),
        acceleration=acceleration.tolist(),
        yaw=yaw.tolist(),
        yaw_rate=yaw_rate.tolist(),
        wgs84=None if origin is None else to_wgs84(origin, position).tolist(),
    )
