"""Golden missions: every planner, shape and map answers as it did before."""

import importlib.util
import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
specification = importlib.util.spec_from_file_location("golden", ROOT / "benchmarks" / "golden.py")
assert specification is not None
assert specification.loader is not None
golden = importlib.util.module_from_spec(specification)
specification.loader.exec_module(golden)

CASES = golden.cases()
KNOWN = json.loads(golden.FILE.read_text(encoding="utf-8"))
EXACT = golden.rounds_alike(KNOWN["numpy"], KNOWN["roundings"])


def test_every_case_has_a_known_answer():
    assert list(CASES) == list(KNOWN["answers"])
    assert all(len(answer) >= 3 for answer in KNOWN["answers"].values())


@pytest.mark.parametrize("name", CASES)
def test_an_answer_is_the_known_one(name):
    found, known = golden.computed(name), KNOWN["answers"][name]
    assert golden.same(found, known, to_the_last_bit=EXACT), (found, known)


def test_all_bits_are_compared_here():
    if not EXACT:
        pytest.skip("this processor, C library or numpy rounds otherwise: only costs and makespans are compared")


def test_all_bits_are_compared_with_a_version_of_numpy_that_is_installed_for_tests():
    pinned = re.findall(
        r"^numpy==(\S+)", (ROOT / "requirements" / "test.txt").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert KNOWN["numpy"] in pinned


@pytest.mark.parametrize(("kind", "exact"), [("x86_64", True), ("AMD64", True), ("aarch64", False), ("arm64", False)])
def test_all_bits_are_compared_on_every_x86_64_processor(kind, exact, monkeypatch):
    monkeypatch.setattr(golden.platform, "machine", lambda: kind)
    monkeypatch.setattr(golden.np, "__version__", "2.4.6")
    assert golden.rounds_alike("2.4.6", golden.roundings()) is exact
    assert not golden.rounds_alike("2.4.7", golden.roundings())
    assert not golden.rounds_alike("2.4.6", "other roundings")


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("name", ["cost", "bound", "points", "makespan", "violations", "numbers", "sum"])
def test_an_answer_that_moved_is_noticed(name, exact):
    known = next(answer for answer in KNOWN["answers"].values() if name in answer)
    assert golden.same(dict(known), known, to_the_last_bit=exact)
    assert not golden.same(known | {name: 1.00001 * known[name] + 1e-5}, known, to_the_last_bit=exact)
    assert not golden.same({key: value for key, value in known.items() if key != name}, known, to_the_last_bit=exact)
    assert not golden.same(known, {}, to_the_last_bit=exact)


def test_one_bit_that_moved_is_noticed_where_all_are_compared():
    known = next(iter(KNOWN["answers"].values()))
    assert not golden.same(known | {"digest": "0"}, known, to_the_last_bit=True)
    assert golden.same(known | {"digest": "0"}, known, to_the_last_bit=False)
