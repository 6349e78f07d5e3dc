"""What is pinned for users is pinned for tests, and what is pinned for tests is pinned for lint and documentation."""

import re
from pathlib import Path

import pytest

LOCKS = Path(__file__).parents[1] / "requirements"


def pinned(kind):
    """Return what a lock pins, version and condition, with the hashes of each."""
    text = (LOCKS / f"{kind}.txt").read_text(encoding="utf-8")
    found = re.findall(r"^(\S+==[^\\\n]+?) \\\n((?: +--hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", text, re.MULTILINE)
    assert len(found) == len(re.findall(r"^\w", text, re.MULTILINE))
    return {name: frozenset(hashes.replace("\\", "").split()) for name, hashes in found}


@pytest.mark.parametrize(("fewer", "more"), [("run", "test"), ("test", "dev")])
def test_a_lock_holds_the_one_before_it_with_the_same_versions_and_hashes(fewer, more):
    assert pinned(fewer).items() < pinned(more).items()


def test_tests_need_no_tools_for_lint_or_documentation():
    names = {name.partition("==")[0] for name in pinned("test")}
    assert {"pytest", "hypothesis", "numba"} <= names
    assert not {"mypy", "ruff", "sphinx", "import-linter"} & names
