"""Plan many paths at once, on all cores."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed

from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.numerics.side_by_side import threads
from skyverse.planners import planner_of
from skyverse.planners.base import Planner, Seed, seeded
from skyverse.planners.own_path import require_result
from skyverse.problem import Airspace, Problem
from skyverse.stop import Stop, require_stop


def plan_many(
    scenario: Scenario | Airspace,
    planner: Planner | str | None = None,
    pairs: Iterable[tuple[int | str, int | str]] | None = None,
    *,
    stop: Stop | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_result: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """Plan the paths of many UAVs to many targets in parallel.

    The space is compiled once and shared. Kernels release Python's global lock, so that threads use all cores. Paths
    have no times, so that movers, active times and speed limits of zones are not heeded.

    Parameters
    ----------
    scenario
        The scenario, or an `Airspace` that was made of it before.
    planner
        Plans each path, or its name; by default `Auto`, which chooses a planner by what the scenario prices.
    pairs
        Indices or names (uav, target), one pair for each path; a UAV or target may occur in many pairs. By default each
        UAV flies to the target with its own index.
    stop
        When the planning of each path ends.
    rng
        Seed or generator. Every path draws from a stream of its own, so that the answers do not depend on `workers`.
    workers
        The number of threads; by default the number of cores.
    on_result
        Called with the position of a pair and its result as soon as it is found.

    Returns
    -------
    list of Result
        One for each pair, in their order.

    Raises
    ------
    InputError
        If `planner`, `stop`, `rng` or `workers` is not what it must be, or the scenario has no such UAV or target.
    """
    most_threads = threads(workers)
    planner = planner_of(planner)
    require_stop(stop)
    airspace = scenario if isinstance(scenario, Airspace) else Airspace(scenario)
    if pairs is None:
        count = min(len(airspace.scenario.uavs), len(airspace.scenario.targets))
        pairs = [(i, i) for i in range(count)]
    problems = [Problem(airspace, uav, target) for uav, target in pairs]
    streams = seeded(rng)[0].spawn(len(problems))
    results: dict[int, Result] = {}

    def plan(i: int) -> Result:
        return require_result(planner.plan(problems[i], stop=stop, rng=streams[i]))

    def note(i: int, result: Result) -> None:
        results[i] = result
        if on_result is not None:
            on_result(i, result)

    if problems:
        note(0, plan(0))  # planned alone, since it compiles the kernels that all share
    with ThreadPoolExecutor(most_threads) as pool:
        waiting = {pool.submit(plan, i): i for i in range(1, len(problems))}
        try:
            for done in as_completed(waiting):
                note(waiting[done], done.result())
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [results[i] for i in range(len(problems))]
