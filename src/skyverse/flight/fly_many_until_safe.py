"""Flies a mission many times, made easier until no run touches anything, or gives it up as too tight."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from skyverse.errors import InputError
from skyverse.flight.easier_mission import farther, slowed
from skyverse.flight.fly_many import Flights, OnRuns
from skyverse.flight.vehicle import refuse_stand_in
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_runs import FlightRuns
from skyverse.model.mission import Mission
from skyverse.model.simulated_vehicle import simulated_vehicle
from skyverse.planners.base import Seed
from skyverse.referee import check
from skyverse.trajectory import Shape

SLOWDOWN = 1.5
"""The factor by which a mission takes longer after a round."""
SPARE = 0.02
"""Metres added to what was missing, since another run may come nearer than the nearest that was flown."""


def fly_many_until_safe(
    mission: Mission,
    *,
    rounds: int = 8,
    shape: Shape = "minimum-time",
    runs: int = 100,
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_progress: OnRuns | None = None,
    on_round: Callable[[str], None] | None = None,
) -> FlightRuns:
    """Fly a mission many times; while any run touches something, make the mission easier and fly it again.

    A round makes the whole mission take half as long again, which keeps all that is proven of it. If that did not halve
    what was missing to the vehicle's radius, or is impossible because of an aeroplane, the next round instead plans the
    mission again with `Auto`, with what was missing added to clearance and separation, and as slow as before. A round
    ends soon after a run has touched something. A mission that is still not safe after all rounds, or for which there
    is no way left, is refused.

    Parameters
    ----------
    rounds
        The largest number of rounds.
    shape
        The shape of trajectories that are planned again; see `plan_mission`.
    on_round
        Called with a sentence about each round.

    The other parameters are those of `fly_many`; every round flies with the same seeds.

    Returns
    -------
    FlightRuns
        Those of the first mission of which no run touches anything; or else the last, with a `refusal`.

    Raises
    ------
    InputError
        As for `fly_many`, if `rounds` is not a whole number from 1 on, or if the vehicle is not the planned one.
    """
    if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 1:
        raise InputError(f"rounds is a whole number from 1 on, not {rounds!r}")
    vehicle = vehicle or simulated_vehicle(mission.scenario.uavs)
    refuse_stand_in(vehicle, mission.scenario.uavs)
    flights = Flights(runs, vehicle, wind, noise, disturbances, rng, workers)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    said: list[str] = []
    slowness, more, apart, before = 1.0, 0.0, 0.0, math.inf

    def say(sentence: str) -> None:
        said.append(sentence)
        if on_round is not None:
            on_round(sentence)

    flown = flights.fly(mission, until_touch=True, on_progress=on_progress)
    why = ""
    while not flown.safe and not why:
        if len(said) == rounds:
            why = f"after {rounds} rounds, {flown.touches[0].sentence}"
            break
        near, close = _missing(flown)
        short = max(near, close)
        if short > 0 and (winged or short > before / 2):
            more += near + SPARE if near > 0 else 0.0
            apart += close + 2 * SPARE if close > 0 else 0.0
            done = f"planned anew with {more:.3g} m more clearance and {apart:.3g} m more separation"
            anew = farther(mission, more, shape, apart)
            if anew is None or not anew.complete or not _kept(mission, anew):
                why = f"{done}, there is no way left"
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, math.inf
        elif winged:
            why = "an aeroplane keeps its airspeed, so that nothing can be slowed down"
            break
        else:
            slowness *= SLOWDOWN
            easier, before = slowed(flown.mission, SLOWDOWN), short if short > 0 else math.inf
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        flown = flights.fly(easier, until_touch=True, on_progress=on_progress)
        verdict = "safe" if flown.safe else flown.touches[0].sentence
        say(f"Round {len(said) + 1}: {done}; {verdict}.")
    if why:
        slow = f" at {1 / slowness:.0%} of its speed" if slowness > 1 else ""
        why = f"Refused: {mission.scenario.name}{slow} is too tight for {_weather(flown)}: {why}."
    return replace(flown, rounds=tuple(said), refusal=why)


def _missing(flown: FlightRuns) -> tuple[float, float]:
    """Return by how many metres obstacles or ground, and another UAV, came nearer than the vehicle's reach."""
    return flown.radius - float(flown.clearance.min()), 2 * flown.radius - float(flown.separation.min())


def _kept(before: Mission, after: Mission) -> bool:
    """Tell whether a mission that was planned anew is no worse in the referee's eyes."""
    given = {violation.fault for violation in check(before.scenario, before)}  # a file may tell any of it
    return {violation.fault for violation in after.violations} <= given


def _weather(flown: FlightRuns) -> str:
    """Return what disturbs, in words."""
    speed = math.hypot(*flown.wind)
    noise = f"noise of {flown.noise:g} m" if flown.noise else ""
    told = filter(None, [f"a wind of {speed:.3g} m/s" if speed else "", noise, flown.disturbances.sentence])
    return ", ".join(told) or "still air"
