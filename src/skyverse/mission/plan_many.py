"""Many paths at once, on all cores."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed

from skyverse.errors import InputError
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario
from skyverse.numerics.cores import cores
from skyverse.planners.base import Planner, Seed, seeded
from skyverse.problem import Airspace, Problem
from skyverse.stop import Stop


def plan_many(
    scenario: Scenario | Airspace,
    planner: Planner,
    pairs: Iterable[tuple[int, int]],
    *,
    stop: Stop | None = None,
    rng: Seed = None,
    workers: int | None = None,
    on_result: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """Plan many UAVs' paths to many targets, side by side.

    The space is compiled once and shared: kernels run outside Python's global lock, so that threads use all cores.

    Parameters
    ----------
    scenario
        What is given, or an `Airspace` of it that is already there.
    planner
        Plans each path.
    pairs
        (uav, target) indices, one path each; any UAV and target may stand in many.
    stop
        When each plan ends.
    rng
        Seed or generator; every path draws from a stream of its own, so that the answers do not depend on `workers`.
    workers
        Threads; as many as there are cores by default.
    on_result
        Called with a pair's position and its result as soon as there is one, in the order in which they are found.

    Returns
    -------
    list of Result
        One for each pair, in their order.

    Raises
    ------
    InputError
        If planner, `workers` or seed is none.
    ValueError
        If the scenario has no such UAV or target.
    """
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"workers is a whole number from 1 on, not {workers!r}")
    if not isinstance(planner, Planner):
        raise InputError(f"plan_many needs a planner, as in plan_many(scenario, Taut(), pairs), not {planner!r:.60}")
    airspace = scenario if isinstance(scenario, Airspace) else Airspace(scenario)
    problems = [Problem(airspace, uav, target) for uav, target in pairs]
    streams = seeded(rng)[0].spawn(len(problems))
    results: dict[int, Result] = {}

    def plan(i: int) -> Result:
        return planner.plan(problems[i], stop=stop, rng=streams[i])

    def note(i: int, result: Result) -> None:
        results[i] = result
        if on_result is not None:
            on_result(i, result)

    if problems:
        note(0, plan(0))  # alone: it compiles what is shared
    with ThreadPoolExecutor(workers or cores()) as pool:
        waiting = {pool.submit(plan, i): i for i in range(1, len(problems))}
        try:
            for done in as_completed(waiting):
                note(waiting[done], done.result())
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [results[i] for i in range(len(problems))]
