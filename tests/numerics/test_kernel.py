"""How kernels are compiled."""

import ast
from functools import cache
from pathlib import Path

import numpy as np

import skyverse
from skyverse.numerics.arrays import doubled, order_of, put, put_all, put_box, towards

SOURCE = Path(skyverse.__file__).parent


@cache
def modules():
    """Every module of skyverse, parsed, by name."""
    names = {path: path.relative_to(SOURCE.parent).with_suffix("") for path in SOURCE.rglob("*.py")}
    return {
        ".".join(name.parts).removesuffix(".__init__"): ast.parse(path.read_text(encoding="utf-8"))
        for path, name in names.items()
    }


def decorated(module, *names):
    return {
        node.name
        for node in modules()[module].body
        if isinstance(node, ast.FunctionDef)
        and {d.id for d in node.decorator_list if isinstance(d, ast.Name)} & {*names}
    }


def called_from_python(module):
    """Yield the functions and modules of skyverse that a module names outside its kernels."""
    own = {name: (module, name) for name in decorated(module, "inner", "inner_query")}
    imported = {}
    for node in ast.walk(modules()[module]):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                own[alias.asname or alias.name] = (node.module, alias.name)
                imported[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    kernels = decorated(module, "kernel", "query", "inner", "inner_query")
    waiting = [node for node in modules()[module].body if getattr(node, "name", None) not in kernels]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Name) and node.id in own:
            yield own[node.id]
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in imported:
            yield imported[node.value.id], node.attr
        waiting += ast.iter_child_nodes(node)


def test_what_is_compiled_for_kernels_only_is_called_by_kernels_only():
    inner = {(module, name) for module in modules() for name in decorated(module, "inner", "inner_query")}
    assert len(inner) > 200
    assert not {(module, called) for module in modules() for called in inner & set(called_from_python(module))}


def test_rows_are_written_as_by_slices():
    rng = np.random.default_rng(1)
    rows, row, others = rng.random((5, 6)), rng.random(6), rng.random((2, 6))
    expected = rows.copy()
    expected[1] = row
    expected[2:4] = others
    expected[4, :3], expected[4, 3:] = row[:3], row[3:]
    put(rows, 1, row)
    put_all(rows, 2, others)
    put_box(rows, 4, row[:3], row[3:])
    np.testing.assert_array_equal(rows, expected)
    np.testing.assert_array_equal(towards(row[:3], row[3:], 0.25), row[:3] + 0.25 * (row[3:] - row[:3]))
    for numbers in (rows, np.arange(6).reshape(3, 2), row):
        longer = doubled(numbers)
        assert longer.shape == (2 * len(numbers), *numbers.shape[1:])
        assert longer.dtype == numbers.dtype
        np.testing.assert_array_equal(longer[: len(numbers)], numbers)
    np.testing.assert_array_equal(row[order_of(row)], np.sort(row))
