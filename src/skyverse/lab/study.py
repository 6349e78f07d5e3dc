"""Studies: scenarios x planners x budgets x seeds, or scenarios x movers x policies x seeds; objects and files."""

import dataclasses
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PlainSerializer, ValidationError, model_validator

from skyverse.atomic import write_text
from skyverse.documents.yaml import yaml_text
from skyverse.errors import InputError, path_of
from skyverse.files import BUILTIN_NAMES, read_scenario
from skyverse.files.document import explained, parse, read_text
from skyverse.lab.job import USUAL_SENSOR, Case, Contender, Encounters, Job
from skyverse.lab.study_parts import (
    Budget,
    Seeds,
    StudyObjective,
    StudyPlanner,
    StudyPolicy,
    StudyScenario,
    StudyScenarios,
    as_settings,
    as_tuple,
    label_of,
    named_by,
    one_or_list,
    refuse_doubles,
)
from skyverse.mission.assignment import Assignment
from skyverse.model.conditions import Sensor
from skyverse.model.quantities import Model, derived
from skyverse.model.scenario import Scenario
from skyverse.model.timed_shapes import temporary_zones
from skyverse.planners.objective import PathObjective
from skyverse.planners.waypoints import WaypointSearch
from skyverse.stop import Stop

_ONLY_PLANNERS = {"budget", "objective"}
_ONLY_POLICIES = {"movers", "sensor", "longest"}


class Study(Model, strict=True, allow_inf_nan=False):
    """A comparison: all planners on all scenarios, with all budgets and seeds; or policies among movers.

    Attributes
    ----------
    name
        The study's title.
    scenarios
        Built-in names or files, or ``{"label": ..., "file": ...}``.
    planners
        Names, planners, or ``{"planner": ..., "label": ..., settings ...}``; a planner of one's own is a class at the
        top of a module, named ``"module:Class"``. Exact planners, which depend on neither budget nor
        seed, are also run for each of them, so that every planner has the same number of rows.
    policies
        Instead of planners, how missions are replanned in flight: names, or ``{"policy": ..., "label": ..., settings
        ...}``: ``default`` (the `Replanner`), ``from-scratch`` (a planner asked anew at each observation),
        ``kept-population`` (one that begins with its last population), ``velocity-obstacles``, ``wait``, and
        ``known-beforehand`` (planned with all movers known, which no policy has).
    movers
        Kinds of movers, by name, or ``{"kind": ..., "count": ..., "speed": ..., "hidden": ..., "label": ...}``.
    seeds
        The number of seeds, counted from 0, or a list of seeds. For policies a seed makes the movers, the sensor's
        errors and the policy's random numbers.
    budget
        The limit of each UAV's search, one of ``paths``, ``nodes``, ``evaluations``, ``iterations`` or ``seconds``, or
        a list of limits. Seconds are turned into paths by a pilot run.
    assignment
        How targets are assigned to UAVs; see `plan_mission`.
    objective
        A `PathObjective` of one's own, ``"module:Class"`` or ``{"objective": ..., settings ...}``: waypoint planners
        minimise it, and the paths of all others are priced by it.
    sensor
        What UAVs see with.
    longest
        Seconds after which a flight is given up.
    """

    format: Literal["skyverse/study/1"] = "skyverse/study/1"
    name: Annotated[str, Field(min_length=1)] = "study"
    scenarios: StudyScenarios
    planners: Annotated[
        tuple[Annotated[StudyPlanner, named_by("planner"), BeforeValidator(as_settings)], ...],
        BeforeValidator(as_tuple),
        Field(min_length=1),
    ] = Field(default=(), validate_default=False)
    policies: Annotated[
        tuple[Annotated[StudyPolicy, named_by("policy")], ...], BeforeValidator(as_tuple), Field(min_length=1)
    ] = Field(default=(), validate_default=False)
    movers: Annotated[
        tuple[Annotated[Encounters, named_by("kind")], ...], BeforeValidator(as_tuple), Field(min_length=1)
    ] = Field(default=(), validate_default=False)
    seeds: Seeds = 30  # type: ignore[assignment]
    budget: Annotated[
        tuple[Budget, ...],
        BeforeValidator(as_tuple),
        PlainSerializer(one_or_list),
        Field(min_length=1, validate_default=True),
    ] = {"paths": 1000}  # type: ignore[assignment]
    assignment: Assignment = "path-cost"
    objective: Annotated[StudyObjective | None, named_by("objective"), BeforeValidator(as_settings)] = None
    sensor: Sensor = USUAL_SENSOR
    longest: Annotated[float, Field(gt=0, le=3600, strict=False)] = 60.0

    @model_validator(mode="after")
    def _of_one_kind(self) -> Self:
        if bool(self.planners) == bool(self.policies):
            raise ValueError("expected either planners, or policies and movers")
        if self.policies and not self.movers:
            raise ValueError("expected movers, among which policies replan")
        others = sorted(self.model_fields_set & (_ONLY_PLANNERS if self.policies else _ONLY_POLICIES))
        if others:
            kind = "policies" if self.policies else "planners"
            raise ValueError(f"expected no {' and no '.join(others)} in a study of {kind}")
        return self

    @model_validator(mode="after")
    def _unlike(self) -> Self:
        refuse_doubles("labels of scenarios", [given.label for given in self.scenarios])
        refuse_doubles("labels of planners", [contender.label for contender in self.planners])
        refuse_doubles("labels of policies", [contender.label for contender in self.policies])
        refuse_doubles("labels of movers", [given.label for given in self.movers])
        refuse_doubles("budget", [budget.label for budget in self.budget])
        refuse_doubles("seeds", self.seeds)
        return self

    @property
    def contenders(self) -> tuple[StudyPlanner | StudyPolicy, ...]:
        """The planners or the policies."""
        return self.planners or self.policies

    def jobs(self) -> Iterator[Job]:
        """Read the scenarios, and yield one job for each run.

        Raises
        ------
        InputError
            If a scenario cannot be read, or has no UAV or no target. For planners, if it has movers or zones with
            active times, or has costs in a unit that not all of them share. For policies, if it has zones with active
            times or a limit of speed, or fewer obstacles than are to be hidden.
        """
        objective = self.objective.make() if self.objective else None
        budgets: list[tuple[Stop | None, str]] = [(budget.stop, budget.label) for budget in self.budget]
        if self.policies:
            cases = [self._flown_case(given, movers) for given in self.scenarios for movers in self.movers]
            budgets = [(None, f"{self.longest:g} s of flight")]
        else:
            cases = [self._planned_case(given, objective) for given in self.scenarios]
        for case in cases:
            for contender in self.contenders:
                made: Contender = contender.make()
                if isinstance(made, WaypointSearch) and made.objective != objective:
                    if made.objective is not None:
                        raise InputError(
                            f"{contender.label}: expected the study's objective, by which all planners are compared, "
                            f"found {made.objective!r}"
                        )
                    made = dataclasses.replace(made, objective=objective)
                for stop, budget in budgets:
                    for seed in self.seeds:
                        yield Job(case, made, contender.label, stop, budget, seed, objective)

    def _planned_case(self, given: StudyScenario, objective: PathObjective | None) -> Case:
        scenario = _read(given)
        _refuse_tours(given, scenario)
        if objective is None:
            self._refuse_two_units(scenario)
        if scenario.movers:
            raise InputError(
                f"{scenario.name}: movers: expected none, since studies compare paths, which have no times, "
                f"found {len(scenario.movers)}"
            )
        for number in temporary_zones(scenario):
            raise InputError(
                f"{scenario.name}: zones[{number}].active: expected none, since studies compare paths, which have no "
                "times"
            )
        return Case(given.label, scenario, self.assignment)

    def _flown_case(self, given: StudyScenario, movers: Encounters) -> Case:
        scenario = _read(given)
        _refuse_tours(given, scenario)
        if len(scenario.targets) > len(scenario.uavs) and self.assignment == "path-cost":
            raise InputError(
                f"{given.file}: targets: expected no more than UAVs, each with one, or another assignment, "
                f"found {len(scenario.targets)}, which make tours"
            )
        for number, zone in enumerate(scenario.zones):
            if zone.max_speed is not None or zone.active is not None:
                raise InputError(
                    f"{given.file}: zones[{number}]: expected no limit of speed and no active times, which replanning "
                    "policies do not keep"
                )
        if movers.hidden > len(scenario.obstacles):
            raise InputError(
                f"{given.file}: obstacles: expected {movers.hidden} or more, of which so many are hidden, "
                f"found {len(scenario.obstacles)}"
            )
        return Case(f"{given.label}: {movers.label}", scenario, self.assignment, movers, self.sensor, self.longest)

    def _refuse_two_units(self, scenario: Scenario) -> None:
        off = [contender.label for contender in self.planners if contender.make().leaves_lattice(scenario)]
        if scenario.objective.unit == "nodes" and 0 < len(off) < len(self.planners):
            raise InputError(
                f"{scenario.name}: objective.unit: expected 'metres' to compare {' and '.join(off)} with planners "
                "on the lattice, found 'nodes', which paths of straight legs have none of"
            )

    def seen_from(self, folder: Path) -> Self:
        """Return the study with the paths of its scenarios' files relative to `folder`."""
        return self.with_files(lambda file: Path(os.path.relpath(file, folder)).as_posix())

    def with_files(self, moved: Callable[[str], str]) -> Self:
        """Return the study with the paths of its scenarios' files moved."""
        given = (
            each if each.file in BUILTIN_NAMES else derived(each, file=moved(each.file)) for each in self.scenarios
        )
        return derived(self, scenarios=tuple(given))


def _refuse_tours(given: StudyScenario, scenario: Scenario) -> None:
    """Raise `InputError` where UAVs would return, or targets ask for more than that one UAV flies there."""
    if scenario.asks_for_tours:
        raise InputError(f"{given.file}: expected UAVs that each fly to one target and stay there, found tours")


def read_study(path: str | Path) -> Study:
    """Read a study file, YAML or JSON; the paths of scenarios in it are relative to the file."""
    path = path_of(path)
    return study_from_data(path, parse(path, read_text(path)), path.parent)


def study_from_data(source: object, data: Any, folder: Path = Path()) -> Study:
    """Return the study that `data` describes, or raise `InputError`; paths of scenarios are relative to `folder`."""
    if not isinstance(data, dict):
        raise InputError(
            f"{source}: expected a study, a mapping with the key 'scenarios' and others, found {data!r:.40}"
        )
    try:
        study = Study.model_validate(data)
    except ValidationError as error:
        parts = (Study, StudyScenario, StudyPlanner, StudyPolicy, Encounters, Budget, Sensor)
        raise explained(source, error, data, {name for part in parts for name in part.model_fields}) from None
    return study.with_files(lambda file: str(folder / file))


def write_study(study: Study, path: Path) -> None:
    """Write a study file from which `read_study` reads an equal study.

    Raises
    ------
    InputError
        If a planner or the objective is of a class in the script that runs, which no file can name.
    """
    for own in (*(contender.planner for contender in study.planners), study.objective and study.objective.objective):
        if own and own.startswith(("__main__:", "__mp_main__:")):
            raise InputError(f"{path}: expected classes in modules of their own, which a file can name, found {own!r}")
    others = {"planners", *_ONLY_PLANNERS} if study.policies else {"policies", *_ONLY_POLICIES}
    data = study.seen_from(path.parent).model_dump(mode="json", exclude=others)
    if data.get("objective", "") is None:
        del data["objective"]
    for part, key in (("scenarios", "file"), ("planners", "planner"), ("policies", "policy")):
        things = data.get(part, [])
        for k, thing in enumerate(things):
            if thing["label"] == label_of(thing[key]) and len(thing) == 2:
                things[k] = thing[key]
    write_text(path, yaml_text(data))


def _read(given: StudyScenario) -> Scenario:
    scenario = read_scenario(given.file)
    for kind, things in (("uavs", scenario.uavs), ("targets", scenario.targets)):
        if not things:
            raise InputError(f"{given.file}: {kind}: there are none")
    return scenario
