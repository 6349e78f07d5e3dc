"""Large arrays lie in a file beside, and nothing else is taken for it."""

import json
import tracemalloc
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import skyverse as sky
from skyverse.files import grid_archive
from skyverse.model.grids import MAX_INLINE_NUMBERS
from worlds import ROOM


def scenario(occupied=None, heights=None):
    """A scenario with voxels and a terrain, large unless given."""
    rng = np.random.default_rng(7)
    occupied = rng.random((20, 30, 17)) < 0.01 if occupied is None else occupied
    heights = rng.random((70, 80)) - 9 if heights is None else heights
    return sky.Scenario.model_validate(
        {
            **dict(ROOM),
            "obstacles": (sky.Voxels(origin=(0, 0, 5), step=(0.1, 0.1, 0.01), occupied=occupied),),
            "terrain": sky.Terrain(origin=(-20, -20), step=(1, 1), heights=heights, lowest=heights - 0.25),
        }
    )


def side(tmp_path, name="a.yaml"):
    return tmp_path / f"{name}.grids.npz"


@pytest.mark.parametrize("name", ["a.yaml", "a.json"])
def test_large_arrays_lie_beside_and_read_back_equal(name, tmp_path):
    given = scenario()
    sky.write(given, tmp_path / name)
    assert {p.name for p in tmp_path.iterdir()} == {name, f"{name}.grids.npz"}
    assert (tmp_path / name).stat().st_size < 3000
    again = sky.read(tmp_path / name)
    assert again == given
    assert not again.terrain.heights.flags.writeable
    assert again.obstacles[0].occupied.dtype == bool


def test_small_arrays_stay_in_the_file(tmp_path):
    given = scenario(occupied=np.ones((16, 16, 16)), heights=np.zeros((64, 64)))
    assert given.terrain.heights.size == MAX_INLINE_NUMBERS
    sky.write(given, tmp_path / "a.yaml")
    assert [p.name for p in tmp_path.iterdir()] == ["a.yaml"]
    assert sky.read(tmp_path / "a.yaml") == given


HEIGHTS = st.floats(-1e300, 1e300) | st.floats(-100, 100, width=32)


@given(
    arrays.arrays(np.float64, (65, 70), elements=HEIGHTS, fill=HEIGHTS),
    arrays.arrays(bool, st.tuples(st.integers(17, 20), st.integers(17, 20), st.integers(16, 19))),
)
@settings(suppress_health_check=[*HealthCheck])
def test_every_array_reads_back_exactly(tmp_path, heights, occupied):
    given = scenario(occupied, heights)
    sky.write(given, tmp_path / "a.json")
    again = sky.read(tmp_path / "a.json")
    assert again == given
    assert again.terrain.heights.tobytes() == heights.tobytes()


def test_heights_take_half_the_room_where_that_loses_nothing(tmp_path):
    sky.write(scenario(heights=np.full((100, 100), 0.5)), tmp_path / "a.yaml")
    sky.write(scenario(heights=np.full((100, 100), 0.1)), tmp_path / "b.yaml")
    kinds = []
    for name in ("a.yaml", "b.yaml"):
        with np.load(side(tmp_path, name), allow_pickle=False) as archive:
            kinds.append(sorted(str(archive[key].dtype) for key in archive))
    assert kinds == [["float32", "float32", "uint8"], ["float64", "float64", "uint8"]]


def test_equal_arrays_are_kept_once_and_equal_scenarios_give_equal_files(tmp_path):
    given = scenario()
    twice = given.model_copy(update={"obstacles": given.obstacles * 2})
    sky.write(twice, tmp_path / "a.yaml")
    first = side(tmp_path).read_bytes()
    with zipfile.ZipFile(side(tmp_path)) as archive:
        assert len(archive.namelist()) == 3
    sky.write(twice, tmp_path / "a.yaml")
    assert side(tmp_path).read_bytes() == first
    assert sky.read(tmp_path / "a.yaml") == twice


def test_a_mission_has_its_scenarios_arrays_beside_it(tmp_path):
    mission = sky.plan_mission(ROOM, sky.AStar())
    mission = type(mission)(**{**vars(mission), "scenario": scenario()})
    sky.write(mission, tmp_path / "m.json")
    assert {p.name for p in tmp_path.iterdir()} == {"m.json", "m.json.grids.npz"}
    assert sky.read(tmp_path / "m.json") == replace(mission, certificates=(), apart=None)
    side(tmp_path, "m.json").unlink()
    refused(tmp_path, "scenario.obstacles[0].occupied: m.json.grids.npz, ", "is missing", name="m.json")


def test_a_file_beside_that_is_no_longer_needed_stays(tmp_path):
    sky.write(scenario(), tmp_path / "a.yaml")
    before = side(tmp_path).read_bytes()
    sky.write(ROOM, tmp_path / "a.yaml")
    assert side(tmp_path).read_bytes() == before
    assert sky.read(tmp_path / "a.yaml") == ROOM


def test_an_unwritable_file_leaves_none_beside_it(tmp_path, refuses):
    (tmp_path / "a.yaml").mkdir()
    with refuses():
        sky.write(scenario(), tmp_path / "a.yaml")
    with refuses():
        sky.write(scenario(), tmp_path / "nowhere" / "a.yaml")
    assert [p.name for p in tmp_path.iterdir()] == ["a.yaml"]


def test_an_unwritable_file_beside_leaves_the_older_file_as_it_was(tmp_path, refuses):
    sky.write(ROOM, tmp_path / "a.yaml")
    side(tmp_path).mkdir()
    with refuses():
        sky.write(scenario(), tmp_path / "a.yaml")
    assert sky.read(tmp_path / "a.yaml") == ROOM
    assert {p.name for p in tmp_path.iterdir()} == {"a.yaml", "a.yaml.grids.npz"}


@pytest.mark.parametrize("step", [1.0, 0.1])  # which float32 has, or float64 alone
def test_heights_are_read_to_where_they_stay(tmp_path, step):
    """What is small in an archive takes once its size in memory, and no copies of it."""
    heights = step * np.add.outer(np.arange(1024), np.zeros(1024))
    ground = sky.Terrain(origin=(0, 0), step=(1, 1), heights=heights)
    sky.write(scenario().model_copy(update={"terrain": ground}), tmp_path / "a.json")
    tracemalloc.start()
    found = sky.read(tmp_path / "a.json").terrain.heights
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.array_equal(found, heights)
    assert peak < (1.5 if step == 0.1 else 2.0) * heights.nbytes + 2**21


def refused(tmp_path, *says, name="a.json"):
    with pytest.raises(sky.InputError) as error:
        sky.read(tmp_path / name)
    message = str(error.value)
    assert message.startswith(str(tmp_path / name))
    assert "\n" not in message
    for words in says:
        assert words in message, message


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("file", "../a.json.grids.npz", "file: expected the plain name"),
        ("file", "sub/a.npz", "file: expected the plain name"),
        ("file", "C:\\a.npz", "file: expected the plain name"),
        ("file", "/etc/passwd", "file: expected the plain name"),
        ("file", "a\0.npz", "file: expected the plain name"),
        ("file", ".npz\n", "file: expected the plain name"),
        ("file", 7, "file: expected the plain name"),
        ("file", "b.npz", "b.npz, the file beside this one with its large arrays, is missing"),
        ("array", "heights", "a.json.grids.npz has no array 'heights'"),
        ("array", ["x"], "has no array"),
        ("array", "x" * 70_000, "has no array"),
        ("shape", [80, 71], "does not have the shape [80, 71]"),
        ("shape", [10**6] * 3, "shape: expected two or three counts"),
        ("shape", [2**13, 2**13 + 1], "shape: expected two or three counts, 67,108,864 numbers at most"),
        ("shape", [10**6, 60], "does not have the shape"),
        ("shape", [-1, 5], "shape: expected two or three counts"),
        ("shape", [5600], "expected two rows of two numbers"),
        ("shape", "70, 80", "shape: expected two or three counts"),
        ("shape", [True, 80], "shape: expected two or three counts"),
        ("sha256", "0" * 64, "is not the array that this file was written with"),
        ("sha256", None, "is not the array that this file was written with"),
        ("colour", "red", "'file', 'array', 'shape' and 'sha256'"),
    ],
)
def test_a_reference_that_is_wrong_is_refused(key, value, says, tmp_path):
    sky.write(scenario(), tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    data["terrain"]["heights"][key] = value
    (tmp_path / "a.json").write_text(json.dumps(data))
    refused(tmp_path, "terrain.heights: ", says)


def test_a_file_beside_of_another_scenario_is_refused(tmp_path):
    sky.write(scenario(), tmp_path / "a.json")
    sky.write(scenario(heights=np.zeros((70, 80))), tmp_path / "b.json")
    side(tmp_path, "b.json").replace(side(tmp_path, "a.json"))
    refused(tmp_path, "terrain.heights: a.json.grids.npz has no array")


def entries(tmp_path):
    with zipfile.ZipFile(side(tmp_path, "a.json")) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_an_array_that_was_changed_is_refused(tmp_path):
    sky.write(scenario(), tmp_path / "a.json")
    changed = {name: data[:-1] + bytes([data[-1] ^ 1]) for name, data in entries(tmp_path).items()}
    with zipfile.ZipFile(side(tmp_path, "a.json"), "w") as archive:
        for name, data in changed.items():
            archive.writestr(name, data)
    refused(tmp_path, "is not the array that this file was written with (its SHA-256 differs)")


def test_an_archive_that_would_fill_memory_is_refused_before(tmp_path):
    sky.write(scenario(), tmp_path / "a.json")
    names = list(entries(tmp_path))
    with zipfile.ZipFile(side(tmp_path, "a.json"), "w", zipfile.ZIP_DEFLATED) as archive:
        for name in names:
            archive.writestr(name, bytes(10**8))
    refused(tmp_path, "is larger than its shape")


def test_a_pickle_is_never_opened(tmp_path):
    sky.write(scenario(), tmp_path / "a.json")
    data = json.loads((tmp_path / "a.json").read_text())
    reference = data["terrain"]["heights"]
    with (tmp_path / "x.npy").open("wb") as file:
        np.save(file, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    pickled = (tmp_path / "x.npy").read_bytes()
    with zipfile.ZipFile(tmp_path / "x.npz", "w") as archive:
        archive.writestr("x.npy", pickled)
    reference |= {"file": "x.npz", "array": "x", "sha256": grid_archive.hashlib.sha256(pickled).hexdigest()}
    (tmp_path / "a.json").write_text(json.dumps(data))
    refused(tmp_path, "terrain.heights: expected an array of numbers, found one of '|O'")


@pytest.mark.parametrize("header", [b"{'descr': '<f8', (", b"{'descr': 3}", b"\0"])
def test_a_header_that_is_none_is_refused(tmp_path, header):
    sky.write(scenario(), tmp_path / "a.json")
    names = list(entries(tmp_path))
    with zipfile.ZipFile(side(tmp_path, "a.json"), "w") as archive:
        for name in names:
            archive.writestr(name, b"\x93NUMPY\1\0" + len(header).to_bytes(2, "little") + header)
    refused(tmp_path, "a.json")


@given(st.data())
@settings(suppress_health_check=[*HealthCheck], max_examples=40)
def test_a_damaged_file_beside_is_read_as_it_was_or_refused(tmp_path, data):
    given = scenario()
    sky.write(given, tmp_path / "a.json")
    path = side(tmp_path, "a.json")
    whole = path.read_bytes()
    at = data.draw(st.integers(0, len(whole) - 1) | st.integers(len(whole) - 300, len(whole) - 1))
    cut = data.draw(st.booleans())
    path.write_bytes(whole[:at] if cut else whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
    try:
        assert sky.read(tmp_path / "a.json") == given
    except sky.InputError as error:
        assert "\n" not in str(error)  # noqa: PT017


def test_a_reference_without_a_file_is_refused(refuses):
    data = scenario().model_dump(mode="json")
    data["terrain"]["heights"] = {"file": "a.npz"}
    with refuses(ValueError):
        sky.Scenario.model_validate(data)
