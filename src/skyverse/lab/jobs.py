"""What every study asks of its runs, whatever they are."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, Self, TypeVar

from skyverse.errors import InputError
from skyverse.lab.code_digest import code_digest

R_co = TypeVar("R_co", covariant=True)


class StudyJob(Protocol[R_co]):
    """One run to be made; it is sent to other processes as it is."""

    @property
    def label(self) -> str:
        """Jobs with one label need the same kernels."""

    @property
    def run(self) -> tuple[str | int, ...]:
        """The labels and the seed that identify the run in its study."""

    @property
    def made_by(self) -> object:
        """What makes the run: a planner and an objective, or a policy."""

    @property
    def code(self) -> str:
        """The digest of the code that makes the run, in the process that asks for it."""

    @property
    def key(self) -> str:
        """A digest of the labels and of all that determines the answer, including the code."""

    def row(self) -> R_co:
        """Make the run and return its row."""

    def shortened(self) -> Self:
        """Return a run that is as short as it can be and needs the same kernels."""


def row_of(job: StudyJob[R_co]) -> R_co:
    """Make a run and return its row, or raise `InputError` where this process has other code than the one that asks."""
    if code_digest(job.made_by) != job.code:
        raise InputError(f"{job}: expected the code of the process that asks, found another; start workers anew")
    return job.row()


def warm_up(jobs: Sequence[StudyJob[object]]) -> None:
    """Make each run as short as it can be, so that all kernels which the jobs need are compiled and cached."""
    for job in jobs:
        with suppress(Exception):  # the run itself will raise the same error
            job.shortened().row()
