"""What every study asks of its runs, whatever they are."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, Self, TypeVar

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
    def key(self) -> str:
        """A digest of the labels and of all that determines the answer, including the code."""

    def row(self) -> R_co:
        """Make the run and return its row."""

    def shortened(self) -> Self:
        """Return a run that is as short as it can be and needs the same kernels."""


def row_of(job: StudyJob[R_co]) -> R_co:
    """Make a run and return its row."""
    return job.row()


def warm_up(jobs: Sequence[StudyJob[object]]) -> None:
    """Make each run as short as it can be, so that all kernels which the jobs need are compiled and cached."""
    for job in jobs:
        with suppress(Exception):  # the run itself will raise the same error
            job.shortened().row()
