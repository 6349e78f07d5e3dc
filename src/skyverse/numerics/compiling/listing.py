"""The list of kernels that are known to be needed, with the types of their arguments, and what each of them calls."""

import importlib
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

FILE = Path(__file__).with_name("kernels.json")


class ListedKernel(NamedTuple):
    """A kernel for arguments of certain types.

    Attributes
    ----------
    name
        ``package.module:function``.
    types
        One text for each argument; see `signatures.text_of`.
    calls
        Positions in the list of the kernels that it calls; they come before it.
    ir_lines
        How long its code is before it is optimised, in lines of LLVM IR: about how long it takes to compile.
    """

    name: str
    types: tuple[str, ...]
    calls: tuple[int, ...]
    ir_lines: int

    def load(self) -> tuple[Any, tuple[Any, ...]]:
        """Return the kernel and the types of its arguments."""
        from skyverse.numerics.compiling.signatures import type_of

        module, _, name = self.name.partition(":")
        return getattr(importlib.import_module(module), name), tuple(map(type_of, self.types))


class Listing(NamedTuple):
    """Kernels, those that are called before those that call them; and which of them a workload needs."""

    kernels: tuple[ListedKernel, ...]
    workloads: dict[str, tuple[int, ...]]

    def needed_by(self, workloads: Iterable[str]) -> list[int]:
        """Return the positions of the kernels that workloads need, in the order of the list; unknown ones need none."""
        return sorted({i for workload in workloads for i in self.workloads.get(workload, ())})


@cache
def read_listing() -> Listing:
    """Return the list that was installed with the package."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    types = data["types"]
    kernels = (
        ListedKernel(row["kernel"], tuple(types[i] for i in row["types"]), tuple(row["calls"]), row["ir_lines"])
        for row in data["kernels"]
    )
    return Listing(tuple(kernels), {name: tuple(needed) for name, needed in data["workloads"].items()})
