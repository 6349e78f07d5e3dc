"""Whole flights that are replanned: what a sensor sees of movers, and what the referee says of what was flown."""

from dataclasses import replace

import numpy as np

import skyverse as sky
from skyverse.referee.curve import curve_of
from skyverse.referee.sorties import Tour
from skyverse.referee.timed_shapes import judge_movers
from skyverse.referee.trajectory import judge_trajectory
from skyverse.referee.world import RefereeWorlds

BALL = sky.Sphere(centre=(0, 0, 0), radius=0.4)


def hall(*obstacles, uavs=None, targets=None, clearance=0.2, size=(20, 10, 4)):
    """A hall that UAVs cross."""
    return sky.Scenario(
        name="hall",
        bounds=sky.Bounds(min=(0, 0, 0), max=size),
        obstacles=obstacles,
        clearance=clearance,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=uavs or [sky.UAV(start=(1, 5, 1))],
        targets=targets or [sky.Target(position=(19, 5, 1))],
    )


def plane(start=(40, 200, 30), **more):
    """An aeroplane that turns on 40 m and climbs by 12 degrees."""
    wing = sky.FixedWing(speed=15, turn_radius=40, climb=12)
    return sky.UAV(
        **{"start": start, "max_speed": 16, "max_acceleration": 7, "separation": 10, "fixed_wing": wing, **more}
    )


def field(*obstacles, uavs=None, targets=None, size=(600, 400, 120), **more):
    """A field that aeroplanes cross."""
    return sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(0, 0, 0), max=size),
        obstacles=obstacles,
        clearance=3,
        lattice=sky.Lattice(step=(10, 10, 10), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=uavs or [plane()],
        targets=targets or [sky.Target(position=(560, 200, 60))],
        **more,
    )


def sightings(truth, t, near, *, reach=np.inf, top_speed, max_acceleration=None, error=0.0, rng=None):
    """What a sensor sees at an instant of movers within its reach of some places (n, 3)."""
    seen = []
    for mover in truth:
        at = mover.at([t])[0]
        if np.linalg.norm(at - near, axis=1).min() <= reach:
            if rng is not None:
                off = rng.normal(size=3)
                at = at + off * error * rng.uniform() / np.linalg.norm(off)
            seen.append(
                sky.Sighting(
                    name=mover.name, shape=mover.shape, position=tuple(at.tolist()), error=error,
                    top_speed=top_speed, max_acceleration=max_acceleration,
                )
            )  # fmt: skip
    return seen


def fly(replanner, truth, *, rate=10.0, seconds=60.0, after=None, **sensor):
    """Observe movers until all UAVs have arrived, with perfect tracking; return all answers."""
    uavs = range(len(replanner.mission.scenario.uavs))
    answers = []
    for k in range(int(seconds * rate)):
        t = k / rate
        places = np.array([replanner.motion(uav).at([t]).position[0] for uav in uavs])
        answers.append(replanner.observe(t, movers=sightings(truth, t, places, **sensor)))
        if after is not None:
            after(answers[-1])
        arrivals = [replanner.arrival(uav) for uav in uavs]
        if None not in arrivals and max(arrivals) <= t:
            break
    return answers


def observe(flight, since, until=60.0, rate=10.0, **given):
    """Observe until all UAVs have arrived; what is given is observed first. Return all answers."""
    answers = []
    for k in range(round(rate * since), round(rate * until)):
        answers += flight.observe(k / rate, **(given if not answers else {}))
        arrivals = [flight.arrival(uav) for uav in range(len(flight.scenario.uavs))]
        if None not in arrivals and max(arrivals) <= k / rate:
            break
    return answers


def whole_flight(flight, scenario):
    """What the referee proves of all that one UAV has flown in a scenario that has its target."""
    mission = replace(flight.mission, scenario=scenario, trajectories=(flight.flown(0),))
    return sky.certify(scenario, mission).trajectories[0]


def certified(replanner, truth, **more):
    """What the referee proves of all that was flown among the movers as they are."""
    mission = replanner.mission
    scenario = sky.Scenario(**{**dict(mission.scenario), "movers": tuple(truth), **more})
    flown = tuple(replanner.flown(uav) for uav in range(len(scenario.uavs)))
    return sky.certify(scenario, replace(mission, scenario=scenario, trajectories=flown))


def from_now(motion, now):
    """The same motion from an instant on, which becomes 0 s."""
    k = max(int(np.searchsorted(motion.knots, now, side="right")) - 1, 0)
    if k >= len(motion.coefficients):
        return sky.Trajectory(np.array([0.0, 1.0]), motion.at([motion.end]).position[None])
    rows, since = motion.coefficients[k:].copy(), now - motion.knots[k]
    for i in range(rows.shape[1] - 1):
        for j in range(rows.shape[1] - 2, i - 1, -1):
            rows[0, j] += since * rows[0, j + 1]
    return sky.Trajectory(np.append(0.0, motion.knots[k + 1 :] - now), rows)


def earlier(mover, seconds):
    """A mover that was predicted from a sighting, with all instants earlier by some seconds."""
    motion = mover.motion.model_copy(update={"times": tuple(t - seconds for t in mover.motion.times)})
    doubt = mover.doubt.model_copy(update={"since": mover.doubt.since - seconds})
    return mover.model_copy(update={"motion": motion, "doubt": doubt})


def faults(replanner, uav=0):
    """What the referee finds wrong with what a UAV flies from now on, up to the horizon, wherever movers may be."""
    motion, horizon = from_now(replanner.motion(uav), replanner.now), replanner.horizon
    start = motion.at([0.0]).position[0]
    uavs = [replanner.mission.scenario.uavs[uav].model_copy(update={"start": tuple(start.tolist())})]
    scenario = replanner.scenario.model_copy(
        update={"uavs": tuple(uavs), "movers": tuple(earlier(one, replanner.now) for one in replanner.predicted())}
    )
    judged = judge_trajectory(RefereeWorlds(scenario).of(0), 0, Tour(), motion)
    found = [one for one in judged.violations if one.fault is not sky.Fault.TRAJECTORY_ENDS]  # it flies already
    horizon -= 2e-3  # so long it is judged where it ends
    if motion.end > horizon:  # what is flown later need only be clear of what stands still
        k = int(np.searchsorted(motion.knots, horizon))
        motion = sky.Trajectory(np.append(motion.knots[:k], horizon), motion.coefficients[:k])
    stay = max(horizon - motion.end, 1e-3)
    return [*found, *judge_movers(scenario, [curve_of(motion)], set(), stay)[0].violations]
