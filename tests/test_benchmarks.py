"""The benchmarks that others run still run."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from patience import PATIENCE_S

PEERS = Path(__file__).parents[1] / "benchmarks" / "peers"


def run(*words):
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, timeout=PATIENCE_S)


@pytest.mark.slow
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
    assert "+0." in rows["Taut"][-3]  # within a per cent of the shortest known
    for kind in ("png", "svg"):
        assert (tmp_path / f"peers.{kind}").stat().st_size > 10_000


def test_an_unknown_name_is_refused_with_the_list_of_names():
    done = run(PEERS, "--only", "map9")
    assert done.returncode == 2
    assert "'map9'" in done.stderr
    assert "map1" in done.stderr
    assert "Theta*" in done.stderr


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="flying in plain Python is slow")
def test_missions_in_gusts_are_a_table():
    if importlib.util.find_spec("rotorpy") is None:
        pytest.skip('rotorpy is not installed; pip install "skyverse[flight]"')
    done = run(PEERS.parent / "tracking.py", "map1", "--runs", "2")
    assert done.returncode == 0, done.stderr
    row = next(line for line in done.stdout.splitlines() if line.startswith("| map1"))
    mission, runs, speed, *_ = (cell.strip() for cell in row.strip("|").split("|"))
    assert (mission, runs, speed) == ("map1", "2", "100%")
