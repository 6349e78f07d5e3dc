"""Surveys flown: photo lines become legs of tours between their ends, and the tours a mission that takes the photos."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from skyverse.errors import InputError
from skyverse.mission.leg_planning import Ends
from skyverse.mission.tours import REASONS
from skyverse.model.coverage import CoverageGap
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario, Target
from skyverse.model.sortie import Sortie, Strip
from skyverse.survey import lines_of
from skyverse.survey.flying import flying
from skyverse.survey.lines import PhotoLine

SETTLE = 3.0
"""Seconds for which a UAV stands still for a photo, as files tell autopilots with an acceptance radius of a metre."""


@dataclass(frozen=True, eq=False)
class SurveyFlights:
    """The surveys of a scenario as tours among more targets: the ends of photo lines.

    Attributes
    ----------
    scenario, staged
        What was given, and the same without surveys, whose last targets are the ends of lines.
    ways
        The lines, in each direction in which they may be flown, by the targets at their ends.
    ends
        The line at each of the targets that were added.
    unseen
        What no line sees.
    """

    scenario: Scenario
    staged: Scenario
    ways: Mapping[Ends, PhotoLine] = field(default_factory=dict)
    ends: tuple[PhotoLine, ...] = ()
    unseen: tuple[CoverageGap, ...] = ()

    def as_asked(self, mission: Mission) -> Mission:
        """Return a mission of the staged scenario as one of that which was given: its surveys are strips of sorties."""
        if not self.ends and not self.scenario.surveys:
            return mission
        count = len(self.scenario.targets)
        sorties = tuple(tuple(map(self._asked, own)) for own in mission.sorties)
        last = (next((v.target for sortie in own[::-1] for v in sortie.visits[::-1]), None) for own in sorties)
        lost = {self.ends[one.target - count]: one.why for one in mission.unvisited if one.target >= count}
        missed = {id(line): _not_flown(line, self._why(line, why)) for line, why in lost.items()}
        return replace(
            mission,
            scenario=self.scenario,
            assignment=tuple(last),
            sorties=sorties,
            unvisited=tuple(one for one in mission.unvisited if one.target < count),
            unseen=(*self.unseen, *missed.values()),
        )

    def _why(self, line: PhotoLine, why: str) -> str:
        """Return why nobody flies a line: by what tours tell, or that it is too long, or aeroplanes too fast for it."""
        from skyverse.survey.ground_survey import GroundSurvey

        if why == REASONS["battery"] and len(line.path) > 1:
            length = float(np.linalg.norm(np.diff(line.path, axis=0), axis=1).sum())
            return f"no battery gives what it takes to go there, to fly along its {length:.3g} m, and to come back"
        task, most = GroundSurvey(self.scenario, line.survey), self.scenario.max_height
        slowest = min(0.0 if uav.fixed_wing is None else uav.fixed_wing.speed for uav in task.uavs)
        if slowest <= line.speed:
            return why
        apart = task.survey.camera.min_interval * slowest
        why = f"an aeroplane at {slowest:g} m/s flies {apart:.3g} m from photo to photo, too far to overlap"
        asked = task.survey.distance * math.sin(math.radians(-task.survey.pitch))
        if most is not None and task.room < asked:
            why += (
                f", as the ceiling of {most:g} m leaves {task.room:.3g} m above ground of the {asked:.3g} m asked for"
            )
        return why

    def _asked(self, sortie: Sortie) -> Sortie:
        count, strips = len(self.scenario.targets), list(sortie.strips)
        for visit in sortie.visits:
            line = None if visit.target < count else self.ends[visit.target - count]
            if line is not None and len(line.path) == 1:
                t = visit.departure
                strips.append(Strip(line.survey, t, t, line.every, line.pitch, line.heading))
        visits = tuple(visit for visit in sortie.visits if visit.target < count)
        return replace(sortie, visits=visits, strips=tuple(sorted(strips, key=lambda strip: strip.begin)))


def survey_flights(scenario: Scenario) -> SurveyFlights:
    """Plan the photo lines of a scenario's surveys, if it has any, and return them as parts of tours."""
    if not scenario.surveys:
        return SurveyFlights(scenario, scenario)
    for survey in scenario.surveys:
        wing = next((uav.name for uav in flying(scenario, survey) if uav.fixed_wing is not None), None)
        if survey.trigger == "point" and wing is not None:
            said = f"{wing} is an aeroplane, which cannot stand still at points; take photos by distance or time"
            raise InputError(said, field="trigger")
    found = [lines_of(scenario, number) for number in range(len(scenario.surveys))]
    targets, ways, ends = list(scenario.targets), dict[Ends, PhotoLine](), list[PhotoLine]()
    stays = [SETTLE if survey.trigger == "point" else 0.0 for survey in scenario.surveys]
    for line in (replace(line, stay=stays[line.survey]) for one in found for line in one.lines):
        first, uavs, alone = len(targets), scenario.surveys[line.survey].uavs, len(line.path) == 1
        aim = {"heading": (line.heading or 0.0) % 360.0, "stay": SETTLE} if alone else {}
        for place in line.path if alone else line.path[[0, -1]]:
            name = f"survey line end {len(ends) + 1}"
            targets.append(Target(name=name, position=tuple(place.tolist()), uavs=uavs, **aim))
            ends.append(line)
        if not alone:
            ways[first, first + 1] = line
            if line.both_ways:
                ways[first + 1, first] = replace(line, path=np.ascontiguousarray(line.path[::-1]))
    staged = derived(scenario, targets=tuple(targets), surveys=())
    return SurveyFlights(scenario, staged, ways, tuple(ends), tuple(gap for one in found for gap in one.unseen))


def _not_flown(line: PhotoLine, why: str) -> CoverageGap:
    """Return what is missed by a line that nobody flies, told by the line itself."""
    return CoverageGap(line.survey, tuple((float(x), float(y)) for x, y, _ in line.path), 0.0, f"not flown: {why}")
