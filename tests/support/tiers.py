"""Two tiers of tests: the first is for everybody and takes minutes; ``--all`` runs every test, with every example.

``tests/second_tier.txt`` names the tests that only ``--all`` runs; ``python benchmarks/first_tier.py`` writes it anew.
In the first tier a property draws a fifth of its examples. A test that is named with ``::`` runs in any tier.
"""

import time
from pathlib import Path

import pytest
from hypothesis import settings

LIST = Path(__file__).parents[1] / "second_tier.txt"
SHARE_OF_EXAMPLES = 5


def second_tier():
    """Return the names of the tests that only ``--all`` runs."""
    return LIST.read_text(encoding="utf-8").splitlines()


def pytest_addoption(parser):
    parser.addoption("--all", action="store_true", help="run every test, and have properties draw all their examples")


def pytest_configure(config):
    config.began = time.monotonic()


def pytest_collection_modifyitems(config, items):
    if config.getoption("--all"):
        return
    second, named = set(second_tier()), tuple(word for word in config.args if "::" in word)
    left = [item for item in items if item.nodeid in second and not item.nodeid.startswith(named)]
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in set(left)]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Let a property draw fewer examples while it runs in the first tier."""
    function = getattr(item, "function", None)
    whole = getattr(function, "_hypothesis_internal_use_settings", None)
    if whole is None or item.config.getoption("--all"):
        return (yield)
    fewer = settings(whole, max_examples=-(-whole.max_examples // SHARE_OF_EXAMPLES))
    function._hypothesis_internal_use_settings = fewer
    try:
        return (yield)
    finally:
        function._hypothesis_internal_use_settings = whole


def pytest_terminal_summary(terminalreporter, config):
    if not config.getoption("--all"):
        minutes, seconds = divmod(round(time.monotonic() - config.began), 60)
        terminalreporter.write_line(
            f"\nThe first tier took {minutes} min {seconds} s; python3 run.py test --all runs {len(second_tier()):,} "
            f"more tests, and {SHARE_OF_EXAMPLES} times as many examples of each property."
        )
