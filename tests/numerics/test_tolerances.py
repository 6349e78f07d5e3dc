"""The planners' tolerances: in order of size, each with a reason."""

import ast
from pathlib import Path

from skyverse.numerics import tolerances

SOURCE = Path(tolerances.__file__).parents[1]
BODY = ast.parse(Path(tolerances.__file__).read_text(encoding="utf-8")).body[1:]

LEAST_OF_SETTINGS = ("gso.py", "waypoint_own.py", "waypoint_packages.py")
"""Files in which a small number is the least value of a setting."""


def test_tolerances_stand_in_order_of_size():
    values = [getattr(tolerances, node.targets[0].id) for node in BODY if isinstance(node, ast.Assign)]
    assert values == sorted(values)
    assert len(values) > 40


def test_each_tolerance_says_why():
    for value, reason in zip(BODY[::2], BODY[1::2], strict=True):
        assert isinstance(value, ast.Assign)
        assert isinstance(reason, ast.Expr)
        assert len(reason.value.value.split()) > 5


def test_no_small_number_stands_elsewhere_in_what_plans_and_exports():
    found = []
    for room in ("numerics", "space", "search", "planners", "trajectory", "deconfliction", "mission", "exports"):
        for file in (SOURCE / room).rglob("*.py"):
            if file.name == "tolerances.py":
                continue
            found += [
                f"{file.name}:{node.lineno}: {node.value}"
                for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
                if isinstance(node, ast.Constant) and isinstance(node.value, float) and 0.0 < node.value <= 1e-5
            ]
    assert [line for line in found if not line.startswith(LEAST_OF_SETTINGS)] == []
