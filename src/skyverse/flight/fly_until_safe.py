"""Flies a mission repeatedly, made easier after each unsafe flight, until it is safe."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from skyverse.errors import InputError
from skyverse.flight.easier_mission import farther, slowed
from skyverse.flight.fly import OnFlown, fly
from skyverse.flight.judge import planned_close
from skyverse.flight.vehicle import refuse_stand_in
from skyverse.model.disturbances import Disturbances
from skyverse.model.flight_record import Flight
from skyverse.model.mission import Mission
from skyverse.model.simulated_vehicle import simulated_vehicle
from skyverse.model.verdict import Fault
from skyverse.planners.base import Seed, seeded
from skyverse.trajectory import Shape

SLOWDOWN = 1.25
"""The factor by which a mission takes longer after a round."""


def fly_until_safe(
    mission: Mission,
    *,
    rounds: int = 5,
    shape: Shape = "minimum-time",
    vehicle: str | None = None,
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    disturbances: Disturbances | None = None,
    margin: float | None = None,
    rng: Seed = None,
    workers: int = 1,
    on_progress: OnFlown | None = None,
    on_round: Callable[[str], None] | None = None,
) -> Flight:
    """Fly a mission; while the flight is not safe, make the mission easier and fly it again.

    A round makes the whole mission take a quarter longer, which keeps all that is proven of it. If that did not halve
    the distance by which a UAV came too near to an obstacle, or is impossible because of an aeroplane, the next round
    instead plans the mission again with `Auto`, with the missing distance added to the clearance, and as slow as
    before.

    Parameters
    ----------
    rounds
        The largest number of rounds.
    shape
        The shape of trajectories that are planned again; see `plan_mission`.
    on_round
        Called with a sentence about each round.

    The other parameters are those of `fly`; every round flies with the same seed.

    Returns
    -------
    Flight
        The first safe flight, or else the last. Its `mission` is the one that was flown; its `rounds` describe what was
        changed.

    Raises
    ------
    InputError
        As for `fly`, if `rounds` is not a whole number from 1 on, or if the vehicle is not the planned one.
    """
    if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 1:
        raise InputError(f"rounds is a whole number from 1 on, not {rounds!r}")
    refuse_stand_in(vehicle or simulated_vehicle(mission.scenario.uavs), mission.scenario.uavs)
    seed = rng if isinstance(rng, int) else int(seeded(rng)[0].integers(2**62))
    said: list[str] = []
    slowness, more, before = 1.0, 0.0, float("inf")
    flown = partial(
        fly,
        vehicle=vehicle,
        wind=wind,
        noise=noise,
        disturbances=disturbances,
        margin=margin,
        rng=seed,
        workers=workers,
        on_progress=on_progress,
    )

    def say(sentence: str) -> None:
        said.append(sentence)
        if on_round is not None:
            on_round(sentence)

    flight = flown(mission)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    for number in range(1, rounds + 1):
        if flight.safe:
            break
        if pair := _planned_close(flight):
            say(f"Round {number}: {pair} are planned too close, which no slower flight mends; ended.")
            break
        short = _shortfall(flight)
        if short > 0 and (winged or short > before / 2):
            more += 1.1 * short
            anew = farther(mission, more, shape)
            done = f"planned anew at a clearance of {mission.scenario.clearance + more:.3g} m"
            if anew is None or not anew.complete:
                say(f"Round {number}: {done}, which leaves no way; ended.")
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, float("inf")
        elif winged:
            say(f"Round {number}: nothing can be slowed down while an aeroplane keeps its airspeed.")
            break
        else:
            slowness *= SLOWDOWN
            easier, before = slowed(flight.mission, SLOWDOWN), short
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        flight = flown(easier)
        verdict = "safe" if flight.safe else f"not safe: {flight.violations[0].message}"
        say(f"Round {number}: {done}; {verdict}.")
    return replace(flight, rounds=tuple(said))


def _planned_close(flight: Flight) -> str:
    """Return the names of two UAVs whose planned trajectories also violate their separation, or an empty string."""
    names = [uav.name for uav in flight.mission.scenario.uavs]
    wrong = (violation.uavs for violation in flight.violations if violation.fault is Fault.SEPARATION)
    return next((f"{names[i]} and {names[j]}" for i, j in wrong if planned_close(flight.mission, i, j)), "")


def _shortfall(flight: Flight) -> float:
    """Return the largest shortfall of clearance from obstacles and ground, metres; 0 where there is none."""
    scenario, missing = flight.mission.scenario, [0.0]
    near = {violation.uavs[0] for violation in flight.violations if violation.fault is Fault.TRAJECTORY_CLEARANCE}
    for flown in flight.flown:
        if flown is not None and flown.uav in near:
            missing.append(scenario.clearance - flight.margin - flown.clearance)
            if flown.above_ground is not None:
                missing.append(scenario.ground_clearance - flight.margin - flown.above_ground)
    return max(missing)
