"""Certificates against an oracle: ``python benchmarks/certificates.py [WORLDS] [--first SEED] [--processes P]``.

Random worlds and fleets (`wild`), some with tracking errors, ceilings, climb limits and obstacles closed above
(`margins`), flights that rise and land on pads (`pads`), and walls with slits and corridors that fit
exactly (`walls`), are judged by `certify` and `check`, and by dense sampling (`oracle`), which shares no code with the
referee. What is called proven must look so at all samples, and at random places within the tracking error of each; what
is called refuted must be so at the instant that is named. The first disagreement ends the run with exit code 1 and
names the seed.
"""

import argparse
import sys
import time
from collections import Counter
from itertools import combinations
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
from machine import describe, table
from margins import astray, narrowed, reach, strays
from oracle import RATE, Motion, excess, moving, norm, sampled, where
from pads import by_pads, rising
from walls import walled
from wild import world

import skyverse as sky
from skyverse.model.shapes import Voxels
from skyverse.numerics.cores import cores

ROUNDING = 1e-9  # of the oracle
ABRUPT = (sky.Fault.CONTINUITY, sky.Fault.TRAJECTORY_ENDS)  # at knots, judged exactly


class Outcome(NamedTuple):
    """One world: what was counted, what disagrees, and the referee's seconds for trajectories and fleet."""

    seed: int
    counted: Counter
    wrong: list[str]
    seconds: float


def compared(seed: int) -> Outcome:
    """Judge one world by both."""
    made = rising if seed % 8 == 6 else walled if seed % 4 == 3 else world
    mission = made(seed)
    mission = narrowed(mission, seed) if seed % 5 == 1 and made is not rising else mission
    scenario = mission.scenario
    began = time.perf_counter()
    certificates = sky.certify(scenario, mission)
    seconds = time.perf_counter() - began
    violations = sky.check(scenario, mission)
    counted: Counter = Counter()
    wrong: list[str] = []
    for uav, certificate in enumerate(certificates.trajectories):
        if certificate is not None:
            counted["trajectory", certificate.verdict] += 1
            faults = [violation for violation in violations if violation.uavs == (uav,) and violation.time is not None]
            wrong += trajectory(mission, uav, certificate, faults, counted)
    if len(scenario.uavs) > 1:
        counted["fleet", certificates.apart.verdict] += 1
        wrong += separation(mission, certificates.apart, violations, counted)
    return Outcome(seed, counted, [f"seed {seed}: {complaint}" for complaint in wrong], seconds)


def trajectory(
    mission: sky.Mission, uav: int, certificate: sky.Certificate, violations: list[sky.Violation], counted: Counter
) -> list[str]:
    """Return where certificate or violations of one trajectory and samples disagree."""
    flown, vehicle = mission.trajectories[uav], mission.scenario.uavs[uav]
    _, motion = sampled(flown)
    worst = {fault: values.max() for fault, values in excess(mission.scenario, vehicle, motion).items()}
    seen = {fault for fault, value in worst.items() if value > ROUNDING}
    wrong = []
    error = vehicle.tracking_error
    exact = error == sky.TrackingError()
    if certificate.verdict is sky.Verdict.PROVEN:
        counted["strayed", ""] += not exact
        counted["on pad", ""] += "on the pad" in certificate.sentence
        for kept in by_pads(mission, uav, motion):
            for fault, value in strays(mission, uav, kept).items():
                if value > ROUNDING:
                    wrong.append(f"{vehicle.name} is proven, but {fault.value} by {value:.3g} when it strays")
        wrong += [f"{vehicle.name} is proven, but {fault.value} by {worst[fault]:.3g}" for fault in seen]
        wrong += [f"{vehicle.name} is proven, but {violation.message}" for violation in violations]
    named = {violation.fault for violation in violations}
    if sky.Fault.UNDECIDED not in named:
        wrong += [f"{vehicle.name} is {fault.value} by {worst[fault]:.3g}, unnoticed" for fault in seen - named]
    for violation in violations:
        counted["violation", violation.fault] += 1
        if violation.fault in ABRUPT or violation.fault is sky.Fault.UNDECIDED:
            continue
        if not exact and violation.fault in (sky.Fault.TRAJECTORY_BOUNDS, sky.Fault.TRAJECTORY_CLEARANCE):
            continue  # spheres and the ground grow by more than the error, and the nominal position need not be unsafe
        there = max(
            excess(mission.scenario, vehicle, at)[violation.fault].max() for at in around(flown, violation.time)
        )
        if not there > -ROUNDING:
            wrong.append(f"{violation.message} But the excess there is {there:.3g}.")
        # quantities of which the referee seeks the worst instant along another scale are left out; so are voxels, of
        # which several may be one box
        voxels = any(isinstance(shape, Voxels) for shape in mission.scenario.obstacles)
        scales = [sky.Fault.SPEED] if voxels else [sky.Fault.SPEED, sky.Fault.TRAJECTORY_CLEARANCE]
        if violation.fault in scales and worst[violation.fault] > there + 1e-6:
            wrong.append(f"{violation.message} But it is worse elsewhere, {worst[violation.fault]:.9g} > {there:.9g}.")
        late = not flown.start <= violation.time <= flown.end
        wrong += [f"{violation.message} But it does not fly then."] if late else []
    return wrong


def around(flown: sky.Trajectory, time: float) -> list[Motion]:
    """Return the motion at an instant; at a knot, on both of its sides."""
    pieces = np.flatnonzero((flown.knots[:-1] <= time + 1e-12) & (flown.knots[1:] >= time - 1e-12))
    local = [np.clip(time - flown.knots[k], 0, flown.knots[k + 1] - flown.knots[k]) for k in pieces]
    return [moving(flown, k, np.array([at])) for k, at in zip(pieces, local, strict=True)]


def separation(
    mission: sky.Mission, apart: sky.Certificate, violations: list[sky.Violation], counted: Counter
) -> list[str]:
    """Return where what is said of each pair and samples disagree."""
    scenario, flown = mission.scenario, mission.trajectories
    end = max((one.end for one in flown if one is not None), default=0.0) + 0.01
    t = np.concatenate([np.arange(0, end, 1 / RATE), np.random.default_rng(0).uniform(0, end, 1000)])
    t.sort()
    places = [where(one, np.array(uav.start), t) for one, uav in zip(flown, scenario.uavs, strict=True)]
    named = {(violation.uavs, violation.fault): violation for violation in violations if len(violation.uavs) == 2}
    wrong = []
    if (apart.verdict is sky.Verdict.PROVEN) != (not named):
        wrong.append(f"the fleet is {apart.verdict.value}, but {len(named)} pairs are not")
    for i, j in combinations(range(len(places)), 2):
        across = max(scenario.uavs[k].ellipsoid[0] for k in (i, j))
        above = max(scenario.uavs[k].ellipsoid[1] for k in (i, j))
        aside, up = (sum(pair) for pair in zip(*(reach(scenario.uavs[k].tracking_error) for k in (i, j)), strict=True))
        if across > 0 and above > 0 and apart.verdict is sky.Verdict.PROVEN:
            wrong += astray(places[i] - places[j], (across, above), (aside, up), f"UAVs {i} and {j}")
        axes = np.array([across, across, above]) * (1 + np.hypot(aside / across, up / above) if across * above else 1)
        floor = given(mission, (i, j), axes, norm((places[i] - places[j]) / axes) >= 1)
        keep = axes * floor[:, None] - 1e-6
        near = np.where(keep.min(axis=1) > 0, norm((places[i] - places[j]) / np.where(keep > 0, keep, 1.0)), np.inf)
        undecided = ((i, j), sky.Fault.UNDECIDED) in named
        told = ((i, j), sky.Fault.GIVEN) in named
        if told != bool((floor < 1).any()) and not undecided:
            wrong.append(f"UAVs {i} and {j} are {'not ' if told else ''}given too close")
        counted["violation", sky.Fault.GIVEN] += told
        violation = named.get(((i, j), sky.Fault.SEPARATION))
        if violation is None:
            if near.min() < 1 - ROUNDING and not undecided:
                wrong.append(f"UAVs {i} and {j} come to {near.min():.9g}, unnoticed")
            continue
        counted["violation", sky.Fault.SEPARATION] += 1
        when = int(np.clip(np.searchsorted(t, violation.time), 1, len(t) - 1))
        least = axes * max(floor[when - 1 : when + 1]) - 1e-6
        at = np.array([violation.time])
        one, other = (where(flown[k], np.array(scenario.uavs[k].start), at)[0] for k in (i, j))
        there = float(np.sqrt((((one - other) / least) ** 2).sum()))
        if not there < 1 + ROUNDING:
            wrong.append(f"{violation.message} But they are at {there:.12g} of it then.")
    return wrong


def given(mission: sky.Mission, pair: tuple[int, int], axes: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """Return the nearness to keep at each sample: less than 1 until first apart, or from when last apart, if given."""
    starts = [np.array(mission.scenario.uavs[k].start) for k in pair]
    spans = [(starts, np.cumsum(apart) == 0)]
    if all(mission.trajectories[k] is not None for k in pair):
        ends = [np.array(mission.scenario.targets[mission.assignment[k]].position) for k in pair]
        spans.append((ends, np.cumsum(apart[::-1])[::-1] == 0))
    floor = np.ones(len(apart))
    for places, span in spans:
        if norm(((places[0] - places[1]) / (axes - 1e-6))[None])[0] < 1:
            nearness = norm(((places[0] - places[1]) / axes)[None])[0]
            floor[span] = np.minimum(floor[span], nearness)
    return floor


def main(worlds: int, first: int, processes: int) -> int:
    """Compare so many worlds; return the exit code."""
    began, seconds = time.perf_counter(), 0.0
    counted: Counter = Counter()
    done = 0
    with get_context("spawn").Pool(processes) as pool:
        for done, outcome in enumerate(pool.imap(compared, range(first, first + worlds), 4), 1):
            counted += outcome.counted
            seconds += outcome.seconds
            if outcome.wrong:
                print("\n".join(outcome.wrong))
                return 1
            if done % 200 == 0:
                print(f"{done:,} worlds to seed {outcome.seed}, {time.perf_counter() - began:.0f} s", file=sys.stderr)
    print(f"{describe()}\n\n{done:,} worlds from seed {first}, {time.perf_counter() - began:.0f} s; no disagreement.\n")
    rows = [[kind, *(f"{counted[kind, verdict]:,}" for verdict in sky.Verdict)] for kind in ("trajectory", "fleet")]
    table(["", *(verdict.value for verdict in sky.Verdict)], rows)
    flown = sum(counted["trajectory", verdict] for verdict in sky.Verdict)
    print(f"\n{1e3 * seconds / max(flown, 1):.1f} ms per trajectory, separations included. Violations:\n")
    rows = [[f.value, f"{counted['violation', f]:,}"] for f in sky.Fault if counted["violation", f]]
    table(["", "found"], rows)
    strayed, pads = counted["strayed", ""], counted["on pad", ""]
    print(f"\n{strayed:,} of the proven trajectories had a tracking error; {pads:,} rose or landed on a pad.")
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("worlds", type=int, nargs="?", default=1000)
    parser.add_argument("--first", type=int, default=0, help="the first seed; go on from here")
    parser.add_argument("--processes", type=int, default=cores())
    wanted = parser.parse_args()
    sys.exit(main(wanted.worlds, wanted.first, wanted.processes))
