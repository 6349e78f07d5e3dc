"""No test waits for a time, or gives up after one that a busy machine needs: all wait by `support/patience.py`."""

import ast
from pathlib import Path

TESTS = Path(__file__).parent
LIMITED = {"wait", "wait_for", "settimeout", "timeout"}
"""Calls whose last argument may be a number of seconds."""


def waits(source):
    """Yield the lines that sleep, or that give a number of seconds after which something is given up."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        given = [one.value for one in node.keywords if one.arg == "timeout"]
        given += node.args[-1:] if name in LIMITED else []
        if name == "sleep" or any(isinstance(one, ast.Constant) and type(one.value) in (int, float) for one in given):
            yield node.lineno


def test_no_test_waits_for_a_time():
    texts = {path: path.read_text("utf-8") for path in TESTS.rglob("*.py") if path.name != "patience.py"}
    some = {path: text for path, text in texts.items() if any(word in text for word in ("sleep", "wait", "timeout"))}
    assert {f"{path.relative_to(TESTS)}:{line}" for path, text in some.items() for line in waits(text)} == set()


def test_what_waits_for_a_time_is_found():
    found = "time.sleep(n)", "await asyncio.sleep(0.1)", "run(x, timeout=5)", "done.wait(3)", "asyncio.wait_for(x, 60)"
    let_pass = "run(x, timeout=PATIENCE_S)", "done.wait()", "'-'.join(x)", "given.get('a', 0)", "done.wait(PATIENCE_S)"
    assert [len(list(waits(f"async def f():\n    {one}"))) for one in (*found, *let_pass)] == [1] * 5 + [0] * 5
