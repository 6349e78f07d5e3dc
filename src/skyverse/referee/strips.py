"""Judges the strips of sorties, which may be malformed, and the photos that are taken along those that are sound."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.model.coverage import Coverage
from skyverse.model.mission import Mission
from skyverse.model.photos import photo_times, photos_of
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Sortie, Strip
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.coverage import judge_coverage
from skyverse.referee.curve import curve_of
from skyverse.referee.sorties import sound_sorties
from skyverse.referee.tolerances import HASTE, LEAST_EVERY, SAME_INSTANT
from skyverse.referee.untrusted import entry


def judge_strips(scenario: Scenario, mission: Mission, uav: int, trajectory: Trajectory) -> Iterator[Violation]:
    """Yield what is wrong with the strips of a UAV's flight."""
    name = scenario.uavs[uav].name
    for sortie in sound_sorties(mission, uav):
        for strip in sortie.strips:
            wrong = _wrong_strip(scenario, uav, trajectory, strip, sortie)
            if wrong:
                yield Violation(Fault.STRIP, (uav,), f"{name}'s strip at t = {strip.begin:.6g} s {wrong}.", strip.begin)
        for one, following in pairwise(sortie.strips):
            if not one.end <= following.begin + SAME_INSTANT:
                message = f"{name}'s strip at t = {following.begin:.6g} s begins before the one before it ends."
                yield Violation(Fault.STRIP, (uav,), message, following.begin)


def _wrong_strip(scenario: Scenario, uav: int, trajectory: Trajectory, strip: Strip, sortie: Sortie) -> str:
    """Say what is wrong with a strip; nothing where all is right."""
    if isinstance(strip.survey, bool) or not 0 <= strip.survey < len(scenario.surveys):
        return "is of a survey that does not exist"
    survey = scenario.surveys[strip.survey]
    if survey.uavs and scenario.uavs[uav].name not in survey.uavs:
        return f"is not its own: only {', '.join(survey.uavs)} may fly {survey.name}"
    begin, end = max(sortie.begin, trajectory.start), min(sortie.end, trajectory.end)
    if not begin - SAME_INSTANT <= strip.begin <= strip.end <= end + SAME_INSTANT:
        return "is not within its sortie"
    if strip.every < 0 or 0 < strip.every < LEAST_EVERY:
        return f"has photos every {strip.every:g} m"
    between: Floats = np.diff(photo_times(trajectory, strip))
    if len(between) and not between.min() >= survey.camera.min_interval * (1 - HASTE):
        return f"has photos {between.min():.3g} s apart, sooner than the camera's {survey.camera.min_interval:g} s"
    return ""


def judge_surveys(scenario: Scenario, mission: Mission) -> tuple[Coverage, ...]:
    """Judge what a mission's photos show of each survey; only photos of strips count with which nothing is wrong.

    What they do not show is no fault of the flight, which is as safe without it: the coverage tells it.
    """
    if not scenario.surveys:
        return ()
    flown = range(len(scenario.uavs))
    trajectories = tuple(entry(mission.trajectories, uav) for uav in flown)
    sound = tuple(t if isinstance(t, Trajectory) and not isinstance(curve_of(t), str) else None for t in trajectories)
    sorties = []
    for uav, trajectory in enumerate(sound):
        kept = []
        for one in sound_sorties(mission, uav):
            if trajectory is None:
                break
            strips = (strip for strip in one.strips if not _wrong_strip(scenario, uav, trajectory, strip, one))
            kept.append(replace(one, strips=tuple(strips)))
        sorties.append(tuple(kept))
    stated = replace(mission, scenario=scenario, trajectories=sound, sorties=tuple(sorties))
    errors = [uav.tracking_error for uav in scenario.uavs]
    return tuple(judge_coverage(scenario, k, photos_of(stated, k), errors) for k in range(len(scenario.surveys)))
