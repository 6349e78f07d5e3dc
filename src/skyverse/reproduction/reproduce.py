"""Runs the thesis's experiments again, and writes the pages of the reproduction."""

import platform
from collections.abc import Sequence
from pathlib import Path

from skyverse._version import __version__
from skyverse.errors import InputError
from skyverse.lab import Job, OnRun, Report, Rows, SectionHeading, Text, run_jobs, write_report_files
from skyverse.lab.report import Block
from skyverse.reproduction import claims, convergence, costs, flights, work
from skyverse.reproduction.cells import CellRuns, ThesisPart, jobs_of
from skyverse.reproduction.claim_verdict import ClaimVerdict

MAX_RUNS = 10_000
MAX_SETS = 100

THESIS_PARTS = {part.name: part for page in (flights, costs, convergence, work, claims) for part in page.parts()}
"""All parts by name: ``fig-4.1`` ... ``fig-4.31``, ``table-4.2`` ... ``table-4.7``, ``table-4.10``, ``claims``."""

_SECTIONS = (
    ("One UAV: paths, trajectories, flight", [f"fig-4.{k}" for k in range(1, 10)]),
    (
        "Best costs and times",
        ["table-4.2", "table-4.3", "table-4.4", "cells", "acceptance", "fig-4.10", "fig-4.11", "fig-4.12", "fig-4.13"],
    ),
    ("Convergence and spread", ["table-4.5", *(f"fig-4.{k}" for k in range(14, 20))]),
    ("Time against population", ["table-4.6", "table-4.7", *(f"fig-4.{k}" for k in range(20, 26))]),
    ("Fleets", ["table-4.10", *(f"fig-4.{k}" for k in range(26, 32))]),
)
_FORMS = (
    "*As run* is what the published experiments did, *as described* what the thesis's text and the original papers "
    "say. *Random restart* is a baseline without memory, given as many generated paths; *exact* is the true optimum "
    "of the same lattice. Costs are in the thesis's unit: nodes on the path, and 100 for each metre that it ends "
    "short of the goal."
)


def named(names: Sequence[str]) -> list[ThesisPart]:
    """Return the parts of these names, or all parts where `names` is empty.

    Raises
    ------
    InputError
        If there is no such part.
    """
    for name in names:
        if name not in THESIS_PARTS:
            raise InputError(f"there is no part {name!r} of the thesis; there are {', '.join(THESIS_PARTS)}")
    return [part for name, part in THESIS_PARTS.items() if not names or name in names]


def jobs(parts: Sequence[ThesisPart], seeds: Sequence[int]) -> list[Job]:
    """Return the runs that these parts need, each once, scenario by scenario."""
    return jobs_of(cell for part in parts for cell in part.wanted(seeds))


def reproduce(
    names: Sequence[str] = (),
    folder: Path | str = Path("out/reproduction"),
    *,
    runs: int = 200,
    seed: int = 0,
    sets: int = 1,
    workers: int = 1,
    on_run: OnRun | None = None,
) -> list[Path]:
    """Run the thesis's experiments again, and write their tables, figures and claims.

    Parameters
    ----------
    names
        The parts, such as ``table-4.2``, ``fig-4.17`` or ``claims``; all parts where it is empty.
    folder
        The folder for ``report``, ``claims`` and ``times`` (.md and .html), their ``figures/``, and the rows of all
        runs. Runs whose rows it has already are not repeated.
    runs
        The number of runs of each cell, at least 2.
    seed
        The first seed of each cell. The same seed gives the same ``report`` and ``claims``, byte by byte.
    sets
        By how many disjoint sets of seeds, of `runs` each, the claims are judged; ``claims`` says how often a verdict
        is the same. Sets that the folder has already are not run again.
    workers
        The number of processes that share the runs.
    on_run
        Called with the number of finished runs and the number of all runs.

    Returns
    -------
    list of Path
        The pages.

    Raises
    ------
    InputError
        If there is no such part, there are too few runs, or something cannot be written.
    """
    parts = named(names)
    if not 2 <= runs <= MAX_RUNS:
        raise InputError(f"expected a whole number from 2 to {MAX_RUNS:,}, found {runs!r}", field="runs")
    if not 1 <= sets <= MAX_SETS:
        raise InputError(f"expected a whole number from 1 to {MAX_SETS}, found {sets!r}", field="sets")
    if THESIS_PARTS["claims"] not in parts:
        sets = 1
    seeds = range(seed, seed + runs)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror or error}") from None
    wanted = jobs(parts, seeds)
    with Rows(folder / "rows.sqlite") as rows:
        if wanted:
            run_jobs(wanted, rows, workers=workers, on_run=on_run)
        cells = CellRuns(rows, seeds)
        command = " ".join(["skyverse reproduce", *names, f"--runs {runs} --seed {seed}"])
        command += f" --sets {sets}" * (sets > 1)
        elsewhere: list[list[list[ClaimVerdict]]] = []
        for first in range(seed + runs, seed + sets * runs, runs):
            others = range(first, first + runs)
            with Rows(folder / f"rows-{first}.sqlite") as more:
                run_jobs(jobs([THESIS_PARTS["claims"]], others), more, workers=workers, on_run=on_run)
                judged = claims.judge_all(CellRuns(more, others))
            elsewhere.append([[finding.verdict for finding in findings] for findings in judged])
        return _write_pages(parts, cells, elsewhere, command, folder)


def _write_pages(
    parts: Sequence[ThesisPart],
    cells: CellRuns,
    elsewhere: Sequence[Sequence[Sequence[ClaimVerdict]]],
    command: str,
    folder: Path,
) -> list[Path]:
    by_name = {part.name: part for part in parts}
    made = f"Made by `{command}`, skyverse {__version__}."
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    shown: list[Block] = []
    timed: list[Block] = []
    for heading, names in _SECTIONS:
        there = [by_name[name] for name in names if name in by_name]
        blocks = [block for part in there for block in part.blocks(cells)]
        seconds = [block for part in there if part.seconds is not None for block in part.seconds(cells)]
        shown += [SectionHeading(heading), *blocks] if blocks else []
        timed += [SectionHeading(heading), *seconds] if seconds else []
    judged = claims.page(cells, elsewhere) if "claims" in by_name else []
    if claimed := by_name.get("claims"):
        timed += claimed.seconds(cells) if claimed.seconds is not None else []
    measured = (
        f"{made} On {machine}. Seconds of tables and figures are wall-clock times of the search alone, several runs "
        "side by side; they differ from run to run and from machine to machine. The thesis's are of MATLAB R2018a at "
        "3.18 GHz."
    )
    pages = (
        ("report", "The thesis's tables and figures, run again", f"{made} {_FORMS}", shown),
        ("claims", "The thesis's claims, judged", f"{made} {_FORMS}", judged),
        ("times", "The thesis's times, measured", measured, timed),
    )
    written: list[Path] = []
    for stem, title, opening, found in pages:
        if found:
            written += write_report_files(Report(title, [Text(opening), *found]), folder, stem=stem)
    return [path for path in written if path.suffix in (".md", ".html")]
