"""Point clouds of PCL, written here by the published format: each way to keep them holds the same points."""

import struct
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.maps.readers.local_worlds import read_voxels
from skyverse.maps.readers.pcd import unpack

POINTS = np.random.default_rng(3).uniform((0, 0, 0), (20, 10, 5), (500, 3)).astype(np.float32)
KINDS = ("ascii", "binary", "binary_compressed")
LAYOUTS = {
    "plain": [("x", "f4", 1), ("y", "f4", 1), ("z", "f4", 1)],
    "double": [("x", "f8", 1), ("y", "f8", 1), ("z", "f8", 1)],
    "mixed": [("label", "u1", 1), ("z", "f4", 1), ("_", "i2", 5), ("x", "f8", 1), ("_", "u4", 2), ("y", "f4", 1)],
}


def squeezed(data):
    """The bytes by LZF: runs, but for stretches of one byte, which are copies of the byte before."""
    made, at = b"", 0
    while at < len(data):
        same = len(data) - at - len(data[at:].lstrip(data[at : at + 1]))
        if same >= 4:
            count = min(same - 1, 264)
            code = bytes([(count - 2) << 5, 0]) if count < 9 else bytes([7 << 5, count - 9, 0])
            made += bytes([0, data[at]]) + code
            at += 1 + count
        else:
            part = data[at : at + min(same, 32)]
            made += bytes([len(part) - 1]) + part
            at += len(part)
    return made


def pcd(points, kind, layout="plain", **more):
    """The bytes of a file; `more` replaces lines of its header."""
    fields = LAYOUTS[layout]
    rows = np.zeros(len(points), [(f"{k}", f"<{form}", (n,)) for k, (_, form, n) in enumerate(fields)])
    for k, (name, form, _) in enumerate(fields):
        if name in "xyz":
            rows[f"{k}"][:, 0] = points[:, "xyz".index(name)]
        elif form[0] != "f":
            rows[f"{k}"] = 1 + k
    said = {
        "VERSION": "0.7",
        "FIELDS": " ".join(name for name, _, _ in fields),
        "SIZE": " ".join(form[1] for _, form, _ in fields),
        "TYPE": " ".join(form[0].upper() for _, form, _ in fields),
        "COUNT": " ".join(str(n) for _, _, n in fields),
        "WIDTH": len(points),
        "HEIGHT": 1,
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": len(points),
        "DATA": kind,
    } | more
    head = "# .PCD v0.7 - Point Cloud Data file format\n" + "".join(
        f"{key} {value}\n" for key, value in said.items() if value is not None
    )
    if kind == "ascii":
        body = "".join(" ".join(repr(x) for one in row for x in one.tolist()) + "\n" for row in rows).encode()
    elif kind == "binary":
        body = rows.tobytes()
    else:
        whole = b"".join(np.ascontiguousarray(rows[f"{k}"]).tobytes() for k in range(len(fields)))
        packed = squeezed(whole)
        body = struct.pack("<II", len(packed), len(whole)) + packed
    return head.encode() + body


def written(folder, data):
    path = folder / "a.pcd"
    path.write_bytes(data)
    return path


def held(voxels):
    first = np.rint(np.array(voxels.origin) / voxels.step).astype(int)
    return {tuple(cell) for cell in (first + np.argwhere(voxels.occupied)).tolist()}


def cells(points, size=0.5):
    return {tuple(cell) for cell in np.floor(np.asarray(points, float) / size).astype(int).tolist()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_cloud_is_the_voxels_that_hold_its_points_however_it_is_kept(tmp_path, kind, layout):
    scenario = sky.read(written(tmp_path, pcd(POINTS, kind, layout)))
    assert held(scenario.obstacles[0]) == cells(POINTS)
    assert scenario.sources[0].cautions == ()
    assert held(read_voxels(tmp_path / "a.pcd", size=2.0)) == cells(POINTS, 2.0)


@pytest.mark.parametrize("kind", KINDS)
def test_points_without_a_place_are_left_out_and_told(tmp_path, kind):
    points = POINTS.copy()
    points[3], points[5, 2], points[9, 0] = np.nan, np.inf, -np.inf
    scenario = sky.read(written(tmp_path, pcd(points, kind, WIDTH=100, HEIGHT=5)))
    assert held(scenario.obstacles[0]) == cells(np.delete(POINTS, [3, 5, 9], axis=0))
    (said,) = scenario.sources[0].cautions
    assert "3 points of 500" in said


@pytest.mark.parametrize("more", [{"POINTS": None}, {"COUNT": None}, {"VIEWPOINT": None}, {"HEIGHT": None}])
def test_what_older_versions_leave_out_is_not_needed(tmp_path, more):
    assert held(read_voxels(written(tmp_path, pcd(POINTS, "binary", **more)))) == cells(POINTS)
    assert read_voxels(written(tmp_path, pcd(POINTS, "binary", VIEWPOINT="0.0 0 0 1.000 -0 0 0"))).occupied.any()


def test_lzf_is_unpacked_as_liblzf_packs_it():
    """What liblzf 3.6 made, by way of python-neo-lzf."""
    packed = (
        "0361626361e00202016400e0ff00e01a000874686520656e642c20e007081f000102030405060708090a0b0c0d0e0f10"
        "1112131415161718191a1b1c1d1e1f072021222324252627"
    )
    whole = b"abcabcabcabcabcd" + bytes(300) + b"the end, the end, the end" + bytes(range(40))
    made = np.empty(len(whole), np.uint8)
    assert unpack(np.frombuffer(bytes.fromhex(packed), np.uint8).copy(), made) == len(whole)
    assert made.tobytes() == whole


@given(st.binary(max_size=200) | st.lists(st.tuples(st.binary(min_size=1, max_size=2), st.integers(1, 400))))
def test_what_is_packed_is_unpacked_and_damaged_bytes_end(made):
    whole = made if isinstance(made, bytes) else b"".join(piece * count for piece, count in made)
    packed = np.frombuffer(squeezed(whole), np.uint8).copy()
    room = np.empty(len(whole), np.uint8)
    assert unpack(packed, room) == len(whole)
    assert room.tobytes() == whole
    for cut in range(0, len(packed), 1 + len(packed) // 20):
        assert -1 <= unpack(packed[:cut].copy(), room) <= len(whole)
    assert -1 <= unpack(np.frombuffer(whole, np.uint8).copy(), room) <= len(whole)


@pytest.mark.parametrize(
    "more",
    [
        {"WIDTH": 999_999_999, "HEIGHT": 999_999_999, "POINTS": None},
        {"POINTS": 499},
        {"POINTS": -500},
        {"WIDTH": "many"},
        {"SIZE": "4 4 3"},
        {"SIZE": "4 4"},
        {"SIZE": "2 2 2"},
        {"TYPE": "F F S"},
        {"COUNT": "1 1 2"},
        {"COUNT": "1 1 0"},
        {"COUNT": "1 1 999999999"},
        {"FIELDS": "x y"},
        {"FIELDS": "x y y"},
        {"FIELDS": "x y intensity"},
        {"VIEWPOINT": "0 0 2 1 0 0 0"},
        {"VIEWPOINT": "nan"},
        {"DATA": "zip"},
        {"DATA": ""},
        {"DATA": None},
    ],
    ids=map(str, range(19)),
)
def test_a_header_that_does_not_fit_is_refused(tmp_path, more, refuses):
    with refuses():
        read_voxels(written(tmp_path, pcd(POINTS, "binary", **more)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_header_that_claims_much_is_refused_before_it_takes_memory(tmp_path, kind, refuses):
    file = written(tmp_path, pcd(POINTS, kind, WIDTH=300_000_000, POINTS=300_000_000))
    tracemalloc.start()
    with refuses():
        read_voxels(file)
    if kind == "binary_compressed":  # the length says the same as the header, and LZF cannot make so much of so little
        head, *_ = file.read_bytes().partition(b"compressed\n")
        head += b"compressed\n"
        with refuses():
            read_voxels(written(tmp_path, head + struct.pack("<II", 1000, 3_600_000_000) + bytes(1000)))
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("length", [0, 5, 60, 260, 2000])
def test_a_cloud_that_is_cut_off_is_refused(tmp_path, kind, length, refuses):
    with refuses():
        read_voxels(written(tmp_path, pcd(POINTS, kind)[:length]))


def test_other_clouds_that_cannot_be_used_are_refused(tmp_path, refuses):
    for points in (POINTS[:0], np.full((4, 3), np.nan), POINTS * 1e12):
        with refuses():
            read_voxels(written(tmp_path, pcd(points, "binary")))
    for text in ("1 2\n", "1 2 three\n", "1 2 3\n4 5 6\n", "1,2,3\n"):
        with refuses():
            read_voxels(written(tmp_path, pcd(POINTS[:1], "binary", DATA="ascii")[:-12] + text.encode()))


@given(st.data(), st.sampled_from(KINDS))
def test_a_damaged_cloud_is_read_or_refused(tmp_path_factory, data, kind):
    whole = bytearray(pcd(POINTS[:40], kind, "mixed"))
    for _ in range(3):
        at = data.draw(st.integers(0, len(whole)))
        whole[at : at + data.draw(st.sampled_from([0, 1, 8]))] = data.draw(st.binary(max_size=4))
    said = ""
    try:
        read_voxels(written(tmp_path_factory.mktemp("damaged"), bytes(whole)), size=1.0)
    except sky.InputError as error:
        said = str(error)
    assert "\n" not in said
    assert not said or "a.pcd" in said
