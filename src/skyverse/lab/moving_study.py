"""Studies of replanning among movers: scenarios x movers x policies x seeds, as objects and as files."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from skyverse.atomic import write_text
from skyverse.documents.yaml import yaml_text
from skyverse.errors import InputError, path_of
from skyverse.files import read_scenario
from skyverse.files.document import explained, parse, read_text
from skyverse.lab.fly_job import Contender, KnownBeforehand, MovingCase, MovingJob, OwnReplanner
from skyverse.lab.study_fields import (
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
from skyverse.live.policies import POLICY_NAMES, make_policy
from skyverse.model.quantities import derived
from skyverse.model.sensor import Sensor
from skyverse.samples.movers import MoverKind

_CONTENDERS = {"default": OwnReplanner, "known-beforehand": KnownBeforehand}


class StudyMovers(StudyModel):
    """What moves in a flight: random movers, which the seed makes, and obstacles that nobody knows of beforehand.

    Attributes
    ----------
    kind, count, speed
        As those of `random_movers`.
    hidden
        How many of the scenario's obstacles are not known beforehand; the seed draws which.
    label
        By default the other fields in words.
    """

    label: str = ""
    kind: MoverKind = "spinners"
    count: Annotated[int, Field(ge=0)] = 10
    speed: Annotated[float, Field(ge=1e-3, le=1e3, strict=False)] = 1.0
    hidden: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _labelled(self) -> Self:
        walls = f", {self.hidden} hidden" if self.hidden else ""
        told = f"{self.count} {self.kind} at {self.speed:g} m/s{walls}"
        return self if self.label else derived(self, label=told)


class StudyPolicy(MadeByName):
    """A policy by name, its settings, and its label."""

    policy: str

    @property
    def name(self) -> str:
        """The policy's name."""
        return self.policy

    def make(self) -> Contender:
        """Return the policy."""
        if self.policy in _CONTENDERS and self.settings:
            raise InputError(f"there is no setting {', '.join(map(repr, self.settings))}; {self.policy!r} has none")
        if self.policy in _CONTENDERS:
            return _CONTENDERS[self.policy]()
        if self.policy not in POLICY_NAMES:
            names = ", ".join([*_CONTENDERS, *POLICY_NAMES])
            raise InputError(f"there is no policy {self.policy!r}; there are {names}")
        return make_policy(self.policy, **self.settings)


class MovingStudy(ScenarioStudy):
    """A comparison of replanning policies: each on all scenarios, among all movers, with all seeds.

    Attributes
    ----------
    name
        The study's title.
    scenarios
        Built-in names or files, or ``{"label": ..., "file": ...}``.
    movers
        Kinds of movers, by name, or ``{"kind": ..., "count": ..., "speed": ..., "hidden": ..., "label": ...}``.
    policies
        Names, or ``{"policy": ..., "label": ..., settings ...}``: ``default`` (the `Replanner`), ``from-scratch`` (a
        planner asked anew at each observation), ``kept-population`` (one that begins with its last population),
        ``velocity-obstacles``, ``wait``, and ``known-beforehand`` (planned
        with all movers known, which no policy has).
    seeds
        The number of seeds, counted from 0, or a list of seeds. A seed makes the movers, the sensor's errors and the
        policy's random numbers.
    sensor
        What UAVs see with.
    longest
        Seconds after which a flight is given up.
    """

    format: Literal["skyverse/moving-study/1"] = "skyverse/moving-study/1"
    movers: Annotated[
        tuple[Annotated[StudyMovers, named_by("kind")], ...], BeforeValidator(as_tuple), Field(min_length=1)
    ]
    policies: Annotated[
        tuple[Annotated[StudyPolicy, named_by("policy")], ...], BeforeValidator(as_tuple), Field(min_length=1)
    ]
    seeds: Seeds = 20  # type: ignore[assignment]
    sensor: Sensor = Sensor(range=8.0)
    longest: Annotated[float, Field(gt=0, le=3600, strict=False)] = 60.0

    @model_validator(mode="after")
    def _unlike(self) -> Self:
        refuse_doubles("labels of scenarios", [given.label for given in self.scenarios])
        refuse_doubles("labels of movers", [given.label for given in self.movers])
        refuse_doubles("labels of policies", [contender.label for contender in self.policies])
        refuse_doubles("seeds", self.seeds)
        return self

    def jobs(self) -> Iterator[MovingJob]:
        """Read the scenarios, and yield one job for each flight.

        Raises
        ------
        InputError
            If a scenario cannot be read, has no UAV or no target, has zones with active times or a limit of speed, or
            has fewer obstacles than are to be hidden.
        """
        for case in [self._case(given, movers) for given in self.scenarios for movers in self.movers]:
            for contender in self.policies:
                for seed in self.seeds:
                    yield MovingJob(case, contender.make(), contender.label, seed)

    def _case(self, given: StudyScenario, movers: StudyMovers) -> MovingCase:
        scenario = read_scenario(given.file)
        for kind, things in (("uavs", scenario.uavs), ("targets", scenario.targets)):
            if not things:
                raise InputError(f"{given.file}: {kind}: there are none")
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
        return MovingCase(
            label=given.label,
            movers_label=movers.label,
            scenario=scenario,
            kind=movers.kind,
            count=movers.count,
            speed=movers.speed,
            hidden=movers.hidden,
            sensor=self.sensor,
            longest=self.longest,
        )


def read_moving_study(path: str | Path) -> MovingStudy:
    """Read the file of a study among movers, YAML or JSON; the paths of scenarios in it are relative to the file."""
    path = path_of(path)
    return moving_study_from_data(path, parse(path, read_text(path)), path.parent)


def moving_study_from_data(source: object, data: Any, folder: Path = Path()) -> MovingStudy:
    """Return the study that `data` describes, or raise `InputError`; paths of scenarios are relative to `folder`."""
    if not isinstance(data, dict):
        raise InputError(
            f"{source}: expected a study, a mapping with the key 'scenarios' and others, found {data!r:.40}"
        )
    try:
        study = MovingStudy.model_validate(data)
    except ValidationError as error:
        parts = (MovingStudy, StudyScenario, StudyMovers, StudyPolicy, Sensor)
        raise explained(source, error, data, {name for part in parts for name in part.model_fields}) from None
    return study.with_files(lambda file: str(folder / file))


def write_moving_study(study: MovingStudy, path: Path) -> None:
    """Write a study file from which `read_moving_study` reads an equal study."""
    data = study.seen_from(path.parent).model_dump(mode="json")
    for things, key in ((data["scenarios"], "file"), (data["policies"], "policy")):
        for k, thing in enumerate(things):
            if thing["label"] == label_of(thing[key]) and len(thing) == 2:
                things[k] = thing[key]
    write_text(path, yaml_text(data))
