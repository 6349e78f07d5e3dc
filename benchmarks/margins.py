"""Margins for the missions of `certificates.py`: tracking errors, ceilings, climb limits, obstacles closed above."""

from dataclasses import replace
from math import radians, tan

import numpy as np
from oracle import Motion, depth, excess, ground, norm, sampled
from pads import Kept, too_near_steep_ground
from wild import OFF

import skyverse as sky
from skyverse.model.quantities import derived
from skyverse.model.shapes import Sphere, Terrain

PER_INSTANT = 4


def narrowed(mission: sky.Mission, seed: int) -> sky.Mission:
    """Return a mission whose scenario asks for more, some of which its flights just keep, or just break."""
    rng = np.random.default_rng([seed, 2])
    scenario = mission.scenario
    motions = [None if flown is None else sampled(flown)[1] for flown in mission.trajectories]
    flown = np.concatenate([motion.position for motion in motions if motion is not None] or [np.zeros((1, 3))])
    if rng.random() < 0.3:
        closed = [
            shape if isinstance(shape, Sphere) else derived(shape, closed_above=bool(rng.random() < 0.3))
            for shape in scenario.obstacles
        ]
        scenario = derived(scenario, obstacles=tuple(closed))
    if scenario.terrain is not None and rng.random() < 0.5:
        terrain = scenario.terrain
        lowest = terrain.heights - np.where(rng.random(terrain.heights.shape) < 0.3, rng.uniform(0, 5), 0.0)
        terrain = Terrain.model_validate(derived(terrain, lowest=lowest).model_dump())
        scenario = derived(scenario, terrain=terrain)
        highest = float((flown[:, 2] - ground(terrain.lowest_ground, flown[:, :2])).max()) + float(rng.choice(OFF))
        scenario = derived(scenario, max_height=max(highest, scenario.ground_clearance + 0.01))
    inside = np.minimum(flown - scenario.bounds.min, scenario.bounds.max - flown).min()
    gap = min(float(-depth(scenario, flown).max()), float(inside), 3.0)
    uavs = [limited(uav, motion, gap, rng) for uav, motion in zip(scenario.uavs, motions, strict=True)]
    return replace(mission, scenario=derived(scenario, uavs=tuple(uavs)))


def limited(uav: sky.UAV, motion: Motion | None, gap: float, rng: np.random.Generator) -> sky.UAV:
    """Return a UAV with a tracking error of about what is free around a flight, and perhaps with climb limits."""
    changes: dict[str, object] = {}
    if motion is not None and rng.random() < 0.5:
        fastest = np.array([motion.velocity[:, 2].max(), -motion.velocity[:, 2].min()])
        wing = uav.fixed_wing
        least = 1e-3 if wing is None else wing.speed * tan(radians(wing.climb)) * (1 + 1e-12)  # what a UAV may have
        climb, descent = np.maximum(fastest * (1 + rng.choice(OFF, 2)), max(least, 1e-3))
        changes |= {"max_climb": float(climb), "max_descent": float(descent)}
    if rng.random() < 0.8:
        aside, up = max(gap, 0.05) * rng.choice([0.0, 0.2, 0.5, 0.7, 1.0, 1.2], 2) * (1 + rng.choice(OFF, 2))
        changes["tracking_error"] = sky.TrackingError(horizontal=float(aside), vertical=float(up))
    return derived(uav, **changes)


def reach(error: sky.TrackingError) -> tuple[float, float]:
    """Return the radius and half the height of the cylinder about a nominal position, metres."""
    return error.horizontal, error.vertical


def astray(difference: np.ndarray, axes: tuple[float, float], errors: tuple[float, float], who: str) -> list[str]:
    """Return a complaint if UAVs can be too close within the sum of their errors.

    `difference` is that of nominal positions, (n, 3). The nearest places are sought in the plane through the vertical:
    the cylinder reaches the inner end of the radius, and the height is brought as near to 0 as it can be.
    """
    level = np.maximum(norm(difference[:, :2]) - errors[0], 0.0)
    upright = np.maximum(np.abs(difference[:, 2]) - errors[1], 0.0)
    least = float(np.hypot(level / axes[0], upright / axes[1]).min())
    return [f"{who} are proven apart, but come to {least:.9g} within their errors"] if least < 1 - 1e-5 else []


def strays(mission: sky.Mission, uav: int, kept: Kept) -> dict[sky.Fault, float]:
    """Return the largest excess of random places within the tracking error of positions over what they must keep."""
    vehicle = mission.scenario.uavs[uav]
    error = vehicle.tracking_error
    if error == sky.TrackingError() or not len(kept.positions):
        return {}
    rng = np.random.default_rng(uav)
    nominal = np.repeat(kept.positions[:: len(kept.positions) // 20_000 + 1], PER_INSTANT, axis=0)
    turn = rng.uniform(0, 2 * np.pi, len(nominal))
    aside = error.horizontal * rng.choice([1.0, 1.0, 0.5], len(nominal))
    up = error.vertical * rng.choice([-1.0, 1.0, 0.3], len(nominal))
    strayed = nominal + np.column_stack([aside * np.cos(turn), aside * np.sin(turn), up])
    still = np.zeros_like(strayed)
    found = excess(kept.scenario, vehicle, Motion(strayed, still, still, still))
    worst = {fault: found[fault].max() for fault in (sky.Fault.TRAJECTORY_BOUNDS, sky.Fault.TRAJECTORY_CLEARANCE)}
    if kept.foot is not None:
        steep = too_near_steep_ground(mission, kept.foot, strayed)
        worst[sky.Fault.TRAJECTORY_CLEARANCE] = max(worst[sky.Fault.TRAJECTORY_CLEARANCE], steep)
    return worst
