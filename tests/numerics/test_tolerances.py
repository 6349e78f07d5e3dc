"""The planners' tolerances: in order of size, each with a reason."""

import ast
from pathlib import Path

from skyverse.numerics import tolerances

BODY = ast.parse(Path(tolerances.__file__).read_text(encoding="utf-8")).body[1:]


def test_tolerances_stand_in_order_of_size():
    values = [getattr(tolerances, node.targets[0].id) for node in BODY if isinstance(node, ast.Assign)]
    assert values == sorted(values)
    assert len(values) > 40


def test_each_tolerance_says_why():
    for value, reason in zip(BODY[::2], BODY[1::2], strict=True):
        assert isinstance(value, ast.Assign)
        assert isinstance(reason, ast.Expr)
        assert len(reason.value.value.split()) > 5
