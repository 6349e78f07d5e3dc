"""Studies: scenarios x planners x budgets x seeds, as objects and as files."""

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PlainSerializer, ValidationError, model_validator

from skyverse.atomic import write_text
from skyverse.documents.yaml import yaml_text
from skyverse.errors import InputError, path_of
from skyverse.files import read_scenario
from skyverse.files.document import explained, parse, read_text
from skyverse.lab.code_digest import settings_of
from skyverse.lab.run_job import Case, Job
from skyverse.lab.study_fields import (
    Count,
    MadeByName,
    ScenarioStudy,
    Seeds,
    StudyModel,
    StudyScenario,
    as_tuple,
    label_of,
    named_by,
    refuse_doubles,
)
from skyverse.mission.plan_mission import Assignment
from skyverse.model.scenario import Scenario
from skyverse.model.temporary_zones import temporary_zones
from skyverse.planners import make_planner, name_of, own_class
from skyverse.planners.base import Planner
from skyverse.planners.objective import PathObjective
from skyverse.planners.waypoints import WaypointSearch
from skyverse.stop import MaxEvaluations, MaxIterations, MaxNodes, MaxPaths, MaxSeconds, Stop

_RULES = {
    "paths": MaxPaths,
    "nodes": MaxNodes,
    "evaluations": MaxEvaluations,
    "iterations": MaxIterations,
    "seconds": MaxSeconds,
}


class StudyPlanner(MadeByName):
    """A planner by name, its settings, and its label."""

    planner: str

    @property
    def name(self) -> str:
        """The planner's name, of an own one that of its class."""
        return self.planner.rpartition(":")[2]

    def make(self) -> Planner:
        """Return the planner."""
        return make_planner(self.planner, **self.settings)


def _said(value: Any) -> Any:
    """Return what a study's file says for a planner or an objective that is given as such."""
    if not isinstance(value, Planner | PathObjective):
        return value
    key = "objective" if isinstance(value, PathObjective) else "planner"
    fields: tuple[Any, ...] = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    settings = {f.name: getattr(value, f.name) for f in fields}
    settings_of(tuple(settings.values()))
    name = name_of(value)
    made = own_class(name, PathObjective)(**settings) if key == "objective" else make_planner(name, **settings)
    if made != value:
        raise ValueError(f"expected what its settings make anew, a dataclass, found {value!r:.60}")
    return {key: name, **{f.name: settings[f.name] for f in fields if settings[f.name] != f.default}}


class StudyObjective(MadeByName):
    """An objective of one's own by its name, ``"module:Class"``, and its settings."""

    objective: str

    @property
    def name(self) -> str:
        """The name of its class."""
        return self.objective.rpartition(":")[2]

    def make(self) -> PathObjective:
        """Return the objective."""
        objective: PathObjective = own_class(self.objective, PathObjective)(**self.settings)
        return objective


class Budget(StudyModel):
    """The budget of each UAV's search: exactly one of these limits."""

    paths: Count | None = None
    nodes: Count | None = None
    evaluations: Count | None = None
    iterations: Count | None = None
    seconds: Annotated[float, Field(gt=0, strict=False)] | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self.model_fields_set) != 1 or self._amount is None:
            raise ValueError(f"expected one of {', '.join(_RULES)} in each budget")
        return self

    @property
    def _unit(self) -> str:
        return next(iter(self.model_fields_set))

    @property
    def _amount(self) -> Any:
        return getattr(self, self._unit)

    @property
    def label(self) -> str:
        """The label of the budget in rows, such as ``"1000 paths"`` or ``"0.1 seconds"``."""
        return f"{self._amount} {self._unit}"

    @property
    def stop(self) -> Stop:
        """The rule that ends a search."""
        return _RULES[self._unit](self._amount)


def _one_or_list(budgets: tuple[Budget, ...]) -> Any:
    said = [budget.model_dump(exclude_unset=True) for budget in budgets]
    return said[0] if len(said) == 1 else said


class Study(ScenarioStudy):
    """A comparison: all planners on all scenarios, with all budgets and seeds.

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
    seeds
        The number of seeds, counted from 0, or a list of seeds.
    budget
        The limit of each UAV's search, one of ``paths``, ``nodes``, ``evaluations``, ``iterations`` or ``seconds``, or
        a list of limits. Seconds are turned into paths by a pilot run.
    assignment
        How targets are assigned to UAVs; see `plan_mission`.
    objective
        A `PathObjective` of one's own, ``"module:Class"`` or ``{"objective": ..., settings ...}``: waypoint planners
        minimise it, and the paths of all others are priced by it.
    """

    format: Literal["skyverse/study/1"] = "skyverse/study/1"
    planners: Annotated[
        tuple[Annotated[StudyPlanner, named_by("planner"), BeforeValidator(_said)], ...],
        BeforeValidator(as_tuple),
        Field(min_length=1),
    ]
    seeds: Seeds = 30  # type: ignore[assignment]
    budget: Annotated[
        tuple[Budget, ...],
        BeforeValidator(as_tuple),
        PlainSerializer(_one_or_list),
        Field(min_length=1, validate_default=True),
    ] = {"paths": 1000}  # type: ignore[assignment]
    assignment: Assignment = "path-cost"
    objective: Annotated[StudyObjective | None, named_by("objective"), BeforeValidator(_said)] = None

    @model_validator(mode="after")
    def _unlike(self) -> Self:
        refuse_doubles("labels of scenarios", [given.label for given in self.scenarios])
        refuse_doubles("labels of planners", [contender.label for contender in self.planners])
        refuse_doubles("budget", [budget.label for budget in self.budget])
        refuse_doubles("seeds", self.seeds)
        return self

    def jobs(self) -> Iterator[Job]:
        """Read the scenarios, and yield one job for each run.

        Raises
        ------
        InputError
            If a scenario cannot be read, has movers or zones with active times, no UAV or no target, or has costs in a
            unit that not all planners share.
        """
        cases = [_case(given, self.assignment) for given in self.scenarios]
        objective = self.objective.make() if self.objective else None
        for case in cases:
            if objective is None:
                self._refuse_two_units(case.scenario)
            if case.scenario.movers:
                raise InputError(
                    f"{case.scenario.name}: movers: expected none, since studies compare paths, which have no times, "
                    f"found {len(case.scenario.movers)}"
                )
            for number in temporary_zones(case.scenario):
                raise InputError(
                    f"{case.scenario.name}: zones[{number}].active: expected none, since studies compare paths, which "
                    "have no times"
                )
            for contender in self.planners:
                planner = contender.make()
                if isinstance(planner, WaypointSearch) and planner.objective != objective:
                    if planner.objective is not None:
                        raise InputError(
                            f"{contender.label}: expected the study's objective, by which all planners are compared, "
                            f"found {planner.objective!r}"
                        )
                    planner = dataclasses.replace(planner, objective=objective)
                for budget in self.budget:
                    for seed in self.seeds:
                        yield Job(case, planner, contender.label, budget.stop, budget.label, seed, objective)

    def _refuse_two_units(self, scenario: Scenario) -> None:
        off = [contender.label for contender in self.planners if contender.make().leaves_lattice(scenario)]
        if scenario.objective.unit == "nodes" and 0 < len(off) < len(self.planners):
            raise InputError(
                f"{scenario.name}: objective.unit: expected 'metres' to compare {' and '.join(off)} with planners "
                "on the lattice, found 'nodes', which paths of straight legs have none of"
            )


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
        known = {*Study.model_fields, *StudyScenario.model_fields, *StudyPlanner.model_fields, *Budget.model_fields}
        raise explained(source, error, data, known) from None
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
    data = study.seen_from(path.parent).model_dump(mode="json")
    if data["objective"] is None:
        del data["objective"]
    for things, key in ((data["scenarios"], "file"), (data["planners"], "planner")):
        for k, thing in enumerate(things):
            if thing["label"] == label_of(thing[key]) and len(thing) == 2:
                things[k] = thing[key]
    write_text(path, yaml_text(data))


def _case(given: StudyScenario, assignment: Assignment) -> Case:
    scenario = read_scenario(given.file)
    for kind, things in (("uavs", scenario.uavs), ("targets", scenario.targets)):
        if not things:
            raise InputError(f"{given.file}: {kind}: there are none")
    return Case(given.label, scenario, assignment)
