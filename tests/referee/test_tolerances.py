"""The referee's tolerances stand in one file: in order of size, each with a reason, and nowhere else."""

import ast
from pathlib import Path

from skyverse.referee import tolerances

FILE = Path(tolerances.__file__)
BODY = [node for node in ast.parse(FILE.read_text(encoding="utf-8")).body[1:] if not isinstance(node, ast.Import)]


def test_tolerances_stand_in_order_of_size():
    values = [getattr(tolerances, node.targets[0].id) for node in BODY if isinstance(node, ast.Assign)]
    assert values == sorted(values)


def test_each_tolerance_says_why():
    for value, reason in zip(BODY[::2], BODY[1::2], strict=True):
        assert isinstance(value, ast.Assign)
        assert len(reason.value.value.split()) > 5


def test_no_other_file_of_the_referee_holds_a_small_number():
    for file in FILE.parent.glob("*.py"):
        numbers = [
            node.value
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
            if isinstance(node, ast.Constant) and isinstance(node.value, float)
        ]
        assert file == FILE or not [number for number in numbers if 0 < abs(number) < 0.1], file.name
