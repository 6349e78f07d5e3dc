"""How many threads or processes may run side by side."""

import os


def cores() -> int:
    """Return how many threads or processes this process may run side by side."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
