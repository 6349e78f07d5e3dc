"""The verb ``reproduce``: the thesis's tables, figures and claims."""

from pathlib import Path
from typing import Annotated

from skyverse.cli.option_types import OUTPUT, WHOLE, Whole
from skyverse.cli.watch import StudyWatch
from skyverse.numerics.cores import cores


def reproduce(
    *parts: str,
    runs: Annotated[int, WHOLE] = 200,
    seed: Annotated[int, WHOLE] = 0,
    sets: Annotated[int, WHOLE] = 1,
    output: Annotated[Path, OUTPUT] = Path("out/reproduction"),
    workers: Whole = None,
) -> int:
    """Run the thesis's experiments again: all its tables and figures and the verdict on its claims, or some of them.

    Examples: `skyverse reproduce`, `skyverse reproduce table-4.2 fig-4.17`, `skyverse reproduce claims --runs 5`

    The output folder gets `report`, `claims` and `times` as .html and .md, `figures/`, and the rows behind them. The
    same seed gives the same report and claims, byte by byte; times are measured and differ. Runs that an earlier
    command has finished are not done again.

    Parameters
    ----------
    parts
        What to reproduce: table-4.2 to table-4.7, table-4.10, cells, acceptance, fig-4.1 to fig-4.31, claims; all when
        left out.
    runs
        How many runs each cell of a table has, 2 or more.
    seed
        The first seed of each cell.
    sets
        By how many disjoint sets of seeds the claims are judged; each takes about as long as the claims alone.
    output
        The folder to write to.
    workers
        Processes that share the runs; as many as there are cores by default.
    """
    from skyverse.reproduction.reproduce import reproduce as run_again

    watch = StudyWatch(output, ["mission", "AStar", "MVO", "GSO", "BBO", "RandomRestart", "HybridMVO"])
    try:
        with watch.bar() as on_run:
            pages = run_again(parts, output, runs=runs, seed=seed, sets=sets, workers=workers or cores(), on_run=on_run)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(watch.kept) from None
    for page in pages:
        print(page)
    return 0
