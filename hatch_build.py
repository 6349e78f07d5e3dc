"""Puts compiled kernels into a wheel: those of the folder that SKYVERSE_KERNELS names; none where it is not set."""

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from packaging.tags import sys_tags


class CompiledKernels(BuildHookInterface):
    """Adds the folders of machine code, one for each level of processors, and names the platform in the wheel's tag."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Tell the builder about the files."""
        folder = os.environ.get("SKYVERSE_KERNELS")
        if version == "editable" or not folder:
            return
        for level in sorted(Path(folder).iterdir()):
            build_data["force_include"][str(level / "kernels")] = f"skyverse/numerics/compiling/shipped/{level.name}"
        build_data["pure_python"] = False
        build_data["tag"] = str(next(tag for tag in sys_tags() if "manylinux" not in tag.platform))
