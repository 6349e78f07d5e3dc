"""The parts of a study's file, many of which may be written short: scenarios, planners, movers, policies, budgets."""

import dataclasses
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, PlainSerializer, model_validator

from skyverse.errors import InputError
from skyverse.files import BUILTIN_NAMES
from skyverse.lab.code_versions import code_digest, settings_of
from skyverse.lab.job import KnownBeforehand, OwnReplanner
from skyverse.live.policies import POLICIES, make_policy
from skyverse.live.policies.policy import Policy
from skyverse.model.quantities import Model, derived
from skyverse.planners import make_own, make_planner, name_of
from skyverse.planners.base import Planner
from skyverse.planners.objective import PathObjective
from skyverse.stop import MaxEvaluations, MaxIterations, MaxNodes, MaxPaths, MaxSeconds, Stop


class StudyScenario(Model, strict=True, allow_inf_nan=False):
    """A scenario, by built-in name or file, and its label, which by default is the name or the stem of the file."""

    label: str = ""
    file: str

    @model_validator(mode="after")
    def _labelled(self) -> Self:
        return self if self.label else derived(self, label=label_of(self.file))


class MadeByName(Model, ABC, extra="allow", strict=True):
    """What is made by its name and settings, and its label, which by default is the name followed by the settings."""

    label: str = ""

    @abstractmethod
    def make(self) -> Any:
        """Return it, or raise `InputError` where a setting is wrong."""

    @property
    def settings(self) -> dict[str, Any]:
        """Its settings."""
        return self.model_extra or {}

    @model_validator(mode="after")
    def _made(self) -> Self:
        made = self.make()
        code_digest(settings_of(made), made)  # as it is imported
        if self.label:
            return self
        (name,) = (value for key, value in self if key not in ("label", *self.settings))
        settings = (f"{key}={value}" for key, value in self.settings.items())
        return derived(self, label=" ".join([name.rpartition(":")[2], *settings]))  # of an own one its class


Count = Annotated[int, Field(ge=1)]


def label_of(name: str) -> str:
    """Return the label of a scenario or a planner by its name or file."""
    return name if name in BUILTIN_NAMES else Path(name).stem


def as_tuple(value: Any) -> Any:
    """Return a list as a tuple, and anything else as the only thing in one."""
    return tuple(value) if isinstance(value, list | tuple) else (value,)


MAX_SEEDS = 1_000_000
"""A study has at most so many seeds."""


def seeds_of(value: Any) -> Any:
    """Return the seeds that a number of them, or a list, stands for."""
    if isinstance(value, int) and not isinstance(value, bool):
        if value < 1:
            raise ValueError("expected how many, from 1 on, or a list of seeds")
        if value > MAX_SEEDS:
            raise ValueError(f"expected at most {MAX_SEEDS:,}")
        return tuple(range(value))
    if not isinstance(value, list | tuple):
        raise ValueError("expected how many, or a list of seeds")
    return tuple(value)


def named_by(key: str) -> BeforeValidator:
    """Return what lets a name stand for a mapping with that name under `key`."""
    return BeforeValidator(lambda value: {key: value} if isinstance(value, str) else value)


def count_or_list(seeds: tuple[int, ...]) -> int | list[int]:
    """Return seeds as a study's file has them."""
    return len(seeds) if seeds == tuple(range(len(seeds))) else list(seeds)


Seeds = Annotated[
    tuple[Annotated[int, Field(ge=0)], ...],
    BeforeValidator(seeds_of),
    PlainSerializer(count_or_list),
    Field(min_length=1, validate_default=True),
]
"""The number of seeds, counted from 0, or a list of seeds."""
StudyScenarios = Annotated[
    tuple[Annotated[StudyScenario, named_by("file")], ...], BeforeValidator(as_tuple), Field(min_length=1)
]
"""Built-in names or files, or ``{"label": ..., "file": ...}``."""


def refuse_doubles(noun: str, names: Sequence[object]) -> None:
    """Raise `ValueError` if a name stands there more than once."""
    for name, count in Counter(names).most_common(1):
        if count > 1:
            raise ValueError(f"{noun} must differ, but {name!r} stands {count} times")


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

    def make(self) -> Planner:
        """Return the planner."""
        return make_planner(self.planner, **self.settings)


def as_settings(value: Any) -> Any:
    """Return what a study's file says for a planner or an objective that is given as such."""
    if not isinstance(value, Planner | PathObjective):
        return value
    key = "objective" if isinstance(value, PathObjective) else "planner"
    fields: tuple[Any, ...] = dataclasses.fields(value) if dataclasses.is_dataclass(value) else ()
    settings = {f.name: getattr(value, f.name) for f in fields}
    settings_of(tuple(settings.values()))
    name = name_of(value)
    made = make_own(name, PathObjective, settings) if key == "objective" else make_planner(name, **settings)
    if made != value:
        raise ValueError(f"expected what its settings make anew, a dataclass, found {value!r:.60}")
    return {key: name, **{f.name: settings[f.name] for f in fields if settings[f.name] != f.default}}


class StudyObjective(MadeByName):
    """An objective of one's own by its name, ``"module:Class"``, and its settings."""

    objective: str

    def make(self) -> PathObjective:
        """Return the objective."""
        objective: PathObjective = make_own(self.objective, PathObjective, self.settings)
        return objective


class Budget(Model, strict=True, allow_inf_nan=False):
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


def one_or_list(budgets: tuple[Budget, ...]) -> Any:
    """Return budgets as a study's file has them."""
    said = [budget.model_dump(exclude_unset=True) for budget in budgets]
    return said[0] if len(said) == 1 else said


_CONTENDERS = {"default": OwnReplanner, "known-beforehand": KnownBeforehand}


class StudyPolicy(MadeByName):
    """A policy by name, its settings, and its label."""

    policy: str

    def make(self) -> Policy | OwnReplanner | KnownBeforehand:
        """Return the policy."""
        if self.policy in _CONTENDERS and self.settings:
            raise InputError(f"there is no setting {', '.join(map(repr, self.settings))}; {self.policy!r} has none")
        if self.policy in _CONTENDERS:
            return _CONTENDERS[self.policy]()
        if self.policy not in POLICIES:
            names = ", ".join([*_CONTENDERS, *POLICIES])
            raise InputError(f"there is no policy {self.policy!r}; there are {names}")
        return make_policy(self.policy, **self.settings)
