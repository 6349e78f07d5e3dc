"""The kinds of studies that ``compare`` runs, and what differs between them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from skyverse.cli.planner_summary import planner_lines, planner_summary
from skyverse.cli.policy_summary import policy_lines, policy_summary
from skyverse.lab.moving_row import MovingRows
from skyverse.lab.moving_study import MovingStudy, read_moving_study, write_moving_study
from skyverse.lab.rows import Rows
from skyverse.lab.study import Study, read_study, write_study
from skyverse.live.policies.planner_policies import PlannerPolicy


class StudyKind(NamedTuple):
    """What differs between kinds of studies.

    Attributes
    ----------
    rows
        The class of the file of rows.
    read, write
        The study's file.
    workloads
        What to compile before the given jobs are run.
    summarise, told
        The summary of the rows as data, and as it is printed.
    write_report
        Writes the report on the rows.
    """

    rows: Any
    read: Callable[..., Any]
    write: Callable[..., None]
    workloads: Callable[[list[Any]], list[str]]
    summarise: Callable[[Any], list[dict[str, Any]]]
    told: Callable[[list[dict[str, Any]]], list[dict[str, str]]]
    write_report: Callable[..., list[Any]]


def _planners_report(rows: Rows, folder: Path, **how: Any) -> list[Path]:
    from skyverse.lab.comparison_report import write_report

    return write_report(rows, folder, **how)


def _policies_report(rows: MovingRows, folder: Path, **how: Any) -> list[Path]:
    from skyverse.lab.moving_report import write_moving_report

    return write_moving_report(rows, folder, **how)


def _planners_of(jobs: list[Any]) -> set[str]:
    """Return the class names of the planners that policies ask."""
    policies = [job.contender for job in jobs if isinstance(job.contender, PlannerPolicy)]
    return {type(policy.made()).__name__ for policy in policies}


PLANNERS = StudyKind(
    rows=Rows,
    read=read_study,
    write=write_study,
    workloads=lambda jobs: sorted({type(job.planner).__name__ for job in jobs}),
    summarise=planner_summary,
    told=planner_lines,
    write_report=_planners_report,
)
POLICIES = StudyKind(
    rows=MovingRows,
    read=read_moving_study,
    write=write_moving_study,
    workloads=lambda jobs: ["mission", *sorted(_planners_of(jobs))],
    summarise=policy_summary,
    told=policy_lines,
    write_report=_policies_report,
)


def kind_of(study: Study | MovingStudy) -> StudyKind:
    """Return the kind of a study."""
    return POLICIES if isinstance(study, MovingStudy) else PLANNERS
