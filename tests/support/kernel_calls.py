"""Calls of every kernel, as planning makes them: kept with copies of their arguments."""

import copy
import importlib
import inspect
import pkgutil
import warnings
from collections import Counter, defaultdict

import numpy as np

import skyverse as sky
from plain_python import in_plain_python

CALLS_PER_KERNEL = 4


def all_kernels():
    """Return every kernel of the package by name, such as ``skyverse.cost:legs``."""
    found = {}
    for module in pkgutil.walk_packages(sky.__path__, "skyverse."):
        if not module.name.endswith("__main__"):
            for thing in vars(importlib.import_module(module.name)).values():
                function = getattr(thing, "py_func", None)
                if function is not None and function.__module__ == module.name:
                    found[name_of(thing)] = thing
    return found


def name_of(kernel):
    return f"{kernel.py_func.__module__}:{kernel.py_func.__qualname__}"


class Recorder:
    """Keeps copies of the arguments of each kernel's first calls, and of later ones that take the place of some.

    The n-th call is kept where n is a power of two, so that calls early and late in a search are among those kept. Of
    the calls that Python makes in a workload, those whose n is a power of four run as plain Python, which takes long,
    so that kernels see what they do.
    """

    def __init__(self):
        self.calls = defaultdict(list)
        self._seen = defaultdict(int)
        self._made = Counter()
        self._rng = np.random.default_rng(0)

    def begin(self):
        """Begin to count the calls that a workload makes."""
        self._made.clear()

    def chosen(self, kernel):
        """Return whether this call, made by Python, is to run as plain Python."""
        self._made[kernel] += 1
        return _is_power_of_two(self._made[kernel]) and self._made[kernel].bit_length() % 2 == 1

    def report(self, kernel, arguments):
        """Take note of a call that is about to be made."""
        name = name_of(kernel)
        self._seen[name] += 1
        seen, kept = self._seen[name], self.calls[name]
        if len(kept) < CALLS_PER_KERNEL:
            kept.append(_copied(kernel, arguments))
        elif _is_power_of_two(seen):
            kept[int(self._rng.integers(CALLS_PER_KERNEL))] = _copied(kernel, arguments)


def _is_power_of_two(count):
    return count & (count - 1) == 0


def _copied(kernel, arguments):
    """Copy arguments; plain Python lets an integer stand for a float, of which a kernel would be compiled anew."""
    kinds = [parameter.annotation for parameter in inspect.signature(kernel.py_func, eval_str=True).parameters.values()]
    cast = [kind if kind in (float, int, bool) else None for kind in kinds]
    return tuple(k(a) if k else a for k, a in zip(cast, copy.deepcopy(arguments), strict=False))


def record(workloads):
    """Return calls that are made while workloads run, partly in plain Python: lists of arguments by kernel's name."""
    recorder = Recorder()
    with in_plain_python(recorder.report, recorder.chosen), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for work in workloads:
            recorder.begin()
            work()
    return recorder.calls
