"""What every test shares: the way hypothesis runs, and `worlds` on the path."""

import os
import sys
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


def pytest_collection_modifyitems(items):
    if not os.environ.get("SKYVERSE_SLOW"):
        skip = pytest.mark.skip(reason="takes long; SKYVERSE_SLOW=1 runs it")
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(skip)
