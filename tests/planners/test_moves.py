"""The operators on lattice paths: walks, loops, detours."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.planners import moves
from skyverse.planners.contact import contact_of
from skyverse.planners.moves import EVALUATIONS, NODES, PATHS, LatticeTask, Paths, Workspace
from skyverse.space.contact import flown_legs
from worlds import ROOM, exits_of, scenarios


def task_and_desk(scenario, directed=True, threshold=20, capacity=400, goal=0):
    airspace = sky.Airspace(scenario)
    grid = airspace.grid
    workspace = Workspace(
        mark=np.zeros(len(grid.exits), np.uint8),
        stamp=np.zeros(1, np.int64),
        position=np.zeros(len(grid.exits), np.int32),
        draft=np.empty(capacity, np.int32),
        legs=flown_legs(capacity + 2),
        spent=np.zeros(3, np.int64),
        limit=np.full(3, 2**62),
        improved=np.empty((1, 4)),
        improvements=np.zeros(1, np.int64),
    )
    contact = contact_of(sky.Problem(airspace))
    return LatticeTask(grid, airspace.pricing, contact, 0, goal, directed, threshold), workspace


def free_node(scenario, grid, seed):
    open_ = exits_of(scenario, grid.moves)
    nodes = np.flatnonzero(open_.any(axis=1))
    return (None if not len(nodes) else int(np.random.default_rng(seed).choice(nodes))), open_


def move_of(grid, a, b):
    """The number of the move from node a to node b, by their indices."""
    shape = tuple(grid.shape)
    step = np.subtract(np.unravel_index(b, shape), np.unravel_index(a, shape))
    found = np.flatnonzero((grid.moves == step).all(axis=1))
    assert len(found) == 1, f"from {a} to {b} is no lattice move"
    return int(found[0])


def raw_walk(task, workspace, seed, source, goal, threshold):
    """The walk with its loops, by the plain Python."""
    workspace.draft[0] = source
    length = plain(moves._walk)(task, workspace, np.random.default_rng(seed), 1, goal, threshold)
    walked = workspace.draft[: abs(length)].copy()
    assert length < 0 or len(set(walked.tolist())) == len(walked)  # it owns up to its loops
    return walked


@given(scenarios(most_nodes=6), st.booleans(), st.integers(1, 40), st.integers(0, 2**32))
def test_a_walk_takes_lattice_moves_through_free_space_and_gives_up_in_time(scenario, directed, threshold, seed):
    task, workspace = task_and_desk(scenario, directed, threshold)
    grid = task.grid
    source, open_ = free_node(scenario, grid, seed)
    goal, _ = free_node(scenario, grid, seed + 1)
    if source is None:
        return
    walk = raw_walk(task, workspace, seed, source, goal, threshold)
    assert workspace.spent[PATHS] == 1
    assert workspace.spent[NODES] == len(walk) - 1
    taken = [move_of(grid, a, b) for a, b in itertools.pairwise(walk)]
    assert all(open_[node, m] for node, m in zip(walk[:-1], taken, strict=True))
    assert goal not in walk[:-1]
    given_up = count_non_viable(grid, open_, walk, taken, goal) if directed else len(taken)
    assert given_up <= threshold + 1
    if walk[-1] != goal:
        assert given_up == threshold + 1 or len(walk) == len(workspace.draft)
    # the compiled walk is this one without its loops
    workspace.draft[0] = source
    length = moves.generate(task, workspace, np.random.default_rng(seed), 1, goal, threshold)
    assert workspace.draft[:length].tolist() == without_loops(walk.tolist())


def without_loops(walk):
    """Go on from each node's last visit."""
    kept, rest = [], walk
    while rest:
        kept.append(rest[0])
        rest = rest[len(rest) - rest[::-1].index(rest[0]) :]
    return kept


def count_non_viable(grid, open_, walk, taken, goal):
    """Replay a walk of Algorithm 2: check the precedence of its four choices, count the non-viable steps."""
    shape, seen, count, before = tuple(grid.shape), {int(walk[0])}, 0, None
    for node, m in zip(walk[:-1], taken, strict=True):
        at, end = np.array(np.unravel_index(node, shape)), np.array(np.unravel_index(goal, shape))
        free = {k for k in range(len(grid.moves)) if open_[node, k]}
        back = {k for k in free if before is not None and np.array_equal(grid.moves[k], -grid.moves[before])}
        nearer = {
            k
            for k in free - back
            if all(abs(w - v) < abs(w) for w, v in zip(end - at, grid.moves[k], strict=True) if v)
        }
        fresh = {k for k in free if int(node + grid.offsets[k]) not in seen}
        if nearer & fresh:
            assert m in nearer & fresh
        elif fresh:
            assert m in fresh
            count += 1
        elif nearer:
            assert m in nearer
        else:
            count += 1
        seen.add(int(node + grid.offsets[m]))
        before = m
    return count


@given(st.integers(0, 2**32), st.booleans())
def test_a_walk_stops_where_the_draft_is_full(seed, directed):
    task, workspace = task_and_desk(ROOM, directed, 10**6, capacity=7)
    assert len(raw_walk(task, workspace, seed, 0, len(task.grid.exits) - 1, 10**6)) == 7


def test_every_choice_is_equally_likely():
    """From a corner of an empty hall three moves are viable; a walk of one step takes each a third of the time."""
    empty = ROOM.model_copy(update={"obstacles": (), "lattice": sky.Lattice(step=(0.5, 0.5, 0.5))})
    rng = np.random.default_rng(5)
    for directed in (True, False):
        task, workspace = task_and_desk(empty, directed, 0, capacity=2, goal=0)
        seconds = []
        for _ in range(3000):
            workspace.draft[0] = 0
            moves.generate(task, workspace, rng, 1, len(task.grid.exits) - 1, 0)
            seconds.append(int(workspace.draft[1]))
        _, counts = np.unique(seconds, return_counts=True)
        assert len(counts) == 3
        assert np.abs(counts - 1000).max() < 5 * np.sqrt(3000 * 2 / 9)


def test_the_marks_of_old_walks_never_count_as_visited():
    """Marks are one byte: after 255 walks the stamps begin anew, and no walk may see what an older one left."""
    task, workspace = task_and_desk(ROOM)
    goal = len(task.grid.exits) - 1
    for number in range(600):
        workspace.draft[0] = 0
        length = moves.generate(task, workspace, np.random.default_rng(number), 1, goal, 20)
        fresh_task, fresh_desk = task_and_desk(ROOM) if number in (0, 254, 255, 256, 511, 599) else (task, None)
        if fresh_desk is not None:
            fresh_desk.draft[0] = 0
            again = moves.generate(fresh_task, fresh_desk, np.random.default_rng(number), 1, goal, 20)
            np.testing.assert_array_equal(workspace.draft[:length], fresh_desk.draft[:again])


@given(scenarios(most_nodes=4, most_boxes=4), st.integers(0, 2**32))
def test_cutting_loops_leaves_a_simple_path_with_the_same_ends_and_moves(scenario, seed):
    task, workspace = task_and_desk(scenario, directed=False, threshold=60)
    source, open_ = free_node(scenario, task.grid, seed)
    if source is None:
        return
    walk = raw_walk(task, workspace, seed, source, -1, 60).tolist()
    kept = workspace.draft[: moves.cut_loops(workspace, 0, len(walk))].tolist()
    assert kept[0] == walk[0]
    assert kept[-1] == walk[-1]
    assert len(set(kept)) == len(kept)
    assert all(open_[a, move_of(task.grid, a, b)] for a, b in itertools.pairwise(kept))
    order = [len(walk) - 1 - walk[::-1].index(node) for node in kept]
    assert order == sorted(order)


@given(st.lists(st.integers(0, 11), min_size=1, max_size=40), st.data())
def test_cutting_loops_goes_on_from_each_last_visit_and_leaves_what_comes_before(walk, data):
    _, workspace = task_and_desk(ROOM)
    workspace.draft[: len(walk)] = walk
    first = data.draw(st.integers(0, len(walk) - 1))
    length = moves.cut_loops(workspace, first, len(walk))
    assert workspace.draft[:length].tolist() == walk[:first] + without_loops(walk[first:])


def test_judging_counts_an_evaluation_and_copying_stops_at_the_end_of_the_draft():
    task, workspace = task_and_desk(ROOM, capacity=5)
    paths = Paths(np.arange(8, dtype=np.int32)[None], np.array([8]), np.array([0.0]))
    assert moves.copy_in(workspace, 0, paths, 0, 2, 4) == 2
    assert workspace.draft[:2].tolist() == [2, 3]
    assert moves.copy_in(workspace, 2, paths, 0, 0, 8) == 5
    assert workspace.draft.tolist() == [2, 3, 0, 1, 2]
    moves.judge(task, workspace, 2)
    assert workspace.spent[EVALUATIONS] == 1


@given(st.integers(0, 2**32))
def test_a_detour_ends_at_a_free_node_or_has_tried_often_enough(seed):
    task, workspace = task_and_desk(ROOM)
    workspace.draft[0] = 0
    length = moves.detour(task, workspace, np.random.default_rng(seed), 1, 1, 3)
    assert 1 <= workspace.spent[PATHS] <= 4
    assert task.grid.exits[workspace.draft[:length]].all()


def test_a_random_node_is_any_free_one():
    task, _ = task_and_desk(ROOM)
    rng = np.random.default_rng(0)
    drawn = {moves.random_node(task.grid, rng) for _ in range(20 * len(task.grid.exits))}
    assert drawn == set(np.flatnonzero(exits_of(ROOM, task.grid.moves).any(axis=1)).tolist())


def plain(kernel):
    return getattr(kernel, "py_func", kernel)
