"""Runs made by whichever process is asked for them."""

from collections.abc import Sequence
from contextlib import suppress

from skyverse.errors import InputError
from skyverse.lab.code_digest import code_digest
from skyverse.lab.fly_job import fly_job
from skyverse.lab.job import Job
from skyverse.lab.plan_job import plan_job
from skyverse.lab.row import Row


def row_of(job: Job) -> Row:
    """Make a run and return its row, or raise `InputError` where this process has other code than the one that asks."""
    if code_digest(job.made_by) != job.code:
        raise InputError(f"{job}: expected the code of the process that asks, found another; start workers anew")
    return make_run(job)


def make_run(job: Job) -> Row:
    """Make a run and return its row."""
    return plan_job(job) if job.case.traffic is None else fly_job(job)


def warm_up(jobs: Sequence[Job]) -> None:
    """Make each run as short as it can be, so that all kernels which the jobs need are compiled and cached."""
    for job in jobs:
        with suppress(Exception):  # the run itself will raise the same error
            make_run(job.shortened())
