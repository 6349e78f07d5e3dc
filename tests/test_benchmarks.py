"""The benchmarks that others run still run."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from patience import PATIENCE_S

PEERS = Path(__file__).parents[1] / "benchmarks" / "peers"


def run(*words):
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=PATIENCE_S)


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="a benchmark of plain Python says nothing")
def test_the_peers_are_compared_in_tables_and_a_figure(tmp_path):
    if importlib.util.find_spec("ompl") is None:
        pytest.skip('OMPL is not installed; pip install "skyverse[ompl]"')
    done = run(PEERS, "--quick", "--seconds", "0.2", "--only", "map1", "Taut", "OMPL AORRTC", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    table = [line.split("|") for line in (tmp_path / "peers.md").read_text().splitlines() if line.startswith("| ")]
    rows = {row[1].strip(): [cell.strip() for cell in row] for row in table}
    assert {"Taut", "OMPL AORRTC"} <= rows.keys()
    sound = [row for row in table if row[-2].strip() == "sound"]
    assert len(sound) == 2
    assert rows["Taut"][-3].startswith("0.")  # within a per cent of the shortest known
    for kind in ("png", "svg"):
        assert (tmp_path / f"peers.{kind}").stat().st_size > 10_000


@pytest.fixture
def showcase(tmp_path, monkeypatch):
    """The benchmark of Phung and Ha, and a terrain of its size that is level."""
    rasterio = pytest.importorskip("rasterio", reason="needs skyverse[maps]")
    file, level = tmp_path / "level.tif", np.full((879, 1045), 50, dtype=np.float32)
    shape = {"driver": "GTiff", "count": 1, "width": 1045, "height": 879, "dtype": "float32"}
    with rasterio.open(file, "w", **shape, transform=rasterio.Affine(1, 0, 0, 0, -1, 879)) as raster:
        raster.write(level, 1)
    monkeypatch.syspath_prepend(PEERS.parent)
    return importlib.import_module("phung_ha"), str(file)


def test_the_objective_of_phung_and_ha_is_the_papers(showcase):
    phung_ha, file = showcase
    objective = phung_ha.Safety(terrain=file)

    def price(*corners):
        above_ground = np.array([(200, 100, 150), *corners, (800, 800, 150)], dtype=float)
        return objective.prices(None, phung_ha.divided(above_ground + np.array((0, 0, 50)))[None])[0]

    assert price((800, 100, 150)) == pytest.approx(5 * 1300 + 90)  # metres, and one turn of 90 degrees
    assert price() == np.inf  # the straight line meets the third threat
    # two threats of 70 m, and 1 m for the drone, are passed at 75 m, 6 m within the zone of 10 m: one by a leg, and one
    # by a node, which is the end of two legs
    near = [(200 + 100 * k, 125, 150) for k in range(7)]
    assert price(*near, (800, 400, 150)) == pytest.approx(5 * (25 + 600 + 675) + 3 * 6 + 2 * 90)
    # a node 20 m too high: two legs of 100 m are longer, and it costs ten times the metres
    legs = [(200 + 100 * k, 100, 150) for k in range(1, 7)]
    raised = [(x, y, 170) if x == 400 else (x, y, z) for x, y, z in legs]
    longer = 2 * (np.hypot(100, 20) - 100)
    assert price(*raised, (800, 300, 150)) == pytest.approx(5 * (1300 + longer) + 90 + 10 * 20)


def test_spherical_vectors_of_phung_and_ha_lead_towards_the_target(showcase):
    phung_ha, file = showcase
    # the middle of all ranges: ten legs of a tenth of the way, level, from start to target
    [path] = phung_ha.Safety(terrain=file).paths(None, np.full((1, 30), 0.5))
    share = np.minimum(np.arange(12), 10)[:, None] / 10
    turned = np.array([(200, 100), (200 + 700, 100 + 600)])  # x by the sine and y by the cosine, as in the paper's code
    assert path[:-1, :2] == pytest.approx((turned[0] + share * (turned[1] - turned[0]))[:-1])
    assert path[:, 2] == pytest.approx(200)
    assert path[-1] == pytest.approx((800, 800, 200))


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="a benchmark of plain Python says nothing")
def test_the_showcase_is_a_table_and_a_picture(showcase, tmp_path):
    _, file = showcase
    pytest.importorskip("pymoo", reason="needs skyverse[optimisers]")
    done = run(PEERS.parent / "phung_ha.py", file, "--runs", "2", "--evaluations", "1200", "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    rows = {line.split("|")[1].strip(): line.split("|")[2:] for line in done.stdout.splitlines() if "|" in line}
    assert {"SPSO", "CMA-ES", "L-SHADE", "MVO", "Cheapest, ten corners"} <= rows.keys()
    assert float(rows["Cheapest, ten corners"][0].replace(",", "")) < 4_700  # the bound is 4,609.8
    assert (tmp_path / "out" / "phung-ha.png").stat().st_size > 50_000


def test_an_unknown_name_is_refused_with_the_list_of_names():
    done = run(PEERS, "--only", "map9")
    assert done.returncode == 2
    assert "'map9'" in done.stderr
    assert "map1" in done.stderr
    assert "Theta*" in done.stderr


@pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="planning thirty missions in plain Python is slow"
)
def test_certificates_agree_with_an_oracle_that_samples():
    done = run(PEERS.parent / "certificates.py", "12", "--processes", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "12 worlds from seed 0" in done.stdout
    row = next(line for line in done.stdout.splitlines() if line.startswith("| trajectory"))
    proven, refuted, _ = (int(cell) for cell in row.split("|")[2:5])
    assert proven >= 8
    assert refuted >= 8


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="flying in plain Python is slow")
def test_missions_in_gusts_are_a_table():
    if importlib.util.find_spec("rotorpy") is None:
        pytest.skip('rotorpy is not installed; pip install "skyverse[flight]"')
    done = run(PEERS.parent / "tracking.py", "map1", "--runs", "2")
    assert done.returncode == 0, done.stderr
    row = next(line for line in done.stdout.splitlines() if line.startswith("| map1"))
    mission, runs, speed, *_ = (cell.strip() for cell in row.strip("|").split("|"))
    assert (mission, runs, speed) == ("map1", "2", "100%")
