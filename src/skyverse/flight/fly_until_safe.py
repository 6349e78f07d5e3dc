"""Fly, make it easier, fly again, until it is safe."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from skyverse.errors import InputError
from skyverse.flight.easier_mission import farther, slowed
from skyverse.flight.fly import OnFlown, fly
from skyverse.flight.judge import planned_close
from skyverse.model.flight_record import Flight
from skyverse.model.mission import Mission
from skyverse.model.verdict import Fault
from skyverse.planners.base import Seed, seeded
from skyverse.trajectory import Shape

SLOWDOWN = 1.25
"""How much longer a mission takes after a round."""


def fly_until_safe(
    mission: Mission,
    *,
    rounds: int = 5,
    shape: Shape = "minimum-snap",
    vehicle: str = "thesis",
    wind: Sequence[float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    margin: float | None = None,
    rng: Seed = None,
    workers: int = 1,
    on_progress: OnFlown | None = None,
    on_round: Callable[[str], None] | None = None,
) -> Flight:
    """Fly a mission, and where that is not safe, make it easier and fly it again.

    A round slows the whole mission down by a quarter, which keeps all that was proven of it. Where that did not halve
    by how much a UAV came too near an obstacle, or is impossible because aeroplanes fly along, the next one plans it
    anew instead: by Taut, at a clearance that is larger by what was missing, and as slow as it was before.

    Parameters
    ----------
    rounds
        The most that are made.
    shape
        Of trajectories that are planned anew; see `plan_mission`.
    on_round
        Called with a sentence about each round.

    Other parameters are those of `fly`; every round flies with the same noise.

    Returns
    -------
    Flight
        The first that is safe, or the last. Its `mission` is what was flown; its `rounds` say what was done.

    Raises
    ------
    InputError
        As `fly`; or if `rounds` is no whole number from 1 on.
    """
    if isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < 1:
        raise InputError(f"rounds is a whole number from 1 on, not {rounds!r}")
    seed = rng if isinstance(rng, int) else int(seeded(rng)[0].integers(2**62))
    said: list[str] = []
    slowness, more, before = 1.0, 0.0, float("inf")

    def flown(current: Mission) -> Flight:
        return fly(
            current,
            vehicle=vehicle,
            wind=wind,
            noise=noise,
            margin=margin,
            rng=seed,
            workers=workers,
            on_progress=on_progress,
        )

    flight = flown(mission)
    winged = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    for number in range(1, rounds + 1):
        if flight.safe:
            break
        if pair := _planned_close(flight):
            _say(said, on_round, f"Round {number}: {pair} are planned too close, which no slower flight mends; ended.")
            break
        short = _shortfall(flight)
        if short > 0 and (winged or short > before / 2):
            more += 1.1 * short
            anew = farther(mission, more, shape)
            done = f"planned anew at a clearance of {mission.scenario.clearance + more:.3g} m"
            if not anew.complete:
                _say(said, on_round, f"Round {number}: {done}, which leaves no way; ended.")
                break
            easier, before = slowed(anew, slowness) if slowness > 1 else anew, float("inf")
        elif winged:
            _say(said, on_round, f"Round {number}: nothing can be slowed down while an aeroplane keeps its airspeed.")
            break
        else:
            slowness *= SLOWDOWN
            easier, before = slowed(flight.mission, SLOWDOWN), short
            done = f"slowed down to {1 / slowness:.0%} of its speed"
        flight = flown(easier)
        verdict = "safe" if flight.safe else f"not safe: {flight.violations[0].message}"
        _say(said, on_round, f"Round {number}: {done}; {verdict}.")
    return replace(flight, rounds=tuple(said))


def _say(said: list[str], on_round: Callable[[str], None] | None, sentence: str) -> None:
    said.append(sentence)
    if on_round is not None:
        on_round(sentence)


def _planned_close(flight: Flight) -> str:
    """Return two UAVs that strayed into a separation that their trajectories do not keep either, or nothing."""
    names = [uav.name for uav in flight.mission.scenario.uavs]
    wrong = (violation.uavs for violation in flight.violations if violation.fault is Fault.SEPARATION)
    return next((f"{names[i]} and {names[j]}" for i, j in wrong if planned_close(flight.mission, i, j)), "")


def _shortfall(flight: Flight) -> float:
    """Return how many metres are missing to what must be left to obstacles and ground; 0 where none are."""
    scenario, missing = flight.mission.scenario, [0.0]
    near = {violation.uavs[0] for violation in flight.violations if violation.fault is Fault.TRAJECTORY_CLEARANCE}
    for flown in flight.flown:
        if flown is not None and flown.uav in near:
            missing.append(scenario.clearance - flight.margin - flown.clearance)
            if flown.above_ground is not None:
                missing.append(scenario.ground_clearance - flight.margin - flown.above_ground)
    return max(missing)
