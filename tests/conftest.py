"""What every test shares: the way hypothesis runs, and `worlds` on the path."""

import math
import os
import sys
import time
from datetime import date
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

sys.path.insert(0, str(Path(__file__).parent))

settings.register_profile(
    "skyverse",
    deadline=None,
    max_examples=int(os.environ.get("SKYVERSE_EXAMPLES", "20")),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
settings.load_profile("skyverse")


UNTIL = float(os.environ.get("SKYVERSE_UNTIL", "inf"))
"""Seconds since 1970 after which no test is begun: a slow machine then leaves tests out, and says how many."""


def pytest_collection_modifyitems(items):
    if not os.environ.get("SKYVERSE_SLOW"):
        skip = pytest.mark.skip(reason="takes long; SKYVERSE_SLOW=1 runs it")
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(skip)
    if math.isfinite(UNTIL):  # each day others come last
        files = [list(some) for _, some in groupby(items, key=lambda item: item.path)]
        first = 17 * date.today().toordinal() % len(files) if files else 0
        items[:] = [item for some in files[first:] + files[:first] for item in some]


def pytest_runtest_setup():
    if time.time() > UNTIL:
        pytest.skip("no time left: SKYVERSE_UNTIL")
