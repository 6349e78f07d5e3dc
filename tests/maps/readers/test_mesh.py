"""Meshes become the voxels that they touch, and their inside."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

import skyverse as sky
from skyverse.maps.readers.mesh import read_mesh, voxels_of_triangles

trimesh = pytest.importorskip("trimesh")


def touches(triangle, cell):
    """Tell by linear programming how far a triangle stays out of a voxel (at least 0)."""
    # least t with  |sum w_i p_i - middle| <= 1/2 + t  on each axis, w >= 0, sum w = 1
    p = np.asarray(triangle).T
    middle = np.asarray(cell) + 0.5
    rows = np.block([[p, -np.ones((3, 1))], [-p, -np.ones((3, 1))]])
    limits = np.concatenate([middle + 0.5, 0.5 - middle])
    found = linprog([0, 0, 0, 1], rows, limits, [[1, 1, 1, 0]], [1], bounds=[(0, None)] * 3 + [(None, None)])
    return found.fun


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.5, 2.0, 6.0]), st.booleans())
def test_a_voxel_is_occupied_exactly_if_a_triangle_touches_it(seed, reach, whole):
    triangle = np.random.default_rng(seed).uniform(0, reach, (3, 3))
    if whole:  # corners on the voxels' own, and degenerate triangles
        triangle = triangle.round()
    occupied, first, size = voxels_of_triangles("a", triangle[None], 1.0)
    assert size == 1
    some = np.random.default_rng(seed).permutation(np.argwhere(np.ones_like(occupied)))[:40]
    for cell in some:
        depth = touches(triangle, first + cell)
        if abs(depth) > 1e-7 or whole:
            assert occupied[tuple(cell)] == (depth <= 1e-7)


def held(voxels):
    first = np.rint(np.array(voxels.origin) / voxels.step).astype(int)
    return {tuple(cell) for cell in (first + np.argwhere(voxels.occupied)).tolist()}


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply"])
def test_every_point_of_a_body_is_in_an_occupied_voxel_and_none_that_is_free_is_near(suffix, tmp_path):
    body = trimesh.creation.icosphere(subdivisions=3, radius=4.0)
    body.apply_translation((1.3, -2.2, 5.1))
    body.export(tmp_path / f"a{suffix}")
    voxels = read_mesh(tmp_path / f"a{suffix}", 0.5)
    cells = held(voxels)
    points = np.random.default_rng(1).uniform(-4, 4, (5000, 3))
    points = points[np.linalg.norm(points, axis=1) < 3.97] + (1.3, -2.2, 5.1)
    assert {tuple(cell) for cell in np.floor(points / 0.5).astype(int).tolist()} <= cells
    middles = (np.array(sorted(cells)) + 0.5) * 0.5 - (1.3, -2.2, 5.1)
    assert np.linalg.norm(middles, axis=1).max() < 4 + 0.5 * np.sqrt(3) / 2
    surface = trimesh.sample.sample_surface(body, 5000, seed=1)[0]
    assert {tuple(cell) for cell in np.floor(surface / 0.5).astype(int).tolist()} <= cells


def test_a_body_with_a_gap_has_no_inside(tmp_path):
    body = trimesh.creation.box(extents=(4, 4, 4))
    body.export(tmp_path / "whole.stl")
    trimesh.Trimesh(body.vertices, body.faces[1:]).export(tmp_path / "gap.stl")
    middle = (0, 0, 0)
    assert middle in held(read_mesh(tmp_path / "whole.stl", 0.5))
    assert middle not in held(read_mesh(tmp_path / "gap.stl", 0.5))


def test_a_box_on_the_voxels_faces_occupies_the_voxels_on_both_sides(tmp_path):
    trimesh.creation.box(bounds=[(0, 0, 0), (2, 2, 2)]).export(tmp_path / "a.stl")
    assert held(read_mesh(tmp_path / "a.stl", 1.0)) == set(itertools.product(range(-1, 3), repeat=3))


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_points_in_a_ply_are_a_cloud(encoding, tmp_path):
    points = np.random.default_rng(1).uniform(-5, 5, (500, 3)).astype(np.float32)
    (tmp_path / "a.ply").write_bytes(trimesh.PointCloud(points).export(file_type="ply", encoding=encoding))
    (voxels,) = sky.read(tmp_path / "a.ply").obstacles
    near = {tuple(cell) for cell in np.floor(points.astype(float) / 0.5).astype(int).tolist()}
    assert len(held(voxels) ^ near) <= (2 if encoding == "ascii" else 0)  # decimals round


OBJ = "v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.obj", OBJ.replace("v 3 0 0", "v nan 0 0").encode()),
        ("a.obj", OBJ.replace("v 3 0 0", "v 1e30 0 0").encode()),
        ("a.obj", OBJ.replace("1 2 3", "1 2 9").encode()),
        ("a.obj", b""),
        ("a.stl", b""),
        ("a.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1000000000000\nproperty float x\nend_header\n1\n"),
        ("a.ply", b"nothing of the kind"),
    ],
)
def test_a_mesh_that_is_wrong_is_refused(name, data, tmp_path, refuses):
    (tmp_path / name).write_bytes(data)
    with refuses():
        sky.read(tmp_path / name)


def test_an_stl_that_says_it_has_more_than_it_has_is_refused_whatever_packages_are_there(tmp_path):
    (tmp_path / "a.stl").write_bytes(b"\x00" * 80 + b"\xff\xff\xff\xff" + b"\x00" * 100)
    with pytest.raises(sky.InputError, match=r"a\.stl: "):
        sky.read(tmp_path / "a.stl")


def test_what_a_library_thinks_of_a_mesh_is_not_printed(tmp_path):
    facet = "facet normal 0 x 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet"
    (tmp_path / "a.stl").write_text(f"solid x\n{facet}\nendsolid")
    read = [sys.executable, "-c", "import skyverse; skyverse.read('a.stl')"]
    done = subprocess.run(read, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stderr == ""


@pytest.mark.parametrize("size", [0, -1, np.nan, np.inf, 1e-9])
def test_a_size_that_is_no_length_is_refused(size, tmp_path, refuses):
    (tmp_path / "a.obj").write_text(OBJ)
    with refuses():
        read_mesh(tmp_path / "a.obj", size)


def test_a_mesh_reads_nothing_beside_it(tmp_path):
    (tmp_path / "a.obj").write_text(f"mtllib {tmp_path}/b.mtl\nusemtl x\n{OBJ}")
    (tmp_path / "b.mtl").mkdir()  # cannot be read
    assert sky.read(tmp_path / "a.obj").obstacles[0].occupied.any()
