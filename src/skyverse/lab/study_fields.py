"""What the files of all studies have: scenarios with labels, seeds, and lists that may be written short."""

import os
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, ConfigDict, Field, PlainSerializer, model_validator

from skyverse.files import BUILTIN_NAMES
from skyverse.lab.code_digest import code_digest, settings_of
from skyverse.model.quantities import Model, derived


class StudyModel(Model):
    """A part of a study's file."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class StudyScenario(StudyModel):
    """A scenario, by built-in name or file, and its label, which by default is the name or the stem of the file."""

    label: str = ""
    file: str

    @model_validator(mode="after")
    def _labelled(self) -> Self:
        return self if self.label else derived(self, label=label_of(self.file))


class MadeByName(Model, ABC):
    """What is made by its name and settings, and its label, which by default is the name followed by the settings."""

    model_config = ConfigDict(extra="allow", strict=True)

    label: str = ""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name."""

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
        settings = " ".join(f"{name}={value}" for name, value in self.settings.items())
        return self if self.label else derived(self, label=f"{self.name} {settings}".strip())


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
    name, count = Counter(names).most_common(1)[0]
    if count > 1:
        raise ValueError(f"{noun} must differ, but {name!r} stands {count} times")


class ScenarioStudy(StudyModel):
    """A study with a name, on scenarios.

    Attributes
    ----------
    name
        The study's title.
    scenarios
        Built-in names or files, or ``{"label": ..., "file": ...}``.
    """

    format: str
    name: Annotated[str, Field(min_length=1)] = "study"
    scenarios: StudyScenarios

    def seen_from(self, folder: Path) -> Self:
        """Return the study with the paths of its scenarios' files relative to `folder`."""
        return self.with_files(lambda file: Path(os.path.relpath(file, folder)).as_posix())

    def with_files(self, moved: Callable[[str], str]) -> Self:
        """Return the study with the paths of its scenarios' files moved."""
        given = (
            each if each.file in BUILTIN_NAMES else derived(each, file=moved(each.file)) for each in self.scenarios
        )
        return derived(self, scenarios=tuple(given))
