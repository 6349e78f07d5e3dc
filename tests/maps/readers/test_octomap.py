"""OctoMap files hold what OctoMap itself says of them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.cli import main
from skyverse.maps.readers.octomap import read_octomap

HEAD = b"# Octomap OcTree binary file\n#\nid OcTree\nsize %d\nres %s\ndata\n"


def bt(path, words, size=None, res=b"0.5"):
    """Write a .bt of these nodes, each the states of its eight children."""
    body = b"".join(sum(s << 2 * k for k, s in enumerate(word)).to_bytes(2, "little") for word in words)
    nodes = 1 + sum(s > 0 for word in words for s in word)
    path.write_bytes(HEAD % (nodes if size is None else size, res) + body)
    return path


def chain(depth, last):
    """Nodes that lead to the child 0 down to a depth, there to these children."""
    return [[3] + [0] * 7] * depth + [last]


def octree(cells):
    """Nodes of a tree that holds these states (n, n, n) in its lowest corner, by subdivision down to single ones."""
    nodes = []

    def node(part):
        half = len(part) // 2
        row, after = [], []
        nodes.append(row)
        for k in range(8):
            x, y, z = (k >> axis & 1 for axis in range(3))
            child = part[x * half : (x + 1) * half, y * half : (y + 1) * half, z * half : (z + 1) * half]
            if (child == child.flat[0]).all():
                row.append(int(child.flat[0]))
            else:
                row.append(3)
                after.append(child)
        for child in after:
            node(child)

    node(cells)
    return chain(16 - int(np.log2(len(cells))), [])[:-1] + nodes


def tree(seed, resolution=0.25):
    """Return a tree of OctoMap's with leaves of several sizes."""
    octomap = pytest.importorskip("pyoctomap")
    rng = np.random.default_rng(seed)
    grown = octomap.OcTree(resolution)
    points = rng.uniform(-6, 6, (60, 3))
    for point, hit in zip(points, rng.random(60) < 0.6, strict=True):
        grown.updateNode(point.tolist(), bool(hit))
    block = rng.integers(-2, 2, 3)
    for cell in np.ndindex(8, 8, 8):
        for _ in range(6):  # until it is as sure as can be, and equal leaves become one
            grown.updateNode(((block * 8 + cell + 0.5) * resolution).tolist(), True)
    grown.updateInnerOccupancy()
    return grown


def cells(grown, occupied):
    """Return the smallest cells (n, 3) in a tree's leaves, by OctoMap's own iterator."""
    found = []
    size = grown.getResolution()
    for leaf in grown.begin_leafs():
        if grown.isNodeOccupied(leaf) == occupied:
            low = np.rint((np.array(leaf.getCoordinate()) - leaf.getSize() / 2) / size).astype(int)
            n = round(leaf.getSize() / size)
            found.append(low + np.stack(np.indices((n, n, n)), -1).reshape(-1, 3))
    return {tuple(cell) for cell in np.concatenate(found).tolist()}


def occupied_cells(voxels):
    first = np.rint(np.array(voxels.origin) / voxels.step).astype(int)
    return {tuple(cell) for cell in (first + np.argwhere(voxels.occupied)).tolist()}


@pytest.mark.parametrize("suffix", [".bt", ".ot"])
@pytest.mark.parametrize("seed", range(4))
def test_the_voxels_are_the_occupied_leaves_that_octomap_finds(seed, suffix, tmp_path):
    grown = tree(seed)
    path = str(tmp_path / f"a{suffix}")
    assert grown.writeBinary(path) if suffix == ".bt" else grown.write(path)
    wanted = cells(grown, True)
    voxels = read_octomap(Path(path), unknown="free")
    assert voxels.step == (0.25, 0.25, 0.25)
    assert occupied_cells(voxels) == wanted
    assert len(wanted) > 512


@pytest.mark.parametrize("seed", range(4))
def test_unknown_space_is_occupied_unless_the_map_does_not_say_what_is_free(seed, tmp_path):
    grown = tree(seed)
    path = str(tmp_path / "a.bt")
    assert grown.writeBinary(path)
    voxels = read_octomap(Path(path))
    assert voxels == read_octomap(Path(path), unknown="occupied")
    free, occupied = cells(grown, False), cells(grown, True)
    known = np.array(sorted(free | occupied))
    low, high = known.min(axis=0), known.max(axis=0)
    inside = {tuple(cell) for cell in (low + np.stack(np.indices(high - low + 1), -1).reshape(-1, 3)).tolist()}
    assert occupied_cells(voxels) == inside - free


@pytest.mark.parametrize("unknown", ["free", "occupied"])
def test_larger_voxels_are_occupied_where_any_part_of_them_is(unknown, tmp_path):
    grown = tree(1)
    path = str(tmp_path / "a.bt")
    assert grown.writeBinary(path)
    coarse = read_octomap(Path(path), size=1.0, unknown=unknown)
    fine = occupied_cells(read_octomap(Path(path), unknown=unknown))
    assert {tuple(np.array(cell) // 4) for cell in fine} <= occupied_cells(coarse)
    if unknown == "free":
        assert {tuple(np.array(cell) // 4) for cell in fine} == occupied_cells(coarse)


def test_a_tree_too_fine_for_the_grid_is_read_in_larger_voxels(tmp_path):
    octomap = pytest.importorskip("pyoctomap")
    grown = octomap.OcTree(0.1)
    for corner in [(-40.05, -40.05, -40.05), (40.05, 40.05, 40.05)]:
        grown.updateNode(list(corner), True)
    assert grown.writeBinary(str(tmp_path / "a.bt"))
    voxels = read_octomap(tmp_path / "a.bt")
    assert voxels.step == pytest.approx((0.4, 0.4, 0.4))
    assert voxels.occupied.sum() == 2


def test_a_tree_by_hand_reads_as_it_says(tmp_path):
    low = (-16384.0,) * 3  # the lowest corner of all, 2^15 voxels of half a metre below zero
    path = bt(tmp_path / "a.bt", chain(15, [2, 1, 0, 0, 0, 0, 0, 2]))
    scenario = sky.read(path)
    (voxels,) = scenario.obstacles
    assert (voxels.origin, voxels.kind) == (low, "occupied or unknown space")
    assert voxels.occupied.tolist() == [[[True, True], [True, True]], [[False, True], [True, True]]]
    assert (scenario.bounds.min, scenario.bounds.max) == (low, (-16383.0,) * 3)  # beyond, all is unknown
    assert scenario.sources[0].file == "a.bt"
    scenario = sky.read(path, unknown="free")
    (voxels,) = scenario.obstacles
    assert (voxels.origin, voxels.kind) == (low, "occupied space")
    assert voxels.occupied.tolist() == [[[True, False], [False, False]], [[False, False], [False, True]]]
    assert scenario.bounds.min == (-16389.0,) * 3


def test_the_command_line_says_what_unknown_space_was_taken_for(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = np.full((16, 16, 16), 1)
    rows[4:12, 4:12, :12] = 0  # within what is seen, a block of which nobody knows
    rows[8, 8, 8] = 2
    bt(tmp_path / "a.bt", octree(rows), res=b"1")
    low = -32768.0
    words = ["plan", "a.bt", "--planner", "taut", "--no-page", "--uav", f"{low + 1.5},{low + 8},{low + 8}", "--target"]
    for more, taken in (([], "occupied; --unknown free takes it as free."), (["--unknown", "free"], "")):
        with pytest.raises(SystemExit) as ended:
            main([*words, f"{low + 14.5},{low + 8},{low + 8}", *more, "-o", "m.json"])
        assert not ended.value.code
        assert (f"Unknown space counts as {taken}" in capsys.readouterr().err) == (not more)
        length = sky.read_mission("m.json").results[0].cost
        assert (length > 15) == (not more)
    with pytest.raises(SystemExit) as ended:
        main(["plan", "map1", "--unknown", "free"])
    assert ended.value.code == 2
    assert "--unknown: expected it for an OctoMap (.bt, .ot) only, found it for map1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "more"),
    [
        (chain(16, [2] * 8), {}),
        (chain(100000, [2] * 8), {}),
        ([*chain(15, [2] * 8), [2] * 8], {}),
        (chain(14, [3] * 8), {}),
        (chain(15, [1] * 8), {}),
        (chain(15, [0] * 8), {}),
        (chain(15, [2] * 8), {"size": 3}),
        (chain(15, [2] * 8), {"res": b"0"}),
        (chain(15, [2] * 8), {"res": b"nan"}),
        (chain(15, [2] * 8), {"res": b"fine"}),
        ([], {"size": 0}),
    ],
)
def test_what_is_no_tree_is_refused(words, more, tmp_path, refuses):
    path = bt(tmp_path / "a.bt", words, **more)
    with refuses():
        sky.read(path)


def test_the_whole_world_occupied_takes_no_more_memory_than_the_largest_grid(tmp_path, refuses):
    voxels = read_octomap(bt(tmp_path / "a.bt", [[2] * 8]))
    assert voxels.occupied.all()
    assert voxels.occupied.size <= 2**23
    assert np.array(voxels.origin).tolist() == [-16384.0] * 3
    with refuses():
        read_octomap(tmp_path / "a.bt", size=0.5)


@pytest.mark.parametrize("size", [0.75, 0.25, -1.0, float("nan")])
def test_a_size_that_the_tree_does_not_have_is_refused(size, tmp_path, refuses):
    with refuses():
        read_octomap(bt(tmp_path / "a.bt", chain(15, [2] * 8)), size=size)


@given(st.integers(0, 300), st.binary(max_size=40))
def test_a_damaged_tree_is_read_or_refused(tmp_path_factory, at, noise):
    path = bt(tmp_path_factory.mktemp("octomap") / "a.bt", chain(13, [3] * 8) + [[2] * 8] * 8)
    data = path.read_bytes()
    path.write_bytes(data[:at] + noise + data[at + len(noise) :])
    try:
        sky.read(path)
    except sky.InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
