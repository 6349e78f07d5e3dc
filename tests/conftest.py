"""What every test shares: how hypothesis draws examples, which tests run, and for which reasons one may be skipped."""

import random
import signal
import sys
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

sys.path.insert(0, str(Path(__file__).parent / "support"))

from skips import cause_of

pytest_plugins = ["golden_messages", "tiers"]

MIN_EXAMPLES = 20

settings.register_profile(
    "fixed",
    deadline=None,
    derandomize=True,
    max_examples=MIN_EXAMPLES,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
settings.register_profile("explore", settings.get_profile("fixed"), derandomize=False, database=None, print_blob=True)


def pytest_configure(config):
    """Draw the same examples each time, unless a seed asks for others (`python3 run.py explore`).

    Hypothesis would also draw constants that stand in the modules imported so far, so that examples would change with
    the order of tests and with any edit of the source. Ctrl-C counts as in a terminal, also where the shell has made it
    of no effect, as it does for what runs beside it.
    """
    fixed = config.getoption("--hypothesis-seed") is None
    settings.load_profile("fixed" if fixed else "explore")
    if fixed:
        providers._get_local_constants = providers.Constants
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(config, items):
    seed = config.getoption("--hypothesis-seed")
    if seed is not None:  # each round of an exploration begins with other tests, since it may be cut short
        files = list(dict.fromkeys(item.path for item in items))
        random.Random(seed).shuffle(files)
        items.sort(key=lambda item: files.index(item.path))


def reason_of(report):
    """Return the reason for which a test or module was skipped."""
    return report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)


def fail_if_skipped_without_cause(report):
    """Let a skipped test or module fail if the reason is not on the list in `skips`."""
    if report.skipped and not hasattr(report, "wasxfail"):
        reason = reason_of(report)
        if cause_of(reason) is None:
            report.outcome = "failed"
            report.longrepr = f"skipped for a reason that is not on the list in tests/support/skips.py: {reason}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item):
    return fail_if_skipped_without_cause((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    return fail_if_skipped_without_cause((yield))


def pytest_terminal_summary(terminalreporter):
    """Say in one line how many tests and modules were skipped, and why; the next line says how long all took."""
    causes = Counter(cause_of(reason_of(report)) for report in terminalreporter.stats.get("skipped", ()))
    if causes:
        told = "; ".join(f"{count} as {cause}" for cause, count in causes.most_common())
        terminalreporter.write_line(f"\nSkipped: {told}.")
