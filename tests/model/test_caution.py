"""The words that mark what a pilot must not overlook stand in one place, and what begins with them stands out."""

import ast
import re
from pathlib import Path

import pytest

import skyverse
from skyverse.model.caution import Caution, stands_out

SOURCE = Path(skyverse.__file__).parent
ITS_OWN, SQL = SOURCE / "model/caution.py", {SOURCE / "lab/rows.py"}


@pytest.mark.parametrize(
    ("said", "stands"),
    [
        ("WARNING: homes that are not level", True),
        ("NOT", True),
        ("NOT from uav-3", True),
        ("ONLY on schedule", True),
        ("NOTES of the flight", False),
        ("corners NOT proven", False),
        ("Only on schedule", False),
        ("", False),
    ],
)
def test_what_begins_with_a_caution_stands_out(said, stands):
    assert stands_out(said) is stands


def strings(file):
    """The texts in a file that are no docstrings, those of f-strings in pieces."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    found = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in alone)
    return [node.value for node in found if isinstance(node.value, str)]


def test_no_file_writes_a_caution_of_its_own():
    word = re.compile(rf"\b({'|'.join(Caution)})\b")
    assert {file for file in SOURCE.rglob("*.py") if any(map(word.search, strings(file)))} == {ITS_OWN, *SQL}
